# SPDX-License-Identifier: MIT
"""What the header and the data format descriptor of a KTX2 say, and what glTF asks of them.

Sources: KTX file format 2.0, Khronos data format 1.3, KHR_texture_basisu.
"""

import struct
from dataclasses import dataclass
from typing import Any

SIGNATURE = b"\xabKTX 20\xbb\r\n\x1a\n"
ETC1S, UASTC = 163, 166
TRANSFER_LINEAR, TRANSFER_SRGB = 1, 2
PRIMARIES_UNSPECIFIED = 0
PREMULTIPLIED = 1

_HEADER = struct.Struct("<12x9I4I2Q")
_MODELS = {ETC1S: "ETC1S", UASTC: "UASTC", 162: "ASTC", 160: "ETC1", 161: "ETC2"}
# Which numbers the samples of a descriptor hold: (model, their channels).
_LAYOUTS = {
    (ETC1S, (0,)): "RGB",
    (ETC1S, (0, 15)): "RGBA",
    (ETC1S, (3,)): "R",
    (ETC1S, (3, 4)): "RRRG",
    (UASTC, (0,)): "RGB",
    (UASTC, (3,)): "RGBA",
    (UASTC, (4,)): "R",
    (UASTC, (5,)): "RRRG",
    (UASTC, (6,)): "RG",
}


@dataclass(frozen=True)
class Ktx2:
    """A header.  `layout` is "" where the descriptor is not one of Basis Universal."""

    format: int
    width: int
    height: int
    depth: int
    layers: int
    faces: int
    mips: int
    scheme: int
    model: int
    primaries: int
    transfer: int
    flags: int
    layout: str
    keys: dict[str, str]

    @property
    def is_basis(self) -> bool:
        """Whether it is of Basis Universal, which is unpacked by a library of its own."""
        return self.format == 0 and self.model in (ETC1S, UASTC)

    @property
    def name(self) -> str:
        return _MODELS.get(self.model, "") if self.format == 0 else ""


def _descriptor(data: bytes, start: int, length: int) -> tuple[int, int, int, int, str]:
    """(model, primaries, transfer, flags, layout) of a descriptor; zeros where there is none."""
    block = data[start : start + length]
    if len(block) < 28:
        return 0, 0, 0, 0, ""
    model, primaries, transfer, flags = block[12:16]
    size = struct.unpack_from("<H", block, 10)[0]
    samples = block[28 : 4 + size]
    channels = tuple(samples[at + 3] & 15 for at in range(0, len(samples) - 15, 16))
    return model, primaries, transfer, flags, _LAYOUTS.get((model, channels), "")


def _keys(data: bytes, start: int, length: int) -> dict[str, str]:
    """The texts among the keys and values."""
    found, at, end = {}, start, min(start + length, len(data))
    while at + 4 <= end:
        size = struct.unpack_from("<I", data, at)[0]
        key, _, value = data[at + 4 : min(at + 4 + size, end)].partition(b"\0")
        found[key.decode("utf-8", "replace")] = value.rstrip(b"\0").decode("utf-8", "replace")
        at += 4 + size + -size % 4
    return found


def parse(data: bytes) -> Ktx2 | None:
    """The header of a KTX2; None where it is cut off."""
    if not data.startswith(SIGNATURE) or len(data) < _HEADER.size:
        return None
    header = _HEADER.unpack_from(data)
    number, _, width, height, depth, layers, faces, mips, scheme = header[:9]
    described = _descriptor(data, header[9], header[10])
    keys = _keys(data, header[11], header[12])
    sizes = (width, height, depth, layers, faces, mips)
    return Ktx2(number, *sizes, scheme, *described, keys)


def _said(rule: str, level: str, message: str) -> dict[str, Any]:
    return {"id": rule, "level": level, "message": message, "count": 0}


def _of_descriptor(ktx: Ktx2) -> list[dict[str, Any]]:
    """What is wrong with the color space and the layout of Basis Universal."""
    found = []
    if ktx.transfer == TRANSFER_SRGB:
        message = f"marked sRGB ({ktx.name}): GPUs convert the numbers as they read them"
        found.append(_said("NT045", "error", message))
    elif ktx.transfer != TRANSFER_LINEAR:
        message = f"the descriptor's transfer function is {ktx.transfer}; 1, linear, is required"
        found.append(_said("NT069", "warning", message))
    if ktx.layout in ("RRRG", "RG", "R"):
        message = (
            f"{ktx.name} of the layout {ktx.layout} holds no z; KHR_texture_basisu asks for RGB, "
            "and glTF 2.0 (3.9.3) reads z from blue"
        )
        found.append(_said("NT065", "error", message))
    elif ktx.layout == "RGBA":
        found.append(_said("NT066", "warning", "the image has an alpha channel; nothing reads it"))
    elif not ktx.layout:
        found.append(_said("NT069", "error", f"the descriptor names no layout of {ktx.name}"))
    if ktx.primaries != PRIMARIES_UNSPECIFIED:
        message = f"the descriptor's primaries are {ktx.primaries}; data has 0, unspecified"
        found.append(_said("NT069", "warning", message))
    if ktx.flags & PREMULTIPLIED:
        found.append(_said("NT069", "error", "the descriptor says that alpha is premultiplied"))
    found.append(_said("NT036", "info", f"compressed in blocks of 16 texels, as {ktx.name}"))
    if ktx.mips <= 1 and max(ktx.width, ktx.height) > 1:
        found.append(_said("NT053", "info", "has no mips"))
    return found


def findings(ktx: Ktx2) -> list[dict[str, Any]]:
    """What glTF does not allow, and what a reader of the pixels would not see."""
    found = []
    if ktx.is_basis:
        found += _of_descriptor(ktx)
        wanted = (1,) if ktx.model == ETC1S else (0, 2)
        if ktx.scheme not in wanted:
            message = f"{ktx.name} is packed by scheme {ktx.scheme}, which is not allowed"
            found.append(_said("NT069", "error", message))
    else:
        kind = ktx.name or f"Vulkan's format {ktx.format}"
        message = f"KTX2 of {kind}; KHR_texture_basisu allows ETC1S and UASTC only"
        found.append(_said("NT069", "error", message))
    if ktx.depth or ktx.layers or ktx.faces != 1 or not ktx.height:
        found.append(_said("NT069", "error", "no 2D texture: an array, a cube or a volume"))
    elif ktx.width % 4 or ktx.height % 4:
        message = f"{ktx.width} x {ktx.height}: the sides have to be multiples of 4"
        found.append(_said("NT069", "warning", message))
    for key, allowed in (("KTXswizzle", "rgba"), ("KTXorientation", "rd")):
        if ktx.keys.get(key, allowed) != allowed:
            message = f"{key} is {ktx.keys[key][:20]!r}; only {allowed!r} is allowed"
            found.append(_said("NT069", "error", message))
    return found
