/* SPDX-License-Identifier: MIT */
/*
 * tally.h - what a measurement keeps
 *
 * This room walks over texels once and keeps counts and sums in a tally; facts follow from them.
 * Colors of 8 bit are only counted on the way, and judged when the facts are asked for.  Other
 * colors are judged at once and added to `wide`.
 *   measure.c        the pass over the texels; packed8_tmpl.h and packed16_tmpl.h are its
 *                    parts for packed RGB, split16_tmpl.h tells texels of 16 bit apart
 *   color_counts.h   how often each color of 8 bit occurs: the cells
 *   judged_sums.h    what judged texels add up to: verdicts, lengths, angles
 *   dense_row_avx2.h the same for rows of cells of which many hold counts
 *   colors_avx512.h  the same for other rows, with AVX-512
 *   close_sums.c     the same for 16-bit texels that are close to exact
 *   far_texels.h     the same for those that are far from it, as noise is
 *   sampled_rows.c   what costs more than a count, and is measured on some rows only
 *   tally.c          turns cells into sums
 *   summarize.c      from the sums to ntp_stats, which users read, and to the evidence
 *   evidence.h       what classify/ asks beyond ntp_stats
 *   blue_evidence.c  the part of it that compares blue with red and green
 *   blue_row.h       what that adds up of the cells of a row, also with AVX2
 *   merge.c          merges and empties tallies and sums
 *   merge.h          adds counts, and takes greater values
 */
#ifndef NTP_TALLY_H
#define NTP_TALLY_H

#include "measure/color_counts.h"
#include "measure/evidence.h"
#include "measure/far_texels.h"
#include "measure/judged_sums.h"
#include "base/view.h"
#include "texel/kernels.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

enum {
    NTP__PAIR_RUN = 32,   /* reds of a green whose pairs lie side by side */
    NTP__PAIR_GROUP = 64, /* pairs that are noted together: of two greens */
    NTP__PAIR_TEXEL =
        1 << 20, /* in `pairs`: the blues of 4096 texels, which it may hold, are less */
    NTP__LARGE_PAGE = 2 << 20
};

typedef struct ntp__channel_sums {
    uint64_t sum;
    uint32_t max, inverted_min;
} ntp__channel_sums;

struct ntp_tally {
    /* What was measured; depth 0: nothing yet. */
    uint32_t depth, channels, encoding, touched;
    uint32_t hidden;  /* texels of transparent_wide are in close_hidden and far_hidden */
    uint32_t is_wide; /* a 16-bit level that is no multiple of 257 was seen */
    uint64_t texels, black, white, transparent, not_finite, gray;
    uint64_t ag_in_disc;
    uint64_t block_steps[3][2], block_count[2]; /* [channel][0 within a block, 1 across] */
    uint32_t alpha[256];                        /* every texel; 16 bit rounded to 8 */
    ntp__channel_sums alpha_levels;             /* of 16 bit only, like wide_alpha_ends */
    uint64_t wide_alpha_ends[2];                /* alpha 0, alpha M */

    ntp__samples samples, padding_samples; /* the second: those of the first that are padding */

    /* Every finite texel. */
    ntp__channel_sums channel[3];
    /* The number of different used colors, 2 standing for more, and the first color. */
    uint32_t colors, color[3];
    /* Texels of 8 bit to be counted in another way before exact ones are looked for again; the last time. */
    int32_t not_close, last_not_close;
    uint64_t wide_flat, narrow;       /* used texels: flat ones of 16 bit; those in the cells */
    uint32_t summed, summed_encoding; /* are `used` and `unused` up to date, and angles for what? */
    uint32_t gathered;                /* is `evidence` what follows from them? */

    /* By level of 8 bit, decoded from sRGB to L of 16 bit: ((2L - M)^2 - 1) / 4, a whole number below 2^30.
     * The first one is 0 as long as these are not worked out. */
    uint32_t linear_square[256];

    ntp__color_counts
        cells; /* used texels only; where most are close, the far ones stay untouched */

    ntp__sums transparent_wide; /* judged at 16 bit */
    uint32_t pair_texels[65536];
    /* Well-formed textures of 16 bit need what follows, up to `harm` of `wide`. */
    uint8_t pair_seen[65536 / NTP__PAIR_GROUP];
    /* Pairs of sampled rows: texels and the sum of their blues in one number (ntp__pair_place, NTP__PAIR_TEXEL),
     * and if pairs_full is set, more of them. */
    uint32_t pairs_full, pairs[65536];
    ntp__close_counts close; /* texels of `wide` */
    ntp__sums wide;

    /* ntp_tally_summarize makes these from all the rest.  They are kept until the tally changes. */
    uint64_t blues[256];    /* texels of the cells by blue */
    ntp__evidence evidence; /* ntp__gather_evidence does */
    ntp__sums used, unused; /* `used` where any is in the cells: see ntp__used */

