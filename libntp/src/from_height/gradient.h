/* SPDX-License-Identifier: MIT */
/*
 * gradient.h - what the files of "heightfield -> normals" share
 *
 * This room makes normals from heights.
 *   plan.c              checks the options and turns them into numbers; names of kernels, borders
 *   gradient.c          ntp_normals_from_height, ntp_normals_dithered: walks over the area;
 *                       arithmetic_tmpl.h is a part of it
 *   height_rows.c       makes rows of heights, extended beyond the borders
 *   gradient_kernels.c  the loops, with tap_sums_tmpl.h and encode_tmpl.h
 *   encode_avx2.c       the latter for packed RGB, with AVX2, also straight from 3 x 3 heights,
 *                       as encode_avx512.c does with AVX-512;
 *                       packed_tmpl.h is a part of gradient.c for it
 *   vectors_avx2.c      the same of floats, by vectors_tmpl.h, which vectors_avx512.c includes too;
 *                       float_rows_tmpl.h is a part of gradient.c for it
 *   exact.c             rounds exactly the texels that the loops are in doubt about
 *   dither_tmpl.h       a part of them: rounds so that errors do not add up;
 *                       dither_avx2_tmpl.h is the same with AVX2, dither_avx512.c of 8 bit
 *                       with AVX-512, dither_rows_tmpl.h
 *                       a part of gradient.c that lays out rows for them
 *   pack.c              writes the result, with its alpha
 *   blur.c              ntp_height_blur: Gaussian blur of the heights
 *   relief.c            ntp_relief_add, ntp_relief_scale: the scale that suits a heightfield
 *   like_program.c      ntp_normals_like: the settings that match other programs
 *
 * The normal of a texel is (c D, d E, N) divided by its length.  D and E are the integer tap sums
 * of heights to the right and down, N = denominator * range, and c, d are scale/dx and scale/dy
 * with their signs.
 */
#ifndef NTP_GRADIENT_H
#define NTP_GRADIENT_H

#include "base/bignum.h"
#include "base/view.h"
#include "stencil/border.h"
#include "stencil/taps.h"

enum {
    NTP__LANES = 8, /* the loops do a multiple of these */
    NTP__GRADIENT_ROW = NTP__BLOCK + 2 * NTP__MAX_RADIUS + NTP__LANES,
    NTP__MAX_READS = 3, /* samples that a height is made of */
    NTP__WAVE = 16,     /* rows that are dithered at the same time */
    NTP__WAVES = 2      /* of these with AVX-512 */
};

/* mantissa 2^exponent, the sign apart; mantissa is odd or 0. */
typedef struct ntp__scaled {
    uint64_t mantissa;
    int32_t exponent;
    bool negative;
} ntp__scaled;

typedef struct ntp__gradient_kernels ntp__gradient_kernels;

typedef struct ntp__gradient {
    const ntp__gradient_kernels *loops;
    const ntp_const_image *src;
    const ntp_image *dst;
    const ntp__kernel *kernel;
    ntp_height_source source;
    bool invert;
    int32_t reads, read[NTP__MAX_READS], weight[NTP__MAX_READS]; /* sample index and weight */
    ntp_border border_x, border_y; /* what lies beyond: never NTP_BORDER_REPEAT_SLOPE */
    ntp__span right_x, right_y, down_x, down_y;
    int64_t range;           /* the number that stands for height 1 */
    ntp__scaled x, y;        /* c, d: the normal of dst is (c D, d E, N) over its length */
    double cx, cy;           /* c/N, d/N as doubles */
    double min_z, shortened; /* shortened: sqrt(1 - min_z^2) */
    ntp__scaled min_z_exact;
    int32_t min_z_level;
    bool derived; /* blue */
    ntp_alpha alpha;
    int32_t m; /* of dst; 0 for floats */
} ntp__gradient;

/* One texel of the result. */
typedef struct ntp__normal {
    int32_t level[3]; /* dst of integers */
    float value[3];   /* dst of floats */
    bool finite;      /* false: the stencil reads a height that is not finite */
    bool wide;        /* only integers of many bits could decide the rounding */
} ntp__normal;

ntp__scaled ntp__scaled_from(double v);

