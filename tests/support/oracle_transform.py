# SPDX-License-Identifier: MIT
"""What flips and turns do to a picture and to the components that it stores."""

import numpy as np

from . import libntp_ffi as ntp


def turned(x, y, flips, turns, y_axis):
    """The stored components after flips and clockwise turns."""
    x, y = (-x if flips[0] else x), (-y if flips[1] else y)
    for _ in range(turns):
        x, y = (y, -x) if y_axis == ntp.UP else (-y, x)
    return x, y


def moved_picture(src, flips, turns):
    out = src[:, ::-1] if flips[0] else src
    out = out[::-1] if flips[1] else out
    return np.rot90(out, -turns)


def unused_mask(src, m):
    black_or_white = np.all(src[..., :3] == 0, -1) | np.all(src[..., :3] == m, -1)
    return black_or_white | (src[..., 3] == 0) if src.shape[2] == 4 else black_or_white
