# SPDX-License-Identifier: MIT
"""Do slopes of a damaged texture lie between texels?  The library beside the same in numpy."""

from collections import Counter

import numpy as np

from support import maps
from support.find import find_kernel
from support.oracle_height import NAMES

FORWARD = NAMES.index("forward")
POINTS, CELL, MOST, REACH, EDGE = 32, 8, 8, 4, 6


def surface(n, seed, exponent):
    rng = np.random.default_rng(seed)
    f = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.fftfreq(n)[None])
    f[0, 0] = np.inf
    return np.fft.fft2(rng.standard_normal((n, n))) / f**exponent


def shifted(spectrum, part, slope=0.6):
    """8-bit normals: slopes right lie a part of a texel further to the right, slopes down below."""
    n = len(spectrum)
    wave = 2 * np.pi * np.fft.fftfreq(n)
    wave[n // 2] = 0
    x, y = wave[None], wave[:, None]
    p = np.fft.ifft2(spectrum * 1j * x * np.exp(1j * part * x)).real
    q = np.fft.ifft2(spectrum * 1j * y * np.exp(1j * part * y)).real
    scale = slope / np.sqrt(np.mean(p * p + q * q))
    v = np.stack([-p * scale, q * scale, np.ones_like(p)], -1)
    return maps.encode(v / np.linalg.norm(v, axis=-1, keepdims=True))


def noisy(n, sigma, seed=1):
    added = np.random.default_rng(seed).normal(0, sigma, n.shape)
    return np.clip(n + added, 0, 255).round().astype(np.uint8)


# ------------------------------------------------------------------------- the same in numpy


def starts(length):
    room = length - 2 * EDGE - POINTS
    count = min(room // POINTS + 1, MOST)
    return [EDGE + room * i // max(count - 1, 1) for i in range(count)]


def filtered(a, taps, axis):
    count = a.shape[axis] - len(taps) + 1
    return sum(tap * a.take(range(k, k + count), axis) for k, tap in enumerate(taps))


BINOMIAL = np.array([1, 4, 6, 4, 1]) / 16
STEEP = np.convolve(BINOMIAL, [1, 0, -1])[::-1] / 2


def tallies(n):
    """Of all cells: how far products are ahead, how much the middle is above both, the squares."""
    x, y = (2.0 * n[..., k] - 255 for k in (0, 1))
    z = np.sqrt(np.maximum(65025 - x * x - y * y, 650.25))
    found = []
    for j in starts(n.shape[0]):
        for i in starts(n.shape[1]):
            part = np.s_[j - REACH : j + POINTS + REACH, i - REACH : i + POINTS + REACH]
            p, q = -(x / z)[part], (y / z)[part]
            u = filtered(filtered(p, STEEP, 0), BINOMIAL, 1)[:, 1:-1]
            v = filtered(filtered(q, BINOMIAL, 0), STEEP, 1)[1:-1]
            inner, below = np.s_[1:-1, 1:-1], np.s_[2:, :-2]
            ahead, behind = u[below] * v[inner], u[inner] * v[below]
            each = [
                ahead - behind,
                2 * u[inner] * v[inner] - ahead - behind,
                (u[inner] ** 2 + v[inner] ** 2) / 2,
            ]
            shape = (POINTS // CELL, CELL, POINTS // CELL, CELL)
            found.append([e.reshape(shape).sum((1, 3)).ravel() for e in each])
    return np.concatenate(found, 1)


def judged(n):
    """How much of the way the top is off, and how sure that is, in standard errors."""
    ahead, middle, square = tallies(n)
    weight = 1 / (square + square.mean() / 2)
    top, curve = (weight * ahead).sum(), (weight * middle).sum()
    where = top / curve if curve > 0 else np.copysign(np.inf, top)
    return where, top / np.sqrt(((weight * ahead) ** 2).sum())


def examples():
    rng = np.random.default_rng(7)
    for case in range(140):
        size, exponent = (150, 140, 200, 107)[case % 4], (2.4, 2.4, 3.2, 1.6, 5)[case % 5]
        part, sigma = 0.5, {1.6: 4, 2.4: rng.choice([24, 48]), 3.2: 12, 5: 48}[exponent]
        if exponent == 1.6:
            part, sigma = (rng.uniform(0.23, 0.265), 4) if case % 3 else (1.7, rng.uniform(10, 110))
        n = noisy(shifted(surface(size, case, exponent), part), sigma, case)[:, : size - case % 5]
        n[..., 2] = 200  # neither black nor white, which would be no normals
        yield np.ascontiguousarray(n)


def test_as_numpy_says():
    """Maps near the limits; each of them decides some."""
    seen = Counter()
    for n in examples():
        where, sure = judged(n)
        found = find_kernel(n)
        limits = np.array([where / 0.4, where / 5, sure / 2.5, sure / 6])
        if (np.abs(limits - 1) < 1e-3).any() or found["points"] < 200:
            continue
        why = "far" if where > 5 else "near" if where > 0.4 else "at texels"
        why += ", sure" if sure > 6 else ", likely" if sure > 2.5 else ""
        if len(starts(n.shape[0])) * len(starts(n.shape[1])) < 8:
            why = "too small"
        yes = why in ("near, sure", "near, likely", "far, sure")
        assert not found["decided"]
        assert (found["kernel"] == FORWARD) == yes, (why, where, sure, found)
        seen[why] += 1
    for why in ("near, likely", "far, sure", "near", "far, likely", "at texels, sure", "too small"):
        assert seen[why] > 1, seen
