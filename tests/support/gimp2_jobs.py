# SPDX-License-Identifier: MIT
"""What the plug-in is asked in GIMP 2.10, all in one start of GIMP."""

from .gimp2 import call, normals, opened, saved, stored
from .libntp_ffi import ROOT
from .plugin_cases import (
    CASES,
    MISPLACED,
    PART,
    PARTS,
    REMEDIES,
    SETTINGS,
)

FILTERS = ["4sample", "sobel3", "sobel5", "prewitt3", "prewitt5", "3x3", "5x5", "7x7", "9x9"]
CONVERSIONS = {0: "luma-gimp", 2: "red", 3: "green", 4: "blue", 5: "max", 6: "min", 7: "screen"}
SELECT = f"(gimp-image-select-rectangle image CHANNEL-OP-REPLACE {' '.join(map(str, PART))})"
# A second layer of the image: what is in another file.
OTHER = (
    '(define other (car (gimp-file-load-layer RUN-NONINTERACTIVE image "{}")))'
    "(gimp-image-insert-layer image other 0 1)"
)
# An XCF file tells that a layer is text by a parasite; GIMP here has no fonts to write with.
TEXT = (
    '(gimp-item-attach-parasite layer (list "gimp-text-layer" 1 "(text \\"A\\")"))'
    '(gimp-xcf-save RUN-NONINTERACTIVE image layer "text.xcf" "x")'
    '(define texts (car (gimp-file-load RUN-NONINTERACTIVE "text.xcf" "x")))'
    "(define text (car (gimp-image-get-active-drawable texts)))"
)
MASK = "(gimp-layer-add-mask layer (car (gimp-layer-create-mask layer ADD-MASK-WHITE)))"
PRECISIONS = [
    f"{kind}-{curve}"
    for kind in ("U8", "U16", "U32", "HALF", "FLOAT", "DOUBLE")
    for curve in ("LINEAR", "GAMMA")
]
PRECISE = [("rgb16-gama", precision) for precision in PRECISIONS]
TEST_FILES = ROOT / "test_files"
# Findings of a file, not of its texels: a layer has none of them.
OF_FILES = {"NT011", "NT030", "NT031"}
# GIMP has other numbers of levels or refuses: palettes, 4 bits.
NOT_JUDGED = ("broken_", "height_gray4", "standard_palette")
JUDGED = sorted(
    file.stem for file in TEST_FILES.glob("*.png") if not file.stem.startswith(NOT_JUDGED)
)


def judged(name):
    """The file that is judged: a name with "zzero" would promise that."""
    return f"judged-{name.replace('zzero', 'zz')}"


def classic(**given):
    return call("plug-in-normalmap", **given)


def exact_jobs():
    jobs = {}
    for file, name in CASES:
        body = normals(**SETTINGS[name]) + saved(f"{file}-{name}.png")
        jobs[f"{file}-{name}"] = opened(f"{file}.png", body)
    for file in PARTS:
        body = SELECT + normals(**SETTINGS["sobel"]) + saved(f"{file}-part.png")
        jobs[f"{file}-part"] = opened(f"{file}.png", body)
    for alpha in ("keep", "one", "inverse", "height"):
        jobs[f"alpha-{alpha}"] = opened(
            "rgba8.png", normals(alpha=alpha) + saved(f"alpha-{alpha}.png")
        )
    jobs["adds-alpha"] = opened("gray16.png", normals(alpha="height") + saved("adds-alpha.png"))
    return jobs


def precision_jobs():
    """Gray becomes RGB on the way."""
    jobs = {}
    for file, precision in PRECISE:
        name = f"{file}-{precision}"
        convert = f"(gimp-image-convert-precision image PRECISION-{precision})"
        body = "" if precision == "U16-GAMMA" else convert
        body += stored(f"{name}-in.xcf") + normals(**SETTINGS["sobel"])
        jobs[name] = opened(f"{file}.png", body + stored(f"{name}-out.xcf"))
    return jobs


