# SPDX-License-Identifier: MIT
"""Vectors as levels, and what is done to levels afterwards: JPEG, other sizes, sRGB, alpha."""

import io

import numpy as np
from PIL import Image


def encode(v, m=255):
    """-1..1 to levels, rounded."""
    return np.clip(np.floor((v + 1) / 2 * m + 0.5), 0, m)


def to_type(levels, m=255):
    return levels.astype(np.uint8 if m == 255 else np.uint16)


def encode_normals(rng, n, m=255, zzero=False, style=None):
    """(levels, style): rounded, truncated, or with flat at 127 or 128."""
    if style is None:
        style = rng.choice(["rounded", "truncated", "flat127", "flat128"], p=[0.6, 0.15, 0.1, 0.15])
    half = m // 2
    if style == "truncated":
        out = np.clip(np.floor((n + 1) / 2 * m), 0, m)
        z = np.floor(n[..., 2] * m)
    elif style == "flat127":
        out = np.clip(np.floor(n * half + half + 0.5), 0, m)
        out[..., 2] = encode(n[..., 2], m)
        z = np.floor(n[..., 2] * m + 0.5)
    elif style == "flat128":
        out = np.clip(np.floor(n * half + half + 1.5), 0, m)
        z = np.floor(n[..., 2] * m + 0.5)
    else:
        out = encode(n, m)
        z = np.floor(n[..., 2] * m + 0.5)
    if zzero:
        out[..., 2] = np.clip(z, 0, m)
    return to_type(out, m), str(style)


def srgb_encode(levels):
    v = levels / 255
    v = np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)
    return to_type(np.floor(v * 255 + 0.5))


def jpeg(levels, quality, subsampling):
    data = io.BytesIO()
    Image.fromarray(levels).save(data, "JPEG", quality=int(quality), subsampling=int(subsampling))
    return np.asarray(Image.open(io.BytesIO(data.getvalue())).convert("RGB"))


def resize(levels, w, h, method):
    return np.asarray(Image.fromarray(levels).resize((w, h), method))


def with_alpha(levels, alpha):
    return np.dstack([levels, np.broadcast_to(alpha, levels.shape[:2]).astype(levels.dtype)])
