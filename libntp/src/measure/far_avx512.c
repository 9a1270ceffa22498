/* SPDX-License-Identifier: MIT */
/*
 * far_avx512.c - adds 16-bit texels that are far from exact, sixteen at a time, with AVX-512
 *
 * As far_avx2.c, which says how neighbors are found and what the angles are, and the numbers are the same.
 * Of groups with neighbors only these are left to others: the rest waits until it makes a group.
 */
#include "measure/far_lanes_avx512_tmpl.h"
#include "measure/far_words_tmpl.h"

#include "base/lanes_avx2.h"
#include "texel/lengths_avx512_tmpl.h"
#include "texel/packed_avx512_tmpl.h"
#include "texel/survey_avx512_tmpl.h"
#include "texel/turn_avx512.h"
#include "texel/turn_avx512_tmpl.h"

#include <stddef.h>
#include <string.h>

enum { STEP = NTP__FAR_STEP, ALL = 2 * STEP + LANES_512 };

/* Sums of up to MOST texels; of angles, which are below 2^27.5, 32 bits of 16 lanes hold those of 256. */
enum { MOST = 4096 };

typedef struct far_lengths {
    __m512i sum, least, greatest, squares, of_padding;
} far_lengths;

typedef struct far_angles {
    __m512i sum, greatest; /* of 64 bits, of 32 */
    uint32_t texels;
} far_angles;

/* What is found out about up to STEP texels, in planes: long loops would leave room for few steps in
 * flight. */
typedef struct far_texels {
    ntp__far_places places;
    int32_t harm[STEP]; /* which kind, times ONE_HARM */
    int32_t off[STEP];  /* lengths from 1 */
    int32_t blue[STEP];
    int32_t xy[STEP], z[STEP], root[STEP];
    /* Angles, and what they are made of: those of harm; then those of texels below the horizon to their clean
     * vectors, and of those that are too long. */
    int32_t turn[ALL];
    union { /* one after the other: all of this is to stay in the first cache */
        double base[ALL];
        struct {
            int32_t whole[STEP];
            float rest[STEP], over[STEP];
        };
    };
    double s[ALL], d[ALL], s2[STEP + LANES_512];
    int32_t n, negative, too_long, padding;
    int32_t padded[STEP + LANES_512]; /* places of padding with harm */
    __mmask16 is_lower[STEP / LANES_512], is_long[STEP / LANES_512], is_padding[STEP / LANES_512];
    int32_t rg_long[STEP + LANES_512], b_long[STEP + LANES_512];
    /* Texels without neighbors that wait for more. */
    int32_t rg[2 * LANES_512], b[2 * LANES_512], waiting;
    struct far_sums {
        surveyed seen;
        __m512i most[2]; /* levels */
        far_lengths lengths[2];
        /* Distances of lengths from 1: of this bin of steepness and the following; of padding */
        __m512i errors[NTP__ALL_BINS], error_zz;
        far_angles angles, kind[NTP__HARM_KINDS];
    } sums;
} far_texels;

/* Appends lanes to a list; 16 of it are written. */
static inline void append(int32_t *to, __mmask16 which, __m512i v)
{
    store(to, _mm512_maskz_compress_epi32(which, v));
}

static inline int32_t count_of(__mmask16 mask)
{
    return __builtin_popcount(mask);
}

/* Two words for each of sixteen texels. */
static inline void put_two(uint64_t *to, __m512i v, __m512i w)
{
    store(to, _mm512_unpacklo_epi32(v, w));
    store(to + 8, _mm512_unpackhi_epi32(v, w));
}

