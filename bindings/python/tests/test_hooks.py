# SPDX-License-Identifier: MIT
"""The pre-commit hooks on a scratch repository, and the steps of the GitHub Action, run here."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from pysupport.gltf_models import model, save
from support import textures
from support.pngs import read_png, write_png

ROOT = Path(__file__).resolve().parents[3]
GOOD = textures.standard(32, 32)
BAD = textures.wrong_blue(GOOD, 0.1)
HOOKS = ROOT / "packaging" / "pre-commit" / ".pre-commit-hooks.yaml"
HOOKS = yaml.safe_load(HOOKS.read_text(encoding="utf-8"))
ACTION = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))


def environment(tmp_path):
    """The programs of this Python first in PATH, nothing of the user's."""
    here = os.path.dirname(sys.executable)
    env = {"PATH": f"{here}:{os.environ['PATH']}", "HOME": str(tmp_path / "home")}
    env |= {"PRE_COMMIT_HOME": str(tmp_path / "pre-commit"), "GIT_CONFIG_NOSYSTEM": "1"}
    env |= {
        name: f"{kind}@example.invalid"
        for name, kind in (("GIT_AUTHOR_EMAIL", "a"), ("GIT_COMMITTER_EMAIL", "c"))
    }
    env |= {"GIT_AUTHOR_NAME": "a", "GIT_COMMITTER_NAME": "c", "LC_ALL": "C.UTF-8"}
    return env


@pytest.fixture
def repository(tmp_path):
    """run(*command) in a scratch repository that uses the hooks of this tree."""
    place = tmp_path / "game"
    place.mkdir()
    (tmp_path / "home").mkdir()
    env = environment(tmp_path)

    def run(*command):
        return subprocess.run(
            command, cwd=place, env=env, capture_output=True, text=True, check=False, timeout=900
        )

    assert run("git", "init", "-q").returncode == 0
    # As a user's, but that the programs are here already: nothing is fetched or built.
    hooks = [{**hook, "language": "system"} for hook in HOOKS]
    config = {"repos": [{"repo": "local", "hooks": hooks}]}
    (place / ".pre-commit-config.yaml").write_text(yaml.safe_dump(config), encoding="utf-8")
    run.place = place
    return run


def hook(repository, name):
    assert repository("git", "add", "-A").returncode == 0
    return repository("pre-commit", "run", name, "--all-files")


def test_hooks_are_complete():
    assert [hook["id"] for hook in HOOKS] == ["ntp-check", "ntp-clean", "ntp-gltf"]
    for entry in HOOKS:
        assert entry["language"] == "python" and entry["entry"].split()[0] in ("ntp", "ntp-gltf")


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("wall_n.png", True),
        ("a b/Wall_NormalGL.PNG", True),
        ("wall_nor_gl_4k.tga", True),
        ("wall-nrm.jpg", True),
        ("x/brick_nor_dx.jpeg", True),
        ("rock_n_2048.png", True),
        ("wall.png", False),
        ("nation.png", False),
        ("wall_n.txt", False),
        ("normals/readme.md", False),
        ("n.png", False),
        ("normal/color.png", False),
    ],
)
def test_names(name, wanted):
    assert bool(re.search(HOOKS[0]["files"], name)) == wanted


def test_check_hook(repository):
    write_png(repository.place / "good_n.png", GOOD)
    write_png(repository.place / "color.png", BAD)
    assert hook(repository, "ntp-check").returncode == 0
    write_png(repository.place / "bad_n.png", BAD)
    done = hook(repository, "ntp-check")
    assert done.returncode == 1 and "NT001" in done.stdout and "color.png" not in done.stdout


def test_clean_hook(repository):
    write_png(repository.place / "bad_n.png", BAD)
    done = hook(repository, "ntp-clean")
    assert done.returncode == 1 and "files were modified" in done.stdout
    assert (read_png(repository.place / "bad_n.png")[0] == GOOD).all()
    assert hook(repository, "ntp-clean").returncode == 0
    assert hook(repository, "ntp-check").returncode == 0


def test_gltf_hook(repository):
    save(model(), repository.place, "glb", "bad")
    done = hook(repository, "ntp-gltf")
    assert done.returncode == 1 and "bad.glb" in done.stdout


# -------------------------------------------------------------------------------- action


def steps(name):
    (step,) = [step for step in ACTION["runs"]["steps"] if step.get("id") == name]
    return step


def test_other_actions_are_named_by_commit():
    for path in (ROOT / "action.yml", ROOT / ".github" / "workflows" / "release.yml"):
        used = re.findall(r"uses: (\S+)", path.read_text(encoding="utf-8"))
        assert used and all(re.fullmatch(r"[\w/.-]+@[0-9a-f]{40}", name) for name in used)


def test_action_takes_no_input_into_a_script():
    for step in ACTION["runs"]["steps"]:
        assert "${{" not in step.get("run", "")
        assert ("shell" in step) == ("run" in step)
    given = re.findall(r"inputs\.([a-z-]+)", json.dumps(ACTION["runs"]))
    assert set(given) == set(ACTION["inputs"])


@pytest.mark.parametrize(
    ("bad", "fail_on", "code"), [(0, "error", 0), (1, "error", 1), (1, "never", 0), (2, "error", 3)]
)
def test_action(tmp_path, bad, fail_on, code):
    (tmp_path / "home").mkdir()
    place = tmp_path / "game"
    place.mkdir()
    write_png(place / "good_n.png", GOOD)
    if bad:
        write_png(place / "bad | $(touch owned)_n.png", BAD)
    if bad == 2:
        (place / "broken_n.png").write_bytes(b"no")
    files = {name: tmp_path / name for name in ("GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY")}
    env = environment(tmp_path) | {name: str(path) for name, path in files.items()}
    defaults = {name: value["default"] for name, value in ACTION["inputs"].items()}
    for name, value in steps("check")["env"].items():
        env[name] = defaults[re.fullmatch(r"\$\{\{ inputs\.([a-z-]+) \}\}", value)[1]]
    env |= {"FAIL_ON": fail_on, "PATHS": "good_n.png\n."}
    command = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", steps("check")["run"]]
    done = subprocess.run(command, cwd=place, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    output = dict(line.split("=") for line in files["GITHUB_OUTPUT"].read_text().splitlines())
    assert output == {"exit-code": str(code), "findings": str(bad)}
    assert done.stdout.count("::error file=") == bad
    summary = files["GITHUB_STEP_SUMMARY"].read_text()
    assert "| file | type | findings |" in summary and not (place / "owned").exists()
    rows = [line for line in summary.splitlines() if line.startswith("| ")]
    assert len(rows) == 1 + bad and all(row.count(" | ") == 2 for row in rows)
    assert (place / defaults["report"]).read_text().startswith("<!DOCTYPE html>")
    assert json.loads((place / defaults["sarif"]).read_text())["version"] == "2.1.0"
