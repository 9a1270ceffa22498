# SPDX-License-Identifier: MIT
"""PNG files that `ntp` reads and writes, beside libpng and others: bench_png.py [FOLDER] [--pairs N] [--markdown] [--sizes]

The files are the PNGs of FOLDER, or those of bench_check.py.  Times are processor times over
those of libpng, alternating in one run; medians count.  Reading: `ntp check --jobs 1`, libspng,
Pillow and OpenCV over a program that decodes.  Writing: `ntp clean --jobs 1`, Pillow and OpenCV over a
copy with libpng's defaults; sizes, too, and those of oxipng -o2.  `ntp convert` makes the files for the
sizes, as it keeps all samples.  Programs count from their start, Python's modules only what they
do.  What is not installed is left out.  The last columns of times are by the clock, with the default
of --jobs, which works on one large file with all processors: over libpng by the clock.  Without
FOLDER, two threads on one file of 8192 x 8192 are compared with one, by the clock.

--sizes leaves out all times: it says which files of FOLDER (written with x mirrored, so that all are
written anew) are larger than libpng's copy of the same pixels, and by how much.
"""

import argparse
import importlib.util
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from bench_check import pairs_for, ratios, save, show, spent, textures

LEVELS = (6, 1)
GOALS = {"check": 0.55, 6: 0.33, 1: 0.16, "threads": 0.60}
TIMED = """
import sys, time
{start}
path, out = sys.argv[1:]
begin = time.process_time()
{work}
print(time.process_time() - begin)
"""
PILLOW = "from PIL import Image\nImage.MAX_IMAGE_PIXELS = None\nImage.init()"
READERS = {
    "Pillow": TIMED.format(start=PILLOW, work="Image.open(path).load()"),
    "OpenCV": TIMED.format(start="import cv2", work="cv2.imread(path, cv2.IMREAD_UNCHANGED)"),
}
WRITERS = {
    "Pillow": TIMED.format(start=PILLOW, work="Image.open(path).save(out)"),
    "OpenCV": TIMED.format(
        start="import cv2", work="cv2.imwrite(out, cv2.imread(path, cv2.IMREAD_UNCHANGED))"
    ),
}
OXIPNG = "import sys, oxipng; oxipng.optimize(sys.argv[1], sys.argv[2], level=2)"
MODULES = {"Pillow": "PIL", "OpenCV": "cv2"}


def installed(programs):
    return {k: v for k, v in programs.items() if importlib.util.find_spec(MODULES[k]) is not None}


def seconds(command):
    """Processor time: of a script what it says, of a program all."""
    if command[0] != sys.executable:
        return spent(command)[0]
    command = [str(part) for part in command]
    return float(subprocess.run(command, capture_output=True, check=True).stdout)


def alternating(commands, pairs):
    """{name: median of its time over that of "libpng"}."""
    times = []
    for i in range(pairs + 1):  # the first run warms the caches
        order = list(commands) if i % 2 else list(reversed(commands))
        times.append({name: seconds(commands[name]) for name in order})
    return {k: statistics.median(t[k] / t["libpng"] for t in times[1:]) for k in commands}


def is_wide(path):
    """16 bits?  Pillow reads 8 of them."""
    with open(path, "rb") as file:
        return file.read(25)[24] == 16


def reading(build, path, pairs):
    bench = build / "bench"
    ntp = [build / "cli" / "ntp", "check", "-q", "--jobs", "1", path]
    commands = {"ntp check": ntp}
    if (bench / "spng_decode").exists():
        commands["libspng"] = [bench / "spng_decode", path]
    for name, script in installed(READERS).items():
        if not (name == "Pillow" and is_wide(path)):
            commands[name] = [sys.executable, "-c", script, path, ""]
    libpng = [bench / "png_decode", path]
    times = alternating({**commands, "libpng": libpng}, pairs)
    if pairs_for(path, pairs) > pairs:
        times["ntp check"] = ratios([ntp, libpng], None, pairs_for(path, pairs))[0]
    return times


def writing(build, path, out, pairs):
    """Times and sizes of one file, over those of libpng's copy."""
    ntp = build / "cli" / "ntp"
    commands, sizes = {}, {}
    for level in LEVELS:
        options = ["-q", "--jobs", "1", "--level", str(level), "--type", "standard"]
        commands[level] = [ntp, "clean", path, *options, "-o", out / f"{level}.png"]
        spent([ntp, "convert", path, *options, "--force", "-o", out / "kept.png"])
        sizes[level] = (out / "kept.png").stat().st_size
    for name, script in installed(WRITERS).items():
        if not (name == "Pillow" and is_wide(path)):
            commands[name] = [sys.executable, "-c", script, path, out / f"{name}.png"]
    commands["libpng"] = [build / "bench" / "png_copy", path, out / "libpng.png"]
    times = alternating(commands, pairs)
    if importlib.util.find_spec("oxipng") is not None:
        spent([sys.executable, "-c", OXIPNG, path, out / "oxipng.png"])
        sizes["oxipng"] = (out / "oxipng.png").stat().st_size
    for name in commands.keys() - sizes.keys():
        sizes[name] = (out / f"{name}.png").stat().st_size
    return times, {name: size / sizes["libpng"] for name, size in sizes.items()}