/* Derives blues, and notes how far blue is from these. */
static inline void note_levels(far_texels *f)
{
    __m512i most = f->sums.most[0], most_zz = f->sums.most[1];
    for (int32_t i = 0; i < f->n; i += LANES_512) {
        const __m512i e = _mm512_sub_epi32(all(REST_16), load(f->xy + i)), b = load(f->blue + i);
        const __m512i root = root_of(e, true), z = _mm512_sub_epi32(b, all(K));
        const __m512i up = _mm512_xor_si512(z, _mm512_srai_epi32(z, 31));
        const __mmask16 fine = (__mmask16) ~f->is_long[group_of(i)];
        const __m512i off = _mm512_abs_epi32(_mm512_sub_epi32(up, root));
        /* as in blue_avx2_tmpl.h */
        const __m512i more = _mm512_sub_epi32(e, _mm512_madd_epi16(root, root));
        const __m512i d2 = _mm512_add_epi32(more, more), t2 = _mm512_add_epi32(root, root);
        __m512i blue = _mm512_add_epi32(t2, all(2));
        blue = _mm512_mask_sub_epi32(
            blue, _mm512_cmpgt_epi32_mask(root, _mm512_add_epi32(d2, all(1))), blue, all(1));
        blue = _mm512_mask_sub_epi32(blue, _mm512_cmpgt_epi32_mask(_mm512_add_epi32(t2, root), d2),
                                     blue, all(1));
        const __m512i off_zz = _mm512_abs_epi32(_mm512_sub_epi32(b, blue));
        most = _mm512_mask_max_epi32(most, fine, most, off);
        most_zz = _mm512_mask_max_epi32(most_zz, fine, most_zz, off_zz);
        store(f->root + i, odd_of(root));
        put_two(f->places.words + i,
                _mm512_mask_add_epi32(all(LEVELS + NTP__NO_BLUE), fine, off, all(LEVELS)),
                _mm512_mask_add_epi32(all(LEVELS_ZZ + NTP__NO_BLUE), fine, off_zz, all(LEVELS_ZZ)));
    }
    f->sums.most[0] = most;
    f->sums.most[1] = most_zz;
}

/* Notes sixteen texels. */
static inline void note(far_texels *f, const far_lanes *v)
{
    enum { PADDED = M / 2 - (16 * 257 - 128) }; /* above: 16 levels of 8 bit from an end */
    const __m512i xy = _mm512_sub_epi32(all(REST_16), v->e);
    const __m512i least = _mm512_min_epu16(v->q, _mm512_rol_epi32(v->q, 16));
    const __mmask16 padding = _mm512_cmpgt_epi32_mask(_mm512_srli_epi32(least, 16), all(PADDED));
    const __mmask16 longs = is_negative(v->e),
                    negative = is_negative(_mm512_add_epi32(v->z, all(1)));
    const __mmask16 lower = negative & (__mmask16) ~longs;
    /* |X| - 2 and |Y| - 2 are too long as well */
    const __mmask16 pair = _mm512_cmplt_epi32_mask(_mm512_add_epi32(v->e, v->sizes), all(2));
    __m512i kind = _mm512_maskz_mov_epi32(pair, all(ONE_HARM));
    kind = _mm512_mask_mov_epi32(kind, negative, all(2 * ONE_HARM));
    kind = _mm512_mask_add_epi32(kind, pair & padding, kind, all(NTP__PADDING_HARM * ONE_HARM));
    store(f->places.shape + f->n, key_of(v, xy, padding));
    store(f->blue + f->n, v->b);
    store(f->harm + f->n, kind);
    store(f->xy + f->n, xy);
    store(f->z + f->n, odd_of(v->z));
    append(f->rg_long + f->too_long, longs, v->rg);
    append(f->b_long + f->too_long, longs, v->b);
    append(f->padded + f->padding, pair & padding, steps_of(1, f->n));
    f->is_lower[group_of(f->n)] = lower;
    f->is_long[group_of(f->n)] = longs;
    f->is_padding[group_of(f->n)] = padding;
    f->negative += count_of(lower);
    f->too_long += count_of(longs);
    f->padding += count_of(pair & padding);
    f->n += LANES_512;
}

static inline __m512i add_squares(__m512i sums, __m512i v)
{
    const __m512i odd = _mm512_srli_epi64(v, 32);
    return _mm512_add_epi64(sums,
                            _mm512_add_epi64(_mm512_mul_epu32(v, v), _mm512_mul_epu32(odd, odd)));
}

