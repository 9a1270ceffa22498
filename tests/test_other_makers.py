# SPDX-License-Identifier: MIT
"""Kernel, border, seam and steps of normals that numpy and OpenCV made, not the library.

Otherwise the library could be wrong in the same way when it makes and when it detects.  Here
heights become normals by support/numpy_normals.py, and by OpenCV's own Sobel and Scharr where that
is installed.
"""

import itertools

import numpy as np
import pytest

from support import drawn_surfaces, numpy_normals, surfaces
from support import libntp_ffi as ntp
from support.find import find_border, find_kernel, find_seams
from support.oracle_height import NAMES
from support.to_height import from_height, to_height

BORDERS = numpy_normals.BORDERS
WRAP, CLAMP, MIRROR, EXTRAPOLATE, REPEAT_SLOPE = range(5)
KERNELS = [*NAMES, "baked"]
DEPTHS = [np.uint8, np.uint16]
# One stands for two: their slopes differ by a blur of the heights, which no texture shows.
CALLED = {"sobel5": "sobel3"}


def scaled(h, slope):
    """With that mean slope."""
    q, p = np.gradient(h)
    return h * (slope / np.hypot(p, q).mean())


def open_heights(seed, h=256, w=256, slope=0.5):
    """Their opposite edges are independent."""
    return scaled(drawn_surfaces.octaves(np.random.default_rng(seed), h, w), slope)


def closed_heights(seed, h=256, w=256, slope=0.5):
    """They tile, and are smooth where they do."""
    return scaled(surfaces.fft_noise(np.random.default_rng(seed), h, w, 2.2), slope)


# ------------------------------------------------------------------------------ the maker


@pytest.mark.parametrize("dtype", DEPTHS)
@pytest.mark.parametrize("kernel", numpy_normals.KERNELS)
def test_numpy_and_the_library_make_the_same(kernel, dtype):
    """Except for slopes near 0, where the sign of a sum of floats is random."""
    h = np.float32(open_heights(3, 53, 61))
    for x in range(5):
        for y in range(5):
            ours = from_height(h, kernel, x, y, dst=dtype)[..., :2].astype(int)
            theirs = numpy_normals.normals(h, kernel, BORDERS[x], BORDERS[y], dtype)[..., :2]
            off = np.abs(ours - theirs)
            assert off.max() <= 1 and np.mean(off > 0) < 0.01, (BORDERS[x], BORDERS[y])
            middle = np.iinfo(dtype).max / 2
            assert np.all(np.abs(theirs[off > 0] - middle) < 1)


# ----------------------------------------------------------------------------- the kernel


@pytest.mark.parametrize("dtype", DEPTHS)
@pytest.mark.parametrize("heights", [open_heights, closed_heights])
@pytest.mark.parametrize("kernel", numpy_normals.KERNELS)
def test_the_kernel_is_found(kernel, heights, dtype):
    for size, border in ((200, "wrap"), (256, "clamp"), (333, "repeat-slope")):
        n = numpy_normals.normals(heights(size, size, size + 7), kernel, border, dtype=dtype)
        found = find_kernel(n)
        assert found["decided"], found
        assert KERNELS[found["kernel"]] == CALLED.get(kernel, kernel)
        assert 0.9 < found["misfit"][found["kernel"]] < 1.1
        others = [m for k, m in enumerate(found["misfit"]) if k != found["kernel"] and m >= 0]
        assert len(others) >= 5 and min(others) > 1.1


@pytest.mark.parametrize("dtype", DEPTHS)
@pytest.mark.parametrize("kernel", [k for k in numpy_normals.KERNELS if k != "sobel5"])
def test_smooth_surfaces_are_left_open_rather_than_called_wrong(kernel, dtype):
    """The smoother they are, the more similar are the normals of different kernels."""
    for falling, slope in itertools.product((3, 4, 4.5, 5, 6), (0.1, 0.5, 1.5)):
        rng = np.random.default_rng(int(falling * 10))
        h = scaled(surfaces.fft_noise(rng, 192, 192, falling), slope)
        found = find_kernel(numpy_normals.normals(h, kernel, dtype=dtype))
        assert not found["decided"] or KERNELS[found["kernel"]] == kernel, (falling, slope)


def test_the_kernel_of_normals_that_point_down_in_green():
    n = numpy_normals.normals(open_heights(1), "scharr3")
    n[..., 1] = 255 - n[..., 1]
    found = find_kernel(n, ntp.DOWN)
    assert found["decided"] and KERNELS[found["kernel"]] == "scharr3"
    assert not find_kernel(n, ntp.UP)["decided"]


def shifted(h, x, y):
    return np.roll(h, (-y, -x), (0, 1))


def spectral(h):
    """Derivatives of the waves that the heights are made of."""
    f = 2j * np.pi * np.fft.fftfreq(len(h))
    return [np.fft.ifft2(np.fft.fft2(h) * g).real for g in (f[None, :], f[:, None])]


