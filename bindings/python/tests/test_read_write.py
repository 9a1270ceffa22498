# SPDX-License-Identifier: MIT
"""Image files: sample for sample both ways, and what is refused."""

import math
import subprocess

import imagecodecs
import numpy as np
import OpenEXR
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

import normaltexture as nt
from pysupport.drawn import layouts
from support.pngs import png_bytes

SHAPES = [(5, 7), (5, 7, 2), (5, 7, 3), (5, 7, 4), (1, 1, 3)]


def image_of(dtype, shape):
    rng = np.random.default_rng(len(shape))
    if dtype == np.float32:
        return rng.standard_normal(shape).astype(dtype)
    return rng.integers(0, np.iinfo(dtype).max + 1, shape).astype(dtype)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_png_is_exact(dtype, shape, tmp_path):
    image = image_of(dtype, shape)
    for level in (None, 1, 12):
        nt.write(tmp_path / "a.png", image, level=level)
        got, info = nt.read_with_info(tmp_path / "a.png")
        assert got.dtype == dtype and np.array_equal(got, image)
        assert (info.width, info.height) == shape[1::-1]
        assert info.channels == (shape[2] if len(shape) == 3 else 1)
        assert info.bit_depth == 8 * image.itemsize
    for kind, array in layouts(image):
        nt.write(tmp_path / "b.png", array)
        assert np.array_equal(nt.read(tmp_path / "b.png"), image), kind


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    hnp.arrays(
        st.sampled_from([np.dtype(np.uint8), np.dtype(np.uint16)]),
        st.tuples(st.integers(1, 5), st.integers(1, 5), st.integers(1, 4)),
    )
)
def test_against_a_png_made_in_python(tmp_path, image):
    data = png_bytes(image, 8 * image.itemsize)
    got = nt.read(data)
    assert np.array_equal(got.reshape(image.shape), image)
    (tmp_path / "c.png").write_bytes(data)
    assert np.array_equal(nt.read(str(tmp_path / "c.png")), got)
    assert nt.read_info(memoryview(data)) == nt.read_with_info(data)[1]


@pytest.mark.parametrize("shape", [(4, 3), (4, 3, 3), (4, 3, 4)])
def test_tga(shape, tmp_path):
    image = image_of(np.uint8, shape)
    nt.write(tmp_path / "a.tga", image)
    got, info = nt.read_with_info(tmp_path / "a.tga")
    assert np.array_equal(got, image) and info.format == "tga"


@pytest.mark.parametrize("shape", [(4, 3), (4, 3, 3)])
def test_pfm(shape, tmp_path):
    image = image_of(np.float32, shape)
    image.flat[0], image.flat[1] = math.nan, math.inf
    nt.write(tmp_path / "a.pfm", image)
    got, info = nt.read_with_info(tmp_path / "a.pfm")
    assert got.tobytes() == image.tobytes() and info.format == "pfm"


def skip_unless(name):
    if name not in nt.codecs:
        pytest.skip(f"built without {name}")


@pytest.mark.parametrize("channels", [3, 4])
def test_webp(channels, tmp_path):
    skip_unless("libwebp")
    image = image_of(np.uint8, (5, 7, channels))
    nt.write(tmp_path / "a.webp", image, level=9)
    got, info = nt.read_with_info(tmp_path / "a.webp")
    assert np.array_equal(got, image) and (info.format, info.lossy) == ("webp", False)
    for wrong, word in ((image[..., 0], "not gray"), (image.astype(np.uint16), "8 bits")):
        with pytest.raises(nt.FileError, match=word):
            nt.write(tmp_path / "b.webp", wrong)


@pytest.mark.parametrize("tiles", [None, (8, 8)])
def test_exr(tiles, tmp_path):
    """All that OpenEXR packs without loss, by OpenEXR's own package."""
    skip_unless("OpenEXR")
    x = np.random.default_rng(3).normal(size=(40, 21, 3)).astype(np.float32)
    for kind in (np.float32, np.float16):
        for packing in ["NO", "RLE", "ZIPS", "ZIP", "PIZ"]:
            header = {"compression": getattr(OpenEXR, f"{packing}_COMPRESSION")}
            header["type"] = OpenEXR.tiledimage if tiles else OpenEXR.scanlineimage
            if tiles:
                header["tiles"] = OpenEXR.TileDescription()
                header["tiles"].xSize, header["tiles"].ySize = tiles
            planes = {c: x[..., i].astype(kind).copy() for i, c in enumerate("XYZ")}
            OpenEXR.File(header, planes).write(str(tmp_path / "a.exr"))
            got, info = nt.read_with_info(tmp_path / "a.exr")
            assert np.array_equal(got, x.astype(kind).astype(np.float32)), packing
            assert (info.format, info.vectors, info.bit_depth) == ("exr", True, 8 * kind().nbytes)


