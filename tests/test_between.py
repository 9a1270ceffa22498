# SPDX-License-Identifier: MIT
"""Do slopes of a damaged texture lie between texels?  The library beside the same in numpy."""

from collections import Counter

import numpy as np

from support import maps
from support.find import find_kernel
from support.oracle_height import NAMES

FORWARD = NAMES.index("forward")
POINTS, CELL, MOST, REACH, BORDER = 32, 8, 8, 4, 2


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


def starts(length, step=1):
    room = length - 2 * BORDER - (POINTS + 2 * REACH) * step
    count = min(room // (POINTS * step) + 1, MOST)
    return [BORDER + room * i // max(count - 1, 1) for i in range(count)]


def filtered(a, taps, axis):
    count = a.shape[axis] - len(taps) + 1
    return sum(tap * a.take(range(k, k + count), axis) for k, tap in enumerate(taps))


BINOMIAL = np.array([1, 4, 6, 4, 1]) / 16
STEEP = np.convolve(BINOMIAL, [1, 0, -1])[::-1] / 2


def tallies(n, step):
    """Of all cells: what u - v has in common with their rise, which both have; neighbors, the squares."""
    x, y = (2.0 * n[..., k] - 255 for k in (0, 1))
    z = np.sqrt(np.maximum(65025 - x * x - y * y, 650.25))
    found = []
    side = POINTS + 2 * REACH
    for j in starts(n.shape[0], step):
        for i in starts(n.shape[1], step):
            part = np.s_[j : j + side * step, i : i + side * step]
            p, q = (a[part].reshape(side, step, side, step).mean((1, 3)) for a in (-(x / z), y / z))
            u = filtered(filtered(p, STEEP, 0), BINOMIAL, 1)[:, 1:-1]
            v = filtered(filtered(q, BINOMIAL, 0), STEEP, 1)[1:-1]
            inner, below, above = np.s_[1:-1, 1:-1], np.s_[2:, :-2], np.s_[:-2, 2:]
            rise_u, rise_v = (a[above] - a[below] for a in (u, v))
            each = [
                2 * (u - v)[inner] * (rise_u + rise_v),
                rise_u * rise_v,
                (u[below] * v[inner] + u[inner] * v[below]) / 2,
                (u[inner] ** 2 + v[inner] ** 2) / 2,
            ]
            shape = (POINTS // CELL, CELL, POINTS // CELL, CELL)
            found.append([e.reshape(shape).sum((1, 3)).ravel() for e in each])
    return np.concatenate(found, 1)


def too_small(n, step):
    return not all(starts(side, step) for side in n.shape[:2])


def judged(n, step=1):
    """How much of the way they are off, how sure that is, in standard errors, how smooth it is."""
    if too_small(n, step):
        return np.nan, np.nan, np.nan
    ahead, rise, both, square = tallies(n, step)
    weight = 1 / (square + square.mean() / 2)
    top, curve = (weight * ahead).sum(), (weight * rise).sum()
    where = step * top / curve
    alike = (weight * both).sum() / (weight * square).sum()
    return where, top / np.sqrt(((weight * ahead) ** 2).sum()), alike


def examples():
    rng = np.random.default_rng(7)
    for case in range(140):
        size, exponent = (150, 60, 200, 46)[case % 4], (2.4, 2.4, 3.2, 1.6, 5)[case % 5]
        part, sigma = 0.5, {1.6: 4, 2.4: rng.choice([24, 48]), 3.2: 12, 5: 48}[exponent]
        if exponent == 1.6:
            part, sigma = (rng.uniform(0.23, 0.265), 4) if case % 3 else (1.7, rng.uniform(10, 110))
        n = noisy(shifted(surface(size, case, exponent), part), sigma, case)[:, : size - case % 5]
        n[..., 2] = 200  # neither black nor white, which would be no normals
        yield np.ascontiguousarray(n)


def near_a_limit(where, sure, *rest):
    return (np.abs([where / 0.4 - 1, where / 5 - 1, sure / 2.5 - 1, *rest]) < 1e-3).any()


def answer(n, step=1):
    if too_small(n, step):
        return "too small"
    where, sure, _ = judged(n, step)
    why = "far" if not -5 < where < 5 else "near" if where > 0.4 else "at texels"
    return why + (", likely" if sure > 2.5 else "")


YES = ("near, likely",)


def test_as_numpy_says():
    """Maps near the limits; each of them decides some."""
    seen = Counter()
    for n in examples():
        where, sure, _ = judged(n)
        found = find_kernel(n)
        if near_a_limit(where, sure) or found["points"] < 200:
            continue
        why = answer(n)
        assert not found["decided"]
        assert (found["kernel"] == FORWARD) == (why in YES), (why, where, sure, found)
        seen[why] += 1
    for why in ("near, likely", "near", "far, likely", "far", "at texels, likely", "too small"):
        assert seen[why] > 1, seen


def waves(n, seed, most):
    """A spectrum of a few waves; most: cycles along an axis."""
    rng = np.random.default_rng(seed)
    spectrum = np.zeros((n, n), complex)
    for a, b in rng.integers(-most, most + 1, (12, 2)):
        spectrum[a, b] += rng.normal() * np.exp(1j * rng.uniform(0, 7)) / (1 + np.hypot(a, b))
    return (spectrum + np.conj(np.roll(spectrum[::-1, ::-1], 1, (0, 1)))) * n * n


def smooth_examples():
    rng = np.random.default_rng(8)
    for case in range(150):
        size = (240, 262, 232, 240, 110, 246, 234, 87)[case % 8]
        most = (4, 6, 10, 20)[case // 8 % 4]
        part = (0.5, 0.5, 0.25, 0.15, 0)[case % 5]
        n = noisy(
            shifted(waves(512, case, most), part), rng.uniform(2, 14) * (1 + case % 3 * 2), case
        )
        n = n[:size, : size - case % 5]
        n[..., 2] = 200
        yield np.ascontiguousarray(n)


def test_smooth_ground():
    """Where texels do not tell, means of 2 x 2 do, if neighbors are alike."""
    seen = Counter()
    for n in smooth_examples():
        found = find_kernel(n)
        where, sure, alike = judged(n, 2)
        close = near_a_limit(*judged(n)[:2]) or near_a_limit(where, sure, alike / 0.875 - 1)
        if close or found["decided"] or found["points"] < 200 or answer(n) in YES:
            continue
        why = answer(n, 2)
        if why != "too small":
            why += ", smooth" if alike > 0.875 else ", rough"
        yes = why in [f"{a}, smooth" for a in YES]
        assert (found["kernel"] == FORWARD) == yes, (why, where, sure, alike, found)
        seen[why] += 1
    for why in ("near, likely", "near", "at texels"):
        assert seen[f"{why}, smooth"] > 1, seen
    assert seen["near, likely, rough"] > 1, seen
    assert seen["too small"] > 1, seen
