# SPDX-License-Identifier: MIT
"""ntp_blend against the published formulas in fractions."""

import itertools
import math

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support.oracle_blend import LINEAR, RNM, UDN, WHITEOUT, blend_by_model
from support.texels import NAMES, TYPES, noise


def blend(
    base,
    detail,
    mode=RNM,
    strength=None,
    encodings=(0, 0),
    ys=(0, 0),
    touch=0,
    area=None,
    dst=None,
    fades=False,
):
    how = ntp.ffi.new("ntp_blend_options *")
    how.mode, how.touch_unused, how.detail_alpha = mode, touch, fades
    how.use_strength, how.strength = strength is not None, strength or 0.0
    dst = np.full_like(base, 77) if dst is None else dst
    source = ntp.view(base, encodings[0], ys[0], const=True)
    second = ntp.view(detail, encodings[1], ys[1], const=True)
    target = ntp.view(dst, encodings[0], ys[0])
    ntp.check(ntp.lib.ntp_blend(target, source, second, how, ntp.rect(area)))
    return dst


@pytest.mark.parametrize("mode", [RNM, WHITEOUT, UDN, LINEAR])
@pytest.mark.parametrize("m", TYPES)
def test_against_fractions(m, mode):
    strengths = itertools.cycle([1.0, 0.5, 0.1, 3.0, 1024.0, 2.0**-10, 0.0, -0.7])
    depths = itertools.cycle([255, 65535])
    for e1, e2, ys in itertools.product(NAMES, NAMES, [(0, 0), (0, 1)]):
        strength, m2 = next(strengths), next(depths)
        base = noise((6, 9, 2 if e1 == ntp.XY and mode else 4), m, 3 + e1)
        detail = noise((4, 5, 3), m2, 5 + e2)
        for touch in (0, 7) if ys == (0, 1) else (0,):
            got = blend(base, detail, mode, strength, (e1, e2), ys, touch)
            want = blend_by_model(base, detail, mode, strength, (e1, e2), ys, (m, m2), touch)
            assert np.array_equal(got, want), (e1, e2, ys, strength, touch)


@pytest.mark.parametrize("m", TYPES)
def test_vectors_that_cancel_each_other(m):
    """Of packed pixels, as many as loops take at once: nothing is left, or hardly anything."""
    base = noise((2, 40, 3), m, 6)
    for off, strength in itertools.product((0, 1), (1.0, 1 + 2.0**-30)):
        detail = (m - base.astype(int) ^ off).astype(base.dtype)
        got = blend(base, detail, LINEAR, strength)
        want = blend_by_model(base, detail, LINEAR, strength, (0, 0), (0, 0), (m, m), 0)
        assert np.array_equal(got, want), (off, strength)


# Pairs of 8 bit that are close to a boundary, where a product of the blend has 25 bits: floats have 24.
WIDE_PRODUCTS = [
    ((20, 69, 253), (253, 145, 236)),
    ((24, 141, 253), (254, 236, 242)),
    ((35, 213, 243), (250, 81, 252)),
    ((9, 87, 250), (255, 245, 195)),
    ((10, 229, 254), (248, 23, 173)),
    ((16, 63, 255), (249, 167, 215)),
    ((2, 65, 251), (252, 166, 192)),
    ((5, 199, 252), (255, 79, 199)),
    ((4, 78, 253), (254, 255, 185)),
    ((12, 245, 254), (250, 9, 161)),
    ((5, 113, 243), (251, 38, 215)),
    ((20, 24, 254), (254, 102, 239)),
]  # fmt: skip


def test_products_that_are_too_wide_for_floats():
    pairs = np.array(WIDE_PRODUCTS, np.uint8)
    base, detail = (np.ascontiguousarray(pairs[None, :, k]) for k in range(2))
    got = blend(base, detail)
    assert np.array_equal(
        got, blend_by_model(base, detail, RNM, 1.0, (0, 0), (0, 0), (255, 255), 0)
    )


def ties(m):
    """(x, y, z) of whole length L, which divides M: M x / 2L and M y / 2L are whole numbers for even x and y."""
    found = []
    for length in (k for k in range(3, 300, 2) if m % k == 0):
        for x, y in itertools.product(range(0, length, 2), repeat=2):
            z = math.isqrt(max(length**2 - x**2 - y**2, 0))
            if z % 2 and x * x + y * y + z * z == length**2:
                found.append((x, y, z))
    return found


