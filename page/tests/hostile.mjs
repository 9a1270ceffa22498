// SPDX-License-Identifier: MIT
// Hostile and huge files: each gets a sentence, the page lives, and memory is given back.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { test } from "node:test";
import { crc32, deflateSync } from "node:zlib";
import { choose, folder, isChecked, isDrawn, LIMIT, page, pick, press, show, texture, verdictOf } from "./driver.mjs";

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type, "latin1"), data]);
  const length = Buffer.alloc(4);
  const sum = Buffer.alloc(4);
  length.writeUInt32BE(data.length);
  sum.writeUInt32BE(crc32(body));
  return Buffer.concat([length, body, sum]);
}

/** An image of gray levels of 1 or 8 bits, all 0. */
function png(width, height, bits, data, ...chunks) {
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header[8] = bits;
  const signature = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);
  return Buffer.concat([signature, chunk("IHDR", header), ...chunks, chunk("IDAT", data), chunk("IEND", Buffer.alloc(0))]);
}

const zeros = (bytes) => deflateSync(Buffer.alloc(bytes));

function file(name, bytes) {
  const path = join(folder, name);
  writeFileSync(path, bytes);
  return path;
}

test("hostile files get a sentence, and the page lives", LIMIT, async () => {
  const cut = readFileSync(texture("standard.png"));
  const bomb = Buffer.concat([Buffer.from("Comment\0\0", "latin1"), zeros(1 << 26)]);
  const refused = [
    file("of_16384.png", png(16384, 16384, 1, zeros(16384 * 2049))),
    file("of_100000.png", png(100000, 100000, 8, Buffer.alloc(0))),
    file("noise.png", Buffer.from(Array.from({ length: 5000 }, (_, i) => (i * 7919) & 255))),
    file("empty.tga", ""),
    file("text.png", "This is no picture.\n"),
    file("cut.png", cut.subarray(0, cut.length / 2)),
  ];
  const odd = [
    file("bomb_of_text.png", png(8, 8, 8, zeros(72), chunk("zTXt", bomb))),
    file("bomb_of_pixels.png", png(8, 8, 8, zeros(1 << 26))),
  ];
  await choose(...refused, ...odd, texture("standard.png"));
  await isChecked(refused.length + odd.length + 1);
  for (const path of refused) {
    await pick(basename(path));
    const { short } = await verdictOf();
    assert.match(short, new RegExp(basename(path)), short);
  }
  for (const path of odd) await pick(basename(path)); // a verdict of either kind
  await pick("standard.png");
  await isDrawn();
});

test("a large texture does not freeze the page, and its memory is given back", LIMIT, async () => {
  const large = file("of_8192.png", png(8192, 4096, 8, zeros(8193 * 4096)));
  const before = await page.evaluate(() => {
    globalThis.crew.memory = [];
    globalThis.ticks = 0;
    globalThis.ticking = setInterval(() => globalThis.ticks++, 10);
    return globalThis.crew.living;
  });
  await show(large);
  await isDrawn();
  const { memory, living, ticks } = await page.evaluate(() => {
    clearInterval(globalThis.ticking);
    return { ...globalThis.crew, ticks: globalThis.ticks };
  });
  const much = memory.filter((bytes) => bytes > 1 << 27).length;
  assert.ok(before >= 1 && ticks > 3, `${ticks} ticks`);
  assert.ok(living <= Math.max(0, 4 - much), `${living} workers, ${memory.join(" ")} bytes`);
  await press("#clear");
});
