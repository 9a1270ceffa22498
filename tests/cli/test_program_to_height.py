# SPDX-License-Identifier: MIT
"""ntp to-height: round trips through the program, choices, options."""

import shlex
import struct

import numpy as np
import pytest

from support import textures
from support import to_height as reconstruction
from support.pngs import chunk, read_png, write_png
from support.run_to_height import make_normals, only, read_pfm, settings_of, texts
from support.spawn import spawn

KERNELS = ["central", "forward", "prewitt3", "sobel3", "scharr3"]
BORDERS = ["wrap", "clamp", "mirror"]
MADE = [(k, b) for k in KERNELS for b in BORDERS]
MADE += [("central", "extrapolate"), ("forward", "extrapolate")]


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


def test_help(run):
    text = run("to-height", "--help").stdout
    for option in ["--kernel", "--border-x", "--method", "--refine", "--seeds", "--mask", "--detrend",
                   "--decode", "--z", "--y", "--depth"]:  # fmt: skip
        assert option in text
    assert "to-height" in run("--help").stdout
    assert "to\\-height" in run("--generate", "man").stdout
    assert "to-height" in run("--generate", "bash").stdout
