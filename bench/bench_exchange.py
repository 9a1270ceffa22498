# SPDX-License-Identifier: MIT
"""How often `ntp check --deep` tells that x and y are exchanged (NT013): bench_exchange.py [FOLDER...]

Each texture is written as it is and with red and green exchanged, as a PNG, and its middle in BC5
as a DDS.  Without folders the textures are those of quality_sets.py that are normals: the corpus and
those that NTP_REAL names.  Of a folder it takes the images that `ntp` itself is sure are normals.
Said of exchanged textures, NT013 is right; each name of one that is accused as it is, is printed.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import quality_sets

BLOCKS = 512  # texels a side of what is compressed
LEAST = 64  # texels a side
SUFFIXES = {".png", ".jpg", ".jpeg", ".tga"}
SURE = 0.9
NTP = Path(os.environ["NTP_BUILD"]) / "cli" / "ntp"
FORMS = ("png", "dds")
SIDES = ("as_is", "exchanged")


def told(*command):
    """The JSON that ntp prints, whatever it finds."""
    done = subprocess.run([NTP, *command], capture_output=True, text=True, check=False)
    return json.loads(done.stdout)["files"]


def listed():
    """(set, name, pixels) of the textures whose labels are known."""
    sets = {"corpus": quality_sets.corpus()} | {
        name: quality_sets.real(name) for name in ("seen", "heldout")
    }
    for name, samples in sets.items():
        for sample in samples:
            if sample.kind == "standard":
                yield name, sample.name, sample.pixels


def below(folder):
    paths = sorted(p for p in Path(folder).rglob("*") if p.suffix.lower() in SUFFIXES)
    for file in told("check", "--format=json", *paths):
        if file.get("type") == "standard" and file["confidence"] >= SURE:
            with Image.open(file["path"]) as image:
                yield folder, file["path"], np.asarray(image.convert("RGB"))


def middle(n):
    y, x = ((side - min(side, BLOCKS)) // 2 // 4 * 4 for side in n.shape[:2])
    return n[y : y + BLOCKS, x : x + BLOCKS]


def write(n, stem):
    for side, channels in zip(SIDES, ([0, 1, 2], [1, 0, 2]), strict=True):
        pixels = n[..., channels]
        path = stem.parent / f"{stem.name}-{side}.png"
        Image.fromarray(pixels).save(path, compress_level=1)
        cut = stem.parent / "cut.png"
        Image.fromarray(middle(pixels)).save(cut, compress_level=1)
        command = [NTP, "convert", "-q", "--type", "standard", "--force", cut, "-o"]
        subprocess.run([*command, path.with_suffix(".dds")], check=True)
        cut.unlink()


def accused(folder):
    """{(form, side)} of which NT013 is said."""
    files = told("check", "--deep", "--format=json", *sorted(folder.iterdir()))
    paths = [Path(f["path"]) for f in files if "NT013" in {x["id"] for x in f["findings"]}]
    return {(path.suffix[1:], path.stem.rpartition("-")[2]) for path in paths}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    folders = parser.parse_args().folders
    counts = {}
    source = (item for f in folders for item in below(f)) if folders else listed()
    for name, texture, pixels in source:
        if pixels.dtype != np.uint8 or pixels.ndim != 3 or min(pixels.shape[:2]) < LEAST:
            continue
        with tempfile.TemporaryDirectory() as folder:
            write(np.ascontiguousarray(pixels[..., :3]), Path(folder) / "n")
            found = accused(Path(folder))
        count = counts.setdefault(
            str(name), dict.fromkeys([(f, s) for f in FORMS for s in SIDES], 0)
        )
        count["textures"] = count.get("textures", 0) + 1
        for key in found:
            count[key] += 1
        if ("png", "as_is") in found or ("dds", "as_is") in found:
            print(f"accused as it is: {texture}", flush=True)
    for name, count in counts.items():
        n = count["textures"]
        shares = ", ".join(
            f"{form} {count[form, 'exchanged']} told, {count[form, 'as_is']} accused as they are"
            for form in FORMS
        )
        print(f"{name}: {n} textures: {shares}")


if __name__ == "__main__":
    main()
