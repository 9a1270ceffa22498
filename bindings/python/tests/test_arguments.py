# SPDX-License-Identifier: MIT
"""Errors: of the right builtin kind, with the status of the library, naming argument and value."""

import fractions
import inspect
import re
import subprocess
import typing

import numpy as np
import pytest

import normaltexture as nt
from normaltexture import _names, _undo
from normaltexture._native import lib
from support import textures

TEXTURE = np.full((6, 8, 3), (128, 128, 255), np.uint8)
GRAY = np.zeros((6, 8), np.uint8)

CALLS = {
    "clean": lambda **how: nt.clean(TEXTURE, **how),
    "convert": lambda **how: nt.convert(TEXTURE, **how),
    "encode": lambda **how: nt.encode(nt.decode(TEXTURE), **how),
    "validate": lambda **how: nt.validate(TEXTURE, **how),
    "measure": lambda **how: nt.measure(TEXTURE, **how),
    "heatmap": lambda **how: nt.heatmap(TEXTURE, **how),
    "shade": lambda **how: nt.shade(TEXTURE, **how),
    "compare": lambda **how: nt.compare(TEXTURE, TEXTURE, **how),
    "resize": lambda **how: nt.resize(TEXTURE, **{"size": (2, 2)} | how),
    "transform": lambda **how: nt.transform(TEXTURE, **how),
    "blend": lambda **how: nt.blend(TEXTURE, TEXTURE, **how),
    "normals_from_height": lambda **how: nt.normals_from_height(GRAY, **{"scale": 1} | how),
    "blur_height": lambda **how: nt.blur_height(GRAY, **how),
    "pack_channels": lambda **how: nt.pack_channels(TEXTURE, **{"channels": "xyz"} | how),
    "like": lambda **how: nt.like(**{"name": "gegl", "value": 1} | how),
    "height_from_normals": lambda **how: nt.height_from_normals(TEXTURE, **how),
    "curvature": lambda **how: nt.curvature(GRAY, **how),
    "occlusion": lambda **how: nt.occlusion(GRAY, **how),
    "encode_bc5": lambda **how: nt.encode_bc5(TEXTURE, **how),
    "encode_bc4": lambda **how: nt.encode_bc4(**{"src": GRAY} | how),
    "detect_orientation": lambda **how: nt.detect_orientation(TEXTURE, **how),
}

WRONG = [
    ("clean", {"type": "height"}),
    ("clean", {"method": "newest"}),
    ("clean", {"verdict": 1}),
    ("clean", {"threads": -1}),
    ("clean", {"threads": 1.5}),
    ("convert", {"type": "best"}),
    ("convert", {"y": "left"}),
    ("transform", {"y": "left"}),
    ("blend", {"detail_y": "left"}),
    ("convert", {"to_y": "left"}),
    ("convert", {"depth": 12}),
    ("convert", {"blue": None}),
    ("encode", {"to": "vectors"}),
    ("validate", {"type": []}),
    ("measure", {"type": "STANDARD"}),
    ("heatmap", {"palette": "pink"}),
    ("shade", {"y": 0}),
    ("encode_bc5", {"quality": "best"}),
    ("encode_bc4", {"src": TEXTURE}),
    ("compare", {"type": ("zz", "standard")}),
    ("compare", {"type": ("auto",)}),
    ("compare", {"y": ("up", "zz")}),
    ("resize", {"size": "50"}),
    ("resize", {"size": (0, 4)}),
    ("resize", {"size": (70000, 4)}),
    ("resize", {"size": 7}),
    ("resize", {"filter": "cubic"}),
    ("resize", {"border": "extrapolate"}),
    ("resize", {"border_x": "none"}),
    ("transform", {"rotate": 361}),
    ("transform", {"border": "extrapolate"}),
    ("transform", {"flip": "z"}),
    ("transform", {"strength": 2000}),
    ("transform", {"strength": float("nan")}),
    ("blend", {"mode": "add"}),
    ("blend", {"strength": "much"}),
    ("blend", {"detail_y": "zz"}),
    ("normals_from_height", {"scale": None}),
    ("normals_from_height", {"scale": float("inf")}),
    ("normals_from_height", {"dx": 0}),
    ("normals_from_height", {"min_z": 1.5}),
    ("normals_from_height", {"kernel": "sobel"}),
    ("normals_from_height", {"border_y": "zero"}),
    ("normals_from_height", {"source": "hue"}),
    ("normals_from_height", {"alpha": "zero"}),
    ("normals_from_height", {"dither": True}),
    ("blur_height", {"sigma": 65}),
    ("blur_height", {"octaves": []}),
    ("blur_height", {"octaves": 2.0}),
    ("blur_height", {"border": "zero"}),
    ("curvature", {"kind": "sharp"}),
    ("curvature", {"border": "mirror"}),
    ("curvature", {"range": -1}),
    ("curvature", {"scale": 0}),
    ("occlusion", {"type": "hills"}),
    ("occlusion", {"radius": float("nan")}),
    ("occlusion", {"depth": 12}),
    ("like", {"name": "photoshop"}),
    ("like", {"value": float("nan")}),
    ("pack_channels", {"channels": "xyq"}),
    ("pack_channels", {"channels": ""}),
    ("height_from_normals", {"method": "best"}),
    ("height_from_normals", {"decode": "snorm"}),
    ("height_from_normals", {"seeds": [1, 2, 3]}),
    ("height_from_normals", {"refine": -1}),
    ("height_from_normals", {"mask": np.zeros((2, 2), np.uint8)}),
    ("detect_orientation", {"type": None}),
]


