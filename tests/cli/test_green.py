# SPDX-License-Identifier: MIT
"""Which way green points: used where sure, asked for where it matters, and never guessed.

The surfaces and their normals are made here, by numpy alone.
"""

import json

import numpy as np
import pytest

from support.pngs import read_png, write_png


def bumps(h=128, w=128, seed=1):
    """Heights, in texels, of round bumps and dents."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:h, :w].astype(float)
    out = np.zeros((h, w))
    for _ in range(h * w // 300):
        cy, cx, size = rng.uniform(0, h), rng.uniform(0, w), rng.uniform(4, 10)
        out += rng.choice([-1, 1]) * size / 2 * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / size**2)
    return out


def encode(p, q, depth=8):
    """The texture of slopes to the right and up the picture, green up."""
    m = 255 if depth == 8 else 65535
    n = np.dstack([-p, -q, np.ones_like(p)]) / np.sqrt(p * p + q * q + 1)[..., None]
    return np.floor((n + 1) / 2 * m + 0.5).astype(np.uint8 if depth == 8 else np.uint16)


def opengl(heights, depth=8):
    down, right = np.gradient(heights)
    return encode(right, -down, depth)


def directx(heights, depth=8):
    down, right = np.gradient(heights)
    return encode(right, down, depth)


def tiny(h=16, w=16):
    """Too small to tell, and not flat."""
    return opengl(bumps(64, 64, 5)[:h, :w])


def angle(a, b):
    """The mean angle between two textures, in degrees."""
    a, b = (t[..., :3].astype(float) / np.iinfo(t.dtype).max * 2 - 1 for t in (a, b))
    a, b = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (a, b))
    return np.degrees(np.arccos(np.clip((a * b).sum(-1), -1, 1))).mean()


def item(done, code=0):
    assert done.returncode == code, (done.stdout, done.stderr)
    (one,) = json.loads(done.stdout)["files"]
    return one


def pixels_of(path):
    return read_png(path)[0]


MAKERS = {"up": opengl, "down": directx}
ASKS = "--y up (OpenGL) or --y down (DirectX)?"


# ------------------------------------------------------------------------- transform


@pytest.mark.parametrize("depth", [8, 16])
@pytest.mark.parametrize("turns", [1, 3])
@pytest.mark.parametrize("y", MAKERS)
def test_a_turned_texture_is_that_of_the_turned_surface(run, tmp_path, y, turns, depth):
    heights = bumps()
    write_png(tmp_path / "a.png", MAKERS[y](heights, depth))
    args = ["transform", "a.png", "-o", "b.png", "--rotate", 90 * turns]
    one = item(run(*args, "--format", "json"))
    assert (one["y"], one["y_by"]) == (y, "texels") and one["y_confidence"] >= 0.9
    want = MAKERS[y](np.rot90(heights, -turns), depth)
    assert angle(pixels_of(tmp_path / "b.png"), want) < 0.5
    assert f"green points {y}" in run(*args).stdout
    by_option = item(run(*args, "--y", "opengl", "--format", "json"))
    assert (by_option["y"], by_option["y_by"], by_option["y_confidence"]) == ("up", "option", 1)


@pytest.mark.parametrize("how", [
    ["--flip", "x"], ["--flip", "y"], ["--flip", "xy"], ["--rotate", "180"], ["--strength", "2"],
    ["--strength", "-0.5"], ["--flip", "x", "--rotate", "180", "--strength", "-3"],
])  # fmt: skip
def test_other_transforms_do_not_ask(run, tmp_path, how):
    """The bytes are the same for both, so there is nothing to ask."""
    write_png(tmp_path / "a_n.png", tiny())
    one = item(run("transform", "a_n.png", "-o", "b.png", *how, "--format", "json"))
    assert (one["y"], one["y_by"], one["y_confidence"]) == (None, "unneeded", 0)
    for y in ("up", "down"):
        assert run("transform", "a_n.png", "-o", f"{y}.png", *how, "--y", y).returncode == 0
        assert (tmp_path / f"{y}.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_quarter_turn_asks(run, tmp_path):
    write_png(tmp_path / "a_n.png", tiny())
    args = ["transform", "a_n.png", "-o", "b.png", "--rotate", "90"]
    done = run(*args)
    assert done.returncode == 1 and ASKS in done.stderr and not (tmp_path / "b.png").exists()
    assert run(*args, "--force").returncode == 1  # it says what to write, not which way
    assert item(run(*args, "--format", "json"), 1)["status"] == "refused"
    for y in MAKERS:
        assert run(*args, "--y", y).returncode == 0


def with_unused(texture, depth):
    out = np.dstack([texture, np.full(texture.shape[:2], np.iinfo(texture.dtype).max)])
    out[:3] = 0
    out[3:5] = np.iinfo(texture.dtype).max
    out[5:7, :, :3], out[5:7, :, 3] = np.array((9, 250, 90)) * (257 if depth == 816 else 1), 0
    return out.astype(texture.dtype)


@pytest.mark.parametrize("depth", [8, 16, 816])
def test_flat_textures_turn_without_asking(run, tmp_path, depth):
    """Both levels in the middle are flat; what is unused has no direction."""
    rng = np.random.default_rng(3)
    middle = [32767, 32768] if depth == 16 else [127, 128]
    flat = np.full((20, 24, 3), 65535 if depth == 16 else 255)
    flat[..., :2] = rng.choice(middle, (20, 24, 2))
    flat = flat.astype(np.uint8 if depth == 8 else np.uint16) * (257 if depth == 816 else 1)
    args = ["transform", "a_n.png", "-o", "b.png", "--rotate", "90", "--type", "standard"]
    for texture in (flat, with_unused(flat, depth)):
        write_png(tmp_path / "a_n.png", texture)
        assert item(run(*args, "--format", "json"))["y_by"] == "unneeded"
        for channel in (0, 1):
            tilted = texture.copy()
            tilted[15, 11, channel] = 129 * (257 if depth == 816 else 1) if depth != 16 else 32769
            write_png(tmp_path / "a_n.png", tilted)
            done = run(*args)
            assert done.returncode == 1 and ASKS in done.stderr


def test_a_name_that_contradicts_the_texels_is_asked_about(run, tmp_path):
    write_png(tmp_path / "wall_dx.png", opengl(bumps()))
    write_png(tmp_path / "wall_gl.png", opengl(bumps()))
    done = run("transform", "wall_dx.png", "-o", "b.png", "--rotate", "90")
    assert done.returncode == 1 and "but its name says DirectX" in done.stderr
    assert "its texels look like OpenGL (Y up), 9" in done.stderr
    assert run("transform", "wall_gl.png", "-o", "b.png", "--rotate", "90").returncode == 0


# ----------------------------------------------------------------------------- blend


@pytest.mark.parametrize("base", MAKERS)
@pytest.mark.parametrize("detail", MAKERS)
def test_blend_turns_the_detail_to_the_base(run, tmp_path, base, detail):
    """Heights add up, nearly: slopes do, with udn, in the green of the base."""
    a, d = bumps(seed=1), bumps(seed=2) / 4
    write_png(tmp_path / "a.png", MAKERS[base](a))
    write_png(tmp_path / "d.png", MAKERS[detail](d))
    args = ["blend", "a.png", "d.png", "-o", "b.png"]
    one = item(run(*args, "--format", "json"))
    assert (one["y"], one["y_by"]) == (base, "texels")
    assert (one["detail_y"], one["detail_y_by"]) == (detail, "texels")
    sum_of_both = MAKERS[base](a + d)
    assert angle(pixels_of(tmp_path / "b.png"), sum_of_both) < 2
    wrong = "down" if detail == "up" else "up"
    run(*args[:-1], "w.png", "--detail-y", wrong)
    assert angle(pixels_of(tmp_path / "w.png"), sum_of_both) > 5
    if (base, detail) == ("up", "down"):
        text = run(*args).stdout
        assert "green of BASE points up" in text and "green of DETAIL points down" in text


def test_blend_asks(run, tmp_path):
    write_png(tmp_path / "known.png", directx(bumps()))
    write_png(tmp_path / "small_n.png", tiny())
    flat = np.full((16, 16, 3), (128, 128, 255), np.uint8)
    write_png(tmp_path / "flat_n.png", flat)
    across = np.repeat(tiny()[:1], 16, 0)
    across[..., 1] = 127
    write_png(tmp_path / "across_n.png", across)

    def blended(base, detail, *more):
        (tmp_path / "b.png").unlink(missing_ok=True)
        return run("blend", f"{base}.png", f"{detail}.png", "-o", "b.png", *more)

    for base, detail, more, words in (
        ("known", "small_n", (), "--detail-y up (OpenGL) or --detail-y down (DirectX)?"),
        ("small_n", "known", (), ASKS),
        ("small_n", "small_n", (), "--detail-y says it of DETAIL"),
        ("small_n", "small_n", ("--y", "up"), "--detail-y up"),
        ("small_n", "small_n", ("--detail-y", "up"), ASKS),
    ):
        done = blended(base, detail, *more)
        assert done.returncode == 1 and words in done.stderr, (base, detail)
        assert not (tmp_path / "b.png").exists()
    for base, detail, more in (
        ("small_n", "small_n", ("--y", "up", "--detail-y", "down")),
        ("flat_n", "small_n", ()),  # takes the green of the detail, whichever it is
        ("small_n", "flat_n", ()),
        ("small_n", "across_n", ()),  # a detail without y is that of both
        ("across_n", "small_n", ()),
        ("small_n", "small_n", ("--strength", "0")),
    ):
        done = blended(base, detail, *more)
        assert done.returncode == 0, (base, detail, done.stderr)
    blended("flat_n", "small_n")
    assert angle(pixels_of(tmp_path / "b.png"), tiny()) < 0.6
