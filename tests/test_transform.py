# SPDX-License-Identifier: MIT
"""ntp_transform against numpy's turns and an integer model of strength."""

import itertools
from fractions import Fraction

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle
from support import oracle_vectors as model
from support.oracle_transform import moved_picture, turned, unused_mask
from support.texels import NAMES, TYPES, noise

STRENGTHS = [0.0, 0.5, 0.1, 2.0, 1 / 3, 7.25, 1000.0, 1024.0, 2.0**-10, -0.7, -3.0, 1 + 2.0**-52]


def transform(
    src, flips=(0, 0), turns=0, strength=None, encoding=ntp.STANDARD, y=ntp.UP, area=None, dst=None
):
    h, w = src.shape[:2][:: -1 if turns % 2 else 1]
    dst = np.full((h, w, src.shape[2]), 77, src.dtype) if dst is None else dst
    how = ntp.ffi.new("ntp_transform_options *")
    how.flip_x, how.flip_y, how.quarter_turns = *flips, turns
    how.use_strength, how.strength = strength is not None, strength or 0.0
    source = ntp.view(src, encoding, y, const=True)
    ntp.check(ntp.lib.ntp_transform(ntp.view(dst, encoding, y), source, how, ntp.rect(area)))
    return dst


@pytest.mark.parametrize("y_axis", [ntp.UP, ntp.DOWN])
@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("encoding", NAMES)
def test_moves_against_numpy(encoding, m, y_axis):
    shapes = [(7, 300), (141, 70)]  # the second is turned in more than one tile
    every = (2, 3, 4) if encoding == ntp.XY else (3, 4)
    for shape, channels in itertools.product(shapes, every):
        src = noise((*shape, channels), m, channels)
        for fx, fy, turns in itertools.product((0, 1), (0, 1), range(4)):
            want = moved_picture(src, (fx, fy), turns).astype(np.int64)
            x, y = 2 * want[..., 0] - m, 2 * want[..., 1] - m
            x, y = turned(x, y, (fx, fy), turns, y_axis)
            used = ~unused_mask(want, m)
            want[..., 0][used] = ((x + m) // 2)[used]
            want[..., 1][used] = ((y + m) // 2)[used]
            got = transform(src, (fx, fy), turns, None, encoding, y_axis)
            assert np.array_equal(got, want)


@pytest.mark.parametrize("m", [255, 65535])
def test_strength_of_pairs_is_that_of_the_vectors_they_stand_for(m):
    """In rows of several blocks, where many pairs are pulled."""
    pairs = np.random.default_rng(m).integers(1, m, (3, 1000, 2)).astype(TYPES[m])
    pairs[0] = pairs[0] // 4 + 3 * m // 8  # none of this row is too long
    r, g = oracle.pulled(*pairs.reshape(-1, 2).T.astype(np.int64), m)
    blues = oracle.derived_blues(r, g, m)
    texels = np.stack([r, g, blues], 1).reshape(3, 1000, 3).astype(TYPES[m])
    want = transform(texels, strength=1.3)[..., :2]
    assert np.array_equal(transform(pairs, strength=1.3, encoding=ntp.XY), want)


@pytest.mark.parametrize("turns", [1, 3])
@pytest.mark.parametrize("m", [255, 65535])
def test_large_turns(m, turns):
    """Rows of large results are written past the caches, whole lines of them."""
    src = noise((1999, 1403 if m == 255 else 703, 3), m, turns)
    assert src.nbytes > 2**23
    src[src[..., 0] < m // 8] = 0
    room = np.full(src.size + 64, 77, src.dtype)
    dst = room[5 : 5 + src.size].reshape(src.shape[1], src.shape[0], 3)
    transform(src, turns=turns, dst=dst)
    want = moved_picture(src, (0, 0), turns).astype(np.int64)
    x, y = turned(2 * want[..., 0] - m, 2 * want[..., 1] - m, (0, 0), turns, ntp.UP)
    used = ~unused_mask(want, m)
    assert not used.all()
    want[..., 0][used] = ((x + m) // 2)[used]
    want[..., 1][used] = ((y + m) // 2)[used]
    assert np.array_equal(dst, want)
    assert (room[:5] == 77).all() and (room[5 + src.size :] == 77).all()


@pytest.mark.parametrize("m", TYPES)
def test_groups(m):
    src = noise((9, 14, 4), m, 1)
    once = transform(src, turns=1)
    assert np.array_equal(transform(once, turns=1), transform(src, turns=2))
    assert np.array_equal(transform(transform(once, turns=1), turns=1), transform(src, turns=3))
    assert np.array_equal(transform(once, turns=3), src)
    assert np.array_equal(transform(transform(src, (1, 0)), (1, 0)), src)
    assert np.array_equal(transform(src, (1, 1)), transform(src, turns=2))
    assert np.array_equal(transform(src, strength=1.0), src)
    inverted = transform(src, strength=-1.0)
    assert np.array_equal(transform(inverted, strength=-1.0), src)
    assert np.array_equal(transform(src), src)


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("encoding", NAMES)
def test_strength_against_integers(encoding, m):
    src = noise((6, 20, 4), m, 3)
    src[..., 3] = np.maximum(src[..., 3], 1)
    src[0, :8, :2] = m // 2 + np.arange(16).reshape(8, 2) % 2
    cases = [(s, (0, 0), 0, ntp.UP) for s in STRENGTHS] + [(0.3, (1, 0), 1, ntp.DOWN)]
    for strength, flips, turns, y_axis in cases:
        got = transform(src, flips, turns, strength, encoding, y_axis)
        want = moved_picture(src, flips, turns).copy()
        scale = Fraction(strength)
        for texel in want.reshape(-1, 4):
            levels = [int(c) for c in texel]
            if model.unused(levels, m):
                continue
            x, y, z = model.components(levels[:3], m, NAMES[encoding])
            x, y = turned(x, y, flips, turns, y_axis)
            v = (x * scale.numerator, y * scale.numerator, z * scale.denominator)
            levels = model.encode(v, m, NAMES[encoding])
            texel[: len(levels)] = levels
        assert np.array_equal(got, want), strength


def test_tiny_strength_is_rounded_to_its_grid():
    src = noise((6, 20, 3), 65535, 4, "flat")
    assert np.array_equal(transform(src, strength=1e-200), transform(src, strength=0.0))
    tiny = transform(src, strength=2.0**-61)
    used = ~unused_mask(src, 65535)
    assert np.all(np.abs(tiny[used][:, :2].astype(int) - 32768) <= 1)


def test_results_are_exact():
    src = noise((30, 40, 3), 255, 5)
    out = transform(src, strength=1.7)
    flags = ntp.validate(out, keep=1)
    assert np.all((flags & (ntp.PASS_EXACT | ntp.IS_UNUSED)) != 0)
    clean = ntp.clean(src)[0]
    for turns in range(4):
        flags = ntp.validate(transform(clean, turns=turns))
        assert np.all((flags & (ntp.PASS_EXACT | ntp.IS_UNUSED)) != 0)


def test_areas_make_the_whole():
    src = noise((11, 13, 4), 65535, 6)
    whole = transform(src, (1, 0), 3, 1.3)
    dst = np.zeros_like(whole)
    for area in ((5, 0, 11, 13), (0, 7, 5, 13), (0, 0, 5, 7)):
        transform(src, (1, 0), 3, 1.3, area=area, dst=dst)
    assert np.array_equal(dst, whole)


def test_floats():
    rng = np.random.default_rng(7)
    biased = rng.random((5, 6, 4)).astype(np.float32)
    biased[0, 0, :3] = 0
    biased[0, 1, 0] = np.nan
    out = transform(biased, (1, 0), 1)
    want = np.rot90(biased[:, ::-1], -1).copy()
    red, green = want[..., 0].astype(np.float64), want[..., 1].astype(np.float64)
    x, y = green, red  # (-x, y) turned is (y, x)
    kept = np.all(want[..., :3] == 0, -1) | np.isnan(red)
    want[..., 0] = np.where(kept, want[..., 0], x.astype(np.float32))
    want[..., 1] = np.where(kept, want[..., 1], y.astype(np.float32))
    assert np.array_equal(out, want, equal_nan=True)
    vectors = (rng.random((5, 6, 3)) * 2 - 1).astype(np.float32)
    half = transform(vectors, turns=2, encoding=ntp.VECTOR)
    assert np.array_equal(half, vectors[::-1, ::-1] * np.float32([-1, -1, 1]))
    mirrored = transform(biased[1:], (0, 1))
    assert np.array_equal(mirrored[..., 1], (1 - biased[:0:-1, :, 1].astype(float)).astype("f4"))


def float_levels(v, vector):
    """As definitions of float samples say; products of 40 bits are exact."""
    v = np.nan_to_num(v.astype(np.float64), nan=-2.0 if vector else 0.0, posinf=9e9, neginf=-9e9)
    if vector:
        return (65536 + np.floor(np.clip(v * 65535, -65536, 65535))) // 2
    return np.clip(np.floor(v * 65535 + 0.5), 0, 65535)


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.ZZERO, ntp.VECTOR])
def test_unused_floats(encoding, channels):
    """All texels of a run are turned at once if none may be unused: here some, one, or none are."""
    rng = np.random.default_rng(channels)
    vector = encoding == ntp.VECTOR
    ends = [0, 0.4 / 65535, 0.6 / 65535, 1e-4, 0.9999, 65534.4 / 65535, 65534.6 / 65535, 1, 2]
    special = [*ends, *(-v for v in ends), 0.5, 1e-42, 3e38, -3e38, np.nan, np.inf, -np.inf]
    special += [np.nextafter(np.float32(v), np.float32(w)) for v in ends for w in (-9, 9)]
    src = (rng.random((900, 7, channels)) * (2 if vector else 1) - vector).astype(np.float32)
    src[..., 3:] = np.abs(src[..., 3:])
    src[:300] = rng.choice(np.array(special, np.float32), (300, 7, channels))
    for row in range(300, 600):  # one sample of another kind, or a texel of one
        at = rng.integers(7)
        some = slice(None) if row % 2 else rng.integers(channels)
        src[row, at, some] = rng.choice(np.array(special, np.float32))
    zero = np.array([-0.0, 0, 0] if vector else [0.5, 0.5, 0 if encoding == ntp.ZZERO else 0.5])
    src[rng.random(src.shape[:2]) < 0.01, :3] = zero
    unused = ~np.isfinite(src[..., :3]).all(-1) | (src[..., :3] == zero).all(-1)
    levels = float_levels(src, vector)
    unused |= (levels[..., :3] == 0).all(-1) | (levels[..., :3] == 65535).all(-1)
    if channels == 4:
        unused |= float_levels(src[..., 3], False) == 0
    assert 0 < unused[600:].sum() < 200 < unused[:300].sum() < 2000
    want = src.copy()
    mirrored = (0.0 if vector else 1.0) - src[..., 0].astype(np.float64)
    want[..., 0] = np.where(unused, src[..., 0], mirrored.astype(np.float32))
    got = transform(src, (1, 0), encoding=encoding)
    assert np.array_equal(got.view(np.uint32), want[:, ::-1].copy().view(np.uint32))


def test_float_strength_goes_by_16_bit():
    levels = noise((6, 9, 4), 65535, 8)
    want = transform(levels, strength=2.5) / 65535.0
    floats = (levels / 65535).astype(np.float32)
    assert np.array_equal(transform(floats, strength=2.5), want.astype(np.float32))


def test_refusals():
    src = np.zeros((4, 6, 3), np.uint8)
    how = ntp.ffi.new("ntp_transform_options *")

    def status(dst, turns=0, strength=1.0, **fields):
        how.quarter_turns, how.use_strength, how.strength = turns, 1, strength
        source = ntp.view(src, const=True, **fields)
        return ntp.lib.ntp_transform(dst, source, how, ntp.ffi.NULL)

    same, other = np.zeros((4, 6, 3), np.uint8), np.zeros((6, 4, 3), np.uint8)
    assert status(ntp.view(same)) == status(ntp.view(other), 1) == ntp.OK
    assert status(ntp.view(other)) == status(ntp.view(same), 1) == ntp.ERR_SHAPE
    assert status(ntp.view(src)) == ntp.ERR_OVERLAP
    assert status(ntp.view(same, ntp.XY)) == ntp.ERR_FORMAT
    for strength in (float("nan"), float("inf"), -1024.5, 1e300):
        assert status(ntp.view(same), 0, strength) == ntp.ERR_ARGUMENT
    assert status(ntp.view(same), 4) == status(ntp.view(same), -1) == ntp.ERR_ARGUMENT
    assert status(ntp.view(same), 2, ring_rows=4) == ntp.ERR_SHAPE
    assert status(ntp.view(same), 0, ring_rows=4) == ntp.OK
