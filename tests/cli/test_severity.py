# SPDX-License-Identifier: MIT
"""ntp check: what makes wrong texels a note, a warning or an error; baselines; counts."""

import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from support import encoders, libntp_ffi, oracle, schemas, textures
from support.pngs import write_png

CORPUS = libntp_ffi.ROOT.parent / "shared/corpus"
LEVELS = ["info", "warning", "error"]
ABOUT_TEXELS = {"NT001", "NT002", "NT003"}


def report(run, *args):
    out = json.loads(run("check", "--format", "json", *args).stdout)
    schemas.validate(out, "check-1")
    return out


def found(file, level=None):
    return {f["id"]: f["level"] for f in file["findings"] if level in (None, f["level"])}


def only(run, *args):
    (file,) = report(run, *args)["files"]
    return file


def hemisphere(n=501, longest=1.0):
    """Unit vectors of a fine grid, with every texel used: outside of the disc they are its rim."""
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n))
    length = np.maximum(np.hypot(x, y), 1e-9)
    shorter = np.minimum(length, longest) / length
    x, y = x * shorter, y * shorter
    return np.dstack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))])


def files_of(tmp_path, pixels):
    """The same texels as PNG and as TGA."""
    write_png(tmp_path / "a_n.png", pixels)
    yield "a_n.png"
    if pixels.dtype == np.uint8:
        h, w = pixels.shape[:2]
        head = bytes([0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, w & 255, w >> 8, h & 255, h >> 8, 24, 32])
        (tmp_path / "a_n.tga").write_bytes(head + pixels[..., ::-1].tobytes())
        yield "a_n.tga"


@pytest.mark.parametrize("depth", [8, 16])
@pytest.mark.parametrize("longest", [1.0, 0.9])
@pytest.mark.parametrize("kind", ["standard", "zzero", "xy"])
def test_no_exact_encoder_has_more_than_notes(run, tmp_path, depth, longest, kind):
    """An encoder in numpy rounds each channel of unit vectors; at the rim red and green get too
    long by that, which is no fault."""
    m = 2**depth - 1
    n = hemisphere(longest=longest)
    pixels = encoders.encode(n, m)
    if kind == "zzero":
        pixels[..., 2] = np.floor(n[..., 2] * m + 0.5)
    elif kind == "xy":
        pixels[..., 2] = m // 3
    if longest == 1:
        assert np.any(oracle.radicands(*pixels[..., :2].astype(np.int64).transpose(2, 0, 1), m) < 0)
    for name in files_of(tmp_path, encoders.to_type(pixels, m)):
        file = only(run, "--type", kind, name)
        above = {i for i, level in found(file).items() if level != "info"}
        assert not above & ABOUT_TEXELS, file["findings"]
        assert all(file["harm"][k]["texels"] == 0 for k in ("length", "xy", "z_negative"))


@pytest.mark.parametrize("method", ["derive", "normalize", "auto"])
def test_nothing_that_clean_writes_has_more_than_notes(run, tmp_path, method):
    folders = [libntp_ffi.ROOT / "test_files"]
    folders += [CORPUS] if CORPUS.is_dir() else []
    for folder in folders:
        # of what is refused or broken there is no output
        run("clean", "-r", folder, "-o", f"out/{folder.name}", "--method", method, "--level", "1")
    checked = report(run, "-r", "out")["files"]
    assert len(checked) > 30
    for file in checked:
        above = {i for i, level in found(file).items() if level != "info"}
        assert not above & ABOUT_TEXELS, (file["path"], file["findings"])


def turned(degrees, share, n=200):
    """Gentle normals; in a share of the texels z is such that the vector is turned so far."""
    rng = np.random.default_rng(5)
    tilt = np.radians(35)
    around = rng.uniform(0, 2 * np.pi, (n, n))
    x, y = np.sin(tilt) * np.cos(around), np.sin(tilt) * np.sin(around)
    wrong = np.zeros(n * n, bool)
    wrong[: round(share * n * n)] = True
    angle = np.where(rng.permutation(wrong).reshape(n, n), tilt + np.radians(degrees), tilt)
    z = np.sin(tilt) / np.tan(angle)
    return np.dstack([x, y, z])


@pytest.mark.parametrize(
    "degrees,share,level",
    [
        (8, 0.03, "error"),  # more than 2 % by more than 5 degrees
        (8, 0.015, "warning"),
        (8, 0.0015, "warning"),  # specks
        (8, 0.0005, "info"),
        (4, 0.05, "warning"),  # the 99th percentile is above half of 5 degrees
        (4, 0.9, "warning"),
        (2, 0.9, "warning"),  # on average more than a degree
        (2, 0.05, "info"),
    ],
)
@pytest.mark.parametrize("depth", [8, 16])
def test_the_angle_decides_in_every_format_and_depth(run, tmp_path, depth, degrees, share, level):
    m = 2**depth - 1
    pixels = encoders.to_type(encoders.encode(turned(degrees, share), m), m)
    for name in files_of(tmp_path, pixels):
        file = only(run, "--type", "standard", name)
        assert found(file)["NT001"] == level, file["findings"]
        assert file["harm"]["length"]["texels"] == pytest.approx(share * 40000, abs=20)
        strict = only(run, "--type", "standard", "--policy", "strict", name)
        assert found(strict)["NT001"] == ("error" if share > 0.02 else "warning")


