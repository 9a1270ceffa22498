// SPDX-License-Identifier: MIT
// Makes the pictures of docs/page.md: node pictures.mjs PAGE TEXTURES FOLDER.
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

const [, , address, textures, folder] = process.argv;
const FILES = ["standard_z_off.png", "height_gray16.png", "red_blue_swapped.png", "zzero.png", "standard.png", "jpeg.jpg"];
const PATIENCE = { timeout: 120_000 };

async function picture(browser, { name, width, height, dark, language, mode }) {
  const page = await browser.newPage();
  await page.setViewport({ width, height });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }]);
  await page.goto(pathToFileURL(address).href);
  await page.waitForSelector("html[data-ready]", PATIENCE);
  await page.select("#language", language);
  const input = await page.$("#input");
  await input.uploadFile(...FILES.map((file) => join(textures, file)));
  await page.waitForSelector("#remedies button", PATIENCE);
  await page.waitForFunction(() => document.querySelector("#list small.quiet") === null, PATIENCE);
  await page.$eval('[data-remedy="cleanIt"]', (button) => button.click());
  await page.waitForSelector('#canvas[data-drawn$="2"]', PATIENCE);
  await page.$eval(`[data-mode="${mode}"]`, (button) => button.click());
  await page.waitForSelector(`#canvas[data-drawn^="${mode}"]`, PATIENCE);
  await page.screenshot({ path: join(folder, name), fullPage: true });
  await page.close();
}

const browser = await puppeteer.launch({ executablePath: "/usr/bin/chromium", args: ["--no-sandbox", "--font-render-hinting=none"] });
await picture(browser, { name: "page.png", width: 1280, height: 900, dark: false, language: "en", mode: "heatmap" });
await picture(browser, { name: "page-phone.png", width: 390, height: 844, dark: true, language: "de", mode: "sphere" });
await browser.close();
