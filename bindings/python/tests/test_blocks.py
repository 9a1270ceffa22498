# SPDX-License-Identifier: MIT
"""encode_bc5 and encode_bc4: read back by the package's own reader, and alike however they are called."""

import numpy as np
import pytest

import normaltexture as nt
from support.gpu_textures import dds

WIDTH, HEIGHT = 46, 37


def texture(dtype):
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH] / 7
    n = np.stack([np.sin(u) / 3, np.cos(v + u) / 3, np.ones_like(u)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    if dtype is np.float32:
        return ((n + 1) / 2).astype(dtype)
    return np.rint((n + 1) / 2 * np.iinfo(dtype).max).astype(dtype)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
@pytest.mark.parametrize("quality", ["angle", "channel", "quick"])
def test_read_back(dtype, quality):
    image = texture(dtype)
    blocks = nt.encode_bc5(image, quality=quality)
    assert blocks.shape == (10, 12, 16) and blocks.dtype == np.uint8
    back = nt.read(dds(WIDTH, HEIGHT, blocks.tobytes(), dxgi=83))
    top = 1 if dtype is np.float32 else np.iinfo(dtype).max
    assert np.abs(back / 65535 - image[..., :2] / top).max() < 0.02
    assert np.array_equal(nt.encode_bc5(image, quality=quality, threads=3), blocks)
    assert np.array_equal(nt.encode_bc5(image[..., :2], quality=quality), blocks)
    x = nt.encode_bc4(image[..., 0], quality=quality)
    back = nt.read(dds(WIDTH, HEIGHT, x.tobytes(), dxgi=80))
    assert np.abs(back / 65535 - image[..., 0] / top).max() < 0.02
    if quality != "angle":
        assert np.array_equal(x, blocks[..., :8])
