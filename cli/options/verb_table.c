/* SPDX-License-Identifier: MIT */
/*
 * verb_table.c - the table of verbs: what each does, in a line and at length, with examples
 */
#include "options/options.h"

const verb_spec VERB_TABLE[] = {
    { "check", "PATH...", "say what textures are, and whether they are well formed",
      "Reads each texture and says what it is (standard, Z-zero or XY-only normals, a height "
      "map, object-space normals, one color, or not a normals texture). It says whether the "
      "normals are well formed and, if not, why and by how much. Nothing is written.\n"
      "Files that are named are always judged. In a directory a file is judged if its name is "
      "that of a normals texture (brick_n.png, brick_normal.png, BrickNormalGL.png ...) or its "
      "content is. Other images are listed and are not findings.",
      "ntp check wall_n.png\n"
      "  is this texture correct?\n"
      "ntp check -r textures --fail-on warning\n"
      "  check a whole tree and let a build fail\n"
      "ntp check -r textures --format list -0 | xargs -0 ls -l\n"
      "  the files with errors, for another program\n"
      "ntp check -r textures --format json > before.json\n"
      "ntp check -r textures --baseline before.json\n"
      "  later: count only new findings\n" },
    { "clean", "PATH...", "repair normals",
      "Makes every texel of a normals texture a unit vector. Where blue alone is wrong, red and "
      "green stay and blue is computed from them; where red and green alone are longer than 1, "
      "they are shortened to length 1 and keep their direction. Where all three channels are off, "
      "as after JPEG or resizing, each vector is divided by its length (--method). Alpha, and "
      "texels that are pure black, pure white or transparent, stay as they are. Cleaning again "
      "changes nothing.\n"
      "Exchanged channels, DXT5nm, inverted blue and numbers converted to sRGB are undone first "
      "where that is sure; else such files are refused (--undo).\n"
      "Heights, object-space maps and other images are refused unless --type says what they "
      "are. gAMA, sRGB, iCCP and cHRM chunks are left out: normals are numbers, not colors.",
      "ntp clean wall_n.png -o wall_clean_n.png\n"
      "  write a repaired copy\n"
      "ntp clean -r textures --in-place --dry-run\n"
      "  what would change, and by how many degrees?\n"
      "ntp clean -r textures --in-place\n"
      "  repair a tree; correct files are not touched\n"
      "ntp clean scan.jpg -o scan_n.png\n"
      "  repair a texture that was stored as JPEG\n"
      "ntp clean wall_n.png -o exact_n.png --method derive\n"
      "  make blue exactly what red and green imply\n" },
    { "convert", "PATH...", "change encoding, depth, channels, or the direction of green",
      "Converts between standard, Z-zero and XY-only textures, 8 and 16 bit, green up (OpenGL) "
      "and green down (DirectX), and rearranges channels. Nothing is repaired: each number is "
      "converted by value, correctly rounded. A clean texture stays clean. Unused texels keep "
      "their color.",
      "ntp convert wall.png -o wall_gl.png --to-y opengl\n"
      "  to OpenGL, whatever it was\n"
      "ntp convert -r textures --to-y opengl --in-place\n"
      "  the same of a tree; files that do not show it are named, and left alone\n"
      "ntp convert wall_n.png -o wall_gl.png --y directx --to-y opengl\n"
      "  a file that does not show which way green points\n"
      "ntp convert wall_n.png -o wall_n.dds --mips\n"
      "  BC5 with all mips, for games; .ktx2 likewise\n"
      "ntp convert wall_n.png -o wall16.png --depth 16\n"
      "  8 bit to 16 bit\n"
      "ntp convert labpbr_n.png -o full_n.png --type xy\n"
      "  compute the missing blue\n"
      "ntp convert packed.png -o plain.png --from-channels -y-x\n"
      "  unpack DXT5nm\n" },
    { "heatmap", "PATH...", "show in a picture which texels are wrong",
      "Writes a picture of each texture in which wrong texels are colored and the others are "
      "gray. Red: x and y too long. Green: wrong length. Blue: negative z. docs/heatmap.md is "
      "the legend.",
      "ntp heatmap wall_n.png -o wall_faults.png\n"
      "ntp heatmap -r textures -o faults --palette safe\n"
      "  heatmaps of a tree, in colors that everybody can tell apart\n" },
    { "dump", "PATH", "list texels as CSV",
      "Prints a row for each texel that fails --verdict, or for every texel with --all: "
      "position, stored levels, vector, length, flags, size of the error, and repaired levels.",
      "ntp dump wall_n.png | head\n"
      "  the first bad texels\n"
      "ntp dump --all tiny_n.png > tiny.csv\n" },
    { "diff", "A B", "compare two textures in levels and degrees",
      "Says how many texels of two textures of the same size differ, by how many levels, and by "
      "what angle. Depth and encoding may differ; B is converted to those of A. If one is a DDS "
      "or KTX2, x and y are compared as the vectors that a shader makes of them, and each of its "
      "mips with the right one; the ten worst blocks are listed. The exit code is 0 if they are "
      "the same, and 1 if they differ.",
      "ntp diff wall_n.png wall_clean_n.png\n"
      "ntp diff a.png b.png -o where.png\n"
      "  a picture of the differences\n"
      "ntp diff wall_n.png wall_n.dds --fail-over 1\n"
      "  what compression costs, in degrees\n" },
    { "from-height", "PATH...", "make normals from heights",
      "Turns heightfields (bump maps: white is high) into normals textures. Red and green are "
      "the correctly rounded values of the formula; blue is computed from them. Input may be 8 "
      "or 16 bit, gray or color, and PFM.\n"
      "With --border-y wrap, the default, and with --blur or --octaves, the heightfield is held "
      "in memory; otherwise only a few rows are.",
      "ntp from-height wall_height.png -o wall_n.png --scale 8\n"
      "  white is 8 texels above black\n"
      "ntp from-height rock.png -o rock_n.png --scale 20 --kernel sobel3 --to-y down --depth "
      "16\n"
      "  smoother, for DirectX, in 16 bit\n"
      "ntp from-height bump.png -o bump_n.png --like gimp-normalmap:sobel3:1\n"
      "  as the old GIMP plug-in, but correctly rounded\n"
      "ntp from-height h.png -o labpbr_n.png --scale 4 --to xy --ao ao.png --alpha height\n"
      "  a LabPBR texture\n" },
    { "transform", "PATH...", "flip, turn, make stronger or weaker",
      "Flips and turns textures, pixels and vectors together, so that bumps stay bumps, and "
      "multiplies their slopes. Flips and turns by multiples of 90 degrees are exact. With "
      "--strength or another angle each normal is correctly rounded. Texels that are pure black, "
      "pure white or transparent move but keep "
      "their color.\n"
      "An image that does not hold tangent-space normals is refused unless --type says what it "
      "is. The image is held in memory.",
      "ntp transform wall_n.png -o strong_n.png --strength 2\n"
      "  bumps twice as high\n"
      "ntp transform wall_n.png -o turned_n.png --rotate 90\n"
      "ntp transform decal_n.png -o tilted_n.png --rotate 12.5 --border clamp\n"
      "  by any angle, clockwise\n"
      "ntp transform left_n.png -o right_n.png --flip x\n"
      "  the mirror image of a texture\n" },
    { "resize", "PATH...", "change the size, or make a mip chain, of unit vectors",
      "Resizes textures as vectors, weighted with alpha, and stores unit vectors again: the "
      "result passes ntp check --verdict exact. Unused texels (pure black, pure white, "
      "transparent) do not bleed into others; where there are only unused texels, the result is "
      "flat, with alpha 0.\n"
      "An image that does not hold tangent-space normals is refused unless --type says what it "
      "is. The image is held in memory.",
      "ntp resize wall_n.png -o small_n.png --size 50%\n"
      "ntp resize wall_n.png -o wall_1k_n.png --size 1024x1024 --filter lanczos3\n"
      "ntp resize wall_n.png -o mips/wall_n.png --mips\n"
      "  mips/wall_n.png, mips/wall_n_mip1.png, mips/wall_n_mip2.png ...\n"
      "ntp resize decal_n.png -o decal_half_n.png --size 50% --border clamp\n"
      "  a texture that does not tile\n" },
    { "blend", "BASE DETAIL", "add the bumps of one texture to another",
      "Adds the bumps of DETAIL to BASE. A smaller DETAIL is repeated. Size, depth, encoding "
      "and alpha are those of BASE. Texels that are unused in either stay as they are in BASE.",
      "ntp blend wall_n.png scratches_n.png -o worn_n.png\n"
      "ntp blend wall_n.png grain_n.png -o grainy_n.png --strength 0.5\n"
      "  the detail half as high\n"
      "ntp blend wall_gl.png scratches_dx.png -o worn_gl.png --detail-y down\n" },
    { "to-height", "PATH...", "make heights from normals",
      "Reconstructs the heightfield of a normals texture: the heights whose slopes are closest "
      "to the stored ones. Writes a 16-bit gray PNG, or floats (PFM). The scale, by which white "
      "is higher than black, is printed and stored in the PNG: ntp from-height with this "
      "--scale, kernel and border makes the same normals again.\n"
      "What the texture does not say (which way green points, whether it tiles, how it was "
      "made) is detected from its texels if possible, and printed; options override it. An "
      "image that does not hold tangent-space normals is refused unless --type says what it is. "
      "The image is held in memory: its samples, and 4 bytes a texel; 40 more with --method "
      "weighted.",
      "ntp to-height wall_n.png -o wall_height.png\n"
      "ntp to-height wall_n.png -o wall_height.png --border wrap --y down\n"
      "  a texture that tiles, for DirectX\n"
      "ntp to-height decal_n.png -o decal_height.png --mask decal_mask.png\n"
      "  no surface where the mask is black\n"
      "ntp to-height wall_n.png -o wall_height.pfm\n"
      "  floats, in texels\n" },
    { "curvature", "PATH...", "make a curvature or cavity map",
      "Shows how much the surface bends: convex edges bright, concave grooves dark, flat ground "
      "gray; or only one of them (--kind). Input is a normals texture or a heightfield; of normals "
      "no heights are needed. docs/relief-maps.md has the formulas. The image is held in memory.",
      "ntp curvature wall_n.png -o wall_curvature.png\n"
      "ntp curvature wall_n.png -o wall_cavity.png --kind cavity --blur 1\n"
      "  dark where grooves are, without the finest noise\n"
      "ntp curvature wall_height.png -o wall_curvature.png --scale 8 --range 0.25\n"
      "  from heights; an edge of radius 4 texels is white\n" },
    { "occlusion", "PATH...", "make an ambient occlusion map",
      "Computes how much of an evenly bright sky each texel sees: white where nothing is in the "
      "way, dark in pits and grooves. Input is a heightfield or a normals texture, of which the "
      "heights are reconstructed first, as by ntp to-height. docs/relief-maps.md has the formulas. "
      "The image is held in memory.",
      "ntp occlusion wall_height.png -o wall_ao.png --scale 8\n"
      "  white is 8 texels above black\n"
      "ntp occlusion wall_n.png -o wall_ao.png\n"
      "ntp occlusion decal_n.png -o decal_ao.png --border clamp --radius 32\n"
      "  a texture that does not tile; only what is near hides\n" },
    { "to-depth", "PATH...", "find the depth of an object from its normals",
      "Finds how far away each texel of an object is, from normals as photometric stereo measures "
      "them: with the perspective of a camera, and with cliffs where one part hides another. "
      "Textures are for ntp to-height. Normals do not tell how far away the object is: without "
      "--camera depth is in texels, with mean 0; with it, only ratios of depth are known, and the "
      "mean of its logarithm is 0. Unused and masked texels, and gray ones without a direction, "
      "have no depth.\n"
      "Depth is offset + scale * (c - 1)/65534 for a level c; both are printed, and stored in the "
      "PNG. docs/depth.md says how it works. The image is held in memory, with about 300 bytes a "
      "texel.",
      "ntp to-depth bear_normals.png -o bear_depth.png --mask bear_mask.png\n"
      "ntp to-depth bear_normals.png -o bear.pfm --camera 3772,3760,305,256\n"
      "ntp to-depth vase_n.png -o vase_depth.png --confidence vase_sure.png\n" },
};
const size_t VERB_ROWS = sizeof VERB_TABLE / sizeof VERB_TABLE[0];
