/* SPDX-License-Identifier: MIT */
/*
 * normalize8_tmpl.h - packed RGB of 8 bit over the length of its vectors; a part of kernels.c
 *
 * With AVX2, and as in clean8_tmpl.h.  The numerator of r is 2a + 1, a = r - 128, and its size 2p + 1,
 * where p is a or -1 - a.  So bytes hold all p, and words the sum of all p(p + 1), which is the sum of
 * the squares less 3, over 4.  Only quotients are floats, in units of 2^-16 of a level, less than 2^23
 * of them.  Their root, division and product err by 2^-24 each, so the units by less than 2.
 */
#ifdef __AVX2__

enum { HALF_UNITS = 255 << 15 /* M/2 */, UNITS_OFF = 2, GROUP_8 = 16, MOST_8 = 256 };

/* Words c of even and odd places, as c + 1/2. */
static inline void to_floats(__m256 to[2], __m256i words)
{
    const __m256i above = _mm256_set1_epi16(0x4b00); /* of 2^23 + c */
    const __m256 less = _mm256_set1_ps(0x1p23F - 0.5F);
    const __m256i even = _mm256_blend_epi16(words, above, 0xaa);
    const __m256i odd = _mm256_blend_epi16(_mm256_srli_epi32(words, 16), above, 0xaa);
    to[0] = _mm256_sub_ps(_mm256_castsi256_ps(even), less);
    to[1] = _mm256_sub_ps(_mm256_castsi256_ps(odd), less);
}

/* p of the quotients of 16 numerators; *doubt: it may be another. */
static inline __m256i over_length(__m256i p, const __m256 factor[2], __m256i *doubt)
{
    __m256 v[2];
    to_floats(v, p);
    const __m256i even = _mm256_cvttps_epi32(_mm256_mul_ps(v[0], factor[0]));
    const __m256i odd = _mm256_cvttps_epi32(_mm256_mul_ps(v[1], factor[1]));
    /* (part + 2) modulo 2^16 < 4 */
    const __m256i part = _mm256_blend_epi16(even, _mm256_slli_epi32(odd, 16), 0xaa);
    const __m256i off = _mm256_add_epi16(part, _mm256_set1_epi16(UNITS_OFF - 32768));
    *doubt =
        _mm256_or_si256(*doubt, _mm256_cmpgt_epi16(_mm256_set1_epi16(2 * UNITS_OFF - 32768), off));
    return _mm256_blend_epi16(_mm256_srli_epi32(even, 16), odd, 0xaa);
}

static inline __m256i sizes(__m256i bytes, __m256i middle)
{
    const __m256i a = _mm256_xor_si256(bytes, middle);
    return _mm256_xor_si256(a, _mm256_cmpgt_epi8(_mm256_setzero_si256(), a));
}

/* Σ p(p + 1) of pairs. */
static inline __m256i sum_of_products(__m256i p)
{
    return _mm256_maddubs_epi16(_mm256_sub_epi8(p, _mm256_set1_epi8(-1)), p);
}

/* Sixteen pixels: their levels, which of them are rounded, and what makes numerators those of unit
 * vectors, in units.  All of a row are looked at before quotients are taken: of a chain that has a root
 * and what follows, few would be in flight. */
typedef struct group8 {
    __m256i pq, sign, s, b, rounded; /* sign: what makes p and q levels again */
    __m256 factor[2];
} group8;

/* *most: the greatest sum of products. */
static inline group8 look_8(const uint8_t *src, __m256i *most)
{
    const __m256i low = load_two(src, src + 24), high = load_two(src + 8, src + 32);
    const __m256i rg =
        _mm256_or_si256(SHUFFLE(low, 0, 1, 3, 4, 6, 7, 9, 10, 12, 13, N, N, N, N, N, N),
                        SHUFFLE(high, N, N, N, N, N, N, N, N, N, N, 7, 8, 10, 11, 13, 14));
    const __m256i b =
        _mm256_or_si256(SHUFFLE(low, 2, N, 5, N, 8, N, 11, N, 14, N, N, N, N, N, N, N),
                        SHUFFLE(high, N, N, N, N, N, N, N, N, N, N, 9, N, 12, N, 15, N));
    const __m256i pq = sizes(rg, _mm256_set1_epi8(-128)), s = sizes(b, _mm256_set1_epi16(128));
    const __m256i sum = _mm256_add_epi16(sum_of_products(pq), sum_of_products(s));
    /* as in normalize_tmpl.h, where this is off + 1, and this ks is 3 less: -ks < off <= ks - 3 */
    const __m256i off = _mm256_abs_epi16(_mm256_add_epi16(sum, _mm256_set1_epi16(1 - 128 * 127)));
    const __m256i ks = _mm256_add_epi16(_mm256_maddubs_epi16(_mm256_set1_epi8(1), pq), s);
    group8 g = { .pq = pq,
                 .sign = _mm256_xor_si256(pq, rg),
                 .s = s,
                 .b = b,
                 .rounded = _mm256_cmpgt_epi16(_mm256_add_epi16(ks, _mm256_set1_epi16(2)), off) };
    *most = _mm256_max_epu16(*most, sum);
    to_floats(g.factor, sum);
    for (int k = 0; k < 2; k++)
        g.factor[k] =
            _mm256_div_ps(_mm256_set1_ps(HALF_UNITS),
                          _mm256_sqrt_ps(_mm256_add_ps(g.factor[k], _mm256_set1_ps(0.25F))));
    return g;
}

