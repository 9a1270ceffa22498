# SPDX-License-Identifier: MIT
"""ntp to-height: round trips through the program, choices, options, refusals, bad input."""

import json
import os
import pty
import re
import select
import shlex
import signal
import struct
import subprocess

import numpy as np
import pytest

from support import schemas, textures
from support import to_height as reconstruction
from support.pngs import chunk, read_png, write_png
from support.spawn import spawn, start

KERNELS = ["central", "forward", "prewitt3", "sobel3", "scharr3"]
BORDERS = ["wrap", "clamp", "mirror"]
MADE = [(k, b) for k in KERNELS for b in BORDERS]
MADE += [("central", "extrapolate"), ("forward", "extrapolate")]


def to_height(run, *args, code=0):
    """The objects of the files."""
    done = run("to-height", *args, "--format", "json")
    assert done.returncode == code, done.stderr
    report = json.loads(done.stdout)
    schemas.validate(report, "to-height-1")
    return report["files"]


def only(run, *args, code=0):
    (file,) = to_height(run, *args, code=code)
    return file


def texts(path):
    """{key: value} of the tEXt chunks; a key that comes twice fails."""
    _, chunks = read_png(path)
    pairs = [body.split(b"\0", 1) for body in chunks.get(b"tEXt", [])]
    out = {key.decode(): value.decode() for key, value in pairs}
    assert len(out) == len(pairs)
    return out


def write_pfm(path, pixels):
    h, w = pixels.shape[:2]
    kind = b"PF" if pixels.ndim == 3 else b"Pf"
    with open(path, "wb") as file:
        file.write(b"%s\n%d %d\n-1.0\n" % (kind, w, h))
        file.write(pixels[::-1].astype("<f4").tobytes())


def read_pfm(path):
    data = path.read_bytes()
    kind, size, _, rest = data.split(b"\n", 3)
    assert kind == b"Pf"
    w, h = map(int, size.split())
    return np.frombuffer(rest, "<f4").reshape(h, w)[::-1]


@pytest.fixture
def surface(tmp_path):
    """h.png, 16 bit, of a surface that tiles; 60 texels high."""
    h = reconstruction.fractal(128)
    h = (h - h.min()) / np.ptp(h)
    write_png(tmp_path / "h.png", np.round(h * 65535).astype(np.uint16))
    return h * 40


def make_normals(run, *args):
    done = run("from-height", "h.png", "-o", "n.png", "--scale", 40, *args)
    assert done.returncode == 0, done.stderr


def settings_of(file):
    return [
        *("--scale", file["scale"], "--kernel", file["kernel"], "--to-y", file["y"]),
        *("--border-x", file["border_x"], "--border-y", file["border_y"]),
    ]


# ------------------------------------------------------------------------------ round trips


@pytest.mark.parametrize("depth", [8, 16])
@pytest.mark.parametrize(("kernel", "border"), MADE)
def test_round_trip_with_everything_auto(run, tmp_path, surface, kernel, border, depth):
    """The settings of from-height are detected, and using them again gives the same normals."""
    make_normals(run, "--kernel", kernel, "--border", border, "--depth", depth)
    file = only(run, "n.png", "-o", "back.png")
    assert file["kernel"] == kernel and file["y"] == "up" and file["kernel_by"] == "texels"
    assert (file["border_x"], file["border_y"]) == (border, border)
    assert file["depth"] == 16 and file["islands"] == 1 and file["written"]
    again = run("from-height", "back.png", "-o", "again.png", "--depth", depth, *settings_of(file))
    assert again.returncode == 0, again.stderr
    one, two = (read_png(tmp_path / name)[0].astype(int) for name in ("n.png", "again.png"))
    off = np.abs(one - two)[..., :2]
    if depth == 8:
        assert off.max() <= 1 and np.mean(off.max(-1) > 0) < 0.1
    else:  # heights of 16 bit, 40 texels high: steps of 1/1638 texel
        assert off.max() <= 65535 * 2 * 40 / 65535
    heights = read_png(tmp_path / "back.png")[0][..., 0] / 65535 * file["scale"] + file["offset"]
    assert np.std(heights - surface) < (0.03 if depth == 8 else 0.005)


def test_identity_up_to_quantization(run, tmp_path, surface):
    """Heights made by to-height are reproduced."""
    make_normals(run, "--depth", 16)
    first = only(run, "n.png", "-o", "one.png", "--border", "wrap")
    run("from-height", "one.png", "-o", "n2.png", "--depth", 16, *settings_of(first))
    second = only(run, "n2.png", "-o", "two.png", "--border", "wrap")
    one, two = (read_png(tmp_path / name)[0].astype(int) for name in ("one.png", "two.png"))
    assert second["scale"] == pytest.approx(first["scale"], rel=1e-4)
    assert np.abs(one - two).max() <= 6


