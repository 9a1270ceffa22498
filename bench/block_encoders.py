# SPDX-License-Identifier: MIT
"""What BC5 costs, by encoder: block_encoders.py [--exhaustive N | --joint N]

Degrees to the source, for the middles of sixteen textures (those of the corpus if it is there) and
for gentle slopes of 16 bit; and the time on one thread, all in one run.  Every file is decoded
exactly, as GPUs do, whatever its encoder supposed.  Others are taken as far as they are installed:
etcpak, quicktex and Pillow; rgbcx from NTP_RGBCX, a shared library made of rgbcx.cpp of bc7enc_rdo.

--exhaustive N: N blocks of one channel against all pairs of ends instead.  --joint N: N blocks of these
textures against the best that both channels can be together.  NTP_BUILD is the build.
"""

import ctypes
import importlib
import io
import os
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

from images import bricks, normals, rock

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

import joint_blocks
from support import exact_blocks
from support import libntp_ffi as ntp
from test_block_encoder import encode, errors, kinds_of_blocks, picture_of

SIDE = 256
CORPUS = Path(os.environ.get("NTP_CORPUS", ROOT.parent / "shared" / "corpus"))
OF_CORPUS = (
    "bgfx/fieldstone-n.tga",
    "glTF-Sample-Assets-OLD/BoomBox_normal.png",
    "glTF-Sample-Assets-OLD/Normal Map.png",
    "glTF-Sample-Assets-OLD/StainedGlassLamp_hardware_normal.png",
    "glTF-Sample-Assets-OLD/ToyCar_normal.png",
    "glTF-Sample-Assets-OLD/chair_fabric_normal.png",
    "glTF-Sample-Assets-OLD/IridescenceAbalone_NormalBump.png",
    "glTF-Sample-Assets-OLD/olives_nrm.png",
    "astc-encoder/ldr-xy-normal1.png",
    "WebGLSamples.github.io/FloorTile_01_NM.tga",
    "godot-demo-projects/scifi_1_normal.png",
)
MADE = {
    "rock, steep": (lambda: rock(SIDE, 1, 0.6), 255),
    "rock": (lambda: rock(SIDE, 2, 0.25), 255),
    "rock, gentle": (lambda: rock(SIDE, 3, 0.08), 255),
    "rock, soft": (lambda: rock(SIDE, 4, 0.15), 255),
    "bricks": (lambda: bricks(SIDE, 5) / 8, 255),
}
MOST_OF_JOINT = 0.3  # a mean of about a degree; rougher blocks have too many good pairs
GENTLE = [(slope, seed) for slope in (0.01, 0.02, 0.04) for seed in (1, 2)]


