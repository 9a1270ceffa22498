# SPDX-License-Identifier: MIT
"""Cases of maps.py given to the classification, and its answers as text."""

import os

from . import libntp_ffi as ntp
from . import maps
from .sanitized import SANITIZED

CI_SEED = 20261121


def draw_seed():
    """NTP_SEED; with CI set always the same one; else a new one.  Printed, so that it can be repeated.

    A sanitizer sees few of the draws, too few for bounds on shares of any seed.
    """
    same = os.environ.get("CI") or SANITIZED
    drawn = CI_SEED if same else int.from_bytes(os.urandom(4), "little")
    value = int(os.environ.get("NTP_SEED") or drawn)
    print(f"\nNTP_SEED={value}")
    return value


def tally_of(case, encoding=None):
    return ntp.tally_of(case.pixels, case.encoding if encoding is None else encoding)


def reason_text(reason):
    room = ntp.ffi.new("char[400]")
    length = ntp.lib.ntp_reason_text(room, 400, reason)
    text = ntp.ffi.string(room).decode()
    assert len(text) == length
    return text


def classify(case):
    return ntp.classify(case.pixels, case.encoding)


def describe(index, case, result):
    reasons = "; ".join(reason_text(result.reasons + i) for i in range(result.reason_count))
    return (
        f"{index} {case.name} {case.details}: {maps.CLASSES[result.type]} "
        f"{result.confidence:.2f} accidents {result.accidents}: {reasons}"
    )
