# SPDX-License-Identifier: MIT
"""The test oracle against itself (slow and fast halves) and against the published counts."""

import zlib
from fractions import Fraction

import numpy as np
import pytest

from support import oracle, pngs
from support.texels import random_texels

M8, M16 = 255, 65535
LEVELS = np.arange(256)


def planes():
    """(r, g, b) of all 2**24 triplets, one red at a time."""
    g, b = np.meshgrid(LEVELS, LEVELS, indexing="ij")
    for r in range(256):
        yield r, g, b


def test_encode():
    assert oracle.encode(Fraction(0), M8) == 128
    assert oracle.encode(Fraction(0), M16) == 32768
    assert oracle.encode_zzero(Fraction(1, 510), M8) == 1
    for m in (M8, M16):
        for c in range(0, m + 1, 1 if m == M8 else 251):
            assert oracle.encode(Fraction(2 * c - m, m), m) == c
            assert oracle.encode_zzero(Fraction(c, m), m) == c


def test_published_counts():
    """The table of the definitions, 8 bit, by enumeration with the fast oracle."""
    counts = dict.fromkeys(["exact", "rounded", "rounded128", "neighbor", "neighbor128"], 0)
    zz = dict.fromkeys(["exact", "rounded", "neighbor"], 0)
    reference = {"b127": 0, "b128": 0}
    for r, g, b in planes():
        flags = oracle.flags(r, g, b, M8)
        counts["exact"] += np.count_nonzero(flags & 4)
        counts["rounded"] += np.count_nonzero(flags & 2)
        counts["rounded128"] += np.count_nonzero((flags & 2 > 0) & (b >= 128))
        counts["neighbor"] += np.count_nonzero(flags & 1)
        counts["neighbor128"] += np.count_nonzero((flags & 1 > 0) & (b >= 128))
        near = np.hypot((2 * r - M8) / M8, (2 * g - M8) / M8) <= 1.00774
        reference["b127"] += np.count_nonzero((flags & 1 > 0) & near & (b >= 127))
        reference["b128"] += np.count_nonzero((flags & 1 > 0) & near & (b >= 128))
        assert not np.any((flags & 4 > 0) & (flags & 2 == 0)), "exact implies rounded"
        assert not np.any((flags & 2 > 0) & (flags & 1 == 0)), "rounded implies neighbor"
        flags = oracle.flags(r, g, b, M8, zz=True)
        zz["exact"] += np.count_nonzero(flags & 4)
        zz["rounded"] += np.count_nonzero(flags & 2)
        zz["neighbor"] += np.count_nonzero(flags & 1)
    assert counts == {
        "exact": 51_040,
        "rounded": 306_608,
        "rounded128": 153_304,
        "neighbor": 612_496,
        "neighbor128": 306_248,
    }
    assert zz == {"exact": 51_040, "rounded": 255_920, "neighbor": 511_448}
    assert reference == {"b127": 306_472, "b128": 304_656}


def test_closed_form_counts():
    assert oracle.count_passing(M8, False, 1) == 306_608
    assert oracle.count_passing(M8, False, 2) == 612_496
    assert oracle.count_passing(M8, True, 1) == 255_920
    assert oracle.count_passing(M8, True, 2) == 511_448


