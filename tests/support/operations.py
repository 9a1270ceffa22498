# SPDX-License-Identifier: MIT
"""Every operation for GIMP, and the verb of `ntp` that must make the same texels.

A row is (name, picture, operation, properties, make), where make(ntp, pixels, detail) makes what is
expected: ntp(pixels, verb, option...) runs the program.
"""

import math
import subprocess

import numpy as np

from . import libntp_ffi, pngs
from .libntp_ffi import ffi, lib
from .plugin_cases import GAMMA

WIDTH, HEIGHT = 61, 47  # no multiple of a tile or a vector
FROM_HEIGHT, CLEAN = "ntp:normals-from-height", "ntp:clean-normals"
TRANSFORM, CURVATURE = "ntp:transform-normals", "ntp:curvature"
OCCLUSION, BLEND, BLEND_FILE = (
    "ntp:ambient-occlusion",
    "ntp:blend-normals",
    "ntp:blend-normals-file",
)
STANDARD = "--type", "standard"
UP = *STANDARD, "--y", "up"
DOWN = *STANDARD, "--y", "down"


def heights(channels, depth):
    """Waves in each channel, which tile, with noise on top; every kind of alpha, three rows without."""
    rng = np.random.default_rng(8)
    y, x = np.mgrid[:HEIGHT, :WIDTH] * (2 * np.pi / np.array([[[HEIGHT]], [[WIDTH]]]))
    waves = [np.sin((2 + c) * x + c) * np.cos((4 - c) * y) for c in range(channels)]
    unit = np.stack(waves, 2) * 0.44 + 0.5 + rng.normal(0, 0.012, (HEIGHT, WIDTH, channels))
    if channels in (2, 4):
        unit[20:23, ..., -1] = 0
    top = 2**depth - 1
    return (unit.clip(0, 1) * top + 0.5).astype(np.uint8 if depth == 8 else np.uint16)


def normals(channels, depth):
    """Normals of waves that tile (green up), truncated; wrong, black and white ones among them."""
    rng = np.random.default_rng(4)
    y, x = np.mgrid[:HEIGHT, :WIDTH] * (2 * np.pi / np.array([[[HEIGHT]], [[WIDTH]]]))
    p, q = 1.2 * np.cos(2 * x) * np.sin(3 * y), -1.4 * np.sin(2 * x) * np.cos(3 * y)
    n = np.stack([-p, -q, np.ones_like(p)], 2) / np.sqrt(1 + p * p + q * q)[..., None]
    top = 2**depth - 1
    made = np.full((HEIGHT, WIDTH, channels), top, np.uint8 if depth == 8 else np.uint16)
    made[..., :3] = (n + 1) / 2 * top
    wrong = rng.random((HEIGHT, WIDTH)) < 0.1
    made[wrong, :3] = rng.integers(0, top, (wrong.sum(), 3), endpoint=True)
    made[5, :9], made[6, 3:9] = 0, top
    if channels == 4:
        made[..., 3] = rng.integers(0, top, (HEIGHT, WIDTH), endpoint=True)
        made[30:33, :, 3] = 0
    return made


