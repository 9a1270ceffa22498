# SPDX-License-Identifier: MIT
"""ntp on DDS and KTX2: what a check says, which image is read, and that none is replaced."""

import csv
import json

import numpy as np
import pytest

from support import oracle_blocks, textures
from support.gpu_textures import bc5_bytes, dds, ktx2
from support.pngs import read_png, write_png

GOOD = textures.standard(32, 48)


def check(run, *arguments):
    done = run("check", "--format", "json", *arguments)
    (file,) = json.loads(done.stdout)["files"]
    return done.returncode, file


def test_bc5(run, tmp_path):
    """XY-only without a warning; converted it is what integers make of the blocks."""
    blocks = bc5_bytes(GOOD[..., 0], GOOD[..., 1])
    (tmp_path / "a_n.dds").write_bytes(dds(48, 32, blocks, four=b"ATI2"))
    code, file = check(run, "a_n.dds")
    assert code == 0 and (file["format"], file["type"], file["bit_depth"]) == ("dds", "xy", 16)
    assert {f["id"]: f["level"] for f in file["findings"]}["NT006"] == "info"
    assert not [f for f in file["findings"] if f["level"] != "info"]
    assert "48 x 32 BC5 (ATI2)" in run("check", "a_n.dds").stdout
    assert run("convert", "a_n.dds", "--type", "xy", "--to", "xy", "-o", "b.png").returncode == 0
    levels = read_png(tmp_path / "b.png")[0]
    for y, x in ((0, 0), (3, 7), (7, 11)):
        at = 16 * (12 * y + x)
        want = np.reshape(oracle_blocks.bc5(blocks[at : at + 16]), (4, 4, 2))
        assert np.array_equal(levels[4 * y : 4 * y + 4, 4 * x : 4 * x + 4, :2], want)


def test_mip_and_layer(run, tmp_path):
    half = np.ascontiguousarray(GOOD[::2, ::2])
    (tmp_path / "a_n.ktx2").write_bytes(ktx2(48, 32, [GOOD.tobytes(), half.tobytes()], 23))
    assert check(run, "a_n.ktx2")[1]["width"] == 48
    assert check(run, "a_n.ktx2", "--mip", "1")[1]["width"] == 24
    done = run("check", "a_n.ktx2", "--mip", "2")
    assert done.returncode == 3 and "a_n.ktx2: has no mip 2: there are 2, from 0" in done.stderr
    faces = b"".join(np.roll(GOOD[..., [2, 1, 0]], face, 0).tobytes() for face in range(6))
    square = dds(
        16, 16, faces[: 6 * 16 * 16 * 3], masks=(255, 255 << 8, 255 << 16), bits=24, cube=1
    )
    (tmp_path / "cube_n.dds").write_bytes(square)
    done = run("check", "cube_n.dds")
    assert done.returncode == 3 and "a cube map of 6 textures: pick a layer" in done.stderr
    assert check(run, "cube_n.dds", "--layer", "5")[1]["status"] == "ok"


def test_neither_is_replaced(run, tmp_path):
    spoiled = textures.wrong_blue(GOOD, 0.1)
    (tmp_path / "a_n.ktx2").write_bytes(ktx2(48, 32, [spoiled.tobytes()], 23))
    before = (tmp_path / "a_n.ktx2").read_bytes()
    done = run("clean", "--in-place", "a_n.ktx2")
    assert done.returncode == 3 and "KTX2 is not written; give -o for a PNG" in done.stderr
    for name in ("b.dds", "b.ktx2"):
        done = run("clean", "a_n.ktx2", "-o", name)
        assert done.returncode == 2 and "write .png, then convert it" in done.stderr
        assert not (tmp_path / name).exists()
    assert run("clean", "a_n.ktx2", "-o", "b.png").returncode == 0
    assert (tmp_path / "a_n.ktx2").read_bytes() == before
    done = run("clean", ".", "-o", "out", "--format", "json")
    assert (tmp_path / "out/a_n.png").exists(), done.stdout


def test_what_is_not_read_is_described(run, tmp_path):
    (tmp_path / "a_n.ktx2").write_bytes(ktx2(64, 64, [bytes(4096)], 0, model=166, transfer=2))
    done = run("check", "a_n.ktx2")
    assert done.returncode == 3
    assert "a KTX2 texture of UASTC, 64 x 64, 1 mip, marked sRGB" in done.stderr


def findings(file):
    return {found["id"]: found["level"] for found in file["findings"]}


