# SPDX-License-Identifier: MIT
"""The pictures of a report: small, as data URIs, and honest about single bad texels.

Textures and lit surfaces are averaged down.  Heatmaps are not: of each block of texels the most
colorful one is kept, so that one bad texel in a 4K texture still shows.
"""

import base64
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._clean import clean_with_counts
from .._measure import measure
from .._pictures import heatmap, shade
from ..typing import Palette, Stored

Bytes = NDArray[np.uint8]

HISTOGRAM_BINS = 64  # of lengths 0..2
_COLOR_TYPES = {1: 0, 3: 2, 4: 6}
DRAWN: dict[str, Stored] = {
    "standard": "standard",
    "zzero": "zzero",
    "xy": "xy",
    "one-color": "standard",
}


@dataclass(frozen=True)
class Pictures:
    """Data URIs of one file, "" for what was not drawn.

    ``lengths`` counts texels by length in 64 bins of 1/32; ``changed`` counts the texels that
    cleaning changes.
    """

    texture: str
    heatmap: str = ""
    lit: str = ""
    cleaned: str = ""
    cleaned_lit: str = ""
    width: int = 0
    height: int = 0
    lengths: tuple[int, ...] = ()
    changed: int = 0


def png(image: Bytes) -> bytes:
    """A PNG of (height, width) or (height, width, 3 or 4) bytes.

    Each row holds differences to the one above, which suits smooth pictures.
    """
    height, width = image.shape[:2]
    channels = image.shape[2] if image.ndim == 3 else 1
    rows = image.reshape(height, width * channels)
    body = np.full((height, 1 + width * channels), 2, np.uint8)  # 2: the filter "up"
    body[0, 1:] = rows[0]
    body[1:, 1:] = rows[1:] - rows[:-1]

    def chunk(kind: bytes, data: bytes) -> bytes:
        end = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + end

    header = struct.pack(">IIBBBBB", width, height, 8, _COLOR_TYPES[channels], 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(body.tobytes(), 9))
        + chunk(b"IEND", b"")
    )


def data_uri(image: Bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(png(image)).decode("ascii")


def _factor(image: NDArray[Any], size: int) -> int:
    side: int = max(image.shape[:2])
    return -(-side // size)


def average(image: NDArray[Any], size: int) -> Bytes:
    """An image of at most size x size, each texel the mean of a block; 16 bit becomes 8 bit."""
    maximum = 1.0 if image.dtype.kind == "f" else float(np.iinfo(image.dtype).max)
    factor = _factor(image, size)
    if factor > 1:
        starts = [np.arange(0, side, factor) for side in image.shape[:2]]
        counts = [
            np.minimum(factor, side - s) for s, side in zip(starts, image.shape, strict=False)
        ]
        # Row by row of blocks, so that the sums need little memory.
        rows = [
            np.add.reduceat(image[y : y + factor].sum(axis=0, dtype=np.float64), starts[1], axis=0)
            for y in starts[0]
        ]
        divisor = np.outer(counts[0], counts[1])
        if image.ndim == 3:
            divisor = divisor[..., None]
        image = np.stack(rows) / divisor
    scaled = np.multiply(np.nan_to_num(np.asarray(image, np.float64)), 255.0 / maximum)
    return np.clip(scaled + 0.5, 0, 255).astype(np.uint8)


def worst(image: Bytes, size: int) -> Bytes:
    """A heatmap of at most size x size, each texel the most colorful of its block."""
    factor = _factor(image, size)
    if factor == 1:
        return image
    height, width = (-(-side // factor) for side in image.shape[:2])
    out = np.empty((height, width, 3), np.uint8)
    for y in range(height):
        band = image[y * factor : (y + 1) * factor]
        missing = width * factor - band.shape[1]
        band = np.pad(band, ((0, 0), (0, missing), (0, 0)), mode="edge")
        cells = band.reshape(band.shape[0], width, factor, 3).transpose(1, 0, 2, 3)
        block = cells.reshape(width, -1, 3)
        chroma = block.max(axis=2).astype(np.int16) - block.min(axis=2)
        pick = chroma.argmax(axis=1)
        colors = block[np.arange(width), pick]
        plain = chroma.max(axis=1) == 0
        colors[plain] = block[plain].mean(axis=1).astype(np.uint8)
        out[y] = colors
    return out


def _opaque_rgb(image: NDArray[Any]) -> NDArray[Any]:
    """Three channels to look at: gray is repeated, a missing blue is empty, alpha is dropped."""
    if image.ndim == 2 or image.shape[2] == 1:
        return np.repeat(image.reshape(*image.shape[:2], 1), 3, axis=2)
    if image.shape[2] == 2:
        return np.repeat(image[..., :1], 3, axis=2)
    return image[..., :3]


def _lit(image: NDArray[Any], kind: Stored) -> Bytes:
    return shade(image, type=kind, out=np.empty(image.shape[:2], np.uint8))


def draw(
    image: NDArray[Any], file: Mapping[str, Any], *, size: int = 256, palette: Palette = "reference"
) -> Pictures:
    """Draws one file.

    Parameters
    ----------
    image
        Its pixels.
    file
        Its entry in the JSON of a check; the type decides how it is read.
    size
        The longer side of the pictures.
    palette
        That of the heatmap.

    Returns
    -------
    Pictures
        Only the texture itself where it is no normals texture of three channels.
    """
    texture = average(_opaque_rgb(image), size)
    height, width = texture.shape[:2]
    kind = DRAWN.get(str(file.get("type")))
    if kind is None or image.ndim != 3 or image.shape[2] < 3:
        return Pictures(data_uri(texture), width=width, height=height)
    cleaned, counts = clean_with_counts(image, type=kind)
    heat = worst(heatmap(image, type=kind, palette=palette), size)
    lengths: tuple[int, ...] = ()
    if kind != "xy":
        fine = np.array(measure(image, type=kind).lengths, np.int64)
        lengths = tuple(int(n) for n in fine.reshape(HISTOGRAM_BINS, -1).sum(axis=1))
    before_after = {}
    if counts.changed:
        before_after = {
            "cleaned": data_uri(average(_opaque_rgb(cleaned), size)),
            "cleaned_lit": data_uri(average(_lit(cleaned, kind), size)),
        }
    return Pictures(
        texture=data_uri(texture),
        heatmap=data_uri(heat),
        lit=data_uri(average(_lit(image, kind), size)),
        width=width,
        height=height,
        lengths=lengths,
        changed=counts.changed,
        **before_after,
    )
