# SPDX-License-Identifier: MIT
"""A folder that normaltexture.report is asked about, and the command."""

import os
import subprocess
import sys

from support import textures
from support.pngs import write_png

GOOD = textures.standard(48, 64)
BAD = textures.wrong_blue(GOOD, 0.1)
HOSTILE = "<img src=x onerror=\"document.title='owned'\">'&amp;{{7*7}}]]>_n.png"


def make_folder(tmp_path):
    """A folder of good and bad textures, of which some have hostile names."""
    place = tmp_path / "textures"
    place.mkdir()
    write_png(place / "good_n.png", GOOD)
    write_png(place / "bad_n.png", BAD)
    write_png(place / "photo.png", textures.photograph())
    write_png(place / HOSTILE, BAD)
    write_png(os.fsencode(place) + b"/caf\xe9\n_n.png", GOOD)
    write_png(place / "\u202egnp.n_live_n.png", GOOD)
    (place / "broken_n.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    return place


def ntp_report(*args, **options):
    command = [sys.executable, "-m", "normaltexture.report._cli", *map(str, args)]
    options.setdefault("text", True)
    return subprocess.run(command, capture_output=True, check=False, **options)
