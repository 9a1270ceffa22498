/* SPDX-License-Identifier: MIT */
/*
 * level.h - the exact arithmetic on the levels of one texel
 *
 * This room is the arithmetic of one normal, or of a run of them.
 *   level.h, .c         derives blue, pulls onto the disc, judges and repairs one texel
 *   kernels.h, .c       the same for runs of texels, fast, with the files that end in _tmpl.h,
 *                       root30.h, pick_kernels.c and, for AVX-512, kernels_avx512.h, .c,
 *                       cells_avx512.c, exact16_avx512.c
 *   turn_avx512.h, .c   angles between vectors and clean ones, with AVX-512
 *   judged.h            what the kernels find out beyond the flags of ntp_validate
 *   cells.h             where colors of 8 bit are counted
 *   close.h             where texels of 16 bit are counted that are nearly exact
 *   unused.h, .c        which texels hold no normal
 *   angle.h, .c         angles between vectors, and sums of angles
 *   direction.h, .c     integer vectors of any length to levels
 *   float_vector.h, .c  float vectors to levels
 *   srgb.h              sRGB levels as linear light
 *
 * The integers in this file define what is right; the kernels give the same bytes.  X = 2r - M and
 * Y = 2g - M are odd, so their squares are 1 mod 8 and S = M*M - X*X - Y*Y is 7 mod 8: never a
 * square.  Hence no rounding below meets a tie.  docs/arithmetic.md has the proofs.
 */
#ifndef NTP_LEVEL_H
#define NTP_LEVEL_H

#include "libntp.h"

#include <math.h>
#include <stdbool.h>

/*
 * floor(sqrt(n)), exact, of n < 2^52, which is a double.  Its root is at most k - 1/(2k) where n < k*k.  As
 * k <= 2^26, that is not above k - 2^-27, which is a double too; so no root is rounded up to k.
 */
static inline uint32_t ntp__isqrt(uint64_t n)
{
    return (uint32_t) sqrt((double) (int64_t) n);
}

static inline int32_t ntp__abs(int32_t v)
{
    return v < 0 ? -v : v;
}

static inline int64_t ntp__sq(int64_t v)
{
    return v * v;
}

/* Odd numerator of a level. */
static inline int32_t ntp__num(int32_t level, int32_t m)
{
    return 2 * level - m;
}

static inline int32_t ntp__level(int32_t numerator, int32_t m)
{
    return (numerator + m) / 2;
}

/* S; negative where (x, y) is longer than 1. */
static inline int64_t ntp__rest(int32_t r, int32_t g, int32_t m)
{
    return ntp__sq(m) - ntp__sq(ntp__num(r, m)) - ntp__sq(ntp__num(g, m));
}

/* The blue that belongs to S >= 0: the rounding of ((sqrt(S)/M + 1)/2) M, or of sqrt(S). */
static inline int32_t ntp__blue_of_rest(int64_t s, int32_t m, bool zzero)
{
    if (zzero)
        return (int32_t) ((ntp__isqrt(4 * (uint64_t) s) + 1) / 2);
    return (int32_t) ((ntp__isqrt((uint64_t) s) + (uint32_t) m + 1) / 2);
}

/* Pulls a pair that is longer than 1 onto the disc.  Of the four pairs of levels around its projection, it
 * takes the one on the disc that reaches farthest in its direction. */
void ntp__pull(int32_t *r, int32_t *g, int32_t m);

/* The same of a pair that is too long only as the x and y of a vector of length 1 were rounded. */
void ntp__pull_rounded(int32_t *r, int32_t *g, int32_t m);

/* The blue derived from r, g.  If they are too long, they are pulled first. */
static inline int32_t ntp__derive(int32_t *r, int32_t *g, int32_t m, bool zzero)
{
    int64_t s = ntp__rest(*r, *g, m);
    if (s < 0) {
        ntp__pull(r, g, m);
        s = ntp__rest(*r, *g, m);
    }
    return ntp__blue_of_rest(s, m, zzero);
}

