# SPDX-License-Identifier: MIT
"""The error diffusion that keeps slopes integrable, and the blur before it."""

import itertools
import math

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle
from support import oracle_height as model
from support.from_height import from_height, options


def dithered(src, encoding=ntp.STANDARD, y=ntp.UP, dst=np.uint8, parts=(), **how):
    out = np.zeros((*src.shape[:2], 3), dst)
    size = ntp.lib.ntp_normals_dithered_scratch_size(src.shape[1])
    errors = ntp.aligned(size, 16)
    errors[:] = 0
    where = ntp.ffi.cast("void *", errors.__array_interface__["data"][0])
    counts = ntp.ffi.new("ntp_normals_counts *")
    ends = [0, *parts, src.shape[0]]
    for y0, y1 in itertools.pairwise(ends):
        status = ntp.lib.ntp_normals_dithered(
            ntp.view(out, encoding, y),
            ntp.view(src, ntp.HEIGHT, const=True),
            options(**how),
            where,
            size,
            counts,
            ntp.rect((0, y0, src.shape[1], y1)),
        )
        ntp.check(status)
    return out, counts.not_finite


def test_working_memory():
    out, src = np.zeros((2, 5, 3), np.uint8), np.zeros((2, 5), np.uint8)
    size = ntp.lib.ntp_normals_dithered_scratch_size(5)
    memory = ntp.aligned(size + 16, 16)
    where = memory.__array_interface__["data"][0]
    views = ntp.view(out), ntp.view(src, ntp.HEIGHT, const=True), options(scale=1.0)
    for address, bytes_ in ((0, size), (where + 8, size), (where, size - 1)):
        scratch = ntp.ffi.cast("void *", address)
        status = ntp.lib.ntp_normals_dithered(*views, scratch, bytes_, ntp.ffi.NULL, ntp.ffi.NULL)
        assert status == ntp.ERR_SCRATCH and not out.any()
    assert [ntp.lib.ntp_normals_dithered_scratch_size(n) for n in (-1, 0, 65536)] == [0, 0, 0]


def decoded_slopes(normals, m):
    """n.x / n.z and n.y / n.z of red and green."""
    x, y = (2.0 * normals[..., k] - m for k in (0, 1))
    z = np.sqrt(m * m - x * x - y * y)
    return x / z, y / z


def gentle(h=60, w=333):
    y, x = np.mgrid[0:h, 0:w]
    x, y = x * (2 * np.pi / w), y * (2 * np.pi / h)  # it tiles: a seam would be a cliff
    wave = np.sin(6 * x) * np.cos(y) + 0.3 * np.sin(21 * x + 3 * y)
    return ((wave + 1.5) / 3 * 65535).astype(np.uint16)


@pytest.mark.parametrize("border", model.BORDERS)
@pytest.mark.parametrize("kernel", ["forward", "central", "gimp9"])
@pytest.mark.parametrize("dst, m", [(np.uint8, 255), (np.uint16, 65535)])
def test_dithering_keeps_sums_of_slopes(border, kernel, dst, m):
    """Along each row the sums of decoded slopes differ from the true ones by at most half a
    step."""
    src = gentle()
    how = {"scale": 8.0, "kernel": kernel, "border_x": border, "border_y": border}
    exact, _, _ = from_height(src, ntp.VECTOR, dst=np.float32, **how)
    want = exact[..., :2] / exact[..., 2:]
    got = decoded_slopes(dithered(src, dst=dst, **how)[0], m)
    plain = decoded_slopes(from_height(src, dst=dst, **how)[0], m)
    for axis in (0, 1):
        drift = np.abs(np.cumsum(got[axis] - want[..., axis], 1 - axis)).max()
        rounded = np.abs(np.cumsum(plain[axis] - want[..., axis], 1 - axis)).max()
        steepest = 1 + (want**2).sum(-1).max()
        assert drift < 1.2 * steepest**1.5 / m + 1e-4
        assert drift < rounded


def taken(error, x, y, half):
    """How much of an error a texel with these slopes takes."""
    length2 = 1 + x * x + y * y
    length = math.sqrt(length2)
    most = min(length2 * length / half, length / 10)
    return max(-most, min(most, error))


