# SPDX-License-Identifier: MIT
"""Heatmap, shaded plane and comparison, written apart from the C code.

The heatmap's model finds lengths by searching a table of squares, the shaded plane's follows
the formula in libntp.h in numpy's doubles, the comparison's converts texel by texel with
oracle_convert and takes angles from numpy's arctan2.
"""

import functools

import numpy as np

from . import libntp_ffi as ntp
from . import oracle, oracle_convert

SAFE = {"z": (240, 228, 66), "xy": (213, 94, 0), "length": (86, 180, 233)}
SQUARES = np.arange(120_000, dtype=np.int64) ** 2


def root(squares, m):
    """floor(sqrt()) by search in the table of squares; no length is above 2m."""
    return np.searchsorted(SQUARES[: 2 * m], squares, side="right") - 1


@functools.lru_cache(maxsize=2)  # many blues are looked at with the same red and green
def of_red_and_green(data, m):
    """(red of the picture, the square of x and y pulled onto the disc); data: r and g as bytes."""
    r, g = np.frombuffer(data, np.int64).reshape(2, -1)
    n = (2 * r - m) ** 2 + (2 * g - m) ** 2
    # never a square, so that floor(L) >= k says L > k
    red = np.where(root(n, m) >= m + 2, 255, np.where(root(n, m) >= m, 128, 0))
    r, g = oracle.pulled(r, g, m)
    return red, (2 * r - m) ** 2 + (2 * g - m) ** 2


