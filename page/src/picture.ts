// SPDX-License-Identifier: MIT
// Draws a texture on a canvas: as it is, lit, on a sphere, tiled.  The samples are those of the file;
// the browser's own decoding would manage colors and multiply by alpha.
import type { Texture } from "./program.js";

export type Mode = "texture" | "heatmap" | "lit" | "sphere" | "tiles";
export const MODES: readonly Mode[] = ["texture", "heatmap", "lit", "sphere", "tiles"];

/** How blue stores z; green points up (1) or down (-1). */
export interface Reading {
  type: string;
  up: 1 | -1;
}

export interface Light {
  x: number;
  y: number;
}

const AMBIENT = 0.12;
const SHINE = 24;
const GLOSS = 0.35;
const GRAY = 175;

const mostOf = ({ data }: Texture) => (data instanceof Uint8Array ? 255 : data instanceof Uint16Array ? 65535 : 1);

/** A texture at the size at which it is drawn. */
export class Picture {
  readonly width: number;
  readonly height: number;
  readonly #samples: Float32Array;
  readonly #channels: number;
  #normals: Float32Array | null = null;

  constructor(texture: Texture) {
    ({ width: this.width, height: this.height } = texture.drawn);
    this.#channels = texture.channels;
    this.#samples = texture.means;
  }

  colors(): ImageData {
    const image = new ImageData(this.width, this.height);
    const gray = this.#channels < 3;
    for (let i = 0, from = 0; i < image.data.length; i += 4, from += this.#channels) {
      for (let c = 0; c < 3; c++) image.data[i + c] = 255 * this.#samples[from + (gray ? 0 : c)];
      image.data[i + 3] = 255;
    }
    return image;
  }

  /** Unit vectors: x right, y up, z to the viewer. */
  normals({ type, up }: Reading): Float32Array {
    if (this.#normals !== null) return this.#normals;
    const out = new Float32Array(3 * this.width * this.height);
    for (let i = 0, from = 0; i < out.length; i += 3, from += this.#channels) {
      const x = 2 * this.#samples[from] - 1;
      const y = this.#channels > 1 ? (2 * this.#samples[from + 1] - 1) * up : 0;
      const derived = Math.sqrt(Math.max(0, 1 - x * x - y * y));
      const blue = this.#channels > 2 ? this.#samples[from + 2] : 1;
      const z = type === "xy" || this.#channels < 3 ? derived : type === "zzero" ? blue : 2 * blue - 1;
      const length = Math.hypot(x, y, z) || 1;
      out[i] = x / length;
      out[i + 1] = y / length;
      out[i + 2] = z / length;
    }
    this.#normals = out;
    return out;
  }
}

/** Lambert and Blinn's light on a gray surface. */
function shading({ x, y }: Light): (nx: number, ny: number, nz: number) => number {
  const length = Math.hypot(x, y, 0.8);
  const [lx, ly, lz] = [x / length, y / length, 0.8 / length];
  const half = Math.hypot(lx, ly, lz + 1); // of the direction between light and viewer
  return (nx, ny, nz) => {
    const sum = nx * lx + ny * ly + nz * lz;
    const facing = Math.max(0, sum);
    const shine = Math.max(0, (sum + nz) / half);
    return GRAY * (AMBIENT + (1 - AMBIENT) * facing) + 255 * GLOSS * facing * shine ** SHINE;
  };
}

export function litPlane(picture: Picture, reading: Reading, light: Light): ImageData {
  const image = new ImageData(picture.width, picture.height);
  const normals = picture.normals(reading);
  const shade = shading(light);
  for (let i = 0, from = 0; i < image.data.length; i += 4, from += 3) {
    const value = shade(normals[from], normals[from + 1], normals[from + 2]);
    image.data[i] = image.data[i + 1] = image.data[i + 2] = value;
    image.data[i + 3] = 255;
  }
  return image;
}

const SPHERE = 512;

/** The mean of the four nearest normals of a place in 0..1, weighted by how near they are. */
function between({ width, height }: Picture, normals: Float32Array, u: number, v: number): [number, number, number] {
  const within = (place: number, size: number) => Math.min(size - 1, Math.max(0, place));
  const [x, y] = [within(u * width - 0.5, width), within(v * height - 0.5, height)];
  const [left, top] = [Math.floor(x), Math.floor(y)];
  const [right, bottom] = [within(left + 1, width), within(top + 1, height)];
  const [fx, fy] = [x - left, y - top];
  const [a, b] = [3 * (top * width + left), 3 * (top * width + right)];
  const [c, d] = [3 * (bottom * width + left), 3 * (bottom * width + right)];
  const [p, q, r, s] = [(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy];
  const mean = (i: number) => p * normals[a + i] + q * normals[b + i] + r * normals[c + i] + s * normals[d + i];
  return [mean(0), mean(1), mean(2)];
}

/** The texture once around half a sphere, in its tangent space. */
export function litSphere(picture: Picture, reading: Reading, light: Light): ImageData {
  const image = new ImageData(SPHERE, SPHERE);
  const normals = picture.normals(reading);
  const shade = shading(light);
  for (let row = 0; row < SPHERE; row++)
    for (let column = 0; column < SPHERE; column++) {
      const at = 4 * (row * SPHERE + column);
      const sx = (2.1 * (column + 0.5)) / SPHERE - 1.05;
      const sy = 1.05 - (2.1 * (row + 0.5)) / SPHERE;
      const inside = 1 - sx * sx - sy * sy;
      image.data[at + 3] = 255;
      if (inside <= 0) {
        image.data[at] = image.data[at + 1] = image.data[at + 2] = 96;
        continue;
      }
      const sz = Math.sqrt(inside);
      const u = Math.atan2(sx, sz) / Math.PI + 0.5;
      const v = 0.5 - Math.asin(sy) / Math.PI;
      const [nx, ny, nz] = between(picture, normals, u, v);
      const around = Math.hypot(sx, sz) || 1;
      const [tx, tz] = [sz / around, -sx / around]; // to the east
      const [bx, by, bz] = [sy * tz, sz * tx - sx * tz, -sy * tx]; // to the north
      const value = shade(
        nx * tx + ny * bx + nz * sx,
        ny * by + nz * sy,
        nx * tz + ny * bz + nz * sz,
      );
      image.data[at] = image.data[at + 1] = image.data[at + 2] = value;
    }
  return image;
}

/** The numbers of one texel, as they are stored. */
export function texelAt({ data, width, channels }: Texture, x: number, y: number): number[] {
  const at = (y * width + x) * channels;
  return [...data.subarray(at, at + channels)];
}

/** The vector of a texel and its length. */
export function vectorOf(texel: number[], texture: Texture, type: string): { vector: number[]; length: number } {
  const most = mostOf(texture);
  const stored = texel.slice(0, 3).map((value) => value / most);
  const vector = stored.map((value, i) => (i === 2 && type === "zzero" ? value : 2 * value - 1));
  if (type === "xy") vector[2] = Math.sqrt(Math.max(0, 1 - vector[0] ** 2 - (vector[1] ?? 0) ** 2));
  return { vector, length: Math.hypot(...vector) };
}
