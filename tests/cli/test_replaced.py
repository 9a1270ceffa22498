# SPDX-License-Identifier: MIT
"""Files that are replaced: by a version that is current, and with all that belongs to them."""

import json
import os
import resource
import shutil
import signal
import struct
import threading

import numpy as np
import pytest

from support import textures
from support.held import while_writing
from support.pngs import read_png, write_png
from support.spawn import spawn

ACCESS, DEFAULT = "system.posix_acl_access", "system.posix_acl_default"
USER_OBJ, USER, GROUP_OBJ, MASK, OTHER = 1, 2, 4, 16, 32


def noise(side=800):
    return np.random.default_rng(3).integers(0, 256, (side, side, 3)).astype(np.uint8)


def names(directory):
    return sorted(p.name for p in directory.iterdir())


# ---------------------------------------------------------------- saved by somebody meanwhile


def renamed(path, saved):
    """As editors save: a new file in the place of the old one."""
    other = path.parent / "saving"
    other.write_bytes(saved)
    other.rename(path)


def rewritten(path, saved):
    """Into the same file."""
    path.write_bytes(saved)


def of_the_same_size(path, saved):
    del saved
    data = bytearray(path.read_bytes())
    data[-1] ^= 255
    with open(path, "r+b") as file:
        file.write(data)


def rewritten_alike(path, saved):
    """Only the time tells."""
    del saved
    path.write_bytes(path.read_bytes())


def removed(path, saved):
    del saved
    path.unlink()


SAVES = [renamed, rewritten, rewritten_alike, of_the_same_size, removed]
IN_PLACE = {
    "clean": ["--type", "standard"],
    "convert": ["--from", "standard", "--y", "up", "--to-y", "down"],
    "heatmap": ["--type", "standard"],
    "transform": ["--type", "standard", "--flip", "x", "--y", "up"],
    "resize": ["--type", "standard", "--size", "90%"],
    "from-height": ["--scale", "4"],
    "to-height": ["--type", "standard", "--y", "up"],
    "curvature": ["--type", "standard", "--y", "up"],
    "occlusion": ["--type", "standard", "--y", "up"],
    "blend": ["--type", "standard", "--y", "up", "--detail-y", "up"],
}


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """The bytes of what somebody saves."""
    path = tmp_path_factory.mktemp("saved") / "n.png"
    write_png(path, textures.standard())
    return path.read_bytes()


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    path = tmp_path_factory.mktemp("original") / "n.png"
    write_png(path, noise())
    return path


@pytest.mark.parametrize("save", SAVES)
@pytest.mark.parametrize("output", ["--in-place", "-o"])
def test_saved_meanwhile(program, tmp_path, original, saved, save, output):
    """What was saved stays, and nothing is made of the older version."""
    path, after = tmp_path / "a_n.png", []

    def act(_process):
        save(path, saved)
        after.append(path.read_bytes() if path.exists() else None)

    where = [output] if output == "--in-place" else ["-o", "b.png"]
    args = [program, "clean", "a_n.png", *where, "--type", "standard", "--level", "9"]
    code, errors = while_writing(args, tmp_path, lambda: shutil.copy(original, path), act)
    assert code == 3 and "a_n.png: " in errors, errors
    if save in (renamed, rewritten_alike, removed):  # others may already break what is read
        assert "changed meanwhile" in errors, errors
    assert (path.read_bytes() if path.exists() else None) == after[-1]
    assert names(tmp_path) == (["a_n.png"] if path.exists() else [])


@pytest.mark.parametrize("verb", IN_PLACE)
def test_every_verb_looks_again(program, tmp_path, original, saved, verb):
    path = tmp_path / "a_n.png"
    files = ["a_n.png"]
    if verb == "blend":
        files = ["a_n.png", "d_n.png"]
        write_png(tmp_path / "d_n.png", textures.standard(8, 8))
    args = [program, verb, *files, "--in-place", *IN_PLACE[verb], "--level", "9"]
    code, errors = while_writing(
        args, tmp_path, lambda: shutil.copy(original, path), lambda _: renamed(path, saved)
    )
    assert code == 3 and "a_n.png: changed meanwhile" in errors, errors
    assert path.read_bytes() == saved and names(tmp_path) == files


