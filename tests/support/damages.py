# SPDX-License-Identifier: MIT
"""Kinds of damage to normals, one at a time, as the classification meets them.

Most take vectors and a random generator and give levels.
"""

import numpy as np

from . import maps, surfaces


def sample(family, strength, rng, size=128):
    height = getattr(surfaces, family)(rng, size, size)
    return surfaces.normals_of(height, strength)


def rounded(n):
    return maps.to_type(maps.encode(n))


def jpeg(quality):
    return lambda n, rng: maps.jpeg(rounded(n), quality, 0)


def share_of_texels(levels, rng, share, value):
    levels = levels.copy()
    rows = max(1, int(levels.shape[0] * share))
    levels[:rows] = value
    return levels


def wrong_z(n, rng):
    levels = rounded(n)
    bad = rng.random(n.shape[:2]) < 0.03
    levels[bad, 2] = rng.integers(0, 256, int(bad.sum()))
    return levels


def tilted(n, rng):
    n = n + np.array([0.2, 0, 0])
    levels = rounded(n / np.linalg.norm(n, axis=-1, keepdims=True))
    levels[5, 5] = (3, 250, 7)
    return levels


def constant_blue(value):
    def damage(n, rng):
        levels = rounded(n)
        levels[..., 2] = value
        return levels

    return damage


def as_zzero(n, rng):
    levels = rounded(n)
    levels[..., 2] = np.floor(n[..., 2] * 255 + 0.5)
    return levels


def resized(factor, how):
    def damage(n, rng):
        side = int(n.shape[0] * factor)
        return maps.resize(rounded(n), side, side, how)

    return damage
