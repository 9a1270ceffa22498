# SPDX-License-Identifier: MIT
"""ntp transform, resize and blend: bytes, names of outputs, JSON, refusals."""

import json
from fractions import Fraction

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle, oracle_rotate, textures
from support import oracle_vectors as model
from support.pngs import read_png, write_png


def pixels_of(path):
    return read_png(path)[0]


def only_item(done):
    assert done.returncode == 0, done.stderr
    (item,) = json.loads(done.stdout)["files"]
    assert item["status"] == "ok" and item["written"]
    return item


def is_exact(texture):
    m = np.iinfo(texture.dtype).max
    r, g, b = np.moveaxis(texture[..., :3].astype(np.int64), -1, 0)
    inside = (2 * r - m) ** 2 + (2 * g - m) ** 2 <= m * m
    return inside.all() and np.array_equal(oracle.derived_blues(r, g, m), b)


# ------------------------------------------------------------------------- transform


@pytest.mark.parametrize("depth", [8, 16])
def test_turns(run, tmp_path, depth):
    before = textures.standard(20, 30, 1, depth=depth)
    m = 255 if depth == 8 else 65535
    write_png(tmp_path / "a_n.png", before)
    done = run(
        "transform", "a_n.png", "-o", "b.png", "--rotate", "90", "--y", "up", "--format", "json"
    )
    item = only_item(done)
    assert item["rotate"] == 90 and item["flip"] is None and item["strength"] == 1
    want = np.rot90(before, -1)
    want = np.dstack([want[..., 1], m - want[..., 0], want[..., 2]])
    assert np.array_equal(pixels_of(tmp_path / "b.png"), want)
    run("transform", "b.png", "-o", "c.png", "--rotate", "270", "--y", "up")
    assert np.array_equal(pixels_of(tmp_path / "c.png"), before)
    run("transform", "a_n.png", "-o", "d.png", "--rotate", "90", "--y", "down")
    want = np.rot90(before, -1)
    want = np.dstack([m - want[..., 1], want[..., 0], want[..., 2]])
    assert np.array_equal(pixels_of(tmp_path / "d.png"), want)


@pytest.mark.parametrize("depth", [8, 16])
def test_turns_by_any_angle(run, tmp_path, depth):
    before = textures.standard(9, 14, 1, depth=depth)
    m = 255 if depth == 8 else 65535
    write_png(tmp_path / "a_n.png", before)
    args = ["transform", "a_n.png", "-o", "b.png", "--y", "down", "--strength", "0.5"]
    args += ["--flip", "x", "--border", "mirror", "--border-x", "clamp"]
    item = only_item(run(*args, "--rotate", "-12.5", "--format", "json"))
    assert item["rotate"] == -12.5 and (item["border_x"], item["border_y"]) == ("clamp", "mirror")
    want = oracle_rotate.rotated(
        before.tolist(), -12.5, m, "standard", ntp.DOWN, (1, 0), (1, 2), Fraction(1, 2)
    )
    assert pixels_of(tmp_path / "b.png").tolist() == want
    item = only_item(run(*args, "--rotate", "-90", "--format", "json"))
    assert item["rotate"] == 270 and pixels_of(tmp_path / "b.png").shape == (14, 9, 3)


def test_flips(run, tmp_path):
    before = textures.standard(20, 30, 2)
    write_png(tmp_path / "a_n.png", before)
    assert (
        only_item(run("transform", "a_n.png", "-o", "b.png", "--flip", "x", "--format", "json"))[
            "flip"
        ]
        == "x"
    )
    want = before[:, ::-1].copy()
    want[..., 0] = 255 - want[..., 0]
    assert np.array_equal(pixels_of(tmp_path / "b.png"), want)
    run("transform", "a_n.png", "-o", "c.png", "--flip", "xy")
    run("transform", "a_n.png", "-o", "d.png", "--rotate", "180")
    assert np.array_equal(pixels_of(tmp_path / "c.png"), pixels_of(tmp_path / "d.png"))


def test_strength(run, tmp_path):
    before = textures.standard(16, 18, 3)
    write_png(tmp_path / "a_n.png", before)
    done = run("transform", "a_n.png", "-o", "b.png", "--strength", "2.5", "--format", "json")
    assert only_item(done)["strength"] == 2.5
    after = pixels_of(tmp_path / "b.png").reshape(-1, 3).tolist()
    for old, new in zip(before.reshape(-1, 3).tolist(), after, strict=True):
        x, y, z = model.components(old, 255, "standard")
        assert tuple(new) == model.encode((5 * x, 5 * y, 2 * z), 255, "standard")


def test_transform_usage(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.standard(8, 8))
    assert run("transform", "a_n.png", "-o", "b.png").returncode == 2
    assert run("transform", "a_n.png", "-o", "b.png", "--strength", "2000").returncode == 2
    assert run("transform", "a_n.png", "-o", "b.png", "--rotate", "361").returncode == 2
    assert run("transform", "a_n.png", "-o", "b.png", "--rotate", "nan").returncode == 2
    assert not (tmp_path / "b.png").exists()


