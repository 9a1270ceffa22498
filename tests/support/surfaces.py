# SPDX-License-Identifier: MIT
"""Heights of surfaces of several kinds, drawn from a seed, and their normals.

Nothing here is taken from libntp.
"""

import numpy as np


def fft_noise(rng, h, w, slope):
    """Noise that tiles, its amplitude falling as frequency ** -slope; mean 0, deviation 1."""
    fy, fx = np.fft.fftfreq(h)[:, None], np.fft.rfftfreq(w)[None, :]
    f = np.hypot(fy, fx)
    f[0, 0] = 1
    spectrum = np.fft.rfft2(rng.standard_normal((h, w))) * f**-slope
    spectrum[0, 0] = 0
    out = np.fft.irfft2(spectrum, s=(h, w))
    return out / max(out.std(), 1e-12)


def blur(a, radius):
    """A Gaussian that wraps."""
    h, w = a.shape
    fy, fx = np.fft.fftfreq(h)[:, None], np.fft.rfftfreq(w)[None, :]
    g = np.exp(-2 * (np.pi * radius) ** 2 * (fy**2 + fx**2))
    return np.fft.irfft2(np.fft.rfft2(a) * g, s=(h, w))


def fractal(rng, h, w):
    return fft_noise(rng, h, w, rng.uniform(1.2, 2.5))


def bricks(rng, h, w):
    bh, bw = max(h // int(rng.integers(2, 7)), 4), max(w // int(rng.integers(2, 5)), 4)
    y, x = np.mgrid[:h, :w]
    row = y // bh
    x = x + (row % 2) * (bw // 2)
    joint = max(1, bh // 8)
    flat = ((y % bh) >= joint) & ((x % bw) >= joint)
    tops = rng.uniform(0.7, 1, (h // bh + 2, w // bw + 3))
    out = flat * tops[row, x // bw]
    out = blur(out, rng.uniform(0.7, 2))
    if rng.random() < 0.5:
        out += 0.03 * fractal(rng, h, w) * out
    return out


def bumps(rng, h, w):
    out = np.zeros((h, w))
    y, x = np.mgrid[:h, :w]
    for _ in range(int(rng.integers(5, 40))):
        cy, cx = rng.uniform(0, h), rng.uniform(0, w)
        r = rng.uniform(0.02, 0.12) * min(h, w) + 1
        dy = (y - cy + h / 2) % h - h / 2
        dx = (x - cx + w / 2) % w - w / 2
        out += rng.choice([-1, 1]) * r * np.exp(-(dx * dx + dy * dy) / (2 * r * r))
    return out


def ridges(rng, h, w):
    y, x = np.mgrid[:h, :w]
    kx, ky = 0, 0
    while kx == 0 and ky == 0:
        kx, ky = int(rng.integers(0, 9)), int(rng.integers(-8, 9))
    wave = np.sin(2 * np.pi * (kx * x / w + ky * y / h))
    return np.abs(wave) if rng.random() < 0.3 else wave


def hemispheres(rng, h, w):
    out = np.zeros((h, w))
    n = int(rng.integers(1, 6))
    y, x = np.mgrid[:h, :w]
    cell_h, cell_w = h / n, w / n
    r = min(cell_h, cell_w) * 0.45
    dy = (y + 0.5) % cell_h - cell_h / 2
    dx = (x + 0.5) % cell_w - cell_w / 2
    inside = r * r - dx * dx - dy * dy
    out = np.sqrt(np.maximum(inside, 0)) * rng.uniform(0.2, 1)
    return blur(out, 0.5)


def scratches(rng, h, w):
    out = np.zeros((h, w))
    for _ in range(int(rng.integers(10, 80))):
        cy, cx, a = rng.uniform(0, h), rng.uniform(0, w), rng.uniform(0, np.pi)
        t = np.arange(int(rng.uniform(0.2, 1) * w))
        yy = (cy + t * np.sin(a)).astype(int) % h
        xx = (cx + t * np.cos(a)).astype(int) % w
        out[yy, xx] -= rng.uniform(0.3, 1)
    return blur(out, rng.uniform(0.5, 1.2))


def noise(rng, h, w):
    return blur(rng.standard_normal((h, w)), rng.uniform(0.5, 1.5))


FAMILIES = [fractal, bricks, bumps, ridges, hemispheres, scratches, noise]


def draw_size(rng, least=16):
    while True:
        h, w = (
            int(rng.choice([16, 24, 32, 48, 64, 100, 128, 200, 256, 512], p=_SIZES)) for _ in "hw"
        )
        if h * w <= 200_000 and h >= least and w >= least:
            return h, w


_SIZES = np.array([1, 1, 3, 3, 6, 5, 6, 4, 4, 1]) / 34


def draw_height(rng, h, w):
    family = FAMILIES[int(rng.integers(len(FAMILIES)))]
    return family(rng, h, w), family.__name__


def normals_of(height, strength):
    """Unit normals whose slopes have their 98th percentile at `strength`."""
    p = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / 2
    q = -(np.roll(height, -1, 0) - np.roll(height, 1, 0)) / 2
    steepest = np.quantile(np.hypot(p, q), 0.98)
    if steepest < 1e-9:
        steepest = np.hypot(p, q).max() + 1e-9
    n = np.stack([-p, -q, np.full_like(p, steepest / strength)], -1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def draw_normals(rng, least=0.02, most=3.0, smallest=16, flip=True):
    """Unit normals of a random heightfield, and what was drawn."""
    strength = float(np.exp(rng.uniform(np.log(least), np.log(most))))
    while True:
        h, w = draw_size(rng, smallest)
        height, family = draw_height(rng, h, w)
        n = normals_of(height, strength)
        if (n[..., 2] < n[..., 2].max() - 1e-6).mean() > 0.02:
            break
    if flip and rng.random() < 0.5:
        n[..., 1] *= -1
    return n, height, {"family": family, "strength": round(strength, 3), "size": (w, h)}
