# SPDX-License-Identifier: MIT
"""generate.py [DIR]: writes the test files; README.md beside it says what each one shows.

The bytes do not depend on the machine or on the version of a library: see shapes.py, and
tests/support/pngs.py for the writers.  Two files are made by Pillow and therefore kept as they are:
jpeg.jpg and jpeg_progressive.jpg (`generate.py --jpeg` makes them anew).
"""

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests")]

import shapes
from support import gpu_textures, pngs

N = shapes.normals(shapes.height())
GENTLE = shapes.normals(shapes.height(), 2.0)
GOOD = shapes.derived(N)
FILES = {}


def file(name):
    """Registers a function that makes the file's bytes."""

    def register(make):
        FILES[name] = make
        return make

    return register


def u8(levels):
    return np.asarray(levels).astype(np.uint8)


def u16(levels):
    return np.asarray(levels).astype(np.uint16)


def png8(name, levels, **options):
    FILES[name] = lambda: pngs.png_bytes(u8(levels()), **options)


def png16(name, levels, **options):
    FILES[name] = lambda: pngs.png_bytes(u16(levels()), **options)


def to_levels(v, m):
    return np.clip(np.floor(v * m + 0.5), 0, m).astype(np.int64)


def alpha(levels, a):
    return np.dstack([levels, np.broadcast_to(a, levels.shape[:2])])


def scattered(percent, seed=5):
    """A mask of about this share of the texels."""
    return shapes.noise(*GOOD.shape[:2], seed, 10_000) < percent * 100


# ------------------------------------------------------------------------------ heights

png8("height_gray8.png", lambda: to_levels(shapes.height(), 255))
png16("height_gray16.png", lambda: to_levels(shapes.height(), 65535))
png8("height_rgb.png", lambda: np.dstack([to_levels(shapes.height(), 255)] * 3))
png8("height_gray4.png", lambda: to_levels(shapes.height(), 15), depth=4)

# ------------------------------------------------------------- standard, in good order

png8("standard.png", lambda: GOOD)
png8("standard_rounded.png", lambda: shapes.encode(N))
png8("standard_truncated.png", lambda: np.floor((N + 1) / 2 * 255).astype(np.int64))
png8("standard_gentle.png", lambda: shapes.derived(GENTLE))
png8("standard_interlaced.png", lambda: GOOD, interlaced=True)
png16("standard_16.png", lambda: shapes.derived(N, 65535))
png16("standard_16_rounded.png", lambda: shapes.encode(N, 65535))
png16("standard_16_of_8.png", lambda: GOOD * 257)


@file("standard_text.png")
def _():
    text = [(b"tEXt", b"Title\0Hills and a stud"), (b"pHYs", bytes([0, 0, 11, 19] * 2 + [1]))]
    text += [(b"gAMA", (45455).to_bytes(4, "big")), (b"sRGB", b"\0")]
    return pngs.png_bytes(u8(GOOD), chunks=text)


@file("standard_palette.png")
def _():
    heights = np.floor(shapes.height() * 40) / 40
    levels = shapes.derived(shapes.normals(heights, 6.0))
    steps = np.array([24, 56, 88, 112, 128, 144, 168, 200, 232])
    nearest = np.abs(levels[..., :2, None] - steps).argmin(-1)
    rg = np.stack(np.meshgrid(steps, steps, indexing="ij"), -1).reshape(-1, 2)
    v = np.concatenate([(2 * rg - 255) / 255, np.zeros((len(rg), 1))], 1)
    long = v[:, 0] ** 2 + v[:, 1] ** 2 > 0.98
    v[long, :2] /= 2
    palette = shapes.derived(v[None])[0]
    return pngs.png_bytes(u8(nearest[..., 0] * 9 + nearest[..., 1]), palette=palette)


png8("standard_down.png", lambda: shapes.derived(N * [1, -1, 1]))
png8("standard_alpha.png", lambda: alpha(GOOD, 255))


@file("standard_unused.png")
def _():
    y, x = np.mgrid[0 : GOOD.shape[0], 0 : GOOD.shape[1]]
    inside = (x - 48) ** 2 + (y - 32) ** 2 < 30**2
    levels = np.where(inside[..., None], GOOD, shapes.noise(*GOOD.shape[:2], 8)[..., None])
    return pngs.png_bytes(u8(alpha(levels, inside * 255)))


@file("padded_black.png")
def _():
    levels = GOOD.copy()
    levels[:, :3] = 0
    return pngs.png_bytes(u8(levels))


