# SPDX-License-Identifier: MIT
"""Times each operation in copies of the same picture: bench_operations.py [FILE...] [--size N] [--made]

`./dev bench operations` runs it.  One copy is a memcpy of the picture as RGB8; the operation and
the copy alternate in one run, on one thread and with `out=` given, and the median of the ratios of
their CPU times is printed.  Beside them stands what a careful program takes that works with numpy
and OpenCV in float32, which is not exact.  `real` is the texture of the first FILE, and `slowest` is
what the slowest of all FILEs takes.  `noise` are random levels, which should take no more than three
times as long as that one.  Without FILE these are the large normals textures of the corpus, or one that
is made like them.  With --made the first one is mixed with black, white and other colors, in many patterns, and
the worst of these pictures stands beside the slowest texture.
"""

import argparse
import csv
import functools
import itertools
import os
import statistics
import sys
import time
from pathlib import Path

import numpy as np

import in_floats
import normaltexture as nt

try:
    import cv2
except ImportError:
    cv2 = None

NOISE_GOAL = 3  # times as long as the slowest real texture
LARGE = 1024  # texels on both sides, of those textures of the corpus that count
COLORS = {
    "black": (0, 0, 0),
    "white": (255, 255, 255),
    "down": (128, 128, 0),
    "flat": (128, 128, 255),
    "gray": (127, 127, 127),
}
HERE = Path(__file__).resolve().parent
CORPUS = Path(os.environ.get("NTP_CORPUS", HERE.parents[1] / "shared" / "corpus"))
REAL = CORPUS / "glTF-Sample-Assets-OLD" / "BoomBox_normal.png"
HEAD = ("operation", "real", "slowest", "noise", "noise/slowest", "numpy, OpenCV", "goal")


# ------------------------------------------------------------------------------------- textures


def heights(size):
    """Rock-like heights in 0..1: octaves of smooth noise."""
    rng = np.random.default_rng(1)
    total = np.zeros((size, size), np.float32)
    cells = 4
    while cells <= size // 2:
        values = rng.random((cells, cells), np.float32)
        at = np.arange(size, dtype=np.float32) * (cells / size)
        low = at.astype(int)
        part = (at - low) ** 2 * (3 - 2 * (at - low))
        across = values[:, low] + (values[:, (low + 1) % cells] - values[:, low]) * part
        total += (across[low] + (across[(low + 1) % cells] - across[low]) * part[:, None]) / cells
        cells *= 2
    total -= total.min()
    return total / total.max()


