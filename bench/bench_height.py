# SPDX-License-Identifier: MIT
"""Times heightfield -> normals beside numpy and OpenCV: bench_height.py [--pairs N] [--size N]

NTP_BUILD names the build.  A and B alternate, and the median of the pairwise ratios of processor
time (of elapsed time for two threads) is compared with the goal.  OpenCV (the
opencv-python-headless package) is left out if it is not installed.
"""

import argparse
import statistics
import sys
import threading
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from support import libntp_ffi as ntp

try:
    import cv2
except ImportError:
    cv2 = None

SCALE = 20.3
CENTRAL, SOBEL3, GIMP9 = 0, 3, 9
MIRROR = 2
STRIP = 128  # rows


def heightfield(n):
    """Waves and a little noise, 0..1."""
    y, x = np.mgrid[0:n, 0:n].astype(np.float32)
    rng = np.random.default_rng(0)
    h = np.sin(x * 0.03) * np.cos(y * 0.021) + 0.3 * np.sin(x * 0.31 + y * 0.17)
    h += rng.standard_normal((n, n), np.float32) * 0.02
    return (h - h.min()) / (h.max() - h.min())


class Ours:
    def __init__(self, src, kernel):
        self.out = np.zeros((*src.shape, 3), np.uint8)
        self.views = ntp.view(self.out), ntp.view(src, ntp.HEIGHT, const=True)
        self.how = ntp.ffi.new("ntp_normals_options *")
        self.how.scale, self.how.kernel = SCALE, kernel
        self.how.border_x = self.how.border_y = MIRROR

    def __call__(self):
        self.rows(0, self.out.shape[0])

    def rows(self, first, end):
        area = ntp.ffi.new("ntp_rect *", (0, first, self.out.shape[1], end))
        null = ntp.ffi.NULL
        ntp.check(ntp.lib.ntp_normals_from_height(*self.views, self.how, null, area))

    def on_two_threads(self):
        """The next free thread takes the next strip."""
        end = self.out.shape[0]
        strips = iter(range(0, end, STRIP))

        def work():
            for first in strips:
                self.rows(first, min(first + STRIP, end))

        other = threading.Thread(target=work)
        other.start()
        work()
        other.join()


def opencv(src):
    """Two Sobels, a root, a division, a merge, one conversion: as few passes as possible."""
    factor = SCALE / 8 / np.iinfo(src.dtype).max
    border = cv2.BORDER_REFLECT_101
    p = cv2.Sobel(src, cv2.CV_32F, 1, 0, scale=-factor, borderType=border)
    q = cv2.Sobel(src, cv2.CV_32F, 0, 1, scale=factor, borderType=border)
    length = cv2.add(cv2.add(cv2.multiply(p, p), cv2.multiply(q, q)), 1.0)
    inverse = cv2.divide(127.5, cv2.sqrt(length))
    planes = (cv2.multiply(p, inverse), cv2.multiply(q, inverse), inverse)
    return cv2.convertScaleAbs(cv2.merge(planes), alpha=1, beta=127.5)


def straightforward(src):
    h = src.astype(np.float32) * (SCALE / 8 / np.iinfo(src.dtype).max)
    up, down = np.roll(h, 1, 0), np.roll(h, -1, 0)
    column, rise = up + 2 * h + down, up - down
    p = np.roll(column, -1, 1) - np.roll(column, 1, 1)
    q = np.roll(rise, 1, 1) + 2 * rise + np.roll(rise, -1, 1)
    n = np.dstack((-p, -q, np.ones_like(p)))
    n /= np.linalg.norm(n, axis=2, keepdims=True)
    return ((n + 1) * 127.5 + 0.5).astype(np.uint8)


def compare(name, a, b, pairs, goal, clock=time.thread_time):
    """The time of A divided by that of B: at most the goal."""
    a(), b()
    times = []
    for i in range(pairs):
        pair = [0.0, 0.0]
        for which in (0, 1) if i % 2 == 0 else (1, 0):
            start = clock()
            (a, b)[which]()
            pair[which] = clock() - start
        times.append(pair)
    ratio = statistics.median(x / y for x, y in times)
    a_ms, b_ms = (1000 * statistics.median(column) for column in zip(*times, strict=True))
    mark = "" if ratio <= goal else "  over"
    print(f"{name:36}{a_ms:>9.1f} ms{b_ms:>9.1f} ms{ratio:>8.3f}  <= {goal:g}{mark}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=7)
    parser.add_argument("--size", type=int, default=4096)
    args = parser.parse_args()
    h = heightfield(args.size)
    sources = {
        "u8": (h * 255 + 0.5).astype(np.uint8),
        "u16": (h * 65535 + 0.5).astype(np.uint16),
    }
    for name, src in sources.items():
        ours = Ours(src, SOBEL3)
        if cv2 is not None:
            cv2.setNumThreads(1)
            beside = lambda src=src: opencv(src)
            compare(f"{name} sobel3, OpenCV", ours, beside, args.pairs, 1 / 4)
        beside = lambda src=src: straightforward(src)
        compare(f"{name} sobel3, numpy", ours, beside, args.pairs, 1 / 12)
        both = ours.on_two_threads
        compare(f"{name} two threads, one", both, ours, args.pairs, 0.56, time.perf_counter)
        compare(f"{name} central, sobel3", Ours(src, CENTRAL), ours, args.pairs, 1)
        compare(f"{name} gimp9, central", Ours(src, GIMP9), Ours(src, CENTRAL), args.pairs, 4)


if __name__ == "__main__":
    main()
