# SPDX-License-Identifier: MIT
"""Fills a directory with the images that bench/real_images.csv lists.

fetch_real.py DIRECTORY [--clones DIRECTORY] [--from URL] takes each image from a clone, bare or
not, and keeps it only if its SHA-256 is the listed one.  A clone of OWNER/NAME is looked for as
OWNER+NAME or OWNER/NAME below --clones.  With --from, what is not there is cloned from
URL/OWNER/NAME, for example https://github.com; else it is only named.  The images belong to their
projects, so they are not part of this repository.
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


def cloned(url, clones, repo):
    """A new bare clone of URL/OWNER/NAME, or None."""
    target = clones / repo.replace("/", "+")
    target.parent.mkdir(parents=True, exist_ok=True)
    words = ["git", "clone", "--quiet", "--bare", f"{url.rstrip('/')}/{repo}", str(target)]
    return target if subprocess.run(words, check=False).returncode == 0 else None


def listed(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def whole(path, row):
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == row["sha256"]


def bring(row, target, clone):
    """Writes one image; why that was not possible, or None."""
    if clone is None:
        return f"no clone of {row['repo']}"
    try:
        data = read(clone, row["commit"], row["repo_path"])
    except subprocess.CalledProcessError:
        return f"commit {row['commit'][:12]} of the clone does not have it"
    except (ValueError, KeyError, IndexError):
        return "its GLB file does not have it"
    if hashlib.sha256(data).hexdigest() != row["sha256"]:
        return "another checksum"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(data)
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("directory", type=Path)
    parser.add_argument("--clones", type=Path, help="default: .clones in the directory")
    parser.add_argument("--from", dest="url", help="clones what is missing from URL/OWNER/NAME")
    parser.add_argument("--list", type=Path, default=LIST, help="default: %(default)s")
    arguments = parser.parse_args()
    clones = arguments.clones or arguments.directory / ".clones"
    rows, missing, known = listed(arguments.list), 0, {}
    for row in rows:
        target, repo = arguments.directory / row["path"], row["repo"]
        if whole(target, row):
            continue
        if repo not in known:
            known[repo] = clone_of(clones, repo)
            if known[repo] is None and arguments.url:
                known[repo] = cloned(arguments.url, clones, repo)
        why = bring(row, target, known[repo])
        if why:
            missing += 1
            print(f"{row['path']}: {why}", file=sys.stderr)
    print(f"{len(rows) - missing} of {len(rows)} images are there")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
