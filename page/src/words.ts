// SPDX-License-Identifier: MIT
// Every word of the page, in both languages.  Sentences about a texture are those of `ntp`, which
// speaks English; their subjects are translated by the number of the finding.
const TABLE = {
  title: ["Normals textures: check, repair, convert", "Normalentexturen: prüfen, reparieren, umwandeln"],
  promise: [
    "Everything happens on this computer. Nothing is sent anywhere.",
    "Alles geschieht auf diesem Rechner. Nichts wird irgendwohin gesendet.",
  ],
  language: ["Language", "Sprache"],
  textures: ["Textures", "Texturen"],
  drop: [
    "Drop normal maps or height maps here, or paste them: PNG, TGA, JPEG, PFM, DDS or KTX2.",
    "Normal-Maps oder Höhenkarten hierher ziehen oder einfügen: PNG, TGA, JPEG, PFM, DDS oder KTX2.",
  ],
  choose: ["Choose files…", "Dateien wählen…"],
  chooseFolder: ["Choose a folder…", "Ordner wählen…"],
  clear: ["Remove all", "Alle entfernen"],
  look: ["Look", "Ansicht"],
  repair: ["Repair and convert", "Reparieren und umwandeln"],
  download: ["Download", "Herunterladen"],
  downloadAll: ["Do this to all, download a zip", "Auf alle anwenden, als Zip herunterladen"],
  downloadShown: ["Do this to those listed, download a zip", "Auf die gelisteten anwenden, als Zip herunterladen"],
  copy: ["Copy", "Kopieren"],
  copied: ["Copied", "Kopiert"],
  footer: [
    "The page runs ntp, the program of libntp. Its results are the same bytes.",
    "Die Seite führt ntp aus, das Programm von libntp. Die Ergebnisse sind dieselben Bytes.",
  ],
  find: ["Name contains", "Name enthält"],
  only: ["Show", "Zeigen"],
  all: ["all", "alle"],
  withErrors: ["with errors", "mit Fehlern"],
  withWarnings: ["with warnings", "mit Warnungen"],
  order: ["Order", "Reihenfolge"],
  asAdded: ["as added", "wie hinzugefügt"],
  byName: ["by name", "nach Namen"],
  worstFirst: ["worst first", "Schlimmste zuerst"],
  waiting: ["waiting", "wartet"],
  checking: ["is being checked", "wird geprüft"],
  checked: ["checked", "geprüft"],
  of: ["of", "von"],
  wellFormed: ["well formed", "in Ordnung"],
  error: ["error", "Fehler"],
  errors: ["errors", "Fehler"],
  warning: ["warning", "Warnung"],
  warnings: ["warnings", "Warnungen"],
  info: ["note", "Hinweis"],
  notes: ["Notes", "Hinweise"],
  sure: ["sure", "sicher"],
  unreadable: ["cannot be read", "nicht lesbar"],
  yUp: ["green points up (OpenGL)", "Grün zeigt nach oben (OpenGL)"],
  yDown: ["green points down (DirectX)", "Grün zeigt nach unten (DirectX)"],
  yUndecided: ["which way green points is undecided", "wohin Grün zeigt, ist unentschieden"],
  lossy: ["JPEG is lossy: keep another copy", "JPEG speichert mit Verlust: eine andere Kopie behalten"],
  failing: ["texels that are not unit vectors", "Texel, die keine Einheitsvektoren sind"],
  angles: ["degrees off: mean, 99th percentile, most", "Grad daneben: Mittel, 99. Perzentil, höchstens"],
  standard: ["standard normals", "Standard-Normalen"],
  zzero: ["Z-zero normals", "Z-Null-Normalen"],
  xy: ["XY-only normals", "XY-Normalen"],
  height: ["a height map", "eine Höhenkarte"],
  "object-space": ["object-space normals", "Objektraum-Normalen"],
  "one-color": ["one color", "eine Farbe"],
  "not-normals": ["not a normals texture", "keine Normalentextur"],
  texture: ["Texture", "Textur"],
  heatmap: ["Heatmap", "Heatmap"],
  lit: ["Lit plane", "Beleuchtete Ebene"],
  sphere: ["Lit sphere", "Beleuchtete Kugel"],
  tiles: ["2 × 2 tiles", "2 × 2 Kacheln"],
  split: ["Before (left) and after (right)", "Vorher (links) und nachher (rechts)"],
  moveLight: [
    "Drag to move the light; arrow keys move it too.",
    "Ziehen bewegt das Licht, die Pfeiltasten auch.",
  ],
  pointAtTexel: [
    "Point at a texel, or move with the arrow keys, to read its numbers.",
    "Auf ein Texel zeigen oder mit den Pfeiltasten gehen: seine Zahlen stehen hier.",
  ],
  heatmapLegend: [
    "Red: x and y too long. Green: wrong length. Blue: negative z.",
    "Rot: x und y zu lang. Grün: falsche Länge. Blau: z negativ.",
  ],
  length: ["length", "Länge"],
  before: ["before", "vorher"],
  after: ["after", "nachher"],
  working: ["working…", "in Arbeit…"],
  cleanIt: ["Clean", "Reinigen"],
  flipIt: ["Flip green", "Grün umkehren"],
  standardIt: ["Make standard", "Zu Standard machen"],
  undoIt: ["Undo the accident", "Fehler rückgängig machen"],
  clean: ["Clean", "Reinigen"],
  convert: ["Convert", "Umwandeln"],
  resize: ["Resize", "Größe"],
  transform: ["Transform", "Drehen und Stärke"],
  blend: ["Blend", "Mischen"],
  "from-height": ["Normals from heights", "Normalen aus Höhen"],
  "to-height": ["Heights from normals", "Höhen aus Normalen"],
  type: ["The texture stores", "Die Textur enthält"],
  method: ["Method", "Verfahren"],
  undo: ["Undo what can be undone first", "Zuerst rückgängig machen, was geht"],
  "only-failing": ["Only texels that fail", "Nur falsche Texel"],
  "touch-unused": ["Unused texels too", "Auch unbenutzte Texel"],
  to: ["Store as", "Speichern als"],
  y: ["Green points now", "Grün zeigt jetzt"],
  "to-y": ["Green shall point", "Grün soll zeigen"],
  depth: ["Bits", "Bits"],
  format: ["File", "Datei"],
  size: ["Size", "Größe"],
  mips: ["With all smaller levels (mips)", "Mit allen kleineren Stufen (Mips)"],
  filter: ["Filter", "Filter"],
  border: ["Beyond the edge", "Jenseits des Randes"],
  strength: ["Strength", "Stärke"],
  rotate: ["Turn by degrees", "Drehen um Grad"],
  flip: ["Mirror", "Spiegeln"],
  detail: ["Detail texture", "Detailtextur"],
  mode: ["Mode", "Art"],
  "detail-y": ["Green of the detail", "Grün des Details"],
  scale: ["Height of white, in texels", "Höhe von Weiß in Texeln"],
  kernel: ["Kernel", "Kernel"],
  source: ["Heights are in", "Höhen stehen in"],
  blur: ["Blur (sigma)", "Weichzeichnen (Sigma)"],
  octaves: ["Octaves (weights)", "Oktaven (Gewichte)"],
  invert: ["Black is high", "Schwarz ist hoch"],
  dither: ["Dither", "Dithering"],
  refine: ["Rounds of refining", "Verfeinerungsrunden"],
  force: ["Even if it looks like something else", "Auch wenn es nach anderem aussieht"],
  noDetail: ["Choose the detail texture first.", "Zuerst die Detailtextur wählen."],
  result: ["Result", "Ergebnis"],
  noSamples: ["There is nothing to show.", "Es gibt nichts anzuzeigen."],
  tooLarge: ["larger than 1 GiB: the page does not open it", "größer als 1 GiB: die Seite öffnet es nicht"],
  zipTooLarge: ["a zip holds no more than 4 GiB: do it in parts", "ein Zip fasst höchstens 4 GiB: bitte in Teilen"],
  noModule: [
    "This browser is too old: it has no WebAssembly with vectors. Use Chrome 91, Firefox 89, Safari 16.4 or later.",
    "Dieser Browser ist zu alt: ihm fehlt WebAssembly mit Vektoren. Nötig sind Chrome 91, Firefox 89, Safari 16.4 oder neuer.",
  ],
} as const;

