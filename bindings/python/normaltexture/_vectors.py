# SPDX-License-Identifier: MIT
"""Float vectors, from stored levels and to them."""

from typing import Any, Literal, Unpack, cast, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import DEPTHS, Output, pixels
from ._convert import convert_parts
from ._green import choose_y
from .typing import (
    AnyPixels,
    Blue,
    Depth,
    EncodeHow,
    Floats,
    GivenY,
    Stored,
    Type,
)


@overload
def decode(
    src: Floats,
    *,
    type: Literal["vector"],
    y: GivenY = ...,
    out: NDArray[np.float32] | None = ...,
    threads: int = ...,
) -> NDArray[np.float32]: ...
@overload
def decode(
    src: AnyPixels,
    *,
    type: Stored = ...,
    y: GivenY = ...,
    out: NDArray[np.float32] | None = ...,
    threads: int = ...,
) -> NDArray[np.float32]: ...
def decode(
    src: AnyPixels | Floats,
    *,
    type: Type = "standard",
    y: GivenY = "up",
    out: NDArray[np.float32] | None = None,
    threads: int = 1,
) -> NDArray[np.float32]:
    """Read stored levels as vectors x, y, z in -1..1, y up.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored.
    y : {"up", "down", "opengl", "directx"}
        Which way green points in `src`.
    out : array, (height, width, 3), float32, optional
        Where to write.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array, (height, width, 3), float32
        (2c - M)/M of each level c, the nearest float; not divided by its length.  Unused texels are
        (-1, -1, -1) or (1, 1, 1), as they are stored.  For `"xy"`, x, y are pulled onto the unit
        disc if too long, and z is the root of 1 - x x - y y.

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
    source = pixels("src", src, type)
    choose_y("y", y)
    output = Output((*source.shape[:2], 3), DEPTHS["float"], out)
    convert_parts(
        source, type, "vector", y, "up", "float", "derived", None, None, True, output.array, threads
    )
    return cast("NDArray[np.float32]", output.finish())


@overload
def encode(
    vectors: Floats,
    *,
    depth: Literal[8] = ...,
    out: NDArray[np.uint8] | None = ...,
    **how: Unpack[EncodeHow],
) -> NDArray[np.uint8]: ...
@overload
def encode(
    vectors: Floats,
    *,
    depth: Literal[16],
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[EncodeHow],
) -> NDArray[np.uint16]: ...
@overload
def encode(
    vectors: Floats,
    *,
    depth: Literal["float"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[EncodeHow],
) -> NDArray[np.float32]: ...
def encode(
    vectors: Floats,
    *,
    to: Stored = "standard",
    to_y: GivenY = "up",
    depth: Depth = 8,
    blue: Blue = "derived",
    out: NDArray[Any] | None = None,
    threads: int = 1,
) -> NDArray[Any]:
    """Store vectors x, y, z, y up, as levels, correctly rounded.

    Parameters
    ----------
    vectors : array, (height, width, 3 or 4), float32
        They may be float64; they are rounded once, to float32.
        Vectors of any length but 0; a fourth component is alpha in 0..1.
    to : {"standard", "zzero", "xy"}
        How the result stores a normal.
    to_y : {"up", "down", "opengl", "directx"}
        Which way green points in the result.
    depth : {8, 16, "float"}
        Samples of the result: uint8, uint16 or float32 in 0..1.
    blue : {"derived", "nearest"}
        Computed from the rounded red and green, or z rounded independently.
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
    source = pixels("vectors", vectors, "vector")
    result, _ = convert_parts(
        source, "vector", to, "up", to_y, depth, blue, None, None, True, out, threads
    )
    return result
