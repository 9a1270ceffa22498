# SPDX-License-Identifier: MIT
"""Textures of known kind, drawn from a seed: what the classification is tested with.

`draw(rng)` gives one Case: pixels, what they are, what was done to them, and the undamaged
pixels where cleaning can be judged against them.  Nothing here is taken from libntp.
"""

from dataclasses import dataclass, field

import numpy as np
from PIL import Image

from .encoders import encode, encode_normals, jpeg, resize, srgb_encode, to_type, with_alpha
from .pictures import PICTURES
from .surfaces import blur, draw_height, draw_normals, draw_size, fft_noise, normals_of

STANDARD, ZZERO, XY, HEIGHT, OBJECT, ONE_COLOR, NOT_NORMALS = range(7)
CLASSES = ["standard", "zzero", "xy", "height", "object-space", "one-color", "not-normals"]
GAMMA, RED_IS_Z, GREEN_IS_Z, DXT5NM, LOSSY, FILTERED, Z_FLIPPED, BLUE_CONSTANT = (
    1 << i for i in range(8)
)


@dataclass
class Case:
    name: str
    pixels: np.ndarray  # (h, w, channels)
    kind: int
    also: tuple = ()  # other classes that no look at the texels could refute
    encoding: int = 0  # how the view is declared: 0 standard, 2 XY, 4 height
    must: int = 0  # accidents that have to be found
    may: int = 0  # accidents that may be reported
    truth: np.ndarray | None = None  # vectors (h, w, 3), z up, of the undamaged map
    method: int | None = None  # the better way of cleaning: 0 derive, 1 normalize, 2 keep
    details: dict = field(default_factory=dict)


# ----------------------------------------------------------------- undamaged normals


def plain(rng, zzero=False):
    n, _, d = draw_normals(rng, 0.3 if zzero else 0.02)
    m = 65535 if rng.random() < 0.2 else 255
    levels, style = encode_normals(rng, n, m, zzero)
    return n, levels, {**d, "style": style, "m": m}


def undamaged(rng):
    n, levels, d = plain(rng)
    method = 2 if d["style"] == "rounded" else None
    case = Case("standard", levels, STANDARD, truth=n, method=method, details=d)
    if rng.random() < 0.2:
        _add_alpha(rng, case)
    return case


def _add_alpha(rng, case):
    """An alpha of the usual sorts: opaque, a mask over unused texels, anything."""
    h, w = case.pixels.shape[:2]
    m = 255 if case.pixels.dtype == np.uint8 else 65535
    sort = rng.choice(["opaque", "mask", "any"])
    alpha = np.full((h, w), m)
    if sort == "mask":
        alpha = np.where(fft_noise(rng, h, w, 2) > 0.3, 0, m)
        case.truth = None
    elif sort == "any":
        alpha = np.clip((fft_noise(rng, h, w, 1.5) * 0.2 + 0.6) * m, 1, m)
    case.pixels = with_alpha(case.pixels, alpha)
    case.details["alpha"] = str(sort)
    if sort == "any":
        case.method = None


def zzero(rng):
    n, levels, d = plain(rng, zzero=True)
    method = 2 if d["style"] == "rounded" else None
    return Case("zzero", levels, ZZERO, truth=n, method=method, details=d)


def gentle_zzero(rng):
    """Slopes of 0.12 to 0.3: blue tells, by a few levels."""
    n, _, d = draw_normals(rng, 0.12, 0.3, 64)
    levels, _ = encode_normals(rng, n, 255, True, "rounded")
    return Case("gentle zzero", levels, ZZERO, truth=n, method=2, details=d)


def padded(rng):
    _, levels, d = plain(rng)
    rows = max(1, int(len(levels) * rng.choice([0.03, 0.03, 0.2, 0.6])))
    m = 255 if levels.dtype == np.uint8 else 65535
    levels = levels.copy()
    levels[:rows] = rng.choice([0, m])
    return Case("padded", levels, STANDARD, details=d)


def tilted(rng):
    """A constant tilt of 0.2 and one bad texel."""
    n, _, d = draw_normals(rng, 0.02, 0.5)
    a = rng.uniform(0, 2 * np.pi)
    n = n + np.array([0.2 * np.cos(a), 0.2 * np.sin(a), 0])
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    levels, _ = encode_normals(rng, n, 255, style="rounded")
    levels[0, 0] = (10, 240, 13)
    return Case("tilted, one bad texel", levels, STANDARD, details=d)


def wrong_z(rng):
    n, _, d = draw_normals(rng, 0.05)
    levels, _ = encode_normals(rng, n, 255, style="rounded")
    bad = rng.random(n.shape[:2]) < 0.03
    levels[bad, 2] = rng.integers(0, 256, int(bad.sum()))
    return Case("3 % wrong z", levels, STANDARD, truth=n, method=0, details=d)


