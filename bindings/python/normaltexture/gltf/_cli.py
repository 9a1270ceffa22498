# SPDX-License-Identifier: MIT
"""ntp gltf: checks and cleans the normals textures of glTF files from the command line."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .. import _console, _ntp
from ..report import sarif
from ._check import MALFORMED, check, where, why
from ._clean import clean
from ._document import GltfError

Json = dict[str, Any]
SUFFIXES = (".gltf", ".glb")

_EPILOG = """\
Without -o and --in-place the files are checked. With one of them a clean copy is written in which
only normals textures differ. The exit code is 1 if an image has a finding at or above --fail-on,
or would still have it in the copy. It is 3 if a file could not be read or written, or if no file
was found.

A glTF file names other files. They are read if they are regular files in its own folder, links
followed; --root names a larger folder.

examples:
  ntp gltf helmet.glb
  ntp gltf -r models --format sarif > gltf.sarif
  ntp gltf helmet.glb -o helmet_clean.glb
  ntp gltf scene.gltf -o out/
    scene.gltf, with what it names, in another directory
"""


def _parser() -> argparse.ArgumentParser:
    parser = _console.parser(
        "ntp gltf", "Checks or cleans the normals textures in glTF files.", _EPILOG
    )
    _console.add_paths(
        parser,
        "a .gltf or .glb file, or a directory",
        "nothing to check is no failure: no glTF file was found, or none of its images is read",
    )
    _console.add_named(parser, "a glTF file names", "of that file")
    how = parser.add_argument_group("checking")
    how.add_argument(
        "--type",
        choices=["auto", "standard", "zzero", "xy"],
        default="auto",
        help="what the images hold; auto: standard normals as glTF says, but heights, photographs "
        "and the like are reported and never cleaned (default: auto)",
    )
    how.add_argument(
        "--y",
        choices=["up", "auto"],
        default="up",
        help="which way green has to point: up as glTF says, or auto: any way (default: up)",
    )
    _console.add_check_options(how)
    how.add_argument(
        "--format",
        choices=["text", "json", "sarif", "github"],
        default="text",
        help="text for people, JSON, SARIF 2.1.0, GitHub annotations (default: text)",
    )
    clean_group = parser.add_argument_group("cleaning")
    where = clean_group.add_mutually_exclusive_group()
    where.add_argument("-o", "--output", metavar="FILE|DIR", help="write a clean copy")
    where.add_argument("--in-place", action="store_true", help="clean the files themselves")
    clean_group.add_argument(
        "--method",
        choices=["derive", "normalize", "auto"],
        default="auto",
        help="as of ntp clean (default: auto)",
    )
    clean_group.add_argument(
        "--keep-alpha", action="store_true", help="keep alpha channels that are opaque everywhere"
    )
    clean_group.add_argument(
        "--flip-green", action="store_true", help="turn green from down (DirectX) to up"
    )
    clean_group.add_argument(
        "--keep-jpeg", action="store_true", help="leave JPEG images; otherwise they become PNG"
    )
    clean_group.add_argument("-n", "--dry-run", action="store_true", help="write nothing")
    _console.add_loudness(parser)
    return parser


def image_label(file: Json) -> str:
    """How text calls an image."""
    label = f"{_console.shown(file['path'])}, image {file['image']}"
    name = file.get("name")
    return f'{label} "{_console.shown(name)}"' if name else label


def _slot_words(use: Json) -> str:
    """A slot, and by which of a texture's images it is shown."""
    if use["via"]:
        return f"{use['slot']} by {use['via']}"
    return f"{use['slot']}, fallback" if use["role"] == "fallback" else str(use["slot"])


def _print_check(report: Json, *, quiet: bool, verbose: bool) -> None:
    words = {"zzero": "Z-zero", "xy": "XY only", "height": "heights", "one-color": "one color"}
    for file in report["files"]:
        if file["status"] == "unreadable":
            print(f"ntp: {_console.shown(file['message'])}", file=sys.stderr)
            continue
        level = _ntp.worst_level(file)
        if quiet and level in (None, "info"):
            continue
        slots = ", ".join(sorted({_slot_words(use) for use in file["uses"]}))
        if file["status"] == "skipped":
            reason = file["message"].removeprefix(f"{where(file)}: ")
            print(f"{image_label(file)} ({slots}): not checked: {reason}")
        else:
            kind = words.get(file["type"], file["type"])
            size = f"{file['width']} x {file['height']} {file['bit_depth']}-bit"
            verdict = "well formed" if level in (None, "info") else level
            print(f"{image_label(file)} ({slots}): {kind}, {size}: {verdict}")
        for found in file["findings"]:
            if verbose or found["level"] != "info":
                print(f"  {found['level']:<7} {found['id']}  {found['message']}")
    if not report["files"] and not quiet:
        print("no normals textures")


