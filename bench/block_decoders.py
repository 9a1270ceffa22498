# SPDX-License-Identifier: MIT
"""Random blocks of each format, read by normaltexture and by other decoders: block_decoders.py [N]

N blocks (default 1,000,000) of BC1 to BC5 and BC7.  The others are imagecodecs and texture2ddecoder,
as far as they are installed.  They interpolate BC1 to BC5 in 8 bits, each in a way of its own, so
that they differ from exact values, and from each other, by a level; BC7 is defined in integers.
"""

import importlib
import sys
from pathlib import Path

import numpy as np

import normaltexture as nt

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from support.gpu_textures import NUMBERS, block_bytes, dds

SIDE = 500  # blocks a side of one picture
KINDS = ("BC1", "BC2", "BC3", "BC4", "BC5", "BC7")


def blocks_of(kind, rng):
    blocks = rng.integers(0, 256, (SIDE * SIDE, block_bytes(kind)), np.uint8)
    if kind == "BC7":  # the lowest bit that is set is the mode: all alike
        mode = np.arange(len(blocks)) % 8
        blocks[:, 0] = ((blocks[:, 0] | 1) << mode) & 255
    return blocks.tobytes()


def by_imagecodecs(module, kind, blocks):
    shape = (4 * SIDE, 4 * SIDE, {"BC4": 1, "BC5": 2}.get(kind, 4))
    shape = shape[:2] if shape[2] == 1 else shape
    return module.bcn_decode(blocks, int(kind[2]), shape=shape).reshape(4 * SIDE, 4 * SIDE, -1)


def by_texture2ddecoder(module, kind, blocks):
    if kind == "BC2":  # it has none
        return None
    decode = getattr(module, f"decode_{kind.lower()}")
    image = np.frombuffer(decode(blocks, 4 * SIDE, 4 * SIDE), np.uint8)
    return image.reshape(4 * SIDE, 4 * SIDE, 4)[..., [2, 1, 0, 3]]


PEERS = {"imagecodecs": by_imagecodecs, "texture2ddecoder": by_texture2ddecoder}


def read(kind, blocks):
    four, dxgi, _ = NUMBERS[kind]
    image = nt.read(dds(4 * SIDE, 4 * SIDE, blocks, four=four or b"", dxgi=0 if four else dxgi))
    return image.reshape(4 * SIDE, 4 * SIDE, -1).astype(np.float64)


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    rng = np.random.default_rng(20261123)
    modules = {}
    for name in PEERS:
        try:
            modules[name] = importlib.import_module(name)
        except ImportError:
            print(f"{name} is not installed")
    failed = False
    for kind in KINDS:
        worst, different = dict.fromkeys(modules, 0.0), dict.fromkeys(modules, 0)
        done = 0
        while done < count:
            blocks = blocks_of(kind, rng)
            ours = read(kind, blocks) / (257 if kind in ("BC4", "BC5") else 1)
            for name, module in modules.items():
                theirs = PEERS[name](module, kind, blocks)
                if theirs is None:
                    continue
                # texture2ddecoder gives colors of BC3 a mode of BC1 that BC3 has not.
                first = 3 if kind == "BC3" and name == "texture2ddecoder" else 0
                off = np.abs(ours[..., first:] - theirs[..., first : ours.shape[2]])
                worst[name] = max(worst[name], off.max())
                different[name] += int((off >= 1).sum())
            done += SIDE * SIDE
        for name in modules:
            if kind == "BC2" and name == "texture2ddecoder":
                continue
            print(
                f"{kind}, {done:,} blocks, {name}: at most {worst[name]:.3f} levels of 8 bit, "
                f"{different[name]:,} samples by a level or more"
            )
            failed |= worst[name] > (0 if kind == "BC7" else 1.5)
    sys.exit(failed)


if __name__ == "__main__":
    main()
