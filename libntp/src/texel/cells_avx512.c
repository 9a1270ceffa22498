/* SPDX-License-Identifier: MIT */
/*
 * cells_avx512.c - counts packed texels of 8 bit, close to exact or in the cells of a tally, with AVX-512
 *
 * As count_close8 and count_cells of cells_avx2.c, which says why the numbers are right, but 32 texels at a time,
 * and their sums and extremes on the way.  A count takes about as long as all the arithmetic for a texel.  So flat
 * texels with their derived blue, half of many textures, are counted by bits of masks instead.
 *
 * To look up which rows of cells are noted would take a third of the time of a count.  So they are noted in blocks,
 * whose bits are in two registers.
 *
 * No list is longer than the texels looked at so far, so there is room for 16 lanes at its end.
 */
#include "texel/kernels_avx512.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"
#include "texel/cells_avx2.h"
#include "texel/packed_avx512_tmpl.h"

#include <string.h>

enum { STEP = 32, FLAT = NTP__ROWS - NTP__FLAT_ROWS };

/* The lanes of a mask's low half, one after the other: behind them come any numbers.  Returns how many. */
static inline int32_t keep(uint32_t *at, __m512i places, __mmask32 mask)
{
    const __mmask16 these = (__mmask16) mask;
    _mm512_storeu_si512(at, _mm512_maskz_compress_epi32(these, places));
    return __builtin_popcount(these);
}

/* Sixteen of 32 words. */
static inline __m512i half_of(__m512i words, int k)
{
    return _mm512_cvtepu16_epi32(k ? _mm512_extracti64x4_epi64(words, 1)
                                   : _mm512_castsi512_si256(words));
}

/* Bytes `first` and first + 1 of 32 texels, in two registers of which the second begins at byte `second`. */
static inline __m512i bytes_of(int32_t channels, int32_t first, int32_t second)
{
    const __m512i from =
        _mm512_add_epi8(steps_of(0x02020202 * channels, 0x01000100 + 0x01010000 * channels),
                        _mm512_set1_epi8((char) first));
    const __mmask64 others = _mm512_cmpge_epu8_mask(from, _mm512_set1_epi8(64));
    return _mm512_mask_add_epi8(from, others, from, _mm512_set1_epi8((char) (64 - second)));
}

/* The greater ones of registers as texels of four channels. */
ONE_COPY static void merge_greatest(uint8_t *to, __m512i rg, __m512i b)
{
    const __m512i low = _mm512_unpacklo_epi16(rg, b), high = _mm512_unpackhi_epi16(rg, b);
    _mm512_storeu_si512(to, _mm512_max_epu8(_mm512_loadu_si512(to), low));
    _mm512_storeu_si512(to + 64, _mm512_max_epu8(_mm512_loadu_si512(to + 64), high));
}

ONE_COPY static uint64_t sum_of(__m512i v)
{
    return (uint64_t) _mm512_reduce_add_epi64(v);
}

static inline __m512i plus_bytes(__m512i sums, __m512i bytes)
{
    return _mm512_add_epi64(sums, _mm512_sad_epu8(bytes, _mm512_setzero_si512()));
}

/* Where the bytes of 32 texels are, in two registers. */
typedef struct layout {
    __m512i from_rg, from_b;
    __mmask64 used; /* of blue and alpha */
    int32_t second; /* where the second one begins: it ends with the texels */
} layout;

static ALWAYS_INLINE layout layout_of(int32_t channels)
{
    const int32_t second = STEP * channels - 64;
    return (layout) { bytes_of(channels, 0, second), bytes_of(channels, 2, second),
                      channels == 3 ? 0x5555555555555555 : UINT64_MAX, second };
}

/* Sums and extremes of texels so far; and the bits of blue and alpha that all have. */
typedef struct surveyed {
    __m512i least_rg, least_b, most_rg, most_b, sum_rg, sum_g, sum_b, every;
} surveyed;

