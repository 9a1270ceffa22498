# SPDX-License-Identifier: MIT
"""The question about accidents, which all functions ask that make textures; words for green."""

import numpy as np
import pytest

import normaltexture as nt
from support import textures as stock


def accident(name, texture):
    """The texture after one of the accidents of the classifier."""
    if name == "red-blue":
        return texture[..., [2, 1, 0]]
    if name == "green-blue":
        return texture[..., [0, 2, 1]]
    if name == "inverted-blue":
        return texture * [1, 1, 0] + [0, 0, 255] - texture * [0, 0, 1]
    if name == "dxt5nm":
        full = np.full_like(texture[..., 0], 255)
        return np.dstack([full, texture[..., 1], np.zeros_like(full), texture[..., 0]])
    v = texture / 255
    light = np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.maximum(v, 1e-9) ** (1 / 2.4) - 0.055)
    return np.floor(light * 255 + 0.5)


FLAT = np.full((8, 8, 3), (128, 128, 255), np.uint8)
# Every function that takes a texture and makes another of it.
MAKERS = {
    "convert": lambda t, **how: nt.convert(t, depth=16, **how),
    "convert to": lambda t, **how: nt.convert(t, to="zzero", **how),
    "convert to_y": lambda t, **how: nt.convert(t, to_y="down", y="up", **how),
    "resize": lambda t, **how: nt.resize(t, size="50%", **how),
    "mip_chain": lambda t, **how: nt.mip_chain(t, **how)[1],
    "transform": lambda t, **how: nt.transform(t, flip="x", **how),
    "strength": lambda t, **how: nt.transform(t, strength=2, **how),
    "blend over": lambda t, **how: nt.blend(t, FLAT, y="up", detail_type="standard", **how),
    "heights": lambda t, **how: nt.height_from_normals(t, y="up", **how),
}


@pytest.mark.parametrize("name", ["red-blue", "green-blue", "inverted-blue", "dxt5nm", "srgb"])
def test_accidents_are_asked_about_by_all_that_make_textures(name):
    good = stock.standard(64, 80, 3, 1.0)
    if name == "srgb":
        good[:24] = [128, 128, 255]
    stored = accident(name, good).astype(np.uint8)
    for maker, make in MAKERS.items():
        with pytest.raises(nt.ArgumentError, match="clean with undo=True puts that right"):
            make(stored)
        assert make(stored, type="standard") is not None, maker
        make(nt.clean(stored, undo=True))
    with pytest.raises(nt.ArgumentError, match='^detail_type="auto": of detail '):
        nt.blend(FLAT, stored, type="standard", detail_type="auto")
    if name not in ("dxt5nm", "inverted-blue"):  # no question where channels are named
        nt.convert(stored, from_channels="zyx")


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
@pytest.mark.parametrize("kind", ["photograph", "heights"])
def test_what_is_no_normals_texture_is_refused(make, kind):
    picture = {"photograph": stock.photograph(), "heights": stock.heights()}[kind]
    picture = picture if picture.ndim == 3 else np.dstack([picture] * 3)
    if make is MAKERS["convert"] and kind == "heights":  # whose depth it changes, as ntp convert
        assert np.array_equal(make(picture), nt.convert(picture, type="height", depth=16))
        return
    with pytest.raises(nt.ArgumentError, match="not like a normals texture"):
        make(picture)


def test_normals_are_no_heights():
    good = stock.standard(64, 80, 3, 1.0)
    for function in (nt.normals_from_height, nt.normals_from_height_with_counts):
        with pytest.raises(nt.ArgumentError, match='it holds normals already .* source="red"'):
            function(good, 4)
        function(good, 4, source="red")
        function(good[..., 0], 4)
    rgb = np.dstack([stock.heights()] * 3) if stock.heights().ndim == 2 else stock.heights()
    assert np.array_equal(
        nt.normals_from_height(rgb, 4), nt.normals_from_height(rgb, 4, source="red")
    )


def test_green_has_both_words_everywhere():
    good = stock.standard(32, 40, 3, 1.0)
    vectors = nt.decode(good)
    for word, same in (("opengl", "up"), ("directx", "down")):
        calls = [
            lambda y: nt.decode(good, y=y),
            lambda y: nt.encode(vectors, to_y=y),
            lambda y: nt.normals_from_height(good[..., 0], 4, to_y=y),
            lambda y: nt.shade(good, y=y),
            lambda y: nt.compare(good, good, y=y).to_dict()["angles"],
            lambda y: nt.compare(good, good, y=(y, "up")).to_dict()["angles"],
            lambda y: nt.find_kernel(good, y=y).kernel,
            lambda y: nt.convert(good, y=y, to_y="up"),
            lambda y: nt.height_from_normals(good, y=y),
        ]
        for call in calls:
            assert np.array_equal(call(word), call(same))
    for wrong in ("auto", "left", None):
        with pytest.raises(nt.ArgumentError, match="^y"):
            nt.decode(good, y=wrong)
