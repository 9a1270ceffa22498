/* SPDX-License-Identifier: MIT */
/*
 * rotate_avx2.c - packed RGB of 8 bit, turned by any angle, with AVX2
 *
 * Along x, sums of two numerators times 15-bit weights are less than 2^24, so floats hold them.  Along y, one fused
 * product adds the difference of two such sums, which is exact, too.  So each component of a sum has one rounding: it is
 * off by u = 2^-24 of itself, and its sign is right.  Texels without a normal have numerators of 0 here.
 *
 * x and y are turned with factors that are off by u: the result is by less than 4u of the length R of both together,
 * since |cos x| + |sin y| <= R.  That makes a length, which is not below R, off by less than 5.7u, and x over the length
 * by 9.7u.  With the 4.5u of roundings in mix_avx2.c this is 14.2u, of which 8u |x| are counted there.  The other 6.2u
 * of the length are below 2^-14 of levels.
 */
#include "base/cpu.h"
#include "base/inlining.h"
#include "base/lanes_avx2.h"
#include "reshape/mix_avx2.h"
#include "reshape/rotation.h"

#include <string.h>

enum {
    HALF = 8,
    STEP = 16, /* texels */
    RUN = NTP__ROTATED_AT_ONCE,
    MOST = 1 << 15, /* columns or rows: places have 32 bits */
    FAR = 1 << 30   /* beyond all indices */
};

/* Places of the texels of a run along one axis. */
typedef struct line {
    int32_t index[2][RUN], share[RUN]; /* of the lower and the higher texels; of the higher */
} line;

/* Can places be counted from here? */
static bool is_near(int32_t first)
{
    return -MOST / 2 <= first && first <= MOST / 2;
}

bool ntp__can_rotate_rgb(const ntp__rotation *j)
{
    const double strength = ntp__strength_value(&j->strength);
    const double size = strength < 0 ? -strength : strength;
    const ntp_const_image dst = ntp_image_as_const(j->dst);
    const ptrdiff_t stride = j->src->row_stride, apart = stride < 0 ? -stride : stride;
    const ntp_part *p = &j->part;
    return ntp__can_mix(j->src) && ntp__can_mix(&dst) && j->src->type == NTP_TYPE_U8 &&
           size >= 0x1p-10 && size <= 0x1p10 && p->width <= MOST && p->height <= MOST &&
           is_near(p->src_x) && is_near(p->src_y) && j->src->width > 1 && j->src->height > 1 &&
           apart <= INT32_MAX / j->src->height;
}

/* Indices beyond the picture, held to or repeated within it. */
typedef struct border {
    int32_t least, most, period, mirror;
} border;

static border border_of(const ntp__axis *a, bool is_part)
{
    if (is_part || a->border == NTP_BORDER_CLAMP)
        return (border) { 0, a->n - 1, FAR, FAR };
    if (a->border == NTP_BORDER_WRAP)
        return (border) { -FAR, FAR, a->n, FAR };
    return (border) { -FAR, FAR, 2 * (a->n - 1), 2 * (a->n - 1) };
}

static __m256i inside(__m256i i, const border *b)
{
    const __m256i period = _mm256_set1_epi32(b->period), mirror = _mm256_set1_epi32(b->mirror);
    i = _mm256_min_epi32(_mm256_max_epi32(i, _mm256_set1_epi32(b->least)),
                         _mm256_set1_epi32(b->most));
    /* The quotient may be one too much or too little. */
    const __m256 quotient = _mm256_floor_ps(
        _mm256_mul_ps(_mm256_cvtepi32_ps(i), _mm256_set1_ps(1 / (float) b->period)));
    i = _mm256_sub_epi32(i, _mm256_mullo_epi32(_mm256_cvtps_epi32(quotient), period));
    i = _mm256_add_epi32(i, _mm256_and_si256(_mm256_srai_epi32(i, 31), period));
    i = _mm256_sub_epi32(i, _mm256_andnot_si256(_mm256_cmpgt_epi32(period, i), period));
    return _mm256_min_epi32(i, _mm256_sub_epi32(mirror, i));
}

static __m256i load(const int32_t *from)
{
    return _mm256_loadu_si256((const __m256i *) (const void *) from);
}

