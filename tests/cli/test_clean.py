# SPDX-License-Identifier: MIT
"""ntp clean: bytes against the oracle, choices of the method, refusals."""

import numpy as np
import pytest

from support import oracle, textures
from support.libntp_ffi import ROOT
from support.pngs import write_png
from support.runs import items, noisy, pixels_of
from support.spawn import spawn


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
