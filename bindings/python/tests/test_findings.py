# SPDX-License-Identifier: MIT
"""What is found out: measuring, classes, origin, orientation, against the oracles of the library."""

import copy
import dataclasses
import math

import hypothesis
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import normaltexture as nt
from pysupport.drawn import max_of, textures, types
from support import oracle_measure, oracle_orientation


@hypothesis.settings(max_examples=60)
@given(textures(), st.booleans())
def test_measure(texture, touch):
    got = nt.measure(texture, touch_unused=touch)
    want = oracle_measure.measure(texture, touch=7 if touch else 0)
    for name in ("texels", "max", "stored_max", "channels", "black", "white", "transparent",
                 "unused", "xy_too_long", "z_negative", "gray", "flat", "distinct_flat",
                 "distinct", "alpha_zero", "alpha_full"):  # fmt: skip
        assert getattr(got, name) == want[name], name
    for reading in ("standard", "zzero"):
        fit = getattr(got, reading)
        for name in ("neighbor", "rounded", "exact", "exact_mirrored"):
            assert getattr(fit, name) == want[reading][name], (reading, name)
        assert fit.length_min == pytest.approx(want[reading]["length_min"], abs=2e-5)
        assert fit.length_max == pytest.approx(want[reading]["length_max"], abs=2e-5)
        assert fit.length_mean == pytest.approx(want[reading]["length_mean"], abs=2e-5)
    off = want["standard"]["off"]
    assert list(got.levels_off) == np.bincount(off[off >= 0]).tolist()[: len(got.levels_off)]
    assert sum(got.levels_off) == np.count_nonzero(off >= 0)
    assert sum(got.lengths) == got.texels
    if len(want["degrees"]):
        assert got.angles.mean == pytest.approx(want["degrees"].mean(), abs=1e-6)
        assert got.angles.max == pytest.approx(want["degrees"].max(), abs=1e-6)


@given(textures(dtypes=(np.uint16,)))
def test_floats_are_judged_as_16_bit(texture):
    floats = (texture / np.float32(65535)).astype(np.float32)
    for function in (nt.validate, nt.heatmap):
        found = function(floats, type="standard")
        assert np.array_equal(found, function(texture, type="standard"))
    cleaned = nt.clean(texture, type="standard") / np.float32(65535)
    assert np.array_equal(nt.clean(floats, type="standard"), cleaned)
    assert nt.measure(floats) == nt.measure(texture)


@given(textures(max_side=4), types, st.booleans())
def test_inspect(texture, type, keep):
    flags = nt.validate(texture, type=type, keep_negative_z=keep)
    how = {"type": type, "keep_negative_z": keep, "touch_unused": True, "method": "derive"}
    cleaned = nt.clean(texture, **how)
    vectors = nt.decode(texture, type=type)
    for y, x in np.ndindex(*texture.shape[:2]):
        texel = nt.inspect(texture, x, y, type=type, keep_negative_z=keep)
        assert texel.flags == flags[y, x] and texel.max == max_of(texture)
        assert list(texel.stored[: texture.shape[2]]) == texture[y, x].tolist()
        colors = min(texture.shape[2], 3)
        assert list(texel.cleaned[:colors]) == cleaned[y, x, :colors].tolist()
        if type != "xy":
            assert (texel.x, texel.y, texel.z) == pytest.approx(vectors[y, x].tolist(), abs=1e-6)
        assert texel.length == pytest.approx(np.hypot(np.hypot(texel.x, texel.y), texel.z))
    for wrong in ((-1, 0), (0, texture.shape[0]), (0.5, 0)):
        with pytest.raises(nt.ArgumentError, match="^[xy]="):
            nt.inspect(texture, *wrong)


@pytest.mark.parametrize("kernel", ["central", "forward", "sobel3"])
@pytest.mark.parametrize("y", ["up", "down"])
def test_origin_and_seams(kernel, y):
    rows, columns = np.mgrid[0:96, 0:96] * (2 * np.pi / 96)
    rough = np.random.default_rng(5).normal(0, 0.05, (96, 96))
    hills = np.sin(3 * columns + np.cos(rows)) + np.cos(2 * rows) + rough
    normals = nt.normals_from_height(hills.astype(np.float32), scale=1.0, kernel=kernel, to_y=y)
    origin = nt.find_kernel(normals, y=y)
    assert origin.decided and origin.kernel == kernel
    assert origin.misfit[kernel] == min(origin.misfit.values()) and "gimp9" not in origin.misfit
    assert all(seam.decided and seam.tiles for seam in nt.find_seams(normals))
    smooth = nt.normals_from_height((hills - rough).astype(np.float32), scale=4.0)
    seams = nt.find_seams(smooth[:, :72])
    assert [(seam.decided, seam.tiles) for seam in seams] == [(True, False), (True, True)]
    assert not any(seam.decided or seam.tiles for seam in nt.find_seams(normals[:8]))
    with pytest.raises(nt.ArgumentError, match="^y="):
        nt.find_kernel(normals, y="left")


