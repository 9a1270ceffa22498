/* SPDX-License-Identifier: MIT */
/*
 * mix_avx2.c - packed RGB made stronger, or blended, with AVX2
 *
 * The bytes are those of directions_tmpl.h.  Floats decide the levels at 16 bit too; the caller does
 * those that are in doubt in double.
 *
 * The bound of floats, where u = 2^-24 and squares of it are left out.  The components of a blended
 * vector are off by u as floats.  So their squares are by 3u, the sum by 5u, the root by 3.5u, the
 * quotient by 4.5u, and the product with a component by 6.5u.  A vector that is made stronger is
 * (x, y, z/S): x and y are exact, z/S is off by 2u, so the sum of squares is by 6u, the root by 4u, and
 * the product by 6u.  Less than 8u is 2^-21.
 *
 * Vectors are blended in double, which is exact where the strength of a detail is 1 or -1.  Else
 * components are off by less than 2^-49 of `size`, which is not below what is added up for one.  The
 * length is at least 2^-16 of it, or the texel is in doubt.  So a component over the length is off by
 * 2^-33, and that by three times as much because the length is.  This is below 2^-16 levels.
 *
 * Of 8 bit, where that strength is 1 or -1, floats are as good.  They hold whole numbers up to 2^24, up
 * to twice that if these are even, and so on.  M is odd, and so are all numerators; hence t.z, t.u and
 * t.z M are even, and t.u is below 2^18.  It is split into a multiple of 4 and a rest of -2, 0 or 2.
 * Then all products are whole: the multiple of 4 times an odd number below 2^8 or times t.z, t.z M times
 * such an odd number.  The sum of the last and of the rest times a component is even and at most
 * 510 * 255^2 + 2 * 510, less than 2^25.  So vectors are rounded once, with the right sign.  All numbers
 * of other modes are below 2^24.
 *
 * Fused products only make errors smaller.
 */
#include "reshape/mix_avx2.h"

#include "base/cpu.h"
#include "base/inlining.h"
#include "base/lanes_avx2.h"
#include "texel/level.h"
#include "texel/packed_avx2_tmpl.h"

#include <math.h>
#include <string.h>

enum { HALF = 8, STEP = 16 /* texels */ };

typedef ntp__mix_constants constants;
typedef ntp__mix_block planes;

static inline __m256i load_ints(const int32_t *from)
{
    return _mm256_loadu_si256((const __m256i *) (const void *) from);
}

static inline void store_ints(int32_t *to, __m256i v)
{
    _mm256_storeu_si256((__m256i *) (void *) to, v);
}

static inline __m256 absolute(__m256 v)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0F), v);
}

/* ------------------------------------------------------------------------------------- texels */

/* 2c - M of eight levels. */
static inline void put_numerators(float *to, __m256i level, __m256i m)
{
    _mm256_storeu_ps(to, _mm256_cvtepi32_ps(_mm256_sub_epi32(_mm256_slli_epi32(level, 1), m)));
}

/* Reads n texels of a row to place `at` of a block, and asks for those that follow.  Are red and
 * green of one those of black or of white? */
static bool take(ntp__mix_planes to, int32_t at, const uint8_t *s, int32_t n, const constants *c)
{
    enum { READ = 10 /* texels at most, for eight */, FEW = 64 /* bytes */ };
    const ptrdiff_t size = c->deep ? 6 : 3;
    const __m256i m = _mm256_set1_epi32(c->m);
    const __m256i white = _mm256_or_si256(m, _mm256_slli_epi32(m, 16));
    __m256i any = _mm256_setzero_si256();
    uint8_t few[FEW] = { 0 };
    for (int32_t i = 0; i < n; i += HALF, s += HALF * size) {
        const uint8_t *from = s;
        if (n - i < READ) {
            memcpy(few, s, (size_t) ((n - i < HALF ? n - i : HALF) * size));
            from = few;
        }
        _mm_prefetch((const char *) s + NTP__BLOCK * size, _MM_HINT_T0);
        const texels t = c->deep ? take16(from) : take8(from);
        const __m256i mark = _mm256_or_si256(_mm256_cmpeq_epi32(t.rg, _mm256_setzero_si256()),
                                             _mm256_cmpeq_epi32(t.rg, white));
        put_numerators(to[0] + at + i, _mm256_and_si256(t.rg, _mm256_set1_epi32(65535)), m);
        put_numerators(to[1] + at + i, _mm256_srli_epi32(t.rg, 16), m);
        put_numerators(to[2] + at + i, t.b, m);
        any = _mm256_or_si256(any, mark);
    }
    return !_mm256_testz_si256(any, any);
}

/* ------------------------------------------------------------------------------------ vectors */

