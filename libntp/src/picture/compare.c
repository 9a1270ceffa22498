/* SPDX-License-Identifier: MIT */
/*
 * compare.c - differences between two textures, in levels and as angles between vectors
 *
 * b is converted to the encoding and y of a at its own depth, by the rules of ntp_convert.  Then
 * the levels of an 8-bit image count 257 each if the other image is deeper.  Only integers are kept
 * of levels and angles, so that parts add up exactly.
 */
#include "texel/angle.h"
#include "texel/level.h"
#include "picture/picture.h"

#include <string.h>

struct ntp_diff {
    uint32_t max; /* M of the levels; 0: nothing yet */
    uint32_t channels, vectors;
    uint64_t texels, different;
    uint32_t levels_max[4];
    uint64_t levels_sum[4];
    ntp__angle_sums angles;
};

enum {
    HEAT_FULL = 10000000, /* micro-degrees at and above which the heat is full red */
    HEAT_STEPS = 510,     /* blue to green and green to red, 255 each */
    HALF_TURN = 180000000 /* for the heat, a height difference of M counts as this angle */
};

typedef struct job {
    ntp_diff *diff;
    const ntp_image *heat;
    const ntp_const_image *a, *b;
    ntp_encoding encoding_a, encoding_b; /* a vector's levels are standard ones */
    int32_t ma, mb, m;
    int32_t channels;
    bool vectors, flip;
} job;

/* One texel of one image. */
typedef struct texel {
    int32_t c[4];
    bool unused, broken;
} texel;

static texel fetch(const ntp__block *block, int32_t i, int32_t m, bool vectors)
{
    texel t = { { block->c[0][i], block->c[1][i], block->c[2][i], block->c[3][i] }, false, false };
    t.broken = block->any_broken && block->broken[i];
    t.unused = vectors && !t.broken && ntp__unused(t.c[0], t.c[1], t.c[2], t.c[3], m, 0);
    if (t.broken && vectors) {
        t.c[0] = t.c[1] = (m + 1) / 2;
        t.c[2] = m;
    }
    return t;
}

/* Numerators of the vector over M.  The M of the two images may differ. */
static void decode(int64_t v[3], const texel *t, int32_t m, ntp_encoding encoding)
{
    v[0] = ntp__num(t->c[0], m);
    v[1] = ntp__num(t->c[1], m);
    if (encoding == NTP_ENCODING_XY) {
        int64_t rest = ntp__rest(t->c[0], t->c[1], m);
        v[2] = rest < 0 ? 0 : ntp__num(ntp__blue_of_rest(rest, m, false), m);
    } else {
        v[2] = encoding == NTP_ENCODING_ZZERO ? t->c[2] : ntp__num(t->c[2], m);
    }
}

static uint32_t angle_between(const job *j, const texel *a, const texel *b)
{
    int64_t v[3], w[3];
    if (a->unused && b->unused)
        return 0;
    decode(v, a, j->ma, j->encoding_a);
    decode(w, b, j->mb, j->encoding_b);
    if (j->ma == j->mb && v[0] == w[0] && v[1] == w[1] && v[2] == w[2])
        return 0;
    return ntp__angle(v[0], v[1], v[2], w[0], w[1], w[2]);
}

/* The blue of b in the encoding of a, where the two store z differently. */
static int32_t blue_as_in_a(const job *j, const texel *b)
{
    int32_t m = j->mb, blue = b->c[2];
    bool zzero = j->encoding_b == NTP_ENCODING_ZZERO, negative = !zzero && ntp__z_negative(blue, m);
    int64_t rest = ntp__rest(b->c[0], b->c[1], m);
    if (rest >= 0 && ntp__blue_of_rest(rest, m, zzero) == (negative ? m - blue : blue))
        return ntp__blue_of_rest(rest, m, !zzero);
    return zzero ? (blue + m + 1) / 2 : ntp__abs(ntp__num(blue, m));
}

