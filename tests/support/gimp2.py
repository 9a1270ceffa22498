# SPDX-License-Identifier: MIT
"""Runs GIMP 2.10 without a window, on Script-Fu that is made from calls of the plug-in."""

import os
import re
import shutil
import subprocess
from pathlib import Path

PROGRAM = "gimp-console-2.10"

# The arguments of each procedure after the drawable, in their order, with their defaults.
ARGUMENTS = {
    "plug-in-ntp-normals-from-height": {
        "scale": 10,
        "kernel": "central",
        "border-x": "wrap",
        "border-y": "wrap",
        "source": "red",
        "invert": 0,
        "to-y": "up",
        "to": "standard",
        "min-z": 0,
        "alpha": "keep",
        "dx": 1,
        "dy": 1,
        "blue": "derived",
        "height-layer": -1,
        "alpha-layer": -1,
        "flip-x": 0,
        "swap-rgb": 0,
        "dudv": "none",
        "preset": "none",
        "strength": 1,
        "blur": 0,
        "small": 1,
        "middle": 1,
        "large": 1,
        "channels": "xyz",
        "dither": "none",
        "occlusion": 0,
        "force": 0,
    },
    "plug-in-ntp-height-from-normals": {
        "border-x": "extrapolate",
        "border-y": "extrapolate",
        "from-y": "up",
        "from": 3,
        "method": 0,
        "kernel": "central",
        "decode": 0,
        "z": 0,
        "invert": 0,
        "contrast": 0,
        "result": 0,
    },
    "plug-in-ntp-check-normals": {"from": 0, "keep-negative-z": 0, "remedy": "none"},
    "plug-in-ntp-clean-normals": {
        "method": 2,
        "from": 0,
        "keep-negative-z": 0,
        "only-failing": 0,
        "verdict": 0,
        "touch-unused": 0,
        "undo": 0,
    },
    "plug-in-ntp-resize-normals": {
        "percent": 50,
        "width": 0,
        "height": 0,
        "scope": "image",
        "filter": "triangle",
        "border-x": "wrap",
        "border-y": "wrap",
        "from": 0,
    },
    "plug-in-normalmap": {
        "filter": 0,
        "minz": 0,
        "scale": 1,
        "wrap": 0,
        "height-source": 0,
        "alpha": 0,
        "conversion": 0,
        "dudv": 0,
        "xinvert": 0,
        "yinvert": 0,
        "swapRGB": 0,
        "contrast": 0,
        "alphamap": -1,
    },
}
CHOICES = {
    "kernel": "central forward prewitt3 sobel3 scharr3 prewitt5 sobel5 gimp5 gimp7 gimp9",
    "border-x": "wrap clamp mirror extrapolate repeat-slope",
    "border-y": "wrap clamp mirror extrapolate repeat-slope",
    "source": "red green blue alpha luma luma-gimp luma-eberly mean max min screen biased luminance",
    "to-y": "up down",
    "from-y": "up down",
    "to": "standard zzero xy",
    "from": "standard zzero xy",
    "alpha": "keep one zero inverse height inverse-height layer",
    "blue": "derived nearest",
    "scope": "image layer",
    "filter": "triangle box lanczos3",
    "dudv": "none 8-signed 8-unsigned 16-signed 16-unsigned",
    "preset": "none unreal unity godot source labpbr gimp gimp-normalmap",
    "channels": "xyz zyx xzy 1y0x",
    "dither": "none integrable",
    "remedy": "none undo clean standard green",
}


def call(procedure, layer="layer", **given):
    """The Script-Fu that calls a procedure with these arguments, by name."""
    values = dict(ARGUMENTS[procedure])
    for name, value in given.items():
        name = name.replace("_", "-")
        assert name in values, name
        values[name] = value
    numbers = []
    for name, value in values.items():
        if isinstance(value, str) and value in CHOICES.get(name, "").split():
            value = CHOICES[name].split().index(value)
        numbers.append(str(value))
    return f"({procedure} RUN-NONINTERACTIVE image {layer} {' '.join(numbers)})"


def normals(**given):
    return call("plug-in-ntp-normals-from-height", **given)


# GIMP reads and writes PNG in a process of its own, which takes longer than the plug-in.  What many
# jobs of a batch open is read once, and XCF is written by GIMP itself.
ORIGINALS = """(define originals '())
(define (original file)
  (let ((known (assoc file originals)))
    (if known (cdr known)
        (let ((image (car (gimp-file-load RUN-NONINTERACTIVE file "x"))))
          (set! originals (cons (cons file image) originals))
          image))))"""
