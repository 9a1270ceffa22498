# SPDX-License-Identifier: MIT
"""What was done to make heights of normals."""

from dataclasses import dataclass
from typing import Any

from ._height_range import told
from ._measure import _Result
from ._names import BORDERS, DECODES, FOUND_KERNELS, HEIGHT_METHODS, ZS, names_of
from .typing import Y

_METHOD_NAMES, _KERNEL_NAMES, _BORDER_NAMES, _DECODE_NAMES, _Z_NAMES = map(
    names_of, (HEIGHT_METHODS, FOUND_KERNELS, BORDERS, DECODES, ZS)
)


@dataclass(frozen=True)
class HeightInfo(_Result):
    """What `height_from_normals` did.

    Attributes
    ----------
    method, kernel, border_x, border_y, y, decode, z : str
        The choice for "auto", otherwise the argument.
    scale, offset : float
        (heights - offset)/scale is 0..1, and with `scale` `normals_from_height` makes these normals
        from that again.
    unused, not_finite : int
        Texels that counted as flat: unused ones, and floats that are not a vector.
    holes, islands : int
        Method "weighted": texels without a height, and connected areas, each with its own mean.
    iterations, error : int, float
        Method "weighted": steps of the last solution, and its final error.
    rounds, refine_left : int
        Rounds done by `refine`, and texels whose normal still differs.
    residual : float
        Root mean square difference of x and y between the normals of the heights and the texture,
        in levels.
    trend_x, trend_y : float
        Slopes to the right and down that `detrend` removed.
    consistency, consistency_max : float
        Method "telescoping": root mean square and maximum difference between slopes of the heights
        and stored slopes that the sums did not use; else 0.
    clipped : int
        Heights that `clip` changed.  `scale` and `offset` are those after it, `residual` before it.
    middle_share : float
        The range of the middle 98 % of the heights, divided by that of all; -1: not computed.
    warnings : tuple of str
        If the residual is more than 8 levels of 8 bit, or `middle_share` below 0.03.
    """

    method: str
    kernel: str
    border_x: str
    border_y: str
    y: Y
    decode: str
    z: str
    scale: float
    offset: float
    unused: int
    not_finite: int
    holes: int
    islands: int
    iterations: int
    error: float
    rounds: int
    refine_left: int
    residual: float
    trend_x: float
    trend_y: float
    consistency: float
    consistency_max: float
    clipped: int
    middle_share: float
    warnings: tuple[str, ...]


def info_of(
    how: Any, result: Any, y: Y, is_8_bit: bool, clipped: int = 0, share: float = -1.0
) -> HeightInfo:
    return HeightInfo(
        method=_METHOD_NAMES[result.method],
        kernel=_KERNEL_NAMES[how.kernel],
        border_x=_BORDER_NAMES[how.border_x],
        border_y=_BORDER_NAMES[how.border_y],
        y=y,
        decode=_DECODE_NAMES[result.decode],
        z=_Z_NAMES[result.z],
        scale=result.max - result.min,
        offset=result.min,
        unused=result.unused,
        not_finite=result.not_finite,
        holes=result.holes,
        islands=result.islands,
        iterations=result.iterations,
        error=result.error,
        rounds=result.rounds,
        refine_left=result.refine_left,
        residual=result.residual,
        trend_x=result.trend_x,
        trend_y=result.trend_y,
        consistency=result.consistency,
        consistency_max=result.consistency_max,
        clipped=clipped,
        middle_share=share,
        warnings=told(result.residual, is_8_bit, share, clipped),
    )