def layer_jobs():
    sobel = SETTINGS["sobel"]
    return {
        "other-height": opened(
            "rgba8.png",
            OTHER.format("rgb8.png")
            + normals(height_layer="other", **sobel)
            + saved("oh.png", "layer"),
        ),
        "other-alpha": opened(
            "rgb8.png",
            OTHER.format("rgba8.png")
            + normals(alpha="layer", alpha_layer="other", **sobel)
            + saved("oa.png", "layer"),
        ),
        "forced": opened("rough16.png", normals(force=1, **sobel) + saved("forced.png")),
        "blue-is-height": opened(
            "rough16.png", normals(source="blue", **sobel) + saved("blue-is-height.png")
        ),
        "offsets": opened(
            "rgb8.png",
            "(gimp-layer-set-offsets layer 40 -30)" + normals(**sobel) + saved("offsets.png"),
        ),
        "mask": opened(
            "rgb8.png",
            MASK
            + "(gimp-layer-set-edit-mask layer FALSE)"
            + normals(**sobel)
            + "(gimp-layer-remove-mask layer MASK-DISCARD)"
            + saved("mask.png"),
        ),
        "one": opened("one.png", normals(**sobel) + saved("one-out.png")),
    }


def refused_jobs():
    group = "(define group (car (gimp-layer-group-new image))) (gimp-image-insert-layer image group 0 0)"
    return {
        "indexed": opened(
            "rgb8.png", '(gimp-image-convert-indexed image 0 0 200 FALSE FALSE "")' + normals()
        ),
        "group": opened("rgb8.png", group + normals(layer="group")),
        "on-mask": opened("rgb8.png", MASK + normals(layer="(car (gimp-layer-get-mask layer))")),
        "no-layer": opened("rgb8.png", normals(layer="-1")),
        "locked": opened("rgb8.png", "(gimp-item-set-lock-content layer TRUE)" + normals()),
        "no-alpha": opened("rgb8.png", normals(source="alpha")),
        "other-size": opened("rgb8.png", OTHER.format("one.png") + normals(height_layer="other")),
        "min-z": opened("rgb8.png", normals(min_z=2)),
        "kernel": opened("rgb8.png", normals(kernel=77)),
        "gray-height": opened("gray8.png", call("plug-in-ntp-height-from-normals")),
        "gray-clean": opened("gray8.png", call("plug-in-ntp-clean-normals")),
        "gray-classic": opened("gray8.png", classic(conversion=8)),
        "no-alpha-layer": opened("rgb8.png", normals(alpha="layer")),
        "no-alpha-map": opened("rgba8.png", classic(alpha=6)),
        "heightfield": opened("equal.png", call("plug-in-ntp-height-from-normals")),
        "normals": opened("judged-standard.png", normals()),
        "normals-luma": opened("rough16.png", normals(source="luma")),
        "normals-zzero": opened("judged-zz.png", normals()),
        "other-normals": opened(
            "judged-height_rgb.png",
            OTHER.format("judged-standard.png") + normals(height_layer="other"),
        ),
        "text": opened("rgb8.png", TEXT + normals(layer="text")),
        "no-remedy": opened("rough8.png", call("plug-in-ntp-check-normals", remedy="undo")),
        "photograph": opened("noise.png", call("plug-in-ntp-clean-normals")),
        **{n: opened(f"{n}.png", call("plug-in-ntp-clean-normals")) for n in MISPLACED},
    }


def classic_jobs():
    jobs = {}
    for i in range(9):
        body = classic(filter=i, scale=2.5, wrap=i % 2) + saved(f"filter-{i}.png")
        jobs[f"filter-{i}"] = opened("rgb8.png", body)
    for i in CONVERSIONS:
        body = classic(conversion=i, scale=9, filter=1) + saved(f"conversion-{i}.png")
        jobs[f"conversion-{i}"] = opened("rgb16.png", body)
    for i in range(7):
        body = OTHER.format("gray8.png") + classic(alpha=i, scale=5, alphamap="other")
        jobs[f"alpha-{i}"] = opened("rgba8.png", body + saved(f"alpha-{i}.png", "layer"))
    jobs["classic-biased"] = opened(
        "rgb16.png", classic(conversion=1, scale=9, filter=1) + saved("cb.png")
    )
    jobs["classic-xy"] = opened("rough8.png", classic(conversion=9) + saved("cx.png"))
    jobs["classic-alpha"] = opened(
        "rgba8.png", classic(height_source=1, scale=8, alpha=2, yinvert=1) + saved("ca.png")
    )
    jobs["classic-normalize"] = opened(
        "rough8.png",
        classic(conversion=8) + saved("cn.png") + classic(conversion=8) + saved("cn2.png"),
    )
    jobs["classic-height"] = opened(
        "rough8.png", classic(conversion=10, yinvert=1) + saved("ch.png")
    )
    for i in (1, 2, 3, 4):
        body = classic(dudv=i, scale=8) + saved(f"dudv-{i}.png")
        jobs[f"dudv-{i}"] = opened("rgba8.png", body)
    return jobs


