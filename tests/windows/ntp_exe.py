# SPDX-License-Identifier: MIT
"""ntp.exe, under wine: names, patterns, long paths, consoles, replacement, and the bytes of Linux.

`./dev windows` runs this file; NTP_EXE is the program of Windows, NTP_BUILD has that of Linux.  A
start of wine takes half a second, so one start does many files.
"""

import hashlib
import json
import os
import pty
import re
import select
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXE = Path(os.environ["NTP_EXE"]).resolve()
PRESS = EXE.parents[1] / "tests" / "press_ctrl_c.exe"
NTP = Path(os.environ["NTP_BUILD"]).resolve() / "cli" / "ntp"
TEST_FILES = ROOT / "test_files"
STANDARD = TEST_FILES / "standard.png"
OFF = TEST_FILES / "standard_z_off.png"
ENVIRONMENT = {**os.environ, "WINEDEBUG": "-all", "LC_ALL": "C.UTF-8"}


def start(*args, cwd, exe=EXE):
    return subprocess.Popen(
        ["wine", exe, *map(str, args)],
        cwd=cwd,
        env=ENVIRONMENT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def run(*args, cwd, code=0, exe=EXE):
    """Standard output, as it is."""
    process = start(*args, cwd=cwd, exe=exe)
    out, err = process.communicate(timeout=300)
    assert process.returncode == code, err.decode()
    return out


def linux(*args, cwd):
    return subprocess.run([NTP, *map(str, args)], cwd=cwd, check=False, capture_output=True).stdout


def files_below(folder):
    return {p.relative_to(folder): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def sums_below(folder):
    """As files_below, but what a failure shows of large files can be read."""
    return {str(p): hashlib.sha256(b).hexdigest() for p, b in files_below(folder).items()}


def of_other_formats(folder):
    """Outputs of WebP and EXR, which the build for Windows does not read."""
    unread = (p.relative_to(folder) for p in folder.rglob("*") if p.suffix in (".webp", ".exr"))
    return {str(p.parent / name) for p in unread for name in (f"{p.name}.png", f"{p.stem}.pfm")}


def windows_path(path):
    return "Z:" + str(path).replace("/", "\\")


VERBS = [
    ("clean", "--force"),
    ("convert", "--to", "zzero", "--depth", "16", "--force"),
    ("heatmap",),
    ("from-height", "--scale", "9", "--force"),
    ("to-height", "--force"),
    ("transform", "--rotate", "30", "--force"),
    ("resize", "--size", "50%", "--force"),
]


@pytest.mark.parametrize("verb", VERBS, ids=[verb[0] for verb in VERBS])
def test_the_bytes_are_those_of_linux(verb, tmp_path):
    """Every file of test_files, and of the corpus where it is, of the formats that both builds read."""
    corpus = Path(os.environ.get("NTP_CORPUS", ROOT.parent / "shared" / "corpus"))
    inputs = [TEST_FILES] + ([corpus] if corpus.exists() else [])
    unread = set()
    for i, folder in enumerate(inputs):
        unread |= {f"{i}/{name}" for name in of_other_formats(folder)}
        for system, call in (("windows", start), ("linux", None)):
            args = [*verb, "-r", ".", "-o", tmp_path / system / str(i), "--jobs", "2"]
            if call is None:
                linux(*args, cwd=folder)
            else:
                process = call(*args, cwd=folder)
                process.communicate()
                assert process.returncode in (0, 1, 3)
    made, expected = sums_below(tmp_path / "windows"), sums_below(tmp_path / "linux")
    assert len(made) > 20
    assert made == {name: value for name, value in expected.items() if name not in unread}


def without_versions(report):
    """JSON names the image libraries, and those of the two builds differ."""
    return re.sub(rb'"codecs": "[^"]*"', b"", report)


@pytest.mark.parametrize("form", ["text", "json", "csv", "list"])
def test_check_says_the_same(form):
    args = ["check", "-r", ".", "--format", form, "--deep"]
    process = start(*args, cwd=TEST_FILES)
    said = process.communicate()[0]
    assert without_versions(said) == without_versions(linux(*args, cwd=TEST_FILES))


@pytest.fixture
def folder(tmp_path):
    """A folder of names in other scripts and with blanks, and of one that a pattern must not take."""
    for name in ("壁の法線_n.png", "🧱 brick_n.PNG", "Grün [1]_n.png", "other.txt"):
        shutil.copy(STANDARD, tmp_path / name)
    (tmp_path / "sub folder").mkdir()
    shutil.copy(STANDARD, tmp_path / "sub folder" / "deep_n.png")
    return tmp_path


def checked(*args, cwd):
    report = json.loads(run("check", *args, "--format", "json", cwd=cwd).decode())
    return [file["path"] for file in report["files"]]


def test_patterns_and_unicode(folder):
    everything = ["Grün [1]_n.png", "壁の法線_n.png", "🧱 brick_n.PNG"]
    assert checked("*.png", cwd=folder) == everything
    assert checked(".\\*_N.png", cwd=folder) == [f"./{name}" for name in everything]
    assert checked("????_n.png", cwd=folder) == ["壁の法線_n.png"]
    assert checked("[gx]*.png", "sub*\\*.png", cwd=folder) == [
        "Grün [1]_n.png",
        "sub folder/deep_n.png",
    ]
    whole = windows_path(folder / "*.png")
    assert checked(whole, cwd=folder) == [
        whole.replace("\\", "/").replace("*.png", name) for name in everything
    ]
    assert checked("--match", "DEEP*", "-r", windows_path(folder), cwd="/") == [
        windows_path(folder / "sub folder/deep_n.png").replace("\\", "/")
    ]


def test_output_with_unicode_names(folder):
    run("heatmap", "-r", windows_path(folder), "-o", "out\\🎨", cwd=folder)
    names = {str(p) for p in files_below(folder / "out" / "🎨")}
    assert names == {
        "壁の法線_n.png",
        "🧱 brick_n.PNG",
        "Grün [1]_n.png",
        "sub folder/deep_n.png",
    }


def test_an_image_on_standard_output_has_no_line_ends_changed(tmp_path):
    assert run("clean", OFF, "-o", "-", cwd=tmp_path) == linux(
        "clean", OFF, "-o", "-", cwd=tmp_path
    )


def test_standard_input_is_binary(tmp_path):
    made = subprocess.run(
        ["wine", EXE, "clean", "-", "-o", "out.png"],
        cwd=tmp_path,
        env=ENVIRONMENT,
        input=OFF.read_bytes(),
        capture_output=True,
        check=False,
    )
    assert made.returncode == 0, made.stderr
    linux("clean", OFF, "-o", "linux.png", cwd=tmp_path)
    assert (tmp_path / "out.png").read_bytes() == (tmp_path / "linux.png").read_bytes()


def test_standard_input_is_not_overwritten(tmp_path):
    """It is a file that the shell of Windows opened."""
    shutil.copy(OFF, tmp_path / "x_n.png")
    shutil.copy(EXE, tmp_path / "ntp.exe")
    words = ["/c", "ntp.exe", "clean", "-", "-o", "x_n.png", "--type", "standard", "<", "x_n.png"]
    process = start(*words, cwd=tmp_path, exe="cmd")
    err = process.communicate()[1].decode()
    assert process.returncode == 2 and "x_n.png is an input" in err
    assert (tmp_path / "x_n.png").read_bytes() == OFF.read_bytes()


def test_a_path_of_more_than_300_characters(tmp_path):
    deep = tmp_path
    while len(str(deep)) < 300:
        deep = deep / "folder with a long name 長い"
    deep.mkdir(parents=True)
    shutil.copy(STANDARD, deep / "x_n.png")
    path = windows_path(deep / "x_n.png")
    assert checked(path, cwd=tmp_path) == [path.replace("\\", "/")]
    shutil.copy(OFF, deep / "x_n.png")
    run("clean", path, "-o", windows_path(deep / "new" / "folder" / "y_n.png"), cwd=tmp_path)
    assert sorted(p.name for p in deep.iterdir()) == ["new", "x_n.png"]


def test_in_place(tmp_path):
    shutil.copy(OFF, tmp_path / "x_n.png")
    linux("clean", OFF, "-o", "linux.png", cwd=tmp_path)
    run("clean", "x_n.png", "--in-place", cwd=tmp_path)
    assert (tmp_path / "x_n.png").read_bytes() == (tmp_path / "linux.png").read_bytes()


def in_console(*command, cwd):
    """Exit code, and what a console on a pseudo-terminal shows, without the padding of its lines."""
    pid, terminal = pty.fork()
    if pid == 0:
        os.chdir(cwd)
        os.execvpe("wine", ["wine", *map(str, command)], {**ENVIRONMENT, "TERM": "xterm"})
    shown, deadline = b"", time.monotonic() + 120
    while True:
        if select.select([terminal], [], [], 0.2)[0]:
            try:
                shown += os.read(terminal, 1 << 16)
            except OSError:  # the last of its users is gone
                pass
        ended, status = os.waitpid(pid, os.WNOHANG)
        if ended:
            break
        if time.monotonic() > deadline:
            os.kill(pid, signal.SIGKILL)
    os.close(terminal)
    return os.waitstatus_to_exitcode(status), shown.decode()


def test_a_console_has_colors(tmp_path):
    shutil.copy(OFF, tmp_path / "x_n.png")
    code, shown = in_console(EXE, "check", "x_n.png", cwd=tmp_path)
    assert code == 1
    assert "\x1b[1mx_n.png\x1b[0m" in shown and "\x1b[31m1 error\x1b[0m" in shown
    plain = in_console(EXE, "check", "x_n.png", "--color", "never", cwd=tmp_path)[1]
    assert "x_n.png: " in plain and not re.search(r"\x1b\[[0-9;]*m", plain)


def test_a_closed_pipe_is_quiet(tmp_path):
    """The reader goes away after a line; that is no error, as on other systems."""
    linux("resize", STANDARD, "--size", "400x400", "-o", "big.png", cwd=tmp_path)
    process = start("dump", "--all", "big.png", cwd=tmp_path)
    assert process.stdout.readline()
    process.stdout.close()
    err = process.stderr.read().decode()
    assert (process.wait(120), err) == (0, "")


@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_keeps_the_old_file(tmp_path, times):
    """The program ends with 130 and leaves nothing beside the target; a bar shows how far it is."""
    linux("resize", STANDARD, "--size", "3000x2000", "-o", "big.png", cwd=tmp_path)
    shutil.copy(OFF, tmp_path / "out.png")
    press = [PRESS, ".out.png.ntp-000001.tmp", 1200 if times == 1 else 0, times]
    work = ["transform", "big.png", "--flip", "x", "--y", "up", "--level", "12", "-o", "out.png"]
    code, shown = in_console(*press, EXE, *work, cwd=tmp_path)
    assert code == 130
    assert times > 1 or "%  0 of 1 files" in shown
    assert (tmp_path / "out.png").read_bytes() == OFF.read_bytes()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["big.png", "out.png"]


def test_a_kill_while_writing_leaves_the_old_file(tmp_path):
    """Whenever the program dies, the target is the old file or the new one, and nothing is left."""
    big = tmp_path / "big.png"
    run("resize", STANDARD, "--size", "3000x2000", "-o", big, cwd=tmp_path)
    target = tmp_path / "target.png"
    old = OFF.read_bytes()
    seen = set()
    for delay in (0.6, 0.9, 1.2):
        target.write_bytes(old)
        process = start("transform", big, "--flip", "x", "-o", target, "--level", "9", cwd=tmp_path)
        time.sleep(delay)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        time.sleep(0.3)
        seen.add(target.read_bytes() == old)
        left = {p.name for p in tmp_path.iterdir()} - {"big.png", "target.png"}
        assert all(name.startswith(".target.png.ntp-") for name in left)
    assert True in seen
    run("transform", big, "--flip", "x", "-o", target, cwd=tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["big.png", "target.png"]


def test_a_target_that_is_read_only_is_refused(tmp_path):
    target = tmp_path / "target.png"
    shutil.copy(STANDARD, target)
    target.chmod(0o444)
    process = start("clean", OFF, "-o", target.name, cwd=tmp_path)
    err = process.communicate()[1].decode()
    assert process.returncode == 3
    assert "target.png: cannot be replaced: Permission denied" in err
    assert target.read_bytes() == STANDARD.read_bytes()
    assert [p.name for p in tmp_path.iterdir()] == ["target.png"]


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 64 KiB."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", disk], check=False, capture_output=True
    )
    if mounted.returncode != 0:
        pytest.skip("nothing can be mounted here")
    yield disk
    subprocess.run(["umount", disk], check=True)


def test_a_full_disk_keeps_the_old_file(small_disk, tmp_path):
    big = tmp_path / "big.png"
    linux("resize", STANDARD, "--size", "900x600", "-o", big, cwd=tmp_path)
    target = small_disk / "target.png"
    shutil.copy(STANDARD, target)
    process = start("transform", big, "--flip", "x", "-o", target, cwd=tmp_path)
    err = process.communicate()[1].decode()
    assert process.returncode == 3
    assert "target.png: cannot be written: No space left on device" in err
    assert target.read_bytes() == STANDARD.read_bytes()
    assert [p.name for p in small_disk.iterdir()] == ["target.png"]


def test_two_names_that_differ_in_case_are_one(tmp_path):
    shutil.copy(STANDARD, tmp_path / "a.png")
    (tmp_path / "sub").mkdir()
    shutil.copy(STANDARD, tmp_path / "sub" / "A.png")
    process = start("clean", "a.png", "sub\\A.png", "-o", "out\\", cwd=tmp_path)
    err = process.communicate()[1].decode()
    assert process.returncode == 2
    assert "a.png and sub/A.png would both be written to" in err
