// SPDX-License-Identifier: MIT
// The page in a real browser, opened from the disk: node --test, with PAGE, NTP, TEXTURES and BROWSER
// (chromium or firefox) in the environment.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, statSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { unzipSync } from "fflate";
import puppeteer from "puppeteer-core";

const { PAGE, NTP, TEXTURES, BROWSER = "chromium" } = process.env;
const PROGRAMS = { chromium: "/usr/bin/chromium", firefox: "/usr/bin/firefox-esr" };
const PATIENCE = { timeout: 120_000 };
const LIMIT = { timeout: 600_000 };

const folder = mkdtempSync(join(tmpdir(), "page-"));
let browser;
let page;
const requests = [];
const errors = [];

const ntp = (...args) => {
  const { status, stdout, stderr } = spawnSync(NTP, args, { cwd: TEXTURES, encoding: "utf8", maxBuffer: 1 << 28 });
  return { status, out: stdout, err: stderr };
};

const texture = (name) => join(TEXTURES, name);

async function open() {
  page = await browser.newPage();
  await page.setViewport({ width: 1400, height: 1000 });
  page.on("request", (request) => requests.push(request.url()));
  page.on("pageerror", (error) => errors.push(error.message));
  await page.goto(pathToFileURL(PAGE).href);
  await page.waitForSelector("html[data-ready]", PATIENCE);
  await page.select("#language", "en");
}

async function choose(...names) {
  await press("#clear");
  const input = await page.$("#input");
  await input.uploadFile(...names);
}

// A click of the mouse may come between two renderings of a button.
const press = (selector) => page.$eval(selector, (element) => element.click());
const isShown = () => page.waitForSelector("#view:not([hidden])", PATIENCE);

const isChecked = (count) =>
  page.waitForFunction(
    (most) => {
      const waiting = [...document.querySelectorAll("#list small.quiet")];
      return document.querySelectorAll("#list button").length === most && waiting.length === 0;
    },
    PATIENCE,
    count,
  );

const verdictOf = () =>
  page.evaluate(() => ({
    short: document.getElementById("verdict-body").firstElementChild.textContent,
    findings: [...document.querySelectorAll("#verdict-body li b")].map((b) => b.textContent.replace("note", "info")),
    messages: [...document.querySelectorAll("#verdict-body li span")].map((span) => span.textContent),
  }));

async function pick(name) {
  await page.evaluate((wanted) => {
    const buttons = [...document.querySelectorAll("#list button")];
    buttons.find((button) => button.firstChild.textContent === wanted).click();
  }, name);
  await page.waitForFunction(
    (wanted) => {
      const { children } = document.getElementById("verdict-body");
      const title = document.getElementById("verdict-title").textContent;
      return title === wanted && (children.length > 1 || children[0]?.className === "error");
    },
    PATIENCE,
    name,
  );
}

/** Waits for a result of the arguments that the command line shows, and returns its bytes. */
async function resultOf(command) {
  await page.waitForFunction(
    (wanted) =>
      document.getElementById("command").textContent.includes(wanted) && !document.getElementById("download").disabled,
    PATIENCE,
    command,
  );
  const bytes = await page.evaluate(async () => {
    const create = URL.createObjectURL;
    const blobs = [];
    URL.createObjectURL = (blob) => (blobs.push(blob), create(blob));
    HTMLAnchorElement.prototype.click = () => {};
    document.getElementById("download").click();
    for (let i = 0; i < 200 && blobs.length === 0; i++) await new Promise((next) => setTimeout(next, 10));
    URL.createObjectURL = create;
    return [...new Uint8Array(await blobs[0].arrayBuffer())];
  });
  return Uint8Array.from(bytes);
}

before(async () => {
  const options = { executablePath: PROGRAMS[BROWSER], browser: BROWSER === "firefox" ? "firefox" : "chrome" };
  browser = await puppeteer.launch({ ...options, args: BROWSER === "firefox" ? [] : ["--no-sandbox"], protocolTimeout: 300_000 });
  await open();
}, LIMIT);

after(async () => {
  await browser?.close();
});

