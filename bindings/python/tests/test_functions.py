# SPDX-License-Identifier: MIT
"""Each function that makes a picture, against oracles that are written apart from the C code."""

import math

import hypothesis
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import normaltexture as nt
from pysupport.drawn import ENCODINGS, max_of, textures, types, ups
from support import oracle, oracle_convert
from support import oracle_pictures as pictures
from support.oracle_blend import blend_by_model
from support.oracle_resize import resize_by_model
from support.oracle_transform import moved_picture, turned, unused_mask


def blue_of(texture):
    """Blue, and what stands for it where there are two channels: M, or 0 of black texels."""
    if texture.shape[2] > 2:
        return texture[..., 2]
    return np.where(texture.any(-1), max_of(texture), 0)


@given(textures(), st.sampled_from(["standard", "zzero"]), st.booleans())
def test_validate(texture, type, keep):
    m = max_of(texture)
    want = oracle.flags(*np.moveaxis(texture[..., :3], 2, 0), m, type == "zzero", keep)
    got = nt.validate(texture, type=type, keep_negative_z=keep)
    assert np.array_equal(got & ~np.uint8(nt.Flag.UNUSED), want)
    assert np.array_equal(got & nt.Flag.UNUSED > 0, oracle.unused(texture, m))


@given(textures(channels=(2, 3, 4)))
def test_validate_xy(texture):
    over = oracle.radicands(texture[..., 0], texture[..., 1], max_of(texture)) < 0
    got = nt.validate(texture, type="xy")
    assert np.array_equal(got & nt.Flag.XY_TOO_LONG > 0, over)
    for flag in (nt.Flag.NEIGHBOR, nt.Flag.ROUNDED, nt.Flag.EXACT):
        assert np.array_equal(got & flag > 0, ~over)


@given(
    textures(),
    types,
    st.sampled_from(["derive", "normalize"]),
    st.sampled_from([None, "neighbor", "rounded", "exact"]),
    st.booleans(),
    st.booleans(),
)
def test_clean(texture, type, method, only_failing, keep, touch):
    m = max_of(texture)
    want = texture.copy()
    zz = type == "zzero"
    for texel, row in zip(want.reshape(-1, want.shape[2]), texture.reshape(-1, want.shape[2])):
        r, g, b = (int(c) for c in row[:3])
        if oracle_convert.is_unused(tuple(row.tolist()), m) and not touch:
            continue
        if type == "xy":
            if not (only_failing and oracle.radicand(r, g, m) >= 0):
                texel[:2] = oracle.pull(r, g, m)
            continue
        if only_failing:
            either = {"either_sign": keep} if only_failing == "exact" else {}
            passes = getattr(oracle, only_failing)(r, g, b, m, zz, **either)
            if passes and (keep or not oracle.z_negative(b, m, zz)):
                continue
        texel[:3] = oracle.cleaned(r, g, b, m, zz, method, keep)
    how = {"type": type, "method": method, "keep_negative_z": keep, "touch_unused": touch}
    if only_failing:
        how |= {"only_failing": True, "verdict": only_failing}
    if type == "xy" and method == "normalize":
        how["method"] = "derive"
    got, counts = nt.clean_with_counts(texture, **how)
    assert np.array_equal(nt.clean(texture, **how), got)
    assert np.array_equal(got, want)
    assert counts.changed == np.count_nonzero((got != texture).any(-1))
    assert np.array_equal(nt.clean(got, **how), got)  # once is enough


@given(
    textures(channels=(2, 3, 4)),
    types,
    types,
    ups,
    ups,
    st.sampled_from([None, 8, 16]),
    st.booleans(),
)
def test_convert(texture, from_, to, from_y, to_y, depth, touch):
    if texture.shape[2] == 2 and from_ != "xy":
        from_ = "xy"
    m = max_of(texture)
    target = {8: 255, 16: 65535, None: m}[depth]
    got, counts = nt.convert_with_counts(
        texture,
        type=from_,
        to=to,
        y=from_y,
        to_y=to_y,
        depth=depth,
        touch_unused=touch,
    )
    negative = pulled = 0
    for texel, row in zip(got.reshape(-1, got.shape[2]), texture.reshape(-1, texture.shape[2])):
        want, z, p = oracle_convert.convert(
            tuple(row.tolist()), m, ENCODINGS[from_], target, ENCODINGS[to], len(texel),
            from_y != to_y, touch,
        )  # fmt: skip
        assert tuple(texel.tolist()) == want
        negative, pulled = negative + z, pulled + p
    assert counts.z_negative == negative
    assert counts.pulled == pulled


