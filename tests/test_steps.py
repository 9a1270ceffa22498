# SPDX-License-Identifier: MIT
"""Slope quantization: detected for low-bit heights, and not for textures that only look similar.

Heights become normals here, in float64.  A kernel's slopes are whole multiples of scale / (its
divisor * the levels' range): this is the step to be found.
"""

import os
from math import atan, degrees

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import maps, surfaces
from support.sanitized import EVERY

SEED = int(os.environ.get("NTP_SEED", "20261121"))
DIVISORS = {"central": 2, "forward": 1, "prewitt3": 6, "sobel3": 8}


def told(n, **how):
    return ntp.find_steps(n, **how)["decided"]


def quantized(h, levels=255):
    h = (h - h.min()) / np.ptp(h)
    return np.floor(h * levels + 0.5)


def sums(h, kernel, axis):
    """The kernel's integer sum along the axis, edges wrapped."""
    if kernel == "forward":
        return np.roll(h, -1, axis) - h
    difference = np.roll(h, -1, axis) - np.roll(h, 1, axis)
    weight = {"central": 0, "prewitt3": 1, "sobel3": 2}[kernel]
    if weight == 0:
        return difference
    sides = np.roll(difference, 1, 1 - axis) + np.roll(difference, -1, 1 - axis)
    return sides + weight * difference


