# SPDX-License-Identifier: MIT
"""ntp_curvature and ntp_occlusion: known surfaces within 1 %, a slow oracle, borders and parts."""

import numpy as np
import pytest

from support import libntp_ffi as ntp
from support import relief_maps as maps

CLAMP = {"border_x": maps.CLAMP, "border_y": maps.CLAMP}
Y, X = np.mgrid[-100:101, -100:101].astype(float)


# ------------------------------------------------------------------------ known surfaces


def sphere(radius):
    """Heights, normals, mean and Gaussian curvature, and where the surface is not too steep."""
    z = np.sqrt(np.maximum(radius**2 - X**2 - Y**2, 1))
    normal = np.stack([X, -Y, z], -1) / radius
    inside = X**2 + Y**2 < (0.85 * radius) ** 2
    return z, normal, np.full(X.shape, 1 / radius), np.full(X.shape, radius**-2), inside


def cylinder(radius, turn):
    """A cylinder that lies in any direction."""
    across = X * np.cos(turn) + Y * np.sin(turn)
    z = np.sqrt(np.maximum(radius**2 - across**2, 1))
    normal = np.stack([across * np.cos(turn), -across * np.sin(turn), z], -1) / radius
    return z, normal, np.full(X.shape, 0.5 / radius), 0 * X, abs(across) < 0.85 * radius


def torus(ring, tube):
    """Lying flat, seen from above; the curvature changes its sign along it."""
    far = np.hypot(X, Y) + 1e-9
    out = np.clip((far - ring) / tube, -1, 1)
    z = np.sqrt(np.maximum(1 - out**2, 1e-4))
    normal = np.stack([out * X / far, -out * Y / far, z], -1)
    other = out / (ring + tube * out)
    inside = abs(out) < 0.7
    return z * tube, normal, (1 / tube + other) / 2, other / tube, inside


SURFACES = {
    "sphere": sphere(90.0),
    "cylinder": cylinder(90.0, 0),
    "turned cylinder": cylinder(90.0, 0.6),
    "torus": torus(48.0, 45.0),
}


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("what", ["heights", "normals16", "floats"])
@pytest.mark.parametrize("y", [ntp.UP, ntp.DOWN])
def test_within_one_percent(name, what, y):
    """Of the greatest curvature of the surface; convex is positive, and a dent the opposite."""
    z, normal, mean, gaussian, inside = SURFACES[name]
    first = (mean + np.sqrt(np.maximum(mean**2 - gaussian, 0)))[inside].max()
    normal = normal * [1, 1 if y == ntp.UP else -1, 1]
    if what == "heights":
        src, encoding = z.astype(np.float32), ntp.HEIGHT
    elif what == "floats":
        src, encoding = normal.astype(np.float32), ntp.VECTOR
    else:
        src, encoding = np.floor((normal + 1) / 2 * 65535 + 0.5).astype(np.uint16), ntp.STANDARD

    def error(kind, known, unit):
        made = maps.curvature(src, encoding, y=y, kind=kind, **CLAMP)
        return abs(made - known)[inside].max() / unit

    assert error(maps.MEAN, mean, abs(mean)[inside].max()) < 0.01
    assert error(maps.GAUSSIAN, gaussian, first**2) < 0.01
    apart = np.sqrt(np.maximum(mean**2 - gaussian, 0))
    assert error(maps.CONVEX, np.maximum(mean + apart, 0), first) < 0.01
    assert error(maps.CAVITY, np.maximum(apart - mean, 0), first) < 0.01
    if what == "heights":
        dent = maps.curvature(-src, encoding, kind=maps.CAVITY, **CLAMP)
        assert (dent == maps.curvature(src, encoding, kind=maps.CONVEX, **CLAMP)).all()
        return
    normal = normal * [-1, -1, 1]  # a trench or a bowl
    src = np.floor((normal + 1) / 2 * 65535 + 0.5).astype(np.uint16)
    src = src if what == "normals16" else normal.astype(np.float32)
    assert error(maps.CAVITY, np.maximum(mean + apart, 0), first) < 0.01


