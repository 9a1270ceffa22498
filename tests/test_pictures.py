# SPDX-License-Identifier: MIT
"""ntp_heatmap, ntp_shade and ntp_diff_add against support/oracle_pictures.py."""

import math

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle
from support.oracle_pictures import (
    DEFAULT_LIGHT,
    expected_compare,
    expected_heat,
    expected_heatmap,
    expected_shade,
    nearly,
)
from support.sanitized import EVERY
from support.texels import image

NULL = ntp.ffi.NULL
DEPTHS = {"u8": (255, np.uint8), "u16": (65535, np.uint16)}


def heatmap(array, encoding=ntp.STANDARD, palette=0, touch=0, dst=None, area=None, y=ntp.UP):
    dst = np.full((*array.shape[:2], 3), 7, np.uint8) if dst is None else dst
    src = ntp.view(array, encoding, y, const=True)
    ntp.check(ntp.lib.ntp_heatmap(ntp.view(dst, ntp.HEIGHT), src, palette, touch, ntp.rect(area)))
    return dst


def shade(array, encoding=ntp.STANDARD, light=None, dst=None, area=None, y=ntp.UP):
    dst = np.full((*array.shape[:2], 3), 7, np.uint8) if dst is None else dst
    src = ntp.view(array, encoding, y, const=True)
    light = NULL if light is None else ntp.ffi.new("ntp_light *", list(light))
    ntp.check(ntp.lib.ntp_shade(ntp.view(dst, ntp.HEIGHT), src, light, ntp.rect(area)))
    return dst


class Diff:
    """An ntp_diff with its memory."""

    def __init__(self):
        self.memory = ntp.aligned(ntp.lib.ntp_diff_size())
        self.pointer = ntp.ffi.cast("ntp_diff *", self.memory.__array_interface__["data"][0])

    def add(self, a, b, encodings=(0, 0), ys=(0, 0), heat=None, area=None):
        heat_view = NULL if heat is None else ntp.view(heat, ntp.HEIGHT)
        views = [ntp.view(v, e, y, const=True) for v, e, y in zip((a, b), encodings, ys)]
        ntp.check(ntp.lib.ntp_diff_add(self.pointer, heat_view, *views, ntp.rect(area)))
        return self

    def stats(self):
        stats = ntp.ffi.new("ntp_diff_stats *")
        ntp.check(ntp.lib.ntp_diff_summarize(stats, self.pointer))
        return ntp.fields(stats)


# ----------------------------------------------------------------------------- the heatmap


@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.ZZERO, ntp.XY])
def test_heatmap_of_all_8_bit_triplets(encoding):
    """Each blue is an image of all red and green, so all 2^24 triplets are tested."""
    g, r = np.mgrid[:256, :256]
    for b in range(0, 256, EVERY if encoding != ntp.XY else 51):
        texels = np.dstack([r, g, np.full_like(r, b)]).astype(np.uint8)
        for palette in (0, 1) if b % 15 == 0 else (0,):
            want = expected_heatmap(texels, 255, encoding, palette)
            assert np.array_equal(heatmap(texels, encoding, palette), want), (b, palette)


@pytest.mark.parametrize("palette", [0, 1])
@pytest.mark.parametrize("touch", [0, 1, 2, 4, 7])
@pytest.mark.parametrize("kind", ["standard", "zzero", "xy"])
def test_heatmap_of_16_bit(kind, touch, palette):
    encoding = ["standard", "zzero", "xy"].index(kind)
    texels = image(65535, 4).astype(np.uint16)
    want = expected_heatmap(texels, 65535, encoding, palette, touch)
    assert np.array_equal(heatmap(texels, encoding, palette, touch), want)


