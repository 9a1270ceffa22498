# SPDX-License-Identifier: MIT
"""All 2**24 8-bit triplets through ntp_validate and ntp_clean, against the oracle.

An image of one red is 256 by 256 texels, green down and blue to the right.  Nothing is sampled.
"""

import itertools

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle

M = 255
ENCODINGS = {"standard": ntp.STANDARD, "zzero": ntp.ZZERO}
METHODS = {"derive": ntp.DERIVE, "normalize": ntp.NORMALIZE, "keep": ntp.KEEP}
G, B = np.arange(256)[:, None], np.arange(256)[None, :]


def plane(r):
    """The texels of one red as an image."""
    out = np.empty((256, 256, 3), np.uint8)
    out[..., 0], out[..., 1], out[..., 2] = r, G, B
    return out


@pytest.mark.parametrize("name,keep", [("standard", 0), ("standard", 1), ("zzero", 0)])
def test_validate(name, keep):
    counts = np.zeros(6, np.int64)
    for r in range(256):
        image = plane(r)
        got = ntp.validate(image, ENCODINGS[name], keep)
        want = oracle.flags(r, G, B, M, name == "zzero", keep)
        want |= np.where(oracle.unused(image, M), ntp.IS_UNUSED, 0).astype(np.uint8)
        assert np.array_equal(got, want), r
        counts += [np.count_nonzero(got & (1 << bit)) for bit in range(6)]
    if name == "standard":
        exact = 102_080 if keep else 51_040
        assert counts.tolist() == [612_496, 306_608, exact, 14_496 * 256, 2**23, 2]
    else:
        assert counts.tolist() == [511_448, 255_920, 51_040, 14_496 * 256, 0, 2]


@pytest.mark.parametrize("keep", [0, 1])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ENCODINGS)
def test_clean(name, method, keep):
    """Result, `changed`, plan == no plan, idempotence, and that every verdict passes."""
    encoding, zz = ENCODINGS[name], name == "zzero"
    how = ntp.clean_options(METHODS[method], keep, touch_unused=ntp.UNUSED_ALL)
    plan, memory = ntp.clean_plan(encoding, how)
    total = 0
    for r in range(256):
        image = plane(r)
        want = oracle.all_cleaned(r, G, B, zz, method, keep).astype(np.uint8)
        got, changed, _ = ntp.clean(image, encoding, how)
        assert np.array_equal(got, want), r
        assert changed == np.count_nonzero(np.any(image != want, axis=-1))
        planned, changed_too, _ = ntp.clean(image, encoding, how, plan)
        assert np.array_equal(planned, got) and changed_too == changed
        again, nothing, _ = ntp.clean(got, encoding, how, plan)
        assert nothing == 0 and np.array_equal(again, got)
        flags = ntp.validate(got, encoding, keep)
        if method == "derive":
            assert np.all(flags & 7 == 7) and not np.any(flags & ntp.XY_TOO_LONG)
            inside = oracle.radicands(r, G[:, 0], M) >= 0
            assert np.array_equal(got[inside][..., :2], image[inside][..., :2])
        if method == "normalize":
            assert np.all(flags & 3 == 3)
        if not keep:
            assert not np.any(flags & ntp.Z_NEGATIVE)
        total += changed
    del memory
    if method == "derive" and not keep:
        assert total == 2**24 - 51_040