def test_through_pipes(program, run, tmp_path, surface):
    make_normals(run)
    file = only(run, "n.png", "-o", "back.png")
    again = ["from-height", "-", "-o", "-", *map(str, settings_of(file)), "--depth", "8"]
    ntp = shlex.quote(str(program))
    pipe = f"{ntp} to-height - -o - < n.png | {ntp} {shlex.join(again)} > piped.png"
    done = spawn(["bash", "-o", "pipefail", "-c", pipe], cwd=tmp_path, text=True)
    assert done.returncode == 0, done.stderr
    assert f"scale {file['scale']:.9g}" in done.stderr  # results go to standard error then
    run("from-height", "back.png", "-o", "again.png", *again[4:])
    assert (tmp_path / "piped.png").read_bytes() == (tmp_path / "again.png").read_bytes()
    with open(tmp_path / "n.png", "rb") as file:
        done = spawn([program, "to-height", "-", "-o", "-"], stdin=file)
    assert done.stdout == (tmp_path / "back.png").read_bytes()


def test_scale_is_recorded_once(run, tmp_path, surface):
    make_normals(run)
    text = run("to-height", "n.png", "-o", "back.png")
    file = only(run, "n.png", "-o", "back.png")
    assert texts(tmp_path / "back.png") == {
        "Height scale": f"{file['scale']:.9g}",
        "Height offset": f"{file['offset']:.9g}",
    }
    assert f"scale {file['scale']:.9g}, offset {file['offset']:.9g}" in text.stdout
    # The texts travel to the normals of these heights, and are replaced on the way back.
    run("from-height", "back.png", "-o", "n2.png", "--scale", 3)
    assert "Height scale" in texts(tmp_path / "n2.png")
    file = only(run, "n2.png", "-o", "back2.png")
    assert texts(tmp_path / "back2.png")["Height scale"] == f"{file['scale']:.9g}"


def test_other_texts_and_phys_are_kept(run, tmp_path):
    n = textures.standard()
    chunks = [(b"tEXt", b"Author\0A. Mason"), (b"pHYs", struct.pack(">IIB", 2, 2, 1))]
    write_png(tmp_path / "n.png", n, chunks=[*chunks, (b"gAMA", struct.pack(">I", 45455))])
    data = (tmp_path / "n.png").read_bytes()
    late = chunk(b"tEXt", b"Comment\0late") + data[-12:]
    (tmp_path / "n.png").write_bytes(data[:-12] + late)
    file = only(run, "n.png", "-o", "h.png")
    found = texts(tmp_path / "h.png")
    assert found["Author"] == "A. Mason" and found["Comment"] == "late" and len(found) == 4
    assert b"pHYs" in read_png(tmp_path / "h.png")[1] and file["dropped"] == ["gAMA"]


# --------------------------------------------------------------------------------- choices


@pytest.mark.parametrize("y", ["up", "down"])
def test_green(run, tmp_path, surface, y):
    make_normals(run, "--to-y", y)
    file = only(run, "n.png", "-o", "h1.png")
    assert (file["y"], file["y_by"]) == (y, "texels") and file["y_confidence"] > 0.8
    other = {"up": "down", "down": "up"}[y]
    file = only(run, "n.png", "-o", "h2.png", "--y", other)
    assert (file["y"], file["y_by"], file["y_confidence"]) == (other, "option", 1)
    assert file["residual_levels"] > 5  # and it does not fit


def test_green_is_asked_for(run, tmp_path):
    """Also where the name says it: a name is no evidence of what the texels are."""
    y, _ = np.mgrid[:64, :64]
    stripes = (4 * np.sin(2 * np.pi * y / 16)).astype(np.float32)  # which do not tell
    n = reconstruction.from_height(stripes)
    for name in ("a_dx.png", "a_n.png"):
        write_png(tmp_path / name, n)
        done = run("to-height", name, "-o", "h.png")
        assert done.returncode == 1 and not (tmp_path / "h.png").exists()
        assert "--y up (OpenGL) or --y down (DirectX)?" in done.stderr
        assert ("its name says DirectX" in done.stderr) == (name == "a_dx.png")
    file = only(run, "a_dx.png", "-o", "h.png", "--y", "down")
    assert (file["y"], file["y_by"], file["y_confidence"]) == ("down", "option", 1)


