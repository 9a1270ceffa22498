/* SPDX-License-Identifier: MIT */
/*
 * inflate_table.h - tables of deflate's codes, for inflate.c
 *
 * A code is looked up by its next bits; longer ones go on in a table of their own.  An entry says
 * all there is to know: how many bits are used, and a literal or the base and extra bits of a
 * length.
 */
#ifndef NTPIO_INFLATE_TABLE_H
#define NTPIO_INFLATE_TABLE_H

#include <stdbool.h>
#include <stdint.h>

/* Entries: bits 0 to 7: bits used, those of the extra ones included.  Bits 8 to 12: without those,
 * or in a link the bits that choose in its table.  Bits 13 to 15: what it is.  16 and up: the
 * literal, the base, or where the table of a link begins. */
enum {
    NTPIO__LITERAL = 1 << 13,
    NTPIO__LINK = 1 << 14,
    NTPIO__SPECIAL = 1 << 15, /* the end of the block, or no code */
    NTPIO__NO_CODE = NTPIO__SPECIAL | 1 << 16,
    NTPIO__END_OF_BLOCK = 256,
    NTPIO__LITERALS_USED = 286, /* a good block has at most so many */
    NTPIO__DISTANCES_USED = 30,
    NTPIO__SYMBOLS_MAX = 288
};

/* Of what codes are: which entry a symbol has, without the bits of its code. */
typedef uint32_t ntpio__entry_of(unsigned symbol);
ntpio__entry_of ntpio__literal_entry, ntpio__distance_entry, ntpio__length_entry;

/*
 * Fills a table from the lengths of codes.  A code has to be complete; but there may be one
 * distance, of one bit, or none.  At most half of the symbols share a link with another one, so
 * the tables of inflate.h are large enough: a complete code has two words at least behind each.
 */
bool ntpio__make_table(uint32_t *table, unsigned bits, const uint8_t *sizes, unsigned symbols,
                       ntpio__entry_of *entry_of);

#endif
