// SPDX-License-Identifier: MIT
// What the page and its workers say to each other.
import type { Run, Texture } from "./program.js";

export interface Setup {
  module: WebAssembly.Module;
}

export type Work =
  | { id: number; kind: "run"; args: string[]; files: Map<string, Uint8Array> }
  | { id: number; kind: "read"; bytes: Uint8Array; type: string };

export type Done = { id: number } & ({ run: Run } | { texture: Texture | null } | { failed: string });
