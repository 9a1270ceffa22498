# SPDX-License-Identifier: MIT
"""The verdicts on texels: a mask of flags for each, and all facts about one."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntFlag
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import Output, choose, pixels, view
from ._classify import resolve
from ._errors import ArgumentError, check
from ._measure import _Result
from ._names import HEIGHT, TYPES
from ._native import ffi, lib
from ._threads import run
from .typing import (
    AnyPixels,
    AutoStored,
    AutoType,
    Floats,
)


class Flag(IntFlag):
    """The bits of what `validate` writes for a texel."""

    NEIGHBOR = lib.NTP_FLAG_NEIGHBOR
    """Within one level of unit length."""
    ROUNDED = lib.NTP_FLAG_ROUNDED
    """An honest rounding of a unit vector."""
    EXACT = lib.NTP_FLAG_EXACT
    """Blue is the one that red and green imply."""
    XY_TOO_LONG = lib.NTP_FLAG_XY_TOO_LONG
    """Red and green alone are longer than 1."""
    Z_NEGATIVE = lib.NTP_FLAG_Z_NEGATIVE
    """The normal points into the surface."""
    UNUSED = lib.NTP_FLAG_UNUSED
    """Pure black, pure white, or transparent; the other bits are set as well."""
    NOT_FINITE = lib.NTP_FLAG_NOT_FINITE
    """A float sample is NaN or infinite; no verdict is passed."""


@overload
def validate(
    src: Floats,
    *,
    type: Literal["vector"],
    keep_negative_z: bool = ...,
    out: NDArray[np.uint8] | None = ...,
    threads: int = ...,
) -> NDArray[np.uint8]: ...
@overload
def validate(
    src: AnyPixels,
    *,
    type: AutoStored = ...,
    keep_negative_z: bool = ...,
    out: NDArray[np.uint8] | None = ...,
    threads: int = ...,
) -> NDArray[np.uint8]: ...
def validate(
    src: AnyPixels | Floats,
    *,
    type: AutoType = "auto",
    keep_negative_z: bool = False,
    out: NDArray[np.uint8] | None = None,
    threads: int = 1,
) -> NDArray[np.uint8]:
    """Judge each texel.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).  Floats are judged as 16-bit levels.
    type : {"auto", "standard", "zzero", "xy", "vector"}
        How a normal is stored: z in -1..1, z in 0..1, no z, or the components as they are (float32,
        -1..1); "auto" detects it from the texels.  For `"xy"` textures all three verdicts require
        only that x, y are not longer than 1.
    keep_negative_z : bool
        `EXACT` accepts the mirrored blue of a negative z.
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
    >>> flags = nt.validate(texture, type="standard")
    >>> flags & nt.Flag.EXACT > 0
    array([[ True, False]])
    >>> nt.Flag(int(flags[0, 1]))
    <Flag.XY_TOO_LONG: 8>
    """
    source = pixels("src", src, type)
    if type == "auto":
        type = resolve(source, type, threads)
    src_view = view("src", source, choose("type", type, TYPES))
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
    """Everything about one texel.

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
        How many levels blue is off; -1 if x, y are too long or not finite.
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


@overload
def inspect(
    src: Floats,
    x: int,
    y: int,
    *,
    type: Literal["vector"],
    keep_negative_z: bool = ...,
) -> Texel: ...
@overload
def inspect(
    src: AnyPixels,
    x: int,
    y: int,
    *,
    type: AutoStored = ...,
    keep_negative_z: bool = ...,
) -> Texel: ...
def inspect(
    src: AnyPixels | Floats,
    x: int,
    y: int,
    *,
    type: AutoType = "auto",
    keep_negative_z: bool = False,
) -> Texel:
    """Return everything about one texel, as `ntp dump` does.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    x, y : int
        Column and row; the upper left texel is at 0, 0.
    type : {"auto", "standard", "zzero", "xy", "vector"}
        How a normal is stored; "auto" detects it from all texels, as `ntp dump` does.
    keep_negative_z : bool
        A negative z is not an error and stays.

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
    >>> texel = nt.inspect(np.array([[[200, 100, 10]]], np.uint8), 0, 0, type="standard")
    >>> texel.cleaned, texel.levels_off, round(texel.length, 3), texel.flags
    ((200, 100, 229), 16, 1.104, <Flag.Z_NEGATIVE: 16>)
    """
    source = pixels("src", src, type)
    height, width = source.shape[:2]
    for name, value, side in (("x", x, width), ("y", y, height)):
        if not isinstance(value, (int, np.integer)) or not 0 <= value < side:
            raise ArgumentError(f"{name}={value!r}: must be an integer 0..{side - 1}")
    if type == "auto":
        type = resolve(source, type, 1)
    src_view = view("src", source, choose("type", type, TYPES))
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
