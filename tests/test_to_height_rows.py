# SPDX-License-Identifier: MIT
"""Normals -> heightfield row by row: the bytes of the whole picture at once."""

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support.to_height import (
    CLAMP,
    EXTRAPOLATE,
    MIRROR,
    UNORM,
    WRAP,
    by_eigenvectors,
    near,
    options,
    serial_hooks,
    slopes,
    to_height,
)

BAKED = 10
CASES = [
    ("forward", WRAP, WRAP),
    ("forward", CLAMP, EXTRAPOLATE),
    ("central", WRAP, WRAP),
    ("central", WRAP, CLAMP),
    ("central", MIRROR, CLAMP),
    (BAKED, WRAP, WRAP),
    (BAKED, CLAMP, CLAMP),
]


class Rows:
    """The callbacks over arrays; `stop` makes call number `stop` fail."""

    def __init__(self, normals, stop=-1):
        self.normals = normals
        self.heights = np.full(normals.shape[:2], np.nan, np.float32)
        self.calls, self.stop = [], stop
        self.most = 0
        ffi = ntp.ffi
        self.read_normals = ffi.callback(
            "int32_t(void *, void *, int32_t, int32_t)",
            lambda _, rows, y, n: self.move("normals", rows, self.normals, y, n, out=True),
        )
        self.read_heights = ffi.callback(
            "int32_t(void *, float *, int32_t, int32_t)",
            lambda _, rows, y, n: self.move("read", rows, self.heights, y, n, out=True),
        )
        self.write_heights = ffi.callback(
            "int32_t(void *, float const *, int32_t, int32_t)",
            lambda _, rows, y, n: self.move("write", rows, self.heights, y, n, out=False),
        )
        self.struct = ffi.new("ntp_height_rows *")
        for name in ("read_normals", "read_heights", "write_heights"):
            setattr(self.struct, name, getattr(self, name))

    def move(self, name, rows, array, y, n, out):
        assert 0 <= y < y + n <= array.shape[0]
        self.calls.append((name, y, n))
        self.most = max(self.most, n)
        part = array[y : y + n]
        there = np.frombuffer(ntp.ffi.buffer(rows, part.nbytes), part.dtype).reshape(part.shape)
        if out:
            there[...] = part
        else:
            part[...] = there
        return int(len(self.calls) == self.stop)


def by_rows(rows, parts=1, encoding=ntp.STANDARD, size=None, **how):
    form = ntp.view(rows.normals, encoding, const=True)
    form.data, form.row_stride, form.ring_rows = ntp.ffi.NULL, 1, -5  # not looked at
    how.setdefault("decode", UNORM)
    chosen = options(**how)
    needed = ntp.lib.ntp_height_rows_scratch_size(form, chosen, parts)
    scratch = ntp.aligned(max(needed, 1), 64)
    where = ntp.ffi.cast("void *", scratch.__array_interface__["data"][0])
    result = ntp.ffi.new("ntp_height_result *")
    ntp.check(
        ntp.lib.ntp_height_from_rows(
            form,
            rows.struct,
            chosen,
            where,
            needed if size is None else size,
            serial_hooks(parts),
            result,
        )
    )
    return ntp.fields(result)


@pytest.mark.parametrize(("kernel", "border_x", "border_y"), CASES)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_the_same_bytes(kernel, border_x, border_y, dtype):
    rng = np.random.default_rng(21)
    for shape in [(1, 9), (7, 5), (133, 20), (300, 31), (800, 17)]:
        if dtype is np.float32:
            n = rng.random((*shape, 3), np.float32) * 0.2 + 0.4
        else:
            m = np.iinfo(dtype).max
            n = rng.integers(0.4 * m, 0.6 * m, (*shape, 4)).astype(dtype)
            n[shape[0] // 2, 3] = 0
        n[..., 2] = 1 if dtype is np.float32 else m
        how = {"kernel": kernel, "border_x": border_x, "border_y": border_y}
        whole, facts = to_height(n, decode=UNORM, **how)
        for parts in (1, 3):
            rows = Rows(n)
            assert by_rows(rows, parts, **how) == facts
            assert np.array_equal(rows.heights.view(np.uint32), whole.view(np.uint32))
            assert rows.most <= 128 * parts + 6
    writes = [y for name, y, _ in rows.calls if name == "write"]
    assert writes == [0, 384, 768, 768, 384, 0]


def test_extrapolated_edges_keep_a_quarter_of_weight():
    rng = np.random.default_rng(22)
    n = rng.integers(100, 156, (133, 40, 3)).astype(np.uint8)
    n[..., 2] = 255
    how = {"kernel": "central", "border_x": EXTRAPOLATE, "border_y": EXTRAPOLATE}
    rows = Rows(n)
    facts = by_rows(rows, **how)
    p, q = slopes(n)
    assert near(rows.heights, by_eigenvectors(p, q, *how.values(), edges=False))
    assert (facts["min"], facts["max"]) == (rows.heights.min(), rows.heights.max())


def test_rows_that_cannot_be_read_or_written_end_it():
    n = np.full((300, 10, 3), 140, np.uint8)
    rows = Rows(n)
    by_rows(rows)
    for stop in range(1, len(rows.calls) + 1):
        cut = Rows(n, stop)
        with pytest.raises(ntp.NtpError) as error:
            by_rows(cut)
        assert error.value.status == ntp.ERR_CANCELLED
        assert len(cut.calls) == stop


@pytest.mark.parametrize(
    "how",
    [
        {"kernel": "sobel3"},
        {"kernel": "central", "border_y": MIRROR},
        {"kernel": "central", "prior": 2},
        {"method": 1},
        {"method": 4},
        {"detrend": 1},
        {"refine": 2},
    ],
)
def test_what_takes_the_whole_picture(how):
    with pytest.raises(ntp.NtpError) as error:
        by_rows(Rows(np.full((9, 9, 3), 140, np.uint8)), **how)
    assert error.value.status == ntp.ERR_FORMAT


def test_arguments():
    rows = Rows(np.full((9, 9, 3), 140, np.uint8))
    with pytest.raises(ntp.NtpError) as error:
        by_rows(rows, size=64)
    assert error.value.status == ntp.ERR_SCRATCH
    for how in ({"dx": -1.0}, {"decode": 9}, {"border_x": 5}, {"kernel": 11}):
        with pytest.raises(ntp.NtpError) as error:
            by_rows(rows, **how)
        assert error.value.status == ntp.ERR_ARGUMENT
    rows.struct.write_heights = ntp.ffi.NULL
    with pytest.raises(ntp.NtpError) as error:
        by_rows(rows)
    assert error.value.status == ntp.ERR_ARGUMENT
