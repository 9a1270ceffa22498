/* SPDX-License-Identifier: MIT */
/* thresholds.h - the thresholds of classify.c and choose_method.c, each with its reason */
#ifndef NTP_CLASSIFY_H
#define NTP_CLASSIFY_H

/* Gray: compression and palettes leave a few texels that are not quite gray. */
static const double GRAY_SHARE = 0.98;
static const double GRAY_SURE = 0.97, NEARLY_GRAY_SURE = 0.88;

/* A gray file is a height but where it holds something else by mistake.  What was only described,
 * not judged, may be anything. */
static const double GRAY_FILE_SURE = 0.99, NOT_ASKED_SURE = 0.5;

/* Unit length.  Honest encoders reach 1 with NTP_VERDICT_NEIGHBOR; 3 % of bad texels must not
 * matter.  By 1/8 even JPEG and resizing rarely take more than a tenth of the texels, and chance (a
 * picture's colors) rarely leaves more than half of them. */
static const double ROUNDED_ALL = 0.995, ROUNDED_SHARE = 0.96, UNIT_SHARE = 0.93,
                    NEAR_UNIT_SHARE = 0.88;

/* A tight fit that comes from flat texels only: of the tilted ones few fit, and where blue does
 * not even follow red and green (correlation) the fit counts for nothing.  A sure fit has three
 * quarters of them: 3 % of wrong blues take few away, and a blue that is bright everywhere fits
 * half at most. Where fewer than 64 are tilted, all others have to fit instead. */
static const double TILTED_LEAST = 0.01, TILTED_NEAR_LEAST = 0.3, BLUE_FOLLOWS = 0.3;
static const double TILTED_NEAR_SURE = 0.75, UNIT_FLAT_SURE = 0.98;

/* Damaged normals: lengths spread by 0.06 at most, or somewhat more where blue still follows red
 * and green; heights, occlusion and pictures spread them by 0.1 and more and do not follow.  What
 * damage spreads still points up, while a height or an occlusion has blues below the middle.
 * Blurring and scaling leave three quarters of the length, faulty generators add up to 15 %. */
static const double SPREAD_MOST = 0.06, SPREAD_FOLLOWING = 0.18, NEGATIVE_DAMAGED = 0.003;
static const double LENGTH_LEAST = 0.75, LENGTH_MOST = 1.15;

/*
 * Flat texels fit whatever blue is, if it is only bright, and an occlusion or a height in blue
 * may well fit the gentle ones too.  So lengths near 1 are sure only where enough texels slope
 * and blue is seen to be z by one of two things.  It goes up and down with the derived blue, by
 * as much: what is no z hardly reaches a correlation of 0.85, and rarely that slope.  Or it goes
 * with it at all and lengths keep close together on slopes as well, which what is no z spreads
 * half as far again.  A correlation of 0.95 is proof, however short or long the vectors are.
 */
static const double Z_FOLLOWS = 0.9, Z_FOLLOWS_CLOSELY = 0.95, Z_SLOPE_OFF = 0.3;
static const double KEPT_SPREAD = 0.03, KEPT_SLOPING_ERROR = 0.05;
static const double LOOSE_SURE = 0.93, UNSEEN_SURE = 0.85;

/* How sure lengths make it: more so the more of them are near 1 (all of it a tenth above the share
 * that it takes), less so the more they spread.  What fits to the level is sure, unless the fit
 * comes from flat texels only. */
static const double TIGHT_SURE = 0.97, NEAR_SURE = 0.8, NEAR_UNIT_RANGE = 0.1;
static const double SPREAD_SURE = 0.6, FLAT_ONLY_SURE = 0.8;
enum { SLOPING_TEXELS_LEAST = 64 };

/* A blue that goes to both ends fits where it is 0 and where it is M: with more negative z than a
 * few wrong texels make it may be a height as well. */
static const double NEGATIVE_MOST = 0.05, NEGATIVE_SURE = 0.8;

