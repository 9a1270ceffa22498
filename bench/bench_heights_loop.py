# SPDX-License-Identifier: MIT
"""How well heights give their normals back: bench_heights_loop.py [--size N]

NTP_BUILD names the build.  The tables of docs/reconstruction.md about `refine` and about weighted
least squares: fields that tile, made normals by a kernel, 8 and 16 bits.  Errors are of the heights,
texels are those whose normals, made again, differ.  All of it is deterministic but the seconds.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from support.to_height import MIRROR, WRAP, from_height
from support.weighted import DERIVED, weighted

FIELDS = [("gentle", 0.48, 2.0), ("terrain", 1.2, 2.6), ("steep", 1.9, 2.0)]
KERNELS = ["forward", "central", "sobel3"]
MASKED = [("central", WRAP), ("central", MIRROR), ("sobel3", WRAP), ("scharr3", WRAP)]
MASKED += [("prewitt5", WRAP), ("gimp9", WRAP)]


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


def error(ours, h):
    return np.std(ours.astype(np.float64) - h)


def differ(ours, n, how):
    return np.any(from_height(ours, dst=n.dtype.type, **how) != n, axis=-1).mean()


def refine_rows(size):
    """(field, kernel, texels of the best fit, texels left, rounds, error ratio, seconds)."""
    for name, slope, exponent in FIELDS:
        h = field(size, slope, exponent)
        for kernel in KERNELS:
            how = {"kernel": kernel, "border_x": WRAP, "border_y": WRAP}
            n = from_height(h, **how)
            plain, _ = weighted(n, method=0, z=DERIVED, **how)
            start = time.process_time()
            ours, result = weighted(n, method=0, z=DERIVED, refine=200, **how)
            seconds = time.process_time() - start
            ratio = error(ours, h) / error(plain, h)
            texels = differ(plain, n, how), differ(ours, n, how)
            yield name, kernel, *texels, result["rounds"], ratio, seconds


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
                ("wrap", "", "mirror")[border],
                bits,
                *texels,
                error(ours, h) / error(direct, h),
            )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--size", type=int, default=512)
    size = parser.parse_args().size
    print("refine: texels that differ before and after, rounds, error beside the best fit's")
    for name, kernel, before, after, rounds, ratio, seconds in refine_rows(size):
        print(
            f"  {name:8} {kernel:8} {before:7.2%} {after:8.3%} {rounds:4} {ratio:6.2f}"
            f" {seconds:7.1f} s",
            flush=True,
        )
    print("weighted, nothing masked: texels that differ, direct and weighted; error beside direct")
    for kernel, border, bits, direct, ours, ratio in weighted_rows(size):
        print(
            f"  {kernel:8} {border:7} {bits:2} {direct:7.2%} {ours:7.2%} {ratio:6.2f}", flush=True
        )


if __name__ == "__main__":
    main()
