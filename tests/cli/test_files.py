# SPDX-License-Identifier: MIT
"""Files and directories: hostile names, scans, collisions, and outputs that cannot be written."""

import base64
import json
import os
import shutil
import signal
import struct
import subprocess
import zlib

import numpy as np
import pytest

from support import textures
from support.held import while_writing
from support.pngs import read_png, write_png
from support.spawn import spawn

HOSTILE = [
    b"two words_n.png",
    b"new\nline_n.png",
    b"percent%n%s_n.png",
    b"caf\xe9_n.png",
    "straße_n.png".encode(),
    b"-dash_n.png",
    b"quote'\"_n.png",
    b"esc\x1b[31m_n.png",
]


def listed(run, *args):
    done = run("check", "--format", "json", *args)
    return [f["path"] for f in json.loads(done.stdout)["files"]]


@pytest.fixture
def tree(tmp_path):
    """A small tree of textures."""
    for name in ("b_n.png", "a_n.png", "sub/c_n.png", "sub/deep/d_n.png", "sub/skip_n.png"):
        path = tmp_path / "t" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_png(path, textures.standard(8, 8))
    (tmp_path / "t/notes.txt").write_text("no image")
    return tmp_path / "t"


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_names(run, program, tmp_path, name):
    directory = os.fsencode(tmp_path)
    write_png(os.path.join(directory, name), textures.standard(8, 8))
    plain = spawn([os.fsencode(program), b"check", b"--", name], cwd=directory)
    assert plain.returncode == 0 and plain.stdout.count(b"\n") == 1 and b"\x1b" not in plain.stdout
    plain.stdout.decode()
    out = spawn(
        [os.fsencode(program), b"check", b"--format", b"json", b"--", name],
        cwd=directory,
    )
    (file,) = json.loads(out.stdout)["files"]
    raw = base64.b64decode(file["path_base64"]) if "path_base64" in file else file["path"].encode()
    assert raw == name
    done = spawn(
        [os.fsencode(program), b"clean", b"-o", b"out/", b"--", name],
        cwd=directory,
    )
    assert done.returncode == 0 and os.path.exists(os.path.join(directory, b"out", name))
    listing = name + b"\0"
    done = spawn(
        [os.fsencode(program), b"check", b"--files-from", b"-", b"-0"],
        cwd=directory,
        input=listing,
    )
    assert done.returncode == 0 and done.stdout == plain.stdout


def test_missing_hostile_name(run):
    done = run("check", "no%n%s\nsuch\x1b.png")
    assert done.returncode == 3 and "\x1b" not in done.stderr and done.stderr.count("\n") == 1


def test_directories(run, tree):
    assert listed(run, "t") == ["t/a_n.png", "t/b_n.png"]
    everything = [
        "t/a_n.png",
        "t/b_n.png",
        "t/sub/c_n.png",
        "t/sub/deep/d_n.png",
        "t/sub/skip_n.png",
    ]
    assert listed(run, "-r", "t") == everything
    assert listed(run, "-r", "t", "--exclude", "skip*") == everything[:4]
    assert listed(run, "-r", "t", "--exclude", "sub/deep") == everything[:3] + everything[4:]
    assert listed(run, "-r", "t", "--match", "[ac]_n.png") == ["t/a_n.png", "t/sub/c_n.png"]
    assert listed(run, "-r", "t", "--match", "sub/*") == everything[2:]
    # named first, in the order given; each file once
    assert listed(run, "t/sub/c_n.png", "-r", "t", "./t/a_n.png") == [
        "t/sub/c_n.png",
        "t/a_n.png",
        "t/b_n.png",
        "t/sub/deep/d_n.png",
        "t/sub/skip_n.png",
    ]


def test_patterns(run, tree):
    assert listed(run, "t/[ab]_n.png") == ["t/a_n.png", "t/b_n.png"]
    assert listed(run, "t/sub/*/?_n.png") == ["t/sub/deep/d_n.png"]
    (tree / "[ab]_n.png").write_bytes((tree / "a_n.png").read_bytes())
    assert listed(run, "t/[ab]_n.png") == ["t/[ab]_n.png"]  # a file of that very name
    assert run("check", "t/*.gif").returncode == 3


def test_links(run, tree):
    (tree / "sub/loop").symlink_to(tree)
    (tree / "again_n.png").symlink_to(tree / "b_n.png")
    (tree / "dangling_n.png").symlink_to(tree / "nothing")
    done = run("check", "-r", "t", "--format", "json")
    files = json.loads(done.stdout)["files"]
    assert done.returncode == 3  # the dangling link cannot be read
    names = [f["path"] for f in files]
    assert "t/b_n.png" not in names and "t/again_n.png" in names and len(names) == 6
    both = ["t/again_n.png", "t/b_n.png"]
    assert listed(run, *both, "./t/b_n.png", "t//b_n.png") == both  # what is named is judged
    assert run("clean", *both, "-o", "out").returncode == 0
    assert sorted(os.listdir(tree.parent / "out")) == ["again_n.png", "b_n.png"]


