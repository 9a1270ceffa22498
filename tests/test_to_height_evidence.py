# SPDX-License-Identifier: MIT
"""What the levels of a texture mean, and whether its blue is used, detected from the texture
alone."""

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import maps
from support.to_height import (
    CLAMP,
    DECODE_AUTO,
    NEUTRAL,
    SNORM,
    TRUNC,
    UNORM,
    WRAP,
    by_eigenvectors,
    fractal,
    mixed_slopes,
    near,
)
from support.to_height import to_height as reconstruct

AUTO, STORED, DERIVED = range(3)


def normals(h, wrap):
    """Float normals of one-sided differences, Y up."""
    edge = "wrap" if wrap else "edge"
    padded = np.pad(h.astype(np.float64), ((0, 1), (0, 1)), mode=edge)
    p, q = padded[:-1, 1:] - h, padded[1:, :-1] - h
    n = np.stack([-p, q, np.ones_like(p)], axis=-1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def encode(n, rule):
    if rule == TRUNC:
        return np.clip(np.floor((n + 1) / 2 * 255), 0, 255).astype(np.uint8)
    if rule == SNORM:
        return np.floor(n * 127 + 128.5).astype(np.uint8)
    return np.floor((n + 1) / 2 * 255 + 0.5).astype(np.uint8)


def derived_blue(c):
    v = (2 * c.astype(np.float64) - 255) / 255
    z = np.sqrt(np.maximum(1 - v[..., 0] ** 2 - v[..., 1] ** 2, 0))
    c = c.copy()
    c[..., 2] = np.floor((z + 1) / 2 * 255 + 0.5)
    return c


def bumps(n, count=9):
    y, x = np.mgrid[:n, :n]
    rng = np.random.default_rng(2)
    h = np.zeros((n, n))
    for cx, cy in rng.uniform(0.1, 0.9, (count, 2)) * n:
        h += 6 * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / 90)
    return h


FIELDS = {
    "fractal": lambda: (fractal(256), True),
    "steep": lambda: (fractal(256, seed=4, rms_slope=2), True),
    "gentle": lambda: (fractal(256, seed=5, rms_slope=0.15), True),
    "bumps": lambda: (bumps(512), False),
}


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("rule", [UNORM, TRUNC, SNORM])
def test_the_rule_of_the_encoder(field, rule):
    h, wrap = FIELDS[field]()
    border = WRAP if wrap else CLAMP
    how = {"kernel": "forward", "border_x": border, "border_y": border}
    n = encode(normals(h, wrap), rule)
    _, result = reconstruct(n, **how)
    assert result["decode"] == rule
    if field == "bumps" and rule == UNORM:
        return  # the heights are better with 127 and 128 both 0, and the normals of these worse
    # As good as the best of all rules.
    error = {
        d: np.std(reconstruct(n, decode=d, **how)[0] - h)
        for d in (DECODE_AUTO, UNORM, NEUTRAL, TRUNC, SNORM)
    }
    assert error[DECODE_AUTO] <= 1.1 * min(error.values()), error


@pytest.mark.parametrize("field", FIELDS)
def test_derived_blue_does_not_mislead(field):
    h, wrap = FIELDS[field]()
    n = derived_blue(encode(normals(h, wrap), UNORM))
    _, result = reconstruct(n)
    assert result["decode"] in (UNORM, NEUTRAL)


def test_noise_and_flat_textures_are_read_plainly():
    rng = np.random.default_rng(3)
    for n in (
        rng.integers(0, 256, (128, 128, 3)),
        rng.integers(120, 136, (128, 128, 3)),
        np.full((64, 64, 3), (128, 128, 255)),
        np.full((64, 64, 3), (127, 127, 254)),
        np.zeros((64, 64, 3)),
    ):
        _, result = reconstruct(n.astype(np.uint8))
        assert result["decode"] in (UNORM, NEUTRAL)


@pytest.mark.parametrize("size", [(1, 1), (7, 3), (40, 30), (256, 256)])
def test_ramps_and_ripples_are_read_plainly(size):
    """The same few rounding errors over and over are no evidence."""
    w, h = size
    x = np.broadcast_to(np.arange(w, dtype=float), (h, w))
    slopes = [(3, 1), (0.3, 0), (0.3, -0.2), (1, 1), (-2.5, 0.7), (0.004, 0.004), (8, 5)]
    fields = [(p * np.ones((h, w)), q * np.ones((h, w))) for p, q in slopes]
    fields += [(a * np.sin(2 * np.pi * x / 16), b * np.ones((h, w))) for a, b in slopes]
    for p, q in fields:
        n = np.stack([-p, q, np.ones((h, w))], axis=-1)
        n = encode(n / np.linalg.norm(n, axis=-1, keepdims=True), UNORM)
        assert reconstruct(n)[1]["decode"] in (UNORM, NEUTRAL), (p[0, :3], q[0, 0])


