# SPDX-License-Identifier: MIT
"""Heights of damaged normals: the size of the errors is told by lengths, and kept out of detail to
which kernels hardly respond; ground that was damaged as a whole stays flat."""

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import maps
from support import oracle_height as kernels
from support.drawn_maps import by_blocks
from support.to_height import (
    DECODE_AUTO,
    EXTRAPOLATE,
    MIRROR,
    NEUTRAL,
    STORED,
    UNORM,
    WRAP,
    Z_AUTO,
    bricks,
    bumps,
    fractal,
    from_height,
    lean,
    mixed_slopes,
    options,
)
from support.to_height import to_height as reconstruct

NO_PRIOR = 1


def made(kernel, slope, seed=1, size=256, exponent=1.6):
    """(heights, their normals of 8 bits)"""
    h = fractal(size, seed=seed, rms_slope=slope, exponent=exponent)
    right, down = by_kernel(h, kernel)
    n = np.stack([-right, down, np.ones_like(h, np.float64)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return h, np.floor((n + 1) * 127.5 + 0.5).astype(np.uint8)


def symbols(shape, kernel):
    y = np.fft.fftfreq(shape[0])[:, None] * 2 * np.pi
    x = np.fft.rfftfreq(shape[1])[None] * 2 * np.pi
    taps, whole = kernels.taps(kernel, False), kernels.KERNELS[kernel][1]
    right = sum(float(t) * np.exp(1j * (i * x + j * y)) for (i, j), t in taps.items()) / whole
    down = sum(float(t) * np.exp(1j * (i * y + j * x)) for (i, j), t in taps.items()) / whole
    return right, down, 4 * np.sin(x / 2) ** 2 + 4 * np.sin(y / 2) ** 2


def by_kernel(h, kernel):
    right, down, _ = symbols(h.shape, kernel)
    f = np.fft.rfft2(h)
    return (np.fft.irfft2(s * f, s=h.shape) for s in (right, down))


def size_of_errors(n):
    """Of x, y and z, by the squares of vectors that are too long, and by how far z^2 lies from its
    line over 1 - x^2 - y^2."""
    v = (2 * n.astype(np.float64) - 255) / 255
    rest, square = 1 - v[..., 0] ** 2 - v[..., 1] ** 2, v[..., 2] ** 2
    longer = 2 * np.mean(np.maximum(square - rest, 0) ** 2) / 4
    across = np.linalg.eigvalsh(np.cov(rest.ravel(), square.ravel(), bias=True))[0] / 2
    return np.sqrt(min(longer, across))


def model(n, kernel, p, q):
    right, down, rough = symbols(p.shape, kernel)
    f = np.conj(right) * np.fft.rfft2(p) + np.conj(down) * np.fft.rfft2(q)
    mean = np.mean(np.fft.irfft2(f, s=p.shape) ** 2)
    seen = np.abs(right) ** 2 + np.abs(down) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        e = size_of_errors(n) ** 2 / 2 / mean
        all_of = seen + e * rough**2 + 2.0**-44 * rough**2 / seen
        h = np.where(seen > 1e-20, f / all_of, 0)
    return np.fft.irfft2(h, s=p.shape)


def jpeg(n):
    return maps.jpeg(n, 85, 0)


def noisy(n):
    added = np.random.default_rng(3).normal(0, 4, n.shape)
    return np.clip(n + added, 0, 255).round().astype(np.uint8)


def by_boxes(n):
    """Block compression as the fastest encoders do it: the two colors of a block are the corners of
    its box, whichever diagonal the texels lie on."""
    h, w = n.shape[:2]
    blocks = n.reshape(h // 4, 4, w // 4, 4, 3).transpose(0, 2, 1, 3, 4).reshape(-1, 16, 3)
    most = np.array([31, 63, 31])
    ends = (f(blocks, 1, keepdims=True) / 255 for f in (np.min, np.max))
    low, high = (np.floor(end * most + 0.5) / most * 255 for end in ends)
    palette = np.concatenate([low, high, (2 * low + high) / 3, (low + 2 * high) / 3], 1)
    index = ((blocks[:, :, None] - palette[:, None]) ** 2).sum(-1).argmin(-1)
    texels = np.take_along_axis(palette, index[..., None], 1)
    texels = texels.reshape(h // 4, w // 4, 4, 4, 3).transpose(0, 2, 1, 3, 4).reshape(n.shape)
    return np.floor(texels + 0.5).astype(np.uint8)


def error(ours, h):
    """Without regard to a common factor: damage shortens slopes."""
    a, b = ours - ours.mean(dtype=float), h - h.mean(dtype=float)
    return np.sqrt(np.mean(((a * b).sum() / (a * a).sum() * a - b) ** 2)) / np.ptp(h)


@pytest.mark.parametrize("kernel", ["central", "sobel3", "scharr3", "prewitt5"])
@pytest.mark.parametrize("damage", [jpeg, noisy])
def test_prior_takes_errors_from_the_lengths(kernel, damage):
    _, n = made(kernel, 0.7)
    n = damage(n)
    ours = reconstruct(n, kernel=kernel, z=Z_AUTO, decode=UNORM)[0]
    expected = model(n, kernel, *mixed_slopes(n))
    assert np.abs(ours - expected).max() <= 2e-4 * np.ptp(expected)


@pytest.mark.parametrize("kernel", ["central", "sobel3"])
@pytest.mark.parametrize("slope", [0.5, 1, 2])
@pytest.mark.parametrize("damage", [jpeg, noisy])
def test_damage_does_not_show_as_fine_detail(kernel, slope, damage):
    h, n = made(kernel, slope, seed=4)
    n = damage(n)
    how = {"kernel": kernel, "decode": UNORM}
    auto, stored = (error(reconstruct(n, z=z, **how)[0], h) for z in (Z_AUTO, STORED))
    assert auto <= 0.9 * stored


@pytest.mark.parametrize("slope", [0.5, 0.7])
def test_blue_of_crude_block_compression_is_still_z(slope):
    """Its z^2 follows 1 - x^2 - y^2 with a slope of a quarter only."""
    h, n = made("central", slope)
    n = by_boxes(n)
    how = {"kernel": "central", "decode": UNORM}
    made_of, info = reconstruct(n, z=Z_AUTO, **how)
    assert info["z"] == STORED
    assert error(made_of, h) <= error(reconstruct(n, z=STORED, **how)[0], h)


@pytest.mark.parametrize("kernel", ["central", "sobel3", "prewitt5"])
@pytest.mark.parametrize("slope", [0.3, 2])
def test_undamaged_heights_are_the_same(kernel, slope):
    n = made(kernel, slope)[1]
    for same in (n, n.astype(np.uint16) * 257, (n / 255).astype(np.float32)):
        for border in (0, EXTRAPOLATE if kernel == "central" else 2):
            how = {"kernel": kernel, "decode": UNORM, "border_x": border}
            a, b = (reconstruct(same, z=z, **how)[0] for z in (Z_AUTO, STORED))
            assert (a == b).all()


def test_lengths_that_are_no_damage_leave_central_alone():
    """Means of normals are shorter; what was scaled lies on its line, but for rounding."""
    n = made("central", 0.7, exponent=2.5)[1].astype(np.float64)
    half = (n.reshape(128, 2, 128, 2, 3).mean((1, 3)) + 0.5).astype(np.uint8)
    shorter, longer = (
        ((n - 127.5) * by + 128).clip(0, 255).astype(np.uint8) for by in (0.8, [1.4, 1.4, 1])
    )
    for other in (half, shorter, longer):
        how = {"kernel": "central", "decode": UNORM, "z": Z_AUTO}
        a, b = (reconstruct(other, prior=prior, **how)[0] for prior in (0, NO_PRIOR))
        assert np.abs(a - b).max() <= 1e-3 * np.ptp(b)


def test_prior_is_not_for_those_who_refuse_it():
    n = noisy(made("central", 0.4, exponent=2.5)[1])
    how = {"kernel": "central", "decode": UNORM}
    none, usual = (reconstruct(n, z=Z_AUTO, prior=prior, **how)[0] for prior in (NO_PRIOR, 0))
    p, q = mixed_slopes(n)
    right, down, _ = symbols(p.shape, "central")
    f = np.conj(right) * np.fft.rfft2(p) + np.conj(down) * np.fft.rfft2(q)
    seen = np.abs(right) ** 2 + np.abs(down) ** 2
    plain = np.fft.irfft2(np.where(seen > 1e-20, f / np.maximum(seen, 1e-20), 0), s=p.shape)
    assert np.abs(none - plain).max() <= 1e-4 * np.ptp(plain)
    assert np.abs(usual - plain).max() > 1e-3 * np.ptp(plain)


@pytest.mark.parametrize("border", range(5))
def test_memory_is_enough_for_the_prior(border):
    """That a texture is damaged shows only later."""
    for kernel in ("central", "forward", "sobel3"):
        how = {"kernel": kernel, "border_x": border, "border_y": border}
        auto, asked = (
            ntp.lib.ntp_height_scratch_size(options(**how, **more), 40, 1009, 3)
            for more in ({"z": Z_AUTO}, {"prior": 2})
        )
        assert auto >= (asked if kernel == "central" else 0)


@pytest.mark.parametrize("surface", [bumps, bricks])
def test_flat_ground_of_block_compression_stays_flat(surface):
    """Levels as far from zero as that of the ground are 0, as if they were 128."""
    h = surface(192).astype(np.float32)
    n = by_blocks(from_height(h, border_x=MIRROR, border_y=MIRROR))
    how = {"kernel": "central", "border_x": MIRROR, "border_y": MIRROR, "z": STORED}
    ours, info = reconstruct(n, decode=DECODE_AUTO, **how)
    pairs, counts = np.unique(n[..., :2].reshape(-1, 2), axis=0, return_counts=True)
    ground = pairs[counts.argmax()].astype(int)
    assert info["decode"] == NEUTRAL and ground[0] == 132
    flat = n.copy()
    near = np.abs(2 * n[..., :2].astype(int) - 255) <= np.abs(2 * ground - 255).max()
    flat[..., :2][near] = 128
    assert (ours == reconstruct(flat, decode=NEUTRAL, **how)[0]).all()
    assert error(ours, h) <= 0.6 * error(reconstruct(n, decode=UNORM, **how)[0], h)


def test_ground_that_leans_on_purpose_still_leans():
    """No damage and not of 5 and 6 bits; or the levels around that of the ground are as common."""
    tilted = np.full((64, 64, 3), (131, 126, 255), np.uint8)
    rng = np.random.default_rng(5)
    varied = np.full((64, 64, 3), (132, 130, 255), np.uint8)
    varied[..., :2] -= rng.integers(0, 5, (64, 64, 2), np.uint8)
    varied[:2] = 64  # damage
    for n in (tilted, varied):
        how = {"kernel": "central", "border_x": EXTRAPOLATE, "border_y": EXTRAPOLATE, "z": STORED}
        ours, info = reconstruct(n, decode=DECODE_AUTO, **how)
        assert info["decode"] == UNORM
        assert (ours == reconstruct(n, decode=UNORM, **how)[0]).all()


@pytest.mark.parametrize("surface", [bumps, bricks])
@pytest.mark.parametrize("damage", [jpeg, noisy])
@pytest.mark.parametrize("y", [ntp.UP, ntp.DOWN])
def test_flat_ground_of_damaged_normals_does_not_lean(surface, damage, y):
    """0 rounds to 128, half a level too high; a plane is taken out where a border does not wrap."""
    h = surface(192).astype(np.float32)
    n = damage(from_height(h, border_x=MIRROR, border_y=MIRROR)).copy()
    if y == ntp.DOWN:
        n[..., 1] = 255 - n[..., 1]
    p, q = lean(n) * 2 / 255
    assert p != 0 or q != 0 or (surface is bricks and damage is jpeg)  # walls hide that pile
    for border_x, border_y in ((MIRROR, MIRROR), (MIRROR, WRAP), (WRAP, MIRROR), (WRAP, WRAP)):
        how = {"border_x": border_x, "border_y": border_y, "z": Z_AUTO, "dx": 2, "dy": 3, "y": y}
        plain = reconstruct(n, decode=UNORM, **how)[0].astype(float)
        ours, info = reconstruct(n, decode=DECODE_AUTO, **how)
        away = np.arange(192) - 191 / 2
        along = 2 * p * away * (border_x != WRAP)
        down = -3 * q * away * (border_y != WRAP) * (1 if y == ntp.UP else -1)
        assert info["decode"] == UNORM
        assert np.allclose(ours, plain + along + down[:, None], atol=1e-3)
        assert (info["min"], info["max"]) == (ours.min(), ours.max())


@pytest.mark.parametrize("damage", [jpeg, noisy])
def test_level_ground_is_nearer_to_the_heights(damage):
    h = bumps(192).astype(np.float32)
    n = damage(from_height(h, border_x=MIRROR, border_y=MIRROR))
    how = {"border_x": MIRROR, "border_y": MIRROR, "z": Z_AUTO}
    auto, plain = (reconstruct(n, decode=d, **how)[0] for d in (DECODE_AUTO, UNORM))
    assert error(auto, h) <= 0.6 * error(plain, h)


def test_only_damaged_flat_ground_is_leveled():
    """Not undamaged bumps, slopes without a pile, or heights that are refined."""
    how = {"border_x": MIRROR, "border_y": MIRROR, "z": STORED}
    clean = from_height(bumps(192).astype(np.float32), border_x=MIRROR, border_y=MIRROR)
    cases = [(clean, 0), (noisy(made("central", 0.5)[1]), 0), (noisy(clean), 1)]
    for n, refine in cases:
        auto, plain = (
            reconstruct(n, decode=d, refine=refine, **how)[0] for d in (DECODE_AUTO, UNORM)
        )
        assert (auto == plain).all()
