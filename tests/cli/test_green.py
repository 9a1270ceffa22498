# SPDX-License-Identifier: MIT
"""Which way green points: used where sure, asked for where it matters, and never guessed.

The surfaces and their normals are made here, by numpy alone.
"""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from support.pngs import read_png, write_png


def bumps(h=128, w=128, seed=1):
    """Heights, in texels, of round bumps and dents."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:h, :w].astype(float)
    out = np.zeros((h, w))
    for _ in range(h * w // 300):
        cy, cx, size = rng.uniform(0, h), rng.uniform(0, w), rng.uniform(4, 10)
        out += rng.choice([-1, 1]) * size / 2 * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / size**2)
    return out


def encode(p, q, depth=8):
    """The texture of slopes to the right and up the picture, green up."""
    m = 255 if depth == 8 else 65535
    n = np.dstack([-p, -q, np.ones_like(p)]) / np.sqrt(p * p + q * q + 1)[..., None]
    return np.floor((n + 1) / 2 * m + 0.5).astype(np.uint8 if depth == 8 else np.uint16)


def opengl(heights, depth=8):
    down, right = np.gradient(heights)
    return encode(right, -down, depth)


def directx(heights, depth=8):
    down, right = np.gradient(heights)
    return encode(right, down, depth)


def tiny(h=16, w=16):
    """Too small to tell, and not flat."""
    return opengl(bumps(64, 64, 5)[:h, :w])


def angle(a, b):
    """The mean angle between two textures, in degrees."""
    a, b = (t[..., :3].astype(float) / np.iinfo(t.dtype).max * 2 - 1 for t in (a, b))
    a, b = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (a, b))
    return np.degrees(np.arccos(np.clip((a * b).sum(-1), -1, 1))).mean()


def item(done, code=0):
    assert done.returncode == code, (done.stdout, done.stderr)
    (one,) = json.loads(done.stdout)["files"]
    return one


def pixels_of(path):
    return read_png(path)[0]


MAKERS = {"up": opengl, "down": directx}
ASKS = "--y up (OpenGL) or --y down (DirectX)?"


# ------------------------------------------------------------------------- transform


@pytest.mark.parametrize("depth", [8, 16])
@pytest.mark.parametrize("turns", [1, 3])
@pytest.mark.parametrize("y", MAKERS)
def test_a_turned_texture_is_that_of_the_turned_surface(run, tmp_path, y, turns, depth):
    heights = bumps()
    write_png(tmp_path / "a.png", MAKERS[y](heights, depth))
    args = ["transform", "a.png", "-o", "b.png", "--rotate", 90 * turns]
    one = item(run(*args, "--format", "json"))
    assert (one["y"], one["y_by"]) == (y, "texels") and one["y_confidence"] >= 0.9
    want = MAKERS[y](np.rot90(heights, -turns), depth)
    assert angle(pixels_of(tmp_path / "b.png"), want) < 0.5
    assert f"green points {y}" in run(*args).stdout
    by_option = item(run(*args, "--y", "opengl", "--format", "json"))
    assert (by_option["y"], by_option["y_by"], by_option["y_confidence"]) == ("up", "option", 1)


@pytest.mark.parametrize("how", [
    ["--flip", "x"], ["--flip", "y"], ["--flip", "xy"], ["--rotate", "180"], ["--strength", "2"],
    ["--strength", "-0.5"], ["--flip", "x", "--rotate", "180", "--strength", "-3"],
])  # fmt: skip
def test_other_transforms_do_not_ask(run, tmp_path, how):
    """The bytes are the same for both, so there is nothing to ask."""
    write_png(tmp_path / "a_n.png", tiny())
    one = item(run("transform", "a_n.png", "-o", "b.png", *how, "--format", "json"))
    assert (one["y"], one["y_by"], one["y_confidence"]) == (None, "unneeded", 0)
    for y in ("up", "down"):
        assert run("transform", "a_n.png", "-o", f"{y}.png", *how, "--y", y).returncode == 0
        assert (tmp_path / f"{y}.png").read_bytes() == (tmp_path / "b.png").read_bytes()


@pytest.mark.parametrize("angle", ["90", "-12.5"])
def test_a_turn_asks(run, tmp_path, angle):
    write_png(tmp_path / "a_n.png", tiny())
    args = ["transform", "a_n.png", "-o", "b.png", "--rotate", angle]
    done = run(*args)
    assert done.returncode == 1 and ASKS in done.stderr and not (tmp_path / "b.png").exists()
    assert run(*args, "--force").returncode == 1  # it says what to write, not which way
    assert item(run(*args, "--format", "json"), 1)["status"] == "refused"
    for y in MAKERS:
        assert run(*args, "--y", y).returncode == 0


def with_unused(texture, depth):
    out = np.dstack([texture, np.full(texture.shape[:2], np.iinfo(texture.dtype).max)])
    out[:3] = 0
    out[3:5] = np.iinfo(texture.dtype).max
    out[5:7, :, :3], out[5:7, :, 3] = np.array((9, 250, 90)) * (257 if depth == 816 else 1), 0
    return out.astype(texture.dtype)


@pytest.mark.parametrize("depth", [8, 16, 816])
def test_flat_textures_turn_without_asking(run, tmp_path, depth):
    """Both levels in the middle are flat; what is unused has no direction."""
    rng = np.random.default_rng(3)
    middle = [32767, 32768] if depth == 16 else [127, 128]
    flat = np.full((20, 24, 3), 65535 if depth == 16 else 255)
    flat[..., :2] = rng.choice(middle, (20, 24, 2))
    flat = flat.astype(np.uint8 if depth == 8 else np.uint16) * (257 if depth == 816 else 1)
    args = ["transform", "a_n.png", "-o", "b.png", "--rotate", "90", "--type", "standard"]
    for texture in (flat, with_unused(flat, depth)):
        write_png(tmp_path / "a_n.png", texture)
        assert item(run(*args, "--format", "json"))["y_by"] == "unneeded"
        for channel in (0, 1):
            tilted = texture.copy()
            tilted[15, 11, channel] = 129 * (257 if depth == 816 else 1) if depth != 16 else 32769
            write_png(tmp_path / "a_n.png", tilted)
            done = run(*args)
            assert done.returncode == 1 and ASKS in done.stderr


def test_a_name_that_contradicts_the_texels_is_asked_about(run, tmp_path):
    write_png(tmp_path / "wall_dx.png", opengl(bumps()))
    write_png(tmp_path / "wall_gl.png", opengl(bumps()))
    done = run("transform", "wall_dx.png", "-o", "b.png", "--rotate", "90")
    assert done.returncode == 1 and "but its name says DirectX" in done.stderr
    assert "its texels look like OpenGL (Y up), 9" in done.stderr
    assert run("transform", "wall_gl.png", "-o", "b.png", "--rotate", "90").returncode == 0


# ----------------------------------------------------------------------------- blend


@pytest.mark.parametrize("base", MAKERS)
@pytest.mark.parametrize("detail", MAKERS)
def test_blend_turns_the_detail_to_the_base(run, tmp_path, base, detail):
    """Heights add up, nearly: slopes do, with udn, in the green of the base."""
    a, d = bumps(seed=1), bumps(seed=2) / 4
    write_png(tmp_path / "a.png", MAKERS[base](a))
    write_png(tmp_path / "d.png", MAKERS[detail](d))
    args = ["blend", "a.png", "d.png", "-o", "b.png"]
    one = item(run(*args, "--format", "json"))
    assert (one["y"], one["y_by"]) == (base, "texels")
    assert (one["detail_y"], one["detail_y_by"]) == (detail, "texels")
    sum_of_both = MAKERS[base](a + d)
    assert angle(pixels_of(tmp_path / "b.png"), sum_of_both) < 2
    wrong = "down" if detail == "up" else "up"
    run(*args[:-1], "w.png", "--detail-y", wrong)
    assert angle(pixels_of(tmp_path / "w.png"), sum_of_both) > 5
    if (base, detail) == ("up", "down"):
        text = run(*args).stdout
        assert "green of BASE points up" in text and "green of DETAIL points down" in text


def test_blend_asks(run, tmp_path):
    write_png(tmp_path / "known.png", directx(bumps()))
    write_png(tmp_path / "small_n.png", tiny())
    flat = np.full((16, 16, 3), (128, 128, 255), np.uint8)
    write_png(tmp_path / "flat_n.png", flat)
    across = np.repeat(tiny()[:1], 16, 0)
    across[..., 1] = 127
    write_png(tmp_path / "across_n.png", across)

    def blended(base, detail, *more):
        (tmp_path / "b.png").unlink(missing_ok=True)
        return run("blend", f"{base}.png", f"{detail}.png", "-o", "b.png", *more)

    for base, detail, more, words in (
        ("known", "small_n", (), "--detail-y up (OpenGL) or --detail-y down (DirectX)?"),
        ("small_n", "known", (), ASKS),
        ("small_n", "small_n", (), "--detail-y says it of DETAIL"),
        ("small_n", "small_n", ("--y", "up"), "--detail-y up"),
        ("small_n", "small_n", ("--detail-y", "up"), ASKS),
    ):
        done = blended(base, detail, *more)
        assert done.returncode == 1 and words in done.stderr, (base, detail)
        assert not (tmp_path / "b.png").exists()
    for base, detail, more in (
        ("small_n", "small_n", ("--y", "up", "--detail-y", "down")),
        ("flat_n", "small_n", ()),  # takes the green of the detail, whichever it is
        ("small_n", "flat_n", ()),
        ("small_n", "across_n", ()),  # a detail without y is that of both
        ("across_n", "small_n", ()),
        ("small_n", "small_n", ("--strength", "0")),
    ):
        done = blended(base, detail, *more)
        assert done.returncode == 0, (base, detail, done.stderr)
    blended("flat_n", "small_n")
    assert angle(pixels_of(tmp_path / "b.png"), tiny()) < 0.6


# --------------------------------------------------------------------------- convert


@pytest.mark.parametrize("depth", [8, 16])
@pytest.mark.parametrize("wanted", [("up", "opengl"), ("down", "directx")])
@pytest.mark.parametrize("y", MAKERS)
def test_convert_turns_green_where_it_must(run, tmp_path, y, wanted, depth):
    """M - g or g, and nothing else changes: not even errors."""
    before = MAKERS[y](bumps(), depth)
    before[60, 60] = 0
    before[61, 61, 2] //= 2
    write_png(tmp_path / "a.png", before)
    for word in wanted:
        done = run("convert", "a.png", "-o", "b.png", "--to-y", word, "--format", "json")
        one = item(done)
        assert (one["from_y"], one["from_y_by"], one["to_y"]) == (y, "texels", wanted[0])
        want = before.copy()
        if y != wanted[0]:
            want[..., 1] = np.iinfo(before.dtype).max - want[..., 1]
            want[60, 60] = 0
        assert np.array_equal(pixels_of(tmp_path / "b.png"), want)
    text = run("convert", "a.png", "-o", "b.png", "--to-y", wanted[0]).stdout
    words = f"already {y}" if y == wanted[0] else f"from {y} to {wanted[0]}"
    assert f"green {words} (9" in text and " % sure)" in text


def test_convert_keeps_what_is_not_asked_for(run, tmp_path):
    """Green, and the encoding: also one that has something else in blue."""
    before = directx(bumps())
    r, g = (before[..., i].astype(int) * 2 - 255 for i in (0, 1))
    left = np.sqrt(np.maximum(255 * 255 - r * r - g * g, 0))
    zzero = np.dstack([before[..., :2], np.floor(left + 0.5)]).astype(np.uint8)
    y, x = np.mgrid[:128, :128]
    xy = np.dstack([before[..., :2], (x * 7 + y * 3) % 256]).astype(np.uint8)
    for name, texture in (("standard", before), ("zzero", zzero), ("xy", xy)):
        write_png(tmp_path / "a_n.png", texture)
        one = item(run("convert", "a_n.png", "-o", "b.png", "--format", "json"))
        assert (one["from"], one["to"], one["from_y"], one["to_y"]) == (name, name, None, None)
        assert np.array_equal(pixels_of(tmp_path / "b.png"), texture)
        assert (
            item(run("convert", "a_n.png", "-o", "b.png", "--to-y", "up", "--format", "json"))["to"]
            == name
        )
        want = texture.copy()
        want[..., 1] = 255 - want[..., 1]
        assert np.array_equal(pixels_of(tmp_path / "b.png"), want)
    assert run("convert", "a_n.png", "-o", "b.png", "--depth", "16").returncode == 0
    assert np.array_equal(pixels_of(tmp_path / "b.png")[..., 2], xy[..., 2] * np.uint16(257))


def test_convert_by_option_is_as_it_was(run, tmp_path):
    """--y alone turns to up, --type alone to standard."""
    before = directx(bumps())
    write_png(tmp_path / "a.png", before)
    assert run("convert", "a.png", "-o", "b.png", "--y", "down").returncode == 0
    want = before.copy()
    want[..., 1] = 255 - want[..., 1]
    assert np.array_equal(pixels_of(tmp_path / "b.png"), want)
    one = item(run("convert", "a.png", "-o", "b.png", "--type", "zzero", "--format", "json"))
    assert (one["from"], one["to"]) == ("zzero", "standard")


def test_convert_asks(run, tmp_path):
    write_png(tmp_path / "a_n.png", tiny())
    args = ["convert", "a_n.png", "-o", "b.png"]
    done = run(*args, "--to-y", "up")
    assert done.returncode == 1 and ASKS in done.stderr and not (tmp_path / "b.png").exists()
    assert run(*args, "--depth", "16").returncode == 0  # which needs no green
    assert run(*args, "--to-y", "up", "--y", "up").returncode == 0
    assert np.array_equal(pixels_of(tmp_path / "b.png"), tiny())
    done = run(*args, "--to-y", "up", "--from-channels", "xyz")
    assert done.returncode == 2 and "--from-channels needs --y" in done.stderr


def test_convert_asks_about_types(run, tmp_path):
    """Only where it makes a difference: nearly flat, both readings of blue fit."""
    gentle = opengl(bumps() / 40)
    write_png(tmp_path / "a_n.png", gentle)
    (checked,) = json.loads(run("check", "a_n.png", "--format", "json").stdout)["files"]
    assert checked["confidence"] < 0.9
    args = ["convert", "a_n.png", "-o", "b.png"]
    done = run(*args, "--to", "zzero")
    assert done.returncode == 1 and "--type standard, zzero or xy?" in done.stderr
    assert not (tmp_path / "b.png").exists()
    assert run(*args, "--to", "zzero", "--type", "standard").returncode == 0
    assert run(*args, "--to-y", "down", "--y", "up").returncode == 0
    want = gentle.copy()
    want[..., 1] = 255 - want[..., 1]
    assert np.array_equal(pixels_of(tmp_path / "b.png"), want)


# ------------------------------------------------------------------------ whole trees


def atlas(make):
    """Charts of one surface on black, with a gap between them."""
    out = np.zeros((256, 256, 3), np.uint8)
    for i in range(4):
        top, left = 128 * (i // 2) + 8, 128 * (i % 2) + 8
        out[top : top + 112, left : left + 112] = make(bumps(112, 112, 20 + i))
    return out


def tree():
    """{name: (image, the green of the input or None, is it known)}"""
    rng = np.random.default_rng(11)
    y, x = np.mgrid[:128, :128].astype(float)
    flat = np.full((32, 32, 3), (128, 128, 255), np.uint8)
    stripes = encode(np.zeros((64, 64)), np.sin(y[:64, :64] / 3))
    gray = np.floor(127.5 + 20 * bumps(seed=3) / 8).clip(0, 255).astype(np.uint8)
    photo = np.dstack([np.sin(x / 9 + i) * 60 + np.sin(y / (7 + i)) * 50 + 128 for i in range(3)])
    photo = (photo + rng.normal(0, 12, photo.shape)).clip(0, 255).astype(np.uint8)
    return {
        "wall/gl_n.png": (opengl(bumps(seed=1)), "up"),
        "wall/dx_n.png": (directx(bumps(seed=2)), "down"),
        "wall/deep/dx16_n.png": (directx(bumps(seed=4), 16), "down"),
        "wall/deep/gl16_normal.png": (opengl(bumps(seed=5), 16), "up"),
        "wall/unhinted.png": (directx(bumps(seed=6)), "down"),
        "atlas/gl_n.png": (atlas(opengl), "up"),
        "atlas/dx_n.png": (atlas(directx), "down"),
        "flat_n.png": (flat, "flat"),
        "tiny_n.png": (tiny(), None),
        "stripes_n.png": (stripes, None),
        "noise_n.png": (encode(*rng.normal(0, 0.3, (2, 64, 64))), None),
        "wrong_dx.png": (opengl(bumps(seed=7)), None),  # the name says otherwise
        "height.png": (gray, "other"),
        "photo.png": (photo, "other"),
    }


def written_tree(folder):
    images = tree()
    for name, (image, _) in images.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        write_png(folder / name, image)
    return images


def turned(image):
    out = image.copy()
    unused = (image == 0).all(-1)
    out[..., 1] = np.iinfo(image.dtype).max - out[..., 1]
    out[unused] = 0
    return out


@pytest.mark.parametrize("in_place", [False, True])
@pytest.mark.parametrize("wanted", ["up", "down"])
def test_a_whole_tree(run, tmp_path, wanted, in_place):
    """Turned, copied, or named and left alone: never turned wrongly."""
    images = written_tree(tmp_path / "t")
    before = {name: (tmp_path / "t" / name).read_bytes() for name in images}
    where = ["--in-place"] if in_place else ["-o", "out"]
    done = run("convert", "-r", "t", "--to-y", wanted, *where)
    assert done.returncode == 1, done.stderr
    found = tmp_path / ("t" if in_place else "out")
    for name, (image, y) in images.items():
        if y == "other" or y is None:
            assert (tmp_path / "t" / name).read_bytes() == before[name], name
            assert in_place or not (found / name).exists(), name
            assert (f"t/{name}: " in done.stderr) == (y is None), name
            continue
        same = y in (wanted, "flat")
        if in_place and same:
            assert (found / name).read_bytes() == before[name], name
        want = image if same else turned(image)
        assert np.array_equal(pixels_of(found / name), want.reshape(pixels_of(found / name).shape))
        assert in_place or (tmp_path / "t" / name).read_bytes() == before[name], name
    refused = sum(y is None for _, y in images.values())
    assert f"{refused} refused" in done.stdout
    # What was asked about is said for each, and twice turned is as it was.
    if not in_place:
        again = run("convert", "-r", "t", "--to-y", wanted, "--y", wanted, "-o", "out2")
        assert again.returncode == 0, again.stderr
        for name, (image, y) in images.items():
            if y is None:
                assert np.array_equal(pixels_of(tmp_path / "out2" / name), image)


# ---------------------------------------------------------------------------- corpus


def test_no_file_of_the_corpus_is_turned_wrongly(run, corpus):
    """Of those whose green the manifest says, and no doubt about it.

    One is taken for the other kind, and its label may be wrong: its rings are bevels only with green
    down.
    """
    with (corpus / "manifest.csv").open(newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if "suspect" not in row["note"]]
    says = {
        row["file"]: {"OpenGL": "up", "DirectX": "down"}.get(row["orientation"]) for row in rows
    }
    done = run("convert", "-r", corpus, "--to-y", "up", "-n", "--format", "json")
    files = {str(Path(one["path"]).relative_to(corpus)): one
             for one in json.loads(done.stdout)["files"]}  # fmt: skip
    taken = {name: one["from_y"] for name, one in files.items()
             if one["status"] == "ok" and one["from_y_by"] == "texels" and says.get(name)}  # fmt: skip
    wrong = {name for name, y in taken.items() if y != says[name]}
    assert wrong <= {"glTF-Sample-Assets-OLD/StainedGlassLamp_hardware_normal.png"}
    assert len(taken) >= 16
    refused = [one["message"] for one in files.values() if one["status"] == "refused"]
    asked = [said for said in refused if "it is packed as DXT5nm" not in said]
    assert all("--y up (OpenGL) or --y down (DirectX)?" in said for said in asked)
