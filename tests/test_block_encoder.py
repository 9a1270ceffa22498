# SPDX-License-Identifier: MIT
"""ntp_bc4_encode and ntp_bc5_encode: against every pair of ends, and by angles."""

import numpy as np
import pytest

from support import exact_blocks
from support import libntp_ffi as ntp

BY_ANGLE, BY_CHANNEL, QUICK = range(3)
FUNCTIONS = {1: "ntp_bc4_encode", 2: "ntp_bc5_encode"}


def encode(image, channels=1, quality=BY_CHANNEL, area=None, out=None, encoding=None, y=0):
    h, w = image.shape[:2]
    if out is None:
        out = np.zeros((-(-h // 4), -(-w // 4), 8 * channels), np.uint8)
    if encoding is None:
        encoding = ntp.HEIGHT if channels == 1 else ntp.XY
    src = ntp.view(image, encoding, y, const=True)
    how = ntp.ffi.new("ntp_block_options *", [quality])
    data = ntp.ffi.cast("uint8_t *", out.ctypes.data)
    function = getattr(ntp.lib, FUNCTIONS[channels])
    ntp.check(function(data, out.strides[0], src, how, ntp.rect(area)))
    return out


def kinds_of_blocks(rng, count):
    """(count, 16): noise, slopes with noise, two colors, and what reaches the ends of the range."""
    u, v = np.arange(16) % 4, np.arange(16) // 4
    slope = rng.normal(0, 1, (count, 2)) * rng.choice([0.2, 2, 12, 60], (count, 1))
    plane = rng.integers(0, 256, (count, 1)) + slope[:, :1] * u + slope[:, 1:] * v
    plane += rng.normal(0, 1, (count, 16)) * rng.choice([0, 0.5, 3, 12], (count, 1))
    noise = rng.integers(0, 256, (count, 16))
    two = np.where(rng.integers(0, 2, (count, 16)), noise[:, :1], noise[:, 1:2])
    beyond = rng.integers(-120, 376, (count, 16))
    kind = rng.choice(4, (count, 1), p=[0.7, 0.1, 0.1, 0.1])
    return np.clip(np.rint(np.choose(kind, [plane, noise, two, beyond])), 0, 255).astype(np.uint8)


def picture_of(blocks):
    """One row of blocks as a picture."""
    return np.ascontiguousarray(blocks.reshape(-1, 4, 4).swapaxes(0, 1).reshape(4, -1))


def errors(image, channel_bytes, scale=1):
    off = scale * exact_blocks.decoded(channel_bytes) - exact_blocks.PARTS * image.astype(np.int64)
    return (exact_blocks.blocks_of(off) ** 2).sum(-1)[0]


@pytest.mark.parametrize("channels", [1, 2])
def test_no_pair_of_ends_is_better(channels):
    blocks = kinds_of_blocks(np.random.default_rng(channels), 1000)
    want = [exact_blocks.least_error(b) for b in blocks]
    image = picture_of(blocks)
    image = np.stack([image, image[:, ::-1]], -1)[..., :channels]
    got = encode(np.ascontiguousarray(image), channels)
    for c in range(channels):
        ours = errors(image[..., c], got[..., 8 * c : 8 * c + 8])
        assert np.array_equal(ours if c == 0 else ours[::-1], want)


def test_no_pair_of_ends_is_better_near_the_ends_of_the_range():
    """Where fifths have 0 and 255 besides, and texels lie a few levels beside these."""
    rng = np.random.default_rng(9)
    middle = rng.integers(60, 180, (1200, 1)) + rng.integers(0, 40, (1200, 16))
    beside = rng.integers(0, rng.choice([14, 30], (1200, 1)), (1200, 16))
    kind = rng.choice(3, (1200, 16), p=[0.6, 0.2, 0.2])
    blocks = np.choose(kind, [middle, beside, 255 - beside]).astype(np.uint8)
    image = picture_of(blocks)
    assert list(errors(image, encode(image))) == [exact_blocks.least_error(b) for b in blocks]


def test_no_pair_of_ends_is_better_for_16_bit():
    rng = np.random.default_rng(5)
    blocks = kinds_of_blocks(rng, 16).astype(np.int64) * 257
    blocks = np.clip(blocks + rng.integers(-300, 301, blocks.shape), 0, 65535).astype(np.uint16)
    image = picture_of(blocks)
    got = errors(image, encode(image), 257)
    assert np.array_equal(got, [exact_blocks.least_error_16(b) for b in blocks])


def normals(rng, side, slope, m):
    """Smooth noise as x, y."""
    x, y = (
        sum(np.roll(rng.normal(0, slope, (side, side)), (i % 3, i // 3), (0, 1)) for i in range(9))
        for _ in range(2)
    )
    v = np.stack([x, y, np.ones_like(x)], -1)
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    return np.rint((v + 1) / 2 * m).astype(np.uint8 if m == 255 else np.uint16)


@pytest.mark.parametrize("slope", [0.02, 0.3])
@pytest.mark.parametrize("m", [255, 65535])
def test_by_angle_is_best(slope, m):
    image = normals(np.random.default_rng(1), 64, slope, m)
    x, y = (2.0 * image[..., c] / m - 1 for c in range(2))
    mean = []
    for quality in (BY_ANGLE, BY_CHANNEL, QUICK):
        got = exact_blocks.vectors(encode(image, 2, quality), 64, 64)
        mean.append(exact_blocks.degrees(exact_blocks.unit(x, y), got).mean())
    assert mean[0] <= mean[1]
    assert mean[0] < 0.97 * mean[2] or slope < 0.1
    assert mean[2] < 1.2 * mean[0]


def test_by_angle_gains_much_where_it_is_steep():
    image = normals(np.random.default_rng(1), 64, 0.8, 255)
    source = exact_blocks.unit(*(2.0 * image[..., c] / 255 - 1 for c in range(2)))
    mean = [
        exact_blocks.degrees(source, exact_blocks.vectors(encode(image, 2, q), 64, 64)).mean()
        for q in (BY_ANGLE, BY_CHANNEL)
    ]
    assert mean[0] < 0.89 * mean[1], mean


@pytest.mark.parametrize("quality", [BY_ANGLE, BY_CHANNEL, QUICK])
def test_bands_and_edges(quality):
    rng = np.random.default_rng(3)
    image = normals(rng, 32, 0.2, 255)[:23, :30]
    whole = encode(image, 2, quality)
    parts = np.zeros_like(whole)
    for area in ((0, 0, 12, 8), (12, 0, 30, 8), (0, 8, 30, 12), (0, 12, 30, 23)):
        encode(image, 2, quality, area, parts)
    assert np.array_equal(parts, whole)
    mirrored = encode(image[::-1][::-1], 2, quality)
    assert np.array_equal(mirrored, whole)
    wide = encode(image.astype(np.uint16) * 257, 2, quality)
    assert np.array_equal(wide, whole)
    # What lies beyond the edge counts for nothing: a block of 3 x 2 texels that fits exactly
    corner = np.array([[10, 20, 30], [40, 50, 60]], np.uint8)
    assert np.array_equal(exact_blocks.decoded(encode(corner))[:2, :3], 35 * corner.astype(int))


def test_other_views():
    rng = np.random.default_rng(8)
    image = rng.integers(0, 256, (8, 8, 4)).astype(np.uint8)
    whole = encode(np.ascontiguousarray(image[..., :2]), 2)
    for encoding in (ntp.STANDARD, ntp.ZZERO, ntp.XY):
        assert np.array_equal(encode(image, 2, encoding=encoding), whole)
    floats = (image / np.float32(255)).astype(np.float32)
    assert np.array_equal(encode(floats, 2, encoding=ntp.STANDARD), whole)
    x = encode(image, encoding=ntp.STANDARD)
    assert np.array_equal(x, whole[..., :8])


@pytest.mark.parametrize("wrong, status", [
    ({"area": (2, 0, 8, 8)}, ntp.ERR_ARGUMENT), ({"area": (0, 0, 6, 8)}, ntp.ERR_ARGUMENT),
    ({"area": (0, 4, 8, 10)}, ntp.ERR_SHAPE), ({"quality": 3}, ntp.ERR_ARGUMENT),
    ({"encoding": ntp.HEIGHT}, ntp.ERR_FORMAT),
])  # fmt: skip
def test_refused(wrong, status):
    out = np.full((2, 2, 16), 7, np.uint8)
    with pytest.raises(ntp.NtpError) as error:
        encode(np.zeros((8, 8, 3), np.uint8), 2, out=out, **{"encoding": ntp.STANDARD, **wrong})
    assert error.value.status == status
    assert (out == 7).all()
