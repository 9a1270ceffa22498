/* SPDX-License-Identifier: MIT */
/*
 * paint_avx2.c - lit previews and heatmaps of packed RGB, with AVX2
 *
 * Eight texels at a time, none of which goes through memory on its way.  What is rare is only marked:
 * black and white texels, levels near a boundary, lengths that depend on how a pair is pulled.  Then
 * shade.c and heatmap.c paint it once more.  Fused products only make errors smaller, so bounds hold.
 */
#include "picture/paint_avx2.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"
#include "texel/packed_avx2_tmpl.h"

#include <string.h>

enum { STEP = 8 /* texels */, SHOWN = 3 * STEP /* bytes */ };

/* As take8, but not a byte more than 24 is read. */
static inline texels take_8(const uint8_t *s)
{
    const __m256i v = load_two(s, s + 8);
    const texels t = {
        _mm256_shuffle_epi8(v, _mm256_setr_epi8(0, N, 1, N, 3, N, 4, N, 6, N, 7, N, 9, N, 10, N, 4,
                                                N, 5, N, 7, N, 8, N, 10, N, 11, N, 13, N, 14, N)),
        _mm256_shuffle_epi8(v, _mm256_setr_epi8(2, N, N, N, 5, N, N, N, 8, N, N, N, 11, N, N, N, 6,
                                                N, N, N, 9, N, N, N, 12, N, N, N, 15, N, N, N))
    };
    return t;
}

/* The signs of 32 bits. */
static inline uint32_t signs(__m256i v)
{
    return (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(v));
}

/* ------------------------------------------------------------------------ lit previews */

/* What light is made of, eight times each: numbers in registers would be repeated in each step, as there
 * are too many for the registers of vectors. */
enum {
    TOWARDS = 0,
    HALFWAY = 3,
    AMBIENT = 6,
    DIFFUSE,
    SPECULAR,
    OFF,
    OFF_BY_GLINT,
    MIDDLE, /* M/2 */
    CORNER, /* only corners of the cube are as long as black and white */
    NUMBERS
};

typedef struct lamp {
    _Alignas(32) float by[NUMBERS][STEP];
} lamp;

static inline void make_lamp(lamp *to, const ntp__lamp *l, float own)
{
    const float each[NUMBERS] = {
        l->towards[0],
        l->towards[1] * l->up,
        l->towards[2],
        l->half[0],
        l->half[1] * l->up,
        l->half[2],
        own * l->ambient,
        own * l->diffuse,
        l->specular,
        l->off,
        l->off_by_glint,
        l->m / 2,
        0.75F * (1 - 0x1p-18F) * l->m * l->m,
    };
    for (int32_t k = 0; k < NUMBERS; k++)
        _mm256_store_ps(to->by[k], _mm256_broadcast_ss(&each[k]));
}

static inline __m256 number(const lamp *l, int32_t k)
{
    return _mm256_load_ps(l->by[k]);
}

/* Levels less M/2: half of the numerators, exactly. */
static inline __m256 centered(__m256i level, const lamp *l)
{
    return _mm256_sub_ps(_mm256_cvtepi32_ps(level), number(l, MIDDLE));
}

static inline __m256 dot(const __m256 v[3], const lamp *l, int32_t of)
{
    return _mm256_fmadd_ps(
        v[2], number(l, of + 2),
        _mm256_fmadd_ps(v[1], number(l, of + 1), _mm256_mul_ps(v[0], number(l, of))));
}

static inline void put_gray(uint8_t *d, __m256i level)
{
    const __m128i two =
        _mm_packus_epi32(_mm256_castsi256_si128(level), _mm256_extracti128_si256(level, 1));
    const __m128i v = _mm_packus_epi16(two, two);
    store(d, _mm_shuffle_epi8(v, _mm_setr_epi8(0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 5)));
    _mm_storel_epi64(
        (__m128i *) (void *) (d + 16),
        _mm_shuffle_epi8(v, _mm_setr_epi8(5, 5, 6, 6, 6, 7, 7, 7, N, N, N, N, N, N, N, N)));
}

/* Of a block: how much light comes back, and the bound of its error; not a number where light may be
 * on the other side, or the texel is black or white. */
typedef struct lit {
    _Alignas(32) float light[NTP__BLOCK], off[NTP__BLOCK];
} lit;

