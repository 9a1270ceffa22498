# SPDX-License-Identifier: MIT
"""headers.py ROOT CC...: each header compiles alone, without a warning.

The public one in C99, C11, C17, C++98 and C++17, twice in one file and with NTP_STATIC; the
internal ones in C11.
"""

import shutil
import subprocess
import sys
from pathlib import Path

WARNINGS = ["-Wall", "-Wextra", "-pedantic", "-Werror", "-Wshadow", "-Wconversion"]
WARNINGS += ["-Wundef", "-Wcast-qual"]
LANGUAGES = {"c": ["c99", "c11", "c17"], "c++": ["c++98", "c++17"]}
NEEDS = {
    "exr_channels.h": "OpenEXR",
    "exr_library.h": "OpenEXR",
}  # left out where that is not installed


def compiles(compiler, language, std, include, directories, defines=(), foreign=()):
    """True when a file that includes a header twice, and nothing else, compiles."""
    source = f'#include "{include}"\n#include "{include}"\nint ntp_nothing;\n'
    command = [*compiler, "-x", language, f"-std={std}", *WARNINGS, "-fsyntax-only"]
    command += [f"-I{d}" for d in directories] + [f"-D{d}" for d in defines]
    command += [word for d in foreign for word in ("-isystem", d)] + ["-"]
    done = subprocess.run(command, input=source, text=True, capture_output=True, check=False)
    if done.returncode != 0:
        print(" ".join(command), f"# {include}", done.stderr, sep="\n")
    return done.returncode == 0


def directories_of(package):
    """Where the headers of a package of pkg-config lie; None without it."""
    tool = shutil.which("pkg-config")
    if tool is None:
        return None
    command = [tool, "--cflags-only-I", package]
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    return done.stdout.replace("-I", "").split() if done.returncode == 0 else None


def main(root, *compiler):
    core = [root / "libntp" / "include", root / "libntp" / "src"]
    good = True
    for language, stds in LANGUAGES.items():
        cc = list(compiler)
        if language == "c++":
            name = cc[-1].replace("gcc", "g++").replace("clang", "clang++")
            cc[-1] = name if shutil.which(name) and name != cc[-1] else "c++"
            if shutil.which(cc[-1]) is None:
                print("no C++ compiler: the C++ half is left out")
                continue
        for std in stds:
            good &= compiles(cc, language, std, "libntp.h", core[:1])
            good &= compiles(cc, language, std, "libntp.h", core[:1], ["NTP_STATIC"])
    for folder, directories in (
        ("libntp/src", core),
        ("os", [root]),
        ("io", [*core, root, root / "io"]),
    ):
        for header in sorted((root / folder).rglob("*.h")):
            if header.name.endswith("_tmpl.h"):  # a part of a source, in its words and types
                continue
            if header.parent.name == "windows" and sys.platform != "win32":
                continue
            others = directories_of(NEEDS[header.name]) if header.name in NEEDS else []
            if others is None:
                continue
            name = header.relative_to(directories[-1]).as_posix()
            gnu = ["_GNU_SOURCE"]
            good &= compiles(list(compiler), "c", "c11", name, directories, gnu, others)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), *sys.argv[2:]))
