# SPDX-License-Identifier: MIT
"""Are errors visible?  severity.py DIR: findings of ntp check, and lit pictures, as a table.

Each texture in DIR that is judged is lit from five sides as it is stored, and as `ntp clean --method
derive` leaves it, by the library's own preview.  The table has what `--policy strict` and the
default policy say, and the differences of the two pictures.  With `-o FOLDER` pictures of the
textures with errors are written there: stored, cleaned, and the difference times 8.
NTP_BUILD names the build.
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

from support import libntp_ffi as ntp

Image.MAX_IMAGE_PIXELS = None
NTP = Path(os.environ.get("NTP_BUILD", ntp.ROOT / "build")) / "cli/ntp"
LIGHTS = [(-1, 1, 1.2), (1, 1, 1.2), (1, 0, 1), (0, -1, 1), (-2, 0, 1)]
VISIBLE = 8  # levels of 255
ENCODINGS = {"standard": ntp.STANDARD, "zzero": ntp.ZZERO, "xy": ntp.XY}


def check(folder, *options):
    command = [NTP, "check", "-r", "--format", "json", "--no-progress", "--fail-on", "never"]
    done = subprocess.run([*command, *options, folder], capture_output=True, check=False)
    return {file["path"]: file for file in json.loads(done.stdout)["files"]}


def cleaned(path, kind):
    """The texels of a file, and those that clean makes of them, through the program."""
    with tempfile.TemporaryDirectory() as folder:
        stored, repaired = Path(folder) / "stored.png", Path(folder) / "clean.png"
        first = [NTP, "convert", "--type", kind, "--to", kind, "--depth", "8", path, "-o", stored]
        second = [NTP, "clean", "--type", kind, "--method", "derive", stored, "-o", repaired]
        subprocess.run(first, capture_output=True, check=True)
        subprocess.run(second, capture_output=True, check=True)
        return tuple(np.asarray(Image.open(name)) for name in (stored, repaired))


def lit(pixels, encoding, light):
    """The luminance of the lit texture."""
    picture = np.zeros((*pixels.shape[:2], 1), np.uint8)
    source = ntp.view(np.ascontiguousarray(pixels), encoding, const=True)
    with_light = ntp.ffi.new("ntp_light *")
    with_light.direction = light
    with_light.ambient, with_light.diffuse, with_light.specular = 0.1, 0.9, 0.2
    with_light.color = (0.6, 0.6, 0.6)
    ntp.check(ntp.lib.ntp_shade(ntp.view(picture, ntp.HEIGHT), source, with_light, ntp.ffi.NULL))
    return picture[..., 0].astype(int)


def compare(path, kind, folder):
    """The worst light: mean and 99th percentile of the difference, and the share that is visible."""
    before, after = cleaned(path, kind)
    worst = (0.0, 0.0, 0.0)
    for number, light in enumerate(LIGHTS):
        a, b = (lit(p[..., :3], ENCODINGS[kind], light) for p in (before, after))
        off = np.abs(a - b)
        found = (100 * float((off > VISIBLE).mean()), float(np.percentile(off, 99)), off.mean())
        worst = max(worst, found)
        if folder is not None:
            beside = np.hstack([a, b, np.minimum(off * 8, 255)]).astype(np.uint8)
            Image.fromarray(beside).save(folder / f"{Path(path).stem}_light{number}.png")
    return worst


def short(file):
    levels = {"error": "E", "warning": "W"}
    found = [f"{f['id'][2:]}{levels[f['level']]}" for f in file["findings"] if f["level"] in levels]
    return " ".join(found) or "-"


def count_levels(files):
    worst = [short(file) for file in files]
    errors = sum("E" in words for words in worst)
    warnings = sum("W" in words and "E" not in words for words in worst)
    return f"{errors} with errors, {warnings} with warnings only"


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder")
    parser.add_argument("-o", type=Path)
    options = parser.parse_args()
    strict, harm = (check(options.folder, "--policy", policy) for policy in ("strict", "harm"))
    judged = [path for path in harm if harm[path]["status"] == "ok" and harm[path]["counts"]]
    print("| file | strict | default | mean | p99 | share over | lit: p99 | lit: share visible |")
    print("|---|---|---|---|---|---|---|---|")
    for path in judged:
        file = harm[path]
        if file["type"] not in ENCODINGS or (short(strict[path]) == "-" and short(file) == "-"):
            continue
        error = any(f["level"] == "error" for f in file["findings"])
        folder = options.o if error else None
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
        visible, p99, _ = compare(path, file["type"], folder)
        angles = file["harm"]["length"]
        over = 100 * angles["over"] / max(1, file["used"]["texels"])
        name = os.path.relpath(path, options.folder).replace("|", " ")
        print(
            f"| {name} | {short(strict[path])} | {short(file)} | {angles['mean']:.3f} | "
            f"{angles['p99']:.2f} | {over:.2f} % | {p99:.0f} | {visible:.2f} % |"
        )
    print(f"\nOf {len(judged)} judged files: strict {count_levels([strict[p] for p in judged])}; ")
    print(f"default {count_levels([harm[p] for p in judged])}.")
    failing = [p for p in judged if (strict[p]["used"] or {}).get("fail")]
    failing = [p for p in failing if strict[p]["used"]["fail"]["neighbor"] > 0]
    notes = sum(not {"001E", "001W"} & set(short(harm[p]).split()) for p in failing)
    print(
        f"{len(failing)} have texels that fail the reference program's test; {notes} of them are notes."
    )


if __name__ == "__main__":
    main()