static ALWAYS_INLINE surveyed begin_survey(void)
{
    const __m512i zero = _mm512_setzero_si512(), ones = _mm512_set1_epi8(-1);
    return (surveyed) { ones, ones, zero, zero, zero, zero, zero, ones };
}

/* Thirty-two texels: red and green, blue and alpha or 0, and blue. */
typedef struct taken {
    __m512i rg, blue_alpha, b;
} taken;

static ALWAYS_INLINE taken take(surveyed *s, const uint8_t *src, const layout *l)
{
    const __m512i v = _mm512_loadu_si512(src), w = _mm512_loadu_si512(src + l->second);
    const __m512i low = _mm512_set1_epi16(255);
    taken t;
    t.rg = _mm512_permutex2var_epi8(v, l->from_rg, w);
    t.blue_alpha = _mm512_maskz_permutex2var_epi8(l->used, v, l->from_b, w);
    t.b = _mm512_and_si512(t.blue_alpha, low);
    s->every = _mm512_and_si512(s->every, t.blue_alpha);
    s->least_rg = _mm512_min_epu8(s->least_rg, t.rg);
    s->least_b = _mm512_min_epu8(s->least_b, t.b);
    s->most_rg = _mm512_max_epu8(s->most_rg, t.rg);
    s->most_b = _mm512_max_epu8(s->most_b, t.b);
    s->sum_rg = plus_bytes(s->sum_rg, t.rg);
    s->sum_g = plus_bytes(s->sum_g, _mm512_srli_epi16(t.rg, 8));
    s->sum_b = plus_bytes(s->sum_b, t.b);
    return t;
}

/* Adds what was found of n texels. */
ONE_COPY static void end_survey(ntp__packed_survey *to, const surveyed *s, int32_t n)
{
    const __m512i ones = _mm512_set1_epi8(-1);
    merge_greatest(to->extremes[0], _mm512_xor_si512(s->least_rg, ones),
                   _mm512_xor_si512(s->least_b, ones));
    merge_greatest(to->extremes[1], s->most_rg, s->most_b);
    to->texels += (uint64_t) n;
    to->translucent |= _mm512_cmplt_epu16_mask(s->every, _mm512_set1_epi16((short) 0xff00)) != 0;
    const uint64_t greens = sum_of(s->sum_g);
    to->sum[0] += sum_of(s->sum_rg) - greens;
    to->sum[1] += greens;
    to->sum[2] += sum_of(s->sum_b);
}

/* Which are gray. */
static ALWAYS_INLINE __mmask32 are_gray(taken t)
{
    const __m512i twice =
        _mm512_broadcast_i32x4(_mm_setr_epi8(0, 0, 2, 2, 4, 4, 6, 6, 8, 8, 10, 10, 12, 12, 14, 14));
    return _mm512_cmpeq_epi16_mask(t.rg, _mm512_shuffle_epi8(t.b, twice));
}

/* Counts gray ones, and those among them that are unused for being black or white.  Returns which these are. */
static ALWAYS_INLINE __mmask32 unused_grays(ntp__found8 *found, taken t, __mmask32 gray)
{
    __mmask32 black = 0, white = 0;
    if (!(found->used & NTP__BLACK8))
        black = _mm512_mask_testn_epi16_mask(gray, t.rg, t.rg);
    if (!(found->used & NTP__WHITE8))
        white = _mm512_mask_cmpeq_epi16_mask(gray, t.rg, _mm512_set1_epi8(-1));
    found->gray += (uint32_t) __builtin_popcount(gray);
    found->black += (uint32_t) __builtin_popcount(black);
    found->white += (uint32_t) __builtin_popcount(white);
    return black | white;
}

/* The k of red and green. */
static ALWAYS_INLINE __m512i k_of(__m512i rg)
{
    return _mm512_min_epu8(_mm512_xor_si512(rg, _mm512_set1_epi8(127)),
                           _mm512_xor_si512(rg, _mm512_set1_epi8(-128)));
}

