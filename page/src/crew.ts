// SPDX-License-Identifier: MIT
// The workers, and what waits for them.
import type { Done, Files, Work } from "./messages.js";
import type { Run, Texture } from "./program.js";

const MOST_WORKERS = 4;

/** A worker that took more bytes is ended after its work: only so they are given back at once. */
const MUCH_MEMORY = 1 << 27;

interface Waiting {
  task: Work;
  resolve(done: Done): void;
}

export class Aborted extends Error {}

interface Member {
  worker: Worker;
  busy: Waiting | null;
}

export class Crew {
  /** How many work at the same time. */
  readonly size = Math.min(MOST_WORKERS, navigator.hardwareConcurrency || 1);
  readonly #start: () => Worker;
  #members: Member[] = [];
  #waiting: Waiting[] = [];

  /** `start` makes a worker that has the module. */
  constructor(start: () => Worker) {
    this.#start = start;
  }

  /** Runs `ntp`. */
  async run(args: string[], files: Files, signal: AbortSignal | null = null): Promise<Run> {
    const done = await this.#do({ kind: "run", args, files }, signal);
    return (done as { run: Run }).run;
  }

  async read(file: Blob, type: string, signal: AbortSignal | null = null): Promise<Texture | null> {
    const done = await this.#do({ kind: "read", file, type }, signal);
    return (done as { texture: Texture | null }).texture;
  }

  /** Does something with each item, as many at a time as there are workers. */
  async each<T>(items: Iterable<T>, work: (item: T) => Promise<void>, atOnce = this.size): Promise<void> {
    const rest = items[Symbol.iterator]();
    const some = async () => {
      for (let next = rest.next(); !next.done; next = rest.next()) await work(next.value);
    };
    await Promise.all(Array.from({ length: atOnce }, some));
  }

  async #do(task: Work, signal: AbortSignal | null): Promise<Done> {
    if (signal?.aborted) throw new Aborted();
    const done = await new Promise<Done>((resolve) => {
      const waiting = { task, resolve };
      this.#waiting.push(waiting);
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
      free.busy = this.#waiting.shift()!;
      free.worker.postMessage(free.busy.task);
    }
  }

  #grow(): Member | null {
    if (this.#members.length >= this.size) return null;
    const member: Member = { worker: this.#start(), busy: null };
    member.worker.onmessage = (event: MessageEvent<Done>) => this.#finish(member, event.data);
    member.worker.onerror = (event) => this.#finish(member, { memory: Infinity, failed: event.message });
    this.#members.push(member);
    return member;
  }

  #finish(member: Member, done: Done) {
    const { busy } = member;
    member.busy = null;
    if (done.memory > MUCH_MEMORY) this.#end(member);
    busy?.resolve(done);
    this.#next();
  }

  #end(member: Member) {
    this.#members = this.#members.filter((other) => other !== member);
    member.worker.terminate();
  }

  /** A worker that computes hears nothing: it is ended, and another begins. */
  #stop(waiting: Waiting) {
    this.#waiting = this.#waiting.filter((other) => other !== waiting);
    const member = this.#members.find(({ busy }) => busy === waiting);
    if (member !== undefined) this.#end(member);
    waiting.resolve({ memory: 0, failed: "" });
    this.#next();
  }
}
