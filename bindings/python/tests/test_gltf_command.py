# SPDX-License-Identifier: MIT
"""`ntp gltf` on the command line, its JSON, and the edits of the text."""

import json

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from referencing import Registry, Resource

import normaltexture as nt
from normaltexture.gltf import _cli
from normaltexture.gltf._spans import Editor
from pysupport import ROOT
from pysupport.gltf_models import GOOD, NOT_READ, ids, model, ntp_gltf, save
from support import textures


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
