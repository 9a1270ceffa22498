# SPDX-License-Identifier: MIT
"""The GEGL operations through the program `gegl`: the same numbers as `ntp`."""

import ctypes

import numpy as np
import pytest

from support import libntp_ffi as ffi_lib
from support import pngs
from support.gegl_pictures import (
    CHANNELS,
    DEPTHS,
    GAMMA,
    picture,
    rough_normals,
    to_options,
    to_properties,
)


@pytest.mark.parametrize("chunks", [(), (GAMMA,)], ids=["plain", "gAMA"])
@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("channels", CHANNELS)
def test_same_as_ntp(gegl, ntp, channels, depth, chunks):
    heights = picture(150, 133, channels, depth)
    settings = {"scale": "7.3", "to-y": "down"}
    expected = ntp(heights, "from-height", *to_options(settings))
    made = gegl(heights, "ntp:normals-from-height", *to_properties(settings), chunks=chunks)
    assert made.shape == expected.shape
    assert np.count_nonzero((made != expected).any(2)) == 0


@pytest.mark.parametrize("depth", DEPTHS)
def test_luminance_is_that_of_gimp(gegl, depth):
    """GIMP's own filter makes the same normals of a color picture, but for its float arithmetic."""
    color = picture(150, 133, 3, depth)
    same = ["scale=10", "to-y=down", "border-x=clamp", "border-y=clamp", "blue=nearest"]
    gimps = gegl(color, "gegl:normal-map", "scale=10")[:, :, :3].astype(int)
    made = gegl(color, "ntp:normals-from-height", "source=luminance", *same)[:, :, :3]
    luma = gegl(color, "ntp:normals-from-height", "source=luma", *same)[:, :, :3]
    off = np.abs(made - gimps).max(2)
    assert off.max() <= 1 and (off > 0).mean() < (0.002 if depth == 8 else 0.05)
    assert (np.abs(luma - gimps).max(2) > 1).mean() > 0.5


GEGL_GAMMA = 1 / 0.45455  # as GEGL reads the chunk
REC_709 = (0.3127, 0.3290, 0.64, 0.33, 0.30, 0.60, 0.15, 0.06)  # white, red, green, blue


def space_of(babl, chunks):
    """The color space in which GEGL reads such a PNG file."""
    pointer, number = ctypes.c_void_p, ctypes.c_double
    for name in ("babl_space", "babl_trc_gamma", "babl_space_from_chromaticities"):
        getattr(babl, name).restype = pointer
    babl.babl_init()
    if not chunks:
        return pointer(babl.babl_space(b"sRGB"))
    curve = pointer(babl.babl_trc_gamma(number(GEGL_GAMMA)))
    points = map(number, REC_709)
    return pointer(babl.babl_space_from_chromaticities(None, *points, curve, curve, curve, 1))


def luminance(color, chunks):
    """Of the formula, in double precision, rounded once; gray is what it is."""
    babl, weights = ctypes.CDLL("libbabl-0.1.so.0"), (ctypes.c_double * 3)()
    red, green, blue = (ctypes.byref(weights, 8 * i) for i in range(3))
    babl.babl_space_get_rgb_luminance(space_of(babl, chunks), red, green, blue)
    c = color[:, :, :3] / np.float64(np.iinfo(color.dtype).max)
    if chunks:
        made = (c**GEGL_GAMMA @ np.array(weights)) ** (1 / GEGL_GAMMA)
    else:
        light = np.where(c > 0.04045, ((c + 0.055) / 1.055) ** 2.4, c / 12.92)
        made = light @ np.array(weights)
        toe = made <= 0.04045 / 12.92
        made = np.where(toe, made * 12.92, 1.055 * made ** (1 / 2.4) - 0.055)
    return np.where((color[:, :, :3] == color[:, :, :1]).all(2), c[:, :, 0], made)