static void store(int32_t *to, __m256i v)
{
    _mm256_storeu_si256((__m256i *) (void *) to, v);
}

/* n is a multiple of STEP. */
ONE_COPY static void find_line(line *to, const ntp__axis *a, bool is_part, int32_t n)
{
    enum { LOW = (1 << NTP__DROPPED_BITS) - 1, BITS = NTP__DROPPED_BITS + NTP__PLACE_BITS };
    const border b = border_of(a, is_part);
    const int32_t first = is_part ? a->first : 0;
    const int64_t from = a->from >> BITS, last = (a->from + (n - 1) * a->step) >> BITS;
    const bool beyond =
        (from < last ? from : last) < first || (from < last ? last : from) - first >= a->n - 1;
    const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i high = _mm256_set1_epi32((int32_t) (a->step >> NTP__DROPPED_BITS));
    const __m256i low = _mm256_set1_epi32((int32_t) (a->step & LOW));
    __m256i upper = _mm256_add_epi32(
        _mm256_set1_epi32((int32_t) (a->from >> NTP__DROPPED_BITS) - first * NTP__ONE_TEXEL),
        _mm256_mullo_epi32(lanes, high));
    __m256i lower = _mm256_add_epi32(_mm256_set1_epi32((int32_t) (a->from & LOW)),
                                     _mm256_mullo_epi32(lanes, low));
    for (int32_t i = 0; i < n; i += HALF) {
        const __m256i place = _mm256_add_epi32(upper, _mm256_srli_epi32(lower, NTP__DROPPED_BITS));
        __m256i at = _mm256_srai_epi32(place, NTP__PLACE_BITS);
        __m256i beside = _mm256_sub_epi32(at, _mm256_set1_epi32(-1));
        if (beyond) {
            at = inside(at, &b);
            beside = inside(beside, &b);
        }
        store(to->index[0] + i, at);
        store(to->index[1] + i, beside);
        store(to->share + i, _mm256_and_si256(place, _mm256_set1_epi32(NTP__ONE_TEXEL - 1)));
        upper = _mm256_add_epi32(upper, _mm256_slli_epi32(high, 3));
        lower = _mm256_add_epi32(lower, _mm256_slli_epi32(low, 3));
    }
}

/* Pixels of a row that is `row` bytes from s on, in the low three bytes.  Four bytes are read, and where there is
 * one, the first is of the pixel before: nothing beyond a row. */
static inline __m256i pixels(const uint8_t *s, __m256i row, __m256i column)
{
    const __m256i back = _mm256_cmpgt_epi32(column, _mm256_setzero_si256());
    const __m256i bytes = _mm256_add_epi32(_mm256_slli_epi32(column, 1), column);
    const __m256i at = _mm256_add_epi32(_mm256_add_epi32(row, back), bytes);
    const __m256i v = _mm256_i32gather_epi32((const int *) (const void *) s, at, 1);
    return _mm256_and_si256(_mm256_srlv_epi32(v, _mm256_and_si256(back, _mm256_set1_epi32(8))),
                            _mm256_set1_epi32(0xffffff));
}

/* The colors of texels that hold no normal; -1: all hold one. */
typedef struct unused {
    int32_t black, white;
} unused;

static inline __m256i unused_at(__m256i v, const unused *u)
{
    return _mm256_or_si256(_mm256_cmpeq_epi32(v, _mm256_set1_epi32(u->black)),
                           _mm256_cmpeq_epi32(v, _mm256_set1_epi32(u->white)));
}

/* Sums along x, of the numerators of 8 pixels and those beside them. */
static inline void sums_along_x(__m256 to[3], __m256i v, __m256i w, __m256i weights,
                                const unused *u)
{
    enum { N = -1 };
    const __m256i none = _mm256_blend_epi16(unused_at(v, u), unused_at(w, u), 0xaa);
#define SUM(k)                                                                                     \
    {                                                                                              \
        const __m256i pair = _mm256_or_si256(                                                      \
            SHUFFLE(v, k, N, N, N, k + 4, N, N, N, k + 8, N, N, N, k + 12, N, N, N),               \
            SHUFFLE(w, N, N, k, N, N, N, k + 4, N, N, N, k + 8, N, N, N, k + 12, N));              \
        const __m256i less =                                                                       \
            _mm256_sub_epi16(_mm256_set1_epi16(255), _mm256_add_epi16(pair, pair));                \
        to[k] = _mm256_cvtepi32_ps(_mm256_madd_epi16(_mm256_andnot_si256(none, less), weights));   \
    }
    SUM(0)
    SUM(1)
    SUM(2)
#undef SUM
}

