# SPDX-License-Identifier: MIT
"""Writes DDS and KTX2 files, byte by byte."""

import struct
import zlib

import numpy as np

BLOCK_BYTES = {"BC1": 8, "BC4": 8}
# FourCC, DXGI format, Vulkan format
NUMBERS = {
    "BC1": (b"DXT1", 71, 131),
    "BC2": (b"DXT3", 74, 135),
    "BC3": (b"DXT5", 77, 137),
    "BC4": (b"ATI1", 80, 139),
    "BC4 SNORM": (b"BC4S", 81, 140),
    "BC5": (b"ATI2", 83, 141),
    "BC5 SNORM": (b"BC5S", 84, 142),
    "BC7": (None, 98, 145),
}


def block_bytes(kind):
    return BLOCK_BYTES.get(kind.split()[0], 16)


def level_sizes(width, height, mips):
    return [(max(width >> m, 1), max(height >> m, 1)) for m in range(mips)]


def dds(width, height, body, four=b"", dxgi=0, masks=(), bits=0, flags=0, mips=1, layers=0, cube=0):
    """A DDS file: `four` a FourCC, or `dxgi` a format of DirectX 10, or `masks` with `bits`.

    `layers` is the size of an array (DirectX 10), `cube` 1 for a cube map.
    """
    code = b"DX10" if dxgi else four
    masks = (*masks, 0, 0, 0, 0)[:4]
    form = struct.pack("<II4s5I", 32, flags | (4 if code else 0x40), code or bytes(4), bits, *masks)
    caps = struct.pack("<IIIII", 0x1000, 0xFE00 if cube else 0, 0, 0, 0)
    head = struct.pack("<7I44x", 124, 0x1007, height, width, 0, 0, mips)
    more = struct.pack("<5I", dxgi, 3, 4 if cube else 0, max(layers, 1), 0) if dxgi else b""
    return b"DDS " + head + form + caps + more + body


def ktx2(
    width, height, levels, vulkan, scheme=0, layers=0, faces=1, transfer=1, model=1, pack=None
):
    """A KTX2 file; `levels` are the bytes of each mip, from the largest; stored smallest first."""
    descriptor = struct.pack("<IIHHBBBB16x", 44, 0, 2, 40, model, 1, transfer, 0) + bytes(16)
    at = 80 + 24 * len(levels)
    packed = [pack(level) if pack else level for level in levels]
    if scheme == 3 and pack is None:
        packed = [zlib.compress(level) for level in levels]
    place, body, offset = [], b"", at + len(descriptor)
    for level, whole in zip(reversed(packed), reversed(levels), strict=True):
        place.append((offset + len(body), len(level), len(whole)))
        body += level
    head = struct.pack("<9I", vulkan, 1, width, height, 0, layers, faces, len(levels), scheme)
    where = struct.pack("<4I2Q", at, len(descriptor), 0, 0, 0, 0)
    index = b"".join(struct.pack("<3Q", *p) for p in reversed(place))
    return b"\xabKTX 20\xbb\r\n\x1a\n" + head + where + index + descriptor + body


# --------------------------------------------------------------------------- simple encoders


def _blocks(channel):
    """(rows, columns, 16) of a channel, its edges repeated."""
    height, width = channel.shape
    channel = np.pad(channel, ((0, -height % 4), (0, -width % 4)), "edge")
    rows, columns = channel.shape[0] // 4, channel.shape[1] // 4
    return channel.reshape(rows, 4, columns, 4).swapaxes(1, 2).reshape(rows, columns, 16)


def bc4_bytes(channel):
    """8-bit levels as (rows, columns, 8) bytes: the ends are the least and greatest level."""
    texels = _blocks(np.asarray(channel).astype(np.int64))
    low, high = texels.min(-1), texels.max(-1)
    span = np.maximum(high - low, 1)[..., None]
    steps = ((high[..., None] - texels) * 14 + span) // (2 * span)  # sevenths below the first end
    index = np.where(steps == 0, 0, np.where(steps == 7, 1, steps + 1))
    index[high == low] = 0
    bits = (index << 3 * np.arange(16)).sum(-1)
    out = np.empty((*low.shape, 8), np.uint8)
    out[..., 0], out[..., 1] = high, low
    for i in range(6):
        out[..., 2 + i] = bits >> 8 * i & 255
    return out


def bc5_bytes(first, second):
    """Two channels of 8-bit levels."""
    return np.concatenate([bc4_bytes(first), bc4_bytes(second)], -1).tobytes()


def dxt5nm_bytes(x, y):
    """BC3 with x in alpha, y in green (its own ends rounded to 6 bits), red and blue 0."""
    texels = _blocks(np.asarray(y).astype(np.int64))
    low, high = texels.min(-1) * 63 // 255, -(-texels.max(-1) * 63 // 255)
    high = np.where(high > low, high, np.minimum(low + 1, 63))
    low = np.where(high > low, low, 62)
    thirds = ((high[..., None] * 255 - texels * 63) * 6 + 255 * (high - low)[..., None]) // (
        2 * 255 * (high - low)[..., None]
    )
    index = np.array([0, 2, 3, 1])[np.clip(thirds, 0, 3)]
    bits = (index << 2 * np.arange(16)).sum(-1)
    out = np.empty((*low.shape, 8), np.uint8)
    for at, end in ((0, high), (2, low)):
        out[..., at], out[..., at + 1] = end << 5 & 255, end >> 3
    for i in range(4):
        out[..., 4 + i] = bits >> 8 * i & 255
    return np.concatenate([bc4_bytes(x), out], -1).tobytes()
