// SPDX-License-Identifier: MIT
// A worker runs the program; it does one thing after the other.
import type { Done, Setup, Work } from "./messages.js";
import { Program } from "./program.js";

let program: Program;

async function work(task: Work): Promise<Done> {
  const { id } = task;
  try {
    if (task.kind === "run") return { id, run: await program.run(task.args, task.files) };
    return { id, texture: await program.read(task.bytes, task.type) };
  } catch (error) {
    return { id, failed: error instanceof Error ? error.message : String(error) };
  }
}

function buffersOf(done: Done): Transferable[] {
  if ("run" in done) return [...done.run.made.values()].map((bytes) => bytes.buffer as ArrayBuffer);
  if (!("texture" in done) || done.texture === null) return [];
  const { data, heatmap } = done.texture;
  return [data, heatmap].flatMap((samples) => (samples === null ? [] : [samples.buffer as ArrayBuffer]));
}

self.onmessage = async (event: MessageEvent<Setup | Work>) => {
  if ("module" in event.data) {
    program = new Program(event.data.module);
    return;
  }
  const done = await work(event.data);
  self.postMessage(done, { transfer: buffersOf(done) });
};
