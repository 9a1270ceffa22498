# SPDX-License-Identifier: MIT
"""`ntp_normals_like`: the pictures of other programs, each by a model of its formula."""

from fractions import Fraction

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import oracle
from support import oracle_height as model

GIMP_FILTERS = {  # its kernels for du as it applies them, and the response to a unit ramp
    "4sample": [[Fraction(-1, 2), 0, Fraction(1, 2)]],
    "sobel3": model.outer([1, 2, 1], [-1, 0, 1]),
    "sobel5": model.outer([1, 4, 6, 4, 1], [-1, -2, 0, 2, 1]),
    "prewitt3": model.outer([1, 1, 1], [-1, 0, 1]),
    "prewitt5": model.outer([1] * 5, [-1, -2, 0, 2, 1]),
    "3x3": [[Fraction(w, 6) for w in (-1, 0, 1)]] * 3,
    "7x7": [[Fraction(w, 138) for w in row] for row in model.ramp(3, [0, 1, 2, 3, 2, 1, 0])],
    "9x9": [[Fraction(w, 308) for w in row] for row in model.ramp(4, [0, 1, 2, 3, 4, 3, 2, 1, 0])],
}
_five = [
    [Fraction(1, 10), Fraction(1, 16)],
    [Fraction(1000, 2800), Fraction(1, 10)],
    [Fraction(1, 2), Fraction(1, 8)],
]
_five = model.mirrored([_five[0], _five[1], _five[2], _five[1], _five[0]])
GIMP_FILTERS["5x5"] = [[w / sum(abs(v) for r in _five for v in r) for w in row] for row in _five]


def peer(name, value):
    result = ntp.ffi.new("ntp_peer *")
    ntp.check(ntp.lib.ntp_normals_like(result, name.encode(), value))
    return result


def as_peer(src, name, value):
    """Our picture with a peer's settings, its channel order included."""
    likeness = peer(name, value)
    out = np.zeros((*src.shape[:2], 3), np.uint8)
    view = ntp.view(src, ntp.HEIGHT, const=True)
    null = ntp.ffi.NULL
    made = ntp.view(out, ntp.STANDARD, likeness.y)
    options = ntp.ffi.addressof(likeness, "options")
    ntp.check(ntp.lib.ntp_normals_from_height(made, view, options, null, null))
    return out[..., [0, 2, 1]] if likeness.swap_green_blue else out


def rounded_normal(nx, ny):
    """Levels of (nx, ny, 1) / length, red and green rounded half up, blue derived."""
    length = 1 + nx * nx + ny * ny
    r = model.level(nx * nx / length, nx < 0, 255) if nx else 128
    g = model.level(ny * ny / length, ny < 0, 255) if ny else 128
    r, g = oracle.pull(r, g, 255)
    return r, g, oracle.derived_blue(r, g, 255)


def peer_model(h, vector):
    """The picture of `vector(get, x, y)`, get(x, y) a height."""
    height, width = len(h), len(h[0])
    out = np.zeros((height, width, 3), np.uint8)
    for y in range(height):
        for x in range(width):
            out[y, x] = rounded_normal(*vector(x, y))
    return out


def color_image(seed=30):
    return np.random.default_rng(seed).integers(0, 256, (9, 11, 3)).astype(np.uint8)


@pytest.mark.parametrize("hfs", [5.0, 15.0, -5.0, 7.5])
def test_like_reference(hfs):
    """x = hfs (h[left] - h[right])/255 of red, unhalved; y = hfs (h[above] - h[below]), negated."""
    src = color_image()
    h = [[Fraction(int(v), 255) for v in row] for row in src[..., 0]]
    rows, columns = len(h), len(h[0])

    def vector(x, y):
        s = Fraction(hfs)
        return (
            s * (h[y][(x - 1) % columns] - h[y][(x + 1) % columns]),
            -s * (h[(y - 1) % rows][x] - h[(y + 1) % rows][x]),
        )

    assert np.array_equal(as_peer(src, "reference", hfs), peer_model(h, vector))


