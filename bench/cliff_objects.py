# SPDX-License-Identifier: MIT
"""Made objects with cliffs, by chance, as photometric stereo sees them: for bench_cliffs.py.

Settings of depth were chosen on seeds 1 and 3.  Solids are given by a signed distance, or about one;
rays walk until they meet the surface.  Lengths are in widths of the picture; y is
down and z away from the viewer, as in cliff_scenes.
"""

import numpy as np

from support import cliff_scenes as scenes


def march(name, size, degrees, distance, depth_range=0.7):
    """The scene of the first surface of a solid that each pixel sees."""
    camera = scenes.camera_of(size, degrees)
    start, ray = scenes._rays(size, camera)
    far = 0.0 if camera is None else camera[0] / size
    start, ray = (start / size).reshape(-1, 3), ray.reshape(-1, 3)
    t = np.full(len(ray), far - depth_range)
    live = np.arange(len(ray))
    for _ in range(400):
        p = start[live] + t[live, None] * ray[live]
        d = distance(p - [0, 0, far])
        t[live] += 0.6 * d / np.linalg.norm(ray[live], axis=-1)
        live = live[(np.abs(d) > 1e-7) & (t[live] < far + depth_range)]
        if not len(live):
            break
    p = start + t[:, None] * ray
    q = p - [0, 0, far]
    hit = (t < far + depth_range) & (np.abs(distance(q)) < 1e-4)
    e = 1e-5
    normal = np.stack([distance(q + e * axis) - distance(q - e * axis) for axis in np.eye(3)], -1)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-30)
    hit &= np.sum(normal * ray, -1) < -1e-3
    depth = np.where(hit, p[:, 2] * size, np.nan).reshape(size, size)
    normal = np.where(hit[:, None], normal, np.nan).reshape(size, size, 3)
    return with_pieces(
        scenes.Scene(
            name, depth, scenes._stored(normal), hit.reshape(size, size).astype(int), camera
        )
    )


def slopes(scene):
    """Depth (with a camera: focal times its logarithm) and its slopes along x and down, by normals."""
    h, w = scene.depth.shape
    v, u = np.mgrid[:h, :w].astype(float)
    x, y, z = np.moveaxis(scene.normals, -1, 0)
    if scene.camera is None:
        return scene.depth, x / z, -y / z
    fx, fy, cx, cy = scene.camera
    d = z - x * (u - cx) / fx + y * (v - cy) / fy
    return fx * np.log(scene.depth), x / d, -y / d * fx / fy


def hangs(scene, axis, most):
    """True where a pixel and the next one along the axis are no cliff: depth changes by as much as the
    slope of either pixel, or by something between the two."""
    z, *slope = slopes(scene)
    s = slope[1 - axis]
    first = [slice(None)] * 2
    after = [slice(None)] * 2
    first[axis], after[axis] = slice(None, -1), slice(1, None)
    first, after = tuple(first), tuple(after)
    step, low, high = (
        z[after] - z[first],
        np.minimum(s[first], s[after]),
        np.maximum(s[first], s[after]),
    )
    off = np.maximum(step - high, low - step)
    with np.errstate(invalid="ignore"):
        sharp = np.abs(scene.normals[first] - scene.normals[after]).max(-1) > 0.3
        mean = (s[first] / (1 + s[first] ** 2) + s[after] / (1 + s[after] ** 2)) / (
            1 / (1 + s[first] ** 2) + 1 / (1 + s[after] ** 2)
        )
        far = sharp & (np.abs(step - mean) > 1.5)
        return (off < most) & ~far & scene.mask[first] & scene.mask[after]


def with_pieces(scene, most=0.5):
    """Pieces: what hangs together by pixels that touch by their sides, cliffs left out."""
    h, w = scene.depth.shape
    label = np.where(scene.mask, np.arange(h * w).reshape(h, w) + 1, 0)
    across, down = hangs(scene, 1, most), hangs(scene, 0, most)
    big = h * w + 1
    while True:
        before = label.copy()
        for _ in range(8):
            for a, b, joined in (
                (label[:, :-1], label[:, 1:], across),
                (label[:-1], label[1:], down),
            ):
                least = np.where(joined, np.minimum(a, b), big)
                np.minimum(a, least, out=a)
                np.minimum(b, least, out=b)
            flat = label.ravel()  # and on to the label of the label
            label[...] = np.where(flat > 0, flat[flat - 1], 0).reshape(h, w)
        if (label == before).all():
            break
    names = np.unique(label[label > 0])
    pieces = np.where(label > 0, np.searchsorted(names, label) + 1, 0)
    return scenes.Scene(scene.name, scene.depth, scene.normals, pieces, scene.camera)


