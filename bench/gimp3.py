# SPDX-License-Identifier: MIT
"""Times our filter and our plug-in in GIMP 3: `./dev gimp3 --bench [SIDE]`.

They are compared with GIMP's own filter at the same settings, and with a plug-in that only copies
the layer; all work on one RGB layer, in turns, in one GIMP.  Then each runs alone, for the memory
that GIMP needs.  Results are compared with `ntp from-height`: no texel may differ.

The plug-in is timed twice: as it is normally called, when it runs the operation on the layer, and
when it reads and writes all texels itself.
"""

import json
import os
import resource
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from support.gimps import Gimp3

GOAL = 1.3  # of the filter: times GIMP's own
PLUGIN_GOAL = 1  # of the plug-in: times the filter and a round trip of all texels
LABELS = {
    "gimp": "gegl:normal-map",
    "filter": "ntp:normals-from-height",
    "plug-in": "plug-in-ntp-normals-from-height",
    "alone": "the same, red and blue swapped",
    "start": "the same on 16 x 16 texels",
    "copy": "a copy by a running plug-in",
}


def heights(side):
    """Waves with a little noise, the same in red, green and blue."""
    rng = np.random.default_rng(1)
    y, x = np.mgrid[:side, :side].astype(np.float32)
    unit = np.sin(x / 31) * np.cos(y / 23) * 0.4 + 0.5
    unit += rng.normal(0, 0.01, (side, side)).astype(np.float32)
    gray = (unit.clip(0, 1) * 255 + 0.5).astype(np.uint8)
    return np.repeat(gray[:, :, None], 3, axis=2)


def run(gimp, names, rounds):
    """Seconds of each turn, by name."""
    gimp.script(ROOT / "bench" / "in_gimp3.py", NTP_TURNS=" ".join(names), NTP_ROUNDS=str(rounds))
    return json.loads((gimp.work / "times.json").read_text())


def memory(gimp, name):
    """The peak memory of GIMP, in MB, in a separate process: the maximum of all children so far."""
    child = os.fork()
    if child == 0:
        run(gimp, [name] if name else [], 1)
        most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
        (gimp.work / "memory").write_text(str(most))
        os._exit(0)
    os.waitpid(child, 0)
    return int((gimp.work / "memory").read_text()) // 1024


def different(gimp, name, side, expected):
    result = np.fromfile(gimp.work / f"result-{name}", np.uint8).reshape(side, side, 3)
    if name == "alone":
        result = result[:, :, ::-1]
    return sum(int((a != b).any(1).sum()) for a, b in zip(result, expected, strict=True))


def main():
    side = int(sys.argv[1]) if len(sys.argv) > 1 else 4096
    gimp = Gimp3(os.environ["NTP_GIMP3"], "bench")
    source, made = gimp.work / "heights.png", gimp.work / "ntp.png"
    Image.fromarray(heights(side)).save(source, compress_level=1)
    rounds = 6 if side <= 4096 else 3
    # The first turn fills caches.
    times = {name: all_[1:] for name, all_ in run(gimp, LABELS, rounds).items()}
    program = next(Path(os.environ["NTP_BUILD"]).rglob("cli/ntp"))
    options = ["--scale", "10", "--border", "clamp", "--to-y", "down"]
    subprocess.run([program, "from-height", "-q", *options, source, "-o", made], check=True)
    Image.MAX_IMAGE_PIXELS = None
    expected = np.asarray(Image.open(made))
    off = {name: different(gimp, name, side, expected) for name in ("filter", "plug-in", "alone")}

    print(f"{side} x {side} RGB, 8 bit, merged in GIMP 3; GIMP with the open image: ", end="")
    print(f"{memory(gimp, None)} MB")
    for name, label in LABELS.items():
        differ = f"{off[name]} texels differ from ntp" if name in off else ""
        ms = statistics.median(times[name]) * 1000
        print(f"  {label:32} {ms:7.0f} ms {memory(gimp, name):7} MB  {differ}")
    pairs = zip(times["filter"], times["gimp"], strict=True)
    print(f"  filter / GIMP's own: {statistics.median(a / b for a, b in pairs):.2f}, goal {GOAL}")
    for name, words in (("plug-in", ""), ("alone", ", red and blue swapped")):
        turns = [times[turn] for turn in (name, "start", "filter", "copy")]
        ratio = [(p / (f + c), (p - s) / (f + c)) for p, s, f, c in zip(*turns, strict=True)]
        whole, work = (statistics.median(r) for r in zip(*ratio, strict=True))
        print(f"  plug-in{words} / (filter + copy): {whole:.2f}, ", end="")
        print(f"without its start {work:.2f}, goal {PLUGIN_GOAL}")
    return any(off.values())


if __name__ == "__main__":
    sys.exit(main())