def _print_clean(report: Json, *, quiet: bool, dry_run: bool) -> None:
    for file in report["files"]:
        if file["status"] == "ok" and quiet:
            continue
        if file["status"] != "ok":
            print(f"ntp: {_console.shown(file['message'])}", file=sys.stderr)
        elif file["written"]:
            also = [
                word
                for key, word in (
                    ("alpha_dropped", "alpha dropped"),
                    ("green_flipped", "green flipped"),
                )
                if file[key]
            ]
            turned = f"turned by up to {file['angle_deg']['max']:g} degrees"
            print(
                f"{image_label(file)}: {file['changed']:,} of {file['texels']:,} texels changed, "
                + ", ".join([turned, *also])
            )
        else:
            print(f"{image_label(file)}: nothing to change")
        for found in file.get("remaining", []):
            if found["level"] != "info":
                print(f"  left: {found['level']} {found['id']}  {found['message']}")
    if not quiet:
        verb = "would be written" if dry_run else "written"
        for output in report["outputs"]:
            print(f"{_console.shown(output['path'])}: {verb}")


def _output_for(path: str, output: str | None, many: bool) -> Path | None:
    if output is None:
        return None
    target = Path(output)
    if target.suffix.lower() in SUFFIXES and not target.is_dir():
        if many:
            raise _ntp.ProgramError("several inputs need a directory after -o", _ntp.EXIT_USAGE)
        return target
    relative = Path(path)
    if relative.is_absolute() or ".." in relative.parts:
        relative = Path(relative.name)
    return target / relative


def _run_clean(args: argparse.Namespace, paths: Sequence[str]) -> int:
    reports: list[Json] = []
    wrong_use = False
    for path in paths:
        try:
            report = clean(
                path,
                _output_for(path, args.output, len(paths) > 1),
                type=args.type,
                method=args.method,
                drop_alpha=not args.keep_alpha,
                flip_green=args.flip_green,
                keep_jpeg=args.keep_jpeg,
                root=args.root,
                max_bytes=args.max_bytes,
                options=_console.check_options(args),
                dry_run=args.dry_run,
            )
        except (GltfError, OSError, *MALFORMED) as error:
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
    """3 where a file failed; 1 where an image was refused, or keeps a finding."""
    files = [file for report in reports for file in report["files"]]
    if any(file["status"] == "unreadable" for file in files):
        return _ntp.EXIT_FAILED
    if any(file["status"] == "refused" for file in files):
        return _ntp.EXIT_FINDINGS
    left = [{"status": "ok", "findings": file.get("remaining", [])} for file in files]
    return _ntp.exit_code(left, fail_on)


def _failed(path: str, message: str) -> Json:
    """The report of a file of which nothing was made."""
    entry = {**_ntp.path_fields(path), "status": "unreadable", "message": message}
    entry["written"] = False
    return {"files": [entry], "outputs": [], "summary": {"files": 1, "failed": 1}}


def _joined(reports: Sequence[Json]) -> Json:
    """One report of several."""
    names = ("files", "written", "unchanged", "skipped", "refused", "failed")
    summary = dict.fromkeys(names, 0)
    for report in reports:
        for key, count in report["summary"].items():
            summary[key] += count
    return {
        "schema_version": 1,
        "tool": _ntp.tool_fields(),
        "files": [file for report in reports for file in report["files"]],
        "outputs": [output for report in reports for output in report["outputs"]],
        "summary": summary,
    }


def _run(args: argparse.Namespace) -> int:
    paths = _console.gather(args, SUFFIXES)
    if not paths and _console.fails_empty(args, "no glTF file found"):
        return _ntp.EXIT_FAILED
    cleaning = args.output is not None or args.in_place
    if cleaning and args.format in ("sarif", "github"):
        raise _ntp.ProgramError("--format sarif and github are for checking", _ntp.EXIT_USAGE)
    if args.dry_run and not cleaning:
        raise _ntp.ProgramError("--dry-run goes with -o or --in-place", _ntp.EXIT_USAGE)
    if cleaning:
        return _run_clean(args, paths)
    report = check(
        list(paths),
        type=args.type,
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
    """Runs ``ntp gltf``; returns its exit code."""
    return _console.run(_parser(), _run, argv)


if __name__ == "__main__":
    sys.exit(main())
