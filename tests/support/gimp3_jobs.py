# SPDX-License-Identifier: MIT
"""What the plug-in is asked in one start of GIMP 3, and in one without the operations."""

import os

from .gimps import is_32
from .libntp_ffi import ROOT
from .plugin_cases import (
    CASES,
    MISPLACED,
    PART,
    PARTS,
    REMEDIES,
    SETTINGS,
)

TEST_FILES = ROOT / "test_files"
CHROOT = os.environ.get("NTP_GIMP3")
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