def test_green_is_not_asked_for_where_nothing_slopes_up_or_down(run, tmp_path):
    write_png(
        tmp_path / "n.png",
        reconstruction.from_height(
            np.tile(4 * np.sin(2 * np.pi * np.arange(64) / 16), (64, 1)).astype(np.float32)
        ),
    )
    file = only(run, "n.png", "-o", "h.png")
    assert (file["y"], file["y_by"], file["y_confidence"]) == ("up", "unneeded", 0)
    up = read_png(tmp_path / "h.png")[0].astype(int)
    only(run, "n.png", "-o", "h.png", "--y", "down")
    assert np.abs(read_png(tmp_path / "h.png")[0].astype(int) - up).max() < 65536 / 8 / 20


def test_borders_by_axis(run, surface):
    make_normals(run, "--border-x", "clamp", "--border-y", "wrap")
    file = only(run, "n.png", "-o", "back.png")
    assert (file["border_x"], file["border_y"]) == ("clamp", "wrap")
    assert file["border_x_by"] == file["border_y_by"] == "texels"
    assert "border clamp across and wrap down" in run("to-height", "n.png", "-o", "b.png").stdout
    file = only(run, "n.png", "-o", "back.png", "--border-x", "mirror")
    assert (file["border_x"], file["border_y"]) == ("mirror", "wrap")
    assert (file["border_x_by"], file["border_y_by"]) == ("option", "texels")
    file = only(run, "n.png", "-o", "back.png", "--border", "extrapolate")
    assert (file["border_x"], file["border_y"]) == ("extrapolate", "extrapolate")


def test_free_borders_when_unknown(run, tmp_path):
    """Part of a surface, with noise at its edges."""
    rng = np.random.default_rng(4)
    n = reconstruction.from_height(reconstruction.fractal(256))[30:170, 40:190].astype(int)
    n += np.round(rng.normal(0, 12, n.shape)).astype(int)
    write_png(tmp_path / "n.png", np.clip(n, 0, 255).astype(np.uint8))
    file = only(run, "n.png", "-o", "h.png", "--type", "standard", "--y", "up")
    assert "wrap" not in (file["border_x"], file["border_y"])
    assert file["method"] == "poisson-dct"


@pytest.mark.parametrize("encoding", ["standard", "zzero", "xy"])
def test_encodings(run, tmp_path, surface, encoding):
    make_normals(run, "--to", encoding, "--depth", 16)
    file = only(run, "n.png", "-o", "back.png", "--type", encoding)
    assert file["from"] == encoding
    heights = read_png(tmp_path / "back.png")[0][..., 0] / 65535 * file["scale"] + file["offset"]
    assert np.std(heights - surface) < 0.01


def test_zzero_is_recognized(run, tmp_path):
    write_png(tmp_path / "n.png", textures.zzero())
    assert only(run, "n.png", "-o", "h.png")["from"] == "zzero"


def test_spacing(run, tmp_path, surface):
    make_normals(run, "--dx", 2, "--dy", 0.5, "--depth", 16)
    spacing = ["--dx", 2, "--dy", 0.5, "--kernel", "central", "--border", "wrap"]
    file = only(run, "n.png", "-o", "back.png", *spacing)
    assert (file["dx"], file["dy"]) == (2, 0.5)
    heights = read_png(tmp_path / "back.png")[0][..., 0] / 65535 * file["scale"] + file["offset"]
    assert np.std(heights - surface) < 0.02


# --------------------------------------------------------------------------------- options


@pytest.mark.parametrize(
    "method", ["telescoping", "frankot-chellappa", "poisson-dct", "weighted", "auto"]
)
def test_methods(run, tmp_path, surface, method):
    make_normals(run, "--depth", 16)
    file = only(run, "n.png", "-o", "back.png", "--method", method, "--kernel", "central")
    assert file["method"] == ("frankot-chellappa" if method == "auto" else method)
    heights = read_png(tmp_path / "back.png")[0][..., 0] / 65535 * file["scale"] + file["offset"]
    assert np.std(heights - surface) < 0.2
    if method == "poisson-dct":
        assert file["border_x"] != "wrap"


def test_seeds(run, tmp_path, surface):
    make_normals(run)
    args = ["--method", "telescoping", "--kernel", "central", "--seeds", "10,11,-2,3.5"]
    run("to-height", "n.png", "-o", "h.pfm", *args)
    assert read_pfm(tmp_path / "h.pfm")[:2, :2].ravel().tolist() == [10, 11, -2, 3.5]
    run("to-height", "n.png", "-o", "e.pfm", *args[:4], "--equalize")
    h = read_pfm(tmp_path / "e.pfm")
    means = [h[y::2, x::2].mean(dtype=float) for y in (0, 1) for x in (0, 1)]
    assert np.ptp(means) < 1e-4


