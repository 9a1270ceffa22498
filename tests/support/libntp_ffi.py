# SPDX-License-Identifier: MIT
"""The built libntp.so, called from Python.

The declarations are cut from libntp.h between its two cdef marks, so the tests speak the same
interface as a C program does.  `view` turns a numpy array into an ntp_image without copying:
crops, negative strides and single channels included.
"""

import os
import re
from pathlib import Path

import cffi
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
HEADER = ROOT / "libntp" / "include" / "libntp.h"
# The one directory from which built files come: no test may take another build's.
BUILD = Path(os.environ.get("NTP_BUILD") or ROOT / "build").resolve()

STANDARD, ZZERO, XY, VECTOR, HEIGHT = range(5)
U8, U16, F32 = range(3)
UP, DOWN = range(2)
NEIGHBOR, ROUNDED, EXACT = range(3)
DERIVE, NORMALIZE, KEEP = range(3)
OK, ERR_ARGUMENT, ERR_SHAPE, ERR_FORMAT, ERR_OVERLAP, ERR_SCRATCH, ERR_CANCELLED = range(7)
ERR_NOT_CONVERGED = 7

PASS_NEIGHBOR, PASS_ROUNDED, PASS_EXACT = 1, 2, 4
XY_TOO_LONG, Z_NEGATIVE, IS_UNUSED, NOT_FINITE = 8, 16, 32, 64
UNUSED_BLACK, UNUSED_WHITE, UNUSED_TRANSPARENT, UNUSED_ALL = 1, 2, 4, 7

_TYPES = {"uint8": U8, "uint16": U16, "float32": F32}


def cdef_text(header=HEADER):
    """The declarations of libntp.h without the export macro."""
    text = Path(header).read_text(encoding="utf-8")
    begin = text.index("cdef begin")
    begin = text.index("\n", begin)
    end = text.index("/* --- cdef end")
    return text[begin:end].replace("NTP_API ", "")


def find_built(name):
    """A file of the build that is tested, by its path in there; None if it was not built."""
    return BUILD / name if (BUILD / name).is_file() else None


ffi = cffi.FFI()
ffi.cdef(cdef_text())
_path = find_built("libntp/libntp.so")
lib = ffi.dlopen(str(_path)) if _path else None


class NtpError(Exception):
    """A status other than NTP_OK."""

    def __init__(self, status):
        super().__init__(ffi.string(lib.ntp_status_string(status)).decode())
        self.status = status


def check(status):
    """Raises NtpError unless status is NTP_OK."""
    if status != OK:
        raise NtpError(status)


def view(array, encoding=STANDARD, y=UP, const=False, ring_rows=0, height=None, **fields):
    """An ntp_image of a (h, w) or (h, w, c) array: no copy, the caller keeps the array alive."""
    if array.ndim == 2:
        array = array[:, :, None]
    h, w, channels = array.shape
    if channels > 1:
        assert array.strides[2] == array.itemsize, "samples of a pixel must be adjacent"
    image = ffi.new("ntp_const_image *" if const else "ntp_image *")
    image.data = ffi.cast("void *", array.__array_interface__["data"][0])
    image.row_stride, image.pixel_stride = array.strides[0], array.strides[1]
    image.width, image.height, image.channels = w, height or h, channels
    image.ring_rows = ring_rows
    image.type = _TYPES[array.dtype.name]
    image.encoding, image.y = encoding, y
    for name, value in fields.items():
        setattr(image, name, value)
    return image


def rect(area):
    """(x0, y0, x1, y1) or None as ntp_rect *."""
    return ffi.NULL if area is None else ffi.new("ntp_rect *", list(area))


def fields(struct):
    """A struct as a dict of Python values, nested structs and arrays included."""

    def plain(value):
        if not isinstance(value, ffi.CData):
            return value
        kind = ffi.typeof(value)
        if kind.kind == "array":
            return [plain(v) for v in value]
        return {name: plain(getattr(value, name)) for name, _ in kind.fields}

    return plain(struct[0] if ffi.typeof(struct).kind == "pointer" else struct)


def validate(array, encoding=STANDARD, keep=0, area=None):
    """The flags of each texel as an (h, w) uint8 array."""
    mask = np.zeros(array.shape[:2], np.uint8)
    src = view(array, encoding, const=True)
    check(lib.ntp_validate(view(mask, HEIGHT), src, keep, rect(area)))
    return mask


