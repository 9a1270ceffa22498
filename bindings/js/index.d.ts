// SPDX-License-Identifier: MIT
/** Normals textures (normal maps): libntp as a WebAssembly module.  Every function is synchronous. */

/** 0..255, 0..65535, or floats of 0..1 (of `"vector"`: -1..1). */
export type Samples = Uint8Array | Uint16Array | Float32Array;

/** Samples by rows, from the top, without gaps; those of a texel side by side. */
export interface Picture<S extends Samples = Samples> {
  data: S;
  /** 1 to 65535, as is `height`. */
  width: number;
  height: number;
  /** 1 to 4: gray; gray and alpha, or x and y; RGB; RGBA. */
  channels: number;
}

/** What a function takes: without `channels` they follow from the size; ImageData is one too. */
export interface PictureLike {
  data: Samples | Uint8ClampedArray;
  width: number;
  height: number;
  channels?: number;
}

/** How a normal is stored: x, y, z as (v + 1)/2; z as 0..1; x and y only; as it is. */
export type Type = "standard" | "zzero" | "xy" | "vector";
/** `"auto"`: as the texels tell; what is no normals texture is refused. */
export type AutoType = "auto" | Type;
/** Which way green points: up the picture (OpenGL, glTF) or down (DirectX). */
export type Y = "up" | "down" | "opengl" | "directx";
export type Kernel =
  | "central"
  | "forward"
  | "prewitt3"
  | "sobel3"
  | "scharr3"
  | "prewitt5"
  | "sobel5"
  | "gimp5"
  | "gimp7"
  | "gimp9";
export type Border = "wrap" | "clamp" | "mirror" | "extrapolate" | "repeat-slope";
export type ResizeBorder = "wrap" | "clamp" | "mirror";
export type Verdict = "neighbor" | "rounded" | "exact";
export type Source =
  | "red"
  | "green"
  | "blue"
  | "alpha"
  | "luma"
  | "luma-gimp"
  | "luma-eberly"
  | "mean"
  | "max"
  | "min"
  | "screen";
export type Accident =
  | "gamma"
  | "red-is-z"
  | "green-is-z"
  | "dxt5nm"
  | "lossy"
  | "filtered"
  | "z-flipped"
  | "blue-constant";
export type Undone = "red-blue" | "green-blue" | "dxt5nm" | "inverted-blue" | "srgb";

/** Borders of both axes, or of each. */
export interface Borders<B> {
  border?: B;
  borderX?: B | null;
  borderY?: B | null;
}

export interface Checked {
  type: "standard" | "zzero" | "xy" | "height" | "object-space" | "one-color" | "not-normals";
  /** 0..1; 0.5: two types are equally likely. */
  confidence: number;
  accidents: Accident[];
  /** English clauses, the most important first. */
  reasons: string[];
  /** How the texels were read for the numbers that follow. */
  readAs: "standard" | "zzero" | "xy";
  /** The cleaning method that suits its errors, and why. */
  method: "derive" | "normalize" | "keep";
  methodReason: string;
  texels: number;
  /** Black, white and transparent texels. */
  unused: number;
  black: number;
  white: number;
  transparent: number;
  /** Used texels that are padding of one other color. */
  padding: number;
  notFinite: number;
  /** The greatest level: 255 or 65535. */
  max: number;
  xyTooLong: number;
  zNegative: number;
  /** Used texels that do not pass each verdict. */
  fail: Record<Verdict, number>;
  length: { min: number; mean: number; max: number };
  /** Degrees between the stored and the cleaned normals. */
  angle: { mean: number; p99: number; max: number };
  /** The same of the texels that are wrong by more than rounding; the others count as 0. */
  harm: { texels: number; mean: number; p99: number; max: number };
  green: { y: "up" | "down" | "undecided"; confidence: number };
}

export interface Cleaned<S extends Samples = Samples> extends Picture<S> {
  /** Texels in which a sample changed; after an undone accident, by the cleaning. */
  changed: number;
  notFinite: number;
  type: Type;
  method: "derive" | "normalize" | "keep";
  undone: Undone | null;
}

export interface Heights extends Picture<Float32Array> {
  /** Of the heights, in texels; their difference is the scale that makes the normals again. */
  min: number;
  max: number;
  y: "up" | "down";
  method: "telescoping" | "frankot-chellappa" | "poisson-dct";
  kernel: Kernel | "baked";
  borderX: Border;
  borderY: Border;
  decode: "unorm" | "neutral" | "unorm-trunc" | "snorm128";
  z: "stored" | "derived";
  /** Rms difference between the normals of the heights and the texture, in levels. */
  residual: number;
  /** Rounds that `refine` took, and texels that differ after them. */
  rounds: number;
  left: number;
}

/** An argument outside what is listed here, or a texture that the operation refuses. */
export class NtpError extends Error {
  /** The ntp_status of libntp.h. */
  readonly status: number;
}

/** The bits of each byte that `validate` gives. */
export const FLAGS: Readonly<{
  neighbor: 1;
  rounded: 2;
  exact: 4;
  xyTooLong: 8;
  zNegative: 16;
  unused: 32;
  notFinite: 64;
}>;

/** What every function throws for a wrong argument: NtpError.  `touchUnused` treats black, white and
 * transparent texels like any other; they are left alone otherwise. */
export class Ntp {
  private constructor();
  /** The version of libntp. */
  readonly version: string;

