# SPDX-License-Identifier: MIT
"""ntp_transform by angles between quarter turns: against fractions, and as a person sees it."""

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle_rotate
from support.texels import NAMES, noise

ANGLES = [45.0, 30.0, -17.3, 359.999, 181.0, 90.000001, 1e-6]


def rotate(src, angle, encoding=ntp.STANDARD, y=ntp.UP, flips=(0, 0), borders=(0, 0), strength=None,
           touch=0, area=None, dst=None, part=None, turns=0):  # fmt: skip
    dst = np.full(src.shape, 77, src.dtype) if dst is None else dst
    how = ntp.ffi.new("ntp_transform_options *")
    how.flip_x, how.flip_y = flips
    how.quarter_turns, how.angle, how.touch_unused = turns, angle, touch
    how.border_x, how.border_y = borders
    how.use_strength, how.strength = strength is not None, strength or 0.0
    place = ntp.ffi.new("ntp_part *", part or [0] * 6)
    how.part = place if part else ntp.ffi.NULL
    source = ntp.view(src, encoding, y, const=True)
    ntp.check(ntp.lib.ntp_transform(ntp.view(dst, encoding, y), source, how, ntp.rect(area)))
    return dst


@pytest.mark.parametrize("m", [255, 65535])
@pytest.mark.parametrize("encoding", NAMES)
def test_against_fractions(encoding, m):
    cases = itertools.cycle(itertools.product(ANGLES, (ntp.UP, ntp.DOWN), ((0, 0), (1, 0), (1, 1))))
    for channels in (2, 3, 4) if encoding == ntp.XY else (3, 4):
        for strength, touch, borders in (
            (None, 0, (0, 1)), (0.3, ntp.UNUSED_ALL, (2, 0)), (-1024.0, 0, (1, 2)),
            (2.0**-40, ntp.UNUSED_TRANSPARENT, (0, 0)),
        ):  # fmt: skip
            angle, y, flips = next(cases)
            next(cases)
            src = noise((5, 9, channels), m, channels)
            got = rotate(src, angle, encoding, y, flips, borders, strength, touch)
            factor = Fraction(strength) if strength is not None else 1
            if 0 < abs(factor) < 2**-10:
                factor = Fraction(math.floor(factor * 2**62), 2**62)
            want = oracle_rotate.rotated(
                src.tolist(), angle, m, NAMES[encoding], y, flips, borders, factor, touch
            )
            assert got.tolist() == want, (angle, strength, touch)


