# SPDX-License-Identifier: MIT
"""The program as a whole: help, options, exit codes, external verbs, dump, diff, completions."""

import csv
import fcntl
import io
import json
import os
import pty
import select
import shlex
import shutil
import struct
import subprocess
import termios

import numpy as np
import pytest

from support import oracle, textures
from support.pngs import read_png, write_png
from support.spawn import spawn

VERBS = ["check", "clean", "convert", "heatmap", "dump", "diff"]


def test_help(run):
    done = run("--help")
    assert done.returncode == 0 and all(f"  {verb} " in done.stdout for verb in VERBS)
    assert run("help").stdout == done.stdout and run("-h").stdout == done.stdout
    assert max(len(line) for line in done.stdout.splitlines()) < 80
    for verb in VERBS:
        text = run(verb, "--help")
        assert text.returncode == 0 and text.stdout.startswith(f"Usage: ntp {verb}")
        assert "Examples:" in text.stdout and run("help", verb).stdout == text.stdout
        assert max(len(line) for line in text.stdout.splitlines()) < 80
    empty = run()
    assert empty.returncode == 2 and not empty.stdout and empty.stderr == done.stdout


def test_version(run):
    done = run("--version")
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    assert lines[0].startswith("ntp 0.") and lines[1].startswith("libntp 0.")
    assert "libpng" in lines[2]


@pytest.mark.parametrize(
    "args,hint",
    [
        (["chekc", "a.png"], '"check"'),
        (["frobnicate"], "frobnicate"),
        (["check", "--verdit", "exact", "a.png"], "--verdict"),
        (["check", "--recurs", "a.png"], "--recursive"),
        (["check", "-x", "a.png"], "-x"),
        (["check", "--verdict", "strict", "a.png"], "neighbor, rounded, exact"),
        (["check", "--verdict"], "--verdict"),
        (["check", "--deep=yes", "a.png"], "--deep"),
        (["check", "--max-fail", "nan", "a.png"], "0 to 100"),
        (["check", "--max-fail", "0x10", "a.png"], "0 to 100"),
        (["check", "--max-fail", "-1", "a.png"], "0 to 100"),
        (["check", "--jobs", "0", "a.png"], "--jobs"),
        (["check", "--jobs", "1.5", "a.png"], "--jobs"),
        (["check"], "needs"),
        (["check", ""], "empty"),
        (["clean", "a.png", "-o", ""], "empty"),
        (["clean", "--type", "object-space", "a.png"], "--type"),
        (["convert", "--depth", "32", "a.png", "-o", "b.png"], "8, 16"),
        (["clean", "a.png", "-o", "b.png", "--level", "13"], "1 to 12"),
        (["dump", "a.png", "b.png"], "one file"),
        (["diff", "a.png"], "two files"),
        (["diff", "-", "-"], "standard input"),
        (["--frob"], "--frob"),
        (["help", "nothing"], "nothing"),
        (["--generate", "x"], "--generate"),
    ],
)
def test_usage_errors(run, args, hint):
    done = run(*args)
    assert done.returncode == 2 and hint in done.stderr and not done.stdout
    assert done.stderr.startswith("ntp: ")


def test_dashes_end_options(run, tmp_path):
    write_png(tmp_path / "--deep", textures.standard())
    assert run("check", "--", "--deep").returncode == 0


@pytest.fixture
def copied(program, tmp_path):
    """The program in a directory of its own, for programs beside it."""
    directory = tmp_path / "bin"
    directory.mkdir()
    shutil.copy(program, directory / "ntp")
    return directory


def test_external_verbs(copied, tmp_path, monkeypatch):
    tool = copied / "ntp-report"
    tool.write_text('#!/bin/sh\necho "$0 $*"\nexit 7\n')
    tool.chmod(0o755)
    done = spawn([copied / "ntp", "report", "a b", "--x"], text=True)
    assert (done.returncode, done.stdout) == (7, f"{tool} a b --x\n")
    link = tmp_path / "link"
    link.symlink_to(copied / "ntp")
    assert spawn([link, "report"]).returncode == 7
    (copied / "ntp-check").write_text("#!/bin/sh\nexit 9\n")  # our own verbs come first
    (copied / "ntp-check").chmod(0o755)
    assert spawn([copied / "ntp", "check"]).returncode == 2
    away = tmp_path / "away"
    away.mkdir()
    shutil.move(tool, away / "ntp-report")
    monkeypatch.setenv("PATH", f"{away}:{os.environ['PATH']}")
    missing = spawn([copied / "ntp", "report"], text=True)
    assert missing.returncode == 2 and "Python package" in missing.stderr
    assert '"gltf"' in spawn([copied / "ntp", "gtlf"], text=True).stderr
    for verb in ("../away/report", "", "Report"):
        assert spawn([copied / "ntp", verb]).returncode == 2
    tool.write_text("#!/bin/sh\n")
    tool.chmod(0o644)
    assert spawn([copied / "ntp", "report"]).returncode == 3
    tool.write_text(f"#!{tmp_path}/gone/python\n")
    tool.chmod(0o755)
    gone = spawn([copied / "ntp", "report"], text=True)
    assert gone.returncode == 3 and "interpreter" in gone.stderr