PARTS = {"type": ["zz"], "y": ["zz"]}  # of two, the wrong one


@pytest.mark.parametrize(("name", "how"), WRONG, ids=[f"{n}-{next(iter(h))}" for n, h in WRONG])
def test_wrong_values_are_named(name, how):
    argument, value = next(iter(how.items()))
    with pytest.raises(nt.ArgumentError) as raised:
        CALLS[name](**how)
    assert isinstance(raised.value, ValueError)
    assert isinstance(raised.value, nt.NormalTextureError)
    message = str(raised.value)
    assert argument in message
    if not isinstance(value, np.ndarray):
        assert any(repr(part) in message for part in (value, *PARTS.get(argument, ())))
    assert isinstance(raised.value.status, nt.Status)


TWO_ARE_DATA = ("compare", "blend", "normals_from_height", "blur_height", "pack_channels", "like")


@pytest.mark.parametrize("name", CALLS)
def test_everything_but_the_data_is_keyword_only(name):
    parameters = list(inspect.signature(getattr(nt, name)).parameters.values())
    data = 1 + (name in TWO_ARE_DATA)
    kinds = [p.kind for p in parameters]
    assert kinds[:data] == [inspect.Parameter.POSITIONAL_OR_KEYWORD] * data
    assert set(kinds[data:]) <= {inspect.Parameter.KEYWORD_ONLY}


@pytest.mark.parametrize("dtype", [np.float64, np.float16, np.int32, np.int8, bool, object, "S1"])
def test_sample_types(dtype):
    with pytest.raises(nt.SampleTypeError, match="src: samples must be uint8, uint16") as raised:
        nt.clean(np.zeros((2, 2, 3), dtype))
    assert isinstance(raised.value, TypeError)
    assert raised.value.status == nt.Status.FORMAT
    assert ("astype" in str(raised.value)) == (np.dtype(dtype).kind == "f")


DOUBLES = np.random.default_rng(7).normal(size=(6, 8, 3)) * [0.3, 0.3, 1]
AS_VECTORS = {
    "clean": {},
    "convert": {"to": "standard", "depth": 16},
    "encode": {},
    "measure": {},
    "validate": {},
    "heatmap": {},
    "shade": {},
    "transform": {"flip": "x"},
    "resize": {"size": (4, 3)},
    "detect_orientation": {},
    "choose_method": {},
    "height_from_normals": {"y": "up"},
}


def same(a, b):
    """Equal arrays, objects or tuples of them."""
    return np.array_equal(a, b, equal_nan=True) if isinstance(a, np.ndarray) else a == b


@pytest.mark.parametrize("name", AS_VECTORS)
def test_double_vectors_are_rounded_once(name):
    """As numpy rounds them; the array itself stays."""
    how = dict(AS_VECTORS[name])
    if name != "encode":
        how["type"] = "vector"
    given = DOUBLES.copy()
    call = getattr(nt, name)
    assert same(call(given, **how), call(DOUBLES.astype(np.float32), **how))
    assert np.array_equal(given, DOUBLES)
    if name != "encode":
        for type in ("standard", "zzero"):
            with pytest.raises(nt.SampleTypeError, match="src: .*float64.*may be float64"):
                call(given, **how | {"type": type})


