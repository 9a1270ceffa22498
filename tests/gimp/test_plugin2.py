# SPDX-License-Identifier: MIT
"""The plug-in in GIMP 2.10, without a window: the same numbers as `ntp`.

GIMP is started once, for all that is to be done.
"""

import json
import re
import shutil
import subprocess

import numpy as np
import pytest

from support import gimp2, pngs
from support.gimp2_jobs import (
    CONVERSIONS,
    FILTERS,
    JUDGED,
    OF_FILES,
    PRECISE,
    RESIZED,
    ROUGH,
    TEST_FILES,
    classic_jobs,
    exact_jobs,
    judged,
    layer_jobs,
    normals_jobs,
    precision_jobs,
    refused_jobs,
    remedy_jobs,
    resize_jobs,
)
from support.gimps import built_with, complaints
from support.plugin_cases import (
    CASES,
    GAMMA,
    HEIGHT,
    INPUTS,
    MISPLACED,
    PART,
    PARTS,
    REMEDIES,
    SETTINGS,
    WIDTH,
    assert_normals_of,
    different,
    options,
    part_of,
    picture,
    rough_normals,
)
from support.xcf import read_xcf

if shutil.which(gimp2.PROGRAM) is None and shutil.which("gimp-console-3.0"):
    pytest.skip("this system has GIMP 3: see ./dev gimp3", allow_module_level=True)

# One process of pytest takes all of them, so that GIMP is started once.
pytestmark = pytest.mark.xdist_group("gimp2")


PRECISE += [("gray16", f"{kind}-GAMMA") for kind in ("U8", "U16", "U32", "HALF", "FLOAT", "DOUBLE")]


@pytest.fixture(scope="module")
def gimp(tmp_path_factory):
    file = "gimp-plugin/plug-in/gimp2/ntp-normals"
    plugin = built_with("gimpui-2.0 >= 2.10", "gimp", file)
    if shutil.which(gimp2.PROGRAM) is None:
        pytest.skip("GIMP 2.10 is not installed")
    made = gimp2.Gimp2(plugin, tmp_path_factory.mktemp("gimp2"))
    for name, (pixels, chunks) in INPUTS.items():
        pngs.write_png(made.work / f"{name}.png", pixels, chunks=chunks)
    pngs.write_png(made.work / "one.png", picture(3, 8, 1, 1))
    pngs.write_png(made.work / "rough8.png", rough_normals(3, 8))
    pngs.write_png(made.work / "rough16.png", rough_normals(4, 16))
    pngs.write_png(made.work / "rough8-gama.png", rough_normals(3, 8), chunks=(GAMMA,))
    noise = np.random.default_rng(1).integers(0, 256, (HEIGHT, WIDTH, 3)).astype(np.uint8)
    pngs.write_png(made.work / "noise.png", noise)
    pixels = pngs.read_png(TEST_FILES / "standard.png")[0].copy()
    pixels[:9, :, 2] = 255 - pixels[:9, :, 2]
    pngs.write_png(made.work / "mirrored.png", pixels)
    pngs.write_png(made.work / "equal.png", np.repeat(picture(1, 8), 3, 2))
    for name in MISPLACED:
        shutil.copy(TEST_FILES / f"{name}.png", made.work)
    for name in JUDGED:
        shutil.copy(TEST_FILES / f"{name}.png", made.work / f"{judged(name)}.png")
    pixels = pngs.read_png(TEST_FILES / "standard_z_off.png")[0].copy()
    pixels[:7] = (0, 255, 0)  # black padding whose green was flipped
    pngs.write_png(made.work / "judged-padding.png", pixels)
    jobs = exact_jobs() | precision_jobs() | layer_jobs() | classic_jobs() | normals_jobs()
    jobs |= resize_jobs() | remedy_jobs()
    made.messages = made.run(jobs, refused_jobs())
    return made


@pytest.fixture
def done(gimp):
    """done(job, file) -> the pixels that the job saved."""

    def look(job, file=None):
        assert f"job-{job}-done" in gimp.messages[job], gimp.messages[job]
        path = gimp.work / (file or f"{job}.png")
        whole = path.with_suffix(".xcf")
        return read_xcf(whole) if whole.exists() else pngs.read_png(path)[0]

    return look


