# SPDX-License-Identifier: MIT
"""The sets of images on which ./dev bench quality counts answers; each yields Samples.

Where green points is known for a sample only if its maker or its project says so.
"""

import csv
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

import made_by_tools
from support import drawn_maps, drawn_pictures, drawn_surfaces, maps

ROOT = Path(__file__).resolve().parents[1]
CORPUS = Path(os.environ.get("NTP_CORPUS", ROOT.parent / "shared" / "corpus"))
REAL = os.environ.get("NTP_REAL")
BAKED = os.environ.get("NTP_BAKED")
CLASSES = drawn_maps.CLASSES
HEIGHT = 4  # how a view is declared

# Owners of public projects whose textures the thresholds for green were fitted on: half of those
# known then, drawn by a hash of their names.  All other projects were looked at only afterwards.
FITTED = ["Redot-Engine", "Unity-Technologies", "UnvanquishedAssets", "bevyengine", "gdquest-demos",
          "gkjohnson", "hiloteam", "immersive-web"]  # fmt: skip

# The words of real_images.csv, as classes.
WORDS = {"normals": "standard", "other": "not-normals"}
SIDES = (16, 32, 64, 128, 256)


@dataclass
class Sample:
    name: str
    pixels: np.ndarray
    kind: str
    also: frozenset = frozenset()
    encoding: int = 0
    y: str = ""  # up, down, or empty: not known
    fitted: bool = False  # the thresholds for green were fitted on it

    def right(self, called):
        return called == self.kind or called in self.also


def fitted(count, seed):
    """The textures that the rules of the classification were fitted on."""
    for number in range(count):
        case = maps.draw(np.random.default_rng([seed, number]))
        also = frozenset(CLASSES[k] for k in case.also)
        pixels = np.ascontiguousarray(case.pixels)
        yield Sample(case.name, pixels, CLASSES[case.kind], also, case.encoding)


def drawn(count, seed):
    """The second generator: maps, other layouts and pictures, whole and damaged, in turn."""
    rng = np.random.default_rng(seed)
    surfaces = [s.__name__ for s in drawn_surfaces.SURFACES]
    damages = list(drawn_maps.DAMAGES)
    damaged = [n for n in drawn_maps.MAPS if n not in ("padded", "16 bit")]
    for number in range(count):
        surface = str(rng.choice(surfaces))
        sort = rng.choice(4)
        if sort == 0:
            drawing = drawn_maps.draw(str(rng.choice(list(drawn_maps.MAPS))), surface, "", number)
        elif sort == 1:
            name = str(rng.choice(damaged))
            drawing = drawn_maps.draw(name, surface, str(rng.choice(damages)), number)
        elif sort == 2:
            drawing = drawn_maps.draw_other(str(rng.choice(drawn_maps.OTHERS)), surface, number)
        else:
            paint = drawn_pictures.PICTURES[rng.choice(len(drawn_pictures.PICTURES))]
            drawing = drawn_maps.draw_picture(paint, str(rng.choice(damages)), number)
        pixels = np.ascontiguousarray(drawing.pixels)
        yield Sample(drawing.name, pixels, CLASSES[drawing.kind], encoding=drawing.encoding)


def drawn_sides(count, seed):
    """Surfaces of the second generator whose green is known, small ones and damaged ones too."""
    rng = np.random.default_rng([seed, 1])
    for number in range(count):
        make = drawn_surfaces.SURFACES[number % len(drawn_surfaces.SURFACES)]
        side, up = int(rng.choice(SIDES)), bool(rng.integers(2))
        n = make(rng, max(side, 64), max(side, 64))[:side, :side]
        pixels = drawn_maps.stored(drawn_maps.to_levels(n * [1, 1 if up else -1, 1]))
        damage = str(rng.choice(["", "jpeg95", "jpeg85", "half", "larger", "blocks"]))
        if side > SIDES[0]:
            pixels = np.ascontiguousarray(drawn_maps.DAMAGES[damage](pixels))
        yield Sample(f"{make.__name__} {side}", pixels, "standard", y="up" if up else "down")


def tools(count, seed):
    """Made by other programs from heights that numpy draws."""
    for name, pixels, y in made_by_tools.draw(count, seed):
        yield Sample(name, pixels, "standard", y=y)


def baked():
    """What made_by_blender.py wrote: charts of many directions; green up."""
    for path in sorted(Path(BAKED).glob("*.png")) if BAKED else []:
        yield Sample(path.name, opened(path)[0], "standard", y="up")


def opened(path):
    """(pixels, how the view is declared) of an image file."""
    with Image.open(path) as image:
        if image.mode in ("I;16", "I"):
            return np.ascontiguousarray(np.asarray(image).astype(np.uint16)[..., None]), HEIGHT
        if image.mode in ("L", "1"):
            return np.ascontiguousarray(np.asarray(image.convert("L"))[..., None]), HEIGHT
        alpha = "A" in image.mode or "transparency" in image.info
        return np.ascontiguousarray(np.asarray(image.convert("RGBA" if alpha else "RGB"))), 0


def rows(path):
    with Path(path).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def real(which):
    """Images of public projects: real_images.csv, in the directory that NTP_REAL names.

    `which` is "seen" (the rules were written with these at hand) or "heldout" (labeled before the
    rules were first tried on them).
    """
    for row in rows(ROOT / "bench" / "real_images.csv") if REAL else []:
        path = Path(REAL) / row["path"]
        if row["set"] == which and path.is_file():
            pixels, encoding = opened(path)
            also = {WORDS.get(w, w) for w in row["also"].split()}
            kind = WORDS.get(row["kind"], row["kind"])
            # Whatever is gray is called height: content cannot tell a height from another gray.
            if pixels.shape[2] == 1:
                also |= {"height"}
            name = f"{row['repo']}: {row['repo_path']}"
            fitted = row["repo"].partition("/")[0] in FITTED
            yield Sample(name, pixels, kind, frozenset(also), encoding, row["y"], fitted)


def corpus():
    """The labeled textures beside the repository."""
    if not CORPUS.is_dir():
        return
    sides = {"OpenGL": "up", "DirectX": "down"}
    manifest = {r["file"]: r for r in rows(CORPUS / "manifest.csv")}
    for row in rows(ROOT / "tests" / "corpus_labels.csv"):
        known = manifest.get(row["file"])
        if known and known["format"] in ("PNG", "TGA", "JPEG") and known["bit_depth"] != "16":
            pixels, encoding = opened(CORPUS / row["file"])
            also = frozenset(filter(None, [row["or"]]))
            y = sides.get(known["orientation"], "") if "suspect" not in known["note"] else ""
            yield Sample(row["file"], pixels, row["class"], also, encoding, y)
