/* SPDX-License-Identifier: MIT */
/*
 * libntp.h - normals textures (normal maps): exact conversion, checking, cleaning
 *
 * This header is the manual of the library.  docs/arithmetic.md has the arithmetic with its proofs.
 * It defines in integers the words "derived", "pulled", "exact", "rounded" and "neighbor", which
 * the comments here use.
 *
 * Rules that hold for every function
 *   - No function allocates, keeps state between calls, starts a thread, prints, or reads the
 *     locale.  Memory belongs to the caller.  Where working memory is needed, a function returns
 *     its size.
 *   - Results are the same bytes on every processor and with every compiler.  They do not depend on
 *     how an image is divided into areas: an operation on an area writes what the same operation on
 *     the whole image would write there.
 *   - Two calls may run at the same time, unless one writes memory that the other reads or writes.
 *     Calls on disjoint areas of one destination are safe.
 *   - Arguments are checked before anything is written.  If they are wrong, nothing is written.
 *   - A zero-filled options struct, or NULL in its place, means the defaults.
 *   - The order of arguments is: destination, source, how, where.
 *
 * Words
 *   M       255 for 8-bit samples, 65535 for 16-bit samples
 *   level   a stored integer sample c, 0..M; as a component of a vector it means (2c - M)/M,
 *           and a Z-zero blue means b/M.  V = 2c - M is its odd integer numerator.
 *   texel   a pixel of a texture
 *   used    not pure black, not pure white, and not alpha 0 (see NTP_UNUSED_BLACK)
 *
 * Binary interface: while the major version is 0, the soversion is the minor version, and any minor
 * version may change any struct.  From 1.0 on, structs and enum values are frozen, and new features
 * come as new functions beside the old ones.
 */
#ifndef LIBNTP_H
#define LIBNTP_H

#include <stddef.h>
#include <stdint.h>

#define NTP_VERSION_MAJOR 0
#define NTP_VERSION_MINOR 1
#define NTP_VERSION_PATCH 0

/* Define NTP_STATIC before this header to link with the static library on Windows. */
#if defined(NTP_STATIC)
#  define NTP_API
#elif defined(_WIN32)
#  if defined(NTP_BUILDING)
#    define NTP_API __declspec(dllexport)
#  else
#    define NTP_API __declspec(dllimport)
#  endif
#elif defined(__GNUC__)
#  define NTP_API __attribute__((visibility("default")))
#else
#  define NTP_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* --- cdef begin: no preprocessor below; bindings cut their declarations from here --- */

/* ------------------------------------------------------------------ status and version */

typedef enum ntp_status {
    NTP_OK = 0,
    NTP_ERR_ARGUMENT = 1,  /* NULL, or a value outside its documented range */
    NTP_ERR_SHAPE = 2,     /* a view is malformed, two views do not match, or an area is outside */
    NTP_ERR_FORMAT = 3,    /* the operation cannot read or write this type, encoding or channels */
    NTP_ERR_OVERLAP = 4,   /* dst and src share memory where they may not */
    NTP_ERR_SCRATCH = 5,   /* working memory is NULL, misaligned or too small */
    NTP_ERR_CANCELLED = 6, /* a progress callback asked to stop */
    NTP_ERR_NOT_CONVERGED = 7 /* an iteration ended before it reached its tolerance */
} ntp_status;

/* The version of the library in use: major << 16 | minor << 8 | patch. */
NTP_API uint32_t ntp_version(void);

/* A short English description of a status; never NULL, also for unknown values. */
NTP_API const char *ntp_status_string(ntp_status status);

/* ------------------------------------------------------------------------------- views */

/* How one sample is stored. */
typedef enum ntp_type {
    NTP_TYPE_U8 = 0,  /* 0..255 */
    NTP_TYPE_U16 = 1, /* 0..65535, native byte order */
    NTP_TYPE_F32 =
        2 /* the unit range of the integers, 0..1; for NTP_ENCODING_VECTOR -1..1. Values outside are
           * judged as the nearest end, and an alpha that is NaN as 0 */
} ntp_type;

/* What the samples of a pixel mean. */
typedef enum ntp_encoding {
    NTP_ENCODING_STANDARD = 0, /* x, y, z each stored as (v + 1)/2: glTF, USD, most tools */
    NTP_ENCODING_ZZERO = 1,    /* x, y as above; z, never negative, stored as it is in 0..1 */
    NTP_ENCODING_XY = 2,       /* x, y as above; z is implied; a third sample is other data, kept */
    NTP_ENCODING_VECTOR = 3,   /* x, y, z as they are; NTP_TYPE_F32 only */
    NTP_ENCODING_HEIGHT = 4    /* sample 0 is a height; or the samples are a plain picture */
} ntp_encoding;

/* Which way the y component points. */
typedef enum ntp_y {
    NTP_Y_UP = 0,  /* up the picture: OpenGL, glTF, USD */
    NTP_Y_DOWN = 1 /* down the picture: DirectX */
} ntp_y;

enum {
    NTP_MAX_SIDE = 65535 /* the greatest width and height of a view */
};

/*
 * A view of pixels that the caller owns.  The samples of a pixel are adjacent.  Pixels and rows may
 * have any stride, so a crop, a mirrored image or one channel of an RGBA image is a view too.  Row
 * 0 is the top of the picture.  data and both strides are multiples of the sample's size.
 *
 * Channels: NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO and NTP_ENCODING_VECTOR have 3 or 4,
 * NTP_ENCODING_XY 2 to 4, NTP_ENCODING_HEIGHT 1 to 4. The second of two NTP_ENCODING_HEIGHT samples
 * and the fourth of four are alpha.
 *
 * ring_rows: 0 if every row is in memory.  Otherwise only this many rows are, with row y at data +
 * (y mod ring_rows) * row_stride.  A call then reads and writes only the rows of its area and,
 * where the operation says so, their neighbors; these have to be in memory.  So a caller can
 * process an image of any height with a few rows in memory, and use its true coordinates.
 */
typedef struct ntp_image {
    void *data;             /* sample 0 of pixel (0, 0) */
    ptrdiff_t row_stride;   /* bytes from a row to the next; may be negative */
    ptrdiff_t pixel_stride; /* bytes from a pixel to the next; may be negative */
    int32_t width;          /* 1..NTP_MAX_SIDE, as is height */
    int32_t height;
    int32_t channels; /* samples of each pixel in this view, 1..4 */
    int32_t ring_rows;
    ntp_type type;
    ntp_encoding encoding;
    ntp_y y;
} ntp_image;

/* The same, read only. */
typedef struct ntp_const_image {
    const void *data;
    ptrdiff_t row_stride;
    ptrdiff_t pixel_stride;
    int32_t width;
    int32_t height;
    int32_t channels;
    int32_t ring_rows;
    ntp_type type;
    ntp_encoding encoding;
    ntp_y y;
} ntp_const_image;

/* x0 <= x < x1, y0 <= y < y1, inside the view and not empty. */
typedef struct ntp_rect {
    int32_t x0, y0, x1, y1;
} ntp_rect;

/* A view of rows without gaps, Y up, encoding NTP_ENCODING_STANDARD (NTP_ENCODING_XY for 2
 * channels, NTP_ENCODING_HEIGHT for 1).  This function checks nothing; every operation checks the
 * views that it is given. */
NTP_API ntp_image ntp_image_packed(void *data, int32_t width, int32_t height, int32_t channels,
                                   ntp_type type);

/* The same view, read only.  image is not NULL. */
NTP_API ntp_const_image ntp_image_as_const(const ntp_image *image);

/*
 * Texels that hold no normal: atlases are padded with them.  They are left alone and counted
 * separately.  A mask of these values in a field `touch_unused` makes operations treat such texels
 * like any other.
 */
enum {
    NTP_UNUSED_BLACK = 1,       /* all samples but alpha are 0 */
    NTP_UNUSED_WHITE = 2,       /* all samples but alpha are M */
    NTP_UNUSED_TRANSPARENT = 4, /* alpha is 0; set it in touch_unused if alpha is a height */
    NTP_UNUSED_ALL = 7
};

/*
 * In every operation below, `area` NULL means the whole image, and dst and src have the same size
 * (else NTP_ERR_SHAPE) unless the operation says otherwise.  Every operation can report a malformed
 * view or a NULL; only other errors are listed.
 */

/* --------------------------------------------------------------- validity of one texel */

/*
 * Three degrees of strictness, all in integers; exact implies rounded implies neighbor.  They
 * ignore the sign of Z, which is a flag.  For NTP_ENCODING_XY all three require only that x, y are
 * not longer than 1.
 */
typedef enum ntp_verdict {
    NTP_VERDICT_NEIGHBOR =
        0, /* of the 27 triplets at -1, 0, +1 level one is not longer than 1, one not shorter */
    NTP_VERDICT_ROUNDED = 1, /* the +-1/2-level box meets the unit sphere: correctly rounded */
    NTP_VERDICT_EXACT = 2    /* blue is the one derived from red and green */
} ntp_verdict;

/* One byte per texel, as ntp_validate writes it. */
enum {
    NTP_FLAG_NEIGHBOR = 1,
    NTP_FLAG_ROUNDED = 2,
    NTP_FLAG_EXACT = 4,       /* either sign of Z when keep_negative_z */
    NTP_FLAG_XY_TOO_LONG = 8, /* x*x + y*y > 1 */
    NTP_FLAG_Z_NEGATIVE = 16, /* NTP_ENCODING_STANDARD and NTP_ENCODING_VECTOR: z < 0 */
    NTP_FLAG_UNUSED = 32,     /* black, white or transparent; the other bits are set too */
    NTP_FLAG_NOT_FINITE = 64  /* floats that are no vector: NaN, infinite, or x, y, z of length 0;
                               * no pass bit is set */
};

/* Everything about one texel. */
typedef struct ntp_texel {
    uint32_t stored[4];  /* levels; float images rounded to 16 bit; absent alpha is M */
    uint32_t cleaned[3]; /* as by NTP_CLEAN_DERIVE; NTP_ENCODING_XY keeps its blue */
    uint32_t max;        /* M: 255 or 65535 */
    uint32_t flags;      /* as ntp_validate */
    int32_t levels_off;  /* |b - derived b|, mirrored where z < 0; -1: x, y too long, or
                         * NTP_FLAG_NOT_FINITE */
    double x, y, z;      /* as stored; NTP_ENCODING_XY: z derived, 0 where x, y are too long */
    double length;       /* of x, y, z */
    double angle;        /* degrees between stored and cleaned vector, to 1e-6; 0 too for
                         * NTP_FLAG_NOT_FINITE */
} ntp_texel;

/*
 * Describes the texel at (x, y).  src is NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO, NTP_ENCODING_XY
 * or NTP_ENCODING_VECTOR.
 * Errors: NTP_ERR_ARGUMENT for coordinates outside, and those of a view.
 */
NTP_API ntp_status ntp_inspect(ntp_texel *texel, const ntp_const_image *src, int32_t x, int32_t y,
                               int32_t keep_negative_z);

/*
 * Writes the flags of each texel into sample 0 of mask, a view of NTP_TYPE_U8; further samples are
 * left alone.  keep_negative_z: NTP_FLAG_EXACT accepts the mirrored blue of a negative Z. mask does
 * not overlap src.  Errors: NTP_ERR_FORMAT for a mask that is not NTP_TYPE_U8, or a src of
 * NTP_ENCODING_HEIGHT.
 */
NTP_API ntp_status ntp_validate(const ntp_image *mask, const ntp_const_image *src,
                                int32_t keep_negative_z, const ntp_rect *area);

/* ---------------------------------------------------------------------------- cleaning */

typedef enum ntp_clean_method {
    NTP_CLEAN_DERIVE = 0,    /* keep x, y (pulled onto the unit disc where too long), derive z */
    NTP_CLEAN_NORMALIZE = 1, /* a texel that is not `rounded` is divided by its length */
    NTP_CLEAN_KEEP = 2       /* mirror negative Z only */
} ntp_clean_method;

/* Zero, NTP_CLEAN_DERIVE, is right where nothing was measured.  The recommended method is that of
 * ntp_choose_method, which `ntp clean` takes by default. */

