# SPDX-License-Identifier: MIT
"""What `ntp` writes besides what it repairs: chunks, formats, depths, channels, heatmaps, sizes."""

import struct
import zlib

import numpy as np
import pytest

from support import textures
from support.pngs import png_bytes, read_png, tga_bytes, write_png
from support.runs import items, noisy, pixels_of
from support.spawn import spawn


def test_chunks(run, tmp_path):
    chunks = [
        (b"gAMA", (45455).to_bytes(4, "big")),
        (b"pHYs", struct.pack(">IIB", 2835, 2835, 1)),
        (b"tEXt", b"Author\0somebody"),
        (b"zTXt", b"Comment\0\0" + zlib.compress(b"long")),
        (b"iTXt", b"Title\0\0\0en\0\0" + "Straße".encode()),
    ]
    color = [(b"cICP", bytes([1, 13, 0, 1]))]
    write_png(tmp_path / "a_n.png", noisy(), chunks=[*color, *chunks])
    done = run("clean", "a_n.png", "-o", "b.png")
    assert "gAMA, cICP" in done.stdout
    _, kept = read_png(tmp_path / "b.png")
    assert b"gAMA" not in kept and b"cICP" not in kept and kept[b"pHYs"] == [chunks[1][1]]
    assert kept[b"tEXt"] == [b"Author\0somebody"] and b"iTXt" in kept and b"zTXt" in kept


def test_what_does_not_change_is_copied(run, program, tmp_path):
    """Byte for byte, with chunks that no writer knows; chunks of color are left out."""
    picture = textures.standard(600, 600)  # large enough to be packed by threads
    chunks = [(b"tIME", bytes(7)), (b"prVt", b"private"), (b"tEXt", b"Author\0somebody")]
    write_png(tmp_path / "a_n.png", picture, chunks=chunks)
    data = (tmp_path / "a_n.png").read_bytes()
    by_row = ["a_n.png", "-o", "r.png", "--max-at-once", "0"]
    for args in (["a_n.png", "-o", "b.png"], ["a_n.png", "-o", "d/"], ["d", "-o", "e"], by_row):
        assert run("clean", *args).returncode == 0
    for name in ("b.png", "d/a_n.png", "e/a_n.png", "r.png"):
        assert (tmp_path / name).read_bytes() == data, name
    assert spawn([program, "clean", "-", "-o", "-"], input=data).stdout == data
    (item,) = items(run("clean", "a_n.png", "-o", "f.png", "--format", "json"))
    assert (item["changed"], item["written"]) == (0, True)
    # Of all kinds of color, also after the palette and where a chunk is longer than a buffer.
    flat = textures.standard(4, 4)
    palette, places = np.unique(flat.reshape(-1, 3), axis=0, return_inverse=True)
    kinds = {"palette": {"pixels": places.reshape(4, 4), "palette": palette, "depth": 8}}
    kinds["rgb"] = {"pixels": picture}
    color = [(b"gAMA", (45455).to_bytes(4, "big")), (b"sRGB", b"\0"), (b"cHRM", bytes(32))]
    color += [(b"cICP", bytes([1, 13, 0, 1]))]
    color = {"some": color, "profile": [(b"iCCP", b"a\0\0" + bytes(200000))]}
    for kind, how in kinds.items():
        want = png_bytes(**how, chunks=chunks)
        for name, more in color.items():
            write_png(tmp_path / "c_n.png", **how, chunks=[chunks[0], *more, *chunks[1:]])
            with open(tmp_path / "c_n.png", "ab") as file:
                file.write(b"gAMA after the end")
            assert run("clean", "c_n.png", "-o", "c.png").returncode == 0
            got = (tmp_path / "c.png").read_bytes()
            assert got == want + b"gAMA after the end", (kind, name)
    # What is asked for is written anew; and so is what changes, in its last texel too.
    late = picture.copy()
    late[-1, -1] = (128, 128, 100)
    write_png(tmp_path / "late_n.png", late, chunks=chunks)
    write_png(tmp_path / "gray.png", np.full((8, 8), 128, np.uint8))
    for name, args in (("a_n", ["--level", "6"]), ("late_n", []), ("gray", [])):
        assert run("clean", f"{name}.png", "-o", "g.png", *args).returncode == 0, name
        got, kept = read_png(tmp_path / "g.png")
        assert b"prVt" not in kept and b"gAMA" not in kept and got.shape[2] == 3, name
        assert name != "a_n" or np.array_equal(got, picture)
    assert run("clean", "a_n.png", "-o", "h.tga").returncode == 0
    assert (tmp_path / "h.tga").read_bytes()[:4] != data[:4]


