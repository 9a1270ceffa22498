# SPDX-License-Identifier: MIT
"""Looks into built artifacts: audit.py SDIST WHEEL...

An sdist holds what the build and its tests need.  A wheel holds the package and the program, and
nothing else; the extension module exports only its initializer; each library that is linked is a
grafted one or the C library.
"""

import fnmatch
import io
import sys
import tarfile
import zipfile
from pathlib import Path

from elftools.elf.elffile import ELFFile
from elftools.elf.sections import SymbolTableSection

IN_SDIST = (
    "LICENSE",
    "meson.build",
    "pyproject.toml",
    "libntp/include/libntp.h",
    "io/ntpio.h",
    "cli/main.c",
    "bindings/python/cdef.py",
    "bindings/python/normaltexture/py.typed",
    "bindings/python/tests/conftest.py",
    "tests/support/oracle.py",
)
IN_WHEEL = (
    "normaltexture/*.py",
    "normaltexture/*.pyi",
    "normaltexture/report/page.html.j2",
    "normaltexture/report/page.css",
    "normaltexture/report/page.js",
    "normaltexture/usd/plugInfo.json",
    "normaltexture/py.typed",
    "normaltexture/_native.abi3.so",
    "normaltexture/ntp",
    "ntp_program.py",
    "normaltexture-*.dist-info/*",
)
GRAFTED = ("normaltexture.libs/*.so*",)
# What the sdist leaves out, because nothing of it is built with the package.
NOT_IN_SDIST = ("gimp-plugin/*", "tests/gimp/*", "fuzz/*", "bench/*")
# What may be linked: the C library, and before the others are grafted those too.
C_LIBRARY = ("libc.so.6", "libm.so.6", "libpthread.so.0", "libz.so.1", "ld-linux*")
BEFORE_GRAFTING = (
    "libpng16.so*",
    "libdeflate.so*",
    "libjpeg.so*",
    "libzstd.so*",
    "libwebp.so*",
    "libOpenEXRCore*.so*",
    "libpopt.so*",
    "libjansson.so*",
)
MODULE_EXPORTS = {"PyInit__native"}

problems: list[str] = []


def elf(data: bytes) -> ELFFile:
    return ELFFile(io.BytesIO(data))


def needed(file: ELFFile) -> list[str]:
    dynamic = file.get_section_by_name(".dynamic")
    return [tag.needed for tag in dynamic.iter_tags() if tag.entry.d_tag == "DT_NEEDED"]


def exported(file: ELFFile) -> set[str]:
    table = file.get_section_by_name(".dynsym")
    assert isinstance(table, SymbolTableSection)
    return {
        symbol.name
        for symbol in table.iter_symbols()
        if symbol.entry.st_shndx != "SHN_UNDEF" and symbol.entry.st_info.bind != "STB_LOCAL"
    }


def is_one_of(name: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)


def sdist(path: Path) -> None:
    with tarfile.open(path) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    for name in IN_SDIST:
        if name not in names:
            problems.append(f"{path.name}: {name} is missing")
    for name in sorted(names):
        if is_one_of(name, NOT_IN_SDIST):
            problems.append(f"{path.name}: {name} does not belong there")
    print(f"{path.name}: {len(names)} files, {path.stat().st_size >> 10} KiB")


def module(path: Path, name: str, file: ELFFile, repaired: bool) -> None:
    extra = exported(file) - MODULE_EXPORTS
    if extra or not exported(file):
        problems.append(f"{path.name}: {name} exports {sorted(extra) or 'nothing'}")
    linked(path, name, file, repaired)


def linked(path: Path, name: str, file: ELFFile, repaired: bool) -> None:
    allowed = C_LIBRARY if repaired else C_LIBRARY + BEFORE_GRAFTING
    for library in needed(file):
        grafted = repaired and "-" in library.partition(".so")[0]  # libpng16-8a6b5ae1.so
        if not grafted and not is_one_of(library, allowed):
            problems.append(f"{path.name}: {name} needs {library}")


def wheel(path: Path) -> None:
    repaired = "manylinux" in path.name
    allowed = IN_WHEEL + GRAFTED if repaired else IN_WHEEL
    with zipfile.ZipFile(path) as archive:
        names = [name for name in archive.namelist() if not name.endswith("/")]
        for name in names:
            if not is_one_of(name, allowed):
                problems.append(f"{path.name}: {name} does not belong there")
            data = archive.read(name)
            if name.endswith("_native.abi3.so"):
                module(path, name, elf(data), repaired)
            elif data.startswith(b"\x7fELF"):
                linked(path, name, elf(data), repaired)
    for part in ("normaltexture/_native.abi3.so", "normaltexture/__init__.py", "normaltexture/ntp"):
        if not any(name.endswith(part) for name in names):
            problems.append(f"{path.name}: {part} is missing")
    if f"-cp3{sys.version_info.minor}-abi3-" not in path.name:
        problems.append(f"{path.name}: not tagged abi3 from this Python on")
    print(f"{path.name}: {len(names)} files, {path.stat().st_size >> 10} KiB")


def main() -> int:
    for name in sys.argv[1:]:
        (sdist if name.endswith(".tar.gz") else wheel)(Path(name))
    for problem in problems:
        print(f"audit: {problem}")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
