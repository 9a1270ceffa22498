# SPDX-License-Identifier: MIT
"""ntp_inspect: everything that can be said about one texel, against the slow oracle."""

import math

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle
from support.texels import random_texels

NAMES = {ntp.STANDARD: "standard", ntp.ZZERO: "zzero", ntp.XY: "xy"}


def inspect(array, encoding, x=0, y=0, keep=0):
    texel = ntp.ffi.new("ntp_texel *")
    ntp.check(ntp.lib.ntp_inspect(texel, ntp.view(array, encoding, const=True), x, y, keep))
    return ntp.fields(texel)


def expected(texel, m, encoding, keep):
    """(cleaned levels, flags, levels_off, vector, angle)."""
    r, g, b = texel
    zz = encoding == ntp.ZZERO
    over = oracle.radicand(r, g, m) < 0
    if encoding == ntp.XY:
        pulled = oracle.pull(r, g, m)
        flags = ntp.XY_TOO_LONG if over else 7
        x, y = (2 * r - m) / m, (2 * g - m) / m
        z = 0.0 if over else math.sqrt(oracle.radicand(r, g, m)) / m
        cleaned_z = 2 * oracle.derived_blue(*pulled, m) - m
        stored_z = 0 if over else 2 * oracle.derived_blue(r, g, m) - m
        to = (2 * pulled[0] - m, 2 * pulled[1] - m, cleaned_z)
        degrees = oracle.angle((2 * r - m, 2 * g - m, stored_z), to)
        return (*pulled, b), flags, -1 if over else 0, (x, y, z), degrees
    cleaned = oracle.cleaned(r, g, b, m, zz, "derive", keep)
    flags = oracle.neighbor(r, g, b, m, zz) + 2 * oracle.rounded(r, g, b, m, zz)
    flags += 4 * oracle.exact(r, g, b, m, zz, keep) + 8 * over
    flags += 16 * oracle.z_negative(b, m, zz)
    vector = oracle.vector(texel, m, zz)
    degrees = oracle.angle(vector, oracle.vector(cleaned, m, zz))
    return cleaned, flags, oracle.levels_off(r, g, b, m, zz), vector, degrees


@pytest.mark.parametrize("m,dtype", [(255, np.uint8), (65535, np.uint16), (65535, np.float32)])
@pytest.mark.parametrize("encoding", NAMES, ids=NAMES.get)
@pytest.mark.parametrize("keep", [0, 1])
def test_texels(m, dtype, encoding, keep):
    texels = random_texels(m, 250, seed=m + encoding)
    array = (texels / m).astype(dtype) if dtype == np.float32 else texels.astype(dtype)
    for x, texel in enumerate(texels.tolist()):
        got = inspect(array[None], encoding, x, 0, keep)
        cleaned, flags, off, vector, degrees = expected(texel, m, encoding, keep)
        if texel in ([0, 0, 0], [m, m, m]):
            flags |= ntp.IS_UNUSED
        assert got["stored"] == [*texel, m]
        assert got["max"] == m
        assert tuple(got["cleaned"]) == cleaned, texel
        assert (got["flags"], got["levels_off"]) == (flags, off), texel
        assert (got["x"], got["y"], got["z"]) == pytest.approx(vector, abs=1e-12)
        assert got["length"] == pytest.approx(math.hypot(*vector), abs=1e-12)
        assert got["angle"] == pytest.approx(degrees, abs=1e-6), texel


def test_flags_are_those_of_validate():
    array = random_texels(255, 400, seed=3)[None].astype(np.uint8)
    for encoding in NAMES:
        mask = ntp.validate(array, encoding, 1)
        for x in range(array.shape[1]):
            assert inspect(array, encoding, x, 0, 1)["flags"] == mask[0, x]


def test_alpha_and_unused():
    array = np.array([[[128, 128, 255, 0], [0, 0, 0, 255], [255, 255, 255, 9]]], np.uint8)
    for x, alpha in enumerate((0, 255, 9)):
        got = inspect(array, ntp.STANDARD, x)
        assert got["stored"][3] == alpha
        assert got["flags"] & ntp.IS_UNUSED
    opaque = inspect(np.full((1, 1, 4), 200, np.uint8), ntp.STANDARD)
    assert not opaque["flags"] & ntp.IS_UNUSED


def test_two_channels():
    got = inspect(np.array([[[255, 255]]], np.uint8), ntp.XY)
    assert got["flags"] & ntp.XY_TOO_LONG and got["levels_off"] == -1 and got["z"] == 0


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_not_finite(value):
    for encoding in (ntp.STANDARD, ntp.ZZERO, ntp.VECTOR):
        for k in range(3):
            array = np.array([[[0.5, 0.5, 1.0]]], np.float32)
            array[0, 0, k] = value
            got = inspect(array, encoding)
            assert got["flags"] & ntp.NOT_FINITE and not got["flags"] & 7
            assert list(got["cleaned"]) == [32768, 32768, 65535] and got["levels_off"] == -1
            cleaned, changed, broken = ntp.clean(array, encoding)
            assert (changed, broken) == (1, 1)
            zero = 0.0 if encoding == ntp.VECTOR else 0.5
            assert cleaned.ravel().tolist() == [zero, zero, 1.0]


def test_vectors():
    """A float vector is judged after rounding to 16 bit; what passes stays bit for bit."""
    rng = np.random.default_rng(4)
    v = rng.normal(size=(1, 2000, 3))
    v /= np.linalg.norm(v, axis=2, keepdims=True)
    v = v.astype(np.float32)
    levels = np.clip(np.floor((v.astype(np.float64) + 1) / 2 * 65535 + 0.5), 0, 65535).astype(int)
    want = oracle.flags(*levels[0].T, 65535)
    assert np.array_equal(ntp.validate(v, ntp.VECTOR)[0], want)
    for method, name in ((ntp.DERIVE, "derive"), (ntp.NORMALIZE, "normalize")):
        got, changed, _ = ntp.clean(v, ntp.VECTOR, ntp.clean_options(method))
        again, nothing, _ = ntp.clean(got, ntp.VECTOR, ntp.clean_options(method))
        assert nothing == 0 and np.array_equal(again, got)
        count = 0
        for old, texel, new in zip(v[0, :300], levels[0, :300].tolist(), got[0, :300]):
            cleaned = np.array(oracle.cleaned(*texel, 65535, False, name))
            same = cleaned == texel
            made = ((2 * cleaned - 65535) / 65535).astype(np.float32)
            assert np.array_equal(new, np.where(same, old, made)), texel
            count += not same.all()
        assert changed >= count


def test_errors():
    array = np.zeros((4, 5, 3), np.uint8)
    texel, src = ntp.ffi.new("ntp_texel *"), ntp.view(array, const=True)
    for x, y in ((-1, 0), (5, 0), (0, -1), (0, 4)):
        assert ntp.lib.ntp_inspect(texel, src, x, y, 0) == ntp.ERR_ARGUMENT
    assert ntp.lib.ntp_inspect(ntp.ffi.NULL, src, 0, 0, 0) == ntp.ERR_ARGUMENT
    assert ntp.lib.ntp_inspect(texel, ntp.ffi.NULL, 0, 0, 0) == ntp.ERR_ARGUMENT
