/* SPDX-License-Identifier: MIT */
/* sums.h - what the operations in sums.c share. */
#ifndef NTP_TESTS_ELSEWHERE_SUMS_H
#define NTP_TESTS_ELSEWHERE_SUMS_H

#include "libntp.h"

#include <stdbool.h>

extern int share;           /* 1 in so many triplets is tried */
extern const char *current; /* the operation, for messages */

enum { WIDE = 93, HIGH = 77, NARROW = 45, LOW = 38 }; /* pictures, and those for slow operations */

static const uint64_t seed = 0xcbf29ce484222325u; /* of a hash */

#define OK(call) need((call) == NTP_OK, #call)

void need(bool holds, const char *what);
/* Numbers and samples are hashed by value, not by the order of their bytes. */
uint64_t hash_number(uint64_t hash, uint64_t number);
uint64_t hash_double(uint64_t hash, double value);
uint64_t hash_image(uint64_t hash, const ntp_image *image);

void *reserve(size_t size); /* zeroed, aligned to 64 */
ntp_image picture(int32_t width, int32_t height, int32_t channels, ntp_type type,
                  ntp_encoding encoding);
ntp_image make_heights(int width, int height, ntp_type type); /* smooth noise */
ntp_image make_normals(int width, int height, ntp_type type, ntp_encoding encoding,
                       int32_t channels);
/* Some levels are wrong, and some texels unused. */
ntp_image make_damaged(int width, int height, ntp_type type, ntp_encoding encoding,
                       int32_t channels);

/* The operations. */
uint64_t validate(ntp_type type);
uint64_t clean(ntp_type type);
uint64_t convert(ntp_type type);
uint64_t clean_picture(ntp_type type);
uint64_t inspect(ntp_type type);
uint64_t measure(ntp_type type);
uint64_t levels_off(ntp_type type);
uint64_t difference(ntp_type type);
uint64_t pictures(ntp_type type);
uint64_t which_way_green(ntp_type type);
uint64_t find_kernel(ntp_type type);
uint64_t find_seams(ntp_type type);
uint64_t find_borders(ntp_type type);
uint64_t normals_from_height(ntp_type type);
uint64_t relief(ntp_type type);
uint64_t heights_direct(ntp_type type);
uint64_t heights_refined(ntp_type type);
uint64_t heights_weighted(ntp_type type);
uint64_t heights_summed(ntp_type type);
uint64_t depth(ntp_type type);
uint64_t resize(ntp_type type);
uint64_t transform(ntp_type type);
uint64_t blend(ntp_type type);
uint64_t curvature(ntp_type type);
uint64_t occlusion(ntp_type type);
uint64_t blur(ntp_type type);
uint64_t blocks(ntp_type type);

#endif
