# SPDX-License-Identifier: MIT
"""ntp on DDS and KTX2: what a check says, which image is read, and that none is written."""

import json

import numpy as np

from support import oracle_blocks, textures
from support.gpu_textures import bc5_bytes, dds, ktx2
from support.pngs import read_png

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


def test_neither_is_written(run, tmp_path):
    spoiled = textures.wrong_blue(GOOD, 0.1)
    (tmp_path / "a_n.ktx2").write_bytes(ktx2(48, 32, [spoiled.tobytes()], 23))
    before = (tmp_path / "a_n.ktx2").read_bytes()
    done = run("clean", "--in-place", "a_n.ktx2")
    assert done.returncode == 3 and "KTX2 is not written; give -o for a PNG" in done.stderr
    for name in ("b.dds", "b.ktx2"):
        done = run("clean", "a_n.ktx2", "-o", name)
        assert done.returncode == 2 and "not written; use .png" in done.stderr
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
