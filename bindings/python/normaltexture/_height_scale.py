# SPDX-License-Identifier: MIT
"""How heights are taken: their channel, the options, and the scale that suits them."""

from typing import Any

from numpy.typing import NDArray

from ._arrays import MOST, choose, number, pixels, spacing, view
from ._errors import ArgumentError, Status, check
from ._names import ALPHAS, BLUES, BORDERS, HEIGHT, KERNELS, SOURCES
from ._native import ffi, lib
from .typing import (
    Alpha,
    AnyHeight,
    Blue,
    Border,
    HeightSource,
    Kernel,
    Scale,
)

_MOST_STRENGTH = lib.NTP_MAX_STRENGTH


def normals_options(
    scale: Scale,
    dx: float,
    dy: float,
    invert: bool,
    kernel: Kernel,
    border: Border,
    border_x: Border | None,
    border_y: Border | None,
    source: HeightSource | None,
    blue: Blue,
    min_z: float,
    alpha: Alpha | None,
) -> Any:
    """An ntp_normals_options."""
    how = ffi.new("ntp_normals_options *")
    if isinstance(scale, str) and scale != "auto":
        raise ArgumentError(f'scale={scale!r}: must be a number or "auto"')
    how.scale = 1.0 if scale == "auto" else number("scale", scale, -MOST, MOST)
    how.dx, how.dy = spacing(dx, dy)
    how.min_z = number("min_z", min_z, 0, 1)
    how.invert = bool(invert)
    how.blue = choose("blue", blue, BLUES)
    how.kernel = choose("kernel", kernel, KERNELS)
    how.border_x = choose("border_x" if border_x else "border", border_x or border, BORDERS)
    how.border_y = choose("border_y" if border_y else "border", border_y or border, BORDERS)
    how.source = choose("source", "red" if source is None else source, SOURCES)
    how.alpha = choose("alpha", "keep" if alpha is None else alpha, ALPHAS)
    if lib.ntp_normals_reach(how) < 0:
        raise ArgumentError(f"scale={scale!r}, dx={dx!r}, dy={dy!r}: out of range")
    return how


def suggest_scale(
    height: AnyHeight,
    *,
    dx: float = 1.0,
    dy: float = 1.0,
    kernel: Kernel = "central",
    border: Border = "wrap",
    border_x: Border | None = None,
    border_y: Border | None = None,
    source: HeightSource = "red",
) -> float:
    """Find the scale that shows the relief of a heightfield, in a small picture as in a large one.

    One in twenty of the texels that are not flat is then steeper than 45 degrees.  This is what
    `ntp from-height --scale auto` takes.

    Parameters
    ----------
    height, dx, dy, kernel, border, border_x, border_y, source
        As in `normals_from_height`.

    Returns
    -------
    float
        Measured at about 256 x 256 texels and rounded to three digits; 0 if all texels are flat.

    Raises
    ------
    ArgumentError, SampleTypeError
        As `normals_from_height`.

    Examples
    --------
    >>> import normaltexture as nt
    >>> nt.suggest_scale(nt.read("wall_height.png"))
    26.5
    """
    how = normals_options(
        "auto", dx, dy, False, kernel, border, border_x, border_y, source, "derived", 0, None
    )
    return relief_scale(height, how)


def relief_scale(height: AnyHeight, how: Any) -> float:
    array = pixels("height", height, "height")
    with_its_source(array, how)
    src = view("height", array, HEIGHT)
    relief, first = ffi.new("ntp_relief *"), ffi.new("int32_t *")
    for y in range(array.shape[0]):
        step = lib.ntp_relief_row(array.shape[1], array.shape[0], y, first)
        if step > 0:
            check(lib.ntp_relief_add(relief, src, how, first[0], y, step), "suggest_scale")
    scale: float = lib.ntp_relief_scale(relief)
    return scale


def rescale(how: Any, height: AnyHeight, scale: Scale, strength: float) -> None:
    """Multiplies the scale as the heights and the strength say."""
    how.scale *= number("strength", strength, -_MOST_STRENGTH, _MOST_STRENGTH)
    if lib.ntp_normals_reach(how) < 0:
        raise ArgumentError(f"scale={scale!r}, strength={strength!r}: out of range")
    if scale == "auto":
        how.scale *= relief_scale(height, how)


def with_its_source(array: NDArray[Any], how: Any) -> bool:
    """Has it alpha?  An error if the height should be there and is not."""
    has_alpha = array.ndim == 3 and array.shape[2] % 2 == 0
    if how.source == lib.NTP_HEIGHT_SOURCE_ALPHA and not has_alpha:
        raise ArgumentError(
            f'source="alpha": height has no alpha, its shape is {array.shape}', Status.FORMAT
        )
    return has_alpha
