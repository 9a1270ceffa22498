# SPDX-License-Identifier: MIT
"""How often libntp is right: quality.py [SECONDS] [--seed N]; NTP_BUILD names the build.

Generates textures of known type, as tests/test_classify.py does, and counts what the classification
and the search for banding say about them; then makes the table of docs/classification.md.

With --tables FILE it counts classes and the direction of green over seven sets (quality_sets.py)
instead, and writes the tables of docs/quality.md between their marks in that file.
"""

import argparse
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import quality_sets as sets
import quality_tables as tables
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


MARKS = "<!-- tables begin -->", "<!-- tables end -->"
TANGENT = ("standard", "zzero", "xy")


def side_of(pixels):
    """(up, down or nothing, confidence): which way green points, by all rows."""
    memory = ntp.aligned(ntp.lib.ntp_orientation_size())
    where = ntp.ffi.cast("ntp_orientation *", memory.__array_interface__["data"][0])
    src = ntp.view(pixels, ntp.STANDARD, const=True)
    ntp.check(ntp.lib.ntp_orientation_add(where, src, 0, 1, ntp.rect(None)))
    found = ntp.ffi.new("ntp_orientation_result *")
    ntp.check(ntp.lib.ntp_orientation_summarize(found, where))
    return ("", "up", "down")[found.decided * (1 + found.y)], found.confidence


def count(title, samples, told, green):
    """Adds to both lists what is said about the samples of one set."""
    classes, sides = tables.Answers(title), tables.Sides(title)
    fitted = tables.Sides(f"{title}, fitted")
    for sample in samples:
        said = ntp.classify(sample.pixels, sample.encoding)
        name = sets.CLASSES[said.type]
        classes.add(sample, name, said.confidence)
        # As in `ntp check`: asked only about textures that are taken for tangent-space normals.
        if sample.y and sample.pixels.shape[2] >= 3 and name in TANGENT:
            (fitted if sample.fitted else sides).add(sample, *side_of(sample.pixels))
    print(f"{title}: {classes.rights()} of {classes.count} right", flush=True)
    for confidence, name, is_one, called in sorted(
        classes.wrong + sides.wrong + fitted.wrong, reverse=True
    ):
        if confidence >= 0.9:
            print(f"  {confidence:.2f} {name}: {is_one} called {called}")
    told += [classes] if classes.count else []
    green += [one for one in (fitted, sides) if one.count + one.undecided]


def all_tables(seed, number):
    """The lines between the marks."""
    told, green = [], []
    count("fitted generator", sets.fitted(number, seed), told, green)
    count("second generator", sets.drawn(number, seed), told, green)
    green.clear()  # neither keeps the direction
    count("second generator, green known", sets.drawn_sides(number, seed), [], green)
    count("other programs", sets.tools(number, seed), told, green)
    count("baked by Blender", sets.baked(), told, green)
    count("public projects", sets.real("seen"), told, green)
    count("held-out projects", sets.real("heldout"), told, green)
    count("corpus", sets.corpus(), told, green)
    day = datetime.now(UTC).date()
    command = f"./dev bench quality --tables docs/quality.md --seed {seed} --count {number}"
    lines = [f"Made by `{command}` on {day}.", ""]
    lines += ["## Classes", "", *tables.overview(told), "", "Right answers by confidence:", ""]
    lines += tables.calibration(told)
    for one in told:
        lines += ["", f"### {one.title[0].upper()}{one.title[1:]}", "", *one.confusion()]
    lines += ["", "## Which way green points", "", *tables.sides_overview(green), ""]
    return [*lines, "Right answers by confidence:", "", *tables.calibration(green)]


def write_tables(path, seed, number):
    text = path.read_text(encoding="utf-8")
    head, _, rest = text.partition(MARKS[0])
    tail = rest.partition(MARKS[1])[2]
    made = "\n".join([MARKS[0], *all_tables(seed, number), MARKS[1]])
    path.write_text(head + made + tail, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("seconds", nargs="?", type=float, default=60)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--tables", type=Path, metavar="FILE")
    parser.add_argument("--count", type=int, default=1000, help="textures drawn for each table")
    arguments = parser.parse_args()
    if arguments.tables:
        write_tables(arguments.tables, arguments.seed, arguments.count)
        return
    draws(arguments.seconds, arguments.seed)
    table(arguments.seed)


if __name__ == "__main__":
    main()
