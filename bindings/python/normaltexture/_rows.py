# SPDX-License-Identifier: MIT
"""Normals to heightfields larger than memory: functions of the caller read and write rows."""

from collections.abc import Callable
from typing import Any, Literal, Unpack, overload

import numpy as np
from numpy.typing import NDArray

from ._arrays import CHANNELS, DEPTHS, MAX_SIDE, SAMPLE_TYPES, choose, memory, spacing
from ._errors import ArgumentError, SampleTypeError, Status, check
from ._green import choose_y, told
from ._height_info import HeightInfo, info_of
from ._names import (
    BORDERS,
    DECODES,
    FOUND_KERNELS,
    HEIGHT_METHODS,
    TOUCH_ALL,
    TOUCH_NONE,
    TYPES,
    ZS,
)
from ._native import ffi, lib
from ._reconstruct import cannot
from ._solve import SCRATCH_ALIGNMENT, Callbacks, stop
from .typing import (
    Border,
    Decode,
    Depth,
    GivenY,
    ReadRows,
    RowKernel,
    RowMethod,
    RowsHow,
    Stored,
    Type,
    WriteRows,
    Z,
)

_KERNELS = {name: FOUND_KERNELS[name] for name in ("central", "forward", "baked")}
_METHODS = {name: HEIGHT_METHODS[name] for name in ("auto", "frankot-chellappa", "poisson-dct")}
_FLOAT = np.dtype(np.float32)


