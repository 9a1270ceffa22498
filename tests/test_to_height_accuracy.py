# SPDX-License-Identifier: MIT
"""The accuracy of heights, compared with least squares in float64 and with fixed figures.

Fields of 512 x 512, heights in texels; errors are standard deviations over the range.  A fixed
figure is the error of float64 least squares on a field of that kind; ours may be 5 % above it.
"""

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle_height as heights
from support.to_height import (
    EXTRAPOLATE,
    UNORM,
    WRAP,
    by_eigenvectors,
    fractal,
    slopes,
    stencil,
    to_height,
    vectors_of,
)

N = 512
SLACK = 1.05
DERIVED, NEAREST = range(2)  # blue from the rounded red and green, or as it is
STORED, Z_AUTO = 1, 0
BAKED = 10
TELESCOPING = 1


def normals(h, kernel, border, dtype, blue=NEAREST):
    how = {"kernel": heights.NAMES.index(kernel), "border_x": border, "border_y": border}
    how = ntp.ffi.new("ntp_normals_options *", {**how, "scale": 1, "blue": blue})
    out = np.zeros((*h.shape, 3), dtype)
    view = ntp.view(out, ntp.VECTOR if dtype is np.float32 else ntp.STANDARD)
    src = ntp.view(h, ntp.HEIGHT, const=True)
    ntp.check(ntp.lib.ntp_normals_from_height(view, src, how, ntp.ffi.NULL, ntp.ffi.NULL))
    return out


def without_parity(h):
    """Even and odd texels get the same mean, because central slopes do not show their
    difference."""
    h = h.astype(np.float64)
    for j in (0, 1):
        for i in (0, 1):
            h[j::2, i::2] -= h[j::2, i::2].mean()
    return h