@pytest.mark.parametrize("angle", [45.0, 61.7])
@pytest.mark.parametrize("m", [255, 65535])
def test_wide_pictures_against_fractions(m, angle):
    """Many texels at a time, with flat areas, unused texels, and a z that nearly vanishes."""
    src = noise((2, 150, 4), m, 9)
    src[:, :20] = [m // 2 + 1, m // 2 + 1, m, m]
    src[:, 20:50, :2] = 3 * m // 4  # an x or y of 0 at 45 degrees, which is always in doubt
    src[:, 20:50, 3] = m
    src[:, 50:80, 2] = m // 2 + np.arange(30) % 2
    src[:, 60:75, 3] = m
    src[:, 90:100, 3] = 0
    rgb = src[..., :3].copy()
    rgb[:, 80:110] = 0  # unused, as are the white ones
    rgb[:, 110:125] = m
    rgb[0, 125:140], rgb[1, 125:140] = [m, m // 2, m // 2], [0, m // 2 + 1, m // 2 + 1]
    for texture, encoding in (
        (src, ntp.STANDARD),
        (src, ntp.ZZERO),
        (src, ntp.XY),
        (rgb, ntp.STANDARD),
    ):
        for strength, borders in ((None, (2, 1)), (1000.0, (2, 1)), (0.3, (0, 2))):
            got = rotate(texture, angle, encoding, strength=strength, borders=borders)
            factor = Fraction(strength or 1)
            want = oracle_rotate.rotated(
                texture.tolist(), angle, m, NAMES[encoding], ntp.UP, (0, 0), borders, factor, 0
            )
            assert got.tolist() == want


def bumps(side, degrees=0.0, y=ntp.UP):
    """Normals of a smooth surface that is turned clockwise, computed where it is, not resampled."""
    at = np.arange(side) + 0.5 - side / 2
    px, py = np.meshgrid(at, -at)  # y up
    a = math.radians(degrees)
    u, v = math.cos(a) * px - math.sin(a) * py, math.sin(a) * px + math.cos(a) * py
    du, dv = np.cos(u / 9) * np.cos(v / 13), -np.sin(u / 9) * np.sin(v / 13) * 9 / 13
    p, q = math.cos(a) * du + math.sin(a) * dv, -math.sin(a) * du + math.cos(a) * dv
    n = np.dstack([-p, -q if y == ntp.UP else q, np.ones_like(p)])
    n /= np.linalg.norm(n, axis=2, keepdims=True)
    return n


@pytest.mark.parametrize("y", [ntp.UP, ntp.DOWN])
@pytest.mark.parametrize("angle", [30.0, 45.0, 200.0, -75.5])
def test_the_surface_is_turned(angle, y):
    """Far from the corners the result is the texture of the turned surface."""
    side = 90
    src = np.floor((bumps(side, 0, y) + 1) / 2 * 65535 + 0.5).astype(np.uint16)
    got = rotate(src, angle, y=y) / 65535 * 2 - 1
    want = bumps(side, angle, y)
    mid = slice(20, -20)
    cosines = np.sum(got[mid, mid] * want[mid, mid], -1)
    assert np.degrees(np.arccos(np.clip(cosines, -1, 1))).max() < 0.6


@pytest.mark.parametrize("m", [255, 65535])
def test_quarter_turns_stay_exact(m):
    src = noise((6, 6, 4), m, 1)
    for turns in range(4):
        want = rotate(src, 0.0, turns=turns)
        for angle in (90.0 * turns, 90.0 * turns - 360, 90.0 * turns + 1e-11):
            assert np.array_equal(rotate(src, angle), want)
        assert np.array_equal(rotate(src, 90.0, turns=(turns + 3) % 4), want)
    turned = rotate(src, 45.0, turns=1)
    assert np.array_equal(turned, rotate(src, 135.0))
    assert np.array_equal(turned, rotate(src, -225.0))


def test_results_are_exact_and_flat_stays_flat():
    out = rotate(noise((30, 40, 3), 255, 5), 33.3)
    assert np.all((ntp.validate(out, keep=1) & ntp.PASS_EXACT) != 0)
    z = np.full((9, 9, 3), 255, np.uint8)
    z[..., :2] = 128  # half a level off flat: it turns like any vector
    turned = rotate(z, 180.00001)
    assert np.all(turned == [127, 127, 255])


def test_where_nothing_is_there_is_nothing():
    src = np.zeros((8, 8, 4), np.uint8)
    assert np.all(rotate(src, 45.0) == [128, 128, 255, 0])
    src[3:5, 3:5] = [200, 100, 200, 255]
    out = rotate(src, 45.0)
    assert out[0, 0, 3] == 0 and out[3, 3, 3] > 128
    seen = out[out[..., 3] > 0]
    assert (seen[:, :3] == seen[0, :3]).all()  # transparent texels do not bleed


@pytest.mark.parametrize(("channels", "m"), [(4, 65535), (3, 255)])
@pytest.mark.parametrize("flips", [(0, 0), (1, 0), (0, 1)])
def test_areas_and_parts_make_the_whole(flips, channels, m):
    src = noise((23, 31, channels), m, 6)
    whole = rotate(src, 40.0, flips=flips, strength=1.3, borders=(1, 1))
    dst = np.zeros_like(whole)
    for area in ((5, 0, 31, 13), (0, 13, 31, 23), (0, 0, 5, 13)):
        rotate(src, 40.0, flips=flips, strength=1.3, borders=(1, 1), area=area, dst=dst)
    assert np.array_equal(dst, whole)
    wide = np.pad(src, ((20, 20), (20, 20), (0, 0)), mode="wrap")
    piece = rotate(wide, 40.0, flips=flips, strength=1.3, dst=np.zeros((7, 9, channels), src.dtype),
                   part=[31, 23, -20, -20, 12, 8])  # fmt: skip
    tiled = rotate(src, 40.0, flips=flips, strength=1.3)
    assert np.array_equal(piece, tiled[8:15, 12:21])


def test_floats_are_on_the_grid_of_16_bits():
    levels = noise((9, 8, 4), 65535, 7)
    floats = (levels / 65535).astype(np.float32)
    got = rotate(floats, 20.0)
    assert np.array_equal(got, (rotate(levels, 20.0) / 65535).astype(np.float32))


def test_arguments():
    src = noise((4, 4, 3), 255, 8)
    for bad in ({"angle": 360.1}, {"angle": math.nan}, {"angle": 1.0, "borders": (3, 0)},
                {"angle": 1.0, "touch": 8}):  # fmt: skip
        with pytest.raises(ntp.NtpError):
            rotate(src, **bad)
    with pytest.raises(ntp.NtpError):
        rotate(src, 45.0, dst=np.zeros((5, 4, 3), np.uint8))
