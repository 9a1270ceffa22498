// SPDX-License-Identifier: MIT
// Normals textures in JavaScript: libntp as a WebAssembly module, in browsers and in node.
// index.d.ts says what each function takes and gives.
import { accidentOf, undone } from "./undo.js";
import {
  ACCIDENTS,
  ALPHAS,
  BLENDS,
  BLUES,
  BORDERS,
  CLASSES,
  DECODES,
  ENCODINGS,
  FILTERS,
  HEIGHT_METHODS,
  KERNELS,
  METHODS,
  PALETTES,
  SOURCES,
  VERDICTS,
  YS,
  ZS,
} from "./words.js";

const SAMPLES = [Uint8Array, Uint16Array, Float32Array];
const DEPTHS = { 8: 0, 16: 1, 32: 2 };
const Y_WORDS = { up: 0, opengl: 0, down: 1, directx: 1 };

const HEIGHT = ENCODINGS.indexOf("height");
const VECTOR = ENCODINGS.indexOf("vector");
const AUTO = -1;
const MAX_SIDE = 65535;
const ALL_UNUSED = 7;
const NORMAL = 3; // channels that hold one
const SURE = 0.9; // an accident is undone, and green believed, from here on
const TEXT = 4096; // bytes of all reasons

/** An argument outside what index.d.ts lists, or a texture that the operation refuses. */
export class NtpError extends Error {
  constructor(message, status = 1) {
    super(message);
    this.name = "NtpError";
    this.status = status;
  }
}

const pick = (name, value, words) => {
  const at = words.indexOf(value);
  if (at < 0) throw new NtpError(`${name}: ${JSON.stringify(value)} is none of ${words.join(", ")}`);
  return at;
};

const pickAuto = (name, value, words) => (value === "auto" ? AUTO : pick(name, value, words));

const pickY = (name, value) => {
  if (!Object.hasOwn(Y_WORDS, value))
    throw new NtpError(`${name}: ${JSON.stringify(value)} is none of ${Object.keys(Y_WORDS).join(", ")}`);
  return Y_WORDS[value];
};

const number = (name, value) => {
  if (typeof value !== "number" || !Number.isFinite(value))
    throw new NtpError(`${name}: must be a finite number, not ${String(value)}`);
  return value;
};

/** Options by name; an unknown one is an error, so that a misspelled one is not lost. */
const options = (given, defaults) => {
  for (const name of Object.keys(given))
    if (!Object.hasOwn(defaults, name))
      throw new NtpError(`${name}: unknown option; there are ${Object.keys(defaults).join(", ")}`);
  return { ...defaults, ...given };
};

const side = (name, value) => {
  if (!Number.isInteger(value) || value < 1 || value > MAX_SIDE)
    throw new NtpError(`${name}: must be a whole number of 1 to ${MAX_SIDE}, not ${String(value)}`);
  return value;
};

/** The picture as the module reads it: ImageData and Node's buffers too. */
const pictureOf = (name, picture) => {
  if (picture === null || typeof picture !== "object" || !ArrayBuffer.isView(picture.data))
    throw new NtpError(`${name}: must be {data, width, height, channels}`);
  const width = side(`${name}.width`, picture.width);
  const height = side(`${name}.height`, picture.height);
  let data = picture.data;
  if (data instanceof Uint8ClampedArray) data = new Uint8Array(data.buffer, data.byteOffset, data.length);
  const type = SAMPLES.findIndex((kind) => data instanceof kind);
  if (type < 0)
    throw new NtpError(`${name}.data: must be a Uint8Array, Uint16Array or Float32Array`);
  const channels = picture.channels ?? data.length / (width * height);
  if (!Number.isInteger(channels) || channels < 1 || channels > 4 || data.length !== width * height * channels)
    throw new NtpError(
      `${name}: ${data.length} samples are not ${width} x ${height} texels of 1 to 4 channels`,
    );
  return { data, width, height, channels, type };
};

/** libntp in a WebAssembly instance.  `load` makes one. */
export class Ntp {
  #module;
  #names;

  constructor(instance) {
    this.#module = instance.exports;
    this.#names = this.#text(this.#module.factNames()).trim().split(" ");
  }

  /** The version of libntp, as in "0.1.0". */
  get version() {
    const version = this.#module.version();
    return `${version >>> 16}.${(version >>> 8) & 255}.${version & 255}`;
  }

