# SPDX-License-Identifier: MIT
"""Heights of damaged maps with everything on auto, beside the best of 22 fixed settings.

./dev bench heights --auto [SEED..] takes made maps: five surfaces, made by four kernels, whole tiles
and parts cut out, four damages.  Without a seed it takes the heights of public projects that NTP_CORPUS
and NTP_REAL hold.  A map fails with more than 1.5 times the error of the best setting.  Beside it
stands how many fail that are told the kernel and the borders with which they were made.  The cause is
the first answer that mends it when it is the best setting's: of the kernel, the border, both, the rest.
"""

import itertools
import os
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from PIL import Image

from damaged_maps import DAMAGES, SURFACES, error
from support import oracle_height as heights
from support import to_height as ours
from support.find import find_borders, find_kernel, find_seams

MOST = 1.5
SIZE = 256
NAMES = (*heights.NAMES, "baked")
KERNELS = ("central", "forward", "sobel3", "baked")
BORDERS = ["wrap", "clamp", "mirror", "extrapolate", "repeat-slope"]
DAMAGED = ("JPEG 95", "JPEG 85", "BC1", "noise 4")
SPONZA = "turanszkij+WickedEngine/Content/models/Sponza/textures/"
# Below NTP_CORPUS or NTP_REAL.
FILES = [
    "panda3d/heightfield.png",
    "bevy/cube_depth.png",
    "MaterialX/plain_heightmap.png",
    "tex-trak5_src.dpkdir/tile1_h.png",
    *(
        f"{SPONZA}{name}_bump.png"
        for name in [
            "spnza_bricks_a",
            "lion",
            "vase_round",
            "background",
            "sponza_column_b",
            "sponza_arch",
            "vase",
            "chain_texture",
            "sponza_thorn",
        ]
    ),
    "JoeyDeVries+LearnOpenGL/resources/textures/bricks2_disp.jpg",
]


def sampled(h):
    """Normals of the surface through the heights that has no finer detail; it tiles."""
    rows, columns = h.shape
    y = np.fft.fftfreq(rows)[:, None] * 2 * np.pi
    x = np.fft.rfftfreq(columns)[None] * 2 * np.pi
    y, x = np.where(y == -np.pi, 0, y), np.where(x == np.pi, 0, x)
    spectrum = np.fft.rfft2(h)
    p, q = (np.fft.irfft2(1j * spectrum * f, s=h.shape) for f in (x, y))
    v = np.stack([-p, q, np.ones_like(p)], -1)
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    return np.floor((v + 1) * 127.5 + 0.5).astype(np.uint8)


def free_border(kernel):
    return ours.CLAMP if kernel == "forward" else ours.MIRROR


def normals(h, kernel, border=ours.WRAP):
    return sampled(h) if kernel == "baked" else ours.from_height(h, kernel, border, border)


def made(seed):
    for name, kernel, cut in itertools.product(SURFACES, KERNELS, (False, True)):
        h = SURFACES[name](2 * SIZE if cut else SIZE, seed).astype(np.float32)
        n = normals(h, kernel)
        part = np.s_[30 : SIZE + 10, 20:SIZE] if cut else np.s_[:]
        truth = kernel, free_border(kernel) if cut else ours.WRAP
        yield f"{name}, {seed}, {'cut' if cut else 'tile'}", truth, n[part].copy(), h[part].copy()


def heights_of(file):
    """At most 512 x 512 texels, of a rms slope of a half; the levels of the file do not show."""
    h = np.asarray(Image.open(file)).astype(float)
    h = h[..., :3].mean(-1) if h.ndim == 3 else h
    while min(h.shape) >= 1024:
        y, x = h.shape[0] // 2, h.shape[1] // 2
        h = h[: 2 * y, : 2 * x].reshape(y, 2, x, 2).mean((1, 3))
    h = h[:512, :512]
    for axis in (0, 1):
        h = (h + np.roll(h, 1, axis) + np.roll(h, -1, axis)) / 3
    slope = np.sqrt(sum(np.mean(np.diff(h, axis=axis) ** 2) for axis in (0, 1)))
    return (h * (0.5 / slope)).astype(np.float32)


