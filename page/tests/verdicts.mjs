// SPDX-License-Identifier: MIT
// The page says what `ntp check` says.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { basename, join } from "node:path";
import { test } from "node:test";
import { choose, corpus, isChecked, LIMIT, pick, reportsOf, textOf, TEXTURES, verdictOf } from "./driver.mjs";

const LEVELS = ["error", "warning", "info"];
const READABLE = /\.(png|tga|jpe?g|pfm|dds|ktx2)$/;

async function compare(paths) {
  await choose(...paths);
  await isChecked(paths.length);
  for (const theirs of reportsOf(paths)) {
    const name = basename(theirs.path);
    await pick(name);
    const ours = await verdictOf();
    if (theirs.status !== "ok") {
      assert.equal(ours.short, theirs.message.replaceAll(theirs.path, name));
      continue;
    }
    const sorted = theirs.findings.toSorted((a, b) => LEVELS.indexOf(a.level) - LEVELS.indexOf(b.level));
    assert.deepEqual(ours.findings, sorted.map(({ id, level }) => `${level} ${id}`), name);
    assert.deepEqual(ours.messages, sorted.map(({ message }) => message), name);
  }
}

test("verdicts are those of ntp check, word for word", LIMIT, async () => {
  const names = readdirSync(TEXTURES).filter((name) => READABLE.test(name) && name !== "broken_huge.png");
  const some = names.filter((_, i) => i % 2 === 0 || names.length < 40);
  assert.ok(some.length >= 20);
  await compare(some.map((name) => join(TEXTURES, name)));
});

test("and of real textures", { ...LIMIT, skip: corpus().length === 0 && "no corpus" }, () => compare(corpus()));

test("a JPEG is called lossy", LIMIT, async () => {
  await choose(join(TEXTURES, "jpeg.jpg"));
  await isChecked(1);
  await pick("jpeg.jpg");
  assert.match(await textOf("#verdict-body"), /JPEG is lossy/);
});

test("every finding has a German subject", () => {
  const read = (path) => readFileSync(new URL(path, import.meta.url), "utf8");
  const all = [...read("../../docs/findings.md").matchAll(/^## (NT\d+):/gm)].map(([, id]) => id);
  const german = [...read("../src/words.ts").matchAll(/^ {2}(NT\d+): "/gm)].map(([, id]) => id);
  assert.ok(all.length > 30);
  assert.deepEqual(german, all);
});