/* The strength of n texels. */
static void boost(planes *p, int32_t n, const ntp__mixing *j)
{
    const __m256 over = _mm256_set1_ps((float) (1 / j->strength));
    const __m256 mirror_x = _mm256_set1_ps(j->mirror_x ? -0.0F : 0.0F);
    const __m256 mirror_y = _mm256_set1_ps(j->mirror_y ? -0.0F : 0.0F);
    const float *const x = p->base[j->swap], *const y = p->base[!j->swap];
    for (int32_t i = 0; i < n; i += HALF) {
        _mm256_storeu_ps(p->v[0] + i, _mm256_xor_ps(_mm256_loadu_ps(x + i), mirror_x));
        _mm256_storeu_ps(p->v[1] + i, _mm256_xor_ps(_mm256_loadu_ps(y + i), mirror_y));
        _mm256_storeu_ps(p->v[2] + i, _mm256_mul_ps(_mm256_loadu_ps(p->base[2] + i), over));
    }
}

#define NUMBER       __m256d
#define ELEMENT      double
#define OP(op)       _mm256_##op##_pd
#define MIXED        mixed_doubles
#define LOAD(from)   _mm256_cvtps_pd(_mm_loadu_ps(from))
#define STORE(to, v) _mm_storeu_ps(to, _mm256_cvtpd_ps(v))
#include "reshape/mixed_tmpl.h"

#define NUMBER       __m256
#define ELEMENT      float
#define OP(op)       _mm256_##op##_ps
#define MIXED        mixed_floats
#define LOAD(from)   _mm256_loadu_ps(from)
#define STORE(to, v) _mm256_storeu_ps(to, v)
#define FOURS        0x1.8p25F /* numbers beside it are multiples of 4 */
#include "reshape/mixed_tmpl.h"

static void blend(planes *p, int32_t n, const ntp__mix_terms *how, const constants *c)
{
    const __m256 least_z = _mm256_set1_ps(c->least_z);
    how->mix(p->v, p->base, p->detail, n, how);
    for (int32_t i = 0; i < n; i += HALF) {
        /* A steep detail, reoriented on a steep base, can point below the horizon.  -0 does not. */
        const __m256 z = _mm256_add_ps(_mm256_loadu_ps(p->v[2] + i), _mm256_setzero_ps());
        const __m256 either =
            _mm256_or_ps(_mm256_loadu_ps(p->base[2] + i), _mm256_loadu_ps(p->detail[2] + i));
        const __m256i below =
            _mm256_srai_epi32(_mm256_castps_si256(_mm256_andnot_ps(either, z)), 31);
        const __m256 unsure = _mm256_cmp_ps(absolute(z), least_z, _CMP_LT_OQ);
        _mm256_storeu_ps(p->v[2] + i, _mm256_andnot_ps(_mm256_castsi256_ps(below), z));
        store_ints(p->left + i,
                   _mm256_or_si256(load_ints(p->left + i), _mm256_castps_si256(unsure)));
    }
}

/* ------------------------------------------------------------------------------------- levels */

/* Is the floor of s in doubt?  That of 0 is only where it may be off. */
static inline __m256i in_doubt(__m256 s, __m256 less)
{
    enum { NEAREST = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC };
    const __m256 most = _mm256_fmadd_ps(absolute(s), _mm256_set1_ps(0x1p-21F), less);
    const __m256 off = absolute(_mm256_sub_ps(s, _mm256_round_ps(s, NEAREST)));
    return _mm256_castps_si256(_mm256_cmp_ps(off, most, _CMP_LT_OQ));
}

static inline __m256i floor_of(__m256 s)
{
    enum { DOWN = _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC };
    return _mm256_cvtps_epi32(_mm256_round_ps(s, DOWN));
}

static void round_pairs(planes *p, int32_t n, const constants *c)
{
    const ntp__mix_rounding r = c->rounding;
    const __m256 half = _mm256_set1_ps(r.half), less = _mm256_set1_ps(r.less);
    const __m256 least2 = _mm256_set1_ps(r.least2);
    for (int32_t i = 0; i < n; i += HALF) {
        const __m256 x = _mm256_loadu_ps(p->v[0] + i), y = _mm256_loadu_ps(p->v[1] + i);
        const __m256 z = _mm256_loadu_ps(p->v[2] + i);
        const __m256 square = _mm256_fmadd_ps(z, z, _mm256_fmadd_ps(y, y, _mm256_mul_ps(x, x)));
        const __m256 factor = _mm256_div_ps(half, _mm256_sqrt_ps(square));
        const __m256 s = _mm256_mul_ps(x, factor), t = _mm256_mul_ps(y, factor);
        const __m256i small = _mm256_castps_si256(_mm256_cmp_ps(square, least2, _CMP_LT_OQ));
        const __m256i doubt = _mm256_or_si256(in_doubt(s, less), in_doubt(t, less));
        store_ints(p->pair + i,
                   _mm256_blend_epi16(floor_of(s), _mm256_slli_epi32(floor_of(t), 16), 0xaa));
        store_ints(p->left + i,
                   _mm256_or_si256(load_ints(p->left + i), _mm256_or_si256(doubt, small)));
    }
}

