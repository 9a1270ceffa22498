/* SPDX-License-Identifier: MIT */
/*
 * classify.c - what a texture is, from the evidence of its tally
 *
 * This room decides what a texture is, what went wrong with it (accidents), and how to clean it.
 *   classify.c       the rules about classes and accidents, in the order in which they are asked
 *   thresholds.h     every threshold, with its reason
 *   question.h       what the rules read: shares of texels, and sums of the evidence (question.c)
 *   choose_method.c  the way to clean it: keep, derive or normalize
 *   reason_text.c    names of classes, and reasons as English clauses
 * The rules are a short list of questions, the most telling first.  The first that can be answered
 * decides.  The rules use shares of texels and hardly any extremes, so padding, a few bad texels or
 * lossy compression do not change the answer.  docs/classification.md tells the same in words.
 */
#include "classify/question.h"
#include "classify/thresholds.h"
#include "base/view.h"

#include <math.h>
#include <string.h>

static void because(question *q, int32_t code, double value)
{
    if (q->out->reason_count < NTP_MAX_REASONS)
        q->out->reasons[q->out->reason_count++] = (ntp_reason) { code, value };
}

static bool is(question *q, ntp_class type, double confidence)
{
    q->out->type = type;
    q->out->confidence = confidence;
    return true;
}

/* ------------------------------------------------------------------------- the questions */

/* DXT5nm: alpha and green lie around the middle, and red and blue hold nothing of their own. */
static bool is_dxt5nm(question *q)
{
    const ntp_stats *s = q->s;
    const ntp__evidence *e = q->e;
    bool gray = s->channels == 2 || (double) s->gray >= GRAY_SHARE * (double) s->texels;
    bool idle = e->used_sd[0] < IDLE_DEVIATION && e->used_sd[2] < IDLE_DEVIATION &&
                off_middle(s->used_mean[0]) > IDLE_OFF_MIDDLE;
    double ends = (double) (s->alpha_zero + s->alpha_full) / (double) s->texels;
    bool still = e->used_sd[1] < CONSTANT_DEVIATION && e->used_sd[3] < CONSTANT_DEVIATION;
    /* Without alpha, ag_in_disc is 0. */
    if ((!gray && !idle) || still || ends > ALPHA_ENDS_MOST ||
        off_middle(s->used_mean[3]) > MIDDLE || off_middle(s->used_mean[1]) > MIDDLE ||
        e->ag_in_disc < 1 - TOO_LONG_SHARE)
        return false;
    q->out->accidents |= NTP_ACCIDENT_DXT5NM;
    because(q, NTP_REASON_DXT5NM, e->ag_in_disc);
    return is(q, NTP_CLASS_XY, gray ? DXT5NM_GRAY_SURE : DXT5NM_SURE);
}

static bool is_one_color(question *q)
{
    const ntp_stats *s = q->s;
    if (s->distinct > 1)
        return false;
    because(q, s->unused >= s->texels ? NTP_REASON_NOTHING_USED : NTP_REASON_ONE_COLOR, 1);
    return is(q, NTP_CLASS_ONE_COLOR, 1);
}

/* Gray images, and whatever was measured as NTP_ENCODING_HEIGHT: of that only the channels are
 * known. */
static bool is_height(question *q)
{
    const ntp_stats *s = q->s;
    double gray = ((double) s->gray - (double) s->black - (double) s->white) / q->all_used;
    bool judged = s->standard.length_max > 0;
    if (s->channels <= 2 && !judged) {
        because(q, NTP_REASON_GRAY_FILE, 1);
        return is(q, NTP_CLASS_HEIGHT, GRAY_FILE_SURE);
    }
    if (s->channels > 2 && gray > GRAY_SHARE) {
        because(q, NTP_REASON_GRAY, least(gray, 1));
        return is(q, NTP_CLASS_HEIGHT, gray < 1 ? NEARLY_GRAY_SURE : GRAY_SURE);
    }
    if (s->channels > 2 && judged && ntp__is_tinted_gray(q->e)) {
        because(q, NTP_REASON_ALL_ALIKE, least(q->e->correlation[1], q->e->correlation[2]));
        return is(q, NTP_CLASS_HEIGHT, TINTED_SURE);
    }
    return !judged && is(q, NTP_CLASS_NOT_NORMALS, NOT_ASKED_SURE);
}

