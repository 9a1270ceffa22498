# SPDX-License-Identifier: MIT
"""Drawn normals of many kinds, and what damages them: which way does green point?"""

import numpy as np
from PIL import Image

from . import maps, surfaces


def tiles(rng, h, w):
    """Tiles of their own heights with slanted tops."""
    n = int(rng.integers(3, 9))
    y, x = np.mgrid[:h, :w]
    i = y * n // h * n + x * n // w
    lean = rng.uniform(-1, 1, (2, n * n))
    dy, dx = (y * n / h) % 1 - 0.5, (x * n / w) % 1 - 0.5
    top = rng.uniform(0, 1, n * n)[i] + lean[0][i] * dx + lean[1][i] * dy
    return surfaces.blur(top, rng.uniform(0.8, 2))


def diagonal(rng, h, w):
    y, x = np.mgrid[:h, :w]
    kx, ky = int(rng.integers(2, 12)), int(rng.integers(2, 12)) * int(rng.choice([-1, 1]))
    return np.sin(2 * np.pi * (kx * x / w + ky * y / h))


FAMILIES = [
    surfaces.fractal, surfaces.bricks, surfaces.bumps, surfaces.hemispheres, surfaces.scratches, surfaces.noise,
    tiles, diagonal,
]  # fmt: skip


def slopes(height, stencil):
    """Derivatives to the right and down; every stencil is antisymmetric or one-sided."""
    if stencil == "forward":
        return np.roll(height, -1, 1) - height, np.roll(height, -1, 0) - height
    across = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / 2
    down = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / 2
    if stencil == "sobel":
        across = (np.roll(across, 1, 0) + 2 * across + np.roll(across, -1, 0)) / 4
        down = (np.roll(down, 1, 1) + 2 * down + np.roll(down, -1, 1)) / 4
    return across, down


def normals(height, strength, stencil="central"):
    """Unit normals with green up."""
    p, q = slopes(height, stencil)
    scale = strength / max(np.quantile(np.hypot(p, q), 0.98), 0.05 * np.hypot(p, q).max(), 1e-9)
    n = np.stack([-p * scale, q * scale, np.ones_like(p)], -1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def maps_levels(rng, size=None):
    """(family, levels, 1 up or -1 down)."""
    h, w = size or (int(v) for v in rng.choice([64, 100, 128, 200, 256], 2))
    family = FAMILIES[int(rng.integers(len(FAMILIES)))]
    n = normals(family(rng, h, w), rng.uniform(0.3, 2))
    up = int(rng.choice([-1, 1]))
    return family.__name__, maps.to_type(maps.encode(n * [1, up, 1])), up


def bc1(levels):
    """Blocks of 4 x 4 with four colors along the diagonal of their box, ends stored as 565."""
    h, w = levels.shape[0] // 4 * 4, levels.shape[1] // 4 * 4
    block = levels[:h, :w].reshape(h // 4, 4, w // 4, 4, 3).swapaxes(1, 2).astype(float)
    flat = block.reshape(h // 4, w // 4, 16, 3)
    mean = flat.mean(2, keepdims=True)
    moment = np.einsum("abik,abil->abkl", flat - mean, flat - mean)
    axis = np.linalg.eigh(moment)[1][..., -1][:, :, None]
    along = ((flat - mean) * axis).sum(-1)
    depth = np.array([31, 63, 31]) / 255
    ends = [mean[:, :, 0] + axis[:, :, 0] * f(along, 2)[..., None] for f in (np.min, np.max)]
    low, high = (np.round(np.clip(e, 0, 255) * depth) / depth for e in ends)
    t = np.linspace(0, 1, 4)[:, None]
    colors = low[:, :, None] * (1 - t) + high[:, :, None] * t
    nearest = ((flat[:, :, :, None] - colors[:, :, None]) ** 2).sum(-1).argmin(-1)
    out = np.take_along_axis(colors, nearest[..., None], 2)
    out = out.reshape(h // 4, w // 4, 4, 4, 3).swapaxes(1, 2).reshape(h, w, 3)
    return np.round(out).astype(np.uint8)


def noisy(rng, levels, amount):
    return np.clip(np.round(levels + rng.normal(0, amount, levels.shape)), 0, 255).astype(np.uint8)


def green_doubled(levels):
    out = levels.astype(float)
    out[..., 1] = (out[..., 1] - 127.5) * 2 + 127.5
    return np.clip(np.round(out), 0, 255).astype(np.uint8)


def resized(levels, factor):
    h, w = levels.shape[:2]
    size = int(w * factor), int(h * factor)
    return np.asarray(Image.fromarray(levels).resize(size, Image.BICUBIC))


CORRUPTIONS = {
    "clean": lambda rng, a: a,
    "JPEG 90": lambda rng, a: maps.jpeg(a, 90, 2),
    "JPEG 50": lambda rng, a: maps.jpeg(a, 50, 2),
    "half": lambda rng, a: resized(a, 0.5),
    "double": lambda rng, a: resized(a, 2),
    "noise 4": lambda rng, a: noisy(rng, a, 4),
    "noise 12": lambda rng, a: noisy(rng, a, 12),
    "BC1": lambda rng, a: bc1(a),
    "green doubled": lambda rng, a: green_doubled(a),
}
