# SPDX-License-Identifier: MIT
"""What a name promises, and what `ntp check` says of a blue that holds nothing."""

import json

import numpy as np
import pytest

from support import textures
from support.pngs import write_png

NOT_BY_NAME = ["Normals_mask", "NormalTangentTest_BaseColor", "ui-normal", "button_normal_hd"]
BY_NAME = ["brick_n", "BrickNormalGL", "color_normal", "mask-normal_2k", "normal", "build_normal"]


def files_of(run, *arguments):
    done = run("check", "--format", "json", "--fail-on", "never", *arguments)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["files"]


def levels_of(file):
    return {f["id"]: f["level"] for f in file["findings"]}


@pytest.fixture
def no_blue():
    pixels = textures.standard(64, 64).copy()
    pixels[..., 2] = 255
    return pixels


@pytest.mark.parametrize("name", NOT_BY_NAME + BY_NAME)
def test_the_last_word_decides(run, tmp_path, name):
    """A picture counts in a directory only where its name is that of a normals texture."""
    picture = np.random.default_rng(1).integers(0, 90, (32, 32, 3)).astype(np.uint8)
    write_png(tmp_path / f"{name}.png", picture)
    [file] = files_of(run, "-r", ".", "--allow-empty")
    assert file["counts"] == (name in BY_NAME)


def test_only_content_makes_notes(run, tmp_path, no_blue):
    write_png(tmp_path / "wall.png", no_blue)
    write_png(tmp_path / "wall_n.png", no_blue)
    by_content, by_name = files_of(run, "-r", ".")
    assert set(levels_of(by_content).values()) == {"info"}
    assert levels_of(by_name)["NT004"] == "warning"
    [named] = files_of(run, "wall.png")
    assert levels_of(named)["NT004"] == "warning"


@pytest.mark.parametrize("blue", [0, 255])
def test_a_blue_that_holds_nothing_is_a_warning_with_a_way_out(run, tmp_path, no_blue, blue):
    no_blue[..., 2] = blue
    write_png(tmp_path / "wall_n.png", no_blue)
    [file] = files_of(run, "wall_n.png")
    [message] = [f["message"] for f in file["findings"] if f["id"] == "NT004"]
    assert "--type xy --to standard" in message
    done = run("convert", "--type", "xy", "--to", "standard", "wall_n.png", "-o", "out_n.png")
    assert done.returncode == 0, done.stderr
    [out] = files_of(run, "out_n.png")
    assert out["type"] == "standard" and set(levels_of(out).values()) <= {"info"}


def test_what_is_promised_is_a_note(run, tmp_path, no_blue):
    for name in ("wall_xy_n.png", "wall_bc5_n.png", "wall_rg_normal.png"):
        write_png(tmp_path / name, no_blue)
        assert set(levels_of(files_of(run, name)[0]).values()) == {"info"}
    [file] = files_of(run, "wall_xy_n.png", "--type", "xy")
    assert set(levels_of(file).values()) <= {"info"}


def test_zzero_is_a_warning_unless_promised(run, tmp_path):
    p, q = textures.slopes(steepness=1.0)
    n = np.stack([-p, -q, np.ones_like(p)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    pixels = np.floor((n / 2 + 0.5) * 255 + 0.5)
    pixels[..., 2] = np.floor(n[..., 2] * 255 + 0.5)
    for name, level in (("wall_n.png", "warning"), ("wall_zzero_n.png", "info")):
        write_png(tmp_path / name, pixels.astype(np.uint8))
        [file] = files_of(run, name)
        assert file["type"] == "zzero" and levels_of(file)["NT005"] == level


def noisy_blue(alpha=None):
    """Red and green of bumps; blue is noise around 205, as in scanned materials after JPEG."""
    rng = np.random.default_rng(3)
    pixels = textures.standard(128, 128).copy()
    pixels[..., 2] = np.clip(rng.normal(205, 18, (128, 128)), 0, 255)
    return pixels if alpha is None else np.dstack([pixels, alpha]).astype(np.uint8)


MAP = np.random.default_rng(4).integers(120, 250, (128, 128))
CUTOUT = np.where(np.arange(128) % 16 < 4, 0, 255) * np.ones((128, 1))


@pytest.mark.parametrize(
    ("name", "alpha", "level"),
    [
        ("wall_n.png", None, "warning"),
        ("wall_n.png", CUTOUT, "warning"),
        ("wall_n.png", MAP, "info"),
        ("wall_n_xy.png", None, "info"),
        ("wall_n_bc5.png", None, "info"),
    ],
)
def test_a_blue_that_is_not_z_is_a_warning_unless_it_is_meant(run, tmp_path, name, alpha, level):
    write_png(tmp_path / name, noisy_blue(alpha))
    [file] = files_of(run, name)
    assert (file["type"], levels_of(file).get("NT006")) == ("xy", level)
    if level == "warning":
        [message] = [f["message"] for f in file["findings"] if f["id"] == "NT006"]
        assert "--type xy --to standard" in message
        done = run("convert", "--type", "xy", "--to", "standard", name, "-o", "out_n.png")
        assert done.returncode == 0, done.stderr
        assert files_of(run, "out_n.png")[0]["type"] == "standard"
        [forced] = files_of(run, "--type", "xy", name)
        assert "NT006" not in levels_of(forced)
