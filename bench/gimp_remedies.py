# SPDX-License-Identifier: MIT
"""Presses each button of Check Normals in a window, and undoes it: gimp_remedies.py DIRECTORY
[--gimp 2 3]

The result must be that of the verb of `ntp`, and after Undo the layer must be what it was.
DIRECTORY gets a picture of the window before and after each.  See gimp_window.py for what it needs;
NTP_BUILD is the build directory, NTP_GIMP3 the chroot.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from gimp_window import ROOT, Gimp2, Gimp3, Screen

sys.path.insert(0, str(ROOT / "tests"))
from support import pngs
from support.gimp2 import saved
from support.plugin_cases import REMEDIES

KEYS = {"undo": "alt+n", "clean": "alt+l", "standard": "alt+s", "green": "alt+f"}
TITLE = r"^Is this map right\?"
SCRIPT3 = """
import os, time
NI = Gimp.RunMode.NONINTERACTIVE
def save(image, file):
    Gimp.file_save(NI, image, Gio.File.new_for_path(f'{HERE}/{file}'), None)
for name in NAMES:
    image = Gimp.file_load(NI, Gio.File.new_for_path(f'{HERE}/in-{name}.png'))
    display = Gimp.Display.new(image)
    p = Gimp.get_pdb().lookup_procedure('plug-in-ntp-check-normals')
    config = p.create_config()
    config.set_property('run-mode', Gimp.RunMode.INTERACTIVE)
    config.set_property('image', image)
    config.set_core_object_array('drawables', image.get_layers())
    p.run(config)
    save(image, f'after-{name}.png')
    open(f'{HERE}/saved-{name}', 'w').close()
    while not os.path.exists(f'{HERE}/undone-{name}'):
        time.sleep(0.1)
    save(image, f'again-{name}.png')
    display.delete()
    open(f'{HERE}/closed-{name}', 'w').close()
"""
SCRIPT2 = """
(define (note file) (call-with-output-file file (lambda (port) (write 1 port))))
(define (wait file) (if (not (file-exists? file)) (begin (gimp-version) (wait file))))
(define (check name)
  (let* ((file (lambda (begin) (string-append begin name ".png")))
         (image (car (gimp-file-load RUN-NONINTERACTIVE (file "in-") "x")))
         (layer (car (gimp-image-get-active-drawable image)))
         (display (car (gimp-display-new image))))
    (plug-in-ntp-check-normals RUN-INTERACTIVE image layer 0 0 0)
    (save image layer (file "after-"))
    (note (string-append "saved-" name))
    (wait (string-append "undone-" name))
    (save image layer (file "again-"))
    (gimp-display-delete display)
    (note (string-append "closed-" name))))
"""


def script(version, names):
    if version == 3:
        return SCRIPT3.replace("NAMES", repr(names))
    save = saved("FILE", "layer").replace('"FILE"', "file")
    calls = " ".join(f'(check "{name}")' for name in names)
    return f"(begin {SCRIPT2} (define (save image layer file) {save}) {calls})"


def same(a, b):
    a, b = (pngs.read_png(file)[0] for file in (a, b))
    shared = b.shape[2]  # a layer keeps its alpha channel
    return not (a[:, :, :shared] != b).any() and (a[:, :, shared:] == 255).all()


def press(gimp, name, out, program):
    screen, work = gimp.screen, gimp.work
    file, remedy = name.rsplit("-", 1)
    window = screen.window(TITLE)[0]
    screen.place(window, 0, 0)
    screen.picture(out / f"gimp{gimp.version}-{name}-before.png", window)
    screen.front(window)
    screen.key(KEYS[remedy])
    screen.settle(window, still=1.5)
    screen.picture(out / f"gimp{gimp.version}-{name}-after.png", window)
    screen.front(window)
    screen.key("Escape")
    screen.wait((work / f"saved-{name}").exists, "saved image")
    screen.front(gimp.image_window()[0])
    screen.key("ctrl+z")
    screen.settle(still=1)
    (work / f"undone-{name}").touch()
    screen.wait((work / f"closed-{name}").exists, "image saved again")
    verb, *words = REMEDIES[name]
    source, expected = ROOT / "test_files" / f"{file}.png", work / f"ntp-{name}.png"
    subprocess.run([program, verb, "-q", *words, source, "-o", expected], check=True)
    right = same(work / f"after-{name}.png", expected)
    back = same(work / f"again-{name}.png", source)
    words = (
        "as ntp" if right else "NOT as ntp",
        "undo brings it back" if back else "undo does NOT bring it back",
    )
    print(f"GIMP {gimp.version}, {name}: {', '.join(words)}", flush=True)
    return right and back


def main():
    parser = argparse.ArgumentParser(description="Presses the buttons of Check Normals")
    parser.add_argument("directory", type=Path)
    parser.add_argument("--gimp", nargs="+", type=int, default=[2, 3], choices=[2, 3])
    parser.add_argument("--display", type=int, default=85)
    given = parser.parse_args()
    given.directory.mkdir(parents=True, exist_ok=True)
    program = next(Path(os.environ.get("NTP_BUILD", ROOT / "build")).rglob("cli/ntp"))
    right = True
    for version in given.gimp:
        with tempfile.TemporaryDirectory() as folder, Screen(given.display) as screen:
            where = os.environ["NTP_GIMP3"] if version == 3 else Path(folder) / "gimp"
            with (Gimp3 if version == 3 else Gimp2)(screen, where) as gimp:
                for name in REMEDIES:
                    file = name.rsplit("-", 1)[0]
                    shutil.copy(ROOT / "test_files" / f"{file}.png", gimp.work / f"in-{name}.png")
                gimp.run(script(version, list(REMEDIES)))
                for name in REMEDIES:
                    right = press(gimp, name, given.directory, program) and right
    return 0 if right else 1


if __name__ == "__main__":
    sys.exit(main())
