// SPDX-License-Identifier: MIT
// `ntp` itself, in WebAssembly: each run is a new instance, so its memory is given back after it.
import { ConsoleStdout, File, OpenFile, WASI } from "@bjorn3/browser_wasi_shim";
import { Folder } from "./folder.js";
import { jumpImports } from "./jump.js";
import type { Files } from "./messages.js";

export interface Run {
  code: number;
  out: string;
  err: string;
  made: Files;
}

/** Samples by rows, from the top; floats for PFM. */
export interface Texture {
  width: number;
  height: number;
  channels: number;
  data: Uint8Array | Uint16Array | Float32Array;
  drawn: { width: number; height: number };
  /** Of the samples of each drawn pixel, in 0..1. */
  means: Float32Array;
  /** Which texels are wrong, as RGBA at the drawn size; null where that makes no sense. */
  heatmap: Uint8ClampedArray<ArrayBuffer> | null;
}

interface Exports extends WebAssembly.Exports {
  memory: WebAssembly.Memory;
  _start(): void;
  __stack_pointer: WebAssembly.Global;
  __indirect_function_table: WebAssembly.Table;
  readTexture(mostTexels: number, mostSide: number, encoding: number): number;
}

const ENCODINGS = ["standard", "zzero", "xy"]; // as in ntp_encoding
const UNREADABLE = 3;
const SAMPLES: Record<number, typeof Uint8Array | typeof Uint16Array | typeof Float32Array> = {
  1: Uint8Array,
  2: Uint16Array,
  4: Float32Array,
};

/** Larger textures are refused, in the words of `ntp`: they would fill the memory of a browser. */
export const MOST_TEXELS = 8192 * 8192;

/** The longest side that is drawn: more would not fit a screen. */
const MOST_SIDE = 1024;

export class Program {
  readonly #module: WebAssembly.Module;

  constructor(module: WebAssembly.Module) {
    this.#module = module;
  }

  async #instance(args: string[], files: Files) {
    const text = { out: "", err: "" };
    const collect = (which: "out" | "err") => {
      const decoder = new TextDecoder();
      return new ConsoleStdout((bytes) => {
        text[which] += decoder.decode(bytes, { stream: true });
      });
    };
    const folder = await Folder.of(files);
    const input = new OpenFile(new File(new Uint8Array(0)));
    const wasi = new WASI(args, ["NO_COLOR=1"], [input, collect("out"), collect("err"), folder], {
      debug: false,
    });
    let exports: Exports;
    const instance = await WebAssembly.instantiate(this.#module, {
      wasi_snapshot_preview1: wasi.wasiImport,
      env: jumpImports(this.#module, () => exports),
    });
    exports = instance.exports as Exports;
    const memory = () => exports.memory.buffer.byteLength + folder.size();
    return { wasi, exports, folder, text, memory };
  }

  async run(args: string[], files: Files): Promise<{ run: Run; memory: number }> {
    const { wasi, exports, folder, text, memory } = await this.#instance(["ntp", ...args], files);
    let code = UNREADABLE;
    try {
      code = wasi.start({ exports });
    } catch (error) {
      // Memory that is used up, or a mistake of ours: either way the page lives on.
      text.err += `ntp: ${error instanceof Error ? error.message : String(error)}\n`;
    }
    return { run: { code, ...text, made: folder.made() }, memory: memory() };
  }

  /** A file that `ntp check` can read, and takes for this type; null for others. */
  async read(file: Blob, type: string): Promise<{ texture: Texture | null; memory: number }> {
    const { wasi, exports, memory } = await this.#instance(["ntp"], new Map([["texture", file]]));
    wasi.initialize({ exports });
    const at = exports.readTexture(MOST_TEXELS, MOST_SIDE, ENCODINGS.indexOf(type));
    return { texture: at === 0 ? null : textureAt(exports.memory.buffer, at), memory: memory() };
  }
}

function textureAt(memory: ArrayBuffer, at: number): Texture {
  const [samples, width, height, channels, size, drawnWidth, drawnHeight, means, heat] = new Uint32Array(memory, at, 9);
  const pixels = drawnWidth * drawnHeight;
  return {
    width,
    height,
    channels,
    data: new SAMPLES[size](memory, samples, width * height * channels).slice(),
    drawn: { width: drawnWidth, height: drawnHeight },
    means: new Float32Array(memory, means, pixels * channels).slice(),
    heatmap: heat === 0 ? null : new Uint8ClampedArray(memory, heat, 4 * pixels).slice(),
  };
}
