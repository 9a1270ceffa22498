# SPDX-License-Identifier: MIT
"""Which way green points, where a result depends on it: told, or sure by the texels, or asked."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import choose
from ._errors import ArgumentError
from ._names import AUTO, YS
from ._orientation import Orientation, detect_orientation
from .typing import AutoY, GivenY, Type, Y

_SURE = 0.9  # as on the command line
_LEAST_SIDE = 6  # below, no texel says which way green points
_COLOR, _WITH_ALPHA = 3, 4  # channels
_EIGHT_BIT = 257  # levels of 16 bit in one of 8 bit
_SYNONYMS: dict[str, Y] = {"opengl": "up", "directx": "down"}
_WORDS = YS | {word: YS[y] for word, y in _SYNONYMS.items()}


def choose_y(name: str, y: GivenY) -> int:
    """The number of the argument `y`, which "opengl" and "directx" can be, too."""
    return choose(name, y, _WORDS)


def told(name: str, y: AutoY) -> Y | None:
    """The argument `y`; None: "auto"."""
    choose(name, y, {"auto": AUTO} | _WORDS)
    word: Any = _SYNONYMS.get(y, y)
    return None if word == "auto" else word


def _look(source: NDArray[Any], type: Type, threads: int) -> Orientation | None:
    """From the rows that a check samples.  None: the array is too small."""
    if min(source.shape[:2]) < _LEAST_SIDE:
        return None
    return detect_orientation(source, type=type, threads=threads)


_FIRST_ROWS, _ROWS = 2, 64


def find(source: NDArray[Any], type: Type, threads: int) -> Y | None:
    """As the texels show, where that is sure."""
    found = _look(source, type, threads)
    return found.likelier if found is not None and found.confidence >= _SURE else None


def _levels(source: NDArray[Any], type: Type) -> tuple[NDArray[np.int64], int]:
    """Stored levels, floats rounded to 16 bit, and the greatest of them."""
    if source.dtype.kind != "f":
        return source.astype(np.int64), int(np.iinfo(source.dtype).max)
    unit = (source.astype(float) + 1) / 2 if type == "vector" else source.astype(float)
    return np.floor(np.clip(np.nan_to_num(unit), 0, 1) * 65535 + 0.5).astype(np.int64), 65535


def _parts(source: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Rows from the first on: few, then more, as the first ones are mostly enough."""
    first, rows = 0, _FIRST_ROWS
    while first < len(source):
        yield source[first : first + rows]
        first += rows
        rows = min(4 * rows, _ROWS)


def _neutral(source: NDArray[Any], type: Type) -> int:
    """How far twice a level may be from the greatest one and still be 0: more in 8 bit kept in 16."""
    if source.dtype == np.uint8:
        return 1
    wide = any((_levels(part, type)[0] % _EIGHT_BIT).any() for part in _parts(source))
    return 1 if wide else _EIGHT_BIT


def slopes(source: NDArray[Any], type: Type, touch_unused: bool = False) -> tuple[bool, bool]:
    """Is x, is y of any used texel not 0, as nearly as the depth can say it?"""
    neutral = _neutral(source, type)
    x = y = False
    for part in _parts(source):
        found = _slopes(part, type, touch_unused, neutral)
        x, y = x or found[0], y or found[1]
        if x and y:
            break
    return x, y


def _slopes(
    source: NDArray[Any], type: Type, touch_unused: bool, neutral: int
) -> tuple[bool, bool]:
    level, m = _levels(source, type)
    used = np.ones(level.shape[:2], bool)
    if not touch_unused and type != "vector":
        color = level[..., :_COLOR]
        if level.shape[2] >= _COLOR:
            used &= (color != 0).any(-1) & (color != m).any(-1)
        if level.shape[2] == _WITH_ALPHA:
            used &= level[..., _WITH_ALPHA - 1] > 0
    leaning = np.abs(2 * level[..., :2] - m)[used] > neutral
    return bool(leaning[:, 0].any()), bool(leaning[:, 1].any())


def question(source: NDArray[Any], type: Type, threads: int, name: str, array: str) -> str:
    """What cannot be known, and which argument says it."""
    found = _look(source, type, threads)
    if found is not None and found.y != "undecided":
        program = "OpenGL" if found.y == "up" else "DirectX"
        seen = f"the texels of {array} look like {program}, {100 * found.confidence:.0f} % sure"
    else:
        seen = f"the texels of {array} do not show which way green points"
    return f'{name}="auto": {seen}; which is it, {name}="up" (OpenGL) or {name}="down" (DirectX)?'


def known(
    name: str,
    y: AutoY,
    source: NDArray[Any],
    type: Type,
    threads: int,
    needed: bool,
    otherwise: Y = "up",
) -> Y:
    """The argument `y`, "auto" found out; `otherwise` if not sure and not `needed`."""
    given = told(name, y) or find(source, type, threads)
    if given is None and needed:
        raise ArgumentError(question(source, type, threads, name, "src"))
    return given or otherwise


def known_or_up(y: AutoY, source: NDArray[Any], type: Type, array: str) -> Y:
    """The argument `y`; "auto": as the texels show, and "up" where nothing says "down"."""
    given = told("y", y) or find(source, type, 1)
    if given is None:
        found = _look(source, type, 1)
        if found is not None and found.y == "down":
            raise ArgumentError(question(source, type, 1, "y", array))
    return given or "up"