def test_texts(tmp_path):
    texts = {"Title": "Wand", "Comment": "r\u00f6ad \u2014 \u6cd5\u7dda"}
    nt.write(tmp_path / "a.png", np.zeros((2, 2, 3), np.uint8), texts=texts)
    assert nt.read_with_info(tmp_path / "a.png")[1].texts == texts
    for key in ("", "x" * 80, "\u6cd5"):
        with pytest.raises(nt.ArgumentError, match="texts: the key"):
            nt.write(tmp_path / "b.png", np.zeros((2, 2, 3), np.uint8), texts={key: "v"})


def test_info(test_files):
    jpeg = nt.read_info(test_files / "jpeg.jpg")
    assert jpeg.lossy and jpeg.format == "jpeg" and 1 <= jpeg.jpeg_quality <= 100
    assert nt.read_info(test_files / "standard_palette.png").palette
    assert nt.read_info(test_files / "standard_interlaced.png").interlaced
    assert nt.read_info(test_files / "gamma.png").to_dict()["format"] == "png"


@pytest.mark.parametrize(
    ("name", "status"),
    [
        ("broken_truncated.png", nt.FileStatus.CORRUPT),
        ("broken_crc.png", nt.FileStatus.CORRUPT),
        ("broken_text.png", nt.FileStatus.FORMAT),
        ("broken_empty.png", nt.FileStatus.CORRUPT),
        ("broken_huge.png", nt.FileStatus.LIMIT),
    ],
)
def test_broken_files(test_files, name, status):
    for file in (test_files / name, (test_files / name).read_bytes()):
        with pytest.raises(nt.FileError) as raised:
            nt.read(file)
        assert raised.value.status == status
        assert isinstance(raised.value, OSError)
        assert ("<bytes>" if isinstance(file, bytes) else name) in str(raised.value)


def test_limits(test_files):
    with pytest.raises(nt.FileError) as raised:
        nt.read(test_files / "standard.png", max_side=95)
    assert raised.value.status == nt.FileStatus.LIMIT
    with pytest.raises(nt.FileError):
        nt.read(test_files / "standard.png", max_texels=96 * 64 - 1)
    assert nt.read(test_files / "standard.png", max_side=96, max_texels=96 * 64).shape[1] == 96


def test_refusals(tmp_path):
    image = np.zeros((2, 2, 3), np.uint8)
    with pytest.raises(FileNotFoundError):
        nt.read(tmp_path / "none.png")
    with pytest.raises(nt.FileError):
        nt.read(tmp_path)
    with pytest.raises(nt.ArgumentError, match=r"\.png, \.tga, \.pfm, \.webp, \.dds or \.ktx2"):
        nt.write(tmp_path / "a.bmp", image)
    with pytest.raises(nt.ArgumentError, match="level=13"):
        nt.write(tmp_path / "a.png", image, level=13)
    with pytest.raises(nt.ArgumentError, match="1 to 4 channels"):
        nt.write(tmp_path / "a.png", np.zeros((2, 2, 5), np.uint8))
    with pytest.raises(nt.SampleTypeError, match="image: samples"):
        nt.write(tmp_path / "a.png", np.zeros((2, 2, 3)))
    for name, wrong in (
        ("a.png", np.zeros((2, 2), np.float32)),
        ("a.pfm", image),
        ("a.tga", np.zeros((2, 2, 3), np.uint16)),
    ):
        with pytest.raises(nt.FileError) as raised:
            nt.write(tmp_path / name, wrong)
        assert raised.value.status == nt.FileStatus.USAGE
    with pytest.raises(nt.FileError) as raised:
        nt.write(tmp_path / "missing" / "a.png", image)
    assert raised.value.status == nt.FileStatus.WRITE
    assert list(tmp_path.iterdir()) == []