def dithered_texel(x, y, along, down, m, min_z):
    """(red, green, error to the right, error down), with the double arithmetic of C."""
    x, y = max(-1e6, min(1e6, x)), max(-1e6, min(1e6, y))
    x, y = x + taken(along, x, y, m / 2), y + taken(down, x, y, m / 2)
    factor = 1 / math.sqrt(1 + x * x + y * y)
    if factor < min_z:
        factor = math.sqrt(1 - min_z * min_z) / math.sqrt(x * x + y * y)
    r, g = (min(m, int((v * factor + 1) / 2 * m + 0.5)) for v in (x, y))
    if (2 * r - m) ** 2 + (2 * g - m) ** 2 > m * m:
        r, g = (int(v[0]) for v in oracle.pulled(np.array([r]), np.array([g]), m))
    z = math.sqrt(m * m - (2 * r - m) ** 2 - (2 * g - m) ** 2)
    return r, g, x - (2 * r - m) / z, y - (2 * g - m) / z


def dithered_model(src, m, zzero, scale, min_z):
    """Texel by texel, kernel central, border wrap."""
    heights = src.astype(float)
    right = np.roll(heights, -1, 1) - np.roll(heights, 1, 1)
    down = np.roll(heights, -1, 0) - np.roll(heights, 1, 0)
    factor = scale / (2 * 65535)
    out = np.zeros((*src.shape, 3), int)
    errors = [0.0] * src.shape[1]
    for row, (p, q) in enumerate(zip(right * -factor, down * factor, strict=True)):
        along = 0.0
        for i in range(src.shape[1]):
            r, g, along, errors[i] = dithered_texel(p[i], q[i], along, errors[i], m, min_z)
            out[row, i, :2] = r, g
    out[..., 2] = oracle.derived_blues(out[..., 0].ravel(), out[..., 1].ravel(), m, zzero).reshape(
        src.shape
    )
    return out


def test_dithering_gives_the_bytes_of_one_texel_after_another():
    """Rows are done in groups, and columns in blocks: shapes around these, and steep heights."""
    rng = np.random.default_rng(8)
    shapes = [(1, 1), (1, 9), (7, 2), (8, 3), (9, 17), (33, 5), (10, 259)]
    ways = [(255, 0, 4.0, 0.0), (255, 1, 60.0, 0.0), (65535, 0, 4.0, 0.0), (65535, 0, 300.0, 0.6)]
    for shape, (m, zzero, scale, min_z) in itertools.product(shapes, ways):
        src = np.cumsum(rng.integers(-900, 901, shape), 1).astype(np.uint16)
        dst = np.uint8 if m == 255 else np.uint16
        encoding = ntp.ZZERO if zzero else ntp.STANDARD
        made, _ = dithered(src, encoding, dst=dst, scale=scale, min_z=min_z)
        want = dithered_model(src, m, zzero, scale, min_z)
        assert (made == want).all(), (shape, m, zzero, scale, min_z)


def bricks(n=96):
    """Flat bricks between mortar, of 8 bits: at scale 32 the edges are far steeper than a level
    tells."""
    y, x = np.mgrid[0:n, 0:n]
    mortar = ((x + 8 * (y // 16 % 2)) % 32 < 3) | (y % 16 < 3)
    return np.where(mortar, 40, 200).astype(np.uint8)


def rough(n=128):
    rng = np.random.default_rng(42)
    f = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None])
    f[0, 0] = np.inf
    h = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((n, n))) / f**2, s=(n, n))
    return ((h - h.min()) / np.ptp(h) * 65535).astype(np.uint16)


def degrees_apart(a, b):
    a, b = (2.0 * v - 255 for v in (a, b))
    cos = (a * b).sum(-1) / np.sqrt((a * a).sum(-1) * (b * b).sum(-1))
    return np.degrees(np.arccos(np.clip(cos, -1, 1)))


@pytest.mark.parametrize("kernel", ["forward", "central", "sobel3"])
def test_dithering_beside_cliffs_leaves_flat_texels_flat(kernel):
    for src, scale in ((bricks(), 32.0), (bricks(), 4.0), (rough(), 500.0)):
        how = {"scale": scale, "kernel": kernel}
        exact, _, _ = from_height(src, ntp.VECTOR, dst=np.float32, **how)
        plain = from_height(src, dst=np.uint8, **how)[0]
        made, _ = dithered(src, dst=np.uint8, **how)
        moved = np.abs(made.astype(int) - plain)[..., :2].max(-1)
        flat = exact[..., 2] > 0.9999
        assert moved[flat].max(initial=0) <= 1
        assert degrees_apart(made, plain)[flat].max(initial=0) < 1
        assert degrees_apart(made, plain).max() < 15


