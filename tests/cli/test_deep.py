# SPDX-License-Identifier: MIT
"""ntp check --deep: the kernel, the seams, the fit of a surface, and what a plain check leaves."""

import json

import jsonschema
import numpy as np
import pytest
import textures
from spawn import spawn

import libntp_ffi
import maps
import oracle_height as model
import test_to_height as reconstruction
from pngs import write_png

SCHEMA = json.loads((libntp_ffi.ROOT / "docs/schema/check-1.json").read_text())
ADDED = ("kernel", "tiles", "residual_levels")


def only(run, *args, code=0):
    done = run("check", "--format", "json", *args)
    assert done.returncode == code, done.stderr
    report = json.loads(done.stdout)
    jsonschema.validate(report, SCHEMA)
    (file,) = report["files"]
    return file


def ids(file):
    return {f["id"] for f in file["findings"]}


@pytest.mark.parametrize("kernel", ["central", "forward", "sobel3", "scharr3"])
def test_kernel_tiling_and_fit(run, tmp_path, kernel):
    n = reconstruction.from_height(reconstruction.fractal(256), kernel)
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png", "--deep")
    assert file["kernel"] == kernel and file["tiles"] == {"x": "yes", "y": "yes"}
    assert 0.15 < file["residual_levels"] < 0.3
    assert not ids(file) & {"NT023", "NT052"}
    text = run("check", "a_n.png", "--deep").stdout
    assert f"kernel {kernel}\n" in text and "across: yes, down: yes\n" in text
    assert "fits a surface" not in run("check", "a_n.png", "--deep", "-q").stdout


@pytest.mark.parametrize("border", ["clamp", "extrapolate", "mirror"])
def test_fit_does_not_depend_on_the_border(run, tmp_path, border):
    number = model.BORDER_NAMES.index(border)
    h = reconstruction.fractal(256)[20:180, 30:200].copy()
    write_png(tmp_path / "a_n.png", reconstruction.from_height(h, "central", number, number))
    file = only(run, "a_n.png", "--deep")
    assert file["residual_levels"] < 0.4
    assert file["tiles"]["x"] != "yes" and file["tiles"]["y"] != "yes"


def test_plain_check_says_none_of_it(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.standard())
    file = only(run, "a_n.png")
    assert all(file[key] is None for key in ADDED)
    assert "tiles" not in run("check", "-v", "a_n.png").stdout


def test_seam(run, tmp_path):
    n = reconstruction.from_height(reconstruction.fractal(256))[:, 30:170]
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png", "--deep")
    assert file["tiles"] == {"x": "no", "y": "yes"} and "NT052" in ids(file)
    assert "left and right edges" in run("check", "-v", "--deep", "a_n.png").stdout


def test_no_surface(run, tmp_path):
    """x and y of two surfaces: each texel is a unit vector, and nothing has these slopes."""
    one, other = (reconstruction.fractal(128, seed) for seed in (1, 2))
    p = np.roll(one, -1, 1) - one
    q = np.roll(other, -1, 0) - other
    n = maps.to_type(maps.encode(reconstruction.vectors_of(p, q)))
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png", "--deep")
    assert file["kernel"] is None and file["residual_levels"] > 8 and "NT023" in ids(file)
    assert all(f["level"] == "info" for f in file["findings"] if f["id"] == "NT023")


def test_green_down(run, tmp_path):
    n = reconstruction.from_height(reconstruction.fractal(128))
    n[..., 1] = 255 - n[..., 1]
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png", "--deep")
    assert file["y"] == "down" and file["kernel"] == "central" and file["residual_levels"] < 0.4
    wrong = only(run, "a_n.png", "--deep", "--y", "up")  # as asked: it does not fit
    assert wrong["kernel"] is None and wrong["residual_levels"] > 5


def test_holes_leave_the_fit_open(run, tmp_path):
    n = reconstruction.from_height(reconstruction.fractal(128))
    n[40:60, 50:90] = 0
    write_png(tmp_path / "a_n.png", n)
    file = only(run, "a_n.png", "--deep")
    assert file["residual_levels"] is None and file["kernel"] == "central"


def test_what_has_no_slopes(run, tmp_path):
    rng = np.random.default_rng(3)
    flat = np.full((64, 64, 3), (128, 128, 255), np.uint8)
    cases = {
        "h.png": (textures.heights(), 1),
        "p.png": (textures.photograph(), 1),
        "f_n.png": (flat, 0),
        "t_n.png": (textures.standard(64, 64)[:1, :1], 0),
        "noise_n.png": (rng.integers(0, 256, (40, 40, 3), dtype=np.uint8), None),
    }
    for name, (pixels, code) in cases.items():
        write_png(tmp_path / name, pixels)
        done = run("check", "--deep", "--format", "json", name)
        assert code is None or done.returncode == code, name
        (file,) = json.loads(done.stdout)["files"]
        jsonschema.validate(json.loads(done.stdout), SCHEMA)
        assert file["kernel"] is None, name


def test_standard_input(program, tmp_path):
    """It can be read only once, and is held."""
    n = reconstruction.from_height(reconstruction.fractal(64))
    write_png(tmp_path / "a_n.png", n)
    with open(tmp_path / "a_n.png", "rb") as file:
        done = spawn([program, "check", "--deep", "-"], stdin=file, text=True)
    assert done.returncode == 0 and "kernel central" in done.stdout