typedef struct ntp_clean_options {
    ntp_clean_method method;
    int32_t keep_negative_z; /* nonzero: a negative Z stays negative; otherwise b becomes M - b
                              * first */
    int32_t only_failing;    /* nonzero: texels that pass `verdict`, and are not negative, stay */
    ntp_verdict verdict;
    uint32_t touch_unused; /* NTP_UNUSED_*: repair such texels too */
} ntp_clean_options;

/* Operations add to these; the caller zeroes them once. */
typedef struct ntp_clean_counts {
    uint64_t changed;    /* texels of which a sample changed */
    uint64_t not_finite; /* float texels with a NaN, an infinity or length 0: made flat */
} ntp_clean_counts;

/*
 * A table that makes cleaning 8-bit images as fast as copying them.  It is opaque, in memory of the
 * caller.  ntp_clean gives the same bytes with and without one.
 */
typedef struct ntp_clean_plan ntp_clean_plan;

/* Bytes of a plan (about 320 KiB). */
NTP_API size_t ntp_clean_plan_size(void);

/*
 * Fills memory of at least ntp_clean_plan_size() bytes, aligned to 16, with the table for images of
 * NTP_TYPE_U8 with this encoding and these options.  Returns it through *plan.  The plan is
 * read-only afterwards, so any number of threads may share it.
 * Errors: NTP_ERR_ARGUMENT for an encoding other than NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO and
 * NTP_ENCODING_XY; NTP_ERR_SCRATCH for the memory.
 */
NTP_API ntp_status ntp_clean_plan_init(ntp_clean_plan **plan, void *memory, size_t size,
                                       ntp_encoding encoding, const ntp_clean_options *how);

/*
 * Repairs normals.  dst and src have the same size, type, encoding, channels and y. They are the
 * same memory with the same strides, or do not overlap (overlap is not detected).  Encodings:
 * NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO, NTP_ENCODING_XY (blue is kept, it is not Z) and
 * NTP_ENCODING_VECTOR.  Alpha is copied.  Float images are judged and repaired on the 16-bit grid:
 * a texel that passes is copied as it is, any other gets the repaired levels divided by 65535.
 * Cleaning a second time changes nothing, for every method and option.  plan may be NULL; otherwise
 * it must have been made for this encoding and `how` (else NTP_ERR_ARGUMENT).  how and counts may
 * be NULL.
 * Errors: NTP_ERR_FORMAT if dst and src do not match, or for NTP_ENCODING_HEIGHT.
 * Source of the test and of derived Z: Eric Haines, NormalTextureProcessor (2024).
 */
NTP_API ntp_status ntp_clean(const ntp_image *dst, const ntp_const_image *src,
                             const ntp_clean_options *how, const ntp_clean_plan *plan,
                             ntp_clean_counts *counts, const ntp_rect *area);

/* -------------------------------------------------------------------------- conversion */

typedef enum ntp_blue {
    NTP_BLUE_DERIVED = 0, /* from the rounded red and green: survives any round trip */
    NTP_BLUE_NEAREST = 1  /* z is rounded independently */
} ntp_blue;

typedef struct ntp_convert_options {
    ntp_blue blue;         /* from NTP_ENCODING_VECTOR only */
    uint32_t touch_unused; /* NTP_UNUSED_*: convert and flip such texels too */
} ntp_convert_options;

/* Operations add to these; the caller zeroes them once. */
typedef struct ntp_convert_counts {
    uint64_t z_negative; /* texels whose negative z became |z| */
    uint64_t not_finite; /* float texels with NaN, infinity or length 0: made flat (a height: 0) */
    uint64_t pulled;     /* texels whose x, y were pulled onto the unit disc, as they were longer
                          * than 1 in the target's depth, or in the source if it has no z */
} ntp_convert_counts;

/*
 * Converts between any two of the normals encodings, types and Y orientations, or a height between
 * types.  It repairs nothing: each sample is converted by value and correctly rounded (8 to 16 bit
 * 257c, 16 to 8 bit round(c/257)), and a Y flip is M - g. However, a texel that is `exact` (either
 * sign of Z) gets its blue derived again in the target's depth and encoding, so that a clean
 * texture stays clean.  XY-only sources get a derived blue; an XY target of 3 or 4 channels gets
 * blue M, unless the source is XY-only and has one.  NTP_ENCODING_VECTOR sources are divided by
 * their length, but copied to NTP_ENCODING_VECTOR.  A missing alpha is opaque.  Unused texels keep
 * their color (black stays black).  dst and src do not overlap, or are the same view of the same
 * type.  how and counts may be NULL.
 * Errors: NTP_ERR_FORMAT between heights and normals, or heights of different channels;
 * NTP_ERR_OVERLAP for different types at one address (no other overlap is detected).
 */
NTP_API ntp_status ntp_convert(const ntp_image *dst, const ntp_const_image *src,
                               const ntp_convert_options *how, ntp_convert_counts *counts,
                               const ntp_rect *area);

/* ----------------------------------------------------------------------- measurement */

/*
 * The tally of a measurement: memory of ntp_tally_size() bytes, aligned to 16, zero-filled (calloc)
 * and freed by the caller.  It holds only integer counts and sums, so the tallies of parts merge
 * exactly, in any order.  It holds up to 2^32 - 1 texels of one depth.
 * It takes 22 MB of address space, of which most stays untouched: memory from calloc costs only
 * what is touched.  A clean texture of any size takes up to 1 MB (16 bit: 0.7 MB), a damaged one of
 * 8 bit about 3.5 MB, noise 4 MB, and up to 6 MB where many of its colors are frequent, 11 MB where
 * these have 65536 texels and more.  A cleared tally keeps what it has touched.
 * Nearly all that a clean texture touches is in the first 2 MiB (8 bit), or in the 2 MiB from 12 MiB on (16 bit):
 * where memory begins at a multiple of 2 MiB, one large page may be cheaper than their page faults.
 */
typedef struct ntp_tally ntp_tally;

NTP_API size_t ntp_tally_size(void);

/* Makes a used tally empty again, faster than zeroing all of it. */
NTP_API ntp_status ntp_tally_clear(ntp_tally *tally);

/*
 * Adds the texels of an area to the tally, in one pass.  src is NTP_ENCODING_STANDARD,
 * NTP_ENCODING_ZZERO, NTP_ENCODING_XY or NTP_ENCODING_VECTOR of 2 to 4 channels, or
 * NTP_ENCODING_HEIGHT (then only the facts of each channel are measured).  Float images are judged
 * after rounding to 16 bit.  The encoding matters only for the angles of 16-bit images: everything
 * else is counted for all encodings at once.  To measure an image in parts, use areas of one view
 * (with ring_rows if only some rows are in memory).
 * Errors: NTP_ERR_FORMAT if the tally already holds another depth, channel count, encoding or
 * touch_unused; NTP_ERR_SHAPE if it would hold more than 2^32 - 1 texels.
 */
NTP_API ntp_status ntp_tally_add(ntp_tally *tally, const ntp_const_image *src,
                                 uint32_t touch_unused, const ntp_rect *area);

/* Adds what `from` holds to `into`.  Errors as ntp_tally_add. */
NTP_API ntp_status ntp_tally_merge(ntp_tally *into, const ntp_tally *from);

/* Results for the texels when read as one encoding.  Counts cover every texel. */
typedef struct ntp_fit {
    uint64_t neighbor, rounded, exact; /* texels that pass */
    uint64_t exact_mirrored;           /* texels whose blue is M - derived blue, Z < 0 */
    uint64_t unused_neighbor, unused_rounded, unused_exact; /* the unused among them */
    uint64_t used_levels_le[4]; /* used texels with x, y not too long and blue off by <= 0,1,2,3 */
    double length_min, length_mean, length_max; /* every texel */
} ntp_fit;

/* Per-channel facts, in levels, over every texel. */
typedef struct ntp_channel {
    uint32_t min, max;
    double mean;
} ntp_channel;

/* Angles in degrees, over used texels; the histogram behind p99 has bins of 0.001. */
typedef struct ntp_angles {
    uint64_t texels;
    double mean, p99, max;
} ntp_angles;

/* The results of a tally; see ntp_tally_summarize. */
typedef struct ntp_stats {
    uint64_t texels;
    uint64_t unused; /* black + white + transparent, each texel once, in this order */
    uint64_t black, white, transparent;
    uint64_t not_finite;
    uint32_t max;        /* M the texels were judged at */
    uint32_t stored_max; /* M of the samples; 65535 with max 255: 16 bit with 8-bit content */
    int32_t channels;
    ntp_channel channel[4];
    uint64_t xy_too_long;       /* X*X + Y*Y > M*M */
    uint64_t xy_far_too_long;   /* the reference program's limit: |(x,y)| > 1.00774 */
    uint64_t neighbor_and_near; /* standard `neighbor` and within that limit */
    uint64_t z_negative;        /* read as standard */
    uint64_t unused_xy_too_long;
    uint64_t unused_z_negative;
    /* Used texels that are padding of one color other than black and white: red and green both lie
     * within 15/255 of an end, so that x, y are far too long.  They fail every verdict, and are
     * left out of used_mean and ntp_harm.  0 if they have many colors or are fewer than one texel
     * in 64, for then they may be damage. */
    uint64_t padding;
    uint64_t padding_z_negative;
    uint64_t gray;                   /* all of r, g, b equal; transparent texels are left out */
    uint64_t flat;                   /* used texels with r and g both (M-1)/2 or (M+1)/2 */
    uint64_t distinct_flat;          /* different colors among them */
    uint64_t distinct;               /* different used colors, counted up to 2; see also flat */
    uint64_t levels_off_max[2];      /* standard, Z-zero; used texels */
    uint64_t alpha_zero, alpha_full; /* texels with alpha 0, alpha M; 0 without alpha */
    ntp_fit standard, zzero;
    ntp_angles angles; /* stored against cleaned, by the encoding measured */
    /* From sampled rows, which are all of an image below 128 rows, fewer of a larger one, at least
     * 64; the count is scaled to all used texels.  Exact are the mean of alpha, and the others
     * unless there are transparent texels or `padding`. */
    double used_mean[4];      /* levels / M */
    uint64_t near_gamma_flat; /* used texels whose r, g are within 3/255 of 188/255 */
} ntp_stats;

/*
 * Computes the results of a tally, read as `encoding` (NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO or
 * NTP_ENCODING_XY; it decides the angles).  A 16-bit tally in which every level is a multiple of
 * 257 is judged as 8 bit.  Any other 16-bit tally has the angles only of the encoding that was
 * measured, else NTP_ERR_FORMAT.  An empty tally is NTP_ERR_ARGUMENT.  Working memory is in the
 * tally: one call at a time.
 */
NTP_API ntp_status ntp_tally_summarize(ntp_stats *stats, ntp_tally *tally, ntp_encoding encoding);

/*
 * The histogram of ntp_texel.levels_off over every texel with x, y not too long, read as
 * NTP_ENCODING_STANDARD or NTP_ENCODING_ZZERO: counts[0..stats.max].  counts has room for `size`
 * numbers.  Fewer than stats.max + 1 are enough if no texel is further off (else NTP_ERR_ARGUMENT).
 */
NTP_API ntp_status ntp_tally_levels_off(uint64_t *counts, size_t size, ntp_tally *tally,
                                        ntp_encoding encoding);

/*
 * The histogram of lengths of every texel, read as NTP_ENCODING_STANDARD or NTP_ENCODING_ZZERO: bin
 * i is i/128..(i+1)/128, and the last is open.
 */
NTP_API ntp_status ntp_tally_lengths(uint64_t counts[256], ntp_tally *tally, ntp_encoding encoding);

/* How a texel can be wrong by more than rounding; a mask.  Each texel is of one kind at most. */
enum {
    NTP_HARM_LENGTH = 1, /* it fails NTP_VERDICT_NEIGHBOR */
    NTP_HARM_XY = 2,     /* x, y are too long even with r and g one level nearer to the middle */
    NTP_HARM_Z_NEGATIVE = 4, /* standard: blue is below (M-1)/2; such a texel is of no other kind */
    NTP_HARM_ALL = 7
};

/*
 * What is shown wrong by texels that are wrong by more than rounding.  The angle of a texel is that
 * between the stored vector and the cleaned one (NTP_CLEAN_DERIVE), that is between what a shader
 * shows that normalizes and one that derives z.  Where z is negative, it is that between the vector
 * and its mirror image.  Read as NTP_ENCODING_XY it is how far x, y lie
 * outside the unit circle, in degrees of an arc of that length.
 */