/* In the standard encoding, is this blue a negative z? */
static inline bool ntp__z_negative(int32_t b, int32_t m)
{
    return b <= (m - 1) / 2;
}

/* Does the box of +-1/2 level around the texel meet the unit sphere?  Standard: half a level is 1
 * in numerators.  Z-zero: everything is doubled, so that half a blue level is 1. */
static inline bool ntp__rounded(int32_t r, int32_t g, int32_t b, int32_t m, bool zzero)
{
    int64_t ax = ntp__abs(ntp__num(r, m)), ay = ntp__abs(ntp__num(g, m));
    int64_t least = ntp__sq(ax - 1) + ntp__sq(ay - 1), most = ntp__sq(ax + 1) + ntp__sq(ay + 1);
    if (!zzero) {
        int64_t az = ntp__abs(ntp__num(b, m));
        return least + ntp__sq(az - 1) <= ntp__sq(m) && most + ntp__sq(az + 1) >= ntp__sq(m);
    }
    int64_t low = b > 0 ? 2 * (int64_t) b - 1 : 0;
    return 4 * least + ntp__sq(low) <= 4 * ntp__sq(m) &&
           4 * most + ntp__sq(2 * (int64_t) b + 1) >= 4 * ntp__sq(m);
}

/* Haines' test: of the 27 triplets at -1, 0, +1 level, is one at most 1 long and one at least 1?
 * The least and the greatest square of each channel decide.  For |X| = 1 the least is that of
 * |X| - 2 = -1. */
static inline bool ntp__neighbor(int32_t r, int32_t g, int32_t b, int32_t m, bool zzero)
{
    int64_t ax = ntp__abs(ntp__num(r, m)), ay = ntp__abs(ntp__num(g, m));
    int64_t az = zzero ? b : ntp__abs(ntp__num(b, m)), step = zzero ? 1 : 2;
    int64_t low = zzero && b == 0 ? 0 : az - step;
    int64_t least = ntp__sq(ax - 2) + ntp__sq(ay - 2) + ntp__sq(low);
    int64_t most = ntp__sq(ax + 2) + ntp__sq(ay + 2) + ntp__sq(az + step);
    return least <= ntp__sq(m) && most >= ntp__sq(m);
}

/* floor((M + 1 + M V / L) / 2) with L*L = length2: the correctly rounded level of V / L. */
static inline int32_t ntp__unit_level(int32_t v, int64_t length2, int32_t m)
{
    uint64_t a = (uint64_t) ntp__abs(v) * (uint64_t) m;
    int32_t q = (int32_t) ntp__isqrt(a * a / (uint64_t) length2);
    /* V / L is irrational, so the floor of a negative quotient lies one below. */
    return v < 0 ? (m - q) / 2 : (m + 1 + q) / 2;
}

/* The 3-vector divided by its length, each channel correctly rounded. */
static inline void ntp__normalize(int32_t *r, int32_t *g, int32_t *b, int32_t m, bool zzero)
{
    int32_t x = ntp__num(*r, m), y = ntp__num(*g, m), z = zzero ? *b : ntp__num(*b, m);
    int64_t length2 = ntp__sq(x) + ntp__sq(y) + ntp__sq(z);
    *r = ntp__unit_level(x, length2, m);
    *g = ntp__unit_level(y, length2, m);
    if (!zzero) {
        *b = ntp__unit_level(z, length2, m);
        return;
    }
    /* floor(M z / L + 1/2): f = floor(M z / L), one more when M z / L >= f + 1/2. */
    uint64_t a = (uint64_t) z * (uint64_t) m, l2 = (uint64_t) length2;
    uint64_t f = ntp__isqrt(a * a / l2);
    uint64_t over = a * a - f * f * l2;
    *b = (int32_t) (f + (4 * over >= (4 * f + 1) * l2));
}

