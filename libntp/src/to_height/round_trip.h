/* SPDX-License-Identifier: MIT */
/*
 * round_trip.h - compares the normals of a reconstructed heightfield with the stored normals
 */
#ifndef NTP_ROUND_TRIP_H
#define NTP_ROUND_TRIP_H

#include "base/parts.h"
#include "base/scratch.h"
#include "to_height/shared/slopes.h"
#include "to_height/shared/slope_operator.h"

enum { NTP__ROUND_TRIP_ROWS = 5 };

typedef struct ntp__round_trip_part {
    double *row[NTP__ROUND_TRIP_ROWS];
} ntp__round_trip_part;

typedef struct ntp__round_trip {
    const ntp__slopes *slopes; /* stored */
    const ntp_const_image *mask;
    int32_t width, height;
    double dx, dy;
    ntp_rect seen; /* the area that the residual looks at */
    int32_t rows;  /* the most rows of it that are looked at */
    ntp__stencil *stencil;
    ntp__round_trip_part *parts;
    ntp__crew crew;
    double *sum;     /* of each row */
    uint64_t *count; /* of each row */
    ntp__plane heights;
    double inside;       /* the share of a box that has no excess */
    bool blue;           /* blue has an excess as well */
    float *right, *down; /* packed planes that the excess writes */
} ntp__round_trip;

/* Lays out its memory, or measures it where memory->base is NULL (slopes NULL then). */
void ntp__round_trip_init(ntp__round_trip *r, const ntp__slopes *slopes,
                          const ntp__height_plan *plan, ntp__crew crew, ntp__scratch *memory);

/* Makes the heights of holes NaN, in a packed plane or in an image.  Slopes that read one then do
 * not count. */
void ntp__round_trip_mark_holes(const ntp__round_trip *r, double *heights, const ntp_image *dst);

/* The root mean square of x and y less the stored ones, in levels.  Unused texels do not count.
 * Negative: no texel counts. */
double ntp__round_trip_residual(ntp__round_trip *r, const ntp__plane *heights);

/*
 * Half the sum of the squared excess, in levels.  Writes to right, down its derivatives by the
 * slopes of the stencil, which the spacing of texels has not divided; NULL: nothing is written.
 * *off is the number of texels that round to other levels.
 */
double ntp__round_trip_excess(ntp__round_trip *r, const ntp__plane *heights, float *right,
                              float *down, uint64_t *off);

/* Decides r->blue: true where z is as stored, and every blue was rounded from the same vector as its
 * red and green.  Blue that was derived after rounding adds nothing to these. */
void ntp__round_trip_see_blue(ntp__round_trip *r);

#endif
