// SPDX-License-Identifier: MIT
// What can be done with a texture: the verbs of `ntp` and those of their options that the page shows.
// An option with its default is left out, so the command line is as short as a person would type it.
import type { Verdict } from "./verdict.js";
import type { Word } from "./words.js";

export interface Field {
  option: Word;
  kind: "choice" | "number" | "check" | "text" | "file";
  initial: string;
  choices?: readonly string[];
  min?: number;
  max?: number;
  step?: number;
}

export interface Verb {
  name: Word;
  fields: readonly Field[];
}

const choice = (option: Word, ...choices: string[]): Field => ({
  option,
  kind: "choice",
  initial: choices[0],
  choices,
});
const check = (option: Word): Field => ({ option, kind: "check", initial: "" });
const number = (option: Word, initial: string, min: number, max: number, step: number): Field => ({
  option,
  kind: "number",
  initial,
  min,
  max,
  step,
});
const text = (option: Word, initial = ""): Field => ({ option, kind: "text", initial });

const BORDERS = ["wrap", "clamp", "mirror"];
const HEIGHT_BORDERS = [...BORDERS, "extrapolate", "repeat-slope"];
const KERNELS = ["central", "forward", "prewitt3", "sobel3", "scharr3", "prewitt5", "sobel5", "gimp5", "gimp7", "gimp9"];
const SOURCES = ["red", "green", "blue", "alpha", "luma", "mean", "max", "min", "screen"];
const type = choice("type", "auto", "standard", "zzero", "xy");
const y = choice("y", "auto", "up", "down");

export const VERBS: readonly Verb[] = [
  {
    name: "clean",
    fields: [type, choice("method", "auto", "derive", "normalize"), check("undo"), check("only-failing"), check("touch-unused")],
  },
  {
    name: "convert",
    fields: [
      type,
      choice("to", "", "standard", "zzero", "xy"),
      y,
      choice("to-y", "", "up", "down"),
      choice("depth", "", "8", "16"),
      choice("format", "png", "tga", "dds", "ktx2"),
    ],
  },
  {
    name: "resize",
    fields: [type, text("size", "50%"), check("mips"), choice("filter", "", "box", "triangle", "lanczos3"), choice("border", ...BORDERS)],
  },
  {
    name: "transform",
    fields: [
      type,
      number("strength", "1", -10, 10, 0.1),
      choice("flip", "", "x", "y", "xy"),
      number("rotate", "0", -360, 360, 1),
      choice("border", ...BORDERS),
      y,
    ],
  },
  {
    name: "blend",
    fields: [
      { option: "detail", kind: "file", initial: "" },
      choice("mode", "rnm", "whiteout", "udn", "linear"),
      number("strength", "1", -10, 10, 0.1),
      y,
      choice("detail-y", "auto", "up", "down"),
    ],
  },
  {
    name: "from-height",
    fields: [
      text("scale", "auto"),
      choice("kernel", ...KERNELS),
      choice("border", ...HEIGHT_BORDERS),
      choice("source", ...SOURCES),
      number("blur", "0", 0, 100, 0.5),
      text("octaves"),
      choice("to-y", "up", "down"),
      choice("depth", "", "8", "16"),
      choice("dither", "none", "integrable"),
      check("invert"),
      check("force"),
    ],
  },
  {
    name: "to-height",
    fields: [
      type,
      y,
      choice("kernel", "auto", ...KERNELS, "baked"),
      choice("border", "auto", ...HEIGHT_BORDERS),
      number("refine", "0", 0, 200, 1),
      check("force"),
    ],
  },
];

export type Values = Record<string, string>;

export const initialValues = (verb: Verb): Values =>
  Object.fromEntries(verb.fields.map(({ option, initial }) => [option, initial]));

/** Options that the program must see although the page has the same default as it. */
const ALWAYS = ["size", "scale"];

/** The arguments after the verb and the input's name, without the output. */
export function argumentsOf(verb: Verb, values: Values): string[] {
  const args: string[] = [];
  for (const { option, kind, initial } of verb.fields) {
    const value = values[option] ?? initial;
    if (kind === "file" || option === "format" || value === "") continue;
    if (kind === "check") args.push(`--${option}`);
    else if (option === "size" && values.mips) continue; // the chain begins with the texture itself
    else if (value !== initial || ALWAYS.includes(option)) args.push(`--${option}`, value);
  }
  return args;
}

/** As a person would type it. */
export function commandLine(args: readonly string[]): string {
  return ["ntp", ...args].map((arg) => (/^[\w./%:=,+-]+$/.test(arg) ? arg : `'${arg.replaceAll("'", `'\\''`)}'`)).join(" ");
}

export const outputName = (input: string, verb: string, { format = "png" }: Values): string =>
  `${input.replace(/\.[^.]*$/, "")}_${verb}.${format}`;

export interface Remedy {
  word: Word;
  verb: Word;
  values: Values;
}

/** One click for what a verdict names. */
export function remediesOf(verdict: Verdict): Remedy[] {
  const found = new Set(verdict.findings.map(({ id }) => id));
  const has = (...ids: string[]) => ids.some((id) => found.has(id));
  const remedies: Remedy[] = [];
  if (verdict.type === "height") return [{ word: "from-height", verb: "from-height", values: {} }];
  if (!["standard", "zzero", "xy"].includes(verdict.type ?? "")) return [];
  if (has("NT012", "NT040")) remedies.push({ word: "undoIt", verb: "clean", values: { undo: "1" } });
  if (has("NT001", "NT002", "NT003", "NT020", "NT035")) remedies.push({ word: "cleanIt", verb: "clean", values: {} });
  if (verdict.type !== "standard") remedies.push({ word: "standardIt", verb: "convert", values: { to: "standard" } });
  const from = verdict.y === "down" ? "down" : "up";
  remedies.push({ word: "flipIt", verb: "convert", values: { y: from, "to-y": from === "up" ? "down" : "up" } });
  return remedies;
}