/* As `light` of picture_kernels.c, in two steps, as many of a long one would have to wait for roots at once.
 * First the cosines of light and of glints, in their place; the former is no number where a texel may be
 * black or white. */
static inline void turn_to_light(lit *to, int32_t i, texels t, const lamp *l)
{
    const __m256 v[3] = { centered(_mm256_and_si256(t.rg, _mm256_set1_epi32(65535)), l),
                          centered(_mm256_srli_epi32(t.rg, 16), l), centered(t.b, l) };
    const __m256 square =
        _mm256_fmadd_ps(v[2], v[2], _mm256_fmadd_ps(v[1], v[1], _mm256_mul_ps(v[0], v[0])));
    const __m256 over = _mm256_div_ps(_mm256_set1_ps(1), _mm256_sqrt_ps(square));
    const __m256 corner = _mm256_cmp_ps(square, number(l, CORNER), _CMP_GE_OQ);
    _mm256_store_ps(to->light + i, _mm256_or_ps(_mm256_mul_ps(dot(v, l, TOWARDS), over), corner));
    _mm256_store_ps(to->off + i, _mm256_mul_ps(dot(v, l, HALFWAY), over));
}

static inline void light(lit *to, int32_t i, const lamp *l)
{
    const __m256 lambert = _mm256_load_ps(to->light + i), zero = _mm256_setzero_ps();
    /* Less than 1/8 is as good as 0, and the power of less may be a slow number. */
    __m256 glint = _mm256_max_ps(_mm256_load_ps(to->off + i), _mm256_set1_ps(0.125F));
    for (int32_t k = 0; k < NTP__SQUARINGS; k++)
        glint = _mm256_mul_ps(glint, glint);
    glint = _mm256_and_ps(glint, _mm256_cmp_ps(lambert, zero, _CMP_GT_OQ));
    const __m256 off = _mm256_fmadd_ps(glint, number(l, OFF_BY_GLINT), number(l, OFF));
    const __m256 edge = _mm256_cmp_ps(_mm256_andnot_ps(_mm256_set1_ps(-0.0F), lambert),
                                      _mm256_set1_ps(NTP__EDGE_OF_LIGHT), _CMP_NGE_UQ);
    const __m256 matt =
        _mm256_fmadd_ps(_mm256_max_ps(lambert, zero), number(l, DIFFUSE), number(l, AMBIENT));
    _mm256_store_ps(to->light + i, _mm256_fmadd_ps(glint, number(l, SPECULAR), matt));
    _mm256_store_ps(to->off + i, _mm256_or_ps(off, edge));
}

/* As `show` of picture_kernels.c; returns bits of those in doubt. */
static inline uint32_t show(uint8_t *d, const lit *from, int32_t i)
{
    const __m256 one = _mm256_set1_ps(1);
    const __m256 root = _mm256_sqrt_ps(_mm256_min_ps(_mm256_load_ps(from->light + i), one));
    const __m256 shown = _mm256_mul_ps(root, _mm256_set1_ps(255));
    const __m256i level = _mm256_cvtps_epi32(shown);
    const __m256 off = _mm256_sub_ps(shown, _mm256_cvtepi32_ps(level));
    const __m256 gap = _mm256_sub_ps(_mm256_set1_ps(0.5F - 0x1p-14F),
                                     _mm256_andnot_ps(_mm256_set1_ps(-0.0F), off));
    put_gray(d, level);
    return (uint32_t) _mm256_movemask_ps(
        _mm256_cmp_ps(_mm256_mul_ps(gap, root), _mm256_load_ps(from->off + i), _CMP_NGT_UQ));
}

/* ----------------------------------------------------------------------------- heatmaps */