def test_findings_of_the_file(run, tmp_path):
    """Marked sRGB, blocks, a channel that holds nothing, no mips; and a file with none of these."""
    rgba = np.dstack([GOOD, np.full_like(GOOD[..., 0], 255)]).tobytes()
    small = np.ascontiguousarray(GOOD[::2, ::2, :2])
    pair = np.ascontiguousarray(GOOD[..., :2])
    still = pair.copy()
    still[..., 1] = 255
    made = {
        "srgb_n.dds": dds(48, 32, rgba, dxgi=29),
        "bc7_n.dds": dds(48, 32, bytes([64, 0, 0, 0, 0, 0, 0, 0] * 192), dxgi=98),
        "still_n.ktx2": ktx2(48, 32, [still.tobytes()], 16),
        "good_n.ktx2": ktx2(48, 32, [pair.tobytes(), small.tobytes()], 16),
    }
    for name, data in made.items():
        (tmp_path / name).write_bytes(data)
    out = json.loads(run("check", "--format", "json", *made).stdout)
    found = {file["path"]: findings(file) for file in out["files"]}
    of_gpus = {"NT013", "NT014", "NT036", "NT045", "NT053"}
    assert found["srgb_n.dds"]["NT045"] == "warning" and found["srgb_n.dds"]["NT053"] == "info"
    assert found["bc7_n.dds"]["NT036"] == "info" and "NT041" not in found["bc7_n.dds"]
    assert found["still_n.ktx2"]["NT014"] == "warning"
    assert not of_gpus & set(found["good_n.ktx2"])


@pytest.mark.parametrize("down", [False, True])
def test_exchanged_x_and_y(run, tmp_path, down):
    """Of a surface, with green either way: told where x and y are exchanged, and only there."""
    image = textures.standard(128, 128)
    x, y = image[..., 0], image[..., 1]
    y = 255 - y if down else y
    for name, channels in (("right", (x, y)), ("exchanged", (y, x))):
        (tmp_path / f"{name}_n.dds").write_bytes(dds(128, 128, bc5_bytes(*channels), four=b"ATI2"))
    assert "NT013" not in findings(check(run, "right_n.dds")[1])
    code, file = check(run, "exchanged_n.dds")
    assert code == 1 and findings(file)["NT013"] == "error"


def test_exchanged_in_the_corpus(run, corpus, tmp_path):
    """None of the real textures is accused; exchanged, most of these small ones are told."""
    names = []
    with open(corpus / "manifest.csv", encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["kind"] == "normals"]
    for row in rows:
        if row["format"] != "PNG" or not row["mode"].startswith("RGB"):
            continue
        if int(row["width"]) * int(row["height"]) > 300_000:  # the test's own reader is slow
            continue
        if (corpus / row["file"]).read_bytes()[28]:  # interlaced
            continue
        pair = read_png(corpus / row["file"])[0][:512, :512, :2]
        for kind, order in (("right", (0, 1)), ("exchanged", (1, 0))):
            body = np.ascontiguousarray(pair[..., order]).tobytes()
            name = f"{len(names)}_{kind}_n.ktx2"
            (tmp_path / name).write_bytes(ktx2(pair.shape[1], pair.shape[0], [body], 16))
            names.append(name)
    files = json.loads(run("check", "--format", "json", "--type", "xy", *names).stdout)["files"]
    told = {file["path"] for file in files if "NT013" in findings(file)}
    assert not [name for name in told if "right" in name]
    assert len(told) >= 0.75 * len(names) / 2, (len(told), len(names) / 2)


def test_fieldstone(run, corpus, tmp_path):
    """A shipped ATI2 with y before x: put right, it is 1.49 degrees from its source."""
    shipped = corpus / "bgfx/fieldstone-n.dds"
    assert findings(check(run, shipped)[1])["NT013"] == "error"
    assert run("convert", "--from-channels", "yx", shipped, "-o", "a.png").returncode == 0
    done = run("diff", "--format", "json", "a.png", corpus / "bgfx/fieldstone-n.tga")
    assert 1.48 < json.loads(done.stdout)["angle_deg"]["mean"] < 1.50


def vectors(x, y):
    """Unit vectors of components in -1..1."""
    z = np.sqrt(np.maximum(1 - x * x - y * y, 0))
    v = np.stack([x, y, z], -1)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def angles(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(-1)))


def to_16_bit(v):
    return np.floor((v[..., :2] + 1) / 2 * 65535 + 0.5).astype("<u2").tobytes()


