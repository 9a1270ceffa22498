# SPDX-License-Identifier: MIT
"""Accidents that are exactly undone, by the rule of `ntp clean`: exchanged channels, DXT5nm, inverted
blue, sRGB.

They are undone where the classification is sure, or where the caller asks for it.  Otherwise the
texture is refused: cleaning would hide the accident and not repair it.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._classify import Classification, classify, natural_tally, resolve, type_of
from ._errors import ArgumentError
from ._measure import Tally
from .typing import AutoType, Type, Undone

# From here on an accident is undone without being asked to, as on the command line.
SURE = 0.9

_TITLES: dict[Undone, str] = {
    "red-blue": "red and blue are exchanged",
    "green-blue": "green and blue are exchanged",
    "dxt5nm": "it is packed as DXT5nm: x is in alpha, y in green",
    "inverted-blue": "blue is inverted",
    "srgb": "the numbers were converted to sRGB",
}


def accident_of(found: Classification, channels: int) -> Undone | None:
    """The accident that is in the way of cleaning."""
    accidents = found.accidents
    if found.type not in ("standard", "zzero", "xy", "one-color") or channels < 3:
        return None
    if "gamma" in accidents:
        return "srgb"
    if "red-is-z" in accidents:
        return "red-blue"
    if "green-is-z" in accidents:
        return "green-blue"
    if "dxt5nm" in accidents:
        return "dxt5nm" if channels == 4 else None
    return "inverted-blue" if found.type == "standard" and "z-flipped" in accidents else None


def choose_undo(
    src: NDArray[Any], type: AutoType, undo: bool, found: Classification
) -> Undone | None:
    """What is undone of a texture.

    Raises
    ------
    ArgumentError
        There is an accident, and neither the classification nor the caller is sure.
    """
    accident = accident_of(found, src.shape[2] if src.ndim == 3 else 1)
    if accident is None or (type != "auto" and not undo):
        return None
    possible = accident != "srgb" or src.dtype.kind == "u"
    if possible and (undo or found.confidence >= SURE):
        return accident
    if accident == "inverted-blue":  # cleaning mirrors negative z anyhow
        return None
    raise ArgumentError(_question(found, accident, possible, "undo=True", "src", "type"))


def resolve_sound(
    src: NDArray[Any],
    type: AutoType,
    threads: int,
    name: str = "src",
    argument: str = "type",
    measured: Tally | None = None,
) -> Type:
    """The argument `type`, "auto" found out; a texture with an accident is refused.

    What makes another texture of it would hide the accident and could not repair it.  `measured` is
    its natural tally.
    """
    if type != "auto":
        return resolve(src, type, threads, name)
    measured = measured or natural_tally(src, threads)
    found = classify(measured)
    accident = accident_of(found, src.shape[2] if src.ndim == 3 else 1)
    if accident is None:
        return type_of(measured, name, found.type)
    possible = accident != "srgb" or src.dtype.kind == "u"
    raise ArgumentError(
        _question(found, accident, possible, "clean with undo=True", name, argument)
    )


def sound_object(src: NDArray[Any], name: str) -> Type:
    """How a picture of an object stores its normals; it need not look like a texture.

    Only what is sure counts, as on the command line.
    """
    measured = natural_tally(src, 1)
    found = classify(measured)
    if found.confidence < SURE:
        return "standard"
    if found.type in ("height", "not-normals"):
        return type_of(measured, name, found.type)
    accident = accident_of(found, src.shape[2])
    if accident is not None:
        possible = accident != "srgb" or src.dtype.kind == "u"
        who = "clean with undo=True"
        raise ArgumentError(_question(found, accident, possible, who, name, "type"))
    return found.type if found.type in ("zzero", "xy") else "standard"


def _question(
    found: Classification, accident: Undone, possible: bool, who: str, name: str, argument: str
) -> str:
    way = f"{who} puts that right, " if possible else ""
    return (
        f'{argument}="auto": of {name} {_TITLES[accident]} ({100 * found.confidence:.0f} % sure); '
        f'{way}{argument}="standard" takes it as it is'
    )


def undone(src: NDArray[Any], accident: Undone) -> NDArray[Any]:
    """The texture before the accident; DXT5nm gives three channels, z being 1."""
    most = 1 if src.dtype.kind == "f" else np.iinfo(src.dtype).max
    out: NDArray[Any] = src.copy()
    if accident == "red-blue":
        out[..., [0, 2]] = src[..., [2, 0]]
    elif accident == "green-blue":
        out[..., [1, 2]] = src[..., [2, 1]]
    elif accident == "dxt5nm":
        out = np.dstack([src[..., 3], src[..., 1], np.full(src.shape[:2], most, src.dtype)])
    elif accident == "inverted-blue":
        red, green, blue = src[..., 0], src[..., 1], src[..., 2]
        unused = (red == green) & (green == blue) & ((blue == 0) | (blue == most))
        out[..., 2] = np.where(unused, blue, most - blue)
    else:
        out[..., :3] = _linear_levels(int(most)).astype(src.dtype)[src[..., :3]]
    return out


def _reaches(k: int, q: int, most: int) -> bool:
    """Whether the linear light of k / 2 sRGB levels is at least q / 2 levels.

    Above 0.04045 it is ((s + 0.055) / 1.055)^2.4; both sides are raised to the fifth power.
    """
    if 100000 * k <= 8090 * most:
        return 25 * k >= 323 * q
    return bool(32 * (100 * k + 11 * most) ** 12 >= q**5 * 211**12 * most**7)


@lru_cache(maxsize=2)
def _linear_levels(most: int) -> NDArray[np.int64]:
    """The nearest linear level of each sRGB level, in integers."""
    stored = np.arange(most + 1) / most
    light = np.where(stored <= 0.04045, stored / 12.92, ((stored + 0.055) / 1.055) ** 2.4) * most
    nearest = np.floor(light + 0.5).astype(np.int64)
    # Floating point is sure away from the halves; near them integers decide.
    for level in np.flatnonzero(np.abs(light + 0.5 - np.rint(light + 0.5)) < 1e-6):
        below = int(np.rint(light[level] + 0.5)) - 1
        nearest[level] = below + _reaches(2 * int(level), 2 * below + 1, most)
    return nearest