def test_consistency_of_telescoping():
    height = np.random.default_rng(6).normal(size=(20, 30)).astype(np.float32)
    consistent = nt.normals_from_height(height, scale=1.0, kernel="forward", depth=16)
    how = {"kernel": "forward", "border": "wrap", "method": "telescoping"}
    _, info = nt.height_from_normals_with_info(consistent, y="up", z="stored", **how)
    assert 0 < info.consistency <= info.consistency_max < 0.02
    _, info = nt.height_from_normals_with_info(consistent[::-1], y="up", z="stored", **how)
    assert info.consistency > 0.1


@pytest.mark.parametrize("depth", [8, 16])
def test_steps_of_coarse_heights(test_files, depth):
    """Central slopes of 8-bit heights are multiples of scale/(2 * 255)."""
    height = nt.read(test_files / "height_gray8.png")
    found = nt.find_steps(nt.normals_from_height(height, scale=10, depth=depth))
    assert found.decided and found.slope == pytest.approx(10 / 510, rel=1e-2)
    assert found.degrees == pytest.approx(math.degrees(math.atan(10 / 510)), rel=1e-2)
    assert found.teeth >= 4 and 1 >= found.share > found.expected > 0
    smooth = nt.normals_from_height(nt.blur_height(height, 2), scale=10, depth=depth)
    assert nt.find_steps(smooth) == nt.Steps(False, 0, 0.0, 0.0, 0.0, 0.0)
    with pytest.raises(nt.ArgumentError, match="type="):
        nt.find_steps(smooth, type="bumps")


def test_levels_off_of_unused_texels():
    """They are in the histogram, also where they are further off than the used ones."""
    texture = np.full((3, 4, 4), (128, 128, 255, 255), np.uint8)
    texture[0, 0] = 128, 128, 200, 0
    for dtype, unit in ((np.uint8, 1), (np.uint16, 257)):
        stats = nt.measure((texture * dtype(unit)).astype(dtype))
        assert (stats.levels_off_max[0], len(stats.levels_off)) == (0, 56)
        assert (stats.levels_off[0], stats.levels_off[55]) == (11, 1)
    texture[0, 0, 2] = 201
    deep = texture.astype(np.uint16) * 257 - 1
    deep[0, 0, 3] = 0
    assert sum(nt.measure(deep).levels_off) == 12
    assert nt.measure(np.zeros((2, 2, 3), np.uint8)).levels_off == ()


@given(textures(max_side=9), st.integers(1, 8))
def test_tally_in_parts(texture, cut):
    cut = min(cut, texture.shape[0])
    upper, lower = nt.Tally().add(texture[:cut]), nt.Tally()
    if cut < texture.shape[0]:
        lower.add(texture[cut:])
    merged, whole = upper.merge(lower).stats(), nt.measure(texture)
    assert merged.angles == whole.angles
    assert merged.standard == whole.standard
    assert merged.levels_off == whole.levels_off


def bumps(seed, size=96):
    """A smooth heightfield that tiles."""
    rng = np.random.default_rng(seed)
    spectrum = np.fft.rfft2(rng.standard_normal((size, size)))
    fy, fx = np.meshgrid(np.fft.fftfreq(size), np.fft.rfftfreq(size), indexing="ij")
    height = np.fft.irfft2(spectrum * np.exp(-900 * (fx * fx + fy * fy)), (size, size))
    return ((height - height.min()) / np.ptp(height)).astype(np.float32)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("to_y", ["up", "down"])
def test_orientation(seed, to_y):
    texture = nt.normals_from_height(bumps(seed), scale=15, to_y=to_y, depth=8)
    r, z, loops, _ = oracle_orientation.statistic(texture)
    for threads in (1, 3):
        found = nt.detect_orientation(texture, threads=threads)
        assert found.y == found.likelier == to_y
        assert 0.8 <= found.confidence <= 0.99
        assert found.statistic == pytest.approx(r, abs=1e-9)
        assert found.score == pytest.approx(z, rel=1e-9)
        assert found.loops == loops