typedef struct ntp_harm {
    uint64_t texels; /* used texels of these kinds */
    uint64_t over;   /* those with an angle of more than `degrees`, taken to 0.01 */
    /* Degrees, over all used texels but padding; those of no such kind count as 0. */
    double mean, p99, max;
} ntp_harm;

/*
 * Computes the harm of some kinds, read as `encoding` (see ntp_tally_summarize, also for errors;
 * NTP_ENCODING_XY has NTP_HARM_XY only).  degrees is 0..180.  Working memory is in the tally.
 */
NTP_API ntp_status ntp_tally_harm(ntp_harm *harm, ntp_tally *tally, ntp_encoding encoding,
                                  uint32_t kinds, double degrees);

/* ---------------------------------------------------------------------- classification */

typedef enum ntp_class {
    NTP_CLASS_STANDARD = 0,
    NTP_CLASS_ZZERO = 1,
    NTP_CLASS_XY = 2,
    NTP_CLASS_HEIGHT = 3,
    NTP_CLASS_OBJECT_SPACE = 4,
    NTP_CLASS_ONE_COLOR = 5,
    NTP_CLASS_NOT_NORMALS = 6
} ntp_class;

/* What was done to a texture, as far as its texels show it; a mask. */
enum {
    NTP_ACCIDENT_GAMMA = 1,      /* stored as sRGB: flat lies near 188 */
    NTP_ACCIDENT_RED_IS_Z = 2,   /* red and blue swapped */
    NTP_ACCIDENT_GREEN_IS_Z = 4, /* green and blue swapped */
    NTP_ACCIDENT_DXT5NM = 8,     /* x in alpha, y in green */
    NTP_ACCIDENT_LOSSY = 16,     /* the traces of lossy compression (JPEG, WebP, BCn) */
    NTP_ACCIDENT_FILTERED = 32,  /* resized or blurred without normalizing: too short */
    NTP_ACCIDENT_Z_FLIPPED = 64, /* Z negative (almost) everywhere */
    NTP_ACCIDENT_BLUE_CONSTANT = 128
};

/* The facts that reasons state, with their numbers in brackets. */
enum {
    NTP_REASON_NONE = 0,
    NTP_REASON_NOTHING_USED = 1,      /* only black, white and transparent texels */
    NTP_REASON_ONE_COLOR = 2,         /* of all used texels */
    NTP_REASON_GRAY = 3,              /* [share of used texels with r = g = b] */
    NTP_REASON_GRAY_FILE = 4,         /* one channel, or gray and alpha */
    NTP_REASON_TWO_CHANNELS = 5,      /* red and green only */
    NTP_REASON_UNIT = 6,              /* [share that is a unit vector to within a level] */
    NTP_REASON_UNIT_ZZERO = 7,        /* the same with blue as 0..1 */
    NTP_REASON_NEAR_UNIT = 8,         /* [share with a length of 1 to within 1/8] */
    NTP_REASON_NEAR_UNIT_ZZERO = 9,   /* the same with blue as 0..1 */
    NTP_REASON_NOT_UNIT = 10,         /* [share with a length of 1 to within 1/8], small */
    NTP_REASON_PREFERS_STANDARD = 11, /* [share of the tilted texels whose blue fits] */
    NTP_REASON_PREFERS_ZZERO = 12,    /* [the same] */
    NTP_REASON_UNDECIDED_ZZERO = 13,  /* both readings of blue fit equally well */
    NTP_REASON_XY_CENTERED = 14,      /* [length of the mean of x, y], small */
    NTP_REASON_XY_OFF_CENTER = 15,    /* [length of the mean of x, y], large */
    NTP_REASON_XY_TOO_LONG = 16,      /* [share of used texels with x, y longer than 1] */
    NTP_REASON_BLUE_CONSTANT = 17,    /* [blue, 0..1] */
    NTP_REASON_BLUE_UNRELATED = 18,   /* [share of tilted texels whose blue is the z of r, g] */
    NTP_REASON_Z_NEGATIVE = 19,       /* [share of used texels with z < 0] */
    NTP_REASON_ALL_DIRECTIONS = 20,   /* [share of used texels with z < 0] */
    NTP_REASON_GAMMA = 21,            /* [share with unit length once sRGB is decoded] */
    NTP_REASON_GAMMA_FLAT = 22,       /* [share of used texels near (188, 188)] */
    NTP_REASON_RED_IS_Z = 23,         /* [share of used texels with red above one half] */
    NTP_REASON_GREEN_IS_Z = 24,       /* [share of used texels with green above one half] */
    NTP_REASON_DXT5NM = 25,           /* [share with alpha, green not longer than 1] */
    NTP_REASON_BLOCKS = 26,           /* [steps across columns 8k-1|8k over those elsewhere] */
    NTP_REASON_SHORT = 27,            /* [share of used texels that are too short] */
    NTP_REASON_COLORS_ALIKE = 28,     /* [correlation of red and green] */
    NTP_REASON_ALL_ROUNDED = 29,      /* every used texel is a correctly rounded unit vector */
    NTP_REASON_LOSSY_FILE = 30,       /* the file format is lossy */
    NTP_REASON_ALL_CHANNELS = 31,     /* [mean length error of steep texels over that of shallow] */
    NTP_REASON_Z_ALONE = 32,          /* [the same, small] */
    NTP_REASON_FEW_WRONG = 33,        /* [share of used texels that are wrong by much] */
    NTP_REASON_XY_ONLY = 34,          /* blue is not z */
    NTP_REASON_TOO_FLAT = 35,         /* so flat that both methods give about the same */
    NTP_REASON_LONG = 36,             /* [share of used texels that are too long] */
    NTP_REASON_ALL_ALIKE = 37,        /* [correlation of blue with red or green, the smaller] */
    NTP_REASON_FOLLOWS = 38,          /* [correlation of blue with the derived blue] */
    /* Against the answer: */
    NTP_REASON_DESPITE_ALIKE = 39, /* [correlation of red and green] */
    /* For it: */
    NTP_REASON_BLUE_IDLE = 40,  /* [mean blue, 0..1] */
    NTP_REASON_BRIGHTNESS = 41, /* [correlation of blue with red or green, the greater] */
    NTP_REASON_NOISE = 42,      /* [mean of all channels, 0..1] */
    NTP_REASON_ZZERO_MEANS = 43 /* [ratio of mean drops of blue; 2 in 0..1] */
};

/* A fact that supports a classification, with its number. */
typedef struct ntp_reason {
    int32_t code; /* NTP_REASON_* */
    double value;
} ntp_reason;

enum { NTP_MAX_REASONS = 6 };

typedef struct ntp_classification {
    ntp_class type;
    double confidence; /* 0..1; 0.5: two classes are equally likely */
    uint32_t accidents;
    int32_t reason_count;
    ntp_reason reasons[NTP_MAX_REASONS]; /* the most important first */
} ntp_classification;

/*
 * Says what a texture is, from its tally; docs/classification.md has the rules.  Best-fit normals
 * (CryEngine) are not distinguished.  Working memory is in the tally: one call at a time.  An empty
 * tally is NTP_ERR_ARGUMENT.
 */
NTP_API ntp_status ntp_classify(ntp_classification *result, ntp_tally *tally);

/* The name of a class as the command line prints it ("standard", "zzero", ...); never NULL. */
NTP_API const char *ntp_class_name(ntp_class type);

/* Writes a reason as an English clause, number included, as snprintf would: at most size - 1
 * bytes and a terminating 0; returns the full length.  text may be NULL to ask for the length. */
NTP_API size_t ntp_reason_text(char *text, size_t size, const ntp_reason *reason);

/*
 * Chooses the cleaning method by the errors of a texture: NTP_CLEAN_KEEP if every used texel is
 * `rounded`, NTP_CLEAN_NORMALIZE if all three channels are off (as after lossy compression or
 * resizing), NTP_CLEAN_DERIVE otherwise.  lossy: the file format is known to be lossy.  *why (may
 * be NULL) gets the reason, for ntp_reason_text.  encoding is NTP_ENCODING_STANDARD,
 * NTP_ENCODING_ZZERO or NTP_ENCODING_XY, and need not be the one that was measured.  The tally is
 * used as in ntp_classify.
 */
NTP_API ntp_status ntp_choose_method(ntp_clean_method *method, ntp_reason *why, ntp_tally *tally,
                                     ntp_encoding encoding, int32_t lossy);

/* ---------------------------------------------------------------------------- pictures */

typedef enum ntp_palette {
    NTP_PALETTE_REFERENCE = 0, /* red: x, y too long; green: wrong length; blue: negative z */
    NTP_PALETTE_SAFE = 1       /* three hues that color-blind people can tell apart too */
} ntp_palette;

/*
 * In the functions below, dst (heat) is NTP_TYPE_U8 with encoding NTP_ENCODING_HEIGHT and 3 or 4
 * channels; alpha becomes opaque.  It does not overlap the source, or is the same 8-bit memory with
 * the same strides.
 *
 * Shows in a picture which texels are wrong; docs/heatmap.md is the legend.  A level is 2/M.
 * Reference palette:
 *   red    |(x, y)| > 1: 128; by more than one level: 255
 *   green  | |(x, y, z)| - 1 | of at least two levels: 128; of at least three: 255.  Where x, y
 *          are longer than 1, they are first pulled onto the disc, so that green is about z
 *   blue   z < 0 (NTP_ENCODING_STANDARD, NTP_ENCODING_VECTOR): M - b in 8 bit: 128 just below 0,
 *          255 at -1
 *   gray   no fault, or unused: 100 + luma/2, luma 0..255 by Rec. 709 of the stored levels
 * The safe palette has one hue for each texel, that of its first fault in this order: z < 0, yellow
 * (240, 228, 66); x, y too long, vermilion (213, 94, 0); length, sky blue (86, 180, 233).  The hue
 * is multiplied by the fault's value above / 255.  For NTP_ENCODING_XY only x, y are judged.
 * Floats are judged as 16-bit levels; those that are not a vector
 * (NaN, infinite, length 0) are white.
 */
NTP_API ntp_status ntp_heatmap(const ntp_image *dst, const ntp_const_image *src,
                               ntp_palette palette, uint32_t touch_unused, const ntp_rect *area);

typedef struct ntp_light {
    double direction[3]; /* towards the light: x right, y up, z to the viewer; any length but 0 */
    double ambient;      /* 0..1 */
    double diffuse;      /* 0..1 */
    double specular;     /* 0..1; Blinn-Phong, exponent 32 */
    double color[3];     /* of the plane, 0..1, linear */
} ntp_light;

/*
 * Shows a plane with these normals, lit from a direction l and seen from straight above: for
 * previews and thumbnails.  With n the stored vector divided by its length (NTP_ENCODING_XY: z
 * derived, 0 where x, y are too long; y down is turned up) and h halfway between l and the viewer,
 * each channel is
 *   color (ambient + diffuse (n.l)) + specular (n.h)^32
 * where negative n.l and n.h count as 0, and there is no specular part where n.l is not above 0.
 * The square root of this (gamma 2) is mapped to 0..255.  dst is as in ntp_heatmap, or has 1
 * channel, which gets the Rec. 709 luminance.  Unused texels, and floats that are not a vector,
 * show a dark checker of 8 x 8 texels.
 * light NULL or zero-filled: direction (-1, 1, 1.2), the upper left; ambient 0.1, diffuse 0.9,
 * specular 0.2, color 0.6.
 */
NTP_API ntp_status ntp_shade(const ntp_image *dst, const ntp_const_image *src,
                             const ntp_light *light, const ntp_rect *area);

/* Differences between two textures.  The sums are integers, so parts add up exactly. */
typedef struct ntp_diff ntp_diff;

/* Bytes of an ntp_diff (about 700 KiB): zero-filled by the caller, aligned to 16.  How much of
 * it is touched depends on how many different angles occur: one page if nothing differs. */
NTP_API size_t ntp_diff_size(void);

