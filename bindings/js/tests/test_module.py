# SPDX-License-Identifier: MIT
"""The WebAssembly module gives the bytes of `ntp`, and its numbers.

`ntp` runs natively, on vectors of this machine; the module has vectors of its own and the C library
of WASI.  Both read the same samples: those that Pillow, or the reader of the tests, finds in a file.
"""

import itertools
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests"))

from support import libntp_ffi as native
from support.pngs import read_png, write_png

TEXTURES = ROOT / "test_files"
NTP = native.BUILD / "cli" / "ntp"
OPTIONS_FROM_HEIGHT = ["--scale", "9.7", "--kernel", "sobel5", "--border-y", "mirror"]
HOW_FROM_HEIGHT = {"scale": 9.7, "kernel": "sobel5", "borderY": "mirror"}


def ntp(*args):
    done = subprocess.run([NTP, *map(str, args)], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


class Jobs:
    """Calls that one process of node runs."""

    def __init__(self, folder):
        self.folder, self.list, self.pictures = folder, [], itertools.count()

    def picture(self, array):
        file = self.folder / f"in{next(self.pictures)}.raw"
        array = np.ascontiguousarray(array if array.ndim == 3 else array[..., None])
        file.write_bytes(array.tobytes())
        height, width, channels = array.shape
        form = {"width": width, "height": height, "channels": channels}
        return {"file": str(file), "kind": array.dtype.name, **form}

    def add(self, call, array, how=None, **more):
        out = self.folder / f"out{len(self.list)}.raw"
        job = {"call": call, "picture": self.picture(array), "how": how, "out": str(out)}
        if "detail" in more:
            more["detail"] = self.picture(more["detail"])
        self.list.append(job | more)
        return len(self.list) - 1

    def run(self):
        file = self.folder / "jobs.json"
        file.write_text(json.dumps(self.list))
        script = Path(__file__).with_name("run_jobs.mjs")
        done = subprocess.run(["node", script, file], capture_output=True, check=False)
        assert done.returncode == 0, done.stderr.decode()
        results = json.loads(done.stdout)
        for result, job in zip(results, self.list, strict=True):
            if result.get("kind"):
                kind = {"Uint8Array": "u1", "Uint16Array": "u2", "Float32Array": "f4"}
                data = np.fromfile(job["out"], kind[result["kind"]])
                form = result if "width" in result else job["picture"]
                result["data"] = data.reshape(form["height"], form["width"], -1)
        return results


def read_pfm(path):
    kind, size, scale, data = path.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    assert kind == b"Pf" and float(scale) < 0
    return np.frombuffer(data, "<f4").reshape(height, width)[::-1]


@pytest.fixture(scope="module")
def textures():
    """Names and samples of all textures that can be read as they are."""
    found = {}
    for path in sorted(TEXTURES.glob("*.png")):
        if not path.name.startswith("broken") and path.stem not in (
            "height_gray4",
            "standard_interlaced",
            "standard_palette",
        ):
            found[path.name] = read_png(path)[0]
    assert len(found) > 35
    return found


@pytest.fixture(scope="module")
def checked(textures, tmp_path_factory):
    jobs = Jobs(tmp_path_factory.mktemp("check"))
    for pixels in textures.values():
        jobs.add("check", pixels)
    return dict(zip(textures, jobs.run(), strict=True))


@pytest.fixture(scope="module")
def said():
    """What `ntp check` says."""
    _, out, _ = ntp("check", "--format", "json", "--fail-on", "never", "-r", TEXTURES)
    return {Path(one["path"]).name: one for one in json.loads(out)["files"]}


def test_version():
    header = (ROOT / "libntp/include/libntp.h").read_text()
    parts = [
        header.split(f"NTP_VERSION_{part} ")[1].split()[0] for part in ("MAJOR", "MINOR", "PATCH")
    ]
    script = (
        "import('./bindings/js/index.js').then(m => m.load()).then(n => console.log(n.version))"
    )
    done = subprocess.run(
        ["node", "-e", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == ".".join(parts)
    package = json.loads((ROOT / "bindings/js/package.json").read_text())
    assert package["version"] == ".".join(parts)


def test_check_says_what_ntp_says(checked, said):
    compared = 0
    for name, mine in checked.items():
        theirs = said[name]
        assert (mine["type"], mine["confidence"]) == (theirs["type"], theirs["confidence"]), name
        assert mine["reasons"] == theirs["reasons"], name
        assert (mine["texels"], mine["unused"]) == (theirs["texels"], theirs["unused"]), name
        if theirs["type"] not in ("standard", "zzero", "xy") or not theirs["counts"]:
            continue
        used = theirs.get("used", theirs)
        assert mine["fail"] == used["fail"], name
        assert mine["xyTooLong"] == used["xy_too_long"], name
        assert mine["zNegative"] == used["z_negative"], name
        if theirs["length"] is None:  # of two channels
            continue
        assert mine["length"] == pytest.approx(theirs["length"], rel=1e-14), name
        for part, value in theirs["angle_deg"].items():
            assert mine["angle"][part] == pytest.approx(value, abs=0.0006), name
        if theirs["y_confidence"]:
            assert mine["green"]["y"] == theirs["y"], name
        compared += 1
    assert compared > 20


def outputs(folder, verb, options):
    """What `ntp` makes of the textures, one process for all."""
    ntp(verb, "-r", TEXTURES, "-o", folder, "-q", *options)
    return {path.name: path for path in folder.iterdir()}


@pytest.mark.parametrize("method", ["auto", "derive", "normalize"])
def test_clean_gives_the_same_bytes(method, textures, tmp_path):
    made = outputs(tmp_path, "clean", ["--method", method])
    jobs = Jobs(tmp_path)
    for pixels in textures.values():
        jobs.add("clean", pixels, {"method": method})
    written = 0
    for name, result in zip(textures, jobs.run(), strict=True):
        # Heights and photographs are refused by both, and accidents that are not sure.
        assert ("error" in result) == (name not in made), (name, result)
        if name in made:
            assert np.array_equal(result["data"], read_png(made[name])[0]), name
            written += 1
    assert written > 25


def test_normals_from_height_give_the_same_bytes(textures, tmp_path):
    made = outputs(tmp_path, "from-height", [*OPTIONS_FROM_HEIGHT, "--force"])
    jobs = Jobs(tmp_path)
    names = [
        name for name in textures if name in made and name.startswith(("height", "photo", "lab"))
    ]
    assert len(names) >= 4
    for name in names:
        jobs.add("normalsFromHeight", textures[name], HOW_FROM_HEIGHT)
    for name, result in zip(names, jobs.run(), strict=True):
        assert np.array_equal(result["data"], read_png(made[name])[0]), name


def test_dithered_normals_give_the_same_bytes(textures, tmp_path):
    out = tmp_path / "out.png"
    name = "height_gray8.png"
    ntp("from-height", TEXTURES / name, "-o", out, "--scale", 5, "--dither", "integrable")
    jobs = Jobs(tmp_path)
    jobs.add("normalsFromHeight", textures[name], {"scale": 5, "dither": True})
    assert np.array_equal(jobs.run()[0]["data"], read_png(out)[0])


@pytest.mark.parametrize(
    ("options", "how"),
    [
        ([], {}),
        (
            ["--kernel", "sobel3", "--border", "clamp", "--from-y", "up"],
            {"kernel": "sobel3", "border": "clamp", "y": "up"},
        ),
        (
            ["--kernel", "central", "--border", "wrap", "--from-y", "up", "--refine", "4"],
            {"kernel": "central", "border": "wrap", "y": "up", "refine": 4},
        ),
    ],
)
def test_heights_from_normals_give_the_same_bytes(options, how, textures, tmp_path):
    names = [
        "standard.png",
        "standard_16.png",
        "standard_z_off.png",
        "zzero.png",
        "jpeg_damaged.png",
    ]
    jobs = Jobs(tmp_path)
    compared = 0
    for name in names:
        jobs.add("heightFromNormals", textures[name], how)
    for name, result in zip(names, jobs.run(), strict=True):
        out = tmp_path / f"{Path(name).stem}.pfm"
        code, _, message = ntp("to-height", TEXTURES / name, "-o", out, "-q", *options)
        if "error" in result:  # green is not sure: the program goes by the name or says "up"
            assert result["error"].startswith("y:"), (name, result["error"])
            continue
        assert code == 0, message
        heights = read_pfm(out)
        assert np.array_equal(result["data"][..., 0].view("u4"), heights.view("u4")), name
        assert result["min"] == heights.min() and result["max"] == heights.max()
        compared += 1
    assert compared >= 3


@pytest.mark.parametrize(
    ("verb", "options", "call", "how", "more"),
    [
        ("heatmap", [], "heatmap", {}, {}),
        ("convert", ["--to", "zzero"], "convert", {"to": "zzero"}, {}),
        ("convert", ["--depth", "16"], "convert", {"depth": 16}, {}),
        ("convert", ["--from-y", "up", "--to-y", "down"], "convert", {"toY": "down"}, {}),
        (
            "transform",
            ["--strength", "1.7", "--rotate", "90", "--y", "up"],
            "transform",
            {"strength": 1.7, "rotate": 90},
            {},
        ),
        (
            "transform",
            ["--rotate", "33", "--border", "wrap", "--y", "up"],
            "transform",
            {"rotate": 33, "border": "wrap"},
            {},
        ),
        (
            "resize",
            ["--size", "37x29", "--filter", "lanczos3", "--border", "mirror"],
            "resize",
            {"filter": "lanczos3", "border": "mirror"},
            {"size": [37, 29]},
        ),
    ],
)
def test_other_verbs_give_the_same_bytes(verb, options, call, how, more, textures, tmp_path):
    for name in ("standard.png", "standard_alpha.png", "standard_16.png", "padded_black.png"):
        out = tmp_path / name
        code, _, message = ntp(verb, TEXTURES / name, "-o", out, "-q", *options)
        assert code == 0, message
        jobs = Jobs(tmp_path)
        jobs.add(call, textures[name], how, **more)
        result = jobs.run()[0]
        assert "error" not in result, result
        assert np.array_equal(result["data"], read_png(out)[0][..., : result["channels"]]), name


def test_blend_gives_the_same_bytes(textures, tmp_path):
    out = tmp_path / "out.png"
    write_png(tmp_path / "detail.png", textures["standard_rounded.png"][:20, :30])
    base = TEXTURES / "standard.png"
    options = ["--y", "up", "--detail-y", "up", "--mode", "whiteout", "--strength", 0.6]
    code, _, message = ntp("blend", base, tmp_path / "detail.png", "-o", out, *options)
    assert code == 0, message
    jobs = Jobs(tmp_path)
    how = {"mode": "whiteout", "strength": 0.6, "type": "standard", "detailType": "standard"}
    jobs.add(
        "blend", textures["standard.png"], how, detail=textures["standard_rounded.png"][:20, :30]
    )
    assert np.array_equal(jobs.run()[0]["data"], read_png(out)[0])


def test_random_triplets_are_judged_as_the_library_judges_them(tmp_path):
    rng = np.random.default_rng(4)
    levels = rng.integers(0, 256, (512, 512, 3), np.uint8)
    deep = rng.integers(0, 65536, (256, 256, 3), np.uint16)
    jobs = Jobs(tmp_path)
    jobs.add("validate", levels, {"type": "standard"})
    jobs.add("validate", deep, {"type": "zzero"})
    first, second = jobs.run()
    assert np.array_equal(first["data"][..., 0], native.validate(levels, native.STANDARD))
    assert np.array_equal(second["data"][..., 0], native.validate(deep, native.ZZERO))


WORD_LISTS = {  # the list in words.js: the enum of libntp.h, and what its enumerators begin with
    "ENCODINGS": ("ntp_encoding", "ENCODING"),
    "YS": ("ntp_y", "Y"),
    "CLASSES": ("ntp_class", "CLASS"),
    "METHODS": ("ntp_clean_method", "CLEAN"),
    "VERDICTS": ("ntp_verdict", "VERDICT"),
    "KERNELS": ("ntp_kernel", "KERNEL"),
    "BORDERS": ("ntp_border", "BORDER"),
    "SOURCES": ("ntp_height_source", "HEIGHT_SOURCE"),
    "BLUES": ("ntp_blue", "BLUE"),
    "ALPHAS": ("ntp_alpha", "ALPHA"),
    "PALETTES": ("ntp_palette", "PALETTE"),
    "HEIGHT_METHODS": ("ntp_height_method", "HEIGHT"),
    "DECODES": ("ntp_decode", "DECODE"),
    "ZS": ("ntp_z", "Z"),
    "FILTERS": ("ntp_filter", "FILTER"),
    "BLENDS": ("ntp_blend_mode", "BLEND"),
}
LEFT_OUT = {"weighted"}  # it takes weights, and no picture that JavaScript passes has them
OTHER_WORDS = {"trunc": "unorm-trunc", "snorm": "snorm128"}  # as the command line says them


def word(enumerator, prefix):
    """NTP_KERNEL_SOBEL3 is sobel3."""
    plain = enumerator.removeprefix(f"NTP_{prefix}_").lower().replace("_", "-")
    return OTHER_WORDS.get(plain, plain)


def test_words_are_those_of_libntp():
    index = (ROOT / "bindings/js/words.js").as_uri()
    script = "console.log(JSON.stringify(await import(process.argv[1])))"
    command = ["node", "--input-type=module", "-e", script, index]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    words = json.loads(done.stdout)
    accidents = {
        getattr(native.lib, name): name for name in dir(native.lib) if "_ACCIDENT_" in name
    }
    assert words.pop("ACCIDENTS") == [word(accidents[bit], "ACCIDENT") for bit in sorted(accidents)]
    assert set(words) == set(WORD_LISTS)
    for name, (enum, prefix) in WORD_LISTS.items():
        found = native.ffi.typeof(enum).elements
        theirs = [word(found[number], prefix) for number in sorted(found)]
        assert words[name] == [plain for plain in theirs if plain not in LEFT_OUT], name


def test_floats_and_vectors(tmp_path):
    rng = np.random.default_rng(5)
    vectors = rng.normal(0, 1, (40, 30, 3)).astype(np.float32)
    vectors[0, 0] = np.nan
    jobs = Jobs(tmp_path)
    jobs.add("clean", vectors, {"type": "vector", "method": "normalize"})
    jobs.add("convert", vectors, {"type": "vector", "to": "standard", "depth": 8})
    cleaned, stored = jobs.run()
    assert cleaned["notFinite"] == 1 and stored["notFinite"] == 1
    how = native.clean_options(method=native.lib.NTP_CLEAN_NORMALIZE)
    assert np.array_equal(cleaned["data"], native.clean(vectors, native.VECTOR, how)[0])
    unit = vectors[1:] / np.linalg.norm(vectors[1:].astype(float), axis=2, keepdims=True)
    off = np.abs(stored["data"][1:] / 127.5 - 1 - unit)[..., :2]  # blue is derived from these
    assert off.max() < 1.51 / 127.5


@pytest.mark.parametrize(
    ("call", "how", "message"),
    [
        ("clean", {"methud": "derive"}, "methud: unknown option; there are type"),
        ("clean", {"method": "keep"}, 'method: "keep" is none of derive, normalize'),
        ("convert", {"depth": 12}, "depth: must be 8, 16 or 32, not 12"),
        ("convert", {"toY": "left"}, 'toY: "left" is none of up, opengl, down, directx'),
        ("normalsFromHeight", {"scale": None}, "scale: must be a finite number, not null"),
        ("normalsFromHeight", {"kernel": "baked"}, 'kernel: "baked" is none of central'),
        ("resize", {}, "width: must be a whole number of 1 to 65535"),
        ("heightFromNormals", {"refine": -1}, "heightFromNormals: "),
    ],
)
def test_wrong_arguments_are_named(call, how, message, textures, tmp_path):
    jobs = Jobs(tmp_path)
    more = {"size": [0, 9]} if call == "resize" else {}
    jobs.add(call, textures["standard.png"], how, **more)
    assert message in jobs.run()[0]["error"]


def test_what_is_no_normals_texture_is_refused(textures, tmp_path):
    jobs = Jobs(tmp_path)
    jobs.add("clean", textures["photograph.png"])
    jobs.add("clean", textures["photograph.png"], {"type": "standard"})
    jobs.add("heightFromNormals", textures["red_blue_swapped.png"])
    jobs.add("clean", np.full((1, 1, 3), (128, 128, 255), np.uint8))
    refused, taken, swapped, tiny = jobs.run()
    assert "looks like not-normals" in refused["error"]
    assert taken["changed"] > 0
    assert "red-blue" in swapped["error"] and "undo: true" in swapped["error"]
    assert tiny["data"].tolist() == [[[128, 128, 255]]]


def test_memory_is_given_back(tmp_path):
    """A thousand pictures fit into the memory of one."""
    script = """
      const { load } = await import(process.argv[1]);
      const ntp = await load();
      const picture = { data: new Uint8Array(3 * 256 * 256).fill(200), width: 256, height: 256 };
      const sizes = new Set();
      const code = await WebAssembly.compile(
        (await import("node:fs")).readFileSync(new URL("libntp.wasm", process.argv[1])));
      const { exports } = await WebAssembly.instantiate(code, {});
      for (let i = 0; i < 1000; i++) {
        const at = exports.allocate(3 * 256 * 256);
        exports.release(at);
        sizes.add(exports.memory.buffer.byteLength);
        if (i % 100 === 0) ntp.clean(picture, { type: "standard" });
      }
      console.log(sizes.size);
    """
    index = (ROOT / "bindings/js/index.js").as_uri()
    command = ["node", "--input-type=module", "-e", script, index]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert int(done.stdout) == 1


def test_module_imports_nothing():
    script = (
        "const m = new WebAssembly.Module(require('fs').readFileSync('bindings/js/libntp.wasm'));"
        "console.log(WebAssembly.Module.imports(m).length)"
    )
    done = subprocess.run(
        ["node", "-e", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "0"
