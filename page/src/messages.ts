// SPDX-License-Identifier: MIT
// What the page and its workers say to each other.  Files travel as blobs: their bytes are read where
// they are needed, and by nobody else.
import type { Run, Texture } from "./program.js";

export type Files = Map<string, Blob>;

export interface Setup {
  module: WebAssembly.Module;
}

export type Work = { kind: "run"; args: string[]; files: Files } | { kind: "read"; file: Blob; type: string };

/** `memory`: the bytes that the work took. */
export type Done = { memory: number } & ({ run: Run } | { texture: Texture | null } | { failed: string });
