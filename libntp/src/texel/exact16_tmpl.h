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

/* What is kept of the texels of a block between the steps. */
typedef struct exact_texels {
    int32_t t[256]; /* 0: not exact, or odd (ntp__survey); else it is odd, as K is even */
    int32_t z[256];
    int32_t pair[256];         /* half_up of x and of y, less 2 */
    int32_t at[256], off[256]; /* where to count: in exact and in exact_off of ntp__close_counts */
} exact_texels;

/* The sums of eight lanes, or of halves of these. */
typedef struct exact_survey {
    __m256i x_and_y, y, z, odd;
    __m256i least[2], greatest[2]; /* of red and green, and of blue */
} exact_survey;

/* Of texels that are steeper than nearly flat. */
typedef struct far_sums {
    __m256i longer, squares, shortest, longest, most;
} far_sums;

static inline int32_t lanes_of(__m256i mask)
{
    return _mm256_movemask_ps(_mm256_castsi256_ps(mask));
}

static inline __m256i kept(__m256i v, __m256i bad)
{
    return _mm256_andnot_si256(bad, v);
}

/* Red and green of eight texels as halves, and blue twice. */
static inline void load_exact(__m256i *rg, __m256i *bb, const uint8_t *s)
{
    const __m128i first = _mm_setr_epi8(0, 1, 2, 3, 6, 7, 8, 9, 4, 5, 4, 5, 10, 11, 10, 11);
    const __m256i low =
        _mm256_shuffle_epi8(load_two(s, s + 24), _mm256_broadcastsi128_si256(first));
    /* the same of texels 2 and 3 of four, 4 bytes further in what is loaded 8 bytes later */
    const __m128i next = _mm_add_epi8(first, _mm_set1_epi8(4));
    const __m256i high =
        _mm256_shuffle_epi8(load_two(s + 8, s + 32), _mm256_broadcastsi128_si256(next));
    *rg = _mm256_unpacklo_epi64(low, high);
    *bb = _mm256_unpackhi_epi64(low, high);
}

/* Which of eight texels are exact. */
static inline void judge_exact(exact_texels *to, exact_survey *s, __m256i rg, __m256i bb, int32_t i)
{
    const __m256i sign = _mm256_set1_epi16(INT16_MIN), zero = _mm256_setzero_si256();
    const __m256i p = _mm256_xor_si256(rg, sign), q = _mm256_xor_si256(bb, sign);
    const __m256i one = _mm256_set1_epi16(1), q1 = _mm256_blend_epi16(q, one, 0xaa);
    const __m256i x_and_y = _mm256_madd_epi16(p, one), z = _mm256_srai_epi32(q, 16);
    const __m256i xy = _mm256_add_epi32(_mm256_madd_epi16(p, p), x_and_y);
    const __m256i z2 = _mm256_madd_epi16(q, q1); /* z(z + 1) */
    const __m256i t = _mm256_sub_epi32(_mm256_add_epi32(xy, z2), eight(CLOSE_AM - 1));
    const __m256i two = _mm256_xor_si256(rg, _mm256_srli_epi16(rg, 8));
    const __m256i third = _mm256_xor_si256(bb, _mm256_srli_epi16(bb, 8));
    const __m256i wide = _mm256_and_si256(_mm256_or_si256(two, third), _mm256_set1_epi16(255));
    const __m256i narrow = _mm256_cmpeq_epi32(wide, zero), gray = _mm256_cmpeq_epi32(rg, bb);
    const __m256i flat = _mm256_cmpeq_epi32(xy, zero);
    const __m256i odd = _mm256_or_si256(_mm256_or_si256(narrow, gray), flat);
    const __m256i inexact = _mm256_cmpgt_epi32(_mm256_abs_epi32(t), z);
    /* half_up is one more than the lesser of x and ~x, without sign */
    const __m256i u = _mm256_xor_si256(p, _mm256_srai_epi16(p, 15));
    store_eight(to->pair + i, _mm256_madd_epi16(u, one));
    store_eight(to->t + i, kept(t, _mm256_or_si256(odd, inexact)));
    store_eight(to->z + i, z);
    s->odd = _mm256_or_si256(s->odd, odd);
    s->x_and_y = _mm256_add_epi32(s->x_and_y, x_and_y);
    s->y = _mm256_add_epi32(s->y, _mm256_srai_epi32(p, 16));
    s->z = _mm256_add_epi32(s->z, z);
    s->least[0] = _mm256_min_epu16(s->least[0], rg);
    s->least[1] = _mm256_min_epu16(s->least[1], bb);
    s->greatest[0] = _mm256_max_epu16(s->greatest[0], rg);
    s->greatest[1] = _mm256_max_epu16(s->greatest[1], bb);
}

