# SPDX-License-Identifier: MIT
"""normaltexture.gltf: what is found in .gltf and .glb files, and copies that differ in nothing else."""

import io
import json
import os
import struct
import subprocess
import sys

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from referencing import Registry, Resource

import normaltexture as nt
from normaltexture import _named, gltf
from normaltexture.gltf import _check, _clean, _cli
from normaltexture.gltf._spans import Editor
from pysupport import ROOT
from pysupport import gltf_files as files
from support import textures
from support.pngs import png_bytes, read_png


def green_mirrored(texture):
    return np.dstack([texture[..., 0], 255 - texture[..., 1], texture[..., 2:]])


GOOD = green_mirrored(textures.standard(48, 64))  # up
BAD = textures.wrong_blue(GOOD, 0.2)
COLOR = files.noise_color()
# A KTX2 of ASTC: its header is read, its pixels are not.
NOT_READ = files.ktx2(np.zeros((3, 3, 4), np.uint8), model=162, vulkan=157)
WAYS = ["glb", "files", "data", "bin"]


def model(normals=BAD, slot="normalTexture", **more):
    """A color texture, a normals texture, another color texture."""
    made = files.Model()
    first = made.image("color 1.png", png_bytes(COLOR))
    second = made.image("brick_n.png", png_bytes(normals))
    third = made.image("color 2.png", png_bytes(COLOR[::-1]))
    made.material("Brick \u2603", baseColorTexture=first, **({slot: second} | more))
    made.material("Other", baseColorTexture=third)
    return made


def save(made, tmp_path, how="glb", name="model"):
    return made.save(tmp_path / (name + (".glb" if how == "glb" else ".gltf")), how)


def ids(entry):
    return {found["id"]: found["level"] for found in entry["findings"]}


def pixels(data, tmp_path):
    path = tmp_path / "pixels.png"
    path.write_bytes(data)
    return read_png(path)[0]


# ------------------------------------------------------------------------------ finding


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


# ----------------------------------------------------------------------------- cleaning


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


def test_nothing_is_written_outside(tmp_path):
    inner = tmp_path / "a" / "b"
    inner.mkdir(parents=True)
    made = model()
    path = save(made, inner, "files")
    (tmp_path / "a" / "brick_n.png").write_bytes((inner / "brick_n.png").read_bytes())
    path.write_text(path.read_text().replace('"brick_n.png"', '"../brick_n.png"'))
    assert gltf.check(path)["files"][0]["status"] == "unreadable"
    assert gltf.check(path, root=tmp_path / "a")["files"][0]["status"] == "ok"
    before = everything(tmp_path)
    for output in (tmp_path / "out" / "copy.gltf", path.with_stem("copy"), None):
        for root in (None, tmp_path / "a"):
            if (output, root) != (None, None):  # in place: an image that is not read
                with pytest.raises(gltf.GltfError, match="outside"):
                    gltf.clean(path, output, root=root)
            assert everything(tmp_path) == before


def everything(folder):
    """What all files in a folder hold, links as such."""
    return {
        file: os.readlink(file) if file.is_symlink() else file.read_bytes()
        for file in folder.rglob("*")
        if file.is_symlink() or file.is_file()
    }


# ------------------------------------------------------ names that lead somewhere else


def hostile(tmp_path, name, what="image"):
    """A model in a/ that names another file as its normals texture, or as its buffer."""
    inner = tmp_path / "a"
    inner.mkdir(exist_ok=True)
    path = save(model(), inner, "files" if what == "image" else "bin")
    old = "brick_n.png" if what == "image" else "geometry.bin"
    path.write_text(path.read_text().replace(f'"{old}"', json.dumps(name)))
    return path


@pytest.mark.parametrize(
    "name", ["/dev/zero", "/dev/null", "pipe", ".", "/etc/passwd", "/proc/kmsg"]
)
@pytest.mark.parametrize("what", ["image", "buffer"])
def test_only_regular_files_of_the_folder_are_opened(tmp_path, name, what):
    path = hostile(tmp_path, name, what)
    os.mkfifo(path.parent / "pipe")
    done = ntp_gltf(path, "--format", "json", timeout=20)
    assert done.returncode == 3, done.stderr
    (entry,) = json.loads(done.stdout)["files"]
    assert entry["status"] == "unreadable" and name.strip("./") in entry["message"]
    out = tmp_path / "out"
    done = ntp_gltf(path, "-o", out, timeout=20)
    assert done.returncode == 3 and "Traceback" not in done.stderr and not out.exists()
    # Nothing that is no regular file is even opened.
    if name in ("/dev/zero", "/dev/null", "pipe"):
        assert "no regular file" in done.stderr
    assert ntp_gltf(path, "--root", "/", timeout=20).returncode == 3


