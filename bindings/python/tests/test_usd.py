# SPDX-License-Identifier: MIT
"""ntp usd: scenes made with usd-core, right and wrong in each way, and the repair of textures."""

import json
import os
import struct
import subprocess
import sys
import zipfile

import numpy as np
import pytest

pytest.importorskip("pxr")

import OpenEXR
from jsonschema import Draft202012Validator
from PIL import Image
from pxr import Usd, UsdValidation
from referencing import Registry, Resource

import normaltexture as nt
from normaltexture import usd
from normaltexture.usd import _cli, validator
from pysupport import ROOT, usd_files
from support import encoders, textures
from support.pngs import png_bytes, read_png

GOOD = textures.standard(48, 64)
GOOD[..., 1] = 255 - GOOD[..., 1]  # green up
DOWN = textures.standard(48, 64)
LEFT = np.dstack([255 - GOOD[..., 0], GOOD[..., 1:]])  # x is inverted
BAD = textures.wrong_blue(GOOD, 0.3)
ZZERO = textures.zzero(48, 64)
ZZERO[..., 1] = 255 - ZZERO[..., 1]


def exr(path, pixels):
    OpenEXR.File({}, {"RGB": pixels.astype(np.float32)}).write(str(path))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Textures of all kinds."""
    place = tmp_path_factory.mktemp("usd")
    images = {"good": GOOD, "bad": BAD, "down": DOWN, "left": LEFT, "zzero": ZZERO}
    images |= {"deep": GOOD.astype(np.uint16) * 257, "photo": textures.photograph()}
    images["gray"] = GOOD[..., 0]
    for name, pixels in images.items():
        (place / f"{name}.png").write_bytes(png_bytes(pixels))
    Image.fromarray(BAD).save(place / "bad.jpg", quality=90)
    for tile in ("good.1001.png", "good.1002.png"):
        (place / tile).write_bytes(png_bytes(GOOD if "1001" in tile else BAD))
    vectors = GOOD / 255 * 2 - 1
    vectors /= np.linalg.norm(vectors, axis=-1, keepdims=True)
    exr(place / "signed.exr", vectors)
    exr(place / "biased.exr", (vectors + 1) / 2)
    return place


def found(path, **options):
    """{(id, level)} of a scene, and its entries."""
    entries = usd.check(path, **options)["files"]
    return {(one["id"], one["level"]) for e in entries for one in e["findings"]}, entries


def preview(file, **more):
    return usd_files.scene, file, more


def mtlx(file, **more):
    return usd_files.materialx, file, more


# Id, level, and a scene that has it.
WRONG = [
    ("NT070", "error", preview("good.png", space="sRGB")),
    ("NT070", "error", preview("good.png", space="auto")),
    ("NT070", "error", preview("good.png", space=None)),
    ("NT070", "warning", preview("deep.png", space="auto")),
    ("NT070", "error", mtlx("good.png", node="ND_image_color3")),
    ("NT070", "error", mtlx("good.png", node="ND_image_color3", space="srgb_texture")),
    ("NT070", "warning", preview("gray.png", space="auto")),
    ("NT070", "warning", mtlx("good.png", space="srgb_texture")),
    ("NT071", "error", preview("good.png", scale=None, bias=None)),
    ("NT071", "error", preview("deep.png", scale=None, bias=None)),
    ("NT071", "error", preview("good.png", bias=(0, 0, 0, 0))),
    ("NT071", "error", preview("good.png", scale=(2, 1, 2, 1), bias=(-1, -0.5, -1, 0))),
    ("NT071", "error", preview("good.png", scale=(2, 2, 3, 1))),
    ("NT071", "warning", preview("zzero.png")),
    ("NT071", "error", preview("signed.exr")),
    ("NT071", "error", preview("biased.exr", scale=None, bias=None)),
    ("NT071", "error", mtlx("good.png", node="ND_UsdUVTexture_23")),
    ("NT072", "info", preview("good.png", scale=(1, 1, 2, 1), bias=(-0.5, -0.5, -1, 0))),
    ("NT072", "info", mtlx("good.png", strength=0.5)),
    ("NT073", "error", preview("good.png", output="r")),
    ("NT073", "info", mtlx("good.png", between="ND_multiply_vector3")),
    ("NT060", "error", preview("good.png", color="good.png")),
    ("NT010", "warning", preview("down.png")),
    ("NT010", "warning", preview("good.png", scale=(2, -2, 2, 1), bias=(-1, 1, -1, 0))),
    ("NT001", "error", preview("bad.png")),
    ("NT001", "error", mtlx("bad.png")),
    ("NT008", "error", preview("photo.png")),
]
RIGHT = [
    preview("good.png"),
    preview("deep.png"),
    preview("good.png", color="photo.png"),
    preview("down.png", scale=(2, -2, 2, 1), bias=(-1, 1, -1, 0)),
    preview("left.png", scale=(-2, 2, 2, 1), bias=(1, -1, -1, 0)),
    preview("zzero.png", scale=(2, 2, 1, 1), bias=(-1, -1, 0, 0)),
    preview("good.png", scale=(255 / 127,) * 4, bias=(-128 / 127,) * 4),
    preview("good.png", scale=(4, 4, 2, 1), bias=(-2, -2, -1, 0)),
    preview("signed.exr", scale=None, bias=None),
    preview("biased.exr"),
    mtlx("good.png"),
    mtlx("good.png", strength=1),
    (usd_files.through_graph, "good.png", {}),
]


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_each_finding(folder, number):
    rule, level, (make, file, more) = WRONG[number]
    path = make(folder / f"wrong{number}.usda", file, **more)
    assert (rule, level) in found(path)[0]


@pytest.mark.parametrize("number", range(len(RIGHT)))
def test_what_is_right_is_not_accused(folder, number):
    make, file, more = RIGHT[number]
    levels, entries = found(make(folder / f"right{number}.usda", file, **more))
    assert not [one for one in levels if one[1] != "info"], levels
    (entry,) = entries
    assert entry["status"] == "ok" and entry["image"] == file


def test_strength_of_z_in_0_to_1(folder):
    for scale, full in ((2, True), (1, False)):
        more = {"scale": (scale, scale, 1, 1), "bias": (-scale / 2, -scale / 2, 0, 0)}
        path = usd_files.scene(folder / f"strength{scale}.usda", "zzero.png", **more)
        assert (("NT072", "info") in found(path)[0]) != full


def test_every_rule_has_a_case():
    assert set(usd.RULES) <= {case[0] for case in WRONG}


def test_tiles_are_each_judged(folder):
    path = usd_files.scene(folder / "tiles.usda", "good.<UDIM>.png")
    entries = found(path)[1]
    worst = {e["image"]: max(one["level"] == "error" for one in e["findings"]) for e in entries}
    assert worst == {"good.1001.png": False, "good.1002.png": True}


def test_files_outside_are_not_read(folder, tmp_path):
    path = usd_files.scene(tmp_path / "out.usda", str(folder / "good.png"))
    assert "outside" in found(path)[1][0]["message"]
    assert found(path, root="/")[1][0]["status"] == "ok"
    assert (
        found(usd_files.scene(tmp_path / "gone.usda", "gone.png"))[1][0]["status"] == "unreadable"
    )
    (tmp_path / "no.usda").write_text("no USD")
    assert "no USD" in found(tmp_path / "no.usda")[1][0]["message"]


def test_layers_that_cannot_be_opened_are_said(folder, capsys):
    path = usd_files.scene(folder / "lost.usda", "good.png")
    stage = Usd.Stage.Open(str(path))
    stage.DefinePrim("/X").GetReferences().AddReference("./gone.mtlx", "/Y")
    stage.Save()
    assert _cli.main([str(path)]) == 3
    assert "gone.mtlx could not be opened" in capsys.readouterr().err


def everything(place):
    return {path.relative_to(place): path.read_bytes() for path in place.rglob("*.*")}


def test_textures_are_cleaned_in_place_and_in_a_copy(folder, tmp_path, capsys):
    (tmp_path / "in" / "maps").mkdir(parents=True)
    place = tmp_path / "in"
    (place / "maps" / "bad.png").write_bytes(png_bytes(BAD))
    (place / "photo.png").write_bytes(png_bytes(textures.photograph()))
    path = usd_files.scene(place / "a.usda", "./maps/bad.png", color="./photo.png")
    before = everything(place)
    assert _cli.main([str(path), "-o", str(tmp_path / "out"), "-n"]) == 0
    assert not (tmp_path / "out").exists() and "would be written" in capsys.readouterr().out
    assert _cli.main([str(path), "-o", str(tmp_path / "out")]) == 0
    after = everything(tmp_path / "out")
    assert everything(place) == before and set(after) == set(before)
    changed = {str(name) for name in before if before[name] != after[name]}
    assert changed == {"maps/bad.png"}
    assert np.array_equal(read_png(tmp_path / "out" / "maps" / "bad.png")[0], GOOD)
    assert _cli.main([str(tmp_path / "out" / "a.usda")]) == 0
    assert _cli.main([str(path), "--in-place"]) == 0
    assert everything(place) == after
    assert _cli.main([str(path), "--in-place"]) == 0
    assert "nothing to change" in capsys.readouterr().out
    assert _cli.main([str(path), "-o", str(place)]) == 2


def test_a_package_is_read_and_cleaned(folder, tmp_path):
    inner = usd_files.scene(folder / "inner.usdc", "bad.png")
    parts = {"inner.usdc": inner, "bad.png": folder / "bad.png", "more.png": folder / "photo.png"}
    path = usd_files.package(tmp_path / "a.usdz", parts)
    assert ("NT001", "error") in found(path)[0]
    copy = tmp_path / "out" / "b.usdz"
    assert _cli.main([str(path), "-o", str(copy)]) == 0
    with zipfile.ZipFile(copy) as made, zipfile.ZipFile(path) as old:
        assert made.namelist() == old.namelist() == list(parts)
        for name in ("inner.usdc", "more.png"):
            assert made.read(name) == old.read(name)
        (tmp_path / "made.png").write_bytes(made.read("bad.png"))
        for info in made.infolist():  # stored, each at a multiple of 64
            head = copy.read_bytes()[info.header_offset :][:30]
            name, extra = struct.unpack_from("<HH", head, 26)
            assert info.compress_type == 0 and (info.header_offset + 30 + name + extra) % 64 == 0
    assert np.array_equal(read_png(tmp_path / "made.png")[0], GOOD)
    assert _cli.main([str(copy)]) == 0
    assert _cli.main([str(path), "--in-place"]) == 0 and path.read_bytes() == copy.read_bytes()
    assert _cli.main([str(path), "-o", str(path)]) == 2


def refer(path, **named):
    """A scene that refers to others, by the names of prims."""
    stage = Usd.Stage.CreateNew(str(path))
    for name, file in named.items():
        stage.DefinePrim(f"/{name}").GetReferences().AddReference(file, "/M")
    stage.Save()
    return path


def test_one_name_of_two_files(tmp_path):
    for name, pixels in (("a", GOOD), ("b", BAD)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "n.png").write_bytes(png_bytes(pixels))
        usd_files.scene(tmp_path / name / "part.usda", "n.png")
    path = refer(tmp_path / "scene.usda", A="./a/part.usda", B="./b/part.usda")
    assert [entry["image"] for entry in found(path)[1]] == ["n.png", "n.png"]
    written = {entry["resolved"]: entry["written"] for entry in usd.clean(path)["files"]}
    assert {place.split("/")[-2]: done for place, done in written.items()} == {
        "a": False,
        "b": True,
    }
    assert np.array_equal(read_png(tmp_path / "b" / "n.png")[0], GOOD)


def test_a_package_of_another_scene_stays(folder, tmp_path, capsys):
    inner = usd_files.scene(folder / "part.usda", "bad.png")
    usd_files.package(tmp_path / "part.usdz", {"part.usda": inner, "bad.png": folder / "bad.png"})
    path = refer(tmp_path / "scene.usda", A="./part.usdz")
    before = everything(tmp_path)
    assert _cli.main([str(path), "--in-place"]) == 1
    assert "in another package" in capsys.readouterr().err and everything(tmp_path) == before


def test_what_cannot_be_repaired_is_said(folder, tmp_path, capsys):
    for name, make, code, word in (
        ("jpeg", ("bad.jpg", {}), 1, "image/jpeg is not written"),
        ("photo", ("photo.png", {}), 1, "photo.png"),
        ("space", ("good.png", {"space": "sRGB"}), 1, "left: error NT070"),
        ("shared", ("bad.png", {"color": "bad.png"}), 1, "is read by /M/Color as well"),
        ("zzero", ("zzero.png", {}), 0, "texels changed"),
    ):
        path = usd_files.scene(folder / f"{name}.usda", make[0], **make[1])
        assert _cli.main([str(path), "-o", str(tmp_path / name)]) == code, name
        said = capsys.readouterr()
        assert word in said.out + said.err, name


def test_numbers_converted_to_srgb_are_undone(tmp_path):
    flat = GOOD.copy()
    flat[12:] = 128, 128, 255
    (tmp_path / "flat.png").write_bytes(png_bytes(encoders.srgb_encode(flat)))
    path = usd_files.scene(tmp_path / "a.usda", "flat.png")
    assert ("NT040", "error") in found(path)[0]
    assert _cli.main([str(path), "--in-place"]) == 0
    made, _ = read_png(tmp_path / "flat.png")
    assert nt.compare(made, flat, type="standard").angles.max < 1.5


def test_json_is_as_the_schema_says(folder, tmp_path, capsys):
    names = ("usd-1.json", "check-1.json", "gltf-1.json")
    read = {n: json.loads((ROOT / "docs" / "schema" / n).read_text("utf-8")) for n in names}
    pairs = [(name, Resource.from_contents(body)) for name, body in read.items()]
    Draft202012Validator.check_schema(read["usd-1.json"])
    schema = Draft202012Validator(read["usd-1.json"], registry=Registry().with_resources(pairs))
    paths = [
        usd_files.scene(folder / "bad.usda", "bad.png"),
        usd_files.scene(folder / "gone.usda", "gone.png"),
        usd_files.scene(folder / "jpeg2.usda", "bad.jpg"),
        folder / "none.usda",
    ]
    for more in ([], ["-o", str(tmp_path / "out"), "-n"]):
        assert _cli.main([*map(str, paths), "--format", "json", *more]) == 3
        told = json.loads(capsys.readouterr().out)
        schema.validate(told)
        assert len(told["files"]) == 4
        wrong = json.loads(json.dumps(told))
        wrong["files"][0].pop("uses")
        assert not schema.is_valid(wrong)
    assert _cli.main([str(paths[0]), "--format", "sarif"]) == 1
    assert json.loads(capsys.readouterr().out)["runs"][0]["results"][0]["ruleId"] == "NT001"


def test_the_validator(folder):
    path = usd_files.scene(folder / "both.usda", "bad.png", space="sRGB")
    name = validator.register()
    assert validator.register() == name
    registry = UsdValidation.ValidationRegistry()
    stage = Usd.Stage.Open(str(path))
    errors = registry.GetOrLoadValidatorByName(name).Validate(stage)
    assert {error.GetName() for error in errors} >= {"NT001", "NT070"}
    assert {str(site.GetPrim().GetPath()) for e in errors for site in e.GetSites()} == {
        "/M/Normals"
    }
    good = usd_files.scene(folder / "fine.usda", "good.png")
    assert not registry.GetOrLoadValidatorByName(name).Validate(Usd.Stage.Open(str(good)))


def test_the_plugin(folder):
    """As USD finds it by PXR_PLUGINPATH_NAME, in a process of its own."""
    path = usd_files.scene(folder / "plugin.usda", "bad.png")
    code = (
        "import sys; from pxr import Usd, UsdValidation; "
        "v = UsdValidation.ValidationRegistry().GetOrLoadValidatorByName("
        "'normaltexture.usd.plugin:NormalsTextureValidator'); "
        "print(*[e.GetName() for e in v.Validate(Usd.Stage.Open(sys.argv[1]))])"
    )
    place = str(validator.folder())
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PXR_PLUGINPATH_NAME": place},
    )
    assert done.stdout.split() == ["NT001"], done.stderr


def test_without_usd_core(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "pxr", None)
    (tmp_path / "a.usda").write_text("#usda 1.0\n")
    assert _cli.main([str(tmp_path / "a.usda")]) == 3
    assert "pip install 'normaltexture[usd]'" in capsys.readouterr().err
    assert _cli.main(["--help"]) == 0
    assert capsys.readouterr().out.startswith("usage: ntp usd")