def test_mask_and_islands(run, tmp_path, surface):
    make_normals(run)
    mask = np.zeros((128, 128), np.uint8)
    mask[10:50, 10:50] = 1
    mask[70:120, 60:110] = 255
    write_png(tmp_path / "mask.png", mask)
    file = only(run, "n.png", "-o", "h.pfm", "--mask", "mask.png")
    assert file["method"] == "weighted" and file["islands"] == 2 and file["iterations"] > 0
    assert file["holes"] == (mask == 0).sum()
    h = read_pfm(tmp_path / "h.pfm")
    for part in (np.s_[10:50, 10:50], np.s_[70:120, 60:110]):
        assert np.std((h - surface)[part]) < 0.05
    text = run("to-height", "n.png", "-o", "h.pfm", "--mask", "mask.png").stdout
    assert "2 separate areas" in text
    write_png(tmp_path / "small.png", mask[:100])
    done = run("to-height", "n.png", "-o", "x.png", "--mask", "small.png")
    assert done.returncode == 2 and "size" in done.stderr
    assert run("to-height", "n.png", "-o", "x.png", "--mask", "none.png").returncode == 3
    assert not (tmp_path / "x.png").exists()


def maze(rng, side):
    """A mask of corridors one texel wide, with one way from each texel to each other one."""
    mask = np.zeros((side, side), np.uint8)
    path = [(0, 0)]
    mask[0, 0] = 1
    while path:
        y, x = path[-1]
        ways = [(y + 2, x), (y - 2, x), (y, x + 2), (y, x - 2)]
        ways = [w for w in ways if 0 <= min(w) and max(w) < side and not mask[w]]
        if ways:
            to = ways[rng.integers(len(ways))]
            mask[to] = mask[(y + to[0]) // 2, (x + to[1]) // 2] = 1
            path.append(to)
        else:
            path.pop()
    return mask


def test_what_does_not_converge_is_said(run, tmp_path):
    rng = np.random.default_rng(1)
    write_png(tmp_path / "n.png", rng.integers(90, 166, (162, 162, 3)).astype(np.uint8))
    write_png(tmp_path / "mask.png", np.kron(maze(rng, 81), np.ones((2, 2), np.uint8)))
    args = ["--type", "standard", "--y", "up", "--kernel", "forward", "--z", "stored"]
    done = run("to-height", "n.png", "-o", "x.png", *args, "--mask", "mask.png")
    assert done.returncode == 2 and not (tmp_path / "x.png").exists()
    assert "n.png: the weighted least squares did not reach their tolerance" in done.stderr
    assert run("to-height", "n.png", "-o", "x.png", *args).returncode == 0


def test_unused_texels_are_holes(run, tmp_path):
    n = reconstruction.from_height(reconstruction.fractal(128))
    n[:, 60:70] = 0
    write_png(tmp_path / "n.png", n)
    file = only(run, "n.png", "-o", "h.png", "--border", "mirror")
    assert file["method"] == "weighted" and file["islands"] == 2 and file["holes"] == 1280


def test_detrend(run, tmp_path):
    y, x = np.mgrid[:96, :96]
    h = reconstruction.fractal(200)[:96, :96] + 0.2 * x - 0.1 * y
    write_png(tmp_path / "n.png", reconstruction.from_height(h.astype(np.float32), "central", 3, 3))
    args = ["n.png", "-o", "h.pfm", "--border", "extrapolate", "--kernel", "central"]
    only(run, *args)
    plane = np.stack([np.ones_like(x), x, y], -1).reshape(-1, 3)
    before = np.linalg.lstsq(plane, read_pfm(tmp_path / "h.pfm").ravel(), rcond=None)[0]
    file = only(run, *args, "--detrend")
    after = np.linalg.lstsq(plane, read_pfm(tmp_path / "h.pfm").ravel(), rcond=None)[0]
    assert np.allclose([file["trend_x"], file["trend_y"]], before[1:], atol=2e-3)
    assert np.abs(after[1:]).max() < 2e-3


def test_refine(run, tmp_path, surface):
    make_normals(run, "--depth", 8)
    plain = only(run, "n.png", "-o", "a.pfm")
    fine = only(run, "n.png", "-o", "b.pfm", "--refine", 16)
    assert plain["refine_left"] is None and plain["refine_rounds"] == 0
    assert fine["refine_rounds"] > 0 and fine["refine_left"] < 128 * 128 * 0.02
    run("from-height", "b.pfm", "-o", "again.png", "--depth", 8, *settings_of(fine))
    one, two = (read_png(tmp_path / name)[0] for name in ("n.png", "again.png"))
    assert (one != two)[..., :2].any(-1).sum() <= fine["refine_left"] + 5


@pytest.mark.parametrize("decode", ["unorm", "neutral", "unorm-trunc", "snorm128"])
@pytest.mark.parametrize("z", ["stored", "derived"])
def test_decode_and_z_can_be_forced(run, surface, decode, z):
    make_normals(run)
    file = only(run, "n.png", "-o", "h.png", "--decode", decode, "--z", z)
    assert file["decode"] == decode and file["z"] == z


def test_floats(program, run, tmp_path, surface):
    make_normals(run)
    file = only(run, "n.png", "-o", "h.pfm")
    assert file["depth"] == "float" and file["scale"] == 1 and file["offset"] == 0
    h = read_pfm(tmp_path / "h.pfm")
    assert h.min() == np.float32(file["min"]) and h.max() == np.float32(file["max"])
    assert np.std(h - surface) < 0.03 and abs(h.mean(dtype=float)) < 1e-4
    only(run, "n.png", "-o", "floats/", "--depth", "float")
    assert (tmp_path / "floats/n.pfm").read_bytes() == (tmp_path / "h.pfm").read_bytes()
    args = [program, "to-height", "n.png", "-o", "-", "--depth", "float"]
    assert spawn(args, cwd=tmp_path).stdout == (tmp_path / "h.pfm").read_bytes()
    only(run, "n.png", "-o", "dir/")
    assert (tmp_path / "dir/n.png").exists()


def test_jobs_and_instruction_give_the_same_bytes(run, tmp_path, surface):
    make_normals(run)
    for jobs in (1, 2, 3, 7):
        only(run, "n.png", "-o", f"{jobs}.png", "--jobs", jobs)
    first = (tmp_path / "1.png").read_bytes()
    assert all((tmp_path / f"{jobs}.png").read_bytes() == first for jobs in (2, 3, 7))


# --------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    "args",
    [
        ("--kernel", "sobel4"),
        ("--border", "none"),
        ("--method", "magic"),
        ("--method", "frankot-chellappa", "--border", "clamp"),
        ("--method", "frankot-chellappa", "--border-y", "mirror"),
        ("--method", "poisson-dct", "--border-x", "wrap"),
        ("--seeds", "1,2,3,4"),
        ("--method", "telescoping", "--seeds", "1,2,3"),
        ("--method", "telescoping", "--seeds", "1,2,3,4,5"),
        ("--method", "telescoping", "--seeds", "1,2,3,nan"),
        ("--method", "telescoping", "--seeds", "1, 2,3,4"),
        ("--method", "telescoping", "--mask", "n.png"),
        ("--equalize",),
        ("--refine", "-1"),
        ("--refine", "x"),
        ("--decode", "snorm"),
        ("--z", "none"),
        ("--type", "height"),
        ("--y", "left"),
        ("--depth", "8"),
        ("--depth", "float"),
        ("--dx", "0"),
        ("--dy", "-1"),
        ("-o", "h.tga"),
        ("-o", "h.jpg"),
        ("-o", "h.pfm", "--depth", "16"),
    ],
)
def test_usage_errors(run, tmp_path, args):
    write_png(tmp_path / "n.png", textures.standard())
    done = run("to-height", "n.png", "-o", "out.png", *args)
    assert done.returncode == 2 and done.stderr.startswith("ntp: "), done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["n.png"]


