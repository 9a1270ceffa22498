# SPDX-License-Identifier: MIT
"""All operations in GEGL beside their verbs of `ntp`: not one texel differs.

Each row of support/operations.py, in 8 and 16 bit, with and without alpha and gAMA, as GIMP 2.10 has
them: one process makes all.  gimp3_operations.py does the same in GIMP 3.
"""

import itertools
import json
import subprocess
import sys
from pathlib import Path

import pytest

from support import operations, pngs
from support.operations import CURVES, KINDS, name_of
from support.plugin_cases import different

RUNNER = Path(operations.__file__).with_name("in_gegl.py")
X, Y, WIDE, HIGH = 3, 3, 40, 37
PART = f" gegl:crop x={X} y={Y} width={WIDE} height={HIGH}"


def chain(operation, settings, detail):
    words = [f"{k}={str(v).lower() if isinstance(v, bool) else v}" for k, v in settings.items()]
    if operation == operations.BLEND:
        words.append(f"aux=[ gegl:png-load path={detail} ]")
    if operation == operations.BLEND_FILE:
        words.append(f"file={detail}")  # GIMP 3's scripts set `path`
    return " ".join([operation, *words])


@pytest.fixture(scope="module")
def made(gegl_env, tmp_path_factory):
    """The directory with what GEGL made."""
    folder, jobs = tmp_path_factory.mktemp("table"), []
    for name, pixels, chunks in operations.pictures():
        pngs.write_png(folder / f"{name}.png", pixels, chunks=chunks)
        detail = folder / f"{name}-detail.png"
        pngs.write_png(detail, operations.detail_of(pixels), chunks=chunks)
        bits = pixels.itemsize * 8
        for row, seen, operation, settings, _ in operations.ROWS:
            if name.startswith(seen.__name__):
                out = folder / f"{name}-{row}.png"
                words = chain(operation, settings, detail)
                jobs.append([str(folder / f"{name}.png"), words, str(out), bits])
                part = out.with_suffix(".part.png")
                jobs.append([str(folder / f"{name}.png"), words + PART, str(part), bits])
    (folder / "jobs.json").write_text(json.dumps(jobs))
    command = [sys.executable, RUNNER, folder / "jobs.json"]
    environment = dict(gegl_env, GEGL_THREADS="1", BABL_INHIBIT_CACHE="1")
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=900, check=False
    )
    assert done.returncode == 0, done.stderr
    assert not any(s in done.stderr for s in ("CRITICAL", "WARNING")), done.stderr
    return folder


@pytest.mark.parametrize(
    ("picture", "make", "row"),
    [(row[1], row[4], row[0]) for row in operations.ROWS],
    ids=operations.NAMES,
)
def test_same_as_ntp(made, program, tmp_path, picture, make, row):
    ntp, wrong = operations.caller(program, tmp_path), {}
    for channels, depth in KINDS:
        pixels = picture(channels, depth)
        expected = make(ntp, pixels, operations.detail_of(pixels))[..., :channels]
        for curve in CURVES:
            name = f"{name_of(picture, channels, depth, curve)}-{row}.png"
            result = pngs.read_png(made / name)[0]
            wrong[name] = different(result[..., :channels], expected)
    assert len(wrong) == len(KINDS) * len(CURVES)
    assert not any(wrong.values()), wrong


@pytest.mark.parametrize(
    ("picture", "row"), [(row[1], row[0]) for row in operations.ROWS], ids=operations.NAMES
)
def test_parts(made, picture, row):
    """A part that is asked for alone is that of the whole: GEGL cuts layers as it likes."""
    wrong = {}
    for (channels, depth), curve in itertools.product(KINDS, CURVES):
        name = f"{name_of(picture, channels, depth, curve)}-{row}"
        whole, part = (pngs.read_png(made / f"{name}{end}.png")[0] for end in ("", ".part"))
        wrong[name] = different(part, whole[Y : Y + HIGH, X : X + WIDE])
    assert not any(wrong.values()), wrong
