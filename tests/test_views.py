# SPDX-License-Identifier: MIT
"""Views and areas: the same bytes for any memory layout and any division of an image."""

import itertools

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support.texels import cuts, image

ENCODINGS = {
    2: [ntp.XY],
    3: [ntp.STANDARD, ntp.ZZERO, ntp.XY],
    4: [ntp.STANDARD, ntp.ZZERO, ntp.XY],
}
TYPES = [np.uint8, np.uint16, np.float32]


def samples(dtype, channels, h=23, w=301):
    """An image of one type; float images also hold levels off the 16-bit grid."""
    m = 255 if dtype == np.uint8 else 65535
    levels = image(m, channels, seed=channels, h=h, w=w)
    return (levels / m).astype(dtype) if dtype == np.float32 else levels.astype(dtype)


def padded(array, after=5, between=0):
    """The same pixels with other bytes after each row and between pixels, and those bytes."""
    h, w, c = array.shape
    memory = np.full((h, w + after, c + between), 7, array.dtype)
    memory[:, :w, :c] = array
    return memory, memory[:, :w, :c]


def layouts(array):
    """name -> (memory, view with the pixels of array in it)."""
    out = {"packed": (array.copy(),) * 2}
    for name, (after, between) in {"rows": (5, 0), "pixels": (3, 2), "odd": (1, 1)}.items():
        out[name] = padded(array, after, between)
    for name, turn in {
        "up": np.s_[::-1],
        "left": np.s_[:, ::-1],
        "both": np.s_[::-1, ::-1],
    }.items():
        memory = np.ascontiguousarray(array[turn])
        out[name] = (memory, memory[turn])
    tall = np.full((array.shape[0], 2, *array.shape[1:]), 9, array.dtype)
    tall[:, 1] = array
    out["every other row"] = (tall, tall[:, 1])
    transposed = np.ascontiguousarray(array.transpose(1, 0, 2))
    out["columns"] = (transposed, transposed.transpose(1, 0, 2))
    return out


def operations(channels):
    """name -> function(dst view, src view, area)."""

    def clean(encoding, method, plan=None):
        how = ntp.clean_options(method)
        return lambda dst, src, area: ntp.clean(src, encoding, how, plan, dst, area)

    out = {}
    for encoding in ENCODINGS[channels]:
        for method in (ntp.DERIVE, ntp.NORMALIZE, ntp.KEEP):
            out[f"clean {encoding} {method}"] = clean(encoding, method)
        for target in ENCODINGS[channels]:
            out[f"convert {encoding} {target}"] = lambda dst, src, area, e=encoding, t=target: (
                ntp.convert(src, dst, e, t, ntp.UP, ntp.DOWN, area=area)
            )
    return out


@pytest.mark.parametrize("dtype", TYPES, ids=lambda t: t.__name__)
@pytest.mark.parametrize("channels", [2, 3, 4])
def test_layouts(dtype, channels):
    """Every layout of source and target, whole and in areas: the same pixels, nothing else."""
    array = samples(dtype, channels, 11, 61)
    rng = np.random.default_rng(1)
    for name, operation in operations(channels).items():
        want = np.zeros_like(array)
        operation(want, array, None)
        for source, target in itertools.product(layouts(array), repeat=2):
            _, src = layouts(array)[source]
            memory, dst = layouts(np.zeros_like(array))[target]
            untouched = memory.copy()
            for area in cuts(*array.shape[:2], rng, 4):
                operation(dst, src, area)
            assert np.array_equal(dst, want), (name, source, target)
            dst[:] = 0
            assert np.array_equal(memory, untouched), (name, source, target)


@pytest.mark.parametrize("dtype", TYPES, ids=lambda t: t.__name__)
@pytest.mark.parametrize("channels", [2, 3, 4])
def test_in_place(dtype, channels):
    array = samples(dtype, channels)
    for name, operation in operations(channels).items():
        want = np.zeros_like(array)
        operation(want, array, None)
        for layout, (_, view) in layouts(array).items():
            operation(view, view, None)
            assert np.array_equal(view, want), (name, layout)


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("encoding", [ntp.STANDARD, ntp.ZZERO, ntp.XY])
def test_plan_in_every_layout(channels, encoding):
    """With a plan the packed 8-bit path is taken: widths 1..70, each start, any layout."""
    array = samples(np.uint8, channels, 3, 90)
    for touch in (0, 7, 4):
        how = ntp.clean_options(touch_unused=touch)
        plan, memory = ntp.clean_plan(encoding, how)
        for width in range(1, 71):
            src = array[:, width % 7 : width % 7 + width]
            want, changed, _ = ntp.clean(np.ascontiguousarray(src), encoding, how)
            got, changed_too, _ = ntp.clean(src, encoding, how, plan, np.zeros_like(want))
            assert np.array_equal(got, want) and changed == changed_too
        for name, (_, view) in layouts(array).items():
            want, _, _ = ntp.clean(array, encoding, how)
            got, _, _ = ntp.clean(view, encoding, how, plan, np.zeros_like(array))
            assert np.array_equal(got, want), name
        del memory


