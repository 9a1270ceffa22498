# SPDX-License-Identifier: MIT
"""Whether Check Normals answers while it looks at a large layer: gimp_check.py [SIDE] [--gimp 2 3]

Opens its window on SIDE x SIDE normals, checks again, and clicks *Colors for everybody* until the
report is there; then it checks once more, and clicks *Stop*.  Prints the milliseconds from a click
to the first pixel of what was clicked that changes, and from *Stop* to the words that say so.  See
gimp_window.py for what it needs; NTP_BUILD is the build directory, NTP_GIMP3 the chroot.
"""

import argparse
import os
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

from gimp_drag import Hand
from gimp_pictures import PLUG_IN, open_gimp, script2, script3
from gimp_window import ROOT, Screen, stones

COLORS = (-168, -143)  # the box of *Colors for everybody*, from the lower right corner
STOP = (170, -83)  # the button *Stop*, from the lower left corner
TEXT = (330, 100)  # the report, from the upper left corner
REACH = 12  # pixels around what is clicked


def write_normals(file, side, program):
    """Those of stones, tiled."""
    folder = file.parent
    Image.fromarray(stones()).save(folder / "stones.png")
    words = ["from-height", "-q", "--scale", "6", folder / "stones.png", "-o", folder / "one.png"]
    subprocess.run([program, *words], check=True)
    one = np.asarray(Image.open(folder / "one.png"))
    Image.fromarray(np.tile(one, (side // 512, side // 512, 1))).save(file, compress_level=1)


class Window:
    def __init__(self, screen, window):
        self.screen, self.hand = screen, Hand(screen.name)
        self.box = screen.box(window)

    def part(self, x, y, width, height):
        return self.screen.pixels[y : y + height, x : x + width]

    def text(self):
        return self.part(*self.box[:2], *TEXT)

    def point(self, x, y):
        self.screen.ask("xdotool", "mousemove", str(x), str(y))
        time.sleep(0.3)  # it lights up where the pointer is

    def click(self, around):
        """Milliseconds until that changes."""
        before, begin = around.copy(), time.perf_counter()
        self.hand.click()
        while np.array_equal(around, before):
            if time.perf_counter() - begin > 60:
                raise TimeoutError("no answer")
            time.sleep(0.001)
        return 1000 * (time.perf_counter() - begin)


def look_again(window):
    """Presses *Check again*; what the window says then."""
    x, y, _, height = window.box
    window.screen.settle(still=3, patience=120)
    window.point(x + STOP[0], y + height + STOP[1])
    window.click(window.text())
    time.sleep(0.1)
    return window.text().copy()


def measure(window):
    x, y, width, height = window.box
    found, looking, begin = [], look_again(window), time.perf_counter()
    at = x + width + COLORS[0], y + height + COLORS[1]
    window.point(*at)
    while np.array_equal(window.text(), looking):
        found.append(window.click(window.part(at[0] - REACH, at[1] - REACH, 2 * REACH, 2 * REACH)))
        time.sleep(0.3)
    taken = time.perf_counter() - begin
    look_again(window)
    time.sleep(0.5)
    return taken, found, window.click(window.text())


def main():
    parser = argparse.ArgumentParser(description="Whether Check Normals answers while it looks")
    parser.add_argument("side", type=int, nargs="?", default=8192)
    parser.add_argument("--gimp", nargs="+", type=int, default=[2, 3], choices=[2, 3])
    parser.add_argument("--display", type=int, default=85)
    given = parser.parse_args()
    program = next(Path(os.environ.get("NTP_BUILD", ROOT / "build")).rglob("cli/ntp"))
    for version in given.gimp:
        with (
            tempfile.TemporaryDirectory() as folder,
            Screen(given.display) as screen,
            open_gimp(version, screen, Path(folder) / "gimp", "en", 1) as gimp,
        ):
            write_normals(gimp.work / "wrong.png", given.side, program)
            gimp.run((script3 if version == 3 else script2)(["wrong"], [PLUG_IN["check"][:2]]))
            shown = screen.window(r"^Is this map right\?")[0]
            screen.place(shown, 0, 0)
            screen.front(shown)
            time.sleep(0.5)
            taken, found, stopped = measure(Window(screen, shown))
        print(
            f"GIMP {version}: looked for {taken:.1f} s; {len(found)} clicks answered after"
            f" {statistics.median(found):.0f} ms, at most {max(found):.0f} ms;"
            f" stopped after {stopped:.0f} ms",
            flush=True,
        )


if __name__ == "__main__":
    main()
