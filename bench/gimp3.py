# SPDX-License-Identifier: MIT
"""Times our operation in GIMP 3 beside GIMP's own filter: `./dev gimp3 --bench [SIDE]`.

Both make normals of one RGB layer with the same settings and are merged, in turns, in one GIMP.
Our result is held against `ntp from-height`: no texel may differ.
"""

import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "tests" / "gimp")]

from gimps import Gimp3

GOAL = 1.3  # times GIMP's own filter


def heights(side):
    """Waves with a little noise, the same in red, green and blue."""
    rng = np.random.default_rng(1)
    y, x = np.mgrid[:side, :side].astype(np.float32)
    unit = np.sin(x / 31) * np.cos(y / 23) * 0.4 + 0.5
    unit += rng.normal(0, 0.01, (side, side)).astype(np.float32)
    gray = (unit.clip(0, 1) * 255 + 0.5).astype(np.uint8)
    return np.repeat(gray[:, :, None], 3, axis=2)


def main():
    side = int(sys.argv[1]) if len(sys.argv) > 1 else 4096
    gimp = Gimp3(os.environ["NTP_GIMP3"], "bench")
    Image.fromarray(heights(side)).save(gimp.work / "heights.png", compress_level=1)
    gimp.script(ROOT / "bench" / "in_gimp3.py")
    times = json.loads((gimp.work / "times.json").read_text())
    ratios = [a / b for a, b in zip(times["ntp"], times["gimp"], strict=True)]
    print(f"{side} x {side} RGB, 8 bit, merged in GIMP 3")
    for name, label in (("gimp", "gegl:normal-map"), ("ntp", "ntp:normals-from-height")):
        print(f"  {label:24} {statistics.median(times[name]) * 1000:8.0f} ms")
    print(f"  ratio {statistics.median(ratios):.2f}, goal {GOAL} at most")

    program = next(Path(os.environ["NTP_BUILD"]).rglob("cli/ntp"))
    source, made = gimp.work / "heights.png", gimp.work / "ntp.png"
    options = ["--scale", "10", "--border", "clamp", "--to-y", "down"]
    subprocess.run([program, "from-height", "-q", *options, source, "-o", made], check=True)
    Image.MAX_IMAGE_PIXELS = None
    expected = np.asarray(Image.open(made))
    result = np.fromfile(gimp.work / "result", np.uint8).reshape(side, side, 3)
    different = int((result != expected).any(2).sum())
    print(f"  {different} texels differ from ntp from-height")
    return different != 0


if __name__ == "__main__":
    sys.exit(main())
