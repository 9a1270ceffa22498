# SPDX-License-Identifier: MIT
"""Normals blended: detail on a base."""

from collections.abc import Iterable
from typing import Any, Literal, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import Output, choose, number, pixels, view
from ._errors import ArgumentError, check
from ._green import choose_y, find, question, slopes, told
from ._names import BLEND_MODES, TOUCH_ALL, TOUCH_NONE, TYPES
from ._native import ffi, lib
from ._threads import THOROUGH, run
from ._undo import resolve_sound
from .typing import (
    AnyPixels,
    AutoStored,
    AutoType,
    AutoY,
    BlendHow,
    BlendMode,
    Floats,
    SampleT,
    Type,
    Y,
)


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
