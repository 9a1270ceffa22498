// SPDX-License-Identifier: MIT
// A worker runs the program; it does one thing after the other.
import type { Done, Setup, Work } from "./messages.js";
import { Program } from "./program.js";

let program: Program;

async function work(task: Work): Promise<Done> {
  try {
    if (task.kind === "run") return await program.run(task.args, task.files);
    return await program.read(task.file, task.type);
  } catch (error) {
    return { memory: Infinity, failed: error instanceof Error ? error.message : String(error) };
  }
}

function buffersOf(done: Done): Transferable[] {
  if (!("texture" in done) || done.texture === null) return [];
  const { data, means, heatmap } = done.texture;
  return [data, means, heatmap].flatMap((samples) => (samples === null ? [] : [samples.buffer as ArrayBuffer]));
}

self.onmessage = async (event: MessageEvent<Setup | Work>) => {
  if ("module" in event.data) {
    program = new Program(event.data.module);
    return;
  }
  const done = await work(event.data);
  self.postMessage(done, { transfer: buffersOf(done) });
};