def test_orientation_is_undecided_where_flat():
    found = nt.detect_orientation(np.full((32, 32, 3), (128, 128, 255), np.uint8))
    assert (found.y, found.confidence) == ("undecided", 0)


def test_classes(test_files):
    names = {
        "standard.png": "standard",
        "zzero.png": "zzero",
        "labpbr.png": "xy",
        "height_rgb.png": "height",
        "object_space.png": "object-space",
        "one_color.png": "one-color",
        "photograph.png": "not-normals",
    }
    for name, kind in names.items():
        found = nt.classify(nt.read(test_files / name))
        assert found.type == kind, name
        assert found == nt.classify(nt.Tally().add(nt.read(test_files / name)))
        assert 0 <= found.confidence <= 1 and found.reasons
    accidents = nt.classify(nt.read(test_files / "green_blue_swapped.png")).accidents
    assert accidents == ("green-is-z",)


def test_choose_method(test_files):
    assert nt.choose_method(nt.read(test_files / "standard.png")).method == "keep"
    assert nt.choose_method(nt.read(test_files / "standard_z_off.png")).method == "derive"
    assert nt.choose_method(nt.read(test_files / "jpeg.jpg"), lossy=True).method == "normalize"


def test_auto_is_what_the_texels_say(test_files):
    zzero = nt.read(test_files / "zzero.png")
    damaged = zzero.copy()
    damaged[:8, :8, 2] //= 2
    assert np.array_equal(nt.clean(damaged, type="auto"), nt.clean(damaged, type="zzero"))
    assert np.array_equal(nt.heatmap(damaged, type="auto"), nt.heatmap(damaged, type="zzero"))
    with pytest.raises(nt.ArgumentError, match="not-normals"):
        nt.clean(nt.read(test_files / "photograph.png"), type="auto")
    pairs = nt.read(test_files / "standard.png")[..., :2]
    assert nt.classify(pairs).type == "xy"
    assert np.array_equal(nt.clean(pairs, type="auto"), nt.clean(pairs, type="xy"))
    gray_alpha = np.full((*pairs.shape[:2], 2), 255, np.uint8)
    gray_alpha[..., 0] = nt.read(test_files / "height_gray8.png")[: len(pairs), : pairs.shape[1]]
    assert nt.classify(gray_alpha).type == "height"
    with pytest.raises(nt.ArgumentError, match="height"):
        nt.clean(gray_alpha, type="auto")
    lossy = nt.read(test_files / "jpeg.jpg")
    method = nt.choose_method(lossy).method
    assert np.array_equal(nt.clean(lossy, method="auto"), nt.clean(lossy, method=method))


def test_stats_are_plain():
    texture = np.random.default_rng(5).integers(0, 256, (12, 9, 4), np.uint8)
    stats = nt.measure(texture)
    assert set(stats.to_dict()) == {field.name for field in dataclasses.fields(nt.Stats)}
    assert stats == nt.measure(texture) and hash(stats) == hash(nt.measure(texture))
    assert copy.copy(stats) == copy.deepcopy(stats) == dataclasses.replace(stats) == stats
    assert sum(stats.lengths) == stats.texels == 108
    with pytest.raises(AttributeError, match="texel_count"):
        _ = stats.texel_count
    with pytest.raises(dataclasses.FrozenInstanceError):
        stats.texels = 1


def test_edges_of_relief():
    """Maps tile where the texture does, and do not look across the edges of a part of it."""
    y, x = np.mgrid[:96, :96] * (2 * np.pi / 96)
    tile = (np.sin(3 * x + 1) * np.cos(2 * y + 2) * 9 + np.sin(x + y)).astype(np.float32)
    cut = np.ascontiguousarray(tile[:80, 5:75])
    for heights, border, solved in ((tile, "wrap", "wrap"), (cut, "clamp", "extrapolate")):
        normals = nt.normals_from_height(heights, 1, border=solved, depth=16)
        color = np.stack([0 * heights, heights, 0 * heights], -1)
        for make in (nt.curvature, nt.occlusion):
            known = make(heights, border=border)
            assert np.array_equal(make(heights), known)
            green = make(color, type="height", source="green")
            assert np.array_equal(green, known)
            told = {"type": "standard", "y": "up"}
            of_normals = make(normals, **told), make(normals, border=border, **told)
            if make is nt.curvature or border == "clamp":  # it solves heights that wrap
                assert np.array_equal(*of_normals)
            assert make is nt.curvature or abs(of_normals[0] / 65535 - known).max() < 0.02
