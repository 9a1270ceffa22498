/* SPDX-License-Identifier: MIT */
/*
 * far_avx2.c - adds 16-bit texels that are far from exact, eight at a time, with AVX2
 *
 * Where none of eight texels is a neighbor, none is rounded, exact or mirrored either, so a few
 * comparisons of whole numbers make all the flags.  Lengths and angles follow (lengths_avx2_tmpl.h,
 * turn_avx2_tmpl.h).  The angle of harm is that to the derived blue, or where z is negative that to the
 * vector with the other sign of z.  Texels with a negative z have another one, to the derived blue; and
 * pairs that are too long have to be pulled before.  Lists of these make whole lanes.
 *
 * Notation is that of judge_tmpl.h, with X = 2r - M.  There, neighbors are
 *     standard: -2k <= a - A_M < 2k - 6;
 *     Z-zero: floor((u - 1)^2/4) <= e_in and e_out < floor((u^2 + 2u + 2)/4).
 * With v = floor(u/2) and h = floor(u^2/4) = v(u - v) these are h - v and h + u - v.
 */
#include "measure/far_words_tmpl.h"

#include "base/inlining.h"
#include "base/lanes_avx2.h"
#include "texel/blue_avx2_tmpl.h"
#include "texel/lengths_avx2_tmpl.h"
#include "texel/turn_avx2_tmpl.h"

#include <stddef.h>
#include <string.h>

enum { STEP = NTP__FAR_STEP / 2, ROOM = STEP + 8, OTHERS = STEP, ALL = 2 * STEP + 8 };

/* What is found out about up to STEP texels, in planes: long loops would leave room for few steps in
 * flight. */
typedef struct far_texels {
    ntp__far_places places;
    int32_t key[STEP], off[STEP];    /* lengths from 1 */
    int32_t harm[STEP];              /* which kind, times ONE_HARM */
    int32_t blue[STEP], angle[STEP]; /* to the clean vector */
    /* Vectors and other z for their x and y, which make angles: those of harm; from OTHERS on those of
     * texels below the horizon, and their derived blues. */
    int32_t xy[ALL], z[ALL], w[ALL], turn[ALL];
    double s2[ALL], d[ALL], u[ROOM], base[ROOM];
    int32_t n;
    /* Which texels are below the horizon; which ones are too long, and these. */
    int32_t at[ROOM], at_long[ROOM], c[3][ROOM];
    int32_t negative, too_long;
} far_texels;

/* Sums of eight lanes of whole blocks; squares are sums of four. */
typedef struct far_lengths {
    __m256i sum, least, greatest, squares, of_padding;
} far_lengths;

static ALWAYS_INLINE __m256i eight(int32_t v)
{
    return _mm256_set1_epi32(v);
}

static ALWAYS_INLINE __m256i marked(__m256i mask, int32_t bits)
{
    return _mm256_and_si256(mask, eight(bits));
}

static ALWAYS_INLINE int mask_of(__m256i v)
{
    return _mm256_movemask_ps(_mm256_castsi256_ps(v));
}

