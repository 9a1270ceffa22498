# SPDX-License-Identifier: MIT
"""Block compression: BC5 of normals, BC4 of heights."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import choose, pixels, view
from ._errors import ArgumentError, Status, check
from ._names import BLOCK_QUALITIES, HEIGHT, STANDARD, XY
from ._native import ffi, lib
from ._threads import THOROUGH, run
from .typing import AnyPixels, BlockQuality

_SIDE = 4


def _encode(
    src: Any, encoder: Callable[..., int], size: int, quality: str, threads: int
) -> NDArray[np.uint8]:
    source = pixels("src", src)
    channels = source.shape[2] if source.ndim == 3 else 1
    if size == 16:
        encoding = XY if channels == 2 else STANDARD
    elif channels != 1:
        raise ArgumentError(f"src: BC4 has one channel, the shape is {source.shape}", Status.FORMAT)
    else:
        encoding = HEIGHT
    seen = view("src", source, encoding)
    how = ffi.new("ntp_block_options *", (choose("quality", quality, BLOCK_QUALITIES),))
    height, width = source.shape[:2]
    rows, columns = -(-height // _SIDE), -(-width // _SIDE)
    out = np.empty((rows, columns, size), np.uint8)
    data = ffi.from_buffer("uint8_t[]", out)

    def work(areas: Iterable[Any]) -> None:
        for strip in areas:  # of rows of blocks
            area = ffi.NULL
            if strip != ffi.NULL:
                bottom = min(_SIDE * strip.y1, height)
                area = ffi.new("ntp_rect *", (0, _SIDE * strip.y0, width, bottom))
            check(
                encoder(data, columns * size, seen, how, area), f"encode_bc{4 if size == 8 else 5}"
            )

    run(threads, columns, rows, work, THOROUGH // 64)
    return out


def encode_bc5(
    src: AnyPixels, *, quality: BlockQuality = "angle", threads: int = 1
) -> NDArray[np.uint8]:
    """Compress the x and y of normals in blocks, as BC5.

    Parameters
    ----------
    src : array, (height, width, 2 to 4), uint8, uint16 or float32 in 0..1
        Red and green are x and y, in any type of normals texture; what follows is left out.
    quality : {"angle", "channel", "quick"}
        By the angle between the vectors; the best that each channel alone can be; or several times
        faster than that, and nearly as good.
    threads : int
        How many threads share the blocks; 0: one for each processor.

    Returns
    -------
    array, (rows of blocks, columns of blocks, 16), uint8
        The blocks as DDS and KTX2 have them, from the top.  Sides that are no multiple of 4 end in
        a part of a block.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import normaltexture as nt
    >>> nt.encode_bc5(nt.read("wall_n.png")).shape
    (16, 24, 16)
    """
    return _encode(src, lib.ntp_bc5_encode, 16, quality, threads)


def encode_bc4(
    src: AnyPixels, *, quality: BlockQuality = "angle", threads: int = 1
) -> NDArray[np.uint8]:
    """Compress one channel in blocks, as BC4.

    Parameters
    ----------
    src : array, (height, width), uint8, uint16 or float32 in 0..1
        A height, or any other channel.
    quality : {"angle", "channel", "quick"}
        As of `encode_bc5`; "angle" is "channel" here.
    threads : int
        How many threads share the blocks; 0: one for each processor.

    Returns
    -------
    array, (rows of blocks, columns of blocks, 8), uint8
        The blocks as DDS and KTX2 have them, from the top.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import normaltexture as nt
    >>> nt.encode_bc4(nt.read("wall_n.png")[..., 0]).shape
    (16, 24, 8)
    """
    return _encode(src, lib.ntp_bc4_encode, 8, quality, threads)
