# SPDX-License-Identifier: MIT
"""Pictures that are no normals, as those of maps.py: noise, wood, gradients, skies, leaves."""

import numpy as np

from .surfaces import fft_noise


def color_noise(rng, h, w):
    """A surface of one material: a color, brightness that varies, colors that vary less."""
    mean = rng.uniform(0.15, 0.8, 3)
    light = 1 + rng.uniform(0.1, 0.4) * fft_noise(rng, h, w, rng.uniform(0.6, 1.6))
    tint = np.stack([fft_noise(rng, h, w, 1.2) for _ in range(3)], -1) * rng.uniform(0, 0.06)
    return mean * light[..., None] + tint


def wood(rng, h, w):
    x = np.arange(w)
    rings = np.sin(x / w * rng.uniform(20, 90) + 2 * fft_noise(rng, h, w, 2))
    t = np.clip(0.5 + 0.3 * rings + 0.1 * fft_noise(rng, h, w, 0.5), 0, 1)[..., None]
    dark = np.array([0.3, 0.17, 0.08]) * rng.uniform(0.6, 1.4)
    return dark * (1 - t) + np.array([0.72, 0.5, 0.3]) * rng.uniform(0.8, 1.2) * t


def gradient(rng, h, w):
    y, x = np.mgrid[:h, :w]
    a = rng.uniform(0, 2 * np.pi)
    t = x / w * np.cos(a) + y / h * np.sin(a)
    t = ((t - t.min()) / np.ptp(t))[..., None]
    return rng.uniform(0, 1, 3) * t + rng.uniform(0, 1, 3) * (1 - t)


def palette_art(rng, h, w):
    colors = rng.uniform(0, 1, (int(rng.integers(4, 17)), 3))
    cell = int(rng.integers(2, 9))
    index = rng.integers(0, len(colors), (h // cell + 1, w // cell + 1))
    return colors[np.kron(index, np.ones((cell, cell), int))[:h, :w]]


def sky(rng, h, w):
    t = (np.arange(h) / h)[:, None, None]
    top, low = np.array([0.2, 0.42, 0.75]), np.array([0.7, 0.83, 0.95])
    clouds = np.clip(fft_noise(rng, h, w, 1.7) - rng.uniform(0, 1), 0, 1)[..., None]
    base = (top + rng.uniform(-0.1, 0.1, 3)) * (1 - t) + low * t
    return base * (1 - clouds) + np.array([0.95, 0.95, 0.97]) * clouds


def leaves(rng, h, w):
    out = np.broadcast_to(np.array([0.1, 0.12, 0.05]), (h, w, 3)).copy()
    y, x = np.mgrid[:h, :w]
    for _ in range(60):
        cy, cx, r = rng.uniform(0, h), rng.uniform(0, w), rng.uniform(0.03, 0.12) * max(h, w)
        inside = (y - cy) ** 2 + 2 * (x - cx) ** 2 < r * r
        out[inside] = np.array([0.25, 0.5, 0.12]) * rng.uniform(0.4, 1.8) * rng.uniform(0.7, 1.3, 3)
    return out * (1 + 0.1 * fft_noise(rng, h, w, 1)[..., None])


PICTURES = [color_noise, wood, gradient, palette_art, sky, leaves]
