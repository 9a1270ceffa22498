# SPDX-License-Identifier: MIT
"""Blurred heights, from which normals are made later."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import DEPTHS, Output, choose, memory, number, pixels, view
from ._errors import ArgumentError, check
from ._names import BORDERS, HEIGHT, SOURCES
from ._native import ffi, lib
from .typing import (
    AnyHeight,
    Border,
    HeightSource,
)

_MAX_OCTAVES = 8


def _octaves(sigma: float, weights: list[float]) -> list[tuple[float, float]]:
    """Sigma and weight of each: blurring twice adds the squares of sigma."""
    own = [0.0, *(float(1 << octave) for octave in range(_MAX_OCTAVES))]
    most = float(lib.NTP_MAX_SIGMA)
    return [
        (min(math.sqrt(sigma * sigma + more * more), most), weight)
        for more, weight in zip(own, weights, strict=False)
    ]


def blur_height(
    height: AnyHeight,
    sigma: float = 0.0,
    *,
    octaves: Sequence[float] = (1.0,),
    border: Border = "wrap",
    border_x: Border | None = None,
    border_y: Border | None = None,
    source: HeightSource = "red",
    out: NDArray[np.float32] | None = None,
) -> NDArray[np.float32]:
    """Blur a heightfield by a Gaussian, or sum several blurs of it.

    Parameters
    ----------
    height : array, (height, width) or (height, width, 1 to 4), uint8, uint16 or float32
        Heights may be float64; they are rounded once, to float32.
        A heightfield, or an image with a height in each pixel; full range is 0..1.
    sigma : float
        Of the Gaussian, in texels, 0..64; 0: none.
    octaves : sequence of float
        The 1 to 8 weights of a sum: of the heights blurred by `sigma`, and of these blurred again
        by 1, 2, 4 texels and so on.
    border, border_x, border_y : {"wrap", "clamp", "mirror", "extrapolate", "repeat-slope"}
        The height beyond the edges; for both axes, or one.
    source : {"red", "green", "blue", "alpha", "luma", "luma-gimp", "luma-eberly", "mean", \
"max", "min", "screen"}
        What of a color image is the height.
    out : array like the result, optional
        Where to write; it does not overlap `height`.

    Returns
    -------
    array, (height, width), float32
        Heights in 0..1, times the sum of the weights.  An image with alpha gives two channels,
        (height, width, 2): the alpha as it is.

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Notes
    -----
    The weights of the Gaussian are integers that add up to 65536 on each axis, so the bytes
    are the same everywhere, and a heightfield that tiles still tiles.

    Examples
    --------
    >>> import normaltexture as nt
    >>> height = nt.read("wall_height.png")
    >>> normals = nt.normals_from_height(nt.blur_height(height, 2), 10, depth=8)
    """
    array = pixels("height", height, "height")
    sigma = number("sigma", sigma, 0, lib.NTP_MAX_SIGMA)
    weights = _weights(octaves)
    options = ffi.new("ntp_blur_options *")
    options.border_x = choose("border_x" if border_x else "border", border_x or border, BORDERS)
    options.border_y = choose("border_y" if border_y else "border", border_y or border, BORDERS)
    options.source = choose("source", source, SOURCES)
    has_alpha = array.ndim == 3 and array.shape[2] % 2 == 0
    if source == "alpha" and not has_alpha:
        raise ArgumentError(f'source="alpha": height has no alpha, its shape is {array.shape}')
    shape = (*array.shape[:2], 2) if has_alpha else array.shape[:2]
    output = Output(shape, DEPTHS["float"], out)
    output.apart_from(False, height=array)
    dst, src = view("out", output.array, HEIGHT, writable=True), view("height", array, HEIGHT)
    for octave, (options.sigma, options.weight) in enumerate(_octaves(sigma, weights)):
        options.add = octave > 0
        size = lib.ntp_height_blur_scratch_size(options, array.shape[1])
        scratch, owner = memory(size)
        check(lib.ntp_height_blur(dst, src, options, scratch, size), "blur_height")
        del owner
    if has_alpha:
        to = view("out", output.array[..., 1], HEIGHT, writable=True)
        alpha = view("height", array[..., -1], HEIGHT)
        check(lib.ntp_convert(to, alpha, ffi.NULL, ffi.NULL, ffi.NULL), "blur_height")
    result: NDArray[np.float32] = output.finish()
    return result


def _weights(octaves: Any) -> list[float]:
    try:
        weights = [float(weight) for weight in octaves]
    except (TypeError, ValueError):
        weights = []
    if not 1 <= len(weights) <= _MAX_OCTAVES or not np.isfinite(weights).all():
        raise ArgumentError(f"octaves={octaves!r}: must be 1 to {_MAX_OCTAVES} finite numbers")
    return weights
