/* SPDX-License-Identifier: MIT */
/*
 * far_avx512.c - adds 16-bit texels that are far from exact, sixteen at a time, with AVX-512
 *
 * As far_avx2.c, which says how neighbors are found and what the angles are, and the numbers are the same.
 * Of groups with neighbors only these are left to others: the rest waits until it makes a group.
 *
 * A level v of red or green is p = v - 32768, or q = -1 - p where that is negative: |X| = 2q + 1, and
 * p(p + 1) = q(q + 1) = -q(-1 - q).  Both factors fit into words, so pmaddwd adds up those of red and green.
 * h = half(u - half), with half = floor(u/2), is -half(half - u) for the same reason.
 */
#include "measure/far_words_tmpl.h"

#include "texel/lengths_avx512_tmpl.h"
#include "texel/packed_avx512_tmpl.h"
#include "texel/survey_avx512_tmpl.h"
#include "texel/turn_avx512_tmpl.h"

#include <stddef.h>
#include <string.h>

enum { STEP = NTP__FAR_STEP, OTHERS = STEP, ALL = 2 * STEP + LANES_512 };

/* Sums of whole blocks: 32 bits of 16 lanes hold those of 256 angles, which are below 2^27.5. */
typedef struct far_lengths {
    __m512i sum, least, greatest, squares, of_padding;
} far_lengths;

typedef struct far_angles {
    __m512i sum, greatest;
    uint32_t texels;
} far_angles;

/* What is found out about up to STEP texels, in planes: long loops would leave room for few steps in
 * flight. */
