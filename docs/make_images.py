# SPDX-License-Identifier: MIT
"""Makes pictures of the README and of the pages with the built program: make_images.py [NTP]

Each panel is what `ntp` wrote, enlarged without smoothing.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "test_files" / "standard_z_off.png"
ENLARGE = 3
GAP = 12


def panel(path):
    image = Image.open(path).convert("RGB")
    return image.resize((image.width * ENLARGE, image.height * ENLARGE), Image.Resampling.NEAREST)


def beside(panels, name):
    """The panels in a row."""
    width = sum(p.width for p in panels) + GAP * (len(panels) - 1)
    picture = Image.new("RGBA", (width, panels[0].height), (0, 0, 0, 0))
    x = 0
    for p in panels:
        picture.paste(p, (x, 0))
        x += p.width + GAP
    picture.save(ROOT / "docs" / "images" / name, optimize=True)


def before_after(ntp, folder):
    made = {verb: folder / f"{verb}.png" for verb in ("heatmap", "clean")}
    for verb, path in made.items():
        subprocess.run([ntp, verb, "-q", SOURCE, "-o", path], check=True)
    beside([panel(SOURCE), *map(panel, made.values())], "before_after.png")


def compression(ntp, folder):
    """A texture, and the angles to it of DXT5nm, of a plain encoder of BC5, and of ntp's."""
    files = ROOT / "test_files"
    source = files / "standard.png"
    ours = folder / "ours.dds"
    subprocess.run([ntp, "convert", "-q", source, "-o", ours], check=True)
    panels = [panel(source)]
    for texture in (files / "bc3_dxt5nm.dds", files / "bc5.dds", ours):
        heat = folder / f"{texture.stem}.png"
        subprocess.run([ntp, "diff", "-q", source, texture, "-o", heat], check=False)
        panels.append(panel(heat))
    beside(panels, "compression.png")


def main():
    ntp = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build" / "cli" / "ntp"
    with tempfile.TemporaryDirectory() as folder:
        before_after(ntp, Path(folder))
        compression(ntp, Path(folder))


main()
