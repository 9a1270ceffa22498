# SPDX-License-Identifier: MIT
"""What a texture is by its statistics, and how it is best cleaned."""

from dataclasses import dataclass
from typing import Any, Literal, overload

from numpy.typing import NDArray

from ._arrays import choose, pixels
from ._errors import ArgumentError, check
from ._measure import Tally, _Result, tally
from ._names import ACCIDENTS, AUTO, CLASSES, CLEAN_METHODS, STANDARD, TYPES, VECTOR, names_of
from ._native import ffi, lib
from .typing import (
    AnyPixels,
    AutoType,
    ChosenMethod,
    Class,
    Floats,
    MeasuredType,
    Stored,
    Type,
)

_CLASS_NAMES: Any = names_of(CLASSES)
_METHOD_NAMES: Any = names_of(CLEAN_METHODS)
_CLAUSE = 128  # bytes of a reason, as a rule
_SURE = 0.8  # of a class that `ntp diff` takes for granted
_COLOR = 3  # channels; fewer are gray, or gray and alpha, which may be x and y


@dataclass(frozen=True)
class Classification(_Result):
    """What a texture is, with which confidence, and why.

    Attributes
    ----------
    type : str
        "standard", "zzero", "xy", "height", "object-space", "one-color" or "not-normals".
    confidence : float
        0..1; 0.5: two classes are equally likely.
    accidents : tuple of str
        What was done to it: "gamma", "red-is-z", "green-is-z", "dxt5nm", "lossy", "filtered",
        "z-flipped", "blue-constant".
    reasons : tuple of str
        English clauses, the most important first.
    """

    type: Class
    confidence: float
    accidents: tuple[str, ...]
    reasons: tuple[str, ...]


def _reason(reason: Any) -> str:
    size = _CLAUSE
    while True:
        text = ffi.new("char[]", size)
        length = lib.ntp_reason_text(text, size, reason)
        if length < size:
            return str(ffi.buffer(text, length)[:], "ascii")
        size = length + 1


def _measured(
    src: AnyPixels | Floats | Tally, type: MeasuredType, touch_unused: bool, threads: int
) -> Tally:
    return src if isinstance(src, Tally) else tally(src, type, touch_unused, threads)


def _natural_type(src: NDArray[Any]) -> MeasuredType:
    """What an array is measured as when its type is not known, as on the command line."""
    return "standard" if src.ndim == 3 and src.shape[2] >= _COLOR else "height"


def _classification(measured: Tally) -> Classification:
    found = ffi.new("ntp_classification *")
    check(lib.ntp_classify(found, measured._pointer), "classify")
    reasons = found.reasons
    return Classification(
        type=_CLASS_NAMES[found.type],
        confidence=found.confidence,
        accidents=tuple(name for name, bit in ACCIDENTS.items() if found.accidents & bit),
        reasons=tuple(_reason(reasons + i) for i in range(found.reason_count)),
    )


def classify(
    src: AnyPixels | Tally, *, touch_unused: bool = False, threads: int = 1
) -> Classification:
    """Tell standard, Z-zero and XY-only textures from heights, photographs and other maps.

    Parameters
    ----------
    src : array, (height, width) or (height, width, 1 to 4), or Tally
        A texture, or its measurement.  Two channels may be gray and alpha, or x and y.
    touch_unused : bool
        Look at pure black, pure white and transparent texels too.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    Classification

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import normaltexture as nt
    >>> texture = nt.read("wall_n.png")
    >>> nt.classify(texture).type
    'standard'
    >>> nt.classify(texture[..., ::-1]).accidents
    ('red-is-z',)
    >>> nt.classify(nt.read("wall_height.png")).type
    'height'
    """
    if isinstance(src, Tally):
        return _classification(src)
    source = pixels("src", src)
    return _classification(_measured(source, _natural_type(source), touch_unused, threads))


@dataclass(frozen=True)
class MethodChoice(_Result):
    """The cleaning method chosen by the errors of a texture, and the reason.

    Attributes
    ----------
    method : {"derive", "normalize", "keep"}
    reason : str
        An English clause.
    """

    method: ChosenMethod
    reason: str


