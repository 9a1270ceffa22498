/* SPDX-License-Identifier: MIT */
/*
 * png_pack.h - the rows of a picture, filtered and packed band by band
 */
#ifndef NTPIO_PNG_PACK_H
#define NTPIO_PNG_PACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { NTPIO__PACKED_ROW_MAX = 1 << 20 }; /* bytes: 131072 texels of RGBA with 16 bits */

typedef struct ntpio__png_packer ntpio__png_packer;

/* Rows of at most NTPIO__PACKED_ROW_MAX bytes, texels of `texel` bytes.  NULL without memory. */
ntpio__png_packer *ntpio__png_packer_new(size_t row_size, uint32_t height, size_t texel, int level);
void ntpio__png_packer_free(ntpio__png_packer *p);

/*
 * Takes the next row; swap: the two bytes of its samples.  Returns the size of the stream's next
 * part, which *packed shows until the next call, or 0 while a band is not full.  All parts together
 * are a zlib stream, and depend on the rows and the level alone.
 */
size_t ntpio__png_pack_row(ntpio__png_packer *p, const uint8_t *row, bool swap,
                           const uint8_t **packed);

#endif
