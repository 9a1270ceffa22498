/* SPDX-License-Identifier: MIT */
/*
 * kernels.h - loops over texels, compiled once for each instruction set
 *
 * kernels.c is plain C that compilers vectorize; only some loops over packed pixels are written by
 * hand.  Every instruction set gives the same bytes: levels and flags come from 32-bit integers,
 * and square roots in float are corrected to the exact integer root.
 *
 * Preconditions of all kernels: 0 <= n; planes hold levels 0..m, m is 255 or 65535; pointers
 * do not alias except where a comment allows it.
 */
#ifndef NTP_KERNELS_H
#define NTP_KERNELS_H

#include "base/cpu.h"
#include "texel/cells.h"
#include "texel/close.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * Cleans packed 8-bit pixels by a table of 65,536 entries indexed by r | g << 8, each holding
 * r' | g' << 8 | b' << 16 and a flag above: nonzero where the pair can be an unused texel.
 * `blue` is NULL unless the table derives standard Z.  Then it is a shorter table, of 64 KiB: the
 * blue of each pair that stays as it is and is never unused, else 0.  `kept` masks the bits of a
 * pixel that stay (blue of XY images).  dst may be src.  Returns the number of pixels that changed.
 */
typedef uint64_t ntp__clean8_fn(uint8_t *dst, const uint8_t *src, size_t n, const uint32_t *table,
                                const uint8_t *blue, uint32_t kept, uint32_t touch_unused);

/*
 * Derives the blue of packed 16-bit pixels from the first on, and adds how many changed (NULL: not
 * counted).  Returns how many are done: n, or fewer when a pair is too long.  (The pairs of black
 * and white are too long.)  The caller then does up to NTP__KERNEL_STEP pixels itself, and calls
 * again.  dst may be src.
 */
typedef int32_t ntp__clean16_fn(uint16_t *dst, const uint16_t *src, int32_t n, int32_t zzero,
                                uint64_t *changed);

/* The same for packed 8-bit pixels, standard Z, without a table.  It leaves a last group of fewer
 * than 2 NTP__KERNEL_STEP pixels to the caller. */
typedef int32_t ntp__derive8_fn(uint8_t *dst, const uint8_t *src, int32_t n, uint64_t *changed);

/* Derives the blue of packed 16-bit pixels, n <= 256 and a multiple of NTP__KERNEL_STEP, and pulls pairs that are
 * too long.  Unused ones stay as they are, and those where the kernel is in doubt how to pull: `at` has the places
 * of the latter, and the result is how many these are.  `changed` counts others.  dst may be src. */
typedef int32_t ntp__derive16_fn(uint16_t *dst, const uint16_t *src, int32_t n, int32_t zzero,
                                 uint32_t touch_unused, int32_t *at, uint64_t *changed);

/* want[i] = the blue derived from r, g; -1 where they are too long. */
typedef void ntp__derive_fn(int32_t *want, const int32_t *r, const int32_t *g, int32_t n, int32_t m,
                            int32_t zzero);

/* What texels are judged by.  `kept` of the flags stay, and where none is left, the flags are
 * `others`. */
typedef struct ntp__validity {
    int32_t m, zzero, keep_negative_z;
    uint32_t kept, others;
} ntp__validity;

/* The flags of ntp_validate but NTP_FLAG_NOT_FINITE.  Flags, and the planes of red, green, blue and
 * alpha, have room for 256; the latter change beyond n. */
typedef void ntp__validate_fn(uint8_t *flags, int32_t *const c[4], int32_t n,
                              const ntp__validity *how);

/* The same of n packed texels of three channels, not as Z-zero; no flag beyond n changes. */
typedef void ntp__validate_rgb_fn(uint8_t *flags, const void *src, int32_t n,
                                  const ntp__validity *how);

/* Sums and extremes of packed texels of 8 bit: 0 of none.  The extremes are the greatest ones of these texels of
 * 4 channels, of which the last one says nothing. */
