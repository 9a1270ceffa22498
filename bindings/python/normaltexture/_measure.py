# SPDX-License-Identifier: MIT
"""Statistics of a texture, and what they say it is.

`Stats` keeps the C struct as bytes beside its fields, so that `classify` takes either an array or
what `measure` has found, also from another process.
"""

import builtins
from dataclasses import asdict, dataclass, field
from struct import Struct
from typing import Any, Literal, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import (
    ENCODINGS,
    TOUCH_ALL,
    TOUCH_NONE,
    AnyType,
    Layout,
    Pool,
    Type,
    choose,
    pixels,
    run,
    view,
)
from ._errors import ArgumentError, Status, check
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

T = TypeVar("T")
_LENGTH_BINS = 256
_LENGTHS = Struct(f"{_LENGTH_BINS}Q")
_LAYOUT = Layout("ntp_stats")
_TALLIES = Pool(lib.ntp_tally_size(), lambda memory: lib.ntp_tally_clear(memory))


class _Result:
    """What the dataclasses of results share."""

    def to_dict(self) -> dict[str, Any]:
        """Plain dicts, lists and numbers, ready for json.dumps."""
        return _plain({k: v for k, v in asdict(self).items() if not k.startswith("_")})  # type: ignore[call-overload,no-any-return]


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(v) for v in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


@dataclass(frozen=True)
class Fit(_Result):
    """How texels fare when blue is read in one way; counts cover every texel."""

    neighbor: int
    rounded: int
    exact: int
    exact_mirrored: int
    unused_neighbor: int
    unused_rounded: int
    unused_exact: int
    used_levels_le: tuple[int, ...]
    length_min: float
    length_mean: float
    length_max: float
    used_length_mean: float
    used_length_sd: float
    used_near_unit: tuple[float, ...]
    used_short: float
    used_long: float


@dataclass(frozen=True)
class Channel(_Result):
    """A channel in levels, over every texel."""

    min: int
    max: int
    mean: float


@dataclass(frozen=True)
class Angles(_Result):
    """Angles in degrees between two vectors of each texel."""

    texels: int
    mean: float
    p99: float
    max: float


@dataclass(frozen=True)
class Stats(_Result):
    """What `measure` found; `ntp_stats` of libntp.h describes each field.

    `levels_off` and `lengths` are histograms: texels by the distance of their blue from the
    derived one, in levels, and by length, bin i being i/128..(i+1)/128, the last one open.
    """

    texels: int
    unused: int
    black: int
    white: int
    transparent: int
    not_finite: int
    max: int
    stored_max: int
    channels: int
    channel: tuple[Channel, ...]
    xy_too_long: int
    xy_far_too_long: int
    neighbor_and_near: int
    z_negative: int
    unused_xy_too_long: int
    unused_z_negative: int
    gray: int
    flat: int
    distinct_flat: int
    distinct: int
    levels_off_max: tuple[int, ...]
    alpha_zero: int
    alpha_full: int
    standard: Fit
    zzero: Fit
    angles: Angles
    steepness: tuple[int, ...]
    steepness_not_rounded: tuple[int, ...]
    steepness_not_neighbor: tuple[int, ...]
    steepness_length_error: tuple[float, ...]
    used_z_negative: int
    used_mean: tuple[float, ...]
    used_sd: tuple[float, ...]
    correlation: tuple[float, ...]
    red_low: int
    green_low: int
    near_gamma_flat: int
    gamma_near_unit: float
    ag_in_disc: float
    block_step: tuple[float, ...]
    tilted: int
    tilted_gap: float
    tilted_off: tuple[float, ...]
    tilted_near: tuple[float, ...]
    tilted_above: float
    blue_slope: float
    blue_correlation: float
    type: Type
    levels_off: tuple[int, ...] = field(repr=False)
    lengths: tuple[int, ...] = field(repr=False)
    _struct: bytes = field(repr=False, compare=False)

    @property
    def fit(self) -> Fit:
        """`zzero` for a texture measured as Z-zero, else `standard`."""
        return self.zzero if self.type == "zzero" else self.standard

    @classmethod
    def _from(cls, struct: Any, type: Type, levels_off: list[int], lengths: Any) -> Self:
        values = _LAYOUT.read(struct)
        values["channel"] = tuple(_made(Channel, c) for c in values["channel"][: struct.channels])
        values["standard"] = _made(Fit, values["standard"])
        values["zzero"] = _made(Fit, values["zzero"])
        values["angles"] = _made(Angles, values["angles"])
        values["type"] = type
        values["levels_off"] = tuple(levels_off)
        values["lengths"] = _LENGTHS.unpack(ffi.buffer(lengths))
        values["_struct"] = bytes(ffi.buffer(struct))
        return _made(cls, values)


