/* SPDX-License-Identifier: MIT */
/*
 * far_texels.h - adds 16-bit texels that are far from exact, with AVX2 or AVX-512
 *
 * Nearly all texels of noise are so, and their counts fall into more memory than the caches near the
 * processor hold.  So what ntp__sums counts in 32 bits is counted in bytes first; a byte that runs
 * over is carried there.  Steepness, flags and the standard length are counted together, in a table of
 * their own: most of it stays empty, and one count takes less time than two.
 */
#ifndef NTP_FAR_TEXELS_H
#define NTP_FAR_TEXELS_H

#include "measure/judged_sums.h"

#include <stdbool.h>

/* A key of texels that are no neighbors: the bin of steepness, and flags. */
enum {
    NTP__KEY_ZZ_LONG = 1,  /* longer than 1 in Z-zero */
    NTP__KEY_SHORT = 2,    /* not longer than 1 */
    NTP__KEY_NEGATIVE = 4, /* below the horizon */
    NTP__KEY_TOO_LONG = 8, /* x and y */
    NTP__KEY_FAR = 16,     /* beyond the limit of the reference program */
    NTP__KEY_STEEP = 32,
    NTP__KEYS = NTP__ALL_BINS * NTP__KEY_STEEP
};

typedef struct ntp__far_counts {
    uint32_t skip;  /* blocks to come that are not looked at, as few of the last one were far */
    uint32_t first; /* no texel of the last block was close */
    uint32_t used;  /* 0: all of the following are 0 */
    uint32_t keys[NTP__KEYS];                          /* what is carried of the following */
    uint8_t shapes[NTP__KEYS * NTP__LENGTH_BINS];      /* by the key, and the bin of the length */
    uint8_t few[sizeof(ntp__sums) / sizeof(uint32_t)]; /* by the words of ntp__sums */
} ntp__far_counts;

enum { NTP__FAR_STEP = 256 };

/* Where up to NTP__FAR_STEP texels are to be counted. */
typedef struct ntp__far_places {
    uint32_t shape[NTP__FAR_STEP]; /* key << 16 | bin of the length << 8 | bin of that in Z-zero */
    uint64_t words[2 * NTP__FAR_STEP]; /* four words of ntp__sums for each texel, two in one */
} ntp__far_places;

/* Counts n texels, an even number. */
void ntp__count_places(ntp__sums *sums, ntp__far_counts *far, const ntp__far_places *at, int32_t n);

/* Adds those angles of harm that bits say, in micro-degrees; a kind is the words before its sums. */
void ntp__add_padding_harm(ntp__sums *sums, const int32_t *kinds, const int32_t *angles,
                           uint32_t which);

/* Adds n 16-bit texels as ntp__add_block does in the standard encoding, but for groups of eight in which
 * any is a neighbor in one of the encodings.  These go to the front of the block; returns how many they
 * are.  Some of the counts are in `far`. */
int32_t ntp__add_far_avx2(ntp__sums *sums, ntp__far_counts *far, ntp__block *block, int32_t n);

/* Pulls n pairs that are too long, of texels with this blue, and makes what angles to clean vectors are made of:
 * squares of products, and dot products (long_products in turn_avx2_tmpl.h); up to whole lanes of four. */
void ntp__long_products_avx2(double *s2, double *d, const int32_t *r, const int32_t *g,
                             const int32_t *b, int32_t n);

/* As ntp__add_far_avx2, but none of the other texels of a group goes there, only up to 15 of all. */
int32_t ntp__add_far_avx512(ntp__sums *sums, ntp__far_counts *far, ntp__block *block, int32_t n);

/* The same of packed texels, and those that are odd (survey in texel/kernels.h), but not for being gray, go to
 * `left` too.  The survey counts all grays.  *n, 16 or more,
 * becomes how many are done and surveyed: a multiple of 16, and all of these if *n is at most NTP__BLOCK. */
int32_t ntp__add_far_rgb_avx512(ntp__sums *sums, ntp__far_counts *far, ntp__survey *found,
                                ntp__block *left, const uint16_t *rgb, int32_t *n);

/* Adds to sums what `far` holds of the texels in `of`, or makes it empty. */
void ntp__merge_far(ntp__sums *into, const ntp__far_counts *far, const ntp__sums *of);
void ntp__clear_far(ntp__far_counts *far, const ntp__sums *of);

#endif
