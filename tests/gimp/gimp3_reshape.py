# SPDX-License-Identifier: MIT
"""Resize Normals and Blend Normals with a File in GIMP 3: as `ntp`.  `./dev gimp3` runs it.

GIMP is started once, for all that is to be done.
"""

import os
import subprocess

import numpy as np
import pytest

from support import pngs
from support.gimps import Gimp3
from support.plugin_cases import GAMMA, HEIGHT, WIDTH, different, rough_normals

CHROOT = os.environ.get("NTP_GIMP3")
pytestmark = pytest.mark.skipif(not CHROOT, reason="NTP_GIMP3 names no chroot; use ./dev gimp3")

# Each depth with and without alpha, and with and without gAMA.
INPUTS = {
    "rough8-3": (rough_normals(3, 8), ()),
    "rough8-4-gAMA": (rough_normals(4, 8), (GAMMA,)),
    "rough16-3-gAMA": (rough_normals(3, 16), (GAMMA,)),
    "rough16-4": (rough_normals(4, 16), ()),
}
RESIZED = {
    "half": ({}, ["--size", "50%"]),
    "told": (
        {"width": 200, "height": 61, "filter": "lanczos3", "border-y": "mirror", "scope": "layer"},
        ["--size", "200x61", "--filter", "lanczos3", "--border-y", "mirror"],
    ),
}
RESIZE = "plug-in-ntp-resize-normals"
HOWS = ("merge", "append")
PART = (20, 30, 50, 40)  # x, y, width, height of a selection


def detail_for(file):
    """Other normals whose alpha is of every kind."""
    pixels = np.ascontiguousarray(rough_normals(4, 16 if "16" in file else 8)[::-1, ::-1])
    ramp = np.linspace(0, np.iinfo(pixels.dtype).max, WIDTH)
    pixels[..., 3] = ramp.astype(pixels.dtype)
    return pixels


def jobs():
    todo = {}

    def job(name, file, *steps):
        todo[name] = {"file": f"{file}.png", "steps": [*steps, ["save", f"{name}.png"]]}

    for file in INPUTS:
        for name, (settings, _) in RESIZED.items():
            todo[f"{file}-{name}"] = {
                "file": f"{file}.png",
                "steps": [
                    ["select", *PART],
                    ["offsets", 7, -3],
                    ["call", RESIZE, settings],
                    ["note_place"],
                    ["dump", f"{file}-{name}"],
                ],
            }
    file = "rough8-3"
    detail = ["ntp:blend-normals-file", {"path": "/home/reshape/detail8-3.png"}]
    job("detail-xcf", file, ["append", *detail], ["reopen", "detail.xcf", "path"])
    for how in HOWS:
        job(f"detail-part-{how}", file, ["select", *PART], [how, *detail])
    todo["effect"] = {
        "file": f"{file}.png",
        "steps": [
            ["append", "ntp:transform-normals", {"strength": 1.7}],
            ["call", RESIZE, {}],
            ["note_filters"],
            ["dump", "effect"],
        ],
    }
    todo["group"] = {
        "file": f"{file}.png",
        "steps": [["group"], ["call", RESIZE, {}], ["note_place"]],
    }
    return todo


@pytest.fixture(scope="module")
def gimp():
    made = Gimp3(CHROOT, "reshape")
    for name, (pixels, chunks) in INPUTS.items():
        pngs.write_png(made.work / f"{name}.png", pixels, chunks=chunks)
    pngs.write_png(made.work / "detail8-3.png", detail_for("rough8-3"))
    made.results, made.complaints = made.run(jobs())
    return made


@pytest.fixture
def done(gimp):
    def look(job):
        assert gimp.results[job]["error"] is None, gimp.results[job]["error"]
        return pngs.read_png(gimp.work / f"{job}.png")[0]

    return look


@pytest.fixture
def raw(gimp):
    def look(job, dtype):
        note = gimp.results[job]
        assert note["error"] is None, note["error"]
        assert "refused" not in note, note
        height, width, size = note["shape"]
        data = np.fromfile(gimp.work / job, dtype)
        return data.reshape(height, width, size // np.dtype(dtype).itemsize)

    return look


@pytest.fixture
def ntp(program, tmp_path):
    """ntp(pixels, verb, option...) -> the pixels that the program makes; "detail" is a path."""

    def run(pixels, verb, *words, detail=None):
        source, made, other = (tmp_path / f"{n}.png" for n in ("in", "out", "detail"))
        pngs.write_png(source, pixels)
        inputs = [source]
        if detail is not None:
            pngs.write_png(other, detail)
            inputs.append(other)
        subprocess.run([program, verb, "-q", *words, *inputs, "-o", made], check=True)
        return pngs.read_png(made)[0]

    return run


TOLD = ["--type", "standard"]


def test_blend_as_effect_is_saved(gimp, done, ntp):
    base, told = INPUTS["rough8-3"][0], [*TOLD, "--y", "up", "--detail-y", "up"]
    expected = ntp(base, "blend", *told, detail=detail_for("rough8-3"))
    assert different(done("detail-xcf"), expected) == 0
    assert gimp.results["detail-xcf"]["filters"] == ["ntp:blend-normals-file"]
    x, y, width, height = PART
    inside = slice(y, y + height), slice(x, x + width)
    part = base.copy()
    part[inside] = expected[inside]
    for how in HOWS:
        assert different(done(f"detail-part-{how}"), part) == 0, how


@pytest.mark.parametrize("file", INPUTS)
def test_resize(gimp, raw, ntp, file):
    pixels = INPUTS[file][0]
    for name, (settings, options) in RESIZED.items():
        expected = ntp(pixels, "resize", *options)
        assert different(raw(f"{file}-{name}", pixels.dtype), expected) == 0
        x, y, width, height = gimp.results[f"{file}-{name}"]["place"]
        if "scope" in settings:  # the image keeps its size, the layer its place
            assert (x, y, width, height) == (7, -3, WIDTH, HEIGHT)
        else:
            assert (width, height) == (76, 67)


def test_resize_takes_effects(gimp, raw, ntp):
    strong = ntp(INPUTS["rough8-3"][0], "transform", *TOLD, "--strength", "1.7")
    assert different(raw("effect", np.uint8), ntp(strong, "resize", "--size", "50%")) == 0
    assert gimp.results["effect"]["filters"] == 0


def test_resize_refuses_groups(gimp):
    assert "group" in gimp.results["group"]["refused"]
    assert gimp.results["group"]["place"][2:] == [WIDTH, HEIGHT]


def test_no_complaints(gimp):
    assert gimp.complaints == []