test("verdicts are those of ntp check, word for word", LIMIT, async () => {
  const names = readdirSync(TEXTURES).filter((name) => /\.(png|tga|jpe?g|pfm|dds|ktx2)$/.test(name) && name !== "broken_huge.png");
  const some = names.filter((_, i) => i % 2 === 0 || names.length < 40);
  assert.ok(some.length >= 20);
  await choose(...some.map(texture));
  await isChecked(some.length);
  for (const name of some) {
    const report = ntp("check", "--format", "json", "--max-texels", "67108864", name);
    const theirs = JSON.parse(report.out).files[0];
    await pick(name);
    const ours = await verdictOf();
    if (theirs.status !== "ok") {
      assert.equal(ours.short, theirs.message, name);
      continue;
    }
    const level = { error: 0, warning: 1, info: 2 };
    const sorted = theirs.findings.toSorted((a, b) => level[a.level] - level[b.level]);
    assert.deepEqual(ours.findings, sorted.map(({ id, level: of }) => `${of} ${id}`), name);
    assert.deepEqual(ours.messages, sorted.map(({ message }) => message), name);
  }
});

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
    await choose(texture(name));
    await isChecked(1);
    await pick(name);
    await isShown();
    await press(`[data-verb="${verb}"]`);
    for (const [option, value] of Object.entries(set)) {
      const id = `#option-${option}`;
      const kind = await page.$eval(id, (field) => field.tagName + field.type);
      if (kind.startsWith("SELECT")) await page.select(id, value);
      else if (kind === "INPUTcheckbox") await press(id);
      else {
        await page.$eval(id, (field) => (field.value = ""));
        await page.type(id, value);
      }
    }
    const shown = options.join(" ");
    const bytes = await resultOf(shown);
    const out = join(folder, `${verb}.png`);
    const theirs = ntp(verb, name, "-o", out, "--force", ...options);
    assert.equal(theirs.status, 0, theirs.err);
    assert.deepEqual(Buffer.from(bytes), readFileSync(out));
  });

test("blend takes the detail from a second file", LIMIT, async () => {
  await choose(texture("standard.png"));
  await isChecked(1);
  await isShown();
  await press('[data-verb="blend"]');
  const detail = await page.$("#option-detail");
  await detail.uploadFile(texture("standard_rounded.png"));
  const bytes = await resultOf("blend");
  const out = join(folder, "blend.png");
  const theirs = ntp("blend", "standard.png", "standard_rounded.png", "-o", out, "--force");
  assert.equal(theirs.status, 0, theirs.err);
  assert.deepEqual(Buffer.from(bytes), readFileSync(out));
});

test("what ntp refuses is refused in its words", LIMIT, async () => {
  await choose(texture("photograph.png"));
  await isChecked(1);
  await isShown();
  await press('[data-verb="clean"]');
  await page.waitForSelector("#outcome.error", PATIENCE);
  const said = await page.$eval("#outcome", (outcome) => outcome.textContent);
  assert.equal(`ntp: ${said}\n`, ntp("clean", "photograph.png", "-o", join(folder, "no.png")).err);
  assert.equal(await page.$eval("#download", ({ disabled }) => disabled), true);
});

test("hostile files get a sentence, and the page lives", LIMIT, async () => {
  const large = join(folder, "large.png");
  const header = readFileSync(texture("broken_huge.png"));
  writeFileSync(large, header);
  writeFileSync(join(folder, "noise.png"), Buffer.from(Array.from({ length: 5000 }, (_, i) => (i * 7919) & 255)));
  writeFileSync(join(folder, "empty.tga"), "");
  const files = [large, join(folder, "noise.png"), join(folder, "empty.tga"), texture("standard.png")];
  await choose(...files);
  await isChecked(files.length);
  for (const file of files.slice(0, 3)) {
    await pick(basename(file));
    const { short } = await verdictOf();
    assert.match(short, new RegExp(basename(file)), short);
  }
  await pick("standard.png");
  await page.waitForSelector("#canvas[data-drawn]", PATIENCE);
});

