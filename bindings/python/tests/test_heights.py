# SPDX-License-Identifier: MIT
"""Heights to normals against exact fractions, and back against least squares in numpy."""

import hypothesis
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import normaltexture as nt
from pysupport.drawn import heights, textures
from support import oracle_height as oracle

KERNELS = list(oracle.KERNELS)
BORDERS = ["wrap", "clamp", "mirror", "extrapolate", "repeat-slope"]
scales = st.sampled_from([0.0, 1.0, -2.5, 0.01, 300.0])


@hypothesis.settings(max_examples=120)
@given(
    heights(max_side=6),
    st.sampled_from(KERNELS),
    st.sampled_from(BORDERS),
    st.sampled_from(BORDERS),
    scales,
    st.sampled_from([(1.0, 1.0), (0.5, 2.0)]),
    st.booleans(),
    st.sampled_from([0.0, 0.3]),
    st.sampled_from(["up", "down"]),
    st.sampled_from(["standard", "zzero", "xy"]),
    st.sampled_from(["derived", "nearest"]),
    st.sampled_from([8, 16]),
)
def test_normals_from_height(
    height, kernel, border_x, border_y, scale, spacing, invert, min_z, to_y, to, blue, depth
):
    want = oracle.normals(
        height, kernel, BORDERS.index(border_x), BORDERS.index(border_y), scale, *spacing,
        invert=invert, dst=np.uint8 if depth == 8 else np.uint16, min_z=min_z,
        y_down=to_y == "down", zz=to == "zzero", xy=to == "xy", nearest=blue == "nearest",
    )  # fmt: skip
    got = nt.normals_from_height(
        height, kernel=kernel, border_x=border_x, border_y=border_y, scale=scale,
        dx=spacing[0], dy=spacing[1], invert=invert, min_z=min_z, to_y=to_y, to=to, blue=blue,
        depth=depth,
    )  # fmt: skip
    assert np.array_equal(got, want)


@given(textures(max_side=5), st.sampled_from(list(oracle.SOURCES)))
def test_sources(picture, source):
    if source == "alpha" and picture.shape[2] == 3:
        with pytest.raises(nt.ArgumentError, match=r'source="alpha"'):
            nt.normals_from_height(picture, scale=1, source=source)
        return
    want = oracle.normals(picture, scale=2.0, source=source, dst=picture.dtype.type)
    got = nt.normals_from_height(picture, scale=2, source=source)
    assert np.array_equal(got[..., :3], want)
    if picture.shape[2] == 4 and source != "alpha":
        assert np.array_equal(got[..., 3], picture[..., 3])


@given(heights((np.uint8,)))
def test_alpha(height):
    m = 255
    gray_alpha = np.stack([height, height[::-1]], -1)
    for alpha, want in (
        ("keep", height[::-1]),
        ("one", np.full_like(height, m)),
        ("inverse", m - height[::-1]),
        ("height", height),
        ("inverse-height", m - height),
    ):
        got = nt.normals_from_height(gray_alpha, scale=1, alpha=alpha)
        assert np.array_equal(got[..., 3], want), alpha
    assert nt.normals_from_height(height, scale=1).shape[2] == 3
    assert nt.normals_from_height(height, scale=1, alpha="height").shape[2] == 4


@given(heights((np.uint8, np.uint16)), scales)
def test_results_are_clean(height, scale):
    normals = nt.normals_from_height(height, scale=scale)
    assert (nt.validate(normals) & nt.Flag.EXACT > 0).all()


def gaussian(height, sigma):
    """A blur that wraps, in real numbers."""
    for axis in (0, 1):
        n = height.shape[axis]
        radius = int(4 * sigma) + 2
        i = np.arange(-radius, radius + 1)
        weights = np.exp(-(i * i) / (2 * sigma * sigma))
        parts = [w * np.roll(height, -k, axis) for k, w in zip(i, weights / weights.sum())]
        height = np.sum(parts, 0).reshape(height.shape) if n else height
    return height


def test_blur_and_octaves():
    height = np.random.default_rng(2).random((40, 48)).astype(np.float32)
    for how, blurred in (
        ({"sigma": 1.5}, gaussian(height, 1.5)),
        ({"octaves": [1, 2, 0.5]}, height + 2 * gaussian(height, 1) + 0.5 * gaussian(height, 2)),
        ({"sigma": 3, "octaves": [0, 1]}, gaussian(height, 10**0.5)),
    ):
        got = nt.normals_from_height(nt.blur_height(height, **how), scale=4, to="vector")
        want = nt.normals_from_height(blurred.astype(np.float32), scale=4, to="vector")
        assert np.abs(got - want).max() < 2e-3, how


