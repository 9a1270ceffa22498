/* SPDX-License-Identifier: MIT */
/*
 * findings.c - the table of findings: docs/findings.md and the man page are made from it
 *
 * Ids are never reused or renumbered.
 */
#include "findings/findings.h"

/* clang-format off */
const finding_spec FINDING_TABLE[FINDING_COUNT] = {
    [NT001] = { "NT001", "nt001", "warning or error", "normals that are not of unit length",
        "A normal is a direction, so its three components must have length 1. A shader that does not normalize "
        "lights such texels too bright or too dark; one that does turns the error into a wrong angle. A texel counts "
        "when it fails `--verdict`. It is a warning as long as at most `--max-fail` percent of the used texels fail, "
        "an error above. JPEG files cannot pass a test of single texels; for them the angle decides: over 10 degrees "
        "at the 99th percentile is an error, over 2 degrees on average a warning.",
        "`ntp clean` computes blue from red and green. Where the file was JPEG or was resized, `--method normalize` or "
        "`auto` loses less. Better: export again from the source." },
    [NT002] = { "NT002", "nt002", "warning or error", "x and y alone are longer than 1",
        "Red and green already describe a vector longer than 1: no blue can make it a unit vector. A shader that "
        "computes z from x and y takes the square root of a negative number there: black or sparkling pixels. An error "
        "above `--max-fail` percent of the used texels, else a warning.",
        "`ntp clean` pulls x and y back to length 1 and keeps their direction." },
    [NT003] = { "NT003", "nt003", "warning or error", "z is negative: blue is at or below one half",
        "The normal points away from the viewer, into the surface. glTF says that normal textures should not contain "
        "it. Often a baking error, an inverted channel, or Z-zero data read as standard. An error above `--max-fail` "
        "percent of the used texels, else a warning.",
        "`ntp clean` mirrors z. Where the direction is meant, use `--keep-negative-z`." },
    [NT004] = { "NT004", "nt004", "warning", "blue is constant although red and green vary",
        "Blue is the same everywhere: it was filled in, not computed. Steep texels are too long or too short.",
        "`ntp clean` computes blue. If the texture is meant to hold only x and y, check it with `--type xy`." },
    [NT005] = { "NT005", "nt005", "info", "a Z-zero texture",
        "Blue stores z in 0..1, not in -1..1. Engines that expect standard normals read every z too small.",
        "Fine if your shader expects it (`--type zzero`); otherwise `ntp convert --from zzero`." },
    [NT006] = { "NT006", "nt006", "info", "an XY-only texture",
        "Only red and green hold a normal; blue is constant or something else, such as ambient occlusion in LabPBR.",
        "Fine if your shader computes z (`--type xy`); otherwise `ntp convert --from xy`." },
    [NT007] = { "NT007", "nt007", "error", "looks like a height map",
        "The picture is gray: it stores heights (a bump map), not normals.",
        "Make normals from it, or name it so that it is not taken for a normals texture." },
    [NT008] = { "NT008", "nt008", "error", "no normals texture",
        "The colors are not those of normals: a photograph, a color or packed texture, or something else.",
        "Look at the file. If it is a normals texture all the same, say so with `--type`." },
    [NT009] = { "NT009", "nt009", "warning", "object-space normals",
        "The normals point in all directions, as in a map that was baked in object or world space. Engines expect "
        "tangent space, where nearly all of them point to the viewer.",
        "Bake in tangent space, or make sure that the material expects object space." },
    [NT010] = { "NT010", "nt010", "warning", "green points the wrong way",
        "The texels look like DirectX (green down) where `--y up` is asked for, or like OpenGL (green up) where "
        "`--y down` is. Bumps look like dents when the light comes from above or below. It is found from the slopes, "
        "which fit together in one of the two ways only; docs/orientation.md tells how, and how sure that is. A texture "
        "with red inverted gives the same picture.",
        "`ntp convert --from-y down --to-y up`, or the other way round. If you know better, go by what you know." },
    [NT011] = { "NT011", "nt011", "warning", "the name contradicts the required direction of green",
        "The name says DirectX (green down) where `--y up` is asked for, or OpenGL where `--y down` is.",
        "`ntp convert --from-y down --to-y up`, or the other way round." },
    [NT012] = { "NT012", "nt012", "error", "channels are in the wrong places",
        "Z is in red or green, or the texture is packed as DXT5nm (x in alpha, y in green).",
        "`ntp convert --from-channels` puts them right, for example `-y-x` for DXT5nm, `zyx` for swapped red and blue." },
    [NT020] = { "NT020", "nt020", "info", "not bit-exact",
        "Some blues are not the one that red and green imply. Harmless, but the file changes when z is dropped and "
        "computed again.",
        "`ntp clean` makes every texel exact." },
    [NT021] = { "NT021", "nt021", "info", "flat color is not 128, 128, 255",
        "Flat texels have another color than the usual one (16 bit: 32768, 32768, 65535), or several. There is no "
        "exact zero: 127 and 128 are equally far from it. Mixtures are a sign of truncation or dithering.",
        "Nothing, unless flat surfaces must match exactly between textures." },
    [NT022] = { "NT022", "nt022", "warning", "tilted on average",
        "The mean of x or y is far from 0 (`--max-tilt`): the surface as a whole leans. Baked maps may do so; "
        "a tiling texture should not.",
        "Check how it was made: a gradient in the source, a wrong tangent space, an offset in a channel." },
    [NT023] = { "NT023", "nt023", "info", "no surface has these normals",
        "Found with `--deep`: even the heights that fit best have other normals, by 8 levels and more on average. "
        "So it is with normals that were painted, mixed as colors, or lossily compressed, and with atlases of separate parts. "
        "They light well; heights made of them are rough guesses.",
        "Nothing, unless heights are needed. `ntp blend` mixes textures so that a surface remains." },
    [NT030] = { "NT030", "nt030", "info", "stored with lossy compression (JPEG)",
        "JPEG is made for photographs. It changes nearly every normal a little and steep ones a lot.",
        "Export PNG from the source. Cleaning repairs lengths, not lost directions." },
    [NT031] = { "NT031", "nt031", "warning", "JPEG with chroma subsampling",
        "x, y and z were mixed into brightness and color, and the color was stored at half the size: normals are blurred.",
        "Export again as PNG, or as JPEG with 4:4:4 if it must be." },
    [NT032] = { "NT032", "nt032", "warning", "marks of lossy compression in a lossless file",
        "The texels show the 8 x 8 blocks or the noise of JPEG, WebP or GPU compression: it was stored so once.",
        "Go back to the source. `ntp clean --method auto` repairs the lengths." },
    [NT033] = { "NT033", "nt033", "info", "made from heights with few levels (banding)",
        "Found with `--deep`: slopes come in steps, all of them whole multiples of one. So do those of an 8-bit "
        "heightfield: what should be a smooth slope is flat terraces with edges between, which show in highlights and "
        "reflections. It is told only where it is sure; a gentle or very smooth texture may have such steps unnoticed.",
        "Bake from heights of 16 bit or float; smooth 8-bit heights before normals are made of them. Nothing, where "
        "steps are meant." },
    [NT034] = { "NT034", "nt034", "info", "16 bit with 8-bit content",
        "Every level is a multiple of 257: an 8-bit texture in a 16-bit file. It is judged as 8 bit.",
        "Export in 16 bit from the source, or save half the size with `ntp convert --depth 8`." },
    [NT035] = { "NT035", "nt035", "warning", "resized or blurred without normalizing",
        "Vectors are too short where the surface bends: neighboring normals were averaged and not made unit vectors again.",
        "`ntp clean --method auto`. Better: resize with a tool that normalizes." },
    [NT040] = { "NT040", "nt040", "info or error", "taken for colors",
        "Normals are numbers; converted as colors are, they are wrong. gAMA, sRGB, iCCP or cHRM chunks ask programs to "
        "do so (info). Flat texels near 188 instead of 128 show that it was done: the numbers went through a conversion "
        "from linear to sRGB (error).",
        "`ntp clean` and `ntp convert` leave these chunks out. Converted numbers: export again with color management "
        "off; the rounding cannot be undone fully." },
    [NT041] = { "NT041", "nt041", "info", "an alpha channel that is opaque everywhere",
        "It holds nothing and costs a quarter of the memory. glTF says that normal textures should not have one.",
        "`ntp convert --channels xyz` drops it." },
    [NT042] = { "NT042", "nt042", "info", "unused texels",
        "Pure black, pure white or transparent texels hold no normal; atlases are padded so. They are left alone and "
        "not judged.",
        "Nothing, if no triangle uses them. Mipmaps blend them into their neighbors." },
    [NT050] = { "NT050", "nt050", "info", "one color",
        "All used texels are equal: a placeholder, or an export that went wrong.",
        "Nothing, if it is meant. A 1 x 1 texture does the same." },
    [NT051] = { "NT051", "nt051", "info", "sides are not powers of two",
        "Some engines and devices resize such textures, or make no mipmaps for them.",
        "Nothing, unless your target asks for it." },
    [NT052] = { "NT052", "nt052", "info", "opposite edges do not fit together",
        "Found with `--deep`: repeated beside itself, the texture shows a seam. In most "
        "lines the step across it is the largest of all, and the heights at the two edges differ.",
        "Nothing, unless it is meant to tile. It may have been cut, or resized without wrapping around." },
};
/* clang-format on */

const char *level_name(finding_level level)
{
    return level == LEVEL_ERROR ? "error" : level == LEVEL_WARNING ? "warning" : "info";
}