def pixels_size(path):
    """Bytes of the IDAT chunks."""
    data, at, size = path.read_bytes(), 8, 0
    while at < len(data):
        length = int.from_bytes(data[at : at + 4], "big")
        size += length if data[at + 4 : at + 8] == b"IDAT" else 0
        at += 12 + length
    return size


def mirrored_sizes(build, path, out):
    """(ours, libpng's) with the default level and with LEVELS; None: `ntp` does not write it."""
    sizes = {}
    options = ["--type", "standard", "--y", "up", "--flip", "x", "--force", "-q", "--jobs", "1"]
    for level in (None, *LEVELS):
        ours, theirs = out / "ours.png", out / "theirs.png"
        ours.unlink(missing_ok=True)
        chosen = [] if level is None else ["--level", str(level)]
        command = [build / "cli" / "ntp", "transform", path, *options, *chosen, "-o", ours]
        subprocess.run(command, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        if not ours.exists():
            return None
        if level is None:
            spent([build / "bench" / "png_copy", ours, theirs])
        sizes[level] = pixels_size(ours), pixels_size(theirs)
    return sizes


def compare_sizes(build, files, out):
    ratios_of = {level: [] for level in (None, *LEVELS)}
    for name, path in files:
        sizes = mirrored_sizes(build, path, out)
        if sizes is None:
            print(f"not written: {name}")
            continue
        for level, (ours, theirs) in sizes.items():
            ratios_of[level].append(ours / theirs)
            if ours > theirs and level != 1:
                print(f"larger at level {level or 'default'}: {name}, {ours} of {theirs} bytes")
    for level, values in ratios_of.items():
        if values:
            print(
                f"level {level or 'default'}: {len(values)} files, size "
                f"{statistics.geometric_mean(values):.3f}, largest {max(values):.4f}, "
                f"{sum(value > 1 for value in values)} larger"
            )


def by_the_clock(build, path, out, pairs):
    """With the default of --jobs: {"clock check", "clock 6", ..: time on the clock over libpng's}."""
    ntp, bench = build / "cli" / "ntp", build / "bench"
    check = [[ntp, "check", "-q", path], [bench / "png_decode", path]]
    times = {"clock check": ratios(check, None, pairs, clock=1)[0]}
    clean = [ntp, "clean", path, "-q", "--type", "standard", "-o", out / "clock.png", "--level"]
    copy = [bench / "png_copy", path, out / "libpng.png"]
    commands = [*([*clean, str(level)] for level in LEVELS), copy]
    for level, ratio in zip(LEVELS, ratios(commands, None, pairs, clock=1), strict=True):
        times[f"clock {level}"] = ratio
    return times


def cells(values, names):
    return [f"{values[name]:.2f}" if name in values else "" for name in names]


def two_threads(build, out, pairs):
    """By the clock: one file of 8192 x 8192, which mirrors one of 4096 x 4096."""
    path = out / "large.png"
    quarter = np.asarray(Image.open(build / "check-textures" / "rock8_4096.png"))
    half = np.hstack([quarter, quarter[:, ::-1]])
    save(np.vstack([half, half[::-1]]), path)
    clean = [build / "cli" / "ntp", "clean", path, "-q", "--type", "standard", "-o", out / "x.png"]
    commands = [[*clean, "--jobs", str(jobs), "--level", "6"] for jobs in (2, 1)]
    return ratios(commands, None, pairs, clock=1)[0]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--markdown", action="store_true")
    parser.add_argument("--sizes", action="store_true")
    args = parser.parse_args()
    build = Path(os.environ["NTP_BUILD"])
    if args.folder is None:
        files = list(textures(build / "check-textures"))
    else:
        files = [(path.name, path) for path in sorted(args.folder.rglob("*.png"))]
    if args.sizes:
        with tempfile.TemporaryDirectory() as folder:
            compare_sizes(build, files, Path(folder))
        return
    print("load:", *(f"{load:.1f}" for load in os.getloadavg()))
    print(f"clock: on the clock, with all {os.cpu_count()} processors; time: of one processor")
    read = ["ntp check", "libspng", "Pillow", "OpenCV"]
    times = [*LEVELS, "Pillow", "OpenCV"]
    head = [*read, *(f"time {k}" for k in times), *(f"size {k}" for k in times), "size oxipng"]
    clock = ["clock check", *(f"clock {level}" for level in LEVELS)]
    head += clock
    show(["file", *head], args.markdown)
    if args.markdown:
        print("|---" + "|--:" * len(head) + "|")
    sizes = {level: [] for level in LEVELS}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        for name, path in files:
            spent_writing, size = writing(build, path, out, args.pairs)
            row = cells(reading(build, path, args.pairs), read)
            row += cells(spent_writing, times) + cells(size, [*times, "oxipng"])
            row += cells(by_the_clock(build, path, out, args.pairs), clock)
            show([name, *row], args.markdown)
            for level in LEVELS:
                sizes[level].append(size[level])
        if args.folder is None:
            ratio = two_threads(build, out, args.pairs)
            print(f"two threads, 8192 x 8192: {ratio:.2f} of one; goal {GOALS['threads']}")
    print(f"goal of ntp check: {GOALS['check']}, at 256 x 256 1")
    for level in LEVELS:
        mean = statistics.geometric_mean(sizes[level])
        larger = sum(size > 1 for size in sizes[level])
        print(
            f"level {level}: size {mean:.3f}, largest {max(sizes[level]):.3f}, {larger} larger; "
            f"goal of the time {GOALS[level]}"
        )


main()
