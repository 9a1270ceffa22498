# SPDX-License-Identifier: MIT
"""Normals turned, mirrored, made stronger: the vectors turn with the picture."""

from collections.abc import Iterable
from typing import Any, Literal, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import Output, choose, number, pixels, view
from ._errors import check
from ._green import choose_y, known, slopes, told
from ._names import TYPES
from ._native import ffi, lib
from ._resize import edges
from ._threads import QUICK, THOROUGH, run
from ._undo import resolve_sound
from .typing import (
    AnyPixels,
    AutoStored,
    AutoType,
    AutoY,
    Flip,
    Floats,
    ResizeBorder,
    SampleT,
    TransformHow,
    Type,
    Y,
)

_FLIPS = {None: (0, 0), "x": (1, 0), "y": (0, 1), "xy": (1, 1)}


def _green_of_turn(source: NDArray[Any], type: Type, y: AutoY, turns: int, threads: int) -> Y:
    """The argument `y` of `transform`, which only turns need that exchange or mix x and y."""
    if turns % 2 == 0:
        return told("y", y) or "up"
    needed = told("y", y) is None and any(slopes(source, type))
    return known("y", y, source, type, threads, needed)


@overload
def transform(
    src: Floats,
    *,
    type: Literal["vector"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[TransformHow],
) -> NDArray[np.float32]: ...


@overload
def transform(
    src: NDArray[SampleT],
    *,
    type: AutoStored = ...,
    out: NDArray[SampleT] | None = ...,
    **how: Unpack[TransformHow],
) -> NDArray[SampleT]: ...


def transform(
    src: AnyPixels | Floats,
    *,
    strength: float | None = None,
    flip: Flip | None = None,
    rotate: float = 0,
    border: ResizeBorder = "wrap",
    border_x: ResizeBorder | None = None,
    border_y: ResizeBorder | None = None,
    type: AutoType = "auto",
    y: AutoY = "auto",
    out: NDArray[Any] | None = None,
    threads: int = 1,
) -> NDArray[Any]:
    """Flip and turn a texture, pixels and vectors together, and make its bumps stronger.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    strength : float, optional
        Multiply the slopes, -1024..1024; -1 turns bumps into dents.
    flip : {"x", "y", "xy"}, optional
        "x": exchange left and right; "y": exchange top and bottom; done before `rotate`.
    rotate : float
        Turn clockwise by this many degrees, -360..360.  By other angles than multiples of 90 the
        texture is turned about its middle, keeps its size, and is resampled.
    border, border_x, border_y : {"wrap", "clamp", "mirror"}
        What such a turn brings in from beyond the edges.
    type : {"auto", "standard", "zzero", "xy", "vector"}
        How a normal is stored; "auto" detects it from the texels, as `ntp transform` does.
    y : {"auto", "up", "down", "opengl", "directx"}
        Which way green points, on which turns depend, but not by 180 degrees.  "auto": as the
        texels show it; if they are not sure, turning a texture that is not flat is an
        ArgumentError.
    out : array, optional
        Where to write; it does not overlap `src`.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array, samples and channels as in `src`
        Flips, turns by multiples of 90 degrees and a strength of 1 or -1 are exact; with these
        turns, unused texels move but keep their color.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texture = np.array([[[200, 128, 231], [128, 128, 255]]], np.uint8)
    >>> nt.transform(texture, flip="x", type="standard")
    array([[[127, 128, 255],
            [ 55, 128, 231]]], dtype=uint8)
    """
    source = pixels("src", src, type)
    if type == "auto":
        type = resolve_sound(source, type, threads)
    encoding = choose("type", type, TYPES)
    view("src", source, encoding)
    flips = choose("flip", flip, _FLIPS)
    angle = number("rotate", rotate, -lib.NTP_MAX_ANGLE, lib.NTP_MAX_ANGLE)
    turns = lib.ntp_quarter_turns(angle)
    up = choose_y("y", _green_of_turn(source, type, y, turns, threads))
    src_view = view("src", source, encoding, up)
    most = lib.NTP_MAX_STRENGTH
    factor = 1.0 if strength is None else number("strength", strength, -most, most)
    sides = edges(border, border_x, border_y)
    how = ffi.new(
        "ntp_transform_options *", (*flips, 0, strength is not None, factor, angle, *sides)
    )
    height, width = source.shape[:2]
    if turns in (1, 3):
        width, height = height, width
    output = Output((height, width, source.shape[2]), source.dtype, out)
    if out is not None:
        output.apart_from(False, src=source)
    dst = view("out", output.array, encoding, up, writable=True)

    def work(areas: Iterable[Any]) -> None:
        for area in areas:
            check(lib.ntp_transform(dst, src_view, how, area), "transform")

    run(threads, width, height, work, QUICK if factor in (1, -1) and turns >= 0 else THOROUGH)
    result: NDArray[Any] = output.finish()
    return result
