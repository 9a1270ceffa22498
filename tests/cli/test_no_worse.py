# SPDX-License-Identifier: MIT
"""No verb makes a test file worse: the angle to the truth does not rise, or the file is refused.

The truth is what test_files/generate.py drew: vectors in floats, before they were stored and
damaged.  Files are read here by formulas of this module.
"""

import dataclasses
import functools
import json
import pathlib
import sys

import numpy as np
import pytest
from PIL import Image

from support.libntp_ffi import ROOT
from support.pngs import read_png, write_png
from support.spawn import spawn

FILES = ROOT / "test_files"
sys.path.insert(0, str(FILES))
import generate
import shapes

ROUNDING = 0.25  # degrees, on average: half a level of 255 in each channel is 0.22 at most
LEVEL = np.degrees(2 / 255)  # that a level of 8 bit turns a flat vector by
POOR_FIT = 8  # levels
Z_IS_DERIVED = 0.8  # degrees that slopes are off where all vectors are too short or too long
TOO_SHORT_OR_LONG = ("too_short.png", "too_long.png", "resized.png")
FLAT_TILT = 0.32  # of (128, 128, 255), which a blend adds


@functools.cache
def truths():
    """{file: (true vectors, encoding)} of the files that show drawn normals."""
    n, gentle = generate.N, generate.GENTLE
    rough = shapes.normals(shapes.height(128, 192, seed=3), 40.0)
    quarter = rough[0::2, 0::2] + rough[1::2, 0::2] + rough[0::2, 1::2] + rough[1::2, 1::2]
    found = {name: (n, "standard") for name in STANDARD}
    found |= {name: (n, "zzero") for name in ("zzero.png", "zzero_16.png")}
    found |= {name: (n, "xy") for name in ("labpbr.png", "blue_255.png", "blue_0.png")}
    found |= {name: (gentle, "standard") for name in ("standard_gentle.png", "gamma.png")}
    found["one_bad_texel.png"] = shapes.unit(gentle + [0.2, 0, 0]), "standard"
    found["standard_down.png"] = n * [1, -1, 1], "standard"
    found["resized.png"] = shapes.unit(quarter), "standard"
    return found


STANDARD = [
    "standard.png",
    "standard_rounded.png",
    "standard_truncated.png",
    "standard_interlaced.png",
    "standard_16.png",
    "standard_16_rounded.png",
    "standard_16_of_8.png",
    "standard_text.png",
    "standard_alpha.png",
    "standard_unused.png",
    "padded_black.png",
    "padded_white.png",
    "z_flipped.png",
    "red_blue_swapped.png",
    "green_blue_swapped.png",
    "dxt5nm.png",
    "jpeg_damaged.png",
    "standard_z_off.png",
    "too_short.png",
    "too_long.png",
    "xy_too_long.png",
    "z_negative.png",
    "tga_24.tga",
    "tga_24_top.tga",
    "tga_24_rle_right.tga",
    "tga_32_rle.tga",
    "jpeg.jpg",
    "jpeg_progressive.jpg",
]
# What a verb may ask about, or refuse: by their accidents, or because it is not sure of them.
ACCIDENTS = [
    "z_flipped.png",
    "red_blue_swapped.png",
    "green_blue_swapped.png",
    "dxt5nm.png",
    "gamma.png",
]
DOUBTFUL = [*ACCIDENTS, "blue_255.png", "blue_0.png", "labpbr.png"]


def same(n):
    return n


# Each: the options, what becomes of the truth, and the encoding of the output (None: that of the
# input).  FLAT and FILE stand for a flat texture and the test file.
VERBS = {
    "clean": (["clean", "FILE"], same, None),
    "clean normalize": (["clean", "FILE", "--method", "normalize"], same, None),
    "clean undo": (["clean", "FILE", "--undo"], same, None),
    "convert depth": (["convert", "FILE", "--depth", "16"], same, None),
    "convert zzero": (["convert", "FILE", "--to", "zzero"], same, "zzero"),
    "convert standard": (["convert", "FILE", "--to", "standard"], same, "standard"),
    "convert y": (["convert", "FILE", "--to-y", "down"], "down", None),
    "convert xy": (["convert", "FILE", "--to", "xy"], same, "xy"),
    "flip": (["transform", "FILE", "--flip", "x"], lambda n: n[:, ::-1] * [-1, 1, 1], None),
    "turn": (
        ["transform", "FILE", "--rotate", "180"],
        lambda n: n[::-1, ::-1] * [-1, -1, 1],
        None,
    ),
    "strength": (
        ["transform", "FILE", "--strength", "0.5"],
        lambda n: shapes.unit(n * [0.5, 0.5, 1]),
        None,
    ),
    "resize": (["resize", "FILE", "--size", "100%"], same, None),
    "blend over": (["blend", "FILE", "FLAT"], same, None),
    "blend under": (["blend", "FLAT", "FILE"], same, "standard"),
}


