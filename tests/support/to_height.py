# SPDX-License-Identifier: MIT
"""Normals -> heights and back by the library, and a model of it in dense float64 least squares.

The model writes every stencil as a matrix, out of the taps and borders of oracle_height, and
solves by singular values (small sizes) or by the eigenvectors of the two axes (large ones).
"""

import functools

import numpy as np

from . import libntp_ffi as ntp
from . import oracle_height as heights

AUTO, TELESCOPING, FRANKOT_CHELLAPPA, POISSON_DCT = range(4)
DECODE_AUTO, UNORM, NEUTRAL, TRUNC, SNORM = range(5)
Z_AUTO, STORED, DERIVED = range(3)
WRAP, CLAMP, MIRROR, EXTRAPOLATE, REPEAT_SLOPE = range(5)
KERNELS = ["central", "forward"]


def options(kernel="central", border_x=WRAP, border_y=WRAP, **how):
    number = heights.NAMES.index(kernel) if isinstance(kernel, str) else kernel
    how = {"kernel": number, "border_x": border_x, "border_y": border_y, "z": STORED, **how}
    return ntp.ffi.new("ntp_height_options *", how)


def serial_hooks(parts, **callbacks):
    hooks = ntp.ffi.new("ntp_hooks *", {"parts": parts})
    for name, callback in callbacks.items():
        setattr(hooks, name, callback)
    return hooks


def to_height(src, encoding=ntp.STANDARD, y=ntp.UP, hooks=None, **how):
    """(heights, result as a dict)."""
    h, w = src.shape[:2]
    parts = hooks.parts if hooks else 1
    chosen = options(**how)
    size = ntp.lib.ntp_height_scratch_size(chosen, w, h, parts)
    scratch = ntp.aligned(max(size, 1), 64)
    where = ntp.ffi.cast("void *", scratch.__array_interface__["data"][0])
    dst = np.full((h, w), np.nan, np.float32)
    result = ntp.ffi.new("ntp_height_result *")
    ntp.check(
        ntp.lib.ntp_height_from_normals(
            ntp.view(dst, ntp.HEIGHT),
            ntp.view(src, encoding, y, const=True),
            chosen,
            where,
            size,
            hooks or ntp.ffi.NULL,
            result,
        )
    )
    return dst, ntp.fields(result)


def bumps(size, count=5):
    """Round bumps on ground that is exactly flat."""
    y, x = np.mgrid[:size, :size]
    rng = np.random.default_rng(5)
    h = np.zeros((size, size))
    for _ in range(count):
        at, radius = rng.uniform(14, size - 14, 2), rng.uniform(6, 12)
        inside = 1 - ((x - at[0]) ** 2 + (y - at[1]) ** 2) / radius**2
        h = np.maximum(h, radius / 2 * np.maximum(inside, 0) ** 2)
    return h


