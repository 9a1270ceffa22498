# SPDX-License-Identifier: MIT
"""Starts the program ntp, which lies in the package normaltexture.

It stands outside that package, whose import takes longer than many a run of the program.
"""

import importlib.util
import os
import sys
from pathlib import Path


def path() -> Path | None:
    """The program of the installed package, also of one that is installed as editable."""
    spec = importlib.util.find_spec("normaltexture")
    reader = getattr(spec.loader, "get_resource_reader", None) if spec else None
    if spec is None or reader is None:
        return None
    found = reader(spec.name).files() / ("ntp.exe" if os.name == "nt" else "ntp")
    return found if isinstance(found, Path) and found.is_file() else None


def main() -> int:
    """Becomes the program, under the name of this script: `ntp report` looks beside that."""
    program = path()
    if program is None:
        print("ntp: the package normaltexture has no program here", file=sys.stderr)
        return 3
    if os.name != "nt":
        os.execv(program, sys.argv)
    import subprocess

    return subprocess.run(sys.argv, executable=program, check=False).returncode
