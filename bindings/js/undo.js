// SPDX-License-Identifier: MIT
// Accidents that are exactly undone, by the rule of `ntp clean`: exchanged channels, DXT5nm, inverted
// blue, sRGB.

const SAMPLES_PER_VECTOR = 3;

/** The accident that is in the way of cleaning, or null.  `found` is what `check` says. */
export function accidentOf(found, channels) {
  if (!["standard", "zzero", "xy", "one-color"].includes(found.type) || channels < SAMPLES_PER_VECTOR)
    return null;
  const has = (name) => found.accidents.includes(name);
  if (has("gamma")) return "srgb";
  if (has("red-is-z")) return "red-blue";
  if (has("green-is-z")) return "green-blue";
  if (has("dxt5nm")) return channels === 4 ? "dxt5nm" : null;
  return found.type === "standard" && has("z-flipped") ? "inverted-blue" : null;
}

/** Whether the linear light of k / 2 sRGB levels is at least q / 2 levels.  Above 0.04045 it is
 * ((s + 0.055) / 1.055)^2.4; both sides are raised to the fifth power. */
function reaches(k, q, most) {
  if (100000 * k <= 8090 * most) return 25 * k >= 323 * q;
  const [K, Q, M] = [k, q, most].map(BigInt);
  return 32n * (100n * K + 11n * M) ** 12n >= Q ** 5n * 211n ** 12n * M ** 7n;
}

/** The nearest linear level of each sRGB level.  Floating point is sure away from the halves; near
 * them integers decide. */
function linearLevels(most) {
  return Array.from({ length: most + 1 }, (_, level) => {
    const stored = level / most;
    const light = (stored <= 0.04045 ? stored / 12.92 : ((stored + 0.055) / 1.055) ** 2.4) * most;
    const half = Math.round(light + 0.5);
    if (Math.abs(light + 0.5 - half) >= 1e-6) return Math.floor(light + 0.5);
    return half - 1 + Number(reaches(2 * level, 2 * half - 1, most));
  });
}

function exchanged(picture, a, b) {
  const data = picture.data.slice();
  for (let i = 0; i < data.length; i += picture.channels)
    [data[i + a], data[i + b]] = [data[i + b], data[i + a]];
  return { ...picture, data };
}

function unpacked(picture, most) {
  const texels = picture.width * picture.height;
  const data = new picture.data.constructor(SAMPLES_PER_VECTOR * texels).fill(most);
  for (let i = 0; i < texels; i++) {
    data[3 * i] = picture.data[4 * i + 3];
    data[3 * i + 1] = picture.data[4 * i + 1];
  }
  return { ...picture, data, channels: SAMPLES_PER_VECTOR };
}

function upright(picture, most) {
  const data = picture.data.slice();
  for (let i = 0; i < data.length; i += picture.channels) {
    const [red, green, blue] = data.subarray(i, i + SAMPLES_PER_VECTOR);
    const unused = red === green && green === blue && (blue === 0 || blue === most);
    if (!unused) data[i + 2] = most - blue;
  }
  return { ...picture, data };
}

function linear(picture, most) {
  const levels = linearLevels(most);
  const data = picture.data.slice();
  for (let i = 0; i < data.length; i += picture.channels)
    for (let c = 0; c < SAMPLES_PER_VECTOR; c++) data[i + c] = levels[data[i + c]];
  return { ...picture, data };
}

/** The picture before the accident; DXT5nm gives three channels, z being 1. */
export function undone(picture, accident) {
  const most = [255, 65535, 1][picture.type];
  if (accident === "red-blue") return exchanged(picture, 0, 2);
  if (accident === "green-blue") return exchanged(picture, 1, 2);
  if (accident === "dxt5nm") return unpacked(picture, most);
  return accident === "inverted-blue" ? upright(picture, most) : linear(picture, most);
}
