/* SPDX-License-Identifier: MIT */
/*
 * convert_avx2.c - packed RGB between the two encodings with a Z, and between depths, with AVX2
 *
 * The bytes are those of convert_runs.c, but no texel goes through memory on its way.  Red and green
 * are the halves of 32 bits, so pmaddwd adds up their squares.
 */
#include "repair/convert_avx2.h"

#include <immintrin.h>

enum { HALF = 8, STEP = 16 /* texels */, READ_BEYOND = 2 /* texels of 8 bit */ };

/* The shuffle of both halves; N: a byte that becomes 0. */
#define N -1
#define SHUFFLE(v, ...)                                                                            \
    _mm256_shuffle_epi8((v), _mm256_broadcastsi128_si256(_mm_setr_epi8(__VA_ARGS__)))

/* Eight texels: r | g << 16, and b. */
typedef struct texels {
    __m256i rg, b;
} texels;

typedef struct rules {
    bool from_zzero, to_zzero;
} rules;

static inline __m256i load_two(const uint8_t *low, const uint8_t *high)
{
    return _mm256_inserti128_si256(
        _mm256_castsi128_si256(_mm_loadu_si128((const __m128i *) (const void *) low)),
        _mm_loadu_si128((const __m128i *) (const void *) high), 1);
}

static inline texels take8(const uint8_t *s)
{
    const __m256i v = load_two(s, s + 12);
    const texels t = { SHUFFLE(v, 0, N, 1, N, 3, N, 4, N, 6, N, 7, N, 9, N, 10, N),
                       SHUFFLE(v, 2, N, N, N, 5, N, N, N, 8, N, N, N, 11, N, N, N) };
    return t;
}

static inline texels take16(const uint8_t *s)
{
    const __m256i v = load_two(s, s + 24), w = load_two(s + 8, s + 32);
    const texels t = {
        _mm256_or_si256(SHUFFLE(v, 0, 1, 2, 3, 6, 7, 8, 9, N, N, N, N, N, N, N, N),
                        SHUFFLE(w, N, N, N, N, N, N, N, N, 4, 5, 6, 7, 10, 11, 12, 13)),
        _mm256_or_si256(SHUFFLE(v, 4, 5, N, N, 10, 11, N, N, N, N, N, N, N, N, N, N),
                        SHUFFLE(w, N, N, N, N, N, N, N, N, 8, 9, N, N, 14, 15, N, N))
    };
    return t;
}

static inline void store(uint8_t *d, __m128i v)
{
    _mm_storeu_si128((__m128i *) (void *) d, v);
}

static inline void put16(uint8_t *d, texels t)
{
    const __m256i first =
        _mm256_or_si256(SHUFFLE(t.rg, 0, 1, 2, 3, N, N, 4, 5, 6, 7, N, N, 8, 9, 10, 11),
                        SHUFFLE(t.b, N, N, N, N, 0, 1, N, N, N, N, 4, 5, N, N, N, N));
    /* Bytes 8 to 23 of four texels */
    const __m256i last =
        _mm256_or_si256(SHUFFLE(t.rg, 6, 7, N, N, 8, 9, 10, 11, N, N, 12, 13, 14, 15, N, N),
                        SHUFFLE(t.b, N, N, 4, 5, N, N, N, N, 8, 9, N, N, N, N, 12, 13));
    store(d, _mm256_castsi256_si128(first));
    store(d + 8, _mm256_castsi256_si128(last));
    store(d + 24, _mm256_extracti128_si256(first, 1));
    store(d + 32, _mm256_extracti128_si256(last, 1));
}

/* Sixteen texels, not a byte more: dst may be src. */
static inline void put8(uint8_t *d, texels t, texels u)
{
    const __m256i v = SHUFFLE(_mm256_or_si256(t.rg, _mm256_slli_epi32(t.b, 8)), 0, 2, 1, 4, 6, 5, 8,
                              10, 9, 12, 14, 13, N, N, N, N);
    const __m256i w = SHUFFLE(_mm256_or_si256(u.rg, _mm256_slli_epi32(u.b, 8)), 0, 2, 1, 4, 6, 5, 8,
                              10, 9, 12, 14, 13, N, N, N, N);
    const __m128i v0 = _mm256_castsi256_si128(v), v1 = _mm256_extracti128_si256(v, 1);
    const __m128i w0 = _mm256_castsi256_si128(w), w1 = _mm256_extracti128_si256(w, 1);
    store(d, _mm_or_si128(v0, _mm_slli_si128(v1, 12)));
    store(d + 16, _mm_or_si128(_mm_srli_si128(v1, 4), _mm_slli_si128(w0, 8)));
    store(d + 32, _mm_or_si128(_mm_srli_si128(w0, 8), _mm_slli_si128(w1, 4)));
}

