# SPDX-License-Identifier: MIT
"""Images in other formats that artists use: WebP, TIFF, EXR, AVIF.

They are read by well-known libraries, which the extra installs: ``pip install
'normaltexture[images]'``.  The result is what the file stores: numbers, without color management,
gamma or premultiplication.  PNG, TGA, JPEG, PFM, DDS and KTX2 are read by the package itself, as are
WebP and EXR where it was built with libwebp and OpenEXR (`normaltexture.codecs`).
"""

import importlib
import io
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._files import read as _read_ours
from ._files import write as _write_ours
from ._names import FILE_FORMATS
from ._native import lib
from .typing import AnyPixels

Pixels: TypeAlias = NDArray[Any]

_KEPT = (np.uint8, np.uint16, np.float32)


class MissingLibraryError(ImportError):
    """A library of the extra ``normaltexture[images]`` is not installed."""


def _library(name: str, purpose: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise MissingLibraryError(
            f"{purpose} needs {name.partition('.')[0]}: pip install 'normaltexture[images]'"
        ) from error


def media_type(data: bytes) -> str:
    """The media type of a file by its first bytes; "" when it is none of those read here."""
    if data[:4] in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"):
        return "image/tiff"
    if data[:4] == b"v/1\x01":
        return "image/x-exr"
    if data[:4] == b"DDS ":
        return "image/vnd-ms.dds"
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return "image/webp"
    if data[4:12] in (b"ftypavif", b"ftypavis"):
        return "image/avif"
    return ""


def _kept(image: Pixels, what: str) -> Pixels:
    """One of the types that the package works on, its shape one of an image."""
    if image.dtype in (np.float16, np.float64):
        image = image.astype(np.float32)
    if image.dtype not in _KEPT:
        image = image.astype(image.dtype.newbyteorder("="))
    if image.dtype not in _KEPT:
        raise ValueError(f"{what} has samples of {image.dtype}; uint8, uint16 and float32 are read")
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[..., 0]
    if image.ndim not in (2, 3) or (image.ndim == 3 and not 2 <= image.shape[2] <= 4):
        raise ValueError(f"{what} has the shape {image.shape}, which is no image")
    return np.ascontiguousarray(image)


def _read_tiff(data: bytes) -> Pixels:
    tifffile = _library("tifffile", "TIFF")
    with tifffile.TiffFile(io.BytesIO(data)) as file:
        page = file.pages[0]
        image = np.asarray(page.asarray())
        if image.ndim == 3 and int(page.planarconfig) == 2:  # a plane for each channel
            image = np.moveaxis(image, 0, -1)
        if int(page.photometric) == 0 and image.dtype.kind == "u":  # white is 0
            image = np.iinfo(image.dtype).max - image
    return _kept(image, "the TIFF")


def _read_exr(data: bytes) -> Pixels:
    openexr = _library("OpenEXR", "EXR")
    with tempfile.TemporaryDirectory(prefix="ntp-exr-") as folder:
        path = Path(folder) / "image.exr"  # the library reads files only
        path.write_bytes(data)
        with openexr.File(str(path), separate_channels=True) as file:
            channels = {name: np.array(c.pixels) for name, c in file.channels().items()}
    for names in (("R", "G", "B", "A"), ("R", "G", "B"), ("X", "Y", "Z"), ("R", "G"), ("Y",)):
        if set(names) <= set(channels):
            return _kept(np.dstack([channels[name] for name in names]), "the EXR")
    raise ValueError(f"the EXR has the channels {sorted(channels)}, not R, G, B")


def _read_by_pillow(data: bytes) -> Pixels:
    pillow = _library("PIL.Image", "WebP and AVIF")
    try:
        with pillow.open(io.BytesIO(data), formats=["WEBP", "AVIF"]) as image:
            if image.mode not in ("L", "LA", "RGB", "RGBA"):
                image = image.convert("RGBA" if "A" in image.mode else "RGB")
            pixels = np.array(image)
    except (OSError, SyntaxError, NotImplementedError) as error:
        raise ValueError(str(error) or type(error).__name__) from None
    return _kept(pixels, "the image")


_READERS: dict[str, Callable[[bytes], Pixels]] = {
    "image/tiff": _read_tiff,
    "image/x-exr": _read_ours if lib.ntpio_reads(FILE_FORMATS["exr"]) else _read_exr,
    "image/vnd-ms.dds": _read_ours,
    "image/webp": _read_ours if lib.ntpio_reads(FILE_FORMATS["webp"]) else _read_by_pillow,
    "image/avif": _read_by_pillow,
}


def read(file: str | os.PathLike[str] | bytes) -> AnyPixels:
    """Reads an image of any supported format.

    Parameters
    ----------
    file
        A path, or the bytes of a file.

    Returns
    -------
    array, (height, width) or (height, width, 2 to 4); uint8, uint16 or float32
        What the file stores.  BC5 has two channels of 16 bits: ``type="xy"``.  EXR holds floats,
        normals in them either -1..1 (``type="vector"``) or 0..1.

    Raises
    ------
    MissingLibraryError
        The library for this format is not installed.
    ValueError
        The file is damaged, or of an unsupported kind.

    Examples
    --------
    >>> from normaltexture import images
    >>> images.read("wall_n.png").shape
    (64, 96, 3)
    """
    data = bytes(file) if isinstance(file, bytes | bytearray | memoryview) else b""
    if not data:
        with open(file, "rb") as opened:
            head = opened.read(32)
            if media_type(head):
                data = head + opened.read()
    reader = _READERS.get(media_type(data))
    if reader is None:
        return _read_ours(file)
    try:
        return reader(data)
    except (MissingLibraryError, ValueError):
        raise
    except Exception as error:  # each library has its own for a damaged file
        raise ValueError(f"{media_type(data)}: {error or type(error).__name__}") from error


def decode_to_png(data: bytes, mime: str) -> bytes:
    """An image of another format as the bytes of a PNG with the same samples.

    Parameters
    ----------
    data
        The content of a file.
    mime
        Its media type, such as "image/webp".

    Returns
    -------
    bytes
        Two channels become three, blue being 0.

    Raises
    ------
    MissingLibraryError
        The library for this format is not installed.
    ValueError
        The image is damaged, or its samples do not fit into a PNG.
    """
    if media_type(data) != mime or mime not in _READERS:
        raise ValueError(f"the image is no {mime}")
    pixels = read(data)
    if pixels.dtype.kind == "f":
        raise ValueError("a PNG holds no floats")
    if pixels.ndim == 3 and pixels.shape[2] == 2:  # a PNG would take the second for alpha
        pixels = np.dstack([pixels, np.zeros_like(pixels[..., :1])])
    with tempfile.TemporaryDirectory(prefix="ntp-png-") as folder:
        path = Path(folder) / "image.png"
        _write_ours(path, pixels)
        return path.read_bytes()


__all__ = ["MissingLibraryError", "decode_to_png", "media_type", "read"]
