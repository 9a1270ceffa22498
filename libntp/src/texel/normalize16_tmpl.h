/* SPDX-License-Identifier: MIT */
/*
 * normalize16_tmpl.h - packed RGB of 16 bit over the length of its vectors; a part of kernels.c
 *
 * As normalize8_tmpl.h, with AVX2.  The sum of all p(p + 1) is 2h, and that of the squares 8h + 3.  A
 * float r of 1/sqrt(h + 3/8) is off by at most 3u, u = 2^-24: h as a float by u, the sum by u more,
 * so the root by 2u and the quotient by 3u.  A step of Newton in doubles leaves 1.5 times the square
 * of that, less than 2^-44, and its own roundings less than 2^-49.  Of less than 2^31 units of 2^-16
 * of a level that is less than half of one, and whole units are the nearest: so the level may be another
 * only where they are a whole level.
 */
#ifdef __AVX2__

/* One or the other, by the sign of words. */
static inline __m256i choose(__m256i a, __m256i b, __m256i if_negative)
{
    return _mm256_castps_si256(_mm256_blendv_ps(_mm256_castsi256_ps(a), _mm256_castsi256_ps(b),
                                                _mm256_castsi256_ps(if_negative)));
}

/* Where units are a whole level. */
static inline __m256i near_levels(const __m256i u[3])
{
    const __m256i zero = _mm256_setzero_si256();
    const __m256i part = _mm256_blend_epi16(u[0], _mm256_slli_epi32(u[1], 16), 0xaa);
    const __m256i rg = _mm256_cmpeq_epi16(part, zero), b = _mm256_cmpeq_epi16(u[2], zero);
    return _mm256_or_si256(rg, _mm256_slli_epi32(_mm256_or_si256(rg, b), 16));
}

/* Eight pixels: their levels, p and q in halves of words, and s. */
typedef struct deep_pixels {
    __m256i rg, b, pq, s;
} deep_pixels;

static inline deep_pixels take_deep(const uint8_t *src)
{
    const texels v = take16(src);
    const __m256i a = _mm256_xor_si256(v.rg, _mm256_set1_epi16(-32768));
    const __m256i z = _mm256_sub_epi32(v.b, _mm256_set1_epi32(32768));
    const deep_pixels t = { v.rg, v.b, _mm256_xor_si256(a, _mm256_srai_epi16(a, 15)),
                            _mm256_xor_si256(z, _mm256_srai_epi32(z, 31)) };
    return t;
}

/* What is known between the steps, each of which goes over all pixels.  In one loop a processor would
 * wait: it has registers for few chains of so many operations. */
typedef struct deep_planes {
    int32_t h[256];
    float over[256];            /* r */
    int32_t unit[3][256];       /* sizes of numerators, then those of the quotients in units */
    int32_t pq[256], sign[256]; /* p and q; what makes them levels again */
    int32_t s[256], b[256], rounded[256];
} deep_planes;

static inline void store_plane(int32_t *plane, __m256i v)
{
    _mm256_storeu_si256((__m256i *) (void *) plane, v);
}

static inline __m256i load_plane(const int32_t *plane)
{
    return _mm256_loadu_si256((const __m256i *) (const void *) plane);
}

/* Returns whether a corner of the cube is among them: only these can be unused. */
static inline bool sum_up(deep_planes *to, const uint8_t *src, int32_t n)
{
    const __m256i one = _mm256_set1_epi16(1);
    __m256i most = _mm256_setzero_si256();
    for (int32_t i = 0; i < n; i += 8) {
        const deep_pixels t = take_deep(src + (ptrdiff_t) 6 * i);
        const __m256i size = _mm256_add_epi32(_mm256_madd_epi16(t.pq, one), t.s);
        const __m256i squares =
            _mm256_add_epi32(_mm256_madd_epi16(t.pq, t.pq), _mm256_madd_epi16(t.s, t.s));
        const __m256i sum = _mm256_add_epi32(squares, size), h = _mm256_srli_epi32(sum, 1);
        /* as in normalize_tmpl.h, see normalize_group */
        const __m256i off =
            _mm256_abs_epi32(_mm256_add_epi32(sum, _mm256_set1_epi32(1 - 32768 * 32767)));
        const __m256 square = _mm256_add_ps(_mm256_cvtepi32_ps(h), _mm256_set1_ps(0.375F));
        const __m256i x = _mm256_add_epi16(_mm256_add_epi16(t.pq, t.pq), one);
        most = _mm256_max_epu32(most, sum);
        store_plane(to->h + i, h);
        store_plane(to->unit[0] + i, _mm256_and_si256(x, _mm256_set1_epi32(0xffff)));
        store_plane(to->unit[1] + i, _mm256_srli_epi32(x, 16));
        store_plane(to->unit[2] + i,
                    _mm256_add_epi32(_mm256_add_epi32(t.s, t.s), _mm256_set1_epi32(1)));
        store_plane(to->pq + i, t.pq);
        store_plane(to->sign + i, _mm256_xor_si256(t.pq, t.rg));
        store_plane(to->s + i, t.s);
        store_plane(to->b + i, t.b);
        store_plane(to->rounded + i,
                    _mm256_cmpgt_epi32(_mm256_add_epi32(size, _mm256_set1_epi32(2)), off));
        _mm256_storeu_ps(to->over + i, _mm256_div_ps(_mm256_set1_ps(1), _mm256_sqrt_ps(square)));
    }
    most = _mm256_cmpeq_epi32(most, _mm256_set1_epi32((int32_t) (3U * 32767 * 32768)));
    return !_mm256_testz_si256(most, most);
}

