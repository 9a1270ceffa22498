/* SPDX-License-Identifier: MIT */
/*
 * choose_method.c - how to clean a texture, judged by its errors
 *
 * Where blue alone is wrong, red and green are still right, and blue is derived from them.  Where
 * all three channels are off, as after compression or filtering, the direction of the whole vector
 * is the best that is left, and it is normalized.  The length tells the two apart.  An error of z
 * counts in the length by a factor of z, so it fades where texels are steep.  Errors of x and y do
 * not.
 */
#include "classify/question.h"
#include "classify/thresholds.h"
#include "base/view.h"

/* The length error of steep texels over that of shallow ones; 0: it cannot be told. */
static double steep_over_shallow(const ntp__evidence *e, double used)
{
    double few = STEEP_LEAST * used;
    double steep = ntp__length_error(e, STEEP_BIN, STEEP_BIN + COMPARED_BINS);
    double shallow = ntp__length_error(e, SHALLOW_BIN, SHALLOW_BIN + COMPARED_BINS);
    bool enough = ntp__count_bins(e, STEEP_BIN, STEEP_BIN + COMPARED_BINS) > few &&
                  ntp__count_bins(e, SHALLOW_BIN, SHALLOW_BIN + COMPARED_BINS) > few;
    return enough && shallow > 0 ? steep / shallow : 0;
}

/* All texels are short by one factor: of the vector, or of z?  The steepest and the flattest bin
 * that hold enough texels tell.  The error in the one over that in the other is 1 for the vector,
 * and for z it is the ratio of their z squared. */
static ntp_clean_method method_of_factor(const ntp__evidence *e, double used, ntp_reason *why)
{
    int32_t flat = -1, steep = -1;
    for (int32_t i = 0; i < NTP__STEEPNESS_BINS - 1; i++) {
        if ((double) e->steepness[i] > STEEP_LEAST * used) {
            flat = flat < 0 ? i : flat;
            steep = i;
        }
    }
    why->code = NTP_REASON_TOO_FLAT;
    why->value = 0;
    if (flat == steep)
        return NTP_CLEAN_DERIVE;
    double low = (flat + 0.5) / NTP__STEEPNESS_BINS, high = (steep + 0.5) / NTP__STEEPNESS_BINS;
    double of_z = (1 - high * high) / (1 - low * low);
    double ratio = e->steepness_length_error[steep] / e->steepness_length_error[flat];
    bool all = ratio > (1 + of_z) / 2 && (of_z < OF_Z_TELLS || e->blue_slope > 1);
    why->code = all ? NTP_REASON_ALL_CHANNELS : NTP_REASON_Z_ALONE;
    why->value = ratio;
    return all ? NTP_CLEAN_NORMALIZE : NTP_CLEAN_DERIVE;
}

static ntp_clean_method method_of_errors(const ntp__evidence *e, bool zzero, double used,
                                         ntp_reason *why)
{
    const ntp_fit *counts = zzero ? &e->stats.zzero : &e->stats.standard;
    const ntp__fit_evidence *fit = &e->fit[zzero];
    double wrong = 1 - (double) (counts->neighbor - counts->unused_neighbor) / used;
    double off = 1 - fit->length_mean;
    double square = fit->length_sd * fit->length_sd + off * off;
    *why = (ntp_reason) { NTP_REASON_FEW_WRONG, wrong };
    if (wrong > 0 && wrong < FEW_SHARE &&
        square - ROUNDING_SQUARE > GROSS_ERROR * GROSS_ERROR * wrong)
        return NTP_CLEAN_DERIVE;
    if (!zzero && off > FACTOR_LEAST && fit->too_short > ALL_SHORT &&
        (fit->length_sd < FACTOR_SPREAD * off || e->blue_correlation > FACTOR_FOLLOWS))
        return method_of_factor(e, used, why);
    *why = (ntp_reason) { NTP_REASON_SHORT, fit->too_short };
    if (fit->too_short > ONE_SIDED * fit->too_long)
        return NTP_CLEAN_NORMALIZE;
    *why = (ntp_reason) { NTP_REASON_LONG, fit->too_long };
    if (-off > LONG_LEAST && fit->too_long > ONE_SIDED * fit->too_short)
        return NTP_CLEAN_DERIVE;
    double ratio = zzero ? 0 : steep_over_shallow(e, used);
    *why = (ntp_reason) { NTP_REASON_TOO_FLAT, 0 };
    if (ratio == 0)
        return NTP_CLEAN_DERIVE;
    bool all = ratio > STEEP_OVER_SHALLOW;
    *why = (ntp_reason) { all ? NTP_REASON_ALL_CHANNELS : NTP_REASON_Z_ALONE, ratio };
    return all ? NTP_CLEAN_NORMALIZE : NTP_CLEAN_DERIVE;
}

ntp_status ntp_choose_method(ntp_clean_method *method, ntp_reason *why, ntp_tally *tally,
                             ntp_encoding encoding, int32_t lossy)
{
    const ntp__evidence *e;
    ntp_reason unwanted;
    if (why == NULL)
        why = &unwanted;
    if (method == NULL || (encoding != NTP_ENCODING_STANDARD && encoding != NTP_ENCODING_ZZERO &&
                           encoding != NTP_ENCODING_XY))
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__gather_evidence(&e, tally));
    bool zzero = encoding == NTP_ENCODING_ZZERO;
    const ntp_stats *stats = &e->stats;
    const ntp_fit *fit = zzero ? &stats->zzero : &stats->standard;
    uint64_t used = stats->texels - stats->unused;
    double judged = (double) (used - e->padding);
    double sign = e->used_z_negative > used / 2 && !zzero ? -1 : 1;
    bool follows = sign * e->blue_correlation > UNRELATED;
    if (encoding == NTP_ENCODING_XY) {
        *method = NTP_CLEAN_DERIVE;
        *why = (ntp_reason) { NTP_REASON_XY_ONLY, 0 };
    } else if (fit->rounded - fit->unused_rounded == used) {
        *method = NTP_CLEAN_KEEP;
        *why = (ntp_reason) { NTP_REASON_ALL_ROUNDED, 1 };
    } else if (ntp__blue_is_idle(e)) {
        bool constant = e->used_sd[2] < CONSTANT_DEVIATION;
        *method = NTP_CLEAN_DERIVE;
        why->code = constant ? NTP_REASON_BLUE_CONSTANT : NTP_REASON_BLUE_IDLE;
        why->value = stats->used_mean[2];
    } else if (lossy) {
        *method = NTP_CLEAN_NORMALIZE;
        *why = (ntp_reason) { NTP_REASON_LOSSY_FILE, 1 };
    } else {
        *method = method_of_errors(e, zzero, judged, why);
        if (!follows && e->fit[zzero].near_unit[2] < UNRELATED_UNIT_SHARE &&
            why->code != NTP_REASON_FEW_WRONG) {
            *method = NTP_CLEAN_DERIVE;
            *why = (ntp_reason) { NTP_REASON_BLUE_UNRELATED, e->tilted_near[zzero] };
        }
    }
    return NTP_OK;
}
