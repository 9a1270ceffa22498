# SPDX-License-Identifier: MIT
"""Normals -> heightfield: threads, progress, cancellation and bad input."""

import itertools
import threading

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support.to_height import (
    AUTO,
    CLAMP,
    FRANKOT_CHELLAPPA,
    KERNELS,
    NEUTRAL,
    POISSON_DCT,
    REPEAT_SLOPE,
    TELESCOPING,
    WRAP,
    least_norm,
    near,
    random_vectors,
    serial_hooks,
    slopes,
    to_height,
)

METHODS = (AUTO, TELESCOPING, 4)  # 4: weighted

# ------------------------------------------------------------------- threads and hooks


@pytest.mark.parametrize("kernel", KERNELS)
def test_same_bytes_for_any_number_of_parts(kernel):
    rng = np.random.default_rng(5)
    n = rng.integers(60, 200, (450, 700, 3)).astype(np.uint8)

    @ntp.ffi.callback("void(void *, int32_t, void (*)(void *, int32_t), void *)")
    def parallel_for(_, count, task, work):
        threads = [threading.Thread(target=task, args=(work, i)) for i in range(count)]
        for t in threads:
            t.start()
        for t in threads:
            t.join()

    for border in (WRAP, CLAMP):
        how = {"kernel": kernel, "border_x": border, "border_y": border}
        alone, facts = to_height(n, **how)
        for parts in (2, 3, 7, 64):
            hooks = serial_hooks(parts, parallel_for=parallel_for)
            ours, result = to_height(n, hooks=hooks, **how)
            assert np.array_equal(ours.view(np.uint32), alone.view(np.uint32))
            assert result == facts


def test_progress_and_cancellation():
    n = np.full((700, 100, 3), 130, np.uint8)
    shares = []

    @ntp.ffi.callback("int32_t(void *, double)")
    def progress(_, share):
        shares.append(share)
        return len(shares) == stop

    stop = 0
    to_height(n, hooks=serial_hooks(1, progress=progress))
    assert shares == sorted(shares)
    assert 0 <= shares[0] and shares[-1] <= 1 and len(shares) > 10
    for stop in range(1, len(shares) + 1):
        shares.clear()
        with pytest.raises(ntp.NtpError) as error:
            to_height(n, hooks=serial_hooks(1, progress=progress))
        assert error.value.status == ntp.ERR_CANCELLED
        assert len(shares) == stop


# ---------------------------------------------------------------------------- bad input


def test_texels_without_a_normal_are_flat():
    rng = np.random.default_rng(2)
    v = random_vectors(rng, (8, 9))
    clean = v.copy()
    v[2, 3] = 0
    v[4, 5, 1] = np.nan
    v[6, 7, 2] = np.inf
    for at in [(2, 3), (4, 5), (6, 7)]:
        clean[at] = (0, 0, 1)
    for method in (AUTO, TELESCOPING):
        ours, result = to_height(v, ntp.VECTOR, method=method)
        assert np.array_equal(ours, to_height(clean, ntp.VECTOR, method=method)[0])
        assert (result["not_finite"], result["unused"]) == (3, 0)
    n = rng.integers(100, 150, (8, 9, 4)).astype(np.uint8)
    n[..., 3] = 255
    n[0, 0] = 0, 0, 0, 255
    n[1, 1] = 255
    n[2, 2, 3] = 0
    ours, result = to_height(n, decode=NEUTRAL)
    assert result["unused"] == 3
    flat = n.copy()
    for at in [(0, 0), (1, 1), (2, 2)]:
        flat[at] = 128, 128, 255, 255
    assert np.array_equal(ours, to_height(flat, decode=NEUTRAL)[0])
    _, result = to_height(n, touch_unused=7)
    assert result["unused"] == 0


