// SPDX-License-Identifier: MIT
// The page: what a person does, and what happens then.
import { argumentsOf, commandLine, type Field, initialValues, outputName, remediesOf, type Values, type Verb, VERBS } from "./actions.js";
import { Aborted, Crew } from "./crew.js";
import { List } from "./list.js";
import { Look, type Side } from "./look.js";
import type { Texture } from "./program.js";
import { listenForArrows, mark } from "./rove.js";
import { type Item, type Result, Textures } from "./textures.js";
import { describe, element, shortVerdict, type Verdict } from "./verdict.js";
import { currentLanguage, isWord, type Language, numberOf, say, setLanguage, type Word } from "./words.js";
import { Zip } from "./zip.js";

const PAUSE = 250; // ms after the last key before a result is made anew

const byId = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;

async function unpacked(base64: string): Promise<WebAssembly.Module> {
  const packed = Uint8Array.from(atob(base64.trim()), (letter) => letter.charCodeAt(0));
  const bytes = "DecompressionStream" in self ? await throughStream(packed) : (await import("fflate")).gunzipSync(packed);
  return WebAssembly.compile(bytes as BufferSource);
}

async function throughStream(packed: Uint8Array): Promise<ArrayBuffer> {
  const stream = new Blob([packed as BlobPart]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

function save(name: string, blob: Blob) {
  const link = element("a", "", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

const readingOf = (verdict: Verdict | null) =>
  ({ type: verdict?.type ?? "standard", up: verdict?.y === "down" ? -1 : 1 }) as const;

class Page {
  readonly #textures: Textures;
  readonly #look = new Look();
  readonly #list = new List(
    (item) => void this.#choose(item),
    () => this.#nameDownloadAll(),
  );
  #item: Item | null = null;
  #texture: Texture | null = null;
  #result: Result | null = null;
  #verb: Verb = VERBS[0];
  #values: Values = initialValues(VERBS[0]);
  #detail: File | null = null;
  #looking: AbortController | null = null;
  #working: AbortController | null = null;
  #pause = 0;

  constructor(crew: Crew) {
    this.#textures = new Textures(crew);
    this.#listen();
    this.translate();
  }

  /* ------------------------------------------------------------------- words */

  translate() {
    document.documentElement.lang = currentLanguage();
    document.title = say("title");
    for (const spoken of document.querySelectorAll<HTMLElement>("[data-word]")) {
      const word = spoken.dataset.word ?? "";
      if (isWord(word)) spoken.textContent = say(word);
    }
    this.#look.translate();
    this.#list.show(this.#textures.items, this.#item);
    this.#showVerdict();
    this.#showVerbs();
    this.#showForm();
  }

  /* ------------------------------------------------------------------- files */

  #listen() {
    const input = byId<HTMLInputElement>("input");
    const folder = byId<HTMLInputElement>("input-folder");
    byId("choose").onclick = () => input.click();
    byId("choose-folder").onclick = () => folder.click();
    for (const chosen of [input, folder])
      chosen.onchange = () => {
        this.#add([...(chosen.files ?? [])].map((file) => [file, file.webkitRelativePath || file.name]));
        chosen.value = "";
      };
    const drop = byId("drop");
    addEventListener("dragover", (event) => {
      event.preventDefault();
      drop.classList.add("over");
    });
    addEventListener("dragleave", () => drop.classList.remove("over"));
    addEventListener("drop", (event) => {
      event.preventDefault();
      drop.classList.remove("over");
      void this.#dropped(event.dataTransfer);
    });
    addEventListener("paste", (event) => {
      const files = [...(event.clipboardData?.files ?? [])];
      if (files.length > 0) this.#add(files.map((file) => [file, file.name]));
    });
    byId("clear").onclick = () => this.#clear();
    byId("download").onclick = () => this.#download();
    byId("download-all").onclick = () => void this.#downloadAll();
    byId("copy").onclick = () => void this.#copy();
    const language = byId<HTMLSelectElement>("language");
    language.value = currentLanguage();
    language.onchange = () => {
      setLanguage(language.value as Language);
      this.translate();
    };
    listenForArrows(byId("verbs"));
    byId("form").onsubmit = (event) => event.preventDefault();
  }

  /** Directories too, as deep as they are. */
  async #dropped(data: DataTransfer | null) {
    const entries = [...(data?.items ?? [])].map((item) => item.webkitGetAsEntry?.() ?? null);
    const files: [File, string][] = [];
    const visit = async (entry: FileSystemEntry): Promise<void> => {
      const path = entry.fullPath.replace(/^\//, "");
      if (entry.isFile)
        files.push([await new Promise<File>((take, fail) => (entry as FileSystemFileEntry).file(take, fail)), path]);
      if (!entry.isDirectory) return;
      const reader = (entry as FileSystemDirectoryEntry).createReader();
      for (;;) {
        const some = await new Promise<FileSystemEntry[]>((take, fail) => reader.readEntries(take, fail));
        if (some.length === 0) return;
        for (const inner of some) await visit(inner);
      }
    };
    const plain = [...(data?.files ?? [])];
    if (entries.some((entry) => entry !== null)) for (const entry of entries) entry && (await visit(entry));
    else files.push(...plain.map((file): [File, string] => [file, file.name]));
    this.#add(files);
  }

  #add(files: [File, string][]) {
    const items = files.map(([file, path]) => this.#textures.add(file, path));
    document.querySelector("main")!.classList.toggle("empty", this.#textures.items.length === 0);
    if (this.#item === null && items.length > 0) void this.#choose(items[0]);
    this.#list.show(this.#textures.items, this.#item);
    void this.#textures.checkAll(items, (item) => this.#list.update(item));
  }

  #clear() {
    this.#textures.clear();
    this.#looking?.abort();
    this.#working?.abort();
    this.#item = this.#texture = this.#result = null;
    document.querySelector("main")!.classList.add("empty");
    for (const id of ["verdict", "view", "act"]) byId(id).hidden = true;
    void this.#look.show([]);
    this.#list.show([], null);
    byId("choose").focus();
  }

  /* ----------------------------------------------------------------- verdict */

  async #choose(item: Item) {
    this.#looking?.abort();
    this.#working?.abort();
    const looking = new AbortController();
    this.#looking = looking;
    this.#item = item;
    this.#texture = null;
    this.#setResult(null);
    byId("verdict").hidden = false;
    byId("verdict-title").textContent = item.name;
    byId("verdict-body").replaceChildren(element("p", say("checking")));
    byId("remedies").replaceChildren();
    this.#list.mark(item);
    const verdict = this.#textures.check(item).then((checked) => this.#showChosen(checked, looking.signal));
    try {
      const [texture] = await Promise.all([this.#textures.look(item, looking.signal), verdict]);
      if (!looking.signal.aborted) await this.#showTexture(texture);
    } catch (error) {
      if (!(error instanceof Aborted)) this.#setResult(null, String(error), true);
    }
  }

  #showChosen(verdict: Verdict, signal: AbortSignal) {
    if (signal.aborted) return;
    this.#list.update(this.#item!);
    this.#showVerdict();
    const readable = verdict.status === "ok";
    byId("act").hidden = byId("view").hidden = !readable;
    if (verdict.type === "height" && this.#verb.name !== "from-height") this.#setVerb("from-height");
    if (verdict.type !== "height" && this.#verb.name === "from-height") this.#setVerb("clean");
    this.#showForm();
  }

  async #showTexture(texture: Texture | null) {
    this.#texture = texture;
    byId("view").hidden = texture === null;
    await this.#draw();
  }

  #showVerdict() {
    const verdict = this.#item?.verdict;
    if (verdict == null) return;
    byId("verdict-body").replaceChildren(...describe(verdict));
    const remedies = remediesOf(verdict).map(({ word, verb, values }) => {
      const button = element("button", say(word), { type: "button" });
      button.dataset.remedy = word;
      button.onclick = () => {
        this.#setVerb(verb);
        this.#values = { ...this.#values, ...values };
        this.#showForm();
        this.#later(0);
      };
      return button;
    });
    byId("remedies").replaceChildren(...remedies);
  }

  async #draw() {
    const item = this.#item;
    if (item === null || this.#texture === null) return;
    const sides: Side[] = [{ texture: this.#texture, reading: readingOf(item.verdict) }];
    const result = this.#result;
    if (result?.texture) sides.push({ texture: result.texture, reading: readingOf(result.verdict) });
    await this.#look.show(sides);
  }

  /* ----------------------------------------------------------------- actions */

  #setVerb(name: Word) {
    this.#verb = VERBS.find((verb) => verb.name === name)!;
    this.#values = initialValues(this.#verb);
    this.#showVerbs();
  }

  #showVerbs() {
    const row = byId("verbs");
    const tabs = VERBS.map((verb) => {
      const tab = element("button", say(verb.name), { type: "button" });
      tab.setAttribute("role", "tab");
      tab.setAttribute("aria-controls", "panel");
      tab.dataset.verb = verb.name;
      tab.onclick = () => {
        this.#setVerb(verb.name);
        byId(tab.id).focus();
        this.#showForm();
        this.#later(0);
      };
      tab.id = `verb-${verb.name}`;
      return tab;
    });
    row.replaceChildren(...tabs);
    mark(row, "aria-selected", row.children[VERBS.indexOf(this.#verb)]);
    byId("panel").setAttribute("aria-label", say(this.#verb.name));
  }

  #showForm() {
    byId("form").replaceChildren(...this.#verb.fields.map((field) => this.#fieldOf(field)));
    this.#showCommand();
  }

  #fieldOf(field: Field): HTMLDivElement {
    const { option, kind, initial } = field;
    const id = `option-${option}`;
    const row = element("div", "", { className: "field" });
    const label = element("label", say(option), { htmlFor: id });
    const value = this.#values[option] ?? initial;
    const take = (now: string) => {
      this.#values[option] = now;
      this.#later(kind === "text" || kind === "number" ? PAUSE : 0);
    };
    if (kind === "choice") {
      const select = element("select", "", { id });
      select.append(...field.choices!.map((name) => element("option", name || "–", { value: name })));
      select.value = value;
      select.onchange = () => take(select.value);
      row.append(label, select);
      return row;
    }
    const input = element("input", "", { id });
    if (kind === "check") {
      Object.assign(input, { type: "checkbox", checked: value !== "" });
      input.onchange = () => take(input.checked ? "1" : "");
    } else if (kind === "file") {
      input.type = "file";
      input.onchange = () => {
        this.#detail = input.files?.[0] ?? null;
        this.#later(0);
      };
    } else {
      Object.assign(input, { type: kind === "number" ? "number" : "text", value });
      if (kind === "number") Object.assign(input, { min: field.min, max: field.max, step: field.step });
      input.oninput = () => take(input.value);
    }
    row.append(label, input);
    return row;
  }

  #arguments(): string[] {
    return [this.#verb.name, ...argumentsOf(this.#verb, this.#values)];
  }

  #showCommand() {
    const item = this.#item;
    if (item === null) return;
    const [verb, ...options] = this.#arguments();
    const detail = verb === "blend" ? [this.#detail?.name ?? "DETAIL"] : [];
    const output = outputName(item.file, verb, this.#values);
    byId("command").textContent = commandLine([verb, item.file, ...detail, "-o", output, ...options]);
  }

  /** Makes the result after a pause, in which another key may come. */
  #later(pause: number) {
    this.#showCommand();
    this.#working?.abort();
    this.#setResult(null, say("working"));
    clearTimeout(this.#pause);
    this.#pause = setTimeout(() => void this.#act(), pause);
  }

  async #act() {
    const item = this.#item;
    if (item === null) return;
    this.#working?.abort();
    const working = new AbortController();
    this.#working = working;
    if (this.#verb.name === "blend" && this.#detail === null) {
      this.#setResult(null, say("noDetail"));
      return;
    }
    try {
      const made = await this.#make(item, working.signal);
      if (typeof made === "string") this.#setResult(null, made, true);
      else {
        await this.#textures.judge(made, working.signal);
        if (!working.signal.aborted) this.#setResult(made);
      }
    } catch (error) {
      if (!(error instanceof Aborted)) this.#setResult(null, String(error), true);
    }
    if (!working.signal.aborted) await this.#draw();
  }

  #make(item: Item, signal: AbortSignal) {
    const args = this.#arguments();
    const detail = args[0] === "blend" ? this.#detail : null;
    return this.#textures.act(item, args, outputName(item.file, args[0], this.#values), detail, signal);
  }

  #setResult(result: Result | null, message = "", failed = false) {
    this.#result = result;
    const outcome = byId("outcome");
    byId<HTMLButtonElement>("download").disabled = result === null;
    outcome.className = failed ? "error" : "";
    outcome.lang = failed ? "en" : "";
    outcome.textContent = message;
    if (result?.verdict) {
      const { text, level } = shortVerdict(result.verdict);
      outcome.append(`${say("result")}: `, element("span", text, { className: level }));
      const { width, height, bit_depth: depth } = result.verdict;
      outcome.append(`, ${width} × ${height}, ${depth} bit, ${numberOf(Math.ceil(result.blob.size / 1024))} KiB. `);
      outcome.append(element("span", result.said, { lang: "en", className: "quiet" }));
    }
  }

  /* -------------------------------------------------------------- taking home */

  #download() {
    const result = this.#result;
    if (result === null) return;
    if (result.more.size === 0) return save(result.name, result.blob);
    void this.#zipped([result]).then((blob) => save(result.name.replace(/\.[^.]*$/, ".zip"), blob));
  }

  async #zipped(results: Result[]): Promise<Blob> {
    const zip = new Zip();
    for (const { name, blob, more } of results)
      for (const [path, file] of [[name, blob] as const, ...more]) await zip.add(path, file);
    return zip.finish();
  }

  #nameDownloadAll() {
    const all = this.#list.shown().length === this.#textures.items.length;
    byId("download-all").dataset.word = all ? "downloadAll" : "downloadShown";
    byId("download-all").textContent = say(all ? "downloadAll" : "downloadShown");
  }

  /** What was refused is said in a text file: a zip without it would look complete. */
  async #downloadAll() {
    const items = this.#list.shown();
    const zip = new Zip();
    const notes: string[] = [];
    const verb = this.#verb.name;
    this.#working?.abort();
    const working = new AbortController();
    this.#working = working;
    let done = 0;
    const act = async (item: Item) => {
      const made = await this.#make(item, working.signal);
      const folder = item.name.includes("/") ? item.name.replace(/[^/]*$/, "") : "";
      if (typeof made === "string") notes.push(made);
      else for (const [name, file] of [[made.name, made.blob] as const, ...made.more]) await zip.add(folder + name, file);
      this.#setResult(null, `${++done} ${say("of")} ${items.length}`);
    };
    try {
      await this.#textures.actOnEach(items, act);
      if (notes.length > 0) await zip.add("not-done.txt", new Blob([`${notes.join("\n")}\n`]));
      this.#setResult(null, notes.join(" · "));
      save(`${verb}.zip`, zip.finish());
    } catch (error) {
      if (!(error instanceof Aborted)) this.#setResult(null, String(error), true);
    }
  }

  async #copy() {
    const command = byId("command");
    const text = command.textContent ?? "";
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      getSelection()?.selectAllChildren(command); // from file:// there may be no clipboard
      document.execCommand("copy");
    }
    const button = byId("copy");
    button.textContent = say("copied");
    setTimeout(() => (button.textContent = say("copy")), 1500);
  }
}

async function start() {
  try {
    const module = await unpacked(byId("module").textContent ?? "");
    const address = URL.createObjectURL(new Blob([byId("worker").textContent ?? ""], { type: "text/javascript" }));
    const crew = new Crew(() => {
      const worker = new Worker(address);
      worker.postMessage({ module });
      return worker;
    });
    document.querySelector("main")!.classList.add("empty");
    new Page(crew);
    const { out } = await crew.run(["--version"], new Map());
    byId("version").textContent = out.trim().replaceAll("\n", ", ");
    document.documentElement.dataset.ready = "true";
  } catch (error) {
    byId("summary").textContent = `${say("noModule")} (${error instanceof Error ? error.message : String(error)})`;
  }
}

void start();
