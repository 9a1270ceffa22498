# SPDX-License-Identifier: MIT
"""Writes a seed corpus for fuzz_io: make_corpus.py TEST_FILES DIRECTORY

The small images of test_files, a chip of each, and headers that those do not have.
"""

import io
import shutil
import struct
import sys
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from support import exr
from support.gpu_textures import NUMBERS, block_bytes, dds, ktx2

SUFFIXES = {".png", ".tga", ".jpg", ".pfm", ".dds", ".ktx2"}
LARGEST = 65536


def tga(kind, bits, descriptor, body, map_bits=0, colors=b"", first=0):
    """A TGA of 4 x 2 texels, type `kind`."""
    count = len(colors) // max((map_bits + 7) // 8, 1)
    head = struct.pack("<BBBHHB", 3, bool(colors), kind, first, count, map_bits)
    return head + struct.pack("<HHHHBB", 0, 0, 4, 2, bits, descriptor) + b"id." + colors + body


def pfm(magic, scale, order):
    """A PFM of 2 x 2 texels."""
    count = 4 * (3 if magic == b"PF" else 1)
    floats = struct.pack(order + f"{count}f", *(i / 8 - 1 for i in range(count)))
    return magic + b"\n2 2\n" + scale + b"\n" + floats


def extra():
    """(name, bytes) of what test_files has no example of."""
    texels = bytes(range(32))
    for origin in (0x00, 0x10, 0x20, 0x30):
        for bits in (15, 16, 24, 32):
            size = 8 * ((bits + 7) // 8)
            yield f"color_{bits}_{origin:02x}.tga", tga(2, bits, origin, texels[:size])
        crossing = bytes([0x85]) + texels[:4] + bytes([0x01]) + texels[4:12]
        yield f"run_32_{origin:02x}.tga", tga(10, 32, origin, crossing)
        yield f"gray_{origin:02x}.tga", tga(11, 8, origin, b"\x87\x55")
        yield f"gray_16_{origin:02x}.tga", tga(3, 16, origin, texels[:16])
    for map_bits in (15, 16, 24, 32):
        colors = texels[: 4 * ((map_bits + 7) // 8)]
        indices = bytes([5, 6, 7, 8, 8, 7, 6, 5])
        yield f"palette_{map_bits}.tga", tga(1, 8, 0x20, indices, map_bits, colors, 5)
    yield "palette_run.tga", tga(9, 8, 0x20, b"\x83\x00\x03\x00\x01\x00\x01", 24, texels[:6])
    yield "float_little.pfm", pfm(b"PF", b"-1.0", "<")
    yield "float_big.pfm", pfm(b"Pf", b"1e0", ">")


def gpu_textures():
    """(name, bytes) of each kind of block, of masks and plain samples, of mips and cubes."""
    noise = bytes(i * 167 + i // 5 & 0xFF for i in range(4096))
    for kind, (four, dxgi, vulkan) in NUMBERS.items():
        name = kind.replace(" ", "_").lower()
        blocks = noise[: 4 * block_bytes(kind)]
        yield f"{name}_10.dds", dds(7, 6, blocks, dxgi=dxgi)
        if four:
            yield f"{name}_9.dds", dds(7, 6, blocks, four=four)
        yield f"{name}.ktx2", ktx2(7, 6, [blocks, blocks[: len(blocks) // 4]], vulkan)
    for dxgi, vulkan, size in ((2, 109, 16), (10, 97, 8), (31, 38, 4), (37, 78, 4), (24, 64, 4)):
        yield f"plain_{dxgi}.dds", dds(4, 3, noise[: 12 * size], dxgi=dxgi)
        yield f"plain_{vulkan}.ktx2", ktx2(4, 3, [noise[: 12 * size]], vulkan, scheme=3)
    yield "masks.dds", dds(4, 3, noise[:24], masks=(0x7C00, 0x3E0, 31, 0x8000), bits=16, flags=1)
    yield "signed.dds", dds(4, 3, noise[:24], masks=(0xFF, 0xFF00), bits=16, flags=0x80000)
    yield "cube.dds", dds(4, 4, noise[: 6 * 21], dxgi=61, mips=3, cube=1)
    yield "cube.ktx2", ktx2(4, 4, [noise[:96], noise[:24]], 9, faces=6)
    yield "array.ktx2", ktx2(4, 4, [noise[:48]], 9, layers=3, scheme=3)
    yield "uastc.ktx2", ktx2(4, 4, [noise[:16]], 0, model=166, transfer=2)


def pictures():
    """A small picture of noise and of a ramp, by name."""
    x, y = np.meshgrid(np.arange(19), np.arange(13))
    yield "noise", (x * 167 + y * 59 + x * y) % 256 / 255
    yield "ramp", (x + y) / 32


def floats():
    """(name, bytes) of EXR files: rows and tiles, each packing of ours, several layers."""
    for name, picture in pictures():
        for kind in ("f2", "f4"):
            plane = picture.astype(kind)
            rgb = dict.fromkeys("RGB", plane)
            for packing in (exr.NONE, exr.RLE, exr.ZIPS, exr.ZIP):
                yield f"{name}_{kind}_{packing}.exr", exr.exr(rgb, compression=packing)
            yield f"{name}_{kind}_tiles.exr", exr.exr(rgb, compression=exr.ZIP, tile=8)
    layers = {f"a.Normal.{c}": plane for c in "XYZ"} | {"Z": plane, "b.R": plane, "b.G": plane}
    yield "layers.exr", exr.exr(layers, corner=(-3, 5))
    yield "gray.exr", exr.exr({"Y": plane, "A": plane}, compression=exr.ZIP)
    # The other packings are of noise: their decoders are tried, and refuse it.
    noise = bytes(i * 167 + i // 5 & 0xFF for i in range(300))
    for packing in range(4, 10):
        data = exr.exr({"R": plane, "G": plane, "B": plane}, raw=noise)
        at = data.index(b"compression\0compression\0") + 28
        yield f"packing_{packing}.exr", data[:at] + bytes([packing]) + data[at + 1 :]


def webps():
    """(name, bytes) of WebP: with and without loss and alpha, and with a profile."""
    for name, picture in pictures():
        gray = np.round(picture * 255).astype(np.uint8)
        for mode, planes in (
            ("RGB", [gray, gray.T.reshape(gray.shape), gray]),
            ("RGBA", [gray] * 4),
        ):
            image = Image.fromarray(np.dstack(planes), mode)
            for lossless in (False, True):
                out = io.BytesIO()
                image.save(out, "WEBP", lossless=lossless, icc_profile=b"profile" * (not lossless))
                yield f"{name}_{mode}_{lossless}.webp", out.getvalue()


def main():
    source, target = Path(sys.argv[1]), Path(sys.argv[2])
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    for path in sorted(source.iterdir()):
        if path.suffix in SUFFIXES and path.stat().st_size <= LARGEST:
            data = path.read_bytes()
            (target / path.name).write_bytes(data)
            (target / f"chip_{path.name}").write_bytes(data[: len(data) * 7 // 8])
    for name, data in [*extra(), *gpu_textures(), *floats(), *webps()]:
        (target / name).write_bytes(data)


if __name__ == "__main__":
    main()
