# SPDX-License-Identifier: MIT
"""BC4 and BC5 by numpy: decoded exactly, and the best ends by trying every pair of them.

All is in integers: a level of 8 bit is 35 parts, so that sevenths and fifths are whole.
"""

import functools

import numpy as np

PARTS = 35
TOP = 255


@functools.cache
def palettes():
    """(pairs, 8) of parts: every pair of ends, those in sevenths first."""
    low, high = np.triu_indices(TOP + 1, 1)
    k = np.arange(8)
    sevenths = 5 * (low[:, None] * (7 - k) + high[:, None] * k)
    low, high = np.triu_indices(TOP + 1)
    k = np.arange(6)
    fifths = 7 * (low[:, None] * (5 - k) + high[:, None] * k)
    ends = np.broadcast_to([0, PARTS * TOP], (len(low), 2))
    return np.concatenate([sevenths, np.concatenate([fifths, ends], 1)]).astype(np.int32)


@functools.cache
def costs():
    """(256, pairs): the squared error, in parts, of each level with each pair."""
    values = palettes().T.copy()
    table = np.empty((TOP + 1, values.shape[1]), np.int32)
    for level in range(TOP + 1):
        off = np.abs(values[0] - PARTS * level)
        for row in values[1:]:
            np.minimum(off, np.abs(row - PARTS * level), out=off)
        table[level] = off * off
    return table


def least_error(block):
    """Of 16 levels of 8 bit."""
    levels, counts = np.unique(block, return_counts=True)
    total = np.zeros(costs().shape[1], np.int32)
    for level, count in zip(levels, counts, strict=True):
        total += count.astype(np.int32) * costs()[level]
    return int(total.min())


def least_error_16(block):
    """Of 16 levels of 16 bit, in parts of those."""
    total = 0
    values = [257 * column for column in palettes().T]
    for level, count in zip(*np.unique(block, return_counts=True), strict=True):
        off = functools.reduce(np.minimum, (np.abs(v - PARTS * int(level)) for v in values))
        total = total + int(count) * np.square(off, dtype=np.int64)
    return int(np.min(total))


def blocks_of(channel):
    """(rows, columns, 16) of a channel with whole blocks."""
    rows, columns = channel.shape[0] // 4, channel.shape[1] // 4
    return channel.reshape(rows, 4, columns, 4).swapaxes(1, 2).reshape(rows, columns, 16)


def decoded(blocks):
    """(h, w) of parts of (rows, columns, 8) bytes of BC4."""
    raw = blocks.astype(np.int64)
    a, b = raw[..., 0], raw[..., 1]
    bits = sum(raw[..., 2 + i] << 8 * i for i in range(6))
    index = np.stack([bits >> 3 * i & 7 for i in range(16)], -1)
    sevenths = [35 * a, 35 * b, *(5 * (a * (8 - k) + b * (k - 1)) for k in range(2, 8))]
    fifths = [35 * a, 35 * b, *(7 * (a * (6 - k) + b * (k - 1)) for k in range(2, 6))]
    fifths += [0 * a, 0 * a + PARTS * TOP]
    palette = np.where((a > b)[..., None], np.stack(sevenths, -1), np.stack(fifths, -1))
    texels = np.take_along_axis(palette, index, -1)
    rows, columns = texels.shape[:2]
    return texels.reshape(rows, columns, 4, 4).swapaxes(1, 2).reshape(4 * rows, 4 * columns)


def unit(x, y):
    """Vectors of x, y with z derived; too long ones shortened."""
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    v = np.stack([x, y, z], -1)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def vectors(blocks, height, width):
    """Of (rows, columns, 16) bytes of BC5."""
    x, y = (
        2 * decoded(blocks[..., 8 * c : 8 * c + 8])[:height, :width] / (PARTS * TOP) - 1
        for c in range(2)
    )
    return unit(x, y)


def degrees(a, b):
    """Between unit vectors."""
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1)))
