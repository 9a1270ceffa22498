# SPDX-License-Identifier: MIT
"""Classes, accidents and cleaning methods of textures whose kind is known (support/maps.py).

The seed is drawn anew at each run and printed; NTP_SEED repeats a run.  With CI set it is always
CI_SEED, so that a change is judged by its own effect.  Bounds on shares are more than five standard
deviations away from what hundreds of seeds gave.  No wrong answer may have a confidence of 0.9 or
more, neither in these draws nor in those of FIXED_SEEDS; in 513,800 draws of other seeds, 110,600 of
them looked at only after the last change of a rule, none had more than 0.85.
"""

import os
from collections import Counter

import numpy as np
import pytest

import libntp_ffi as ntp
from support import maps, surfaces
from support.evidence import evidence

DRAWS = 700
FIXED_DRAWS = 250
# Each had a wrong answer of high confidence once, or a bound that it came near to.
FIXED_SEEDS = [(205, 500), (20, 0), (35, 250), (16, 400)]
# Draws that were called something else with confidence once.
CONFIDENT_ONCE = [
    ("draw", 3901100012, 170),
    ("draw", 5601200005, 226),
    ("draw", 5701200103, 177),
    ("draw", 5801200019, 566),
    ("zzero", 7701200017, 589, 7),
]
CONFIDENT = 0.9
UNSURE = 0.85  # no error is surer than this, so that there is a margin below CONFIDENT
CI_SEED = 20261121


@pytest.fixture(scope="module")
def seed():
    drawn = CI_SEED if os.environ.get("CI") else int.from_bytes(os.urandom(4), "little")
    value = int(os.environ.get("NTP_SEED") or drawn)
    print(f"\nNTP_SEED={value}")
    return value


def tally_of(case, encoding=None):
    return ntp.tally_of(case.pixels, case.encoding if encoding is None else encoding)


def reason_text(reason):
    room = ntp.ffi.new("char[400]")
    length = ntp.lib.ntp_reason_text(room, 400, reason)
    text = ntp.ffi.string(room).decode()
    assert len(text) == length
    return text


def classify(case):
    return ntp.classify(case.pixels, case.encoding)


def describe(index, case, result):
    reasons = "; ".join(reason_text(result.reasons + i) for i in range(result.reason_count))
    return (
        f"{index} {case.name} {case.details}: {maps.CLASSES[result.type]} "
        f"{result.confidence:.2f} accidents {result.accidents}: {reasons}"
    )


def matrix_text(matrix):
    head = " ".join(f"{name[:9]:>9}" for name in maps.CLASSES)
    rows = [
        f"{name:>12} " + " ".join(f"{n:9}" for n in row)
        for name, row in zip(maps.CLASSES, matrix, strict=True)
    ]
    return "\n".join([f"{'is / called':>12} {head}", *rows])


@pytest.fixture(scope="module")
def judged(seed):
    """(index, case, result) of many draws."""
    cases = [(i, maps.draw(np.random.default_rng([seed, i]))) for i in range(DRAWS)]
    return [(i, case, classify(case)) for i, case in cases]


def test_drawn_textures_are_recognized(judged, seed):
    matrix = np.zeros((7, 7), int)
    wrong, confident = [], []
    for i, case, result in judged:
        right = result.type == case.kind or result.type in case.also
        matrix[case.kind, case.kind if right else result.type] += 1
        if not right:
            wrong.append(describe(i, case, result))
            if result.confidence >= CONFIDENT:
                confident.append(wrong[-1])
    share = matrix.trace() / len(judged)
    report = f"NTP_SEED={seed}: {share:.1%} right\n{matrix_text(matrix)}\n" + "\n".join(wrong)
    print("\n" + report)
    assert share >= 0.98, report
    assert not confident, report


@pytest.mark.parametrize(("fixed", "first"), FIXED_SEEDS)
def test_no_confident_error(fixed, first):
    wrong, right = [], 0
    for i in range(first, first + FIXED_DRAWS):
        case = maps.draw(np.random.default_rng([fixed, i]))
        result = classify(case)
        if result.type == case.kind or result.type in case.also:
            right += 1
        elif result.confidence >= CONFIDENT:
            wrong.append(describe(i, case, result))
    assert not wrong, "\n".join(wrong)
    assert right >= 0.95 * FIXED_DRAWS


@pytest.mark.parametrize("what", CONFIDENT_ONCE, ids=str)
def test_errors_that_were_confident_once(what):
    case = getattr(maps, what[0])(np.random.default_rng(what[1:]))
    result = classify(case)
    right = result.type == case.kind or result.type in case.also
    assert right or result.confidence <= UNSURE, describe(what, case, result)


