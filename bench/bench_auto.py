# SPDX-License-Identifier: MIT
"""What detection costs: heights with everything on auto beside given settings.

bench_auto.py [--size N ...] [--kernel NAME] [--only TEXT]

Run it where the package is installed: `./dev bench auto`.  Processor time of one thread; auto and
given alternate, and the median of the ratios counts.  In the columns of the program, reading and writing
PNG count on both sides.  NTP_CORPUS and NTP_REAL name directories of more textures (quality_sets.py).
"""

import argparse
import itertools
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

import normaltexture as nt
from support import drawn_maps
from support.encoders import jpeg

GOAL = 2.5
LARGE, MOST = 1 << 20, 4  # texels of files that count; files of a directory
SETTINGS = ("y", "kernel", "border_x", "border_y", "decode", "z")


def surface(n):
    """A fractal that tiles."""
    f = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None])
    f[0, 0] = np.inf
    noise = np.random.default_rng(1).standard_normal((n, n))
    h = np.fft.irfft2(np.fft.rfft2(noise) / f**2, s=(n, n))
    return ((h - h.min()) / np.ptp(h) * n / 17).astype(np.float32)


def noisy(n):
    added = np.random.default_rng(2).normal(0, 4, n.shape)
    return np.clip(n + added, 0, 255).round().astype(np.uint8)


def drawn(size, kernel="central"):
    whole = nt.normals_from_height(surface(size), 1.0, depth=8, kernel=kernel)
    cut = nt.normals_from_height(surface(2 * size), 1.0, depth=8, kernel=kernel)
    cut = np.ascontiguousarray(cut[30 : size + 30, 20 : size + 20])
    damages = {
        "clean": lambda n: n,
        "JPEG 85": lambda n: jpeg(n, 85, 0),
        "noise of 4 levels": noisy,
        "BC1": drawn_maps.by_blocks,
    }
    for (kind, n), (name, damage) in itertools.product(
        (("tile", whole), ("cut out", cut)), damages.items()
    ):
        yield f"{kind}, {name}", damage(n)
    yield "tile, 16 bit", nt.normals_from_height(surface(size), 1.0, depth=16, kernel=kernel)


def stored():
    """The largest textures of the corpus and of public projects."""
    if not (os.environ.get("NTP_CORPUS") or os.environ.get("NTP_REAL")):
        return
    import quality_sets

    for name, samples in (("corpus", quality_sets.corpus()), ("real", quality_sets.real("seen"))):
        large = (s.pixels for s in samples if s.kind == "standard")
        large = (n for n in large if n.shape[0] * n.shape[1] >= LARGE and min(n.shape[:2]) >= 512)
        for i, n in enumerate(itertools.islice(large, MOST)):
            yield f"{name}, {i + 1}: {n.shape[1]} x {n.shape[0]}", n


def given(n):
    """(what auto needs, what it then finds); the texels may not show which way green points."""
    for asked in ({}, {"y": "up"}):
        try:
            info = nt.height_from_normals_with_info(n, **asked)[1]
        except nt.ArgumentError:
            continue
        return asked, {name: getattr(info, name) for name in SETTINGS}
    return None, None


def in_python(n, how):
    start = time.process_time()
    nt.height_from_normals(n, **how)
    return time.process_time() - start


def by_program(file, out, how):
    options = [f"--{k.replace('_', '-')}={v}" for k, v in how.items()]
    command = [os.environ.get("NTP_PROGRAM") or shutil.which("ntp"), "to-height", "-q"]
    # It warns of textures that are no surface, as many real ones are.
    process = subprocess.Popen(
        [*command, "--jobs=1", *options, file, "-o", out], stderr=subprocess.PIPE
    )
    said = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"exit {process.returncode}: {process.args}: {said.decode()}")
    return usage.ru_utime + usage.ru_stime


def median_of(run, both, pairs):
    """The medians of both times, and of their ratio."""
    times = [[run(how) for how in both] for _ in range(pairs)]
    columns = [*zip(*times, strict=True), [a / b for a, b in times]]
    return [statistics.median(column) for column in columns]


def compare(name, n, pairs, folder):
    """A row of the table, and its ratios."""
    asked, found = given(n)
    if asked is None:
        return []
    known = {"type": "standard", **found}
    a, b, python = median_of(lambda how: in_python(n, how), (asked, known), pairs)
    each = 1e9 / (n.shape[0] * n.shape[1])
    file, out = folder / "n.png", folder / "h.png"
    nt.write(file, n)
    c, d, program = median_of(lambda how: by_program(file, out, how), (asked, known), pairs)
    mark = "" if max(python, program) <= GOAL else "  over"
    print(
        f"{name:32}{a * each:8.1f}{b * each:8.1f} ns{python:7.2f}"
        f"{c * 1e3:10.0f}{d * 1e3:8.0f} ms{program:7.2f}  <= {GOAL}{mark}",
        flush=True,
    )
    return [python, program]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, nargs="+", default=[2048])
    parser.add_argument("--kernel", default="central", help="that made the drawn textures")
    parser.add_argument("--only", default="", help="rows whose name contains this text")
    parser.add_argument("--pairs", type=int, default=5)
    args = parser.parse_args()
    print(f"{'':32}{'Python: auto, given, ratio':>26}{'ntp: auto, given, ratio':>28}")
    ratios = []
    with tempfile.TemporaryDirectory() as folder:
        rows = (
            (f"{size}: {name}", n) for size in args.size for name, n in drawn(size, args.kernel)
        )
        for name, n in itertools.chain(rows, stored()):
            if args.only in name:
                packed = np.ascontiguousarray(n[..., :3])
                ratios.append(compare(name, packed, args.pairs, Path(folder)))
    for i, where in enumerate(("Python", "ntp")):
        column = [row[i] for row in ratios if row]
        over = sum(ratio > GOAL for ratio in column)
        if column:
            print(f"{where}: at most {max(column):.2f}, {over} of {len(column)} over {GOAL}")


if __name__ == "__main__":
    main()
