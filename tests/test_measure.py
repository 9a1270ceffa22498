# SPDX-License-Identifier: MIT
"""ntp_tally_add, ntp_tally_summarize and the histograms against numpy; parts merge to the whole."""

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle_measure
from support.evidence import evidence
from support.texels import cuts, image

ENCODINGS = {"standard": ntp.STANDARD, "zzero": ntp.ZZERO, "xy": ntp.XY}
COUNTS = [
    "texels",
    "unused",
    "black",
    "white",
    "transparent",
    "max",
    "stored_max",
    "channels",
    "xy_too_long",
    "xy_far_too_long",
    "neighbor_and_near",
    "z_negative",
    "unused_xy_too_long",
    "unused_z_negative",
    "gray",
    "flat",
    "distinct_flat",
    "distinct",
    "alpha_zero",
    "alpha_full",
    "levels_off_max",
]
EVIDENCE_COUNTS = [
    "padding",
    "used_z_negative",
    "steepness",
    "steepness_not_rounded",
    "steepness_not_neighbor",
    "red_low",
    "green_low",
]
FIT_COUNTS = [
    "neighbor",
    "rounded",
    "exact",
    "exact_mirrored",
    "unused_neighbor",
    "unused_rounded",
    "unused_exact",
    "used_levels_le",
]


def make(kind):
    """(array, encoding) for a name such as "standard-u16-4"."""
    encoding, sample, channels = kind.split("-")
    channels = int(channels)
    if sample == "u8":
        array = image(255, channels).astype(np.uint8)
    elif sample == "u16":
        array = image(65535, channels).astype(np.uint16)
    elif sample == "u16of8":
        array = (image(255, channels) * 257).astype(np.uint16)
    else:
        array = (image(65535, channels) / 65535).astype(np.float32)
    return array, ENCODINGS[encoding]


KINDS = [f"{e}-{s}-{c}" for e in ENCODINGS for s in ("u8", "u16", "u16of8", "f32") for c in (3, 4)]
KINDS += ["xy-u8-2", "xy-u16-2"]


@pytest.mark.parametrize("touch", [0, 7])
def test_grays(touch):
    """Every gray, and its neighbors in blue: some are also next to a derived blue."""
    gray = np.arange(256)
    rgb = [[v, v, np.clip(v + d, 0, 255)] for v in gray for d in (-16, -1, 0, 1, 16)]
    array = np.array(rgb, np.uint8)[None]
    got = ntp.Tally().measure(array, ntp.STANDARD, touch).stats(ntp.STANDARD)
    want = oracle_measure.measure(array, False, touch, False)
    assert {k: got[k] for k in COUNTS} == {k: want[k] for k in COUNTS}
    assert got["gray"] == 256 + 2 * 2  # clipping makes two more of 0 and of 255


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("touch", [0, 7, 4])
def test_summarize(kind, touch):
    array, encoding = make(kind)
    check_summary(ntp.Tally().measure(array, encoding, touch), array, encoding, touch)


FEW = 4096  # NTP__FEW of color_counts.h: fewer texels are measured in another way


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("width,height", [(2, 3), (17, 5), (64, 63), (64, 64), (64, 65)])
def test_few_texels(kind, width, height):
    """The same in a new tally, in one that has tables from before, and in parts."""
    array, encoding = make(kind)
    small = np.tile(array, (2, 1, 1))[7 : 7 + height, 3 : 3 + width]
    fresh = ntp.Tally().measure(small, encoding)
    check_summary(fresh, small, encoding, 0)
    used = ntp.Tally().measure(array, encoding)
    used.stats(encoding)
    ntp.check(ntp.lib.ntp_tally_clear(used.pointer))
    want = everything(fresh, encoding)
    assert everything(used.measure(small, encoding), encoding) == want
    rows = ntp.Tally()
    for y in range(height):  # goes on to more than a few
        rows.measure(small, encoding, area=(0, y, width, y + 1))
    assert everything(rows, encoding) == want
    many = ntp.Tally().measure(array, encoding)
    assert array.shape[0] * array.shape[1] > FEW
    both = ntp.Tally().measure(small, encoding).merge(many)
    assert everything(both, encoding) == everything(many.merge(fresh), encoding)