def bricks(n, grain):
    """Flat bricks between mortar, with some of a fractal on them."""
    y, x = np.mgrid[:n, :n]
    edge = np.minimum((x + 16 * (y // 16 % 2)) % 32, y % 16)
    return 4.0 * np.clip(edge - 1, 0, 2) + grain * fractal(n, seed=6)


@pytest.mark.parametrize("grain, neutral", [(0, True), (0.02, False), (0.2, False)])
def test_flat_ground_is_neutral_and_grain_is_not(grain, neutral):
    """Slopes below a level, of either sign in turn, would be lost if 127 and 128 were both 0."""
    h = bricks(128, grain)
    v = normals(h, True)
    n = encode(v, UNORM)
    n[..., :2][v[..., :2] == 0] = 127  # as encoders do that round a half down
    _, result = reconstruct(n, kernel="forward")
    assert result["decode"] == (NEUTRAL if neutral else UNORM)
    gentle = encode(normals(0.02 * fractal(128, seed=7), True), UNORM)
    assert reconstruct(gentle, kernel="forward")[1]["decode"] == UNORM


@pytest.mark.parametrize("slope, spread", [(0.3, 2), (0.7, 2), (0.7, 4), (1.8, 4), (4, 4), (4, 10)])
def test_z_of_damaged_textures_is_near_the_best(slope, spread):
    h = fractal(128, seed=8, rms_slope=slope)
    clean = encode(normals(h, True), UNORM)
    noise = np.random.default_rng(9).normal(0, spread, clean.shape)
    damaged = (clean + noise).round().clip(0, 255).astype(np.uint8)
    error = [
        np.std(reconstruct(damaged, z=z, kernel="forward", decode=UNORM)[0] - h)
        for z in (AUTO, STORED, DERIVED)
    ]
    assert error[AUTO] <= 1.05 * min(error[1:])
    if spread == 10:  # many z are nearly 0, or below it
        assert error[AUTO] < 0.6 * error[1]


@pytest.mark.parametrize("spread", [2, 4, 10])
def test_derived_z_is_not_taken_from_damaged_red_and_green(spread):
    """Where they are nearly 1 long, slopes from derived z have no limit."""
    h = fractal(256, rms_slope=1.8)
    clean = encode(normals(h, True), UNORM)
    noise = np.random.default_rng(spread).normal(0, spread, clean.shape)
    damaged = (clean + noise).round().clip(0, 255).astype(np.uint8)
    how = {"kernel": "forward", "decode": UNORM}
    error, told = {}, {}
    for z in (AUTO, STORED, DERIVED):
        made, result = reconstruct(damaged, z=z, **how)
        error[z], told[z] = np.std(made - h), result["z"]
    assert told[AUTO] == STORED and error[AUTO] <= error[STORED]
    assert error[STORED] < 0.2 * error[DERIVED]
    spoiled = clean.copy()  # in blue alone
    spoiled[::2, :, 2] = 255
    made, result = reconstruct(spoiled, z=AUTO, **how)
    assert result["z"] == DERIVED
    spoiled[5, 5, :2] = 255  # one texel is too long by accident
    assert reconstruct(spoiled, z=AUTO, **how)[1]["z"] == DERIVED


def test_blue_of_a_jpeg_is_kept():
    """Errors of x and y make z^2 follow 1 - x^2 - y^2 loosely, though no texel is too long."""
    h = fractal(256, seed=8, rms_slope=0.45, exponent=1.6)
    p, q = ((np.roll(h, -1, axis) - np.roll(h, 1, axis)) / 2 for axis in (1, 0))
    n = np.stack([-p, q, np.ones_like(p)], axis=-1, dtype=np.float64)
    clean = encode(n / np.linalg.norm(n, axis=-1, keepdims=True), UNORM)
    how = {"kernel": "central", "decode": UNORM}
    damaged = maps.jpeg(clean, 30, 0)
    error = [np.std(reconstruct(damaged, z=z, **how)[0] - h) for z in (AUTO, STORED, DERIVED)]
    assert error[AUTO] <= 1.05 * error[STORED] < 0.3 * error[DERIVED]
    parts = clean.copy()  # of which the other half is right
    parts[::2, :, 2] = 255
    heights = clean.copy()
    heights[..., 2] = (h - h.min()) / np.ptp(h) * 255
    for other in (parts, heights, maps.jpeg(heights, 85, 0)):
        assert reconstruct(other, z=AUTO, **how)[1]["z"] == DERIVED


@pytest.mark.parametrize("slope", [0.5, 2.5])
def test_z_of_a_jpeg_is_told_by_all_three_channels(slope):
    h = fractal(64, seed=3, rms_slope=slope)
    n = maps.jpeg(encode(normals(h, True), UNORM), 85, 0)
    model = by_eigenvectors(*mixed_slopes(n), "forward", WRAP, WRAP)
    how = {"kernel": "forward", "z": AUTO, "decode": UNORM}
    opaque = np.dstack([n, np.full(n.shape[:2], 255, np.uint8)])
    for same in (n, opaque, n[:, ::-1][:, ::-1], n.astype(np.uint16) * 257):
        assert near(reconstruct(same, **how)[0], model, 1e-5)
    assert near(reconstruct((n / 255).astype(np.float32), **how)[0], model, 1e-5)
    assert not near(reconstruct(n, **{**how, "z": STORED})[0], model, 1e-4)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("quality", [85, 95])
def test_z_of_a_part_of_a_jpeg_is_near_the_best(seed, quality):
    """Errors of blue bend heights where no border holds them."""
    h = fractal(512, seed=seed, rms_slope=0.65, exponent=2.2)
    part = np.s_[30:286, 20:276]
    n = maps.jpeg(np.ascontiguousarray(encode(normals(h, True), UNORM)[part]), quality, 0)
    how = {"kernel": "forward", "border_x": CLAMP, "border_y": CLAMP, "decode": UNORM}
    error = []
    for z in (AUTO, STORED, DERIVED):
        away = reconstruct(n, z=z, **how)[0] - h[part]
        error.append(np.std(away))
    assert error[AUTO] <= 1.4 * min(error[1:])


def test_z_of_shorter_normals_is_the_stored_one():
    """Means of normals keep the quotient of x and z."""
    n = encode(normals(fractal(256, rms_slope=1.5, exponent=1.6), True), UNORM).astype(np.float64)
    half = (n.reshape(128, 2, 128, 2, 3).mean((1, 3)) + 0.5).astype(np.uint8)
    made = [reconstruct(half, kernel="forward", z=z, decode=UNORM)[0] for z in (AUTO, STORED)]
    assert (made[0] == made[1]).all()


def test_whether_blue_counts():
    h = fractal(256, rms_slope=1)
    n = normals(h, True)
    how = {"kernel": "forward", "z": AUTO}
    rounded = encode(n, UNORM)
    assert reconstruct(rounded, **how)[1]["z"] == STORED
    assert reconstruct(derived_blue(rounded), **how)[1]["z"] == DERIVED
    wrong = rounded.copy()
    wrong[..., 2] = 255
    assert reconstruct(wrong, **how)[1]["z"] == DERIVED
    assert reconstruct(rounded[..., :2].copy(), ntp.XY, **how)[1]["z"] == DERIVED
    flat = np.full((64, 64, 3), (128, 128, 255), np.uint8)
    assert reconstruct(flat, **how)[1]["z"] == STORED
    deep = np.floor((n + 1) / 2 * 65535 + 0.5).astype(np.uint16)
    assert reconstruct(deep, **how)[1]["z"] == STORED
    unit = ((n + 1) / 2).astype(np.float32)
    assert reconstruct(unit, **how)[1]["z"] == STORED
    assert reconstruct((3 * n).astype(np.float32), ntp.VECTOR, **how)[1]["z"] == STORED
    z_zero = rounded.copy()
    z_zero[..., 2] = np.floor(n[..., 2] * 255 + 0.5)
    assert reconstruct(z_zero, ntp.ZZERO, **how)[1]["z"] == STORED
    assert reconstruct(rounded, kernel="forward")[1]["z"] == STORED
    # And it is the better choice where the ground is steep.
    steep = fractal(256, rms_slope=4)
    n = encode(normals(steep, True), UNORM)
    error = {z: np.std(reconstruct(n, kernel="forward", z=z)[0] - steep) for z in range(3)}
    assert error[AUTO] == error[STORED] < error[DERIVED]
