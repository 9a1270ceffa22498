# SPDX-License-Identifier: MIT
"""ntp_resize in integers and fractions."""

import math
from fractions import Fraction

from . import libntp_ffi as ntp
from . import oracle_vectors as model

TRIANGLE, BOX, LANCZOS3 = range(3)
WRAP, CLAMP, MIRROR, EXTRAPOLATE = range(4)


def mapped(i, n, border):
    if 0 <= i < n:
        return i
    if border == CLAMP or n == 1:
        return min(max(i, 0), n - 1)
    if border == WRAP:
        return i % n
    j = i % (2 * (n - 1))
    return min(j, 2 * (n - 1) - j)


def weights(j, src, dst, filter, border):
    """{texel of the source: weight} of texel j of the result; the weights add up to 1."""
    scale = Fraction(src, dst)
    out = {}
    if filter == BOX:
        for i in range(src):
            low, high = max(j * scale, Fraction(i)), min((j + 1) * scale, Fraction(i + 1))
            if high > low:
                out[i] = (high - low) / scale
        return out
    unit = max(scale, Fraction(1))
    center = (j + Fraction(1, 2)) * scale
    for i in range(math.floor(center - 3 * unit) - 1, math.ceil(center + 3 * unit) + 2):
        x = abs(i + Fraction(1, 2) - center) / unit
        if filter == TRIANGLE:
            w = max(1 - x, Fraction(0))
        else:
            t = math.pi * float(x)
            w = 1.0 if x == 0 else 3 * math.sin(t) * math.sin(t / 3) / t**2 if x < 3 else 0.0
            w = Fraction(w)
        if w:
            at = mapped(i, src, border)
            out[at] = out.get(at, 0) + w
    total = sum(out.values())
    return {i: w / total for i, w in out.items()}


def texel_of_model(src, m, wx, wy, encoding, touch):
    """One texel of the result as a list of levels, and the filtered vector."""
    data_alpha = touch & ntp.UNUSED_TRANSPARENT
    v, weight, alpha, extra, negative = [0, 0, 0], 0, Fraction(0), 0, False
    for y, b in wy.items():
        for x, a in wx.items():
            texel, w = src[y][x], a * b
            full = texel if encoding != "xy" or len(texel) > 2 else [*texel, max(texel) and m]
            own = texel[3] if len(texel) == 4 else m
            alpha += w * own
            if model.unused(full, m, None if data_alpha else own):
                continue
            w *= 1 if data_alpha else own
            v_texel = model.components(texel, m, encoding)
            v = [s + w * c for s, c in zip(v, v_texel)]
            weight += w
            negative |= v_texel[2] < 0
            extra += w * full[2]
    none = weight <= 0
    if not negative:  # an overshoot
        v[2] = max(v[2], 0)
    common = math.lcm(*(Fraction(c).denominator for c in v))
    v = [0, 0, 0] if none else [int(c * common) for c in v]
    out = list(model.encode(v, m, encoding))
    if encoding == "xy" and len(src[0][0]) > 2:
        out.append(m if none else min(max(model.half_up(extra / weight), 0), m))
    if len(src[0][0]) == 4:
        clear = none and not data_alpha
        out.append(0 if clear else min(max(model.half_up(alpha), 0), m))
    return out, v


def resize_by_model(src, m, size, filter, borders, encoding, touch=0):
    h, w = len(src), len(src[0])
    columns = [weights(j, w, size[0], filter, borders[0]) for j in range(size[0])]
    rows = [weights(j, h, size[1], filter, borders[1]) for j in range(size[1])]
    return [[texel_of_model(src, m, wx, wy, encoding, touch) for wx in columns] for wy in rows]
