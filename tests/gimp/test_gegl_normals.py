# SPDX-License-Identifier: MIT
"""The operations on normals: shading, transforms, blending, cleaning, conversions, heatmaps."""

import math

import numpy as np
import pytest

from support import libntp_ffi as ffi_lib
from support import pngs
from support.gegl_pictures import DEPTHS, GAMMA, picture, rough_normals, to_options, to_properties


@pytest.mark.parametrize(("channels", "depth"), [(3, 8), (4, 8), (3, 16)])
def test_lit(gegl, ntp, channels, depth):
    """As libntp lights the normals that the program makes."""
    heights = picture(150, 133, channels, depth)
    normals = ntp(heights, "from-height", "--scale", "30", "--to-y", "down")
    around, above = math.radians(20), math.radians(50)
    light = ffi_lib.ffi.new("ntp_light *")
    direction = (math.cos(around) * math.cos(above), math.sin(around) * math.cos(above))
    light.direction = [*direction, math.sin(above)]
    light.ambient, light.diffuse, light.specular, light.color = 0.1, 0.9, 0.2, [0.6] * 3
    expected = np.zeros((*normals.shape[:2], channels), np.uint8)
    source = ffi_lib.view(normals, ffi_lib.STANDARD, ffi_lib.DOWN, const=True)
    picture_of = ffi_lib.view(expected, ffi_lib.HEIGHT)
    ffi_lib.check(ffi_lib.lib.ntp_shade(picture_of, source, light, ffi_lib.ffi.NULL))
    shown = ["show=lit", "light-from=20", "light-height=50"]
    made = gegl(heights, "ntp:normals-from-height", "scale=30", "to-y=down", *shown)
    assert (made == expected.astype(made.dtype) * (1 if depth == 8 else 257)).all()


@pytest.mark.parametrize(
    ("depth", "properties", "options"),
    [
        (8, ["strength=1.7"], ["--strength", "1.7"]),
        (16, ["strength=-0.3", "flip-x=true"], ["--strength", "-0.3", "--flip", "x"]),
        (8, ["flip-y=true"], ["--flip", "y"]),
        (16, ["flip-x=true", "flip-y=true"], ["--rotate", "180"]),
        (8, ["rotate=90", "flip-x=true"], ["--rotate", "90", "--flip", "x"]),
        (16, ["rotate=-90", "flip-y=true"], ["--rotate", "-90", "--flip", "y"]),
        (8, ["rotate=33.3"], ["--rotate", "33.3"]),
        (16, ["rotate=-120.5", "strength=0.7", "flip-x=true"],
         ["--rotate", "-120.5", "--strength", "0.7", "--flip", "x"]),
        (8, ["rotate=200", "border=clamp", "flip-y=true"],
         ["--rotate", "200", "--border", "clamp", "--flip", "y"]),
    ],
)  # fmt: skip
@pytest.mark.parametrize("y", ["up", "down"])
def test_transform(gegl, ntp, depth, properties, options, y):
    normals = rough_normals(4, depth)
    expected = ntp(normals, "transform", "--type", "standard", "--y", y, *options)
    properties = [f"from-y={y}", *properties]
    assert (gegl(normals, "ntp:transform-normals", *properties, threads=4) == expected).all()
    if properties[-1].startswith(("flip", "rotate")):  # a part is that part of the whole
        crop = ["gegl:crop", "x=3", "y=2", "width=9", "height=5"]
        part = gegl(normals, "ntp:transform-normals", *properties, *crop)
        assert (part == expected[2:7, 3:12]).all()


