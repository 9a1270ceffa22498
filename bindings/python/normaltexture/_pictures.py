# SPDX-License-Identifier: MIT
"""Pictures of textures: which texels are wrong, how they look lit, how two of them differ."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import Output, Pool, choose, pixels, view
from ._classify import likely, resolve
from ._errors import ArgumentError, Status, check
from ._green import choose_y
from ._measure import Angles, _Result
from ._names import HEIGHT, MEASURED, PALETTES, TOUCH_ALL, TOUCH_NONE, TYPES
from ._native import ffi, lib
from ._threads import THOROUGH, run
from .typing import (
    AnyPixels,
    AutoStored,
    AutoType,
    ComparedType,
    Floats,
    GivenY,
    MeasuredType,
    Palette,
)

_Plain: TypeAlias = Literal["auto", "standard", "zzero", "xy", "height"]
_U8 = np.dtype(np.uint8)
_DIFFS = Pool(lib.ntp_diff_size(), lambda memory: lib.ntp_diff_clear(memory))


@overload
def heatmap(
    src: Floats,
    *,
    type: Literal["vector"],
    palette: Palette = ...,
    touch_unused: bool = ...,
    out: NDArray[np.uint8] | None = ...,
    threads: int = ...,
) -> NDArray[np.uint8]: ...
@overload
def heatmap(
    src: AnyPixels,
    *,
    type: AutoStored = ...,
    palette: Palette = ...,
    touch_unused: bool = ...,
    out: NDArray[np.uint8] | None = ...,
    threads: int = ...,
) -> NDArray[np.uint8]: ...
def heatmap(
    src: AnyPixels | Floats,
    *,
    type: AutoType = "auto",
    palette: Palette = "reference",
    touch_unused: bool = False,
    out: NDArray[np.uint8] | None = None,
    threads: int = 1,
) -> NDArray[np.uint8]:
    """Show which texels are wrong; correct texels are gray.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    type : {"auto", "standard", "zzero", "xy", "vector"}
        How a normal is stored; "auto" detects it from the texels, as `ntp heatmap` does.
    palette : {"reference", "safe"}
        "reference": red where x, y are too long, green where the length is wrong, blue where z is
        negative.  "safe": colors that can be told apart with every kind of color vision.
    touch_unused : bool
        Judge pure black, pure white and transparent texels too.
    out : array, (height, width, 3), uint8, optional
        Where to write.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array, (height, width, 3), uint8

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Notes
    -----
    docs/heatmap.md is the legend.  The colors of "reference" are those of Eric Haines'
    NormalTextureProcessor.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> nt.heatmap(np.array([[[128, 128, 255], [128, 128, 200]]], np.uint8), type="standard")
    array([[[168, 168, 168],
            [  0, 255,   0]]], dtype=uint8)
    """
    source = pixels("src", src, type)
    if type == "auto":
        type = resolve(source, type, threads)
    src_view = view("src", source, choose("type", type, TYPES))
    output = Output((*source.shape[:2], 3), _U8, out)
    output.apart_from(True, src=source)
    heat = view("out", output.array, HEIGHT, writable=True)
    colors = choose("palette", palette, PALETTES)
    touch = TOUCH_ALL if touch_unused else TOUCH_NONE

    def work(areas: Iterable[Any]) -> None:
        for area in areas:
            check(lib.ntp_heatmap(heat, src_view, colors, touch, area), "heatmap")

    run(threads, source.shape[1], source.shape[0], work)
    result: NDArray[np.uint8] = output.finish()
    return result


@dataclass(frozen=True)
class Light(_Result):
    """A light for `shade`.

    Attributes
    ----------
    direction : tuple of 3 floats
        Towards the light: x right, y up, z to the viewer; any length but 0.
    ambient, diffuse, specular : float
        0..1.
    color : tuple of 3 floats
        Of the plane, 0..1, linear.
    """

    direction: tuple[float, float, float] = (-1.0, 1.0, 1.2)
    ambient: float = 0.1
    diffuse: float = 0.9
    specular: float = 0.2
    color: tuple[float, float, float] = (0.6, 0.6, 0.6)


_DEFAULT_LIGHT = Light()


@overload
def shade(
    src: Floats,
    *,
    type: Literal["vector"],
    y: GivenY = ...,
    light: Light = ...,
    out: NDArray[np.uint8] | None = ...,
    threads: int = ...,
) -> NDArray[np.uint8]: ...
@overload
def shade(
    src: AnyPixels,
    *,
    type: AutoStored = ...,
    y: GivenY = ...,
    light: Light = ...,
    out: NDArray[np.uint8] | None = ...,
    threads: int = ...,
) -> NDArray[np.uint8]: ...
def shade(
    src: AnyPixels | Floats,
    *,
    type: AutoType = "auto",
    y: GivenY = "up",
    light: Light = _DEFAULT_LIGHT,
    out: NDArray[np.uint8] | None = None,
    threads: int = 1,
) -> NDArray[np.uint8]:
    """Show a plane with these normals, lit from a direction and seen from above.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    type : {"auto", "standard", "zzero", "xy", "vector"}
        How a normal is stored; "auto" detects it from the texels.
    y : {"up", "down", "opengl", "directx"}
        Which way green points.
    light : Light
        Where the light comes from, and how the plane reflects it.
    out : array, (height, width, 3) or (height, width), uint8, optional
        Where to write; two dimensions get the luminance.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    array, (height, width, 3), uint8

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> texture = np.full((1, 2, 3), (128, 128, 255), np.uint8)
    >>> texture[0, 1] = 37, 218, 128
    >>> nt.shade(texture, type="standard")[0, :, 0]
    array([165, 175], dtype=uint8)
    """
    source = pixels("src", src, type)
    if type == "auto":
        type = resolve(source, type, threads)
    src_view = view("src", source, choose("type", type, TYPES), choose_y("y", y))
    gray = isinstance(out, np.ndarray) and out.ndim == 2
    output = Output(source.shape[:2] if gray else (*source.shape[:2], 3), _U8, out)
    output.apart_from(not gray, src=source)
    picture = view("out", output.array, HEIGHT, writable=True)
    setup = ffi.new(
        "ntp_light *",
        (light.direction, light.ambient, light.diffuse, light.specular, light.color),
    )

    def work(areas: Iterable[Any]) -> None:
        for area in areas:
            check(lib.ntp_shade(picture, src_view, setup, area), "shade: light")

    run(threads, source.shape[1], source.shape[0], work)
    result: NDArray[np.uint8] = output.finish()
    return result


@dataclass(frozen=True)
class Difference(_Result):
    """How two textures differ.

    Attributes
    ----------
    texels : int
        How many were compared.
    different : int
        Texels in which a sample differs.
    max : int
        The greatest level, M, of those below: 255, or 65535 if one texture is deeper.
    levels_max, levels_mean : tuple
        The greatest and mean difference of each channel, in levels.
    angles : Angles
        Degrees between the two vectors, over all texels.
    """

    texels: int
    different: int
    max: int
    levels_max: tuple[int, ...]
    levels_mean: tuple[float, ...]
    angles: Angles


def _pair(name: str, value: Any) -> tuple[Any, Any]:
    """An argument that is for both textures, or a tuple of two."""
    if not isinstance(value, tuple):
        return value, value
    if len(value) != 2:
        raise ArgumentError(f"{name}={value!r}: must be one for both, or two")
    return value[0], value[1]


def _types(
    type: ComparedType | tuple[ComparedType, ComparedType],
    first: NDArray[Any],
    second: NDArray[Any],
    threads: int,
) -> tuple[MeasuredType, MeasuredType]:
    """The argument `type` of `compare`, "auto" found out."""
    a, b = _pair("type", type)
    of_a: MeasuredType = likely(first, threads) if a == "auto" else a
    of_b: MeasuredType = likely(second, threads) if b == "auto" else b
    # Where one of them has no blue, that of the other tells more than a derived one.
    if a == "auto" and of_a == "xy" != of_b and first.shape[2] > 2:
        of_a = "standard"
    if b == "auto" and of_b == "xy" != of_a and second.shape[2] > 2:
        of_b = "standard"
    return of_a, of_b


@overload
def compare(
    a: AnyPixels,
    b: AnyPixels,
    *,
    type: _Plain | tuple[_Plain, _Plain] = ...,
    y: GivenY | tuple[GivenY, GivenY] = ...,
    out_heat: NDArray[np.uint8] | None = ...,
    threads: int = ...,
) -> Difference: ...
@overload
def compare(
    a: Floats,
    b: AnyPixels,
    *,
    type: tuple[ComparedType, _Plain],
    y: GivenY | tuple[GivenY, GivenY] = ...,
    out_heat: NDArray[np.uint8] | None = ...,
    threads: int = ...,
) -> Difference: ...
@overload
def compare(
    a: AnyPixels,
    b: Floats,
    *,
    type: tuple[_Plain, ComparedType],
    y: GivenY | tuple[GivenY, GivenY] = ...,
    out_heat: NDArray[np.uint8] | None = ...,
    threads: int = ...,
) -> Difference: ...
@overload
def compare(
    a: Floats,
    b: Floats,
    *,
    type: ComparedType | tuple[ComparedType, ComparedType],
    y: GivenY | tuple[GivenY, GivenY] = ...,
    out_heat: NDArray[np.uint8] | None = ...,
    threads: int = ...,
) -> Difference: ...
def compare(
    a: AnyPixels | Floats,
    b: AnyPixels | Floats,
    *,
    type: ComparedType | tuple[ComparedType, ComparedType] = "auto",
    y: GivenY | tuple[GivenY, GivenY] = "up",
    out_heat: NDArray[np.uint8] | None = None,
    threads: int = 1,
) -> Difference:
    """Compare two textures of the same size in levels and degrees, as `ntp diff` does.

    Parameters
    ----------
    a, b : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        Normals textures; depth, encoding and direction of green may differ.  `b` is converted to
        the encoding of `a`.
    type : {"auto", "standard", "zzero", "xy", "vector", "height"}, or two of these
        How both store a normal, or how `a` and how `b` does.  "auto" decides as `ntp diff` does: by
        the texels of each if these are clear, else standard; XY only if both are; arrays of two
        dimensions as heights.  Two heights, or pictures of any kind, of 1 to 4 channels are
        compared in levels only.
    y : {"up", "down", "opengl", "directx"}, or two of these
        Which way green points in both, or in `a` and in `b`.
    out_heat : array, (height, width, 3), uint8, optional
        Filled with a picture: black where they are equal, then from blue (0 degrees) through green
        (5) to red (10 and more).
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    Difference

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> a = np.full((1, 2, 3), (128, 128, 255), np.uint8)
    >>> b = a.copy(); b[0, 0] = 128, 255, 128
    >>> found = nt.compare(a, b)
    >>> found.different, found.levels_max, round(found.angles.max)
    (1, (0, 127, 127), 90)
    """
    type_a, type_b = _pair("type", type)
    first, second = pixels("a", a, type_a), pixels("b", b, type_b)
    if first.shape[:2] != second.shape[:2]:
        raise ArgumentError(
            f"b: must be of the size of a, {first.shape[:2]}, not {second.shape[:2]}",
            Status.SHAPE,
        )
    types, ys = _types(type, first, second, threads), _pair("y", y)
    a_view = view("a", first, choose("type", types[0], MEASURED), choose_y("y", ys[0]))
    b_view = view("b", second, choose("type", types[1], MEASURED), choose_y("y", ys[1]))
    heat_view, output = ffi.NULL, None
    if out_heat is not None:
        output = Output((*first.shape[:2], 3), _U8, out_heat)
        output.apart_from(False, a=first, b=second)
        heat_view = view("out_heat", output.array, HEIGHT, writable=True)

    def work(areas: Iterable[Any]) -> tuple[Any, Any]:
        part, owner = _DIFFS.take()
        for area in areas:
            check(lib.ntp_diff_add(part, heat_view, a_view, b_view, area), "compare")
        return part, owner

    parts = run(threads, first.shape[1], first.shape[0], work, THOROUGH)
    sums = parts[0][0]
    for part, _ in parts[1:]:
        check(lib.ntp_diff_merge(sums, part), "compare")
    found = ffi.new("ntp_diff_stats *")
    check(lib.ntp_diff_summarize(found, sums), "compare")
    for part, owner in parts:
        _DIFFS.give(part, owner)
    if output is not None:
        output.finish()
    n = found.channels
    return Difference(
        texels=found.texels,
        different=found.different,
        max=found.max,
        levels_max=tuple(found.levels_max[i] for i in range(n)),
        levels_mean=tuple(found.levels_mean[i] for i in range(n)),
        angles=Angles(found.angles.texels, found.angles.mean, found.angles.p99, found.angles.max),
    )
