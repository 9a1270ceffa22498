# SPDX-License-Identifier: MIT
"""A second generator of textures of known type, which shares nothing with maps.py.

The classification's rules were fitted on the draws of maps.py, so a test on those alone shows how
well they fit.  This module was written from the definitions only, without knowledge of the rules:
most surfaces are normals from formulas rather than heights, and the features that distinguish types
are left to chance.  A drawing is a function of its names and its number; nothing else is random.
"""

import functools
import io
from dataclasses import dataclass

import numpy as np
from PIL import Image

from .drawn_surfaces import SURFACES, octaves, softened

STANDARD, ZZERO, XY, HEIGHT, OBJECT, ONE_COLOR, NOT_NORMALS = range(7)
CLASSES = ["standard", "zzero", "xy", "height", "object-space", "one-color", "not-normals"]


@dataclass
class Drawing:
    name: str
    pixels: np.ndarray  # (h, w, channels) of uint8 or uint16
    kind: int
    encoding: int = 0  # how the view is declared: 0 standard, 2 XY, 4 height


# ------------------------------------------------------------------------------- encoding


def to_levels(n, m=255, how="rounded"):
    """As different programs write them; (h, w, 3) of floats that are whole."""
    out = {
        "rounded": lambda: np.floor((n * 0.5 + 0.5) * m + 0.5),
        "truncated": lambda: np.floor((n * 0.5 + 0.5) * m),
        "centered": lambda: np.floor(n * (m // 2) + 0.5) + m // 2 + 1,  # flat at 128
    }[how]()
    return np.clip(out, 0, m)


def stored(levels, m=255):
    return levels.astype(np.uint8 if m == 255 else np.uint16)


def with_positive_z(n):
    """The same as Z-zero: blue is z, not (z + 1) / 2."""
    out = to_levels(n)
    out[..., 2] = np.floor(n[..., 2] * 255 + 0.5)
    return stored(out)


# -------------------------------------------------------------------------------- damages


def by_jpeg(pixels, quality, subsampling):
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=quality, subsampling=subsampling)
    return np.array(Image.open(file))


def by_pillow(pixels, factor, how):
    h, w = pixels.shape[:2]
    size = max(round(w * factor), 8), max(round(h * factor), 8)
    return np.array(Image.fromarray(pixels).resize(size, how))


def by_blocks(pixels):
    """Like BC1: four colors on a line for each four by four texels, its ends of 5, 6 and 5 bit."""
    h, w = (n // 4 * 4 for n in pixels.shape[:2])
    blocks = pixels[:h, :w].reshape(h // 4, 4, w // 4, 4, 3).swapaxes(1, 2).reshape(-1, 16, 3)
    blocks = blocks.astype(float)
    middle = blocks.mean(1, keepdims=True)
    spread = blocks - middle
    cover = np.einsum("nki,nkj->nij", spread, spread)
    axis = np.linalg.eigh(cover)[1][..., -1][:, None, :]
    along = (spread * axis).sum(-1)
    steps = np.array([31, 63, 31])
    ends = [middle[:, 0] + edge(along, axis=1)[:, None] * axis[:, 0] for edge in (np.min, np.max)]
    ends = [np.round(np.clip(e, 0, 255) / 255 * steps) / steps * 255 for e in ends]
    colors = np.stack([(ends[0] * (3 - k) + ends[1] * k) / 3 for k in range(4)], 1).round()
    chosen = ((blocks[:, :, None] - colors[:, None]) ** 2).sum(-1).argmin(-1)
    out = np.take_along_axis(colors, chosen[..., None], 1)
    out = out.reshape(h // 4, w // 4, 4, 4, 3).swapaxes(1, 2).reshape(h, w, 3)
    return out.astype(np.uint8)


def by_sixteen_levels(pixels):
    return (np.round(pixels / 17) * 17).astype(np.uint8)


def by_palette(pixels):
    return np.array(Image.fromarray(pixels).quantize(256).convert("RGB"))


def brightened(pixels):
    """Stored as if the levels had been linear light: the curve of sRGB."""
    v = pixels / 255
    curve = np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)
    return np.floor(curve * 255 + 0.5).astype(np.uint8)


DAMAGES = {
    "": lambda p: p,
    "jpeg95": lambda p: by_jpeg(p, 95, 0),
    "jpeg85": lambda p: by_jpeg(p, 85, 2),
    "jpeg60": lambda p: by_jpeg(p, 60, 2),
    "half": lambda p: by_pillow(p, 0.5, Image.Resampling.BOX),
    "smaller": lambda p: by_pillow(p, 0.7, Image.Resampling.LANCZOS),
    "larger": lambda p: by_pillow(p, 1.6, Image.Resampling.BICUBIC),
    "blocks": by_blocks,
    "4 bit": by_sixteen_levels,
    "palette": by_palette,
}


# ------------------------------------------------------------------- textures of each kind


def surface(rng, name, least=0.0):
    """Normals by one of SURFACES, leaning by `least` on average or more."""
    make = {s.__name__: s for s in SURFACES}[name]
    while True:
        h, w = (int(v) for v in rng.choice([64, 96, 128, 160, 200], 2))
        n = make(rng, h, w)
        if np.hypot(n[..., 0], n[..., 1]).mean() >= least:
            return n * [1, rng.choice([-1, 1]), 1]


def shade_of(rng, n):
    """Occlusion, 0..1: dark where normals lean towards each other, bright where they part."""
    parting = np.gradient(n[..., 0], axis=1) - np.gradient(n[..., 1], axis=0)
    hollow = softened(-parting, int(rng.integers(2, 9)))
    hollow = np.maximum(hollow, 0) / max(np.quantile(np.abs(hollow), 0.99), 1e-9)
    dirt = rng.uniform(0, 0.3) * octaves(rng, *n.shape[:2])
    return np.clip(rng.uniform(0.85, 1) - rng.uniform(0.3, 0.9) * hollow - dirt, 0, 1)


def standard(rng, name):
    how = str(rng.choice(["rounded", "truncated", "centered"], p=[0.6, 0.2, 0.2]))
    return stored(to_levels(surface(rng, name, 0.03), how=how))


def zzero(rng, name):
    return with_positive_z(surface(rng, name, 0.15))


def xy_and_shade(rng, name):
    n = surface(rng, name, 0.15)
    levels = to_levels(n)
    levels[..., 2] = np.floor(shade_of(rng, n) * 255 + 0.5)
    return stored(levels)


def xy_and(blue):
    def make(rng, name):
        levels = to_levels(surface(rng, name, 0.2))
        levels[..., 2] = blue
        return stored(levels)

    return make


def padded(rng, name):
    """Islands of normals in a sheet of black, white or nothing."""
    pixels = standard(rng, name)
    h, w = pixels.shape[:2]
    island = np.zeros((h, w), bool)
    for _ in range(4):
        y0, x0 = int(rng.uniform(0, h * 0.6)), int(rng.uniform(0, w * 0.6))
        island[y0 : y0 + h // 3, x0 : x0 + w // 3] = True
    if rng.random() < 0.4:
        return np.dstack([pixels, np.where(island, 255, 0).astype(np.uint8)])
    pixels[~island] = 0 if rng.random() < 0.7 else 255
    return pixels


def sixteen_bits(rng, name):
    return stored(to_levels(surface(rng, name, 0.03), 65535), 65535)


def heights_as_gray(rng, name):
    """A bump map in three equal channels: what the surface's tilt adds up to, and noise."""
    n = surface(rng, name)
    gray = 0.7 * octaves(rng, *n.shape[:2]) + 0.3 * shade_of(rng, n)
    gray = np.floor(np.clip(gray, 0, 1) * rng.uniform(100, 255) + 0.5)
    return np.repeat(gray[..., None], 3, 2).astype(np.uint8)


def on_a_ball(rng, h, w):
    """Directions of a whole sphere, unrolled; or of a torus; detail of a surface is laid on."""
    a, b = np.meshgrid(np.linspace(0, 2 * np.pi, w), np.linspace(0.02, 0.98, h) * np.pi)
    if rng.random() < 0.5:
        b = b * 2
        return np.stack([np.cos(a) * np.cos(b), np.sin(b), np.sin(a) * np.cos(b)], -1)
    return np.stack([np.cos(a) * np.sin(b), np.cos(b), np.sin(a) * np.sin(b)], -1)


def object_space(rng, name):
    detail = surface(rng, name)
    base = on_a_ball(rng, *detail.shape[:2])
    side = np.roll(base, 1, -1)
    across = np.cross(base, side)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    side = np.cross(across, base)
    soft = detail * [0.5, 0.5, 1]
    out = soft[..., :1] * across + soft[..., 1:2] * side + soft[..., 2:] * base
    return stored(to_levels(out / np.linalg.norm(out, axis=-1, keepdims=True)))


def boxed(rng, name):
    """Six charts of a box, each with the directions of its side, in one sheet."""
    detail = surface(rng, name)
    h, w = (n // 2 * 2 for n in detail.shape[:2])
    w = w // 3 * 3
    detail = detail[:h, :w]
    out = np.empty_like(detail)
    turns = [(0, 1, 2), (1, 2, 0), (2, 0, 1)]
    for i in range(6):
        rows = slice(i // 3 * h // 2, (i // 3 + 1) * h // 2)
        columns = slice(i % 3 * w // 3, (i % 3 + 1) * w // 3)
        out[rows, columns] = detail[rows, columns][..., turns[i % 3]] * (1 if i < 3 else -1)
    return stored(to_levels(out))


MAPS = {
    "standard": (standard, STANDARD),
    "zzero": (zzero, ZZERO),
    "XY and shade": (xy_and_shade, XY),
    "XY and 0": (xy_and(0), XY),
    "XY and 128": (xy_and(128), XY),
    "XY and 255": (xy_and(255), XY),
    "padded": (padded, STANDARD),
    "16 bit": (sixteen_bits, STANDARD),
    "heights": (heights_as_gray, HEIGHT),
    "object space": (object_space, OBJECT),
    "box": (boxed, OBJECT),
}


# -------------------------------------------------------------------------------- drawing


@functools.lru_cache(maxsize=400)  # to be damaged in many ways
def undamaged(name, surface_name, number):
    seed = [ord(c) for c in name + surface_name] + [number]
    return MAPS[name][0](np.random.default_rng(seed), surface_name)


def draw(name, surface_name, damage, number):
    """One Drawing."""
    pixels = DAMAGES[damage](undamaged(name, surface_name, number).copy())
    title = f"{name}, {surface_name}, {damage or 'undamaged'}, {number}"
    return Drawing(title, pixels, MAPS[name][1])


def draw_picture(paint, damage, number):
    rng = np.random.default_rng([ord(c) for c in paint.__name__] + [number])
    h, w = (int(v) for v in rng.choice([64, 96, 128, 160, 200], 2))
    pixels = np.clip(np.round(paint(rng, h, w)), 0, 255).astype(np.uint8)
    title = f"{paint.__name__}, {damage or 'undamaged'}, {number}"
    return Drawing(title, DAMAGES[damage](pixels), NOT_NORMALS)


def draw_other(name, surface_name, number):
    """Channels in other places, other curves, and what is declared in another way."""
    rng = np.random.default_rng([ord(c) for c in name + surface_name] + [number])
    n = surface(rng, surface_name, 0.08)
    plain = stored(to_levels(n))
    full = np.full_like(plain[..., 0], 255)
    pixels, kind, encoding = {
        "brightened": lambda: (brightened(plain), STANDARD, 0),
        "red and blue swapped": lambda: (plain[..., ::-1], STANDARD, 0),
        "green and blue swapped": lambda: (plain[..., [0, 2, 1]], STANDARD, 0),
        "blue inverted": lambda: (stored(to_levels(n * [1, 1, -1])), STANDARD, 0),
        "x in alpha": lambda: (np.dstack([full, plain[..., 1], full, plain[..., 0]]), XY, 0),
        "x in alpha, gray": lambda: (plain[..., [1, 1, 1, 0]], XY, 0),
        "two channels": lambda: (plain[..., :2], XY, 2),
        "one channel": lambda: (plain[..., :1], HEIGHT, 4),
        "flat": lambda: (np.full_like(plain, (128, 128, 255)), ONE_COLOR, 0),
        "one color": lambda: (np.full_like(plain, rng.integers(1, 255, 3)), ONE_COLOR, 0),
    }[name]()
    pixels = np.ascontiguousarray(pixels)
    return Drawing(f"{name}, {surface_name}, {number}", pixels, kind, encoding)


OTHERS = ["brightened", "red and blue swapped", "green and blue swapped", "blue inverted",
          "x in alpha", "x in alpha, gray", "two channels", "one channel", "flat", "one color"]  # fmt: skip
