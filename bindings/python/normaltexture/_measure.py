# SPDX-License-Identifier: MIT
"""Statistics of a texture."""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field
from operator import attrgetter
from struct import Struct
from typing import Any, Literal, Self, TypeVar, overload

import numpy as np

from ._arrays import Pool, choose, pixels, view
from ._errors import Status, check
from ._names import HEIGHT, MEASURED, STANDARD, TOUCH_ALL, TOUCH_NONE, VECTOR, ZZERO, names_of
from ._native import ffi, lib
from ._threads import run
from .typing import (
    AnyPixels,
    Floats,
    MeasuredType,
)

_LENGTH_BINS = 256
_LENGTHS = Struct(f"{_LENGTH_BINS}Q")  # faster than ffi.unpack
_GRAIN = 1 << 19  # texels: two tallies are to be added up
_TALLIES = Pool(lib.ntp_tally_size(), lambda memory: lib.ntp_tally_clear(memory))

T = TypeVar("T")


class _Result:
    """What the dataclasses of results share."""

    def to_dict(self) -> dict[str, Any]:
        """Plain dicts, lists and numbers, ready for json.dumps."""
        this: Any = self
        found: dict[str, Any] = _plain(asdict(this))
        return found


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(v) for v in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


@dataclass(frozen=True)
class Fit(_Result):
    """Results for the texels when blue is read in one way, as standard or as Z-zero.

    Attributes
    ----------
    neighbor, rounded, exact : int
        Texels that pass each verdict, unused ones included.
    exact_mirrored : int
        Texels whose blue is the exact one of a negative z.
    unused_neighbor, unused_rounded, unused_exact : int
        The unused ones among those that pass.
    used_levels_le : tuple of 4 int
        Used texels with x, y not too long whose blue is off by at most 0, 1, 2, 3 levels.
    length_min, length_mean, length_max : float
        Lengths of the vectors, 1 being right; of every texel.
    """

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


@dataclass(frozen=True)
class Channel(_Result):
    """A channel in levels, over every texel.

    Attributes
    ----------
    min, max : int
    mean : float
    """

    min: int
    max: int
    mean: float


@dataclass(frozen=True)
class Angles(_Result):
    """Angles in degrees between two vectors of each texel.

    Attributes
    ----------
    texels : int
        How many were measured.
    mean, p99, max : float
        Degrees; 99 percent of the texels are at or below `p99`, which is counted in steps of 0.001.
    """

    texels: int
    mean: float
    p99: float
    max: float


