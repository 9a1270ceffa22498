/* SPDX-License-Identifier: MIT */
/* png_sums.h - the checksums of PNG: by libdeflate where it is there, which is faster than zlib */
#ifndef NTPIO_PNG_SUMS_H
#define NTPIO_PNG_SUMS_H

#include <stddef.h>
#include <stdint.h>
#ifdef NTPIO_HAVE_LIBDEFLATE
#  include <libdeflate.h>
#else
#  include <zlib.h>
#endif

/* Of a chunk's name and data; begins with 0. */
static inline uint32_t ntpio__crc32(uint32_t sum, const uint8_t *bytes, size_t size)
{
#ifdef NTPIO_HAVE_LIBDEFLATE
    return libdeflate_crc32(sum, bytes, size);
#else
    return (uint32_t) crc32_z(sum, bytes, size);
#endif
}

/* Of what a zlib stream holds; begins with 1. */
static inline uint32_t ntpio__adler32(uint32_t sum, const uint8_t *bytes, size_t size)
{
#ifdef NTPIO_HAVE_LIBDEFLATE
    return libdeflate_adler32(sum, bytes, size);
#else
    return (uint32_t) adler32_z(sum, bytes, size);
#endif
}

#endif
