# SPDX-License-Identifier: MIT
"""Heightfield -> normals against the model in oracle_height.py: no texel may be off."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle
from support import oracle_height as model
from support.from_height import SCALES, both, from_height, options, random_heights, random_how

# ------------------------------------------------------------------------ every setting


@pytest.mark.parametrize("kernel", model.NAMES)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_every_kernel_border_depth(kernel, dtype):
    rng = np.random.default_rng([model.NAMES.index(kernel), np.dtype(dtype).itemsize])
    for border_x in model.BORDERS:
        for border_y in model.BORDERS:
            size = rng.integers(1, 12, 2)
            src = random_heights(rng, size, dtype)
            how = random_how(rng)
            ours, expected = both(src, how, kernel=kernel, border_x=border_x, border_y=border_y)
            assert np.array_equal(ours, expected), (size, border_x, border_y, how)


@pytest.mark.parametrize("kernel", model.NAMES)
def test_tiny_sizes(kernel):
    rng = np.random.default_rng(5)
    for size in [(1, 1), (1, 2), (2, 1), (1, 7), (7, 1), (2, 2), (3, 2), (4, 3), (5, 5), (8, 8)]:
        for border in model.BORDERS:
            src = random_heights(rng, size, np.uint8)
            ours, expected = both(
                src, {"scale": 3.5}, kernel=kernel, border_x=border, border_y=border
            )
            assert np.array_equal(ours, expected), (size, border)


@pytest.mark.parametrize("source", model.SOURCES)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_sources(source, dtype):
    rng = np.random.default_rng(model.SOURCES[source])
    for channels in (1, 2, 3, 4):
        if source == "alpha" and channels % 2 == 1:
            with pytest.raises(ntp.NtpError):
                from_height(random_heights(rng, (3, 3, channels), dtype), source=source)
            continue
        for kernel in ("central", "sobel3", "gimp5"):
            src = random_heights(rng, (5, 6, channels), dtype)
            how = {"kernel": kernel, "scale": 7.3, "border_x": 3, "border_y": 3, "dst": np.uint16}
            ours, expected = both(src, how, source=source)
            assert np.array_equal(ours, expected), (channels, kernel)


@pytest.mark.parametrize("source", ["red", "luma", "mean", "max", "screen"])
def test_float_heights_of_any_size(source):
    """Sums that are not exact doubles; negative, huge and denormal heights; flat ones."""
    rng = np.random.default_rng(9)
    for size in (1e-44, 1e-30, 1e-8, 1.0, 1e8, 1e37):
        src = (rng.normal(size=(6, 7, 3)) * size).astype(np.float32)
        src[1, 2] = 1.0
        src[3:, 3:] = src[3, 3]
        for scale in (1.0, 1 / size if size > 1e-40 else 1e40, 1e-9):
            for kernel in ("central", "sobel3", "gimp9"):
                ours, expected = both(
                    src, {"scale": scale, "kernel": kernel, "dst": np.uint16}, source=source
                )
                assert np.array_equal(ours, expected), (size, scale, kernel)


@pytest.mark.parametrize("dtype", [np.uint16, np.float32])
@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.ZZERO, ntp.XY, ntp.VECTOR])
def test_float_normals_are_nearest(encoding, dtype):
    """A height that is not finite has all texels around it made exactly, without the loops."""
    rng = np.random.default_rng(21)
    cases = [(s, z) for s in SCALES[:11] + [1e3, 1e6, 1e12] for z in (0.0, 0.25, 1.0)]
    for scale, min_z in cases:
        src = random_heights(rng, (5, 5), dtype)
        src[2:4, :3] = src[2, 0]
        if dtype == np.float32:
            src[rng.integers(5), rng.integers(5)] = np.nan
        kernel = model.NAMES[rng.integers(10)]
        ours, _, _ = from_height(
            src, encoding, scale=scale, min_z=min_z, kernel=kernel, dst=np.float32
        )
        h = model.heights(src)
        for y in range(5):
            for x in range(5):
                slopes = model.slopes(h, x, y, kernel, 0, 0, scale, 1.0, 1.0)
                p, q = slopes or (Fraction(0), Fraction(0))
                x2, y2, z2 = model.components(p, q, min_z)
                unit = encoding != ntp.VECTOR
                want = [
                    model.nearest_float(x2, p > 0, unit),
                    model.nearest_float(y2, q > 0, unit),
                    model.nearest_float(z2, False, unit and encoding != ntp.ZZERO),
                ]
                if encoding == ntp.XY:
                    want[2] = 1
                assert ours[y, x].tolist() == want, (scale, min_z, kernel, x, y)


@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.VECTOR])
@pytest.mark.parametrize("source", ["red", "luma", "screen"])
def test_rows_of_floats_are_exact(encoding, source):
    """Long rows: most texels by loops, and the same ones where a height that is not finite stops these."""
    rng = np.random.default_rng(22)
    for size in (1e-40, 1e-3, 1.0, 1e9):
        src = (rng.normal(size=(7, 300, 3)) * size).astype(np.float32)
        for scale in (0.7, 1 / max(size, 1e-30), 1e4):
            for border in (0, 4):
                how = {"scale": scale, "border_x": border, "dst": np.float32, "kernel": "sobel3"}
                ours, _, _ = from_height(src, encoding, source=source, **how)
                bad = src.copy()
                bad[:, 0] = np.nan
                exact, _, _ = from_height(bad, encoding, source=source, **how)
                assert np.array_equal(ours[:, 2:254], exact[:, 2:254]), (size, scale, border)


# ---------------------------------------------------------------------- ties and near-ties


def test_exact_ties():
    """Integer slopes such as (2, 2), n.x = 2/3, meet rounding boundaries exactly."""
    rng = np.random.default_rng(2)
    src = rng.integers(100, 116, (12, 12)).astype(np.uint8)
    exact = 0
    for scale in (510.0, -510.0, 255.0, 1020.0):
        for y in (ntp.UP, ntp.DOWN):
            ours, took, _ = from_height(src, scale=scale, y=y)
            expected = model.normals(src, scale=scale, y_down=bool(y))
            assert np.array_equal(ours, expected)
            exact += took
    assert exact > 20


@pytest.mark.parametrize("m, dst", [(255, np.uint8), (65535, np.uint16)])
def test_near_ties(m, dst):
    """Scales that put n.x so close to a boundary 2k/M that a double cannot decide."""
    rng = np.random.default_rng(3)
    took = 0
    for _ in range(150):
        k = int(rng.integers(1, m // 2))
        d, e = int(rng.integers(1, 256)), int(rng.integers(-20, 21))
        # p = s d / 510 and q = p e / d: t^2 (1 + p^2 (1 + e^2/d^2)) = p^2
        t = Fraction(2 * k, m)
        rest = 1 - t * t * (1 + Fraction(e * e, d * d))
        if rest <= 0:
            continue
        scale = float(t / d * 510) / math.sqrt(rest)
        src = np.full((3, 3), 128, np.uint8)
        src[1] = [0, 99, d]
        src[0, 1], src[2, 1] = 100 + e, 100
        for s in (math.nextafter(scale, 0), scale, math.nextafter(scale, math.inf), -scale):
            ours, exact, _ = from_height(src, scale=s, dst=dst, area=(1, 1, 2, 2))
            took += exact
            p, q = model.slopes(model.heights(src), 1, 1, "central", 0, 0, s, 1.0, 1.0)
            assert tuple(ours[1, 1].tolist()) == model.texel(p, q, m), (src, s)
    assert took > 300


@pytest.mark.parametrize("unit", [False, True])
def test_near_ties_of_floats(unit):
    """Scales that put n.x, or (n.x + 1)/2, so close to the middle of two floats that a double
    cannot decide."""
    rng = np.random.default_rng(4)
    took = 0
    for _ in range(150):
        middle = Fraction(2 * int(rng.integers(2**23 + 1, 2**24)) + 1, 2**25)
        t = 2 * middle - 1 if unit else middle
        d, e = int(rng.integers(1, 256)), int(rng.integers(-2, 3))
        rest = 1 - t * t * (1 + Fraction(e * e, d * d))
        if rest <= 0 or t == 0:
            continue
        scale = -float(t / d * 510) / math.sqrt(rest)
        src = np.full((3, 3), 128, np.uint8)
        src[1] = [0, 99, d]
        src[0, 1], src[2, 1] = 100 + e, 100
        encoding = ntp.STANDARD if unit else ntp.VECTOR
        how = {"dst": np.float32, "area": (1, 1, 2, 2)}
        for s in (math.nextafter(scale, 0), scale, math.nextafter(scale, -math.inf)):
            ours, exact, _ = from_height(src, encoding, scale=s, **how)
            took += exact
            p, q = model.slopes(model.heights(src), 1, 1, "central", 0, 0, s, 1.0, 1.0)
            x2, y2, _ = model.components(p, q, 0.0)
            want = [model.nearest_float(x2, p > 0, unit), model.nearest_float(y2, q > 0, unit)]
            assert ours[1, 1, :2].tolist() == want, (src, s)
    assert took > 300


def pair_image():
    """Every pair of 8-bit differences (dx, dy), -255..255 each, at the centers of 3 x 3 cells."""
    d = np.arange(-255, 256)
    image = np.zeros((511, 3, 511, 3), np.uint8)
    image[:, 1, :, 2] = np.maximum(d, 0)[None, :]
    image[:, 1, :, 0] = np.maximum(-d, 0)[None, :]
    image[:, 2, :, 1] = np.maximum(d, 0)[:, None]
    image[:, 0, :, 1] = np.maximum(-d, 0)[:, None]
    return image.reshape(1533, 1533)


@pytest.mark.parametrize("scale", [1.0, 5.0, 24.0, 255.0, 510.0, 1000.0, 0.1, math.pi, -7.38])
def test_all_differences_of_8_bit(scale):
    src = pair_image()
    s = Fraction(scale)
    num, den = s.numerator, s.denominator * 510
    for dst, m in ((np.uint8, 255), (np.uint16, 65535)):
        ours, _, _ = from_height(src, scale=scale, dst=dst)
        ours = ours[1::3, 1::3]
        # floor(M |n| / 2) = isqrt(floor(M^2 P^2 / (4 L^2))) for one quadrant; one less below 0,
        # unless it is exact.
        red = np.zeros((256, 256), np.int64)
        exact = np.zeros((256, 256), bool)
        for i in range(1, 256):
            p2 = (num * i) ** 2
            for j in range(256):
                l2 = 4 * (den * den + p2 + (num * j) ** 2)
                top = m * m * p2
                red[i, j] = math.isqrt(top // l2)
                exact[i, j] = int(red[i, j]) ** 2 * l2 == top
        exact[0] = True
        d = np.arange(-255, 256)
        dx, dy = np.meshgrid(d, d)
        sign = 1 if scale > 0 else -1

        below = -(red + ~exact)
        zero = (m + 1) // 2
        r, g = abs(dx), abs(dy)
        r, g = (
            zero + np.where(sign * dx > 0, below[r, g], red[r, g]),
            zero + np.where(sign * dy < 0, below[g, r], red[g, r]),
        )
        long = oracle_long(r, g, m)
        assert np.array_equal(ours[..., 0][~long], r[~long])
        assert np.array_equal(ours[..., 1][~long], g[~long])
        ys, xs = np.nonzero(long)
        for y, x in list(zip(ys, xs, strict=True))[:: max(1, len(ys) // 500)]:
            want = oracle.pull(int(r[y, x]), int(g[y, x]), m)
            assert tuple(ours[y, x, :2].tolist()) == want


def oracle_long(r, g, m):
    return (2 * r - m) ** 2 + (2 * g - m) ** 2 > m * m


# ------------------------------------------------------------------------- what must hold


@pytest.mark.parametrize("kernel", model.NAMES)
def test_gain_of_one(kernel):
    """A ramp of slope 3/4 in each direction, away from the borders."""
    y, x = np.mgrid[0:21, 0:21]
    for along, axis in ((x, 0), (20 - y, 1)):
        src = (along * 100).astype(np.uint16)
        ours, _, _ = from_height(
            src, ntp.VECTOR, dst=np.float32, scale=0.75 * 65535 / 100, kernel=kernel
        )
        want = [0, 0, 0.8]
        want[axis] = -0.6
        assert np.abs(ours[10, 10] - want).max() < 1e-7


@pytest.mark.parametrize("kernel", model.NAMES)
def test_tileable_in_tileable_out(kernel):
    rng = np.random.default_rng(4)
    src = rng.integers(0, 256, (20, 300)).astype(np.uint8)
    ours, _, _ = from_height(src, scale=4.0, kernel=kernel)
    for shift in ((1, 0), (0, 1), (7, 131)):
        rolled = np.roll(src, shift, (0, 1)).copy()
        again, _, _ = from_height(rolled, scale=4.0, kernel=kernel)
        assert np.array_equal(again, np.roll(ours, shift, (0, 1)))


@pytest.mark.parametrize("border", model.BORDERS)
@pytest.mark.parametrize("kernel", ["forward", "sobel3", "gimp9"])
def test_parts_make_the_whole(kernel, border):
    rng = np.random.default_rng(6)
    src = rng.integers(0, 65536, (23, 531)).astype(np.uint16)
    how = {"kernel": kernel, "border_x": border, "border_y": border, "scale": 9.0}
    whole, _, _ = from_height(src, **how)
    parts = np.zeros_like(whole)
    ys, xs = [0, 1, 4, 12, 22, 23], [0, 1, 3, 255, 257, 511, 530, 531]
    for y0, y1 in itertools.pairwise(ys):
        for x0, x1 in itertools.pairwise(xs):
            from_height(src, out=parts, area=(x0, y0, x1, y1), **how)
    assert np.array_equal(parts, whole)


@pytest.mark.parametrize("border", [b for b in model.BORDERS if b != model.WRAP])
@pytest.mark.parametrize("kernel", ["central", "sobel5", "gimp9"])
def test_streaming_through_a_ring(kernel, border):
    rng = np.random.default_rng(8)
    src = rng.integers(0, 256, (40, 33)).astype(np.uint8)
    how = {"kernel": kernel, "border_x": border, "border_y": border, "scale": 9.0}
    whole, _, _ = from_height(src, **how)
    reach = ntp.lib.ntp_normals_reach(options(**how))
    rows = 2 * reach + 1
    ring = np.zeros((rows, 33), np.uint8)
    got = np.zeros_like(whole)
    line = np.zeros((1, 33, 3), np.uint8)
    read = 0
    for y in range(40):
        while read < min(40, y + reach + 1):
            ring[read % rows] = src[read]
            read += 1
        line_view = ntp.view(line, ring_rows=1, height=40)
        view = ntp.view(ring, ntp.HEIGHT, const=True, ring_rows=rows, height=40)
        area = ntp.rect((0, y, 33, y + 1))
        ntp.check(
            ntp.lib.ntp_normals_from_height(line_view, view, options(**how), ntp.ffi.NULL, area)
        )
        got[y] = line[0]
    assert np.array_equal(got, whole)


def test_strides():
    rng = np.random.default_rng(12)
    big = rng.integers(0, 256, (40, 50, 3)).astype(np.uint8)
    src = big[30:4:-2, 45:5:-3, 1:2]
    plain, _, _ = from_height(np.ascontiguousarray(src), scale=5.0, kernel="sobel3")
    out = np.zeros((13, 40, 4), np.uint8)[:, ::3, 0:3][:, :14]
    ours, _, _ = from_height(src, out=out, scale=5.0, kernel="sobel3")
    assert np.array_equal(ours, plain)


@pytest.mark.parametrize("dst", [np.uint8, np.uint16])
@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.ZZERO, ntp.XY])
def test_clean_changes_nothing(dst, encoding):
    rng = np.random.default_rng(13)
    src = rng.integers(0, 256, (64, 300)).astype(np.uint8)
    for scale in (1.0, 20.0, 1000.0):
        ours, _, _ = from_height(src, encoding, scale=scale, dst=dst)
        how = ntp.clean_options(touch_unused=ntp.UNUSED_ALL)
        assert ntp.clean(ours, encoding, how)[1] == 0


def test_min_z_is_honored():
    rng = np.random.default_rng(14)
    src = rng.integers(0, 256, (64, 64)).astype(np.uint8)
    for min_z, slack in ((0.1, 0.081), (0.5, 0.01), (0.9, 0.01)):
        ours, _, _ = from_height(src, scale=1000.0, min_z=min_z)
        z = ours[..., 2].astype(float) / 255 * 2 - 1
        assert min_z - slack <= z.min() <= min_z + 0.02
        nearest, _, _ = from_height(src, scale=1000.0, min_z=min_z, blue=1)
        assert nearest[..., 2].min() == math.floor((Fraction(min_z) + 1) / 2 * 255 + Fraction(1, 2))


# ------------------------------------------------------------------ not finite, arguments


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("kernel", ["central", "sobel3", "gimp9"])
def test_heights_that_are_not_finite(kernel, bad):
    rng = np.random.default_rng(15)
    src = rng.random((11, 17)).astype(np.float32)
    src[5, 7] = bad
    src[9, 16] = bad
    h = model.heights(src)
    for border in model.BORDERS:
        ours, _, count = from_height(
            src, scale=3.0, kernel=kernel, border_x=border, border_y=border
        )
        expected = model.normals(src, kernel, border, border, 3.0)
        assert np.array_equal(ours, expected)
        flat = sum(
            model.slopes(h, x, y, kernel, border, border, 1.0, 1.0, 1.0) is None
            for y in range(11)
            for x in range(17)
        )
        assert count == flat > 4
        vector, _, _ = from_height(src, ntp.VECTOR, scale=3.0, dst=np.float32, kernel=kernel)
        assert np.isfinite(vector).all()


def test_argument_errors():
    src = np.zeros((4, 4), np.uint8)
    nan, inf = float("nan"), float("inf")
    for wrong in [
        {"scale": nan}, {"scale": inf}, {"dx": -1.0}, {"dx": inf}, {"dy": nan}, {"dy": -0.1},
        {"min_z": -0.1}, {"min_z": 1.1}, {"min_z": nan}, {"border_x": 5}, {"alpha": 9},
        {"blue": 2}, {"scale": 1e300, "dx": 1e-300}, {"scale": -1e300, "dy": 1e-300},
    ]:  # fmt: skip
        with pytest.raises(ntp.NtpError) as error:
            from_height(src, **wrong)
        assert error.value.status == ntp.ERR_ARGUMENT, wrong
        assert ntp.lib.ntp_normals_reach(options(**wrong)) == -1, wrong
    with pytest.raises(ntp.NtpError) as error:
        from_height(src, out=np.zeros((4, 5, 3), np.uint8))
    assert error.value.status == ntp.ERR_SHAPE
    null = ntp.ffi.NULL
    out = ntp.view(np.zeros((4, 4, 3), np.uint8))
    view = ntp.view(src, ntp.HEIGHT, const=True)
    assert ntp.lib.ntp_normals_from_height(out, view, null, null, null) == ntp.ERR_ARGUMENT
    assert ntp.lib.ntp_normals_reach(null) == -1


# -------------------------------------------------------------------------------- alpha


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("dst", [np.uint8, np.uint16])
def test_alpha(dtype, dst):
    rng = np.random.default_rng(16)
    src = rng.integers(0, np.iinfo(dtype).max + 1, (6, 9, 4)).astype(dtype)
    m, top = np.iinfo(dst).max, np.iinfo(dtype).max

    def to_level(v):
        return math.floor(v * m + Fraction(1, 2))

    for alpha in range(5):
        for source in ("red", "luma", "mean", "screen"):
            for invert in (0, 1):
                ours, _, _ = from_height(
                    src, dst=dst, channels=4, alpha=alpha, source=source, invert=invert
                )
                for y in range(6):
                    for x in range(9):
                        h = model.height_of(src[y, x], source, top)
                        a = Fraction(int(src[y, x, 3]), top)
                        high = 1 - h if invert else h
                        want = to_level([a, 1, 1 - a, high, 1 - high][alpha])
                        assert ours[y, x, 3] == want
    gray, _, _ = from_height(src[..., :1].copy(), dst=dst, channels=4)
    assert (gray[..., 3] == m).all()


KEEP, ONE, INVERSE, HEIGHT, INVERSE_HEIGHT = range(5)


def weighted_ties(m, to):
    """Colors whose Rec. 709 height lies halfway between two levels of the target."""
    step = 1 if m == 255 else 257
    r, g, b = np.meshgrid(*[np.arange(0, m + 1, step)[::3]] * 3, indexing="ij")
    h = 2126 * r.astype(np.int64) + 7152 * g + 722 * b
    tie = (2 * h * to) % (2 * 10_000 * m) == 10_000 * m
    return np.stack([r[tie], g[tie], b[tie]], -1)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("dst", [np.uint8, np.uint16])
def test_alpha_of_ties_is_rounded_up(dtype, dst):
    """Also that of 1 - h, as every level is."""
    m, to = np.iinfo(dtype).max, np.iinfo(dst).max
    colors = weighted_ties(m, to)[:4000]
    assert len(colors) > 100
    src = np.ascontiguousarray(colors[None], dtype)
    h = 2126 * colors[:, 0] + 7152 * colors[:, 1] + 722 * colors[:, 2]
    half_up = {False: h, True: 10_000 * m - h}
    for alpha, invert in itertools.product((HEIGHT, INVERSE_HEIGHT), (0, 1)):
        number = half_up[(alpha == INVERSE_HEIGHT) != bool(invert)]
        want = (2 * number * to + 10_000 * m) // (20_000 * m)
        how = {"channels": 4, "alpha": alpha, "source": "luma", "invert": invert}
        ours, _, _ = from_height(src, dst=dst, **how)
        assert np.array_equal(ours[0, :, 3], want), (alpha, invert)


@pytest.mark.parametrize("dst", [np.uint8, np.uint16])
def test_alpha_of_floats_is_rounded_up(dst):
    """The floats at and beside the boundaries between levels, those of 1 - h too, and beyond."""
    m = np.iinfo(dst).max
    edges = (np.arange(0, m, m // 255) + 0.5) / m
    edges = np.concatenate([edges, 1 - edges]).astype(np.float32)
    beside = [np.nextafter(edges, np.float32(side)) for side in (-1, 2)]
    far = [0, 0.5, 1, -1, 2, 1e30, -1e30, 1e-45, -1e-45, 2.0**-30]
    h = np.concatenate([edges, *beside, np.array(far, np.float32)])
    src = np.zeros((1, len(h), 4), np.float32)
    src[0, :, 0] = src[0, :, 3] = h
    exact = [Fraction(float(v)) for v in h]
    for alpha, invert in itertools.product(range(5), (0, 1)):
        inverse = alpha == INVERSE or (
            alpha >= HEIGHT and (alpha == INVERSE_HEIGHT) != bool(invert)
        )
        want = [(1 - v if inverse else v) if alpha != ONE else Fraction(1) for v in exact]
        want = [math.floor(min(max(v, 0), 1) * m + Fraction(1, 2)) for v in want]
        ours, _, _ = from_height(src, dst=dst, channels=4, alpha=alpha, invert=invert)
        assert ours[0, :, 3].tolist() == want, (alpha, invert)