def test_a_uri_that_no_file_name_can_be(tmp_path):
    """JSON can hold half a surrogate pair, which no encoding of names can."""
    place = save(model(), tmp_path, "files")
    place.write_text(place.read_text().replace("brick_n.png", "\\ud800.png"))
    done = ntp_gltf(place)
    assert done.returncode == 3 and "Traceback" not in done.stderr
    assert "is not a file name" in done.stderr


def test_the_file_itself_is_a_regular_one(tmp_path):
    os.mkfifo(tmp_path / "model.glb")
    done = ntp_gltf(tmp_path / "model.glb", "/dev/zero", timeout=20)
    assert done.returncode == 3 and done.stderr.count("is no regular file") == 2


@pytest.mark.parametrize("what", ["image", "buffer"])
def test_size_limit(tmp_path, what):
    path = hostile(tmp_path, "huge", what)
    with open(path.parent / "huge", "wb") as huge:
        huge.truncate(1 << 40)
    done = ntp_gltf(path, timeout=20)
    assert done.returncode == 3 and "1,099,511,627,776 bytes" in done.stderr
    good = save(model(GOOD), tmp_path)
    size = good.stat().st_size
    assert gltf.check(good, max_bytes=size)["files"][0]["status"] == "ok"
    (entry,) = gltf.check(good, max_bytes=size - 1)["files"]
    assert entry["status"] == "unreadable" and "max_bytes (--max-bytes)" in entry["message"]
    for wrong in ("0", "-1", "x"):
        assert ntp_gltf(good, "--max-bytes", wrong).returncode == 2


def test_a_link_that_leads_out_is_not_followed(tmp_path):
    """Neither read nor rewritten, nor are its bytes copied to the output."""
    victim = tmp_path / "victim.png"
    victim.write_bytes(png_bytes(BAD))
    path = hostile(tmp_path, "link.png")
    (path.parent / "link.png").symlink_to("../victim.png")
    before = everything(tmp_path)
    assert "outside" in gltf.check(path)["files"][0]["message"]
    for root in ([], ["--root", tmp_path]):
        done = ntp_gltf(path, "--in-place", *root)
        assert done.returncode == 3 and "out" in done.stderr
        assert everything(tmp_path) == before
    assert gltf.check(path, root=tmp_path)["files"][0]["status"] == "ok"
    # A folder on the way is a link.
    path.write_text(path.read_text().replace('"link.png"', '"up/victim.png"'))
    (path.parent / "up").symlink_to("..")
    before = everything(tmp_path)
    for root in ([], ["--root", tmp_path]):
        assert ntp_gltf(path, "--in-place", *root).returncode == 3
        assert everything(tmp_path) == before


@pytest.mark.parametrize("target", ["../secret", "/etc/passwd"])
def test_a_linked_buffer_is_not_copied(tmp_path, target):
    (tmp_path / "secret").write_bytes(b"secret" * 100)
    for what in ("geometry.bin", "color 2.png"):
        folder = tmp_path / what
        folder.mkdir()
        path = save(model(), folder, "files")
        (folder / what).unlink()
        (folder / what).symlink_to(target)
        (tmp_path / "secret").replace(folder / "../secret")
        done = ntp_gltf(path, "-o", tmp_path / "out")
        assert done.returncode == 3 and "outside" in done.stderr and "written" not in done.stdout
        assert not (tmp_path / "out").exists()


def test_links_within_the_folder(tmp_path):
    path = hostile(tmp_path, "link.png")
    (path.parent / "link.png").symlink_to("brick_n.png")
    assert gltf.check(path)["files"][0]["status"] == "ok"
    gltf.clean(path, method="derive")
    assert (path.parent / "link.png").is_symlink()
    assert np.array_equal(read_png(path.parent / "brick_n.png")[0], GOOD)
    # An image that is a color texture under another name is not a normals texture alone.
    for name in ("./color%201.png", "link2.png", "%63olor%201.png"):
        path = hostile(tmp_path, name)
        if not (path.parent / "link2.png").exists():
            (path.parent / "link2.png").symlink_to("color 1.png")
        (path.parent / "color 1.png").write_bytes(png_bytes(BAD))
        before = everything(path.parent)
        (entry,) = gltf.clean(path, method="derive")["files"]
        assert entry["status"] == "skipped" and "same place" in entry["message"]
        assert everything(path.parent) == before


