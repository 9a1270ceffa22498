# SPDX-License-Identifier: MIT
"""Between numpy arrays and the views of libntp, without copies; memory for libntp.

A view is a pointer, two strides and a meaning.  Any array whose samples of a pixel are adjacent is
a view: crops, mirrored and strided arrays, a single channel, read-only and memory-mapped ones.
Others (planar or reversed channels, foreign byte order) are copied once on the way in, and on the
way out.
"""

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import ArgumentError, SampleTypeError, Status
from ._names import HEIGHT, STANDARD, VECTOR, XY, ZZERO
from ._native import ffi, lib

T = TypeVar("T")

DEPTHS: dict[Any, np.dtype[Any]] = {
    8: np.dtype(np.uint8),
    16: np.dtype(np.uint16),
    "float": np.dtype(np.float32),
}
MOST = 1.7e308  # within the range of a double

SAMPLE_TYPES: dict[np.dtype[Any], int] = {
    np.dtype(np.uint8): lib.NTP_TYPE_U8,
    np.dtype(np.uint16): lib.NTP_TYPE_U16,
    np.dtype(np.float32): lib.NTP_TYPE_F32,
}
_KINDS = {dtype.str[1:] for dtype in SAMPLE_TYPES}  # in any byte order
_MAY_BE_DOUBLES = ("vector", "height")
CHANNELS = {STANDARD: (3, 4), ZZERO: (3, 4), XY: (2, 4), VECTOR: (3, 4), HEIGHT: (1, 4)}
MAX_SIDE: int = lib.NTP_MAX_SIDE
_MOST_IDLE = 2  # pieces of memory that a pool keeps
_OVERLAP_WORK: Any = 10_000  # steps that numpy may take to tell whether two arrays share memory


def choose(name: str, value: Any, table: Mapping[Any, T]) -> T:
    """table[value], or an error that names the argument and what it can be."""
    try:
        return table[value]
    except (KeyError, TypeError):
        choices = ", ".join(map(repr, table))
        raise ArgumentError(f"{name}={value!r}: must be one of {choices}") from None


def number(name: str, value: Any, low: float, high: float) -> float:
    """A finite float within low..high."""
    try:
        result = float(value)
    except (TypeError, ValueError):
        raise ArgumentError(f"{name}={value!r}: must be a number") from None
    if not low <= result <= high:
        raise ArgumentError(f"{name}={value!r}: must be within {low:g}..{high:g}")
    return result


def spacing(dx: Any, dy: Any) -> tuple[float, float]:
    """The arguments `dx` and `dy`: width and height of a texel."""
    width, height = number("dx", dx, 0, MOST), number("dy", dy, 0, MOST)
    if width == 0 or height == 0:
        raise ArgumentError(f"dx={dx!r}, dy={dy!r}: must be greater than 0")
    return width, height


def pixels(name: str, value: ArrayLike, type: str = "auto") -> NDArray[Any]:
    """The argument as an array that a view can describe; copied only where that takes it.

    Vectors and heights may be float64: they are rounded here, once, to float32.
    """
    if isinstance(value, np.ma.MaskedArray):
        raise SampleTypeError(
            f"{name}: masked arrays are not taken, because the mask would be lost; "
            "filled(0) makes it an array, in which black texels are unused"
        )
    array = value if isinstance(value, np.ndarray) else np.asarray(value)
    if array.dtype not in SAMPLE_TYPES:
        if array.dtype.kind == "f" and array.itemsize == 8 and type in _MAY_BE_DOUBLES:
            with np.errstate(over="ignore"):  # infinities are counted as such
                array = array.astype(np.float32)
        elif array.dtype.str[1:] in _KINDS:
            array = array.astype(array.dtype.newbyteorder("="))
        else:
            raise SampleTypeError(_wrong_samples(name, array.dtype))
    if array.ndim not in (2, 3):
        raise ArgumentError(
            f"{name}: the shape must be (height, width) or (height, width, channels),"
            f" not {array.shape}",
            Status.SHAPE,
        )
    return array if _is_viewable(array) else np.ascontiguousarray(array)


def _wrong_samples(name: str, dtype: np.dtype[Any]) -> str:
    hint = ""
    if dtype.kind == "f":
        hint = "; astype(np.float32) makes it one of these"
    if dtype == np.float64:
        hint += '; vectors (type="vector") and heights may be float64'
    return f"{name}: samples must be uint8, uint16 or float32, not {dtype}{hint}"


def _is_viewable(array: NDArray[Any]) -> bool:
    """Samples of a pixel are adjacent, and everything is a multiple of a sample's size."""
    size = array.itemsize
    strides = array.strides
    if array.ndim == 3 and array.shape[2] > 1 and strides[2] != size:
        return False
    return strides[0] % size == 0 and strides[1] % size == 0 and array.flags.aligned


