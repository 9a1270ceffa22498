# SPDX-License-Identifier: MIT
"""Copies of .gltf and .glb files that differ in normals textures alone."""

import io
import json
import struct

import numpy as np
import pytest

import normaltexture as nt
from normaltexture import gltf
from normaltexture.gltf import _check
from pysupport import gltf_files as files
from pysupport.gltf_models import (
    BAD,
    GOOD,
    WAYS,
    green_mirrored,
    ids,
    model,
    ntp_gltf,
    pixels,
    save,
)
from support import textures


def changed_lines(before, after):
    """The lines of two texts of equal length in lines that differ."""
    pairs = zip(before.splitlines(), after.splitlines(), strict=True)
    return [(old.strip(), new.strip()) for old, new in pairs if old != new]


@pytest.mark.parametrize("how", WAYS)
def test_clean_changes_only_normals(tmp_path, how):
    path = save(model(), tmp_path, how)
    (tmp_path / "out").mkdir()
    copy = tmp_path / "out" / path.name
    report = gltf.clean(path, copy, method="derive")
    (entry,) = report["files"]
    assert entry["written"] and entry["changed"] == round(0.2 * 64 * 48)
    old_buffer, old = files.resources(path)
    new_buffer, new = files.resources(copy)
    assert new[0] == old[0] and new[2] == old[2] and new[1] != old[1]
    assert np.array_equal(pixels(new[1], tmp_path), GOOD)
    before, after = files.parse(path), files.parse(copy)
    assert files.accessor_bytes(after[0], new_buffer) == files.accessor_bytes(before[0], old_buffer)
    for view in after[0]["bufferViews"]:
        assert view.get("byteOffset", 0) % 4 == 0
    edited = changed_lines(before[1].rstrip(), after[1].rstrip())
    names = {line.partition('"')[2].partition('"')[0] for _, line in edited}
    allowed = {
        "glb": {"byteOffset", "byteLength"},
        "bin": {"byteOffset", "byteLength"},
        "data": {"uri"},
        "files": set(),
    }
    assert names <= allowed[how], edited
    assert gltf.check(copy)["files"][0]["fail"]["exact"] == 0
    again = gltf.clean(copy, tmp_path / "again" / path.name)
    assert not again["files"][0]["written"]
    assert (tmp_path / "again" / path.name).read_bytes() == copy.read_bytes()


@pytest.mark.parametrize("how", WAYS)
def test_clean_of_a_clean_file_is_a_copy(tmp_path, how):
    path = save(model(GOOD), tmp_path, how)
    copy = tmp_path / "out" / path.name
    gltf.clean(path, copy, method="derive")
    assert copy.read_bytes() == path.read_bytes()
    assert files.resources(copy) == files.resources(path)


@pytest.mark.parametrize("how", WAYS)
def test_clean_beside_the_original_keeps_it(tmp_path, how):
    path = save(model(), tmp_path, how)
    before = {file: file.read_bytes() for file in tmp_path.iterdir()}
    copy = path.with_stem("cleaned")
    for _ in range(2):  # a second run takes the same names
        gltf.clean(path, copy, method="derive")
    for file, data in before.items():
        assert file.read_bytes() == data
    assert np.array_equal(pixels(files.resources(copy)[1][1], tmp_path), GOOD)
    made = {file.name for file in tmp_path.iterdir()} - {file.name for file in before}
    extra = {"files": {"brick_n-clean.png"}, "bin": {"geometry-clean.bin"}}.get(how, set())
    assert made - {"pixels.png"} == {copy.name} | extra


@pytest.mark.parametrize("how", WAYS)
def test_clean_in_place(tmp_path, how):
    path = save(model(), tmp_path, how)
    names = set(tmp_path.iterdir())
    gltf.clean(path, dry_run=True)
    assert gltf.check(path)["summary"]["with_errors"] == 1
    gltf.clean(path, method="derive")
    assert set(tmp_path.iterdir()) == names
    assert gltf.check(path)["summary"]["well_formed"] == 1
    assert np.array_equal(pixels(files.resources(path)[1][1], tmp_path), GOOD)


def jpeg_bytes(image):
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(image).save(out, "JPEG", quality=90, subsampling=0)
    return out.getvalue()


@pytest.mark.parametrize("how", WAYS)
def test_jpeg_becomes_png(tmp_path, how):
    made = model()
    made.images[1] = ("brick_n.jpg", jpeg_bytes(BAD), "image/jpeg")
    path = save(made, tmp_path, how)
    copy = tmp_path / "out" / path.name
    kept = gltf.clean(path, copy, keep_jpeg=True)["files"][0]
    assert kept["status"] == "skipped" and "JPEG" in kept["message"]
    assert files.resources(copy)[1] == files.resources(path)[1]
    assert gltf.clean(path, copy, method="derive")["files"][0]["written"]
    data = files.resources(copy)[1][1]
    assert data.startswith(b"\x89PNG")
    image = files.parse(copy)[0]["images"][1]
    if how == "files":
        assert image["uri"] == "brick_n.png"
    elif how == "data":
        assert image["uri"].startswith("data:image/png;base64,")
    else:
        assert image["mimeType"] == "image/png"
    assert "NT063" not in ids(gltf.check(copy)["files"][0])


