# SPDX-License-Identifier: MIT
"""Fills a directory with the images that bench/real_images.csv lists.

fetch_real.py DIRECTORY [--clones DIRECTORY] takes each image from a local clone, bare or not, and
keeps it only if its SHA-256 is the listed one.  A clone of github.com/OWNER/NAME is looked for as
OWNER+NAME or OWNER/NAME below --clones.  Without --clones, what is missing is only named.  The
images belong to their projects, so they are not part of this repository.
"""

import argparse
import csv
import hashlib
import json
import struct
import subprocess
import sys
from pathlib import Path

LIST = Path(__file__).resolve().parent / "real_images.csv"
GLB, JSON_CHUNK, BIN_CHUNK = b"glTF", 0x4E4F534A, 0x004E4942


def glb_parts(data):
    """The JSON and the binary chunk of a GLB file."""
    if data[:4] != GLB:
        raise ValueError("not a GLB file")
    parts, at = {}, 12
    while at + 8 <= len(data):
        size, kind = struct.unpack_from("<II", data, at)
        parts[kind] = data[at + 8 : at + 8 + size]
        at += 8 + size
    return json.loads(parts[JSON_CHUNK]), parts.get(BIN_CHUNK, b"")


def image_in_glb(data, number):
    gltf, binary = glb_parts(data)
    view = gltf["bufferViews"][gltf["images"][number]["bufferView"]]
    start = view.get("byteOffset", 0)
    return binary[start : start + view["byteLength"]]


def git(clone, *words):
    return subprocess.run(["git", "-C", str(clone), *words], check=True, capture_output=True).stdout


def read(clone, commit, path):
    """A file of a commit; PATH#imageN is the image N inside a GLB file."""
    name, _, image = path.partition("#image")
    data = git(clone, "show", f"{commit}:{name}")
    return image_in_glb(data, int(image)) if image else data


def clone_of(clones, repo):
    owner, name = repo.split("/")
    for place in (f"{owner}+{name}", f"{owner}/{name}", f"{owner}/{name}.git"):
        for git_dir in (clones / place / "repo", clones / place):
            if (git_dir / "HEAD").exists() or (git_dir / ".git").exists():
                return git_dir
    return None


def listed():
    with LIST.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def whole(path, row):
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == row["sha256"]


def bring(row, target, clones):
    """Writes one image; why that was not possible, or None."""
    clone = clone_of(clones, row["repo"]) if clones else None
    if clone is None:
        return f"no clone of https://github.com/{row['repo']}"
    try:
        data = read(clone, row["commit"], row["repo_path"])
    except (subprocess.CalledProcessError, ValueError, KeyError, IndexError):
        return "not in the clone"
    if hashlib.sha256(data).hexdigest() != row["sha256"]:
        return "another checksum"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(data)
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directory", type=Path)
    parser.add_argument("--clones", type=Path)
    arguments = parser.parse_args()
    rows, missing = listed(), 0
    for row in rows:
        target = arguments.directory / row["path"]
        if whole(target, row):
            continue
        why = bring(row, target, arguments.clones)
        if why:
            missing += 1
            print(f"{row['path']}: {why}", file=sys.stderr)
    print(f"{len(rows) - missing} of {len(rows)} images are there")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
