# SPDX-License-Identifier: MIT
"""The types of arguments and results, for annotations of your own.

>>> from normaltexture.typing import AnyPixels, Kernel
>>> def bumpy(height: AnyPixels, kernel: Kernel) -> AnyPixels: ...
"""

from collections.abc import Callable, Sequence
from typing import Literal, Required, TypeAlias, TypedDict, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Sample: TypeAlias = np.uint8 | np.uint16 | np.float32
"""What an array holds."""
SampleT = TypeVar("SampleT", bound=np.uint8 | np.uint16 | np.float32)
"""What an array holds, where a result holds the same."""
AnyPixels: TypeAlias = NDArray[np.uint8 | np.uint16 | np.float32]
"""An image of any depth, such as `read` gives."""
Floats: TypeAlias = NDArray[np.float32 | np.float64]
"""Vectors or heights; float64 is rounded once, to float32."""
AnyHeight: TypeAlias = NDArray[np.uint8 | np.uint16 | np.float32 | np.float64]
"""Heights of any depth; float64 is rounded once, to float32."""

Stored: TypeAlias = Literal["standard", "zzero", "xy"]
"""How a normal is stored: z in -1..1, z in 0..1, no z."""
AutoStored: TypeAlias = Literal["auto"] | Stored
Type: TypeAlias = Stored | Literal["vector"]
""""vector": the components as they are, float32."""
AutoType: TypeAlias = Literal["auto"] | Type
MeasuredType: TypeAlias = Type | Literal["height"]
ComparedType: TypeAlias = Literal["auto"] | MeasuredType
Y: TypeAlias = Literal["up", "down"]
"""Which way green points: OpenGL, or DirectX."""
GivenY: TypeAlias = Y | Literal["opengl", "directx"]
"""The same, also by the names of programs."""
AutoY: TypeAlias = Literal["auto"] | GivenY
Depth: TypeAlias = Literal[8, 16, "float"]
"""Samples: uint8, uint16 or float32."""
Blue: TypeAlias = Literal["derived", "nearest"]

CleanMethod: TypeAlias = Literal["derive", "normalize", "auto"]
ChosenMethod: TypeAlias = Literal["derive", "normalize", "keep"]
Undone: TypeAlias = Literal["red-blue", "green-blue", "dxt5nm", "inverted-blue", "srgb"]
"""An accident that `clean` has undone."""
Verdict: TypeAlias = Literal["neighbor", "rounded", "exact"]
Palette: TypeAlias = Literal["reference", "safe"]
Policy: TypeAlias = Literal["harm", "strict"]
Class: TypeAlias = Literal[
    "standard", "zzero", "xy", "height", "object-space", "one-color", "not-normals"
]
CheckType: TypeAlias = Literal["auto", "standard", "zzero", "xy", "height"]
Level: TypeAlias = Literal["error", "warning", "info"]

Kernel: TypeAlias = Literal[
    "central",
    "forward",
    "prewitt3",
    "sobel3",
    "scharr3",
    "prewitt5",
    "sobel5",
    "gimp5",
    "gimp7",
    "gimp9",
]
Border: TypeAlias = Literal["wrap", "clamp", "mirror", "extrapolate", "repeat-slope"]
HeightSource: TypeAlias = Literal[
    "red",
    "green",
    "blue",
    "alpha",
    "luma",
    "luma-gimp",
    "luma-eberly",
    "mean",
    "max",
    "min",
    "screen",
]
Alpha: TypeAlias = Literal["keep", "one", "inverse", "height", "inverse-height"]
Scale: TypeAlias = float | Literal["auto"]
Dither: TypeAlias = Literal["none", "integrable"]

FoundKernel: TypeAlias = Kernel | Literal["baked"]
HeightKernel: TypeAlias = Literal["auto"] | FoundKernel
AutoBorder: TypeAlias = Literal["auto"] | Border
HeightMethod: TypeAlias = Literal[
    "auto", "telescoping", "frankot-chellappa", "poisson-dct", "weighted"
]
Decode: TypeAlias = Literal["auto", "unorm", "neutral", "unorm-trunc", "snorm128"]
Z: TypeAlias = Literal["auto", "stored", "derived"]
RowKernel: TypeAlias = Literal["central", "forward", "baked"]
RowMethod: TypeAlias = Literal["auto", "frankot-chellappa", "poisson-dct"]
Mask: TypeAlias = NDArray[np.uint8 | np.uint16 | np.bool_]
ReadRows: TypeAlias = Callable[[int, int], ArrayLike]
WriteRows: TypeAlias = Callable[[int, NDArray[np.float32]], object]