def test_like_and_dither():
    height = (np.random.default_rng(3).random((20, 24)) * 255).astype(np.uint8)
    same = [
        (("reference", 3), {"scale": 6}),
        (("eberly", 4), {"scale": -8, "to_y": "down"}),
        (("gegl", 10), {"scale": 10, "to_y": "down", "border": "clamp"}),
        (("gimp-normalmap:sobel3", 1), {"scale": 8, "kernel": "sobel3", "to_y": "down",
                                     "border": "clamp"}),
    ]  # fmt: skip
    for like, settings in same:
        got = nt.normals_from_height(height, **nt.like(*like))
        assert np.array_equal(got, nt.normals_from_height(height, **settings)), like
    zima = nt.normals_from_height(height, **nt.like("zima", 1))
    plain = nt.normals_from_height(height, scale=-8, kernel="sobel3", to_y="down", border="wrap")
    assert np.array_equal(zima, plain)
    dithered = nt.normals_from_height(height, scale=3, dither="integrable")
    off = dithered.astype(int) - nt.normals_from_height(height, scale=3)
    assert off.any() and np.abs(off[..., :2]).max() <= 2


# ------------------------------------------------------------------------ reconstruction


def slope_matrix(n, border):
    """Central slopes along an axis of n heights."""
    d = np.zeros((n, n))
    for i in range(n):
        for offset, weight in ((-1, -0.5), (1, 0.5)):
            for index, share in oracle.reflect(i + offset, n, BORDERS.index(border)):
                d[i, index] += weight * float(share)
    return d


def least_squares(p, q, border):
    """The heights of least norm whose central slopes come nearest to p, right, and q, down."""
    h, w = p.shape
    matrix = np.vstack(
        [
            np.kron(np.eye(h), slope_matrix(w, border)),
            np.kron(slope_matrix(h, border), np.eye(w)),
        ]
    )
    return np.linalg.lstsq(matrix, np.concatenate([p.ravel(), q.ravel()]), rcond=1e-11)[0]


@pytest.mark.parametrize("border", ["wrap", "clamp"])
@pytest.mark.parametrize("shape", [(5, 7), (8, 6), (1, 4)])
def test_height_from_normals_is_least_squares(border, shape):
    rng = np.random.default_rng(sum(shape))
    p, q = rng.standard_normal((2, *shape))
    vectors = np.stack([-p, q, np.ones(shape)], -1)
    vectors = (vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)).astype(np.float32)
    v = vectors.astype(np.float64)
    want = least_squares(-v[..., 0] / v[..., 2], v[..., 1] / v[..., 2], border).reshape(shape)
    for threads in (1, 3):
        got, info = nt.height_from_normals_with_info(
            vectors, type="vector", y="up", kernel="central", border=border, z="stored",
            threads=threads,
        )  # fmt: skip
        assert np.abs(got - want).max() < 1e-5 * max(1, np.abs(want).max())
        assert (info.kernel, info.border_x, info.y) == ("central", border, "up")
        assert info.scale == pytest.approx(np.ptp(want), rel=1e-5)
        assert info.offset == pytest.approx(want.min(), rel=1e-5, abs=1e-6)


def hill(size):
    y, x = np.mgrid[0:size, 0:size] / (size / 2) - 1
    return np.exp(-4 * (x * x + y * y)).astype(np.float32)


@pytest.mark.parametrize("to_y", ["up", "down"])
def test_heights_come_back(to_y):
    """Height -> 16-bit normals -> height, the direction of green found out."""
    height = hill(128)
    normals = nt.normals_from_height(height, scale=20, border="extrapolate", to_y=to_y)
    again, info = nt.height_from_normals_with_info(normals)
    assert info.y == to_y
    assert np.abs(again / 20 - (height - height.mean())).max() < 2e-3
    shape = (again - info.offset) / info.scale
    assert shape.min() == pytest.approx(0, abs=1e-6) and shape.max() == pytest.approx(1, abs=1e-6)
    made = nt.normals_from_height(
        shape.astype(np.float32), scale=info.scale, border="extrapolate", to_y=to_y
    )
    assert nt.compare(made, normals, y=to_y).angles.mean < 0.02


