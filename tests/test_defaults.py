# SPDX-License-Identifier: MIT
"""Each option has the same default in C (a zero-filled struct), in Python and on the command line.

Python is read as source: this needs no package that was built.
"""

import ast
import re
import subprocess

import pytest

from support import libntp_ffi as ntp

PACKAGE = ntp.ROOT / "bindings" / "python" / "normaltexture"

# Each choice of the command line, with Python's argument, and the member of a struct of C; None:
# there is none, or its zero is another choice ("auto" is found out by the program, not by C).
CHOICES = {
    "check": ("check", None),
    "clean": ("clean", "ntp_clean_options"),
    "convert": ("convert", "ntp_convert_options"),
    "heatmap": ("heatmap", None),
    "from-height": ("normals_from_height", "ntp_normals_options"),
    "to-height": ("height_from_normals", "ntp_height_options"),
    "to-depth": ("depth_from_normals", "ntp_depth_options"),
    "resize": ("resize", "ntp_resize_options"),
    "transform": ("transform", "ntp_transform_options"),
    "blend": ("blend", "ntp_blend_options"),
    "curvature": ("curvature", "ntp_curvature_options"),
    "occlusion": ("occlusion", "ntp_occlusion_options"),
}
ROWS = [
    ("check", "verdict", "verdict", "ntp_verdict"),
    ("check", "policy", "policy", None),
    ("check", "max-angle", "max_angle", None),
    ("check", "max-fail", "max_fail", None),
    ("check", "max-tilt", "max_tilt", None),
    ("clean", "method", "method", None),
    ("clean", "verdict", "verdict", "verdict"),
    ("clean", "keep-negative-z", "keep_negative_z", "keep_negative_z"),
    ("clean", "only-failing", "only_failing", "only_failing"),
    ("clean", "touch-unused", "touch_unused", "touch_unused"),
    ("clean", "type", "type", None),
    ("clean", "undo", "undo", None),
    ("convert", "to", "to", None),
    ("convert", "to-y", "to_y", None),
    ("convert", "depth", "depth", None),
    ("heatmap", "palette", "palette", "ntp_palette"),
    ("from-height", "kernel", "kernel", "kernel"),
    ("from-height", "border", "border", "border_x"),
    ("from-height", "border", "border", "border_y"),
    ("from-height", "border-x", "border_x", None),
    ("from-height", "source", "source", "source"),
    ("from-height", "blue", "blue", "blue"),
    ("from-height", "alpha", "alpha", "alpha"),
    ("from-height", "invert", "invert", "invert"),
    ("from-height", "min-z", "min_z", "min_z"),
    ("from-height", "dx", "dx", "dx"),
    ("from-height", "dy", "dy", "dy"),
    ("from-height", "dither", "dither", None),
    ("from-height", "to", "to", "ntp_encoding"),
    ("from-height", "to-y", "to_y", "ntp_y"),
    ("from-height", "depth", "depth", None),
    ("to-height", "method", "method", "method"),
    ("to-height", "decode", "decode", "decode"),
    ("to-height", "z", "z", "z"),
    ("to-height", "refine", "refine", "refine"),
    ("to-height", "detrend", "detrend", "detrend"),
    ("to-height", "clip", "clip", None),
    ("to-height", "equalize", "equalize", "equalize"),
    ("to-height", "dx", "dx", "dx"),
    ("to-height", "dy", "dy", "dy"),
    ("to-height", "kernel", "kernel", None),
    ("to-height", "border", "border", None),
    ("to-height", "mask", "mask", "mask"),
    ("to-depth", "type", "type", None),
    ("to-depth", "y", "y", None),
    ("to-depth", "k", "k", None),
    ("to-depth", "rounds", "rounds", None),
    ("resize", "filter", "filter", "filter"),
    ("resize", "border", "border", "border_x"),
    ("resize", "border", "border", "border_y"),
    ("resize", "touch-unused", "touch_unused", "touch_unused"),
    ("transform", "rotate", "rotate", "angle"),
    ("transform", "border", "border", "border_x"),
    ("transform", "border", "border", "border_y"),
    ("curvature", "kind", "kind", "kind"),
    ("curvature", "range", "range", "range"),
    ("curvature", "border", "border", None),
    ("curvature", "source", "source", "ntp_height_source"),
    ("curvature", "blur", "blur", None),
    ("occlusion", "radius", "radius", "radius"),
    ("occlusion", "border", "border", None),
    ("occlusion", "depth", "depth", None),
    ("blend", "mode", "mode", "mode"),
    ("blend", "detail-alpha", "detail_alpha", "detail_alpha"),
    ("blend", "touch-unused", "touch_unused", "touch_unused"),
]
STANDS_FOR = {"dx": "1", "dy": "1"}  # what 0 stands for, as libntp.h says
NOTHING = ("None", "False", "0")


