# SPDX-License-Identifier: MIT
"""Where GEGL finds the operations that were built."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from support.gimps import built_with

# GEGL loads all its modules at each start; with these alone a start takes a tenth of the time.
MODULES = ["gegl-core", "gegl-common", "transformops", "text", "png-load", "png-save"]


@pytest.fixture(scope="session")
def gegl_env(tmp_path_factory):
    """The environment in which GEGL finds the operations that were built."""
    module = built_with("gegl-0.4 >= 0.4.36", "gegl", "gimp-plugin/gegl/ntp-gegl.so")
    if shutil.which("gegl") is None:
        pytest.skip("the program gegl is not installed")
    query = ["pkg-config", "--variable=pluginsdir", "gegl-0.4"]
    plugins = Path(subprocess.run(query, capture_output=True, text=True, check=True).stdout.strip())
    few = tmp_path_factory.mktemp("gegl")
    files = [plugins / f"{name}.so" for name in MODULES]
    if all(file.exists() for file in files):
        for file in files:
            (few / file.name).symlink_to(file)
        plugins = few
    # Nothing in the home directory is read or written.
    own = {"HOME": str(few), "GEGL_SWAP": "RAM", "GEGL_USE_OPENCL": "no"}
    return dict(os.environ, GEGL_PATH=f"{plugins}:{module.parent}", **own)