static bool is_two_channels(question *q)
{
    if (q->s->channels != 2)
        return false;
    because(q, NTP_REASON_TWO_CHANNELS, 1);
    if (q->too_long > TOO_LONG_SHARE) {
        because(q, NTP_REASON_XY_TOO_LONG, q->too_long);
        return is(q, NTP_CLASS_NOT_NORMALS, PAIR_TOO_LONG_SURE);
    }
    because(q, q->lean > LEAN_MOST ? NTP_REASON_XY_OFF_CENTER : NTP_REASON_XY_CENTERED, q->lean);
    return is(q, NTP_CLASS_XY, q->lean > LEAN_MOST ? PAIR_LEANING_SURE : PAIR_SURE);
}

static bool is_gamma(question *q)
{
    const ntp_stats *s = q->s;
    const ntp__evidence *e = q->e;
    double flat = (double) s->near_gamma_flat / q->used;
    double rise = s->used_mean[2] - most(s->used_mean[0], s->used_mean[1]);
    if (e->gamma_near_unit < GAMMA_SHARE || e->gamma_near_unit < q->near[0] + GAMMA_GAIN ||
        distance(s->used_mean[0], GAMMA_FLAT) > GAMMA_SPREAD ||
        distance(s->used_mean[1], GAMMA_FLAT) > GAMMA_SPREAD || rise < GAMMA_RISE)
        return false;
    q->out->accidents |= NTP_ACCIDENT_GAMMA;
    because(q, NTP_REASON_GAMMA, e->gamma_near_unit);
    if (flat > GAMMA_FLAT_SHARE)
        because(q, NTP_REASON_GAMMA_FLAT, flat);
    bool sure = flat > GAMMA_FLAT_SHARE && !ntp__keep_to_a_line(q->e, 0, 1);
    return is(q, NTP_CLASS_STANDARD, sure ? GAMMA_SURE : GAMMA_UNSEEN_SURE);
}

/* What varies in a picture is brightness: in all channels alike, and seldom around the middle. */
static bool is_bright_and_dark(const question *q)
{
    double alike = 0;
    for (int32_t i = 0; i < 3; i++)
        alike = most(alike, distance(q->e->correlation[i], 0));
    return q->lean > LEAN_PICTURE && alike > ALIKE;
}

static bool is_swapped(question *q)
{
    const ntp_stats *s = q->s;
    if (q->near[0] < NEAR_UNIT_SHARE || off_middle(s->used_mean[2]) > MIDDLE)
        return false;
    bool red = q->red_low < 1 - OTHER_Z_SHARE && s->used_mean[0] > OTHER_Z_MEAN &&
               off_middle(s->used_mean[1]) < MIDDLE;
    bool green = q->green_low < 1 - OTHER_Z_SHARE && s->used_mean[1] > OTHER_Z_MEAN &&
                 off_middle(s->used_mean[0]) < MIDDLE;
    int32_t z = red ? 0 : 1;
    double y = 2 * s->used_mean[1 - z] - 1, b = 2 * s->used_mean[2] - 1;
    double y_sd = 2 * q->e->used_sd[1 - z], b_sd = 2 * q->e->used_sd[2];
    double squares = y * y + b * b + y_sd * y_sd + b_sd * b_sd;
    double fall = 2 * (1 - s->used_mean[z]), needed = OTHER_Z_FALLS * squares;
    bool picture = y * y + b * b > LEAN_PICTURE * LEAN_PICTURE &&
                   distance(q->e->correlation[red ? 2 : 1], 0) > ALIKE;
    if ((!red && !green) || fall + OTHER_Z_ROUNDING < needed ||
        (picture && q->unit[0] < UNIT_SHARE))
        return false;
    q->out->accidents |= red ? NTP_ACCIDENT_RED_IS_Z : NTP_ACCIDENT_GREEN_IS_Z;
    because(q, red ? NTP_REASON_RED_IS_Z : NTP_REASON_GREEN_IS_Z,
            1 - (red ? q->red_low : q->green_low));
    because(q, NTP_REASON_NEAR_UNIT, q->near[0]);
    bool sure =
        q->unit[0] > UNIT_SHARE && fall >= needed && !ntp__keep_to_a_line(q->e, red ? 1 : 0, 2);
    return is(q, NTP_CLASS_STANDARD, sure ? SWAPPED_SURE : SWAPPED_LOOSE_SURE);
}