/* Where to count texels that are nearly flat, and which are too near to a limit.  With v = w - 1,
 * G = 4K v - 3v*v - 2v + 1 + 4t, and b = 2K - 1 - v. */
static inline __m256i place_near(__m256i *between, __m256i t, __m256i z, __m256i pair)
{
    const __m256i v = _mm256_sub_epi32(eight(CLOSE_K - 1), z), v2 = _mm256_madd_epi16(v, v);
    const __m256i q = _mm256_add_epi32(t, eight(16390)), part = _mm256_srai_epi32(q, 15);
    *between = _mm256_cmpgt_epi32(_mm256_add_epi32(v2, eight(7)), marked(q, 32767));
    const __m256i three = _mm256_add_epi32(_mm256_add_epi32(v2, v2), v2);
    const __m256i limit = _mm256_sub_epi32(_mm256_slli_epi32(v, 17), three);
    /* 8 pair - 4t > limit - 4K, and 4 pair - 4t > limit - v - 2K - 3 */
    const __m256i pair4 = _mm256_slli_epi32(pair, 2);
    const __m256i less = _mm256_sub_epi32(pair4, _mm256_slli_epi32(t, 2));
    const __m256i neighbor = _mm256_cmpgt_epi32(_mm256_add_epi32(less, pair4),
                                                _mm256_sub_epi32(limit, eight(4 * CLOSE_K)));
    const __m256i rounded = _mm256_cmpgt_epi32(_mm256_add_epi32(less, v),
                                               _mm256_sub_epi32(limit, eight(2 * CLOSE_K + 3)));
    const __m256i is_long = _mm256_cmpgt_epi32(t, _mm256_setzero_si256());
    /* distances plus 1 above, -1 to 2 below, and what each has more */
    const __m256i off = _mm256_slli_epi32(_mm256_add_epi32(v, part), 7);
    const __m256i passed = _mm256_slli_epi32(_mm256_sub_epi32(part, is_long), 3);
    __m256i at = _mm256_add_epi32(off, passed);
    at = _mm256_add_epi32(at, _mm256_setr_epi32(136, 137, 138, 139, 140, 141, 142, 143));
    at = _mm256_or_si256(at, marked(neighbor, 8 * NTP__EXACT_NEIGHBOR));
    return _mm256_or_si256(at, marked(rounded, 8 * NTP__EXACT_ROUNDED));
}

/* The same of texels that are steeper, those in `far`; also sums them and puts their distances where
 * `off` points to.  Lengths are below 2^14 here, so that the squares of 32 fit. */
ONE_COPY static __m256i place_far(far_sums *s, __m256i *between, int32_t *off_to, __m256i t,
                                  __m256i z, __m256i far)
{
    const __m256i zero = _mm256_setzero_si256(), one = eight(1), t2 = _mm256_add_epi32(t, t);
    const __m256i z1 = _mm256_add_epi32(z, one), b = _mm256_add_epi32(z, eight(CLOSE_K));
    const __m256i e = _mm256_sub_epi32(_mm256_mullo_epi32(z, z1), t);
    const __m256i g = _mm256_sub_epi32(_mm256_mullo_epi32(b, b), _mm256_slli_epi32(e, 2));
    const __m256i longer = _mm256_sub_epi32(close_length(between, g), eight(NTP__LENGTH_ONE));
    const __m256i left = _mm256_or_si256(*between, _mm256_xor_si256(far, eight(-1)));
    /* how many limits t has passed, negative */
    __m256i passed = _mm256_add_epi32(_mm256_cmpgt_epi32(t, eight(CLOSE_ONE - 1)),
                                      _mm256_cmpgt_epi32(t, eight(CLOSE_LONGER - 1)));
    passed = _mm256_add_epi32(passed, _mm256_cmpgt_epi32(t, zero));
    __m256i off = _mm256_sub_epi32(eight(CLOSE_K - 1), z);
    off = _mm256_sub_epi32(off, _mm256_cmpgt_epi32(t2, z1));
    off = kept(_mm256_sub_epi32(off, _mm256_cmpgt_epi32(_mm256_add_epi32(t2, z), zero)), left);
    s->most = _mm256_max_epi32(s->most, off);
    /* as many places as lanes for what is forgotten */
    store_eight(off_to, _mm256_blendv_epi8(_mm256_add_epi32(off, eight(7)),
                                           _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), left));
    const __m256i length = kept(longer, left);
    s->longer = _mm256_add_epi32(s->longer, length);
    s->squares = _mm256_add_epi32(s->squares, _mm256_madd_epi16(length, length));
    s->shortest = _mm256_min_epu32(s->shortest, _mm256_or_si256(length, left));
    s->longest = _mm256_max_epi32(s->longest, length);
    __m256i at = _mm256_slli_epi32(_mm256_srli_epi32(longer, 9), 10);
    at = _mm256_add_epi32(
        at, _mm256_slli_epi32(steepness(_mm256_sub_epi32(eight(CLOSE_AM - 1), e)), 4));
    at = _mm256_sub_epi32(at, _mm256_slli_epi32(passed, 2));
    return _mm256_add_epi32(at, _mm256_add_epi32(own_copies(), eight(NTP__EXACT_FAR)));
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