/* Notes bins of lengths, and adds these and their distances from 1.  Returns the distances of padding. */
ONE_COPY static __m512i add_lengths(far_lengths *sums, far_texels *f, const int32_t *z)
{
    far_lengths s = *sums;
    __m512i padded = _mm512_setzero_si512();
    roots_of(f->whole, f->rest, f->over, f->xy, z, f->n);
    for (int32_t i = 0; i < f->n; i += LANES_512) {
        const __m512i length = lengths_of(load(f->whole + i), _mm512_loadu_ps(f->rest + i),
                                          _mm512_loadu_ps(f->over + i), f->xy + i, z + i);
        const __m512i off = _mm512_abs_epi32(_mm512_sub_epi32(length, all(NTP__LENGTH_ONE)));
        const __m512i of_padding = _mm512_maskz_mov_epi32(f->is_padding[group_of(i)], off);
        const __m512i shape = _mm512_slli_epi32(load(f->places.shape + i), 8);
        s.sum = _mm512_add_epi32(s.sum, length);
        s.least = _mm512_min_epi32(s.least, length);
        s.greatest = _mm512_max_epi32(s.greatest, length);
        s.squares = add_squares(s.squares, off);
        s.of_padding = add_squares(s.of_padding, of_padding);
        padded = _mm512_add_epi32(padded, of_padding);
        store(f->off + i, off);
        store(f->places.shape + i, _mm512_or_si512(shape, _mm512_srli_epi32(length, LENGTH_BIN)));
    }
    *sums = s;
    return padded;
}

/* Adds distances of lengths from 1 by steepness. */
static inline void add_errors(far_texels *f)
{
    for (int32_t k = 0; k < NTP__ALL_BINS; k++) {
        const __m512i first = all(k * NTP__KEY_STEEP * NTP__LENGTH_BINS);
        __m512i sum = f->sums.errors[k];
        for (int32_t i = 0; i < f->n; i += LANES_512) {
            const __mmask16 its = _mm512_cmpge_epi32_mask(load(f->places.shape + i), first);
            sum = _mm512_mask_add_epi32(sum, its, sum, load(f->off + i));
        }
        f->sums.errors[k] = sum;
    }
}

static void end_lengths(ntp__fit_sums *fit, const far_lengths *s)
{
    const uint64_t squares = sum_of_wide(&s->squares);
    const uint64_t of_padding = sum_of_wide(&s->of_padding);
    const __m512i inverted = _mm512_xor_si512(s->least, all(-1));
    fit->length_sum += sum_of(&s->sum);
    fit->length_error2[0] += squares - of_padding;
    fit->length_error2[1] += of_padding;
    ntp__merge_max(&fit->length_max, greatest_of(&s->greatest));
    ntp__merge_max(&fit->length_inverted_min, greatest_of(&inverted));
}

static int32_t turn_again(const far_texels *f, int32_t at)
{
    const int32_t longs = f->n + f->negative,
                  i = at < f->n ? at : find_lower(f->is_lower, at - f->n);
    if (at >= longs)
        return slow_turn(f->s2[at - longs], f->d[at]);
    return flat_turn_again(f->d[at], f->xy[i], f->z[i], f->root[i], at < f->n);
}

/* All angles. */
static void turn_vectors(far_texels *f)
{
    int32_t again[ALL];
    store(f->rg_long + f->too_long, _mm512_setzero_si512());
    store(f->b_long + f->too_long, _mm512_setzero_si512());
    const int32_t lower =
        ntp__flat_vectors_avx512(f->s, f->d, f->xy, f->z, f->root, f->is_lower, f->n);
    long_products(f->s + lower, f->s2, f->d + lower, f->rg_long, f->b_long, f->too_long);
    int32_t left = ntp__turns_avx512(f->turn, again, f->base, f->s, f->d, lower + f->too_long);
    while (left-- > 0)
        f->turn[again[left]] = turn_again(f, again[left]);
}

/* Those of one step. */
typedef struct some_angles {
    __m512i sum, greatest;
    int32_t texels;
} some_angles;

static inline void no_angles(some_angles *of)
{
    of->sum = of->greatest = _mm512_setzero_si512();
    of->texels = 0;
}

static inline void add_angles(some_angles *of, __m512i angle, __mmask16 which)
{
    of->sum = _mm512_mask_add_epi32(of->sum, which, of->sum, angle);
    of->greatest = _mm512_mask_max_epi32(of->greatest, which, of->greatest, angle);
    of->texels += count_of(which);
}

static inline void merge_angles(far_angles *into, const some_angles *from)
{
    const __m512i even = _mm512_and_si512(from->sum, _mm512_set1_epi64(UINT32_MAX));
    const __m512i both = _mm512_add_epi64(even, _mm512_srli_epi64(from->sum, 32));
    into->sum = _mm512_add_epi64(into->sum, both);
    into->greatest = _mm512_max_epi32(into->greatest, from->greatest);
    into->texels += (uint32_t) from->texels;
}

