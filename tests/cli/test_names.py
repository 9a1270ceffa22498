# SPDX-License-Identifier: MIT
"""The words that options take, against the values of libntp.h that they stand for."""

import json
import re

import numpy as np
import pytest

from support import textures
from support.libntp_ffi import ffi, lib
from support.pngs import write_png

SYNONYMS = {"opengl": "up", "directx": "down"}


def words(run, verb, option):
    """The choices of an option, as --help lists them."""
    found = re.search(rf"--{option} ([a-z0-9-]+(?:\|[a-z0-9-]+)+)", run(verb, "--help").stdout)
    return [word for word in found[1].split("|") if word not in SYNONYMS]


def enumerators(kind):
    """The values of an enumeration, in order, in the words of an option: NTP_KERNEL_SOBEL3 is sobel3."""
    elements = ffi.typeof(kind).elements
    assert sorted(elements) == list(range(len(elements)))
    names = [elements[i] for i in range(len(elements))]
    prefix = "NTP_HEIGHT_" if kind == "ntp_height_method" else f"{kind.upper()}_"
    prefix = {"ntp_blend_mode": "NTP_BLEND_", "ntp_curvature_kind": "NTP_CURVATURE_"}.get(
        kind, prefix
    )
    assert all(name.startswith(prefix) for name in names)
    spelled = {"trunc": "unorm-trunc", "snorm": "snorm128"} if kind == "ntp_decode" else {}
    values = [name[len(prefix) :].lower().replace("_", "-") for name in names]
    return [spelled.get(value, value) for value in values]


@pytest.mark.parametrize(
    "verb,option,kind,before",
    [
        ("check", "type", "ntp_class", ["auto"]),
        ("check", "verdict", "ntp_verdict", []),
        ("convert", "type", "ntp_class", ["auto"]),
        ("convert", "to-y", "ntp_y", []),
        ("heatmap", "palette", "ntp_palette", []),
        ("blend", "mode", "ntp_blend_mode", []),
        ("from-height", "kernel", "ntp_kernel", []),
        ("from-height", "border", "ntp_border", []),
        ("from-height", "source", "ntp_height_source", []),
        ("from-height", "blue", "ntp_blue", []),
        ("to-height", "type", "ntp_encoding", ["auto"]),
        ("to-height", "kernel", "ntp_kernel", ["auto"]),
        ("to-height", "border", "ntp_border", ["auto"]),
        ("to-height", "method", "ntp_height_method", []),
        ("to-height", "decode", "ntp_decode", []),
        ("to-height", "z", "ntp_z", []),
        ("resize", "border", "ntp_border", []),
        ("curvature", "kind", "ntp_curvature_kind", []),
        ("curvature", "border", "ntp_border", ["auto"]),
        ("occlusion", "source", "ntp_height_source", []),
    ],
)
def test_words_are_enumerators(run, verb, option, kind, before):
    """A choice stands for the value of its place: a verb may leave out the last ones only."""
    choices = words(run, verb, option)
    assert choices[: len(before)] == before
    choices = choices[len(before) :]
    assert choices == enumerators(kind)[: len(choices)]


@pytest.mark.parametrize(
    "verb,option,name_of",
    [
        ("from-height", "kernel", "ntp_kernel_name"),
        ("to-height", "kernel", "ntp_kernel_name"),
        ("from-height", "border", "ntp_border_name"),
        ("to-height", "method", "ntp_height_method_name"),
        ("blend", "mode", "ntp_blend_mode_name"),
        ("resize", "filter", "ntp_filter_name"),
    ],
)
def test_words_are_names(run, verb, option, name_of):
    kind = name_of.removesuffix("_name")
    names = {ffi.string(getattr(lib, name_of)(i)).decode() for i in ffi.typeof(kind).elements}
    assert set(words(run, verb, option)) - {"auto"} <= names
    assert names - set(words(run, verb, option)) <= {"auto", "baked"}