def middle(image):
    y, x = (max(s - SIDE, 0) // 2 // 4 * 4 for s in image.shape[:2])
    return np.ascontiguousarray(image[y : y + SIDE, x : x + SIDE, :3])


def textures():
    """(name, image) of eight bits."""
    for name in OF_CORPUS:
        if (CORPUS / name).is_file():
            yield name, middle(np.asarray(Image.open(CORPUS / name).convert("RGB")))
    for name, (height, top) in MADE.items():
        yield name, normals(height(), top)


# --------------------------------------------------------------------------- encoders


def ours(quality):
    return lambda image: encode(image, 2, quality, encoding=ntp.STANDARD)


def as_blocks(data, image):
    height, width = (-(-s // 4) for s in image.shape[:2])
    return np.frombuffer(data, np.uint8)[-16 * height * width :].reshape(height, width, 16)


def rgba(image):
    return np.ascontiguousarray(np.pad(image, ((0, 0), (0, 0), (0, 1)), constant_values=255))


def by_etcpak(module):
    def run(image):
        data = rgba(image).tobytes()
        return as_blocks(module.compress_bc5(data, image.shape[1], image.shape[0]), image)

    return run


def by_quicktex(module):
    bc5 = importlib.import_module("quicktex.s3tc.bc5")
    encoder = bc5.BC5Encoder()

    def run(image):
        raw = module.RawTexture.frombytes(rgba(image).tobytes(), image.shape[1], image.shape[0])
        return as_blocks(encoder.encode(raw).tobytes(), image)

    return run


def by_pillow(module):
    def run(image):
        file = io.BytesIO()
        module.fromarray(image).save(file, "DDS", pixel_format="BC5")
        return as_blocks(file.getvalue(), image)

    return run


def by_rgbcx(path):
    library = ctypes.CDLL(path)
    library._ZN5rgbcx4initENS_15bc1_approx_modeE(0)
    encode_block = library._ZN5rgbcx13encode_bc5_hqEPvPKhjjjjj
    encode_block.argtypes = [ctypes.c_void_p, ctypes.c_void_p, *[ctypes.c_uint32] * 5]

    def run(image):
        blocks = np.stack([exact_blocks.blocks_of(c) for c in np.moveaxis(rgba(image), 2, 0)], -1)
        blocks = np.ascontiguousarray(blocks)
        out = np.zeros((*blocks.shape[:2], 16), np.uint8)
        source, target = blocks.ctypes.data, out.ctypes.data
        begin = time.process_time()
        for i in range(blocks.shape[0] * blocks.shape[1]):
            encode_block(target + 16 * i, source + 64 * i, 0, 1, 4, 3, 3)
        run.took = time.process_time() - begin
        return out

    return run


def encoders():
    table = {}
    for name, module, make in (
        ("Pillow", "PIL.Image", by_pillow),
        ("etcpak", "etcpak", by_etcpak),
        ("quicktex", "quicktex", by_quicktex),
    ):
        try:
            table[name] = make(importlib.import_module(module))
        except ImportError:
            print(f"{name} is not installed")
    if os.environ.get("NTP_RGBCX"):
        table["rgbcx hq"] = by_rgbcx(os.environ["NTP_RGBCX"])
    qualities = {"quick": 2, "channel": 1, "angle": 0}
    return table | {f"ntp, {name}": ours(number) for name, number in qualities.items()}


# --------------------------------------------------------------------------- measuring


def measured(run, image):
    """(mean, p99, seconds)"""
    begin = time.process_time()
    blocks = run(image)
    took = getattr(run, "took", time.process_time() - begin)
    height, width = image.shape[:2]
    top = np.iinfo(image.dtype).max
    source = exact_blocks.unit(*(2.0 * image[..., c] / top - 1 for c in range(2)))
    angles = exact_blocks.degrees(source, exact_blocks.vectors(blocks, height, width))
    return angles.mean(), np.percentile(angles, 99), took


def geometric(values):
    return np.exp(np.mean(np.log(values)))


def exhaustive(count):
    rng = np.random.default_rng(count)
    worse = 0
    for first in range(0, count, 10_000):
        blocks = kinds_of_blocks(rng, min(10_000, count - first))
        image = picture_of(blocks)
        got = errors(image, encode(image))
        worse += sum(g != exact_blocks.least_error(b) for g, b in zip(got, blocks, strict=True))
        print(
            f"{first + len(blocks):,} blocks, {worse} with another error than the least", flush=True
        )


def blocks_to_compare(count):
    """(levels of x, levels of y, the 16 bytes by angle, by channel), of all textures alike."""
    rng = np.random.default_rng(count)
    images = [image for _, image in textures()]
    for number in range(count):
        image = images[number % len(images)]
        y, x = (4 * rng.integers(0, side // 4) for side in image.shape[:2])
        part = np.ascontiguousarray(image[y : y + 4, x : x + 4])
        if part.shape[:2] == (4, 4):
            yield *(part[..., c].ravel() for c in range(2)), ours(0)(part), ours(1)(part)


def distance_of(levels, coded):
    """The sum of distances of a coded block to its source."""
    source, got = (
        exact_blocks.unit(*(2.0 * v / exact_blocks.TOP - 1 for v in levels)),
        exact_blocks.vectors(coded, 4, 4).reshape(16, 3),
    )
    return np.linalg.norm(source - got, axis=-1).sum()


def joint(count):
    rows, left_out = [], 0
    for x, y, by_angle, by_channel in blocks_to_compare(count):
        angle, channel = (distance_of((x, y), coded) for coded in (by_angle, by_channel))
        rim = joint_blocks.from_rim(*(2.0 * v / exact_blocks.TOP - 1 for v in (x, y)))
        if angle >= min(rim, MOST_OF_JOINT):
            left_out += 1
            continue
        rows.append((joint_blocks.least_distance(x, y, angle), angle, channel))
        if len(rows) % 50 == 0:
            least, angle, channel = np.degrees(np.mean(rows, 0) / 16)
            print(
                f"{len(rows)} blocks, {left_out} too steep or too rough; mean degrees: the least "
                f"{least:.4f}, angle {angle:.4f}, channel {channel:.4f}",
                flush=True,
            )


def main():
    if sys.argv[1:2] == ["--exhaustive"]:
        return exhaustive(int(sys.argv[2]))
    if sys.argv[1:2] == ["--joint"]:
        return joint(int(sys.argv[2]))
    images = list(textures())
    texels = sum(i.shape[0] * i.shape[1] for _, i in images)
    print(f"BC5, {len(images)} textures of 8 bit, geometric means; degrees to the source")
    print(f"{'':14}{'mean':>8}{'p99':>8}{'us a block':>12}")
    for name, run in encoders().items():
        rows = [measured(run, image) for _, image in images]
        mean, p99 = (geometric([max(r[k], 1e-4) for r in rows]) for k in range(2))
        took = sum(r[2] for r in rows) * 16 / texels * 1e6
        print(f"{name:14}{mean:8.3f}{p99:8.3f}{took:12.2f}")
        if "-v" in sys.argv:
            print(
                *(f"    {r[0]:.3f} {r[1]:.3f} {n}" for r, (n, _) in zip(rows, images, strict=True)),
                sep="\n",
            )
    means = {"8-bit PNG": [], "ntp, angle": []}
    for slope, seed in GENTLE:
        image = normals(rock(SIDE, seed, slope), 65535)
        means["ntp, angle"].append(measured(ours(0), image)[0])
        eight = np.floor(image / 257 + 0.5)
        source, rounded = (
            exact_blocks.unit(*(2.0 * i[..., c] / top - 1 for c in range(2)))
            for i, top in ((image, 65535), (eight, 255))
        )
        means["8-bit PNG"].append(exact_blocks.degrees(source, rounded).mean())
    print("gentle slopes of 16 bit, mean:", *(f"{n} {geometric(m):.3f}" for n, m in means.items()))
    return None


if __name__ == "__main__":
    main()
