# SPDX-License-Identifier: MIT
"""DDS and KTX2: every layout, and blocks against integers and other decoders."""

import random
import struct

import imagecodecs
import numpy as np
import pytest

import normaltexture as nt
from normaltexture import images
from support import oracle_blocks
from support.gpu_textures import NUMBERS, block_bytes, dds, ktx2, level_sizes

SIDE = 100  # blocks a side: 10,000 of each kind
ORACLES = {
    "BC1": oracle_blocks.bc1,
    "BC2": oracle_blocks.bc2,
    "BC3": oracle_blocks.bc3,
    "BC4": oracle_blocks.bc4,
    "BC4 SNORM": oracle_blocks.bc4_signed,
    "BC5": oracle_blocks.bc5,
    "BC5 SNORM": oracle_blocks.bc5_signed,
    "BC7": oracle_blocks.bc7,
}
# Blocks of the oracle that are looked at; the rest is left to other decoders.
SAMPLE = 700


def random_blocks(kind, count, seed=17):
    """As bytes; equal ends, and BC7 of each mode."""
    size = block_bytes(kind)
    blocks = bytearray(random.Random(seed).randbytes(count * size))
    for i in range(count):
        at = i * size
        if kind == "BC7":  # the mode is the lowest bit that is set
            mode = i % 9
            blocks[at] = 0 if mode == 8 else (blocks[at] | 1) << mode & 0xFF
        elif i % 16 == 0:
            blocks[at + 1] = blocks[at]
            blocks[at + 2 : at + 4] = blocks[at : at + 2] if kind == "BC1" else b"\x92\x24"
    return bytes(blocks)


def as_image(texels):
    """An image of SIDE x SIDE blocks from one row of texels a block."""
    array = np.asarray(texels)
    array = array.reshape(SIDE, SIDE, 4, 4, -1).swapaxes(1, 2)
    return array.reshape(4 * SIDE, 4 * SIDE, -1)


def as_blocks(image):
    image = image.reshape(SIDE, 4, SIDE, 4, -1).swapaxes(1, 2)
    return image.reshape(SIDE * SIDE, 16, -1)


def read_kind(kind, blocks, side=4 * SIDE):
    four, dxgi, _ = NUMBERS[kind]
    return nt.read(
        dds(side, side, blocks, four=four) if four else dds(side, side, blocks, dxgi=dxgi)
    )


