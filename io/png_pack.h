/* SPDX-License-Identifier: MIT */
/*
 * png_pack.h - the rows of a picture, filtered and packed band by band
 */
#ifndef NTPIO_PNG_PACK_H
#define NTPIO_PNG_PACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Fuzzing makes both smaller. */
#ifndef NTPIO_PNG_BAND
#  define NTPIO_PNG_BAND (4 << 20)
#endif
#ifndef NTPIO_PNG_ROW_MAX
#  define NTPIO_PNG_ROW_MAX (1 << 20)
#endif

enum {
    NTPIO__PACKED_BAND = NTPIO_PNG_BAND,       /* bytes */
    NTPIO__PACKED_ROW_MAX = NTPIO_PNG_ROW_MAX, /* bytes: 131072 texels of RGBA with 16 bits */
    NTPIO__PACKERS_MAX = 16                    /* threads; each takes about 11 MB */
};

typedef struct ntpio__png_packer ntpio__png_packer;

/* Rows of at most NTPIO__PACKED_ROW_MAX bytes, texels of `texel` bytes; at most `threads` pack, the
 * caller's included.  NULL without memory. */
ntpio__png_packer *ntpio__png_packer_new(size_t row_size, uint32_t height, size_t texel, int level,
                                         int threads);
/* Before the first row: the same picture, nearly, was in a file of `size` bytes.  What comes out larger
 * is packed again with more care.  False: no memory. */
bool ntpio__png_packer_rival(ntpio__png_packer *p, uint64_t size);
void ntpio__png_packer_free(ntpio__png_packer *p);

/* Takes the next row; swap: the two bytes of its samples.  Whatever is packed is to be taken before
 * the next row. */
void ntpio__png_pack_row(ntpio__png_packer *p, const uint8_t *row, bool swap);

/*
 * Returns the size of the stream's next part, which *packed shows until the next call, or 0 while
 * there is none.  All parts together are a zlib stream; they depend on the rows and the level
 * alone, not on the threads.
 */
size_t ntpio__png_packed(ntpio__png_packer *p, const uint8_t **packed);

#endif
