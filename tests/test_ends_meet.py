# SPDX-License-Identifier: MIT
"""Damaged textures whose heights end as they begin: wrap, where a free border would lean."""

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import to_height as reconstruction
from support.drawn_maps import by_blocks
from support.encoders import jpeg
from support.find import find_borders
from support.oracle_height import CLAMP, EXTRAPOLATE, MIRROR, NAMES, WRAP

PLACES = np.arange(16) * 16 + np.arange(16) * 7 % 16  # rows in 256 that tell damage
BAKED, FORWARD, END = len(NAMES), NAMES.index("forward"), 4
LENGTH = 4 / (255**2 * 12)  # the square that rounding gives to the error of a length


def islands(n, seed):
    """A fractal that tiles, above a flat sea."""
    h = reconstruction.fractal(n, seed, 0.4, 2.2)
    return np.maximum(h, np.quantile(h, 0.6)).astype(np.float32)


def noisy(n, sigma=4, seed=1):
    added = np.random.default_rng(seed).normal(0, sigma, n.shape)
    return np.clip(n + added, 0, 255).round().astype(np.uint8)


DAMAGES = [noisy, lambda n: jpeg(n, 85, 0), lambda n: jpeg(n, 95, 0)]


def free(h, kernel="central"):
    border = CLAMP if kernel == "forward" else MIRROR
    return reconstruction.from_height(h, kernel, border, border)


def answers(n, kernel=BAKED, **how):
    """The borders, and which of them are wrap though the texels do not show it: undecided, and after
    the solution with a free border no other was asked for.  Progress tells that: of ten steps the
    third is the solution with a free border along x, the next three are others, and so on for y."""
    shares = []

    @ntp.ffi.callback("int32_t(void *, double)")
    def progress(_, share):
        shares.append(share)
        return 0

    found = find_borders(n, kernel, hooks=reconstruction.serial_hooks(1, progress=progress), **how)
    others = [any(first < 10 * share < first + 2.9 for share in shares) for first in (3.1, 7.1)]
    return [f["border"] for f in found], [
        f["border"] == WRAP and not f["decided"] and not other
        for f, other in zip(found, others, strict=True)
    ]


def error(made, h):
    a, b = made - made.mean(), h - h.mean()
    return np.sqrt(np.mean((a - b) ** 2)) / np.ptp(h)


# ------------------------------------------------------------------------- the same in numpy


