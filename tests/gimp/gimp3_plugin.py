# SPDX-License-Identifier: MIT
"""The plug-in in GIMP 3: the same numbers as `ntp`.  `./dev gimp3` runs it."""

import json
import os
import shutil
import subprocess

import numpy as np
import pytest

from support import pngs
from support.gimps import Gimp3, is_32
from support.libntp_ffi import ROOT
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

TEST_FILES = ROOT / "test_files"
CHROOT = os.environ.get("NTP_GIMP3")
pytestmark = pytest.mark.skipif(not CHROOT, reason="NTP_GIMP3 names no chroot; use ./dev gimp3")

NORMALS = "plug-in-ntp-normals-from-height"
HEIGHT = "plug-in-ntp-height-from-normals"
CHECK = "plug-in-ntp-check-normals"
CLEAN = "plug-in-ntp-clean-normals"
RESIZE = "plug-in-ntp-resize-normals"
OTHERS = (HEIGHT, CHECK, CLEAN)
INVERT = ["gegl:invert-gamma", {}]  # an effect whose result is plain to see: the levels from above
SHADOW = ["gegl:dropshadow", {}]
TEXT = "Layer > Rasterize" if is_32(CHROOT) else "Layer > Discard Text Information"
SOBEL = SETTINGS["sobel"]
TYPES = {"U8": "u1", "U16": "u2", "U32": "u4", "HALF": "f2", "FLOAT": "f4", "DOUBLE": "f8"}
CURVES = ("LINEAR", "NON_LINEAR", "PERCEPTUAL")
PRECISIONS = [f"{kind}_{curve}" for kind in TYPES for curve in CURVES]
# The plug-in leaves whole RGB layers to the operation; that it makes the same texels itself is seen
# in a GIMP without the operation.
ALONE = {name: case for case in CASES if case[0].startswith("rgb") for name in ["-".join(case)]}
SINGLE = 7.30000019073486328125  # a number of single precision, which the operation takes for 7.3
FILTERS = ["4sample", "sobel3", "sobel5", "prewitt3", "prewitt5", "3x3", "5x5", "7x7", "9x9"]


def refused_jobs():
    """Each with a part of the reason that is given."""
    sobel = ["call", NORMALS, SOBEL]
    everywhere = {
        **{f"indexed-{p}": ("rough8", ["mode", "indexed"], "Indexed images") for p in OTHERS},
        **{f"group-{p}": ("rough8", ["group"], "layer group") for p in OTHERS},
        **{f"text-{p}": ("rough8", ["text"], TEXT) for p in (HEIGHT, CLEAN)},
    }
    if is_32(CHROOT):
        kinds = {"link": ["link", "rough16.png"], "vector": ["vector"]}
        for kind, step in kinds.items():
            for p in (NORMALS, HEIGHT, CLEAN, RESIZE):
                everywhere[f"{kind}-{p}"] = ("rough8", step, "a file or paths")
    return {
        **{
            name: (file, [step, ["call", name.split("-", 1)[1], {}]], reason)
            for name, (file, step, reason) in everywhere.items()
        },
        "indexed": ("rgb8", [["mode", "indexed"], sobel], "Indexed images"),
        "group": ("rgb8", [["group"], sobel], "layer group"),
        "mask": ("rgb8", [["mask"], [*sobel, "mask"]], "works on layers"),
        "none": ("rgb8", [[*sobel, "none"]], "Select one layer"),
        "locked": ("rgb8", [["lock"], sobel], "locked"),
        "no-alpha": ("rgb8", [["call", NORMALS, {"source": "alpha"}]], "no alpha channel"),
        "size": (
            "rgb8",
            [["other", "one.png"], ["call", NORMALS, {"height-layer": "other"}]],
            "size",
        ),
        "gray": ("gray8", [["call", "plug-in-ntp-clean-normals", {}]], "is gray"),
        "swapped": (
            "red_blue_swapped",
            [["call", CLEAN, {}]],
            "this would make it worse",
        ),
        "text": ("rgb8", [["text"], sobel], TEXT),
        "heightfield": ("rgb8-equal", [["call", HEIGHT, {}]], "looks like a heightfield"),
        "swapped-height": ("red_blue_swapped", [["call", HEIGHT, {}]], "this would make it worse"),
        "no-alpha-layer": ("rgb8", [["call", NORMALS, {"alpha": "layer"}]], "none is chosen"),
        "no-alpha-map": ("rgba8", [["call", "plug-in-normalmap", {"alpha": 6}]], "none is chosen"),
        "normals": ("rough16", [sobel], "normals already"),
        "effect": (
            "rgb16",
            [["append", "ntp:normals-from-height", SOBEL], sobel],
            "normals already",
        ),
        "other-effect": (
            "rgba8",
            [
                ["other", "rgb8.png"],
                ["append", "ntp:normals-from-height", SOBEL, "second"],
                ["call", NORMALS, {**SOBEL, "height-layer": "other"}],
            ],
            "normals already",
        ),
        "shadow": ("rgba8", [["append", *SHADOW], sobel], "reach beyond its edges"),
    }


