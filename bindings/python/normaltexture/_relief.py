# SPDX-License-Identifier: MIT
"""Maps of the shape of a surface: curvature, cavity, ambient occlusion."""

from collections.abc import Callable, Iterable
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ._arrays import DEPTHS, Output, choose, memory, number, pixels, view
from ._blur import blur_height
from ._convert import convert
from ._errors import ArgumentError, check
from ._green import choose_y, known, slopes, told
from ._names import BORDERS, CURVATURES, HEIGHT, MEASURED, SOURCES
from ._native import ffi, lib
from ._reconstruct import height_from_normals
from ._solve import SCRATCH_ALIGNMENT, Callbacks
from ._threads import THOROUGH, run
from ._undo import resolve_sound
from .typing import (
    AnyHeight,
    AnyPixels,
    AutoReliefType,
    AutoY,
    CurvatureKind,
    Depth,
    HeightSource,
    ReliefBorder,
)

_TYPES = {"auto": -1} | MEASURED
_BORDERS = {"auto": -1} | {name: BORDERS[name] for name in ("wrap", "clamp")}
_Edges = tuple[Literal["wrap", "clamp"], Literal["wrap", "clamp"]]  # of x and of y
_NO_SCALE = "scale=0: with this scale the heights are flat"


def _is_height(source: NDArray[Any], type: AutoReliefType) -> bool:
    choose("type", type, _TYPES)
    few = source.ndim == 2 or source.shape[2] == 1
    return type == "height" or (type == "auto" and few)


def _edges(
    how: Any,
    surface: tuple[NDArray[Any], int],
    border: ReliefBorder,
    border_x: ReliefBorder | None,
    border_y: ReliefBorder | None,
) -> _Edges:
    """Fills in the borders of options: those asked for, or those that the edges show.

    The surface is heights or normals, and how they are stored.
    """
    asked = (
        choose("border_x" if border_x else "border", border_x or border, _BORDERS),
        choose("border_y" if border_y else "border", border_y or border, _BORDERS),
    )
    found = ffi.new("ntp_border[2]")
    if min(asked) < 0:
        seen = view("src", *surface)
        check(lib.ntp_relief_borders(found, found + 1, seen), "border")
    how.border_x, how.border_y = (b if b >= 0 else found[i] for i, b in enumerate(asked))
    x, y = (how.border_x == BORDERS["clamp"], how.border_y == BORDERS["clamp"])
    return "clamp" if x else "wrap", "clamp" if y else "wrap"


def _plain(source: NDArray[Any], channel: HeightSource) -> tuple[NDArray[Any], int]:
    """Heights as they are before a blur."""
    choose("source", channel, SOURCES)
    if channel == "red":
        return source, HEIGHT
    made = blur_height(source, 0, source=channel)
    return made if made.ndim == 2 else made[..., 0], HEIGHT


def _heights(
    source: NDArray[Any],
    blur: float,
    edges: _Edges,
    channel: HeightSource,
) -> NDArray[Any]:
    """The heights of an image: as they are where sample 0 has them, else as floats."""
    choose("source", channel, SOURCES)
    if blur == 0 and channel == "red":
        return source
    made = blur_height(source, blur, border_x=edges[0], border_y=edges[1], source=channel)
    return made if made.ndim == 2 else made[..., 0]


def _blurred(
    source: NDArray[Any],
    type: Any,
    blur: float,
    edges: _Edges,
) -> NDArray[np.float32]:
    """Normals as vectors with x and y blurred; what has no direction counts as flat."""
    vectors = np.array(convert(source, type=type, to="vector")[..., :3], order="C")
    squares = vectors * vectors
    vectors[~(squares[..., 0] + squares[..., 1] + squares[..., 2] < 2)] = (0, 0, 1)
    for axis in (0, 1):
        channel = np.ascontiguousarray(vectors[..., axis])
        vectors[..., axis] = blur_height(channel, blur, border_x=edges[0], border_y=edges[1])
    return vectors


def _depth(depth: Depth | None, source: NDArray[Any]) -> np.dtype[Any]:
    if depth is None:
        return source.dtype
    return choose("depth", depth, DEPTHS)