def test_the_second_files_of_blend_and_diff(program, tmp_path, original, saved):
    for name in ("a_n.png", "b_n.png"):
        shutil.copy(original, tmp_path / name)
    path = tmp_path / "b_n.png"
    for args in (
        ["blend", "a_n.png", "b_n.png", "-o", "b_n.png", "--force", *IN_PLACE["blend"]],
        ["diff", "a_n.png", "b_n.png", "-o", "heat.png", "--type", "standard"],
    ):
        code, errors = while_writing(
            [program, *args],
            tmp_path,
            lambda: shutil.copy(original, path),
            lambda _: renamed(path, saved),
        )
        assert code == 3 and "b_n.png: changed meanwhile" in errors, errors
        assert path.read_bytes() == saved and names(tmp_path) == ["a_n.png", "b_n.png"]


def test_a_link_that_leads_elsewhere_meanwhile(program, tmp_path, original, saved):
    """A link is a name, too: what it led to is not replaced by what is no more its content."""

    def prepare():
        shutil.copy(original, tmp_path / "real.png")
        (tmp_path / "other.png").write_bytes(saved)
        (tmp_path / "link.png").unlink(missing_ok=True)
        (tmp_path / "link.png").symlink_to("real.png")

    def act(_process):
        (tmp_path / "link.png").unlink()
        (tmp_path / "link.png").symlink_to("other.png")

    args = [program, "clean", "link.png", "--in-place", "--type", "standard", "--level", "9"]
    code, errors = while_writing(args, tmp_path, prepare, act)
    assert code == 3 and "changed meanwhile" in errors
    assert (tmp_path / "real.png").read_bytes() == original.read_bytes()
    assert (tmp_path / "other.png").read_bytes() == saved


# --------------------------------------------------------------------- what is no regular file


def test_pipes_and_devices_are_not_replaced(run, tmp_path):
    """Nor waited for: a pipe without a writer would hang for ever."""
    os.mkfifo(tmp_path / "a_n.png")
    (tmp_path / "zero_n.png").symlink_to("/dev/zero")
    write_png(tmp_path / "b_n.png", textures.wrong_blue(textures.standard(), 0.1))
    how = ["--in-place", "--method", "derive"]
    done = run("clean", "a_n.png", "zero_n.png", "b_n.png", *how, timeout=60)
    assert done.returncode == 3, done.stderr
    for name in ("a_n.png", "zero_n.png"):
        assert f"{name}: not a regular file" in done.stderr
    assert run("check", "b_n.png", "--verdict", "rounded").returncode == 0
    for verb, options in IN_PLACE.items():
        files = ["a_n.png", "b_n.png"] if verb == "blend" else ["a_n.png"]
        done = run(verb, *files, "--in-place", *options, timeout=60)
        assert done.returncode == 3 and "not a regular file" in done.stderr, verb


def test_pipes_are_read(run, program, tmp_path):
    os.mkfifo(tmp_path / "pipe_n.png")
    write_png(tmp_path / "a_n.png", textures.wrong_blue(textures.standard(), 0.1))
    data = (tmp_path / "a_n.png").read_bytes()
    writer = threading.Thread(target=lambda: (tmp_path / "pipe_n.png").write_bytes(data))
    writer.start()
    done = run("clean", "pipe_n.png", "-o", "b.png", timeout=60)
    writer.join()
    assert done.returncode == 0, done.stderr
    assert run("clean", "a_n.png", "-o", "c.png").returncode == 0
    assert (tmp_path / "b.png").read_bytes() == (tmp_path / "c.png").read_bytes()


def test_devices_are_not_read(run):
    done = run("check", "/dev/zero", timeout=60)
    assert done.returncode == 3 and "/dev/zero: a device" in done.stderr


# --------------------------------------------------------------------------- too large a file