@pytest.mark.parametrize(
    ("args", "why"),
    [
        (("--method", "telescoping"), "--method telescoping"),
        (("--kernel", "central", "--method", "weighted", "--detrend"), "--detrend"),
    ],
)
def test_what_cannot_be_refined(run, tmp_path, args, why):
    write_png(tmp_path / "n.png", textures.standard())
    done = run("to-height", "n.png", "-o", "out.png", "--refine", 2, *args)
    assert done.returncode == 2 and "--refine" in done.stderr and why in done.stderr, done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["n.png"]


def test_floats_cannot_be_refined(run, tmp_path):
    n = textures.standard()[..., :3] / 127.5 - 1
    n = (n / np.linalg.norm(n, axis=-1, keepdims=True)).astype("<f4")
    h, w = n.shape[:2]
    (tmp_path / "n.pfm").write_bytes(b"PF\n%d %d\n-1.0\n" % (w, h) + n[::-1].tobytes())
    done = run(
        "to-height", "n.pfm", "-o", "out.png", "--refine", 2, "--type", "standard", "--y", "up"
    )
    assert done.returncode == 2 and "floats are not rounded" in done.stderr, done.stderr


def test_what_is_no_normals_texture(run, tmp_path):
    write_png(tmp_path / "h.png", textures.heights())
    write_png(tmp_path / "p.png", textures.photograph())
    for name, way_out in (("h.png", "ntp from-height"), ("p.png", "--type standard")):
        done = run("to-height", name, "-o", "out.png")
        assert done.returncode == 1 and way_out in done.stderr
        assert not (tmp_path / "out.png").exists()
    assert only(run, "p.png", "-o", "out.png", "--type", "standard", "--y", "up")["status"] == "ok"
    assert run("to-height", "none.png", "-o", "out2.png").returncode == 3
    (tmp_path / "bad_n.png").write_bytes((tmp_path / "p.png").read_bytes()[:300])
    assert run("to-height", "bad_n.png", "-o", "out2.png").returncode == 3
    assert not (tmp_path / "out2.png").exists()


