# SPDX-License-Identifier: MIT
"""The test oracle for conversions: one texel at a time, in integers and fractions.

A texel is a tuple of levels, (r, g), (r, g, b) or (r, g, b, a); vectors are tuples of floats.
Encodings are the numbers of libntp.h.
"""

import functools
import math
from fractions import Fraction

from .libntp_ffi import STANDARD, XY, ZZERO
from .oracle import derived_blue, encode, encode_zzero, exact, pull, radicand


def deepen(c, m, to):
    """A level by value into another depth, correctly rounded."""
    return math.floor(Fraction(c * to, m) + Fraction(1, 2))


def is_unused(texel, m):
    colors = texel[:3]
    clear = len(texel) == 4 and texel[3] == 0
    return all(c == 0 for c in colors) or all(c == m for c in colors) or clear


def convert(texel, m, encoding, to, target, channels, flip=False, touch=False):
    """(levels of the target, was a negative z made |z|, was it pulled from outside the disc)."""
    used = bool(touch) or not is_unused(texel, m)
    (r, g, b, a), negative, pulled = converted(tuple(texel), m, encoding, to, target, used)
    if flip and used:
        g = to - g
    return (r, g, b, a)[:channels], negative, pulled


@functools.lru_cache(maxsize=4096)  # one texel is asked for with many layouts
def converted(texel, m, encoding, to, target, used):
    """The same, of four channels and not flipped."""
    blue_in = texel[2] if len(texel) > 2 else m * any(texel)  # black stays black
    alpha = texel[3] if len(texel) > 3 else m
    r, g = deepen(texel[0], m, to), deepen(texel[1], m, to)
    a = deepen(alpha, m, to)
    if not used:
        return (r, g, deepen(blue_in, m, to), a), False, False
    negative = pulled = False
    too_long = radicand(r, g, to) < 0
    if encoding == XY:
        over = radicand(*texel[:2], m) < 0
        if target == XY:
            b = deepen(texel[2], m, to) if len(texel) > 2 else to
            if not over:
                pulled = too_long
                r, g = pull(r, g, to)
        else:
            pulled = too_long
            r, g = pull(r, g, to)
            b = derived_blue(r, g, to, target == ZZERO)
    else:
        zz = encoding == ZZERO
        is_exact = exact(*texel[:3], m, zz, either_sign=True)
        sign = -1 if not zz and blue_in <= (m - 1) // 2 else 1
        if is_exact:
            pulled = too_long
            r, g = pull(r, g, to)
        negative = target == ZZERO and sign < 0
        if target == XY:
            b = to
        elif is_exact:
            b = derived_blue(r, g, to, target == ZZERO)
            b = to - b if sign < 0 and target == STANDARD else b
        elif zz == (target == ZZERO):
            b = deepen(blue_in, m, to)
        else:
            z = Fraction(blue_in, m) if zz else Fraction(2 * blue_in - m, m)
            b = encode_zzero(abs(z), to) if target == ZZERO else encode(z, to)
    return (r, g, b, a), negative, pulled


@functools.lru_cache(maxsize=16384)
def unit_level(c, n, to, zzero=False):
    """The level of c/sqrt(n), both integers: round half up."""

    def at_least(edge, over):  # c/sqrt(n) >= edge/over
        if edge <= 0 or c < 0:
            if edge <= 0 <= c:
                return True
            if c < 0 < edge or (c < 0 and edge == 0):
                return False
            return c * c * over * over <= edge * edge * n
        return c * c * over * over >= edge * edge * n

    low, high = 0, to
    while low < high:
        k = (low + high + 1) // 2
        if at_least(2 * k - 1, 2 * to) if zzero else at_least(2 * k - 1 - to, to):
            low = k
        else:
            high = k - 1
    return low


def from_vector(v, to, target, flip=False, nearest=False):
    """Levels (r, g, b) of a float vector; None where it is no direction."""
    if not all(math.isfinite(c) for c in v[:3]) or not any(v[:3]):
        return None
    exact_v = [Fraction(float(c)) for c in v[:3]]
    common = math.lcm(*(c.denominator for c in exact_v))
    x, y, z = (int(c * common) for c in exact_v)
    n = x * x + y * y + z * z
    r, g = unit_level(x, n, to), unit_level(-y if flip else y, n, to)
    z_negative = z < 0
    if target == XY:
        return r, g, to
    if nearest:
        z = abs(z) if target == ZZERO else z
        return r, g, unit_level(z, n, to, target == ZZERO)
    r, g = pull(r, g, to)
    b = derived_blue(r, g, to, target == ZZERO)
    return r, g, to - b if z_negative and target == STANDARD else b
