/* SPDX-License-Identifier: MIT */
/*
 * close_tmpl.h - counts 16-bit texels that are close to exact, eight at a time; a part of kernels.c
 *
 * Notation is that of judge_tmpl.h.  Let z = b - K, e = A_M - 1 - xy, and t = z(z + 1) - e.  The
 * derived blue is K + root with root*root <= e < (root + 1)^2.  So root is
 *   z      where     -z <= t <= z
 *   z + 1  where -3z - 3 <= t < -z
 *   z - 1  where      z < t <= 3z - 1
 * and none has to be taken.  The square of the length is 4(A_M + t - 1) + 3: t alone decides whether
 * the length is rounded to 65535, 65536 or 65537.  All of these are neighbors: 1 - 2k <= t <= 2k - 6,
 * for k*k, the square of a sum, is at least A_M + t - 1.
 */

#ifdef __AVX2__

enum { CLOSE_K = 32768, CLOSE_AM = 32768 * 32767 };

/* Eight texels. */
typedef struct close_lanes {
    __m256i bad;        /* negative: not close */
    __m256i z, t, e;    /* as above */
    __m256i kxy;        /* half_up of x and of y */
    __m256i inexact;    /* all bits: one level off */
    __m256i at;         /* places in the counts, and among copies */
    __m256i at_zz, off; /* those of Z-zero; how far blue is from its derived one */
    __m256i longer;     /* the length in Z-zero, less 65536 */
} close_lanes;

static inline __m256i eight(int32_t v)
{
    return _mm256_set1_epi32(v);
}

static inline __m256i marked(__m256i mask, int32_t bits)
{
    return _mm256_and_si256(mask, eight(bits));
}

/* Whose copies lanes count in. */
static inline __m256i own_copies(void)
{
    return _mm256_setr_epi32(0, 1, 2, 3, 0, 1, 2, 3);
}

/* floor(64 xy / A_M), exact: A_M / 64 = 2^24 - 2^9 */
static inline __m256i steepness(__m256i xy)
{
    const __m256i more = _mm256_add_epi32(_mm256_srli_epi32(xy, 15), eight(1));
    return _mm256_srli_epi32(_mm256_add_epi32(xy, more), 24);
}

/* All that the standard encoding asks. */
static inline close_lanes close_standard(__m256i r, __m256i g, __m256i b)
{
    close_lanes v;
    const __m256i one = eight(1), zero = _mm256_setzero_si256(), k0 = eight(CLOSE_K);
    const __m256i x = _mm256_sub_epi32(r, k0), x1 = _mm256_add_epi32(x, one);
    const __m256i y = _mm256_sub_epi32(g, k0), y1 = _mm256_add_epi32(y, one);
    const __m256i z = _mm256_sub_epi32(b, k0), z1 = _mm256_add_epi32(z, one);
    const __m256i xy = _mm256_add_epi32(_mm256_mullo_epi32(x, x1), _mm256_mullo_epi32(y, y1));
    const __m256i e = _mm256_sub_epi32(eight(CLOSE_AM - 1), xy);
    const __m256i t = _mm256_sub_epi32(_mm256_mullo_epi32(z, z1), e);
    v.kxy = _mm256_add_epi32(_mm256_max_epi32(x1, _mm256_sub_epi32(zero, x)),
                             _mm256_max_epi32(y1, _mm256_sub_epi32(zero, y)));
    const __m256i k = _mm256_add_epi32(v.kxy, z1), off = _mm256_abs_epi32(t);
    /* at most one level off: |t + 2| <= 3z + 1 */
    const __m256i beyond = _mm256_abs_epi32(_mm256_add_epi32(t, eight(2)));
    const __m256i reach = _mm256_add_epi32(_mm256_add_epi32(z, z), z1);
    v.bad = _mm256_or_si256(e, _mm256_cmpgt_epi32(beyond, reach));
    v.bad = _mm256_or_si256(v.bad, _mm256_cmpgt_epi32(off, eight(NTP__CLOSE_T_MOST)));
    v.inexact = _mm256_cmpgt_epi32(off, z);
    /* rounded: |t| <= k - 2 */
    const __m256i rounded = _mm256_cmpgt_epi32(_mm256_sub_epi32(k, one), off);
    const int32_t by = NTP__CLOSE_COPIES;
    v.at =
        _mm256_or_si256(_mm256_slli_epi32(steepness(xy), NTP__CLOSE_STEEP_BIT + 2), own_copies());
    v.at = _mm256_add_epi32(v.at, marked(_mm256_cmpgt_epi32(t, eight(NTP__CLOSE_T_ONE - 1)), by));
    v.at =
        _mm256_add_epi32(v.at, marked(_mm256_cmpgt_epi32(t, eight(NTP__CLOSE_T_LONGER - 1)), by));
    v.at = _mm256_or_si256(v.at, marked(_mm256_cmpgt_epi32(t, zero), by * NTP__CLOSE_LONG));
    v.at = _mm256_or_si256(v.at, marked(rounded, by * NTP__CLOSE_ROUNDED));
    v.at = _mm256_or_si256(v.at, marked(v.inexact, by * NTP__CLOSE_INEXACT));
    v.z = z;
    v.t = t;
    v.e = e;
    return v;
}