def normals_jobs():
    tell = " ".join(f'(number->string (nth {i} values)) " "' for i in (1, 3, 4, 5, 6, 7))
    check = f"""(let* ((values {call("plug-in-ntp-check-normals")}))
        (gimp-message (string-append "report " (car values) " " {tell} (nth 11 values))))"""
    mirrored = f"""(let* ((values {call("plug-in-ntp-check-normals")}))
        (gimp-message (car (reverse values))))"""
    reports = {judged(n): opened(f"{judged(n)}.png", mirrored) for n in [*JUDGED, "padding"]}
    clean = call("plug-in-ntp-clean-normals")
    told = call("plug-in-ntp-clean-normals", **{"from": 1})
    undo = call("plug-in-ntp-clean-normals", undo=1)
    return {
        "check": opened("rough8.png", check),
        "check-mirrored": opened("mirrored.png", mirrored),
        **reports,
        "clean8": opened("rough8.png", clean + saved("clean8.png")),
        "clean16": opened("rough16.png", clean + saved("clean16.png")),
        "clean-part": opened("rough8.png", SELECT + clean + saved("clean-part.png")),
        "clean-again": opened("rough8.png", clean + clean),
        **{f"undone-{n}": opened(f"{n}.png", undo + saved(f"undone-{n}.png")) for n in MISPLACED},
        "clean-told": opened("red_blue_swapped.png", told + saved("clean-told.png")),
        "height-told": opened(
            "equal.png", call("plug-in-ntp-height-from-normals", **{"from": "standard"})
        ),
        "height": opened(
            "rough16.png", call("plug-in-ntp-height-from-normals") + saved("height.png")
        ),
    }


def remedy_jobs():
    jobs = {}
    for name in REMEDIES:
        file, remedy = name.rsplit("-", 1)
        body = call("plug-in-ntp-check-normals", remedy=remedy) + saved(f"{name}.png")
        jobs[name] = opened(f"{judged(file)}.png", body)
    return jobs


# The settings of Resize Normals, and the options of `ntp resize` that they are.
RESIZED = {
    "half": ({}, ["--size", "50%"]),
    "told": ({"width": 200, "height": 61, "filter": "lanczos3", "border-y": "mirror"},
             ["--size", "200x61", "--filter", "lanczos3", "--border-y", "mirror"]),
    "box": ({"percent": 33.3, "filter": "box", "border-x": "clamp"},
            ["--size", "33.3%", "--filter", "box", "--border-x", "clamp"]),
}  # fmt: skip
ROUGH = ["rough8", "rough16", "rough8-gama"]


def resize(**given):
    return call("plug-in-ntp-resize-normals", **given)


def resize_jobs():
    jobs = {}
    for file in ROUGH:
        for name, (settings, _) in RESIZED.items():
            body = SELECT + resize(**settings) + saved(f"{file}-{name}.png")
            jobs[f"{file}-{name}"] = opened(f"{file}.png", body)
    size = '(gimp-message (string-append "size "'
    for what in ("(gimp-image-width image)", "(gimp-image-height image)",
                 "(gimp-drawable-width layer)", "(gimp-drawable-height layer)",
                 "(gimp-drawable-offsets layer)", "(cdr (gimp-drawable-offsets layer))"):  # fmt: skip
        size += f' (number->string (car {what})) " "'
    size += "))"
    jobs["resize-layer"] = opened(
        "rough8.png",
        "(gimp-layer-set-offsets layer 7 -3)"
        + resize(scope="layer") + size + saved("resize-layer.png", "layer"),
    )  # fmt: skip
    jobs["resize-image"] = opened(
        "rough8.png",
        OTHER.format("rough16.png")
        + "(gimp-layer-set-offsets other 20 10)"
        + MASK
        + resize()
        + size
        + saved("resize-below.png", "layer")
        + saved("resize-above.png", "other"),
    )
    return jobs
