/* SPDX-License-Identifier: MIT */
/* thresholds.h - the thresholds of classify.c and choose_method.c, each with its reason */
#ifndef NTP_THRESHOLDS_H
#define NTP_THRESHOLDS_H

/* Block compression tints grays: its ends have 5 and 6 bits, so channels differ by up to 4 levels,
 * 3 as root mean square.  Brightness has to vary by more than that. */
static const double TINT = 4.0 / 255, TINTED_SURE = 0.85, TINTED_VARIES = 3;

/* Gray images: compression and palettes leave a few texels that are not quite gray. */
static const double GRAY_SHARE = 0.98;
static const double GRAY_SURE = 0.97, NEARLY_GRAY_SURE = 0.88;

/* A gray file is a height unless it holds something else by mistake.  An image that was only
 * described, not judged, may be anything. */
static const double GRAY_FILE_SURE = 0.99, NOT_ASKED_SURE = 0.5;

/* Shares of texels with unit length.  Encoders that round correctly reach a share of 1 with
 * NTP_VERDICT_NEIGHBOR; 3 % of bad texels must not matter.  Even JPEG and resizing rarely put more
 * than a tenth of the texels off by over 1/8.  The colors of a picture rarely leave more than half
 * of them within 1/8. */
static const double ROUNDED_ALL = 0.995, ROUNDED_SHARE = 0.96, UNIT_SHARE = 0.93,
                    NEAR_UNIT_SHARE = 0.88;

/* A tight fit may come from flat texels only: few of the tilted ones fit.  Where blue does not even
 * follow red and green (correlation), such a fit counts for nothing.  A sure fit has three quarters
 * of the tilted texels: 3 % of wrong blues take few away, and a blue that is bright everywhere fits
 * half at most.  Where fewer than 64 are tilted, nearly all texels have to fit instead. */
static const double TILTED_LEAST = 0.01, TILTED_NEAR_LEAST = 0.3, BLUE_FOLLOWS = 0.3;
static const double TILTED_NEAR_SURE = 0.75, UNIT_FLAT_SURE = 0.98;

/* Damaged normals: lengths spread by 0.06 at most, or somewhat more where blue still follows red
 * and green.  With heights, occlusion and pictures in blue, lengths spread by 0.1 and more, and
 * blue does not follow.  Damaged normals still point up, while a height or an occlusion has blues
 * below the middle.  Blurring and scaling leave three quarters of the length; faulty generators add
 * up to 15 %. */
static const double SPREAD_MOST = 0.06, SPREAD_FOLLOWING = 0.18, NEGATIVE_DAMAGED = 0.003;
static const double LENGTH_LEAST = 0.75, LENGTH_MOST = 1.15;

/*
 * Flat texels fit any bright blue, and an occlusion or a height in blue may well fit gentle slopes
 * too.  So lengths near 1 are sure only where enough texels slope and one of two things shows that
 * blue is z.  One: blue rises and falls with the derived blue, by as much.  A blue that is not z
 * hardly reaches a correlation of 0.85, and rarely that slope.  Two: blue rises and falls with the
 * derived blue at all, and lengths are close together, on slopes as well.  A blue that is not z
 * spreads them half as far again.  A correlation of 0.95 is proof, however short or long the
 * vectors are.
 */
static const double Z_FOLLOWS = 0.9, Z_FOLLOWS_CLOSELY = 0.95, Z_SLOPE_OFF = 0.3;
static const double KEPT_SPREAD = 0.03, KEPT_SLOPING_ERROR = 0.05;
static const double LOOSE_SURE = 0.93, UNSEEN_SURE = 0.85;

/* Coarse JPEG of rough surfaces spreads lengths as widely as a height in blue does.  But a blue that
 * still rises and falls by as much as z, at this correlation, is hardly anything else. */
static const double Z_FOLLOWS_ROUGHLY = 0.75, ROUGHLY_SURE = 0.75;

/* Sharpening lengthens steep normals, and some generators clip x and y that they never divide by the
 * length.  Where blue follows z like that, a fifth of x, y may be too long. */
static const double TOO_LONG_ROUGHLY = 0.2;

/* How sure lengths make it: surer the more of them are near 1 (fully a tenth above the share that
 * it takes), less sure the more they spread.  A fit to the level is sure unless it comes from flat
 * texels only. */
