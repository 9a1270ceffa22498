# SPDX-License-Identifier: MIT
"""Does a texture tile?  Periodic surfaces do, parts cut out of them do not."""

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import maps
from support import to_height as reconstruction
from support.find import find_seams as find

UNDECIDED, TILES, SEAM = "undecided", "tiles", "seam"


def told(seam):
    """The verdict on two opposite edges, as a word."""
    if not seam["decided"]:
        return UNDECIDED
    return TILES if seam["tiles"] else SEAM


KERNELS = ["central", "forward", "sobel3", "scharr3"]


def bumps(n, seed):
    """Rounded hills, some of them across the edges."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:n, :n] / n
    h = np.zeros((n, n))
    for cx, cy, r in rng.uniform([0, 0, 0.05], [1, 1, 0.2], (25, 3)):
        dx, dy = (x - cx + 0.5) % 1 - 0.5, (y - cy + 0.5) % 1 - 0.5
        h += n * r * 0.3 * np.exp(-(dx * dx + dy * dy) / (r * r))
    return h.astype(np.float32)


SURFACES = [reconstruction.fractal, bumps]


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("surface", SURFACES)
def test_periodic_surfaces_tile(surface, kernel):
    for seed, size in [(1, 64), (2, 256), (3, 300)]:
        n = reconstruction.from_height(surface(size, seed), kernel)
        for seam in find(n):
            assert told(seam) == TILES and seam["wraps"], seam
            assert seam["closure"] < 0.1 and seam["jump"] < 3 and abs(seam["lean"]) < 1 / 255


@pytest.mark.parametrize("surface", SURFACES)
def test_cut_out_parts_do_not(surface):
    seams = 0
    for seed, size in [(1, 128), (2, 256), (3, 400), (4, 256)]:
        n = reconstruction.from_height(surface(size, seed))
        part = np.ascontiguousarray(n[size // 9 : size * 3 // 4, size // 7 : size * 2 // 3])
        for seam in find(part):
            assert told(seam) != TILES and not seam["wraps"], seam
            seams += told(seam) == SEAM
    assert seams >= 6


def test_each_axis_by_itself():
    h = reconstruction.fractal(256)
    n = reconstruction.from_height(h)[:, 30:170].copy()
    across, down = find(n)
    assert told(across) == SEAM and told(down) == TILES
    turned = np.ascontiguousarray(n.transpose(1, 0, 2)[..., [1, 0, 2]])
    assert find(turned) == (down, across)


def test_one_axis_alone():
    n = reconstruction.from_height(reconstruction.fractal(150))[:, 30:170].copy()
    src = ntp.view(n, ntp.STANDARD, const=True)
    for i, both in enumerate(find(n)):
        seam = [ntp.ffi.NULL, ntp.ffi.NULL]
        seam[i] = ntp.ffi.new("ntp_seam *")
        ntp.check(ntp.lib.ntp_find_seams(*seam, src, 0))
        assert ntp.fields(seam[i]) == both


def test_a_ramp_tiles_but_does_not_wrap():
    """The normals repeat; the heights climb."""
    h = reconstruction.fractal(256)
    p = (np.roll(h, -1, 1) - np.roll(h, 1, 1)) / 2 + 0.2
    q = (np.roll(h, -1, 0) - np.roll(h, 1, 0)) / 2
    n = maps.to_type(maps.encode(reconstruction.vectors_of(p, q)))
    across, down = find(n)
    assert told(across) == TILES and not across["wraps"]
    assert across["lean"] == pytest.approx(-0.2, abs=0.01)
    assert down["wraps"]


def test_damage():
    """JPEG and noise do not give a tiling texture a seam, and do not make a seam disappear."""
    rng = np.random.default_rng(8)
    n = reconstruction.from_height(bumps(256, 5))
    part = np.ascontiguousarray(n[20:200, 30:190])
    noise = rng.normal(0, 3, n.shape)
    for damaged in [maps.jpeg(n, 90, 0), np.clip(n + noise, 0, 255).round().astype(np.uint8)]:
        assert all(told(s) != SEAM for s in find(damaged))
    assert all(told(s) == SEAM for s in find(maps.jpeg(part, 90, 0)))


def noisy(n, seed):
    noise = np.random.default_rng(seed).normal(0, 4, n.shape)
    return np.clip(n + noise, 0, 255).round().astype(np.uint8)


def test_damaged_tiles_still_tile():
    """Sums of slopes along a line do not survive damage, but slopes go on across the edges."""
    tile, part = [], []
    for slope, exponent in ((0.7, 2.0), (0.2, 2.2), (1.5, 2.5)):
        for seed in (1, 2):
            surface = reconstruction.fractal
            n = reconstruction.from_height(surface(160, seed, slope, exponent))
            cut = reconstruction.from_height(surface(320, seed, slope, exponent))
            cut = cut[37:197, 51:211].copy()
            for damaged, into in ((n, tile), (cut, part)):
                for worse in (maps.jpeg(damaged, 85, 0), noisy(damaged, seed)):
                    into += [seam["wraps"] for seam in find(worse)]
    assert not any(part) and sum(tile) >= 0.75 * len(tile), tile


def test_parts_whose_ends_happen_to_be_alike():
    """A wave and a part of the next: slopes nearly go on across the edges, but with a step or a lean."""
    x = np.arange(44)[None] * (2 * np.pi / 44)
    y = np.arange(44)[:, None] * (2 * np.pi / 44)
    answers = []
    for turns in (1.15, 1.2, 1.25, 1.3):
        for tilt in (0.0, 0.04, 0.06):
            p = 0.25 * np.cos(turns * x + 0.4 + 0.3 * np.sin(y)) + tilt
            q = 0.2 * np.sin(y) + 0 * x
            n = maps.to_type(maps.encode(reconstruction.vectors_of(p, q)))
            answers.append(told(find(noisy(n, 3))[0]))
    assert TILES not in answers, answers


def bricks(n, grain, seed):
    """64 x 32 texels each, in courses that are half a brick apart."""
    y, x = np.mgrid[:n, :n]
    x = (x + y // 32 % 2 * 32) % 64
    y = y % 32
    edge = np.minimum(np.minimum(x, 64 - x), np.minimum(y, 32 - y))
    h = np.clip(edge / 3 + grain * reconstruction.fractal(n, seed, exponent=1.6), 0, 1)
    return (7 * h).astype(np.float32)


@pytest.mark.parametrize("kernel", ["central", "forward"])
@pytest.mark.parametrize("seed", range(3))
def test_flat_edges_decide_nothing(kernel, seed):
    """The face of one brick fits that of another, wherever both are cut."""
    n = reconstruction.from_height(bricks(512, 0.03 * seed, seed), kernel)
    for damage in (lambda n: n, lambda n: maps.jpeg(n, 95, 0)):
        for part in (n[20:266, 30:256], n[20:266, 30:267], n[12:490, 7:490]):
            for seam in find(damage(np.ascontiguousarray(part))):
                assert told(seam) != TILES, seam
    shifted = find(np.roll(n, 16, 0))[1]  # seams of tiles may be amid bricks as well
    assert told(shifted) == UNDECIDED and (kernel == "forward" or shifted["wraps"]), shifted


def sampled(h):
    """Normals of the band-limited surface through the heights: it rings beside edges."""
    slopes = []
    for axis in (1, 0):
        f = np.fft.fftfreq(h.shape[axis]) * 2j * np.pi
        f[h.shape[axis] // 2] = 0
        f = f if axis == 1 else f[:, None]
        slopes.append(np.fft.ifft(np.fft.fft(h, axis=axis) * f, axis=axis).real)
    n = reconstruction.vectors_of(*slopes)
    return np.floor((n + 1) * 127.5 + 0.5).clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize("seed", range(3))
def test_sums_of_very_steep_slopes_decide_nothing(seed):
    n = sampled(bricks(512, 0.03, seed))
    for first in range(28, 40, 2):
        for seam in find(np.ascontiguousarray(n[first : first + 236, 20:256])):
            assert told(seam) != TILES, (first, seam)


def test_undecided():
    rng = np.random.default_rng(5)
    fractal = reconstruction.from_height(reconstruction.fractal(64))
    cases = {
        "flat": np.full((64, 64, 3), (128, 128, 255), np.uint8),
        "dithered": np.full((64, 64, 3), (128, 128, 255), np.uint8)
        - rng.integers(0, 2, (64, 64, 3), dtype=np.uint8),
        "black": np.zeros((64, 64, 3), np.uint8),
        "tiny": fractal[:10, :10].copy(),
        "a texel": fractal[:1, :1].copy(),
        "a row": fractal[:1].copy(),
    }
    for name, n in cases.items():
        for seam in find(n):
            assert told(seam) == UNDECIDED and not seam["wraps"], (name, seam)
    ring = fractal.copy()
    ring[:, [0, -1]] = 0  # no normals at the edges
    assert told(find(ring)[0]) == UNDECIDED


def test_encodings_agree():
    n = reconstruction.from_height(reconstruction.fractal(128))
    one = find(n)
    assert find(np.ascontiguousarray(n[..., :2]), ntp.XY) == one
    deep = n.astype(np.uint16) * 257
    assert [told(s) for s in find(deep)] == [told(s) for s in one]


def test_against_a_model():
    """The numbers, by numpy."""
    n = reconstruction.from_height(reconstruction.fractal(120))[:, :97].copy()
    p, _ = reconstruction.slopes(n, ntp.XY)
    slopes = -np.stack(reconstruction.slopes(n, ntp.XY))
    across, _ = find(n)
    heights = np.cumsum(-p, axis=1)
    full = heights[:, -1]
    steps = np.abs(np.diff(slopes, axis=2)).sum(0)
    jump = np.abs(slopes[:, :, 0] - slopes[:, :, -1]).sum(0)
    pp, qq = slopes**2
    noise = (2 / 255) ** 2 / 12 * (1 + pp + qq) * ((1 + pp) ** 2 + pp * qq)
    noise = noise.sum(1).mean()
    signal = heights.var(1).mean() - full.mean() ** 2 / 12
    assert across["lean"] == pytest.approx(full.mean() / 97)
    assert across["jump"] == pytest.approx(jump.mean() / steps.mean())
    assert across["closure"] == pytest.approx(np.sqrt((full.var() - noise) / (signal - noise / 6)))
    assert across["largest"] == pytest.approx((steps > jump[:, None]).max(1).__invert__().mean())
    assert across["rank"] == pytest.approx((steps > jump[:, None]).mean(), abs=1e-3)


def test_errors():
    n = np.zeros((8, 8, 3), np.uint8)
    x = ntp.ffi.new("ntp_seam *")
    src = ntp.view(n, ntp.STANDARD, const=True)
    find_seams = ntp.lib.ntp_find_seams
    assert find_seams(x, x, src, 0) == ntp.OK
    assert find_seams(ntp.ffi.NULL, ntp.ffi.NULL, src, 0) == ntp.ERR_ARGUMENT
    assert find_seams(x, x, ntp.ffi.NULL, 0) == ntp.ERR_ARGUMENT
    assert find_seams(x, x, src, 8) == ntp.ERR_ARGUMENT
    src.ring_rows = 4
    assert find_seams(x, x, src, 0) == ntp.ERR_SHAPE
