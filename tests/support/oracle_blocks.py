# SPDX-License-Identifier: MIT
"""Block compression by Python's integers: BC1 to BC5 and BC7, as their specifications state them.

A block is 16 (BC1, BC4: 8) bytes.  Each function returns 16 texels, rows from the top.
"""

from fractions import Fraction
from math import floor


def rounded(value):
    """Half up."""
    return floor(value + Fraction(1, 2))


def _colors(block, opaque):
    number = int.from_bytes(block, "little")
    first, second = number & 0xFFFF, number >> 16 & 0xFFFF
    ends = [(n >> 11, n >> 5 & 63, n & 31) for n in (first, second)]
    tops = (31, 63, 31)
    thirds = [Fraction(0), Fraction(1), Fraction(1, 3), Fraction(2, 3)]
    three = first <= second and not opaque
    if three:
        thirds[2] = Fraction(1, 2)
    palette = [
        tuple(rounded(255 * (a + (b - a) * t) / top) for a, b, top in zip(*ends, tops, strict=True))
        + (255,)
        for t in thirds
    ]
    if three:
        palette[3] = (0, 0, 0, 0)
    return [palette[number >> 32 + 2 * i & 3] for i in range(16)]


def bc1(block):
    return _colors(block, False)


def bc2(block):
    alpha = int.from_bytes(block[:8], "little")
    colors = _colors(block[8:], True)
    return [(*c[:3], 17 * (alpha >> 4 * i & 15)) for i, c in enumerate(colors)]


def _line(a, b, low, high, eight):
    """The eight values between two ends, as fractions."""
    n = 7 if eight else 5
    values = [a, b] + [Fraction(a * (n - k) + b * k, n) for k in range(1, n)]
    return values if eight else [*values, low, high]


def _chosen(block, palette):
    indices = int.from_bytes(block[2:8], "little")
    return [palette[indices >> 3 * i & 7] for i in range(16)]


def bc3(block):
    palette = [rounded(v) for v in _line(block[0], block[1], 0, 255, block[0] > block[1])]
    colors = _colors(block[8:], True)
    return [(*c[:3], a) for c, a in zip(colors, _chosen(block, palette), strict=True)]


def bc4(block):
    """16 bit."""
    values = _line(block[0], block[1], 0, 255, block[0] > block[1])
    return _chosen(block, [rounded(Fraction(v) * 257) for v in values])


def bc4_signed(block):
    """16 bit; -1..1 becomes 0..65535."""
    raw = [b - 256 if b > 127 else b for b in block[:2]]
    ends = [max(v, -127) for v in raw]
    values = _line(*ends, -127, 127, raw[0] > raw[1])
    return _chosen(block, [rounded((Fraction(v, 127) + 1) / 2 * 65535) for v in values])


def bc5(block):
    return list(zip(bc4(block[:8]), bc4(block[8:]), strict=True))


def bc5_signed(block):
    return list(zip(bc4_signed(block[:8]), bc4_signed(block[8:]), strict=True))


# --------------------------------------------------------------------------- BC7

# subsets, bits of: partition, rotation, selector, color, alpha, p of each end, p of a subset,
# index, second index
_MODES = (
    (3, 4, 0, 0, 4, 0, 1, 0, 3, 0),
    (2, 6, 0, 0, 6, 0, 0, 1, 3, 0),
    (3, 6, 0, 0, 5, 0, 0, 0, 2, 0),
    (2, 6, 0, 0, 7, 0, 1, 0, 2, 0),
    (1, 0, 2, 1, 5, 6, 0, 0, 2, 3),
    (1, 0, 2, 0, 7, 8, 0, 0, 2, 2),
    (1, 0, 0, 0, 7, 7, 1, 0, 4, 0),
    (2, 6, 0, 0, 5, 5, 1, 0, 2, 0),
)
# A digit for the subset of each texel: partitions 0 to 15 of two subsets (modes 1, 3, 7) and of
# three (modes 0, 2).
_TWO = (
    "0011001100110011",
    "0001000100010001",
    "0111011101110111",
    "0001001100110111",
    "0000000100010011",
    "0011011101111111",
    "0001001101111111",
    "0000000100110111",
    "0000000000010011",
    "0011011111111111",
    "0000000101111111",
    "0000000000010111",
    "0001011111111111",
    "0000000011111111",
    "0000111111111111",
    "0000000000001111",
)
_THREE = (
    "0011001102212222",
    "0001001122112221",
    "0000200122112211",
    "0222002200110111",
    "0000000011221122",
    "0011001100220022",
    "0022002211111111",
    "0011001122112211",
    "0000000011112222",
    "0000111111112222",
    "0000111122222222",
    "0012001200120012",
    "0112011201120112",
    "0122012201220122",
    "0011011211221222",
    "0011200122002220",
)
_SECOND_OF_TWO = (15,) * 16
_SECOND_OF_THREE = (3, 3, 15, 15, 8, 3, 15, 15, 8, 8, 6, 6, 6, 5, 3, 3)
_THIRD_OF_THREE = (15, 8, 8, 3, 15, 15, 3, 8, 15, 15, 15, 15, 15, 15, 15, 8)
_WEIGHTS = {n: [(64 * i + (2**n - 1) // 2) // (2**n - 1) for i in range(2**n)] for n in (2, 3, 4)}


def bc7(block):
    """None for a partition above 15, whose table is not repeated here."""
    number = int.from_bytes(block, "little")
    at = 0

    def take(count):
        nonlocal at
        at += count
        return number >> at - count & ((1 << count) - 1)

    mode = next((m for m in range(8) if block[0] >> m & 1), None)
    if mode is None:
        return [(0, 0, 0, 0)] * 16
    take(mode + 1)
    subsets, *bits, color, alpha, own, shared, first, second = _MODES[mode]
    partition, rotation, selector = (take(n) for n in bits)
    if partition > 15:
        return None
    ends = [[take(n) for _ in range(2 * subsets)] for n in (color,) * 3 + (alpha,)]
    if own or shared:
        p = [take(1) for _ in range(2 * subsets if own else subsets)]
        p = p if own else [bit for bit in p for _ in range(2)]
        ends = [[v << 1 | b for v, b in zip(row, p, strict=True)] for row in ends]
    wide = []
    for row, n in zip(ends, (color,) * 3 + (alpha,), strict=True):
        n += bool(own or shared)
        wide.append([v << 8 - n | v << 8 - n >> n for v in row])
    if not alpha:
        wide[3] = [255] * (2 * subsets)
    table = {1: ["0" * 16] * 16, 2: _TWO, 3: _THREE}[subsets][partition]
    anchors = {0}
    if subsets == 2:
        anchors.add(_SECOND_OF_TWO[partition])
    if subsets == 3:
        anchors |= {_SECOND_OF_THREE[partition], _THIRD_OF_THREE[partition]}
    one = [_WEIGHTS[first][take(first - (i in anchors))] for i in range(16)]
    two = [_WEIGHTS[second][take(second - (i in anchors))] for i in range(16)] if second else one
    if selector:
        one, two = two, one
    texels = []
    for i in range(16):
        subset = int(table[i])
        texel = [
            ((64 - w) * row[2 * subset] + w * row[2 * subset + 1] + 32) // 64
            for row, w in zip(wide, (one[i],) * 3 + (two[i],), strict=True)
        ]
        if rotation:
            texel[3], texel[rotation - 1] = texel[rotation - 1], texel[3]
        texels.append(tuple(texel))
    return texels
