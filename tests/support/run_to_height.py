# SPDX-License-Identifier: MIT
"""`ntp to-height`: what it is asked, and what it says and writes."""

import json

import numpy as np

from . import schemas
from .pngs import read_png


def to_height(run, *args, code=0):
    """The objects of the files."""
    done = run("to-height", *args, "--format", "json")
    assert done.returncode == code, done.stderr
    report = json.loads(done.stdout)
    schemas.validate(report, "to-height-1")
    return report["files"]


def only(run, *args, code=0):
    (file,) = to_height(run, *args, code=code)
    return file


def texts(path):
    """{key: value} of the tEXt chunks; a key that comes twice fails."""
    _, chunks = read_png(path)
    pairs = [body.split(b"\0", 1) for body in chunks.get(b"tEXt", [])]
    out = {key.decode(): value.decode() for key, value in pairs}
    assert len(out) == len(pairs)
    return out


def write_pfm(path, pixels):
    h, w = pixels.shape[:2]
    kind = b"PF" if pixels.ndim == 3 else b"Pf"
    with open(path, "wb") as file:
        file.write(b"%s\n%d %d\n-1.0\n" % (kind, w, h))
        file.write(pixels[::-1].astype("<f4").tobytes())


def read_pfm(path):
    data = path.read_bytes()
    kind, size, _, rest = data.split(b"\n", 3)
    assert kind == b"Pf"
    w, h = map(int, size.split())
    return np.frombuffer(rest, "<f4").reshape(h, w)[::-1]


def make_normals(run, *args):
    done = run("from-height", "h.png", "-o", "n.png", "--scale", 40, *args)
    assert done.returncode == 0, done.stderr


def settings_of(file):
    return [
        *("--scale", file["scale"], "--kernel", file["kernel"], "--to-y", file["y"]),
        *("--border-x", file["border_x"], "--border-y", file["border_y"]),
    ]
