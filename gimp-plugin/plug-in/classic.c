/* SPDX-License-Identifier: MIT */
/*
 * classic.c - the old arguments, one by one
 */
#include "classic.h"

#include <string.h>

enum { /* conversions */
       BIASED_RGB = 1,
       NORMALIZE_ONLY = 8,
       DUDV_TO_NORMAL = 9,
       TO_HEIGHT = 10
};

/* The names under which ntp_normals_like knows the filters. */
static const char *const filters[] = { "gimp-normalmap:4sample",  "gimp-normalmap:sobel3",
                                       "gimp-normalmap:sobel5",   "gimp-normalmap:prewitt3",
                                       "gimp-normalmap:prewitt5", "gimp-normalmap:3x3",
                                       "gimp-normalmap:5x5",      "gimp-normalmap:7x7",
                                       "gimp-normalmap:9x9" };

static const ntp_height_source height_sources[] = {
    NTP_HEIGHT_SOURCE_LUMA_GIMP, NTP_HEIGHT_SOURCE_LUMA_GIMP, NTP_HEIGHT_SOURCE_RED,
    NTP_HEIGHT_SOURCE_GREEN,     NTP_HEIGHT_SOURCE_BLUE,      NTP_HEIGHT_SOURCE_MAX,
    NTP_HEIGHT_SOURCE_MIN,       NTP_HEIGHT_SOURCE_SCREEN
};

static const alpha_rule alpha_rules[] = { ALPHA_KEEP, ALPHA_HEIGHT, ALPHA_INVERSE_HEIGHT,
                                          ALPHA_ZERO, ALPHA_ONE,    ALPHA_INVERSE,
                                          ALPHA_LAYER };

static normals_job normals_of(const settings *s, alpha_rule alpha, dudv_format dudv, bool has_alpha)
{
    const double *v = s->value;
    const int conversion = (int) v[FO_CONVERSION];
    ntp_peer peer;
    normals_job job = { .forms = { 0, 1, 1, 1 } };
    if (ntp_normals_like(&peer, filters[(int) v[FO_FILTER]], v[FO_SCALE]) != NTP_OK)
        return job;
    job.how = peer.options;
    job.how.min_z = v[FO_MIN_Z];
    job.how.border_x = job.how.border_y = v[FO_WRAP] != 0 ? NTP_BORDER_WRAP : NTP_BORDER_CLAMP;
    if (v[FO_HEIGHT_SOURCE] != 0 && has_alpha) {
        job.how.source = NTP_HEIGHT_SOURCE_ALPHA;
    } else {
        job.how.source = height_sources[conversion];
        job.biased = conversion == BIASED_RGB;
    }
    job.alpha = alpha;
    job.dudv = dudv;
    if (alpha == ALPHA_HEIGHT)
        job.how.alpha = NTP_ALPHA_HEIGHT;
    if (alpha == ALPHA_INVERSE_HEIGHT)
        job.how.alpha = NTP_ALPHA_INVERSE_HEIGHT;
    job.swap = v[FO_SWAP] != 0;
    job.y = v[FO_FLIP_Y] != 0 ? NTP_Y_UP : NTP_Y_DOWN;
    if (v[FO_FLIP_X] != 0) {
        job.how.scale = -job.how.scale;
        job.y = job.y == NTP_Y_UP ? NTP_Y_DOWN : NTP_Y_UP;
    }
    return job;
}

static repair_job repair_of(const settings *s, alpha_rule alpha, dudv_format dudv)
{
    const double *v = s->value;
    repair_job job = {
        .from = (int) v[FO_CONVERSION] == DUDV_TO_NORMAL ? NTP_ENCODING_XY : NTP_ENCODING_STANDARD,
        .derive = (int) v[FO_CONVERSION] == DUDV_TO_NORMAL,
        .alpha_is_data = true,
        .strengthen = v[FO_SCALE] != 1,
        .strength = v[FO_SCALE],
        .min_z = v[FO_MIN_Z],
        .flip_x = v[FO_FLIP_X] != 0,
        .flip_y = v[FO_FLIP_Y] != 0,
        .swap = v[FO_SWAP] != 0,
        .dudv = dudv,
        .alpha = alpha == ALPHA_HEIGHT || alpha == ALPHA_INVERSE_HEIGHT ? ALPHA_KEEP : alpha,
        .how = { .method = NTP_CLEAN_NORMALIZE, .keep_negative_z = 1 },
    };
    job.clean = !job.derive;
    if (job.strength > NTP_MAX_STRENGTH)
        job.strength = NTP_MAX_STRENGTH;
    if (job.strength < -NTP_MAX_STRENGTH)
        job.strength = -NTP_MAX_STRENGTH;
    return job;
}

static height_job height_of(const settings *s)
{
    const ntp_border border = s->value[FO_WRAP] != 0 ? NTP_BORDER_WRAP : NTP_BORDER_EXTRAPOLATE;
    return (height_job) { .how = { .border_x = border, .border_y = border },
                          .y = NTP_Y_DOWN,
                          .encoding = NTP_ENCODING_STANDARD,
                          .contrast = s->value[FO_CONTRAST] };
}

classic_job classic_job_from(const settings *s, int32_t channels, ntp_type type)
{
    const double *v = s->value;
    const bool has_alpha = channels % 2 == 0;
    const int conversion = (int) v[FO_CONVERSION];
    dudv_format dudv = (dudv_format) v[FO_DUDV];
    classic_job job = { .alpha = alpha_rules[(int) v[FO_ALPHA]] };
    if (dudv >= DUDV_16_SIGNED && type == NTP_TYPE_U8 && !has_alpha)
        dudv = DUDV_NONE; /* as in the old plug-in: there is no room for them */
    if (!has_alpha || dudv != DUDV_NONE)
        job.alpha = ALPHA_KEEP;
    job.kind = conversion == TO_HEIGHT        ? CLASSIC_HEIGHT
               : conversion >= NORMALIZE_ONLY ? CLASSIC_REPAIR
                                              : CLASSIC_NORMALS;
    if (job.kind == CLASSIC_NORMALS) {
        job.normals = normals_of(s, job.alpha, dudv, has_alpha);
        return job;
    }
    job.repair = repair_of(s, job.alpha, job.kind == CLASSIC_HEIGHT ? DUDV_NONE : dudv);
    job.height = height_of(s);
    return job;
}
