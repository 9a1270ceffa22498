# SPDX-License-Identifier: MIT
"""The operations run by the program `gegl`: progress, nothing to do, the README, mistakes."""

import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from support import libntp_ffi as ffi_lib
from support import pngs
from support.gegl_pictures import picture, rough_normals, to_options


def test_progress_ends(gegl_env, tmp_path):
    """GIMP takes neither clicks nor keys from the progress 0 to the progress 1."""
    pngs.write_png(tmp_path / "in.png", picture(33, 21, 3, 8))
    program = Path(ffi_lib.__file__).parent / "gegl_progress.py"
    done = subprocess.run(
        [sys.executable, program, tmp_path / "in.png", "ntp:ambient-occlusion"],
        env=gegl_env,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=900,
        check=True,
    )
    shares = [float(line) for line in done.stdout.split()]
    assert shares[0] == 0 and shares[-1] == 1 and shares == sorted(shares), done.stderr


def test_nothing_to_do(gegl_env, tmp_path):
    """No input, an empty one, an endless one."""
    for graph in (
        ["gegl:nop", "ntp:normals-from-height"],
        ["gegl:crop", "width=0", "height=0", "ntp:normals-from-height"],
        ["gegl:checkerboard", "ntp:normals-from-height", "gegl:crop", "width=9", "height=9"],
        ["gegl:checkerboard", "ntp:clean-normals", "gegl:crop", "width=9", "height=9"],
    ):
        done = subprocess.run(
            ["gegl", "-o", "none.png", "--", *graph],
            env=gegl_env,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=900,
            check=False,
        )
        assert done.returncode >= 0 and "CRITICAL" not in done.stderr, done.stderr


def documented():
    """The commands of the README, under "Without GIMP"."""
    text = (Path(__file__).resolve().parents[2] / "gimp-plugin" / "README.md").read_text()
    block = text.split("## Without GIMP")[1].split("```sh")[1].split("```")[0]
    return [shlex.split(line) for line in block.strip().splitlines()]


def gegl_says(gegl_env, tmp_path, *words):
    """What the program says in all; --info prints a pointer as if it were text."""
    done = subprocess.run(
        words, env=gegl_env, cwd=tmp_path, capture_output=True, timeout=900, check=False
    )
    text = (done.stdout + done.stderr).decode(errors="replace")
    # GLib of Debian 13 says so of a value out of range; the program goes on and says it too.
    lines = [line for line in text.splitlines() if "is invalid or out of range for" not in line]
    assert done.returncode == 0 and "CRITICAL" not in "".join(lines), text
    return text


def test_documented(gegl_env, tmp_path, ntp):
    heights, normals = picture(40, 30, 3, 8), rough_normals(3, 8)
    pngs.write_png(tmp_path / "heights.png", heights)
    pngs.write_png(tmp_path / "rock_n.png", normals)
    made, cleaned, info = documented()
    gegl_says(gegl_env, tmp_path, *made)
    options = to_options(dict(word.split("=") for word in made if "=" in word))
    expected = ntp(heights, "from-height", *options)
    assert (pngs.read_png(tmp_path / "normals.png")[0] == expected * np.uint16(257)).all()
    gegl_says(gegl_env, tmp_path, *cleaned)
    expected = ntp(normals, "clean", "--type", "standard", "--method", "derive")
    assert (pngs.read_png(tmp_path / "rock_clean.png")[0] == expected * np.uint16(257)).all()
    text = gegl_says(gegl_env, tmp_path, *info)
    assert all(name in text for name in ("kernel", "border-x", "How many texels white rises"))


@pytest.mark.parametrize(
    "word, answer",
    [
        ("kernel=sobel", "prewitt3 sobel3 scharr3"),
        ("border=wrap", "'border-x', 'border-y'"),
        ("min-z=1.5", "out of range for property 'min-z'"),
    ],
)
def test_mistakes(gegl_env, tmp_path, word, answer):
    """Said with what there is instead, as the README tells."""
    pngs.write_png(tmp_path / "in.png", picture(9, 9, 3, 8))
    command = ["gegl", "in.png", "-o", "out.png", "--", "ntp:normals-from-height", word]
    assert answer in gegl_says(gegl_env, tmp_path, *command)
