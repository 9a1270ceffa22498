# SPDX-License-Identifier: MIT
"""Runs a command of any kind, whatever its exit code."""

import signal
import subprocess


def spawn(args, **options):
    """subprocess.run without check; standard output and error are kept unless sent elsewhere."""
    options.setdefault("stdout", subprocess.PIPE)
    options.setdefault("stderr", subprocess.PIPE)
    options.setdefault("timeout", 900)  # for what hangs; a busy machine is no failure
    return subprocess.run(args, check=False, **options)


def start(args, **options):
    """subprocess.Popen that receives Ctrl-C, which background jobs of a shell ignore."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return subprocess.Popen(args, **options)
    finally:
        signal.signal(signal.SIGINT, before)
