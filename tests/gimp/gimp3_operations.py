# SPDX-License-Identifier: MIT
"""All operations in GIMP 3 beside their verbs of `ntp`: not one texel differs.  `./dev gimp3`.

Each row of support/operations.py, in 8 and 16 bit, with and without alpha and gAMA, merged and as a
layer effect.
"""

import os

import numpy as np
import pytest

from support import operations, pngs
from support.gimps import Gimp3
from support.operations import CURVES, KINDS, name_of
from support.plugin_cases import different

CHROOT = os.environ.get("NTP_GIMP3")
pytestmark = pytest.mark.skipif(not CHROOT, reason="NTP_GIMP3 names no chroot; use ./dev gimp3")


def hows(operation):
    """GIMP 3.0 takes no operation with a pad "aux" as an effect; 3.2 does, and shows no detail."""
    return ["merge"] if operation == operations.BLEND else ["merge", "append"]


@pytest.fixture(scope="module")
def gimp():
    made, jobs = Gimp3(CHROOT, "table"), {}
    for name, pixels, chunks in operations.pictures():
        pngs.write_png(made.work / f"{name}.png", pixels, chunks=chunks)
        detail = f"{name}-detail.png"
        pngs.write_png(made.work / detail, operations.detail_of(pixels), chunks=chunks)
        things = [
            [f"{name}-{row}-{how}", how, operation,
             {**settings,
              **({"aux": True} if operation == operations.BLEND else {}),
              **({"path": f"{made.inside}/{detail}"}
                 if operation == operations.BLEND_FILE else {})}]
            for row, seen, operation, settings, _ in operations.ROWS
            if name.startswith(seen.__name__) for how in hows(operation)
        ]  # fmt: skip
        steps = [["hide_other", detail], ["each", things]]
        jobs[name] = {"file": f"{name}.png", "steps": steps}
    made.results, made.complaints = made.run(jobs)
    return made


@pytest.fixture
def ntp(program, tmp_path):
    return operations.caller(program, tmp_path)


@pytest.mark.parametrize(
    ("picture", "operation", "make", "row"),
    [(row[1], row[2], row[4], row[0]) for row in operations.ROWS],
    ids=operations.NAMES,
)
def test_same_as_ntp(gimp, ntp, picture, operation, make, row):
    wrong = {}
    for channels, depth in KINDS:
        pixels = picture(channels, depth)
        expected = make(ntp, pixels, operations.detail_of(pixels))[..., :channels]
        assert different(expected, pixels) > 0 and expected[..., :3].std() > 0
        for curve in CURVES:
            name = name_of(picture, channels, depth, curve)
            note = gimp.results[name]
            assert note["error"] is None, note["error"]
            for how in hows(operation):
                file = f"{name}-{row}-{how}"
                height, width, size = note["each"][file]
                data = np.fromfile(gimp.work / file, expected.dtype).reshape(height, width, -1)
                assert size == data.shape[2] * data.itemsize
                wrong[file] = different(data[..., :channels], expected)
    assert len(wrong) == len(KINDS) * len(CURVES) * len(hows(operation))
    assert not any(wrong.values()), wrong


def test_no_complaints(gimp):
    assert gimp.complaints == []
