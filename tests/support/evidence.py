# SPDX-License-Identifier: MIT
"""The classifier's evidence, which is private to libntp: read from a tally by ntp_evidence.so."""

import re

from . import libntp_ffi as ntp

_SOURCES = ntp.ROOT / "libntp" / "src"
_BUILT = ntp.find_built("tests/libntp_evidence.so")


def _declarations():
    structs = (_SOURCES / "measure" / "evidence.h").read_text(encoding="utf-8")
    bins = (_SOURCES / "texel" / "judged.h").read_text(encoding="utf-8")
    number = re.search(r"NTP__STEEPNESS_BINS = (\d+)", bins)[1]
    found = re.findall(r"^typedef struct .*?^\} \w+;$", structs, re.DOTALL | re.MULTILINE)
    return "\n".join(found).replace("NTP__STEEPNESS_BINS", number)


ntp.ffi.cdef(_declarations())
ntp.ffi.cdef("ntp_status ntp_test_evidence(ntp__evidence *evidence, ntp_tally *tally);")
_lib = ntp.ffi.dlopen(str(_BUILT)) if _BUILT else None


def evidence(tally):
    """The evidence of a Tally: the fields of ntp__evidence as a dict."""
    found = ntp.ffi.new("ntp__evidence *")
    ntp.check(_lib.ntp_test_evidence(found, tally.pointer))
    return ntp.fields(found)
