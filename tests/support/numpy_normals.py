# SPDX-License-Identifier: MIT
"""Heights -> normals by numpy's own means, as a script would make them: no code of libntp, no oracle.

Slopes come from np.gradient, np.diff, or a correlation with a kernel; borders from np.pad.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

BORDERS = ["wrap", "clamp", "mirror", "extrapolate", "repeat-slope"]
PADS = {"wrap": "wrap", "clamp": "edge", "mirror": "reflect"}

# The slope to the right, as the difference of a column right and one left of the texel.
WINDOWS = {
    "prewitt3": np.outer([1, 1, 1], [-1, 0, 1]) / 6,
    "sobel3": np.array([[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]]) / 8,
    "scharr3": np.array([[-3, 0, 3], [-10, 0, 10], [-3, 0, 3]]) / 32,
    "prewitt5": np.outer(np.ones(5), [-1, -2, 0, 2, 1]) / 40,
    "sobel5": np.outer([1, 4, 6, 4, 1], [-1, -2, 0, 2, 1]) / 128,
}
KERNELS = ["central", "forward", *WINDOWS]


def longer(h, reach, border, axis):
    """More heights before and after, along one axis."""
    width = [(0, 0), (0, 0)]
    width[axis] = (reach, reach)
    if border in PADS:
        return np.pad(h, width, PADS[border])
    ends = np.moveaxis(h, axis, 0)  # a straight line goes on
    k = np.arange(1, reach + 1)[:, None]
    before = ends[0] + (ends[0] - ends[1]) * k[::-1]
    after = ends[-1] + (ends[-1] - ends[-2]) * k
    return np.moveaxis(np.concatenate([before, ends, after]), 0, axis)


def by_window(h, window, borders):
    """A correlation; borders (of x, of y).  A slope is repeated by padding the slopes."""
    reach = window.shape[0] // 2
    repeated = [b == "repeat-slope" for b in borders]
    for axis, border in ((1, borders[0]), (0, borders[1])):
        if border != "repeat-slope":
            h = longer(h, reach, border, axis)
    out = np.einsum("yxij,ij->yx", sliding_window_view(h, window.shape), window)
    pads = [(reach * repeated[1],) * 2, (reach * repeated[0],) * 2]
    return np.pad(out, pads, "edge")


def slope_along(h, kernel, borders, axis):
    """Towards greater indices."""
    if kernel in WINDOWS:
        window = WINDOWS[kernel]
        return by_window(h, window if axis == 1 else window.T, borders)
    border = borders[1 - axis]
    if kernel == "central":
        if border in ("extrapolate", "repeat-slope"):
            out = np.gradient(h, axis=axis)
            if border == "repeat-slope":
                inside = np.take(out, range(1, h.shape[axis] - 1), axis)
                out = np.pad(inside, [(1, 1) if a == axis else (0, 0) for a in (0, 1)], "edge")
            return out
        inside = range(1, h.shape[axis] + 1)
        return np.take(np.gradient(longer(h, 1, border, axis), axis=axis), inside, axis)
    if border == "repeat-slope":
        step = np.diff(h, axis=axis)
        return np.concatenate([step, np.take(step, [-1], axis)], axis)
    step = np.diff(longer(h, 1, border, axis), axis=axis)
    return np.take(step, range(1, h.shape[axis] + 1), axis)


def vectors(p, q):
    """Unit normals of slopes p to the right and q down the picture; y up."""
    n = np.dstack([-p, q, np.ones_like(p)])
    return n / np.linalg.norm(n, axis=2, keepdims=True)


def levels(n, dtype=np.uint8):
    m = np.iinfo(dtype).max
    return np.rint((n + 1) * (m / 2)).astype(dtype)


def normals(h, kernel="central", border_x="wrap", border_y=None, dtype=np.uint8):
    """A texture of heights that are measured in texels."""
    h = np.asarray(h, np.float64)
    borders = border_x, border_y or border_x
    p, q = (slope_along(h, kernel, borders, axis) for axis in (1, 0))
    return levels(vectors(p, q), dtype)
