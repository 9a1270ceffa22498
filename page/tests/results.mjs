// SPDX-License-Identifier: MIT
// What the page makes has the bytes that `ntp` makes.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { basename, join } from "node:path";
import { test } from "node:test";
import { unzipSync } from "fflate";
import { choose, corpus, fill, folder, hasResult, isChecked, LIMIT, ntp, page, PATIENCE, press, savedBy, show, textOf, texture } from "./driver.mjs";

async function compare(verb, inputs, options, ending = "png") {
  await hasResult(options.join(" "));
  const bytes = await savedBy("#download");
  const out = join(folder, `${verb}.${ending}`);
  const theirs = ntp(verb, ...inputs, "-o", out, "--force", ...options);
  assert.equal(theirs.status, 0, theirs.err);
  assert.deepEqual(bytes, readFileSync(out));
  return theirs;
}

for (const [verb, name, options, set] of [
  ["clean", "standard_z_off.png", [], {}],
  ["clean", "red_blue_swapped.png", ["--undo"], { undo: true }],
  ["clean", "jpeg_damaged.png", ["--method", "normalize"], { method: "normalize" }],
  ["convert", "standard.png", ["--to", "zzero", "--depth", "16"], { to: "zzero", depth: "16" }],
  ["convert", "standard.png", ["--y", "up", "--to-y", "down"], { y: "up", "to-y": "down" }],
  ["transform", "standard_16.png", ["--strength", "2", "--rotate", "90"], { strength: "2", rotate: "90" }],
  ["resize", "standard.png", ["--size", "50%"], {}],
  ["from-height", "height_gray16.png", ["--scale", "8", "--kernel", "sobel3"], { scale: "8", kernel: "sobel3" }],
  ["to-height", "standard.png", ["--refine", "4"], { refine: "4" }],
])
  test(`${verb} ${name} ${options.join(" ")}: the bytes of ntp`, LIMIT, async () => {
    await show(texture(name));
    await press(`[data-verb="${verb}"]`);
    await fill(set);
    const { out } = await compare(verb, [name], options);
    const said = out.trim().split("\n")[0].replace(/^.* -> .*?: /, "");
    assert.ok((await textOf("#outcome")).includes(said), said);
  });

test("blend takes the detail from a second file", LIMIT, async () => {
  await show(texture("standard.png"));
  await press('[data-verb="blend"]');
  const detail = await page.$("#option-detail");
  await detail.uploadFile(texture("standard_rounded.png"));
  await compare("blend", ["standard.png", "standard_rounded.png"], []);
});

test("convert to blocks for games: the bytes of ntp", LIMIT, async () => {
  await show(texture("standard.png"));
  await press('[data-verb="convert"]');
  await fill({ format: "dds" });
  await hasResult("standard_convert.dds");
  await compare("convert", ["standard.png"], [], "dds");
});

test("what ntp refuses is refused in its words", LIMIT, async () => {
  await show(texture("photograph.png"));
  await press('[data-verb="clean"]');
  await page.waitForSelector("#outcome.error", PATIENCE);
  assert.equal(`ntp: ${await textOf("#outcome")}\n`, ntp("clean", "photograph.png", "-o", join(folder, "no.png")).err);
  assert.equal(await page.$eval("#download", ({ disabled }) => disabled), true);
});

test("all textures go home in one zip", LIMIT, async () => {
  await show(texture("standard_z_off.png"), texture("photograph.png"), texture("zzero.png"));
  await press('[data-verb="clean"]');
  const files = unzipSync(await savedBy("#download-all"));
  assert.deepEqual(Object.keys(files).toSorted(), ["not-done.txt", "standard_z_off_clean.png", "zzero_clean.png"]);
  const out = join(folder, "one.png");
  assert.equal(ntp("clean", "zzero.png", "-o", out, "--force").status, 0);
  assert.deepEqual(Buffer.from(files["zzero_clean.png"]), readFileSync(out));
});

for (const [verb, set, options] of [
  ["clean", {}, []],
  ["convert", { depth: "16" }, ["--depth", "16"]],
])
  test(`${verb} of real textures: the bytes of ntp`, { ...LIMIT, skip: corpus().length === 0 && "no corpus" }, async () => {
    const paths = corpus();
    await choose(...paths);
    await isChecked(paths.length);
    await press(`[data-verb="${verb}"]`);
    await fill(set);
    const files = unzipSync(await savedBy("#download-all"));
    const out = join(folder, verb);
    mkdirSync(out);
    ntp(verb, ...paths, "-o", out, ...options);
    const made = Object.keys(files).filter((name) => name !== "not-done.txt");
    assert.ok(made.length > 15, made.join(" "));
    for (const path of paths) {
      const stem = basename(path).replace(/\.[^.]*$/, "");
      const ours = files[`${stem}_${verb}.png`];
      const theirs = join(out, `${stem}.png`);
      if (ours !== undefined) assert.deepEqual(Buffer.from(ours), readFileSync(theirs), path);
      else assert.throws(() => readFileSync(theirs), path);
    }
  });