@pytest.mark.parametrize(
    "verb,option,key",
    [
        ("convert", "type", "from"),
        ("convert", "to", "to"),
        ("convert", "to-y", "to_y"),
        ("clean", "method", "method"),
        ("heatmap", "palette", "palette"),
        ("resize", "filter", "filter"),
        ("resize", "border", "border_y"),
        ("from-height", "source", "source"),
        ("from-height", "to", "to"),
        ("from-height", "to-y", "to_y"),
        ("from-height", "kernel", "kernel"),
        ("from-height", "border", "border_x"),
        ("from-height", "blue", "blue"),
        ("to-height", "decode", "decode"),
        ("to-height", "z", "z"),
        ("to-height", "y", "y"),
        ("to-height", "type", "from"),
        ("curvature", "kind", "kind"),
        ("curvature", "border", "border_x"),
        ("occlusion", "y", "y"),
    ],
)
def test_reports_say_what_was_given(run, tmp_path, verb, option, key):
    rgba = np.dstack([textures.standard(16, 16), np.full((16, 16), 255, np.uint8)])
    write_png(tmp_path / "a.png", rgba)
    more = {
        "resize": ["--size", "8x8"],
        "from-height": ["--scale", "2", "--force"],  # of what are normals
        "to-height": [] if option == "y" else ["--y", "up"],
        "curvature": ["--y", "up"],
        "convert": ["--y", "up"] if option == "to-y" else [],
    }.get(verb, [])
    for word in words(run, verb, option):
        if word == "auto" or (option == "type" and word == "height"):
            continue
        done = run(verb, "a.png", "-o", "b.png", *more, f"--{option}", word, "--format", "json")
        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)["files"][0][key] == word


@pytest.mark.parametrize("synonym", SYNONYMS)
@pytest.mark.parametrize(
    "verb,option,key", [("convert", "to-y", "to_y"), ("from-height", "to-y", "to_y"),
                        ("to-height", "y", "y")]
)  # fmt: skip
def test_green_by_the_names_of_programs(run, tmp_path, verb, option, key, synonym):
    write_png(tmp_path / "a.png", textures.standard(16, 16))
    more = {"from-height": ["--scale", "2", "--force"], "convert": ["--y", "up"]}.get(verb, [])
    done = run(verb, "a.png", "-o", "b.png", *more, f"--{option}", synonym, "--format", "json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["files"][0][key] == SYNONYMS[synonym]


VERBS = ["check", "clean", "convert", "heatmap", "dump", "diff", "transform", "resize", "blend",
         "to-height", "curvature", "occlusion"]  # fmt: skip


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_takes_type_and_y(run, verb):
    for option in ("type", "y"):
        assert {"auto", "standard", "up"} & set(words(run, verb, option)), option


@pytest.mark.parametrize("verb", ["convert", "to-height"])
def test_older_names_are_accepted_and_not_shown(run, tmp_path, verb):
    write_png(tmp_path / "a.png", textures.standard(16, 16))
    for older, newer, word in (("from", "type", "standard"), ("from-y", "y", "down")):
        for name in (older, newer):
            green = ["--y", "up"] if older == "from" else []
            done = run(verb, "a.png", "-o", f"{name}.png", f"--{name}", word, *green)
            assert done.returncode == 0, done.stderr
        both = [(tmp_path / f"{name}.png").read_bytes() for name in (older, newer)]
        assert both[0] == both[1]
        assert f"--{older} " not in run(verb, "--help").stdout


@pytest.mark.parametrize(
    "args,hint",
    [
        (["resize", "a.png", "-o", "b.png", "--size", "512"], "--size 512x512, or percent"),
        (["from-height", "a.png", "-o", "b.png", "--scale", "1", "--kernel", "sobel"],
         "did you mean sobel3 or sobel5?"),
        (["check", "a.png", "--y", "OpenGL"], "did you mean opengl?"),
        (["to-height", "a.png", "-o", "b.png", "--method", "poisson"],
         "did you mean poisson-dct?"),
    ],
)  # fmt: skip
def test_wrong_values_are_met_with_a_hint(run, args, hint):
    done = run(*args)
    assert done.returncode == 2 and hint in done.stderr