def test_a_directory(run, tmp_path):
    (tmp_path / "in").mkdir()
    write_png(tmp_path / "in/a_n.png", textures.standard(seed=1))
    write_png(tmp_path / "in/b_n.png", textures.standard(seed=2, depth=16))
    write_png(tmp_path / "in/photo.png", textures.photograph())
    files = to_height(run, "in", "-o", "out")
    assert [f["status"] for f in files] == ["ok", "ok", "skipped"]
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["a_n.png", "b_n.png"]


# --------------------------------------------------------------------------------- bad input


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1), (2, 2), (3, 5), (1, 97), (31, 37)])
def test_small_and_odd_sizes(run, tmp_path, shape):
    n = textures.standard(64, 128)[: shape[0], : shape[1]]
    write_png(tmp_path / "n.png", n)
    for method in ("auto", "telescoping", "weighted"):
        args = ["--type", "standard", "--y", "up", "--method", method]
        file = only(run, "n.png", "-o", "h.png", *args)
        assert read_png(tmp_path / "h.png")[0].shape == (*shape, 1)
        assert np.isfinite([file["scale"], file["offset"], file["residual_levels"] or 0]).all()


@pytest.mark.parametrize("color", [(128, 128, 255), (127, 127, 255), (128, 128, 0), (200, 90, 3)])
def test_one_color(run, tmp_path, color):
    write_png(tmp_path / "n.png", np.full((20, 30, 3), color, np.uint8))
    file = only(run, "n.png", "-o", "h.png", "--type", "standard", "--y", "up", "--border", "wrap")
    assert file["scale"] == pytest.approx(0, abs=1e-3)
    assert run("from-height", "h.png", "-o", "x.png", "--scale", file["scale"]).returncode == 0


@pytest.mark.parametrize("color", [0, 255])
def test_nothing_used(run, tmp_path, color):
    write_png(tmp_path / "n.png", np.full((20, 30, 3), color, np.uint8))
    file = only(run, "n.png", "-o", "h.png", "--type", "standard")
    assert file["unused"] == 600 or file["holes"] == 600
    assert not read_png(tmp_path / "h.png")[0].any()


def test_broken_floats(run, tmp_path):
    n = (reconstruction.from_height(reconstruction.fractal(64)) / 255).astype(np.float32)
    n[3, 4] = np.nan
    n[10:12, 7] = np.inf
    n[20, 20] = 0.5  # length 0
    write_pfm(tmp_path / "n.pfm", n)
    file = only(run, "n.pfm", "-o", "h.pfm", "--type", "standard")
    h = read_pfm(tmp_path / "h.pfm")
    assert np.isfinite(h).all() and file["not_finite"] + file["holes"] >= 4


def test_huge_heights(run, tmp_path):
    """Slopes near 5, 2000 texels high: the printed scale is what was used."""
    h = np.abs((np.arange(512) + 256) % 512 - 256) * np.float32(5)
    n = reconstruction.from_height(np.tile(h, (64, 1)).astype(np.float32), dst=np.uint16)
    write_png(tmp_path / "n.png", n)
    file = only(run, "n.png", "-o", "h.png", "--border", "wrap", "--kernel", "central")
    assert file["scale"] == pytest.approx(1280, rel=0.01)
    assert float(f"{file['scale']:.9g}") == file["scale"]


