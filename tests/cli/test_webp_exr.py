# SPDX-License-Identifier: MIT
"""WebP, by Pillow's library and back, and EXR, by files that support/exr.py makes byte by byte."""

import json
import re
import struct
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from support import exr, textures
from support.pngs import read_png, write_png
from support.spawn import spawn

HEIGHT, WIDTH = 37, 53


@pytest.fixture(scope="module")
def versions(program):
    return spawn([program, "--version"]).stdout.decode()


@pytest.fixture
def webp(versions):
    if "libwebp" not in versions:
        pytest.skip("built without libwebp")


@pytest.fixture
def openexr(versions):
    if "OpenEXR" not in versions:
        pytest.skip("built without OpenEXR")


@pytest.fixture(scope="module")
def vectors():
    n = np.random.default_rng(17).normal(size=(HEIGHT, WIDTH, 3))
    n[..., 2] = np.abs(n[..., 2]) + 1
    return (n / np.linalg.norm(n, axis=2, keepdims=True)).astype(np.float32)


@pytest.fixture(scope="module")
def texels(vectors):
    return (vectors + 1) / 2


def named(names, picture):
    return dict(zip(names, np.moveaxis(picture, 2, 0), strict=True))


def checked(run, *args):
    done = run("check", "--format", "json", *args)
    return {f["path"].removeprefix("./"): f for f in json.loads(done.stdout)["files"]}


def turned(run, directory, name, *args):
    """The floats that `ntp` reads, turned by 180 degrees and back; red and green become 1 - v."""
    done = run("transform", name, "-o", "x.pfm", "--rotate", "180", *args)
    assert done.returncode == 0, done.stderr
    kind, size, _, data = (directory / "x.pfm").read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    shape = (height, width, 3) if kind == b"PF" else (height, width)
    return np.frombuffer(data, np.float32).reshape(shape)[:, ::-1]


def as_turned(picture):
    return np.dstack([np.float32(1) - picture[..., :2], picture[..., 2]])


# ------------------------------------------------------------------------------ WebP


def test_webp_is_read(run, tmp_path, webp):
    picture = textures.standard(HEIGHT, WIDTH)
    alpha = np.arange(HEIGHT * WIDTH, dtype=np.uint8).reshape(HEIGHT, WIDTH)
    seen = np.dstack([picture, alpha])
    Image.fromarray(picture).save(tmp_path / "a_n.webp", lossless=True)
    Image.fromarray(seen).save(tmp_path / "b_n.webp", lossless=True, exact=True)
    Image.fromarray(picture).save(tmp_path / "c_n.webp", quality=70, icc_profile=b"profile")
    a, b, c = (file for _, file in sorted(checked(run, ".").items()))
    assert a["format"] == b["format"] == c["format"] == "webp" and a["type"] == "standard"
    assert (a["channels"], b["channels"], a["bit_depth"]) == (3, 4, 8)
    ids = [{f["id"] for f in file["findings"]} for file in (a, c)]
    assert ids[1] >= {"NT030", "NT031", "NT040"} and not ids[0] & {"NT030", "NT031", "NT040"}
    for name, want in (("a", picture), ("b", seen)):
        done = run("convert", f"{name}_n.webp", "-o", "x.png", "--y", "up", "--to-y", "up")
        assert done.returncode == 0 and np.array_equal(read_png(tmp_path / "x.png")[0], want)


@pytest.mark.parametrize("channels", [3, 4])
def test_webp_is_written_without_loss(run, tmp_path, webp, channels):
    picture = np.random.default_rng(5).integers(0, 256, (HEIGHT, WIDTH, channels), np.uint8)
    picture[:5, :, 3:] = 0  # colors under an alpha of 0 stay
    write_png(tmp_path / "a.png", picture)
    how = ["--rotate", "180", "--type", "standard", "--y", "up"]
    run("transform", "a.png", "-o", "x.png", *how)
    for level in ("1", "12"):
        assert run("transform", "a.png", "-o", "x.webp", *how, "--level", level).returncode == 0
        with Image.open(tmp_path / "x.webp") as image:
            assert np.array_equal(np.array(image), read_png(tmp_path / "x.png")[0])