def test_jpeg_is_judged_by_the_same_rule(run, tmp_path):
    from PIL import Image

    for quality, good in ((97, True), (10, False)):
        pixels = encoders.to_type(encoders.encode(hemisphere(256, 0.8)))
        Image.fromarray(pixels).save(tmp_path / "a_n.jpg", quality=quality, subsampling=0)
        decoded = np.asarray(Image.open(tmp_path / "a_n.jpg"))
        write_png(tmp_path / "same_n.png", decoded)
        jpeg, png = (only(run, "--type", "standard", name) for name in ("a_n.jpg", "same_n.png"))
        assert found(jpeg)["NT001"] == found(png)["NT001"], quality
        assert jpeg["harm"] == png["harm"]
        assert (found(jpeg)["NT001"] == "info") == good
        strict = only(run, "--type", "standard", "--policy", "strict", "a_n.jpg")
        assert found(strict)["NT001"] == "error"


def test_limits_are_options(run, tmp_path):
    write_png(tmp_path / "a_n.png", encoders.to_type(encoders.encode(turned(8, 0.03))))
    levels = {}
    for angle, fail in (("5", "2"), ("20", "2"), ("5", "5"), ("40", "5"), ("0", "0")):
        file = only(run, "a_n.png", "--max-angle", angle, "--max-fail", fail)
        levels[angle, fail] = found(file)["NT001"]
        assert file["harm"]["max_angle"] == float(angle)
    assert levels == {
        ("5", "2"): "error",
        ("20", "2"): "info",
        ("5", "5"): "warning",
        ("40", "5"): "info",
        ("0", "0"): "error",
    }
    assert report(run, "a_n.png", "--max-fail", "5")["summary"]["rule"] == {
        "policy": "harm",
        "verdict": "neighbor",
        "max_angle": 5,
        "max_fail": 5,
    }
    assert run("check", "a_n.png", "--max-angle", "181").returncode == 2


def test_tiny_errors_of_16_bit_are_notes(run, tmp_path):
    """Normals that were half floats: all fail the verdict, by a thousandth of a degree."""
    n = hemisphere(128, 0.7).astype(np.float16).astype(np.float64)
    write_png(tmp_path / "a_n.png", encoders.to_type(encoders.encode(n, 65535), 65535))
    file = only(run, "a_n.png")
    assert file["fail"]["neighbor"] > 0.5 * file["texels"]
    assert found(file)["NT001"] == "info" and run("check", "a_n.png").returncode == 0
    assert "no visible errors" in run("check", "a_n.png").stdout
    assert run("check", "a_n.png", "--policy", "strict").returncode == 1


def test_negative_z_by_angle(run, tmp_path):
    n = hemisphere(200, 0.999)
    n[:20, :, 2] *= -1  # the rim: nearly level, and not visibly wrong
    for low, level in ((0.02, "info"), (0.5, "error")):
        below = n.copy()
        below[:20, :, 2] = -low
        below[:20, :, :2] *= (
            np.sqrt(1 - low * low) / np.linalg.norm(below[:20, :, :2], axis=2)[..., None]
        )
        write_png(tmp_path / "a_n.png", encoders.to_type(encoders.encode(below)))
        file = only(run, "--type", "standard", "a_n.png")
        assert found(file)["NT003"] == level
        assert file["harm"]["z_negative"]["texels"] == 20 * 200


@pytest.mark.parametrize("pixel", [(255, 255, 255), (0, 0, 0), (90, 80, 70, 0)])
def test_a_named_file_without_normals_is_not_well_formed(run, tmp_path, pixel):
    pixels = np.full((16, 16, len(pixel)), pixel, np.uint8)
    write_png(tmp_path / "a_n.png", pixels)
    assert found(only(run, "a_n.png"))["NT050"] == "warning"
    assert "no texel holds a normal" in run("check", "a_n.png").stdout


def test_counts_say_whether_unused_texels_are_in(run, tmp_path):
    pixels = textures.wrong_blue(textures.standard(), 0.015)
    pixels[:32] = 0
    write_png(tmp_path / "a_n.png", pixels)
    file = only(run, "a_n.png")
    black = 32 * 64
    assert file["used"]["texels"] == file["texels"] - file["unused"] == black
    for verdict, count in file["fail"].items():
        assert file["used"]["fail"][verdict] == count - black
    assert file["used"]["xy_too_long"] == file["xy_too_long"] - black
    assert file["used"]["z_negative"] == file["z_negative"] - black
    of = {f["id"]: (f["count"], f["count_of"]) for f in file["findings"]}
    assert of["NT001"] == (file["used"]["fail"]["neighbor"], "used")
    assert of["NT042"] == (black, "all")


