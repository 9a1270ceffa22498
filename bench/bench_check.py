# SPDX-License-Identifier: MIT
"""Times of `ntp check` beside decoding the same files: bench_check.py [FOLDER] [--pairs N] [--markdown]

All commands alternate in one run, and the medians of the ratios of their processor times count;
with two jobs it is the time on the clock.  Textures, those of images.py and some of
../shared/corpus where it is there, are compared with a program that only decodes with libpng; a
folder of images of any kind is compared with Pillow, and OpenCV's imread too where it is installed.
"""

import argparse
import importlib.util
import os
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

import numpy as np
from PIL import Image, PngImagePlugin

from images import normals, rock

HERE = Path(__file__).resolve().parent
CORPUS = HERE.parent.parent / "shared" / "corpus" / "glTF-Sample-Assets-OLD"
SUFFIXES = {".png", ".jpg", ".jpeg", ".tga"}
DECODE = """
import sys
{start}
for path in sys.stdin.read().split("\\0"):
    try:
        {read}
    except Exception:
        pass  # what cannot be read is not the point here
"""
PILLOW = DECODE.format(
    start="from PIL import Image\nImage.MAX_IMAGE_PIXELS = None", read="Image.open(path).load()"
)
SMALL = 500_000  # bytes of a file
OPENCV = DECODE.format(start="import cv2", read="cv2.imread(path, cv2.IMREAD_UNCHANGED)")


def spent(command, paths=None):
    """(processor seconds, seconds on the clock) of one process."""
    with tempfile.TemporaryFile() as given:
        given.write("\0".join(map(str, paths or [])).encode())
        given.seek(0)
        start = time.perf_counter()
        process = subprocess.Popen(
            [str(part) for part in command],
            stdin=given,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1, 3):  # findings; a file that is no image
        sys.exit(f"exit {process.returncode}: {' '.join(map(str, command))[:200]}")
    return usage.ru_utime + usage.ru_stime, seconds


def ratios(commands, paths, pairs, clock=0):
    """Medians of the times of all commands but the last over its own; `clock` 1: on the clock."""
    for command in commands:
        spent(command, paths)  # caches warm
    times = []
    for i in range(pairs):
        order = range(len(commands)) if i % 2 else reversed(range(len(commands)))
        times.append({k: spent(commands[k], paths)[clock] for k in order})
    last = len(commands) - 1
    return [statistics.median(t[k] / t[last] for t in times) for k in range(last)]


def pairs_for(path, pairs):
    """Of a file that takes milliseconds many pairs are measured: each varies by a tenth."""
    return pairs * (60 if path.stat().st_size < SMALL else 1)


def has_opencv():
    return importlib.util.find_spec("cv2") is not None


def save(array, path):
    """Adaptive filters and level 6, as most programs write."""
    if array.dtype == np.uint8:
        Image.fromarray(array).save(path)
        return
    rows = array.astype(">u2").view(np.uint8).reshape(array.shape[0], -1)
    up = np.vstack([rows[:1], rows[1:] - rows[:-1]])
    filters = np.full((rows.shape[0], 1), 2, np.uint8)
    filters[0] = 0
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        header = struct.pack(">IIBBBBB", array.shape[1], array.shape[0], 16, 2, 0, 0, 0)
        PngImagePlugin.putchunk(file, b"IHDR", header)
        PngImagePlugin.putchunk(file, b"IDAT", zlib.compress(np.hstack([filters, up]), 6))
        PngImagePlugin.putchunk(file, b"IEND", b"")


def textures(folder):
    """(name, path) of textures of 256 to 4096 texels a side, made where they are missing."""
    folder.mkdir(parents=True, exist_ok=True)
    for side in (256, 2048, 4096):
        height = None
        for depth in (8, 16):
            path = folder / f"rock{depth}_{side}.png"
            if not path.exists():
                height = rock(side, 1, 0.4) if height is None else height
                save(normals(height, 2**depth - 1), path)
            yield f"rock, RGB{depth}, {side}", path
    for name in ("BoomBox_normal.png", "StainedGlassLamp_hardware_normal.png"):
        if (CORPUS / name).exists():
            yield f"{name}, 2048", CORPUS / name


def show(cells, markdown):
    if markdown:
        print("| " + " | ".join(cells) + " |", flush=True)
    else:
        print(f"{cells[0]:44}" + "".join(f"{c:>12}" for c in cells[1:]), flush=True)


def compare_textures(build, pairs, markdown):
    ntp, decode = build / "cli" / "ntp", build / "bench" / "png_decode"
    show(["file", "ntp check", "goal"], markdown)
    if markdown:
        print("|---|--:|--:|")
    for name, path in textures(build / "check-textures"):
        goal = 1.0 if name.endswith(" 256") else 0.55
        commands = [[ntp, "check", "-q", "--jobs", "1", path], [decode, path]]
        [ours] = ratios(commands, None, pairs_for(path, pairs))
        show([name, f"{ours:.2f}", f"{goal:g}"], markdown)


def compare_folder(build, folder, pairs, markdown):
    found = sorted(p for p in folder.rglob("*") if p.suffix.lower() in SUFFIXES)
    check = [build / "cli" / "ntp", "check", "-q", "--files-from", "-", "-0", "--jobs"]
    beside = [[sys.executable, "-c", OPENCV]] if has_opencv() else []
    show([f"{len(found)} images / Pillow", "ntp check", "OpenCV", "goal"], markdown)
    if markdown:
        print("|---|--:|--:|--:|")
    for jobs, goal in ((1, 0.6), (2, 0.33)):
        commands = [[*check, str(jobs)], *beside, [sys.executable, "-c", PILLOW]]
        ours, *theirs = ratios(commands, found, pairs, int(jobs > 1))
        theirs = f"{theirs[0]:.2f}" if theirs else ""
        show([f"--jobs {jobs}", f"{ours:.2f}", theirs, f"{goal:g}"], markdown)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--pairs", type=int, default=7)
    parser.add_argument("--markdown", action="store_true")
    args = parser.parse_args()
    build = Path(os.environ["NTP_BUILD"])
    if args.folder is None:
        compare_textures(build, args.pairs, args.markdown)
    else:
        compare_folder(build, args.folder, args.pairs, args.markdown)


if __name__ == "__main__":
    main()
