# SPDX-License-Identifier: MIT
"""ntp check: counts against the oracle, levels of findings, formats, baseline, exit codes."""

import csv
import io
import json

import numpy as np
import pytest

from support import libntp_ffi, oracle, schemas, textures
from support.pngs import chunk, write_png


def report(run, *args, code=None):
    done = run("check", "--format", "json", *args)
    if code is not None:
        assert done.returncode == code, done.stderr
    out = json.loads(done.stdout)
    schemas.validate(out, "check-1")
    return out


def only(run, *args, code=None):
    (file,) = report(run, *args, code=code)["files"]
    return file


def ids(file, level=None):
    return {f["id"] for f in file["findings"] if level in (None, f["level"])}


def test_clean_standard_texture(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.standard())
    file = only(run, "a_n.png", code=0)
    assert file["type"] == "standard" and file["confidence"] >= 0.9 and file["reasons"]
    assert file["fail"] == {"neighbor": 0, "rounded": 0, "exact": 0}
    assert file["levels_off"] == {"0": 64 * 64}
    assert not ids(file, "error") and not ids(file, "warning")
    text = run("check", "a_n.png")
    assert text.returncode == 0 and text.stdout.startswith("a_n.png: standard") and not text.stderr
    assert "well formed" in text.stdout and text.stdout.count("\n") == 1


