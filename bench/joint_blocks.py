# SPDX-License-Identifier: MIT
"""The best BC5 blocks that there are, in the angle between the vectors, by trying all pairs of pairs of ends.

The distance between two unit vectors stands for their angle, as in the encoder; it is at least that of
their x and y.  So what each pair of ends leaves of its own channel bounds its block from below, and
almost all pairs are left out.  Values beyond the disc are pulled onto it, where this bound may not hold;
but no block whose sum is less than the distance to its rim has one.
"""

import numpy as np

from support import exact_blocks

SCALE = 2 / (exact_blocks.PARTS * exact_blocks.TOP)  # of a part, in components


def z_of(x, y):
    return np.sqrt(np.maximum(1 - x * x - y * y, 0))


def from_rim(x, y):
    """The distance of a block's components to the rim of the disc."""
    return 1 - np.sqrt((x * x + y * y).max())


def distance(x, y, palettes_x, palettes_y):
    """(n,): the sum over texels of the distance to the nearest of 64 vectors, for n pairs of palettes."""
    px, py = palettes_x[:, :, None], palettes_y[:, None, :]
    square = px * px + py * py
    inside = 1 / np.sqrt(np.maximum(square, 1))
    px, py, pz = px * inside, py * inside, np.sqrt(np.maximum(1 - square, 0))
    total = 0
    for a, b, c in zip(x, y, z_of(x, y), strict=True):
        off = (px - a) ** 2 + (py - b) ** 2 + (pz - c) ** 2
        total = total + np.sqrt(off.min((1, 2)))
    return total


def candidates(levels, most):
    """Pairs of ends that leave at most `most`: which, and (n, 16) what they leave of each texel."""
    off = np.sqrt(exact_blocks.costs()[levels].T) * SCALE
    chosen = np.flatnonzero(off.sum(1) <= most)
    chosen = chosen[np.argsort(off[chosen].sum(1))]
    return chosen, off[chosen]


def least_distance(levels_x, levels_y, known):
    """The least sum of distances of a block of 8 bits; `known`: that of some block."""
    x, y = (2.0 * levels / exact_blocks.TOP - 1 for levels in (levels_x, levels_y))
    palettes = SCALE * exact_blocks.palettes() - 1
    (of_x, left_x), (of_y, left_y) = (candidates(v, known) for v in (levels_x, levels_y))
    best, square_y = known, left_y**2
    for number, left in zip(of_x, left_x, strict=True):
        if left.sum() >= best:
            break
        bound = np.sqrt(left**2 + square_y).sum(1)
        open_ = np.flatnonzero(bound < best)
        open_ = open_[np.argsort(bound[open_])]
        for first in range(0, len(open_), 256):
            some = open_[first : first + 256]
            if bound[some[0]] >= best:
                break
            one = np.broadcast_to(palettes[number], (len(some), 8))
            best = min(best, distance(x, y, one, palettes[of_y[some]]).min())
    return best