@pytest.mark.parametrize("scale, at_most", [(20, 0.2), (60, 0.2), (80, 0.2)])
def test_dithering_keeps_sums_of_slopes_on_steep_ground(scale, at_most):
    """The drift of sums of slopes (rms) as a share of that of plain rounding: rms slopes of 0.4,
    1.1 and 1.4."""
    how = {"scale": float(scale), "kernel": "central"}
    src = rough()
    exact, _, _ = from_height(src, ntp.VECTOR, dst=np.float32, **how)
    want = exact[..., :2] / exact[..., 2:]

    def drift(levels):
        slopes = decoded_slopes(levels, 255)
        off = [np.cumsum(slopes[a] - want[..., a], 1 - a) for a in (0, 1)]
        return np.sqrt(np.mean(np.square(off)))

    plain = drift(from_height(src, dst=np.uint8, **how)[0])
    assert drift(dithered(src, dst=np.uint8, **how)[0]) < at_most * plain


def test_dithering_in_parts_is_clean_and_bounded():
    src = gentle()
    for how in ({"scale": 8.0}, {"scale": 1e5}, {"scale": 1e300}, {"scale": 9.0, "min_z": 0.8}):
        for encoding in (ntp.STANDARD, ntp.ZZERO, ntp.XY):
            whole, _ = dithered(src, encoding, **how)
            parts, _ = dithered(src, encoding, parts=(1, 7, 40), **how)
            assert np.array_equal(whole, parts)
            clean = ntp.clean_options(touch_unused=ntp.UNUSED_ALL)
            assert ntp.clean(whole, encoding, clean)[1] == 0
    bad = src.astype(np.float32) / 65535
    bad[5, 9] = np.nan
    out, count = dithered(bad, scale=5.0)
    assert count == 4 and out[5, 100:].std() > 0
    flat = np.full((9, 9), 77, np.uint8)
    assert (dithered(flat, scale=5.0)[0] == dithered(flat, scale=5.0)[0][0, 0]).mean() > 0.3


def blur(src, sigma, weight=1.0, add=None, border_x=0, border_y=0, source="red"):
    how = ntp.ffi.new("ntp_blur_options *")
    how.sigma, how.weight, how.add = sigma, weight, add is not None
    how.border_x, how.border_y, how.source = border_x, border_y, model.SOURCES[source]
    out = np.zeros(src.shape[:2], np.float32) if add is None else add.copy()
    scratch = ntp.aligned(ntp.lib.ntp_height_blur_scratch_size(how, src.shape[1]))
    memory = ntp.ffi.cast("void *", scratch.__array_interface__["data"][0])
    view = ntp.view(src, ntp.HEIGHT, const=True)
    ntp.check(ntp.lib.ntp_height_blur(ntp.view(out, ntp.HEIGHT), view, how, memory, len(scratch)))
    return out


@pytest.mark.parametrize("border", model.BORDERS)
@pytest.mark.parametrize("sigma", [0.3, 1.0, 2.7])
def test_blur_is_the_gaussian(border, sigma):
    rng = np.random.default_rng(40)
    src = rng.integers(0, 65536, (12, 15)).astype(np.uint16)
    radius = math.ceil(3 * sigma)
    weights = np.exp(-(np.arange(-radius, radius + 1) ** 2) / (2 * sigma * sigma))
    weights /= weights.sum()

    def matrix(n):
        a = np.zeros((n, n))
        for i in range(n):
            for k, w in zip(range(-radius, radius + 1), weights, strict=True):
                for index, factor in model.reflect(i + k, n, border):
                    a[i, index] += w * factor
        return a

    want = matrix(12) @ (src / 65535) @ matrix(15).T
    assert np.abs(blur(src, sigma, border_x=border, border_y=border) - want).max() < 3e-3


def test_blur_is_seamless_and_keeps_constants():
    rng = np.random.default_rng(41)
    src = rng.integers(0, 256, (31, 47)).astype(np.uint8)
    for sigma in (0.5, 3.3, 20.0, 64.0):
        whole = blur(src, sigma)
        rolled = blur(np.roll(src, (11, 20), (0, 1)).copy(), sigma)
        assert np.array_equal(rolled, np.roll(whole, (11, 20), (0, 1)))
        for border in model.BORDERS:
            same = blur(np.full((9, 5), 51, np.uint8), sigma, border_x=border, border_y=border)
            assert np.abs(same - 0.2).max() < 1e-6
    assert np.array_equal(blur(src, 0.0), (src / 255).astype(np.float32))
    two = blur(src, 2.0, 0.5, add=blur(src, 0.0))
    assert np.abs(two - (src / 255 + 0.5 * blur(src, 2.0))).max() < 1e-6
    for wrong in (-1.0, 65.0, float("nan")):
        with pytest.raises(ntp.NtpError):
            blur(src, wrong)