@pytest.mark.parametrize("dtype", TYPES, ids=lambda t: t.__name__)
def test_validate_layouts(dtype):
    array = samples(dtype, 4, 13, 259)
    want = ntp.validate(array)
    assert want.any()
    for _, view in layouts(array).values():
        assert np.array_equal(ntp.validate(view), want)
    mask = np.full((13, 259, 3), 77, np.uint8)
    ntp.check(
        ntp.lib.ntp_validate(
            ntp.view(mask, ntp.STANDARD), ntp.view(array, const=True), 0, ntp.ffi.NULL
        )
    )
    assert np.array_equal(mask[..., 0], want)
    assert np.all(mask[..., 1:] == 77), "further samples are left alone"
    parts = np.zeros((13, 259), np.uint8)
    for area in cuts(13, 259, np.random.default_rng(2), 9):
        x0, y0, x1, y1 = area
        one = np.zeros((13, 259), np.uint8)
        ntp.check(
            ntp.lib.ntp_validate(
                ntp.view(one, ntp.HEIGHT), ntp.view(array, const=True), 0, ntp.rect(area)
            )
        )
        parts[y0:y1, x0:x1] = one[y0:y1, x0:x1]
        one[y0:y1, x0:x1] = 0
        assert not one.any()
    assert np.array_equal(parts, want)


@pytest.mark.parametrize("dtype", TYPES, ids=lambda t: t.__name__)
def test_measure_layouts(dtype):
    array = samples(dtype, 4, 13, 90)
    want = ntp.Tally().measure(array).stats()
    for _, view in layouts(array).values():
        if view.strides[1] > 0 and view.strides[0] > 0:
            assert ntp.Tally().measure(view).stats() == want
        else:
            assert ntp.Tally().measure(view).stats()["standard"] == want["standard"]


@pytest.mark.parametrize("rows", [1, 2, 5])
def test_ring_rows(rows):
    """An image streamed through a few rows, as a caller without room for all of it does."""
    array = samples(np.uint8, 3, 23, 90)
    want, changed, _ = ntp.clean(array)
    ring_in = np.zeros((rows, 90, 3), np.uint8)
    ring_out = np.zeros_like(ring_in)
    got, counts, tally = np.zeros_like(array), ntp.ffi.new("ntp_clean_counts *"), ntp.Tally()
    src = ntp.view(ring_in, const=True, ring_rows=rows, height=23)
    dst = ntp.view(ring_out, ring_rows=rows, height=23)
    for y in range(0, 23, rows):
        here = [(j, j % rows) for j in range(y, min(y + rows, 23))]
        for j, slot in here:
            ring_in[slot] = array[j]
        area = ntp.rect((0, y, 90, min(y + rows, 23)))
        ntp.check(ntp.lib.ntp_clean(dst, src, ntp.ffi.NULL, ntp.ffi.NULL, counts, area))
        ntp.check(ntp.lib.ntp_tally_add(tally.pointer, src, 0, area))
        for j, slot in here:
            got[j] = ring_out[slot]
    assert np.array_equal(got, want)
    assert counts.changed == changed
    assert tally.stats() == ntp.Tally().measure(array).stats()


def bad_views():
    """(fields of a view of a 4 x 5 x 3 u8 image, status)."""
    return [
        ({"data": ntp.ffi.NULL}, ntp.ERR_ARGUMENT),
        ({"width": 0}, ntp.ERR_SHAPE),
        ({"height": -1}, ntp.ERR_SHAPE),
        ({"width": 65536}, ntp.ERR_SHAPE),
        ({"height": 65536}, ntp.ERR_SHAPE),
        ({"ring_rows": -1}, ntp.ERR_SHAPE),
        ({"channels": 0}, ntp.ERR_FORMAT),
        ({"channels": 2}, ntp.ERR_FORMAT),
        ({"channels": 5}, ntp.ERR_FORMAT),
        ({"type": 3}, ntp.ERR_ARGUMENT),
        ({"encoding": 5}, ntp.ERR_ARGUMENT),
        ({"encoding": ntp.VECTOR}, ntp.ERR_FORMAT),
        ({"encoding": ntp.HEIGHT}, ntp.ERR_FORMAT),
        ({"y": 2}, ntp.ERR_ARGUMENT),
    ]


@pytest.mark.parametrize("fields,want", bad_views(), ids=str)
def test_bad_views(fields, want):
    array, mask = np.zeros((4, 5, 3), np.uint8), np.full((4, 5), 7, np.uint8)
    src, dst = ntp.view(array, const=True, **fields), ntp.view(array.copy(), **fields)
    null, lib = ntp.ffi.NULL, ntp.lib
    texel = ntp.ffi.new("ntp_texel *")
    assert lib.ntp_clean(dst, src, null, null, null, null) == want
    assert lib.ntp_validate(ntp.view(mask, ntp.HEIGHT), src, 0, null) == want
    assert np.all(mask == 7)
    assert lib.ntp_inspect(texel, src, 0, 0, 0) == want
    if fields != {"encoding": ntp.HEIGHT}:
        assert lib.ntp_tally_add(ntp.Tally().pointer, src, 0, null) == want