@pytest.mark.parametrize("chunks", [(), (GAMMA,)], ids=["plain", "gAMA"])
@pytest.mark.parametrize("depth", DEPTHS)
def test_luminance_is_the_formula(gegl, run, tmp_path, depth, chunks):
    """The same on every run: no conversion of babl, which it chooses by timing, takes part."""
    color = picture(150, 133, 4, depth)
    color[20:60, 30:90, 1:3] = color[20:60, 30:90, :1]
    heights = luminance(color, chunks).astype("<f4")
    header = b"Pf\n%d %d\n-1\n" % heights.shape[::-1]
    (tmp_path / "light.pfm").write_bytes(header + heights[::-1].tobytes())
    for settings in ({"scale": "40"}, {"scale": "40", "blur": "1.5"}):
        options = [*to_options(settings), "--depth", str(depth), "-q"]
        done = run("from-height", "light.pfm", "-o", "light.png", *options)
        assert done.returncode == 0, done.stderr
        expected = pngs.read_png(tmp_path / "light.png")[0]
        settings = to_properties({**settings, "source": "luminance"})
        made = gegl(color, "ntp:normals-from-height", *settings, chunks=chunks)
        assert np.count_nonzero((made[:, :, :3] != expected).any(2)) == 0
        assert np.array_equal(made[:, :, 3], color[:, :, 3])


SETTINGS = [
    {"kernel": kernel, "border-x": border, "border-y": other}
    for kernel, border, other in [
        ("central", "clamp", "mirror"),
        ("forward", "extrapolate", "wrap"),
        ("prewitt3", "repeat-slope", "repeat-slope"),
        ("sobel3", "wrap", "clamp"),
        ("scharr3", "mirror", "extrapolate"),
        ("prewitt5", "clamp", "clamp"),
        ("sobel5", "extrapolate", "extrapolate"),
        ("gimp5", "repeat-slope", "wrap"),
        ("gimp7", "mirror", "mirror"),
        ("gimp9", "repeat-slope", "repeat-slope"),
        ("gimp9", "wrap", "wrap"),
    ]
] + [
    {"source": source}
    for source in (
        "green",
        "blue",
        "luma",
        "luma-gimp",
        "luma-eberly",
        "mean",
        "max",
        "min",
        "screen",
    )
]
SETTINGS += [
    {"dx": "0.5", "dy": "3"},
    {"min-z": "0.6", "invert": True},
    {"to": "zzero", "blue": "nearest"},
    {"to": "xy"},
    {"source": "alpha", "alpha": "keep"},
    {"alpha": "height"},
    {"alpha": "inverse"},
    {"alpha": "one"},
]


@pytest.mark.parametrize("settings", SETTINGS, ids=lambda s: "-".join(map(str, s.values())))
def test_settings(gegl, ntp, settings):
    heights = picture(61, 47, 4, 8)
    settings = {"scale": "-12.5", **settings}
    expected = ntp(heights, "from-height", *to_options(settings))
    made = gegl(heights, "ntp:normals-from-height", *to_properties(settings))
    assert made.shape == expected.shape
    assert np.count_nonzero((made != expected).any(2)) == 0