export type Word = keyof typeof TABLE;
export const LANGUAGES = ["en", "de"] as const;
export type Language = (typeof LANGUAGES)[number];

let language: Language = navigator.language.startsWith("de") ? "de" : "en";

export function currentLanguage(): Language {
  return language;
}

export function setLanguage(to: Language) {
  language = to;
}

export function say(word: Word): string {
  return TABLE[word][LANGUAGES.indexOf(language)];
}

/** As the language writes numbers. */
export function numberOf(value: number, decimals = 0): string {
  const digits = { minimumFractionDigits: decimals, maximumFractionDigits: decimals };
  return value.toLocaleString(language, digits);
}

export function isWord(word: string): word is Word {
  return Object.hasOwn(TABLE, word);
}

/** What findings are about, in German; docs/findings.md has them in English. */
const GERMAN_FINDINGS: Record<string, string> = {
  NT001: "Normalen, die nicht die Länge 1 haben",
  NT002: "x und y allein sind länger als 1",
  NT003: "z ist negativ: Blau liegt höchstens bei der Hälfte",
  NT004: "Blau ist konstant, obwohl Rot und Grün sich ändern",
  NT005: "eine Z-Null-Textur",
  NT006: "eine XY-Textur",
  NT007: "sieht wie eine Höhenkarte aus",
  NT008: "keine Normalentextur",
  NT009: "Objektraum-Normalen",
  NT010: "Grün zeigt in die falsche Richtung",
  NT011: "der Name widerspricht der verlangten Richtung von Grün",
  NT012: "Kanäle sind vertauscht",
  NT013: "x und y sind vertauscht",
  NT014: "ein Kanal enthält nichts",
  NT020: "nicht bitgenau",
  NT021: "die flache Farbe ist nicht 128, 128, 255",
  NT022: "im Mittel geneigt",
  NT023: "keine Oberfläche hat diese Normalen",
  NT030: "verlustbehaftet gespeichert (JPEG)",
  NT031: "JPEG mit verkleinerten Farben",
  NT032: "Spuren verlustbehafteter Kompression in einer verlustfreien Datei",
  NT033: "aus Höhen mit wenigen Stufen gemacht (Bänder)",
  NT034: "16 Bit mit 8-Bit-Inhalt",
  NT035: "verkleinert oder weichgezeichnet, ohne zu normieren",
  NT036: "Blockkompression",
  NT040: "als Farben behandelt",
  NT041: "ein Alphakanal, der überall deckt",
  NT042: "unbenutzte Texel",
  NT044: "Füllung in einer Farbe, die keine Normale hat",
  NT045: "als sRGB gekennzeichnet",
  NT050: "eine Farbe, oder nichts",
  NT051: "die Seiten sind keine Zweierpotenzen",
  NT052: "gegenüberliegende Ränder passen nicht zusammen",
  NT053: "keine Mips",
  NT054: "Mips, die nicht normiert sind",
};

/** The subject of a finding where it needs translation, else "". */
export function subjectOf(finding: string): string {
  return language === "de" ? (GERMAN_FINDINGS[finding] ?? "") : "";
}
