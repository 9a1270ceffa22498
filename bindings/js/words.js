// SPDX-License-Identifier: MIT
// The words of the command line.  Each list has the order of its enum in libntp.h; a test compares them.
export const ENCODINGS = ["standard", "zzero", "xy", "vector", "height"];
export const YS = ["up", "down"];
export const CLASSES = ["standard", "zzero", "xy", "height", "object-space", "one-color", "not-normals"];
export const ACCIDENTS = [
  "gamma",
  "red-is-z",
  "green-is-z",
  "dxt5nm",
  "lossy",
  "filtered",
  "z-flipped",
  "blue-constant",
];
export const METHODS = ["derive", "normalize", "keep"];
export const VERDICTS = ["neighbor", "rounded", "exact"];
export const KERNELS = [
  "central",
  "forward",
  "prewitt3",
  "sobel3",
  "scharr3",
  "prewitt5",
  "sobel5",
  "gimp5",
  "gimp7",
  "gimp9",
  "baked",
];
export const BORDERS = ["wrap", "clamp", "mirror", "extrapolate", "repeat-slope"];
export const SOURCES = [
  "red",
  "green",
  "blue",
  "alpha",
  "luma",
  "luma-gimp",
  "luma-eberly",
  "mean",
  "max",
  "min",
  "screen",
];
export const BLUES = ["derived", "nearest"];
export const ALPHAS = ["keep", "one", "inverse", "height", "inverse-height"];
export const PALETTES = ["reference", "safe"];
export const HEIGHT_METHODS = ["auto", "telescoping", "frankot-chellappa", "poisson-dct"];
export const DECODES = ["auto", "unorm", "neutral", "unorm-trunc", "snorm128"];
export const ZS = ["auto", "stored", "derived"];
export const FILTERS = ["triangle", "box", "lanczos3"];
export const BLENDS = ["rnm", "whiteout", "udn", "linear"];
