# SPDX-License-Identifier: MIT
"""Normals textures (normal maps): exact conversion, checking, cleaning, from and to heights.

Functions take numpy arrays of shape (height, width) or (height, width, channels), row 0 at the top,
of uint8, uint16 or float32 samples, and return new ones or fill `out`.  Names, strings and defaults
are those of the command line: `type` and `y` say what an array is, and `to` and `to_y` what the
result should be.  Results are the same bytes on every machine.

>>> import normaltexture as nt
>>> texture = nt.read("wall_n.png")
>>> nt.check("wall_n.png").ok
False
>>> cleaned = nt.clean(texture)
>>> nt.write("wall_clean_n.png", cleaned)
>>> nt.check("wall_clean_n.png").ok
True
"""

from ._blend import blend
from ._blocks import encode_bc4, encode_bc5
from ._blur import blur_height
from ._channels import pack_channels
from ._classify import Classification, MethodChoice, choose_method, classify
from ._clean import CleanCounts, clean, clean_with_counts
from ._convert import ConvertCounts, convert, convert_with_counts
from ._depth import depth_from_normals, depth_from_normals_with_confidence
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
from ._files import ImageInfo, read, read_info, read_with_info, write
from ._height import (
    NormalsCounts,
    like,
    normals_from_height,
    normals_from_height_with_counts,
)
from ._height_info import HeightInfo
from ._height_scale import suggest_scale
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
from ._orientation import Orientation, detect_orientation
from ._origin import KernelFit, Seam, Steps, find_kernel, find_seams, find_steps
from ._pictures import Difference, Light, compare, heatmap, shade
from ._program import CheckedFile, CheckReport, Finding, check, program
from ._reconstruct import height_from_normals, height_from_normals_with_info
from ._relief import curvature, occlusion
from ._resize import mip_chain, resize
from ._rows import height_from_rows
from ._transform import transform
from ._validate import Flag, Texel, inspect, validate
from ._vectors import decode, encode

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
    "HeightInfo",
    "ImageInfo",
    "KernelFit",
    "Light",
    "MethodChoice",
    "NormalTextureError",
    "NormalsCounts",
    "NotConvergedError",
    "Orientation",
    "SampleTypeError",
    "Seam",
    "Stats",
    "Status",
    "Steps",
    "Tally",
    "Texel",
    "__version__",
    "blend",
    "blur_height",
    "check",
    "choose_method",
    "classify",
    "clean",
    "clean_with_counts",
    "codecs",
    "compare",
    "convert",
    "convert_with_counts",
    "curvature",
    "decode",
    "depth_from_normals",
    "depth_from_normals_with_confidence",
    "detect_orientation",
    "encode",
    "encode_bc4",
    "encode_bc5",
    "find_kernel",
    "find_seams",
    "find_steps",
    "heatmap",
    "height_from_normals",
    "height_from_normals_with_info",
    "height_from_rows",
    "inspect",
    "like",
    "measure",
    "mip_chain",
    "normals_from_height",
    "normals_from_height_with_counts",
    "occlusion",
    "pack_channels",
    "program",
    "read",
    "read_info",
    "read_with_info",
    "resize",
    "shade",
    "suggest_scale",
    "transform",
    "validate",
    "write",
]
