# SPDX-License-Identifier: MIT
"""How often libntp is right: quality.py [SECONDS] [--seed N]; NTP_BUILD names the build.

Generates textures of known type, as tests/test_classify.py does, and counts what the classification
and the search for banding say about them; then makes the table of docs/classification.md.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from support import from_height, maps, surfaces
from support import libntp_ffi as ntp

SCALES = (1, 2, 5, 10, 25, 50, 100)
KERNELS = ("central", "forward", "prewitt3", "sobel3", "scharr3", "prewitt5", "sobel5")
BORDERS = 5  # kinds
TEXTURES = 50


def draws(seconds, seed):
    wrong, right, steps, count = [], 0, 0, 0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        case = maps.draw(np.random.default_rng([seed, count]))
        result = ntp.classify(case.pixels, case.encoding)
        if result.type == case.kind or result.type in case.also:
            right += result.confidence >= 0.9
        else:
            wrong.append(result.confidence)
        if case.encoding != ntp.HEIGHT and case.pixels.shape[2] >= 2:
            encoding = ntp.XY if case.pixels.shape[2] == 2 else ntp.STANDARD
            pixels = np.ascontiguousarray(case.pixels)
            steps += ntp.find_steps(pixels, encoding)["found"]
        count += 1
    if count == 0:
        return
    print(
        f"{count} textures drawn from seed {seed}: {len(wrong)} called wrong ({len(wrong) / count:.2%})"
    )
    print(f"their highest confidence: {max(wrong, default=0):.2f}")
    print(f"right answers of 0.9 and more: {right / max(1, count - len(wrong)):.0%}")
    print(f"steps told, where there are none: {steps}")


def heights(seed):
    """8-bit heights of full range: bumps and fractals in turn."""
    for i in range(TEXTURES):
        h = (surfaces.bumps, surfaces.fractal)[i % 2](np.random.default_rng([seed, i]), 256, 256)
        h = (h - h.min()) / np.ptp(h)
        yield np.floor(h * 255 + 0.5).astype(np.uint8)[:, :, None]


def table(seed):
    print("\n| kernel | normals | " + " | ".join(map(str, SCALES)) + " |")
    print("|---|---" + "|---" * len(SCALES) + "|")
    made = list(heights(seed))
    for kernel in KERNELS:
        for dtype in (np.uint8, np.uint16):
            row = []
            for scale in SCALES:
                told = 0
                for i, h in enumerate(made):
                    border = i % BORDERS
                    how = {"kernel": kernel, "scale": scale, "border_x": border, "border_y": border}
                    n, _, _ = from_height.from_height(h, dst=dtype, **how)
                    told += ntp.find_steps(n)["decided"]
                row.append(f"{told / TEXTURES:.0%}"[:-1])
            print(
                f"| {kernel} | {8 * dtype(0).itemsize} bit | " + " | ".join(row) + " |", flush=True
            )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("seconds", nargs="?", type=float, default=60)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    arguments = parser.parse_args()
    draws(arguments.seconds, arguments.seed)
    table(arguments.seed)


if __name__ == "__main__":
    main()
