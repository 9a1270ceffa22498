# SPDX-License-Identifier: MIT
"""Heightfields to normals."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import DEPTHS, Output, choose, memory, pixels, view
from ._classify import classify
from ._errors import ArgumentError, Status, check
from ._green import choose_y
from ._height_scale import normals_options, rescale, with_its_source
from ._measure import _Result
from ._names import BORDERS, HEIGHT, KERNELS, SOURCES, TYPES, YS, names_of
from ._native import ffi, lib
from ._threads import run
from ._undo import SURE
from .typing import (
    Alpha,
    AnyHeight,
    Blue,
    Border,
    Depth,
    Dither,
    Floats,
    GivenY,
    HeightSource,
    Kernel,
    LikeSettings,
    NormalsHow,
    Scale,
    Stored,
    Type,
)

_COLOR = 3  # channels
_DITHERS = {"none": False, "integrable": True}
_KERNEL_NAMES, _BORDER_NAMES, _SOURCE_NAMES, _Y_NAMES = map(
    names_of, (KERNELS, BORDERS, SOURCES, YS)
)


@dataclass(frozen=True)
class NormalsCounts(_Result):
    """What `normals_from_height` counted.

    Attributes
    ----------
    not_finite : int
        Float heights: texels with a NaN or an infinity under the stencil, made flat.
    exact : int
        Texels whose rounding needed more precision than a double.
    """

    not_finite: int
    exact: int


def like(name: str, value: float) -> LikeSettings:
    """Give the arguments of `normals_from_height` that make another program's picture.

    Parameters
    ----------
    name : str
        "reference" (Eric Haines' NormalTextureProcessor), "eberly", "zima", "zima-corrected",
        "gegl", or "gimp-normalmap:" and the name of its filter, such as
        "gimp-normalmap:sobel3".
    value : float
        The strength in that program: its `-hfs`, sigma, normalStrength or scale.

    Returns
    -------
    dict
        `scale`, `kernel`, `border`, `source` and `to_y`.  "zima" also stores z in green and y in
        blue: use `pack_channels(normals, "xzy")` for this.

    Raises
    ------
    ArgumentError
        For another name, or a value that is not finite.

    Notes
    -----
    docs/equivalences.md says how the programs differ from that.

    Examples
    --------
    >>> import normaltexture as nt
    >>> nt.like("gegl", 10)
    {'scale': 10.0, 'kernel': 'central', 'border': 'clamp', 'source': 'luma', 'to_y': 'down'}
    >>> height = nt.read("wall_height.png")
    >>> normals = nt.normals_from_height(height, **nt.like("gegl", 10))
    >>> sharper = nt.normals_from_height(height, **nt.like("gegl", 10) | {"scale": 30})
    """
    peer = ffi.new("ntp_peer *")
    try:
        status = lib.ntp_normals_like(peer, name.encode(), float(value))
    except (AttributeError, TypeError, ValueError):
        status = Status.ARGUMENT
    if status != Status.OK:
        raise ArgumentError(
            f"name={name!r}, value={value!r}: the name must be one of reference, eberly, zima,"
            " zima-corrected, gegl and gimp-normalmap:FILTER, the value a finite number"
        )
    how: Any = {
        "scale": peer.options.scale,
        "kernel": _KERNEL_NAMES[peer.options.kernel],
        "border": _BORDER_NAMES[peer.options.border_x],
        "source": _SOURCE_NAMES[peer.options.source],
        "to_y": _Y_NAMES[peer.y],
    }
    settings: LikeSettings = how
    return settings


@overload
def normals_from_height(
    height: NDArray[np.uint8],
    scale: Scale,
    *,
    to: Stored = ...,
    depth: None = ...,
    out: NDArray[np.uint8] | None = ...,
    **how: Unpack[NormalsHow],
) -> NDArray[np.uint8]: ...
@overload
def normals_from_height(
    height: NDArray[np.uint16],
    scale: Scale,
    *,
    to: Stored = ...,
    depth: None = ...,
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[NormalsHow],
) -> NDArray[np.uint16]: ...
@overload
def normals_from_height(
    height: Floats,
    scale: Scale,
    *,
    to: Stored = ...,
    depth: None = ...,
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[NormalsHow],
) -> NDArray[np.uint16]: ...
@overload
def normals_from_height(
    height: AnyHeight,
    scale: Scale,
    *,
    to: Stored = ...,
    depth: Literal[8],
    out: NDArray[np.uint8] | None = ...,
    **how: Unpack[NormalsHow],
) -> NDArray[np.uint8]: ...
@overload
def normals_from_height(
    height: AnyHeight,
    scale: Scale,
    *,
    to: Stored = ...,
    depth: Literal[16],
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[NormalsHow],
) -> NDArray[np.uint16]: ...
@overload
def normals_from_height(
    height: AnyHeight,
    scale: Scale,
    *,
    to: Type = ...,
    depth: Literal["float"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[NormalsHow],
) -> NDArray[np.float32]: ...
@overload
def normals_from_height(
    height: AnyHeight,
    scale: Scale,
    *,
    to: Literal["vector"],
    depth: None = ...,
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[NormalsHow],
) -> NDArray[np.float32]: ...
def normals_from_height(
    height: AnyHeight,
    scale: Scale,
    *,
    strength: float = 1.0,
    dx: float = 1.0,
    dy: float = 1.0,
    invert: bool = False,
    kernel: Kernel = "central",
    border: Border = "wrap",
    border_x: Border | None = None,
    border_y: Border | None = None,
    source: HeightSource | None = None,
    dither: Dither = "none",
    to: Type = "standard",
    to_y: GivenY = "up",
    depth: Depth | None = None,
    blue: Blue = "derived",
    min_z: float = 0.0,
    alpha: Alpha | None = None,
    out: NDArray[Any] | None = None,
    threads: int = 1,
) -> NDArray[Any]:
    """Make normals from heights: n = (-p, -q, 1)/sqrt(1 + p p + q q), p, q the slopes.

    Red and green are the correctly rounded values of the formula, for every input.

    Parameters
    ----------
    height : array, (height, width) or (height, width, 1 to 4), uint8, uint16 or float32
        Heights may be float64; they are rounded once, to float32.
        A heightfield, or an image with a height in each pixel; full range is 0..1.
    scale : float or "auto"
        How many texels a height of 1 (white) rises above 0; negative turns hills into dents.
        "auto": `suggest_scale` of these heights.
    strength : float
        Multiplies the scale, -1024..1024.
    dx, dy : float
        Width and height of a texel.
    invert : bool
        Black is high and white is low.
    kernel : {"central", "forward", "prewitt3", "sobel3", "scharr3", "prewitt5", "sobel5", \
"gimp5", "gimp7", "gimp9"}
        How a slope is computed; all are equally strong.
    border, border_x, border_y : {"wrap", "clamp", "mirror", "extrapolate", "repeat-slope"}
        The height beyond the edges; for both axes, or one.
    source : {"red", "green", "blue", "alpha", "luma", "luma-gimp", "luma-eberly", "mean", \
"max", "min", "screen"}, optional
        What of a color image is the height.  By default it is red, and an image that holds
        normals already (at least 90 % sure) is refused, as by `ntp from-height`.
    dither : {"none", "integrable"}
        "integrable": pass rounding errors on, so that heights can be reconstructed accurately.
    to : {"standard", "zzero", "xy", "vector"}
        How the result stores a normal.
    to_y : {"up", "down", "opengl", "directx"}
        Which way green points in the result.
    depth : {8, 16, "float"}, optional
        Samples of the result: uint8, uint16 or float32 in 0..1; by default those of `height`, and
        16 for floats, as on the command line.
    blue : {"derived", "nearest"}
        Computed from the rounded red and green, so that `clean` changes nothing; or z rounded
        independently.
    min_z : float
        The least z, 0..1: steeper normals are raised to it.
    alpha : {"keep", "one", "inverse", "height", "inverse-height"}, optional
        The alpha of the result: that of `height`, opaque, 1 minus that of `height`, the height
        (LabPBR), or 1 minus the height.  By default the result keeps the alpha of `height`, if it
        has one.
    out : array, optional
        Where to write; it does not overlap `height`.
    threads : int
        How many threads share the rows; 0: one for each processor.  The bytes are the same.

    Returns
    -------
    array, (height, width, 3 or 4)

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Notes
    -----
    `blur_height` blurs the heights first, `pack_channels` arranges the channels of the
    result, and `like` gives the arguments for another program's picture.

    docs/arithmetic.md defines kernels and borders; the construction is that of D. Eberly,
    "Reconstructing a Height Field from a Normal Map", equations 3 to 11.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> ramp = np.array([[0, 85, 170, 255]] * 2, np.uint8)
    >>> nt.normals_from_height(ramp, scale=3, border="extrapolate")[0]
    array([[ 37, 128, 217],
           [ 37, 128, 217],
           [ 37, 128, 217],
           [ 37, 128, 217]], dtype=uint8)
    """
    how = normals_options(
        scale, dx, dy, invert, kernel, border, border_x, border_y, source, blue, min_z, alpha
    )
    _no_normals(height, source, threads)
    rescale(how, height, scale, strength)
    return _normals(height, how, dither, to, to_y, depth, alpha is not None, out, threads)[0]


@overload
def normals_from_height_with_counts(
    height: NDArray[np.uint8],
    scale: Scale,
    *,
    to: Stored = ...,
    depth: None = ...,
    out: NDArray[np.uint8] | None = ...,
    **how: Unpack[NormalsHow],
) -> tuple[NDArray[np.uint8], NormalsCounts]: ...
@overload
def normals_from_height_with_counts(
    height: NDArray[np.uint16],
    scale: Scale,
    *,
    to: Stored = ...,
    depth: None = ...,
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[NormalsHow],
) -> tuple[NDArray[np.uint16], NormalsCounts]: ...
@overload
def normals_from_height_with_counts(
    height: Floats,
    scale: Scale,
    *,
    to: Stored = ...,
    depth: None = ...,
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[NormalsHow],
) -> tuple[NDArray[np.uint16], NormalsCounts]: ...
@overload
def normals_from_height_with_counts(
    height: AnyHeight,
    scale: Scale,
    *,
    to: Stored = ...,
    depth: Literal[8],
    out: NDArray[np.uint8] | None = ...,
    **how: Unpack[NormalsHow],
) -> tuple[NDArray[np.uint8], NormalsCounts]: ...
@overload
def normals_from_height_with_counts(
    height: AnyHeight,
    scale: Scale,
    *,
    to: Stored = ...,
    depth: Literal[16],
    out: NDArray[np.uint16] | None = ...,
    **how: Unpack[NormalsHow],
) -> tuple[NDArray[np.uint16], NormalsCounts]: ...
@overload
def normals_from_height_with_counts(
    height: AnyHeight,
    scale: Scale,
    *,
    to: Type = ...,
    depth: Literal["float"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[NormalsHow],
) -> tuple[NDArray[np.float32], NormalsCounts]: ...
@overload
def normals_from_height_with_counts(
    height: AnyHeight,
    scale: Scale,
    *,
    to: Literal["vector"],
    depth: None = ...,
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[NormalsHow],
) -> tuple[NDArray[np.float32], NormalsCounts]: ...
def normals_from_height_with_counts(
    height: AnyHeight,
    scale: Scale,
    *,
    strength: float = 1.0,
    dx: float = 1.0,
    dy: float = 1.0,
    invert: bool = False,
    kernel: Kernel = "central",
    border: Border = "wrap",
    border_x: Border | None = None,
    border_y: Border | None = None,
    source: HeightSource | None = None,
    dither: Dither = "none",
    to: Type = "standard",
    to_y: GivenY = "up",
    depth: Depth | None = None,
    blue: Blue = "derived",
    min_z: float = 0.0,
    alpha: Alpha | None = None,
    out: NDArray[Any] | None = None,
    threads: int = 1,
) -> tuple[NDArray[Any], NormalsCounts]:
    """Make normals from heights, and count special cases.

    Parameters
    ----------
    height, scale, strength, dx, dy, invert, kernel, border, border_x, border_y, source, dither, to, to_y, \
depth, blue, min_z, alpha, out, threads
        As in `normals_from_height`.

    Returns
    -------
    (array, NormalsCounts)

    Raises
    ------
    ArgumentError, SampleTypeError
        As `normals_from_height`.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> hole = np.zeros((4, 4), np.float32)
    >>> hole[1, 1] = np.nan
    >>> nt.normals_from_height_with_counts(hole, 1)[1].not_finite
    4
    """
    how = normals_options(
        scale, dx, dy, invert, kernel, border, border_x, border_y, source, blue, min_z, alpha
    )
    _no_normals(height, source, threads)
    rescale(how, height, scale, strength)
    result, parts = _normals(height, how, dither, to, to_y, depth, alpha is not None, out, threads)
    return result, NormalsCounts(
        sum(part.not_finite for part in parts), sum(part.exact for part in parts)
    )


def _no_normals(height: AnyHeight, source: HeightSource | None, threads: int) -> None:
    """Refuses normals in the place of heights, unless a channel is named."""
    array = pixels("height", height, "height")
    if source is not None or array.ndim != 3 or array.shape[2] < _COLOR:
        return
    found = classify(array, threads=threads)
    if (found.type in TYPES or found.type == "object-space") and found.confidence >= SURE:
        raise ArgumentError(
            f"height: it holds normals already ({found.type}, {100 * found.confidence:.0f} % "
            'sure), not heights; source="red" takes the first channel'
        )


def _normals(
    height: AnyHeight,
    how: Any,
    dither: Dither,
    to: Type,
    to_y: GivenY,
    depth: Depth | None,
    with_alpha: bool,
    out: Any,
    threads: int,
) -> tuple[NDArray[Any], list[Any]]:
    """The array, and an ntp_normals_counts for each part of the work."""
    array = pixels("height", height, "height")
    target, y = choose("to", to, TYPES), choose_y("to_y", to_y)
    has_alpha = with_its_source(array, how)
    of_alpha = how.source == lib.NTP_HEIGHT_SOURCE_ALPHA
    if depth is None and (to == "vector" or array.dtype.kind != "f"):
        dtype = DEPTHS["float"] if to == "vector" else array.dtype
    else:
        dtype = choose("depth", 16 if depth is None else depth, DEPTHS)
    count = 4 if with_alpha or (has_alpha and not of_alpha) else 3
    if isinstance(out, np.ndarray) and out.ndim == 3 and 2 <= out.shape[2] <= 4:
        count = out.shape[2]
    output = Output((*array.shape[:2], count), dtype, out)
    if out is not None:
        output.apart_from(False, height=array)
    src_view = view("height", array, HEIGHT)
    dst = view("out", output.array, target, y, writable=True)

    def work(areas: Iterable[Any]) -> Any:
        counts = ffi.new("ntp_normals_counts *")
        for area in areas:
            status = lib.ntp_normals_from_height(dst, src_view, how, counts, area)
            check(status, "normals_from_height")
        return counts

    if choose("dither", dither, _DITHERS):
        parts = [_dithered(dst, src_view, how, array.shape[1])]
    else:
        parts = run(threads, array.shape[1], array.shape[0], work)
    result: NDArray[Any] = output.finish()
    return result, parts


def _dithered(dst: Any, src: Any, how: Any, width: int) -> Any:
    """One pass down the rows: each takes over the rounding errors of the one above."""
    size = lib.ntp_normals_dithered_scratch_size(width)
    counts = ffi.new("ntp_normals_counts *")
    where, owner = memory(size)
    status = lib.ntp_normals_dithered(dst, src, how, where, size, counts, ffi.NULL)
    del owner
    check(status, 'normals_from_height: dither="integrable"')
    return counts