def expected_heatmap(texels, m, encoding, palette=0, touch=0):
    """(..., 3) of the picture; texels (..., c) of integers."""
    texels = np.asarray(texels, np.int64)
    r, g = texels[..., 0], texels[..., 1]
    b = texels[..., 2] if texels.shape[-1] > 2 else np.full_like(r, m)
    used = ~oracle.unused(texels, m, touch)
    parts = of_red_and_green(np.stack([r, g]).tobytes(), m)
    red, pulled = (part.reshape(r.shape) for part in parts)
    green = np.zeros_like(red)
    blue = np.zeros_like(red)
    if encoding != ntp.XY:
        z = b if encoding == ntp.ZZERO else 2 * b - m
        length2 = pulled + z * z
        long_by = root(length2, m) - m
        short_by = m - root(length2 - 1, m) - 1  # ceil(L) = floor(sqrt(L2 - 1)) + 1
        off = np.maximum(long_by, short_by)
        green = np.where(off >= 6, 255, np.where(off >= 4, 128, 0))
        if encoding != ntp.ZZERO:
            below = (m - 1) // 2
            blue = np.where(b <= below, np.floor((m - b) / (m / 255) + 0.5), 0).astype(np.int64)
    faults = np.stack([red, green, blue], -1) * used[..., None]
    flagged = faults.any(-1)
    luma = np.floor((2126 * r + 7152 * g + 722 * b) / (10_000 * (m // 255)) + 0.5).astype(int)
    gray = np.repeat((100 + luma // 2)[..., None], 3, -1)
    if palette == 0:
        return np.where(flagged[..., None], faults, gray)
    out = gray
    for name, channel in (("length", 1), ("xy", 0), ("z", 2)):  # the last one wins
        strength = faults[..., channel : channel + 1]
        color = np.floor(np.array(SAFE[name]) * strength / 255 + 0.5).astype(int)
        out = np.where(strength > 0, color, out)
    return out


DEFAULT_LIGHT = ([-1.0, 1.0, 1.2], 0.1, 0.9, 0.2, [0.6, 0.6, 0.6])


def unit(v):
    x, y, z = v
    length = np.sqrt(x * x + y * y + z * z)
    return [x / length, y / length, z / length]


def expected_shade(texels, m, encoding, light=DEFAULT_LIGHT, down=False, channels=3):
    texels = np.asarray(texels, np.int64)
    direction, ambient, diffuse, specular, color = light
    v = [(2 * texels[..., 0] - m).astype(float), (2 * texels[..., 1] - m).astype(float)]
    if down:
        v[1] = -v[1]
    if encoding == ntp.XY:
        v.append(np.sqrt(np.maximum(oracle.radicands(texels[..., 0], texels[..., 1], m), 0)))
    else:
        v.append((texels[..., 2] if encoding == ntp.ZZERO else 2 * texels[..., 2] - m) * 1.0)
    n = unit(v)
    greatest = max(abs(d) for d in direction)
    to_light = unit([d / greatest for d in direction])
    half = unit([to_light[0], to_light[1], to_light[2] + 1.0])
    lambert = n[0] * to_light[0] + n[1] * to_light[1] + n[2] * to_light[2]
    glint = np.maximum(n[0] * half[0] + n[1] * half[1] + n[2] * half[2], 0.0)
    for _ in range(5):
        glint = glint * glint
    glint = np.where(lambert > 0, glint, 0.0)
    lambert = np.maximum(lambert, 0.0)
    linear = [c * (ambient + diffuse * lambert) + specular * glint for c in color]
    if channels == 1:
        linear = [0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]]
    out = np.stack([np.floor(np.sqrt(np.minimum(c, 1.0)) * 255.0 + 0.5) for c in linear], -1)
    row, column = np.indices(texels.shape[:2])
    checker = np.where((row // 8 + column // 8) % 2 == 0, 88, 72)[..., None]
    return np.where(oracle.unused(texels, m)[..., None], checker, out).astype(np.uint8)


def decode(texels, m, encoding):
    t = np.asarray(texels, np.int64)
    x, y = 2 * t[..., 0] - m, 2 * t[..., 1] - m
    if encoding == ntp.XY:
        z = 2 * oracle.derived_blues(t[..., 0], t[..., 1], m) - m
        z = np.where(oracle.radicands(t[..., 0], t[..., 1], m) < 0, 0, z)
    else:
        z = t[..., 2] if encoding == ntp.ZZERO else 2 * t[..., 2] - m
    return np.stack([x, y, z], -1) / m


def expected_compare(a, b, ms, encodings, flip):
    """(|differences| in levels, degrees, channels)."""
    m = max(ms)
    both_unused = oracle.unused(a, ms[0]) & oracle.unused(b, ms[1])
    flipped = b.astype(np.int64)
    if flip:
        keep = oracle.unused(b, ms[1])
        flipped[..., 1] = np.where(keep, flipped[..., 1], ms[1] - flipped[..., 1])
    u, v = decode(a, ms[0], encodings[0]), decode(flipped, ms[1], encodings[1])
    cross = np.linalg.norm(np.cross(u, v), axis=-1)
    degrees = np.degrees(np.arctan2(cross, (u * v).sum(-1)))
    degrees[both_unused] = 0
    channels = min(a.shape[-1], b.shape[-1])
    if (encodings[0] == ntp.XY) != (encodings[1] == ntp.XY):
        channels = 2
    elif encodings[0] != encodings[1]:
        flat = [tuple(map(int, t)) for t in b.reshape(-1, b.shape[-1])]
        to = [
            oracle_convert.convert(t, ms[1], encodings[1], ms[1], encodings[0], len(t), flip)[0]
            for t in flat
        ]
        flipped = np.array(to).reshape(b.shape)
    left = a.astype(np.int64) * (m // ms[0])
    right = flipped * (m // ms[1])
    return np.abs(left[..., :channels] - right[..., :channels]), degrees, channels


def expected_heat(degrees, equal):
    step = np.floor(np.minimum(np.round(degrees * 1e6), 10e6) * 51 / 1e6 + 0.5).astype(int)
    low = np.stack([0 * step, step, 255 - step], -1)
    high = np.stack([step - 255, 510 - step, 0 * step], -1)
    heat = np.where((step <= 255)[..., None], low, high)
    return np.where((equal & (degrees < 5e-7))[..., None], 0, heat)


def nearly(texels, m, seed):
    """The same texels, some off by a few levels."""
    rng = np.random.default_rng(seed)
    off = rng.choice([0, 0, 0, 1, -3, 40], texels.shape) * (m // 255)
    return np.clip(texels + off, 0, m)
