# SPDX-License-Identifier: MIT
"""Pictures that are no normals: photographs, charts, noise, as (h, w, 3) of levels 0..255."""

import numpy as np

from .drawn_surfaces import grid, lattice, masonry, octaves


def colors_of(rng, h, w, where, count=5):
    """Colors along a random ramp; `where` is in 0..1."""
    ramp = rng.uniform(0, 255, (count, 3))
    at = np.clip(where, 0, 1) * (count - 1)
    return np.stack([np.interp(at, np.arange(count), ramp[:, k]) for k in range(3)], -1)


def photograph(rng, h, w):
    """Things of one color each in uneven light, with grain."""
    y, x = grid(h, w)
    picture = colors_of(rng, h, w, octaves(rng, h, w))
    for _ in range(int(rng.integers(3, 12))):
        cy, cx, r = rng.uniform(0, h), rng.uniform(0, w), rng.uniform(0.1, 0.35) * min(h, w)
        thing = ((y - cy) / r) ** 2 + ((x - cx) / (r * rng.uniform(0.5, 2))) ** 2 < 1
        picture[thing] = rng.uniform(20, 235, 3)
    light = 0.45 + 0.75 * lattice(rng, h, w, 3)
    return picture * light[..., None] + rng.normal(0, rng.uniform(1, 8), (h, w, 3))


def meadow(rng, h, w):
    blades = octaves(rng, h, w) ** rng.uniform(0.7, 2)
    base = np.array([rng.uniform(60, 120), rng.uniform(110, 190), rng.uniform(20, 70)])
    return base * (0.3 + blades[..., None]) + rng.normal(0, 10, (h, w, 1))


def planks(rng, h, w):
    y, x = grid(h, w)
    board = np.floor(y / rng.uniform(12, 30)).astype(int)
    grain = np.sin(x / 20 + 40 * lattice(rng, h, w, 4) + board * 3)
    tone = rng.uniform(0.6, 1.1, board.max() + 1)[board]
    color = np.array([170, 115, 70]) * rng.uniform(0.7, 1.2)
    return color * (tone + 0.12 * grain)[..., None]


def sky(rng, h, w):
    y, _ = grid(h, w)
    blue = np.array([90, 140, 230]) + (y / h)[..., None] * [120, 80, 10]
    cloud = np.clip(octaves(rng, h, w) * 2 - 0.8, 0, 1)[..., None]
    return blue * (1 - cloud) + cloud * 245


def two_fades(rng, h, w):
    """A gradient along each axis, blue of its own: like a chart of colors."""
    y, x = grid(h, w)
    turn = rng.permutation(3)
    planes = np.stack([x / w, y / h, np.full((h, w), rng.uniform(0, 1))], -1)
    return 255 * planes[..., turn]


def color_wheel(rng, h, w):
    """Hue around the middle, saturation outwards, as color pickers show it."""
    y, x = grid(h, w)
    hue = (np.arctan2(y - h / 2, x - w / 2) / (2 * np.pi) + rng.uniform(0, 1)) * 6
    full = np.stack([np.clip(np.abs((hue - k) % 6 - 3) - 1, 0, 1) for k in (0, 2, 4)], -1)
    saturation = np.clip(np.hypot(y - h / 2, x - w / 2) / (min(h, w) / 2), 0, 1)[..., None]
    return 255 * (1 - saturation * (1 - full))


def chart(rng, h, w):
    """Squares of even colors, as photographers use."""
    picture = np.zeros((h, w, 3))
    rows, columns = int(rng.integers(3, 7)), int(rng.integers(4, 9))
    for i in range(rows):
        for k in range(columns):
            part = np.s_[
                i * h // rows : (i + 1) * h // rows, k * w // columns : (k + 1) * w // columns
            ]
            picture[part] = rng.uniform(0, 255, 3)
    return picture


def white_noise(rng, h, w):
    return rng.integers(0, 256, (h, w, 3)).astype(float)


def masks(rng, h, w):
    """Occlusion, roughness and metal in one file, as engines pack them."""
    metal = (octaves(rng, h, w) > 0.5) * 255.0
    return np.stack([255 - 120 * octaves(rng, h, w), 90 + 150 * octaves(rng, h, w), metal], -1)


def brick_wall(rng, h, w):
    """The color texture that belongs to such a surface."""
    n = masonry(rng, h, w)
    edge = n[..., 2] < 0.999
    picture = np.array([165, 80, 60]) * (0.7 + 0.5 * octaves(rng, h, w))[..., None]
    picture[edge] = 190
    return picture + rng.normal(0, 6, (h, w, 3))


def purple_painting(rng, h, w):
    """The colors that normals have, in a picture that has none."""
    mix = octaves(rng, h, w)[..., None]
    return np.array([110, 110, 200]) + (mix - 0.5) * rng.uniform(-120, 120, 3)


PICTURES = [photograph, meadow, planks, sky, two_fades, color_wheel, chart, white_noise, masks,
            brick_wall, purple_painting]  # fmt: skip
