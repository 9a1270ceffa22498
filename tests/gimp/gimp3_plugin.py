# SPDX-License-Identifier: MIT
"""The plug-in in GIMP 3: the same numbers as `ntp`.  `./dev gimp3` runs it."""

import json
import os
import shutil
import subprocess

import numpy as np
import pytest

from support import pngs
from support.gimp3_jobs import (
    ALONE,
    CHROOT,
    FILTERS,
    PRECISIONS,
    SINGLE,
    SOBEL,
    TEST_FILES,
    TYPES,
    jobs,
    jobs_alone,
    refused_jobs,
)
from support.gimps import Gimp3, is_32
from support.plugin_cases import (
    CASES,
    INPUTS,
    MISPLACED,
    PART,
    PARTS,
    REMEDIES,
    SETTINGS,
    assert_normals_of,
    different,
    options,
    part_of,
    picture,
    rough_normals,
)

pytestmark = pytest.mark.skipif(not CHROOT, reason="NTP_GIMP3 names no chroot; use ./dev gimp3")


@pytest.fixture(scope="module")
def gimp():
    made = Gimp3(CHROOT, "plugin")
    for name, (pixels, chunks) in INPUTS.items():
        pngs.write_png(made.work / f"{name}.png", pixels, chunks=chunks)
    pngs.write_png(made.work / "one.png", picture(3, 8, 1, 1))
    equal = np.repeat(INPUTS["rgb8"][0][:, :, :1], 3, 2)
    pngs.write_png(made.work / "rgb8-equal.png", equal)
    pngs.write_png(made.work / "rough8.png", rough_normals(3, 8))
    pngs.write_png(made.work / "rough16.png", rough_normals(4, 16))
    for name in MISPLACED:
        shutil.copy(TEST_FILES / f"{name}.png", made.work)
    for name in REMEDIES:
        file = name.rsplit("-", 1)[0]
        shutil.copy(TEST_FILES / f"{file}.png", made.work / f"judged-{file}.png")
    made.results, made.complaints = made.run(jobs())
    alone, complaints = made.run(jobs_alone(), GEGL_PATH=made.without_our_operations())
    made.results.update(alone)
    made.complaints += complaints
    return made


@pytest.fixture
def done(gimp):
    """done(job) -> the pixels of the PNG that the job saved."""

    def look(job):
        result = gimp.results[job]
        assert result["error"] is None and "refused" not in result, result
        return pngs.read_png(gimp.work / f"{job}.png")[0]

    return look