/* Lean of the mean of x, y.  Tangent-space textures lean by less than 0.1 as a rule, and by 0.3 on
 * a slope; a picture's red and green are rarely both that near the middle. */
static const double LEAN_SMALL = 0.03, LEAN_SLANTED = 0.1, LEAN_CENTERED = 0.15, LEAN_MOST = 0.3;

/* x, y that are too long: JPEG and overshooting filters make some; what has more holds no x, y. */
static const double TOO_LONG_SHARE = 0.08;

/* Of colors spread evenly over the disc three quarters are steeper than 1/2 and a sixteenth is
 * flatter than 1/4; normals crowd in the middle, and where they do not, little is sure.  Noise with
 * slopes of 3 has nearly nine tenths of its texels there. */
static const double STEEP_MOST = 0.9, MIDDLE_LEAST = 0.1;

/* Padding of another color than black and white, such as gray, or the green that a flip makes of
 * black, is flat in red and green or too long.  Where this share of the tilted texels has the
 * blue of a normal, one that a constant blue has not, the rest is taken for it.  Pale pictures
 * have a few such texels too, but hardly a unit vector. */
static const double PADDED_NEAR = 0.75, PADDED_GAP = 3, PADDED_UNIT = 0.1;
static const double PADDED_LEAST_SURE = 0.7, PADDED_SURE = 0.85, PADDED_RANGE = 0.15;
enum { PADDED_TEXELS_LEAST = 64 };

/* Object space: all three axes go both ways.  3 % of wrong blues are 1.5 % negative ones.  Where
 * the axes are well mixed less of the length may be lost, as compressed borders of charts lose
 * it. */
static const double DIRECTIONS_LEAST = 0.05, AXIS_LEAST = 0.02;
static const double MIXED_LEAST = 0.15, MIXED_UNIT_SHARE = 0.8;

/* Of a ball seven eighths are steeper than 1/2, of a cube two thirds; of hills and ridges with a
 * height in blue, which may point in all directions too, mostly fewer, or red and green keep to a
 * line. */
static const double BODY_STEEP_LEAST = 0.4;

/* Unit vectors to the level with well mixed axes are hardly anything else. */
static const double OBJECT_SURE = 0.96, OBJECT_LOOSE_SURE = 0.8;

/* Blue 0 or 255 is of unit length where red and green are flat, whatever it means; so the tilted
 * texels (steepness 1/4 to 7/8) of an object-space texture must be near unit length by
 * themselves. JPEG at the borders of charts takes up to 0.15 from them where sides of a box leave
 * hardly others. */
static const double TILTED_ERROR_MOST = 0.16;
enum { TILTED_FIRST_BIN = 2, TILTED_END_BIN = 7 };

/* Z flipped, or another channel being z: (almost) all texels agree. */
static const double FLIPPED_SHARE = 0.95, OTHER_Z_SHARE = 0.98, OTHER_Z_MEAN = 0.8;

/* Colors of a picture may have this mean too; unit vectors to the level, off a line, do not come by
 * chance. */
static const double SWAPPED_SURE = 0.92, SWAPPED_LOOSE_SURE = 0.75;

/* The mean of a channel that holds x or y: near the middle, in levels / M.  An alpha that holds x
 * is rarely 0 or M; a mask is little else. */
static const double MIDDLE = 0.15, ALPHA_ENDS_MOST = 0.05;

/* Two channels that are x and y by their number alone: a lean can be a slope, but hardly one so
 * steep. */
static const double PAIR_SURE = 0.95, PAIR_LEANING_SURE = 0.6, PAIR_TOO_LONG_SURE = 0.8;

/* Red and blue of DXT5nm: constant but for what block compression does to them, and near 0 or M, as
 * no x is.  Where they repeat green it may be a gray picture with an alpha that is balanced as
 * well. */
