# SPDX-License-Identifier: MIT
"""How long GIMP 3 takes to show a change of a slider: gimp_drag.py [SIDE] [--steps N]

Strength of Normals from Height beside Scale of GIMP's own Normal Map filter, on the canvas of an
image of SIDE x SIDE, from a click on its plus or minus to the first and to the last
pixel that changes.  The filters take turns.  See gimp_window.py for what it needs; NTP_GIMP3
is the chroot.
"""

import argparse
import ctypes
import os
import statistics
import time

import numpy as np
from PIL import Image

from gimp_window import Gimp3, Screen, stones

OURS, THEIRS = "Normals from Height", "GIMP's Normal Map"
# The buttons of the slider, plus and minus, from the upper right corner of the dialog.
SLIDERS = {OURS: ((-20, 144), (-39, 144)), THEIRS: ((-20, 89), (-39, 89))}
QUIET = 1.5  # seconds without a change: the picture is done
LOAD = """
image = Gimp.file_load(Gimp.RunMode.NONINTERACTIVE, Gio.File.new_for_path(HERE + '/heights.png'))
Gimp.Display.new(image)
"""


class Hand:
    """Clicks without a process for each."""

    def __init__(self, display):
        self.x11 = ctypes.CDLL("libX11.so.6")
        self.test = ctypes.CDLL("libXtst.so.6")
        self.x11.XOpenDisplay.restype = ctypes.c_void_p
        self.display = ctypes.c_void_p(self.x11.XOpenDisplay(display.encode()))

    def click(self):
        for down in (1, 0):
            self.test.XTestFakeButtonEvent(self.display, 1, down, 0)
        self.x11.XSync(self.display, 0)


def open_dialog(gimp, name):
    screen, main = gimp.screen, gimp.image_window()[0]
    before = set(screen.windows())
    words = "Generate a normal map" if name == THEIRS else "ntp:normals-from-height"
    screen.search(main, words)
    title = screen.wait(lambda: set(screen.windows()) - before, "dialog").pop()
    dialog = screen.windows()[title][0]
    screen.place(dialog, 1400, 40)
    screen.front(dialog)
    screen.settle()
    screen.settle(still=QUIET)
    return dialog


def watch(canvas, begin):
    """Milliseconds from begin to the first and to the last change."""
    last = canvas.copy()
    first = end = None
    while time.perf_counter() - (end or begin) < (QUIET if end else 40):
        now = canvas.copy()
        if not np.array_equal(now, last):
            end = time.perf_counter()
            first = first or end
            last = now
        time.sleep(0.001)
    if first is None:
        raise TimeoutError("the slider changed nothing")
    return 1000 * (first - begin), 1000 * (end - begin)


def measure(gimp, name, steps):
    screen = gimp.screen
    dialog = open_dialog(gimp, name)
    x, y, width, _ = screen.box(dialog)
    buttons = [(x + width + right, y + down) for right, down in SLIDERS[name]]
    x, y, width, height = screen.box(gimp.image_window()[0])
    canvas = screen.pixels[y + 150 : y + height - 100, x + 300 : x + width - 420]
    found = []
    hand = Hand(screen.name)
    for step in range(steps + 1):
        x, y = buttons[step % 2]
        screen.ask("xdotool", "mousemove", str(x), str(y))
        time.sleep(0.5)
        hand.click()
        found.append(watch(canvas, time.perf_counter()))
    screen.front(dialog)
    screen.key("Escape")
    screen.settle(still=QUIET)
    return found[1:]  # the first fills caches


def bench(gimp, side, steps):
    image = np.tile(np.repeat(stones()[:, :, None], 3, 2), (side // 512, side // 512, 1))
    Image.fromarray(image).save(gimp.work / "heights.png", compress_level=1)
    gimp.run(LOAD)
    main = gimp.image_window()[0]
    gimp.screen.place(main, 0, 0, 1380, 1000)
    gimp.screen.settle(still=QUIET)
    times = {OURS: [], THEIRS: []}
    for _ in range(2):
        for name, found in times.items():
            found += measure(gimp, name, steps)
    for name, found in times.items():
        first, last = (statistics.median(t) for t in zip(*found, strict=True))
        quickest = min(end for _, end in found)
        print(
            f"{name:20} first pixel {first:6.0f} ms"
            f"  last {last:6.0f} ms  at best {quickest:6.0f} ms  ({len(found)} steps)",
            flush=True,
        )


def main():
    parser = argparse.ArgumentParser(description="How long GIMP takes to show a change of a slider")
    parser.add_argument("side", type=int, nargs="?", default=4096)
    parser.add_argument("--steps", type=int, default=10)
    parser.add_argument("--display", type=int, default=85)
    given = parser.parse_args()
    with Screen(given.display) as screen, Gimp3(screen, os.environ["NTP_GIMP3"]) as gimp:
        bench(gimp, given.side, given.steps)


if __name__ == "__main__":
    main()