def test_empty_directory(run, tmp_path):
    (tmp_path / "d").mkdir()
    for args in (["check", "d"], ["clean", "d", "-o", "out"], ["from-height", "d", "-o", "out"]):
        scale = ["--scale", "2"] if args[0] == "from-height" else []
        done = run(*args, *scale)
        assert done.returncode == 3 and "no image" in done.stderr, args
        done = run(*args, *scale, "--allow-empty")
        assert done.returncode == 0 and not done.stderr, args
    (tmp_path / "list").write_text("")
    assert run("check", "--files-from", "list").returncode == 3
    done = run("check", "--files-from", "list", "--allow-empty", "--format", "json")
    assert done.returncode == 0 and json.loads(done.stdout)["summary"]["files"] == 0


def test_nothing_checked(run, tmp_path):
    """A directory of other images; with one normals texture, or a named file, something is."""
    for name in ("d/a.png", "d/b.png"):
        (tmp_path / "d").mkdir(exist_ok=True)
        write_png(tmp_path / name, textures.photograph())
    done = run("check", "d")
    assert done.returncode == 3 and "nothing was checked: of 2 images" in done.stderr
    assert run("check", "d", "--allow-empty").returncode == 0
    assert "nothing" not in run("check", "d/a.png").stderr
    write_png(tmp_path / "d/c_n.png", textures.standard())
    done = run("check", "d")
    assert done.returncode == 0 and not done.stderr
    (tmp_path / "d/c_n.png").write_bytes(b"no image")
    assert run("check", "d", "--allow-empty").returncode == 3  # it is still unreadable


FOREIGN = {
    "brick_normal.tif": b"II*\0" + bytes(99),
    "brick_n.psd": b"8BPS" + bytes(99),
    "brick_nrm.avif": b"\0\0\0\x20ftypavif" + bytes(99),
    "BrickNormalGL.HDR": b"#?RADIANCE" + bytes(99),
    "sub/brick_normals.bmp": b"BM" + bytes(99),
    "sub/brick_normal.ktx": b"\xabKTX 11\xbb\r\n\x1a\n" + bytes(99),
}


def test_textures_that_cannot_be_read_are_told(run, tree):
    """By the name of a normals texture; others, such as photographs, are none of ours."""
    for name, data in FOREIGN.items():
        (tree / name).write_bytes(data)
    for name in ("brick_albedo.tif", "notes_normal.txt", "brick_normal"):
        (tree / name).write_bytes(FOREIGN["brick_normal.tif"])
    done = run("check", "-r", "t", "--format", "json")
    out = json.loads(done.stdout)
    bad = {f["path"]: f for f in out["files"] if f["status"] == "unreadable"}
    assert done.returncode == 3 and set(bad) == {f"t/{name}" for name in FOREIGN}
    for name in FOREIGN:
        assert "not read" in bad[f"t/{name}"]["message"] and f"t/{name}: " in done.stderr
    assert out["summary"]["unsupported"] == out["summary"]["unreadable"] == len(FOREIGN)
    assert out["summary"]["files"] == len(FOREIGN) + 5
    text = run("check", "-r", "t").stdout
    assert "6 unreadable (6 of formats that are not read)" in text
    done = run("clean", "-r", "t", "-o", "out", "--format", "json")
    summary = json.loads(done.stdout)["summary"]
    assert done.returncode == 3 and summary["failed"] == summary["unsupported"] == 6
    left_out = [f"--exclude=*{os.path.splitext(name)[1]}" for name in FOREIGN]
    assert run("check", "-r", "t", *left_out).returncode == 0
    assert run("check", "-r", "t", "--match", "*_n.png").returncode == 0
    done = run("from-height", "-r", "t", "-o", "heights", "--scale", "2", "--format", "json")
    assert json.loads(done.stdout)["summary"]["unsupported"] == 0  # its inputs are heights


def test_content_decides_under_a_foreign_name(run, tmp_path):
    (tmp_path / "d").mkdir()
    write_png(tmp_path / "a.png", textures.standard())
    (tmp_path / "d/a_n.bmp").write_bytes((tmp_path / "a.png").read_bytes())
    done = run("check", "d", "--format", "json")
    (file,) = json.loads(done.stdout)["files"]
    assert done.returncode == 0 and file["format"] == "png"