test("every view draws something that differs from the others", LIMIT, async () => {
  await choose(texture("standard_z_off.png"));
  await isChecked(1);
  await isShown();
  const seen = new Set();
  for (const mode of ["texture", "heatmap", "lit", "sphere", "tiles"]) {
    await press(`[data-mode="${mode}"]`);
    await page.waitForSelector(`#canvas[data-drawn^="${mode}"]`, PATIENCE);
    seen.add(await page.$eval("#canvas", (canvas) => canvas.toDataURL()));
  }
  assert.equal(seen.size, 5);
});

test("the loupe tells the levels of the file", LIMIT, async () => {
  await choose(texture("standard_16.png"));
  await isChecked(1);
  await page.waitForSelector("#canvas[data-drawn]", PATIENCE);
  await press('[data-mode="texture"]');
  await page.focus("#canvas");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowDown");
  const said = await page.$eval("#loupe", (loupe) => loupe.textContent);
  const [, levels] = /^\(1, 1\): (\d+, \d+, \d+)/.exec(said);
  const rows = ntp("dump", "standard_16.png", "--all").out.split("\n");
  const names = rows[0].split(",");
  const row = rows.slice(1).map((line) => line.split(",")).find((cells) => cells[0] === "1" && cells[1] === "1");
  assert.equal(levels, ["r", "g", "b"].map((name) => row[names.indexOf(name)]).join(", "));
});

test("all textures go home in one zip", LIMIT, async () => {
  await choose(texture("standard_z_off.png"), texture("photograph.png"), texture("zzero.png"));
  await isChecked(3);
  await pick("standard_z_off.png");
  await page.waitForSelector("#canvas[data-drawn]", PATIENCE);
  await press('[data-verb="clean"]');
  const bytes = await page.evaluate(async () => {
    const create = URL.createObjectURL;
    const blobs = [];
    URL.createObjectURL = (blob) => (blobs.push(blob), create(blob));
    HTMLAnchorElement.prototype.click = () => {};
    document.getElementById("download-all").click();
    const zip = () => blobs.find(({ type }) => type === "application/zip");
    for (let i = 0; i < 6000 && !zip(); i++) await new Promise((next) => setTimeout(next, 10));
    URL.createObjectURL = create;
    return [...new Uint8Array(await zip().arrayBuffer())];
  });
  const files = unzipSync(Uint8Array.from(bytes));
  assert.deepEqual(Object.keys(files).toSorted(), ["not-done.txt", "standard_z_off_clean.png", "zzero_clean.png"]);
  const out = join(folder, "one.png");
  assert.equal(ntp("clean", "zzero.png", "-o", out, "--force").status, 0);
  assert.deepEqual(Buffer.from(files["zzero_clean.png"]), readFileSync(out));
});

test("the page speaks German, on a phone too", LIMIT, async () => {
  await choose(texture("standard_z_off.png"));
  await isChecked(1);
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

test("every finding has a German subject", () => {
  const read = (path) => readFileSync(new URL(path, import.meta.url), "utf8");
  const all = [...read("../../docs/findings.md").matchAll(/^## (NT\d+):/gm)].map(([, id]) => id);
  const german = [...read("../src/words.ts").matchAll(/^ {2}(NT\d+): "/gm)].map(([, id]) => id);
  assert.ok(all.length > 30);
  assert.deepEqual(german, all);
});

test("axe finds no violation", LIMIT, async () => {
  await choose(texture("standard_z_off.png"));
  await isChecked(1);
  await isShown();
  await press('[data-remedy="cleanIt"]');
  await page.waitForFunction(() => !document.getElementById("download").disabled, PATIENCE);
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
  await page.waitForSelector('#canvas[data-drawn^="heatmap"]', PATIENCE);
  const all = performance.now() - begun;
  const size = (statSync(large).size / 1e6).toFixed(1);
  context.diagnostic(
    `2048 x 2048 (${size} MB): ntp check ${native.toFixed(0)} ms, verdict ${verdict.toFixed(0)} ms ` +
      `(${(verdict / native).toFixed(1)} times), and heatmap ${all.toFixed(0)} ms`,
  );
});

test("nothing was sent, and nothing went wrong", LIMIT, () => {
  assert.deepEqual(requests.filter((url) => !/^(file|blob|data):/.test(url)), []);
  assert.deepEqual(errors, []);
});