def smooth_least(a, b, width):
    h = np.clip(0.5 + 0.5 * (b - a) / width, 0, 1)
    return b + (a - b) * h - width * h * (1 - h)


def capsule(p, a, b, radius):
    along = b - a
    t = np.clip((p - a) @ along / (along @ along + 1e-12), 0, 1)
    return np.linalg.norm(p - a - t[:, None] * along, axis=-1) - radius


def ellipsoid(p, center, axes, turn):
    q = (p - center) @ turn / axes
    k0, k1 = np.linalg.norm(q, axis=-1), np.linalg.norm(q / axes, axis=-1)
    return np.where(k1 > 1e-9, k0 * (k0 - 1) / np.maximum(k1, 1e-9), -np.min(axes))


def rotation(rng):
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q


def figure(size, degrees, seed):
    """A body with limbs before it and beside it, smoothly joined."""
    rng = np.random.default_rng(1000 + seed)
    body = [rng.uniform(0.13, 0.2), rng.uniform(0.2, 0.3), rng.uniform(0.13, 0.18)]
    limbs = []
    for _ in range(int(rng.integers(3, 6))):
        turn = rng.uniform(0, 6.3)
        root = np.array(
            [0.7 * body[0] * np.cos(turn), 0.8 * body[1] * np.sin(turn), rng.uniform(-0.12, 0.05)]
        )
        elbow = root * rng.uniform(1.2, 1.6) + [0, 0, rng.uniform(-0.2, -0.05)]
        hand = np.array(
            [rng.uniform(-0.25, 0.25), rng.uniform(-0.3, 0.3), rng.uniform(-0.36, -0.2)]
        )
        limbs.append((root, elbow, hand, rng.uniform(0.03, 0.055)))
    head = np.array([rng.uniform(-0.1, 0.1), -body[1] - 0.03, -0.08])
    width = rng.uniform(0.01, 0.04)

    def distance(p):
        d = ellipsoid(p, np.zeros(3), np.array(body), np.eye(3))
        d = smooth_least(d, np.linalg.norm(p - head, axis=-1) - 0.11, width)
        for root, elbow, hand, radius in limbs:
            arm = np.minimum(capsule(p, root, elbow, radius), capsule(p, elbow, hand, radius * 0.8))
            d = smooth_least(d, arm, width)
        return d

    return march(f"figure {seed}", size, degrees, distance)


def heap(size, degrees, seed):
    """Ellipsoids in a heap; each runs into another."""
    rng = np.random.default_rng(2000 + seed)
    solids = []
    for _ in range(int(rng.integers(5, 9))):
        axes = rng.uniform(0.08, 0.2, 3)
        center = rng.normal(size=3) * [0.14, 0.14, 0.12]
        solids.append((center, axes, rotation(rng)))

    def distance(p):
        return np.min([ellipsoid(p, *solid) for solid in solids], axis=0)

    return march(f"heap {seed}", size, degrees, distance)


def drop(size, degrees, seed):
    """Metaballs: balls that flow together."""
    rng = np.random.default_rng(3000 + seed)
    balls = [(rng.normal(size=3) * [0.16, 0.16, 0.16], rng.uniform(0.06, 0.12)) for _ in range(9)]
    width = rng.uniform(0.04, 0.1)

    def distance(p):
        d = np.full(len(p), 9.0)
        for center, radius in balls:
            d = smooth_least(d, np.linalg.norm(p - center, axis=-1) - radius, width)
        return d

    return march(f"drops {seed}", size, degrees, distance)


def knot(size, degrees, seed):
    """A tube along a knot, over and under itself."""
    rng = np.random.default_rng(4000 + seed)
    turn = rotation(rng) if seed > 1 else np.eye(3)
    s = np.linspace(0, 2 * np.pi, 160, endpoint=False)
    curve = np.stack(
        [np.sin(s) + 2 * np.sin(2 * s), np.cos(s) - 2 * np.cos(2 * s), -1.2 * np.sin(3 * s)], -1
    )
    curve = 0.11 * curve @ turn
    radius = rng.uniform(0.05, 0.08)

    def distance(p):
        d = np.full(len(p), 9.0)
        for a, b in zip(curve, np.roll(curve, -1, 0), strict=True):
            np.minimum(d, capsule(p, a, b, radius), out=d)
        return d

    return march(f"knot {seed}", size, degrees, distance)


