# SPDX-License-Identifier: MIT
"""ntp_relief_*: the scale that makes a heightfield's normals visible, against numpy."""

import numpy as np
import pytest

from support import libntp_ffi as ntp


def relief_of(heights, **how):
    """The counts of all rows that are measured."""
    view = ntp.view(heights, ntp.HEIGHT, const=True)
    how = ntp.ffi.new("ntp_normals_options *", how)
    relief, first = ntp.ffi.new("ntp_relief *"), ntp.ffi.new("int32_t *")
    rows, columns = heights.shape[:2]
    for y in range(rows):
        step = ntp.lib.ntp_relief_row(columns, rows, y, first)
        if step > 0:
            ntp.check(ntp.lib.ntp_relief_add(relief, view, how, first[0], y, step))
    return relief


def scale_of(heights, **how):
    return ntp.lib.ntp_relief_scale(relief_of(heights, **how))


def slopes(heights, most=None):
    """Central differences of a texture that tiles, of heights 0..1; none of 0."""
    h = heights[..., 0].astype(float) / (most or np.iinfo(heights.dtype).max)
    across = (np.roll(h, -1, 1) - np.roll(h, 1, 1)) / 2
    down = (np.roll(h, -1, 0) - np.roll(h, 1, 0)) / 2
    length = np.hypot(across, down).ravel()
    return length[length > 0]


def hills(side, dtype, amplitude=1.0, floor=0.0):
    x = np.linspace(0, 2 * np.pi, side, endpoint=False)
    h = 0.5 + 0.25 * amplitude * (np.sin(3 * x)[:, None] + np.cos(2 * x))
    h[h < floor] = floor
    if dtype == np.float32:
        return h.astype(dtype)[..., None]
    return np.round(h * np.iinfo(dtype).max).astype(dtype)[..., None]


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize(("amplitude", "floor"), [(1, 0), (0.1, 0), (1, 0.8)])
def test_one_in_twenty(dtype, amplitude, floor):
    """Of the texels that are not flat, one in twenty is steeper than 45 degrees: within a bin."""
    heights = hills(200, dtype, amplitude, floor)
    scale = scale_of(heights)
    length = slopes(heights, 1 if dtype == np.float32 else None)
    assert np.mean(length * scale * 0.985 > 1) <= 0.05 <= np.mean(length * scale * 1.015 >= 1)


def test_sampled():
    """A large texture is measured at some of its texels, with about the same answer."""
    heights = hills(1030, np.uint16)
    first = ntp.ffi.new("int32_t *")
    rows = [ntp.lib.ntp_relief_row(1030, 1030, y, first) for y in range(1030)]
    assert sum(step > 0 for step in rows) == 258 and set(rows) == {0, 4}
    assert sum(relief_of(heights).texels) == pytest.approx(258 * 258, rel=0.02)
    steep = np.quantile(slopes(heights), 0.95)
    assert scale_of(heights) == pytest.approx(1 / steep, rel=0.03)


def test_same_picture_of_any_size():
    """Twice the size needs twice the scale."""
    assert scale_of(hills(512, np.uint16)) == pytest.approx(
        2 * scale_of(hills(256, np.uint16)), rel=0.02
    )


def test_three_digits():
    scale = scale_of(hills(200, np.uint8))
    assert scale == float(f"{scale:.3g}")


def test_flat():
    assert scale_of(np.full((9, 9, 1), 77, np.uint8)) == 0
    assert scale_of(np.full((9, 9, 1), np.nan, np.float32)) == 0


def test_spacing_and_source():
    heights = np.repeat(hills(128, np.uint16), 4, 2)
    heights[..., :3] = 0
    assert scale_of(heights, source=0) == 0
    wide = scale_of(heights, source=3, dx=2, dy=2)
    assert wide == pytest.approx(2 * scale_of(heights, source=3), rel=0.01)


def test_wrong_arguments():
    view = ntp.view(np.zeros((3, 3, 1), np.uint8), ntp.HEIGHT, const=True)
    relief, how = ntp.ffi.new("ntp_relief *"), ntp.ffi.new("ntp_normals_options *")
    add = ntp.lib.ntp_relief_add
    for x, y, step in ((-1, 0, 1), (0, -1, 1), (0, 3, 1), (0, 0, 0)):
        assert add(relief, view, how, x, y, step) == ntp.ERR_ARGUMENT
    assert add(ntp.ffi.NULL, view, how, 0, 0, 1) == ntp.ERR_ARGUMENT
    assert add(relief, view, ntp.ffi.NULL, 0, 0, 1) == ntp.ERR_ARGUMENT
    how.source = 3
    assert add(relief, view, how, 0, 0, 1) == ntp.ERR_FORMAT
    assert ntp.lib.ntp_relief_scale(ntp.ffi.NULL) == 0