def test_where_a_file_lies_is_asked_of_the_open_file(tmp_path, monkeypatch):
    """The name is exchanged between looking and opening: what was opened decides."""
    root, other = tmp_path / "root", tmp_path / "other"
    root.mkdir(), other.mkdir()
    (root / "x").write_bytes(b"good")
    (other / "x").write_bytes(b"secret")
    real = os.open

    def swapped(path, flags, *more, **named):
        if str(path).endswith("x"):
            (root / "x").unlink()
            (root / "x").symlink_to("../other/x")
            descriptor = real(path, flags, *more, **named)
            (root / "x").unlink()
            (root / "x").write_bytes(b"good")
            return descriptor
        return real(path, flags, *more, **named)

    monkeypatch.setattr(os, "open", swapped)
    with pytest.raises(OSError, match="outside"):
        _named.read_named(root / "x", root)
    monkeypatch.undo()
    assert _named.read_named(root / "x", root)[0] == b"good"


@pytest.mark.parametrize("how", ["glb", "files"])
def test_a_file_that_changed_meanwhile_stays(tmp_path, how, monkeypatch):
    path = save(model(), tmp_path, how)
    changed = path if how == "glb" else tmp_path / "brick_n.png"
    real = _clean.plan

    def plan(*args, **named):
        changed.write_bytes(changed.read_bytes() + b"saved meanwhile")
        return real(*args, **named)

    monkeypatch.setattr(_clean, "plan", plan)
    with pytest.raises(OSError, match="changed meanwhile"):
        gltf.clean(path)
    assert changed.read_bytes().endswith(b"saved meanwhile")


def test_extended_attributes_stay(tmp_path):
    path = save(model(), tmp_path)
    path.chmod(0o640)
    try:
        os.setxattr(path, "user.note", b"mine")
    except OSError:
        pytest.skip("this file system has no extended attributes")
    gltf.clean(path)
    assert os.getxattr(path, "user.note") == b"mine" and path.stat().st_mode & 0o777 == 0o640


def test_memory_that_ends(tmp_path):
    path = save(model(), tmp_path)
    limit = "import resource; resource.setrlimit(resource.RLIMIT_AS, (1 << 29, 1 << 29));"
    code = limit + "from normaltexture.gltf import _cli; raise SystemExit(_cli.main())"
    with open(tmp_path / "big.glb", "wb") as file:
        file.truncate((1 << 30) - 1)
    command = [sys.executable, "-c", code, tmp_path / "big.glb", path]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 3 and "not enough memory" in done.stderr
    assert "Traceback" not in done.stderr


# ------------------------------------------------------------ what glTF says about types


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


def test_missing_files_leave_no_copy(tmp_path):
    for name in ("brick_n.png", "color 1.png", "geometry.bin"):
        path = save(model(), tmp_path, "files")
        (tmp_path / name).unlink()
        for output in ("out", "copy.gltf"):
            done = ntp_gltf(path, "-o", tmp_path / output)
            assert done.returncode == 3 and name in done.stderr, (name, output)
            assert "written" not in done.stdout and not (tmp_path / output).exists()
            told = json.loads(ntp_gltf(path, "-o", tmp_path / output, "--format", "json").stdout)
            assert not told["outputs"] and told["summary"]["failed"]


def test_wrong_outputs_are_wrong_use(tmp_path):
    path = save(model(), tmp_path, "files")
    before = everything(tmp_path)
    done = ntp_gltf(path, "-o", tmp_path / "y.glb")
    assert done.returncode == 2 and ".gltf" in done.stderr and "Traceback" not in done.stderr
    done = ntp_gltf(path, "-o", path)
    assert done.returncode == 2 and "is the input" in done.stderr
    assert everything(tmp_path) == before


def test_messages_name_the_file(tmp_path):
    made = model()
    made.images[1] = ("n.ktx2", NOT_READ, "image/ktx2")
    path = save(made, tmp_path)
    done = ntp_gltf(path, "-o", tmp_path / "copy.glb")
    assert f"{path}, image 1: a KTX2 texture of ASTC" in done.stderr
    assert str(path) in ntp_gltf(path).stdout


def test_output_of_another_kind(tmp_path):
    path = save(model(), tmp_path)
    with pytest.raises(ValueError, match=r"\.glb"):
        gltf.clean(path, tmp_path / "copy.gltf")