/* floor(c / 257) of 16-bit levels in 32 bits. */
static inline __m256i over257(__m256i c)
{
    return _mm256_srli_epi16(_mm256_sub_epi16(c, _mm256_srli_epi16(c, 8)), 8);
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

/* e = (S - 3) / 4 of pairs, as in kernels.c; negative where they are too long. */
static inline __m256i rest(__m256i rg, bool deep)
{
    const __m256i a = _mm256_sub_epi16(rg, _mm256_set1_epi16((short) (deep ? -32768 : 128)));
    const __m256i sum =
        _mm256_add_epi32(_mm256_madd_epi16(a, a), _mm256_madd_epi16(a, _mm256_set1_epi16(1)));
    return _mm256_sub_epi32(_mm256_set1_epi32(deep ? 1073709055 : 16255), sum);
}

/* floor(sqrt(e)), 0 where e is negative; as in root30.h.  pmaddwd squares 2^15 correctly too. */
static inline __m256i root(__m256i e)
{
    const __m256 f = _mm256_cvtepi32_ps(_mm256_max_epi32(e, _mm256_setzero_si256()));
    const __m256i t = _mm256_cvttps_epi32(_mm256_sqrt_ps(f));
    return _mm256_add_epi32(t, _mm256_cmpgt_epi32(_mm256_madd_epi16(t, t), e));
}

/* The derived blue, as in kernels.c. */
static inline __m256i blue(__m256i e, __m256i t, bool deep, bool zzero)
{
    if (!zzero)
        return _mm256_add_epi32(t, _mm256_set1_epi32(deep ? 32768 : 128));
    const __m256i d2 = _mm256_slli_epi32(_mm256_sub_epi32(e, _mm256_madd_epi16(t, t)), 1);
    const __m256i t2 = _mm256_add_epi32(t, t);
    const __m256i below1 = _mm256_cmpgt_epi32(t, _mm256_add_epi32(d2, _mm256_set1_epi32(1)));
    const __m256i below2 = _mm256_cmpgt_epi32(_mm256_add_epi32(t2, t), d2);
    return _mm256_add_epi32(_mm256_add_epi32(t2, _mm256_set1_epi32(2)),
                            _mm256_add_epi32(below1, below2));
}

/* Blue by value, as in convert.c. */
static inline __m256i blue_by_value(__m256i b, bool from_deep, bool to_deep, const rules *how)
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

/* `stop` marks texels that are black, where that matters, or have to be pulled; `negative` those
 * with z < 0. */
static inline texels converted(texels t, bool from_deep, bool to_deep, const rules *how,
                               __m256i *stop, __m256i *negative)
{
    const __m256i e = rest(t.rg, from_deep), zero = _mm256_setzero_si256();
    texels out = { deepen(t.rg, from_deep, to_deep), zero };
    const __m256i e_to = from_deep == to_deep ? e : rest(out.rg, to_deep), root_to = root(e_to);
    __m256i want = blue(e_to, root_to, to_deep, how->to_zzero), odd, minus = zero;
    if (how->from_zzero) {
        const __m256i root_from = from_deep == to_deep ? root_to : root(e);
        const __m256i same = _mm256_cmpeq_epi32(t.b, blue(e, root_from, from_deep, true));
        odd = _mm256_or_si256(_mm256_srai_epi32(e, 31),
                              _mm256_xor_si256(same, _mm256_set1_epi32(-1)));
    } else {
        /* as in flags_tmpl.h */
        const __m256i z = _mm256_sub_epi32(t.b, _mm256_set1_epi32(from_deep ? 32768 : 128));
        minus = _mm256_srai_epi32(z, 31);
        const __m256i up = _mm256_xor_si256(z, minus);
        const __m256i d = _mm256_sub_epi32(e, _mm256_madd_epi16(up, up));
        odd = _mm256_or_si256(_mm256_srai_epi32(d, 31),
                              _mm256_cmpgt_epi32(d, _mm256_add_epi32(up, up)));
        if (!how->to_zzero)
            want = _mm256_xor_si256(
                want, _mm256_and_si256(minus, _mm256_set1_epi32(to_deep ? 65535 : 255)));
    }
    out.b = _mm256_blendv_epi8(want, blue_by_value(t.b, from_deep, to_deep, how), odd);
    *negative = minus;
    *stop = _mm256_andnot_si256(odd, _mm256_srai_epi32(e_to, 31));
    if (how->from_zzero != how->to_zzero)
        *stop = _mm256_or_si256(*stop, _mm256_cmpeq_epi32(_mm256_or_si256(t.rg, t.b), zero));
    return out;
}

static inline int32_t convert(uint8_t *d, const uint8_t *s, int32_t n, bool from_deep, bool to_deep,
                              const rules *how, uint64_t *negative)
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
        for (int32_t k = 0; k < 2; k++) {
            const uint8_t *half = s + (ptrdiff_t) k * HALF * from;
            const texels in = from_deep ? take16(half) : take8(half);
            out[k] = converted(in, from_deep, to_deep, how, &stop[k], &minus[k]);
        }
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

int32_t ntp__convert_rgb_avx2(const ntp__conversion *j, int32_t x, int32_t y, int32_t n,
                              uint64_t *negative)
{
    const rules how = { j->src->encoding == NTP_ENCODING_ZZERO,
                        j->dst->encoding == NTP_ENCODING_ZZERO };
    uint8_t *d = ntp__at_mut(j->dst, x, y);
    const uint8_t *s = ntp__at(j->src, x, y);
    if (j->ms < j->md)
        return convert(d, s, n, false, true, &how, negative);
    if (j->ms > j->md)
        return convert(d, s, n, true, false, &how, negative);
    return j->ms > 255 ? convert(d, s, n, true, true, &how, negative)
                       : convert(d, s, n, false, false, &how, negative);
}
