/* SPDX-License-Identifier: MIT */
/*
 * exact16_tmpl.h - counts packed 16-bit texels with the derived blue; a part of kernels.c
 *
 * Notation is that of close_tmpl.h.  Exact is |t| <= z, and then root is z and d is z - t.  So blue
 * in Z-zero is w - (2t <= z + 1) - (2t <= -z) above its derived one, with w = K - z.  Where w is 1, t
 * is at least 1.  So this is never negative, and G is above 3, as it is 4t + 1 for w = 1, 4(z + t) + 4
 * for w = 2, and greater beyond.
 *
 * Nearly all normals are nearly flat: there w is at most NEAR.  Then both limits of t above, those of
 * the standard length (-16382 and 16385), and those at which the length in Z-zero is rounded up, lie
 * close together, at -16383.5 and 16383.5 or up to 7 below or (w - 1)^2 above.  Texels in there wait
 * for others; of these few, unit tests look at each.  So with q = t + 16390, floor(q/2^15) says all
 * but the sign of t: the length in Z-zero is as many 65536ths above 1 as blue is levels off, which is
 * w - 1 + floor(q/2^15).
 *
 * Beyond, G >= 4K(w - 2) - 3w*w + 8w is more than neighbors have, as P is below 2K + 16 sqrt(K w).
 */

#ifdef __AVX2__

/* Eight texels. */
typedef struct exact_lanes {
    __m256i rg, bb;  /* red and green, or blue twice, as halves */
    __m256i bad;     /* not exact, or odd (ntp__survey) */
    __m256i between; /* too near to a limit */
    __m256i xy, z, z2, t;
    __m256i x_and_y, y;
    __m256i at;          /* places in ntp__close_counts */
    __m256i off, longer; /* places of distances; the length in Z-zero less 65536 */
} exact_lanes;

/* The sums of eight lanes, or of halves of these. */
typedef struct exact_sums {
    __m256i x_and_y, y, z, longer, squares;
    __m256i least[2], greatest[2]; /* of rg and bb */
    __m256i shortest, longest, most, odd;
} exact_sums;

static inline exact_lanes load_exact(const uint8_t *s)
{
    exact_lanes v;
    const __m128i first = _mm_setr_epi8(0, 1, 2, 3, 6, 7, 8, 9, 4, 5, 4, 5, 10, 11, 10, 11);
    const __m256i low =
        _mm256_shuffle_epi8(load_two(s, s + 24), _mm256_broadcastsi128_si256(first));
    /* the same of texels 2 and 3 of four, 4 bytes further in what is loaded 8 bytes later */
    const __m128i next = _mm_add_epi8(first, _mm_set1_epi8(4));
    const __m256i high =
        _mm256_shuffle_epi8(load_two(s + 8, s + 32), _mm256_broadcastsi128_si256(next));
    v.rg = _mm256_unpacklo_epi64(low, high);
    v.bb = _mm256_unpackhi_epi64(low, high);
    return v;
}

/* Which are exact, and which are odd. */
static inline __m256i judge_exact(exact_lanes *v)
{
    const __m256i sign = _mm256_set1_epi16(INT16_MIN), zero = _mm256_setzero_si256();
    const __m256i p = _mm256_xor_si256(v->rg, sign), q = _mm256_xor_si256(v->bb, sign);
    const __m256i one = _mm256_set1_epi16(1), q1 = _mm256_blend_epi16(q, one, 0xaa);
    v->x_and_y = _mm256_madd_epi16(p, one);
    v->y = _mm256_srai_epi32(p, 16);
    v->z = _mm256_srai_epi32(q, 16);
    v->xy = _mm256_add_epi32(_mm256_madd_epi16(p, p), v->x_and_y);
    v->z2 = _mm256_madd_epi16(q, q1); /* z(z + 1) */
    v->t = _mm256_sub_epi32(_mm256_add_epi32(v->xy, v->z2), eight(CLOSE_AM - 1));
    const __m256i two = _mm256_xor_si256(v->rg, _mm256_srli_epi16(v->rg, 8));
    const __m256i third = _mm256_xor_si256(v->bb, _mm256_srli_epi16(v->bb, 8));
    const __m256i wide = _mm256_and_si256(_mm256_or_si256(two, third), _mm256_set1_epi16(255));
    const __m256i narrow = _mm256_cmpeq_epi32(wide, zero), gray = _mm256_cmpeq_epi32(v->rg, v->bb);
    const __m256i flat = _mm256_cmpeq_epi32(v->xy, zero);
    const __m256i odd = _mm256_or_si256(_mm256_or_si256(narrow, gray), flat);
    v->bad = _mm256_or_si256(odd, _mm256_cmpgt_epi32(_mm256_abs_epi32(v->t), v->z));
    return odd;
}

