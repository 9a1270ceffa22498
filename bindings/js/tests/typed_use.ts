// SPDX-License-Identifier: MIT
// Uses of the module that compile, and some that must not.
import { FLAGS, load, NtpError, type Cleaned, type Heights, type Picture } from "../index.js";

const ntp = await load();
const texture: Picture<Uint8Array> = {
  data: new Uint8Array(3),
  width: 1,
  height: 1,
  channels: 3,
};

const cleaned: Cleaned<Uint8Array> = ntp.clean(texture, { method: "derive" });
const again: Picture = ntp.clean(cleaned);
const green: "up" | "down" | "undecided" = ntp.check(again).green.y;
const heights: Heights = ntp.heightFromNormals(texture, { y: "opengl", borderX: "auto" });
const deep = ntp.normalsFromHeight(heights, { scale: heights.max - heights.min, depth: 16 });
const wrong = ntp.validate(deep).filter((flags) => !(flags & FLAGS.neighbor)).length;
const half = ntp.resize(deep, 1, 1, { filter: "box", border: "wrap" });
const shown: Uint8Array = ntp.shade(ntp.blend(half, half, { mode: "rnm" }), { light: [0, 0, 1] }).data;

try {
  ntp.convert(texture, { to: "zzero", toY: "directx" });
} catch (error) {
  if (error instanceof NtpError) console.log(error.status, green, wrong, shown);
}

// @ts-expect-error: no such method
ntp.clean(texture, { method: "keep" });
// @ts-expect-error: no such option
ntp.check(texture, { kind: "auto" });
// @ts-expect-error: heights have no such kernel
ntp.normalsFromHeight(texture, { kernel: "baked" });
// @ts-expect-error: a picture has a size
ntp.heatmap({ data: new Uint8Array(3) });
