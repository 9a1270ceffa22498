/* SPDX-License-Identifier: MIT */
/*
 * convert_avx2.c - packed RGB between the two encodings with a Z, and between depths, with AVX2
 *
 * The bytes are those of convert_runs.c, but no texel goes through memory on its way.  Levels to float
 * vectors, and these to levels, are here too.
 */
#include "repair/convert_avx2.h"

#include "base/inlining.h"
#include "texel/packed_avx2_tmpl.h"

/* Of two depths: with these as arguments at run time loops take longer, by a fifth and more. */
#define FOR_EACH_DEPTH static ALWAYS_INLINE

enum { HALF = 8, STEP = 16 /* texels */, READ_BEYOND = 2 /* texels of 8 bit */ };

typedef struct rules {
    bool from_zzero, to_zzero;
} rules;

/* floor(c / 257) of 16-bit levels: 257 * 0xff01 is 2^24 + 1. */
static inline __m256i over257(__m256i c)
{
    return _mm256_srli_epi16(_mm256_mulhi_epu16(c, _mm256_set1_epi16((short) 0xff01)), 8);
}

/* Levels in halves of 32 bits at the new depth: 257c, and (c + 128) / 257, which is 255 also where
 * the sum saturates. */
static inline __m256i deepen(__m256i c, bool from_deep, bool to_deep)
{
    if (from_deep == to_deep)
        return c;
    return from_deep ? over257(_mm256_adds_epu16(c, _mm256_set1_epi16(128)))
                     : _mm256_or_si256(c, _mm256_slli_epi16(c, 8));
}

/* Blue by value, as in convert.c. */
FOR_EACH_DEPTH __m256i blue_by_value(__m256i b, bool from_deep, bool to_deep, const rules *how)
{
    if (how->from_zzero == how->to_zzero)
        return deepen(b, from_deep, to_deep);
    if (how->to_zzero) {
        const __m256i m = _mm256_set1_epi32(from_deep ? 65535 : 255);
        const __m256i z = _mm256_abs_epi32(_mm256_sub_epi32(_mm256_add_epi32(b, b), m));
        return deepen(z, from_deep, to_deep);
    }
    if (from_deep && !to_deep)
        b = over257(b);
    else
        b = deepen(b, from_deep, to_deep);
    return _mm256_srli_epi32(_mm256_add_epi32(b, _mm256_set1_epi32(to_deep ? 65536 : 256)), 1);
}

/* Marks texels that are not exact, and finds the root of e in what is left of blue; `minus`: z < 0. */
FOR_EACH_DEPTH __m256i odd_of(__m256i e, __m256i b, bool deep, bool zzero, __m256i *t,
                              __m256i *minus)
{
    *minus = _mm256_setzero_si256();
    if (zzero) { /* -b < 4e + 3 - b*b <= b, also modulo 2^32: e >= 0 is below 2^30 - 2^15 */
        const __m256i square = deep ? _mm256_mullo_epi32(b, b) : _mm256_madd_epi16(b, b);
        const __m256i v = _mm256_sub_epi32(
            _mm256_add_epi32(_mm256_slli_epi32(e, 2), _mm256_set1_epi32(3)), square);
        const __m256i low = _mm256_cmpgt_epi32(_mm256_add_epi32(v, b), _mm256_setzero_si256());
        const __m256i half = _mm256_srli_epi32(b, 1); /* of 2t, 2t + 1 or 2t + 2 */
        *t = _mm256_add_epi32(half, _mm256_cmpgt_epi32(_mm256_madd_epi16(half, half), e));
        return _mm256_or_si256(_mm256_or_si256(_mm256_srai_epi32(e, 31), _mm256_cmpgt_epi32(v, b)),
                               _mm256_xor_si256(low, _mm256_set1_epi32(-1)));
    }
    /* as in flags_tmpl.h */
    const __m256i z = _mm256_sub_epi32(b, _mm256_set1_epi32(deep ? 32768 : 128));
    *minus = _mm256_srai_epi32(z, 31);
    *t = _mm256_xor_si256(z, *minus);
    const __m256i d = _mm256_sub_epi32(e, _mm256_madd_epi16(*t, *t));
    return _mm256_or_si256(_mm256_srai_epi32(d, 31),
                           _mm256_cmpgt_epi32(d, _mm256_add_epi32(*t, *t)));
}