typedef struct ntp_diff_stats {
    uint64_t texels;
    uint64_t different; /* texels in which a compared sample differs */
    uint32_t max;       /* M of the levels below, which is that of the deeper image */
    int32_t channels;   /* compared: the smaller number of the two; 2 if one is NTP_ENCODING_XY */
    uint32_t levels_max[4]; /* greatest and mean |difference| of each channel */
    double levels_mean[4];
    ntp_angles angles; /* between the two vectors, over all texels; none for NTP_ENCODING_HEIGHT */
} ntp_diff_stats;

/*
 * Adds the differences between a and b, which have the same size and may differ in type, encoding
 * and y. For the levels, b is converted to the encoding and y of a as by ntp_convert at the depth
 * of b; if the other image is deeper, 8-bit levels are then multiplied by 257.  Angles are between
 * the vectors as stored (NTP_ENCODING_XY: z derived, 0 where x, y are too long).  Texels that are
 * unused in both are 0 degrees apart.  Floats are rounded to 16 bit; those that are not a vector
 * count as flat, and as different from a vector.  Two NTP_ENCODING_HEIGHT views with the same
 * channels are compared in levels only.
 * heat: NULL, or a picture as in ntp_heatmap.  It is black where levels and vectors are equal, and
 * goes from blue (0 degrees) through green (5) to red (10 and more), linearly in the angle.  For
 * heights a difference of M counts as 180 degrees.
 * Errors: NTP_ERR_FORMAT if diff already holds another depth, channel count or kind; NTP_ERR_SHAPE
 * if it would hold more than 2^32 - 1 texels.
 */
NTP_API ntp_status ntp_diff_add(ntp_diff *diff, const ntp_image *heat, const ntp_const_image *a,
                                const ntp_const_image *b, const ntp_rect *area);

/* Adds what `from` holds to `into`.  Errors as ntp_diff_add. */
NTP_API ntp_status ntp_diff_merge(ntp_diff *into, const ntp_diff *from);

/* Makes a used diff empty again, faster than zeroing all of it. */
NTP_API ntp_status ntp_diff_clear(ntp_diff *diff);

/* The sums as numbers.  An empty diff is NTP_ERR_ARGUMENT. */
NTP_API ntp_status ntp_diff_summarize(ntp_diff_stats *stats, const ntp_diff *diff);

/* --------------------------------------------------------------- heightfield -> normals */

/* How a slope is computed.  Each has gain 1 on a ramp, so none is stronger.  Radius 1 to 4. */
typedef enum ntp_kernel {
    NTP_KERNEL_CENTRAL = 0,
    NTP_KERNEL_FORWARD = 1, /* to the next texel on the right and below */
    NTP_KERNEL_PREWITT3 = 2,
    NTP_KERNEL_SOBEL3 = 3,
    NTP_KERNEL_SCHARR3 = 4,
    NTP_KERNEL_PREWITT5 = 5,
    NTP_KERNEL_SOBEL5 = 6,
    NTP_KERNEL_GIMP5 = 7, /* those of the gimp-normalmap plug-in */
    NTP_KERNEL_GIMP7 = 8,
    NTP_KERNEL_GIMP9 = 9,
    NTP_KERNEL_BAKED =
        10 /* slopes of a surface at the texel centers, without a stencil: ntp_height_from_normals
            * only */
} ntp_kernel;

/* The height beyond an edge.  The two axes are independent. */
typedef enum ntp_border {
    NTP_BORDER_WRAP = 0,        /* the opposite end: for textures that tile */
    NTP_BORDER_CLAMP = 1,       /* the texel at the edge */
    NTP_BORDER_MIRROR = 2,      /* reflected about the texel at the edge */
    NTP_BORDER_EXTRAPOLATE = 3, /* the line through the last two texels */
    NTP_BORDER_REPEAT_SLOPE = 4 /* the slope of the nearest texel whose stencil lies inside */
} ntp_border;

/* What of a pixel is the height.  Gray pixels count as r = g = b. */
typedef enum ntp_height_source {
    NTP_HEIGHT_SOURCE_RED = 0,
    NTP_HEIGHT_SOURCE_GREEN = 1,
    NTP_HEIGHT_SOURCE_BLUE = 2,
    NTP_HEIGHT_SOURCE_ALPHA = 3,
    NTP_HEIGHT_SOURCE_LUMA = 4, /* 0.2126 r + 0.7152 g + 0.0722 b of the stored numbers: Rec. 709 */
    NTP_HEIGHT_SOURCE_LUMA_GIMP = 5,   /* 0.3, 0.59, 0.11: gimp-normalmap */
    NTP_HEIGHT_SOURCE_LUMA_EBERLY = 6, /* 0.2125, 0.7154, 0.0721 */
    NTP_HEIGHT_SOURCE_MEAN = 7,
    NTP_HEIGHT_SOURCE_MAX = 8,
    NTP_HEIGHT_SOURCE_MIN = 9,
    NTP_HEIGHT_SOURCE_SCREEN = 10 /* 1 - (1 - r)(1 - g)(1 - b) */
} ntp_height_source;

/* What becomes of the alpha of dst. */
typedef enum ntp_alpha {
    NTP_ALPHA_KEEP = 0, /* that of src by value, opaque if it has none */
    NTP_ALPHA_ONE = 1,
    NTP_ALPHA_INVERSE = 2, /* 1 - that of src */
    NTP_ALPHA_HEIGHT = 3,  /* the height from which the normals are made (LabPBR) */
    NTP_ALPHA_INVERSE_HEIGHT = 4
} ntp_alpha;

typedef struct ntp_normals_options {
    double scale; /* how many texels a height of 1 rises; 0 is flat, negative inverts */
    double dx;    /* spacing of texels; 0 stands for 1 */
    double dy;
    double min_z; /* 0..1: where z would be less, x and y are shortened to sqrt(1 - min_z^2) */
    ntp_kernel kernel;
    ntp_border border_x;
    ntp_border border_y;
    ntp_height_source source;
    ntp_blue blue;
    ntp_alpha alpha;
    int32_t invert; /* nonzero: a height h is 1 - h */
} ntp_normals_options;

/* Operations add to these; the caller zeroes them once. */
typedef struct ntp_normals_counts {
    uint64_t not_finite; /* float heights: texels with a NaN or infinity under the stencil; they
                          * become flat */
    uint64_t exact;      /* texels whose rounding needed more precision than a double */
} ntp_normals_counts;

/*
 * Normals of a heightfield: n = (-p, -q, 1) / sqrt(1 + p*p + q*q), p and q the slopes to the right
 * and up the picture.  Red and green are the correctly rounded encodings of n.x and n.y, rounded
 * half up, for every input; blue is derived from them (a pair that is too long after rounding is
 * pulled onto the disc) or, with NTP_BLUE_NEAREST, n.z is rounded independently.  src is
 * NTP_ENCODING_HEIGHT of 1 to 4 channels; dst is NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO,
 * NTP_ENCODING_XY (a third sample becomes 1) or NTP_ENCODING_VECTOR, of any type; y follows dst->y.
 * Float results are x, y and z, each the nearest float; `blue` does not matter.  dst and src do not
 * overlap.  The texels read are those of the area and ntp_normals_reach(how) more on each side,
 * within the image.  If the area is that close to an edge, NTP_BORDER_WRAP also reads as many at
 * the opposite end; these rows must then be in the ring at the same time.  Alpha is rounded half up
 * too.
 * Errors: NTP_ERR_ARGUMENT for how NULL, a scale that is not finite, dx or dy negative or not
 * finite or so small that scale/dx or scale/dy is infinite, min_z outside 0..1; NTP_ERR_FORMAT for a
 * source that src does not have.
 */
NTP_API ntp_status ntp_normals_from_height(const ntp_image *dst, const ntp_const_image *src,
                                           const ntp_normals_options *how,
                                           ntp_normals_counts *counts, const ntp_rect *area);

/* How many rows above and below a row its normals depend on; -1 if how is NULL or invalid. */
NTP_API int32_t ntp_normals_reach(const ntp_normals_options *how);

/* Bytes of working memory of ntp_normals_dithered: 173 KiB, and 8 for each column; 0 if an argument is
 * invalid. */
NTP_API size_t ntp_normals_dithered_scratch_size(int32_t width);

/*
 * The same for NTP_TYPE_U8 and NTP_TYPE_U16, with the rounding error of each slope passed on to the
 * next texel, to the right for x and down for y ("integrable").  Heights that are reconstructed
 * from the result drift far less on gentle ground, but the picture is slightly noisier.  A texel
 * takes no more error than a level holds there: most of what a cliff leaves is lost.  dst is not
 * NTP_ENCODING_VECTOR; blue is derived.  The area covers full rows; to work in parts, start at row 0
 * and go down.  scratch: ntp_normals_dithered_scratch_size bytes, aligned to 16, zeroed before row
 * 0; it keeps the errors from call to call.
 */
NTP_API ntp_status ntp_normals_dithered(const ntp_image *dst, const ntp_const_image *src,
                                        const ntp_normals_options *how, void *scratch,
                                        size_t scratch_size, ntp_normals_counts *counts,
                                        const ntp_rect *area);

enum {
    NTP_MAX_SIGMA = 64 /* texels */
};

typedef struct ntp_blur_options {
    double sigma;  /* of the Gaussian, 0..NTP_MAX_SIGMA; 0: no blur */
    double weight; /* of the result */
    int32_t add;   /* nonzero: add to the values in dst */
    ntp_border border_x;
    ntp_border border_y;
    ntp_height_source source;
} ntp_blur_options;

/* Bytes of working memory of ntp_height_blur; 0 if an argument is invalid. */
NTP_API size_t ntp_height_blur_scratch_size(const ntp_blur_options *how, int32_t width);

/*
 * Blurs a heightfield: dst, NTP_TYPE_F32 NTP_ENCODING_HEIGHT (sample 0 is written), is set to
 * weight times the blurred heights, or this is added to it.  The weights of the Gaussian are
 * integers that add up to 65536 on each axis.  Beyond the edges the border gives the heights
 * (NTP_BORDER_REPEAT_SLOPE: extrapolated), so a texture that tiles still tiles.  Octaves are
 * several calls with `add`.  dst and src do not overlap.  scratch: ntp_height_blur_scratch_size
 * bytes, aligned to 16.  The whole image is processed.
 */
NTP_API ntp_status ntp_height_blur(const ntp_image *dst, const ntp_const_image *src,
                                   const ntp_blur_options *how, void *scratch, size_t scratch_size);

enum { NTP_RELIEF_BINS = 4096 };

/* How many texels have which slope, at scale 1; the caller zeroes it once.  Parts add up. */
typedef struct ntp_relief {
    uint32_t texels[NTP_RELIEF_BINS];
} ntp_relief;

/*
 * The texels of a row that are measured, about 256 x 256 of an image of any size: *first, and every
 * step-th after it, where the step is returned; 0: none of this row.
 */
NTP_API int32_t ntp_relief_row(int32_t width, int32_t height, int32_t y, int32_t *first);

/*
 * Counts the slopes of texels x, x + step, ... of row y.  Flat texels do not count, nor do those
 * whose heights are not finite.  Of the options the kernel, the borders, the spacings and the
 * source matter.  Reads as ntp_normals_from_height for that row.
 */
NTP_API ntp_status ntp_relief_add(ntp_relief *relief, const ntp_const_image *src,
                                  const ntp_normals_options *how, int32_t x, int32_t y,
                                  int32_t step);

/*
 * The scale that shows the relief: one in twenty of the texels that are not flat is then steeper
 * than 45 degrees.  Rounded to three digits, so that it can be typed.  0 if all texels are flat.
 */
NTP_API double ntp_relief_scale(const ntp_relief *relief);

/* The settings that give another program's picture of a heightfield; see ntp_normals_like. */
typedef struct ntp_peer {
    ntp_normals_options options;
    ntp_y y;                 /* of dst */
    int32_t swap_green_blue; /* nonzero: it stores z in green and y in blue */
} ntp_peer;

/*
 * The settings that give another program's picture, correctly rounded: `name` is "reference"
 * (value: its -hfs), "eberly" (sigma), "zima" (normalStrength; "zima-corrected": with the sign that
 * a reader of the article reported), "gegl" (scale), or "gimp-normalmap:FILTER" (scale) with FILTER
 * one of 4sample, sobel3, sobel5, prewitt3, prewitt5, 3x3, 5x5, 7x7, 9x9.  docs/equivalences.md
 * says how the programs differ from that.
 * Errors: NTP_ERR_ARGUMENT for another name or a value that is not finite.
 */
