# SPDX-License-Identifier: MIT
"""ntp to-depth: what is written, options and refusals."""

import json

import numpy as np
import pytest

from support import cliff_scenes as scenes
from support.libntp_ffi import ROOT
from support.pngs import read_png, write_png

SIZE = 48
FILES = ROOT / "test_files"


def read_pfm(path):
    _, size, _, data = path.read_bytes().split(b"\n", 3)
    w, h = map(int, size.split())
    return np.frombuffer(data, "<f4").reshape(h, w)[::-1]


@pytest.fixture
def scene(tmp_path):
    """n.png, 16 bit, of balls before a plane, and mask.png, which leaves a margin out."""
    made = scenes.spheres(SIZE, 60, False)
    made.pieces[:3] = 0
    write_png(tmp_path / "n.png", np.floor((made.normals + 1) / 2 * 65535 + 0.5).astype(np.uint16))
    write_png(tmp_path / "mask.png", (made.mask * 255).astype(np.uint8))
    return made


def camera_option(scene):
    return ("--camera", ",".join(map(repr, scene.camera)))


def report(run, *args):
    done = run("to-depth", *args, "--format", "json")
    assert done.returncode == 0, done.stderr
    (file,) = json.loads(done.stdout)["files"]
    return file


def test_floats_levels_and_confidence(run, tmp_path, scene):
    how = (*camera_option(scene), "--mask", "mask.png")
    file = report(run, "n.png", "-o", "d.pfm", *how, "--confidence", "c.pfm")
    depth, sure = read_pfm(tmp_path / "d.pfm"), read_pfm(tmp_path / "c.pfm")
    assert (np.isnan(depth) == ~scene.mask).all()
    assert ((sure == 0) == ~scene.mask).all() and sure.max() <= 1
    assert scenes.error(depth, scene) < 0.02 * scene.camera[0]
    assert file["holes"] == 3 * SIZE and file["islands"] == 1 and file["depth"] == "float"
    file = report(run, "n.png", "-o", "d.png", *how, "--confidence", "c.png")
    levels, chunks = read_png(tmp_path / "d.png")
    levels = levels.reshape(SIZE, SIZE)
    assert levels.dtype == np.uint16 and ((levels == 0) == ~scene.mask).all()
    again = file["offset"] + file["scale"] * (levels.astype(float) - 1) / 65534
    assert np.abs(again - depth)[scene.mask].max() < file["scale"] / 65000
    texts = dict(body.split(b"\0", 1) for body in chunks[b"tEXt"])
    assert float(texts[b"Depth scale"]) == file["scale"]
    assert float(texts[b"Depth offset"]) == file["offset"]
    rounded = read_png(tmp_path / "c.png")[0].reshape(SIZE, SIZE)
    assert np.abs(rounded / 65535 - sure).max() < 1e-5


def test_green_down_and_least_squares(run, tmp_path, scene):
    levels = read_png(tmp_path / "n.png")[0].copy()
    levels[..., 1] = 65535 - levels[..., 1]
    write_png(tmp_path / "down.png", levels)
    run("to-depth", "n.png", "-o", "up.pfm")
    run("to-depth", "down.png", "-o", "down.pfm", "--y", "directx")
    assert (read_pfm(tmp_path / "up.pfm") == read_pfm(tmp_path / "down.pfm")).all()
    assert report(run, "n.png", "-o", "one.pfm", "--rounds", 1)["rounds"] == 1


def test_green_is_used_where_it_is_sure(run, tmp_path):
    """Up is the convention where nothing says down; a texture that may be down is asked about."""
    for name, y in (("standard.png", "up"), ("standard_down.png", "down")):
        file = report(run, str(FILES / name), "-o", "d.pfm")
        assert (file["y"], file["y_by"]) == (y, "texels")
    made = scenes.cloth(64, 0)
    for name, sign, y in (("up.png", 1, "up"), ("down.png", -1, None)):
        turned = made.normals * [1, sign, 1]
        write_png(tmp_path / name, np.floor((turned + 1) / 2 * 255 + 0.5).astype(np.uint8))
        done = run("to-depth", name, "-o", "d.png")
        if y is None:
            assert done.returncode == 1 and "--y up (OpenGL) or --y down" in done.stderr
            assert run("to-depth", name, "-o", "d.png", "--y", "down").returncode == 0
        else:
            assert "green taken as pointing up, as is usual" in done.stdout


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("gamma.png", "sRGB"),
        ("red_blue_swapped.png", "exchanged"),
        ("z_flipped.png", "inverted"),
        ("dxt5nm.png", "DXT5nm"),
        ("photograph.png", "something else"),
        ("height_gray8.png", "a height map"),
    ],
)
def test_what_is_surely_no_picture_of_normals_is_refused(run, tmp_path, name, why):
    done = run("to-depth", str(FILES / name), "-o", "d.png")
    assert done.returncode == 1 and why in done.stderr and not (tmp_path / "d.png").exists()
    if name == "gamma.png":
        for insist in (("--force",), ("--type", "standard")):
            assert run("to-depth", str(FILES / name), "-o", "d.png", *insist).returncode == 0


def test_how_z_is_stored_is_found_out(run):
    standard = report(run, str(FILES / "standard.png"), "-o", "d.png")
    zzero = report(run, str(FILES / "zzero.png"), "-o", "d.png")
    assert (standard["type"], zzero["type"]) == ("standard", "zzero")
    assert abs(zzero["scale"] / standard["scale"] - 1) < 0.01


@pytest.mark.parametrize(
    "wrong",
    [
        ("--camera", "1,2,3"),
        ("--camera", "0,1,2,3"),
        ("--camera", "1,2,3,nan"),
        ("--k", "0"),
        ("--rounds", "0"),
        ("--depth", "float"),
        ("--confidence", "c.tga"),
    ],
)
def test_wrong_options(run, tmp_path, scene, wrong):
    done = run("to-depth", "n.png", "-o", "d.png", *wrong)
    assert done.returncode == 2 and wrong[0].strip("-") in done.stderr.lower() + "tga confidence"
    assert not (tmp_path / "d.png").exists()


def test_one_confidence_for_one_input(run, tmp_path, scene):
    write_png(tmp_path / "m.png", read_png(tmp_path / "n.png")[0])
    done = run("to-depth", "n.png", "m.png", "-o", "out", "--confidence", "c.png")
    assert done.returncode == 2 and "several inputs" in done.stderr
    assert run("to-depth", "n.png", "-o", "d.png", "--confidence", "n.png").returncode == 2
    done = run("to-depth", "n.png", "-o", "d.png", "--mask", "none.png")
    assert done.returncode == 3 and not (tmp_path / "d.png").exists()
