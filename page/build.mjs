// SPDX-License-Identifier: MIT
// Builds the page: node build.mjs MODULE OUTPUT.  MODULE is ntp as WebAssembly; OUTPUT is one file that
// needs no other.
import { execFileSync } from "node:child_process";
import { readFile, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";

const LIMIT = 500_000; // bytes, gzipped

const [, , module, output] = process.argv;
const source = (name) => fileURLToPath(new URL(`src/${name}`, import.meta.url));

async function bundle(entry, format) {
  const { outputFiles } = await build({
    entryPoints: [source(entry)],
    bundle: true,
    minify: true,
    write: false,
    target: "es2022",
    format,
    loader: { ".css": "css" },
    legalComments: "none",
  });
  return outputFiles[0].text;
}

// Within a script element, neither of these may occur.
const harmless = (script) => script.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");

// Optimizes the linked module whole: fourteen kilobytes less, packed.  Memory begins with the stack, which grows
// down, so nothing but a stack that is about to overflow has its first kilobyte.
const optimized = (path) => {
  const target = `${path}.wasm`;
  const features = ["--enable-simd", "--enable-mutable-globals", "--enable-bulk-memory"];
  const strip = ["--strip-producers", "--strip-target-features"];
  execFileSync("wasm-opt", ["-Os", "--low-memory-unused", ...features, ...strip, path, "-o", target]);
  return target;
};

// Twenty kilobytes smaller than zlib packs it, and it unpacks as well.
const packedSmall = (path) => execFileSync("zopfli", ["-c", path], { maxBuffer: LIMIT });

const parts = {
  "/*style*/": await bundle("style.css"),
  "<!--module-->": packedSmall(optimized(module)).toString("base64"),
  "<!--worker-->": harmless(await bundle("worker.ts", "iife")),
  "/*script*/": harmless(await bundle("main.ts", "esm")),
};
let page = await readFile(source("index.html"), "utf8");
for (const [mark, text] of Object.entries(parts)) page = page.replace(mark, () => text);
const packed = gzipSync(page, { level: 9 }).length;
if (packed > LIMIT) throw new Error(`${output}: ${packed} bytes gzipped, more than ${LIMIT}`);
await writeFile(output, page);
console.log(`${output}: ${page.length} bytes, ${packed} gzipped`);
