# SPDX-License-Identifier: MIT
"""PNG files that `ntp` writes, beside libpng's defaults: bench_png.py [FOLDER] [--pairs N] [--markdown]

The files are the PNGs of FOLDER, or those of bench_check.py.  Sizes: `ntp convert`, which keeps the
samples, over a copy that libpng makes.  Times: processor time of `ntp clean --jobs 1` over that of
the copy, alternating in one run, and beside it Pillow and OpenCV (if installed) opening and saving.
"""

import argparse
import os
import statistics
import sys
import tempfile
from pathlib import Path

from bench_check import has_opencv, ratios, show, spent, textures

GOALS = {6: 0.33, 1: 0.16}
PILLOW = "import sys; from PIL import Image; Image.open(sys.argv[1]).save(sys.argv[2])"
OPENCV = "import sys, cv2; cv2.imwrite(sys.argv[2], cv2.imread(sys.argv[1], cv2.IMREAD_UNCHANGED))"


def measure(build, path, out, pairs):
    """Of one file: {level: (size, time)} over libpng's copy, and times of the others."""
    ntp, theirs = build / "cli" / "ntp", out / "theirs.png"
    copy = [build / "bench" / "png_copy", path, theirs]
    found = {}
    for level in GOALS:
        ours = out / f"{level}.png"
        options = ["-q", "--jobs", "1", "--level", str(level), "-o", ours]
        kept = [ntp, "convert", path, *options, "--force", "--type", "standard"]
        clean = [ntp, "clean", path, *options, "--type", "standard"]
        spent(kept)
        spent(copy)
        size = ours.stat().st_size / theirs.stat().st_size
        found[level] = size, ratios([clean, copy], None, pairs)[0]
    others = [[sys.executable, "-c", PILLOW, path, out / "pillow.png"]]
    if has_opencv():
        others.append([sys.executable, "-c", OPENCV, path, out / "opencv.png"])
    return found, ratios([*others, copy], None, pairs)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--markdown", action="store_true")
    args = parser.parse_args()
    build = Path(os.environ["NTP_BUILD"])
    if args.folder is None:
        files = list(textures(build / "check-textures"))
    else:
        files = [(path.name, path) for path in sorted(args.folder.rglob("*.png"))]
    show(["file", "size 6", "size 1", "time 6", "time 1", "Pillow", "OpenCV"], args.markdown)
    if args.markdown:
        print("|---" + "|--:" * 6 + "|")
    sizes = {level: [] for level in GOALS}
    with tempfile.TemporaryDirectory() as out:
        for name, path in files:
            found, others = measure(build, path, Path(out), args.pairs)
            for level, (size, _) in found.items():
                sizes[level].append(size)
            cells = [f"{found[k][0]:.3f}" for k in GOALS] + [f"{found[k][1]:.2f}" for k in GOALS]
            cells += [f"{ratio:.2f}" for ratio in others]
            show([name, *cells, *[""] * (2 - len(others))], args.markdown)
    for level, goal in GOALS.items():
        mean = statistics.geometric_mean(sizes[level])
        larger = sum(size > 1 for size in sizes[level])
        print(
            f"level {level}: size {mean:.3f}, largest {max(sizes[level]):.3f}, {larger} larger; goal of the time {goal}"
        )


main()