/* `stop` marks texels that are black, where that matters, or have to be pulled, as only coarser levels
 * make that of exact ones; `negative` those with z < 0. */
FOR_EACH_DEPTH texels converted(texels t, bool from_deep, bool to_deep, const rules *how,
                                __m256i *stop, __m256i *negative)
{
    const __m256i e = rest_of(t.rg, from_deep), zero = _mm256_setzero_si256();
    texels out = { deepen(t.rg, from_deep, to_deep), zero };
    __m256i e_to = e, root_to, minus;
    const __m256i odd = odd_of(e, t.b, from_deep, how->from_zzero, &root_to, &minus);
    if (from_deep != to_deep) {
        /* 257 X: S is 257^2 times as much */
        e_to = from_deep ? rest_of(out.rg, to_deep)
                         : _mm256_add_epi32(_mm256_mullo_epi32(e, _mm256_set1_epi32(257 * 257)),
                                            _mm256_set1_epi32(3 * (257 * 257 - 1) / 4));
        root_to = root_of(e_to, to_deep);
    }
    __m256i want = blue_of(e_to, root_to, to_deep, how->to_zzero);
    if (!how->to_zzero)
        want = _mm256_xor_si256(want,
                                _mm256_and_si256(minus, _mm256_set1_epi32(to_deep ? 65535 : 255)));
    out.b = _mm256_blendv_epi8(want, blue_by_value(t.b, from_deep, to_deep, how), odd);
    *negative = minus;
    *stop = from_deep && !to_deep ? _mm256_andnot_si256(odd, _mm256_srai_epi32(e_to, 31)) : zero;
    if (how->from_zzero != how->to_zzero)
        *stop = _mm256_or_si256(*stop, _mm256_cmpeq_epi32(_mm256_or_si256(t.rg, t.b), zero));
    return out;
}

FOR_EACH_DEPTH int32_t convert(uint8_t *d, const uint8_t *s, int32_t n, bool from_deep,
                               bool to_deep, const rules *how, uint64_t *negative)
{
    const int32_t beyond = from_deep ? 0 : READ_BEYOND, from = from_deep ? 6 : 3;
    const int32_t to = to_deep ? 6 : 3;
    __m256i count = _mm256_setzero_si256();
    uint32_t counts[HALF];
    int32_t i = 0;
    for (; i + STEP + beyond <= n;
         i += STEP, s += (ptrdiff_t) STEP * from, d += (ptrdiff_t) STEP * to) {
        texels out[2];
        __m256i stop[2], minus[2];
        const uint8_t *other = s + (ptrdiff_t) HALF * from;
        out[0] = converted(from_deep ? take16(s) : take8(s), from_deep, to_deep, how, &stop[0],
                           &minus[0]);
        out[1] = converted(from_deep ? take16(other) : take8(other), from_deep, to_deep, how,
                           &stop[1], &minus[1]);
        const __m256i any = _mm256_or_si256(stop[0], stop[1]);
        if (!_mm256_testz_si256(any, any))
            break;
        count = _mm256_sub_epi32(count, _mm256_add_epi32(minus[0], minus[1]));
        if (to_deep) {
            put16(d, out[0]);
            put16(d + (ptrdiff_t) HALF * to, out[1]);
        } else {
            put8(d, out[0], out[1]);
        }
    }
    _mm256_storeu_si256((__m256i *) (void *) counts, count);
    for (int32_t k = 0; k < HALF && how->to_zzero; k++)
        *negative += counts[k];
    return i;
}

#include "repair/convert_words_tmpl.h"