@pytest.mark.parametrize(
    ("mode", "depth"), [("rnm", 8), ("whiteout", 16), ("linear", 8), ("rnm", 16)]
)
def test_blend(gegl, run, tmp_path, mode, depth):
    """The detail is at the pad aux; where it ends the base stays."""
    base = rough_normals(3, depth)
    detail = np.ascontiguousarray(rough_normals(3, depth)[::-1, ::-1])
    pngs.write_png(tmp_path / "base.png", base)
    pngs.write_png(tmp_path / "detail.png", detail)
    told = [
        "--mode",
        mode,
        "--strength",
        "0.6",
        "--type",
        "standard",
        "--y",
        "up",
        "--detail-y",
        "up",
    ]
    done = run("blend", "base.png", "detail.png", "-o", "blended.png", "-q", *told)
    assert done.returncode == 0, done.stderr
    expected = pngs.read_png(tmp_path / "blended.png")[0]
    aux = ["aux=[", "gegl:png-load", "path=detail.png", "]"]
    operation = ["ntp:blend-normals", f"mode={mode}", "strength=0.6", *aux]
    assert (gegl(base, *operation) == expected).all()
    file = ["ntp:blend-normals-file", f"mode={mode}", "strength=0.6", "path=detail.png"]
    assert (gegl(base, *file, threads=2) == expected).all()
    assert (gegl(base, "ntp:blend-normals") == base).all()
    assert (gegl(base, "ntp:blend-normals-file", "path=none.png") == base).all()
    small = ["aux=[", "gegl:png-load", "path=detail.png", "gegl:crop", "width=20", "height=9", "]"]
    expected[9:], expected[:, 20:] = base[9:], base[:, 20:]
    operation = ["ntp:blend-normals", f"mode={mode}", "strength=0.6", *small]
    assert (gegl(base, *operation) == expected).all()
    faded = np.dstack([detail, np.arange(detail[..., 0].size).reshape(detail.shape[:2])])
    pngs.write_png(tmp_path / "detail.png", faded.astype(detail.dtype))
    told += ["--detail-alpha"]
    done = run("blend", "base.png", "detail.png", "-o", "blended.png", "-q", *told)
    assert done.returncode == 0, done.stderr
    expected = pngs.read_png(tmp_path / "blended.png")[0]
    operation = ["ntp:blend-normals", f"mode={mode}", "strength=0.6", "detail-alpha=true", *aux]
    assert (gegl(base, *operation) == expected).all()


CLEANING = [
    ({}, {}),
    ({"repair": "normalize"}, {"method": "normalize"}),
    ({"keep-negative-z": True}, {"keep-negative-z": True}),
    ({"touch-unused": True}, {"touch-unused": True}),
    ({"only-failing": True, "verdict": "rounded"}, {"only-failing": True, "verdict": "rounded"}),
    ({"from": "zzero", "to": "zzero"}, {"type": "zzero"}),
    ({"from": "xy", "to": "xy"}, {"type": "xy"}),
]


@pytest.mark.parametrize("chunks", [(), (GAMMA,)], ids=["plain", "gAMA"])
@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("properties, options", CLEANING)
def test_clean(gegl, ntp, properties, options, channels, depth, chunks):
    normals = rough_normals(channels, depth)
    options = {"type": "standard", "method": "derive", **options}
    expected = ntp(normals, "clean", *to_options(options))
    made = gegl(normals, "ntp:clean-normals", *to_properties(properties), chunks=chunks)
    assert (made == expected).all()


CONVERSIONS = [
    {"to": "zzero"},
    {"to-y": "down"},
    {"from": "zzero", "to": "standard", "from-y": "down"},
    {"to": "xy", "from-y": "down", "to-y": "down"},
]


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("settings", CONVERSIONS, ids=lambda s: "-".join(s.values()))
def test_convert(gegl, ntp, settings, depth):
    normals = rough_normals(4, depth)
    # The operation does not look at the layer; the program would.
    told = {"from": "standard", "from-y": "up", **settings}
    expected = ntp(normals, "convert", *to_options(told))
    made = gegl(normals, "ntp:clean-normals", "repair=none", *to_properties(settings))
    assert (made == expected).all()
    cleaned = ntp(normals, "clean", "--type", told["from"], "--method", "derive")
    expected = ntp(cleaned, "convert", *to_options(told))
    made = gegl(normals, "ntp:clean-normals", *to_properties(settings))
    assert (made == expected).all()


@pytest.mark.parametrize("palette", ["reference", "safe"])
@pytest.mark.parametrize("depth", DEPTHS)
def test_heatmap(gegl, ntp, depth, palette):
    normals = rough_normals(3, depth)
    show = "heatmap" if palette == "reference" else "heatmap-safe"
    expected = ntp(normals, "heatmap", "--type", "standard", "--palette", palette)[:, :, :3]
    assert expected.dtype == np.uint8
    made = gegl(normals, "ntp:clean-normals", f"show={show}")
    assert (made == expected.astype(made.dtype) * (1 if depth == 8 else 257)).all()