def test_baseline_knows_a_file_by_any_spelling(run, tmp_path):
    (tmp_path / "d").mkdir()
    bad = textures.wrong_blue(textures.standard(), 0.1)
    names = ["d/a_n.png", os.fsdecode(b"d/\xff_n.png")]
    for name in names:
        write_png(tmp_path / name, bad)
    here = os.fspath(tmp_path.resolve())
    (tmp_path / "x").mkdir()
    spelled = ["d/{}", "./d/{}", "d//./{}", "d/../d/{}", "x/../d/{}", here + "/d/{}"]
    for first in spelled:
        given = [first.format(Path(name).name) for name in names]
        (tmp_path / "before.json").write_text(run("check", *given, "--format", "json").stdout)
        for second in spelled:
            given = [second.format(Path(name).name) for name in names]
            done = run("check", *given, "--baseline", "before.json")
            assert done.returncode == 0, (first, second, done.stdout)
    other = run("check", "d/../d/a_n.png", "--baseline", "before.json", "--type", "standard")
    assert other.returncode == 0
    write_png(tmp_path / "a_n.png", bad)
    assert run("check", "a_n.png", "--baseline", "before.json").returncode == 1


def test_known_errors_are_called_known(run, tmp_path):
    write_png(tmp_path / "a_n.png", textures.wrong_blue(textures.standard(), 0.1))
    write_png(tmp_path / "b_n.png", textures.standard())
    (tmp_path / "before.json").write_text(run("check", "a_n.png", "--format", "json").stdout)
    args = ("a_n.png", "b_n.png", "--baseline", "before.json")
    text = run("check", *args).stdout
    assert text.splitlines()[0].endswith(": 2 known")
    assert text.splitlines()[1].endswith(": well formed")
    assert "1 with known findings only" in text
    summary = report(run, *args)["summary"]
    assert (summary["well_formed"], summary["only_known"]) == (1, 1)
    assert max(map(LEVELS.index, found(report(run, *args)["files"][0]).values())) == 2


def test_what_only_content_suggests_is_not_called_well_formed(run, tmp_path):
    """In a directory it is a note, and the headline says what it would be."""
    (tmp_path / "d").mkdir()
    write_png(tmp_path / "d" / "a.png", textures.wrong_blue(textures.standard(), 0.1))
    write_png(tmp_path / "d" / "b.png", textures.standard())
    text = run("check", "d").stdout.splitlines()
    assert text[0].endswith(": 1 possible error (not named as a normals texture)")
    assert text[1].endswith(": well formed")
    assert "1 without warnings" in text[-1] and "1 with possible ones" in text[-1]
    checked = report(run, "d")
    assert (checked["summary"]["well_formed"], checked["summary"]["possible"]) == (1, 1)
    named = found(report(run, "d/a.png")["files"][0])
    for finding in checked["files"][0]["findings"]:
        assert finding["level"] == "info"
        assert finding.get("level_if_named", "info") == named[finding["id"]]
    (tmp_path / "before.json").write_text(run("check", "d", "--format", "json").stdout)
    assert "possible" not in run("check", "d", "--baseline", "before.json").stdout


def atlas(flip):
    """Bumps on charts amid black, whose green may be flipped as a paint program does it."""
    y, x = np.mgrid[:128, :128] / 128 * 2 * np.pi
    slopes = np.dstack([0.5 * np.sin(2 * x), 0.5 * np.cos(2 * y), np.ones_like(x)])
    pixels = encoders.to_type(encoders.encode(slopes / np.linalg.norm(slopes, axis=2)[..., None]))
    pixels[:, 64:] = 0
    if flip:
        pixels[..., 1] = 255 - pixels[..., 1]
    return pixels


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("name", ["a_n.png", "a_n.jpg"])
def test_padding_does_not_count(run, tmp_path, name, flip):
    quality = {"quality": 95, "subsampling": 0} if name.endswith("jpg") else {}
    Image.fromarray(atlas(flip)).save(tmp_path / name, **quality)
    file = only(run, "--y", "up", name)
    assert (file["type"], found(file, "error")) == ("standard", {})
    assert file["padding"] + file["unused"] == pytest.approx(64 * 128, rel=0.01)
    assert found(file).get("NT044") == ("info" if file["padding"] else None)
    assert (file["padding"] > 0) == flip
    assert file["used"]["texels"] == file["texels"] - file["unused"] - file["padding"]
    assert file["used"]["fail"]["neighbor"] <= 64 * 128
    assert file["used"]["xy_too_long"] + file["used"]["z_negative"] < 200
    assert "NT022" not in found(file)


def test_little_of_a_wrong_color_is_damage(run, tmp_path):
    pixels = atlas(False)
    pixels[:, 64:] = pixels[:, :64]
    pixels[10:20, 10:20] = 0, 255, 200
    write_png(tmp_path / "a_n.png", pixels)
    file = only(run, "a_n.png")
    assert file["padding"] == 0 and found(file)["NT002"] == "warning"
