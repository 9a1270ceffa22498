# SPDX-License-Identifier: MIT
"""Weighted least squares: how far normals of the heights are from those given, and known surfaces."""

import itertools

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle_reconstruct as model
from support.to_height import (
    CLAMP,
    EXTRAPOLATE,
    MIRROR,
    SNORM,
    TRUNC,
    UNORM,
    WRAP,
    bricks,
    bumps,
    fractal,
    from_height,
    serial_hooks,
    slopes,
)
from support.weighted import DERIVED, INSIDE, INSIDE_X, INSIDE_Y, weighted

# Kernel, border on both axes, and the rounds after which no texel differs.
GENTLE = [
    ("forward", WRAP, 7),
    ("central", WRAP, 5),
    ("sobel3", WRAP, 6),
    ("forward", EXTRAPOLATE, 8),
    ("central", EXTRAPOLATE, 7),
    ("central", MIRROR, 6),
    ("sobel3", CLAMP, 5),
    # Slopes at the mirrored ends are 0 to the last bit, at the edge of the box of 128.
    ("prewitt5", MIRROR, 12),
    ("gimp7", MIRROR, 30),
]


@pytest.mark.parametrize(("kernel", "border", "most"), GENTLE)
def test_refinement_returns_every_texel(kernel, border, most):
    h = fractal(96) if border == WRAP else fractal(160)[:96, :90]
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    n = from_height(h, **how)
    plain, _ = weighted(n, method=0, z=DERIVED, **how)
    ours, result = weighted(n, method=0, z=DERIVED, refine=most, **how)
    assert np.any(from_height(plain, **how) != n, axis=-1).mean() > 0.02
    assert np.array_equal(from_height(ours, **how), n)
    assert result["refine_left"] == 0 and 0 < result["rounds"] <= most
    assert np.std(ours - h) <= np.std(plain - h)
    assert abs(ours.mean(dtype=float)) < 1e-6 * np.ptp(h)


@pytest.mark.parametrize(("kernel", "most"), [("forward", 25), ("central", 32), ("sobel3", 25)])
def test_refinement_of_steep_ground(kernel, most):
    """Slopes of 62 degrees (rms): the best fit makes a third of the texels anew."""
    h = fractal(96, rms_slope=1.9)
    how = {"kernel": kernel, "border_x": WRAP, "border_y": WRAP}
    n = from_height(h, **how)
    plain, _ = weighted(n, method=0, z=DERIVED, **how)
    ours, result = weighted(n, method=0, z=DERIVED, refine=most, **how)
    assert np.any(from_height(plain, **how) != n, axis=-1).mean() > 0.25
    assert np.array_equal(from_height(ours, **how), n) and result["refine_left"] == 0
    assert np.std(ours - h) <= 0.9 * np.std(plain - h)


@pytest.mark.parametrize("kernel", ["sobel3", "scharr3", "prewitt5", "gimp7"])
@pytest.mark.parametrize("slope", [0.2, 0.7])
def test_refined_heights_of_wide_kernels_are_no_worse(kernel, slope):
    """Also in the finest detail, to which the kernel hardly responds."""
    h = fractal(96, rms_slope=slope)
    how = {"kernel": kernel, "border_x": WRAP, "border_y": WRAP}
    n = from_height(h, **how)
    plain, _ = weighted(n, method=0, z=DERIVED, **how)
    ours, result = weighted(n, method=0, z=DERIVED, refine=30, **how)
    assert result["refine_left"] == 0 and np.std(ours - h) <= np.std(plain - h)


# Surface, kernel, border, which way green points, and the texels that may differ in the end.
FLAT = [
    (bricks, "forward", WRAP, ntp.UP, 0),
    (bricks, "central", WRAP, ntp.UP, 0),
    (bricks, "central", WRAP, ntp.DOWN, 0),
    (bricks, "sobel3", WRAP, ntp.UP, 0),
    (bricks, "central", CLAMP, ntp.UP, 0),
    (bumps, "forward", WRAP, ntp.UP, 0),
    (bumps, "central", WRAP, ntp.UP, 0),
    (bumps, "central", WRAP, ntp.DOWN, 0),
    (bumps, "sobel3", WRAP, ntp.UP, 0),
    (bumps, "central", CLAMP, ntp.UP, 0),
]


