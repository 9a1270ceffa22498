# SPDX-License-Identifier: MIT
"""The glTF files that most tests of normaltexture.gltf make, and what they ask of reports."""

import subprocess
import sys

import numpy as np

from pysupport import gltf_files as files
from support import textures
from support.pngs import png_bytes, read_png


def green_mirrored(texture):
    return np.dstack([texture[..., 0], 255 - texture[..., 1], texture[..., 2:]])


GOOD = green_mirrored(textures.standard(48, 64))  # up
BAD = textures.wrong_blue(GOOD, 0.2)
COLOR = files.noise_color()
# A KTX2 of ASTC: its header is read, its pixels are not.
NOT_READ = files.ktx2(np.zeros((3, 3, 4), np.uint8), model=162, vulkan=157)
WAYS = ["glb", "files", "data", "bin"]


def model(normals=BAD, slot="normalTexture", **more):
    """A color texture, a normals texture, another color texture."""
    made = files.Model()
    first = made.image("color 1.png", png_bytes(COLOR))
    second = made.image("brick_n.png", png_bytes(normals))
    third = made.image("color 2.png", png_bytes(COLOR[::-1]))
    made.material("Brick \u2603", baseColorTexture=first, **({slot: second} | more))
    made.material("Other", baseColorTexture=third)
    return made


def save(made, tmp_path, how="glb", name="model"):
    return made.save(tmp_path / (name + (".glb" if how == "glb" else ".gltf")), how)


def ids(entry):
    return {found["id"]: found["level"] for found in entry["findings"]}


def pixels(data, tmp_path):
    path = tmp_path / "pixels.png"
    path.write_bytes(data)
    return read_png(path)[0]


def ntp_gltf(*args, **options):
    command = [sys.executable, "-m", "normaltexture.gltf._cli", *map(str, args)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)
