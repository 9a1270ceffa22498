# SPDX-License-Identifier: MIT
"""What each channel of an array holds, in letters: x y z a, h (height), 0 and 1, - (nothing)."""

from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import HEIGHT, Output, pixels, view
from ._errors import ArgumentError, Status, check
from ._native import ffi, lib

Shape: TypeAlias = tuple[int, ...]
Place: TypeAlias = int | Literal["0", "1"]

_PLACES: dict[str, Place] = {"x": 0, "y": 1, "z": 2, "a": 3, "h": 3, "0": "0", "1": "1"}
_FULL = 4  # channels of the array that a layout picks from: x, y, z, alpha


def _one(dtype: np.dtype[Any]) -> float:
    return 1.0 if dtype.kind == "f" else int(np.iinfo(dtype).max)


class Packed:
    """An array that an operation fills with x, y, z and alpha, and the output made of it.

    Without letters the two are the same array, of `count` channels or as many as `out` has; where
    `count` is 0, of this shape.
    """

    def __init__(
        self,
        letters: str | None,
        known: str,
        shape: Shape,
        count: int,
        dtype: np.dtype[Any],
        out: Any,
    ) -> None:
        self._places: list[Place] | None = None
        if letters is None:
            if (
                count
                and isinstance(out, np.ndarray)
                and out.ndim == 3
                and 2 <= out.shape[2] <= _FULL
            ):
                count = out.shape[2]
            self.output = Output((*shape[:2], count) if count else shape, dtype, out)
            self.array = self.output.array
            return
        if (
            not isinstance(letters, str)
            or not 1 <= len(letters) <= _FULL
            or set(letters) - set(known)
        ):
            raise ArgumentError(
                f"channels={letters!r}: must be 1 to {_FULL} of the letters {' '.join(known)}"
            )
        self._places = [_PLACES[letter] for letter in letters]
        packed = shape[:2] if len(letters) == 1 else (*shape[:2], len(letters))
        self.output = Output(packed, dtype, out)
        self.array = np.empty((*shape[:2], _FULL), dtype)

    def finish(self) -> Any:
        """Lays out the channels; what the caller gets."""
        if self._places is not None:
            out = self.output.array
            planes = out[..., None] if out.ndim == 2 else out
            for channel, place in enumerate(self._places):
                if isinstance(place, int):
                    planes[..., channel] = self.array[..., place]
                else:
                    planes[..., channel] = 0 if place == "0" else _one(out.dtype)
        return self.output.finish()


def unpacked(source: NDArray[Any], letters: str) -> tuple[NDArray[Any], bool]:
    """x, y, z and alpha of an array in another layout, copied; is there a z?"""
    wrong = f"from_channels={letters!r}: "
    if not isinstance(letters, str) or not 2 <= len(letters) <= _FULL:
        raise ArgumentError(f"{wrong}must be 2 to {_FULL} letters, one for each channel")
    if set(letters) - set("xyza01-"):
        raise ArgumentError(f"{wrong}the letters are x y z a 0 1 -")
    if any(letters.count(letter) > 1 for letter in "xyza"):
        raise ArgumentError(f"{wrong}a letter stands twice")
    if "x" not in letters or "y" not in letters:
        raise ArgumentError(f"{wrong}x and y are needed")
    if source.ndim != 3 or source.shape[2] < len(letters):
        raise ArgumentError(
            f"{wrong}names more channels than src has, its shape is {source.shape}", Status.SHAPE
        )
    count = 4 if "a" in letters else 3
    planes = np.empty((*source.shape[:2], count), source.dtype)
    for channel, letter in enumerate("xyza"[:count]):
        at = letters.find(letter)
        planes[..., channel] = source[..., at] if at >= 0 else _one(source.dtype)
    return planes, "z" in letters


def plane(name: str, value: ArrayLike, shape: Shape, dtype: np.dtype[Any]) -> NDArray[Any]:
    """The first channel of an image of the size `shape`, its numbers brought to dtype."""
    array = pixels(name, value)
    if array.shape[:2] != shape[:2]:
        raise ArgumentError(
            f"{name}: must be of the size of height, {shape[:2]}, not {array.shape[:2]}",
            Status.SHAPE,
        )
    first = array if array.ndim == 2 else array[..., 0]
    if first.dtype == dtype:
        return first
    result = np.empty(shape[:2], dtype)
    to, src = view(name, result, HEIGHT, writable=True), view(name, first, HEIGHT)
    check(lib.ntp_convert(to, src, ffi.NULL, ffi.NULL, ffi.NULL), name)
    return result
