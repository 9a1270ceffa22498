/* SPDX-License-Identifier: MIT */
/*
 * options.c - the table of options
 *
 * An option may have several rows, each with a mask of the verbs that it is for.  The order is that
 * of the help.  A row without a help text is an older name, which is accepted and not shown.  tests/cli/test_names.py holds the choices equal to the values of libntp.h.
 */
#include "options/options.h"

#define TYPES     "auto|standard|zzero|xy|height"
#define Y_WORDS   "up|down|opengl|directx"
#define VERDICTS  "neighbor|rounded|exact"
#define ENCODINGS "standard|zzero|xy"
#define FORMATS   "text|json"
#define KERNELS   "central|forward|prewitt3|sobel3|scharr3|prewitt5|sobel5|gimp5|gimp7|gimp9"
#define BORDERS   "wrap|clamp|mirror|extrapolate|repeat-slope"
#define SOURCES   "red|green|blue|alpha|luma|luma-gimp|luma-eberly|mean|max|min|screen"

/* clang-format off */
const option_spec OPTION_TABLE[] = {
    { OPT_TYPE, "type", 0, KIND_CHOICE, TYPES, "auto", 0, 0,
      V_CHECK | V_CLEAN | V_HEATMAP | V_DUMP | V_DIFF | V_TRANSFORM | V_RESIZE | V_BLEND,
      "what the files are; auto: detect it from their texels. Any other value is final: files "
      "that would be refused or classified as something else are taken for this" },
    { OPT_Y, "y", 0, KIND_CHOICE, "auto|" Y_WORDS, "auto", 0, 0, V_CHECK,
      "which way green should point: up (OpenGL, glTF, USD) or down (DirectX)" },
    { OPT_Y, "y", 0, KIND_CHOICE, "auto|" Y_WORDS, "auto", 0, 0,
      V_CLEAN | V_HEATMAP | V_DUMP | V_DIFF | V_RESIZE,
      "which way green points: up (OpenGL, glTF, USD) or down (DirectX). The result is the same "
      "for both" },
    { OPT_VERDICT, "verdict", 0, KIND_CHOICE, VERDICTS, "neighbor", 0, 0, V_CHECK,
      "how strictly a texel is judged. neighbor: within one level of unit length; rounded: a "
      "correctly rounded unit vector; exact: blue is the one that red and green imply" },
    { OPT_VERDICT, "verdict", 0, KIND_CHOICE, VERDICTS, "neighbor", 0, 0, V_CLEAN,
      "which texels --only-failing repairs (see ntp check --help)" },
    { OPT_VERDICT, "verdict", 0, KIND_CHOICE, VERDICTS, "neighbor", 0, 0, V_DUMP,
      "list the texels that fail this verdict (see ntp check --help)" },
    { OPT_KEEP_NEGATIVE_Z, "keep-negative-z", 0, KIND_FLAG, NULL, NULL, 0, 0, V_CHECK | V_CLEAN | V_DUMP,
      "normals may point away from the viewer: a negative Z is not an error and stays" },
    { OPT_POLICY, "policy", 0, KIND_CHOICE, "harm|strict", "harm", 0, 0, V_CHECK,
      "what makes wrong texels a warning or an error. harm: the angle that a renderer shows, and "
      "how much of the picture it touches; strict: every texel that fails --verdict" },
    { OPT_MAX_ANGLE, "max-angle", 0, KIND_NUMBER, "DEG", "5", 0, 180, V_CHECK,
      "with --policy harm: a normal that is off by more, in degrees, is visible" },
    { OPT_MAX_FAIL, "max-fail", 0, KIND_NUMBER, "PERCENT", "2", 0, 100, V_CHECK,
      "a larger share of texels that are off by more than --max-angle (--policy strict: that fail "
      "--verdict) is an error" },
    { OPT_MAX_TILT, "max-tilt", 0, KIND_NUMBER, "X", "0.1", 0, 1, V_CHECK,
      "warn where the mean of x or y, in -1..1, is farther from 0 than this" },
    { OPT_FAIL_ON, "fail-on", 0, KIND_CHOICE, "error|warning|never", "error", 0, 0, V_CHECK,
      "exit with 1 if a finding has this level or above" },
    { OPT_BASELINE, "baseline", 0, KIND_STRING, "FILE", NULL, 0, 0, V_CHECK,
      "the JSON of an earlier check: findings that it contains are not counted again" },
    { OPT_DEEP, "deep", 0, KIND_FLAG, NULL, NULL, 0, 0, V_CHECK,
      "use the whole texture, not only its middle, to detect which kernel made it and how well "
      "a surface fits, and print both; use every row, not only some, to detect which way green "
      "points. The texture is held in memory" },

    { OPT_OUTPUT, "output", 'o', KIND_STRING, "FILE|DIR", NULL, 0, 0, V_WRITES,
      "where to write: a file, - for standard output, or a directory, in which relative paths "
      "are kept and names end in .png. A file takes only a single input. An input is not "
      "overwritten, under any of its names, unless --in-place or --force is given" },
    { OPT_OUTPUT, "output", 'o', KIND_STRING, "HEATMAP", NULL, 0, 0, V_DIFF,
      "write a picture of the differences: black means equal, then come blue, green, and red "
      "for 10 degrees and more" },
    { OPT_FAIL_OVER, "fail-over", 0, KIND_NUMBER, "DEG", NULL, 0, 180, V_DIFF,
      "exit with 1 only if the mean angle is above DEG degrees, here or in a mip; without it, if "
      "anything differs" },
    { OPT_IN_PLACE, "in-place", 0, KIND_FLAG, NULL, NULL, 0, 0, V_CLEAN,
      "repair the files themselves; only files that change are written" },
    { OPT_IN_PLACE, "in-place", 0, KIND_FLAG, NULL, NULL, 0, 0, V_CONVERT,
      "convert the files themselves; only files that change are written" },
    { OPT_IN_PLACE, "in-place", 0, KIND_FLAG, NULL, NULL, 0, 0, V_BLEND,
      "write the result in the place of BASE" },
    { OPT_IN_PLACE, "in-place", 0, KIND_FLAG, NULL, NULL, 0, 0,
      V_WRITES & ~(unsigned) (V_CLEAN | V_CONVERT | V_BLEND),
      "write each result in the place of its input" },
    { OPT_METHOD, "method", 0, KIND_CHOICE, "auto|derive|normalize", "auto", 0, 0, V_CLEAN,
      "derive: keep x and y, compute z; normalize: divide each failing vector by its length "
      "(better after JPEG or resizing); auto: choose by the errors of the file. A file in which "
      "every texel is a correctly rounded unit vector stays as it is" },
    { OPT_UNDO, "undo", 0, KIND_FLAG, NULL, NULL, 0, 0, V_CLEAN,
      "first undo what can be undone exactly: exchanged channels, DXT5nm, inverted blue, numbers "
      "converted to sRGB. Where that is at least 90 % sure, it is undone also without --undo, "
      "unless --type says what the file is" },
    { OPT_ONLY_FAILING, "only-failing", 0, KIND_FLAG, NULL, NULL, 0, 0, V_CLEAN,
      "leave texels that pass --verdict as they are" },
    { OPT_ONLY_CHANGED, "only-changed", 0, KIND_FLAG, NULL, NULL, 0, 0, V_CLEAN,
      "write only files in which a texel changes" },
    { OPT_TYPE, "type", 0, KIND_CHOICE, TYPES, "auto", 0, 0, V_CONVERT,
      "how the input stores a normal: standard: x, y, z in -1..1; zzero: z in 0..1; xy: no z; "
      "height: it is not a normal (only --depth goes with it); auto: detect it from the texels. "
      "If that is not sure and --to is given, the file is refused" },
    { OPT_TYPE, "from", 0, KIND_CHOICE, TYPES, NULL, 0, 0, V_CONVERT, NULL },
    { OPT_TO, "to", 0, KIND_CHOICE, ENCODINGS, NULL, 0, 0, V_CONVERT,
      "how the output stores it. Without it the encoding stays; but where --type says what the "
      "input is, it becomes standard" },
    { OPT_Y, "y", 0, KIND_CHOICE, "auto|" Y_WORDS, "auto", 0, 0, V_CONVERT,
      "which way green points in the input: up (OpenGL) or down (DirectX); auto: as the texels "
      "show. If ntp check is not sure and --to-y is given, the file is refused" },
    { OPT_Y, "from-y", 0, KIND_CHOICE, "auto|" Y_WORDS, NULL, 0, 0, V_CONVERT, NULL },
    { OPT_TO_Y, "to-y", 0, KIND_CHOICE, Y_WORDS, NULL, 0, 0, V_CONVERT,
      "which way green points in the output. Without it green stays; but where --y says which way "
      "it points, it becomes up" },
    { OPT_DEPTH, "depth", 0, KIND_CHOICE, "8|16", NULL, 0, 0, V_CONVERT,
      "bits of each sample of the output; default: as the input" },
    { OPT_CHANNELS, "channels", 0, KIND_STRING, "SPEC", NULL, 0, 0, V_CONVERT,
      "what each channel of the output holds, one letter each of x y z 0 1 and a (alpha): xyz, "
      "xzy, 1y0x (DXT5nm); two letters make a gray and alpha PNG" },
    { OPT_FROM_CHANNELS, "from-channels", 0, KIND_STRING, "SPEC", NULL, 0, 0, V_CONVERT,
      "what each channel of the input holds, in the same letters, with - for an unused channel: "
      "-y-x reads DXT5nm. If z is missing, it is computed" },
    { OPT_COMPRESSION, "compression", 0, KIND_CHOICE, "blocks|none", "blocks", 0, 0, V_CONVERT,
      "of .dds and .ktx2. blocks: BC5 for normals, which keeps x and y, and BC4 for heights; none: "
      "1, 2 or 4 channels, RGB with an opaque alpha" },
    { OPT_QUALITY, "quality", 0, KIND_CHOICE, "angle|channel|quick", "angle", 0, 0, V_CONVERT,
      "of BC5 and BC4. angle: by the angle between the vectors; channel: the best that each channel "
      "alone can be; quick: several times faster than channel, nearly as good" },
    { OPT_MIPS, "mips", 0, KIND_FLAG, NULL, NULL, 0, 0, V_CONVERT,
      "all mips in the one file, each made of the whole texture, as ntp resize --mips makes them" },
    { OPT_SCALE, "scale", 0, KIND_NUMBER, "S|auto", NULL, -1.7e308, 1.7e308, V_FROM_HEIGHT,
      "how many texels a height of 1 (white) rises above 0 (black); negative turns hills into "
      "dents. auto: as the slopes of the heights, before blur and octaves, suggest: one in twenty "
      "of the texels that are not flat is then steeper than 45 degrees" },
    { OPT_TYPE, "type", 0, KIND_CHOICE, "auto|" ENCODINGS, "auto", 0, 0, V_TO_DEPTH,
      "how the input stores a normal; auto: standard, unless the texels are surely something else. "
      "An image that is surely none of these is refused" },
    { OPT_Y, "y", 0, KIND_CHOICE, "auto|" Y_WORDS, "auto", 0, 0, V_TO_DEPTH,
      "which way green points: up (OpenGL) or down (DirectX); auto: as the texels show, if ntp "
      "check is sure; up where nothing says down, as photometric stereo has it; else the file is "
      "refused" },
    { OPT_CAMERA, "camera", 0, KIND_STRING, "FX,FY,CX,CY", NULL, 0, 0, V_TO_DEPTH,
      "the focal lengths and the place of the axis, in texels, the middle of the first texel being "
      "0,0. Without it all rays are parallel" },
    { OPT_CONFIDENCE, "confidence", 0, KIND_STRING, "FILE", NULL, 0, 0, V_TO_DEPTH,
      "also write how sure the depth is at each texel, from black to white: 1/(1 + the error that "
      "may be expected, in texels); a 16-bit PNG, or .pfm. It takes as long again" },
    { OPT_K, "k", 0, KIND_NUMBER, "K", "2", 1e-6, 1e6, V_TO_DEPTH,
      "how readily a cliff is seen" },
    { OPT_ROUNDS, "rounds", 0, KIND_INTEGER, "N", "33", 1, 100000, V_TO_DEPTH,
      "at most so many rounds; 1 is least squares, which know no cliffs" },
    { OPT_DEPTH, "depth", 0, KIND_CHOICE, "16|float", "16", 0, 0, V_TO_DEPTH,
      "16: a 16-bit gray PNG, where 1 is nearest, 65535 farthest and 0 no surface; float: a PFM, "
      "where NaN is no surface. The default for -o FILE.pfm is float" },
    { OPT_STRENGTH, "strength", 0, KIND_NUMBER, "S", "1", -1024, 1024, V_FROM_HEIGHT,
      "multiply the scale, as after --scale auto" },
    { OPT_DX, "dx", 0, KIND_NUMBER, "D", "1", 0, 1.7e308, V_FROM_HEIGHT | V_TO_HEIGHT,
      "width of a texel, where texels are not square" },
    { OPT_DY, "dy", 0, KIND_NUMBER, "D", "1", 0, 1.7e308, V_FROM_HEIGHT | V_TO_HEIGHT,
      "height of a texel" },
    { OPT_INVERT, "invert", 0, KIND_FLAG, NULL, NULL, 0, 0, V_FROM_HEIGHT,
      "black is high and white is low" },
    { OPT_KERNEL, "kernel", 0, KIND_CHOICE, KERNELS, "central", 0, 0, V_FROM_HEIGHT,
      "how a slope is computed; wider kernels are smoother, and all are equally strong" },
    { OPT_BORDER, "border", 0, KIND_CHOICE, BORDERS, "wrap", 0, 0, V_FROM_HEIGHT,
      "the height beyond the edges: wrap for textures that tile" },
    { OPT_BORDER_X, "border-x", 0, KIND_CHOICE, BORDERS, NULL, 0, 0, V_FROM_HEIGHT,
      "the same for the left and right edges only" },
    { OPT_BORDER_Y, "border-y", 0, KIND_CHOICE, BORDERS, NULL, 0, 0, V_FROM_HEIGHT,
      "the same for the upper and lower edges only" },
    { OPT_SOURCE, "source", 0, KIND_CHOICE, SOURCES, "red", 0, 0, V_FROM_HEIGHT,
      "what of a color image is the height; gray images have only one channel" },
    { OPT_BLUR, "blur", 0, KIND_NUMBER, "SIGMA", "0", 0, 64, V_FROM_HEIGHT,
      "first blur the heights by a Gaussian with this sigma, in texels" },
    { OPT_OCTAVES, "octaves", 0, KIND_STRING, "W,W,...", NULL, 0, 0, V_FROM_HEIGHT,
      "use a weighted sum of the heights without blur and blurred by 1, by 2, by 4 texels and "
      "so on: 1,1,2 emphasizes large shapes" },
    { OPT_DITHER, "dither", 0, KIND_CHOICE, "none|integrable", "none", 0, 0, V_FROM_HEIGHT,
      "integrable: pass rounding errors on to the next texels, so that heights can be "
      "reconstructed accurately from the result" },
    { OPT_LIKE, "like", 0, KIND_STRING, "PEER:VALUE", NULL, 0, 0, V_FROM_HEIGHT,
      "the settings of another program, correctly rounded: reference:5, eberly:4, zima:8, "
      "gegl:10, gimp-normalmap:sobel3:1 (docs/equivalences.md); other options override them" },
    { OPT_TO, "to", 0, KIND_CHOICE, ENCODINGS, "standard", 0, 0, V_FROM_HEIGHT,
      "how the output stores a normal: standard: x, y, z in -1..1; zzero: z in 0..1; xy: no z" },
    { OPT_TO_Y, "to-y", 0, KIND_CHOICE, Y_WORDS, "up", 0, 0, V_FROM_HEIGHT,
      "which way green points: up (OpenGL, glTF, USD) or down (DirectX)" },
    { OPT_DEPTH, "depth", 0, KIND_CHOICE, "8|16", NULL, 0, 0, V_FROM_HEIGHT,
      "bits of each sample of the output; default: as the input" },
    { OPT_BLUE, "blue", 0, KIND_CHOICE, "derived|nearest", "derived", 0, 0, V_FROM_HEIGHT,
      "derived: blue is computed from the rounded red and green, so ntp clean changes nothing; "
      "nearest: z is rounded independently" },
    { OPT_MIN_Z, "min-z", 0, KIND_NUMBER, "Z", "0", 0, 1, V_FROM_HEIGHT,
      "the least z: steeper normals are raised to it" },
    { OPT_ALPHA, "alpha", 0, KIND_STRING, "keep|height|inverse|one|FILE", "keep", 0, 0, V_FROM_HEIGHT,
      "the alpha of the output: that of the input, the height (LabPBR), the input's inverted, "
      "opaque, or the first channel of an image" },
    { OPT_AO, "ao", 0, KIND_STRING, "FILE", NULL, 0, 0, V_FROM_HEIGHT,
      "with --to xy: an image whose first channel goes into blue (LabPBR: ambient occlusion)" },
    { OPT_CHANNELS, "channels", 0, KIND_STRING, "SPEC", NULL, 0, 0, V_FROM_HEIGHT,
      "what each channel of the output holds, one letter each of x y z 0 1, h (height) and a "
      "(alpha): xyz, xzy, xyzh, 1y0x" },
    { OPT_TYPE, "type", 0, KIND_CHOICE, "auto|" ENCODINGS, "auto", 0, 0, V_TO_HEIGHT,
      "how the input stores a normal; auto: detect it from the texels. Any other value is "
      "final: files that would be refused are taken for this" },
    { OPT_TYPE, "from", 0, KIND_CHOICE, "auto|" ENCODINGS, NULL, 0, 0, V_TO_HEIGHT, NULL },
    { OPT_Y, "y", 0, KIND_CHOICE, "auto|" Y_WORDS, "auto", 0, 0, V_TO_HEIGHT,
      "which way green points: up (OpenGL) or down (DirectX); auto: as the texels show, if ntp "
      "check is sure, else the file is refused" },
    { OPT_Y, "from-y", 0, KIND_CHOICE, "auto|" Y_WORDS, NULL, 0, 0, V_TO_HEIGHT, NULL },
    { OPT_KERNEL, "kernel", 0, KIND_CHOICE, "auto|" KERNELS "|baked", "auto", 0, 0, V_TO_HEIGHT,
      "how the slopes were computed from heights; baked: they are those of a surface, at texel "
      "centers. auto: the one that fits best, else central or baked" },
    { OPT_BORDER, "border", 0, KIND_CHOICE, "auto|" BORDERS, "auto", 0, 0, V_TO_HEIGHT,
      "the height beyond the edges. auto: detect it from the normals at the edges and from "
      "whether the texture tiles, else the one with which normals fit best" },
    { OPT_BORDER_X, "border-x", 0, KIND_CHOICE, "auto|" BORDERS, NULL, 0, 0, V_TO_HEIGHT,
      "the same for the left and right edges only" },
    { OPT_BORDER_Y, "border-y", 0, KIND_CHOICE, "auto|" BORDERS, NULL, 0, 0, V_TO_HEIGHT,
      "the same for the upper and lower edges only" },
    { OPT_METHOD, "method", 0, KIND_CHOICE,
      "auto|telescoping|frankot-chellappa|poisson-dct|weighted", "auto", 0, 0, V_TO_HEIGHT,
      "frankot-chellappa, poisson-dct: least squares, for textures that tile and that do not; "
      "weighted: with holes where texels are unused or masked, and less weight on steep texels; "
      "telescoping: sums of slopes, after Eberly. auto: weighted if there are holes, else by "
      "the borders" },
    { OPT_REFINE, "refine", 0, KIND_INTEGER, "N", "0", 0, 100000, V_TO_HEIGHT,
      "do up to N more rounds, until the normals of the heights are those of the input" },
    { OPT_SEEDS, "seeds", 0, KIND_STRING, "H00,H10,H01,H11", NULL, 0, 0, V_TO_HEIGHT,
      "telescoping: the heights of the four texels at the upper left, in texels; the kernel forward "
      "uses the first" },
    { OPT_EQUALIZE, "equalize", 0, KIND_FLAG, NULL, NULL, 0, 0, V_TO_HEIGHT,
      "telescoping: give texels of even and of odd rows and columns the same mean" },
    { OPT_MASK, "mask", 0, KIND_STRING, "FILE", NULL, 0, 0, V_TO_HEIGHT | V_TO_DEPTH,
      "an image of the same size: there is no surface where its first channel is 0" },
    { OPT_DETREND, "detrend", 0, KIND_FLAG, NULL, NULL, 0, 0, V_TO_HEIGHT,
      "remove the best-fitting plane from the heights, where they do not tile" },
    { OPT_CLIP, "clip", 0, KIND_NUMBER, "PERCENT", "0", 0, 49, V_TO_HEIGHT,
      "raise the lowest PERCENT of the heights to the next one, and lower the highest PERCENT, "
      "before the range is chosen; 0.1 leaves spikes out" },
    { OPT_DECODE, "decode", 0, KIND_CHOICE, "auto|unorm|neutral|unorm-trunc|snorm128", "auto", 0, 0,
      V_TO_HEIGHT,
      "which level of red and green is 0, in 8 bit: unorm: 127.5; neutral: the same, but 127 "
      "and 128 are both 0; unorm-trunc: 127, levels were truncated; snorm128: 128. auto: detect "
      "it from the texels" },
    { OPT_Z, "z", 0, KIND_CHOICE, "auto|stored|derived", "auto", 0, 0, V_TO_HEIGHT,
      "whether z is read from blue or computed from red and green; auto: decide by the texels" },
    { OPT_DEPTH, "depth", 0, KIND_CHOICE, "16|float", "16", 0, 0, V_TO_HEIGHT,
      "16: a 16-bit gray PNG, where black is lowest and white is highest; float: a PFM of "
      "heights in texels. The default for -o FILE.pfm is float" },
    { OPT_STRENGTH, "strength", 0, KIND_NUMBER, "S", NULL, -1024, 1024, V_TRANSFORM,
      "multiply the slopes: 2 makes bumps twice as high, 0.5 half as high, -1 turns them into dents" },
    { OPT_FLIP, "flip", 0, KIND_CHOICE, "x|y|xy", NULL, 0, 0, V_TRANSFORM,
      "x: exchange left and right; y: exchange top and bottom; done before --rotate" },
    { OPT_ROTATE, "rotate", 0, KIND_NUMBER, "DEG", NULL, -360, 360, V_TRANSFORM,
      "turn clockwise by this many degrees. Multiples of 90 are exact; by other angles the "
      "texture is turned about its middle, keeps its size, and is resampled" },
    { OPT_BORDER, "border", 0, KIND_CHOICE, "wrap|clamp|mirror", "wrap", 0, 0, V_TRANSFORM,
      "what a turn brings in from beyond the edges, if the angle is not a multiple of 90" },
    { OPT_BORDER_X, "border-x", 0, KIND_CHOICE, "wrap|clamp|mirror", NULL, 0, 0, V_TRANSFORM,
      "the same for the left and right edges only" },
    { OPT_BORDER_Y, "border-y", 0, KIND_CHOICE, "wrap|clamp|mirror", NULL, 0, 0, V_TRANSFORM,
      "the same for the upper and lower edges only" },
    { OPT_Y, "y", 0, KIND_CHOICE, "auto|" Y_WORDS, "auto", 0, 0, V_TRANSFORM,
      "which way green points: up (OpenGL, glTF, USD) or down (DirectX); auto: as the texels "
      "show, if ntp check is sure, else the file is refused. Only turns depend on it, and not those by 180 degrees" },
    { OPT_SIZE, "size", 0, KIND_STRING, "WxH|P%", NULL, 0, 0, V_RESIZE,
      "the new size in texels, such as 512x256, or in percent of the old one" },
    { OPT_MIPS, "mips", 0, KIND_FLAG, NULL, NULL, 0, 0, V_RESIZE,
      "write a mip chain: the output, such as wall.png, is level 0, and wall_mip1.png beside it "
      "is half as large; then come wall_mip2.png and so on down to 1 x 1" },
    { OPT_FILTER, "filter", 0, KIND_CHOICE, "box|triangle|lanczos3", NULL, 0, 0, V_RESIZE,
      "box: the mean over an area; triangle: bilinear; lanczos3: sharper, can ring. Default: box "
      "with --mips, else triangle" },
    { OPT_BORDER, "border", 0, KIND_CHOICE, "wrap|clamp|mirror", "wrap", 0, 0, V_RESIZE,
      "what lies beyond the edges: wrap for textures that tile" },
    { OPT_BORDER_X, "border-x", 0, KIND_CHOICE, "wrap|clamp|mirror", NULL, 0, 0, V_RESIZE,
      "the same for the left and right edges only" },
    { OPT_BORDER_Y, "border-y", 0, KIND_CHOICE, "wrap|clamp|mirror", NULL, 0, 0, V_RESIZE,
      "the same for the upper and lower edges only" },
    { OPT_MODE, "mode", 0, KIND_CHOICE, "rnm|whiteout|udn|linear", "rnm", 0, 0, V_BLEND,
      "rnm: reoriented, as if the detail lay on the surface of the base; whiteout and udn: "
      "sums, cheaper in shaders, weaker on slopes; linear: the mean of both, which flattens them "
      "(docs/operations.md)" },
    { OPT_STRENGTH, "strength", 0, KIND_NUMBER, "S", "1", -1024, 1024, V_BLEND,
      "multiply the slopes of the detail first" },
    { OPT_DETAIL_ALPHA, "detail-alpha", 0, KIND_FLAG, NULL, NULL, 0, 0, V_BLEND,
      "the alpha of DETAIL fades it: soft edges, or a mask" },
    { OPT_Y, "y", 0, KIND_CHOICE, "auto|" Y_WORDS, "auto", 0, 0, V_BLEND,
      "which way green points in BASE and in the output: up (OpenGL) or down (DirectX); auto: as "
      "the texels show, if ntp check is sure, else BASE is refused" },
    { OPT_DETAIL_Y, "detail-y", 0, KIND_CHOICE, "auto|" Y_WORDS, "auto", 0, 0, V_BLEND,
      "which way green points in DETAIL; it is turned to that of BASE" },
    { OPT_KIND, "kind", 0, KIND_CHOICE, "mean|gaussian|convex|cavity", "mean", 0, 0, V_CURVATURE,
      "mean: edges bright, grooves dark, flat is gray; gaussian: knobs and pits bright, saddles "
      "dark; convex: edges alone, bright on black; cavity: grooves alone, dark on white" },
    { OPT_TYPE, "type", 0, KIND_CHOICE, TYPES, "auto", 0, 0, V_RELIEF,
      "what the files are: normals (standard, zzero, xy), or heights; auto: detect it from their "
      "texels. Any other value is final" },
    { OPT_Y, "y", 0, KIND_CHOICE, "auto|" Y_WORDS, "auto", 0, 0, V_RELIEF,
      "normals: which way green points: up (OpenGL) or down (DirectX); auto: as the texels show, "
      "if ntp check is sure, else the file is refused" },
    { OPT_SCALE, "scale", 0, KIND_NUMBER, "S|auto", NULL, -1.7e308, 1.7e308, V_RELIEF,
      "heights: how many texels white rises above black; negative turns hills into dents; auto: "
      "as ntp from-height takes it. Default: what ntp to-height stored in the file, and 1 for PFM" },
    { OPT_SOURCE, "source", 0, KIND_CHOICE, SOURCES, "red", 0, 0, V_RELIEF,
      "heights: what of a color image is the height" },
    { OPT_BLUR, "blur", 0, KIND_NUMBER, "SIGMA", "0", 0, 64, V_RELIEF,
      "first blur the heights, or the normals, by a Gaussian with this sigma, in texels: shows "
      "larger shapes and less noise" },
    { OPT_BORDER, "border", 0, KIND_CHOICE, "auto|wrap|clamp", "auto", 0, 0, V_RELIEF,
      "what lies beyond the edges: wrap: the opposite edge, for textures that tile; clamp: nothing; "
      "auto: clamp where opposite edges clearly do not fit together, else wrap" },
    { OPT_BORDER_X, "border-x", 0, KIND_CHOICE, "auto|wrap|clamp", NULL, 0, 0, V_RELIEF,
      "the same for the left and right edges only" },
    { OPT_BORDER_Y, "border-y", 0, KIND_CHOICE, "auto|wrap|clamp", NULL, 0, 0, V_RELIEF,
      "the same for the upper and lower edges only" },
    { OPT_RANGE, "range", 0, KIND_NUMBER, "R", "0", 0, 1e30, V_CURVATURE,
      "the curvature that is shown white (cavity: black), in 1/texel (gaussian: 1/texel^2). 0: 99 "
      "% of what is not flat lies within; it is printed, and stored in the PNG" },
    { OPT_RADIUS, "radius", 0, KIND_NUMBER, "R", "0", 0, 1e30, V_OCCLUSION,
      "what is farther away, in texels, hides nothing; 0: the longer side of the image" },
    { OPT_DEPTH, "depth", 0, KIND_CHOICE, "8|16|float", NULL, 0, 0, V_RELIEF,
      "bits of each sample of the output; float: a PFM, of curvature in 1/texel. Default: as the "
      "input, 16 for floats, and float for -o FILE.pfm" },
    { OPT_PALETTE, "palette", 0, KIND_CHOICE, "reference|safe", "reference", 0, 0, V_HEATMAP,
      "reference: red: x, y too long, green: wrong length, blue: negative z; safe: colors that "
      "can be told apart with every kind of color vision" },
    { OPT_ALL, "all", 0, KIND_FLAG, NULL, NULL, 0, 0, V_DUMP, "list every texel" },
    { OPT_TOUCH_UNUSED, "touch-unused", 0, KIND_FLAG, NULL, NULL, 0, 0, V_RESIZE,
      "treat pure black, pure white and transparent texels like any other; alpha gives no weight" },
    { OPT_TOUCH_UNUSED, "touch-unused", 0, KIND_FLAG, NULL, NULL, 0, 0, V_CLEAN | V_CONVERT | V_BLEND,
      "treat pure black, pure white and transparent texels like any other" },
    { OPT_DRY_RUN, "dry-run", 'n', KIND_FLAG, NULL, NULL, 0, 0, V_CLEAN | V_CONVERT,
      "write nothing, say what would change" },
    { OPT_FORCE, "force", 0, KIND_FLAG, NULL, NULL, 0, 0, V_WRITES,
      "write in spite of what the input is: a named file that would be refused is taken for a "
      "standard texture. -o may also name an input" },
    { OPT_LEVEL, "level", 0, KIND_INTEGER, "1..12", NULL, 1, 12, V_WRITES,
      "PNG output: 1 is fastest, 12 smallest and slow; default: 6, more where the input is smaller" },

    { OPT_FORMAT, "format", 0, KIND_CHOICE, "text|json|csv|list", "text", 0, 0, V_CHECK,
      "text for people, JSON (see docs/schema/check-1.json), CSV with a row for each file, or "
      "list: only the paths of files with findings at or above --fail-on" },
    { OPT_FORMAT, "format", 0, KIND_CHOICE, FORMATS, "text", 0, 0, V_WRITES | V_DIFF,
      "text for people, or JSON" },
    { OPT_NUL, "null", '0', KIND_FLAG, NULL, NULL, 0, 0, V_PATHS,
      "names in --files-from and --format list end with a NUL, not a newline" },
    { OPT_RECURSIVE, "recursive", 'r', KIND_FLAG, NULL, NULL, 0, 0, V_PATHS,
      "descend into directories" },
    { OPT_MATCH, "match", 0, KIND_STRING, "GLOB", NULL, 0, 0, V_PATHS,
      "in directories use only files whose name matches (the path, if GLOB has a slash); may be "
      "repeated" },
    { OPT_EXCLUDE, "exclude", 0, KIND_STRING, "GLOB", NULL, 0, 0, V_PATHS,
      "skip files and directories that match; may be repeated" },
    { OPT_FILES_FROM, "files-from", 0, KIND_STRING, "FILE", NULL, 0, 0, V_PATHS,
      "read paths from FILE, one on each line; - is standard input" },
    { OPT_ALLOW_EMPTY, "allow-empty", 0, KIND_FLAG, NULL, NULL, 0, 0, V_CHECK,
      "nothing to check is no failure: no image was found, or no normals texture" },
    { OPT_ALLOW_EMPTY, "allow-empty", 0, KIND_FLAG, NULL, NULL, 0, 0, V_MAPS,
      "it is no failure that no image was found" },
    { OPT_JOBS, "jobs", 'j', KIND_INTEGER, "N", NULL, 1, 256, V_TO_HEIGHT | V_OCCLUSION,
      "work with N threads, on files at once or on parts of one; default: one for each processor" },
    { OPT_JOBS, "jobs", 'j', KIND_INTEGER, "N", NULL, 1, 256,
      V_PATHS & ~(unsigned) (V_TO_HEIGHT | V_OCCLUSION),
      "work on N files at once; default: one for each processor" },
    { OPT_QUIET, "quiet", 'q', KIND_FLAG, NULL, NULL, 0, 0, V_CHECK,
      "print only files with findings" },
    { OPT_QUIET, "quiet", 'q', KIND_FLAG, NULL, NULL, 0, 0, V_WRITES | V_DUMP | V_DIFF,
      "print only problems" },
    { OPT_VERBOSE, "verbose", 'v', KIND_FLAG, NULL, NULL, 0, 0, V_CHECK,
      "add notes, reasons and statistics" },
    { OPT_VERBOSE, "verbose", 'v', KIND_FLAG, NULL, NULL, 0, 0, V_WRITES,
      "print more about each file" },
    { OPT_COLOR, "color", 0, KIND_CHOICE, "auto|always|never", "auto", 0, 0, V_PATHS,
      "color the text; auto: on a terminal, unless NO_COLOR is set" },
    { OPT_NO_PROGRESS, "no-progress", 0, KIND_FLAG, NULL, NULL, 0, 0, V_PATHS,
      "do not draw a progress bar" },
    { OPT_MAX_SIDE, "max-side", 0, KIND_INTEGER, "N", "65535", 1, 65535, V_ALL,
      "refuse images wider or higher than this" },
    { OPT_MAX_TEXELS, "max-texels", 0, KIND_INTEGER, "N", "1073741824", 1, 4294836225.0, V_ALL,
      "refuse images of more texels than this" },
    { OPT_MAX_AT_ONCE, "max-at-once", 0, KIND_INTEGER, "MIB", "256", 0, 4095, V_ALL,
      "keep a PNG that is read twice in memory, which is faster, if file and picture take up to so many "
      "MiB each; 0: read every PNG row by row through libpng" },
    { OPT_MIP, "mip", 0, KIND_INTEGER, "N", "0", 0, 31, V_ALL,
      "of a DDS or KTX2, read this mip: 0 is the largest, each next one is half as large" },
    { OPT_LAYER, "layer", 0, KIND_INTEGER, "N", NULL, 0, 12287, V_ALL,
      "of a DDS or KTX2 that is an array or a cube map, read this texture, from 0: six faces a "
      "cube. Without it such files are refused" },
    { OPT_HELP, "help", 'h', KIND_FLAG, NULL, NULL, 0, 0, V_ALL, "print this help" },
};
/* clang-format on */
const size_t OPTION_ROWS = sizeof OPTION_TABLE / sizeof OPTION_TABLE[0];

const companion COMPANION_TABLE[COMPANIONS] = {
    { "report", "an HTML page with pictures, SARIF or annotations of a check" },
    { "gltf", "check or clean the normals textures in .gltf and .glb files" },
    { "usd", "check or clean the normals textures of USD scenes" },
};

const option_spec *option_row(option_id id, unsigned verb_bits)
{
    for (size_t i = 0; i < OPTION_ROWS; i++) {
        if (OPTION_TABLE[i].id == id && (OPTION_TABLE[i].verbs & verb_bits) != 0)
            return &OPTION_TABLE[i];
    }
    return NULL;
}