/*
 * The length as Z-zero, from G = b*b - 4e: its square is s = M*M - 3 + G, 4e + 3 being M*M less those
 * of x and y.  As in judge_lengths_quickly, with k next to the root it is k + (s - k*k)/(root + k),
 * where a reciprocal root r of half the digits, and one step of Newton's, will do:
 *   s as a float is off by at most 448, and r by 1.5 2^-12 of it before that step, 2^-21 after it;
 *   then the root s r is off by 0.04, so k - root by 0.55, and s - k*k is below 2^17;
 *   r/2 for 1/(root + k) is off by 2^-17.8 of it, which with all roundings is 2^-18.
 * Doubtful are lanes where what is rounded lies closer to the middle than 2^-16.
 */
static inline __m256i close_length(__m256i *doubtful, __m256i g)
{
    const float m = 65535;
    const int32_t m2_less_3 = (int32_t) (65535U * 65535U - 3U);
    const __m256 s = _mm256_add_ps(_mm256_cvtepi32_ps(g), _mm256_set1_ps(m * m));
    const __m256 guess = _mm256_rsqrt_ps(s), half = _mm256_mul_ps(s, _mm256_set1_ps(0.5f));
    const __m256 error = _mm256_mul_ps(_mm256_mul_ps(half, guess), guess);
    const __m256 r = _mm256_mul_ps(guess, _mm256_sub_ps(_mm256_set1_ps(1.5f), error));
    const __m256i k = _mm256_cvtps_epi32(_mm256_mul_ps(s, r));
    const __m256i square = _mm256_add_epi32(g, eight(m2_less_3));
    const __m256 rest = _mm256_cvtepi32_ps(_mm256_sub_epi32(square, _mm256_mullo_epi32(k, k)));
    const __m256 part = _mm256_mul_ps(rest, _mm256_mul_ps(r, _mm256_set1_ps(32768.0f / m)));
    const __m256 more = _mm256_mul_ps(_mm256_cvtepi32_ps(k), _mm256_set1_ps(1.0f / m));
    const __m256 up = _mm256_add_ps(_mm256_add_ps(part, more), _mm256_set1_ps(0.5f));
    const __m256i down = _mm256_cvttps_epi32(up);
    const __m256 left =
        _mm256_sub_ps(_mm256_sub_ps(up, _mm256_cvtepi32_ps(down)), _mm256_set1_ps(0.5f));
    const __m256 away = _mm256_andnot_ps(_mm256_set1_ps(-0.0f), left);
    const __m256 doubt = _mm256_cmp_ps(away, _mm256_set1_ps(0.5f - 0x1p-16f), _CMP_GT_OQ);
    *doubtful = _mm256_castps_si256(doubt);
    return _mm256_add_epi32(k, down);
}

/*
 * The same of Z-zero.  With P = b + 4q, q standing for half_up(x) + half_up(y), a neighbor is
 * 2 - 2P <= G <= 2P - 14, and rounded 5 - P <= G <= P - 4.  G is never below these: with w = K - z
 * it is w(4K - 3w) - 4z + 4t.  For w = 1, t is positive; for w = 2, G >= 4K - 4 + 4t > -P + 5, and
 * for more, G is positive.
 */
