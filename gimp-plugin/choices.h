/* SPDX-License-Identifier: MIT */
/*
 * choices.h - what the operations and the plug-in offer in menus, declared once
 *
 * Each list calls ROW(identifier, name, label) for its choices, in the order of libntp's own
 * enumeration: GEGL's enum_value makes it a property of the operations, and a row of a table makes
 * it an argument of the plug-in.  Names are those of the command line.  N_() marks labels for
 * translators, who get each label once.
 *
 * Options that both have are named and explained here, too.  An underscore marks the letter for the
 * keyboard in the plug-in's dialog; the operations leave it out.
 */
#ifndef NTP_GIMP_CHOICES_H
#define NTP_GIMP_CHOICES_H

/* clang-format off */

#define NTP_KERNEL_CHOICES(ROW) /* ntp_kernel */ \
    ROW(NTP_OP_CENTRAL, "central", N_("Central difference")) \
    ROW(NTP_OP_FORWARD, "forward", N_("Forward difference")) \
    ROW(NTP_OP_PREWITT3, "prewitt3", N_("Prewitt 3x3")) \
    ROW(NTP_OP_SOBEL3, "sobel3", N_("Sobel 3x3")) \
    ROW(NTP_OP_SCHARR3, "scharr3", N_("Scharr 3x3")) \
    ROW(NTP_OP_PREWITT5, "prewitt5", N_("Prewitt 5x5")) \
    ROW(NTP_OP_SOBEL5, "sobel5", N_("Sobel 5x5")) \
    ROW(NTP_OP_GIMP5, "gimp5", N_("gimp-normalmap 5x5")) \
    ROW(NTP_OP_GIMP7, "gimp7", N_("gimp-normalmap 7x7")) \
    ROW(NTP_OP_GIMP9, "gimp9", N_("gimp-normalmap 9x9"))

#define NTP_BORDER_CHOICES(ROW) /* ntp_border */ \
    ROW(NTP_OP_WRAP, "wrap", N_("Wrap (textures that tile)")) \
    ROW(NTP_OP_CLAMP, "clamp", N_("Clamp")) \
    ROW(NTP_OP_MIRROR, "mirror", N_("Mirror")) \
    ROW(NTP_OP_EXTRAPOLATE, "extrapolate", N_("Extrapolate the height")) \
    ROW(NTP_OP_REPEAT_SLOPE, "repeat-slope", N_("Repeat the slope"))

#define NTP_HEIGHT_SOURCE_CHOICES(ROW) /* ntp_height_source */ \
    ROW(NTP_OP_RED, "red", N_("Red")) \
    ROW(NTP_OP_GREEN, "green", N_("Green")) \
    ROW(NTP_OP_BLUE, "blue", N_("Blue")) \
    ROW(NTP_OP_ALPHA, "alpha", N_("Alpha")) \
    ROW(NTP_OP_LUMA, "luma", N_("Luma (Rec. 709)")) \
    ROW(NTP_OP_LUMA_GIMP, "luma-gimp", N_("Luma (gimp-normalmap)")) \
    ROW(NTP_OP_LUMA_EBERLY, "luma-eberly", N_("Luma (Eberly)")) \
    ROW(NTP_OP_MEAN, "mean", N_("Mean of red, green, blue")) \
    ROW(NTP_OP_MAX, "max", N_("Greatest of red, green, blue")) \
    ROW(NTP_OP_MIN, "min", N_("Least of red, green, blue")) \
    ROW(NTP_OP_SCREEN, "screen", N_("Red, green, blue screened"))

#define NTP_LUMINANCE_CHOICE(ROW) /* by GIMP's color conversion; no ntp_height_source */ \
    ROW(NTP_OP_LUMINANCE, "luminance", N_("Luminance (as GIMP's Normal Map filter)"))

#define NTP_GREEN_CHOICES(ROW) /* ntp_y */ \
    ROW(NTP_OP_UP, "up", N_("Up: OpenGL (Y+)")) \
    ROW(NTP_OP_DOWN, "down", N_("Down: DirectX (Y-)"))