NTP_API ntp_status ntp_normals_like(ntp_peer *peer, const char *name, double value);

/* The name of a kernel or border as in docs/arithmetic.md: "sobel3", "repeat-slope"; never NULL. */
NTP_API const char *ntp_kernel_name(ntp_kernel kernel);
NTP_API const char *ntp_border_name(ntp_border border);

/* --------------------------------------------------------------- normals -> heightfield */

typedef enum ntp_height_method {
    NTP_HEIGHT_AUTO = 0,              /* least squares; the borders decide which */
    NTP_HEIGHT_TELESCOPING = 1,       /* Eberly's sums of slopes: no averaging, errors add up */
    NTP_HEIGHT_FRANKOT_CHELLAPPA = 2, /* least squares, both borders NTP_BORDER_WRAP */
    NTP_HEIGHT_POISSON_DCT = 3,       /* least squares, neither border NTP_BORDER_WRAP */
    NTP_HEIGHT_WEIGHTED = 4           /* least squares with weights and holes, by iteration */
} ntp_height_method;

/* What integer samples of x, y (and z, but for Z-zero) mean.  Float images: as stored. */
typedef enum ntp_decode {
    NTP_DECODE_AUTO = 0,    /* decided by the texels, else UNORM; see ntp_height_from_normals */
    NTP_DECODE_UNORM = 1,   /* (2c - M)/M */
    NTP_DECODE_NEUTRAL = 2, /* the same, but (M-1)/2 and (M+1)/2 of x and y are both 0 */
    NTP_DECODE_TRUNC = 3,   /* (2c + 1 - M)/M: written by an encoder that truncates */
    NTP_DECODE_SNORM = 4    /* (2c - M - 1)/(M - 1): 128 is 0 */
} ntp_decode;

typedef enum ntp_z {
    NTP_Z_AUTO = 0,   /* decided by the texels: derived if blue was, or if blue alone is wrong */
    NTP_Z_STORED = 1, /* NTP_ENCODING_XY: derived */
    NTP_Z_DERIVED = 2 /* sqrt(1 - x*x - y*y): if blue is unreliable */
} ntp_z;

/* Kernels of 3 x 3 and more respond little to the finest detail; a prior keeps noise out of it.
 * Detail to which a kernel hardly responds at all is damped without a prior as well: floats do not
 * hold enough digits to divide by that response.  With NTP_Z_AUTO, lengths of vectors tell how large
 * the errors of a damaged texture are; else the noise is that of rounding. */
typedef enum ntp_prior {
    NTP_PRIOR_AUTO = 0,     /* ROUGHNESS with kernels of 3 x 3 and more, and with CENTRAL where the
                             * texture turns out to be damaged; else NONE */
    NTP_PRIOR_NONE = 1,     /* NTP_HEIGHT_WEIGHTED: pairs of neighbors take its place */
    NTP_PRIOR_ROUGHNESS = 2 /* of heights that fit equally well within rounding, smooth ones */
} ntp_prior;

/* Which texels `residual` covers. */
typedef enum ntp_residual_scope {
    NTP_RESIDUAL_NONE = 0,
    NTP_RESIDUAL_ALL = 1,    /* all texels */
    NTP_RESIDUAL_INSIDE = 2, /* in at most 128 rows, texels whose kernel does not cross a border and
                              * that are not beside an edge that was fitted again */
    NTP_RESIDUAL_INSIDE_X = 3, /* texels whose kernel does not cross the left or the right border */
    NTP_RESIDUAL_INSIDE_Y = 4 /* texels whose kernel does not cross the upper or the lower border */
} ntp_residual_scope;

typedef struct ntp_height_options {
    ntp_height_method method;
    ntp_kernel kernel; /* that made the normals, or NTP_KERNEL_BAKED */
    ntp_border border_x;
    ntp_border border_y;
    ntp_decode decode;
    ntp_z z;
    uint32_t touch_unused; /* NTP_UNUSED_*; other unused texels count as flat, except black and
                            * white ones of NTP_ENCODING_VECTOR */
    int32_t use_seeds;     /* nonzero, telescoping only: heights start at `seeds` */
    double seeds[4];       /* h(0,0), h(1,0), h(0,1), h(1,1); forward: the first */
    int32_t equalize;      /* nonzero, telescoping, central: one mean for even and odd texels */
    ntp_residual_scope residual_scope; /* compute `residual` for these texels, in one more pass */
    int32_t detrend; /* nonzero: remove the best-fitting plane, along borders that do not wrap */
    int32_t refine;  /* 0..NTP_MAX_ITERATIONS rounds */
    /* NTP_HEIGHT_WEIGHTED; a mask makes it the default method.  It is NTP_TYPE_U8 or NTP_TYPE_U16,
     * NTP_ENCODING_HEIGHT, and has the size of src.  Texels where its sample 0 is 0 are holes.
     * Unused texels are holes too. */
    const ntp_const_image *mask;
    double tolerance;       /* rms error of slopes divided by their rms; 0 means 1e-6 */
    int32_t max_iterations; /* 1..NTP_MAX_ITERATIONS; 0 means 1000.  A second solution, which only
                             * improves heights and ends by itself, may take 30 times as many. */
    double dx;              /* spacing of texels, 2^-100..2^100; 0 stands for 1 */
    double dy;              /* the same; the two differ by less than a factor of 2^50 */
    ntp_prior prior;
} ntp_height_options;

enum { NTP_MAX_ITERATIONS = 100000 };

/* What was done. */
typedef struct ntp_height_result {
    ntp_height_method method; /* never NTP_HEIGHT_AUTO */
    ntp_decode decode;        /* never NTP_DECODE_AUTO */
    double min, max;          /* of the heights; (h - min)/(max - min) is 0..1, and with the scale
                               * max - min ntp_normals_from_height makes normals of it again */
    uint64_t unused;          /* texels that counted as flat */
    uint64_t not_finite;      /* float texels with a NaN, an infinity or length 0: flat */
    ntp_z z;                  /* never NTP_Z_AUTO */
    int32_t iterations;       /* NTP_HEIGHT_WEIGHTED: of the last solution */
    double error;             /* NTP_HEIGHT_WEIGHTED: the final error, in the unit of tolerance */
    uint64_t holes;           /* NTP_HEIGHT_WEIGHTED: texels without a height; they get 0 */
    uint64_t islands;         /* connected areas, each with its own mean; 0: only holes */
    double trend_x, trend_y;  /* slopes to the right and down that `detrend` removed */
    int32_t rounds;           /* done by `refine` */
    uint64_t refine_left;     /* after `refine`: texels that still differ */
    double residual;          /* rms difference of x and y between the normals of the heights and
                               * the texture, in levels (floats: of 16 bit); -1: not measured, or no
                               * texel counts */
    /* NTP_HEIGHT_TELESCOPING: rms and maximum of |slope of the heights - stored slope| in the
     * equations that the sums did not use, which are those of other paths; else 0 */
    double consistency, consistency_max;
} ntp_height_result;

/* Callbacks for operations that take long.  Members, and a pointer to it, may be NULL. */
typedef struct ntp_hooks {
    void *user;
    /* Gets the share done so far, 0..1, between parallel_for calls.  Returning nonzero cancels. */
    int32_t (*progress)(void *user, double share);
    /* Calls task(work, i) for each i from 0 to count - 1, on any threads, and returns when all
     * are done.  count is at most parts. */
    void (*parallel_for)(void *user, int32_t count, void (*task)(void *work, int32_t index),
                         void *work);
    int32_t parts; /* 1..NTP_MAX_PARTS; 0 means 1 */
} ntp_hooks;

enum { NTP_MAX_PARTS = 64 };

/* Bytes of working memory, some rows for each part; 0 if an argument is invalid. */
NTP_API size_t ntp_height_scratch_size(const ntp_height_options *how, int32_t width, int32_t height,
                                       int32_t parts);

/*
 * Reconstructs the heightfield of normals: dst, NTP_TYPE_F32 NTP_ENCODING_HEIGHT of one packed
 * channel, gets heights in the unit of dx and dy.  Slopes are -x/z and -y/z, with z at least 1/M
 * (float: 1/65535).
 *
 * Least squares give the heightfield whose slopes, by this kernel with these borders, are closest
 * to the stored ones; if there are several, the one of least norm.  Its mean is 0. The solution is
 * direct: a Fourier (wrap) or cosine transform of each row, then a recursion down and up each
 * column (forward, central, baked) or transforms of the columns as well (3 x 3 and more, prior,
 * central with mirror down the picture).  Beside dst it needs memory for only some rows and
 * columns.  8-bit textures are transformed in float arithmetic, deeper ones in double.
 *
 * Kernels and borders; the two axes are independent:
 *   forward           all.  With clamp the last slope is ignored; where the last two are
 *                     slopes of one pair of texels (mirror, extrapolate, repeat-slope, which is
 *                     extrapolate), only their mean counts.
 *   central           wrap, clamp, mirror, extrapolate (slopes at the edge count a quarter; then
 *                     the two outermost lines of texels are fitted again with equal weights)
 *   prewitt3, sobel3, scharr3     wrap, clamp, mirror
 *   prewitt5, sobel5, gimp5..9    wrap, mirror
 *   baked             wrap; any other is a free end.  Slopes of a surface at texel centers; the
 *                     difference of two neighbors is (-1, 13, 13, -1)/24 of the four slopes around
 *                     them, at free ends (9, 19, -5, 1)/24.
 * With mirror the texels at the edge count half, also in the mean, which is that of the mirrored
 * plane.  Of heights that fit equally well within the errors of the slopes, NTP_PRIOR_ROUGHNESS
 * prefers smoother ones.  docs/reconstruction.md has the formulas.
 *
 * NTP_HEIGHT_WEIGHTED supports every kernel with every border.  The weight of a slope is about
 * 1/variance, which is 1/((1 + p*p + q*q)(1 + p*p)) for p with z as stored and less with z derived,
 * and at least 0.01.  Slopes whose kernel reads a hole do not count.  In a first solution pairs of
 * neighbors count a little, as if the mean of their slopes were their difference: they connect
 * texels that the kernel leaves independent.  Then the iteration goes on with the prior, without
 * pairs or, where there are holes, with weak ones (docs/reconstruction.md).  With NTP_PRIOR_NONE there is only the first solution, in which
 * pairs count 1e-5.  Heights in holes are 0. Texels connected by their sides form an island, also
 * across borders that wrap; the mean of each island is 0. The method is conjugate gradients and
 * needs about 50 bytes a texel.  Steep textures and ragged holes need more iterations.
 * NTP_ERR_NOT_CONVERGED means that `tolerance` was not reached; dst and result are then those of the
 * last iteration.
 *
 * refine: rounds that change the heights until their normals, by ntp_normals_from_height with this
 * kernel and these borders, have the stored red and green, rounded as NTP_DECODE_* says; and the
 * stored blue, where z is not derived and every blue was rounded from the same vector as its red
 * and green.  They end when all texels agree, those aside whose kernel reads a hole.  dst gets the
 * heights of the round that leaves fewest texels.  While they run, `progress` finds the rounds so far
 * and the texels left in result.  They take 112 bytes a texel.  refine is not for
 * telescoping and floats.  Baked normals are made again by the slopes of polynomials through the
 * nine nearest heights in a line.  detrend is applied to the refined heights and changes
 * their normals; with NTP_HEIGHT_WEIGHTED using both is an error.
 *
 * Automatic choices: for 8-bit NTP_ENCODING_STANDARD, NTP_DECODE_AUTO chooses TRUNC or SNORM if
 * the lengths decoded so are 1 to within rounding, and clearly closer to 1 than with UNORM.
 * Otherwise, for 8 bits, it chooses NEUTRAL if flat ground has 127 in red, not 128 as correct
 * rounding makes it, unless all of green is 128; and if all of red or of green is 128 and that
 * axis does not wrap; else UNORM.  It chooses NEUTRAL too where most texels within 5 levels of zero have
 * one red and one green, as flat ground has after block compression: then all levels as near to zero as
 * these are 0.  NTP_Z_AUTO chooses the derived z if tilted texels have the
 * blue that is derived from red and green, or if lengths are off by more than three times their
 * rounding while x and y are too long in at most one texel of 50,000 and blue does not follow
 * them; NTP_ENCODING_VECTOR: stored.  Where it chooses the stored z and damage made some vectors
 * longer than 1, a mean of both counts: of the stored z the share x*x + y*y, of the derived one the
 * rest.  A z below twice the error that negative z show counts as that.
 *
 * Where the choices are UNORM and the stored z, and lengths are off by more than three times their
 * rounding, levels of flat ground are a pile around 128, half a level above zero.  The direct solver then
 * takes out the plane by which heights would lean along axes that do not wrap; not with refine or detrend.
 *
 * Telescoping (Eberly 3.1, 3.2): forward goes along the first row and down each column.  central
 * goes in steps of two from h(0,0), h(1,0), h(0,1), h(1,1); by default h(0,0) = 0, and each other
 * is the mean of its known or implied neighbors: h(1,0) = p(1,0), h(0,1) = q(0,1), h(1,1) = (h(0,1)
 * + p(1,1) + h(1,0) + q(1,1))/2.  Without seeds the mean is then set to 0. No slope at a border is
 * used.
 *
 * The result is the same bytes for any number of parts.  dst and src do not overlap, and ring_rows
 * is 0 in both.  scratch: ntp_height_scratch_size bytes for these parts, aligned to 64.  hooks and
 * result may be NULL.  After NTP_ERR_CANCELLED the content of dst is undefined and result is as it
 * was, unless the rounds of `refine` had begun: then both are those of the best round so far, and
 * result->method is not NTP_HEIGHT_AUTO.
 * Errors: NTP_ERR_ARGUMENT also if the method does not support the borders, seeds are not finite, a
 * mask is given with another method, or telescoping is refined; NTP_ERR_FORMAT for a kernel, or a
 * border of it, that is not listed above, for a float mask, and for what cannot be refined;
 * NTP_ERR_SHAPE for a mask of another size; NTP_ERR_NOT_CONVERGED.
 */