static inline void close_zzero(close_lanes *v, __m256i b)
{
    const __m256i sign = _mm256_or_si256(_mm256_srai_epi32(v->t, 31), eight(1));
    const __m256i root = _mm256_sub_epi32(v->z, _mm256_and_si256(sign, v->inexact));
    const __m256i twice = _mm256_add_epi32(root, root);
    const __m256i d = _mm256_sub_epi32(v->e, _mm256_mullo_epi32(root, root));
    const __m256i d2 = _mm256_add_epi32(d, d);
    /* as in blue(): 2 root + (2d + 1 >= root) + (2d >= 3 root) */
    __m256i want =
        _mm256_sub_epi32(twice, _mm256_cmpgt_epi32(_mm256_add_epi32(d2, eight(2)), root));
    const __m256i three = _mm256_sub_epi32(_mm256_add_epi32(twice, root), eight(1));
    want = _mm256_sub_epi32(want, _mm256_cmpgt_epi32(d2, three));
    v->off = _mm256_abs_epi32(_mm256_sub_epi32(b, want));
    const __m256i g = _mm256_sub_epi32(_mm256_mullo_epi32(b, b), _mm256_slli_epi32(v->e, 2));
    const __m256i reach = _mm256_add_epi32(b, _mm256_slli_epi32(v->kxy, 2));
    const __m256i neighbor =
        _mm256_cmpgt_epi32(_mm256_add_epi32(reach, reach), _mm256_add_epi32(g, eight(13)));
    const __m256i rounded = _mm256_cmpgt_epi32(reach, _mm256_add_epi32(g, eight(3)));
    const __m256i length = close_length(&v->bad, g), by512 = _mm256_srli_epi32(length, 3);
    const int32_t by = NTP__CLOSE_COPIES, least = NTP__CLOSE_ZZ_SHORTEST * 64;
    v->longer = _mm256_sub_epi32(length, eight(NTP__LENGTH_ONE));
    v->at_zz = _mm256_sub_epi32(_mm256_and_si256(by512, eight(-64)), eight(least));
    v->at_zz = _mm256_or_si256(v->at_zz, own_copies());
    v->at_zz = _mm256_or_si256(v->at_zz, marked(neighbor, by * NTP__CLOSE_ZZ_NEIGHBOR));
    v->at_zz = _mm256_or_si256(v->at_zz, marked(rounded, by * NTP__CLOSE_ZZ_ROUNDED));
    v->at_zz =
        _mm256_or_si256(v->at_zz, marked(_mm256_cmpeq_epi32(b, want), by * NTP__CLOSE_ZZ_EXACT));
    v->at_zz =
        _mm256_or_si256(v->at_zz, marked(_mm256_cmpgt_epi32(g, eight(3)), by * NTP__CLOSE_ZZ_LONG));
}

static inline __m256i load_eight(const void *p)
{
    return _mm256_loadu_si256((const __m256i *) p);
}

static inline void store_eight(void *p, __m256i v)
{
    _mm256_storeu_si256((__m256i *) p, v);
}

static inline bool any_negative(__m256i v)
{
    return _mm256_movemask_ps(_mm256_castsi256_ps(v)) != 0;
}

/* Places to count at, and texels that are not exact. */
typedef struct close_places {
    int32_t at[256], at_zz[256], off[256];
    int32_t xy[256], blue[256], want[256];
} close_places;

/* Keeps what the angle of inexact texels comes from. */
static inline int32_t note_turned(close_places *p, int32_t turned, const close_lanes *v, __m256i b)
{
    int32_t xy[8], blue[8], want[8];
    uint32_t lanes = (uint32_t) _mm256_movemask_ps(_mm256_castsi256_ps(v->inexact));
    const __m256i sign = _mm256_or_si256(_mm256_srai_epi32(v->t, 31), eight(1));
    store_eight(xy, _mm256_sub_epi32(eight(CLOSE_AM - 1), v->e));
    store_eight(blue, b);
    store_eight(want, _mm256_sub_epi32(b, sign));
    for (; lanes != 0; lanes &= lanes - 1, turned++) {
        const int i = __builtin_ctz(lanes);
        p->xy[turned] = xy[i];
        p->blue[turned] = blue[i];
        p->want[turned] = want[i];
    }
    return turned;
}

