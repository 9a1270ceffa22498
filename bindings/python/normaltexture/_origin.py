# SPDX-License-Identifier: MIT
"""Where normals come from: which kernel made them, of how fine heights, and whether they tile."""

from dataclasses import dataclass
from typing import Any, Literal, get_args

from numpy.typing import ArrayLike

from ._arrays import ENCODINGS, TOUCH_ALL, TOUCH_NONE, YS, Type, Y, choose, pixels, view
from ._errors import check
from ._height import Kernel
from ._measure import _Result
from ._native import ffi, lib

_KERNELS: tuple[Kernel | Literal["baked"], ...] = (*get_args(Kernel), "baked")


@dataclass(frozen=True)
class Origin(_Result):
    """Which kernel made a texture.

    Attributes
    ----------
    decided : bool
        Rounding explains all that is left with `kernel`, and clearly not with the others.
    kernel : str
        Decided or not, the one to reconstruct with: one of `normals_from_height`, or "baked".
    misfit : dict
        Of each kernel that was tried, the mean square of what is left over that of rounding: 1 is
        a perfect fit.
    points : int
        How much was looked at.
    """

    decided: bool
    kernel: Kernel | Literal["baked"]
    misfit: dict[str, float]
    points: int


@dataclass(frozen=True)
class Seam(_Result):
    """How two opposite edges fit together.

    Attributes
    ----------
    tiling : {"tiles", "seam", "undecided"}
        Whether the texture goes on across the edges.
    wraps : bool
        The heights close as well: it tiles and does not lean.
    closure : float
        By how much heights differ between the ends of a line, over how much they vary along it.
    jump : float
        The step across the seam over the mean step inside.
    rank : float
        Share of the steps inside that are larger.
    largest : float
        Share of lines in which no step inside is larger.
    lean : float
        The mean slope along the lines.
    """

    tiling: Literal["undecided", "tiles", "seam"]
    wraps: bool
    closure: float
    jump: float
    rank: float
    largest: float
    lean: float


@dataclass(frozen=True)
class Steps(_Result):
    """The steps in which slopes come that were taken of heights with few levels.

    Attributes
    ----------
    found : bool
        They do; where it is False, which is also where it cannot be told, the rest is 0.
    teeth : int
        Multiples of the step that occur, but for 0 and signs, on both axes.
    slope, degrees : float
        The step, and the angle between a flat normal and the next.
    share, expected : float
        Of the texels that lie on a multiple, and what chance would put there.
    """

    found: bool
    teeth: int
    slope: float
    degrees: float
    share: float
    expected: float


def find_origin(
    src: ArrayLike, *, type: Type = "standard", y: Y = "up", touch_unused: bool = False
) -> Origin:
    """Tell which kernel made normals: their slopes must be the differences of one heightfield.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored; only red and green count.
    y : {"up", "down"}
        Which way green points.
    touch_unused : bool
        Look at pure black, pure white and transparent texels too.

    Returns
    -------
    Origin

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import normaltexture as nt
    >>> normals = nt.normals_from_height(nt.read("wall_height.png"), scale=9, kernel="sobel3")
    >>> found = nt.find_origin(normals)
    >>> found.decided, found.kernel
    (True, 'sobel3')
    """
    source = pixels("src", src)
    src_view = view("src", source, choose("type", type, ENCODINGS), choose("y", y, YS))
    found = ffi.new("ntp_kernel_fit *")
    check(
        lib.ntp_find_kernel(found, src_view, TOUCH_ALL if touch_unused else TOUCH_NONE),
        "find_origin",
    )
    return Origin(
        decided=bool(found.decided),
        kernel=_KERNELS[found.kernel],
        misfit={name: m for name, m in zip(_KERNELS, found.misfit, strict=True) if m >= 0},
        points=found.points,
    )


def find_seams(
    src: ArrayLike, *, type: Type = "standard", touch_unused: bool = False
) -> tuple[Seam, Seam]:
    """Tell whether a texture tiles: from left to right, and from top to bottom.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored; only red and green count.
    touch_unused : bool
        Look at pure black, pure white and transparent texels too.

    Returns
    -------
    (Seam, Seam)
        About the left and right edges, and about the upper and lower ones.  Undecided are textures
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
    >>> [seam.tiling for seam in nt.find_seams(normals[:, :50])]
    ['seam', 'tiles']
    """
    source = pixels("src", src)
    src_view = view("src", source, choose("type", type, ENCODINGS))
    found = ffi.new("ntp_seam[2]")
    touch = TOUCH_ALL if touch_unused else TOUCH_NONE
    check(lib.ntp_find_seams(found, found + 1, src_view, touch), "find_seams")
    return _seam(found[0]), _seam(found[1])


def _seam(found: Any) -> Seam:
    return Seam(
        tiling=("tiles" if found.tiles else "seam") if found.decided else "undecided",
        wraps=bool(found.wraps),
        closure=found.closure,
        jump=found.jump,
        rank=found.rank,
        largest=found.largest,
        lean=found.lean,
    )


def find_steps(src: ArrayLike, *, type: Type = "standard", touch_unused: bool = False) -> Steps:
    """Tell normals that were made of heights with few levels, such as those of 8 bits.

    Their slopes are whole multiples of one step, and smooth ground is flat terraces with edges
    between: banding, which no cleaning takes away.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored; only red and green count.
    touch_unused : bool
        Look at pure black, pure white and transparent texels too.

    Returns
    -------
    Steps
        Not told are steps of about the size of the texture's own levels, gentle textures, fewer
        than four multiples, and steps along one axis only.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Examples
    --------
    >>> import normaltexture as nt
    >>> height = nt.read("wall_height.png")  # of 8 bits
    >>> nt.find_steps(nt.normals_from_height(height, scale=10)).found
    True
    >>> nt.find_steps(nt.normals_from_height(height, scale=10, blur=2)).found
    False
    """
    source = pixels("src", src)
    src_view = view("src", source, choose("type", type, ENCODINGS))
    found = ffi.new("ntp_steps *")
    touch = TOUCH_ALL if touch_unused else TOUCH_NONE
    check(lib.ntp_find_steps(found, src_view, touch), "find_steps")
    return Steps(
        found=bool(found.decided),
        teeth=found.teeth,
        slope=found.slope,
        degrees=found.degrees,
        share=found.share,
        expected=found.expected,
    )