def test_progress_and_cancellation():
    normals = nt.normals_from_height(hill(128), scale=20, depth=8)
    shares = []
    nt.height_from_normals(normals, progress=shares.append, threads=2)
    assert shares == sorted(shares) and shares and 0 <= shares[0] and shares[-1] <= 1
    with pytest.raises(nt.CancelledError) as raised:
        nt.height_from_normals(normals, progress=lambda share: False)
    assert raised.value.status == nt.Status.CANCELLED

    def interrupted(share):
        raise KeyboardInterrupt

    for threads in (1, 3):
        with pytest.raises(KeyboardInterrupt):
            nt.height_from_normals(normals, progress=interrupted, threads=threads)


def rough(size, slope, seed=1):
    """A random surface that tiles, with this root mean square slope."""
    rng = np.random.default_rng(seed)
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(size), np.fft.fftfreq(size)))
    f[0, 0] = 1
    h = np.fft.ifft2(np.fft.fft2(rng.standard_normal((size, size))) / f**2).real
    steps = np.roll(h, -1, 1) - h, np.roll(h, -1, 0) - h
    return (h * slope / np.sqrt(np.mean(np.square(steps)))).astype(np.float32)


@pytest.mark.parametrize("tiles", [True, False])
def test_where_no_border_shows_the_best_fit_decides(tiles):
    """Of noisy normals, whose edges show nothing."""
    h = rough(96, 0.3)
    if not tiles:
        h = h[:80, :64] + np.float32(0.4) * np.arange(64, dtype=np.float32)
    made = nt.normals_from_height(h, 1, border="wrap" if tiles else "extrapolate", depth=8)
    noise = np.random.default_rng(3).normal(0, 8, made.shape)
    noisy = (made + noise).round().clip(1, 254).astype(np.uint8)
    how = {"type": "standard", "y": "up", "kernel": "central"}
    fits = {
        border: nt.height_from_normals_with_info(noisy, **how, border=border)[1].residual
        for border in ("wrap", "clamp", "mirror", "extrapolate")
    }
    shares = []
    _, info = nt.height_from_normals_with_info(noisy, **how, progress=shares.append)
    assert info.residual <= 1.02 * min(fits.values()) < fits["mirror"], (info, fits)
    assert "mirror" not in (info.border_x, info.border_y)
    assert shares == sorted(shares)
    with pytest.raises(nt.CancelledError):
        nt.height_from_normals(noisy, **how, progress=lambda share: share < 0.3)


def clipped_by_sorting(heights, percent):
    ordered = np.sort(heights, axis=None)
    k = int(ordered.size * percent / 100)
    return heights.clip(ordered[k], ordered[-1 - k])


@pytest.mark.parametrize("percent", [0, 0.1, 3, 49])
def test_clip(percent):
    normals = nt.normals_from_height(rough(64, 0.5), 1, depth=8)
    heights = nt.height_from_normals(normals)
    want = clipped_by_sorting(heights, percent)
    got, info = nt.height_from_normals_with_info(normals, clip=percent)
    assert np.array_equal(got, want) and info.clipped == np.count_nonzero(want != heights)
    assert np.array_equal(nt.height_from_normals(normals, clip=percent), want)
    assert (info.offset, info.scale) == (want.min(), float(want.max()) - float(want.min()))
    ordered, k = np.sort(want, axis=None), want.size // 100
    share = (float(ordered[-1 - k]) - float(ordered[k])) / info.scale
    assert info.middle_share == pytest.approx(share) and info.warnings == ()
    mask = np.ones((64, 64), bool)
    mask[20:50] = False
    heights = nt.height_from_normals(normals, mask=mask)
    got = nt.height_from_normals(normals, mask=mask, clip=percent)
    assert np.array_equal(got[mask], clipped_by_sorting(heights[mask], percent))
    out = np.empty((128, 64), np.float32)[::2]
    assert np.array_equal(nt.height_from_normals(normals, clip=percent, out=out), want)


@pytest.mark.parametrize("clip", [-1, 50, float("nan"), "x"])
def test_clip_is_a_percentage(clip):
    with pytest.raises(nt.ArgumentError, match="clip"):
        nt.height_from_normals(np.full((8, 8, 3), 128, np.uint8), type="standard", clip=clip)