/* Where to count texels that are nearly flat. */
static inline void place_near(exact_lanes *v)
{
    const __m256i b = _mm256_srli_epi32(v->bb, 16), e = _mm256_sub_epi32(v->z2, v->t);
    const __m256i g = _mm256_sub_epi32(_mm256_mullo_epi32(b, b), _mm256_slli_epi32(e, 2));
    const __m256i q = _mm256_add_epi32(v->t, eight(16390)), part = _mm256_srai_epi32(q, 15);
    const __m256i w1 = _mm256_sub_epi32(eight(CLOSE_K - 1), v->z);
    const __m256i width = _mm256_add_epi32(_mm256_madd_epi16(w1, w1), eight(7));
    v->between = _mm256_cmpgt_epi32(width, marked(q, 32767));
    /* half_up is one more than the lesser of x and ~x, without sign */
    const __m256i p = _mm256_xor_si256(v->rg, _mm256_set1_epi16(INT16_MIN));
    const __m256i u = _mm256_xor_si256(p, _mm256_srai_epi16(p, 15));
    const __m256i kxy = _mm256_madd_epi16(u, _mm256_set1_epi16(1));
    const __m256i reach = _mm256_add_epi32(_mm256_slli_epi32(kxy, 2), b); /* P - 8 */
    const __m256i neighbor =
        _mm256_cmpgt_epi32(_mm256_add_epi32(reach, reach), _mm256_sub_epi32(g, eight(3)));
    const __m256i rounded = _mm256_cmpgt_epi32(reach, _mm256_sub_epi32(g, eight(5)));
    const __m256i is_long = _mm256_cmpgt_epi32(v->t, _mm256_setzero_si256());
    /* distances plus 1 above, -1 to 2 below, and what each has more */
    const __m256i off = _mm256_slli_epi32(_mm256_add_epi32(w1, part), 7);
    const __m256i passed = _mm256_slli_epi32(_mm256_sub_epi32(part, is_long), 3);
    v->at = _mm256_add_epi32(off, passed);
    v->at = _mm256_add_epi32(v->at, _mm256_setr_epi32(136, 137, 138, 139, 140, 141, 142, 143));
    v->at = _mm256_or_si256(v->at, marked(neighbor, 8 * NTP__EXACT_NEIGHBOR));
    v->at = _mm256_or_si256(v->at, marked(rounded, 8 * NTP__EXACT_ROUNDED));
}