def test_double_heights_are_rounded_once():
    doubles = np.abs(DOUBLES[..., 0])
    floats = doubles.astype(np.float32)
    assert same(nt.normals_from_height(doubles, 5), nt.normals_from_height(floats, 5))
    assert same(nt.blur_height(doubles, 1), nt.blur_height(floats, 1))
    assert same(nt.measure(doubles, type="height"), nt.measure(floats, type="height"))
    assert nt.blur_height(doubles, 1).dtype == np.float32
    huge = np.full((4, 4), 1e300)  # no float32: counted like any infinity
    _, counts = nt.normals_from_height_with_counts(huge, 5)
    assert counts.not_finite == 16


@pytest.mark.parametrize("kind", [np.uint8, np.float64])
def test_masked_arrays_are_refused(kind):
    masked = np.ma.masked_array(TEXTURE.astype(kind), mask=False)
    for call in (nt.clean, nt.classify, nt.heatmap, lambda m: nt.normals_from_height(m, 1)):
        with pytest.raises(nt.SampleTypeError, match=r"(src|height): masked arrays .* filled\(0\)"):
            call(masked)


def test_what_is_no_normals_texture_is_not_cleaned():
    """By default, and in one sentence that names what was found and the way out."""
    heights = textures.heights()
    directions = np.random.default_rng(1).normal(size=(64, 64, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    objects = np.floor((directions + 1) / 2 * 255 + 0.5).astype(np.uint8)
    for image, what in (
        (textures.photograph(), "not-normals"),
        (np.dstack([heights] * 3), "height"),
        (objects, "object-space"),
    ):
        for call in (nt.clean, nt.clean_with_counts):
            with pytest.raises(nt.ArgumentError, match=f'src looks like {what}.*type="standard"'):
                call(image)
        assert nt.clean(image, type="standard").shape == image.shape


ACCIDENTS = {
    "red_blue_swapped": "red-blue",
    "green_blue_swapped": "green-blue",
    "dxt5nm": "dxt5nm",
    "z_flipped": "inverted-blue",
    "gamma": "srgb",
}


@pytest.mark.parametrize("name", ACCIDENTS)
def test_accidents_are_undone_as_the_program_does(name, test_files, tmp_path):
    """The same bytes, and the same word for what was undone."""
    path, made = test_files / f"{name}.png", tmp_path / "made.png"
    text = subprocess.run(
        [nt.program(), "clean", path, "-o", made, "--format", "json"],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    image = nt.read(path)
    result, counts = nt.clean_with_counts(image)
    assert f'"what": "{ACCIDENTS[name]}"' in text and counts.undone == ACCIDENTS[name]
    assert np.array_equal(result, nt.read(made))
    assert f'"changed": {counts.changed},' in text
    assert np.array_equal(result, nt.clean(image, undo=True))
    assert nt.clean_with_counts(image, type="standard")[1].undone is None


def test_an_accident_that_is_not_sure_is_refused(monkeypatch):
    swapped = np.ascontiguousarray(textures.standard(48, 64)[..., ::-1])
    monkeypatch.setattr(_undo, "SURE", 1.01)
    with pytest.raises(nt.ArgumentError, match=r"of src red and blue are exchanged .*undo=True"):
        nt.clean(swapped)
    assert np.array_equal(nt.clean(swapped, undo=True), nt.clean(swapped[..., ::-1]))


@pytest.mark.parametrize("most", [255, 65535])
def test_srgb_levels_are_rounded_exactly(most):
    """By fractions and integer powers, for every level that is near a half and many others."""
    levels = _undo._linear_levels(most)
    for level in {*range(0, most + 1, 97 if most > 255 else 1), 0, most}:
        n = int(levels[level])
        if 100000 * level <= 4045 * most:
            assert abs(fractions.Fraction(level * 25, 323) - n) <= fractions.Fraction(1, 2)
        else:  # (2n - 1)/2M <= ((s + 0.055)/1.055)^2.4 < (2n + 1)/2M, to the fifth power
            light = fractions.Fraction(1000 * level + 55 * most, 1055 * most) ** 12
            low, high = (fractions.Fraction(2 * n + d, 2 * most) ** 5 for d in (-1, 1))
            assert low <= light < high


@pytest.mark.parametrize(
    ("shape", "says"),
    [
        ((3,), "the shape must be"),
        ((1, 2, 3, 4), "the shape must be"),
        ((4, 4), "channels are needed"),
        ((4, 4, 2), "channels are needed"),
        ((4, 4, 5), "channels are needed"),
        ((0, 4, 3), "width and height must be"),
        ((4, 0, 3), "width and height must be"),
        ((1, 65536, 3), "65536 x 1"),
    ],
)
def test_shapes(shape, says):
    with pytest.raises(nt.ArgumentError, match=says) as raised:
        nt.clean(np.zeros(shape, np.uint8))
    assert raised.value.status in (nt.Status.SHAPE, nt.Status.FORMAT)
    assert "src" in str(raised.value)


def test_out():
    read_only = TEXTURE.copy()
    read_only.flags.writeable = False
    for out, says in (
        (np.zeros((6, 8, 4), np.uint8), r"out: must be an array of shape \(6, 8, 3\)"),
        (np.zeros((6, 8, 3), np.uint16), "uint8"),
        (TEXTURE.tolist(), "out: must be a numpy array, not list"),
        (read_only, "out: the array is read-only"),
    ):
        with pytest.raises(nt.ArgumentError, match=says):
            nt.clean(TEXTURE, out=out)


def test_overlap():
    wide = np.zeros((6, 9, 3), np.uint8)
    for call in (
        lambda: nt.clean(wide[:, 1:], out=wide[:, :-1]),
        lambda: nt.clean(wide[::-1], out=wide),
        lambda: nt.transform(wide, flip="x", out=wide),
        lambda: nt.blend(wide, wide, out=wide),
    ):
        with pytest.raises(nt.ArgumentError, match="out: overlaps") as raised:
            call()
        assert raised.value.status == nt.Status.OVERLAP
    pixels = np.zeros((6, 8, 6), np.uint8)
    nt.clean(pixels[..., :3], out=pixels[..., 3:])  # interleaved, but apart
    other = np.zeros((7, 8, 3), np.uint8)
    with pytest.raises(nt.ArgumentError, match="b: must be of the size of a"):
        nt.compare(TEXTURE, other)


def test_vectors_are_floats():
    with pytest.raises(nt.SampleTypeError, match='src: type "vector" needs float32'):
        nt.clean(TEXTURE, type="vector")
    with pytest.raises(nt.SampleTypeError, match="depth=8"):
        nt.convert(TEXTURE, type="standard", to="vector", depth=8)


def test_a_light_from_nowhere():
    with pytest.raises(nt.ArgumentError, match="light"):
        nt.shade(TEXTURE, light=nt.Light(direction=(0, 0, 0)))


def test_statuses_are_those_of_the_headers():
    for status in nt.Status:
        name = "NTP_OK" if status == 0 else f"NTP_ERR_{status.name}"
        assert getattr(lib, name) == status
    for file_status in nt.FileStatus:
        name = "NTPIO_OK" if file_status == 0 else f"NTPIO_ERR_{file_status.name}"
        assert getattr(lib, name) == file_status
    for flag in nt.Flag:
        assert getattr(lib, f"NTP_FLAG_{flag.name}") == flag


def strings_of(function, argument):
    """The strings that the Literal type of an argument holds."""
    hint = typing.get_type_hints(function)[argument]
    found = []

    def walk(part):
        if typing.get_origin(part) is typing.Literal:
            found.extend(a for a in typing.get_args(part) if isinstance(a, str))
        for inner in typing.get_args(part) if typing.get_origin(part) is not typing.Literal else ():
            walk(inner)

    walk(hint)
    return found


LITERALS = [
    (nt.clean, "type", _names.TYPES),
    (nt.convert, "to", _names.MEASURED),
    (nt.convert, "y", _names.YS),
    (nt.convert, "blue", _names.BLUES),
    (nt.clean, "verdict", _names.VERDICTS),
    (nt.heatmap, "palette", _names.PALETTES),
    (nt.Classification, "type", _names.CLASSES),
    (nt.MethodChoice, "method", _names.CLEAN_METHODS),
    (nt.normals_from_height, "kernel", _names.KERNELS),
    (nt.normals_from_height, "border", _names.BORDERS),
    (nt.normals_from_height, "source", _names.SOURCES),
    (nt.normals_from_height, "alpha", _names.ALPHAS),
    (nt.height_from_normals, "kernel", _names.FOUND_KERNELS),
    (nt.height_from_normals, "border", _names.BORDERS),
    (nt.height_from_normals, "method", _names.HEIGHT_METHODS),
    (nt.height_from_normals, "decode", _names.DECODES),
    (nt.height_from_normals, "z", _names.ZS),
    (nt.resize, "filter", _names.FILTERS),
    (nt.blend, "mode", _names.BLEND_MODES),
    (nt.encode_bc5, "quality", _names.BLOCK_QUALITIES),
    (nt.ImageInfo, "format", _names.FILE_FORMATS),
]


# "auto" is found out before C is asked, and programs are other names of a direction.
ASIDE = {"auto", "opengl", "directx"}


@pytest.mark.parametrize(("where", "argument", "table"), LITERALS)
def test_literals_are_the_names_of_the_library(where, argument, table):
    assert set(strings_of(where, argument)) - ASIDE == set(table) - {"auto"}


@pytest.mark.parametrize(
    ("function", "argument", "table"),
    [entry for entry in LITERALS if callable(entry[0]) and not isinstance(entry[0], type)],
)
def test_zero_asks_for_the_default_in_c(function, argument, table):
    """A zero-filled struct of C means what an argument means that is left out."""
    default = inspect.signature(function).parameters[argument].default
    name = OF_NONE.get(argument) if default is None else default
    if name in table:
        assert table[name] == 0
    else:
        assert name == "auto"  # found out before C is asked


# Of `to`: where `type` is told.  Of `source`: a red that is not asked for is looked at first.
OF_NONE = {"alpha": "keep", "to": "standard", "source": "red"}


@pytest.mark.parametrize(
    "name",
    ["clean", "convert", "normals_from_height", "height_from_normals", "read"],
)
def test_with_counts_or_info_takes_the_same_arguments(name):
    other = next(n for n in nt.__all__ if n.startswith(f"{name}_with_"))
    plain, more = (inspect.signature(getattr(nt, n)) for n in (name, other))
    assert plain.parameters == more.parameters


def test_every_string_is_one_of_the_command_line():
    """The help of each verb names the choices; so do the types here."""
    pairs = [
        ("clean", nt.clean, ["type", "method", "verdict"]),
        ("convert", nt.convert, ["type", "y", "to", "to_y"]),
        ("heatmap", nt.heatmap, ["type", "palette"]),
        ("dump", nt.inspect, ["type"]),
        ("diff", nt.compare, ["type"]),
        ("from-height", nt.normals_from_height,
         ["kernel", "border", "source", "dither", "to", "to_y", "blue"]),
        ("to-height", nt.height_from_normals,
         ["type", "y", "kernel", "border", "method", "decode", "z"]),
        ("transform", nt.transform, ["type", "y", "flip"]),
        ("resize", nt.resize, ["type", "filter", "border"]),
        ("blend", nt.blend, ["type", "mode", "y", "detail_y"]),
        ("check", nt.check, ["type", "y", "verdict", "policy"]),
    ]  # fmt: skip
    for verb, function, arguments in pairs:
        text = subprocess.run(
            [nt.program(), verb, "--help"], capture_output=True, text=True, check=True
        ).stdout
        for argument in arguments:
            option = "--" + argument.replace("_", "-")
            listed = re.search(rf"^ +{option} (\S+\|\S+)(?: |$)", text, re.MULTILINE)
            assert listed, (verb, option)
            ours = set(strings_of(function, argument)) - {
                "auto",
                "vector",
                "height",
                "opengl",
                "directx",
            }
            theirs = set(listed[1].split("|")) - {"auto", "height", "opengl", "directx"}
            assert ours == theirs, (verb, option)
            # The default: that of the filter is said in words.
            default = inspect.signature(function).parameters[argument].default
            stated = re.search(r"\(default:\s+(\S+)\)", text[listed.end() :])
            if default is not None and argument != "filter":
                assert stated and stated[1] == default, (verb, option)
