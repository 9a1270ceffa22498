# SPDX-License-Identifier: MIT
"""Weighted least squares against dense float64 matrices: every kernel, border and kind of hole."""

import itertools

import numpy as np
import pytest

import libntp_ffi as ntp
import oracle_height as heights
import oracle_reconstruct as model
from test_to_height import CLAMP, EXTRAPOLATE, UNORM, WRAP, fractal, from_height
from test_to_height import random_vectors, serial_hooks, slopes, vectors_of

WEIGHTED = 4
DERIVED = 1
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
    how = {"method": WEIGHTED, "decode": UNORM, **how}
    chosen = ntp.ffi.new("ntp_height_options *", how)
    if mask is not None:
        chosen.mask = view = ntp.view(mask, ntp.HEIGHT, const=True)
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