def test_limit_of_file_size(program, tmp_path):
    """The system sends SIGXFSZ, which ends a program that does not ignore it."""
    write_png(tmp_path / "a_n.png", noise(300))
    write_png(tmp_path / "b_n.png", textures.wrong_blue(textures.standard(16, 16), 0.1))
    before = (tmp_path / "a_n.png").read_bytes()

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, resource.RLIM_INFINITY))

    args = [program, "clean", "a_n.png", "b_n.png", "--in-place", "--type", "standard"]
    args += ["--method", "derive"]
    done = spawn(args, cwd=tmp_path, text=True, preexec_fn=limit)
    assert done.returncode == 3 and "a_n.png: cannot be written" in done.stderr, done
    assert (tmp_path / "a_n.png").read_bytes() == before
    assert (
        spawn([program, "check", "--verdict", "rounded", "b_n.png"], cwd=tmp_path).returncode == 0
    )
    assert names(tmp_path) == ["a_n.png", "b_n.png"]


# ------------------------------------------------------- access control lists and attributes


def access_list(owner, user, group, mask, other):
    """In the kernel's form: user 1000 has an entry of its own."""
    entries = [(USER_OBJ, owner, -1), (USER, user, 1000), (GROUP_OBJ, group, -1)]
    entries += [(MASK, mask, -1), (OTHER, other, -1)]
    return struct.pack("<I", 2) + b"".join(struct.pack("<HHi", *entry) for entry in entries)


def put(path, name, value):
    try:
        os.setxattr(path, name, value)
    except OSError as error:
        pytest.skip(f"no {name} here: {error}")


def attributes(path):
    return {
        name: os.getxattr(path, name)
        for name in os.listxattr(path)
        if not name.startswith("security.")
    }


@pytest.fixture
def faulty(tmp_path):
    path = tmp_path / "a_n.png"
    write_png(path, textures.wrong_blue(textures.standard(), 0.1))
    return path


@pytest.mark.parametrize("args", [["--in-place"], ["-o", "a_n.png", "--force"]])
def test_access_lists_and_attributes_are_kept(run, faulty, args):
    faulty.chmod(0o640)
    put(faulty, "user.license", b"CC0\0binary")
    put(faulty, "user.empty", b"")
    put(faulty, ACCESS, access_list(6, 7, 0, 7, 0))  # the mask stands where the group's bits do
    before, state = attributes(faulty), faulty.stat()
    assert run("clean", "a_n.png", *args).returncode == 0
    after = faulty.stat()
    assert after.st_ino != state.st_ino and attributes(faulty) == before
    assert (after.st_mode, after.st_uid, after.st_gid) == (
        state.st_mode,
        state.st_uid,
        state.st_gid,
    )


def test_lists_of_the_directory_let_nobody_in(run, faulty, tmp_path):
    """A new file inherits the directory's default list; the old file had none."""
    put(tmp_path, DEFAULT, access_list(7, 7, 7, 7, 7))
    faulty.chmod(0o640)
    os.removexattr(faulty, ACCESS) if ACCESS in os.listxattr(faulty) else None
    assert run("clean", "a_n.png", "--in-place").returncode == 0
    assert attributes(faulty) == {} and faulty.stat().st_mode & 0o777 == 0o640
    assert run("clean", "a_n.png", "-o", "new.png").returncode == 0  # as every new file
    assert ACCESS in attributes(tmp_path / "new.png")


def without(capability):
    if shutil.which("setpriv") is None:
        pytest.skip("setpriv is missing")
    return ["setpriv", f"--bounding-set=-{capability}"]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give the file another group")
@pytest.mark.parametrize(("before", "after"), [(0o660, 0o600), (0o664, 0o644), (0o604, 0o644)])
def test_another_group_gets_no_more_than_everybody(program, faulty, before, after):
    """Where the group cannot be kept, its bits are not for the new one."""
    os.chown(faulty, 0, 54321)
    faulty.chmod(before)
    args = [*without("chown"), program, "clean", "a_n.png", "--in-place"]
    assert spawn(args, cwd=faulty.parent).returncode == 0
    assert faulty.stat().st_gid == os.getegid() and faulty.stat().st_mode & 0o777 == after


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can set such attributes")
def test_what_cannot_be_kept_is_not_replaced(program, faulty):
    """An attribute that takes a privilege to set, and the group of a list."""
    data = faulty.read_bytes()
    put(faulty, "trusted.mark", b"1")
    args = [*without("sys_admin"), program, "clean", "a_n.png", "--in-place"]
    done = spawn(args, cwd=faulty.parent, text=True)
    if done.returncode == 0:  # without the privilege the attribute cannot be seen either
        assert read_png(faulty)[0].shape == (64, 64, 3)
        faulty.write_bytes(data)
    put(faulty, ACCESS, access_list(6, 7, 0, 7, 0))
    os.chown(faulty, 0, 54321)
    args = [*without("chown"), program, "clean", "a_n.png", "--in-place"]
    done = spawn(args, cwd=faulty.parent, text=True)
    assert done.returncode == 3 and "a_n.png: cannot be replaced" in done.stderr, done
    assert faulty.read_bytes() == data and names(faulty.parent) == ["a_n.png"]