/* The same of those in `far`, which are steeper; and their distances and lengths. */
static inline void place_far(exact_lanes *v, __m256i far)
{
    const __m256i zero = _mm256_setzero_si256(), t2 = _mm256_add_epi32(v->t, v->t);
    const __m256i b = _mm256_srli_epi32(v->bb, 16), e = _mm256_sub_epi32(v->z2, v->t);
    const __m256i g = _mm256_sub_epi32(_mm256_mullo_epi32(b, b), _mm256_slli_epi32(e, 2));
    __m256i doubt;
    v->longer = _mm256_sub_epi32(close_length(&doubt, g), eight(NTP__LENGTH_ONE));
    v->between = _mm256_blendv_epi8(v->between, doubt, far);
    v->off = _mm256_sub_epi32(eight(CLOSE_K - 1), v->z);
    v->off = _mm256_sub_epi32(v->off, _mm256_cmpgt_epi32(t2, _mm256_add_epi32(v->z, eight(1))));
    v->off = _mm256_sub_epi32(v->off, _mm256_cmpgt_epi32(_mm256_add_epi32(t2, v->z), zero));
    /* how many limits t has passed, negative */
    __m256i passed = _mm256_add_epi32(_mm256_cmpgt_epi32(v->t, eight(CLOSE_ONE - 1)),
                                      _mm256_cmpgt_epi32(v->t, eight(CLOSE_LONGER - 1)));
    passed = _mm256_add_epi32(passed, _mm256_cmpgt_epi32(v->t, zero));
    __m256i at = _mm256_slli_epi32(_mm256_srli_epi32(v->longer, 9), 10);
    at = _mm256_add_epi32(at, _mm256_slli_epi32(steepness(v->xy), 4));
    at = _mm256_sub_epi32(at, _mm256_slli_epi32(passed, 2));
    at = _mm256_add_epi32(at, _mm256_add_epi32(own_copies(), eight(NTP__EXACT_FAR)));
    v->at = _mm256_blendv_epi8(v->at, at, far);
}

static inline __m256i kept(__m256i v, __m256i bad)
{
    return _mm256_andnot_si256(bad, v);
}

static inline void survey_exact(exact_sums *s, const exact_lanes *v)
{
    s->x_and_y = _mm256_add_epi32(s->x_and_y, v->x_and_y);
    s->y = _mm256_add_epi32(s->y, v->y);
    s->z = _mm256_add_epi32(s->z, v->z);
    s->least[0] = _mm256_min_epu16(s->least[0], v->rg);
    s->least[1] = _mm256_min_epu16(s->least[1], v->bb);
    s->greatest[0] = _mm256_max_epu16(s->greatest[0], v->rg);
    s->greatest[1] = _mm256_max_epu16(s->greatest[1], v->bb);
}

/* Of texels that are not `left`.  Lengths are below 2^14 here, so that the squares of 32 fit. */
static inline void sum_exact(exact_sums *s, const exact_lanes *v, __m256i left)
{
    const __m256i longer = kept(v->longer, left);
    s->longer = _mm256_add_epi32(s->longer, longer);
    s->squares = _mm256_add_epi32(s->squares, _mm256_madd_epi16(longer, longer));
    s->shortest = _mm256_min_epu32(s->shortest, _mm256_or_si256(longer, left));
    s->longest = _mm256_max_epi32(s->longest, longer);
    s->most = _mm256_max_epi32(s->most, kept(v->off, left));
}