static const double IDLE_DEVIATION = 0.02, IDLE_OFF_MIDDLE = 0.35;
static const double DXT5NM_SURE = 0.95, DXT5NM_GRAY_SURE = 0.85;

/* Stored as sRGB, flat is 188/255 = 0.737, and slopes of 1 spread the mean by less than this.  The
 * mean of blue is above theirs by 0.2 and more; a gray of 230 has unit length too. */
static const double GAMMA_FLAT = 0.737, GAMMA_SPREAD = 0.12, GAMMA_SHARE = 0.85, GAMMA_RISE = 0.1;

/* Decoding has to bring a tenth of the lengths nearer to 1.  Flat texels at 188 are proof; without
 * this many of them another bright picture may do the same. */
static const double GAMMA_GAIN = 0.1, GAMMA_FLAT_SHARE = 0.02;
static const double GAMMA_SURE = 0.93, GAMMA_UNSEEN_SURE = 0.8;

/* A channel that does not vary: deviation of an eighth of an 8-bit level. */
static const double CONSTANT_DEVIATION = 0.0005;

/* Blue that is filled in is 0, the middle, or M; another constant can be the scaled z of a
 * surface that is flat. */
static const double USUAL_BLUE = 0.99;
static const double BLUE_CONSTANT_SURE = 0.95, BLUE_UNUSUAL_SURE = 0.8;

/* Nor is a bright constant blue filled in where it makes unit vectors: z of a gentle surface,
 * rounded to one level.  M alone makes most lengths of gentle slopes nearly 1, but not to the
 * level. */
static const double BRIGHT_BLUE = 0.9, FULL_BLUE = 0.998;

/* Blue as 0..1: of the texels that can tell, half fit to within 3 levels; slope 2 and not 1.  Of
 * textures that are not honestly rounded it is believed only where the two blues lie 3 levels apart
 * on average: blurring a gentle standard texture makes its blue as low as Z-zero's. */
static const double ZZERO_NEAR = 0.5, ZZERO_SLOPE = 1.5, ZZERO_GAP = 3;

/* Below 6 levels a blurred standard texture may still lie nearer to Z-zero and have its slope,
 * but blue then no longer follows red and green closely.  Where it does, at a slope of 2, it is
 * Z-zero whatever the levels: of standard ones with this correlation none came near 1.8.  Off this
 * line only honest rounding of all texels is sure. */
static const double ZZERO_WIDE_GAP = 6, ZZERO_GENTLE_FOLLOWS = 0.9;
static const double ZZERO_FOLLOWS = 0.97, ZZERO_SLOPE_OFF = 0.2;

/* An encoder that truncates lowers a standard blue by up to a level: where the blues lie less than
 * two apart that is Z-zero's as well as not. */
static const double ZZERO_SURE_GAP = 2, ZZERO_SURE = 0.85;

/* Z-zero of which some texels are no honest rounding; and a standard texture of which blue would
 * fit as 0..1 as well, since nothing in it tilts enough. */
static const double ZZERO_LOOSE_SURE = 0.8, EITHER_Z_SURE = 0.85;

/* A mean blue above this can be occlusion, or z that coarse JPEG took apart: less is sure. */
static const double OPEN_BLUE = 0.8;

/* Red and green of a picture go together; those of normals do on slanted ridges only.  Where any
 * two channels do and the mean lies this far off the middle, it is a picture: slopes that go
 * round or back and forth do not lean, and blue goes with the steepness of a slope, not with its
 * direction. */
static const double ALIKE = 0.5, LEAN_PICTURE = 0.05;

/* JPEG with halved colors, and blocks of few colors, turn steps of red and green into steps of
 * brightness, so that blue goes up and down with both of them.  In what is no z it goes with
 * neither (0.1 at most, as a rule).  A third of the lengths are near 1 all the same. */
static const double COMPRESSED_ALIKE = 0.2, COMPRESSED_NEAR = 0.3, COMPRESSED_SURE = 0.7;