/* Marks those of eight texels that hold no normal. */
static inline __m256i unused_at(const ntp__mix_planes v, int32_t i, const constants *c)
{
    const __m256 x = _mm256_loadu_ps(v[0] + i), y = _mm256_loadu_ps(v[1] + i);
    const __m256 z = _mm256_loadu_ps(v[2] + i);
    const __m256 gray =
        _mm256_and_ps(_mm256_cmp_ps(x, y, _CMP_EQ_OQ), _mm256_cmp_ps(x, z, _CMP_EQ_OQ));
    const __m256 end = _mm256_or_ps(_mm256_cmp_ps(x, _mm256_set1_ps(c->black), _CMP_EQ_OQ),
                                    _mm256_cmp_ps(x, _mm256_set1_ps(c->white), _CMP_EQ_OQ));
    return _mm256_castps_si256(_mm256_and_ps(gray, end));
}

/* The levels of eight numerators. */
static inline __m256i level_at(const float *from, const constants *c)
{
    const __m256i v = _mm256_cvtps_epi32(_mm256_loadu_ps(from));
    return _mm256_srli_epi32(_mm256_add_epi32(v, _mm256_set1_epi32(c->m)), 1);
}

/* Puts texels back that stay as they are in the base, as one of both holds no normal; returns their bits.
 * Few textures have any, so the loop has no copy of it. */
ONE_COPY static uint32_t keep_base(texels *t, const planes *p, int32_t i, const constants *c)
{
    __m256i kept = unused_at(p->base, i, c);
    if (p->blends)
        kept = _mm256_or_si256(kept, unused_at(p->detail, i, c));
    const __m256i g = _mm256_slli_epi32(level_at(p->base[1] + i, c), 16);
    t->rg = _mm256_blendv_epi8(t->rg, _mm256_or_si256(level_at(p->base[0] + i, c), g), kept);
    t->b = _mm256_blendv_epi8(t->b, level_at(p->base[2] + i, c), kept);
    return (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(kept));
}

/* Eight texels with their blue; *bits: those that are left. */
static ALWAYS_INLINE texels finished(const planes *p, int32_t i, const constants *c, uint32_t *bits)
{
    const __m256i zero = _mm256_set1_epi32((c->m + 1) / 2);
    __m256i pair = load_ints(p->pair + i);
    __m256i e = rest_of_pair(pair, c->deep);
    if (_mm256_movemask_ps(_mm256_castsi256_ps(e)) != 0)
        pair = pulled(pair, &e, c->deep);
    const __m256i z = _mm256_castps_si256(_mm256_loadu_ps(p->v[2] + i));
    const __m256i down = _mm256_srai_epi32(z, 31);
    const texels t = { _mm256_add_epi16(pair, _mm256_or_si256(zero, _mm256_slli_epi32(zero, 16))),
                       _mm256_xor_si256(
                           _mm256_add_epi32(root_of(e, c->deep), zero), /* M - b is M ^ b */
                           _mm256_and_si256(down, _mm256_set1_epi32(c->m))) };
    *bits = (uint32_t) _mm256_movemask_ps(
        _mm256_loadu_ps((const float *) (const void *) (p->left + i)));
    return t;
}

int32_t ntp__put_levels_avx2(uint8_t *d, int32_t *at, planes *p, int32_t n, const constants *c)
{
    int32_t found = 0;
    const int32_t whole = (n + STEP - 1) / STEP * STEP;
#ifdef NTP_HAVE_AVX512
    if (c->avx512)
        ntp__round_pairs_avx512(p->pair, p->left, p->v, whole, &c->rounding);
#endif
    if (!c->avx512)
        round_pairs(p, whole, c);
    for (int32_t i = 0; i < n; i += STEP) {
        uint32_t bits[2];
        texels t[2] = { finished(p, i, c, &bits[0]), finished(p, i + HALF, c, &bits[1]) };
        if (p->any_kept) {
            texels both[2] = { t[0], t[1] }; /* so that others need no memory */
            bits[0] &= ~keep_base(&both[0], p, i, c);
            bits[1] &= ~keep_base(&both[1], p, i + HALF, c);
            t[0] = both[0];
            t[1] = both[1];
        }
        put_step(d, i, n, t, c->deep);
        found += add_places(at + found, i, n, bits);
    }
    return found;
}

/* --------------------------------------------------------------------------------------- rows */