def test_misaligned_views():
    memory = np.zeros(400, np.uint8)
    base = memory.__array_interface__["data"][0]
    array = memory[: 4 * 5 * 6].view(np.uint16).reshape(4, 5, 3)
    for change in ({"data": base + 1}, {"row_stride": 31}, {"pixel_stride": 7}):
        if "data" in change:
            change = {"data": ntp.ffi.cast("void *", change["data"])}
        src = ntp.view(array, const=True, **change)
        assert ntp.lib.ntp_inspect(ntp.ffi.new("ntp_texel *"), src, 0, 0, 0) == ntp.ERR_SHAPE


def test_clean_errors():
    a = np.zeros((4, 5, 3), np.uint8)
    null = ntp.ffi.NULL

    def status(dst, src, how=None, plan=None, area=None, e=ntp.STANDARD, src_e=None, **more):
        out = ntp.view(dst, e)
        into = ntp.view(src, e if src_e is None else src_e, const=True, **more)
        return ntp.lib.ntp_clean(out, into, how or null, plan or null, null, ntp.rect(area))

    assert status(a.copy(), a) == ntp.OK
    assert status(np.zeros((5, 5, 3), np.uint8), a) == ntp.ERR_SHAPE
    assert status(np.zeros((4, 5, 4), np.uint8), a) == ntp.ERR_FORMAT
    assert status(np.zeros((4, 5, 3), np.uint16), a) == ntp.ERR_FORMAT
    assert status(a.copy(), a, src_e=ntp.ZZERO) == ntp.ERR_FORMAT
    assert status(a.copy(), a, y=ntp.DOWN) == ntp.ERR_FORMAT
    for area in ((-1, 0, 2, 2), (0, 0, 6, 2), (0, 0, 2, 5), (3, 0, 3, 1), (3, 0, 2, 1)):
        assert status(a.copy(), a, area=area) == ntp.ERR_SHAPE, area
    for how in ((3, 0, 0, 0, 0), (0, 0, 0, 3, 0), (0, 0, 0, 0, 8)):
        assert status(a.copy(), a, ntp.ffi.new("ntp_clean_options *", how)) == ntp.ERR_ARGUMENT
    how = ntp.clean_options()
    plan, memory = ntp.clean_plan(ntp.STANDARD, how)
    assert status(a.copy(), a, how, plan) == ntp.OK
    assert status(a.copy(), a, None, plan) == ntp.OK, "NULL options are the defaults"
    assert status(a.copy(), a, ntp.clean_options(ntp.KEEP), plan) == ntp.ERR_ARGUMENT
    assert status(a.copy(), a, how, plan, e=ntp.ZZERO) == ntp.ERR_ARGUMENT
    assert (
        ntp.lib.ntp_clean(null, ntp.view(a, const=True), null, null, null, null) == ntp.ERR_ARGUMENT
    )
    assert ntp.lib.ntp_clean(ntp.view(a), null, null, null, null, null) == ntp.ERR_ARGUMENT
    del memory


def test_plan_errors():
    size = ntp.lib.ntp_clean_plan_size()
    assert 256 * 1024 <= size <= 330 * 1024
    memory, plan, how = (
        ntp.aligned(size + 16),
        ntp.ffi.new("ntp_clean_plan **"),
        ntp.clean_options(),
    )
    at = memory.__array_interface__["data"][0]

    def init(address, bytes_, encoding=ntp.STANDARD):
        where = ntp.ffi.cast("void *", address)
        return ntp.lib.ntp_clean_plan_init(plan, where, bytes_, encoding, how)

    assert init(at, size) == ntp.OK
    assert init(0, size) == ntp.ERR_SCRATCH
    assert init(at + 8, size) == ntp.ERR_SCRATCH
    assert init(at, size - 1) == ntp.ERR_SCRATCH
    assert init(at, size, ntp.VECTOR) != ntp.OK
    assert init(at, size, ntp.HEIGHT) != ntp.OK


def test_status_strings_and_version():
    texts = {ntp.ffi.string(ntp.lib.ntp_status_string(s)) for s in range(8)}
    assert len(texts) == 8
    for unknown in (8, 1000, 2**31 - 1):
        assert ntp.ffi.string(ntp.lib.ntp_status_string(unknown))
    header = ntp.HEADER.read_text(encoding="utf-8")
    version = ntp.lib.ntp_version()
    for name, part in (
        ("MAJOR", version >> 16),
        ("MINOR", version >> 8 & 255),
        ("PATCH", version & 255),
    ):
        assert f"#define NTP_VERSION_{name} {part}\n" in header