def vectors(p, q):
    """Of slopes to the right and down the picture; y up."""
    n = np.stack([-p, q, np.ones_like(p)], -1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def stored(p, q, m=255):
    return maps.to_type(maps.encode(vectors(p, q), m), m)


def made(h, kernel="central", scale=25.0, levels=255):
    """Vectors of integer heights, and their step."""
    step = scale / (DIVISORS[kernel] * levels)
    return vectors(step * sums(h, kernel, 1), step * sums(h, kernel, 0)), step


def textures_of(kernel, scale, m, levels=255, surface=surfaces.fractal, seed=1, n=256):
    h = quantized(surface(np.random.default_rng(seed), n, n), levels)
    v, step = made(h, kernel, scale, levels)
    return maps.to_type(maps.encode(v, m), m), step


# ---------------------------------------------------------------------------- it tells


@pytest.mark.parametrize(
    "kernel, scale, m",
    [("central", s, 255) for s in (20, 25, 50)]
    + [("forward", s, 255) for s in (10, 25)]
    + [(k, s, 65535) for k in DIVISORS for s in (5, 10, 25, 50)],
)
def test_heights_of_8_bit(kernel, scale, m):
    n, step = textures_of(kernel, scale, m)
    found = ntp.find_steps(n)
    assert found["decided"]
    assert found["slope"] == pytest.approx(step, rel=0.01 if m == 255 else 0.002)
    assert found["degrees"] == pytest.approx(degrees(atan(found["slope"])), abs=1e-3)
    assert found["teeth"] >= 4 and found["share"] > 0.99
    assert found["expected"] < (0.5 if m == 255 else 0.1)


@pytest.mark.parametrize("levels", [63, 1023])
def test_other_numbers_of_levels(levels):
    n, step = textures_of("central", 0.1 * levels, 65535, levels)
    assert ntp.find_steps(n)["slope"] == pytest.approx(step, rel=0.002)


def test_smooth_bumps():
    h = surfaces.bumps(np.random.default_rng(5), 256, 256)
    for m, scale in ((255, 30), (65535, 6)):
        v, step = made(quantized(h), scale=scale)
        assert ntp.find_steps(maps.to_type(maps.encode(v, m), m))["slope"] == pytest.approx(
            step, rel=0.01
        )


def test_encoders():
    """8 bit: rounded, truncated, with 127 or 128 for 0; also in a 16-bit image."""
    rng = np.random.default_rng(2)
    v, step = made(quantized(surfaces.fractal(rng, 256, 256)), scale=30)
    for style in ("rounded", "truncated", "flat127", "flat128"):
        n, _ = maps.encode_normals(rng, v, 255, style=style)
        found = ntp.find_steps(n)
        assert found["slope"] == pytest.approx(step, rel=0.02), style
        assert ntp.find_steps(n.astype(np.uint16) * 257) == found
        assert ntp.find_steps(n.astype(np.float32) / 255) == found


def test_what_does_not_matter():
    n, step = textures_of("central", 30, 255)
    found = ntp.find_steps(n)
    other = n.copy()
    other[..., 2] = 77
    assert ntp.find_steps(other, encoding=ntp.ZZERO) == found
    assert ntp.find_steps(np.ascontiguousarray(n[..., :2]), encoding=ntp.XY) == found
    assert ntp.find_steps(ntp.clean(other, how=ntp.clean_options())[0])["slope"] == found["slope"]
    for same in (np.dstack([255 - n[..., :1], n[..., 1:]]), n[::-1], n[:, ::-1]):
        assert ntp.find_steps(same)["slope"] == pytest.approx(step, rel=0.01)
    padded = n.copy()
    padded[:90] = 0
    assert ntp.find_steps(padded)["slope"] == pytest.approx(step, rel=0.01)
    assert not told(padded[:90]) and told(n[:90]) and told(n[:, :60])
    noise = stored(*np.random.default_rng(9).normal(0, 0.3, (2, 90, 256)))
    hidden = maps.with_alpha(np.concatenate([noise, n[90:]]), 255)
    assert not told(hidden)
    hidden[:90, :, 3] = 0
    assert told(hidden) and not told(hidden, touch=ntp.UNUSED_TRANSPARENT)


def test_some_texels_are_other():
    n, step = textures_of("central", 10, 65535)
    rng = np.random.default_rng(3)
    bad = rng.random(n.shape[:2]) < 0.02
    n[bad] = stored(*rng.normal(0, 0.3, (2, bad.sum())), m=65535)
    assert ntp.find_steps(n)["slope"] == pytest.approx(step, rel=0.002)


# -------------------------------------------------------------------------- it is silent


def test_drawn_textures():
    """Textures of every kind from the tests of the classification, none made from integer
    heights."""
    rng = np.random.default_rng(SEED)
    for i in range(250 // EVERY):
        case = maps.draw(rng)
        if case.pixels.ndim == 3 and case.encoding != ntp.HEIGHT and case.pixels.shape[2] > 1:
            encoding = ntp.XY if case.pixels.shape[2] == 2 else ntp.STANDARD
            n = np.ascontiguousarray(case.pixels)
            assert not told(n, encoding=encoding), (SEED, i, case.name, case.details)


@pytest.mark.parametrize("m", [255, 65535])
@pytest.mark.parametrize("surface", surfaces.FAMILIES)
def test_good_textures(surface, m):
    """Heights of 16 bit and more, gentle and steep."""
    rng = np.random.default_rng(4)
    for strength in (0.02, 0.1, 0.5, 2):
        h = surface(rng, 256, 256)
        assert not told(maps.to_type(maps.encode(surfaces.normals_of(h, strength), m), m))
        v, _ = made(quantized(h, 65535), scale=30, levels=65535)
        assert not told(maps.to_type(maps.encode(v), 255))


def test_gentle_heights_of_8_bit():
    """Their steps are the levels of the texture, so they cannot be distinguished from a good
    one."""
    for kernel in DIVISORS:
        for scale in (0.5, 1, 2):
            assert not told(textures_of(kernel, scale, 255)[0])


@pytest.mark.parametrize("strength", [0.05, 0.2, 1])
@pytest.mark.parametrize("surface", [surfaces.fractal, surfaces.noise])
def test_images_of_fewer_bits(surface, strength):
    """Levels that are evenly spaced, not slopes."""
    v = surfaces.normals_of(surface(np.random.default_rng(6), 256, 256), strength)
    n8 = maps.to_type(maps.encode(v)).astype(np.uint16)
    n16 = maps.to_type(maps.encode(v, 65535), 65535)
    assert not told(n8 << 8) and not told((n8 << 8) + np.uint16(128))
    for lost in range(3, 8):
        assert not told(n16 >> lost << lost)
        whole = 65535 >> lost
        assert not told((((n16 >> lost) * 65535.0) / whole + 0.5).astype(np.uint16))
    for lost in range(1, 6):
        few = (n8 >> lost << lost).astype(np.uint8)
        assert not told(few) and not told(few + np.uint8(1 << lost >> 1))
    for greatest in (127, 511, 1023):
        rounded = np.round(v * greatest) / greatest
        assert not told(maps.to_type(maps.encode(rounded, 65535), 65535))


@pytest.mark.parametrize("m", [255, 65535])
@pytest.mark.parametrize("radius", [8, 12, 20, 50])
@pytest.mark.parametrize("offset", [0, 0.5, 0.3])
def test_domes_waves_and_cones(m, radius, offset):
    """Slopes that grow by the same amount at each texel are evenly spaced and smooth."""
    y, x = np.mgrid[:256, :256] + offset
    cx, cy = x % (2 * radius) - radius, y % (2 * radius) - radius
    inside = cx**2 + cy**2 < radius**2
    r = np.hypot(cx, cy) + 1e-9
    for steep in (0.3, 1, 2):
        a = steep / radius
        assert not told(stored(a * cx * inside, a * cy * inside, m))
        wave = [a * (np.abs(v % (4 * radius) - 2 * radius) - radius) for v in (x, y)]
        assert not told(stored(*wave, m))
        twice = stored(*wave, m)[:128, :128].repeat(2, 0).repeat(2, 1)
        assert not told(twice)
        assert not told(stored(steep * cx / r * inside, steep * cy / r * inside, m))


@pytest.mark.parametrize("m", [255, 65535])
def test_tiles(m):
    """Planes of a few angles, also evenly spaced ones."""
    rng = np.random.default_rng(7)
    for side in (8, 16):
        for angles in ([0, 30, 45, 60], [0, 15, 30, 45, 60, 75], [0, 20, 70]):
            drawn = rng.choice([*angles, *(-a for a in angles)], (2, 256 // side, 256 // side))
            p, q = np.tan(np.deg2rad(drawn)).repeat(side, 1).repeat(side, 2)
            assert not told(stored(p, q, m))
        for count in range(1, 7):
            drawn = 0.2 * rng.integers(-count, count + 1, (2, 256 // side, 256 // side))
            assert not told(stored(*drawn.repeat(side, 1).repeat(side, 2), m))
    art = rng.integers(0, 4, (32, 32)).astype(float).repeat(8, 0).repeat(8, 1)
    assert not told(stored(0.4 * sums(art, "central", 1), 0.4 * sums(art, "central", 0), m))


def test_damaged_and_empty():
    n, _ = textures_of("central", 25, 255)
    assert not told(maps.jpeg(n, 85, 0))
    assert not told(maps.resize(n, 200, 200, maps.Image.BILINEAR))
    rng = np.random.default_rng(8)
    assert not told(rng.integers(0, 256, (64, 64, 3)).astype(np.uint8))
    for color in ((128, 128, 255), (127, 127, 255), (0, 0, 0), (200, 90, 180)):
        assert not told(np.full((64, 64, 3), color, np.uint8))
    for shape in ((1, 1), (1, 300), (300, 1), (7, 7)):
        found = ntp.find_steps(np.ascontiguousarray(n[: shape[0], : shape[1]]))
        assert found == {k: 0 for k in found}
    nan = np.full((32, 32, 3), np.nan, np.float32)
    assert not told(nan)


@pytest.mark.parametrize("m", [255, 65535])
def test_both_axes_have_to_agree(m):
    h = quantized(surfaces.fractal(np.random.default_rng(1), 256, 256))
    p, q = (30 / 510 * sums(h, "central", axis) for axis in (1, 0))
    assert told(stored(p, q, m))
    for other in (0 * q, 1.3 * q, surfaces.fractal(np.random.default_rng(2), 256, 256)):
        assert not told(stored(p, other, m)) and not told(stored(other, q, m))


def test_arguments():
    n, _ = textures_of("central", 25, 255)
    steps = ntp.ffi.new("ntp_steps *")
    find_steps, src = ntp.lib.ntp_find_steps, ntp.view(n, const=True)
    assert find_steps(ntp.ffi.NULL, src, 0) == ntp.ERR_ARGUMENT
    assert find_steps(steps, ntp.ffi.NULL, 0) == ntp.ERR_ARGUMENT
    assert find_steps(steps, src, 8) == ntp.ERR_ARGUMENT
    assert find_steps(steps, ntp.view(n, ntp.HEIGHT, const=True), 0) == ntp.ERR_FORMAT
    assert find_steps(steps, ntp.view(n, const=True, ring_rows=8), 0) == ntp.ERR_SHAPE
