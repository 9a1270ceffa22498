# SPDX-License-Identifier: MIT
"""Runs the commands in the pages: console.py [--check] NTP

In README.md and docs/*.md each line "$ ..." of a console block is run by sh in a copy of
test_files, one copy for each page, with NTP in the PATH.  The lines that follow are replaced by its
output; with --check, a difference is an error.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"(?<=```console\n).*?(?=```)", re.DOTALL)


def run_block(block, folder, env):
    out = []
    for command in re.findall(r"^\$ (.*)\n", block, re.MULTILINE):
        done = subprocess.run(
            ["sh", "-c", command],
            check=False,
            cwd=folder,
            env=env,
            text=True,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        out.append(f"$ {command}\n{done.stdout}")
    return "".join(out)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--check", action="store_true")
    parser.add_argument("ntp", type=Path)
    args = parser.parse_args()
    path = f"{args.ntp.resolve().parent}{os.pathsep}{os.environ['PATH']}"
    env = dict(os.environ, PATH=path, LC_ALL="C.UTF-8")
    stale = 0
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        old = page.read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / "textures"
            shutil.copytree(ROOT / "test_files", folder)
            new = BLOCK.sub(lambda match, at=folder: run_block(match[0], at, env), old)
        if new != old and args.check:
            print(
                f"{page.relative_to(ROOT)}: the program prints something else than the page shows"
            )
            stale += 1
        elif new != old:
            page.write_text(new, encoding="utf-8")
    sys.exit(stale != 0)


main()
