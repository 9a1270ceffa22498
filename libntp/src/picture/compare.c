/* SPDX-License-Identifier: MIT */
/*
 * compare.c - differences between two textures, in levels and as angles between vectors
 *
 * b is converted to the encoding and y of a at its own depth, by the rules of ntp_convert.  Then
 * the levels of an 8-bit image count 257 each if the other image is deeper.  Only integers are kept
 * of levels and angles, so that parts add up exactly.
 */
#include "texel/angle.h"
#include "texel/direction.h"
#include "texel/level.h"
#include "texel/unused.h"
#include "picture/picture.h"
#include "picture/picture_kernels.h"
#ifdef NTP_HAVE_AVX2
#  include "picture/compare_avx2.h"
#endif

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
    UNEQUAL = 1 << 16,    /* a texel that is a vector in one image only, beside its levels */
    HALF_TURN =
        180000000 /* micro-degrees; for the heat, a height difference of M counts as this angle */
};

typedef struct job {
    ntp_diff *diff;
    const ntp_image *heat;
    const ntp_const_image *a, *b;
    ntp_encoding encoding_a, encoding_b; /* a vector's levels are standard ones */
    int32_t ma, mb, m;
    int32_t channels;
    bool vectors, flip;
    bool alike; /* equal bytes are equal texels, and only sums are asked for */
    const ntp__kernels_table *kernels;
#ifdef NTP_HAVE_AVX2
    ntp__compare_rgb *compare_rgb; /* for texels that are also alike and packed RGB; or NULL */
    int32_t fullest;               /* of the bins, as it takes it */
#endif
    int32_t span; /* texels it is given: few after equal ones, for more of these may come */
} job;

/* A block of one image. */
typedef struct side {
    ntp__block block;
    ntp__block derived;       /* of an image without blue: z as a numerator */
    uint8_t none[NTP__BLOCK]; /* not 0: unused or broken, so it is not flipped */
    bool any_none;
} side;

static void fetch(const job *j, side *s, const ntp_const_image *view, int32_t m, int32_t x,
                  int32_t y, int32_t n)
{
    ntp__block *block = &s->block;
    ntp__unpack(block, view, x, y, n);
    ntp__fill_group(block, n);
    s->any_none = j->vectors && ntp__any_suspect(block, n, m);
    for (int32_t i = 0; s->any_none && i < n; i++) {
        s->none[i] = ntp__texel_unused(block, i, m, 0);
        if (block->any_broken && block->broken[i]) {
            block->c[0][i] = block->c[1][i] = (m + 1) / 2;
            block->c[2][i] = m;
        }
    }
}

/* Is the texel unused?  Broken ones are not. */
static bool is_unused(const side *s, int32_t i)
{
    return s->any_none && s->none[i] && !(s->block.any_broken && s->block.broken[i]);
}

/* The vectors of a side.  The M of the two images may differ. */
static ntp__numbers decode(const job *j, side *s, int32_t n, int32_t m, ntp_encoding encoding)
{
    const bool zzero = encoding == NTP_ENCODING_ZZERO;
    ntp__numbers v = {
        .c = { s->block.c[0], s->block.c[1], s->block.c[2] },
        .m = m,
        .doubled = -1,
        .less = m,
        .doubled_z = zzero ? 0 : -1,
        .less_z = zzero ? 0 : m,
    };
    if (encoding != NTP_ENCODING_XY)
        return v;
    ntp__block *derived = &s->derived;
    *derived = s->block;
    j->kernels->derive(derived->c[2], derived->c[0], derived->c[1], ntp__whole(n), m, 0);
    for (int32_t i = 0; i < ntp__whole(n); i++)
        derived->c[2][i] = derived->c[2][i] < 0 ? 0 : ntp__num(derived->c[2][i], m);
    for (int k = 0; k < 3; k++)
        v.c[k] = derived->c[k];
    v.doubled_z = v.less_z = 0;
    return v;
}

static void find_angles(const job *j, int32_t *angle, side *a, side *b, int32_t n)
{
    const ntp__numbers v = decode(j, a, n, j->ma, j->encoding_a);
    const ntp__numbers w = decode(j, b, n, j->mb, j->encoding_b);
    j->kernels->angles(angle, &v, &w, n);
    for (int32_t i = 0; a->any_none && i < n; i++)
        angle[i] = is_unused(a, i) && is_unused(b, i) ? 0 : angle[i];
}