@pytest.fixture
def ntp(program, tmp_path):
    """ntp(pixels, verb, option...) -> the pixels that the program makes."""

    def run(pixels, verb, *words):
        source, made = tmp_path / "in.png", tmp_path / "out.png"
        pngs.write_png(source, pixels)
        subprocess.run([program, verb, "-q", *words, source, "-o", made], check=True)
        return pngs.read_png(made)[0]

    return run


@pytest.mark.parametrize(("file", "name"), CASES)
def test_same_as_ntp(done, ntp, file, name):
    expected = ntp(INPUTS[file][0], "from-height", "--scale", "10", *options(SETTINGS[name]))
    assert different(done(f"{file}-{name}"), expected) == 0


@pytest.mark.parametrize("name", RESIZED)
@pytest.mark.parametrize("file", ROUGH)
def test_resize(done, ntp, file, name):
    """The whole picture, whatever is selected."""
    pixels = rough_normals(4 if "16" in file else 3, 16 if "16" in file else 8)
    expected = ntp(pixels, "resize", *RESIZED[name][1])
    assert different(done(f"{file}-{name}"), expected) == 0


def test_resize_a_layer(gimp, done, ntp):
    """It stays where it begins, and the image keeps its size."""
    expected = ntp(rough_normals(3, 8), "resize", "--size", "50%")
    assert different(done("resize-layer"), expected) == 0
    assert f"size {WIDTH} {HEIGHT} 76 67 7 -3 " in gimp.messages["resize-layer"]


def test_resize_an_image(gimp, done, ntp):
    """Both layers, each as a picture of its own; a mask follows."""
    assert "size 76 67 76 67 0 0 " in gimp.messages["resize-image"]
    expected = ntp(rough_normals(3, 8), "resize", "--size", "50%")
    made = done("resize-image", "resize-below.png")
    assert different(made[:, :, :3], expected) == 0
    # GIMP opens 16 bits into an image of 8 by its own rounding: this is about the place.
    assert done("resize-image", "resize-above.png").shape[2] == 4


@pytest.mark.parametrize("file", PARTS)
def test_selection(done, ntp, file):
    """Inside, the texels of the whole picture; outside, those that were there."""
    pixels = INPUTS[file][0]
    whole = ntp(pixels, "from-height", *options(SETTINGS["sobel"]))
    made, expected = done(f"{file}-part"), part_of(whole, pixels)
    x, y, w, h = PART
    inside = (slice(y, y + h), slice(x, x + w))
    assert different(made[inside], expected[inside]) == 0
    if pixels.shape[2] > 2:  # gray outside is converted by GIMP
        assert different(made, expected) == 0


@pytest.mark.parametrize(("file", "precision"), PRECISE)
def test_precision(gimp, file, precision):
    name = f"{file}-{precision}"
    assert f"job-{name}-done" in gimp.messages[name], gimp.messages[name]
    assert_normals_of(*(read_xcf(gimp.work / f"{name}-{end}.xcf") for end in ("in", "out")))


@pytest.mark.parametrize("alpha", ["keep", "one", "inverse", "height"])
def test_alpha(done, ntp, alpha):
    expected = ntp(INPUTS["rgba8"][0], "from-height", "--scale", "10", "--alpha", alpha)
    assert different(done(f"alpha-{alpha}"), expected) == 0


def test_alpha_is_added(done, ntp):
    expected = ntp(INPUTS["gray16"][0], "from-height", "--scale", "10", "--alpha", "height")
    assert different(done("adds-alpha"), expected) == 0


def test_other_layers(done, ntp):
    made = done("other-height", "oh.png")
    expected = ntp(INPUTS["rgb8"][0], "from-height", *options(SETTINGS["sobel"]))
    assert different(made[:, :, :3], expected) == 0
    assert (made[:, :, 3] == INPUTS["rgba8"][0][:, :, 3]).all()  # the layer's own
    made = done("other-alpha", "oa.png")
    assert different(made[:, :, :3], expected) == 0
    r, g, b = np.moveaxis(INPUTS["rgba8"][0][:, :, :3].astype(int), 2, 0)
    luma = (2126 * r + 7152 * g + 722 * b) / 10000
    assert np.abs(made[:, :, 3] - luma).max() <= 0.5001


def test_offsets_and_mask(done, ntp):
    expected = ntp(INPUTS["rgb8"][0], "from-height", *options(SETTINGS["sobel"]))
    assert different(done("offsets"), expected) == 0
    assert different(done("mask"), expected) == 0