@pytest.mark.parametrize("extra", [[], ["--format", "json"]])
def test_interrupted(program, run, tmp_path, extra):
    """Ctrl-C within the rounds of --refine: 130, and the best heights so far are written.  The
    progress on a terminal says how many texels are left."""
    rng = np.random.default_rng(5)  # of noise, no heights make every texel
    n = np.full((800, 800, 3), 200, np.uint8)
    n[..., :2] = rng.integers(90, 166, (800, 800, 2))
    write_png(tmp_path / "n.png", n)
    settings = ["--type", "standard", "--y", "up", "--kernel", "forward", "--border", "wrap"]
    settings += ["--z", "derived", "--decode", "unorm"]
    args = [program, "to-height", "n.png", "-o", "h.pfm", *settings, "--refine", "100000"]
    args += extra
    ours, theirs = pty.openpty()
    drawn = b""
    with start(args, cwd=tmp_path, stdout=subprocess.PIPE, stderr=theirs) as child:
        os.close(theirs)
        while b"texels left" not in drawn and select.select([ours], [], [], 20)[0]:
            drawn += os.read(ours, 4096)
        child.send_signal(signal.SIGINT)
        said = child.stdout.read().decode()
        assert child.wait(timeout=900) == 130, drawn
    os.close(ours)
    first = int(re.search(rb"(\d+) texels left", drawn)[1])
    assert 0 < first < n.shape[0] * n.shape[1]
    written = sorted(p.name for p in tmp_path.iterdir())
    assert written == ["h.pfm", "n.png"]
    if extra:
        file = json.loads(said)["files"][0]
        assert file["refine_rounds"] > 0
        run("from-height", "h.pfm", "-o", "m.png", "--depth", 8, "--kernel", "forward",
            "--border", "wrap", "--scale", 1)  # fmt: skip
        again = read_png(tmp_path / "m.png")[0]
        off = (again[..., :2] != n[..., :2]).any(-1).sum()
        assert abs(int(off) - file["refine_left"]) <= 0.01 * n.size
    else:
        assert "interrupted: " in said and "texels differ" in said


def test_the_line_says_how_many_texels_are_left(run, tmp_path):
    h = reconstruction.fractal(64, rms_slope=0.3)
    write_png(tmp_path / "n.png", reconstruction.from_height(h))
    args = ["n.png", "-o", "h.pfm", "--border", "wrap", "--kernel", "central", "--refine"]
    assert "1 round of refinement: " in run("to-height", *args, 1).stdout
    done = run("to-height", *args, 30, "--force")
    assert "rounds of refinement: every texel comes back" in done.stdout, done.stdout
    run("from-height", "h.pfm", "-o", "m.png", "--depth", 8, "--border", "wrap", "--scale", 1)
    again, given = (read_png(tmp_path / name)[0] for name in ("m.png", "n.png"))
    assert np.array_equal(again, given)


def test_help(run):
    text = run("to-height", "--help").stdout
    for option in ["--kernel", "--border-x", "--method", "--refine", "--seeds", "--mask", "--detrend",
                   "--decode", "--z", "--y", "--depth"]:  # fmt: skip
        assert option in text
    assert "to-height" in run("--help").stdout
    assert "to\\-height" in run("--generate", "man").stdout
    assert "to-height" in run("--generate", "bash").stdout


# ------------------------------------------------------- borders by trying, clipping, warnings

EVERY = ["wrap", "clamp", "mirror", "extrapolate"]


def write_noisy(tmp_path, heights, border, noise, seed=3):
    """n.png: normals of these heights, moved by noise of so many levels."""
    rng = np.random.default_rng(seed)
    at = reconstruction.WRAP if border == "wrap" else reconstruction.EXTRAPOLATE
    n = reconstruction.from_height(heights, "central", at, at).astype(float)
    n[..., :2] += rng.normal(0, noise, n[..., :2].shape)
    write_png(tmp_path / "n.png", n.round().clip(1, 254).astype(np.uint8))


@pytest.mark.parametrize("border", ["wrap", "extrapolate"])
def test_where_no_border_shows_the_best_fit_decides(run, tmp_path, border):
    """Of noisy normals, whose edges show nothing."""
    h = reconstruction.fractal(96, rms_slope=0.3)
    if border == "extrapolate":
        h = h[:80, :64] + np.arange(64) * 0.4 - np.arange(80)[:, None] * 0.3
    write_noisy(tmp_path, h, border, 8)
    how = ["--type", "standard", "--kernel", "central", "--y", "up"]
    found = only(run, "n.png", "-o", "auto.png", *how)
    fits = {
        b: only(run, "n.png", "-o", f"{b}.png", *how, "--border", b)["residual_levels"]
        for b in EVERY
    }
    assert found["residual_levels"] <= min(fits.values()) * 1.02, (found, fits)
    assert fits["mirror"] > 1.1 * min(fits.values())  # what was taken before
    assert "mirror" not in (found["border_x"], found["border_y"])
    assert found["border_x_by"] == found["border_y_by"] == "texels"
    free = only(run, "n.png", "-o", "p.png", *how, "--method", "poisson-dct")
    assert "wrap" not in (free["border_x"], free["border_y"])
    held = only(run, "n.png", "-o", "m.png", *how, "--border-x", "mirror")
    assert (held["border_x"], held["border_x_by"]) == ("mirror", "option")


def clipped_by_model(heights, percent):
    ordered = np.sort(heights, axis=None)
    k = int(len(ordered) * percent / 100)
    return heights.clip(ordered[k], ordered[-1 - k])