int32_t ntp__convert_rgb_avx2(const ntp__conversion *j, uint8_t *d, const uint8_t *s, int32_t n,
                              uint64_t *negative)
{
    const rules how = { j->src->encoding == NTP_ENCODING_ZZERO,
                        j->dst->encoding == NTP_ENCODING_ZZERO };
    const bool standard = !how.from_zzero && !how.to_zzero;
    if (standard)
        return j->ms < j->md ? widen(d, s, n) : narrow(d, s, n);
    if (!how.from_zzero && j->ms == j->md)
        return j->ms > 255 ? to_zzero(d, s, n, true, ntp__black_is_unused(j), negative)
                           : to_zzero(d, s, n, false, ntp__black_is_unused(j), negative);
    if (j->ms < j->md)
        return convert(d, s, n, false, true, &how, negative);
    if (j->ms > j->md)
        return convert(d, s, n, true, false, &how, negative);
    return j->ms > 255 ? convert(d, s, n, true, true, &how, negative)
                       : convert(d, s, n, false, false, &how, negative);
}

/* What convert_packed.c does with samples, eight at a time. */
static inline void decode(float *d, const uint8_t *s, bool deep, __m256 times, __m256 less,
                          __m256 over)
{
    const __m128i c = _mm_loadu_si128((const __m128i *) (const void *) s);
    const __m256i wide = deep ? _mm256_cvtepu16_epi32(c) : _mm256_cvtepu8_epi32(c);
    const __m256 v = _mm256_sub_ps(_mm256_mul_ps(_mm256_cvtepi32_ps(wide), times), less);
    _mm256_storeu_ps(d, _mm256_add_ps(v, _mm256_mul_ps(v, over)));
}

FOR_EACH_DEPTH int32_t decode_run(float *d, const uint8_t *s, int32_t samples, bool deep,
                                  const float times[24], const float less[24])
{
    enum { SAMPLES = 24 /* whole texels of 2, 3 and 4 channels */, READ = 16 };
    const int32_t size = deep ? 2 : 1, beyond = deep ? 0 : READ - HALF;
    const __m256 over = _mm256_set1_ps(1 / (deep ? 65535.0f : 255.0f));
    __m256 by[3], off[3];
    int32_t i = 0;
    for (int32_t k = 0; k < 3; k++) {
        by[k] = _mm256_loadu_ps(times + HALF * k);
        off[k] = _mm256_loadu_ps(less + HALF * k);
    }
    for (; i + SAMPLES + beyond <= samples; i += SAMPLES) {
        for (int32_t k = 0; k < 3; k++)
            decode(d + i + HALF * k, s + (ptrdiff_t) size * (i + HALF * k), deep, by[k], off[k],
                   over);
    }
    return i;
}

int32_t ntp__decode_avx2(float *d, const void *s, int32_t n, int32_t channels, bool deep,
                         const float times[4], const float less[4])
{
    float by[24], off[24];
    for (int32_t i = 0; i < 24; i++) {
        by[i] = times[i % channels];
        off[i] = less[i % channels];
    }
    const int32_t done = deep ? decode_run(d, s, channels * n, true, by, off)
                              : decode_run(d, s, channels * n, false, by, off);
    return done / channels;
}

/*
 * Float vectors of a length from 2^-20 to 2^20, to levels.  M |x|/2L is taken in units of 1/UNITS, as
 * in directions_tmpl.h.  u is 2^-24, and squares of it are left out.
 * For 8 bits in floats: a sum of three squares errs by 3u of it, its root by 2.5u, the quotient by
 * 3.5u and the product by 4.5u, which is less than 2 units, as there are less than 2^22.
 * For 16 bits the float 1/L errs by 3.5u.  A step of Newton in doubles leaves 1.5 times the square
 * of that, so less than 2^-43, and its own roundings less than 2^-49: of 2^30 units less than one.
 */
enum { UNIT_BITS = 15, UNITS = 1 << UNIT_BITS };

typedef struct vectors {
    __m256 x, y, z;
} vectors;