/* Do blue and the derived blue keep to a line of this slope, and do enough texels slope to tell? */
static bool follows_as(const question *q, double slope, double correlation, double off)
{
    double sign = slope < 0 ? -1 : 1;
    return ntp__has_slopes(q) && sign * q->e->blue_correlation > correlation &&
           distance(q->e->blue_slope, slope) < off;
}

/* Do the means say 0..1, and lengths too?  This holds after JPEG that spoiled single texels. */
static bool may_be_zzero(const question *q)
{
    const ntp__evidence *e = q->e;
    double drop = ntp__blue_drop_before(e);
    return drop > ZZERO_MEANS_LEAST && drop < ZZERO_MEANS_MOST && q->near[1] > q->near[0] &&
           e->fit[1].length_sd < e->fit[0].length_sd && e->tilted_off[1] < e->tilted_off[0] &&
           e->blue_correlation > ZZERO_MEANS_FOLLOWS && e->tilted_gap > ZZERO_MEANS_GAP;
}

static bool is_zzero_by_means(const question *q)
{
    const ntp__evidence *e = q->e;
    return may_be_zzero(q) && e->blue_slope > ZZERO_MEANS_SLOPE &&
           e->tilted_off[1] < ZZERO_MEANS_OFF * e->tilted_off[0] &&
           e->tilted_gap > ZZERO_MEANS_CLEAR;
}

/* Is blue stored as 0..1?  Nine of ten textures are not, so it takes more than a better fit. */
static bool prefers_zzero(const question *q)
{
    const ntp__evidence *e = q->e;
    if (e->tilted == 0)
        return false;
    bool line = follows_as(q, 2, ZZERO_FOLLOWS, ZZERO_SLOPE_OFF);
    if (q->rounded[0] > ROUNDED_SHARE || q->rounded[1] > ROUNDED_SHARE) {
        bool clear = (e->tilted_gap > ZZERO_GAP && e->tilted_near[1] >= e->tilted_near[0]) ||
                     q->rounded[1] > ROUNDED_ALL || line;
        return q->rounded[1] > q->rounded[0] && clear;
    }
    if (line || is_zzero_by_means(q))
        return true;
    return e->tilted_near[1] > e->tilted_near[0] && e->tilted_near[1] > ZZERO_NEAR &&
           e->tilted_off[1] < e->tilted_off[0] && e->tilted_gap > ZZERO_GAP &&
           e->blue_slope > ZZERO_SLOPE &&
           (e->tilted_gap > ZZERO_WIDE_GAP || e->blue_correlation > ZZERO_GENTLE_FOLLOWS);
}

static bool is_object_space(question *q)
{
    double z = rarer(q->negative), red = rarer(q->red_low), green = rarer(q->green_low);
    const double *alike = q->e->correlation;
    bool bright_and_dark = least(least(alike[0], alike[1]), alike[2]) > ALL_ALIKE;
    bool mixed = z > MIXED_LEAST && red > MIXED_LEAST && green > MIXED_LEAST;
    double up = 2 * q->s->used_mean[2] - 1, one_way = sqrt(q->lean * q->lean + up * up);
    if (bright_and_dark || one_way > ONE_WAY_MOST || z < DIRECTIONS_LEAST || red < AXIS_LEAST ||
        green < AXIS_LEAST || ntp__steep_share(q) < BODY_STEEP_LEAST ||
        ntp__keep_to_a_line(q->e, 0, 1) ||
        q->near[0] < (mixed ? MIXED_UNIT_SHARE : NEAR_UNIT_SHARE) || prefers_zzero(q) ||
        ntp__length_error(q->e, TILTED_FIRST_BIN, TILTED_END_BIN) > TILTED_ERROR_MOST)
        return false;
    because(q, NTP_REASON_ALL_DIRECTIONS, q->negative);
    because(q, NTP_REASON_NEAR_UNIT, q->near[0]);
    bool sure = mixed && q->unit[0] > UNIT_SHARE && q->unit[1] < UNIT_SHARE;
    return is(q, NTP_CLASS_OBJECT_SPACE, sure ? OBJECT_SURE : OBJECT_LOOSE_SURE);
}