def test_warnings_about_heights():
    normals = nt.normals_from_height(rough(64, 0.5), 1, depth=16)
    assert nt.height_from_normals_with_info(normals)[1].warnings == ()
    spiked = 0.3 * rough(128, 0.5)
    spiked[40:42, 50:53] += 300
    spiked = nt.normals_from_height(spiked, 1, depth=16)
    how = {"y": "up", "border": "wrap", "kernel": "central", "type": "standard"}
    info = nt.height_from_normals_with_info(spiked, **how)[1]
    assert info.middle_share < 0.03 and "clip=0.1" in info.warnings[-1]
    info = nt.height_from_normals_with_info(spiked, **how, clip=0.1)[1]
    assert info.middle_share > 0.1 and "clip" not in "".join(info.warnings)
    rng = np.random.default_rng(5)
    for m, dtype in ((255, np.uint8), (65535, np.uint16)):
        noise = rng.normal(0.5, 0.15, (64, 64, 3)).clip(0.1, 0.9)
        noise[..., 2] = 0.95
        how = {"y": "up", "type": "standard"}
        info = nt.height_from_normals_with_info((noise * m).astype(dtype), **how)[1]
        assert info.residual > 8 * m / 255 and "levels of 8 bit" in info.warnings[0]


def test_scales_out_of_range_are_named():
    with pytest.raises(nt.ArgumentError, match="scale=1e.300, dx=1e-300"):
        nt.normals_from_height(np.zeros((4, 4), np.uint8), 1e300, dx=1e-300)


def test_mask_and_seeds():
    normals = nt.normals_from_height(hill(32), scale=10, border="extrapolate")
    mask = np.ones((32, 32), bool)
    mask[:, 20:] = False
    again, info = nt.height_from_normals_with_info(normals, mask=mask, y="up")
    assert info.method == "weighted" and info.holes == np.count_nonzero(~mask)
    want = hill(32) * 10
    inner = np.s_[1:-1, 1:19]
    assert np.abs((again - want)[inner] - (again - want)[inner].mean()).max() < 0.05
    seeds = (hill(32)[:2, :2].ravel() * 10).tolist()  # (0, 0), (1, 0), (0, 1), (1, 1)
    got = nt.height_from_normals(normals, method="telescoping", seeds=seeds, decode="unorm", y="up")
    assert np.abs(got - want).max() < 0.05


def noisy_normals(side):
    """Of noise: no heights have all these normals, so rounds of refine do not end early."""
    levels = np.random.default_rng(8).integers(90, 166, (side, side, 3)).astype(np.uint8)
    levels[..., 2] = 200
    return levels


@pytest.mark.parametrize("stop", [KeyboardInterrupt, False])
def test_refine_keeps_the_best_when_it_is_stopped(stop):
    how = {"kernel": "forward", "border": "wrap", "y": "up", "type": "standard", "z": "derived"}
    shares = []

    def progress(share):
        shares.append(share)
        if share > 0.11:
            if stop is KeyboardInterrupt:
                raise KeyboardInterrupt
            return False
        return True

    again, info = nt.height_from_normals_with_info(
        noisy_normals(48), refine=100, progress=progress, **how
    )
    assert 2 < info.rounds < 20 and info.refine_left > 0
    full, whole = nt.height_from_normals_with_info(noisy_normals(48), refine=info.rounds, **how)
    assert np.array_equal(again, full) and info.refine_left == whole.refine_left

    def fails(share):
        raise ValueError(share)

    with pytest.raises(ValueError, match="0"):
        nt.height_from_normals(noisy_normals(48), refine=100, progress=fails, **how)
    with pytest.raises(nt.CancelledError):
        nt.height_from_normals(noisy_normals(48), refine=9, progress=lambda _: False, **how)


def test_refine_gives_the_texture_back():
    normals = nt.normals_from_height(hill(48), scale=40, kernel="central", border="extrapolate")
    how = {"kernel": "central", "border": "extrapolate"}
    again, info = nt.height_from_normals_with_info(normals, refine=60, y="up", **how)
    assert info.refine_left == 0 < info.rounds
    assert np.array_equal(nt.normals_from_height(again, 1.0, **how), normals)


@pytest.mark.parametrize(
    ("how", "why"),
    [
        ({"kernel": "central", "method": "telescoping"}, "telescoping"),
        ({"kernel": "central", "method": "weighted", "detrend": True}, "detrend"),
    ],
)
def test_what_cannot_be_refined_is_said(how, why):
    flat = np.full((32, 32, 3), (128, 128, 255), np.uint8)
    with pytest.raises(nt.ArgumentError, match="refine") as raised:
        nt.height_from_normals(flat, refine=2, **how)
    assert why in str(raised.value)
    with pytest.raises(nt.ArgumentError, match="floats are not rounded"):
        nt.height_from_normals(flat.astype(np.float32) / 255, refine=2, kernel="central")


