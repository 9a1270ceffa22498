// SPDX-License-Identifier: MIT
// What `ntp check --format json` says of one file, and how it is shown.
import { isWord, numberOf, say, subjectOf, type Word } from "./words.js";

export interface Finding {
  id: string;
  level: "error" | "warning" | "info";
  message: string;
}

export interface Verdict {
  status: "ok" | "unreadable" | "unsupported";
  message: string | null;
  width: number;
  height: number;
  bit_depth: number;
  channels: number;
  type: string | null;
  confidence: number;
  reasons: string[];
  y: "up" | "down" | "undecided";
  y_confidence: number;
  texels: number;
  used: { texels: number; fail: { neighbor: number } | null } | null;
  angle_deg: { mean: number; p99: number; max: number } | null;
  findings: Finding[];
}

/** The only file of a report; null where `ntp` ended without one. */
export function verdictOf(report: string): Verdict | null {
  try {
    return (JSON.parse(report) as { files: Verdict[] }).files[0] ?? null;
  } catch {
    return null;
  }
}

export function element<K extends keyof HTMLElementTagNameMap>(
  name: K,
  text = "",
  properties: Partial<HTMLElementTagNameMap[K]> = {},
): HTMLElementTagNameMap[K] {
  return Object.assign(document.createElement(name), { textContent: text }, properties);
}

function counted(count: number, one: "error" | "warning", many: "errors" | "warnings") {
  return count > 0 ? [`${count} ${say(count === 1 ? one : many)}`] : [];
}

const CHANNELS = ["", "gray", "gray + alpha", "RGB", "RGBA"];

const ofLevel = (verdict: Verdict, level: Finding["level"]) =>
  verdict.findings.filter((finding) => finding.level === level).length;

export type Severity = "error" | "warning" | "good";

export function severityOf(verdict: Verdict): Severity {
  if (verdict.status !== "ok" || ofLevel(verdict, "error") > 0) return "error";
  return ofLevel(verdict, "warning") > 0 ? "warning" : "good";
}

/** As the end of the first line of `ntp check`: the worst that was found. */
export function shortVerdict(verdict: Verdict): { text: string; level: Severity } {
  const level = severityOf(verdict);
  if (verdict.status !== "ok") return { text: say("unreadable"), level };
  const [errors, warnings] = [ofLevel(verdict, "error"), ofLevel(verdict, "warning")];
  const parts = [...counted(errors, "error", "errors"), ...counted(warnings, "warning", "warnings")];
  return { text: parts.join(", ") || say("wellFormed"), level };
}

export const isNormals = ({ type }: Verdict) => ["standard", "zzero", "xy"].includes(type ?? "");

export const typeOf = ({ type }: Verdict) => (isWord(type ?? "") ? say(type as Word) : (type ?? ""));

function greenOf({ y, y_confidence: sure }: Verdict): string {
  if (y === "undecided") return say("yUndecided");
  return `${say(y === "up" ? "yUp" : "yDown")}, ${Math.round(100 * sure)} % ${say("sure")}`;
}

function facts(verdict: Verdict): string[] {
  const form = `${verdict.width} × ${verdict.height}, ${verdict.bit_depth} bit ${CHANNELS[verdict.channels]}`;
  const lines = [`${typeOf(verdict)}, ${Math.round(100 * verdict.confidence)} % ${say("sure")}`, form];
  if (isNormals(verdict)) lines.push(greenOf(verdict));
  if (verdict.findings.some(({ id }) => id === "NT030")) lines.push(say("lossy"));
  const { used } = verdict;
  if (!used?.fail?.neighbor) return lines;
  lines.push(`${say("failing")}: ${numberOf(used.fail.neighbor)} ${say("of")} ${numberOf(used.texels)}`);
  if (verdict.angle_deg !== null) {
    const { mean, p99, max } = verdict.angle_deg;
    lines.push(`${say("angles")}: ${[mean, p99, max].map((angle) => numberOf(angle, 2)).join("; ")}`);
  }
  return lines;
}

const ORDER = ["error", "warning", "info"];

function findingLine(finding: Finding): HTMLLIElement {
  const line = element("li");
  const subject = subjectOf(finding.id);
  line.append(element("b", `${say(finding.level)} ${finding.id}`, { className: finding.level }), " ");
  if (subject) line.append(`${subject}: `);
  line.append(element("span", finding.message, { lang: "en" }));
  return line;
}

/** The whole verdict as elements. */
export function describe(verdict: Verdict): HTMLElement[] {
  if (verdict.status !== "ok") return [element("p", verdict.message ?? "", { className: "error", lang: "en" })];
  const { text, level } = shortVerdict(verdict);
  const list = element("ul");
  for (const line of facts(verdict)) list.append(element("li", line));
  const named = verdict.findings.filter((finding) => finding.level !== "info");
  const notes = verdict.findings.filter((finding) => finding.level === "info");
  named.sort((a, b) => ORDER.indexOf(a.level) - ORDER.indexOf(b.level));
  const parts = [element("p", text, { className: level, id: "verdict-short" }), listOf(named, "findings"), list];
  if (notes.length === 0) return parts;
  const more = element("details");
  more.append(element("summary", `${say("notes")} (${notes.length})`), listOf(notes, "notes"));
  return [...parts, more];
}

function listOf(findings: Finding[], id: string): HTMLUListElement {
  const list = element("ul", "", { id });
  list.append(...findings.map(findingLine));
  return list;
}