def near_ties(m, rng, least, most):
    """Whole (x, y, z) where M x / 2L is closer to a whole number than doubles say."""
    found = []
    while len(found) < 25:
        x = rng.integers(1, m + 1, 1 << 20).astype(object)
        k = (x * rng.uniform(least, most, x.size)).astype(int).clip(1, None)
        square, by = x * x * m * m, 4 * k * k
        length2 = (square + by // 2) // by
        far = np.abs(square - by * length2).astype(float) / (square / k).astype(float)
        for i in np.flatnonzero(far < 2.0**-34)[:40]:
            y = np.arange(1, m + 1)
            z2 = int(length2[i] - x[i] * x[i]) - y * y
            z = np.sqrt(np.maximum(z2, 0)).round().astype(int)
            right = np.flatnonzero((z > 0) & (z * z == z2) & (z <= m))
            if right.size:
                found.append((x[i], int(y[right[0]]), int(z[right[0]])))
    return found


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("m", TYPES)
def test_ties_and_what_is_close_to_them(m, channels):
    """Each vector is the sum of a base and a detail, whose numerators are odd: so twice whole numbers."""
    rng = np.random.default_rng(m)
    exact = np.array(ties(m), int)
    exact = np.concatenate([exact[:150] * k for k in (1, m // int(exact.max()))])
    close = np.array(near_ties(m, rng, 0.26, 0.49), int) if m > 255 else exact[:0]
    for signs in itertools.product((1, -1), repeat=3):
        v = np.concatenate([exact, close, close[:, [1, 0, 2]]]) * signs
        one = np.where(v % 2, v, np.where(v < m, v + 1, v - 1))
        both = [((n + m) // 2).astype(f"u{1 if m == 255 else 2}") for n in (one, 2 * v - one)]
        base, detail = (np.insert(t, 3, m, 1)[None, :, :channels].copy() for t in both)
        for strength, other in ((1.0, detail), (-1.0, m - detail)):
            if strength < 0:
                other[..., 2:] = detail[..., 2:]
            got = blend(base, other, LINEAR, strength)
            want = blend_by_model(base, other, LINEAR, strength, (0, 0), (0, 0), (m, m), 0)
            assert np.array_equal(got, want), (signs, strength)


@pytest.mark.parametrize("mode", [RNM, WHITEOUT, UDN, LINEAR])
def test_alpha_fades_the_detail(mode):
    for m, m2, e2, strength in (
        (255, 65535, ntp.STANDARD, 1.0), (65535, 255, ntp.ZZERO, 0.3),
        (65535, 65535, ntp.XY, -1024.0), (255, 255, ntp.STANDARD, 2.0**-61),
    ):  # fmt: skip
        base, detail = noise((5, 9, 3), m, 3), noise((4, 5, 4), m2, 5)
        for touch in (0, 7):
            got = blend(base, detail, mode, strength, (0, e2), (0, 1), touch, fades=True)
            want = blend_by_model(
                base, detail, mode, strength, (0, e2), (0, 1), (m, m2), touch, fades=True
            )
            assert np.array_equal(got, want), (m, m2, strength, touch)
        opaque = detail.copy()
        opaque[..., 3] = m2
        assert np.array_equal(
            blend(base, opaque, mode, strength, (0, e2), fades=True),
            blend(base, opaque, mode, strength, (0, e2)),
        )
    clear = noise((9, 9, 4), 65535, 4)
    base = ntp.clean(np.maximum(noise((9, 9, 3), 65535, 3), 1))[0]
    clear[..., 3] = 0
    touch = ntp.UNUSED_TRANSPARENT
    assert np.array_equal(blend(base, clear, mode, touch=touch, fades=True), base)


def test_the_detail_repeats():
    base, detail = noise((3, 600, 3), 255, 20), noise((2, 7, 3), 255, 21)
    want = blend_by_model(base, detail, RNM, 1.0, (0, 0), (0, 0), (255, 255))
    assert np.array_equal(blend(base, detail), want)


def test_strength_defaults_to_one():
    base, detail = noise((9, 300, 3), 255, 1), noise((5, 7, 3), 255, 2)
    for mode in (RNM, WHITEOUT, UDN):
        assert np.array_equal(blend(base, detail, mode), blend(base, detail, mode, 1.0))


def test_no_detail_leaves_clean_texels():
    """Strength 0: for RNM and UDN the base's own direction, whose levels do not change."""
    base = ntp.clean(noise((20, 30, 3), 65535, 3))[0]
    detail = ntp.clean(noise((5, 7, 3), 255, 4))[0]
    for mode in (RNM, UDN):
        assert np.array_equal(blend(base, detail, mode, 0.0), base)


def test_a_flat_base_shows_the_detail():
    """The levels nearest to flat are half a level off flat, and so is a blend with them."""
    base = np.full((40, 40, 3), [128, 128, 255], np.uint8)
    rng = np.random.default_rng(5)
    detail = base.copy()
    detail[..., :2] = rng.integers(70, 186, (40, 40, 2))
    detail = ntp.clean(detail)[0]
    for mode in (RNM, WHITEOUT, UDN):
        off = blend(base, detail, mode).astype(int)[..., :2] - detail[..., :2]
        assert np.abs(off).max() <= (22 if mode == UDN else 1)


def test_rnm_reorients():
    """A detail tilted like the base doubles the tilt."""
    degrees = np.radians([10, 25, 40])
    base = np.zeros((1, 3, 3), np.float32)
    base[0, :, 0], base[0, :, 2] = np.sin(degrees), np.cos(degrees)
    out = blend(base, base, RNM, encodings=(ntp.VECTOR, ntp.VECTOR))
    got = np.degrees(np.arctan2(out[0, :, 0], out[0, :, 2]))
    assert np.allclose(got, [20, 50, 80], atol=0.01)


def test_no_negative_z_out_of_none():
    """50 degrees on 60 degrees is 110: it stays at 90."""
    base, detail = np.zeros((1, 1, 3), np.float32), np.zeros((1, 1, 3), np.float32)
    for layer, degrees in ((base, 60), (detail, 50)):
        layer[..., 0], layer[..., 2] = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    out = blend(base, detail, RNM, encodings=(ntp.VECTOR, ntp.VECTOR))
    assert out[0, 0, 0] > 0.9999 and 0 <= out[0, 0, 2] < 0.01


@pytest.mark.parametrize("mode", [RNM, WHITEOUT, UDN])
def test_results_are_exact(mode):
    base, detail = noise((40, 50, 4), 255, 6), noise((16, 16, 3), 255, 7)
    out = blend(base, detail, mode, 0.8)
    unused = np.zeros(base.shape[:2], bool)
    for y, x in np.ndindex(*unused.shape):
        unused[y, x] = np.array_equal(out[y, x], base[y, x])
    assert np.all(unused | (ntp.validate(out, keep=1) & ntp.PASS_EXACT != 0))
    assert np.array_equal(out[..., 3], base[..., 3])


def test_unused_texels_stay():
    base, detail = noise((8, 8, 4), 255, 8), noise((8, 8, 4), 255, 9)
    out = blend(base, detail)
    mask = ntp.validate(base) | ntp.validate(detail)
    unused = mask & ntp.IS_UNUSED != 0
    assert unused.any() and np.array_equal(out[unused], base[unused])


def test_areas_in_place_and_strides():
    base, detail = noise((13, 300, 4), 65535, 10), noise((4, 7, 3), 255, 11)
    whole = blend(base, detail, WHITEOUT, 0.6)
    own = base.copy()
    for area in ((0, 0, 271, 5), (271, 0, 300, 5), (0, 5, 300, 13)):
        blend(own, detail, WHITEOUT, 0.6, area=area, dst=own)
    assert np.array_equal(own, whole)
    flipped = blend(base[::-1], np.roll(detail, -(13 % 4), 0)[::-1], WHITEOUT, 0.6)
    assert np.array_equal(flipped[::-1], whole)


def test_floats_go_by_16_bit():
    base, detail = noise((6, 8, 4), 65535, 12), noise((3, 3, 3), 65535, 13)
    want = blend(base, detail).astype(np.float64)
    floats = (base / 65535).astype(np.float32)
    got = blend(floats, (detail / 65535).astype(np.float32))
    assert np.array_equal(got, (want / 65535).astype(np.float32))
    floats[1, 1, 0] = np.inf
    assert np.array_equal(blend(floats, detail)[1, 1], floats[1, 1])


def test_refusals():
    base, detail = np.zeros((4, 6, 3), np.uint8), np.zeros((2, 2, 3), np.uint8)
    dst = np.zeros_like(base)
    how = ntp.ffi.new("ntp_blend_options *")

    def status(target, source=None, second=None, **fields):
        for name, value in {"mode": 0, "strength": 1.0, "use_strength": 1, **fields}.items():
            setattr(how, name, value)
        source = source or ntp.view(base, const=True)
        second = second or ntp.view(detail, const=True)
        return ntp.lib.ntp_blend(target, source, second, how, ntp.ffi.NULL)

    assert status(ntp.view(dst)) == ntp.OK
    assert status(ntp.view(dst[1:])) == ntp.ERR_SHAPE
    assert status(ntp.view(dst, ntp.ZZERO)) == ntp.ERR_FORMAT
    height = ntp.view(detail, ntp.HEIGHT, const=True)
    assert status(ntp.view(dst), second=height) == ntp.ERR_FORMAT
    assert status(ntp.view(dst), strength=float("nan")) == ntp.ERR_ARGUMENT
    assert status(ntp.view(dst), mode=2, strength=2000.0) == ntp.ERR_ARGUMENT
    assert status(ntp.view(base), second=ntp.view(base, const=True)) == ntp.ERR_OVERLAP
    names = [ntp.ffi.string(ntp.lib.ntp_blend_mode_name(m)) for m in (0, 1, 2, 9)]
    assert names == [b"rnm", b"whiteout", b"udn", b"unknown"]