def test_alpha_and_green(tmp_path):
    opaque = np.dstack([GOOD, np.full(GOOD.shape[:2], 255, np.uint8)])
    path = save(model(opaque), tmp_path)
    copy = tmp_path / "copy.glb"
    assert gltf.clean(path, copy, method="derive")["files"][0]["alpha_dropped"]
    assert np.array_equal(pixels(files.resources(copy)[1][1], tmp_path), GOOD)
    gltf.clean(path, copy, drop_alpha=False)
    assert copy.read_bytes() == path.read_bytes()
    opaque[0, 0, 3] = 7  # used for something: kept
    gltf.clean(save(model(opaque), tmp_path), copy)
    assert pixels(files.resources(copy)[1][1], tmp_path).shape[2] == 4
    entry = gltf.clean(save(model(GOOD), tmp_path), copy, flip_green=True)["files"][0]
    assert entry["green_flipped"]
    flipped = pixels(files.resources(copy)[1][1], tmp_path)
    assert np.array_equal(flipped, green_mirrored(GOOD))


def test_shared_images_are_left(tmp_path):
    made = model()
    made.materials[1]["emissiveTexture"] = {"index": 1}
    path, copy = save(made, tmp_path), tmp_path / "copy.glb"
    entry = gltf.clean(path, copy, method="derive")["files"][0]
    assert entry["status"] == "skipped" and "emissiveTexture" in entry["message"]
    assert copy.read_bytes() == path.read_bytes()


def test_overlapping_views_are_left(tmp_path):
    path, copy = save(model(), tmp_path), tmp_path / "copy.glb"
    document, _, chunk = files.parse(path)
    view = dict(document["bufferViews"][document["images"][1]["bufferView"]], byteLength=8)
    document["bufferViews"].append(view)
    path.write_bytes(files.glb(json.dumps(document), chunk))
    entry = gltf.clean(path, copy, method="derive")["files"][0]
    assert entry["status"] == "skipped" and "overlaps" in entry["message"]


def test_offsets_of_extensions_move(tmp_path):
    path, copy = save(model(), tmp_path), tmp_path / "copy.glb"
    document, _, chunk = files.parse(path)
    last = document["bufferViews"][-1]
    last["extensions"] = {
        "EXT_meshopt_compression": {
            "buffer": 0,
            "byteOffset": last["byteOffset"],
            "byteLength": last["byteLength"],
        }
    }
    extra = struct.pack("<I4s", 4, b"XTRA") + b"keep"
    path.write_bytes(files.glb(json.dumps(document), chunk, extra))
    gltf.clean(path, copy, method="derive")
    last = files.parse(copy)[0]["bufferViews"][-1]
    assert last["extensions"]["EXT_meshopt_compression"]["byteOffset"] == last["byteOffset"]
    assert copy.read_bytes().endswith(extra)


def packed_by_meshopt(tmp_path, **compressed):
    """What EXT_meshopt_compression says of such files: accessors read a buffer without bytes."""
    path = save(model(), tmp_path)
    document, _, chunk = files.parse(path)
    fallback = {"byteLength": 64, "extensions": {"EXT_meshopt_compression": {"fallback": True}}}
    document["buffers"].append(fallback)
    body = {"buffer": 0, "byteOffset": len(chunk), "byteLength": 8} | compressed
    view = {"buffer": 1, "byteLength": 64, "extensions": {"EXT_meshopt_compression": body}}
    document["bufferViews"].append(view)
    chunk += b"vertices"
    document["buffers"][0]["byteLength"] = len(chunk)
    path.write_bytes(files.glb(json.dumps(document), chunk))
    return path


def test_buffers_without_bytes(tmp_path):
    path, copy = packed_by_meshopt(tmp_path), tmp_path / "copy.glb"
    assert gltf.clean(path, copy, method="derive")["files"][0]["status"] == "ok"
    document, _, chunk = files.parse(copy)
    body = document["bufferViews"][-1]["extensions"]["EXT_meshopt_compression"]
    assert chunk[body["byteOffset"] :][:8] == b"vertices"
    assert document["buffers"][1]["byteLength"] == 64
    assert "NT001" not in ids(gltf.check(copy)["files"][0])