def tiled(texture, size):
    """The middle of a texture, or repetitions of it: size x size x 3."""
    height, width = texture.shape[:2]
    times = (-(-size // height), -(-size // width), 1)
    return np.ascontiguousarray(np.tile(texture[..., :3], times)[:size, :size])


class Pictures:
    """All that the operations take, in one content."""

    def __init__(self, size, rgb8, drawn=None):
        """drawn: the texels whose colors are the same at both depths."""
        rng = np.random.default_rng(2)
        shape = (size, size, 3)
        self.noise = rgb8 is None
        if self.noise:
            self.rgb8 = rng.integers(0, 256, shape, np.uint8)
            self.rgb16 = rng.integers(0, 65536, shape, np.uint16)
            self.vectors = rng.random(shape, np.float32) * 2 - 1
            self.height16 = rng.integers(0, 65536, (size, size), np.uint16)
        else:
            self.rgb8 = rgb8
            finer = rng.random(shape, np.float32) * (2 / 255) - np.float32(1 / 255)
            self.vectors = nt.decode(rgb8) + finer
            self.rgb16 = nt.encode(self.vectors, depth=16, blue="nearest")
            if drawn is not None:
                self.rgb16[drawn] = rgb8[drawn] * np.uint16(257)
            self.height16 = (heights(size) * 65535 + 0.5).astype(np.uint16)
        self.rgba8 = np.dstack([self.rgb8, np.full((size, size), 255, np.uint8)])
        self.xy8 = np.ascontiguousarray(self.rgb8[..., :2])
        off = rng.integers(-4, 5, shape, np.int8)
        self.damaged8 = np.clip(self.rgb8.astype(np.int16) + off, 0, 255).astype(np.uint8)
        more = rng.integers(-999, 1000, shape, np.int16)
        self.damaged16 = np.clip(self.rgb16.astype(np.int32) + more, 0, 65535).astype(np.uint16)
        self.other8 = np.ascontiguousarray(np.roll(self.rgb8, size // 3, 1))
        self.other16 = np.ascontiguousarray(np.roll(self.rgb16, size // 3, 1))
        self.height32 = (self.height16 / np.float32(65535)).astype(np.float32)
        self.scale = size / 64.0
        self.out = {
            "8": np.empty(shape, np.uint8),
            "8a": np.empty((size, size, 4), np.uint8),
            "16": np.empty(shape, np.uint16),
            "32": np.empty(shape, np.float32),
            "mask": np.empty((size, size), np.uint8),
            "half8": np.empty((size // 2, size // 2, 3), np.uint8),
            "half8a": np.empty((size // 2, size // 2, 4), np.uint8),
            "half16": np.empty((size // 2, size // 2, 3), np.uint16),
        }
        for buffer in self.out.values():
            buffer.fill(1)  # the first touch of memory is not measured


# ------------------------------------------------------------------------------------ operations


def operations(p):
    """(name, goal in copies or None, ours, theirs or None)."""
    out, std = p.out, {"type": "standard"}
    o8, o16 = out["8"], out["16"]
    plain = functools.partial

    def clean(src, to, method="derive"):
        return plain(nt.clean, src, type="standard", method=method, out=out[to])

    def convert(src, into, **how):
        return plain(nt.convert, src, **std, y="up", out=out[into], **how)

    def theirs(function, *args):
        return plain(function, *args) if cv2 is not None else None

    sobel = {"scale": p.scale, "kernel": "sobel3"}
    return [
        ("clean, derive: RGB8", 2, clean(p.rgb8, "8"), theirs(in_floats.clean_floats, p.rgb8, o8)),
        ("clean, derive: damaged RGB8", 3, clean(p.damaged8, "8"), None),
        ("clean, derive: RGBA8", 3, clean(p.rgba8, "8a"), None),
        ("clean, derive: RGB16", 3.3, clean(p.rgb16, "16"), theirs(in_floats.clean_floats, p.rgb16, o16)),
        ("clean, derive: damaged RGB16", 4.5, clean(p.damaged16, "16"), None),
        ("clean, normalize: damaged RGB8", 8, clean(p.damaged8, "8", "normalize"),
         theirs(in_floats.normalize_floats, p.damaged8, o8)),
        ("clean, normalize: damaged RGB16", 8, clean(p.damaged16, "16", "normalize"),
         theirs(in_floats.normalize_floats, p.damaged16, o16)),
        ("validate: RGB8", 2.5, plain(nt.validate, p.rgb8, **std, out=out["mask"]), None),
        ("validate: RGB16", 4, plain(nt.validate, p.rgb16, **std, out=out["mask"]), None),
        ("measure: RGB8", 6, plain(nt.measure, p.rgb8), None),
        ("measure: damaged RGB8", 9, plain(nt.measure, p.damaged8), None),
        ("measure: RGB16", 12, plain(nt.measure, p.rgb16), None),
        ("classify: RGB8", 6, plain(nt.classify, p.rgb8), None),
        ("classify: RGB16", 12, plain(nt.classify, p.rgb16), None),
        ("convert: RGB8 to 16 bit", 4, convert(p.rgb8, "16", depth=16),
         theirs(in_floats.deepen_floats, p.rgb8, o16)),
        ("convert: RGB16 to 8 bit", 4, convert(p.rgb16, "8", depth=8),
         theirs(in_floats.narrow_floats, p.rgb16, o8)),
        ("convert: RGB8 to Z-zero", 4, convert(p.rgb8, "8", to="zzero"),
         theirs(in_floats.zzero_floats, p.rgb8, o8)),
        ("convert: RGB16 to Z-zero", 4, convert(p.rgb16, "16", to="zzero"), None),
        ("convert: RGB8 to floats in 0..1", None, convert(p.rgb8, "32", depth="float"),
         theirs(in_floats.unit_floats, p.rgb8, out["32"])),
        ("convert: flip of RGB8", 1.5, convert(p.rgb8, "8", to_y="down"),
         theirs(in_floats.flip_bytes, p.rgb8, o8)),
        ("convert: flip of RGB16", 4, convert(p.rgb16, "16", to_y="down"),
         theirs(in_floats.flip_bytes, p.rgb16, o16)),
        ("heatmap: RGB8", 6, plain(nt.heatmap, p.rgb8, **std, out=o8), None),
        ("heatmap: RGB16", 6, plain(nt.heatmap, p.rgb16, **std, out=o8), None),
        ("shade: RGB8", 9, plain(nt.shade, p.rgb8, **std, out=o8),
         theirs(in_floats.shaded_floats, p.rgb8, o8)),
        ("shade: RGB16", 9, plain(nt.shade, p.rgb16, **std, out=o8),
         theirs(in_floats.shaded_floats, p.rgb16, o8)),
        ("compare: RGB8", 9, plain(nt.compare, p.rgb8, p.other8, **std),
         theirs(in_floats.compared_floats, p.rgb8, p.other8)),
        ("compare: RGB16", 9, plain(nt.compare, p.rgb16, p.other16, **std),
         theirs(in_floats.compared_floats, p.rgb16, p.other16)),
        ("decode: RGB8 to floats", 6, plain(nt.decode, p.rgb8, out=out["32"]),
         theirs(in_floats.decode_floats, p.rgb8, out["32"])),
        ("decode: RGB16 to floats", 6, plain(nt.decode, p.rgb16, out=out["32"]),
         theirs(in_floats.decode_floats, p.rgb16, out["32"])),
        ("decode: RGBA8 to floats", None, plain(nt.decode, p.rgba8, out=out["32"]),
         theirs(in_floats.decode_floats, p.rgba8[..., :3], out["32"])),
        ("decode: XY of 8 bit to floats", None, plain(nt.decode, p.xy8, type="xy", out=out["32"]),
         theirs(in_floats.pairs_floats, p.xy8, out["32"])),
        ("encode: floats to 8 bit", 12, plain(nt.encode, p.vectors, out=o8),
         theirs(in_floats.encode_floats, p.vectors, o8)),
        ("encode: floats to 16 bit", 18, plain(nt.encode, p.vectors, depth=16, out=o16),
         theirs(in_floats.encode_floats, p.vectors, o16)),
        ("rotate by 90: RGB8", 5, plain(nt.transform, p.rgb8, **std, y="up", rotate=90, out=o8),
         theirs(in_floats.turned_floats, p.rgb8, o8)),
        ("rotate by 90: RGB16", 5, plain(nt.transform, p.rgb16, **std, y="up", rotate=90, out=o16),
         theirs(in_floats.turned_floats, p.rgb16, o16)),
        ("rotate by 30: RGB8", None, plain(nt.transform, p.rgb8, **std, y="up", rotate=30, out=o8),
         theirs(in_floats.rotated_floats, p.rgb8, o8)),
        ("strength 1.7: RGB8", 15, plain(nt.transform, p.rgb8, **std, y="up", strength=1.7, out=o8),
         theirs(in_floats.stronger_floats, p.rgb8, o8)),
        ("strength 1.7: RGB16", 15,
         plain(nt.transform, p.rgb16, **std, y="up", strength=1.7, out=o16),
         theirs(in_floats.stronger_floats, p.rgb16, o16)),
        ("strength 1.7: float vectors", None,
         plain(nt.transform, p.vectors, type="vector", y="up", strength=1.7, out=out["32"]),
         theirs(in_floats.stronger_vectors, p.vectors, out["32"])),
        ("blend: RGB8", 21, plain(nt.blend, p.rgb8, p.other8, **std, y="up", detail_y="up", out=o8),
         theirs(in_floats.blend_floats, p.rgb8, p.other8, o8)),
        ("blend: RGB16", 21,
         plain(nt.blend, p.rgb16, p.other16, **std, y="up", detail_y="up", out=o16),
         theirs(in_floats.blend_floats, p.rgb16, p.other16, o16)),
        ("resize to 50 %, triangle: RGB8", 12,
         plain(nt.resize, p.rgb8, **std, size="50%", out=out["half8"]), None),
        ("resize to 50 %, box: RGB8", 12,
         plain(nt.resize, p.rgb8, **std, size="50%", filter="box", out=out["half8"]),
         theirs(in_floats.half_floats, p.rgb8, out["half8"])),
        ("resize to 50 %, box: RGB16", 12,
         plain(nt.resize, p.rgb16, **std, size="50%", filter="box", out=out["half16"]),
         theirs(in_floats.half_floats, p.rgb16, out["half16"])),
        ("resize to 50 %, Lanczos: RGB8", 12,
         plain(nt.resize, p.rgb8, **std, size="50%", filter="lanczos3", out=out["half8"]), None),
        ("resize to 50 %, box: RGBA8", None,
         plain(nt.resize, p.rgba8, **std, size="50%", filter="box", out=out["half8a"]),
         theirs(in_floats.half_with_alpha, p.rgba8, out["half8a"])),
        ("from-height, sobel3: u16 to 16 bit", 9,
         plain(nt.normals_from_height, p.height16, **sobel, depth=16, out=o16),
         theirs(in_floats.slopes_floats, p.height16, p.scale, o16)),
        ("from-height, sobel3: float to 8 bit", 12,
         plain(nt.normals_from_height, p.height32, **sobel, depth=8, out=o8),
         theirs(in_floats.slopes_floats, p.height32, p.scale, o8)),
        ("from-height, sobel3: u16 to float vectors", None,
         plain(nt.normals_from_height, p.height16, **sobel, to="vector", out=out["32"]),
         theirs(in_floats.slope_vectors, p.height16, p.scale, out["32"])),
        ("from-height, sobel3, dithered: u16 to 8 bit", 30,
         plain(nt.normals_from_height, p.height16, **sobel, depth=8, dither="integrable", out=o8),
         None),
    ]  # fmt: skip


# ----------------------------------------------------------------------------------------- times


def spent(call):
    start = time.thread_time()
    call()
    return time.thread_time() - start


def in_copies(call, pictures, rounds):
    """The median over rounds of the time of the call in copies of the picture."""
    copy = functools.partial(np.copyto, pictures.out["8"], pictures.rgb8)
    call(), copy()
    ratios = []
    for i in range(rounds):
        if i % 2 == 0:
            one, other = spent(call), spent(copy)
        else:
            other, one = spent(copy), spent(call)
        ratios.append(one / other)
    return statistics.median(ratios)


def number(value):
    return "" if value is None else f"{value:.1f}" if value < 99.5 else f"{value:.0f}"


def in_corpus():
    """Large normals textures of 8 bits of the corpus, REAL first."""
    if not REAL.exists():
        return []
    with open(CORPUS / "manifest.csv", newline="", encoding="utf-8") as file:
        rows = [r for r in csv.DictReader(file) if r["kind"] == "normals" and r["bit_depth"] == "8"]
    found = [
        CORPUS / r["file"]
        for r in rows
        if r["one_colour"] == "False" and min(int(r["width"]), int(r["height"])) >= LARGE
    ]
    return [REAL, *(path for path in found if path != REAL)]


def textures(args):
    """What `real` and `slowest` are of, one after the other."""
    files = args.files or in_corpus()
    if not files:
        made = nt.normals_from_height(heights(args.size), scale=args.size / 64, depth=8)
        yield tiled(made, args.size)
    for path in files:
        texture = nt.read(path)
        if texture.dtype == np.uint8 and texture.ndim == 3 and texture.shape[2] >= 3:
            yield tiled(texture, args.size)
        else:
            print(f"left out, as it is not RGB of 8 bits: {path}", file=sys.stderr)


def in_turn(pictures, args):
    """{name: time} of all rows of one content."""
    rows = [row for row in operations(pictures) if args.only in row[0]]
    return {name: in_copies(ours, pictures, args.rounds) for name, _, ours, _ in rows}


def measured(args):
    found = textures(args)
    first = Pictures(args.size, next(found))
    real = in_turn(first, args)
    others = [in_turn(Pictures(args.size, texture), args) for texture in found]
    noise = in_turn(Pictures(args.size, None), args)
    for name, goal, _, theirs in operations(first):
        if args.only not in name:
            continue
        slowest = max(times[name] for times in (real, *others))
        beside = in_copies(theirs, first, args.rounds) if theirs is not None else None
        yield name, real[name], slowest, noise[name], noise[name] / slowest, beside, goal


def drawn_pictures(texture):
    """(name, picture, where it is drawn): a texture mixed with each color, and colors with each other."""
    size = len(texture)
    y, x = np.mgrid[:size, :size]
    dots = np.random.default_rng(3).random((size, size)) < 0.5
    places = {"all": x >= 0, "half": x < size // 2, "dots": dots}
    for n in (1, 4, 16, 64):
        places[f"columns of {n}"] = x // n % 2 == 0
        places[f"checkers of {n}"] = (x // n + y // n) % 2 == 0
    for where, drawn in places.items():
        for name, color in COLORS.items():
            picture = np.where(drawn[..., None], np.uint8(color), texture)
            yield f"{name}, {where}", picture, drawn
    for one, other in itertools.combinations(COLORS, 2):
        picture = np.where(dots[..., None], np.uint8(COLORS[one]), np.uint8(COLORS[other]))
        yield f"{one} and {other}, dots", picture, places["all"]


def print_made(args):
    """The worst drawn picture of each row, in times of its slowest texture."""
    first, slowest, worst = None, {}, {}
    for texture in textures(args):
        first = texture if first is None else first
        for row, time_ in in_turn(Pictures(args.size, texture), args).items():
            slowest[row] = max(time_, slowest.get(row, 0))
    for name, picture, drawn in drawn_pictures(first):
        for row, time_ in in_turn(Pictures(args.size, picture, drawn), args).items():
            worst[row] = max((time_ / slowest[row], name), worst.get(row, (0, "")))
    print(f"{'operation':44}{'slowest':>9}{'made/slowest':>14}")
    for row, (ratio, name) in worst.items():
        print(f"{row:44}{number(slowest[row]):>9}{number(ratio):>14}  {name}")


def verdict(real, worst, beside, goal):
    words = ["over its goal"] if goal is not None and real > goal else []
    if worst > NOISE_GOAL:
        words.append("noise is slow")
    if beside is not None and real > beside:
        words.append("slower than OpenCV")
    return ", ".join(words)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("files", nargs="*", type=Path, help="normals textures of 8 bit")
    parser.add_argument("--size", type=int, default=2048)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only", default="", help="rows whose name contains this text")
    parser.add_argument("--markdown", action="store_true", help="the table of docs/performance.md")
    parser.add_argument(
        "--made", action="store_true", help="drawn pictures beside the slowest texture"
    )
    args = parser.parse_args()
    if cv2 is not None:
        cv2.setNumThreads(1)
    if args.made:
        print_made(args)
        return
    missed = 0
    line = (
        "| {} | {} | {} | {} | {} | {} | {} |"
        if args.markdown
        else "{:44}{:>8}{:>9}{:>8}{:>15}{:>15}{:>7}"
    )
    print(line.format(*HEAD))
    if args.markdown:
        print("|---|--:|--:|--:|--:|--:|--:|")
    for name, *times, goal in measured(args):
        words = verdict(times[0], times[3], times[4], goal)
        missed += bool(words)
        row = line.format(name, *map(number, times), "" if goal is None else format(goal, "g"))
        print(row if args.markdown else f"{row}  {words}", flush=True)
    if not args.markdown:
        print(f"{missed} rows beyond a goal" if missed else "all goals met", file=sys.stderr)


main()
