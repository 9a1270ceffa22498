# SPDX-License-Identifier: MIT
"""normaltexture.report: SARIF, and annotations of GitHub."""

import json
import re

import jsonschema
import pytest

from normaltexture import report
from pysupport import sarif_schema
from pysupport.reports import GOOD, HOSTILE
from support import textures
from support.pngs import write_png


def test_sarif(folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    found = report.check_json(["textures"])
    log = json.loads(json.dumps(report.to_sarif(found)))
    sarif_schema.validate(log)
    (run,) = log["runs"]
    rules = run["tool"]["driver"]["rules"]
    results = run["results"]
    assert [rule["id"] for rule in rules] == sorted({rule["id"] for rule in rules})
    for result in results:
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
    uris = [r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] for r in results]
    assert "textures/bad_n.png" in uris and "textures/photo.png" not in uris
    assert all(re.fullmatch(r"[A-Za-z0-9._~/%-]+", uri) for uri in uris)
    by_id = {result["ruleId"]: result for result in results}
    assert by_id["NT000"]["level"] == "error" and not run["invocations"][0]["executionSuccessful"]
    assert {result["level"] for result in results} <= {"error", "warning"}
    noted = report.to_sarif(found, notes=True)["runs"][0]["results"]
    assert any(result["level"] == "note" for result in noted) and len(noted) > len(results)
    prints = [result["partialFingerprints"]["normaltexture/v1"] for result in noted]
    assert len(set(prints)) == len(prints)
    assert report.to_sarif(report.check_json(["textures"])) == report.to_sarif(found)
    absolute = report.to_sarif(report.check_json([folder]))["runs"][0]["results"][0]
    location = absolute["locations"][0]["physicalLocation"]["artifactLocation"]
    assert location["uri"].startswith("file:///") and "uriBaseId" not in location


def many(count, **more):
    """The JSON of a check with so many errors, and as many warnings before them."""

    def entry(i, level):
        found = {"id": "NT001", "level": level, "message": f"wrong {i}", "count": 1, **more}
        return {"path": f"{level}{i}_n.png", "status": "ok", "message": None, "findings": [found]}

    files = [entry(i, level) for level in ("warning", "error") for i in range(count)]
    return {"schema_version": 1, "tool": {"name": "ntp", "version": "0.1.0"}, "files": files}


def test_sarif_is_as_the_official_schema_says(folder):
    for found in (report.check_json([folder]), many(3)):
        for notes in (False, True):
            sarif_schema.check_officially(report.to_sarif(found, notes=notes))
    wrong = report.to_sarif(many(3))
    wrong["runs"][0]["results"][0]["level"] = "fatal"
    with pytest.raises(jsonschema.ValidationError):
        sarif_schema.check_officially(wrong)


def test_sarif_within_the_limits_of_github(monkeypatch):
    """25,000 results and 25 MB: the gravest stay, and the rest is counted."""
    log = report.to_sarif(many(20_000))
    (run,) = log["runs"]
    levels = [result["level"] for result in run["results"]]
    assert levels == ["error"] * 20_000 + ["warning"] * 5_000
    (notification,) = run["invocations"][0]["toolExecutionNotifications"]
    assert notification["message"]["text"].startswith("15,000 of 40,000 findings are left out")
    sarif_schema.validate(log)
    assert len(json.dumps(log, indent=1)) < 25_000_000
    assert (
        "toolExecutionNotifications" not in report.to_sarif(many(10))["runs"][0]["invocations"][0]
    )
    long = report.to_sarif(many(10_000, message="x\n" * 1500))
    assert 24_900_000 < len(json.dumps(long, indent=1)) < 25_000_000
    kept = long["runs"][0]["results"]
    assert len(kept) < 10_000 and {result["level"] for result in kept} == {"error"}
    told = long["runs"][0]["invocations"][0]["toolExecutionNotifications"][0]["message"]["text"]
    assert told.startswith(f"{20_000 - len(kept):,} of 20,000")
    lines = report.to_github(many(3)).splitlines()
    assert [line.split()[0] for line in lines] == ["::error"] * 3 + ["::warning"] * 3


def test_fingerprints_of_github(folder, monkeypatch):
    """One for each finding; it stays when the file is edited, as ours does not."""
    monkeypatch.chdir(folder.parent)

    def prints():
        results = report.to_sarif(report.check_json(["textures"]), notes=True)["runs"][0]["results"]
        return {
            (r["ruleId"], r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]): r[
                "partialFingerprints"
            ]
            for r in results
        }

    before = prints()
    hashes = [p["primaryLocationLineHash"] for p in before.values()]
    assert all(re.fullmatch("[0-9a-f]{16}:1", text) for text in hashes)
    assert len(set(hashes)) == len(hashes)
    write_png(folder / "bad_n.png", textures.wrong_blue(GOOD, 0.11))
    after, key = prints(), ("NT001", "textures/bad_n.png")
    assert after[key]["primaryLocationLineHash"] == before[key]["primaryLocationLineHash"]
    assert after[key]["normaltexture/v1"] != before[key]["normaltexture/v1"]


@pytest.mark.parametrize(
    "spoil",
    [
        lambda run: run["tool"]["driver"].pop("name"),
        lambda run: run["results"][0].update(ruleID="NT001"),
        lambda run: run["results"][0]["locations"][0].update(region={"startLine": 1}),
        lambda run: run["results"][0].update(message={"txt": "Wrong."}),
    ],
)
def test_wrong_sarif_is_seen_by_both_oracles(folder, spoil):
    log = report.to_sarif(report.check_json([folder]))
    spoil(log["runs"][0])
    with pytest.raises(jsonschema.ValidationError):
        sarif_schema.check_objects(log)
    with pytest.raises(AssertionError):
        sarif_schema.check_properties(log)


def test_names_are_no_links():
    forged = {"path": "a.png", "status": "unreadable", "message": "[a](//b): c [d]", "findings": []}
    tool = {"name": "ntp", "version": "0.1.0"}
    log = report.to_sarif({"tool": tool, "files": [forged]})
    sarif_schema.validate(log)
    message = log["runs"][0]["results"][0]["message"]["text"]
    assert message == r"\[a\](//b): c \[d\]."


def test_github(folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    text = report.to_github(report.check_json(["textures"]))
    lines = text.splitlines()
    levels = [line.split(" ")[0] for line in lines]
    assert levels.count("::error") == 3 and set(levels) <= {"::error", "::warning"}
    form = re.compile(r"::[a-z]+ file=([^,:]*),line=1,title=([^,:]*)%3A [^,:]*::(.*)")
    matches = [form.fullmatch(line) for line in lines]
    assert all(matches)
    names = {match[1].replace("%3A", ":").replace("%2C", ",") for match in matches}
    assert f"textures/{HOSTILE}" in names
    forged = {
        "path": "a\n::error::x,y",
        "status": "unreadable",
        "message": "m\r\n::b",
        "findings": [],
    }
    (line,) = report.to_github({"files": [forged]}).splitlines()
    assert line.startswith("::error file=a%0A%3A%3Aerror%3A%3Ax%2Cy,") and line.endswith(
        "m%0D%0A::b"
    )
