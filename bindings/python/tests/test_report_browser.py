# SPDX-License-Identifier: MIT
"""normaltexture.report: the page in a real browser, on a desk and on a phone."""

import base64
import hashlib
import html
import json
import os
import re
import shutil
import subprocess

import numpy as np
import pytest

from normaltexture import report
from pysupport.reports import BAD
from support.pngs import read_png, write_png

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
needs_chromium = pytest.mark.skipif(
    CHROMIUM is None and not os.environ.get("CI"), reason="Chromium is not installed"
)
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-extensions",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
    "--window-size=1200,1600",
]


def browser(tmp_path, page, *flags, enough=lambda done: True, tries=16):
    """What Chromium did, started again while it fails, hangs, or has not done enough.

    On a busy machine it may end before a page has run its scripts or painted its pictures, so each
    try gives the page twice the time, by the page's own clock.
    """
    for number in range(tries):
        patience = f"--virtual-time-budget={3000 * 2 ** min(number, 6)}"
        profile = tmp_path / f"profile{len(list(tmp_path.iterdir()))}"
        command = [CHROMIUM, *FLAGS, patience, f"--user-data-dir={profile}", *flags]
        home = dict(os.environ, HOME=str(tmp_path))
        try:
            done = subprocess.run(
                [*command, page.as_uri()],
                capture_output=True,
                check=False,
                timeout=300,
                cwd=tmp_path,
                env=home,
            )
        except subprocess.TimeoutExpired as hang:
            print(hang)
            continue
        if done.returncode == 0 and enough(done):
            return done
        print(done.returncode, done.stderr.decode("utf-8", "replace")[-2000:])
    raise AssertionError("Chromium did not do it in any try")


# Runs in the page, allowed by a policy that the test writes; the result is left in the title.
PROBE = """
const log = [];
const table = document.getElementById("table");
const names = () => Array.from(table.tBodies[0].rows).filter(r => !r.hidden)
  .map(r => r.cells[1].textContent.split("/").pop());
const heading = key => Array.from(table.tHead.rows[0].cells).find(c => c.dataset.key === key);
const button = key => heading(key).querySelector("button");
log.push(names());
button("state").click();
log.push([heading("state").getAttribute("aria-sort"), ...names()]);
button("failing").click(); button("failing").click();
log.push([heading("failing").getAttribute("aria-sort"),
          heading("state").getAttribute("aria-sort"), ...names()]);
const find = document.getElementById("find");
find.value = "bad"; find.dispatchEvent(new Event("input"));
log.push([...names(), document.querySelectorAll("article:not([hidden])").length]);
find.value = ""; find.dispatchEvent(new Event("input"));
document.querySelector("[data-state=error]").click();
const figure = document.querySelector(".slider");
const range = figure.querySelector("input");
range.value = 20; range.dispatchEvent(new Event("input"));
const before = figure.querySelector(".before");
const texture = before.src;
figure.querySelector(".swap").click();
const last = [getComputedStyle(before).clipPath, before.src !== texture];
Promise.allSettled(Array.from(document.images, i => i.decode())).then(pictures => {
  log.push([...last, pictures.filter(p => p.status !== "fulfilled").length,
    getComputedStyle(document.body).backgroundColor, document.title]);
  document.documentElement.setAttribute("data-log", JSON.stringify(log));
});
"""


def probed(text, probe=PROBE):
    """The page with a probe that its policy allows by its hash."""
    digest = base64.b64encode(hashlib.sha256(probe.encode()).digest()).decode()
    text = text.replace("script-src '", f"script-src 'sha256-{digest}' '", 1)
    return text.replace("</body>", f"<script>{probe}</script></body>")


