# SPDX-License-Identifier: MIT
"""The test oracle for conversions: one texel at a time, in integers and fractions.

A texel is a tuple of levels, (r, g), (r, g, b) or (r, g, b, a); vectors are tuples of floats.
Encodings are the numbers of libntp.h.
"""

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
    blue_in = texel[2] if len(texel) > 2 else m * any(texel)  # black stays black
    alpha = texel[3] if len(texel) > 3 else m
    r, g = deepen(texel[0], m, to), deepen(texel[1], m, to)
    a = deepen(alpha, m, to)
    if is_unused(texel, m) and not touch:
        return (r, g, deepen(blue_in, m, to), a)[:channels], False, False
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
    if flip:
        g = to - g
    return (r, g, b, a)[:channels], negative, pulled


def unit_level(v, i, to, zzero=False):
    """The level of v[i]/|v|, v exact rationals: round half up."""
    n = sum(c * c for c in v)

    def at_least(edge):  # v[i]/|v| >= edge
        if edge <= 0 or v[i] < 0:
            if edge <= 0 <= v[i]:
                return True
            if v[i] < 0 < edge or (v[i] < 0 and edge == 0):
                return False
            return v[i] * v[i] <= edge * edge * n
        return v[i] * v[i] >= edge * edge * n

    low, high = 0, to
    while low < high:
        k = (low + high + 1) // 2
        edge = Fraction(2 * k - 1, 2 * to) if zzero else Fraction(2 * k - 1 - to, to)
        if at_least(edge):
            low = k
        else:
            high = k - 1
    return low


def from_vector(v, to, target, flip=False, nearest=False):
    """Levels (r, g, b) of a float vector; None where it is no direction."""
    if not all(math.isfinite(c) for c in v[:3]) or not any(v[:3]):
        return None
    exact_v = [Fraction(float(c)) for c in v[:3]]
    if flip:
        exact_v[1] = -exact_v[1]
    r, g = unit_level(exact_v, 0, to), unit_level(exact_v, 1, to)
    z_negative = exact_v[2] < 0
    if target == XY:
        return r, g, to
    if nearest:
        exact_v[2] = abs(exact_v[2]) if target == ZZERO else exact_v[2]
        return r, g, unit_level(exact_v, 2, to, target == ZZERO)
    r, g = pull(r, g, to)
    b = derived_blue(r, g, to, target == ZZERO)
    return r, g, to - b if z_negative and target == STANDARD else b
