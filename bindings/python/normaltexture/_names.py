# SPDX-License-Identifier: MIT
"""The strings of arguments and results, and the numbers of the library that they stand for.

Names that the library knows are asked of it; the others are the enumerators of libntp.h in small
letters.  The Literal types of `normaltexture.typing` repeat them for type checkers; a test compares.
"""

from collections.abc import Callable, Mapping
from typing import Any

from ._native import ffi, lib


def _numbers(ctype: str) -> dict[int, str]:
    """The enumerators of an enum by their numbers, in this order."""
    return dict(sorted(ffi.typeof(ctype).elements.items()))


def _lower(enumerator: str, prefix: str) -> str:
    """NTP_HEIGHT_SOURCE_LUMA_GIMP is "luma-gimp"."""
    return enumerator.removeprefix(prefix).lower().replace("_", "-")


def _enumerators(ctype: str, prefix: str) -> dict[str, int]:
    return {_lower(name, prefix): number for number, name in _numbers(ctype).items()}


def _named(ctype: str, name_of: Callable[[int], Any]) -> dict[str, int]:
    return {ffi.string(name_of(number)).decode(): number for number in _numbers(ctype)}


def _bits(prefix: str) -> dict[str, int]:
    found = {_lower(name, prefix): getattr(lib, name) for name in dir(lib) if prefix in name}
    return dict(sorted(found.items(), key=lambda item: item[1]))


def names_of(table: Mapping[str, int]) -> dict[int, str]:
    """The other way round."""
    return {number: name for name, number in table.items()}


AUTO = -1  # for the texels to tell; the library has no number for that

MEASURED = _enumerators("ntp_encoding", "NTP_ENCODING_")
TYPES = {name: number for name, number in MEASURED.items() if name != "height"}
STANDARD, ZZERO, XY, VECTOR, HEIGHT = (
    MEASURED[name] for name in ("standard", "zzero", "xy", "vector", "height")
)
YS = _enumerators("ntp_y", "NTP_Y_")
VERDICTS = _enumerators("ntp_verdict", "NTP_VERDICT_")
CLEAN_METHODS = _enumerators("ntp_clean_method", "NTP_CLEAN_")
BLUES = _enumerators("ntp_blue", "NTP_BLUE_")
PALETTES = _enumerators("ntp_palette", "NTP_PALETTE_")
CLASSES = _named("ntp_class", lib.ntp_class_name)
ACCIDENTS = _bits("NTP_ACCIDENT_")

FOUND_KERNELS = _named("ntp_kernel", lib.ntp_kernel_name)
KERNELS = {name: number for name, number in FOUND_KERNELS.items() if name != "baked"}
BORDERS = _named("ntp_border", lib.ntp_border_name)
SOURCES = _enumerators("ntp_height_source", "NTP_HEIGHT_SOURCE_")
ALPHAS = _enumerators("ntp_alpha", "NTP_ALPHA_")

HEIGHT_METHODS = _named("ntp_height_method", lib.ntp_height_method_name)
_ENCODERS = {"trunc": "unorm-trunc", "snorm": "snorm128"}  # as the command line calls them
DECODES = {
    _ENCODERS.get(name, name): number
    for name, number in _enumerators("ntp_decode", "NTP_DECODE_").items()
}
ZS = _enumerators("ntp_z", "NTP_Z_")

FILTERS = _named("ntp_filter", lib.ntp_filter_name)
RESIZE_BORDERS = {name: BORDERS[name] for name in ("wrap", "clamp", "mirror")}
CURVATURES = _enumerators("ntp_curvature_kind", "NTP_CURVATURE_")
BLOCK_QUALITIES = {
    name.removeprefix("by-"): number
    for name, number in _enumerators("ntp_block_quality", "NTP_BLOCK_").items()
}
BLEND_MODES = _named("ntp_blend_mode", lib.ntp_blend_mode_name)

TOUCH_ALL: int = lib.NTP_UNUSED_ALL
TOUCH_NONE = 0

FILE_FORMATS = _enumerators("ntpio_format", "NTPIO_")