#define NTP_ENCODING_CHOICES(ROW) /* the first three of ntp_encoding */ \
    ROW(NTP_OP_STANDARD, "standard", N_("-1 to 1 (standard)")) \
    ROW(NTP_OP_ZZERO, "zzero", N_("0 to 1 (Z-zero)")) \
    ROW(NTP_OP_XY, "xy", N_("None: red and green only"))

#define NTP_BLUE_CHOICES(ROW) /* ntp_blue */ \
    ROW(NTP_OP_DERIVED, "derived", N_("From red and green")) \
    ROW(NTP_OP_NEAREST, "nearest", N_("Rounded by itself"))

#define NTP_ALPHA_CHOICES(ROW) /* ntp_alpha */ \
    ROW(NTP_OP_KEEP, "keep", N_("Unchanged")) \
    ROW(NTP_OP_ONE, "one", N_("Opaque")) \
    ROW(NTP_OP_INVERSE, "inverse", N_("Inverted")) \
    ROW(NTP_OP_HEIGHT, "height", N_("Height")) \
    ROW(NTP_OP_INVERSE_HEIGHT, "inverse-height", N_("Inverted height"))

#define NTP_CHANNEL_CHOICES(ROW) /* the letters of `ntp from-height --channels`; alpha follows */ \
    ROW(NTP_OP_XYZ, "xyz", N_("Red, green, blue: x, y, z")) \
    ROW(NTP_OP_ZYX, "zyx", N_("Red and blue exchanged: z, y, x")) \
    ROW(NTP_OP_XZY, "xzy", N_("Green and blue exchanged: x, z, y")) \
    ROW(NTP_OP_DXT5NM, "1y0x", N_("DXT5nm: x in alpha, y in green"))

#define NTP_DITHER_CHOICES(ROW) \
    ROW(NTP_OP_NO_DITHER, "none", N_("None")) \
    ROW(NTP_OP_INTEGRABLE, "integrable", N_("Keeps the sums of slopes"))

#define NTP_PRESET_CHOICES(ROW) /* preset of presets.h */ \
    ROW(NTP_OP_NO_PRESET, "none", N_("None: as set below")) \
    ROW(NTP_OP_UNREAL, "unreal", N_("Unreal Engine: green down")) \
    ROW(NTP_OP_UNITY, "unity", N_("Unity: green up")) \
    ROW(NTP_OP_GODOT, "godot", N_("Godot: green up")) \
    ROW(NTP_OP_SOURCE_ENGINE, "source", N_("Source: green down")) \
    ROW(NTP_OP_LABPBR, "labpbr", N_("LabPBR: green down, no z, height in alpha")) \
    ROW(NTP_OP_GIMP, "gimp", N_("As GIMP's Normal Map filter")) \
    ROW(NTP_OP_GIMP_NORMALMAP, "gimp-normalmap", N_("As the old plug-in gimp-normalmap"))

#define NTP_LENGTH_CHOICES(ROW) /* the first two of ntp_clean_method */ \
    ROW(NTP_OP_DERIVE, "derive", N_("Derive blue from red and green")) \
    ROW(NTP_OP_NORMALIZE, "normalize", N_("Normalize what is not of length 1"))

#define NTP_VERDICT_CHOICES(ROW) /* ntp_verdict */ \
    ROW(NTP_OP_NEIGHBOR, "neighbor", N_("More than a level off")) \
    ROW(NTP_OP_ROUNDED, "rounded", N_("Not a rounded unit vector")) \
    ROW(NTP_OP_EXACT, "exact", N_("Blue not the derived one"))