def test_webp_that_is_not_written(run, tmp_path, webp):
    write_png(tmp_path / "deep.png", textures.standard(8, 8).astype(np.uint16) * 257)
    Image.fromarray(textures.wrong_blue(textures.standard(), 0.1)).save(tmp_path / "lossy.webp")
    before = (tmp_path / "lossy.webp").read_bytes()
    for args, words in (
        (["convert", "deep.png", "-o", "x.webp"], "8 bits, not more"),
        (["curvature", "deep.png", "-o", "x.webp", "--depth", "8", "--y", "up"], "not gray"),
        (["clean", "lossy.webp", "--in-place", "--type", "standard"], "WebP with loss is not"),
        (["clean", "deep.png", "-o", "x.exr"], "not written"),
    ):
        done = run(*args)
        assert done.returncode in (2, 3) and words in done.stderr, (args, done.stderr)
    assert (tmp_path / "lossy.webp").read_bytes() == before and not (tmp_path / "x.webp").exists()


def test_damaged_webp(run, tmp_path, webp):
    Image.fromarray(textures.standard(HEIGHT, WIDTH)).save(tmp_path / "a.webp", lossless=True)
    good = (tmp_path / "a.webp").read_bytes()
    frames = [Image.new("RGB", (8, 8), (255 * i, 0, 0)) for i in range(2)]
    frames[0].save(tmp_path / "moves.webp", save_all=True, append_images=frames[1:])
    huge = bytearray(good)
    huge[21:25] = b"\xff\xff\xff\x0f"  # 16384 x 16384
    (tmp_path / "huge.webp").write_bytes(huge)
    (tmp_path / "cut.webp").write_bytes(good[:-9])
    (tmp_path / "start.webp").write_bytes(good[:14])
    (tmp_path / "riff.webp").write_bytes(good[:4] + b"\xff" * 4 + good[8:])
    bad = bytearray(good)
    bad[20] ^= 1  # the signature of what has no loss
    (tmp_path / "bad.webp").write_bytes(bad)
    files = checked(run, ".", "--max-texels", "1000000")
    words = {"cut": "truncated", "start": "truncated", "riff": "truncated", "bad": "damaged"}
    words |= {"huge": "limit", "moves": "animated"}
    for name, word in words.items():
        assert word in files[f"{name}.webp"]["message"], files[f"{name}.webp"]["message"]


# ------------------------------------------------------------------------------ EXR


@pytest.mark.parametrize("kind", ["f2", "f4"])
def test_exr_gives_the_numbers_of_the_file(run, tmp_path, openexr, texels, kind):
    picture = texels.astype(kind)
    want = as_turned(picture.astype(np.float32))
    for compression in (exr.NONE, exr.RLE, exr.ZIPS, exr.ZIP):
        for tile in (0, 16):
            data = exr.exr(
                named("RGB", picture), compression=compression, tile=tile, corner=(-7, 9)
            )
            (tmp_path / f"{compression}_{tile}.exr").write_bytes(data)
    names = [path.name for path in sorted(tmp_path.glob("*.exr"))]
    done = run("transform", *names, "-o", "out/", "--rotate", "180", "--type", "standard")
    assert done.returncode == 0, done.stderr
    for name in names:
        data = (tmp_path / "out" / name.replace(".exr", ".pfm")).read_bytes().split(b"\n", 3)[3]
        got = np.frombuffer(data, np.float32).reshape(want.shape)[:, ::-1]
        assert np.array_equal(got, want), name


def test_exr_channels(run, tmp_path, openexr, vectors, texels):
    """Which are taken; X, Y, Z are vectors."""
    plane = np.full((HEIGHT, WIDTH), 0.25, np.float32)
    biased = ((vectors.astype(np.float64) + 1) / 2).astype(np.float32)
    cases = {
        "rgb before a layer": (named("RGB", texels) | {"depth.Z": plane}, texels),
        "normals before rgb": (
            named(("l.Normal.X", "l.Normal.Y", "l.Normal.Z"), vectors) | named("RGB", 0 * texels),
            biased,
        ),
        "small letters": (named("rgb", texels) | {"Z": plane}, texels),
        "xyz": (named("XYZ", vectors), biased),
        "a pair": (named("RG", texels[..., :2]), np.dstack([texels[..., :2], 0 * plane])),
    }
    for name, (channels, want) in cases.items():
        (tmp_path / "a.exr").write_bytes(exr.exr(channels, compression=exr.ZIP))
        got = turned(run, tmp_path, "a.exr", "--type", "standard")
        assert np.array_equal(got, as_turned(want)), name
    heights = texels[..., 0]
    data = b"Pf\n%d %d\n-1\n" % (WIDTH, HEIGHT) + heights[::-1].tobytes()
    (tmp_path / "a.pfm").write_bytes(data)
    run("from-height", "a.pfm", "-o", "x.png", "--scale", "2")
    want = read_png(tmp_path / "x.png")[0]
    for channels in ({"Y": heights}, {"Z": heights}, {"l.V": heights}):
        (tmp_path / "a.exr").write_bytes(exr.exr(channels))
        assert run("from-height", "a.exr", "-o", "x.png", "--scale", "2").returncode == 0
        assert np.array_equal(read_png(tmp_path / "x.png")[0], want), channels


