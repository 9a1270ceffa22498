# SPDX-License-Identifier: MIT
"""Which border made the normals at the edges: detected where possible, with the right numbers."""

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import to_height as reconstruction
from support.encoders import jpeg
from support.find import find_border as find
from support.find import find_borders, find_seams
from support.oracle_height import CLAMP, EXTRAPOLATE, KERNELS, MIRROR, NAMES, REPEAT_SLOPE, WRAP

BAKED = len(NAMES)
WEIGHTED = 4
FORWARD = NAMES.index("forward")
REACH = 4  # of the largest kernel


# --------------------------------------------------------------------------- the numbers


def beyond(h, border, wraps, span):
    """REACH more rows above and below; slopes are steps over `span` rows."""
    n, k = len(h), np.arange(1, REACH + 1)[:, None]
    if border == WRAP:
        around = np.diff(np.vstack([h[-4:], h[:4]]).mean(axis=1))  # seven steps; the seam is [3]
        if span == 2:
            around = around[1:] + around[:-1]
            expected = 1.5 * (around[1] + around[4]) - 0.5 * (around[0] + around[5])
            drift = (around[2] + around[3] - expected) / 2
        else:
            drift = around[3] - (around[2] + around[4]) / 2
        drift = drift if wraps else 0
        return np.vstack([h[-REACH:] + drift, h, h[:REACH] - drift])
    if border == MIRROR:
        return np.vstack([h[REACH:0:-1], h, h[-2 : -2 - REACH : -1]])
    if border == EXTRAPOLATE:
        above, below = h[0] - k[::-1] * (h[1] - h[0]), h[-1] + k * (h[-1] - h[-2])
        return np.vstack([above, h, below])
    return np.vstack([h[np.zeros(REACH, int)], h, h[np.full(REACH, n - 1)]])


def slope(h, taps, denominator, border, wraps, span):
    """By a kernel given as {(row, column): weight}, away from the left and right edges."""
    n, w = h.shape
    tall = beyond(h, border, wraps, span)
    rows = np.arange(n)
    if border == REPEAT_SLOPE:
        used = [r for r, _ in taps]
        rows = rows.clip(-min(used), n - 1 - max(used))
    total = np.zeros((n, w - 2 * REACH))
    for (r, c), weight in taps.items():
        total += weight * tall[rows + REACH + r, REACH + c : w - REACH + c]
    return total / denominator


def error_of(stored, h, kernel, border, down, wraps, level):
    """Root mean square over x and y of the first and the last line, in levels."""
    rows, denominator = KERNELS[NAMES[kernel]]
    middle = len(rows) // 2, len(rows[0]) // 2
    right = {
        (r - middle[0], c - middle[1]): weight
        for r, row in enumerate(rows)
        for c, weight in enumerate(row)
        if weight
    }
    below = {(c, r): weight for (r, c), weight in right.items()}
    if not down:  # the picture is turned about its diagonal, and the kernels with it
        h, stored, right, below = h.T, stored.swapaxes(0, 1), below, right
    how = denominator, border, wraps, 1 if kernel == FORWARD else 2
    p = slope(h, right, *how)[[0, -1]]
    q = slope(h, below, *how)[[0, -1]]
    length = np.sqrt(1 + p * p + q * q)
    made = np.stack([-p / length, q / length], axis=-1)
    made = np.floor((made + 1) / 2 * level + 0.5)
    off = made - stored[[0, -1], REACH:-REACH, :2]
    return np.sqrt(np.mean(off * off)) / (level / 255)