def vectors(path, encoding):
    """Unit vectors as a shader sees them, and which texels are unused."""
    if path.suffix == ".png" and path.read_bytes()[28] == 0:  # not interlaced
        levels = read_png(path)[0]
    else:
        levels = np.asarray(Image.open(path))
    m = 65535.0 if levels.dtype == np.uint16 else 255.0
    rgb = levels[..., :3]
    unused = (rgb == 0).all(-1) | (rgb == int(m)).all(-1)
    if levels.shape[2] == 4 and encoding != "xy" and set(np.unique(levels[..., 3])) == {0, 255}:
        unused |= levels[..., 3] == 0
    v = 2 * rgb.astype(np.float64) / m - 1
    if encoding == "zzero":
        v[..., 2] = rgb[..., 2] / m
    if encoding == "xy":
        v[..., 2] = np.sqrt(np.maximum(0, 1 - v[..., 0] ** 2 - v[..., 1] ** 2))
    return v / np.linalg.norm(v, axis=-1, keepdims=True), unused


@functools.cache
def vectors_of_input(name, encoding):
    return vectors(FILES / name, encoding)


def mean_angle(path, encoding, truth, unused=None):
    v, own = vectors(path, encoding)
    used = ~(own if unused is None else unused)
    cosines = np.clip((v * truth).sum(-1)[used], -1, 1)
    return float(np.degrees(np.arccos(cosines)).mean())


IMAGES = [
    file
    for file in sorted(FILES.iterdir())
    if file.suffix in (".png", ".tga", ".jpg") and not file.name.startswith("broken")
]


@dataclasses.dataclass
class Made:
    """What a verb made of a file: its exit code, what it said, and the output where there is one."""

    code: int
    said: str
    out: pathlib.Path


CODES = {"ok": 0, "refused": 1}


def each_alone(ntp, words, flat, folder):
    """Of a verb that takes one pair of files."""
    for file in IMAGES:
        out = folder / f"{file.name}.png"
        args = [{"FILE": file, "FLAT": flat}.get(word, word) for word in words]
        done = ntp(*args, "-o", out)
        yield file.name, Made(done.returncode, done.stderr, out)


def all_at_once(ntp, words, folder):
    at = words.index("FILE")
    done = ntp(*words[:at], *IMAGES, *words[at + 1 :], "-o", folder, "--format", "json")
    for item in json.loads(done.stdout)["files"]:
        name = pathlib.Path(item["path"]).name
        assert item["written"] == (item["output"] is not None) == (item["status"] == "ok"), item
        said = [line for line in done.stderr.splitlines() if line.startswith("ntp: ")]
        said = [line for line in said if f"{name}: " in line]
        out = item["output"] or folder / f"{pathlib.Path(name).stem}.png"
        yield name, Made(CODES[item["status"]], "".join(said), pathlib.Path(out))


@pytest.fixture(scope="module")
def made(program, tmp_path_factory):
    """made(verb): {file: Made} of every test file.  Each verb runs once."""

    def ntp(*args):
        return spawn([program, *args], text=True)

    @functools.cache
    def call(verb):
        words, _, _ = VERBS[verb]
        folder = tmp_path_factory.mktemp("made")
        if words[0] != "blend":
            return dict(all_at_once(ntp, words, folder))
        write_png(folder / "flat_n.png", np.full((64, 96, 3), [128, 128, 255], np.uint8))
        return dict(each_alone(ntp, words, folder / "flat_n.png", folder))

    return call


# Both tests of a verb look at the same outputs, so one process of pytest-xdist runs them.
EACH_VERB = [
    pytest.param(verb, marks=pytest.mark.xdist_group(f"no worse: {verb}")) for verb in VERBS
]


@pytest.mark.parametrize("verb", EACH_VERB)
def test_no_verb_makes_a_file_worse(made, verb):
    _, becomes, encoding_out = VERBS[verb]
    refused = []
    for name, (truth, encoding) in truths().items():
        if verb == "blend under" and (FILES / name).suffix == ".jpg":
            continue
        one = made(verb)[name]
        if one.code == 1:
            assert not one.out.exists() and "ntp: " in one.said, (name, one)
            refused.append(name)
            continue
        assert one.code == 0, (name, one)
        _, unused = vectors(FILES / name, encoding)
        wanted = truth * ([1, 1, 1] if name == "standard_down.png" else [1, -1, 1])
        wanted = wanted if becomes == "down" else becomes(truth)
        moved = {"flip": unused[:, ::-1], "turn": unused[::-1, ::-1]}.get(verb, unused)
        # without blue: what red and green of the input say
        old = mean_angle(FILES / name, "xy" if encoding_out == "xy" else encoding, truth)
        new = mean_angle(one.out, encoding_out or encoding, wanted, moved)
        more = ROUNDING + (FLAT_TILT if "blend" in verb else 0)
        assert new <= old + more, (verb, name, old, new)
    allowed = [] if verb.startswith("clean") else DOUBTFUL
    if verb == "convert y":
        # which way green points is not sure
        allowed = [*allowed, "xy_too_long.png", "one_bad_texel.png"]
    assert set(refused) <= set(allowed), verb


