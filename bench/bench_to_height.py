# SPDX-License-Identifier: MIT
"""Times normals -> heightfield beside scipy.fft: bench_to_height.py [--pairs N] [--size N]

NTP_BUILD names the build.  The same least squares on both sides, RGB8 normals to float heights, one
thread; A and B alternate, and the median of the pairwise ratios of processor time is compared with
the goal.  In the rows "slopes" scipy gets ready-made slopes, while ours decodes.
"""

import argparse
import statistics
import sys
import time
from pathlib import Path

import numpy as np
import scipy.fft

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from support import libntp_ffi as ntp

FORWARD = 1
WRAP, CLAMP = 0, 1
UNORM, STORED = 1, 1
GOAL = 0.6


def normals(n):
    """Waves and noise, one-sided slopes, 8 bit."""
    y, x = np.mgrid[0:n, 0:n].astype(np.float32)
    turn = np.float32(2 * np.pi / n)
    h = 40 * np.sin(5 * turn * x) * np.cos(3 * turn * y)
    h += np.random.default_rng(0).standard_normal((n, n), np.float32) * 0.3
    p, q = np.roll(h, -1, 1) - h, np.roll(h, -1, 0) - h
    v = np.stack([-p, q, np.ones_like(p)], axis=-1)
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    return ((v + 1) * 127.5 + 0.5).astype(np.uint8)


class Ours:
    def __init__(self, src, kernel, border):
        h, w = src.shape[:2]
        self.dst = np.zeros((h, w), np.float32)
        how = {"kernel": kernel, "border_x": border, "border_y": border, "decode": UNORM}
        how["z"] = STORED
        self.how = ntp.ffi.new("ntp_height_options *", how)
        self.size = ntp.lib.ntp_height_scratch_size(self.how, w, h, 1)
        self.scratch = ntp.aligned(self.size, 64)
        self.where = ntp.ffi.cast("void *", self.scratch.__array_interface__["data"][0])
        self.views = ntp.view(self.dst, ntp.HEIGHT), ntp.view(src, const=True)

    def __call__(self):
        null = ntp.ffi.NULL
        ntp.check(
            ntp.lib.ntp_height_from_normals(
                *self.views, self.how, self.where, self.size, null, null
            )
        )
        return self.dst


def slopes(src, real=np.float32):
    """With as few passes as numpy allows."""
    v = src.astype(real)
    v *= real(2 / 255)
    v -= 1
    z = np.maximum(v[..., 2], real(1 / 255))
    return -v[..., 0] / z, v[..., 1] / z


def by_fourier(p, q):
    """One-sided, wrapping: the divergence in space, one transform there and one back."""
    h, w = p.shape
    f = np.roll(p, 1, 1) - p
    f += np.roll(q, 1, 0)
    f -= q
    spectrum = scipy.fft.rfft2(f, workers=1)
    wx = 4 * np.sin(np.pi * np.arange(w // 2 + 1) / w) ** 2
    wy = 4 * np.sin(np.pi * np.arange(h) / h) ** 2
    symbol = (wy[:, None] + wx[None, :]).astype(p.dtype)
    symbol[0, 0] = np.inf
    spectrum /= symbol
    return scipy.fft.irfft2(spectrum, s=(h, w), workers=1)


def by_cosines(p, q):
    """One-sided, free: the last slopes of a row and a column are ignored."""
    h, w = p.shape
    f = np.zeros((h, w), p.dtype)
    f[:, 1:] += p[:, :-1]
    f[:, :-1] -= p[:, :-1]
    f[1:] += q[:-1]
    f[:-1] -= q[:-1]
    spectrum = scipy.fft.dctn(f, type=2, overwrite_x=True, workers=1)
    wx = 4 * np.sin(np.pi * np.arange(w) / (2 * w)) ** 2
    wy = 4 * np.sin(np.pi * np.arange(h) / (2 * h)) ** 2
    symbol = (wy[:, None] + wx[None, :]).astype(p.dtype)
    symbol[0, 0] = np.inf
    spectrum /= symbol
    return scipy.fft.idctn(spectrum, type=2, overwrite_x=True, workers=1)


def compare(name, a, b, pairs):
    first, second = a().astype(np.float64), b()
    off = np.abs(first - second).max() / np.ptp(first)
    times = []
    for i in range(pairs):
        pair = [0.0, 0.0]
        for which in (0, 1) if i % 2 == 0 else (1, 0):
            start = time.thread_time()
            (a, b)[which]()
            pair[which] = time.thread_time() - start
        times.append(pair)
    ratio = statistics.median(x / y for x, y in times)
    a_ms, b_ms = (1000 * statistics.median(column) for column in zip(*times, strict=True))
    mark = "" if ratio <= GOAL else "  over"
    print(
        f"{name:36}{a_ms:>9.1f} ms{b_ms:>9.1f} ms{ratio:>8.3f}  <= {GOAL:g}{mark}"
        f"   (apart: {off:.1e} of the range)",
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=7)
    parser.add_argument("--size", type=int, action="append")
    args = parser.parse_args()
    for size in args.size or (2048, 4096):
        src = normals(size)
        for name, border, solve in [("wrap", WRAP, by_fourier), ("free", CLAMP, by_cosines)]:
            ours = Ours(src, FORWARD, border)
            for real in (np.float32, np.float64):
                row = f"RGB8 {size} {name}, scipy {np.dtype(real)}"
                compare(row, ours, lambda s=solve, r=real: s(*slopes(src, r)), args.pairs)  # noqa: B023
            p, q = slopes(src)
            row = f"RGB8 {size} {name}, scipy from slopes"
            compare(row, ours, lambda s=solve: s(p, q), args.pairs)  # noqa: B023


if __name__ == "__main__":
    main()