static void end_angles(uint64_t *count, uint64_t *sum, uint64_t *max, const far_angles *sums)
{
    const uint32_t most = greatest_of(&sums->greatest);
    *count += sums->texels;
    *sum += sum_of_wide(&sums->sum);
    *max = most > *max ? most : *max;
}

/* Sums angles, and makes words of them. */
static void sum_angles(far_texels *f)
{
    const int32_t *lower = f->turn + f->n, *longer = lower + f->negative;
    some_angles every, failing, too_long, negative;
    no_angles(&every);
    no_angles(&failing);
    no_angles(&too_long);
    no_angles(&negative);
    for (int32_t i = 0; i < f->n; i += LANES_512) {
        const __mmask16 is_lower = f->is_lower[group_of(i)], is_long = f->is_long[group_of(i)];
        const __m512i its = load(f->harm + i);
        __m512i turn = load(f->turn + i),
                angle = _mm512_mask_expand_epi32(turn, is_lower, load(lower));
        angle = _mm512_mask_expand_epi32(angle, is_long, load(longer));
        lower += count_of(is_lower);
        longer += count_of(is_long);
        /* Those that are too long, and not below the horizon. */
        turn = _mm512_mask_mov_epi32(
            turn, is_long & _mm512_cmpge_epi32_mask(load(f->z + i), all(-1)), angle);
        add_angles(&every, angle, 0xFFFF);
        add_angles(&failing, turn, _mm512_testn_epi32_mask(its, its));
        add_angles(&too_long, turn, _mm512_cmpeq_epi32_mask(its, all(ONE_HARM)));
        add_angles(&negative, turn, _mm512_cmpeq_epi32_mask(its, all(2 * ONE_HARM)));
        store(f->turn + i, turn);
        const __m512i bin = divided(_mm512_add_epi32(angle, all(500)), 274877907, 38);
        const __m512i bin_harm = divided(_mm512_add_epi32(turn, all(9999)), 3518437209, 45);
        put_two(f->places.words + STEP + i, _mm512_add_epi32(bin, all(ANGLES)),
                _mm512_add_epi32(bin_harm, _mm512_add_epi32(its, all(HARM))));
    }
    merge_angles(&f->sums.angles, &every);
    merge_angles(&f->sums.kind[0], &failing);
    merge_angles(&f->sums.kind[1], &too_long);
    merge_angles(&f->sums.kind[2], &negative);
}

static void add_judged(ntp__sums *sums, ntp__far_counts *far, far_texels *f)
{
    note_levels(f);
    add_lengths(&f->sums.lengths[0], f, f->z);
    add_errors(f);
    f->sums.error_zz =
        _mm512_add_epi32(f->sums.error_zz, add_lengths(&f->sums.lengths[1], f, f->blue));
    turn_vectors(f);
    sum_angles(f);
    for (int32_t i = 0; i < f->padding; i++)
        ntp__add_padding_harm(sums, f->harm + f->padded[i], f->turn + f->padded[i], 1);
    sums->texels += (uint32_t) f->n;
    far->used = 1;
    ntp__count_places(sums, far, &f->places, f->n);
}

static void begin(far_texels *f)
{
    f->waiting = 0;
    memset(&f->sums, 0, sizeof f->sums);
    begin_survey(&f->sums.seen);
    for (int32_t k = 0; k < 2; k++)
        f->sums.lengths[k].least = all(INT32_MAX);
}

static void end(ntp__sums *sums, const far_texels *f)
{
    uint64_t following = 0;
    end_angles(&sums->angles.texels, &sums->angles.sum, &sums->angles.max, &f->sums.angles);
    for (int32_t k = 0; k < NTP__HARM_KINDS; k++) {
        ntp__harm_sums *const harm = &sums->harm[k];
        end_angles(&harm->texels, &harm->sum, &harm->max, &f->sums.kind[k]);
    }
    for (int32_t k = NTP__ALL_BINS; k-- > 0;) {
        const uint64_t from = sum_of(&f->sums.errors[k]);
        sums->fit[0].length_error[k] += from - following;
        following = from;
    }
    sums->fit[1].length_error[NTP__PADDING_BIN] += sum_of(&f->sums.error_zz);
    for (int32_t k = 0; k < 2; k++) {
        end_lengths(&sums->fit[k], &f->sums.lengths[k]);
        ntp__merge_max(&sums->fit[k].levels_off_max, greatest_of(&f->sums.most[k]));
    }
}