/* 100 + half of luma, as in picture_kernels.c, of levels less (M + 1)/2. */
static inline __m256i gray_of(__m256i rg, __m256i b, bool deep)
{
    const int32_t m = deep ? 65535 : 255, whole = NTP__LUMA_WHOLE * (m / 255), twice = 2 * whole;
    const int32_t more = NTP__LUMA_WHOLE * ((m + 1) / 2) + whole / 2;
    const __m256i weights = _mm256_set1_epi32(NTP__LUMA_GREEN << 16 | NTP__LUMA_RED);
    const __m256i sum = _mm256_add_epi32(_mm256_madd_epi16(rg, weights),
                                         _mm256_madd_epi16(b, _mm256_set1_epi32(NTP__LUMA_BLUE)));
    if (!deep) { /* over 20000: s/32 + 1 is below 2^17, and 2^25/625 = 53687.1 */
        const __m256i s = _mm256_srli_epi32(_mm256_add_epi32(sum, _mm256_set1_epi32(more + 32)), 5);
        const __m256i half = _mm256_srli_epi32(_mm256_mullo_epi32(s, _mm256_set1_epi32(53687)), 25);
        return _mm256_add_epi32(half, _mm256_set1_epi32(NTP__GRAY_BASE));
    }
    const __m256i s = _mm256_add_epi32(sum, _mm256_set1_epi32(more));
    const __m256 share = _mm256_set1_ps(1.0F / (float) twice);
    const __m256i low = _mm256_cvttps_epi32(
        _mm256_fmadd_ps(_mm256_cvtepi32_ps(s), share, _mm256_set1_ps(NTP__GRAY_BASE - 0x1p-13F)));
    const __m256i rest = _mm256_sub_epi32(s, _mm256_mullo_epi32(low, _mm256_set1_epi32(twice)));
    const int32_t least = (int32_t) (twice - 1 - (int64_t) NTP__GRAY_BASE * twice);
    return _mm256_sub_epi32(low, _mm256_cmpgt_epi32(rest, _mm256_set1_epi32(least)));
}

/* The first three bytes of 32 bits. */
static ALWAYS_INLINE void put_colors(uint8_t *d, __m256i color)
{
    const __m256i v = _mm256_shuffle_epi8(
        color, _mm256_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, N, N, N, N, N, N, N, N, 0,
                                1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14));
    const __m128i low = _mm256_castsi256_si128(v);
    const int32_t last = _mm_extract_epi32(low, 2);
    store(d + 8, _mm256_extracti128_si256(v, 1));
    _mm_storel_epi64((__m128i *) (void *) d, low);
    memcpy(d + 8, &last, sizeof last);
}

static inline __m256i either(__m256i a, __m256i b)
{
    return _mm256_or_si256(a, b);
}

static inline __m256i bits_where(__m256i mask, int32_t bits)
{
    return _mm256_and_si256(mask, _mm256_set1_epi32(bits));
}

/* Is v beyond these limits? */
static inline __m256i is_outside(__m256i v, int32_t below, int32_t from)
{
    return either(_mm256_cmpgt_epi32(_mm256_set1_epi32(below), v),
                  _mm256_cmpgt_epi32(v, _mm256_set1_epi32(from - 1)));
}

/*
 * As judge_pairs, judge_blues and paint_reference of picture_kernels.c.
 *
 * Where a pair is too long, its place is that of the pulled one, which reaches at least to M - 2
 * sqrt(2): of the four pairs around the projection, the one taken reaches as far as that which has
 * both components rounded down, by less than 2 each.  So its sum is from -sqrt(2) M to -2.  If with
 * -3/2 M there is a strong fault, or with -2 none, then so it is for all between.  No length is too
 * short.
 */
