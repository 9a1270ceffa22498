# SPDX-License-Identifier: MIT
"""Normals -> heights by weighted least squares, by the library."""

import numpy as np

from . import libntp_ffi as ntp
from . import oracle_height as heights
from . import oracle_reconstruct as model
from .to_height import UNORM

WEIGHTED = 4
INSIDE, INSIDE_X, INSIDE_Y = 2, 3, 4  # NTP_RESIDUAL_INSIDE and those for one axis
STORED, DERIVED = 1, 2
KERNELS = [*heights.NAMES, model.BAKED]


def weighted(src, encoding=ntp.STANDARD, y=ntp.UP, hooks=None, mask=None, status=ntp.OK, **how):
    """(heights, result as a dict)."""
    h, w = src.shape[:2]
    how["kernel"] = KERNELS.index(how.get("kernel", "central"))
    how = {"method": WEIGHTED, "decode": UNORM, "z": STORED, **how}
    chosen = ntp.ffi.new("ntp_height_options *", how)
    mask_view = ntp.ffi.NULL if mask is None else ntp.view(mask, ntp.HEIGHT, const=True)
    chosen.mask = mask_view
    size = ntp.lib.ntp_height_scratch_size(chosen, w, h, hooks.parts if hooks else 1)
    scratch = ntp.aligned(max(size, 1), 64)
    scratch[:] = 255  # NaN
    dst = np.full((h, w), np.nan, np.float32)
    result = ntp.ffi.new("ntp_height_result *")
    done = ntp.lib.ntp_height_from_normals(
        ntp.view(dst, ntp.HEIGHT),
        ntp.view(src, encoding, y, const=True),
        chosen,
        ntp.ffi.cast("void *", scratch.__array_interface__["data"][0]),
        size,
        hooks or ntp.ffi.NULL,
        result,
    )
    assert done == status
    return dst, ntp.fields(result)


def near(ours, oracle, tolerance=1e-5):
    return np.abs(ours - oracle).max() <= tolerance * max(np.ptp(oracle), 1e-3)
