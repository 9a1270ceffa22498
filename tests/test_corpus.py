# SPDX-License-Identifier: MIT
"""Real textures: manifest.csv's figures, found by others, are reproduced by library and program.

frac_fail_pm1 is the reference program's test: `neighbor` and |(x, y)| <= 1.00774.  The manifest
takes blue against the derived blue without mirroring, and 128 where x, y are too long.

corpus_labels.csv says what each is: by facts (the manifest, the publisher), by numbers (how blue goes
with the z of red and green, found by numpy alone), by eye.  Where in doubt it names a second class.
"""

import csv
import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from support import libntp_ffi as ntp
from support import pngs

CORPUS = Path(os.environ.get("NTP_CORPUS", ntp.ROOT.parent / "shared" / "corpus"))


def rows(formats, kinds=("normals",)):
    """The manifest's rows; one of None where there is no corpus, so that a test says so."""
    if not (CORPUS / "manifest.csv").exists():
        return [None]
    with open(CORPUS / "manifest.csv", newline="", encoding="utf-8") as file:
        found = list(csv.DictReader(file))
    return [r for r in found if r["format"] in formats and r["kind"].startswith(kinds)]


def name_of(row):
    return row["file"] if row else "none"


def pixels(row):
    """The raw samples of a PNG, TGA or JPEG."""
    path = CORPUS / row["file"]
    if row["bit_depth"] == "16":
        return pngs.read_png(path)[0]
    Image.MAX_IMAGE_PIXELS = None
    with Image.open(path) as image:
        if image.mode == "P":
            image = image.convert("RGBA" if "transparency" in image.info else "RGB")
        return np.array(image)


@pytest.mark.parametrize("row", rows(("PNG", "TGA")), ids=name_of)
def test_library(corpus, row):
    array = pixels(row)
    m = np.iinfo(array.dtype).max
    stats = ntp.Tally().measure(array).stats()
    n = stats["texels"]
    cleaned = ntp.clean(array, how=ntp.clean_options(touch_unused=7))[0].astype(int)
    over = ntp.validate(array) & ntp.XY_TOO_LONG > 0
    blue = np.where(over, (m + 1) // 2, cleaned[..., 2])
    off = np.abs(array[..., 2].astype(int) - blue)
    got = {
        "frac_fail_pm1": 1 - stats["neighbor_and_near"] / n,
        "frac_blue_off_gt1": np.mean(off > 1),
        "frac_blue_off_gt2": np.mean(off > 2),
        "frac_xy_gt1": stats["xy_too_long"] / n,
        "frac_z_neg": stats["z_negative"] / n,
        "blue_maxdiff": off.max(),
        "len_min": stats["standard"]["length_min"],
        "len_mean": stats["standard"]["length_mean"],
        "len_max": stats["standard"]["length_max"],
    }
    scale = 255 / stats["max"]
    for k, channel in enumerate("rgb"):
        got["mean_" + channel] = stats["channel"][k]["mean"] * scale
    if row["alpha_min"]:
        got["alpha_min"] = stats["channel"][3]["min"]
        got["alpha_max"] = stats["channel"][3]["max"]
    for field, value in got.items():
        assert float(value) == pytest.approx(float(row[field]), abs=1.2e-5), field
    ends = [(c["min"], c["max"]) for c in stats["channel"]]
    assert (row["one_colour"] == "True") == all(low == high for low, high in ends[:3])


def check(run, path, *options):
    done = run("check", "--format", "json", *options, path)
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout)["files"][0]


@pytest.mark.parametrize("row", rows(("PNG", "TGA", "JPEG")), ids=name_of)
def test_program(run, corpus, row):
    file = check(run, CORPUS / row["file"], "--type", "standard")
    assert (file["width"], file["height"]) == (int(row["width"]), int(row["height"]))
    n = file["texels"]
    assert n == file["width"] * file["height"]
    near = 0.01 if row["format"] == "JPEG" else 1e-6  # decoders may differ by a level
    assert file["xy_too_long"] / n == pytest.approx(float(row["frac_xy_gt1"]), abs=near)
    assert file["z_negative"] / n == pytest.approx(float(row["frac_z_neg"]), abs=near)
    failing = file["fail"]["neighbor"] / n
    if float(row["frac_xy_gt1"]) == 0:
        assert failing == pytest.approx(float(row["frac_fail_pm1"]), abs=near)
    else:  # the reference program fails some more: those beyond its limit on x, y
        assert failing <= float(row["frac_fail_pm1"]) + near
    assert file["slope_step_deg"] is None  # none is known to be banded
    if row["format"] != "JPEG":
        assert file["length"]["mean"] == pytest.approx(float(row["len_mean"]), abs=1.1e-3)


@pytest.mark.parametrize("row", rows(("PNG",), ("height",)), ids=name_of)
def test_heights(corpus, row):
    array = pixels(row)
    stats = ntp.Tally().measure(array, ntp.HEIGHT).stats()
    assert stats["channel"][0]["min"] == float(row["val_min"])
    assert stats["channel"][0]["max"] == float(row["val_max"])
    assert stats["gray"] == stats["texels"] == int(row["width"]) * int(row["height"])


CLASSES = ["standard", "zzero", "xy", "height", "object-space", "one-color", "not-normals"]
LABELS = Path(__file__).resolve().parent / "corpus_labels.csv"


def labels():
    """{file: classes that are right}"""
    with open(LABELS, newline="", encoding="utf-8") as file:
        found = list(csv.DictReader(file))
    assert all(row["judged_by"] in ("facts", "numbers", "eye") for row in found)
    return {row["file"]: {row["class"], row["or"]} - {""} for row in found}


def classify(array):
    """(class, confidence)"""
    gray = array.ndim == 2 or array.shape[2] < 3
    result = ntp.classify(np.ascontiguousarray(array), ntp.HEIGHT if gray else ntp.STANDARD)
    return CLASSES[result.type], result.confidence


def test_every_texture_has_a_label(corpus):
    drawn = {row["file"] for row in rows(("PNG", "TGA", "JPEG"), ("normals", "height"))}
    assert set(labels()) == drawn
    assert all(right <= set(CLASSES) for right in labels().values())


@pytest.mark.parametrize("row", rows(("PNG", "TGA", "JPEG"), ("normals", "height")), ids=name_of)
def test_labels(corpus, row):
    called, confidence = classify(pixels(row))
    assert called in labels()[row["file"]], confidence


@pytest.mark.parametrize(
    "path", sorted((ntp.ROOT / "docs" / "images").glob("*.png")), ids=lambda p: p.name
)
def test_pictures_of_the_documentation_are_no_normals(path):
    """Real pictures: windows, some of which show a normals texture among other things.

    compression.png is a texture and its heatmaps, so it may pass for a texture with padding.
    """
    with Image.open(path) as image:
        called, _ = classify(np.array(image.convert("RGB")))
    right = {"not-normals", "standard"} if path.name == "compression.png" else {"not-normals"}
    assert called in right
