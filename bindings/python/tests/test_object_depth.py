# SPDX-License-Identifier: MIT
"""Depth of objects: what Python adds to the library, whose own tests say how good it is."""

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
        ("y", "auto"),
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
