# SPDX-License-Identifier: MIT
"""The orientation statistic in numpy, written from docs/orientation.md: nothing from libntp."""

import numpy as np

SMOOTH = np.array([1, 5, 10, 10, 5, 1])
STEEP = np.array([-1, -3, -2, 2, 3, 1])
ONE = 4096


def slopes(pixels):
    """(X/Z, Y/Z) of (h, w, c) levels in units of 1/4096, and which texels can be used."""
    c = pixels.astype(np.int64)
    m = 255 if pixels.dtype == np.uint8 else 65535
    x, y = 2 * c[..., 0] - m, 2 * c[..., 1] - m
    s = m * m - x * x - y * y
    used = 100 * s > m * m
    color = c[..., :3]
    used &= ~((color == 0).all(-1) | ((color == m).all(-1) & (c.shape[-1] > 2)))
    if c.shape[-1] == 4:
        used &= c[..., 3] > 0
    one, by = (ONE, 1) if m == 255 else (ONE // 2, 4)  # floats: IEEE single
    z = np.sqrt((np.where(used, s, 4) // by).astype(np.float32))
    p, q = (np.trunc((a * one).astype(np.float32) / z).astype(np.int64) for a in (x, y))
    return np.where(used, p, 0), np.where(used, q, 0), used


def _filter(a, taps, axis):
    n = a.shape[axis] - 5
    return sum(t * np.take(a, range(k, k + n), axis) for k, t in enumerate(taps))


def _pairs(a, axis):
    n = a.shape[axis] - 1
    return np.take(a, range(n), axis) + np.take(a, range(1, n + 1), axis)


def sampled(height, every_row=False):
    """Which rows loops are taken in."""
    step = 1
    while not every_row and step < 128 and step * 64 <= height:
        step *= 2
    y = np.arange(height)
    onward = step * 5 // 8 // 2 * 2 + 1
    return y % step == y // step * onward % step


def loops(pixels, every_row=False):
    """Of each loop that counts: u, v of the wide filter, u, v of the narrow one, x, y, its p, q,
    and the change of p to the right and of q down by the wide filter."""
    h, w = pixels.shape[:2]
    if h < 6 or w < 6:
        return np.zeros((10, 0), np.int64)
    p, q, used = slopes(pixels)
    wide = [-_filter(_filter(p, STEEP, 0), SMOOTH, 1), _filter(_filter(q, SMOOTH, 0), STEEP, 1)]
    along = [_filter(_filter(p, SMOOTH, 0), STEEP, 1), -_filter(_filter(q, STEEP, 0), SMOOTH, 1)]
    whole = _filter(_filter(used.astype(np.int64), [1] * 6, 0), [1] * 6, 1) == 36
    y, x = np.mgrid[2 : h - 3, 2 : w - 3]
    whole &= sampled(h, every_row)[2 : h - 3, None]
    narrow = [-_pairs(np.diff(p, axis=0), 1), _pairs(np.diff(q, axis=1), 0)]
    near = [a[2 : h - 3, 2 : w - 3] for a in (*narrow, p, q)]
    return np.stack([a[whole] for a in (*wide, *near[:2], x, y, *near[2:], *along)])


def _blocks(u, v, block, inside=False):
    """What each block says, as a share of what all say; the energy before large ones are held.

    inside: those of more than twice to four times the median are held, else those of more than
    three times the root mean square.
    """
    top = np.maximum(abs(u), abs(v))
    bits = np.where(top > 0, np.floor(np.log2(np.maximum(top, 1))).astype(int) + 1, 0)
    shift = np.maximum(bits - 12, 0)
    uu, vv = np.trunc(u / 2.0**shift), np.trunc(v / 2.0**shift)
    scale = 4.0 ** np.maximum(np.arange(25) - 12, 0)
    n = np.bincount(bits, minlength=25)
    energy = np.bincount(bits, uu * uu + vv * vv, minlength=25) * scale
    if energy.sum() == 0:
        return np.zeros(256), 0.0
    most = 9 * energy.sum() / len(u)
    if inside:
        varied = np.sort(bits[bits > 0])
        most = 4.0 ** (varied[(len(varied) - 1) // 2] + 1)
    weight = np.ones(25)
    far = energy > most * n
    weight[far] = most * n[far] / energy[far]
    cross = np.bincount(block * 25 + bits, uu * vv, minlength=256 * 25).reshape(256, 25)
    return 2 * (cross * (weight * scale)).sum(1) / (energy * weight).sum(), energy.sum()


def _score(sums):
    spread = np.sqrt((sums * sums).sum())
    return sums.sum() / spread if spread else 0.0


def _enough(filters, inside=False):
    sign = -1 if sum(filters).sum() < 0 else 1
    clear, steady = max(sign * f.sum() for f in filters), sign * _score(sum(filters))
    if inside:
        return clear >= 0.15 and steady >= 5
    return (clear >= 0.1 and steady >= 4) or (clear >= 0.5 and steady >= 3.5)


def statistic(pixels, every_row=False):
    """(r, z, loops, whether it is a weave)."""
    h, w = pixels.shape[:2]
    u, v, u2, v2, x, y, p, q, along_p, along_q = loops(pixels, every_row)
    if len(u) == 0:
        return 0.0, 0.0, 0, False
    cells = [max(-(-side // 16), 4) for side in (w, h)]
    block = (y // cells[1]) * 16 + x // cells[0]
    (wide, across), (narrow, _) = (_blocks(*uv, block) for uv in ((u, v), (u2, v2)))
    inside = [_blocks(*uv, block, inside=True)[0] for uv in ((u, v), (u2, v2))]
    told = (
        inside if _enough(inside, inside=True) and not _enough([wide, narrow]) else [wide, narrow]
    )
    sums = (told[0] + told[1]) / 2
    along = 65536.0 * (np.trunc(along_p / 256) ** 2 + np.trunc(along_q / 256) ** 2).sum()
    both, either = 2.0 * abs(p * q).sum(), float((p * p + q * q).sum())
    bends, meets = across * either, along * both
    mixed = both < 0.6 * either and narrow.sum() / (wide.sum() or 1) < 0.45
    weave = (both < 0.45 * either and bends > meets) or (mixed and bends > 0.7 * meets)
    surface = min(abs(wide.sum()), abs(narrow.sum())) >= 0.85 and wide.sum() * narrow.sum() > 0
    return sums.sum(), _score(sums), len(u), weave and not surface
