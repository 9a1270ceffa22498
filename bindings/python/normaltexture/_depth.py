# SPDX-License-Identifier: MIT
"""Depth of objects from their normals, with cliffs and a camera."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import Output, choose, memory, number, pixels, view
from ._errors import ArgumentError, Status, check
from ._green import choose_y, known_or_up
from ._names import AUTO, HEIGHT, TOUCH_ALL, TOUCH_NONE, TYPES
from ._native import ffi, lib
from ._reconstruct import mask_of
from ._solve import SCRATCH_ALIGNMENT, Callbacks
from ._undo import sound_object
from .typing import AnyPixels, AutoType, AutoY, Floats, Mask

_FLOAT = np.dtype(np.float32)
_MOST = 1 << 20  # texels, of a camera


def depth_from_normals(
    normals: AnyPixels | Floats,
    mask: Mask | None = None,
    camera: Sequence[float] | None = None,
    *,
    type: AutoType = "auto",
    y: AutoY = "auto",
    k: float = 2.0,
    rounds: int = 33,
    start: NDArray[np.float32] | None = None,
    touch_unused: bool = False,
    progress: Callable[[float], object] | None = None,
    out: NDArray[np.float32] | None = None,
) -> NDArray[np.float32]:
    """Find the depth of an object from its normals, also where one part hides another.

    It is for normals as photometric stereo measures them; textures are for `height_from_normals`.

    Parameters
    ----------
    normals : array, (height, width, channels), uint8, uint16, float32 or float64
        x to the right, y up or down, z towards the viewer.  They are read as 16 bit.
    mask : array, (height, width), bool, uint8 or uint16, optional
        There is no surface where it is 0.
    camera : (fx, fy, cx, cy), optional
        Focal lengths, and where the axis meets the picture, in texels; the middle of the first texel
        is (0, 0).  None: orthographic.
    type : {"auto", "standard", "zzero", "xy", "vector"}
        How a normal is stored.  Auto: floats are vectors of -1 to 1, integers are "standard" unless
        the texels are surely something else; what is surely no picture of normals is refused.
    y : {"auto", "up", "down"}
        Which way y points, also "opengl" and "directx".  Auto: as the texels show, if that is sure;
        up where nothing says down; else a question.
    k : float
        How readily a cliff is seen: 2 in the paper.
    rounds : int
        At most; 1 is least squares, which know no cliffs.
    start : array, (height, width), float32, optional
        Depth to begin with, such as that of the last picture of a film.
    touch_unused : bool
        Use pure black, pure white and transparent texels like any other.
    progress : callable, optional
        Called now and then with the share done, 0..1; returning False stops.
    out : array, (height, width), float32, optional
        Where to write; it does not overlap `normals`.

    Returns
    -------
    array, (height, width), float32
        Greater is farther; NaN where there is no surface.  Without a camera it is in texels, and
        each island has mean 0.  With a camera it is positive, and each island has a scale of its
        own: the mean of the logarithm is 0.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.
    CancelledError
        If `progress` returned False.

    Notes
    -----
    docs/depth.md says how it works and how good it is.  Source: X. Cao, H. Santo, B. Shi, F. Okura,
    Y. Matsushita, "Bilateral Normal Integration" (ECCV 2022).

    Examples
    --------
    >>> import normaltexture as nt
    >>> normals = np.zeros((40, 60, 3))
    >>> normals[...] = 0.6, 0, 0.8  # it rises to the left by 3/4
    >>> depth = nt.depth_from_normals(normals)
    >>> bool(abs(depth[0, 59] - depth[0, 0] - 59 * 0.75) < 0.01)
    True
    """
    return _depth(
        normals, mask, camera, type, y, k, rounds, start, touch_unused, progress, out, False
    )[0]


def depth_from_normals_with_confidence(
    normals: AnyPixels | Floats,
    mask: Mask | None = None,
    camera: Sequence[float] | None = None,
    *,
    type: AutoType = "auto",
    y: AutoY = "auto",
    k: float = 2.0,
    rounds: int = 33,
    start: NDArray[np.float32] | None = None,
    touch_unused: bool = False,
    progress: Callable[[float], object] | None = None,
    out: NDArray[np.float32] | None = None,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Find the depth of an object, and how sure it is at each texel.

    It takes about twice as long as `depth_from_normals`.

    Parameters
    ----------
    normals, mask, camera, type, y, k, rounds, start, touch_unused, progress, out
        As in `depth_from_normals`.

    Returns
    -------
    (depth, confidence) : arrays, (height, width), float32
        The confidence is 1/(1 + e), e the error that may be expected, in texels; with a camera fx
        times that of the depth.  It ranks texels and is no bound.  0: there is no surface.

    Raises
    ------
    ArgumentError, SampleTypeError, CancelledError
        As `depth_from_normals`.

    Examples
    --------
    >>> import normaltexture as nt
    >>> normals = np.zeros((40, 60, 3))
    >>> normals[...] = 0, 0, 1
    >>> depth, confidence = nt.depth_from_normals_with_confidence(normals, camera=(60, 60, 30, 20))
    >>> bool(confidence.min() > 0.9)
    True
    """
    depth, confidence = _depth(
        normals, mask, camera, type, y, k, rounds, start, touch_unused, progress, out, True
    )
    assert confidence is not None
    return depth, confidence


