/* SPDX-License-Identifier: MIT */
/*
 * counts.c - which texels count, and how much they matter
 */
#include "findings/counts.h"

/*
 * docs/findings.md gives the reasons of --max-angle 5 and --max-fail 2: a gray that a light at 45
 * degrees makes changes by 1.7 of 255 levels a degree.  These are parts of the two.
 *
 * Bright or dark dots catch the eye long before they cover as much as a fault of the whole picture:
 * a twentieth is 0.1 %, 1049 texels of 1024 x 1024.
 */
static const double SPECKS = 1.0 / 20;
/* One texel in a hundred at 2.5 degrees is 4 levels in the lines and edges that steep texels make:
 * just visible side by side. */
static const double P99_WARNING = 1.0 / 2;
/* 1 degree, 1.7 levels, over all of the picture: the least that a screen of 8 bit shows. */
static const double MEAN_WARNING = 1.0 / 5;

uint64_t counts_judged(const ntp_stats *s)
{
    return s->texels - s->unused - s->padding;
}

void counts_failing(const ntp_stats *s, ntp_encoding encoding, ntp_verdict verdict,
                    bool keep_negative_z, uint64_t *all, uint64_t *used)
{
    const ntp_fit *fit = encoding == NTP_ENCODING_ZZERO ? &s->zzero : &s->standard;
    if (encoding == NTP_ENCODING_XY) {
        *all = s->xy_too_long;
        *used = counts_xy_too_long(s);
        return;
    }
    uint64_t pass = fit->neighbor, unused_pass = fit->unused_neighbor;
    if (verdict == NTP_VERDICT_ROUNDED)
        pass = fit->rounded, unused_pass = fit->unused_rounded;
    if (verdict == NTP_VERDICT_EXACT) {
        /* unused texels are rarely exact with z mirrored, so these all count as used */
        pass = fit->exact + (keep_negative_z ? fit->exact_mirrored : 0);
        unused_pass = fit->unused_exact;
    }
    *all = s->texels - pass;
    const uint64_t left_out = s->unused - unused_pass + s->padding;
    *used = *all > left_out ? *all - left_out : 0;
}

uint64_t counts_xy_too_long(const ntp_stats *s)
{
    return s->xy_too_long - s->unused_xy_too_long - s->padding;
}

uint64_t counts_z_negative(const ntp_stats *s)
{
    return s->z_negative - s->unused_z_negative - s->padding_z_negative;
}

finding_level counts_level(const ntp_harm *harm, uint64_t judged, double max_angle, double max_fail)
{
    if (judged == 0 || harm->texels == 0)
        return LEVEL_INFO;
    const double percent = 100.0 * (double) harm->over / (double) judged;
    if (percent > max_fail)
        return LEVEL_ERROR;
    const bool visible = percent > max_fail * SPECKS || harm->p99 > max_angle * P99_WARNING ||
                         harm->mean > max_angle * MEAN_WARNING;
    return visible ? LEVEL_WARNING : LEVEL_INFO;
}

double counts_tilt(const ntp_stats *s)
{
    const double x = 2 * s->used_mean[0] - 1, y = 2 * s->used_mean[1] - 1;
    return (x < 0 ? -x : x) > (y < 0 ? -y : y) ? x : y;
}

bool counts_alpha_map(const ntp_stats *s)
{
    const uint64_t ends = s->alpha_zero + s->alpha_full;
    return s->channels == 4 && s->channel[3].min < s->channel[3].max &&
           ends < s->texels - s->texels / 20;
}

bool counts_misplaced(const ntp_classification *type, int32_t channels)
{
    const uint32_t misplaced = NTP_ACCIDENT_RED_IS_Z | NTP_ACCIDENT_GREEN_IS_Z |
                               NTP_ACCIDENT_GAMMA | (channels > 2 ? NTP_ACCIDENT_DXT5NM : 0);
    return (type->accidents & misplaced) != 0;
}
