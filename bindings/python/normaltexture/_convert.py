# SPDX-License-Identifier: MIT
"""Between encodings, depths and directions of green."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import DEPTHS, choose, pixels, view
from ._channels import Packed, unpacked
from ._classify import classify, natural_tally
from ._errors import ArgumentError, SampleTypeError, Status, check
from ._green import choose_y, known, slopes, told
from ._measure import _Result
from ._names import AUTO, BLUES, HEIGHT, MEASURED, TOUCH_ALL, TOUCH_NONE, VECTOR, XY
from ._native import ffi, lib
from ._threads import QUICK, THOROUGH, run
from ._undo import resolve_sound
from .typing import (
    AnyPixels,
    AutoY,
    Blue,
    ComparedType,
    ConvertHow,
    Depth,
    Floats,
    GivenY,
    MeasuredType,
    SampleT,
    Stored,
    Type,
    Y,
)

# What an array of integers or floats holds; "vector" is of floats only.
_Kept = Literal["standard", "zzero", "xy", "height"]
_From = Literal["auto"] | _Kept


_SURE = 0.9  # of the type, as on the command line


@dataclass(frozen=True)
class ConvertCounts(_Result):
    """What `convert` counted.

    Attributes
    ----------
    z_negative : int
        Texels whose negative z became its absolute value.
    not_finite : int
        Float texels with a NaN, an infinity or length 0: made flat.
    pulled : int
        Texels whose x, y, longer than 1, were pulled onto the unit disc.
    """

    z_negative: int
    not_finite: int
    pulled: int


def _depth_of(source: NDArray[Any], depth: Depth | None, to: str) -> np.dtype[Any]:
    if to == "vector":
        if depth not in (None, "float"):
            raise SampleTypeError(f'depth={depth!r}: to="vector" writes float32')
        return DEPTHS["float"]
    return source.dtype.newbyteorder("=") if depth is None else choose("depth", depth, DEPTHS)


def _types(
    source: NDArray[Any],
    type: ComparedType,
    to: MeasuredType | None,
    from_channels: str | None,
    only_depth: bool,
    threads: int,
) -> tuple[MeasuredType, MeasuredType]:
    """The arguments `type` and `to`, "auto" and None found out.

    If only the depth changes, heights are taken as well as normals.
    """
    if type != "auto":
        choose("type", type, {"auto": AUTO} | MEASURED)
        return type, to or ("height" if type == "height" else "standard")
    if from_channels is not None:  # in another order nothing can be detected
        return "standard", to or "standard"
    if to == "height":
        _only_heights(type, to, None, None)
    if source.ndim == 2 or source.shape[2] == 1:  # it can be nothing else
        return "height", to or ("height" if only_depth else "standard")
    measured = natural_tally(source, threads)
    seen = classify(measured)
    if only_depth and seen.type == "height":
        return "height", "height"
    found = resolve_sound(source, "auto", threads, measured=measured)
    if to is not None:
        choose("to", to, MEASURED)
        if seen.type != "one-color" and seen.confidence < _SURE:
            raise ArgumentError(
                f'type="auto": src looks {seen.type}, {100 * seen.confidence:.0f} % sure; which is'
                ' it, type="standard", "zzero" or "xy"?'
            )
    return found, to or found


def _greens(
    source: NDArray[Any],
    type: MeasuredType,
    y: AutoY,
    to_y: GivenY | None,
    from_channels: str | None,
    touch_unused: bool,
    threads: int,
) -> tuple[GivenY, GivenY]:
    """The arguments `y` and `to_y`, "auto" and None found out."""
    given = told("y", y)
    if type == "height":
        return "up", "up"
    if to_y is None:
        return given or "up", "up"
    choose_y("to_y", to_y)
    if given is not None:
        return given, to_y
    if from_channels is not None:
        raise ArgumentError('to_y, from_channels: go together only with y="up" or y="down"')
    needed = slopes(source, type, touch_unused)[1]
    otherwise: Y = "down" if to_y in ("down", "directx") else "up"
    return known("y", y, source, type, threads, needed, otherwise), to_y


def _only_heights(type: str, to: str, channels: str | None, from_channels: str | None) -> None:
    if type != to:
        raise ArgumentError(
            f"type={type!r}, to={to!r}: normals_from_height and height_from_normals do that",
            Status.FORMAT,
        )
    if channels is not None or from_channels is not None:
        raise ArgumentError('channels, from_channels: name those of normals, not of to="height"')


@overload
def convert(
    src: NDArray[SampleT],
    *,
    type: _From = ...,
    to: _Kept | None = ...,
    depth: None = ...,
    out: NDArray[SampleT] | None = ...,
    **how: Unpack[ConvertHow],
) -> NDArray[SampleT]: ...
@overload
def convert(
    src: AnyPixels,
    *,
    type: _From = ...,
    to: _Kept | None = ...,
    depth: Literal[8],
    out: NDArray[np.uint8] | None = ...,
    **how: Unpack[ConvertHow],
) -> NDArray[np.uint8]: ...
@overload
def convert(
    src: AnyPixels,
    *,
    type: _From = ...,
    to: _Kept | None = ...,
    depth: Literal[16],
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[ConvertHow],
) -> NDArray[np.uint16]: ...
@overload
def convert(
    src: AnyPixels,
    *,
    type: _From = ...,
    to: MeasuredType | None = ...,
    depth: Literal["float"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[ConvertHow],
) -> NDArray[np.float32]: ...
@overload
def convert(
    src: AnyPixels,
    *,
    type: _From = ...,
    to: Literal["vector"],
    depth: None = ...,
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[ConvertHow],
) -> NDArray[np.float32]: ...
@overload
def convert(
    src: Floats,
    *,
    type: Literal["vector"],
    to: Type | None = ...,
    depth: Literal["float"] | None = ...,
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[ConvertHow],
) -> NDArray[np.float32]: ...
@overload
def convert(
    src: Floats,
    *,
    type: Literal["vector"],
    to: Stored | None = ...,
    depth: Literal[8],
    out: NDArray[np.uint8] | None = ...,
    **how: Unpack[ConvertHow],
) -> NDArray[np.uint8]: ...
@overload
def convert(
    src: Floats,
    *,
    type: Literal["vector"],
    to: Stored | None = ...,
    depth: Literal[16],
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[ConvertHow],
) -> NDArray[np.uint16]: ...
def convert(
    src: AnyPixels | Floats,
    *,
    type: ComparedType = "auto",
    to: MeasuredType | None = None,
    y: AutoY = "auto",
    to_y: GivenY | None = None,
    depth: Depth | None = None,
    blue: Blue = "derived",
    channels: str | None = None,
    from_channels: str | None = None,
    touch_unused: bool = False,
    out: NDArray[Any] | None = None,
    threads: int = 1,
) -> NDArray[Any]:
    """Change encoding, depth or the direction of green.  Nothing is repaired.

    Each sample is converted by value, correctly rounded; a flip of green is M - g. A texel with the
    exact blue gets the exact blue of the target, so a clean texture stays clean.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4), or heights, of which only the depth
        changes: arrays of one channel are heights, and so are gray images.
    type, to : {"auto", "standard", "zzero", "xy", "vector", "height"}
        How a normal is stored, before and after.  "auto": detect it from the texels, as `ntp convert`
        does; if that is not sure and `to` is given, it is an ArgumentError.  Without `to` it stays,
        but where `type` is given it becomes "standard".  From `"xy"` blue is derived; `"xy"` of 3 or 4
        channels gets blue M (255, 65535 or 1).  If both are "height", the samples of a gray image,
        or of any picture, are converted to another depth.
    y, to_y : {"auto", "up", "down", "opengl", "directx"}
        Which way green points, before and after.  "auto": as the texels show it; if they are not
        sure and `to_y` is given, it is an ArgumentError where a texel slopes up or down.  Without
        `to_y` green stays, but where `y` is given it becomes "up".
    depth : {8, 16, "float"}, optional
        Samples of the result: uint8, uint16 or float32 in 0..1; by default those of `src`.
    blue : {"derived", "nearest"}
        From `"vector"` only: computed from the rounded red and green, or z rounded independently.
    channels : str, optional
        What each channel of the result holds, one letter each of x y z 0 1 and a (alpha):
        "xyz", "xzy", "1y0x" (DXT5nm); one letter makes an array of two dimensions.
    from_channels : str, optional
        What each channel of `src` holds, in the same letters, with - for an unused channel: "-y-x"
        reads DXT5nm.  If z is missing, it is computed.
    touch_unused : bool
        Convert pure black, pure white and transparent texels too, which are copied otherwise.
    out : array, optional
        Where to write; its channels may differ from those of `src` (a missing alpha is opaque). It
        may be `src` itself if the type of the samples stays the same.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array, (height, width, channels)
        `"xy"` arrays of 2 channels become 3, except to `"xy"`.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texture = np.array([[[128, 200, 232]]], np.uint8)
    >>> nt.convert(texture, y="down")
    array([[[128,  55, 232]]], dtype=uint8)
    >>> nt.convert(texture, depth=16)
    array([[[32896, 51400, 59722]]], dtype=uint16)
    >>> packed = nt.convert(texture, channels="1y0x")
    >>> packed
    array([[[255, 200,   0, 128]]], dtype=uint8)
    >>> nt.convert(packed, from_channels="-y-x", channels="xyz")
    array([[[128, 200, 232]]], dtype=uint8)
    """
    result, _ = convert_parts(
        src, type, to, y, to_y, depth, blue, channels, from_channels, touch_unused, out, threads
    )
    return result


@overload
def convert_with_counts(
    src: NDArray[SampleT],
    *,
    type: _From = ...,
    to: _Kept | None = ...,
    depth: None = ...,
    out: NDArray[SampleT] | None = ...,
    **how: Unpack[ConvertHow],
) -> tuple[NDArray[SampleT], ConvertCounts]: ...
@overload
def convert_with_counts(
    src: AnyPixels,
    *,
    type: _From = ...,
    to: _Kept | None = ...,
    depth: Literal[8],
    out: NDArray[np.uint8] | None = ...,
    **how: Unpack[ConvertHow],
) -> tuple[NDArray[np.uint8], ConvertCounts]: ...
@overload
def convert_with_counts(
    src: AnyPixels,
    *,
    type: _From = ...,
    to: _Kept | None = ...,
    depth: Literal[16],
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[ConvertHow],
) -> tuple[NDArray[np.uint16], ConvertCounts]: ...
@overload
def convert_with_counts(
    src: AnyPixels,
    *,
    type: _From = ...,
    to: MeasuredType | None = ...,
    depth: Literal["float"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[ConvertHow],
) -> tuple[NDArray[np.float32], ConvertCounts]: ...
@overload
def convert_with_counts(
    src: AnyPixels,
    *,
    type: _From = ...,
    to: Literal["vector"],
    depth: None = ...,
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[ConvertHow],
) -> tuple[NDArray[np.float32], ConvertCounts]: ...
@overload
def convert_with_counts(
    src: Floats,
    *,
    type: Literal["vector"],
    to: Type | None = ...,
    depth: Literal["float"] | None = ...,
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[ConvertHow],
) -> tuple[NDArray[np.float32], ConvertCounts]: ...
@overload
def convert_with_counts(
    src: Floats,
    *,
    type: Literal["vector"],
    to: Stored | None = ...,
    depth: Literal[8],
    out: NDArray[np.uint8] | None = ...,
    **how: Unpack[ConvertHow],
) -> tuple[NDArray[np.uint8], ConvertCounts]: ...
@overload
def convert_with_counts(
    src: Floats,
    *,
    type: Literal["vector"],
    to: Stored | None = ...,
    depth: Literal[16],
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[ConvertHow],
) -> tuple[NDArray[np.uint16], ConvertCounts]: ...
def convert_with_counts(
    src: AnyPixels | Floats,
    *,
    type: ComparedType = "auto",
    to: MeasuredType | None = None,
    y: AutoY = "auto",
    to_y: GivenY | None = None,
    depth: Depth | None = None,
    blue: Blue = "derived",
    channels: str | None = None,
    from_channels: str | None = None,
    touch_unused: bool = False,
    out: NDArray[Any] | None = None,
    threads: int = 1,
) -> tuple[NDArray[Any], ConvertCounts]:
    """Change encoding, depth or the direction of green, and count what could not be kept.

    Parameters
    ----------
    src, type, to, y, to_y, depth, blue, channels, from_channels, touch_unused, out, threads
        As in `convert`.

    Returns
    -------
    (array, ConvertCounts)

    Raises
    ------
    ArgumentError, SampleTypeError
        As `convert`.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texture = np.array([[[128, 200, 20]]], np.uint8)
    >>> zzero, counts = nt.convert_with_counts(texture, to="zzero")
    >>> counts.z_negative
    1
    """
    result, parts = convert_parts(
        src, type, to, y, to_y, depth, blue, channels, from_channels, touch_unused, out, threads
    )
    return result, ConvertCounts(
        sum(part.z_negative for part in parts),
        sum(part.not_finite for part in parts),
        sum(part.pulled for part in parts),
    )


def convert_parts(
    src: AnyPixels | Floats,
    type: ComparedType,
    to: MeasuredType | None,
    y: AutoY,
    to_y: GivenY | None,
    depth: Depth | None,
    blue: Blue,
    channels: str | None,
    from_channels: str | None,
    touch_unused: bool,
    out: Any,
    threads: int,
) -> tuple[NDArray[Any], list[Any]]:
    """The array, and an ntp_convert_counts for each part of the work."""
    source = pixels("src", src, type)
    only_depth = to is None and to_y is None and channels is None
    found, to = _types(source, type, to, from_channels, only_depth, threads)
    encoding, target = choose("type", found, MEASURED), choose("to", to, MEASURED)
    if encoding == HEIGHT or target == HEIGHT:
        _only_heights(found, to, channels, from_channels)
    green, to_green = _greens(source, found, y, to_y, from_channels, touch_unused, threads)
    if from_channels is not None:
        source, has_z = unpacked(source, from_channels)
        encoding = encoding if has_z else XY
    src_view = view("src", source, encoding, choose_y("y", green))
    dtype = _depth_of(source, depth, to)
    if target == HEIGHT:
        count = 0
    else:
        count = source.shape[2] if target == XY else max(source.shape[2], 3)
    packed = Packed(channels, source.shape, count, dtype, out)
    if out is not None and channels is None:
        packed.output.apart_from(source.dtype == dtype, src=source)
    dst = view("out", packed.array, target, choose_y("to_y", to_green), writable=True)
    how = ffi.new(
        "ntp_convert_options *",
        (choose("blue", blue, BLUES), TOUCH_ALL if touch_unused else TOUCH_NONE),
    )

    def work(areas: Iterable[Any]) -> Any:
        counts = ffi.new("ntp_convert_counts *")
        for area in areas:
            check(lib.ntp_convert(dst, src_view, how, counts, area), "convert")
        return counts

    parts = run(
        threads, source.shape[1], source.shape[0], work, THOROUGH if encoding == VECTOR else QUICK
    )
    result: NDArray[Any] = packed.finish()
    return result, parts
