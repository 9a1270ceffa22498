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
    WRAP,
    fractal,
    from_height,
    slopes,
)
from support.weighted import INSIDE, weighted


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