def goblet(size, degrees, seed):
    """A cup on a stem, seen from above; its inside is cut off by the rim."""
    rng = np.random.default_rng(5000 + seed)
    tilt = -rng.uniform(0.2, 0.5)
    c, s = np.cos(tilt), np.sin(tilt)
    turn = np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    wide, high, thick = rng.uniform(0.18, 0.25), rng.uniform(0.15, 0.25), rng.uniform(0.012, 0.025)

    def distance(p):
        q = p @ turn
        r, y = np.hypot(q[:, 0], q[:, 2]), q[:, 1]
        bowl = np.hypot(r / wide, (y + 0.15) / high)
        shell = np.abs((bowl - 1) * min(wide, high)) - thick
        shell = np.maximum(shell, -(y + 0.2))
        stem = np.maximum(r - 0.03, np.maximum(y - 0.32, 0.0 - y))
        foot = np.hypot(r / 0.15, (y - 0.33) / 0.03)
        foot = (foot - 1) * 0.03
        d = smooth_least(shell, stem, 0.03)
        return 0.7 * smooth_least(d, foot, 0.02)

    return march(f"goblet {seed}", size, degrees, distance)


def draped(size, degrees, seed):
    """A bust in a garment of deep folds, some of which hang over."""
    rng = np.random.default_rng(6000 + seed)
    waves = [
        (rng.normal(size=3) * [16, 6, 4], rng.uniform(0, 6.3), rng.uniform(0.01, 0.025))
        for _ in range(4)
    ]
    head = np.array([rng.uniform(-0.05, 0.05), -0.27, -0.1])

    def distance(p):
        d = ellipsoid(p, np.array([0, 0.05, 0.0]), np.array([0.27, 0.3, 0.2]), np.eye(3))
        for k, phase, high in waves:
            d = d + high * np.sin(p @ k * 1.6 + phase + 1.5 * np.sin(5 * p[:, 1] + phase))
        return 0.45 * smooth_least(d, np.linalg.norm(p - head, axis=-1) - 0.13, 0.02)

    return march(f"draped {seed}", size, degrees, distance)


def scales(size, degrees, seed):
    """Scales that grow out of the ground and stand off at their tips."""
    rng = np.random.default_rng(7000 + seed)
    plates = []
    for i in range(3):
        for j in range(3):
            plates.append(
                (
                    0.2 + 0.3 * i + rng.uniform(-0.05, 0.05),
                    0.2 + 0.3 * j + rng.uniform(-0.05, 0.05),
                    rng.uniform(0.08, 0.13),
                    rng.uniform(0, 6.3),
                    rng.uniform(0.03, 0.1),
                )
            )

    def height(u, v, u0, v0):
        h = 0.03 * np.sin(5 * u + 1) * np.cos(6 * v) - 0.15 * v
        for x, y, radius, turn, high in plates:
            a = ((u - x) * np.cos(turn) + (v - y) * np.sin(turn)) / radius
            b = (-(u - x) * np.sin(turn) + (v - y) * np.cos(turn)) / radius
            a0 = ((u0 - x) * np.cos(turn) + (v0 - y) * np.sin(turn)) / radius
            b0 = (-(u0 - x) * np.sin(turn) + (v0 - y) * np.cos(turn)) / radius
            rise = np.clip(a + 1, 0, None) ** 2 / 4 * (1 - 0.3 * b * b)
            side = np.clip(1 - b * b, 0, None) ** 1.0
            h = h - np.where((a0 * a0 + b0 * b0 < 1), high * rise * side, 0)
        return h

    return with_pieces(scenes._of_height(f"scales {seed}", size, degrees, height))


def spiral(size, degrees, seed):
    """A ramp around a column, its cliff bent."""
    rng = np.random.default_rng(8000 + seed)
    x0, y0 = rng.uniform(0.35, 0.65, 2)
    bend, high, roll = rng.uniform(-3, 3), rng.uniform(0.15, 0.4), rng.uniform(0, 0.15)
    waves, sign = rng.uniform(5, 12, 2), rng.choice([-1, 1])

    def height(u, v, u0, v0):
        def angle(u, v):
            return np.arctan2(v - y0, u - x0) + bend * np.hypot(u - x0, v - y0)

        turn = (angle(u0, v0) + np.pi) % (2 * np.pi) - np.pi
        here = angle(u, v)
        here = turn + (here - turn + np.pi) % (2 * np.pi) - np.pi
        part = (np.pi - here) / (2 * np.pi)
        radius = np.hypot(u - x0, v - y0)
        near = radius * radius / (radius * radius + 0.02)
        return sign * near * (roll * scenes._roll(part) - high * part) + 0.02 * np.sin(
            waves[0] * u
        ) * np.cos(waves[1] * v)

    return with_pieces(scenes._of_height(f"spiral {seed}", size, degrees, height))


KINDS = (figure, heap, drop, knot, goblet, draped, scales, spiral)