@pytest.fixture
def raw(gimp):
    """raw(job, file, dtype) -> what the job dumped."""

    def look(job, file=None, dtype=np.uint8):
        result = gimp.results[job]
        assert result["error"] is None and "refused" not in result, result
        height, width, size = result["shape"]
        data = np.fromfile(gimp.work / (file or job), dtype)
        return data.reshape(height, width, size // np.dtype(dtype).itemsize)

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


@pytest.mark.parametrize("name", ALONE)
def test_without_the_operation(done, ntp, name):
    file, settings = ALONE[name]
    words = ["--scale", "10", *options(SETTINGS[settings])]
    assert different(done(f"alone-{name}"), ntp(INPUTS[file][0], "from-height", *words)) == 0


def test_number_of_single_precision(done, ntp):
    """It is not rounded on the way to the operation."""
    expected = ntp(INPUTS["rgb16"][0], "from-height", *options({**SOBEL, "scale": SINGLE}))
    assert different(done("single"), expected) == 0
    assert different(done("rgb16-sobel"), expected) > 0


@pytest.mark.parametrize("file", PARTS)
def test_selection(done, ntp, file):
    """Inside, the texels of the whole picture; outside, those that were there."""
    pixels = INPUTS[file][0]
    whole = ntp(pixels, "from-height", *options(SOBEL))
    made, expected = done(f"{file}-part"), part_of(whole, pixels)
    x, y, w, h = PART
    inside = (slice(y, y + h), slice(x, x + w))
    assert different(made[inside], expected[inside]) == 0
    if pixels.shape[2] > 2:  # gray outside is converted by GIMP
        assert different(made, expected) == 0


def test_alpha_in_selection(gimp, done, ntp):
    """The channel is opaque beside it, no other sample changes, and the image keeps its profile."""
    pixels = INPUTS["rgb16-gama"][0]
    opaque = np.dstack([pixels, np.full(pixels.shape[:2], 65535, np.uint16)])
    whole = ntp(pixels, "from-height", *options(SOBEL), "--alpha", "height")
    assert different(done("part-alpha"), part_of(whole, opaque)) == 0
    assert "gAMA" in gimp.results["part-alpha"]["profile"]


@pytest.mark.parametrize("alpha", ["height", "one"])
def test_alpha(done, ntp, alpha):
    """The channel is added."""
    expected = ntp(INPUTS["rgb8"][0], "from-height", *options(SOBEL), "--alpha", alpha)
    assert different(done(f"alpha-{alpha}"), expected) == 0


def test_layers(raw, ntp):
    """Another layer's height or brightness; offsets and a layer mask change nothing."""
    expected = ntp(INPUTS["rgb8"][0], "from-height", *options(SOBEL))
    made = raw("other")
    assert different(made[:, :, :3], expected) == 0
    assert (made[:, :, 3] == INPUTS["rgba8"][0][:, :, 3]).all()
    made = raw("masked")
    assert different(made[:, :, :3], expected) == 0
    assert (made[:, :, 3] == INPUTS["gray8"][0][:, :, 0]).all()
    assert different(raw("offsets"), expected) == 0
    assert raw("one").tolist() == [[[128, 128, 255]]]


@pytest.mark.parametrize("file", ["rgb8", "rgba16-gama"])
def test_luminance(raw, ntp, file):
    """The plug-in reads it as the operation does, of which test_gegl.py knows that it is GIMP's."""
    pixels = INPUTS[file][0]
    made, same = (raw(f"light-{file}{end}", dtype=pixels.dtype) for end in ("", "-operation"))
    assert different(made, same) == 0
    assert different(made, ntp(pixels, "from-height", *options({**SOBEL, "source": "luma"}))) > 0


@pytest.mark.parametrize("precision", PRECISIONS)
def test_precision(raw, precision):
    dtype = np.dtype(TYPES[precision.split("_")[0]])
    heights = raw(precision, f"{precision}-in", dtype)
    # babl times its conversions when it starts.  On a busy machine those of floats, through which the
    # operation's result goes, are not always the exact ones.
    inexact = ["FLOAT_LINEAR", "FLOAT_PERCEPTUAL"]
    float_error = 2.0**-21 if precision in inexact else 0
    for job in (precision, f"alone-{precision}"):
        assert_normals_of(heights, raw(job, f"{job}-out", dtype), float_error)


@pytest.mark.parametrize("i", range(9))
def test_old_filters(raw, ntp, i):
    like = ["--like", f"gimp-normalmap:{FILTERS[i]}:2.5", "--border", "wrap" if i % 2 else "clamp"]
    assert different(raw(f"filter-{i}"), ntp(INPUTS["rgb8"][0], "from-height", *like)) == 0


@pytest.mark.parametrize("depth", [8, 16])
def test_clean(done, ntp, depth):
    pixels = rough_normals(3 if depth == 8 else 4, depth)
    assert different(done(f"clean{depth}"), ntp(pixels, "clean", "--type", "standard")) == 0


def test_check(gimp, program):
    """The numbers of `ntp check`."""
    values = gimp.results["check"]["values"]
    command = [program, "check", "--format", "json", "--type", "standard", "rough8.png"]
    text = subprocess.run(command, cwd=gimp.work, capture_output=True, check=False).stdout
    f = json.loads(text)["files"][0]
    fail = [f["fail"][v] for v in ("neighbor", "rounded", "exact")]
    assert values[0] == "standard" and values[2] == f["texels"] and values[3] == f["unused"]
    assert values[4:7] == fail and values[7] == f["xy_too_long"] and values[11] == f["y"]


@pytest.mark.parametrize("name", REMEDIES)
def test_remedy(done, ntp, name):
    """What a click in the report does, by the same code, is what a verb does."""
    pixels = pngs.read_png(TEST_FILES / f"{name.rsplit('-', 1)[0]}.png")[0]
    verb, *words = REMEDIES[name]
    made, expected = done(name), ntp(pixels, verb, *words)
    channels = expected.shape[2]  # a layer keeps its alpha channel
    assert different(made[:, :, :channels], expected) == 0
    assert (made[:, :, channels:] == 255).all()


def test_height(done):
    """Slopes of the height are those of the normals, green up."""
    made, n = done("height")[:, :, 0].astype(float), rough_normals(3, 16)
    x, y, z = np.moveaxis(n[:, :, :3] / 32767.5 - 1, 2, 0)
    inner = (slice(2, -2), slice(2, -2))
    right = ((np.roll(made, -1, 1) - np.roll(made, 1, 1)) / 2)[inner].ravel()
    up = ((np.roll(made, 1, 0) - np.roll(made, -1, 0)) / 2)[inner].ravel()
    assert np.corrcoef(right, (-x / z)[inner].ravel())[0, 1] > 0.9
    assert np.corrcoef(up, (-y / z)[inner].ravel())[0, 1] > 0.9


@pytest.mark.parametrize("job", refused_jobs())
def test_refused(gimp, job):
    """With a sentence that says why."""
    result = gimp.results[job]
    assert result["error"] is None
    assert refused_jobs()[job][2] in result["refused"]
    assert result["status"] == "execution-error"


def test_told(gimp):
    """Who says how blue stores z gets heights of anything; reading a text layer harms nothing."""
    for job in ("told", "text-check"):
        assert gimp.results[job]["error"] is None and "refused" not in gimp.results[job]


@pytest.mark.skipif(not is_32(CHROOT), reason="GIMP 3.0 has no link layers")
def test_link_layers(gimp, raw, ntp):
    """They are checked as they are shown, and an operation takes what they show."""
    values = gimp.results["link-check"]["values"]
    assert values[0] == "standard" and values[2:8] == gimp.results["check"]["values"][2:8]
    made, expected = raw("link-merged"), ntp(INPUTS["rgb8"][0], "from-height", *options(SOBEL))
    assert different(made[..., :3], expected) == 0


def test_effects_checked(gimp):
    """Normals as an effect are what is seen, not the heights below; the effect stays."""
    result = gimp.results["seen-check"]
    assert result["error"] is None and result["values"][0] == "standard"
    assert "with its effects" in result["values"][-1] and result["filters"] == 1


@pytest.mark.parametrize("file", ["rgb8", "rgba16", "rgb16-gama"])
def test_effects_are_the_height(gimp, raw, ntp, file):
    """GIMP's own effect, and the result takes its place."""
    dtype = INPUTS[file][0].dtype
    shown = raw(f"inverted-{file}", dtype=dtype)
    assert different(shown, INPUTS[file][0]) > 0
    expected = ntp(shown, "from-height", *options(SOBEL))
    assert different(raw(f"seen-{file}", dtype=dtype), expected) == 0
    assert gimp.results[f"seen-{file}"]["filters"] == 0


def test_effects_in_selection(raw, ntp):
    """Beside the selection the layer becomes what it showed."""
    shown = raw("inverted-part", dtype=np.uint16)
    expected = part_of(ntp(shown, "from-height", *options(SOBEL)), shown)
    assert different(raw("seen-part", dtype=np.uint16), expected) == 0


def test_hidden_effects(gimp, raw, ntp):
    """Nobody sees them; they stay as they are."""
    expected = ntp(INPUTS["rgb8"][0], "from-height", *options(SOBEL))
    assert different(raw("seen-hidden"), expected) == 0
    assert gimp.results["seen-hidden"]["filters"] == 1


def test_effects_of_the_other_layer(raw, ntp):
    expected = ntp(raw("inverted-rgb8"), "from-height", *options(SOBEL))
    assert different(raw("seen-other")[:, :, :3], expected) == 0


@pytest.mark.parametrize("depth", [8, 16])
def test_effects_cleaned(gimp, done, raw, ntp, depth):
    shown = raw(f"inverted-rough{depth}", dtype=f"u{depth // 8}")
    words = ["--type", "standard", "--method", "derive"]
    assert different(done(f"seen-clean{depth}"), ntp(shown, "clean", *words)) == 0
    assert gimp.results[f"seen-clean{depth}"]["filters"] == 0


def test_effects_to_height(gimp, raw):
    """In the layer; and in a new image, where the effect stays."""
    assert different(raw("seen-height", dtype=np.uint16), raw("bare-height", dtype=np.uint16)) == 0
    made, turned = raw("seen-image", dtype=np.uint16), raw("merged-image", dtype=np.uint16)
    assert different(made, turned) == 0 and np.ptp(made) == 65535
    assert gimp.results["seen-image"]["filters"] == 1
    assert gimp.results["seen-height"]["filters"] == 0


def test_our_effect_is_seen(gimp, raw, ntp):
    """After Normals from Height as an effect each takes the normals, not the heights below.

    Making normals of them takes a word more: see refused_jobs."""
    words = options(SOBEL)
    shown = ntp(INPUTS["rgb16"][0], "from-height", *words)
    again = ntp(shown, "from-height", "--force", *words)
    assert different(raw("seen-normals", dtype=np.uint16), again) == 0
    # These normals have no error: Clean leaves the effect, and the heights below it.
    assert different(ntp(shown, "clean", "--type", "standard"), shown) == 0
    assert different(raw("seen-made", dtype=np.uint16), INPUTS["rgb16"][0]) == 0
    assert gimp.results["seen-made"]["filters"] == 1
    relief = [raw(f"{how}-relief", dtype=np.uint16) for how in ("seen", "merged")]
    assert different(*relief) == 0 and np.ptp(relief[0]) == 65535
    for job in ("seen-normals", "seen-relief"):
        assert gimp.results[job]["filters"] == 0


@pytest.mark.parametrize("name", MISPLACED)
def test_clean_puts_channels_right(done, program, tmp_path, name):
    """As `ntp clean --undo`."""
    command = [program, "clean", "--undo", "-q", TEST_FILES / f"{name}.png", "-o"]
    subprocess.run([*command, tmp_path / "right.png"], check=True)
    expected = pngs.read_png(tmp_path / "right.png")[0]
    assert different(done(f"right-{name}")[..., :3], expected[..., :3]) == 0


@pytest.mark.parametrize("name", ["larger", "smaller"])
def test_canvas_of_another_size(raw, ntp, name):
    """The whole layer is cleaned, not what the canvas shows of it; a mask changes nothing."""
    expected = ntp(rough_normals(3, 8), "clean", "--type", "standard")
    assert different(raw(f"canvas-{name}"), expected) == 0


def test_uninstall_leaves_nothing(gimp):
    """Of an installation into a new directory."""
    place = gimp.work / "place"
    script = f"""meson install -C /build --no-rebuild --tags gimp,i18n --destdir {gimp.inside}/place
        test -n "$(find {gimp.inside}/place -type f)"
        ninja -C /build uninstall"""
    command = ["chroot", gimp.chroot, "env", "-i", "PATH=/usr/bin:/bin", "LANG=C.UTF-8"]
    root = [] if os.geteuid() == 0 else ["sudo", "-n"]
    subprocess.run([*root, *command, "sh", "-ec", script], check=True, capture_output=True)
    assert not [path for path in place.rglob("*") if path.name.startswith(("ntp", "libntp"))]


def test_no_complaints(gimp):
    assert gimp.complaints == []
