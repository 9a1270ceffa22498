# SPDX-License-Identifier: MIT
"""Runs the program ntp and reads its JSON; the texts of its findings.

What a texture is and what is wrong with it is decided in one place, the program.  The report, the
glTF checker and the cluster functions all start from its JSON.
"""

import base64
import json
import os
import re
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from . import _program

EXIT_DONE, EXIT_FINDINGS, EXIT_USAGE, EXIT_FAILED, EXIT_INTERRUPTED = 0, 1, 2, 3, 130
LEVELS = ("info", "warning", "error")

Json = dict[str, Any]


class ProgramError(RuntimeError):
    """The program ntp is missing, or was used wrongly; `code` is its exit code."""

    def __init__(self, message: str, code: int = EXIT_FAILED) -> None:
        super().__init__(message)
        self.code = code


def program() -> Path:
    """Where ntp is.

    Raises
    ------
    ProgramError
        There is none.
    """
    try:
        return _program.program()
    except FileNotFoundError as error:
        raise ProgramError(str(error)) from None


def _nul_separated(paths: Iterable[str | bytes | os.PathLike[Any]]) -> bytes:
    names = [os.fsencode(path) for path in paths]
    for name in names:
        if b"\0" in name or not name:
            raise ProgramError(f"no file is called {os.fsdecode(name)!r}", EXIT_USAGE)
    return b"".join(name + b"\0" for name in names)


def run_json(
    verb: str,
    paths: Iterable[str | bytes | os.PathLike[Any]],
    options: Sequence[str] = (),
    cwd: str | os.PathLike[str] | None = None,
) -> tuple[Json, int]:
    """Runs ``ntp VERB --format json`` on paths; gives the JSON and the exit code.

    The paths go through standard input: any number of any bytes.

    Raises
    ------
    ProgramError
        The program is missing, was told something wrong, or was interrupted.
    """
    command = [str(program()), verb, *options, "--format", "json", "--no-progress"]
    command += ["--color", "never", "-q", "-0", "--files-from", "-"]
    done = subprocess.run(
        command, input=_nul_separated(paths), capture_output=True, check=False, cwd=cwd
    )
    if done.returncode not in (EXIT_DONE, EXIT_FINDINGS, EXIT_FAILED) or not done.stdout:
        text = done.stderr.decode("utf-8", "replace").strip()
        code = done.returncode if done.returncode > 0 else EXIT_FAILED
        raise ProgramError(text or f"ntp {verb} ended with {done.returncode}", code)
    return json.loads(done.stdout), done.returncode


@lru_cache(maxsize=1)
def tool_fields() -> Json:
    """The "tool" of every JSON: which program made it."""
    command = [str(program()), "--version"]
    said = subprocess.run(command, capture_output=True, check=True, encoding="utf-8").stdout
    name, _, codecs = said.splitlines()
    return {"name": "ntp", "version": name.split()[1], "codecs": codecs}


def path_of(file: Mapping[str, Any]) -> str:
    """The path of a file in the JSON, as Python spells it (bytes that are no UTF-8 survive)."""
    if "path_base64" in file:
        return os.fsdecode(base64.b64decode(file["path_base64"]))
    return str(file["path"])


def path_fields(path: str | os.PathLike[str]) -> Json:
    """``path``, and ``path_base64`` where that loses bytes, as the program writes them."""
    raw = os.fsencode(path)
    shown = raw.decode("utf-8", "replace")
    if shown.encode("utf-8") == raw:
        return {"path": shown}
    return {"path": shown, "path_base64": base64.b64encode(raw).decode("ascii")}


def worst_level(file: Mapping[str, Any]) -> str | None:
    """The highest level among the findings of a file: "error", "warning", "info" or None."""
    found = [LEVELS.index(finding["level"]) for finding in file.get("findings", [])]
    return LEVELS[max(found)] if found else None


def counts(file: Mapping[str, Any]) -> bool:
    """Whether the findings of a file count: False for photographs met in a directory."""
    return file["status"] != "ok" or bool(file.get("counts", True))


def exit_code(files: Iterable[Mapping[str, Any]], fail_on: str = "error") -> int:
    """What `ntp check` would exit with for these files."""
    code = EXIT_DONE
    for file in files:
        if file["status"] == "unreadable":
            return EXIT_FAILED
        level = worst_level(file)
        if (
            fail_on != "never"
            and level is not None
            and counts(file)
            and LEVELS.index(level) >= LEVELS.index(fail_on)
        ):
            code = EXIT_FINDINGS
    return code


def nothing_checked(files: Sequence[Mapping[str, Any]]) -> str | None:
    """What `ntp check` says where no file was checked; None where one was."""
    if any(file["status"] != "skipped" and counts(file) for file in files):
        return None
    if not files:
        return "no image found"
    number = f"{len(files)} image{'' if len(files) == 1 else 's'}"
    why = "none is a normals texture by name or content"
    if any(file["status"] == "skipped" for file in files):
        why = "none is a normals texture of a format that is read"
    return f"nothing was checked: of {number}, {why}; --allow-empty allows that"


@dataclass(frozen=True)
class Rule:
    """One kind of finding: its id, its levels in words, and the texts of its documentation."""

    id: str
    levels: str
    title: str
    text: str
    remedy: str

    @property
    def level(self) -> str:
        """The highest level that it comes with."""
        return max((word for word in LEVELS if word in self.levels), key=LEVELS.index)


_SECTION = re.compile(
    r"^## (NT\d{3}): (.+?)\n\nLevel: (.+?)\.\n\n(.+?)\n\nWhat to do: (.+?)(?=\n\n<a|\s*\Z)",
    re.MULTILINE | re.DOTALL,
)


def parse_rules(page: str) -> dict[str, Rule]:
    """The rules on a page like docs/findings.md."""
    rules = {}
    for match in _SECTION.finditer(page):
        name, title, levels, text, remedy = match.groups()
        rules[name] = Rule(name, levels, title, text.strip(), remedy.strip())
    return rules


@lru_cache(maxsize=1)
def program_rules() -> dict[str, Rule]:
    """The rules of the program, from its own table."""
    command = [str(program()), "--generate", "findings"]
    done = subprocess.run(command, capture_output=True, check=True, encoding="utf-8")
    return parse_rules(done.stdout)
