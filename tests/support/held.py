# SPDX-License-Identifier: MIT
"""A program that is held while it writes, so that something can happen meanwhile."""

import os
import re
import signal
import stat
import subprocess
import time
from pathlib import Path

from support.spawn import start


def _has_output_open(pid):
    """Is a file open for writing?"""
    for name in os.listdir(f"/proc/{pid}/fd"):
        info = Path(f"/proc/{pid}/fdinfo/{name}").read_text(encoding="ascii")
        flags = int(re.search(r"^flags:\s*([0-7]+)", info, re.MULTILINE)[1], 8)
        is_file = stat.S_ISREG(os.stat(f"/proc/{pid}/fd/{name}").st_mode)
        if is_file and flags & os.O_ACCMODE != os.O_RDONLY:
            return True
    return False


def _stop(process):
    """False if it has already ended."""
    process.send_signal(signal.SIGSTOP)
    if process.returncode is not None:
        return False
    how = os.WSTOPPED | os.WEXITED | os.WNOWAIT
    return os.waitid(os.P_PID, process.pid, how).si_code == os.CLD_STOPPED


def while_writing(args, directory, prepare, act):
    """Runs prepare(), starts a program, and calls act(process) while it is held with an output open.

    It is stopped for each look at it, so that it cannot be done before; should it be done before
    the first look, all begins again.  Returns its exit code and standard error.
    """
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    for _ in range(10):
        prepare()
        acted = False
        with start(args, cwd=directory, **pipes) as process:
            while not acted and _stop(process):
                acted = _has_output_open(process.pid)
                if acted:
                    act(process)
                process.send_signal(signal.SIGCONT)
                if not acted:
                    time.sleep(0.002)
            _, errors = process.communicate(timeout=900)
        if acted:
            return process.returncode, errors
    raise AssertionError("the program is too fast to be held")
