# SPDX-License-Identifier: MIT
"""The range that most heights lie in, clipping to it, and what is told about heights."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST_CLIP = 49.0  # percent
_POOR_FIT = 8  # levels of 8 bit; rounding leaves .2, JPEG and painting a few
_LEAST_MIDDLE = 0.03  # of the range; where the middle 98 % take less, the rest are spikes


def middle(heights: NDArray[np.float32], holes: bool, percent: float) -> tuple[float, float]:
    """The least and the greatest height of what is left when `percent`, rounded down, are left out
    at each end.  With `holes`, a height of exactly 0 stands for a hole."""
    used = heights[heights != 0] if holes else heights.ravel()
    if used.size == 0:
        return 0.0, 0.0
    first = int(used.size * percent / 100)
    last = used.size - 1 - first
    found = np.partition(used, (first, last))
    return float(found[first]), float(found[last])


def clip_heights(heights: NDArray[np.float32], holes: bool, percent: float, result: Any) -> int:
    """Clips in place and sets the range in `result`; how many heights changed."""
    least, greatest = middle(heights, holes, percent)
    clipped = np.count_nonzero((heights < least) | (heights > greatest))
    np.clip(heights, least, greatest, out=heights)
    result.min, result.max = least, greatest
    return int(clipped)


def middle_share(heights: NDArray[np.float32], result: Any) -> float:
    """The range of the middle 98 %, divided by that of all."""
    everything: float = result.max - result.min
    least, greatest = middle(heights, result.holes > 0, 1)
    return (greatest - least) / everything if everything > 0 else 1.0


def told(residual: float, is_8_bit: bool, share: float, clipped: int) -> tuple[str, ...]:
    """The warnings of `HeightInfo`."""
    found = []
    fit = residual if is_8_bit else residual / 257
    if fit > _POOR_FIT:
        found.append(
            f"the heights give back normals that are {fit:.3g} levels of 8 bit off (rms): no surface"
            " has these normals, or y, kernel or border is wrong"
        )
    if 0 <= share < _LEAST_MIDDLE:
        more = "a greater clip leaves more out" if clipped else "clip=0.1 leaves spikes out"
        found.append(
            f"the middle 98 % of the heights take {100 * share:.2g} % of the range; {more}"
        )
    return tuple(found)
