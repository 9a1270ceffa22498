# SPDX-License-Identifier: MIT
"""What the texels tell of the kernel and the borders that made a texture, as `ntp to-height` asks.

Borders: the heights are made without regard to the slopes at the edges; then the normals that each
border would give there are compared with the stored ones.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import HEIGHT, view
from ._errors import CancelledError, Status
from ._native import ffi, lib
from ._solve import Solver

_BORDERS = 5
_STRIP = 8  # lines along an edge, enough for every kernel that is tried
_ENDS = 4  # texels at the ends of a line: the other axis has borders too
# Levels of 8 bit by which normals of the right border may be off, rms; what fits nearly as well as
# the best is as good; noise at the edges does not speak against what tiles.
_MOST_ERROR = 3.0
_NEARLY, _NEARLY_LEVELS = 1.25, 0.05
_MUCH_WORSE = 1.5


def find_kernel(src: Any, touch_unused: int) -> int:
    """The kernel to reconstruct with."""
    origin = ffi.new("ntp_origin *")
    if lib.ntp_find_origin(origin, src, touch_unused) != Status.OK:
        return int(lib.NTP_KERNEL_CENTRAL)
    return int(origin.kernel)


def _free_border(kernel: int) -> int:
    """The border that supposes least: with it, slopes at the edge do not matter."""
    if kernel == lib.NTP_KERNEL_FORWARD:
        return int(lib.NTP_BORDER_CLAMP)
    return int(lib.NTP_BORDER_MIRROR)


def choose_borders(
    how: Any, asked: tuple[int, int], texture: NDArray[Any], src: Any, heights: Any, solver: Solver
) -> bool:
    """Sets the borders of `how`; -1 in `asked` is for the texels to tell.  Did it solve?"""
    method = how.method
    wrap, poisson = int(lib.NTP_BORDER_WRAP), lib.NTP_HEIGHT_POISSON_DCT
    fixed = asked[0] >= 0, asked[1] >= 0
    how.border_x, how.border_y = (max(border, wrap) for border in asked)
    if all(fixed) or method == lib.NTP_HEIGHT_FRANKOT_CHELLAPPA:
        return False
    seams = ffi.new("ntp_seam[2]")
    if method != poisson:
        lib.ntp_find_seams(seams, seams + 1, src, how.touch_unused)
    free = _free_border(how.kernel)
    wraps = bool(seams[0].wraps), bool(seams[1].wraps)
    found = [wrap if wraps[i] else free for i in (0, 1)]
    tried = False
    small = min(texture.shape[:2]) < 2 * _STRIP
    if method in (lib.NTP_HEIGHT_AUTO, poisson) and not small:
        tried = how.kernel != lib.NTP_KERNEL_BAKED
    if tried:
        first = ffi.new("ntp_height_options *", how[0])
        first.refine = first.detrend = first.measure = 0
        first.border_x = how.border_x if fixed[0] else free
        first.border_y = how.border_y if fixed[1] else free
        status = solver.solve(first, ffi.NULL, 0.0, 0.5)
        if status == Status.CANCELLED:
            raise CancelledError("height_from_normals: cancelled")
        if status == Status.OK:
            for i in (0, 1):
                found[i] = _by_edges(first, texture, src, heights, i == 1, wraps[i])
    for i, name in enumerate(("border_x", "border_y")):
        never = method == poisson and found[i] == wrap
        if not fixed[i]:
            setattr(how, name, free if never else found[i])
    return tried


def _by_edges(
    how: Any, texture: NDArray[Any], src: Any, heights: NDArray[np.float32], down: bool, wraps: bool
) -> int:
    """The border that fits best, and first of all what the whole texture speaks for."""
    wrap = int(lib.NTP_BORDER_WRAP)
    errors = [_edge_error(how, texture, src, heights, down, b) for b in range(_BORDERS)]
    told = [error for error in errors if error >= 0]
    best = min(told, default=-1.0)
    if told and best <= _MOST_ERROR:
        likely = wrap if wraps else int(lib.NTP_BORDER_EXTRAPOLATE)
        as_good = 0 <= errors[likely] <= _NEARLY * best + _NEARLY_LEVELS
        return likely if as_good else errors.index(best)
    if wraps and told and 0 <= errors[wrap] <= _MUCH_WORSE * best:
        return wrap
    return _free_border(how.kernel)


def _edge_error(
    how: Any, texture: NDArray[Any], src: Any, heights: NDArray[np.float32], down: bool, border: int
) -> float:
    """The rms error of both edges in levels of 8 bit; negative: cannot be told."""
    options = ffi.new("ntp_height_options *", how[0])
    options.border_x = options.border_y = border
    if lib.ntp_height_scratch_size(options, src.width, src.height, 1) == 0:
        return -1.0
    wraps = border == lib.NTP_BORDER_WRAP
    total, count = 0.0, 0
    axis = 0 if down else 1
    lines = texture.shape[axis]
    for line in (0, lines - 1):
        if wraps:  # the last lines and the first ones beside each other
            indices = np.arange(-_STRIP // 2, _STRIP // 2) % lines
            at = _STRIP // 2 if line == 0 else _STRIP // 2 - 1
        else:
            indices = np.arange(_STRIP) if line == 0 else np.arange(lines - _STRIP, lines)
            at = 0 if line == 0 else _STRIP - 1
        strip = np.ascontiguousarray(np.take(heights, indices, axis))
        made = _normals_of(strip, texture, src, how, lib.NTP_BORDER_CLAMP if wraps else border)
        if made is None:
            return -1.0
        ours, theirs = np.take(made, at, axis), np.take(texture, line, axis)
        ours, theirs = (_unit(part[_ENDS:-_ENDS]) for part in (ours, theirs))
        used = _is_used(theirs)
        total += float(((ours - theirs)[used, :2] ** 2).sum())
        count += 2 * int(np.count_nonzero(used))
    scale = 127.5 if src.encoding == lib.NTP_VECTOR else 255.0
    return math.sqrt(total / count) * scale if count else -1.0


def _normals_of(
    strip: NDArray[np.float32], texture: NDArray[Any], src: Any, how: Any, border: int
) -> NDArray[Any] | None:
    made = np.empty((*strip.shape, texture.shape[2]), texture.dtype)
    gradient = ffi.new("ntp_gradient_options *")
    gradient.scale, gradient.dx, gradient.dy, gradient.kernel = 1.0, how.dx, how.dy, how.kernel
    gradient.border_x = gradient.border_y = border
    dst = view("out", made, src.encoding, src.y, writable=True)
    height = view("height", strip, HEIGHT)
    status = lib.ntp_normals_from_height(dst, height, gradient, ffi.NULL, ffi.NULL)
    return made if status == Status.OK else None


def _unit(samples: NDArray[Any]) -> NDArray[np.float64]:
    """Samples in 0..1, or as they are."""
    most = 1.0 if samples.dtype.kind == "f" else float(np.iinfo(samples.dtype).max)
    return samples.astype(np.float64) / most


def _is_used(samples: NDArray[np.float64]) -> NDArray[np.bool_]:
    r, g = samples[:, 0], samples[:, 1]
    used: NDArray[np.bool_] = np.isfinite(r) & np.isfinite(g) & ~(((r <= 0) | (r >= 1)) & (r == g))
    return used & (samples[:, 3] > 0) if samples.shape[1] == 4 else used
