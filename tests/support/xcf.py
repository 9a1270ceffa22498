# SPDX-License-Identifier: MIT
"""Reads the first layer of an XCF file, GIMP's own format: its samples as they are stored."""

import struct
import zlib

import numpy as np

TILE = 64
COMPRESSION, RLE, ZLIB = 17, 1, 2  # a property of the image, and values of it
# The precisions of images: hundreds are types, whatever the curve is.
TYPES = {1: ">u1", 2: ">u2", 3: ">u4", 5: ">f2", 6: ">f4", 7: ">f8"}


def unpack_runs(data, size):
    """One byte plane after the other is run-length encoded; this is about one of them."""
    out, at = bytearray(), 0
    while len(out) < size:
        code, at = data[at], at + 1
        literal = code >= 128
        count = 256 - code if literal else code + 1
        if count == 128:
            count, at = int.from_bytes(data[at : at + 2], "big"), at + 2
        if literal:
            out += data[at : at + count]
            at += count
        else:
            out += data[at : at + 1] * count
            at += 1
    return bytes(out), data[at:]


class Xcf:
    def __init__(self, data):
        self.data = data
        self.at = 14
        version = data[9:13].decode()
        self.version = int(version[1:]) if version.startswith("v") else 0
        _, _, _, precision = self.words(4)
        self.dtype = np.dtype(TYPES[precision // 100])
        compression = self.properties().get(COMPRESSION)
        self.compression = compression[0] if compression else RLE
        (self.layer,) = self.pointers(1)

    def words(self, count):
        self.at += 4 * count
        return struct.unpack(f">{count}I", self.data[self.at - 4 * count : self.at])

    def pointers(self, count):
        size = 8 if self.version >= 11 else 4
        self.at += size * count
        text = self.data[self.at - size * count : self.at]
        return struct.unpack(f">{count}{'Q' if size == 8 else 'I'}", text)

    def properties(self):
        found = {}
        while True:
            kind, size = self.words(2)
            if kind == 0:
                return found
            found[kind] = self.data[self.at : self.at + size]
            self.at += size

    def tile(self, offset, width, height, bpp):
        size = width * height
        data = self.data[offset : offset + 2 * size * bpp + 1000]
        if self.compression == ZLIB:
            return np.frombuffer(zlib.decompressobj().decompress(data), np.uint8).reshape(size, bpp)
        planes = []
        for _ in range(bpp):
            plane, data = unpack_runs(data, size)
            planes.append(np.frombuffer(plane, np.uint8))
        return np.stack(planes, 1)

    def pixels(self):
        self.at = self.layer
        width, height, _ = self.words(3)
        (length,) = self.words(1)
        self.at += length
        self.properties()
        (self.at,) = self.pointers(1)  # the hierarchy
        _, _, bpp = self.words(3)
        (self.at,) = self.pointers(1)  # its first level
        self.words(2)
        out = np.zeros((height, width, bpp), np.uint8)
        for y in range(0, height, TILE):
            for x in range(0, width, TILE):
                w, h = min(TILE, width - x), min(TILE, height - y)
                tile = self.tile(self.pointers(1)[0], w, h, bpp)
                out[y : y + h, x : x + w] = tile.reshape(h, w, bpp)
        return out.view(self.dtype).astype(self.dtype.newbyteorder("="))


def read_xcf(path):
    """The samples of the first layer: height x width x channels, in their own type."""
    return Xcf(path.read_bytes()).pixels()
