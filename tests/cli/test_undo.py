# SPDX-License-Identifier: MIT
"""ntp clean --undo: which accidents are undone, exactly how, and what is refused."""

import json
from fractions import Fraction

import numpy as np
import pytest

from support import textures
from support.libntp_ffi import ROOT
from support.pngs import read_png, write_png
from support.spawn import spawn

FILES = ROOT / "test_files"


def linear_table(m):
    """round(m * linear(s / m)) by integers: a fifth power on one side, a twelfth on the other."""

    def reaches(s, twice):  # is the linear light of level s at least twice / 2 levels?
        v = Fraction(s, m)
        if v <= Fraction(4045, 100000):
            return v / Fraction(1292, 100) * m * 2 >= twice
        v = (v + Fraction(55, 1000)) / Fraction(1055, 1000)
        return v**12 >= Fraction(twice, 2 * m) ** 5

    table, level = [], 0
    for s in range(m + 1):
        while level < m and reaches(s, 2 * level + 1):
            level += 1
        table.append(level)
    return np.array(table)


def srgb_of(levels, m):
    v = levels / m
    stored = np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.maximum(v, 1e-9) ** (1 / 2.4) - 0.055)
    return np.floor(stored * m + 0.5).astype(np.uint8 if m == 255 else np.uint16)