def jobs():
    todo = {}

    def job(name, file, *steps):
        todo[name] = {"file": f"{file}.png", "steps": list(steps)}

    for file, name in CASES:
        settings = {"scale": 10, **SETTINGS[name]}
        save = ["save", f"{file}-{name}.png"]
        job(f"{file}-{name}", file, ["call", NORMALS, settings], save)
    job("single", "rgb16", ["call", NORMALS, {**SOBEL, "scale": SINGLE}], ["save", "single.png"])
    for file in PARTS:
        save = ["save", f"{file}-part.png"]
        job(f"{file}-part", file, ["select", *PART], ["call", NORMALS, SOBEL], save)
    part = [["select", *PART], ["call", NORMALS, {**SOBEL, "alpha": "height"}], ["note_profile"]]
    job("part-alpha", "rgb16-gama", *part, ["save", "part-alpha.png"])
    for alpha in ("height", "one"):
        settings = {**SOBEL, "alpha": alpha}
        job(f"alpha-{alpha}", "rgb8", ["call", NORMALS, settings], ["save", f"alpha-{alpha}.png"])
    other = {**SOBEL, "height-layer": "other"}
    job("other", "rgba8", ["other", "rgb8.png"], ["call", NORMALS, other], ["dump", "other"])
    other = {**SOBEL, "alpha": "layer", "alpha-layer": "other"}
    job("masked", "rgb8", ["other", "gray8.png"], ["call", NORMALS, other], ["dump", "masked"])
    move = [["enlarge", 400, 300, 100, 50], ["offsets", 33, -7], ["mask"]]
    job("offsets", "rgb8", *move, ["call", NORMALS, SOBEL], ["dump", "offsets"])
    light = {**SOBEL, "source": "luminance"}
    for file in ("rgb8", "rgba16-gama"):
        call, merge = ["call", NORMALS, light], ["merge", "ntp:normals-from-height", light]
        job(f"light-{file}", file, call, ["dump", f"light-{file}"])
        job(f"light-{file}-operation", file, merge, ["dump", f"light-{file}-operation"])
    job("one", "one", ["call", NORMALS, SOBEL], ["dump", "one"])
    for precision in PRECISIONS:
        steps = [["precision", precision], ["dump", f"{precision}-in"], ["call", NORMALS, SOBEL]]
        job(precision, "rgb16-gama", *steps, ["dump", f"{precision}-out"])
    for i in range(9):
        old = {"filter": i, "scale": 2.5, "wrap": i % 2}
        job(f"filter-{i}", "rgb8", ["call", "plug-in-normalmap", old], ["dump", f"filter-{i}"])
    for depth in (8, 16):
        clean = ["call", "plug-in-ntp-clean-normals", {}]
        job(f"clean{depth}", f"rough{depth}", clean, ["save", f"clean{depth}.png"])
    for name in MISPLACED:
        job(f"right-{name}", name, ["call", CLEAN, {"undo": True}], ["save", f"right-{name}.png"])
    for name, size in (("larger", (400, 300, 100, 50)), ("smaller", (60, 50, -30, -20))):
        steps = [["enlarge", *size], ["mask"], ["call", CLEAN, {"from": "standard"}]]
        job(f"canvas-{name}", "rough8", *steps, ["dump", f"canvas-{name}"])
    for name in REMEDIES:
        file, remedy = name.rsplit("-", 1)
        job(name, f"judged-{file}", ["call", CHECK, {"remedy": remedy}], ["save", f"{name}.png"])
    job("check", "rough8", ["call", "plug-in-ntp-check-normals", {}])
    height = ["call", "plug-in-ntp-height-from-normals", {}]
    job("height", "rough16", height, ["save", "height.png"])
    for name, (file, steps, _) in refused_jobs().items():
        job(name, file, *steps)
    for name, (file, steps) in effect_jobs().items():
        job(name, file, *steps)
    job("told", "rgb8-equal", ["call", HEIGHT, {"from": "standard"}])
    job("text-check", "rgb8", ["text"], ["call", CHECK, {}])
    if is_32(CHROOT):
        job("link-check", "rgb8", ["link", "rough8.png"], ["call", CHECK, {}])
        shown = ["merge", "ntp:normals-from-height", SOBEL]
        job("link-merged", "rough8", ["link", "rgb8.png"], shown, ["dump", "link-merged"])
    return todo