static void end_survey(ntp__survey *out, const exact_survey *s, int32_t n)
{
    const __m256i ones = eight(-1);
    const int32_t y = sum_of_eight(s->y), bias = CLOSE_K * n;
    const uint32_t least = least_halves(s->least[0]);
    const uint32_t greatest = ~least_halves(_mm256_xor_si256(s->greatest[0], ones));
    out->sum[0] = (uint32_t) (sum_of_eight(s->x_and_y) - y + bias);
    out->sum[1] = (uint32_t) (y + bias);
    out->sum[2] = (uint32_t) (sum_of_eight(s->z) + bias);
    out->least[0] = least & 65535;
    out->least[1] = least >> 16;
    out->least[2] = least_halves(s->least[1]) & 65535;
    out->greatest[0] = greatest & 65535;
    out->greatest[1] = greatest >> 16;
    out->greatest[2] = ~least_halves(_mm256_xor_si256(s->greatest[1], ones)) & 65535;
    out->odd = (uint32_t) any_negative(s->odd);
}

static void survey_exact(ntp__survey *out, exact_texels *to, const uint16_t *src, int32_t n)
{
    const __m256i zero = _mm256_setzero_si256(), ones = eight(-1);
    exact_survey s = { zero, zero, zero, zero, { ones, ones }, { zero, zero } };
    __m256i rg, bb;
    for (int32_t i = 0; i < n; i += 8) {
        load_exact(&rg, &bb, (const uint8_t *) src + 6 * i);
        judge_exact(to, &s, rg, bb, i);
    }
    end_survey(out, &s, n);
}

static void end_far(ntp__exact_block *out, const far_sums *s)
{
    uint64_t squares[4];
    store_eight(squares,
                _mm256_add_epi64(_mm256_srli_epi64(s->squares, 32),
                                 _mm256_and_si256(s->squares, _mm256_set1_epi64x(UINT32_MAX))));
    out->length_sum = (uint32_t) sum_of_eight(s->longer);
    out->length_error2 = squares[0] + squares[1] + squares[2] + squares[3];
    out->least = ~greatest_of_eight(_mm256_xor_si256(s->shortest, eight(-1)));
    out->greatest = greatest_of_eight(s->longest);
    out->levels_off_max = greatest_of_eight(s->most) - 1;
}

/* Counts at n places, whole groups. */
ONE_COPY static void count_at(uint32_t *counts, const int32_t *at, int32_t n)
{
    for (int32_t i = 0; i < n; i += 8) {
        for (int32_t k = 0; k < 8; k++)
            counts[at[i + k]]++;
    }
}

static int32_t count_exact(ntp__exact_block *out, ntp__close_counts *counts, const uint16_t *src,
                           int32_t n)
{
    int32_t texels = 0, steep = 0, left = 0, far_ones = 0;
    const __m256i zero = _mm256_setzero_si256();
    exact_texels v;
    far_sums s = { zero, zero, eight(-1), zero, zero };
    n &= -8;
    survey_exact(&out->survey, &v, src, n);
    for (int32_t i = 0; i < n; i += 8) {
        const __m256i t = load_eight(v.t + i), z = load_eight(v.z + i);
        __m256i bad = _mm256_cmpeq_epi32(t, zero), between;
        int32_t others = lanes_of(bad);
        if (others != 255) {
            const __m256i far = kept(_mm256_cmpgt_epi32(eight(CLOSE_K - NTP__EXACT_NEAR), z), bad);
            __m256i at = place_near(&between, t, z, load_eight(v.pair + i));
            if (any_negative(far)) {
                __m256i doubt;
                at = _mm256_blendv_epi8(at, place_far(&s, &doubt, v.off + steep, t, z, far), far);
                between = _mm256_blendv_epi8(between, doubt, far);
                steep += 8;
                far_ones += __builtin_popcount((unsigned) lanes_of(kept(far, doubt)));
            }
            bad = _mm256_or_si256(bad, between);
            store_eight(v.at + texels, kept(at, bad));
            texels += 8;
            others = lanes_of(bad);
        }
        for (; others != 0; others &= others - 1)
            out->left[left++] = (uint8_t) (i + __builtin_ctz((unsigned) others));
    }
    count_at(counts->exact, v.at, texels);
    count_at(counts->exact_off, v.off, steep);
    out->texels = n - left;
    out->far = far_ones;
    if (far_ones > 0)
        end_far(out, &s);
    return n;
}
#else
#  define count_exact NULL
#endif
