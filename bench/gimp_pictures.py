# SPDX-License-Identifier: MIT
"""Pictures of every dialog: `gimp_pictures.py DIRECTORY [--gimp 2 3] [--languages en de]
[--scales 1 2] [--only NAME...]`

Each window is also measured: at a scale of 2 it must fit a screen of 1920 x 1080.
See gimp_window.py for what it needs; NTP_BUILD is the build directory, NTP_GIMP3 the chroot.
"""

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

from gimp_window import ROOT, Gimp2, Gimp3, Screen, stones

sys.path.insert(0, str(ROOT / "tests"))
from support.gimp2 import call

PLUG_IN = {
    "normals": ("plug-in-ntp-normals-from-height", "stones", "Normals from"),
    "height": ("plug-in-ntp-height-from-normals", "wrong", "Height from Normals"),
    "check": ("plug-in-ntp-check-normals", "wrong", "Is this map right?"),
    "clean": ("plug-in-ntp-clean-normals", "wrong", "Clean Normals"),
    "resize": ("plug-in-ntp-resize-normals", "wrong", "Resize Normals"),
}
TITLES = {
    (2, "normals"): "Normals from Height",
    (3, "normals"): "Normals from Another Layer",
    (3, "clean"): "Clean Normals by Their Errors",
}
OPERATIONS = {
    "op-normals": ("Normals from Height", "stones"),
    "op-clean": ("Clean Normals", "wrong"),
    "op-transform": ("Transform Normals", "wrong"),
    "op-blend": ("Blend Normals", "wrong"),
    "op-curvature": ("Curvature", "wrong"),
    "op-occlusion": ("Ambient Occlusion", "stones"),
}
NAMES = {
    "op-normals": "normals-from-height",
    "op-clean": "clean-normals",
    "op-transform": "transform-normals",
    "op-blend": "blend-normals",
    "op-curvature": "curvature",
    "op-occlusion": "ambient-occlusion",
}
SCRIPT3 = """
import json
images = {}
for name in json.loads('FILES'):
    image = Gimp.file_load(Gimp.RunMode.NONINTERACTIVE, Gio.File.new_for_path(f'{HERE}/{name}.png'))
    Gimp.Display.new(image)
    images[name] = image
for procedure, name in json.loads('JOBS'):
    p = Gimp.get_pdb().lookup_procedure(procedure)
    config = p.create_config()
    config.set_property('run-mode', Gimp.RunMode.INTERACTIVE)
    config.set_property('image', images[name])
    config.set_core_object_array('drawables', images[name].get_layers())
    p.run(config)
"""


def script2(files, jobs):
    lines = []
    for name in files:
        load = f'(car (gimp-file-load RUN-NONINTERACTIVE "{name}.png" "x"))'
        lines.append(f"(define {name} {load}) (gimp-display-new {name})")
    for procedure, name in jobs:
        text = call(procedure, f"(car (gimp-image-get-active-drawable {name}))")
        text = text.replace("RUN-NONINTERACTIVE image", f"RUN-INTERACTIVE {name}")
        lines.append(f'(gimp-message (if (catch #f {text}) "done" "no"))')
    return f"(begin {' '.join(lines)})"


def script3(files, jobs):
    return SCRIPT3.replace("FILES", json.dumps(files)).replace("JOBS", json.dumps(jobs))


def write_images(folder, program):
    """Heights, and normals that are wrong in some places."""
    heights = np.repeat(stones()[:, :, None], 3, 2)
    Image.fromarray(heights).save(folder / "stones.png")
    words = [
        "from-height",
        "-q",
        "--scale",
        "12",
        folder / "stones.png",
        "-o",
        folder / "wrong.png",
    ]
    subprocess.run([program, *words], check=True)
    wrong = np.asarray(Image.open(folder / "wrong.png")).copy()
    wrong[96:160, 96:224, 2] -= 40
    wrong[300:330, 340:440] = 255 - wrong[300:330, 340:440]
    Image.fromarray(wrong).save(folder / "wrong.png")


def open_gimp(version, screen, folder, language, scale):
    if version == 3:
        return Gimp3(screen, os.environ["NTP_GIMP3"], language, scale)
    return Gimp2(screen, folder, language, scale)