NTP_API ntp_status ntp_height_from_normals(const ntp_image *dst, const ntp_const_image *src,
                                           const ntp_height_options *how, void *scratch,
                                           size_t scratch_size, const ntp_hooks *hooks,
                                           ntp_height_result *result);

/*
 * Functions that read rows of normals and write rows of heights, for a picture too large for
 * memory.  Each reads or writes rows y .. y + count - 1, packed, and returns 0; any other value
 * ends the work.  They are called from the caller's thread only.
 */
typedef struct ntp_height_rows {
    void *user;
    /* Reads groups of rows in order down the picture.  A few rows around each group are read as
     * well, and with NTP_BORDER_WRAP those of the opposite end. */
    int32_t (*read_normals)(void *user, void *rows, int32_t y, int32_t count);
    /* On the way down, rows are written that are not heights yet.  Then, from the last group to the
     * first, they are read again and written as heights. */
    int32_t (*read_heights)(void *user, float *rows, int32_t y, int32_t count);
    int32_t (*write_heights)(void *user, const float *rows, int32_t y, int32_t count);
} ntp_height_rows;

/* Bytes of working memory: for each part about 32 rows of both pictures; 0 if an argument is
 * invalid, or if this cannot be solved row by row. */
NTP_API size_t ntp_height_rows_scratch_size(const ntp_const_image *form,
                                            const ntp_height_options *how, int32_t parts);

/*
 * ntp_height_from_normals row by row.  The bytes are the same, except for central with
 * NTP_BORDER_EXTRAPOLATE, whose edges are not fitted again, and for normals that are the same all
 * along an axis that wraps, whose heights are not made the same to the last bit.  form describes
 * the normals by its size, channels, type, encoding and y.  Supported are least squares with
 * NTP_KERNEL_FORWARD, _CENTRAL and _BAKED without a prior, but not central with NTP_BORDER_MIRROR
 * down the picture; and
 * no mask, detrend, residual_scope or refine.  Nothing is decided by the texels: NTP_DECODE_AUTO
 * means UNORM, and NTP_Z_AUTO means stored.
 * Errors: NTP_ERR_FORMAT for what is not supported; NTP_ERR_CANCELLED if a function returned
 * nonzero.
 */
NTP_API ntp_status ntp_height_from_rows(const ntp_const_image *form, const ntp_height_rows *rows,
                                        const ntp_height_options *how, void *scratch,
                                        size_t scratch_size, const ntp_hooks *hooks,
                                        ntp_height_result *result);

/* The name of a method as on the command line ("poisson-dct"); never NULL. */
NTP_API const char *ntp_height_method_name(ntp_height_method method);

/* ------------------------------------------- curvature, cavity, ambient occlusion */

/* What of the curvature is stored.  k1 >= k2 are the two principal curvatures, 1/radius, positive
 * where the surface is convex. */
typedef enum ntp_curvature_kind {
    NTP_CURVATURE_MEAN = 0,     /* (k1 + k2)/2: a sphere of radius R has 1/R, a cylinder 1/(2R) */
    NTP_CURVATURE_GAUSSIAN = 1, /* k1 k2 */
    NTP_CURVATURE_CONVEX = 2,   /* k1, or 0 if it is negative: how sharp edges are */
    NTP_CURVATURE_CAVITY = 3    /* -k2, or 0 if that is negative: how sharp grooves are */
} ntp_curvature_kind;

typedef struct ntp_curvature_options {
    ntp_curvature_kind kind;
    double scale; /* heights: how many texels a height of 1 rises; 0 stands for 1 */
    /* Above 0: dst gets v = value/range, clamped to 0..1: (v + 1)/2 for the first two kinds, v for
     * CONVEX, 1 - v for CAVITY.  0: the value itself. */
    double range;
    /* NTP_BORDER_WRAP, or NTP_BORDER_CLAMP: the nearest texel whose neighbors lie inside. */
    ntp_border border_x;
    ntp_border border_y;
} ntp_curvature_options;

/*
 * The curvature of a heightfield, or of the surface of normals, in 1/texel (GAUSSIAN: 1/texel^2).
 * Heights are sample 0; of normals x and y are read as they are stored, and not z, by central
 * differences: twice the mean curvature is the divergence of (x, y), and the Gaussian curvature the
 * determinant of their derivatives.  docs/relief-maps.md has the formulas.
 * dst is NTP_ENCODING_HEIGHT, of any type with a range, else of NTP_TYPE_F32; sample 0 is written.
 * It does not overlap src.  The 3 x 3 texels around each are read; in a ring they must be there,
 * also those of the opposite end with NTP_BORDER_WRAP.  Where one of them is not finite, or is an
 * unused texel of normals, the value is 0.
 */
NTP_API ntp_status ntp_curvature(const ntp_image *dst, const ntp_const_image *src,
                                 const ntp_curvature_options *how, const ntp_rect *area);

/*
 * A range that shows most of a picture: 99 % of the values that are not 0 lie in it.  It is a
 * multiple of 1/16 of a power of two; 0 if all are 0.  values are those of ntp_curvature without a
 * range; ring_rows is 0.
 */
NTP_API ntp_status ntp_curvature_range(double *range, const ntp_const_image *values);

typedef struct ntp_occlusion_options {
    double scale;        /* how many texels a height of 1 rises; 0 stands for 1 */
    double radius;       /* what is farther away, in texels, hides nothing; 0: the longer side */
    ntp_border border_x; /* NTP_BORDER_WRAP, or NTP_BORDER_CLAMP: beyond the edge is nothing */
    ntp_border border_y;
} ntp_occlusion_options;

/* Bytes of working memory, 8 a texel and some lines for each part; 0 if an argument is invalid. */
NTP_API size_t ntp_occlusion_scratch_size(const ntp_occlusion_options *how, int32_t width,
                                          int32_t height, int32_t parts);

/*
 * Ambient occlusion of a heightfield: the light that a texel gets from a uniformly bright
 * surrounding, divided by what it would get if nothing were in the way; 1 is open, 0 hidden.  It
 * is the share of directions above the surface, weighted by the cosine of their angle to the
 * normal (that of central differences), in which no other part of the surface lies.  The horizon
 * is that of 32 directions.  Heights are rounded to 2^-24 of their range; those that are not finite
 * count as the lowest.  src is NTP_ENCODING_HEIGHT, of which sample 0 is read; dst is
 * NTP_ENCODING_HEIGHT of any type; sample 0 is written.  They may be the same memory. ring_rows is
 * 0 in both.  scratch: ntp_occlusion_scratch_size bytes for these parts, aligned to 64; hooks may
 * be NULL.  The result is the same bytes for any number of parts.
 * docs/relief-maps.md has the formulas.
 * Source of horizons by hulls: V. Timonen, J. Westerholm, Scalable Height Field Self-Shadowing
 * (2010).
 */
NTP_API ntp_status ntp_occlusion(const ntp_image *dst, const ntp_const_image *src,
                                 const ntp_occlusion_options *how, void *scratch,
                                 size_t scratch_size, const ntp_hooks *hooks);

/* ---------------------------------------------------------- normals -> depth of an object */

/*
 * A camera without distortion, as OpenCV has it: texel (u, v), whose middle is at whole numbers,
 * looks along ((u - cx)/fx, (v - cy)/fy, 1), x to the right, y down, z away from the viewer.
 */
typedef struct ntp_camera {
    double fx, fy; /* focal lengths in texels, 2^-10..2^20; both 0: orthographic */
    double cx, cy; /* where the axis meets the picture, in texels, -2^20..2^20 */
} ntp_camera;

typedef struct ntp_depth_options {
    ntp_camera camera;
    double k; /* how readily a cliff is seen, 2^-20..2^20; 0 means 2, the value of the paper */
    int32_t rounds;        /* at most, 0..NTP_MAX_ITERATIONS; 0 means 33, 1 is least squares */
    uint32_t touch_unused; /* NTP_UNUSED_*: such texels hold normals */
    /* NULL, or of type U8 or U16, NTP_ENCODING_HEIGHT, of the size of src.  Texels where its sample
     * 0 is 0 are holes. */
    const ntp_const_image *mask;
    /* NULL, or depth to begin with, such as that of the last picture of a film: NTP_TYPE_F32,
     * NTP_ENCODING_HEIGHT, one channel, of the size of src.  What is not finite, and with a camera
     * what is not positive, counts as the middle. */
    const ntp_const_image *start;
} ntp_depth_options;

typedef struct ntp_depth_result {
    int32_t rounds;       /* done */
    int32_t iterations;   /* of conjugate gradients, in all rounds */
    uint64_t islands;     /* areas of texels joined by their sides, each with a scale of its own */
    uint64_t holes;       /* texels without depth */
    uint64_t not_finite;  /* of these: floats with a NaN, an infinity or length 0 */
    uint64_t turned_away; /* texels whose normals do not face the viewer; their neighbors decide */
    double min, max;      /* of the depth; both 0 if there is none */
} ntp_depth_result;

enum { NTP_MAX_DEPTH_TEXELS = 1 << 28 }; /* that ntp_depth_from_normals takes */

/* Bytes of working memory, about 314 a texel; 0 if the size is invalid. */
NTP_API size_t ntp_depth_scratch_size(int32_t width, int32_t height);

