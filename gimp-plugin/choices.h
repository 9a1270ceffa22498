/* SPDX-License-Identifier: MIT */
/*
 * choices.h - what the operations and the plug-in offer in menus, declared once
 *
 * Each list calls ROW(identifier, name, label) for its choices, in the order of libntp's own
 * enumeration: GEGL's enum_value makes it a property of the operations, and a row of a table makes
 * it an argument of the plug-in.  Names are those of the command line.  N_() marks labels for
 * translators, who get each label once.
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

#define NTP_LENGTH_CHOICES(ROW) /* the first two of ntp_clean_method */ \
    ROW(NTP_OP_DERIVE, "derive", N_("Derive blue from red and green")) \
    ROW(NTP_OP_NORMALIZE, "normalize", N_("Normalize what is not of length 1"))

#define NTP_VERDICT_CHOICES(ROW) /* ntp_verdict */ \
    ROW(NTP_OP_NEIGHBOR, "neighbor", N_("More than a level off")) \
    ROW(NTP_OP_ROUNDED, "rounded", N_("Not a rounded unit vector")) \
    ROW(NTP_OP_EXACT, "exact", N_("Blue not the derived one"))

/* clang-format on */

#endif
