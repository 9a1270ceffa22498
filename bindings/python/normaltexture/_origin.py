# SPDX-License-Identifier: MIT
"""The origin of normals: which kernel made them, from how fine heights, and whether they tile."""

from dataclasses import dataclass
from typing import Any, Literal, overload

from ._arrays import choose, pixels, view
from ._errors import check
from ._green import choose_y
from ._measure import _Result
from ._names import FOUND_KERNELS, TOUCH_ALL, TOUCH_NONE, TYPES, names_of
from ._native import ffi, lib
from .typing import (
    AnyPixels,
    Floats,
    FoundKernel,
    GivenY,
    Stored,
    Type,
)

_KERNEL_NAMES: Any = names_of(FOUND_KERNELS)


@dataclass(frozen=True)
class KernelFit(_Result):
    """Which kernel made a texture.

    Attributes
    ----------
    decided : bool
        Rounding explains the residual of `kernel`, and clearly not that of the others.
    kernel : str
        The one to reconstruct with, also if undecided: one of `normals_from_height`, or "baked".
    misfit : dict
        For each kernel that was tried, the mean square of the residual divided by that of rounding;
        1 is a perfect fit.
    points : int
        How many points were used.
    """

    decided: bool
    kernel: FoundKernel
    misfit: dict[str, float]
    points: int


@dataclass(frozen=True)
class Seam(_Result):
    """How two opposite edges fit together.

    Attributes
    ----------
    decided : bool
        Whether there is a clear answer.
    tiles : bool
        The texture continues across the edges; False if undecided.
    wraps : bool
        The heights at the edges meet too: the border "wrap" suits them, also where nothing is
        decided because the edges are flat.
    closure : float
        The difference of heights between the ends of a line, divided by their variation along it.
    jump : float
        The step across the seam divided by the mean step inside.
    rank : float
        Share of the steps inside that are larger.
    largest : float
        Share of lines without a larger step inside.
    lean : float
        The mean slope along the lines.
    """

    decided: bool
    tiles: bool
    wraps: bool
    closure: float
    jump: float
    rank: float
    largest: float
    lean: float


@dataclass(frozen=True)
class Steps(_Result):
    """Slope quantization caused by low-bit heights.

    Attributes
    ----------
    decided : bool
        Slopes are quantized.  If False, they are not, or it is unknown, and the rest is 0.
    teeth : int
        Different multiples of the step that occur, without 0 and signs, on both axes.
    slope, degrees : float
        The step, and the angle between a flat normal and the next.
    share, expected : float
        Of the texels that lie on a multiple, and the share expected by chance.
    """

    decided: bool
    teeth: int
    slope: float
    degrees: float
    share: float
    expected: float


@overload
def find_kernel(
    src: Floats,
    *,
    type: Literal["vector"],
    y: GivenY = ...,
    touch_unused: bool = ...,
) -> KernelFit: ...
@overload
def find_kernel(
    src: AnyPixels,
    *,
    type: Stored = ...,
    y: GivenY = ...,
    touch_unused: bool = ...,
) -> KernelFit: ...
def find_kernel(
    src: AnyPixels | Floats,
    *,
    type: Type = "standard",
    y: GivenY = "up",
    touch_unused: bool = False,
) -> KernelFit:
    """Detect which kernel made normals: their slopes must be the differences of one heightfield.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored; only red and green count.
    y : {"up", "down", "opengl", "directx"}
        Which way green points.
    touch_unused : bool
        Look at pure black, pure white and transparent texels too.

    Returns
    -------
    KernelFit

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import normaltexture as nt
    >>> normals = nt.normals_from_height(nt.read("wall_height.png"), scale=9, kernel="sobel3")
    >>> found = nt.find_kernel(normals)
    >>> found.decided, found.kernel
    (True, 'sobel3')
    """
    source = pixels("src", src, type)
    src_view = view("src", source, choose("type", type, TYPES), choose_y("y", y))
    found = ffi.new("ntp_kernel_fit *")
    check(
        lib.ntp_find_kernel(found, src_view, TOUCH_ALL if touch_unused else TOUCH_NONE),
        "find_kernel",
    )
    return KernelFit(
        decided=bool(found.decided),
        kernel=_KERNEL_NAMES[found.kernel],
        misfit={name: found.misfit[i] for name, i in FOUND_KERNELS.items() if found.misfit[i] >= 0},
        points=found.points,
    )


