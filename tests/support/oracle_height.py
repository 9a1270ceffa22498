# SPDX-License-Identifier: MIT
"""An independent model of heightfield -> normals, in Python integers and fractions.

Written from the definitions, one texel at a time; nothing is rounded before the level.
Heights are Fractions in 0..1 (or what a float image holds) in a list of rows; None is a height
that is not finite.
"""

import functools
import math
from fractions import Fraction

import numpy as np

from . import oracle

WRAP, CLAMP, MIRROR, EXTRAPOLATE, REPEAT_SLOPE = range(5)
BORDERS = range(5)
BORDER_NAMES = ["wrap", "clamp", "mirror", "extrapolate", "repeat-slope"]


def outer(across, along):
    return [[a * b for b in along] for a in across]


def mirrored(rows):
    """A kernel from the right half of its rows, the center column being 0."""
    return [[-v for v in reversed(row)] + [0] + list(row) for row in rows]


def ramp(first, rows):
    return mirrored([[first - i + k for i in range(first)] for k in rows])


# name: (taps of p, rows from top to bottom, the middle one the texel's; denominator)
KERNELS = {
    "central": ([[-1, 0, 1]], 2),
    "forward": ([[0, -1, 1]], 1),
    "prewitt3": (outer([1, 1, 1], [-1, 0, 1]), 6),
    "sobel3": (outer([1, 2, 1], [-1, 0, 1]), 8),
    "scharr3": (outer([3, 10, 3], [-1, 0, 1]), 32),
    "prewitt5": (outer([1] * 5, [-1, -2, 0, 2, 1]), 40),
    "sobel5": (outer([1, 4, 6, 4, 1], [-1, -2, 0, 2, 1]), 128),
    "gimp5": (mirrored([[56, 35], [200, 56], [280, 70], [200, 56], [56, 35]]), 2592),
    "gimp7": (ramp(3, [0, 1, 2, 3, 2, 1, 0]), 248),
    "gimp9": (ramp(4, [0, 1, 2, 3, 4, 3, 2, 1, 0]), 680),
}
NAMES = list(KERNELS)

SOURCES = {
    "red": 0,
    "green": 1,
    "blue": 2,
    "alpha": 3,
    "luma": 4,
    "luma-gimp": 5,
    "luma-eberly": 6,
    "mean": 7,
    "max": 8,
    "min": 9,
    "screen": 10,
}


@functools.cache
def taps(name, down):
    """{(column, row): weight} of the slope to the right or, down, of the one up the picture."""
    rows, _ = KERNELS[name]
    cy, cx = len(rows) // 2, len(rows[0]) // 2
    right = {(x - cx, y - cy): w for y, row in enumerate(rows) for x, w in enumerate(row) if w != 0}
    return {(y, x): -w for (x, y), w in right.items()} if down else right


def reflect(i, n, border):
    """h[i] as [(index, weight)]."""
    if n == 1:
        return [(0, 1)]
    if border == WRAP:
        return [(i % n, 1)]
    if 0 <= i < n:
        return [(i, 1)]
    if border == CLAMP:
        return [(min(max(i, 0), n - 1), 1)]
    if border == MIRROR:
        j = i % (2 * (n - 1))
        return [(min(j, 2 * (n - 1) - j), 1)]
    if i < 0:
        return [(0, 1 - i), (1, i)]
    k = i - (n - 1)
    return [(n - 1, 1 + k), (n - 2, -k)]


@functools.cache
def reads(x, y, width, height, kernel, down, border_x, border_y):
    """The sum of taps at (x, y) as [(row, column, weight)]."""
    weights = taps(kernel, down)
    at, borders = [x, y], [border_x, border_y]
    for axis, n in enumerate((width, height)):
        if borders[axis] != REPEAT_SLOPE:
            continue
        offsets = [t[axis] for t in weights]
        first, last = -min(*offsets, 0), n - 1 - max(*offsets, 0)
        if first <= last and max(offsets) - min(offsets) < n:
            at[axis] = min(max(at[axis], first), last)
        borders[axis] = EXTRAPOLATE
    return [
        (row, column, w * wx * wy)
        for (i, j), w in weights.items()
        for row, wy in reflect(at[1] + j, height, borders[1])
        for column, wx in reflect(at[0] + i, width, borders[0])
    ]


def slope(h, x, y, kernel, down, border_x, border_y):
    """Sum of taps at (x, y); None where a height it reads is not finite."""
    total, denominator = 0, 1  # a Fraction that is reduced once, at the end
    for row, column, w in reads(x, y, len(h[0]), len(h), kernel, down, border_x, border_y):
        v = h[row][column]
        if v is None:
            return None
        if v.denominator != denominator:
            common = math.lcm(v.denominator, denominator)
            total *= common // denominator
            w *= common // v.denominator
            denominator = common
        total += w * v.numerator
    return Fraction(total, denominator)