def gentle(depth=8, h=64, w=80):
    """A texture whose red and green go over a wide range, with much that is flat."""
    out = textures.standard(h, w, 3, 1.0, depth)
    out[: h // 3] = [128, 128, 255] if depth == 8 else [32768, 32768, 65535]
    return out


def cleaned(run, path, *options):
    done = run("clean", path, "-o", "out.png", "--format", "json", *options)
    assert done.returncode == 0, done.stderr
    (item,) = json.loads(done.stdout)["files"]
    return item


@pytest.mark.parametrize("depth", [8, 16])
def test_srgb_is_undone_by_the_exact_inverse(run, tmp_path, depth):
    m = 255 if depth == 8 else 65535
    good = gentle(depth)
    stored = srgb_of(good, m)
    write_png(tmp_path / "a_n.png", stored)
    item = cleaned(run, "a_n.png", "--method", "derive", "--undo")
    assert item["undone"]["what"] == "srgb"
    got = read_png(tmp_path / "out.png")[0].astype(np.int64)
    want = linear_table(m)[stored] if depth == 8 else None
    if depth == 16:  # Fractions of 16 bits are slow: only the levels that are there
        v = (stored.astype(np.longdouble) / m + np.longdouble("0.055")) / np.longdouble("1.055")
        want = np.floor(v ** np.longdouble("2.4") * m + np.longdouble("0.5")).astype(np.int64)
    inside = ((2 * want[..., :2] - m) ** 2).sum(-1) <= m * m
    assert inside.mean() > 0.9
    assert np.array_equal(got[inside][:, :2], want[inside][:, :2])
    off = np.abs(want - good.astype(np.int64)).max()
    assert off <= item["undone"]["loss_levels"] <= 1


def test_unused_texels_stay_when_blue_is_inverted(run, tmp_path):
    good = textures.standard(64, 80, 3, 1.0)
    stored = good.copy()
    stored[..., 2] = 255 - stored[..., 2]
    stored[:4] = 0
    stored[-4:] = 255
    write_png(tmp_path / "a_n.png", stored)
    item = cleaned(run, "a_n.png")
    assert item["undone"]["what"] == "inverted-blue" and item["changed"] == 56 * 80
    good[:4], good[-4:] = 0, 255
    assert np.array_equal(read_png(tmp_path / "out.png")[0], good)


def test_alpha_stays_when_channels_are_exchanged(run, tmp_path):
    good = textures.standard(64, 80, 3, 1.0)
    alpha = (np.arange(64 * 80).reshape(64, 80) % 200 + 40).astype(np.uint8)
    write_png(tmp_path / "a_n.png", np.dstack([good[..., [2, 1, 0]], alpha]))
    assert cleaned(run, "a_n.png")["undone"]["what"] == "red-blue"
    assert np.array_equal(read_png(tmp_path / "out.png")[0], np.dstack([good, alpha]))


@pytest.mark.parametrize("name", ["gamma.png", "dxt5nm.png", "red_blue_swapped.png"])
def test_streams_and_in_place(run, program, tmp_path, name):
    data = (FILES / name).read_bytes()
    cleaned(run, FILES / name)
    want = read_png(tmp_path / "out.png")[0]
    done = spawn([program, "clean", "-", "-o", "-"], input=data)
    (tmp_path / "piped.png").write_bytes(done.stdout)
    assert done.returncode == 0 and np.array_equal(read_png(tmp_path / "piped.png")[0], want)
    (tmp_path / "a_n.png").write_bytes(data)
    assert run("clean", "a_n.png", "--in-place", "-n").returncode == 0
    assert (tmp_path / "a_n.png").read_bytes() == data
    done = run("clean", "a_n.png", "--in-place")
    assert done.returncode == 0 and "undid" in done.stdout
    assert np.array_equal(read_png(tmp_path / "a_n.png")[0], want)
    assert "not written" in run("clean", "a_n.png", "--in-place").stdout  # once is enough


def test_large_texture_of_many_blocks(run, tmp_path):
    good = textures.standard(1100, 1024, 3, 1.0)
    write_png(tmp_path / "a_n.png", np.ascontiguousarray(good[..., [0, 2, 1]]))
    item = cleaned(run, "a_n.png")
    assert item["undone"]["what"] == "green-blue"
    assert np.array_equal(read_png(tmp_path / "out.png")[0], good)
    assert item["changed"] == (good != good[..., [0, 2, 1]]).any(axis=2).sum()


def doubtful():
    """Red and blue exchanged, and damaged so much that this is not sure."""
    rng = np.random.default_rng(5)
    levels = textures.standard(64, 80, 3, 0.6)[..., [2, 1, 0]].astype(np.int64)
    levels += rng.integers(-9, 10, levels.shape)
    return np.clip(levels, 0, 255).astype(np.uint8)


def test_what_is_not_sure_is_asked(run, tmp_path):
    write_png(tmp_path / "a_n.png", doubtful())
    (check,) = json.loads(run("check", "a_n.png", "--format", "json").stdout)["files"]
    assert "NT012" in [f["id"] for f in check["findings"]] and check["confidence"] < 0.9
    done = run("clean", "a_n.png", "-o", "out.png")
    assert done.returncode == 1 and not (tmp_path / "out.png").exists()
    for word in ("red and blue", "--undo", "--type", "--force"):
        assert word in done.stderr
    assert cleaned(run, "a_n.png", "--undo")["undone"]["what"] == "red-blue"
    assert read_png(tmp_path / "out.png")[0][..., 2].mean() > 200
    for option in (["--type", "standard"], ["--force"]):
        assert cleaned(run, "a_n.png", *option)["undone"] is None
        assert read_png(tmp_path / "out.png")[0][..., 0].mean() > 200


@pytest.mark.parametrize("name", ["gamma.png", "dxt5nm.png", "z_flipped.png"])
def test_every_verb_asks_first(run, tmp_path, name):
    write_png(tmp_path / "flat_n.png", np.full((64, 96, 3), [128, 128, 255], np.uint8))
    file = FILES / name
    verbs = {
        "transform": [file, "--flip", "x"],
        "resize": [file, "--size", "50%"],
        "to-height": [file],
        "blend": [file, "flat_n.png"],
    }
    for verb, words in verbs.items():
        done = run(verb, *words, "-o", "out.png")
        assert done.returncode == 1 and not (tmp_path / "out.png").exists(), verb
        for word in ("ntp clean --undo", "--type", "--force"):
            assert word in done.stderr, verb
    done = run("blend", "flat_n.png", file, "-o", "out.png")
    assert done.returncode == 1 and name in done.stderr and "--undo" in done.stderr
    args = ["resize", file, "--size", "50%", "-o", "out.png"]
    assert (
        run(*args, "--force").returncode == 0 and run(*args, "--type", "standard").returncode == 0
    )
    assert run("heatmap", file, "-o", "heat.png").returncode == 0  # a picture of what is wrong


def test_normals_are_not_taken_for_heights(run, tmp_path):
    args = ["from-height", FILES / "standard.png", "-o", "out.png", "--scale", "4"]
    done = run(*args)
    assert done.returncode == 1 and not (tmp_path / "out.png").exists()
    assert "--source" in done.stderr and "--force" in done.stderr
    assert run(*args, "--force").returncode == 0
    assert run(*args, "--source", "blue").returncode == 0
    for name in ("height_rgb.png", "height_gray8.png", "photograph.png"):
        args[1] = FILES / name
        done = run(*args)
        assert done.returncode == 0, (name, done.stderr)


def test_tree(run, tmp_path):
    for name in ("gamma.png", "standard.png", "photograph.png"):
        (tmp_path / name).write_bytes((FILES / name).read_bytes())
    write_png(tmp_path / "doubtful.png", doubtful())
    done = run("clean", ".", "-o", "d")
    assert done.returncode == 1 and "doubtful.png" in done.stderr
    assert sorted(p.name for p in (tmp_path / "d").iterdir()) == ["gamma.png", "standard.png"]
