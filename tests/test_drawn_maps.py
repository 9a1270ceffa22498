# SPDX-License-Identifier: MIT
"""The classification on textures that its rules were not fitted on (support/drawn_maps.py).

Each kind of texture is drawn with every surface, several times, and damaged in several ways.  It
asserts that no wrong answer has a high confidence, that about as many answers are right as when
this was written, and that changes that keep a texture's meaning keep its class.  The drawings are
the same at each run.
"""

import numpy as np
import pytest

from support import drawn_maps, drawn_pictures
from support import libntp_ffi as ntp

CONFIDENT = 0.9
NUMBERS = range(3)
DRAWN = len(drawn_maps.SURFACES) * len(NUMBERS)  # of each kind and damage: 27
SPARE = 2  # so many fewer may be right
FEW = ["", "jpeg85", "half", "blocks"]
MANY = ["standard", "zzero", "XY and shade", "object space"]
DAMAGES = {name: FEW for name in drawn_maps.MAPS}
DAMAGES |= {name: list(drawn_maps.DAMAGES) for name in MANY}
DAMAGES |= {"padded": [""], "16 bit": [""]}


def in_groups(cases):
    """Cases that begin with a name of drawn_maps.MAPS.  One process of pytest-xdist runs all of a
    name, so that its textures are drawn once."""
    cases = [(case,) if isinstance(case, str) else case for case in cases]
    return [pytest.param(*c, marks=pytest.mark.xdist_group(f"drawn: {c[0]}")) for c in cases]


CASES = [(name, damage) for name in drawn_maps.MAPS for damage in DAMAGES[name]]

# How many of DRAWN are right where not all are.  The others are wrong today, none with confidence:
# whoever makes more of them right raises the number.  Damaged Z-zero is called standard or XY where
# its means do not tell either; JPEG makes a constant blue follow the surface;
# diagonal ridges have red like green, as pictures have.
RIGHT = {
    ("standard", "jpeg60"): 24,
    ("zzero", "jpeg85"): 21,
    ("zzero", "jpeg60"): 10,
    ("zzero", "half"): 22,
    ("zzero", "smaller"): 25,
    ("zzero", "larger"): 26,
    ("zzero", "blocks"): 20,
    ("XY and shade", ""): 26,
    ("XY and 0", "jpeg85"): 21,
    ("XY and 255", "jpeg85"): 23,
    ("box", "jpeg85"): 19,
    ("box", "half"): 25,
}
# Smooth noise around the middle is called XY: nothing but the lack of any surface speaks against it.
NOISE_THAT_IS_CALLED_XY = ("jpeg85", "half")

# How many of DRAWN are right and sure, undamaged: an answer that is never sure helps nobody.
# Nothing in the texels proves that blue is something else on purpose.
SURE = dict.fromkeys(drawn_maps.MAPS, DRAWN) | {"XY and shade": 0}
SURE |= dict.fromkeys(["XY and 0", "XY and 128", "XY and 255"], 24)

# What the classification must name, and is not expressed by the class; else it names nothing.
ACCIDENTS = {
    "brightened": 1,
    "red and blue swapped": 2,
    "green and blue swapped": 4,
    "x in alpha": 8,
    "x in alpha, gray": 8,
    "blue inverted": 64,
}
BLUE_CONSTANT = 128


def told(drawing):
    """(class, confidence, accidents)"""
    result = ntp.classify(np.ascontiguousarray(drawing.pixels), drawing.encoding)
    return result.type, result.confidence, result.accidents


def described(drawing, answer):
    right, called = drawn_maps.CLASSES[drawing.kind], drawn_maps.CLASSES[answer[0]]
    return f"{drawing.name}: {right} called {called}, {answer[1]:.2f}"


def judge(drawings):
    """(how many are right, the wrong answers as text, those of them that are sure)."""
    wrong, sure = [], []
    for drawing in drawings:
        answer = told(drawing)
        if answer[0] != drawing.kind:
            wrong.append(described(drawing, answer))
            if answer[1] >= CONFIDENT:
                sure.append(wrong[-1])
    return len(drawings) - len(wrong), wrong, sure


def draw_all(name, damage):
    surfaces = [s.__name__ for s in drawn_maps.SURFACES]
    return [drawn_maps.draw(name, s, damage, n) for s in surfaces for n in NUMBERS]


