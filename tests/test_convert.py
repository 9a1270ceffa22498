# SPDX-License-Identifier: MIT
"""ntp_convert against the oracle, and what conversions promise."""

import itertools
import math

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle, oracle_convert
from support.texels import random_texels

DEPTHS = {255: np.uint8, 65535: np.uint16}
NAMES = {ntp.STANDARD: "standard", ntp.ZZERO: "zzero", ntp.XY: "xy"}
CASES = list(itertools.product(NAMES, DEPTHS, NAMES, DEPTHS))


def case_name(case):
    e, m, target, to = case
    return f"{NAMES[e]}{8 if m == 255 else 16}-{NAMES[target]}{8 if to == 255 else 16}"


def texels_of(m, encoding, count=120):
    """Texels of all kinds, many of them exact, and the unused ones."""
    anything = random_texels(m, count, seed=m * 7 + encoding)
    r, g = oracle.pulled(anything[:, 0], anything[:, 1], m)
    b = oracle.derived_blues(r, g, m, encoding == ntp.ZZERO)
    clean = np.stack([r, g, b], 1)
    mirrored = np.stack([r, g, m - b], 1)
    extra = [[0, 0, 0], [m, m, m], [0, 0, 1], [m, m, m - 1], [m // 2, m // 2 + 1, m]]
    # Some more, so that loops of 16 at a time see the ones before.
    return np.concatenate([anything, clean, mirrored, extra, clean[:16]])


@pytest.mark.parametrize("case", CASES, ids=case_name)
def test_integers(case):
    encoding, m, target, to = case
    texels = texels_of(m, encoding)
    alphas = np.resize([m, m // 3, 0], len(texels))
    full = np.column_stack([texels, alphas]).astype(DEPTHS[m])
    for channels in (2, 3, 4) if encoding == ntp.XY else (3, 4):
        src = np.ascontiguousarray(full[:, :channels])[None]
        targets = (2, 3, 4) if target == ntp.XY else (3, 4)
        for target_channels, flip, touch in itertools.product(targets, (0, 1), (0, 1)):
            dst = np.zeros((1, len(texels), target_channels), DEPTHS[to])
            got = ntp.convert(src, dst, encoding, target, 0, flip, (0, 7 * touch))
            want = [
                oracle_convert.convert(t, m, encoding, to, target, target_channels, flip, touch)
                for t in src[0].tolist()
            ]
            for texel, out, (levels, _, _) in zip(src[0].tolist(), dst[0].tolist(), want):
                assert tuple(out) == levels, (texel, out, levels, channels, flip, touch)
            negative = got[0] if target == ntp.XY else sum(w[1] for w in want)
            assert got == (negative, 0, sum(w[2] for w in want))


def with_alpha(m, encoding):
    """Three rows of texels of all kinds, each of more than are converted at once."""
    texels = texels_of(m, encoding)
    alphas = np.resize([m, m // 3, 0, m, m], len(texels))
    return np.stack([np.column_stack([np.roll(texels, k, 0), alphas]) for k in range(3)])


@pytest.mark.parametrize("m", DEPTHS)
@pytest.mark.parametrize("encoding", NAMES, ids=NAMES.get)
@pytest.mark.parametrize("target", NAMES, ids=NAMES.get)
def test_floats_are_levels_of_16_bits(target, encoding, m):
    """To floats as to 16 bits; y is flipped as 1 - y, unless a texel is unused."""
    for channels, flip, touch in itertools.product((3, 4), (0, 1), (0, 7)):
        texels = np.tile(with_alpha(m, encoding), (1, 3, 1))[..., :channels]
        src = np.ascontiguousarray(texels).astype(DEPTHS[m])
        assert src.shape[1] > 1024 and src.shape[1] % 16 != 0
        levels, got = np.zeros(src.shape, np.uint16), np.zeros(src.shape, np.float32)
        counts = ntp.convert(src, levels, encoding, target, 0, 0, (0, touch))
        want = (levels / 65535).astype(np.float32)
        gone = np.isin(src[..., :3], [0]).all(-1) | np.isin(src[..., :3], [m]).all(-1)
        if channels == 4:
            gone |= src[..., 3] == 0
        turned = flip & ~(gone & (touch == 0))
        want[..., 1] = np.where(turned, (1.0 - want[..., 1].astype(float)), want[..., 1])
        assert ntp.convert(src, got, encoding, target, 0, flip, (0, touch)) == counts
        assert np.array_equal(got, want)


@pytest.mark.parametrize("encoding", NAMES, ids=NAMES.get)
@pytest.mark.parametrize("target", NAMES, ids=NAMES.get)
def test_from_floats_as_from_16_bits(target, encoding):
    """Of floats that are levels; those that are no vectors are flat."""
    for channels, touch, to in itertools.product((3, 4), (0, 7), (np.uint8, np.uint16, np.float32)):
        full = np.ascontiguousarray(with_alpha(65535, encoding)[..., :channels]).astype(np.uint16)
        if (encoding, target) == (ntp.ZZERO, ntp.STANDARD):
            r, g, _ = (
                full[..., :3].reshape(-1, 3).astype(int).T
            )  # others go by a floor of the float
            full[..., 2] = oracle.derived_blues(*oracle.pulled(r, g, 65535), 65535, True).reshape(
                full.shape[:2]
            )
            full[oracle.radicands(*full[..., :2].astype(int).transpose(2, 0, 1), 65535) < 0] = 65535
        floats = (full / 65535).astype(np.float32)
        want, got = np.zeros(full.shape, to), np.zeros(full.shape, to)
        counts = ntp.convert(full, want, encoding, target, 0, 1, (0, touch))
        assert ntp.convert(floats, got, encoding, target, 0, 1, (0, touch)) == counts
        assert np.array_equal(got, want)
        floats[1, ::5, 0] = np.nan
        flat = {np.uint8: [128, 128, 255, 255], np.uint16: [32768, 32768, 65535, 65535]}
        assert ntp.convert(floats, got, encoding, target, 0, 1, (0, touch))[1] == len(got[1, ::5])
        assert (got[1, ::5] == flat.get(to, [0.5, 0.5, 1, 1])[:channels]).all()
        assert np.array_equal(got[::2], want[::2])
        assert np.array_equal(got[1, 1::5], want[1, 1::5])


@pytest.mark.parametrize("case", CASES, ids=case_name)
def test_clean_stays_clean(case):
    """A texel that passes `exact` passes it after every conversion."""
    encoding, m, target, to = case
    rng = np.random.default_rng(3)
    texels = np.concatenate([texels_of(m, encoding, 2000), rng.integers(0, m + 1, (40_000, 3))])
    if m == 65535:  # those that rounding to 8 bit can push off the disc
        turn = rng.uniform(0, 2 * np.pi, 60_000)
        edge = np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1) * 0.99999
        texels = np.concatenate([texels, np.floor((edge + 1) / 2 * m + 0.5).astype(int)])
    texels = texels[: len(texels) // 5 * 5]
    src = texels.reshape(5, -1, 3).astype(DEPTHS[m])
    how = ntp.clean_options(touch_unused=7)
    src, _, _ = ntp.clean(src, encoding, how)
    dst = np.zeros(src.shape, DEPTHS[to])
    ntp.convert(src, dst, encoding, target, how=(0, 7))
    assert np.all(ntp.validate(dst, target) & 7 == 7)
    assert np.array_equal(ntp.clean(dst, target, how)[0], dst)


@pytest.mark.parametrize("encoding", NAMES, ids=NAMES.get)
@pytest.mark.parametrize("target", NAMES, ids=NAMES.get)
def test_pulls_of_a_new_depth_are_counted(encoding, target):
    """Of every red of 16 bits with the greatest green on the disc, and with its mirror image."""
    m = 65535
    r = np.arange(m + 1)
    rest = m * m - (2 * r - m) ** 2
    root = np.array([math.isqrt(v) for v in rest.tolist()])
    y = root - (root % 2 == 0)  # the greatest odd number
    held = y > 0
    r, y = r[held], y[held]
    g = np.concatenate([(m + y) // 2, (m - y) // 2])
    r = np.concatenate([r, r])
    b = oracle.derived_blues(r, g, m, encoding == ntp.ZZERO)
    src = np.stack([r, g, b], -1).reshape(2, -1, 3).astype(np.uint16)
    r8, g8 = ((c + 128) // 257 for c in (r, g))
    want = int(((2 * r8 - 255) ** 2 + (2 * g8 - 255) ** 2 > 255 * 255).sum())
    assert want > 10_000
    dst = np.zeros(src.shape, np.uint8)
    assert ntp.convert(src, dst, encoding, target)[2] == want
    assert np.all(oracle.radicands(*dst[..., :2].astype(int).transpose(2, 0, 1), 255) > 0)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("to", [np.uint8, np.uint16, np.float32])
def test_the_third_sample_of_two_channels_is_full(dtype, to):
    """Also of a black texel that is converted like any other."""
    full = {np.uint8: 255, np.uint16: 65535, np.float32: 1}
    src = np.array([[[0, 0], [full[dtype]] * 2, [0, full[dtype]]]], dtype)
    for channels in (3, 4):
        for to_y in (ntp.UP, ntp.DOWN):
            dst = np.full((1, 3, channels), 7, to)
            ntp.convert(src, dst, ntp.XY, ntp.XY, ntp.UP, to_y, (0, 7))
            assert dst[0, :, 2:].tolist() == [[full[to]] * (channels - 2)] * 3
            ntp.convert(src, dst, ntp.XY, ntp.XY, ntp.UP, to_y)
            assert dst[0, :, 2].tolist() == [0, full[to], full[to]]


def test_8_to_16_to_8_is_the_identity():
    g, b = np.meshgrid(np.arange(256), np.arange(256), indexing="ij")
    for r in range(256):
        src = np.stack([np.full_like(g, r), g, b], -1).astype(np.uint8)
        for encoding in NAMES:
            wide, back = np.zeros(src.shape, np.uint16), np.zeros_like(src)
            ntp.convert(src, wide, encoding, encoding)
            ntp.convert(wide, back, encoding, encoding)
            assert np.array_equal(back, src), (r, encoding)


def test_standard_to_zzero_and_back():
    """The identity on all triplets with b > M/2."""
    g, b = np.meshgrid(np.arange(256), np.arange(128, 256), indexing="ij")
    for r in range(256):
        src = np.stack([np.full_like(g, r), g, b], -1).astype(np.uint8)
        there, back = np.zeros_like(src), np.zeros_like(src)
        ntp.convert(src, there, ntp.STANDARD, ntp.ZZERO)
        ntp.convert(there, back, ntp.ZZERO, ntp.STANDARD)
        assert np.array_equal(back, src), r


def test_flip_twice_is_the_identity():
    for m, dtype in DEPTHS.items():
        src = random_texels(m, 5000, seed=8)[None].astype(dtype)
        for encoding in NAMES:
            once, twice = np.zeros_like(src), np.zeros_like(src)
            ntp.convert(src, once, encoding, encoding, ntp.UP, ntp.DOWN)
            ntp.convert(once, twice, encoding, encoding, ntp.DOWN, ntp.UP)
            assert np.array_equal(twice, src)
            used = ~oracle.unused(src[0].astype(int), m)
            assert np.array_equal(once[0, used, 1], m - src[0, used, 1])
            assert np.array_equal(once[0, :, [0, 2]], src[0, :, [0, 2]])


@pytest.mark.parametrize("to", ["flip", "zzero", "other depth", "vectors"])
@pytest.mark.parametrize("dtype", DEPTHS.values())
def test_rows_one_behind_the_other_are_like_others(dtype, to):
    """Of more texels than are converted at once; parts, rows with a gap between them, and rings."""
    h, w = 1000, 131
    m = np.iinfo(dtype).max
    src = random_texels(m, h * w // 3 + 1, seed=9)[: h * w].astype(dtype)
    src = src.reshape(h, w, 3)
    other = {"vectors": np.float32, "other depth": np.uint16 if m == 255 else np.uint8}
    into = other.get(to, dtype)
    encoding = {"zzero": ntp.ZZERO, "vectors": ntp.VECTOR}.get(to, ntp.STANDARD)
    y = ntp.DOWN if to == "flip" else ntp.UP

    def made(part, dst, area=None):
        ntp.convert(part, dst, ntp.STANDARD, encoding, ntp.UP, y, area=area)
        return dst

    want = np.stack([made(row[None], np.zeros((1, w, 3), into))[0] for row in src])
    assert np.array_equal(made(src, np.zeros((h, w, 3), into)), want)
    wide = np.zeros((h, w + 3, 3), dtype)
    wide[:, :w] = src
    assert np.array_equal(made(wide[:, :w], np.zeros((h, w, 3), into)), want)
    gaps = np.full((h, w + 3, 3), 7, into)
    made(src, gaps[:, :w])
    assert np.array_equal(gaps[:, :w], want) and np.all(gaps[:, w:] == 7)
    for x0, y0, x1, y1 in ((0, 3, w, 900), (5, 0, w, h), (0, 1, w - 1, 700)):
        dst = made(src, np.full((h, w, 3), 7, into), (x0, y0, x1, y1))
        assert np.array_equal(dst[y0:y1, x0:x1], want[y0:y1, x0:x1])
        dst[y0:y1, x0:x1] = 7
        assert np.all(dst == 7), (x0, y0, x1, y1)
    ring = np.zeros((4, w, 3), into)
    view = ntp.view(ring, encoding, y, ring_rows=4, height=h)
    from_view, area = ntp.view(src, const=True), ntp.rect((0, 6, w, 9))
    ntp.check(ntp.lib.ntp_convert(view, from_view, ntp.ffi.NULL, ntp.ffi.NULL, area))
    assert np.array_equal(ring[[2, 3, 0]], want[6:9])


@pytest.mark.parametrize("dtype", DEPTHS.values())
def test_flips_leave_unused_texels_alone_wherever_they_lie(dtype):
    """Loops of many texels a step: every width, also in place; levels that are nearly unused."""
    m = np.iinfo(dtype).max
    rng = np.random.default_rng(6)
    for width, touch, stride in itertools.product((*range(1, 70), 300), (0, 1, 2), (3, 4)):
        src = rng.choice(np.array([0, 1, m - 1, m, 7], dtype), (2, width, stride))[..., :3]
        some = rng.random((2, width))
        src[some < 0.2] = 0
        src[some > 0.8] = m
        kept = (src == 0).all(2) & (not touch & 1) | (src == m).all(2) & (not touch & 2)
        want = src.copy()
        want[..., 1] = np.where(kept, src[..., 1], m - src[..., 1])
        dst = np.zeros_like(src)
        ntp.convert(src, dst, y=ntp.DOWN, how=(0, touch))
        assert (dst == want).all(), (width, touch, stride)
        ntp.convert(src, src, y=ntp.DOWN, how=(0, touch))
        assert (src == want).all(), (width, touch, stride)


@pytest.mark.parametrize("dtype", DEPTHS.values())
@pytest.mark.parametrize("lone", ["none", "black", "white", "green"])
def test_flips_find_a_lone_unused_texel(dtype, lone):
    """Texels of which no level is 0 or M, but for one at each place of a part, and some after it."""
    m = np.iinfo(dtype).max
    rng = np.random.default_rng(7)
    lone_texel = {"black": (0, 0, 0), "white": (m, m, m), "green": (1, 0, m)}.get(lone)
    for width, at in itertools.product((32, 96, 1500), range(96)):
        src = rng.integers(1, m, (1, width, 3)).astype(dtype)
        for x in (at, at + 33, at + 700):
            if lone_texel is not None and x < width:
                src[0, x] = lone_texel
        want = src.copy()
        want[..., 1] = m - src[..., 1]
        if lone in ("black", "white"):
            want[(src == lone_texel).all(2)] = lone_texel
        dst = np.zeros_like(src)
        ntp.convert(src, dst, y=ntp.DOWN)
        assert (dst == want).all(), (width, at)
        ntp.convert(src, src, y=ntp.DOWN)
        assert (src == want).all(), (width, at)


def vectors():
    """Vectors that are difficult to convert."""
    rng = np.random.default_rng(11)
    plain = rng.normal(size=(300, 3))
    lengths = np.float64(2.0) ** rng.integers(-60, 60, (300, 1))
    axes = np.array(list(itertools.product([-1, 0, 1], repeat=3)))
    ties = np.array([[3, 4, 0], [-3, 4, 0], [0.6, -0.8, 0], [5, 12, 84], [8, -9, 12], [0, 1, 0]])
    tiny = np.array([[1e-45, 0, 1], [-1e-45, 0, 1], [0, -1e-40, 1], [1e-45, 1e-45, 1e-45]])
    huge = np.array([[3e38, 3e38, 3e38], [-3e38, 0, 1e-45], [1, 3e38, -1], [0, 0, -3e38]])
    signed = np.array([[0.5, 0.5, -0.0], [-0.0, 0.0, 1], [1, 0, -1e-45], [-1, 1e-3, 0]])
    bad = np.array([[0, 0, 0], [-0.0, 0, 0], [np.nan, 0, 1], [0, np.inf, 1], [0, 0, -np.inf]])
    grid = rng.integers(-255, 256, (300, 3))  # many on lattice points: near ties
    parts = [plain, plain * lengths, axes, ties, tiny, huge, signed, bad, grid]
    return np.concatenate(parts).astype(np.float32)


@pytest.mark.parametrize("target", NAMES, ids=NAMES.get)
@pytest.mark.parametrize("to", DEPTHS)
def test_from_vectors(target, to):
    v = vectors()
    for flip, blue in itertools.product((0, 1), (0, 1)):
        dst = np.zeros((1, len(v), 3), DEPTHS[to])
        counts = ntp.convert(v[None], dst, ntp.VECTOR, target, 0, flip, (blue, 0))
        bad = 0
        for vector, out in zip(v, dst[0].tolist()):
            want = oracle_convert.from_vector(vector, to, target, flip, blue)
            if want is None:
                bad += 1
                want = (to + 1) // 2, (to + 1) // 2, to
            assert tuple(out) == want, (vector.tolist(), out, want, flip, blue)
        assert counts[1] == bad
        if target == ntp.ZZERO:
            finite = np.isfinite(v).all(axis=1)
            assert counts[0] == np.count_nonzero(finite & (v[:, 2] < 0))


@pytest.mark.parametrize("m", DEPTHS)
def test_to_vectors(m):
    texels = texels_of(m, ntp.STANDARD)
    src = texels[None].astype(DEPTHS[m])
    dst = np.zeros(src.shape, np.float32)
    ntp.convert(src, dst, ntp.STANDARD, ntp.VECTOR)
    assert np.array_equal(dst[0], ((2 * texels - m) / m).astype(np.float32))
    ntp.convert(src, dst, ntp.ZZERO, ntp.VECTOR)
    assert np.array_equal(dst[0, :, 2], (texels[:, 2] / m).astype(np.float32))
    ntp.convert(src, dst, ntp.STANDARD, ntp.VECTOR, ntp.UP, ntp.DOWN, how=(0, 7))
    assert np.array_equal(dst[0, :, 1], (-(2 * texels[:, 1] - m) / m).astype(np.float32))
    ntp.convert(src, dst, ntp.XY, ntp.VECTOR, how=(0, 7))
    r, g = oracle.pulled(texels[:, 0], texels[:, 1], m)
    z = np.sqrt(oracle.radicands(r, g, m).astype(np.float64)) / m
    assert np.allclose(dst[0, :, 2], z, rtol=1e-7, atol=0)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_unused_texels_of_two_channels_stay(dtype):
    full = 1 if dtype is np.float32 else np.iinfo(dtype).max
    src = np.array([[[0, 0], [full, full]]], dtype)
    for target in NAMES:
        for to in (np.uint8, np.uint16, np.float32):
            white = 1 if to is np.float32 else np.iinfo(to).max
            dst = np.full((1, 2, 3), 77, to)
            counts = ntp.convert(src, dst, ntp.XY, target)
            assert dst.tolist() == [[[0, 0, 0], [white] * 3]] and not any(counts)
    dst = np.zeros((1, 2, 3), np.float32)
    counts = ntp.convert(src, dst, ntp.XY, ntp.VECTOR)
    assert dst.tolist() == [[[-1, -1, -1], [1, 1, 1]]] and not any(counts)


def test_float_images_round_to_16_bit_and_back():
    """Every 16-bit level, and the floats around the rounding boundaries."""
    levels = np.arange(65536)
    src = (levels / 65535).astype(np.float32).reshape(256, 256, 1)
    dst = np.zeros((256, 256, 1), np.uint16)
    ntp.convert(src, dst, ntp.HEIGHT, ntp.HEIGHT)
    assert np.array_equal(dst.ravel(), levels)
    wide = np.zeros_like(src)
    ntp.convert(dst, wide, ntp.HEIGHT, ntp.HEIGHT)
    assert np.array_equal(wide, src)
    edges = ((levels[:-1] + 0.5) / 65535).astype(np.float32)
    edges = np.concatenate([np.nextafter(edges, np.float32(0)), edges, np.nextafter(edges, 1)])
    edges = np.concatenate([edges, [-1, -0.0, 2, 1e30, -1e30, 1e-45]]).astype(np.float32)
    for dtype, m in ((np.uint16, 65535), (np.uint8, 255)):
        out = np.zeros((len(edges), 1, 1), dtype)
        for rows in (
            slice(0, 65535),
            slice(65535, 131070),
            slice(131070, 196605),
            slice(196605, None),
        ):
            ntp.convert(edges[rows, None, None], out[rows], ntp.HEIGHT, ntp.HEIGHT)
        exact = edges.astype(np.float64)  # 24 + 16 bits: the product is exact
        assert np.array_equal(out.ravel(), np.clip(np.floor(exact * m + 0.5), 0, m).astype(int))


def test_heights_by_value():
    for channels in (1, 2, 3, 4):
        src = np.resize(np.arange(65536, dtype=np.uint16), (300, 256, channels))
        dst = np.zeros(src.shape, np.uint8)
        ntp.convert(src, dst, ntp.HEIGHT, ntp.HEIGHT, ntp.UP, ntp.DOWN)
        assert np.array_equal(dst, (src.astype(int) + 128) // 257)


def test_in_place():
    for m, dtype in DEPTHS.items():
        src = random_texels(m, 300, seed=2)[None].astype(dtype)
        want = np.zeros_like(src)
        ntp.convert(src, want, ntp.STANDARD, ntp.ZZERO, ntp.UP, ntp.DOWN)
        ntp.convert(src, src, ntp.STANDARD, ntp.ZZERO, ntp.UP, ntp.DOWN)
        assert np.array_equal(src, want)


def status(src, dst, *args, **kwargs):
    with pytest.raises(ntp.NtpError) as error:
        ntp.convert(src, dst, *args, **kwargs)
    return error.value.status


def test_errors():
    a = np.zeros((4, 5, 3), np.uint8)
    assert status(a, np.zeros((4, 6, 3), np.uint8)) == ntp.ERR_SHAPE
    assert status(a, np.zeros((4, 5, 1), np.uint8), 0, ntp.HEIGHT) == ntp.ERR_FORMAT
    assert status(a, np.zeros((4, 5, 2), np.uint8), 0, ntp.STANDARD) == ntp.ERR_FORMAT
    assert status(a, np.zeros((4, 5, 3), np.uint8), 0, ntp.VECTOR) == ntp.ERR_FORMAT
    assert status(a, a.copy(), how=(2, 0)) == ntp.ERR_ARGUMENT
    assert status(a, a.copy(), how=(0, 8)) == ntp.ERR_ARGUMENT
    assert status(a, a.copy(), area=(0, 0, 6, 4)) == ntp.ERR_SHAPE
    assert status(a, a.copy(), area=(2, 1, 2, 3)) == ntp.ERR_SHAPE


@pytest.mark.parametrize("y", [ntp.UP, ntp.DOWN], ids=["same", "flip"])
@pytest.mark.parametrize("m", DEPTHS)
def test_to_vectors_every_level(m, y):
    """Also beside unused texels, whose green keeps its sign in a flip, and in strides."""
    for channels, encoding in itertools.product((3, 4), (ntp.STANDARD, ntp.ZZERO)):
        texels = np.repeat(np.arange(m + 1)[:, None], channels, 1)
        texels[:, 0] = texels[::-1, 0]
        texels[m // 5 :: 7] = 0
        texels[m // 3 :: 11, :3] = m
        src = texels.reshape(-1, 256, channels).astype(DEPTHS[m])
        unused = ((texels[:, :3] == 0).all(1)) | ((texels[:, :3] == m).all(1))
        unused |= texels[:, -1] == 0 if channels == 4 else False
        want = (2 * texels - m) / m
        want[:, 2 if encoding == ntp.ZZERO else 3 :] = (
            texels[:, 2 if encoding == ntp.ZZERO else 3 :] / m
        )
        want[:, 1] *= np.where(unused | (y == ntp.UP), 1, -1)
        for view in (src, np.dstack([src, src])[..., :channels]):
            dst = np.zeros(src.shape, np.float32)
            ntp.convert(view, dst, encoding, ntp.VECTOR, ntp.UP, y)
            assert np.array_equal(dst.reshape(want.shape), want.astype(np.float32))


@pytest.mark.parametrize("channels", [2, 3, 4])
@pytest.mark.parametrize("m", DEPTHS)
def test_pairs_to_vectors(m, channels):
    """Rows of several blocks; of 8 bit all pairs."""
    levels = np.indices((256, 256)).reshape(2, -1).T
    if m > 255:
        levels = np.random.default_rng(7).integers(0, m + 1, levels.shape)
    rest = np.full((len(levels), channels - 2), m // 3)
    src = np.ascontiguousarray(np.hstack([levels, rest]).astype(DEPTHS[m])).reshape(
        16, -1, channels
    )
    dst = np.zeros((*src.shape[:2], 4), np.float32)
    counts = ntp.convert(src, dst, ntp.XY, ntp.VECTOR, how=(0, 7))
    r, g = oracle.pulled(levels[:, 0], levels[:, 1], m)
    z = np.sqrt(oracle.radicands(r, g, m).astype(np.float64)) / m
    alpha = np.full(len(z), m // 3 / m if channels == 4 else 1)
    want = np.stack([(2 * r - m) / m, (2 * g - m) / m, z, alpha], 1).astype(np.float32)
    assert np.array_equal(dst.reshape(want.shape), want)
    long = oracle.radicands(levels[:, 0], levels[:, 1], m) < 0
    assert counts[2] == np.count_nonzero(long) > 1000


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.ZZERO, ntp.VECTOR])
def test_floats_to_vectors(encoding, flip):
    """2v - 1 rounded once; what is no vector is flat.  Also in place, and between other floats."""
    rng = np.random.default_rng(8)
    zero = [0, 0, 0] if encoding == ntp.VECTOR else [0.5, 0.5, 0 if encoding == ntp.ZZERO else 0.5]
    src = rng.uniform(-0.5, 1.5, (3, 1000, 4)).astype(np.float32)
    src[1, 300:320] *= 1e-30
    src[1, 700, :3] = 0, 0.5, 1e30
    src[2, 5::9, 2] = rng.choice([np.nan, np.inf, -np.inf], len(range(5, 1000, 9)))
    src[0, 7::11, :3] = zero
    src[0, 600:603, :3] = 0, 1, -0.0
    broken = ~np.isfinite(src[..., :3]).all(-1) | (src[..., :3] == np.float32(zero)).all(-1)
    biased = 0 if encoding == ntp.VECTOR else 2 if encoding == ntp.ZZERO else 3
    want = src.astype(np.float64)
    want[..., :biased] = 2 * want[..., :biased] - 1
    levels = np.clip(np.floor(src.astype(np.float64) * 65535 + 0.5), 0, 65535)
    unused = (levels == 0).all(-1) | (levels == 65535).all(-1) | (levels[..., 3] == 0)
    unused |= (levels[..., :3] == 0).all(-1) | (levels[..., :3] == 65535).all(-1)
    turned = flip & (~unused if encoding != ntp.VECTOR else np.full(unused.shape, True))
    want[..., 1] *= np.where(turned, -1, 1)
    want = want.astype(np.float32)
    want[broken] = 0, 0, 1, 1
    y = ntp.DOWN if flip else ntp.UP
    among = np.repeat(src, 2, 1)[:, ::2]
    for view in (src, among, src.copy()):
        dst = view if view is among else np.zeros_like(src)
        counts = ntp.convert(view, dst, encoding, ntp.VECTOR, ntp.UP, y)
        assert np.array_equal(dst, want) and counts[1] == np.count_nonzero(broken) > 100