def floor_root(f):
    """floor(sqrt(f)) and whether it is the root."""
    root = math.isqrt(f.numerator // f.denominator)
    return root, root * root == f


def level(square, negative, m):
    """floor((M + 1)/2 + M n/2) for a component n of this square and sign."""
    root, exact = floor_root(square * m * m / 4)
    if negative:
        return (m + 1) // 2 - root - (not exact)
    return (m + 1) // 2 + root


def level_zzero(square, m):
    """floor(M n + 1/2): the greatest k with k - 1/2 <= M n."""
    root, _ = floor_root(square * m * m)
    return root + ((root + Fraction(1, 2)) ** 2 <= square * m * m)


def components(p, q, min_z):
    """Squares of n.x, n.y, n.z, with min_z."""
    length = 1 + p * p + q * q
    z2 = Fraction(min_z) ** 2
    if length * z2 > 1:
        flat = p * p + q * q
        return p * p * (1 - z2) / flat, q * q * (1 - z2) / flat, z2
    return p * p / length, q * q / length, 1 / length


def slopes(h, x, y, kernel, border_x, border_y, scale, dx, dy, rounded_sums=False):
    """(p, q), or None where a height is not finite."""
    sx, sy = Fraction(scale / dx), Fraction(scale / dy)
    result = []
    for down, s in ((False, sx), (True, sy)):
        d = slope(h, x, y, kernel, down, border_x, border_y)
        if d is None:
            return None
        if rounded_sums:
            d = Fraction(float(d))
        result.append(s * d / KERNELS[kernel][1])
    return result


def texel(p, q, m, y_down=False, zz=False, xy=False, nearest=False, min_z=0.0):
    """The levels of the normal."""
    x2, y2, z2 = components(p, q, min_z)
    r = level(x2, -p < 0, m) if x2 else (m + 1) // 2
    g = level(y2, (q if y_down else -q) < 0, m) if y2 else (m + 1) // 2
    if nearest:
        return r, g, m if xy else level_zzero(z2, m) if zz else level(z2, False, m)
    r, g = oracle.pull(r, g, m)
    return r, g, m if xy else oracle.derived_blue(r, g, m, zz)


def nearest_float(square, negative, unit):
    """n, or (n + 1)/2, as the nearest binary32, ties to even."""
    scale = 1 << 1200
    root = math.isqrt(square.numerator * scale * scale // square.denominator)
    if root * root * square.denominator != square.numerator * scale * scale:
        root = Fraction(2 * root + 1, 2)  # strictly between: sides with no tie
    n = Fraction(root, scale) * (-1 if negative else 1)
    v = (n + 1) / 2 if unit else n
    if v == 0:
        return np.float32(0)
    near = np.float32(float(v))
    candidates = [near, np.nextafter(near, np.float32(2)), np.nextafter(near, np.float32(-2))]
    best = min(abs(Fraction(float(c)) - v) for c in candidates)
    ties = [c for c in candidates if abs(Fraction(float(c)) - v) == best]
    even = [c for c in ties if int(np.abs(c).view(np.uint32)) % 2 == 0]
    return (even if len(ties) > 1 else ties)[0] + np.float32(0)


def height_of(pixel, source, m):
    """The height of a pixel as an exact fraction; None where a sample it reads is not finite."""
    gray = len(pixel) <= 2
    if source == "alpha":
        used = [pixel[-1]]
    elif source in ("red", "green", "blue"):
        used = [pixel[0 if gray else SOURCES[source]]]
    else:
        used = [pixel[0]] * 3 if gray else list(pixel[:3])
    if not all(math.isfinite(float(v)) for v in used):
        return None
    v = [Fraction(float(c)) if m is None else Fraction(int(c), m) for c in used]
    weights = {
        "luma": (2126, 7152, 722),
        "luma-gimp": (3000, 5900, 1100),
        "luma-eberly": (2125, 7154, 721),
        "mean": (Fraction(10000, 3),) * 3,
    }
    if source in weights:
        return sum(w * c for w, c in zip(weights[source], v)) / 10000
    if source == "max":
        return max(v)
    if source == "min":
        return min(v)
    if source == "screen":
        return 1 - (1 - v[0]) * (1 - v[1]) * (1 - v[2])
    return v[0]


def heights(array, source="red"):
    """Rows of exact heights of a (h, w) or (h, w, c) array."""
    m = {"uint8": 255, "uint16": 65535, "float32": None}[array.dtype.name]
    if array.ndim == 2:
        array = array[:, :, None]
    return [[height_of(p, source, m) for p in row] for row in array]


def normals(array, kernel="central", border_x=WRAP, border_y=WRAP, scale=1.0, dx=1.0, dy=1.0,
            source="red", invert=False, dst=np.uint8, min_z=0.0, **how):  # fmt: skip
    """The whole result; texels that are not finite are flat."""
    h = heights(array, source)
    if invert:
        h = [[None if v is None else 1 - v for v in row] for row in h]
    m = np.iinfo(dst).max
    out = np.zeros((len(h), len(h[0]), 3), dst)
    floats = array.dtype == np.float32
    for y in range(len(h)):
        for x in range(len(h[0])):
            pq = slopes(h, x, y, kernel, border_x, border_y, scale, dx, dy, floats)
            p, q = pq or (Fraction(0), Fraction(0))
            out[y, x] = texel(p, q, m, min_z=min_z, **how)
    return out
