# SPDX-License-Identifier: MIT
"""Cleans every glTF file below some folders and checks the copies: `gltf_sweep.py DIR...`.

A copy has to be without errors, or `ntp gltf` has to say what is left.  With --validator DIR, a
folder in which `npm install gltf-validator` was run, Khronos' validator must find no error in a
copy that the original does not have.  Run it with the Python that has the package installed.
"""

import argparse
import collections
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from normaltexture import gltf

VALIDATE = """
const validator = require("gltf-validator"), fs = require("fs"), path = require("path");
(async () => {
  const told = {};
  for (const name of process.argv.slice(1)) {
    const options = {maxIssues: 0, externalResourceFunction: uri =>
      fs.promises.readFile(path.join(path.dirname(name), decodeURIComponent(uri)))};
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(name)), options)
      .catch(error => ({issues: {messages: [{severity: 0, code: String(error)}]}}));
    told[name] = report.issues.messages.filter(m => m.severity == 0).map(m => m.code);
  }
  console.log(JSON.stringify(told));
})();
"""


def validator_errors(paths, folder):
    """{path: {code: how many errors}}, of one process."""
    done = subprocess.run(
        ["node", "-e", VALIDATE, *map(str, paths)],
        capture_output=True,
        check=True,
        cwd=folder,
        text=True,
    )
    return {path: collections.Counter(codes) for path, codes in json.loads(done.stdout).items()}


def levels(findings):
    return sorted({f"{one['id']} {one['level']}" for one in findings if one["level"] != "info"})


def sweep(path, copy):
    """(what was found, what the copy has, what was said) of a file; None without normals."""
    before = gltf.check(path)["files"]
    if not any("image" in entry for entry in before):
        return None
    done = gltf.clean(path, copy)["files"]
    after = gltf.check(copy)["files"]
    return [
        (levels(old["findings"]), levels(new["findings"]), levels(said["remaining"]), said)
        for old, said, new in zip(before, done, after, strict=True)
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--validator", type=Path)
    args = parser.parse_args()
    paths = [path for folder in args.folders for path in sorted(folder.rglob("*.gl[bt]*"))]
    counts = collections.Counter()
    failed = 0
    for path in paths:
        if not path.is_file() or path.suffix.lower() not in (".gltf", ".glb"):
            continue
        with tempfile.TemporaryDirectory() as scratch:
            copy = Path(scratch) / path.name
            try:
                images = sweep(path, copy)
            except (gltf.GltfError, OSError) as error:
                counts["not written"] += 1
                print(error if str(path) in str(error) else f"{path}: {error}")
                continue
            if not images:
                counts["without normals textures"] += 1
                continue
            counts["files"] += 1
            for before, after, said, entry in images:
                counts["images"] += 1
                counts["images with findings"] += bool(before)
                counts["images clean in the copy"] += not after
                if before or after:
                    print(f"{path}, image {entry['image']}: {before} -> {after} {entry['status']}")
                if after != said:
                    failed += 1
                    print(f"  FAILED: not said: {said}")
            if args.validator:
                told = validator_errors([path.absolute(), copy], args.validator)
                new = told[str(copy)] - told[str(path.absolute())]
                counts["validated"] += 1
                if new:
                    failed += 1
                    print(f"  FAILED: new errors of the validator: {dict(new)}")
    print(", ".join(f"{number} {what}" for what, number in counts.items()), f"{failed} failed")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
