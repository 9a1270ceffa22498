# SPDX-License-Identifier: MIT
"""Normals textures (normal maps): exact conversion, checking, cleaning, from and to heights.

Functions take numpy arrays of shape (height, width) or (height, width, channels), row 0 at the top,
of uint8, uint16 or float32 samples, and return new ones or fill `out`.  Names, strings and defaults
are those of the command line.  Results are the same bytes on every machine.

>>> import normaltexture as nt
>>> texture = nt.read("wall_n.png")
>>> nt.check("wall_n.png").ok
False
>>> cleaned = nt.clean(texture)
>>> nt.write("wall_clean_n.png", cleaned)
>>> nt.check("wall_clean_n.png").ok
True
"""

from ._classify import Classification, MethodChoice, choose_method, classify
from ._clean import CleanCounts, clean
from ._convert import ConvertCounts, convert, decode, encode
from ._errors import (
    ArgumentError,
    CancelledError,
    FileError,
    FileStatus,
    NormalTextureError,
    NotConvergedError,
    SampleTypeError,
    Status,
)
from ._files import ImageInfo, read, read_info, write
from ._height import GradientCounts, normals_from_height
from ._measure import (
    Angles,
    Channel,
    Fit,
    Stats,
    Tally,
    measure,
)
from ._native import ffi as _ffi
from ._native import lib as _lib
from ._operations import blend, mip_chain, resize, transform
from ._orientation import Orientation, detect_orientation
from ._origin import Origin, Seam, Steps, find_origin, find_seams, find_steps
from ._pictures import Difference, Light, compare, heatmap, shade
from ._program import CheckedFile, CheckReport, Finding, check, program
from ._reconstruct import HeightInfo, height_from_normals
from ._rows import height_from_rows
from ._validate import Flag, Texel, inspect, validate

_version: int = _lib.ntp_version()
__version__ = f"{_version >> 16}.{_version >> 8 & 255}.{_version & 255}"
codecs: str = _ffi.string(_lib.ntpio_versions()).decode()
"""The libraries that files are read and written with, and their versions."""

__all__ = [
    "Angles",
    "ArgumentError",
    "CancelledError",
    "Channel",
    "CheckReport",
    "CheckedFile",
    "Classification",
    "CleanCounts",
    "ConvertCounts",
    "Difference",
    "FileError",
    "FileStatus",
    "Finding",
    "Fit",
    "Flag",
    "GradientCounts",
    "HeightInfo",
    "ImageInfo",
    "Light",
    "MethodChoice",
    "NormalTextureError",
    "NotConvergedError",
    "Orientation",
    "Origin",
    "SampleTypeError",
    "Seam",
    "Stats",
    "Status",
    "Steps",
    "Tally",
    "Texel",
    "__version__",
    "blend",
    "check",
    "choose_method",
    "classify",
    "clean",
    "codecs",
    "compare",
    "convert",
    "decode",
    "detect_orientation",
    "encode",
    "find_origin",
    "find_seams",
    "find_steps",
    "heatmap",
    "height_from_normals",
    "height_from_rows",
    "inspect",
    "measure",
    "mip_chain",
    "normals_from_height",
    "program",
    "read",
    "read_info",
    "resize",
    "shade",
    "transform",
    "validate",
    "write",
]
