# SPDX-License-Identifier: MIT
"""normaltexture.gltf: what is found in .gltf and .glb files."""

import json

import numpy as np
import pytest

from normaltexture import gltf
from pysupport.gltf_models import GOOD, NOT_READ, WAYS, green_mirrored, ids, model, save
from support import textures
from support.pngs import png_bytes


@pytest.mark.parametrize("how", WAYS)
def test_finds_normals_textures(tmp_path, how):
    path = save(model(), tmp_path, how)
    report = gltf.check(path)
    (entry,) = report["files"]
    assert entry["path"] == str(path) and entry["image"] == 1 and entry["status"] == "ok"
    assert entry["storage"] == {"glb": "buffer", "bin": "buffer", "files": "file"}.get(how, how)
    assert entry["name"] == "brick_n.png" and entry["type"] == "standard"
    assert ids(entry)["NT001"] == "error" and (entry["width"], entry["height"]) == (64, 48)
    (use,) = entry["uses"]
    assert use["slot"] == "normalTexture" and use["pointer"] == "/materials/0/normalTexture"
    assert use["material_name"] == "Brick \u2603" and use["wrap_s"] == "repeat"
    assert report["summary"]["with_errors"] == 1 and json.dumps(report)
    assert gltf.check(save(model(GOOD), tmp_path, how, "good"))["summary"]["well_formed"] == 1


def test_finds_clearcoat_and_alternative_sources(tmp_path):
    made = model(slot="emissiveTexture")  # the bad one is no normals texture here
    coat = made.image("coat.png", png_bytes(GOOD))
    made.textures[coat]["extensions"] = {"EXT_texture_avif": {"source": 4}}
    made.images.append(("coat.avif", b"\0\0\0\x1cftypavif" + bytes(16), "image/avif"))
    made.materials[1]["extensions"] = {
        "KHR_materials_clearcoat": {"clearcoatNormalTexture": {"index": coat, "scale": 0.5}}
    }
    entries = gltf.check(save(made, tmp_path))["files"]
    assert [entry["image"] for entry in entries] == [3, 4]
    (use,) = entries[0]["uses"]
    assert use["slot"] == "clearcoatNormalTexture" and use["scale"] == 0.5
    pointer = "/materials/1/extensions/KHR_materials_clearcoat/clearcoatNormalTexture"
    assert use["pointer"] == pointer and entries[0]["type"] == "standard"
    assert entries[1]["uses"][0]["via"] == "EXT_texture_avif"
    assert entries[1]["status"] == "skipped" and ids(entries[1])["NT064"] == "info"


def test_ktx2_is_said(tmp_path):
    made = model()
    made.textures[1]["extensions"] = {"KHR_texture_basisu": {"source": 3}}
    made.images.append(("n.ktx2", NOT_READ, "image/ktx2"))
    entries = gltf.check(save(made, tmp_path))["files"]
    assert [entry["status"] for entry in entries] == ["ok", "skipped"]
    assert "KTX2" in entries[1]["message"]


def test_rules_of_gltf(tmp_path):
    def only(made, name):
        (entry,) = gltf.check(save(made, tmp_path, name=name))["files"]
        return ids(entry)

    shared = model(GOOD)
    shared.materials[1]["emissiveTexture"] = {"index": 1}
    assert only(shared, "a")["NT060"] == "error"
    shared.materials[1] = {"occlusionTexture": {"index": 1}}
    assert only(shared, "b")["NT060"] == "warning"
    assert only(model(GOOD, normalTexture={"index": 1, "scale": -1}), "c")["NT061"] == "warning"
    bare = model(GOOD)
    bare.texcoord = False
    assert only(bare, "d")["NT062"] == "warning"
    wrong = model(GOOD)
    wrong.images[1] = (*wrong.images[1][:2], "image/jpeg")
    assert only(wrong, "e")["NT063"] == "warning"
    assert only(model(textures.zzero(48, 64)), "f")["NT065"] == "error"
    opaque = np.dstack([GOOD, np.full(GOOD.shape[:2], 255, np.uint8)])
    assert only(model(opaque), "g")["NT066"] == "warning"
    turned = {"index": 1, "extensions": {"KHR_texture_transform": {"scale": [-1, 1]}}}
    assert only(model(GOOD, normalTexture=turned), "h")["NT067"] == "info"
    assert only(model(np.dstack([GOOD[..., :2], 255 - GOOD[..., 2:]])), "i")["NT003"] == "error"
    assert only(model(green_mirrored(GOOD)), "j").get("NT010") == "warning"
    assert not {"warning", "error"} & set(only(model(GOOD), "k").values())
    documented = {name for name in gltf.RULES}
    assert documented == {f"NT{number:03}" for number in range(60, 70)}


BROKEN = {
    "empty": b"",
    "text": b"hello",
    "lfs": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
    "array": b"[]",
    "version 1": b'{"asset": {"version": "1.0"}}',
    "no asset": b"{}",
    "glb truncated": b"glTF\2\0\0\0\xff\0\0\0",
    "glb version": b"glTF\1\0\0\0\x0c\0\0\0",
    "glb without JSON": b"glTF\2\0\0\0\x14\0\0\0\0\0\0\0BIN\0",
    "deep": b'{"asset":' * 100000,
    "images no list": b'{"asset":{"version":"2.0"},"images":3,"materials":'
    b'[{"normalTexture":{"index":0}}],"textures":[{"source":0}]}',
    "index": b'{"asset":{"version":"2.0"},"materials":[{"normalTexture":{"index":7}}]}',
    "negative": b'{"asset":{"version":"2.0"},"materials":[{"normalTexture":{"index":-1}}]}',
    "meshes": b'{"asset":{"version":"2.0"},"meshes":[{"primitives":[3]}],"materials":'
    b'[{"normalTexture":{"index":0}}],"textures":[{"source":0}],"images":[{"uri":"x.png"}]}',
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files(tmp_path, name):
    path = tmp_path / "broken.glb"
    path.write_bytes(BROKEN[name])
    report = gltf.check([path, save(model(GOOD), tmp_path)])
    assert report["files"][0]["status"] == "unreadable"
    assert str(path) in report["files"][0]["message"] and report["files"][-1]["status"] == "ok"


@pytest.mark.parametrize(
    "uri", ["missing.png", "http://localhost/x.png", "//host/x.png", "data:,x", "data:;base64,%%%"]
)
def test_missing_images(tmp_path, uri):
    path = save(model(), tmp_path, "files")
    path.write_text(path.read_text().replace('"brick_n.png"', json.dumps(uri)))
    (entry,) = gltf.check(path)["files"]
    assert entry["status"] == "unreadable" and entry["message"]


def test_views_outside_the_buffer(tmp_path):
    path = save(model(), tmp_path, "data")
    document = json.loads(path.read_text())
    for view in ({"byteOffset": 10**9}, {"byteLength": 10**9}, {"byteLength": 0}, {"buffer": 1}):
        document["bufferViews"].append({"buffer": 0, "byteOffset": 0, "byteLength": 4, **view})
        document["images"][1] = {"bufferView": len(document["bufferViews"]) - 1}
        path.write_text(json.dumps(document))
        (entry,) = gltf.check(path)["files"]
        assert entry["status"] == "unreadable", view
