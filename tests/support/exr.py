# SPDX-License-Identifier: MIT
"""Makes EXR files byte by byte: one part, rows or tiles, not packed or packed by RLE or zlib."""

import struct
import zlib

import numpy as np

NONE, RLE, ZIPS, ZIP = range(4)
KINDS = {np.dtype("u4"): 0, np.dtype("f2"): 1, np.dtype("f4"): 2}


def attribute(name: str, kind: str, value: bytes) -> bytes:
    return b"%s\0%s\0%s%s" % (name.encode(), kind.encode(), struct.pack("<i", len(value)), value)


def runs(data: bytes) -> bytes:
    """Run lengths as EXR has them: n and a byte that comes n + 1 times, or -n and n bytes."""
    out, at = b"", 0
    while at < len(data):
        end = at + 1
        while end < len(data) and end - at < 127 and data[end] == data[at]:
            end += 1
        if end - at < 3:
            end = min(at + 3, len(data))
            out += struct.pack("b", at - end) + data[at:end]
        else:
            out += struct.pack("b", end - at - 1) + data[at : at + 1]
        at = end
    return out


def packed(data: bytes, compression: int) -> bytes:
    if compression == NONE:
        return data
    halves = np.frombuffer(data[::2] + data[1::2], np.uint8).astype(np.int64)
    steps = np.diff(halves) + 128 & 0xFF
    smooth = bytes([int(halves[0])]) + steps.astype(np.uint8).tobytes()
    small = runs(smooth) if compression == RLE else zlib.compress(smooth)
    return small if len(small) < len(data) else data


def exr(
    channels: dict[str, np.ndarray],
    *,
    compression: int = NONE,
    tile: int = 0,
    corner: tuple[int, int] = (0, 0),
    sampling: int = 1,
    flags: int = 0,
    header: bytes = b"",
    raw: bytes | None = None,
) -> bytes:
    """A file of these channels, (height, width) each; `corner`: of the data window, x and y;
    `raw`: what each chunk holds instead of its texels."""
    names = sorted(channels)
    height, width = channels[names[0]].shape
    x, y = corner
    window = struct.pack("<4i", x, y, x + width - 1, y + height - 1)
    listed = b"".join(
        b"%s\0" % name.encode()
        + struct.pack("<iB3x2i", KINDS[channels[name].dtype], 0, sampling, sampling)
        for name in names
    )
    head = b"v/1\x01" + struct.pack("<I", 2 | flags | (0x200 if tile else 0)) + header
    for name, kind, value in (
        ("channels", "chlist", listed + b"\0"),
        ("compression", "compression", bytes([compression])),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", struct.pack("<4i", 0, 0, width - 1, height - 1)),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)),
        ("screenWindowCenter", "v2f", bytes(8)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    ):
        head += attribute(name, kind, value)
    if tile:
        head += attribute("tiles", "tiledesc", struct.pack("<2IB", tile, tile, 0))
    head += b"\0"
    chunks = []
    step = tile or (16 if compression == ZIP else 1)
    for top in range(0, height, step):
        for left in range(0, width, tile or width):
            columns = slice(left, left + (tile or width))
            rows = range(top, min(top + step, height))
            data = b"".join(channels[n][row, columns].tobytes() for row in rows for n in names)
            data = packed(data, compression) if raw is None else raw
            place = (left // tile, top // tile, 0, 0) if tile else (y + top,)
            chunks.append(struct.pack(f"<{len(place) + 1}i", *place, len(data)) + data)
    at = len(head) + 8 * len(chunks)
    table = b""
    for chunk in chunks:
        table += struct.pack("<Q", at)
        at += len(chunk)
    return head + table + b"".join(chunks)