def test_files_from(run, tree, tmp_path):
    (tmp_path / "list").write_text("t/b_n.png\n\nt/sub/c_n.png\n")
    assert listed(run, "--files-from", "list") == ["t/b_n.png", "t/sub/c_n.png"]
    done = run("clean", "--files-from", "list", "-o", "out")
    assert done.returncode == 0
    assert (tmp_path / "out/t/b_n.png").exists() and (tmp_path / "out/t/sub/c_n.png").exists()
    assert run("check", "--files-from", "missing").returncode == 2


def test_files_from_windows(run, tree, tmp_path):
    """Lines end with a carriage return and a newline."""
    (tmp_path / "list").write_bytes(b"t/b_n.png\r\n\r\nt/sub/c_n.png\r\n")
    assert listed(run, "--files-from", "list") == ["t/b_n.png", "t/sub/c_n.png"]


def test_carriage_return_in_a_name(run, tree, tmp_path):
    """What ends a line in a list from Windows may be part of a name here."""
    (tmp_path / "list").write_bytes(b"t/b_n.png\r\n\r\nt/sub/c_n.png\r\n")
    (tree / "b_n.png\r").write_bytes((tree / "b_n.png").read_bytes())
    assert listed(run, "--files-from", "list") == ["t/b_n.png\r", "t/sub/c_n.png"]
    (tmp_path / "list").write_bytes(b"t/a_n.png\r\0")
    done = run("check", "--files-from", "list", "-0")
    assert done.returncode == 3  # names that end with a NUL are exact


def png_chunk(kind, data):
    crc = zlib.crc32(kind + data)
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", crc)


@pytest.mark.parametrize("interlaced", [0, 1])
@pytest.mark.parametrize("surplus", [0, 1 << 12, 64 << 20])
def test_data_after_the_picture(run, tmp_path, interlaced, surplus):
    """64 MB of zeros in 64 KB: where there is so much, nothing behind the picture is read."""
    side = 64
    rows = 15 * side // 8 if interlaced else side  # of all passes
    picture = bytes(rows + 3 * side * side)  # black
    data = bytearray(zlib.compress(picture + bytes(surplus), 9))
    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, interlaced)
    parts = [png_chunk(b"IHDR", header), png_chunk(b"IDAT", bytes(data))]
    whole = [*parts, png_chunk(b"IEND", b"")]
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(whole))
    done = run("check", "a.png", "--format", "json")
    (file,) = json.loads(done.stdout)["files"]
    assert file["status"] == "ok" and file["unused"] == side * side, done.stderr
    wrong = bytearray(parts[1])
    wrong[-1] ^= 1  # the checksum, which follows the surplus
    whole = [parts[0], bytes(wrong), png_chunk(b"IEND", b"")]
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(whole))
    assert (run("check", "a.png").returncode == 3) == (surplus < 64 << 20)


def test_output_directory_keeps_paths(run, tree, tmp_path):
    assert run("clean", "-r", "t", "-o", "out").returncode == 0
    made = sorted(str(p.relative_to(tmp_path / "out")) for p in (tmp_path / "out").rglob("*.png"))
    assert made == ["a_n.png", "b_n.png", "sub/c_n.png", "sub/deep/d_n.png", "sub/skip_n.png"]


def test_collisions_and_usage(run, tree, tmp_path):
    def wrong(*args):
        done = run("clean", *args)
        assert done.returncode == 2 and done.stderr and not done.stdout, args
        assert not (tmp_path / "out").exists()
        return done.stderr

    shutil.copytree(tree, tmp_path / "u")
    wrong("t/a_n.png", "u/a_n.png", "-o", "out")  # one output for two inputs
    wrong("t/a_n.png", "t/b_n.png", "-o", "out.png")
    wrong("t/a_n.png")  # no -o
    wrong("t/a_n.png", "-o", "out", "--in-place")
    wrong("t/a_n.png", "-o", "t")  # an input
    wrong("t/a_n.png", "-o", "t/sub/..")
    os.symlink(tree, tmp_path / "same")
    wrong("t/a_n.png", "-o", "same")
    wrong("-r", "t", "-o", "t/")
    wrong("t/a_n.png", "t/b_n.png", "-o", "t")
    for name in ("out.jpg", "out.JPE", "out.bmp", "out.tiff"):
        assert name in wrong("t/a_n.png", "-o", name)
    wrong("-", "--in-place")
    assert sorted(p.name for p in tree.iterdir()) == ["a_n.png", "b_n.png", "notes.txt", "sub"]


