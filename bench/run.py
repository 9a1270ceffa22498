# SPDX-License-Identifier: MIT
"""Measures the times of `ntp` and of references: run.py BUILD [--pairs N] [--huge] [--only TEXT]

Absolute times mean little on a shared machine, but ratios measured side by side do: A and B
alternate in one run, and the median of the pairwise ratios is compared with the goal.  Both write
to the same directory and both sync what they write.
"""

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
MIB = 1 << 20
NAMES = ("png_copy", "png_decode", "bench_kernels", "bench_to_height")


def spent(command):
    """(seconds, peak bytes) of one process; its output is discarded."""
    start = time.perf_counter()
    process = subprocess.Popen(
        [str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1):
        sys.exit(f"exit {process.returncode}: {' '.join(map(str, command))}")
    return seconds, usage.ru_maxrss * 1024


class Report:
    def __init__(self, only):
        self.only = only
        self.over = []
        print(f"{'':44}{'A':>10}{'B':>10}{'A/B':>8}{'goal':>8}")

    def wanted(self, name):
        return self.only in name

    def row(self, name, a, b, ratio, goal):
        mark = "" if ratio <= goal else "  over"
        if mark:
            self.over.append(name)
        print(
            f"{name:44}{a:>10}{b:>10}{ratio:>8.3f}{'<= ' + format(goal, 'g'):>8}{mark}", flush=True
        )

    def compare(self, name, a, b, goal, pairs, per=(1, 1)):
        """The median over pairs of the ratio of the times of A and B, each divided by its amount of
        work."""
        if not self.wanted(name):
            return
        spent(a), spent(b)  # caches warm, lazy files read
        times = []
        for i in range(pairs):
            order = (a, b) if i % 2 == 0 else (b, a)
            first, second = spent(order[0])[0], spent(order[1])[0]
            times.append((first, second) if i % 2 == 0 else (second, first))
        ratio = statistics.median(x / per[0] / (y / per[1]) for x, y in times)
        a_ms, b_ms = (1000 * statistics.median(column) for column in zip(*times, strict=True))
        self.row(name, f"{a_ms:.1f} ms", f"{b_ms:.1f} ms", ratio, goal)

    def compare_sum(self, name, a, b, goal, pairs):
        """The same if B is a sum of several commands, some of them subtracted."""
        if not self.wanted(name):
            return
        times = []
        for _ in range(pairs):
            other = sum(sign * spent(command)[0] for sign, command in b)
            times.append((spent(a)[0], other))
        ratio = statistics.median(x / y for x, y in times)
        a_ms, b_ms = (1000 * statistics.median(column) for column in zip(*times, strict=True))
        self.row(name, f"{a_ms:.1f} ms", f"{b_ms:.1f} ms", ratio, goal)

    def memory(self, name, command, limit):
        if self.wanted(name):
            peak = spent(command)[1]
            self.row(name, f"{peak / MIB:.1f} MiB", f"{limit / MIB:.0f} MiB", peak / limit, 1)


def programs(build):
    found = {name: build / "bench" / name for name in NAMES}
    found["ntp"] = build / "cli" / "ntp"
    missing = [str(path) for path in found.values() if not path.exists()]
    if missing:
        print(f"not built: {', '.join(missing)}")
    return {name: path if path.exists() else None for name, path in found.items()}


def images(folder, huge):
    stamp = folder / ("done-huge" if huge else "done")
    if not stamp.exists() or stamp.stat().st_mtime < (HERE / "images.py").stat().st_mtime:
        print(f"making textures in {folder}", flush=True)
        option = ["--huge"] if huge else []
        subprocess.run([sys.executable, HERE / "images.py", folder, *option], check=True)
        stamp.touch()


def end_to_end(report, tool, src, out, pairs):
    ntp, copy, decode = tool["ntp"], tool["png_copy"], tool["png_decode"]

    def clean(name):
        return [ntp, "clean", "-q", src / name, "-o", out / "a.png"]

    for label, name in (("RGB8 rock", "rock_n.png"), ("RGB8 bricks", "bricks_n.png")):
        b = [copy, src / name, out / "b.png"]
        report.compare(f"clean {label} / libpng copy", clean(name), b, 0.33, pairs)
        fast = [*clean(name), "--level", "1"]
        report.compare(f"clean --level 1 {label} / libpng copy", fast, b, 0.16, pairs)
    b = [copy, src / "rock16_n.png", out / "b.png"]
    report.compare("clean RGB16 rock / libpng copy", clean("rock16_n.png"), b, 0.33, pairs)
    for label, name in (("RGB8 rock", "rock_n.png"), ("RGB8 bricks", "bricks_n.png")):
        a = [ntp, "check", "-q", src / name]
        report.compare(f"check {label} / libpng decode", a, [decode, src / name], 1.15, pairs)
        a = [ntp, "check", "--format", "json", src / name]  # with the surface of the middle
        report.compare(
            f"check, JSON, {label} / libpng decode", a, [decode, src / name], 1.15, pairs
        )
    b = [copy, src / "small_n.png", out / "b.png"]
    report.compare("clean 256 x 256 / libpng copy", clean("small_n.png"), b, 1.3, 5 * pairs)
    for depth in (8, 16):
        height, normals = src / f"height{depth}.png", out / "n.png"
        a = [ntp, "from-height", "-q", height, "-o", normals, "--scale", "9", "--depth", "8"]
        spent(a)
        # Reading the heights and writing the normals: copying the normals minus reading them.
        b = [(1, [decode, height]), (1, [copy, normals, out / "b.png"]), (-1, [decode, normals])]
        report.compare_sum(f"from-height {depth} bit / libpng", a, b, 1.1, pairs)
    many = [ntp, "clean", "-q", "-r", src / "many", "-o", out / "many", "--jobs"]
    report.compare("clean 8 files, 2 jobs / 1 job", [*many, "2"], [*many, "1"], 0.56, pairs)
    report.memory("clean RGB8 4096 x 4096, peak / limit", clean("rock_n.png"), 64 * MIB)


def huge_image(report, tool, src, out):
    def clean(name):
        return [tool["ntp"], "clean", "-q", src / name, "-o", out / "a.png"]

    a, b = clean("huge_n.png"), clean("rock_sub_n.png")
    per = (32768**2, 4096**2)
    report.compare("texel of 32768 x 32768 / of 4096 x 4096", a, b, 1.2, 3, per)
    report.memory("clean RGB8 32768 x 32768, peak / limit", a, 64 * MIB)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=Path)
    parser.add_argument("--pairs", type=int, default=7)
    parser.add_argument("--huge", action="store_true", help="32768 x 32768 as well: minutes, 4 GB")
    parser.add_argument("--only", default="", help="rows whose name contains this text")
    args = parser.parse_args()
    tool = programs(args.build)
    if tool["bench_kernels"]:
        print("In memory, one thread, caller's buffers:", flush=True)
        for isa in ("base", "avx2"):
            options = ["--isa", isa, "--pairs", str(args.pairs), "--only", args.only]
            subprocess.run([tool["bench_kernels"], *options], check=True)
        print()
    if tool["bench_to_height"] and args.only in "to height":
        print("Normals to heights, in memory:", flush=True)
        subprocess.run([tool["bench_to_height"], "--pairs", str(args.pairs)], check=True)
        if args.huge:
            subprocess.run([tool["bench_to_height"], "--rows", "16384"], check=True)
        print()
    if not all(tool[name] for name in ("ntp", "png_copy", "png_decode")):
        sys.exit("the end-to-end benchmarks need all programs")
    src, out = args.build / "textures", args.build / "bench-out"
    images(src, args.huge)
    out.mkdir(exist_ok=True)
    print("End to end, file to file:")
    report = Report(args.only)
    end_to_end(report, tool, src, out, args.pairs)
    if args.huge:
        huge_image(report, tool, src, out)
    shutil.rmtree(out)
    if report.over:
        print(f"over their goals: {len(report.over)}")


main()
