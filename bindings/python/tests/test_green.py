# SPDX-License-Identifier: MIT
"""Which way green points: used where sure, asked for where it matters, as by the program."""

import subprocess

import numpy as np
import pytest

import normaltexture as nt


def bumps(size=128, seed=1):
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:size, :size].astype(float)
    out = np.zeros((size, size))
    for cy, cx, r in rng.uniform((0, 0, 4), (size, size, 10), (size * size // 300, 3)):
        out += rng.choice([-1, 1]) * r / 2 * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / r**2)
    return out


def texture(heights, y, dtype=np.uint8):
    """By numpy alone: slopes of the heights, in levels or as floats in 0..1."""
    down, right = np.gradient(heights)
    n = np.dstack([-right, down if y == "up" else -down, np.ones_like(right)])
    n = (n / np.linalg.norm(n, axis=-1, keepdims=True) + 1) / 2
    if dtype == np.float32:
        return n.astype(dtype)
    return np.floor(n * np.iinfo(dtype).max + 0.5).astype(dtype)


def flipped(levels):
    out = levels.copy()
    out[..., 1] = (1 if levels.dtype.kind == "f" else np.iinfo(levels.dtype).max) - out[..., 1]
    return out


def angle(a, b):
    a, b = (t.astype(float) / (1 if t.dtype.kind == "f" else np.iinfo(t.dtype).max) for t in (a, b))
    a, b = ((v * 2 - 1) / np.linalg.norm(v * 2 - 1, axis=-1, keepdims=True) for v in (a, b))
    return np.degrees(np.arccos(np.clip((a * b).sum(-1), -1, 1))).mean()


YS = ["up", "down"]
DTYPES = [np.uint8, np.uint16, np.float32]
TINY = texture(bumps(64)[:16, :16], "up")
FLAT = np.full((16, 16, 3), (128, 127, 255), np.uint8)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("wanted", [("up", "opengl"), ("down", "directx")])
@pytest.mark.parametrize("y", YS)
def test_convert(y, wanted, dtype):
    src = texture(bumps(), y, dtype)
    want = src if y == wanted[0] else flipped(src)
    for to_y in wanted:
        assert np.array_equal(nt.convert(src, to_y=to_y), want)
        assert np.array_equal(nt.convert(src, type="standard", to_y=to_y), want)
    assert np.array_equal(nt.convert(src), src)
    assert np.array_equal(nt.convert(src, y="down"), flipped(src))


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("y", YS)
def test_transform(y, dtype):
    for turn in (90, 270):
        got = nt.transform(texture(bumps(), y, dtype), rotate=turn)
        assert angle(got, texture(np.rot90(bumps(), -turn // 90), y, dtype)) < 0.5
    for how in ({"flip": "xy"}, {"rotate": 180}, {"strength": -2}):
        assert np.array_equal(nt.transform(TINY, **how), nt.transform(TINY, y="down", **how))
    assert nt.transform(FLAT, rotate=90).shape == FLAT.shape


@pytest.mark.parametrize("base", YS)
@pytest.mark.parametrize("detail", YS)
def test_blend(base, detail):
    a, d = bumps(seed=1), bumps(seed=2) / 4
    got = nt.blend(texture(a, base), texture(d, detail))
    assert angle(got, texture(a + d, base)) < 2
    assert np.array_equal(
        got, nt.blend(texture(a, base), texture(d, detail), y=base, detail_y=detail)
    )


@pytest.mark.parametrize("y", YS)
def test_heights(y):
    _, info = nt.height_from_normals_with_info(texture(bumps(), y))
    assert info.y == y
    across = np.repeat(texture(bumps(), "up")[:1], 128, 0)
    across[..., 1] = 128
    assert nt.height_from_normals_with_info(across)[1].y == "up"


def test_blend_where_one_has_no_y():
    assert angle(nt.blend(FLAT, TINY), TINY) < 0.6
    assert angle(nt.blend(TINY, FLAT), TINY) < 0.6
    assert np.array_equal(nt.blend(TINY, TINY, strength=0), nt.blend(TINY, FLAT, strength=0))


@pytest.mark.parametrize(
    "call,asks",
    [
        (lambda: nt.convert(TINY, to_y="up"), "y"),
        (lambda: nt.transform(TINY, rotate=90), "y"),
        (lambda: nt.transform(TINY, rotate=7.5), "y"),
        (lambda: nt.blend(TINY, TINY), "y"),
        (lambda: nt.blend(TINY, TINY, y="up"), "detail_y"),
        (lambda: nt.height_from_normals(TINY), "y"),
    ],
)
def test_it_asks(call, asks):
    words = rf'{asks}="auto": .*; which is it, {asks}="up" \(OpenGL\) or {asks}="down"'
    with pytest.raises(nt.ArgumentError, match=words):
        call()


def test_the_program_takes_the_same(test_files, tmp_path):
    """Or asks as well, of each file that is one of normals."""
    for path in sorted(test_files.glob("st*.png")) + sorted(test_files.glob("zzero*.png")):
        command = [nt.program(), "convert", path, "-o", tmp_path / "out.png", "--to-y", "down"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        try:
            got = nt.convert(nt.read(path), to_y="down")
        except nt.ArgumentError:
            assert done.returncode == 1 and "--y up (OpenGL)" in done.stderr, path
        else:
            assert done.returncode == 0, (path, done.stderr)
            assert np.array_equal(nt.read(tmp_path / "out.png"), got), path


def test_types_are_asked_for_where_they_matter():
    gentle = texture(bumps() / 40, "up")
    assert nt.classify(gentle).confidence < 0.9
    with pytest.raises(nt.ArgumentError, match='which is it, type="standard", "zzero" or "xy"'):
        nt.convert(gentle, to="zzero")
    assert np.array_equal(nt.convert(gentle), gentle)
    assert nt.convert(gentle, type="standard", to="zzero").shape == gentle.shape


@pytest.mark.parametrize(
    ("call", "how"),
    [
        (nt.transform, {"rotate": 90, "y": "OpenGL"}),
        (nt.height_from_normals, {"y": "OpenGL"}),
        (nt.normals_from_height, {"scale": 2, "to_y": "OpenGL"}),
    ],
)
def test_a_wrong_word_is_answered_with_all_right_ones(call, how):
    picture = np.full((8, 8, 3), (128, 128, 255), np.uint8)
    picture = picture[..., 0] if "scale" in how else picture
    with pytest.raises(nt.ArgumentError, match="'up', 'down', 'opengl', 'directx'"):
        call(picture, **how)


def test_flat_in_16_bit_depends_on_all_texels():
    """127 and 128 of 8 bit are both flat; one texel anywhere that is not of 8 bit makes them slopes."""
    level = np.random.default_rng(3).choice([127, 128], (150, 8, 3)).astype(np.uint16) * 257
    level[..., 2] = 65535
    nt.height_from_normals(level, type="standard", border="wrap", kernel="central")  # is not asked
    for row in (0, 70, 149):
        other = level.copy()
        other[row, 3, 2] -= 1
        with pytest.raises(nt.ArgumentError, match="which is it"):
            nt.height_from_normals(other, type="standard", border="wrap", kernel="central")