def curvature(
    src: AnyHeight,
    *,
    kind: CurvatureKind = "mean",
    type: AutoReliefType = "auto",
    y: AutoY = "auto",
    scale: float = 1.0,
    source: HeightSource = "red",
    blur: float = 0.0,
    border: ReliefBorder = "auto",
    border_x: ReliefBorder | None = None,
    border_y: ReliefBorder | None = None,
    range: float = 0.0,
    depth: Depth | None = None,
    out: AnyPixels | None = None,
    threads: int = 1,
) -> AnyPixels:
    """Make a curvature or cavity map of heights or normals.

    Parameters
    ----------
    src : array, (height, width) or (height, width, channels), uint8, uint16 or float32
        A normals texture, or a heightfield; floats may be float64.
    kind : {"mean", "gaussian", "convex", "cavity"}
        Mean curvature: edges are bright, grooves dark; Gaussian curvature; how sharp edges are;
        how sharp grooves are, dark on white.
    type : {"auto", "standard", "zzero", "xy", "vector", "height"}
        What `src` is.  "auto": one channel is a height; else it is detected from the texels.
    y : {"auto", "up", "down"}
        Normals: which way green points, as in `height_from_normals`.
    scale : float
        Heights: how many texels a height of 1 rises.
    source : one of `normals_from_height`
        Heights: what of a color image is the height.
    blur : float
        First blur the heights, or the normals, by a Gaussian with this sigma, in texels.
    border, border_x, border_y : {"auto", "wrap", "clamp"}
        For textures that tile; and others, for which the edge is like what is beside it.  "auto":
        "clamp" where opposite edges clearly do not fit together.
    range : float
        8 and 16 bit: the curvature that is shown white ("cavity": black); 0: 99 % of the values
        that are not 0 lie within.
    depth : {8, 16, "float"}, optional
        Of the result; default: as `src`.  "float": the curvature itself, in 1/texel ("gaussian":
        1/texel^2).
    out : array like the result, optional
        Where to write; it does not overlap `src`.
    threads : int
        How many threads work; 0: one for each processor.  The bytes are the same.

    Returns
    -------
    array, (height, width)

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Notes
    -----
    docs/relief-maps.md has the formulas.

    Examples
    --------
    >>> import normaltexture as nt
    >>> cavity = nt.curvature(nt.read("wall_n.png"), kind="cavity", blur=1)
    """
    array = pixels("src", src, type if type == "vector" else "auto")
    how = ffi.new("ntp_curvature_options *")
    how.kind = choose("kind", kind, CURVATURES)
    how.range = number("range", range, 0, 1e30)
    how.scale = number("scale", scale, -1.7e308, 1.7e308)
    blur = number("blur", blur, 0, lib.NTP_MAX_SIGMA)
    dtype = _depth(depth, array)
    if _is_height(array, type):
        if how.scale == 0:
            raise ArgumentError(_NO_SCALE)
        edges = _edges(how, _plain(array, source), border, border_x, border_y)
        array = _heights(array, blur, edges, source)
        seen = view("src", array, HEIGHT)
    else:
        found: Any = resolve_sound(array, type, threads) if type == "auto" else type
        needed = told("y", y) is None and slopes(array, found, False)[1]
        green = choose_y("y", known("y", y, array, found, threads, needed))
        encoding = MEASURED[found]
        edges = _edges(how, (array, encoding), border, border_x, border_y)
        if blur > 0:
            array, encoding = _blurred(array, found, blur, edges), MEASURED["vector"]
        seen = view("src", array, encoding, green)
    height, width = array.shape[:2]
    output = Output((height, width), dtype, out)
    if out is not None:
        output.apart_from(False, src=array)
    if dtype.kind == "f":
        how.range = 0
    elif how.range == 0:
        values = np.empty((height, width), np.float32)
        _curve(view("values", values, HEIGHT, writable=True), seen, how, threads)
        most = ffi.new("double *")
        check(lib.ntp_curvature_range(most, view("values", values, HEIGHT)), "curvature")
        how.range = most[0] or 1.0
    _curve(view("out", output.array, HEIGHT, writable=True), seen, how, threads)
    result: AnyPixels = output.finish()
    return result


