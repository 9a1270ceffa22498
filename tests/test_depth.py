# SPDX-License-Identifier: MIT
"""Depth of objects from normals: cliffs, cameras, holes, and what is no normal."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "bench"))

import cliff_objects
from support import cliff_scenes as scenes
from support import libntp_ffi as ntp
from support.depth import (
    by_shares,
    equations,
    find_depth,
    shares_of,
    trust_of,
    wanted_of_means,
)

SIZE = 80
CAMERA = (60.0, 70.0, 5.0, 4.0)


def vectors(scene):
    return np.where(scene.mask[..., None], scene.normals, 0).astype(np.float32)


def stored(normals, dtype):
    m = np.iinfo(dtype).max
    return np.floor((np.asarray(normals, float) + 1) / 2 * m + 0.5).astype(dtype)


@pytest.fixture(scope="module")
def found():
    """Scenes with least squares, depth and confidence."""
    makers = [
        lambda: scenes.spheres(SIZE, 0, False),
        lambda: scenes.spheres(SIZE, 60, True),
        lambda: scenes.spiral(SIZE, 0),
        lambda: scenes.spiral(SIZE, 30),
        lambda: scenes.boxes(SIZE, 30),
        lambda: scenes.cloth(SIZE, 90),
    ]
    out = []
    for make in makers:
        scene = make()
        plain = find_depth(vectors(scene), camera=scene.camera, rounds=1)[0]
        out.append((scene, plain, *find_depth(vectors(scene), camera=scene.camera)))
    return out


def test_error_is_at_most_a_third_of_least_squares(found):
    for scene, plain, depth, _, result in found:
        error = scenes.error(depth, scene, scene.pieces)
        assert error <= scenes.error(plain, scene, scene.pieces) / 3, scene.name
        assert result["islands"] == 1


@pytest.mark.parametrize("degrees", [0, 45])
def test_a_cliff_that_least_squares_hides(degrees):
    """Differences of depth alone do not show it: bends of the normals do."""
    for scene in (scenes.steps(128, degrees), scenes.spiral(128, degrees)):
        plain = find_depth(vectors(scene), camera=scene.camera, rounds=1, sure=False)[0]
        depth = find_depth(vectors(scene), camera=scene.camera, sure=False)[0]
        assert scenes.error(depth, scene) <= scenes.error(plain, scene) / 8, scene.name


def test_the_cliff_of_a_wide_view_is_found():
    """Least squares spread it so widely that differences of slopes hardly show it."""
    scene = scenes.spiral(128, 75)
    plain = find_depth(vectors(scene), camera=scene.camera, rounds=1, sure=False)[0]
    depth = find_depth(vectors(scene), camera=scene.camera, sure=False)[0]
    assert scenes.error(depth, scene, scene.pieces) <= scenes.error(plain, scene, scene.pieces) / 3


@pytest.mark.parametrize(("seed", "degrees"), [(2, 30), (4, 0), (6, 45)])
def test_where_bends_abound_they_tell_no_cliff(seed, degrees):
    """The inside of a goblet hangs by the ends of its rim, among bends."""
    scene = cliff_objects.goblet(96, degrees, seed)
    plain = find_depth(vectors(scene), camera=scene.camera, rounds=1, sure=False)[0]
    depth = find_depth(vectors(scene), camera=scene.camera, sure=False)[0]
    limit = scenes.error(plain, scene, scene.pieces) / 10
    assert scenes.error(depth, scene, scene.pieces) <= limit


@pytest.mark.parametrize(("seed", "degrees"), [(2, 30), (6, 45)])
def test_what_moves_slowly_arrives(seed, degrees):
    """The inside of a goblet hangs by so little that without momentum a hundred rounds are needed."""
    scene = cliff_objects.goblet(128, degrees, seed)
    plain = find_depth(vectors(scene), camera=scene.camera, rounds=1, sure=False)[0]
    depth = find_depth(vectors(scene), camera=scene.camera, sure=False)[0]
    limit = scenes.error(plain, scene, scene.pieces) / 40
    assert scenes.error(depth, scene, scene.pieces) <= limit


def test_in_the_end_what_is_off_a_little_is_off():
    """With the trust of the first part alone they are off by 0.24 to 0.32 texels."""
    for degrees in (0, 45):
        scene = scenes.steps(128, degrees)
        depth = find_depth(vectors(scene), camera=scene.camera, sure=False)[0]
        assert scenes.error(depth, scene) <= 0.12


@pytest.mark.parametrize(
    "make",
    [
        lambda: scenes.spheres(128, 60, False),
        lambda: scenes.cloth(80, 90),
        lambda: scenes.cloth(128, 0),
        lambda: cliff_objects.knot(96, 0, 1),
    ],
)
def test_doubt_is_measured_from_where_most_texels_are(make):
    """Measured from means it is that of the mean itself: the area under the curve falls to 0.1."""
    scene = make()
    depth, confidence, _ = find_depth(vectors(scene), camera=scene.camera)
    errors = np.abs(scenes.aligned(depth, scene) - scene.depth)[scene.mask]
    assert scenes.ranks(confidence[scene.mask], errors) >= 0.72


def test_confidence_ranks_the_errors(found):
    ranks = []
    for scene, _, depth, confidence, _ in found:
        errors = np.abs(scenes.aligned(depth, scene) - scene.depth)[scene.mask]
        ranks.append(scenes.ranks(confidence[scene.mask], errors))
        assert (confidence[scene.mask] > 0).all() and confidence.max() <= 1
        assert (confidence[~scene.mask] == 0).all()
    assert np.mean(ranks) >= 0.8, ranks


@pytest.mark.parametrize(
    ("size", "degrees", "least"),
    [
        (64, 60, 0.85),
        (64, 90, 0.95),
        (136, 60, 0.95),
        (192, 90, 0.65),
        (256, 60, 0.95),
        (256, 90, 0.95),
    ],
)
def test_confidence_knows_what_is_far_and_what_is_cut_off(size, degrees, least):
    """Balls in the air, and a plane whose far end is off by more texels than its near end.  The plane
    has less than half of the texels, so one shift fits a ball.  Where the plane is taken for the middle, the
    area under the curve is 0.76 at 136 and 0.24 at 192."""
    scene = scenes.spheres(size, degrees, True)
    depth, confidence, _ = find_depth(vectors(scene), camera=scene.camera)
    errors = np.abs(scenes.aligned(depth, scene) - scene.depth)[scene.mask]
    assert scenes.ranks(confidence[scene.mask], errors) >= least


def test_no_doubt_is_above_half_the_spread_of_depth():
    """What hangs by nothing moves by any amount; it is still a part of the object."""
    scene = scenes.spheres(64, 0, True)
    depth, confidence, _ = find_depth(vectors(scene))
    doubt = 1 / confidence[scene.mask].astype(float) - 1
    most = np.std(depth[scene.mask].astype(float)) / 2
    assert 0.9 * most < doubt.max() <= most * (1 + 1e-6)


def test_iterations_do_not_grow_where_parts_are_cut_off():
    """One step alone on each coarser level takes 17 iterations a round here."""
    scene = scenes.spheres(256, 60, True)
    result = find_depth(vectors(scene), camera=scene.camera, sure=False)[2]
    assert result["iterations"] <= 6 * result["rounds"]


def test_8_bits_are_nearly_as_good(found):
    scene, plain, *_ = found[0]
    depth = find_depth(stored(scene.normals, np.uint8), ntp.STANDARD)[0]
    assert scenes.error(depth, scene) <= scenes.error(plain, scene) / 3


def some_normals(h, w, seed=3):
    normals = np.random.default_rng(seed).normal(size=(h, w, 3)) * 0.4 + [0, 0, 1.5]
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return (np.rint(normals * 65535) / 65535).astype(np.float32)


@pytest.mark.parametrize("camera", [None, CAMERA])
def test_one_round_is_least_squares(camera):
    normals = some_normals(9, 12)
    blocks, wanted = equations(normals, camera)
    half = np.full(9 * 12, 0.5)
    want = by_shares(blocks, wanted, [half, half])
    depth, _, result = find_depth(normals, camera=camera, rounds=1)
    got = np.log(depth) if camera else depth
    # 16-bit normals, and the springs of at least a millionth.
    assert np.abs(got.ravel() - want).max() <= 3e-4 * np.abs(want).max()
    assert result["rounds"] == 1


@pytest.mark.parametrize("camera", [None, (24.0, 24.0, 7.5, 7.5)])
def test_shares_are_those_of_the_depth(camera):
    """Where the rounds end, the next round by the formulas changes next to nothing."""
    scene = scenes.spheres(16, 0, False)
    blocks, wanted = equations(scene.normals, camera)
    depth = find_depth(vectors(scene), camera=camera)[0].astype(float)
    z = (np.log(depth) if camera else depth).ravel()
    focal = camera[0] if camera else 1
    means = wanted_of_means(blocks, wanted, 16, focal)
    again = z
    for _ in range(2):
        trust = trust_of(blocks, wanted, scene.normals, again, focal)
        again = by_shares(blocks, means, shares_of(blocks, again, 2), trust)
    assert np.abs(again - z).mean() <= 0.01 * (z.max() - z.min())


@pytest.mark.parametrize("turn", [0, 1])
def test_a_fold_between_two_texels_has_half_of_each_slope(turn):
    """A roof whose ridge lies in the middle between two rows of texels, one side of it steep."""
    normals = np.zeros((24, 24, 3), np.float32)
    gentle, steep = 0.25, 4.0
    normals[:12] = np.float32([0, -gentle, 1]) / np.float32(np.hypot(gentle, 1))
    normals[12:] = np.float32([0, -steep, 1]) / np.float32(np.hypot(steep, 1))
    want = np.where(np.arange(24) < 12, gentle, steep)
    if turn:
        normals = np.ascontiguousarray(
            normals.swapaxes(0, 1)[..., [1, 0, 2]] * np.float32([-1, 1, 1])
        )
    depth = find_depth(normals, sure=False)[0]
    found = depth.T if turn else depth
    assert np.allclose(np.diff(found, axis=0), (want[1:] + want[:-1])[:, None] / 2, atol=0.02)


@pytest.mark.parametrize("y", [ntp.UP, ntp.DOWN])
def test_plane_in_perspective(y):
    """From Z = 1 / (1 + a u + b v): any camera, to the last digits of floats."""
    v, u = np.mgrid[:40, :50].astype(float)
    fx, fy, cx, cy = CAMERA
    plane = np.array([0.3, -0.2, -1.0])  # x right, y down, z away
    depth = 1 / (plane @ np.stack([(u - cx) / fx, (v - cy) / fy, 1 + 0 * u], -1)[..., None])[..., 0]
    normal = plane * [1, -1, -1] / np.linalg.norm(plane)
    normals = np.broadcast_to(normal, (40, 50, 3)).astype(np.float32)
    if y == ntp.DOWN:
        normals = normals * np.float32([1, -1, 1])
    got = find_depth(np.ascontiguousarray(normals), y=y, camera=CAMERA)[0]
    ratio = got / -depth
    assert ratio.max() / ratio.min() < 1.002  # differences of logarithms are no derivatives


def test_islands_holes_and_what_is_no_normal():
    normals = np.tile(np.float32([0.1, 0, 0.995]), (12, 20, 1))
    normals[:, 9] = 0
    normals[3, 4] = np.nan
    normals[5, 6] = np.inf
    mask = np.full((12, 20), 255, np.uint8)
    mask[8:, :3] = 0
    depth, confidence, result = find_depth(normals, mask=mask)
    hole = mask == 0
    hole[:, 9] = hole[3, 4] = hole[5, 6] = True
    assert (np.isnan(depth) == hole).all()
    assert (confidence[hole] == 0).all()
    assert result["holes"] == hole.sum()
    assert result["not_finite"] == 14  # a vector of length 0 is none either
    assert result["islands"] == 2
    left, right = depth[:, :9], depth[:, 10:]
    assert abs(np.nanmean(left)) < 1e-5 and abs(right.mean()) < 1e-5
    assert np.allclose(np.diff(right), 0.1 / 0.995, atol=1e-3)
    assert result["min"] == np.nanmin(depth) and result["max"] == np.nanmax(depth)


def test_gray_and_transparent_backgrounds_are_holes():
    normals = np.zeros((6, 8, 4), np.uint8)
    normals[...] = (128, 128, 255, 255)
    normals[:, :2, :3] = 128
    normals[:, 2, 3] = 0
    result = find_depth(normals, ntp.STANDARD)[2]
    assert result["holes"] == 18
    kept = find_depth(normals, ntp.STANDARD, touch_unused=ntp.UNUSED_TRANSPARENT)[2]
    assert kept["holes"] == 12


def test_nothing_and_next_to_nothing():
    for shape in ((1, 1), (1, 7), (7, 1), (2, 2)):
        flat = np.zeros((*shape, 3), np.float32)
        depth, confidence, result = find_depth(flat)
        assert np.isnan(depth).all() and (confidence == 0).all()
        assert (result["islands"], result["min"], result["max"]) == (0, 0, 0)
        flat[..., 2] = 1
        for camera, value in ((None, 0), (CAMERA, 1)):
            depth, confidence, result = find_depth(flat, camera=camera)
            assert np.allclose(depth, value, atol=0.05) and np.isfinite(confidence).all()
            assert result["islands"] == 1


def test_grazing_and_turned_away():
    """Such texels are held by their neighbors; slopes stay below 500."""
    normals = np.tile(np.float32([0, 0, 1]), (20, 20, 1))
    normals[5:9, 5:9] = (1, 0, 1e-5)
    normals[12:15, 4:9] = (0, 0.6, -0.8)
    for camera in (None, (30.0, 30.0, 9.5, 9.5)):
        depth, confidence, result = find_depth(normals, camera=camera)
        assert np.isfinite(depth).all() and np.isfinite(confidence).all()
        assert result["turned_away"] >= 15
        z = depth if camera is None else 30 * np.log(depth)
        assert np.abs(np.diff(z)).max() < 520


def test_extreme_cameras():
    normals = some_normals(9, 12)
    for camera in ((2.0**-10, 2.0**20, 2.0**20, -(2.0**20)), (2.0**20, 2.0**-10, 0.0, 2.0**20)):
        depth, confidence, _ = find_depth(normals, camera=camera)
        assert np.isfinite(depth).all() and (depth > 0).all()
        assert np.isfinite(confidence).all() and confidence.min() >= 0 and confidence.max() <= 1


def test_start_saves_rounds(found):
    scene, _, depth, _, result = found[2]
    again, _, warm = find_depth(vectors(scene), start=depth)
    assert warm["rounds"] < result["rounds"]
    assert scenes.error(again, scene) <= 1.1 * scenes.error(depth, scene)
    start = depth.copy()
    start[::3] = np.nan
    assert np.isfinite(find_depth(vectors(scene), start=start)[0]).all()


def test_hooks_and_errors():
    normals = some_normals(9, 12)
    depth = np.full((9, 12), 7, np.float32)
    mask = np.full((9, 12), 1, np.uint8)
    size = ntp.lib.ntp_depth_scratch_size(12, 9)
    memory = ntp.aligned(size, 64)
    where = ntp.ffi.cast("void *", memory.__array_interface__["data"][0])
    shares = []

    def run(dst=depth, mask=mask, size=size, stop=99, confidence=None, **how):
        @ntp.ffi.callback("int32_t(void *, double)")
        def progress(_user, share):
            shares.append(share)
            return len(shares) > stop

        hooks = ntp.ffi.new("ntp_hooks *", {"progress": progress})
        seen = ntp.view(mask, ntp.HEIGHT, const=True)
        return ntp.lib.ntp_depth_from_normals(
            ntp.view(dst, ntp.HEIGHT),
            ntp.ffi.NULL if confidence is None else ntp.view(confidence, ntp.HEIGHT),
            ntp.view(normals, ntp.VECTOR, const=True),
            ntp.ffi.new("ntp_depth_options *", {"mask": seen, **how}),
            where,
            size,
            hooks,
            ntp.ffi.NULL,
        )

    assert run(stop=2) == ntp.ERR_CANCELLED
    assert (depth == 7).all()
    assert run(confidence=np.zeros((9, 12), np.float32)) == ntp.OK
    assert shares[3:] == sorted(shares[3:]) and 0 <= shares[3] and shares[-1] <= 1
    assert run(size=size - 1) == ntp.ERR_SCRATCH
    assert run(dst=np.zeros((9, 11), np.float32)) == ntp.ERR_SHAPE
    assert run(dst=np.zeros((9, 12), np.uint8)) == ntp.ERR_FORMAT
    assert run(mask=np.zeros((9, 11), np.uint8)) == ntp.ERR_SHAPE
    assert run(mask=np.zeros((9, 12), np.float32)) == ntp.ERR_FORMAT
    for bad in ({"fx": 5.0}, {"fx": -1.0, "fy": 1.0}, {"fx": np.nan, "fy": 1.0}, {"cx": np.inf}):
        assert run(camera=bad) == ntp.ERR_ARGUMENT
    for bad in ({"k": -1.0}, {"k": np.nan}, {"rounds": -1}, {"touch_unused": 8}):
        assert run(**bad) == ntp.ERR_ARGUMENT
    assert ntp.lib.ntp_depth_scratch_size(0, 5) == 0
    assert ntp.lib.ntp_depth_scratch_size(65535, 65535) == 0
