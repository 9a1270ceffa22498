# SPDX-License-Identifier: MIT
"""Arrays of texels of every kind, and ways to cut an image into parts."""

import numpy as np

from . import libntp_ffi as ntp

NAMES = {ntp.STANDARD: "standard", ntp.ZZERO: "zzero", ntp.XY: "xy"}
TYPES = {255: np.uint8, 65535: np.uint16}


def random_texels(m, count, seed):
    """Texels of every kind: anywhere, near the sphere, near the disc's edge."""
    rng = np.random.default_rng(seed)
    texels = rng.integers(0, m + 1, (count, 3))
    v = rng.normal(size=(count, 3))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    near = np.clip(np.floor((v + 1) / 2 * m + 0.5), 0, m).astype(int)
    near = np.clip(near + rng.integers(-2, 3, near.shape), 0, m)
    angle = rng.uniform(0, 2 * np.pi, count)
    radius = rng.choice([1 - 1 / m, 1, 1 + 1 / m, 1.004, 1.3], count)
    edge = np.stack([radius * np.cos(angle), radius * np.sin(angle), rng.uniform(-1, 1, count)], 1)
    edge = np.clip(np.floor((edge + 1) / 2 * m + 0.5), 0, m).astype(int)
    return np.concatenate([texels, near, edge])


def image(m, channels=3, seed=1, h=61, w=83):
    """Normals of every kind: good, off by a few levels, random, unused, flat, gray."""
    rng = np.random.default_rng(seed)
    tilt = rng.uniform(0, 1.05, (h, w)) ** 2
    turn = rng.uniform(0, 2 * np.pi, (h, w))
    v = np.stack(
        [tilt * np.cos(turn), tilt * np.sin(turn), np.sqrt(np.maximum(1 - tilt**2, 0))], -1
    )
    v[..., 2] *= rng.choice([1, 1, 1, -1], (h, w))
    out = np.floor((v + 1) / 2 * m + 0.5).astype(int)
    out[..., 2] += rng.choice([0, 0, 0, 1, -2, 5], (h, w))
    out = np.where(rng.random((h, w, 1)) < 0.1, rng.integers(0, m + 1, (h, w, 3)), out)
    half = (m + 1) // 2
    specials = [[0] * 3, [m] * 3, [half, half, m], [half - 1, half, m], [half] * 3]
    pick = rng.integers(0, 40, (h, w))
    for i, special in enumerate(specials):
        out[pick == i] = special
    if channels == 4:
        alpha = rng.choice([0, m, m, m // 3], (h, w))
        out = np.dstack([out, alpha])
    return np.clip(out, 0, m)[..., :channels]


def noise(shape, m, seed, kind="any"):
    """Texels of all kinds: steep and flat, unused ones, alpha of all sorts."""
    rng = np.random.default_rng(seed)
    h, w, channels = shape
    src = rng.integers(0, m + 1, shape)
    if kind == "flat":
        src[..., :2] = m // 2 + rng.integers(-m // 50, m // 50, (h, w, 2))
        src[..., 2:3] = m
    odd = rng.random((h, w))
    src[odd < 0.1, :3] = 0
    src[odd > 0.95, :3] = m
    if channels == 4:
        src[..., 3] = rng.choice([0, 1, m // 3, m], (h, w))
    return src.astype(TYPES[m])


def cuts(h, w, rng, count):
    """Rectangles that cover h by w exactly once."""
    areas = [(0, 0, w, h)]
    while len(areas) < count:
        x0, y0, x1, y1 = areas.pop(rng.integers(len(areas)))
        if rng.random() < 0.5 and x1 - x0 > 1:
            x = int(rng.integers(x0 + 1, x1))
            areas += [(x0, y0, x, y1), (x, y0, x1, y1)]
        elif y1 - y0 > 1:
            y = int(rng.integers(y0 + 1, y1))
            areas += [(x0, y0, x1, y), (x0, y, x1, y1)]
        else:
            areas.append((x0, y0, x1, y1))
    return areas
