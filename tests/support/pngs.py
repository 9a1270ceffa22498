# SPDX-License-Identifier: MIT
"""PNG and TGA files written by hand, and PNG read back, for tests.

The writers give the same bytes on every machine: pixel data are stored, not compressed, since
compressors differ between versions.  The reader knows just what tests need: 8 and 16 bit gray,
RGB and RGBA without interlacing, with the raw sample values.
"""

import struct
import zlib

import numpy as np

try:
    from PIL import Image
except ImportError:  # inside GIMP
    Image = None

SIGNATURE = b"\x89PNG\r\n\x1a\n"
_COLOR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}
_ADAM7 = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2)]
_ADAM7 += [(0, 1, 1, 2)]  # x0, y0, dx, dy


def chunk(kind, data=b""):
    """One PNG chunk with its checksum."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def stored(data):
    """A zlib stream of stored blocks."""
    blocks = [data[i : i + 65535] for i in range(0, len(data), 65535)] or [b""]
    out = b"\x78\x01"
    for i, block in enumerate(blocks):
        last = i == len(blocks) - 1
        out += struct.pack("<BHH", last, len(block), len(block) ^ 0xFFFF) + block
    return out + struct.pack(">I", zlib.adler32(data))


def _rows(pixels, depth):
    """Filter byte 0 and the packed samples of each row."""
    if depth == 16:
        return b"".join(b"\0" + row.astype(">u2").tobytes() for row in pixels)
    if depth == 8:
        return b"".join(b"\0" + row.astype(np.uint8).tobytes() for row in pixels)
    out = b""
    for row in pixels.reshape(len(pixels), -1):
        bits = ((row[:, None] >> np.arange(depth - 1, -1, -1)) & 1).astype(np.uint8)
        out += b"\0" + np.packbits(bits).tobytes()
    return out


def png_bytes(pixels, depth=None, palette=None, trns=None, interlaced=False, chunks=()):
    """A PNG of an (h, w) or (h, w, c) integer array.

    depth: bits of a sample, by default those of the dtype.  palette: (n, 3) colors, pixels are
    indices then.  trns: bytes of the tRNS chunk.  chunks: (kind, data) pairs before the pixels.
    """
    pixels = np.asarray(pixels)
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    h, w, channels = pixels.shape
    depth = depth or pixels.dtype.itemsize * 8
    color_type = 3 if palette is not None else _COLOR_TYPES[channels]
    out = SIGNATURE
    out += chunk(b"IHDR", struct.pack(">IIBBBBB", w, h, depth, color_type, 0, 0, interlaced))
    for kind, data in chunks:
        out += chunk(kind, data)
    if palette is not None:
        out += chunk(b"PLTE", np.asarray(palette, np.uint8).tobytes())
    if trns is not None:
        out += chunk(b"tRNS", trns)
    data = b""
    for x, y, dx, dy in _ADAM7 if interlaced else [(0, 0, 1, 1)]:
        part = pixels[y::dy, x::dx]
        if part.size:
            data += _rows(part, depth)
    return out + chunk(b"IDAT", stored(data)) + chunk(b"IEND")


def write_png(path, pixels, **options):
    """png_bytes into a file."""
    with open(path, "wb") as file:
        file.write(png_bytes(pixels, **options))


def _unfilter(kind, row, above, step):
    if kind == 2:
        both = np.frombuffer(row, np.uint8) + np.frombuffer(above, np.uint8)
        return both.tobytes()
    out = bytearray(step) + row  # with a pixel of zeros to the left
    above = bytes(step) + bytes(above)
    if kind == 1:
        for i in range(step, len(out)):
            out[i] = (out[i] + out[i - step]) & 255
    elif kind == 3:
        for i in range(step, len(out)):
            out[i] = (out[i] + (out[i - step] + above[i]) // 2) & 255
    elif kind == 4:
        for i in range(step, len(out)):
            left, up, corner = out[i - step], above[i], above[i - step]
            to_left, to_up = abs(up - corner), abs(left - corner)
            to_corner = abs(left + up - 2 * corner)
            if to_left <= to_up and to_left <= to_corner:
                out[i] = (out[i] + left) & 255
            elif to_up <= to_corner:
                out[i] = (out[i] + up) & 255
            else:
                out[i] = (out[i] + corner) & 255
    return bytes(out[step:])


def unfiltered(data, h, w, step):
    """The bytes of h rows of w texels, from a zlib stream of filtered rows."""
    raw, above, rows = zlib.decompress(data), bytes(w * step), []
    for y in range(h):
        start = y * (w * step + 1)
        row = raw[start + 1 : start + 1 + w * step]
        above = _unfilter(raw[start], row, above, step) if raw[start] else row
        rows.append(bytes(above))
    return b"".join(rows)


def unfiltered_by_pillow(data, h, w, step):
    """The same, many times faster.  Of two bytes a sample Pillow keeps one, so it is asked twice."""
    mode = {1: "L", 2: "LA", 3: "RGB", 4: "RGBA", 6: "RGB", 8: "RGBA"}[step]
    kept = [""] if step <= 4 else [";16B", ";16L"]
    parts = [Image.frombytes(mode, (w, h), data, "zip", mode + which).tobytes() for which in kept]
    return np.stack([np.frombuffer(part, np.uint8) for part in parts], -1).tobytes()


def read_png(path):
    """(pixels as (h, w, c), {chunk kind: [data, ...]}) of a PNG that the program wrote."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:8] == SIGNATURE
    chunks, position = {}, 8
    while position < len(data):
        size, kind = struct.unpack_from(">I4s", data, position)
        body = data[position + 8 : position + 8 + size]
        (crc,) = struct.unpack_from(">I", data, position + 8 + size)
        assert crc == zlib.crc32(kind + body), kind
        chunks.setdefault(kind, []).append(body)
        position += 12 + size
    w, h, depth, color_type, _, _, interlaced = struct.unpack(">IIBBBBB", chunks[b"IHDR"][0])
    assert depth in (8, 16) and not interlaced and color_type != 3
    channels = {0: 1, 4: 2, 2: 3, 6: 4}[color_type]
    data = b"".join(chunks[b"IDAT"])
    assert len(zlib.decompress(data)) == h * (1 + w * channels * depth // 8)
    unfilter = unfiltered_by_pillow if Image else unfiltered
    samples = unfilter(data, h, w, channels * depth // 8)
    pixels = np.frombuffer(samples, ">u2" if depth == 16 else np.uint8)
    return pixels.astype(np.uint16 if depth == 16 else np.uint8).reshape(h, w, channels), chunks


def _run_lengths(row):
    """TGA RLE packets of one row of pixels (a list of bytes objects)."""
    out, i = b"", 0
    while i < len(row):
        run = 1
        while i + run < len(row) and run < 128 and row[i + run] == row[i]:
            run += 1
        if run > 1:
            out += bytes([127 + run]) + row[i]
            i += run
            continue
        start = i
        while i < len(row) and i - start < 128 and (i + 1 == len(row) or row[i] != row[i + 1]):
            i += 1
        out += bytes([i - start - 1]) + b"".join(row[start:i])
    return out


def tga_bytes(pixels, rle=False, origin="bottom-left", palette=None):
    """A TGA of (h, w), (h, w, 3) or (h, w, 4) bytes; with a palette (n, 3), pixels are indices."""
    pixels = np.asarray(pixels, np.uint8)
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    h, w, channels = pixels.shape
    if "bottom" in origin:
        pixels = pixels[::-1]
    if "right" in origin:
        pixels = pixels[:, ::-1]
    if channels >= 3:  # stored as BGR(A)
        pixels = pixels[..., [2, 1, 0, 3][:channels]]
    kind = {1: 3, 3: 2, 4: 2}[channels] if palette is None else 1
    descriptor = (8 if channels == 4 else 0) | ("right" in origin) << 4 | ("top" in origin) << 5
    colors = b"" if palette is None else np.asarray(palette, np.uint8)[:, ::-1].tobytes()
    entries = len(colors) // 3
    header = struct.pack(
        "<BBBHHB", 0, palette is not None, kind + 8 * rle, 0, entries, 24 * bool(entries)
    )
    header += struct.pack("<HHHHBB", 0, 0, w, h, channels * 8, descriptor)
    if rle:
        body = b"".join(_run_lengths([p.tobytes() for p in row]) for row in pixels)
    else:
        body = pixels.tobytes()
    return header + colors + body