/* Do red and green vary together, and by as much?  (A flip of green makes them vary against each
 * other.) */
static bool is_one_channel_twice(const question *q)
{
    const double *sd = q->e->used_sd;
    return distance(q->e->correlation[0], 0) > NEARLY_ONE && sd[0] < AS_MUCH * sd[1] &&
           sd[1] < AS_MUCH * sd[0];
}

static bool is_blue_constant(question *q)
{
    const ntp_stats *s = q->s;
    const ntp__evidence *e = q->e;
    const double z = 2 * s->used_mean[2] - 1;
    bool constant = e->used_sd[2] < CONSTANT_DEVIATION;
    bool still = most(e->used_sd[0], e->used_sd[1]) < CONSTANT_DEVIATION;
    if (!ntp__blue_is_idle(e) || still || ntp__too_long(q) > TOO_LONG_SHARE ||
        q->lean > LEAN_MOST ||
        (constant ? q->lean > LEAN_PICTURE && is_one_channel_twice(q) : is_bright_and_dark(q)) ||
        (s->used_mean[2] > BRIGHT_BLUE && q->unit[0] > UNIT_SHARE) ||
        (constant && s->used_mean[2] < FULL_BLUE && s->used_mean[2] > BRIGHT_BLUE &&
         q->near[0] > NEAR_UNIT_SHARE))
        return false;
    q->out->accidents |= NTP_ACCIDENT_BLUE_CONSTANT;
    because(q, constant ? NTP_REASON_BLUE_CONSTANT : NTP_REASON_BLUE_IDLE, s->used_mean[2]);
    because(q, NTP_REASON_XY_CENTERED, q->lean);
    bool usual = z < -USUAL_BLUE || z > USUAL_BLUE || distance(z, 0) < 1 - USUAL_BLUE;
    bool sure = constant && usual && q->lean < LEAN_CENTERED && !ntp__keep_to_a_line(q->e, 0, 1);
    return is(q, NTP_CLASS_XY, sure ? BLUE_CONSTANT_SURE : BLUE_UNUSUAL_SURE);
}

static void note_damage(question *q, bool zzero)
{
    const ntp__fit_evidence *fit = &q->e->fit[zzero];
    double step = ntp__block_step(q->e);
    if (step > BLOCK_STEP && fit->too_short > BOTH_SIDES && fit->too_long > BOTH_SIDES) {
        q->out->accidents |= NTP_ACCIDENT_LOSSY;
        because(q, NTP_REASON_BLOCKS, step);
    } else if (fit->near_unit[1] < 1 - BLURRED_SHARE &&
               fit->too_short > BLURRED_SHORT_OVER_LONG * fit->too_long) {
        q->out->accidents |= NTP_ACCIDENT_FILTERED;
        because(q, NTP_REASON_SHORT, fit->too_short);
    }
}

/*
 * The share of tilted texels that fit; 1 where none are tilted, as then nothing speaks against it.
 * tilted_near takes z for positive.  If z is flipped, the texels steeper than 1/8 are asked
 * instead, and there have to be some.
 */
static double fit_on_slopes(const question *q, bool zzero, bool flipped)
{
    const ntp__evidence *e = q->e;
    double sloping = ntp__count_bins(q->e, 1, NTP__STEEPNESS_BINS), wrong = 0;
    if (!flipped)
        return e->tilted > 0 ? e->tilted_near[zzero] : 1;
    for (int32_t i = 1; i < NTP__STEEPNESS_BINS; i++)
        wrong += (double) e->steepness_not_neighbor[i];
    return sloping > TILTED_LEAST * q->used ? 1 - wrong / sloping : 0;
}