@pytest.mark.parametrize("sigma", [4.0, 1.0])
def test_like_eberly(sigma):
    """(sigma dx, sigma dy, 1) of a y-down image with dx = h[x+1] - h[x-1]."""
    src = color_image()
    h = model.heights(src, "luma-eberly")
    rows, columns = len(h), len(h[0])

    def vector(x, y):
        s = Fraction(sigma)
        return (
            s * (h[y][(x + 1) % columns] - h[y][(x - 1) % columns]),
            s * (h[(y + 1) % rows][x] - h[(y - 1) % rows][x]),
        )

    assert np.array_equal(as_peer(src, "eberly", sigma), peer_model(h, vector))


@pytest.mark.parametrize("name, sign", [("zima", 1), ("zima-corrected", -1)])
def test_like_zima(name, sign):
    """Sobel sums times the strength, unnormalized; the up vector lies in green."""
    src = color_image()
    h = model.heights(src)
    rows, columns = len(h), len(h[0])

    def vector(x, y):
        def at(i, j):
            return h[(y + j) % rows][(x + i) % columns]

        dx = at(1, -1) + 2 * at(1, 0) + at(1, 1) - at(-1, -1) - 2 * at(-1, 0) - at(-1, 1)
        dy = at(-1, 1) + 2 * at(0, 1) + at(1, 1) - at(-1, -1) - 2 * at(0, -1) - at(1, -1)
        return sign * Fraction(3, 2) * dx, sign * Fraction(3, 2) * dy

    expected = peer_model(h, vector)[..., [0, 2, 1]]
    assert np.array_equal(as_peer(src, name, 1.5), expected)


def test_like_gegl():
    """s/2 (h[x-1] - h[x+1]) and s/2 (h[y-1] - h[y+1]) of gray, clamped."""
    src = color_image()[..., :1].copy()
    h = model.heights(src)

    def vector(x, y):
        def at(i, j):
            return h[min(max(y + j, 0), 8)][min(max(x + i, 0), 10)]

        return 5 * (at(-1, 0) - at(1, 0)), 5 * (at(0, -1) - at(0, 1))

    assert np.array_equal(as_peer(src, "gegl", 10.0), peer_model(h, vector))


@pytest.mark.parametrize("name", GIMP_FILTERS)
def test_like_gimp_normalmap(name):
    """(-du s, -dv s, 1); 5x5 is compared in red where dv (which has wrong taps) is not there."""
    src = color_image()
    if name == "5x5":
        src[:] = src[:1]
    h = model.heights(src, "luma-gimp")
    taps = GIMP_FILTERS[name]
    cy, cx = len(taps) // 2, len(taps[0]) // 2
    scale = Fraction(5, 4)

    def vector(x, y):
        def at(i, j):
            return h[min(max(y + j, 0), 8)][min(max(x + i, 0), 10)]

        du = dv = Fraction(0)
        for j, row in enumerate(taps):
            for i, w in enumerate(row):
                du += w * at(i - cx, j - cy)
                dv += w * at(j - cy, i - cx)
        return -du * scale, -dv * scale

    ours = as_peer(src, "gimp-normalmap:" + name, 1.25)
    assert np.array_equal(ours, peer_model(h, vector))


def test_like_rounds_the_scale_once():
    rng = np.random.default_rng(31)
    for value in [0.0, 0.1, 1.25, -3.7, 1e-310, 5e-324, *rng.normal(size=200)]:
        for name, gain in (("5x5", Fraction(36, 29)), ("9x9", Fraction(170, 77))):
            exact = Fraction(float(value)) * gain
            result = peer("gimp-normalmap:" + name, float(value))  # owns the memory
            assert result.options.scale == exact.numerator / exact.denominator
    for name, value in (("nobody", 1.0), ("gegl", float("nan")), ("gimp-normalmap", 1.0)):
        result = ntp.ffi.new("ntp_peer *")
        assert ntp.lib.ntp_normals_like(result, name.encode(), value) == ntp.ERR_ARGUMENT