@pytest.mark.parametrize("radius", [30.0, 90.0, 300.0, 1000.0])
@pytest.mark.parametrize("kind", [maps.MEAN, maps.CONVEX, maps.CAVITY])
def test_levels_of_a_ball(radius, kind):
    """What rounding to 16 bit alone can do, where both principal curvatures are the same.

    A stored number is off by up to 1/M, so that a difference of two, halved, is too: e.  The mean is
    off by up to e; half the difference of the principal curvatures, which is
    sqrt(((a - d) / 2)^2 + b c) of differences a, b, c, d that are off by e, by up to sqrt(2) e.
    """
    _, normal, mean, _, inside = sphere(radius)
    src = np.floor((normal + 1) / 2 * 65535 + 0.5).astype(np.uint16)
    made = maps.curvature(src, ntp.STANDARD, kind=kind, **CLAMP)
    known = 0 * mean if kind == maps.CAVITY else mean
    most = (1 if kind == maps.MEAN else 1 + 2**0.5) / 65535
    assert abs(made - known)[inside].max() <= most * 1.0001


@pytest.mark.parametrize("degrees", [30, 45, 60])
def test_pit(degrees):
    """A dent that is part of a sphere: every point of it sees the same share of the sky."""
    rim = 95
    radius = rim / np.sin(np.radians(degrees))
    depth = np.sqrt(np.maximum(radius**2 - X**2 - Y**2, 0)) - radius * np.cos(np.radians(degrees))
    far = np.hypot(X, Y)
    made = maps.occlusion(np.where(far < rim, -depth, 0).astype(np.float32), **CLAMP)
    known = (1 + np.cos(np.radians(degrees))) / 2
    assert abs(made / known - 1)[far < 0.95 * rim].max() < 0.01
    assert made[far > rim + 1].min() == 1


@pytest.mark.parametrize("kind", ["cylinder", 0.5, 1.0, 2.0])
def test_groove(kind):
    """A trench, and grooves with straight sides: endless, as the texture tiles along them."""
    h, known, inside = maps.groove(kind, 20.0 if kind == "cylinder" else 20)
    inside &= abs(X[0]) > (0 if kind == "cylinder" else 2)
    h = np.tile(h, (2, 1)).astype(np.float32)
    for src in (h, h.T):
        made = maps.occlusion(np.ascontiguousarray(src))
        made = made if src is h else made.T
        assert (made == made[0]).all()
        assert abs(made[0][inside] / known[inside] - 1).max() < 0.01


def test_random_heights():
    """Against rays in 96 directions, by the definition of ambient occlusion."""
    h = maps.hills(30, 8)
    slow = maps.slow_occlusion(h)
    made = maps.occlusion(h.astype(np.float32))
    assert slow.min() < 0.5
    assert abs(made - slow).max() < 0.015 and np.sqrt(np.mean((made - slow) ** 2)) < 0.003
    scaled = maps.occlusion((h / 8 * 65535 + 0.5).astype(np.uint16), scale=8)
    assert abs(scaled - made).max() < 1e-3


# -------------------------------------------------------------- borders, parts, rounding

LEVELS = (maps.hills(48, 65535)[:37]).astype(np.uint16)


def test_wrap_is_shift():
    """A texture that tiles has no edges: shifted heights have the shifted result."""
    for made in (lambda h: maps.occlusion(h, scale=9), lambda h: maps.curvature(h, scale=9)):
        plain = made(LEVELS)
        for shift in ((5, 7), (20, 33), (36, 47)):
            moved = np.roll(LEVELS, shift, (0, 1))
            assert (made(moved) == np.roll(plain, shift, (0, 1))).all()