/* How sure it is that lengths are off by no more than damage makes them; 0: they are not. */
static double fits_loosely(const question *q, bool zzero, double follows)
{
    const ntp__fit_evidence *fit = &q->e->fit[zzero];
    bool upright = zzero || rarer(q->negative) < NEGATIVE_DAMAGED;
    double spread_most = SPREAD_MOST + (upright ? SPREAD_FOLLOWING * most(follows, 0) : 0);
    double mean = fit->length_mean;
    /* Compression mixes normals and padding where they meet: lengths spread, but in few texels. */
    bool edges = q->e->padding > 0 && q->near[zzero] > NEAR_UNIT_SHARE;
    if ((fit->length_sd > spread_most && !edges) || mean < LENGTH_LEAST || mean > LENGTH_MOST ||
        q->lean > LEAN_MOST || q->too_long > TOO_LONG_SHARE ||
        (q->lean > LEAN_CENTERED && q->near[zzero] < NEAR_UNIT_SHARE))
        return 0;
    if (q->near[zzero] > NEAR_UNIT_SHARE)
        return blend(NEAR_SURE, LOOSE_SURE, (q->near[zzero] - NEAR_UNIT_SHARE) / NEAR_UNIT_RANGE);
    return blend(SPREAD_SURE, NEAR_SURE, (spread_most - fit->length_sd) / SPREAD_MOST);
}

/* Does blue rise and fall with z, by as much? */
static bool follows_z(const question *q, bool flipped, double correlation)
{
    return follows_as(q, flipped ? -1 : 1, correlation, Z_SLOPE_OFF);
}

/* Does blue rise and fall with z at all, and are lengths close together, on slopes as well? */
static bool keeps_length(const question *q, double follows)
{
    return ntp__has_slopes(q) && follows > BLUE_FOLLOWS && q->e->fit[0].length_sd < KEPT_SPREAD &&
           ntp__length_error(q->e, 1, NTP__STEEPNESS_BINS) < KEPT_SLOPING_ERROR;
}

static bool is_normals(question *q)
{
    const ntp_stats *s = q->s;
    const ntp__evidence *e = q->e;
    bool zzero = prefers_zzero(q), flipped = q->negative > FLIPPED_SHARE && !zzero;
    double follows = flipped ? -e->blue_correlation : e->blue_correlation;
    double on_slopes = fit_on_slopes(q, zzero, flipped);
    bool enough = flipped || (double) e->tilted > TILTED_LEAST * q->used;
    bool flat_only = enough && on_slopes < TILTED_NEAR_LEAST, idle = follows < BLUE_FOLLOWS;
    bool tight = q->unit[zzero] > UNIT_SHARE && !(flat_only && idle);
    double sure = tight ? TIGHT_SURE : fits_loosely(q, zzero, follows);
    if (sure == 0 && !zzero && !flipped && q->negative < NEGATIVE_MOST &&
        follows_z(q, false, Z_FOLLOWS_ROUGHLY) && q->lean < LEAN_CENTERED &&
        q->too_long < TOO_LONG_ROUGHLY)
        sure = ROUGHLY_SURE;
    if (sure == 0)
        return false;
    bool closely = follows_z(q, flipped, Z_FOLLOWS_CLOSELY);
    bool seen = tight && on_slopes >= TILTED_NEAR_SURE &&
                (e->tilted >= SLOPING_TEXELS_LEAST || q->unit[zzero] > UNIT_FLAT_SURE);
    if (closely && !tight)
        sure = LOOSE_SURE;
    if ((flat_only && !closely) || (!tight && q->lean > LEAN_SLANTED))
        sure = least(sure, FLAT_ONLY_SURE);
    if (s->channel[2].min == s->channel[2].max ||
        !(seen || follows_z(q, flipped, Z_FOLLOWS) || keeps_length(q, follows)))
        sure = least(sure, UNSEEN_SURE);
    if (!zzero && !flipped && q->negative > NEGATIVE_MOST)
        sure = least(sure, NEGATIVE_SURE);
    if (ntp__keep_to_a_line(q->e, 0, 1) && (!tight || q->lean > LEAN_MOST))
        sure = least(sure, LINE_SURE);
    is(q, zzero ? NTP_CLASS_ZZERO : NTP_CLASS_STANDARD, sure);
    if (tight)
        because(q, zzero ? NTP_REASON_UNIT_ZZERO : NTP_REASON_UNIT, q->unit[zzero]);
    else if (closely)
        because(q, NTP_REASON_FOLLOWS, follows);
    else
        because(q, zzero ? NTP_REASON_NEAR_UNIT_ZZERO : NTP_REASON_NEAR_UNIT, q->near[zzero]);
    if (zzero) {
        bool by_means = e->tilted_near[1] < ZZERO_NEAR;
        if (by_means)
            because(q, NTP_REASON_ZZERO_MEANS, ntp__blue_drop_before(e));
        else
            because(q, NTP_REASON_PREFERS_ZZERO, e->tilted_near[1]);
        bool line = follows_as(q, 2, ZZERO_FOLLOWS, ZZERO_SLOPE_OFF);
        if (q->rounded[1] < ROUNDED_SHARE || !(line || q->rounded[1] > ROUNDED_ALL))
            q->out->confidence = least(sure, by_means ? ZZERO_MEANS_SURE : ZZERO_LOOSE_SURE);
        else if (e->tilted_gap < ZZERO_SURE_GAP)
            q->out->confidence = least(sure, ZZERO_SURE);
    } else if (!flipped && (e->tilted == 0 || (e->tilted_near[1] > e->tilted_near[0] &&
                                               e->blue_slope > ZZERO_SLOPE))) {
        because(q, NTP_REASON_UNDECIDED_ZZERO, 0);
        q->out->confidence = least(sure, EITHER_Z_SURE);
    } else if (!flipped && q->unit[0] < UNIT_SHARE && may_be_zzero(q)) {
        because(q, NTP_REASON_ZZERO_MEANS, ntp__blue_drop_before(e));
        q->out->confidence = least(sure, MAY_BE_ZZERO_SURE);
    }
    if (flipped) {
        q->out->accidents |= NTP_ACCIDENT_Z_FLIPPED;
        because(q, NTP_REASON_Z_NEGATIVE, q->negative);
    }
    if (!tight)
        note_damage(q, zzero);
    return true;
}

