# SPDX-License-Identifier: MIT
"""Heightfield -> normals by the library, and draws of what it is asked, for its tests."""

import numpy as np

from . import libntp_ffi as ntp
from . import oracle_height as model

SCALES = [0.0, 1.0, 2.0, -4.0, 0.1, 16.5, 255.0, 510.0, 1e-30, 1e30, 3.3e-5, 1e300, 5e-324]


def options(kernel="central", source="red", **how):
    how.setdefault("scale", 1.0)
    how["kernel"] = model.NAMES.index(kernel)
    how["source"] = model.SOURCES[source]
    return ntp.ffi.new("ntp_normals_options *", how)


def from_height(src, encoding=ntp.STANDARD, y=ntp.UP, dst=np.uint8, out=None, area=None,
                channels=3, **how):  # fmt: skip
    """(normals, texels that took the exact path, texels that are not finite)."""
    if out is None:
        out = np.zeros((*src.shape[:2], channels), dst)
    counts = ntp.ffi.new("ntp_normals_counts *")
    view = ntp.view(src, ntp.HEIGHT, const=True)
    status = ntp.lib.ntp_normals_from_height(
        ntp.view(out, encoding, y), view, options(**how), counts, ntp.rect(area)
    )
    ntp.check(status)
    return out, counts.exact, counts.not_finite


def random_heights(rng, shape, dtype):
    if dtype == np.float32:
        return rng.random(shape).astype(np.float32)
    top = np.iinfo(dtype).max
    if rng.integers(3) == 0:  # small steps: slopes near 0
        return rng.integers(top // 2, top // 2 + 4, shape).astype(dtype)
    return rng.integers(0, top + 1, shape).astype(dtype)


def random_how(rng):
    """Options for both, as one dict: those of the model."""
    return {
        "scale": float(rng.choice(SCALES)) if rng.integers(2) else float(rng.normal() * 20),
        "dx": float(rng.choice([1, 1, 2, 0.3])),
        "dy": float(rng.choice([1, 1, 0.5, 0.7])),
        "min_z": float(rng.choice([0, 0, 0, 0.1, 0.5, 0.9, 1, 1e-5, 1e-200])),
        "invert": bool(rng.integers(2)),
        "nearest": bool(rng.integers(2)),
        "y_down": bool(rng.integers(2)),
        "zz": bool(rng.integers(2)),
        "xy": rng.integers(5) == 0,
        "dst": [np.uint8, np.uint16][rng.integers(2)],
    }


def both(src, how, **more):
    """(ours, the model's)."""
    how = {**how, **more}
    expected = model.normals(src, **how)
    how["blue"] = int(how.pop("nearest", False))
    how["y"] = int(how.pop("y_down", False))
    how["invert"] = int(how.get("invert", False))
    zz, xy = how.pop("zz", False), how.pop("xy", False)
    how["encoding"] = ntp.XY if xy else ntp.ZZERO if zz else ntp.STANDARD
    return from_height(src, **how)[0], expected
