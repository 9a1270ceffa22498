# SPDX-License-Identifier: MIT
"""What pictures and padding have in common with normals must not decide.

Each test draws what a real image was once wrong about: sheets of normals on black after JPEG, color
textures whose red is like green, packed masks, a blue that holds nothing.
"""

import numpy as np
import pytest

from support import drawn_maps, drawn_surfaces, maps
from support import libntp_ffi as ntp
from support.judged import reason_text

SURFACES = [s.__name__ for s in drawn_maps.SURFACES]
CONFIDENT = 0.9


def told(pixels):
    return ntp.classify(np.ascontiguousarray(pixels), ntp.STANDARD)


def reasons(result):
    return [reason_text(result.reasons + i) for i in range(result.reason_count)]


def sheet(rng, name, padding, islands=9, side=256):
    """Islands of a standard texture, each with a round edge, on one color."""
    make = getattr(drawn_surfaces, name)
    n = make(rng, side, side)
    levels = drawn_maps.stored(drawn_maps.to_levels(n))
    y, x = np.mgrid[:side, :side]
    inside = np.zeros((side, side), bool)
    for _ in range(islands):
        cy, cx, r = rng.uniform(0, side), rng.uniform(0, side), rng.uniform(0.1, 0.2) * side
        inside |= (y - cy) ** 2 + (x - cx) ** 2 < r * r
    levels[~inside] = padding
    return levels, inside


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("padding", [(0, 0, 0), (0, 255, 0), (255, 255, 255)])
@pytest.mark.parametrize("quality", [95, 85])
def test_sheets_after_jpeg_are_normals(surface, padding, quality):
    """Black with the noise of JPEG is no color of normals, and neither is black with green flipped."""
    rng = np.random.default_rng([quality, *padding])
    levels, _ = sheet(rng, surface, padding)
    result = told(drawn_maps.by_jpeg(levels, quality, 0))
    assert result.type == drawn_maps.STANDARD, reasons(result)


@pytest.mark.parametrize("surface", SURFACES)
def test_cleaning_such_a_sheet_does_not_harm(surface):
    """Inside the islands the mean angle to the truth does not rise; pure black stays."""
    rng = np.random.default_rng(5)
    levels, inside = sheet(rng, surface, (0, 0, 0))
    stored = drawn_maps.by_jpeg(levels, 95, 0)
    cleaned = ntp.clean(stored, how=ntp.clean_options(1))[0]  # NTP_CLEAN_NORMALIZE

    def off(pixels):
        v, w = (2.0 * p[inside].astype(float) - 255 for p in (pixels, levels))
        v, w = (a / np.linalg.norm(a, axis=1, keepdims=True) for a in (v, w))
        return np.degrees(np.arccos(np.clip((v * w).sum(1), -1, 1))).mean()

    assert off(cleaned) <= off(stored) + 0.3
    black = (stored == 0).all(-1)
    assert (cleaned[black] == 0).all()


def like(rng, h, w, spread, blue):
    """Red, and green that is nearly the same, both around the middle; blue as it comes."""
    base = drawn_surfaces.octaves(rng, h, w) - 0.5
    base -= base.mean()
    noise = rng.normal(0, 0.02, (h, w))
    own = drawn_surfaces.octaves(rng, h, w)
    planes = [0.5 + spread * base, 0.5 + spread * (base + noise), blue * base + own]
    return np.clip(np.round(255 * np.stack(planes, -1)), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("number", range(6))
@pytest.mark.parametrize("blue", [0, 0.7])
def test_red_like_green_is_a_picture(number, blue):
    rng = np.random.default_rng(number)
    result = told(like(rng, 128, 128, 0.9, blue))
    assert result.type in (drawn_maps.NOT_NORMALS, drawn_maps.HEIGHT), reasons(result)


@pytest.mark.parametrize("number", range(4))
def test_a_fade_beside_a_constant_blue_is_a_picture(number):
    """White to blue, as on a button."""
    rng = np.random.default_rng(number)
    across = np.linspace(rng.uniform(0.2, 0.3), rng.uniform(0.8, 0.95), 128)
    fade = np.round(255 * np.repeat(across[None], 128, 0)).astype(np.uint8)
    result = told(np.stack([fade, fade, np.full_like(fade, 255)], -1))
    assert result.type == drawn_maps.NOT_NORMALS, reasons(result)


@pytest.mark.parametrize("number", range(6))
def test_packed_masks_with_full_red_are_not_swapped_normals(number):
    """Occlusion 1 throughout, roughness and metal around the middle: red is no z of theirs."""
    rng = np.random.default_rng(number)
    h, w = 96, 128
    own = [0.5 + 0.3 * (drawn_surfaces.octaves(rng, h, w) - 0.5) for _ in range(2)]
    masks = np.stack([np.ones((h, w)), *own], -1)
    result = told(np.round(255 * masks).astype(np.uint8))
    assert result.accidents & (maps.RED_IS_Z | maps.GREEN_IS_Z) == 0, reasons(result)


@pytest.mark.parametrize("surface", SURFACES)
def test_noise_around_the_middle_is_no_xy(surface):
    """White or smooth, all channels alike: neither holds x and y."""
    rng = np.random.default_rng(len(surface))
    for smooth in (0, 1, 2):
        noise = rng.normal(0, 1, (128, 128, 3))
        for _ in range(smooth):
            noise = sum(np.roll(noise, (i, k), (0, 1)) for i in range(3) for k in range(3))
        noise = 128 + 20 * noise / noise.std()
        result = told(np.clip(np.round(noise), 0, 255).astype(np.uint8))
        assert result.type == drawn_maps.NOT_NORMALS, reasons(result)


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("end", [0, 255])
def test_a_blue_that_hardly_varies_holds_nothing(surface, end):
    """Filled in, and a few levels off: not z, and said so."""
    rng = np.random.default_rng(end)
    n = drawn_maps.surface(rng, surface, 0.25)
    levels = drawn_maps.to_levels(n)
    levels[..., 2] = np.abs(end - np.abs(rng.normal(0, 2, n.shape[:2])).round())
    result = told(drawn_maps.stored(levels))
    assert result.type == drawn_maps.XY, reasons(result)
    assert result.accidents & maps.BLUE_CONSTANT


def test_reasons_against_say_so():
    """Red and green that go together are no reason for x and y."""
    rng = np.random.default_rng(3)
    n = drawn_maps.surface(rng, "rock", 0.2)
    mixed = np.stack([n[..., 0] + 0.9 * n[..., 1], n[..., 1] + 0.5 * n[..., 0], n[..., 2]], -1)
    levels = drawn_maps.to_levels(np.clip(0.5 * mixed, -1, 1))
    levels[..., 2] = 255 * drawn_maps.shade_of(rng, n)
    result = told(drawn_maps.stored(levels))
    assert result.type == drawn_maps.XY
    told_alike = [r for r in reasons(result) if "vary together" in r]
    assert told_alike and all(r.startswith("against it: ") for r in told_alike)