@given(textures(), st.sampled_from(["standard", "zzero"]), ups)
def test_decode(texture, from_, from_y):
    m = max_of(texture)
    v = (2 * texture[..., :3].astype(np.int64) - m) / m
    if from_ == "zzero":
        v[..., 2] = texture[..., 2] / m
    v[..., 1] *= -1 if from_y == "down" else 1
    assert np.array_equal(nt.decode(texture, type=from_, y=from_y), v.astype(np.float32))


@given(textures())
def test_decode_xy(texture):
    """Pulled where too long; z is the nearest float of the root."""
    m = max_of(texture)
    r, g = oracle.pulled(texture[..., 0], texture[..., 1], m)
    z = np.sqrt(oracle.radicands(r, g, m)) / m
    v = np.stack([(2 * r - m) / m, (2 * g - m) / m, z], -1)
    assert np.array_equal(nt.decode(texture, type="xy"), v.astype(np.float32))


components = st.floats(-4, 4, width=32) | st.sampled_from([0.0, 1.0, -1.0, math.nan, math.inf])


@given(
    st.lists(st.tuples(components, components, components), min_size=1, max_size=6),
    types,
    ups,
    st.sampled_from([8, 16]),
    st.sampled_from(["derived", "nearest"]),
)
def test_encode(vectors, to, to_y, depth, blue):
    m = 255 if depth == 8 else 65535
    array = np.array(vectors, np.float32)[None]
    got = nt.encode(array, to=to, to_y=to_y, depth=depth, blue=blue)
    nearest = blue == "nearest"
    flat = oracle_convert.from_vector((0.0, 0.0, 1.0), m, ENCODINGS[to], False, nearest)
    for texel, v in zip(got[0].tolist(), array[0].tolist()):
        want = oracle_convert.from_vector(v, m, ENCODINGS[to], to_y == "down", nearest)
        assert tuple(texel) == (want or flat)


@given(textures(max_side=5))
def test_decode_and_encode_are_inverse_where_clean(texture):
    clean = nt.clean(texture, type="standard", method="derive", touch_unused=True)
    depth = 8 if texture.dtype == np.uint8 else 16
    again = nt.encode(nt.decode(clean), depth=depth)
    assert np.array_equal(again, clean[..., :3])


@given(textures(max_side=5))
def test_touched_texels_are_repaired_by_the_default_method(texture):
    flags = nt.validate(nt.clean(texture, type="standard", touch_unused=True), type="standard")
    assert np.all(flags & nt.Flag.ROUNDED)


@given(textures(), types, st.sampled_from(["reference", "safe"]), st.booleans())
def test_heatmap(texture, type, palette, touch):
    want = pictures.expected_heatmap(
        texture, max_of(texture), ENCODINGS[type], ["reference", "safe"].index(palette), 7 * touch
    )
    got = nt.heatmap(texture, type=type, palette=palette, touch_unused=touch)
    assert np.array_equal(got, want)


@given(textures(), types, ups)
def test_shade(texture, type, y):
    m = max_of(texture)
    light = nt.Light(direction=(0.3, -2.0, 0.1), ambient=0.05, diffuse=1.0, specular=0.7)
    for asked, model in (
        (None, pictures.DEFAULT_LIGHT),
        (light, ([0.3, -2.0, 0.1], 0.05, 1.0, 0.7, [0.6] * 3)),
    ):
        how = {} if asked is None else {"light": asked}
        want = pictures.expected_shade(texture, m, ENCODINGS[type], model, y == "down")
        assert np.array_equal(nt.shade(texture, type=type, y=y, **how), want)
    gray = np.zeros(texture.shape[:2], np.uint8)
    want = pictures.expected_shade(texture, m, ENCODINGS[type], down=y == "down", channels=1)
    assert np.array_equal(nt.shade(texture, type=type, y=y, out=gray), want[..., 0])