def solved(n):
    """The slopes that heights with free borders are solved from."""
    rows = n[:: -(-len(n) // 256)]
    off = ((2 * rows.astype(float) / 255 - 1) ** 2).sum(-1) - 1
    damaged = np.mean(off**2) / 4 > 9 * LENGTH
    right, down = reconstruction.lean(rows) * 2 / 255 * damaged
    decode = reconstruction.to_height(n, decode=0, border_x=MIRROR, border_y=MIRROR)[1]["decode"]
    n = n.astype(float)
    if (
        decode == reconstruction.NEUTRAL
    ):  # then levels as near to zero as those of flat ground are 0
        ground = [np.bincount(c)[123:133].argmax() + 123 for c in rows[..., :2].reshape(-1, 2).T]
        n[..., :2][np.abs(2 * n[..., :2] - 255) <= np.abs(2 * np.array(ground) - 255).max()] = 127.5
        right = down = 0
    v = 2 * n / 255 - 1
    z = np.maximum(v[..., 2], 1 / 255)
    p, q = -v[..., 0] / z, v[..., 1] / z
    if damaged and (off[off > 0] ** 2).sum() > 0.05 * (off**2).sum():
        p, q = reconstruction.mixed_slopes(n)
    return p + right, q - down


def losses(p, q):
    """Of p along rows and q across them: the lean, and squares of steps: of both, the one, the other."""
    h, w = p.shape
    n = 16
    while 2 * n <= min(h, 512) and 2 * n * w <= 1 << 18:
        n *= 2
    rows = np.arange(n) * h // n
    ends = np.hstack([p[:, :END], p[:, -END:]]).sum(1) / 2
    apart = q[:, -END:].mean(1) - q[:, :END].mean(1)
    seen = (np.cumsum(apart) - apart / 2 + ends)[rows]
    step = p[rows].sum(1)
    squares = np.zeros(3)
    for half in 2 ** np.arange(int(np.log2(n))):
        a, b = (v.reshape(half, 2, -1).mean(2) for v in (step, seen))
        a, b = (np.subtract(*v.T) / 2 for v in (a, b))
        squares += np.array([np.mean(a * b), np.mean(a * a), np.mean(b * b)]) / half
    return step.mean(), squares


def in_blocks(n):
    """At most four colors in every block that is looked at, and in some three or four."""
    y, x = (np.arange(16) * (side // 4) // 16 * 4 for side in n.shape[:2])
    colors = [len(np.unique(n[j : j + 4, i : i + 4].reshape(-1, 3), axis=0)) for j in y for i in x]
    return max(colors) <= 4 and np.sum(np.array(colors) > 2) >= 8


def ends(n, down):
    """Whether ends meet, and whether steps show that they differ."""
    p, q = solved(n)
    if down:
        p, q = q.T, p.T
    h, w = p.shape
    v = 2 * n[PLACES * len(n) // 256].astype(float) / 255 - 1
    lean, (both, one, other) = losses(p, q)
    chance = np.sqrt(one * other)
    both = np.clip(both, 0, chance)
    steps = min(both, one, other)
    errors = one - steps
    ramp = lean**2 * 2 / 3 * w / h
    damaged = np.mean(((v**2).sum(-1) - 1) ** 2) / 4 > 5 * LENGTH
    agreed = steps * both / chance if chance else 0
    times = (ramp + 0.2 * errors) / max(9 * agreed + 0.2 * chance, 1e-30)
    most = 1.5 if lean**2 <= 2 * errors else 0.75
    if times > 400:
        most = max(most, 1)
    if times > 10 and in_blocks(n):
        most = 2.5
    meets = times > 1 and abs(lean) <= most / 255 * w
    return damaged and meets, damaged and not meets and both > 0.85 * chance


def meet(n, down):
    return ends(n, down)[0]


@pytest.mark.parametrize("y", [ntp.UP, ntp.DOWN])
def test_answers_are_those_of_numpy(y):
    said = []
    for seed in range(8):
        for h in (
            islands(256, seed),
            islands(320, seed)[:150],
            islands(256, seed) * 6,
            islands(256, seed) + 0.006 * np.arange(256, dtype=np.float32),
            reconstruction.fractal(400, seed, 0.4)[30:330, 20:220].copy(),
            reconstruction.fractal(256, seed, 0.7),
        ):
            n = [*DAMAGES, by_blocks][seed % 4](free(h, NAMES[seed % 3 % 2]))
            levels = n.copy()
            if y == ntp.DOWN:
                levels[..., 1] = 255 - n[..., 1]
            expected = [meet(n, 0), meet(n, 1)]
            assert answers(levels, y=y)[1] == expected, (seed, h.shape)
            said += expected
    assert 15 <= sum(said) <= len(said) - 15


def test_of_large_textures_some_rows_are_read():
    """All are asked, by way of what every third row tells."""
    said = []
    for seed in range(4):
        h = islands(640, seed)[: 640 - seed * 40]
        n = noisy(free(h, NAMES[seed % 2]))
        expected = [meet(n, 0), meet(n, 1)]
        assert answers(n)[1] == expected, seed
        said += expected
    assert 2 <= sum(said) <= 6


# ------------------------------------------------------------------------------- what it gives


@pytest.mark.parametrize("kernel", ["central", "forward", "sobel3"])
def test_a_bias_does_not_lean(kernel):
    """Noise whose fractions are cut off is half a level off zero, which a free border adds up."""
    ratios = []
    for seed in range(4):
        h = islands(256, seed)
        clean = free(h, kernel)
        for sigma in (2, 4):
            n = noisy(clean - 0.5, sigma, seed)
            borders, guessed = answers(n)
            if any(guessed):
                how = {"kernel": BAKED, "decode": reconstruction.DECODE_AUTO}
                ends = [MIRROR if g else b for g, b in zip(guessed, borders, strict=True)]
                errors = [
                    error(reconstruction.to_height(n, border_x=x, border_y=y, **how)[0], h)
                    for x, y in (borders, ends)
                ]
                ratios.append(errors[0] / errors[1])
    assert len(ratios) >= 5 and max(ratios) < 1 and np.mean(ratios) < 0.8, ratios


def cut_off(n, share):
    """A tile with flat sides, of whose columns a share in percent loses a level."""
    x = np.arange(n)
    h = islands(n, 3) * 2
    h = ((h - h.min()) * np.clip(np.minimum(x, x[::-1]) / 24 - 1, 0, 1)).astype(np.float32)
    clean = free(h)
    flat = (x < 20) | (x > n - 20)
    levels = np.where(flat[None, :, None], clean, noisy(clean, 1))
    levels[:, ~flat & (x % 100 < share), 0] -= 1
    return levels.astype(np.uint8)


@pytest.mark.parametrize("share, meets", [(60, True), (80, True), (100, False)])
def test_fractions_that_are_cut_off_lean(share, meets):
    """By up to half a level, where flat sides say that both ends are as high."""
    n = cut_off(256, share)
    assert meet(n, 0) == meets
    assert (answers(n, 0)[0][0] == WRAP) == meets


def test_colors_of_blocks_lean():
    """By more than a level of other damage could be."""
    slopes = reconstruction.fractal(256, 2, 2, 2.2), np.round(islands(256, 7) * 3)
    for axis, h in zip((1, 0), slopes, strict=True):
        n = by_blocks(free(h.astype(np.float32)))
        assert meet(n, axis) and answers(n)[0][axis] == WRAP
        moved = np.roll(n, 2, 1 - axis)  # no blocks begin at the corner
        assert not in_blocks(moved) and not meet(moved, axis) and not answers(moved)[1][axis]


def test_flat_edges_do_not_decide():
    """They fit every border, and bands of them show no damage."""
    for seed in (1, 4):
        inner = islands(256, seed)[48:-48, 48:-48]
        h = np.pad((inner - inner.min()) * 2, 48)
        for kernel in ("central", "forward"):
            for damage in DAMAGES:
                found = find_borders(damage(free(h, kernel)), NAMES.index(kernel))
                assert [(f["border"], f["decided"]) for f in found] == [(WRAP, 0)] * 2


def test_rows_of_a_grid_do_not_hide_damage():
    """Every sixteenth row is in a flat gap."""
    inner = islands(256, 5).reshape(16, 16, 256)
    h = inner - inner.min()
    h[:, :4] = h[:, 15:] = 0
    h = h.reshape(256, 256)
    n = by_blocks(free(h))
    assert (n[::16] == n[0, 0]).all()
    assert meet(n, 0) and answers(n)[1][0]


def test_ends_that_differ_do_not_meet():
    """By a step that changes along the edge, or by a ramp."""
    x = np.arange(256)[None] / 256
    for seed in range(4):
        for height in (4, 12):
            wave = height * x * np.sin(2 * np.pi * (x.T + seed / 4))
            for more in (wave, 2 * height * x + 0 * x.T):
                h = (islands(256, seed) + more).astype(np.float32)
                for damage in DAMAGES:
                    assert not answers(damage(free(h)))[1][0]
                    assert not answers(damage(free(h.T.copy())))[1][1]


def sampled(h):
    """Normals of the surface through the heights of a tile that has no finer detail."""
    y, x = (2 * np.pi * f for f in np.ix_(np.fft.fftfreq(len(h)), np.fft.fftfreq(len(h))))
    spectrum = np.fft.fft2(h)
    p, q = (np.fft.ifft2(1j * f * spectrum).real for f in (x, y))
    v = np.stack([-p, q, np.ones_like(p)], -1)
    return ((v / np.linalg.norm(v, axis=-1, keepdims=True) + 1) * 127.5 + 0.5).astype(np.uint8)


def test_ends_that_differ_do_not_wrap():
    """No kernel makes normals of rough ground again that a surface has, and wrap fits them no worse."""
    differ = met = 0
    for seed in range(12):
        h = reconstruction.fractal(512, seed, 1, 1.6)
        for damage in DAMAGES:
            n = damage(sampled(h)[30:286, 20:276].copy())
            for axis, border in enumerate(answers(n)[0]):
                meets, differs = ends(n, axis)
                differ += differs
                met += meets
                assert not differs or border != WRAP, (seed, axis)
    assert differ >= 40 and met <= 5, (differ, met)


def waves(n, seed):
    """A smooth tile, of at most 8 cycles."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:n, :n] * (2 * np.pi / n)
    h = sum(
        rng.normal() * np.cos(a * x + b * y + rng.uniform(0, 7)) / (1 + np.hypot(a, b))
        for a, b in rng.integers(-8, 9, (12, 2))
    )
    return (h * 15 / np.ptp(h)).astype(np.float32)


def test_of_borders_that_fit_alike_none_is_decided():
    """Tiles, and parts of them: what is decided is right."""
    said = 0
    for seed in range(6):
        rough = reconstruction.fractal(256, seed, 1, 1.6)
        steep = reconstruction.fractal(256, seed, 2.4, 2)
        for h in (rough, steep, waves(256, seed)):
            for n in (sampled(h), *(reconstruction.from_height(h, k) for k in NAMES[:2])):
                for damage in DAMAGES:
                    for part in (n, n[:180, 30:230].copy()):
                        found = find_borders(damage(part), FORWARD if h is steep else BAKED)
                        said += sum(f["decided"] for f in found)
                        wrong = [
                            f
                            for f in found
                            if f["decided"] and (f["border"] == WRAP) != (part is n)
                        ]
                        assert not wrong, (seed, wrong)
    assert said > 200, said


def test_undamaged_textures_are_not_asked():
    """Nor those whose blue is something else, or that were cut off."""
    for seed in range(8):
        h = islands(256, seed)
        for kernel in ("central", "forward"):
            fine = reconstruction.from_height(h, kernel, CLAMP, CLAMP, np.uint16) / 65535.0
            cut = np.floor(255 * fine).astype(np.uint8)
            clean = free(h, kernel)
            other = clean.copy()
            other[..., 2] = clean[::-1, :, 0]
            for n in (clean, other, cut):
                for solved_as in (NAMES.index(kernel), BAKED):
                    assert not any(answers(n, solved_as)[1]), (seed, kernel, solved_as)


def test_only_where_it_is_to_be_found():
    n = jpeg(free(islands(256, 6), "forward"), 95, 0)
    assert answers(n) == ([WRAP, WRAP], [True, True])
    assert answers(n, open_=(0, 1), border_x=EXTRAPOLATE) == ([EXTRAPOLATE, WRAP], [False, True])
    assert not any(answers(n, dx=1, dy=2)[1]), "texels are not square"
    assert not any(answers(n, method=2)[1]), "the method never wraps"