@overload
def find_seams(
    src: Floats,
    *,
    type: Literal["vector"],
    touch_unused: bool = ...,
) -> tuple[Seam, Seam]: ...
@overload
def find_seams(
    src: AnyPixels,
    *,
    type: Stored = ...,
    touch_unused: bool = ...,
) -> tuple[Seam, Seam]: ...
def find_seams(
    src: AnyPixels | Floats, *, type: Type = "standard", touch_unused: bool = False
) -> tuple[Seam, Seam]:
    """Tell whether a texture tiles: from left to right, and from top to bottom.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored; only red and green count.
    touch_unused : bool
        Look at pure black, pure white and transparent texels too.

    Returns
    -------
    (Seam, Seam)
        For the left and right edges, and for the upper and lower ones.  Undecided are textures
        below 16 x 16 texels, nearly flat ones, and those with many unused texels at the edges.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> y, x = np.mgrid[0:64, 0:64] * (2 * np.pi / 64)
    >>> hills = np.sin(x + np.cos(y)) + np.sin(2 * y) * np.cos(3 * x)
    >>> normals = nt.normals_from_height(hills.astype(np.float32), scale=2.0)
    >>> [seam.tiles for seam in nt.find_seams(normals[:, :50])]
    [False, True]
    """
    source = pixels("src", src, type)
    src_view = view("src", source, choose("type", type, TYPES))
    found = ffi.new("ntp_seam[2]")
    touch = TOUCH_ALL if touch_unused else TOUCH_NONE
    check(lib.ntp_find_seams(found, found + 1, src_view, touch), "find_seams")
    return _seam(found[0]), _seam(found[1])


def _seam(found: Any) -> Seam:
    return Seam(
        decided=bool(found.decided),
        tiles=bool(found.decided and found.tiles),
        wraps=bool(found.wraps),
        closure=found.closure,
        jump=found.jump,
        rank=found.rank,
        largest=found.largest,
        lean=found.lean,
    )


@overload
def find_steps(
    src: Floats,
    *,
    type: Literal["vector"],
    touch_unused: bool = ...,
) -> Steps: ...
@overload
def find_steps(
    src: AnyPixels,
    *,
    type: Stored = ...,
    touch_unused: bool = ...,
) -> Steps: ...
def find_steps(
    src: AnyPixels | Floats, *, type: Type = "standard", touch_unused: bool = False
) -> Steps:
    """Detect normals that were made from low-bit heights, such as 8-bit ones.

    Their slopes are whole multiples of one step, and smooth ground becomes flat terraces with edges
    between them.  Cleaning cannot remove this banding.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored; only red and green count.
    touch_unused : bool
        Look at pure black, pure white and transparent texels too.

    Returns
    -------
    Steps
        Not detected are steps of about the size of the texture's own levels, gentle textures, fewer
        than four multiples, and steps along one axis only.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import normaltexture as nt
    >>> height = nt.read("wall_height.png")  # of 8 bits
    >>> nt.find_steps(nt.normals_from_height(height, scale=10)).decided
    True
    >>> soft = nt.normals_from_height(nt.blur_height(height, 2), scale=10)
    >>> nt.find_steps(soft).decided
    False
    """
    source = pixels("src", src, type)
    src_view = view("src", source, choose("type", type, TYPES))
    found = ffi.new("ntp_steps *")
    touch = TOUCH_ALL if touch_unused else TOUCH_NONE
    check(lib.ntp_find_steps(found, src_view, touch), "find_steps")
    return Steps(
        decided=bool(found.decided),
        teeth=found.teeth,
        slope=found.slope,
        degrees=found.degrees,
        share=found.share,
        expected=found.expected,
    )
