# SPDX-License-Identifier: MIT
"""Brings an image of a glTF file into a form that ntp reads."""

import re
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .. import _files, _ntp
from .._errors import FileError, FileStatus
from . import _ktx2
from ._walk import NormalImage

Json = dict[str, Any]

_SIGNATURES = [
    (b"\x89PNG\r\n\x1a\n", "image/png", ".png"),
    (b"\xff\xd8\xff", "image/jpeg", ".jpg"),
    (_ktx2.SIGNATURE, "image/ktx2", ".ktx2"),
    (b"DDS ", "image/vnd-ms.dds", ".dds"),
]
_OF_GPUS = ("image/ktx2", "image/vnd-ms.dds")
READ_BY_NTP = {"image/png", "image/jpeg", *_OF_GPUS}
_UNSAFE = re.compile(r"[^A-Za-z0-9._-]+")
_DDS_FORMAT, _DDS_TEXELS = 128, 148  # where they stand behind the header of DirectX 10
_B8G8R8X8 = 88
MAX_TEXELS = 1 << 28  # of Basis Universal, which is unpacked whole: 1 GiB

# The layouts that Python's reader returns with two channels, such as BC5.
_NO_BLUE = (
    "{layout} holds no z; glTF 2.0 (3.9.3) reads z from blue, and packed normals are not part of it"
)


@dataclass
class Extracted:
    """An image as a file, or why there is none; `xy`: it holds x and y alone."""

    path: Path | None = None
    why_not: str = ""
    xy: bool = False
    findings: list[Json] = field(default_factory=list)


def media_type(data: bytes) -> tuple[str, str]:
    """(media type, suffix) of an image by its first bytes; ("", "") when unknown."""
    for signature, mime, suffix in _SIGNATURES:
        if data.startswith(signature):
            return mime, suffix
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return "image/webp", ".webp"
    if data[4:12] in (b"ftypavif", b"ftypavis"):
        return "image/avif", ".avif"
    return "", ""


def safe_name(image: NormalImage, suffix: str) -> str:
    """A file name for an image: what its own name says (such as _DX) stays readable."""
    stem = _UNSAFE.sub("_", Path(image.name).stem).strip("._-")[:60]
    return f"{image.index}_{stem or 'image'}{suffix}"


def _read_by_program(mime: str) -> bool:
    codecs = _ntp.tool_fields()["codecs"].lower()
    return mime in READ_BY_NTP or (mime == "image/webp" and "webp" in codecs)


def _of_gpu(data: bytes, path: Path) -> Extracted:
    """A DDS or KTX2 of plain samples or blocks, which the program reads itself."""
    try:
        info = _files.read_info(data)
    except FileError as error:
        if error.status in (FileStatus.FORMAT, FileStatus.USAGE):
            return Extracted(why_not=str(error).removeprefix("<bytes>: "))
        path.write_bytes(data)  # damaged: the program says how
        return Extracted(path)
    path.write_bytes(data)
    if not info.red_green:
        return Extracted(path)
    message = _NO_BLUE.format(layout=info.layout)
    told = {"id": "NT065", "level": "error", "message": message, "count": 0}
    return Extracted(path, xy=True, findings=[told])


def _basis_pixels(data: bytes, ktx: _ktx2.Ktx2) -> Any:
    """(height, width, 3) of uint8: what glTF reads, or x, y and 255 of a packed layout."""
    import opengl_basisu

    texture = opengl_basisu.open(data)
    rgba = np.asarray(texture.transcode("rgba8", level=0).data, np.uint8)
    rgba = rgba.reshape(ktx.height, ktx.width, 4)
    if ktx.layout not in ("RRRG", "RG", "R"):
        return np.ascontiguousarray(rgba[..., :3])
    second = {"RRRG": 3, "RG": 1, "R": 0}[ktx.layout]
    flat = np.full(rgba.shape[:2], 255, np.uint8)
    return np.dstack([rgba[..., 0], rgba[..., second], flat])