static inline vectors take_vectors(const float *s)
{
    const uint8_t *p = (const uint8_t *) (const void *) s;
    const __m256 a = _mm256_castsi256_ps(load_two(p, p + 48));
    const __m256 b = _mm256_castsi256_ps(load_two(p + 16, p + 64));
    const __m256 c = _mm256_castsi256_ps(load_two(p + 32, p + 80));
    const __m256 xy = _mm256_shuffle_ps(b, c, _MM_SHUFFLE(2, 1, 3, 2));
    const __m256 yz = _mm256_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 2, 1));
    const vectors v = { _mm256_shuffle_ps(a, xy, _MM_SHUFFLE(2, 0, 3, 0)),
                        _mm256_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0)),
                        _mm256_shuffle_ps(yz, c, _MM_SHUFFLE(3, 0, 3, 1)) };
    return v;
}

static inline __m256 sum_of_squares(vectors v)
{
    return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(v.x, v.x), _mm256_mul_ps(v.y, v.y)),
                         _mm256_mul_ps(v.z, v.z));
}

/* Units of the x and y of four texels of 16 bit, given 1/L as floats. */
static inline void units_16(__m128i to[2], __m128 x, __m128 y, __m128 z, __m128 over)
{
    const __m256d none = _mm256_set1_pd(-0.0), r = _mm256_cvtps_pd(over);
    const __m256d a = _mm256_andnot_pd(none, _mm256_cvtps_pd(x));
    const __m256d b = _mm256_andnot_pd(none, _mm256_cvtps_pd(y)), c = _mm256_cvtps_pd(z);
    const __m256d square =
        _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(a, a), _mm256_mul_pd(b, b)), _mm256_mul_pd(c, c));
    const __m256d rest =
        _mm256_sub_pd(_mm256_set1_pd(3), _mm256_mul_pd(square, _mm256_mul_pd(r, r)));
    const __m256d factor =
        _mm256_mul_pd(_mm256_mul_pd(r, _mm256_set1_pd(65535.0 / 4 * UNITS)), rest);
    to[0] = _mm256_cvttpd_epi32(_mm256_mul_pd(a, factor));
    to[1] = _mm256_cvttpd_epi32(_mm256_mul_pd(b, factor));
}

FOR_EACH_DEPTH void units_of(__m256i to[2], vectors v, __m256 square, bool deep)
{
    const __m256 none = _mm256_set1_ps(-0.0F), length = _mm256_sqrt_ps(square);
    if (!deep) {
        const __m256 factor = _mm256_div_ps(_mm256_set1_ps(255.0F / 2 * UNITS), length);
        to[0] = _mm256_cvttps_epi32(_mm256_mul_ps(_mm256_andnot_ps(none, v.x), factor));
        to[1] = _mm256_cvttps_epi32(_mm256_mul_ps(_mm256_andnot_ps(none, v.y), factor));
        return;
    }
    const __m256 over = _mm256_div_ps(_mm256_set1_ps(1), length);
    __m128i low[2], high[2];
    units_16(low, _mm256_castps256_ps128(v.x), _mm256_castps256_ps128(v.y),
             _mm256_castps256_ps128(v.z), _mm256_castps256_ps128(over));
    units_16(high, _mm256_extractf128_ps(v.x, 1), _mm256_extractf128_ps(v.y, 1),
             _mm256_extractf128_ps(v.z, 1), _mm256_extractf128_ps(over, 1));
    for (int32_t k = 0; k < 2; k++)
        to[k] = _mm256_inserti128_si256(_mm256_castsi128_si256(low[k]), high[k], 1);
}

/* The level of so many units; *doubt: they may lie on the other side of a level.  0 is none, as the
 * sign is right. */