# Properties, and the options that are the same; pictures of so many channels and bits.
FORMS = "small=0.5 middle=2 large=1.25", "--octaves 0.5,0,1.5,0,-0.75"
DOWN = "--to-y down"
SAME = [
    (4, 8, "blur=2.5", "--blur 2.5"),
    (3, 16, FORMS[0], FORMS[1]),
    (1, 8, f"blur=1.5 {FORMS[0]} border-x=mirror border-y=extrapolate alpha=height",
     f"--blur 1.5 {FORMS[1]} --border-x mirror --border-y extrapolate --alpha height"),
    (3, 8, "large=0 source=luma border-y=repeat-slope kernel=gimp7",
     "--octaves 1,0,0,0,-1 --source luma --border-y repeat-slope --kernel gimp7"),
    (4, 8, "dither=integrable", "--dither integrable"),
    (3, 16, "dither=integrable kernel=gimp9 border-x=clamp border-y=mirror",
     "--dither integrable --kernel gimp9 --border-x clamp --border-y mirror"),
    (3, 8, "dither=integrable blur=2 invert=true", "--dither integrable --blur 2 --invert"),
    (4, 8, "channels=zyx", "--channels zyxa"),
    (3, 16, "channels=xzy", "--channels xzy"),
    (4, 16, "channels=1y0x", "--channels 1y0x"),
    (3, 8, "channels=1y0x", "--channels 1y0x"),
    (3, 8, "preset=unreal channels=zyx kernel=sobel3", f"{DOWN} --kernel sobel3"),
    (4, 16, "preset=unity to-y=down to=zzero", "--to-y up"),
    (3, 8, "preset=godot to=xy", "--to-y up"),
    (3, 8, "preset=source", DOWN),
    (3, 8, "preset=labpbr", f"{DOWN} --to xy --alpha height"),
    (1, 16, "preset=gimp kernel=sobel3", "--like gegl:-12.5 --blue nearest"),
    (3, 8, "preset=gimp-normalmap kernel=sobel3", "--like gimp-normalmap:sobel3:-12.5"),
    (3, 8, "preset=gimp-normalmap kernel=forward", "--like gimp-normalmap:4sample:-12.5"),
]  # fmt: skip


@pytest.mark.parametrize(("channels", "depth", "properties", "options"), SAME)
def test_smoothed_dithered_arranged(gegl, ntp, channels, depth, properties, options):
    heights = picture(97, 71, channels, depth)
    scale = [] if "--like" in options else ["--scale", "-12.5"]
    expected = ntp(heights, "from-height", *scale, *options.split())
    made = gegl(heights, "ntp:normals-from-height", "scale=-12.5", *properties.split(), threads=2)
    assert made.shape == expected.shape
    assert np.count_nonzero((made != expected).any(2)) == 0


# The layer, properties, and the same for `ntp occlusion`.
OPEN = [
    (3, 8, "", ""),
    (4, 16, "source=luma invert=true border-x=mirror", "--source luma --border-x clamp"),
    (1, 8, "blur=2", "--blur 2"),
    (4, 8, "preset=labpbr strength=0.5", ""),
]


@pytest.mark.parametrize(("channels", "depth", "properties", "options"), OPEN)
def test_occlusion(gegl, ntp, run, tmp_path, channels, depth, properties, options):
    """Blue is what `ntp occlusion` makes; a part is that of the whole layer."""
    heights = picture(83, 61, channels, depth)
    scale = -12.5 * (0.5 if "strength" in properties else 1)
    pngs.write_png(tmp_path / "h.png", heights)
    turned = -scale if "invert" in properties else scale
    words = ["--type", "height", "--scale", str(turned), "--border", "wrap", *options.split()]
    done = run("occlusion", "h.png", "-o", "ao.png", *words)
    assert done.returncode == 0, done.stderr
    words = options.replace("clamp", "mirror").split()
    words += ["--invert"] if "invert" in properties else []
    words += ["--to-y", "down", "--alpha", "height"] if "labpbr" in properties else []
    words += ["--to", "xy", "--ao", str(tmp_path / "ao.png"), "--scale", str(scale)]
    expected = ntp(heights, "from-height", *words)
    operation = ["ntp:normals-from-height", "scale=-12.5", "to=xy", "occlusion=true"]
    operation += properties.split()
    made = gegl(heights, *operation, threads=2)
    assert np.ptp(made[..., 2]) > 0
    assert np.count_nonzero((made != expected).any(2)) == 0
    part = gegl(heights, *operation, "gegl:crop", "x=11", "y=7", "width=50", "height=30")
    assert (part == expected[7:37, 11:61]).all()


