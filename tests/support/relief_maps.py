# SPDX-License-Identifier: MIT
"""Curvature and ambient occlusion: calls of the library, surfaces with known values, a slow oracle."""

import numpy as np

from support import libntp_ffi as ntp

MEAN, GAUSSIAN, CONVEX, CAVITY = range(4)
WRAP, CLAMP = 0, 1


def curvature(src, encoding=ntp.HEIGHT, dtype=np.float32, y=ntp.UP, area=None, **how):
    """ntp_curvature of an array."""
    made = np.full(src.shape[:2], 7, dtype)
    dst = ntp.view(made, ntp.HEIGHT)
    options = ntp.ffi.new("ntp_curvature_options *", how)
    rect = ntp.ffi.new("ntp_rect *", area) if area else ntp.ffi.NULL
    view = ntp.view(src, encoding, y, const=True)
    ntp.check(ntp.lib.ntp_curvature(dst, view, options, rect))
    return made


def range_of(values):
    found = ntp.ffi.new("double *")
    ntp.check(ntp.lib.ntp_curvature_range(found, ntp.view(values, ntp.HEIGHT, const=True)))
    return found[0]


def borders(src, encoding=ntp.HEIGHT):
    """ntp_relief_borders: (x, y)."""
    found = ntp.ffi.new("ntp_border[2]")
    view = ntp.view(src, encoding, const=True)
    ntp.check(ntp.lib.ntp_relief_borders(found, found + 1, view))
    return found[0], found[1]


def occlusion(src, dtype=np.float32, parts=1, hooks=None, **how):
    """ntp_occlusion of heights."""
    made = np.full(src.shape[:2], 7, dtype)
    options = ntp.ffi.new("ntp_occlusion_options *", how)
    height, width = src.shape[:2]
    size = ntp.lib.ntp_occlusion_scratch_size(options, width, height, parts)
    memory = np.empty(size + 64, np.uint8)
    memory = memory[-memory.ctypes.data % 64 :][:size]
    if hooks is None:
        hooks = ntp.ffi.new("ntp_hooks *", {"parts": parts})
    scratch = ntp.ffi.cast("void *", memory.ctypes.data)
    view = ntp.view(src, ntp.HEIGHT, const=True)
    dst = ntp.view(made, ntp.HEIGHT)
    ntp.check(ntp.lib.ntp_occlusion(dst, view, options, scratch, size, hooks))
    return made


def hills(side, height, blur=8, seed=1):
    """Smooth random heights that tile, from 0 to `height`."""
    noise = np.fft.fft2(np.random.default_rng(seed).random((side, side)))
    far = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.fftfreq(side))
    smooth = np.fft.ifft2(noise * np.exp(-((far * blur) ** 2))).real
    return (smooth - smooth.min()) / (smooth.max() - smooth.min()) * height


def groove(kind, half):
    """Heights of a groove that runs down the picture, and what each texel sees of the sky.

    In a cross-section the share is the half of the difference of the sines of the angles to the
    normal between which the sky is seen.
    """
    x = np.arange(-100, 101.0)
    if kind == "cylinder":
        radius = half / np.sin(np.radians(50))
        h = radius * np.cos(np.radians(50)) - np.sqrt(np.maximum(radius**2 - x**2, 0))
        slope = x / np.sqrt(np.maximum(radius**2 - x**2, 1))
    else:
        h, slope = (abs(x) - half) * kind, np.sign(x) * kind
    h = np.where(abs(x) < half, h, 0)
    right = np.stack([np.ones_like(x), slope], -1) / np.sqrt(1 + slope**2)[:, None]
    rims = [np.stack([end - x, -h], -1) for end in (-half, half)]
    sines = [(rim * right).sum(-1) / np.maximum(np.hypot(*rim.T), 1e-9) for rim in rims]
    return np.broadcast_to(h, (60, len(x))), (sines[1] - sines[0]) / 2, abs(x) < 0.9 * half


def _between(h, x, y):
    """Heights at positions between texels, bilinear, of a texture that tiles."""
    left, up = np.floor(x).astype(int), np.floor(y).astype(int)
    rows, columns = h.shape

    def at(down, right):
        return h[(up + down) % rows, (left + right) % columns]

    upper = at(0, 0) + (at(0, 1) - at(0, 0)) * (x - left)
    lower = at(1, 0) + (at(1, 1) - at(1, 0)) * (x - left)
    return upper + (lower - upper) * (y - up)


def slow_occlusion(h, directions=96):
    """By its definition: rays in many directions, and a sum over the angles that are hidden."""
    p, q = (np.roll(h, -1, 1) - np.roll(h, 1, 1)) / 2, (np.roll(h, -1, 0) - np.roll(h, 1, 0)) / 2
    z = 1 / np.sqrt(1 + p * p + q * q)
    y, x = np.mgrid[: h.shape[0], : h.shape[1]].astype(float)
    places, weights = np.polynomial.legendre.leggauss(16)
    lost = np.zeros(h.shape)
    for turn in (np.arange(directions) + 0.5) * 2 * np.pi / directions:
        right, down = np.cos(turn), np.sin(turn)
        tangent = p * right + q * down
        horizon = tangent
        for i in range(1, max(h.shape) + 1):
            far = i / max(abs(right), abs(down))
            seen = (_between(h, x + right * far, y + down * far) - h) / far
            horizon = np.maximum(horizon, seen)
        low, high = np.arctan(tangent), np.arctan(horizon)
        for place, weight in zip(places, weights, strict=True):
            angle = (low + high) / 2 + (high - low) / 2 * place
            cosine = z * (np.sin(angle) - tangent * np.cos(angle))
            lost += weight * (high - low) / 2 * cosine * np.cos(angle)
    return 1 - lost * 2 / directions