def _made(cls: builtins.type[T], values: dict[str, Any]) -> T:
    """cls(**values) at once: a frozen dataclass sets field after field, which here takes longer
    than the measurement of a small texture."""
    made = object.__new__(cls)
    object.__setattr__(made, "__dict__", values)
    return made


class Tally:
    """Measures a texture in parts: rows, tiles, or what other threads have measured.

    The sums are integers: parts add up to what the whole would give, in any order.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texture = np.full((4, 4, 3), (128, 128, 255), np.uint8)
    >>> upper, lower = nt.Tally().add(texture[:2]), nt.Tally().add(texture[2:])
    >>> upper.merge(lower).stats().texels
    16
    """

    def __init__(self, *, type: Type = "standard", touch_unused: bool = False) -> None:
        self._encoding = choose("type", type, ENCODINGS)
        self._type: Type = type
        self._touch = TOUCH_ALL if touch_unused else TOUCH_NONE
        self._pointer, self._owner = _TALLIES.take()

    def __del__(self) -> None:
        if hasattr(self, "_owner"):
            _TALLIES.give(self._pointer, self._owner)

    def add(self, src: ArrayLike) -> Self:
        """Add the texels of an array; of one depth, and one number of channels."""
        source = pixels("src", src)
        self._add(view("src", source, self._encoding), ffi.NULL)
        return self

    def _add(self, src_view: Any, area: Any) -> None:
        check(lib.ntp_measure(self._pointer, src_view, self._touch, area), "measure")

    def merge(self, other: Self) -> Self:
        """Add what another tally holds."""
        check(lib.ntp_tally_merge(self._pointer, other._pointer), "merge")
        return self

    def stats(self) -> Stats:
        """Work out the statistics of what was added."""
        struct = self._summarize()
        z = 1 if self._encoding == 1 else 0
        lengths = ffi.new("uint64_t[]", _LENGTH_BINS)
        check(lib.ntp_lengths(lengths, self._pointer, z), "measure")
        return Stats._from(struct, self._type, self._levels_off(struct, z), lengths)

    def _summarize(self) -> Any:
        struct = ffi.new("ntp_stats *")
        encoding = 0 if self._encoding == 3 else self._encoding
        check(lib.ntp_summarize(struct, self._pointer, encoding), "measure")
        return struct

    def _levels_off(self, struct: Any, z: int) -> list[int]:
        """The histogram up to its last texel; unused texels may be further off than used ones."""
        size = struct.levels_off_max[z] + 1
        counts = ffi.new("uint64_t[]", size)
        status = lib.ntp_levels_off(counts, size, self._pointer, z)
        if status == Status.ARGUMENT:
            size = struct.max + 1
            counts = ffi.new("uint64_t[]", size)
            status = lib.ntp_levels_off(counts, size, self._pointer, z)
        check(status, "measure")
        while size > 0 and counts[size - 1] == 0:
            size -= 1
        values: list[int] = ffi.unpack(counts, size)
        return values


def measure(
    src: ArrayLike, *, type: Type = "standard", touch_unused: bool = False, threads: int = 1
) -> Stats:
    """Count and measure everything that is known about a texture, in one pass.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        A normals texture; floats are judged as 16-bit levels.
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored.  It decides the angles and histograms; counts of both readings of
        blue are in `standard` and `zzero`.
    touch_unused : bool
        Count pure black, pure white and transparent texels like any other.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    Stats

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texture = np.full((8, 8, 3), (128, 128, 255), np.uint8)
    >>> texture[0, 0] = 128, 128, 200
    >>> stats = nt.measure(texture)
    >>> stats.texels, stats.standard.neighbor, round(stats.standard.length_min, 3)
    (64, 63, 0.569)
    """
    return _tally(src, type, touch_unused, threads).stats()