/* The correctly rounded normal at (x, y).  For integers, blue is set only if it is not derived.
 * sums: the integer tap sums to the right and down; NULL: they are made here. */
void ntp__gradient_exact(ntp__normal *normal, const ntp__gradient *g, int32_t x, int32_t y,
                         const int64_t *sums);

/* n.x / n.z and n.y / n.z, before min_z, as doubles; false: a height is not finite, both are 0. */
bool ntp__gradient_slopes(const ntp__gradient *g, int32_t x, int32_t y, double xy[2]);

/* Checks all arguments and fills in the rest (plan.c). */
ntp_status ntp__gradient_plan(ntp__gradient *g, const ntp_image *dst, const ntp_const_image *src,
                              const ntp_normals_options *how);

/* Sets which samples of g->src make a height, their weights, and the number for height 1. */
ntp_status ntp__gradient_source(ntp__gradient *g, ntp_height_source source);

/* Writes a run of levels, or of floats.  Fills in alpha, and the third sample of NTP_ENCODING_XY. */
void ntp__gradient_pack(const ntp__gradient *g, ntp__block *block, int32_t x, int32_t y, int32_t n);
void ntp__gradient_pack_floats(const ntp__gradient *g, const float *value, int32_t x, int32_t y,
                               int32_t n);

/* The exact level of a z in 0..1: floor((M + 1 + M z)/2), or floor(M z + 1/2) for Z-zero. */
int32_t ntp__gradient_z_level(double z, int32_t m, bool zzero);

/* The level 0..m of v, or of 1 - v, rounded half up; exact if v is a float. */
int32_t ntp__share_level(double v, bool inverse, int32_t m);

/* The height of a texel, or 1 minus it, rounded to a level 0..m; and as a double; 1 is height 1. */
int32_t ntp__height_level(const ntp__gradient *g, int32_t x, int32_t y, bool inverse, int32_t m);
double ntp__height_value(const ntp__gradient *g, int32_t x, int32_t y);

/* The exact height of a texel, times range; integer sources only. */
int64_t ntp__height_integer(const ntp__gradient *g, int32_t x, int32_t y);

/* --- rows of heights (height_rows.c) --- */

/* A row of heights of the columns x - 4 .. x + n + 3, with what lies beyond the border.  Zeros
 * follow, because the loops of tap sums read beyond the last column. */
typedef struct ntp__height_row {
    int32_t y; /* the row, -4..height + 3 */
    bool filled, finite;
    bool quick;         /* heights are floats, as the samples are (ntp__height_row_floats) */
    double least, most; /* floats: the least magnitude other than 0 and the greatest of a sample */
    float low, high;    /* quick: the range of heights */
    union {
        int32_t i[NTP__GRADIENT_ROW];
        double d[NTP__GRADIENT_ROW];
        float f[NTP__GRADIENT_ROW];
    } h;
} ntp__height_row;

/* Do the tap sums of this source fit into int32_t?  Then heights are kept as int32_t too. */
bool ntp__heights_are_int(const ntp__gradient *g);

/* Fills a row from column x - 4 on; n <= NTP__BLOCK. */
void ntp__height_row_fill(ntp__height_row *row, const ntp__gradient *g, int32_t x, int32_t y,
                          int32_t n);

/* The same of radius 1 and packed gray samples, where no place beyond the border is a sum. */
void ntp__height_row_floats(ntp__height_row *row, const ntp__gradient *g, int32_t x, int32_t y,
                            int32_t n);

/* --- loops (gradient_kernels.c); all write n <= NTP__BLOCK numbers --- */

/* Tap sums of the slope to the right or down, from rows y - 4 .. y + 4.  A row pointer is at column
 * x - 4; rows beyond the radius are not read.  Both loops read and write up to the next multiple of
 * NTP__LANES. */
typedef void ntp__tap_sums_i_fn(int32_t *sums, const int32_t *const rows[NTP__MAX_TAPS],
                                const ntp__kernel *kernel, int32_t down, int32_t n);
typedef void ntp__tap_sums_d_fn(double *sums, const double *const rows[NTP__MAX_TAPS],
                                const ntp__kernel *kernel, int32_t down, int32_t n);

