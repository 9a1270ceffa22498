# SPDX-License-Identifier: MIT
"""Inputs are replaced only on request, and never lost."""

import json
import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image

from support import textures
from support.libntp_ffi import ROOT
from support.pngs import write_png
from support.runs import noisy, pixels_of


def test_in_place(run, tmp_path):
    write_png(tmp_path / "good_n.png", textures.standard())
    write_png(tmp_path / "bad_n.png", noisy())
    good = (tmp_path / "good_n.png").stat()
    assert run("clean", ".", "--in-place").returncode == 0
    after = (tmp_path / "good_n.png").stat()
    assert (after.st_ino, after.st_mtime_ns) == (good.st_ino, good.st_mtime_ns)
    assert run("check", "bad_n.png").returncode == 0
    assert run("clean", "bad_n.png", "--in-place").stdout.count("nothing to repair") == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["bad_n.png", "good_n.png"]


OVERWRITING = {
    "clean": [],
    "convert": ["--y", "up", "--to-y", "down"],
    "heatmap": ["--type", "standard"],
    "transform": ["--flip", "x"],
    "resize": ["--size", "50%"],
    "from-height": ["--scale", "4"],
    "to-height": ["--from", "standard"],
    "curvature": ["--type", "standard", "--y", "up"],
    "occlusion": ["--type", "standard", "--y", "up"],
    "blend": [],
}


def replaced_on_request(run, tmp_path, verb, names):
    """Each of the names, given as -o, is refused, but for --force; what then comes of the input."""
    before = textures.heights() if verb == "from-height" else noisy()
    options = OVERWRITING[verb]
    inputs = ["a_n.png"]
    if verb == "blend":
        inputs = ["a_n.png", "d_n.png"]
        options = ["--type", "standard", "--y", "up", "--detail-y", "up"]
        write_png(tmp_path / "d_n.png", textures.standard(8, 8))
    if verb in ("clean", "convert", "transform", "resize"):
        options = [*options, *(["--from"] if verb == "convert" else ["--type"]), "standard"]
    write_png(tmp_path / "a_n.png", before)
    (tmp_path / "sub").mkdir()
    old = (tmp_path / "a_n.png").read_bytes()
    done = run(verb, *inputs, "-o", "other.png", *options)
    assert done.returncode == 0, done.stderr
    want = (tmp_path / "other.png").read_bytes()
    for given in names:
        (tmp_path / "a_n.png").write_bytes(old)
        done = run(verb, *inputs, "-o", given, *options)
        assert done.returncode == 2 and given in done.stderr, (given, done.stderr)
        assert (tmp_path / "a_n.png").read_bytes() == old, given
        done = run(verb, *inputs, "-o", given, *options, "--force")
        assert done.returncode == 0, (given, done.stderr)
        assert (tmp_path / "a_n.png").read_bytes() == want, given
    (tmp_path / "a_n.png").write_bytes(old)
    return [verb, *inputs, *options], old, want


@pytest.mark.parametrize("verb", OVERWRITING)
def test_the_input_is_replaced_only_on_request(run, tmp_path, verb):
    """-o FILE that is the input, by its own name or another: refused, but for --force."""
    names = ("a_n.png", "./sub/../a_n.png")
    args, old, want = replaced_on_request(run, tmp_path, verb, names)
    done = run(*args, "--in-place")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a_n.png").read_bytes() == want
    if verb == "blend":
        (tmp_path / "a_n.png").write_bytes(old)
        assert run(*args, "-o", "d_n.png").returncode == 2
        assert run(*args, "-o", "d_n.png", "--force").returncode == 0
        assert (tmp_path / "d_n.png").read_bytes() == want
        assert (tmp_path / "a_n.png").read_bytes() == old


@pytest.mark.parametrize("verb", OVERWRITING)
def test_the_input_is_replaced_by_a_link_only_on_request(run, tmp_path, verb):
    (tmp_path / "link.png").symlink_to("a_n.png")
    replaced_on_request(run, tmp_path, verb, ["link.png"])
    assert (tmp_path / "link.png").is_symlink()