def bricks(size):
    """Bricks of 48 x 24 texels with beveled edges, in courses that are half a brick apart."""
    y, x = np.mgrid[:size, :size]
    x = (x + y // 24 % 2 * 24) % 48
    y = y % 24
    return np.clip(np.minimum(np.minimum(x, 47 - x), np.minimum(y, 23 - y)) - 1.0, 0, 3)


def from_height(h, kernel="central", border_x=WRAP, border_y=WRAP, dst=np.uint8, vector=False):
    how = {"kernel": heights.NAMES.index(kernel), "border_x": border_x, "border_y": border_y}
    how = ntp.ffi.new("ntp_normals_options *", {**how, "scale": 1})
    out = np.zeros((*h.shape, 3), np.float32 if vector else dst)
    view = ntp.view(out, ntp.VECTOR if vector else ntp.STANDARD)
    h = np.ascontiguousarray(h, np.float32)
    src = ntp.view(h, ntp.HEIGHT, const=True)
    ntp.check(ntp.lib.ntp_normals_from_height(view, src, how, ntp.ffi.NULL, ntp.ffi.NULL))
    return out


def stencil(n, kernel, border):
    """The matrix of slopes along an axis of n heights, towards greater indices."""
    matrix = np.zeros((n, n))
    taps = heights.taps(kernel, False)
    for i in range(n):
        at = i
        if border == REPEAT_SLOPE:
            at = min(max(i, -min(0, *(t[0] for t in taps))), n - 1 - max(t[0] for t in taps))
            at = i if n == 1 else at
        for (offset, _), weight in taps.items():
            for index, share in heights.reflect(at + offset, n, border):
                matrix[i, index] += float(weight * share)
    return matrix / heights.KERNELS[kernel][1]


def rows_of(n, kernel, border):
    """(matrix, what it is multiplied with to take data along): the rows that are fitted."""
    d, take = stencil(n, kernel, border), np.eye(n)
    if kernel == "forward" and border in (MIRROR, EXTRAPOLATE, REPEAT_SLOPE) and n > 1:
        take[n - 2, n - 2] = 0.5
        take[n - 2, n - 1] = -0.5 if border == MIRROR else 0.5
        take[n - 1] = 0
    elif kernel == "central" and border == EXTRAPOLATE:
        take[0, 0] = take[n - 1, n - 1] = 0.5
    return take @ d, take


def edge(h, p, q, dx, dy):
    """Changes of the two columns at the left: the least squares, the other heights held."""
    n = h.shape[0]
    rest_x, rest_y = (p - h @ dx.T)[:, :3], (q - dy @ h)[:, :2]
    inward, along = dx[:3, :2], dy
    matrix = np.kron(np.eye(n), inward.T @ inward) + np.kron(along.T @ along, np.eye(2))
    data = rest_x @ inward + along.T @ rest_y
    return np.linalg.solve(matrix, data.ravel()).reshape(n, 2)


def with_edges(h, p, q, kernel, borders, spacing=(1, 1)):
    """What central slopes with extrapolated borders have besides: edges with full weights."""
    h = h.copy()
    dx, dy = (stencil(n, kernel, b) for n, b in zip(h.shape[::-1], borders, strict=True))
    dx, dy = dx / spacing[0], dy / spacing[1]
    sides = [(kernel, b, n >= 4) for b, n in zip(borders, h.shape[::-1], strict=True)]
    across, down = (side == ("central", EXTRAPOLATE, True) for side in sides)
    if across:
        h[:, :2] += edge(h, p, q, dx, dy)
        h[:, :-3:-1] += edge(h[:, ::-1], -p[:, ::-1], q[:, ::-1], -dx[::-1, ::-1], dy)
    if down:
        h[:2] += edge(h.T, q.T, p.T, dy, dx).T
        h[:-3:-1] += edge(h[::-1].T, -q[::-1].T, p[::-1].T, -dy[::-1, ::-1], dx).T
    return h - h.mean() if across or down else h


def least_norm(p, q, kernel, border_x, border_y):
    """The heights whose slopes come nearest to p, right, and q, down."""
    h, w = p.shape
    dx, take_x = rows_of(w, kernel, border_x)
    dy, take_y = rows_of(h, kernel, border_y)
    matrix = np.vstack([np.kron(np.eye(h), dx), np.kron(dy, np.eye(w))])
    data = np.concatenate([(p @ take_x.T).ravel(), (take_y @ q).ravel()])
    heights = np.linalg.lstsq(matrix, data, rcond=1e-11)[0].reshape(h, w)
    return with_edges(heights, p, q, kernel, (border_x, border_y))


@functools.lru_cache(maxsize=16)
def eigenvectors(n, kernel, border, spacing):
    """rows_of with this spacing, and what the squares of these rows have for an axis."""
    d, take = rows_of(n, kernel, border)
    d = d / spacing
    return d, take, *np.linalg.eigh(d.T @ d)


def by_eigenvectors(p, q, kernel, border_x, border_y, spacing=(1, 1), edges=True):
    """The same for large sizes; edges: of extrapolated borders are fitted again."""
    h, w = p.shape
    dx, take_x, lx, vx = eigenvectors(w, kernel, border_x, spacing[0])
    dy, take_y, ly, vy = eigenvectors(h, kernel, border_y, spacing[1])
    f = p @ take_x.T @ dx + dy.T @ (take_y @ q)
    total = ly[:, None] + lx[None, :]
    null = total < 1e-11
    spectrum = np.where(null, 0, (vy.T @ f @ vx) / np.where(null, 1, total))
    solution = vy @ spectrum @ vx.T
    return with_edges(solution, p, q, kernel, (border_x, border_y), spacing) if edges else solution


def slopes(n, encoding=ntp.STANDARD, y=ntp.UP, decode=UNORM, derived=False):
    """(p right, q down) of a texture, in float64."""
    c = n.astype(np.float64)
    if n.dtype == np.float32:
        least = 1 / 65535
        v = c if encoding == ntp.VECTOR else 2 * c - 1
        z_zero = c
    else:
        m = np.iinfo(n.dtype).max
        least = 1 / m
        v = (2 * c - m) / m
        if decode == NEUTRAL:
            v[np.abs(2 * c - m) == 1] = 0
        if decode == TRUNC:
            v = (2 * c + 1 - m) / m
        if decode == SNORM:
            v = (2 * c - m - 1) / (m - 1)
            least = 1 / (m - 1)
        z_zero = c / m
    if derived or encoding == ntp.XY:
        z = np.sqrt(np.maximum(1 - v[..., 0] ** 2 - v[..., 1] ** 2, 0))
    else:
        z = z_zero[..., 2] if encoding == ntp.ZZERO else v[..., 2]
        if decode == NEUTRAL and encoding != ntp.ZZERO:
            z = (2 * c[..., 2] - m) / m
    z = np.maximum(z, least)
    return -v[..., 0] / z, (v[..., 1] if y == ntp.UP else -v[..., 1]) / z


def mixed_slopes(c):
    """By a z of which the stored one is the share x^2 + y^2, and the derived one the rest."""
    v = (2 * c.astype(np.float64) - 255) / 255
    square = np.minimum(v[..., 0] ** 2 + v[..., 1] ** 2, 1)
    derived = np.sqrt(np.maximum(1 - square, 1 / 255**2))
    negative = v[..., 2][v[..., 2] < -1 / 255]
    least = 2 * np.sqrt((negative**2).sum() / (negative.size + 8))
    z = np.maximum(square * v[..., 2] + (1 - square) * derived, max(least, 1 / 255))
    return -v[..., 0] / z, v[..., 1] / z


def lean(n):
    """What flat ground adds to the mean levels of red and green: the pile of levels around zero."""
    seen = 2.0 * n[:, ::4, :2].reshape(-1, 2) - 255  # of every fourth texel
    far = np.abs(seen).max(1) / 2
    best, found = 0.1, np.zeros(2)
    for size in (1, 2, 4):
        inside, middle, outside = ((far < k * size).mean() for k in (1, 2, 3))
        around = (outside - middle) / (36 - 16)  # a square of size x size
        share = middle - 16 * around
        if inside >= 4 * 4 * around and share > best:
            best = share
            found = (seen * (far < 2 * size)[:, None]).mean(0) / 2
            found *= np.abs(found).max() <= 0.75 * share  # on purpose
            found = np.clip(found, -share / 2, share / 2)
            found[np.abs(found) < 0.1] = 0
    return found


def near(ours, model, tolerance=2e-6):
    scale = max(np.ptp(model), np.abs(model).max(), 1e-3)
    return np.abs(ours - model).max() <= tolerance * scale


def vectors_of(p, q):
    n = np.stack([-p, q, np.ones_like(p)], axis=-1)
    return (n / np.linalg.norm(n, axis=-1, keepdims=True)).astype(np.float32)


def random_vectors(rng, shape, steepness=1.0):
    return vectors_of(*(rng.normal(size=(2, *shape)) * steepness))


def fractal(n, seed=1, rms_slope=0.7, exponent=2.5, width=None):
    """A periodic heightfield with a spectrum of 1/f^exponent, heights in texels; n is its height,
    and its width as well unless one is given."""
    width = width or n
    rng = np.random.default_rng(seed)
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(width), np.fft.fftfreq(n)))
    f[0, 0] = np.inf
    h = np.fft.ifft2(np.fft.fft2(rng.normal(size=(n, width))) * f**-exponent).real
    dx, dy = np.roll(h, -1, 1) - h, np.roll(h, -1, 0) - h
    slope = np.sqrt(np.mean(dx * dx + dy * dy))
    return (h * (rms_slope / slope)).astype(np.float32)


def ramp_and_bumps(n):
    """Not periodic."""
    y, x = np.mgrid[:n, :n] / n
    h = 0.3 * n * x - 0.2 * n * y
    for cx, cy, r in [(0.3, 0.3, 0.1), (0.7, 0.4, 0.06), (0.5, 0.8, 0.15)]:
        h = h + 0.4 * n * r * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (r * r))
    return h.astype(np.float32)
