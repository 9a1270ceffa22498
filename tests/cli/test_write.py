# SPDX-License-Identifier: MIT
"""ntp clean, convert, heatmap: bytes against the oracle, choices, refusals, metadata."""

import json
import shutil
import struct
import subprocess
import zlib

import numpy as np
import pytest
from PIL import Image

from support import oracle, textures
from support.libntp_ffi import ROOT
from support.pngs import png_bytes, read_png, tga_bytes, write_png
from support.spawn import spawn


def pixels_of(path):
    return read_png(path)[0]


def items(done):
    out = json.loads(done.stdout)
    assert out["schema_version"] == 1 and out["tool"]["name"] == "ntp"
    return out["files"]


def noisy(depth=8, seed=7, h=48, w=56):
    m = 255 if depth == 8 else 65535
    rng = np.random.default_rng(seed)
    step = m // 255
    out = textures.standard(h, w, seed, 1.5, depth).astype(np.int64)
    out += rng.integers(-4 * step, 4 * step + 1, out.shape)
    return np.clip(out, 0, m).astype(np.uint8 if depth == 8 else np.uint16)


@pytest.mark.parametrize("depth", [8, 16])
@pytest.mark.parametrize("options", [(), ("--method", "normalize"), ("--keep-negative-z",)])
def test_clean_is_the_oracle(run, tmp_path, depth, options):
    before = noisy(depth, h=16, w=20)
    before[:2] = 0
    m = 255 if depth == 8 else 65535
    write_png(tmp_path / "a_n.png", before)
    method = "normalize" if "normalize" in options else "derive"
    options = [*options, *([] if "--method" in options else ["--method", "derive"])]
    args = ["clean", "a_n.png", "-o", "b.png", "--type", "standard", *options]
    done = run(*args, "--format", "json")
    assert done.returncode == 0, done.stderr
    keep = "--keep-negative-z" in options
    after = pixels_of(tmp_path / "b.png")
    changed = 0
    for old, new in zip(before.reshape(-1, 3).tolist(), after.reshape(-1, 3).tolist(), strict=True):
        want = old if not any(old) else oracle.cleaned(*old, m, False, method, keep)
        assert tuple(new) == tuple(want)
        changed += old != new
    (item,) = items(done)
    assert item["changed"] == changed and item["output"] == "b.png" and item["method"] == method
    assert set(item["angle_deg"]) == {"mean", "p99", "max"}
    run(*["clean", "b.png", "-o", "c.png", "--type", "standard", *options])
    assert np.array_equal(pixels_of(tmp_path / "c.png"), after)


def test_large_image_streams(run, tmp_path):
    before = noisy(h=700, w=800)
    write_png(tmp_path / "a_n.png", before)
    assert run("clean", "a_n.png", "-o", "b.png", "--method", "derive").returncode == 0
    table = oracle.derive_table(255)
    after = pixels_of(tmp_path / "b.png")
    want = oracle.all_cleaned(*np.moveaxis(before.astype(np.int64), -1, 0))
    assert table is not None
    assert np.array_equal(after, want)


def test_alpha_and_unused_stay(run, tmp_path):
    rgba = np.dstack([noisy(), np.tile(np.arange(56, dtype=np.uint8) * 4, (48, 1))])
    rgba[3:6, 3:6, :3] = 255
    write_png(tmp_path / "a_n.png", rgba)
    assert run("clean", "a_n.png", "-o", "b.png", "--type", "standard").returncode == 0
    after = pixels_of(tmp_path / "b.png")
    assert np.array_equal(after[..., 3], rgba[..., 3])
    assert np.array_equal(after[:, 0], rgba[:, 0])  # alpha 0: unused
    assert (after[3:6, 3:6, :3] == 255).all()
    args = ["clean", "a_n.png", "-o", "c.png", "--type", "standard", "--touch-unused"]
    assert run(*args).returncode == 0
    assert (pixels_of(tmp_path / "c.png")[3:6, 3:6, 2] != 255).all()


@pytest.mark.parametrize("method", ["auto", "derive", "normalize"])
@pytest.mark.parametrize("m", [255, 65535])
def test_unused_texels_are_repaired_on_request(run, tmp_path, m, method):
    """Also if all others are correctly rounded and need no repair."""
    rng = np.random.default_rng(6)
    v = rng.normal(0, 0.3, (40, 40, 3)) + (0, 0, 1)
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    texture = np.floor((v + 1) / 2 * m + 0.5).astype(np.uint8 if m == 255 else np.uint16)
    used = texture[6:].copy()
    texture[:3], texture[3:6] = 0, m
    write_png(tmp_path / "a_n.png", texture)
    done = run("clean", "a_n.png", "-o", "b.png", "--touch-unused", "--method", method)
    assert done.returncode == 0, done.stderr
    assert ("only unused texels need it" in done.stdout) == (method == "auto"), done.stdout
    after = pixels_of(tmp_path / "b.png").astype(int)
    for r, g, b in after[:6].reshape(-1, 3)[::7].tolist():
        assert oracle.rounded(r, g, b, m)
    if method != "derive":
        assert np.array_equal(after[6:], used)


