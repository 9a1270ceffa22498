/* SPDX-License-Identifier: MIT */
/*
 * classify.c - what a texture is, from its statistics
 */
#include "internal.h"

#include <string.h>

static const double UNIT_SHARE = 0.95;

typedef struct verdict {
    ntp_classification *out;
    const ntp_stats *s;
    double used;
} verdict;

static void because(verdict *v, int32_t code, double value)
{
    if (v->out->reason_count < NTP_MAX_REASONS)
        v->out->reasons[v->out->reason_count++] = (ntp_reason) { code, value };
}

static void decide(verdict *v, ntp_class type, double confidence)
{
    v->out->type = type;
    v->out->confidence = confidence;
}

static void classify_rgb(verdict *v)
{
    const ntp_stats *s = v->s;
    double gray = (double) (s->gray - s->black - s->white) / v->used;
    double negative = (double) s->used_z_negative / v->used;
    if (gray > 0.98) {
        decide(v, NTP_CLASS_HEIGHT, 0.95);
        because(v, NTP_REASON_GRAY, gray < 1 ? gray : 1);
        return;
    }
    if (s->used_sd[2] == 0 &&
        (s->used_mean[2] < 0.9 || s->standard.used_near_unit[0] < UNIT_SHARE)) {
        v->out->accidents |= NTP_ACCIDENT_BLUE_CONSTANT;
        decide(v, NTP_CLASS_XY, 0.9);
        because(v, NTP_REASON_BLUE_CONSTANT, s->used_mean[2]);
        return;
    }
    double standard = s->standard.used_near_unit[2], zzero = s->zzero.used_near_unit[2];
    if (standard > 0.8 && standard >= zzero) {
        decide(v, NTP_CLASS_STANDARD, 0.9);
        if (negative > 0.95)
            v->out->accidents |= NTP_ACCIDENT_Z_FLIPPED;
        else if (negative > 0.05)
            decide(v, NTP_CLASS_OBJECT_SPACE, 0.8);
        because(v, NTP_REASON_NEAR_UNIT, standard);
    } else if (zzero > 0.8) {
        decide(v, NTP_CLASS_ZZERO, 0.9);
        because(v, NTP_REASON_NEAR_UNIT_ZZERO, zzero);
    } else {
        decide(v, NTP_CLASS_NOT_NORMALS, 0.7);
        because(v, NTP_REASON_NOT_UNIT, standard);
    }
}

ntp_status ntp_classify(ntp_classification *result, const ntp_stats *stats)
{
    if (result == NULL || stats == NULL || stats->texels == 0)
        return NTP_ERR_ARGUMENT;
    memset(result, 0, sizeof *result);
    uint64_t used = stats->texels - stats->unused - stats->not_finite;
    verdict v = { result, stats, (double) used };
    if (stats->distinct <= 1) {
        decide(&v, NTP_CLASS_ONE_COLOR, 1);
        because(&v, used == 0 ? NTP_REASON_NOTHING_USED : NTP_REASON_ONE_COLOR, 1);
    } else if (stats->channels == 1) {
        decide(&v, NTP_CLASS_HEIGHT, 0.99);
        because(&v, NTP_REASON_GRAY_FILE, 1);
    } else {
        classify_rgb(&v);
    }
    return NTP_OK;
}