def test_extreme_textures_stay_finite():
    zeros = np.zeros((13, 17, 3), np.float32)
    ours, result = to_height(zeros, ntp.VECTOR)
    assert np.all(ours == 0) and result["not_finite"] == 13 * 17
    behind = np.full((13, 17, 3), 10, np.uint8)  # z < 0 everywhere
    for kernel, border in itertools.product(KERNELS, (WRAP, CLAMP)):
        how = {"kernel": kernel, "border_x": border, "border_y": border}
        p, q = slopes(behind)
        assert p.max() == 235
        ours, _ = to_height(behind, **how)
        assert near(ours, least_norm(p, q, kernel, border, border))
    huge = np.zeros((5, 6, 3), np.float32)
    huge[..., 0] = 3e38
    assert np.all(np.isfinite(to_height(huge / 1e10, ntp.VECTOR)[0]))


def test_arguments():
    n = np.full((8, 8, 3), 130, np.uint8)
    wrong = [
        ({"method": FRANKOT_CHELLAPPA, "border_x": CLAMP}, ntp.ERR_ARGUMENT),
        ({"method": POISSON_DCT}, ntp.ERR_ARGUMENT),
        ({"kernel": 11}, ntp.ERR_ARGUMENT),
        ({"kernel": "sobel3", "method": TELESCOPING}, ntp.ERR_FORMAT),
        ({"border_y": REPEAT_SLOPE}, ntp.ERR_FORMAT),
        ({"use_seeds": 1}, ntp.ERR_ARGUMENT),
        ({"use_seeds": 1, "method": TELESCOPING, "seeds": [np.nan, 0, 0, 0]}, ntp.ERR_ARGUMENT),
        ({"decode": 5}, ntp.ERR_ARGUMENT),
        ({"z": 3}, ntp.ERR_ARGUMENT),
        ({"border_x": 9}, ntp.ERR_ARGUMENT),
        ({"touch_unused": 8}, ntp.ERR_ARGUMENT),
        ({"residual_scope": 5}, ntp.ERR_ARGUMENT),
        ({"prior": 3}, ntp.ERR_ARGUMENT),
        ({"method": 5}, ntp.ERR_ARGUMENT),
        ({"dx": -1.0}, ntp.ERR_ARGUMENT),
        *(({"method": m, "dx": 2.0**101, "dy": 2.0**101}, ntp.ERR_ARGUMENT) for m in METHODS),
        *(({"method": m, "dx": 2.0**51}, ntp.ERR_ARGUMENT) for m in METHODS),
        *(({"method": m, "dy": 2.0**51}, ntp.ERR_ARGUMENT) for m in METHODS),
    ]
    for how, status in wrong:
        with pytest.raises(ntp.NtpError) as error:
            to_height(n, **how)
        assert error.value.status == status, how
    with pytest.raises(ntp.NtpError) as error:
        to_height(n, ntp.HEIGHT)
    assert error.value.status == ntp.ERR_FORMAT
    dst = np.zeros((8, 8), np.float32)
    src = ntp.view(n, const=True)
    view = ntp.view(dst, ntp.HEIGHT)
    null = ntp.ffi.NULL
    call = ntp.lib.ntp_height_from_normals
    scratch = ntp.aligned(1 << 16, 64)
    where = ntp.ffi.cast("char *", scratch.__array_interface__["data"][0])
    size = ntp.lib.ntp_height_scratch_size(null, 8, 8, 0)
    assert 0 < size <= 1 << 16
    assert call(view, src, null, where, size, null, null) == ntp.OK
    assert call(view, src, null, where, size - 1, null, null) == ntp.ERR_SCRATCH
    assert call(view, src, null, where + 4, size, null, null) == ntp.ERR_SCRATCH
    assert call(view, src, null, null, size, null, null) == ntp.ERR_SCRATCH
    assert call(null, src, null, where, size, null, null) == ntp.ERR_ARGUMENT
    assert ntp.lib.ntp_height_scratch_size(null, 0, 8, 1) == 0
    assert ntp.lib.ntp_height_scratch_size(null, 8, 8, 65) == 0