@pytest.mark.parametrize("times", [1, 80000])
def test_noise(times):
    """Rows of cells that are full, and colors that are more than a byte counts."""
    rng = np.random.default_rng(11)
    array = rng.integers(0, 256, (120, 5400, 3)).astype(np.uint8)  # all rows are sampled
    array.reshape(-1, 3)[:times, :2] = 190, 90
    check_summary(ntp.Tally().measure(array, ntp.STANDARD), array, ntp.STANDARD, 0)


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("touch", [0, 7])
def test_runs_of_one_color(channels, touch):
    """Groups of equal texels are counted at once: runs that begin and end anywhere."""
    rng = np.random.default_rng(6)
    colors = [(0, 0, 0, 255), (255, 255, 255, 255), (128, 128, 255, 255), (9, 9, 9, 255),
              (0, 0, 0, 0), (255, 255, 255, 0), (90, 100, 200, 0), (140, 70, 230, 99),
              (255, 255, 0, 255), (200, 60, 90, 255), (128, 127, 255, 0)]  # fmt: skip
    lengths = rng.integers(1, 70, 400)
    flat = np.repeat(rng.choice(np.array(colors, np.uint8), 400), lengths, 0)
    size = flat.shape[0] // 251 * 251
    array = np.ascontiguousarray(flat[:size, :channels].reshape(-1, 251, channels))
    assert array.shape[0] < 128  # all rows are sampled
    check_summary(ntp.Tally().measure(array, ntp.STANDARD, touch), array, ntp.STANDARD, touch)


@pytest.mark.parametrize("least", [0, 70])
def test_many_of_a_few_colors(least):
    """Counts that are more than a byte holds, also where parts merge, and after clearing."""
    rng = np.random.default_rng(8)
    colors = np.array([(200, 60, 9), (201, 60, 9), (128, 127, 3), (140, 70, 220)], np.uint8)
    array = np.ascontiguousarray(rng.choice(colors, (120, 200), p=(0.55, 0.02, 0.03, 0.4)))
    tally = ntp.Tally().measure(array[least:], ntp.STANDARD)
    tally.stats(ntp.STANDARD)
    if least > 0:
        tally.merge(ntp.Tally().measure(array[:least], ntp.STANDARD))
    check_summary(tally, array, ntp.STANDARD, 0)
    ntp.check(ntp.lib.ntp_tally_clear(tally.pointer))
    check_summary(tally.measure(array[:90], ntp.STANDARD), array[:90], ntp.STANDARD, 0)


@pytest.mark.parametrize("count", [255, 256, 257, 4096])
def test_counts_of_whole_bytes(count):
    """Colors of two rows, so often that a byte is 0 again: far, near and at both ends."""
    blues = (0, 9, 63, 64, 65, 127, 128, 190, 191, 192, 194, 215, 223, 224, 255)
    colors = [pair + (b,) for pair in ((206, 207), (90, 131)) for b in blues]
    array = np.repeat(np.array(colors, np.uint8)[None], count, 0)
    check_summary(ntp.Tally().measure(array, ntp.STANDARD), array, ntp.STANDARD, 0)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("visible", [0.01, 0.3])