/* Their rows; those in the middle are flat. */
static ALWAYS_INLINE __m512i rows_of(__m512i rg, __m512i k, __mmask32 in_middle)
{
    const __m512i p = _mm512_and_si512(k, _mm512_set1_epi16(255)), q = _mm512_srli_epi16(k, 8);
    const __m512i k1 = _mm512_max_epi16(p, q), k2 = _mm512_min_epi16(p, q);
    const __m512i rectangle = _mm512_mullo_epi16(k1, _mm512_sub_epi16(k1, _mm512_set1_epi16(-1)));
    return _mm512_mask_add_epi16(_mm512_add_epi16(_mm512_srli_epi16(rectangle, 1), k2), in_middle,
                                 _mm512_maddubs_epi16(rg, _mm512_set1_epi16(0x201)),
                                 _mm512_set1_epi16(FLAT - (127 + 2 * 127)));
}

/* Are 64 bytes those of the texels before?  Plain areas of textures are counted by the number of such steps. */
static ALWAYS_INLINE bool are_as_before(const uint8_t *src, int32_t channels)
{
    return _mm512_cmpneq_epi8_mask(_mm512_loadu_si512(src), _mm512_loadu_si512(src - channels)) ==
           0;
}

/* The k of one level. */
static inline uint32_t k_of_one(uint32_t level)
{
    return level ^ (level < 128 ? 127 : 128);
}

/* Counts of four bits in each lane of 16, as bytes: those of even rows, and those of odd ones. */
static ALWAYS_INLINE void add_flat(__m512i sums[2], __m512i flat)
{
    const __m512i low = _mm512_set1_epi8(15);
    sums[0] = _mm512_add_epi8(sums[0], _mm512_and_si512(flat, low));
    sums[1] = _mm512_add_epi8(sums[1], _mm512_and_si512(_mm512_srli_epi16(flat, 4), low));
}

/* Are all of these equal?  n is a multiple of STEP. */
static ALWAYS_INLINE bool are_equal(const uint32_t *at, int32_t n)
{
    if (at[n - 1] != at[0] || at[n / 2] != at[0])
        return false;
    __mmask16 others = 0;
    for (int32_t i = 0; i < n; i += LANES_512)
        others |= _mm512_cmpneq_epi32_mask(_mm512_loadu_si512(at + i),
                                           _mm512_set1_epi32((int32_t) at[0]));
    return others == 0;
}

/* Counts waiting texels, of all these n or some of them. */
static ALWAYS_INLINE void count_waiting(uint32_t *counts, uint32_t *at, int32_t waiting, int32_t n)
{
    enum { COPIES = NTP__CLOSE8_COPIES };
    _mm512_storeu_si512(at + waiting, _mm512_set1_epi32(NTP__CLOSE8_NONE * COPIES));
    /* Else each of these counts would wait for the one before. */
    if (waiting == n && are_equal(at, n)) {
        for (int k = 0; k < COPIES; k++)
            counts[at[0] + (uint32_t) k] += (uint32_t) n / COPIES;
        return;
    }
    for (int32_t i = 0; i < waiting; i += COPIES) {
        uint64_t two[2];
        memcpy(two, at + i, sizeof two);
        counts[(uint32_t) two[0]]++;
        counts[(two[0] >> 32) + 1]++;
        counts[(uint32_t) two[1] + 2]++;
        counts[(two[1] >> 32) + 3]++;
    }
}

/* Counts a run of texels that are each like the one before, in whole steps of n texels, unless they are to be in the
 * list of colors; returns how many, below 0 if they are not counted. */