def _of_basis(data: bytes, path: Path, ktx: _ktx2.Ktx2) -> Extracted:
    xy = ktx.layout in ("RRRG", "RG", "R")
    size = f"{ktx.name}, {ktx.width} x {ktx.height}"
    if not 0 < ktx.width * ktx.height <= MAX_TEXELS:
        return Extracted(why_not=f"{size}: too large to be unpacked", xy=xy)
    try:
        pixels = _basis_pixels(data, ktx)
    except ImportError:
        why = f"{size}: pip install 'normaltexture[basisu]' reads its pixels"
        return Extracted(why_not=why, xy=xy)
    except (ValueError, RuntimeError, IndexError, MemoryError) as error:
        return Extracted(why_not=f"{size}: {error or type(error).__name__}", xy=xy)
    path = path.with_suffix(".png")
    _files.write(path, pixels)
    return Extracted(path, xy=xy)


def _by_libraries(data: bytes, path: Path, mime: str) -> Extracted:
    try:
        from ..images import decode_to_png

        path = path.with_suffix(".png")
        path.write_bytes(decode_to_png(data, mime))
    except ImportError as error:
        return Extracted(why_not=f"{mime} is not read: {error}")
    except ValueError as error:
        return Extracted(why_not=f"{mime} could not be read: {error}")
    return Extracted(path)


def extract(image: NormalImage, data: bytes, folder: Path) -> Extracted:
    """Writes an image to a folder in a form that ntp reads."""
    mime, suffix = media_type(data)
    path = folder / safe_name(image, suffix or ".bin")
    ktx = _ktx2.parse(data)
    if ktx is not None and ktx.is_basis:
        made = _of_basis(data, path, ktx)
    elif mime in _OF_GPUS:
        made = _of_gpu(data, path)
    elif mime and not _read_by_program(mime):
        made = _by_libraries(data, path, mime)
    else:
        path.write_bytes(data)  # ntp says itself what is wrong with an unknown format
        made = Extracted(path)
    if ktx is not None:
        made.findings += _ktx2.findings(ktx)
    return made


def is_plain_dds(data: bytes) -> bool:
    """A DDS of one RGB or RGBA texture of 8 bits, not in blocks: it is written again as such."""
    if not data.startswith(b"DDS "):
        return False
    try:
        info = _files.read_info(data)
    except FileError:
        return False
    other = info.layout.startswith("BC") or "SNORM" in info.layout
    return info.layers <= 1 and info.bit_depth == 8 and info.channels >= 3 and not other


def plain_dds(png: bytes) -> bytes:
    """A PNG of 8 bits as a DDS of the same numbers, with all mips; RGB as B8G8R8X8."""
    pixels = _files.read(png)
    with tempfile.TemporaryDirectory(prefix="ntp-dds-") as scratch:
        path = Path(scratch) / "image.dds"
        _files.write(path, pixels, compression="none", mips=True, type="standard")
        data = bytearray(path.read_bytes())
    if pixels.shape[2] == 3:
        texels = np.frombuffer(data, np.uint8, offset=_DDS_TEXELS).reshape(-1, 4)
        texels[:, :3] = texels[:, 2::-1]
        data[_DDS_FORMAT] = _B8G8R8X8
    return bytes(data)


def _webp_by_pillow(pixels: Any, path: Path) -> bool:
    try:
        from PIL import Image

        Image.fromarray(pixels).save(path, "WEBP", lossless=True, exact=True)
        with Image.open(path) as again:
            return np.array_equal(np.asarray(again.convert("RGB")), pixels)
    except (ImportError, OSError, KeyError, TypeError, ValueError):
        return False


def lossless_webp(png: bytes) -> bytes | None:
    """A PNG as a WebP with the same numbers; None where neither library is there."""
    pixels = _files.read(png)
    with tempfile.TemporaryDirectory(prefix="ntp-webp-") as scratch:
        path = Path(scratch) / "image.webp"
        try:
            _files.write(path, pixels)
        except (FileError, ValueError, TypeError):
            if not _webp_by_pillow(pixels, path):
                return None
        return path.read_bytes()
