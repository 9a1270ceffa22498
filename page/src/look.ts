// SPDX-License-Identifier: MIT
// The picture of the chosen texture: ways to look at it, the light, the loupe, before and after.
import { litPlane, litSphere, type Light, type Mode, MODES, Picture, type Reading, texelAt, vectorOf } from "./picture.js";
import type { Texture } from "./program.js";
import { listenForArrows, mark } from "./rove.js";
import { element } from "./verdict.js";
import { say, type Word } from "./words.js";

/** One side of before and after. */
export interface Side {
  texture: Texture;
  reading: Reading;
}

const byId = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;
const LOUPE = 64; // texels that fit across an enlarged picture
const STEP = 0.1;

export class Look {
  readonly #canvas = byId<HTMLCanvasElement>("canvas");
  readonly #split = byId<HTMLInputElement>("split");
  readonly #loupe = byId<HTMLParagraphElement>("loupe");
  readonly #hint = byId<HTMLParagraphElement>("hint");
  #mode: Mode = "texture";
  #light: Light = { x: -0.6, y: 0.6 };
  #sides: Side[] = [];
  #drawn = new Map<Texture, Picture>();
  #texel = { x: 0, y: 0 };
  #order = 0;

  constructor() {
    this.#split.oninput = () => this.draw();
    this.#canvas.onpointermove = (event) => this.#point(event);
    this.#canvas.onpointerdown = (event) => {
      this.#canvas.setPointerCapture(event.pointerId);
      this.#point(event);
    };
    listenForArrows(byId("modes"));
    this.#canvas.onkeydown = (event) => this.#press(event);
    this.translate();
  }

  translate() {
    const modes = byId<HTMLDivElement>("modes");
    modes.replaceChildren(...MODES.map((mode) => this.#modeButton(modes, mode)));
    mark(modes, "aria-checked", modes.children[MODES.indexOf(this.#mode)]);
    this.#split.setAttribute("aria-label", say("split"));
    this.#say();
  }

  #modeButton(modes: HTMLElement, mode: Mode): HTMLButtonElement {
    const button = element("button", say(mode), { type: "button" });
    button.setAttribute("role", "radio");
    button.dataset.mode = mode;
    button.onclick = () => {
      this.#mode = mode;
      mark(modes, "aria-checked", button);
      this.#say();
      this.draw();
    };
    return button;
  }

  #say() {
    const words: Record<Mode, Word> = {
      texture: "pointAtTexel",
      heatmap: "heatmapLegend",
      lit: "moveLight",
      sphere: "moveLight",
      tiles: "moveLight",
    };
    this.#hint.textContent = say(words[this.#mode]);
    this.#canvas.setAttribute("aria-label", `${say(this.#mode)}. ${this.#hint.textContent}`);
  }

  /** Before alone, or before and after. */
  show(sides: Side[]) {
    this.#sides = sides;
    const kept = new Map<Texture, Picture>();
    for (const { texture } of sides) {
      const drawn = this.#drawn.get(texture);
      if (drawn !== undefined) kept.set(texture, drawn);
    }
    this.#drawn = kept;
    this.#split.hidden = sides.length < 2;
    this.#loupe.textContent = "";
    delete this.#canvas.dataset.drawn;
    return this.draw();
  }

  async draw() {
    const order = ++this.#order;
    if (this.#sides.length === 0) return;
    const images = this.#sides.map((side) => this.#image(side));
    const repeat = this.#mode === "tiles" ? 2 : 1;
    const { width, height } = images[0];
    const canvas = this.#canvas;
    canvas.width = width * repeat;
    canvas.height = height * repeat;
    const context = canvas.getContext("2d")!;
    context.imageSmoothingEnabled = width > LOUPE;
    const sources = await Promise.all(images.map((image) => createImageBitmap(image)));
    if (order !== this.#order) return;
    const edge = sources.length > 1 ? Math.round((canvas.width * Number(this.#split.value)) / 100) : canvas.width;
    this.#half(context, sources[0], 0, edge, width, height);
    if (sources.length > 1) this.#half(context, sources[1], edge, canvas.width, width, height);
    canvas.style.imageRendering = width <= LOUPE ? "pixelated" : "auto";
    canvas.dataset.drawn = `${this.#mode} ${sources.length}`;
  }

  #half(context: CanvasRenderingContext2D, image: ImageBitmap, from: number, to: number, width: number, height: number) {
    context.save();
    context.beginPath();
    context.rect(from, 0, to - from, context.canvas.height);
    context.clip();
    for (let y = 0; y < context.canvas.height; y += height)
      for (let x = 0; x < context.canvas.width; x += width) context.drawImage(image, x, y, width, height);
    context.restore();
  }

  #image({ texture, reading }: Side): ImageData {
    const picture = this.#drawn.get(texture) ?? new Picture(texture);
    this.#drawn.set(texture, picture);
    if (this.#mode === "sphere") return litSphere(picture, reading, this.#light);
    if (this.#mode === "lit" || this.#mode === "tiles") return litPlane(picture, reading, this.#light);
    const { heatmap, drawn } = texture;
    if (this.#mode === "texture" || heatmap === null) return picture.colors();
    return new ImageData(heatmap, drawn.width, drawn.height);
  }

  /* ------------------------------------------------------------- pointer and keys */

  #point(event: PointerEvent) {
    const area = this.#canvas.getBoundingClientRect();
    const u = Math.min(0.999999, Math.max(0, (event.clientX - area.left) / area.width));
    const v = Math.min(0.999999, Math.max(0, (event.clientY - area.top) / area.height));
    if (this.#mode === "texture" || this.#mode === "heatmap") this.#read(u, v);
    else if (event.buttons !== 0) this.#shine(2 * u - 1, 1 - 2 * v);
  }

  #shine(x: number, y: number) {
    const within = (value: number) => Math.min(1.5, Math.max(-1.5, value));
    this.#light = { x: within(x), y: within(y) };
    void this.draw();
  }

  #press(event: KeyboardEvent) {
    const [dx, dy] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key] ?? [0, 0];
    if ((dx === 0 && dy === 0) || this.#sides.length === 0) return;
    event.preventDefault();
    if (this.#mode === "texture" || this.#mode === "heatmap") {
      const { width, height } = this.#sides[0].texture;
      const x = Math.min(width - 1, Math.max(0, this.#texel.x + dx));
      const y = Math.min(height - 1, Math.max(0, this.#texel.y - dy));
      this.#read((x + 0.5) / width, (y + 0.5) / height);
    } else this.#shine(this.#light.x + STEP * dx, this.#light.y + STEP * dy);
  }

  /** The texel at a place of the picture, in 0..1; of both sides if there are two. */
  #read(u: number, v: number) {
    const lines = this.#sides.map(({ texture, reading }, side) => {
      const x = Math.floor(u * texture.width);
      const y = Math.floor(v * texture.height);
      if (side === 0) this.#texel = { x, y };
      const texel = texelAt(texture, x, y);
      const { vector, length } = vectorOf(texel, texture, reading.type);
      const name = this.#sides.length > 1 ? `${say(side === 0 ? "before" : "after")} ` : "";
      const numbers = vector.map((value) => value.toFixed(3)).join(", ");
      const normal = reading.type === "height" ? "" : ` = ${numbers}; ${say("length")} ${length.toFixed(4)}`;
      return `${name}(${x}, ${y}): ${texel.join(", ")}${normal}`;
    });
    this.#loupe.textContent = lines.join(" · ");
  }
}
