# SPDX-License-Identifier: MIT
"""Makes the pictures of the README with the built program: make_images.py [NTP]

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


def main():
    ntp = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build" / "cli" / "ntp"
    with tempfile.TemporaryDirectory() as folder:
        made = {verb: Path(folder) / f"{verb}.png" for verb in ("heatmap", "clean")}
        for verb, path in made.items():
            subprocess.run([ntp, verb, "-q", SOURCE, "-o", path], check=True)
        panels = [panel(SOURCE), *map(panel, made.values())]
    width = sum(p.width for p in panels) + GAP * (len(panels) - 1)
    picture = Image.new("RGBA", (width, panels[0].height), (0, 0, 0, 0))
    x = 0
    for p in panels:
        picture.paste(p, (x, 0))
        x += p.width + GAP
    picture.save(ROOT / "docs" / "images" / "before_after.png", optimize=True)


main()
