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

/*
 * Entries: bits 0 to 7: bits used, those of the extra ones included.
 * Of literals: 8 to 15: the first one; 16 to 20: its bits, if there are two; 24 and 25: how many.
 * Of others: 8 to 12: 31 less the extra bits, or in a link the bits that choose in its table; 13 and
 * 14: what it is; 16 to 30: the base, or where the table of a link begins; 31 is set, but not in
 * distances and in lengths of codes.
 */
enum {
    NTPIO__SPECIAL = 1 << 13, /* the end of the block, or no code */
    NTPIO__LINK = 1 << 14,
    NTPIO__ONE_MORE = 1 << 24, /* literal */
    NTPIO__BASE = 0x7fff,      /* once shifted */
    NTPIO__NO_CODE = NTPIO__SPECIAL | 1 << 16,
    NTPIO__END_OF_BLOCK = 256,
    NTPIO__LITERALS_USED = 286, /* a good block has at most so many */
    NTPIO__DISTANCES_USED = 30,
    NTPIO__SYMBOLS_MAX = 288
};

#define NTPIO__NO_LITERAL (UINT32_C(1) << 31)

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

/*
 * Lets an entry of a literal use the bits of the next code, too, where that is another literal.  For
 * this its bits need not be known, only how many they are: what it is, is looked up when nothing
 * waits for it.
 */
void ntpio__pair_literals(uint32_t *table);

#endif
