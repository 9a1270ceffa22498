# SPDX-License-Identifier: MIT
"""The check that a report is made of: the program checks images, `gltf` checks glTF files."""

import os
from collections.abc import Iterable, Sequence
from typing import Any

from .. import _ntp
from .._named import MAX_BYTES
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


def _check_models(
    models: Sequence[str],
    options: Sequence[str],
    y: str,
    root: str | os.PathLike[str] | None,
    max_bytes: int,
) -> Json:
    """glTF files, with the options of `ntp check` that they understand."""
    kept = [word for word in options if word not in ("-r", "--recursive")]
    type: Any = "auto"
    if "--type" in kept:
        at = kept.index("--type")
        type = kept[at + 1] if kept[at + 1] != "height" else "auto"
        del kept[at : at + 2]
    way = "auto" if y == "auto" else "up"
    return check_gltf(models, type=type, y=way, root=root, max_bytes=max_bytes, options=tuple(kept))


def check_json(
    paths: Iterable[str | os.PathLike[str]],
    *,
    options: Sequence[str] = (),
    y: str = "auto",
    root: str | os.PathLike[str] | None = None,
    max_bytes: int = MAX_BYTES,
) -> Json:
    """Checks image files, directories and glTF files.

    Parameters
    ----------
    paths
        Files and directories.  Named .gltf and .glb files are checked under glTF's rules.
    options
        Options of ``ntp check``, such as ``("-r", "--max-fail", "5")``.
    y
        Which way green has to point: "up", "down" ("opengl", "directx"), or "auto" to require
        nothing.
    root, max_bytes
        Of glTF files, as in `normaltexture.gltf.check`.

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
        reports.append(_check_models(models, options, y, root, max_bytes))
    if len(reports) == 1:
        return reports[0]
    return {
        "schema_version": 1,
        "tool": reports[0]["tool"],
        "files": [file for report in reports for file in report["files"]],
        "summary": _total(reports),
    }
