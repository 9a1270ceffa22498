// SPDX-License-Identifier: MIT
// `ntp` itself, in WebAssembly: each run is a new instance, so its memory is given back after it.
import { ConsoleStdout, File, OpenFile, WASI } from "@bjorn3/browser_wasi_shim";
import { Folder } from "./folder.js";
import { jumpImports } from "./jump.js";

export interface Run {
  code: number;
  out: string;
  err: string;
  made: Map<string, Uint8Array>;
}

/** Samples by rows, from the top; floats for PFM. */
export interface Texture {
  width: number;
  height: number;
  channels: number;
  data: Uint8Array | Uint16Array | Float32Array;
  /** Which texels are wrong, as RGB; null where that makes no sense. */
  heatmap: Uint8Array | null;
}

interface Exports extends WebAssembly.Exports {
  memory: WebAssembly.Memory;
  _start(): void;
  __stack_pointer: WebAssembly.Global;
  __indirect_function_table: WebAssembly.Table;
  readTexture(mostTexels: number, encoding: number): number;
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

export class Program {
  readonly #module: WebAssembly.Module;

  constructor(module: WebAssembly.Module) {
    this.#module = module;
  }

  async #instance(args: string[], files: Map<string, Uint8Array>) {
    const text = { out: "", err: "" };
    const collect = (which: "out" | "err") => {
      const decoder = new TextDecoder();
      return new ConsoleStdout((bytes) => {
        text[which] += decoder.decode(bytes, { stream: true });
      });
    };
    const folder = new Folder(files);
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
    return { wasi, exports, folder, text };
  }

  async run(args: string[], files: Map<string, Uint8Array>): Promise<Run> {
    const { wasi, exports, folder, text } = await this.#instance(["ntp", ...args], files);
    let code = UNREADABLE;
    try {
      code = wasi.start({ exports });
    } catch (error) {
      // Memory that is used up, or a mistake of ours: either way the page lives on.
      text.err += `ntp: ${error instanceof Error ? error.message : String(error)}\n`;
    }
    return { code, ...text, made: folder.made() };
  }

  /** A file that `ntp check` can read, and takes for this type; null for others. */
  async read(bytes: Uint8Array, type: string): Promise<Texture | null> {
    const { wasi, exports } = await this.#instance(["ntp"], new Map([["texture", bytes]]));
    wasi.initialize({ exports });
    const at = exports.readTexture(MOST_TEXELS, ENCODINGS.indexOf(type));
    if (at === 0) return null;
    const buffer = exports.memory.buffer;
    const [samples, width, height, channels, size, heat] = new Uint32Array(buffer, at, 6);
    const Samples = SAMPLES[size];
    const data = new Samples(buffer, samples, width * height * channels).slice();
    const heatmap = heat === 0 ? null : new Uint8Array(buffer, heat, 3 * width * height).slice();
    return { width, height, channels, data, heatmap };
  }
}
