# SPDX-License-Identifier: MIT
"""The results of `ntp check` as objects: the program is run and its JSON is read."""

import json
import os
import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import ntp_program

from ._errors import ArgumentError, FileError, FileStatus
from ._measure import _Result
from .typing import AutoY, CheckType, Class, Level, Policy, Verdict


@dataclass(frozen=True)
class Finding(_Result):
    """A finding about a file.

    Attributes
    ----------
    id : str
        "NT001" and so on; docs/findings.md lists them.
    level : {"error", "warning", "info"}
    message : str
    count : int
        The number of texels concerned.
    """

    id: str
    level: Level
    message: str
    count: int


@dataclass(frozen=True)
class CheckedFile(_Result):
    """What `check` says about one file.

    Attributes
    ----------
    path : str
    status : {"ok", "unreadable"}
    message : str or None
        Why it is unreadable.
    type : str or None
        "standard", "zzero", "xy", "height", "object-space", "one-color" or "not-normals".
    findings : tuple of Finding
        The most important first.
    data : dict
        All that the JSON of `ntp check` says about the file, by the names of
        docs/schema/check-1.json.
    """

    path: str
    status: Literal["ok", "unreadable"]
    message: str | None
    type: Class | None
    findings: tuple[Finding, ...]
    data: dict[str, Any]

    @property
    def level(self) -> Level | None:
        """The highest level among the findings; None without any."""
        levels = [finding.level for finding in self.findings]
        ranked: tuple[Level, ...] = ("error", "warning", "info")
        return next((level for level in ranked if level in levels), None)

    def to_dict(self) -> dict[str, Any]:
        """The file's object in the JSON of `ntp check`."""
        return dict(self.data)


@dataclass(frozen=True)
class CheckReport(_Result):
    """What `check` found: the files, and the summary of docs/schema/check-1.json."""

    files: tuple[CheckedFile, ...]
    summary: dict[str, Any]
    data: dict[str, Any]

    @property
    def ok(self) -> bool:
        """No file has an error, and all could be read."""
        return not self.summary["with_errors"] and not self.summary["unreadable"]

    def to_dict(self) -> dict[str, Any]:
        """The JSON of `ntp check`, as docs/schema/check-1.json describes it."""
        return dict(self.data)


def program() -> Path:
    """The `ntp` that belongs to this package.

    `NTP_PROGRAM` in the environment names another.

    Returns
    -------
    Path

    Raises
    ------
    FileNotFoundError
        If neither the package nor PATH has one.
    """
    if os.environ.get("NTP_PROGRAM"):
        return Path(os.environ["NTP_PROGRAM"])
    own = ntp_program.path()
    if own is not None:
        return own
    found = shutil.which("ntp")
    if found is None:
        raise FileNotFoundError("ntp is neither in the package normaltexture nor in PATH")
    return Path(found)


def check(
    paths: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    *,
    type: CheckType = "auto",
    y: AutoY = "auto",
    verdict: Verdict = "neighbor",
    keep_negative_z: bool = False,
    policy: Policy = "harm",
    max_angle: float = 5.0,
    max_fail: float = 2.0,
    max_tilt: float = 0.1,
    deep: bool = False,
    recursive: bool = False,
    match: Iterable[str] = (),
    exclude: Iterable[str] = (),
    jobs: int | None = None,
) -> CheckReport:
    """Check files and folders as `ntp check` does: what they are, and whether they are well formed.

    Parameters
    ----------
    paths : path, or iterable of paths
        Files are always judged; in folders, normals textures are.
    type : {"auto", "standard", "zzero", "xy", "height"}
        What the files are; "auto" detects it.
    y : {"auto", "up", "down"}
        Which way green must point.
    verdict : {"neighbor", "rounded", "exact"}
        How strictly a texel is judged.
    keep_negative_z : bool
        A negative z is not an error.
    policy : {"harm", "strict"}
        What makes wrong texels a warning or an error.  "harm": the angle that a renderer shows, and
        how much of the picture it touches; "strict": every texel that fails `verdict`.
    max_angle : float
        With "harm": a normal that is off by more, in degrees, is visible.
    max_fail : float
        A larger share, in percent, of texels that are off by more than `max_angle` ("strict": that
        fail `verdict`) is an error.
    max_tilt : float
        Warn if the mean of x or y is farther from 0 than this.
    deep : bool
        Read every row and the whole texture; otherwise only a part is read.
    recursive : bool
        Descend into folders.
    match, exclude : iterable of str
        Patterns of the names in folders to use, and to skip.
    jobs : int, optional
        Files at once; default: one for each processor.

    Returns
    -------
    CheckReport

    Raises
    ------
    ArgumentError
        For an argument that `ntp check` does not accept.
    FileNotFoundError
        If the program `ntp` is missing.

    Examples
    --------
    >>> import normaltexture as nt
    >>> report = nt.check("wall_n.png")
    >>> report.ok, report.files[0].type, report.files[0].findings[0].id
    (False, 'standard', 'NT001')
    """
    named = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
    if not named:
        raise ArgumentError("paths: at least one is needed")
    options = [f"--type={type}", f"--y={y}", f"--verdict={verdict}"]
    options += [f"--policy={policy}", f"--max-angle={max_angle!r}"]
    options += [f"--max-fail={max_fail!r}", f"--max-tilt={max_tilt!r}"]
    options += ["--keep-negative-z"] if keep_negative_z else []
    options += ["--deep"] if deep else []
    options += ["--recursive"] if recursive else []
    options += [f"--match={pattern}" for pattern in match]
    options += [f"--exclude={pattern}" for pattern in exclude]
    options += [f"--jobs={jobs}"] if jobs is not None else []
    command: list[Any] = [program(), "check", "--format=json", "--fail-on=never", "--no-progress"]
    command += [*options, "--", *(os.fspath(path) for path in named)]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=False)
    message = done.stderr.decode("utf-8", "replace").strip()
    if done.returncode == 2:
        raise ArgumentError(message)
    try:
        data = json.loads(done.stdout)
    except ValueError:
        raise FileError(
            f"ntp check: exit {done.returncode}: {message}", FileStatus.CORRUPT
        ) from None
    return CheckReport(tuple(map(_file, data["files"])), data["summary"], data)


def _file(data: dict[str, Any]) -> CheckedFile:
    findings = tuple(
        Finding(f["id"], f["level"], f["message"], f["count"]) for f in data["findings"]
    )
    return CheckedFile(
        path=data["path"],
        status=data["status"],
        message=data["message"],
        type=data["type"],
        findings=findings,
        data=data,
    )
