# SPDX-License-Identifier: MIT
"""ntp_depth_from_normals on numpy arrays, and least squares of the same equations by dense algebra."""

import numpy as np

from support import libntp_ffi as ntp


def find_depth(
    normals, encoding=ntp.VECTOR, y=ntp.UP, mask=None, camera=None, start=None, sure=True, **how
):
    """(depth, confidence, result): float32 arrays, and the result as a dict.  sure: find the
    confidence, too."""
    h, w = normals.shape[:2]
    depth, confidence = np.zeros((h, w), np.float32), np.zeros((h, w), np.float32)
    keep = {}
    if mask is not None:
        keep["mask"] = ntp.view(mask, ntp.HEIGHT, const=True)
    if start is not None:
        keep["start"] = ntp.view(start, ntp.HEIGHT, const=True)
    options = {"camera": dict(zip(("fx", "fy", "cx", "cy"), camera or (0,) * 4, strict=True))}
    memory = ntp.aligned(ntp.lib.ntp_depth_scratch_size(w, h), 64)
    result = ntp.ffi.new("ntp_depth_result *")
    ntp.check(
        ntp.lib.ntp_depth_from_normals(
            ntp.view(depth, ntp.HEIGHT),
            ntp.view(confidence, ntp.HEIGHT) if sure else ntp.ffi.NULL,
            ntp.view(normals, encoding, y, const=True),
            ntp.ffi.new("ntp_depth_options *", {**options, **keep, **how}),
            ntp.ffi.cast("void *", memory.__array_interface__["data"][0]),
            memory.size,
            ntp.ffi.NULL,
            result,
        )
    )
    return depth, confidence, ntp.fields(result)


def equations(normals, camera=None):
    """(A, b) of all one-sided equations, none masked: first those with the texel after each along x,
    then before it, then the same down the picture.  Equations that leave the picture are 0 = 0."""
    h, w = normals.shape[:2]
    v, u = np.mgrid[:h, :w].astype(float)
    x, y, z = np.moveaxis(normals.astype(float), -1, 0)
    view = [z, z]
    if camera:
        fx, fy, cx, cy = camera
        facing = z - x * (u - cx) / fx + y * (v - cy) / fy
        view = [fx * facing, fy * facing]
    rise = [x, -y]
    index = np.arange(h * w).reshape(h, w)
    blocks, wanted = [], []
    for axis in (1, 0):
        for step in (1, -1):
            a, b = np.zeros((h * w, h * w)), np.zeros(h * w)
            for i in index.flat:
                j, n = divmod(i, w), (h, w)[axis]
                at = j[axis] + step
                if 0 <= at < n:
                    other = i + step * (1 if axis == 1 else w)
                    a[i, other] = step * view[1 - axis].flat[i]
                    a[i, i] = -step * view[1 - axis].flat[i]
                    b[i] = rise[1 - axis].flat[i]
            blocks.append(a)
            wanted.append(b)
    return blocks, wanted


def by_shares(blocks, wanted, shares, trust=(1, 1, 1, 1)):
    """The depth, mean 0, of weighted least squares: shares along x and down."""
    weights = [shares[0], 1 - shares[0], shares[1], 1 - shares[1]]
    weights = [w * t for w, t in zip(weights, trust, strict=True)]
    normal = sum(a.T @ (w[:, None] * a) for a, w in zip(blocks, weights, strict=True))
    right = sum(a.T @ (w * b) for a, w, b in zip(blocks, weights, wanted, strict=True))
    z = np.linalg.lstsq(normal, right, rcond=1e-14)[0]
    return z - z.mean()


def shares_of(blocks, z, k):
    """Of the equations with the texel after each."""
    after_x, before_x, after_y, before_y = (a @ z for a in blocks)
    return [
        1 / (1 + np.exp(-k * (before_x**2 - after_x**2))),
        1 / (1 + np.exp(-k * (before_y**2 - after_y**2))),
    ]


def ends_of(blocks, wanted, number, w, least):
    """Of one block: where its equations are, the other texel of each, and both their views and slopes."""
    a = blocks[number]
    index, there = np.arange(len(a)), (np.abs(a) > 0).any(1)
    other = np.where(there, index + (1, -1, w, -w)[number], index)
    view = np.abs(a[index, index])
    back = np.where(there, np.abs(blocks[number ^ 1][other, other]), view)
    views = np.maximum([view, back], least)
    slopes = np.stack([wanted[number], wanted[number ^ 1][other]]) / views
    return there, other, views, slopes


def wanted_of_means(blocks, wanted, w, focal=1, steep=0.05):
    """The right-hand sides with the mean slope of both texels instead of one's own."""
    out = []
    for number, a in enumerate(blocks):
        there, _, _, slopes = ends_of(blocks, wanted, number, w, steep * focal)
        out.append(np.where(there, np.abs(np.diag(a)) * slopes.mean(0), 0))
    return out


def bends_that_tell(normals, bend=0.07, many=0.125, sharp=0.3, tile=8):
    """Of each texel: the distance of normals that halves the trust in a pair.  It is greater where bends
    abound in the tile and those around it."""
    h, w = normals.shape[:2]
    bends, pairs = np.zeros((2, -(-h // tile) + 2, -(-w // tile) + 2))
    for axis in (0, 1):
        square = np.sum(np.diff(normals.astype(float), axis=axis) ** 2, -1)
        y, x = np.indices(square.shape) // tile + 1
        np.add.at(bends, (y, x), square / (square + sharp**2))
        np.add.at(pairs, (y, x), 1)
    around = [
        sum(
            a[1 + y : a.shape[0] - 1 + y, 1 + x : a.shape[1] - 1 + x]
            for y in (-1, 0, 1)
            for x in (-1, 0, 1)
        )
        for a in (bends, pairs)
    ]
    wide = bend * (1 + (around[0] / (1 + around[1]) / many) ** 2)
    return np.repeat(np.repeat(wide, tile, 0), tile, 1)[:h, :w]


def trust_of(blocks, wanted, normals, z, focal=1, far=0.03):
    """Of all equations where the rounds end, by the normals of both texels and by the depth."""
    h, w = normals.shape[:2]
    index, flat, out = np.arange(h * w), normals.reshape(-1, 3).astype(float), []
    wide = bends_that_tell(normals).ravel()
    for number, a in enumerate(blocks):
        there, other, (view, back), slopes = ends_of(blocks, wanted, number, w, 0.002 * focal)
        step = a @ z / np.where(there, view, 1)
        off = np.maximum(np.maximum(step - slopes.max(0), slopes.min(0) - step), 0)
        off *= np.minimum(view, back) ** 2 / focal / far
        bends = np.sum((flat - flat[other]) ** 2, -1) / wide[np.minimum(index, other)] ** 2
        out.append(np.where(there, 1 / (1 + bends) / (1 + off * off), 0))
    return out
