# SPDX-License-Identifier: MIT
"""The test oracle for measurements: the fields of ntp_stats computed in numpy from the texels."""

import numpy as np

from . import oracle

STEEP = 8


def levels_of(array):
    """Integer levels (n, c) and M that an image is judged at; M of the samples."""
    if array.dtype == np.float32:
        wide = np.clip(np.floor(array.astype(np.float64) * 65535 + 0.5), 0, 65535)
        levels, stored = wide.astype(np.int64), 65535
    else:
        levels, stored = array.astype(np.int64), int(np.iinfo(array.dtype).max)
    levels = levels.reshape(-1, levels.shape[-1])
    if stored == 65535 and np.all(levels % 257 == 0):
        return levels // 257, 255, stored
    return levels, stored, stored


def judged_of(r, g, m, used):
    """The used texels that the classifier looks at: red and green both within 15 levels of 8 bit
    from an end are padding.  It counts where fewer than a sixteenth would be left."""
    red, green = (c if m == 255 else (c + 128) // 257 for c in (r, g))
    ends = [(c < 16) | (c > 239) for c in (red, green)]
    left = used & ~(ends[0] & ends[1])
    return left if 16 * left.sum() >= used.sum() else used


def fit(r, g, b, m, zz, used):
    """The fields of ntp_fit."""
    flags = oracle.flags(r, g, b, m, zz)
    inside = oracle.radicands(r, g, m) >= 0
    x, y = (2 * r - m) / m, (2 * g - m) / m
    z = b / m if zz else (2 * b - m) / m
    length = np.sqrt(x * x + y * y + z * z)
    out = {"flags": flags, "length": length}
    for name, bit in (("neighbor", 1), ("rounded", 2), ("exact", 4)):
        out[name] = np.count_nonzero(flags & bit)
        out["unused_" + name] = np.count_nonzero((flags & bit > 0) & ~used)
    want = oracle.derived_blues(r, g, m, zz)
    out["exact_mirrored"] = 0 if zz else np.count_nonzero(inside & (b == m - want))
    off = np.abs(b - np.where((b <= (m - 1) // 2) & (not zz), m - want, want))
    out["off"] = np.where(inside, off, -1)
    out["used_levels_le"] = [np.count_nonzero(inside & used & (off <= i)) for i in range(4)]
    out["length_min"], out["length_max"] = length.min(), length.max()
    out["length_mean"] = length.mean()
    used = judged_of(r, g, m, used)
    if used.any():
        out["used_length_mean"] = length[used].mean()
        out["used_length_sd"] = length[used].std()
        bad = used & (flags & 2 == 0)
        out["used_short"] = np.count_nonzero(bad & (length < 1)) / used.sum()
        out["used_long"] = np.count_nonzero(bad & (length > 1)) / used.sum()
    return out


def harm_kinds(r, g, b, m, zz, xy):
    """How each texel is wrong beyond rounding: 0 its length, 1 red and green, 2 z; -1: it is not."""
    near = [np.maximum(abs(2 * c - m) - 2, 1) for c in (r, g)]
    pair = near[0] ** 2 + near[1] ** 2 > m * m
    length = np.full(len(r), False) if xy else ~oracle.in_shell(r, g, b, m, zz, 2)
    below = (b < m // 2) & (not zz and not xy)
    return np.where(below, 2, np.where(pair, 1, np.where(length, 0, -1)))


def block_steps(array, m):
    """Mean |step| across columns 8k-1|8k over that elsewhere, for each of three channels."""
    step = np.abs(np.diff(array[..., :3].astype(np.float64), axis=1))
    across = np.arange(1, array.shape[1]) % 8 == 0
    means = [step[:, c].mean((0, 1)) if c.any() else np.zeros(3) for c in (across, ~across)]
    return np.where(means[1] > 0, means[0] / np.where(means[1] > 0, means[1], 1), 0)


def measure(array, encoding_is_zzero=False, touch=0, xy=False):
    """A dict with the fields of ntp_stats; arrays of texels under names of their own."""
    levels, m, stored = levels_of(array)
    r, g = levels[:, 0], levels[:, 1]
    b = levels[:, 2] if levels.shape[1] > 2 else np.where(r + g > 0, m, 0)  # black stays black
    rgb = np.stack([r, g, b], 1)
    channels = levels.shape[1]
    alpha = levels[:, 3] if channels == 4 else np.full(len(levels), m)
    black = np.all(levels[:, :3] == 0, 1) & (not touch & 1)
    white = np.all(levels[:, :3] == m, 1) & (not touch & 2) & ~black
    clear = (alpha == 0) & (not touch & 4) & ~black & ~white
    used = ~(black | white | clear)
    s = {"texels": len(levels), "max": m, "stored_max": stored, "channels": channels}
    s |= {"black": black.sum(), "white": white.sum(), "transparent": clear.sum()}
    s["unused"] = np.count_nonzero(~used)
    s["channel"] = [
        {"min": c.min(), "max": c.max(), "mean": c.mean()} for c in levels.T[: min(channels, 4)]
    ]
    std, zz = fit(r, g, b, m, False, used), fit(r, g, b, m, True, used)
    s["standard"], s["zzero"] = std, zz
    over = std["flags"] & 8 > 0
    negative = std["flags"] & 16 > 0
    near = np.hypot((2 * r - m) / m, (2 * g - m) / m) <= 1.00774
    s["xy_too_long"], s["unused_xy_too_long"] = over.sum(), np.count_nonzero(over & ~used)
    s["xy_far_too_long"] = np.count_nonzero(~near)
    s["neighbor_and_near"] = np.count_nonzero(near & (std["flags"] & 1 > 0))
    s["z_negative"], s["unused_z_negative"] = negative.sum(), np.count_nonzero(negative & ~used)
    judged = judged_of(r, g, m, used)
    s["padding"] = np.count_nonzero(used & ~judged)
    s["used_z_negative"] = np.count_nonzero(negative & judged)
    s["gray"] = np.count_nonzero((r == g) & (g == b) & ~clear)
    flat = np.isin(r, ((m - 1) // 2, (m + 1) // 2)) & np.isin(g, ((m - 1) // 2, (m + 1) // 2))
    s["flat"] = np.count_nonzero(flat & used)
    s["distinct_flat"] = len(np.unique(rgb[flat & used], axis=0))
    s["distinct"] = min(2, len(np.unique(rgb[used], axis=0)))
    s["levels_off_max"] = [max(f["off"][used].max(initial=0), 0) for f in (std, zz)]
    s["alpha_zero"] = np.count_nonzero(alpha == 0) if channels == 4 else 0
    s["alpha_full"] = np.count_nonzero(alpha == m) if channels == 4 else 0
    if xy:
        cr, cg = oracle.pulled(r, g, m)
        z = np.where(over, m // 2 * 0, 2 * oracle.derived_blues(r, g, m) - m)
        z = np.where(over, 0, z)
        a = np.stack([2 * r - m, 2 * g - m, z], 1).astype(float)
        c = np.stack([2 * v - m for v in (cr, cg, oracle.derived_blues(cr, cg, m))], 1)
        cross = np.linalg.norm(np.cross(a, c), axis=1)
        degrees = np.degrees(np.arctan2(cross, (a * c).sum(1)))
    else:
        degrees = oracle.angles(r, g, b, m, encoding_is_zzero)
    degrees = degrees[used]
    s["degrees"] = degrees
    outside = np.degrees(np.hypot((2 * r - m) / m, (2 * g - m) / m) - 1)[used]
    z = (2 * b - m) / m
    mirror = np.degrees(2 * np.arctan2(np.abs(z), np.hypot((2 * r - m) / m, (2 * g - m) / m)))
    kinds = harm_kinds(r, g, b, m, encoding_is_zzero, xy)[used]
    s["harm_kinds"] = kinds
    s["harm_degrees"] = np.where(kinds == 2, mirror[used], outside if xy else degrees)
    steep = np.minimum((np.hypot((2 * r - m) / m, (2 * g - m) / m) * STEEP).astype(int), STEEP - 1)
    bins = [judged & (steep == i) for i in range(STEEP)]
    s["steepness"] = [np.count_nonzero(i) for i in bins]
    s["steepness_not_rounded"] = [np.count_nonzero(i & (std["flags"] & 2 == 0)) for i in bins]
    s["steepness_not_neighbor"] = [np.count_nonzero(i & (std["flags"] & 1 == 0)) for i in bins]
    error = np.abs(std["length"] - 1)
    s["steepness_length_error"] = [error[i].mean() if i.any() else 0 for i in bins]
    if used.any():
        s["used_mean"] = rgb[used].mean(0) / m
        parts = rgb[judged] / m
        s["judged_mean"], s["used_sd"] = parts.mean(0), parts.std(0)
        s["parts"] = parts
        s["red_low"] = np.count_nonzero(judged & (r <= (m - 1) // 2))
        s["green_low"] = np.count_nonzero(judged & (g <= (m - 1) // 2))
        close = (np.abs(r / m - 188 / 255) <= 3.001 / 255) & (
            np.abs(g / m - 188 / 255) <= 3.001 / 255
        )
        s["near_gamma_flat"] = np.count_nonzero(used & close)
        if channels == 4:
            s["ag_in_disc"] = np.mean(oracle.radicands(alpha, g, m)[used] >= 0)
    s["block_step"] = block_steps(array, m) if channels >= 3 else None
    return s
