# SPDX-License-Identifier: MIT
"""Normals to heightfields."""

from collections.abc import Callable, Sequence
from typing import Any, Literal, NoReturn, Unpack, cast, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import Output, choose, number, pixels, spacing, view
from ._borders import SHARE, choose_borders, find_kernel
from ._errors import ArgumentError, Status, check
from ._green import choose_y, known, slopes, told
from ._height_info import HeightInfo, info_of
from ._height_range import MOST_CLIP, clip_heights, middle_share
from ._names import (
    AUTO,
    BORDERS,
    DECODES,
    FOUND_KERNELS,
    HEIGHT,
    HEIGHT_METHODS,
    TOUCH_ALL,
    TOUCH_NONE,
    TYPES,
    ZS,
    names_of,
)
from ._native import ffi, lib
from ._solve import Solver
from ._undo import resolve_sound
from .typing import (
    AnyPixels,
    AutoBorder,
    AutoStored,
    AutoType,
    AutoY,
    Decode,
    Floats,
    HeightKernel,
    HeightMethod,
    HeightsHow,
    Mask,
    Z,
)

_KERNELS = {"auto": AUTO} | FOUND_KERNELS
_BORDERS = {"auto": AUTO} | BORDERS
_METHOD_NAMES, _KERNEL_NAMES, _BORDER_NAMES = map(
    names_of, (HEIGHT_METHODS, FOUND_KERNELS, BORDERS)
)