@pytest.mark.parametrize(
    "properties", ["blur=3 small=2", "dither=integrable", "blur=2 dither=integrable"]
)
def test_parts_of_what_reaches_far(gegl, properties):
    """A part that is asked for alone; the scale is that of the heights before they are blurred."""
    heights = picture(530, 300, 3, 8)
    operation = ["ntp:normals-from-height", *properties.split()]
    whole = gegl(heights, *operation, f"scale={suggested_scale(heights)!r}", threads=4)
    part = gegl(heights, *operation, "gegl:crop", "x=37", "y=40", "width=50", "height=30")
    assert (part == whole[40:70, 37:87]).all()


@pytest.mark.parametrize("border", ["wrap", "clamp", "mirror", "extrapolate", "repeat-slope"])
@pytest.mark.parametrize("size", [(1, 1), (2, 1), (1, 3), (3, 3), (5, 9), (8, 2)])
def test_small(gegl, ntp, size, border):
    heights = picture(*size, 3, 16)
    for kernel in ("central", "gimp9"):
        settings = {"scale": "4", "kernel": kernel, "border-x": border, "border-y": border}
        expected = ntp(heights, "from-height", *to_options(settings))
        made = gegl(heights, "ntp:normals-from-height", *to_properties(settings))
        assert (made == expected).all()


@pytest.mark.parametrize("border", ["wrap", "repeat-slope"])
@pytest.mark.parametrize("kernel", ["forward", "gimp9"])
def test_threads_and_blocks(gegl, ntp, kernel, border):
    """Larger than a block and a tile, cut among threads."""
    heights = picture(1201, 517, 1, 8)
    settings = {"scale": "30", "kernel": kernel, "border-x": border, "border-y": border}
    expected = ntp(heights, "from-height", *to_options(settings))
    for threads in (1, 4):
        made = gegl(heights, "ntp:normals-from-height", *to_properties(settings), threads=threads)
        assert (made == expected).all()


@pytest.mark.parametrize("border", ["wrap", "repeat-slope", "mirror"])
def test_parts(gegl, border):
    """A part that is asked for alone is that part of the whole.

    What comes before the operation makes only what the operation says that it needs.
    """
    heights = picture(90, 70, 3, 8)
    operation = [
        "ntp:clean-normals",
        "repair=none",
        "ntp:normals-from-height",
        "kernel=gimp7",
        f"border-x={border}",
        f"border-y={border}",
    ]
    whole = gegl(heights, *operation)
    for x, y, w, h in [
        (0, 0, 5, 4),
        (83, 64, 7, 6),
        (40, 30, 11, 13),
        (0, 69, 90, 1),
        (89, 0, 1, 70),
    ]:
        part = gegl(
            heights, *operation, "gegl:crop", f"x={x}", f"y={y}", f"width={w}", f"height={h}"
        )
        assert (part == whole[y : y + h, x : x + w]).all()


def test_offsets(gegl):
    """A picture that does not begin at 0, 0 has its edges where it has them."""
    heights = picture(40, 30, 3, 8)
    whole = gegl(heights, "ntp:normals-from-height", "kernel=sobel5")
    moved = gegl(
        heights, "gegl:translate", "x=-13", "y=57", "ntp:normals-from-height", "kernel=sobel5"
    )
    assert (moved == whole).all()


def test_alpha_height_of_opaque(gegl, ntp):
    heights = picture(31, 20, 1, 16)
    expected = ntp(heights, "from-height", "--scale", "10", "--alpha", "height")
    made = gegl(heights, "ntp:normals-from-height", "scale=10", "alpha=height")
    assert made.shape[2] == 4
    assert (made == expected).all()


