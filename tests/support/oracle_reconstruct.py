# SPDX-License-Identifier: MIT
"""An independent model of weighted reconstruction: dense matrices in float64.

Every slope is a row of a matrix made of the taps and borders of oracle_height, one texel at a
time; weights, holes and pairs of neighbors as docs/reconstruction.md has them.
"""

import functools

import numpy as np

from . import oracle_height as heights

WRAP, CLAMP, MIRROR, EXTRAPOLATE, REPEAT_SLOPE = range(5)
BAKED = "baked"


def shifted(n, offset, offsets, border):
    """(matrix that takes the element `offset` on from each, with the border; which it reads)."""
    matrix, reads = np.zeros((n, n)), np.zeros((n, n), bool)
    first, last = min(*offsets, 0), max(*offsets, 0)
    for i in range(n):
        at = i
        if border == REPEAT_SLOPE and max(offsets) - min(offsets) < n and -first <= n - 1 - last:
            at = min(max(i, -first), n - 1 - last)
        for index, share in heights.reflect(at + offset, n, beyond(border)):
            matrix[i, index] += share
            reads[i, index] = True
    return matrix, reads


@functools.cache
def slope_rows(shape, kernel, border_x, border_y, down):
    """(matrix, which texels each row reads as a boolean matrix)."""
    h, w = shape
    taps, denominator = heights.KERNELS[kernel]
    radius_y, radius_x = len(taps) // 2, len(taps[0]) // 2
    taps = {
        (i - radius_x, j - radius_y): taps[j][i]
        for j in range(len(taps))
        for i in range(len(taps[0]))
        if taps[j][i] != 0
    }
    if down:
        taps = {(y, x): weight for (x, y), weight in taps.items()}
    columns, rows = [i for i, _ in taps], [j for _, j in taps]
    matrix, reads = np.zeros((h * w, h * w)), np.zeros((h * w, h * w), bool)
    for (i, j), weight in taps.items():
        x, reads_x = shifted(w, i, columns, border_x)
        y, reads_y = shifted(h, j, rows, border_y)
        matrix += weight * np.kron(y, x)
        reads |= np.kron(reads_y, reads_x)
    return matrix / denominator, reads


def beyond(border):
    return EXTRAPOLATE if border == REPEAT_SLOPE else border


def weights_of(p, q, derived):
    z2 = 1 / (1 + p * p + q * q)
    if derived:
        across = z2 / ((1 + p * p) ** 2 + (p * q) ** 2)
        down = z2 / ((1 + q * q) ** 2 + (p * q) ** 2)
    else:
        across, down = z2 / (1 + p * p), z2 / (1 + q * q)
    return np.maximum(across, 0.01), np.maximum(down, 0.01)


def pairs(shape, border_x, border_y):
    """For each pair of neighbors: is it along y, and the four texels around it (None: beyond)."""
    h, w = shape
    for along_y, n, others, border in [(False, w, h, border_x), (True, h, w, border_y)]:
        for other in range(others):
            for i in range(n if border == WRAP and n > 1 else n - 1):
                four = []
                for k in range(i - 1, i + 3):
                    inside = 0 <= k < n
                    at = k % n if inside or border == WRAP else None
                    if at is None:
                        four.append(None)
                    else:
                        four.append(at * w + other if along_y else other * w + at)
                yield along_y, four