def scaled_z(rng):
    n, _, d = draw_normals(rng, 0.1)
    z = n * [1, 1, rng.uniform(0.8, 0.95)]
    return Case(
        "scaled z", to_type(encode(z)), STANDARD, truth=n, method=0, may=FILTERED, details=d
    )


def noisy_z(rng):
    n, _, d = draw_normals(rng, 0.1)
    z = n + rng.standard_normal(n.shape) * [0, 0, rng.uniform(0.02, 0.06)]
    return Case(
        "noise in z", to_type(encode(z)), STANDARD, truth=n, method=0, details=d, may=FILTERED
    )


def noisy(rng):
    n, _, d = draw_normals(rng, 0.1)
    z = n + rng.standard_normal(n.shape) * rng.uniform(2, 4) * 2 / 255
    return Case(
        "noise of a few levels",
        to_type(encode(z)),
        STANDARD,
        truth=n,
        method=1,
        may=LOSSY,
        details=d,
    )


def scaled_vector(rng):
    n, _, d = draw_normals(rng, 0.25)
    return Case(
        "scaled by 0.9",
        to_type(encode(0.9 * n)),
        STANDARD,
        truth=n,
        method=1,
        may=FILTERED,
        details=d,
    )


def lossy(rng):
    n, _, d = draw_normals(rng, 0.05, 2.0, 32)
    levels, _ = encode_normals(rng, n, 255, style="rounded")
    q, sub = int(rng.integers(60, 99)), int(rng.choice([0, 2]))
    d.update(quality=q, subsampling=sub)
    # What is too gentle leaves no mark that could be found.
    marked = d["strength"] > 0.3 and q < 80 and min(n.shape[:2]) >= 64
    pixels = jpeg(levels, q, sub)
    return Case(
        "JPEG",
        pixels,
        STANDARD,
        truth=n,
        method=1,
        must=LOSSY if marked else 0,
        may=LOSSY | FILTERED,
        details=d,
    )


def resized(rng):
    """Made twice to four times as large or small, up or down, and not normalized."""
    n, _, d = draw_normals(rng, 0.1, 2.0, 48)
    levels, _ = encode_normals(rng, n, 255, style="rounded")
    h, w = n.shape[:2]
    how = [Image.BOX, Image.BILINEAR, Image.LANCZOS][int(rng.integers(3))]
    factor = float(rng.choice([0.25, 0.5, 0.7, 1.5, 2.0]))
    size = max(8, int(w * factor)), max(8, int(h * factor))
    big = np.stack([_resize_plane(n[..., k], size, how) for k in range(3)], -1)
    truth = big / np.maximum(np.linalg.norm(big, axis=-1, keepdims=True), 1e-9)
    d.update(factor=factor, filter=int(how))
    shortened = (np.linalg.norm(big, axis=-1) < 0.95).mean() > 0.1
    return Case(
        "resized",
        resize(levels, *size, how),
        STANDARD,
        truth=truth,
        method=1,
        must=FILTERED if shortened else 0,
        may=FILTERED | LOSSY,
        details=d,
    )


def _resize_plane(plane, size, how):
    return np.asarray(Image.fromarray(plane.astype(np.float32)).resize(size, how), float)


def flipped_z(rng):
    n, _, d = draw_normals(rng, 0.2)
    levels, _ = encode_normals(rng, n * [1, 1, -1], 255, style="rounded")
    return Case("flipped z", levels, STANDARD, must=Z_FLIPPED, truth=n, method=2, details=d)


def gamma(rng):
    n, _, d = draw_normals(rng, 0.05, 2.0)
    levels, _ = encode_normals(rng, n, 255, style="rounded")
    return Case("stored as sRGB", srgb_encode(levels), STANDARD, must=GAMMA, details=d)


def swapped(rng):
    n, _, d = draw_normals(rng, 0.05, 1.5)
    levels, _ = encode_normals(rng, n, 255, style="rounded")
    if rng.random() < 0.6:
        return Case("red is z", levels[..., ::-1], STANDARD, must=RED_IS_Z, details=d)
    return Case("green is z", levels[..., [0, 2, 1]], STANDARD, must=GREEN_IS_Z, details=d)