ONE_COPY static int32_t sum_of_eight(__m256i v)
{
    const __m128i four = _mm_add_epi32(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    const __m128i two = _mm_add_epi32(four, _mm_shuffle_epi32(four, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(two, _mm_shuffle_epi32(two, 0xb1)));
}

/* The least halves, those of even and of odd places, without sign. */
ONE_COPY static uint32_t least_halves(__m256i v)
{
    const __m128i four = _mm_min_epu16(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    const __m128i two = _mm_min_epu16(four, _mm_shuffle_epi32(four, 0x4e));
    return (uint32_t) _mm_cvtsi128_si32(_mm_min_epu16(two, _mm_shuffle_epi32(two, 0xb1)));
}

ONE_COPY static uint32_t greatest_of_eight(__m256i v)
{
    const __m128i four = _mm_max_epu32(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    const __m128i two = _mm_max_epu32(four, _mm_shuffle_epi32(four, 0x4e));
    return (uint32_t) _mm_cvtsi128_si32(_mm_max_epu32(two, _mm_shuffle_epi32(two, 0xb1)));
}

static void end_exact(ntp__exact_block *out, const exact_sums *s, int32_t n)
{
    const __m256i ones = eight(-1);
    const int32_t y = sum_of_eight(s->y), bias = CLOSE_K * n;
    const uint32_t least = least_halves(s->least[0]);
    const uint32_t greatest = ~least_halves(_mm256_xor_si256(s->greatest[0], ones));
    out->survey.sum[0] = (uint32_t) (sum_of_eight(s->x_and_y) - y + bias);
    out->survey.sum[1] = (uint32_t) (y + bias);
    out->survey.sum[2] = (uint32_t) (sum_of_eight(s->z) + bias);
    out->survey.least[0] = least & 65535;
    out->survey.least[1] = least >> 16;
    out->survey.least[2] = least_halves(s->least[1]) & 65535;
    out->survey.greatest[0] = greatest & 65535;
    out->survey.greatest[1] = greatest >> 16;
    out->survey.greatest[2] = ~least_halves(_mm256_xor_si256(s->greatest[1], ones)) & 65535;
    out->survey.odd = (uint32_t) any_negative(s->odd);
}

/* Those of steeper texels. */
static void end_far(ntp__exact_block *out, const exact_sums *s)
{
    uint32_t squares[8];
    store_eight(squares, s->squares);
    out->length_sum = (uint32_t) sum_of_eight(s->longer);
    out->length_error2 = 0;
    for (int i = 0; i < 8; i++)
        out->length_error2 += squares[i];
    out->least = ~greatest_of_eight(_mm256_xor_si256(s->shortest, eight(-1)));
    out->greatest = greatest_of_eight(s->longest);
    out->levels_off_max = greatest_of_eight(s->most) - 1;
}

static inline int32_t lanes_of(__m256i mask)
{
    return _mm256_movemask_ps(_mm256_castsi256_ps(mask));
}

static int32_t count_exact(ntp__exact_block *out, ntp__close_counts *counts, const uint16_t *src,
                           int32_t n)
{
    int32_t at[256], off[256], texels = 0, steep = 0, others = 0;
    const __m256i zero = _mm256_setzero_si256(), ones = eight(-1);
    exact_sums s = { zero,           zero, zero, zero, zero, { ones, ones },
                     { zero, zero }, ones, zero, zero, zero };
    out->far = 0;
    n &= -8;
    for (int32_t i = 0; i < n; i += 8) {
        exact_lanes v = load_exact((const uint8_t *) src + 6 * i);
        s.odd = _mm256_or_si256(s.odd, judge_exact(&v));
        survey_exact(&s, &v);
        int32_t bad = lanes_of(v.bad);
        if (bad != 255) {
            const __m256i far =
                kept(_mm256_cmpgt_epi32(eight(CLOSE_K - NTP__EXACT_NEAR), v.z), v.bad);
            place_near(&v);
            if (any_negative(far))
                place_far(&v, far);
            v.bad = _mm256_or_si256(v.bad, v.between);
            if (any_negative(far)) {
                const __m256i left = _mm256_or_si256(v.bad, _mm256_xor_si256(far, ones));
                sum_exact(&s, &v, left);
                store_eight(off + steep, kept(v.off, left));
                steep += 8;
                out->far += 8 - __builtin_popcount((unsigned) lanes_of(left));
            }
            store_eight(at + texels, kept(v.at, v.bad));
            texels += 8;
            bad = lanes_of(v.bad);
        }
        out->others[i / 8] = (uint8_t) bad;
        others += __builtin_popcount((unsigned) bad);
    }
    for (int32_t i = 0; i < texels; i++)
        counts->exact[at[i]]++;
    for (int32_t i = 0; i < steep; i++)
        counts->exact_off[off[i]]++;
    out->texels = n - others;
    end_exact(out, &s, n);
    if (out->far > 0)
        end_far(out, &s);
    return n;
}
#else
#  define count_exact NULL
#endif
