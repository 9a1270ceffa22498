/* SPDX-License-Identifier: MIT */
/*
 * mix_avx2.h - packed RGB made stronger, or blended, with AVX2
 *
 * All texels are of the standard encoding, of 8 bit or of 16 (deep).
 */
#ifndef NTP_MIX_AVX2_H
#define NTP_MIX_AVX2_H

#include "base/view.h"
#include "reshape/blend_kernels.h"

/* How rows are made.  All pictures are packed. */
typedef struct ntp__mixing {
    const ntp_image *dst;
    const ntp_const_image *base, *detail; /* detail: NULL, or what repeats; dst may be base */
    /* Without a detail x and y are swapped, mirrored, and multiplied by the strength, 2^-10 to 2^10 */
    double strength;
    bool swap, mirror_x, mirror_y;
    /* With one; its strength is at most NTP__MOST_MIXED */
    const ntp__mixture *how;
    bool reoriented, exact;
    uint32_t touch_unused;
    /* Makes texels from base, in place, and detail: of those in doubt or too long. */
    void (*settle)(const void *job, ntp__block *base, ntp__block *detail, int32_t n);
    const void *job;
} ntp__mixing;

enum { NTP__MOST_MIXED = 64 };

/* Is a picture packed RGB of levels, in the standard encoding? */
static inline bool ntp__can_mix(const ntp_const_image *v)
{
    return v->type != NTP_TYPE_F32 && v->channels == 3 && v->encoding == NTP_ENCODING_STANDARD &&
           ntp__is_packed(v);
}

/* Makes row y from column x0 up to x1. */
void ntp__mix_row_avx2(const ntp__mixing *j, int32_t x0, int32_t x1, int32_t y);

/* Numerators over M of a block, with room for what is done beyond it. */
typedef float ntp__mix_planes[3][NTP__BLOCK + 16];

typedef struct ntp__mix_terms ntp__mix_terms;

/* n vectors of base and detail, blended in double, or in float. */
typedef void ntp__mix_vectors_fn(ntp__mix_planes v, ntp__mix_planes base, ntp__mix_planes detail,
                                 int32_t n, const ntp__mix_terms *t);

/* What a blend is made with, as in blend_kernels.h. */
struct ntp__mix_terms {
    double strength, turn, m, base_z, detail_z, product;
    bool reoriented;
    ntp__mix_vectors_fn *mix;
};

ntp__mix_vectors_fn ntp__mix_doubles_avx512;

/* What vectors become, where floats decide their levels. */
typedef struct ntp__mix_rounding {
    float half, less, least2; /* M/2; what x or y may be off by; the least square of a length */
} ntp__mix_rounding;

/* Pairs of levels of x, y less that of 0, of n vectors, a multiple of 16; marks those in doubt. */
typedef void ntp__round_pairs_fn(int32_t *pair, int32_t *left, ntp__mix_planes v, int32_t n,
                                 const ntp__mix_rounding *how);
ntp__round_pairs_fn ntp__round_pairs_avx512;

typedef struct ntp__mix_constants {
    bool deep;
    int32_t m;
    float least_z; /* the least z that is sure */
    ntp__mix_rounding rounding;
    bool avx512;
    float black, white; /* all numerators of texels without a normal; NaN: those hold one */
} ntp__mix_constants;

/* What a block becomes: vectors of any length; pairs of levels of x, y less that of 0; negative where a
 * texel is left to the caller.  Each loop does one thing: while a processor waits for a root it does
 * others. */
typedef struct ntp__mix_block {
    /* Whole lines of the cache, so that no load needs two. */
    _Alignas(64) ntp__mix_planes base, detail, v;
    int32_t pair[NTP__BLOCK], left[NTP__BLOCK + 16];
    bool any_kept, blends; /* may a texel stay as it is in the base?  is there a detail? */
} ntp__mix_block;

/* The levels of n vectors as packed pixels; returns how many are left to the caller, and their places. */
int32_t ntp__put_levels_avx2(uint8_t *d, int32_t *at, ntp__mix_block *p, int32_t n,
                             const ntp__mix_constants *c);

#endif