def test_no_class_is_given_up(judged, seed):
    """Each class by itself, in both directions: no class is right at the cost of another."""
    for kind in range(7):
        drawn = [r for _, c, r in judged if c.kind == kind]
        right = sum(r.type == c.kind or r.type in c.also for _, c, r in judged if c.kind == kind)
        called = [c for _, c, r in judged if r.type == kind]
        true = sum(c.kind == kind or kind in c.also for c in called)
        name = f"NTP_SEED={seed} {maps.CLASSES[kind]}"
        assert len(drawn) >= 5, name
        assert right >= 0.85 * len(drawn), name
        assert true >= 0.85 * len(called), name


def test_the_sure_are_many(judged, seed):
    """Confidence says something: most textures get 0.9 or more, and errors are less sure."""
    right = [r.confidence for _, c, r in judged if r.type == c.kind]
    assert np.mean(np.array(right) >= CONFIDENT) > 0.6, f"NTP_SEED={seed}"
    assert all(0.5 <= r.confidence <= 1 for _, _, r in judged)


def test_accidents(judged, seed):
    wanted, missing, false = 0, [], []
    for i, case, result in judged:
        wanted += case.must != 0
        if case.must & ~result.accidents:
            missing.append(describe(i, case, result))
        if result.accidents & ~(case.must | case.may):
            false.append(describe(i, case, result))
    report = f"NTP_SEED={seed}: of {wanted}\n" + "\n".join([*missing, "false:", *false])
    assert len(missing) <= 0.12 * wanted, report
    assert len(false) <= 0.02 * len(judged), report


def test_every_answer_has_a_reason(judged):
    for _, _, result in judged:
        assert 1 <= result.reason_count <= 6
        for i in range(result.reason_count):
            assert len(reason_text(result.reasons + i)) > 10


# ------------------------------------------- what the reference program gets wrong, one by one


def sample(family, strength, rng, size=128):
    height = getattr(surfaces, family)(rng, size, size)
    return surfaces.normals_of(height, strength)


def rounded(n):
    return maps.to_type(maps.encode(n))


def jpeg(quality):
    return lambda n, rng: maps.jpeg(rounded(n), quality, 0)


def _share_of_texels(levels, rng, share, value):
    levels = levels.copy()
    rows = max(1, int(levels.shape[0] * share))
    levels[:rows] = value
    return levels


def _wrong_z(n, rng):
    levels = rounded(n)
    bad = rng.random(n.shape[:2]) < 0.03
    levels[bad, 2] = rng.integers(0, 256, int(bad.sum()))
    return levels


def _tilted(n, rng):
    n = n + np.array([0.2, 0, 0])
    levels = rounded(n / np.linalg.norm(n, axis=-1, keepdims=True))
    levels[5, 5] = (3, 250, 7)
    return levels


def _constant_blue(value):
    def damage(n, rng):
        levels = rounded(n)
        levels[..., 2] = value
        return levels

    return damage


def _zzero(n, rng):
    levels = rounded(n)
    levels[..., 2] = np.floor(n[..., 2] * 255 + 0.5)
    return levels


def _resized(factor, how):
    def damage(n, rng):
        side = int(n.shape[0] * factor)
        return maps.resize(rounded(n), side, side, how)

    return damage


