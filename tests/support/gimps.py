# SPDX-License-Identifier: MIT
"""Runs GIMP without a window, on jobs that are described as data."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from . import libntp_ffi

HERE = Path(__file__).resolve().parent

# What GIMP 3.0 prints about itself, whether our parts are there or not.
NOISE = re.compile(
    r"\((file-png|script-fu[\w-]*|python[\w.-]*):\d+\)"  # programs of its own
    r"|g_object_unref: assertion 'G_IS_OBJECT"
    r"|stale context|contexts left|gimp_wire_read|gimp_flush"
)


def built_with(package, option, file):
    """A file that the build makes where pkg-config knows a package.

    Without the package the test is skipped.  With it a build that lacks the file was configured
    before the package came, which is a failure.
    """
    path = libntp_ffi.find_built(file)
    if path is not None:
        return path
    settings = json.loads((libntp_ffi.BUILD / "meson-info/intro-buildoptions.json").read_text())
    if "disabled" in [entry["value"] for entry in settings if entry["name"] == option]:
        pytest.skip(f"{libntp_ffi.BUILD} was configured with -D{option}=disabled")
    if subprocess.run(["pkg-config", "--exists", package], check=False).returncode != 0:
        pytest.skip(f"not built: pkg-config does not know {package}")
    pytest.fail(
        f"{package} is installed, but {file} is not in {libntp_ffi.BUILD}, which was "
        "configured before: meson setup --reconfigure --clearcache, or ./dev test"
    )


def is_32(chroot):
    """Does the chroot have GIMP 3.2 or newer, not 3.0?  None: there is no chroot."""
    return chroot is not None and not (Path(chroot) / "usr/bin/gimp-console-3.0").exists()


class Gimp3:
    """GIMP 3 in a chroot (./dev gimp3 makes it), with a work directory inside of it."""

    def __init__(self, chroot, name):
        self.chroot = Path(chroot)
        self.inside = f"/home/{name}"
        self.work = self.chroot / self.inside[1:]
        shutil.rmtree(self.work, ignore_errors=True)
        self.work.mkdir(parents=True)

    def script(self, file, **environment):
        """Runs a Python file in GIMP; what it wrote to stderr."""
        shutil.copy(file, self.work / "script.py")
        home = self.inside
        variables = {
            "PATH": "/usr/bin:/bin",
            "HOME": home,
            "LANG": "C.UTF-8",
            "GIMP3_DIRECTORY": f"{home}/profile",
            "NTP_JOBS": home,
            **environment,
        }
        command = ["chroot", self.chroot, "env", "-i"] + [f"{k}={v}" for k, v in variables.items()]
        command += ["gimp-console-3", "-i", "-d", "-f", "--batch-interpreter=python-fu-eval"]
        command += ["-b", f"exec(open('{home}/script.py').read())", "--quit"]
        if os.geteuid() != 0:
            command = ["sudo", "-n", *command]
        done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
        (self.work / "log").write_text(done.stdout + done.stderr)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stderr

    def without_our_operations(self):
        """GEGL_PATH for a GIMP that has no operation of ours."""
        installed = next(self.chroot.glob("usr/lib/*/gegl-0.4/ntp-gegl.so")).parent
        path = self.work / "gegl"
        path.mkdir(exist_ok=True)
        for file in installed.iterdir():
            if file.name != "ntp-gegl.so":
                (path / file.name).symlink_to("/" / file.relative_to(self.chroot))
        return f"{self.inside}/gegl"

    def run(self, jobs, **environment):
        """Does the jobs of in_gimp3.py: {name: what it noted}, and the complaints of GIMP."""
        (self.work / "jobs.json").write_text(json.dumps(jobs))
        errors = self.script(HERE / "in_gimp3.py", **environment)
        results = json.loads((self.work / "results.json").read_text())
        return results, complaints(errors)


def complaints(text):
    """The lines that say CRITICAL or that something crashed, but for GIMP's own."""
    lines = [line for line in text.splitlines() if re.search("CRITICAL|ERROR|crash|fatal", line)]
    return [line for line in lines if not NOISE.search(line)]
