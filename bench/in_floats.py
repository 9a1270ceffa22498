# SPDX-License-Identifier: MIT
"""What a careful program without libntp would do, with numpy and OpenCV in float32, which is not exact."""

import functools

import numpy as np

try:
    import cv2
except ImportError:
    cv2 = None


def floats_of(texture):
    """x, y, z as planes of float32 in -1..1."""
    most = 255 if texture.dtype == np.uint8 else 65535
    return [cv2.addWeighted(c, 2 / most, c, 0, -1, dtype=cv2.CV_32F) for c in cv2.split(texture)]


def stored(x, y, z, out):
    """Unit vectors of these planes, as levels."""
    squares = cv2.multiply(x, x)
    cv2.accumulateSquare(y, squares)
    cv2.accumulateSquare(z, squares)
    half = (255 if out.dtype == np.uint8 else 65535) / 2
    factor = cv2.divide(half, cv2.sqrt(squares))
    merged = cv2.merge([cv2.multiply(c, factor) for c in (x, y, z)])
    if out.dtype == np.uint8:
        cv2.convertScaleAbs(merged, out, 1, half)
    else:
        merged += np.float32(half + 0.5)
        np.copyto(out, merged, casting="unsafe")


def clean_floats(texture, out):
    x, y, _ = floats_of(texture)
    squares = cv2.multiply(x, x)
    cv2.accumulateSquare(y, squares)
    z = cv2.sqrt(cv2.max(1 - squares, 0.0))
    stored(x, y, z, out)


def normalize_floats(texture, out):
    stored(*floats_of(texture), out)


def flip_bytes(texture, out):
    mask = np.zeros(1, texture.dtype)
    cv2.bitwise_xor(texture, (0, int(~mask[0]), 0, 0), out)


def deepen_floats(texture, out):
    np.multiply(texture, np.uint16(257), out=out, dtype=np.uint16)


def narrow_floats(texture, out):
    cv2.convertScaleAbs(texture, out, 1 / 257)


def zzero_floats(texture, out):
    r, g, b = cv2.split(texture)
    cv2.merge([r, g, cv2.convertScaleAbs(b, alpha=2, beta=-255)], out)


def decode_floats(texture, out):
    most = 255 if texture.dtype == np.uint8 else 65535
    np.multiply(texture, np.float32(2 / most), out=out, dtype=np.float32)
    out -= np.float32(1)


def encode_floats(vectors, out):
    stored(*cv2.split(vectors), out)


def stronger_floats(texture, out):
    x, y, z = floats_of(texture)
    x *= np.float32(1.7)
    y *= np.float32(1.7)
    stored(x, y, z, out)


def pairs_floats(pairs, out):
    x, y = (cv2.addWeighted(c, 2 / 255, c, 0, -1, dtype=cv2.CV_32F) for c in cv2.split(pairs))
    squares = cv2.multiply(x, x)
    cv2.accumulateSquare(y, squares)
    cv2.merge([x, y, cv2.sqrt(cv2.max(1 - squares, 0.0))], out)


def stronger_vectors(vectors, out):
    x, y, z = cv2.split(vectors)
    x *= np.float32(1.7)
    y *= np.float32(1.7)
    squares = cv2.multiply(x, x)
    cv2.accumulateSquare(y, squares)
    cv2.accumulateSquare(z, squares)
    factor = cv2.divide(1, cv2.sqrt(squares))
    cv2.merge([cv2.multiply(c, factor) for c in (x, y, z)], out)


def turned_floats(texture, out):
    r, g, b = cv2.split(cv2.rotate(texture, cv2.ROTATE_90_CLOCKWISE))
    cv2.merge([g, cv2.bitwise_not(r), b], out)


def blend_floats(texture, other, out):
    tx, ty, tz = floats_of(texture)
    ux, uy, uz = floats_of(other)
    tz += np.float32(1)
    dot = cv2.multiply(tz, uz) - cv2.multiply(tx, ux) - cv2.multiply(ty, uy)
    dot = cv2.divide(dot, tz + np.float32(1e-6))
    stored(tx * dot + ux, ty * dot + uy, tz * dot - uz, out)