static inline uint32_t heat(uint8_t *d, texels t, bool deep, const ntp__limits *l)
{
    const int32_t m = l->m, k = (m + 1) / 2, most = k * (k - 1);
    const __m256i rg = _mm256_sub_epi16(t.rg, _mm256_set1_epi16((short) k));
    const __m256i b = _mm256_sub_epi16(t.b, _mm256_set1_epi32(k));
    const __m256i xy = _mm256_sub_epi32(sum_of_pair(rg), _mm256_set1_epi32(most));
    const __m256i z = sum_of_pair(b), full = _mm256_add_epi32(xy, z);
    const __m256i overlong = _mm256_cmpgt_epi32(xy, _mm256_set1_epi32(-1));
    const __m256i below = _mm256_srai_epi32(_mm256_slli_epi32(b, 16), 31);
    const __m256i gray =
        SHUFFLE(gray_of(rg, b, deep), 0, 0, 0, N, 4, 4, 4, N, 8, 8, 8, N, 12, 12, 12, N);
    const __m256i any =
        either(either(overlong, below), is_outside(full, l->short_weak, l->long_weak));
    if (_mm256_testz_si256(any, any)) {
        put_colors(d, gray);
        return 0;
    }
    const __m256i pulled = _mm256_sub_epi32(z, _mm256_set1_epi32(m + m / 2));
    const __m256i sum = _mm256_blendv_epi8(full, pulled, overlong);
    const __m256i hard = _mm256_cmpgt_epi32(xy, _mm256_set1_epi32(l->xy_strong - 1));
    const __m256i weak = is_outside(sum, l->short_weak, l->long_weak);
    const __m256i strong = is_outside(sum, l->short_strong, l->long_strong);
    __m256i down = _mm256_and_si256(_mm256_xor_si256(t.b, _mm256_set1_epi32(m)), below);
    if (deep) /* times 255/65535, rounded, as in picture_kernels.c */
        down =
            _mm256_srli_epi32(_mm256_add_epi32(_mm256_sub_epi32(_mm256_slli_epi32(down, 8), down),
                                               _mm256_set1_epi32(32895)),
                              16);
    const __m256i red = either(bits_where(overlong, 0x80), bits_where(hard, 0x7f));
    const __m256i green = either(bits_where(weak, 0x8000), bits_where(strong, 0x7f00));
    const __m256i faults = either(either(red, green), _mm256_slli_epi32(down, 16));
    const __m256i none = _mm256_cmpeq_epi32(faults, _mm256_setzero_si256());
    const __m256i doubt =
        _mm256_and_si256(_mm256_cmpgt_epi32(z, _mm256_set1_epi32(l->long_weak + 1)),
                         _mm256_cmpgt_epi32(_mm256_set1_epi32(l->long_strong), pulled));
    const __m256i corner = _mm256_cmpgt_epi32(full, _mm256_set1_epi32(2 * most - 1));
    put_colors(d, either(faults, _mm256_and_si256(none, gray)));
    return signs(either(_mm256_and_si256(overlong, doubt), corner));
}

/* ------------------------------------------------------------------------------- blocks */

/* The last texels are painted from a copy of them, into one. */
typedef struct ends {
    uint8_t few[6 * STEP], shown[SHOWN];
} ends;

ONE_COPY static const uint8_t *copy_last(ends *e, const uint8_t *s, int32_t left, int32_t bytes)
{
    memset(e->few, 1, sizeof e->few);
    return memcpy(e->few, s, (size_t) bytes * (size_t) left);
}

static ALWAYS_INLINE const uint8_t *source(ends *e, const uint8_t *s, int32_t left, int32_t bytes)
{
    return left < STEP ? copy_last(e, s, left, bytes) : s;
}

/* Ends a step that painted `shown`; returns how many are odd. */
static inline int32_t finish(uint8_t *odd, uint32_t bits, uint8_t *dst, const ends *e, int32_t left)
{
    if (left < STEP) {
        memcpy(dst, e->shown, 3 * (size_t) left);
        bits &= (1U << left) - 1;
    }
    *odd = (uint8_t) bits;
    return __builtin_popcount(bits);
}

int32_t ntp__shade_rgb_avx2(uint8_t *dst, uint8_t odd[NTP__BLOCK / 8], const void *src, int32_t n,
                            bool deep, const ntp__lamp *of, float own)
{
    const uint8_t *const from = src;
    const int32_t bytes = deep ? 6 : 3;
    int32_t found = 0;
    lit lights;
    lamp l;
    ends e;
    make_lamp(&l, of, own);
    /* In three loops, as the roots of one are long waited for. */
    for (int32_t i = 0; i < n; i += STEP) {
        const uint8_t *const s = source(&e, from + bytes * i, n - i, bytes);
        turn_to_light(&lights, i, deep ? take16(s) : take_8(s), &l);
    }
    for (int32_t i = 0; i < n; i += STEP)
        light(&lights, i, &l);
    for (int32_t i = 0; i < n; i += STEP) {
        uint8_t *const d = dst + 3 * i;
        const uint32_t bits = show(n - i < STEP ? e.shown : d, &lights, i);
        found += finish(odd + i / STEP, bits, d, &e, n - i);
    }
    end_lanes();
    return found;
}

int32_t ntp__heat_rgb_avx2(uint8_t *dst, uint8_t odd[NTP__BLOCK / 8], const void *src, int32_t n,
                           bool deep, const ntp__limits *limits)
{
    const uint8_t *const from = src;
    const ntp__limits l = *limits;
    const int32_t bytes = deep ? 6 : 3;
    int32_t found = 0;
    ends e;
    for (int32_t i = 0; i < n; i += STEP) {
        const uint8_t *const s = source(&e, from + bytes * i, n - i, bytes);
        uint8_t *const d = dst + 3 * i;
        const texels t = deep ? take16(s) : take_8(s);
        const uint32_t bits = heat(n - i < STEP ? e.shown : d, t, deep, &l);
        found += finish(odd + i / STEP, bits, d, &e, n - i);
    }
    end_lanes();
    return found;
}

