# SPDX-License-Identifier: MIT
"""GIMP 3 by hand, without a manual: gimp_walk.py DIRECTORY

From the height of a photo to normals, blended with the details of another texture, checked, cleaned
and lit, by keys and clicks alone.  Makes a picture of each step, for the tutorial.  The exit status
tells whether the last report has nothing to repair.  See gimp_window.py for what it needs;
NTP_BUILD is the build directory, NTP_GIMP3 the chroot.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from gimp_window import ROOT, Gimp3, Screen, stones

LOAD = """
NI = Gimp.RunMode.NONINTERACTIVE
for name in ('detail', 'stones'):
    image = Gimp.file_load(NI, Gio.File.new_for_path(f'{HERE}/{name}.png'))
    Gimp.Display.new(image)
"""
SAVE = """
import os, time
while not os.path.exists(f'{HERE}/walked'):
    time.sleep(0.2)
Gimp.file_save(NI, image, Gio.File.new_for_path(f'{HERE}/made.png'), None)
open(f'{HERE}/saved', 'w').close()
"""
SPLIT_VIEW = 409  # of the dialog of Normals from Height, from the left
AUX = (92, 101)  # of the dialog of Blend Normals: its button for the other layer
FIRST_IMAGE = (155, 232)  # in what opens, from the same corner: the image that was opened first
ITS_LAYER = (379, 216)


def write_images(folder, program):
    """Heights of stones, and normals of grain, which tile."""
    Image.fromarray(np.repeat(stones()[:, :, None], 3, 2)).save(folder / "stones.png")
    grain = np.random.default_rng(5).normal(size=(512, 512))
    for axis in (0, 1, 0, 1):
        grain = (grain + np.roll(grain, 1, axis) + np.roll(grain, -1, axis)) / 3
    gray = ((grain - grain.min()) / np.ptp(grain) * 255).round().astype(np.uint8)
    Image.fromarray(gray).save(folder / "grain.png")
    words = ["from-height", "-q", "--scale", "4", folder / "grain.png", "-o", folder / "detail.png"]
    subprocess.run([program, *words], check=True)


class Walk:
    def __init__(self, gimp, out):
        self.gimp, self.screen, self.out = gimp, gimp.screen, out
        self.main = gimp.image_window()[0]
        self.screen.place(self.main, 0, 0, 960, 680)

    def picture(self, name, *windows):
        """Of one window, or of all that the given ones span."""
        screen = self.screen
        screen.park()
        screen.settle(still=2)  # a tip goes
        boxes = np.array([screen.box(window) for window in windows])
        left, top = boxes[:, :2].min(0)
        right, bottom = (boxes[:, :2] + boxes[:, 2:]).max(0)
        shown = Image.fromarray(screen.grab()[top:bottom, left:right])
        few = shown.quantize(256, dither=Image.Dither.NONE)  # as many colors as docs/images has
        few.save(self.out / f"{name}.png", optimize=True)
        print(name, flush=True)

    def dialog(self, command, title, x=970, y=0, below=0):
        self.screen.search(self.main, command, below)
        window = self.screen.window(title)[0]
        self.screen.place(window, x, y)
        self.screen.front(window)
        self.screen.settle()
        return window

    def click(self, window, at):
        x, y, _, _ = self.screen.box(window)
        self.screen.click(x + at[0], y + at[1])
        self.screen.settle()

    def operation(self):
        """The filter on the canvas, in halves; then not."""
        title = r"\(ntp:normals-from-height\)"
        window = self.dialog("ntp:normals-from-height", title)
        _, _, _, height = self.screen.box(window)
        self.click(window, (SPLIT_VIEW, height - 56))
        self.picture("2-operation", self.main, window)
        self.screen.front(window)
        self.screen.key("Escape")
        self.screen.gone(title)

    def normals(self):
        title = "Normals from Another Layer"
        window = self.dialog(title.lower(), title, 100, 60)
        self.picture("3-normals", window)
        self.screen.front(window)
        self.screen.key("Return")
        self.screen.gone(title)

    def blend(self):
        title = r"\(ntp:blend-normals\)"
        window = self.dialog("ntp:blend-normals", title, below=1)  # the first takes a file
        self.click(window, AUX)
        self.click(window, FIRST_IMAGE)
        self.picture("4-choose", self.main, window)
        self.click(window, ITS_LAYER)
        self.screen.key("Return")
        self.screen.settle()
        self.picture("5-blend", self.main, window)
        _, _, width, height = self.screen.box(window)
        self.click(window, (width - 50, height - 20))  # OK
        self.screen.gone(title)

    def check(self):
        title = r"Is this map right"
        window = self.dialog("check normals", title, 100, 60)
        self.picture("6-check", window)
        self.screen.front(window)
        self.screen.key("alt+l")  # Clean, if there is something to clean
        self.screen.settle(still=2)
        self.picture("7-right", window)
        self.screen.front(window)
        self.screen.key("Escape")
        self.screen.gone(title)


def main():
    parser = argparse.ArgumentParser(description="From heights to a blended, checked, lit texture")
    parser.add_argument("directory", type=Path)
    parser.add_argument("--display", type=int, default=85)
    given = parser.parse_args()
    given.directory.mkdir(parents=True, exist_ok=True)
    program = next(Path(os.environ.get("NTP_BUILD", ROOT / "build")).rglob("cli/ntp"))
    with Screen(given.display) as screen, Gimp3(screen, os.environ["NTP_GIMP3"]) as gimp:
        write_images(gimp.work, program)
        gimp.run(LOAD + SAVE)
        walk = Walk(gimp, given.directory)
        walk.picture("1-heights", walk.main)
        walk.operation()
        walk.normals()
        walk.blend()
        walk.check()
        (gimp.work / "walked").touch()
        screen.wait((gimp.work / "saved").exists, "saved image")
        command = [program, "check", "--format", "json", gimp.work / "made.png"]
        said = subprocess.run(command, capture_output=True, check=False).stdout
    found = json.loads(said)["files"][0]
    print(f"ntp check: {found['type']}, {found['fail']['neighbor']} texels fail")
    return int(found["fail"]["neighbor"] > 0)


if __name__ == "__main__":
    sys.exit(main())