ONE_COPY static int32_t count_run(ntp__close8_block *out, ntp__close8_counts close,
                                  const uint8_t *p, int32_t n, int32_t channels, size_t ahead)
{
    const uint32_t a = k_of_one(p[0]), b = k_of_one(p[1]), u = p[2] < 127 ? 0 : p[2] - 127U;
    const uint32_t k1 = a > b ? a : b, k2 = a > b ? b : a;
    const uint32_t sum = u * (u + 8) + a * (a + 1) + b * (b + 1) - (REST_8 - 15);
    int32_t i = 0;
    for (; i <= n * channels - 64 && are_as_before(p + i, channels); i += 64)
        _mm_prefetch((const char *) p + i + ahead, _MM_HINT_T0);
    const int32_t run = i / channels & -STEP;
    if (channels == 4 && out->visible && p[3] == 0) {
        out->hidden += run;
    } else if ((p[0] | p[1] | p[2] | (out->found.used & NTP__BLACK8)) == 0) {
        out->found.gray += (uint32_t) run;
        out->found.black += (uint32_t) run;
    } else if (((p[0] == p[1]) & (p[1] == p[2])) || 16 * u <= (sum & 65535)) {
        return -run;
    } else {
        const uint32_t row =
            k1 == 0 ? FLAT - (127 + 2 * 127) + p[0] + 2U * p[1] : k1 * (k1 + 1) / 2 + k2;
        close[ntp__close8_of(row, p[2])][0] += (uint32_t) run;
    }
    for (int32_t k = 0; k < 3; k++)
        out->found.survey->sum[k] += (uint64_t) ((uint32_t) run * p[k]);
    return run;
}

int32_t ntp__count_close8_avx512(ntp__close8_block *out, ntp__close8_counts close,
                                 const uint8_t *src, int32_t n, int32_t channels, size_t ahead)
{
    enum {
        MOVED = FLAT - NTP__CLOSE8_ROWS,
        AT_ONCE = 15 * STEP, /* counts of four bits hold no more */
        MOST = 256 - STEP    /* colors, before a step */
    };
    _Alignas(64) uint32_t at[AT_ONCE + LANES_512];
    const layout at_src = layout_of(channels);
    const bool hides = channels == 4 && out->visible;
    const __m512i low = _mm512_set1_epi16(255), one = _mm512_set1_epi8(1);
    const __m512i one_flat =
        _mm512_set1_epi64(0x1000010000100001); /* by number of row: 16 to its last bits */
    surveyed survey = begin_survey();
    __m512i flats[2] = { _mm512_setzero_si512(), _mm512_setzero_si512() };
    int32_t i = 0, colors = 0, hidden = 0, next_run = STEP;
    out->hidden = 0;
    while (i < n && colors <= MOST) {
        const int32_t first = i, end = n - i < AT_ONCE ? n : i + AT_ONCE;
        int32_t waiting = 0;
        bool runs = false;
        __m512i flat = _mm512_setzero_si512(); /* one count for each flat pair */
        for (; i < end && colors <= MOST; i += STEP, src += channels * STEP) {
            if (i >= next_run && are_as_before(src, channels)) {
                runs = true;
                break;
            }
            /* processors fetch what follows */
            _mm_prefetch((const char *) src + ahead, _MM_HINT_T0);
            _mm_prefetch((const char *) src + ahead + 64, _MM_HINT_T0);
            const taken t = take(&survey, src, &at_src);
            const __m512i k = k_of(t.rg);
            const __m512i xy = _mm512_maddubs_epi16(_mm512_add_epi8(k, one), k);
            const __m512i u = _mm512_subs_epu16(t.b, _mm512_set1_epi16(127));
            const __m512i square = _mm512_mullo_epi16(u, _mm512_add_epi16(u, _mm512_set1_epi16(8)));
            const __m512i sum =
                _mm512_add_epi16(square, _mm512_sub_epi16(xy, _mm512_set1_epi16(REST_8 - 15)));
            const __mmask32 in_middle = _mm512_testn_epi16_mask(k, k);
            const __m512i row = rows_of(t.rg, k, in_middle);
            const __m512i place = _mm512_or_si512(
                _mm512_mask_sub_epi16(row, in_middle, row, _mm512_set1_epi16(MOVED)),
                _mm512_slli_epi16(t.b, NTP__CLOSE8_SHIFT));
            __mmask32 gray = are_gray(t);
            __mmask32 other = gray | _mm512_cmple_epu16_mask(_mm512_slli_epi16(u, 4), sum);
            __mmask32 exact = _mm512_mask_cmpeq_epi16_mask(in_middle, t.b, low);
            __mmask32 counted = ~(other | exact);
            if (hides) {
                const __mmask32 shown = _mm512_cmpgt_epu16_mask(t.blue_alpha, low);
                hidden += STEP - __builtin_popcount(shown);
                gray &= shown;
                other &= shown;
                exact &= shown;
                counted &= shown;
            }
            flat =
                _mm512_mask_add_epi16(flat, exact, flat, _mm512_permutexvar_epi16(row, one_flat));
            UNROLLED
            for (int h = 0; h < 2; h++)
                waiting += keep(at + waiting, _mm512_slli_epi32(half_of(place, h), 2),
                                counted >> LANES_512 * h);
            if (other == 0)
                continue;
            other &= ~unused_grays(&out->found, t, gray);
            UNROLLED
            for (int h = 0; h < 2; h++) {
                const __m512i blue = _mm512_slli_epi32(half_of(t.b, h), 16);
                colors += keep(out->color + colors, _mm512_or_si512(half_of(row, h), blue),
                               other >> LANES_512 * h);
            }
        }
        add_flat(flats, flat);
        if (i > first)
            count_waiting(close[0], at, waiting, i - first);
        if (!runs)
            continue;
        const int32_t run = count_run(out, close, src, n - i, channels, ahead);
        const int32_t counted = run < 0 ? 0 : run;
        next_run = i + (run < 0 ? -run : run) + STEP;
        src += channels * counted;
        i += counted;
    }
    for (uint32_t k = 0; k < NTP__FLAT_ROWS; k++) {
        const __m512i counts = _mm512_srl_epi16(flats[k & 1], _mm_cvtsi32_si128((int) k / 2 * 8));
        close[ntp__close8_of(FLAT + k, 255)][0] +=
            (uint32_t) sum_of(plus_bytes(_mm512_setzero_si512(), _mm512_and_si512(counts, low)));
    }
    out->others = 0;
    out->colors = colors;
    out->hidden += hidden;
    const surveyed all = survey;
    end_survey(out->found.survey, &all, i);
    end_lanes();
    return i;
}

