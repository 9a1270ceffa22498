/* SPDX-License-Identifier: MIT */
/*
 * judged_sums.h - what judged texels add up to
 */
#ifndef NTP_JUDGED_SUMS_H
#define NTP_JUDGED_SUMS_H

#include "measure/merge.h"
#include "base/view.h"
#include "texel/angle.h"
#include "texel/close.h"
#include "texel/judged.h"
#include "texel/kernels.h"

enum {
    NTP__LENGTH_BINS = 256 /* of 1/128 */
};

/* Sums over judged texels, read as standard or as Z-zero. */
typedef struct ntp__fit_sums {
    uint32_t flags[NTP__ALL_BINS * 256]; /* texels by steepness * 256 + flags */
    uint32_t lengths[NTP__LENGTH_BINS];
    /* The same of every second texel that ntp__add_block counts once; merged sums have none. */
    uint32_t other_flags[NTP__ALL_BINS * 256], other_lengths[NTP__LENGTH_BINS];
    uint64_t length_error[NTP__ALL_BINS]; /* Z-zero: only that of padding is read */
    uint64_t length_error2[2];            /* without padding, and of padding */
    uint64_t length_sum;
    uint32_t length_max, length_inverted_min; /* ~min: zero-filled memory means none yet */
    uint32_t levels_off_max;                  /* the greatest index below with a count */
    uint32_t levels_off[NTP__NO_BLUE + 1];    /* the last one is never read */
} ntp__fit_sums;

enum {
    NTP__HARM_KINDS = 3,   /* the bits of NTP_HARM_* */
    NTP__PADDING_HARM = 2, /* padding has the last two of these kinds again, after all three */
    NTP__ALL_HARM = NTP__HARM_KINDS + NTP__PADDING_HARM,
    NTP__HARM_BINS = 18001 /* of 0.01 degrees */
};

/* Texels that are wrong by more than rounding, with angles in micro-degrees.  Bin i holds the
 * angles above (i - 1)/100 degrees and up to i/100. */
typedef struct ntp__harm_sums {
    uint64_t texels, sum, max;
    uint32_t bins[NTP__HARM_BINS];
} ntp__harm_sums;

/* Sums over texels judged at one M. */
typedef struct ntp__sums {
    uint64_t texels;
    ntp__fit_sums fit[2]; /* standard, Z-zero */
    ntp__angle_sums angles;
    ntp__harm_sums harm[NTP__ALL_HARM]; /* by the encoding of the angles */
} ntp__sums;

/* The greatest bin in use. */
static inline uint32_t ntp__harm_bin(uint64_t angle)
{
    return (uint32_t) ((angle + 9999) / 10000);
}

/* Makes the sums empty again. */
void ntp__clear_sums(ntp__sums *sums);

void ntp__merge_sums(ntp__sums *into, const ntp__sums *from);

/* Adds count[i] texels (NULL: one each) of the color c[0..2][i], i < n, with angles by this
 * encoding. */
void ntp__add_block(ntp__sums *sums, const ntp__block *block, const uint32_t *count, int32_t n,
                    int32_t m, ntp_encoding encoding);

/* Colors with their counts, waiting to be judged together. */
typedef struct ntp__color_batch {
    ntp__block block;
    uint32_t count[NTP__BLOCK];
    int32_t n;
} ntp__color_batch;

/* Pulls the pairs among these that are too long, where want[i] is negative, and derives the blues of
 * these. */
void ntp__clean_long(int32_t *r, int32_t *g, int32_t *want, int32_t n, int32_t m, bool zzero);

/* Adds what waits. */
void ntp__end_batch(ntp__sums *sums, ntp__color_batch *batch, int32_t m, ntp_encoding encoding);

/* Puts a color there, and adds all when the batch is full. */
static inline void ntp__put_color(ntp__sums *sums, ntp__color_batch *batch, const int32_t c[3],
                                  uint32_t count, int32_t m, ntp_encoding encoding)
{
    for (int32_t k = 0; k < 3; k++)
        batch->block.c[k][batch->n] = c[k];
    batch->count[batch->n++] = count;
    if (batch->n == NTP__BLOCK)
        ntp__end_batch(sums, batch, m, encoding);
}

struct ntp__far_counts; /* far_texels.h */

/* Adds those of n 16-bit texels of the standard encoding, which angles are those of too, that are close to exact or
 * far from it, as long as kernels find them.  The others go to the front of the block; returns how many they are.
 * Close ones are counted in `close`, as far as that holds them; counts of far ones are partly in `far`. */
int32_t ntp__take_close_block(ntp__sums *sums, ntp__close_counts *close,
                              struct ntp__far_counts *far, ntp__block *block, int32_t n);

/* Adds all of them.  Changes the block. */
void ntp__add_close_block(ntp__sums *sums, ntp__close_counts *close, struct ntp__far_counts *far,
                          ntp__block *block, int32_t n);

/* Adds exact texels that count_exact counted (texel/kernels.h). */
void ntp__add_exact(ntp__sums *sums, const ntp__exact_block *found);

/* Adds what `close` holds of the texels that ntp__add_close_block and ntp__add_exact added to these
 * sums, and makes it empty. */
void ntp__take_close(ntp__sums *sums, ntp__close_counts *close);

/* Adds what is counted elsewhere in ntp__fit_sums to the other counts. */
void ntp__take_others(ntp__sums *sums);

/* Adds counts of texels that are in these sums, or makes them empty. */
void ntp__merge_close(ntp__close_counts *into, const ntp__close_counts *from,
                      const ntp__sums *sums);
void ntp__clear_close(ntp__close_counts *close, const ntp__sums *sums);

/* Adds `count` texels of one color. */
void ntp__add(ntp__sums *sums, const int32_t c[3], uint32_t count, int32_t m,
              ntp_encoding encoding);

#endif