static inline __m256i level_of(__m256i units, __m256 component, bool deep, __m256i *doubt)
{
    const int32_t off = deep ? 1 : 2;
    const __m256i part = _mm256_and_si256(_mm256_add_epi32(units, _mm256_set1_epi32(off)),
                                          _mm256_set1_epi32(UNITS - 1));
    const __m256i near =
        _mm256_andnot_si256(_mm256_cmpgt_epi32(part, _mm256_set1_epi32(2 * off - 1)),
                            _mm256_cmpgt_epi32(units, _mm256_set1_epi32(off - 1)));
    const __m256 minus = _mm256_cmp_ps(component, _mm256_setzero_ps(), _CMP_LT_OQ);
    *doubt = _mm256_or_si256(*doubt, near);
    return _mm256_add_epi32(
        _mm256_xor_si256(_mm256_srli_epi32(units, UNIT_BITS), _mm256_castps_si256(minus)),
        _mm256_set1_epi32(deep ? 32768 : 128));
}

static inline uint32_t bits_of(__m256 v)
{
    return (uint32_t) _mm256_movemask_ps(v);
}

/* Eight texels; *doubt, *overlong, *negative: bits of those that are. */
FOR_EACH_DEPTH texels encoded(const float *s, bool deep, bool zzero, __m256 flip, uint32_t *doubt,
                              uint32_t *overlong, uint32_t *negative)
{
    vectors v = take_vectors(s);
    v.y = _mm256_xor_ps(v.y, flip);
    const __m256 square = sum_of_squares(v);
    const __m256 least = _mm256_cmp_ps(square, _mm256_set1_ps(0x1p-40F), _CMP_GE_OQ);
    const __m256 most = _mm256_cmp_ps(square, _mm256_set1_ps(0x1p40F), _CMP_LE_OQ);
    __m256i units[2], near = _mm256_setzero_si256();
    units_of(units, v, square, deep);
    const __m256i r = level_of(units[0], v.x, deep, &near);
    const __m256i g = level_of(units[1], v.y, deep, &near);
    texels t = { _mm256_or_si256(r, _mm256_slli_epi32(g, 16)), near };
    const __m256i e = rest_of(t.rg, deep);
    const __m256 down = _mm256_cmp_ps(v.z, _mm256_setzero_ps(), _CMP_LT_OQ);
    t.b = _mm256_andnot_si256(_mm256_srai_epi32(e, 31), blue_of(e, root_of(e, deep), deep, zzero));
    if (!zzero)
        t.b = _mm256_xor_si256(t.b, _mm256_and_si256(_mm256_castps_si256(down),
                                                     _mm256_set1_epi32(deep ? 65535 : 255)));
    *doubt = bits_of(_mm256_castsi256_ps(near)) | (bits_of(_mm256_and_ps(least, most)) ^ 0xff);
    *overlong = bits_of(_mm256_castsi256_ps(e));
    *negative = bits_of(down);
    return t;
}

FOR_EACH_DEPTH int32_t encode(uint8_t *d, const float *s, int32_t n, bool deep, bool zzero,
                              __m256 flip, ntp__left *left)
{
    const int32_t size = deep ? 6 : 3;
    int32_t i = 0;
    for (; i + STEP <= n; i += STEP, left++) {
        uint32_t doubt[2], overlong[2], negative[2];
        texels t[2];
        t[0] = encoded(s + 3 * i, deep, zzero, flip, &doubt[0], &overlong[0], &negative[0]);
        t[1] =
            encoded(s + 3 * (i + HALF), deep, zzero, flip, &doubt[1], &overlong[1], &negative[1]);
        if (deep) {
            put16(d + (ptrdiff_t) size * i, t[0]);
            put16(d + (ptrdiff_t) size * (i + HALF), t[1]);
        } else {
            put8(d + (ptrdiff_t) size * i, t[0], t[1]);
        }
        left->doubt = doubt[0] | doubt[1] << HALF;
        left->overlong = overlong[0] | overlong[1] << HALF;
        left->negative = negative[0] | negative[1] << HALF;
    }
    return i;
}

int32_t ntp__encode_rgb_avx2(void *d, const float *s, int32_t n, bool deep, bool zzero, bool flip,
                             ntp__left *left)
{
    const __m256 minus = _mm256_set1_ps(flip ? -0.0F : 0.0F);
    return deep ? encode(d, s, n, true, zzero, minus, left)
                : encode(d, s, n, false, zzero, minus, left);
}
