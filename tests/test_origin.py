# SPDX-License-Identifier: MIT
"""Which kernel made a texture: detected if there is detail, undecided if there is none."""

import numpy as np
import pytest
from PIL import Image

from support import drawn_maps, maps, surfaces
from support import libntp_ffi as ntp
from support import oracle_height as heights
from support import to_height as reconstruction
from support.find import find_kernel as find

TRIED = ["central", "forward", "prewitt3", "sobel3", "scharr3", "prewitt5", "baked"]
NAMES = [*heights.NAMES, "baked"]
MADE = ["forward", "central", "prewitt3", "sobel3", "scharr3", "prewitt5", "sobel5"]


def bricks(n, seed=1):
    rng = np.random.default_rng(seed)
    h = surfaces.bricks(rng, n, n) + 0.15 * surfaces.fractal(rng, n, n)
    slope = np.hypot(np.roll(h, -1, 1) - h, np.roll(h, -1, 0) - h)
    return (h * 0.5 / np.sqrt(np.mean(slope**2))).astype(np.float32)


def named(kernel):
    """It is reported as Sobel 3 x 3: Sobel 5 x 5 is Sobel 3 x 3 of blurred heights."""
    return "sobel3" if kernel == "sobel5" else kernel


@pytest.mark.parametrize("kernel", MADE)
@pytest.mark.parametrize("size", [256, 512])
@pytest.mark.parametrize("surface", [reconstruction.fractal, bricks])
def test_found_where_there_is_detail(surface, size, kernel):
    n = reconstruction.from_height(surface(size), kernel)
    found = find(n)
    if kernel == "sobel5" and not found["decided"]:
        return  # so blurred that there may be too little detail
    assert found["decided"], found
    assert NAMES[found["kernel"]] == named(kernel)
    assert 0.9 < found["misfit"][found["kernel"]] < 1.1
    assert all((m > 0) == (name in TRIED) for m, name in zip(found["misfit"], NAMES, strict=True))