# ------------------------------------------------------------- links out of what was named


@pytest.fixture
def linked(tmp_path):
    """A directory with links to a file and to a directory outside of it."""
    bad = textures.wrong_blue(textures.standard(), 0.1)
    for name in ("t/own_n.png", "out/victim_n.png", "out/d/victim_n.png"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        write_png(tmp_path / name, bad)
    (tmp_path / "t/file_n.png").symlink_to("../out/victim_n.png")
    (tmp_path / "t/d").symlink_to("../out/d")
    return tmp_path


def victims(directory):
    return [(directory / name).read_bytes() for name in ("out/victim_n.png", "out/d/victim_n.png")]


@pytest.mark.parametrize("verb", [verb for verb in IN_PLACE if verb != "blend"])
def test_links_out_of_a_directory_are_not_followed(run, linked, verb):
    before, listed = victims(linked), sorted(linked.rglob("*"))
    done = run(verb, "-r", "t", "--in-place", *IN_PLACE[verb])
    assert done.returncode == 3, done.stderr
    for name, victim in (("t/file_n.png", "victim_n.png"), ("t/d/victim_n.png", "d/victim_n.png")):
        assert f"{name}: leads to {linked}/out/{victim}, outside" in done.stderr, done.stderr
    assert victims(linked) == before
    assert (linked / "t/own_n.png").read_bytes() != before[0]  # the rest was done
    assert sorted(linked.rglob("*")) == listed


def test_mips_are_not_made_beside_such_a_link(run, linked):
    before = victims(linked)
    done = run("resize", "-r", "t", "--in-place", "--mips")
    assert done.returncode == 3 and victims(linked) == before
    assert "file_n_mip1.png" not in os.listdir(linked / "t")
    assert os.listdir(linked / "out/d") == ["victim_n.png"]


def test_a_dry_run_says_so_too(run, linked):
    done = run("clean", "-r", "t", "--in-place", "--dry-run", "--format", "json")
    status = {f["path"]: f["status"] for f in json.loads(done.stdout)["files"]}
    assert done.returncode == 3
    assert status == {"t/d/victim_n.png": "failed", "t/file_n.png": "failed", "t/own_n.png": "ok"}


def test_what_would_not_be_written_may_lead_out(run, linked):
    """A texture without faults, and a photograph."""
    write_png(linked / "out/victim_n.png", textures.standard())
    write_png(linked / "out/d/victim_n.png", textures.photograph())
    (linked / "out/d/victim_n.png").rename(linked / "out/d/photo.png")
    done = run("clean", "-r", "t", "--in-place")
    assert done.returncode == 0, done.stderr


def test_what_is_named_may_be_replaced(run, linked):
    """The link itself, its target, or the other directory."""
    before = victims(linked)
    assert run("clean", "t/file_n.png", "--in-place").returncode == 0
    assert (linked / "t/file_n.png").is_symlink()
    assert victims(linked)[0] != before[0] and victims(linked)[1] == before[1]
    assert run("clean", "-r", "t", "out", "--in-place").returncode == 0
    assert victims(linked)[1] != before[1]


def test_directories_that_are_links(run, linked):
    (linked / "other").symlink_to("out")
    before = victims(linked)
    assert run("clean", "-r", "other", "--in-place").returncode == 0
    assert all(a != b for a, b in zip(victims(linked), before, strict=True))
