# SPDX-License-Identifier: MIT
"""Surfaces as unit vectors (h, w, 3): x right, y up, z towards the viewer; most by formulas."""

import numpy as np
from PIL import Image, ImageDraw


def unit(p, q):
    """Normals of slopes p to the right and q downwards."""
    n = np.stack([-p, q, np.ones_like(p)], -1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def grid(h, w):
    y, x = np.mgrid[:h, :w]
    return y + 0.5, x + 0.5


def domes(rng, h, w):
    """Caps of spheres of several sizes on a plane; a later one covers the earlier ones."""
    y, x = grid(h, w)
    n = unit(np.zeros((h, w)), np.zeros((h, w)))
    for _ in range(int(rng.integers(6, 40))):
        r = rng.uniform(0.05, 0.25) * min(h, w)
        dx, dy = (x - rng.uniform(0, w)) / r, (y - rng.uniform(0, h)) / r
        inside = dx * dx + dy * dy < rng.uniform(0.2, 0.95)
        z = np.sqrt(np.maximum(1 - dx * dx - dy * dy, 0))
        n[inside] = np.stack([dx, -dy, z], -1)[inside]
    return n


def masonry(rng, h, w):
    """Bricks in rows, with edges cut at one angle: few directions, hard borders."""
    y, x = grid(h, w)
    tall, wide = rng.uniform(10, 28), rng.uniform(24, 60)
    row = np.floor(y / tall)
    u, v = (x + row * wide * 0.37) % wide, y % tall
    edge, cut = rng.uniform(1.5, 4), rng.uniform(0.3, 1.6)
    p = cut * ((u < edge) * 1.0 - (u > wide - edge))
    q = cut * ((v < edge) * 1.0 - (v > tall - edge))
    return unit(p, q)


def weave(rng, h, w):
    """Threads, over and under: parts of cylinders along both axes."""
    y, x = grid(h, w)
    t = rng.uniform(5, 14)
    over = (np.floor(x / t) + np.floor(y / t)) % 2 == 0
    bend = rng.uniform(0.5, 0.95)
    a, b = bend * (2 * (x % t) / t - 1), bend * (2 * (y % t) / t - 1)
    nx, ny = np.where(over, a, 0), np.where(over, 0, -b)
    return np.stack([nx, ny, np.sqrt(1 - nx * nx - ny * ny)], -1)


def studs(rng, h, w):
    """Pyramids in a grid: four directions and the plane between them."""
    y, x = grid(h, w)
    s, slope = rng.uniform(12, 30), rng.uniform(0.3, 2.0)
    u, v = (x % s) / s - 0.5, (y % s) / s - 0.5
    side = np.abs(u) > np.abs(v)
    near = np.maximum(np.abs(u), np.abs(v)) < rng.uniform(0.3, 0.48)
    p = np.where(side & near, -np.sign(u) * slope, 0)
    q = np.where(~side & near, -np.sign(v) * slope, 0)
    return unit(p, q)


def cobbles(rng, h, w):
    """Rounded stones around random points: each texel leans away from the nearest one."""
    y, x = grid(h, w)
    points = rng.uniform(0, 1, (int(rng.integers(12, 60)), 2)) * [h, w]
    apart = np.stack([np.hypot(y - a, x - b) for a, b in points])
    nearest = apart.argmin(0)
    size = np.sqrt(h * w / len(points)) * 0.75
    lean = np.minimum(apart.min(0) / size, 1) ** rng.uniform(1, 4) * rng.uniform(0.4, 0.95)
    away = np.arctan2(y - points[nearest, 0], x - points[nearest, 1])
    nx, ny = lean * np.cos(away), -lean * np.sin(away)
    return np.stack([nx, ny, np.sqrt(1 - nx * nx - ny * ny)], -1)


def lattice(rng, h, w, cells):
    """Random values at the corners of a lattice, smoothly between them; (h, w) in 0..1."""
    values = rng.uniform(0, 1, (cells + 2, cells + 2))
    y, x = np.linspace(0, cells, h), np.linspace(0, cells, w)
    iy, ix = y.astype(int)[:, None], x.astype(int)[None, :]
    fy, fx = (y % 1)[:, None], (x % 1)[None, :]
    fy, fx = fy * fy * (3 - 2 * fy), fx * fx * (3 - 2 * fx)
    top = values[iy, ix] * (1 - fx) + values[iy, ix + 1] * fx
    bottom = values[iy + 1, ix] * (1 - fx) + values[iy + 1, ix + 1] * fx
    return top * (1 - fy) + bottom * fy


def octaves(rng, h, w):
    total = np.zeros((h, w))
    cells, weight, fall = int(rng.integers(2, 6)), 1.0, rng.uniform(0.35, 0.65)
    while cells < min(h, w) / 2:
        total += weight * lattice(rng, h, w, cells)
        cells, weight = cells * 2, weight * fall
    return total / np.ptp(total)


def from_heights(heights, steepness):
    """By differences inside; the mean slope is `steepness`."""
    q, p = np.gradient(heights)
    scale = steepness / max(np.hypot(p, q).mean(), 1e-9)
    return unit(p * scale, q * scale)


def rock(rng, h, w):
    return from_heights(octaves(rng, h, w), rng.uniform(0.2, 1.2))


def softened(a, times=1):
    """A box of three by three, several times."""
    for _ in range(times):
        padded = np.pad(a, 1, mode="edge")
        a = sum(padded[i : i + a.shape[0], k : k + a.shape[1]] for i in range(3) for k in range(3))
        a = a / 9
    return a


def scratched(rng, h, w):
    """Thin lines in a plate that is almost flat."""
    picture = Image.new("L", (w, h), 255)
    pen = ImageDraw.Draw(picture)
    for _ in range(int(rng.integers(15, 90))):
        ends = rng.uniform(0, 1, 4) * [w, h, w, h]
        pen.line([float(v) for v in ends], fill=int(rng.integers(0, 200)), width=1)
    plate = softened(np.asarray(picture, float) / 255) + 0.1 * octaves(rng, h, w)
    return from_heights(plate, rng.uniform(0.1, 0.4))


def lettered(rng, h, w):
    """Signs like letters, raised with slanting sides: five by seven cells each."""
    plate = np.zeros((h, w))
    cell = int(rng.integers(2, 5))
    for y in range(3, h - 8 * cell, 9 * cell):
        for x in range(3, w - 6 * cell, 7 * cell):
            sign = np.kron(rng.integers(0, 2, (7, 5)), np.ones((cell, cell)))
            plate[y : y + 7 * cell, x : x + 5 * cell] = sign
    return from_heights(softened(plate, int(rng.integers(1, 4))), rng.uniform(0.15, 0.6))


def corrugated(rng, h, w):
    """Half pipes side by side, at some angle."""
    y, x = grid(h, w)
    angle, t = rng.uniform(0, np.pi), rng.uniform(8, 40)
    along = (x * np.cos(angle) + y * np.sin(angle)) / t % 1
    lean = rng.uniform(0.4, 0.9) * np.sin(2 * np.pi * along)
    nx, ny = lean * np.cos(angle), -lean * np.sin(angle)
    return np.stack([nx, ny, np.sqrt(1 - nx * nx - ny * ny)], -1)


SURFACES = [domes, masonry, weave, studs, cobbles, rock, scratched, lettered, corrugated]
