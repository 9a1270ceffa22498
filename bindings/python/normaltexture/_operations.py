# SPDX-License-Identifier: MIT
"""Operations that keep every texel a unit vector: resizing, mip chains, turning, blending."""

import re
from collections.abc import Iterable
from typing import Any, Literal, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import MAX_SIDE, Output, choose, memory, number, pixels, view
from ._errors import ArgumentError, check
from ._green import choose_y, find, known, question, slopes, told
from ._names import BLEND_MODES, FILTERS, RESIZE_BORDERS, TOUCH_ALL, TOUCH_NONE, TYPES
from ._native import ffi, lib
from ._threads import QUICK, THOROUGH, run
from ._undo import resolve_sound
from .typing import (
    AnyPixels,
    AutoStored,
    AutoType,
    AutoY,
    BlendHow,
    BlendMode,
    Filter,
    Flip,
    Floats,
    ResizeBorder,
    ResizeHow,
    SampleT,
    Size,
    SizedHow,
    TransformHow,
    Type,
    Y,
)

_FLIPS = {None: (0, 0), "x": (1, 0), "y": (0, 1), "xy": (1, 1)}


def _size(size: Size, width: int, height: int) -> tuple[int, int]:
    """(width, height) of "512x256", "50%" or (512, 256)."""
    if isinstance(size, str):
        if match := re.fullmatch(r"(\d+)x(\d+)", size):
            sides = int(match[1]), int(match[2])
        elif match := re.fullmatch(r"(\d+(?:\.\d*)?|\.\d+)%", size):
            # rounded half up, at least 1, as on the command line
            share = float(match[1])
            sides = (
                max(1, int(width * share / 100 + 0.5)),
                max(1, int(height * share / 100 + 0.5)),
            )
        else:
            raise ArgumentError(f"size={size!r}: must be (width, height), 'WxH' or 'P%'")
    else:
        try:
            sides = int(size[0]), int(size[1])
        except (TypeError, ValueError, IndexError):
            raise ArgumentError(f"size={size!r}: must be (width, height), 'WxH' or 'P%'") from None
    if not (1 <= sides[0] <= MAX_SIDE and 1 <= sides[1] <= MAX_SIDE):
        raise ArgumentError(f"size={size!r}: sides must be 1..{MAX_SIDE}")
    return sides


def resized(
    source: NDArray[Any], encoding: int, width: int, height: int, how: Any, out: Any, threads: int
) -> NDArray[Any]:
    src_view = view("src", source, encoding)
    shape = height, width, source.shape[2]
    output = Output(shape, source.dtype, out)
    if out is not None:
        output.apart_from(False, src=source)
    dst = view("out", output.array, encoding, writable=True)
    sides = source.shape[1], source.shape[0], width, height
    size = lib.ntp_resize_plan_size(how, *sides)
    room, owner = memory(size)
    plan = ffi.new("ntp_resize_plan **")
    check(lib.ntp_resize_plan_init(plan, room, size, how, *sides), "resize")
    scratch_size = lib.ntp_resize_scratch_size(plan[0])

    def work(areas: Iterable[Any]) -> None:
        scratch, scratch_owner = memory(scratch_size)
        for area in areas:
            status = lib.ntp_resize(dst, src_view, plan[0], scratch, scratch_size, area)
            check(status, "resize")
        del scratch_owner

    run(threads, width, height, work, THOROUGH)
    del owner
    result: NDArray[Any] = output.finish()
    return result


def _edges(
    border: ResizeBorder, border_x: ResizeBorder | None, border_y: ResizeBorder | None
) -> tuple[int, int]:
    return (
        choose("border_x" if border_x else "border", border_x or border, RESIZE_BORDERS),
        choose("border_y" if border_y else "border", border_y or border, RESIZE_BORDERS),
    )


def _resize_options(
    filter: Filter,
    border: ResizeBorder,
    border_x: ResizeBorder | None,
    border_y: ResizeBorder | None,
    touch_unused: bool,
) -> Any:
    return ffi.new(
        "ntp_resize_options *",
        (
            choose("filter", filter, FILTERS),
            *_edges(border, border_x, border_y),
            TOUCH_ALL if touch_unused else TOUCH_NONE,
        ),
    )


