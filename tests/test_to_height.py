# SPDX-License-Identifier: MIT
"""Normals -> heightfield against the model in support/to_height.py, and round trips."""

import itertools

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support.to_height import (
    CLAMP,
    DERIVED,
    EXTRAPOLATE,
    FRANKOT_CHELLAPPA,
    KERNELS,
    MIRROR,
    NEUTRAL,
    POISSON_DCT,
    SNORM,
    STORED,
    TELESCOPING,
    TRUNC,
    UNORM,
    WRAP,
    by_eigenvectors,
    fractal,
    from_height,
    least_norm,
    near,
    ramp_and_bumps,
    random_vectors,
    slopes,
    stencil,
    to_height,
)

# What the direct solver takes.
BORDERS = {"forward": [0, 1, 2, 3, 4], "central": [WRAP, CLAMP, EXTRAPOLATE]}
CASES = [(k, x, y) for k in KERNELS for x, y in itertools.product(BORDERS[k], repeat=2)]
SIZES = [(1, 1), (1, 2), (2, 1), (2, 2), (1, 7), (7, 1), (3, 2), (5, 4), (4, 5), (7, 7), (6, 9)]


# ---------------------------------------------------------------------- least squares


@pytest.mark.parametrize(("kernel", "border_x", "border_y"), CASES)
def test_least_squares_of_small_sizes(kernel, border_x, border_y):
    rng = np.random.default_rng([border_x, border_y])
    for shape in SIZES:
        n = random_vectors(rng, shape)
        p, q = slopes(n, ntp.VECTOR)
        ours, result = to_height(n, ntp.VECTOR, kernel=kernel, border_x=border_x, border_y=border_y)
        model = least_norm(p, q, kernel, border_x, border_y)
        assert near(ours, model), (shape, ours, model)
        assert near(model, by_eigenvectors(p, q, kernel, border_x, border_y), 1e-8)
        wrap = border_x == WRAP and border_y == WRAP
        assert result["method"] == (FRANKOT_CHELLAPPA if wrap else POISSON_DCT)
        assert (result["min"], result["max"]) == (ours.min(), ours.max())


@pytest.mark.parametrize("shape", [(64, 48), (97, 101), (30, 211), (256, 33), (33, 300), (17, 600)])
@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("border", [WRAP, CLAMP, EXTRAPOLATE])
def test_least_squares_of_large_sizes(shape, kernel, border):
    rng = np.random.default_rng(shape)
    n = random_vectors(rng, shape, 0.3)
    p, q = slopes(n, ntp.VECTOR)
    for border_x, border_y in [(border, border), (border, WRAP), (CLAMP, border)]:
        ours, _ = to_height(n, ntp.VECTOR, kernel=kernel, border_x=border_x, border_y=border_y)
        assert near(ours, by_eigenvectors(p, q, kernel, border_x, border_y), 3e-6)
        assert abs(ours.mean(dtype=np.float64)) < 1e-6 * np.ptp(ours)


@pytest.mark.parametrize("shape", [(3, 1000), (1000, 3), (1, 1031), (1031, 1)])
def test_long_images(shape):
    rng = np.random.default_rng(4)
    n = random_vectors(rng, shape, 0.3)
    p, q = slopes(n, ntp.VECTOR)
    for kernel, border in [("forward", WRAP), ("forward", CLAMP), ("central", WRAP)]:
        ours, _ = to_height(n, ntp.VECTOR, kernel=kernel, border_x=border, border_y=border)
        assert near(ours, by_eigenvectors(p, q, kernel, border, border), 1e-5), (kernel, border)