    /* Well-formed textures need nothing from here on, so these pages stay untouched. */
    uint8_t wide_flat_seen[4 * 8192]; /* a bit for each blue of the four flat pairs */
    uint64_t pair_blue[65536];
    ntp__sums transparent_narrow;   /* judged at 8 bit */
    ntp__far_counts far;            /* texels of `wide`, as those in `close` */
    ntp__close_counts close_hidden; /* of transparent_wide, if hidden is set */
    ntp__far_counts far_hidden;
};

/* A caller may put one large page under the counts of the depth it has (libntp.h, ntp_tally_size). */
_Static_assert(offsetof(ntp_tally, cells.at.far) <= NTP__LARGE_PAGE &&
                   offsetof(ntp_tally, pair_seen) >= 6 * NTP__LARGE_PAGE &&
                   offsetof(ntp_tally, wide.harm) <= 7 * NTP__LARGE_PAGE,
               "");

/* The place of red and green, rounded to 8 bit.  Slopes lie in a disc, so a page holds 32 reds of 32
 * greens: in a small texture few pages are touched. */
static inline uint32_t ntp__pair_place(uint32_t r, uint32_t g)
{
    return (g >> 5) << 13 | (r >> 5) << 10 | (g & 31) << 5 | (r & 31);
}

/* The texels of a pair, and the sum of their blues. */
typedef struct ntp__pair {
    uint64_t texels, blue;
} ntp__pair;

static inline ntp__pair ntp__pair_at(const ntp_tally *tally, uint32_t place)
{
    const uint32_t few = tally->pairs[place];
    ntp__pair pair = { few / NTP__PAIR_TEXEL, few % NTP__PAIR_TEXEL };
    if (tally->pairs_full) {
        pair.texels += tally->pair_texels[place];
        pair.blue += tally->pair_blue[place];
    }
    return pair;
}

/* What is not noted is not cleared before.  And a page that is first written to takes one fault; one that
 * is read first takes two. */
static inline void ntp__begin_pairs(ntp_tally *t, uint32_t group)
{
    t->pair_seen[group] = 1;
    memset(&t->pairs[group * NTP__PAIR_GROUP], 0, NTP__PAIR_GROUP * sizeof t->pairs[0]);
}

/* Adds the texels x0 <= x < x1 of row y to the samples if the row is a sampled one
 * (sampled_rows.c). */
void ntp__sample_row(ntp_tally *tally, const ntp_const_image *src, int32_t x0, int32_t x1,
                     int32_t y);

/* The greatest magnitude of a red or green of 8 bit (merge.c). */
int32_t ntp__steepest_of(const ntp_tally *tally);

/* The sums over used texels, once they are made.  Those of 16 bit alone are not copied: that takes
 * longer than to look at a small texture. */
static inline const ntp__sums *ntp__used(const ntp_tally *tally)
{
    return tally->narrow > 0 ? &tally->used : &tally->wide;
}

/* Makes these sums and tally->unused, with angles by this encoding.  The errors are those of
 * ntp_tally_summarize. */
ntp_status ntp__sum_up(ntp_tally *tally, ntp_encoding encoding);

/* Fills in how blue depends on red and green (blue_evidence.c). */
void ntp__describe_blue(ntp__evidence *evidence, const ntp_tally *tally);

/* May a texel of a whole block have another color than the one that is noted?  Black and white ones that are unused
 * do not count.  Without branches, as of two colors any may come next. */
static inline bool ntp__may_differ(const ntp_tally *t, const ntp__block *block, int32_t m)
{
    const int32_t black = t->touched & NTP_UNUSED_BLACK ? 1 : 0;
    const int32_t white = t->touched & NTP_UNUSED_WHITE ? 1 : 0;
    int32_t any = 0, first = t->colors == 0; /* none is noted: any may be it */
    for (int32_t i = 0; i < NTP__BLOCK; i++) {
        const int32_t r = block->c[0][i], g = block->c[1][i], b = block->c[2][i];
        const int32_t other = first | (r ^ (int32_t) t->color[0]) | (g ^ (int32_t) t->color[1]) |
                              (b ^ (int32_t) t->color[2]);
        any |= (other != 0) & ((r | g | b | black) != 0) & ((((r & g & b) ^ m) | white) != 0);
    }
    return any != 0;
}

/* The M that texels are judged at. */
static inline int32_t ntp__tally_max(const ntp_tally *t)
{
    return t->depth == 8 || !t->is_wide ? 255 : 65535;
}

/* The encoding that angles are measured by: vectors and pictures count as standard. */
static inline ntp_encoding ntp__judged_as(ntp_encoding encoding)
{
    return encoding == NTP_ENCODING_ZZERO || encoding == NTP_ENCODING_XY ? encoding
                                                                         : NTP_ENCODING_STANDARD;
}

/* The encoding of the sums that are there, or else that of the tally.  Facts that do not depend on
 * the encoding ask for this one, and so cause no new sums. */
ntp_encoding ntp__encoding_at_hand(const ntp_tally *t);

/* Padding that is surely no damage: much of it, and of one color but for compression. */
uint64_t ntp__padding_of_one_color(const ntp_tally *t);

#endif
