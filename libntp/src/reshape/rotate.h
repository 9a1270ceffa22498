/* SPDX-License-Identifier: MIT */
/*
 * rotate.h - turning a texture by an angle that is no multiple of 90 degrees
 */
#ifndef NTP_ROTATE_H
#define NTP_ROTATE_H

#include "texel/direction.h"

enum {
    NTP__UNIT_BITS = 30 /* of a sine */
};

/* An angle in 2^-32 of a degree, in 0..360 degrees; the double is at most NTP_MAX_ANGLE in size. */
int64_t ntp__ticks_of(double angle, int32_t quarter_turns);

/* A quarter turn. */
static inline int64_t ntp__quarter(void)
{
    return (int64_t) 90 << 32;
}

/* Cosine and sine in units of 2^-NTP__UNIT_BITS, rounded. */
typedef struct ntp__turn {
    int64_t cosine, sine;
} ntp__turn;

ntp__turn ntp__turn_of(int64_t ticks);

/* Turns by an angle; the views and options are good, and src and dst have the same size or lie in
 * how->part. */
void ntp__rotate(const ntp_image *dst, const ntp_const_image *src, const ntp_transform_options *how,
                 ntp__strength strength, int64_t ticks, const ntp_rect *area);

#endif