typedef struct ntp__packed_survey {
    uint64_t texels, sum[3];
    uint8_t extremes[2][32 * 4]; /* 255 less the least level, and the greatest */
    int32_t translucent;         /* set where an alpha is not full */
} ntp__packed_survey;

/* What counts as used, and what was found among texels: how many of them are gray, and unused for being black or
 * white; and the sums and extremes of all. */
enum { NTP__BLACK8 = 1, NTP__WHITE8 = 2, NTP__CLEAR8 = 4 /* alpha 0 */ };
typedef struct ntp__found8 {
    uint32_t used;
    uint64_t gray, black, white;
    ntp__packed_survey *survey;
} ntp__found8;

/*
 * Counts packed texels of 3 or 4 channels of 8 bit in the cells of a tally (cells.h), not in near
 * ones, a group of NTP__KERNEL_STEP after the other.  Black and white ones that are unused are left out of
 * the cells; those that are unused for alpha 0 are left out of all but the survey.  Returns of how many
 * texels, and adds to `found`.  What lies `ahead` bytes further on is fetched.
 */
typedef int32_t ntp__count8_fn(ntp__cell_counts *counts, ntp__found8 *found, const uint8_t *src,
                               int32_t n, int32_t channels, size_t ahead);

/* Counts of alpha, in four parts; and how many texels have alpha and green in the disc: none of those that are
 * black, white, opaque or of alpha 0. */
typedef struct ntp__alphas8 {
    uint32_t count[4][256];
    uint64_t in_disc;
    uint32_t color,
        clear; /* of those of alpha 0 that are hidden: their one color, and how many; 0: any color */
} ntp__alphas8;

/* Adds texels of 4 channels of 8 bit, a group of NTP__KERNEL_STEP after the other, up to one with another color
 * that is hidden, as its alpha is less than `visible`, 0 or 1.  Returns of how many. */
typedef int32_t ntp__count_alpha8_fn(ntp__alphas8 *alphas, const uint8_t *src, int32_t n,
                                     int32_t visible);

/* What is known of packed texels of 8 bit: the places of those that are not counted, in order, and at each of
 * these their row.  Instead of its place a kernel may give a color, as row | blue << 16. */
typedef struct ntp__close8_block {
    uint16_t row[256];
    uint8_t left[256];
    uint32_t color[256];
    int32_t others, colors; /* how many are not counted: places, and colors */
    int32_t visible,
        hidden; /* of four channels, those of less alpha than `visible`, 0 or 1, are hidden: how many are */
    ntp__found8 found; /* of this block and those before; all grays are here */
} ntp__close8_block;

/*
 * Counts packed texels of 3 or 4 channels of 8 bit that are not gray and close to exact: all of
 * those with the derived blue, and of others those with places in the counts but for u < 4 (cells_avx2.c).
 * Grays that are unused for being black or white are in `found`, and not left.  n is a multiple of
 * NTP__KERNEL_LANES, at most NTP__CLOSE8_AT_ONCE.  Returns of how many texels, of at least 128 if there are so many.
 * What lies `ahead` bytes further on is fetched, as sums of the next row would wait for it.
 */
enum { NTP__CLOSE8_AT_ONCE = 4096 };
typedef int32_t ntp__count_close8_fn(ntp__close8_block *out, ntp__close8_counts close,
                                     const uint8_t *src, int32_t n, int32_t channels, size_t ahead);

/* What is known of a block of texels at once. */
typedef struct ntp__survey {
    uint32_t least[3], greatest[3], sum[3];
    uint32_t odd;  /* not 0: a texel is gray, flat at 16 bit, or one of 8 bit times 257 */
    uint32_t gray; /* how many are; set where a comment says so */
} ntp__survey;

/* 1 <= n <= 256.  The planes have room for whole lanes, and change beyond n. */
typedef void ntp__survey_fn(ntp__survey *survey, int32_t *r, int32_t *g, int32_t *b, int32_t n);

/* The same of packed texels of 8 bit. */
typedef struct ntp__survey8 {
    uint64_t sum[3];
    uint32_t least[3], greatest[3];
} ntp__survey8;

