# SPDX-License-Identifier: MIT
"""What the models of resize, transform and blend share: integers and fractions only.

A texel is a list of levels.  A vector is three integers of any size over a common denominator,
which a direction does not depend on.
"""

import math

from . import oracle


def components(texel, m, encoding):
    """The vector that a texel holds; encoding is "standard", "zzero" or "xy"."""
    r, g = texel[:2]
    if encoding == "xy":
        r, g = oracle.pull(r, g, m)
        return 2 * r - m, 2 * g - m, 2 * oracle.derived_blue(r, g, m) - m
    b = texel[2]
    return 2 * r - m, 2 * g - m, b if encoding == "zzero" else 2 * b - m


def unused(texel, m, alpha=None):
    """Black, white or transparent."""
    return set(texel[:3]) in ({0}, {m}) or alpha == 0


def level_of_quotient(v, length2, m):
    """The level of v / sqrt(length2): the greatest c with (c - 1/2)/M <= (v/L + 1)/2."""
    # 2c - 1 - M <= M v / L
    low, high = 0, m
    while low < high:
        c = (low + high + 1) // 2
        k = 2 * c - 1 - m
        left, right = (abs(k) * k) * length2, m * m * abs(v) * v
        if left <= right:
            low = c
        else:
            high = c - 1
    return low


def encode(v, m, encoding):
    """The levels of the direction of v: r, g rounded and pulled, b derived, z's sign kept."""
    length2 = sum(c * c for c in v)
    if length2 == 0:
        r = g = (m + 1) // 2
    else:
        r, g = (level_of_quotient(c, length2, m) for c in v[:2])
    r, g = oracle.pull(r, g, m)
    if encoding == "xy":
        return r, g
    b = oracle.derived_blue(r, g, m, encoding == "zzero")
    return r, g, m - b if v[2] < 0 and encoding == "standard" else b


def half_up(fraction):
    return math.floor(fraction + type(fraction)(1, 2))