class _Rows(Callbacks):
    """The caller's functions, between libntp's memory and numpy's."""

    def __init__(
        self,
        functions: tuple[ReadRows, WriteRows, ReadRows],
        shape: tuple[int, int, int],
        dtype: np.dtype[Any],
        threads: int,
        progress: Callable[[float], object] | None,
    ) -> None:
        super().__init__(threads, shape[0] * shape[1], progress)
        self.read_normals, self.write_heights, self.read_heights = functions
        self._row = shape[1:]
        self._dtype = dtype
        self._scratch, self._begin = np.empty(0, np.uint8), 0

    def room(self, size: int) -> Any:
        """Working memory."""
        pointer, self._scratch = memory(size, SCRATCH_ALIGNMENT)
        self._begin = int(ffi.cast("uintptr_t", ffi.from_buffer(self._scratch)))
        return pointer

    def _there(self, rows: Any, shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
        """Rows in the working memory, which lives as long as the array."""
        begin = int(ffi.cast("uintptr_t", rows)) - self._begin
        return np.ndarray(shape, dtype, self._scratch.data, begin)

    def fill(self, name: str, rows: Any, y: int, count: int) -> None:
        """Puts there what one of the reading functions gives."""
        is_normals = name == "read_normals"
        shape = (count, *self._row) if is_normals else (count, self._row[0])
        dtype = self._dtype if is_normals else _FLOAT
        got = np.asarray((self.read_normals if is_normals else self.read_heights)(y, count))
        if got.shape != shape or (got.dtype != dtype and got.dtype.newbyteorder("=") != dtype):
            raise ArgumentError(
                f"{name}({y}, {count}): must return an array of shape {shape} and {dtype},"
                f" not of shape {got.shape} and {got.dtype}",
                Status.SHAPE,
            )
        self._there(rows, shape, dtype)[...] = got

    def write(self, rows: Any, y: int, count: int) -> None:
        there = self._there(rows, (count, self._row[0]), _FLOAT)
        there.flags.writeable = False
        self.write_heights(y, there)


@ffi.def_extern(name="ntp_py_read_normals", onerror=stop)  # type: ignore[untyped-decorator]
def _read_normals(user: Any, rows: Any, y: int, count: int) -> int:
    work: _Rows = ffi.from_handle(user)
    work.fill("read_normals", rows, y, count)
    return 0


@ffi.def_extern(name="ntp_py_read_heights", onerror=stop)  # type: ignore[untyped-decorator]
def _read_heights(user: Any, rows: Any, y: int, count: int) -> int:
    work: _Rows = ffi.from_handle(user)
    work.fill("read_heights", rows, y, count)
    return 0


@ffi.def_extern(name="ntp_py_write_heights", onerror=stop)  # type: ignore[untyped-decorator]
def _write_heights(user: Any, rows: Any, y: int, count: int) -> int:
    work: _Rows = ffi.from_handle(user)
    work.write(rows, y, count)
    return 0


def _shape(shape: Any, encoding: int) -> tuple[int, int, int]:
    low, high = CHANNELS[encoding]
    try:
        height, width, channels = (int(side) for side in shape)
    except (TypeError, ValueError):
        raise ArgumentError(f"shape={shape!r}: must be (height, width, channels)") from None
    if not (1 <= height <= MAX_SIDE and 1 <= width <= MAX_SIDE and low <= channels <= high):
        raise ArgumentError(
            f"shape={shape!r}: must be (1..{MAX_SIDE}, 1..{MAX_SIDE}, {low}..{high})", Status.SHAPE
        )
    return height, width, channels


@overload
def height_from_rows(
    read_normals: ReadRows,
    write_heights: WriteRows,
    read_heights: ReadRows,
    *,
    type: Literal["vector"],
    depth: Literal["float"],
    **how: Unpack[RowsHow],
) -> HeightInfo: ...
@overload
def height_from_rows(
    read_normals: ReadRows,
    write_heights: WriteRows,
    read_heights: ReadRows,
    *,
    type: Stored = ...,
    depth: Depth = ...,
    **how: Unpack[RowsHow],
) -> HeightInfo: ...
def height_from_rows(
    read_normals: ReadRows,
    write_heights: WriteRows,
    read_heights: ReadRows,
    *,
    shape: tuple[int, int, int],
    depth: Depth = 8,
    type: Type = "standard",
    y: GivenY = "up",
    method: RowMethod = "auto",
    kernel: RowKernel = "central",
    border: Border = "wrap",
    border_x: Border | None = None,
    border_y: Border | None = None,
    dx: float = 1.0,
    dy: float = 1.0,
    decode: Decode = "auto",
    z: Z = "auto",
    touch_unused: bool = False,
    progress: Callable[[float], object] | None = None,
    threads: int = 1,
) -> HeightInfo:
    """Reconstruct the heightfield of normals, row by row, for pictures too large for memory.

    The heights are those of `height_from_normals`, byte for byte, with the same kernel, borders,
    `y`, `decode` and `z`, but nothing is detected here.  The exception is "central" with
    "extrapolate", whose edges are not fitted again.

    Parameters
    ----------
    read_normals : callable (y, count) -> array, (count, width, channels)
        Returns this many rows of normals from row y on.  Groups of rows are read in order down the
        picture, with a few rows around each; with `border="wrap"` also those of the opposite end.
    write_heights : callable (y, rows)
        Keeps `rows`, (count, width), float32, read-only, from row y on; they are valid until it
        returns.  On the way down these are not heights yet.  Then, from the last group to the
        first, each is read again and written as heights.
    read_heights : callable (y, count) -> array, (count, width), float32
        Returns what was written there last.
    shape : (height, width, channels)
        Of the normals: 3 or 4 channels (`"xy"`: 2 to 4).
    depth : {8, 16, "float"}
        Samples of the normals: uint8, uint16 or float32.
    type : {"standard", "zzero", "xy", "vector"}
        How a normal is stored.
    y : {"up", "down", "opengl", "directx"}
        Which way green points.
    method : {"auto", "frankot-chellappa", "poisson-dct"}
        Least squares by the borders; for textures that tile; for those that do not.
    kernel : {"central", "forward", "baked"}
        How the slopes were computed; "baked": they are those of a surface, at texel centers.
    border, border_x, border_y : one of `normals_from_height`
        The height beyond the edges; for both axes, or one.  "central" does not support
        `border_y="mirror"`.
    dx, dy : float
        Width and height of a texel.
    decode : {"auto", "unorm", "neutral", "unorm-trunc", "snorm128"}
        As in `height_from_normals`; "auto" means "unorm".
    z : {"auto", "stored", "derived"}
        Whether z is read from blue or computed from red and green; "auto" means "stored".
    touch_unused : bool
        Use pure black, pure white and transparent texels like any other.
    progress : callable, optional
        Called now and then with the share done, 0..1; returning False stops.
    threads : int
        How many threads work; 0: one for each processor.  The bytes are the same.  The functions
        are called from the caller's thread only.

    Returns
    -------
    HeightInfo

    Raises
    ------
    ArgumentError, SampleTypeError
        For arguments outside what is listed here, rows of another shape or type, and kernels and
        borders that cannot be solved row by row.
    CancelledError
        If `progress` returned False.
    Exception
        What one of the functions raises ends the work and is raised here.

    Examples
    --------
    >>> import numpy as np, normaltexture as nt
    >>> normals = nt.normals_from_height(nt.read("wall_height.png"), scale=8, depth=16)
    >>> heights = np.empty(normals.shape[:2], np.float32)  # np.memmap, or a part of a file
    >>> def write(y, rows):
    ...     heights[y : y + len(rows)] = rows
    >>> info = nt.height_from_rows(
    ...     lambda y, count: normals[y : y + count],
    ...     write,
    ...     lambda y, count: heights[y : y + count],
    ...     shape=normals.shape,
    ...     depth=16,
    ... )
    >>> whole = nt.height_from_normals(normals, kernel="central", border="wrap", z="stored")
    >>> np.array_equal(heights, whole)
    True
    """
    for name, function in (
        ("read_normals", read_normals),
        ("write_heights", write_heights),
        ("read_heights", read_heights),
    ):
        if not callable(function):
            raise ArgumentError(f"{name}: must be callable, not {function.__class__.__name__}")
    encoding = choose("type", type, TYPES)
    height, width, channels = _shape(shape, encoding)
    dtype = choose("depth", depth, DEPTHS)
    if type == "vector" and dtype != _FLOAT:
        raise SampleTypeError(f'depth={depth!r}: type="vector" needs "float"')
    up = choose_y("y", y)
    how = ffi.new("ntp_height_options *")
    how.method = choose("method", method, _METHODS)
    how.kernel = choose("kernel", kernel, _KERNELS)
    how.border_x = choose("border_x" if border_x else "border", border_x or border, BORDERS)
    how.border_y = choose("border_y" if border_y else "border", border_y or border, BORDERS)
    how.dx, how.dy = spacing(dx, dy)
    how.decode = choose("decode", decode, DECODES)
    how.z = choose("z", z, ZS)
    how.touch_unused = TOUCH_ALL if touch_unused else TOUCH_NONE
    form = ffi.new(
        "ntp_const_image *",
        (ffi.NULL, 0, 0, width, height, channels, 0, SAMPLE_TYPES[dtype], encoding, up),
    )
    functions = read_normals, write_heights, read_heights
    work = _Rows(functions, (height, width, channels), dtype, threads, progress)
    size = lib.ntp_height_rows_scratch_size(form, how, work.parts)
    if size == 0:
        cannot(how, Status.FORMAT, dtype == _FLOAT, " row by row")
    handle = ffi.new_handle(work)
    rows = ffi.new(
        "ntp_height_rows *",
        (handle, lib.ntp_py_read_normals, lib.ntp_py_read_heights, lib.ntp_py_write_heights),
    )
    result = ffi.new("ntp_height_result *")
    status = lib.ntp_height_from_rows(
        form, rows, how, work.room(size), size, work.hooks(handle, True), result
    )
    work.check()
    check(status, "height_from_rows")
    return info_of(how, result, told("y", y) or "up", dtype == np.uint8)