def system(p, q, kernel, border_x, border_y, holes, strength, derived=False):
    """(matrix, data, weights) of all that is fitted; holes: boolean image."""
    shape = p.shape
    n = p.size
    wp, wq = (v.ravel() * ~holes.ravel() for v in weights_of(p, q, derived))
    p, q = p.ravel(), q.ravel()
    matrices, data, weights = [], [], []
    counts = [np.zeros(n, bool), np.zeros(n, bool)]
    if kernel != BAKED:
        for down, slopes, weight in [(False, p, wp), (True, q, wq)]:
            matrix, reads = slope_rows(shape, kernel, border_x, border_y, down)
            counts[down] = ~(reads & holes.ravel()[None, :]).any(axis=1) & ~holes.ravel()
            matrices.append(matrix)
            data.append(slopes)
            weights.append(weight * counts[down])
    if kernel != "forward":
        for along_y, four in pairs(shape, border_x, border_y):
            weight, slope = (wq, q) if along_y else (wp, p)
            a, b = four[1], four[2]
            held = [k is not None and weight[k] > 0 for k in four]
            row = np.zeros(n)
            row[b] += 1
            row[a] -= 1
            value = (slope[a] + slope[b]) / 2
            if kernel == BAKED and held[0] and held[3]:
                value = (13 * (slope[a] + slope[b]) - slope[four[0]] - slope[four[3]]) / 24
            alone = not any(k is not None and counts[along_y][k] for k in four)
            least = min(weight[a], weight[b])
            matrices.append(row[None])
            data.append([value])
            times = 1 if kernel == BAKED else 10 * strength if alone else strength
            weights.append([least * times])
    if not matrices:
        return np.zeros((1, n)), np.zeros(1), np.zeros(1)
    return np.vstack(matrices), np.concatenate(data), np.concatenate(weights)


def islands(holes, border_x, border_y):
    """A number for each texel, from 0; -1 in holes."""
    h, w = holes.shape
    label = np.full((h, w), -1)
    count = 0
    for y in range(h):
        for x in range(w):
            if holes[y, x] or label[y, x] >= 0:
                continue
            todo = [(y, x)]
            label[y, x] = count
            while todo:
                j, i = todo.pop()
                for dj, di in [(0, 1), (0, -1), (1, 0), (-1, 0)]:
                    v, u = j + dj, i + di
                    v = v % h if border_y == WRAP else v
                    u = u % w if border_x == WRAP else u
                    if 0 <= v < h and 0 <= u < w and not holes[v, u] and label[v, u] < 0:
                        label[v, u] = count
                        todo.append((v, u))
            count += 1
    return label, count


def laplacian(shape, border_x, border_y):
    """Differences to the neighbors, summed; free ends have none beyond."""
    matrix = np.zeros((shape[0] * shape[1],) * 2)
    for _, (_, a, b, _) in pairs(shape, border_x, border_y):
        for i, j in ((a, b), (b, a)):
            matrix[i, i] += 1
            matrix[i, j] -= 1
    return matrix


def with_prior(matrix, data, weights, shape, kernel, border_x, border_y, level):
    """The system with the prior that smooth heights are likelier; no holes."""
    deep, radius = level < 1 / 255, {"3": 1, "5": 2, "7": 3, "9": 4}.get(kernel[-1], 1)
    part = (0.75 if radius < 3 else 0.5) if deep else (0.6 if radius < 2 else 0.5)
    n = matrix.shape[1]
    mean = weights[:n].mean()  # of the slopes to the right
    square = np.mean((matrix.T @ (weights * data)) ** 2)
    noise = level * level / 12 * part * (1 if deep else mean)
    rows = laplacian(shape, border_x, border_y)
    prior = np.full(n, noise * mean * mean / square)
    return np.vstack([matrix, rows]), np.append(data, np.zeros(n)), np.append(weights, prior)


def solve(p, q, kernel, border_x, border_y, holes, strength, derived=False, level=None):
    """The heights, of mean 0 over each island and 0 in holes; level: 2/M, where a prior takes the
    place of pairs."""
    matrix, data, weights = system(p, q, kernel, border_x, border_y, holes, strength, derived)
    if level is not None:
        system_ = matrix, data, weights
        matrix, data, weights = with_prior(*system_, p.shape, kernel, border_x, border_y, level)
    root = np.sqrt(weights)
    h = np.linalg.lstsq(matrix * root[:, None], data * root, rcond=1e-12)[0].reshape(p.shape)
    label, count = islands(holes, border_x, border_y)
    for i in range(count):
        h[label == i] -= h[label == i].mean()
    h[holes] = 0
    return h
