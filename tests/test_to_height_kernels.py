# SPDX-License-Identifier: MIT
"""Normals -> heightfield with kernels of 3 x 3 and more, mirrored borders, baked normals, spacing.

The model writes the normal equations as one dense matrix, from the taps and borders of
oracle_height.  If a border mirrors heights about a texel, the texels at the edge count half.
"""

import functools

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle_height as heights
from support.to_height import (
    CLAMP,
    EXTRAPOLATE,
    MIRROR,
    REPEAT_SLOPE,
    WRAP,
    by_eigenvectors,
    fractal,
    near,
    random_vectors,
    slopes,
    to_height,
    vectors_of,
)

SMALL = ["prewitt3", "sobel3", "scharr3"]
WIDE = ["prewitt5", "sobel5", "gimp5", "gimp7", "gimp9"]
NO_PRIOR, ROUGHNESS = 1, 2
BAKED = 10
SHAPES = [(1, 1), (1, 5), (2, 2), (4, 7), (9, 6)]


def rows_down(name):
    """The taps of the slope down the picture, from those of the slope up."""
    return {at: -weight for at, weight in heights.taps(name, True).items()}


@functools.cache
def matrix_of(kernel, down, shape, borders):
    """For borders that map to one texel: wrap, clamp, mirror."""
    h, w = shape
    taps = rows_down(kernel) if down else heights.taps(kernel, False)
    out = np.zeros((h * w, h * w))
    at = np.arange(h * w).reshape(h, w)
    for (i, j), weight in taps.items():
        columns = [heights.reflect(x + i, w, borders[0])[0][0] for x in range(w)]
        rows = [heights.reflect(y + j, h, borders[1])[0][0] for y in range(h)]
        out[at.ravel(), at[np.ix_(rows, columns)].ravel()] += weight
    return out


def edge_weights(n, border):
    weight = np.ones(n)
    if border == MIRROR and n > 1:
        weight[[0, -1]] = 0.5
    return weight


def roughness(n, border):
    """The negative second difference along an axis."""
    out = np.zeros((n, n))
    for i in range(n):
        for at, weight in [(i, 2), (i - 1, -1), (i + 1, -1)]:
            for index, share in heights.reflect(at, n, border):
                out[i, index] += weight * share
    return out


def least_squares(p, q, kernel, borders, bits, prior=True):
    """(A + e L^2 + t L^2/A) h = f, in the eigenvectors that A and L share."""
    h, w = shape = p.shape
    denominator = heights.KERNELS[kernel][1]
    right = matrix_of(kernel, False, shape, borders) / denominator
    down = matrix_of(kernel, True, shape, borders) / denominator
    weight = np.kron(edge_weights(h, borders[1]), edge_weights(w, borders[0]))
    root = np.sqrt(weight)
    f = (right.T @ (weight * p.ravel()) + down.T @ (weight * q.ravel())) / root
    a = right.T @ (weight[:, None] * right) + down.T @ (weight[:, None] * down)
    rough = np.kron(np.eye(h), roughness(w, borders[0]))
    rough += np.kron(roughness(h, borders[1]), np.eye(w))
    a = a / root[:, None] / root[None, :]
    rough = root[:, None] * rough / root[None, :]
    _, v = np.linalg.eigh(a + 0.1234567 * rough)
    seen = np.einsum("ij,ik,kj->j", v, a, v)
    square = np.einsum("ij,ik,kj->j", v, rough, v) ** 2
    sigma = (2.0**-23 if bits == 24 else 2 / (2**bits - 1)) / np.sqrt(12)
    mean = np.mean((f / root) ** 2)
    e = sigma**2 / mean if prior and mean > 0 else 0
    t = 2.0**-44 if bits == 8 else 2.0**-48
    null = seen < 1e-12
    seen = np.where(null, 1, seen)
    spectrum = np.where(null, 0, (v.T @ f) / (seen + e * square + t * square / seen))
    return ((v @ spectrum) / root).reshape(shape)


