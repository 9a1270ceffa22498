# SPDX-License-Identifier: MIT
"""The GEGL operations in GIMP 3: the same numbers as `ntp`.  `./dev gimp3` runs it.

GIMP is started once, for all that is to be done.  Jobs are declared beside their tests.
"""

import os
import subprocess

import numpy as np
import pytest

from support import libntp_ffi, pngs
from support.gegl_pictures import CHANNELS, DEPTHS, GAMMA, picture, rough_normals, to_options
from support.gimps import Gimp3
from support.libntp_ffi import ffi, lib

CHROOT = os.environ.get("NTP_GIMP3")
pytestmark = pytest.mark.skipif(not CHROOT, reason="NTP_GIMP3 names no chroot; use ./dev gimp3")

OPERATION = "ntp:normals-from-height"
SETTINGS = {"scale": 7.3, "to-y": "down", "kernel": "sobel3"}
PLAIN = [OPERATION, SETTINGS]
CLEAN = ["ntp:clean-normals", {"to-y": "down"}]
ZZERO = ["ntp:clean-normals", {"to": "zzero", "to-y": "down"}]
OTHER = ["gegl:invert-gamma", {}]  # not ours
# What reaches far, or changes other channels; and the options of `ntp` that are the same.
FAR = {
    "forms": (
        {"scale": 7.3, "blur": 1.5, "small": 0.5, "middle": 2, "large": 1.25},
        "--scale 7.3 --blur 1.5 --octaves 0.5,0,1.5,0,-0.75",
    ),
    "dither": (
        {"scale": 2.5, "dither": "integrable", "blur": 0.7},
        "--scale 2.5 --dither integrable --blur 0.7",
    ),
    "auto": ({"strength": 0.3, "channels": "zyx"}, "--scale auto --strength 0.3 --channels zyx"),
    "labpbr": (
        {"scale": 7.3, "preset": "labpbr"},
        "--scale 7.3 --to-y down --to xy --alpha height",
    ),
}
WIDTH, HEIGHT = 150, 133
PART = (20, 30, 77, 55)  # x, y, width, height of the selection
PRECISIONS = [
    f"{kind}_{curve}"
    for kind in ("U8", "U16", "U32", "HALF", "FLOAT", "DOUBLE")
    for curve in ("LINEAR", "NON_LINEAR", "PERCEPTUAL")
]


def name_of(channels, depth, gamma):
    return f"{depth}bit-{channels}{'-gAMA' if gamma else ''}"


INPUTS = {
    name_of(c, d, g): (picture(WIDTH, HEIGHT, c, d), (GAMMA,) if g else ())
    for c in CHANNELS
    for d in DEPTHS
    for g in (False, True)
}
INPUTS["rough8"] = rough_normals(3, 8), (GAMMA,)
INPUTS["rough16"] = rough_normals(4, 16), ()
INPUTS["rough8-plain"] = rough_normals(3, 8), ()
INPUTS["rough16-gAMA"] = rough_normals(3, 16), (GAMMA,)
ROUGH = [name for name in INPUTS if name.startswith("rough")]
INPUTS["one"] = picture(1, 1, 3, 8), ()
RGB, RGBA = name_of(3, 8, False), name_of(4, 16, False)
SELECTED = [name_of(c, d, g) for c in (3, 4) for d in DEPTHS for g in (False, True)]