@pytest.mark.parametrize(("name", "damage"), in_groups(CASES))
def test_kinds_and_damages(name, damage):
    right, wrong, sure = judge(draw_all(name, damage))
    assert right >= RIGHT.get((name, damage), DRAWN) - SPARE * (damage != ""), "\n".join(wrong)
    assert not sure, "\n".join(sure)


@pytest.mark.parametrize("name", in_groups(drawn_maps.MAPS))
def test_what_is_whole_is_sure(name):
    sure = [told(drawing)[1] >= CONFIDENT for drawing in draw_all(name, "")]
    assert sum(sure) >= SURE[name] - SPARE


@pytest.mark.parametrize("damage", ["", "jpeg85", "half", "blocks", "4 bit"])
@pytest.mark.parametrize("paint", drawn_pictures.PICTURES)
def test_pictures(paint, damage):
    drawings = [drawn_maps.draw_picture(paint, damage, n) for n in NUMBERS]
    right, wrong, sure = judge(drawings)
    assert not sure, "\n".join(sure)
    if paint is not drawn_pictures.white_noise or damage not in NOISE_THAT_IS_CALLED_XY:
        assert right == len(drawings), "\n".join(wrong)


@pytest.mark.parametrize("name", drawn_maps.OTHERS)
def test_other_layouts(name):
    """The class is right, and the accident is named."""
    wrong = []
    for surface in drawn_maps.SURFACES:
        drawings = [drawn_maps.draw_other(name, surface.__name__, n) for n in NUMBERS]
        for drawing in drawings:
            answer = told(drawing)
            if answer[0] != drawing.kind:
                wrong.append(described(drawing, answer))
                assert answer[1] < CONFIDENT, wrong[-1]
            else:
                assert answer[2] == ACCIDENTS.get(name, 0), drawing.name
    assert len(wrong) <= 1, "\n".join(wrong)


@pytest.mark.parametrize("name", in_groups(drawn_maps.MAPS))
def test_no_accident_of_what_is_whole(name):
    constant = name in ("XY and 0", "XY and 128", "XY and 255")
    for surface in drawn_maps.SURFACES:
        drawing = drawn_maps.draw(name, surface.__name__, "", 0)
        assert told(drawing)[2] == (BLUE_CONSTANT if constant else 0), drawing.name


# Two textures side by side, and the classes that hold for both; of others the answer is not sure.
# A surface is also a chart of object space that faces the viewer.
NO_NORMALS = (drawn_maps.NOT_NORMALS,)
HALVES = [
    # Wrong today, once in nine: a gentle Z-zero half passes for normals that were resized.
    ("standard", "zzero", (drawn_maps.STANDARD,)),
    ("standard", "XY and shade", ()),
    ("standard", "XY and 0", ()),
    ("standard", "object space", (drawn_maps.OBJECT,)),
    ("zzero", "XY and shade", ()),
    ("zzero", "object space", ()),
    ("standard", "heights", NO_NORMALS),
    ("XY and 0", "heights", NO_NORMALS),
    ("standard", "photograph", NO_NORMALS),
    ("standard", "purple_painting", NO_NORMALS),
    ("zzero", "masks", NO_NORMALS),
    ("object space", "photograph", NO_NORMALS),
    ("heights", "photograph", NO_NORMALS),
]


def pixels_of(name, surface, number):
    if name in drawn_maps.MAPS:
        return drawn_maps.draw(name, surface, "", number).pixels
    return drawn_maps.draw_picture(getattr(drawn_pictures, name), "", number).pixels


