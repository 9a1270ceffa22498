// SPDX-License-Identifier: MIT
// The textures of the page: their files, verdicts and, of the one that is shown, samples.
import { Crew } from "./crew.js";
import { MOST_TEXELS, type Run, type Texture } from "./program.js";
import { say } from "./words.js";
import { type Verdict, verdictOf } from "./verdict.js";

const MOST_BYTES = 2 ** 30;
const LIMITS = ["--max-texels", String(MOST_TEXELS), "--jobs", "1"];

export interface Item {
  name: string;
  /** The name in the program's directory: no slash, no leading dash. */
  file: string;
  blob: Blob;
  verdict: Verdict | null;
}

export interface Result {
  name: string;
  bytes: Uint8Array;
  more: Map<string, Uint8Array>;
  texture: Texture | null;
  verdict: Verdict | null;
}

const refused = (message: string) =>
  ({ status: "unreadable", message, findings: [], type: null }) as unknown as Verdict;

/** What the program complains about, without its own name. */
const complaint = ({ err, code }: Run) => err.trim().replace(/^ntp: /, "") || `ntp: ${code}`;

export class Textures {
  readonly crew: Crew;
  readonly items: Item[] = [];
  #count = 0;

  constructor(crew: Crew) {
    this.crew = crew;
  }

  add(blob: File, path = blob.name): Item {
    const plain = blob.name.replaceAll(/[/\\]/g, "_").replace(/^[-.]+/, "_") || "pasted.png";
    this.#count++;
    const item = { name: path || plain, file: plain, blob, verdict: null };
    this.items.push(item);
    return item;
  }

  clear() {
    this.items.length = 0;
  }

  static async bytes({ blob }: { blob: Blob }): Promise<Uint8Array> {
    return new Uint8Array(await blob.arrayBuffer());
  }

  async check(item: Item, urgent: boolean): Promise<Verdict> {
    if (item.verdict !== null) return item.verdict;
    if (item.blob.size > MOST_BYTES) item.verdict = refused(`${item.name}: ${say("tooLarge")}`);
    else item.verdict = await this.#checkBytes(item.file, await Textures.bytes(item), urgent);
    return item.verdict;
  }

  async #checkBytes(name: string, bytes: Uint8Array, urgent: boolean): Promise<Verdict> {
    const args = ["check", "--format", "json", ...LIMITS, name];
    const run = await this.crew.run(args, new Map([[name, bytes]]), urgent);
    return verdictOf(run.out) ?? refused(complaint(run));
  }

  /** A checked texture to look at; null if it cannot be read. */
  async look(item: Item): Promise<Texture | null> {
    return this.crew.read(await Textures.bytes(item), item.verdict?.type ?? "");
  }

  /** Runs a verb on one texture.  A message where `ntp` refuses. */
  async act(item: Item, args: string[], output: string, detail: File | null, signal: AbortSignal): Promise<Result | string> {
    const files = new Map([[item.file, await Textures.bytes(item)]]);
    const inputs = [item.file];
    if (detail !== null) {
      inputs.push(`detail_${detail.name}`);
      files.set(inputs[1], await Textures.bytes({ blob: detail }));
    }
    const [verb, ...options] = args;
    const limits = verb === "blend" ? LIMITS.slice(0, 2) : LIMITS;
    const run = await this.crew.run([verb, ...limits, ...options, ...inputs, "-o", output], files, true, signal);
    const bytes = run.made.get(output);
    if (bytes === undefined) return complaint(run);
    run.made.delete(output);
    return { name: output, bytes, more: run.made, texture: null, verdict: null };
  }

  /** What a result is now. */
  async judge(result: Result): Promise<void> {
    result.verdict = await this.#checkBytes(result.name, result.bytes, true);
    result.texture = await this.crew.read(result.bytes, result.verdict.type ?? "");
  }
}
