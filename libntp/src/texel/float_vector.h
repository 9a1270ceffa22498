/* SPDX-License-Identifier: MIT */
/*
 * float_vector.h - float vectors to levels, correctly rounded
 */
#ifndef NTP_FLOAT_VECTOR_H
#define NTP_FLOAT_VECTOR_H

#include <stdint.h>

/*
 * level[i] = floor((M + 1 + M v[i]/L)/2), L the length of v: the encoding of v / L.  It is
 * correctly rounded for all finite floats that are not all 0.  *unsigned_z = floor(M |z|/L + 1/2).
 */
void ntp__vector_levels(int32_t level[3], int32_t *unsigned_z, const float v[3], int32_t m);

#endif
