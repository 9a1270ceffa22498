# SPDX-License-Identifier: MIT
"""Between encodings, depths, directions of green, and float vectors."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, cast, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import (
    DEPTHS,
    HEIGHT,
    MEASURED,
    TOUCH_ALL,
    TOUCH_NONE,
    YS,
    Depth,
    MeasuredType,
    Output,
    Pixels,
    Type,
    Y,
    choose,
    pixels,
    view,
)
from ._channels import Packed, unpacked
from ._errors import ArgumentError, SampleTypeError, Status, check
from ._measure import _Result
from ._native import ffi, lib
from ._threads import QUICK, THOROUGH, run

Blue = Literal["derived", "nearest"]
BLUES = {"derived": 0, "nearest": 1}


@dataclass(frozen=True)
class ConvertCounts(_Result):
    """What `convert` met.

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


def _only_heights(from_: str, to: str, channels: str | None, from_channels: str | None) -> None:
    if from_ != to:
        raise ArgumentError(
            f"from_={from_!r}, to={to!r}: normals_from_height and height_from_normals do that",
            Status.FORMAT,
        )
    if channels is not None or from_channels is not None:
        raise ArgumentError('channels, from_channels: name those of normals, not of to="height"')


@overload
def convert(
    src: ArrayLike,
    *,
    from_: MeasuredType = ...,
    to: MeasuredType = ...,
    from_y: Y = ...,
    to_y: Y = ...,
    depth: Depth | None = ...,
    blue: Blue = ...,
    channels: str | None = ...,
    from_channels: str | None = ...,
    touch_unused: bool = ...,
    return_counts: Literal[False] = ...,
    out: Pixels | None = ...,
    threads: int = ...,
) -> Pixels: ...
@overload
def convert(
    src: ArrayLike,
    *,
    from_: MeasuredType = ...,
    to: MeasuredType = ...,
    from_y: Y = ...,
    to_y: Y = ...,
    depth: Depth | None = ...,
    blue: Blue = ...,
    channels: str | None = ...,
    from_channels: str | None = ...,
    touch_unused: bool = ...,
    return_counts: Literal[True],
    out: Pixels | None = ...,
    threads: int = ...,
) -> tuple[Pixels, ConvertCounts]: ...
def convert(
    src: ArrayLike,
    *,
    from_: MeasuredType = "standard",
    to: MeasuredType = "standard",
    from_y: Y = "up",
    to_y: Y = "up",
    depth: Depth | None = None,
    blue: Blue = "derived",
    channels: str | None = None,
    from_channels: str | None = None,
    touch_unused: bool = False,
    return_counts: bool = False,
    out: Pixels | None = None,
    threads: int = 1,
) -> Pixels | tuple[Pixels, ConvertCounts]:
    """Change encoding, depth or the direction of green.  Nothing is repaired.

    Each sample goes over by value, correctly rounded; a flip of green is M - g.  A texel whose
    blue is the exact one gets the exact blue of the target, so a clean texture stays clean.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    from_, to : {"standard", "zzero", "xy", "vector", "height"}
        How a normal is stored, before and after.  From `"xy"` blue is derived; `"xy"` of 3 or 4
        channels gets blue M (255, 65535 or 1).  Where both are "height" the samples of a gray image,
        or of any picture, go to another depth.
    from_y, to_y : {"up", "down"}
        Which way green points, before and after: OpenGL or DirectX.
    depth : {8, 16, "float"}, optional
        Samples of the result: uint8, uint16 or float32 in 0..1; by default those of `src`.
    blue : {"derived", "nearest"}
        From `"vector"` only: computed from the rounded red and green, or z rounded by itself.
    channels : str, optional
        What each channel of the result holds, one letter each of x y z 0 1 and a (alpha):
        "xyz", "xzy", "1y0x" (DXT5nm); one letter makes an array of two dimensions.
    from_channels : str, optional
        What each channel of `src` holds, in the same letters, - for nothing of use: "-y-x" reads
        DXT5nm.  Without z it is computed.
    touch_unused : bool
        Convert pure black, pure white and transparent texels too, which are copied otherwise.
    return_counts : bool
        Return `ConvertCounts` as well.
    out : array, optional
        Where to write; its channels may differ from those of `src` (a missing alpha is opaque).
        It may be `src` itself where the samples stay of one type.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array, (height, width, channels), or (array, ConvertCounts)
        `"xy"` arrays of 2 channels become 3, except to `"xy"`.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texture = np.array([[[128, 200, 232]]], np.uint8)
    >>> nt.convert(texture, from_y="down", to_y="up")
    array([[[128,  55, 232]]], dtype=uint8)
    >>> nt.convert(texture, depth=16)
    array([[[32896, 51400, 59722]]], dtype=uint16)
    >>> packed = nt.convert(texture, channels="1y0x")
    >>> packed
    array([[[255, 200,   0, 128]]], dtype=uint8)
    >>> nt.convert(packed, from_channels="-y-x", channels="xyz")
    array([[[128, 200, 232]]], dtype=uint8)
    """
    source = pixels("src", src)
    encoding, target = choose("from_", from_, MEASURED), choose("to", to, MEASURED)
    if encoding == HEIGHT or target == HEIGHT:
        _only_heights(from_, to, channels, from_channels)
    if from_channels is not None:
        source, has_z = unpacked(source, from_channels)
        encoding = encoding if has_z else MEASURED["xy"]
    src_view = view("src", source, encoding, choose("from_y", from_y, YS))
    dtype = _depth_of(source, depth, to)
    if target == HEIGHT:
        count = 0
    else:
        count = source.shape[2] if target == 2 else max(source.shape[2], 3)
    packed = Packed(channels, "xyza01", source.shape, count, dtype, out)
    if out is not None and channels is None:
        packed.output.apart_from(source.dtype == dtype, src=source)
    dst = view("out", packed.array, target, choose("to_y", to_y, YS), writable=True)
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
        threads, source.shape[1], source.shape[0], work, THOROUGH if encoding == 3 else QUICK
    )
    result: Pixels = packed.finish()
    if not return_counts:
        return result
    return result, ConvertCounts(
        sum(part.z_negative for part in parts),
        sum(part.not_finite for part in parts),
        sum(part.pulled for part in parts),
    )


