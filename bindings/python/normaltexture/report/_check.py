# SPDX-License-Identifier: MIT
"""The check that a report is made of: image files by the program, glTF files by our own walk."""

import os
from collections.abc import Iterable, Sequence
from typing import Any

from .. import _ntp
from ..gltf import check as check_gltf

Json = dict[str, Any]
GLTF_SUFFIXES = (".gltf", ".glb")


def _total(reports: Sequence[Json]) -> Json:
    """One summary of several: counts are added up."""
    summary: Json = {}
    for report in reports:
        for key, count in report["summary"].items():
            if isinstance(count, int):
                summary[key] = summary.get(key, 0) + count
            else:
                summary.setdefault(key, count)
    return summary


def check_json(
    paths: Iterable[str | os.PathLike[str]], *, options: Sequence[str] = (), y: str = "auto"
) -> Json:
    """Checks image files, directories and glTF files.

    Parameters
    ----------
    paths
        Files and directories.  Named .gltf and .glb files are checked under glTF's rules.
    options
        Options of ``ntp check``, such as ``("-r", "--max-fail", "5")``.
    y
        Which way green has to point: "up", "down", or "auto" to require nothing.

    Returns
    -------
    dict
        As ``ntp check --format json`` prints it.

    Raises
    ------
    normaltexture._ntp.ProgramError
        The program ntp is missing or refuses an option.
    """
    named = [os.fspath(path) for path in paths]
    models = [p for p in named if p.lower().endswith(GLTF_SUFFIXES) and not os.path.isdir(p)]
    images = [path for path in named if path not in models]
    reports = []
    if images or not models:
        reports.append(_ntp.run_json("check", images, ["--y", y, *options])[0])
    if models:
        kept = tuple(word for word in options if word not in ("-r", "--recursive"))
        reports.append(check_gltf(models, y="auto" if y == "auto" else "up", options=kept))
    if len(reports) == 1:
        return reports[0]
    return {
        "schema_version": 1,
        "tool": reports[0]["tool"],
        "files": [file for report in reports for file in report["files"]],
        "summary": _total(reports),
    }