def effect_jobs():
    """The procedures on layers that show something else than their pixels."""
    seen = ["append", "ntp:normals-from-height", SOBEL]
    invert, note = ["append", *INVERT], ["note_filters"]
    jobs = {"seen-check": ("rgb16", [seen, ["call", CHECK, {}], note])}
    for file in ("rgb8", "rgba16", "rgb16-gama"):
        steps = [invert, ["call", NORMALS, SOBEL], note, ["dump", f"seen-{file}"]]
        jobs[f"seen-{file}"] = file, steps
    jobs["seen-part"] = (
        "rgba16",
        [
            *(["select", *PART], invert, ["call", NORMALS, SOBEL], note, ["dump", "seen-part"]),
        ],
    )
    jobs["seen-hidden"] = (
        "rgb8",
        [
            *(invert, ["hide_filters"], ["call", NORMALS, SOBEL], note, ["dump", "seen-hidden"]),
        ],
    )
    call = ["call", NORMALS, {**SOBEL, "height-layer": "other"}]
    shown = [["other", "rgb8.png"], ["append", *INVERT, "second"], call, note]
    jobs["seen-other"] = "rgba8", [*shown, ["dump", "seen-other"]]
    for depth in (8, 16):
        steps = [invert, ["call", CLEAN, {"from": "standard", "method": "derive"}], note]
        jobs[f"seen-clean{depth}"] = f"rough{depth}", [*steps, ["save", f"seen-clean{depth}.png"]]
    for name in ("rgb8", "rgba16", "rgb16-gama", "rough8", "rough16"):
        jobs[f"inverted-{name}"] = name, [["merge", *INVERT], ["dump", f"inverted-{name}"]]
    part = [["select", *PART], ["merge", *INVERT], ["dump", "inverted-part"]]
    jobs["inverted-part"] = "rgba16", part
    again = ["call", NORMALS, {**SOBEL, "force": True}]
    jobs["seen-normals"] = "rgb16", [seen, again, note, ["dump", "seen-normals"]]
    clean = ["call", CLEAN, {"from": "standard"}]
    jobs["seen-made"] = "rgb16", [seen, clean, note, ["dump", "seen-made"]]
    made = ["call", HEIGHT, {"from": "standard"}]
    for name, how in (("seen", "append"), ("merged", "merge")):
        steps = [[how, *seen[1:]], made, note, ["dump", f"{name}-relief"]]
        jobs[f"{name}-relief"] = "rgb16", steps
    # Twice inverted shows what is there: the height of these normals, not of others.
    twice = [invert, invert]
    jobs["seen-height"] = "rough16", [*twice, ["call", HEIGHT, {}], note, ["dump", "seen-height"]]
    jobs["bare-height"] = "rough16", [["call", HEIGHT, {}], note, ["dump", "bare-height"]]
    image = ["call", HEIGHT, {"result": "image", "from": "standard"}]
    for name, how in (("seen", "append"), ("merged", "merge")):
        steps = [[how, *INVERT], image, note, ["newest"], ["dump", f"{name}-image"]]
        jobs[f"{name}-image"] = "rough16", steps
    return jobs


def jobs_alone():
    todo = {}
    for name, job in jobs().items():
        if name in ALONE or name in PRECISIONS:
            *steps, (end, file) = job["steps"]
            todo[f"alone-{name}"] = {**job, "steps": [*steps, [end, f"alone-{file}"]]}
    return todo


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
