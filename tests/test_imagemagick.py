# SPDX-License-Identifier: MIT
"""The classification of maps that ImageMagick worked on, where it is installed."""

import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image

from support import drawn_maps
from support import libntp_ffi as ntp

# What ImageMagick does to a map, and the classes that may be its answer: with 64 colors or after
# strong blurring little is left of z.
IMAGEMAGICK = {
    "resized.png": (["-resize", "60%"], True),
    "coarse.jpg": (["-sampling-factor", "2x2", "-quality", "80"], True),
    "turned.png": (["-rotate", "180", "-resize", "150%"], True),
    "blurred.png": (["-blur", "0x1.5"], True),
    "tiled.tga": (["-crop", "50%x50%+8+8", "+repage"], True),
    "colors.png": (["-dither", "None", "-colors", "64"], False),
    "gray.png": (["-colorspace", "Gray"], False),
    "negated.png": (["-channel", "G", "-negate"], True),
}


def imagemagick():
    """Other programs are called `convert` too, so it is asked who it is."""
    program = shutil.which("convert")
    if program is None:
        return None
    said = subprocess.run([program, "-version"], capture_output=True, text=True, check=False)
    return program if "ImageMagick" in said.stdout else None


@pytest.fixture(scope="module")
def by_imagemagick(tmp_path_factory):
    """One run of ImageMagick for all pictures: {(kind, name): pixels}."""
    program = imagemagick()
    if program is None:
        pytest.skip("no ImageMagick")
    folder = tmp_path_factory.mktemp("imagemagick")
    command = [program]
    for kind in ("standard", "zzero"):
        made = drawn_maps.draw(kind, "cobbles", "", 5).pixels
        Image.fromarray(made).save(folder / f"{kind}.png")
        command += ["(", f"{kind}.png"]
        for name, (how, _) in IMAGEMAGICK.items():
            command += ["(", "+clone", *how, "-write", f"{kind}-{name}", "+delete", ")"]
        command += [")"]
    subprocess.run([*command, "null:"], cwd=folder, check=True)
    return {
        (kind, name): np.array(Image.open(folder / f"{kind}-{name}").convert("RGB"))
        for kind in ("standard", "zzero")
        for name in IMAGEMAGICK
    }


@pytest.mark.parametrize("kind", ["standard", "zzero"])
@pytest.mark.parametrize("name", IMAGEMAGICK)
def test_imagemagick(by_imagemagick, kind, name):
    result = ntp.classify(by_imagemagick[kind, name], ntp.STANDARD)
    called = drawn_maps.CLASSES[result.type]
    if name == "gray.png":
        assert called == "height"
    elif IMAGEMAGICK[name][1]:
        assert called == kind, result.confidence
    else:
        assert called == kind or result.confidence < 0.9