@needs_chromium
def test_page_in_chromium(folder, tmp_path):
    page = tmp_path / "report.html"
    page.write_text(probed(report.build(report.check_json([folder]))), encoding="utf-8")

    def logged(done):
        return re.search(r'data-log="([^"]*)"', done.stdout.decode("utf-8", "replace"))

    match = logged(browser(tmp_path, page, "--dump-dom", enough=logged))
    first, by_state, by_failing, sought, last = json.loads(html.unescape(match[1]))
    assert len(first) == 7 and "bad_n.png" in first
    assert by_state[0] == "descending" and by_state[1] == "broken_n.png"
    assert by_state[-1] == "photo.png"
    assert by_failing[:2] == ["ascending", None]
    assert (by_failing[2], by_failing[-1]) == ("photo.png", "broken_n.png")
    assert by_failing[-2] == "bad_n.png" and by_failing[-3].startswith("<img")
    assert sought[:-1] == ["bad_n.png"] and sought[-1] == 1
    clip, swapped, broken_images, background, title = last
    assert "80%" in clip and swapped and broken_images == 0
    assert title == "Normals textures"  # no name has run as a script
    assert background == "rgb(246, 247, 249)"


PHONE = """
const wide = Array.from(document.querySelectorAll("body *")).filter(e => {
  const box = e.getBoundingClientRect();
  return box.width > 0 && box.right > innerWidth + 1 && !e.closest(".hidden, .skip");
}).map(e => e.tagName + "." + e.className + " " + e.textContent.slice(0, 40));
const scroll = document.querySelector(".scroll");
document.documentElement.setAttribute("data-log", JSON.stringify([
  innerWidth, document.documentElement.scrollWidth, scroll.scrollWidth <= scroll.clientWidth, wide]));
"""


@needs_chromium
def test_page_fits_a_phone(folder, tmp_path):
    """Nothing is wider than 390 pixels: no part has to be moved sideways."""
    write_png(folder / ("Brick" * 12 + "_" * 3 + "w" * 90 + "_n.png"), BAD)
    inner = tmp_path / "inner.html"
    text = report.build(report.check_json([folder]))
    inner.write_text(probed(text, PHONE), encoding="utf-8")
    # The window itself cannot be so narrow everywhere, a frame in it can.
    outer = tmp_path / "outer.html"
    collect = """addEventListener("load", () => { const f = document.querySelector("iframe");
      document.documentElement.setAttribute("data-log",
        f.contentDocument.documentElement.getAttribute("data-log")); });"""
    outer.write_text(
        f'<iframe src="{inner.as_uri()}" width="390" height="800" style="border: 0"></iframe>'
        f"<script>{collect}</script>",
        encoding="utf-8",
    )

    def logged(done):
        return re.search(r'data-log="(\[[^"]*)"', done.stdout.decode("utf-8", "replace"))

    match = logged(
        browser(tmp_path, outer, "--dump-dom", "--allow-file-access-from-files", enough=logged)
    )
    width, needed, fits, wide = json.loads(html.unescape(match[1]))
    assert width == 390 and needed <= 390 and fits and not wide, wide


def colorful(pixels):
    return (np.ptp(pixels, axis=2) > 120).sum()


def screenshot(tmp_path, page, number, least=0):
    """The pixels of the page, of which at least so many are colorful."""
    shot = tmp_path / f"{number}.png"

    def look():
        return read_png(shot)[0][..., :3].astype(int)

    def enough(done):
        return shot.exists() and colorful(look()) >= least

    shot.unlink(missing_ok=True)
    scheme = f"--blink-settings=preferredColorScheme={number}"
    tall = "--window-size=1200,2800"  # the first file with pictures stands below the table
    browser(tmp_path, page, scheme, tall, f"--screenshot={shot}", enough=enough)
    return look()


@needs_chromium
def test_screenshots(folder, tmp_path):
    """Light and dark differ as the reader asks, and the pictures are in them."""
    text = report.build(report.check_json([folder]))
    without = tmp_path / "without.html"
    without.write_text(re.sub(r"<img\b", "<i", text), encoding="utf-8")
    page = tmp_path / "report.html"
    page.write_text(text.replace("<img ", '<img decoding="sync" '), encoding="utf-8")
    means = []
    for number in (0, 1):  # 0: dark
        plain = colorful(screenshot(tmp_path, without, number))
        pixels = screenshot(tmp_path, page, number, plain + 5000)
        assert pixels.shape == (2800, 1200, 3)
        means.append(pixels.mean())
    assert means[0] < 70 and means[1] > 180
