# SPDX-License-Identifier: MIT
"""ntp_blend by the published formulas, in fractions."""

import itertools
from fractions import Fraction

from . import oracle_vectors as model
from .texels import NAMES

RNM, WHITEOUT, UDN, LINEAR = range(4)


def blended(mode, n1, n2):
    """Barre-Brisebois and Hill's formulas on fractions."""
    if mode == WHITEOUT:
        return n1[0] + n2[0], n1[1] + n2[1], n1[2] * n2[2]
    if mode == UDN:
        return n1[0] + n2[0], n1[1] + n2[1], n1[2]
    if mode == LINEAR:
        return tuple(a + b for a, b in zip(n1, n2))
    t = (n1[0], n1[1], n1[2] + 1)
    u = (-n2[0], -n2[1], n2[2])
    dot = sum(a * b for a, b in zip(t, u))
    return tuple(a * dot - b * t[2] for a, b in zip(t, u))  # times t.z, which is not negative


def blend_by_model(base, detail, mode, strength, encodings, ys, maxima, touch=0, fades=False):
    out = base.copy()
    scale = Fraction(strength)
    names = [NAMES[e] for e in encodings]
    for y, x in itertools.product(range(base.shape[0]), range(base.shape[1])):
        texels = [base[y, x].tolist(), detail[y % detail.shape[0], x % detail.shape[1]].tolist()]
        vectors, keep = [], False
        for texel, m, name in zip(texels, maxima, names):
            alpha = texel[3] if len(texel) == 4 else None
            full = texel if len(texel) > 2 else [*texel, max(texel) and m]
            keep = keep or (model.unused(full, m, alpha) and not touch)
            vectors.append([Fraction(c, m) for c in model.components(texel, m, name)])
        if keep:
            continue
        n1, n2 = vectors
        n2 = [scale * n2[0], scale * n2[1] * (-1 if ys[0] != ys[1] else 1), n2[2]]
        stored_z = n2[2]
        if fades and detail.shape[2] == 4:
            share = Fraction(texels[1][3], maxima[1])
            n2 = [share * c for c in n2]
            n2[2] += (1 - share) if mode != LINEAR else 0
        v = list(blended(mode, n1, n2))
        if n1[2] >= 0 and stored_z >= 0:
            v[2] = max(v[2], 0)
        common = 1
        for c in v:
            common *= c.denominator
        levels = model.encode([int(c * common) for c in v], maxima[0], names[0])
        out[y, x, : len(levels)] = levels
    return out
