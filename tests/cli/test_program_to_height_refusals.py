# SPDX-License-Identifier: MIT
"""`ntp to-height`: usage errors, what it refuses, bad input and Ctrl-C."""

import json
import os
import pty
import re
import select
import signal
import subprocess

import numpy as np
import pytest

from support import textures
from support import to_height as reconstruction
from support.pngs import read_png, write_png
from support.run_to_height import (
    only,
    read_pfm,
    to_height,
    write_pfm,
)
from support.spawn import start


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