def normals_of(h, wraps):
    """8-bit normals of heights by central differences, in numpy."""
    padded = np.pad(h, 1, mode="wrap" if wraps else "reflect", **{} if wraps else ODD)
    p, q = padded[1:-1, 2:] - padded[1:-1, :-2], padded[:-2, 1:-1] - padded[2:, 1:-1]
    n = np.stack([-p / 2, -q / 2, np.ones_like(p)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return np.floor((n + 1) / 2 * 255 + 0.5).astype(np.uint8)


ODD = {"reflect_type": "odd"}  # goes on straight


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("blur", [8, 12])
def test_edges_of_tiles_and_of_cuts(seed, blur):
    """What tiles wraps, also after it was shifted; a part that was cut out does not, on both axes."""
    tile = maps.hills(160, 25, blur, seed)
    for h, known in (
        (tile, (maps.WRAP, maps.WRAP)),
        (np.roll(tile, (31, 77), (0, 1)), (maps.WRAP, maps.WRAP)),
        (tile[:, 20:120], (maps.CLAMP, maps.WRAP)),
        (tile[30:130], (maps.WRAP, maps.CLAMP)),
        (tile[10:110, 20:120], (maps.CLAMP, maps.CLAMP)),
    ):
        h = np.ascontiguousarray(h)
        assert maps.borders((h / 25 * 65535).astype(np.uint16)) == known
        assert maps.borders(h.astype(np.float32)) == known
        if known[0] == known[1]:
            made = normals_of(h, known[0] == maps.WRAP)
            assert maps.borders(made, ntp.STANDARD) == known


def test_edges_that_look_like_a_seam():
    """A step at the edge is no seam if there is another inside, or if bevels cancel out."""
    y, x = np.mgrid[:64, :64]
    planks = np.where(x % 32 < 30, 200 + x // 32, 40).astype(np.uint8)
    assert maps.borders(planks) == (maps.WRAP, maps.WRAP)
    panel = np.minimum(np.minimum(np.minimum(x, 63 - x), np.minimum(y, 63 - y)), 12).astype(float)
    assert maps.borders(normals_of(panel, True), ntp.STANDARD) == (maps.WRAP, maps.WRAP)
    noise = np.random.default_rng(3).integers(0, 255, (90, 70), np.uint8)
    assert maps.borders(noise) == (maps.WRAP, maps.WRAP)
    ramp = np.tile(np.arange(40, dtype=np.float32), (15, 1))
    assert maps.borders(ramp) == (maps.WRAP, maps.WRAP)  # few rows
    assert maps.borders(np.tile(ramp, (2, 1))) == (maps.CLAMP, maps.WRAP)
    assert maps.borders(np.zeros((40, 40), np.uint8)) == (maps.WRAP, maps.WRAP)


@pytest.mark.parametrize("borders", [{}, CLAMP, {"border_x": maps.CLAMP}])
@pytest.mark.parametrize("radius", [0, 11])
def test_turns_and_flips(borders, radius):
    turned = {f"border_{b}": borders.get(f"border_{a}", 0) for a, b in ("xy", "yx")}
    made = maps.occlusion(LEVELS, scale=9, radius=radius, **borders)
    bent = maps.curvature(LEVELS, scale=9, **borders)
    for k, how in ((1, turned), (2, borders), (3, turned)):
        src = np.ascontiguousarray(np.rot90(LEVELS, k))
        assert (maps.occlusion(src, scale=9, radius=radius, **how) == np.rot90(made, k)).all()
        assert abs(maps.curvature(src, scale=9, **how) - np.rot90(bent, k)).max() < 1e-6
    assert (
        maps.occlusion(LEVELS[:, ::-1], scale=9, radius=radius, **borders) == made[:, ::-1]
    ).all()


def test_radius():
    """Only what is near hides: a wall shades the texels up to the radius."""
    wall = np.zeros((40, 80), np.uint8)
    wall[:, 40] = 255
    made = maps.occlusion(wall, scale=30, radius=10, **CLAMP)
    assert (made[20, :29] == 1).all() and (np.diff(made[20, 31:39]) < 0).all()
    open_all = maps.occlusion(wall, scale=30, radius=1e9, **CLAMP)
    assert (open_all == maps.occlusion(wall, scale=30, **CLAMP)).all() and open_all[20, 0] < 1


def test_plane_is_open():
    """A slope hides nothing from itself, however steep."""
    plane = (X[:50] * 2.5 + Y[:50] * 0.3).astype(np.float32)
    assert maps.occlusion(plane, **CLAMP).min() == 1
    assert abs(maps.curvature(plane, **CLAMP)).max() < 1e-5


@ntp.ffi.callback("void(void *, int32_t, void (*)(void *, int32_t), void *)")
def backwards(_user, count, task, work):
    for i in reversed(range(count)):
        task(work, i)


def test_parts():
    """The same bytes for any number of parts, in any order; progress cancels."""
    plain = maps.occlusion(LEVELS, scale=9)
    for parts in (2, 3, 64):
        hooks = ntp.ffi.new("ntp_hooks *", {"parts": parts, "parallel_for": backwards})
        assert (maps.occlusion(LEVELS, scale=9, parts=parts, hooks=hooks) == plain).all()
    stop = ntp.ffi.callback("int32_t(void *, double)", lambda _user, share: share > 0.5)
    with pytest.raises(ntp.NtpError) as caught:
        maps.occlusion(LEVELS, hooks=ntp.ffi.new("ntp_hooks *", {"progress": stop}))
    assert caught.value.status == ntp.ERR_CANCELLED


def test_areas():
    """An area gets what the whole image gets there, and nothing else is touched."""
    whole = maps.curvature(LEVELS, scale=9)
    part = maps.curvature(LEVELS, scale=9, area=(3, 0, 48, 9))
    assert (
        (part[:9, 3:] == whole[:9, 3:]).all() and (part[9:] == 7).all() and (part[:, :3] == 7).all()
    )


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("kind", [maps.MEAN, maps.GAUSSIAN, maps.CONVEX, maps.CAVITY])
def test_stored(dtype, kind):
    """Levels are the rounded values of the formula; flat is the middle, or an end."""
    m = np.iinfo(dtype).max
    values = maps.curvature(LEVELS, scale=9, kind=kind).astype(float)
    most = maps.range_of(values.astype(np.float32))
    share = np.mean(abs(values[values != 0]) <= most)
    assert 0.98 < share < 1 and abs(values).max() >= most / 1.0625
    v = values / most
    unit = {maps.CONVEX: v, maps.CAVITY: 1 - v}.get(kind, (v + 1) / 2)
    levels = maps.curvature(LEVELS, dtype=dtype, scale=9, kind=kind, range=most)
    assert abs(levels - np.clip(unit, 0, 1) * m).max() < 0.501 + m * 1e-7
    flat = maps.curvature(np.zeros((5, 5), np.uint8), dtype=dtype, kind=kind, range=1)
    assert set(flat.ravel()) == {{maps.CONVEX: 0, maps.CAVITY: m}.get(kind, (m + 1) // 2)}


def test_range_of_nothing():
    assert maps.range_of(np.zeros((4, 4), np.float32)) == 0
    assert maps.range_of(np.array([[0, np.nan, np.inf, -1.0]], np.float32)) == 1.0625


def test_unused_and_not_finite():
    normals = np.full((9, 9, 3), (140, 120, 254), np.uint8)
    normals[4, 4] = 0
    normals[:, 6:] = (100, 90, 220)
    made = maps.curvature(normals, ntp.STANDARD)
    assert (made[3:6, 4] == 0).all() and (made[4, 3:6] == 0).all() and made[4, 6] != 0
    heights = maps.hills(12, 5).astype(np.float32)
    heights[5, 5] = np.nan
    assert (maps.curvature(heights)[4:7, 4:7] == 0).all()
    low = np.where(np.isnan(heights), np.nanmin(heights), heights)
    assert (maps.occlusion(heights) == maps.occlusion(low)).all()


def test_enormous_heights():
    """Cliffs without end: finite, and as dark as those of a finite height."""
    finite = maps.occlusion(LEVELS, scale=1e15)
    assert abs(maps.occlusion(LEVELS, scale=1.7e308) - finite).max() < 1e-6 and finite.min() < 0.1


def test_refusals():
    heights = np.zeros((4, 4), np.uint8)
    for how in ({"kind": 4}, {"border_x": 2}, {"range": -1.0}, {"scale": float("nan")}):
        with pytest.raises(ntp.NtpError) as caught:
            maps.curvature(heights, **how)
        assert caught.value.status == ntp.ERR_ARGUMENT
    with pytest.raises(ntp.NtpError) as caught:
        maps.curvature(heights, dtype=np.uint8)
    assert caught.value.status == ntp.ERR_FORMAT
    for how in ({"radius": -1.0}, {"radius": float("nan")}, {"border_y": 3}):
        options = ntp.ffi.new("ntp_occlusion_options *", how)
        assert ntp.lib.ntp_occlusion_scratch_size(options, 4, 4, 1) == 0