def test_heights_and_back(run, tmp_path):
    """to-height, then from-height as told: as near as the fit, or a warning that none is near."""
    for name, (truth, encoding) in truths().items():
        _, unused = vectors(FILES / name, encoding)
        if unused.any():
            continue  # slopes at the rim of a hole would need heights inside it
        height, again = tmp_path / "h.png", tmp_path / "again.png"
        height.unlink(missing_ok=True)
        y = "down" if name == "standard_down.png" else "up"
        args = ["--format", "json", "--y", y]
        done = run("to-height", FILES / name, "-o", height, *args)
        if done.returncode == 1:
            assert not height.exists() and name in DOUBTFUL, done.stderr
            continue
        assert done.returncode == 0, (name, done.stderr)
        (made,) = json.loads(done.stdout)["files"]
        kernel = "central" if made["kernel"] == "baked" else made["kernel"]
        args = ["--kernel", kernel, "--scale", str(made["scale"]), "--to-y", made["y"]]
        args += ["--border-x", made["border_x"], "--border-y", made["border_y"]]
        assert run("from-height", height, "-o", again, *args).returncode == 0
        old = mean_angle(FILES / name, encoding, truth)
        new = mean_angle(again, "standard", truth, unused)
        fit = made["residual_levels"] * LEVEL * (1 / 257 if "16" in name else 1)
        if made["residual_levels"] > POOR_FIT:
            assert "warning" in done.stdout + done.stderr, name
            continue
        more = ROUNDING + 1.5 * fit + (Z_IS_DERIVED if name in TOO_SHORT_OR_LONG else 0)
        assert new <= old + more, (name, old, new, fit)


@pytest.mark.parametrize("name", ACCIDENTS)
def test_accidents_are_undone(run, tmp_path, name):
    truth, _ = truths()[name]
    out = tmp_path / "out.png"
    done = run("clean", FILES / name, "-o", out, "--format", "json")
    assert done.returncode == 0, done.stderr
    (made,) = json.loads(done.stdout)["files"]
    undone = made["undone"]
    assert undone["confidence"] >= 0.9 and made["changed"] == 6144
    assert (undone["loss_levels"] > 0) == (name == "gamma.png")
    # What was true lies within the loss that is told, and the rounding to 8 bits before it.
    new = mean_angle(out, "standard", truth)
    assert new <= undone["loss_deg_mean"] + ROUNDING
    if name != "gamma.png":
        assert np.array_equal(read_png(out)[0], read_png(FILES / "standard.png")[0])
    # --type and --force: the file as it is
    run("clean", FILES / name, "-o", out, "--type", "standard")
    assert mean_angle(out, "standard", truth) > 10 or name == "z_flipped.png"
    (check,) = json.loads(run("check", FILES / name, "--format", "json").stdout)["files"]
    assert check["confidence"] >= 0.9


LEVELS = ("info", "warning", "error")


@pytest.fixture(scope="module")
def worst(program):
    """worst(files, option...) -> {file: (the gravest level of its findings as a number, all of them,
    the type)}."""

    @functools.cache
    def call(files, *options):
        done = spawn([program, "check", *files, "--format", "json", *options], text=True)
        of = {}
        for item in json.loads(done.stdout)["files"]:
            told = [(LEVELS.index(f["level"]), f["id"]) for f in item["findings"]]
            told = [finding for finding in told if finding[1] != "NT022"]
            of[pathlib.Path(item["path"])] = max(told, default=(0, ""))[0], told, item["type"]
        assert set(of) == set(files)
        return of

    return call


@pytest.mark.parametrize("verb", EACH_VERB)
def test_check_calls_no_result_worse(worst, made, verb):
    """Of every test file.  A conversion is judged as what it was asked for; a tilt that is made
    stronger on purpose (NT022) is none of its faults."""
    options, _, encoding_out = VERBS[verb]
    told = encoding_out if options[0] == "convert" else None
    written = {}
    for file in IMAGES:
        one = made(verb)[file.name]
        assert one.code in (0, 1, 2), (file.name, one)
        if one.code == 0:
            written[file] = one.out
        else:
            assert not one.out.exists(), file.name
    of_inputs = worst(tuple(IMAGES))
    of_outputs = worst(tuple(written.values()), *(["--type", told] if told else []))
    for file, out in written.items():
        before, of_input, kind = of_inputs[file]
        if kind in ("one-color", "height"):
            continue  # not normals that anything could be wrong with
        after, of_output, _ = of_outputs[out]
        assert after <= before, (verb, file.name, of_input, of_output)
    assert len(written) >= 30
