# SPDX-License-Identifier: MIT
"""GEGL with the operations that were built, and `ntp` on the same pixels."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from support import pngs
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


@pytest.fixture
def gegl(gegl_env, tmp_path):
    """gegl(pixels, "ntp:...", "name=value", ...) -> pixels of the result as a PNG file."""

    def call(pixels, *operations, chunks=(), threads=1, depth=None):
        pngs.write_png(tmp_path / "in.png", pixels, chunks=chunks)
        out = tmp_path / "out.png"
        out.unlink(missing_ok=True)
        depth = depth or pixels.dtype.itemsize * 8
        done = subprocess.run(
            ["gegl", "in.png", "-o", "out.png", "--", *operations, "gegl:png-save", "path=out.png"]
            + [f"bitdepth={depth}", "compression=1"],
            env=dict(gegl_env, GEGL_THREADS=str(threads)),
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=900,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        assert not any(s in done.stderr for s in ("CRITICAL", "WARNING")), done.stderr
        return pngs.read_png(out)[0]

    return call


@pytest.fixture
def ntp(run, tmp_path):
    """ntp(pixels, "from-height", option, ...) -> pixels of the result."""

    def call(pixels, verb, *options, chunks=()):
        pngs.write_png(tmp_path / "ntp-in.png", pixels, chunks=chunks)
        done = run(verb, "ntp-in.png", "-o", "ntp-out.png", "-q", *options)
        assert done.returncode == 0, done.stderr
        return pngs.read_png(tmp_path / "ntp-out.png")[0]

    return call
