# SPDX-License-Identifier: MIT
"""What the tests of normaltexture share.

They test the installed package: `./dev python` builds the sdist, from it the wheel, installs that
into a virtual environment, and runs them there.  The oracles are those of the repository's tests.
With CI set hypothesis draws the same examples each time, and a skipped test is a failure; else it
draws anew (--hypothesis-seed=N repeats a run).
"""

import os
import sys

import hypothesis
import pytest

from pysupport import ROOT

sys.path.insert(0, str(ROOT / "tests"))

# Messages of the system in English, names and output in UTF-8, whatever the user speaks.
os.environ["LC_ALL"] = "C.UTF-8"

hypothesis.settings.register_profile(
    "normaltexture",
    derandomize=bool(os.environ.get("CI")),
    deadline=None,  # a busy machine is no failure
    database=None,
    suppress_health_check=list(hypothesis.HealthCheck),
)
hypothesis.settings.load_profile("normaltexture")

_skipped = []


def pytest_runtest_logreport(report):
    if report.skipped and not hasattr(report, "wasxfail"):
        _skipped.append(report.nodeid)


def pytest_sessionfinish(session):
    if os.environ.get("CI") and _skipped and session.exitstatus == 0:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter):
    if os.environ.get("CI"):
        for test in _skipped:
            terminalreporter.line(f"skipped, which fails in CI: {test}")


@pytest.fixture(scope="session")
def test_files():
    """The folder of made textures."""
    return ROOT / "test_files"


@pytest.fixture
def folder(tmp_path):
    """What normaltexture.report is asked about."""
    from pysupport import reports  # it needs the path above

    return reports.make_folder(tmp_path)