  /** What a texture is, how far it is right, and which way green points. */
  check(picture, given = {}) {
    const how = options(given, { type: "auto", touchUnused: false, lossy: false });
    const source = pictureOf("picture", picture);
    const encoding = pickAuto("type", how.type, ENCODINGS.slice(0, HEIGHT));
    return this.#call((memory) => {
      const facts = memory.doubles(this.#names.length);
      const text = memory.take(TEXT);
      const from = memory.picture(source, encoding, 0);
      this.#do("check", facts.at, text, TEXT, from, touched(how), Number(how.lossy));
      return this.#checked(facts.read(), this.#text(text).trimEnd().split("\n"));
    });
  }

  #checked(numbers, reasons) {
    const fact = Object.fromEntries(this.#names.map((name, i) => [name, numbers[i]]));
    const methodReason = reasons.pop();
    return {
      type: CLASSES[fact.type],
      confidence: fact.confidence,
      accidents: ACCIDENTS.filter((_, i) => (fact.accidents >> i) & 1),
      reasons: reasons.slice(0, fact.reasonCount),
      readAs: ENCODINGS[fact.encoding],
      method: METHODS[fact.method],
      methodReason,
      texels: fact.texels,
      unused: fact.unused,
      black: fact.black,
      white: fact.white,
      transparent: fact.transparent,
      padding: fact.padding,
      notFinite: fact.notFinite,
      max: fact.max,
      xyTooLong: fact.xyTooLong,
      zNegative: fact.zNegative,
      fail: {
        neighbor: fact.failNeighbor,
        rounded: fact.failRounded,
        exact: fact.failExact,
      },
      length: { min: fact.lengthMin, mean: fact.lengthMean, max: fact.lengthMax },
      angle: { mean: fact.angleMean, p99: fact.angleP99, max: fact.angleMax },
      harm: { texels: fact.harmTexels, mean: fact.harmMean, p99: fact.harmP99, max: fact.harmMax },
      green: {
        y: fact.greenDecided ? YS[fact.greenY] : "undecided",
        confidence: fact.greenConfidence,
      },
    };
  }

  /** The verdict of each texel: a byte of flags; see `FLAGS`. */
  validate(picture, given = {}) {
    const how = options(given, { type: "auto", keepNegativeZ: false });
    const source = pictureOf("picture", picture);
    const encoding = this.#encoding(picture, how.type);
    return this.#call((memory) => {
      const flags = memory.take(source.width * source.height);
      const from = memory.picture(source, encoding, 0);
      this.#do("validate", flags, from, Number(how.keepNegativeZ));
      return memory.bytes(flags, source.width * source.height);
    });
  }

  /** Repairs normals: each texel becomes a unit vector.  Cleaning again changes nothing. */
  clean(picture, given = {}) {
    const how = options(given, {
      type: "auto",
      method: "auto",
      verdict: "neighbor",
      onlyFailing: false,
      keepNegativeZ: false,
      touchUnused: false,
      undo: false,
    });
    let source = pictureOf("picture", picture);
    const verdict = pick("verdict", how.verdict, VERDICTS);
    let type = how.type;
    let method = pickAuto("method", how.method, METHODS.slice(0, 2));
    let found = type === "auto" || how.undo ? this.check(source) : null;
    const accident = found === null ? null : this.#accident(found, source, type, how.undo);
    if (accident !== null) {
      source = undone(source, accident);
      type = "standard";
      if (accident === "dxt5nm") method = METHODS.indexOf("derive"); // there is no blue
    }
    if (type === "auto" || method === AUTO) {
      if (found === null || type !== "auto") found = this.check(source, { type });
      if (type === "auto") type = this.#typeOf(found);
      if (method === AUTO) method = METHODS.indexOf(found.method);
      // Unused texels were not asked.  Normalizing repairs them, and leaves what is rounded.
      if (how.touchUnused && METHODS[method] === "keep") method = METHODS.indexOf("normalize");
    }
    const encoding = pick("type", type, ENCODINGS.slice(0, HEIGHT));
    return this.#call((memory) => {
      const from = memory.picture(source, encoding, 0);
      const to = memory.picture(memory.like(source), encoding, 0);
      const counts = memory.doubles(2);
      const flags = [Number(how.onlyFailing), Number(how.keepNegativeZ), touched(how)];
      this.#do("clean", counts.at, to.at, from, method, verdict, ...flags);
      const [changed, notFinite] = counts.read();
      return { ...to.read(), changed, notFinite, type, method: METHODS[method], undone: accident };
    });
  }

  /** Another encoding, depth or direction of green; every value is correctly rounded. */
  convert(picture, given = {}) {
    const how = options(given, {
      type: "auto",
      to: null,
      depth: null,
      channels: null,
      y: "up",
      toY: null,
      blue: "derived",
      touchUnused: false,
    });
    const source = pictureOf("picture", picture);
    const from = this.#encoding(picture, how.type, ENCODINGS);
    const to = how.to === null ? from : pick("to", how.to, ENCODINGS);
    const y = pickY("y", how.y);
    const type = how.depth === null ? (to === VECTOR ? 2 : source.type) : depth(how.depth);
    const channels = how.channels ?? (to === from ? source.channels : source.channels === 4 ? 4 : NORMAL);
    return this.#call((memory) => {
      const src = memory.picture(source, from, y);
      const dst = memory.picture(
        memory.sized(source.width, source.height, channels, type),
        to,
        how.toY === null ? y : pickY("toY", how.toY),
      );
      const counts = memory.doubles(3);
      this.#do("convert", counts.at, dst.at, src, pick("blue", how.blue, BLUES), touched(how));
      const [zNegative, notFinite, pulled] = counts.read();
      return { ...dst.read(), zNegative, notFinite, pulled };
    });
  }

  /** A picture of the texels that are wrong; docs/heatmap.md is the legend. */
  heatmap(picture, given = {}) {
    const how = options(given, { type: "auto", palette: "reference", touchUnused: false });
    const source = pictureOf("picture", picture);
    const encoding = this.#encoding(picture, how.type);
    const palette = pick("palette", how.palette, PALETTES);
    return this.#call((memory) => {
      const from = memory.picture(source, encoding, 0);
      const to = memory.picture(memory.sized(source.width, source.height, NORMAL, 0), HEIGHT, 0);
      this.#do("heatmap", to.at, from, palette, touched(how));
      return to.read();
    });
  }

  /** A plane with these normals, lit; x right, y up, z to the viewer. */
  shade(picture, given = {}) {
    const how = options(given, {
      type: "auto",
      y: "up",
      light: [-1, 1, 1.2],
      ambient: 0.1,
      diffuse: 0.9,
      specular: 0.2,
      color: 0.6,
      channels: NORMAL,
    });
    const source = pictureOf("picture", picture);
    const encoding = this.#encoding(picture, how.type);
    const light = [...how.light, how.ambient, how.diffuse, how.specular, how.color];
    return this.#call((memory) => {
      const from = memory.picture(source, encoding, pickY("y", how.y));
      const to = memory.picture(memory.sized(source.width, source.height, how.channels, 0), HEIGHT, 0);
      this.#do("shade", to.at, from, ...light.map((value) => number("light", value)));
      return to.read();
    });
  }

  /** Normals of a heightfield, correctly rounded. */
  normalsFromHeight(picture, given = {}) {
    const how = options(given, {
      scale: "auto",
      dx: 1,
      dy: 1,
      kernel: "central",
      border: "wrap",
      borderX: null,
      borderY: null,
      source: "red",
      minZ: 0,
      invert: false,
      encoding: "standard",
      y: "up",
      depth: null,
      blue: "derived",
      alpha: "keep",
      dither: false,
    });
    const source = pictureOf("picture", picture);
    const encoding = pick("encoding", how.encoding, ENCODINGS.slice(0, HEIGHT));
    const type = how.depth === null ? (encoding === VECTOR ? 2 : Math.min(source.type, 1)) : depth(how.depth);
    return this.#call((memory) => {
      const from = memory.picture(source, HEIGHT, 0);
      const settings = memory.normalsHow({
        ...how,
        scale: how.scale === "auto" ? 1 : number("scale", how.scale),
      });
      let scale = how.scale;
      if (scale === "auto") {
        const found = memory.doubles(1);
        this.#do("reliefScale", found.at, from, settings.at);
        [scale] = found.read();
        settings.setScale(scale);
      }
      const hasAlpha = source.channels % 2 === 0;
      const channels = how.alpha === "keep" && !hasAlpha ? NORMAL : NORMAL + 1;
      const form = memory.sized(source.width, source.height, channels, type);
      const to = memory.picture(form, encoding, pickY("y", how.y));
      const counts = memory.doubles(2);
      this.#do("normalsFromHeight", counts.at, to.at, from, settings.at, Number(how.dither));
      const [notFinite] = counts.read();
      return { ...to.read(), scale, notFinite };
    });
  }

  /** The heightfield of normals, in texels, with mean 0. */
  heightFromNormals(picture, given = {}) {
    const how = options(given, {
      type: "auto",
      y: "auto",
      method: "auto",
      kernel: "auto",
      border: "auto",
      borderX: null,
      borderY: null,
      dx: 1,
      dy: 1,
      decode: "auto",
      z: "auto",
      refine: 0,
      detrend: false,
      touchUnused: false,
    });
    const source = pictureOf("picture", picture);
    const found = how.type === "auto" || how.y === "auto" ? this.check(picture, { type: how.type }) : null;
    if (how.type === "auto") this.#sound(found, source.channels);
    const type = how.type === "auto" ? this.#typeOf(found) : how.type;
    const encoding = pick("type", type, ENCODINGS.slice(0, HEIGHT));
    const y = how.y === "auto" ? this.#green(found, source, type) : pickY("y", how.y);
    const count = source.width * source.height;
    return this.#call((memory) => {
      const from = memory.picture(source, encoding, y);
      const to = memory.take(count * Float32Array.BYTES_PER_ELEMENT);
      const facts = memory.doubles(11);
      this.#do("heightFromNormals", facts.at, to, from, memory.heightsHow(how, touched(how)));
      const [min, max, method, kernel, borderX, borderY, decode, z, residual, rounds, left] = facts.read();
      return {
        data: memory.floats(to, count),
        width: source.width,
        height: source.height,
        channels: 1,
        min,
        max,
        y: YS[y],
        method: HEIGHT_METHODS[method],
        kernel: KERNELS[kernel],
        borderX: BORDERS[borderX],
        borderY: BORDERS[borderY],
        decode: DECODES[decode],
        z: ZS[z],
        residual,
        rounds,
        left,
      };
    });
  }

  /** Another size; the vectors are filtered, and are unit vectors again. */
  resize(picture, width, height, given = {}) {
    const how = options(given, {
      type: "auto",
      filter: "triangle",
      border: "clamp",
      borderX: null,
      borderY: null,
      touchUnused: false,
    });
    const source = pictureOf("picture", picture);
    const encoding = this.#encoding(picture, how.type);
    const form = [side("width", width), side("height", height), source.channels, source.type];
    return this.#call((memory) => {
      const from = memory.picture(source, encoding, 0);
      const to = memory.picture(memory.sized(...form), encoding, 0);
      this.#do("resize", to.at, from, pick("filter", how.filter, FILTERS), ...borders(how), touched(how));
      return to.read();
    });
  }

  /** Flips and turns the picture with its vectors, and scales the slopes. */
  transform(picture, given = {}) {
    const how = options(given, {
      type: "auto",
      y: "up",
      flipX: false,
      flipY: false,
      rotate: 0,
      strength: 1,
      border: "clamp",
      borderX: null,
      borderY: null,
      touchUnused: false,
    });
    const source = pictureOf("picture", picture);
    const encoding = this.#encoding(picture, how.type);
    const y = pickY("y", how.y);
    const angle = number("rotate", how.rotate);
    const turned = Math.abs(angle) % 180 === 90;
    const size = turned ? [source.height, source.width] : [source.width, source.height];
    return this.#call((memory) => {
      const from = memory.picture(source, encoding, y);
      const to = memory.picture(memory.sized(...size, source.channels, source.type), encoding, y);
      const flips = [Number(how.flipX), Number(how.flipY)];
      const strength = number("strength", how.strength);
      this.#do("transform", to.at, from, ...flips, angle, strength, ...borders(how), touched(how));
      return to.read();
    });
  }

  /** A detail texture over a base; it is repeated where it is smaller. */
  blend(base, detail, given = {}) {
    const how = options(given, {
      type: "auto",
      detailType: "auto",
      y: "up",
      detailY: "up",
      mode: "rnm",
      strength: 1,
      detailAlpha: false,
      touchUnused: false,
    });
    const first = pictureOf("base", base);
    const second = pictureOf("detail", detail);
    const encoding = this.#encoding(base, how.type);
    const other = this.#encoding(detail, how.detailType);
    const y = pickY("y", how.y);
    return this.#call((memory) => {
      const under = memory.picture(first, encoding, y);
      const over = memory.picture(second, other, pickY("detailY", how.detailY));
      const to = memory.picture(memory.like(first), encoding, y);
      const mode = pick("mode", how.mode, BLENDS);
      const strength = number("strength", how.strength);
      this.#do("blend", to.at, under, over, mode, strength, Number(how.detailAlpha), touched(how));
      return to.read();
    });
  }

  /* -------------------------------------------------------------------- what is asked */

  #encoding(picture, type, words = ENCODINGS.slice(0, HEIGHT)) {
    if (type !== "auto") return pick("type", type, words);
    return ENCODINGS.indexOf(this.#typeOf(this.check(picture)));
  }

  #typeOf(found) {
    if (found.type === "one-color") return "standard";
    if (["standard", "zzero", "xy"].includes(found.type)) return found.type;
    throw new NtpError(
      `the picture looks like ${found.type}, not like a normals texture (${found.reasons.join("; ")}); ` +
        'name its type to go on, such as type: "standard"',
    );
  }

  /** The accident to undo first, or null.  `found` is what `check` says of it, of type auto. */
  #accident(found, source, type, undo) {
    const accident = accidentOf(found, source.channels);
    if (accident === null || (type !== "auto" && !undo)) return null;
    const possible = accident !== "srgb" || source.type !== 2;
    if (possible && (undo || found.confidence >= SURE)) return accident;
    if (accident === "inverted-blue") return null; // cleaning mirrors negative z anyhow
    throw this.#refusal(found, accident, possible ? "undo: true puts that right, " : "");
  }

  /** What makes another picture of a texture with an accident would only hide it. */
  #sound(found, channels) {
    const accident = accidentOf(found, channels);
    if (accident !== null) throw this.#refusal(found, accident, "clean with undo: true first, ");
  }

  #refusal(found, accident, way) {
    const sure = Math.round(100 * found.confidence);
    return new NtpError(
      `the picture looks as if it had this accident: ${accident} (${sure} % sure); ` +
        `${way}type: "standard" takes it as it is`,
    );
  }

  #green(found, source, type) {
    if (found.green.confidence >= SURE) return YS.indexOf(found.green.y);
    if (!slopesDown(source, type)) return YS.indexOf("up");
    throw new NtpError(
      'y: the texels do not show which way green points; y: "up" (OpenGL) or y: "down" (DirectX)?',
    );
  }

  /* -------------------------------------------------------------------- the module's memory */

  #text(at) {
    const bytes = new Uint8Array(this.#module.memory.buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  #do(name, ...values) {
    const status = this.#module[name](...values);
    if (status !== 0) throw new NtpError(`${name}: ${this.#text(this.#module.statusText(status))}`, status);
  }

  #call(work) {
    const memory = new Scratch(this.#module);
    try {
      return work(memory);
    } finally {
      memory.releaseAll();
    }
  }
}

