# SPDX-License-Identifier: MIT
"""Properties of single texels, 8 and 16 bit, searched by hypothesis for a counterexample."""

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from support import libntp_ffi as ntp
from support import oracle
from support.sanitized import EVERY

# The same examples at each run, however long a busy machine takes to draw them.
settings.register_profile(
    "texels",
    max_examples=300 // EVERY,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)
settings.load_profile("texels")

DEPTHS = {255: np.uint8, 65535: np.uint16}
METHODS = {"derive": ntp.DERIVE, "normalize": ntp.NORMALIZE, "keep": ntp.KEEP}


@st.composite
def texels(draw):
    """(M, r, g, b), mostly in critical places: near the edge of the disc and near the sphere."""
    m = draw(st.sampled_from(list(DEPTHS)))
    level = st.integers(0, m)
    r, g, b = draw(level), draw(level), draw(level)
    if draw(st.booleans()):  # g near the edge of the disc for this r
        y = int(max(m * m - (2 * r - m) ** 2, 0) ** 0.5)
        g = min(max((m + draw(st.sampled_from([-1, 1])) * y) // 2 + draw(st.integers(-3, 3)), 0), m)
    if draw(st.booleans()):  # b near the sphere
        inside = oracle.pull(r, g, m)
        b = oracle.derived_blue(*inside, m, draw(st.booleans())) + draw(st.integers(-3, 3))
        b = min(max(draw(st.sampled_from([b, m - b])), 0), m)
    return m, r, g, b


def library_clean(m, texel, encoding, method, keep):
    how = ntp.clean_options(METHODS[method], keep, touch_unused=7)
    array = np.array([[texel]], DEPTHS[m])
    return tuple(ntp.clean(array, encoding, how)[0][0, 0].tolist())


@given(texels(), st.booleans(), st.sampled_from(list(METHODS)), st.booleans())
@example((65535, 65535, 65534, 0), False, "derive", False)
@example((65535, 32767, 65535, 40000), False, "derive", False)
@example((65535, 32767, 65535, 40000), True, "normalize", True)
def test_clean(texel, zz, method, keep):
    m, *rgb = texel
    encoding = ntp.ZZERO if zz else ntp.STANDARD
    got = library_clean(m, rgb, encoding, method, keep)
    assert got == oracle.cleaned(*rgb, m, zz, method, keep)
    assert library_clean(m, got, encoding, method, keep) == got


@given(texels(), st.booleans(), st.booleans())
def test_validate(texel, zz, keep):
    m, r, g, b = texel
    encoding = ntp.ZZERO if zz else ntp.STANDARD
    flags = int(ntp.validate(np.array([[[r, g, b]]], DEPTHS[m]), encoding, keep)[0, 0]) & 31
    want = oracle.neighbor(r, g, b, m, zz) + 2 * oracle.rounded(r, g, b, m, zz)
    want += 4 * oracle.exact(r, g, b, m, zz, keep) + 8 * (oracle.radicand(r, g, m) < 0)
    assert flags == want + 16 * oracle.z_negative(b, m, zz)


@given(texels(), st.sampled_from(["derive", "normalize"]), st.booleans())
def test_symmetry(texel, method, zz):
    """Cleaning commutes with mirroring red, mirroring green and swapping the two."""
    m, r, g, b = texel
    encoding = ntp.ZZERO if zz else ntp.STANDARD
    cr, cg, cb = library_clean(m, (r, g, b), encoding, method, 0)
    assert library_clean(m, (m - r, g, b), encoding, method, 0) == (m - cr, cg, cb)
    assert library_clean(m, (r, m - g, b), encoding, method, 0) == (cr, m - cg, cb)
    assert library_clean(m, (g, r, b), encoding, method, 0) == (cg, cr, cb)


@given(texels())
def test_exact_implies_rounded_implies_neighbor(texel):
    m, r, g, b = texel
    for encoding in (ntp.STANDARD, ntp.ZZERO):
        flags = int(ntp.validate(np.array([[[r, g, b]]], DEPTHS[m]), encoding)[0, 0])
        assert flags & 7 in (0, 1, 3, 7)


@pytest.mark.parametrize("zz", [False, True])
def test_ends_of_the_passing_blues_16_bit(zz):
    """For many (r, g) of 16 bit the blues that pass are those of the closed form, to the level."""
    m, rng = 65535, np.random.default_rng(6)
    x = np.sort(rng.choice(np.arange(1, m + 1, 2), 400))
    turn = rng.uniform(0, np.pi / 2, 300)
    pairs = np.concatenate(
        [
            rng.choice(x, (300, 2)),
            np.stack([np.cos(turn), np.sin(turn)], 1)
            * rng.uniform(0.999, 1.0001, (300, 1))
            * m
            // 2
            * 2
            + 1,
        ]
    ).astype(np.int64)
    pairs = np.minimum(pairs, m)
    encoding = ntp.ZZERO if zz else ntp.STANDARD
    for ax, ay in pairs.tolist():
        r, g = (m + ax) // 2, (m - ay) // 2
        s = max(oracle.radicand(r, g, m), 0)
        z = int(s**0.5)
        middle = z if zz else (m + z + 1) // 2
        near = np.arange(max(middle - 700, 0), min(middle + 700, m) + 1)
        array = np.stack(np.broadcast_arrays(r, g, near), 1)[None].astype(np.uint16)
        got = ntp.validate(array, encoding)[0] & 15
        assert np.array_equal(got, oracle.flags(r, g, near, m, zz) & 15), (r, g)
