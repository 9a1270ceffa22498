# SPDX-License-Identifier: MIT
"""ntp report: one HTML page, SARIF or annotations of a check."""

import argparse
import json
import os
import sys
from collections.abc import Sequence
from typing import Any

from .. import _console, _ntp
from ._check import GLTF_SUFFIXES, check_json
from ._page import MAX_TEXELS, build, save
from .sarif import cut_of, to_github, to_sarif

Json = dict[str, Any]

_EPILOG = """\
The page needs no network and no other file. The exit code is that of ntp check: 1 with a finding
at or above --fail-on, 3 where a file could not be read or nothing was there to check.

Files that --from-json or a glTF file names are opened if they are regular files in a folder, links
followed: for --from-json the current folder, for a glTF file its own. --root names another.

examples:
  ntp report -r textures -o report.html
  ntp report helmet.glb -o helmet.html
  ntp report -r textures --format sarif -o ntp.sarif --fail-on never
  ntp report -r textures --format github
    annotations in a GitHub workflow
  ntp check -r textures --format json | ntp report --from-json - -o report.html
"""


def _parser() -> argparse.ArgumentParser:
    parser = _console.parser(
        "ntp report", "Writes an HTML page, SARIF or annotations of a check.", _EPILOG
    )
    _console.add_paths(
        parser,
        "an image file, a directory, or a .gltf or .glb file",
        "nothing to check is no failure: no image was found, or no normals texture",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="where to write; - is standard output (default of SARIF and annotations)",
    )
    parser.add_argument(
        "--format",
        choices=["html", "sarif", "github", "json"],
        default="html",
        help="an HTML page, SARIF 2.1.0, GitHub annotations, or the JSON that they "
        "are made of (default: html)",
    )
    parser.add_argument(
        "--from-json",
        metavar="FILE",
        help="report what ntp check --format json has found before; - is standard input",
    )
    _console.add_named(parser, "--from-json or a glTF file names", "described below")
    how = parser.add_argument_group("checking")
    how.add_argument(
        "--type",
        choices=["auto", "standard", "zzero", "xy", "height"],
        default="auto",
        help="what the files are (default: auto)",
    )
    how.add_argument(
        "--y",
        choices=["auto", "up", "down", "opengl", "directx"],
        default="auto",
        help="which way green has to point (default: auto, any)",
    )
    _console.add_check_options(how)
    how.add_argument("--baseline", metavar="FILE", help="leave out findings of an earlier JSON")
    how.add_argument("--deep", action="store_true", help="look at every row")
    how.add_argument("-j", "--jobs", type=int, metavar="N", help="check N files at once")
    page = parser.add_argument_group("the page")
    page.add_argument("--title", default="Normals textures", help="its heading")
    page.add_argument(
        "--size",
        type=int,
        default=256,
        metavar="N",
        help="the longer side of its pictures (default: 256)",
    )
    page.add_argument(
        "--limit",
        type=int,
        default=200,
        metavar="N",
        help="how many files get pictures, the worst first (default: 200)",
    )
    page.add_argument(
        "--palette",
        choices=["reference", "safe"],
        default="reference",
        help="of heatmaps; safe: for every kind of color vision",
    )
    page.add_argument(
        "--max-texels",
        type=int,
        default=MAX_TEXELS,
        metavar="N",
        help=f"no pictures of larger files (default: {MAX_TEXELS})",
    )
    parser.add_argument(
        "--notes",
        action="store_true",
        help="findings of the level info too, in SARIF and annotations",
    )
    _console.add_loudness(parser)
    return parser


def _check_options(args: argparse.Namespace) -> tuple[str, ...]:
    words = [*_console.check_options(args), "--type", args.type]
    if args.recursive:
        words.append("--recursive")
    if args.deep:
        words.append("--deep")
    if args.jobs is not None:
        words += ["--jobs", str(args.jobs)]
    if args.baseline is not None:
        words += ["--baseline", args.baseline]
    for name in ("match", "exclude"):
        for glob in getattr(args, name):
            words += [f"--{name}", glob]
    return tuple(words)


def _load(path: str) -> Json:
    try:
        if path == "-":
            report = json.load(sys.stdin.buffer)
        else:
            with open(path, "rb") as file:
                report = json.load(file)
        if report["schema_version"] != 1:
            raise ValueError(f"schema_version is {report['schema_version']!r}")
        for file in report["files"]:
            for key in ("path", "status", "findings"):
                if key not in file:
                    raise ValueError(f"a file has no {key}")
    except (ValueError, KeyError, TypeError) as error:
        message = f"--from-json: {path}: no JSON of ntp check: {error}"
        raise _ntp.ProgramError(message, _ntp.EXIT_FAILED) from None
    return dict(report)


def _render(args: argparse.Namespace, report: Json) -> str:
    root = args.root
    if root is None and args.from_json is not None:
        root = os.curdir
    if args.format == "sarif":
        log = to_sarif(report, notes=args.notes, root=root)
        if cut_of(log):
            print(f"ntp: {cut_of(log)}", file=sys.stderr)
        return json.dumps(log, indent=1) + "\n"
    if args.format == "github":
        return to_github(report, notes=args.notes)
    if args.format == "json":
        return json.dumps(report, indent=1) + "\n"
    return build(
        report,
        title=args.title,
        size=args.size,
        limit=args.limit,
        palette=args.palette,
        max_texels=args.max_texels,
        root=root,
        max_bytes=args.max_bytes,
    )


def _run(args: argparse.Namespace) -> int:
    for name, least in (("size", 16), ("limit", 0), ("max_texels", 1)):
        if getattr(args, name) < least:
            option = name.replace("_", "-")
            raise _ntp.ProgramError(f"--{option} is at least {least}", _ntp.EXIT_USAGE)
    output = args.output or ("" if args.format == "html" else "-")
    if not output:
        raise _ntp.ProgramError(
            "-o FILE is needed for HTML (- for standard output)", _ntp.EXIT_USAGE
        )
    paths: list[str] = []
    if args.from_json is not None:
        if args.paths or args.files_from:
            raise _ntp.ProgramError("--from-json takes no PATH", _ntp.EXIT_USAGE)
        report = _load(args.from_json)
    else:
        paths = _console.listed_paths(args)
        report = check_json(
            paths,
            options=_check_options(args),
            y=args.y,
            root=args.root,
            max_bytes=args.max_bytes,
        )
    text = _render(args, report)
    if output == "-":
        sys.stdout.write(text)
    else:
        save(text, output)
    if not args.quiet:
        for file in report["files"]:
            if file["status"] == "unreadable":
                print(f"ntp: {_console.shown(file['message'])}", file=sys.stderr)
        if output != "-" and args.format == "html":
            count = len(report["files"])
            files = "file" if count == 1 else "files"
            print(f"{_console.shown(os.fspath(output))}: {count} {files}", file=sys.stderr)
    code = _ntp.exit_code(report["files"], args.fail_on)
    models = any(path.lower().endswith(GLTF_SUFFIXES) for path in paths)
    empty = None if models and not report["files"] else _ntp.nothing_checked(report["files"])
    return _ntp.EXIT_FAILED if _console.fails_empty(args, empty) else code


def main(argv: Sequence[str] | None = None) -> int:
    """Runs ``ntp report``; returns its exit code."""
    return _console.run(_parser(), _run, argv)


if __name__ == "__main__":
    sys.exit(main())
