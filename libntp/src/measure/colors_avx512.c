/* SPDX-License-Identifier: MIT */
/*
 * colors_avx512.c - adds colors of 8 bit with their counts to the sums, sixteen at a time, with AVX-512
 *
 * Rows of cells are read sixteen cells at a time; those that hold counts are put side by side.  What is judged
 * stays in registers, and is counted in the end.
 *
 * Notation is that of texel/judge_tmpl.h, and of k1 and k2 of a row, which are x and y where these are not
 * negative.  With u = z or -1 - z, |Z| = 2u + 1.  Both ends of a verdict are one comparison without a sign:
 *     standard: -2k <= a - A_M < 2k - 6, and -k < a - A_M <= k - 3;
 *     Z-zero, with t = b*b - 4e and r = 8(k1 + k2 + 2): 2 - r - 2b <= t <= r + 2b - 14, and
 *     5 - r/2 - b <= t <= r/2 + b - 4.
 * No pair here is too long, so none is padding.  Lengths are the doubles of ntp__fixed_length.  Angles are
 * those of texel/turn_avx512_tmpl.h.
 */
#include "measure/colors_avx512.h"

#include "base/lanes_avx2.h"
#include "measure/dense_row_avx2.h"
#include "texel/lengths_avx512_tmpl.h"
#include "texel/packed_avx512_tmpl.h"
#include "texel/sums_avx512_tmpl.h"
#include "texel/turn_avx512.h"
#include "texel/turn_avx512_tmpl.h"

#include <stddef.h>
#include <string.h>

enum {
    M = 255,
    K = 128,
    AM = K * (K - 1),
    STEP = 256, /* colors */
    ROOM = STEP + 256 + LANES_512,
    FIT_BINS = NTP__STEEPNESS_BINS,
    TURNS = 3 /* all angles; those of harm: of texels that fail, and below the horizon */
};

/* Of angles; the last one of 32 bits. */
typedef struct turn_sums {
    __m512i texels, sum, most;
} turn_sums;

typedef struct color_sums {
    __m512i length[2], squares[2], errors[2][FIT_BINS]; /* of 64 bits */
    __m512i inverted[2], greatest[2], levels[2];        /* of 32 bits */
    turn_sums turns[TURNS];
} color_sums;

typedef struct colors {
    int32_t n;
    int32_t sizes[ROOM], blue[ROOM]; /* k1 | k2 << 16 */
    uint32_t count[ROOM];
    /* Of one step: what angles are made of; where colors are counted. */
    int32_t xy[STEP], z[STEP], root[STEP];
    uint32_t keys[STEP];   /* of both encodings */
    uint32_t places[STEP]; /* distances of blue and bins of lengths */
    uint32_t bins[STEP], harm_bins[STEP], harm_count[STEP];
    int32_t turn[2 * STEP + LANES_512];
    double s[2 * STEP + LANES_512], d[2 * STEP + LANES_512], base[2 * STEP + LANES_512];
    __mmask16 is_lower[STEP / LANES_512], fails[STEP / LANES_512];
    color_sums sums;
} colors;

/* v + w * count, of 64 bits. */
static inline __m512i add_products(__m512i v, __m512i w, __m512i count)
{
    const __m512i odd = _mm512_mul_epu32(_mm512_srli_epi64(w, 32), _mm512_srli_epi64(count, 32));
    return _mm512_add_epi64(_mm512_add_epi64(v, odd), _mm512_mul_epu32(w, count));
}

static inline __m512i when(__mmask16 which, int32_t flag)
{
    return _mm512_maskz_mov_epi32(which, all(flag));
}

static inline __m512i flagged(__m512i key, __mmask16 which, int32_t flag)
{
    return _mm512_mask_or_epi32(key, which, key, all(flag));
}

/* low <= v < high, which are not in the wrong order. */
static inline __mmask16 within(__m512i v, __m512i low, __m512i high)
{
    return _mm512_cmplt_epu32_mask(_mm512_sub_epi32(v, low), _mm512_sub_epi32(high, low));
}