S, X = maps.STANDARD, maps.XY
DAMAGES = {
    "nothing": (lambda n, rng: rounded(n), S, 0),
    "truncated": (lambda n, rng: maps.to_type(np.floor((n + 1) / 2 * 255)), S, 0),
    "3 % black": (lambda n, rng: _share_of_texels(rounded(n), rng, 0.03, 0), S, 0),
    "3 % white": (lambda n, rng: _share_of_texels(rounded(n), rng, 0.03, 255), S, 0),
    "70 % black": (lambda n, rng: _share_of_texels(rounded(n), rng, 0.7, 0), S, 0),
    "60 % gray": (lambda n, rng: _share_of_texels(rounded(n), rng, 0.6, 128), S, 0),
    "25 % green": (lambda n, rng: _share_of_texels(rounded(n), rng, 0.25, (0, 255, 0)), S, 0),
    "40 % magenta": (lambda n, rng: _share_of_texels(rounded(n), rng, 0.4, (255, 0, 255)), S, 0),
    "3 % wrong z": (_wrong_z, S, 0),
    "tilted, one bad texel": (_tilted, S, 0),
    "JPEG 95": (jpeg(95), S, 0),
    "JPEG 85": (jpeg(85), S, 0),
    "JPEG 75": (jpeg(75), S, 0),
    "halved by box": (_resized(0.5, maps.Image.BOX), S, 0),
    "halved by Lanczos": (_resized(0.5, maps.Image.LANCZOS), S, 0),
    "doubled": (_resized(2, maps.Image.BILINEAR), S, 0),
    "z flipped": (lambda n, rng: rounded(n * [1, 1, -1]), S, maps.Z_FLIPPED),
    "red is z": (lambda n, rng: rounded(n)[..., ::-1], S, maps.RED_IS_Z),
    "green is z": (lambda n, rng: rounded(n)[..., [0, 2, 1]], S, maps.GREEN_IS_Z),
    "scaled by 0.9": (lambda n, rng: rounded(0.9 * n), S, 0),
    "sRGB": (lambda n, rng: maps.srgb_encode(rounded(n)), S, maps.GAMMA),
    "blue 0": (_constant_blue(0), X, maps.BLUE_CONSTANT),
    "blue 128": (_constant_blue(128), X, maps.BLUE_CONSTANT),
    "blue 255": (_constant_blue(255), X, maps.BLUE_CONSTANT),
    "Z-zero": (_zzero, maps.ZZERO, 0),
    "Z-zero, 60 % gray": (
        lambda n, rng: _share_of_texels(_zzero(n, rng), rng, 0.6, 128),
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
    quartered = _resized(0.25, maps.Image.BOX)(rough, None)
    assert classify(maps.Case("", quartered, S)).accidents == maps.FILTERED
    assert classify(maps.Case("", rounded(n), S)).accidents == 0


def test_gentle_zzero_is_told_where_it_can_be():
    rng = np.random.default_rng(3)
    for strength in (0.1, 0.15, 0.25):
        pixels = _zzero(sample("bumps", strength, rng), rng)
        assert classify(maps.Case("gentle", pixels, maps.ZZERO)).type == maps.ZZERO, strength
    flat = _zzero(sample("bumps", 0.02, rng), rng)
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
    """Flat texels fit any bright blue, or any dark one: few domes have to tell."""
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
    """Scaled vectors: no texel is a unit vector, but blue goes up and down with z."""
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
    """JPEG with halved colors takes the relation to blue from noise, but makes all channels alike."""
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
            levels = _zzero(sample(family, rng.uniform(0.3, 0.36), rng), rng)
            low = (levels - (levels > 0)).astype(np.uint8)
            case = maps.Case(family, low, maps.ZZERO)
            result = classify(case)
            assert result.type == maps.ZZERO, describe(seed, case, result)


def test_ridges_with_a_height_are_no_object_space():
    """Sine and cosine: unit vectors in all directions, but red and green keep to a line."""
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


# ------------------------------------------------------------------------- cleaning method


def choose(case, lossy=0):
    encoding = case.kind
    tally = tally_of(case, encoding)
    method, why = ntp.ffi.new("ntp_clean_method *"), ntp.ffi.new("ntp_reason *")
    ntp.check(ntp.lib.ntp_choose_method(method, why, tally.pointer, encoding, lossy))
    return method[0], reason_text(why), evidence(tally)


def mean_angle(levels, truth, m, zzero):
    """Mean angle in degrees between what the levels say and the undamaged vectors."""
    v = levels[..., :3].astype(float) * 2 / m - 1
    if zzero:
        v[..., 2] = levels[..., 2] / m
    dot, cross = (v * truth).sum(-1), np.linalg.norm(np.cross(v, truth), axis=-1)
    return np.degrees(np.arctan2(cross, dot)).mean()


def test_the_chosen_method_is_not_the_worse_one(seed):
    good, total, bad = 0, 0, []
    counts = Counter()
    for i in range(DRAWS):
        case = maps.draw(np.random.default_rng([seed, 1, i]))
        if case.truth is None or case.kind > maps.ZZERO:
            continue
        pixels = np.ascontiguousarray(case.pixels)
        m = 255 if pixels.dtype == np.uint8 else 65535
        method, why, _ = choose(case)
        angles = [
            mean_angle(
                ntp.clean(pixels, case.kind, ntp.clean_options(k))[0], case.truth, m, case.kind
            )
            for k in range(3)
        ]
        total += 1
        counts[case.name, method] += 1
        if angles[method] <= 1.1 * min(angles[:2]) + 0.05:
            good += 1
        else:
            bad.append(f"{i} {case.name} {case.details}: {method} {why} {np.round(angles, 2)}")
    report = (
        f"NTP_SEED={seed}: {good} of {total}\n" + "\n".join(bad) + f"\n{sorted(counts.items())}"
    )
    print("\n" + report)
    assert total > 200
    assert good >= 0.95 * total, report


def test_method_of_plain_cases():
    rng = np.random.default_rng(5)
    n = sample("fractal", 0.8, rng)
    clean = maps.Case("clean", rounded(n), S)
    assert choose(clean)[0] == ntp.KEEP
    assert choose(maps.Case("flipped", rounded(n * [1, 1, -1]), S))[0] == ntp.KEEP
    assert choose(maps.Case("Z-zero", _zzero(n, rng), maps.ZZERO))[0] == ntp.KEEP
    assert choose(maps.Case("wrong z", _wrong_z(n, rng), S))[0] == ntp.DERIVE
    assert choose(maps.Case("blue 255", _constant_blue(255)(n, rng), S))[0] == ntp.DERIVE
    assert choose(maps.Case("blue 255", _constant_blue(255)(n, rng), S), 1)[0] == ntp.DERIVE
    assert choose(maps.Case("scaled", rounded(0.9 * n), S))[0] == ntp.NORMALIZE
    assert choose(maps.Case("scaled z", rounded(n * [1, 1, 0.85]), S))[0] == ntp.DERIVE
    too_blue = rounded(n)
    too_blue[..., 2] = np.minimum(too_blue[..., 2].astype(int) + 9, 255)
    assert choose(maps.Case("too blue", too_blue, S))[0] == ntp.DERIVE
    halved = _resized(0.5, maps.Image.BOX)(n, rng)
    assert choose(maps.Case("halved", halved, S))[0] == ntp.NORMALIZE
    assert choose(maps.Case("JPEG", jpeg(85)(n, rng), S), 1)[0] == ntp.NORMALIZE
    one_off = rounded(n)
    one_off[3, 3, 2] = 90
    assert choose(maps.Case("one texel", one_off, S))[0] == ntp.DERIVE
    padded = rounded(n)
    padded[:20] = 0
    assert choose(maps.Case("padded", padded, S))[0] == ntp.KEEP
    assert choose(maps.Case("XY", rounded(n), maps.XY))[0] in (ntp.DERIVE, ntp.KEEP)


# ----------------------------------------------------------------- how blue goes with x, y


def blue_oracle(pixels):
    """The statistics on tilted texels, written with numpy from their description."""
    p = pixels.reshape(-1, 3).astype(float)
    p = p[~((p == 0).all(1) | (p == 255).all(1))]
    xy = 2 * p[:, :2] / 255 - 1
    rest = 1 - (xy**2).sum(1)
    p, rest = p[rest > 0], rest[rest > 0]
    z = np.sqrt(rest)
    want = np.stack([127.5 + 127.5 * z, 255 * z])
    blue = p[:, 2]
    tilted = want[0] - want[1] > 1
    off = np.abs(blue - want)[:, tilted]
    slope, correlation = (
        np.cov(want[0], blue)[0, 1] / want[0].var(ddof=1),
        np.corrcoef(want[0], blue),
    )
    return {
        "tilted": int(tilted.sum()),
        "tilted_gap": (want[0] - want[1])[tilted].mean(),
        "tilted_off": np.minimum(off, 32).mean(1),
        "tilted_near": (off <= 3).mean(1),
        "tilted_above": (blue - want[0] > 4)[tilted].mean(),
        "blue_slope": slope,
        "blue_correlation": correlation[0, 1],
    }


def test_statistics_of_blue(seed):
    rng = np.random.default_rng([seed, 2])
    for i in range(6):
        n = sample("fractal", 0.3 * (i + 1), rng, 48)
        pixels = _wrong_z(n, rng) if i % 2 else _zzero(n, rng)
        pixels[:3] = 0
        got = evidence(ntp.Tally().measure(pixels))
        for name, want in blue_oracle(pixels).items():
            assert got[name] == pytest.approx(want, rel=1e-6, abs=1e-9), (
                f"NTP_SEED={seed} {i} {name}"
            )


def test_sixteen_bit_content_is_judged_like_eight(seed):
    """A 16-bit texture of 8-bit levels gets the same answer as the 8-bit one."""
    for i in range(10):
        case = maps.draw(np.random.default_rng([seed, 3, i]))
        if case.pixels.dtype != np.uint8:
            continue
        wide = maps.Case(
            case.name, case.pixels.astype(np.uint16) * 257, case.kind, case.also, case.encoding
        )
        a, b = classify(case), classify(wide)
        assert (a.type, a.accidents) == (b.type, b.accidents), describe(i, case, a)
        assert a.confidence == pytest.approx(b.confidence, abs=0.02)
