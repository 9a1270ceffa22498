# SPDX-License-Identifier: MIT
"""Fills the recipes for vcpkg, Conan, Homebrew and pre-commit: recipes.py ARCHIVE ADDRESS OUT

ARCHIVE is the archive of the sources that a release has, ADDRESS the repository's.  Version,
address and checksums are put into copies of the recipes, in the directory OUT: an archive cannot
hold its own checksum, so those beside this file have none.
"""

import hashlib
import re
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).parent
PLACEHOLDER = "https://example.com/libntp"
# The file of each recipe that names the archive's checksum, and how.
CHECKSUMS = {
    "vcpkg/portfile.cmake": ("sha512", "SHA512 {}"),
    "conan/conandata.yml": ("sha256", 'sha256: "{}"'),
    "homebrew/libntp.rb": ("sha256", 'sha256 "{}"'),
}
# The files that name a version.
VERSIONS = (
    "vcpkg/vcpkg.json",
    "conan/conandata.yml",
    "conan/conanfile.py",
    "homebrew/libntp.rb",
    "pre-commit/pyproject.toml",
)


def version_of(archive: Path) -> str:
    named = re.fullmatch(r"libntp-(\d+\.\d+\.\d+)\.tar\.gz", archive.name)
    if named is None:
        raise SystemExit(f"{archive}: the archive of a release is libntp-VERSION.tar.gz")
    return named[1]


def replaced(text: str, old: str, new: str, name: str) -> str:
    if old not in text:
        raise SystemExit(f"{name}: has no {old}")
    return text.replace(old, new)


def copies(out: Path) -> list[Path]:
    made = []
    for recipe in ("vcpkg", "conan", "homebrew", "pre-commit"):
        shutil.copytree(HERE / recipe, out / recipe, dirs_exist_ok=True)
        made += [path for path in (out / recipe).rglob("*") if path.is_file()]
    return made


def fill(archive: Path, address: str, out: Path) -> None:
    data = archive.read_bytes()
    version = version_of(archive)
    for path in copies(out):
        text = path.read_text(encoding="utf-8")
        name = path.relative_to(out).as_posix()
        if name in CHECKSUMS:
            kind, line = CHECKSUMS[name]
            checksum = hashlib.new(kind, data).hexdigest()
            text = replaced(text, line.format("0"), line.format(checksum), name)
        if name in VERSIONS:
            text = replaced(text, "0.0.0", version, name)
        path.write_text(text.replace(PLACEHOLDER, address), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        raise SystemExit(__doc__)
    fill(Path(sys.argv[1]), sys.argv[2].rstrip("/"), Path(sys.argv[3]))