static inline __m256d load_four(const int32_t *plane)
{
    return _mm256_cvtepi32_pd(_mm_loadu_si128((const __m128i *) (const void *) plane));
}

static inline void divide(deep_planes *to, int32_t n)
{
    const double half = 65535.0 * 32768 / 4 * 0.70710678118654752; /* M/(4 sqrt(8)) in units */
    for (int32_t i = 0; i < n; i += 4) {
        const __m256d over = _mm256_cvtps_pd(_mm_loadu_ps(to->over + i));
        const __m256d square = _mm256_add_pd(load_four(to->h + i), _mm256_set1_pd(0.375));
        const __m256d rest =
            _mm256_sub_pd(_mm256_set1_pd(3), _mm256_mul_pd(square, _mm256_mul_pd(over, over)));
        const __m256d factor = _mm256_mul_pd(_mm256_mul_pd(over, _mm256_set1_pd(half)), rest);
        UNROLLED
        for (int k = 0; k < 3; k++) {
            int32_t *unit = to->unit[k] + i;
            _mm_storeu_si128((__m128i *) (void *) unit,
                             _mm256_cvtpd_epi32(_mm256_mul_pd(load_four(unit), factor)));
        }
    }
}

/* Eight pixels; see normalize_group.  A bit for each of the result. */
static inline uint32_t normalize_eight(uint8_t *dst, const deep_planes *planes, int32_t i,
                                       const unused_blues *ends, bool corners, __m256i *same)
{
    const __m256i pq = load_plane(planes->pq + i), s = load_plane(planes->s + i);
    const __m256i b = load_plane(planes->b + i), rounded = load_plane(planes->rounded + i);
    const __m256i u[3] = { load_plane(planes->unit[0] + i), load_plane(planes->unit[1] + i),
                           load_plane(planes->unit[2] + i) };
    const __m256i sign = load_plane(planes->sign + i);
    const texels was = { _mm256_xor_si256(pq, sign), b };
    const __m256i unused = corners ? unused_of(was, ends) : _mm256_setzero_si256();
    const __m256i doubt = _mm256_andnot_si256(_mm256_or_si256(rounded, unused), near_levels(u));
    const __m256i keep = _mm256_or_si256(doubt, unused);
    const __m256i to_pq = choose(_mm256_blend_epi16(_mm256_srli_epi32(u[0], 16), u[1], 0xaa), pq,
                                 _mm256_or_si256(rounded, keep));
    const __m256i to_s = choose(_mm256_srli_epi32(u[2], 16), s, rounded);
    const __m256i to_b = choose(_mm256_add_epi32(to_s, _mm256_set1_epi32(32768)), b, keep);
    *same = _mm256_add_epi32(
        *same, _mm256_and_si256(_mm256_cmpeq_epi32(to_pq, pq), _mm256_cmpeq_epi32(to_b, b)));
    put16(dst, (texels) { _mm256_xor_si256(to_pq, sign), to_b });
    return (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(doubt));
}

static int32_t normalize_rgb16(void *dst, const void *src, int32_t n, uint32_t touch_unused,
                               int32_t *at, uint64_t *changed)
{
    const unused_blues ends = blues_of_unused(65535, touch_unused);
    __m256i same = _mm256_setzero_si256();
    int32_t each[8], found = 0;
    uint8_t *d = dst;
    const uint8_t *s = src;
    deep_planes planes;
    const bool corners = sum_up(&planes, s, n);
    divide(&planes, n);
    for (int32_t i = 0; i < n; i += 8) {
        uint32_t left = normalize_eight(d + (ptrdiff_t) 6 * i, &planes, i, &ends, corners, &same);
        for (; left != 0; left &= left - 1)
            at[found++] = i + __builtin_ctz(left);
    }
    _mm256_storeu_si256((__m256i *) (void *) each, same);
    *changed += (uint64_t) n;
    for (int32_t k = 0; k < 8; k++)
        *changed -= (uint64_t) -each[k];
    return found;
}

#  undef N

#else
#  define normalize_rgb16 NULL
#endif