/** Whether green of any used texel is more than the level nearest to 0. */
const slopesDown = ({ data, channels, type }, stored) => {
  const most = [255, 65535, 1][type];
  const neutral = type === 0 ? 1 : type === 1 && data.every((v) => v % 257 === 0) ? 257 : 1;
  const least = type === 2 ? 1 / 65535 : neutral;
  for (let i = 0; i < data.length; i += channels) {
    const colors = data.subarray(i, i + Math.min(channels, NORMAL));
    const one = colors.every((v) => v === colors[0]) && (colors[0] === 0 || colors[0] === most);
    const hidden = channels === 4 && data[i + 3] === 0;
    const lean = stored === "vector" ? data[i + 1] : 2 * data[i + 1] - most;
    if (Math.abs(lean) > least && (stored === "vector" || !(one || hidden))) return true;
  }
  return false;
};

const touched = (how) => (how.touchUnused ? ALL_UNUSED : 0);

const depth = (bits) => {
  if (!Object.hasOwn(DEPTHS, bits)) throw new NtpError(`depth: must be 8, 16 or 32, not ${String(bits)}`);
  return DEPTHS[bits];
};

const borders = (how) =>
  [how.borderX ?? how.border, how.borderY ?? how.border].map((word) => pick("border", word, BORDERS));