def test_tga(run, tmp_path):
    before = noisy()
    (tmp_path / "a_n.tga").write_bytes(tga_bytes(before))
    write_png(tmp_path / "a_n.png", before)
    assert run("clean", ".", "-o", "d").returncode == 0
    assert sorted(p.name for p in (tmp_path / "d").iterdir()) == ["a_n.png", "a_n.tga.png"]
    one, two = (pixels_of(tmp_path / "d" / n) for n in ("a_n.png", "a_n.tga.png"))
    assert np.array_equal(one, two)
    assert run("clean", "a_n.tga", "-o", "e/").returncode == 0
    assert (tmp_path / "e/a_n.png").exists()
    assert run("clean", "a_n.tga", "-o", "b.tga").returncode == 0
    assert run("diff", "b.tga", "d/a_n.png").returncode == 0
    write_png(tmp_path / "deep_n.png", textures.standard(depth=16))
    assert run("clean", "deep_n.png", "-o", "c.tga").returncode in (2, 3)
    assert not (tmp_path / "c.tga").exists()


def test_flip_keeps_unused(run, tmp_path):
    before = textures.standard()
    before[:4] = 0
    before[4:6] = 255
    write_png(tmp_path / "a.png", before)
    assert run("convert", "a.png", "-o", "b.png", "--from-y", "down").returncode == 0
    after = pixels_of(tmp_path / "b.png")
    assert (after[:4] == 0).all() and (after[4:6] == 255).all()
    assert np.array_equal(after[6:, :, 1], 255 - before[6:, :, 1])
    assert np.array_equal(after[6:, :, ::2], before[6:, :, ::2])
    assert run("convert", "b.png", "-o", "c.png", "--y", "up", "--to-y", "down").returncode == 0
    assert np.array_equal(pixels_of(tmp_path / "c.png"), before)


def test_depth_and_encoding_round_trip(run, tmp_path):
    before = noisy()
    before[..., 2] |= 128
    write_png(tmp_path / "a.png", before)
    assert run("convert", "a.png", "-o", "b.png", "--depth", "16").returncode == 0
    assert pixels_of(tmp_path / "b.png").dtype == np.uint16
    assert run("convert", "b.png", "-o", "c.png", "--depth", "8").returncode == 0
    assert np.array_equal(pixels_of(tmp_path / "c.png"), before)
    clean = textures.standard()
    write_png(tmp_path / "s.png", clean)
    run("convert", "s.png", "-o", "z.png", "--to", "zzero")
    run("convert", "z.png", "-o", "t.png", "--from", "zzero")
    assert np.array_equal(pixels_of(tmp_path / "t.png"), clean)
    run("convert", "s.png", "-o", "xy.png", "--to", "xy")
    assert (pixels_of(tmp_path / "xy.png")[..., 2] == 255).all()
    run("convert", "xy.png", "-o", "u.png", "--from", "xy")
    assert np.array_equal(pixels_of(tmp_path / "u.png"), clean)


def test_channels(run, tmp_path):
    clean = textures.standard()
    write_png(tmp_path / "s.png", clean)
    assert run("convert", "s.png", "-o", "d.png", "--channels", "1y0x").returncode == 0
    packed = pixels_of(tmp_path / "d.png")
    assert (packed[..., 0] == 255).all() and (packed[..., 2] == 0).all()
    assert np.array_equal(packed[..., 1], clean[..., 1])
    assert np.array_equal(packed[..., 3], clean[..., 0])
    args = ["convert", "d.png", "-o", "e.png", "--from-channels", "-y-x", "--channels", "xyz"]
    assert run(*args).returncode == 0
    assert np.array_equal(pixels_of(tmp_path / "e.png"), clean)
    assert run("convert", "s.png", "-o", "f.png", "--channels", "xy").returncode == 0
    assert pixels_of(tmp_path / "f.png").shape[2] == 2
    run("convert", "s.png", "-o", "g.png", "--channels", "xzy")
    assert np.array_equal(pixels_of(tmp_path / "g.png"), clean[..., [0, 2, 1]])
    for spec in ("xyq", "", "xyzxy", "xh"):
        assert run("convert", "s.png", "-o", "x.png", "--channels", spec).returncode == 2
    for spec in ("x-", "xx", "xyzzz", "q"):
        assert run("convert", "s.png", "-o", "x.png", "--from-channels", spec).returncode == 2
    done = run("convert", "s.png", "-o", "x.png", "--from-channels", "--yx")
    assert done.returncode == 2 and not (tmp_path / "x.png").exists()