/* Where (red, green) all but keep to a line, as in a picture that fades from one color to
 * another, a length near 1 proves little: any line through the middle of the disc has it.  Slopes
 * of one direction keep to a line as well, so this refutes nothing.  The second part is for
 * rounding. */
static const double LINE_WIDTH = 0.15, LINE_NOISE = 1.0 / 255, LINE_SURE = 0.85;

/* That blue is no z makes a picture as likely as x, y; a height or an alpha map beside them, as in
 * LabPBR, makes it less so. */
static const double XY_SURE = 0.85, XY_ALPHA_SURE = 0.92, ALPHA_VARIES = 0.02;

/* Less sure is x, y without z the farther the mean lies off the middle, the more lengths are near 1
 * (all of it is gone a fifth below the share of normals), the less they spread, and the fewer
 * texels are gentle.  Block coding, colors that go together and a line of colors are marks of
 * pictures. */
static const double XY_LEANING_SURE = 0.6, XY_NEAR_SURE = 0.7, XY_KEPT_SURE = 0.6;
static const double XY_SPREAD_OUT_SURE = 0.6, XY_PICTURE_SURE = 0.75;
static const double FAR_FROM_UNIT = 0.2, XY_SPREAD_RANGE = 0.08;

/* Blue of tilted texels that is z for fewer than half of them is said to be unrelated. */
static const double UNRELATED_NEAR = 0.5;

/* No normals: the surer the farther the mean lies off the middle, and the fewer lengths are near
 * 1. */
static const double NOT_LEAST_SURE = 0.7, NOT_SURE = 0.95, NOT_LEAN_RANGE = 0.15;

/* Columns at block borders step this much farther than others only after block coding; it shows in
 * two channels at least, and errs to both sides.  (Steps of gentle textures make ratios such as
 * 28/25, which must not hang on the rounding of a sum: so the bound is none.) */
static const double BLOCK_STEP = 1.120001, BOTH_SIDES = 0.02;

/* Blurring: lengths are lost, by more than 1/16 in this share of texels, and hardly any gained. */
static const double BLURRED_SHARE = 0.06, BLURRED_SHORT_OVER_LONG = 3;

/* ------------------------------------------------------------------------ which way to clean */

/* A few texels far off: at most this share fails, and those that fail are off by this much (root of
 * the mean square), besides what rounding does to all.  Resizing fails less grossly. */
static const double FEW_SHARE = 0.1, GROSS_ERROR = 0.15, ROUNDING_SQUARE = 2e-5;

/* One sign: of the texels that are off, six of seven are too short, or too long, and that by more
 * than rounding does, which averaging of vectors never makes them.  (Where blue is 255, noise can
 * only shorten, so that a mostly flat texture with noise comes near this.) */
static const double ONE_SIDED = 6, LONG_LEAST = 0.01;

/* One factor for all texels: practically all are too short, by about the same.  The lengths of a
 * texture whose z is scaled spread somewhat more, but there blue follows z to the level. */
static const double ALL_SHORT = 0.95, FACTOR_SPREAD = 0.35, FACTOR_FOLLOWS = 0.97;
static const double FACTOR_LEAST = 0.02;

/* Of a gentle texture the steepest bin tells little; there the slope of blue on derived blue tells:
 * less than 1 where z is scaled, more where the vector is. */
static const double OF_Z_TELLS = 0.9;

/* Blue that does not follow red and green at all; the smallest correlation after hard JPEG.  Where
 * nine of ten lengths are near 1 it is z all the same. */
static const double UNRELATED = 0.1, UNRELATED_UNIT_SHARE = 0.9;

/* Steep over shallow: z alone gives 0.7, all channels 1 and more.  Bins of 1/8; where too few
 * texels are that steep, both methods give nearly the same. */
static const double STEEP_OVER_SHALLOW = 0.85, STEEP_LEAST = 0.005;
enum { SHALLOW_BIN = 2, STEEP_BIN = 5, COMPARED_BINS = 2 };

#endif
