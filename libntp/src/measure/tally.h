/* SPDX-License-Identifier: MIT */
/*
 * tally.h - what a measurement keeps
 *
 * 8-bit texels are not judged one by one.  Each adds one to the cell of (row, blue), where the
 * row stands for {|X|, |Y|}, all that verdicts, lengths and angles depend on.  Two lookups and
 * two increments a texel, and all facts follow exactly, in integers, when the cells are read
 * (summarize.c).  A 16-bit texel of which every level is a multiple of 257 goes to the same
 * cells, for its X and Y are 257 times those of the 8-bit texel; the others are judged and added
 * to `wide`.
 *
 * Tables of megabytes are slow to look through, so it is noted which parts of them hold counts: of
 * small images for each texel, of large ones, where that would cost more, once at the end.
 */
#ifndef NTP_TALLY_H
#define NTP_TALLY_H

#include "measure/evidence.h"
#include "texel/angle.h"
#include "texel/judged.h"
#include "base/view.h"

#include <math.h>
#include <string.h>

enum {
    /* Unordered pairs of 128 magnitudes, and a row for each of the four flat pairs, which are
     * kept apart to tell flat colors. */
    NTP__FLAT_ROWS = 4,
    NTP__ROWS = 128 * 129 / 2 + NTP__FLAT_ROWS,

    NTP__NEAR = 16,            /* cells about the derived blue of a row: a cache line */
    NTP__FAR_CELLS = 256 + 16, /* rows a power of two apart would share few cache sets */
    NTP__FEW = 4096,           /* texels up to which it pays to note the rows of each */
    NTP__PAIR_GROUP = 64,      /* pairs of red and green that are noted together */

    NTP__LENGTH_BINS = 256 /* of 1/128 */
};

/* Where the cells of a row hold counts. */
enum { NTP__SEEN_NEAR = 1, NTP__SEEN_FAR = 2 };

/* What judged texels add, read as standard or as Z-zero. */
typedef struct ntp__fit_sums {
    uint32_t flags[NTP__STEEPNESS_BINS * 256]; /* texels by steepness * 256 + flags */
    uint64_t length_error[NTP__STEEPNESS_BINS], length_error2;
    uint64_t length_sum;
    uint32_t length_max, length_inverted_min; /* ~min: zero-filled memory means none yet */
    uint32_t lengths[NTP__LENGTH_BINS];
    uint32_t levels_off_max; /* of the texels below */
    uint32_t levels_off[65536];
} ntp__fit_sums;

/* All at one M. */
typedef struct ntp__sums {
    uint64_t texels;
    ntp__fit_sums fit[2]; /* standard, Z-zero */
    ntp__angle_sums angles;
} ntp__sums;

typedef struct ntp__channel_sums {
    uint64_t sum;
    uint32_t max, inverted_min;
} ntp__channel_sums;

/* Used texels of sampled rows, at 8 bit. */
typedef struct ntp__samples {
    uint64_t n, sum[3], square[3], product[3]; /* products: r g, r b, g b */
    uint64_t red_low, green_low;               /* below 128 */
    uint64_t gamma_flat, gamma_unit;           /* near (188, 188); of length 1 as linear levels */
} ntp__samples;

struct ntp_tally {
    /* What was measured; depth 0: nothing yet. */
    uint32_t depth, channels, encoding, touched;
    uint32_t rows_ready, is_wide; /* is_wide: a 16-bit level that is no multiple of 257 was seen */
    uint64_t texels, black, white, transparent, not_finite, gray;
    uint64_t ag_in_disc;
    uint64_t block_steps[3][2], block_count[2]; /* [channel][0 within a block, 1 across] */
    uint32_t alpha[256];                        /* every texel; 16 bit rounded to 8 */
    ntp__channel_sums alpha_levels;             /* 16 bit only, as wide_alpha_ends */
    uint64_t wide_alpha_ends[2];                /* alpha 0, alpha M */

    ntp__samples samples;

    /* Every finite texel. */
    ntp__channel_sums channel[3];
    /* Different used colors, counted up to 2, and the first. */
    uint32_t colors, color[3];
    uint64_t wide_flat, narrow;       /* of used texels; narrow: those of the cells */
    uint32_t summed, summed_encoding; /* whether `used` and `unused` are of now, and for what */

    /* The cells: used texels only. */
    uint32_t few;                 /* those being measured are few: their rows are noted */
    uint32_t unnoted;             /* some rows with near cells are not in row_seen */
    uint8_t row_seen[NTP__ROWS];  /* NTP__SEEN_* */
    uint32_t row_of[65536];       /* by r | g << 8: see ntp__entry; when rows_ready */
    uint16_t row_pair[NTP__ROWS]; /* of a row seen: some r | g << 8 of it, r, g >= 128 */
    uint8_t row_first[NTP__ROWS]; /* and the blue of its first near cell */
    /* The cells of a row: those near its derived blue; the others are in `far`. */
    uint32_t near[NTP__ROWS * NTP__NEAR];
    /* What ntp_tally_summarize works out of the cells and the above, kept until the tally changes. */
    ntp__sums used, unused;