/** Memory of the module that one call uses.  Views are made late: memory moves when it grows. */
class Scratch {
  #module;
  #taken = [];

  constructor(module) {
    this.#module = module;
  }

  take(size) {
    const at = this.#module.allocate(size) >>> 0;
    if (at === 0) throw new NtpError(`no memory left for ${size} bytes`, 5);
    this.#taken.push(at);
    return at;
  }

  releaseAll() {
    for (const at of this.#taken) this.#module.release(at);
  }

  bytes(at, size) {
    return new Uint8Array(this.#module.memory.buffer, at, size).slice();
  }

  floats(at, count) {
    return new Float32Array(this.#module.memory.buffer, at, count).slice();
  }

  doubles(count) {
    const at = this.take(count * Float64Array.BYTES_PER_ELEMENT);
    return { at, read: () => [...new Float64Array(this.#module.memory.buffer, at, count)] };
  }

  sized(width, height, channels, type) {
    return { width, height, channels, type, data: null };
  }

  like({ width, height, channels, type }) {
    return this.sized(width, height, channels, type);
  }

  /** A picture in the module: the address of its description; of one to be written, also `read`. */
  picture({ data, width, height, channels, type }, encoding, y) {
    const Kind = SAMPLES[type];
    const count = width * height * channels;
    const samples = this.take(count * Kind.BYTES_PER_ELEMENT);
    if (data !== null) new Kind(this.#module.memory.buffer, samples, count).set(data);
    const at = this.#integers([samples, width, height, channels, type, encoding, y]);
    if (data !== null) return at;
    const read = () => new Kind(this.#module.memory.buffer, samples, count).slice();
    return { at, read: () => ({ data: read(), width, height, channels }) };
  }

  #integers(values, doubles = []) {
    const at = this.take(8 * doubles.length + 4 * values.length);
    new Float64Array(this.#module.memory.buffer, at, doubles.length).set(doubles);
    new Int32Array(this.#module.memory.buffer, at + 8 * doubles.length, values.length).set(values);
    return at;
  }

  normalsHow(how) {
    const [x, y] = borders(how);
    const at = this.#integers(
      [
        pick("kernel", how.kernel, KERNELS.slice(0, -1)),
        x,
        y,
        pick("source", how.source, SOURCES),
        pick("blue", how.blue, BLUES),
        pick("alpha", how.alpha, ALPHAS),
        Number(how.invert),
      ],
      [how.scale, number("dx", how.dx), number("dy", how.dy), number("minZ", how.minZ)],
    );
    return {
      at,
      setScale: (scale) => new Float64Array(this.#module.memory.buffer, at, 1).set([scale]),
    };
  }

  heightsHow(how, touch) {
    return this.#integers(
      [
        pick("method", how.method, HEIGHT_METHODS),
        pickAuto("kernel", how.kernel, KERNELS),
        pickAuto("borderX", how.borderX ?? how.border, BORDERS),
        pickAuto("borderY", how.borderY ?? how.border, BORDERS),
        pick("decode", how.decode, DECODES),
        pick("z", how.z, ZS),
        number("refine", how.refine),
        Number(how.detrend),
        touch,
      ],
      [number("dx", how.dx), number("dy", how.dy)],
    );
  }
}

/** The bits of each byte that `validate` gives. */
export const FLAGS = Object.freeze({
  neighbor: 1,
  rounded: 2,
  exact: 4,
  xyTooLong: 8,
  zNegative: 16,
  unused: 32,
  notFinite: 64,
});

const bytesOf = async (source) => {
  if (source.protocol === "file:") {
    const { readFile } = await import("node:fs/promises");
    return readFile(source);
  }
  const response = await fetch(source);
  if (!response.ok) throw new NtpError(`${source}: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
};

/**
 * Makes an instance of the module: from libntp.wasm beside this file, or from an address, bytes or a
 * WebAssembly.Module that the caller has.
 */
export async function load(source = new URL("./libntp.wasm", import.meta.url)) {
  const address = typeof source === "string" ? new URL(source, import.meta.url) : source;
  const code = address instanceof URL ? await bytesOf(address) : address;
  const module = code instanceof WebAssembly.Module ? code : await WebAssembly.compile(code);
  return new Ntp(await WebAssembly.instantiate(module, {}));
}
