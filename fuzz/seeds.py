# SPDX-License-Identifier: MIT
"""Writes a small corpus of every format for the fuzzer to start from: seeds.py DIRECTORY"""

import struct
import sys
import zlib
from pathlib import Path


def chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def png(depth, kind, lace, extra=b""):
    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[kind]
    row = bytes(1) + bytes((i * 37) & 255 for i in range((8 * channels * depth + 7) // 8))
    palette = bytes(range(3 << depth)) if kind == 3 and depth < 8 else b""
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", 8, 8, depth, kind, 0, 0, lace))
        + (chunk(b"PLTE", palette) if palette else b"")
        + extra
        + chunk(b"IDAT", zlib.compress(row * (8 if not lace else 24)))
        + chunk(b"IEND", b"")
    )


def tga(kind, bits, descriptor):
    head = struct.pack(
        "<BBBHHBHHHHBB",
        0,
        kind & 7 == 1,
        kind,
        0,
        4 if kind & 7 == 1 else 0,
        bits if kind & 7 == 1 else 0,
        0,
        0,
        4,
        4,
        8 if kind & 7 == 1 else bits,
        descriptor,
    )
    return head + bytes((i * 29) & (3 if kind & 7 == 1 else 255) for i in range(256))


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    texts = (
        chunk(b"gAMA", struct.pack(">I", 45455))
        + chunk(b"iCCP", b"x\0\0" + zlib.compress(bytes(999)))
        + chunk(b"tEXt", b"Title\0text")
        + chunk(b"zTXt", b"Comment\0\0" + zlib.compress(bytes([65]) * 5000))
        + chunk(b"iTXt", b"Author\0\1\0de\0Autor\0" + zlib.compress(b"text"))
        + chunk(b"pHYs", struct.pack(">IIB", 1, 1, 1))
    )
    files = {
        f"png{depth}-{kind}-{lace}": png(depth, kind, lace)
        for depth, kind in ((1, 0), (4, 3), (8, 2), (16, 6), (8, 4), (2, 3))
        for lace in (0, 1)
    }
    files["png-texts"] = png(8, 2, 0, texts)
    files["png-key"] = png(16, 2, 0, chunk(b"tRNS", bytes(6)))
    for kind in (1, 2, 3, 9, 10, 11):
        for bits in (8,) if kind & 7 == 3 else (16, 24, 32):
            for descriptor in (0, 0x18, 0x20, 0x38):
                files[f"tga{kind}-{bits}-{descriptor}"] = tga(kind, bits, descriptor)
    files["pfm"] = b"PF\n2 2\n-1.0\n" + bytes(48)
    files["jpeg"] = b"\xff\xd8\xff\xe0\0\x10JFIF\0\1\1\0\0\1\0\1\0\0"
    for name, data in files.items():
        (folder / name).write_bytes(data)


main()
