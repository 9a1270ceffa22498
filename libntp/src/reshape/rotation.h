/* SPDX-License-Identifier: MIT */
/*
 * rotation.h - what the two parts of ntp__rotate share
 */
#ifndef NTP_ROTATION_H
#define NTP_ROTATION_H

#include "reshape/rotate.h"

enum {
    NTP__PLACE_BITS = 15,
    NTP__ONE_TEXEL = 1 << NTP__PLACE_BITS,
    NTP__DROPPED_BITS = NTP__UNIT_BITS + 1 - NTP__PLACE_BITS,
    NTP__ROTATED_AT_ONCE = 128 /* texels: what is known of them stays in the first cache */
};

typedef struct ntp__rotation {
    const ntp_image *dst;
    const ntp_const_image *src;
    const ntp_transform_options *how;
    ntp__strength strength;
    ntp__turn turn;
    double by[2][2]; /* what x and y of a sum add to x, and to y, of the result */
    ntp_part part;
    int32_t m;
    bool extra;    /* the third sample is no component of a vector */
    bool by_alpha; /* which is a part of the weights */
    bool quick;    /* ntp__rotate_rgb_avx2 is for this */
} ntp__rotation;

/* Places along one axis of the source: those of texels side by side are one step apart. */
typedef struct ntp__axis {
    int64_t from, step; /* in 2^-NTP__DROPPED_BITS of 1/NTP__ONE_TEXEL, which are dropped */
    ntp_border border;
    int32_t side, first, n; /* of the picture; of it src has n from the first on */
} ntp__axis;

/* Those from (x, y) of the picture on. */
void ntp__find_axes(const ntp__rotation *j, ntp__axis axes[2], int32_t x, int32_t y);

/* The places of some texels in the source. */
typedef struct ntp__places {
    /* columns and rows of the texels around each, the lower and the higher ones: in bytes */
    ptrdiff_t at[2][2][NTP__ROTATED_AT_ONCE];
    double share[2][2][NTP__ROTATED_AT_ONCE]; /* of these; in whole 1/NTP__ONE_TEXEL */
} ntp__places;

/* Those of n texels from (x, y) of the picture on. */
void ntp__find_places(const ntp__rotation *j, ntp__places *p, int32_t x, int32_t y, int32_t n);

/* Texel i by integers, into texel i of a block. */
void ntp__rotate_texel(const ntp__rotation *j, ntp__block *out, const ntp__places *p, int32_t i);

/* The levels of n texels, NTP__ROTATED_AT_ONCE or fewer, from (x, y) of the picture on. */
void ntp__rotate_run(const ntp__rotation *j, ntp__block *out, int32_t x, int32_t y, int32_t n);

/* Packed RGB of 8 bit, from (x, y) of the picture on, to d: sums of levels fit in 32 bits.  Returns how many texels
 * are in doubt, and their places in `at`. */
bool ntp__can_rotate_rgb(const ntp__rotation *j);
int32_t ntp__rotate_rgb_avx2(const ntp__rotation *j, uint8_t *d, int32_t *at, int32_t x, int32_t y,
                             int32_t n);

#endif
