# SPDX-License-Identifier: MIT
"""Surfaces, what damages their normals, and the error of heights: what the benches of heights share."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from support import maps


def fractal(n, seed, exponent):
    rng = np.random.default_rng(seed)
    f = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None])
    f[0, 0] = np.inf
    h = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((n, n))) / f**exponent, s=(n, n))
    return (h - h.min()) / np.ptp(h)


def smooth(n, seed):
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:n, :n] * (2 * np.pi / n)
    h = np.zeros((n, n))
    for a, b in rng.integers(-8, 9, (12, 2)):
        h += rng.normal() * np.cos(a * x + b * y + rng.uniform(0, 7)) / (1 + np.hypot(a, b))
    return (h - h.min()) / np.ptp(h)


def bricks(n, seed):
    y, x = np.mgrid[:n, :n]
    across, down = n // 8, n // 16
    x = (x + across // 2 * (y // down % 2)) % across
    edge = np.minimum(np.minimum(x, across - x), np.minimum(y % down, down - y % down))
    return np.clip(edge / 3 + 0.1 * fractal(n, seed, 1.6), 0, 1)


SURFACES = {
    "rough": lambda n, seed: fractal(n, seed, 1.6) * n / 17,
    "terrain": lambda n, seed: fractal(n, seed, 2.2) * n / 4,
    "steep": lambda n, seed: fractal(n, seed, 2) * n / 1.5,
    "smooth": lambda n, seed: smooth(n, seed) * n / 17,
    "bricks": lambda n, seed: bricks(n, seed) * n / 70,
}


def noise(n):
    added = np.random.default_rng(1).normal(0, 4, n.shape)
    return np.clip(n + added, 0, 255).round().astype(np.uint8)


def palettes(ends):
    """The four colors of blocks, of ends that are rounded to 5, 6, 5 bits."""
    most = np.array([31, 63, 31])
    low, high = (np.floor(np.clip(end, 0, 255) / 255 * most + 0.5) / most * 255 for end in ends)
    return np.concatenate([low, high, (2 * low + high) / 3, (low + 2 * high) / 3], 1)


def bc1(n):
    """Block compression: of each 4 x 4 texels two colors, and two between them.

    The first two are the texels at the ends of the longest axis.  As encoders do, they are then the
    least squares for what the texels chose, twice, where that is closer."""
    height, width = n.shape[:2]
    n = np.pad(n, ((0, -height % 4), (0, -width % 4), (0, 0)), "edge")
    h, w = n.shape[:2]
    blocks = n.reshape(h // 4, 4, w // 4, 4, 3).transpose(0, 2, 1, 3, 4).reshape(-1, 16, 3)
    away = blocks - blocks.mean(1, keepdims=True)
    axis = np.linalg.eigh(away.transpose(0, 2, 1) @ away)[1][..., -1:]
    along = (away @ axis)[..., 0]
    ends = [
        np.take_along_axis(blocks, f(along, 1)[:, None, None], 1) for f in (np.argmin, np.argmax)
    ]
    least = np.full((len(blocks), 1, 1), np.inf)
    best = np.zeros(blocks.shape)
    for _ in range(3):
        palette = palettes(ends)
        off = ((blocks[:, :, None] - palette[:, None]) ** 2).sum(-1)
        index = off.argmin(-1)
        total = np.take_along_axis(off, index[..., None], 2).sum(1, keepdims=True)
        best = np.where(total < least, np.take_along_axis(palette, index[..., None], 1), best)
        least = np.minimum(total, least)
        share = np.array([0, 1, 1 / 3, 2 / 3])[index]
        both = np.stack([1 - share, share], -1)
        ends = np.split(np.linalg.pinv(both) @ blocks, 2, 1)
    texels = best.reshape(h // 4, w // 4, 4, 4, 3).transpose(0, 2, 1, 3, 4).reshape(n.shape)
    return np.floor(texels + 0.5).astype(np.uint8)[:height, :width]


def half(n):
    """Means of 2 x 2 texels, made 1 long."""
    h, w = n.shape[0] // 2, n.shape[1] // 2
    v = (2.0 * n - 255)[: 2 * h, : 2 * w].reshape(h, 2, w, 2, 3).mean((1, 3))
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    return np.floor((v + 1) * 127.5 + 0.5).astype(np.uint8)


DAMAGES = {
    "none": lambda n: n,
    "JPEG 95": lambda n: maps.jpeg(n, 95, 0),
    "JPEG 85": lambda n: maps.jpeg(n, 85, 0),
    "BC1": bc1,
    "noise 4": noise,
}


def error(made, h):
    a, b = made - made.mean(dtype=float), h - h.mean()
    gain = (a * b).sum() / max((a * a).sum(), 1e-30)
    return 100 * np.sqrt(np.mean((gain * a - b) ** 2)) / np.ptp(h)