@pytest.mark.parametrize("job", ["forced", "blue-is-height"])
def test_normals_of_normals(done, ntp, job):
    """Who insists gets them, and a single channel may well be a height: as `ntp` takes them."""
    words = {"forced": ["--force"], "blue-is-height": ["--source", "blue"]}[job]
    expected = ntp(rough_normals(4, 16), "from-height", *options(SETTINGS["sobel"]), *words)
    assert different(done(job), expected) == 0


def test_one_texel(done):
    assert done("one", "one-out.png").tolist() == [[[128, 128, 255]]]


REFUSED = {
    "indexed": "Indexed images",
    "group": "layer group",
    "on-mask": "works on layers",
    "no-layer": "",  # by GIMP itself
    "locked": "locked",
    "no-alpha": "no alpha channel",
    "other-size": "another size",
    "min-z": "argument min-z",
    "kernel": "argument kernel",
    "gray-height": "is gray",
    "gray-clean": "is gray",
    "gray-classic": "is gray",
    "no-alpha-layer": "none is chosen",
    "no-alpha-map": "none is chosen",
    "heightfield": "looks like a heightfield",
    **dict.fromkeys(
        ["normals", "normals-luma", "normals-zzero", "other-normals"], "normals already"
    ),
    "text": "text layer",
    "no-remedy": "not one for this layer",
    "photograph": "not look like a normals texture",
    **dict.fromkeys(MISPLACED, "this would make it worse"),
}


@pytest.mark.parametrize("job", REFUSED)
def test_refused(gimp, job):
    """With a sentence that says why; the image is as it was."""
    assert f"job-{job}-done" not in gimp.messages[job]
    assert REFUSED[job] in gimp.messages[job], gimp.messages[job]


@pytest.mark.parametrize("i", range(9))
def test_classic_filters(done, ntp, i):
    border = "wrap" if i % 2 else "clamp"
    like = f"gimp-normalmap:{FILTERS[i]}:2.5"
    expected = ntp(INPUTS["rgb8"][0], "from-height", "--like", like, "--border", border)
    assert different(done(f"filter-{i}"), expected) == 0


@pytest.mark.parametrize("i", CONVERSIONS)
def test_classic_conversions(done, ntp, i):
    like = ["--like", "gimp-normalmap:sobel3:9", "--source", CONVERSIONS[i]]
    expected = ntp(INPUTS["rgb16"][0], "from-height", *like)
    assert different(done(f"conversion-{i}"), expected) == 0


def test_classic_alpha(done, ntp):
    pixels = INPUTS["rgba8"][0]
    like = ["--like", "gimp-normalmap:4sample:8", "--source", "alpha", "--to-y", "up"]
    made = done("classic-alpha", "ca.png")
    assert different(made[:, :, :3], ntp(pixels, "from-height", *like, "--channels", "xyz")) == 0
    assert (made[:, :, 3] == 255 - pixels[:, :, 3]).all()


def test_classic_biased(done, ntp):
    """The luma of what a color has above the mean color."""
    pixels = INPUTS["rgb16"][0]
    mean = (pixels.reshape(-1, 3).mean(0) + 0.5).astype(int)
    above = np.maximum(pixels.astype(int) - mean, 0).astype(np.uint16)
    expected = ntp(above, "from-height", "--like", "gimp-normalmap:sobel3:9")
    assert different(done("classic-biased", "cb.png"), expected) == 0


def test_classic_xy(done):
    """z = sqrt(1 - x x - y y); x and y stay."""
    pixels, made = rough_normals(3, 8), done("classic-xy", "cx.png")
    x, y = np.moveaxis(pixels[:, :, :2] / 127.5 - 1, 2, 0)
    z = np.sqrt(1 - x * x - y * y)
    assert (made[:, :, :2] == pixels[:, :, :2]).all()
    assert (made[:, :, 2] == np.floor((z + 1) * 127.5 + 0.5)).all()


@pytest.mark.parametrize("i", range(7))
def test_classic_alphas(done, ntp, i):
    pixels = INPUTS["rgba8"][0]
    expected = ntp(pixels, "from-height", "--like", "gimp-normalmap:4sample:5", "--channels", "xyz")
    made, old = done(f"alpha-{i}"), pixels.astype(int)
    assert different(made[:, :, :3], expected) == 0
    height = (30 * old[:, :, 0] + 59 * old[:, :, 1] + 11 * old[:, :, 2]) / 100
    flat = np.zeros_like(height)
    other = INPUTS["gray8"][0][:, :, 0].astype(float)
    alphas = (old[:, :, 3], height, 255 - height, flat, flat + 255, 255 - old[:, :, 3], other)
    assert np.abs(made[:, :, 3] - alphas[i]).max() <= 0.5