def test_further_inputs_are_not_overwritten(run, tmp_path):
    write_png(tmp_path / "h.png", textures.heights())
    write_png(tmp_path / "n.png", textures.standard())
    write_png(tmp_path / "m.png", textures.heights())
    before = (tmp_path / "m.png").read_bytes()
    for args in (
        ["to-height", "n.png", "--mask", "m.png", "-o", "m.png"],
        ["from-height", "h.png", "--scale", "2", "--alpha", "m.png", "-o", "m.png"],
        ["from-height", "h.png", "--scale", "2", "--to", "xy", "--ao", "m.png", "-o", "./m.png"],
    ):
        done = run(*args)
        assert done.returncode == 2 and "m.png is an input" in done.stderr, (args, done.stderr)
        assert (tmp_path / "m.png").read_bytes() == before


def test_standard_input_is_not_overwritten(program, tmp_path):
    write_png(tmp_path / "a_n.png", noisy())
    before = (tmp_path / "a_n.png").read_bytes()
    with open(tmp_path / "a_n.png", "rb") as file:
        done = subprocess.run(
            [program, "clean", "-", "-o", "a_n.png", "--type", "standard"],
            stdin=file,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
        )
    assert done.returncode == 2 and "a_n.png is an input" in done.stderr
    assert (tmp_path / "a_n.png").read_bytes() == before


def test_force_replaces_only_the_own_input(run, tmp_path):
    """Below -o DIR as well; but never another input, which may still be unread."""
    for name in ("a_n.png", "b_n.png"):
        write_png(tmp_path / name, noisy())
    before = (tmp_path / "a_n.png").read_bytes()
    args = ["clean", "--type", "standard", "-o", ".", "--force"]
    assert run(*args, "a_n.png", "b_n.png").returncode == 0
    assert (tmp_path / "a_n.png").read_bytes() != before
    write_png(tmp_path / "a_n.png", noisy())
    (tmp_path / "a_n.tga").symlink_to("b_n.png")
    (tmp_path / "d").mkdir()
    (tmp_path / "d/a_n.png").hardlink_to(tmp_path / "b_n.png")
    done = run("clean", "--type", "standard", "-o", "d", "--force", "a_n.png", "b_n.png")
    assert done.returncode == 2 and "d/a_n.png is an input" in done.stderr
    assert (tmp_path / "a_n.png").read_bytes() == before


@pytest.mark.parametrize("verb", ["convert", "clean"])
def test_in_place_keeps_what_does_not_change(run, tmp_path, verb):
    write_png(tmp_path / "a_n.png", textures.standard())
    write_png(tmp_path / "pair_n.png", textures.standard()[..., :2])
    before = {p.name: (p.stat().st_ino, p.read_bytes()) for p in tmp_path.iterdir()}
    options = {"a_n.png": ["--type", "standard"], "pair_n.png": ["--type", "xy"]}
    if verb == "convert":
        xy = ["--from", "xy", "--to", "xy"]
        options = {"a_n.png": ["--depth", "8"], "pair_n.png": xy}
    for name, how in options.items():
        done = run(verb, name, "--in-place", *how)
        assert done.returncode == 0 and "not written" in done.stdout, (done.stdout, done.stderr)
        assert ((tmp_path / name).stat().st_ino, (tmp_path / name).read_bytes()) == before[name]


def test_convert_in_place(run, tmp_path):
    """Against integers: green flipped, and rearranged channels that happen to be equal stay."""
    texture = textures.standard()
    write_png(tmp_path / "a_n.png", texture)
    assert run("convert", "a_n.png", "--in-place", "--y", "up", "--to-y", "down").returncode == 0
    want = texture.copy()
    want[..., 1] = 255 - texture[..., 1]
    assert np.array_equal(pixels_of(tmp_path / "a_n.png"), want)
    done = run("convert", "a_n.png", "--in-place", "--channels", "yxz")
    assert done.returncode == 0 and "not written" not in done.stdout
    assert np.array_equal(pixels_of(tmp_path / "a_n.png"), want[..., [1, 0, 2]])
    flat = np.full((8, 8, 3), (128, 128, 255), np.uint8)
    write_png(tmp_path / "flat_n.png", flat)
    done = run("convert", "flat_n.png", "--in-place", "--channels", "xyz", "--from-channels", "xyz")
    assert done.returncode == 0 and "not written" in done.stdout, done.stdout


def test_mips_in_place_are_written_once(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.standard(16, 16))
    assert run("resize", "a_n.png", "--mips", "--in-place").returncode == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "a_n.png",
        *(f"a_n_mip{i}.png" for i in range(1, 5)),
    ]


