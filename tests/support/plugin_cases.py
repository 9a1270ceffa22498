# SPDX-License-Identifier: MIT
"""What both GIMPs must make of some pictures, and how the tests of the plug-in know it."""

import struct

import numpy as np

from . import libntp_ffi
from .libntp_ffi import ffi, lib

GAMMA = (b"gAMA", struct.pack(">I", 45455))
WIDTH, HEIGHT = 151, 134  # no multiple of a tile or a band
PART = (20, 30, 77, 55)  # x, y, width, height of a selection


def picture(channels, depth, width=WIDTH, height=HEIGHT, seed=7):
    """Waves of other lengths in each channel, noise on top."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:height, :width]
    waves = [np.sin(x / (6 + c) + c) * np.cos(y / (9 - c)) for c in range(channels)]
    unit = np.stack(waves, 2) * 0.44 + 0.5 + rng.normal(0, 0.012, (height, width, channels))
    top = 2**depth - 1
    return (unit.clip(0, 1) * top + 0.5).astype(np.uint8 if depth == 8 else np.uint16)


def rough_normals(channels, depth, seed=3):
    """Normals of a wavy surface (green up), truncated, every tenth blue wrong."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    p = 1.5 * np.cos(x / 7) * np.sin(y / 11)  # of 10.5 sin(x/7) sin(y/11)
    q = -10.5 / 11 * np.sin(x / 7) * np.cos(y / 11)
    n = np.stack([-p, -q, np.ones_like(p)], 2) / np.sqrt(1 + p * p + q * q)[:, :, None]
    top = 2**depth - 1
    out = np.full((HEIGHT, WIDTH, channels), top, np.uint8 if depth == 8 else np.uint16)
    out[:, :, :3] = (n + 1) / 2 * top
    wrong = np.random.default_rng(seed).random((HEIGHT, WIDTH)) < 0.1
    out[wrong, 2] = out[wrong, 2] * 0.9
    return out


# Name, picture, PNG chunks: gray and color, with and without alpha and gAMA.
INPUTS = {
    f"{'gray' if c < 3 else 'rgb'}{'a' if c % 2 == 0 else ''}{d}{'-gama' if g else ''}": (
        picture(c, d),
        (GAMMA,) if g else (),
    )
    for c in (1, 2, 3, 4)
    for d in (8, 16)
    for g in (False, True)
}

# The plug-in's arguments that are the options of `ntp from-height`, and pictures to try them on:
# "sobel" on all.
SETTINGS = {
    "sobel": {"scale": 7.3, "kernel": "sobel3", "to-y": "down"},
    "gimp9": {"scale": -12.5, "kernel": "gimp9", "border-x": "repeat-slope", "border-y": "wrap"},
    "luma": {"source": "luma", "border-x": "mirror", "border-y": "extrapolate"},
    "screen": {"source": "screen", "border-x": "clamp", "border-y": "repeat-slope"},
    "zzero": {"to": "zzero", "blue": "nearest", "min-z": 0.6},
    "spacing": {"dx": 0.5, "dy": 3, "kernel": "forward"},
    "forms": {"blur": 1.5, "small": 0.5, "middle": 2, "large": 1.25, "border-x": "mirror"},
    "dither": {"dither": "integrable", "strength": 0.25},
    "dxt5nm": {"channels": "1y0x", "to-y": "down"},
    "labpbr": {"preset": "labpbr"},
}
# Those that the program has by other names.
OTHERWISE = {
    "forms": "--blur 1.5 --octaves 0.5,0,1.5,0,-0.75 --border-x mirror",
    "labpbr": "--to-y down --to xy --alpha height",
}


CASES = [(file, "sobel") for file in INPUTS]
CASES += [("rgb8", "gimp9"), ("rgba16", "luma"), ("rgb8", "screen"), ("gray16-gama", "zzero")]
CASES += [("rgba16", "spacing"), ("rgb16", "zzero"), ("rgba8", "forms"), ("gray16", "forms")]
CASES += [("rgb8", "dither"), ("rgba16", "dither"), ("rgb8", "dxt5nm"), ("rgba16", "labpbr")]
# On which a selection is tried.
PARTS = ["gray8", "graya16", "gray16-gama", "rgb8-gama", "rgb16-gama", "rgba16", "rgba16-gama"]


def options(settings):
    """Settings as options of the program."""
    for name, words in OTHERWISE.items():
        if settings == SETTINGS[name]:
            return words.split()
    return [word for name, value in settings.items() for word in (f"--{name}", str(value))]


def different(a, b):
    """How many texels differ."""
    assert a.shape == b.shape and a.dtype == b.dtype, (a.shape, b.shape, a.dtype, b.dtype)
    return int((a != b).any(2).sum())


def normals_of(heights):
    """The library's, by the settings "sobel", in the type of the heights."""
    how = ffi.new("ntp_normals_options *", {"scale": 7.3, "kernel": lib.NTP_KERNEL_SOBEL3})
    made = np.zeros((*heights.shape[:2], 3), heights.dtype)
    src = libntp_ffi.view(heights, encoding=libntp_ffi.HEIGHT, const=True)
    dst = libntp_ffi.view(made, encoding=libntp_ffi.STANDARD, y=libntp_ffi.DOWN)
    libntp_ffi.check(lib.ntp_normals_from_height(dst, src, how, ffi.NULL, ffi.NULL))
    return made


def assert_normals_of(heights, made, float_error=0):
    """The stored numbers are the heights; 8 bit, 16 bit and float are exact."""
    dtype = heights.dtype
    assert made.dtype == dtype and made.shape == (*heights.shape[:2], 3)
    if dtype.kind == "u" and dtype.itemsize <= 2:
        assert different(made, normals_of(heights)) == 0
        return
    # The others go through single precision, and back with GIMP's rounding.
    top = 2**32 - 1 if dtype.kind == "u" else 1
    expected = normals_of((heights.astype(np.float64) / top).astype(np.float32))
    step = {"u4": 2.0**-32, "f2": 2.0**-11, "f4": float_error, "f8": float_error}[dtype.str[1:]]
    assert np.abs(made.astype(np.float64) / top - expected).max() <= step


def part_of(whole, pixels):
    """Pixels with the selection out of `whole`; gray ones as RGB."""
    x, y, w, h = PART
    color = pixels if pixels.shape[2] > 2 else pixels[:, :, [0, 0, 0, 1][: whole.shape[2]]]
    expected = color.copy()
    expected[y : y + h, x : x + w] = whole[y : y + h, x : x + w]
    return expected


# Textures of test_files that cleaning would make worse, unless channels are put right first.
MISPLACED = ["red_blue_swapped", "green_blue_swapped", "dxt5nm", "gamma"]
# Wrong textures of test_files, the remedy for each in Check Normals, and the verb that it is.
REMEDIES = {
    "red_blue_swapped-undo": ["clean", "--undo"],
    "dxt5nm-undo": ["clean", "--undo"],
    "gamma-undo": ["clean", "--undo"],
    "zzero-standard": ["convert", "--to", "standard"],
    "standard_truncated-clean": ["clean"],
    "standard_16_rounded-green": ["convert", "--y", "up", "--to-y", "down"],
    "standard_down-green": ["convert", "--to-y", "up"],
}