def test_two_channels(run, tmp_path):
    texture = textures.standard()
    write_png(tmp_path / "a_n.png", texture)
    assert run("convert", "a_n.png", "-o", "xy_n.png", "--channels", "xy").returncode == 0
    done = run("check", "xy_n.png", "-v")
    assert done.returncode == 0 and "NT006" in done.stdout and "NT012" not in done.stdout
    run("convert", "xy_n.png", "-o", "back.png", "--from-channels", "xy")
    assert np.array_equal(pixels_of(tmp_path / "back.png"), texture)


def test_convert_says_when_the_input_looks_different(run, tmp_path):
    write_png(tmp_path / "z.png", textures.zzero())
    done = run("convert", "z.png", "-o", "b.png", "--type", "standard")
    assert "looks Z-zero" in done.stdout


def test_gray_depth(run, tmp_path):
    write_png(tmp_path / "h.png", textures.heights())
    assert run("convert", "h.png", "-o", "i.png", "--depth", "16").returncode == 0
    assert np.array_equal(
        pixels_of(tmp_path / "i.png")[..., 0], textures.heights().astype(np.uint16) * 257
    )
    assert run("convert", "h.png", "-o", "j.png", "--to", "xy").returncode == 1
    write_png(tmp_path / "p.png", textures.photograph())
    assert run("convert", "p.png", "-o", "q.png", "--depth", "16").returncode == 1
    args = ["convert", "p.png", "-o", "q.png", "--type", "height"]
    assert run(*args, "--depth", "16").returncode == 0
    assert np.array_equal(pixels_of(tmp_path / "q.png"), textures.photograph().astype(int) * 257)
    for more in (["--to", "xy"], ["--y", "down"], ["--channels", "xyz"]):
        assert run(*args, *more).returncode == 2, more


def test_heatmap(run, tmp_path):
    before = textures.standard()
    before[5, 5] = (255, 128, 255)  # x, y too long
    before[9, 9, 2] -= 60  # too short
    write_png(tmp_path / "a_n.png", before)
    assert run("heatmap", "a_n.png", "-o", "h.png").returncode == 0
    heat = pixels_of(tmp_path / "h.png").astype(int)
    gray = (heat[..., 0] == heat[..., 1]) & (heat[..., 1] == heat[..., 2])
    assert not gray[5, 5] and not gray[9, 9] and np.count_nonzero(~gray) == 2
    assert heat[5, 5, 0] > heat[5, 5, 2] and heat[9, 9, 1] > heat[9, 9, 0]
    assert run("heatmap", "a_n.png", "-o", "s.png", "--palette", "safe").returncode == 0
    assert not np.array_equal(pixels_of(tmp_path / "s.png"), heat)


def words(size=256):
    """Texels of few colors in words that come again and again, as painted or tiled maps have them."""
    rng = np.random.default_rng(5)
    colors = rng.integers(0, 256, (60, 3), dtype=np.uint8)
    some = [rng.integers(0, 60, rng.integers(2, 9)) for _ in range(1000)]
    texels = np.concatenate([some[i] for i in rng.integers(0, 1000, size * size)])
    return colors[texels[: size * size].reshape(size, size)]


@pytest.mark.parametrize("pains", [9, 6])
def test_beside_a_file_that_was_packed_hard(run, tmp_path, pains):
    picture = words()
    rows = b"".join(b"\0" + row.tobytes() for row in picture)
    head = struct.pack(">IIBBBBB", *picture.shape[1::-1], 8, 2, 0, 0, 0)
    # Packed the same way; only the stream's second byte says at which level.
    packed = b"\x78" + (b"\xda" if pains == 9 else b"\x9c") + zlib.compress(rows, 9)[2:]
    data = b"\x89PNG\r\n\x1a\n"
    for name, body in ((b"IHDR", head), (b"IDAT", packed), (b"IEND", b"")):
        data += struct.pack(">I", len(body)) + name + body
        data += struct.pack(">I", zlib.crc32(name + body))
    path = tmp_path / "in.png"
    path.write_bytes(data)
    made = []
    ways = ((), ("--max-at-once", "0"), ("--jobs", "3"), ("--level", "6"))
    for i, way in enumerate(ways):
        out = tmp_path / f"{i}.png"
        run("convert", path, "--force", "--type", "standard", *way, "-o", out)
        assert (pixels_of(out) == picture).all()
        made.append(out.read_bytes())
    assert made[0] == made[1] == made[2]
    assert len(made[3]) > 1.02 * len(data)  # or this picture tells nothing
    assert (len(made[0]) <= 1.02 * len(data)) == (pains == 9)
    assert (made[0] == made[3]) == (pains == 6)  # such a file says nothing about pains
