# SPDX-License-Identifier: MIT
"""Runs a command of any kind, whatever its exit code."""

import subprocess


def spawn(args, **options):
    """subprocess.run without check; standard output and error are kept unless sent elsewhere."""
    options.setdefault("stdout", subprocess.PIPE)
    options.setdefault("stderr", subprocess.PIPE)
    options.setdefault("timeout", 60)
    return subprocess.run(args, check=False, **options)