#define NTP_PRESET_LABEL N_("Preset")
#define NTP_PRESET_HELP N_("What an engine reads, or what another program makes. It takes the place of the options that it names; the scale stays yours")
#define NTP_STRENGTH_LABEL N_("Strength")
#define NTP_STRENGTH_HELP N_("Multiplies the slopes. With a scale of 0, one in twenty of the slopes is steeper than 45 degrees at strength 1, whatever the size of the layer")
#define NTP_SCALE_LABEL N_("Sc_ale (0: from the layer)")
#define NTP_SCALE_HELP N_("How many texels white rises above black. 0: as the slopes of the layer suggest; a negative scale inverts the relief")
#define NTP_KERNEL_LABEL N_("_Kernel")
#define NTP_KERNEL_HELP N_("How a slope is taken. A wider kernel is smoother, none is stronger")
#define NTP_SOURCE_LABEL N_("He_ight")
#define NTP_SOURCE_HELP N_("Which number of a pixel is the height. In a gray picture red, green and blue are the gray value")
#define NTP_INVERT_LABEL N_("I_nvert height")
#define NTP_INVERT_HELP N_("Black is high and white is low")
#define NTP_BLUR_LABEL N_("Blur")
#define NTP_BLUR_HELP N_("Blurs the heights first: the standard deviation of the Gaussian, in texels")
#define NTP_SMALL_LABEL N_("Small forms")
#define NTP_SMALL_HELP N_("How much of the finest detail of the heights is used; 1: as it is")
#define NTP_MIDDLE_LABEL N_("Middle forms")
#define NTP_MIDDLE_HELP N_("The same for forms that a blur by 2 texels leaves, and one by 8 does not")
#define NTP_LARGE_LABEL N_("Large forms")
#define NTP_LARGE_HELP N_("The same for forms that a blur by 8 texels leaves")
#define NTP_TO_Y_LABEL N_("_Green points")
#define NTP_TO_Y_HELP N_("Up the picture: OpenGL, glTF, USD, Blender, Unity, Godot. Down: DirectX, Unreal")
#define NTP_BORDER_X_LABEL N_("Le_ft and right edge")
#define NTP_BORDER_X_HELP N_("The height beyond the left and right edge")
#define NTP_BORDER_Y_LABEL N_("_Top and bottom edge")
#define NTP_BORDER_Y_HELP N_("The height beyond the top and bottom edge")
#define NTP_DX_LABEL N_("Spacing _X")
#define NTP_DX_HELP N_("Width of a texel, for textures that are stretched")
#define NTP_DY_LABEL N_("Spacing _Y")
#define NTP_DY_HELP N_("Height of a texel")
#define NTP_MIN_Z_LABEL N_("Minimum _Z")
#define NTP_MIN_Z_HELP N_("Steeper slopes are made this steep")
#define NTP_TO_LABEL N_("Range of bl_ue")
#define NTP_TO_HELP N_("What the blue channel stands for")
#define NTP_OCCLUSION_LABEL N_("Ambient occlusion in blue")
#define NTP_OCCLUSION_HELP N_("How much of an evenly bright sky a texel sees: 1 is open, 0 hidden. For a range of blue of None, as LabPBR has it. The whole layer is made at once")
#define NTP_BLUE_LABEL N_("_Blue")
#define NTP_BLUE_HELP N_("A derived blue survives any conversion")
#define NTP_DITHER_LABEL N_("Dithering")
#define NTP_DITHER_HELP N_("Passes what rounding takes from a slope on to the next texels, so that the heights can be found again. For 8 and 16 bit; blue is then derived")
#define NTP_CHANNELS_LABEL N_("Channels")
#define NTP_CHANNELS_HELP N_("What the channels of the result hold. DXT5nm needs a layer with an alpha channel")
#define NTP_ALPHA_LABEL N_("Al_pha")

#define NTP_REPAIR_LABEL N_("Re_pair")
#define NTP_KEEP_NEGATIVE_Z_LABEL N_("Keep ne_gative Z")
#define NTP_ONLY_FAILING_LABEL N_("Onl_y what fails")
#define NTP_VERDICT_LABEL N_("A te_xel fails if it is")
#define NTP_TOUCH_UNUSED_LABEL N_("Unuse_d texels too")

/* clang-format on */

#endif
