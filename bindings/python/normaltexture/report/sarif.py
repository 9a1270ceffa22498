# SPDX-License-Identifier: MIT
"""Findings for other programs: SARIF 2.1.0 and the annotations of GitHub Actions.

The worst findings come first, because GitHub shows only so many.  What goes beyond its limits is
left out, and the file says how much.

Source: OASIS, Static Analysis Results Interchange Format 2.1.0; GitHub, workflow commands, and
SARIF support for code scanning (its fingerprints and limits).
"""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import quote

from .. import _ntp
from .._named import open_named
from ..gltf._rules import RULES
from ..usd._rules import RULES as USD_RULES

Json = dict[str, Any]

SARIF_VERSION = "2.1.0"
SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/os/schemas/sarif-schema-2.1.0.json"
UNREADABLE = "NT000"
# By content: a finding is known again as long as the file stays as it is.
FINGERPRINT = "normaltexture/v1"
# By place, for GitHub: an alert stays the same one, also a dismissed one, while the file is edited.
GITHUB_FINGERPRINT = "primaryLocationLineHash"

# What GitHub takes: results of a run, and bytes of a file.  A file has one run here.
MAX_RESULTS = 25_000
MAX_BYTES = 25_000_000
# `json.dumps(log, indent=1)` puts so many spaces before each line of a result.
_RESULT_DEPTH = 4

_SARIF_LEVELS = {"error": "error", "warning": "warning", "info": "note"}
_GITHUB_COMMANDS = {"error": "error", "warning": "warning", "info": "notice"}


def all_rules() -> dict[str, _ntp.Rule]:
    """Every rule by its id: the program's, those of glTF and USD, and that a file cannot be read."""
    unreadable = _ntp.Rule(
        UNREADABLE,
        "error",
        "the file cannot be read",
        "The file is missing, damaged, too large, or no image of a kind that is read.",
        "Restore the file, or leave it out with --exclude.",
    )
    return {UNREADABLE: unreadable, **_ntp.program_rules(), **RULES, **USD_RULES}


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


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _worst_first(
    report: Mapping[str, Any], notes: bool
) -> list[tuple[Mapping[str, Any], Mapping[str, Any]]]:
    """(file, finding) of all that count, errors before warnings before notes."""
    used = [
        (file, found)
        for file in report["files"]
        if _ntp.counts(file)
        for found in _findings(file)
        if notes or found["level"] != "info"
    ]
    return sorted(used, key=lambda pair: -_ntp.LEVELS.index(pair[1]["level"]))


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
        image = file["image"]  # an index of glTF, or a name of USD
        pointer = f"/images/{image}" if isinstance(image, int) else image
        location["logicalLocations"] = [{"fullyQualifiedName": pointer, "kind": "object"}]
    place = "\0".join([found["id"], file_uri(path), str(file.get("image", ""))])
    return {
        "ruleId": found["id"],
        "ruleIndex": rules.index(found["id"]),
        "level": _SARIF_LEVELS[found["level"]],
        "message": {"text": _where(file) + _sentence(found["message"])},
        "locations": [location],
        "partialFingerprints": {
            FINGERPRINT: _hash(f"{place}\0{digest}"),
            GITHUB_FINGERPRINT: f"{_hash(place)[:16]}:1",
        },
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
        One run, to be written as JSON, the worst findings first.  Paths are relative to %SRCROOT%
        where the check was given relative ones.  One fingerprint is of rule, path and content, so
        that a finding is known again as long as the file stays.  GitHub's is of rule and path.
        Findings beyond GitHub's limits are left out, and a notification of the run says how many.
    """
    rules = all_rules()
    used = _worst_first(report, notes)
    ids = sorted(rules.keys() | {found["id"] for _, found in used})
    for name in ids:
        rules.setdefault(name, _ntp.Rule(name, "warning", name, name, ""))
    kept = used[:MAX_RESULTS]
    digests = {path: _digest(path, root) for path in {_ntp.path_of(file) for file, _ in kept}}
    results = [_result(file, found, ids, digests[_ntp.path_of(file)]) for file, found in kept]
    failed = any(file["status"] == "unreadable" for file in report["files"])
    invocation: Json = {"executionSuccessful": not failed}
    run: Json = {
        "tool": {
            "driver": {
                "name": report["tool"]["name"],
                "semanticVersion": report["tool"]["version"],
                "version": report["tool"]["version"],
                "rules": [_rule(rules[name]) for name in ids],
            }
        },
        "invocations": [invocation],
        "originalUriBaseIds": {
            "%SRCROOT%": {"description": {"text": "Where the check was started."}}
        },
        "columnKind": "unicodeCodePoints",
        "results": [],
    }
    log: Json = {"$schema": SCHEMA, "version": SARIF_VERSION, "runs": [run]}
    room = MAX_BYTES - len(json.dumps(log, indent=1)) - 1000  # and a sentence about what is cut
    run["results"] = _that_fit(results, room)
    text = cut_message(len(used), len(run["results"]))
    if text:
        notification = {"level": "warning", "message": {"text": text}}
        invocation["toolExecutionNotifications"] = [notification]
    return log


def _that_fit(results: list[Json], room: int) -> list[Json]:
    """The first results, of at most `room` bytes as they are written."""
    for count, result in enumerate(results):
        text = json.dumps(result, indent=1)
        room -= len(text) + _RESULT_DEPTH * (text.count("\n") + 1) + len(",\n")
        if room < 0:
            return results[:count]
    return results


def cut_message(found: int, kept: int) -> str:
    """What is said where not all findings are written; "" where they are."""
    if found == kept:
        return ""
    return (
        f"{found - kept:,} of {found:,} findings are left out, the least grave ones: GitHub takes "
        f"{MAX_RESULTS:,} results and {MAX_BYTES // 1_000_000} MB in a file. Check fewer files at a "
        "time, and upload each file with a category of its own."
    )


def cut_of(log: Mapping[str, Any]) -> str:
    """What a log says about findings that were left out, "" for none."""
    notifications = log["runs"][0]["invocations"][0].get("toolExecutionNotifications", [])
    return " ".join(note["message"]["text"] for note in notifications)


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
        One line for each finding, the worst first; the workflow commands of GitHub.
    """
    lines = []
    rules = all_rules()
    for file, found in _worst_first(report, notes):
        path = _escape(os.fsencode(_ntp.path_of(file)).decode("utf-8", "replace"), ":,")
        rule = rules.get(found["id"])
        title = f"{found['id']}: {rule.title}" if rule else str(found["id"])
        command = _GITHUB_COMMANDS[found["level"]]
        message = _escape(_where(file) + found["message"])
        lines.append(f"::{command} file={path},line=1,title={_escape(title, ':,')}::{message}\n")
    return "".join(lines)