/* Of packed texels of 3 or 4 channels, but for the last 0 to 31.  Returns of how many. */
typedef int32_t ntp__survey8_fn(ntp__survey8 *survey, const uint8_t *src, int32_t n,
                                int32_t channels);

/* Sums over the used texels of sampled rows, rounded to 8 bit. */
typedef struct ntp__samples {
    uint64_t n, sum[3], square[3], product[3]; /* products: r g, r b, g b */
    uint64_t red_low, green_low;               /* below 128 */
    uint64_t gamma_flat, gamma_unit;           /* near (188, 188); of length 1 as linear levels */
} ntp__samples;

/* Flat after gamma: red and green of 188, and 3 to both sides. */
enum { NTP__GAMMA_FLAT_LEAST = 185, NTP__GAMMA_FLAT_RANGE = 6 };

/* Is the length within 1/8 of 1 if the levels are decoded from sRGB first?  With s, the sum of their
 * linear_square (measure/tally.h), its square is 4s + 3, and 49 M*M <= 64 (4s + 3) <= 81 M*M. */
static inline bool ntp__linear_near_unit(uint32_t s)
{
    const int64_t unit = INT64_C(65535) * 65535;
    const uint32_t least = (uint32_t) ((49 * unit - 192 + 255) / 256);
    const uint32_t most = (uint32_t) ((81 * unit - 192) / 256);
    return s - least <= most - least;
}

/* Adds packed texels of 3 or 4 channels, in whole groups of NTP__KERNEL_STEP, and those again to `padding` whose
 * red and green are within 15 of an end.  Unused ones have steps alone.  Steps are those from the texel before, also
 * the first; [0] within blocks of eight columns, [1] from one to the next.  `src` is in column x.  n <= 65536.
 * Returns of how many. */
typedef int32_t ntp__sample8_fn(ntp__samples *samples, ntp__samples *padding, uint64_t steps[3][2],
                                const uint32_t *linear_square, const uint8_t *src, int32_t n,
                                int32_t channels, int32_t x, uint32_t touch_unused);

/* A block of texels, judged as standard or as Z-zero. */
typedef struct ntp__judged_fit {
    int32_t key[256];        /* steepness * 256 + flags (judged.h) */
    int32_t levels_off[256]; /* NTP__NO_BLUE: x, y are too long */
    int32_t length[256];     /* in NTP__LENGTH_ONE */
    uint32_t off[256];       /* how far the length is from 1 */
    uint64_t length_sum,
        length_error2[2]; /* the second: squares of off; without padding, and of it */
    uint32_t least, greatest, levels_off_max;
    uint32_t every, some; /* the bits of all keys, and those of any */
} ntp__judged_fit;

typedef struct ntp__judged {
    ntp__judged_fit fit[2]; /* standard, Z-zero */
    int32_t want[256];      /* derived blue in the encoding of the angles; -1: x, y are too long */
    /* Micro-degrees to the cleaned vector; of standard where any z is negative, also to that with the
     * other sign of z.  -1: there is none, as x, y are too long or z is not negative; or doubt. */
    int32_t angle[256], mirrored[256];
} ntp__judged;

/* Sums are of count[i] texels of each color.  The angles are Z-zero's if `zzero` is 1,
 * standard's if 0, and missing if 2. */
typedef void ntp__judge_block_fn(ntp__judged *judged, const int32_t *r, const int32_t *g,
                                 const int32_t *b, const uint32_t *count, int32_t n, int32_t m,
                                 int32_t zzero);

/* Counts 16-bit texels that are close to exact (close.h), with their distances from the blue of
 * Z-zero in levels_off.  The others go to the front of the planes.  0 <= n <= 256. */
typedef void ntp__count_close_fn(ntp__close_block *out, ntp__close_counts *counts,
                                 uint32_t *levels_off, int32_t *const c[3], int32_t n);

/* What is known of n packed texels, and of the exact ones among them.  Of those that are not nearly
 * flat, lengths in Z-zero, in 1/65536 and less 1, and levels from the blue of Z-zero. */
