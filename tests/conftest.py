# SPDX-License-Identifier: MIT
"""Shared by all tests: the paths of built files and of the corpus, and the rule on skips.

NTP_BUILD says where the built files are (else in build/), NTP_CORPUS where the corpus of real
textures is (else ../shared/corpus beside the repository).
With CI set, a skipped test that allowed_skips.txt does not list fails the run.
"""

import fnmatch
import os
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from support import libntp_ffi
from support.sanitized import EVERY, SANITIZED

# Messages of the system in English, names and output in UTF-8, whatever the user speaks.
os.environ["LC_ALL"] = "C.UTF-8"

TESTS = Path(__file__).resolve().parent
ALLOWED_SKIPS = TESTS / "allowed_skips.txt"
_skipped = {}


# What a sanitizer leaves out: cases of modules that have more than so many, which all run the same
# code, and modules that call no code of ours that was compiled.
MANY_CASES = 24
NOTHING_COMPILED = {"test_fetch_real.py", "test_mnemonics.py", "test_oracle.py", "test_rooms.py"}


def _sample(config, items):
    """Every fourth case of the modules that have many, where NTP_SANITIZED says it is slow."""
    counts = Counter(item.path for item in items if hasattr(item, "callspec"))
    seen = Counter()
    left_out = {item for item in items if item.path.name in NOTHING_COMPILED}
    for item in items:
        if hasattr(item, "callspec") and counts[item.path] > MANY_CASES:
            if seen[item.path] % EVERY != 0:
                left_out.add(item)
            seen[item.path] += 1
    config.hook.pytest_deselected(items=list(left_out))
    items[:] = [item for item in items if item not in left_out]


def pytest_configure(config):
    config.addinivalue_line("markers", "xdist_group(name): one process of pytest-xdist runs these")
    if libntp_ffi.lib is None:
        raise pytest.UsageError(
            f"there is no libntp/libntp.so in {libntp_ffi.BUILD}: build it (ninja -C build), set "
            "NTP_BUILD to a build directory that has it, or run ./dev test"
        )


def _leave_out(items):
    """Skips what makes no sense with the program of another system."""
    patterns = listed(TESTS / "windows" / "left_out.txt")
    for item in items:
        for pattern, reason in patterns.items():
            if fnmatch.fnmatchcase(_short_id(item.nodeid), pattern):
                item.add_marker(pytest.mark.skip(reason=f"ntp.exe: {reason}"))


def pytest_collection_modifyitems(config, items):
    if SANITIZED:
        _sample(config, items)
    if "NTP_PROGRAM" in os.environ:
        _leave_out(items)


PATIENCE = 900  # seconds: ends what hangs; a busy machine, or a sanitizer, is no failure


@pytest.fixture(scope="session")
def program():
    """The built `ntp`, or what starts that of another system: tests/windows/under_wine."""
    path = os.environ.get("NTP_PROGRAM") or libntp_ffi.find_built("cli/ntp")
    if path is None:
        pytest.skip("the program is not built")
    return path


@pytest.fixture
def run(program, tmp_path):
    """run("check", ...) -> CompletedProcess with text output."""

    def call(*args, **kwargs):
        kwargs.setdefault("cwd", tmp_path)
        kwargs.setdefault("capture_output", True)
        kwargs.setdefault("text", True)
        kwargs.setdefault("timeout", PATIENCE)
        return subprocess.run([program, *map(str, args)], check=False, **kwargs)

    return call


@pytest.fixture(scope="session")
def corpus():
    """The directory of real textures; not part of the repository."""
    path = Path(os.environ.get("NTP_CORPUS", libntp_ffi.ROOT.parent / "shared" / "corpus"))
    if not (path / "manifest.csv").exists():
        pytest.skip("the corpus is not here")
    return path


def listed(path):
    """{pattern of a test id: reason}."""
    lines = path.read_text(encoding="utf-8").splitlines()
    lines = [line for line in lines if line.strip() and not line.startswith("#")]
    return dict((part.strip() for part in line.split(" # ", 1)) for line in lines)


def _short_id(nodeid):
    """Without directories and group; a module that skips itself has no "::" in its id."""
    module, colons, test = nodeid.partition("::")
    return module.rpartition("/")[2] + colons + test.removesuffix("@gimp2")


def pytest_runtest_logreport(report):
    if report.skipped and not hasattr(report, "wasxfail"):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longrepr
        _skipped[_short_id(report.nodeid)] = str(reason)


def pytest_collectreport(report):
    if report.skipped:
        _skipped[_short_id(report.nodeid)] = str(report.longrepr)


def pytest_sessionfinish(session):
    if os.environ.get("CI") and _unexpected() and session.exitstatus == 0:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def _unexpected():
    patterns = listed(ALLOWED_SKIPS)
    return {
        test: reason
        for test, reason in _skipped.items()
        if "ntp.exe: " not in reason
        and not any(fnmatch.fnmatchcase(test, pattern) for pattern in patterns)
    }


def pytest_terminal_summary(terminalreporter):
    unexpected = _unexpected()
    if unexpected:
        terminalreporter.section("skipped, and not listed in allowed_skips.txt")
        for test, reason in unexpected.items():
            terminalreporter.line(f"{test}: {reason}")