def cut(channels, depth):
    """A part of long waves, which does not tile."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    waves = [np.sin(x / (17 + 3 * c) + 0.7) * np.cos(y / 21 + c) for c in range(channels)]
    top = 2**depth - 1
    made = (np.stack(waves, 2) * 0.45 + 0.5) * top + 0.5
    return made.astype(np.uint8 if depth == 8 else np.uint16)


def detail_of(pixels):
    """Other normals to blend with these; where there is an alpha it is of every kind."""
    made = np.ascontiguousarray(pixels[::-1, ::-1])
    if made.shape[2] == 4:
        made[..., 3] = np.linspace(0, np.iinfo(made.dtype).max, WIDTH).astype(made.dtype)
    return made


def verb(name, *options):
    return lambda ntp, pixels, _: ntp(pixels, name, *options)


def gray(name, *options):
    """A gray map; GIMP keeps the alpha of the layer."""

    def make(ntp, pixels, _):
        made = np.repeat(ntp(pixels, name, *options)[..., :1], pixels.shape[2], 2)
        made[..., 3:] = pixels[..., 3:]
        return made

    return make


def blended(*options):
    told = *UP, *([] if "--detail-y" in options else ["--detail-y", "up"]), *options
    return lambda ntp, pixels, detail: ntp(pixels, "blend", *told, detail=detail)


def converted(*options):
    def make(ntp, pixels, _):
        cleaned = ntp(pixels, "clean", *STANDARD, "--method", "derive")
        return ntp(cleaned, "convert", "--from", "standard", "--from-y", "up", *options)

    return make


def colored(palette):
    """The heatmap has 8 bits and no alpha; GIMP shows it in what the layer has."""

    def make(ntp, pixels, _):
        made = np.full_like(pixels, np.iinfo(pixels.dtype).max)
        map_ = ntp(pixels, "heatmap", *STANDARD, "--palette", palette)
        made[..., : map_.shape[2]] = map_ * pixels.dtype.type(1 if pixels.itemsize == 1 else 257)
        return made

    return make


def lit(*, around, above, make=None, y=libntp_ffi.UP):
    """No verb lights a surface: as libntp lights the normals."""

    def shade(ntp, pixels, detail):
        seen = np.ascontiguousarray(pixels if make is None else make(ntp, pixels, detail))
        a, b = math.radians(around), math.radians(above)
        light = ffi.new("ntp_light *")
        light.direction = [math.cos(a) * math.cos(b), math.sin(a) * math.cos(b), math.sin(b)]
        light.ambient, light.diffuse, light.specular, light.color = 0.1, 0.9, 0.2, [0.6] * 3
        shown = np.zeros(seen.shape, np.uint8)
        source = libntp_ffi.view(seen, libntp_ffi.STANDARD, y, const=True)
        picture = libntp_ffi.view(shown, libntp_ffi.HEIGHT)
        libntp_ffi.check(lib.ntp_shade(picture, source, light, ffi.NULL))
        return shown * pixels.dtype.type(1 if pixels.itemsize == 1 else 257)

    return shade


def labpbr(ntp, pixels, _):
    ao = ntp(pixels, "occlusion", "--type", "height", "--scale", "7.3", "--border", "wrap")
    words = ["--to-y", "down", "--to", "xy", "--alpha", "height", "--scale", "7.3"]
    return ntp(pixels, "from-height", *words, side=("--ao", ao))[..., : pixels.shape[2]]


SOBEL = "--scale", "7.3", "--kernel", "sobel3", "--to-y", "down"
SOBEL_SET = {"scale": 7.3, "kernel": "sobel3", "to-y": "down"}
FORMS = {"scale": 7.3, "blur": 1.5, "small": 0.5, "middle": 2, "large": 1.25}
FORMS_TOLD = "--scale", "7.3", "--blur", "1.5", "--octaves", "0.5,0,1.5,0,-0.75"
DITHER = {"scale": 2.5, "dither": "integrable"}

# What README.md says of each preset, as options of `ntp from-height`; the properties that it decides
# are set to something else before.  LabPBR has a row of its own; GIMP's filter takes a luminance,
# which no verb has.
PRESET_SET = {"scale": 7.3, "kernel": "sobel3", "to": "zzero", "channels": "zyx"}
WORDS = "--scale", "7.3", "--kernel", "sobel3", "--to", "standard", "--to-y"
PRESETS = {
    "unreal": (*WORDS, "down"),
    "unity": (*WORDS, "up"),
    "godot": (*WORDS, "up"),
    "source": (*WORDS, "down"),
    "gimp-normalmap": ("--like", "gimp-normalmap:sobel3:7.3"),
}

ROWS = [
    ("from height", heights, FROM_HEIGHT, SOBEL_SET, verb("from-height", *SOBEL)),
    ("forms", heights, FROM_HEIGHT, FORMS, verb("from-height", *FORMS_TOLD)),
    ("dither", heights, FROM_HEIGHT, DITHER,
     verb("from-height", "--scale", "2.5", "--dither", "integrable")),
    ("auto scale", heights, FROM_HEIGHT, {"strength": 0.3},
     verb("from-height", "--scale", "auto", "--strength", "0.3")),
    ("LabPBR", heights, FROM_HEIGHT, {"scale": 7.3, "preset": "labpbr", "occlusion": True}, labpbr),
    *((f"preset {name}", heights, FROM_HEIGHT, {**PRESET_SET, "preset": name},
       verb("from-height", *words))
      for name, words in PRESETS.items()),
    ("lit heights", heights, FROM_HEIGHT,
     {**SOBEL_SET, "show": "lit", "light-from": 20.0, "light-height": 50.0},
     lit(around=20, above=50, make=verb("from-height", *SOBEL), y=libntp_ffi.DOWN)),
    *((f"{kind} of heights", heights, CURVATURE,
       {"from": "height", "scale": 7.3, "kind": kind, "range": 0.3, "border": border},
       gray("curvature", "--type", "height", "--scale", "7.3", "--kind", kind, "--range", "0.3",
            "--border", border))
      for kind, border in (("mean", "wrap"), ("gaussian", "clamp"), ("convex", "clamp"),
                           ("cavity", "wrap"))),
    ("occlusion", heights, OCCLUSION, {"scale": 20.0, "border": "wrap"},
     gray("occlusion", "--type", "height", "--scale", "20", "--border", "wrap")),
    ("occlusion near", heights, OCCLUSION, {"scale": 20.0, "radius": 9.0, "border": "clamp"},
     gray("occlusion", "--type", "height", "--scale", "20", "--radius", "9", "--border", "clamp")),
    *((f"{verb_} of {picture.__name__} as edges show", picture, operation,
       {"scale": 20.0, **({"from": "height"} if verb_ == "curvature" else {}), **settings},
       gray(verb_, "--type", "height", "--scale", "20", *options))
      for picture in (heights, cut)
      for verb_, operation, settings, options in (
          ("curvature", CURVATURE, {"range": 0.3}, ["--range", "0.3"]),
          ("occlusion", OCCLUSION, {}, []),
      )),
    ("occlusion of normals", normals, OCCLUSION, {"from": "normals"}, gray("occlusion", *UP)),
    ("occlusion of normals that wrap", normals, OCCLUSION,
     {"from": "normals", "from-y": "down", "border": "wrap", "radius": 12.0},
     gray("occlusion", *DOWN, "--border", "wrap", "--radius", "12")),
    ("curvature of normals as edges show", normals, CURVATURE, {"range": 0.3},
     gray("curvature", *UP, "--range", "0.3")),
    ("clean", normals, CLEAN, {}, verb("clean", *STANDARD, "--method", "derive")),
    ("normalize", normals, CLEAN, {"repair": "normalize"},
     verb("clean", *STANDARD, "--method", "normalize")),
    ("failing", normals, CLEAN, {"only-failing": True, "verdict": "rounded"},
     verb("clean", *STANDARD, "--method", "derive", "--only-failing", "--verdict", "rounded")),
    ("Z-zero", normals, CLEAN, {"to": "zzero", "to-y": "down"},
     converted("--to", "zzero", "--to-y", "down")),
    ("x and y", normals, CLEAN, {"to": "xy"}, converted("--to", "xy")),
    ("heatmap", normals, CLEAN, {"show": "heatmap"}, colored("reference")),
    ("heatmap safe", normals, CLEAN, {"show": "heatmap-safe"}, colored("safe")),
    ("strong", normals, TRANSFORM, {"strength": 1.7}, verb("transform", *UP, "--strength", "1.7")),
    ("turn", normals, TRANSFORM, {"rotate": 33.3, "strength": -0.5, "from-y": "down"},
     verb("transform", *DOWN, "--rotate", "33.3", "--strength", "-0.5")),
    ("turn and flip", normals, TRANSFORM, {"rotate": 180.0, "flip-y": True, "border": "clamp"},
     verb("transform", *UP, "--rotate", "180", "--flip", "y", "--border", "clamp")),
    ("lit", normals, TRANSFORM, {"show": "lit", "light-from": 20.0}, lit(around=20, above=40)),
    *((f"{kind} of normals", normals, CURVATURE,
       {"from-y": "down", "kind": kind, "range": 0.3, "border": border},
       gray("curvature", *DOWN, "--kind", kind, "--range", "0.3", "--border", border))
      for kind, border in (("mean", "clamp"), ("gaussian", "wrap"), ("convex", "wrap"),
                           ("cavity", "clamp"))),
    *((f"{mode} of {what}", normals, operation, {**settings, "mode": mode},
       blended("--mode", mode, *options))
      for mode, settings, options in (
          ("rnm", {"strength": 0.6}, ["--strength", "0.6"]),
          ("whiteout", {"detail-y": "down"}, ["--detail-y", "down"]),
          ("udn", {}, []),
          ("linear", {"detail-alpha": True}, ["--detail-alpha"]),
      )
      for what, operation in (("layers", BLEND), ("files", BLEND_FILE))),
]  # fmt: skip
NAMES = [row[0] for row in ROWS]

# Channels and bits, and what a file says of its curve.
KINDS = [(channels, depth) for channels in (3, 4) for depth in (8, 16)]
CURVES = {"plain": (), "gAMA": (GAMMA,)}


def name_of(picture, channels, depth, curve):
    return f"{picture.__name__}{channels}-{depth}-{curve}"


def pictures():
    """All inputs of the rows: a name, pixels, and PNG chunks."""
    for picture in (heights, cut, normals):
        for channels, depth in KINDS:
            for curve, chunks in CURVES.items():
                yield name_of(picture, channels, depth, curve), picture(channels, depth), chunks


def caller(program, folder):
    """ntp(pixels, verb, option...) -> the pixels that the program makes."""

    def call(pixels, verb, *words, detail=None, side=None):
        source, made, other = (folder / f"{n}.png" for n in ("in", "out", "other"))
        pngs.write_png(source, pixels)
        inputs = [source] if detail is None else [source, other]
        if detail is not None:
            pngs.write_png(other, detail)
        if side is not None:
            pngs.write_png(other, side[1])
            words = *words, side[0], other
        subprocess.run([program, verb, "-q", *words, *inputs, "-o", made], check=True)
        return pngs.read_png(made)[0]

    return call
