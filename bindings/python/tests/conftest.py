# SPDX-License-Identifier: MIT
"""What the tests of normaltexture share.

They test the installed package: `./dev python` builds the sdist, from it the wheel, installs that
into a virtual environment, and runs them there.  The oracles are those of the repository's tests.
"""

import os
import shutil
import sys
from pathlib import Path

import hypothesis
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests"))
TEST_FILES = ROOT / "test_files"

hypothesis.settings.register_profile("ci", derandomize=True, deadline=None)
hypothesis.settings.register_profile("dev", deadline=None)
hypothesis.settings.load_profile("ci" if os.environ.get("CI") else "dev")


@pytest.fixture(autouse=True)
def doctest_place(request, tmp_path, monkeypatch, doctest_namespace):
    """Examples run in a folder of their own, in which wall_n.png and wall_height.png lie."""
    doctest_namespace["np"] = np
    if isinstance(request.node, pytest.DoctestItem):
        monkeypatch.chdir(tmp_path)
        shutil.copy(TEST_FILES / "standard_z_off.png", tmp_path / "wall_n.png")
        shutil.copy(TEST_FILES / "height_gray8.png", tmp_path / "wall_height.png")
