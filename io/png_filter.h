/* SPDX-License-Identifier: MIT */
/*
 * png_filter.h - the row filters of PNG, done and undone
 *
 * PNG stores each byte of a row as the difference from what a filter foretells from the texel to
 * the left (a), above (b) and above left (c): PNG specification, third edition, section 9.
 */
#ifndef NTPIO_PNG_FILTER_H
#define NTPIO_PNG_FILTER_H

#include <stddef.h>
#include <stdint.h>

enum {
    NTPIO__AVERAGE = 3,
    NTPIO__FILTERS = 5,  /* None, Sub, Up, Average, Paeth: their numbers in the file */
    NTPIO__TEXEL_MAX = 8 /* bytes */
};

/*
 * Undoes filter `kind` in a row of `size` bytes, in place.  `above`: the row above, undone, or NULL
 * in the first row.  `texel`: bytes of a texel, 1 to 4, 6 or 8, of which `size` is a multiple.
 */
void ntpio__unfilter(uint8_t *row, const uint8_t *above, size_t size, size_t texel, int kind);

enum { NTPIO__ROWS_TOGETHER = 4 };

/*
 * The same for a row and, if that is faster together, for some of those below it, of which
 * `count` - 1 are there: NTPIO__ROWS_TOGETHER with the first one at most.  Each begins `stride` after
 * the one above.  Returns how many are undone.
 */
uint32_t ntpio__unfilter_rows(uint8_t *row, ptrdiff_t stride, uint32_t count, const uint8_t *above,
                              size_t size, size_t texel, const int *kinds);

/* Filters a row into `out`.  A texel of zeros stands before both rows; the row above the first one is
 * zeros. */
void ntpio__filter(uint8_t *out, const uint8_t *row, const uint8_t *above, size_t size,
                   size_t texel, int kind);

/*
 * The sum of what each of the five filters would write, each byte as its distance from 0 modulo 256:
 * the smallest is the usual guess at which filter packs best.
 */
void ntpio__filter_sums(const uint8_t *row, const uint8_t *above, size_t size, size_t texel,
                        uint64_t *of_kinds);

/* Both with AVX-512 or AVX2, of as many of the first bytes as fit in its registers: returns how many. */
size_t ntpio__filter_avx512(uint8_t *out, const uint8_t *row, const uint8_t *above, size_t size,
                            size_t texel, int kind);
size_t ntpio__filter_sums_avx512(const uint8_t *row, const uint8_t *above, size_t size,
                                 size_t texel, uint64_t *of_kinds);
size_t ntpio__filter_avx2(uint8_t *out, const uint8_t *row, const uint8_t *above, size_t size,
                          size_t texel, int kind);
size_t ntpio__filter_sums_avx2(const uint8_t *row, const uint8_t *above, size_t size, size_t texel,
                               uint64_t *of_kinds);

#endif