/* Blue mirrored.  Unused ones stay as they are, and those of the result, which are in doubt: a bit in both
 * bytes of each.  `same` counts what is not changed, less than 0. */
static inline uint32_t normalize_group(uint8_t *dst, const group8 *g, const unused_blues *ends,
                                       bool corners, __m256i *same)
{
    const __m256i pq = g->pq, s = g->s, b = g->b, rounded = g->rounded;
    const __m256i middle = _mm256_set1_epi16(128);
    __m256i doubt = _mm256_setzero_si256();
    const __m256i p = over_length(_mm256_and_si256(pq, _mm256_set1_epi16(255)), g->factor, &doubt);
    const __m256i q = over_length(_mm256_srli_epi16(pq, 8), g->factor, &doubt);
    const __m256i t = over_length(s, g->factor, &doubt);
    const __m256i rg = _mm256_xor_si256(pq, g->sign), zero = _mm256_setzero_si256();
    __m256i unused = zero;
    if (corners)
        unused = _mm256_or_si256(
            _mm256_and_si256(_mm256_cmpeq_epi16(rg, zero),
                             _mm256_cmpeq_epi16(b, _mm256_set1_epi16((short) ends->black))),
            _mm256_and_si256(_mm256_cmpeq_epi16(rg, _mm256_set1_epi16(-1)),
                             _mm256_cmpeq_epi16(b, _mm256_set1_epi16((short) ends->white))));
    doubt = _mm256_andnot_si256(_mm256_or_si256(rounded, unused), doubt);
    const __m256i keep = _mm256_or_si256(doubt, unused);
    const __m256i to_pq = _mm256_blendv_epi8(_mm256_or_si256(p, _mm256_slli_epi16(q, 8)), pq,
                                             _mm256_or_si256(rounded, keep));
    const __m256i to_s = _mm256_blendv_epi8(t, s, rounded);
    const __m256i to_b = _mm256_blendv_epi8(_mm256_xor_si256(to_s, middle), b, keep);
    *same = _mm256_add_epi16(
        *same, _mm256_and_si256(_mm256_cmpeq_epi16(to_pq, pq), _mm256_cmpeq_epi16(to_b, b)));
    store_pixels(dst, _mm256_xor_si256(to_pq, g->sign), to_b);
    return (uint32_t) _mm256_movemask_epi8(doubt);
}

static int32_t normalize_rgb8(void *dst, const void *src, int32_t n, uint32_t touch_unused,
                              int32_t *at, uint64_t *changed)
{
    const unused_blues ends = blues_of_unused(255, touch_unused);
    __m256i same = _mm256_setzero_si256(), most = same;
    group8 groups[MOST_8 / GROUP_8];
    int16_t each[16];
    int32_t found = 0;
    for (int32_t i = 0; i < n; i += GROUP_8)
        groups[i / GROUP_8] = look_8((const uint8_t *) src + (ptrdiff_t) 3 * i, &most);
    /* only corners of the cube can be unused */
    most = _mm256_cmpeq_epi16(most, _mm256_set1_epi16((short) (3 * 127 * 128)));
    const bool corners = !_mm256_testz_si256(most, most);
    for (int32_t i = 0; i < n; i += GROUP_8) {
        const group8 *g = groups + i / GROUP_8;
        uint32_t left =
            normalize_group((uint8_t *) dst + (ptrdiff_t) 3 * i, g, &ends, corners, &same) &
            0x55555555;
        for (; left != 0; left &= left - 1)
            at[found++] = i + __builtin_ctz(left) / 2;
    }
    _mm256_storeu_si256((__m256i *) (void *) each, same);
    *changed += (uint64_t) n;
    for (int32_t k = 0; k < 16; k++)
        *changed -= (uint64_t) -each[k];
    return found;
}

#else
#  define normalize_rgb8 NULL
#endif
