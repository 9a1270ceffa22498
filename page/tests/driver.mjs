// SPDX-License-Identifier: MIT
// Drives the page in a real browser, opened from the disk: PAGE, NTP, TEXTURES, CORPUS and BROWSER (chromium
// or firefox) are in the environment.  One browser and one tab serve all tests.
import { spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readdirSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

export const { BROWSER = "chromium", NTP, TEXTURES } = process.env;
const { CORPUS, PAGE } = process.env;
const PROGRAMS = { chromium: "/usr/bin/chromium", firefox: "/usr/bin/firefox-esr" };
const isFirefox = BROWSER === "firefox";

export const PATIENCE = { timeout: 120_000 };
export const LIMIT = { timeout: 600_000 };
export const folder = mkdtempSync(join(tmpdir(), "page-"));
export const requests = [];
export const errors = [];
export let page;
let browser;

export const texture = (name) => join(TEXTURES, name);

export function ntp(...args) {
  const { status, stdout, stderr } = spawnSync(NTP, args, { cwd: TEXTURES, encoding: "utf8", maxBuffer: 1 << 28 });
  return { status, out: stdout, err: stderr };
}

const CORPUS_BYTES = 80_000; // of a file, so that the tests stay quick

/** Small real textures, where they are beside the repository; names are unique. */
export function corpus() {
  if (!CORPUS || !existsSync(CORPUS)) return [];
  const all = readdirSync(CORPUS, { recursive: true }).filter((path) => /\.(png|tga|jpg|dds|ktx2)$/.test(path));
  const small = all.map((path) => join(CORPUS, path)).filter((path) => statSync(path).size < CORPUS_BYTES);
  const wide = /StudioRoom/; // 4096 x 4096 texels of one color
  const stem = (path) => basename(path).replace(/\.[^.]*$/, "");
  return small.filter((path, i) => !wide.test(path) && small.findIndex((other) => stem(other) === stem(path)) === i);
}

/** What `ntp check` reports of each file, with the limit of the page. */
export const reportsOf = (paths) =>
  JSON.parse(ntp("check", "--format", "json", "--max-texels", "67108864", ...paths).out).files;

/** Counts the workers that live, and notes what each says of its memory. */
function watchWorkers() {
  const { Worker: Plain } = globalThis;
  globalThis.crew = { living: 0, most: 0, memory: [] };
  globalThis.Worker = class extends Plain {
    constructor(...args) {
      super(...args);
      globalThis.crew.most = Math.max(globalThis.crew.most, ++globalThis.crew.living);
      this.addEventListener("message", ({ data }) => globalThis.crew.memory.push(data.memory));
    }
    terminate() {
      globalThis.crew.living--;
      super.terminate();
    }
  };
}

export async function open() {
  browser = await puppeteer.launch({
    executablePath: PROGRAMS[BROWSER],
    browser: isFirefox ? "firefox" : "chrome",
    args: isFirefox ? [] : ["--no-sandbox"],
    protocolTimeout: 300_000,
  });
  page = await browser.newPage();
  await page.setViewport({ width: 1400, height: 1000 });
  page.on("request", (request) => requests.push(request.url()));
  page.on("pageerror", (error) => errors.push(error.message));
  await page.evaluateOnNewDocument(watchWorkers);
  await page.goto(pathToFileURL(PAGE).href);
  await page.waitForSelector("html[data-ready]", PATIENCE);
  await page.select("#language", "en");
}

export const close = () => browser?.close();

// A click of the mouse may come between two renderings of a button.
export const press = (selector) => page.$eval(selector, (element) => element.click());
export const isShown = () => page.waitForSelector("#view:not([hidden])", PATIENCE);
export const isDrawn = (mode) => page.waitForSelector(mode ? `#canvas[data-drawn^="${mode}"]` : "#canvas[data-drawn]", PATIENCE);
export const textOf = (selector) => page.$eval(selector, ({ textContent }) => textContent);

export async function choose(...names) {
  await press("#clear");
  const input = await page.$("#input");
  await input.uploadFile(...names);
}

export const isChecked = (count) =>
  page.waitForFunction(
    (most) => {
      const waiting = [...document.querySelectorAll("#list small.quiet")];
      return document.querySelectorAll("#list button").length === most && waiting.length === 0;
    },
    PATIENCE,
    count,
  );

/** Chooses files, and waits until the last is checked and the first is shown. */
export async function show(...names) {
  await choose(...names);
  await isChecked(names.length);
  await isShown();
}

export async function pick(name) {
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

export const verdictOf = () =>
  page.evaluate(() => ({
    short: document.getElementById("verdict-body").firstElementChild.textContent,
    findings: [...document.querySelectorAll("#verdict-body li b")].map((b) => b.textContent.replace("note", "info")),
    messages: [...document.querySelectorAll("#verdict-body li span")].map((span) => span.textContent),
  }));

/** Sets the fields of the form by their options. */
export async function fill(values) {
  for (const [option, value] of Object.entries(values)) {
    const id = `#option-${option}`;
    const kind = await page.$eval(id, (field) => field.tagName + field.type);
    if (kind.startsWith("SELECT")) await page.select(id, value);
    else if (kind === "INPUTcheckbox") await press(id);
    else {
      await page.$eval(id, (field) => (field.value = ""));
      await page.type(id, value);
    }
  }
}

export const hasResult = (command) =>
  page.waitForFunction(
    (wanted) =>
      document.getElementById("command").textContent.includes(wanted) && !document.getElementById("download").disabled,
    PATIENCE,
    command,
  );

/** Presses a button and takes the file that the page then saves. */
export async function savedBy(selector) {
  const base64 = await page.evaluate(async (button) => {
    const create = URL.createObjectURL;
    const saved = new Promise((take) => {
      URL.createObjectURL = (blob) => (take(blob), create(blob));
    });
    HTMLAnchorElement.prototype.click = () => {};
    document.querySelector(button).click();
    const reader = new FileReader();
    const read = new Promise((take) => (reader.onload = take));
    reader.readAsDataURL(await saved);
    await read;
    URL.createObjectURL = create;
    return reader.result.replace(/^.*,/, "");
  }, selector);
  return Buffer.from(base64, "base64");
}
