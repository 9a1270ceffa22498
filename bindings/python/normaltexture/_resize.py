# SPDX-License-Identifier: MIT
"""Normals resized, and mip chains: every texel stays a unit vector."""

import re
from collections.abc import Iterable
from typing import Any, Literal, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import MAX_SIDE, Output, choose, memory, pixels, view
from ._errors import ArgumentError, check
from ._names import FILTERS, RESIZE_BORDERS, TOUCH_ALL, TOUCH_NONE, TYPES
from ._native import ffi, lib
from ._threads import THOROUGH, run
from ._undo import resolve_sound
from .typing import (
    AnyPixels,
    AutoStored,
    AutoType,
    Filter,
    Floats,
    ResizeBorder,
    ResizeHow,
    SampleT,
    Size,
    SizedHow,
)


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


def edges(
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
            *edges(border, border_x, border_y),
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