def dxt5nm(rng):
    n, _, d = draw_normals(rng, 0.05, 2.0)
    levels, _ = encode_normals(rng, n, 255, style="rounded")
    x, y = levels[..., 0], levels[..., 1]
    full = np.full_like(x, 255)
    sort = rng.choice(["1y1x", "1y0x", "yyyx", "ya", "0y0x"])
    d["layout"] = str(sort)
    encoding = 0
    if sort == "1y1x":
        p = np.dstack([full, y, full, x])
    elif sort == "1y0x":
        p = np.dstack([full, y, 0 * full, x])
    elif sort == "0y0x":
        p = np.dstack([0 * full, y, 0 * full, x])
    elif sort == "yyyx":
        p = np.dstack([y, y, y, x])
    else:
        p, encoding = np.dstack([y, x]), 4
    return Case("DXT5nm", p, XY, encoding=encoding, must=DXT5NM, may=BLUE_CONSTANT, details=d)


# --------------------------------------------------------------- red and green only


def occlusion(rng, height):
    """1 in the open, darker in hollows."""
    h, w = height.shape
    spread = blur(height, rng.uniform(2, max(3, min(h, w) / 12))) - height
    return np.clip(1 - np.maximum(spread / (spread.std() + 1e-9), 0) * rng.uniform(0.1, 0.3), 0, 1)


def xy_only(rng):
    n, height, d = draw_normals(rng, 0.1)
    m = 65535 if rng.random() < 0.15 else 255
    levels, style = encode_normals(rng, n, m)
    sort = rng.choice(["occlusion", "height", "constant", "labpbr"])
    unit = (height - height.min()) / (np.ptp(height) + 1e-9)
    must = 0
    also = ()
    if sort in ("occlusion", "labpbr"):
        blue = occlusion(rng, height)
    elif sort == "height":
        blue = unit
    else:
        value = int(rng.choice([0, 128, 255, 127, 64]))
        blue = np.full(n.shape[:2], value / 255)
        d["value"] = value
        must = BLUE_CONSTANT
        # A blue of 255 is the z of a gentle surface.
        if value == 255 and d["strength"] < 0.35:
            also, must = (STANDARD,), 0
        if value == 0 and d["strength"] < 0.35:
            also = (STANDARD,)
    levels[..., 2] = np.floor(blue * m + 0.5)
    if sort == "occlusion" and d["strength"] < 0.2:
        also = (STANDARD,)
    if sort == "labpbr":
        levels = with_alpha(levels, np.floor((unit * 0.7 + 0.3) * m))
    d.update(style=style, sort=str(sort))
    return Case(
        "XY with " + str(sort),
        levels,
        XY,
        also=also,
        must=must,
        may=BLUE_CONSTANT | Z_FLIPPED,
        details=d,
    )


def two_channels(rng):
    _, levels, d = plain(rng)
    return Case("two channels", np.ascontiguousarray(levels[..., :2]), XY, encoding=2, details=d)


# ----------------------------------------------------------------------- object space


def _sphere_directions(h, w):
    """Directions over a latitude-longitude rectangle, y up."""
    theta = (np.arange(h) + 0.5) / h * np.pi
    phi = (np.arange(w) + 0.5) / w * 2 * np.pi
    theta, phi = theta[:, None], phi[None, :]
    return np.stack(
        np.broadcast_arrays(
            np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)
        ),
        -1,
    )


def _unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-9)


def _blob(rng, h, w):
    d = _sphere_directions(h, w)
    bend = np.zeros_like(d)
    for _ in range(6):
        axis = _unit(rng.standard_normal(3))
        k = rng.uniform(1, 6)
        bend += (
            rng.uniform(0.02, 0.12)
            * k
            * np.cos(k * (d @ axis) + rng.uniform(0, 6))[..., None]
            * axis
        )
    return _unit(d - bend + (bend * d).sum(-1, keepdims=True) * d)


def _charts(rng, h, w, directions, detail):
    """Charts on a background, each a flat side of a body with some detail."""
    n = np.zeros((h, w, 3))
    cells = int(np.ceil(np.sqrt(len(directions))))
    ch, cw = h // cells, w // cells
    used = np.zeros((h, w), bool)
    for i, direction in enumerate(directions):
        y, x = i // cells * ch, i % cells * cw
        part = np.broadcast_to(direction, (ch, cw, 3))
        local = normals_of(fft_noise(rng, max(ch, 4), max(cw, 4), 2)[:ch, :cw], detail)
        side = _unit(np.cross(direction, [0.31, 0.62, 0.72]))
        up = np.cross(direction, side)
        part = local[..., :1] * side + local[..., 1:2] * up + local[..., 2:] * direction
        n[y : y + ch, x : x + cw] = part
        used[y : y + ch, x : x + cw] = True
    return n, used