/* Normals with much padding: only the tilted texels are asked. */
static bool is_padded(question *q)
{
    const ntp__evidence *e = q->e;
    const bool zzero = e->tilted_near[1] > e->tilted_near[0];
    const double tilted = (double) e->tilted;
    if (tilted < PADDED_TEXELS_LEAST || tilted < TILTED_LEAST * q->used ||
        e->tilted_gap < PADDED_GAP || e->tilted_near[zzero] < PADDED_NEAR ||
        q->unit[zzero] < PADDED_UNIT)
        return false;
    because(q, zzero ? NTP_REASON_PREFERS_ZZERO : NTP_REASON_PREFERS_STANDARD,
            e->tilted_near[zzero]);
    because(q, zzero ? NTP_REASON_UNIT_ZZERO : NTP_REASON_UNIT, q->unit[zzero]);
    if (q->too_long > 0)
        because(q, NTP_REASON_XY_TOO_LONG, q->too_long);
    return is(q, zzero ? NTP_CLASS_ZZERO : NTP_CLASS_STANDARD,
              blend(PADDED_LEAST_SURE, PADDED_SURE,
                    (e->tilted_near[zzero] - PADDED_NEAR) / PADDED_RANGE));
}

/* Standard after compression that left blue little of its own: all three channels correlate. */
static bool is_compressed(question *q)
{
    const ntp_stats *s = q->s;
    const ntp__evidence *e = q->e;
    double alike = least(e->correlation[1], e->correlation[2]);
    if (alike < COMPRESSED_ALIKE || s->used_mean[2] < OPEN_BLUE || q->lean > LEAN_SLANTED ||
        q->negative >
            (follows_z(q, false, COMPRESSED_FOLLOWS) ? NEGATIVE_MOST : NEGATIVE_DAMAGED) ||
        q->too_long > TOO_LONG_SHARE || q->near[0] < COMPRESSED_NEAR ||
        q->e->fit[0].length_mean < LENGTH_LEAST)
        return false;
    q->out->accidents |= NTP_ACCIDENT_LOSSY;
    because(q, NTP_REASON_ALL_ALIKE, alike);
    because(q, NTP_REASON_XY_CENTERED, q->lean);
    return is(q, NTP_CLASS_STANDARD, COMPRESSED_SURE);
}

