/* SPDX-License-Identifier: MIT */
/*
 * picture_kernels.h - loops over blocks of texels, compiled once for each instruction set
 *
 * All planes have room for whole groups (ntp__whole), and `n` is a whole number of these.
 */
#ifndef NTP_PICTURE_KERNELS_H
#define NTP_PICTURE_KERNELS_H

#include "base/view.h"

enum {
    NTP__STRONG = 255, /* strengths of faults; 0: there is none */
    NTP__WEAK = 128,
    NTP__SQUARINGS = 5 /* of a glint: the specular exponent is 2^5 = 32 */
};

/* Rec. 709 luma weights in ten-thousandths. */
enum {
    NTP__LUMA_RED = 2126,
    NTP__LUMA_GREEN = 7152,
    NTP__LUMA_BLUE = 722,
    NTP__LUMA_WHOLE = 10000
};

/* Faultless texels: 100 + luma/2, so 100..227, never taken for a fault. */
enum { NTP__GRAY_BASE = 100 };

/* Light falls so flat that it may not fall on the texel at all. */
#define NTP__EDGE_OF_LIGHT (32 * 0x1p-24F)

typedef struct ntp__faults {
    int32_t xy[NTP__BLOCK], length[NTP__BLOCK], z[NTP__BLOCK];
} ntp__faults;

/* What a sum of squares has to reach for a fault, and what else depends on M. */
typedef struct ntp__limits {
    int32_t m, zzero, xy_strong, short_weak, short_strong, long_weak, long_strong;
} ntp__limits;

/* How light falls on a texel, in floats. */
typedef struct ntp__lit {
    float lambert[NTP__BLOCK], glint[NTP__BLOCK];
    int32_t doubt[NTP__BLOCK]; /* not 0: a level may be wrong */
} ntp__lit;

typedef struct ntp__lamp {
    float m, up, twice, less; /* what makes vectors of levels; up = -1 turns y */
    float towards[3], half[3];
    float ambient, diffuse, specular;
    float off, off_by_glint; /* off + glint off_by_glint is a bound of the error */
    float white; /* 1: of a constant, compilers would make a branch that prevents vectors */
} ntp__lamp;

typedef struct ntp__picture_kernels {
    /* Has one of n texels a fault? */
    int32_t (*any_fault)(const ntp__block *block, int32_t n, const ntp__limits *how);
    /* The faults of x, y, and their squares less that of 1; returns how many are too long. */
    int32_t (*judge_pairs)(int32_t *fault, int32_t *xy, const int32_t *r, const int32_t *g,
                           int32_t n, const ntp__limits *how);
    /* The faults of the length and of z, from the squares of x, y. */
    void (*judge_blues)(ntp__faults *f, const int32_t *xy, const int32_t *b, int32_t n,
                        const ntp__limits *how);
    void (*make_gray)(ntp__block *out, const ntp__block *block, int32_t n, int32_t m);
    /* Colors of faults over gray, by the reference palette or by the safe one. */
    void (*paint)(ntp__block *out, const ntp__faults *f, int32_t n, int32_t safe);
    void (*light)(ntp__lit *lit, const ntp__block *block, int32_t n, const ntp__lamp *lamp);
    /* The levels of a color that reflects `own` of the light. */
    void (*show)(ntp__lit *lit, int32_t *level, int32_t n, const ntp__lamp *lamp, float own);
    /* |a by_a - b by_b|: the greatest goes to `most` and `greatest`; returns the sum. */
    int32_t (*differ)(int32_t *greatest, int32_t *most, const int32_t *a, const int32_t *b,
                      int32_t by_a, int32_t by_b, int32_t n);
    /* Micro-degrees as bins of 0.001 degrees; the greatest goes to `most`; returns the sum. */
    uint64_t (*bins)(int32_t *bin, int32_t *most, const int32_t *angle, int32_t n);
} ntp__picture_kernels;

/* The kernels for this processor. */
const ntp__picture_kernels *ntp__picture_loops(void);

#endif