def half_floats(texture, out):
    side = (out.shape[1], out.shape[0])
    planes = [cv2.resize(c, side, interpolation=cv2.INTER_AREA) for c in floats_of(texture)]
    stored(*planes, out)


def shaded_floats(texture, out):
    x, y, z = floats_of(texture)
    light = np.array((-1.0, 1.0, 1.2), np.float32) / np.float32(3.44**0.5)
    half = light + np.array((0, 0, 1), np.float32)
    half /= np.linalg.norm(half)
    squares = cv2.multiply(x, x)
    cv2.accumulateSquare(y, squares)
    cv2.accumulateSquare(z, squares)
    length = cv2.sqrt(squares)
    lambert = cv2.max(cv2.divide(x * light[0] + y * light[1] + z * light[2], length), 0.0)
    glint = cv2.max(cv2.divide(x * half[0] + y * half[1] + z * half[2], length), 0.0)
    linear = lambert * np.float32(0.54) + cv2.pow(glint, 32) * np.float32(0.2) + np.float32(0.06)
    gray = cv2.convertScaleAbs(cv2.sqrt(cv2.min(linear, 1.0)), alpha=255)
    cv2.merge([gray, gray, gray], out)


def compared_floats(texture, other):
    a, b = floats_of(texture), floats_of(other)
    squares = functools.reduce(
        np.add, [cv2.multiply(p - q, p - q) for p, q in zip(a, b, strict=True)]
    )
    chord = cv2.sqrt(squares)
    angles = 2 * np.arcsin(np.minimum(chord * np.float32(0.5), np.float32(1)))
    return float(angles.mean()), float(angles.max()), int(cv2.absdiff(texture, other).max())


def slopes_floats(height, scale, out):
    h = height.astype(np.float32)
    most = 65535 if height.dtype == np.uint16 else 1
    p = cv2.Sobel(h, cv2.CV_32F, 1, 0, ksize=3, scale=-scale / (8 * most))
    q = cv2.Sobel(h, cv2.CV_32F, 0, 1, ksize=3, scale=scale / (8 * most))
    stored(p, q, np.ones_like(p), out)


def unit_floats(texture, out):
    most = 255 if texture.dtype == np.uint8 else 65535
    np.multiply(texture, np.float32(1 / most), out=out, dtype=np.float32)


def rotated_floats(texture, out):
    """By 30 degrees clockwise; what lies outside is wrapped."""
    size = texture.shape[0]
    middle = (size - 1) / 2
    turn = cv2.getRotationMatrix2D((middle, middle), -30, 1)
    x, y, z = (
        cv2.warpAffine(c, turn, (size, size), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
        for c in floats_of(texture)
    )
    cosine, sine = np.float32(3**0.5 / 2), np.float32(-0.5)
    stored(x * cosine - y * sine, x * sine + y * cosine, z, out)


def half_with_alpha(texture, out):
    side = (out.shape[1], out.shape[0])
    alpha = texture[..., 3].astype(np.float32)
    planes = [
        cv2.resize(c * alpha, side, interpolation=cv2.INTER_AREA) for c in floats_of(texture)[:3]
    ]
    rgb = np.empty((side[1], side[0], 3), out.dtype)
    stored(*planes, rgb)
    cv2.merge(
        [*cv2.split(rgb), cv2.resize(texture[..., 3], side, interpolation=cv2.INTER_AREA)], out
    )


def slope_vectors(height, scale, out):
    h = height.astype(np.float32)
    p = cv2.Sobel(h, cv2.CV_32F, 1, 0, ksize=3, scale=-scale / (8 * 65535))
    q = cv2.Sobel(h, cv2.CV_32F, 0, 1, ksize=3, scale=scale / (8 * 65535))
    squares = cv2.multiply(p, p)
    cv2.accumulateSquare(q, squares)
    factor = cv2.divide(1, cv2.sqrt(squares + np.float32(1)))
    cv2.merge([cv2.multiply(p, factor), cv2.multiply(q, factor), factor], out)