SHARED = re.compile("(gray|rgb|rough)")  # the name of a copy is not looked at: it has none


def opened(file, body):
    """Script-Fu with `image` and its `layer`."""
    image = f'(gimp-file-load RUN-NONINTERACTIVE "{file}" "x")'
    if SHARED.match(file):
        image = f'(gimp-image-duplicate (original "{file}"))'
    return f"""(let* ((image (car {image}))
                      (layer (car (gimp-image-get-active-drawable image))))
                 {body}
                 (gimp-image-delete image))"""


def saved(file, layer=None):
    """Script-Fu that saves a layer as PNG: its numbers, also under alpha 0.  An image whose only layer
    it is becomes an XCF file of that name."""
    if layer is None:
        return stored(file.replace(".png", ".xcf"))
    return f'(file-png-save2 RUN-NONINTERACTIVE image {layer} "{file}" "x" 0 1 0 0 0 0 0 0 1)'


def stored(file):
    """Script-Fu that saves the image as XCF: its layer's samples as they are."""
    layer = "(car (gimp-image-get-active-drawable image))"
    return f'(gimp-xcf-save RUN-NONINTERACTIVE image {layer} "{file}" "x")'


def marked(name, body):
    """Script-Fu that says where it begins and that it came to its end."""
    begin, done = (f'(gimp-message "job-{name}-{end}")' for end in ("begin", "done"))
    return f"{begin} {body} {done}"


# Modules of GEGL that read and write files and devices: GIMP has plug-ins for these.
NOT_NEEDED = re.compile(r"-(load|save)\.so$|^(v4l|lcms-from-profile|matting-levin)\.so$")


def gegl_modules(folder):
    """A directory with the modules of GEGL that GIMP needs.  Each start of a plug-in loads all that
    there are, and the libraries that these need: FFmpeg, Poppler and many others."""
    query = ["pkg-config", "--variable=pluginsdir", "gegl-0.4"]
    there = subprocess.run(query, capture_output=True, text=True, check=True).stdout.strip()
    folder.mkdir()
    for file in Path(there).glob("*.so"):
        if not NOT_NEEDED.search(file.name):
            (folder / file.name).symlink_to(file)
    return folder


class Gimp2:
    """GIMP 2.10 with our plug-in, in directories of its own."""

    def __init__(self, plugin, work):
        self.work = work
        self.modules = gegl_modules(work / "gegl")
        place = work / "profile" / "plug-ins" / "ntp-normals"
        place.mkdir(parents=True)
        shutil.copy(plugin, place / "ntp-normals")
        self.log = ""

    def run(self, jobs, refused):
        """Does all jobs in one start of GIMP: {name: Script-Fu} -> {name: its messages}.

        Each -b starts Script-Fu anew, which takes as long as a job.  An error ends one -b only, so
        that those which are to fail have one each.
        """
        command = [PROGRAM, "-i", "-d", "-f"]
        names = list(jobs)
        for batch in [names[i : i + 10] for i in range(0, len(names), 10)] + [[n] for n in refused]:
            bodies = (marked(name, jobs.get(name) or refused[name]) for name in batch)
            command += ["-b", f"(begin {ORIGINALS} {' '.join(bodies)})"]
        command += ["-b", "(gimp-quit 0)"]
        environment = dict(os.environ, GIMP2_DIRECTORY=str(self.work / "profile"), LC_ALL="C.UTF-8")
        environment["HOME"] = str(self.work)
        environment.pop("LD_PRELOAD", None)  # of sanitizers: for Python only
        environment["GEGL_USE_OPENCL"] = "no"
        environment["GEGL_PATH"] = str(self.modules)
        # With a cache of conversions each start measures 360 MB of tables, to see if they pay.
        environment["BABL_INHIBIT_CACHE"] = "1"
        done = subprocess.run(
            command,
            cwd=self.work,
            env=environment,
            capture_output=True,
            text=True,
            timeout=900,
            check=False,
        )
        self.log = done.stdout + done.stderr
        parts = re.split(r"job-([\w.-]+)-begin\n", self.log)
        return dict(zip(parts[1::2], parts[2::2], strict=True))
