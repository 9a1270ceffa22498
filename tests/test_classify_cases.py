# SPDX-License-Identifier: MIT
"""Single textures that the reference program gets wrong, or that the classification once got
wrong."""

from collections import Counter

import numpy as np
import pytest
from PIL import ImageFilter

from support import maps, surfaces
from support.damages import (
    as_zzero,
    constant_blue,
    jpeg,
    resized,
    rounded,
    sample,
    share_of_texels,
    tilted,
    wrong_z,
)
from support.judged import classify, describe, reason_text

CONFIDENT, UNSURE = 0.9, 0.85

S, X = maps.STANDARD, maps.XY
DAMAGES = {
    "nothing": (lambda n, rng: rounded(n), S, 0),
    "truncated": (lambda n, rng: maps.to_type(np.floor((n + 1) / 2 * 255)), S, 0),
    "3 % black": (lambda n, rng: share_of_texels(rounded(n), rng, 0.03, 0), S, 0),
    "3 % white": (lambda n, rng: share_of_texels(rounded(n), rng, 0.03, 255), S, 0),
    "70 % black": (lambda n, rng: share_of_texels(rounded(n), rng, 0.7, 0), S, 0),
    "60 % gray": (lambda n, rng: share_of_texels(rounded(n), rng, 0.6, 128), S, 0),
    "25 % green": (lambda n, rng: share_of_texels(rounded(n), rng, 0.25, (0, 255, 0)), S, 0),
    "40 % magenta": (lambda n, rng: share_of_texels(rounded(n), rng, 0.4, (255, 0, 255)), S, 0),
    "3 % wrong z": (wrong_z, S, 0),
    "tilted, one bad texel": (tilted, S, 0),
    "JPEG 95": (jpeg(95), S, 0),
    "JPEG 85": (jpeg(85), S, 0),
    "JPEG 75": (jpeg(75), S, 0),
    "halved by box": (resized(0.5, maps.Image.BOX), S, 0),
    "halved by Lanczos": (resized(0.5, maps.Image.LANCZOS), S, 0),
    "doubled": (resized(2, maps.Image.BILINEAR), S, 0),
    "z flipped": (lambda n, rng: rounded(n * [1, 1, -1]), S, maps.Z_FLIPPED),
    "red is z": (lambda n, rng: rounded(n)[..., ::-1], S, maps.RED_IS_Z),
    "green is z": (lambda n, rng: rounded(n)[..., [0, 2, 1]], S, maps.GREEN_IS_Z),
    "scaled by 0.9": (lambda n, rng: rounded(0.9 * n), S, 0),
    "sRGB": (lambda n, rng: maps.srgb_encode(rounded(n)), S, maps.GAMMA),
    "blue 0": (constant_blue(0), X, maps.BLUE_CONSTANT),
    "blue 128": (constant_blue(128), X, maps.BLUE_CONSTANT),
    "blue 255": (constant_blue(255), X, maps.BLUE_CONSTANT),
    "Z-zero": (as_zzero, maps.ZZERO, 0),
    "Z-zero, 60 % gray": (
        lambda n, rng: share_of_texels(as_zzero(n, rng), rng, 0.6, 128),
        maps.ZZERO,
        0,
    ),
}


@pytest.mark.parametrize("family", [f.__name__ for f in surfaces.FAMILIES])
@pytest.mark.parametrize("damage", DAMAGES)
def test_known_errors_of_the_reference_program(damage, family):
    apply, kind, accident = DAMAGES[damage]
    for strength in (0.5, 0.8):
        rng = np.random.default_rng([int(strength * 10), len(family)])
        pixels = apply(sample(family, strength, rng), rng)
        case = maps.Case(damage, pixels, kind, details={"family": family, "strength": strength})
        result = classify(case)
        text = describe(0, case, result)
        assert result.type == kind, text
        assert result.accidents & accident == accident, text