def object_space(rng):
    h, w = draw_size(rng, 32)
    sort = rng.choice(["sphere", "blob", "box", "low-poly"])
    used = np.ones((h, w), bool)
    if sort == "sphere":
        n = _sphere_directions(h, w)
    elif sort == "blob":
        n = _blob(rng, h, w)
    elif sort == "box":
        turn = np.linalg.qr(rng.standard_normal((3, 3)))[0] if rng.random() < 0.5 else np.eye(3)
        n, used = _charts(rng, h, w, np.concatenate([turn, -turn]), rng.uniform(0.02, 0.5))
    else:
        sides = _unit(rng.standard_normal((int(rng.integers(12, 60)), 3)))
        n, used = _charts(rng, h, w, sides, rng.uniform(0.02, 0.5))
    levels = to_type(encode(n))
    levels[~used] = rng.choice([0, 255])
    q = 0
    if rng.random() < 0.25:
        q = int(rng.integers(75, 96))
        levels = jpeg(levels, q, 0)
    return Case(
        "object space " + str(sort),
        levels,
        OBJECT,
        may=LOSSY | FILTERED,
        details={"size": (w, h), "quality": q},
    )


# -------------------------------------------------------------------- no normals at all


def picture(rng):
    h, w = draw_size(rng)
    paint = PICTURES[int(rng.integers(len(PICTURES)))]
    levels = to_type(np.clip(np.floor(paint(rng, h, w) * 255 + 0.5), 0, 255))
    q = 0
    if rng.random() < 0.3:
        q = int(rng.integers(70, 98))
        levels = jpeg(levels, q, 2)
    return Case(
        "picture " + paint.__name__,
        levels,
        NOT_NORMALS,
        may=LOSSY,
        details={"size": (w, h), "quality": q},
    )


def gray_height(rng):
    h, w = draw_size(rng)
    height, family = draw_height(rng, h, w)
    m = 65535 if rng.random() < 0.3 else 255
    unit = (height - height.min()) / (np.ptp(height) + 1e-9)
    gray = to_type(np.floor(unit * m + 0.5), m)
    sort = rng.choice(["gray", "rgb", "rgba", "gray, alpha"])
    encoding = 4 if sort.startswith("gray") else 0
    pixels = gray[..., None] if sort == "gray" else np.dstack([gray] * 3)
    alpha = np.full((h, w), m) if rng.random() < 0.5 else np.where(unit > 0.3, m, 0)
    if sort == "rgba":
        pixels = with_alpha(pixels, alpha)
    if sort == "gray, alpha":
        pixels = with_alpha(gray, alpha)
    return Case(
        "height as " + str(sort),
        pixels,
        HEIGHT,
        encoding=encoding,
        may=LOSSY,
        details={"family": family, "size": (w, h)},
    )


def one_color(rng):
    h, w = draw_size(rng)
    color = [
        (128, 128, 255),
        (127, 127, 255),
        (201, 201, 201),
        (0, 0, 0),
        (255, 255, 255),
        (255, 255, 0),
        tuple(rng.integers(0, 256, 3)),
    ][int(rng.integers(7))]
    pixels = np.broadcast_to(np.array(color, np.uint8), (h, w, 3)).copy()
    if rng.random() < 0.3:
        pixels[: h // 3] = 0
    return Case("one color", pixels, ONE_COLOR, details={"color": tuple(map(int, color))})


# Weights: how often each is drawn.
KINDS = [
    (undamaged, 6), (zzero, 3), (gentle_zzero, 1), (padded, 2), (tilted, 1), (wrong_z, 2),
    (scaled_z, 1), (noisy_z, 1), (noisy, 1), (scaled_vector, 1), (lossy, 4), (resized, 4),
    (flipped_z, 1), (gamma, 2), (swapped, 2), (dxt5nm, 2), (xy_only, 6), (two_channels, 1),
    (object_space, 4), (picture, 6), (gray_height, 3), (one_color, 2),
]  # fmt: skip


def has_one_color(case):
    """Do all used texels agree?  Padding and damage can leave nothing but the flat parts."""
    channels = case.pixels.shape[2]
    alpha = channels == 4 or (channels == 2 and case.encoding == 4)
    color = case.pixels[..., : channels - alpha].reshape(-1, channels - alpha)
    unused = (color == 0).all(1) | (color == np.iinfo(color.dtype).max).all(1)
    if alpha:
        unused |= case.pixels[..., -1].ravel() == 0
    used = color[~unused]
    return len(used) == 0 or bool((used == used[0]).all())


def draw(rng):
    weights = np.array([w for _, w in KINDS], float)
    kind = KINDS[int(rng.choice(len(KINDS), p=weights / weights.sum()))][0]
    case = kind(rng)
    if has_one_color(case):
        case.also += (ONE_COLOR,)
    return case