@given(textures(channels=(3,)), st.integers(0, 1 << 30), types, ups)
def test_compare(texture, seed, type, b_y):
    m = max_of(texture)
    other = pictures.nearly(texture.astype(np.int64), m, seed).astype(texture.dtype)
    heat = np.zeros((*texture.shape[:2], 3), np.uint8)
    got = nt.compare(texture, other, type=type, y=("up", b_y), out_heat=heat)
    code = ENCODINGS[type]
    off, degrees, channels = pictures.expected_compare(
        texture, other, (m, m), (code, code), b_y == "down"
    )
    assert (got.texels, got.max) == (degrees.size, m)
    assert got.different == np.count_nonzero(off.any(-1))
    assert list(got.levels_max) == off.reshape(-1, channels).max(0).tolist()
    assert got.levels_mean == pytest.approx(off.reshape(-1, channels).mean(0))
    assert got.angles.max == pytest.approx(degrees.max(), abs=1e-6)
    assert np.array_equal(heat, pictures.expected_heat(degrees, ~off.any(-1)))


@hypothesis.settings(max_examples=40)
@given(
    textures(max_side=4),
    types,
    st.integers(1, 6),
    st.integers(1, 6),
    st.sampled_from(["box", "triangle"]),
    st.sampled_from(["wrap", "clamp", "mirror"]),
    st.sampled_from(["wrap", "clamp", "mirror"]),
)
def test_resize(texture, type, width, height, filter, border_x, border_y):
    borders = tuple(["wrap", "clamp", "mirror"].index(b) for b in (border_x, border_y))
    want = resize_by_model(
        texture.tolist(), max_of(texture), (width, height), {"triangle": 0, "box": 1}[filter],
        borders, type,
    )  # fmt: skip
    got = nt.resize(
        texture, size=(width, height), type=type, filter=filter, border_x=border_x,
        border_y=border_y,
    )  # fmt: skip
    assert got.tolist() == [[texel for texel, _ in row] for row in want]


def test_sizes_and_mip_chain(test_files):
    texture = nt.read(test_files / "standard.png")
    h, w = texture.shape[:2]
    assert nt.resize(texture, size="50%").shape[:2] == (h // 2, w // 2)
    assert nt.resize(texture, size="10x7").shape[:2] == (7, 10)
    assert np.array_equal(nt.resize(texture, size=(10, 7)), nt.resize(texture, size="10x7"))
    chain = nt.mip_chain(texture)
    assert np.array_equal(chain[0], texture) and chain[-1].shape[:2] == (1, 1)
    assert np.array_equal(chain[2], nt.resize(texture, size=(w // 4, h // 4), filter="box"))
    assert all((nt.validate(level) & nt.Flag.EXACT > 0).all() for level in chain)


@given(
    textures(),
    types,
    ups,
    st.sampled_from([None, "x", "y", "xy"]),
    st.sampled_from([0, 90, 180, 270]),
)
def test_transform_moves(texture, type, y, flip, rotate):
    m = max_of(texture)
    flips, turns = ("x" in (flip or ""), "y" in (flip or "")), rotate // 90
    want = moved_picture(texture, flips, turns).astype(np.int64)
    used = ~unused_mask(want, m)
    vx, vy = turned(2 * want[..., 0] - m, 2 * want[..., 1] - m, flips, turns, int(y == "down"))
    want[..., 0][used] = ((vx + m) // 2)[used]
    want[..., 1][used] = ((vy + m) // 2)[used]
    got = nt.transform(texture, type=type, y=y, flip=flip, rotate=rotate)
    assert np.array_equal(got, want)


@hypothesis.settings(max_examples=60)
@given(
    textures(max_side=5),
    textures(max_side=4, channels=(3,)),
    types,
    types,
    ups,
    ups,
    st.sampled_from(["rnm", "whiteout", "udn", "linear"]),
    st.sampled_from([1.0, 0.5, 0.1, -0.7, 3.0, 0.0]),
    st.booleans(),
)
def test_blend(base, detail, type, detail_type, y, detail_y, mode, strength, touch):
    want = blend_by_model(
        base, detail, ["rnm", "whiteout", "udn", "linear"].index(mode), strength,
        (ENCODINGS[type], ENCODINGS[detail_type]), (y, detail_y), (max_of(base), max_of(detail)),
        7 if touch else 0,
    )  # fmt: skip
    got = nt.blend(
        base, detail, type=type, detail_type=detail_type, y=y, detail_y=detail_y, mode=mode,
        strength=strength, touch_unused=touch,
    )  # fmt: skip
    assert np.array_equal(got, want)