def test_marks_of_compression_and_filtering():
    n = sample("fractal", 0.8, np.random.default_rng(4), 256)
    for quality in (60, 75):
        assert classify(maps.Case("", jpeg(quality)(n, None), S)).accidents == maps.LOSSY
    rough = sample("noise", 1.5, np.random.default_rng(4), 256)
    quartered = resized(0.25, maps.Image.BOX)(rough, None)
    assert classify(maps.Case("", quartered, S)).accidents == maps.FILTERED
    assert classify(maps.Case("", rounded(n), S)).accidents == 0


def test_gentle_zzero_is_told_where_it_can_be():
    rng = np.random.default_rng(3)
    for strength in (0.1, 0.15, 0.25):
        pixels = as_zzero(sample("bumps", strength, rng), rng)
        assert classify(maps.Case("gentle", pixels, maps.ZZERO)).type == maps.ZZERO, strength
    flat = as_zzero(sample("bumps", 0.02, rng), rng)
    result = classify(maps.Case("too gentle", flat, maps.ZZERO))
    assert result.type == maps.STANDARD and result.confidence < CONFIDENT


def test_single_colors():
    for color in [(128, 128, 255), (201, 201, 201), (0, 0, 0), (255, 255, 255), (0, 255, 255)]:
        pixels = np.full((32, 32, 3), color, np.uint8)
        assert classify(maps.Case("color", pixels, maps.ONE_COLOR)).type == maps.ONE_COLOR, color


def test_object_space_sphere():
    for h, w in ((64, 128), (256, 512)):
        pixels = rounded(maps._sphere_directions(h, w))
        result = classify(maps.Case("sphere", pixels, maps.OBJECT))
        assert result.type == maps.OBJECT and result.confidence >= CONFIDENT


@pytest.mark.parametrize("paint", maps.PICTURES)
def test_pictures_are_no_normals(paint):
    wrong = 0
    for i in range(20):
        rng = np.random.default_rng([i, 9])
        pixels = maps.to_type(np.clip(np.floor(paint(rng, 128, 128) * 255 + 0.5), 0, 255))
        result = classify(maps.Case(paint.__name__, pixels, maps.NOT_NORMALS))
        if result.type != maps.NOT_NORMALS:
            wrong += 1
            assert result.confidence < CONFIDENT, describe(i, maps.Case("", pixels, 6), result)
    assert wrong <= 4


def test_a_gray_chart_is_not_taken_for_gamma_encoded_normals():
    """A gray of 230 is of unit length where it is decoded from sRGB."""
    pixels = np.full((300, 300, 3), 230, np.uint8)
    pixels[:20] = pixels[:, :20] = 255
    for y in range(40, 260, 30):
        pixels[y : y + 4, 30:280] = 60
    pixels[100:140, 60:90] = 23, 179, 183
    pixels[150:190, 160:190] = 243, 94, 90
    assert classify(maps.Case("chart", pixels, maps.NOT_NORMALS)).type == maps.NOT_NORMALS


def test_fades_are_not_taken_for_normals_with_confidence():
    """A line of colors through the middle of the disc has lengths near 1 as normals do."""
    rng = np.random.default_rng(11)
    called = Counter()
    for i in range(400):
        h, w = int(rng.integers(16, 80)), int(rng.integers(16, 80))
        y, x = np.mgrid[:h, :w]
        a = rng.uniform(0, 2 * np.pi)
        t = np.cos(a) * x / w + np.sin(a) * y / h
        t = (t - t.min()) / np.ptp(t) - 0.5
        middle = np.array([0.5, 0.5, rng.uniform(0.85, 1)]) + rng.uniform(-0.03, 0.03, 3)
        if i % 4 == 0:
            middle = np.array([0.737, 0.737, 0.97])  # what flat is as sRGB
        along = rng.uniform(-0.6, 0.6, 3) * [1, 1, rng.uniform(0, 1)]
        levels = np.clip(np.round((middle + t[..., None] * along) * 255), 0, 255).astype(np.uint8)
        if i % 3 == 0:
            levels = maps.jpeg(levels, int(rng.integers(70, 98)), 2)
        case = maps.Case("fade", levels, maps.NOT_NORMALS, details={"along": along})
        result = classify(case)
        called[result.type] += 1
        assert result.type in (maps.NOT_NORMALS, maps.ONE_COLOR) or result.confidence < CONFIDENT, (
            describe(i, case, result)
        )
    assert called[maps.STANDARD] + called[maps.XY] > 100  # they do look alike