@file("padded_white.png")
def _():
    levels = GOOD.copy()
    levels[:2] = 255
    return pngs.png_bytes(u8(levels))


# ------------------------------------------------------------------- other encodings

png8("zzero.png", lambda: shapes.derived(N, zzero=True))
png16("zzero_16.png", lambda: shapes.derived(N, 65535, zzero=True))


@file("labpbr.png")
def _():
    h = shapes.height()
    occlusion = to_levels(0.55 + 0.45 * np.minimum(h * 1.6, 1), 255)
    levels = np.dstack([GOOD[..., :2], occlusion, to_levels(h * 0.9 + 0.1, 255)])
    return pngs.png_bytes(u8(levels))


def with_blue(value):
    levels = GOOD.copy()
    levels[..., 2] = value
    return levels


png8("blue_255.png", lambda: with_blue(255))
png8("blue_0.png", lambda: with_blue(0))
png8("object_space.png", lambda: shapes.encode(shapes.sphere_directions()))
png8("one_color.png", lambda: np.broadcast_to([128, 128, 255], (32, 32, 3)))
png8("one_color_gray.png", lambda: np.full((32, 32, 3), 201))
png8("all_black.png", lambda: np.zeros((32, 32, 3)))


@file("photograph.png")
def _():
    h, w = 96, 128
    tones = [
        0.55 * shapes.smooth_noise(h, w, 32, 20 + k)
        + 0.30 * shapes.smooth_noise(h, w, 8, 30 + k)
        + 0.15 * shapes.noise(h, w, 40 + k, 256) / 255
        for k in range(3)
    ]
    common = shapes.smooth_noise(h, w, 16, 50)
    tint = [(0.9, 0.05), (0.65, 0.02), (0.35, 0.0)]  # warm, like wood or stone
    levels = [a * (0.6 * common + 0.4 * t) + b for t, (a, b) in zip(tones, tint)]
    return pngs.png_bytes(u8(to_levels(np.dstack(levels), 255)))


png8("noise.png", lambda: np.dstack([shapes.noise(64, 64, 60 + k) for k in range(3)]))

# ---------------------------------------------------------------------- what goes wrong

png8("z_flipped.png", lambda: GOOD * [1, 1, -1] + [0, 0, 255])
png8("red_blue_swapped.png", lambda: GOOD[..., [2, 1, 0]])
png8("green_blue_swapped.png", lambda: GOOD[..., [0, 2, 1]])
png8(
    "dxt5nm.png",
    lambda: np.dstack([with_blue(255)[..., 2], GOOD[..., 1], GOOD[..., 1] * 0, GOOD[..., 0]]),
)
png8("gamma.png", lambda: shapes.srgb(shapes.derived(GENTLE)))
png8("jpeg_damaged.png", lambda: shapes.jpeg_damage(GOOD))


@file("resized.png")
def _():
    rough = shapes.normals(shapes.height(128, 192, seed=3), 40.0)
    return pngs.png_bytes(u8(shapes.box_half(shapes.encode(rough))))


@file("standard_z_off.png")
def _():
    levels = GOOD.copy()
    patch = shapes.smooth_noise(*GOOD.shape[:2], 16, 12) > 0.88
    levels[..., 2] = np.where(
        patch | scattered(1), 128 + (levels[..., 2] - 128) // 2, levels[..., 2]
    )
    return pngs.png_bytes(u8(levels))


@file("one_bad_texel.png")
def _():
    levels = shapes.derived(shapes.unit(GENTLE + [0.2, 0, 0]))
    levels[40, 50] = 128, 128, 180
    return pngs.png_bytes(u8(levels))


png8("too_short.png", lambda: shapes.encode(N * 0.9))
png8("too_long.png", lambda: shapes.encode(N * 1.1))


@file("xy_too_long.png")
def _():
    levels = GOOD.copy()
    edge = scattered(1)
    levels[edge] = [226, 226, 128]
    return pngs.png_bytes(u8(levels))


@file("z_negative.png")
def _():
    levels = GOOD.copy()
    levels[..., 2] = np.where(scattered(4, 9), 255 - levels[..., 2], levels[..., 2])
    return pngs.png_bytes(u8(levels))


# ------------------------------------------------------------------------------- TGA

