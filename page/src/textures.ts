// SPDX-License-Identifier: MIT
// The textures of the page: their files, verdicts and, of the one that is shown, samples.
import type { Crew } from "./crew.js";
import { MOST_TEXELS, type Run, type Texture } from "./program.js";
import { say } from "./words.js";
import { isNormals, type Verdict, verdictOf } from "./verdict.js";

const MOST_BYTES = 2 ** 30;
const LIMITS = ["--max-texels", String(MOST_TEXELS), "--jobs", "1"];

/** Textures with more texels are changed one after the other: each may take a gigabyte. */
const LARGE = 4096 * 4096;

export interface Item {
  name: string;
  /** The name in the program's directory: no slash, no leading dash. */
  file: string;
  blob: Blob;
  verdict: Verdict | null;
  checking: Promise<Verdict> | null;
}

export interface Result {
  name: string;
  blob: Blob;
  /** Files that were made besides: smaller levels. */
  more: Map<string, Blob>;
  /** What `ntp` says of it. */
  said: string;
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

  constructor(crew: Crew) {
    this.crew = crew;
  }

  add(blob: File, path: string): Item {
    const plain = blob.name.replaceAll(/[/\\]/g, "_").replace(/^[-.]+/, "_") || "pasted.png";
    const item = { name: path || plain, file: plain, blob, verdict: null, checking: null };
    this.items.push(item);
    return item;
  }

  clear() {
    this.items.length = 0;
  }

  /** Checks what was added, and tells of each.  One that was chosen meanwhile is not checked twice. */
  async checkAll(items: Item[], tell: (item: Item) => void): Promise<void> {
    await this.crew.each(items, async (item) => {
      if (!this.items.includes(item)) return; // removed
      await this.check(item);
      tell(item);
    });
  }

  check(item: Item): Promise<Verdict> {
    item.checking ??= this.#checkBlob(item.file, item.blob).then((verdict) => (item.verdict = verdict));
    return item.checking;
  }

  async #checkBlob(name: string, blob: Blob): Promise<Verdict> {
    if (blob.size > MOST_BYTES) return refused(`${name}: ${say("tooLarge")}`);
    try {
      const run = await this.crew.run(["check", "--format", "json", ...LIMITS, name], new Map([[name, blob]]));
      return verdictOf(run.out) ?? refused(complaint(run));
    } catch (error) {
      return refused(`${name}: ${String(error)}`);
    }
  }

  /** A texture to look at; null if it cannot be read.  Most hold standard normals, so one that is not
   * checked yet is read as such meanwhile, and again where it is not. */
  async look(item: Item, signal: AbortSignal): Promise<Texture | null> {
    if (item.blob.size > MOST_BYTES) return null;
    const expected = item.verdict?.type ?? "standard";
    const [verdict, texture] = await Promise.all([this.check(item), this.crew.read(item.blob, expected, signal)]);
    if (texture === null || verdict.type === expected) return texture;
    if (isNormals(verdict)) return this.crew.read(item.blob, verdict.type!, signal);
    return { ...texture, heatmap: null };
  }

  /** Runs a verb on one texture.  A message where `ntp` refuses. */
  async act(item: Item, args: string[], output: string, detail: File | null, signal: AbortSignal): Promise<Result | string> {
    const files = new Map([[item.file, item.blob]]);
    const inputs = [item.file];
    if (detail !== null) {
      inputs.push(`detail_${detail.name}`);
      files.set(inputs[1], detail);
    }
    const [verb, ...options] = args;
    const limits = verb === "blend" ? LIMITS.slice(0, 2) : LIMITS;
    const run = await this.crew.run([verb, ...limits, ...options, ...inputs, "-o", output], files, signal);
    const blob = run.made.get(output);
    if (blob === undefined) return complaint(run);
    run.made.delete(output);
    const said = run.out.trim().split("\n")[0].replace(/^.* -> .*?: /, "");
    return { name: output, blob, more: run.made, said, texture: null, verdict: null };
  }

  /** Does something with each, as many at a time as the memory of a browser holds. */
  actOnEach(items: Item[], act: (item: Item) => Promise<void>): Promise<void> {
    const isLarge = ({ verdict }: Item) => (verdict?.width ?? 0) * (verdict?.height ?? 0) > LARGE;
    return this.crew.each(items, act, items.some(isLarge) ? 1 : this.crew.size);
  }

  /** What a result is now. */
  async judge(result: Result, signal: AbortSignal): Promise<void> {
    const item: Item = { name: result.name, file: result.name, blob: result.blob, verdict: null, checking: null };
    result.texture = await this.look(item, signal);
    result.verdict = item.verdict;
  }
}