static inline __m512i plus(__m512i v, int32_t more)
{
    return _mm512_add_epi32(v, all(more));
}

static inline __m256i length_of_eight(__m256i square)
{
    const __m512d root = _mm512_sqrt_pd(_mm512_cvtepi32_pd(square));
    const __m512d length = _mm512_mul_pd(root, eight((double) NTP__LENGTH_ONE / M));
    return _mm512_cvttpd_epi32(_mm512_add_pd(length, eight(0.5)));
}

/* Adds lengths with these squares in numerators; returns their bins. */
ONE_COPY static __m512i add_lengths(color_sums *s, int32_t k, __m512i square, __m512i steep,
                                    __m512i count)
{
    const __m512i length =
        _mm512_inserti64x4(_mm512_castsi256_si512(length_of_eight(_mm512_castsi512_si256(square))),
                           length_of_eight(_mm512_extracti64x4_epi64(square, 1)), 1);
    const __m512i off = _mm512_abs_epi32(_mm512_sub_epi32(length, all(NTP__LENGTH_ONE)));
    s->length[k] = add_products(s->length[k], length, count);
    s->squares[k] = add_products(s->squares[k], _mm512_mullo_epi32(off, off), count);
    s->inverted[k] = _mm512_max_epu32(s->inverted[k], _mm512_xor_si512(length, all(-1)));
    s->greatest[k] = _mm512_max_epi32(s->greatest[k], length);
    /* mostly there is one bin of steepness */
    for (uint32_t left = 0xFFFF; left != 0;) {
        const __m512i first = _mm512_maskz_compress_epi32((__mmask16) left, steep);
        const int32_t bin = _mm_cvtsi128_si32(_mm512_castsi512_si128(first));
        const __mmask16 these = _mm512_cmpeq_epi32_mask(steep, all(bin));
        s->errors[k][bin] =
            add_products(s->errors[k][bin], _mm512_maskz_mov_epi32(these, off), count);
        left &= (uint32_t) ~these;
    }
    return _mm512_srli_epi32(length, 9);
}