@pytest.fixture(scope="module")
def helps(program):
    """The text about each option, by verb and option."""
    found = {}
    for verb in CHOICES:
        done = subprocess.run([program, verb, "--help"], capture_output=True, text=True, check=True)
        options = done.stdout.partition("Options:\n")[2]
        for text in re.split(r"\n(?=  (?:-\w,|   ) --)", "\n" + options):
            words = " ".join(text.split())
            name = re.match(r"(?:-\w, )?--([a-z-]+)", words)
            if name:
                found[verb, name[1]] = words
    return found


def command_line(text):
    """The default that a help text names; "None": it names none."""
    plain = re.search(r"\(default: ([^()]+)\)", text)
    if plain:
        return plain[1]
    unless = re.search(r"Default: \w+ with --\w+, else (\w+)", text)
    return unless[1] if unless else "None"


def signatures():
    """{function: {argument: default as text}} of what Python offers; overloads say less."""
    found = {}
    for path in sorted(PACKAGE.glob("_*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if not isinstance(node, ast.FunctionDef) or node.name.startswith("_"):
                continue
            if any(getattr(d, "id", "") == "overload" for d in node.decorator_list):
                continue
            given = zip(node.args.kwonlyargs, node.args.kw_defaults, strict=True)
            found[node.name] = {a.arg: ast.unparse(v) for a, v in given if v is not None}
    return found


def in_python(default):
    value = ast.literal_eval(default)
    return f"{value:g}" if isinstance(value, float) else str(value)


def in_c(struct, member):
    """What zero means: an enumerator's last words, a number, or nothing."""
    if member.startswith("ntp_"):
        kind = ntp.ffi.typeof(member)
    else:
        kind = dict(ntp.ffi.typeof(struct).fields)[member].type
    if kind.kind != "enum":
        return STANDS_FOR.get(member, "0" if kind.kind == "primitive" else "None")
    names = kind.elements.values()
    common = min(len(words) for words in ([n.split("_") for n in names]))
    parts = [n.split("_") for n in names]
    shared = next(i for i in range(common) if len({tuple(p[: i + 1]) for p in parts}) > 1)
    return "-".join(kind.elements[0].split("_")[shared:]).lower()


@pytest.mark.parametrize("verb, option, argument, member", ROWS)
def test_defaults_are_one(helps, verb, option, argument, member):
    function, struct = CHOICES[verb]
    said = command_line(helps[verb, option])
    python = in_python(signatures()[function][argument])
    both = {said, python}
    if member is not None:
        both.add(in_c(struct, member))
    # None is the first choice where a choice that is given means more than the same by default.
    if both <= set(NOTHING) or (argument in ("alpha", "source") and python == "None"):
        both -= set(NOTHING)
    assert len(both) <= 1, (said, python, both)


def test_zero_is_a_choice():
    """Every enum of the options has a zero."""
    for _, struct in CHOICES.values():
        members = ntp.ffi.typeof(struct).fields if struct else []
        for name, field in members:
            assert field.type.kind != "enum" or 0 in field.type.elements, (struct, name)