def test_packed_bytes_that_overlap_an_image_are_left(tmp_path):
    path, copy = (
        packed_by_meshopt(tmp_path, byteOffset=0, byteLength=1 << 20),
        tmp_path / "copy.glb",
    )
    entry = gltf.clean(path, copy, method="derive")["files"][0]
    assert entry["status"] == "skipped" and "overlaps" in entry["message"]
    path = packed_by_meshopt(tmp_path, byteLength="8")
    with pytest.raises(gltf.GltfError, match="without a range"):
        gltf.clean(path, copy, method="derive")


def test_spoiled_blue_is_standard_all_the_same(tmp_path):
    """By its texels alone it would be XY-only, whose blue nobody judges or repairs."""
    half = textures.wrong_blue(GOOD, 0.5)
    constant = np.dstack([GOOD[..., :2], np.full(GOOD.shape[:2], 255, np.uint8)])
    for name, texture in (("half", half), ("constant", constant)):
        path = save(model(texture), tmp_path, name=name)
        (entry,) = gltf.check(path)["files"]
        assert entry["type"] == "standard" and ids(entry)["NT001"] == "error", name
        assert "NT065" not in ids(entry) and "NT006" not in ids(entry)
        (done,) = gltf.clean(path, copy := tmp_path / "copy.glb")["files"]
        assert done["written"] and not [f for f in done["remaining"] if f["level"] == "error"]
        assert np.array_equal(pixels(files.resources(copy)[1][1], tmp_path), GOOD)
        assert ntp_gltf(copy).returncode == 0


def test_z_zero_becomes_standard(tmp_path):
    zzero = green_mirrored(textures.zzero(48, 64))
    path, copy = save(model(zzero), tmp_path), tmp_path / "copy.glb"
    assert ids(gltf.check(path)["files"][0])["NT065"] == "error"
    expected = nt.convert(zzero, type="zzero", to="standard")
    for type in ("auto", "zzero"):
        (entry,) = gltf.clean(path, copy, type=type)["files"]
        assert entry["written"] and "NT065" not in {f["id"] for f in entry["remaining"]}
        made = pixels(files.resources(copy)[1][1], tmp_path)
        assert np.array_equal(made, expected), type
        assert ntp_gltf(copy).returncode == 0
    assert ids(gltf.check(path, type="zzero")["files"][0])["NT065"] == "error"
    assert ids(gltf.check(path, type="xy")["files"][0])["NT065"] == "error"


def test_what_is_not_normals_is_refused_unless_told(tmp_path):
    path, copy = save(model(textures.photograph()), tmp_path), tmp_path / "copy.glb"
    assert ids(gltf.check(path)["files"][0]).get("NT008") == "error"
    done = ntp_gltf(path, "-o", copy)
    assert done.returncode == 1 and "photograph" not in done.stdout
    done = ntp_gltf(path, "-o", copy, "--type", "standard")
    assert done.returncode == 0, done.stderr
    assert "NT008" not in ids(gltf.check(copy, type="standard")["files"][0])


def test_what_is_reported_is_repaired_or_refused(tmp_path):
    """Exit 0 means that the copy has no finding at or above --fail-on."""
    shared = model()
    shared.materials[1]["emissiveTexture"] = {"index": 1}
    lossy = model()
    lossy.images[1] = ("brick_n.jpg", jpeg_bytes(textures.wrong_blue(GOOD, 1)), "image/jpeg")
    odd = model(normalTexture={"index": 1, "scale": -1})
    copy = tmp_path / "copy.glb"
    for made, options, code, rule in (
        (model(), [], 0, ""),
        (shared, [], 1, "NT060"),
        (lossy, ["--keep-jpeg"], 1, "NT001"),
        (lossy, [], 0, ""),
        (odd, [], 0, "NT061"),
        (odd, ["--fail-on", "warning"], 1, "NT061"),
        (shared, ["--fail-on", "never"], 0, "NT060"),
    ):
        done = ntp_gltf(save(made, tmp_path), "-o", copy, "--method", "derive", *options)
        assert done.returncode == code, (rule, done.stdout, done.stderr)
        assert (f" {rule}  " in done.stdout + done.stderr) if rule else "NT0" not in done.stdout


def test_orientation_is_a_warning_only_where_sure(tmp_path, monkeypatch):
    path = save(model(green_mirrored(GOOD)), tmp_path)
    assert ids(gltf.check(path)["files"][0])["NT010"] == "warning"
    real = _check._ntp.run_json

    def unsure(verb, paths, options=(), cwd=None):
        report, code = real(verb, paths, options, cwd)
        if "auto" in options:
            for file in report["files"]:
                file["y_confidence"] = 0.89
        return report, code

    monkeypatch.setattr(_check._ntp, "run_json", unsure)
    assert ids(gltf.check(path)["files"][0])["NT010"] == "info"