/* Sixteen colors. */
static inline void judge(colors *c, int32_t i)
{
    color_sums *const s = &c->sums;
    const __m512i q = load(c->sizes + i), b = load(c->blue + i), count = load(c->count + i);
    const __m512i ones = _mm512_set1_epi16(1), zero = _mm512_setzero_si512();
    const __m512i v = _mm512_madd_epi16(q, _mm512_add_epi16(q, ones)),
                  kxy = plus(_mm512_madd_epi16(q, ones), 2);
    const __m512i e = _mm512_sub_epi32(all(REST_8), v), root = root_of(e, false);
    const __m512i z = plus(b, -K), u = _mm512_xor_si512(z, _mm512_srai_epi32(z, 31));
    const __m512i steep = _mm512_cvttps_epi32(_mm512_sqrt_ps(
        _mm512_mul_ps(_mm512_add_ps(_mm512_cvtepi32_ps(v), _mm512_set1_ps(0.5f)),
                      _mm512_set1_ps(64.0f / AM)))); /* v is whole: never next to another bin */
    const __mmask16 negative = _mm512_cmplt_epi32_mask(z, zero),
                    same = _mm512_cmpeq_epi32_mask(u, root);
    const __mmask16 lower = _mm512_cmplt_epi32_mask(z, all(-1));
    /* standard; off is a - A_M */
    const __m512i off =
        _mm512_sub_epi32(_mm512_madd_epi16(u, _mm512_add_epi32(u, all(1))), plus(e, 1));
    const __m512i k = plus(_mm512_add_epi32(kxy, u), 1), k2 = _mm512_add_epi32(k, k);
    const __mmask16 near = within(off, _mm512_sub_epi32(zero, k2), plus(k2, -6));
    const __m512i bin = _mm512_slli_epi32(steep, 8);
    __m512i key = flagged(bin, near, NTP_FLAG_NEIGHBOR);
    key = flagged(key, within(off, _mm512_sub_epi32(all(1), k), plus(k, -2)), NTP_FLAG_ROUNDED);
    key = flagged(key, same & (__mmask16) ~negative, NTP_FLAG_EXACT);
    key = flagged(key, same & negative, NTP__MIRRORED);
    key = flagged(key, negative, NTP_FLAG_Z_NEGATIVE);
    key = flagged(key, _mm512_cmpge_epi32_mask(off, zero), NTP__LONG);
    /* Z-zero */
    const __m512i r2 = _mm512_slli_epi32(kxy, 2);
    const __m512i t = _mm512_sub_epi32(_mm512_madd_epi16(b, b), _mm512_slli_epi32(e, 2));
    const __m512i reach = _mm512_add_epi32(r2, b), reach2 = _mm512_add_epi32(reach, reach);
    __m512i zz = flagged(bin, within(t, _mm512_sub_epi32(all(2), reach2), plus(reach2, -13)),
                         NTP_FLAG_NEIGHBOR);
    zz = flagged(zz, within(t, _mm512_sub_epi32(all(5), reach), plus(reach, -3)), NTP_FLAG_ROUNDED);
    const __m512i d = _mm512_sub_epi32(e, _mm512_madd_epi16(root, root)),
                  d2 = _mm512_add_epi32(d, d), root2 = _mm512_add_epi32(root, root);
    __m512i blue = plus(root2, 2);
    blue = _mm512_mask_sub_epi32(blue, _mm512_cmpgt_epi32_mask(root, plus(d2, 1)), blue, all(1));
    blue = _mm512_mask_sub_epi32(blue, _mm512_cmpgt_epi32_mask(_mm512_add_epi32(root2, root), d2),
                                 blue, all(1));
    const __m512i off_zz = _mm512_abs_epi32(_mm512_sub_epi32(b, blue));
    zz = flagged(zz, _mm512_testn_epi32_mask(off_zz, off_zz), NTP_FLAG_EXACT);
    zz = flagged(zz, _mm512_cmpgt_epi32_mask(t, all(3)), NTP__LONG);
    const __m512i off_std = _mm512_abs_epi32(_mm512_sub_epi32(u, root));
    s->levels[0] = _mm512_max_epi32(s->levels[0], off_std);
    s->levels[1] = _mm512_max_epi32(s->levels[1], off_zz);
    const __m512i bins[2] = {
        add_lengths(s, 0, plus(_mm512_slli_epi32(off, 2), 4 * AM + 3), steep, count),
        add_lengths(s, 1, plus(t, 4 * REST_8 + 2), steep, count),
    };
    store(c->keys + i, words_of(key, zz));
    store(c->places + i, words_of(_mm512_or_si512(off_std, _mm512_slli_epi32(off_zz, 8)),
                                  _mm512_or_si512(bins[0], _mm512_slli_epi32(bins[1], 8))));
    store(c->xy + i, v);
    store(c->z + i, odd_of(z));
    store(c->root + i, odd_of(root));
    c->is_lower[group_of(i)] = lower;
    c->fails[group_of(i)] = (__mmask16) ~(lower | near);
}

static void turn_vectors(colors *c, int32_t n)
{
    int32_t again[2 * STEP + LANES_512];
    const int32_t turns =
        ntp__flat_vectors_avx512(c->s, c->d, c->xy, c->z, c->root, c->is_lower, n);
    int32_t left = ntp__turns_avx512(c->turn, again, c->base, c->s, c->d, turns);
    while (left-- > 0) {
        const int32_t at = again[left], i = at < n ? at : find_lower(c->is_lower, at - n);
        c->turn[at] = flat_turn_again(c->d[at], c->xy[i], c->z[i], c->root[i], at < n);
    }
}