Filter: TypeAlias = Literal["box", "triangle", "lanczos3"]
ResizeBorder: TypeAlias = Literal["wrap", "clamp", "mirror"]
ReliefBorder: TypeAlias = Literal["auto", "wrap", "clamp"]
CurvatureKind: TypeAlias = Literal["mean", "gaussian", "convex", "cavity"]
AutoReliefType: TypeAlias = Literal["auto"] | MeasuredType
BlockQuality: TypeAlias = Literal["angle", "channel", "quick"]
Compression: TypeAlias = Literal["blocks", "none"]
BlendMode: TypeAlias = Literal["rnm", "whiteout", "udn", "linear"]
Flip: TypeAlias = Literal["x", "y", "xy"]
Size: TypeAlias = tuple[int, int] | str


class LikeSettings(TypedDict):
    """Keyword arguments of `normals_from_height`, as `like` gives them."""

    scale: float
    kernel: Kernel
    border: Border
    source: HeightSource
    to_y: Y


class CleanHow(TypedDict, total=False):
    """Arguments of `clean` that do not decide the type of its result."""

    method: CleanMethod
    verdict: Verdict
    only_failing: bool
    keep_negative_z: bool
    touch_unused: bool
    undo: bool
    threads: int


class ConvertHow(TypedDict, total=False):
    """The same of `convert`."""

    y: AutoY
    to_y: GivenY | None
    blue: Blue
    channels: str | None
    from_channels: str | None
    touch_unused: bool
    threads: int


class EncodeHow(TypedDict, total=False):
    """The same of `encode`."""

    to: Stored
    to_y: GivenY
    blue: Blue
    threads: int


class NormalsHow(TypedDict, total=False):
    """The same of `normals_from_height`."""

    strength: float
    dx: float
    dy: float
    invert: bool
    kernel: Kernel
    border: Border
    border_x: Border | None
    border_y: Border | None
    source: HeightSource | None
    dither: Dither
    to_y: GivenY
    blue: Blue
    min_z: float
    alpha: Alpha | None
    threads: int


class HeightsHow(TypedDict, total=False):
    """The same of `height_from_normals`."""

    y: AutoY
    method: HeightMethod
    kernel: HeightKernel
    border: AutoBorder
    border_x: AutoBorder | None
    border_y: AutoBorder | None
    dx: float
    dy: float
    refine: int
    seeds: Sequence[float] | None
    equalize: bool
    mask: Mask | None
    detrend: bool
    clip: float
    decode: Decode
    z: Z
    touch_unused: bool
    progress: Callable[[float], object] | None
    threads: int


class RowsHow(TypedDict, total=False):
    """The same of `height_from_rows`."""

    shape: Required[tuple[int, int, int]]
    y: GivenY
    method: RowMethod
    kernel: RowKernel
    border: Border
    border_x: Border | None
    border_y: Border | None
    dx: float
    dy: float
    decode: Decode
    z: Z
    touch_unused: bool
    progress: Callable[[float], object] | None
    threads: int


class ResizeHow(TypedDict, total=False):
    """The same of `resize` and `mip_chain`."""

    filter: Filter
    border: ResizeBorder
    border_x: ResizeBorder | None
    border_y: ResizeBorder | None
    touch_unused: bool
    threads: int


class SizedHow(ResizeHow, total=False):
    """The same of `resize`."""

    size: Required[Size]


class TransformHow(TypedDict, total=False):
    """The same of `transform`."""

    strength: float | None
    flip: Flip | None
    rotate: float
    border: ResizeBorder
    border_x: ResizeBorder | None
    border_y: ResizeBorder | None
    y: AutoY
    threads: int


class BlendHow(TypedDict, total=False):
    """The same of `blend`."""

    mode: BlendMode
    strength: float
    y: AutoY
    detail_y: AutoY
    detail_alpha: bool
    touch_unused: bool
    threads: int