def test_help_of_external_verbs(copied):
    tool = copied / "ntp-report"
    tool.write_text('#!/bin/sh\necho "$*"\n')
    tool.chmod(0o755)
    assert spawn([copied / "ntp", "help", "report"], text=True).stdout == "--help\n"
    assert spawn([copied / "ntp", "help", "gltf"]).returncode == 2


def test_external_verb_beside_a_script_that_starts_the_program(copied, tmp_path):
    """As wheels install it: bin/ntp runs the executable elsewhere, under its own name."""
    scripts = tmp_path / "scripts"
    scripts.mkdir()
    start = scripts / "ntp"
    start.write_text(f'#!/bin/bash\nexec -a "$0" "{copied}/ntp" "$@"\n')
    start.chmod(0o755)
    tool = scripts / "ntp-report"
    tool.write_text("#!/bin/sh\nexit 7\n")
    tool.chmod(0o755)
    assert spawn([start, "report"]).returncode == 7
    env = dict(os.environ, PATH=f"{scripts}:{os.environ['PATH']}")
    assert spawn(["bash", "-c", "ntp report"], env=env).returncode == 7


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="/dev/full is missing")
@pytest.mark.parametrize("args", [["check", "."], ["--help"], ["dump", "--all", "a_n.png"]])
def test_full_standard_output(program, tmp_path, args):
    write_png(tmp_path / "a_n.png", textures.standard())
    with open("/dev/full", "w") as full:
        done = spawn([program, *args], stdout=full, cwd=tmp_path, text=True)
    assert done.returncode == 3 and "space" in done.stderr


def test_closed_pipe_is_quiet(program, tmp_path):
    write_png(tmp_path / "a_n.png", textures.standard(400, 400))
    pipe = f"'{program}' dump --all a_n.png | head -n 1; echo ${{PIPESTATUS[0]}}"
    done = spawn(["bash", "-c", pipe], cwd=tmp_path, text=True)
    lines = done.stdout.splitlines()
    assert lines[0].startswith("column,row") and lines[1] == "0" and not done.stderr


def test_clean_goes_on_without_listeners(program, tmp_path):
    for i in range(5):
        write_png(tmp_path / f"{i}_n.png", textures.standard(seed=i))
    pipe = f"'{program}' clean . -o out | true"
    subprocess.run(["bash", "-c", pipe], cwd=tmp_path, check=True)
    assert len(list((tmp_path / "out").iterdir())) == 5


def test_decimal_point_in_any_locale(program, tmp_path):
    write_png(tmp_path / "a_n.png", textures.wrong_blue(textures.standard(), 0.1))
    env = {**os.environ, "LC_ALL": "de_DE.UTF-8"}
    args = [program, "check", "a_n.png", "--max-fail", "0.5", "--format", "json"]
    done = spawn(args, cwd=tmp_path, env=env, text=True)
    assert isinstance(json.loads(done.stdout)["files"][0]["angle_deg"]["max"], float)


# ------------------------------------------------------------------------------- dump, diff


def test_dump(run, tmp_path):
    before = textures.standard(12, 16)
    before[3, 4, 2] -= 60
    before[5, 6] = (255, 128, 200)
    before[7, 8] = 0
    write_png(tmp_path / "a_n.png", before)
    rows = list(csv.DictReader(io.StringIO(run("dump", "a_n.png").stdout)))
    where = [(int(r["column"]), int(r["row"])) for r in rows]
    assert where == [(4, 3), (6, 5), (8, 7)]
    first, long, black = rows
    r, g, b = (int(v) for v in before[3, 4])
    assert [int(first[k]) for k in "rgb"] == [r, g, b]
    assert [int(first[f"clean_{k}"]) for k in "rgb"] == list(oracle.cleaned(r, g, b, 255))
    assert int(first["levels_off"]) == 60 and "not_neighbor" in first["flags"]
    assert abs(float(first["x"]) - (2 * r - 255) / 255) < 1e-6
    assert "xy_too_long" in long["flags"] and long["levels_off"] == ""
    assert "unused" in black["flags"]
    everything = run("dump", "--all", "a_n.png").stdout.splitlines()
    assert len(everything) == 1 + 12 * 16
    assert len(run("dump", "--verdict", "exact", "a_n.png").stdout.splitlines()) == 4
    assert run("dump", "missing.png").returncode == 3
    write_png(tmp_path / "h.png", textures.heights())
    assert run("dump", "h.png").returncode == 1