def test_classic_normalize(done, ntp):
    """As `ntp clean --method normalize`, and a second time changes nothing."""
    words = ["--type", "standard", "--method", "normalize", "--keep-negative-z"]
    expected = ntp(rough_normals(3, 8), "clean", *words)
    assert different(done("classic-normalize", "cn.png"), expected) == 0
    assert different(done("classic-normalize", "cn2.png"), expected) == 0


def test_classic_height(done):
    """Not inverted: the slopes of the height are those of the normals, by yinvert green up."""
    made, n = done("classic-height", "ch.png")[:, :, 0].astype(float), rough_normals(3, 8)
    x, y, z = np.moveaxis(n[:, :, :3] / 127.5 - 1, 2, 0)
    inner = (slice(2, -2), slice(2, -2))
    right = ((np.roll(made, -1, 1) - np.roll(made, 1, 1)) / 2)[inner].ravel()
    down = ((np.roll(made, -1, 0) - np.roll(made, 1, 0)) / 2)[inner].ravel()
    assert np.corrcoef(right, (-x / z)[inner].ravel())[0, 1] > 0.9
    assert np.corrcoef(down, (y / z)[inner].ravel())[0, 1] > 0.9
    assert made.min() == 0 and made.max() == 255


@pytest.mark.parametrize("i", [1, 2, 3, 4])
def test_classic_dudv(done, i):
    """Against the formula in doubles; at most a few texels lie on the edge of rounding."""
    pixels = INPUTS["rgba8"][0].astype(np.float64)
    h = (0.3 * pixels[:, :, 0] + 0.59 * pixels[:, :, 1] + 0.11 * pixels[:, :, 2]) / 255
    padded = np.pad(h, 1, mode="edge")
    p = (padded[1:-1, 2:] - padded[1:-1, :-2]) / 2 * 8
    q = (padded[2:, 1:-1] - padded[:-2, 1:-1]) / 2 * 8
    n = np.stack([-p, -q], 2) / np.sqrt(1 + p * p + q * q)[:, :, None]
    made = done(f"dudv-{i}").astype(int)
    if i in (1, 3):
        top = 127 if i == 1 else 32767
        expected = np.floor(n * top + 0.5).astype(int) & (255 if i == 1 else 65535)
    else:
        top = 127.5 if i == 2 else 32767.5
        expected = np.floor((n + 1) * top + 0.5).astype(int)
    if i > 2:
        found = made[:, :, ::2] + 256 * made[:, :, 1::2]
    else:
        found = made[:, :, :2]
        assert (made[:, :, 2] == 0).all() and (made[:, :, 3] == INPUTS["rgba8"][0][:, :, 3]).all()
    off = (found - expected + 4) % (65536 if i > 2 else 256) - 4
    assert np.abs(off).max() <= 1 and np.count_nonzero(off) <= (2 if i < 3 else 100)


def test_check(gimp, program):
    """The numbers of `ntp check`."""
    assert "job-check-done" in gimp.messages["check"]
    words = gimp.messages["check"].split("report ")[1].split()
    command = [program, "check", "--format", "json", "--type", "standard", "rough8.png"]
    text = subprocess.run(command, cwd=gimp.work, capture_output=True, check=False).stdout
    f = json.loads(text)["files"][0]
    assert words[0] == "standard" and words[7] == f["y"]
    assert float(words[1]) > 0.7  # as told without --type
    assert int(float(words[2])) == f["unused"]
    assert [int(float(w)) for w in words[3:6]] == [
        f["fail"][v] for v in ("neighbor", "rounded", "exact")
    ]
    assert int(float(words[6])) == f["xy_too_long"]


