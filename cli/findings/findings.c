/* SPDX-License-Identifier: MIT */
/*
 * findings.c - the table of findings: docs/findings.md and the man page are made from it
 *
 * Ids are never reused or renumbered.
 */
#include "findings/findings.h"

/* clang-format off */
const finding_spec FINDING_TABLE[FINDING_COUNT] = {
    [NT001] = { "NT001", "nt001", "info, warning or error", "normals that are not of unit length",
        "A normal is a direction, so its three components must have length 1. A shader that does not normalize "
        "makes such texels too bright or too dark; one that does turns the error into a wrong angle. A texel counts "
        "when it fails `--verdict`. The level follows the angles, in every format (see [Levels](#levels)): nearly every "
        "texel of a JPEG file fails, and few of these are visibly wrong.",
        "`ntp clean` computes blue from red and green. If the file was JPEG or was resized, it divides "
        "vectors by their length, which changes directions less. Better: export again from the source." },
    [NT002] = { "NT002", "nt002", "info, warning or error", "x and y alone are longer than 1",
        "Red and green already describe a vector longer than 1: no blue can make it a unit vector. A shader that "
        "computes z from x and y takes the square root of a negative number there, which gives black or sparkling "
        "pixels unless the shader clamps. Rounding alone makes steep pairs too long, by less than a level: if there are "
        "only such pairs, the finding is a note. Otherwise only the others count, and [the angles](#levels) decide.",
        "`ntp clean` pulls x and y back to length 1 and keeps their direction." },
    [NT003] = { "NT003", "nt003", "info, warning or error", "z is negative: blue is at or below one half",
        "The normal points away from the viewer, into the surface. glTF says that normal textures should not "
        "contain such normals. The cause is often a baking error, an inverted channel, or Z-zero data read as "
        "standard. The angle is that between the normal and its mirror image above the surface; [the angles](#levels) "
        "decide.",
        "`ntp clean` mirrors z. If the direction is intended, use `--keep-negative-z`." },
    [NT004] = { "NT004", "nt004", "warning", "blue is constant although red and green vary",
        "Blue is the same everywhere, or nearly so near 0 or 255: it was not computed from red and green. Steep texels "
        "are too long or too short.",
        "`ntp convert --type xy --to standard` computes blue. If the texture is meant to hold only x and y, check it "
        "with `--type xy`, or name it so (xy, rg, bc5): then it has NT006." },
    [NT005] = { "NT005", "nt005", "info or warning", "a Z-zero texture",
        "Blue stores z in 0..1, not in -1..1. Engines that expect standard normals read every z too small.",
        "Nothing, if your shader expects it: `--type zzero`, or zzero in the name, makes it a note. Otherwise use "
        "`ntp convert --type zzero --to standard`." },
    [NT006] = { "NT006", "nt006", "info or warning", "an XY-only texture",
        "Only red and green hold a normal. Blue is something else: another map, such as ambient occlusion in LabPBR, or "
        "a z that was lost. Whoever reads it as z sees wrong normals. It is a note where that is meant: the name says so "
        "(xy, rg, bc5), or alpha holds a map as well, as in LabPBR.",
        "Nothing, if your shader computes z: `--type xy` says so. Otherwise use `ntp convert --type xy --to standard`." },
    [NT007] = { "NT007", "nt007", "error", "looks like a height map",
        "The picture is gray: it stores heights (a bump map), not normals.",
        "`ntp from-height --scale 10` makes normals from it, as a surface that rises 10 texels from black to white. Or "
        "name it so that it is not taken for a normals texture." },
    [NT008] = { "NT008", "nt008", "error", "not a normals texture",
        "The colors are not those of normals: a photograph, a color or packed texture, or something else.",
        "Look at the file. If it is a normals texture nevertheless, say so with `--type`." },
    [NT009] = { "NT009", "nt009", "warning", "object-space normals",
        "The normals point in all directions, as in a map that was baked in object or world space. Engines expect "
        "tangent space, where nearly all of them point to the viewer.",
        "Bake in tangent space, or make sure that the material expects object space." },
    [NT010] = { "NT010", "nt010", "warning", "green points the wrong way",
        "The texels look like DirectX (green down) although `--y up` was given, or like OpenGL (green up) although "
        "`--y down` was given. Bumps look like dents when the light comes from above or below. The direction is "
        "detected from the slopes, which are consistent in one of the two ways only; docs/orientation.md explains "
        "how, and how reliable that is. A texture with red inverted looks the same.",
        "`ntp convert --y down --to-y up`, or the other way round. If you know the direction for certain, "
        "ignore this finding." },
    [NT011] = { "NT011", "nt011", "warning", "the name contradicts the required direction of green",
        "The file name says DirectX (green down) although `--y up` was given, or OpenGL (green up) although `--y "
        "down` was given.",
        "If the name is right, `ntp convert --y down --to-y up`, or the other way round, with a new name that does not "
        "contradict. If it is wrong, rename the file." },
    [NT012] = { "NT012", "nt012", "error", "channels are in the wrong places",
        "Z is in red or green, or the texture is packed as DXT5nm (x in alpha, y in green).",
        "`ntp clean` puts them in their places where that is at least 90 % sure, and with `--undo` in any case. For other "
        "orders `ntp convert` takes letters: `ntp convert --from-channels -y-x` reads DXT5nm, `ntp convert "
        "--from-channels zyx` swapped red and blue." },
    [NT013] = { "NT013", "nt013", "error", "x and y are exchanged",
        "In a DDS or KTX2, and elsewhere with `--deep`: the slopes fit a surface when x and y change places, and do not "
        "fit one as they are. The format ATI2 was first written with y before x, and some tools still do so; GPUs read the "
        "first as x. A picture that was rotated by 90 degrees without its normals shows the same. Every normal is turned "
        "then. It is said only where it is sure, which is so in nine of ten exchanged textures: the others show too little "
        "of a surface.",
        "`ntp convert --from-channels yx` makes a standard PNG with x and y in their places. Better: export as BC5 with "
        "the header of DirectX 10, x first; and rotate by `ntp transform --rotate 90`, which turns the normals too." },
    [NT014] = { "NT014", "nt014", "warning", "one of two channels holds nothing",
        "A texture of two channels, such as BC5, has the same number everywhere in one of them, so only x or only y is "
        "there. The cause is a wrong order of channels before compression, such as that of DXT5nm, whose red is 1.",
        "Compress again, x in red and y in green." },
    [NT020] = { "NT020", "nt020", "info", "not bit-exact",
        "Some texels do not have the exact blue that red and green imply. This is harmless, but the file changes "
        "when z is dropped and computed again.",
        "`ntp clean --method derive` makes every texel exact." },
    [NT021] = { "NT021", "nt021", "info", "flat color is not 128, 128, 255",
        "Flat texels have a different color than usual (16 bit: 32768, 32768, 65535), or several colors. There is "
        "no exact zero: 127 and 128 are equally far from it. A mixture is a sign of truncation or dithering.",
        "Nothing, unless flat surfaces must match exactly between textures." },
    [NT022] = { "NT022", "nt022", "warning", "tilted on average",
        "The mean of x or y is far from 0 (`--max-tilt`): the surface as a whole is tilted. Baked maps may be; a "
        "tiling texture should not be.",
        "Look for the cause: a gradient in the source, a wrong tangent space, or an offset in a channel." },
    [NT023] = { "NT023", "nt023", "info", "no surface has these normals",
        "Found with `--deep`: the normals of the best-fitting heights differ by 8 levels or more on average. "
        "Typical causes are normals that were painted, mixed as colors or lossily compressed, and atlases of "
        "separate parts. Such normals are usable for lighting, but heights made from them are only approximate.",
        "Nothing, unless heights are needed. `ntp blend` combines textures so that a surface remains." },
    [NT030] = { "NT030", "nt030", "info", "stored with lossy compression (JPEG, WebP, EXR)",
        "JPEG, WebP with loss, and B44 and DWA of EXR are made for photographs. They change nearly every normal slightly, and steep ones by much.",
        "Export PNG, or WebP without loss, from the source. Cleaning repairs lengths, not lost directions." },
    [NT031] = { "NT031", "nt031", "info or warning", "JPEG or WebP with chroma subsampling",
        "x, y and z were mixed into brightness and color, and the color was stored at half the size: normals are blurred. It is a "
        "warning where NT001 is visible.",
        "Export again as PNG. If it must be JPEG, use 4:4:4; WebP with loss has no such choice." },
    [NT032] = { "NT032", "nt032", "info or warning", "traces of lossy compression in a lossless file",
        "The texels show the 8 x 8 blocks or the noise of JPEG, WebP or GPU compression: the texture was once "
        "stored in such a format. It is a warning where NT001 is visible.",
        "Go back to the source. `ntp clean` repairs the lengths." },
    [NT033] = { "NT033", "nt033", "info", "made from heights with few levels (banding)",
        "Found with `--deep`: slopes are quantized: all of them are whole multiples of one step. Low-bit heights, "
        "such as 8-bit ones, cause this. Smooth slopes become flat terraces with edges between them, visible in "
        "highlights and reflections. It is reported only if it is certain; in a gentle or very smooth texture it "
        "may stay undetected.",
        "Make normals from 16-bit or float heights, or smooth 8-bit heights first. Nothing, if the steps are "
        "intended." },
    [NT034] = { "NT034", "nt034", "info", "16 bit with 8-bit content",
        "Every level is a multiple of 257: an 8-bit texture in a 16-bit file. It is judged as 8 bit.",
        "Export in 16 bit from the source, or use `ntp convert --depth 8` for a file of half the size." },
    [NT035] = { "NT035", "nt035", "info or warning", "resized or blurred without normalizing",
        "Vectors are too short where the surface is curved: neighboring normals were averaged and not normalized "
        "again. It is a warning where NT001 is visible.",
        "`ntp clean`. Better: resize with a tool that normalizes." },
    [NT036] = { "NT036", "nt036", "info", "compressed in blocks",
        "BC1, BC2, BC3 and BC7 share two or a few colors among 16 texels, so lengths are wrong nearly everywhere. "
        "[The angles](#levels) decide whether that is visible, as in JPEG. BC1 rounds to 5 and 6 bits, besides.",
        "Compress x and y as BC5, which has a line of 8 values for each, and let the shader compute z." },
    [NT040] = { "NT040", "nt040", "info or error", "treated as colors",
        "Normals are numbers; a color conversion makes them wrong. gAMA, sRGB, iCCP, cHRM or cICP chunks ask "
        "programs to convert (info). Flat texels near 188 instead of 128 show that it was done: the numbers were "
        "converted from linear to sRGB (error).",
        "`ntp clean` and `ntp convert` leave these chunks out. If numbers were converted, `ntp clean` converts "
        "them back where that is at least 90 % sure, and with `--undo` in any case; levels may then be off by one. "
        "Better: export again with color management off." },
    [NT041] = { "NT041", "nt041", "info", "an alpha channel that is opaque everywhere",
        "It holds no information and costs a quarter of the memory. glTF says that normal textures should not have "
        "one.",
        "`ntp convert --channels xyz` drops it." },
    [NT042] = { "NT042", "nt042", "info", "unused texels",
        "Pure black, pure white or transparent texels hold no normal; they are padding in atlases. They are left "
        "alone and not judged.",
        "Nothing, if no triangle uses them. But mipmaps blend them into their neighbors." },
    [NT044] = { "NT044", "nt044", "info", "padding of a color that no normal has",
        "One color with red and green both near 0 or 255 covers a 64th of the picture or more: too long for any normal, "
        "whatever blue is. Flipping green makes it of black padding, and JPEG of black and white. It is padding, so it "
        "does not count as an error: shares, angles and the tilt are those of the other texels. Unlike black and white, "
        "it is changed by `ntp clean`, as any used texel.",
        "Nothing, if no triangle uses it. But mipmaps blend it into its neighbors, and so does JPEG: export again with "
        "flat normals (128, 128, 255) around the charts." },
    [NT045] = { "NT045", "nt045", "warning", "marked sRGB in a DDS or KTX2",
        "A GPU that reads a format of sRGB converts each number to linear light: 128 becomes 55, and flat ground is "
        "tilted by 40 degrees. Some engines replace the format by the plain one, others do not.",
        "Export again with a plain (UNORM, linear) format: of normals, never one of sRGB." },
    [NT050] = { "NT050", "nt050", "info or warning", "one color, or nothing",
        "All used texels are equal: a placeholder, or an export that went wrong. If all texels are black, white or "
        "transparent, there is no normal at all: a warning.",
        "Nothing, if it is intended. A 1 x 1 texture has the same effect." },
    [NT051] = { "NT051", "nt051", "info", "sides are not powers of two",
        "Some engines and devices resize such textures, or make no mipmaps for them.",
        "Nothing, unless your target requires it." },
    [NT052] = { "NT052", "nt052", "info", "opposite edges do not fit together",
        "Found with `--deep`: if the texture is repeated, a seam is visible. In most rows or columns the step "
        "across the seam is the largest one, and the heights at the two edges differ.",
        "Nothing, unless it should tile. It may have been cropped, or resized without wrapping around." },
    [NT053] = { "NT053", "nt053", "info", "no mips",
        "A DDS or KTX2 with a single level: an engine that does not make the others itself shows noise and moire from "
        "afar, and reads more memory.",
        "`ntp resize --mips` makes the levels, each normalized; build the DDS or KTX2 of them." },
    [NT054] = { "NT054", "nt054", "info or warning", "mips are not normalized",
        "In a DDS or KTX2 of two channels: the mips are plain means of x and of y. The mean of vectors is to be made a unit "
        "vector again, else the z that a shader computes is too large, and rough surfaces become smooth from afar. It is a "
        "warning where that is more than a fifth of `--max-angle` on average.",
        "Make the levels by `ntp resize --mips`, which normalizes, and build the DDS or KTX2 of them." },
};
/* clang-format on */

const char *level_name(finding_level level)
{
    return level == LEVEL_ERROR ? "error" : level == LEVEL_WARNING ? "warning" : "info";
}