def real():
    folders = [Path(os.environ[k]) for k in ("NTP_CORPUS", "NTP_REAL") if os.environ.get(k)]
    for name in FILES:
        file = next((f / name for f in folders if (f / name).exists()), None)
        if file is None:
            print(f"missing: {name}")
            continue
        for slope, kernel in itertools.product((0.6, 2.0), KERNELS):
            h = (heights_of(file) * slope).astype(np.float32)
            truth = kernel, ours.WRAP if kernel == "baked" else free_border(kernel)
            yield f"{file.stem} x {slope}", truth, normals(h, *truth), h


def solve(n, h, **how):
    return error(ours.to_height(n, **how)[0], h)


def detect(n):
    """The kernel, whether it is sure, and both borders, as the program finds them."""
    kernel = find_kernel(n)
    wraps = [seam["wraps"] for seam in find_seams(n)]
    x, y = find_borders(n, kernel["kernel"], wraps=wraps)
    return kernel["kernel"], kernel["decided"], (x["border"], y["border"])


def fixed(n, h):
    """The errors of all settings."""
    found = {}
    for kernel, z in itertools.product(KERNELS, (ours.STORED, ours.DERIVED)):
        for border in (ours.WRAP, free_border(kernel), ours.EXTRAPOLATE):
            if kernel == "sobel3" and border == ours.EXTRAPOLATE:
                continue  # not for the direct solver
            how = {"kernel": NAMES.index(kernel), "border_x": border, "border_y": border, "z": z}
            found[kernel, border, z] = solve(n, h, decode=ours.UNORM, **how)
    return found


def cause(n, h, most, best, borders, kernel):
    auto = {"decode": ours.DECODE_AUTO, "z": ours.Z_AUTO}
    tries = {
        "kernel": (NAMES.index(best[0]), *borders),
        "border": (kernel, best[1], best[1]),
        "kernel and border": (NAMES.index(best[0]), best[1], best[1]),
    }
    for name, (k, x, y) in tries.items():
        if solve(n, h, kernel=k, border_x=x, border_y=y, **auto) <= most:
            return name
    return "decode, z or prior"


def judge(case):
    name, (kernel, border), damage, clean, h = case
    n = DAMAGES[damage](clean)
    found, decided, borders = detect(n)
    x, y = borders
    auto = {"decode": ours.DECODE_AUTO, "z": ours.Z_AUTO}
    e = solve(n, h, kernel=found, border_x=x, border_y=y, **auto)
    settings = fixed(n, h)
    best = min(settings, key=settings.get)
    times = e / settings[best]
    told = solve(n, h, kernel=NAMES.index(kernel), border_x=border, border_y=border, **auto)
    why = cause(n, h, MOST * settings[best], best, borders, found) if times > MOST else ""
    row = f"{name:34}{kernel:9}{damage:9}{e:8.3f}{settings[best]:8.3f}{times:6.1f}  "
    row += f"{NAMES[found]} {BORDERS[x]} {BORDERS[y]}, best {best[0]} {BORDERS[best[1]]}: {why}"
    sure_wrong = bool(decided) and NAMES[found] != kernel
    return times, told / settings[best], why, sure_wrong, row


def compare(seeds):
    maps = itertools.chain.from_iterable(map(made, seeds)) if seeds else real()
    cases = [(name, k, damage, n, h) for name, k, n, h in maps for damage in DAMAGED]
    print(f"{'map, kernel, damage: error with auto, best of 22, ratio':69}found, best: cause")
    with ProcessPoolExecutor() as pool:
        rows = list(pool.map(judge, cases, chunksize=4))
    for times, _, _, wrong, row in rows:
        if times > MOST or wrong:
            print(row + ("  SURE AND WRONG" if wrong else ""))
    causes = Counter(why for _, _, why, _, _ in rows if why)
    times, told = np.array([row[:2] for row in rows]).T
    print(
        f"{(times > MOST).sum()} of {len(rows)} have more than {MOST} times the error of the best"
        f" (geometric mean {np.exp(np.log(times).mean()):.3f}, at most {times.max():.1f});"
        f" sure of a wrong kernel: {sum(w for _, _, _, w, _ in rows)}"
    )
    print(
        f"told the kernel and the borders, {(told > MOST).sum()} have, at most {told.max():.1f} times"
    )
    print(", ".join(f"{name}: {count}" for name, count in causes.most_common()))