def view(
    name: str,
    array: NDArray[Any],
    encoding: int,
    y: int = lib.NTP_Y_UP,
    writable: bool = False,
) -> Any:
    """An ntp_image or ntp_const_image of an array, which the caller keeps alive."""
    shape, strides = array.shape, array.strides
    channels = shape[2] if len(shape) == 3 else 1
    if not 0 < shape[0] <= MAX_SIDE or not 0 < shape[1] <= MAX_SIDE:
        raise ArgumentError(
            f"{name}: width and height must be 1..{MAX_SIDE}, not {shape[1]} x {shape[0]}",
            Status.SHAPE,
        )
    low, high = CHANNELS[encoding]
    if not low <= channels <= high:
        raise ArgumentError(
            f"{name}: {low} to {high} channels are needed, the shape is {shape}", Status.FORMAT
        )
    kind = SAMPLE_TYPES[array.dtype]
    if encoding == VECTOR and kind != lib.NTP_TYPE_F32:
        raise SampleTypeError(
            f'{name}: type "vector" needs float32 or float64 samples, not {array.dtype}'
        )
    # the quicker way to the address; it takes memory without gaps, which one pixel is
    data = ffi.from_buffer(array if array.flags.c_contiguous else array[:1, :1])
    return ffi.new(
        "ntp_image *" if writable else "ntp_const_image *",
        (
            data,
            strides[0],
            strides[1],
            shape[1],
            shape[0],
            channels,
            0,
            kind,
            encoding,
            y,
        ),
    )


class Output:
    """Where an operation writes: a new array, or the caller's `out`.

    `array` is what the operation fills; `finish()` returns what the caller gets.  The two differ
    only where `out` is of a layout that no view can describe.
    """

    __slots__ = ("_result", "array")

    def __init__(self, shape: tuple[int, ...], dtype: np.dtype[Any], out: Any) -> None:
        if out is None:
            self.array: NDArray[Any] = np.empty(shape, dtype)
            self._result = self.array
            return
        if not isinstance(out, np.ndarray):
            raise ArgumentError(f"out: must be a numpy array, not {type(out).__name__}")
        if out.shape != shape or out.dtype.newbyteorder("=") != dtype:
            raise ArgumentError(
                f"out: must be an array of shape {shape} and {dtype},"
                f" not of shape {out.shape} and {out.dtype}",
                Status.SHAPE,
            )
        if not out.flags.writeable:
            raise ArgumentError("out: the array is read-only")
        self._result = out
        if out.dtype in SAMPLE_TYPES and _is_viewable(out):
            self.array = out
        else:
            self.array = np.empty(shape, dtype)

    def apart_from(self, in_place: bool, **sources: NDArray[Any]) -> None:
        """Refuses overlap; with in_place a source may be exactly the output."""
        for name, source in sources.items():
            if not np.may_share_memory(self.array, source):
                continue
            if in_place and _is_same(self.array, source):
                continue
            try:
                shares = np.shares_memory(
                    self.array,
                    source,
                    max_work=_OVERLAP_WORK,
                )
            except np.exceptions.TooHardError:
                shares = True
            if shares:
                allowed = f"the same array as {name}, or " if in_place else ""
                raise ArgumentError(
                    f"out: overlaps {name}; it must be {allowed}memory apart", Status.OVERLAP
                )

    def finish(self) -> Any:
        if self._result is not self.array:
            self._result[...] = self.array
        return self._result


def _is_same(a: NDArray[Any], b: NDArray[Any]) -> bool:
    return (
        a.__array_interface__["data"][0] == b.__array_interface__["data"][0]
        and a.shape == b.shape
        and a.strides == b.strides
        and a.dtype == b.dtype
    )


def memory(size: int, alignment: int = 16) -> tuple[Any, NDArray[np.uint8]]:
    """Zeroed memory at a multiple of `alignment`: a pointer, and the array that owns it."""
    owner = np.zeros(size + alignment, np.uint8)
    start = ffi.from_buffer(owner)
    address = int(ffi.cast("uintptr_t", start))
    return ffi.cast("void *", start + -address % alignment), owner


class Pool:
    """Zeroed memory of one size, cleared after use and used again.

    Fresh memory costs more than a small texture: the system zeroes each page at its first touch.
    """

    def __init__(self, size: int, clear: Callable[[Any], object]) -> None:
        self._size, self._clear = size, clear
        self._idle: list[tuple[Any, NDArray[np.uint8]]] = []

    def take(self) -> tuple[Any, NDArray[np.uint8]]:
        """As `memory`."""
        try:
            return self._idle.pop()
        except IndexError:
            return memory(self._size)

    def give(self, pointer: Any, owner: NDArray[np.uint8]) -> None:
        """Takes back what is not used any more."""
        if len(self._idle) < _MOST_IDLE:
            self._clear(pointer)
            self._idle.append((pointer, owner))