/* Which of these rows are in blocks that are not noted. */
static ALWAYS_INLINE __mmask32 are_new(__m512i row, __m512i noted0, __m512i noted1)
{
    const __m512i bits = _mm512_set1_epi64((long long) 0x8040201008040201);
    const __m512i block = _mm512_srli_epi16(row, NTP__BLOCK_SHIFT);
    /* of 128 bytes, which is all blocks */
    const __m512i byte = _mm512_permutex2var_epi8(noted0, _mm512_srli_epi16(block, 3), noted1);
    /* of the high bytes no bit */
    const __m512i which = _mm512_ternarylogic_epi64(block, _mm512_set1_epi16(7),
                                                    _mm512_set1_epi16((short) 0x8000), 0xea);
    return _mm512_testn_epi16_mask(byte, _mm512_shuffle_epi8(bits, which));
}

/* Notes the blocks of n rows. */
ONE_COPY static void note_blocks(ntp__cell_counts *counts, const uint16_t *rows, int32_t n)
{
    enum { ROWS = 1 << NTP__BLOCK_SHIFT };
    for (int32_t i = 0; i < n;) {
        const __mmask32 new_ones =
            are_new(_mm512_loadu_si512(rows + i), _mm512_loadu_si512(counts->noted),
                    _mm512_loadu_si512(counts->noted + 64));
        if (new_ones == 0) {
            i += STEP;
            continue;
        }
        const int32_t block = ntp__row_block(rows[i + __builtin_ctz(new_ones)]);
        counts->noted[block >> 3] |= (uint8_t) (1 << (block & 7));
        for (int32_t first = block * ROWS; first < NTP__ROWS; first += NTP__ROW_BLOCKS * ROWS) {
            for (int32_t k = first; k < first + ROWS && k < NTP__ROWS; k++)
                counts->row_seen[k] |= NTP__SEEN_QUARTERS;
        }
    }
}