# Slopes (p, q) by operators that the library does not know.
OTHERS = {
    "backward": lambda h: (h - shifted(h, -1, 0), h - shifted(h, 0, -1)),
    "five points": lambda h: [
        (8 * (shifted(h, x, y) - shifted(h, -x, -y)) - shifted(h, 2 * x, 2 * y)
         + shifted(h, -2 * x, -2 * y)) / 12 for x, y in ((1, 0), (0, 1))
    ],
    "spectral": spectral,
    "of each axis another": lambda h: (
        numpy_normals.slope_along(h, "sobel3", ("wrap", "wrap"), 1),
        numpy_normals.slope_along(h, "central", ("wrap", "wrap"), 0),
    ),
    "of two surfaces": lambda h: (
        numpy_normals.slope_along(h, "sobel3", ("wrap", "wrap"), 1),
        numpy_normals.slope_along(h.T, "sobel3", ("wrap", "wrap"), 0),
    ),
}  # fmt: skip


@pytest.mark.parametrize("dtype", DEPTHS)
@pytest.mark.parametrize("operator", OTHERS)
def test_no_kernel_is_claimed_of_another_operator(operator, dtype):
    p, q = OTHERS[operator](closed_heights(4))
    found = find_kernel(numpy_normals.levels(numpy_normals.vectors(p, q), dtype))
    assert not found["decided"], found


@pytest.mark.parametrize("surface", ["domes", "weave", "studs", "cobbles"])
def test_no_kernel_is_claimed_of_formulas(surface):
    n = getattr(drawn_surfaces, surface)(np.random.default_rng(1), 256, 256)
    found = find_kernel(numpy_normals.levels(n))
    assert not found["decided"], found


def test_differences_of_two_by_two_are_called_sobel():
    """As Sobel of other heights would be: their two slopes agree in the same way."""
    h = closed_heights(4)
    a, b, c = shifted(h, 1, 0), shifted(h, 0, 1), shifted(h, 1, 1)
    n = numpy_normals.levels(numpy_normals.vectors((a + c - h - b) / 2, (b + c - h - a) / 2))
    found = find_kernel(n)
    assert found["decided"] and KERNELS[found["kernel"]] == "sobel3"


# ------------------------------------------------------------------------------- the seam


def both_ways(n):
    return [(s["decided"], s["tiles"], s["wraps"]) for s in find_seams(n)]


@pytest.mark.parametrize("dtype", DEPTHS)
@pytest.mark.parametrize("kernel", numpy_normals.KERNELS)
def test_seams(kernel, dtype):
    seams = 0
    for seed in range(4):
        closed = np.roll(closed_heights(seed, 200, 240), (37, 91), (0, 1))
        assert both_ways(numpy_normals.normals(closed, kernel, dtype=dtype)) == [(1, 1, 1)] * 2
        n = numpy_normals.normals(open_heights(seed, 200, 240), kernel, "repeat-slope", dtype=dtype)
        for decided, tiles, wraps in both_ways(n):
            assert not tiles and not wraps
            seams += decided
    assert seams >= 2  # of 8; the others are left open


@pytest.mark.parametrize("kernel", ["central", "sobel3"])
def test_what_is_mirrored_tiles_along_that_axis(kernel):
    for seed in range(3):
        half = open_heights(seed, 256, 128)
        n = numpy_normals.normals(np.hstack([half, half[:, ::-1]]), kernel, "clamp")
        across, down = both_ways(n)
        assert across == (1, 1, 1)
        assert not down[1]


@pytest.mark.parametrize("dtype", DEPTHS)
def test_what_leans_does_not_wrap(dtype):
    """The normals repeat, the heights climb; many stay undecided, and none is a seam."""
    for seed, lean in itertools.product(range(4), (0.1, -0.3)):
        h = closed_heights(seed)
        p, q = (numpy_normals.slope_along(h, "central", ("wrap", "wrap"), axis) for axis in (1, 0))
        n = numpy_normals.levels(numpy_normals.vectors(p, q + lean), dtype)
        across, down = find_seams(n)
        assert across["wraps"] and not down["wraps"]
        assert down["lean"] == pytest.approx(lean, abs=2e-4)
        assert down["tiles"] == down["decided"] and (down["decided"] or lean != 0.1)


# ----------------------------------------------------------------------------- the border

FITTED = [
    (kernel, border)
    for kernel in ("central", "forward", "prewitt3", "sobel3", "scharr3")
    for border in BORDERS
    # Least squares take no such border of these, so that it is not tried.
    if kernel in ("central", "forward") or border not in ("extrapolate", "repeat-slope")
    if (kernel, border) != ("central", "repeat-slope")
]


