# SPDX-License-Identifier: MIT
"""What each channel of an array holds, in letters: x y z a, h (height), 0 and 1, - (nothing)."""

from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._arrays import Output, pixels, view
from ._errors import ArgumentError, Status, check
from ._names import HEIGHT
from ._native import ffi, lib
from .typing import AnyPixels, SampleT

Shape: TypeAlias = tuple[int, ...]
Place: TypeAlias = int | Literal["0", "1"]

_PLACES: dict[str, Place] = {"x": 0, "y": 1, "z": 2, "a": 3, "0": "0", "1": "1"}
_LETTERS = "xyza01"
_PACKED = "xyzah01"  # with the heights
_FULL = 4  # channels of the array that a layout picks from: x, y, z, alpha


def _one(dtype: np.dtype[Any]) -> float:
    return 1.0 if dtype.kind == "f" else int(np.iinfo(dtype).max)


def _named(letters: Any, known: str) -> str:
    """The argument `channels`."""
    if not isinstance(letters, str) or not 1 <= len(letters) <= _FULL or set(letters) - set(known):
        raise ArgumentError(
            f"channels={letters!r}: must be 1 to {_FULL} of the letters {' '.join(known)}"
        )
    return letters


class Packed:
    """An array that an operation fills with x, y, z and alpha, and the output made of it.

    Without letters the two are the same array, of `count` channels or as many as `out` has; where
    `count` is 0, of this shape.
    """

    def __init__(
        self,
        letters: str | None,
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
        self._places = [_PLACES[letter] for letter in _named(letters, _LETTERS)]
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


def _plane(name: str, value: AnyPixels, like: NDArray[Any]) -> NDArray[Any]:
    """The first channel of an image of the size of `like`, its numbers brought to these samples."""
    array = pixels(name, value)
    if array.shape[:2] != like.shape[:2]:
        raise ArgumentError(
            f"{name}: must be of the size of src, {like.shape[:2]}, not {array.shape[:2]}",
            Status.SHAPE,
        )
    first = array if array.ndim == 2 else array[..., 0]
    if first.dtype == like.dtype:
        return first
    result = np.empty(like.shape[:2], like.dtype)
    to, src = view(name, result, HEIGHT, writable=True), view(name, first, HEIGHT)
    check(lib.ntp_convert(to, src, ffi.NULL, ffi.NULL, ffi.NULL), name)
    return result


def pack_channels(
    src: NDArray[SampleT],
    channels: str,
    *,
    height: AnyPixels | None = None,
    ao: AnyPixels | None = None,
    alpha: AnyPixels | None = None,
    out: NDArray[SampleT] | None = None,
) -> NDArray[SampleT]:
    """Arrange the channels of a texture in another order, together with those of other images.

    Parameters
    ----------
    src : array, (height, width, 2 to 4), uint8, uint16 or float32
        A normals texture: x, y, z, alpha.
    channels : str
        What each channel of the result holds, one letter each of x y z 0 1, a (alpha) and h
        (height): "xzy", "xyzh" (LabPBR), "1y0x" (DXT5nm); one letter makes an array of two
        dimensions.
    height, ao, alpha : array, (height, width) or (height, width, channels), optional
        Images of the size of `src` and of any depth; the first channel is used, converted to the
        samples of `src`.  `height` is for h; `ao` (ambient occlusion) replaces z, which an XY
        texture does not have; `alpha` replaces the alpha of `src`.
    out : array, optional
        Where to write; it does not overlap the other arrays.

    Returns
    -------
    array, (height, width, letters), samples as in `src`
        A missing alpha is opaque.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here, and letters without data.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texture = np.array([[[128, 200, 232]]], np.uint8)
    >>> nt.pack_channels(texture, "xyzh", height=np.array([[77]], np.uint8))
    array([[[128, 200, 232,  77]]], dtype=uint8)
    """
    source = pixels("src", src)
    if source.ndim != 3 or not 2 <= source.shape[2] <= _FULL:
        raise ArgumentError(f"src: 2 to {_FULL} channels are needed, the shape is {source.shape}")
    planes: dict[str, Any] = {"0": 0, "1": _one(source.dtype), "a": _one(source.dtype)}
    planes |= {letter: source[..., at] for at, letter in enumerate("xyza"[: source.shape[2]])}
    others = {"h": ("height", height), "z": ("ao", ao), "a": ("alpha", alpha)}
    for letter, (name, other) in others.items():
        if other is not None:
            planes[letter] = _plane(name, other, source)
    letters = _named(channels, _PACKED)
    for letter in letters:
        if letter not in planes:
            lacking = "src has no z" if letter == "z" else "height is not given"
            raise ArgumentError(f"channels={channels!r}: {lacking}", Status.FORMAT)
    shape = source.shape[:2] if len(letters) == 1 else (*source.shape[:2], len(letters))
    output = Output(shape, source.dtype, out)
    given = {"src": source, "height": height, "ao": ao, "alpha": alpha}
    output.apart_from(False, **{name: np.asarray(a) for name, a in given.items() if a is not None})
    target = output.array[..., None] if output.array.ndim == 2 else output.array
    for channel, letter in enumerate(letters):
        target[..., channel] = planes[letter]
    result: NDArray[SampleT] = output.finish()
    return result
