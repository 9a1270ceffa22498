# SPDX-License-Identifier: MIT
"""What the programs of the package share: options, paths, messages and exit codes as of ntp."""

import argparse
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from fnmatch import fnmatch
from io import TextIOWrapper
from typing import Any, NoReturn

from . import _ntp
from ._named import MAX_BYTES

# Marks that turn the direction of text: with them one name can look like another.
_REORDERING = "\u200e\u200f\u2028\u2029\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"


class _Parser(argparse.ArgumentParser):
    """Errors in the voice of ntp: one line, exit code 2."""

    def error(self, message: str) -> NoReturn:
        print(f"ntp: {message}; {self.prog} --help tells more", file=sys.stderr)
        raise SystemExit(_ntp.EXIT_USAGE)


def parser(prog: str, description: str, epilog: str) -> argparse.ArgumentParser:
    return _Parser(
        prog=prog,
        description=description,
        epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )


def add_paths(to: argparse.ArgumentParser, what: str, empty: str) -> None:
    to.add_argument("paths", nargs="*", metavar="PATH", help=what)
    group = to.add_argument_group("files")
    group.add_argument("-r", "--recursive", action="store_true", help="descend into directories")
    group.add_argument(
        "--match",
        action="append",
        default=[],
        metavar="GLOB",
        help="of directories take only files whose name matches; may be repeated",
    )
    group.add_argument(
        "--exclude",
        action="append",
        default=[],
        metavar="GLOB",
        help="leave out files that match; may be repeated",
    )
    group.add_argument(
        "--files-from",
        metavar="FILE",
        help="read paths from FILE, one on each line; - is standard input",
    )
    group.add_argument("--allow-empty", action="store_true", help=empty)


def add_named(to: argparse.ArgumentParser, who: str, default: str) -> None:
    """The options about files that were named inside other files."""
    group = to.add_argument_group("files that are named in files")
    group.add_argument(
        "--root",
        metavar="DIR",
        help=f"the folder in which the files have to lie that {who} (default: the folder {default})",
    )
    group.add_argument(
        "--max-bytes",
        type=_count,
        default=MAX_BYTES,
        metavar="N",
        help=f"refuse to read more than N bytes for one file (default: {MAX_BYTES})",
    )


def _count(word: str) -> int:
    number = int(word)
    if number < 1:
        raise ValueError
    return number


_count.__name__ = "count"  # as argparse calls it in its message


def add_check_options(to: Any) -> None:
    """The options of `ntp check` that are handed on to it."""
    to.add_argument(
        "--verdict",
        choices=["neighbor", "rounded", "exact"],
        default="neighbor",
        help="which test of a texel counts (default: neighbor)",
    )
    to.add_argument(
        "--max-fail",
        type=float,
        default=2,
        metavar="PERCENT",
        help="more wrong texels than this are an error (default: 2)",
    )
    to.add_argument(
        "--policy",
        choices=["harm", "strict"],
        default="harm",
        help="what makes a texel wrong; harm: the angle that a renderer shows; strict: that it "
        "fails --verdict (default: harm)",
    )
    to.add_argument(
        "--max-angle",
        type=float,
        default=5,
        metavar="DEG",
        help="with harm, a normal that is off by more than this is wrong (default: 5)",
    )
    to.add_argument(
        "--max-tilt",
        type=float,
        default=0.1,
        metavar="X",
        help="warn where the mean of x or y is farther from 0 (default: 0.1)",
    )
    to.add_argument(
        "--keep-negative-z", action="store_true", help="normals may point away from the viewer"
    )
    to.add_argument(
        "--fail-on",
        choices=["error", "warning", "never"],
        default="error",
        help="the level of findings from which on the exit code is 1 (default: error)",
    )


def check_options(args: argparse.Namespace) -> tuple[str, ...]:
    """The same as words for ntp."""
    words = ["--verdict", args.verdict, "--fail-on", args.fail_on]
    words += ["--max-fail", repr(args.max_fail), "--max-tilt", repr(args.max_tilt)]
    words += ["--policy", args.policy, "--max-angle", repr(args.max_angle)]
    if args.keep_negative_z:
        words.append("--keep-negative-z")
    return tuple(words)