ONE_COPY static int32_t sum_of_eight(__m256i v)
{
    const __m128i four = _mm_add_epi32(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    const __m128i two = _mm_add_epi32(four, _mm_shuffle_epi32(four, 0x4e));
    return _mm_cvtsi128_si32(_mm_add_epi32(two, _mm_shuffle_epi32(two, 0xb1)));
}

/* Of numbers without a sign. */
ONE_COPY static uint64_t sum_of_squares(__m256i v)
{
    uint64_t sums[4];
    const __m256i even = _mm256_and_si256(v, _mm256_set1_epi64x(UINT32_MAX));
    store_eight(sums, _mm256_add_epi64(_mm256_srli_epi64(v, 32), even));
    return sums[0] + sums[1] + sums[2] + sums[3];
}

ONE_COPY static uint32_t greatest_of_eight(__m256i v)
{
    const __m128i four = _mm_max_epu32(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    const __m128i two = _mm_max_epu32(four, _mm_shuffle_epi32(four, 0x4e));
    return (uint32_t) _mm_cvtsi128_si32(_mm_max_epu32(two, _mm_shuffle_epi32(two, 0xb1)));
}

static void count_places(ntp__close_counts *counts, uint32_t *levels_off, const close_places *p,
                         int32_t n)
{
    uint32_t *const standard = &counts->standard[0][0], *const zzero = &counts->zzero[0][0];
    for (int32_t i = 0; i < n; i++) {
        standard[p->at[i]]++;
        zzero[p->at_zz[i]]++;
        levels_off[p->off[i]]++;
    }
}

/* Whole lanes; what fills them up is 0. */
ONE_COPY static void sum_turned(ntp__close_block *out, const int32_t *angle, int32_t n)
{
    __m256i sum = _mm256_setzero_si256(), most = sum, from_1 = sum, from_2 = sum;
    for (int32_t i = 0; i < n; i += 8) {
        const __m256i turn = load_eight(angle + i);
        sum = _mm256_add_epi32(sum, turn);
        most = _mm256_max_epi32(most, turn);
        from_1 = _mm256_sub_epi32(from_1, _mm256_cmpgt_epi32(turn, eight(499)));
        from_2 = _mm256_sub_epi32(from_2, _mm256_cmpgt_epi32(turn, eight(1499)));
    }
    const int32_t others = sum_of_eight(from_1);
    out->angle_sum = (uint32_t) sum_of_eight(sum);
    out->angle_max = greatest_of_eight(most);
    out->angle_bins[2] = sum_of_eight(from_2);
    out->angle_bins[1] = others - out->angle_bins[2];
    out->angle_bins[0] = out->texels - others;
}

static void count_close(ntp__close_block *out, ntp__close_counts *counts, uint32_t *levels_off,
                        int32_t *const c[3], int32_t n)
{
    __m256i sum = _mm256_setzero_si256(), squares = sum, most = sum;
    __m256i least = eight(-1), greatest = sum;
    close_places p;
    int32_t i = 0, found = 0, turned = 0, left = 0;
    for (; i + 8 <= n; i += 8) {
        const __m256i r = load_eight(c[0] + i), g = load_eight(c[1] + i), b = load_eight(c[2] + i);
        close_lanes v = close_standard(r, g, b);
        bool close = !any_negative(v.bad);
        if (close) {
            close_zzero(&v, b);
            close = !any_negative(v.bad);
        }
        if (!close) {
            store_eight(c[0] + left, r);
            store_eight(c[1] + left, g);
            store_eight(c[2] + left, b);
            left += 8;
            continue;
        }
        if (any_negative(v.inexact))
            turned = note_turned(&p, turned, &v, b);
        store_eight(p.at + found, v.at);
        store_eight(p.at_zz + found, v.at_zz);
        store_eight(p.off + found, v.off);
        found += 8;
        const __m256i size = _mm256_abs_epi32(v.longer);
        sum = _mm256_add_epi32(sum, v.longer);
        squares = _mm256_add_epi32(squares, _mm256_madd_epi16(size, size));
        const __m256i length = _mm256_add_epi32(v.longer, eight(NTP__LENGTH_ONE));
        least = _mm256_min_epu32(least, length);
        greatest = _mm256_max_epu32(greatest, length);
        most = _mm256_max_epi32(most, v.off);
    }
    for (; i < n; i++, left++) {
        for (int k = 0; k < 3; k++)
            c[k][left] = c[k][i];
    }
    out->texels = found;
    out->left = left;
    /* squares are below 2^27, and there are 32 */
    out->length_sum = sum_of_eight(sum);
    out->length_error2 = sum_of_squares(squares);
    out->least = ~greatest_of_eight(_mm256_xor_si256(least, eight(-1)));
    out->greatest = greatest_of_eight(greatest);
    out->levels_off_max = greatest_of_eight(most);
    count_places(counts, levels_off, &p, found);
    for (i = turned; i % LANES != 0; i++) {
        p.xy[i] = p.blue[i] = p.want[i] = 0;
    }
    /* Their places are not needed any more. */
    int32_t *const angle = p.at;
    judge_angles(angle, p.xy, p.blue, p.want, turned, 65535, 0);
    for (i = 0; i < turned; i++) {
        if (angle[i] >= 0)
            continue;
        const double z = 2.0 * p.blue[i] - 65535, w = 2.0 * p.want[i] - 65535;
        const double rho2 = 4.0 * p.xy[i] + 2.0;
        angle[i] =
            (int32_t) (ntp__radians(sqrt(rho2) * fabs(z - w), rho2 + z * w) * (180e6 / NTP__PI) +
                       0.5);
    }
    sum_turned(out, angle, whole_lanes(turned + LANES - 1));
}
#else
#  define count_close NULL
#endif
