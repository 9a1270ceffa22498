# SPDX-License-Identifier: MIT
"""How well heights give their normals back: bench_heights_loop.py [--size N]

NTP_BUILD names the build.  The tables of docs/reconstruction.md about `refine` and about weighted
least squares: fields that tile, made normals by a kernel, 8 and 16 bits.  Errors are of the heights,
texels are those whose normals, made again, differ.  All of it is deterministic but the seconds.
"""

import argparse
import itertools
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from support.to_height import CLAMP, EXTRAPOLATE, MIRROR, WRAP, bricks, bumps, from_height
from support.weighted import DERIVED, STORED, weighted

BORDERS = ["wrap", "clamp", "mirror", "extrapolate"]
ROUNDS = 150
KERNELS = ["forward", "central", "sobel3"]
MASKED = [("central", WRAP), ("central", MIRROR), ("sobel3", WRAP), ("scharr3", WRAP)]
MASKED += [("sobel3", CLAMP), ("prewitt5", WRAP), ("gimp9", WRAP)]


def field(n, rms_slope, exponent, seed=1):
    """A fractal that tiles, of this slope; its spectrum falls with the frequency."""
    rng = np.random.default_rng(seed)
    k = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None])
    k[0, 0] = 1
    spectrum = k**-exponent * np.exp(2j * np.pi * rng.random(k.shape))
    spectrum[0, 0] = 0
    h = np.fft.irfft2(spectrum, s=(n, n))
    slope = np.hypot(np.roll(h, -1, 1) - h, np.roll(h, -1, 0) - h)
    return (h * rms_slope / np.sqrt(np.mean(slope**2))).astype(np.float32)


def rough(n, height, seed=1):
    """A rougher fractal that tiles, of this range."""
    rng = np.random.default_rng(seed)
    k = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None])
    k[0, 0] = np.inf
    h = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((n, n))) / k**1.6, s=(n, n))
    return ((h - h.min()) / np.ptp(h) * height).astype(np.float32)


def nearest_blue(h):
    """Normals by central slopes that wrap, every channel rounded by itself."""
    p, q = ((np.roll(h, -1, a) - np.roll(h, 1, a)) / 2 for a in (1, 0))
    n = np.stack([-p, q, np.ones_like(p)], -1).astype(np.float64)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return np.floor((n + 1) * 127.5 + 0.5).astype(np.uint8)


def error(ours, h):
    return np.std(ours.astype(np.float64) - h)


def differ(ours, n, how):
    return np.any(from_height(ours, dst=n.dtype.type, **how) != n, axis=-1).mean()


def refined(name, h, kernel, border, dtype=np.uint8, blue="derived", mask=None):
    """(what, texels of the best fit, texels left, rounds, error ratio, seconds)."""
    how = {"kernel": kernel, "border_x": border, "border_y": border}
    n = nearest_blue(h) if blue == "nearest" else from_height(h, dst=dtype, **how)
    how["z"] = STORED if blue == "nearest" else DERIVED
    if mask is not None:
        how["mask"] = mask
    else:
        how["method"] = 0
    seen = np.ones(h.shape, bool) if mask is None else mask != 0
    plain, _ = weighted(n, refine=0, **how)
    left = weighted(n, refine=1, **how)[1]["refine_left"] if mask is not None else None
    start = time.process_time()
    ours, result = weighted(n, refine=ROUNDS, **how)
    seconds = time.process_time() - start
    again = nearest_blue if blue == "nearest" else None
    kept = {k: how[k] for k in ("kernel", "border_x", "border_y")}
    if left is None:
        made = again(plain) if again else from_height(plain, dst=dtype, **kept)
        left = np.any(made != n, axis=-1).sum()
    ratio = error(ours[seen] - ours[seen].mean(), h[seen] - h[seen].mean())
    ratio /= error(plain[seen] - plain[seen].mean(), h[seen] - h[seen].mean())
    what = f"{name:9} {kernel:8} {BORDERS[border]:12} {8 * n.itemsize:2} {blue:8}"
    return what, left / h.size, result["refine_left"], result["rounds"], ratio, seconds


def refine_rows(size):
    tiles = [("gentle", field(size, 0.48, 2.0)), ("rough 30", rough(size, 30))]
    tiles += [("terrain", field(size, 1.2, 2.6)), ("steep", field(size, 1.9, 2.0))]
    tiles += [("rough 120", rough(size, 120))]
    flat = [("bricks", bricks(size // 48 * 48)), ("bumps", bumps(size, size * size // 1800))]
    for (name, h), kernel in itertools.product(tiles + flat, KERNELS):
        yield refined(name, h.astype(np.float32), kernel, WRAP)
    crop = field(2 * size, 0.7, 2.3)[:size, :size].copy()
    for kernel, border in (("forward", EXTRAPOLATE), ("central", EXTRAPOLATE), ("central", MIRROR)):
        yield refined("crop", crop, kernel, border)
    yield refined("crop", crop, "sobel3", CLAMP)
    for kernel in ("prewitt5", "gimp7"):
        yield refined("crop", crop, kernel, MIRROR)
    for kernel in KERNELS:
        yield refined("rough 30", rough(size, 30), kernel, WRAP, np.uint16)
    for name, h in tiles[1:3]:
        yield refined(name, h, "central", WRAP, blue="nearest")
    y, x = np.mgrid[:size, :size] - size / 2
    disc = (np.hypot(x, y) < 0.45 * size).astype(np.uint8)
    yield refined("disc", crop, "central", CLAMP, mask=disc)


def weighted_rows(size):
    """(kernel, border, bits, texels of direct and weighted, error ratio), nothing masked."""
    h = field(size, 0.7, 2.3)
    for kernel, border in MASKED:
        for dtype in (np.uint8, np.uint16):
            how = {"kernel": kernel, "border_x": border, "border_y": border}
            n = from_height(h, dst=dtype, **how)
            direct, _ = weighted(n, method=0, **how)
            ours, _ = weighted(n, mask=np.ones(h.shape, np.uint8), **how)
            texels = differ(direct, n, how), differ(ours, n, how)
            bits = 8 * np.dtype(dtype).itemsize
            yield (
                kernel,
                BORDERS[border],
                bits,
                *texels,
                error(ours, h) / error(direct, h),
            )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--size", type=int, default=512)
    size = parser.parse_args().size
    print(
        "refine: texels that differ (with a mask: after a round), left, rounds, error by the best fit's"
    )
    for what, before, left, rounds, ratio, seconds in refine_rows(size):
        print(
            f"  {what} {before:7.2%} {left:6} {rounds:4} {ratio:6.2f} {seconds:7.1f} s", flush=True
        )
    print("weighted, nothing masked: texels that differ, direct and weighted; error beside direct")
    for kernel, border, bits, direct, ours, ratio in weighted_rows(size):
        print(
            f"  {kernel:8} {border:7} {bits:2} {direct:7.2%} {ours:7.2%} {ratio:6.2f}", flush=True
        )


if __name__ == "__main__":
    main()
