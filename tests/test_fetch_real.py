# SPDX-License-Identifier: MIT
"""bench/fetch_real.py from beginning to end, with repositories made here and a file: URL."""

import csv
import hashlib
import json
import struct
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[1] / "bench" / "fetch_real.py"
PICTURE, INSIDE = b"the bytes of an image", b"an image in a GLB file"


def git(folder, *words):
    who = ["-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "commit.gpgsign=false"]
    done = subprocess.run(["git", "-C", folder, *who, *words], check=True, capture_output=True)
    return done.stdout.decode().strip()


def glb():
    gltf = {
        "images": [{"bufferView": 1}],
        "bufferViews": [{"byteLength": 4}, {"byteOffset": 4, "byteLength": len(INSIDE)}],
    }
    parts = [(0x4E4F534A, json.dumps(gltf).encode()), (0x004E4942, b"...." + INSIDE)]
    body = b"".join(struct.pack("<II", len(data), kind) + data for kind, data in parts)
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


@pytest.fixture
def public(tmp_path):
    """public/OWNER/NAME, a repository with two files that a later commit removes."""
    folder = tmp_path / "public" / "owner" / "name"
    (folder / "tex").mkdir(parents=True)
    git(folder, "init", "-q")
    (folder / "tex" / "a n.png").write_bytes(PICTURE)
    (folder / "model.glb").write_bytes(glb())
    git(folder, "add", "-A")
    git(folder, "commit", "-qm", "Add")
    commit = git(folder, "rev-parse", "HEAD")
    git(folder, "rm", "-rq", ".")
    git(folder, "commit", "-qm", "Remove")
    return commit


def write_list(path, *rows):
    fields = ["path", "repo", "repo_path", "commit", "sha256"]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerows([fields, *rows])


def fetch(tmp_path, *words):
    command = [sys.executable, SCRIPT, "out", "--list", "list.csv", *words]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def test_from_a_url_and_from_its_clone(tmp_path, public):
    sums = [hashlib.sha256(data).hexdigest() for data in (PICTURE, INSIDE)]
    write_list(
        tmp_path / "list.csv",
        ["owner+name/a n.png", "owner/name", "tex/a n.png", public, sums[0]],
        ["owner+name/0.png", "owner/name", "model.glb#image0", public, sums[1]],
    )
    code, out, err = fetch(tmp_path)
    assert (code, out) == (1, "0 of 2 images are there\n")
    assert err.count("no clone of owner/name") == 2
    url = (tmp_path / "public").as_uri()
    assert fetch(tmp_path, "--from", url) == (0, "2 of 2 images are there\n", "")
    assert (tmp_path / "out/owner+name/a n.png").read_bytes() == PICTURE
    assert (tmp_path / "out/owner+name/0.png").read_bytes() == INSIDE
    # what is there stays; what is spoiled comes again, from the clone that was made
    (tmp_path / "out/owner+name/0.png").write_bytes(b"spoiled")
    assert fetch(tmp_path)[:2] == (0, "2 of 2 images are there\n")
    assert (tmp_path / "out/owner+name/0.png").read_bytes() == INSIDE


def test_what_is_missing_is_named_with_its_reason(tmp_path, public):
    right = hashlib.sha256(PICTURE).hexdigest()
    write_list(
        tmp_path / "list.csv",
        ["b.png", "owner/name", "tex/b.png", public, right],
        ["c.png", "owner/name", "tex/a n.png", public, "0" * 64],
        ["d.png", "owner/name", "model.glb#image7", public, right],
        ["e.png", "owner/none", "tex/a n.png", public, right],
        ["f.png", "owner/name", "tex/a n.png", public, right],
    )
    code, out, err = fetch(tmp_path, "--clones", str(tmp_path / "public"))
    assert (code, out) == (1, "1 of 5 images are there\n")
    assert f"b.png: commit {public[:12]} of the clone does not have it" in err
    assert "c.png: another checksum" in err and not (tmp_path / "out/c.png").exists()
    assert "d.png: its GLB file does not have it" in err
    assert "e.png: no clone of owner/none" in err
    assert (tmp_path / "out/f.png").read_bytes() == PICTURE