/* Sums angles, and finds their bins. */
static inline void sum_angles(colors *c, int32_t n)
{
    const int32_t *lower = c->turn + n;
    for (int32_t i = 0; i < n; i += LANES_512) {
        const __mmask16 is_lower = c->is_lower[group_of(i)], fails = c->fails[group_of(i)];
        const __m512i turn = load(c->turn + i), count = load(c->count + i);
        const __m512i angle = _mm512_mask_expand_epi32(turn, is_lower, load(lower));
        const __m512i of[TURNS] = { angle, turn, turn };
        const __mmask16 which[TURNS] = { 0xFFFF, fails, is_lower };
        lower += __builtin_popcount(is_lower);
        for (int32_t k = 0; k < TURNS; k++) {
            turn_sums *const s = &c->sums.turns[k];
            const __m512i its = _mm512_maskz_mov_epi32(which[k], count);
            s->texels = add_products(s->texels, all(1), its);
            s->sum = add_products(s->sum, of[k], its);
            s->most = _mm512_mask_max_epu32(s->most, which[k], s->most, of[k]);
        }
        store(c->bins + i, divided(plus(angle, 500), 274877907, 38));
        store(c->harm_bins + i,
              _mm512_add_epi32(divided(plus(turn, 9999), 3518437209, 45),
                               when(is_lower, 2 * sizeof(ntp__harm_sums) / sizeof(uint32_t))));
        store(c->harm_count + i, _mm512_maskz_mov_epi32(fails | is_lower, count));
    }
}

/* Angles fall into more memory than the caches near the processor hold: their bins are fetched while other
 * things are counted. */
static inline void count_places(ntp__sums *sums, uint64_t blues[256], const colors *c, int32_t n)
{
    ntp__fit_sums *const standard = &sums->fit[0], *const zz = &sums->fit[1];
    /* the bins of one kind of harm, and of others behind it */
    uint32_t *const harm =
        (uint32_t *) (void *) sums + offsetof(ntp__sums, harm[0].bins) / sizeof(uint32_t);
    for (int32_t i = 0; i < n; i++) {
        const uint32_t keys = c->keys[i], places = c->places[i], count = c->count[i];
        _mm_prefetch((const char *) (sums->angles.bins + c->bins[i]), _MM_HINT_T0);
        standard->flags[keys & 65535] += count;
        zz->flags[keys >> 16] += count;
        standard->levels_off[places & 255] += count;
        zz->levels_off[places >> 8 & 255] += count;
        standard->lengths[places >> 16 & 255] += count;
        zz->lengths[places >> 24] += count;
    }
    for (int32_t i = 0; i < n; i++) {
        blues[c->blue[i]] += c->count[i];
        sums->angles.bins[c->bins[i]] += c->count[i];
        harm[c->harm_bins[i]] += c->harm_count[i];
    }
}

/* Adds the first ones, and moves the others to the front. */
ONE_COPY static void add_step(ntp__sums *sums, uint64_t blues[256], colors *c, int32_t n)
{
    const int32_t whole = (n + LANES_512 - 1) & -LANES_512;
    for (int32_t i = 0; i < whole; i += LANES_512)
        judge(c, i);
    turn_vectors(c, whole);
    sum_angles(c, whole);
    count_places(sums, blues, c, n);
    c->n -= n;
    for (int32_t i = 0; i < c->n; i += LANES_512) {
        store(c->sizes + i, load(c->sizes + n + i));
        store(c->blue + i, load(c->blue + n + i));
        store(c->count + i, load(c->count + n + i));
    }
}

/* Puts the blues with a count side by side; returns how many they are. */
static inline int32_t keep(int32_t *blues, uint32_t *counts, __m512i blue, __m512i count)
{
    const __mmask16 some = _mm512_test_epi32_mask(count, count);
    store(blues, _mm512_maskz_compress_epi32(some, blue));
    store(counts, _mm512_maskz_compress_epi32(some, count));
    return __builtin_popcountll(some); /* that of 16 bits is slow */
}

