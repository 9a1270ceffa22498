# SPDX-License-Identifier: MIT
"""ntp usd: checks and cleans the normals textures of USD scenes from the command line."""

import argparse
import json
import sys
from collections.abc import Sequence
from typing import Any

from .. import _console, _ntp
from ..images import MissingLibraryError
from ..report import sarif

Json = dict[str, Any]
SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")

_EPILOG = """\
Without -o and --in-place the scenes are checked: the texels of textures that feed normals inputs,
and the color space, scale and bias of the shaders that read them. With one of them the textures
are cleaned; layers stay as they are. The exit code is 1 if an image has a finding at or above
--fail-on, or would still have it in the copy. It is 3 if a file could not be read or written, or
if no scene was found. It needs usd-core: pip install 'normaltexture[usd]'

examples:
  ntp usd chair.usdz
  ntp usd -r scenes --format sarif > usd.sarif
  ntp usd scene.usda -o out/
    the scene with all files that it names, in another directory
  ntp usd scene.usda --in-place
"""


def _parser() -> argparse.ArgumentParser:
    parser = _console.parser(
        "ntp usd", "Checks or cleans the normals textures of USD scenes.", _EPILOG
    )
    _console.add_paths(
        parser,
        "a .usd, .usda, .usdc or .usdz file, or a directory",
        "nothing to check is no failure: no USD file was found, or none of its images is read",
    )
    _console.add_named(parser, "a scene names", "of that scene")
    how = parser.add_argument_group("checking")
    how.add_argument(
        "--y",
        choices=["up", "auto"],
        default="up",
        help="which way green has to point: up, or down where scale and bias turn it; auto: any way "
        "(default: up)",
    )
    _console.add_check_options(how)
    how.add_argument(
        "--format",
        choices=["text", "json", "sarif", "github"],
        default="text",
        help="text for people, JSON, SARIF 2.1.0, GitHub annotations (default: text)",
    )
    cleaning = parser.add_argument_group("cleaning")
    where = cleaning.add_mutually_exclusive_group()
    where.add_argument(
        "-o", "--output", metavar="DIR", help="write a copy of the scene; a .usdz as a FILE too"
    )
    where.add_argument("--in-place", action="store_true", help="clean the textures themselves")
    cleaning.add_argument(
        "--method",
        choices=["derive", "normalize", "auto"],
        default="auto",
        help="as of ntp clean (default: auto)",
    )
    cleaning.add_argument("-n", "--dry-run", action="store_true", help="write nothing")
    _console.add_loudness(parser)
    return parser


def _label(file: Json) -> str:
    return f"{_console.shown(file['path'])}, {_console.shown(file['image'])}"


def _print_check(report: Json, *, quiet: bool, verbose: bool) -> None:
    for file in report["files"]:
        if file["status"] == "unreadable":
            print(f"ntp: {_console.shown(file['message'])}", file=sys.stderr)
            continue
        level = _ntp.worst_level(file)
        if quiet and level in (None, "info"):
            continue
        inputs = ", ".join(sorted({_console.shown(use["input"]) for use in file["uses"]}))
        if file["status"] == "skipped":
            print(f"{_label(file)} ({inputs}): not checked")
        else:
            size = f"{file['width']} x {file['height']} {file['bit_depth']}-bit"
            verdict = "well formed" if level in (None, "info") else level
            print(f"{_label(file)} ({inputs}): {file['type']}, {size}: {verdict}")
        for found in file["findings"]:
            if verbose or found["level"] != "info":
                print(f"  {found['level']:<7} {found['id']}  {_console.shown(found['message'])}")
    if not report["files"] and not quiet:
        print("no normals textures")


def _print_clean(report: Json, *, quiet: bool, dry_run: bool) -> None:
    for file in report["files"]:
        if file["status"] != "ok":
            print(f"ntp: {_console.shown(file['message'])}", file=sys.stderr)
        elif file["written"] and not quiet:
            print(
                f"{_label(file)}: {file['changed']:,} of {file['texels']:,} texels changed, "
                f"turned by up to {file['angle_deg']['max']:g} degrees"
            )
        elif not quiet:
            print(f"{_label(file)}: nothing to change")
        for found in file.get("remaining", []):
            if found["level"] != "info":
                message = _console.shown(found["message"])
                print(f"  left: {found['level']} {found['id']}  {message}")
    if not quiet:
        verb = "would be written" if dry_run else "written"
        for output in report["outputs"]:
            print(f"{_console.shown(output['path'])}: {verb}")


