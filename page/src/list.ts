// SPDX-License-Identifier: MIT
// The list of textures: a line for each, found by name, sifted by verdict, in the wanted order.
import type { Item } from "./textures.js";
import { element, severityOf, shortVerdict, typeOf } from "./verdict.js";
import { say, type Word } from "./words.js";

const FEW = 6; // that nobody needs to sift

type Kind = "unreadable" | "error" | "warning" | "good" | "waiting";
const KINDS: readonly Kind[] = ["unreadable", "error", "warning", "good", "waiting"];
const NAMES: Record<Kind, Word> = {
  unreadable: "unreadable",
  error: "withErrors",
  warning: "withWarnings",
  good: "wellFormed",
  waiting: "waiting",
};

const byId = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;

function kindOf({ verdict }: Item): Kind {
  if (verdict === null) return "waiting";
  return verdict.status === "ok" ? severityOf(verdict) : "unreadable";
}

export class List {
  readonly #choose: (item: Item) => void;
  readonly #changed: () => void;
  readonly #lines = new Map<Item, HTMLLIElement>();
  readonly #find = byId<HTMLInputElement>("find");
  readonly #only = byId<HTMLSelectElement>("only");
  readonly #order = byId<HTMLSelectElement>("order");
  #items: readonly Item[] = [];
  #current: Item | null = null;
  #drawing = 0;

  /** Calls `choose` with the item of a pressed line, and `changed` when others are shown. */
  constructor(choose: (item: Item) => void, changed: () => void) {
    this.#choose = choose;
    this.#changed = changed;
    this.#find.oninput = () => this.#draw();
    this.#only.onchange = () => this.#draw();
    this.#order.onchange = () => this.#draw();
  }

  show(items: readonly Item[], current: Item | null) {
    this.#items = items;
    this.#current = current;
    this.#lines.clear();
    if (items.length === 0) {
      this.#find.value = "";
      this.#only.value = "";
    }
    this.#draw();
  }

  /** A verdict came; several that come at once are drawn once. */
  update(item: Item) {
    this.#lines.delete(item);
    if (this.#drawing === 0)
      this.#drawing = requestAnimationFrame(() => {
        this.#drawing = 0;
        this.#draw();
      });
  }

  mark(item: Item | null) {
    this.#current = item;
    for (const [other, line] of this.#lines) this.#markLine(line, other);
  }

  /** Those that are shown, in the order in which they are. */
  shown(): Item[] {
    const [find, only] = [this.#find.value.toLowerCase(), this.#only.value];
    const some = this.#items.filter(
      (item) => item.name.toLowerCase().includes(find) && (only === "" || kindOf(item) === only),
    );
    if (this.#order.value === "name") return some.sort((a, b) => a.name.localeCompare(b.name, undefined, { numeric: true }));
    if (this.#order.value === "worst") return some.sort((a, b) => KINDS.indexOf(kindOf(a)) - KINDS.indexOf(kindOf(b)));
    return some;
  }

  #draw() {
    const done = this.#items.filter(({ verdict }) => verdict !== null).length;
    byId("sift").hidden = this.#items.length < FEW;
    byId("clear").hidden = this.#items.length === 0;
    byId("summary").textContent =
      this.#items.length > 1 ? `${done} ${say("of")} ${this.#items.length} ${say("checked")}` : "";
    this.#drawKinds();
    const focused = document.activeElement?.closest("li");
    byId("list").replaceChildren(...this.shown().map((item) => this.#line(item)));
    if (focused?.isConnected) focused.querySelector("button")!.focus();
    this.#changed();
  }

  #drawKinds() {
    const only = this.#only.value;
    const options = [element("option", `${say("all")} (${this.#items.length})`, { value: "" })];
    for (const kind of KINDS) {
      const count = this.#items.filter((item) => kindOf(item) === kind).length;
      if (count > 0 || kind === only) options.push(element("option", `${say(NAMES[kind])} (${count})`, { value: kind }));
    }
    this.#only.replaceChildren(...options);
    this.#only.value = only;
  }

  #line(item: Item): HTMLLIElement {
    let line = this.#lines.get(item);
    if (line === undefined) {
      line = this.#newLine(item);
      this.#lines.set(item, line);
    }
    this.#markLine(line, item);
    return line;
  }

  #newLine(item: Item): HTMLLIElement {
    const button = element("button", item.name, { type: "button" });
    const { verdict } = item;
    const { text, level } = verdict === null ? { text: say("waiting"), level: "quiet" } : shortVerdict(verdict);
    const small = element("small", text, { className: level });
    if (verdict?.type) small.append(element("span", ` · ${typeOf(verdict)}`, { className: "quiet" }));
    button.append(small);
    button.onclick = () => this.#choose(item);
    const line = element("li");
    line.append(button);
    return line;
  }

  #markLine(line: HTMLLIElement, item: Item) {
    const button = line.querySelector("button")!;
    if (item === this.#current) button.setAttribute("aria-current", "true");
    else button.removeAttribute("aria-current");
  }
}