def _curve(dst: Any, src: Any, how: Any, threads: int) -> None:
    def work(areas: Iterable[Any]) -> None:
        for area in areas:
            check(lib.ntp_curvature(dst, src, how, area), "curvature")

    run(threads, src.width, src.height, work, THOROUGH)


def occlusion(
    src: AnyHeight,
    *,
    type: AutoReliefType = "auto",
    y: AutoY = "auto",
    scale: float = 1.0,
    source: HeightSource = "red",
    blur: float = 0.0,
    border: ReliefBorder = "auto",
    border_x: ReliefBorder | None = None,
    border_y: ReliefBorder | None = None,
    radius: float = 0.0,
    depth: Depth | None = None,
    progress: Callable[[float], object] | None = None,
    out: AnyPixels | None = None,
    threads: int = 1,
) -> AnyPixels:
    """Make an ambient occlusion map of heights or normals: 1 (white) is open, 0 is hidden.

    Parameters
    ----------
    src, type, y, scale, source, blur
        As in `curvature`.  Of normals the heights are reconstructed first, as by
        `height_from_normals`; a blur is one of heights.
    border, border_x, border_y : {"auto", "wrap", "clamp"}
        For textures that tile; and others, for which there is nothing beyond the edges.  "auto":
        as in `curvature`.
    radius : float
        What is farther away, in texels, hides nothing; 0: the longer side.
    depth : {8, 16, "float"}, optional
        Of the result; default: as `src`.
    progress : callable, optional
        Called now and then with the share done, 0..1; returning False stops.
    out : array like the result, optional
        Where to write; it does not overlap `src`.
    threads : int
        How many threads work; 0: one for each processor.  The bytes are the same.

    Returns
    -------
    array, (height, width)

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.
    CancelledError
        If `progress` returned False.

    Notes
    -----
    The share of the light of an evenly bright sky that reaches a texel, by the cosine to its
    normal; docs/relief-maps.md has the formulas.

    Examples
    --------
    >>> import normaltexture as nt
    >>> light = nt.occlusion(nt.read("wall_height.png"), scale=10, radius=32)
    """
    array = pixels("src", src, type if type == "vector" else "auto")
    how = ffi.new("ntp_occlusion_options *")
    how.scale = number("scale", scale, -1.7e308, 1.7e308)
    how.radius = number("radius", radius, 0, 1e30)
    blur = number("blur", blur, 0, lib.NTP_MAX_SIGMA)
    dtype = _depth(depth, array)
    if _is_height(array, type):
        if how.scale == 0:
            raise ArgumentError(_NO_SCALE)
        edges = _edges(how, _plain(array, source), border, border_x, border_y)
        array = _heights(array, blur, edges, source)
    else:
        stored: Any = resolve_sound(array, type, threads) if type == "auto" else type
        edges = _edges(how, (array, MEASURED[stored]), border, border_x, border_y)
        solved = height_from_normals(
            array,
            type=stored,
            y=y,
            border_x="wrap" if (border_x or border) == "wrap" else "auto",
            border_y="wrap" if (border_y or border) == "wrap" else "auto",
            threads=threads,
        )
        array, how.scale = _heights(solved, blur, edges, "red"), 1.0
    height, width = array.shape[:2]
    output = Output((height, width), dtype, out)
    if out is not None:
        output.apart_from(False, src=array)
    calls = Callbacks(threads, height * width, progress)
    handle = ffi.new_handle(calls)
    size = lib.ntp_occlusion_scratch_size(how, width, height, calls.parts)
    scratch, owner = memory(size, SCRATCH_ALIGNMENT)
    dst = view("out", output.array, HEIGHT, writable=True)
    seen = view("src", array, HEIGHT)
    status = lib.ntp_occlusion(dst, seen, how, scratch, size, calls.hooks(handle, is_long=True))
    del owner
    calls.check()
    check(status, "occlusion")
    result: AnyPixels = output.finish()
    return result