def test_diff_of_a_source_and_its_blocks(run, tmp_path):
    """Angles, mips and the worst block are those of numpy; the mean decides about --fail-over."""
    source = textures.standard(32, 48, depth=16)
    write_png(tmp_path / "a.png", source)
    x, y = (source[..., :2].astype(np.float64) * 2 / 65535 - 1).transpose(2, 0, 1)
    whole = vectors(x, y)
    spoiled = whole.copy()
    spoiled[8:12, 20:24, :2] *= -0.5
    right = whole.reshape(16, 2, 24, 2, 3).mean((1, 3))
    right /= np.linalg.norm(right, axis=-1, keepdims=True)
    tilted = right.copy()
    tilted[..., 0] *= 0.7
    levels = [to_16_bit(spoiled), to_16_bit(tilted)]
    (tmp_path / "b.ktx2").write_bytes(ktx2(48, 32, levels, 77))
    done = run("diff", "a.png", "b.ktx2", "--format", "json")
    out = json.loads(done.stdout)
    stored = [
        np.frombuffer(level, "<u2").reshape(*shape, 2).astype(np.float64) * 2 / 65535 - 1
        for level, shape in zip(levels, ((32, 48), (16, 24)), strict=True)
    ]
    want = angles(whole, vectors(stored[0][..., 0], stored[0][..., 1]))
    assert done.returncode == 1
    assert out["angle_deg"]["mean"] == pytest.approx(want.mean(), abs=0.002)
    assert out["angle_deg"]["max"] == pytest.approx(want.max(), abs=0.01)
    (mip,) = out["mips"]
    want_mip = angles(right, vectors(stored[1][..., 0], stored[1][..., 1]))
    assert (mip["mip"], mip["width"], mip["height"]) == (1, 24, 16)
    assert mip["angle_deg"]["mean"] == pytest.approx(want_mip.mean(), abs=0.002)
    worst = out["worst_blocks"]
    by_block = want.reshape(8, 4, 12, 4).mean((1, 3))
    assert (worst[0]["x"], worst[0]["y"]) == (20, 8) and len(worst) <= 10
    assert worst[0]["angle_deg"]["mean"] == pytest.approx(by_block[2, 5], abs=0.002)
    text = run("diff", "a.png", "b.ktx2").stdout
    assert "24 x 16" in text and "20, 8 " in text
    most = max(want.mean(), want_mip.mean())
    assert run("diff", "a.png", "b.ktx2", "--fail-over", f"{most + 0.01:.3f}").returncode == 0
    assert run("diff", "a.png", "b.ktx2", "--fail-over", f"{most - 0.01:.3f}").returncode == 1
    assert run("diff", "b.ktx2", "a.png").returncode == 1  # in either order


def test_diff_matches_green(run, tmp_path):
    """Of a texture whose green surely points the other way."""
    image = textures.standard(128, 128)
    write_png(tmp_path / "up.png", image)
    down = np.ascontiguousarray(np.dstack([image[..., 0], 255 - image[..., 1]]))
    (tmp_path / "down.ktx2").write_bytes(ktx2(128, 128, [down.tobytes()], 16))
    done = run("diff", "up.png", "down.ktx2", "--format", "json")
    assert json.loads(done.stdout)["angle_deg"]["mean"] == 0


def test_mips_that_are_plain_means(run, tmp_path):
    """Told of plain means, also with noise as of compression; not of right mips with that noise."""
    source = textures.standard(128, 128, depth=16)
    x, y = (source[..., :2].astype(np.float64) * 2 / 65535 - 1).transpose(2, 0, 1)
    whole = vectors(x, y)
    rng = np.random.default_rng(7)
    for noise in (0, 0.02):
        right, plain = [to_16_bit(whole)], [to_16_bit(whole)]
        for side in (2, 4, 8):
            n = 128 // side
            mean = whole.reshape(n, side, n, side, 3).mean((1, 3))
            error = rng.normal(0, noise, (n, n, 2))
            plain.append(to_16_bit(np.clip(mean[..., :2] + error, -0.99, 0.99)))
            unit = mean / np.linalg.norm(mean, axis=-1, keepdims=True)
            right.append(to_16_bit(np.clip(unit[..., :2] + error, -0.99, 0.99)))
        (tmp_path / "right_n.ktx2").write_bytes(ktx2(128, 128, right, 77))
        (tmp_path / "plain_n.ktx2").write_bytes(ktx2(128, 128, plain, 77))
        assert "NT054" not in findings(check(run, "right_n.ktx2")[1])
        assert "NT054" in findings(check(run, "plain_n.ktx2")[1])