@dataclass(frozen=True)
class Stats(_Result):
    """What `measure` found.  Counts are of texels, and cover unused ones unless they say so.

    Attributes
    ----------
    texels, unused, black, white, transparent : int
        All texels; those that hold no normal, which are of three kinds.
    not_finite : int
        Float texels with a NaN or an infinity.
    max, stored_max : int
        The greatest level, 255 or 65535: that the texels were judged at, and that of the samples.
        They differ for 16-bit samples that are all multiples of 257.
    channels : int
    channel : tuple of Channel
        One for each channel.
    xy_too_long, xy_far_too_long : int
        Red and green alone are longer than 1; longer than 1.00774, the limit of Eric Haines'
        NormalTextureProcessor.
    neighbor_and_near : int
        Texels that pass `neighbor` as standard and are within that limit.
    z_negative : int
        Read as standard.
    unused_xy_too_long, unused_z_negative : int
        The unused ones among these.
    padding, padding_z_negative : int
        Used texels of one color whose red and green are near 0 or `max`, which no normal has; those
        among them with z negative. `used_mean` is without them.
    gray : int
        Red, green and blue are equal; without transparent texels.
    flat, distinct_flat : int
        Used texels with x and y 0 but for rounding, and their different colors.
    distinct : int
        Different colors of used texels, counted up to 2.
    levels_off_max : tuple of 2 int
        How far blue of a used texel is off at most, in levels, as standard and as Z-zero.
    alpha_zero, alpha_full : int
        Texels with alpha 0, and with alpha `max`; 0 without alpha.
    standard, zzero : Fit
        How texels fare when blue is read as standard, and as Z-zero.
    angles : Angles
        Between stored and cleaned vectors of used texels, by the type measured.
    used_mean : tuple of 4 float
        Means of red, green, blue and alpha over used texels, 0..1.
    near_gamma_flat : int
        Used texels within 3/255 of (188, 188): flat ones stored as sRGB.
    type : str
        The argument of `measure`.
    levels_off : tuple of int
        Texels with x, y not too long by how far their blue is off the derived one, in levels.
    lengths : tuple of 256 int
        Texels by length: bin i is i/128..(i+1)/128, the last one is open.
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
    padding: int
    padding_z_negative: int
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
    used_mean: tuple[float, ...]
    near_gamma_flat: int
    type: MeasuredType
    levels_off: tuple[int, ...] = field(repr=False)
    lengths: tuple[int, ...] = field(repr=False)

    @property
    def fit(self) -> Fit:
        """`zzero` for a texture measured as Z-zero, else `standard`."""
        return self.zzero if self.type == "zzero" else self.standard


def _made(cls: type[T], values: dict[str, Any]) -> T:
    """cls(**values), which in a frozen dataclass sets field after field and takes four times as
    long."""
    made = cls.__new__(cls)
    made.__dict__.update(values)
    return made


def _reader(ctype: str) -> Callable[[Any], dict[str, Any]]:
    """A function that gives the numbers in a C struct, and its arrays of numbers as tuples."""
    kinds = {name: member.type for name, member in ffi.typeof(ctype).fields}
    numbers = [name for name, kind in kinds.items() if kind.kind == "primitive"]
    arrays = [
        name
        for name, kind in kinds.items()
        if kind.kind == "array" and kind.item.kind == "primitive"
    ]
    all_numbers = attrgetter(*numbers)

    def read(struct: Any) -> dict[str, Any]:
        values = dict(zip(numbers, all_numbers(struct), strict=True))
        for name in arrays:
            values[name] = tuple(getattr(struct, name))
        return values

    return read


_read_stats, _read_fit = _reader("ntp_stats"), _reader("ntp_fit")
_read_channel, _read_angles = _reader("ntp_channel"), _reader("ntp_angles")


class Tally:
    """Measures a texture in parts: rows, tiles, or what other threads have measured.

    The sums are integers: parts add up to what the whole would give, in any order.  A tally takes
    22 MB of address space, of which a clean 8-bit texture touches little.

    Parameters
    ----------
    type : {"standard", "zzero", "xy", "vector", "height"}
        As in `measure`.
    touch_unused : bool
        Count pure black, pure white and transparent texels like any other.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texture = np.full((4, 4, 3), (128, 128, 255), np.uint8)
    >>> upper, lower = nt.Tally().add(texture[:2]), nt.Tally().add(texture[2:])
    >>> upper.merge(lower).stats().texels
    16
    """

    def __init__(self, *, type: MeasuredType = "standard", touch_unused: bool = False) -> None:
        self._encoding = choose("type", type, MEASURED)
        self._type: MeasuredType = type
        self._touch = TOUCH_ALL if touch_unused else TOUCH_NONE
        self._pointer, self._owner = _TALLIES.take()

    def __del__(self) -> None:
        if hasattr(self, "_owner"):
            _TALLIES.give(self._pointer, self._owner)

    def add(self, src: AnyPixels) -> Self:
        """Add the texels of an array, and return this tally.

        Parameters
        ----------
        src : array, (height, width, channels), uint8, uint16 or float32
            Vectors may be float64; they are rounded once, to float32.
            All that are added have samples of one type and the same number of channels.

        Raises
        ------
        ArgumentError, SampleTypeError
            For another depth or number of channels than before, and as `measure`.
        """
        source = pixels("src", src, names_of(MEASURED)[self._encoding])
        self._add(view("src", source, self._encoding), ffi.NULL)
        return self

    def _add(self, src_view: Any, area: Any) -> None:
        check(lib.ntp_tally_add(self._pointer, src_view, self._touch, area), "measure")

    def merge(self, other: Self) -> Self:
        """Add the content of another tally, and return this one.

        Raises
        ------
        ArgumentError
            Where the other was made of samples of another type or another number of channels.
        """
        check(lib.ntp_tally_merge(self._pointer, other._pointer), "merge")
        return self

    def stats(self) -> Stats:
        """Compute the statistics of what was added.

        Raises
        ------
        ArgumentError
            Where nothing was added.
        """
        struct = ffi.new("ntp_stats *")
        encoding = STANDARD if self._encoding in (VECTOR, HEIGHT) else self._encoding
        check(lib.ntp_tally_summarize(struct, self._pointer, encoding), "measure")
        blue = ZZERO if self._encoding == ZZERO else STANDARD
        channels = struct.channel[0 : struct.channels]
        values = _read_stats(struct)
        values["channel"] = tuple(_made(Channel, _read_channel(one)) for one in channels)
        values["standard"] = _made(Fit, _read_fit(struct.standard))
        values["zzero"] = _made(Fit, _read_fit(struct.zzero))
        values["angles"] = _made(Angles, _read_angles(struct.angles))
        values["type"] = self._type
        values["levels_off"] = self._levels_off(struct, blue)
        values["lengths"] = self._lengths(blue)
        return _made(Stats, values)

    def _lengths(self, blue: int) -> tuple[int, ...]:
        counts = ffi.new("uint64_t[]", _LENGTH_BINS)
        check(lib.ntp_tally_lengths(counts, self._pointer, blue), "measure")
        return _LENGTHS.unpack(ffi.buffer(counts))

    def _levels_off(self, struct: Any, blue: int) -> tuple[int, ...]:
        """Unused texels may be further off than used ones, so it can take more room than these."""
        size = struct.levels_off_max[blue == ZZERO] + 1
        counts = ffi.new("uint64_t[]", size)
        status = lib.ntp_tally_levels_off(counts, size, self._pointer, blue)
        if status == Status.ARGUMENT:
            size = struct.max + 1
            counts = ffi.new("uint64_t[]", size)
            status = lib.ntp_tally_levels_off(counts, size, self._pointer, blue)
        check(status, "measure")
        while size > 0 and counts[size - 1] == 0:
            size -= 1
        return tuple(ffi.unpack(counts, size))


@overload
def measure(
    src: Floats,
    *,
    type: Literal["vector"],
    touch_unused: bool = ...,
    threads: int = ...,
) -> Stats: ...
@overload
def measure(
    src: AnyPixels,
    *,
    type: Literal["standard", "zzero", "xy", "height"] = ...,
    touch_unused: bool = ...,
    threads: int = ...,
) -> Stats: ...
def measure(
    src: AnyPixels | Floats,
    *,
    type: MeasuredType = "standard",
    touch_unused: bool = False,
    threads: int = 1,
) -> Stats:
    """Measure a texture, in one pass.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4); floats are judged as 16-bit levels.
    type : {"standard", "zzero", "xy", "vector", "height"}
        How a normal is stored.  It decides the angles and histograms; counts of both readings of
        blue are in `standard` and `zzero`.  "height": a gray image, or any picture of 1 to 4
        channels; only the facts of each channel are measured.
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
    return tally(src, type, touch_unused, threads).stats()


def tally(src: AnyPixels | Floats, type: MeasuredType, touch_unused: bool, threads: int) -> Tally:
    """A tally of all of a texture."""
    encoding = choose("type", type, MEASURED)
    source = pixels("src", src, type)
    src_view = view("src", source, encoding)

    def work(areas: Iterable[Any]) -> Tally:
        part = Tally(type=type, touch_unused=touch_unused)
        for area in areas:
            part._add(src_view, area)
        return part

    first, *rest = run(threads, source.shape[1], source.shape[0], work, _GRAIN)
    for part in rest:
        first.merge(part)
    return first
