/* SPDX-License-Identifier: MIT */
/*
 * turn_avx512.h - angles between vectors and clean ones, from what is made of them, with AVX-512
 */
#ifndef NTP_TURN_AVX512_H
#define NTP_TURN_AVX512_H

#include <immintrin.h>
#include <stdint.h>

/* What the angles of n vectors are made of that are not too long, with x(x + 1) + y(y + 1), z and the root of what
 * is left for it: those of harm, so to the other z where this is below the horizon; then those of the latter, which
 * masks say, to their clean vectors.  Returns how many they are. */
int32_t ntp__flat_vectors_avx512(double *s8, double *d8, const int32_t *xy, const int32_t *z8,
                                 const int32_t *root, const __mmask16 *is_lower, int32_t n);

/* n angles, and up to whole lanes of eight.  Returns how many are in doubt; these are `at`.  `base` is working
 * memory, as is s from then on. */
int32_t ntp__turns_avx512(int32_t *angle, int32_t *at, double *base, double *s, const double *d,
                          int32_t n);

#endif