@pytest.mark.parametrize("depth", [8, 16])
def test_counts_are_those_of_the_oracle(run, tmp_path, depth):
    rng = np.random.default_rng(depth)
    m = 255 if depth == 8 else 65535
    pixels = textures.standard(48, 40, depth=depth).astype(np.int64)
    pixels += rng.integers(-3 * (m // 255), 3 * (m // 255) + 1, pixels.shape)
    pixels = np.clip(pixels, 0, m)
    pixels[:2, :3] = 0
    pixels[5, 5] = (m, m // 2, m)  # too long in x, y
    pixels[6, 6] = (m // 2, m // 2, 3)  # z negative
    write_png(tmp_path / "a_n.png", pixels.astype(np.uint8 if depth == 8 else np.uint16))
    file = only(run, "--type", "standard", "a_n.png")
    flags = oracle.flags(*np.moveaxis(pixels, -1, 0), m)
    total = pixels.shape[0] * pixels.shape[1]
    for name, bit in (("neighbor", 1), ("rounded", 2), ("exact", 4)):
        assert file["fail"][name] == total - np.count_nonzero(flags & bit), name
    assert file["xy_too_long"] == np.count_nonzero(flags & 8)
    assert file["z_negative"] == np.count_nonzero(flags & 16)
    assert file["unused"] == 6 and file["texels"] == total
    assert sum(file["levels_off"].values()) == total - file["xy_too_long"]


@pytest.mark.parametrize("share,level", [(0.01, "warning"), (0.04, "error")])
def test_max_fail_divides_warnings_from_errors(run, tmp_path, share, level):
    write_png(tmp_path / "a_n.png", textures.wrong_blue(textures.standard(), share))
    file = only(run, "a_n.png", code=int(level == "error"))
    (finding,) = [f for f in file["findings"] if f["id"] == "NT001"]
    assert finding["level"] == level and finding["count"] == round(share * 64 * 64)
    assert run("check", "a_n.png", "--fail-on", "warning").returncode == 1
    assert run("check", "a_n.png", "--fail-on", "never").returncode == 0
    assert run("check", "a_n.png", "--max-fail", "5").returncode == 0
    assert run("check", "a_n.png", "--max-fail", "0.1").returncode == 1


def test_unused_texels_leave_the_share(run, tmp_path):
    pixels = textures.wrong_blue(textures.standard(), 0.015)
    pixels[:32] = 0  # half of the texture: what remains fails 1.5 %
    write_png(tmp_path / "a_n.png", pixels)
    file = only(run, "a_n.png", code=0)
    assert file["type"] == "standard" and file["unused"] == 32 * 64
    assert "NT042" in ids(file, "info") and "NT001" in ids(file, "warning")
    assert file["fail"]["neighbor"] >= 32 * 64  # counts cover every texel


def test_types(run, tmp_path):
    black = np.zeros((8, 8, 3), np.uint8)
    flat = np.full((8, 8, 3), (128, 128, 255), np.uint8)
    cases = {
        "z_n.png": (textures.zzero(), "zzero", 0, "NT005"),
        "h.png": (textures.heights(), "height", 1, "NT007"),
        "p.png": (textures.photograph(), "not-normals", 1, "NT008"),
        "f_n.png": (flat, "one-color", 0, "NT050"),
        "b_n.png": (black, "one-color", 0, "NT050"),
    }
    for name, (pixels, kind, code, finding) in cases.items():
        write_png(tmp_path / name, pixels)
        file = only(run, name, code=code)
        assert file["type"] == kind, name
        assert finding in ids(file), name
        if kind not in ("standard", "zzero", "xy"):
            assert file["fail"] is None
    assert only(run, "h.png", "--type", "height", code=0)["findings"] == []


def test_negative_z(run, tmp_path):
    pixels = textures.standard()
    pixels[10:14, 10:14, 2] = 255 - pixels[10:14, 10:14, 2]
    write_png(tmp_path / "a_n.png", pixels)
    assert "NT003" in ids(only(run, "a_n.png"))
    file = only(run, "a_n.png", "--keep-negative-z")
    assert "NT003" not in ids(file) and file["fail"]["exact"] == 0


def test_type_decides(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.standard())
    file = only(run, "--type", "zzero", "a_n.png", code=1)
    assert file["type"] == "zzero" and file["confidence"] == 1 and file["reasons"]
    file = only(run, "--type", "xy", "a_n.png", code=0)
    assert set(file["fail"].values()) == {file["xy_too_long"]} and file["length"] is None


def test_direction_of_green(run, tmp_path):
    """The texels say OpenGL; the name says DirectX."""
    pixels = textures.standard()  # y of its slopes goes down the picture
    pixels[..., 1] = 255 - pixels[..., 1]
    write_png(tmp_path / "rock_nor_dx.png", pixels)
    file = only(run, "rock_nor_dx.png")
    assert file["y"] == "up" and 0.8 <= file["y_confidence"] <= 0.99
    assert not {"NT010", "NT011"} & set(ids(file))
    file = only(run, "rock_nor_dx.png", "--y", "up")
    assert (file["y"], file["y_confidence"]) == ("up", 1) and "NT011" in ids(file, "warning")
    assert "NT010" not in ids(file)
    file = only(run, "rock_nor_dx.png", "--y", "down")
    assert (file["y"], file["y_confidence"]) == ("down", 1)
    assert "NT010" in ids(file, "warning") and "NT011" not in ids(file)
    text = run("check", "-v", "--y", "down", "rock_nor_dx.png").stdout
    assert "looks OpenGL (green up) where DirectX (green down) is required" in text
    assert ", OpenGL (Y up)" in text.splitlines()[0] and "% sure" in text


def test_direction_of_green_is_found(run, tmp_path):
    """In a texture that is read in several blocks, sampled and --deep."""
    pixels = np.tile(textures.standard(), (12, 16, 1))
    write_png(tmp_path / "a_n.png", pixels)
    write_png(tmp_path / "b_n.png", np.full((64, 64, 3), (128, 128, 255), np.uint8))
    write_png(tmp_path / "c_n.png", pixels[:, :, [2, 1, 0]])
    for deep in ((), ("--deep",)):
        assert only(run, "a_n.png", *deep)["y"] == "down"
        assert only(run, "b_n.png", *deep)["y"] == "undecided"
        assert only(run, "c_n.png", *deep)["y"] == "undecided"  # red and blue are swapped
        assert "NT010" in ids(only(run, "a_n.png", "--y", "up", *deep), "warning")
    assert only(run, "a_n.png", "--jobs", "2") == only(run, "a_n.png", "--jobs", "1")


@pytest.mark.parametrize("first,wide", [(0, 256), (100, 256), (0, 6144)])
def test_direction_of_green_does_not_ask_for_blue(run, tmp_path, first, wide):
    """Rows whose blue is that of no normal are put aside, as far as there is room for them, and are
    measured when x and y turn out to be normals."""
    rng = np.random.default_rng(first)
    pixels = np.tile(textures.standard(), (12, wide // 64, 1)).astype(np.int16)
    pixels[..., :2] += rng.integers(-16, 17, (*pixels.shape[:2], 2), np.int16)
    pixels = np.clip(pixels, 0, 255).astype(np.uint8)
    write_png(tmp_path / "a_n.png", pixels)
    pixels[first:, :, 2] = 0
    write_png(tmp_path / "b_n.png", pixels)
    a, b = (only(run, name, "--type", "xy") for name in ("a_n.png", "b_n.png"))
    assert (a["y"], a["y_confidence"]) == (b["y"], b["y_confidence"])
    assert 0.5 < a["y_confidence"] < 0.99


def test_facts_of_the_file(run, tmp_path):
    rgb = textures.standard(48, 64)
    alpha = np.full((48, 64, 1), 255, np.uint8)
    chunks = [
        (b"gAMA", (45455).to_bytes(4, "big")),
        (b"sRGB", b"\0"),
        (b"cICP", bytes([1, 13, 0, 1])),
    ]
    write_png(tmp_path / "a_n.png", np.dstack([rgb, alpha]), chunks=chunks)
    file = only(run, "a_n.png", code=0)
    assert {"NT040", "NT041", "NT051"} <= ids(file, "info")
    color = [f["message"] for f in file["findings"] if f["id"] == "NT040"]
    assert color == ["contains color information (sRGB, gAMA, cICP): ignore it"]
    write_png(tmp_path / "b_n.png", rgb.astype(np.uint16) * 257)
    file = only(run, "b_n.png", code=0)
    assert "NT034" in ids(file) and file["bit_depth"] == 16
    assert file["fail"] == {"neighbor": 0, "rounded": 0, "exact": 0}


def test_tilt(run, tmp_path):
    p, q = textures.slopes(steepness=0.2)
    m = 255
    n = np.dstack([-(p + 0.4), -q, np.ones_like(p)])
    n /= np.linalg.norm(n, axis=2, keepdims=True)
    rg = np.floor((n[..., :2] + 1) / 2 * m + 0.5).astype(np.int64)
    b = oracle.derived_blues(rg[..., 0], rg[..., 1], m)
    write_png(tmp_path / "a_n.png", np.dstack([rg, b]).astype(np.uint8))
    assert "NT022" in ids(only(run, "a_n.png"), "warning")
    assert "NT022" not in ids(only(run, "a_n.png", "--max-tilt", "0.9"))


def test_text_summary_quiet_verbose(run, tmp_path):
    (tmp_path / "d").mkdir()
    write_png(tmp_path / "d/a_n.png", textures.standard())
    write_png(tmp_path / "d/b_n.png", textures.wrong_blue(textures.standard(seed=5), 0.1))
    write_png(tmp_path / "d/photo.png", textures.photograph())
    write_png(tmp_path / "d/bump.png", textures.heights())
    done = run("check", "d")
    assert done.returncode == 1
    lines = done.stdout.splitlines()
    assert [line.split(":")[0] for line in lines if line.startswith("d/")] == [
        "d/a_n.png",
        "d/b_n.png",
        "d/bump.png",
        "d/photo.png",
    ]
    assert "4 files: 2 standard" in done.stdout and "1 height map" in done.stdout
    quiet = run("check", "-q", "d").stdout
    assert "b_n.png" in quiet and "a_n.png" not in quiet and "photo" not in quiet
    loud = run("check", "-v", "d").stdout
    assert "because" in loud and "fail rounded" in loud
    summary = report(run, "d")["summary"]
    assert summary["files"] == 4 and summary["not_counted"] == 2
    assert summary["with_errors"] == 1 and summary["well_formed"] == 1


def test_names_count_in_directories(run, tmp_path):
    write_png(tmp_path / "photo.png", textures.photograph())
    assert run("check", ".", "--allow-empty").returncode == 0
    assert run("check", "photo.png").returncode == 1  # named: judged
    write_png(tmp_path / "wall_normal.png", textures.photograph())
    assert run("check", ".").returncode == 1  # named like a normals texture


def test_list_and_csv(run, tmp_path):
    write_png(tmp_path / "a, b_n.png", textures.standard())
    write_png(tmp_path / "b_n.png", textures.wrong_blue(textures.standard(), 0.1))
    write_png(tmp_path / "c_n.png", textures.wrong_blue(textures.standard(), 0.01))
    assert run("check", ".", "--format", "list").stdout == "./b_n.png\n"
    done = run("check", ".", "--format", "list", "-0", "--fail-on", "warning")
    assert done.stdout == "./b_n.png\0./c_n.png\0"
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    done = run("check", ".", "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    assert done.returncode == 3
    assert [r["path"] for r in rows] == ["./a, b_n.png", "./b_n.png", "./broken.png", "./c_n.png"]
    assert rows[1]["errors"] == "1" and rows[2]["status"] == "unreadable" and rows[2]["message"]
    assert None not in rows[0] and None not in rows[2].values()


def test_baseline(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.wrong_blue(textures.standard(), 0.1))
    before = run("check", "a_n.png", "--format", "json")
    (tmp_path / "before.json").write_text(before.stdout)
    assert before.returncode == 1
    assert run("check", "a_n.png", "--baseline", "before.json").returncode == 0
    out = report(run, "a_n.png", "--baseline", "before.json", code=0)
    assert all(f["baseline"] for f in out["files"][0]["findings"])
    assert out["summary"]["failing"] == 0 and out["summary"]["in_baseline"] > 0
    write_png(tmp_path / "b_n.png", textures.wrong_blue(textures.standard(), 0.1))
    done = run("check", "a_n.png", "b_n.png", "--baseline", "before.json", "--format", "list")
    assert (done.returncode, done.stdout) == (1, "b_n.png\n")
    (tmp_path / "bad.json").write_text("{]")
    assert run("check", "a_n.png", "--baseline", "bad.json").returncode == 2
    assert run("check", "a_n.png", "--baseline", "none.json").returncode == 2


def test_unreadable_files(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.wrong_blue(textures.standard(), 0.1))
    whole = (tmp_path / "a_n.png").read_bytes()
    broken = {
        "empty.png": b"",
        "signature.png": whole[:8],
        "cut.png": whole[: len(whole) // 2],
        "crc.png": whole[:20] + bytes([whole[20] ^ 1]) + whole[21:],
        "text.png": b"this is not an image\n" * 20,
        "lfs.png": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
        "zero.png": whole[:8] + chunk(b"IHDR", bytes(8) + b"\x08\x02\0\0\0") + whole[33:],
    }
    for name, data in broken.items():
        (tmp_path / name).write_bytes(data)
        done = run("check", name)
        assert done.returncode == 3, name
        assert name in done.stderr and not done.stdout
    out = report(run, "a_n.png", "empty.png", "missing.png", code=3)  # 3 before 1
    assert [f["status"] for f in out["files"]] == ["ok", "unreadable", "unreadable"]
    assert all(f["type"] is None and f["findings"] == [] for f in out["files"][1:])
    assert out["summary"]["unreadable"] == 2


def test_limits(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.standard())
    assert run("check", "a_n.png", "--max-side", "63").returncode == 3
    assert run("check", "a_n.png", "--max-texels", "4095").returncode == 3
    assert run("check", "a_n.png", "--max-side", "64", "--max-texels", "4096").returncode == 0


def test_color(run, tmp_path, monkeypatch):
    write_png(tmp_path / "a_n.png", textures.standard())
    assert "\033" not in run("check", "a_n.png").stdout
    assert "\033[" in run("check", "a_n.png", "--color", "always").stdout
    monkeypatch.setenv("CLICOLOR_FORCE", "1")
    assert "\033[" in run("check", "a_n.png").stdout
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\033[" not in run("check", "a_n.png").stdout
    assert "\033[" in run("check", "a_n.png", "--color=always").stdout


def test_findings_page_is_the_table(run):
    page = (libntp_ffi.ROOT / "docs/findings.md").read_text()
    assert run("--generate", "findings").stdout == page