def note(where, label, size, screen, scale):
    fits = size[0] <= 1920 and size[1] <= 1080
    print(f"{label}: {size[0]} x {size[1]}" + ("" if fits else "  TOO LARGE"), flush=True)


def open_operation(gimp, where, title, name):
    """The dialog of an operation; commands of the plug-in may have the words of its title, too."""
    screen = gimp.screen
    if gimp.version == 2:
        screen.search(where, "GEGL")
        dialog = screen.window("GEGL")[0]
        screen.front(dialog)
        return dialog
    words = " ".join(word for word in title.split() if word.isascii())  # what keys can type
    for below in range(4):
        before = set(screen.windows())
        screen.search(where, words, below)
        new = screen.wait(lambda b=before: [t for t in screen.windows() if t not in b], "dialog")
        if f"(ntp:{name})" in new[0]:
            return screen.windows()[new[0]][0]
        screen.front(screen.windows()[new[0]][0])
        screen.key("Escape")
        screen.gone(f"^{re.escape(new[0])}$")
    raise TimeoutError(f"no dialog {name}")


def photograph(gimp, out, label, scale, only):
    """The dialogs of the plug-in one after the other, then those of the operations."""
    screen = gimp.screen
    plug_in = [n for n in PLUG_IN if not only or n in only]
    operations = [n for n in OPERATIONS if not only or n in only]
    jobs = [PLUG_IN[n][:2] for n in plug_in]
    gimp.run((script3 if gimp.version == 3 else script2)(["stones", "wrong"], jobs))
    for name in plug_in:
        title = gimp.text(TITLES.get((gimp.version, name), PLUG_IN[name][2])).replace("?", r"\?")
        window = screen.window(f"^{title}")[0]
        screen.place(window, 0, 0)
        time.sleep(2)
        size = screen.picture(out / f"{label}-{name}.png", window)
        note(out, f"{label}-{name}", size, screen, scale)
        if name == "normals":
            for page in ("forms", "more"):
                screen.front(window)
                screen.key("ctrl+Next")
                screen.picture(out / f"{label}-{name}-{page}.png", window)
        screen.front(window)
        screen.key("Escape")
        screen.gone(f"^{title}")
    for name in operations:
        label_, image = OPERATIONS[name]
        title = gimp.text(label_, "libntp-gegl")
        where = gimp.image_window()[0]
        screen.front(where)
        screen.key(f"alt+{1 + ['stones', 'wrong'].index(image)}")
        screen.settle(still=0.5)
        dialog = open_operation(gimp, where, title, NAMES[name])
        screen.place(dialog, 0, 0)
        screen.front(dialog)
        time.sleep(2)
        size = screen.picture(out / f"{label}-{name}.png", dialog)
        note(out, f"{label}-{name}", size, screen, scale)
        screen.front(dialog)
        screen.key("Escape")
        screen.gone(r"\(ntp:" if gimp.version == 3 else "GEGL")


def main():
    parser = argparse.ArgumentParser(description="Pictures of every dialog in GIMP")
    parser.add_argument("directory", type=Path)
    parser.add_argument("--gimp", nargs="+", type=int, default=[2, 3], choices=[2, 3])
    parser.add_argument("--languages", nargs="+", default=["en", "de"])
    parser.add_argument("--scales", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--only", nargs="+", default=[])
    parser.add_argument("--display", type=int, default=85)
    given = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that what was started ends
    given.directory.mkdir(parents=True, exist_ok=True)
    program = next(Path(os.environ.get("NTP_BUILD", ROOT / "build")).rglob("cli/ntp"))
    for version in given.gimp:
        for scale in given.scales:
            for language in given.languages:
                label = f"gimp{version}-{language}-{scale}x"
                dpi = 96 * scale if version == 2 else 96
                with (
                    tempfile.TemporaryDirectory() as folder,
                    Screen(given.display, dpi=dpi) as screen,
                    open_gimp(version, screen, Path(folder) / "gimp", language, scale) as gimp,
                ):
                    write_images(gimp.work, program)
                    try:
                        photograph(gimp, given.directory, label, scale, given.only)
                    except TimeoutError as error:
                        print(f"{label}: {error}; there are {list(screen.windows())}")
                        screen.picture(given.directory / f"{label}-stuck.png")


if __name__ == "__main__":
    main()