def test_files_with_and_without_a_height_in_alpha(run, tmp_path):
    # Large enough for the tables that files share; alpha 0 is a height in one of them.
    texture = textures.standard(512, 512, 3)
    texture[..., 2] = 255
    height = (np.arange(512 * 512).reshape(512, 512) % 256).astype(np.uint8)
    write_png(tmp_path / "a_n.png", np.dstack([texture, height]))
    write_png(tmp_path / "b_n.png", texture)
    for order in (["a_n.png", "b_n.png"], ["b_n.png", "a_n.png"]):
        done = run("clean", *order, "--type", "xy", "-j", "1", "-o", "out")
        assert done.returncode == 0, done.stderr
        assert np.array_equal(pixels_of(tmp_path / "out" / "b_n.png"), texture)


def test_zzero_is_found_while_cleaning(run, tmp_path):
    before = textures.zzero()
    before[10:12, :, 2] -= 40
    write_png(tmp_path / "z_n.png", before)
    done = run("clean", "z_n.png", "-o", "b.png", "--method", "derive", "--format", "json")
    (item,) = items(done)
    assert item["type"] == "zzero"
    assert np.array_equal(pixels_of(tmp_path / "b.png"), textures.zzero())


def method_oracle(levels, method, m=255):
    flat = [
        oracle.cleaned(*t, m, False, method, False) if any(t) else t
        for t in levels.reshape(-1, 3).tolist()
    ]
    return np.array(flat).reshape(levels.shape)


@pytest.mark.parametrize("streams", [False, True])
def test_the_method_suits_the_errors(run, program, tmp_path, streams):
    """Blue alone wrong: derive.  All channels: normalize.  Rounded: nothing, or z mirrored."""
    good = textures.standard(40, 44, 5, 1.5).astype(np.int64)
    off = good.copy()
    off[8:10, 6:30, 2] = 128
    negative = good.copy()
    negative[3:9, :, 2] = 255 - negative[3:9, :, 2]
    noise = noisy(h=40, w=44).astype(np.int64)
    cases = {
        "derive": (off, method_oracle(off, "derive")),
        "normalize": (noise, method_oracle(noise, "normalize")),
        "keep": (good, good),
        "mirror": (negative, good),
    }
    for method, (before, want) in cases.items():
        write_png(tmp_path / "a_n.png", before.astype(np.uint8))
        out = tmp_path / "b.png"
        options = ["-o", str(out), "--type", "standard", "--format", "json"]
        if streams:
            data = (tmp_path / "a_n.png").read_bytes()
            done = spawn([program, "clean", "-", *options], input=data)
            done.stdout = done.stdout.decode()
        else:
            done = run("clean", "a_n.png", *options)
        assert done.returncode == 0, done.stderr
        (item,) = items(done)
        assert item["method"] == method and item["method_reason"], method
        assert item["changed"] == (before != want).any(axis=2).sum()
        assert np.array_equal(pixels_of(out), want), method


def test_what_is_printed_is_what_was_done(run, tmp_path):
    """Texels are never said to be kept while their z is mirrored."""
    levels = textures.standard(40, 44, 5, 1.5)
    write_png(tmp_path / "a_n.png", np.ascontiguousarray(levels[..., [2, 1, 0]]))
    done = run("clean", "a_n.png", "-o", "b.png", "--type", "standard")
    assert done.returncode == 0 and "changed" in done.stdout, done.stderr
    assert "keep" not in done.stdout and "mirrored" in done.stdout


def test_only_failing(run, tmp_path):
    before = noisy()
    write_png(tmp_path / "a_n.png", before)
    args = ["clean", "a_n.png", "-o", "b.png", "--only-failing", "--type", "standard"]
    assert run(*args).returncode == 0
    flags = oracle.flags(*np.moveaxis(before.astype(np.int64), -1, 0), 255)
    same = (pixels_of(tmp_path / "b.png") == before).all(axis=2)
    passing = ((flags & 1) != 0) & ((flags & 16) == 0)
    assert same[passing].all()


