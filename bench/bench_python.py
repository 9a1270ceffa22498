# SPDX-License-Identifier: MIT
"""Times normaltexture beside straightforward numpy and OpenCV: bench_python.py [--size N]

Run it where the package is installed, on a machine with nothing else to do: `./dev python`, then
`.venv-python/bin/python bench/bench_python.py`.  A and B alternate in one run, and the best of each
is compared with the goal.  The numpy and OpenCV versions are what one would write in a tool:
floats, whole arrays, rounding half up.  OpenCV is left out if it is not installed.
"""

import argparse
import functools
import sys
import time

import numpy as np

import normaltexture as nt

try:
    import cv2
except ImportError:
    cv2 = None

CALL_GOAL = 30e-6  # seconds of a call on one texel
SPEED_GOAL = 10  # times as fast as numpy
THREADS_GOAL = 0.8  # times as fast as one thread, also where there is little to do
ROUNDS = 7


def numpy_clean(texture):
    """Red and green stay, and blue is computed; pairs that are too long are shortened first."""
    xy = texture[..., :2].astype(np.float32) * (2 / 255) - 1
    length2 = (xy * xy).sum(-1, keepdims=True)
    xy = np.where(length2 > 1, xy / np.sqrt(np.maximum(length2, 1)), xy)
    z = np.sqrt(np.maximum(1 - (xy * xy).sum(-1, keepdims=True), 0))
    out = np.floor((np.concatenate([xy, z], -1) + 1) * 127.5 + 0.5)
    return out.astype(np.uint8)


