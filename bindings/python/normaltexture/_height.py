# SPDX-License-Identifier: MIT
"""Heightfields to normals."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import (
    DEPTHS,
    ENCODINGS,
    HEIGHT,
    MOST,
    YS,
    Depth,
    Pixels,
    Type,
    Y,
    choose,
    memory,
    number,
    pixels,
    spacing,
    view,
)
from ._channels import Packed, Shape, plane
from ._convert import BLUES, Blue
from ._errors import ArgumentError, Status, check
from ._measure import _Result
from ._native import ffi, lib
from ._threads import run

Kernel = Literal[
    "central",
    "forward",
    "prewitt3",
    "sobel3",
    "scharr3",
    "prewitt5",
    "sobel5",
    "gimp5",
    "gimp7",
    "gimp9",
]
Border = Literal["wrap", "clamp", "mirror", "extrapolate", "repeat-slope"]
Source = Literal[
    "red",
    "green",
    "blue",
    "alpha",
    "luma",
    "luma-gimp",
    "luma-eberly",
    "mean",
    "max",
    "min",
    "screen",
]
Alpha = Literal["keep", "one", "inverse", "height", "inverse-height"]
Dither = Literal["none", "integrable"]

KERNELS = {name: i for i, name in enumerate(get_args(Kernel))}
BORDERS = {name: i for i, name in enumerate(get_args(Border))}
_SOURCES = {name: i for i, name in enumerate(get_args(Source))}
_ALPHAS = {name: i for i, name in enumerate(get_args(Alpha))}
_DITHERS = {"none": False, "integrable": True}
_MAX_OCTAVES = 8


@dataclass(frozen=True)
class GradientCounts(_Result):
    """What `normals_from_height` met.

    Attributes
    ----------
    not_finite : int
        Float heights: texels with a NaN or an infinity under the stencil, made flat.
    exact : int
        Texels whose rounding took more than a double.
    """

    not_finite: int
    exact: int


def _like(like: str) -> Any:
    """The settings of another program: "reference:5", "gimp-normalmap:sobel3:1"."""
    name, _, value = like.rpartition(":")
    peer = ffi.new("ntp_peer *")
    try:
        status = lib.ntp_normals_like(peer, name.encode(), float(value))
    except ValueError:
        status = Status.ARGUMENT
    if status != Status.OK:
        raise ArgumentError(
            f"like={like!r}: must be NAME:VALUE, NAME one of reference, eberly, zima,"
            " zima-corrected, gegl and gimp-normalmap:FILTER"
        )
    return peer


def _blurred(
    source: NDArray[Any], blur: float, octaves: Sequence[float] | None, how: Any
) -> NDArray[np.float32]:
    """The weighted sum of the heights, blurred by `blur` and by 0, 1, 2, 4 ... texels; and alpha."""
    weights = [1.0] if octaves is None else [float(w) for w in octaves]
    if not 1 <= len(weights) <= _MAX_OCTAVES or not np.isfinite(weights).all():
        raise ArgumentError(f"octaves={octaves!r}: must be 1 to {_MAX_OCTAVES} finite numbers")
    height, width = source.shape[:2]
    has_alpha = source.ndim == 3 and source.shape[2] % 2 == 0
    result = np.empty((height, width, 1 + has_alpha), np.float32)
    dst, src = view("out", result, HEIGHT, writable=True), view("height", source, HEIGHT)
    for octave, weight in enumerate(weights):
        # blurring twice adds the squares of sigma
        own = 0.0 if octave == 0 else float(1 << (octave - 1))
        sigma = min(math.sqrt(blur * blur + own * own), float(lib.NTP_MAX_SIGMA))
        options = ffi.new(
            "ntp_blur_options *",
            (sigma, weight, int(octave > 0), how.border_x, how.border_y, how.source),
        )
        size = lib.ntp_height_blur_scratch_size(options, width)
        scratch, owner = memory(size)
        status = lib.ntp_height_blur(dst, src, options, scratch, size)
        del owner
        check(status, "normals_from_height: blur")
    if has_alpha:
        to = view("out", result[..., 1], HEIGHT, writable=True)
        alpha = view("height", source[..., -1], HEIGHT)
        check(lib.ntp_convert(to, alpha, ffi.NULL, ffi.NULL, ffi.NULL), "normals_from_height")
    return result


@overload
def normals_from_height(
    height: ArrayLike,
    *,
    scale: float | None = ...,
    dx: float = ...,
    dy: float = ...,
    invert: bool = ...,
    kernel: Kernel | None = ...,
    border: Border | None = ...,
    border_x: Border | None = ...,
    border_y: Border | None = ...,
    source: Source | None = ...,
    blur: float = ...,
    octaves: Sequence[float] | None = ...,
    dither: Dither = ...,
    like: str | None = ...,
    to: Type = ...,
    to_y: Y | None = ...,
    depth: Depth | None = ...,
    blue: Blue = ...,
    min_z: float = ...,
    alpha: Alpha | ArrayLike | None = ...,
    ao: ArrayLike | None = ...,
    channels: str | None = ...,
    return_counts: Literal[False] = ...,
    out: Pixels | None = ...,
    threads: int = ...,
) -> Pixels: ...
@overload
def normals_from_height(
    height: ArrayLike,
    *,
    scale: float | None = ...,
    dx: float = ...,
    dy: float = ...,
    invert: bool = ...,
    kernel: Kernel | None = ...,
    border: Border | None = ...,
    border_x: Border | None = ...,
    border_y: Border | None = ...,
    source: Source | None = ...,
    blur: float = ...,
    octaves: Sequence[float] | None = ...,
    dither: Dither = ...,
    like: str | None = ...,
    to: Type = ...,
    to_y: Y | None = ...,
    depth: Depth | None = ...,
    blue: Blue = ...,
    min_z: float = ...,
    alpha: Alpha | ArrayLike | None = ...,
    ao: ArrayLike | None = ...,
    channels: str | None = ...,
    return_counts: Literal[True],
    out: Pixels | None = ...,
    threads: int = ...,
) -> tuple[Pixels, GradientCounts]: ...
def normals_from_height(
    height: ArrayLike,
    *,
    scale: float | None = None,
    dx: float = 1.0,
    dy: float = 1.0,
    invert: bool = False,
    kernel: Kernel | None = None,
    border: Border | None = None,
    border_x: Border | None = None,
    border_y: Border | None = None,
    source: Source | None = None,
    blur: float = 0.0,
    octaves: Sequence[float] | None = None,
    dither: Dither = "none",
    like: str | None = None,
    to: Type = "standard",
    to_y: Y | None = None,
    depth: Depth | None = None,
    blue: Blue = "derived",
    min_z: float = 0.0,
    alpha: Alpha | ArrayLike | None = None,
    ao: ArrayLike | None = None,
    channels: str | None = None,
    return_counts: bool = False,
    out: Pixels | None = None,
    threads: int = 1,
) -> Pixels | tuple[Pixels, GradientCounts]:
    """Make normals from heights: n = (-p, -q, 1)/sqrt(1 + p p + q q), p, q the slopes.

    Red and green are the correctly rounded values of the formula, for every input.

    Parameters
    ----------
    height : array, (height, width) or (height, width, 1 to 4), uint8, uint16 or float32
        A heightfield, or an image of which one number is the height; full range is 0..1.
    scale : float
        How many texels a height of 1 (white) rises above 0; negative turns hills into dents.
        Needed, except with `like`.
    dx, dy : float
        Width and height of a texel.
    invert : bool
        Black is high and white is low.
    kernel : {"central", "forward", "prewitt3", "sobel3", "scharr3", "prewitt5", "sobel5", \
"gimp5", "gimp7", "gimp9"}
        How a slope is taken; all are equally strong.  Default: "central".
    border, border_x, border_y : {"wrap", "clamp", "mirror", "extrapolate", "repeat-slope"}
        The height beyond the edges; for both axes, or one.  Default: "wrap".
    source : {"red", "green", "blue", "alpha", "luma", "luma-gimp", "luma-eberly", "mean", \
"max", "min", "screen"}
        Which number of a color image is the height.  Default: "red".
    blur : float
        First blur the heights by a Gaussian of so many texels, 0..64.
    octaves : sequence of float, optional
        Take a weighted sum of the heights as they are, blurred by 1, by 2, by 4 texels and so on.
    dither : {"none", "integrable"}
        "integrable": carry rounding errors on, so that heights can be reconstructed well.
    like : str, optional
        The settings of another program, such as "reference:5", "eberly:4", "zima:8", "gegl:10" or
        "gimp-normalmap:sobel3:1"; arguments given beside it win.
    to : {"standard", "zzero", "xy", "vector"}
        How a normal is to be stored.
    to_y : {"up", "down"}
        Which way green is to point.  Default: "up".
    depth : {8, 16, "float"}, optional
        Samples of the result: uint8, uint16 or float32 in 0..1; by default those of `height`, and
        16 for floats, as on the command line.
    blue : {"derived", "nearest"}
        Computed from the rounded red and green, so that `clean` changes nothing; or z rounded by
        itself.
    min_z : float
        The least z, 0..1: steeper normals are turned up to it.
    alpha : {"keep", "one", "inverse", "height", "inverse-height"} or array, optional
        The alpha of the result: that of `height`, opaque, 1 minus that of `height`, the height
        (LabPBR), 1 minus the height, or the first channel of an image of the same size.  By
        default the result has one where `height` has, and keeps it.
    ao : array, optional
        With `to="xy"`: an image of the same size whose first channel goes into blue (LabPBR:
        ambient occlusion).
    channels : str, optional
        What each channel of the result holds, one letter each of x y z 0 1, h (height) and a
        (alpha): "xyz", "xzy", "xyzh", "1y0x"; one letter makes an array of two dimensions.
    return_counts : bool
        Return `GradientCounts` as well.
    out : array, optional
        Where to write; it does not overlap `height`.
    threads : int
        How many threads share the rows; 0: one for each processor.  The bytes are the same.

    Returns
    -------
    array, (height, width, 3 or 4), or (array, GradientCounts)

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Notes
    -----
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
    array = pixels("height", height)
    y = choose("to_y", "up" if to_y is None else to_y, YS)
    swap_green_blue = False
    how = ffi.new("ntp_normals_options *")
    if like is not None:
        if scale is not None:
            raise ArgumentError(f"scale={scale!r}: like sets the scale; leave it out")
        peer = _like(like)
        how[0] = peer.options
        y = peer.y if to_y is None else y
        swap_green_blue = bool(peer.swap_green_blue)
    elif scale is None:
        raise ArgumentError("scale=None: it is needed; how many texels a height of 1 rises")
    else:
        how.scale = number("scale", scale, -MOST, MOST)
    how.dx, how.dy = spacing(dx, dy)
    how.min_z = number("min_z", min_z, 0, 1)
    how.invert = bool(invert)
    how.blue = choose("blue", blue, BLUES)
    if kernel is not None:
        how.kernel = choose("kernel", kernel, KERNELS)
    if border is not None:
        how.border_x = how.border_y = choose("border", border, BORDERS)
    if border_x is not None:
        how.border_x = choose("border_x", border_x, BORDERS)
    if border_y is not None:
        how.border_y = choose("border_y", border_y, BORDERS)
    if source is not None:
        how.source = choose("source", source, _SOURCES)
    if alpha is None or isinstance(alpha, str):
        how.alpha = choose("alpha", "keep" if alpha is None else alpha, _ALPHAS)
    else:
        how.alpha = _ALPHAS["one"]
    if lib.ntp_normals_reach(how) < 0:
        raise ArgumentError(f"scale={scale!r}, dx={dx!r}, dy={dy!r}: out of range")

    target = choose("to", to, ENCODINGS)
    if ao is not None and to != "xy":
        raise ArgumentError('ao: goes into the blue channel that to="xy" leaves free')
    if isinstance(channels, str) and "h" in channels:
        if "a" in channels or alpha is not None:
            raise ArgumentError(f"channels={channels!r}: h does not go with a, nor with alpha")
        how.alpha = _ALPHAS["height"]

    has_alpha = array.ndim == 3 and array.shape[2] % 2 == 0
    if how.source == _SOURCES["alpha"] and not has_alpha:
        raise ArgumentError(
            f'source="alpha": height has no alpha, its shape is {array.shape}', Status.FORMAT
        )
    kept = has_alpha and how.source != _SOURCES["alpha"]
    if depth is None and (to == "vector" or array.dtype.kind != "f"):
        dtype = DEPTHS["float"] if to == "vector" else array.dtype
    else:
        dtype = choose("depth", 16 if depth is None else depth, DEPTHS)
    count = 4 if alpha is not None or kept else 3
    packed = Packed(channels, "xyzah01", array.shape, count, dtype, out)
    packed.output.apart_from(False, height=array)
    others = _others(alpha, ao, array.shape, dtype)
    if number("blur", blur, 0, lib.NTP_MAX_SIGMA) > 0 or octaves is not None:
        array = _blurred(array, float(blur), octaves, how)
        how.source = _SOURCES["red"]
    src_view = view("height", array, HEIGHT)
    dst = view("out", packed.array, target, y, writable=True)

    if choose("dither", dither, _DITHERS):
        parts = [_dithered(dst, src_view, how, array.shape[1])]
    else:

        def work(areas: Iterable[Any]) -> Any:
            counts = ffi.new("ntp_normals_counts *")
            for area in areas:
                status = lib.ntp_normals_from_height(dst, src_view, how, counts, area)
                check(status, "normals_from_height")
            return counts

        parts = run(threads, array.shape[1], array.shape[0], work)
    for channel, other in others.items():
        if channel < packed.array.shape[2]:
            packed.array[..., channel] = other
    if swap_green_blue and channels is None:
        packed.array[..., [1, 2]] = packed.array[..., [2, 1]]
    result: Pixels = packed.finish()
    if not return_counts:
        return result
    return result, GradientCounts(
        sum(part.not_finite for part in parts), sum(part.exact for part in parts)
    )


def _others(
    alpha: Alpha | ArrayLike | None, ao: ArrayLike | None, shape: Shape, dtype: np.dtype[Any]
) -> dict[int, NDArray[Any]]:
    """Channels of the result that come from other images."""
    others = {}
    if ao is not None:
        others[2] = plane("ao", ao, shape, dtype)
    if alpha is not None and not isinstance(alpha, str):
        others[3] = plane("alpha", alpha, shape, dtype)
    return others


def _dithered(dst: Any, src: Any, how: Any, width: int) -> Any:
    """One pass down the rows: each takes over the rounding errors of the one above."""
    size = lib.ntp_normals_dithered_scratch_size(width)
    counts = ffi.new("ntp_normals_counts *")
    where, owner = memory(size)
    status = lib.ntp_normals_dithered(dst, src, how, where, size, counts, ffi.NULL)
    del owner
    check(status, 'normals_from_height: dither="integrable"')
    return counts