# -------------------------------------------------------------------------- editing text


def test_editor_keeps_every_other_byte():
    text = '\n{ "a" : [1, {"b":\t2.50}, "x\\u00e9"],"c":{} , "d":{"e":1e5} }  '
    editor = Editor(text)
    editor.set(["a", 1, "b"], 7)
    editor.set(["c", "new"], "\u00e9\n")
    editor.set(["d", "f"], [1])
    expected = text.replace("2.50", "7").replace("{}", '{"new":"\u00e9\\n"}')
    assert editor.apply() == expected.replace('{"e"', '{"f":[1],"e"')
    assert Editor(text).apply() == text
    with pytest.raises(KeyError):
        Editor(text).set(["nothing", "here"], 1)


def test_editor_agrees_with_json():
    rng = np.random.default_rng(3)

    def value(depth):
        kind = int(rng.integers(0, 6 if depth else 4))
        if kind == 4:
            return [value(depth - 1) for _ in range(int(rng.integers(0, 4)))]
        if kind == 5:
            return {f'k"{i}\\': value(depth - 1) for i in range(int(rng.integers(0, 4)))}
        return [None, 1.5, "\u2603]}{[,", True][kind]

    def places(node, path=()):
        if not isinstance(node, dict | list):
            return
        for key, child in node.items() if isinstance(node, dict) else enumerate(node):
            yield (*path, key)
            yield from places(child, (*path, key))

    for _ in range(60):
        document = {"root": value(4), "end": 1}
        paths = list(places(document))
        path = paths[int(rng.integers(0, len(paths)))]
        text = json.dumps(document, indent=int(rng.integers(0, 3)) or None)
        editor = Editor(text)
        editor.set(path, 12345)
        node = document
        for key in path[:-1]:
            node = node[key]
        node[path[-1]] = 12345
        assert json.loads(editor.apply()) == document


# ----------------------------------------------------------------------- command line


def ntp_gltf(*args, **options):
    command = [sys.executable, "-m", "normaltexture.gltf._cli", *map(str, args)]
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


def test_command_line(tmp_path):
    bad, good = save(model(), tmp_path, name="bad"), save(model(GOOD), tmp_path, name="good")
    (tmp_path / "deep").mkdir()
    save(model(), tmp_path / "deep", "files")
    done = ntp_gltf(bad, good)
    assert done.returncode == 1 and "error   NT001" in done.stdout and "well formed" in done.stdout
    assert ntp_gltf(good).returncode == 0 and not ntp_gltf("-q", good).stdout
    assert ntp_gltf(bad, "--fail-on", "never").returncode == 0
    assert ntp_gltf(bad, tmp_path / "missing.glb").returncode == 3
    assert len(json.loads(ntp_gltf(tmp_path, "--format", "json").stdout)["files"]) == 2
    found = json.loads(ntp_gltf("-r", tmp_path, "--format", "json").stdout)["files"]
    assert [entry["path"] for entry in found] == sorted(entry["path"] for entry in found)
    assert len(found) == 3
    sarif = json.loads(ntp_gltf(bad, "--format", "sarif").stdout)
    assert sarif["runs"][0]["results"][0]["ruleId"] == "NT001"
    assert ntp_gltf(bad, "--format", "github").stdout.startswith("::error file=")
    for wrong in ([], ["--frob", bad], [bad, good, "-o", "x.glb"], [bad, "-n"], [""]):
        assert ntp_gltf(*wrong, cwd=tmp_path).returncode == 2, wrong
    assert ntp_gltf("--help").returncode == 0


def test_no_file_is_a_failure(tmp_path, capsys):
    (tmp_path / "deep").mkdir()
    for how in ([], ["--in-place"], ["-o", str(tmp_path / "out")]):
        assert _cli.main([str(tmp_path), *how]) == 3
        assert "no glTF file found; -r looks below" in capsys.readouterr().err
        assert _cli.main([str(tmp_path), *how, "--allow-empty"]) == 0
        assert not capsys.readouterr().err
    assert _cli.main(["-r", str(tmp_path)]) == 3
    assert capsys.readouterr().err == "ntp: no glTF file found\n"
    # A model without normals textures was looked at; one of which no image is read was not.
    plain, packed = model(slot="emissiveTexture"), model()
    assert _cli.main([str(save(plain, tmp_path, name="plain"))]) == 0
    packed.images[1] = ("n.ktx2", NOT_READ, "image/ktx2")
    path = str(save(packed, tmp_path, name="packed"))
    assert _cli.main([path]) == 3 and "of 1 image, none" in capsys.readouterr().err
    assert _cli.main([path, "--allow-empty", "--fail-on", "never"]) == 0