def test_an_older_file_stays_until_the_new_one_is_complete(tmp_path):
    path = tmp_path / "a.png"
    nt.write(path, np.zeros((2, 2, 3), np.uint8))
    before = path.read_bytes()
    with pytest.raises(nt.FileError):
        nt.write(path, np.zeros((2, 2), np.float32))
    assert path.read_bytes() == before
    nt.write(path, np.ones((2, 2, 3), np.uint8))
    assert nt.read(path).all()


TEXTURE_CASES = [  # arguments of write, those of ntp convert, dtype, channels
    ({}, (), np.uint8, 3),
    ({"mips": True}, ("--mips",), np.uint16, 3),
    ({"quality": "quick", "mips": True}, ("--quality", "quick", "--mips"), np.uint8, 4),
    ({"quality": "channel"}, ("--quality", "channel", "--type", "height"), np.uint16, 1),
    ({"compression": "none", "mips": True}, ("--compression", "none", "--mips"), np.uint16, 3),
    ({"compression": "none"}, ("--compression", "none", "--type", "height"), np.uint8, 1),
]


def waves(depth):
    v, u = np.mgrid[0:37, 0:46] / 7
    n = np.stack([np.sin(u) / 3, np.cos(v + u) / 3, np.ones_like(u)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return nt.encode(n.astype(np.float32), depth=depth)


@pytest.mark.parametrize("ending", ["dds", "ktx2"])
@pytest.mark.parametrize("case", range(len(TEXTURE_CASES)))
def test_gpu_textures_as_the_program_writes_them(tmp_path, ending, case):
    how, arguments, dtype, channels = TEXTURE_CASES[case]
    image = waves(8 * np.dtype(dtype).itemsize)
    if channels == 4:
        image = np.dstack([image, np.full((37, 46), 255, dtype)])
    image = image[..., 0] if channels == 1 else image
    nt.write(tmp_path / "a.png", image)
    made, expected = tmp_path / f"a.{ending}", tmp_path / f"b.{ending}"
    command = [nt.program(), "convert", tmp_path / "a.png", "-o", expected, *arguments]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    for threads in (1, 3):
        nt.write(made, np.asfortranarray(image), threads=threads, **how)
        assert made.read_bytes() == expected.read_bytes()


def test_dds_by_other_readers(tmp_path):
    """Both round BC4 and BC5 to 8 bits, some a level off."""
    image, target = waves(8)[:36, :44], tmp_path / "a.dds"
    nt.write(target, image, compression="none", mips=True)
    rgba = np.asarray(Image.open(target))
    assert np.array_equal(rgba[..., :3], image) and np.all(rgba[..., 3] == 255)
    for source in (image, image[..., 0]):
        nt.write(target, source, mips=source.ndim == 3)
        ours = nt.read(target) / 257
        theirs = np.asarray(Image.open(target))
        if source.ndim == 3:
            theirs = theirs[..., :2]
        for other in (theirs, imagecodecs.dds_decode(target.read_bytes())):
            assert np.abs(other - ours).max() <= 1.5
            assert np.abs(other - ours).mean() < 0.6


def test_gpu_textures_refused(tmp_path, monkeypatch):
    image = waves(8)
    target = tmp_path / "a.dds"
    for match, array, how in [
        ("mips=True", image[..., 0], {"mips": True}),
        ("quality=", image, {"quality": "best"}),
        ("compression=", image, {"compression": "bc7"}),
        ("threads=", image, {"threads": -1}),
        ("type=", image, {"type": "rgb"}),
        ("undo", image[..., ::-1], {"mips": True}),
    ]:
        with pytest.raises(nt.ArgumentError, match=match):
            nt.write(target, array, **how)
    with pytest.raises(nt.ArgumentError, match=r"\.dds or \.ktx2"):
        nt.write(tmp_path / "a.png", image, mips=True)
    with pytest.raises(nt.FileError, match="DDS"):
        nt.write(target, image.astype(np.float32))

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("normaltexture._texture_file.encode_bc5", interrupted)
    with pytest.raises(KeyboardInterrupt):
        nt.write(target, image)
    assert not list(tmp_path.iterdir())