/* Bits of floats without their signs. */
typedef struct ntp__magnitudes {
    int32_t least, most; /* the least other than 0, less 1, else INT32_MAX; the greatest */
    float low, high;     /* the range of the floats themselves; for ntp__take_heights_fn alone */
} ntp__magnitudes;

/* Heights from floats; widens their range. */
typedef void ntp__take_floats_fn(double *height, const float *s, int32_t n, ntp__magnitudes *m);

/* NTP__LANES or more packed samples of any type as they are; widens the range of floats only. */
typedef void ntp__take_heights_fn(float *to, const void *s, ntp_type type, int32_t n,
                                  ntp__magnitudes *m);

/* What the encoding loops need to know. */
typedef struct ntp__encode {
    double cx, cy, half; /* c/N, d/N, M/2 */
    double shortened;    /* sqrt(1 - min_z^2); ignored unless use_shortened */
    int32_t use_shortened, zzero;
    float side, middle; /* the taps across of a kernel of radius 1 */
    double spread;      /* NTP__FROM_FLOATS: no difference of two heights is greater */
    int32_t off; /* 1, and the error of M/2 times a component that tap sums cause, in 2^-15 */
    /* Floats: */
    bool unit;  /* components are (n + 1)/2, that of z is z if Z-zero; else as they are */
    bool steep; /* squares of slopes may be beyond floats */
    bool plain; /* components other than 0 are in their normal range, and have no other error */
    const char *ahead; /* what is written next: fetched on the way */
    double min_z;      /* no z is less */
    double rough;      /* the error of a component that tap sums cause */
} ntp__encode;

enum { NTP__OFF_ONE = 1 << 15 };

/* red, green: levels; blue: the nearest, or NULL.  doubt[i]: 1 where the rounding of
 * one of them is in doubt, else 0.  Returns whether any is.  All planes have room for a multiple of NTP__LANES. */
typedef int32_t ntp__encode_i_fn(int32_t *red, int32_t *green, int32_t *blue, int32_t *doubt,
                                 const int32_t *right, const int32_t *down, int32_t n,
                                 const ntp__encode *e);
typedef int32_t ntp__encode_d_fn(int32_t *red, int32_t *green, int32_t *blue, int32_t *doubt,
                                 const double *right, const double *down, int32_t n,
                                 const ntp__encode *e);

/* What packed texels are made of: tap sums to the right and down, or three rows of heights as floats, which
 * are integers whose tap sums are exact, or not. */
typedef enum ntp__packed_from {
    NTP__FROM_SUMS_I,
    NTP__FROM_SUMS_D,
    NTP__FROM_INTEGERS,
    NTP__FROM_FLOATS
} ntp__packed_from;

/*
 * Makes n <= NTP__BLOCK packed texels of 8 bit, or of 16 (deep), in the standard encoding with derived
 * blue.  Sums have room for whole NTP__LANES; a row pointer is at column x - 1.  cx and cy have the same
 * magnitude, and neither 1/cx nor a sum is beyond 2^60.  at: the places of texels whose levels are in doubt,
 * or whose red and green are too long; returns how many there are.  Negative: nothing was made, because
 * of these floats too much is in doubt.
 */
typedef int32_t ntp__encode_packed_fn(uint8_t *d, int32_t *at, const void *const from[3],
                                      ntp__packed_from which, int32_t n, const ntp__encode *e,
                                      bool deep);

/* The same of floats, in any encoding, whatever cx and cy are.  Of rows of heights: of integers, with AVX2. */
typedef int32_t ntp__encode_vectors_fn(float *d, int32_t *at, const void *const from[3],
                                       ntp__packed_from which, int32_t n, const ntp__encode *e);

/* The best for a mask. */
ntp__encode_vectors_fn *ntp__encode_vectors_for(int mask);

/* The same from rows of heights alone, with AVX-512; NULL without. */
ntp__encode_packed_fn *ntp__encode_rows_for(int mask);

/* What of the slopes of floats stands for smaller ones. */
#define NTP__TINY 0x1p-62F