/*
 * Depth of an object from its normals, as photometric stereo measures them: with the perspective of
 * a camera, and with cliffs where one part hides another.  Textures are for
 * ntp_height_from_normals.  dst, NTP_TYPE_F32 NTP_ENCODING_HEIGHT of one channel, gets the distance
 * along the axis of the camera: greater is farther.  Normals do not tell how far away an object is.
 * Orthographic depth is in texels and has mean 0 on each island; depth with a camera is positive
 * and its logarithm has mean 0 on each island, so only its ratios are known.  In holes it is NaN.
 * Holes are texels that are unused or masked, and vectors shorter than 1/4, as the gray (128, 128,
 * 128) of an empty background.  Floats are read as 16 bit.
 *
 * The method is bilateral normal integration (Cao, Santo, Shi, Okura, Matsushita, ECCV 2022).  At
 * each texel and axis there are two equations, with the neighbor on either side.  With a and b the
 * differences of depth to the two, in texels and times the cosine between normal and view, the
 * shares of the equations are 1/(1 + exp(-k (b*b - a*a))) and the rest: the side with the jump
 * hardly counts.  Both equations of a pair of neighbors ask for the mean of their slopes, of which
 * none is above 20; that is right at a fold, too.  Only least squares takes each slope for itself.
 * Beside that both count 1/(1 + (n/m)^2) times 1/(1 + (o/f)^2): n is the distance of their normals,
 * o how far depth is off both of their slopes.  m is 0.07, and more where normals bend everywhere,
 * as in folds and patterns.  f falls from 3 to 0.3 texels.  All are found in turn, until the sum of
 * squares changes by less than 0.03 percent.  What is cut off all round keeps about the depth that
 * the first rounds gave it: nothing tells it.
 *
 * confidence: NULL, or a view like dst that gets 1/(1 + e), e the error that may be expected of the
 * depth, in texels (with a camera: fx times that of the depth in dst); 0 in holes.  e is twice how
 * far the depth moves under forces as large as what is left of the equations, and how far with 3 times k;
 * it stays below half the standard deviation of all depths.  It ranks texels; it is no bound.  It takes
 * 1.2 times as long as the depth.
 *
 * scratch: ntp_depth_scratch_size bytes, aligned to 64.  One thread works; of hooks, which may be
 * NULL, only progress is called.  dst, confidence and src do not overlap.  result may be NULL.
 * After NTP_ERR_CANCELLED nothing is written.
 * Errors: NTP_ERR_ARGUMENT, NTP_ERR_SCRATCH, NTP_ERR_CANCELLED; NTP_ERR_FORMAT for other views, and
 * a float mask; NTP_ERR_SHAPE for views of different size, ring_rows, and more than
 * NTP_MAX_DEPTH_TEXELS texels.
 */
NTP_API ntp_status ntp_depth_from_normals(const ntp_image *dst, const ntp_image *confidence,
                                          const ntp_const_image *src, const ntp_depth_options *how,
                                          void *scratch, size_t scratch_size,
                                          const ntp_hooks *hooks, ntp_depth_result *result);

/* -------------------------------------------------------------- operations on normals */

/*
 * Resizing, turning, scaling the slopes and blending of NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO,
 * NTP_ENCODING_XY and NTP_ENCODING_VECTOR textures.  Every normal that is computed is stored as its
 * unit vector.  Red and green are correctly rounded, half up (a pair that is then too long is
 * pulled onto the disc).  Blue is derived from them, with the sign of z (NTP_ENCODING_ZZERO: |z|).
 * So the texel passes NTP_VERDICT_EXACT with keep_negative_z.  NTP_ENCODING_XY texels are read with
 * the z that the standard texel of their red and green, pulled where too long, would store.  Floats
 * are read and written on the 16-bit grid, level / 65535.  All sums are of integers, without
 * rounding.
 */

typedef enum ntp_filter {
    NTP_FILTER_TRIANGLE = 0, /* bilinear; widened where the texture shrinks */
    NTP_FILTER_BOX = 1,      /* the mean over the area that the texel covers: for mip chains */
    NTP_FILTER_LANCZOS3 = 2
} ntp_filter;

typedef struct ntp_resize_options {
    ntp_filter filter;
    ntp_border border_x; /* NTP_BORDER_WRAP, _CLAMP or _MIRROR */
    ntp_border border_y;
    uint32_t touch_unused; /* NTP_UNUSED_*; NTP_UNUSED_TRANSPARENT: alpha is data, no weight */
} ntp_resize_options;

/* The weights of every row and column.  Opaque, in memory of the caller, read-only once made. */
typedef struct ntp_resize_plan ntp_resize_plan;

/* The source rows first..last from which a row of the result is made.  The border defines rows
 * below 0 and from the height on: with NTP_BORDER_WRAP they are rows of the opposite end. */
typedef struct ntp_rows {
    int32_t first, last;
} ntp_rows;

/* Bytes of a plan from src_width x src_height to width x height; 0 if an argument is invalid. */
NTP_API size_t ntp_resize_plan_size(const ntp_resize_options *how, int32_t src_width,
                                    int32_t src_height, int32_t width, int32_t height);

/* Fills memory of that size, aligned to 16, and returns it through *plan. */
NTP_API ntp_status ntp_resize_plan_init(ntp_resize_plan **plan, void *memory, size_t size,
                                        const ntp_resize_options *how, int32_t src_width,
                                        int32_t src_height, int32_t width, int32_t height);

/* Bytes of working memory of each call of ntp_resize; 0 for NULL. */
NTP_API size_t ntp_resize_scratch_size(const ntp_resize_plan *plan);

/* The source rows of row y of the result; y is clamped to the rows of the result.  plan is not
 * NULL. */
NTP_API ntp_rows ntp_resize_rows(const ntp_resize_plan *plan, int32_t y);

/*
 * Resizes.  dst and src have the same type, encoding, channels and y, have the sizes of the plan,
 * and do not overlap; area is an area of dst.  The vectors are filtered as stored, weighted with
 * alpha.  Unused texels, and floats that are not a vector, have no weight.  Alpha is filtered
 * independently.  Where no weight is left, the result is the flat normal, with alpha 0 unless
 * touch_unused says that alpha is data.  A negative z that no texel under the filter has (Lanczos
 * overshoots) counts as 0. The third sample of NTP_ENCODING_XY is filtered like x and y. Source
 * rows read: ntp_resize_rows of each row of area.
 * scratch: ntp_resize_scratch_size bytes, aligned to 16.
 */
NTP_API ntp_status ntp_resize(const ntp_image *dst, const ntp_const_image *src,
                              const ntp_resize_plan *plan, void *scratch, size_t scratch_size,
                              const ntp_rect *area);

/* Levels of the full mip chain, including the texture itself; 0 for sides below 1. */
NTP_API int32_t ntp_mip_levels(int32_t width, int32_t height);

/* A side at a level, where 0 is the texture: halved and rounded down `level` times, at least 1. */
NTP_API int32_t ntp_mip_side(int32_t side, int32_t level);

/* The name of a filter ("triangle", "box", "lanczos3"); never NULL. */
NTP_API const char *ntp_filter_name(ntp_filter filter);

enum {
    NTP_MAX_STRENGTH = 1024, /* of slopes; below 1/1024 a strength is rounded to 2^-62 */
    NTP_MAX_ANGLE = 360      /* of a turn; it is rounded to 2^-32 of a degree */
};

/* A picture of which src and dst are parts.  Texels of src beyond its edges are those at the edge,
 * so src has all that is needed, also from beyond the picture's edges. */
typedef struct ntp_part {
    int32_t width, height; /* of the picture */
    int32_t src_x, src_y;  /* where src begins in it */
    int32_t dst_x, dst_y;
} ntp_part;

typedef struct ntp_transform_options {
    int32_t flip_x;        /* nonzero: exchange left and right; done first */
    int32_t flip_y;        /* nonzero: exchange top and bottom */
    int32_t quarter_turns; /* clockwise as seen, 0..3; after the flips */
    int32_t use_strength;  /* nonzero: the slopes are multiplied by strength */
    double strength;       /* -NTP_MAX_STRENGTH..NTP_MAX_STRENGTH; negative: bumps become dents */
    double angle;          /* degrees clockwise, -NTP_MAX_ANGLE..NTP_MAX_ANGLE, and quarter_turns */
    /* The rest is for angles that are no multiple of 90 degrees. */
    ntp_border border_x; /* NTP_BORDER_WRAP, _CLAMP or _MIRROR */
    ntp_border border_y;
    uint32_t touch_unused; /* as in ntp_resize_options */
    const ntp_part *part;  /* NULL: src and dst are whole pictures */
} ntp_transform_options;

/*
 * Flips and turns the picture and its vectors together, and scales the slopes.  dst and src have
 * the same type, encoding, channels and y and do not overlap; after an odd number of quarter turns
 * the width of dst is the height of src.  Flips, turns and a strength of 1 or -1 only move and
 * mirror levels (r -> M - r): nothing is rounded.  Any other strength computes every texel from (S
 * x, S y, z).  Unused texels, and floats that are not a vector, move but keep their color.  area is
 * an area of dst.  src->ring_rows is 0 if rows change places (else NTP_ERR_SHAPE).
 * A turn that is no multiple of 90 degrees leaves the size as it is.  It is about the middle of the
 * picture; each vector is made of the four around its place, bilinearly and weighted with alpha as
 * in ntp_resize, and then turned.
 */
NTP_API ntp_status ntp_transform(const ntp_image *dst, const ntp_const_image *src,
                                 const ntp_transform_options *how, const ntp_rect *area);

/* The quarter turns clockwise, 0..3, that an angle is; -1: it is none, or not allowed. */
NTP_API int32_t ntp_quarter_turns(double angle);

typedef enum ntp_blend_mode {
    NTP_BLEND_RNM = 0,      /* reoriented: as if the detail lay on the surface of the base */
    NTP_BLEND_WHITEOUT = 1, /* (x1 + x2, y1 + y2, z1 z2) */
    NTP_BLEND_UDN = 2,      /* (x1 + x2, y1 + y2, z1): keeps less of the detail on slopes */
    NTP_BLEND_LINEAR = 3    /* the sum of both vectors: flattens both; the mean of two textures */
} ntp_blend_mode;

typedef struct ntp_blend_options {
    ntp_blend_mode mode;
    int32_t use_strength;  /* nonzero: x and y of the detail are multiplied by strength first */
    double strength;       /* as in ntp_transform_options */
    uint32_t touch_unused; /* NTP_UNUSED_*: blend such texels too */
    int32_t detail_alpha;  /* nonzero: the alpha of the detail fades it, to a flat one; linear: to
                            * nothing, so that the base remains */
} ntp_blend_options;

/*
 * Blends a detail over a base.  dst and base have the same size, type, encoding, channels and y,
 * and are the same memory with the same strides or do not overlap.  The detail may differ in all of
 * these.  It is repeated, starting at the upper left corner, and does not overlap dst.  If neither
 * z was negative, a negative result (RNM, both steep) counts as 0. Where base or detail is unused,
 * or a float that is not a vector, the base's texel is copied.  Alpha, and the third sample of
 * NTP_ENCODING_XY, are those of the base.  Rows of the detail read: those of area mod its height.
 * Source: C. Barre-Brisebois, S. Hill, Blending in Detail (2012).
 */
NTP_API ntp_status ntp_blend(const ntp_image *dst, const ntp_const_image *base,
                             const ntp_const_image *detail, const ntp_blend_options *how,
                             const ntp_rect *area);

/* The name of a mode ("rnm", "whiteout", "udn", "linear"); never NULL. */
NTP_API const char *ntp_blend_mode_name(ntp_blend_mode mode);

/* ------------------------------------------------------------------ block compression */

/*
 * BC4 stores one channel in 8 bytes for 4 x 4 texels, BC5 two in 16.  Each block has two ends of 8
 * bit for each channel, and each texel takes one of eight values on the line between them (or of
 * six, and 0 and 1).  The error is that of a decoder that interpolates exactly, as GPUs do; the
 * ends are the same for any other.
 */
typedef enum ntp_block_quality {
    NTP_BLOCK_BY_ANGLE = 0, /* BC5: both channels by the angle between the vectors; BC4: as next */
    NTP_BLOCK_BY_CHANNEL = 1, /* the least squared error of each channel that BC4 can have */
    NTP_BLOCK_QUICK = 2       /* the best of the ends near the range of the texels */
} ntp_block_quality;

typedef struct ntp_block_options {
    ntp_block_quality quality;
} ntp_block_options;

enum { NTP_BLOCK_SIDE = 4 };

/*
 * Writes the blocks of an area: sample 0 of a view as BC4, samples 0 and 1 as BC5.  The block of
 * the texels from (x, y) on goes to dst + (y / 4) row_stride + (x / 4) 8 (BC5: 16).  x, y are taken
 * as they are stored, and z is what follows from them; texels whose x, y are too long count as
 * shortened.  Where a side is no multiple of 4, the texels beyond the edge count for nothing.
 * area begins at multiples of 4, and ends there or at the edge of the image.  how may be NULL.
 * Errors: NTP_ERR_ARGUMENT for another area; NTP_ERR_FORMAT for NTP_ENCODING_VECTOR, for too few
 * channels, and BC5 for NTP_ENCODING_HEIGHT.
 */