FILES["tga_24.tga"] = lambda: pngs.tga_bytes(GOOD)
FILES["tga_24_top.tga"] = lambda: pngs.tga_bytes(GOOD, origin="top-left")
FILES["tga_24_rle_right.tga"] = lambda: pngs.tga_bytes(GOOD, rle=True, origin="bottom-right")
FILES["tga_32_rle.tga"] = lambda: pngs.tga_bytes(alpha(GOOD, 255), rle=True, origin="top-right")
FILES["tga_gray.tga"] = lambda: pngs.tga_bytes(to_levels(shapes.height(), 255))


@file("tga_palette.tga")
def _():
    colors, indices = np.unique(GOOD[:16, :16].reshape(-1, 3), axis=0, return_inverse=True)
    return pngs.tga_bytes(indices.reshape(16, 16), palette=colors, rle=True)


# ---------------------------------------------------------------------------- DDS and KTX2


def dds(name, body, **options):
    FILES[name] = lambda: gpu_textures.dds(96, 64, body(), **options)


dds("bc5.dds", lambda: gpu_textures.bc5_bytes(GOOD[..., 0], GOOD[..., 1]), dxgi=83)
dds("bc5_exchanged.dds", lambda: gpu_textures.bc5_bytes(GOOD[..., 1], GOOD[..., 0]), four=b"ATI2")
dds("srgb.dds", lambda: alpha(GOOD, 255).astype(np.uint8).tobytes(), dxgi=29)
dds("bc3_dxt5nm.dds", lambda: gpu_textures.dxt5nm_bytes(GOOD[..., 0], GOOD[..., 1]), four=b"DXT5")
dds(
    "bc4_height.dds",
    lambda: gpu_textures.bc4_bytes(to_levels(shapes.height(), 255)).tobytes(),
    four=b"ATI1",
)
dds(
    "bgra.dds",
    lambda: alpha(GOOD, 255)[..., [2, 1, 0, 3]].astype(np.uint8).tobytes(),
    masks=(0xFF0000, 0xFF00, 0xFF, 0),
    bits=32,
)
FILES["rg16.ktx2"] = lambda: gpu_textures.ktx2(
    96, 64, [to_levels((N[..., :2] + 1) / 2, 65535).astype("<u2").tobytes()], 77
)
FILES["zlib.ktx2"] = lambda: gpu_textures.ktx2(
    96, 64, [u8(GOOD).tobytes()], 23, scheme=3, pack=pngs.stored
)


# ---------------------------------------------------------------------------- broken

FILES["broken_truncated.dds"] = lambda: FILES["bc5.dds"]()[:3000]

FILES["broken_empty.png"] = lambda: b""
FILES["broken_text.png"] = lambda: b"This is not an image.\n"
FILES["broken_lfs_pointer.png"] = lambda: (
    b"version https://git-lfs.github.com/spec/v1\n"
    b"oid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393\nsize 12345\n"
)
FILES["broken_signature_only.png"] = lambda: pngs.SIGNATURE
FILES["broken_truncated.png"] = lambda: pngs.png_bytes(u8(GOOD))[:9000]
FILES["broken_truncated.tga"] = lambda: pngs.tga_bytes(GOOD)[:9000]
FILES["broken_huge.png"] = lambda: (
    pngs.SIGNATURE
    + pngs.chunk(b"IHDR", bytes.fromhex("7fffffff 7fffffff 08 02 00 00 00"))
    + pngs.chunk(b"IDAT", pngs.stored(b"\0" * 64))
    + pngs.chunk(b"IEND")
)
FILES["broken_huge.tga"] = lambda: bytes.fromhex(
    "0000020000000000000000000080018018 20".replace(" ", "")
)


@file("broken_crc.png")
def _():
    data = bytearray(pngs.png_bytes(u8(GOOD)))
    data[60] ^= 1  # inside IDAT
    return bytes(data)


@file("broken_header_crc.png")
def _():
    data = bytearray(pngs.png_bytes(u8(GOOD)))
    data[30] ^= 1
    return bytes(data)


def make_jpegs(folder):
    """Pillow writes these two; other versions of it may write other bytes."""
    from PIL import Image

    image = Image.fromarray(u8(GOOD))
    image.save(folder / "jpeg.jpg", quality=92, subsampling=0)
    image.save(folder / "jpeg_progressive.jpg", quality=75, subsampling=2, progressive=True)


def main(arguments):
    jpegs = "--jpeg" in arguments
    arguments = [a for a in arguments if a != "--jpeg"]
    folder = Path(arguments[0]) if arguments else HERE
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in FILES.items():
        (folder / name).write_bytes(make())
    if jpegs:
        make_jpegs(folder)


if __name__ == "__main__":
    main(sys.argv[1:])