static const double TIGHT_SURE = 0.97, NEAR_SURE = 0.8, NEAR_UNIT_RANGE = 0.1;
static const double SPREAD_SURE = 0.6, FLAT_ONLY_SURE = 0.8;
enum { SLOPING_TEXELS_LEAST = 64 };

/* A blue that reaches both ends fits where it is 0 and where it is M.  With more negative z than a
 * few wrong texels make, it may be a height as well. */
static const double NEGATIVE_MOST = 0.05, NEGATIVE_SURE = 0.8;

/* The lean: how far the mean of (x, y) lies off the middle.  As a rule it is below 0.1 in
 * tangent-space textures, and 0.3 on a slope.  Red and green of a picture are rarely both that near
 * the middle. */
static const double LEAN_SMALL = 0.03, LEAN_SLANTED = 0.1, LEAN_CENTERED = 0.15, LEAN_MOST = 0.3;

/* The share of x, y that are too long.  JPEG and filters that overshoot make some; a texture with
 * more holds no x, y. */
static const double TOO_LONG_SHARE = 0.08;

/* If colors are spread evenly over the disc, three quarters of them are steeper than 1/2 and a
 * sixteenth is flatter than 1/4.  Normals crowd in the middle; where they do not, little is sure.
 * Of noise with slopes of 3 nearly nine tenths are steeper than 1/2. */
static const double STEEP_MOST = 0.9, MIDDLE_LEAST = 0.1;

/* Padding may have another color than black or white, such as gray, or the green that a flip makes
 * of black.  Then it is flat in red and green, or too long.  Where this share of the tilted texels
 * has the blue of a normal, and the gap shows that no constant blue would fit, the rest is taken
 * for padding.  Pale pictures have a few such texels too, but hardly a unit vector. */
static const double PADDED_NEAR = 0.75, PADDED_GAP = 3, PADDED_UNIT = 0.1;
static const double PADDED_LEAST_SURE = 0.7, PADDED_SURE = 0.85, PADDED_RANGE = 0.15;
enum { PADDED_TEXELS_LEAST = 64 };

/* Object space: all three axes have both signs.  3 % of wrong blues are 1.5 % negative ones.  Where
 * the signs are well mixed, a smaller share of unit lengths is enough, as compression at the
 * borders of charts takes some. */
static const double DIRECTIONS_LEAST = 0.05, AXIS_LEAST = 0.02;
static const double MIXED_LEAST = 0.15, MIXED_UNIT_SHARE = 0.8;

/* The normals of a closed body cancel out, and those of half a ball leave a mean of length 1/2.  The
 * mean of a picture with a background of one color is nearly as long as that color. */
static const double ONE_WAY_MOST = 0.7;

/* Seven eighths of a ball are steeper than 1/2, and two thirds of a cube.  Hills and ridges with a
 * height in blue may seem to point in all directions too.  They mostly have fewer steep texels, or
 * their red and green keep to a line. */
static const double BODY_STEEP_LEAST = 0.4;

/* Unit vectors to the level with well mixed signs are hardly anything else. */
static const double OBJECT_SURE = 0.96, OBJECT_LOOSE_SURE = 0.8;

/* Where red and green are flat, blue 0 and blue 255 give unit length, whatever blue means.  So the
 * tilted texels (steepness 1/4 to 7/8) of an object-space texture must be near unit length by
 * themselves.  On boxes hardly any texels are tilted but those at the borders of charts, and there
 * JPEG puts lengths off by up to 0.15. */
static const double TILTED_ERROR_MOST = 0.16;
enum { TILTED_FIRST_BIN = 2, TILTED_END_BIN = 7 };

/* Where z is flipped, or another channel is z, (almost) all texels agree. */
static const double FLIPPED_SHARE = 0.95, OTHER_Z_SHARE = 0.98, OTHER_Z_MEAN = 0.8;

/* Another channel is z only if it falls as far as the other two need: half the mean of their
 * squares, or up to twice that where they are steep.  A channel that is M throughout does not.  On
 * gentle ground rounding may take up to half a level from the fall, in vectors that is 1/255. */
