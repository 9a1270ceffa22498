# SPDX-License-Identifier: MIT
"""normaltexture.report: the page, hostile names, pictures, the command line."""

import base64
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from html.parser import HTMLParser

import numpy as np
import pytest

from normaltexture import _program, report
from normaltexture.report import _cli, _page, _pictures
from pysupport import ROOT
from pysupport.reports import BAD, GOOD, HOSTILE, ntp_report
from support import textures
from support.pngs import read_png, write_png

VOID = {"meta", "img", "input", "link", "br", "line", "rect", "wbr"}


class Page(HTMLParser):
    """Tags with attributes, the text, and whether they are nested as they should be."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.open, self.words, self.scripts = [], [], [], []
        self.feed(text)
        assert not self.open, self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("script", "style"):
            self.scripts.append(data)
        else:
            self.words.append(data)


def test_page_is_self_contained_and_unharmed_by_names(folder):
    found = report.check_json([folder])
    text = report.build(found, title="<script>alert(1)</script>")
    page = Page(text)
    for tag, attrs in page.tags:
        for key, value in attrs.items():
            assert not key.startswith("on"), (tag, attrs)
            if key in ("src", "href", "action", "srcset"):
                assert value.startswith(("data:image/png;base64,", "#")), (tag, value)
    assert [tag for tag, _ in page.tags].count("script") == 1
    assert "onerror" not in {key for _, attrs in page.tags for key in attrs}
    words = "".join(page.words)
    assert HOSTILE in words and "{{7*7}}" in words and "<script>alert(1)</script>" in words
    assert "\u202e" not in text and "\\u202e" in words and "\\n_n.png" in words
    policy = next(a["content"] for t, a in page.tags if a.get("http-equiv"))
    assert "default-src 'none'" in policy and "unsafe" not in policy
    assert "http" not in text.partition("<body>")[2].replace("http-equiv", "")
    assert text.encode() == report.build(found, title="<script>alert(1)</script>").encode()


def judged(name, levels=(), *, fail=0, mean=0.0, over=0):
    """What `ntp check` says about a texture of 1,000 texels, with the harm that it does."""
    kind = {"texels": fail, "over": over, "mean": mean, "p99": 2 * mean, "max": 3 * mean}
    none = dict.fromkeys(kind, 0)
    return {
        "path": name, "status": "ok", "message": None, "type": "standard", "confidence": 1,
        "reasons": [], "y": "up", "y_confidence": 1, "width": 40, "height": 25, "texels": 1000,
        "unused": 0, "bit_depth": 8, "channels": 3, "format": "jpeg", "counts": True,
        "fail": {"neighbor": fail, "rounded": fail, "exact": 1000},
        "angle_deg": {"mean": mean, "p99": 2 * mean, "max": 3 * mean},
        "harm": {"max_angle": 5, "length": kind, "xy": none, "z_negative": none},
        "length": {"min": 1, "mean": 1, "max": 1},
        "findings": [
            {"id": "NT001", "level": level, "message": "m", "count": fail} for level in levels
        ],
    }  # fmt: skip


def test_worst_first_and_why():
    """No figure stands there without the rule that made it a warning, an error or nothing."""
    files = [
        judged("fine_n.png"),
        judged("jpeg_n.jpg", fail=371, mean=0.8),
        judged("some_n.png", ["warning"], fail=10, mean=1, over=5),
        judged("bad_n.png", ["error"], fail=100, mean=9, over=100),
        judged("worse_n.png", ["info", "error"], fail=90, mean=30, over=90),
        judged("worst_n.png", ["error"], fail=200, mean=9, over=200),
        {
            "path": "gone_n.png",
            "status": "unreadable",
            "message": "m",
            "type": None,
            "findings": [],
        },
    ]
    rule = {"policy": "harm", "verdict": "neighbor", "max_angle": 5, "max_fail": 2}
    found = {"tool": {"name": "ntp", "version": "0.2.0"}, "files": files, "summary": {"rule": rule}}
    text = report.build(found, limit=0)
    page = Page(text)
    order = [a["data-sort"] for tag, a in page.tags if tag == "th" and "data-sort" in a]
    assert order == [
        "gone_n.png", "worst_n.png", "bad_n.png", "worse_n.png", "some_n.png", "jpeg_n.jpg",
        "fine_n.png",
    ]  # fmt: skip
    assert re.findall('<h3 id="[^"]*"><bdi class="folder"></bdi><bdi>([a-z]+)_', text) == [
        "gone", "worst", "bad", "worse", "some", "jpeg", "fine",
    ]  # fmt: skip
    words = " ".join("".join(page.words).split())
    assert "off by more than 5°. If more than 2 % of the used texels are, that is an error" in words
    assert (
        "37.1 % of the used texels fail the test neighbor, by 0.8° on average and 2.4° at most. 0 % of "
        "the used texels are off by more than 5°, which is what can be seen. That is too little "
        "for a warning." in words
    )
    assert words.count("too little for a warning") == 1 and "Fail neighbor" in words
    strict = {**found, "summary": {"rule": {**rule, "policy": "strict", "verdict": "exact"}}}
    words = " ".join("".join(Page(report.build(strict, limit=0)).words).split())
    assert "fail the test exact. A share of more than 2 % is an error" in words
    assert "Fail exact" in words and "100 % of the used texels fail the test exact" in words
    old = {**found, "summary": {}}  # of an older program
    for file in files[:-1]:
        del file["harm"]
    words = "".join(Page(report.build(old, limit=0)).words)
    assert "Off by" not in words and "37.1 % of the used texels fail the test neighbor" in words


def test_what_only_content_suggests_is_not_called_well_formed():
    """Nor is a note about lengths: the badge has the words of `ntp check`."""
    guess = judged("guess.png", ["info"], fail=900, mean=9, over=900)
    guess["findings"][0]["level_if_named"] = "error"
    atlas = {**judged("atlas_n.png", ["info"], fail=510, mean=0.1), "unused": 500}
    atlas["used"] = {"texels": 500, "fail": {"neighbor": 10, "rounded": 10, "exact": 500}}
    files = [judged("fine_n.png"), atlas, guess, judged("bad_n.png", ["warning"], fail=1)]
    rule = {"policy": "harm", "verdict": "neighbor", "max_angle": 5, "max_fail": 2}
    found = {"tool": {"name": "ntp", "version": "0.2.0"}, "files": files, "summary": {"rule": rule}}
    text = report.build(found, limit=0)
    rows = [" ".join(row.split()) for row in re.findall("<tr data-state=.*?</tr>", text, re.DOTALL)]
    names = ("bad_n", "guess", "atlas_n", "fine_n")
    badges = ("warning", "possible error", "no visible errors", "well formed")
    for row, name, badge in zip(rows, names, badges, strict=True):
        assert f'data-sort="{name}.png"' in row and f">{badge}</span>" in row
    assert "<code" in rows[1] and ">2 %</td>" in rows[2]  # 10 of 500 used texels
    words = " ".join("".join(Page(text).words).split())
    assert words.count("only noted, because the name is not that of a normals texture") == 1


def test_names_break_between_their_parts():
    broken = str(_page._breakable("a/b_c/BrickWall_1K-NormalGL.v2 <b>.png")).split("<wbr>")
    assert broken == [
        "a/",
        "b_",
        "c/",
        "Brick",
        "Wall_",
        "1K-",
        "Normal",
        "GL.",
        "v",
        "2 ",
        "&lt;b&gt;.",
        "png",
    ]
    assert str(_page._breakable("")) == ""


def test_page_is_accessible(folder):
    page = Page(report.build(report.check_json([folder])))
    names = [tag for tag, _ in page.tags]
    assert dict(page.tags)["html"] == {"lang": "en"} and names.count("h1") == 1
    assert all("alt" in attrs for tag, attrs in page.tags if tag == "img")
    assert all(attrs.get("scope") for tag, attrs in page.tags if tag == "th")
    ids = [attrs["id"] for _, attrs in page.tags if "id" in attrs]
    assert len(ids) == len(set(ids))
    for _, attrs in page.tags:
        for key in ("aria-labelledby", "aria-describedby"):
            assert attrs.get(key, ids[0]) in ids
        if attrs.get("href", "").startswith("#"):
            assert attrs["href"][1:] in ids
    for tag, attrs in page.tags:
        if tag == "input" and attrs["type"] == "range":
            assert attrs["aria-label"]
        if tag == "svg":
            assert attrs["role"] == "img" and attrs["aria-label"]


def luminance(color):
    parts = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return float(np.dot(linear, [0.2126, 0.7152, 0.0722]))


def test_colors_have_contrast():
    """At least 4.5 to 1 for every text on its background, light and dark (WCAG 2 AA)."""
    style = report._page._template("page.css")
    blocks = re.findall(r":root \{(.*?)\}", style, re.DOTALL)
    assert len(blocks) == 2
    for block in blocks:
        colors = dict(re.findall(r"--([a-z-]+): (#[0-9a-f]{6})", block))
        pairs = [("text", "back"), ("text", "card"), ("text", "hover"), ("muted", "back")]
        pairs += [("muted", "card"), ("muted", "hover"), ("link", "card"), ("link", "hover")]
        pairs += [(name, f"{name}-back") for name in ("ok", "warning", "error", "info")]
        for front, back in pairs:
            light, dark = sorted([luminance(colors[front]), luminance(colors[back])])[::-1]
            assert (light + 0.05) / (dark + 0.05) >= 4.5, (front, back)


# ------------------------------------------------------------------------------- pictures


def decoded(uri, tmp_path):
    path = tmp_path / "picture.png"
    path.write_bytes(base64.b64decode(uri.partition(",")[2]))
    return read_png(path)[0]


def test_pictures(tmp_path):
    entry = {"type": "standard", "format": "png"}
    drawn = report.draw(BAD, entry)
    assert np.array_equal(decoded(drawn.texture, tmp_path), BAD)
    assert np.array_equal(decoded(drawn.cleaned, tmp_path), GOOD)
    assert drawn.changed == (BAD != GOOD).any(axis=2).sum()
    heat = decoded(drawn.heatmap, tmp_path).astype(int)
    colored = np.ptp(heat, axis=2) > 0
    lengths = np.sqrt((((2.0 * BAD - 255) / 255) ** 2).sum(axis=2))
    expected = np.histogram(lengths, 64, (0, 2))[0]
    assert list(drawn.lengths) == expected.tolist()
    assert colored.any() and not colored[np.abs(lengths - 1) < 0.01].any()
    assert report.draw(GOOD, entry).cleaned == "" and report.draw(GOOD, entry).changed == 0
    plain = report.draw(textures.heights(), {"type": "height", "format": "png"})
    assert plain.texture and not plain.heatmap and not plain.lit


@pytest.mark.parametrize("shape", [(300, 200), (33, 500), (1, 1), (7, 1000)])
def test_one_bad_texel_shows(shape, tmp_path):
    image = np.full((*shape, 3), (128, 128, 255), np.uint8)
    image[shape[0] // 2, shape[1] - 1] = 128, 128, 100
    drawn = report.draw(image, {"type": "standard", "format": "png"}, size=64)
    heat = decoded(drawn.heatmap, tmp_path).astype(int)
    assert max(heat.shape[:2]) <= 64 and heat.shape[:2] == (drawn.height, drawn.width)
    assert (np.ptp(heat, axis=2) > 50).sum() == 1


def test_averages():
    rng = np.random.default_rng(4)
    for shape in ((50, 70, 3), (64, 64), (13, 200, 3)):
        image = rng.integers(0, 65536, shape).astype(np.uint16)
        small = _pictures.average(image, 20)
        factor = -(-max(shape[:2]) // 20)
        for y in range(small.shape[0]):
            for x in range(small.shape[1]):
                block = image[y * factor : (y + 1) * factor, x * factor : (x + 1) * factor]
                mean = block.reshape(-1, *shape[2:]).mean(axis=0) / 257
                assert np.all(np.abs(small[y, x] - mean) <= 0.500001)


def test_png_is_valid(tmp_path):
    rng = np.random.default_rng(4)
    for shape in ((5, 7), (4, 9, 3), (6, 3, 4)):
        image = rng.integers(0, 256, shape).astype(np.uint8)
        (tmp_path / "a.png").write_bytes(_pictures.png(image))
        assert np.array_equal(read_png(tmp_path / "a.png")[0].reshape(shape), image)


def test_limits(folder):
    found = report.check_json([folder])
    text = report.build(found, limit=1, size=32)
    assert text.count("Pictures are limited to 1 files.") == 5
    assert report.build(found, max_texels=100).count("Too large for pictures.") == 6
    shutil.rmtree(folder)
    assert "No pictures: " in report.build(found)


@pytest.mark.parametrize(
    "name", ["/dev/zero", "pipe", "../secret_n.png", "link_n.png", "up/secret_n.png"]
)
def test_paths_in_a_json_are_not_trusted(folder, tmp_path, name):
    """A JSON that somebody sent names devices, pipes, and files elsewhere."""
    write_png(tmp_path / "secret_n.png", BAD)
    os.mkfifo(folder / "pipe")
    (folder / "link_n.png").symlink_to("../secret_n.png")
    (folder / "up").symlink_to("..")
    found = report.check_json([folder / "bad_n.png"])
    found["files"][0]["path"] = name
    text = json.dumps(found)
    options = {"input": text, "cwd": folder, "timeout": 30}
    done = ntp_report("--from-json", "-", "-o", "-", **options)
    assert done.returncode == 1, done.stderr
    kept = "no regular file" if name in ("/dev/zero", "pipe") else "lies outside of"
    assert kept in done.stdout and "data:image/png" not in done.stdout
    sarif = ntp_report("--from-json", "-", "--format", "sarif", **options)
    again = ntp_report("--from-json", "-", "--format", "sarif", **options)
    assert sarif.returncode == 1 and sarif.stdout == again.stdout
    if "secret" in name or "link" in name:
        opened = ntp_report("--from-json", "-", "-o", "-", "--root", tmp_path, **options)
        assert "data:image/png" in opened.stdout
        other = ntp_report("--from-json", "-", "--format", "sarif", "--root", tmp_path, **options)
        assert other.stdout != sarif.stdout  # the content is part of the fingerprint


def test_few_texels_are_held_at_once():
    budget, used, most = _page._Budget(10), 0, 0
    lock = threading.Lock()

    def work(texels):
        nonlocal used, most
        with budget.take(texels):
            with lock:
                used += texels
                most = max(most, used if texels <= 10 else 0)
                assert texels <= 10 or used == texels  # larger than the budget: alone
            time.sleep(0.002)
            with lock:
                used -= texels

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(work, [3, 4, 25, 10, 1, 1, 1, 12, 9, 2] * 4))
    assert used == 0 and 0 < most <= 10


# -------------------------------------------------------------------------- command line


def test_command_line(folder, tmp_path):
    page = tmp_path / "report.html"
    done = ntp_report(folder, "-o", page)
    assert done.returncode == 3 and "broken_n.png" in done.stderr and page.exists()
    (folder / "broken_n.png").unlink()
    assert ntp_report(folder, "-o", page, "-q").returncode == 1
    assert ntp_report(folder, "-o", page, "--fail-on", "never").returncode == 0
    assert ntp_report(folder / "good_n.png", "-o", page).returncode == 0
    standard = ntp_report(folder / "good_n.png", "-o", "-")
    assert Page(standard.stdout) and standard.stdout == page.read_text(encoding="utf-8")
    sarif = ntp_report(folder, "--format", "sarif")
    assert sarif.returncode == 1 and json.loads(sarif.stdout)["version"] == "2.1.0"
    checked = ntp_report(folder, "--format", "json").stdout
    again = ntp_report("--from-json", "-", "--format", "sarif", "--root", "/", input=checked)
    assert again.stdout == sarif.stdout and again.returncode == 1
    for wrong in (
        [],
        [folder],
        [folder, "-o", page, "--size", "1"],
        [folder, "--from-json", "-", "-o", page],
        [folder, "-o", page, "--y", "left"],
        [folder, "-o", page, "--max-fail", "1000"],
    ):
        done = ntp_report(*wrong, input="{}")
        assert done.returncode == 2 and done.stderr.startswith("ntp: "), wrong
    for bad in (
        "",
        "[]",
        "{}",
        '{"schema_version": 2, "files": []}',
        '{"schema_version":1,"files":[{}]}',
    ):
        assert ntp_report("--from-json", "-", "-o", page, input=bad).returncode == 3
    assert ntp_report(folder, "-o", tmp_path / "none" / "r.html").returncode == 3
    assert "--from-json" in ntp_report("--help").stdout


def test_nothing_checked_is_a_failure(tmp_path, capsys):
    """As of `ntp check`, which is run beside it."""

    def both(*args):
        told = []
        for work in (lambda *words: ntp_check(*words), in_process):
            code = work(*map(str, args))
            told.append((code, capsys.readouterr().err))
        return told

    def in_process(*args):
        return _cli.main([*args, "--format", "json"])

    def ntp_check(*args):
        done = subprocess.run(
            [_program.program(), "check", *args], capture_output=True, text=True, check=False
        )
        print(done.stderr, end="", file=sys.stderr)
        return done.returncode

    (tmp_path / "below").mkdir()
    for checked, reported in (both(tmp_path), both("-r", tmp_path)):
        assert checked == reported and reported[0] == 3 and "no image found" in reported[1]
    assert both(tmp_path, "--allow-empty") == [(0, "")] * 2
    write_png(tmp_path / "photo.png", textures.photograph())
    checked, reported = both(tmp_path)
    assert checked == reported and reported[0] == 3 and "of 1 image, none is" in reported[1]
    assert both(tmp_path, "--allow-empty") == [(0, "")] * 2
    assert [code for code, _ in both(tmp_path / "photo.png")] == [1, 1]  # named: judged
    (tmp_path / "broken_n.png").write_bytes(b"")
    assert [code for code, _ in both(tmp_path, "--allow-empty")] == [3, 3]


@pytest.mark.parametrize("make", ["harm", "length"])
def test_limits_are_those_of_the_check(make, tmp_path, capsys):
    """--policy and --max-angle reach it: a limit on either side of what the texture shows."""
    off = textures.wrong_blue(GOOD, 0.004) if make == "harm" else textures.wrong_blue(GOOD, 0.1)
    write_png(tmp_path / "a_n.png", off)

    def level(*options):
        code = _cli.main([str(tmp_path / "a_n.png"), "--format", "json", *options])
        (file,) = json.loads(capsys.readouterr().out)["files"]
        found = {found["id"]: found["level"] for found in file["findings"]}
        return code, found["NT001"]

    if make == "harm":  # few texels of small errors: seen by the strict policy alone
        assert level("--policy", "strict", "--max-fail", "0") == (1, "error")
        assert level("--max-fail", "50")[0] == 0
    else:
        assert level() == (1, "error")
        assert level("--max-angle", "89") == (0, "info")
        assert level("--max-angle", "89", "--policy", "strict") == (1, "error")


def test_commands_of_the_page_about_ci(folder, tmp_path):
    """As they stand, under `sh -e`: the page is there also where the build stops."""
    page = (ROOT / "docs" / "continuous-integration.md").read_text(encoding="utf-8")
    script = re.search(r"## Anywhere else\n\n```sh\n(.*?)```", page, re.DOTALL)[1]
    programs = os.path.dirname(sys.executable)
    env = os.environ | {"PATH": programs + os.pathsep + os.environ["PATH"]}
    for bad, code in ((True, 1), (False, 0)):
        for name in ("broken_n.png", *([] if bad else ["bad_n.png", HOSTILE])):
            (folder / name).unlink(missing_ok=True)
        done = subprocess.run(["sh", "-ec", script], cwd=tmp_path, env=env, check=False)
        assert done.returncode == code
        for name in ("report.html", "ntp.sarif", "ntp.json"):
            (tmp_path / name).unlink()


def test_beside_ntp(folder, tmp_path):
    """`ntp report` finds the program that the package installs."""
    beside = shutil.which("ntp", path=os.path.dirname(sys.executable))
    if beside is None:
        pytest.fail("the wheel's ntp is not beside Python")
    done = subprocess.run(
        [beside, "report", folder / "good_n.png", "-o", tmp_path / "r.html"], check=False
    )
    assert done.returncode == 0 and (tmp_path / "r.html").exists()
    assert subprocess.run([beside, "gltf"], check=False, capture_output=True).returncode == 2
