/* SPDX-License-Identifier: MIT */
/*
 * direction.h - texels as integer vectors, and integer vectors of any length as levels
 *
 * Resizing, transforming and blending compute with these.
 */
#ifndef NTP_DIRECTION_H
#define NTP_DIRECTION_H

#include "base/int128.h"
#include "base/view.h"
#include "texel/kernels.h"

/*
 * The numerators over M of the vector that texel i of a block holds.  NTP_ENCODING_XY: red and
 * green are pulled if they are too long, and blue is derived, as in a standard texel.
 */
void ntp__texel_vector(int32_t v[3], const ntp__block *block, int32_t i, int32_t m,
                       ntp_encoding encoding);

/* As ntp__pull, where that is seldom: a call in place of its code. */
static inline void ntp__pull_seldom(int32_t *r, int32_t *g, int32_t m)
{
    ntp__block one;
    int32_t v[3];
    one.c[0][0] = *r;
    one.c[1][0] = *g;
    one.c[2][0] = 0;
    ntp__texel_vector(v, &one, 0, m, NTP_ENCODING_XY);
    *r = (v[0] + m) / 2;
    *g = (v[1] + m) / 2;
}

/* Pulls pairs that are too long, whose places among n are those of marks below 0.  As ntp__pull, but many at once. */
void ntp__pull_pairs(int32_t *r, int32_t *g, const int32_t *marks, int32_t n, int32_t m);

/* The vectors of the first n texels of a block. */
void ntp__block_vectors(ntp__vectors *v, const ntp__block *block, int32_t n, int32_t m,
                        ntp_encoding encoding);

/*
 * The levels of the directions of n vectors: those of ntp__direction_levels, but fast.  Where
 * doubt[i] is not 0 the caller asks that function, with exact components.  NTP_ENCODING_XY: b is
 * left alone.  kernels.h says how good the components have to be, and what `exact` means.  False: no
 * doubt[i] is other than 0.
 */
bool ntp__block_directions(ntp__block *out, int32_t *doubt, ntp__vectors *v, int32_t n, int32_t m,
                           ntp_encoding encoding, bool exact);

/* Pulls what is too long and not in doubt, and derives its blue; returns how many. */
uint64_t ntp__pull_directions(ntp__block *out, int32_t *doubt, const ntp__vectors *v, int32_t n,
                              int32_t m, bool zzero);

/*
 * The levels of v / |v|, |components| < 2^125.  r and g are correctly rounded (half up), and pulled
 * if they are then too long.  b is derived from them; in the standard encoding it keeps the sign of
 * z.  NTP_ENCODING_XY: b is left alone.  A vector of length 0 is flat.
 */
void ntp__direction_levels(int32_t c[3], const ntp__i128 v[3], int32_t m, ntp_encoding encoding);

/* The same of whole numbers, as components; false: they do not tell, or are all 0. */
bool ntp__direction_decided(int32_t c[3], const double v[3], int32_t m, ntp_encoding encoding);

/* Halves all three, towards 0, until none has more than these bits. */
void ntp__i128_shorten(ntp__i128 v[3], int32_t bits);

/* floor(a / b + 1/2), held to 0..max; b > 0. */
int32_t ntp__i128_ratio(ntp__i128 a, ntp__i128 b, int32_t max);

/* Writes levels to a view of any type.  Floats are level / 65535, components of vectors
 * (2 level - 65535) / 65535. */
void ntp__store_levels(const ntp_image *view, const ntp__block *block, int32_t x, int32_t y,
                       int32_t n);

/*
 * A strength as numerator / 2^shift.  From 2^-10 on this is exact; below, it is rounded to a
 * multiple of 2^-62.  ntp__strength_of is false unless the strength is finite and at most
 * NTP_MAX_STRENGTH in magnitude.
 */
typedef struct ntp__strength {
    int64_t numerator; /* below 2^53 */
    int32_t shift;     /* 0..62 */
} ntp__strength;

bool ntp__strength_of(ntp__strength *out, double strength);

static inline double ntp__strength_value(const ntp__strength *s)
{
    return (double) s->numerator / (double) ((uint64_t) 1 << s->shift);
}

#endif
