// SPDX-License-Identifier: MIT
// The workers, and what waits for them.
import type { Done, Work } from "./messages.js";
import type { Run, Texture } from "./program.js";

const MOST_WORKERS = 4;

type Task = Work extends infer W ? (W extends Work ? Omit<W, "id"> : never) : never;

interface Waiting {
  task: Task;
  urgent: boolean;
  resolve(done: Done): void;
  signal: AbortSignal | null;
}

export class Aborted extends Error {}

interface Member {
  worker: Worker;
  busy: Waiting | null;
}

export class Crew {
  readonly #start: () => Worker;
  readonly #members: Member[] = [];
  #waiting: Waiting[] = [];

  /** `start` makes a worker that has the module. */
  constructor(start: () => Worker) {
    this.#start = start;
  }

  /** Runs `ntp`.  What is urgent goes before what is not. */
  async run(args: string[], files: Map<string, Uint8Array>, urgent = false, signal: AbortSignal | null = null) {
    const done = await this.#do({ kind: "run", args, files }, urgent, signal);
    return (done as { run: Run }).run;
  }

  async read(bytes: Uint8Array, type: string): Promise<Texture | null> {
    const done = await this.#do({ kind: "read", bytes, type }, true, null);
    return (done as { texture: Texture | null }).texture;
  }

  async #do(task: Task, urgent: boolean, signal: AbortSignal | null): Promise<Done> {
    const done = await new Promise<Done>((resolve) => {
      const waiting = { task, urgent, resolve, signal };
      if (urgent) this.#waiting.unshift(waiting);
      else this.#waiting.push(waiting);
      signal?.addEventListener("abort", () => this.#stop(waiting), { once: true });
      this.#next();
    });
    if (signal?.aborted) throw new Aborted();
    if ("failed" in done) throw new Error(done.failed);
    return done;
  }

  #next() {
    while (this.#waiting.length > 0) {
      const free = this.#members.find(({ busy }) => busy === null) ?? this.#grow();
      if (free === null) return;
      const waiting = this.#waiting.shift()!;
      free.busy = waiting;
      free.worker.postMessage({ id: 0, ...waiting.task });
    }
  }

  #grow(): Member | null {
    const most = Math.min(MOST_WORKERS, navigator.hardwareConcurrency || 1);
    if (this.#members.length >= most) return null;
    const member: Member = { worker: this.#start(), busy: null };
    member.worker.onmessage = (event: MessageEvent<Done>) => this.#finish(member, event.data);
    member.worker.onerror = (event) => this.#finish(member, { id: 0, failed: event.message });
    this.#members.push(member);
    return member;
  }

  #finish(member: Member, done: Done) {
    const { busy } = member;
    member.busy = null;
    busy?.resolve(done);
    this.#next();
  }

  /** A worker that computes hears nothing: it is ended, and another begins. */
  #stop(waiting: Waiting) {
    this.#waiting = this.#waiting.filter((other) => other !== waiting);
    const at = this.#members.findIndex(({ busy }) => busy === waiting);
    if (at >= 0) this.#members.splice(at, 1)[0].worker.terminate();
    waiting.resolve({ id: 0, failed: "" });
    this.#next();
  }
}
