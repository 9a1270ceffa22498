# SPDX-License-Identifier: MIT
"""Depth of objects: what Python adds to the library, whose own tests say how good it is."""

import dataclasses
import inspect

import numpy as np
import pytest

import normaltexture as nt

CAMERA = (50.0, 60.0, 20.0, 15.0)


@pytest.fixture
def ball():
    """Normals of half a ball, and where it is."""
    v, u = np.mgrid[:33, :40] - 16.0
    mask = u * u + v * v < 14 * 14
    z = np.sqrt(np.where(mask, 15 * 15 - u * u - v * v, 0))
    return np.stack([u / 15, -v / 15, z / 15], -1), mask


def test_every_way_to_say_it(ball):
    normals, mask = ball
    depth = nt.depth_from_normals(normals, mask)
    assert depth.dtype == np.float32 and (np.isnan(depth) == ~mask).all()
    v, u = np.mgrid[:33, :40] - 16.0
    true = -np.sqrt(225 - (u * u + v * v)[mask])
    assert np.abs(depth[mask] - true - np.mean(depth[mask] - true)).mean() < 0.1
    flipped = normals * [1, -1, 1]
    other = nt.depth_from_normals(flipped, mask, y="directx")
    assert np.nanmax(np.abs(other - depth)) < 0.01  # levels round half up
    out = np.zeros_like(depth)
    assert nt.depth_from_normals(normals.astype(np.float32), mask * np.uint8(255), out=out) is out
    levels = np.floor((normals + 1) / 2 * 65535 + 0.5).astype(np.uint16)
    near = nt.depth_from_normals(levels, mask.astype(np.uint16))
    assert np.nanmax(np.abs(near - depth)) < 0.05


def test_confidence_and_camera(ball):
    normals, mask = ball
    depth, confidence = nt.depth_from_normals_with_confidence(normals, mask, CAMERA)
    assert (nt.depth_from_normals(normals, mask, CAMERA)[mask] == depth[mask]).all()
    assert (depth[mask] > 0).all() and abs(np.log(depth[mask]).mean()) < 1e-5
    assert (confidence[~mask] == 0).all() and (confidence[mask] > 0).all()
    again = nt.depth_from_normals(normals, mask, CAMERA, start=depth)
    assert np.nanmax(np.abs(again / depth - 1)) < 0.02


def test_what_is_not_known_is_asked():
    """As by `ntp to-depth`: what is sure holds, up is the convention, down is asked about."""
    y, x = np.mgrid[:64, :64] / 64 * 2 * np.pi
    slopes = np.dstack([0.5 * np.sin(2 * x) * np.cos(y), 0.5 * np.cos(2 * y), np.ones_like(x)])
    normals = slopes / np.linalg.norm(slopes, axis=2)[..., None]
    levels = np.floor((normals + 1) / 2 * 255 + 0.5).astype(np.uint8)
    for exchanged in (levels[..., ::-1], levels[..., [0, 2, 1]]):
        with pytest.raises(nt.ArgumentError, match="normals .* exchanged"):
            nt.depth_from_normals(exchanged)
        nt.depth_from_normals(exchanged, type="standard", y="up", rounds=1)
    photo = np.linspace(0, 255, 64 * 64 * 3).reshape(64, 64, 3).astype(np.uint8)
    photo[..., 1] //= 2
    with pytest.raises(nt.ArgumentError, match="normals looks like"):
        nt.depth_from_normals(photo)


def test_green_down_is_used_or_asked_about(monkeypatch):
    y, x = np.mgrid[:96, :96] / 96 * 2 * np.pi
    q, p = np.gradient(8 * (np.sin(5 * x + 3 * y) + np.sin(4 * y - 2 * x)))
    up = np.dstack([-p, q, np.ones_like(p)]) / np.sqrt(1 + p * p + q * q)[..., None]
    depth, down = nt.depth_from_normals(up), up * [1, -1, 1]
    assert np.abs(nt.depth_from_normals(down) - depth).max() < 0.01
    sure = nt.detect_orientation(down, type="vector")
    weak = {"down": ("down", 0.8), "up": ("up", 0.8), "undecided": ("undecided", 0.0)}
    for word, (y, confidence) in weak.items():
        found = dataclasses.replace(sure, y=y, confidence=confidence)
        monkeypatch.setattr("normaltexture._green.detect_orientation", lambda *a, f=found, **k: f)
        if word == "down":
            with pytest.raises(nt.ArgumentError, match='80 % sure; which is it, y="up" .OpenGL.'):
                nt.depth_from_normals(up)
        else:
            assert np.array_equal(nt.depth_from_normals(up), depth)


def test_both_take_the_same_arguments():
    plain, more = map(
        inspect.signature, (nt.depth_from_normals, nt.depth_from_normals_with_confidence)
    )
    assert plain.parameters == more.parameters


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("camera", (1, 2, 3)),
        ("camera", (0, 1, 2, 3)),
        ("camera", (1, np.nan, 2, 3)),
        ("k", 0),
        ("rounds", 0),
        ("mask", np.zeros((3, 3), bool)),
        ("start", np.zeros((3, 3), np.float32)),
        ("y", "left"),
        ("type", "height"),
    ],
)
def test_wrong_values_are_named(ball, argument, value):
    with pytest.raises(nt.ArgumentError, match=argument):
        nt.depth_from_normals(ball[0], **{argument: value})


def test_progress(ball):
    told = []
    nt.depth_from_normals_with_confidence(ball[0], progress=told.append)
    assert told == sorted(told) and 0 <= told[0] and told[-1] <= 1
    with pytest.raises(nt.CancelledError):
        nt.depth_from_normals(ball[0], progress=lambda share: False)