static const double OTHER_Z_FALLS = 0.4, OTHER_Z_ROUNDING = 1.0 / 255;

/* Colors of a picture may have this mean too.  Unit vectors to the level that do not keep to a line
 * do not come by chance. */
static const double SWAPPED_SURE = 0.92, SWAPPED_LOOSE_SURE = 0.75;

/* The mean of a channel that holds x or y lies so near the middle, in levels / M.  An alpha that
 * holds x is rarely 0 or M; a mask is little else. */
static const double MIDDLE = 0.15, ALPHA_ENDS_MOST = 0.05;

/* Two channels are x and y by their number alone.  A lean can come from a slope, but hardly from
 * one so steep. */
static const double PAIR_SURE = 0.95, PAIR_LEANING_SURE = 0.6, PAIR_TOO_LONG_SURE = 0.8;

/* Red and blue of DXT5nm are constant but for block compression, and near 0 or M, as no x is.
 * Where they repeat green, it may be a gray picture whose alpha lies around the middle by
 * chance. */
static const double IDLE_DEVIATION = 0.02, IDLE_OFF_MIDDLE = 0.35;
static const double DXT5NM_SURE = 0.95, DXT5NM_GRAY_SURE = 0.85;

/* Stored as sRGB, flat is 188/255 = 0.737, and slopes of 1 move the means of red and green by less
 * than this.  The mean of blue is above theirs by 0.2 and more; a gray of 230 has unit length
 * too. */
static const double GAMMA_FLAT = 0.737, GAMMA_SPREAD = 0.12, GAMMA_SHARE = 0.85, GAMMA_RISE = 0.1;

/* Decoding has to bring a tenth of the lengths near to 1.  Flat texels at 188 are proof; with fewer
 * of them it may be any bright picture. */
static const double GAMMA_GAIN = 0.1, GAMMA_FLAT_SHARE = 0.02;
static const double GAMMA_SURE = 0.93, GAMMA_UNSEEN_SURE = 0.8;

/* A channel that does not vary: its standard deviation is an eighth of an 8-bit level. */
static const double CONSTANT_DEVIATION = 0.0005;

/* A blue that was filled in with 0 or M, and then compressed or resized, stays near that end: its
 * mean is off by 10 levels at most.  The mean of a blue that is z lies as far off M as that of the
 * derived blue does (as far off 0 where z is flipped), and damage only takes it farther: in drawn
 * textures after JPEG of quality 60 by at least 1.07 times as much.  That of a blue that was filled
 * in came at most 0.65 times as far, and hardly followed z. */
static const double IDLE_BLUE_OFF_END = 0.04, IDLE_BLUE_DEVIATION = 0.045, IDLE_BLUE_DROP = 0.7,
                    IDLE_BLUE_SLOPE = 0.35, IDLE_BLUE_FOLLOWS = 0.5;

/* Before that can be told, the derived blue has to lie 2 levels below M on average. */
static const double IDLE_BLUE_SLOPES = 2.0 / 255;

/* A blue that was filled in is 0, the middle, or M.  Another constant can be the scaled z of a flat
 * surface. */
static const double USUAL_BLUE = 0.99;
static const double BLUE_CONSTANT_SURE = 0.95, BLUE_UNUSUAL_SURE = 0.8;

/* A bright constant blue that makes unit vectors was not filled in: it is the z of a gentle
 * surface, rounded to one level.  M makes most lengths of gentle slopes nearly 1, but not to the
 * level. */
static const double BRIGHT_BLUE = 0.9, FULL_BLUE = 0.998;

/* Blue as 0..1: of the texels that can tell, half fit to within 3 levels, and the slope is nearer
 * to 2 than to 1.  If a texture is not correctly rounded, this is believed only where the two blues
 * lie 3 levels apart on average: blurring a gentle standard texture makes its blue as low as
 * Z-zero's. */
static const double ZZERO_NEAR = 0.5, ZZERO_SLOPE = 1.5, ZZERO_GAP = 3;

/* Below 6 levels a blurred standard texture may still lie nearer to Z-zero and have its slope, but
 * then blue no longer follows red and green closely.  If blue does follow them, at a slope of 2, it
 * is Z-zero whatever the levels: no standard texture with this correlation came near a slope of
 * 1.8.  Off this line only correct rounding of all texels is sure. */