@pytest.mark.parametrize("kernel", SMALL + WIDE)
@pytest.mark.parametrize("border_x", [WRAP, CLAMP, MIRROR])
@pytest.mark.parametrize("border_y", [WRAP, CLAMP, MIRROR])
def test_kernels_of_two_dimensions(kernel, border_x, border_y):
    borders = {"border_x": border_x, "border_y": border_y}
    rng = np.random.default_rng(11)
    if kernel in WIDE and CLAMP in (border_x, border_y):
        with pytest.raises(ntp.NtpError) as error:
            to_height(random_vectors(rng, (9, 9)), ntp.VECTOR, kernel=kernel, **borders)
        assert error.value.status == ntp.ERR_FORMAT
        return
    for shape in SHAPES:
        n = random_vectors(rng, shape, 0.5)
        # Past what floats tell apart there is nothing to compare: no exact null modes but 0.
        model = least_squares(*slopes(n, ntp.VECTOR), kernel, (border_x, border_y), 24)
        ours, _ = to_height(n, ntp.VECTOR, kernel=kernel, **borders)
        assert near(ours, model, 2e-5), shape
        levels = rng.integers(90, 166, (*shape, 3)).astype(np.uint8)
        levels[..., 2] = 250
        model = least_squares(*slopes(levels), kernel, (border_x, border_y), 8)
        ours, _ = to_height(levels, kernel=kernel, decode=1, **borders)
        assert near(ours, model, 2e-5), shape


@pytest.mark.parametrize("kernel", SMALL + WIDE)
def test_without_a_prior_only_the_digits_of_floats_limit_detail(kernel):
    rng = np.random.default_rng(14)
    for shape in SHAPES:
        n = rng.integers(90, 166, (*shape, 3)).astype(np.uint8)
        n[..., 2] = 250
        model = least_squares(*slopes(n), kernel, (MIRROR, WRAP), 8, prior=False)
        ours, _ = to_height(n, kernel=kernel, prior=NO_PRIOR, decode=1, border_x=MIRROR)
        assert near(ours, model, 2e-5), shape


@pytest.mark.parametrize("kernel", ["central", "forward"])
@pytest.mark.parametrize("borders", [(WRAP, WRAP), (CLAMP, CLAMP), (WRAP, CLAMP)])
def test_prior_of_kernels_of_one_dimension(kernel, borders):
    if kernel == "forward" and CLAMP in borders:
        return  # its last slope is not looked at
    rng = np.random.default_rng(12)
    for shape in SHAPES:
        n = rng.integers(90, 166, (*shape, 3)).astype(np.uint8)
        n[..., 2] = 250
        model = least_squares(*slopes(n), kernel, borders, 8)
        how = {"border_x": borders[0], "border_y": borders[1], "decode": 1}
        ours, _ = to_height(n, kernel=kernel, prior=ROUGHNESS, **how)
        assert near(ours, model, 2e-5), shape


@pytest.mark.parametrize("border_x", [WRAP, CLAMP, MIRROR, EXTRAPOLATE])
@pytest.mark.parametrize("border_y", [WRAP, CLAMP, MIRROR, EXTRAPOLATE])
def test_central_slopes_with_mirrored_borders(border_x, border_y):
    if MIRROR not in (border_x, border_y) or EXTRAPOLATE in (border_x, border_y):
        return
    rng = np.random.default_rng(13)
    for shape in SHAPES:
        n = random_vectors(rng, shape)
        model = least_squares(
            *slopes(n, ntp.VECTOR), "central", (border_x, border_y), 24, prior=False
        )
        ours, _ = to_height(n, ntp.VECTOR, kernel="central", border_x=border_x, border_y=border_y)
        assert near(ours, model), shape


@pytest.mark.parametrize("kernel", ["central", "forward"])
@pytest.mark.parametrize("border", [WRAP, CLAMP])
def test_texels_that_are_not_square(kernel, border):
    rng = np.random.default_rng(14)
    dx, dy = 0.5, 1.75
    n = random_vectors(rng, (13, 10))
    p, q = slopes(n, ntp.VECTOR)
    # Slopes per texel; those to the right count dy^2/dx^2 times as much as those down.
    ours, _ = to_height(
        n, ntp.VECTOR, kernel=kernel, border_x=border, border_y=border, dx=dx, dy=dy
    )
    model = by_eigenvectors(p, q, kernel, border, border, (dx, dy))
    assert near(ours, model)
    sobel, _ = to_height(n, ntp.VECTOR, kernel="sobel3", border_x=border, border_y=border)
    twice = {"dx": 2.0, "dy": 2.0, "border_x": border, "border_y": border}
    assert np.allclose(to_height(n, ntp.VECTOR, kernel="sobel3", **twice)[0], 2 * sobel, atol=1e-4)
    for dx in (-1.0, np.nan, np.inf):
        with pytest.raises(ntp.NtpError):
            to_height(n, ntp.VECTOR, kernel=kernel, dx=dx)


