# SPDX-License-Identifier: MIT
"""The pictures behind the test files: heights, normals, and what tools do to them.

Everything is integers, or the float operations that IEEE 754 rounds correctly (+ - * / sqrt), so
that the same bytes come out on every machine.  No random generator of a library is used either.
"""

import numpy as np

WIDTH, HEIGHT = 96, 64


def noise(h, w, seed, top=256):
    """Independent integers 0..top-1, from a mixing function of position and seed."""
    i = np.arange(h * w, dtype=np.uint64).reshape(h, w) + np.uint64(seed * 1_000_003 + 1)
    i = (i ^ (i >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    i = (i ^ (i >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return ((i ^ (i >> np.uint64(31))) % np.uint64(top)).astype(np.int64)


def smooth_noise(h, w, cell, seed):
    """Value noise in 0..1 that wraps at the edges; h and w are multiples of cell."""
    grid = noise(h // cell, w // cell, seed, 1 << 16) / 65535.0
    t = np.arange(cell) / cell
    t = t * t * (3 - 2 * t)

    def stretch(a):  # along axis 0
        b = np.roll(a, -1, axis=0)
        return (a[:, None] + (b - a)[:, None] * t[None, :, None]).reshape(-1, a.shape[1])

    return stretch(stretch(grid).T).T


def height(h=HEIGHT, w=WIDTH, seed=1):
    """Heights in 0..1: hills, finer grain, and a round stud with a steep rim; wraps."""
    hills = 0.5 * smooth_noise(h, w, 32, seed) + 0.12 * smooth_noise(h, w, 8, seed + 1)
    hills = hills + 0.02 * smooth_noise(h, w, 4, seed + 2)
    y, x = np.mgrid[0:h, 0:w]
    d2 = ((x - w // 2) ** 2 + (y - h // 2) ** 2) / (h // 4) ** 2
    stud = np.where(d2 < 1, np.sqrt(np.maximum(1 - d2, 0)), 0)
    return hills + 0.3 * stud


def normals(heights, scale=8.0):
    """Unit vectors (h, w, 3), Y up, from central differences that wrap."""
    p = scale * (np.roll(heights, -1, 1) - np.roll(heights, 1, 1)) / 2
    q = scale * (np.roll(heights, 1, 0) - np.roll(heights, -1, 0)) / 2
    length = np.sqrt(1 + p * p + q * q)
    return np.stack([-p / length, -q / length, 1 / length], -1)


def sphere_directions(h=HEIGHT, w=WIDTH):
    """Unit vectors to all sides: what an object-space map of a closed shape holds."""
    y, x = np.mgrid[0:h, 0:w]
    u, v = (x % 48 - 23.5) / 23.5, (y % 48 - 23.5) / 23.5
    fold = np.where((x // 48 + y // 48) % 2 == 0, 1.0, -1.0)
    z = fold * (1 - np.abs(u) - np.abs(v))  # octahedral mapping
    n = np.stack([u, v, z], -1)
    return n / np.sqrt(n[..., 0] ** 2 + n[..., 1] ** 2 + n[..., 2] ** 2)[..., None]


def unit(v):
    return v / np.sqrt(v[..., 0] ** 2 + v[..., 1] ** 2 + v[..., 2] ** 2)[..., None]


def encode(v, m=255):
    """Correct rounding of components to levels."""
    return np.clip(np.floor((v + 1) / 2 * m + 0.5), 0, m).astype(np.int64)


def isqrt(s):
    root = np.sqrt(s.astype(np.float64)).astype(np.int64)
    root -= root * root > s
    return root + ((root + 1) * (root + 1) <= s)


def derived(v, m=255, zzero=False):
    """Levels whose blue is derived from the rounded red and green (all are on the disc)."""
    out = encode(v, m)
    s = m * m - (2 * out[..., 0] - m) ** 2 - (2 * out[..., 1] - m) ** 2
    assert s.min() >= 0
    out[..., 2] = (isqrt(4 * s) + 1) // 2 if zzero else (isqrt(s) + m + 1) // 2
    return out


def srgb(levels):
    """Linear numbers stored as sRGB, by a table whose entries are found with integer powers."""
    out = np.empty(256, np.int64)
    for c in range(256):
        v = c / 255
        # v**(1/2.4) = (v**5)**(1/12): twelfth root by bisection, exact enough for a level
        low, high = 0.0, 1.0
        for _ in range(60):
            mid = (low + high) / 2
            p = mid * mid * mid
            p = p * p
            low, high = (mid, high) if p * p < v * v * v * v * v else (low, mid)
        out[c] = int(255 * (12.92 * v if v <= 0.0031308 else 1.055 * low - 0.055) + 0.5)
    return out[levels]


def box_half(levels):
    """Half the size by averaging 2 x 2 texels as colors: what a plain resize does."""
    s = levels[0::2, 0::2] + levels[1::2, 0::2] + levels[0::2, 1::2] + levels[1::2, 1::2]
    return (s + 2) // 4


# The luminance and chrominance tables of ITU T.81 annex K, scaled as by quality 85.
_LUMA = """16 11 10 16 24 40 51 61 12 12 14 19 26 58 60 55 14 13 16 24 40 57 69 56 14 17 22 29 51 87
80 62 18 22 37 56 68 109 103 77 24 35 55 64 81 104 113 92 49 64 78 87 103 121 120 101 72 92 95 98
112 100 103 99"""
_CHROMA = """17 18 24 47 99 99 99 99 18 21 26 66 99 99 99 99 24 26 56 99 99 99 99 99 47 66 99 99 99
99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99 99
99 99"""
# round(2**14 * c(k)/2 * cos((2n + 1) k pi / 16)): rows k, columns n
_C = [8035, 7568, 6811, 5793, 4551, 3135, 1598]


def _dct_matrix():
    d = np.empty((8, 8), np.int64)
    for k in range(8):
        for n in range(8):
            phase = (2 * n + 1) * k % 32
            sign = -1 if 8 < phase < 24 else 1
            phase = min(phase, 32 - phase)
            phase = min(phase, 16 - phase)
            d[k, n] = 5793 if k == 0 else 0 if phase == 8 else sign * _C[phase - 1]
    return d


def jpeg_damage(levels):
    """What JPEG at quality 85, 4:4:4, leaves of the levels; width and height multiples of 8."""
    d = _dct_matrix()
    r, g, b = (levels[..., k] for k in range(3))
    ycc = [
        (19595 * r + 38470 * g + 7471 * b + 32768) >> 16,
        ((-11059 * r - 21709 * g + 32768 * b + 32767) >> 16) + 128,
        ((32768 * r - 27439 * g - 5329 * b + 32767) >> 16) + 128,
    ]
    back = []
    for plane, text in zip(ycc, (_LUMA, _CHROMA, _CHROMA)):
        table = (np.array(text.split(), np.int64).reshape(8, 8) * 30 + 50) // 100
        table = np.maximum(table, 1)
        h, w = plane.shape
        blocks = (plane - 128).reshape(h // 8, 8, w // 8, 8).transpose(0, 2, 1, 3)
        c = d @ blocks @ d.T  # scaled by 2**28
        step = table << 28
        c = np.sign(c) * ((np.abs(c) + step // 2) // step) * table
        p = (d.T @ c @ d + (1 << 27)) >> 28
        back.append(np.clip(p.transpose(0, 2, 1, 3).reshape(h, w) + 128, 0, 255))
    y, cb, cr = back[0], back[1] - 128, back[2] - 128
    rgb = [
        y + ((91881 * cr + 32768) >> 16),
        y + ((-22554 * cb - 46802 * cr + 32768) >> 16),
        y + ((116130 * cb + 32768) >> 16),
    ]
    return np.clip(np.stack(rgb, -1), 0, 255)