@pytest.mark.parametrize(("left", "right", "classes"), in_groups(HALVES))
def test_halves_of_two_kinds_are_not_surely_one(left, right, classes):
    for number, surface in enumerate(drawn_maps.SURFACES):
        pixels = pixels_of(left, surface.__name__, number).copy()
        h, w = pixels.shape[:2]
        other = pixels_of(right, surface.__name__, number + 1)
        rows, columns = h // other.shape[0] + 1, w // other.shape[1] + 1
        pixels[:, w // 2 :] = np.tile(other, (rows, columns, 1))[:h, w // 2 : w]
        answer = told(drawn_maps.Drawing("", pixels, 0))
        assert answer[1] < CONFIDENT or answer[0] in classes, (surface.__name__, answer)


@pytest.mark.parametrize("name", in_groups(MANY))
def test_what_is_a_third_noise_is_not_sure(name):
    for number, surface in enumerate(drawn_maps.SURFACES):
        pixels = pixels_of(name, surface.__name__, number).copy()
        rng = np.random.default_rng(number)
        hit = rng.random(pixels.shape[:2]) < 0.33
        pixels[hit] = rng.integers(0, 256, (hit.sum(), 3))
        answer = told(drawn_maps.Drawing("", pixels, 0))
        assert answer[1] < CONFIDENT or answer[0] == drawn_maps.NOT_NORMALS, surface.__name__


def one_channel_twice(pixels):
    """Ridges along a diagonal have red like green: a picture, as far as anybody can tell."""
    red, green = pixels[..., 0].ravel() / 255, pixels[..., 1].ravel() / 255
    like = abs(np.corrcoef(red, green)[0, 1]) > 0.9
    return like and 2 / 3 < red.std() / green.std() < 3 / 2


@pytest.mark.parametrize("surface", [s.__name__ for s in drawn_maps.SURFACES])
def test_blue_of_another_surface_makes_it_xy(surface):
    """For a standard texture and a Z-zero one: the relation of blue decides, not its
    distribution."""
    names = [s.__name__ for s in drawn_maps.SURFACES]
    for number, name in enumerate(["standard", "zzero"] * 2):
        pixels = pixels_of(name, surface, number).copy()
        h, w = pixels.shape[:2]
        other = pixels_of(name, names[(names.index(surface) + 4) % len(names)], number)
        rows, columns = h // other.shape[0] + 1, w // other.shape[1] + 1
        pixels[..., 2] = np.tile(other, (rows, columns, 1))[:h, :w, 2]
        if not one_channel_twice(pixels):
            assert told(drawn_maps.Drawing("", pixels, 0))[0] == drawn_maps.XY


def shuffled(pixels):
    flat = pixels.reshape(-1, pixels.shape[2])
    return np.random.default_rng(1).permutation(flat).reshape(pixels.shape)


def with_full_alpha(pixels):
    return np.dstack([pixels, np.full(pixels.shape[:2], 255, np.uint8)])


# What changes nothing about what a texture is.
KEEPING = {
    "mirrored": lambda p: p[:, ::-1],
    "turned": np.rot90,
    "repeated": lambda p: np.tile(p, (2, 2, 1)),
    "x and y swapped": lambda p: p[..., [1, 0, 2]],
    "opaque alpha added": with_full_alpha,
    "in 16 bits": lambda p: p.astype(np.uint16) * 257,
    "black around it": lambda p: np.pad(p, ((16, 16), (16, 16), (0, 0))),
    "texels in another order": shuffled,
}


@pytest.mark.parametrize(
    "name", in_groups(n for n in drawn_maps.MAPS if n not in ("padded", "16 bit"))
)
def test_what_keeps_the_meaning_keeps_the_class(name):
    for surface in drawn_maps.SURFACES:
        drawing = drawn_maps.draw(name, surface.__name__, "", 1)
        pixels, before = drawing.pixels, told(drawing)[0]
        for change, changed in KEEPING.items():
            drawing.pixels = changed(pixels)
            assert told(drawing)[0] == before, (drawing.name, change)


@pytest.mark.parametrize("name", in_groups(["standard", "zzero", "XY and shade", "XY and 128"]))
@pytest.mark.parametrize("channel", [0, 1])
def test_the_orientation_does_not_matter(name, channel):
    for surface in drawn_maps.SURFACES:
        drawing = drawn_maps.draw(name, surface.__name__, "", 1)
        before = told(drawing)
        drawing.pixels[..., channel] = 255 - drawing.pixels[..., channel]
        after = told(drawing)
        assert after[0] == before[0] and after[1] == pytest.approx(before[1], abs=0.05)


def test_means_tell_zzero_after_jpeg_and_say_so():
    """Domes keep to their line; the reason names the ratio, which is 2 but for what JPEG took."""
    made = drawn_maps.draw("zzero", "domes", "", 1).pixels
    stored = drawn_maps.by_jpeg(made, 85, 2)
    result = ntp.classify(stored, ntp.STANDARD)
    assert drawn_maps.CLASSES[result.type] == "zzero" and result.confidence < 0.9
    ratios = [r.value for r in result.reasons[0 : result.reason_count] if r.code == 43]
    assert ratios and 1.65 < ratios[0] < 2.5
