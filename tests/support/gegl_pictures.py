# SPDX-License-Identifier: MIT
"""Pictures for the GEGL operations, and settings as options of `ntp`."""

import struct

import numpy as np

GAMMA = (b"gAMA", struct.pack(">I", 45455))
DEPTHS = [8, 16]
CHANNELS = [1, 2, 3, 4]


def picture(width, height, channels, depth, seed=5):
    """Smooth waves in each channel, noise on top."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:height, :width]
    waves = [np.sin(x / (5 + c) + c) * np.cos(y / (7 - c)) for c in range(channels)]
    unit = np.stack(waves, 2) * 0.45 + 0.5 + rng.normal(0, 0.01, (height, width, channels))
    top = 2**depth - 1
    return (unit.clip(0, 1) * top + 0.5).astype(np.uint8 if depth == 8 else np.uint16)


def to_options(settings):
    """{"to_y": "down"} as options of ntp."""
    return [
        word
        for k, v in settings.items()
        for word in ([f"--{k}", v] if v is not True else [f"--{k}"])
    ]


def rough_normals(channels, depth, seed=9):
    """Normals of every sort: unit, short, long, pointing inwards; black, white and transparent."""
    rng = np.random.default_rng(seed)
    top = 2**depth - 1
    pixels = rng.integers(0, top, (60, 80, channels), endpoint=True)
    pixels[:20, :, 2] = top - pixels[:20, :, 2] // 3
    pixels[5, :30], pixels[6, :30] = 0, top
    return pixels.astype(np.uint8 if depth == 8 else np.uint16)


def to_properties(settings):
    """The same as properties of the operation."""
    return [f"{k}={'true' if v is True else v}" for k, v in settings.items()]
