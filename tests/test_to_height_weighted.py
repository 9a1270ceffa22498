# SPDX-License-Identifier: MIT
"""Weighted least squares against dense float64 matrices: every kernel, border and kind of hole."""

import itertools

import numpy as np
import pytest

import libntp_ffi as ntp
from support import oracle_height as heights
from support import oracle_reconstruct as model
from support.to_height import (
    CLAMP,
    EXTRAPOLATE,
    UNORM,
    WRAP,
    fractal,
    from_height,
    random_vectors,
    serial_hooks,
    slopes,
)

WEIGHTED = 4
INSIDE = 2  # NTP_RESIDUAL_INSIDE
STORED, DERIVED = 1, 2
KERNELS = [*heights.NAMES, model.BAKED]


def strength(n, kernel):
    """Of pairs of neighbors beside slopes."""
    if n.dtype == np.uint8:
        return 1e-2
    return 1e-4 if kernel == "central" else 1e-3


def weighted(src, encoding=ntp.STANDARD, y=ntp.UP, hooks=None, mask=None, status=ntp.OK, **how):
    """(heights, result as a dict)."""
    h, w = src.shape[:2]
    how["kernel"] = KERNELS.index(how.get("kernel", "central"))
    how = {"method": WEIGHTED, "decode": UNORM, "z": STORED, **how}
    chosen = ntp.ffi.new("ntp_height_options *", how)
    mask_view = ntp.ffi.NULL if mask is None else ntp.view(mask, ntp.HEIGHT, const=True)
    chosen.mask = mask_view
    size = ntp.lib.ntp_height_scratch_size(chosen, w, h, hooks.parts if hooks else 1)
    scratch = ntp.aligned(max(size, 1), 64)
    scratch[:] = 255  # NaN
    dst = np.full((h, w), np.nan, np.float32)
    result = ntp.ffi.new("ntp_height_result *")
    done = ntp.lib.ntp_height_from_normals(
        ntp.view(dst, ntp.HEIGHT),
        ntp.view(src, encoding, y, const=True),
        chosen,
        ntp.ffi.cast("void *", scratch.__array_interface__["data"][0]),
        size,
        hooks or ntp.ffi.NULL,
        result,
    )
    assert done == status
    return dst, ntp.fields(result)


def near(ours, oracle, tolerance=1e-5):
    return np.abs(ours - oracle).max() <= tolerance * max(np.ptp(oracle), 1e-3)


SMALL = [(1, 1), (1, 9), (9, 1), (2, 2), (3, 4), (7, 6)]


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("border_x", range(5))
def test_every_kernel_and_border(kernel, border_x):
    rng = np.random.default_rng([KERNELS.index(kernel), border_x])
    for border_y, shape in itertools.product(range(5), SMALL):
        n = random_vectors(rng, shape)
        p, q = slopes(n, ntp.VECTOR)
        how = {"kernel": kernel, "border_x": border_x, "border_y": border_y}
        ours, result = weighted(n, ntp.VECTOR, tolerance=1e-12, max_iterations=5000, **how)
        oracle = model.solve(
            p, q, kernel, border_x, border_y, np.zeros(shape, bool), strength(n, kernel)
        )
        assert near(ours, oracle), (border_y, shape, result, ours, oracle)
        assert result["islands"] == 1 and result["holes"] == 0


# --------------------------------------------------------------------- holes and islands