static inline __m512i sixteen_bytes(const uint8_t *bytes)
{
    return _mm512_cvtepu8_epi32(_mm_loadu_si128((const void *) bytes));
}

/* Reads a row that is not noted as NTP__SEEN_OFTEN; returns its number of colors. */
ONE_COPY static int32_t read_row(int32_t *blues, uint32_t *counts, const ntp__color_counts *t,
                                 int32_t row)
{
    const uint64_t firsts = 0x1111111111111111; /* of four bits each */
    const uint32_t seen = t->at.row_seen[row], first = t->row[row].first;
    const uint32_t group = first / LANES_512 * 4;
    const uint8_t *const far = &t->at.far[row * NTP__ROW_CELLS];
    const uint8_t *const carried = &t->at.carried[row * NTP__ROW_CELLS];
    const __m512i near = load(&t->at.near[row * NTP__NEAR]), steps = steps_of(1, 0);
    int32_t n = 0;
    if ((seen & NTP__SEEN_QUARTERS) == 0)
        return keep(blues, counts, plus(steps, (int32_t) first), near);
    /* Which cells may hold counts, by fours; then by sixteens, of which near cells lie in one or two. */
    const uint32_t some = (uint32_t) _mm512_test_epi32_mask(near, near) << first % LANES_512;
    uint64_t left = 0;
    for (uint32_t k = 0; k < 4; k++) {
        if (!(seen & NTP__SEEN_QUARTER << k))
            continue;
        __m512i v = load(far + k * NTP__QUARTER);
        if (seen & NTP__SEEN_CARRIED)
            v = _mm512_or_si512(v, load(carried + k * NTP__QUARTER));
        const uint32_t its = _mm512_test_epi32_mask(v, v);
        left |= (uint64_t) its << 16 * k;
    }
    left |= (uint64_t) ((some & 0xFFFF) != 0) << group | (uint64_t) (some > 0xFFFF)
                                                             << (group + 4) % 64;
    left |= left >> 2;
    for (left = (left | left >> 1) & firsts; left != 0; left &= left - 1) {
        const int32_t b = __builtin_ctzll(left) * 4;
        const __m512i blue = plus(steps, b), place = _mm512_sub_epi32(blue, all((int32_t) first));
        __m512i count = _mm512_maskz_permutexvar_epi32(
            _mm512_cmplt_epu32_mask(place, all(NTP__NEAR)), place, near);
        if (seen & NTP__SEEN_QUARTER << b / NTP__QUARTER) {
            count = _mm512_add_epi32(count, sixteen_bytes(far + b));
            if (seen & NTP__SEEN_CARRIED)
                count = _mm512_add_epi32(count, _mm512_slli_epi32(sixteen_bytes(carried + b), 8));
        }
        n += keep(blues + n, counts + n, blue, count);
    }
    return n;
}

int32_t ntp__row_cells_avx512(ntp__cells *cells, const ntp__color_counts *counts, int32_t row)
{
    if (counts->at.row_seen[row] & NTP__SEEN_OFTEN)
        return ntp__row_cells(cells, counts, row);
    const int32_t n = read_row(cells->blue, cells->count, counts, row);
    end_lanes();
    return n;
}

/* Returns the number of texels. */
static uint64_t end_turns(uint64_t *texels_of, uint64_t *sum, uint64_t *most, const turn_sums *s)
{
    const uint64_t max = greatest_of(&s->most), number = sum_of_wide(&s->texels);
    *texels_of += number;
    *sum += sum_of_wide(&s->sum);
    *most = max > *most ? max : *most;
    return number;
}