enum { NTP__EXACT_AT_ONCE = 512, NTP__EXACT_GROUP = 16 };

typedef struct ntp__exact_block {
    ntp__survey survey;
    int32_t texels, far; /* exact ones, and those of them that are not nearly flat */
    uint32_t length_sum, least, greatest, levels_off_max; /* of far > 0 */
    uint64_t length_error2;
    /* The places of the texels that are not counted, n - texels, in any order. */
    int32_t left[NTP__EXACT_AT_ONCE + NTP__EXACT_GROUP];
} ntp__exact_block;

/* Counts packed 16-bit texels that are exact and not odd (ntp__survey); whether any is odd, it does not
 * say.  It takes whole groups, NTP__EXACT_AT_ONCE texels or fewer, and returns how many.  There is a group:
 * n >= NTP__EXACT_GROUP. */
typedef int32_t ntp__count_exact_fn(ntp__exact_block *out, ntp__close_counts *counts,
                                    const uint16_t *src, int32_t n);

/* Vectors of any length, as planes. */
typedef struct ntp__vectors {
    double c[3][256];
} ntp__vectors;

/* Why the levels of a vector are not known. */
enum {
    NTP__IN_DOUBT = 1, /* red or green is too near to a boundary between levels */
    NTP__OVERLONG = 2  /* red and green are known, but too long: they have no blue */
};

/*
 * The levels of vectors over their lengths: r and g rounded half up, b derived, in the standard
 * encoding with the sign of z.  Each component is off by at most 2^-33 of the length.  `exact`: the
 * signs of x, y are right, also 0; else they may be wrong where a component is that small.  The
 * sign of z is right.  Components are 0, or from 2^-149 to 2^127 in size.  A vector of length 0 is
 * flat.  doubt[i] says why levels are not known, else 0; returns what any of them says.  Levels and
 * doubts have room for 256.
 */
typedef int32_t ntp__directions_fn(int32_t *r, int32_t *g, int32_t *b, int32_t *doubt,
                                   ntp__vectors *v, int32_t n, int32_t m, int32_t zzero,
                                   int32_t exact);

/* Planes of numerators over m: level + (level & doubled) - less.  So these are levels with a mask of
 * -1 and m, or already numerators with 0 and 0. */
typedef struct ntp__numbers {
    int32_t *c[3];
    int32_t m; /* 255 or 65535: no numerator is beyond it */
    int32_t doubled, less, doubled_z, less_z;
} ntp__numbers;

/* The angles of ntp__angle between vectors; none of them has length 0.  Angles and planes have room
 * for 256; the latter change beyond n, where levels become 0. */
typedef void ntp__angles_fn(int32_t *angle, const ntp__numbers *v, const ntp__numbers *w,
                            int32_t n);

/* The same of n <= 256 pairs s^2 = |v x w|^2 and d = v . w, both times a power of 4 or 2.  All three
 * have room for whole lanes, and change beyond n. */
typedef void ntp__angles_of_fn(int32_t *angle, double *s2, double *d, int32_t n);

/* Standard Z: blues up to `low` are mirrored; then vectors that are not `rounded` go over their
 * lengths, each level rounded half up.  Where doubt[i] is not 0, levels may be wrong.  Returns
 * whether any is.  `changed` counts the texels that are not as they were, also those in doubt.
 * Works on whole lanes: the planes hold levels, and have room for them. */
typedef int32_t ntp__normalize_fn(int32_t *const to[3], int32_t *doubt, int32_t *const from[3],
                                  int32_t n, int32_t m, int32_t low, int32_t *changed);

/* The same of whole steps of packed pixels, n <= 256, where all blues below the middle are mirrored.
 * Unused pixels stay as they are, and those in doubt; `at` has the places of the latter, and the result is how
 * many these are.  `changed` counts others.  dst may be src. */
typedef int32_t ntp__normalize_rgb_fn(void *dst, const void *src, int32_t n, uint32_t touch_unused,
                                      int32_t *at, uint64_t *changed);