def test_standard_streams(program, tmp_path):
    before = textures.wrong_blue(textures.zzero(), 0.1)  # needs a second pass
    write_png(tmp_path / "a.png", before)
    data = (tmp_path / "a.png").read_bytes()
    done = spawn([program, "clean", "-", "-o", "-", "--method", "derive"], input=data)
    assert done.returncode == 0, done.stderr
    (tmp_path / "b.png").write_bytes(done.stdout)
    assert np.array_equal(read_png(tmp_path / "b.png")[0], textures.zzero())
    assert b"changed" in done.stderr
    done = spawn([program, "check", "-"], input=data)
    assert done.returncode == 1 and done.stdout.startswith(b"-: Z-zero")


def test_standard_input_by_its_path(program, tmp_path):
    write_png(tmp_path / "a.png", textures.wrong_blue(textures.zzero(), 0.1))
    pipe = f"cat a.png | '{program}' check /dev/stdin"
    assert spawn(["sh", "-c", pipe], cwd=tmp_path).returncode == 1


def test_order_does_not_depend_on_jobs(run, tmp_path):
    for i in range(40):
        size = 200 if i % 7 == 0 else 8
        write_png(tmp_path / f"{i:02}_n.png", textures.standard(size, size, i))
    one = run("check", ".", "--jobs", "1", "--format", "json").stdout
    assert one == run("check", ".", "--jobs", "8", "--format", "json").stdout
    assert one == run("check", ".", "--format", "json").stdout
    text = run("clean", ".", "-o", "a", "-j", "1").stdout
    assert text.replace("a/", "b/") == run("clean", ".", "-o", "b", "-j", "7").stdout
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


def test_read_only_directory(program, tmp_path):
    """Root may write anywhere, and so gives up that privilege."""
    write_png(tmp_path / "a_n.png", textures.standard())
    locked = tmp_path / "locked"
    locked.mkdir()
    write_png(locked / "a_n.png", textures.wrong_blue(textures.standard(), 0.1))
    before = (locked / "a_n.png").read_bytes()
    prefix = []
    if os.geteuid() == 0:
        if shutil.which("setpriv") is None:
            pytest.skip("setpriv is missing")
        prefix = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"]
    locked.chmod(0o555)
    try:
        for args in (["--in-place", "locked"], ["-o", "locked/b.png", "a_n.png"]):
            done = spawn([*prefix, program, "clean", *args], cwd=tmp_path, text=True)
            assert done.returncode == 3 and "locked" in done.stderr, done
        args = ["-o", "locked/new/b.png", "a_n.png"]
        done = spawn([*prefix, program, "clean", *args], cwd=tmp_path)
        assert done.returncode == 3
        assert [p.name for p in locked.iterdir()] == ["a_n.png"]
        assert (locked / "a_n.png").read_bytes() == before
    finally:
        locked.chmod(0o755)


def test_full_disk(run, tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(disk)]
    if os.geteuid() != 0 or spawn(mount).returncode != 0:
        pytest.skip("a small file system cannot be mounted")
    try:
        write_png(disk / "a_n.png", textures.wrong_blue(textures.standard(96, 96), 0.1))
        before = (disk / "a_n.png").read_bytes()
        big = np.random.default_rng(1).integers(0, 256, (300, 300, 3)).astype(np.uint8)
        write_png(tmp_path / "big_n.png", big)
        done = run("clean", "big_n.png", "-o", "disk/b.png", "--type", "standard")
        assert done.returncode == 3 and "space" in done.stderr
        assert [p.name for p in disk.iterdir()] == ["a_n.png"]
        assert (disk / "a_n.png").read_bytes() == before
        report = tmp_path / "ok_n.png"
        write_png(report, textures.standard())
    finally:
        subprocess.run(["umount", str(disk)], check=False)


def interrupted(program, directory, number):
    """The exit code of a `clean` that gets a signal while it writes."""
    noise = np.random.default_rng(1).integers(0, 256, (1500, 1500, 3)).astype(np.uint8)
    write_png(directory / "big_n.png", noise)
    args = [program, "clean", "big_n.png", "-o", "out_n.png", "--type", "standard", "--level", "9"]

    def prepare():
        write_png(directory / "out_n.png", textures.standard())

    return while_writing(args, directory, prepare, lambda process: process.send_signal(number))[0]


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_ended_while_writing(program, tmp_path, number):
    """The old file stays whole, and after an orderly end nothing stays beside it."""
    code = interrupted(program, tmp_path, number)
    assert code == (130 if number == signal.SIGINT else -number)
    assert np.array_equal(read_png(tmp_path / "out_n.png")[0], textures.standard())
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"big_n.png", "out_n.png"} or number == signal.SIGKILL