@overload
def choose_method(
    src: Floats | Tally,
    *,
    type: Literal["vector"],
    lossy: bool = ...,
    threads: int = ...,
) -> MethodChoice: ...
@overload
def choose_method(
    src: AnyPixels | Tally,
    *,
    type: Stored = ...,
    lossy: bool = ...,
    threads: int = ...,
) -> MethodChoice: ...
def choose_method(
    src: AnyPixels | Floats | Tally,
    *,
    type: Type = "standard",
    lossy: bool = False,
    threads: int = 1,
) -> MethodChoice:
    """Choose the cleaning method by the errors of a texture.

    Parameters
    ----------
    src : array, (height, width, channels) of 3 or 4 channels, or Tally
        A texture, or its measurement.
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored.
    lossy : bool
        The texture comes from a file format that is known to be lossy, such as JPEG.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    MethodChoice
        "keep" if every used texel is correctly rounded, so that there is nothing to repair;
        "normalize" if all three channels are off, as after lossy compression or resizing; "derive"
        otherwise.  `clean` does the same with `method="auto"`; it does not take "keep".

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import normaltexture as nt
    >>> nt.choose_method(nt.read("wall_n.png")).method
    'derive'
    """
    encoding = _as_read(choose("type", type, TYPES))
    measured = _measured(src, type, False, threads)
    method, why = ffi.new("ntp_clean_method *"), ffi.new("ntp_reason *")
    counts = measured._pointer
    check(lib.ntp_choose_method(method, why, counts, encoding, bool(lossy)), "choose_method")
    return MethodChoice(_METHOD_NAMES[method[0]], _reason(why))


def _as_read(encoding: int) -> int:
    """What the samples are read as: vectors are judged as standard levels."""
    return STANDARD if encoding == VECTOR else encoding


def resolve(src: NDArray[Any], type: AutoType, threads: int, name: str = "src") -> Type:
    """The argument `type`, "auto" found out as the command line does."""
    if type != "auto":
        choose("type", type, {"auto": AUTO} | TYPES)
        return type
    return type_of(_measured(src, _natural_type(src), False, threads), name)


def likely(src: NDArray[Any], threads: int) -> MeasuredType:
    """What an array is compared as: as the texels tell, where they are sure; never refused."""
    if src.ndim < _COLOR or src.shape[2] == 1:
        return "height"
    found = _classification(_measured(src, _natural_type(src), False, threads))
    if found.type == "xy" or (found.type == "zzero" and found.confidence >= _SURE):
        return found.type
    return "height" if src.shape[2] < _COLOR else "standard"


def natural_tally(src: NDArray[Any], threads: int) -> Tally:
    """The measurement by which `classify` judges an array."""
    return _measured(src, _natural_type(src), False, threads)


def resolve_both(
    src: NDArray[Any], type: AutoType, method: int, threads: int, known: Tally | None = None
) -> tuple[Type, int]:
    """The arguments `type` and, AUTO for "auto", `method` of `clean`; `known` is its natural tally."""
    measured = _natural_type(src) if type == "auto" else type
    counted = known if type == "auto" and known else _measured(src, measured, False, threads)
    found = type_of(counted) if type == "auto" else type
    if method == AUTO:
        if found != measured:
            counted = _measured(src, found, False, threads)
        chosen = ffi.new("ntp_clean_method *")
        encoding = _as_read(choose("type", found, TYPES))
        check(lib.ntp_choose_method(chosen, ffi.NULL, counted._pointer, encoding, 0), "clean")
        method = chosen[0]
    return found, method


def type_of(measured: Tally, name: str = "src", kind: Class | None = None) -> Type:
    """How a texture that was measured stores its normals; `kind` is what it was classified as."""
    if kind is None:
        result = ffi.new("ntp_classification *")
        check(lib.ntp_classify(result, measured._pointer), "classify")
        kind = _CLASS_NAMES[result.type]
    if kind == "standard" or kind == "one-color":
        return "standard"
    if kind == "zzero" or kind == "xy":
        return kind
    because = "; ".join(_classification(measured).reasons)
    heights = "normals_from_height makes normals of it, or " if kind == "height" else ""
    raise ArgumentError(
        f'type="auto": {name} looks like {kind}, not like a normals texture ({because});'
        f' {heights}name its type to go on, such as type="standard"'
    )