/* Copies the colors of n packed RGBA pixels, a multiple of four, to packed RGB; dst: from there, and the rest from
 * src.  Where an alpha of 0 makes a pixel unused, rgb gets a flat color, and dst that of src.  rgb has room for
 * four more bytes.  dst is NULL, or may be src. */
typedef void ntp__move_colors_fn(uint8_t *rgb, uint8_t *dst, const uint8_t *src, int32_t n,
                                 int32_t m, uint32_t touch_unused);

/* The places of the marks that have one of `bits`, in order; returns how many.  `at` has room for n. */
typedef int32_t ntp__find_fn(int32_t *at, const int32_t *marks, int32_t bits, int32_t n);

/* Pulls pairs that are too long onto the disc.  Where doubt[i] is not 0, levels may be wrong.
 * Returns whether any is.  Works on whole lanes: the planes hold levels, and have room for them. */
typedef int32_t ntp__pull_fn(int32_t *r, int32_t *g, int32_t *doubt, int32_t n, int32_t m);

/* May one of n texels be black, white or transparent?  Those of four planes. */
typedef int32_t ntp__suspect_fn(const int32_t *r, const int32_t *g, const int32_t *b,
                                const int32_t *a, int32_t n, int32_t m);

/* The numerators of n levels over m: 2c - m, or c where blue is that of Z-zero.  Those of r and g
 * are multiplied by by_r and by_g. */
typedef void ntp__numerators_fn(ntp__vectors *v, const int32_t *r, const int32_t *g,
                                const int32_t *b, int32_t n, int32_t m, int32_t zzero, double by_r,
                                double by_g);

typedef struct ntp__kernels_table {
    const char *name;
    ntp__clean8_fn *clean_rgb8;         /* counts */
    ntp__clean8_fn *clean_rgb8_blindly; /* returns nothing of use */
    ntp__clean8_fn *clean_rgba8;
    ntp__derive8_fn *derive_rgb8;   /* NULL where a table is faster than arithmetic */
    ntp__clean16_fn *clean_rgb16;   /* NULL where there is the next one */
    ntp__derive16_fn *derive_rgb16; /* NULL where planes are as fast */
    ntp__derive_fn *derive;
    ntp__validate_fn *validate;
    ntp__validate_rgb_fn *validate_rgb; /* NULL where planes are as fast */
    ntp__count8_fn *count_cells;        /* NULL where a table is faster than arithmetic */
    ntp__count_alpha8_fn *count_alpha8; /* NULL where one by one is as fast */
    ntp__count_close8_fn *count_close8; /* NULL where look-ups are as fast */
    ntp__survey8_fn *survey8;
    ntp__sample8_fn *sample8; /* NULL where planes are as fast */
    ntp__survey_fn *survey;
    ntp__judge_block_fn *judge_block;
    ntp__count_close_fn *count_close; /* NULL where judging them as all others is as fast */
    ntp__count_exact_fn *count_exact; /* NULL where planes are as fast */
    ntp__directions_fn *directions;
    ntp__angles_fn *angles;
    ntp__angles_of_fn *angles_of;
    ntp__normalize_fn *normalize;
    ntp__normalize_rgb_fn *normalize_rgb8, *normalize_rgb16; /* NULL where planes are as fast */
    ntp__move_colors_fn *move_colors;                        /* NULL where planes are as fast */
    ntp__find_fn *find;
    ntp__pull_fn *pull;
    ntp__suspect_fn *suspect;
    ntp__numerators_fn *numerators;
} ntp__kernels_table;

enum {
    NTP__KERNEL_STEP = 16,
    NTP__KERNEL_LANES = 32 /* whole lanes are a multiple of these */
};

/* The kernels for this processor; cpu.h says what the mask is. */
const ntp__kernels_table *ntp__kernels(int mask);

/* A copy of these, in which loops for AVX-512 (kernels_avx512.h) have the places of some. */
void ntp__pick_kernels(ntp__kernels_table *kernels, int mask);

#endif