# ------------------------------------------------------------------------------- decoding


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.ZZERO, ntp.XY])
@pytest.mark.parametrize("y", [ntp.UP, ntp.DOWN])
def test_decoding_of_integers(dtype, encoding, y):
    rng = np.random.default_rng(7)
    m = np.iinfo(dtype).max
    channels = 2 if encoding == ntp.XY else 3
    n = rng.integers(m // 4, 3 * m // 4, (9, 12, channels)).astype(dtype)
    n[..., :2][:3] = m // 2
    if channels == 3:
        n[..., 2] = rng.integers(m // 2 - 2, m, n.shape[:2])
        n[4, 4, 2] = 0
    for decode, derived in itertools.product([UNORM, NEUTRAL, TRUNC, SNORM], [False, True]):
        if encoding == ntp.ZZERO and decode == SNORM:
            continue
        z = DERIVED if derived else STORED
        p, q = slopes(n, encoding, y, decode, derived)
        if encoding == ntp.ZZERO and decode == TRUNC:
            p, q = slopes(n, encoding, y, TRUNC, derived)
        ours, result = to_height(n, encoding, y, kernel="forward", decode=decode, z=z)
        assert near(ours, least_norm(p, q, "forward", WRAP, WRAP)), (decode, derived)
        assert result["decode"] == decode


def test_decoding_of_floats():
    rng = np.random.default_rng(8)
    v = random_vectors(rng, (6, 7))
    unit = ((v + 1) / 2).astype(np.float32)
    zzero = unit.copy()
    zzero[..., 2] = v[..., 2]
    for n, encoding in [(v, ntp.VECTOR), (unit, ntp.STANDARD), (zzero, ntp.ZZERO), (unit, ntp.XY)]:
        for y in (ntp.UP, ntp.DOWN):
            ours, _ = to_height(n, encoding, y, kernel="forward")
            p, q = slopes(n, encoding, y)
            assert near(ours, least_norm(p, q, "forward", WRAP, WRAP))


def test_neutral_levels_by_evidence():
    """Flat ground at 127 was meant to be flat.  At 128 it is what the plain rule rounds 0 to."""
    h = np.zeros((128, 128), np.float32)
    y, x = np.mgrid[:128, :128]
    h += 4 * np.exp(-((x - 40.0) ** 2 + (y - 70.0) ** 2) / 60).astype(np.float32)
    n = from_height(h, border_x=CLAMP, border_y=CLAMP)
    free = {"border_x": CLAMP, "border_y": CLAMP}
    assert to_height(n, **free)[1]["decode"] == UNORM
    n[..., :2][n[..., :2] == 128] = 127
    ours, result = to_height(n, **free)
    biased, _ = to_height(n, decode=UNORM, **free)
    assert result["decode"] == NEUTRAL
    assert np.std(ours - h) < 0.02
    assert np.std(biased - h) > 0.1
    _, result = to_height(from_height(fractal(128)))
    assert result["decode"] == UNORM


def test_level_channels_are_neutral_where_heights_could_lean():
    """Green is 128 everywhere: half a level that heights follow only where they do not wrap."""
    x = np.arange(128)
    h = np.tile(2 * np.sin(x / 64 * np.pi), (128, 1)).astype(np.float32)
    for border, expected in ((WRAP, UNORM), (CLAMP, NEUTRAL)):
        borders = {"border_x": border, "border_y": border}
        n = from_height(h, **borders)
        assert (n[..., 1] == 128).all()
        ours, result = to_height(n, **borders)
        assert result["decode"] == expected
        assert np.std(ours - h) < 0.03
    kept = {
        d: (from_height(to_height(n, decode=d)[0]) == n).all(-1).sum() for d in (UNORM, NEUTRAL)
    }
    assert kept[UNORM] >= kept[NEUTRAL]


@pytest.mark.parametrize("down", [0, 1])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("border", [CLAMP, EXTRAPOLATE, MIRROR, WRAP])
def test_textures_that_slope_along_one_axis_come_back(border, dtype, down):
    """Heights that are off by a rounding error of floats would make 127 of 128."""
    x = np.arange(96)
    for h in (0.3 * x, 2 * np.sin(x / 48 * np.pi), 2 * abs(np.sin(x * np.pi / 24 + 1))):
        h = np.tile(h, (80, 1))
        if border == WRAP and h[0, -1] > 20:
            continue  # the ramp has a step of 29 texels at the seam
        h = np.ascontiguousarray(h.T if down else h)
        how = {"border_x": border, "border_y": border}
        n = from_height(h, **how, dst=dtype)
        assert (n[..., 1 - down] == {np.uint8: 128, np.uint16: 32768}[dtype]).all()
        how["border_x" if down else "border_y"] = WRAP
        ours, result = to_height(n, **how)
        assert result["decode"] == UNORM
        assert np.ptp(ours, axis=down).max() == 0
        assert (result["min"], result["max"]) == (ours.min(), ours.max())
        assert np.std(ours - h) < 0.012 * np.ptp(h)
        assert np.mean(from_height(ours, **how, dst=dtype) != n) < 0.002


def test_flat_ground_at_127_of_red_is_no_evidence_where_green_is_128():
    """Whoever rounds 0 to 128 in green does so in red: these are slopes a little below 0."""
    x = np.arange(128)
    h = np.tile(2 * np.tanh((x % 32 - 16) / 3), (128, 1))
    n = from_height(h, border_x=MIRROR)
    red = np.bincount(n[..., 0].ravel(), minlength=256)
    assert red[127] > 3 * (red[126] + red[129])
    assert red[127] > 10 * red[128]
    assert to_height(n, border_x=MIRROR)[1]["decode"] == UNORM


@pytest.mark.parametrize("kernel", KERNELS)
def test_own_normals_of_flat_ground_are_read_plainly(kernel):
    """With 127 and 128 both 0, more texels would differ when the normals are made again."""
    y, x = np.mgrid[:96, :96]
    edge = np.minimum((x + 12 * (y // 12 % 2)) % 24, y % 12)
    bump = np.clip(1 - np.hypot(x - 40, y - 50) ** 2 / 200, 0, 1)
    for h in (2 * np.clip(edge / 3.0, 0, 1), 3 * bump, 9 * bump, np.maximum(fractal(96), 1)):
        n = from_height(h.astype(np.float32), kernel=kernel)
        ours, result = to_height(n, kernel=kernel)
        assert result["decode"] == UNORM
        neutral, _ = to_height(n, kernel=kernel, decode=NEUTRAL)
        off, more = ((from_height(v, kernel=kernel) != n).any(-1).sum() for v in (ours, neutral))
        assert off <= more


# -------------------------------------------------------------------------- round trips


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("border", [WRAP, EXTRAPOLATE])
def test_round_trip_of_8_bits(kernel, border):
    h = fractal(512) if border == WRAP else fractal(1024)[:512, :512]
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    n = from_height(h, **how)
    ours, _ = to_height(n, **how)
    again = from_height(ours, **how)
    off = np.abs(again.astype(int) - n)[..., :2].max(axis=-1)
    # Extrapolated slopes at the edge itself count less than the others.
    assert off.max() <= (1 if border == WRAP else 2)
    assert off[1:-1, 1:-1].max() <= 1
    assert np.mean(off > 0) <= 0.065


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("border", [WRAP, EXTRAPOLATE, CLAMP])
def test_round_trip_of_16_bits_and_floats(kernel, border):
    # Next to nothing in the parity modes, which central slopes do not see.
    h = fractal(256, exponent=3.5) if border == WRAP else ramp_and_bumps(256)
    if border == CLAMP and kernel == "forward":
        border = MIRROR
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    error = {}
    for name, n, encoding in [
        ("u16", from_height(h, dst=np.uint16, **how), ntp.STANDARD),
        ("f32", from_height(h, vector=True, **how), ntp.VECTOR),
    ]:
        ours, _ = to_height(n, encoding, **how)
        rest = ours - h
        error[name] = np.std(rest) / np.ptp(h)
    assert error["u16"] <= 1e-6
    assert error["f32"] <= 1e-7


def test_ramps_are_exact_where_borders_are_free():
    y, x = np.mgrid[:40, :50].astype(np.float64)
    h = 0.5 * x - 0.25 * y
    for kernel in KERNELS:
        how = {"kernel": kernel, "border_x": EXTRAPOLATE, "border_y": EXTRAPOLATE}
        ours, _ = to_height(from_height(h, vector=True, **how), ntp.VECTOR, **how)
        assert near(ours, h - h.mean(), 1e-6)


# -------------------------------------------------------------------------- telescoping


def telescoped(p, q, central, seeds):
    """Eberly's sums, one height after another."""
    h, w = p.shape
    out = np.zeros((h, w))
    step = 2 if central else 1
    for j, i in itertools.product(range(h), range(w)):
        if i < step and j < step:
            out[j, i] = seeds[i + 2 * j]
        elif j < step:
            out[j, i] = out[j, i - step] + step * p[j, i - step // 2 if central else i - 1]
        else:
            out[j, i] = out[j - step, i] + step * q[j - step // 2 if central else j - 1, i]
    return out


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("shape", [*SIZES, (20, 31), (31, 20), (64, 300)])
def test_telescoping_is_eberlys_construction(kernel, shape):
    rng = np.random.default_rng(shape)
    n = random_vectors(rng, shape)
    p, q = slopes(n, ntp.VECTOR)
    seeds = [0.5, -1.25, 2, 3]
    central = kernel == "central"
    how = {"kernel": kernel, "method": TELESCOPING}
    ours, result = to_height(n, ntp.VECTOR, use_seeds=1, seeds=seeds, **how)
    model = telescoped(p, q, central, seeds)
    assert np.array_equal(ours, model.astype(np.float32))
    assert result["method"] == TELESCOPING
    h, w = shape
    p10 = p[0, 1] if w > 1 else 0
    q01 = q[1, 0] if h > 1 else 0
    h11 = (q01 + p[1, 1] + p10 + q[1, 1]) / 2 if min(h, w) > 1 else 0
    model = telescoped(p, q, central, [0, p10, q01, h11])
    assert near(to_height(n, ntp.VECTOR, **how)[0], model - model.mean(), 1e-7)
    if central:
        for j, i in itertools.product(range(min(h, 2)), range(min(w, 2))):
            model[j::2, i::2] -= model[j::2, i::2].mean()
        assert near(to_height(n, ntp.VECTOR, equalize=1, **how)[0], model, 1e-7)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("shape", [(33, 40), (40, 33)])
def test_telescoping_recovers_consistent_heights(kernel, shape):
    rng = np.random.default_rng(3)
    h = np.round(rng.normal(size=shape) * 8) / 8
    p = h @ stencil(shape[1], kernel, EXTRAPOLATE).T
    q = stencil(shape[0], kernel, EXTRAPOLATE) @ h
    n = np.stack([-p, q, np.ones(shape)], axis=-1).astype(np.float32)  # exact, not of length 1
    seeds = [h[0, 0], h[0, 1], h[1, 0], h[1, 1]]
    ours, _ = to_height(n, ntp.VECTOR, kernel=kernel, method=TELESCOPING, use_seeds=1, seeds=seeds)
    assert np.array_equal(ours, h)


def untaken(p, q, central, heights_of, border_x, border_y, dx=1, dy=1):
    """The errors in the equations that the sums do not use, inside and across borders that wrap."""
    h, w = p.shape
    reach = 1 if central else 0
    rows = 1 + reach
    off = []
    for y, x in np.ndindex(h, w):
        inside = reach <= x < w - 1
        if (inside and y >= rows) or (not inside and border_x == WRAP and w > 1):
            slope = (heights_of[y, (x + 1) % w] - heights_of[y, x - reach]) / (rows * dx)
            off.append(abs(slope - p[y, x]))
        if not reach <= y < h - 1 and border_y == WRAP and h > 1:
            slope = (heights_of[(y + 1) % h, x] - heights_of[y - reach, x]) / (rows * dy)
            off.append(abs(slope - q[y, x]))
    return np.array(off) if off else np.zeros(1)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("borders", [*itertools.product([WRAP, CLAMP], repeat=2)])
def test_consistency_of_telescoping(kernel, borders):
    rng = np.random.default_rng(9)
    central = kernel == "central"
    how = {"kernel": kernel, "border_x": borders[0], "border_y": borders[1]}
    for shape in [*SIZES, (12, 17)]:
        n = random_vectors(rng, shape)
        p, q = slopes(n, ntp.VECTOR)
        seeds = [0.5, -1.25, 2, 3]
        spacing = {"dx": 0.5, "dy": 2.0}
        model = telescoped(p * 0.5, q * 2, central, seeds)
        ours, result = to_height(
            n, ntp.VECTOR, method=TELESCOPING, use_seeds=1, seeds=seeds, **how, **spacing
        )
        assert near(ours, model, 1e-7)
        off = untaken(p, q, central, model, *borders, **spacing)
        assert np.isclose(result["consistency"], np.sqrt(np.mean(off**2)), rtol=1e-9, atol=1e-12)
        assert np.isclose(result["consistency_max"], off.max(), rtol=1e-9, atol=1e-12)
    # Heights of which every difference is a float: nothing is off.
    h = np.round(rng.normal(size=(14, 16)) * 8) / 8
    p, q = h @ stencil(16, kernel, WRAP).T, stencil(14, kernel, WRAP) @ h
    n = np.stack([-p, q, np.ones(h.shape)], axis=-1).astype(np.float32)
    seeds = [h[0, 0], h[0, 1], h[1, 0], h[1, 1]]
    how.update(method=TELESCOPING, use_seeds=1, seeds=seeds)
    ours, result = to_height(n, ntp.VECTOR, **how)
    assert np.array_equal(ours, h)
    assert (result["consistency"], result["consistency_max"]) == (0, 0)
    n[5, 5, 0] += 1
    assert to_height(n, ntp.VECTOR, **how)[1]["consistency_max"] >= 1
    assert to_height(n, ntp.VECTOR, kernel=kernel)[1]["consistency"] == 0