@pytest.mark.parametrize("name", ENCODINGS)
@pytest.mark.parametrize("method", METHODS)
def test_only_failing(name, method):
    """Texels that pass the verdict stay, unless Z is negative and must not be.  The others are
    cleaned as usual.  A second pass changes nothing."""
    encoding, zz = ENCODINGS[name], name == "zzero"
    bits = {ntp.NEIGHBOR: 1, ntp.ROUNDED: 2, ntp.EXACT: 4}
    for verdict, keep, r in itertools.product(bits, (0, 1), range(0, 256, 15)):
        how = ntp.clean_options(METHODS[method], keep, 1, verdict, ntp.UNUSED_ALL)
        image = plane(r)
        flags = oracle.flags(r, G, B, M, zz, keep)
        passes = (flags & bits[verdict] > 0) & (keep or flags & ntp.Z_NEGATIVE == 0)
        cleaned = oracle.all_cleaned(r, G, B, zz, method, keep).astype(np.uint8)
        want = np.where(passes[..., None], image, cleaned)
        got = ntp.clean(image, encoding, how)[0]
        assert np.array_equal(got, want), (r, verdict, keep)
        plan, memory = ntp.clean_plan(encoding, how)
        assert np.array_equal(ntp.clean(image, encoding, how, plan)[0], want)
        again, nothing, _ = ntp.clean(got, encoding, how, plan)
        assert nothing == 0 and np.array_equal(again, got)
        del memory


@pytest.mark.parametrize("method", METHODS)
def test_unused_and_alpha(method):
    """RGBA: unused texels stay unless asked for, alpha never changes."""
    for touch, alpha in itertools.product(range(8), (0, 1, 255)):
        how = ntp.clean_options(METHODS[method], touch_unused=touch)
        for encoding in (ntp.STANDARD, ntp.ZZERO):
            plan, memory = ntp.clean_plan(encoding, how)
            for r in (0, 3, 128, 200, 255):
                image = np.dstack([plane(r), np.full((256, 256), alpha, np.uint8)])
                stay = oracle.unused(image, M, touch)
                want = image.copy()
                made = oracle.all_cleaned(r, G, B, encoding == ntp.ZZERO, method)
                want[..., :3] = np.where(stay[..., None], image[..., :3], made)
                for p in (None, plan):
                    got, _, _ = ntp.clean(image, encoding, how, p)
                    assert np.array_equal(got, want), (touch, alpha, r)
            del memory


def test_symmetry():
    """Cleaning commutes with r -> M - r, g -> M - g and r <-> g, on all triplets."""
    for encoding in (ntp.STANDARD, ntp.ZZERO):
        for method in (ntp.DERIVE, ntp.NORMALIZE):
            how = ntp.clean_options(method, touch_unused=ntp.UNUSED_ALL)
            for r in range(256):
                image = plane(r)
                base = ntp.clean(image, encoding, how)[0]
                for channel in (0, 1):
                    mirrored = image.copy()
                    mirrored[..., channel] = M - mirrored[..., channel]
                    want = base.copy()
                    want[..., channel] = M - want[..., channel]
                    assert np.array_equal(ntp.clean(mirrored, encoding, how)[0], want)
                swapped = np.ascontiguousarray(image[..., [1, 0, 2]])
                want = base[..., [1, 0, 2]]
                assert np.array_equal(ntp.clean(swapped, encoding, how)[0], want)


def test_xy_only():
    """XY-only: red and green are repaired, a third sample is kept."""
    r, g = np.meshgrid(np.arange(256), np.arange(256), indexing="ij")
    table = oracle.derive_table()
    for channels in (2, 3, 4):
        image = np.full((256, 256, channels), 77, np.uint8)
        image[..., 0], image[..., 1] = r, g
        for method in METHODS.values():
            how = ntp.clean_options(method, touch_unused=ntp.UNUSED_ALL)
            got, _, _ = ntp.clean(image, ntp.XY, how)
            want = image.copy()
            if method != ntp.KEEP:
                want[..., :2] = table[..., :2]
            if method == ntp.NORMALIZE:  # how a pair is shortened is not said: it is, for good
                flags = ntp.validate(got, ntp.XY)
                assert np.all(flags & 7 == 7)
                assert np.array_equal(ntp.clean(got, ntp.XY, how)[0], got)
                inside = oracle.radicands(r, g, M) >= 0
                assert np.array_equal(got[inside], image[inside])
            else:
                assert np.array_equal(got, want), (channels, method)
            plan, memory = ntp.clean_plan(ntp.XY, how)
            assert np.array_equal(ntp.clean(image, ntp.XY, how, plan)[0], got)
            del memory
