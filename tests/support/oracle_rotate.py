# SPDX-License-Identifier: MIT
"""ntp_transform by angles that are no multiple of 90 degrees, in integers and fractions."""

import math
from decimal import Decimal, localcontext
from fractions import Fraction

from . import libntp_ffi as ntp
from . import oracle_vectors as model
from .oracle_resize import mapped

UNIT = 2**30
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459")


def cosine_and_sine(degrees):
    """In units of 2^-30, rounded, of an angle rounded to 2^-32 degrees: a plain Taylor series."""
    with localcontext() as context:
        context.prec = 60
        ticks = model.half_up(Fraction(degrees) * 2**32)
        x = Decimal(ticks) / 2**32 * PI / 180
        term, sums = Decimal(1), [Decimal(0), Decimal(0)]
        for k in range(80):
            sums[k % 2] += term if k % 4 < 2 else -term
            term = term * x / (k + 1)
        return tuple(math.floor(v * UNIT + Decimal("0.5")) for v in sums)


def rotated(src, degrees, m, encoding, y_axis=ntp.UP, flips=(0, 0), borders=(0, 0), strength=1,
            touch=0):  # fmt: skip
    """The texture as nested lists; src too."""
    cosine, sine = (Fraction(v, UNIT) for v in cosine_and_sine(degrees))
    height, width = len(src), len(src[0])
    out = []
    for y in range(height):
        row = []
        for x in range(width):
            u, v = x + Fraction(1 - width, 2), y + Fraction(1 - height, 2)
            place = [cosine * u + sine * v, cosine * v - sine * u]
            place = [-p if f else p for p, f in zip(place, flips, strict=True)]
            place = [p + Fraction(n - 1, 2) for p, n in zip(place, (width, height), strict=True)]
            place = [Fraction(model.half_up(p * 2**15), 2**15) for p in place]
            row.append(texel(src, place, (cosine, sine), m, encoding, y_axis, flips, borders,
                             strength, touch))  # fmt: skip
        out.append(row)
    return out


def texel(src, place, turn, m, encoding, y_axis, flips, borders, strength, touch):
    first = [math.floor(p) for p in place]
    sums, weight, alpha, extra = [Fraction(0)] * 3, Fraction(0), Fraction(0), Fraction(0)
    for i in (0, 1):
        for j in (0, 1):
            x = mapped(first[0] + i, len(src[0]), borders[0])
            y = mapped(first[1] + j, len(src), borders[1])
            w = (1 - abs(place[0] - first[0] - i)) * (1 - abs(place[1] - first[1] - j))
            one = src[y][x]
            full = one if len(one) > 2 else [*one, m if max(one) else 0]
            own = one[3] if len(one) == 4 else m
            alpha += w * own
            color = set(full[:3])
            if (color == {0} and not touch & ntp.UNUSED_BLACK) or (
                color == {m} and not touch & ntp.UNUSED_WHITE
            ):
                continue
            if len(one) == 4 and not touch & ntp.UNUSED_TRANSPARENT:
                w *= own
            vector = model.components(full, m, encoding)
            signs = (-1 if flips[0] else 1, -1 if flips[1] else 1, 1)
            sums = [a + w * c * s for a, c, s in zip(sums, vector, signs, strict=True)]
            weight += w
            extra += w * full[2]
    cosine, sine = turn
    sine = sine if y_axis == ntp.UP else -sine  # clockwise in the picture
    v = (cosine * sums[0] + sine * sums[1], cosine * sums[1] - sine * sums[0], sums[2])
    v = (v[0] * strength, v[1] * strength, v[2])
    common = math.lcm(*(Fraction(c).denominator for c in v))
    levels = list(model.encode([int(c * common) for c in v], m, encoding))
    if encoding == "xy" and len(src[0][0]) > 2:
        levels.append(model.half_up(extra / weight) if weight else m)
    if len(src[0][0]) == 4:
        clear = weight == 0 and not touch & ntp.UNUSED_TRANSPARENT
        levels.append(0 if clear else model.half_up(alpha))
    return levels
