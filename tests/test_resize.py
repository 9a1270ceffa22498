# SPDX-License-Identifier: MIT
"""ntp_resize against a model in integers and fractions, and what resizing promises."""

import math
from itertools import pairwise

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle_vectors as model
from support.oracle_resize import (
    BOX,
    CLAMP,
    EXTRAPOLATE,
    LANCZOS3,
    MIRROR,
    TRIANGLE,
    WRAP,
    mapped,
    resize_by_model,
)
from support.texels import NAMES, TYPES, noise


class Plan:
    """An ntp_resize_plan with its memory."""

    def __init__(self, src, dst, how):
        sizes = (*src, *dst)
        self.how = ntp.ffi.new("ntp_resize_options *", list(how))
        size = ntp.lib.ntp_resize_plan_size(self.how, *sizes)
        self.memory = ntp.aligned(size)
        where = ntp.ffi.cast("void *", self.memory.__array_interface__["data"][0])
        plan = ntp.ffi.new("ntp_resize_plan **")
        ntp.check(ntp.lib.ntp_resize_plan_init(plan, where, size, self.how, *sizes))
        self.pointer = plan[0]
        self.scratch = ntp.aligned(ntp.lib.ntp_resize_scratch_size(self.pointer))
        self.scratch[:] = 0xA5

    def run(self, dst, src, area=None):
        where = ntp.ffi.cast("void *", self.scratch.__array_interface__["data"][0])
        return ntp.lib.ntp_resize(dst, src, self.pointer, where, len(self.scratch), ntp.rect(area))


def resize(src, size, filter=BOX, border=WRAP, encoding=ntp.STANDARD, touch=0, areas=(None,)):
    """src resized to (width, height); border is one for both axes, or a pair."""
    borders = border if isinstance(border, tuple) else (border, border)
    plan = Plan(src.shape[1::-1], size, (filter, *borders, touch))
    dst = np.full((size[1], size[0], src.shape[2]), 77, src.dtype)
    for area in areas:
        ntp.check(plan.run(ntp.view(dst, encoding), ntp.view(src, encoding, const=True), area))
    return dst


SIZES = [((5, 4), (3, 7)), ((1, 1), (3, 2)), ((7, 6), (1, 1)), ((4, 6), (8, 3)), ((9, 2), (5, 2))]


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("encoding", NAMES)
@pytest.mark.parametrize("filter", [BOX, TRIANGLE])
def test_against_fractions(filter, encoding, m):
    borders = [(WRAP, WRAP), (CLAMP, MIRROR), (MIRROR, CLAMP)]
    for case, ((w, h), size) in enumerate(SIZES):
        for channels in (2, 3, 4) if encoding == ntp.XY else (3, 4):
            for touch in (0, ntp.UNUSED_TRANSPARENT):
                kind = ("any", "flat")[case % 2]
                src = noise((h, w, channels), m, 10 * case + channels, kind)
                border = borders[(case + channels) % 3]
                got = resize(src, size, filter, border, encoding, touch).tolist()
                want = resize_by_model(
                    src.tolist(), m, size, filter, border, NAMES[encoding], touch
                )
                assert got == [[t for t, _ in row] for row in want], (case, channels, touch)


