# SPDX-License-Identifier: MIT
"""All operations in GIMP 3 beside their verbs of `ntp`: not one texel differs.  `./dev gimp3`.

Each row of support/operations.py, in 8 and 16 bit, with and without alpha and gAMA, merged and as a
layer effect.
"""

import os
import subprocess

import numpy as np
import pytest

from support import operations, pngs
from support.gimps import Gimp3
from support.plugin_cases import GAMMA, different

CHROOT = os.environ.get("NTP_GIMP3")
pytestmark = pytest.mark.skipif(not CHROOT, reason="NTP_GIMP3 names no chroot; use ./dev gimp3")

# Channels and bits.
KINDS = [(channels, depth) for channels in (3, 4) for depth in (8, 16)]
CURVES = {"plain": (), "gAMA": (GAMMA,)}
MAKERS = [operations.heights, operations.cut, operations.normals]


def name_of(picture, channels, depth, curve):
    return f"{picture.__name__}{channels}-{depth}-{curve}"


def hows(operation):
    """GIMP 3.0 takes no operation with a pad "aux" as an effect."""
    return ["merge"] if operation == operations.BLEND else ["merge", "append"]


@pytest.fixture(scope="module")
def gimp():
    made, jobs = Gimp3(CHROOT, "table"), {}
    for picture in MAKERS:
        for channels, depth in KINDS:
            for curve, chunks in CURVES.items():
                name, pixels = name_of(picture, channels, depth, curve), picture(channels, depth)
                pngs.write_png(made.work / f"{name}.png", pixels, chunks=chunks)
                detail = f"{name}-detail.png"
                pngs.write_png(made.work / detail, operations.detail_of(pixels), chunks=chunks)
                things = [
                    [f"{name}-{row}-{how}", how, operation,
                     {**settings,
                      **({"aux": True} if operation == operations.BLEND else {}),
                      **({"path": f"{made.inside}/{detail}"}
                         if operation == operations.BLEND_FILE else {})}]
                    for row, seen, operation, settings, _ in operations.ROWS if seen is picture
                    for how in hows(operation)
                ]  # fmt: skip
                steps = [["hide_other", detail], ["each", things]]
                jobs[name] = {"file": f"{name}.png", "steps": steps}
    made.results, made.complaints = made.run(jobs)
    return made


@pytest.fixture
def ntp(program, tmp_path):
    """ntp(pixels, verb, option...) -> the pixels that the program makes."""

    def call(pixels, verb, *words, detail=None, side=None):
        source, made, other = (tmp_path / f"{n}.png" for n in ("in", "out", "other"))
        pngs.write_png(source, pixels)
        inputs = [source] if detail is None else [source, other]
        if detail is not None:
            pngs.write_png(other, detail)
        if side is not None:
            pngs.write_png(other, side[1])
            words = *words, side[0], other
        subprocess.run([program, verb, "-q", *words, *inputs, "-o", made], check=True)
        return pngs.read_png(made)[0]

    return call


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