def bricks():
    """Eight courses of four bricks of unequal height with rounded edges; it tiles."""
    rng = np.random.default_rng(3)
    y, x = np.mgrid[:N, :N]
    high, wide = N // 8, N // 4
    row = y // high
    x = (x + row % 2 * (wide // 2)) % N
    u, v = x % wide, y % high
    from_edge = np.minimum(np.minimum(u, wide - u), np.minimum(v, high - v))
    t = np.clip((from_edge - 2) / 8, 0, 1)
    tops = rng.uniform(0.8, 1, (8, 4))[row, x // wide]
    return 6 * tops * t * t * (3 - 2 * t) + fractal(N, 5, 0.05)


def ramp_and_bumps():
    """It does not tile."""
    rng = np.random.default_rng(4)
    y, x = np.mgrid[:N, :N].astype(np.float64)
    h = 0.3 * x - 0.2 * y
    for _ in range(150):
        cx, cy, r = rng.uniform(0, N), rng.uniform(0, N), rng.uniform(10, 40)
        h += rng.uniform(-0.5, 0.5) * r * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (r * r))
    return h


FIELDS = {
    "fractal": (lambda: fractal(N), WRAP),
    "crop": (lambda: fractal(2 * N)[:N, :N], EXTRAPOLATE),
    "bricks": (bricks, WRAP),
    "ramp": (ramp_and_bumps, EXTRAPOLATE),
}
# 8-bit error over the range; share of texels that differ and levels, after the round trip
FIGURES = {
    ("fractal", "forward"): (2.3e-5, 0.065, 1),
    ("fractal", "central"): (4.7e-5, 0.065, 1),
    ("crop", "forward"): (2.3e-5, 0.065, 1),
    ("crop", "central"): (4.7e-5, 0.065, 1),
    ("bricks", "forward"): (3.1e-4, 0.10, 2),
    ("bricks", "central"): (4.4e-4, 0.09, 1),
    ("ramp", "forward"): (5.2e-5, 0.05, 1),
    ("ramp", "central"): (5.6e-5, 0.05, 1),
    ("fractal", "scharr3"): (3.7e-5, 0.065, 1),
    ("fractal", "sobel3"): (3.9e-5, 0.065, 1),
}


def error(ours, h):
    rest = ours.astype(np.float64) - h
    return np.std(rest) / np.ptp(h)


@pytest.fixture(scope="module")
def fields():
    return {name: (make(), border) for name, (make, border) in FIELDS.items()}


@pytest.mark.parametrize(("field", "kernel"), FIGURES)
def test_eight_bits(fields, field, kernel):
    h, border = fields[field]
    h = np.ascontiguousarray(h if kernel == "forward" else without_parity(h), np.float32)
    n = normals(h, kernel, border, np.uint8)
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    ours, _ = to_height(n, decode=UNORM, **how)
    figure, share, levels = FIGURES[field, kernel]
    assert error(ours, h) <= SLACK * figure
    again = normals(ours, kernel, border, np.uint8)
    off = np.abs(again.astype(int) - n)[..., :2].max(axis=-1)
    assert off.max() <= levels
    assert np.mean(off > 0) <= SLACK * share
    if kernel in ("forward", "central"):
        model = by_eigenvectors(*slopes(n), kernel, border, border)
        assert error(ours, h) <= SLACK * error(model, h)
        # What float arithmetic adds is nothing beside the rounding of 8 bits.
        assert np.abs(ours - model).max() <= 1e-6 * np.ptp(h)


@pytest.mark.parametrize("kernel", ["forward", "central"])
@pytest.mark.parametrize("border", [WRAP, EXTRAPOLATE])
def test_a_level_at_most_with_derived_blue(kernel, border):
    """The defaults of from-height and to-height.  Derived blue adds no information to red and
    green: slopes beyond 53 degrees are less accurate, at the edges and elsewhere."""
    for seed in (1, 4):
        h = fractal(N, seed) if border == WRAP else fractal(2 * N, seed)[:N, :N]
        h = np.ascontiguousarray(h if kernel == "forward" else without_parity(h), np.float32)
        n = normals(h, kernel, border, np.uint8, DERIVED)
        for z in (STORED, Z_AUTO):
            ours, _ = to_height(n, kernel=kernel, border_x=border, border_y=border, z=z)
            again = normals(ours, kernel, border, np.uint8, DERIVED)
            off = np.abs(again.astype(int) - n)[..., :2].max(axis=-1)
            assert off.max() <= 2
            assert np.count_nonzero(off == 2) <= 4
            assert np.all(n[off == 2, 2] < 204)
            assert np.mean(off > 0) <= 0.065


def test_extrapolated_edges_cost_next_to_nothing(fields):
    """The sum of squares, with full weights at the edges, compared with the minimum."""
    h = np.ascontiguousarray(fields["ramp"][0][:200, :160], np.float32)
    n = normals(h, "central", EXTRAPOLATE, np.uint8)
    ours, _ = to_height(n, decode=UNORM, border_x=EXTRAPOLATE, border_y=EXTRAPOLATE)
    p, q = slopes(n)
    dx, dy = (stencil(m, "central", EXTRAPOLATE) for m in h.shape[::-1])
    lx, vx = np.linalg.eigh(dx.T @ dx)
    ly, vy = np.linalg.eigh(dy.T @ dy)
    total = ly[:, None] + lx[None, :]
    f = vy.T @ (p @ dx + dy.T @ q) @ vx
    best = vy @ np.where(total < 1e-11, 0, f / np.maximum(total, 1e-11)) @ vx.T
    squares = [np.sum((v @ dx.T - p) ** 2) + np.sum((dy @ v - q) ** 2) for v in (ours, best)]
    assert squares[1] <= squares[0] <= 1.002 * squares[1]
    quarter = by_eigenvectors(p, q, "central", EXTRAPOLATE, EXTRAPOLATE, edges=False)
    assert np.sum((quarter @ dx.T - p) ** 2) + np.sum((dy @ quarter - q) ** 2) > 1.008 * squares[1]


@pytest.mark.parametrize(("field", "kernel"), [k for k in FIGURES if k[0] != "bricks"][:6])
def test_sixteen_bits_and_floats(fields, field, kernel):
    h, border = fields[field]
    h = np.ascontiguousarray(h if kernel == "forward" else without_parity(h), np.float32)
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    ours, _ = to_height(normals(h, kernel, border, np.uint16), **how)
    assert error(ours, h) <= 1e-6
    ours, _ = to_height(normals(h, kernel, border, np.float32), ntp.VECTOR, **how)
    assert error(ours, h) <= 1e-7


def test_sums_drift_and_seeds_make_a_checkerboard(fields):
    """Why least squares is the default."""
    h, border = fields["fractal"]
    seen = np.ascontiguousarray(without_parity(h), np.float32)
    n = normals(seen, "central", border, np.float32)
    how = {"kernel": "central", "method": TELESCOPING}
    by_rule, _ = to_height(n, ntp.VECTOR, **how)
    equal, facts = to_height(n, ntp.VECTOR, equalize=1, **how)
    # The mean of neighbors is off by what is between texels; with equal means of even and odd
    # texels heights come back.
    assert np.std(by_rule - seen) > 100 * np.std(equal - seen)
    assert np.std(without_parity(by_rule) - seen) < 1e-4
    assert np.std(equal - seen) < 1e-4
    assert facts["consistency"] < 1e-6
    for kernel, field in [("forward", h), ("central", seen)]:
        field = np.ascontiguousarray(field, np.float32)
        n = normals(field, kernel, border, np.uint8)
        how = {"kernel": kernel, "decode": UNORM}
        sums, facts = to_height(n, method=TELESCOPING, equalize=1, **how)
        least, _ = to_height(n, **how)
        assert error(sums, field) > 8 * error(least, field)
        assert 0.002 < facts["consistency"] < 0.2


def test_baked_bumps():
    rng = np.random.default_rng(6)
    y, x = np.mgrid[:N, :N].astype(np.float64)
    h, p, q = np.zeros((3, N, N))
    for _ in range(40):
        cx, cy, r = rng.uniform(0, N), rng.uniform(0, N), rng.uniform(20, 45)
        u, v = (x - cx + N / 2) % N - N / 2, (y - cy + N / 2) % N - N / 2
        bump = rng.uniform(-1, 1) * r * np.exp(-(u * u + v * v) / (r * r))
        h += bump
        p -= 2 * u / (r * r) * bump
        q -= 2 * v / (r * r) * bump
    n = vectors_of(p, q)
    ours, _ = to_height(n, ntp.VECTOR, kernel=BAKED)
    assert np.std(ours - h) <= SLACK * 8.4e-6
    levels = np.floor((n.astype(np.float64) + 1) * 127.5 + 0.5).astype(np.uint8)
    ours, _ = to_height(levels, decode=UNORM, kernel=BAKED)
    assert np.std(ours - h) <= SLACK * 0.0123
    shifted, _ = to_height(n, ntp.VECTOR, kernel="forward")
    assert np.std(shifted - h) > 0.1