def test_pairs_on_the_disc():
    inside = sum(np.count_nonzero(oracle.radicands(r, LEVELS, M8) >= 0) for r in range(256))
    assert inside == 51_040
    # 16 bit: for each |X| the number of |Y| with Y*Y <= M*M - X*X, four times
    x = np.arange(1, M16 + 1, 2, dtype=np.int64)
    assert 4 * int(((oracle.isqrt(M16 * M16 - x * x) + 1) // 2).sum()) == 3_373_155_896


def test_over_long_pairs():
    """14,496 pairs; the mean angle of the pull; no pull leaves the disc; symmetries."""
    table = oracle.derive_table()
    r, g = np.meshgrid(LEVELS, LEVELS, indexing="ij")
    over = oracle.radicands(r, g, M8) < 0
    assert np.count_nonzero(over) == 14_496
    assert np.all(oracle.radicands(table[..., 0], table[..., 1], M8) >= 0)
    v = [2 * c - M8 for c in (r[over], g[over])]
    w = [2 * c - M8 for c in np.moveaxis(table[over], -1, 0)]
    length = np.sqrt(w[0] ** 2 + w[1] ** 2 + w[2] ** 2) * np.sqrt(v[0] ** 2 + v[1] ** 2)
    mean = np.degrees(np.arccos((v[0] * w[0] + v[1] * w[1]) / length)).mean()
    assert round(float(mean), 2) == 3.43
    assert np.array_equal(table[::-1, :, 0], M8 - table[:, :, 0])
    assert np.array_equal(table[:, ::-1, 1], M8 - table[:, :, 1])
    assert np.array_equal(table[..., 0], table[..., 1].T)
    assert np.array_equal(table[..., 2], table[::-1, :, 2])
    assert np.array_equal(table[..., 2], table[..., 2].T)


def test_reference_programs_cleaning_is_worse():
    """The count of the definitions for normalise-then-round: 7,128 pairs stay over-long."""
    r, g = np.meshgrid(LEVELS, LEVELS, indexing="ij")
    over = oracle.radicands(r, g, M8) < 0
    x, y = 2 * r[over] - M8, 2 * g[over] - M8
    n = np.sqrt(x * x + y * y)
    again = [np.floor((M8 * c / n + M8 + 1) / 2).astype(int) for c in (x, y)]
    assert np.count_nonzero(oracle.radicands(*again, M8) < 0) == 7_128


@pytest.mark.parametrize("m", [M8, M16])
@pytest.mark.parametrize("zz", [False, True])
def test_fast_equals_slow(m, zz):
    texels = random_texels(m, 700, seed=m + zz)
    r, g, b = texels.T
    for keep in (False, True):
        fast = oracle.flags(r, g, b, m, zz, keep)
        for (rr, gg, bb), got in zip(texels.tolist(), fast.tolist()):
            want = 1 * oracle.neighbor(rr, gg, bb, m, zz) + 2 * oracle.rounded(rr, gg, bb, m, zz)
            want += 4 * oracle.exact(rr, gg, bb, m, zz, keep)
            want += 8 * (oracle.radicand(rr, gg, m) < 0) + 16 * oracle.z_negative(bb, m, zz)
            assert got == want, (rr, gg, bb)
    pr, pg = oracle.pulled(r, g, m)
    blue = oracle.derived_blues(pr, pg, m, zz)
    degrees = oracle.angles(r, g, b, m, zz)
    for (rr, gg, bb), x, y, z, a in zip(texels.tolist(), pr, pg, blue, degrees):
        assert (x, y) == oracle.pull(rr, gg, m), (rr, gg)
        assert z == oracle.derived_blue(int(x), int(y), m, zz)
        stored = oracle.vector((rr, gg, bb), m, zz)
        assert abs(a - oracle.angle(stored, oracle.vector((x, y, z), m, zz))) < 1e-9


@pytest.mark.parametrize("zz", [False, True])
@pytest.mark.parametrize("method", ["derive", "normalize", "keep"])
def test_fast_cleaning_equals_slow(zz, method):
    texels = random_texels(M8, 400, seed=5)
    for keep in (False, True):
        fast = oracle.all_cleaned(*texels.T, zz, method, keep)
        for texel, got in zip(texels.tolist(), fast.tolist()):
            assert oracle.cleaned(*texel, M8, zz, method, keep) == tuple(got), texel


@pytest.mark.parametrize("zz", [False, True])
def test_normalized_is_rounded(zz):
    """The slow model's own consequence, 16 bit included."""
    for m in (M8, M16):
        for r, g, b in random_texels(m, 150, seed=9).tolist():
            assert oracle.rounded(*oracle.normalized(r, g, b, m, zz), m, zz)


@pytest.mark.parametrize("texel", [1, 2, 3, 4, 6, 8])
def test_both_readers_of_png_agree(texel):
    """With all filters, in any order of the rows."""
    rng = np.random.default_rng(texel)
    rows = rng.integers(0, 256, (60, 1 + 21 * texel)).astype(np.uint8)
    rows[:, 0] = rng.integers(0, 5, 60)
    data = zlib.compress(rows.tobytes())
    one, other = (f(data, 60, 21, texel) for f in (pngs.unfiltered, pngs.unfiltered_by_pillow))
    assert one == other and len(one) == 60 * 21 * texel