/* What floats of heights add to errors, in units of 2^-16 levels; negative: too much would be in doubt. */
static inline int32_t ntp__off_of_floats(const ntp__encode *e)
{
    static const double units = 1 << 16, most = 1 << 13;
    const double taps = (double) (8 * e->side + 3 * e->middle), cx = e->cx < 0 ? -e->cx : e->cx;
    const double more =
        1.5 * (taps * e->spread * 0x1p-24 + (double) NTP__TINY) * cx * e->half * units;
    return more < most ? 1 + (int32_t) more : -1;
}

/*
 * A step of a wave that dithers rows: a texel of each row, one column farther left than that of the
 * row above.  So none of them needs the errors of another.  Step t holds column t - k of row k.
 */
typedef union ntp__wave_step {
    double slope[2][NTP__WAVE];  /* in: n.x / n.z and n.y / n.z, before min_z; else 0 */
    int32_t level[3][NTP__WAVE]; /* out */
} ntp__wave_step;

/* A part of the rows of a wave has a margin on either side, so that all columns of all steps are in it. */
enum {
    NTP__WAVE_COLUMNS =
        NTP__BLOCK, /* of fewer, steps without a texel of each row are more of all */
    NTP__WAVE_STEPS = NTP__WAVE_COLUMNS + NTP__WAVE,
    NTP__WAVE_PART = NTP__WAVE / 2,
    NTP__WAVE_ROOM = NTP__WAVE_COLUMNS + 2 * NTP__WAVE
};

/* Some rows of a wave, alike; column x is at NTP__WAVE + x.  Where there is none, slopes are 0. */
typedef union ntp__wave_rows {
    double slope[NTP__WAVE_PART][2][NTP__WAVE_ROOM];
    int32_t level[NTP__WAVE_PART][3][NTP__WAVE_ROOM];
} ntp__wave_rows;

/* Too much for the caller's stack. */
typedef struct ntp__wave_memory {
    ntp__wave_step steps[NTP__WAVES][NTP__WAVE_STEPS];
    ntp__wave_rows part;
} ntp__wave_memory;

typedef struct ntp__dithering {
    int32_t m;
    bool zzero;
    double min_z, shortened; /* as in ntp__gradient */
} ntp__dithering;

/* Dithers n <= NTP__WAVE_COLUMNS columns of 1 to NTP__WAVE rows.  along (for each row), down (for each column): in, the
 * errors of the texels before and above; out, those that the last ones leave. */
typedef void ntp__dither_fn(ntp__wave_step *steps, double *along, double *down, int32_t rows,
                            int32_t n, const ntp__dithering *how);

/* The same of 8 bit without min_z, of the rows of all waves: the second one has those after the first. */
typedef void ntp__dither_waves_fn(ntp__wave_step *steps[NTP__WAVES], double *along, double *down,
                                  int32_t rows, int32_t n, bool zzero);

/* Slopes or levels of the rows from `first` on, to n steps or from them.  Up to three steps more, or as
 * many columns, change. */
typedef void ntp__put_slopes_fn(ntp__wave_step *steps, const ntp__wave_rows *from, int32_t first,
                                int32_t n);
typedef void ntp__take_levels_fn(ntp__wave_rows *to, const ntp__wave_step *steps, int32_t first,
                                 int32_t n);

struct ntp__gradient_kernels {
    ntp__tap_sums_i_fn *tap_sums_i;
    ntp__tap_sums_d_fn *tap_sums_d;
    ntp__take_floats_fn *take_floats;
    ntp__encode_i_fn *encode_i;                    /* in float arithmetic */
    ntp__encode_d_fn *encode_d, *encode_precisely; /* in float, in double */
    ntp__encode_vectors_fn *encode_vectors;        /* in double */
    ntp__encode_packed_fn *encode_packed;          /* in float; NULL where planes are as fast */
    ntp__take_heights_fn *take_heights;            /* NULL where that is */
    ntp__dither_fn *dither;
    ntp__put_slopes_fn *put_slopes;
    ntp__take_levels_fn *take_levels;
};

const ntp__gradient_kernels *ntp__gradient_kernels_for(int mask);

/* NULL: without AVX-512 */
ntp__dither_waves_fn *ntp__dither_waves(int mask);

#endif
