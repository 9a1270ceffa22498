# SPDX-License-Identifier: MIT
"""Errors: of the right builtin kind, with the status of the library, naming argument and value."""

import inspect
import re
import subprocess
import typing

import numpy as np
import pytest

import normaltexture as nt
from normaltexture._native import ffi, lib

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
    "height_from_normals": lambda **how: nt.height_from_normals(TEXTURE, **how),
    "detect_orientation": lambda **how: nt.detect_orientation(TEXTURE, **how),
}

WRONG = [
    ("clean", {"type": "height"}),
    ("clean", {"method": "newest"}),
    ("clean", {"verdict": 1}),
    ("clean", {"threads": -1}),
    ("clean", {"threads": 1.5}),
    ("convert", {"from_": "auto"}),
    ("convert", {"to_y": "left"}),
    ("convert", {"depth": 12}),
    ("convert", {"blue": None}),
    ("encode", {"to": "vectors"}),
    ("validate", {"type": []}),
    ("measure", {"type": "STANDARD"}),
    ("heatmap", {"palette": "pink"}),
    ("shade", {"y": 0}),
    ("compare", {"b_type": "zz"}),
    ("compare", {"b_y": "zz"}),
    ("resize", {"size": "50"}),
    ("resize", {"size": (0, 4)}),
    ("resize", {"size": (70000, 4)}),
    ("resize", {"size": 7}),
    ("resize", {"filter": "cubic"}),
    ("resize", {"border": "extrapolate"}),
    ("resize", {"border_x": "none"}),
    ("transform", {"rotate": 45}),
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
    ("normals_from_height", {"blur": 65}),
    ("normals_from_height", {"octaves": []}),
    ("normals_from_height", {"like": "reference:1"}),
    ("height_from_normals", {"method": "best"}),
    ("height_from_normals", {"decode": "snorm"}),
    ("height_from_normals", {"seeds": [1, 2, 3]}),
    ("height_from_normals", {"refine": -1}),
    ("height_from_normals", {"mask": np.zeros((2, 2), np.uint8)}),
    ("detect_orientation", {"type": None}),
]


@pytest.mark.parametrize(("name", "how"), WRONG, ids=[f"{n}-{next(iter(h))}" for n, h in WRONG])
def test_wrong_values_are_named(name, how):
    argument, value = next(iter(how.items()))
    with pytest.raises(nt.ArgumentError) as raised:
        CALLS[name](**how)
    assert isinstance(raised.value, ValueError)
    assert isinstance(raised.value, nt.NormalTextureError)
    message = str(raised.value)
    assert argument in message or argument == "like"
    if not isinstance(value, np.ndarray):
        assert repr(value) in message or argument == "like"
    assert isinstance(raised.value.status, nt.Status)


@pytest.mark.parametrize("name", CALLS)
def test_everything_but_the_data_is_keyword_only(name):
    parameters = list(inspect.signature(getattr(nt, name)).parameters.values())
    data = 2 if name in ("compare", "blend") else 1
    kinds = [p.kind for p in parameters]
    assert kinds[:data] == [inspect.Parameter.POSITIONAL_OR_KEYWORD] * data
    assert set(kinds[data:]) == {inspect.Parameter.KEYWORD_ONLY}


@pytest.mark.parametrize("dtype", [np.float64, np.float16, np.int32, np.int8, bool, object, "S1"])
def test_sample_types(dtype):
    with pytest.raises(nt.SampleTypeError, match="src: samples must be uint8, uint16") as raised:
        nt.clean(np.zeros((2, 2, 3), dtype))
    assert isinstance(raised.value, TypeError)
    assert raised.value.status == nt.Status.FORMAT
    assert ("astype" in str(raised.value)) == (np.dtype(dtype).kind == "f")


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
        nt.convert(TEXTURE, to="vector", depth=8)


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
        assert getattr(lib, f"NTP_{flag.name}") == flag


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


@pytest.mark.parametrize(
    ("function", "argument", "names"),
    [
        (nt.normals_from_height, "kernel", lib.ntp_kernel_name),
        (nt.normals_from_height, "border", lib.ntp_border_name),
        (nt.height_from_normals, "method", lib.ntp_height_method_name),
        (nt.resize, "filter", lib.ntp_filter_name),
        (nt.blend, "mode", lib.ntp_blend_mode_name),
    ],
)
def test_strings_are_in_the_order_of_the_header(function, argument, names):
    for code, name in enumerate(strings_of(function, argument)):
        if name != "auto":
            assert ffi.string(names(code)).decode() == name


def test_every_string_is_one_of_the_command_line():
    """The help of each verb names the choices; so do the types here."""
    pairs = [
        ("clean", nt.clean, ["type", "method", "verdict"]),
        ("convert", nt.convert, ["from_y", "to_y"]),
        ("heatmap", nt.heatmap, ["palette"]),
        ("from-height", nt.normals_from_height,
         ["kernel", "border", "source", "dither", "to_y", "blue"]),
        ("to-height", nt.height_from_normals,
         ["kernel", "border", "method", "decode", "z", "from_y"]),
        ("transform", nt.transform, ["flip"]),
        ("resize", nt.resize, ["filter", "border"]),
        ("blend", nt.blend, ["mode", "y", "detail_y"]),
        ("check", nt.check, ["type", "y", "verdict"]),
    ]  # fmt: skip
    for verb, function, arguments in pairs:
        text = subprocess.run(
            [nt.program(), verb, "--help"], capture_output=True, text=True, check=True
        ).stdout
        for argument in arguments:
            option = "--" + argument.rstrip("_").replace("_", "-")
            listed = re.search(rf"^ +{option} (\S+\|\S+)(?: |$)", text, re.MULTILINE)
            assert listed, (verb, option)
            ours = set(strings_of(function, argument)) - {"auto", "vector"}
            theirs = set(listed[1].split("|")) - {"auto", "height"}
            if verb == "check":
                theirs = set(listed[1].split("|")) - {"auto"}
            assert ours == theirs, (verb, option)
            # The default.  Arrays are not guessed at, None stands for what `like` may set, and the
            # default filter is said in words.
            default = inspect.signature(function).parameters[argument].default
            stated = re.search(r"\(default:\s+(\S+)\)", text[listed.end() :])
            if default is not None and argument not in ("type", "filter"):
                assert stated and stated[1] == default, (verb, option)