@pytest.mark.parametrize(("surface", "kernel", "border", "y", "most"), FLAT)
def test_refinement_of_flat_ground(surface, kernel, border, y, most):
    """Level 128 begins at slope 0, so that nothing but equal heights gives flat ground again."""

    def texture(heights):
        if y == ntp.UP:
            return from_height(heights, **how)
        return from_height(heights[::-1], **how)[::-1]

    h = surface(96)
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    n = np.ascontiguousarray(texture(h))
    plain, _ = weighted(n, method=0, z=DERIVED, y=y, **how)
    ours, result = weighted(n, method=0, z=DERIVED, y=y, refine=120, **how)
    off = np.any(texture(ours) != n, axis=-1)
    assert not np.array_equal(texture(plain), n)
    assert off.sum() == result["refine_left"] <= most
    assert np.std(ours - h) <= np.std(plain - h)


# Many bumps, whose feet are partly as flat as the ground in levels; and 16-bit bricks, whose corners
# a kernel of 3 x 3 smooths.
MANY = [
    (bumps(240, 32), "forward", WRAP, np.uint8),
    (bumps(240, 32), "central", WRAP, np.uint8),
    (bumps(240, 32), "central", WRAP, np.uint16),
    (bumps(240, 32), "sobel3", MIRROR, np.uint8),
    (bumps(160, 14), "scharr3", WRAP, np.uint8),
    (bumps(160, 14), "scharr3", CLAMP, np.uint8),
    (bricks(240), "sobel3", WRAP, np.uint16),
]


@pytest.mark.parametrize(("h", "kernel", "border", "dtype"), MANY)
def test_refinement_frees_what_was_no_flat_ground(h, kernel, border, dtype):
    h = h.astype(np.float32)
    if border != WRAP:
        h = np.ascontiguousarray(h[3:-5, 7:-9])
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    n = from_height(h, dst=dtype, **how)
    plain, _ = weighted(n, method=0, z=DERIVED, **how)
    ours, result = weighted(n, method=0, z=DERIVED, refine=150, **how)
    assert np.array_equal(from_height(ours, dst=dtype, **how), n) and result["refine_left"] == 0
    assert np.std(ours - h) <= np.std(plain - h)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("y", [ntp.UP, ntp.DOWN])
def test_refinement_returns_nearest_blue_as_well(dtype, y):
    """Where blue was rounded by itself it is a measurement too."""
    m = np.iinfo(dtype).max
    h = fractal(64, rms_slope=0.5).astype(np.float64)
    how = {"kernel": "central", "border_x": WRAP, "border_y": WRAP}

    def made_of(h):
        p, q = (np.roll(h, -1, a) / 2 - np.roll(h, 1, a) / 2 for a in (1, 0))
        n = np.stack([-p, q if y == ntp.UP else -q, np.ones_like(p)], -1)
        return np.floor((n / np.linalg.norm(n, axis=-1, keepdims=True) + 1) / 2 * m + 0.5)

    n = made_of(h).astype(dtype)
    plain, _ = weighted(n, method=0, y=y, **how)
    ours, result = weighted(n, method=0, y=y, refine=100, **how)
    assert np.any(made_of(plain.astype(np.float64)) != n, axis=-1).mean() > 0.02
    assert np.array_equal(made_of(ours.astype(np.float64)), n) and result["refine_left"] == 0


@pytest.mark.parametrize("slope", [0.1, 0.4])
def test_nearest_blue_makes_gentle_heights_no_worse(slope):
    h = fractal(96, rms_slope=slope, exponent=3).astype(np.float64)
    p, q = (np.roll(h, -1, a) / 2 - np.roll(h, 1, a) / 2 for a in (1, 0))
    v = np.stack([-p, q, np.ones_like(p)], -1)
    n = np.floor((v / np.linalg.norm(v, axis=-1, keepdims=True) + 1) * 127.5 + 0.5).astype(np.uint8)
    how = {"kernel": "central", "border_x": WRAP, "border_y": WRAP}
    plain, _ = weighted(n, method=0, **how)
    ours, result = weighted(n, method=0, refine=80, **how)
    assert result["refine_left"] == 0 and np.std(ours - h) <= np.std(plain - h)


