# SPDX-License-Identifier: MIT
"""What can be said about each texel: a mask of flags; and about one of them, everything."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntFlag
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import ENCODINGS, HEIGHT, Output, Type, choose, pixels, view
from ._errors import ArgumentError, check
from ._measure import _Result
from ._native import ffi, lib
from ._threads import run


class Flag(IntFlag):
    """The bits of what `validate` writes for a texel."""

    PASS_NEIGHBOR = 1
    """Within one level of unit length."""
    PASS_ROUNDED = 2
    """An honest rounding of a unit vector."""
    PASS_EXACT = 4
    """Blue is the one that red and green imply."""
    XY_TOO_LONG = 8
    """Red and green alone are longer than 1."""
    Z_NEGATIVE = 16
    """The normal points into the surface."""
    IS_UNUSED = 32
    """Pure black, pure white, or transparent; the other bits are set as well."""
    NOT_FINITE = 64
    """A float sample is NaN or infinite; no PASS bit is set."""


def validate(
    src: ArrayLike,
    *,
    type: Type = "standard",
    keep_negative_z: bool = False,
    out: NDArray[np.uint8] | None = None,
    threads: int = 1,
) -> NDArray[np.uint8]:
    """Judge each texel.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).  Floats are judged as 16-bit levels.
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored: z in -1..1, z in 0..1, no z, or the components as they are
        (float32, -1..1).  Of `"xy"` textures all three verdicts ask only that x, y are not longer
        than 1.
    keep_negative_z : bool
        `PASS_EXACT` accepts the mirrored blue of a negative z.
    out : array, (height, width), uint8, optional
        Where to write the flags.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array, (height, width), uint8
        `Flag` bits of each texel.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Notes
    -----
    The verdicts are those of docs/arithmetic.md.  `neighbor` is the test of Eric Haines'
    NormalTextureProcessor.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texture = np.array([[[128, 128, 255], [255, 255, 128]]], np.uint8)
    >>> flags = nt.validate(texture)
    >>> flags & nt.Flag.PASS_EXACT > 0
    array([[ True, False]])
    >>> nt.Flag(int(flags[0, 1]))
    <Flag.XY_TOO_LONG: 8>
    """
    encoding = choose("type", type, ENCODINGS)
    source = pixels("src", src)
    src_view = view("src", source, encoding)
    output = Output(source.shape[:2], np.dtype(np.uint8), out)
    output.apart_from(False, src=source)
    mask = view("out", output.array, HEIGHT, writable=True)

    def work(areas: Iterable[Any]) -> None:
        for area in areas:
            check(lib.ntp_validate(mask, src_view, bool(keep_negative_z), area), "validate")

    run(threads, source.shape[1], source.shape[0], work)
    result: NDArray[np.uint8] = output.finish()
    return result


@dataclass(frozen=True)
class Texel(_Result):
    """All that can be said about one texel.

    Attributes
    ----------
    stored : tuple of int
        Red, green, blue and alpha in levels; floats rounded to 16 bit, absent alpha is `max`.
    cleaned : tuple of int
        Red, green and blue as `clean` leaves them.
    max : int
        The greatest level: 255 or 65535.
    flags : Flag
        As `validate` writes them.
    levels_off : int
        How many levels blue is off; -1 where x, y are too long or not finite.
    x, y, z : float
        The vector as stored; of `"xy"`, z is derived.
    length : float
        Of x, y, z.
    angle : float
        Degrees between the stored and the cleaned vector.
    """

    stored: tuple[int, ...]
    cleaned: tuple[int, ...]
    max: int
    flags: Flag
    levels_off: int
    x: float
    y: float
    z: float
    length: float
    angle: float


def inspect(
    src: ArrayLike, x: int, y: int, *, type: Type = "standard", keep_negative_z: bool = False
) -> Texel:
    """Say everything about one texel, as `ntp dump` does.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    x, y : int
        Column and row; the upper left texel is at 0, 0.
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored.
    keep_negative_z : bool
        A negative z is no fault and stays.

    Returns
    -------
    Texel

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texel = nt.inspect(np.array([[[200, 100, 10]]], np.uint8), 0, 0)
    >>> texel.cleaned, texel.levels_off, round(texel.length, 3), texel.flags
    ((200, 100, 229), 16, 1.104, <Flag.Z_NEGATIVE: 16>)
    """
    source = pixels("src", src)
    src_view = view("src", source, choose("type", type, ENCODINGS))
    height, width = source.shape[:2]
    for name, value, side in (("x", x, width), ("y", y, height)):
        if not isinstance(value, (int, np.integer)) or not 0 <= value < side:
            raise ArgumentError(f"{name}={value!r}: must be an integer 0..{side - 1}")
    found = ffi.new("ntp_texel *")
    check(lib.ntp_inspect(found, src_view, x, y, bool(keep_negative_z)), "inspect")
    return Texel(
        stored=tuple(found.stored),
        cleaned=tuple(found.cleaned),
        max=found.max,
        flags=Flag(found.flags),
        levels_off=found.levels_off,
        x=found.x,
        y=found.y,
        z=found.z,
        length=found.length,
        angle=found.angle,
    )