def test_heatmap_at_every_16_bit_limit():
    """Blues whose lengths lie just inside and just outside each limit."""
    m = 65535
    rng = np.random.default_rng(5)
    rows = []
    for r, g in rng.integers(0, m + 1, (400, 2)):
        n = (2 * int(r) - m) ** 2 + (2 * int(g) - m) ** 2
        for limit in (m - 6, m - 4, m + 4, m + 6):
            z = math.isqrt(max(limit * limit - n, 0))
            rows += [(r, g, min(max((m + z) // 2 + i, 0), m)) for i in range(-2, 3)]
    for r in rng.integers(0, m + 1, 400):
        for limit in (m, m + 2):
            y = math.isqrt(max(limit * limit - (2 * int(r) - m) ** 2, 0))
            rows += [(r, min((m + y) // 2 + i, m), m // 2 + 1) for i in range(-2, 3)]
    texels = np.array(rows, np.uint16)[None]
    assert np.array_equal(heatmap(texels), expected_heatmap(texels, m, ntp.STANDARD))


@pytest.mark.parametrize("sample", DEPTHS)
def test_heatmap_of_long_pairs_at_every_limit(sample):
    """Pairs that are too long, with blues of which the length is judged after pulling."""
    m, dtype = DEPTHS[sample]
    r, g = np.random.default_rng(6).integers(0, m + 1, (2, 3000))
    long = (2 * r - m) ** 2 + (2 * g - m) ** 2 > m * m
    r, g = r[long], g[long]
    x, y = (2 * v - m for v in oracle.pulled(r, g, m))
    rows = []
    for limit in (m, m + 4, m + 6, m + m // 100):
        z = np.sqrt(limit * limit - x * x - y * y).astype(int)
        for sign in (-1, 1):
            b = (m + sign * z) // 2
            rows += [np.stack([r, g, b + i], -1) for i in range(-3, 4)]
    texels = np.clip(rows, 0, m).astype(dtype)
    assert np.array_equal(heatmap(texels), expected_heatmap(texels, m, ntp.STANDARD))


def test_heatmap_names_the_corners():
    """The legend in words: docs/heatmap.md."""
    texels = {
        (128, 128, 255): (168, 168, 168),
        (128, 128, 127): (0, 255, 128),
        (128, 128, 0): (0, 0, 255),
        (255, 255, 128): (255, 0, 0),
        (128, 128, 252): (0, 128, 0),
        (128, 128, 251): (0, 255, 0),
        (0, 0, 0): (100, 100, 100),
        (255, 255, 255): (227, 227, 227),
    }
    array = np.array([list(texels)], np.uint8)
    assert heatmap(array)[0].tolist() == [list(v) for v in texels.values()]


@pytest.mark.parametrize("sample", DEPTHS)
def test_two_channels(sample):
    m, dtype = DEPTHS[sample]
    texels = np.maximum(image(m, 2), 1).astype(dtype)
    want = expected_heatmap(texels, m, ntp.XY)
    assert np.array_equal(heatmap(texels, ntp.XY), want)
    want = expected_shade(texels, m, ntp.XY)
    assert np.array_equal(shade(texels, ntp.XY), want)


def test_floats_are_judged_as_16_bit():
    levels = image(65535, 4).astype(np.uint16)
    floats = (levels / 65535).astype(np.float32)
    vectors = ((2.0 * levels - 65535) / 65535).astype(np.float32)
    vectors[..., 3] = floats[..., 3]
    for array, encoding in ((floats, ntp.STANDARD), (vectors, ntp.VECTOR)):
        assert np.array_equal(heatmap(array, encoding), heatmap(levels))
        assert np.array_equal(shade(array, encoding), shade(levels))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_floats_that_are_no_vector(bad):
    array = np.full((16, 16, 3), [0.5, 0.5, 1.0], np.float32)
    array[3, 4, 1] = bad
    array[9, 9] = 0.5
    for palette in (0, 1):
        picture = heatmap(array, palette=palette)
        white = (picture == 255).all(-1)
        assert sorted(map(tuple, np.argwhere(white))) == [(3, 4), (9, 9)]
    picture = shade(array)
    assert picture[3, 4].tolist() == [88] * 3 and picture[9, 9].tolist() == [88] * 3
    flat = np.full((16, 16, 3), [0.5, 0.5, 1.0], np.float32)
    stats = Diff().add(array, flat).stats()
    assert stats["different"] == 2 and stats["levels_max"][:3] == [0, 0, 0]
    assert stats["angles"]["max"] == 0
    none = np.full((2, 2, 3), bad, np.float32)  # flat has no y that could be flipped
    assert Diff().add(none, none, ys=(ntp.UP, ntp.DOWN)).stats()["levels_max"] == [0] * 4


# ----------------------------------------------------------------------- the shaded plane

RED_LIGHT = ([0.3, -2.0, 0.1], 0.05, 1.0, 0.7, [1.0, 0.25, 0.0])


@pytest.mark.parametrize("light", [None, DEFAULT_LIGHT, RED_LIGHT])
@pytest.mark.parametrize("y", [ntp.UP, ntp.DOWN])
@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.ZZERO, ntp.XY])
@pytest.mark.parametrize("sample", DEPTHS)
def test_shade(sample, encoding, y, light):
    m, dtype = DEPTHS[sample]
    texels = image(m, 4, seed=3, h=70, w=300).astype(dtype)
    for channels, alpha in ((1, True), (3, True), (3, False), (4, True)):
        dst = np.full((70, 300, channels), 7, np.uint8)
        seen = texels if alpha else np.ascontiguousarray(texels[..., :3])
        got = shade(seen, encoding, light, dst, y=y)
        want = expected_shade(seen, m, encoding, light or DEFAULT_LIGHT, y == ntp.DOWN, channels)
        colors = 1 if channels == 1 else 3
        assert np.array_equal(got[..., :colors], want)
        assert channels != 4 or (got[..., 3] == 255).all()


def test_shade_of_many_texels():
    """Gray lights, of which some make levels that are near a boundary, and some make none."""
    texels = np.random.default_rng(7).integers(0, 256, (64, 1000, 3), np.uint8)
    texels[::9, ::5] = np.random.default_rng(8).choice([0, 255], (8, 200, 1))
    texels[1::9, ::5, 0] = 128 + np.arange(200) % 17
    texels[1::9, ::5, 2] = 129 + 3 * (np.arange(200) % 17)  # 3X = Z: at right angles to a light
    lights = [
        ([0.3, -2.0, 0.9], 0, 1, 1, 1),
        ([0.3, -2.0, 0.9], 0.1, 0.9, 1, 0.6),
        ([0.3, -2.0, 0.9], 0, 0.5, 0, 0),
        *(([3.0 * scale, 0.0, -scale], 0, 1, 1, 1) for scale in (1.0, 1.1, 1.3, 1.7, 1.9)),
    ]
    for *light, own in lights:
        light = (*light, [own] * 3)
        for array, m in ((texels, 255), (texels.astype(np.uint16) * 257, 65535)):
            want = expected_shade(array, m, ntp.STANDARD, light)
            assert np.array_equal(shade(array, light=light), want)


def test_shade_of_all_texels():
    """Some lie as close to a boundary between two levels as any texel does."""
    texels = np.empty((256, 256, 3), np.uint8)
    texels[..., 1], texels[..., 2] = np.indices((256, 256))
    for red in range(256):
        texels[..., 0] = red
        assert np.array_equal(shade(texels), expected_shade(texels, 255, ntp.STANDARD)), red


def test_shade_of_glints():
    """Glints are what floats know least of; with little other light, they are decided by a wider bound."""
    rng = np.random.default_rng(9)
    texels = np.full((600, 1000, 3), 65535, np.uint16)
    texels[..., :2] = np.clip(rng.normal(32768, 9000, (600, 1000, 2)), 0, 65535)
    for ambient, diffuse in ((0, 0), (1e-5, 0), (0.002, 0), (0.3, 0), (0.1, 0.4)):
        light = ([0.1, -0.2, 0.9], ambient, diffuse, 1, [0.7] * 3)
        assert np.array_equal(
            shade(texels, light=light), expected_shade(texels, 65535, ntp.STANDARD, light)
        )


def test_shade_lights_what_faces_the_light():
    """A hill: its upper left side is lit, in either orientation of y."""
    y, x = np.mgrid[1:-1:64j, -1:1:64j] * 0.6
    v = np.dstack([x, y, np.sqrt(1 - x * x - y * y)])
    up = np.floor((v + 1) / 2 * 255 + 0.5).astype(np.uint8)
    down = up.copy()
    down[..., 1] = 255 - up[..., 1]
    picture = shade(up).astype(int)
    assert picture[:32, :32].mean() > 1.5 * picture[32:, 32:].mean()
    assert np.array_equal(shade(down, y=ntp.DOWN), picture)


def test_length_of_the_light_does_not_matter():
    texels = image(255, 3).astype(np.uint8)
    for scale in (2.0**-1040, 0.25, 2.0**1000):
        light = ([d * scale for d in (-1.0, 1.0, 1.25)], *DEFAULT_LIGHT[1:])
        assert np.array_equal(
            shade(texels, light=light), shade(texels, light=([-1.0, 1.0, 1.25], *light[1:]))
        )


def test_zero_filled_light_is_the_default():
    texels = image(255, 3).astype(np.uint8)
    assert np.array_equal(shade(texels, light=([0] * 3, 0, 0, 0, [0] * 3)), shade(texels))


@pytest.mark.parametrize("field", range(5))
@pytest.mark.parametrize("value", [np.nan, np.inf, -0.5, 1.5])
def test_bad_lights(field, value):
    light = list(DEFAULT_LIGHT)
    if field in (0, 4):
        light[field] = [0.5, value, 0.5]
    else:
        light[field] = value
    texels = image(255, 3).astype(np.uint8)
    if field == 0 and np.isfinite(value):
        shade(texels, light=light)
        return
    with pytest.raises(ntp.NtpError) as e:
        shade(texels, light=light)
    assert e.value.status == ntp.ERR_ARGUMENT


def test_light_from_nowhere():
    with pytest.raises(ntp.NtpError) as e:
        shade(image(255, 3).astype(np.uint8), light=([0.0] * 3, *DEFAULT_LIGHT[1:]))
    assert e.value.status == ntp.ERR_ARGUMENT


# -------------------------------------------------------------------------- the comparison


PAIRS = [("u8", "u8"), ("u16", "u16"), ("u8", "u16"), ("u16", "u8")]
ENCODINGS = [(0, 0), (0, 1), (1, 0), (1, 1), (2, 2), (0, 2), (2, 1)]


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("encodings", ENCODINGS)
@pytest.mark.parametrize("samples", PAIRS)
def test_compare(samples, encodings, flip):
    (ma, ta), (mb, tb) = DEPTHS[samples[0]], DEPTHS[samples[1]]
    a8 = image(255, 4, seed=11, h=23, w=270)
    b8 = nearly(a8, 255, 12)
    a = (a8 * (ma // 255)).astype(ta)
    b = (nearly(b8, 255, 13) * (mb // 255)).astype(tb)[..., : 3 if flip else 4]
    heat = np.full((23, 270, 3), 7, np.uint8)
    got = Diff().add(a, b, encodings, (ntp.UP, ntp.DOWN if flip else ntp.UP), heat).stats()
    off, degrees, channels = expected_compare(a, b, (ma, mb), encodings, flip)
    assert got["texels"] == 23 * 270 and got["max"] == max(ma, mb)
    assert got["channels"] == channels
    assert got["different"] == np.count_nonzero(off.any(-1))
    assert got["levels_max"] == [*off.reshape(-1, channels).max(0), *[0] * (4 - channels)]
    assert got["levels_mean"][:channels] == pytest.approx(off.reshape(-1, channels).mean(0))
    assert got["angles"]["texels"] == 23 * 270
    assert got["angles"]["mean"] == pytest.approx(degrees.mean(), abs=1e-6)
    assert got["angles"]["max"] == pytest.approx(degrees.max(), abs=1e-6)
    p99 = np.sort(degrees.ravel())[math.ceil(degrees.size * 99 / 100) - 1]
    assert got["angles"]["p99"] == pytest.approx(p99, abs=0.0006)
    assert np.array_equal(heat, expected_heat(degrees, ~off.any(-1)))


def test_compare_of_equal_textures_is_exactly_zero():
    for m, dtype in DEPTHS.values():
        texels = image(m, 4).astype(dtype)
        heat = np.full((*texels.shape[:2], 4), 7, np.uint8)
        stats = Diff().add(texels, texels, heat=heat).stats()
        assert stats["different"] == 0 and stats["levels_max"] == [0] * 4
        assert stats["angles"]["max"] == stats["angles"]["mean"] == stats["angles"]["p99"] == 0
        assert not heat[..., :3].any() and (heat[..., 3] == 255).all()


def test_compare_by_value_over_depths_and_orientations():
    """An 8-bit texture, the same times 257, and both flipped: no difference anywhere."""
    a = image(255, 3).astype(np.uint8)
    wide = a.astype(np.uint16) * 257
    down = a.copy()
    down[..., 1] = np.where(oracle.unused(a, 255), a[..., 1], 255 - a[..., 1])
    for b, y in ((wide, ntp.UP), (down, ntp.DOWN)):
        for pair, ys in (((a, b), (ntp.UP, y)), ((b, a), (y, ntp.UP))):
            stats = Diff().add(*pair, ys=ys).stats()
            assert stats["different"] == 0 and stats["angles"]["max"] == 0


def test_compare_after_conversion_finds_no_difference():
    """Clean standard against its own Z-zero version: levels agree both ways."""
    clean = ntp.clean(image(255, 3).astype(np.uint8))[0]
    zzero = np.zeros_like(clean)
    ntp.convert(clean, zzero, encoding=ntp.ZZERO)
    assert Diff().add(clean, zzero, (0, 1)).stats()["different"] == 0
    assert Diff().add(zzero, clean, (1, 0)).stats()["different"] == 0


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_compare_heights(channels):
    a = image(255, 4)[..., :channels].astype(np.uint8)
    b = nearly(a.astype(int), 255, 2).astype(np.uint8)
    heat = np.full((*a.shape[:2], 3), 7, np.uint8)
    stats = Diff().add(a, b, (4, 4), heat=heat).stats()
    off = np.abs(a.astype(int) - b)
    assert stats["levels_max"][:channels] == off.reshape(-1, channels).max(0).tolist()
    assert stats["different"] == np.count_nonzero(off.any(-1))
    assert stats["angles"]["texels"] == 0 and stats["angles"]["mean"] == 0
    assert np.array_equal(heat == 0, expected_heat(off.max(-1) * 180 / 255, ~off.any(-1)) == 0)


def test_diff_merges():
    a, b = image(255, 4, h=40, w=300), image(255, 4, seed=2, h=40, w=300)
    a, b = a.astype(np.uint8), b.astype(np.uint16)
    whole = Diff().add(a, b)
    one, other = Diff(), Diff()
    for i, area in enumerate([(0, 0, 300, 3), (0, 3, 17, 40), (17, 3, 299, 40), (299, 3, 300, 40)]):
        (one if i % 2 else other).add(a, b, area=area)
    ntp.check(ntp.lib.ntp_diff_merge(one.pointer, other.pointer))
    assert one.stats() == whole.stats()
    assert np.array_equal(one.memory, whole.memory)
    empty, nothing = Diff(), Diff()
    ntp.check(ntp.lib.ntp_diff_merge(empty.pointer, whole.pointer))
    ntp.check(ntp.lib.ntp_diff_merge(empty.pointer, nothing.pointer))
    assert empty.stats() == whole.stats()


def test_a_cleared_diff_is_empty():
    a, b = image(255, 4).astype(np.uint8), image(65535, 4, seed=2).astype(np.uint16)
    up, down = np.float32([[[0, 0, 1]]]), np.float32([[[0, 0, -1]]])
    opposite = Diff().add(up, down, encodings=(ntp.VECTOR, ntp.VECTOR))
    assert opposite.stats()["angles"]["max"] > 179.9  # the last bin
    for used in (Diff().add(a, b), Diff().add(a, a), opposite, Diff()):
        ntp.check(ntp.lib.ntp_diff_clear(used.pointer))
        assert not used.memory.any()
    assert ntp.lib.ntp_diff_clear(NULL) == ntp.ERR_ARGUMENT


def test_diff_errors():
    a = image(255, 3).astype(np.uint8)
    wide = a.astype(np.uint16)
    deep, shallow = Diff().add(a, wide), Diff().add(a, a)
    merge, summarize = ntp.lib.ntp_diff_merge, ntp.lib.ntp_diff_summarize
    stats = ntp.ffi.new("ntp_diff_stats *")
    assert merge(deep.pointer, shallow.pointer) == ntp.ERR_FORMAT
    assert merge(deep.pointer, deep.pointer) == ntp.ERR_ARGUMENT
    assert merge(NULL, deep.pointer) == merge(deep.pointer, NULL) == ntp.ERR_ARGUMENT
    empty = Diff()
    assert summarize(stats, empty.pointer) == ntp.ERR_ARGUMENT
    assert summarize(NULL, deep.pointer) == summarize(stats, NULL) == ntp.ERR_ARGUMENT
    cases = [
        ((a, a), (0, 4), ntp.ERR_FORMAT),
        ((a, a[..., :1].copy()), (4, 4), ntp.ERR_FORMAT),
        ((a, a[:, 1:]), (0, 0), ntp.ERR_SHAPE),
        ((a, wide), (0, 0), ntp.ERR_FORMAT),  # shallow holds 8 bit
    ]
    for pair, encodings, status in cases:
        before = shallow.memory.copy()
        with pytest.raises(ntp.NtpError) as e:
            shallow.add(*pair, encodings)
        assert e.value.status == status
        assert np.array_equal(before, shallow.memory)


# ------------------------------------------------------------------- views, areas, in place

PAINTERS = {"heatmap": heatmap, "shade": shade}


@pytest.mark.parametrize("name", PAINTERS)
@pytest.mark.parametrize("sample", DEPTHS)
def test_areas_and_strides(name, sample):
    m, dtype = DEPTHS[sample]
    paint = PAINTERS[name]
    texels = image(m, 4, h=37, w=600).astype(dtype)
    whole = paint(texels)
    parts = np.full((37, 600, 3), 7, np.uint8)
    for area in [(0, 0, 600, 1), (0, 1, 5, 37), (5, 1, 300, 37), (300, 1, 600, 20)]:
        paint(texels, dst=parts, area=area)
    assert (parts[20:, 300:] == 7).all()
    paint(texels, dst=parts, area=(300, 20, 600, 37))
    assert np.array_equal(parts, whole)
    big = np.full((40, 700, 5), 7, np.uint8)
    inner = big[38:1:-1, 650:50:-1, 1:5]
    paint(texels, dst=inner)
    assert np.array_equal(inner[..., :3], whole) and (inner[..., 3] == 255).all()
    assert (big[..., 0] == 7).all() and (big[:, :51] == 7).all() and (big[39] == 7).all()
    mirrored = np.ascontiguousarray(texels[::-1, ::-1])[::-1, ::-1]
    assert np.array_equal(paint(mirrored), whole)


@pytest.mark.parametrize("name", PAINTERS)
def test_in_place(name):
    texels = image(255, 4, h=9, w=600).astype(np.uint8)
    whole = PAINTERS[name](texels, dst=np.zeros_like(texels))
    assert np.array_equal(PAINTERS[name](texels, dst=texels), whole)


def test_heat_in_place():
    a, b = image(255, 3, h=9, w=600).astype(np.uint8), image(255, 3, 2, 9, 600).astype(np.uint8)
    heat = np.zeros_like(a)
    stats = Diff().add(a, b, heat=heat).stats()
    assert Diff().add(a, b, heat=b).stats() == stats
    assert np.array_equal(b, heat)


def test_picture_errors():
    """Status, and nothing written."""
    src = image(255, 3).astype(np.uint8)
    h, w = src.shape[:2]
    dst = np.full((h, w, 4), 7, np.uint8)
    wide = np.full((h, w, 3), 7, np.uint16)
    good, source = ntp.view(dst, ntp.HEIGHT), ntp.view(src, const=True)
    height = ntp.view(src, ntp.HEIGHT, const=True)
    outside = ntp.rect((0, 0, w + 1, h))
    paints = {
        "heatmap": lambda d, s, area=NULL, *how: ntp.lib.ntp_heatmap(d, s, *(how or (0, 0)), area),
        "shade": lambda d, s, area=NULL: ntp.lib.ntp_shade(d, s, NULL, area),
    }
    for name, paint in paints.items():
        assert paint(NULL, source) == paint(good, NULL) == ntp.ERR_ARGUMENT
        assert paint(good, height) == ntp.ERR_FORMAT
        assert paint(ntp.view(dst, ntp.STANDARD), source) == ntp.ERR_FORMAT
        assert paint(ntp.view(wide, ntp.HEIGHT), source) == ntp.ERR_FORMAT
        assert paint(ntp.view(dst[..., :2], ntp.HEIGHT), source) == ntp.ERR_FORMAT
        gray = paint(ntp.view(dst[..., :1], ntp.HEIGHT), source)
        assert gray == (ntp.ERR_FORMAT if name == "heatmap" else ntp.OK)
        dst[:] = 7
        assert paint(ntp.view(dst[1:], ntp.HEIGHT), source) == ntp.ERR_SHAPE
        assert paint(good, source, outside) == ntp.ERR_SHAPE
        shifted = ntp.view(src.reshape(w, h, 3), ntp.HEIGHT, width=w, height=h)
        assert (w == h) or paint(shifted, source) == ntp.ERR_OVERLAP
    for how in ((2, 0), (-1, 0), (0, 8)):
        status = paints["heatmap"](good, source, NULL, *[ntp.ffi.cast("uint32_t", v) for v in how])
        assert status == ntp.ERR_ARGUMENT
    compare, diff = ntp.lib.ntp_diff_add, Diff()
    assert compare(NULL, good, source, source, NULL) == ntp.ERR_ARGUMENT
    assert compare(diff.pointer, good, NULL, source, NULL) == ntp.ERR_ARGUMENT
    assert compare(diff.pointer, good, source, source, outside) == ntp.ERR_SHAPE
    assert compare(diff.pointer, ntp.view(wide, 4), source, source, NULL) == ntp.ERR_FORMAT
    assert not diff.memory.any()
    assert (dst == 7).all() and (wide == 7).all()