def suggested_scale(heights, kernel="central"):
    """ntp_relief_scale of a picture that wraps, of red."""
    view = ffi_lib.view(np.ascontiguousarray(heights), ffi_lib.HEIGHT, const=True)
    how = ffi_lib.ffi.new("ntp_normals_options *", {"kernel": 9 if kernel == "gimp9" else 0})
    relief, first = ffi_lib.ffi.new("ntp_relief *"), ffi_lib.ffi.new("int32_t *")
    rows, columns = heights.shape[:2]
    for y in range(rows):
        step = ffi_lib.lib.ntp_relief_row(columns, rows, y, first)
        if step > 0:
            ffi_lib.check(ffi_lib.lib.ntp_relief_add(relief, view, how, first[0], y, step))
    return ffi_lib.lib.ntp_relief_scale(relief)


@pytest.mark.parametrize(("depth", "kernel"), [(8, "central"), (16, "gimp9")])
def test_scale_of_the_layer(gegl, ntp, depth, kernel):
    """Without a scale it is that of all of the layer, also for a part; strength multiplies it."""
    heights = picture(530, 300, 3, depth)
    scale = suggested_scale(heights, kernel)
    expected = ntp(heights, "from-height", "--scale", repr(scale * 0.5), "--kernel", kernel)
    operation = ["ntp:normals-from-height", "strength=0.5", f"kernel={kernel}"]
    for threads in (1, 4):
        assert (gegl(heights, *operation, threads=threads) == expected).all()
    part = gegl(heights, *operation, "gegl:crop", "x=37", "y=40", "width=50", "height=30")
    assert (part == expected[40:70, 37:87]).all()


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("channels", [1, 3, 4])
@pytest.mark.parametrize(
    "settings",
    [
        {"kind": "mean", "range": "0.3", "border": "wrap"},
        {"kind": "cavity", "range": "0.7", "border": "clamp"},
    ],
)
def test_curvature(gegl, ntp, channels, depth, settings):
    """Of heights and of normals the numbers of `ntp curvature`, as a gray picture."""
    if channels == 1:
        src = picture(150, 133, 1, depth)
        how, also = ["--type", "height", "--scale", "7.3"], ["from=height", "scale=7.3"]
    else:
        src = rough_normals(channels, depth)
        how, also = ["--type", "standard", "--y", "down"], ["from-y=down"]
    expected = ntp(src, "curvature", *how, *to_options(settings))[:, :, :1]
    properties = [*to_properties(settings), *also]
    made = gegl(src, "ntp:curvature", *properties, threads=4)
    assert (made[:, :, :3] == expected).all()
    if channels == 4:
        assert (made[:, :, 3] == src[:, :, 3]).all()
    crop = ["gegl:crop", "x=3", "y=0", "width=9", "height=5"]
    assert (gegl(src, "ntp:curvature", *properties, *crop)[:, :, :3] == expected[:5, 3:12]).all()


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("channels", [1, 4])
@pytest.mark.parametrize("settings", [{"border": "wrap"}, {"radius": "9", "border": "clamp"}])
def test_ambient_occlusion(gegl, ntp, channels, depth, settings):
    """The numbers of `ntp occlusion`, as a gray picture; a part is that part of the whole."""
    heights = picture(90, 71, channels, depth)
    settings = {"scale": "20"} | settings
    expected = ntp(heights, "occlusion", "--type", "height", *to_options(settings))[:, :, :1]
    made = gegl(heights, "ntp:ambient-occlusion", *to_properties(settings), threads=4)
    assert (made[:, :, :3] == expected).all() and expected.min() < expected.max()
    if channels == 4:
        assert (made[:, :, 3] == heights[:, :, 3]).all()
    crop = ["gegl:crop", "x=3", "y=2", "width=9", "height=5"]
    part = gegl(heights, "ntp:ambient-occlusion", *to_properties(settings), *crop)
    assert (part[:, :, :3] == expected[2:7, 3:12]).all()
    flat = gegl(heights, "ntp:ambient-occlusion", "scale=0")
    assert (flat[:, :, :3] == np.iinfo(flat.dtype).max).all()