/* Notes sixteen texels of which those of the mask are to be, or has them wait.  Returns which ones are
 * neighbors. */
static inline __mmask16 judge(far_texels *f, texels t, __mmask16 which)
{
    far_lanes v;
    const __mmask16 near = set_lanes(&v, t) & which, far = which & (__mmask16) ~near;
    if (far == 0xFFFF) {
        note(f, &v);
        return 0;
    }
    append(f->rg + f->waiting, far, t.rg);
    append(f->b + f->waiting, far, t.b);
    f->waiting += count_of(far);
    return near;
}

/* Sixteen of those that wait. */
static inline texels take_waiting(far_texels *f)
{
    const texels t = { load(f->rg), load(f->b) };
    f->waiting -= LANES_512;
    store(f->rg, load(f->rg + LANES_512));
    store(f->b, load(f->b + LANES_512));
    return t;
}

/* Of packed texels, or where there are none, of a block; returns how many are others.  *n becomes how many are done:
 * all of a block, and of more than that those whose others have room. */
static int32_t add_far(ntp__sums *sums, ntp__far_counts *far, ntp__survey *found, ntp__block *block,
                       const uint16_t *rgb, int32_t *n)
{
    enum { SKIPPED = 15 };
    __mmask16 odd[STEP / LANES_512];
    far_texels f;
    int32_t left = 0, i = 0;
    begin(&f);
    /* There is room for all texels of a step as others.  Steps that are too short would gain nothing. */
    for (int32_t room = STEP; i < *n && room >= STEP / 4;) {
        const int32_t last = *n - i < room ? *n : i + room;
        f.n = f.negative = f.too_long = f.padding = 0;
        if (rgb != NULL)
            survey(&f.sums.seen, odd, rgb + (size_t) 3 * i, last - i);
        for (const __mmask16 *is_odd = odd; i < last || f.waiting >= LANES_512;) {
            uint32_t some = 0xFFFF;
            __mmask16 others = 0;
            texels t;
            if (f.waiting >= LANES_512) {
                t = take_waiting(&f);
            } else {
                if (last - i < LANES_512)
                    some = (1U << (last - i)) - 1;
                if (rgb != NULL) {
                    t = take16((const uint8_t *) (rgb + (size_t) 3 * i));
                    others = *is_odd++;
                } else {
                    t.rg = words_of(load(block->c[0] + i), load(block->c[1] + i));
                    t.b = load(block->c[2] + i);
                }
                i += LANES_512;
            }
            others |= judge(&f, t, (__mmask16) some & (__mmask16) ~others);
            if (others == 0)
                continue;
            append(block->c[0] + left, others, _mm512_and_si512(t.rg, all(M)));
            append(block->c[1] + left, others, _mm512_srli_epi32(t.rg, 16));
            append(block->c[2] + left, others, t.b);
            left += count_of(others);
        }
        i = last;
        room = (NTP__BLOCK - left - f.waiting) & -LANES_512;
        if (f.n > 0)
            add_judged(sums, far, &f);
    }
    *n = i;
    for (i = 0; i < f.waiting; i++, left++) {
        block->c[0][left] = f.rg[i] & M;
        block->c[1][left] = (int32_t) ((uint32_t) f.rg[i] >> 16);
        block->c[2][left] = f.b[i];
    }
    if (left < *n)
        end(sums, &f);
    if (rgb != NULL)
        ntp__end_survey_avx512(found, &f.sums.seen);
    far->skip = left > *n - (int32_t) ((uint32_t) *n / 4) ? SKIPPED : 0;
    return left;
}

int32_t ntp__add_far_avx512(ntp__sums *sums, ntp__far_counts *far, ntp__block *block, int32_t n)
{
    if (far->skip > 0) {
        far->skip--;
        return n;
    }
    const int32_t left = add_far(sums, far, NULL, block, NULL, &n);
    end_lanes();
    return left;
}

int32_t ntp__add_far_rgb_avx512(ntp__sums *sums, ntp__far_counts *far, ntp__survey *found,
                                ntp__block *left, const uint16_t *rgb, int32_t *n)
{
    *n = *n < MOST ? *n & -LANES_512 : MOST;
    const int32_t others = add_far(sums, far, found, left, rgb, n);
    end_lanes();
    return others;
}
