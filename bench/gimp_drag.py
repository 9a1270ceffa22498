# SPDX-License-Identifier: MIT
"""How long GIMP takes to show a change of a slider: gimp_drag.py [SIDE] [--steps N] [--gimp 2]

Strength of Normals from Height beside Scale of GIMP's own Normal Map filter, on the canvas of an
image of SIDE x SIDE, from a click on its plus or minus to the first and to the last
pixel that changes.  The filters take turns.  See gimp_window.py for what it needs; NTP_GIMP3
is the chroot.
"""

import argparse
import ctypes
import statistics
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

from gimp_pictures import open_gimp, open_operation
from gimp_window import Screen, stones

OURS, THEIRS = "Normals from Height", "GIMP's Normal Map"
# The buttons of the slider, plus and minus, from the upper right corner of the dialog.
SLIDERS = {
    2: {OURS: ((-13, 233), (-13, 241)), THEIRS: ((-13, 89), (-13, 97))},
    3: {OURS: ((-20, 144), (-39, 144)), THEIRS: ((-20, 89), (-39, 89))},
}
QUIET = 1.5  # seconds without a change: the picture is done
LOAD2 = """
(gimp-display-new (car (gimp-file-load RUN-NONINTERACTIVE "heights.png" "x")))
"""
LOAD3 = """
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
    if name == OURS:
        dialog = open_operation(gimp, main, "normals-from-height")
    else:
        before = set(screen.windows())
        screen.search(main, "Generate a normal map")
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
    buttons = [(x + width + right, y + down) for right, down in SLIDERS[gimp.version][name]]
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
    gimp.run(LOAD2 if gimp.version == 2 else LOAD3)
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
    parser.add_argument("--gimp", type=int, default=3, choices=[2, 3])
    parser.add_argument("--display", type=int, default=85)
    given = parser.parse_args()
    with (
        tempfile.TemporaryDirectory() as folder,
        Screen(given.display) as screen,
        open_gimp(given.gimp, screen, Path(folder) / "gimp", "en", 1) as gimp,
    ):
        bench(gimp, given.side, given.steps)


if __name__ == "__main__":
    main()