def test_limits_are_those_of_the_check(tmp_path, capsys):
    """--policy and --max-angle: checking, and judging what is left in a copy."""
    path = str(save(model(), tmp_path))

    def level(*options):
        code = _cli.main([path, "--format", "json", *options])
        (entry,) = json.loads(capsys.readouterr().out)["files"]
        return code, ids(entry)["NT001"]

    assert level() == (1, "error")
    assert level("--max-angle", "89") == (0, "info")
    assert level("--max-angle", "89", "--policy", "strict") == (1, "error")
    assert level("--policy", "strict", "--max-fail", "99") == (0, "warning")


def test_command_line_cleans(tmp_path):
    bad = save(model(), tmp_path, name="bad")
    (tmp_path / "deep").mkdir()
    save(model(), tmp_path / "deep", "files", "other")
    done = ntp_gltf("bad.glb", "-o", "copy.glb", "-n", cwd=tmp_path)
    assert done.returncode == 0 and not (tmp_path / "copy.glb").exists()
    assert "would be written" in done.stdout
    done = ntp_gltf("-r", ".", "-o", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "deep" / "geometry.bin").exists()
    assert ntp_gltf("-r", tmp_path / "out").returncode == 0
    report = json.loads(ntp_gltf(bad, "--in-place", "--format", "json").stdout)
    assert report["summary"]["written"] == 1 and ntp_gltf(bad).returncode == 0
    assert ntp_gltf(tmp_path / "none.glb", "--in-place").returncode == 3
    assert nt.check(bad.with_name("nothing.png")).files[0].status == "unreadable"


def schema():
    """Of docs/schema/gltf-1.json, with the one that it refers to."""
    read = {
        name: json.loads((ROOT / "docs" / "schema" / name).read_text(encoding="utf-8"))
        for name in ("gltf-1.json", "check-1.json")
    }
    pairs = [(name, Resource.from_contents(body)) for name, body in read.items()]
    Draft202012Validator.check_schema(read["gltf-1.json"])
    return Draft202012Validator(read["gltf-1.json"], registry=Registry().with_resources(pairs))


def test_json_is_as_the_schema_says(tmp_path):
    """Of every kind of entry: clean, damaged, refused, skipped, unreadable, and lost images."""
    made = {"bad": model(), "good": model(GOOD), "xy": model(GOOD)}
    made["photo"], made["heights"] = model(textures.photograph()), model(textures.heights())
    made["shared"], made["gone"], made["ktx"] = model(GOOD), model(), model()
    made["shared"].materials[1]["emissiveTexture"] = {"index": 1}
    made["ktx"].textures[1]["extensions"] = {"KHR_texture_basisu": {"source": 3}}
    made["ktx"].images.append(("n.ktx2", NOT_READ, "image/ktx2"))
    for name, one in made.items():
        save(one, tmp_path / name, "files") if name == "gone" else save(one, tmp_path, name=name)
    next((tmp_path / "gone").glob("brick_n*")).unlink()
    (tmp_path / "broken.glb").write_bytes(b"no glTF")
    validator = schema()

    def states(*args):
        done = ntp_gltf("-r", ".", "--format", "json", *args, cwd=tmp_path)
        assert done.returncode == 3 and "broken.glb" in done.stderr + done.stdout
        told = json.loads(done.stdout)
        validator.validate(told)
        assert told["summary"]["files"] == len(told["files"])
        return told, {entry["status"] for entry in told["files"]}

    assert states()[1] == {"ok", "skipped", "unreadable"}
    told, found = states("-o", "out", "-n")
    assert found == {"ok", "skipped", "refused", "unreadable"} and told["outputs"]
    assert told["summary"]["failed"] == 2 and told["summary"]["refused"] == 2
    assert not any("--type" in entry["message"] for entry in told["files"] if entry["message"])
    # The schema is no rubber stamp.
    for spoil in (
        lambda entry: entry.pop("uses"),
        lambda entry: entry.update(storage="web"),
        lambda entry: entry.update(written="yes"),
        lambda entry: entry.pop("angle_deg"),
    ):
        wrong = json.loads(json.dumps(told))
        spoil(next(entry for entry in wrong["files"] if entry["status"] == "ok"))
        assert not validator.is_valid(wrong)