def waves(n, seed, most=4):
    """A smooth tile: at most four cycles."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:n, :n] * (2 * np.pi / n)
    h = np.zeros((n, n))
    for a, b in rng.integers(-most, most + 1, (12, 2)):
        h += rng.normal() * np.cos(a * x + b * y + rng.uniform(0, 7)) / (1 + np.hypot(a, b))
    return (h * n / 10).astype(np.float32)


@pytest.mark.parametrize("kernel", ["central", "sobel3"])
@pytest.mark.parametrize("seed, size", [(3, 256), (3, 512), (8, 256)])
def test_smooth_tiles_are_not_one_sided(seed, size, kernel):
    """All kernels give the same slopes there, but one-sided ones would lie half a texel off."""
    found = find(reconstruction.from_height(waves(size, seed), kernel))
    assert NAMES[found["kernel"]] != "forward" and not found["decided"], found


@pytest.mark.parametrize("kernel", ["forward", "central", "sobel3"])
def test_smooth_slopes_between_texels(kernel):
    """Most kernels explain the residual, but forward slopes lie half a texel further than all others."""
    for seed in (1, 2, 3):
        n = reconstruction.from_height(waves(480, seed, 8), kernel)[31:271, 45:285]
        found = find(np.ascontiguousarray(n))
        assert (NAMES[found["kernel"]] == "forward") == (kernel == "forward"), seed


def noisy(n):
    added = np.random.default_rng(5).normal(0, 5, n.shape)
    return (n + added).clip(0, 255).round().astype(np.uint8)


DAMAGES = {
    "jpeg": lambda n: maps.jpeg(n, 80, 0),
    "blocks": drawn_maps.by_blocks,
    "noise": noisy,
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_slopes_between_texels(damage):
    """No kernel fits, but forward slopes lie half a texel further than all others."""
    tile = bricks(256)
    flat = reconstruction.bumps(256, 12)
    rough = reconstruction.fractal(256, rms_slope=0.6)
    for h in (rough, flat, tile, np.roll(tile, (3, 1), (0, 1))):
        for kernel in ("forward", "central", "sobel3"):
            n = reconstruction.from_height(h.astype(np.float32), kernel)
            found = find(np.ascontiguousarray(DAMAGES[damage](n)))
            assert not found["decided"]
            assert (NAMES[found["kernel"]] == "forward") == (kernel == "forward"), kernel


@pytest.mark.parametrize("kernel", ["forward", "central", "sobel3"])
def test_twice_as_large(kernel):
    """Forward misfits least, whatever the kernel, but where slopes lie tells."""
    n = reconstruction.from_height(reconstruction.fractal(256, 9, 0.3, 2.5), kernel)
    large = Image.fromarray(n).resize((512, 512), Image.BILINEAR)
    found = find(np.ascontiguousarray(np.asarray(large)[:256, :256]))
    fits = [m for m in found["misfit"] if m >= 0]
    assert min(fits) == found["misfit"][NAMES.index("forward")] > 1.2
    assert not found["decided"]
    assert (NAMES[found["kernel"]] == "forward") == (kernel == "forward"), found


def test_orientation_matters():
    n = reconstruction.from_height(reconstruction.fractal(256))
    n[..., 1] = 255 - n[..., 1]
    assert find(n, ntp.DOWN)["decided"]
    wrong = find(n, ntp.UP)
    assert not wrong["decided"]


@pytest.mark.parametrize("dtype", [np.uint16, np.float32])
def test_deep_textures(dtype):
    h = reconstruction.fractal(256)
    for kernel in ["forward", "sobel3"]:
        vector = dtype == np.float32
        n = reconstruction.from_height(h, kernel, dst=dtype, vector=vector)
        if vector:
            n = ((n + 1) / 2).astype(np.float32)
        found = find(n)
        assert NAMES[found["kernel"]] == kernel
        assert vector or found["decided"]  # floats are rounded finer than the grid of 16 bit


def test_encodings_agree():
    n = reconstruction.from_height(reconstruction.fractal(128), "scharr3")
    one = find(n)
    zzero = n.copy()
    zzero[..., 2] = 77
    assert find(zzero, encoding=ntp.ZZERO) == one  # blue is not looked at
    assert find(np.ascontiguousarray(n[..., :2]), encoding=ntp.XY) == one


def test_left_open():
    """Smooth, flat, noisy, damaged and tiny textures are undecided."""
    y, x = np.mgrid[:256, :256]
    smooth = 20 * np.sin(2 * np.pi * x / 256) * np.cos(2 * np.pi * y / 256)
    rng = np.random.default_rng(5)
    fractal = reconstruction.from_height(reconstruction.fractal(256))
    noisy = np.clip(np.round(fractal + rng.normal(0, 3, fractal.shape)), 0, 255).astype(np.uint8)
    cases = {
        "smooth": reconstruction.from_height(smooth.astype(np.float32)),
        "flat": np.full((64, 64, 3), (128, 128, 255), np.uint8),
        "noise": rng.integers(0, 256, (256, 256, 3), dtype=np.uint8),
        "noisy": noisy,
        "JPEG": maps.jpeg(fractal, 90, 0),
        "black": np.zeros((64, 64, 3), np.uint8),
        "tiny": fractal[:12, :12].copy(),
        "a texel": fractal[:1, :1].copy(),
        "a row": fractal[:1].copy(),
    }
    for name, n in cases.items():
        found = find(n)
        assert not found["decided"], (name, found)
        damaged = name in ("noise", "noisy", "JPEG")
        likely = ["central", "baked"] if damaged else ["central"]
        assert [*NAMES, "baked"][found["kernel"]] in likely, (name, found)


BAKED = len(heights.NAMES)


def sampled(h):
    """Normals of the smooth surface through heights that tile, at their places."""
    spectrum = np.fft.fft2(h)
    wave = [2j * np.pi * np.fft.fftfreq(n) for n in h.shape]
    for w in wave:
        w[len(w) // 2] = 0
    p = np.fft.ifft2(spectrum * wave[1]).real
    q = np.fft.ifft2(spectrum * wave[0][:, None]).real
    v = np.stack([-p, q, np.ones_like(p)], -1)
    return maps.encode(v / np.linalg.norm(v, axis=-1, keepdims=True))


def test_a_blur_shows_under_damage():
    """Much of what sobel3 made is taken for central, and no surface is."""
    seen = []
    for seed in range(4):
        for exponent, slope in ((1.6, 1), (2, 1.5)):
            h = reconstruction.fractal(256, seed, slope, exponent)
            noise = np.random.default_rng(seed).normal(0, 3, (*h.shape, 3))
            for n in (reconstruction.from_height(h, "sobel3"), maps.to_type(sampled(h))):
                for damaged in (maps.jpeg(n, 95, 0), np.clip(n + noise, 0, 255).astype(np.uint8)):
                    found = find(damaged)
                    m = {k: found["misfit"][NAMES.index(k)] for k in TRIED}
                    blurred = m["sobel3"] < 0.95 * m["scharr3"] and m["baked"] < 0.92 * m["central"]
                    blurred &= m["sobel3"] > 0.7 * m["central"]
                    baked = m["baked"] < 1.03 * m["central"] and not blurred
                    assert not found["decided"]
                    assert NAMES[found["kernel"]] == ("baked" if baked else "central"), m
                    seen.append(baked)
    sobel, surface = (np.reshape(seen, (-1, 2, 2))[:, k] for k in (0, 1))
    assert surface.all() and 8 <= (~sobel).sum() <= 14, seen


def test_damage_takes_the_kernel_that_errs_least():
    """None fits; central is off by far on what it did not make, baked on nothing."""
    rough = reconstruction.fractal(160, seed=3)
    wave = np.arange(160) * (2 * np.pi / 160)
    even = 3 * np.sin(3 * wave)[:, None] * np.cos(2 * wave) + 2 * np.cos(5 * wave)
    rng = np.random.default_rng(2)
    cases = [(rough, maps.jpeg(maps.to_type(sampled(rough)), 90, 0), "baked")]
    cases += [(rough, maps.jpeg(reconstruction.from_height(rough), 97, 0), "central")]
    noisy = reconstruction.from_height(even) + rng.normal(0, 4, (160, 160, 3))
    cases += [(even, np.clip(noisy, 0, 255).round().astype(np.uint8), "baked")]
    for h, n, expected in cases:
        found = find(n)
        assert not found["decided"]
        assert [*NAMES, "baked"][found["kernel"]] == expected, found
        error = [np.std(reconstruction.to_height(n, kernel=k)[0] - h) for k in (0, BAKED)]
        assert error[expected == "baked"] < 0.95 * error[expected != "baked"]


def test_holes_do_not_matter():
    n = reconstruction.from_height(reconstruction.fractal(256), "forward")
    n = np.dstack([n, np.full(n.shape[:2], 255, np.uint8)])
    n[100:140, 60:90, :3] = 0
    n[30:40, 30:70, 3] = 0
    n[30:40, 30:70, 0] = np.arange(40) * 6
    found = find(n)
    assert found["decided"] and NAMES[found["kernel"]] == "forward"
    assert found["points"] < find(n[..., :3].copy(), touch=ntp.UNUSED_ALL)["points"] + 3000


def test_against_a_model():
    """The misfit of central by numpy, over the points that the library takes."""
    n = reconstruction.from_height(reconstruction.fractal(100), "central")
    p, q = reconstruction.slopes(n, ntp.XY)
    variance = (2 / 255) ** 2 / 12 * (1 + p * p + q * q)
    noise_p = variance * ((1 + p * p) ** 2 + p * p * q * q)
    noise_q = variance * ((1 + q * q) ** 2 + p * p * q * q)

    def shift(a, dx, dy):
        return np.roll(a, (-dy, -dx), (0, 1))

    e = (shift(p, 0, 1) - shift(p, 0, -1) - shift(q, 1, 0) + shift(q, -1, 0)) / 2
    expected = sum(shift(noise_p, 0, d) + shift(noise_q, d, 0) for d in (-1, 1)) / 4
    binomial = np.array([1, 4, 6, 4, 1]) / 16

    def seen(a, along):
        for axis in (0, 1):
            a = sum(w * np.roll(a, k - 2, axis) for k, w in enumerate(binomial))
        return np.abs(np.roll(a, -1, along) - np.roll(a, 1, along)) / 2

    worth = np.minimum(seen(p, 0), seen(q, 1)) > 2 / 255
    inside = np.zeros_like(worth)
    inside[5:-5, 5:-5] = True
    steep = np.hypot(p, q) > 9.9
    assert not steep.any()
    square = (e * e / expected)[worth & inside]
    found = find(n)
    assert found["points"] == pytest.approx(len(square), abs=3)
    assert found["misfit"][0] == pytest.approx(np.mean(square / (1 + square / 100)), rel=1e-3)


def test_errors():
    n = np.zeros((8, 8, 3), np.uint8)
    origin = ntp.ffi.new("ntp_kernel_fit *")
    src = ntp.view(n, ntp.STANDARD, const=True)
    find_origin = ntp.lib.ntp_find_kernel
    assert find_origin(origin, src, 0) == ntp.OK
    assert find_origin(ntp.ffi.NULL, src, 0) == ntp.ERR_ARGUMENT
    assert find_origin(origin, ntp.ffi.NULL, 0) == ntp.ERR_ARGUMENT
    assert find_origin(origin, src, 8) == ntp.ERR_ARGUMENT
    src.ring_rows = 4
    assert find_origin(origin, src, 0) == ntp.ERR_SHAPE
    gray = np.zeros((8, 8), np.uint8)
    height = ntp.view(gray, ntp.HEIGHT, const=True)
    assert find_origin(origin, height, 0) == ntp.ERR_FORMAT