def surface(size, seed, tiles):
    """Sums of waves with their slopes to the right and down, which are exact."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:size, :size] * (2 * np.pi / size)
    h, p, q = np.zeros((3, size, size))
    for _ in range(30):
        a, b = rng.integers(-8, 9, 2) if tiles else rng.uniform(-8, 8, 2)
        wave = a * x + b * y + rng.uniform(0, 7)
        size_of = rng.normal() * size / 20 / (1 + np.hypot(a, b)) ** 1.6
        h += size_of * np.cos(wave)
        p -= size_of * np.sin(wave) * a * 2 * np.pi / size
        q -= size_of * np.sin(wave) * b * 2 * np.pi / size
    return h, p, q


def differentiated(h, wrap):
    """The slope along the last axis of the polynomial through the nine nearest heights."""
    n, at = h.shape[-1], np.arange(h.shape[-1])
    first = at - 4 if wrap else np.clip(at - 4, 0, n - 9)
    slope = np.zeros_like(h, dtype=np.float64)
    for i in range(n):
        k = np.arange(first[i], first[i] + 9) - i
        basis = np.linalg.solve(np.vander(k, increasing=True).T.astype(float), np.eye(9)[1])
        slope[..., i] = h[..., (k + i) % n] @ basis
    return slope


@pytest.mark.parametrize("border", [WRAP, CLAMP])
@pytest.mark.parametrize("masked", [False, True])
def test_refinement_of_baked_normals(border, masked):
    h, p, q = surface(64, 2, border == WRAP)
    v = np.stack([-p, q, np.ones_like(p)], -1)
    n = np.floor((v / np.linalg.norm(v, axis=-1, keepdims=True) + 1) * 127.5 + 0.5).astype(np.uint8)
    how = {"kernel": "baked", "border_x": border, "border_y": border, "z": DERIVED}
    seen = np.ones(h.shape, bool)
    if masked:
        seen[:, :9] = False
        how["mask"] = seen.astype(np.uint8)
    else:
        how["method"] = 0
    plain, _ = weighted(n, **how)
    ours, result = weighted(n, refine=120, **how)
    once = weighted(n, refine=1, **how)[1]["refine_left"]
    assert result["refine_left"] <= 4 < once
    errors = [np.std((made - h)[seen]) for made in (plain, ours)]
    assert errors[1] <= errors[0]
    if masked:
        return
    made = ours.astype(np.float64)
    p, q = differentiated(made, border == WRAP), differentiated(made.T, border == WRAP).T
    length = np.sqrt(1 + p * p + q * q)
    again = np.floor((np.stack([-p, q], -1) / length[..., None] + 1) * 127.5 + 0.5)
    assert np.any(again != n[..., :2], axis=-1).sum() == result["refine_left"]


def levels_of(h, kernel, border, decode, m):
    """Red and green of the normals of heights, by dense matrices, before rounding."""
    p, q = (
        (model.slope_rows(h.shape, kernel, border, border, down)[0] @ h.ravel()).reshape(h.shape)
        for down in (False, True)
    )
    n = np.stack([-p, q], -1) / np.sqrt(1 + p * p + q * q)[..., None]
    zero, span = {UNORM: (m, m), TRUNC: (m - 1, m), SNORM: (m + 1, m - 1)}[decode]
    return (n * span + zero) / 2


@pytest.mark.parametrize("kernel", ["forward", "scharr3", "gimp5"])
@pytest.mark.parametrize("decode", [UNORM, TRUNC, SNORM])
def test_texels_left_are_counted_right(kernel, decode):
    """Also where no heights fit: noise.  Every level is that of the decoding rule."""
    rng = np.random.default_rng([1, decode])
    n = rng.integers(100, 156, (14, 17, 3)).astype(np.uint8)
    n[..., 2] = 250
    n[3, 5] = 0  # unused, which counts as flat
    border = MIRROR if kernel == "gimp5" else CLAMP
    how = {"kernel": kernel, "border_x": border, "border_y": border, "decode": decode}
    ours, result = weighted(n, method=0, refine=12, z=DERIVED, **how)
    at = levels_of(ours.astype(np.float64), kernel, border, decode, 255)
    again = np.floor(at + 0.5)
    off = np.any(again != n[..., :2], axis=-1)
    off[3, 5] = False
    assert result["refine_left"] == off.sum() > 0
    plain, _ = weighted(n, method=0, z=DERIVED, **how)
    before = np.floor(levels_of(plain.astype(np.float64), kernel, border, decode, 255) + 0.5)
    assert off.sum() < np.any(before != n[..., :2], axis=-1).sum()


def test_refinement_of_texels_that_are_not_square():
    h = fractal(64)
    how = {"kernel": "central", "border_x": WRAP, "border_y": WRAP}
    n = from_height(h, **how)  # of heights per texel: per unit they are twice as steep across
    p, q = (np.roll(h, -1, a) / 2 - np.roll(h, 1, a) / 2 for a in (1, 0))
    v = np.stack([-p / 0.5, q / 3, np.ones_like(p)], -1)
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    n = np.floor((v + 1) / 2 * 255 + 0.5).astype(np.uint8)
    ours, result = weighted(n, method=0, refine=60, dx=0.5, dy=3, **how)
    assert result["refine_left"] == 0
    assert np.std(ours - h) < 0.01 * np.std(h)


@pytest.mark.parametrize("kernel", ["forward", "central"])
def test_refinement_of_16_bits(kernel):
    y, x = np.mgrid[:96, :96]
    h = (5 * np.sin(x / 8.0) * np.cos(y / 11.0) + 0.02 * x * y / 10).astype(np.float32)
    how = {"kernel": kernel, "border_x": CLAMP, "border_y": CLAMP}
    n = from_height(h, dst=np.uint16, **how)
    ours, result = weighted(n, method=0, refine=50, z=DERIVED, **how)
    assert np.array_equal(from_height(ours, dst=np.uint16, **how), n)
    assert result["refine_left"] == 0


@pytest.mark.parametrize("kernel", ["forward", "central", "sobel3"])
def test_refinement_with_holes(kernel):
    """Texels whose kernel reads no hole come back; islands keep the mean 0, holes the height 0."""
    y, x = np.mgrid[:96, :96]
    h = 5 * np.sin(x / 8.0) * np.cos(y / 11.0) + 0.02 * x * y / 10
    mask = (np.hypot(x - 48, y - 48) < 40) & (np.abs(x - y) > 2) & (x % 29 > 0)
    how = {"kernel": kernel, "border_x": CLAMP, "border_y": CLAMP}
    n = from_height(h.astype(np.float32), **how)
    given = {"mask": mask.astype(np.uint8), "z": DERIVED, **how}
    plain, _ = weighted(n, **given)
    ours, result = weighted(n, refine=40, **given)
    seen = mask.copy()
    for offset in itertools.product((-1, 0, 1), (-1, 0, 1)):
        seen &= np.roll(mask, offset, (0, 1))

    def off(v):
        return np.any(from_height(v, **how) != n, axis=-1)[seen]

    assert off(plain).mean() > 0.005
    assert not off(ours).any() and result["refine_left"] == 0
    label = model.islands(~mask, CLAMP, CLAMP)[0]
    means = [ours[label == i].mean(dtype=float) for i in range(label.max() + 1)]
    assert len(means) == result["islands"] > 4 and np.abs(means).max() < 1e-6
    assert not ours[~mask].any()


def test_parts_do_not_change_refined_heights():
    n = from_height(fractal(80, rms_slope=1.5))
    one, _ = weighted(n, method=0, refine=12)
    two, _ = weighted(n, method=0, refine=12, hooks=serial_hooks(2))
    five, _ = weighted(n, method=0, refine=12, hooks=serial_hooks(5))
    assert one.tobytes() == two.tobytes() == five.tobytes()


def test_cancelled_refinement_keeps_the_best():
    """dst and the result are those of the best round so far."""
    n = from_height(fractal(64, rms_slope=1.9))
    calls = []

    @ntp.ffi.callback("int32_t(void *, double)")
    def progress(_, share):
        calls.append(share)
        return share > 0.12  # within the rounds, as the solution is the first 1/101

    hooks = serial_hooks(1, progress=progress)
    cut, cut_result = weighted(n, method=0, refine=100, hooks=hooks, status=ntp.ERR_CANCELLED)
    full, result = weighted(n, method=0, refine=cut_result["rounds"])
    assert 5 < cut_result["rounds"] < 20 and cut_result["method"] != 0
    assert cut_result["refine_left"] == result["refine_left"] and cut.tobytes() == full.tobytes()
    # Before the rounds there is nothing to keep.
    stop = ntp.ffi.callback("int32_t(void *, double)", lambda *_: 1)
    hooks = serial_hooks(1, progress=stop)
    _, nothing = weighted(n, method=0, refine=100, hooks=hooks, status=ntp.ERR_CANCELLED)
    assert nothing["method"] == 0


def test_residual_is_that_of_the_normals():
    rng = np.random.default_rng(4)
    for kernel, border, dtype in itertools.product(
        ["forward", "central", "scharr3"], [WRAP, CLAMP, EXTRAPOLATE], [np.uint8, np.uint16]
    ):
        if kernel == "scharr3" and border == EXTRAPOLATE:
            continue
        m = np.iinfo(dtype).max
        n = rng.integers(m // 3, 2 * m // 3, (20, 23, 3)).astype(dtype)
        n[..., 2] = 4 * (m // 5)
        n[3, 4] = 0
        how = {"kernel": kernel, "border_x": border, "border_y": border}
        ours, result = weighted(n, method=0, residual_scope=1, **how)
        p, q = slopes(n)
        p2 = model.slope_rows((20, 23), kernel, border, border, False)[0] @ ours.ravel()
        q2 = model.slope_rows((20, 23), kernel, border, border, True)[0] @ ours.ravel()
        used = np.ones((20, 23), bool)
        used[3, 4] = False
        a = vectors(p, q)[used]
        b = vectors(p2.reshape(20, 23), q2.reshape(20, 23))[used]
        rms = np.sqrt(np.mean((a - b)[:, :2] ** 2)) * m / 2
        assert abs(result["residual"] - rms) <= 1e-4 * rms

        inside = np.zeros((20, 23), bool)
        first = 0 if kernel == "forward" else 1
        first, last = (3, -3) if (kernel, border) == ("central", EXTRAPOLATE) else (first, -1)
        inside[first:last, first:last] = True
        a = vectors(p, q)[used & inside]
        b = vectors(p2.reshape(20, 23), q2.reshape(20, 23))[used & inside]
        rms = np.sqrt(np.mean((a - b)[:, :2] ** 2)) * m / 2
        found = weighted(n, method=0, residual_scope=INSIDE, **how)[1]["residual"]
        assert abs(found - rms) <= 1e-4 * rms
        for scope, turned in ((INSIDE_X, False), (INSIDE_Y, True)):
            lines = np.zeros((23, 20) if not turned else (20, 23), bool)
            lines[0 if kernel == "forward" else 1 : -1] = True
            seen = used & (lines if turned else lines.T)
            a = vectors(p, q)[seen]
            b = vectors(p2.reshape(20, 23), q2.reshape(20, 23))[seen]
            rms = np.sqrt(np.mean((a - b)[:, :2] ** 2)) * m / 2
            found = weighted(n, method=0, residual_scope=scope, **how)[1]["residual"]
            assert abs(found - rms) <= 1e-4 * rms
    assert weighted(n, method=0)[1]["residual"] == -1


@pytest.mark.parametrize("shape", [(127, 40), (130, 40), (131, 40), (700, 40)])
def test_residual_inside_is_of_128_rows(shape):
    """Those that are spread evenly: floor(k rows / 128)."""
    rng = np.random.default_rng(9)
    n = rng.integers(90, 165, (*shape, 3)).astype(np.uint8)
    n[..., 2] = 240
    ours, result = weighted(n, method=0, residual_scope=INSIDE, border_x=CLAMP, border_y=CLAMP)
    a = vectors(*slopes(n))
    p2 = (ours[1:-1, 2:] - ours[1:-1, :-2]) / 2
    q2 = (ours[2:, 1:-1] - ours[:-2, 1:-1]) / 2
    square = ((a[1:-1, 1:-1] - vectors(p2, q2))[..., :2] ** 2).mean((1, 2))
    rows = shape[0] - 2
    seen = [y for y in range(rows) if rows <= 128 or y * 128 % rows < 128]
    assert len(seen) == min(rows, 128)
    rms = np.sqrt(square[seen].mean()) * 255 / 2
    assert abs(result["residual"] - rms) <= 1e-4 * rms


def test_residual_of_nothing():
    n = np.full((1, 9, 3), (128, 128, 255), np.uint8)
    assert weighted(n, method=0, residual_scope=INSIDE)[1]["residual"] == -1
    black = np.zeros((9, 9, 3), np.uint8)
    for scope in (1, INSIDE):
        assert weighted(black, method=0, residual_scope=scope)[1]["residual"] == -1


def vectors(p, q):
    n = np.stack([-p, q, np.ones_like(p)], axis=-1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


# ------------------------------------------------------------------------------- surfaces


def hemisphere(size=512, share=0.45):
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    r = share * size
    inside = np.hypot(x, y) < r
    h = np.sqrt(np.maximum(r * r - x * x - y * y, 0))
    n = np.stack([x / r, -y / r, h / r], axis=-1)
    n[~inside] = 0, 0, 1
    return h, n, inside


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_hemisphere_with_a_mask(dtype):
    h, n, inside = hemisphere()
    inside &= n[..., 2] >= 0.1
    m = np.iinfo(dtype).max
    levels = np.floor((n + 1) / 2 * m + 0.5).astype(dtype)
    how = {"kernel": model.BAKED, "border_x": CLAMP, "border_y": CLAMP}
    ours, result = weighted(levels, mask=inside.astype(np.uint8), **how)
    assert result["islands"] == 1
    error = (ours - h)[inside]
    assert np.std(error) <= 1.05 * 0.016


def test_detrending():
    y, x = np.mgrid[:40, :60]
    h = (2 * np.sin(x / 6.0) * np.cos(y / 5.0) + 0.1 * x - 0.07 * y).astype(np.float32)
    n = from_height(h, kernel="forward", border_x=CLAMP, border_y=CLAMP, vector=True)
    mask = np.ones(h.shape, np.uint8)
    mask[:, 30:32] = 0
    mask[:9, :20] = 0
    how = {"kernel": "forward", "border_x": CLAMP, "border_y": CLAMP}
    for given in (None, mask):
        more = {"method": 0} if given is None else {"mask": given}
        plain, _ = weighted(n, ntp.VECTOR, **how, **more)
        ours, result = weighted(n, ntp.VECTOR, detrend=1, **how, **more)
        used = mask > 0 if given is not None else np.ones(h.shape, bool)
        label = model.islands(~used, CLAMP, CLAMP)[0]
        sides = [label == i for i in range(label.max() + 1)]
        columns = [x[used] * 1.0, y[used] * 1.0] + [s[used] * 1.0 for s in sides]
        fit = np.linalg.lstsq(np.stack(columns, 1), plain[used].astype(np.float64), rcond=None)[0]
        assert np.allclose([result["trend_x"], result["trend_y"]], fit[:2], atol=1e-6)
        model_h = plain[used] - np.stack(columns, 1) @ fit
        assert np.abs(ours[used] - model_h).max() < 1e-4
    wrapped = {**how, "border_x": WRAP}
    _, result = weighted(n, ntp.VECTOR, detrend=1, **wrapped)
    assert result["trend_x"] == 0 and result["trend_y"] != 0