def test_colors_of_transparent_texels(dtype, visible):
    """Rows of more transparent colors than are judged at once."""
    rng = np.random.default_rng(9)
    m = np.iinfo(dtype).max
    array = rng.integers(0, 256, (5, 700, 4)).astype(dtype) * dtype(m // 255)
    array[2:] ^= (rng.random((3, 700, 4)) < 0.1).astype(dtype)
    array[..., 3] = np.where(rng.random((5, 700)) < visible, m, 0)
    array[4] = np.repeat(array[4, ::7], 7, 0)
    check_summary(ntp.Tally().measure(array, ntp.STANDARD), array, ntp.STANDARD, 0)


@pytest.mark.parametrize("touch", range(8))
@pytest.mark.parametrize("count", [60, 900])
def test_transparent_colors_that_come_again(touch, count):
    """Fewer and more colors than have a place at once, black and white among them, in any order."""
    rng = np.random.default_rng(count)
    colors = rng.integers(0, 256, (count, 4)).astype(np.uint8)
    colors[:, 3] = np.where(rng.random(count) < 0.8, 0, rng.integers(0, 256, count))
    colors[:2, :3], colors[:2, 3] = [[0], [255]], 0
    array = colors[rng.integers(0, count, (40, 130))]
    array[9:12] = np.repeat(array[9:12, ::10], 10, 1)
    check_summary(ntp.Tally().measure(array, ntp.STANDARD, touch), array, ntp.STANDARD, touch)


def test_odd_texel_among_wide_ones():
    """Blocks of 16-bit texels that are counted as a whole, but for one: gray, flat, of 8 bit, too
    long by as little as can be."""
    m = 65535
    x = int((m * m / 2) ** 0.5) | 1  # nearest to the circle, from within
    inside, over = (x + m) // 2, (x + 2 + m) // 2
    odd = [(0, 0, 0), (m, m, m), (9999, 9999, 9999), (32767, 32768, 65500), (32768, 32768, m),
           (257, 514, 771), (m, 32700, 0), (inside, inside, 33000), (over, inside, 33000),
           (over, over, 33000), (32768, 32768, 60000), (32766, 32768, 60000)]  # fmt: skip
    array = np.random.default_rng(7).integers(28000, 37001, (len(odd), 256, 3), np.uint16)
    array[..., 2] += 28000
    for row, color in enumerate(odd):
        array[row, 7 * row + 3] = color
        one = array[row : row + 1]
        check_summary(ntp.Tally().measure(one), one, ntp.STANDARD, 0)
    check_summary(ntp.Tally().measure(array), array, ntp.STANDARD, 0)


@pytest.mark.parametrize("color", [(128, 128, 255), (0, 0, 0)])
def test_one_color_and_one_texel(color):
    """One other texel at the end of a picture of one color is seen."""
    array = np.full((80, 80, 3), color, np.uint8)
    assert ntp.Tally().measure(array).stats()["distinct"] == (color != (0, 0, 0))
    array[79, 79] = 120, 130, 254
    assert ntp.Tally().measure(array).stats()["distinct"] == 1 + (color != (0, 0, 0))


def check_summary(tally, array, encoding, touch):
    got = tally.stats(encoding)
    want = oracle_measure.measure(array, encoding == ntp.ZZERO, touch, encoding == ntp.XY)
    narrow = want["max"] == 255
    assert {k: got[k] for k in COUNTS} == {k: want[k] for k in COUNTS}
    for name in ("standard", "zzero"):
        have, need = got[name], want[name]
        assert {k: have[k] for k in FIT_COUNTS} == {k: need[k] for k in FIT_COUNTS}
        for field in ("length_min", "length_mean", "length_max"):
            assert have[field] == pytest.approx(need[field], abs=2e-5), field
        histogram = tally.levels_off(ENCODINGS[name])
        off = need["off"][need["off"] >= 0]
        assert np.array_equal(histogram, np.bincount(off, minlength=65536))
        lengths = np.floor(need["length"] * 65536 + 0.5).astype(int) >> 9
        lengths = np.bincount(np.minimum(lengths, 255), minlength=256)
        assert np.array_equal(tally.lengths(ENCODINGS[name]), lengths)
    for have, need in zip(got["channel"], want["channel"]):
        assert (have["min"], have["max"]) == (need["min"], need["max"])
        assert have["mean"] == pytest.approx(need["mean"], rel=1e-12)
    degrees = want["degrees"]
    angles = got["angles"]
    assert len(degrees) > 0
    assert angles["texels"] == len(degrees)
    assert angles["mean"] == pytest.approx(degrees.mean(), abs=2e-6)
    assert angles["max"] == pytest.approx(degrees.max(), abs=2e-6)
    rank = np.sort(degrees)[(len(degrees) * 99 + 99) // 100 - 1]
    assert angles["p99"] == pytest.approx(rank, abs=0.0011)
    check_harm(tally, encoding, want)
    close = 1e-9 if narrow else 0.003
    assert got["used_mean"][:3] == pytest.approx(want["used_mean"], abs=close)
    if narrow and array.dtype == np.uint8:
        assert got["near_gamma_flat"] == want["near_gamma_flat"]
    check_evidence(tally, array, want)


def check_harm(tally, encoding, want):
    for kinds in (1, 2, 4, 3, 7):
        of = np.isin(want["harm_kinds"], [k for k in range(3) if kinds >> k & 1])
        degrees = np.sort(np.where(of, want["harm_degrees"], 0))
        rank = degrees[(len(degrees) * 99 + 99) // 100 - 1]
        for limit in (0, 0.5, 5, 60):
            got = tally.harm(encoding, kinds, limit)
            assert got["texels"] == np.count_nonzero(of)
            least, most = (np.count_nonzero(degrees > limit + e) for e in (6e-7, 4e-7))
            assert least <= got["over"] <= most  # angles are whole micro-degrees
            assert got["mean"] == pytest.approx(degrees.mean(), abs=2e-6)
            assert got["max"] == pytest.approx(degrees.max(), abs=2e-6)
            assert rank - 1e-6 <= got["p99"] <= rank + 0.01001


def check_evidence(tally, array, want):
    """The other statistics that the classifier uses."""
    got = evidence(tally)
    narrow = want["max"] == 255
    assert {k: got[k] for k in EVIDENCE_COUNTS} == {k: want[k] for k in EVIDENCE_COUNTS}
    for have, need in zip(got["fit"], (want["standard"], want["zzero"]), strict=True):
        assert have["length_mean"] == pytest.approx(need["used_length_mean"], abs=2e-5)
        assert have["length_sd"] == pytest.approx(need["used_length_sd"], abs=2e-4)
        assert have["too_short"] == pytest.approx(need["used_short"], abs=1e-12)
        assert have["too_long"] == pytest.approx(need["used_long"], abs=1e-12)
    assert got["steepness_length_error"] == pytest.approx(want["steepness_length_error"], abs=2e-5)
    if narrow and array.dtype == np.uint8:
        assert got["stats"]["used_mean"][:3] == pytest.approx(want["judged_mean"], abs=1e-9)
        assert got["used_sd"][:3] == pytest.approx(want["used_sd"], abs=1e-9)
        if array.shape[2] > 2:
            c = np.corrcoef(want["parts"].T)
            assert got["correlation"] == pytest.approx([c[0, 1], c[0, 2], c[1, 2]], abs=1e-9)
    if "ag_in_disc" in want:
        close = 1e-9 if narrow else 0.003
        assert got["ag_in_disc"] == pytest.approx(want["ag_in_disc"], abs=close)


@pytest.mark.parametrize("m,dtype", [(255, np.uint8), (65535, np.uint16)])
@pytest.mark.parametrize("width", [1, 8, 9, 83])
def test_block_step(m, dtype, width):
    """Every row of a small image counts."""
    levels = image(m, w=83)
    levels += np.arange(83)[None, :, None] // 8 * (m // 200)  # a step at each block
    array = np.clip(levels, 1, m - 1)[:, :width].astype(dtype)
    got = evidence(ntp.Tally().measure(array))["block_step"]
    want = oracle_measure.block_steps(array, m) if width > 1 else np.zeros(3)
    assert got == pytest.approx(want, rel=1e-9)


def everything(tally, encoding):
    """All results of a tally, in a form that can be compared."""
    parts = [tally.stats(encoding), evidence(tally)]
    parts += [tally.harm(encoding, kinds) for kinds in range(8)]
    for e in (ntp.STANDARD, ntp.ZZERO):
        parts += [tally.levels_off(e).tolist(), tally.lengths(e).tolist()]
    return parts


@pytest.mark.parametrize("kind", KINDS)
def test_parts_merge_to_the_whole(kind):
    array, encoding = make(kind)
    rng = np.random.default_rng(len(kind))
    whole = everything(ntp.Tally().measure(array, encoding), encoding)
    for count in (2, 5, 17):
        areas = cuts(*array.shape[:2], rng, count)
        rng.shuffle(areas)
        one = ntp.Tally()
        for area in areas:
            one.measure(array, encoding, area=area)
        assert everything(one, encoding) == whole
        parts = [ntp.Tally().measure(array, encoding, area=area) for area in areas[:5]]
        rest = ntp.Tally()
        for area in areas[5:]:
            rest.measure(array, encoding, area=area)
        parts.append(rest)
        while len(parts) > 1:  # in any order, any tree; asking in between changes nothing
            i, j = rng.choice(len(parts), 2, replace=False)
            if rng.random() < 0.3 and parts[i] is not rest:
                parts[i].stats(encoding)
            parts[i].merge(parts[j])
            parts.pop(j)
        assert everything(parts[0], encoding) == whole


def test_a_cleared_tally_is_empty():
    for kind in ("standard-u8-4", "standard-u16-3", "zzero-f32-4"):
        array, encoding = make(kind)
        want = everything(ntp.Tally().measure(array, encoding), encoding)
        for other_kind in ("standard-u8-3", "xy-u16-4", "standard-f32-3"):
            other, other_encoding = make(other_kind)
            tally = ntp.Tally().measure(other, other_encoding)
            tally.stats(other_encoding)
            ntp.check(ntp.lib.ntp_tally_clear(tally.pointer))
            assert everything(tally.measure(array, encoding), encoding) == want


def test_blue_of_many_texels_in_few_pairs():
    """Red and green that come thousands of times, with blues of any size, are summed as they are once."""
    rng = np.random.default_rng(3)
    one = rng.integers(20000, 45000, (8, 8, 3)).astype(np.uint16)
    one[:, :, 2] = rng.integers(32768, 65536, (8, 8))
    one[0] = 65280, 32700, 65530  # the brightest blue there is
    want = evidence(ntp.Tally().measure(one))
    half = ntp.Tally().measure(np.tile(one, (1, 4333, 1)))
    many = ntp.Tally().merge(half).merge(half)
    for tally in (half, many, many.measure(np.tile(one, (1, 2000, 1)))):
        got = evidence(tally)
        assert got["tilted"] % want["tilted"] == 0 and want["tilted"] > 32
        for name in ("tilted_gap", "tilted_off", "tilted_near", "tilted_above"):
            assert got[name] == pytest.approx(want[name], rel=1e-9), name
        for name in ("blue_drop", "blue_slope", "blue_correlation"):
            assert got[name] == pytest.approx(want[name], rel=1e-9), name


def test_16_bit_with_8_bit_content_is_judged_as_8_bit():
    """One level that is not a multiple of 257, in any channel and any part, makes it 16 bit."""
    narrow = (image(255, 4) * 257).astype(np.uint16)
    assert ntp.Tally().measure(narrow).stats()["max"] == 255
    for channel in range(4):
        array = narrow.copy()
        array[50, 60, channel] ^= 1
        tally = ntp.Tally()
        for area in ((0, 0, 83, 30), (0, 30, 83, 61)):
            tally.measure(array, area=area)
        got = tally.stats()
        want = oracle_measure.measure(array)
        assert got["max"] == want["max"] == 65535, channel
        assert got["standard"]["neighbor"] == want["standard"]["neighbor"], channel


def test_errors():
    a8, _ = make("standard-u8-3")
    a16, _ = make("standard-u16-3")
    a4, _ = make("standard-u8-4")
    cases = [(a16, ntp.STANDARD), (a4, ntp.STANDARD), (a8, ntp.XY)]
    for array, encoding in cases:
        tally = ntp.Tally().measure(a8)
        with pytest.raises(ntp.NtpError) as error:
            tally.measure(array, encoding)
        assert error.value.status == ntp.ERR_FORMAT
        with pytest.raises(ntp.NtpError) as error:
            tally.merge(ntp.Tally().measure(array, encoding))
        assert error.value.status == ntp.ERR_FORMAT
        assert tally.stats()["texels"] == a8.shape[0] * a8.shape[1]
    with pytest.raises(ntp.NtpError) as error:
        ntp.Tally().measure(a16).stats(ntp.ZZERO)
    assert error.value.status == ntp.ERR_FORMAT
    tally = ntp.Tally().measure(a8)
    most = int(np.flatnonzero(tally.levels_off())[-1])
    assert 0 < most < 255
    assert np.array_equal(tally.levels_off(size=most + 1), tally.levels_off()[: most + 1])
    with pytest.raises(ntp.NtpError) as error:
        tally.levels_off(size=most)
    assert error.value.status == ntp.ERR_ARGUMENT
    for wrong in ({"kinds": 8}, {"degrees": -0.1}, {"degrees": 180.1}, {"degrees": np.nan}):
        with pytest.raises(ntp.NtpError) as error:
            tally.harm(**wrong)
        assert error.value.status == ntp.ERR_ARGUMENT
    assert tally.harm(kinds=0) == {"texels": 0, "over": 0, "mean": 0, "p99": 0, "max": 0}
    with pytest.raises(ntp.NtpError) as error:
        ntp.Tally().measure(a8, area=(0, 0, 84, 1))
    assert error.value.status == ntp.ERR_SHAPE
    with pytest.raises(ntp.NtpError) as error:
        ntp.Tally().measure(a8, touch_unused=8)
    assert error.value.status == ntp.ERR_ARGUMENT
    lib, null = ntp.lib, ntp.ffi.NULL
    assert lib.ntp_tally_add(null, ntp.view(a8, const=True), 0, null) == ntp.ERR_ARGUMENT
    assert lib.ntp_tally_add(ntp.Tally().pointer, null, 0, null) == ntp.ERR_ARGUMENT
    assert lib.ntp_tally_summarize(null, ntp.Tally().pointer, 0) == ntp.ERR_ARGUMENT


def test_not_finite():
    array = (image(65535) / 65535).astype(np.float32)
    array[3, 4, 0], array[5, 6, 2], array[7, 8, 1] = np.nan, np.inf, -np.inf
    stats = ntp.Tally().measure(array).stats()
    assert stats["not_finite"] == 3
    assert stats["texels"] == array.shape[0] * array.shape[1]


def padded_atlas(dtype):
    """Half an atlas of unit vectors, half a green that spreads by 4 levels, with blues around the
    middle; returns it and where the green is."""
    rng = np.random.default_rng(5)
    v = rng.normal(size=(64, 64, 3)) * [0.2, 0.2, 0] + [0, 0, 1]
    levels = np.floor((v / np.linalg.norm(v, axis=2)[..., None] + 1) / 2 * 255 + 0.5)
    green = np.zeros((64, 64), bool)
    green[:, 32:] = True
    levels[green] = rng.integers(0, 5, (64 * 32, 3)) + [0, 250, 125]
    levels[0, 0] = 10, 20, 0
    scale = 257 if dtype == np.uint16 else 1
    array = levels.astype(dtype) * scale
    if dtype == np.uint16:
        array[1, 1] += 1  # else it is judged as 8 bit
    return array, green


@pytest.mark.parametrize("height", [128, 256, 512, 2048])
def test_sampled_rows_keep_no_pace_with_bars(height):
    """What sampled rows tell is near what all rows tell, however wide horizontal bars are."""
    row = np.arange(height)[:, None, None] + np.zeros((1, 4, 3))
    for period in (2, 3, 4, 5, 6, 8, 12, 16, 20, 24, 32, 48, 64):
        # a steep side and a gentle one
        array = np.where(row % period < period / 4, [128, 10, 150], [128, 167, 248])
        array = array.astype(np.uint8)
        whole = ntp.Tally().measure(array)
        assert whole.stats()["used_mean"][:3] == pytest.approx(array.mean((0, 1)) / 255), period
        assert evidence(whole)["used_sd"][:3] == pytest.approx(array.std((0, 1)) / 255, abs=0.05), (
            period
        )
        array = np.dstack([array, np.full(array.shape[:2], 200, np.uint8)])
        array[:2, 0] = 1, 2, 3, 0  # the colors of transparent texels are not known: rows tell
        mean = array[2:, 0, :3].mean(0) / 255
        got = ntp.Tally().measure(array).stats()["used_mean"][:3]
        assert got == pytest.approx(mean, abs=0.05), period


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_padding_of_one_color_is_no_harm(dtype):
    array, green = padded_atlas(dtype)
    whole, charts = ntp.Tally().measure(array), ntp.Tally().measure(array[:, :32].copy())
    stats, want = whole.stats(), charts.stats()
    low = array[..., 2] <= np.iinfo(dtype).max // 2
    assert stats["padding"] == green.sum()
    assert stats["padding_z_negative"] == np.count_nonzero(low & green) > 0
    assert stats["used_mean"][:3] == pytest.approx(want["used_mean"][:3])
    for kinds in range(1, 8):
        assert whole.harm(kinds=kinds) == pytest.approx(charts.harm(kinds=kinds))
    # the verdicts still count it, and so does what it is not: one color, or enough of it
    assert stats["xy_too_long"] == want["xy_too_long"] + green.sum()
    few = array.copy()
    few[:, 33:] = array[:, :31]
    few[4:] = np.where(green[4:, :, None], array[:60, :1], few[4:])
    assert ntp.Tally().measure(few).stats()["padding"] == 0
    two = array.copy()
    two[32:, 32:] = np.iinfo(dtype).max - array[32:, 32:]
    stats = ntp.Tally().measure(two).stats()
    assert (stats["padding"], stats["padding_z_negative"]) == (0, 0)
    assert ntp.Tally().measure(two).harm()["texels"] >= green.sum()