@pytest.mark.parametrize("kind", ORACLES)
def test_blocks_are_those_of_integers(kind):
    blocks = random_blocks(kind, SIDE * SIDE)
    read = as_blocks(read_kind(kind, blocks))
    size = block_bytes(kind)
    compared = 0
    for i in range(0, SIDE * SIDE, SIDE * SIDE // SAMPLE):
        want = ORACLES[kind](blocks[i * size : (i + 1) * size])
        if want is not None:
            want = np.reshape(want, (16, -1))[:, : read.shape[2]]
            assert np.array_equal(read[i], want), (i, blocks[i * size : (i + 1) * size].hex())
            compared += 1
    assert compared > SAMPLE / 2


@pytest.mark.parametrize("kind", ["BC4", "BC4 SNORM"])
def test_palettes_are_those_of_integers(kind):
    """Each of the 65,536 pairs of ends, all eight values."""
    signed = kind != "BC4"
    a, b = np.meshgrid(np.arange(256), np.arange(256), indexing="ij")
    a, b = a.ravel(), b.ravel()
    rows = np.zeros((65536, 8), np.uint8)
    rows[:, 0], rows[:, 1] = a, b
    rows[:, 2:] = np.frombuffer(bytes.fromhex("88c6fa") * 2, np.uint8)  # indices 0 to 7, twice
    image = nt.read(dds(1024, 1024, rows.tobytes(), four=NUMBERS[kind][0]))
    read = image.reshape(256, 4, 256, 4).swapaxes(1, 2).reshape(65536, 16).astype(np.int64)
    top = 127 if signed else 255
    if signed:
        a, b = (np.where(v > 127, v - 256, v) for v in (a, b))
    eight = a > b
    a, b = np.maximum(a, -127), np.maximum(b, -127)
    span, low = (2 * top, top) if signed else (top, 0)
    for i in range(8):
        want = np.zeros(65536, np.int64)
        for n, where in ((7, eight), (5, ~eight)):
            value = a * n if i == 0 else b * n if i == 1 else a * (n + 1 - i) + b * (i - 1)
            if i > n:
                value = np.full_like(a, (-low if i == 6 else top) * n)
            level = (2 * 65535 * (value + low * n) + span * n) // (2 * span * n)
            want[where] = level[where]
        assert np.array_equal(read[:, i], want) and np.array_equal(read[:, i + 8], want)


# What the peer rounds in its own way: thirds of colors, and sevenths to 8 bit.
PEER_OFF = {"BC1": 1, "BC2": 1, "BC3": 1, "BC4": 1, "BC5": 1, "BC7": 0}


@pytest.mark.parametrize("kind", PEER_OFF)
def test_blocks_are_those_of_another_decoder(kind):
    blocks = random_blocks(kind, SIDE * SIDE, seed=18)
    read = as_blocks(read_kind(kind, blocks)).astype(np.int64)
    shape = (4 * SIDE, 4 * SIDE, {"BC4": 1, "BC5": 2}.get(kind, 4))
    shape = shape[:2] if shape[2] == 1 else shape
    out = imagecodecs.bcn_decode(blocks, int(kind[2]), shape=shape)
    peer = as_blocks(out)[..., : read.shape[2]].astype(np.int64)
    if kind in ("BC4", "BC5"):
        peer *= 257
        assert np.abs(read - peer).max() <= 257
        return
    assert np.abs(read - peer).max() <= PEER_OFF[kind]


PLAIN = {  # DXGI, Vulkan, channels, type of a stored sample
    "R8": (61, 9, 1, "u1"),
    "R8G8": (49, 16, 2, "u1"),
    "R8G8B8": (0, 23, 3, "u1"),
    "R8G8B8A8": (28, 37, 4, "u1"),
    "R16": (56, 70, 1, "<u2"),
    "R16G16": (35, 77, 2, "<u2"),
    "R16G16B16": (0, 84, 3, "<u2"),
    "R16G16B16A16": (11, 91, 4, "<u2"),
    "R16 FLOAT": (54, 76, 1, "<f2"),
    "R16G16 FLOAT": (34, 83, 2, "<f2"),
    "R16G16B16A16 FLOAT": (10, 97, 4, "<f2"),
    "R32 FLOAT": (41, 100, 1, "<f4"),
    "R32G32 FLOAT": (16, 103, 2, "<f4"),
    "R32G32B32 FLOAT": (6, 106, 3, "<f4"),
    "R32G32B32A32 FLOAT": (2, 109, 4, "<f4"),
    "R8 SNORM": (63, 10, 1, "i1"),
    "R8G8 SNORM": (51, 17, 2, "i1"),
    "R8G8B8A8 SNORM": (31, 38, 4, "i1"),
    "R16G16 SNORM": (37, 78, 2, "<i2"),
    "R16G16B16A16 SNORM": (13, 92, 4, "<i2"),
}


def stored_and_read(kind, height, width, channels):
    """Random samples, and what they are read as."""
    size = np.dtype(kind).itemsize
    raw = random.Random(3).randbytes(height * width * channels * size)
    stored = np.frombuffer(raw, kind).reshape(height, width, channels)
    if kind.endswith("1") and kind[-2] == "i" or kind == "<i2":
        top = 127 if size == 1 else 32767
        value = np.maximum(stored.astype(np.int64), -top) + top
        read = ((value * 65535 + top) // (2 * top)).astype(np.uint16)
    else:
        read = (
            stored.astype(np.float32)
            if "f" in kind
            else stored.astype(stored.dtype.newbyteorder("="))
        )
    return raw, read[..., 0] if channels == 1 else read


@pytest.mark.parametrize("name", PLAIN)
def test_plain_layouts(name):
    dxgi, vulkan, channels, kind = PLAIN[name]
    raw, want = stored_and_read(kind, 5, 7, channels)
    files = [ktx2(7, 5, [raw], vulkan)] + ([dds(7, 5, raw, dxgi=dxgi)] if dxgi else [])
    for data in files:
        read, info = nt.read_with_info(data)
        assert read.dtype == want.dtype and read.tobytes() == want.tobytes()
        assert info.layout == name and (info.mips, info.layers) == (1, 1)
        assert info.red_green == (channels == 2)


MASKS = {  # bits, masks of red, green, blue, alpha, flags beside: what pixel format says
    "A8R8G8B8": (32, (0xFF0000, 0xFF00, 0xFF, 0xFF000000), 1),
    "X8R8G8B8": (32, (0xFF0000, 0xFF00, 0xFF, 0), 0),
    "A8B8G8R8": (32, (0xFF, 0xFF00, 0xFF0000, 0xFF000000), 1),
    "R8G8B8": (24, (0xFF0000, 0xFF00, 0xFF, 0), 0),
    "R5G6B5": (16, (0xF800, 0x7E0, 0x1F, 0), 0),
    "A1R5G5B5": (16, (0x7C00, 0x3E0, 0x1F, 0x8000), 1),
    "A4R4G4B4": (16, (0xF00, 0xF0, 0xF, 0xF000), 1),
    "A2B10G10R10": (32, (0x3FF, 0xFFC00, 0x3FF00000, 0xC0000000), 1),
    "L8": (8, (0xFF, 0, 0, 0), 0x20000),
    "L16": (16, (0xFFFF, 0, 0, 0), 0x20000),
    "A8L8": (16, (0xFF, 0xFF, 0xFF, 0xFF00), 0x20001),
    "G16R16": (32, (0xFFFF, 0xFFFF0000, 0, 0), 0),
    "V8U8": (16, (0xFF, 0xFF00, 0, 0), 0x80000),
    "Q8W8V8U8": (32, (0xFF, 0xFF00, 0xFF0000, 0xFF000000), 0x80000),
}


@pytest.mark.parametrize("name", MASKS)
def test_masks(name):
    bits, masks, flags = MASKS[name]
    raw = random.Random(4).randbytes(6 * 5 * bits // 8)
    read = nt.read(dds(6, 5, raw, masks=masks, bits=bits, flags=flags)).astype(np.int64)
    step = bits // 8
    texels = [int.from_bytes(raw[i : i + step], "little") for i in range(0, len(raw), step)]
    if flags & 0x20000:
        masks = (masks[0], 0, 0, masks[3])
    used = [m for m in masks if m]
    full = 65535 if max(m // (m & -m) for m in used) > 255 or flags & 0x80000 else 255
    want = []
    for texel in texels:
        for mask in used:
            low = mask & -mask
            value, top = (texel & mask) // low, mask // low
            if flags & 0x80000:
                half = top // 2 + 1
                value = max(value - 2 * half if value >= half else value, 1 - half) + half - 1
                top = 2 * half - 2
            want.append((2 * full * value + top) // (2 * top))
    assert np.array_equal(read.ravel(), want)


def test_mips_and_layers():
    """Each image of an array of cubes with mips is found, in DDS and in KTX2."""
    sizes = level_sizes(8, 6, 4)
    images_of = {
        (layer, mip): bytes([10 * layer + mip]) * (w * h)
        for layer in range(12)
        for mip, (w, h) in enumerate(sizes)
    }
    body = b"".join(images_of[layer, mip] for layer in range(12) for mip in range(4))
    levels = [b"".join(images_of[layer, mip] for layer in range(12)) for mip in range(4)]
    files = [
        dds(8, 6, body, dxgi=61, mips=4, layers=2, cube=1),
        ktx2(8, 6, levels, 9, layers=2, faces=6),
        ktx2(8, 6, levels, 9, layers=2, faces=6, scheme=3),
    ]
    for data in files:
        with pytest.raises(nt.FileError, match="a cube map of 12 textures: pick a layer, 0 to 11"):
            nt.read(data)
        for (layer, mip), raw in images_of.items():
            read, info = nt.read_with_info(data, mip=mip, layer=layer)
            assert read.shape == sizes[mip][::-1] and read.tobytes() == raw
            assert (info.mips, info.layers) == (4, 12)
        for wrong in ({"layer": 12}, {"mip": 4, "layer": 0}):
            with pytest.raises(
                nt.FileError, match=r"has no (layer 12|mip 4): there are (12|4), from 0"
            ):
                nt.read(data, **wrong)
    with pytest.raises(nt.ArgumentError, match="mip=-1"):
        nt.read(files[0], mip=-1)


def test_sides_that_are_no_multiples_of_four():
    blocks = random_blocks("BC5", 6)
    whole = nt.read(dds(12, 8, blocks, four=b"ATI2"))
    for width, height in ((9, 5), (10, 7), (12, 8)):
        read = nt.read(dds(width, height, blocks, four=b"ATI2"))
        assert np.array_equal(read, whole[:height, :width])
    assert np.array_equal(nt.read(ktx2(9, 5, [blocks], 141)), whole[:5, :9])


def test_supercompression():
    raw = bytes(range(64)) * 16
    plain = nt.read(ktx2(32, 32, [raw], 9))
    assert np.array_equal(nt.read(ktx2(32, 32, [raw], 9, scheme=3)), plain)
    packed = ktx2(32, 32, [raw], 9, scheme=2, pack=imagecodecs.zstd_encode)
    assert np.array_equal(nt.read(packed), plain)
    for damage in (
        ktx2(32, 32, [raw], 9, scheme=3, pack=lambda level: level),
        ktx2(32, 32, [raw], 9, scheme=2, pack=lambda level: level),
        ktx2(32, 32, [raw[:-1]], 9, scheme=3),
        ktx2(32, 32, [raw[:-1]], 9),
    ):
        with pytest.raises(nt.FileError, match="damaged"):
            nt.read(damage)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (ktx2(8, 8, [bytes(64)], 0, model=166), "UASTC, 8 x 8, 1 mip: its pixels are not read"),
        (ktx2(8, 8, [bytes(64)], 0, scheme=1, model=163, transfer=2), "ETC1S.*marked sRGB"),
        (ktx2(8, 8, [bytes(64)], 157, model=162), "ASTC"),
        (ktx2(8, 8, [bytes(64)], 147), "ETC2"),
        (dds(8, 8, bytes(64), dxgi=95), "BC6H, which is not read"),
        (dds(8, 8, bytes(64), four=b"UYVY"), "an unknown format, which is not read"),
        (dds(8, 8, bytes(64), dxgi=61, mips=5), r"damaged \(5 mips of 8 x 8 texels\)"),
        (dds(8, 8, bytes(63), dxgi=61), "truncated"),
        (dds(8, 8, bytes(64), dxgi=61, layers=3, mips=4), "an array of 3 textures"),
        (dds(0x7FFFFFFF, 0x7FFFFFFF, bytes(64), dxgi=2), "larger than the limit"),
        (dds(8, 8, bytes(64), dxgi=61, layers=0xFFFFFFFF), "damaged"),
        (dds(8, 8, bytes(64), masks=(0xFF, 0xFF00), bits=8), "masks of 8 bits"),
        (dds(8, 8, bytes(64), masks=(1, 2), bits=8, flags=0x80000), "masks"),
        (dds(8, 8, bytes(64), bits=8), "masks"),
        (b"\xabKTX 11\xbb\r\n\x1a\n" + bytes(99), "version 1"),
        (b"\xabKTX 20\xbb\r\n\x1a\n", "truncated"),
    ],
)
def test_what_is_refused(data, words):
    with pytest.raises(nt.FileError, match=words):
        nt.read(data)


def test_offsets_beyond_the_file():
    data = bytearray(ktx2(8, 8, [bytes(64)], 9))
    for offset, length in ((2**63, 64), (2**64 - 1, 64), (len(data), 64), (0, 2**64 - 1), (0, 0)):
        data[80:96] = struct.pack("<2Q", offset, length)
        with pytest.raises(nt.FileError):
            nt.read(bytes(data))


def test_srgb_is_told():
    for data in (
        dds(8, 8, bytes(256), dxgi=29),
        ktx2(8, 8, [bytes(256)], 43),
        ktx2(8, 8, [bytes(256)], 37, transfer=2),
    ):
        assert nt.read_info(data).color_chunks == ("sRGB",)
    assert nt.read_info(dds(8, 8, bytes(256), dxgi=28)).color_chunks == ()


def test_as_an_image_of_the_extra():
    block = bytes([200, 200]) + bytes(6) + bytes([90, 90]) + bytes(6)
    read = images.read(dds(8, 4, block * 2, four=b"BC5U"))
    assert read.shape == (4, 8, 2) and (read == [200 * 257, 90 * 257]).all()
