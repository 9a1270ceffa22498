# SPDX-License-Identifier: MIT
"""Findings for other programs: SARIF 2.1.0 and the annotations of GitHub Actions.

Source: OASIS, Static Analysis Results Interchange Format 2.1.0; GitHub, workflow commands.
"""

import hashlib
import os
from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import quote

from .. import _ntp
from .._named import open_named
from ..gltf._rules import RULES

Json = dict[str, Any]

SARIF_VERSION = "2.1.0"
SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/os/schemas/sarif-schema-2.1.0.json"
UNREADABLE = "NT000"
FINGERPRINT = "normaltexture/v1"

_SARIF_LEVELS = {"error": "error", "warning": "warning", "info": "note"}
_GITHUB_COMMANDS = {"error": "error", "warning": "warning", "info": "notice"}


def all_rules() -> dict[str, _ntp.Rule]:
    """Every rule by its id: the program's, those of glTF, and that a file cannot be read."""
    unreadable = _ntp.Rule(
        UNREADABLE,
        "error",
        "the file cannot be read",
        "The file is missing, damaged, too large, or no image of a kind that is read.",
        "Restore the file, or leave it out with --exclude.",
    )
    return {UNREADABLE: unreadable, **_ntp.program_rules(), **RULES}


def file_uri(path: str) -> str:
    """A path as the URI of an artifact: relative as it is, absolute with file://."""
    raw = os.fsencode(path)
    if os.path.isabs(path):
        return "file://" + quote(raw)
    uri = quote(os.path.normpath(raw))
    # A colon in the first segment would make it a scheme.
    return f"./{uri}" if ":" in uri.split("/")[0] else uri


def _digest(path: str, root: str | os.PathLike[str] | None) -> str:
    """The SHA-256 of a file, "" when it cannot be read or lies outside of `root`."""
    try:
        with os.fdopen(open_named(path, root), "rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def _findings(file: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """The findings of a file; that it is unreadable is one too."""
    if file["status"] == "unreadable":
        yield {"id": UNREADABLE, "level": "error", "message": file["message"], "count": 0}
    yield from file["findings"]


def _where(file: Mapping[str, Any]) -> str:
    """Which image of a glTF file; "" for an image file."""
    if "image" not in file:
        return ""
    name = f' "{file["name"]}"' if file.get("name") else ""
    return f"image {file['image']}{name}: "


def _result(
    file: Mapping[str, Any], found: Mapping[str, Any], rules: list[str], digest: str
) -> Json:
    path = _ntp.path_of(file)
    location: Json = {
        "physicalLocation": {
            # A line is asked for even of a picture: line 1.
            "artifactLocation": {"uri": file_uri(path)},
            "region": {"startLine": 1},
        }
    }
    if not os.path.isabs(path):
        location["physicalLocation"]["artifactLocation"]["uriBaseId"] = "%SRCROOT%"
    if "image" in file:
        pointer = f"/images/{file['image']}"
        location["logicalLocations"] = [{"fullyQualifiedName": pointer, "kind": "object"}]
    key = "\0".join([found["id"], file_uri(path), str(file.get("image", "")), digest])
    return {
        "ruleId": found["id"],
        "ruleIndex": rules.index(found["id"]),
        "level": _SARIF_LEVELS[found["level"]],
        "message": {"text": _where(file) + _sentence(found["message"])},
        "locations": [location],
        "partialFingerprints": {FINGERPRINT: hashlib.sha256(key.encode()).hexdigest()},
        "properties": {"texels": found["count"]},
    }


def _sentence(message: str) -> str:
    """A sentence, in which no name can pose as a link ("[text](target)" would be one)."""
    if "](" in message:
        message = message.replace("\\", "\\\\").replace("[", "\\[").replace("]", "\\]")
    return message if message.endswith(".") else message + "."


def _rule(rule: _ntp.Rule) -> Json:
    return {
        "id": rule.id,
        "shortDescription": {"text": _capital(rule.title)},
        "fullDescription": {"text": rule.text},
        "help": {"text": f"What to do: {rule.remedy}", "markdown": f"What to do: {rule.remedy}"},
        "defaultConfiguration": {"level": _SARIF_LEVELS[rule.level]},
    }


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:].rstrip(".") + "."


def to_sarif(
    report: Mapping[str, Any],
    *,
    notes: bool = False,
    root: str | os.PathLike[str] | None = None,
) -> Json:
    """The findings of a check as SARIF 2.1.0, for code scanning.

    Parameters
    ----------
    report
        What ``ntp check --format json`` or `normaltexture.gltf.check` gives.
    notes
        Keep findings of the level "info" as well.
    root
        The folder in which files have to lie whose content goes into fingerprints.  None: anywhere.

    Returns
    -------
    dict
        One run, to be written as JSON.  Paths are relative to %SRCROOT% where the check was given
        relative ones.  Fingerprints depend on rule, path and content, so that a finding is known
        again as long as the file stays.
    """
    rules = all_rules()
    results: list[Json] = []
    used: list[tuple[Mapping[str, Any], Mapping[str, Any]]] = []
    for file in report["files"]:
        if not _ntp.counts(file):
            continue
        used += [(file, f) for f in _findings(file) if notes or f["level"] != "info"]
    ids = sorted(rules.keys() | {found["id"] for _, found in used})
    for name in ids:
        rules.setdefault(name, _ntp.Rule(name, "warning", name, name, ""))
    digests = {path: _digest(path, root) for path in {_ntp.path_of(file) for file, _ in used}}
    for file, found in used:
        results.append(_result(file, found, ids, digests[_ntp.path_of(file)]))
    failed = any(file["status"] == "unreadable" for file in report["files"])
    return {
        "$schema": SCHEMA,
        "version": SARIF_VERSION,
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": report["tool"]["name"],
                        "semanticVersion": report["tool"]["version"],
                        "version": report["tool"]["version"],
                        "rules": [_rule(rules[name]) for name in ids],
                    }
                },
                "invocations": [{"executionSuccessful": not failed}],
                "originalUriBaseIds": {
                    "%SRCROOT%": {"description": {"text": "Where the check was started."}}
                },
                "columnKind": "unicodeCodePoints",
                "results": results,
            }
        ],
    }


def _escape(text: str, extra: str = "") -> str:
    """The escapes of workflow commands; `extra` are further characters of properties."""
    for char in "%\r\n" + extra:
        text = text.replace(char, f"%{ord(char):02X}")
    return text


def to_github(report: Mapping[str, Any], *, notes: bool = False) -> str:
    """The findings of a check as annotations: lines that a workflow prints.

    Parameters
    ----------
    report, notes
        As in `to_sarif`.

    Returns
    -------
    str
        One line for each finding; the workflow commands of GitHub.
    """
    lines = []
    rules = all_rules()
    for file in report["files"]:
        if not _ntp.counts(file):
            continue
        path = _escape(os.fsencode(_ntp.path_of(file)).decode("utf-8", "replace"), ":,")
        for found in _findings(file):
            if found["level"] == "info" and not notes:
                continue
            rule = rules.get(found["id"])
            title = f"{found['id']}: {rule.title}" if rule else str(found["id"])
            command = _GITHUB_COMMANDS[found["level"]]
            message = _escape(_where(file) + found["message"])
            lines.append(
                f"::{command} file={path},line=1,title={_escape(title, ':,')}::{message}\n"
            )
    return "".join(lines)