@overload
def resize(
    src: Floats,
    *,
    type: Literal["vector"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[SizedHow],
) -> NDArray[np.float32]: ...
@overload
def resize(
    src: NDArray[SampleT],
    *,
    type: AutoStored = ...,
    out: NDArray[SampleT] | None = ...,
    **how: Unpack[SizedHow],
) -> NDArray[SampleT]: ...
def resize(
    src: AnyPixels | Floats,
    *,
    size: Size,
    filter: Filter = "triangle",
    border: ResizeBorder = "wrap",
    border_x: ResizeBorder | None = None,
    border_y: ResizeBorder | None = None,
    type: AutoType = "auto",
    touch_unused: bool = False,
    out: NDArray[Any] | None = None,
    threads: int = 1,
) -> NDArray[Any]:
    """Resize a texture as vectors, weighted with alpha; every texel is a unit vector again.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    size : (width, height), or str
        The new size in texels, also as "512x256", or in percent of the old one: "50%".
    filter : {"box", "triangle", "lanczos3"}
        The mean over an area; bilinear; sharper, but can ring.
    border, border_x, border_y : {"wrap", "clamp", "mirror"}
        What lies beyond the edges; for both axes, or one.
    type : {"auto", "standard", "zzero", "xy", "vector"}
        How a normal is stored; "auto" detects it from the texels, as `ntp resize` does.
    touch_unused : bool
        Treat pure black, pure white and transparent texels like any other; alpha gives no weight.
    out : array, optional
        Where to write; it does not overlap `src`.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array of the new size, samples and channels as in `src`

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Notes
    -----
    docs/operations.md has the formulas.

    Examples
    --------
    >>> import normaltexture as nt
    >>> nt.resize(nt.read("wall_n.png"), size="50%").shape
    (32, 48, 3)
    """
    source = pixels("src", src, type)
    if type == "auto":
        type = resolve_sound(source, type, threads)
    encoding = choose("type", type, TYPES)
    view("src", source, encoding)
    how = _resize_options(filter, border, border_x, border_y, touch_unused)
    width, height = _size(size, source.shape[1], source.shape[0])
    return resized(source, encoding, width, height, how, out, threads)


@overload
def mip_chain(
    src: Floats,
    *,
    type: Literal["vector"],
    **how: Unpack[ResizeHow],
) -> list[NDArray[np.float32]]: ...
@overload
def mip_chain(
    src: NDArray[SampleT],
    *,
    type: AutoStored = ...,
    **how: Unpack[ResizeHow],
) -> list[NDArray[SampleT]]: ...
def mip_chain(
    src: AnyPixels | Floats,
    *,
    filter: Filter = "box",
    border: ResizeBorder = "wrap",
    border_x: ResizeBorder | None = None,
    border_y: ResizeBorder | None = None,
    type: AutoType = "auto",
    touch_unused: bool = False,
    threads: int = 1,
) -> list[NDArray[Any]]:
    """Make the full mip chain, down to 1 x 1, each level from the texture itself.

    Parameters
    ----------
    src, filter, border, border_x, border_y, type, touch_unused, threads
        As in `resize`.

    Returns
    -------
    list of arrays
        Level 0 is a copy of `src`; each further one has half the sides, rounded down.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import normaltexture as nt
    >>> [level.shape[:2] for level in nt.mip_chain(nt.read("wall_n.png"))]
    [(64, 96), (32, 48), (16, 24), (8, 12), (4, 6), (2, 3), (1, 1)]
    """
    source = pixels("src", src, type)
    if type == "auto":
        type = resolve_sound(source, type, threads)
    encoding = choose("type", type, TYPES)
    view("src", source, encoding)
    how = _resize_options(filter, border, border_x, border_y, touch_unused)
    height, width = source.shape[:2]
    chain: list[Any] = [source.copy()]
    for level in range(1, lib.ntp_mip_levels(width, height)):
        sides = lib.ntp_mip_side(width, level), lib.ntp_mip_side(height, level)
        chain.append(resized(source, encoding, *sides, how, None, threads))
    return chain


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
    edges = _edges(border, border_x, border_y)
    how = ffi.new(
        "ntp_transform_options *", (*flips, 0, strength is not None, factor, angle, *edges)
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


def _greens(
    arrays: tuple[NDArray[Any], NDArray[Any]],
    types: tuple[Type, Type],
    asked: tuple[AutoY, AutoY],
    strength: float,
    touch_unused: bool,
    threads: int,
) -> tuple[Y, Y]:
    """The arguments `y` and `detail_y` of `blend`.

    Turning green changes nothing where every y is 0: a base without y takes the green of the detail,
    and a detail without y that of the base.
    """
    names = "y", "detail_y"
    greens: list[Y | None] = [
        told(name, y) or find(array, type, threads)
        for name, y, array, type in zip(names, asked, arrays, types, strict=True)
    ]
    base, detail = greens
    if base is None or detail is None:
        has_y = [slopes(a, t, touch_unused)[1] for a, t in zip(arrays, types, strict=True)]
        matters = has_y[1] and strength != 0
        if base is None and (not has_y[0] or not matters):
            base = detail = detail or "up"
        elif detail is None and not matters:
            detail = base
    for i, (found, array) in enumerate(((base, "base"), (detail, "detail"))):
        if found is None:
            raise ArgumentError(question(arrays[i], types[i], threads, names[i], array))
    assert base is not None and detail is not None
    return base, detail


@overload
def blend(
    base: Floats,
    detail: Floats,
    *,
    type: Literal["vector"],
    detail_type: Literal["vector"] | None = ...,
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[BlendHow],
) -> NDArray[np.float32]: ...
@overload
def blend(
    base: Floats,
    detail: AnyPixels,
    *,
    type: Literal["vector"],
    detail_type: AutoStored,
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[BlendHow],
) -> NDArray[np.float32]: ...
@overload
def blend(
    base: NDArray[SampleT],
    detail: Floats,
    *,
    type: AutoStored = ...,
    detail_type: Literal["vector"],
    out: NDArray[SampleT] | None = ...,
    **how: Unpack[BlendHow],
) -> NDArray[SampleT]: ...
@overload
def blend(
    base: NDArray[SampleT],
    detail: AnyPixels,
    *,
    type: AutoStored = ...,
    detail_type: AutoStored | None = ...,
    out: NDArray[SampleT] | None = ...,
    **how: Unpack[BlendHow],
) -> NDArray[SampleT]: ...
def blend(
    base: AnyPixels | Floats,
    detail: AnyPixels | Floats,
    *,
    mode: BlendMode = "rnm",
    strength: float = 1.0,
    type: AutoType = "auto",
    detail_type: AutoType | None = None,
    y: AutoY = "auto",
    detail_y: AutoY = "auto",
    detail_alpha: bool = False,
    touch_unused: bool = False,
    out: NDArray[Any] | None = None,
    threads: int = 1,
) -> NDArray[Any]:
    """Add the bumps of one texture to another.

    Parameters
    ----------
    base : array, (height, width, channels), uint8, uint16 or float32
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    detail : array
        Another; size, depth, encoding and direction of green may differ.  It is repeated, starting
        at the upper left corner.
    mode : {"rnm", "whiteout", "udn", "linear"}
        Reoriented, as if the detail lay on the surface of the base; or sums, weaker on slopes; or
        the mean of both, which flattens them.
    strength : float
        Multiply the slopes of the detail first, -1024..1024.
    type, detail_type : {"auto", "standard", "zzero", "xy", "vector"}
        How the two store a normal; "auto" detects it from the texels of each, as `ntp blend` does.
        `detail_type` is `type` if it is not given.
    y, detail_y : {"auto", "up", "down", "opengl", "directx"}
        Which way green points in each; the detail is turned to the base.  "auto": as the texels
        show it; if they are not sure, it is an ArgumentError where it makes a difference.
    detail_alpha : bool
        The alpha of the detail fades it.
    touch_unused : bool
        Blend pure black, pure white and transparent texels too.
    out : array like base, optional
        Where to write; it may be `base` itself.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array like base
        Where base or detail is unused, the base's texel is copied; alpha is that of the base.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Notes
    -----
    Source: C. Barre-Brisebois and S. Hill, "Blending in Detail" (2012).

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> base = np.full((2, 2, 3), (200, 128, 231), np.uint8)
    >>> detail = nt.encode(np.array([[[0.5, 0, 1]]], np.float32))
    >>> nt.blend(base, detail)[0, 0]
    array([240, 128, 187], dtype=uint8)
    """
    first, second = pixels("base", base, type), pixels("detail", detail, detail_type or type)
    if detail_type is None:
        detail_type = type
    if type == "auto":
        type = resolve_sound(first, type, threads, "base")
    if detail_type == "auto":
        detail_type = resolve_sound(second, detail_type, threads, "detail", "detail_type")
    encoding = choose("type", type, TYPES)
    detail_encoding = choose("detail_type", detail_type, TYPES)
    view("base", first, encoding)
    view("detail", second, detail_encoding)
    most = lib.NTP_MAX_STRENGTH
    factor = number("strength", strength, -most, most)
    greens = _greens(
        (first, second), (type, detail_type), (y, detail_y), factor, touch_unused, threads
    )
    up = choose_y("y", greens[0])
    base_view = view("base", first, encoding, up)
    detail_view = view("detail", second, detail_encoding, choose_y("detail_y", greens[1]))
    output = Output(first.shape, first.dtype, out)
    if out is not None:
        output.apart_from(True, base=first)
        output.apart_from(False, detail=second)
    dst = view("out", output.array, encoding, up, writable=True)
    how = ffi.new(
        "ntp_blend_options *",
        (
            choose("mode", mode, BLEND_MODES),
            factor != 1,
            factor,
            TOUCH_ALL if touch_unused else TOUCH_NONE,
            bool(detail_alpha),
        ),
    )

    def work(areas: Iterable[Any]) -> None:
        for area in areas:
            check(lib.ntp_blend(dst, base_view, detail_view, how, area), "blend")

    run(threads, first.shape[1], first.shape[0], work, THOROUGH)
    result: NDArray[Any] = output.finish()
    return result
