# SPDX-License-Identifier: MIT
"""Edges that are level only by a mirror: no surface was sampled, and no other border is tried."""

from collections import Counter

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import to_height as reconstruction
from support.drawn_maps import by_blocks
from support.encoders import jpeg
from support.find import find_borders, find_kernel
from support.oracle_height import CLAMP, MIRROR, NAMES, WRAP

BAKED, CENTRAL = len(NAMES), NAMES.index("central")


def noisy(n, sigma=4, seed=1):
    added = np.random.default_rng(seed).normal(0, sigma, n.shape)
    return np.clip(n + added, 0, 255).round().astype(np.uint8)


DAMAGES = [noisy, by_blocks, lambda n: jpeg(n, 95, 0), lambda n: jpeg(n, 85, 0)]


def sampled(h):
    """Normals of the surface through the heights of a tile that has no finer detail."""
    y, x = (2 * np.pi * f for f in np.ix_(np.fft.fftfreq(len(h)), np.fft.fftfreq(h.shape[1])))
    spectrum = np.fft.fft2(h)
    p, q = (np.fft.ifft2(1j * f * spectrum).real for f in (x, y))
    v = np.stack([-p, q, np.ones_like(p)], -1)
    return ((v / np.linalg.norm(v, axis=-1, keepdims=True) + 1) * 127.5 + 0.5).astype(np.uint8)


def is_level(n, down):
    """In levels.  An edge is level by less than damage makes it, and not the texels beside it."""
    v = n.astype(float) - 127.5
    v = v.swapaxes(0, 1) if down else v
    sides = []
    for lines in (v, v[:, ::-1]):
        middle = max(len(lines) - 1024, 0) // 2
        lines = lines[middle : middle + 1024, :3]
        here, beside, inside = lines[..., 1 if down else 0].T
        damage = ((lines[:, 0] ** 2).sum(-1) / 127.5 - 127.5) / 2
        expected = min(np.mean((2 * beside - inside) ** 2), 4 * np.mean(beside**2))
        off = np.mean(here**2)
        sides.append(expected > 8 * off and off < 4 * (np.mean(damage**2) + 0.5))
    return all(sides)


def as_inside(n):
    """Edges like the texels beside them.  What tells kernels is further from the edges."""
    return np.ascontiguousarray(np.pad(n[1:-1, 1:-1], ((1, 1), (1, 1), (0, 0)), "edge"))


def examples():
    for case in range(72):
        h = reconstruction.fractal(256, case, (0.4, 1, 2)[case % 3], (1.6, 2, 2.4)[case // 3 % 3])
        h = h[: 256 - case % 7, : 200 + case % 5 * 4]
        kernel = ("central", "sobel3", "forward", "baked")[case // 2 % 4]
        border = CLAMP if kernel == "forward" else MIRROR
        if kernel == "baked":
            n = sampled(h)
        else:
            n = reconstruction.from_height(np.ascontiguousarray(h), kernel, border, border)
        yield kernel, DAMAGES[case % len(DAMAGES)](n)


def test_kernels_are_those_of_numpy():
    """A surface is only taken where no two opposite edges are level."""
    seen = Counter()
    for kernel, n in examples():
        inside = find_kernel(as_inside(n))
        found = find_kernel(n)
        level = is_level(n, 0) or is_level(n, 1)
        if inside["decided"] or inside["kernel"] != BAKED:
            assert found["kernel"] == inside["kernel"]
            continue
        assert found["kernel"] == (CENTRAL if level else BAKED), kernel
        assert not found["decided"]
        seen[kernel, level] += 1
    assert seen["central", True] >= 3 and seen["sobel3", True] >= 8, seen
    assert seen["baked", False] >= 8 and not seen["baked", True], seen


@pytest.mark.parametrize("down", [0, 1])
def test_one_axis_is_enough(down):
    """The other one is cut."""
    h = reconstruction.fractal(300, 3, 1, 2)
    n = jpeg(reconstruction.from_height(h, "central", MIRROR, MIRROR), 85, 0)
    n = n[:, 20:280] if down else n[20:280]
    n = np.ascontiguousarray(n)
    assert is_level(n, down) and not is_level(n, not down)
    assert find_kernel(as_inside(n))["kernel"] == BAKED
    assert find_kernel(n)["kernel"] == CENTRAL
    turned = n.copy()
    turned[..., 1] = 255 - n[..., 1]
    assert find_kernel(turned, y=ntp.DOWN)["kernel"] == CENTRAL


def test_surfaces_that_are_symmetric_are_no_mirror():
    """Tiles that rise from all edges alike, about a place beside the last texels or at them."""
    for n in (255, 256):
        for at in (0, 0.5):
            x = (np.arange(n) + at) * 2 * np.pi / n
            h = sum(np.cos(k * x)[:, None] * np.cos(k * x) for k in (1, 3, 8)) * 4
            for damage in DAMAGES:
                damaged = damage(sampled(h))
                assert not is_level(damaged, 0) and not is_level(damaged, 1)


@pytest.mark.parametrize("size, slope", [(256, 1), (64, 0.4)])
def test_level_edges_have_no_other_border(size, slope):
    """But wrap, which may cost less than the mirror that made them.  On gentle small maps another one would
    seem to fit after JPEG."""
    for seed in range(6):
        for kernel in ("central", "sobel3"):
            h = reconstruction.fractal(size, seed, slope, 2.2)
            n = reconstruction.from_height(h, kernel, MIRROR, MIRROR)
            for damage in DAMAGES:
                damaged = damage(n)
                for axis, found in enumerate(find_borders(damaged, CENTRAL)):
                    if is_level(damaged, axis):
                        assert found["border"] in (MIRROR, WRAP), (seed, kernel)