static inline bool ntp__unused(int32_t r, int32_t g, int32_t b, int32_t a, int32_t m,
                               uint32_t touch)
{
    return (a == 0 && !(touch & NTP_UNUSED_TRANSPARENT)) ||
           (r == 0 && g == 0 && b == 0 && !(touch & NTP_UNUSED_BLACK)) ||
           (r == m && g == m && b == m && !(touch & NTP_UNUSED_WHITE));
}

/* The flags of ntp_validate except NTP_FLAG_UNUSED and NTP_FLAG_NOT_FINITE. */
static inline uint32_t ntp__flags(int32_t r, int32_t g, int32_t b, int32_t m, ntp_encoding encoding,
                                  bool keep_negative_z)
{
    int64_t s = ntp__rest(r, g, m);
    uint32_t flags = s < 0 ? (uint32_t) NTP_FLAG_XY_TOO_LONG : 0;
    if (encoding == NTP_ENCODING_XY)
        return s < 0 ? flags : NTP_FLAG_NEIGHBOR | NTP_FLAG_ROUNDED | NTP_FLAG_EXACT;
    bool zzero = encoding == NTP_ENCODING_ZZERO, negative = !zzero && ntp__z_negative(b, m);
    if (negative)
        flags |= NTP_FLAG_Z_NEGATIVE;
    if (ntp__neighbor(r, g, b, m, zzero))
        flags |= NTP_FLAG_NEIGHBOR;
    if (ntp__rounded(r, g, b, m, zzero))
        flags |= NTP_FLAG_ROUNDED;
    if (s >= 0) {
        int32_t want = ntp__blue_of_rest(s, m, zzero);
        if (b == want || (negative && keep_negative_z && m - b == want))
            flags |= NTP_FLAG_EXACT;
    }
    return flags;
}

/* Repairs one texel in place.  The caller leaves out unused texels. */
static inline void ntp__clean(int32_t c[3], int32_t m, ntp_encoding encoding,
                              ntp_clean_method method, bool keep_negative_z)
{
    bool zzero = encoding == NTP_ENCODING_ZZERO;
    if (encoding == NTP_ENCODING_XY) {
        if (method != NTP_CLEAN_KEEP && ntp__rest(c[0], c[1], m) < 0)
            ntp__pull(&c[0], &c[1], m);
        return;
    }
    bool negative = !zzero && ntp__z_negative(c[2], m);
    if (negative && !keep_negative_z) {
        c[2] = m - c[2];
        negative = false;
    }
    if (method == NTP_CLEAN_DERIVE) {
        int32_t b = ntp__derive(&c[0], &c[1], m, zzero);
        c[2] = negative ? m - b : b;
    } else if (method == NTP_CLEAN_NORMALIZE && !ntp__rounded(c[0], c[1], c[2], m, zzero)) {
        ntp__normalize(&c[0], &c[1], &c[2], m, zzero);
    }
}

/* 16 to 8 bit: c / 257 rounded; 257 is odd, so there is no tie.  With v = 257 q + r, v - floor(v/256)
 * is 256 q + r or, where r is 256 - q or more, one less; so it is below 256 (q + 1). */
static inline int32_t ntp__narrow(int32_t c)
{
    const int32_t v = c + 128;
    return (v - (v >> 8)) >> 8;
}

/* Are red and green both within 15 levels of 8 bit from an end, as those of black, of white and of
 * their flips still are after compression?  (x, y) is longer than 1.23 there: no damage to a normal
 * makes it so. */
static inline bool ntp__is_padding(int32_t r, int32_t g, int32_t m)
{
    enum { NEAR_END = 16 };
    int32_t r8 = m == 255 ? r : ntp__narrow(r), g8 = m == 255 ? g : ntp__narrow(g);
    return (r8 < NEAR_END || r8 > 255 - NEAR_END) && (g8 < NEAR_END || g8 > 255 - NEAR_END);
}

#endif