# -------------------------------------------------------------------------------- baked


def edges_of(n, wrap):
    """The matrix of mean slopes between neighbors, from the slopes at the texels."""
    count = 0 if n == 1 else n if wrap else n - 1
    out = np.zeros((count, n))
    for i in range(count):
        if wrap:
            for k, weight in zip(range(i - 1, i + 3), [-1, 13, 13, -1], strict=True):
                out[i, k % n] += weight / 24
            continue
        # The polynomial through the nearest slopes, integrated from i to i + 1.
        at = np.arange(min(max(i - 1, 0), max(n - 4, 0)), min(max(i - 1, 0), max(n - 4, 0)) + 4)
        at = at[at < n]
        powers = np.vander(at - i, increasing=True).T.astype(float)
        out[i, at] = np.linalg.solve(powers, 1 / np.arange(1, len(at) + 1))
    return out


def differences(n, wrap):
    count = 0 if n == 1 else n if wrap else n - 1
    out = np.zeros((count, n))
    for i in range(count):
        out[i, i] -= 1
        out[i, (i + 1) % n] += 1
    return out


@pytest.mark.parametrize("border_x", [WRAP, CLAMP, MIRROR, EXTRAPOLATE, REPEAT_SLOPE])
@pytest.mark.parametrize("border_y", [WRAP, CLAMP, EXTRAPOLATE])
def test_baked_slopes_are_those_of_edges(border_x, border_y):
    rng = np.random.default_rng(15)
    for shape in [*SHAPES, (3, 3), (12, 13), (31, 4)]:
        h, w = shape
        n = random_vectors(rng, shape)
        p, q = slopes(n, ntp.VECTOR)
        dx, dy = differences(w, border_x == WRAP), differences(h, border_y == WRAP)
        p, q = p @ edges_of(w, border_x == WRAP).T, edges_of(h, border_y == WRAP) @ q
        matrix = np.vstack([np.kron(np.eye(h), dx), np.kron(dy, np.eye(w))])
        data = np.concatenate([p.ravel(), q.ravel()])
        model = np.linalg.lstsq(matrix, data, rcond=1e-11)[0].reshape(h, w)
        borders = {"border_x": border_x, "border_y": border_y}
        ours, _ = to_height(n, ntp.VECTOR, kernel=BAKED, **borders)
        assert near(ours, model), shape


def test_baked_surfaces_come_out_to_fourth_order():
    errors = []
    for n in (64, 128):
        y, x = (np.mgrid[:n, :n] + 0.5) * (2 * np.pi / n)
        h = n / 20 * (np.sin(x) * np.cos(2 * y) + 0.3 * np.cos(3 * x))
        p = np.pi / 10 * (np.cos(x) * np.cos(2 * y) - 0.9 * np.sin(3 * x))
        q = -np.pi / 5 * np.sin(x) * np.sin(2 * y)
        ours, _ = to_height(vectors_of(p, q), ntp.VECTOR, kernel=BAKED)
        errors.append(np.std(ours - h) / np.ptp(h))
    assert errors[1] < errors[0] / 14 and errors[1] < 2e-6


def test_baked_is_for_reconstruction_only():
    h = fractal(16)
    how = ntp.ffi.new("ntp_normals_options *", {"kernel": BAKED, "scale": 1})
    out = np.zeros((16, 16, 3), np.uint8)
    status = ntp.lib.ntp_normals_from_height(
        ntp.view(out), ntp.view(h, ntp.HEIGHT, const=True), how, ntp.ffi.NULL, ntp.ffi.NULL
    )
    assert status == ntp.ERR_ARGUMENT
    assert ntp.ffi.string(ntp.lib.ntp_kernel_name(BAKED)) == b"baked"