@pytest.mark.parametrize("step", [1, 257])  # 257: levels of 8 bit
@pytest.mark.parametrize("filter", [BOX, TRIANGLE])
def test_nearly_flat_texels_are_close_to_boundaries(filter, step):
    """Of packed pixels, as many as loops take at once; their sums are whole numbers."""
    rng = np.random.default_rng(step)
    src = np.full((8, 160, 3), 65535, np.uint16)
    src[..., :2] = step * (65536 // (2 * step) + rng.integers(-9, 10, (8, 160, 2)))
    got = resize(src, (80, 4), filter, CLAMP).tolist()
    want = resize_by_model(src.tolist(), 65535, (80, 4), filter, (CLAMP, CLAMP), "standard")
    assert got == [[t for t, _ in row] for row in want]


@pytest.mark.parametrize("m", TYPES)
def test_lanczos_against_real_numbers(m):
    """Equal but where the double's value lies next to a rounding boundary."""
    checked = 0
    for (w, h), size in [*SIZES, ((13, 11), (4, 5)), ((6, 5), (17, 14))]:
        src = noise((h, w, 3), m, w, "flat")
        for border in (WRAP, CLAMP, MIRROR):
            got = resize(src, size, LANCZOS3, border).tolist()
            want = resize_by_model(src.tolist(), m, size, LANCZOS3, (border, border), "standard")
            for row, want_row in zip(got, want):
                for texel, (levels, v) in zip(row, want_row):
                    length = math.sqrt(sum(float(c) ** 2 for c in v))
                    exact = [(float(c) / length + 1) / 2 * m + 0.5 for c in v[:2]] if length else []
                    if all(abs(e - round(e)) > 1e-3 for e in exact):
                        assert texel == levels
                        checked += 1
    assert checked > 900


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("size", [(40, 4), (27, 5)])
def test_sums_that_are_0_or_nearly_so(size, m):
    """Columns that point up and down in turn, and others that cancel: each sum is 0, or small."""
    rng = np.random.default_rng(m)
    src = np.full((8, 80, 3), m, TYPES[m])
    src[..., :2] = m // 2 + rng.integers(0, 2, (8, 80, 2))
    src[:, ::2, :2] = m // 2 + 1
    src[:, ::2, 2] = 0
    src[:4, 40:, 2] = m // 2 + rng.integers(0, 2, (4, 40))
    # Where sides are halved Lanczos has pairs of equal weights; others are rounded.
    for filter in (BOX, TRIANGLE, LANCZOS3)[: 3 if size[0] == 40 else 2]:
        got = resize(src, size, filter, WRAP).tolist()
        want = resize_by_model(src.tolist(), m, size, filter, (WRAP, WRAP), "standard")
        assert got == [[t for t, _ in row] for row in want], filter


@pytest.mark.parametrize("color", [0, None])
def test_short_vectors_among_unused_texels(color):
    """Of 8 bit and halved: what floats cannot decide, up to sums of no weight and of no length."""
    rng = np.random.default_rng(3)
    src = rng.integers(126, 130, (14, 90, 3)).astype(np.uint8)
    if color is None:
        src[:, 1::2] = 255 - src[:, ::2]
        src[:, 60:] = src[:, 29::-1] // 2 * 2 + 1
    else:
        src[rng.random((14, 90)) < 0.6] = color
        src[:, 50:70] = color
    got = resize(src, (45, 7), LANCZOS3, WRAP).tolist()
    want = resize_by_model(src.tolist(), 255, (45, 7), LANCZOS3, (WRAP, WRAP), "standard")
    assert got == [[t for t, _ in row] for row in want]


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("channels", [3, 4])
def test_rows_of_more_columns_than_are_kept_at_once(channels, m):
    """As many as three strips have, with alpha and with the third sample of XY."""
    src = noise((7, 700, channels), m, channels, "any")
    encoding = ntp.XY if channels == 3 else ntp.STANDARD
    for filter, border in ((BOX, WRAP), (TRIANGLE, MIRROR)):
        got = resize(src, (350, 3), filter, border, encoding).tolist()
        want = resize_by_model(src.tolist(), m, (350, 3), filter, (border, border), NAMES[encoding])
        assert got == [[t for t, _ in row] for row in want], filter


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("channels", [3, 4])
def test_samples_between_two_levels_are_rounded_up(channels, m):
    """Halved by Lanczos, a step amid the taps is a mean; its sums are beyond the integers of doubles."""
    src = np.full((8, 24, channels), m // 2 + 1, TYPES[m])
    encoding = ntp.XY if channels == 3 else ntp.STANDARD
    for level in range(1, m, m // 85 * 2 - 1):
        src[:, :13, -1] = level
        src[:, 13:, -1] = level + 1
        got = resize(src, (12, 4), LANCZOS3, CLAMP, encoding)
        assert (got[:, 6, -1] == level + 1).all(), level


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("width", [24, 6, 12, 9])
def test_rows_of_no_weight_do_not_decide_whether_lanczos_overshot(width, m):
    """Where the height stays, rows are resized one by one, however negative the z of others is."""
    steps = np.full((8, 12, 3), m // 2 + 1, TYPES[m])
    steps[:, 3:6, 0] = steps[:, 8:11, 0] = m
    steps[:, :3, 2] = steps[:, 6:8, 2] = steps[:, 11:, 2] = m
    mixed = steps.copy()
    mixed[1::2, :, 2] = 0
    for border in (WRAP, CLAMP, MIRROR):
        want = resize(steps, (width, 8), LANCZOS3, border)
        got = resize(mixed, (width, 8), LANCZOS3, border)
        assert np.array_equal(got[::2], want[::2])
        assert want[..., 2].min() > m // 2


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("filter", [BOX, TRIANGLE, LANCZOS3])
@pytest.mark.parametrize("encoding", NAMES)
def test_constant_clean_maps_stay_constant(encoding, filter, m):
    rng = np.random.default_rng(m)
    texels = rng.integers(0, m + 1, (60, 3)).astype(TYPES[m])
    texels[:4] = [[m // 2] * 2 + [m], [m // 2 + 1] * 2 + [m], [m, m // 2, 0], [1, m // 2, 9]]
    how = ntp.clean_options(touch_unused=7)
    texels = ntp.clean(texels[None], encoding, how)[0][0]
    for i, texel in enumerate(texels):
        channels = 3 if i % 2 else 4
        src = np.zeros((5, 6, channels), TYPES[m])
        src[..., :3] = texel
        if channels == 4:
            # With less than that Lanczos' negative weights can win.
            least = m * 3 // 4 if filter == LANCZOS3 else 1
            src[..., 3] = rng.integers(least, m + 1, (5, 6))
        for size in ((3, 4), (11, 7), (1, 1)):
            got = resize(src, size, filter, i % 3, encoding)
            assert np.all(got[..., :3] == texel), (texel, got[0, 0], size)


@pytest.mark.parametrize("encoding", NAMES)
@pytest.mark.parametrize("filter", [BOX, TRIANGLE, LANCZOS3])
@pytest.mark.parametrize("m", TYPES)
def test_results_are_exact(m, filter, encoding):
    src = noise((40, 50, 3), m, 5)
    for size in ((25, 20), (80, 70), (1, 1), (50, 40)):
        out = resize(src, size, filter, WRAP, encoding)
        flags = ntp.validate(out, encoding, keep=1)
        assert np.all(flags & ntp.PASS_EXACT) and not np.any(flags & ntp.XY_TOO_LONG)


@pytest.mark.parametrize("filter", [BOX, TRIANGLE, LANCZOS3])
def test_same_size_keeps_clean_texels(filter):
    src = ntp.clean(noise((31, 45, 3), 255, 1), how=ntp.clean_options(touch_unused=7))[0]
    assert np.array_equal(resize(src, (45, 31), filter), src)


@pytest.mark.parametrize("filter", [BOX, TRIANGLE, LANCZOS3])
def test_mip_chain_is_clean(filter):
    src = ntp.clean(noise((37, 83, 3), 65535, 2), how=ntp.clean_options(touch_unused=7))[0]
    levels = ntp.lib.ntp_mip_levels(83, 37)
    assert levels == 7
    sides = [(ntp.lib.ntp_mip_side(83, k), ntp.lib.ntp_mip_side(37, k)) for k in range(levels)]
    assert sides == [(83, 37), (41, 18), (20, 9), (10, 4), (5, 2), (2, 1), (1, 1)]
    for size in sides:
        out = resize(src, size, filter)
        assert np.all(ntp.validate(out) & ntp.PASS_EXACT)
        assert np.array_equal(ntp.clean(out)[0], out)


def test_mip_sides():
    assert [ntp.lib.ntp_mip_side(5, k) for k in (-1, 0, 1, 2, 3, 40)] == [5, 5, 2, 1, 1, 1]
    assert ntp.lib.ntp_mip_side(0, 1) == 0
    assert ntp.lib.ntp_mip_levels(1, 1) == 1 and ntp.lib.ntp_mip_levels(65535, 1) == 16
    assert ntp.lib.ntp_mip_levels(0, 4) == 0


@pytest.mark.parametrize("filter", [BOX, TRIANGLE, LANCZOS3])
@pytest.mark.parametrize("border", [WRAP, CLAMP, MIRROR])
def test_areas_make_the_whole(filter, border):
    src = noise((23, 31, 4), 65535, 3)
    for size in ((300, 17), (9, 40)):
        whole = resize(src, size, filter, border)
        xs, ys = sorted({0, 1, 7, size[0]}), sorted({0, 5, 6, size[1]})
        areas = [(a, c, b, d) for a, b in pairwise(xs) for c, d in pairwise(ys)]
        assert np.array_equal(resize(src, size, filter, border, areas=areas[::-1]), whole)


@pytest.mark.parametrize("filter", [BOX, TRIANGLE, LANCZOS3])
def test_wrap_moves_with_the_texture(filter):
    src = noise((24, 36, 4), 255, 4)
    small = resize(src, (12, 8), filter)
    for dx, dy in ((1, 1), (5, 3)):
        moved = np.roll(src, (3 * dy, 3 * dx), (0, 1))
        assert np.array_equal(resize(moved, (12, 8), filter), np.roll(small, (dy, dx), (0, 1)))
    large = resize(src, (72, 48), filter)
    moved = np.roll(src, (5, 7), (0, 1))
    assert np.array_equal(resize(moved, (72, 48), filter), np.roll(large, (10, 14), (0, 1)))


@pytest.mark.parametrize("filter", [BOX, TRIANGLE, LANCZOS3])
@pytest.mark.parametrize("border", [WRAP, CLAMP, MIRROR])
def test_commutes_with_a_mirror_of_the_picture(filter, border):
    src = noise((14, 19, 4), 255, 6)
    for size in ((7, 5), (40, 33)):
        out = resize(src, size, filter, border)
        assert np.array_equal(resize(src[::-1, ::-1], size, filter, border), out[::-1, ::-1])


def test_unused_texels_do_not_bleed():
    tilted = np.array([200, 100, 220, 255], np.uint8)
    tilted = ntp.clean(tilted[None, None])[0][0, 0]
    for padding in ([0, 0, 0, 255], [255, 255, 255, 255], [13, 250, 4, 0]):
        src = np.empty((8, 8, 4), np.uint8)
        src[:] = padding
        src[2:5, 1:6] = tilted
        for filter in (BOX, TRIANGLE):
            out = resize(src, (4, 4), filter, CLAMP)
            held = out[..., 3] > 0
            assert np.all(out[held][:, :3] == tilted[:3]) and held.any()
            assert np.all(out[~held] == [128, 128, 255, 0])


def test_without_alpha_padding_becomes_flat():
    src = np.zeros((4, 4, 3), np.uint8)
    assert np.all(resize(src, (2, 2)) == [128, 128, 255])


def test_black_in_alpha_as_data_keeps_alpha():
    src = np.zeros((4, 4, 4), np.uint8)
    src[..., 3] = 90
    out = resize(src, (2, 2), touch=ntp.UNUSED_TRANSPARENT)
    assert np.all(out == [128, 128, 255, 90])
    assert np.all(resize(src, (2, 2))[..., 3] == 0)


@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.ZZERO, ntp.XY, ntp.VECTOR])
def test_floats_go_by_16_bit(encoding):
    levels = noise((9, 10, 4), 65535, 8)
    integers = resize(levels, (6, 5), LANCZOS3, MIRROR, ntp.STANDARD if encoding == 3 else encoding)
    floats = (levels / 65535).astype(np.float32)
    want = (integers / 65535.0).astype(np.float32)
    if encoding == ntp.VECTOR:
        unused = np.all(levels[..., :3] == 0, -1) | np.all(levels[..., :3] == 65535, -1)
        floats[..., :3] = ((2.0 * levels[..., :3] - 65535) / 65535).astype(np.float32)
        floats[unused, :3] = np.nan
        want[..., :3] = ((2.0 * integers[..., :3] - 65535) / 65535).astype(np.float32)
    floats[0, 0, :3] = np.nan
    levels[0, 0, :3] = 0
    assert np.array_equal(resize(floats, (6, 5), LANCZOS3, MIRROR, encoding)[1:4], want[1:4])


def test_rows_tell_what_is_read():
    """A result row comes out right when only the rows named are there, in a ring."""
    src = noise((40, 12, 3), 255, 9)
    for filter, border, height in ((LANCZOS3, CLAMP, 10), (TRIANGLE, WRAP, 77), (BOX, WRAP, 7)):
        plan = Plan((12, 40), (9, height), (filter, WRAP, border, 0))
        want = resize(src, (9, height), filter, (WRAP, border))
        for y in range(height):
            rows = ntp.lib.ntp_resize_rows(plan.pointer, y)
            known = np.full_like(src, 0x5A)
            for row in range(rows.first, rows.last + 1):
                known[mapped(row, 40, border)] = src[mapped(row, 40, border)]
            dst = np.zeros((height, 9, 3), np.uint8)
            ntp.check(plan.run(ntp.view(dst), ntp.view(known, const=True), (0, y, 9, y + 1)))
            assert np.array_equal(dst[y], want[y])


def test_ties_are_rounded_up():
    """The mean points along (2, 2, 1)/3: 255 * 2/3 is even, so the levels are exact ties."""
    for m, k in ((255, 100), (65535, 20000)):
        for sx, sy in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
            one = [sx * (k + 1), sy * (k + 1), k - 1]
            two = [sx * (k - 1), sy * (k - 1), 1]
            src = (np.array([[one, two]]) + m) // 2
            got = resize(src.astype(TYPES[m]), (1, 1))[0, 0].tolist()
            assert got[0] == (m + 1) // 2 + sx * (m // 3)
            assert got == list(model.encode((2 * sx, 2 * sy, 1), m, "standard"))


def test_views_of_any_stride():
    src = noise((12, 14, 4), 65535, 11)
    want = resize(src, (5, 6), TRIANGLE, MIRROR)
    large = np.zeros((24, 28, 4), np.uint16)
    large[::2, ::2] = src
    assert np.array_equal(resize(large[::2, ::2], (5, 6), TRIANGLE, MIRROR), want)


def test_greatest_sums_do_not_overflow():
    """The longest axis there is, 16 bit with alpha, every sample at an end of its range."""
    texel = [65535, 65535, 65534, 65535]
    for filter in (BOX, TRIANGLE, LANCZOS3):
        src = np.zeros((1, 65535, 4), np.uint16)
        src[:] = texel
        wide = resize(src, (1, 1), filter, WRAP)
        tall = resize(src.reshape(65535, 1, 4), (1, 1), filter, WRAP)
        want = model.encode((65535, 65535, 65533), 65535, "standard")
        assert wide[0, 0].tolist() == tall[0, 0].tolist() == [*want, 65535]


def test_refusals():
    src, dst = np.zeros((4, 6, 3), np.uint8), np.zeros((2, 3, 3), np.uint8)
    plan = Plan((6, 4), (3, 2), (0, 0, 0, 0))
    source, target = ntp.view(src, const=True), ntp.view(dst)
    assert plan.run(target, source) == ntp.OK
    assert plan.run(target, source, (0, 0, 4, 1)) == ntp.ERR_SHAPE
    assert plan.run(target, ntp.ffi.NULL) == ntp.ERR_ARGUMENT
    assert plan.run(ntp.view(src), source) == ntp.ERR_SHAPE
    assert plan.run(ntp.view(dst, ntp.ZZERO), source) == ntp.ERR_FORMAT
    assert plan.run(ntp.view(dst, 4), ntp.view(src, 4, const=True)) == ntp.ERR_FORMAT
    plan.scratch = plan.scratch[:-16]
    assert plan.run(target, source) == ntp.ERR_SCRATCH
    for how, sizes in (
        ((3, 0, 0, 0), (6, 4, 3, 2)),
        ((0, EXTRAPOLATE, 0, 0), (6, 4, 3, 2)),
        ((0, 0, 0, 8), (6, 4, 3, 2)),
        ((0, 0, 0, 0), (6, 4, 0, 2)),
        ((0, 0, 0, 0), (65536, 4, 3, 2)),
    ):
        assert ntp.lib.ntp_resize_plan_size(ntp.ffi.new("ntp_resize_options *", how), *sizes) == 0
    names = [ntp.ffi.string(ntp.lib.ntp_filter_name(f)) for f in (0, 1, 2, 9)]
    assert names == [b"triangle", b"box", b"lanczos3", b"unknown"]