def test_check_says_what_ntp_says(gimp, program):
    """The headline, and the findings with their levels, in their order and in the same words."""
    files = [f"{judged(name)}.png" for name in [*JUDGED, "padding"]]
    command = [program, "check", "-v", "--format", "json", *files]
    made = subprocess.run(command, cwd=gimp.work, capture_output=True, check=False).stdout
    plain = subprocess.run(
        [program, "check", *files], cwd=gimp.work, capture_output=True, check=False, text=True
    ).stdout
    wrong = []
    for file in json.loads(made)["files"]:
        name = file["path"].removesuffix(".png")
        said = gimp.messages[name].split(f"job-{name}-done")[0]
        lines = [line.strip() for line in said.splitlines()]
        expected = [
            (f["level"].replace("info", "note"), f["id"], f["message"])
            for f in file["findings"]
            if f["id"] not in OF_FILES and not f["message"].startswith("contains color info")
        ]
        found = [re.match(r"(note|warning|error) (NT\d\d\d)  (.*)", line) for line in lines]
        found = [match.groups() for match in found if match]
        headline = next(
            line.split(".png: ")[1]
            for line in plain.splitlines()
            if line.startswith(f"{name}.png:")
        )
        same = len(found) == len(expected) and all(
            a[:2] == b[:2] and (b[2] == a[2] or re.split(r": ntp |, --type", b[2])[0] == a[2])
            for a, b in zip(found, expected, strict=True)
        )
        if not same or not any(headline in line for line in lines):
            wrong.append((name, headline, lines, expected))
    assert wrong == []


def test_check_of_mirrored(gimp):
    """Where only z is negative, no blue is derived, and the report says so."""
    said = gimp.messages["check-mirrored"]
    assert "Cleaning makes negative z positive" in said and "deriving" not in said, said


@pytest.mark.parametrize("depth", [8, 16])
def test_clean(done, ntp, depth):
    pixels = rough_normals(3 if depth == 8 else 4, depth)
    assert different(done(f"clean{depth}"), ntp(pixels, "clean", "--type", "standard")) == 0


def test_clean_as_told(done, ntp):
    """Who says how blue stores z has its channels cleaned where they are."""
    pixels = pngs.read_png(TEST_FILES / "red_blue_swapped.png")[0]
    assert different(done("clean-told"), ntp(pixels, "clean", "--type", "standard")) == 0


@pytest.mark.parametrize("name", REMEDIES)
def test_remedy(done, ntp, name):
    """What a click in the report does, by the same code, is what a verb does."""
    pixels = pngs.read_png(TEST_FILES / f"{name.rsplit('-', 1)[0]}.png")[0]
    verb, *words = REMEDIES[name]
    made, expected = done(name), ntp(pixels, verb, *words)
    channels = expected.shape[2]  # a layer keeps its alpha channel
    assert different(made[:, :, :channels], expected) == 0
    assert (made[:, :, channels:] == 255).all()


@pytest.mark.parametrize("name", MISPLACED)
def test_clean_puts_channels_right(done, program, tmp_path, name):
    """As `ntp clean --undo`."""
    command = [program, "clean", "--undo", "-q", TEST_FILES / f"{name}.png", "-o"]
    subprocess.run([*command, tmp_path / "right.png"], check=True)
    expected = pngs.read_png(tmp_path / "right.png")[0]
    assert different(done(f"undone-{name}")[..., :3], expected[..., :3]) == 0


def test_clean_selection(done, ntp):
    pixels = rough_normals(3, 8)
    expected = part_of(ntp(pixels, "clean", "--type", "standard"), pixels)
    assert different(done("clean-part"), expected) == 0


def test_clean_twice(gimp):
    assert "Every texel is right already" in gimp.messages["clean-again"]


def test_height(done):
    """Slopes of the height are those of the normals, green up."""
    made, n = done("height")[:, :, 0].astype(float), rough_normals(3, 16)
    x, y, z = np.moveaxis(n[:, :, :3] / 32767.5 - 1, 2, 0)
    inner = (slice(2, -2), slice(2, -2))
    right = ((np.roll(made, -1, 1) - np.roll(made, 1, 1)) / 2)[inner].ravel()
    up = ((np.roll(made, 1, 0) - np.roll(made, -1, 0)) / 2)[inner].ravel()
    assert np.corrcoef(right, (-x / z)[inner].ravel())[0, 1] > 0.9
    assert np.corrcoef(up, (-y / z)[inner].ravel())[0, 1] > 0.9
    assert made.min() == 0 and made.max() == 65535


def test_height_as_told(gimp):
    """Who says how blue stores z gets heights of anything."""
    assert "job-height-told-done" in gimp.messages["height-told"]


def test_no_complaints(gimp):
    assert complaints(gimp.log) == []