/* The turned sums around n places, a multiple of STEP.  A sum of 0, as around texels without a normal, is flat. */
static void sum_texels(ntp__mix_planes v, const ntp__rotation *j, const line *x, const line *y,
                       int32_t n)
{
    /* From the middle row on, offsets have 32 bits. */
    const int32_t middle = j->src->height / 2;
    const uint8_t *const s = ntp__at(j->src, 0, middle);
    const __m256i stride = _mm256_set1_epi32((int32_t) j->src->row_stride);
    const unused u = { j->how->touch_unused & NTP_UNUSED_BLACK ? -1 : 0,
                       j->how->touch_unused & NTP_UNUSED_WHITE ? -1 : 0xffffff };
    __m256 by[2][2];
    for (int32_t k = 0; k < 4; k++)
        by[k / 2][k % 2] = _mm256_set1_ps((float) j->by[k / 2][k % 2]);
    for (int32_t i = 0; i < n; i += HALF) {
        const __m256i left = load(x->index[0] + i), right = load(x->index[1] + i);
        const __m256i share = load(x->share + i);
        /* Less both weights, as that of a whole texel would not fit in 16 bits. */
        const __m256i weights =
            _mm256_sub_epi32(_mm256_add_epi32(share, _mm256_set1_epi32(NTP__ONE_TEXEL)),
                             _mm256_slli_epi32(share, 16));
        const __m256 below = _mm256_mul_ps(_mm256_cvtepi32_ps(load(y->share + i)),
                                           _mm256_set1_ps(1.0F / NTP__ONE_TEXEL));
        __m256 sum[2][3];
        for (int32_t k = 0; k < 2; k++) {
            const __m256i row = _mm256_mullo_epi32(
                _mm256_sub_epi32(load(y->index[k] + i), _mm256_set1_epi32(middle)), stride);
            sums_along_x(sum[k], pixels(s, row, left), pixels(s, row, right), weights, &u);
        }
        for (int32_t k = 0; k < 3; k++)
            sum[0][k] = _mm256_fmadd_ps(_mm256_sub_ps(sum[1][k], sum[0][k]), below, sum[0][k]);
        const __m256 any = _mm256_or_ps(_mm256_or_ps(sum[0][0], sum[0][1]), sum[0][2]);
        const __m256 nothing = _mm256_cmp_ps(any, _mm256_setzero_ps(), _CMP_EQ_OQ);
        for (int32_t k = 0; k < 2; k++) {
            const __m256 turned =
                _mm256_fmadd_ps(by[k][0], sum[0][0], _mm256_mul_ps(by[k][1], sum[0][1]));
            _mm256_storeu_ps(v[k] + i, _mm256_blendv_ps(turned, _mm256_set1_ps(1), nothing));
        }
        _mm256_storeu_ps(v[2] + i, _mm256_blendv_ps(sum[0][2], _mm256_set1_ps(255), nothing));
    }
}

int32_t ntp__rotate_rgb_avx2(const ntp__rotation *j, uint8_t *d, int32_t *at, int32_t x, int32_t y,
                             int32_t n)
{
    const ntp__mix_constants c = { .m = 255,
                                   .rounding = { 127.5F, 0x1p-14F, 0.5F },
                                   .avx512 = ntp__cpu_has_avx512(NTP__CPU_ALL) };
    const int32_t whole = (n + STEP - 1) / STEP * STEP;
    ntp__mix_block p;
    ntp__axis axes[2];
    line lines[2];
    ntp__find_axes(j, axes, x, y);
    for (int32_t k = 0; k < 2; k++)
        find_line(&lines[k], &axes[k], j->how->part != NULL, whole);
    sum_texels(p.v, j, &lines[0], &lines[1], whole);
    memset(p.left, 0, (size_t) whole * sizeof p.left[0]);
    p.any_kept = false;
    const int32_t left = ntp__put_levels_avx2(d, at, &p, n, &c);
    end_lanes();
    return left;
}