def jobs():
    todo = {}
    for name, (pixels, _) in INPUTS.items():
        if name.startswith("rough"):
            continue
        # Mode > RGB converts by the profile: without one gray becomes three times the same.
        first = [["discard_profile"], ["mode", "rgb"]] if pixels.shape[2] < 3 else []
        for how in ("merge", "append"):
            save = ["save", f"{name}-{how}.png"]
            todo[f"{name}-{how}"] = {"file": f"{name}.png", "steps": [*first, [how, *PLAIN], save]}

    def job(name, *steps, file=RGB):
        todo[name] = {"file": f"{file}.png", "steps": list(steps)}

    for file in SELECTED:
        for how in ("merge", "append"):
            for name, what in (("normals", PLAIN), ("zzero", ZZERO), ("other", OTHER)):
                steps = [["select", *PART], [how, *what]]
                job(f"{file}-{name}-{how}", *steps, ["save", f"{file}-{name}-{how}.png"], file=file)
    for file in (RGB, RGBA):
        xcf = [["append", *PLAIN], ["reopen", f"{file}.xcf"], ["save", f"{file}-xcf.png"]]
        job(f"{file}-xcf", *xcf, file=file)
    job(
        "offsets",
        ["enlarge", 400, 300, 100, 50],
        ["offsets", 33, -7],
        ["merge", *PLAIN],
        ["dump", "offsets"],
    )
    for name, (settings, _) in FAR.items():
        for file in (RGB, RGBA):
            for how in ("merge", "append"):
                steps = [[how, OPERATION, settings], ["save", f"{file}-{name}-{how}.png"]]
                job(f"{file}-{name}-{how}", *steps, file=file)
        settings = ["append", OPERATION, settings]
        job(f"{name}-xcf", settings, ["reopen", f"{name}.xcf"], ["save", f"{name}-xcf.png"])
    job("group", ["group"], ["append", *PLAIN], ["save", "group.png"])
    job("indexed", ["mode", "indexed"], ["merge", *PLAIN], ["dump", "indexed"])
    job("gray", ["merge", *PLAIN], ["dump", "gray"], file=name_of(1, 8, False))
    job("one-wrap", ["merge", *PLAIN], ["dump", "one-wrap"], file="one")
    height = {**SETTINGS, "alpha": "height"}
    for file in (RGB, name_of(3, 16, True)):
        job(
            f"{file}-no-alpha",
            ["merge", OPERATION, height],
            ["dump", f"{file}-no-alpha"],
            file=file,
        )
    job("alpha", ["add_alpha"], ["merge", OPERATION, height], ["save", "alpha.png"])
    masked = [["select", *PART], ["mask", "SELECTION"], ["select_all"]]
    job("mask-merge", *masked, ["merge", *PLAIN], ["dump", "mask-merge"])
    job("mask-append", *masked, ["append", *PLAIN], ["save", "mask-append.png"])
    for precision in PRECISIONS:
        for name, what, file in (
            ("rgba", [OPERATION, height], RGBA),
            ("clean", CLEAN, "rough16"),
        ):
            steps = [["precision", precision], ["dump", f"{precision}-{name}-in"], ["merge", *what]]
            job(f"{precision}-{name}", *steps, ["dump", f"{precision}-{name}-out"], file=file)
        steps = [["precision", precision], ["dump", f"{precision}-in"], ["merge", *PLAIN]]
        job(precision, *steps, ["dump", f"{precision}-out"], file=name_of(3, 16, True))
    for file in ROUGH:
        for how in ("merge", "append"):
            job(f"{file}-{how}", [how, *ZZERO], ["save", f"{file}-{how}.png"], file=file)
        job(
            f"{file}-heat",
            ["append", "ntp:clean-normals", {"show": "heatmap"}],
            ["save", f"{file}-heat.png"],
            file=file,
        )
    return todo


@pytest.fixture(scope="module")
def gimp():
    made = Gimp3(CHROOT, "operations")
    for name, (pixels, chunks) in INPUTS.items():
        pngs.write_png(made.work / f"{name}.png", pixels, chunks=chunks)
    made.results, made.complaints = made.run(jobs())
    return made


@pytest.fixture
def done(gimp):
    """done(job, file) -> the pixels of a PNG file that the job saved."""

    def look(job, file=None):
        assert gimp.results[job]["error"] is None, gimp.results[job]["error"]
        return pngs.read_png(gimp.work / (file or f"{job}.png"))[0]

    return look


