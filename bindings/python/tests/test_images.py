# SPDX-License-Identifier: MIT
"""normaltexture.images: WebP, AVIF, TIFF, EXR and DDS give the numbers that are in the file."""

import builtins
import io
import struct
import sys

import numpy as np
import OpenEXR
import pytest
import tifffile
from PIL import Image, features

import normaltexture as nt
from normaltexture import gltf, images
from pysupport import gltf_files
from support import textures
from support.pngs import png_bytes, read_png

RGB = textures.standard(20, 28)
DEEP = textures.standard(20, 28, depth=16)
RGBA = np.dstack([RGB, RGB[..., 0]])


def by_pillow(image, kind, **options):
    out = io.BytesIO()
    Image.fromarray(image).save(out, kind, **options)
    return out.getvalue()


def tiff(image, **options):
    out = io.BytesIO()
    tifffile.imwrite(out, image, **options)
    return out.getvalue()


@pytest.mark.parametrize("image", [RGB, RGBA], ids=["RGB", "RGBA"])
def test_webp(image, tmp_path):
    data = by_pillow(image, "WEBP", lossless=True, exact=True)
    assert np.array_equal(images.read(data), image)
    (tmp_path / "a.webp").write_bytes(data)
    assert np.array_equal(images.read(tmp_path / "a.webp"), image)
    (tmp_path / "a.png").write_bytes(images.decode_to_png(data, "image/webp"))
    assert np.array_equal(read_png(tmp_path / "a.png")[0], image)


@pytest.mark.skipif(not features.check("avif"), reason="this Pillow is built without AVIF")
def test_avif():
    read = images.read(by_pillow(RGB, "AVIF", quality=100, subsampling="4:4:4"))
    assert read.shape == RGB.shape and np.abs(read.astype(int) - RGB).max() <= 6


@pytest.mark.parametrize("image", [RGB, RGBA, DEEP, RGB[..., 0], DEEP.astype(np.float32) / 65535])
@pytest.mark.parametrize(
    "how",
    [{}, {"compression": "zlib"}, {"compression": "lzw", "predictor": True}, {"byteorder": ">"}],
)
def test_tiff(image, how):
    photometric = "minisblack" if image.ndim == 2 else "rgb"
    read = images.read(tiff(image, photometric=photometric, **how))
    assert read.dtype == image.dtype and np.array_equal(read, image)


def test_odd_tiffs():
    planes = np.moveaxis(RGB, -1, 0)
    data = tiff(planes, photometric="rgb", planarconfig="separate")
    assert np.array_equal(images.read(data), RGB)
    assert np.array_equal(
        images.read(tiff(RGB[..., 0], photometric="miniswhite")), 255 - RGB[..., 0]
    )
    pages = tiff(np.stack([RGB, RGB[::-1]]), photometric="rgb")
    assert np.array_equal(images.read(pages), RGB)
    with pytest.raises(ValueError, match="uint32"):
        images.read(tiff(RGB.astype(np.uint32), photometric="rgb"))


@pytest.mark.parametrize("kind", [np.float16, np.float32])
def test_exr(kind, tmp_path):
    vectors = (DEEP.astype(np.float64) / 65535 * 2 - 1).astype(kind)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": vectors}).write(str(tmp_path / "a.exr"))
    read = images.read(tmp_path / "a.exr")
    assert read.dtype == np.float32 and np.array_equal(read, vectors.astype(np.float32))
    assert nt.measure(read, type="vector").texels == 20 * 28


def dds(width, height, four, body, mask=()):
    """A DDS file; `mask` are bit count and masks of an uncompressed one."""
    flags = 0x4 if four else 0x40
    form = struct.pack("<II4s5I", 32, flags, four or bytes(4), *(mask or (0,) * 5))
    head = struct.pack("<7I44x", 124, 0x1007, height, width, 0, 0, 0)
    return b"DDS " + head + form + struct.pack("<I16x", 0x1000) + body


def test_dds():
    bgr = RGB[..., ::-1]
    plain = dds(28, 20, b"", bgr.tobytes(), (24, 0xFF0000, 0xFF00, 0xFF, 0))
    assert np.array_equal(images.read(plain), RGB)
    block = bytes([200, 200]) + bytes(6) + bytes([90, 90]) + bytes(6)
    for four in (b"ATI2", b"BC5U"):
        two = images.read(dds(8, 4, four, block * 2))
        assert two.shape == (4, 8, 2) and (two == [200 * 257, 90 * 257]).all()
    png = images.decode_to_png(dds(8, 4, b"ATI2", block * 2), "image/vnd-ms.dds")
    assert nt.read(png).shape == (4, 8, 3)


def test_ours_need_nothing(tmp_path):
    data = png_bytes(DEEP)
    assert np.array_equal(images.read(data), DEEP)
    (tmp_path / "a.png").write_bytes(data)
    assert np.array_equal(images.read(tmp_path / "a.png"), DEEP)
    with pytest.raises(FileNotFoundError):
        images.read(tmp_path / "b.png")


@pytest.mark.parametrize("start", [b"RIFF\0\0\0\0WEBP", b"II*\0", b"v/1\x01", b"DDS ", b"hello"])
def test_damaged(start):
    with pytest.raises((ValueError, nt.FileError)):
        images.read(start + b"\1" * 60)


def test_missing_library(monkeypatch):
    data = by_pillow(RGB, "AVIF")
    for name in [name for name in sys.modules if name.partition(".")[0] == "PIL"]:
        monkeypatch.delitem(sys.modules, name)
    real = builtins.__import__

    def without_pillow(name, *args, **kwargs):
        if name.partition(".")[0] == "PIL":
            raise ImportError("no PIL")
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without_pillow)
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(images.MissingLibraryError, match=r"normaltexture\[images\]"):
        images.read(data)


def test_webp_in_gltf(tmp_path):
    made = gltf_files.Model()
    made.image(
        "n.webp", by_pillow(textures.wrong_blue(RGB, 0.1), "WEBP", lossless=True), "image/webp"
    )
    made.textures[0] = {"extensions": {"EXT_texture_webp": {"source": 0}}}
    made.material("m", normalTexture=0)
    path = made.save(tmp_path / "a.glb")
    (entry,) = gltf.check(path)["files"]
    assert entry["status"] == "ok" and entry["type"] == "standard"
    assert "NT001" in {found["id"] for found in entry["findings"]}
    (entry,) = gltf.clean(path, tmp_path / "b.glb")["files"]
    assert entry["status"] == "ok" and entry["written"]
    (entry,) = gltf.check(tmp_path / "b.glb")["files"]
    assert "NT001" not in {found["id"] for found in entry["findings"]}