static const double ZZERO_WIDE_GAP = 6, ZZERO_GENTLE_FOLLOWS = 0.9;
static const double ZZERO_FOLLOWS = 0.97, ZZERO_SLOPE_OFF = 0.2;

/*
 * JPEG keeps means.  So the mean blue lies as far below M as the mean of the derived blue does, or
 * twice as far (Z-zero), whatever became of single texels.  But red and green lose slopes, and the
 * derived blue rises, where colors have half the size: fine detail of all channels is stored as one
 * brightness L = 0.299 x + 0.587 y.  Of two slopes of equal variance v it has 0.43 v, so what red
 * and green lost is (2 - 2 * 0.43) / 0.43 = 2.6 times the variance of L, which shows in blue as its
 * covariance with red and green.  With that put back, drawn standard textures have 0.9 to 1.5 after
 * JPEG and resizing, and Z-zero has 1.65 to 2.5.  An occlusion has any ratio, but does not follow z,
 * and lengths are near 1 as -1..1 rather than as 0..1.
 */
static const double ZZERO_MEANS_LEAST = 1.55, ZZERO_MEANS_MOST = 2.7, LOST_SLOPES = 2.6;
static const double ZZERO_MEANS_FOLLOWS = 0.3, ZZERO_MEANS_GAP = 2, ZZERO_MEANS_SURE = 0.75;

/* Standard textures that were blurred without normalizing have such a ratio as well.  Then blue
 * hardly rises faster than the derived one (1.3 times at most on public images), or hardly fits 0..1
 * better (0.94 times as far off at least).  So where neither is clear, all that the ratio says is
 * that it may be either. */
static const double ZZERO_MEANS_SLOPE = 1.4, ZZERO_MEANS_OFF = 0.9, ZZERO_MEANS_CLEAR = 4;
static const double MAY_BE_ZZERO_SURE = 0.7;

/* An encoder that truncates lowers a standard blue by up to a level.  Where the two blues lie less
 * than two levels apart, the result may be either. */
static const double ZZERO_SURE_GAP = 2, ZZERO_SURE = 0.85;

/* Z-zero where some texels are not correctly rounded; and a standard texture whose blue would fit
 * as 0..1 as well, since nothing in it tilts enough. */
static const double ZZERO_LOOSE_SURE = 0.8, EITHER_Z_SURE = 0.85;

/* A mean blue above this can be occlusion, or z that coarse JPEG spoiled: less is sure. */
static const double OPEN_BLUE = 0.8;

/* Red and green of a picture correlate; those of normals do so on slanted ridges only.  Where any
 * two channels correlate and the mean lies this far off the middle, it is a picture.  Slopes that
 * go round or back and forth do not lean, and blue depends on the steepness of a slope, not on its
 * direction. */
static const double ALIKE = 0.5, LEAN_PICTURE = 0.05;

/* Red and green that are nearly one channel are no x and y: only a surface of ridges that all run
 * along one diagonal has these, and as a rule its blue is z or constant.  Blue depends on how steep
 * a slope is and not on where it faces, as every slope up comes with one down; so it hardly varies
 * with red or green.  Compression makes it do so, but as a rule half as much as these vary at most.
 * Where all three channels vary together, what varies is brightness. */
static const double NEARLY_ONE = 0.9, AS_MUCH = 1.5, BLUE_ALIKE = 0.6, BLUE_VARIES = 0.55,
                    ALL_ALIKE = 0.7;

/* Of noise all channels have the same mean and spread.  A blue that is something else than x or y
 * has them by accident only. */
static const double NOISE_MEAN = 0.03, NOISE_SPREAD = 1.3, NOISE_SURE = 0.7;

/* JPEG with halved colors, and blocks of few colors, turn steps of red and green into steps of
 * brightness, so blue correlates with both of them.  A blue that is not z correlates with neither
 * (0.1 at most, as a rule).  A third of the lengths are near 1 all the same. */
static const double COMPRESSED_ALIKE = 0.2, COMPRESSED_NEAR = 0.3, COMPRESSED_SURE = 0.7;

/* What is left of z then rises and falls by as much as z, if not closely.  Where it does, negative z
 * is noise, and not the dark side of an occlusion. */