def numpy_normals(height, scale):
    """Central differences that wrap, normalized, encoded."""
    h = height.astype(np.float32) * (scale / 255)
    p = (np.roll(h, -1, 1) - np.roll(h, 1, 1)) / 2
    q = (np.roll(h, 1, 0) - np.roll(h, -1, 0)) / 2
    n = np.stack([-p, -q, np.ones_like(h)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return np.floor((n + 1) * 127.5 + 0.5).astype(np.uint8)


def opencv_clean(texture):
    """The same with OpenCV's whole-array operations, on separate planes."""
    r, g, _ = (c.astype(np.float32) for c in cv2.split(texture))
    x, y = cv2.addWeighted(r, 2 / 255, r, 0, -1), cv2.addWeighted(g, 2 / 255, g, 0, -1)
    length = cv2.max(cv2.magnitude(x, y), 1.0)
    x, y = cv2.divide(x, length), cv2.divide(y, length)
    z = cv2.sqrt(cv2.max(1 - cv2.add(cv2.multiply(x, x), cv2.multiply(y, y)), 0.0))
    return cv2.convertScaleAbs(cv2.merge([x, y, z]), alpha=127.5, beta=127.5)


def opencv_normals(height, scale):
    """cv2.Sobel of size 1 is the central difference; borders are replicated."""
    h = height.astype(np.float32)
    p = cv2.Sobel(h, cv2.CV_32F, 1, 0, ksize=1, scale=-scale / 510)
    q = cv2.Sobel(h, cv2.CV_32F, 0, 1, ksize=1, scale=scale / 510)
    length = cv2.sqrt(cv2.multiply(p, p) + cv2.multiply(q, q) + 1)
    n = cv2.merge([cv2.divide(p, length), cv2.divide(q, length), cv2.divide(1.0, length)])
    return cv2.convertScaleAbs(n, alpha=127.5, beta=127.5)


def seconds(call):
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def best(*calls):
    """The shortest time of each; they take turns."""
    for call in calls:
        call()
    times = [[seconds(call) for call in calls] for _ in range(ROUNDS)]
    return [min(column) for column in zip(*times, strict=True)]


class Report:
    def __init__(self):
        self.missed = []

    def row(self, name, a, b, goal=None):
        ratio = b / a
        mark = ""
        if goal is not None:
            mark = f"  goal >= {goal:g}"
            if ratio < goal:
                mark += "  missed"
                self.missed.append(name)
        print(f"{name:46}{1e3 * a:9.2f} ms{1e3 * b:9.2f} ms{ratio:8.1f} x{mark}", flush=True)

    def call(self, name, function, goal=CALL_GOAL):
        count, times = 1000, []
        for _ in range(7):
            start = time.thread_time()  # what else runs on the machine does not count
            for _ in range(count):
                function()
            times.append((time.thread_time() - start) / count)
        each = min(times)
        mark = ""
        if goal is not None:
            mark = f"  goal <= {1e6 * goal:.0f}"
            if each > goal:
                mark += "  missed"
                self.missed.append(name)
        print(f"{name:46}{1e6 * each:9.1f} us{mark}", flush=True)


def speeds(report, size):
    rng = np.random.default_rng(1)
    height = rng.integers(0, 256, (size, size), np.uint8)
    texture = numpy_normals(height, 3.0)
    out = np.empty_like(texture)
    print(f"{size} x {size}, 8 bit{'':28}{'ours':>12}{'theirs':>12}")
    cases = [
        ("clean", functools.partial(nt.clean, type="standard"), numpy_clean, opencv_clean, texture, {}),
        ("normals_from_height", nt.normals_from_height, numpy_normals, opencv_normals, height,
         {"scale": 3.0}),
    ]  # fmt: skip
    for name, function, by_numpy, by_opencv, data, how in cases:
        ours = functools.partial(function, data, out=out, **how)
        report.row(
            f"{name}, numpy", *best(ours, functools.partial(by_numpy, data, **how)), SPEED_GOAL
        )
        if cv2 is not None:
            report.row(f"{name}, OpenCV", *best(ours, functools.partial(by_opencv, data, **how)))


def threads(report, size):
    """Two threads should help with much work, and never cost much."""
    rng = np.random.default_rng(1)
    print(f"\n{'two threads beside one':46}{'two':>12}{'one':>12}")
    for side in sorted({64, 256, 512, size}):
        height = rng.integers(0, 256, (side, side), np.uint8)
        texture = nt.normals_from_height(height, scale=3)
        out = np.empty_like(texture)
        cases = {
            "clean": lambda n, t=texture, o=out: nt.clean(t, type="standard", out=o, threads=n),
            "normals_from_height": lambda n, h=height, o=out: nt.normals_from_height(
                h, scale=3, out=o, threads=n
            ),
            "heatmap": lambda n, t=texture, o=out: nt.heatmap(t, type="standard", out=o, threads=n),
            "measure": lambda n, t=texture: nt.measure(t, threads=n),
        }
        for name, call in cases.items():
            times = best(functools.partial(call, 2), functools.partial(call, 1))
            report.row(f"{name}, {side} x {side}", *times, THREADS_GOAL)


def texels():
    """One texel in the forms that the functions take."""
    texel = np.array([[[128, 128, 255]]], np.uint8)
    return texel, nt.convert(texel, depth=16), nt.convert(texel, depth="float"), nt.decode(texel)


def calls(report):
    """Each function that takes an array; `read`, `read_info`, `write` and `check` take files."""
    texel, deep, floats, vector = texels()
    gray, counted = texel[..., 0], nt.Tally().add(texel)
    heights = np.zeros((1, 1), np.float32)
    tally = nt.Tally()
    cases = {
        "clean": lambda: nt.clean(texel, type="standard"),
        "clean, 16 bit": lambda: nt.clean(deep, type="standard"),
        "clean, float": lambda: nt.clean(floats, type="standard"),
        "clean, counts": lambda: nt.clean_with_counts(texel, type="standard"),
        "clean, a mirrored view": lambda: nt.clean(texel[::-1, ::-1], type="standard"),
        'clean, type="auto"': lambda: nt.clean(texel, type="auto"),
        'clean, type="auto", method="auto"': lambda: nt.clean(texel, type="auto", method="auto"),
        "validate": lambda: nt.validate(texel, type="standard"),
        "inspect": lambda: nt.inspect(texel, 0, 0, type="standard"),
        "convert": lambda: nt.convert(texel, to="zzero"),
        "convert, to DXT5nm": lambda: nt.convert(texel, channels="1y0x"),
        "decode": lambda: nt.decode(texel),
        "encode": lambda: nt.encode(vector),
        "heatmap": lambda: nt.heatmap(texel, type="standard"),
        'heatmap, type="auto"': lambda: nt.heatmap(texel, type="auto"),
        "shade": lambda: nt.shade(texel, type="standard"),
        "transform": lambda: nt.transform(texel, type="standard", flip="x"),
        "transform, strength": lambda: nt.transform(texel, type="standard", strength=2),
        "blend": lambda: nt.blend(texel, texel, type="standard"),
        "resize": lambda: nt.resize(texel, type="standard", size=(1, 1)),
        "resize, to 2 x 2": lambda: nt.resize(
            texel, type="standard", size=(2, 2), filter="lanczos3"
        ),
        "mip_chain": lambda: nt.mip_chain(texel, type="standard"),
        "normals_from_height": lambda: nt.normals_from_height(gray, scale=1),
        "normals_from_height, 5 settings": lambda: nt.normals_from_height(
            gray, scale=1, kernel="sobel3", border="clamp", to="xy", to_y="down", depth=16
        ),
        "height_from_normals": lambda: nt.height_from_normals(texel, type="standard"),
        'height_from_normals, type="auto"': lambda: nt.height_from_normals(texel),
        "height_from_normals, info": lambda: nt.height_from_normals_with_info(
            texel, type="standard"
        ),
        "height_from_rows": lambda: nt.height_from_rows(
            lambda y, n: texel, lambda y, rows: None, lambda y, n: heights, shape=(1, 1, 3)
        ),
        "detect_orientation": lambda: nt.detect_orientation(texel),
        "find_kernel": lambda: nt.find_kernel(texel),
        "find_seams": lambda: nt.find_seams(texel),
        "find_steps": lambda: nt.find_steps(texel),
        "compare": lambda: nt.compare(texel, texel, type="standard"),
        "measure": lambda: nt.measure(texel),
        "measure, and a number of it": lambda: nt.measure(texel).standard.neighbor,
        "measure, 16 bit": lambda: nt.measure(deep),
        "measure, 16 bit, and a number of it": lambda: nt.measure(deep).standard.neighbor,
        "measure, float": lambda: nt.measure(floats),
        'measure, type="height"': lambda: nt.measure(gray, type="height"),
        "Tally.add": lambda: tally.add(texel),
        "classify": lambda: nt.classify(texel),
        "classify, 16 bit": lambda: nt.classify(deep),
        "classify, of a Tally": lambda: nt.classify(counted),
        "choose_method": lambda: nt.choose_method(texel),
    }
    print("\none texel; read, read_info, write and check, of files, are not among them")
    for name, call in cases.items():
        report.call(name, call)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=2048)
    arguments = parser.parse_args()
    report = Report()
    speeds(report, arguments.size)
    threads(report, arguments.size)
    calls(report)
    if report.missed:
        sys.exit(f"missed: {', '.join(report.missed)}")


if __name__ == "__main__":
    main()