def clean_options(
    method=DERIVE, keep=0, only_failing=0, verdict=NEIGHBOR, touch_unused=0
):  # the order of the struct
    return ffi.new("ntp_clean_options *", [method, keep, only_failing, verdict, touch_unused])


def aligned(size, alignment=16):
    """Zeroed memory at a multiple of `alignment`, as a numpy array that owns it."""
    raw = np.zeros(size + alignment, np.uint8)
    start = -raw.__array_interface__["data"][0] % alignment
    return raw[start : start + size]


def clean_plan(encoding, how):
    """(plan pointer, its memory: keep it alive)."""
    size = lib.ntp_clean_plan_size()
    memory = aligned(size)
    plan = ffi.new("ntp_clean_plan **")
    where = ffi.cast("void *", memory.__array_interface__["data"][0])
    check(lib.ntp_clean_plan_init(plan, where, size, encoding, how))
    return plan[0], memory


def clean(src, encoding=STANDARD, how=None, plan=None, dst=None, area=None, y=UP):
    """(cleaned array, changed, not_finite)."""
    dst = src.copy() if dst is None else dst
    counts = ffi.new("ntp_clean_counts *")
    check(
        lib.ntp_clean(
            view(dst, encoding, y),
            view(src, encoding, y, const=True),
            ffi.NULL if how is None else how,
            ffi.NULL if plan is None else plan,
            counts,
            rect(area),
        )
    )
    return dst, counts.changed, counts.not_finite


def convert(
    src,
    dst,
    src_encoding=STANDARD,
    encoding=STANDARD,
    src_y=UP,
    y=UP,
    how=None,
    area=None,
):
    """Fills dst; returns (z_negative, not_finite, pulled)."""
    counts = ffi.new("ntp_convert_counts *")
    options = ffi.NULL if how is None else ffi.new("ntp_convert_options *", list(how))
    check(
        lib.ntp_convert(
            view(dst, encoding, y),
            view(src, src_encoding, src_y, const=True),
            options,
            counts,
            rect(area),
        )
    )
    return counts.z_negative, counts.not_finite, counts.pulled


class Tally:
    """An ntp_tally with its memory."""

    def __init__(self):
        self.memory = aligned(lib.ntp_tally_size())
        pointer = ffi.cast("ntp_tally *", self.memory.__array_interface__["data"][0])
        # The memory lives as long as the pointer, which may outlive this.
        self.pointer = ffi.gc(pointer, lambda _, memory=self.memory: None)

    def measure(self, array, encoding=STANDARD, touch_unused=0, area=None):
        src = view(array, encoding, const=True)
        check(lib.ntp_tally_add(self.pointer, src, touch_unused, rect(area)))
        return self

    def merge(self, other):
        check(lib.ntp_tally_merge(self.pointer, other.pointer))
        return self

    def stats(self, encoding=STANDARD):
        stats = ffi.new("ntp_stats *")
        check(lib.ntp_tally_summarize(stats, self.pointer, encoding))
        return fields(stats)

    def levels_off(self, encoding=STANDARD, size=65536):
        counts = np.zeros(size, np.uint64)
        where = ffi.cast("uint64_t *", counts.__array_interface__["data"][0])
        check(lib.ntp_tally_levels_off(where, size, self.pointer, encoding))
        return counts

    def harm(self, encoding=STANDARD, kinds=7, degrees=5.0):
        harm = ffi.new("ntp_harm *")
        check(lib.ntp_tally_harm(harm, self.pointer, encoding, kinds, degrees))
        return fields(harm)

    def lengths(self, encoding=STANDARD):
        counts = np.zeros(256, np.uint64)
        where = ffi.cast("uint64_t *", counts.__array_interface__["data"][0])
        check(lib.ntp_tally_lengths(where, self.pointer, encoding))
        return counts


def tally_of(pixels, encoding):
    """What is measured of an array that is declared so."""
    return Tally().measure(np.ascontiguousarray(pixels), encoding)


def classify(pixels, encoding):
    result = ffi.new("ntp_classification *")
    check(lib.ntp_classify(result, tally_of(pixels, encoding).pointer))
    return result


def find_steps(array, encoding=STANDARD, touch=0):
    steps = ffi.new("ntp_steps *")
    check(lib.ntp_find_steps(steps, view(array, encoding, const=True), touch))
    return fields(steps)


def public_functions():
    """The names that libntp.h declares."""
    text = re.sub(r"/\*.*?\*/", "", cdef_text(), flags=re.DOTALL)
    return set(re.findall(r"\b(ntp_\w+)\s*\(", text))