static const double COMPRESSED_FOLLOWS = 0.5;

/* Where (red, green) nearly keep to a line, as in a picture that fades from one color to another, a
 * length near 1 proves little: any line through the middle of the disc has it.  Slopes of one
 * direction keep to a line as well, so this refutes nothing.  LINE_NOISE allows for rounding. */
static const double LINE_WIDTH = 0.15, LINE_NOISE = 1.0 / 255, LINE_SURE = 0.85;

/* Where blue is not z, a picture is as likely as x, y.  A height or an alpha map beside them, as in
 * LabPBR, makes a picture less likely. */
static const double XY_SURE = 0.85, XY_ALPHA_SURE = 0.92, ALPHA_VARIES = 0.02;

/* x, y without z is less sure the farther the mean lies off the middle, the more lengths are near 1
 * (this takes nothing a fifth below the share of normals), the less they spread, and the fewer
 * texels are gentle.  Block coding, channels that correlate and colors on a line are marks of
 * pictures. */
static const double XY_LEANING_SURE = 0.6, XY_NEAR_SURE = 0.7, XY_KEPT_SURE = 0.6;
static const double XY_SPREAD_OUT_SURE = 0.6, XY_PICTURE_SURE = 0.75;
static const double FAR_FROM_UNIT = 0.2, XY_SPREAD_RANGE = 0.08;

/* If blue is z for fewer than half of the tilted texels, it is said to be unrelated. */
static const double UNRELATED_NEAR = 0.5;

/* It is surer that there are no normals the farther the mean lies off the middle, and the fewer
 * lengths are near 1. */
static const double NOT_LEAST_SURE = 0.7, NOT_SURE = 0.95, NOT_LEAN_RANGE = 0.15;

/* Steps between columns are this much larger at block borders only after block coding.  That shows
 * in two channels at least, and lengths are off to both sides.  (Steps of gentle textures make
 * ratios such as 28/25, and the answer must not depend on the rounding of a sum.  So the bound is
 * not such a ratio.) */
static const double BLOCK_STEP = 1.120001, BOTH_SIDES = 0.02;

/* Blurring: more than 1/16 of the length is lost in this share of texels, and hardly any texel
 * gains length. */
static const double BLURRED_SHARE = 0.06, BLURRED_SHORT_OVER_LONG = 3;

/* ------------------------------------------------------------------------ which way to clean */

/* A few texels far off: at most this share fails, and those that fail are off by this much (root
 * mean square), besides the rounding of all.  After resizing, errors are smaller than that. */
static const double FEW_SHARE = 0.1, GROSS_ERROR = 0.15, ROUNDING_SQUARE = 2e-5;

/* One sign: of the texels that are off, six of seven are too short, or six of seven are too long,
 * by more than rounding makes them.  Averaging vectors never makes them too long.  (Where blue is
 * 255, noise can only shorten, so a mostly flat texture with noise comes near this.) */
static const double ONE_SIDED = 6, LONG_LEAST = 0.01;

/* One factor for all texels: nearly all are too short, by about the same.  If z is scaled, lengths
 * spread somewhat more, but blue follows z to the level. */
static const double ALL_SHORT = 0.95, FACTOR_SPREAD = 0.35, FACTOR_FOLLOWS = 0.97;
static const double FACTOR_LEAST = 0.02;

/* The steepest bin of a gentle texture tells little.  There the slope of blue on derived blue
 * tells: it is less than 1 where z is scaled, and more where the vector is. */
static const double OF_Z_TELLS = 0.9;

/* Below this correlation blue does not follow red and green at all; it is the smallest after hard
 * JPEG.  Where nine of ten lengths are near 1, blue is z all the same. */
static const double UNRELATED = 0.1, UNRELATED_UNIT_SHARE = 0.9;

/* The length error of steep texels over that of shallow ones: errors of z alone give 0.7, errors of
 * all channels 1 and more.  Bins are 1/8 wide.  Where too few texels are that steep, both methods
 * give nearly the same. */
static const double STEEP_OVER_SHALLOW = 0.85, STEEP_LEAST = 0.005;
enum { SHALLOW_BIN = 2, STEEP_BIN = 5, COMPARED_BINS = 2 };

#endif