  /** What a texture is, how far it is right, and which way green points. */
  check(
    picture: PictureLike,
    options?: { type?: AutoType; touchUnused?: boolean; lossy?: boolean },
  ): Checked;

  /** The verdict of each texel: a byte of `FLAGS`. */
  validate(
    picture: PictureLike,
    options?: { type?: AutoType; keepNegativeZ?: boolean },
  ): Uint8Array;

  /**
   * Repairs normals: each texel becomes a unit vector.  Cleaning again changes nothing.  Exchanged
   * channels, DXT5nm, inverted blue and sRGB are undone first where the texels are sure, or with
   * `undo`; else such a texture is refused.
   */
  clean<S extends Samples>(picture: Picture<S> | PictureLike, options?: {
    type?: AutoType;
    method?: "auto" | "derive" | "normalize";
    verdict?: Verdict;
    onlyFailing?: boolean;
    keepNegativeZ?: boolean;
    touchUnused?: boolean;
    undo?: boolean;
  }): Cleaned<S>;

  /** Another encoding, depth or direction of green; every value is correctly rounded. */
  convert(picture: PictureLike, options?: {
    type?: AutoType | "height";
    /** `null`: as `type`. */
    to?: Type | "height" | null;
    /** 8, 16, or 32 for floats; `null`: as the picture, floats for vectors. */
    depth?: 8 | 16 | 32 | null;
    channels?: number | null;
    y?: Y;
    /** `null`: as `y`. */
    toY?: Y | null;
    blue?: "derived" | "nearest";
    touchUnused?: boolean;
  }): Picture & { zNegative: number; notFinite: number; pulled: number };

  /** Which texels are wrong, as RGB; docs/heatmap.md is the legend. */
  heatmap(picture: PictureLike, options?: {
    type?: AutoType;
    palette?: "reference" | "safe";
    touchUnused?: boolean;
  }): Picture<Uint8Array>;

  /** A plane with these normals, lit.  `light`: x right, y up, z to the viewer. */
  shade(picture: PictureLike, options?: {
    type?: AutoType;
    y?: Y;
    light?: [number, number, number];
    ambient?: number;
    diffuse?: number;
    specular?: number;
    color?: number;
    channels?: 1 | 3 | 4;
  }): Picture<Uint8Array>;

  /**
   * Normals of a heightfield, each level correctly rounded.  `scale`: how many texels a height of 1
   * (white) rises; `"auto"`: the one that shows the relief.
   */
  normalsFromHeight(picture: PictureLike, options?: Borders<Border> & {
    scale?: number | "auto";
    dx?: number;
    dy?: number;
    kernel?: Kernel;
    source?: Source;
    minZ?: number;
    invert?: boolean;
    encoding?: Type;
    y?: Y;
    /** `null`: as the picture; 16 of floats; floats for vectors. */
    depth?: 8 | 16 | 32 | null;
    blue?: "derived" | "nearest";
    alpha?: "keep" | "one" | "inverse" | "height" | "inverse-height";
    /** Passes the rounding errors of slopes on, so that heights drift less. */
    dither?: boolean;
  }): Picture & { scale: number; notFinite: number };

  /**
   * The heightfield whose slopes are closest to those of the normals, in texels, with mean 0.
   * `y: "auto"` throws where the texels do not show which way green points and it matters.
   */
  heightFromNormals(picture: PictureLike, options?: Borders<"auto" | Border> & {
    type?: AutoType;
    y?: "auto" | Y;
    method?: "auto" | "telescoping" | "frankot-chellappa" | "poisson-dct";
    kernel?: "auto" | Kernel | "baked";
    dx?: number;
    dy?: number;
    decode?: "auto" | "unorm" | "neutral" | "unorm-trunc" | "snorm128";
    z?: "auto" | "stored" | "derived";
    /** So many more rounds, until the normals of the heights are those of the picture. */
    refine?: number;
    detrend?: boolean;
    touchUnused?: boolean;
  }): Heights;

  /** Another size; the vectors are filtered, and are unit vectors again. */
  resize(picture: PictureLike, width: number, height: number, options?: Borders<ResizeBorder> & {
    type?: AutoType;
    filter?: "triangle" | "box" | "lanczos3";
    touchUnused?: boolean;
  }): Picture;

  /** Flips, then turns clockwise, the picture with its vectors, and multiplies the slopes. */
  transform(picture: PictureLike, options?: Borders<ResizeBorder> & {
    type?: AutoType;
    y?: Y;
    flipX?: boolean;
    flipY?: boolean;
    /** Degrees; quarter turns only move levels. */
    rotate?: number;
    strength?: number;
    touchUnused?: boolean;
  }): Picture;

  /** A detail over a base, of its type and size; the detail is repeated where it is smaller. */
  blend(base: PictureLike, detail: PictureLike, options?: {
    type?: AutoType;
    detailType?: AutoType;
    y?: Y;
    detailY?: Y;
    mode?: "rnm" | "whiteout" | "udn" | "linear";
    strength?: number;
    detailAlpha?: boolean;
    touchUnused?: boolean;
  }): Picture;
}

/**
 * Makes an instance: from libntp.wasm beside this module, or from an address, bytes or a compiled
 * module that the caller has.  An instance keeps the memory of its largest picture; a new one starts
 * with little.
 */
export function load(source?: string | URL | BufferSource | WebAssembly.Module): Promise<Ntp>;
