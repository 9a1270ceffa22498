// SPDX-License-Identifier: MIT
// Hundreds of files, dropped as a folder.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { unzipSync } from "fflate";
import { BROWSER, folder, isChecked, LIMIT, ntp, page, press, savedBy, texture } from "./driver.mjs";

const KINDS = ["standard_z_off.png", "one_bad_texel.png", "broken_text.png"];
const COUNT = BROWSER === "firefox" ? 120 : 240;
const PER_FOLDER = COUNT / 2; // in Chromium more than it lists at once

/** Drops a folder of folders; what a script drops has no entries, so these are made like a browser's. */
function dropFolder(kinds, count, perFolder) {
  const bytes = kinds.map((base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)));
  const fileEntry = (name, path, i) => ({
    isFile: true,
    fullPath: path,
    file: (take) => take(new File([bytes[i % bytes.length]], name, { type: "image/png" })),
  });
  const folderEntry = (path, entries) => ({
    isDirectory: true,
    fullPath: path,
    createReader() {
      let at = 0;
      return { readEntries: (take) => setTimeout(() => take(entries.slice(at, (at += 100)))) };
    },
  });
  const folders = [];
  for (let first = 0; first < count; first += perFolder) {
    const path = `/textures/${folders.length}`;
    const files = Array.from({ length: perFolder }, (_, i) => {
      const name = `wall${i}.png`; // the same names in each folder
      return fileEntry(name, `${path}/${name}`, first + i);
    });
    folders.push(folderEntry(path, files));
  }
  const drop = new Event("drop", { bubbles: true, cancelable: true });
  const items = [{ webkitGetAsEntry: () => folderEntry("/textures", folders) }];
  Object.defineProperty(drop, "dataTransfer", { value: { items, files: [] } });
  dispatchEvent(drop);
}

const shown = () =>
  page.$$eval("#list button", (buttons) => buttons.map(({ firstChild, lastChild }) => [firstChild.textContent, lastChild.className]));

test(`${COUNT} files: a list that is sifted, few workers, a zip that Python reads`, LIMIT, async () => {
  await press("#clear");
  await page.evaluate(dropFolder, KINDS.map((name) => readFileSync(texture(name), "base64")), COUNT, PER_FOLDER);
  await isChecked(COUNT);
  const { living, most } = await page.evaluate(() => globalThis.crew);
  assert.ok(living >= 1 && most <= 4, `${living} of ${most} workers`);

  const all = await shown();
  assert.deepEqual(all[PER_FOLDER], ["textures/1/wall0.png", all[0][1]]);
  await page.select("#order", "worst");
  const ranks = (await shown()).map(([, level]) => ["error", "warning", "good"].indexOf(level));
  assert.deepEqual(ranks, ranks.toSorted());
  await page.select("#only", "unreadable");
  assert.equal((await shown()).length, COUNT / 3);
  await page.select("#only", "");
  await page.type("#find", "1/wall5");
  assert.equal((await shown()).length, 11); // 5, 50 to 59
  await page.$eval("#find", (input) => {
    input.value = "1/";
    input.dispatchEvent(new Event("input"));
  });

  // The zip has what is listed: those of one folder.
  await press('[data-verb="clean"]');
  const path = join(folder, "many.zip");
  const bytes = await savedBy("#download-all");
  writeFileSync(path, bytes);
  const tested = spawnSync("python3", ["-m", "zipfile", "-t", path], { encoding: "utf8" });
  assert.equal(tested.stdout.trim(), "Done testing", tested.stderr);
  const files = unzipSync(bytes);
  assert.equal(Object.keys(files).length, (PER_FOLDER / 3) * 2 + 1);
  for (const [i, name] of KINDS.slice(0, 2).entries()) {
    const out = join(folder, name);
    assert.equal(ntp("clean", name, "-o", out).status, 0);
    const theirs = readFileSync(out);
    for (let n = i; n < PER_FOLDER; n += 3)
      assert.deepEqual(Buffer.from(files[`textures/1/wall${n}_clean.png`]), theirs);
  }
  assert.ok(files["not-done.txt"].length > 0);
  await press("#clear");
});