def maze(shape, rng):
    """Corridors one texel wide, with one way from each texel to each other one; True: corridor."""
    used = np.zeros(shape, bool)
    path = [(0, 0)]
    used[0, 0] = True
    while path:
        y, x = path[-1]
        ways = [(y + 2, x), (y - 2, x), (y, x + 2), (y, x - 2)]
        ways = [w for w in ways if 0 <= w[0] < shape[0] and 0 <= w[1] < shape[1] and not used[w]]
        if ways:
            to = ways[rng.integers(len(ways))]
            used[to] = used[(y + to[0]) // 2, (x + to[1]) // 2] = True
            path.append(to)
        else:
            path.pop()
    return used


def masks(shape, rng):
    """Name and holes (True) of masks of one shape."""
    h, w = shape
    y, x = np.mgrid[:h, :w]
    disc = np.hypot(x - w / 2, y - h / 2) > 0.4 * min(h, w)
    walls = (x % 5 == 2) & (y % 7 != 3)
    return {
        "noise": rng.random(shape) < 0.3,
        "disc": disc,
        "islands": (x == w // 2) | (y == 2),
        "labyrinth": walls,
        "maze": ~maze(shape, rng),
        "one texel": ~((x == 3) & (y == 4)),
    }


@pytest.mark.parametrize(
    ("kernel", "border"),
    [
        *itertools.product(["central"], range(5)),
        *itertools.product(["forward", "sobel3", model.BAKED], [WRAP, EXTRAPOLATE]),
        ("gimp5", WRAP),
    ],
)
def test_holes(kernel, border):
    rng = np.random.default_rng([KERNELS.index(kernel), border])
    shape = (11, 12)
    n = random_vectors(rng, shape, 0.7)
    p, q = slopes(n, ntp.VECTOR)
    for name, holes in masks(shape, rng).items():
        mask = np.where(holes, 0, rng.integers(1, 255, shape)).astype(np.uint8)
        how = {"kernel": kernel, "border_x": border, "border_y": (border + 2) % 5}
        ours, result = weighted(
            n, ntp.VECTOR, mask=mask, tolerance=1e-9, max_iterations=5000, **how
        )
        borders = (how["border_x"], how["border_y"])
        oracle = model.solve(p, q, kernel, *borders, holes, strength(n, kernel))
        assert near(ours, oracle, 1e-4), name
        label, count = model.islands(holes, *borders)
        assert (result["islands"], result["holes"]) == (count, holes.sum()), name
        assert np.all(ours[holes] == 0)
        for i in range(count):
            assert abs(ours[label == i].mean(dtype=np.float64)) < 1e-6 * max(np.ptp(ours), 1e-3)


@pytest.mark.parametrize(
    ("kernel", "border", "most"),
    [
        *[("forward", WRAP, 2), ("forward", CLAMP, 2), ("sobel3", WRAP, 2)],
        *[("central", WRAP, 700), ("central", CLAMP, 700)],
    ],
)
def test_mazes(kernel, border, most):
    """Where corridors are a texel wide and make no loop, sums along them are the solution; but for
    central slopes, which skip a texel."""
    rng = np.random.default_rng(41)
    used = maze((102, 120), rng)  # at no border that wraps is there another corridor
    h = fractal(120)[:102]
    n = from_height(h, kernel, border, border)
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    ours, result = weighted(n, mask=used.astype(np.uint8), **how)
    assert result["iterations"] <= most and result["error"] <= 1e-6
    assert result["islands"] == 1 and np.all(ours[~used] == 0)
    # Along the way each height is the one before and the mean of two slopes, or the slope.
    p, q = slopes(n)
    along = used[:, :-1] & used[:, 1:], used[:-1] & used[1:]
    want = (p[:, :-1] + p[:, 1:]) / 2, (q[:-1] + q[1:]) / 2
    if kernel == "forward":
        want = p[:, :-1], q[:-1]
    got = ours[:, 1:] - ours[:, :-1], ours[1:] - ours[:-1]
    for a, b, where in zip(got, want, along, strict=True):
        off = np.abs(a - b)[where]
        assert off.max() < 1e-5 if kernel != "central" else np.median(off) < 0.02


def test_what_is_a_hole():
    rng = np.random.default_rng(9)
    shape = (10, 14)
    n = np.full((*shape, 4), 255, np.uint8)
    n[..., :3] = rng.integers(90, 160, (*shape, 3))
    n[..., 2] = 230
    mask = np.full(shape, 65535, np.uint16)
    holes = np.zeros(shape, bool)
    n[2, 3], n[5, 5, :3], n[7, 8, 3] = (0, 0, 0, 255), 255, 0
    mask[1, 1] = 0
    for at in [(2, 3), (5, 5), (7, 8), (1, 1)]:
        holes[at] = True
    p, q = slopes(n)
    how = {"border_x": CLAMP, "border_y": CLAMP, "tolerance": 1e-10}
    for given in (mask, (mask > 0).astype(np.uint8)):
        ours, result = weighted(n, mask=given, **how)
        assert near(ours, model.solve(p, q, "central", CLAMP, CLAMP, holes, 1e-2))
        assert (result["holes"], result["islands"]) == (4, 1)
    assert np.array_equal(ours, weighted(n, mask=given, **{**how, "method": 0})[0])
    _, result = weighted(n, mask=mask, touch_unused=7, **how)
    assert result["holes"] == 1
    v = random_vectors(rng, shape)
    v[3, 3], v[4, 4, 0], v[5, 5] = 0, np.nan, np.inf
    ours, result = weighted(v, ntp.VECTOR, **how)
    holes[:] = False
    holes[3, 3] = holes[4, 4] = holes[5, 5] = True
    p, q = slopes(np.where(holes[..., None], np.float32(1), v), ntp.VECTOR)
    assert near(ours, model.solve(p, q, "central", CLAMP, CLAMP, holes, 1e-4))
    assert (result["holes"], result["not_finite"]) == (3, 3)


@pytest.mark.parametrize("shape", [(1, 40), (40, 1), (31, 37), (1, 1)])
@pytest.mark.parametrize("kernel", ["forward", "central", "scharr3", model.BAKED])
def test_nothing_but_holes(shape, kernel):
    n = np.full((*shape, 3), 140, np.uint8)
    ours, result = weighted(n, kernel=kernel, mask=np.zeros(shape, np.uint8))
    assert np.all(ours == 0)
    assert (result["islands"], result["holes"]) == (0, n.size // 3)


def test_derived_z_and_spacing():
    rng = np.random.default_rng(12)
    shape = (9, 8)
    n = rng.integers(70, 190, (*shape, 3)).astype(np.uint8)
    for z in (STORED, DERIVED):
        derived = z == DERIVED
        p, q = slopes(n, derived=derived)
        how = {"border_x": WRAP, "border_y": CLAMP, "tolerance": 1e-11, "z": z}
        ours, result = weighted(n, **how)
        none = np.zeros(shape, bool)
        oracle = model.solve(p, q, "central", WRAP, CLAMP, none, 1e-2, derived)
        assert near(ours, oracle)
        assert result["z"] == z
        # Twice as far apart texels with half the slopes give the same heights.
    v = random_vectors(rng, shape)
    half = v * np.array([0.5, 0.25, 1], np.float32)
    oracle_p, oracle_q = slopes(half, ntp.VECTOR)
    wp, wq = model.weights_of(oracle_p, oracle_q, False)
    ours, _ = weighted(half, ntp.VECTOR, kernel="forward", dx=2, dy=4, tolerance=1e-12)
    p, q = oracle_p * 2, oracle_q * 4
    mp, _ = model.slope_rows(shape, "forward", WRAP, WRAP, False)
    mq, _ = model.slope_rows(shape, "forward", WRAP, WRAP, True)
    root = np.sqrt(np.concatenate([wp.ravel() / 4, wq.ravel() / 16]))
    both = np.vstack([mp, mq]) * root[:, None]
    h = np.linalg.lstsq(both, np.concatenate([p.ravel(), q.ravel()]) * root, rcond=1e-12)[0]
    assert near(ours, h.reshape(shape) - h.mean())


# ------------------------------------------------------------------- iteration and hooks


def test_tolerance_is_met_or_said_not_to_be():
    n = from_height(fractal(128, rms_slope=3), kernel="forward")
    how = {"kernel": "forward"}
    exact, _ = weighted(n, tolerance=1e-12, **how)
    before = np.inf
    for tolerance in (1e-2, 1e-4, 1e-6, 1e-8):
        ours, result = weighted(n, tolerance=tolerance, **how)
        assert result["error"] <= tolerance
        off = np.abs(ours - exact).max() / np.ptp(exact)
        assert off <= max(30 * tolerance, 1e-7) and off <= before
        before = off
    ours, result = weighted(n, tolerance=1e-9, max_iterations=5, status=7, **how)
    assert result["iterations"] == 5 and result["error"] > 1e-9
    assert np.all(np.isfinite(ours))
    _, result = weighted(n, tolerance=1e-15, max_iterations=300, status=7, **how)
    assert result["error"] > 1e-15


def test_steep_texels_count_less():
    # A wall that 8 bits cannot hold leaves the ground on both sides alone.
    h = np.zeros((96, 96), np.float32)
    y, x = np.mgrid[:96, :96]
    h += 3 * np.sin(x / 9) * np.cos(y / 7)
    n = from_height(h, kernel="forward", border_x=CLAMP, border_y=CLAMP)
    n[40:50, 60] = 255, 128, 128  # slope of 127
    how = {"kernel": "forward", "border_x": CLAMP, "border_y": CLAMP}
    plain, _ = weighted(n, method=3, **how)
    ours, _ = weighted(n, **how)
    good = np.ones(h.shape, bool)
    good[38:52, 58:63] = False
    error = [np.std((v - h)[good]) for v in (plain, ours)]
    assert error[1] < error[0] / 10


@pytest.mark.parametrize("kernel", ["forward", "central", "sobel5", model.BAKED])
def test_same_bytes_for_any_number_of_parts(kernel):
    rng = np.random.default_rng(5)
    n = rng.integers(80, 180, (67, 75, 3)).astype(np.uint8)
    mask = (rng.random((67, 75)) > 0.1).astype(np.uint8)

    @ntp.ffi.callback("void(void *, int32_t, void (*)(void *, int32_t), void *)")
    def backwards(_, count, task, work):
        for i in reversed(range(count)):
            task(work, i)

    how = {"kernel": kernel, "border_x": WRAP, "border_y": CLAMP, "mask": mask, "residual_scope": 1}
    alone, facts = weighted(n, tolerance=1e-3, **how)
    for parts in (2, 7, 64):
        hooks = serial_hooks(parts, parallel_for=backwards)
        ours, result = weighted(n, hooks=hooks, tolerance=1e-3, **how)
        assert np.array_equal(ours.view(np.uint32), alone.view(np.uint32))
        assert result == facts


def test_progress_and_cancellation():
    n = from_height(fractal(64))
    shares = []

    @ntp.ffi.callback("int32_t(void *, double)")
    def progress(_, share):
        shares.append(share)
        return len(shares) == stop

    for how in ({}, {"method": 0, "refine": 3}, {"refine": 2}):
        stop = 0
        shares.clear()
        weighted(n, hooks=serial_hooks(1, progress=progress), **how)
        assert shares == sorted(shares) and 0 <= shares[0] and shares[-1] <= 1
        for stop in (1, len(shares) // 2, len(shares)):
            shares.clear()
            hooks = serial_hooks(1, progress=progress)
            weighted(n, hooks=hooks, status=ntp.ERR_CANCELLED, **how)


def test_arguments():
    n = np.full((8, 8, 3), 130, np.uint8)
    mask = np.ones((8, 8), np.uint8)
    wrong = [
        ({"mask": mask, "method": 2}, ntp.ERR_ARGUMENT),
        ({"mask": np.ones((8, 9), np.uint8)}, ntp.ERR_SHAPE),
        ({"mask": np.ones((8, 8), np.float32)}, ntp.ERR_FORMAT),
        ({"tolerance": -1}, ntp.ERR_ARGUMENT),
        ({"tolerance": np.nan}, ntp.ERR_ARGUMENT),
        ({"max_iterations": -1}, ntp.ERR_ARGUMENT),
        ({"refine": -1}, ntp.ERR_ARGUMENT),
        ({"refine": 1, "method": 1}, ntp.ERR_ARGUMENT),
        ({"refine": 1, "kernel": model.BAKED}, ntp.ERR_FORMAT),
        ({"refine": 1, "detrend": 1}, ntp.ERR_ARGUMENT),
        ({"dx": -1}, ntp.ERR_ARGUMENT),
    ]
    for how, status in wrong:
        weighted(n, status=status, **how)
    weighted(n.astype(np.float32) / 255, refine=1, status=ntp.ERR_FORMAT)


# -------------------------------------------------------------------------- round trips


@pytest.mark.parametrize("kernel", ["forward", "central", "sobel3"])
@pytest.mark.parametrize("border", [WRAP, EXTRAPOLATE])
def test_refinement(kernel, border):
    border = CLAMP if kernel == "sobel3" and border == EXTRAPOLATE else border
    h = fractal(512) if border == WRAP else fractal(1024)[:512, :512]
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    n = from_height(h, **how)
    for rounds, most in [(16, 0.006), (128, 0.0002)]:
        ours, result = weighted(n, method=0, refine=rounds, **how)
        again = from_height(ours, **how)
        left = np.any(again != n, axis=-1).sum()
        assert left <= most * h.size
        assert result["refine_left"] == left
        assert result["rounds"] == rounds or left == 0


def test_refinement_of_16_bits_and_with_a_mask():
    y, x = np.mgrid[:96, :96]
    h = (5 * np.sin(x / 8.0) * np.cos(y / 11.0) + 0.02 * x * y / 10).astype(np.float32)
    how = {"kernel": "forward", "border_x": CLAMP, "border_y": CLAMP}
    n = from_height(h, dst=np.uint16, **how)
    ours, result = weighted(n, method=0, refine=50, **how)
    again = from_height(ours, dst=np.uint16, **how)
    assert result["refine_left"] == np.any(again != n, axis=-1).sum() <= 0.01 * h.size
    mask = (np.hypot(x - 48, y - 48) < 40).astype(np.uint8)
    n = from_height(h, **how)
    plain, _ = weighted(n, mask=mask, **how)
    ours, result = weighted(n, mask=mask, refine=20, **how)

    def off(v):
        inner = np.hypot(x - 48, y - 48) < 38
        return np.any(from_height(v, **how) != n, axis=-1)[inner].mean()

    assert off(plain) > 0.01
    assert off(ours) <= 0.001


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