/* Of four numbers of 64 bits. */
static ALWAYS_INLINE uint64_t sum_of_wide(__m256i v)
{
    const __m128i two = _mm_add_epi64(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    return (uint64_t) _mm_cvtsi128_si64(_mm_add_epi64(two, _mm_unpackhi_epi64(two, two)));
}

ONE_COPY static uint64_t sum_of(__m256i v)
{
    return sum_of_wide(_mm256_add_epi64(_mm256_srli_epi64(v, 32),
                                        _mm256_and_si256(v, _mm256_set1_epi64x(UINT32_MAX))));
}

ONE_COPY static uint32_t greatest_of(__m256i v)
{
    const __m128i four = _mm_max_epu32(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
    const __m128i two = _mm_max_epu32(four, _mm_shuffle_epi32(four, _MM_SHUFFLE(1, 0, 3, 2)));
    return (uint32_t) _mm_cvtsi128_si32(_mm_max_epu32(two, _mm_srli_epi64(two, 32)));
}

/* Which bytes of four numbers go to the front, for each mask of four. */
static const uint8_t FRONT[16][16] = {
#define AT(i) 4 * (i), 4 * (i) + 1, 4 * (i) + 2, 4 * (i) + 3
    { AT(0) },
    { AT(0) },
    { AT(1) },
    { AT(0), AT(1) },
    { AT(2) },
    { AT(0), AT(2) },
    { AT(1), AT(2) },
    { AT(0), AT(1), AT(2) },
    { AT(3) },
    { AT(0), AT(3) },
    { AT(1), AT(3) },
    { AT(0), AT(1), AT(3) },
    { AT(2), AT(3) },
    { AT(0), AT(2), AT(3) },
    { AT(1), AT(2), AT(3) },
    { AT(0), AT(1), AT(2), AT(3) },
#undef AT
};

/* Appends the lanes of the mask to lists that are n long; returns how long they are then. */
static ALWAYS_INLINE int32_t append(int32_t *const to[4], const __m256i from[4], int32_t n,
                                    int mask)
{
    UNROLLED
    for (int half = 0; half < 2; half++, mask >>= 4) {
        const __m128i which = _mm_load_si128((const __m128i *) (const void *) FRONT[mask & 15]);
        UNROLLED
        for (int i = 0; i < 4; i++) {
            const __m128i four =
                half ? _mm256_extracti128_si256(from[i], 1) : _mm256_castsi256_si128(from[i]);
            _mm_storeu_si128((__m128i *) (void *) (to[i] + n), _mm_shuffle_epi8(four, which));
        }
        n += __builtin_popcount((unsigned) mask & 15U);
    }
    return n;
}

/* What eight texels are made of. */
typedef struct far_lanes {
    __m256i z,
        w; /* blue and derived blue as numerators; w is any number where pairs are too long */
    __m256i xy, e, longs;      /* as in judge_tmpl.h; where e is negative */
    __m256i sizes, dz, off, h; /* |X| + |Y|, |Z|, a - A_M, h */
    __m256i padding, below;    /* below the horizon by more than half a level */
} far_lanes;

/* Returns whether any is a neighbor. */
static inline bool set_lanes(far_lanes *v, __m256i r, __m256i g, __m256i b)
{
    enum { PADDED = M - 2 * (16 * 257 - 128) }; /* above: 16 levels of 8 bit from an end */
    const __m256i one = eight(1), m = eight(M);
    const __m256i dx = _mm256_abs_epi32(_mm256_sub_epi32(_mm256_add_epi32(r, r), m));
    const __m256i dy = _mm256_abs_epi32(_mm256_sub_epi32(_mm256_add_epi32(g, g), m));
    const __m256i z = _mm256_sub_epi32(b, eight(K)), half = _mm256_srli_epi32(b, 1);
    v->z = _mm256_sub_epi32(_mm256_add_epi32(b, b), m);
    v->dz = _mm256_abs_epi32(v->z);
    v->below = _mm256_cmpgt_epi32(eight(-1), v->z);
    v->sizes = _mm256_add_epi32(dx, dy);
    v->padding = _mm256_cmpgt_epi32(_mm256_min_epi32(dx, dy), eight(PADDED));
    v->e = rest_of(_mm256_or_si256(r, _mm256_slli_epi32(g, 16)), true);
    v->longs = _mm256_srai_epi32(v->e, 31);
    v->xy = _mm256_sub_epi32(eight(REST_16), v->e);
    const __m256i zz = _mm256_mullo_epi32(z, _mm256_add_epi32(z, one));
    v->off = _mm256_sub_epi32(_mm256_sub_epi32(zz, one), v->e);
    /* 2k = |X| + |Y| + |Z| + 3 */
    const __m256i k2 = _mm256_add_epi32(_mm256_add_epi32(v->sizes, v->dz), eight(3));
    const __m256i in = _mm256_cmpgt_epi32(k2, _mm256_add_epi32(v->off, eight(6)));
    const __m256i near =
        _mm256_and_si256(in, _mm256_cmpgt_epi32(v->off, _mm256_xor_si256(k2, eight(-1))));
    /* e_in = e + |X| + |Y| - 2, and e_out = e - |X| - |Y| - 2 */
    const __m256i rest = _mm256_sub_epi32(b, half);
    v->h = _mm256_mullo_epi32(half, rest);
    const __m256i e_in = _mm256_sub_epi32(_mm256_add_epi32(v->e, v->sizes), one);
    const __m256i e_out = _mm256_sub_epi32(_mm256_sub_epi32(v->e, v->sizes), eight(2));
    const __m256i near_zz =
        _mm256_and_si256(_mm256_cmpgt_epi32(e_in, _mm256_sub_epi32(v->h, half)),
                         _mm256_cmpgt_epi32(_mm256_add_epi32(v->h, rest), e_out));
    return mask_of(_mm256_or_si256(near, near_zz)) != 0;
}

/* Steepness and flags. */
static inline __m256i key_of(const far_lanes *v)
{
    const int32_t most = (int32_t) ((NTP__FAR_SQUARED * ((double) M * M) - 2) / 4);
    /* floor(64 xy / A_M), as in close_tmpl.h; the root of 64 and more is not used */
    const __m256i more = _mm256_add_epi32(_mm256_srli_epi32(v->xy, 15), eight(1));
    const __m256i steep = _mm256_srli_epi32(_mm256_add_epi32(v->xy, more), 24);
    const __m256i root = _mm256_cvttps_epi32(_mm256_sqrt_ps(_mm256_cvtepi32_ps(steep)));
    __m256i bin = _mm256_min_epi32(root, eight(NTP__STEEPNESS_BINS - 1));
    bin = _mm256_blendv_epi8(bin, eight(NTP__PADDING_BIN), v->padding);
    __m256i key = _mm256_slli_epi32(bin, 5);
    key = _mm256_or_si256(key, marked(_mm256_cmpgt_epi32(v->xy, eight(most)), NTP__KEY_FAR));
    /* A_M is one more than the e of xy = 0 */
    key =
        _mm256_or_si256(key, marked(_mm256_cmpgt_epi32(v->xy, eight(REST_16)), NTP__KEY_TOO_LONG));
    key = _mm256_or_si256(key, marked(_mm256_srai_epi32(v->z, 31), NTP__KEY_NEGATIVE));
    key = _mm256_or_si256(key, marked(_mm256_srai_epi32(v->off, 31), NTP__KEY_SHORT));
    return _mm256_or_si256(key, marked(_mm256_cmpgt_epi32(v->h, v->e), NTP__KEY_ZZ_LONG));
}

static ALWAYS_INLINE __m256i add_squares(__m256i sums, __m256i v)
{
    const __m256i odd = _mm256_srli_epi64(v, 32);
    return _mm256_add_epi64(sums,
                            _mm256_add_epi64(_mm256_mul_epu32(v, v), _mm256_mul_epu32(odd, odd)));
}

static void end_lengths(ntp__fit_sums *fit, const far_lengths *s)
{
    const uint64_t squares = sum_of_wide(s->squares), of_padding = sum_of_wide(s->of_padding);
    fit->length_sum += sum_of(s->sum);
    fit->length_error2[0] += squares - of_padding;
    fit->length_error2[1] += of_padding;
    ntp__merge_max(&fit->length_max, greatest_of(s->greatest));
    ntp__merge_max(&fit->length_inverted_min, greatest_of(_mm256_xor_si256(s->least, eight(-1))));
}

/* Notes bins of lengths, and sums these and their distances from 1.  Returns the sum of those of padding. */
ONE_COPY static uint64_t add_lengths(ntp__fit_sums *fit, far_texels *f, int32_t doubled,
                                     int32_t less)
{
    const __m256i zero = _mm256_setzero_si256();
    far_lengths s = { zero, eight(INT32_MAX), zero, zero, zero };
    __m256i padded = zero;
    float rest[STEP], over[STEP];
    lengths_of(f->off, rest, over, f->xy, f->blue, f->n, doubled, less);
    for (int32_t i = 0; i < f->n; i += 8) {
        const __m256i length = load_eight(f->off + i), key = load_eight(f->key + i);
        const __m256i padding =
            _mm256_cmpgt_epi32(key, eight(NTP__PADDING_BIN * NTP__KEY_STEEP - 1));
        const __m256i from_1 = _mm256_abs_epi32(_mm256_sub_epi32(length, eight(NTP__LENGTH_ONE)));
        const __m256i of_padding = _mm256_and_si256(from_1, padding);
        const __m256i shape = _mm256_slli_epi32(load_eight((int32_t *) f->places.shape + i), 8);
        s.sum = _mm256_add_epi32(s.sum, length);
        s.least = _mm256_min_epi32(s.least, length);
        s.greatest = _mm256_max_epi32(s.greatest, length);
        s.squares = add_squares(s.squares, from_1);
        s.of_padding = add_squares(s.of_padding, of_padding);
        padded = _mm256_add_epi32(padded, of_padding);
        store_eight(f->off + i, from_1);
        store_eight(f->places.shape + i,
                    _mm256_or_si256(shape, _mm256_srli_epi32(length, LENGTH_BIN)));
    }
    end_lengths(fit, &s);
    return sum_of(padded);
}

/* Adds distances of lengths from 1 by steepness: of every second texel apart, as sums wait for
 * each other. */
static void add_errors(ntp__fit_sums *fit, const far_texels *f)
{
    uint32_t errors[2][NTP__ALL_BINS] = { { 0 } };
    for (int32_t i = 0; i < f->n; i += 2) {
        errors[0][(uint32_t) f->key[i] / NTP__KEY_STEEP] += (uint32_t) f->off[i];
        errors[1][(uint32_t) f->key[i + 1] / NTP__KEY_STEEP] += (uint32_t) f->off[i + 1];
    }
    for (int32_t k = 0; k < NTP__ALL_BINS; k++)
        fit->length_error[k] += errors[0][k] + errors[1][k];
}

static inline void note_harm(far_texels *f, const far_lanes *v)
{
    /* |X| - 2 and |Y| - 2 are too long as well */
    const __m256i inner = _mm256_sub_epi32(v->xy, v->sizes);
    const __m256i pair = _mm256_cmpgt_epi32(_mm256_add_epi32(inner, eight(2)), eight(REST_16));
    const __m256i negative = v->below;
    __m256i kind = marked(pair, ONE_HARM);
    kind = _mm256_blendv_epi8(kind, eight(2 * ONE_HARM), negative);
    kind = _mm256_add_epi32(
        kind, marked(_mm256_and_si256(pair, v->padding), NTP__PADDING_HARM * ONE_HARM));
    store_eight(f->harm + f->n, kind);
    store_eight(f->xy + f->n, v->xy);
    store_eight(f->z + f->n, v->z);
    store_eight(f->w + f->n, _mm256_blendv_epi8(v->w, v->dz, negative));
}

static inline void note_lists(far_texels *f, const far_lanes *v, __m256i r, __m256i g, __m256i b)
{
    const __m256i at = _mm256_add_epi32(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), eight(f->n));
    const int below = mask_of(_mm256_andnot_si256(v->longs, v->below)), longs = mask_of(v->e);
    const __m256i lower[4] = { at, v->xy, v->z, v->w }, longer[4] = { at, r, g, b };
    int32_t *const to_lower[4] = { f->at, f->xy + OTHERS, f->z + OTHERS, f->w + OTHERS };
    int32_t *const to_longer[4] = { f->at_long, f->c[0], f->c[1], f->c[2] };
    f->negative = append(to_lower, lower, f->negative, below);
    f->too_long = append(to_longer, longer, f->too_long, longs);
}

/* Two words for each of eight texels. */
static ALWAYS_INLINE void put_two(uint64_t *to, __m256i v, __m256i w)
{
    store_eight(to, _mm256_unpacklo_epi32(v, w));
    store_eight(to + 4, _mm256_unpackhi_epi32(v, w));
}

/* The blues that are derived, and how far blue is from them; without these where pairs are too long. */
static inline void note_levels(far_texels *f, __m256i most[2], far_lanes *v, __m256i b)
{
    const __m256i root = root_of(v->e, true), none = eight(NTP__NO_BLUE);
    const __m256i off = _mm256_abs_epi32(_mm256_sub_epi32(_mm256_srli_epi32(v->dz, 1), root));
    const __m256i off_zz = _mm256_abs_epi32(_mm256_sub_epi32(b, blue_of(v->e, root, true, true)));
    v->w = _mm256_add_epi32(_mm256_add_epi32(root, root), eight(1));
    store_eight(f->blue + f->n, b);
    most[0] = _mm256_max_epi32(most[0], _mm256_andnot_si256(v->longs, off));
    most[1] = _mm256_max_epi32(most[1], _mm256_andnot_si256(v->longs, off_zz));
    put_two(f->places.words + f->n,
            _mm256_add_epi32(_mm256_blendv_epi8(off, none, v->longs), eight(LEVELS)),
            _mm256_add_epi32(_mm256_blendv_epi8(off_zz, none, v->longs), eight(LEVELS_ZZ)));
}

/* Texels from `from` on, whole lanes, of which those that are left to others go to `left` and on.
 * Returns where these end. */
static int32_t judge_some(ntp__sums *sums, far_texels *f, ntp__block *block, int32_t from,
                          int32_t n, int32_t left)
{
    __m256i most[2] = { _mm256_setzero_si256(), _mm256_setzero_si256() };
    for (int32_t i = from; i < n; i += 8) {
        const __m256i r = load_eight(block->c[0] + i), g = load_eight(block->c[1] + i),
                      b = load_eight(block->c[2] + i);
        far_lanes v;
        if (set_lanes(&v, r, g, b)) {
            store_eight(block->c[0] + left, r);
            store_eight(block->c[1] + left, g);
            store_eight(block->c[2] + left, b);
            left += 8;
            continue;
        }
        note_levels(f, most, &v, b);
        const __m256i key = key_of(&v);
        store_eight(f->key + f->n, key);
        store_eight(f->places.shape + f->n, key);
        note_harm(f, &v);
        note_lists(f, &v, r, g, b);
        f->n += 8;
    }
    for (int k = 0; k < 2; k++)
        ntp__merge_max(&sums->fit[k].levels_off_max, greatest_of(most[k]));
    return left;
}

void ntp__long_products_avx2(double *s2, double *d, const int32_t *r, const int32_t *g,
                             const int32_t *b, int32_t n)
{
    int32_t x[ROOM], y[ROOM];
    long_products(s2, d, x, y, r, g, b, n);
    end_lanes();
}

/* All angles. */
static void turn_vectors(far_texels *f)
{
    const __m256i zero = _mm256_setzero_si256();
    const int32_t longs = OTHERS + f->negative;
    store_eight(f->xy + longs, zero);
    store_eight(f->z + longs, zero);
    store_eight(f->w + longs, zero);
    for (int k = 0; k < 3; k++)
        store_eight(f->c[k] + f->too_long, zero);
    flat_products(f->s2, f->d, f->xy, f->z, f->w, f->n);
    flat_products(f->s2 + OTHERS, f->d + OTHERS, f->xy + OTHERS, f->z + OTHERS, f->w + OTHERS,
                  f->negative);
    ntp__long_products_avx2(f->s2 + longs, f->d + longs, f->c[0], f->c[1], f->c[2], f->too_long);
    turns_of(f->turn, f->u, f->base, f->s2, f->d, f->n);
    turns_of(f->turn + OTHERS, f->u, f->base, f->s2 + OTHERS, f->d + OTHERS,
             f->negative + f->too_long);
    memcpy(f->angle, f->turn, (size_t) f->n * sizeof f->angle[0]);
    for (int32_t i = 0; i < f->negative; i++)
        f->angle[f->at[i]] = f->turn[OTHERS + i];
    for (int32_t i = 0; i < f->too_long; i++) {
        const int32_t at = f->at_long[i], turn = f->turn[at], angle = f->turn[longs + i];
        f->angle[at] = angle;
        f->turn[at] = f->z[at] < -1 ? turn : angle;
    }
}

/* Sums and extremes of angles of one kind. */
typedef struct angles_of_kind {
    __m256i sum, greatest, texels;
} angles_of_kind;

static ALWAYS_INLINE void add_kind(angles_of_kind *k, __m256i angle, __m256i mask)
{
    const __m256i its = _mm256_and_si256(angle, mask);
    k->sum = _mm256_add_epi32(k->sum, its);
    k->greatest = _mm256_max_epi32(k->greatest, its);
    k->texels = _mm256_sub_epi32(k->texels, mask);
}

ONE_COPY static void end_kind(uint64_t *texels, uint64_t *sum, uint64_t *max,
                              const angles_of_kind *k)
{
    const uint32_t most = greatest_of(k->greatest);
    *texels += sum_of(k->texels);
    *sum += sum_of(k->sum);
    *max = most > *max ? most : *max;
}

/* v / d of eight numbers below 2^28, where `by` is 2^shift / d, rounded up: as compilers have it. */
static ALWAYS_INLINE __m256i divided(__m256i v, uint32_t by, int shift)
{
    const __m256i factor = _mm256_set1_epi32((int32_t) by);
    const __m256i even = _mm256_srli_epi64(_mm256_mul_epu32(v, factor), shift);
    const __m256i odd = _mm256_mul_epu32(_mm256_srli_epi64(v, 32), factor);
    return _mm256_or_si256(even, _mm256_slli_epi64(_mm256_srli_epi64(odd, shift), 32));
}

/* Sums angles, and makes words of them.  They are below 2^27.5, so 32 bits hold the sums of STEP texels in
 * eight lanes. */
static void sum_angles(ntp__sums *sums, far_texels *f)
{
    const __m256i zero = _mm256_setzero_si256();
    const angles_of_kind none = { zero, zero, zero };
    angles_of_kind all = none, kind[NTP__HARM_KINDS] = { none, none, none };
    for (int32_t i = 0; i < f->n; i += 8) {
        const __m256i first = load_eight(f->turn + i), its = load_eight(f->harm + i);
        const __m256i angle = load_eight(f->angle + i);
        add_kind(&all, angle, eight(-1));
        UNROLLED
        for (int k = 0; k < NTP__HARM_KINDS; k++)
            add_kind(&kind[k], first, _mm256_cmpeq_epi32(its, eight(k * ONE_HARM)));
        /* Padding is seldom. */
        ntp__add_padding_harm(
            sums, f->harm + i, f->turn + i,
            (uint32_t) mask_of(_mm256_cmpgt_epi32(its, eight((NTP__HARM_KINDS - 1) * ONE_HARM))));
        const __m256i bin = divided(_mm256_add_epi32(angle, eight(500)), 274877907, 38);
        const __m256i bin_harm = divided(_mm256_add_epi32(first, eight(9999)), 3518437209, 45);
        const __m256i base = _mm256_add_epi32(its, eight(HARM));
        put_two(f->places.words + NTP__FAR_STEP + i, _mm256_add_epi32(bin, eight(ANGLES)),
                _mm256_add_epi32(bin_harm, base));
    }
    end_kind(&sums->angles.texels, &sums->angles.sum, &sums->angles.max, &all);
    for (int k = 0; k < NTP__HARM_KINDS; k++) {
        ntp__harm_sums *const harm = &sums->harm[k];
        end_kind(&harm->texels, &harm->sum, &harm->max, &kind[k]);
    }
}

static void add_judged(ntp__sums *sums, ntp__far_counts *far, far_texels *f)
{
    ntp__fit_sums *const std = &sums->fit[0], *const zz = &sums->fit[1];
    add_lengths(std, f, -1, M);
    add_errors(std, f);
    zz->length_error[NTP__PADDING_BIN] += add_lengths(zz, f, 0, 0);
    turn_vectors(f);
    sum_angles(sums, f);
    sums->texels += (uint32_t) f->n;
    ntp__count_places(sums, far, &f->places, f->n);
}

int32_t ntp__add_far_avx2(ntp__sums *sums, ntp__far_counts *far, ntp__block *block, int32_t n)
{
    enum { SKIPPED = 15 };
    far_texels f;
    int32_t left = 0;
    if (far->skip > 0) {
        far->skip--;
        return n;
    }
    for (int32_t from = 0; from + 8 <= n; from += STEP) {
        f.n = f.negative = f.too_long = 0;
        left = judge_some(sums, &f, block, from, from + STEP < n ? from + STEP : n & -8, left);
        if (f.n > 0)
            add_judged(sums, far, &f);
    }
    for (int32_t i = n & -8; i < n; i++, left++) {
        for (int k = 0; k < 3; k++)
            block->c[k][left] = block->c[k][i];
    }
    far->skip = left > n - n / 4 ? SKIPPED : 0;
    end_lanes();
    return left;
}
