/* SPDX-License-Identifier: MIT */
/*
 * png_filter.h - the row filters of PNG, undone
 *
 * PNG stores each byte of a row as the difference from what a filter foretells from the texel to
 * the left (a), above (b) and above left (c): PNG specification, third edition, section 9.
 */
#ifndef NTPIO_PNG_FILTER_H
#define NTPIO_PNG_FILTER_H

#include <stddef.h>
#include <stdint.h>

enum { NTPIO__FILTERS = 5 }; /* None, Sub, Up, Average, Paeth: their numbers in the file */

/*
 * Undoes filter `kind` in a row of `size` bytes, in place.  `above`: the row above, undone, or NULL
 * in the first row.  `texel`: bytes of a texel, 1 to 4, 6 or 8, of which `size` is a multiple.
 */
void ntpio__unfilter(uint8_t *row, const uint8_t *above, size_t size, size_t texel, int kind);

#endif