static void end(ntp__sums *sums, const color_sums *s)
{
    ntp__harm_sums *const fails = &sums->harm[0], *const lower = &sums->harm[2];
    for (int32_t k = 0; k < 2; k++) {
        ntp__fit_sums *const fit = &sums->fit[k];
        fit->length_sum += sum_of_wide(&s->length[k]);
        fit->length_error2[0] += sum_of_wide(&s->squares[k]);
        for (int32_t i = 0; i < FIT_BINS; i++)
            fit->length_error[i] += sum_of_wide(&s->errors[k][i]);
        ntp__merge_max(&fit->length_max, greatest_of(&s->greatest[k]));
        ntp__merge_max(&fit->length_inverted_min, greatest_of(&s->inverted[k]));
        ntp__merge_max(&fit->levels_off_max, greatest_of(&s->levels[k]));
    }
    sums->texels +=
        end_turns(&sums->angles.texels, &sums->angles.sum, &sums->angles.max, &s->turns[0]);
    end_turns(&fails->texels, &fails->sum, &fails->max, &s->turns[1]);
    end_turns(&lower->texels, &lower->sum, &lower->max, &s->turns[2]);
}

/* Notes which quarters of a row hold counts, where all are noted as if they did; returns whether it is noted as
 * a dense row. */
static inline bool look_at_row(ntp__color_counts *counts, int32_t row)
{
    enum { ROWS = 12, AHEAD = ROWS * NTP__ROW_CELLS, NEAR_AHEAD = ROWS * NTP__NEAR * 4 };
    uint8_t *const seen = &counts->at.row_seen[row];
    const uint8_t *const far = &counts->at.far[row * NTP__ROW_CELLS];
    const char *const near = (const char *) &counts->at.near[row * NTP__NEAR];
    int32_t used = 0;
    uint32_t none = 0;
    *seen &= (uint8_t) ~NTP__SEEN_DENSE; /* it may be noted for an encoding before */
    if ((*seen & NTP__SEEN_QUARTERS) != NTP__SEEN_QUARTERS)
        return false;
    /* processors do not foresee short rows with other work between them */
    _mm_prefetch(near + NEAR_AHEAD, _MM_HINT_T0);
    for (int32_t k = 4; k-- > 0;) {
        const __m512i v = load(far + k * NTP__QUARTER);
        _mm_prefetch((const char *) far + AHEAD + k * NTP__QUARTER, _MM_HINT_T0);
        const int32_t its = __builtin_popcountll(_mm512_test_epi8_mask(v, v));
        used += its;
        none += none + (its == 0);
    }
    if (!(*seen & NTP__SEEN_CARRIED)) /* a cell of 0 may hold some */
        *seen &= (uint8_t) ~(none * NTP__SEEN_QUARTER);
    if (!counts->grouped || used < NTP__DENSE_512)
        return false;
    *seen |= NTP__SEEN_DENSE;
    return true;
}

void ntp__add_colors_avx512(ntp__sums *sums, uint64_t blues[256], ntp__color_counts *counts)
{
    colors c;
    c.n = 0;
    memset(&c.sums, 0, sizeof c.sums);
    for (int32_t row = 0; (row = ntp__next_row(counts->at.row_seen, row)) < NTP__ROWS; row++) {
        const int32_t pair = counts->row[row].pair, k1 = (pair & 255) - K, k2 = (pair >> 8) - K;
        if (counts->at.row_seen[row] & NTP__SEEN_OFTEN || !ntp__row_is_on_disc(counts, row) ||
            look_at_row(counts, row))
            continue;
        const int32_t end = c.n + read_row(c.blue + c.n, c.count + c.n, counts, row);
        for (; c.n < end; c.n += LANES_512)
            store(c.sizes + c.n, all(k1 | k2 << 16));
        c.n = end;
        while (c.n >= STEP)
            add_step(sums, blues, &c, STEP);
    }
    /* Those that make whole lanes are the last one, which counts for nothing. */
    if (c.n > 0) {
        const int32_t last = c.n - 1;
        store(c.sizes + c.n, all(c.sizes[last]));
        store(c.blue + c.n, all(c.blue[last]));
        store(c.count + c.n, _mm512_setzero_si512());
        add_step(sums, blues, &c, c.n);
    }
    end(sums, &c.sums);
    end_lanes();
}