static bool is_xy(question *q)
{
    const ntp_stats *s = q->s;
    const ntp__evidence *e = q->e;
    double middle = (double) (e->steepness[0] + e->steepness[1]) / q->used;
    if (ntp__too_long(q) > TOO_LONG_SHARE || q->lean > LEAN_CENTERED ||
        ntp__steep_share(q) > STEEP_MOST || is_bright_and_dark(q) || is_one_channel_twice(q) ||
        ntp__blue_alike(e) > BLUE_ALIKE || ntp__is_noise(q->e))
        return false;
    double ends = (double) (s->alpha_zero + s->alpha_full) / (double) s->texels;
    bool alpha = e->used_sd[3] > ALPHA_VARIES && ends < ALPHA_ENDS_MOST;
    double sure = alpha ? XY_ALPHA_SURE : XY_SURE;
    sure = least(sure, blend(XY_LEANING_SURE, XY_ALPHA_SURE,
                             (LEAN_CENTERED - q->lean) / (LEAN_CENTERED - LEAN_SMALL)));
    sure = least(
        sure, blend(XY_NEAR_SURE, XY_ALPHA_SURE, (NEAR_UNIT_SHARE - q->near[0]) / FAR_FROM_UNIT));
    sure = least(sure, blend(XY_KEPT_SURE, XY_ALPHA_SURE,
                             (q->e->fit[0].length_sd - SPREAD_MOST) / XY_SPREAD_RANGE));
    sure = least(sure, blend(XY_SPREAD_OUT_SURE, XY_ALPHA_SURE, middle / MIDDLE_LEAST - 1));
    if (s->used_mean[2] > OPEN_BLUE)
        sure = least(sure, XY_SURE);
    if (ntp__block_step(q->e) > BLOCK_STEP)
        sure = least(sure, XY_PICTURE_SURE);
    if (e->tilted_near[0] < UNRELATED_NEAR)
        because(q, NTP_REASON_BLUE_UNRELATED, e->tilted_near[0]);
    else
        because(q, NTP_REASON_NOT_UNIT, q->near[0]);
    because(q, NTP_REASON_XY_CENTERED, q->lean);
    if (e->correlation[0] > ALIKE) {
        sure = least(sure, XY_PICTURE_SURE);
        because(q, NTP_REASON_DESPITE_ALIKE, e->correlation[0]);
    }
    if (ntp__keep_to_a_line(q->e, 0, 1))
        sure = least(sure, XY_PICTURE_SURE);
    return is(q, NTP_CLASS_XY, sure);
}

static void classify(question *q)
{
    if (is_dxt5nm(q) || is_one_color(q) || is_height(q) || is_two_channels(q) || is_gamma(q) ||
        is_blue_constant(q) || is_swapped(q) || is_object_space(q) || is_normals(q) ||
        is_padded(q) || is_compressed(q) || is_xy(q))
        return;
    if (q->near[0] < NEAR_UNIT_SHARE)
        because(q, NTP_REASON_NOT_UNIT, q->near[0]);
    if (q->too_long > TOO_LONG_SHARE)
        because(q, NTP_REASON_XY_TOO_LONG, q->too_long);
    if (q->lean > LEAN_CENTERED)
        because(q, NTP_REASON_XY_OFF_CENTER, q->lean);
    if (q->e->correlation[0] > ALIKE)
        because(q, NTP_REASON_COLORS_ALIKE, q->e->correlation[0]);
    else if (ntp__blue_alike(q->e) > ALIKE)
        because(q, NTP_REASON_BRIGHTNESS, ntp__blue_alike(q->e));
    else if (ntp__is_noise(q->e))
        because(q, NTP_REASON_NOISE, q->s->used_mean[2]);
    if (q->out->reason_count == 0)
        because(q, NTP_REASON_NOT_UNIT, q->near[0]);
    is(q, NTP_CLASS_NOT_NORMALS,
       least(blend(NOT_LEAST_SURE, NOT_SURE, (q->lean - LEAN_CENTERED) / NOT_LEAN_RANGE),
             blend(NOT_LEAST_SURE, NOT_SURE,
                   (NEAR_UNIT_SHARE - FAR_FROM_UNIT - q->near[0]) / FAR_FROM_UNIT)));
}

ntp_status ntp_classify(ntp_classification *result, ntp_tally *tally)
{
    const ntp__evidence *e;
    if (result == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__gather_evidence(&e, tally));
    memset(result, 0, sizeof *result);
    question q = { .out = result, .e = e, .s = &e->stats };
    ntp__set_shares(&q);
    classify(&q);
    return NTP_OK;
}