typedef struct far_texels {
    ntp__far_places places;
    int32_t harm[STEP]; /* which kind, times ONE_HARM */
    int32_t off[STEP];  /* lengths from 1 */
    int32_t blue[STEP];
    /* Vectors and other z for their x and y, which make angles: those of harm; from OTHERS on those of
     * texels below the horizon, and their derived blues, before those that are too long. */
    int32_t xy[ALL], z[ALL], w[ALL], turn[ALL];
    double s2[ALL], d[ALL];
    int32_t n, negative, too_long;
    __mmask16 is_lower[STEP / LANES_512], is_long[STEP / LANES_512], is_padding[STEP / LANES_512];
    int32_t c[3][STEP + LANES_512]; /* those that are too long */
    /* Texels without neighbors that wait for more. */
    int32_t rg[2 * LANES_512], b[2 * LANES_512], waiting;
    struct far_sums {
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

/* What sixteen texels are made of; halves of numerators are rounded down. */
typedef struct far_lanes {
    __m512i rg, b, e;       /* e as in judge_tmpl.h */
    __m512i q, z, up;       /* q of red and green in words; b - K, and its q */
    __m512i sizes, off, zz; /* |X| + |Y|, a - A_M, and e - h */
} far_lanes;

/* Returns which are neighbors. */
static inline __mmask16 set_lanes(far_lanes *v, texels t)
{
    const __m512i ones = all(-1), p = _mm512_xor_si512(t.rg, all((int32_t) 0x80008000));
    const __m512i b = t.b, half = _mm512_srli_epi32(b, 1);
    v->rg = t.rg;
    v->b = b;
    v->q = _mm512_xor_si512(p, _mm512_srai_epi16(p, 15));
    v->z = _mm512_sub_epi32(b, all(K));
    v->up = _mm512_xor_si512(v->z, _mm512_srai_epi32(v->z, 31));
    v->e = _mm512_add_epi32(all(REST_16), _mm512_madd_epi16(v->q, _mm512_xor_si512(v->q, ones)));
    const __m512i sum = _mm512_madd_epi16(v->q, all(0x00010001));
    v->sizes = _mm512_add_epi32(_mm512_add_epi32(sum, sum), all(2));
    const __m512i less = _mm512_madd_epi16(v->up, _mm512_xor_si512(v->up, ones));
    v->off = _mm512_xor_si512(_mm512_add_epi32(v->e, less), ones);
    v->zz = _mm512_add_epi32(v->e, _mm512_madd_epi16(half, _mm512_sub_epi32(half, b)));
    /* -2k <= off < 2k - 6, with 2k = |X| + |Y| + |Z| + 3; from -2k on, as numbers without a sign */
    const __m512i k2 =
        _mm512_add_epi32(_mm512_add_epi32(v->sizes, all(4)), _mm512_add_epi32(v->up, v->up));
    const __mmask16 near = _mm512_cmplt_epu32_mask(
        _mm512_add_epi32(v->off, k2), _mm512_sub_epi32(_mm512_add_epi32(k2, k2), all(6)));
    /* 2 - sizes - half <= e - h < 2 + sizes + b - half */
    const __m512i from =
        _mm512_add_epi32(_mm512_add_epi32(v->zz, v->sizes), _mm512_sub_epi32(half, all(2)));
    return near |
           _mm512_cmplt_epu32_mask(from, _mm512_add_epi32(_mm512_add_epi32(v->sizes, v->sizes), b));
}

static inline __m512i flagged(__m512i key, __mmask16 where, int32_t flag)
{
    return _mm512_mask_or_epi32(key, where, key, all(flag));
}

static inline __mmask16 is_negative(__m512i v)
{
    return _mm512_cmplt_epi32_mask(v, _mm512_setzero_si512());
}

/* Steepness and flags. */
static inline __m512i key_of(const far_lanes *v, __m512i xy, __mmask16 padding)
{
    const int32_t most = (int32_t) ((NTP__FAR_SQUARED * ((double) M * M) - 2) / 4);
    static const _Alignas(64) uint8_t roots[64] = {
        0, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 4, 4, 4, 4, 4, 4,
        4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 6, 6, 6, 6, 6, 6, 6, 6,
        6, 6, 6, 6, 6, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7,
    };
    /* floor(64 xy / A_M), as in close_tmpl.h; the root of 64 and more is not used */
    const __m512i more = _mm512_add_epi32(_mm512_srli_epi32(xy, 15), all(1));
    const __m512i steep = _mm512_srli_epi32(_mm512_add_epi32(xy, more), 24);
    __m512i bin =
        _mm512_permutexvar_epi8(_mm512_min_epu32(steep, all(63)), _mm512_load_si512(roots));
    bin = _mm512_mask_mov_epi32(bin, padding, all(NTP__PADDING_BIN));
    __m512i key = _mm512_slli_epi32(bin, 5);
    key = flagged(key, _mm512_cmpgt_epi32_mask(xy, all(most)), NTP__KEY_FAR);
    key = flagged(key, is_negative(v->e), NTP__KEY_TOO_LONG);
    key = flagged(key, is_negative(v->z), NTP__KEY_NEGATIVE);
    key = flagged(key, is_negative(v->off), NTP__KEY_SHORT);
    return flagged(key, is_negative(v->zz), NTP__KEY_ZZ_LONG);
}

/* Two words for each of sixteen texels. */
static inline void put_two(uint64_t *to, __m512i v, __m512i w)
{
    store(to, _mm512_unpacklo_epi32(v, w));
    store(to + 8, _mm512_unpackhi_epi32(v, w));
}

/* How far blue is from the derived ones, of these roots. */
static inline void note_levels(far_texels *f, const far_lanes *v, __m512i root, __mmask16 longs)
{
    const __mmask16 fine = (__mmask16) ~longs;
    const __m512i off = _mm512_abs_epi32(_mm512_sub_epi32(v->up, root));
    /* as in blue_avx2_tmpl.h */
    const __m512i more = _mm512_sub_epi32(v->e, _mm512_madd_epi16(root, root));
    const __m512i d2 = _mm512_add_epi32(more, more), t2 = _mm512_add_epi32(root, root);
    __m512i blue = _mm512_add_epi32(t2, all(2));
    blue = _mm512_mask_sub_epi32(blue, _mm512_cmpgt_epi32_mask(root, _mm512_add_epi32(d2, all(1))),
                                 blue, all(1));
    blue = _mm512_mask_sub_epi32(blue, _mm512_cmpgt_epi32_mask(_mm512_add_epi32(t2, root), d2),
                                 blue, all(1));
    const __m512i off_zz = _mm512_abs_epi32(_mm512_sub_epi32(v->b, blue));
    f->sums.most[0] = _mm512_mask_max_epi32(f->sums.most[0], fine, f->sums.most[0], off);
    f->sums.most[1] = _mm512_mask_max_epi32(f->sums.most[1], fine, f->sums.most[1], off_zz);
    put_two(f->places.words + f->n,
            _mm512_mask_add_epi32(all(LEVELS + NTP__NO_BLUE), fine, off, all(LEVELS)),
            _mm512_mask_add_epi32(all(LEVELS_ZZ + NTP__NO_BLUE), fine, off_zz, all(LEVELS_ZZ)));
}

/* Notes sixteen texels. */
static inline void note(far_texels *f, const far_lanes *v)
{
    enum { PADDED = M / 2 - (16 * 257 - 128) }; /* above: 16 levels of 8 bit from an end */
    const __m512i xy = _mm512_sub_epi32(all(REST_16), v->e), root = root_of(v->e, true);
    const __m512i least = _mm512_min_epu16(v->q, _mm512_rol_epi32(v->q, 16));
    const __m512i z = _mm512_add_epi32(_mm512_add_epi32(v->z, v->z), all(1));
    const __m512i w = _mm512_add_epi32(_mm512_add_epi32(root, root), all(1));
    const __m512i size = _mm512_add_epi32(_mm512_add_epi32(v->up, v->up), all(1));
    const __mmask16 padding = _mm512_cmpgt_epi32_mask(_mm512_srli_epi32(least, 16), all(PADDED));
    const __mmask16 longs = is_negative(v->e),
                    negative = is_negative(_mm512_add_epi32(v->z, all(1)));
    const __mmask16 lower = negative & (__mmask16) ~longs;
    /* |X| - 2 and |Y| - 2 are too long as well */
    const __mmask16 pair = _mm512_cmplt_epi32_mask(_mm512_add_epi32(v->e, v->sizes), all(2));
    __m512i kind = _mm512_maskz_mov_epi32(pair, all(ONE_HARM));
    kind = _mm512_mask_mov_epi32(kind, negative, all(2 * ONE_HARM));
    kind = _mm512_mask_add_epi32(kind, pair & padding, kind, all(NTP__PADDING_HARM * ONE_HARM));
    note_levels(f, v, root, longs);
    store(f->places.shape + f->n, key_of(v, xy, padding));
    store(f->blue + f->n, v->b);
    store(f->harm + f->n, kind);
    store(f->xy + f->n, xy);
    store(f->z + f->n, z);
    store(f->w + f->n, _mm512_mask_mov_epi32(w, negative, size));
    append(f->xy + OTHERS + f->negative, lower, xy);
    append(f->z + OTHERS + f->negative, lower, z);
    append(f->w + OTHERS + f->negative, lower, w);
    append(f->c[0] + f->too_long, longs, _mm512_and_si512(v->rg, all(M)));
    append(f->c[1] + f->too_long, longs, _mm512_srli_epi32(v->rg, 16));
    append(f->c[2] + f->too_long, longs, v->b);
    f->is_lower[group_of(f->n)] = lower;
    f->is_long[group_of(f->n)] = longs;
    f->is_padding[group_of(f->n)] = padding;
    f->negative += count_of(lower);
    f->too_long += count_of(longs);
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
    int32_t whole[STEP];
    float rest[STEP], over[STEP];
    far_lengths s = *sums;
    __m512i padded = _mm512_setzero_si512();
    roots_of(whole, rest, over, f->xy, z, f->n);
    for (int32_t i = 0; i < f->n; i += LANES_512) {
        const __m512i length = lengths_of(load(whole + i), _mm512_loadu_ps(rest + i),
                                          _mm512_loadu_ps(over + i), f->xy + i, z + i);
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
    const uint64_t squares = (uint64_t) _mm512_reduce_add_epi64(s->squares);
    const uint64_t of_padding = (uint64_t) _mm512_reduce_add_epi64(s->of_padding);
    const __m512i inverted = _mm512_xor_si512(s->least, all(-1));
    fit->length_sum += sum_of(&s->sum);
    fit->length_error2[0] += squares - of_padding;
    fit->length_error2[1] += of_padding;
    ntp__merge_max(&fit->length_max, greatest_of(&s->greatest));
    ntp__merge_max(&fit->length_inverted_min, greatest_of(&inverted));
}

ONE_COPY static void find_turns(int32_t *angle, const double *s2, const double *d, int32_t n)
{
    double u[STEP + 8], base[STEP + 8];
    turns_of(angle, u, base, s2, d, n);
}

/* All angles. */
static void turn_vectors(far_texels *f)
{
    const __m512i zero = _mm512_setzero_si512();
    const int32_t longs = OTHERS + f->negative;
    store(f->xy + longs, zero);
    store(f->z + longs, zero);
    store(f->w + longs, zero);
    for (int32_t k = 0; k < 3; k++)
        store(f->c[k] + f->too_long, zero);
    flat_products(f->s2, f->d, f->xy, f->z, f->w, f->n);
    flat_products(f->s2 + OTHERS, f->d + OTHERS, f->xy + OTHERS, f->z + OTHERS, f->w + OTHERS,
                  f->negative);
    ntp__long_products_avx2(f->s2 + longs, f->d + longs, f->c[0], f->c[1], f->c[2], f->too_long);
    find_turns(f->turn, f->s2, f->d, f->n);
    find_turns(f->turn + OTHERS, f->s2 + OTHERS, f->d + OTHERS, f->negative + f->too_long);
}

static inline void add_angles(far_angles *sums, __m512i angle, __mmask16 which)
{
    sums->sum = _mm512_mask_add_epi32(sums->sum, which, sums->sum, angle);
    sums->greatest = _mm512_mask_max_epi32(sums->greatest, which, sums->greatest, angle);
    sums->texels += (uint32_t) count_of(which);
}

static void end_angles(uint64_t *count, uint64_t *sum, uint64_t *max, const far_angles *sums)
{
    const uint32_t most = greatest_of(&sums->greatest);
    *count += sums->texels;
    *sum += sum_of(&sums->sum);
    *max = most > *max ? most : *max;
}

/* v / d of numbers below 2^28, where `by` is 2^shift / d, rounded up: as compilers have it. */
static inline __m512i divided(__m512i v, uint32_t by, unsigned shift)
{
    const __m512i factor = all((int32_t) by);
    const __m512i even = _mm512_srli_epi64(_mm512_mul_epu32(v, factor), shift);
    const __m512i odd = _mm512_mul_epu32(_mm512_srli_epi64(v, 32), factor);
    return _mm512_or_si512(even, _mm512_slli_epi64(_mm512_srli_epi64(odd, shift), 32));
}

/* Sums angles, and makes words of them. */
static void sum_angles(ntp__sums *sums, far_texels *f)
{
    const int32_t *lower = f->turn + OTHERS, *longer = lower + f->negative;
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
        add_angles(&f->sums.angles, angle, 0xFFFF);
        UNROLLED
        for (int32_t k = 0; k < NTP__HARM_KINDS; k++)
            add_angles(&f->sums.kind[k], turn, _mm512_cmpeq_epi32_mask(its, all(k * ONE_HARM)));
        store(f->turn + i, turn);
        const __mmask16 padding =
            _mm512_cmpgt_epi32_mask(its, all((NTP__HARM_KINDS - 1) * ONE_HARM));
        if (padding != 0)
            ntp__add_padding_harm(sums, f->harm + i, f->turn + i, padding);
        const __m512i bin = divided(_mm512_add_epi32(angle, all(500)), 274877907, 38);
        const __m512i bin_harm = divided(_mm512_add_epi32(turn, all(9999)), 3518437209, 45);
        put_two(f->places.words + STEP + i, _mm512_add_epi32(bin, all(ANGLES)),
                _mm512_add_epi32(bin_harm, _mm512_add_epi32(its, all(HARM))));
    }
}

static void add_judged(ntp__sums *sums, ntp__far_counts *far, far_texels *f)
{
    add_lengths(&f->sums.lengths[0], f, f->z);
    add_errors(f);
    f->sums.error_zz =
        _mm512_add_epi32(f->sums.error_zz, add_lengths(&f->sums.lengths[1], f, f->blue));
    turn_vectors(f);
    sum_angles(sums, f);
    sums->texels += (uint32_t) f->n;
    far->used = 1;
    ntp__count_places(sums, far, &f->places, f->n);
}

static void begin(far_texels *f)
{
    f->waiting = 0;
    memset(&f->sums, 0, sizeof f->sums);
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
ONE_COPY static __mmask16 judge(far_texels *f, const texels *t, __mmask16 which)
{
    far_lanes v;
    const __mmask16 near = set_lanes(&v, *t) & which, far = which & (__mmask16) ~near;
    if (far == 0xFFFF) {
        note(f, &v);
        return 0;
    }
    append(f->rg + f->waiting, far, t->rg);
    append(f->b + f->waiting, far, t->b);
    f->waiting += count_of(far);
    return near;
}

/* Notes those that wait, if they are sixteen. */
static void end_wait(far_texels *f)
{
    const texels t = { load(f->rg), load(f->b) };
    if (f->waiting < LANES_512)
        return;
    f->waiting -= LANES_512;
    store(f->rg, load(f->rg + LANES_512));
    store(f->b, load(f->b + LANES_512));
    judge(f, &t, 0xFFFF);
}

/* Of packed texels, or where there are none, of a block; where any are odd, these are others. */
static int32_t add_far(ntp__sums *sums, ntp__far_counts *far, ntp__block *block,
                       const uint16_t *rgb, const __mmask16 *odd, int32_t n)
{
    enum { SKIPPED = 15 };
    far_texels f;
    int32_t left = 0;
    begin(&f);
    for (int32_t i = 0; i < n;) {
        f.n = f.negative = f.too_long = 0;
        for (const int32_t last = i + STEP; i < n && i < last; i += LANES_512) {
            const uint32_t some = n - i < LANES_512 ? (1U << (n - i)) - 1 : 0xFFFF;
            __mmask16 others = 0;
            texels t;
            if (rgb != NULL) {
                t = take16((const uint8_t *) (rgb + (size_t) 3 * i));
                others = odd[group_of(i)];
            } else {
                const __m512i g = load(block->c[1] + i);
                t.rg = _mm512_or_si512(load(block->c[0] + i), _mm512_slli_epi32(g, 16));
                t.b = load(block->c[2] + i);
            }
            others |= judge(&f, &t, (__mmask16) some & (__mmask16) ~others);
            if (others == 0)
                continue;
            append(block->c[0] + left, others, _mm512_and_si512(t.rg, all(M)));
            append(block->c[1] + left, others, _mm512_srli_epi32(t.rg, 16));
            append(block->c[2] + left, others, t.b);
            left += count_of(others);
            end_wait(&f);
        }
        if (f.n > 0)
            add_judged(sums, far, &f);
    }
    for (int32_t i = 0; i < f.waiting; i++, left++) {
        block->c[0][left] = f.rg[i] & M;
        block->c[1][left] = (int32_t) ((uint32_t) f.rg[i] >> 16);
        block->c[2][left] = f.b[i];
    }
    if (left < n)
        end(sums, &f);
    far->skip = left > n - (int32_t) ((uint32_t) n / 4) ? SKIPPED : 0;
    return left;
}

int32_t ntp__add_far_avx512(ntp__sums *sums, ntp__far_counts *far, ntp__block *block, int32_t n)
{
    if (far->skip > 0) {
        far->skip--;
        return n;
    }
    return add_far(sums, far, block, NULL, NULL, n);
}

int32_t ntp__add_far_rgb_avx512(ntp__sums *sums, ntp__far_counts *far, ntp__survey *found,
                                ntp__block *left, const uint16_t *rgb, int32_t n)
{
    __mmask16 odd[NTP__BLOCK / LANES_512];
    survey(found, odd, rgb, n);
    found->odd = 0;
    return add_far(sums, far, left, rgb, odd, n);
}
