# SPDX-License-Identifier: MIT
"""Depth with cliffs beside least squares, on made scenes: bench_cliffs.py [--size N]

NTP_BUILD names the build.  Errors are means of |depth - true depth| in texels, after the best shift
(with a camera: scale), of each piece that is cut off all round by itself.  AUC: how well the
confidence finds the worst tenth of the errors after one shift of the whole.  Seconds are of one
processor, without the confidence.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from support import cliff_scenes as scenes
from support.depth import find_depth

VIEWS = (0, 30, 60, 90)


def row(scene):
    normals = np.where(scene.mask[..., None], scene.normals, 0).astype(np.float32)
    plain = find_depth(normals, camera=scene.camera, rounds=1, sure=False)[0]
    begin = time.process_time()
    depth, _, result = find_depth(normals, camera=scene.camera, sure=False)
    seconds = time.process_time() - begin
    confidence = find_depth(normals, camera=scene.camera)[1]
    errors = np.abs(scenes.aligned(depth, scene) - scene.depth)[scene.mask]
    return (
        scenes.error(plain, scene, scene.pieces),
        scenes.error(depth, scene, scene.pieces),
        scenes.ranks(confidence[scene.mask], errors),
        result["rounds"],
        seconds,
    )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--size", type=int, default=256)
    size = parser.parse_args().size
    print(f"{size} x {size}; view in degrees, 0: orthographic")
    print("| scene | view | least squares | cliffs | ratio | AUC | rounds | seconds |")
    print("|---|---|---|---|---|---|---|---|")
    ratios, ranks = [], []
    for degrees in VIEWS:
        for scene in scenes.all_scenes(size, degrees):
            plain, error, rank, rounds, seconds = row(scene)
            ratios.append(error / plain)
            ranks.append(rank)
            print(
                f"| {scene.name} | {degrees} | {plain:.2f} | {error:.2f} | {ratios[-1]:.2f} |"
                f" {rank:.2f} | {rounds} | {seconds:.2f} |",
                flush=True,
            )
    within = sum(ratio <= 1 / 3 for ratio in ratios)
    print(f"mean ratio {np.mean(ratios):.2f} (goal .33; {within} of {len(ratios)} within)")
    print(f"mean AUC {np.mean(ranks):.2f} (goal .8)")


if __name__ == "__main__":
    main()
