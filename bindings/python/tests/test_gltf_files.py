# SPDX-License-Identifier: MIT
"""Which files `normaltexture.gltf` opens and writes: none outside of the folder, none half."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from normaltexture import _named, gltf
from normaltexture.gltf import _clean
from pysupport.gltf_models import BAD, GOOD, NOT_READ, model, ntp_gltf, save
from support.pngs import png_bytes, read_png


def test_nothing_is_written_outside(tmp_path):
    inner = tmp_path / "a" / "b"
    inner.mkdir(parents=True)
    made = model()
    path = save(made, inner, "files")
    (tmp_path / "a" / "brick_n.png").write_bytes((inner / "brick_n.png").read_bytes())
    path.write_text(path.read_text().replace('"brick_n.png"', '"../brick_n.png"'))
    assert gltf.check(path)["files"][0]["status"] == "unreadable"
    assert gltf.check(path, root=tmp_path / "a")["files"][0]["status"] == "ok"
    before = everything(tmp_path)
    for output in (tmp_path / "out" / "copy.gltf", path.with_stem("copy"), None):
        for root in (None, tmp_path / "a"):
            if (output, root) != (None, None):  # in place: an image that is not read
                with pytest.raises(gltf.GltfError, match="outside"):
                    gltf.clean(path, output, root=root)
            assert everything(tmp_path) == before


def everything(folder):
    """What all files in a folder hold, links as such."""
    return {
        file: os.readlink(file) if file.is_symlink() else file.read_bytes()
        for file in folder.rglob("*")
        if file.is_symlink() or file.is_file()
    }


def hostile(tmp_path, name, what="image"):
    """A model in a/ that names another file as its normals texture, or as its buffer."""
    inner = tmp_path / "a"
    inner.mkdir(exist_ok=True)
    path = save(model(), inner, "files" if what == "image" else "bin")
    old = "brick_n.png" if what == "image" else "geometry.bin"
    path.write_text(path.read_text().replace(f'"{old}"', json.dumps(name)))
    return path


@pytest.mark.parametrize(
    "name", ["/dev/zero", "/dev/null", "pipe", ".", "/etc/passwd", "/proc/kmsg"]
)
@pytest.mark.parametrize("what", ["image", "buffer"])
def test_only_regular_files_of_the_folder_are_opened(tmp_path, name, what):
    path = hostile(tmp_path, name, what)
    os.mkfifo(path.parent / "pipe")
    done = ntp_gltf(path, "--format", "json", timeout=20)
    assert done.returncode == 3, done.stderr
    (entry,) = json.loads(done.stdout)["files"]
    assert entry["status"] == "unreadable" and name.strip("./") in entry["message"]
    out = tmp_path / "out"
    done = ntp_gltf(path, "-o", out, timeout=20)
    assert done.returncode == 3 and "Traceback" not in done.stderr and not out.exists()
    # Nothing that is no regular file is even opened.
    if name in ("/dev/zero", "/dev/null", "pipe"):
        assert "no regular file" in done.stderr
    assert ntp_gltf(path, "--root", "/", timeout=20).returncode == 3


def test_a_uri_that_no_file_name_can_be(tmp_path):
    """JSON can hold half a surrogate pair, which no encoding of names can."""
    place = save(model(), tmp_path, "files")
    place.write_text(place.read_text().replace("brick_n.png", "\\ud800.png"))
    done = ntp_gltf(place)
    assert done.returncode == 3 and "Traceback" not in done.stderr
    assert "is not a file name" in done.stderr


def test_the_file_itself_is_a_regular_one(tmp_path):
    os.mkfifo(tmp_path / "model.glb")
    done = ntp_gltf(tmp_path / "model.glb", "/dev/zero", timeout=20)
    assert done.returncode == 3 and done.stderr.count("is no regular file") == 2


@pytest.mark.parametrize("what", ["image", "buffer"])
def test_size_limit(tmp_path, what):
    path = hostile(tmp_path, "huge", what)
    with open(path.parent / "huge", "wb") as huge:
        huge.truncate(1 << 40)
    done = ntp_gltf(path, timeout=20)
    assert done.returncode == 3 and "1,099,511,627,776 bytes" in done.stderr
    good = save(model(GOOD), tmp_path)
    size = good.stat().st_size
    assert gltf.check(good, max_bytes=size)["files"][0]["status"] == "ok"
    (entry,) = gltf.check(good, max_bytes=size - 1)["files"]
    assert entry["status"] == "unreadable" and "max_bytes (--max-bytes)" in entry["message"]
    for wrong in ("0", "-1", "x"):
        assert ntp_gltf(good, "--max-bytes", wrong).returncode == 2


def test_a_link_that_leads_out_is_not_followed(tmp_path):
    """Neither read nor rewritten, nor are its bytes copied to the output."""
    victim = tmp_path / "victim.png"
    victim.write_bytes(png_bytes(BAD))
    path = hostile(tmp_path, "link.png")
    (path.parent / "link.png").symlink_to("../victim.png")
    before = everything(tmp_path)
    assert "outside" in gltf.check(path)["files"][0]["message"]
    for root in ([], ["--root", tmp_path]):
        done = ntp_gltf(path, "--in-place", *root)
        assert done.returncode == 3 and "out" in done.stderr
        assert everything(tmp_path) == before
    assert gltf.check(path, root=tmp_path)["files"][0]["status"] == "ok"
    # A folder on the way is a link.
    path.write_text(path.read_text().replace('"link.png"', '"up/victim.png"'))
    (path.parent / "up").symlink_to("..")
    before = everything(tmp_path)
    for root in ([], ["--root", tmp_path]):
        assert ntp_gltf(path, "--in-place", *root).returncode == 3
        assert everything(tmp_path) == before


@pytest.mark.parametrize("target", ["../secret", "/etc/passwd"])
def test_a_linked_buffer_is_not_copied(tmp_path, target):
    (tmp_path / "secret").write_bytes(b"secret" * 100)
    for what in ("geometry.bin", "color 2.png"):
        folder = tmp_path / what
        folder.mkdir()
        path = save(model(), folder, "files")
        (folder / what).unlink()
        (folder / what).symlink_to(target)
        (tmp_path / "secret").replace(folder / "../secret")
        done = ntp_gltf(path, "-o", tmp_path / "out")
        assert done.returncode == 3 and "outside" in done.stderr and "written" not in done.stdout
        assert not (tmp_path / "out").exists()


def test_links_within_the_folder(tmp_path):
    path = hostile(tmp_path, "link.png")
    (path.parent / "link.png").symlink_to("brick_n.png")
    assert gltf.check(path)["files"][0]["status"] == "ok"
    gltf.clean(path, method="derive")
    assert (path.parent / "link.png").is_symlink()
    assert np.array_equal(read_png(path.parent / "brick_n.png")[0], GOOD)
    # An image that is a color texture under another name is not a normals texture alone.
    for name in ("./color%201.png", "link2.png", "%63olor%201.png"):
        path = hostile(tmp_path, name)
        if not (path.parent / "link2.png").exists():
            (path.parent / "link2.png").symlink_to("color 1.png")
        (path.parent / "color 1.png").write_bytes(png_bytes(BAD))
        before = everything(path.parent)
        (entry,) = gltf.clean(path, method="derive")["files"]
        assert entry["status"] == "skipped" and "same place" in entry["message"]
        assert everything(path.parent) == before


def test_where_a_file_lies_is_asked_of_the_open_file(tmp_path, monkeypatch):
    """The name is exchanged between looking and opening: what was opened decides."""
    root, other = tmp_path / "root", tmp_path / "other"
    root.mkdir(), other.mkdir()
    (root / "x").write_bytes(b"good")
    (other / "x").write_bytes(b"secret")
    real = os.open

    def swapped(path, flags, *more, **named):
        if str(path).endswith("x"):
            (root / "x").unlink()
            (root / "x").symlink_to("../other/x")
            descriptor = real(path, flags, *more, **named)
            (root / "x").unlink()
            (root / "x").write_bytes(b"good")
            return descriptor
        return real(path, flags, *more, **named)

    monkeypatch.setattr(os, "open", swapped)
    with pytest.raises(OSError, match="outside"):
        _named.read_named(root / "x", root)
    monkeypatch.undo()
    assert _named.read_named(root / "x", root)[0] == b"good"


@pytest.mark.parametrize("how", ["glb", "files"])
def test_a_file_that_changed_meanwhile_stays(tmp_path, how, monkeypatch):
    path = save(model(), tmp_path, how)
    changed = path if how == "glb" else tmp_path / "brick_n.png"
    real = _clean.plan

    def plan(*args, **named):
        changed.write_bytes(changed.read_bytes() + b"saved meanwhile")
        return real(*args, **named)

    monkeypatch.setattr(_clean, "plan", plan)
    with pytest.raises(OSError, match="changed meanwhile"):
        gltf.clean(path)
    assert changed.read_bytes().endswith(b"saved meanwhile")


def test_extended_attributes_stay(tmp_path):
    path = save(model(), tmp_path)
    path.chmod(0o640)
    try:
        os.setxattr(path, "user.note", b"mine")
    except OSError:
        pytest.skip("this file system has no extended attributes")
    gltf.clean(path)
    assert os.getxattr(path, "user.note") == b"mine" and path.stat().st_mode & 0o777 == 0o640


def test_memory_that_ends(tmp_path):
    path = save(model(), tmp_path)
    limit = "import resource; resource.setrlimit(resource.RLIMIT_AS, (1 << 29, 1 << 29));"
    code = limit + "from normaltexture.gltf import _cli; raise SystemExit(_cli.main())"
    with open(tmp_path / "big.glb", "wb") as file:
        file.truncate((1 << 30) - 1)
    command = [sys.executable, "-c", code, tmp_path / "big.glb", path]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 3 and "not enough memory" in done.stderr
    assert "Traceback" not in done.stderr


def test_missing_files_leave_no_copy(tmp_path):
    for name in ("brick_n.png", "color 1.png", "geometry.bin"):
        path = save(model(), tmp_path, "files")
        (tmp_path / name).unlink()
        for output in ("out", "copy.gltf"):
            done = ntp_gltf(path, "-o", tmp_path / output)
            assert done.returncode == 3 and name in done.stderr, (name, output)
            assert "written" not in done.stdout and not (tmp_path / output).exists()
            told = json.loads(ntp_gltf(path, "-o", tmp_path / output, "--format", "json").stdout)
            assert not told["outputs"] and told["summary"]["failed"]


def test_wrong_outputs_are_wrong_use(tmp_path):
    path = save(model(), tmp_path, "files")
    before = everything(tmp_path)
    done = ntp_gltf(path, "-o", tmp_path / "y.glb")
    assert done.returncode == 2 and ".gltf" in done.stderr and "Traceback" not in done.stderr
    done = ntp_gltf(path, "-o", path)
    assert done.returncode == 2 and "is the input" in done.stderr
    assert everything(tmp_path) == before


def test_messages_name_the_file(tmp_path):
    made = model()
    made.images[1] = ("n.ktx2", NOT_READ, "image/ktx2")
    path = save(made, tmp_path)
    done = ntp_gltf(path, "-o", tmp_path / "copy.glb")
    assert f"{path}, image 1: a KTX2 texture of ASTC" in done.stderr
    assert str(path) in ntp_gltf(path).stdout


def test_output_of_another_kind(tmp_path):
    path = save(model(), tmp_path)
    with pytest.raises(ValueError, match=r"\.glb"):
        gltf.clean(path, tmp_path / "copy.gltf")