def test_output_by_a_hard_link_leaves_the_input(run, tmp_path):
    write_png(tmp_path / "a_n.png", noisy())
    (tmp_path / "b.png").hardlink_to(tmp_path / "a_n.png")
    before = (tmp_path / "a_n.png").read_bytes()
    args = ["clean", "a_n.png", "-o", "b.png", "--type", "standard", "--method", "derive"]
    assert run(*args).returncode == 2  # both are names of one file
    assert run(*args, "--force").returncode == 0
    assert (tmp_path / "a_n.png").read_bytes() == before
    assert run("check", "--type", "standard", "--verdict", "exact", "b.png").returncode == 0


def test_failing_leaves_the_input_that_o_names(run, tmp_path):
    write_png(tmp_path / "a_n.png", noisy())
    data = (tmp_path / "a_n.png").read_bytes()
    (tmp_path / "a_n.png").write_bytes(data[: len(data) // 2])
    done = run("clean", "a_n.png", "-o", "a_n.png", "--type", "standard", "--force")
    assert done.returncode == 3 and done.stderr
    assert (tmp_path / "a_n.png").read_bytes() == data[: len(data) // 2]
    write_png(tmp_path / "p.png", textures.photograph())
    before = (tmp_path / "p.png").read_bytes()
    assert run("clean", "p.png", "--in-place").returncode == 1
    assert (tmp_path / "p.png").read_bytes() == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a_n.png", "p.png"]


def test_jpeg_is_never_replaced(run, tmp_path):
    """Nor one by the name of a PNG."""
    Image.fromarray(textures.standard()).save(tmp_path / "a_n.jpg", quality=95)
    data = (tmp_path / "a_n.jpg").read_bytes()
    (tmp_path / "b_n.png").write_bytes(data)
    write_png(tmp_path / "d_n.png", textures.standard())
    for args in (
        ["clean", "a_n.jpg", "-o", "a_n.jpg"],
        ["clean", "b_n.png", "-o", "b_n.png"],
        ["convert", "b_n.png", "-o", "b_n.png", "--to-y", "down"],
        ["blend", "b_n.png", "d_n.png", "-o", "b_n.png"],
        ["blend", "d_n.png", "b_n.png", "-o", "b_n.png"],
    ):
        assert run(*args).returncode == 2
        done = run(*args, "--force")
        assert done.returncode == 2 and "JPEG" in done.stderr, args
        assert (tmp_path / "b_n.png").read_bytes() == data
        assert (tmp_path / "a_n.jpg").read_bytes() == data
    assert run("clean", "b_n.png", "--in-place").returncode == 3
    assert (tmp_path / "b_n.png").read_bytes() == data


def test_jpeg_in_place_that_needs_nothing_is_done(run, tmp_path):
    """Only where something would have to be written it cannot be."""
    shutil.copy(ROOT / "test_files" / "jpeg.jpg", tmp_path / "up_n.jpg")
    # JPEG of full quality gives this normal back, with the blue of its red and green
    exact = Image.fromarray(np.full((64, 64, 3), [90, 119, 249], np.uint8))
    exact.save(tmp_path / "exact_n.jpg", quality=100, subsampling=0)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for args, name, code in (
        (["convert", "--to-y", "up"], "up_n.jpg", 0),
        (["convert", "--y", "up", "--to-y", "opengl"], "up_n.jpg", 0),
        (["convert", "--type", "standard"], "up_n.jpg", 0),
        (["convert", "--to-y", "down"], "up_n.jpg", 3),
        (["convert", "--depth", "16"], "up_n.jpg", 3),
        (["clean"], "up_n.jpg", 3),
        (["clean"], "exact_n.jpg", 0),
        (["clean", "--method", "derive"], "exact_n.jpg", 0),
        (["transform", "--flip", "x"], "exact_n.jpg", 3),
    ):
        for dry in ([], ["-n"]) if args[0] != "transform" else ([],):
            done = run(*args, "--in-place", *dry, name)
            assert done.returncode == code, (args, dry, done.stderr)
            assert "not written" in (done.stderr if code else done.stdout), (args, dry)
            assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    told = json.loads(run("convert", "--to-y", "up", "--in-place", ".", "--format", "json").stdout)
    assert told["summary"]["failed"] == 0 and told["summary"]["unchanged"] >= 1
