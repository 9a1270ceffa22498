# SPDX-License-Identifier: MIT
"""Normals that other programs make from heights: those of them that are installed.

numpy's gradient is always there; OpenCV is used if it is.  made_by_blender.py is for Blender's bakes.
None of this looks at libntp or at its rules.
"""

import numpy as np

from support import surfaces

try:
    import cv2
except ImportError:
    cv2 = None

FAMILIES = (surfaces.fractal, surfaces.bricks, surfaces.bumps, surfaces.noise)
SIDES = (32, 64, 128, 256)


def encoded(p, q, rng):
    """Levels of slopes p to the right and q down the picture, green up."""
    n = np.stack([-p, q, np.ones_like(p)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    level = (n * 0.5 + 0.5) * 255
    return np.floor(level + (0.5 if rng.random() < 0.7 else 0)).astype(np.uint8)


def by_numpy(h, strength, rng):
    q, p = np.gradient(h * strength)
    return encoded(p, q, rng)


def by_sobel(h, strength, rng):
    size = int(rng.choice([3, 5, 7]))
    gain = {3: 8, 5: 128, 7: 2048}[size]
    p, q = (cv2.Sobel(h * strength, cv2.CV_64F, *d, ksize=size) / gain for d in ((1, 0), (0, 1)))
    return encoded(p, q, rng)


def by_scharr(h, strength, rng):
    p, q = (cv2.Scharr(h * strength, cv2.CV_64F, *d) / 32 for d in ((1, 0), (0, 1)))
    return encoded(p, q, rng)


def by_cv_jpeg(h, strength, rng):
    """OpenCV's blur, Sobel and JPEG."""
    made = by_sobel(cv2.GaussianBlur(h, (0, 0), rng.uniform(0.5, 2)), strength, rng)
    quality = [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(75, 98))]
    return cv2.imdecode(cv2.imencode(".jpg", made, quality)[1], cv2.IMREAD_COLOR)


def makers():
    """(name, function) of what is installed."""
    found = [("numpy", by_numpy)]
    if cv2:
        found += [("OpenCV Sobel", by_sobel), ("OpenCV Scharr", by_scharr)]
        found += [("OpenCV JPEG", by_cv_jpeg)]
    return found


def draw(count, seed):
    """(name, pixels, which way green points), the makers in turn, half of them turned."""
    there = makers()
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        name, make = there[number % len(there)]
        side = int(rng.choice(SIDES))
        h = FAMILIES[int(rng.integers(len(FAMILIES)))](rng, side, side)
        h = (h - h.min()) / max(np.ptp(h), 1e-9)
        steep = np.hypot(*np.gradient(h)).mean()
        pixels = make(h, rng.uniform(0.15, 0.6) / max(steep, 1e-9), rng)
        y = "up"
        if rng.integers(2):
            pixels = pixels.copy()
            pixels[..., 1] = 255 - pixels[..., 1]
            y = "down"
        yield f"{name}, {side}", np.ascontiguousarray(pixels), y
