/* SPDX-License-Identifier: MIT */
/*
 * inspect.c - everything about one texel: its vector, its verdicts, and what cleaning makes of it
 */
#include "base/view.h"
#include "texel/angle.h"
#include "texel/level.h"

#include <math.h>
#include <string.h>

/* The vector that three levels stand for, as integer numerators over M. */
static void numerators(int64_t v[3], const int32_t c[3], int32_t m, ntp_encoding encoding)
{
    v[0] = ntp__num(c[0], m);
    v[1] = ntp__num(c[1], m);
    v[2] = encoding == NTP_ENCODING_ZZERO ? c[2] : ntp__num(c[2], m);
}

/* For XY-only: the derived z, or 0 where x, y are too long. */
static void implied_z(double *z, int64_t v[3], const int32_t c[3], int32_t m)
{
    int64_t s = ntp__rest(c[0], c[1], m);
    *z = s < 0 ? 0.0 : sqrt((double) s) / m;
    v[2] = s < 0 ? 0 : ntp__num(ntp__blue_of_rest(s, m, false), m);
}

static void describe(ntp_texel *t, const int32_t c[4], int32_t m, ntp_encoding encoding, bool keep)
{
    int32_t cleaned[3] = { c[0], c[1], c[2] };
    ntp__clean(cleaned, m, encoding, NTP_CLEAN_DERIVE, keep);
    for (int32_t k = 0; k < 4; k++) {
        t->stored[k] = (uint32_t) c[k];
        if (k < 3)
            t->cleaned[k] = (uint32_t) cleaned[k];
    }
    t->max = (uint32_t) m;
    t->flags = ntp__flags(c[0], c[1], c[2], m, encoding, keep);
    if (ntp__unused(c[0], c[1], c[2], c[3], m, 0))
        t->flags |= NTP_FLAG_UNUSED;

    int64_t s = ntp__rest(c[0], c[1], m);
    bool negative = encoding == NTP_ENCODING_STANDARD && ntp__z_negative(c[2], m);
    t->levels_off = -1;
    if (s >= 0) {
        int32_t b = ntp__blue_of_rest(s, m, encoding == NTP_ENCODING_ZZERO);
        t->levels_off =
            encoding == NTP_ENCODING_XY ? 0 : ntp__abs((negative ? m - c[2] : c[2]) - b);
    }
    int64_t v[3], w[3];
    numerators(v, c, m, encoding);
    numerators(w, cleaned, m, encoding);
    t->x = (double) v[0] / m;
    t->y = (double) v[1] / m;
    t->z = (double) v[2] / m;
    if (encoding == NTP_ENCODING_XY) {
        double unused_z;
        implied_z(&t->z, v, c, m);
        implied_z(&unused_z, w, cleaned, m);
    }
    t->length = sqrt(t->x * t->x + t->y * t->y + t->z * t->z);
    t->angle = ntp__angle(v[0], v[1], v[2], w[0], w[1], w[2]) / 1e6;
}

/* A texel that is not a vector is cleaned to the flat normal. */
static void flat_cleaned(ntp_texel *t, ntp_encoding encoding)
{
    t->cleaned[0] = t->cleaned[1] = (t->max + 1) / 2;
    if (encoding != NTP_ENCODING_XY)
        t->cleaned[2] = t->max;
    t->levels_off = -1;
    t->angle = 0.0;
}

ntp_status ntp_inspect(ntp_texel *texel, const ntp_const_image *src, int32_t x, int32_t y,
                       int32_t keep_negative_z)
{
    if (texel == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_normals(src));
    if (x < 0 || y < 0 || x >= src->width || y >= src->height)
        return NTP_ERR_ARGUMENT;
    ntp__block block;
    ntp__unpack(&block, src, x, y, 1);
    int32_t c[4] = { block.c[0][0], block.c[1][0], block.c[2][0], block.c[3][0] };
    ntp_encoding encoding =
        src->encoding == NTP_ENCODING_VECTOR ? NTP_ENCODING_STANDARD : src->encoding;
    memset(texel, 0, sizeof *texel);
    describe(texel, c, ntp__max(src->type), encoding, keep_negative_z != 0);
    if (block.any_broken) {
        texel->flags &= ~(uint32_t) (NTP_FLAG_NEIGHBOR | NTP_FLAG_ROUNDED | NTP_FLAG_EXACT);
        texel->flags |= NTP_FLAG_NOT_FINITE;
        flat_cleaned(texel, encoding);
    }
    return NTP_OK;
}
