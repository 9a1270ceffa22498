# SPDX-License-Identifier: MIT
"""Gray and alpha that hold x and y: judged by either order, converted only by a stated one."""

import json

import numpy as np
import pytest

from support import oracle, textures
from support.pngs import read_png, write_png


def pairs(depth=8, bad_rows=3):
    """(h, w, 2) x and y of a texture, the first rows longer than 1."""
    out = np.ascontiguousarray(textures.standard(64, 80, 5, 1.0, depth)[..., :2])
    step = 1 if depth == 8 else 257
    rng = np.random.default_rng(1)
    out[:bad_rows] = rng.integers(1, 30, out[:bad_rows].shape) * step
    return out


def too_long(array):
    m = np.iinfo(array.dtype).max
    v = 2 * array.astype(np.int64) - m
    return int(((v**2).sum(-1) > m * m).sum())


def only_item(done):
    return json.loads(done.stdout)["files"][0]


@pytest.mark.parametrize("depth", [8, 16])
def test_check(run, tmp_path, depth):
    a = pairs(depth)
    write_png(tmp_path / "a.png", a)
    write_png(tmp_path / "swapped.png", np.ascontiguousarray(a[..., ::-1]))
    count = too_long(a)
    assert count > 0
    for name, forced in (("a.png", ()), ("swapped.png", ()), ("a.png", ("--type", "xy"))):
        item = only_item(run("check", name, "--format", "json", *forced))
        assert item["type"] == "xy" and item["channels"] == 2
        assert item["xy_too_long"] == item["fail"]["neighbor"] == count
        found = {f["id"]: f for f in item["findings"]}
        assert found["NT002"]["count"] == count and found["NT002"]["level"] == "error"
        assert ("NT006" in found) == (not forced)
        assert item["angle_deg"]["max"] > 0.1
        if not forced:  # gray may be y
            assert item["y"] == "undecided"
    assert run("check", "a.png").returncode == 1
    write_png(tmp_path / "good.png", pairs(depth, 0))
    assert run("check", "good.png").returncode == 0
    assert run("check", "--type", "xy", "good.png").returncode == 0


@pytest.mark.parametrize("depth", [8, 16])
def test_clean_in_either_order(run, tmp_path, depth):
    a = pairs(depth)
    m = np.iinfo(a.dtype).max
    want = [oracle.cleaned(r, g, m, m, False)[:2] for r, g in a.reshape(-1, 2).tolist()]
    want = np.array(want, a.dtype).reshape(a.shape)
    write_png(tmp_path / "a.png", a)
    write_png(tmp_path / "swapped.png", np.ascontiguousarray(a[..., ::-1]))
    for name, options in (("a.png", ()), ("a.png", ("--type", "xy")), ("swapped.png", ())):
        done = run("clean", name, "-o", "out.png", "--format", "json", *options)
        assert done.returncode == 0, done.stderr
        assert only_item(done)["changed"] == (a != want).any(-1).sum()
        got = read_png(tmp_path / "out.png")[0]
        assert np.array_equal(got if name == "a.png" else got[..., ::-1], want)
    assert run("clean", "out.png", "--in-place").stdout.count("nothing to repair") == 1
    assert run("heatmap", "a.png", "-o", "heat.png").returncode == 0
    heat = read_png(tmp_path / "heat.png")[0]
    assert (heat[..., 0] != heat[..., 2]).sum() == too_long(a)


def test_order_has_to_be_stated(run, tmp_path):
    a = pairs(bad_rows=0)
    write_png(tmp_path / "a.png", a)
    write_png(tmp_path / "base_n.png", textures.standard(64, 80, 6))
    for args in (
        ["transform", "a.png", "-o", "out.png", "--flip", "x"],
        ["blend", "a.png", "base_n.png", "-o", "out.png"],
        ["blend", "base_n.png", "a.png", "-o", "out.png"],
        ["dump", "a.png"],
    ):
        done = run(*args)
        assert done.returncode == 1 and "--type xy" in done.stderr, args
        assert not (tmp_path / "out.png").exists()
        assert run(*args, "--type", "xy").returncode == 0, args
        (tmp_path / "out.png").unlink(missing_ok=True)
    assert run("transform", "a.png", "-o", "f.png", "--flip", "x", "--type", "xy").returncode == 0
    want = a[:, ::-1].copy()
    want[..., 0] = 255 - want[..., 0]
    assert np.array_equal(read_png(tmp_path / "f.png")[0], want)


def test_convert(run, tmp_path):
    texture = textures.standard(64, 80, 5, 1.0)
    write_png(tmp_path / "std_n.png", texture)
    args = ["convert", "std_n.png", "-o", "a.png", "--channels", "xy"]
    assert run(*args).returncode == 0
    a = read_png(tmp_path / "a.png")[0]
    assert a.shape[2] == 2 and np.array_equal(a, texture[..., :2])
    assert run("convert", "a.png", "-o", "b.png", "--from", "xy").returncode == 0
    assert np.array_equal(read_png(tmp_path / "b.png")[0], texture)
    args = ["convert", "a.png", "-o", "c.png", "--type", "xy", "--to", "xy"]
    args += ["--y", "up", "--to-y", "down"]
    assert run(*args).returncode == 0
    c = read_png(tmp_path / "c.png")[0]
    assert np.array_equal(c, np.dstack([a[..., 0], 255 - a[..., 1]]))
    done = run("convert", "a.png", "-o", "d.png", "--to", "zzero")
    assert done.returncode == 1 and "--type xy" in done.stderr
    assert run("diff", "a.png", "std_n.png", "-o", "heat.jpg").returncode == 2
    same = run("diff", "a.png", "std_n.png", "--format", "json")
    assert json.loads(same.stdout)["different"] == 0


def test_heights_with_alpha_are_no_pairs(run, tmp_path):
    gray = textures.heights()
    gray = gray[..., 0] if gray.ndim == 3 else gray
    for alpha in (np.full_like(gray, 255), np.where(gray > 128, 255, 0).astype(np.uint8)):
        write_png(tmp_path / "h.png", np.dstack([gray, alpha]))
        assert only_item(run("check", "h.png", "--format", "json"))["type"] == "height"