def test_exr_in_a_pipe_and_in_check(run, program, tmp_path, openexr, texels):
    data = exr.exr(named("RGB", texels), compression=exr.ZIP)
    (tmp_path / "a_n.exr").write_bytes(data)
    file = checked(run, ".")["a_n.exr"]
    assert (file["format"], file["type"], file["bit_depth"]) == ("exr", "standard", 32)
    assert file["fail"]["rounded"] == 0
    done = spawn([program, "check", "-"], input=data)
    assert done.returncode == 0, done.stderr
    odd = texels.copy()
    odd[3, 4] = (np.nan, np.inf, -np.inf)
    (tmp_path / "b_n.exr").write_bytes(exr.exr(named("RGB", odd)))
    assert checked(run, "b_n.exr")["b_n.exr"]["type"] == "standard"
    done = run("clean", "a_n.exr", "--in-place", "--method", "derive")
    assert (tmp_path / "a_n.exr").read_bytes() == data


def test_exr_without_its_library(program, tmp_path, openexr, texels):
    """A program that loads the library with the first EXR, looking for another version of it."""
    code = Path(program).read_bytes()
    if b"which is read by" not in code:
        pytest.skip("the program is linked to OpenEXRCore")
    other = tmp_path / "ntp"
    other.write_bytes(re.sub(rb"(libOpenEXRCore[-.\w]*\.so\.)\d", rb"\1x", code))
    other.chmod(0o755)
    (tmp_path / "a_n.exr").write_bytes(exr.exr(named("RGB", texels)))
    write_png(tmp_path / "b_n.png", np.full((4, 4, 3), (128, 128, 255), "u1"))
    done = spawn([other, "check", tmp_path / "b_n.png"])
    assert done.returncode == 0, done.stderr
    done = spawn([other, "check", tmp_path / "a_n.exr"])
    assert (done.returncode, done.stderr.count(b"libOpenEXRCore")) == (3, 1), done
    assert b"is not installed here" in done.stderr


def test_damaged_exr(run, tmp_path, openexr, texels):
    channels = named("RGB", texels)
    good = exr.exr(channels, compression=exr.ZIP)
    window = good.index(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4

    def with_window(*sides):
        return good[:window] + struct.pack("<4i", *sides) + good[window + 16 :]

    files = {
        "cut": (good[:-9], ""),
        "head": (good[:100], ""),
        "table": (good[: good.index(b"screenWindowWidth") + 40], ""),
        "huge": (with_window(0, 0, 60000, 60000), "limit"),
        "wide": (with_window(-(1 << 31), 0, (1 << 31) - 1, 5), ""),
        "empty": (with_window(5, 5, 4, 4), ""),
        "parts": (exr.exr(channels, flags=0x1000), ""),
        "deep": (exr.exr(channels, flags=0x800), ""),
        "whole": (exr.exr({n: c.view("u4") for n, c in channels.items()}), "integers"),
        "few": (exr.exr({"Y": np.zeros((8, 8), "f4")}, sampling=2), "fewer samples"),
        "names": (exr.exr({"p": channels["R"], "q": channels["G"]}), "of 2 channels"),
        "noise": (exr.exr(channels, compression=exr.ZIP, raw=bytes(range(200))), "damaged"),
        "many": (exr.exr({f"c{i}": np.zeros((1, 1), "f4") for i in range(1100)}), "1024"),
    }
    for name, (data, _) in files.items():
        (tmp_path / f"{name}.exr").write_bytes(data)
    told = checked(run, ".", "--max-texels", "1000000")
    for name, (_, words) in files.items():
        file = told[f"{name}.exr"]
        assert file["status"] == "unreadable" and words in file["message"], file["message"]


# ------------------------------------------------------------------------------ others


def test_what_to_install(run, tmp_path):
    """A file of a format that is not read is named, with what reads it."""
    words = {
        "a.tif": (b"II*\0", "normaltexture[images]"),
        "a.avif": (b"\0\0\0\x20ftypavif", "normaltexture[images]"),
        "a.astc": (b"\x13\xab\xa1\x5c\x04\x04\x01", "astcenc"),
    }
    for name, (start, _) in words.items():
        (tmp_path / name).write_bytes(start + bytes(99))
    told = checked(run, *words)
    for name, (_, word) in words.items():
        assert told[name]["status"] == "unreadable" and word in told[name]["message"]
