# SPDX-License-Identifier: MIT
"""DDS and KTX2: the mips and blocks that ntpio asks for while it writes one."""

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import choose
from ._blocks import encode_bc4, encode_bc5
from ._errors import ArgumentError
from ._names import BLOCK_QUALITIES, FILE_FORMATS, FILTERS, TOUCH_NONE, TYPES
from ._native import ffi, lib
from ._resize import resized
from ._threads import thread_count
from ._undo import resolve_sound
from .typing import AutoType, BlockQuality, Compression

ENDINGS = {f".{name}": FILE_FORMATS[name] for name in ("dds", "ktx2")}
_COMPRESSIONS = {"blocks": 0, "none": 1}


class TextureOutput:
    """How one array becomes a DDS or KTX2; it lives until the file is complete."""

    def __init__(
        self,
        image: NDArray[Any],
        compression: Compression,
        quality: BlockQuality,
        mips: bool,
        type: AutoType,
        threads: int,
    ) -> None:
        self.raised: BaseException | None = None
        self._image = image
        self._channels = image.shape[2] if image.ndim == 3 else 1
        self._quality: BlockQuality = quality
        self._threads = thread_count(threads)
        self._encoding = -1
        choose("quality", quality, BLOCK_QUALITIES)
        choose("type", type, {**TYPES, "auto": -1})
        if mips and self._channels == 1:
            raise ArgumentError("mips=True: mips are made of normals, the image has one channel")
        if mips:
            if type == "auto":
                type = "xy" if self._channels == 2 else resolve_sound(image, type, threads, "image")
            self._encoding = TYPES[type]
        self._how = ffi.new("ntpio_texture *")
        if not choose("compression", compression, _COMPRESSIONS):
            self._how.blocks = lib.NTPIO_BLOCKS_BC4 if self._channels == 1 else lib.NTPIO_BLOCKS_BC5
        self._how.mips = mips
        self._handle = ffi.new_handle(self)
        self._how.context = self._handle
        self._how.make_mip, self._how.compress = lib.ntp_py_make_mip, lib.ntp_py_compress

    @property
    def how(self) -> Any:
        """The ntpio_texture."""
        return self._how

    def _pixels(self, where: Any, width: int, height: int) -> NDArray[Any]:
        shape = (height, width) if self._channels == 1 else (height, width, self._channels)
        size = width * height * self._channels * self._image.itemsize
        return np.frombuffer(ffi.buffer(where, size), self._image.dtype).reshape(shape)

    def make_mip(self, dst: Any, width: int, height: int) -> None:
        """As `mip_chain`: each mip is made of the whole picture."""
        filtered = ffi.new("ntp_resize_options *", (FILTERS["box"], 0, 0, TOUCH_NONE))
        out = self._pixels(dst, width, height)
        resized(self._image, self._encoding, width, height, filtered, out, self._threads)

    def compress(self, dst: Any, src: Any, width: int, height: int) -> None:
        texels = self._pixels(src, width, height)
        encode = encode_bc4 if self._channels == 1 else encode_bc5
        blocks = encode(texels, quality=self._quality, threads=self._threads)
        ffi.memmove(dst, ffi.from_buffer(blocks), blocks.nbytes)


def texture_output(path: str | os.PathLike[str], ending: str, **how: Any) -> TextureOutput | None:
    """None: the file is of another format, which has no mips."""
    if ending in ENDINGS:
        return TextureOutput(**how)
    if how["mips"]:
        raise ArgumentError(f"mips=True: path={os.fspath(path)!r} must end in .dds or .ktx2")
    return None


def _failed(exception: Any, value: Any, traceback: Any) -> bool:
    """An exception in a callback, Ctrl-C included: it is kept, and ntpio is told to stop."""
    del exception
    output: TextureOutput = ffi.from_handle(traceback.tb_frame.f_locals["context"])
    output.raised = value
    return False


@ffi.def_extern(name="ntp_py_make_mip", onerror=_failed)  # type: ignore[untyped-decorator]
def _make_mip(context: Any, dst: Any, width: int, height: int, whole: Any) -> bool:
    del whole  # the array itself
    ffi.from_handle(context).make_mip(dst, width, height)
    return True


@ffi.def_extern(name="ntp_py_compress", onerror=_failed)  # type: ignore[untyped-decorator]
def _compress(context: Any, dst: Any, src: Any, width: int, height: int) -> bool:
    ffi.from_handle(context).compress(dst, src, width, height)
    return True
