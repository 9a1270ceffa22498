# SPDX-License-Identifier: MIT
"""Textures that hypothesis draws: all depths, unused texels, flat ones, steep ones, any alpha."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

ENCODINGS = {"standard": 0, "zzero": 1, "xy": 2}
DEPTHS = {np.uint8: 255, np.uint16: 65535}
MAX_SIDE = 7


def levels(m):
    """Levels, those at the ends and in the middle more often than others."""
    special = [0, 1, (m - 1) // 2, (m + 1) // 2, m - 1, m]
    return st.one_of(st.integers(0, m), st.sampled_from(special))


@st.composite
def textures(draw, dtypes=(np.uint8, np.uint16), channels=(3, 4), max_side=MAX_SIDE):
    dtype = draw(st.sampled_from(dtypes))
    shape = (
        draw(st.integers(1, max_side)),
        draw(st.integers(1, max_side)),
        draw(st.sampled_from(channels)),
    )
    if dtype == np.float32:
        elements = st.floats(-0.25, 1.25, width=32) | st.sampled_from([0.0, 0.5, 1.0])
        return draw(hnp.arrays(dtype, shape, elements=elements, fill=st.nothing()))
    m = DEPTHS[dtype]
    texture = draw(hnp.arrays(dtype, shape, elements=levels(m), fill=st.nothing()))
    odd = draw(hnp.arrays(np.uint8, shape[:2], elements=st.integers(0, 9), fill=st.nothing()))
    texture[odd == 0, :3] = 0
    texture[odd == 1, :3] = m
    return texture


def heights(dtypes=(np.uint8, np.uint16, np.float32), max_side=MAX_SIDE):
    def of(dtype):
        elements = (
            st.floats(-2, 2, width=32) if dtype == np.float32 else levels(np.iinfo(dtype).max)
        )
        shape = hnp.array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=max_side)
        return hnp.arrays(dtype, shape, elements=elements, fill=st.nothing())

    return st.sampled_from(dtypes).flatmap(of)


def layouts(array):
    """The same texels in memory of other kinds: (name, array)."""
    h, w = array.shape[:2]
    yield "contiguous", np.ascontiguousarray(array)
    yield "Fortran order", np.asfortranarray(array)
    wide = np.zeros((h + 3, w + 4, *array.shape[2:]), array.dtype)
    wide[1 : h + 1, 2 : w + 2] = array
    yield "crop", wide[1 : h + 1, 2 : w + 2]
    yield "mirrored", np.ascontiguousarray(array[::-1, ::-1])[::-1, ::-1]
    spread = np.zeros((2 * h, 3 * w, *array.shape[2:]), array.dtype)
    spread[::2, ::3] = array
    yield "every second row, every third column", spread[::2, ::3]
    if array.ndim == 3:
        rgbaz = np.zeros((h, w, array.shape[2] + 2), array.dtype)
        rgbaz[..., 1:-1] = array
        yield "channels inside wider pixels", rgbaz[..., 1:-1]
        yield "reversed channels", np.ascontiguousarray(array[..., ::-1])[..., ::-1]
        planar = np.ascontiguousarray(np.moveaxis(array, 2, 0))
        yield "planar", np.moveaxis(planar, 0, 2)
    yield "the other byte order", array.astype(array.dtype.newbyteorder())
    locked = array.copy()
    locked.flags.writeable = False
    yield "read-only", locked


types = st.sampled_from(list(ENCODINGS))
ups = st.sampled_from(["up", "down"])


def max_of(texture):
    return DEPTHS[texture.dtype.type]