def _tally(src: ArrayLike, type: Type, touch_unused: bool, threads: int) -> Tally:
    """A tally of all of a texture."""
    encoding = choose("type", type, ENCODINGS)
    source = pixels("src", src)
    src_view = view("src", source, encoding)

    def work(area: Any) -> Tally:
        tally = Tally(type=type, touch_unused=touch_unused)
        tally._add(src_view, area)
        return tally

    first, *rest = run(threads, source.shape[1], source.shape[0], work)
    for tally in rest:
        first.merge(tally)
    return first


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


def _struct_of(src: ArrayLike | Stats, type: Type, touch_unused: bool, threads: int) -> Any:
    if isinstance(src, Stats):
        return ffi.from_buffer("ntp_stats *", src._struct)
    return _tally(src, type, touch_unused, threads)._summarize()


def _reason(reason: Any) -> str:
    size = lib.ntp_reason_text(ffi.NULL, 0, reason) + 1
    text = ffi.new("char[]", size)
    lib.ntp_reason_text(text, size, reason)
    words: str = ffi.string(text).decode()
    return words


def classify(
    src: ArrayLike | Stats, *, touch_unused: bool = False, threads: int = 1
) -> Classification:
    """Tell standard, Z-zero and XY-only textures from heights, photographs and other maps.

    Parameters
    ----------
    src : array, (height, width, channels) of 3 or 4 channels, or Stats
        A texture, or what `measure` said about it.
    touch_unused : bool
        Look at pure black, pure white and transparent texels too.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    Classification

    Examples
    --------
    >>> import normaltexture as nt
    >>> texture = nt.read("wall_n.png")
    >>> nt.classify(texture).type
    'standard'
    >>> nt.classify(texture[..., ::-1]).accidents
    ('red-is-z',)
    """
    result = ffi.new("ntp_classification *")
    struct = _struct_of(src, "standard", touch_unused, threads)
    check(lib.ntp_classify(result, struct), "classify")
    return Classification(
        type=CLASSES[result.type],
        confidence=result.confidence,
        accidents=tuple(name for bit, name in ACCIDENTS.items() if result.accidents & bit),
        reasons=tuple(
            _reason(ffi.addressof(result.reasons, i)) for i in range(result.reason_count)
        ),
    )


@dataclass(frozen=True)
class MethodChoice(_Result):
    """The cleaning method for which a texture's errors speak, and the evidence."""

    method: Literal["derive", "normalize", "keep"]
    reason: str


def choose_method(
    src: ArrayLike | Stats, *, type: Type = "standard", lossy: bool = False, threads: int = 1
) -> MethodChoice:
    """Find the cleaning method for which a texture's errors speak.

    Parameters
    ----------
    src : array, (height, width, channels) of 3 or 4 channels, or Stats
        A texture, or what `measure` said about it.
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
    struct = _struct_of(src, type, False, threads)
    method, why = ffi.new("ntp_method *"), ffi.new("ntp_reason *")
    check(lib.ntp_choose_method(method, why, struct, encoding % 3, bool(lossy)), "choose_method")
    names: tuple[Literal["derive", "normalize", "keep"], ...] = ("derive", "normalize", "keep")
    return MethodChoice(names[method[0]], _reason(why))


def resolve(src: NDArray[Any] | Stats, type: AnyType, threads: int) -> Type:
    """The argument `type`, "auto" found out as the command line does."""
    if type != "auto":
        choose("type", type, {"auto": 0} | ENCODINGS)
        return type
    found = classify(src, threads=threads)
    if found.type == "standard" or found.type == "one-color":
        return "standard"
    if found.type == "zzero" or found.type == "xy":
        return found.type
    because = "; ".join(found.reasons)
    raise ArgumentError(
        f'type="auto": src looks like {found.type}, not like a normals texture ({because});'
        ' name its type to go on, such as type="standard"'
    )