/* The blue of b in the encoding of a, where the two store z differently. */
static int32_t blue_as_in_a(const job *j, const ntp__block *b, int32_t i)
{
    int32_t m = j->mb, blue = b->c[2][i];
    bool zzero = j->encoding_b == NTP_ENCODING_ZZERO, negative = !zzero && ntp__z_negative(blue, m);
    int64_t rest = ntp__rest(b->c[0][i], b->c[1][i], m);
    if (rest >= 0 && ntp__blue_of_rest(rest, m, zzero) == (negative ? m - blue : blue))
        return ntp__blue_of_rest(rest, m, !zzero);
    return zzero ? (blue + m + 1) / 2 : ntp__abs(ntp__num(blue, m));
}

/* Puts the levels of b into what those of a are in. */
static void match(const job *j, side *b, int32_t n)
{
    for (int32_t i = 0; j->flip && i < n; i++)
        b->block.c[1][i] ^= b->any_none && b->none[i] ? 0 : j->mb;
}

/* Adds up the differences of channel k, and puts the greatest of each texel into `greatest`. */
static void add_channel(const job *j, int32_t *restrict greatest, const ntp__block *restrict a,
                        const ntp__block *restrict b, int32_t k, int32_t n)
{
    const int32_t by_a = j->m / j->ma, by_b = j->m / j->mb;
    /* A gray image with alpha is unpacked with alpha in the fourth plane. */
    const int32_t plane = !j->vectors && j->channels == 2 && k == 1 ? 3 : k;
    int32_t most = (int32_t) j->diff->levels_max[k];
    j->diff->levels_sum[k] += (uint64_t) ntp__picture_loops()->differ(
        greatest, &most, a->c[plane], b->c[plane], by_a, by_b, ntp__whole(n));
    j->diff->levels_max[k] = (uint32_t) most;
}

/* Where greatest becomes 0, the texels are equal. */
static void add_levels(const job *j, int32_t *greatest, side *a, side *b, int32_t n)
{
    int32_t different = 0;
    for (int32_t i = 0; j->channels > 2 && j->encoding_a != j->encoding_b && i < n; i++) {
        if (!is_unused(b, i))
            b->block.c[2][i] = blue_as_in_a(j, &b->block, i);
    }
    memset(greatest, 0, (size_t) ntp__whole(n) * sizeof *greatest);
    for (int32_t k = 0; k < j->channels; k++)
        add_channel(j, greatest, &a->block, &b->block, k, n);
    for (int32_t i = 0; i < n && (a->block.any_broken || b->block.any_broken); i++) {
        bool broken_a = a->block.any_broken && a->block.broken[i];
        bool broken_b = b->block.any_broken && b->block.broken[i];
        greatest[i] |= (broken_a != broken_b) ? UNEQUAL : 0;
    }
    for (int32_t i = 0; i < n; i++)
        different += greatest[i] != 0;
    j->diff->different += (uint64_t) different;
}

static void paint_heat(uint8_t rgb[3], int32_t angle, bool equal)
{
    int64_t capped = angle < HEAT_FULL ? angle : HEAT_FULL;
    int32_t step = (int32_t) ((capped * HEAT_STEPS + HEAT_FULL / 2) / HEAT_FULL);
    bool lower = step <= 255;
    rgb[0] = (uint8_t) (lower ? 0 : step - 255);
    rgb[1] = (uint8_t) (lower ? step : HEAT_STEPS - step);
    rgb[2] = (uint8_t) (lower ? 255 - step : 0);
    if (equal && angle == 0)
        rgb[0] = rgb[1] = rgb[2] = 0;
}

static void paint(const job *j, const int32_t *angle, const int32_t *greatest, int32_t x, int32_t y,
                  int32_t n)
{
    uint8_t *d = ntp__at_mut(j->heat, x, y);
    for (int32_t i = 0; i < n; i++, d += j->heat->pixel_stride) {
        uint8_t rgb[3];
        int64_t height = (int64_t) (greatest[i] & ~UNEQUAL) * HALF_TURN / j->m;
        paint_heat(rgb, j->vectors ? angle[i] : (int32_t) height, greatest[i] == 0);
        ntp__paint(d, j->heat->channels, rgb);
    }
}

static void add_angles(ntp__angle_sums *sums, int32_t *angle, int32_t n)
{
    int32_t bin[NTP__BLOCK + 1], most = (int32_t) sums->max;
    for (int32_t i = n; i < ntp__whole(n); i++)
        angle[i] = 0;
    sums->texels += (uint64_t) n;
    sums->sum += ntp__picture_loops()->bins(bin, &most, angle, ntp__whole(n));
    sums->max = (uint64_t) most;
    ntp__count_angles(sums->bins, bin, n);
}

