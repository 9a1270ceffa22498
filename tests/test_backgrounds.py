# SPDX-License-Identifier: MIT
"""Textures with backgrounds: packed RGB has loops of its own, and RGBA that is opaque has few of them."""

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle
from support.texels import TYPES

NULL = ntp.ffi.NULL
SIZE = 96, 320  # more than a block wide
METHODS = ("derive", "normalize")
FILTERS = (0, 1, 2)
TOUCH = (0, ntp.UNUSED_BLACK, ntp.UNUSED_WHITE, 7)


def texture(m, seed):
    """Clean normals; black, white, flat and too long texels in boxes, in runs, and alone."""
    rng = np.random.default_rng(seed)
    h, w = SIZE
    xy = rng.normal(0, 0.25, (h, w, 2)) + np.sin(np.arange(w) / 9)[None, :, None] * 0.4
    z = np.sqrt(np.maximum(0, 1 - (xy**2).sum(-1)))
    levels = (np.clip(np.dstack([xy, z]), -1, 1) + 1) / 2 * m + 0.5
    out = levels.astype(TYPES[m])
    colors = [0, m, [m // 2 + 1, m // 2 + 1, m], [m, 0, 9], [0, 0, m], [m, m, 0]]
    for k in range(40):
        y, x = rng.integers(0, h), rng.integers(0, w)
        height, width = rng.integers(1, 40), rng.integers(1, 90)
        out[y : y + height, x : x + width] = colors[k % len(colors)]
    out[rng.random((h, w)) < 0.02] = 0
    out[rng.random((h, w)) < 0.02] = m
    out[:, 70:110][rng.random((h, 40)) < 0.9] = 0
    out[:, 200:240, :2] = rng.integers(m // 2, m // 2 + 2, (h, 40, 2))  # all that is flat
    out[:, 200:240, 2] = m
    return out


def opaque(rgb, m):
    return np.dstack([rgb, np.full(rgb.shape[:2], m, rgb.dtype)])


def apart(pixels):
    """Bytes between pixels: these are cleaned as planes, by none of the loops for packed ones."""
    return np.dstack([pixels, pixels[..., :1]])[..., :-1]


def both(m, run):
    """What `run` makes of packed RGB, and of RGBA."""
    for seed in range(3):
        src = texture(m, 10 * m + seed)
        got, want = run(src), run(opaque(src, m))
        assert np.array_equal(got, want[..., :3]), np.argwhere(got != want[..., :3])[:5]


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("touch", TOUCH)
@pytest.mark.parametrize("method", range(len(METHODS)))
def test_clean(method, touch, m):
    for seed in range(3):
        src = texture(m, seed)
        how = ntp.clean_options(method=method, touch_unused=touch)
        got, count = ntp.clean(src, how=how)[:2]
        want, same = ntp.clean(apart(src), how=how)[:2]
        assert np.array_equal(got, want)
        assert count == same == (got != src).any(-1).sum()


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("touch", TOUCH)
@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.ZZERO])
@pytest.mark.parametrize("method", range(len(METHODS)))
def test_clean_alpha(method, encoding, touch, m):
    """Alphas of all sorts, some of one byte 0: the packed colors of RGBA are cleaned as RGB."""
    how = ntp.clean_options(method=method, touch_unused=touch)
    plan, _memory = ntp.clean_plan(encoding, how)
    for seed in range(3):
        src = opaque(texture(m, seed), m)
        rng = np.random.default_rng(seed)
        src[..., 3] = rng.choice([0, 1, 254, 255, m // 255 * 254, m], SIZE)
        src[40:50, :, 3] = 0
        src[50:60, :, 3] = m
        for width in (320, 257, 31, 15):
            some = np.ascontiguousarray(src[:, :width])
            want, count = ntp.clean(apart(some), encoding, how)[:2]
            used = ~oracle.unused(some, m, touch)
            assert (want != some).any(-1)[used].sum() == count == (want != some).any(-1).sum()
            for got, same, _ in (
                ntp.clean(some, encoding, how),
                ntp.clean(some, encoding, how, plan),
                ntp.clean(some, encoding, how, dst=some),  # in place; the last one
            ):
                assert np.array_equal(got, want), np.argwhere(got != want)[:5]
                assert count == same
    got = ntp.clean(src, encoding, how)[0]
    for x, y in enumerate(rng.integers(0, SIZE[0], 300).tolist()):
        *texel, alpha = src[y, x].tolist()
        want = texel
        if not oracle.unused(src[y, x], m, touch):
            want = oracle.cleaned(*texel, m, encoding == ntp.ZZERO, METHODS[method])
        assert got[y, x].tolist() == [*want, alpha]


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("touch", TOUCH)
def test_zzero(touch, m):
    """Black stays black, and does not count as a negative z."""
    how = ntp.ffi.new("ntp_convert_options *", {"touch_unused": touch})
    for seed in range(3):
        src = texture(m, seed)
        got, want = np.zeros_like(src), np.zeros_like(src)
        counts = ntp.ffi.new("ntp_convert_counts[2]")
        for from_, dst, count in ((src, got, counts), (apart(src), want, counts + 1)):
            view = ntp.view(from_, const=True)
            ntp.check(ntp.lib.ntp_convert(ntp.view(dst, ntp.ZZERO), view, how, count, NULL))
        assert np.array_equal(got, want)
        used = ~oracle.unused(src, m, touch)
        assert (
            counts[0].z_negative == counts[1].z_negative == (used & (src[..., 2] <= m // 2)).sum()
        )
        black = ~src.any(-1)
        assert (got[black] == (0, 0, m if touch & ntp.UNUSED_BLACK else 0)).all()


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("touch", TOUCH)
def test_heatmap(touch, m):
    def paint(src):
        dst = np.zeros((*SIZE, 3), np.uint8)
        source = ntp.view(src, const=True)
        ntp.check(ntp.lib.ntp_heatmap(ntp.view(dst, ntp.HEIGHT), source, 0, touch, NULL))
        return dst

    both(m, paint)


@pytest.mark.parametrize("m", TYPES)
def test_shade(m):
    def paint(src):
        dst = np.zeros((*SIZE, 3), np.uint8)
        source = ntp.view(src, const=True)
        ntp.check(ntp.lib.ntp_shade(ntp.view(dst, ntp.HEIGHT), source, NULL, NULL))
        return dst

    both(m, paint)


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("strength", [0.6, 1.7])
def test_strength(strength, m):
    def strengthen(src):
        how = ntp.ffi.new("ntp_transform_options *")
        how.use_strength, how.strength, how.flip_x, how.quarter_turns = 1, strength, 1, 2
        dst = np.zeros_like(src)
        ntp.check(ntp.lib.ntp_transform(ntp.view(dst), ntp.view(src, const=True), how, NULL))
        return dst

    both(m, strengthen)


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("touch", TOUCH)
@pytest.mark.parametrize("mode", [0, 1, 2])
def test_blend(mode, touch, m):
    def blend(src):
        how = ntp.ffi.new("ntp_blend_options *")
        how.mode, how.touch_unused = mode, touch
        dst, detail = np.zeros_like(src), np.roll(src, (7, 31), (0, 1))
        views = ntp.view(dst), ntp.view(src, const=True), ntp.view(detail, const=True)
        ntp.check(ntp.lib.ntp_blend(*views, how, NULL))
        return dst

    both(m, blend)


@pytest.mark.parametrize("m", TYPES)
@pytest.mark.parametrize("touch", TOUCH)
@pytest.mark.parametrize("border", FILTERS)
@pytest.mark.parametrize("filter", FILTERS)
def test_resize(filter, border, touch, m):
    def shrink(src, width, height, encoding=ntp.STANDARD):
        how = ntp.ffi.new("ntp_resize_options *", [filter, border, border, touch])
        sizes = SIZE[1], SIZE[0], width, height
        memory = ntp.aligned(ntp.lib.ntp_resize_plan_size(how, *sizes))
        where = ntp.ffi.cast("void *", memory.__array_interface__["data"][0])
        plan = ntp.ffi.new("ntp_resize_plan **")
        ntp.check(ntp.lib.ntp_resize_plan_init(plan, where, len(memory), how, *sizes))
        scratch = ntp.aligned(ntp.lib.ntp_resize_scratch_size(plan[0]))
        room = ntp.ffi.cast("void *", scratch.__array_interface__["data"][0])
        dst = np.zeros((height, width, src.shape[2]), src.dtype)
        views = ntp.view(dst, encoding), ntp.view(src, encoding, const=True)
        ntp.check(ntp.lib.ntp_resize(*views, plan[0], room, len(scratch), NULL))
        return dst

    both(m, lambda src: shrink(src, SIZE[1] // 2, SIZE[0] // 2))
    both(m, lambda src: shrink(src, SIZE[1] // 2, SIZE[0] // 2, ntp.ZZERO))
    both(m, lambda src: shrink(src, 217, 61))


@pytest.mark.parametrize("channels", [3, 4])
def test_flat_on_flat_is_as_alone(channels):
    """Twice flat of 16 bit is in doubt, and what was found for one texel serves for the next equal one."""
    rng = np.random.default_rng(channels)
    base, detail = (rng.integers(32767, 32769, (3, 70, channels), np.uint16) for _ in range(2))
    base[..., 2:] = detail[..., 2:] = rng.integers(65534, 65536, (3, 70, channels - 2))
    detail[..., 3:] = rng.choice([20000, 65535], (3, 70, channels - 3))
    how = ntp.ffi.new("ntp_blend_options *")
    how.detail_alpha = 1
    views = ntp.view(base, const=True), ntp.view(detail, const=True)
    whole, alone = np.zeros_like(base), np.zeros_like(base)
    ntp.check(ntp.lib.ntp_blend(ntp.view(whole), *views, how, NULL))
    for y, x in np.ndindex(3, 70):
        ntp.check(ntp.lib.ntp_blend(ntp.view(alone), *views, how, ntp.rect((x, y, x + 1, y + 1))))
    assert np.array_equal(whole, alone)


def sixteen_bit(seed):
    """Textures of 16 bit that are not like normals: gray, or 8 bit in part."""
    rng = np.random.default_rng(seed)
    h, w = SIZE
    waves = np.sin(np.arange(h) / 17)[:, None] + np.cos(np.arange(w) / 23)[None, :]
    noise = rng.integers(0, 65536, (h, w, 3), np.uint16)
    eight = rng.integers(0, 256, (h, w, 3), np.uint16) * 257
    some = rng.random((h, w, 1)) < 0.4
    normals, alpha = texture(65535, seed), rng.choice([0, 30000, 65535], (h, w, 1))
    gray = np.repeat(((waves / 4 + 0.5) * 65535).astype(np.uint16)[..., None], 3, 2)
    # close to length 1, where texels are neighbors
    near = np.repeat(rng.choice([13800, 13858, 51677, 51700], (h, w, 1)), 3, 2).astype(np.uint16)
    yield from (gray, noise[..., :1].repeat(3, 2), np.where(some, gray, noise), near)
    yield from (eight, np.where(some, eight, noise), np.where(some, eight, normals))
    yield np.where(some, eight, texture(255, seed).astype(np.uint16) * 257)
    yield texture(255, seed).astype(np.uint16) * 257
    yield np.dstack([np.where(some, eight, noise), alpha.astype(np.uint16)])
    yield np.dstack([np.where(some, gray, normals), alpha.astype(np.uint16)])


def facts(tally):
    lengths, off, harm = tally.lengths(), tally.levels_off(), tally.harm()
    return tally.stats(), lengths.tolist(), off.tolist(), harm


@pytest.mark.parametrize("touch", TOUCH)
@pytest.mark.parametrize("seed", range(2))
def test_measured_at_once_as_in_narrow_parts(seed, touch):
    """Columns of a few texels have neither kernels of packed texels nor tables of colors."""
    for case, pixels in enumerate(sixteen_bit(seed)):
        src = np.ascontiguousarray(pixels)
        whole, parts = ntp.Tally().measure(src, touch_unused=touch), ntp.Tally()
        for x in range(0, SIZE[1], 13):
            area = x, 0, min(x + 13, SIZE[1]), SIZE[0]
            parts.merge(ntp.Tally().measure(src, touch_unused=touch, area=area))
        assert facts(whole) == facts(parts), case
