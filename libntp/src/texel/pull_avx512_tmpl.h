/* SPDX-License-Identifier: MIT */
/*
 * pull_avx512_tmpl.h - pulls pairs of 16 bit that are too long, with AVX-512; a part of kernels_avx512.c
 */

enum { ROOM_16 = 256 + LANES_512 };

/* Pairs of a block that are too long, in whole steps; what |X| and |Y| become, halved, in units of 2^-16; and
 * blues, negative where the pair is in doubt.  One loop for all that is done to them would wait, as it has long
 * chains. */
typedef struct many_long {
    int32_t rg[ROOM_16], unit[2][ROOM_16], blue[ROOM_16];
} many_long;

/* What eight |X| and |Y| become.  The squares of X and Y have the sum 4w + 2, and roots are those of normalize_rgb: a
 * unit is off by less than 2^-9. */
static inline void shorten(many_long *to, int32_t first, __m256i w, __m256i x, __m256i y)
{
    const __m512i square = sum_of(_mm512_castpd_si512(_mm512_cvtepi32_pd(w)), of(0.5, true), true);
    const __m512i r = inverse_root(square, true);
    const __m512i minus_e = fused(times(square, r, true), r, of(-1, true), true);
    const __m512i by = fused(minus_e, of(0.375, true), of(-0.5, true), true);
    const __m512i scaled = times(r, of(65535 * 65536.0 / 4, true), true);
    const __m512d factor =
        _mm512_castsi512_pd(fused(times(scaled, minus_e, true), by, scaled, true));
    _mm256_storeu_si256((void *) (to->unit[0] + first),
                        _mm512_cvtpd_epi32(_mm512_mul_pd(_mm512_cvtepi32_pd(x), factor)));
    _mm256_storeu_si256((void *) (to->unit[1] + first),
                        _mm512_cvtpd_epi32(_mm512_mul_pd(_mm512_cvtepi32_pd(y), factor)));
}

static inline void shorten_sixteen(many_long *to, int32_t first)
{
    const __m512i rg = _mm512_loadu_si512(to->rg + first), one = _mm512_set1_epi32(1);
    const __m512i p = _mm512_xor_si512(rg, _mm512_set1_epi16(-32768));
    const __m512i q = _mm512_xor_si512(p, _mm512_srai_epi16(p, 15)), twice = _mm512_add_epi16(q, q);
    const __m512i x = _mm512_or_si512(_mm512_and_si512(twice, _mm512_set1_epi32(65535)), one);
    const __m512i y = _mm512_or_si512(_mm512_srli_epi32(twice, 16), one);
    const __m512i w = _mm512_sub_epi32(_mm512_set1_epi32(REST_16), rest_of(rg, true));
    shorten(to, first, _mm512_castsi512_si256(w), _mm512_castsi512_si256(x),
            _mm512_castsi512_si256(y));
    shorten(to, first + 8, _mm512_extracti64x4_epi64(w, 1), _mm512_extracti64x4_epi64(x, 1),
            _mm512_extracti64x4_epi64(y, 1));
}

/* Pulls them as pull() in judge_tmpl.h, and derives their blues.  Whole units are the nearest, so a pair is in doubt
 * where they are a whole size; but all become less than they were. */
static inline void pull_sixteen(many_long *to, int32_t first, bool zzero)
{
    const __m512i flip = _mm512_set1_epi16(-32768), half = _mm512_set1_epi32(32768);
    const __m512i p = _mm512_xor_si512(_mm512_loadu_si512(to->rg + first), flip);
    const __m512i sign = _mm512_srai_epi16(p, 15), last = _mm512_set1_epi32(65535);
    const __m512i q = _mm512_xor_si512(p, sign);
    const __m512i u =
        _mm512_min_epu32(_mm512_add_epi32(_mm512_loadu_si512(to->unit[0] + first), half),
                         _mm512_or_si512(_mm512_slli_epi32(q, 16), last));
    const __m512i v = _mm512_min_epu32(
        _mm512_add_epi32(_mm512_loadu_si512(to->unit[1] + first), half), _mm512_or_si512(q, last));
    const __m512i sizes = _mm512_mask_mov_epi16(_mm512_srli_epi32(u, 16), 0xaaaaaaaa, v);
    const __m512i size = onto_disc(sizes, q, true);
    const __m512i rg = _mm512_xor_si512(size, _mm512_xor_si512(sign, flip));
    const __mmask16 doubt = _mm512_testn_epi32_mask(u, last) | _mm512_testn_epi32_mask(v, last);
    _mm512_storeu_si512(to->rg + first, rg);
    _mm512_storeu_si512(to->blue + first, _mm512_mask_mov_epi32(blue_of(rest_of(rg, true), zzero),
                                                                doubt, _mm512_set1_epi32(-1)));
}

/* Pulls the found pairs of a block, of which pixels have a bit in `which`.  Returns how many are in doubt. */
static int32_t pull_pixels(uint16_t *dst, const uint16_t *src, many_long *v, int32_t found,
                           const __mmask16 *which, int32_t n, bool zzero, int32_t *at)
{
    enum { LINE = 32 /* samples */, AS_MANY = 3 * LANES_512 };
    int32_t left = 0, done = 0;
    for (int32_t i = 0; i < found; i += LANES_512) {
        /* the next block: while this one is pulled, none of it is fetched by itself */
        for (int32_t k = 3 * (n + i); k < 3 * (n + i) + AS_MANY; k += LINE) {
            _mm_prefetch((const char *) (src + k), _MM_HINT_T0);
            _mm_prefetch((const char *) (dst + k), _MM_HINT_T0);
        }
        shorten_sixteen(v, i);
    }
    for (int32_t i = 0; i < found; i += LANES_512)
        pull_sixteen(v, i, zzero);
    for (int32_t i = 0; i < n; i += LANES_512) {
        const __mmask16 longs = which[i / LANES_512];
        if (longs == 0)
            continue;
        const texels t = take16((const uint8_t *) (dst + 3 * i));
        const __m512i blue = _mm512_maskz_expand_epi32(longs, _mm512_loadu_si512(v->blue + done));
        const __m512i rg = _mm512_maskz_expand_epi32(longs, _mm512_loadu_si512(v->rg + done));
        const __mmask16 doubt = _mm512_cmplt_epi32_mask(blue, _mm512_setzero_si512()),
                        sure = longs & (__mmask16) ~doubt;
        put16((uint8_t *) (dst + 3 * i), (texels) { _mm512_mask_mov_epi32(t.rg, sure, rg),
                                                    _mm512_mask_mov_epi32(t.b, sure, blue) });
        /* No more than i places are known yet: there is room for as many as texels are looked at. */
        _mm512_storeu_si512(at + left, _mm512_maskz_compress_epi32(doubt, steps_of(1, i)));
        left += __builtin_popcount(doubt);
        done += __builtin_popcount(longs);
    }
    return left;
}