@pytest.mark.parametrize("down", [0, 1])
@pytest.mark.parametrize("kernel", ["central", "forward", "sobel3", "sobel5", "gimp9"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_errors_are_those_of_normals_made_with_each_border(kernel, down, dtype):
    """For any heights, whether or not they belong to the texture."""
    rng = np.random.default_rng(5)
    size = (150, 41) if down == 0 else (41, 150)
    h = reconstruction.fractal(256, seed=6)[: size[0], : size[1]].astype(np.float32)
    h = np.ascontiguousarray(0.3 * h + rng.normal(0, 0.05, size).astype(np.float32))
    level = np.iinfo(dtype).max
    n = rng.integers(level // 3, level * 2 // 3, (*size, 3)).astype(dtype)
    number = NAMES.index(kernel)
    for wraps in (0, 1):
        error = find(n, h, number, down, wraps, method=WEIGHTED)["error"]
        for border in (WRAP, CLAMP, MIRROR, EXTRAPOLATE, REPEAT_SLOPE):
            want = error_of(n.astype(float), h.astype(float), number, border, down, wraps, level)
            assert error[border] == pytest.approx(want, rel=1e-4), (border, wraps)


@pytest.mark.parametrize("down", [0, 1])
def test_wrap_does_not_depend_on_odd_heights_lying_apart_from_even_ones(down):
    """Central slopes do not tell how far apart they lie, and damage pushes them apart."""
    h = reconstruction.fractal(128, seed=9).astype(np.float32)
    n = reconstruction.from_height(h, "central")
    odd = np.arange(128) % 2
    apart = h + 3 * (odd[:, None] if down else odd).astype(np.float32)
    error = find(n, apart, NAMES.index("central"), down, wraps=1)["error"][WRAP]
    assert error < 0.5


def test_only_what_the_method_takes_is_tried():
    h = reconstruction.fractal(64).astype(np.float32)
    n = reconstruction.from_height(h, "sobel3")
    error = find(n, h, NAMES.index("sobel3"), 0)["error"]
    assert [e >= 0 for e in error] == [True, True, True, False, False]
    error = find(n, h, NAMES.index("sobel3"), 0, method=3)["error"]  # poisson-dct
    assert [e >= 0 for e in error] == [False, True, True, False, False]


# --------------------------------------------------------------------------- what is told


def solve_freely(n, kernel):
    border = ntp.lib.ntp_free_border(kernel)
    return reconstruction.to_height(n, kernel=kernel, border_x=border, border_y=border)[0]


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize(
    ("kernel", "border"),
    [
        ("central", WRAP),
        ("central", CLAMP),
        ("central", MIRROR),
        ("central", EXTRAPOLATE),
        ("forward", WRAP),
        ("forward", CLAMP),
        ("forward", EXTRAPOLATE),
        ("sobel3", CLAMP),
        ("sobel3", MIRROR),
        ("scharr3", WRAP),
    ],
)
def test_the_border_is_found(kernel, border, dtype):
    h = reconstruction.fractal(128, seed=7)[:, :100].astype(np.float32)
    if border == WRAP:
        h = reconstruction.fractal(128, seed=7).astype(np.float32)
    n = reconstruction.from_height(h, kernel, border, border, dst=dtype)
    number = NAMES.index(kernel)
    made = solve_freely(n, number)
    for down in (0, 1):
        found = find(n, made, number, down, wraps=int(border == WRAP))
        assert found["decided"] and found["border"] == border, found
        assert found["error"][border] < 2.5  # the heights were found without that border


def test_what_cannot_be_told():
    rng = np.random.default_rng(8)
    noise = rng.integers(60, 196, (64, 64, 3)).astype(np.uint8)
    for kernel in (0, FORWARD):
        free = CLAMP if kernel == FORWARD else MIRROR
        found = find(noise, solve_freely(noise, kernel), kernel, 0)
        assert (found["border"], found["decided"]) == (free, 0)
        small = np.ascontiguousarray(noise[:15])
        for down in (0, 1):
            found = find(small, np.zeros((15, 64), np.float32), kernel, down)
            assert (found["border"], found["decided"]) == (free, 0) and max(found["error"]) == -1
            found = find(small, np.zeros((15, 64), np.float32), kernel, down, wraps=1)
            assert (found["border"], found["decided"]) == (WRAP, 1)
    found = find(noise, np.zeros((64, 64), np.float32), BAKED, 1)
    assert (found["border"], found["decided"]) == (MIRROR, 0)


def test_unused_texels_at_the_edges_do_not_count():
    h = reconstruction.fractal(96, seed=9).astype(np.float32)[:90, :80]
    n = reconstruction.from_height(h, "central", EXTRAPOLATE, EXTRAPOLATE)
    plain = find(n, h, 0, 1)
    n[0, 10:30] = n[-1, 40:50] = 0
    hidden = find(n, h, 0, 1)
    assert hidden["border"] == plain["border"] == EXTRAPOLATE
    assert hidden["error"][EXTRAPOLATE] < 0.01 < find(n, h, 0, 1, touch_unused=1)["error"][WRAP]
    assert find(n, h, 0, 1, touch_unused=1)["error"][EXTRAPOLATE] > 10


# ------------------------------------------------------------------------------ from bands


PAIRS = [(WRAP, CLAMP), (EXTRAPOLATE, WRAP), (CLAMP, EXTRAPOLATE), (MIRROR, CLAMP), (WRAP, WRAP)]


@pytest.mark.parametrize("borders", PAIRS)
def test_bands_show_the_borders_of_both_axes(borders):
    """Along a side with bands, and along one that is used whole."""
    for kernel, size in (("central", (290, 300)), ("forward", (120, 310)), ("sobel3", (310, 110))):
        if (kernel == "forward" and MIRROR in borders) or (
            kernel == "sobel3" and EXTRAPOLATE in borders
        ):
            continue
        # of the period of the texture where it wraps
        period = size[0] if borders[1] == WRAP else 400, size[1] if borders[0] == WRAP else 420
        whole = reconstruction.fractal(period[0], seed=7, width=period[1])
        h = whole[: size[0], : size[1]].copy()
        n = reconstruction.from_height(h, kernel, *borders)
        wraps = [int(seam["wraps"]) for seam in find_seams(n)]
        for with_seams in (wraps, (0, 0)):
            found = find_borders(n, NAMES.index(kernel), wraps=with_seams)
            assert [f["border"] for f in found] == list(borders), (kernel, found)
            assert all(f["decided"] for f in found)


def test_damage_does_not_hide_that_it_tiles():
    """Nothing fits well at the edges, so borders are tried.  Blue that was derived again hides the
    damage."""
    h = reconstruction.fractal(300, seed=3, rms_slope=0.5)
    rng = np.random.default_rng(4)
    clean = reconstruction.from_height(h).astype(float)
    n = (clean + rng.normal(0, 5, clean.shape)).clip(0, 255).round().astype(np.uint8)
    z2 = 1 - ((n[..., :2] / 127.5 - 1) ** 2).sum(-1)
    n[..., 2] = (127.5 + 127.5 * np.sqrt(z2.clip(0, 1))).round()
    found = find_borders(n, 0)
    assert [f["border"] for f in found] == [WRAP, WRAP]
    assert min(found[0]["error"][:4]) > 3  # levels: no border is shown by the edges alone


def test_few_lines_that_close_by_chance_are_no_tile():
    """Heights at both ends of the lines of one band are alike, and slopes there are not."""
    n = 600
    f = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None])
    f[0, 0] = np.inf
    noise = np.random.default_rng(7).standard_normal((n, n))
    h = np.fft.irfft2(np.fft.rfft2(noise) / f**2.3, s=(n, n))
    h *= 1.2 / np.diff(h, axis=1).std()
    cut = h[30:330, 20:320].astype(np.float32)
    normals = jpeg(reconstruction.from_height(cut, "forward", MIRROR, MIRROR), 85, 0)
    assert WRAP not in [f["border"] for f in find_borders(normals, FORWARD)]


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("down", [0, 1])
def test_an_axis_without_slopes_wraps(down, dtype):
    """Heights would lean by half a level there if its border were free."""
    x = np.arange(96)
    for h in (0.3 * x, 3.0 * (x // 16 % 2), 3 * abs(np.sin(x / 5))):
        h = np.tile(h, (80, 1))
        n = reconstruction.from_height(
            h.T if down else h, border_x=EXTRAPOLATE, border_y=EXTRAPOLATE, dst=dtype
        )
        fits = find_borders(n, 0)
        level, sloped = fits[1 - down], fits[down]
        assert (level["border"], level["decided"]) == (WRAP, 1)
        assert max(level["error"]) == -1 < max(sloped["error"])
        found = find_borders(n, 0, open_=(1 - down, down))
        assert found[1 - down]["border"] == WRAP, "the other axis is given"
        # one texel that slopes, and it is asked as before
        n[5, 7, 1 - down] += 4
        assert max(find_borders(n, 0)[1 - down]["error"]) > 0


def test_borders_that_are_given_stay():
    h = reconstruction.fractal(200, seed=2)
    n = reconstruction.from_height(h)
    given = {"border_x": CLAMP, "border_y": MIRROR}
    first, second = find_borders(n, 0, open_=(0, 1), wraps=(1, 1), **given)
    assert (first["border"], second["border"], second["decided"]) == (CLAMP, WRAP, 1)
    first, second = find_borders(n, 0, open_=(1, 0), wraps=(1, 1), **given)
    assert (first["border"], second["border"], first["decided"]) == (WRAP, MIRROR, 1)


def test_borders_of_what_is_not_solved():
    n = reconstruction.from_height(reconstruction.fractal(64))
    for case in ({"method": WEIGHTED}, {"method": 2}, {"method": 1}):
        found = find_borders(n, 0, wraps=(1, 0), **case)
        assert [(f["border"], f["decided"]) for f in found] == [(WRAP, 1), (MIRROR, 0)]
    for small in (n[:15], n[:, :15]):
        found = find_borders(np.ascontiguousarray(small), FORWARD)
        assert [(f["border"], f["decided"]) for f in found] == [(CLAMP, 0)] * 2


def test_baked_normals_show_borders_as_central_ones():
    whole = reconstruction.fractal(160)
    for h in (whole, whole[20:120, 30:150].copy()):
        n = jpeg(reconstruction.from_height(h, border_x=EXTRAPOLATE), 90, 0)
        assert find_borders(n, BAKED) == find_borders(n, 0)


def test_threads_do_not_change_the_borders_and_progress_can_stop():
    h = reconstruction.fractal(400, seed=5)[:330, :350].copy()
    n = reconstruction.from_height(h, "central", CLAMP, EXTRAPOLATE)
    shares = []

    @ntp.ffi.callback("int32_t(void *, double)")
    def progress(_, share):
        shares.append(share)
        return 0

    one = find_borders(n, 0, hooks=reconstruction.serial_hooks(1, progress=progress))
    assert one == find_borders(n, 0, hooks=reconstruction.serial_hooks(3)) == find_borders(n, 0)
    assert shares == sorted(shares) and shares[0] < 0.3 and 0.5 < shares[-1] <= 1
    stop = ntp.ffi.callback("int32_t(void *, double)", lambda *_: 1)
    with pytest.raises(ntp.NtpError) as error:
        find_borders(n, 0, hooks=reconstruction.serial_hooks(1, progress=stop))
    assert error.value.status == ntp.ERR_CANCELLED


def test_wrong_arguments_of_both_axes():
    n = reconstruction.from_height(reconstruction.fractal(32))
    call, size = ntp.lib.ntp_find_borders, ntp.lib.ntp_find_borders_scratch_size
    how, fits = ntp.ffi.new("ntp_height_options *"), ntp.ffi.new("ntp_border_fit[2]")
    src, null, both = ntp.view(n, const=True), ntp.ffi.NULL, ntp.ffi.new("int32_t[2]", [1, 1])
    assert size(how, 32, 32, 1) > 0
    for given in ((null, 32, 32, 1), (how, 0, 32, 1), (how, 32, 2**31 - 1, 1), (how, 32, 32, 65)):
        assert size(*given) == 0
    assert call(null, src, how, both, both, null, 0, null) == ntp.lib.NTP_ERR_ARGUMENT
    assert call(fits, src, null, both, both, null, 0, null) == ntp.lib.NTP_ERR_ARGUMENT
    assert call(fits, src, how, null, both, null, 0, null) == ntp.lib.NTP_ERR_ARGUMENT
    assert call(fits, src, how, both, null, null, 0, null) == ntp.lib.NTP_ERR_ARGUMENT
    assert call(fits, src, how, both, both, null, 0, null) == ntp.lib.NTP_ERR_SCRATCH


def test_wrong_arguments():
    n, h = np.zeros((20, 20, 3), np.uint8), np.zeros((20, 20), np.float32)
    null = ntp.ffi.NULL
    how, fit = ntp.ffi.new("ntp_height_options *"), ntp.ffi.new("ntp_border_fit *")
    src, made = ntp.view(n, const=True), ntp.view(h, ntp.HEIGHT, const=True)
    call = ntp.lib.ntp_find_border
    assert call(fit, src, made, how, 0, 0) == ntp.lib.NTP_OK
    assert call(null, src, made, how, 0, 0) == ntp.lib.NTP_ERR_ARGUMENT
    assert call(fit, src, made, null, 0, 0) == ntp.lib.NTP_ERR_ARGUMENT
    for wrong in ({"touch_unused": 8}, {"kernel": 11}, {"method": 5}, {"dx": -1.0}, {"dy": np.inf}):
        bad = ntp.ffi.new("ntp_height_options *", wrong)
        assert call(fit, src, made, bad, 0, 0) == ntp.lib.NTP_ERR_ARGUMENT, wrong
    levels = ntp.view(np.zeros((20, 20), np.uint8), ntp.HEIGHT, const=True)
    assert call(fit, src, levels, how, 0, 0) == ntp.lib.NTP_ERR_FORMAT
    other = ntp.view(np.zeros((20, 21), np.float32), ntp.HEIGHT, const=True)
    assert call(fit, src, other, how, 0, 0) == ntp.lib.NTP_ERR_SHAPE