def add_loudness(to: argparse.ArgumentParser) -> None:
    to.add_argument("-q", "--quiet", action="store_true", help="print only what went wrong")
    to.add_argument("-v", "--verbose", action="store_true", help="say more about each file")


def shown(name: str) -> str:
    """A name for people: control characters and stray bytes are escaped, as ntp does it."""
    out = []
    for char in name:
        code = ord(char)
        if 0xDC80 <= code <= 0xDCFF:
            out.append(f"\\x{code - 0xDC00:02x}")
        elif char == "\n":
            out.append("\\n")
        elif code < 0x20 or code == 0x7F or 0x80 <= code < 0xA0:
            out.append(f"\\x{code:02x}")
        elif char in _REORDERING:
            out.append(f"\\u{code:04x}")
        else:
            out.append(char)
    return "".join(out)


def listed_paths(args: argparse.Namespace) -> list[str]:
    """The paths that were named, on the command line and in --files-from."""
    paths = list(args.paths)
    if args.files_from == "-":
        data = sys.stdin.buffer.read()
        paths += [os.fsdecode(line) for line in data.splitlines() if line]
    elif args.files_from is not None:
        with open(args.files_from, "rb") as file:
            paths += [os.fsdecode(line) for line in file.read().splitlines() if line]
    if not paths:
        raise _ntp.ProgramError("at least one PATH is needed", _ntp.EXIT_USAGE)
    if "" in paths:
        raise _ntp.ProgramError("a PATH is empty", _ntp.EXIT_USAGE)
    return paths


def _walk(folder: str, recursive: bool) -> Iterator[str]:
    for entry in sorted(os.scandir(folder), key=lambda entry: os.fsencode(entry.name)):
        path = os.path.normpath(entry.path) if folder == "." else entry.path
        if entry.is_dir(follow_symlinks=False) and recursive and not entry.name.startswith("."):
            yield from _walk(path, recursive)
        elif entry.is_file():
            yield path


def gather(args: argparse.Namespace, suffixes: tuple[str, ...]) -> list[str]:
    """The files to work on: those named, and those with a suffix in directories."""

    def wanted(path: str) -> bool:
        name = os.path.basename(path)
        fits = any(fnmatch(path if "/" in glob else name, glob) for glob in args.match)
        return path.lower().endswith(suffixes) and (fits or not args.match)

    def left_out(path: str) -> bool:
        name = os.path.basename(path)
        return any(fnmatch(path if "/" in glob else name, glob) for glob in args.exclude)

    paths = []
    for path in listed_paths(args):
        if os.path.isdir(path):
            paths += [p for p in _walk(path, args.recursive) if wanted(p) and not left_out(p)]
        elif not left_out(path):
            paths.append(path)
    return paths


def fails_empty(args: argparse.Namespace, message: str | None) -> bool:
    """Whether nothing was there to work on and that is a failure; it is said."""
    if message is None or args.allow_empty:
        return False
    below = not args.recursive and any(os.path.isdir(path) for path in args.paths)
    hint = "; -r looks below the directory as well" if below and "found" in message else ""
    print(f"ntp: {message}{hint}", file=sys.stderr)
    return True


def run(
    options: argparse.ArgumentParser,
    work: Callable[[argparse.Namespace], int],
    argv: Sequence[str] | None,
) -> int:
    """Parses, works, and turns what goes wrong into a message and an exit code."""
    try:
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")
        code = work(options.parse_args(argv))
        sys.stdout.flush()
        return code
    except SystemExit as error:
        return error.code if isinstance(error.code, int) else _ntp.EXIT_USAGE
    except _ntp.ProgramError as error:
        print(str(error) if str(error).startswith("ntp: ") else f"ntp: {error}", file=sys.stderr)
        return error.code
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 128 + signal.SIGPIPE
    except OSError as error:
        name = f"{shown(str(error.filename))}: " if error.filename else ""
        print(f"ntp: {name}{error.strerror or error}", file=sys.stderr)
        return _ntp.EXIT_FAILED
    except MemoryError:
        print("ntp: not enough memory", file=sys.stderr)
        return _ntp.EXIT_FAILED
    except KeyboardInterrupt:
        return _ntp.EXIT_INTERRUPTED