# ---------------------------------------------------------------------------- resize


def box_halved(src, m):
    """The mean of each 2 x 2 texels as a unit vector."""
    out = np.zeros((src.shape[0] // 2, src.shape[1] // 2, 3), src.dtype)
    for y, x in np.ndindex(out.shape[:2]):
        four = src[2 * y : 2 * y + 2, 2 * x : 2 * x + 2].reshape(4, 3).tolist()
        v = np.sum([model.components(t, m, "standard") for t in four], 0)
        out[y, x] = model.encode([int(c) for c in v], m, "standard")
    return out


@pytest.mark.parametrize("depth", [8, 16])
def test_half_size(run, tmp_path, depth):
    before = textures.standard(20, 30, 4, depth=depth)
    write_png(tmp_path / "a_n.png", before)
    want = box_halved(before, 255 if depth == 8 else 65535)
    for size in ("50%", "15x10"):
        args = ["resize", "a_n.png", "-o", "b.png", "--size", size, "--filter", "box"]
        item = only_item(run(*args, "--format", "json"))
        assert (item["width"], item["height"], item["filter"]) == (15, 10, "box")
        assert item["border_x"] == item["border_y"] == "wrap"
        assert np.array_equal(pixels_of(tmp_path / "b.png"), want)


@pytest.mark.parametrize("filter", ["box", "triangle", "lanczos3"])
@pytest.mark.parametrize("size", ["37%", "200%", "1x1", "5x300"])
def test_results_are_exact(run, tmp_path, filter, size):
    write_png(tmp_path / "a_n.png", textures.standard(70, 90, 5, 1.5))
    args = ["resize", "a_n.png", "-o", "b.png", "--size", size, "--filter", filter]
    assert run(*args, "--border-x", "clamp", "--border-y", "mirror").returncode == 0
    assert is_exact(pixels_of(tmp_path / "b.png"))


def test_mip_chain(run, tmp_path):
    before = textures.standard(40, 24, 6)
    write_png(tmp_path / "a_n.png", before)
    item = only_item(run("resize", "a_n.png", "-o", "out/a_n.png", "--mips", "--format", "json"))
    sizes = [(24, 40), (12, 20), (6, 10), (3, 5), (1, 2), (1, 1)]
    assert [(one["width"], one["height"]) for one in item["mips"]] == sizes
    names = ["a_n.png"] + [f"a_n_mip{k}.png" for k in range(1, 6)]
    assert [one["path"] for one in item["mips"]] == [f"out/{name}" for name in names]
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == sorted(names)
    for name, (w, h) in zip(names, sizes, strict=True):
        level = pixels_of(tmp_path / "out" / name)
        assert level.shape == (h, w, 3) and is_exact(level)
    assert np.array_equal(pixels_of(tmp_path / "out/a_n.png"), before)
    assert np.array_equal(pixels_of(tmp_path / "out/a_n_mip1.png"), box_halved(before, 255))


def test_mips_overwrite_no_input(run, tmp_path):
    texture = textures.standard(16, 16, 7)
    write_png(tmp_path / "a_n.png", texture)
    write_png(tmp_path / "b_mip1.png", texture)
    kept = (tmp_path / "b_mip1.png").read_bytes()
    (tmp_path / "out").mkdir()
    done = run("resize", "a_n.png", "b_mip1.png", "-o", "out", "--mips")
    assert done.returncode == 0
    write_png(tmp_path / "b.png", texture)
    done = run("resize", "b.png", "b_mip1.png", "-o", "out", "--mips")
    assert done.returncode == 2 and "nothing is overwritten" in done.stderr
    assert (tmp_path / "b_mip1.png").read_bytes() == kept


def test_alpha_weighs(run, tmp_path):
    rgba = np.zeros((4, 4, 4), np.uint8)
    tilted = [200, 90, 232]
    tilted[2] = oracle.derived_blue(200, 90, 255)
    rgba[..., :3] = [40, 128, 190]
    rgba[:, :3] = [*tilted, 255]
    write_png(tmp_path / "a_n.png", rgba)
    args = ["resize", "a_n.png", "-o", "b.png", "--size", "2x1", "--filter", "box"]
    assert run(*args, "--type", "standard").returncode == 0
    assert pixels_of(tmp_path / "b.png").tolist() == [[[*tilted, 255], [*tilted, 128]]]


def test_resize_usage(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.standard(8, 8))
    for wrong in ("0x4", "4x", "x4", "4x4x4", "-5%", "0%", "65536x1", "large", "4 x 4", "nan%"):
        done = run("resize", "a_n.png", "-o", "b.png", f"--size={wrong}")
        assert done.returncode == 2 and "--size" in done.stderr, wrong
    assert run("resize", "a_n.png", "-o", "b.png").returncode == 2
    assert run("resize", "a_n.png", "-o", "b.png", "--size", "4x4", "--mips").returncode == 2
    assert run("resize", "a_n.png", "-o", "-", "--mips").returncode == 2
    done = run("resize", "a_n.png", "-o", "b.png", "--size", "9000x9000", "--max-texels", "1000")
    assert done.returncode == 2
    assert not (tmp_path / "b.png").exists()


# ----------------------------------------------------------------------------- blend


def test_blend_whiteout(run, tmp_path):
    base, detail = textures.standard(12, 20, 8), textures.standard(5, 7, 9, depth=16)
    write_png(tmp_path / "a_n.png", base)
    write_png(tmp_path / "d_n.png", detail)
    done = run(
        "blend", "a_n.png", "d_n.png", "-o", "b.png", "--mode", "whiteout", "--strength", "0.5",
        "--y", "up", "--detail-y", "down", "--format", "json"
    )  # fmt: skip
    item = only_item(done)
    assert item["mode"] == "whiteout" and item["strength"] == 0.5 and item["detail"] == "d_n.png"
    assert item["detail_y"] == "down" and item["y"] == "up"
    after = pixels_of(tmp_path / "b.png")
    for y, x in np.ndindex(base.shape[:2]):
        b = model.components(base[y, x].tolist(), 255, "standard")
        d = model.components(detail[y % 5, x % 7].tolist(), 65535, "standard")
        v = (
            2 * 257 * b[0] + d[0],
            2 * 257 * b[1] - d[1],
            2 * b[2] * d[2],
        )
        v = (v[0] * 255, v[1] * 255, v[2])
        assert tuple(after[y, x]) == model.encode(v, 255, "standard")
    assert item["changed"] == np.any(after != base, -1).sum()


@pytest.mark.parametrize("mode", ["rnm", "whiteout", "udn", "linear"])
def test_blends_are_exact(run, tmp_path, mode):
    write_png(tmp_path / "a_n.png", textures.standard(80, 60, 10))
    write_png(tmp_path / "d_n.png", textures.standard(16, 16, 11))
    args = ["blend", "a_n.png", "d_n.png", "-o", "b.png", "--mode", mode]
    assert run(*args, "--y", "up", "--detail-y", "up").returncode == 0
    assert is_exact(pixels_of(tmp_path / "b.png"))


def test_blend_usage(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.standard())
    write_png(tmp_path / "h.png", textures.heights())
    assert run("blend", "a_n.png", "-o", "b.png").returncode == 2
    assert run("blend", "a_n.png", "a_n.png").returncode == 2
    done = run("blend", "a_n.png", "h.png", "-o", "b.png")
    assert done.returncode == 1 and "h.png: a height map" in done.stderr
    assert run("blend", "h.png", "a_n.png", "-o", "b.png").returncode == 1
    assert run("blend", "a_n.png", "missing.png", "-o", "b.png").returncode == 3
    assert run("blend", "missing.png", "a_n.png", "-o", "b.png").returncode == 3
    assert not (tmp_path / "b.png").exists()


# ------------------------------------------------------------------------------- all


@pytest.mark.parametrize(
    "verb", [("transform", "--flip", "x"), ("resize", "--size", "50%"), ("resize", "--mips")]
)
def test_refusals(run, tmp_path, verb):
    write_png(tmp_path / "h.png", textures.heights())
    done = run(verb[0], "h.png", "-o", "b.png", *verb[1:])
    assert done.returncode == 1 and "a height map" in done.stderr
    done = run(verb[0], "h.png", "-o", ".", *verb[1:])
    assert done.returncode == 2 and "is an input" in done.stderr
    assert run(verb[0], "missing.png", "-o", "b.png", *verb[1:]).returncode == 3
    assert not (tmp_path / "b.png").exists()
    assert run(verb[0], "h.png", "-o", "b.png", "--type", "standard", *verb[1:]).returncode == 0
    assert pixels_of(tmp_path / "b.png").shape[2] == 4 - 1


def test_large_image_of_many_blocks(run, tmp_path):
    before = textures.standard(700, 800, 12)
    write_png(tmp_path / "a_n.png", before)
    assert run("transform", "a_n.png", "-o", "b.png", "--rotate", "90").returncode == 0
    assert run("transform", "b.png", "-o", "c.png", "--rotate", "270").returncode == 0
    assert np.array_equal(pixels_of(tmp_path / "c.png"), before)
    assert run("resize", "a_n.png", "-o", "d.png", "--size", "100%").returncode == 0
    assert np.array_equal(pixels_of(tmp_path / "d.png"), before)


def test_tree(run, tmp_path):
    for name in ("x/a_n.png", "b_n.png"):
        (tmp_path / "t" / name).parent.mkdir(parents=True, exist_ok=True)
        write_png(tmp_path / "t" / name, textures.standard(16, 16, 13))
    write_png(tmp_path / "t/photo.png", textures.heights())
    assert run("resize", "-r", "t", "-o", "out", "--size", "8x8").returncode == 0
    made = sorted(str(p.relative_to(tmp_path / "out")) for p in (tmp_path / "out").rglob("*.png"))
    assert made == ["b_n.png", "x/a_n.png"]