def test_mostly_flat_with_another_blue_is_not_sure():
    """Flat texels fit any bright blue, or any dark one, so a few domes have to decide."""
    for size in (64, 128, 256):
        y, x = np.mgrid[:size, :size] + 0.5
        for radius in (0.08, 0.12, 0.16):
            r = radius * size
            inside = np.maximum(r * r - (x - size / 2) ** 2 - (y - size / 2) ** 2, 0)
            height = surfaces.blur(np.sqrt(inside), 0.7)
            for strength in (0.25, 0.5, 1.0):
                levels = rounded(surfaces.normals_of(height, strength))
                around = surfaces.blur(height, r / 3) - height
                for name, blue in {
                    "height": height / height.max(),
                    "occlusion": np.clip(1 - 4 * np.maximum(around, 0) / height.max(), 0, 1),
                }.items():
                    levels[..., 2] = np.floor(blue * 255 + 0.5)
                    case = maps.Case(name, levels, X, details={"r": r, "strength": strength})
                    result = classify(case)
                    assert result.type == X or result.confidence < CONFIDENT, describe(
                        size, case, result
                    )


def test_well_formed_textures_are_sure():
    for family in (f.__name__ for f in surfaces.FAMILIES):
        for strength in (0.3, 0.8, 2):
            n = sample(family, strength, np.random.default_rng(8))
            result = classify(maps.Case(family, rounded(n), S))
            assert result.type == S and result.confidence >= 0.95, (family, strength)


def test_blue_that_follows_is_sure_whatever_the_lengths():
    """Scaled vectors: no texel is a unit vector, but blue varies with z."""
    for family in ("fractal", "bricks", "bumps"):
        n = sample(family, 0.8, np.random.default_rng(6))
        for scaled in (0.85 * n, n * [1, 1, 0.82]):
            result = classify(maps.Case("scaled", rounded(scaled), S))
            assert result.type == S and result.confidence >= CONFIDENT, family
            texts = [reason_text(result.reasons + i) for i in range(result.reason_count)]
            assert "varies with the z" in " ".join(texts)


def test_bright_blue_over_gentle_slopes_is_not_sure():
    """Lengths are near 1 whatever blue means: constant, or an occlusion that is 1 nearly everywhere."""
    for seed in range(12):
        rng = np.random.default_rng([seed, 12])
        levels = rounded(sample("hemispheres", rng.uniform(0.35, 0.45), rng, 64))
        for share in (0, 0.02, 0.05):
            blue = np.full(levels.shape[:2], 255)
            blue[: int(64 * share)] = rng.integers(40, 250)
            case = maps.Case("bright", np.dstack([levels[..., :2], blue]).astype(np.uint8), X)
            result = classify(case)
            assert result.type == X or result.confidence <= UNSURE, describe(seed, case, result)


def test_halved_colors():
    """JPEG with chroma subsampling removes the relation of noise to blue, but makes all channels
    alike."""
    for seed in range(6):
        rng = np.random.default_rng([seed, 13])
        n = sample("noise", rng.uniform(1, 1.6), rng, 64)
        case = maps.Case("halved", maps.jpeg(rounded(n), rng.integers(70, 92), 2), S)
        result = classify(case)
        assert result.type == S and result.confidence < CONFIDENT, describe(seed, case, result)


def test_zzero_that_is_not_honestly_rounded():
    """A level too low, where the two readings lie two to three apart: blue follows at a slope of 2."""
    for seed in range(6):
        for family in ("fractal", "bumps", "hemispheres"):
            rng = np.random.default_rng([seed, 14])
            levels = as_zzero(sample(family, rng.uniform(0.3, 0.36), rng), rng)
            low = (levels - (levels > 0)).astype(np.uint8)
            case = maps.Case(family, low, maps.ZZERO)
            result = classify(case)
            assert result.type == maps.ZZERO, describe(seed, case, result)