@pytest.fixture
def raw(gimp):
    """raw(job, file, dtype) -> what the job dumped."""

    def look(job, file=None, dtype=np.uint8):
        assert gimp.results[job]["error"] is None, gimp.results[job]["error"]
        height, width, size = gimp.results[job]["shape"]
        data = np.fromfile(gimp.work / (file or job), dtype)
        return data.reshape(height, width, size // np.dtype(dtype).itemsize)

    return look


@pytest.fixture
def ntp(program, tmp_path):
    """ntp(pixels, verb, option...) -> the pixels that the program makes."""

    def call(pixels, verb, *options):
        source, made = tmp_path / "in.png", tmp_path / "out.png"
        pngs.write_png(source, pixels)
        subprocess.run([program, verb, "-q", *options, source, "-o", made], check=True)
        return pngs.read_png(made)[0]

    return call


OPTIONS = to_options({k: str(v) for k, v in SETTINGS.items()})


def different(a, b):
    """How many texels differ."""
    assert a.shape == b.shape and a.dtype == b.dtype
    return int((a != b).any(2).sum())


@pytest.mark.parametrize("how", ["merge", "append"])
@pytest.mark.parametrize("gamma", [False, True], ids=["plain", "gAMA"])
@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("channels", CHANNELS)
def test_same_as_ntp(done, ntp, channels, depth, gamma, how):
    """Merged, and non-destructive."""
    name = name_of(channels, depth, gamma)
    assert different(done(f"{name}-{how}"), ntp(INPUTS[name][0], "from-height", *OPTIONS)) == 0


@pytest.mark.parametrize("file", [RGB, RGBA])
@pytest.mark.parametrize("name", FAR)
def test_far(done, ntp, name, file):
    """Merged, as a layer effect, and saved with the layer."""
    words = FAR[name][1].split()
    if "zyx" in words and file == RGBA:
        words[-1] += "a"
    expected = ntp(INPUTS[file][0], "from-height", *words)
    for how in ("merge", "append"):
        made = done(f"{file}-{name}-{how}")
        assert different(made, expected[..., : made.shape[2]]) == 0, how
    if file == RGB:
        made = done(f"{name}-xcf")
        assert different(made, expected[..., : made.shape[2]]) == 0


def selected(pixels, how, make):
    """Pixels with what is made of the selection, or of it in the whole layer, in the selection.

    GIMP gives a merged filter the selection alone: it is the picture.  A layer effect sees all.
    """
    x, y, w, h = PART
    inside = (slice(y, y + h), slice(x, x + w))
    expected = pixels.copy()
    expected[inside] = make(pixels[inside]) if how == "merge" else make(pixels)[inside]
    return expected, inside


def assert_selected(made, expected, inside, file, other):
    """Exact, but where GIMP blends 16 bits in the linear light of a gamma curve.

    There in + (out - in) in single precision cannot end in each of the darkest levels, babl's curve
    leaves out some of the others, and a layer effect changes what is not selected, as any does.
    """
    if not file.startswith("16bit") or not file.endswith("gAMA"):
        assert different(made, expected) == 0
        return
    off = np.abs(made[inside].astype(int) - expected[inside]).max(2)
    dark = expected[inside].min(2) < 512
    print(f"\n{file}: {(off > 0).sum()} of {off.size} selected texels off, by up to {off.max()}")
    assert (off[~dark] > 0).mean() < 1e-3
    assert off.max() <= 33
    outside = np.ones(made.shape[:2], bool)
    outside[inside] = False
    assert (made[outside] == other[outside]).all()


@pytest.mark.parametrize("how", ["merge", "append"])
@pytest.mark.parametrize("file", SELECTED)
def test_selection(done, ntp, file, how):
    pixels = INPUTS[file][0]
    expected = selected(pixels, how, lambda p: ntp(p, "from-height", *OPTIONS))
    other = done(f"{file}-other-{how}")
    assert_selected(done(f"{file}-normals-{how}"), *expected, file, other)


@pytest.mark.parametrize("how", ["merge", "append"])
@pytest.mark.parametrize("file", SELECTED)
def test_selection_cleaned(done, file, how):
    """Of pictures that are no normals at all, with Z from 0: the darkest levels come about."""
    pixels = INPUTS[file][0]
    expected = selected(pixels, how, lambda p: cleaned(p, libntp_ffi.ZZERO))
    assert_selected(done(f"{file}-zzero-{how}"), *expected, file, done(f"{file}-other-{how}"))


@pytest.mark.parametrize("file", [RGB, RGBA])
def test_saved_and_reopened(gimp, done, ntp, file):
    assert different(done(f"{file}-xcf"), ntp(INPUTS[file][0], "from-height", *OPTIONS)) == 0
    assert gimp.results[f"{file}-xcf"]["filters"] == [OPERATION]


def test_mask(raw, done, ntp):
    """A layer mask hides texels, it does not change them."""
    expected = ntp(INPUTS[RGB][0], "from-height", *OPTIONS)
    assert different(raw("mask-merge"), expected) == 0
    x, y, w, h = PART
    made = done("mask-append")
    shown = np.zeros((HEIGHT, WIDTH), bool)
    shown[y : y + h, x : x + w] = True
    assert ((made[:, :, 3] == 255) == shown).all() and ((made[:, :, 3] == 0) == ~shown).all()
    assert (made[shown][:, :3] == expected[shown]).all()


def test_offsets(raw, ntp):
    assert different(raw("offsets"), ntp(INPUTS[RGB][0], "from-height", *OPTIONS)) == 0


def test_group(done, ntp):
    made = done("group")
    assert different(made[:, :, :3], ntp(INPUTS[RGB][0], "from-height", *OPTIONS)) == 0


def test_one_texel(raw):
    assert raw("one-wrap").tolist() == [[[128, 128, 255]]]


def test_alpha(raw, done, ntp):
    """The height goes into an alpha channel that there is; without one colors are as ever."""
    for file in (RGB, name_of(3, 16, True)):
        pixels = INPUTS[file][0]
        made = raw(f"{file}-no-alpha", dtype=pixels.dtype)
        assert different(made, ntp(pixels, "from-height", *OPTIONS)) == 0
    pixels = INPUTS[RGB][0]
    expected = ntp(pixels, "from-height", *OPTIONS, "--alpha", "height")
    assert different(done("alpha"), expected) == 0


def test_gray_and_indexed(raw):
    """An operation cannot change the mode: nothing of use, but nothing bad either."""
    assert raw("gray").shape == (HEIGHT, WIDTH, 1)
    assert raw("indexed").shape == (HEIGHT, WIDTH, 1)


def normals_of(heights):
    """The library's, of the settings above, in the type of the heights; an alpha is the height."""
    alpha = lib.NTP_ALPHA_HEIGHT if heights.shape[2] == 4 else lib.NTP_ALPHA_KEEP
    kernel = lib.NTP_KERNEL_SOBEL3
    how = ffi.new("ntp_normals_options *", {"scale": 7.3, "kernel": kernel, "alpha": alpha})
    made = np.zeros_like(heights)
    src = libntp_ffi.view(heights, encoding=libntp_ffi.HEIGHT, const=True)
    dst = libntp_ffi.view(made, encoding=libntp_ffi.STANDARD, y=libntp_ffi.DOWN)
    libntp_ffi.check(lib.ntp_normals_from_height(dst, src, how, ffi.NULL, ffi.NULL))
    return made


def cleaned(normals, encoding=libntp_ffi.STANDARD):
    """The library's, with green turned down."""
    made = np.zeros_like(normals)
    src = libntp_ffi.view(normals, encoding=libntp_ffi.STANDARD, const=True)
    dst = libntp_ffi.view(made, encoding=libntp_ffi.STANDARD)
    libntp_ffi.check(lib.ntp_clean(dst, src, ffi.NULL, ffi.NULL, ffi.NULL, ffi.NULL))
    turned = np.zeros_like(normals)
    src = libntp_ffi.view(made, encoding=libntp_ffi.STANDARD, const=True)
    dst = libntp_ffi.view(turned, encoding=encoding, y=libntp_ffi.DOWN)
    libntp_ffi.check(lib.ntp_convert(dst, src, ffi.NULL, ffi.NULL, ffi.NULL))
    return turned


KINDS = {"U8": "u1", "U16": "u2", "U32": "u4", "HALF": "f2", "FLOAT": "f4", "DOUBLE": "f8"}


@pytest.mark.parametrize("kind", ["", "-rgba"], ids=["rgb", "rgba"])
@pytest.mark.parametrize("precision", PRECISIONS)
def test_precision(raw, precision, kind):
    """The stored numbers are the heights, whatever they mean to GIMP; 8 and 16 bit are exact."""
    dtype = np.dtype(KINDS[precision.split("_")[0]])
    name = precision + kind
    heights, made = (raw(name, f"{name}-{end}", dtype) for end in ("in", "out"))
    assert heights.shape[2] == (4 if kind else 3)
    if dtype.kind == "u" and dtype.itemsize <= 2:
        assert different(made, normals_of(heights)) == 0
        return
    # The others go through single precision, and back with GIMP's rounding.
    top = 2**32 - 1 if dtype.kind == "u" else 1
    expected = normals_of((heights.astype(np.float64) / top).astype(np.float32))
    step = {"u4": 2.0**-32, "f2": 2.0**-11, "f4": 0, "f8": 0}[dtype.str[1:]]
    assert np.abs(made.astype(np.float64) / top - expected).max() <= step


@pytest.mark.parametrize("precision", PRECISIONS)
def test_clean_precision(raw, precision):
    """Stored numbers again; what is neither 8, 16 nor 32 bits of float goes through the latter."""
    dtype = np.dtype(KINDS[precision.split("_")[0]])
    name = f"{precision}-clean"
    normals, made = (raw(name, f"{name}-{end}", dtype) for end in ("in", "out"))
    if dtype.str[1:] in ("u1", "u2", "f4"):
        assert different(made, cleaned(normals)) == 0
        return
    # Where red and green alone have about length 1, blue comes of the last bits.
    top = 2**32 - 1 if dtype.kind == "u" else 1
    expected = cleaned((normals.astype(np.float64) / top).astype(np.float32))
    off = np.abs(made.astype(np.float64) / top - expected)
    assert off[:, :, [0, 1, 3]].max() <= 2.0**-11 and off[:, :, 2].max() <= 2.0**-9


@pytest.mark.parametrize("how", ["merge", "append"])
@pytest.mark.parametrize("file", ROUGH)
def test_clean(done, ntp, file, how):
    cleaned = ntp(INPUTS[file][0], "clean", "--type", "standard", "--method", "derive")
    told = ["--from", "standard", "--from-y", "up"]
    expected = ntp(cleaned, "convert", *told, "--to", "zzero", "--to-y", "down")
    assert different(done(f"{file}-{how}"), expected) == 0


def test_heatmap(done, ntp):
    for file in ROUGH:
        expected = ntp(INPUTS[file][0], "heatmap", "--type", "standard")[:, :, :3]
        made = done(f"{file}-heat")[:, :, :3]
        assert different(made, expected.astype(made.dtype) * (257 if "16" in file else 1)) == 0


def test_no_complaints(gimp):
    assert gimp.complaints == []
