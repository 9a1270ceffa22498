# SPDX-License-Identifier: MIT
"""Weighted least squares against dense float64 matrices: every kernel, border and kind of hole."""

import itertools

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle_reconstruct as model
from support.to_height import (
    CLAMP,
    EXTRAPOLATE,
    MIRROR,
    REPEAT_SLOPE,
    WRAP,
    fractal,
    from_height,
    random_vectors,
    serial_hooks,
    slopes,
)
from support.weighted import DERIVED, KERNELS, STORED, near, weighted

NONE = 1  # NTP_PRIOR_NONE: one solution, with pairs of this strength beside slopes
STRENGTH = 1e-5


SMALL = [(1, 1), (1, 9), (9, 1), (2, 2), (3, 4), (7, 6)]


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("border_x", range(5))
def test_every_kernel_and_border(kernel, border_x):
    rng = np.random.default_rng([KERNELS.index(kernel), border_x])
    for border_y, shape in itertools.product(range(5), SMALL):
        n = random_vectors(rng, shape)
        p, q = slopes(n, ntp.VECTOR)
        how = {"kernel": kernel, "border_x": border_x, "border_y": border_y}
        how = {**how, "prior": NONE, "tolerance": 1e-12, "max_iterations": 5000}
        ours, result = weighted(n, ntp.VECTOR, **how)
        oracle = model.solve(p, q, kernel, border_x, border_y, np.zeros(shape, bool), STRENGTH)
        assert near(ours, oracle), (border_y, shape, result, ours, oracle)
        assert result["islands"] == 1 and result["holes"] == 0