    /* From here on, what well-formed textures of 8 bit do without: pages that stay untouched. */
    uint32_t far[NTP__ROWS][NTP__FAR_CELLS];
    uint8_t wide_flat_seen[4 * 8192]; /* a bit for each blue of the four flat pairs */
    ntp__sums wide;
    uint8_t pair_seen[65536 / NTP__PAIR_GROUP];
    uint32_t pair_texels[65536]; /* of sampled rows, by r | g << 8 rounded to 8 bit */
    uint64_t pair_blue[65536];   /* and the sum of their blues */
    ntp__sums transparent_wide, transparent_narrow; /* judged at 16 and at 8 bit */
};

/* Red and green, judged: what all blues of a row share. */
typedef struct ntp__row {
    int32_t m, r, g;
    int64_t xy2;     /* X*X + Y*Y */
    int32_t want[2]; /* derived blue, standard and Z-zero; -1: too long */
    int32_t steepness;
    uint32_t flags;     /* NTP_FLAG_XY_TOO_LONG, NTP__FAR */
    int32_t cleaned[2]; /* r, g as ntp_clean leaves them */
    int32_t cleaned_blue[2];
} ntp__row;

void ntp__row_init(ntp__row *row, int32_t r, int32_t g, int32_t m);

/* Adds `count` texels of this row and blue.  encoding: what the angle is taken for. */
void ntp__add(ntp__sums *sums, const ntp__row *row, int32_t b, uint32_t count,
              ntp_encoding encoding);

/*
 * Adds count[i] texels (NULL: one each) of the color c[0..2][i], i < n.  Their x, y are not too
 * long.
 */
void ntp__add_block(ntp__sums *sums, const ntp__block *block, const uint32_t *count, int32_t n,
                    int32_t m, ntp_encoding encoding);

/* Adds row y's texels x0 <= x < x1 to the samples, when it is one of those sampled (sampled_rows.c). */
void ntp__sample_row(ntp_tally *tally, const ntp_const_image *src, int32_t x0, int32_t x1,
                     int32_t y);

void ntp__merge_samples(ntp_tally *into, const ntp_tally *from);

void ntp__clear_samples(ntp_tally *tally);

/* Fills row_of, once. */
void ntp__rows_prepare(ntp_tally *tally);

/* The entry of one pair, without the table. */
uint32_t ntp__find_row(ntp_tally *tally, int32_t r, int32_t g);

/* An entry of row_of: where the cells of its row begin in `near`, and the blue of the first. */
static inline uint32_t ntp__entry(uint32_t row, uint32_t first)
{
    return row * NTP__NEAR << 8 | first;
}

static inline uint32_t ntp__entry_cells(uint32_t entry)
{
    return entry >> 8;
}

static inline uint32_t ntp__entry_first(uint32_t entry)
{
    return entry & 255;
}

/* The texels of a row that was seen, by blue: cells[*first] to cells[*end - 1]; the others are 0
 * and not set. */
void ntp__row_cells(uint32_t cells[256], int32_t *first, int32_t *end, const ntp_tally *tally,
                    int32_t row);

/* The first row from `row` on of which seen[row] is not 0; NTP__ROWS: none. */
static inline int32_t ntp__next_row(const uint8_t seen[NTP__ROWS], int32_t row)
{
    uint64_t eight;
    for (; row + 8 <= NTP__ROWS; row += 8) {
        memcpy(&eight, seen + row, sizeof eight);
        if (eight != 0)
            break;
    }
    while (row < NTP__ROWS && seen[row] == 0)
        row++;
    return row;
}

/* Completes row_seen. */
void ntp__note_rows(ntp_tally *tally);

void ntp__merge_cells(ntp_tally *into, const ntp_tally *from);
void ntp__clear_cells(ntp_tally *tally);

static inline void ntp__merge_counts(uint32_t *into, const uint32_t *from, size_t n)
{
    for (size_t i = 0; i < n; i++)
        into[i] += from[i];
}

/* Fills tally->used and tally->unused, with angles by this encoding.  Errors as ntp_tally_summarize. */
ntp_status ntp__sum_up(ntp_tally *tally, ntp_encoding encoding);

/* Fills in how blue goes with red and green (blue_evidence.c). */
void ntp__describe_blue(ntp__evidence *evidence, const ntp_tally *tally);

/* M that the texels are judged at. */
static inline int32_t ntp__tally_max(const ntp_tally *t)
{
    return t->depth == 8 || !t->is_wide ? 255 : 65535;
}

/* Encoding by which angles are taken: vectors and pictures count as standard. */
static inline ntp_encoding ntp__judged_as(ntp_encoding encoding)
{
    return encoding == NTP_ENCODING_ZZERO || encoding == NTP_ENCODING_XY ? encoding
                                                                         : NTP_ENCODING_STANDARD;
}

#endif