# ------------------------------------------------------------------- heights as pictures


@given(
    st.one_of(
        heights((np.uint8, np.uint16)),
        textures(channels=(1, 2, 3, 4)),
    )
)
def test_measure_and_classify_of_heights(picture):
    stats = nt.measure(picture, type="height")
    narrow = picture.dtype == np.uint8 or not (picture.astype(int) % 257).any()
    m = 255 if narrow else 65535
    channels = picture[..., None] if picture.ndim == 2 else picture
    levels = channels // 257 if picture.dtype == np.uint16 and narrow else channels
    assert (stats.texels, stats.channels, stats.max) == (levels[..., 0].size, levels.shape[2], m)
    color = levels.shape[2] - 1 + levels.shape[2] % 2  # without alpha
    for k in range(color):
        have = stats.channel[k]
        assert (have.min, have.max) == (levels[..., k].min(), levels[..., k].max())
        assert have.mean == pytest.approx(levels[..., k].mean())
    assert not any(stats.lengths) and stats.type == "height"
    if picture.ndim == 2 or picture.shape[2] == 1:
        found = nt.classify(picture)
        assert found.type == ("height" if len(np.unique(levels)) > 1 else "one-color")
        assert found == nt.classify(nt.Tally(type="height").add(picture))


@given(heights((np.uint8, np.uint16)), st.integers(0, 1 << 30), st.booleans())
def test_compare_of_heights(height, seed, deepen):
    other = np.random.default_rng(seed).permutation(height.ravel()).reshape(height.shape)
    found = nt.compare(height, other, type="height")
    off = np.abs(height.astype(int) - other)
    assert (found.different, found.levels_max) == (np.count_nonzero(off), (off.max(),))
    assert found.levels_mean == pytest.approx((off.mean(),)) and found.angles.texels == 0
    if deepen and height.dtype == np.uint8:
        deep = nt.convert(height, type="height", to="height", depth=16)
        assert np.array_equal(nt.convert(height, depth=16), deep)  # it can be nothing else
        assert np.array_equal(deep, height.astype(np.uint16) * 257)
        assert nt.compare(deep, height, type="height").different == 0
        assert np.array_equal(nt.convert(deep, type="height", to="height", depth=8), height)


def test_heights_and_normals_do_not_mix():
    normals = np.zeros((2, 3, 3), np.uint8)
    for how in (
        {"type": "height", "to": "standard"},
        {"to": "height"},
        {"type": "height", "to": "height", "channels": "xyz"},
    ):
        with pytest.raises(nt.ArgumentError, match="height"):
            nt.convert(normals, **how)
    with pytest.raises(nt.ArgumentError):
        nt.compare(normals, normals, type=("standard", "height"))
    with pytest.raises(nt.ArgumentError, match="looks like"):
        nt.clean(hill(16), type="auto")


def test_scale_of_the_heights():
    """One in twenty of the slopes that are not 0 is steeper than 45 degrees, by any kernel."""
    x = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    hills = 0.5 + 0.25 * (np.sin(3 * x)[:, None] + np.cos(2 * x))
    for height in (hills, np.round(hills * 65535).astype(np.uint16)):
        scale = nt.suggest_scale(height, kernel="central")
        gentle, steep = (
            np.mean(nt.normals_from_height(height, scale * near, to="vector")[..., 2] ** 2 <= 0.5)
            for near in (0.985, 1.015)
        )
        assert gentle <= 0.05 <= steep
        for strength in (1.0, -2.0):
            ours = nt.normals_from_height(height, "auto", strength=strength)
            assert np.array_equal(ours, nt.normals_from_height(height, scale * strength))
    assert nt.suggest_scale(hills, dx=3, dy=3) == pytest.approx(3 * nt.suggest_scale(hills), 0.01)
    assert nt.suggest_scale(np.full((5, 5), 9, np.uint8)) == 0
    for wrong in (("much", 1), ("auto", np.nan), (1, 1e5), ("auto", "x")):
        with pytest.raises(nt.ArgumentError):
            nt.normals_from_height(hills, wrong[0], strength=wrong[1])
    with pytest.raises(nt.ArgumentError):
        nt.suggest_scale(hills, source="alpha")
