# SPDX-License-Identifier: MIT
"""What the statistics of a texture say it is, and how it is best cleaned."""

from dataclasses import dataclass
from typing import Any, Literal

from numpy.typing import ArrayLike, NDArray

from ._arrays import ENCODINGS, AnyType, MeasuredType, Type, choose, pixels
from ._errors import ArgumentError, check
from ._measure import Tally, _made, _Result, tally
from ._native import ffi, lib

Class = Literal["standard", "zzero", "xy", "height", "object-space", "one-color", "not-normals"]
CLASSES: tuple[Class, ...] = (
    "standard",
    "zzero",
    "xy",
    "height",
    "object-space",
    "one-color",
    "not-normals",
)
ACCIDENTS = {
    1: "gamma",
    2: "red-is-z",
    4: "green-is-z",
    8: "dxt5nm",
    16: "lossy",
    32: "filtered",
    64: "z-flipped",
    128: "blue-constant",
}

_METHODS: tuple[Literal["derive", "normalize", "keep"], ...] = ("derive", "normalize", "keep")
_CLAUSE = 128  # bytes of a reason, as a rule
_COLOR = 3  # channels; fewer are gray, or gray and alpha, which may be x and y


@dataclass(frozen=True)
class Classification(_Result):
    """What a texture is, how surely, and why.

    Attributes
    ----------
    type : str
        "standard", "zzero", "xy", "height", "object-space", "one-color" or "not-normals".
    confidence : float
        0..1; 0.5 is a coin toss between two.
    accidents : tuple of str
        What happened to it: "gamma", "red-is-z", "green-is-z", "dxt5nm", "lossy", "filtered",
        "z-flipped", "blue-constant".
    reasons : tuple of str
        English clauses, the weightiest first.
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
    src: ArrayLike | Tally, type: MeasuredType, touch_unused: bool, threads: int
) -> Tally:
    return src if isinstance(src, Tally) else tally(src, type, touch_unused, threads)


def _natural_type(src: NDArray[Any]) -> MeasuredType:
    """What an array is measured as when its type is not known, as on the command line."""
    return "standard" if src.ndim == 3 and src.shape[2] >= _COLOR else "height"


def _classification(measured: Tally) -> Classification:
    found = ffi.new("ntp_classification *")
    check(lib.ntp_classify(found, measured._pointer), "classify")
    reasons = found.reasons
    return _made(
        Classification,
        {
            "type": CLASSES[found.type],
            "confidence": found.confidence,
            "accidents": tuple([n for bit, n in ACCIDENTS.items() if found.accidents & bit]),
            "reasons": tuple([_reason(reasons + i) for i in range(found.reason_count)]),
        },
    )


def classify(
    src: ArrayLike | Tally, *, touch_unused: bool = False, threads: int = 1
) -> Classification:
    """Tell standard, Z-zero and XY-only textures from heights, photographs and other maps.

    Parameters
    ----------
    src : array, (height, width) or (height, width, 1 to 4), or Tally
        A texture, or what was measured of it.  Two channels may be gray and alpha, or x and y.
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
    """The cleaning method for which a texture's errors speak, and the evidence."""

    method: Literal["derive", "normalize", "keep"]
    reason: str


def choose_method(
    src: ArrayLike | Tally, *, type: Type = "standard", lossy: bool = False, threads: int = 1
) -> MethodChoice:
    """Find the cleaning method for which a texture's errors speak.

    Parameters
    ----------
    src : array, (height, width, channels) of 3 or 4 channels, or Tally
        A texture, or what was measured of it.
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored.
    lossy : bool
        The texture comes from a file format that is known to be lossy, such as JPEG.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    MethodChoice
        "keep" where every used texel is an honest rounding, "normalize" where all three channels
        err together, as after lossy compression or resizing, "derive" otherwise.
    """
    encoding = choose("type", type, ENCODINGS)
    measured = _measured(src, type, False, threads)
    method, why = ffi.new("ntp_clean_method *"), ffi.new("ntp_reason *")
    tally = measured._pointer
    check(lib.ntp_choose_method(method, why, tally, encoding % 3, bool(lossy)), "choose_method")
    return MethodChoice(_METHODS[method[0]], _reason(why))


def resolve(src: NDArray[Any], type: AnyType, threads: int) -> Type:
    """The argument `type`, "auto" found out as the command line does."""
    if type != "auto":
        choose("type", type, {"auto": 0} | ENCODINGS)
        return type
    return _type_of(_measured(src, _natural_type(src), False, threads))


def resolve_both(src: NDArray[Any], type: AnyType, method: int, threads: int) -> tuple[Type, int]:
    """The arguments `type` and, less than 0 for "auto", `method` of `clean`."""
    measured = _natural_type(src) if type == "auto" else type
    counted = _measured(src, measured, False, threads)
    found = _type_of(counted) if type == "auto" else type
    if method < 0:
        if found != measured:
            counted = _measured(src, found, False, threads)
        chosen = ffi.new("ntp_clean_method *")
        encoding = choose("type", found, ENCODINGS) % 3
        check(lib.ntp_choose_method(chosen, ffi.NULL, counted._pointer, encoding, 0), "clean")
        method = chosen[0]
    return found, method


def _type_of(measured: Tally) -> Type:
    result = ffi.new("ntp_classification *")
    check(lib.ntp_classify(result, measured._pointer), "classify")
    name: Class = CLASSES[result.type]
    if name == "standard" or name == "one-color":
        return "standard"
    if name == "zzero" or name == "xy":
        return name
    because = "; ".join(_classification(measured).reasons)
    raise ArgumentError(
        f'type="auto": src looks like {name}, not like a normals texture ({because});'
        ' name its type to go on, such as type="standard"'
    )