static int32_t deepen(int32_t level, int32_t from, int32_t to)
{
    return from == to ? level : level * 257;
}

static uint32_t compare_texel(const job *j, texel *a, texel *b, bool *equal)
{
    ntp_diff *d = j->diff;
    if (j->flip && !b->unused && !b->broken)
        b->c[1] = j->mb - b->c[1];
    uint32_t angle = j->vectors ? angle_between(j, a, b) : 0;
    if (j->channels > 2 && j->encoding_a != j->encoding_b && !b->unused)
        b->c[2] = blue_as_in_a(j, b);
    *equal = a->broken == b->broken;
    uint32_t greatest = 0;
    for (int32_t k = 0; k < j->channels; k++) {
        /* A gray image with alpha is unpacked with alpha in the fourth plane. */
        int32_t plane = !j->vectors && j->channels == 2 && k == 1 ? 3 : k;
        int32_t off = deepen(a->c[plane], j->ma, j->m) - deepen(b->c[plane], j->mb, j->m);
        uint32_t size = (uint32_t) ntp__abs(off);
        d->levels_sum[k] += size;
        if (size > d->levels_max[k])
            d->levels_max[k] = size;
        greatest = size > greatest ? size : greatest;
    }
    *equal = *equal && greatest == 0;
    d->different += !*equal;
    if (!j->vectors)
        return (uint32_t) ((uint64_t) greatest * HALF_TURN / (uint64_t) j->m);
    ntp__angles_add(&d->angles, angle, 1);
    return angle;
}

static void paint_heat(uint8_t rgb[3], uint32_t angle, bool equal)
{
    uint64_t capped = angle < HEAT_FULL ? angle : HEAT_FULL;
    int32_t step = (int32_t) ((capped * HEAT_STEPS + HEAT_FULL / 2) / HEAT_FULL);
    bool lower = step <= 255;
    rgb[0] = (uint8_t) (lower ? 0 : step - 255);
    rgb[1] = (uint8_t) (lower ? step : HEAT_STEPS - step);
    rgb[2] = (uint8_t) (lower ? 255 - step : 0);
    if (equal && angle == 0)
        rgb[0] = rgb[1] = rgb[2] = 0;
}

static void compare_run(const job *j, int32_t x, int32_t y, int32_t n)
{
    ntp__block a, b;
    ntp__unpack(&a, j->a, x, y, n);
    ntp__unpack(&b, j->b, x, y, n);
    uint8_t *d = j->heat != NULL ? ntp__at_mut(j->heat, x, y) : NULL;
    for (int32_t i = 0; i < n; i++) {
        texel ta = fetch(&a, i, j->ma, j->vectors), tb = fetch(&b, i, j->mb, j->vectors);
        bool equal;
        uint32_t angle = compare_texel(j, &ta, &tb, &equal);
        if (d == NULL)
            continue;
        uint8_t rgb[3];
        paint_heat(rgb, angle, equal);
        ntp__paint(d + i * j->heat->pixel_stride, j->heat->channels, rgb);
    }
}

static ntp_status prepare(job *j, const ntp_const_image *a, const ntp_const_image *b)
{
    if (!ntp__same_size(a, b))
        return NTP_ERR_SHAPE;
    j->vectors = a->encoding != NTP_ENCODING_HEIGHT;
    if (j->vectors != (b->encoding != NTP_ENCODING_HEIGHT) ||
        (!j->vectors && a->channels != b->channels))
        return NTP_ERR_FORMAT;
    j->encoding_a = a->encoding == NTP_ENCODING_VECTOR ? NTP_ENCODING_STANDARD : a->encoding;
    j->encoding_b = b->encoding == NTP_ENCODING_VECTOR ? NTP_ENCODING_STANDARD : b->encoding;
    j->ma = ntp__max(a->type);
    j->mb = ntp__max(b->type);
    j->m = j->ma > j->mb ? j->ma : j->mb;
    j->flip = j->vectors && a->y != b->y;
    j->channels = a->channels < b->channels ? a->channels : b->channels;
    if ((j->encoding_a == NTP_ENCODING_XY) != (j->encoding_b == NTP_ENCODING_XY))
        j->channels = 2;
    return NTP_OK;
}