def _failed(path: str, message: str) -> Json:
    """The report of a scene of which nothing was made."""
    entry = {**_ntp.path_fields(path), "status": "unreadable", "message": message}
    entry["written"] = False
    return {"files": [entry], "outputs": [], "summary": {"files": 1, "failed": 1}}


def _run_clean(args: argparse.Namespace, paths: Sequence[str]) -> int:
    from . import clean
    from ._check import MALFORMED, why

    if args.output is not None and len(paths) > 1 and args.output.lower().endswith(SUFFIXES):
        raise _ntp.ProgramError("several inputs need a directory after -o", _ntp.EXIT_USAGE)
    reports: list[Json] = []
    wrong_use = False
    for path in paths:
        try:
            report = clean(
                path,
                args.output,
                method=args.method,
                root=args.root,
                max_bytes=args.max_bytes,
                options=_console.check_options(args),
                dry_run=args.dry_run,
            )
        except MALFORMED as error:
            report = _failed(path, why(path, error))
        except ValueError as error:
            report = _failed(path, str(error).replace("output: ", "-o: "))
            wrong_use = True
        reports.append(report)
        if args.format != "json":
            _print_clean(report, quiet=args.quiet, dry_run=args.dry_run)
    if args.format == "json":
        print(json.dumps(_joined(reports), indent=1))
    return _ntp.EXIT_USAGE if wrong_use else _cleaned_code(reports, args.fail_on)


def _cleaned_code(reports: Sequence[Json], fail_on: str) -> int:
    """3 where a scene failed; 1 where an image was refused, or keeps a finding."""
    files = [file for report in reports for file in report["files"]]
    states = {file["status"] for file in files}
    if "unreadable" in states:
        return _ntp.EXIT_FAILED
    if "refused" in states:
        return _ntp.EXIT_FINDINGS
    left = [{"status": "ok", "findings": file.get("remaining", [])} for file in files]
    return _ntp.exit_code(left, fail_on)


def _joined(reports: Sequence[Json]) -> Json:
    """One report of several."""
    names = ("files", "written", "unchanged", "skipped", "refused", "failed")
    summary = {name: sum(r["summary"].get(name, 0) for r in reports) for name in names}
    return {
        "schema_version": 1,
        "tool": _ntp.tool_fields(),
        "files": [file for report in reports for file in report["files"]],
        "outputs": [output for report in reports for output in report["outputs"]],
        "summary": summary,
    }


def _run(args: argparse.Namespace) -> int:
    paths = _console.gather(args, SUFFIXES)
    if not paths and _console.fails_empty(args, "no USD file found"):
        return _ntp.EXIT_FAILED
    cleaning = args.output is not None or args.in_place
    if cleaning and args.format in ("sarif", "github"):
        raise _ntp.ProgramError("--format sarif and github are for checking", _ntp.EXIT_USAGE)
    if args.dry_run and not cleaning:
        raise _ntp.ProgramError("--dry-run goes with -o or --in-place", _ntp.EXIT_USAGE)
    try:
        if cleaning:
            return _run_clean(args, paths)
        from . import check
    except MissingLibraryError as error:
        raise _ntp.ProgramError(str(error)) from None
    report = check(
        list(paths),
        y=args.y,
        root=args.root,
        max_bytes=args.max_bytes,
        options=_console.check_options(args),
    )
    if args.format == "json":
        print(json.dumps(report, indent=1))
    elif args.format == "sarif":
        log = sarif.to_sarif(report)
        if sarif.cut_of(log):
            print(f"ntp: {sarif.cut_of(log)}", file=sys.stderr)
        print(json.dumps(log, indent=1))
    elif args.format == "github":
        sys.stdout.write(sarif.to_github(report))
    else:
        _print_check(report, quiet=args.quiet, verbose=args.verbose)
    code = _ntp.exit_code(report["files"], args.fail_on)
    empty = _ntp.nothing_checked(report["files"]) if report["files"] else None
    return _ntp.EXIT_FAILED if _console.fails_empty(args, empty) else code


def main(argv: Sequence[str] | None = None) -> int:
    """Runs ``ntp usd``; returns its exit code."""
    return _console.run(_parser(), _run, argv)


if __name__ == "__main__":
    sys.exit(main())