@pytest.mark.parametrize("kernel", ["central", "sobel3", "gimp5"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_with_the_prior_of_the_direct_solver(kernel, dtype):
    """Where nothing is masked, pairs have no part."""
    rng = np.random.default_rng([3, KERNELS.index(kernel)])
    m = np.iinfo(dtype).max
    n = (random_vectors(rng, (11, 12)) * 0.5 + 0.5) * m
    n = np.floor(n + 0.5).astype(dtype)
    border = {"border_x": WRAP, "border_y": WRAP if kernel == "gimp5" else CLAMP}
    ours, _ = weighted(n, kernel=kernel, tolerance=1e-12, max_iterations=5000, **border)
    none = np.zeros(n.shape[:2], bool)
    oracle = model.solve(*slopes(n), kernel, *border.values(), none, 0, level=2 / m)
    assert near(ours, oracle, 1e-4)


WITHOUT_DIRECT = [
    *[("sobel3", EXTRAPOLATE), ("scharr3", REPEAT_SLOPE), ("prewitt3", EXTRAPOLATE)],
    *[("prewitt5", CLAMP), ("sobel5", CLAMP), ("gimp7", CLAMP)],
]


def has_direct(kernel, border):
    """The table of docs/reconstruction.md."""
    most = {"forward": REPEAT_SLOPE, "central": EXTRAPOLATE}
    narrow = MIRROR if kernel[-1] == "3" else WRAP
    return border <= most.get(kernel, narrow) or border == MIRROR


def off_and_error(h, kernel, border, dtype):
    """Of the direct solver and with a full mask: share of texels that differ, error."""
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    n = from_height(h, dst=dtype, **how)
    made = [weighted(n, mask=np.ones(h.shape, np.uint8), **how)[0]]
    if has_direct(kernel, border):
        made.insert(0, weighted(n, method=0, **how)[0])
    off = [np.any(from_height(v, dst=dtype, **how) != n, axis=-1).mean() for v in made]
    return off, [np.std(v - h) for v in made]


@pytest.mark.parametrize("kernel", KERNELS[:-1])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_full_mask_is_as_good_as_the_direct_solution(kernel, dtype):
    for border in filter(lambda b: has_direct(kernel, b), range(5)):
        for slope in (0.4, 1.5):
            h = fractal(160, rms_slope=slope)[:80, :74] if border else fractal(80, rms_slope=slope)
            off, errors = off_and_error(h, kernel, border, dtype)
            assert errors[1] <= 1.05 * errors[0], (border, slope)
            assert off[1] <= off[0] + 0.01, (border, slope)


@pytest.mark.parametrize(("kernel", "border"), WITHOUT_DIRECT)
def test_full_mask_where_there_is_no_direct_solution(kernel, border):
    """Pairs of neighbors, which decide first, leave no bias."""
    off, _ = off_and_error(fractal(160)[:80, :74], kernel, border, np.uint16)
    assert off[0] < 0.07


def ragged(shape, rng):
    """True where texels are used: blobs with frayed edges."""
    blobs = fractal(160, seed=7, exponent=1)[: shape[0], : shape[1]]
    return blobs > np.quantile(blobs, 0.2) + 0.01 * rng.random(shape)


@pytest.mark.parametrize(
    ("kernel", "dtype", "most"),
    [
        *[("central", np.uint8, 0.06), ("central", np.uint16, 0.06), ("sobel3", np.uint8, 0.06)],
        *[("sobel3", np.uint16, 0.08), ("scharr3", np.uint16, 0.08), ("prewitt5", np.uint16, 0.1)],
    ],
)
def test_holes_do_not_bias_the_rest(kernel, dtype, most):
    """Texels whose kernel reads no hole are fitted as well as without holes."""
    h = fractal(160)[:96, :90]
    y, x = np.mgrid[:96, :90]
    disc = (np.hypot(x - 40, y - 50) < 44) & (x != 61) & ((x - 30) ** 2 + (y - 40) ** 2 > 60)
    how = {"kernel": kernel, "border_x": CLAMP, "border_y": CLAMP}
    n = from_height(h, dst=dtype, **how)
    cases = [("ragged", ragged(h.shape, np.random.default_rng(8)))]
    if kernel != "prewitt5":
        cases.append(("disc", disc))
    for name, mask in cases:
        ours, result = weighted(n, mask=mask.astype(np.uint8), **how)
        seen, radius = mask.copy(), 2 if kernel == "prewitt5" else 1
        for shift in itertools.product(range(-radius, radius + 1), repeat=2):
            seen &= np.roll(mask, shift, (0, 1))
        seen[[0, 1, -2, -1]] = seen[:, [0, 1, -2, -1]] = False
        assert name == "ragged" or result["islands"] == 2
        off = np.any(from_height(ours, dst=dtype, **how) != n, axis=-1)[seen].mean()
        assert seen.mean() > 0.1 and off < most, (name, seen.mean(), off)


@pytest.mark.parametrize("kernel", KERNELS[:-1])
def test_holes_beside_a_full_mask(kernel):
    """Every border and depth by default: as many texels come back beside holes as without any."""
    radius = {"5": 2, "7": 3, "9": 4}.get(kernel[-1], 1)
    for border, dtype in itertools.product(range(5), (np.uint8, np.uint16)):
        side = 40 if dtype == np.uint8 else 28
        h = fractal(2 * side)[:side, : side - 3] if border else fractal(side)
        mask = np.ones(h.shape, np.uint8)
        mask[20:22, 5:8] = mask[3, 20] = 0
        how = {"kernel": kernel, "border_x": border, "border_y": border}
        n = from_height(h, dst=dtype, **how)
        seen = mask > 0
        for shift in itertools.product(range(-radius, radius + 1), repeat=2):
            seen &= np.roll(mask, shift, (0, 1)) > 0
        made = [weighted(n, mask=m, **how)[0] for m in (np.ones_like(mask), mask)]
        off = [np.any(from_height(v, dst=dtype, **how) != n, axis=-1)[seen].mean() for v in made]
        assert off[1] <= off[0] + (0.13 if radius > 2 else 0.07), (border, dtype, off)
        assert off[0] <= (0.22 if dtype == np.uint8 else 0.07), (border, dtype, off)


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
            n, ntp.VECTOR, mask=mask, tolerance=1e-9, max_iterations=5000, prior=NONE, **how
        )
        borders = (how["border_x"], how["border_y"])
        oracle = model.solve(p, q, kernel, *borders, holes, STRENGTH)
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
    """If corridors are a texel wide and form no loop, sums along them are the solution, except for
    central slopes, which skip a texel."""
    rng = np.random.default_rng(41)
    used = maze((102, 120), rng)  # at no border that wraps is there another corridor
    h = fractal(120)[:102]
    n = from_height(h, kernel, border, border)
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    ours, result = weighted(n, mask=used.astype(np.uint8), **how)
    assert result["iterations"] <= most and result["error"] <= 1e-6
    assert result["islands"] == 1 and np.all(ours[~used] == 0)
    # Along the way each height is the one before and the mean of two slopes, or the slope; about
    # so for central slopes, whose mean is no difference.
    p, q = slopes(n)
    along = used[:, :-1] & used[:, 1:], used[:-1] & used[1:]
    want = (p[:, :-1] + p[:, 1:]) / 2, (q[:-1] + q[1:]) / 2
    if kernel == "forward":
        want = p[:, :-1], q[:-1]
    got = ours[:, 1:] - ours[:, :-1], ours[1:] - ours[:-1]
    for a, b, where in zip(got, want, along, strict=True):
        off = np.abs(a - b)[where]
        assert off.max() < 1e-5 if kernel != "central" else np.median(off) < 0.025


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
    how = {"border_x": CLAMP, "border_y": CLAMP, "tolerance": 1e-10, "prior": NONE}
    for given in (mask, (mask > 0).astype(np.uint8)):
        ours, result = weighted(n, mask=given, **how)
        assert near(ours, model.solve(p, q, "central", CLAMP, CLAMP, holes, STRENGTH))
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
    assert near(ours, model.solve(p, q, "central", CLAMP, CLAMP, holes, STRENGTH))
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
        oracle = model.solve(p, q, "central", WRAP, CLAMP, none, 0, derived, 2 / 255)
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
        ({"refine": 1, "detrend": 1}, ntp.ERR_ARGUMENT),
        ({"dx": -1}, ntp.ERR_ARGUMENT),
    ]
    for how, status in wrong:
        weighted(n, status=status, **how)
    weighted(n.astype(np.float32) / 255, refine=1, status=ntp.ERR_FORMAT)
