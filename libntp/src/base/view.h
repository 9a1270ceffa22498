/* SPDX-License-Identifier: MIT */
/*
 * view.h - views over the caller's pixels: checks, addresses, blocks of texels
 *
 * All other rooms stand on this one.  It is about pixels, memory, numbers and the processor; the
 * arithmetic of normals begins in texel/.
 *   view.h, view.c      checks of views and areas; pixels to levels and back
 *   rgb_avx2.h, .c      the latter for packed RGB, where there is AVX2
 *   scratch.h           hands out the caller's working memory
 *   parts.h, parts.c    shares work out among the caller's threads
 *   finite.h            tests for infinity and NaN without libm
 *   int128.h            signed integers of 128 bits
 *   bignum.h, bignum.c  natural numbers of up to 2048 bits
 *   cpu.h, cpu.c        picks loops with or without AVX2
 *   inlining.h          what compilers are told about copies of code
 *
 * Operations on texels have one shape.  They check all arguments.  Then, for each row of the area
 * and each block of at most NTP__BLOCK texels, they unpack to planar levels, work, and pack.  So
 * most of them need not know about types, strides and channel counts.
 */
#ifndef NTP_VIEW_H
#define NTP_VIEW_H

#include "libntp.h"

#include <float.h>
#include <stdbool.h>

/* The bytes of results depend on it.  16 differs from 0 in floats of 16 bits only. */
#if FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#  error "floats are computed as doubles: add -fexcess-precision=fast (x86: -msse2 -mfpmath=sse)"
#endif

enum {
    NTP__BLOCK = 256 /* texels; a block is 4 KiB of levels, which stays in the first cache */
};

/* Planar levels of a run of texels.  Floats are rounded to 16-bit levels. */
typedef struct ntp__block {
    int32_t c[4][NTP__BLOCK]; /* an absent blue or alpha is M; gray fills r, g and b */
    uint8_t
        broken[NTP__BLOCK]; /* 1: not finite, or a float vector of length 0; set when any_broken */
    bool any_broken;
} ntp__block;

#define NTP__TRY(expr)                                                                             \
    do {                                                                                           \
        ntp_status ntp__status_ = (expr);                                                          \
        if (ntp__status_ != NTP_OK)                                                                \
            return ntp__status_;                                                                   \
    } while (0)

/* M of a type: floats are judged at 16 bit. */
static inline int32_t ntp__max(ntp_type type)
{
    return type == NTP_TYPE_U8 ? 255 : 65535;
}

static inline ptrdiff_t ntp__sample_size(ntp_type type)
{
    return type == NTP_TYPE_U8 ? 1 : type == NTP_TYPE_U16 ? 2 : 4;
}

static inline int32_t ntp__ring_row(int32_t ring_rows, int32_t y)
{
    return ring_rows > 0 ? y % ring_rows : y;
}

static inline const void *ntp__at(const ntp_const_image *v, int32_t x, int32_t y)
{
    return (const char *) v->data + (ptrdiff_t) ntp__ring_row(v->ring_rows, y) * v->row_stride +
           (ptrdiff_t) x * v->pixel_stride;
}

static inline void *ntp__at_mut(const ntp_image *v, int32_t x, int32_t y)
{
    return (char *) v->data + (ptrdiff_t) ntp__ring_row(v->ring_rows, y) * v->row_stride +
           (ptrdiff_t) x * v->pixel_stride;
}

/* A well-formed view whose encoding, type and channels go together. */
ntp_status ntp__check_view(const ntp_const_image *view);
/* The same, and an encoding of normals. */
ntp_status ntp__check_normals(const ntp_const_image *view);
/* The image mirrored about its diagonal: its columns become rows.  Not for a ring of rows. */
ntp_const_image ntp__transposed(const ntp_const_image *view);
/* A U8 picture of min_channels to max_channels. */
ntp_status ntp__check_picture(const ntp_const_image *view, int32_t min_channels,
                              int32_t max_channels);
/* Fills in rect from area (NULL: all of the view), and checks that it lies inside. */
ntp_status ntp__check_area(ntp_rect *rect, const ntp_const_image *view, const ntp_rect *area);

static inline bool ntp__same_size(const ntp_const_image *a, const ntp_const_image *b)
{
    return a->width == b->width && a->height == b->height;
}

/* Samples lie side by side without gaps between pixels. */
static inline bool ntp__is_packed(const ntp_const_image *v)
{
    return v->pixel_stride == (ptrdiff_t) v->channels * ntp__sample_size(v->type);
}

/* Reads n <= NTP__BLOCK texels of row y from column x on. */
void ntp__unpack(ntp__block *block, const ntp_const_image *view, int32_t x, int32_t y, int32_t n);

/* Writes the first `channels` planes as integer samples (NTP_TYPE_U8, NTP_TYPE_U16). */
void ntp__pack(const ntp_image *view, const ntp__block *block, int32_t x, int32_t y, int32_t n,
               int32_t channels);

/* Float samples of a run of texels, as planes. */
typedef float ntp__float_planes[4][NTP__BLOCK];

/* The nearest floats to c/M of n levels, or to (2c - M)/M of components. */
void ntp__floats_of_levels(float *to, const int32_t *level, int32_t n, int32_t m, bool component);

/* Writes the first planes, one for each channel of the view, as floats. */
void ntp__pack_floats(const ntp_image *view, ntp__float_planes planes, int32_t x, int32_t y,
                      int32_t n);

/* A float sample in 0..1 as a 16-bit level: rounded half up, clamped, exact for every float. */
int32_t ntp__level_of_unit(float v);

#endif