NTP_API ntp_status ntp_bc4_encode(uint8_t *dst, ptrdiff_t row_stride, const ntp_const_image *src,
                                  const ntp_block_options *how, const ntp_rect *area);
NTP_API ntp_status ntp_bc5_encode(uint8_t *dst, ptrdiff_t row_stride, const ntp_const_image *src,
                                  const ntp_block_options *how, const ntp_rect *area);

/* -------------------------------------------------------------------- which way is green */

/*
 * Detects OpenGL or DirectX from the texels alone: the slopes of a surface have equal cross
 * derivatives; if green is the other way round, they are opposite.  docs/orientation.md explains
 * how, and what cannot be known: a texture with red and green both inverted is that of the inverted
 * height, which is an equally possible surface.  So the answer assumes that red points right.
 *
 * The accumulator: memory of ntp_orientation_size() bytes, aligned to 16, zero-filled by the
 * caller.  It takes 101 KiB.  It holds only integer sums, so parts merge exactly.
 */
typedef struct ntp_orientation ntp_orientation;

NTP_API size_t ntp_orientation_size(void);

/*
 * Adds the texels of an area.  src is NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO, NTP_ENCODING_XY or
 * NTP_ENCODING_VECTOR; only red and green are used; src->y is not.  Only sampled rows are read, and
 * a smaller share of large images; every_row nonzero: all rows.  The surroundings of a texel are
 * read too: for row y the rows y - 2 .. y + 3, two columns to the left and three to the right.
 * Nothing is measured within 2 or 3 texels of the edges, or if a texel in the surroundings is
 * unused, not finite, or steeper than z = 0.1.
 * Errors: NTP_ERR_SHAPE if it already holds an image of another size or every_row.
 */
NTP_API ntp_status ntp_orientation_add(ntp_orientation *orientation, const ntp_const_image *src,
                                       uint32_t touch_unused, int32_t every_row,
                                       const ntp_rect *area);

/* Nonzero: row y of an image of this height is measured. */
NTP_API int32_t ntp_orientation_row(int32_t height, int32_t every_row, int32_t y);

/* Adds what `from` holds to `into`.  Errors as ntp_orientation_add. */
NTP_API ntp_status ntp_orientation_merge(ntp_orientation *into, const ntp_orientation *from);

/* Makes a used accumulator empty again. */
NTP_API ntp_status ntp_orientation_clear(ntp_orientation *orientation);

typedef struct ntp_orientation_result {
    int32_t decided;   /* 0: undecided: stripes, weaves, flat, noise, too small */
    ntp_y y;           /* which way green points as stored; the more likely one if undecided */
    double confidence; /* 0.8..0.99; 0 if undecided */
    double statistic;  /* -1..1: how well the cross derivatives agree; positive: Y up */
    double score;      /* how consistent this is over the picture, in standard deviations */
    uint64_t loops;    /* measured: groups of 6 x 6 texels */
} ntp_orientation_result;

/* Computes the result. */
NTP_API ntp_status ntp_orientation_summarize(ntp_orientation_result *result,
                                             const ntp_orientation *orientation);

/* ---------------------------------------------------------------- where normals come from */

enum { NTP_KERNELS = 11 /* as many as ntp_kernel has */ };

/* Which kernel made the normals, if the texels show it. */
typedef struct ntp_kernel_fit {
    /* 1: rounding explains the residual of `kernel`, and clearly not that of the others; 0: smooth,
     * changed afterwards, or not made by a kernel */
    int32_t decided;
    ntp_kernel kernel;          /* the one to reconstruct with, also if undecided */
    double misfit[NTP_KERNELS]; /* by ntp_kernel: mean square of the residual divided by that of
                                 * rounding; 1 is a perfect fit; -1: not tried */
    uint64_t points;
} ntp_kernel_fit;

/*
 * Tries kernels on the normals: the two slopes must be differences of one height.  It uses red,
 * green and src->y, which ntp_orientation_summarize can find.  It tries central, forward, prewitt3,
 * sobel3, scharr3, prewitt5 and baked; sobel5 looks like sobel3.  It reads sampled rows, at most
 * 1024 and only until they show enough detail, and 256 columns of each.  The border does not
 * matter.  Where damage or smooth ground hides the kernel, it is undecided: forward if the slopes clearly
 * lie between texels, a fifth of a texel or more to the right and below.  Else it is baked on damage,
 * unless that misfits 1.03 times as much as central, or the blur of sobel3 shows; and central on smooth
 * ground.
 * src->ring_rows is 0.
 */
NTP_API ntp_status ntp_find_kernel(ntp_kernel_fit *fit, const ntp_const_image *src,
                                   uint32_t touch_unused);

/* How two opposite edges fit together. */
typedef struct ntp_seam {
    int32_t decided; /* 0: neither clearly a seam nor clearly without one */
    int32_t tiles;   /* decided only: 1: the two edges fit together; 0: there is a seam */
    int32_t wraps;   /* 1: the heights at the edges meet too: NTP_BORDER_WRAP suits them, also where
                      * nothing is decided because the edges are flat */
    /* The difference of heights between the ends of a line, divided by their variation along it;
     * without rounding and what all lines have in common. */
    double closure;
    double jump;    /* the step across the seam divided by the mean step inside */
    double rank;    /* share of the steps inside that are larger */
    double largest; /* share of lines without a larger step inside */
    double lean;    /* mean of x/z (y/z) along the lines: a slope */
} ntp_seam;

/*
 * Says whether a texture tiles.  x is for the left and right edges, y for the upper and lower ones.
 * It reads at most 128 rows and 128 columns, and uses red and green.  Undecided are textures below
 * 16 x 16 texels, nearly flat ones, those with many unused texels at the edges, those with flat
 * edges but not flat inside, and those with neither a clear seam nor clearly none.  src->ring_rows
 * is 0. One of x and y may be NULL: it is not computed.
 */
NTP_API ntp_status ntp_find_seams(ntp_seam *x, ntp_seam *y, const ntp_const_image *src,
                                  uint32_t touch_unused);

/*
 * The borders for ntp_curvature and ntp_occlusion of a texture of which nothing is known: x for the
 * left and right edges, y for the others.  NTP_BORDER_CLAMP where it clearly does not tile, else
 * NTP_BORDER_WRAP.  It does not where the step of heights (sample 0), or of x and y of normals, from
 * an edge to the opposite one is more than 1.5 times the highest between two columns (rows) inside,
 * as the rms of up to 128 lines.  Of normals ntp_find_seams comes first; where that is undecided
 * its closure must be 0.3, too.  Sides below 16 texels wrap.  ring_rows is 0.
 */
NTP_API ntp_status ntp_relief_borders(ntp_border *x, ntp_border *y, const ntp_const_image *src);

/* Slope quantization caused by low-bit heights. */
typedef struct ntp_steps {
    int32_t decided; /* 1: slopes are quantized; 0: they are not, or it is unknown, and the rest is
                      * 0 */
    int32_t teeth;   /* different multiples of the step that occur, without 0 and signs; on both
                      * axes */
    double slope;    /* the step */
    double degrees;  /* the angle between a flat normal and the next */
    double share;    /* of the texels that lie on a multiple, within rounding */
    double expected; /* the share that is expected by chance */
} ntp_steps;

/*
 * Detects slope quantization.  Slopes of a low-bit heightfield, such as an 8-bit one, are whole
 * multiples of one step, and smooth ground becomes flat terraces with edges between them (banding).
 * It uses red and green, and reads at most 16384 texels for each axis.  Not detected are steps of
 * about the size of the texture's own levels, gentle textures in which evenly spaced slopes and
 * levels are the same, fewer than 4 multiples (large smooth shapes have no more, but beveled tiles
 * neither), and steps along one axis only.  src->ring_rows is 0.
 */
NTP_API ntp_status ntp_find_steps(ntp_steps *steps, const ntp_const_image *src,
                                  uint32_t touch_unused);

enum { NTP_BORDERS = 5 /* as many as ntp_border has */ };

/* Which border the normals at two opposite edges were made with. */
typedef struct ntp_border_fit {
    ntp_border border;
    int32_t decided; /* 1: the texels show it; 0: it is the one that is likely to do least harm */
    /* By ntp_border: rms difference of x and y between the normals of the heights and those at the
     * edges, in levels of 8 bit; -1: not tried */
    double error[NTP_BORDERS];
} ntp_border_fit;

/* The border to reconstruct with if it is unknown: slopes at the edge do not matter. */
NTP_API ntp_border ntp_free_border(ntp_kernel kernel);

/*
 * Detects the border along x (down nonzero: along y).  heights are those of src by least squares,
 * with ntp_free_border for the border to be found; NTP_TYPE_F32 NTP_ENCODING_HEIGHT.  From `how` it
 * uses the method, kernel, dx, dy and touch_unused; borders that the method does not support are
 * not tried.  wraps is the result of ntp_find_seams, or 0 without one; wrap is preferred if it fits
 * about as well as the best.  Undecided are textures below 16 x 16 texels, baked ones, and those
 * that no border fits.  ring_rows is 0 in both.
 * Errors: NTP_ERR_ARGUMENT for how NULL, or a kernel, method, dx, dy or touch_unused out of range;
 * NTP_ERR_FORMAT for other heights.
 */
NTP_API ntp_status ntp_find_border(ntp_border_fit *fit, const ntp_const_image *src,
                                   const ntp_const_image *heights, const ntp_height_options *how,
                                   int32_t down, int32_t wraps);

/* Bytes of working memory of ntp_find_borders; 0 if an argument is invalid. */
NTP_API size_t ntp_find_borders_scratch_size(const ntp_height_options *how, int32_t width,
                                             int32_t height, int32_t parts);

/*
 * Detects the borders of both axes, along x in fit[0] and along y in fit[1], from bands of the
 * texture that reach from edge to edge: the rows, and the columns, with the most slope at the two
 * edges.  Bands have 32 lines or more, up to 1/64 of all; sides of up to 128 are used whole.
 * An axis wraps if no texel slopes along it (red, or green, is at the two levels beside 0
 * everywhere).  If ntp_find_seams says wrap for all axes that are open, bands are solved so, and that is the answer
 * if normals fit to 0.4 levels of 8 bit, and those at the edges to 0.8.  Else each is solved with
 * ntp_free_border, and ntp_find_border decides.  If that cannot, and the fit is worse than 0.4
 * levels, wrap is tried, and extrapolate and clamp if their error at the edges is at most twice the
 * least (extrapolate after wrap in any case); the border with the least residual is taken if that is
 * less by 1 %, and decided if it is less by 3 %.
 * Textures that fit worse than that, whose lengths show damage and whose blue is z, are asked before:
 * from the slopes along up to 512 lines, and along the two edges, it is estimated what a free border
 * costs the heights, which adds up errors, and what wrap costs, which bends them where they do not meet.
 * If wrap costs clearly less it is taken, and not decided.  If both show the same steps between the ends,
 * wrap is not tried.  Only for NTP_HEIGHT_AUTO, and square texels.  Nor is extrapolate decided where
 * normals fit that badly, and those at the edges fit wrap within 5 times: smooth ground goes on.
 * how: as for ntp_height_from_normals; the borders are those of the axes that are not `open`.  Only
 * NTP_HEIGHT_AUTO and NTP_HEIGHT_POISSON_DCT without a mask are solved, NTP_KERNEL_BAKED as central;
 * else, and for sides below 16 texels, fit[i] is what `wraps` says, or undecided.  open, wraps: nonzero for
 * the axes whose border is to be found, and that ntp_find_seams says wrap.  fit[i].error is -1
 * where ntp_find_border was not asked, and fit[i] is that of `how` where the axis is not open.
 * scratch: aligned to 64.  hooks may be NULL.  src->ring_rows is 0.
 * Errors: those of ntp_height_from_normals, but NTP_ERR_FORMAT for kernels and borders that cannot
 * be solved: then fit is undecided.
 */
NTP_API ntp_status ntp_find_borders(ntp_border_fit fit[2], const ntp_const_image *src,
                                    const ntp_height_options *how, const int32_t open[2],
                                    const int32_t wraps[2], void *scratch, size_t scratch_size,
                                    const ntp_hooks *hooks);

/* --- cdef end --- */

#ifdef __cplusplus
}
#endif

#endif /* LIBNTP_H */
