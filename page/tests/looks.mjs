// SPDX-License-Identifier: MIT
// What a person sees: views, the loupe, languages, a phone, keys, and how soon.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { test } from "node:test";
import { choose, folder, hasResult, isChecked, isDrawn, isShown, LIMIT, NTP, ntp, page, press, show, textOf, texture } from "./driver.mjs";

test("every view draws something that differs from the others", LIMIT, async () => {
  await show(texture("standard_z_off.png"));
  const seen = new Set();
  for (const mode of ["texture", "heatmap", "lit", "sphere", "tiles"]) {
    await press(`[data-mode="${mode}"]`);
    await isDrawn(mode);
    seen.add(await page.$eval("#canvas", (canvas) => canvas.toDataURL()));
  }
  assert.equal(seen.size, 5);
});

test("the loupe tells the levels of the file", LIMIT, async () => {
  await show(texture("standard_16.png"));
  await press('[data-mode="texture"]');
  await isDrawn("texture");
  await page.focus("#canvas");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowDown");
  const said = await textOf("#loupe");
  const [, levels] = /^\(1, 1\): (\d+, \d+, \d+)/.exec(said);
  const rows = ntp("dump", "standard_16.png", "--all").out.split("\n");
  const names = rows[0].split(",");
  const row = rows.slice(1).map((line) => line.split(",")).find((cells) => cells[0] === "1" && cells[1] === "1");
  assert.equal(levels, ["r", "g", "b"].map((name) => row[names.indexOf(name)]).join(", "));
});

test("the page speaks German, on a phone too", LIMIT, async () => {
  await show(texture("standard_z_off.png"));
  await page.select("#language", "de");
  await page.setViewport({ width: 360, height: 740 });
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  const words = await page.evaluate(() => document.body.innerText);
  await page.setViewport({ width: 1400, height: 1000 });
  await page.select("#language", "en");
  assert.ok(wide <= 360, `${wide} pixels wide`);
  assert.match(words, /Nichts wird irgendwohin gesendet/);
  assert.match(words, /Normalen, die nicht die Länge 1 haben/);
});

test("tabs and ways to look are chosen by arrow keys", LIMIT, async () => {
  await show(texture("standard_z_off.png"));
  for (const [row, chosen] of [["#modes", "aria-checked"], ["#verbs", "aria-selected"]]) {
    const now = () => page.$eval(row, (element, is) => {
      const buttons = [...element.children];
      const at = buttons.findIndex((button) => button.getAttribute(is) === "true");
      return [at, buttons.findIndex((button) => button.tabIndex === 0), buttons.indexOf(document.activeElement)];
    }, chosen);
    await page.$eval(row, (element) => element.firstElementChild.click());
    await page.focus(`${row} [tabindex="0"]`);
    for (const [key, at] of [["ArrowRight", 1], ["ArrowRight", 2], ["ArrowLeft", 1], ["Home", 0]]) {
      await page.keyboard.press(key);
      assert.deepEqual(await now(), [at, at, at], `${row} ${key}`);
    }
  }
});

test("axe finds no violation", LIMIT, async () => {
  await show(texture("standard_z_off.png"));
  await press('[data-remedy="cleanIt"]');
  await hasResult("clean");
  const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => globalThis.axe.run());
  assert.deepEqual(violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(" ")}`), []);
});

test("a large texture: how long verdict and heatmap take beside ntp check", LIMIT, async (context) => {
  const large = join(folder, "large_n.png");
  assert.equal(ntp("resize", texture("standard_z_off.png"), "--size", "2048x2048", "-o", large, "--force").status, 0);
  const started = performance.now();
  spawnSync(NTP, ["check", large]);
  const native = performance.now() - started;
  const begun = performance.now();
  await choose(large);
  await isChecked(1);
  const verdict = performance.now() - begun;
  await isShown();
  await press('[data-mode="heatmap"]');
  await isDrawn("heatmap");
  const all = performance.now() - begun;
  const size = (statSync(large).size / 1e6).toFixed(1);
  context.diagnostic(
    `2048 x 2048 (${size} MB): ntp check ${native.toFixed(0)} ms, verdict ${verdict.toFixed(0)} ms ` +
      `(${(verdict / native).toFixed(1)} times), and heatmap ${all.toFixed(0)} ms`,
  );
});