static void compare_run(const job *j, int32_t x, int32_t y, int32_t n)
{
    side a, b;
    int32_t angle[NTP__BLOCK], greatest[NTP__BLOCK];
    fetch(j, &a, j->a, j->ma, x, y, n);
    fetch(j, &b, j->b, j->mb, x, y, n);
    match(j, &b, n);
    if (j->vectors)
        find_angles(j, angle, &a, &b, n);
    add_levels(j, greatest, &a, &b, n);
    if (j->vectors)
        add_angles(&j->diff->angles, angle, n);
    if (j->heat != NULL)
        paint(j, angle, greatest, x, y, n);
}

/* Adds n texels of equal bytes; false: they are not. */
static bool add_equal(const job *j, const void *a, const void *b, int32_t n)
{
    if (!j->alike || memcmp(a, b, (size_t) n * (size_t) j->a->pixel_stride) != 0)
        return false;
    if (j->vectors)
        ntp__angles_add(&j->diff->angles, 0, (uint32_t) n);
    return true;
}

#ifdef NTP_HAVE_AVX2
static void add_compared(ntp_diff *d, const ntp__compared *c, int32_t n)
{
    for (int32_t k = 0; k < 3; k++) {
        d->levels_sum[k] += c->sum[k];
        d->levels_max[k] = c->most[k] > d->levels_max[k] ? c->most[k] : d->levels_max[k];
    }
    d->different += (uint64_t) c->different;
    d->angles.sum += c->sum[ANGLES] - (uint64_t) ROUND_BIN * (uint32_t) c->found;
    if (c->most[ANGLES] > d->angles.max + ROUND_BIN)
        d->angles.max = c->most[ANGLES] - ROUND_BIN;
    /* The number of zeros, or less that of zeros beyond n. */
    d->angles.texels += (uint64_t) n - (uint64_t) c->left;
    d->angles.bins[0] += (uint32_t) n - (uint32_t) (c->found + c->left);
}

static void add_left(const job *j, ntp__compared *c)
{
    int32_t angle[NTP__BLOCK];
    for (int32_t i = 0; i < c->left; i += NTP__BLOCK) {
        const int32_t some = c->left - i < NTP__BLOCK ? c->left - i : NTP__BLOCK;
        j->kernels->angles_of(angle, c->s2 + i, c->d + i, some);
        add_angles(&j->diff->angles, angle, some);
    }
}

static void pick_loops(job *j)
{
    const ntp_const_image *a = j->a;
    if (!j->alike || a->encoding != NTP_ENCODING_STANDARD || a->channels != 3 ||
        a->type == NTP_TYPE_F32)
        return;
    if (ntp__cpu_has_avx2(NTP__CPU_ALL))
        j->compare_rgb = ntp__compare_rgb_avx2;
#  ifdef NTP_HAVE_AVX512
    if (ntp__cpu_has_avx512(NTP__CPU_ALL))
        j->compare_rgb = ntp__compare_rgb_avx512;
#  endif
}

/* Compares the first of n texels; returns how many, or 0: it cannot. */
static int32_t compare_packed(job *j, const void *a, const void *b, int32_t n)
{
    ntp__compared c;
    if (j->compare_rgb == NULL)
        return 0;
    n = n < j->span ? n : j->span;
    j->span = j->span < SPAN ? 2 * j->span : SPAN;
    c.fullest = j->fullest;
    c.bins = j->diff->angles.bins;
    n = j->compare_rgb(&c, a, b, n, j->m > 255);
    j->fullest = c.fullest;
    add_compared(j->diff, &c, n);
    add_left(j, &c);
    return n;
}
#else
static void pick_loops(job *j)
{
    (void) j;
}

static int32_t compare_packed(job *j, const void *a, const void *b, int32_t n)
{
    (void) j, (void) a, (void) b, (void) n;
    return 0;
}
#endif

/* Compares the first of n texels; returns how many. */
static int32_t compare_quickly(job *j, int32_t x, int32_t y, int32_t n)
{
    const void *a = ntp__at(j->a, x, y), *b = ntp__at(j->b, x, y);
    const int32_t block = n < NTP__BLOCK ? n : NTP__BLOCK;
    if (add_equal(j, a, b, block)) {
        j->span = NTP__BLOCK;
        return block;
    }
    const int32_t done = compare_packed(j, a, b, n);
    if (done > 0)
        return done;
    compare_run(j, x, y, block);
    return block;
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
    j->alike = j->heat == NULL && !j->flip && j->encoding_a == j->encoding_b &&
               a->type == b->type && a->channels == b->channels && ntp__is_packed(a) &&
               ntp__is_packed(b);
    pick_loops(j);
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
    job j = { .diff = diff,
              .heat = heat,
              .a = a,
              .b = b,
              .kernels = ntp__kernels(NTP__CPU_ALL),
              .span = NTP__BLOCK };
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
        for (int32_t x = rect.x0; x < rect.x1;)
            x += compare_quickly(&j, x, y, rect.x1 - x);
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
