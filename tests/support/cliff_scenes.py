# SPDX-License-Identifier: MIT
"""Made scenes with cliffs: depth and normals of the same surface, from formulas.

A pixel (u, v) of a camera (fx, fy, cx, cy) looks along ((u - cx)/fx, (v - cy)/fy, 1), x to the right,
y down, z away.  Without a camera all look along z, and a pixel is one unit wide.  Normals point to
the viewer and are given as textures store them: x right, y up, z towards the viewer.
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass
class Scene:
    """depth and pieces are (h, w), normals (h, w, 3); NaN, and piece 0, is nothing."""

    name: str
    depth: np.ndarray
    normals: np.ndarray
    pieces: np.ndarray  # parts that hang together somewhere; each has a depth of its own
    camera: tuple | None

    @property
    def mask(self):
        return self.pieces > 0


def camera_of(size, degrees):
    """A camera of this horizontal field of view; None: orthographic."""
    if not degrees:
        return None
    f = size / 2 / math.tan(math.radians(degrees) / 2)
    return (f, f, (size - 1) / 2, (size - 1) / 2)


def _rays(size, camera):
    """The start and direction of the ray of each pixel."""
    v, u = np.mgrid[:size, :size].astype(float)
    zero = np.zeros_like(u)
    if camera is None:
        middle = (size - 1) / 2
        return np.stack([u - middle, v - middle, zero], -1), np.stack([zero, zero, zero + 1], -1)
    fx, fy, cx, cy = camera
    return np.stack([zero] * 3, -1), np.stack([(u - cx) / fx, (v - cy) / fy, zero + 1], -1)


def _stored(normals):
    """From x right, y down, z away to x right, y up, z towards the viewer."""
    return normals * np.array([1.0, -1.0, -1.0])


def _distance(size, camera):
    """Where the middle of a scene of about the size of the picture lies."""
    return 0.0 if camera is None else camera[0]


def spheres(size, degrees, floating):
    """Four spheres and a slanted plane.  Sunk into it they meet it along half of their outline."""
    camera = camera_of(size, degrees)
    start, ray = _rays(size, camera)
    far = _distance(size, camera)
    slant = np.array([0.05, -0.45, -1.0])
    slant /= np.linalg.norm(slant)
    point = np.array([0.0, 0.0, far])
    depth = ((point - start) @ slant) / (ray @ slant)
    normals = np.broadcast_to(slant, start.shape).copy()
    pieces = np.where(np.isfinite(depth) & (depth > 0) | (camera is None), 1, 0)
    for index, (x, y, radius) in enumerate(
        [(-0.22, -0.2, 0.14), (0.2, -0.16, 0.17), (-0.15, 0.2, 0.16), (0.24, 0.22, 0.1)]
    ):
        center = np.array([x * size, y * size, far])
        center[2] -= ((center - point) @ slant) / slant[2]
        if floating:
            center[2] -= 1.6 * radius * size
        at = start - center
        a, b = np.sum(ray * ray, -1), np.sum(ray * at, -1)
        c = np.sum(at * at, -1) - (radius * size) ** 2
        under = b * b - a * c
        hit = (-b - np.sqrt(np.where(under > 0, under, np.nan))) / a
        nearer = (under > 0) & (hit < depth)
        depth = np.where(nearer, hit, depth)
        round_ = (at + hit[..., None] * ray) / (radius * size)
        normals = np.where(nearer[..., None], round_, normals)
        pieces = np.where(nearer, index + 2 if floating else 1, pieces)
    name = "spheres " + ("floating" if floating else "sunk")
    return Scene(name, depth, _stored(normals), pieces, camera)


def _of_height(name, size, degrees, height):
    """A scene from depth as a function of the pixel, in units of the picture's width: orthographic,
    or its logarithm with perspective.  Slopes are differences of the same formula."""
    camera = camera_of(size, degrees)
    v, u = np.mgrid[:size, :size].astype(float)
    tiny = 1e-4

    def z(u, v, u0, v0):
        flat = height((u + 0.5) / size, (v + 0.5) / size, (u0 + 0.5) / size, (v0 + 0.5) / size)
        return flat * size if camera is None else camera[0] * np.exp(flat * 1.0)

    depth = z(u, v, u, v)
    along = (z(u + tiny, v, u, v) - z(u - tiny, v, u, v)) / (2 * tiny)
    down = (z(u, v + tiny, u, v) - z(u, v - tiny, u, v)) / (2 * tiny)
    if camera is None:
        normals = np.stack([along, down, -np.ones_like(u)], -1)
    else:
        fx, fy, cx, cy = camera
        right = np.stack([along * (u - cx) / fx + depth / fx, along * (v - cy) / fy, along], -1)
        below = np.stack([down * (u - cx) / fx, down * (v - cy) / fy + depth / fy, down], -1)
        normals = -np.cross(right, below)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return Scene(name, depth, _stored(normals), np.ones((size, size), int), camera)


def _roll(t):
    """An edge that rolls off: 0 up to t = .6, then down ever steeper until t = 1."""
    over = np.clip((t - 0.6) / 0.42, 0, 1)
    return 1 - np.sqrt(1 - over * over)


def spiral(size, degrees):
    """A ramp around a middle column, with one cliff from there to the edge, its upper edge rolled."""

    def height(u, v, u0, v0):
        turn = np.arctan2(v0 - 0.47, u0 - 0.52)
        here = np.arctan2(v - 0.47, u - 0.52)
        here = turn + (here - turn + np.pi) % (2 * np.pi) - np.pi
        part = (np.pi - here) / (2 * np.pi)
        radius = np.hypot(u - 0.52, v - 0.47)
        near = radius * radius / (radius * radius + 0.02)
        return near * (0.12 * _roll(part) - 0.3 * part) + 0.02 * np.sin(9 * u) * np.cos(7 * v)

    return _of_height("spiral ramp", size, degrees, height)


def steps(size, degrees):
    """Stairs of five steps with rolled edges beside a ramp that descends as far; the steps run out
    into the ramp."""

    def height(u, v, u0, v0):
        count, rise = 5, 0.07
        step = np.floor(v0 * count)
        side = np.clip((u - 0.15) / 0.6, 0, 1)
        fade = side * side * (3 - 2 * side)  # 0: the ramp, 1: the stairs
        ramp = v * count
        stairs = step + 0.5 * _roll(v * count - step)
        return rise * ((1 - fade) * ramp + fade * stairs) + 0.01 * np.sin(11 * u)

    return _of_height("steps", size, degrees, height)


def boxes(size, degrees):
    """Boxes that stand on a slanted plane, turned this way and that; all seen from above."""
    camera = camera_of(size, degrees)
    start, ray = _rays(size, camera)
    far = _distance(size, camera)
    up = np.array([0.0, -0.8, -0.6])  # of the plane that they stand on
    point = np.array([0.0, 0.0, far])
    depth = ((point - start) @ up) / (ray @ up)
    normals = np.broadcast_to(up, start.shape).copy()
    flat = np.array([1.0, 0.0, 0.0])
    back = np.cross(up, flat)
    for x, y, turn, side, high in [
        (-0.2, -0.2, 0.5, 0.17, 0.12),
        (0.22, -0.12, 1.1, 0.2, 0.2),
        (-0.1, 0.3, 0.3, 0.15, 0.16),
    ]:
        foot = point + flat * x * size + back * (-y) * size
        a = math.cos(turn) * flat + math.sin(turn) * back
        b = np.cross(up, a)
        enter = np.full(depth.shape, -np.inf)
        leave = np.full(depth.shape, np.inf)
        face = np.zeros_like(normals)
        for axis, low, top in ((a, -side / 2, side / 2), (b, -side / 2, side / 2), (up, -1, high)):
            along, at = ray @ axis, (start - foot) @ axis
            first, last = (low * size - at) / along, (top * size - at) / along
            nearer = np.minimum(first, last)
            out = -np.sign(along)[..., None] * axis
            face = np.where((nearer > enter)[..., None], out, face)
            enter = np.maximum(enter, nearer)
            leave = np.minimum(leave, np.maximum(first, last))
        seen = (enter < leave) & (enter < depth)
        depth = np.where(seen, enter, depth)
        normals = np.where(seen[..., None], face, normals)
    found = np.isfinite(depth) & ((depth > 0) | (camera is None)) & (depth < 6 * max(far, size))
    return Scene(
        "boxes", np.where(found, depth, np.nan), _stored(normals), found.astype(int), camera
    )


def cloth(size, degrees):
    """A sheet whose folds lie over each other, ever less towards the top."""
    camera = camera_of(size, degrees)
    many = 10 * size
    depth = np.full((size, size), np.inf)
    normals = np.zeros((size, size, 3))
    t = np.linspace(-0.8, 0.8, many)

    def place(s, t):
        grow = np.clip(t + 0.5, 0, 1) ** 2
        wave = 2 * np.pi * 3 * s
        x = s + 0.115 * grow * np.sin(wave + 1.5 * t)
        y = t + 0 * s
        z = -0.11 * (0.2 + grow) * np.cos(wave + 0.7 + 1.5 * t) + 0.05 * t
        return np.stack([x, y, z], -1)

    far = _distance(size, camera)
    e = 1e-6
    for part in np.array_split(np.linspace(-0.8, 0.8, many), 40):
        s, tt = np.meshgrid(part, t, indexing="ij")
        p = place(s, tt) * size + np.array([0, 0, far])
        across = (place(s + e, tt) - place(s - e, tt)) / (2 * e)
        along = (place(s, tt + e) - place(s, tt - e)) / (2 * e)
        n = np.cross(across, along)
        n /= np.linalg.norm(n, axis=-1, keepdims=True)
        if camera is None:
            u, v = p[..., 0] + (size - 1) / 2, p[..., 1] + (size - 1) / 2
            ray = np.broadcast_to(np.array([0.0, 0.0, 1.0]), p.shape)
        else:
            fx, fy, cx, cy = camera
            u, v = p[..., 0] / p[..., 2] * fx + cx, p[..., 1] / p[..., 2] * fy + cy
            ray = p
        n = np.where(np.sum(n * ray, -1, keepdims=True) > 0, -n, n)
        i, j = np.rint(u), np.rint(v)
        inside = (i >= 0) & (i < size) & (j >= 0) & (j < size)
        i, j = i[inside].astype(int), j[inside].astype(int)
        # To the middle of the pixel, along the tangent plane.
        pixel = np.stack([i - (size - 1) / 2, j - (size - 1) / 2, 0 * i], -1).astype(float)
        q, m = p[inside], n[inside]
        if camera is None:
            z = np.sum((q - pixel) * m, -1) / m[:, 2]
        else:
            look = np.stack([(i - cx) / fx, (j - cy) / fy, 1 + 0 * i], -1)
            z = np.sum(q * m, -1) / np.sum(look * m, -1)
        good = np.abs(z - q[:, 2]) < 3
        i, j, z, m = i[good], j[good], z[good], m[good]
        order = np.argsort(-z, kind="stable")
        i, j, z, m = i[order], j[order], z[order], m[order]
        best = np.full((size, size), np.inf)
        np.minimum.at(best, (j, i), z)
        front = z == best[j, i]
        nearer = front & (z < depth[j, i])
        depth[j[nearer], i[nearer]] = z[nearer]
        normals[j[nearer], i[nearer]] = m[nearer]
    seen = np.isfinite(depth)
    depth = np.where(seen, depth, np.nan)
    return Scene("folded cloth", depth, _stored(normals), seen.astype(int), camera)


def all_scenes(size, degrees):
    """Every scene at this size and field of view (0: orthographic)."""
    return [
        spheres(size, degrees, False),
        spheres(size, degrees, True),
        boxes(size, degrees),
        spiral(size, degrees),
        steps(size, degrees),
        cloth(size, degrees),
    ]


def aligned(found, scene, pieces=None):
    """The depth found, shifted (orthographic) or scaled (perspective) to fit; each piece by itself
    if they are given."""
    out = np.array(found, float)
    pieces = scene.mask.astype(int) if pieces is None else pieces
    for piece in np.unique(pieces[pieces > 0]):
        at = pieces == piece
        if scene.camera is None:
            out[at] += np.median(scene.depth[at] - out[at])
        else:
            out[at] *= np.median(scene.depth[at] / out[at])
    return out


def error(found, scene, pieces=None):
    """The mean depth error, in pixels (perspective: of the plane in the middle of the scene)."""
    return float(np.mean(np.abs(aligned(found, scene, pieces) - scene.depth)[scene.mask]))


def ranks(confidence, errors, worst=0.1):
    """AUC: how likely a texel of the worst tenth of errors has less confidence than another."""
    order = np.argsort(confidence, kind="stable")
    rank = np.empty(order.size)
    rank[order] = np.arange(order.size)
    values, first, counts = np.unique(
        np.asarray(confidence)[order], return_index=True, return_counts=True
    )
    del values
    mean = np.repeat(first + (counts - 1) / 2, counts)
    rank[order] = mean
    bad = errors > np.quantile(errors, 1 - worst)
    n, m = bad.sum(), (~bad).sum()
    if n == 0 or m == 0:
        return 1.0
    return float((rank[~bad].sum() - m * (m - 1) / 2) / (n * m))