def test_diff(run, tmp_path):
    before = textures.standard()
    after = before.copy()
    after[3, 4, 2] -= 9
    after[5, 6, 0] += 2
    write_png(tmp_path / "a.png", before)
    write_png(tmp_path / "b.png", after)
    assert run("diff", "a.png", "a.png").returncode == 0
    done = run("diff", "a.png", "b.png", "--format", "json")
    out = json.loads(done.stdout)
    assert done.returncode == 1 and out["schema_version"] == 1
    assert out["different"] == 2 and out["levels_max"] == [2, 0, 9] and not out["same"]
    assert out["angle_deg"]["max"] > 0
    assert "2 of 4,096 texels differ" in run("diff", "a.png", "b.png").stdout
    assert run("diff", "-q", "a.png", "b.png").stdout == ""
    assert run("diff", "a.png", "b.png", "-o", "h.png").returncode == 1
    heat = read_png(tmp_path / "h.png")[0]
    assert np.count_nonzero(heat.any(axis=2)) == 2
    assert run("diff", "a.png", "b.png", "-o", "a.png").returncode == 2
    write_png(tmp_path / "c.png", textures.standard(32, 32))
    done = run("diff", "a.png", "c.png")
    assert done.returncode == 1 and "sizes differ" in done.stdout
    assert run("diff", "a.png", "missing.png").returncode == 3


def test_diff_of_depths(run, tmp_path):
    write_png(tmp_path / "a.png", textures.standard())
    run("convert", "a.png", "-o", "b.png", "--depth", "16")
    done = run("diff", "a.png", "b.png", "--format", "json")
    assert json.loads(done.stdout)["angle_deg"]["max"] < 0.5


# ----------------------------------------------------------------------------- generated


def test_bash_completion(run, tmp_path):
    script = tmp_path / "ntp.bash"
    script.write_text(run("--generate", "bash").stdout)
    subprocess.run(["bash", "-n", script], check=True)
    probe = (
        f"source {shlex.quote(str(script))}; COMP_WORDS=(ntp check --verdict ''); COMP_CWORD=3; _ntp; "
        'echo "${COMPREPLY[*]}"; COMP_WORDS=(ntp clean --in); COMP_CWORD=2; _ntp; '
        'echo "${COMPREPLY[*]}"; COMP_WORDS=(ntp ch); COMP_CWORD=1; _ntp; echo "${COMPREPLY[*]}"'
    )
    done = spawn(["bash", "-c", probe], text=True)
    assert done.stdout.splitlines() == ["neighbor rounded exact", "--in-place", "check"]


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_completions(run, tmp_path, shell):
    text = run("--generate", shell).stdout
    assert all(verb in text for verb in [*VERBS, "report", "gltf", "usd"]) and "verdict" in text
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    script = tmp_path / "completion"
    script.write_text(text)
    subprocess.run([shell, "-n", script], check=True)


def test_man_page(run, tmp_path):
    page = tmp_path / "ntp.1"
    page.write_text(run("--generate", "man").stdout)
    assert all(f"ntp {verb}" in page.read_text() for verb in [*VERBS, "report", "gltf", "usd"])
    if shutil.which("groff") is None:
        pytest.skip("groff is not installed")
    env = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
    done = spawn(["groff", "-man", "-Tutf8", "-ww", "-z", page], text=True, env=env)
    assert done.returncode == 0 and not done.stderr


def drawn_at(program, directory, columns):
    """What a terminal of so many columns is sent by a run of two seconds, line by line."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    os.mkfifo(directory / "slow_n.png")  # the program waits for its writer
    args = [program, "check", "a_n.png", "slow_n.png"]
    with subprocess.Popen(
        args, cwd=directory, stdout=subprocess.DEVNULL, stderr=theirs, stdin=subprocess.DEVNULL
    ) as process:
        os.close(theirs)
        with open(directory / "slow_n.png", "wb") as writer:
            sent = b""
            while sent.count(b"\r") < 3 and select.select([ours], [], [], 20)[0]:
                sent += os.read(ours, 4096)
            writer.write((directory / "a_n.png").read_bytes())
        assert process.wait(60) == 0
    os.close(ours)
    return [part.replace("\033[K", "") for part in sent.decode().split("\r")[1:3]]


@pytest.mark.parametrize(
    ("columns", "bar", "counts"),
    [(80, 30, True), (34, 11, True), (24, 0, True), (18, 9, False), (8, 0, False)],
)
def test_progress_fits_the_terminal(program, tmp_path, columns, bar, counts):
    """A line that wraps would stay: a narrow terminal gets a shorter bar, then no counts."""
    write_png(tmp_path / "a_n.png", textures.standard())
    for line in drawn_at(program, tmp_path, columns):
        assert len(line) < columns and line.count("#") + line.count(".") == bar, repr(line)
        assert ("of 2 files" in line) == counts and "%" in line