int32_t ntp__count_cells_avx512(ntp__cell_counts *counts, ntp__found8 *found, const uint8_t *src,
                                int32_t n, int32_t channels, size_t ahead)
{
    const layout at_src = layout_of(channels);
    const __mmask32 hidden = channels == 4 && !(found->used & NTP__CLEAR8) ? UINT32_MAX : 0;
    const __m512i low = _mm512_set1_epi16(255), by = _mm512_set1_epi32(1 << 16 | NTP__ROW_CELLS);
    const int32_t whole = n & -STEP;
    surveyed survey = begin_survey();
    uint32_t at[NTP__WAITING8];
    uint16_t rows[NTP__WAITING8];
    for (int32_t i = 0; i < whole;) {
        const __m512i noted0 = _mm512_loadu_si512(counts->noted),
                      noted1 = _mm512_loadu_si512(counts->noted + 64);
        __mmask32 new_ones = 0;
        int32_t looked = 0, waiting = 0;
        /* Calls would take these registers, so there is none. */
        for (; looked < NTP__WAITING8 && i < whole;
             looked += STEP, i += STEP, src += channels * STEP) {
            _mm_prefetch((const char *) src + ahead, _MM_HINT_T0);
            _mm_prefetch((const char *) src + ahead + 64, _MM_HINT_T0);
            const taken t = take(&survey, src, &at_src);
            const __m512i k = k_of(t.rg), row = rows_of(t.rg, k, _mm512_testn_epi16_mask(k, k));
            __mmask32 left_out = hidden & _mm512_cmple_epu16_mask(t.blue_alpha, low);
            const __mmask32 gray = are_gray(t) & ~left_out;
            if (gray != 0)
                left_out |= unused_grays(found, t, gray);
            new_ones |= are_new(row, noted0, noted1) & ~left_out;
            const __m512i cells[2] = { _mm512_madd_epi16(_mm512_unpacklo_epi16(row, t.b), by),
                                       _mm512_madd_epi16(_mm512_unpackhi_epi16(row, t.b), by) };
            const __m512i first = _mm512_broadcastd_epi32(_mm512_castsi512_si128(cells[0]));
            _mm512_storeu_si512(rows + looked, row);
            if (left_out != 0) {
                /* words of which a half of each lane is in cells[0] */
                const __m512i kept = _mm512_movm_epi16(~left_out);
                const __m512i halves[2] = { _mm512_unpacklo_epi16(kept, kept),
                                            _mm512_unpackhi_epi16(kept, kept) };
                UNROLLED
                for (int h = 0; h < 2; h++) {
                    const __mmask16 these = _mm512_test_epi32_mask(halves[h], halves[h]);
                    _mm512_storeu_si512(at + waiting, _mm512_maskz_compress_epi32(these, cells[h]));
                    waiting += __builtin_popcount(these);
                }
            } else if ((_mm512_cmpneq_epi32_mask(cells[0], first) |
                        _mm512_cmpneq_epi32_mask(cells[1], first)) == 0) {
                const uint32_t cell = (uint32_t) _mm_cvtsi128_si32(_mm512_castsi512_si128(first));
                counts->far[cell] += STEP;
                if (counts->far[cell] < STEP)
                    ntp__carry_inline(counts, cell);
            } else {
                _mm512_storeu_si512(at + waiting, cells[0]);
                _mm512_storeu_si512(at + waiting + LANES_512, cells[1]);
                waiting += STEP;
            }
        }
        if (new_ones != 0)
            note_blocks(counts, rows, looked);
        ntp__count_each8(counts, at, waiting);
    }
    const surveyed all = survey;
    end_survey(found->survey, &all, whole);
    return whole + ntp__count_cells_avx2(counts, found, src, n - whole, channels, ahead);
}
