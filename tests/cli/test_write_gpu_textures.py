# SPDX-License-Identifier: MIT
"""ntp convert to DDS and KTX2: headers, mips and blocks, by readers written from the formats."""

import io
import json
import struct

import numpy as np
import pytest
from PIL import Image

from support import exact_blocks, textures
from support import libntp_ffi as ntp
from support.pngs import read_png, write_png

WIDTH, HEIGHT = 43, 22
MIPS = [(43, 22), (21, 11), (10, 5), (5, 2), (2, 1), (1, 1)]
NORMALS = textures.standard(24, 48)[:HEIGHT, :WIDTH]


def encoded(image, channels):
    h, w = image.shape[:2]
    out = np.zeros((-(-h // 4), -(-w // 4), 8 * channels), np.uint8)
    encoding = ntp.HEIGHT if channels == 1 else ntp.STANDARD
    image = np.ascontiguousarray(image)
    src = ntp.view(image, encoding, const=True)
    encode = ntp.lib.ntp_bc4_encode if channels == 1 else ntp.lib.ntp_bc5_encode
    data = ntp.ffi.cast("uint8_t *", out.ctypes.data)
    ntp.check(encode(data, out.strides[0], src, ntp.ffi.NULL, ntp.ffi.NULL))
    return out.tobytes()


def level_bytes(width, height, size, blocks):
    return (-(-width // 4)) * (-(-height // 4)) * size if blocks else width * height * size


def read_dds(data, size, blocks, mips=1):
    """(DXGI format, levels from the largest); size: bytes of a texel or block."""
    magic, own, flags, height, width, pitch, _, count = struct.unpack_from("<4s7I", data)
    assert (magic, own, width, height, count) == (b"DDS ", 124, WIDTH, HEIGHT, mips)
    assert flags == 0x1007 | (0x80000 if blocks else 8) | (0x20000 if mips > 1 else 0)
    assert pitch == (level_bytes(WIDTH, HEIGHT, size, True) if blocks else WIDTH * size)
    assert struct.unpack_from("<II4s5I", data, 76) == (32, 4, b"DX10", 0, 0, 0, 0, 0)
    assert struct.unpack_from("<5I", data, 108) == (0x401008 if mips > 1 else 0x1000, 0, 0, 0, 0)
    dxgi, dimension, misc, layers, alpha = struct.unpack_from("<5I", data, 128)
    assert (dimension, misc, layers, alpha) == (3, 0, 1, 0)
    levels, at = [], 148
    for w, h in MIPS[:mips]:
        levels.append(data[at : at + level_bytes(w, h, size, blocks)])
        at += len(levels[-1])
    assert at == len(data)
    return dxgi, levels


def read_ktx2(data, size, blocks, mips=1):
    assert data[:12] == b"\xabKTX 20\xbb\r\n\x1a\n"
    vulkan, type_size, *rest = struct.unpack_from("<9I", data, 12)
    assert rest == [WIDTH, HEIGHT, 0, 0, 1, mips, 0]
    descriptor, descriptor_size, names, names_size, *last = struct.unpack_from("<4I2Q", data, 48)
    assert descriptor == 80 + 24 * mips and last == [0, 0]
    assert names == descriptor + descriptor_size
    length = struct.unpack_from("<I", data, names)[0]
    assert data[names + 4 : names + 4 + length] == b"KTXwriter\0ntp\0"
    assert names_size == 4 + length + -length % 4
    index = [struct.unpack_from("<3Q", data, 80 + 24 * mip) for mip in range(mips)]
    end = names + names_size
    for offset, stored, plain in reversed(index):  # smallest first
        assert stored == plain and offset % max(size, 4) == 0 and 0 <= offset - end < max(size, 4)
        assert not any(data[end:offset])
        end = offset + stored
    assert end == len(data)
    check_descriptor(data[descriptor:names], size, blocks, type_size)
    return vulkan, [data[o : o + n] for o, n, _ in index]


def check_descriptor(data, size, blocks, type_size):
    total, vendor, version, own, model, primaries, transfer, flags = struct.unpack_from(
        "<IIHHBBBB", data
    )
    assert (total, vendor, version, own) == (len(data), 0, 2, len(data) - 4)
    assert (primaries, transfer, flags) == (1, 1, 0)
    samples = [struct.unpack_from("<HBB4BII", data, at) for at in range(28, len(data), 16)]
    assert list(data[16:28]) == [3 * blocks, 3 * blocks, 0, 0, size, *[0] * 7]
    bits = 8 * size // len(samples)
    assert model == ({8: 131, 16: 132}[size] if blocks else 1)
    assert type_size == (1 if blocks else bits // 8)
    for i, (offset, length, channel, *place, lower, upper) in enumerate(samples):
        assert (offset, length, place, lower) == (i * bits, bits - 1, [0] * 4, 0)
        assert channel == (15 if i == 3 else i)
        assert upper == (2**32 - 1 if blocks else 2**bits - 1)


READERS = {"dds": read_dds, "ktx2": read_ktx2}
CASES = [  # image, arguments, DXGI and Vulkan formats, bytes of a texel or block, blocks
    (NORMALS, (), (83, 141), 16, True),
    (NORMALS.astype(np.uint16) * 257, ("--mips",), (83, 141), 16, True),
    (NORMALS[..., 0], ("--type", "height"), (80, 139), 8, True),
    (NORMALS, ("--compression", "none", "--mips"), (28, 37), 4, False),
    (NORMALS.astype(np.uint16) * 257, ("--compression", "none"), (11, 91), 8, False),
    (NORMALS, ("--channels", "xy", "--compression", "none"), (49, 16), 2, False),
    (NORMALS, ("--channels", "xy", "--depth", "16", "--compression", "none"), (35, 77), 4, False),
    (NORMALS[..., 0], ("--type", "height", "--compression", "none"), (61, 9), 1, False),
]


@pytest.mark.parametrize("case", range(len(CASES)))
@pytest.mark.parametrize("kind", READERS)
def test_files(run, tmp_path, kind, case):
    image, arguments, formats, size, blocks = CASES[case]
    write_png(tmp_path / "a_n.png", image)
    done = run("convert", "a_n.png", "-o", f"b.{kind}", *arguments)
    assert (done.returncode, done.stderr) == (0, "")
    mips = len(MIPS) if "--mips" in arguments else 1
    found, levels = READERS[kind]((tmp_path / f"b.{kind}").read_bytes(), size, blocks, mips)
    assert found == formats[kind == "ktx2"]
    pictures = [image]
    if mips > 1:
        assert run("resize", "a_n.png", "--mips", "-o", "m.png").returncode == 0
        pictures += [read_png(tmp_path / f"m_mip{i}.png")[0] for i in range(1, mips)]
    for level, picture in zip(levels, pictures, strict=True):
        if blocks:
            assert level == encoded(picture, size // 8)
            continue
        want = picture if picture.ndim == 3 else picture[..., None]
        if "16" in arguments:
            want = want.astype(np.uint16) * 257
        want = want[..., :2] if "xy" in arguments else want
        if want.shape[2] == 3:
            want = np.pad(want, ((0, 0), (0, 0), (0, 1)), constant_values=np.iinfo(want.dtype).max)
        assert level == want.astype(want.dtype.newbyteorder("<")).tobytes()


def test_another_reader(run, tmp_path):
    """Pillow cuts palettes to 8 bit: it is off by a level at most."""
    write_png(tmp_path / "a_n.png", NORMALS)
    assert run("convert", "a_n.png", "-o", "b.dds").returncode == 0
    data = (tmp_path / "b.dds").read_bytes()
    theirs = np.asarray(Image.open(io.BytesIO(data)))[..., :2]
    blocks = np.frombuffer(data[148:], np.uint8).reshape(6, 11, 16)
    for c in range(2):
        ours = exact_blocks.decoded(blocks[..., 8 * c : 8 * c + 8])[:HEIGHT, :WIDTH] / 35
        assert np.abs(ours - theirs[..., c]).max() <= 1
        assert np.abs(ours - NORMALS[..., c]).max() <= 16


def test_same_bytes_for_any_number_of_threads(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.standard(64, 64))
    for jobs in "13":
        arguments = ("--mips", "--quality", "channel", "--jobs", jobs)
        assert run("convert", "a_n.png", "-o", f"{jobs}.ktx2", *arguments).returncode == 0
    assert (tmp_path / "1.ktx2").read_bytes() == (tmp_path / "3.ktx2").read_bytes()


def test_what_is_said(run, tmp_path):
    write_png(tmp_path / "a_n.png", NORMALS)
    done = run("convert", "a_n.png", "-o", "b.dds", "--mips", "--format", "json")
    (file,) = json.loads(done.stdout)["files"]
    assert (file["compression"], file["mips"]) == ("bc5", 6)
    done = run("convert", "a_n.png", "-o", "b.dds", "--quality", "quick")
    assert "standard, in BC5 (red and green; blue follows from them)" in done.stdout
    before = (tmp_path / "b.dds").read_bytes()
    for arguments, words in (
        (("clean", "a_n.png", "-o", "b.dds"), "only ntp convert writes DDS and KTX2"),
        (("diff", "a_n.png", "a_n.png", "-o", "b.ktx2"), "only ntp convert writes"),
        (("convert", "a_n.png", "-o", "b.dds", "--channels", "1y0x"), "need x, y first"),
        (("convert", "a_n.png", "-o", "b.png", "--mips"), "--mips is for .dds and .ktx2"),
    ):
        done = run(*arguments)
        assert done.returncode == 2 and words in done.stderr
    done = run("convert", "a_n.png", "-o", "/dev/full/b.dds")
    assert done.returncode == 3
    assert (tmp_path / "b.dds").read_bytes() == before
    assert sorted(f.name for f in tmp_path.iterdir()) == ["a_n.png", "b.dds"]
