# SPDX-License-Identifier: MIT
"""GIMP by hand, without a manual: gimp_walk.py DIRECTORY [--gimp 2]

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
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from gimp_pictures import open_gimp, open_operation
from gimp_window import ROOT, Screen, stones

sys.path.insert(0, str(ROOT / "tests"))
from support.gimp2 import saved

SCRIPT3 = """
NI = Gimp.RunMode.NONINTERACTIVE
for name in ('detail', 'stones'):
    image = Gimp.file_load(NI, Gio.File.new_for_path(f'{HERE}/{name}.png'))
    Gimp.Display.new(image)
import os, time
while not os.path.exists(f'{HERE}/walked'):
    time.sleep(0.2)
Gimp.file_save(NI, image, Gio.File.new_for_path(f'{HERE}/made.png'), None)
open(f'{HERE}/saved', 'w').close()
"""
SCRIPT2 = f"""(begin
(define (wait file) (if (not (file-exists? file)) (begin (gimp-version) (wait file))))
(define (open file)
  (let ((image (car (gimp-file-load RUN-NONINTERACTIVE file "x")))) (gimp-display-new image) image))
(open "detail.png")
(let* ((image (open "stones.png")))
  (wait "walked")
  (let* ((layer (car (gimp-image-get-active-drawable image)))) {saved("made.png", "layer")})
  (call-with-output-file "saved" (lambda (port) (write 1 port)))))
"""
TITLES = {2: "Normals from Height", 3: "Normals from Another Layer"}  # of the plug-in
SPLIT_VIEW = {2: (280, 52), 3: (409, 56)}  # in Normals from Height: from the left, from the bottom
AUX = {2: (140, 189), 3: (92, 101)}  # in Blend Normals: its button for the other layer
# In what opens, from the same corner: the image that was opened first, and its layer.
FIRST_IMAGE = {2: (194, 329), 3: (155, 232)}
ITS_LAYER = {2: (399, 305), 3: (379, 216)}


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
        self.gimp, self.screen, self.out, self.version = gimp, gimp.screen, out, gimp.version
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

    def place(self, window, x, y):
        self.screen.place(window, x, y)
        self.screen.front(window)
        self.screen.settle()
        return window

    def dialog(self, title):
        self.screen.search(self.main, title.lower())
        return self.place(self.screen.window(f"^{title}|^Is this map right")[0], 100, 60)

    def operation_dialog(self, name):
        return self.place(open_operation(self.gimp, self.main, name), 970, 0)

    def end(self, window, key=None):
        """Closes a dialog, by OK if by no key."""
        title = next(t for t, found in self.screen.windows().items() if found[0] == window)
        _, _, width, height = self.screen.box(window)
        if key is None:
            self.click(window, (width - 50, height - 20))
        else:
            self.screen.front(window)
            self.screen.key(key)
        self.screen.wait(lambda: title not in self.screen.windows(), f"end of {title}")

    def click(self, window, at):
        x, y, _, _ = self.screen.box(window)
        self.screen.click(x + at[0], y + at[1])
        self.screen.settle()

    def operation(self):
        """The filter on the canvas, in halves; then not."""
        window = self.operation_dialog("normals-from-height")
        _, _, _, height = self.screen.box(window)
        left, below = SPLIT_VIEW[self.version]
        self.click(window, (left, height - below))
        self.picture("2-operation", self.main, window)
        self.end(window, "Escape")

    def normals(self):
        window = self.dialog(TITLES[self.version])
        self.picture("3-normals", window)
        self.end(window, "Return")

    def blend(self):
        window = self.operation_dialog("blend-normals")
        self.click(window, AUX[self.version])
        self.click(window, FIRST_IMAGE[self.version])
        self.picture("4-choose", self.main, window)
        self.click(window, ITS_LAYER[self.version])
        self.screen.key("Return")
        self.screen.settle()
        self.screen.front(window)
        self.screen.settle(still=2)
        self.picture("5-blend", self.main, window)
        self.end(window)

    def check(self):
        window = self.dialog("Check Normals")
        self.picture("6-check", window)
        self.screen.front(window)
        self.screen.key("alt+l")  # Clean, if there is something to clean
        self.screen.settle(still=2)
        self.picture("7-right", window)
        self.end(window, "Escape")


def main():
    parser = argparse.ArgumentParser(description="From heights to a blended, checked, lit texture")
    parser.add_argument("directory", type=Path)
    parser.add_argument("--gimp", type=int, default=3, choices=[2, 3])
    parser.add_argument("--display", type=int, default=85)
    given = parser.parse_args()
    given.directory.mkdir(parents=True, exist_ok=True)
    program = next(Path(os.environ.get("NTP_BUILD", ROOT / "build")).rglob("cli/ntp"))
    with (
        tempfile.TemporaryDirectory() as folder,
        Screen(given.display) as screen,
        open_gimp(given.gimp, screen, Path(folder) / "gimp", "en", 1) as gimp,
    ):
        write_images(gimp.work, program)
        gimp.run(SCRIPT2 if given.gimp == 2 else SCRIPT3)
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