@pytest.mark.parametrize("percent", ["0", "0.1", "0.1%", "3", "49%"])
def test_clipping(run, tmp_path, surface, percent):
    make_normals(run)
    only(run, "n.png", "-o", "all.pfm")
    all_heights = read_pfm(tmp_path / "all.pfm")
    want = clipped_by_model(all_heights, float(percent.rstrip("%")))
    file = only(run, "n.png", "-o", "clipped.pfm", "--clip", percent)
    assert np.array_equal(read_pfm(tmp_path / "clipped.pfm"), want)
    assert file["clip"] == float(percent.rstrip("%"))
    assert file["clipped"] == np.count_nonzero(want != all_heights)
    assert (file["min"], file["max"]) == (want.min(), want.max())
    middle = np.sort(want, axis=None)
    k = len(middle) // 100
    share = (float(middle[-1 - k]) - float(middle[k])) / (float(want.max()) - float(want.min()))
    assert file["middle_share"] == pytest.approx(share, rel=1e-12)
    file = only(run, "n.png", "-o", "clipped.png", "--clip", percent)
    back = read_png(tmp_path / "clipped.png")[0][..., 0] / 65535 * file["scale"] + file["offset"]
    assert np.abs(back - want).max() <= 0.51 * file["scale"] / 65535
    assert texts(tmp_path / "clipped.png")["Height scale"] == f"{file['scale']:.9g}"
    line = run("to-height", "n.png", "-o", "x.png", "--clip", percent).stdout
    assert (f"{file['clipped']:,} heights clipped" in line) == (file["clipped"] > 0)


def test_clipping_leaves_holes_out_of_the_count(run, tmp_path, surface):
    make_normals(run)
    pixels = read_png(tmp_path / "n.png")[0].copy()
    pixels[:64] = 0
    write_png(tmp_path / "n.png", pixels)
    only(run, "n.png", "-o", "all.pfm")
    all_heights = read_pfm(tmp_path / "all.pfm")
    want = clipped_by_model(all_heights[64:], 5)
    file = only(run, "n.png", "-o", "clipped.pfm", "--clip", "5")
    assert file["holes"] >= 64 * 128
    assert np.array_equal(read_pfm(tmp_path / "clipped.pfm")[64:], want)


@pytest.mark.parametrize("percent", ["50", "-1", "%", "1%%", "0.1 %", "nan"])
def test_clip_is_a_percentage(run, tmp_path, surface, percent):
    make_normals(run)
    done = run("to-height", "n.png", "-o", "x.png", "--clip", percent)
    assert done.returncode == 2 and "--clip" in done.stderr


def test_spikes_are_told(run, tmp_path, surface):
    make_normals(run)
    assert only(run, "n.png", "-o", "plain.png")["notes"] == []
    rng = np.random.default_rng(4)
    h = 0.3 * rng.random((128, 128))
    h[40:42, 50:53] += 60
    write_png(tmp_path / "n.png", reconstruction.from_height(h.astype(np.float32), dst=np.uint16))
    file = only(run, "n.png", "-o", "spiked.png", "--border", "wrap", "--kernel", "central")
    assert file["middle_share"] < 0.03 and len(file["notes"]) == 1
    assert "--clip" in file["notes"][0]
    line = run("to-height", "n.png", "-o", "x.png", "--border", "wrap", "--kernel", "central")
    assert f"note: {file['notes'][0]}" in line.stdout
    file = only(
        run, "n.png", "-o", "cut.png", "--border", "wrap", "--kernel", "central", "--clip", "0.1"
    )
    assert file["middle_share"] > 0.5 and file["notes"] == []


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_a_poor_fit_is_a_warning(run, tmp_path, surface, depth):
    make_normals(run, "--depth", 8 * np.dtype(depth).itemsize)
    assert only(run, "n.png", "-o", "fits.png")["warnings"] == []
    m = np.iinfo(depth).max
    rng = np.random.default_rng(5)
    for spread, poor in ((0.025, False), (0.3, True)):
        n = rng.normal(0.5, spread / 2, (64, 64, 3)).clip(0.1, 0.9)
        n[..., 2] = 0.95
        write_png(tmp_path / "n.png", (n * m).astype(depth))
        file = only(run, "n.png", "-o", "x.png", "--y", "up", "--type", "standard")
        level = 1 if depth is np.uint8 else 257
        assert (file["residual_levels"] > 8 * level) == poor, file["residual_levels"]
        assert len(file["warnings"]) == poor
        line = run("to-height", "n.png", "-o", "x.png", "--y", "up", "--type", "standard")
        assert line.returncode == 0
        assert (f"warning: {''.join(file['warnings'])}" in line.stdout) == poor
        quiet = run("to-height", "n.png", "-o", "x.png", "--y", "up", "--type", "standard", "-q")
        assert quiet.stdout == "" and ("n.png: warning: " in quiet.stderr) == poor
