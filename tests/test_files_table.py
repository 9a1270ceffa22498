# SPDX-License-Identifier: MIT
"""test_files/README.md against the program, and generate.py against the files."""

import json
import re
import subprocess
import sys

import pytest

from support import libntp_ffi as ntp

FOLDER = ntp.ROOT / "test_files"
BY_HAND = {"README.md", "generate.py", "shapes.py"}


def table():
    """Rows of the table: (file, types, required findings, optional findings, exit codes)."""
    rows = []
    for line in (FOLDER / "README.md").read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|") or cells[0] in ("File", "---"):
            continue
        name, _, kinds, findings, exits = cells
        optional = set(re.findall(r"\((NT\d+)\)", findings))
        required = set(re.findall(r"NT\d+", findings)) - optional
        codes = {int(code) for code in exits.split(" or ")}
        rows.append((name, set(kinds.split(" or ")), required, optional, codes))
    return rows


def test_every_file_is_in_the_table():
    files = {path.name for path in FOLDER.iterdir() if path.is_file()} - BY_HAND
    assert files == {row[0] for row in table()}
    assert sum((FOLDER / name).stat().st_size for name in files) < 2_000_000


@pytest.mark.parametrize("row", table(), ids=lambda row: row[0])
def test_check(run, row):
    name, kinds, required, optional, codes = row
    done = run("check", "--format", "json", FOLDER / name)
    report = json.loads(done.stdout)
    (file,) = report["files"]
    if kinds == {"unreadable"}:
        assert file["status"] == "unreadable"
        assert file["message"]
    else:
        assert file["status"] == "ok"
        assert file["type"] in kinds, file["reasons"]
        found = {f["id"] for f in file["findings"] if f["level"] in ("warning", "error")}
        assert required <= found <= required | optional, file["findings"]
    assert done.returncode in codes
    assert run("check", FOLDER / name).returncode == done.returncode


def test_generate_reproduces_the_files(tmp_path):
    subprocess.run([sys.executable, FOLDER / "generate.py", tmp_path], check=True)
    made = {path.name for path in tmp_path.iterdir()}
    kept = {path.name for path in FOLDER.iterdir() if path.is_file()} - BY_HAND
    assert kept - made == {"jpeg.jpg", "jpeg_progressive.jpg"}
    for name in sorted(made):
        assert (FOLDER / name).read_bytes() == (tmp_path / name).read_bytes(), name