@pytest.mark.parametrize("dtype", DEPTHS)
@pytest.mark.parametrize(("kernel", "border"), FITTED)
def test_the_border_is_found(kernel, border, dtype):
    """With the original heights, and with those that the library reconstructs from the texture."""
    h = closed_heights(7, 150, 160) if border == "wrap" else open_heights(7, 150, 160)
    n = numpy_normals.normals(h, kernel, border, dtype=dtype)
    number = NAMES.index(kernel)
    free = ntp.lib.ntp_free_border(number)
    solved = to_height(n, kernel=number, border_x=free, border_y=free)[0]
    # Of forward, a slope that is repeated is the one of a line that goes on.
    told = "extrapolate" if (kernel, border) == ("forward", "repeat-slope") else border
    for heights, worst in ((np.float32(h), 2), (solved, 2.5)):
        for down in (0, 1):
            found = find_border(n, heights, number, down, wraps=int(border == "wrap"))
            assert found["decided"] and BORDERS[found["border"]] == told, found
            assert found["error"][found["border"]] < worst


@pytest.mark.parametrize(
    ("kernel", "border"), [("central", "repeat-slope"), ("sobel3", "extrapolate")]
)
def test_a_border_that_is_not_tried_is_no_other(kernel, border):
    h = open_heights(7, 150, 160)
    n = numpy_normals.normals(h, kernel, border)
    for down in (0, 1):
        found = find_border(n, np.float32(h), NAMES.index(kernel), down)
        assert not found["decided"] and BORDERS[found["border"]] == "mirror"


# ------------------------------------------------------------------------------ the steps


@pytest.mark.parametrize("kernel", ["central", "forward", "prewitt3", "sobel3", "scharr3"])
@pytest.mark.parametrize("levels", [255, 1023])
def test_steps_of_whole_heights(kernel, levels):
    """The step is that of one level of height, over the kernel's divisor."""
    divisor = {"central": 2, "forward": 1, "prewitt3": 6, "sobel3": 8, "scharr3": 32}[kernel]
    h = open_heights(3)
    h = np.rint((h - h.min()) / np.ptp(h) * levels)
    for rise in (20 / 255, 40 / 255):
        found = ntp.find_steps(numpy_normals.normals(h * rise, kernel, "mirror", dtype=np.uint16))
        assert found["decided"], rise
        assert found["slope"] == pytest.approx(rise / divisor, rel=1e-3)


@pytest.mark.parametrize("dtype", DEPTHS)
@pytest.mark.parametrize("kernel", ["central", "forward", "sobel3"])
def test_no_steps_of_heights_that_are_not_whole(kernel, dtype):
    for heights in (open_heights, closed_heights):
        for slope in (0.1, 0.5, 2):
            n = numpy_normals.normals(heights(3, slope=slope), kernel, "mirror", dtype=dtype)
            assert not ntp.find_steps(n)["decided"]


@pytest.mark.parametrize("dtype", DEPTHS)
@pytest.mark.parametrize(
    "surface", [s for s in drawn_surfaces.SURFACES if s.__name__ != "lettered"]
)
def test_no_steps_of_surfaces_with_few_angles(surface, dtype):
    """Nor of curved ones.  (Letters have few heights: theirs are steps.)"""
    for seed in range(6):
        n = surface(np.random.default_rng(seed), 200, 200)
        assert not ntp.find_steps(numpy_normals.levels(n, dtype))["decided"], seed


# --------------------------------------------------------------------------------- OpenCV

CV_BORDERS = {"clamp": "BORDER_REPLICATE", "mirror": "BORDER_REFLECT_101"}


def by_opencv(cv2, h, kernel, border):
    h = np.float32(h)
    if border == "wrap":
        h = cv2.copyMakeBorder(h, 2, 2, 2, 2, cv2.BORDER_WRAP)
    how = {"borderType": getattr(cv2, CV_BORDERS.get(border, "BORDER_REPLICATE"))}
    size, divisor = {"central": (1, 2), "sobel3": (3, 8), "scharr3": (-1, 32), "sobel5": (5, 128)}[
        kernel
    ]
    slopes = [
        cv2.Sobel(h, cv2.CV_32F, x, 1 - x, ksize=size, scale=1 / divisor, **how) for x in (1, 0)
    ]
    if border == "wrap":
        slopes = [s[2:-2, 2:-2] for s in slopes]
    return numpy_normals.levels(numpy_normals.vectors(*np.float64(slopes)))


@pytest.mark.parametrize("kernel", ["central", "sobel3", "scharr3", "sobel5"])
@pytest.mark.parametrize("border", ["wrap", "clamp", "mirror"])
def test_opencv(kernel, border):
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    h = closed_heights(7, 150, 160) if border == "wrap" else open_heights(7, 150, 160)
    n = by_opencv(cv2, h, kernel, border)
    number = BORDERS.index(border)
    off = np.abs(from_height(np.float32(h), kernel, number, number).astype(int) - n)[..., :2]
    assert off.max() <= 1 and np.mean(off > 0) < 0.01
    found = find_kernel(n)
    assert found["decided"] and KERNELS[found["kernel"]] == CALLED.get(kernel, kernel)
    assert both_ways(n)[0][1] == (border == "wrap")
    if kernel != "sobel5":
        for down in (0, 1):
            wraps = int(border == "wrap")
            edges = find_border(n, np.float32(h), NAMES.index(kernel), down, wraps=wraps)
            assert edges["decided"] and BORDERS[edges["border"]] == border