/* ---------------------------------------------------------------------------------- odd texels */

/* Paints those of eight texels that are marked as unused, or `bright` if white. */
static inline void paint_unused(uint8_t *d, const ntp__painter *p, __m256i unused, __m256i bright,
                                int32_t x, int32_t y)
{
    int32_t four; /* of black texels two, and of white ones */
    memcpy(&four, p->unused, sizeof four);
    const __m256i grays = _mm256_cvtepu8_epi32(_mm_cvtsi32_si128(four));
    const __m256i column =
        _mm256_add_epi32(_mm256_set1_epi32(x), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    const __m256i field = _mm256_and_si256(
        _mm256_add_epi32(_mm256_srli_epi32(column, 3), _mm256_set1_epi32(y / NTP__CHECKER)),
        _mm256_set1_epi32(1));
    const __m256i level = _mm256_permutevar8x32_epi32(
        grays, _mm256_sub_epi32(field, _mm256_add_epi32(bright, bright)));
    const __m256i gray = SHUFFLE(level, 0, 0, 0, N, 4, 4, 4, N, 8, 8, 8, N, 12, 12, 12, N);
    const __m256i was = _mm256_shuffle_epi8(
        load_two(d, d + 8), _mm256_setr_epi8(0, 1, 2, N, 3, 4, 5, N, 6, 7, 8, N, 9, 10, 11, N, 4, 5,
                                             6, N, 7, 8, 9, N, 10, 11, 12, N, 13, 14, 15, N));
    put_colors(d, _mm256_blendv_epi8(was, gray, unused));
}

void ntp__gather_odd_avx2(const ntp__painter *p, ntp__odd_texels *odd,
                          const uint8_t bits[NTP__BLOCK / 8], int32_t x, int32_t y, int32_t n)
{
    const bool deep = p->src->type == NTP_TYPE_U16;
    const int32_t bytes = deep ? 6 : 3, m = deep ? 65535 : 255;
    const uint8_t *const from = (const uint8_t *) ntp__at(p->src, x, y);
    uint8_t *const to = ntp__at_mut(p->dst, x, y);
    /* No blue is -1. */
    const __m256i black = _mm256_set1_epi32((p->touch_unused & NTP_UNUSED_BLACK) ? -1 : 0);
    const __m256i white = _mm256_set1_epi32((p->touch_unused & NTP_UNUSED_WHITE) ? -1 : m);
    ends e;
    for (int32_t i = 0; i < n; i += STEP) {
        if (bits[i / STEP] == 0)
            continue;
        const uint8_t *const s = source(&e, from + bytes * i, n - i, bytes);
        uint8_t *const d = to + 3 * i;
        const texels t = deep ? take16(s) : take_8(s);
        const __m256i gray = _mm256_cmpeq_epi32(t.rg, either(t.b, _mm256_slli_epi32(t.b, 16)));
        const __m256i bright = _mm256_and_si256(gray, _mm256_cmpeq_epi32(t.b, white));
        const __m256i unused =
            either(bright, _mm256_and_si256(gray, _mm256_cmpeq_epi32(t.b, black)));
        uint32_t left = bits[i / STEP] & ~signs(unused);
        if (left != bits[i / STEP]) {
            const bool few = n - i < STEP;
            if (few)
                memcpy(e.shown, d, 3 * (size_t) (n - i));
            paint_unused(few ? e.shown : d, p, unused, bright, x + i, y);
            if (few)
                memcpy(d, e.shown, 3 * (size_t) (n - i));
        }
        for (; left != 0; left &= left - 1) {
            const int32_t k = __builtin_ctz(left);
            uint16_t c[3] = { s[3 * k], s[3 * k + 1], s[3 * k + 2] };
            if (deep)
                memcpy(c, s + 6 * k, sizeof c);
            for (int32_t q = 0; q < 3; q++)
                odd->block.c[q][odd->n] = c[q];
            odd->block.c[3][odd->n] = m;
            odd->x[odd->n] = x + i + k;
            odd->y[odd->n++] = y;
        }
    }
    end_lanes();
}