def decode(
    src: ArrayLike,
    *,
    from_: Type = "standard",
    from_y: Y = "up",
    out: NDArray[np.float32] | None = None,
    threads: int = 1,
) -> NDArray[np.float32]:
    """Read stored levels as vectors x, y, z in -1..1, y up.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    from_ : {"standard", "zzero", "xy", "vector"}
        How a normal is stored.
    from_y : {"up", "down"}
        Which way green points in `src`.
    out : array, (height, width, 3), float32, optional
        Where to write.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array, (height, width, 3), float32
        (2c - M)/M of each level c, the nearest float; not divided by its length.  Unused texels
        are (-1, -1, -1) or (1, 1, 1), as they are stored.  Of `"xy"`, x, y are pulled onto the
        unit disc where too long, and z is the root of 1 - x x - y y.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> nt.decode(np.array([[[0, 255, 128]]], np.uint8))
    array([[[-1.        ,  1.        ,  0.00392157]]], dtype=float32)
    """
    source = pixels("src", src)
    output = Output((*source.shape[:2], 3), DEPTHS["float"], out)
    convert(
        source,
        from_=from_,
        to="vector",
        from_y=from_y,
        touch_unused=True,
        depth="float",
        out=output.array,
        threads=threads,
    )
    return cast("NDArray[np.float32]", output.finish())


def encode(
    vectors: ArrayLike,
    *,
    to: Type = "standard",
    to_y: Y = "up",
    depth: Depth = 8,
    blue: Blue = "derived",
    out: Pixels | None = None,
    threads: int = 1,
) -> Pixels:
    """Store vectors x, y, z, y up, as levels, correctly rounded.

    Parameters
    ----------
    vectors : array, (height, width, 3 or 4), float32
        Vectors of any length but 0; a fourth component is alpha in 0..1.
    to : {"standard", "zzero", "xy"}
        How a normal is to be stored.
    to_y : {"up", "down"}
        Which way green is to point.
    depth : {8, 16, "float"}
        Samples of the result: uint8, uint16 or float32 in 0..1.
    blue : {"derived", "nearest"}
        Computed from the rounded red and green, or z rounded by itself.
    out : array, optional
        Where to write.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array, (height, width, 3 or 4)
        Vectors that are not finite or of length 0 become the flat normal.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> nt.encode(np.array([[[0, 0, 2], [1, 0, 1]]], np.float32))
    array([[[128, 128, 255],
            [218, 128, 217]]], dtype=uint8)
    """
    return convert(
        pixels("vectors", vectors),
        from_="vector",
        to=to,
        to_y=to_y,
        depth=depth,
        blue=blue,
        touch_unused=True,
        out=out,
        threads=threads,
    )
