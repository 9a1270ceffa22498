# SPDX-License-Identifier: MIT
"""Pictures of every dialog: `gimp_pictures.py DIRECTORY [--gimp 2 3] [--languages en de]
[--scales 1 2] [--only NAME...]`

Each window is also measured: at a scale of 2 it must fit a screen of 1920 x 1080.
See gimp_window.py for what it needs; NTP_BUILD is the build directory, NTP_GIMP3 the chroot.
"""

import argparse
import json
import os
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
    "op-normals": ("normals-from-height", "stones", "Normals from Height"),
    "op-clean": ("clean-normals", "wrong", "Clean Normals"),
    "op-transform": ("transform-normals", "wrong", "Transform Normals"),
    "op-blend": ("blend-normals", "wrong", "Blend Normals"),
    "op-blend-file": ("blend-normals-file", "wrong", "Blend Normals with a File"),
    "op-curvature": ("curvature", "wrong", "Curvature"),
    "op-occlusion": ("ambient-occlusion", "stones", "Ambient Occlusion"),
}
# What else is in the list of GIMP 2.10's tool, which is in the order of bytes.
LISTED = {
    "en": (
        "Absolute",
        "Bilateral Filter",
        "Box Blur",
        "Brightness Contrast",
        "Color Assimilation Grid",
        "Color Overlay",
        "Color warp",
        "Denoise DCT",
        "Fractal Explorer",
        "Levels",
        "Negative Darkroom",
        "Pack",
        "Smooth by Domain Transform",
        "Unpremultiply alpha",
    ),
    "de": (
        "Absolut",
        "Bilateraler Filter",
        "Box-Weichzeichner",
        "Denoise DCT",
        "Farb-Assimilation-Raster",
        "Farben verzerren",
        "Farbwerte",
        "Farbüberlagerung",
        "Fraktal-Explorer",
        "Helligkeitskontrast",
        "Negativ-Dunkelkammer",
        "Packen",
        "Vormultiplikation von Alpha rückgängig machen",
        "Weichzeichnen durch Domänentransformation",
    ),
}
# The choice of a page in the dialog of the operation, from the top, at each scale.
PAGES = {2: {1: 175, 2: 274}, 3: {1: 89, 2: 178}}
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
        lines.append(f"(catch #f {text})")
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


def note(label, screen, window):
    """What does not fit the screen is said."""
    _, _, width, height = screen.box(window)
    fits = width <= screen.width and height <= screen.height
    print(f"{label}: {width} x {height}" + ("" if fits else "  TOO LARGE"), flush=True)


def above(gimp, name):
    """How many operations are above it in the list of GIMP 2.10."""
    titles = {words[0]: gimp.text(words[2], "libntp-gegl") for words in OPERATIONS.values()}
    known = [*titles.values(), *LISTED[gimp.language]]
    return sum(other.encode() < titles[name].encode() for other in known)


def open_operation(gimp, main, name):
    """The dialog of an operation."""
    screen = gimp.screen
    if gimp.version == 3:
        # That with a file is found first.
        screen.search(main, f"ntp:{name}", below=name == "blend-normals")
        return screen.window(rf"\(ntp:{name}\)")[0]
    screen.search(main, "GEGL")
    dialog = screen.window("GEGL")[0]
    screen.place(dialog, 0, 0)
    screen.front(dialog)
    screen.settle()
    x, y, width, _ = screen.box(dialog)
    screen.click(x + width // 2, y + 54 * gimp.scale)
    screen.park()  # where it does not scroll the list
    screen.settle(still=0.5)
    screen.key("Home", *["Down"] * above(gimp, name), "Return")
    screen.settle(still=3)  # the list goes when the preview is there
    return dialog


def photograph(gimp, out, label, only):
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
        screen.picture(out / f"{label}-{name}.png", window)
        note(f"{label}-{name}", screen, window)
        if name == "normals":
            screen.front(window)
            if gimp.version == 3:
                screen.key("Tab")  # from OK to the tabs
            for page in ("forms", "more"):
                screen.front(window)
                screen.key("ctrl+alt+Next")
                screen.picture(out / f"{label}-{name}-{page}.png", window)
        screen.front(window)
        screen.key("Escape")
        screen.gone(f"^{title}")
    for name in operations:
        operation, image, _ = OPERATIONS[name]
        main = gimp.image_window()[0]
        screen.front(main)
        screen.key(f"alt+{1 + ['stones', 'wrong'].index(image)}")
        screen.settle(still=0.5)
        dialog = open_operation(gimp, main, operation)
        screen.place(dialog, 0, 0)
        screen.front(dialog)
        time.sleep(2)
        screen.picture(out / f"{label}-{name}.png", dialog)
        note(f"{label}-{name}", screen, dialog)
        for page in ("forms", "more"):
            if name == "op-normals":
                left, top, width, _ = screen.box(dialog)
                screen.click(left + width // 2, top + PAGES[gimp.version][gimp.scale])
                screen.settle(still=0.5)
                screen.key("Down", "Return")
                screen.settle(still=3)
                screen.picture(out / f"{label}-{name}-{page}.png", dialog)
                note(f"{label}-{name}-{page}", screen, dialog)
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
                        photograph(gimp, given.directory, label, given.only)
                    except TimeoutError as error:
                        print(f"{label}: {error}; there are {list(screen.windows())}")
                        screen.picture(given.directory / f"{label}-stuck.png")


if __name__ == "__main__":
    main()
