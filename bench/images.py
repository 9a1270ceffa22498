# SPDX-License-Identifier: MIT
"""Makes the textures that the benchmarks read: images.py DIRECTORY [--huge]

Fractal rock and a brick wall, as unit normals whose channels were rounded independently: realistic
enough for PNG filters and for the cleaner, and the same on every machine.
"""

import struct
import sys
import zlib
from pathlib import Path

import numpy as np
from PIL import Image

SIDE = 4096
HUGE = 32768


def rock(side, seed, slope):
    """A tiling height, in texels, with amplitudes of 1/f^2.2 and this standard deviation of slope."""
    rng = np.random.default_rng(seed)
    fx = np.fft.rfftfreq(side, 1 / side)[None, :]
    fy = np.fft.fftfreq(side, 1 / side)[:, None]
    amplitude = 1 / np.maximum(fx * fx + fy * fy, 1) ** 1.1
    spectrum = amplitude * np.exp(2j * np.pi * rng.random((side, side // 2 + 1)))
    height = np.fft.irfft2(spectrum, (side, side))
    return height * (slope / (np.roll(height, 1, 1) - height).std())


def bricks(side, seed):
    """Rows of bricks with rounded edges, with rock added."""
    v, u = np.mgrid[0:side, 0:side] / side
    row = np.floor(v * 16)
    u = (u * 8 + 0.5 * (row % 2)) % 1
    v = v * 16 - row
    edge = np.minimum(np.minimum(u, 1 - u) * 2, np.minimum(v, 1 - v))
    t = np.clip((edge - 0.04) / 0.08, 0, 1)
    return 12 * t * t * (3 - 2 * t) + rock(side, seed, 0.15)


def normals(height, top):
    """Central differences, wrapped; each channel rounded to 0..top independently."""
    x = (np.roll(height, 1, 1) - np.roll(height, -1, 1)) / 2
    y = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / 2
    length = np.sqrt(x * x + y * y + 1)
    image = np.stack([x / length, y / length, 1 / length], -1)
    return np.floor((image + 1) / 2 * top + 0.5).astype(np.uint8 if top == 255 else np.uint16)


class PngWriter:
    """Writes rows of any sample size one after another: filter Sub, runs only."""

    def __init__(self, file, width, height, depth):
        self.file = file
        self.pixel = 3 * depth // 8
        self.deflate = zlib.compressobj(1, zlib.DEFLATED, 15, 9, zlib.Z_RLE)
        self.file.write(b"\x89PNG\r\n\x1a\n")
        self.chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, 2, 0, 0, 0))

    def chunk(self, name, data):
        crc = struct.pack(">I", zlib.crc32(name + data))
        self.file.write(struct.pack(">I", len(data)) + name + data + crc)

    def rows(self, samples):
        raw = samples.astype(samples.dtype.newbyteorder(">")).view(np.uint8)
        raw = raw.reshape(samples.shape[0], -1)
        out = np.empty((raw.shape[0], raw.shape[1] + 1), np.uint8)
        out[:, 0] = 1
        out[:, 1 : 1 + self.pixel] = raw[:, : self.pixel]
        np.subtract(raw[:, self.pixel :], raw[:, : -self.pixel], out=out[:, 1 + self.pixel :])
        data = self.deflate.compress(out.tobytes())
        if data:
            self.chunk(b"IDAT", data)

    def close(self):
        self.chunk(b"IDAT", self.deflate.flush())
        self.chunk(b"IEND", b"")


def write(path, samples, repeat=1):
    """repeat: how many times the image is repeated in each direction."""
    height, width, _ = samples.shape
    with path.open("wb") as file:
        writer = PngWriter(file, width * repeat, height * repeat, 8 * samples.itemsize)
        for _ in range(repeat):
            for y in range(0, height, 64):
                writer.rows(np.tile(samples[y : y + 64], (1, repeat, 1)))
        writer.close()


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    height = rock(SIDE, 1, 0.45)
    image = normals(height, 255)
    # Like most textures: with libpng's own defaults, which Pillow uses.
    Image.fromarray(image).save(folder / "rock_n.png")
    write(folder / "rock16_n.png", normals(height, 65535))
    unit = (height - height.min()) / np.ptp(height)
    for depth, kind in ((8, np.uint8), (16, np.uint16)):
        levels = (unit * (2**depth - 1) + 0.5).astype(kind)
        Image.fromarray(levels).save(folder / f"height{depth}.png")
    del height, unit
    write(folder / "rock_sub_n.png", image)
    Image.fromarray(image[:256, :256]).save(folder / "small_n.png")
    (folder / "many").mkdir(exist_ok=True)
    for i in range(8):
        tile = image[512 * i : 512 * i + 1024, :1024] if i < 7 else image[:1024, 1024:2048]
        Image.fromarray(tile).save(folder / "many" / f"rock{i}_n.png")
    Image.fromarray(normals(bricks(SIDE, 2), 255)).save(folder / "bricks_n.png")
    if "--huge" in sys.argv:
        write(folder / "huge_n.png", image, HUGE // SIDE)


if __name__ == "__main__":
    main()