/* What blending needs to know of the error of vectors. */
static ntp__mix_terms terms_of(constants *c, const ntp__mixing *j)
{
    const ntp__mixture *h = j->how;
    const double m = c->m, s = fabs(h->strength) < 1 ? 1 : fabs(h->strength);
    /* No component is more than M, and t.z is at most twice that: `size` in blend_kernels.c. */
    const double size = j->reoriented ? 96 * m * m * m * s : 9 * m * m * s;
    ntp__mix_terms t = { h->strength,   h->turn,      m, h->base_z * m, h->detail_z * m, h->product,
                         j->reoriented, mixed_doubles };
    /* Whole numbers are exact, so only a length of 0 is in doubt. */
    c->rounding.less = j->exact ? 0 : 0x1p-16F;
    c->rounding.least2 = j->exact ? 0.5F : (float) (size * size * 0x1p-32);
    c->least_z = j->exact ? 0 : (float) (size * 0x1p-48);
#ifdef NTP_HAVE_AVX512
    if (c->avx512)
        t.mix = ntp__mix_doubles_avx512;
#endif
    if (j->exact && !c->deep)
        t.mix = mixed_floats;
    return t;
}

/* Texels of a row that are left, until there are many; for those other loops are quicker. */
typedef struct waiting {
    int32_t n, at[NTP__BLOCK];
    ntp__block base, detail;
} waiting;

static void put_texel(void *row, int32_t x, const ntp__block *b, int32_t i, bool deep)
{
    for (int32_t k = 0; k < 3; k++) {
        const ptrdiff_t at = 3 * (ptrdiff_t) x + k;
        if (deep)
            ((uint16_t *) row)[at] = (uint16_t) b->c[k][i];
        else
            ((uint8_t *) row)[at] = (uint8_t) b->c[k][i];
    }
}

static void settle(const ntp__mixing *j, waiting *w, void *row, bool deep)
{
    if (w->n == 0)
        return;
    w->base.any_broken = w->detail.any_broken = false;
    j->settle(j->job, &w->base, &w->detail, w->n);
    for (int32_t i = 0; i < w->n; i++)
        put_texel(row, w->at[i], &w->base, i, deep);
    w->n = 0;
}

static void take_texel(ntp__block *b, int32_t i, ntp__mix_planes v, int32_t at, const constants *c)
{
    for (int32_t k = 0; k < 3; k++)
        b->c[k][i] = ntp__level((int32_t) v[k][at], c->m);
    b->c[3][i] = c->m;
}

/* Takes n texels of both, of which the detail repeats. */
static void take_block(planes *p, const ntp__mixing *j, int32_t x, int32_t y, int32_t n,
                       const constants *c)
{
    const ntp_const_image *d = j->detail;
    memset(p->left, 0, sizeof p->left);
    p->blends = d != NULL;
    p->any_kept = take(p->base, 0, ntp__at(j->base, x, y), n, c);
    for (int32_t done = 0, some; d != NULL && done < n; done += some) {
        const int32_t column = (x + done) % d->width, beside = d->width - column;
        some = beside < n - done ? beside : n - done;
        p->any_kept |= take(p->detail, done, ntp__at(d, column, y % d->height), some, c);
    }
}

void ntp__mix_row_avx2(const ntp__mixing *j, int32_t x0, int32_t x1, int32_t y)
{
    const int32_t m = ntp__max(j->dst->type);
    constants c = { .m = m,
                    .deep = j->dst->type == NTP_TYPE_U16,
                    .black = (j->touch_unused & NTP_UNUSED_BLACK) ? NAN : (float) -m,
                    .white = (j->touch_unused & NTP_UNUSED_WHITE) ? NAN : (float) m,
                    .rounding.half = 0.5F * (float) m,
                    .avx512 = ntp__cpu_has_avx512(NTP__CPU_ALL) };
    const ntp__mix_terms t = j->detail != NULL ? terms_of(&c, j) : (ntp__mix_terms) { .m = 0 };
    uint8_t *row = ntp__at_mut(j->dst, x0, y);
    waiting w;
    w.n = 0;
    for (int32_t x = x0, n; x < x1; x += n) {
        int32_t at[NTP__BLOCK];
        planes p;
        n = x1 - x < NTP__BLOCK ? x1 - x : NTP__BLOCK;
        take_block(&p, j, x, y, n, &c);
        if (j->detail != NULL)
            blend(&p, n, &t, &c);
        else
            boost(&p, n, j);
        const int32_t found =
            ntp__put_levels_avx2(row + (x - x0) * j->dst->pixel_stride, at, &p, n, &c);
        if (w.n + found > NTP__BLOCK)
            settle(j, &w, row, c.deep);
        for (int32_t i = 0; i < found; i++) {
            w.at[w.n] = x - x0 + at[i];
            take_texel(&w.base, w.n, p.base, at[i], &c);
            if (j->detail != NULL)
                take_texel(&w.detail, w.n, p.detail, at[i], &c);
            w.n++;
        }
    }
    settle(j, &w, row, c.deep);
    end_lanes();
}