def test_ridges_with_a_height_are_no_object_space():
    """Sine and cosine: unit vectors in all directions, but red and green lie on a line."""
    y, x = np.mgrid[:64, :64]
    for kx, ky in ((2, 1), (3, -2), (1, 4)):
        wave = 2 * np.pi * (kx * x + ky * y) / 64
        along = np.array([kx, ky]) / np.hypot(kx, ky)
        n = np.dstack([np.cos(wave) * along[0], np.cos(wave) * along[1], np.sin(wave)])
        result = classify(maps.Case("ridges", rounded(n), X))
        assert result.type != maps.OBJECT and result.confidence < CONFIDENT


def test_flipped_z_is_sure():
    for family in ("fractal", "bricks", "bumps"):
        n = sample(family, 0.8, np.random.default_rng(6)) * [1, 1, -1]
        result = classify(maps.Case("flipped", rounded(n), S))
        assert (result.type, result.accidents) == (S, maps.Z_FLIPPED)
        assert result.confidence >= CONFIDENT


@pytest.mark.parametrize("family", ["fractal", "hemispheres"])
def test_sharpened_normals_whose_blue_follows_z(family):
    """Sharpening makes one x, y in six too long; blue still rises and falls with z."""
    n = sample(family, 2.2, np.random.default_rng([22, len(family)]))
    sharp = maps.Image.fromarray(np.ascontiguousarray(rounded(n))).filter(
        ImageFilter.UnsharpMask(1, 200, 0)
    )
    result = classify(maps.Case(family, np.array(sharp), S))
    assert result.type == S


def test_rough_normals_sharpened_and_saved_as_jpeg_twice():
    """A few blues fall below one half, but the others still follow z."""
    n = sample("bricks", 3, np.random.default_rng([30, len("bricks")]))
    sharp = maps.Image.fromarray(maps.jpeg(rounded(n), 20, 2)).filter(
        ImageFilter.UnsharpMask(1, 100, 0)
    )
    result = classify(maps.Case("twice", maps.jpeg(np.array(sharp), 20, 2), S))
    assert result.type == S and result.accidents & maps.LOSSY


def test_a_skin_has_no_exchanged_channels():
    """Full red, and a green and blue that vary together off the middle: a color, not y and x."""
    t = surfaces.fractal(np.random.default_rng(3), 128, 128)
    t = (t - t.mean()) / t.std()
    skin = np.dstack([250 + 0 * t, 160 + 14 * t, 123 + 13 * t])
    result = classify(maps.Case("skin", maps.to_type(skin.clip(0, 255)), maps.NOT_NORMALS))
    assert result.type == maps.NOT_NORMALS


def test_a_background_of_one_color_is_no_body():
    """A screenshot whose background happens to have unit length: all vectors point one way."""
    rng = np.random.default_rng(4)
    page = np.full((128, 128, 3), (178, 190, 220), np.uint8)
    page[48:80, 40:96] = rng.integers(0, 256, (32, 56, 3))
    result = classify(maps.Case("page", page, maps.NOT_NORMALS))
    assert result.type == maps.NOT_NORMALS


def test_no_reason_says_only_all():
    """Half a ball that faces down, a little short, is of no class, but not for its lengths."""
    z, x = np.mgrid[-1:1:64j, -1:1:64j]
    y = -np.maximum(np.sqrt(np.clip(1 - x * x - z * z, 0, 1)), 0.15)
    n = np.dstack([x, y, z]) / np.sqrt(x * x + y * y + z * z)[..., None]
    result = classify(maps.Case("half a ball", rounded(0.96 * n), maps.NOT_NORMALS))
    assert result.type == maps.NOT_NORMALS and result.reason_count > 0
    for i in range(result.reason_count):
        assert "of the used texels have about unit length" not in reason_text(result.reasons + i)
