# SPDX-License-Identifier: MIT
"""Which way green points."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, overload

from ._arrays import Pool, choose, pixels, view
from ._errors import check
from ._measure import _Result
from ._names import TOUCH_ALL, TOUCH_NONE, TYPES, YS, names_of
from ._native import ffi, lib
from ._threads import QUICK, THOROUGH, run
from .typing import (
    AnyPixels,
    Floats,
    Stored,
    Type,
    Y,
)

_Y_NAMES = names_of(YS)
_SUMS = Pool(lib.ntp_orientation_size(), lambda memory: lib.ntp_orientation_clear(memory))


@dataclass(frozen=True)
class Orientation(_Result):
    """Which way green points.

    Attributes
    ----------
    y : {"up", "down", "undecided"}
        "up": OpenGL, glTF, USD; "down": DirectX.
    confidence : float
        0.8..0.99; 0 if undecided.
    likelier : {"up", "down"}
        The better guess, also if undecided.
    statistic : float
        -1..1: how well the cross derivatives agree; positive: up.
    score : float
        How consistent this is over the picture, in standard deviations.
    loops : int
        How much was measured: groups of 6 x 6 texels.
    """

    y: Literal["up", "down", "undecided"]
    confidence: float
    likelier: Y
    statistic: float
    score: float
    loops: int


@overload
def detect_orientation(
    src: Floats,
    *,
    type: Literal["vector"],
    deep: bool = ...,
    touch_unused: bool = ...,
    threads: int = ...,
) -> Orientation: ...
@overload
def detect_orientation(
    src: AnyPixels,
    *,
    type: Stored = ...,
    deep: bool = ...,
    touch_unused: bool = ...,
    threads: int = ...,
) -> Orientation: ...
def detect_orientation(
    src: AnyPixels | Floats,
    *,
    type: Type = "standard",
    deep: bool = False,
    touch_unused: bool = False,
    threads: int = 1,
) -> Orientation:
    """Detect OpenGL or DirectX from the texels alone, or say that it cannot be known.

    The slopes of a surface have equal cross derivatives; if green is the other way round, they are
    opposite.  The answer assumes that red points right.

    Parameters
    ----------
    src : array, (height, width, channels), uint8, uint16 or float32
        Vectors may be float64; they are rounded once, to float32.
        A normals texture of at least 6 x 6 texels.
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored; only red and green count.
    deep : bool
        Read every row, also of large textures.
    touch_unused : bool
        Look at pure black, pure white and transparent texels too.
    threads : int
        How many threads share the rows; 0: one for each processor.

    Returns
    -------
    Orientation

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here.

    Notes
    -----
    docs/orientation.md says how it works and what cannot be known.

    Examples
    --------
    >>> import normaltexture as nt
    >>> y, x = np.mgrid[0:64, 0:64].astype(np.float32) / 32 - 1
    >>> bump = np.exp(-4 * (x * x + y * y))
    >>> normals = nt.normals_from_height(bump, scale=20, depth=8, to_y="down")
    >>> nt.detect_orientation(normals).y
    'down'
    """
    encoding = choose("type", type, TYPES)
    source = pixels("src", src, type)
    src_view = view("src", source, encoding)
    touch = TOUCH_ALL if touch_unused else TOUCH_NONE

    def work(areas: Iterable[Any]) -> tuple[Any, Any]:
        part, owner = _SUMS.take()
        for area in areas:
            check(
                lib.ntp_orientation_add(part, src_view, touch, bool(deep), area),
                "detect_orientation",
            )
        return part, owner

    parts = run(threads, source.shape[1], source.shape[0], work, THOROUGH if deep else QUICK)
    sums = parts[0][0]
    for part, _ in parts[1:]:
        check(lib.ntp_orientation_merge(sums, part), "detect_orientation")
    found = ffi.new("ntp_orientation_result *")
    check(lib.ntp_orientation_summarize(found, sums), "detect_orientation")
    for part, owner in parts:
        _SUMS.give(part, owner)
    likelier: Any = _Y_NAMES[found.y]
    return Orientation(
        y=likelier if found.decided else "undecided",
        confidence=found.confidence,
        likelier=likelier,
        statistic=found.statistic,
        score=found.score,
        loops=found.loops,
    )
