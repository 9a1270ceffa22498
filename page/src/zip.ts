// SPDX-License-Identifier: MIT
// A zip of files as they are.  Each stays a blob, so the browser keeps them where it has room.
import { say } from "./words.js";

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? (value >>> 1) ^ 0xedb88320 : value >>> 1;
  return value;
});

async function checksumOf(blob: Blob): Promise<number> {
  let value = 0xffffffff;
  for (const byte of new Uint8Array(await blob.arrayBuffer())) value = TABLE[(value ^ byte) & 255] ^ (value >>> 8);
  return ~value >>> 0;
}

const UTF8_NAMES = 0x800;
const DAY = 0x21; // the first of 1980
const MOST_BYTES = 2 ** 32 - 1; // of a zip without extensions
const MOST_FILES = 2 ** 16 - 1;

/** Little-endian numbers of 2 or 4 bytes. */
function numbers(...values: readonly (readonly [number, 2 | 4])[]): Uint8Array<ArrayBuffer> {
  const view = new DataView(new ArrayBuffer(values.reduce((sum, [, size]) => sum + size, 0)));
  let at = 0;
  for (const [value, size] of values) {
    if (size === 2) view.setUint16(at, value, true);
    else view.setUint32(at, value, true);
    at += size;
  }
  return new Uint8Array(view.buffer);
}

export class Zip {
  readonly #parts: BlobPart[] = [];
  readonly #directory: BlobPart[] = [];
  readonly #names = new Set<string>();
  #size = 0;

  async add(path: string, file: Blob): Promise<void> {
    const unused = this.#unused(path);
    const name = new TextEncoder().encode(unused);
    const common = [[20, 2], [UTF8_NAMES, 2], [0, 2], [0, 2], [DAY, 2], [await checksumOf(file), 4], [file.size, 4], [file.size, 4], [name.length, 2], [0, 2]] as const;
    const local = numbers([0x04034b50, 4], ...common);
    const entry = numbers([0x02014b50, 4], [20, 2], ...common, [0, 2], [0, 2], [0, 2], [0, 4], [this.#size, 4]);
    this.#parts.push(local, name, file);
    this.#directory.push(entry, name);
    this.#size += local.length + name.length + file.size;
  }

  /** Two files may come to the same name: wall.png and wall.tga. */
  #unused(path: string): string {
    let name = path;
    for (let again = 2; this.#names.has(name); again++) name = path.replace(/(\.[^./]*)?$/, `-${again}$1`);
    this.#names.add(name);
    return name;
  }

  finish(): Blob {
    const directory = new Blob(this.#directory);
    const count = this.#names.size;
    if (this.#size > MOST_BYTES || count > MOST_FILES) throw new Error(say("zipTooLarge"));
    const end = numbers([0x06054b50, 4], [0, 2], [0, 2], [count, 2], [count, 2], [directory.size, 4], [this.#size, 4], [0, 2]);
    return new Blob([...this.#parts, directory, end], { type: "application/zip" });
  }
}