def test_refusals(run, tmp_path):
    write_png(tmp_path / "h.png", textures.heights())
    write_png(tmp_path / "p.png", textures.photograph())
    for name in ("h.png", "p.png"):
        for verb in ("clean", "heatmap"):
            done = run(verb, name, "-o", "out.png")
            way = "from-height" if name == "h.png" else "--type"
            assert done.returncode == 1 and way in done.stderr, (verb, name)
            assert not (tmp_path / "out.png").exists()
    assert run("clean", "p.png", "-o", "out.png", "--type", "standard").returncode == 0
    (tmp_path / "out.png").unlink()
    done = run("clean", ".", "-o", "d")  # of a directory: left out, no failure
    assert done.returncode == 0 and "left out" in done.stdout
    assert not list(tmp_path.glob("d/*"))


@pytest.mark.parametrize("name", ["height_gray8.png", "object_space.png", "photograph.png"])
def test_force_takes_what_is_refused_for_standard(run, tmp_path, name):
    files = ROOT / "test_files"
    verbs = {"clean": [], "heatmap": [], "transform": ["--flip", "x"], "resize": ["--size", "50%"]}
    for verb, options in verbs.items():
        done = run(verb, files / name, "-o", "no.png", *options)
        assert done.returncode == 1 and not (tmp_path / "no.png").exists(), done.stderr
        done = run(verb, files / name, "-o", f"{verb}.png", "--force", *options)
        assert done.returncode == 0, done.stderr
        run(verb, files / name, "-o", "told.png", "--type", "standard", *options)
        assert (tmp_path / f"{verb}.png").read_bytes() == (tmp_path / "told.png").read_bytes()
        (tmp_path / "told.png").unlink()


def test_force_leaves_what_a_directory_holds_besides(run, tmp_path):
    write_png(tmp_path / "p.png", textures.photograph())
    assert run("clean", ".", "-o", "d", "--force").returncode == 0
    assert not list(tmp_path.glob("d/*"))


def test_dry_run_and_only_changed(run, tmp_path):
    write_png(tmp_path / "good_n.png", textures.standard())
    write_png(tmp_path / "bad_n.png", noisy())
    done = run("clean", ".", "-o", "d", "-n", "--format", "json")
    by_name = {f["path"]: f for f in items(done)}
    assert by_name["./good_n.png"]["changed"] == 0 and by_name["./bad_n.png"]["changed"] > 0
    assert not (tmp_path / "d").exists()
    assert run("clean", ".", "-o", "d", "--only-changed").returncode == 0
    assert [p.name for p in (tmp_path / "d").iterdir()] == ["bad_n.png"]


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


def test_clean_files_of_other_classes_are_not_written(run, tmp_path):
    for name, texture in (("z_n.png", textures.zzero()), ("xy_n.png", textures.standard())):
        if name == "xy_n.png":
            texture[..., 2] = np.arange(64) % 8 * 30  # blue is something else
        write_png(tmp_path / name, texture)
        before = (tmp_path / name).stat()
        done = run("clean", name, "--in-place", "--format", "json")
        (item,) = items(done)
        assert done.returncode == 0 and not item["written"] and item["changed"] == 0, name
        assert item["type"] == ("zzero" if name == "z_n.png" else "xy")
        after = (tmp_path / name).stat()
        assert (before.st_ino, before.st_mtime_ns) == (after.st_ino, after.st_mtime_ns)
        assert run("clean", name, "-o", "out", "--only-changed").returncode == 0
        assert not (tmp_path / "out" / name).exists()


def test_method_auto_says_why(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.wrong_blue(textures.standard(), 0.1))
    done = run("clean", "a_n.png", "-o", "b.png", "--method", "auto", "--format", "json")
    (item,) = items(done)
    assert item["method"] in ("derive", "normalize") and item["method_reason"]
    run("clean", "a_n.png", "-o", "c.png", "--method", item["method"])
    assert np.array_equal(pixels_of(tmp_path / "b.png"), pixels_of(tmp_path / "c.png"))
    write_png(tmp_path / "clean_n.png", textures.standard())
    (item,) = items(run("clean", "clean_n.png", "-n", "--method", "auto", "--format", "json"))
    assert (item["method"], item["changed"]) == ("keep", 0)


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
    some = [rng.integers(0, 60, rng.integers(2, 9)) for _ in range(200)]
    texels = np.concatenate([some[i] for i in rng.integers(0, 200, size * size)])
    return colors[texels[: size * size].reshape(size, size)]


@pytest.mark.parametrize("pains", [9, 6])
def test_beside_a_file_that_was_packed_hard(run, tmp_path, pains):
    picture = words()
    rows = b"".join(b"\0" + row.tobytes() for row in picture)
    head = struct.pack(">IIBBBBB", *picture.shape[1::-1], 8, 2, 0, 0, 0)
    data = b"\x89PNG\r\n\x1a\n"
    for name, body in ((b"IHDR", head), (b"IDAT", zlib.compress(rows, pains)), (b"IEND", b"")):
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
