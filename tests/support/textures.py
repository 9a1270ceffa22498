# SPDX-License-Identifier: MIT
"""Textures that the tests of the program write: made from waves, in integers where it matters."""

import numpy as np

from . import oracle


def slopes(h=64, w=64, seed=1, steepness=0.7):
    """Slopes p, q of a sum of random waves that tiles."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:h, 0:w]
    p = np.zeros((h, w))
    q = np.zeros((h, w))
    for _ in range(12):
        kx, ky = rng.integers(-5, 6, 2)
        phase, height = rng.uniform(0, 2 * np.pi), rng.uniform(0.2, 1)
        wave = np.cos(2 * np.pi * (kx * x / w + ky * y / h) + phase) * height
        p += wave * kx
        q += wave * ky
    scale = steepness / max(np.sqrt(p * p + q * q).mean(), 1e-9)
    return p * scale, q * scale


def standard(h=64, w=64, seed=1, steepness=0.7, depth=8):
    """A clean standard texture: red and green rounded, blue derived by the oracle."""
    p, q = slopes(h, w, seed, steepness)
    m = 255 if depth == 8 else 65535
    length = np.sqrt(p * p + q * q + 1)
    r = np.floor((1 - p / length) / 2 * m + 0.5).astype(np.int64)
    g = np.floor((1 - q / length) / 2 * m + 0.5).astype(np.int64)
    b = oracle.derived_blues(r, g, m)
    return np.dstack([r, g, b]).astype(np.uint8 if depth == 8 else np.uint16)


def wrong_blue(texture, share, seed=2):
    """The same with blue lowered by 60 levels in a share of the texels."""
    out = texture.copy()
    rng = np.random.default_rng(seed)
    flat = out.reshape(-1, out.shape[-1])
    count = round(share * len(flat))
    where = rng.choice(len(flat), count, replace=False)
    flat[where, 2] = flat[where, 2].astype(int) - 60
    return out


def zzero(h=64, w=64, seed=3, depth=8):
    """A clean Z-zero texture, steep enough to be told from a standard one."""
    m = 255 if depth == 8 else 65535
    out = standard(h, w, seed, 0.9, depth)
    rg = out.astype(np.int64)
    out[..., 2] = oracle.derived_blues(rg[..., 0], rg[..., 1], m, True)
    return out


def heights(h=64, w=64):
    """A gray bump map."""
    y, x = np.mgrid[0:h, 0:w]
    return (127.5 + 100 * np.sin(x / 5.0) * np.cos(y / 7.0)).astype(np.uint8)


def photograph(h=64, w=64, seed=4):
    """Colors like those of a photograph: smooth, correlated, mostly dark and warm."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:h, 0:w]
    light = 0.5 + 0.4 * np.sin(x / 9.0 + 1) * np.cos(y / 11.0)
    color = np.array([190, 140, 90])
    noise = rng.normal(0, 8, (h, w, 1))
    return np.clip(light[..., None] * color + noise, 3, 250).astype(np.uint8)