@overload
def height_from_normals(
    src: Floats,
    *,
    type: Literal["vector"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[HeightsHow],
) -> NDArray[np.float32]: ...
@overload
def height_from_normals(
    src: AnyPixels,
    *,
    type: AutoStored = ...,
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[HeightsHow],
) -> NDArray[np.float32]: ...
def height_from_normals(
    src: AnyPixels | Floats,
    *,
    type: AutoType = "auto",
    y: AutoY = "auto",
    method: HeightMethod = "auto",
    kernel: HeightKernel = "auto",
    border: AutoBorder = "auto",
    border_x: AutoBorder | None = None,
    border_y: AutoBorder | None = None,
    dx: float = 1.0,
    dy: float = 1.0,
    refine: int = 0,
    seeds: Sequence[float] | None = None,
    equalize: bool = False,
    mask: Mask | None = None,
    detrend: bool = False,
    clip: float = 0.0,
    decode: Decode = "auto",
    z: Z = "auto",
    touch_unused: bool = False,
    progress: Callable[[float], object] | None = None,
    out: NDArray[np.float32] | None = None,
    threads: int = 1,
) -> NDArray[np.float32]:
    """Reconstruct the heightfield of normals, in texels, with mean 0.

    It is the heightfield whose slopes, by the kernel and borders, are closest to the stored ones.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of 3 or 4 channels (`"xy"`: 2 to 4).
    type : {"auto", "standard", "zzero", "xy", "vector"}
        How a normal is stored; "auto" detects it from the texels, as `ntp to-height` does.
    y : {"auto", "up", "down"}
        Which way green points, also "opengl" and "directx".  "auto": as the texels show it; if they
        are not sure, it is an ArgumentError where a texel slopes up or down.
    method : {"auto", "telescoping", "frankot-chellappa", "poisson-dct", "weighted"}
        Least squares, for textures that tile and that do not; with holes and weights; or Eberly's
        sums of slopes.  "auto": weighted with a `mask`, else by the borders.
    kernel : {"auto", "baked"}, or one of `normals_from_height`
        How the slopes were computed; "baked": they are those of a surface, at texel centers.
        "auto": the one that fits best, else central or baked.
    border, border_x, border_y : {"auto"}, or one of `normals_from_height`
        The height beyond the edges.  "auto": detect it from the normals at the edges; if they show
        none, the one with which normals fit best.
    dx, dy : float
        Width and height of a texel.
    refine : int
        Do up to this many more rounds, until the normals of the heights are those of `src`.  If
        `progress` returns False within them, or at Ctrl-C, the best heights so far are returned.
    seeds : four floats, optional
        Telescoping: the heights at (0, 0), (1, 0), (0, 1), (1, 1), in texels.
    equalize : bool
        Telescoping: give texels of even and of odd rows and columns the same mean.
    mask : array, (height, width), uint8 or uint16, optional
        There is no surface where it is 0.
    detrend : bool
        Remove the best-fitting plane from the heights, where they do not tile.
    clip : float
        Raise the lowest `clip` percent of the heights to the next one, and lower the highest.
    decode : {"auto", "unorm", "neutral", "unorm-trunc", "snorm128"}
        Which level of red and green is 0, in 8 bit: 127.5; both 127 and 128; 127; 128.
    z : {"auto", "stored", "derived"}
        Whether z is read from blue or computed from red and green.
    touch_unused : bool
        Use pure black, pure white and transparent texels like any other.
    progress : callable, optional
        Called now and then with the share done, 0..1; returning False stops.
    out : array, (height, width), float32, optional
        Where to write; it does not overlap `src`.
    threads : int
        How many threads work; 0: one for each processor.  The bytes are the same.

    Returns
    -------
    array, (height, width), float32

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here, and kernels and borders that the method cannot
        solve.
    CancelledError
        If `progress` returned False.

    Notes
    -----
    docs/arithmetic.md and libntp.h describe the methods.  Sources: R. Frankot and R. Chellappa
    (1988); D. Eberly, "Reconstructing a Height Field from a Normal Map".

    Least squares take as much memory as the heights, and some rows.  For textures beyond memory
    `src` and `out` may be of `numpy.memmap`: they are read and written in order.

    Examples
    --------
    >>> import normaltexture as nt
    >>> height = nt.read("wall_height.png")
    >>> normals = nt.normals_from_height(height, scale=10, border="extrapolate", depth=16)
    >>> again = nt.height_from_normals(normals)
    >>> bool(np.abs((again - again.mean()) / 10 - (height / 255 - height.mean() / 255)).max() < .01)
    True
    """
    return _heights(
        src,
        lib.NTP_RESIDUAL_NONE,
        type,
        y,
        method,
        kernel,
        border,
        border_x,
        border_y,
        dx,
        dy,
        refine,
        seeds,
        equalize,
        mask,
        detrend,
        clip,
        decode,
        z,
        touch_unused,
        progress,
        out,
        threads,
    )[0]


@overload
def height_from_normals_with_info(
    src: Floats,
    *,
    type: Literal["vector"],
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[HeightsHow],
) -> tuple[NDArray[np.float32], HeightInfo]: ...
@overload
def height_from_normals_with_info(
    src: AnyPixels,
    *,
    type: AutoStored = ...,
    out: NDArray[np.float32] | None = ...,
    **how: Unpack[HeightsHow],
) -> tuple[NDArray[np.float32], HeightInfo]: ...
def height_from_normals_with_info(
    src: AnyPixels | Floats,
    *,
    type: AutoType = "auto",
    y: AutoY = "auto",
    method: HeightMethod = "auto",
    kernel: HeightKernel = "auto",
    border: AutoBorder = "auto",
    border_x: AutoBorder | None = None,
    border_y: AutoBorder | None = None,
    dx: float = 1.0,
    dy: float = 1.0,
    refine: int = 0,
    seeds: Sequence[float] | None = None,
    equalize: bool = False,
    mask: Mask | None = None,
    detrend: bool = False,
    clip: float = 0.0,
    decode: Decode = "auto",
    z: Z = "auto",
    touch_unused: bool = False,
    progress: Callable[[float], object] | None = None,
    out: NDArray[np.float32] | None = None,
    threads: int = 1,
) -> tuple[NDArray[np.float32], HeightInfo]:
    """Reconstruct the heightfield of normals, and say what was chosen and how well it fits.

    Computing the residual takes one more pass.

    Parameters
    ----------
    src, type, y, method, kernel, border, border_x, border_y, dx, dy, refine, seeds, equalize, mask, \
detrend, clip, decode, z, touch_unused, progress, out, threads
        As in `height_from_normals`.

    Returns
    -------
    (array, HeightInfo)

    Raises
    ------
    ArgumentError, SampleTypeError, CancelledError
        As `height_from_normals`.

    Examples
    --------
    >>> import normaltexture as nt
    >>> height = nt.read("wall_height.png")
    >>> normals = nt.normals_from_height(height, 10, kernel="sobel3", depth=16)
    >>> again, info = nt.height_from_normals_with_info(normals)
    >>> info.method, info.kernel, info.border_x
    ('frankot-chellappa', 'sobel3', 'wrap')
    """
    return _heights(
        src,
        lib.NTP_RESIDUAL_ALL,
        type,
        y,
        method,
        kernel,
        border,
        border_x,
        border_y,
        dx,
        dy,
        refine,
        seeds,
        equalize,
        mask,
        detrend,
        clip,
        decode,
        z,
        touch_unused,
        progress,
        out,
        threads,
    )


def _heights(
    src: AnyPixels | Floats,
    scope: int,
    type: AutoType,
    y: AutoY,
    method: HeightMethod,
    kernel: HeightKernel,
    border: AutoBorder,
    border_x: AutoBorder | None,
    border_y: AutoBorder | None,
    dx: float,
    dy: float,
    refine: int,
    seeds: Sequence[float] | None,
    equalize: bool,
    mask: Mask | None,
    detrend: bool,
    clip: float,
    decode: Decode,
    z: Z,
    touch_unused: bool,
    progress: Callable[[float], object] | None,
    out: NDArray[np.float32] | None,
    threads: int,
) -> tuple[NDArray[np.float32], HeightInfo]:
    """The heights, and what was done; `scope` says what of the residual is worked out."""
    source = pixels("src", src, type)
    if type == "auto":
        type = resolve_sound(source, type, threads)
    encoding = choose("type", type, TYPES)
    view("src", source, encoding)
    needed = told("y", y) is None and slopes(source, type, touch_unused)[1]
    green = known("y", y, source, type, threads, needed)
    src_view = view("src", source, encoding, choose_y("y", green))
    height, width = source.shape[:2]

    how = ffi.new("ntp_height_options *")
    how.method = choose("method", method, HEIGHT_METHODS)
    kernel_code = choose("kernel", kernel, _KERNELS)
    asked = (
        choose("border_x" if border_x else "border", border_x or border, _BORDERS),
        choose("border_y" if border_y else "border", border_y or border, _BORDERS),
    )
    how.decode = choose("decode", decode, DECODES)
    how.z = choose("z", z, ZS)
    how.touch_unused = TOUCH_ALL if touch_unused else TOUCH_NONE
    if seeds is not None:
        values = [float(seed) for seed in seeds]
        if len(values) != 4 or not np.isfinite(values).all() or method != "telescoping":
            raise ArgumentError(f'seeds={seeds!r}: four finite numbers, with method="telescoping"')
        how.use_seeds, how.seeds = 1, values
    if equalize and method != "telescoping":
        raise ArgumentError('equalize=True: goes with method="telescoping"')
    how.equalize, how.detrend, how.residual_scope = bool(equalize), bool(detrend), scope
    how.refine = int(number("refine", refine, 0, lib.NTP_MAX_ITERATIONS))
    how.dx, how.dy = spacing(dx, dy)
    percent = number("clip", clip, 0, MOST_CLIP)
    mask_array = None
    if mask is not None:
        mask_array = mask_of(mask, source)
        mask_view = view("mask", mask_array, HEIGHT)
        how.mask = mask_view

    output = Output((height, width), np.dtype(np.float32), out)
    if out is not None:
        output.apart_from(False, src=source)
    packed = (
        output.array if output.array.flags.c_contiguous else np.empty_like(output.array, order="C")
    )
    dst = view("out", packed, HEIGHT, writable=True)
    how.kernel = find_kernel(src_view, how) if kernel_code == AUTO else kernel_code
    result = ffi.new("ntp_height_result *")
    solver = Solver(dst, src_view, threads, progress)
    looked = choose_borders(how, asked, src_view, solver)
    status = solver.solve(how, result, SHARE if looked else 0.0, 1.0)
    del mask_array
    if status in (Status.ARGUMENT, Status.FORMAT):
        cannot(how, status, source.dtype.kind == "f")
    check(status, "height_from_normals")
    clipped = clip_heights(packed, result.holes > 0, percent, result) if percent > 0 else 0
    share = middle_share(packed, result) if scope != lib.NTP_RESIDUAL_NONE else -1.0
    if packed is not output.array:
        output.array[...] = packed
    heights = cast("NDArray[np.float32]", output.finish())
    return heights, info_of(how, result, green, source.dtype == np.uint8, clipped, share)


def mask_of(mask: Any, source: NDArray[Any]) -> NDArray[Any]:
    array = np.asarray(mask)
    array = pixels("mask", array.view(np.uint8) if array.dtype == np.bool_ else array)
    if array.shape[:2] != source.shape[:2] or array.dtype.kind == "f":
        raise ArgumentError(
            f"mask: must be uint8 or uint16 of the size of src, {source.shape[:2]},"
            f" not {array.dtype} of shape {array.shape}",
            Status.SHAPE,
        )
    return array


def cannot(how: Any, status: int, floats: bool, in_what_way: str = "") -> NoReturn:
    if how.refine > 0:
        why = None
        if how.method == lib.NTP_HEIGHT_TELESCOPING:
            why = 'refine: goes with least squares, not with method="telescoping"'
        elif floats:
            why = "refine: is for textures of 8 and 16 bits; floats are not rounded"
        elif how.method == lib.NTP_HEIGHT_WEIGHTED and how.detrend:
            why = 'refine, detrend: do not go together with method="weighted"'
        if why is not None:
            raise ArgumentError(why, Status(status))
    raise ArgumentError(
        f"kernel={_KERNEL_NAMES[how.kernel]!r} with"
        f" border_x={_BORDER_NAMES[how.border_x]!r} and"
        f" border_y={_BORDER_NAMES[how.border_y]!r} cannot be solved{in_what_way} by"
        f" method={_METHOD_NAMES[how.method]!r}",
        Status(status),
    )
