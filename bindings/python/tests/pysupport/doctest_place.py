# SPDX-License-Identifier: MIT
"""Where the examples of the docstrings run: pytest -p pysupport.doctest_place --doctest-modules.

Each gets a folder of its own, in which wall_n.png and wall_height.png lie.
"""

import shutil

import numpy as np
import pytest

from . import ROOT

TEST_FILES = ROOT / "test_files"
FILES = {"wall_n.png": "standard_z_off.png", "wall_height.png": "height_gray8.png"}


@pytest.fixture(autouse=True)
def doctest_place(request, tmp_path, monkeypatch, doctest_namespace):
    if isinstance(request.node, pytest.DoctestItem):
        doctest_namespace["np"] = np
        monkeypatch.chdir(tmp_path)
        for name, original in FILES.items():
            shutil.copy(TEST_FILES / original, tmp_path / name)
