# SPDX-License-Identifier: MIT
"""What `ntp` says and writes, and a texture for it that is wrong everywhere."""

import json

import numpy as np

from . import textures
from .pngs import read_png


def pixels_of(path):
    return read_png(path)[0]


def items(done):
    out = json.loads(done.stdout)
    assert out["schema_version"] == 1 and out["tool"]["name"] == "ntp"
    return out["files"]


def noisy(depth=8, seed=7, h=48, w=56):
    m = 255 if depth == 8 else 65535
    rng = np.random.default_rng(seed)
    step = m // 255
    out = textures.standard(h, w, seed, 1.5, depth).astype(np.int64)
    out += rng.integers(-4 * step, 4 * step + 1, out.shape)
    return np.clip(out, 0, m).astype(np.uint8 if depth == 8 else np.uint16)
