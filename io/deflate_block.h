/* SPDX-License-Identifier: MIT */
/*
 * deflate_block.h - symbols of deflate, and how a block of them becomes bits (RFC 1951)
 */
#ifndef NTPIO_DEFLATE_BLOCK_H
#define NTPIO_DEFLATE_BLOCK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum {
    NTPIO__LITERALS = 256,
    NTPIO__FIRST_LENGTH = 257, /* after the literals and the end of the block */
    NTPIO__WORDS = 286,        /* literals, the end, slots of lengths */
    NTPIO__DISTANCES = 30,     /* slots of distances */
    NTPIO__LENGTH_MAX = 258    /* of a match */
};

/* A match: length << 16 | distance - 1; 0: none. */
typedef uint32_t ntpio__match;

/* Literals, which stand in the bytes themselves, and the match after them. */
typedef struct ntpio__step {
    uint32_t literals;
    ntpio__match match;
} ntpio__step;

typedef struct ntpio__counts {
    uint32_t words[NTPIO__WORDS], distances[NTPIO__DISTANCES];
} ntpio__counts;

typedef struct ntpio__bits {
    uint8_t *out;
    size_t size; /* whole bytes in out */
    uint64_t waiting;
    unsigned count; /* bits that wait; below 8 between calls */
    bool stored;    /* bytes were put as they are, so the place of whole bytes matters */
} ntpio__bits;

static inline unsigned ntpio__top_bit(uint32_t v)
{
    return 31 - (unsigned) __builtin_clz(v);
}

/*
 * Slots of lengths grow by a bit after every four, those of distances after every two; the first of them
 * have no extra bits.  No branches: matches are hard to foresee.
 */
static inline unsigned ntpio__length_extra(uint32_t length)
{
    return length == NTPIO__LENGTH_MAX ? 0 : ntpio__top_bit((length - 3) | 4) - 2;
}

static inline unsigned ntpio__length_slot(uint32_t length)
{
    const uint32_t v = length - 3, extra = ntpio__top_bit(v | 4) - 2;
    return 4 * extra + (v >> extra) + (length == NTPIO__LENGTH_MAX);
}

static inline unsigned ntpio__distance_extra(uint32_t less_one)
{
    return ntpio__top_bit(less_one | 2) - 1;
}

static inline unsigned ntpio__distance_slot(uint32_t less_one)
{
    const uint32_t extra = ntpio__distance_extra(less_one);
    return 2 * extra + (less_one >> extra);
}

/* At most 63 bits may wait.  Writes eight bytes, of which the whole ones count. */
static inline void ntpio__flush_bits(ntpio__bits *b)
{
    uint64_t waiting = b->waiting;
#if defined __BYTE_ORDER__ && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    waiting = __builtin_bswap64(waiting);
#endif
    memcpy(b->out + b->size, &waiting, sizeof waiting);
    b->size += b->count / 8;
    b->waiting >>= b->count / 8 * 8;
    b->count %= 8;
}

static inline void ntpio__add_bits(ntpio__bits *b, uint32_t value, unsigned count)
{
    b->waiting |= (uint64_t) value << b->count;
    b->count += count;
}

static inline void ntpio__put_bits(ntpio__bits *b, uint32_t value, unsigned count)
{
    ntpio__add_bits(b, value, count);
    ntpio__flush_bits(b);
}

/* Writes what waits, filled with zeros to a whole byte. */
void ntpio__end_byte(ntpio__bits *b);

/* Bytes as they are; an empty run ends at a whole byte, and no more. */
void ntpio__put_stored(ntpio__bits *b, const uint8_t *bytes, size_t size, bool last);

/*
 * The shortest of three kinds of a block: codes made for it, codes that are fixed, bytes as they
 * are.  The steps stand for the bytes; counts has all their symbols without the end of the block,
 * which is counted here.
 */
void ntpio__put_block(ntpio__bits *b, const ntpio__step *steps, size_t count, ntpio__counts *counts,
                      const uint8_t *bytes, size_t size, bool last);

#endif