/* May this many more texels of this kind be added? */
static ntp_status accept(const ntp_diff *d, uint32_t max, uint32_t channels, uint32_t vectors,
                         uint64_t texels)
{
    if (d->max != 0 && (d->max != max || d->channels != channels || d->vectors != vectors))
        return NTP_ERR_FORMAT;
    return d->texels + texels > UINT32_MAX ? NTP_ERR_SHAPE : NTP_OK;
}

size_t ntp_diff_size(void)
{
    return sizeof(ntp_diff);
}

ntp_status ntp_diff_add(ntp_diff *diff, const ntp_image *heat, const ntp_const_image *a,
                        const ntp_const_image *b, const ntp_rect *area)
{
    if (diff == NULL)
        return NTP_ERR_ARGUMENT;
    NTP__TRY(ntp__check_view(a));
    NTP__TRY(ntp__check_view(b));
    job j = { .diff = diff, .heat = heat, .a = a, .b = b };
    NTP__TRY(prepare(&j, a, b));
    if (heat != NULL) {
        NTP__TRY(ntp__check_painting(heat, a, 3));
        NTP__TRY(ntp__check_painting(heat, b, 3));
    }
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, a, area));
    uint64_t texels = (uint64_t) (rect.x1 - rect.x0) * (uint64_t) (rect.y1 - rect.y0);
    NTP__TRY(accept(diff, (uint32_t) j.m, (uint32_t) j.channels, j.vectors, texels));
    diff->max = (uint32_t) j.m;
    diff->channels = (uint32_t) j.channels;
    diff->vectors = j.vectors;
    diff->texels += texels;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x += NTP__BLOCK) {
            int32_t n = rect.x1 - x < NTP__BLOCK ? rect.x1 - x : NTP__BLOCK;
            compare_run(&j, x, y, n);
        }
    }
    return NTP_OK;
}

ntp_status ntp_diff_merge(ntp_diff *into, const ntp_diff *from)
{
    if (into == NULL || from == NULL || into == from)
        return NTP_ERR_ARGUMENT;
    if (from->max == 0)
        return NTP_OK;
    NTP__TRY(accept(into, from->max, from->channels, from->vectors, from->texels));
    into->max = from->max;
    into->channels = from->channels;
    into->vectors = from->vectors;
    into->texels += from->texels;
    into->different += from->different;
    for (int32_t k = 0; k < 4; k++) {
        into->levels_sum[k] += from->levels_sum[k];
        if (from->levels_max[k] > into->levels_max[k])
            into->levels_max[k] = from->levels_max[k];
    }
    ntp__angles_merge(&into->angles, &from->angles);
    return NTP_OK;
}

ntp_status ntp_diff_clear(ntp_diff *diff)
{
    if (diff == NULL)
        return NTP_ERR_ARGUMENT;
    ntp__angles_clear(&diff->angles);
    memset(diff, 0, offsetof(ntp_diff, angles));
    return NTP_OK;
}

ntp_status ntp_diff_summarize(ntp_diff_stats *stats, const ntp_diff *diff)
{
    if (stats == NULL || diff == NULL || diff->max == 0)
        return NTP_ERR_ARGUMENT;
    memset(stats, 0, sizeof *stats);
    stats->texels = diff->texels;
    stats->different = diff->different;
    stats->max = diff->max;
    stats->channels = (int32_t) diff->channels;
    for (uint32_t k = 0; k < diff->channels; k++) {
        stats->levels_max[k] = diff->levels_max[k];
        stats->levels_mean[k] = (double) diff->levels_sum[k] / (double) diff->texels;
    }
    ntp__angles_describe(&stats->angles, &diff->angles);
    return NTP_OK;
}