def _depth(
    normals: AnyPixels | Floats,
    mask: Mask | None,
    camera: Sequence[float] | None,
    type: AutoType,
    y: AutoY,
    k: float,
    rounds: int,
    start: NDArray[np.float32] | None,
    touch_unused: bool,
    progress: Callable[[float], object] | None,
    out: NDArray[np.float32] | None,
    sure: bool,
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
    if type == "auto" and np.asarray(normals).dtype.kind == "f":
        type = "vector"
    choose("type", type, {"auto": AUTO} | TYPES)
    source = pixels("normals", normals, type)
    stored = sound_object(source, "normals") if type == "auto" else type
    green = known_or_up(y, source, stored, "normals")
    src = view("normals", source, choose("type", stored, TYPES), choose_y("y", green))
    height, width = source.shape[:2]
    how = ffi.new("ntp_depth_options *")
    how.camera = _camera(camera)
    how.k = number("k", k, 2.0**-20, 2.0**20)
    how.rounds = int(number("rounds", rounds, 1, lib.NTP_MAX_ITERATIONS))
    how.touch_unused = TOUCH_ALL if touch_unused else TOUCH_NONE
    owners: list[Any] = []
    if mask is not None:
        owners.append(mask_of(mask, source))
        owners.append(view("mask", owners[-1], HEIGHT))
        how.mask = owners[-1]
    if start is not None:
        begin = np.ascontiguousarray(start, _FLOAT)
        if begin.shape != (height, width):
            raise ArgumentError(
                f"start: must be {(height, width)}, not {begin.shape}", Status.SHAPE
            )
        owners += [begin, view("start", begin, HEIGHT)]
        how.start = owners[-1]
    output = Output((height, width), _FLOAT, out)
    if out is not None:
        output.apart_from(False, normals=source)
    confidence = np.empty((height, width), _FLOAT) if sure else None
    size = lib.ntp_depth_scratch_size(width, height)
    if size == 0:
        raise ArgumentError(
            f"normals: {width} x {height} are more than {lib.NTP_MAX_DEPTH_TEXELS} texels",
            Status.SHAPE,
        )
    callbacks = Callbacks(1, height * width, progress)
    handle = ffi.new_handle(callbacks)
    scratch, owner = memory(size, SCRATCH_ALIGNMENT)
    status = lib.ntp_depth_from_normals(
        view("out", output.array, HEIGHT, writable=True),
        ffi.NULL if confidence is None else view("confidence", confidence, HEIGHT, writable=True),
        src,
        how,
        scratch,
        size,
        callbacks.hooks(handle, False),
        ffi.NULL,
    )
    del owner, owners
    callbacks.check()
    check(status, "depth_from_normals")
    depth: NDArray[np.float32] = output.finish()
    return depth, confidence


def _camera(camera: Sequence[float] | None) -> dict[str, float]:
    if camera is None:
        return {}
    values = [float(value) for value in camera]
    names = ("fx", "fy", "cx", "cy")
    within = all(abs(value) <= _MOST for value in values)  # which NaN is not
    if len(values) != 4 or not within or min(values[:2]) < 1 / 1024:
        raise ArgumentError(
            f"camera={camera!r}: must be four numbers fx, fy, cx, cy up to {_MOST}, with fx and fy"
            " above 0.001"
        )
    return dict(zip(names, values, strict=True))
