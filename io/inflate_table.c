/* SPDX-License-Identifier: MIT */
/* inflate_table.c - tables of deflate's codes; see inflate_table.h */
#include "inflate_table.h"

#include <limits.h>
#include <string.h>

#include "inflate.h"

static uint32_t based(uint32_t base, unsigned extra)
{
    return base << 16 | (31 - extra) << 8 | extra;
}

uint32_t ntpio__literal_entry(unsigned symbol)
{
    static const uint8_t extra[] = { 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                     2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0 };
    static const uint16_t base[] = { 3,  4,  5,  6,   7,   8,   9,   10,  11, 13,
                                     15, 17, 19, 23,  27,  31,  35,  43,  51, 59,
                                     67, 83, 99, 115, 131, 163, 195, 227, 258 };
    if (symbol < NTPIO__END_OF_BLOCK)
        return NTPIO__ONE_MORE | symbol << 8;
    if (symbol == NTPIO__END_OF_BLOCK)
        return NTPIO__NO_LITERAL | NTPIO__SPECIAL;
    const unsigned i = symbol - NTPIO__END_OF_BLOCK - 1;
    return NTPIO__NO_LITERAL |
           (symbol < NTPIO__LITERALS_USED ? based(base[i], extra[i]) : NTPIO__NO_CODE);
}

uint32_t ntpio__distance_entry(unsigned symbol)
{
    if (symbol >= NTPIO__DISTANCES_USED)
        return NTPIO__NO_CODE;
    const unsigned extra = symbol < 4 ? 0 : symbol / 2 - 1;
    const uint32_t base = symbol < 4 ? symbol + 1 : ((2 + symbol % 2) << extra) + 1;
    return based(base, extra);
}

uint32_t ntpio__length_entry(unsigned symbol)
{
    return symbol << 16;
}

typedef struct code_of {
    uint32_t *table;
    unsigned bits, most; /* of a look-up; of the longest code */
    unsigned used;       /* entries */
    unsigned linked;     /* the last look-up that got a link */
} code_of;

/* The next code, as its bits come: the highest bit first, at the lowest place.  It is one more, from
 * its last bit on. */
static unsigned next_code(unsigned code, unsigned size)
{
    const unsigned zeros = code ^ ((1u << size) - 1);
    const unsigned bit = 1u << (31 - (unsigned) __builtin_clz(zeros | 1));
    return (code & (bit - 1)) | bit;
}

/* A code that is longer than a look-up goes on in a table that the entry of its begin links to. */
static void put_long(code_of *c, uint32_t entry, unsigned code, unsigned size)
{
    const unsigned at = code & ((1u << c->bits) - 1), more = c->most - c->bits;
    if (at != c->linked) { /* codes that begin alike follow one another */
        c->linked = at;
        c->table[at] =
            NTPIO__NO_LITERAL | NTPIO__LINK | c->bits | more << 8 | (uint32_t) c->used << 16;
        c->used += 1u << more;
    }
    uint32_t *const table = c->table + (c->table[at] >> 16 & NTPIO__BASE);
    const unsigned step = size - c->bits;
    entry += step;
    for (unsigned i = code >> c->bits; i < 1u << more; i += 1u << step)
        table[i] = entry;
}

/* Fills a table of a complete code, whose symbols are in the order of their codes. */
static void fill(code_of *c, const uint16_t *order, const unsigned *count,
                 ntpio__entry_of *entry_of)
{
    unsigned code = 0, size = 0, filled = 0;
    for (unsigned i = 0; size < c->most;) {
        size++;
        if (filled != 0 && size <= c->bits) { /* what comes after a shorter code does not matter */
            memcpy(c->table + filled, c->table, filled * sizeof *c->table);
            filled *= 2;
        }
        if (count[size] != 0 && filled == 0)
            filled = 1u << (size < c->bits ? size : c->bits);
        for (const unsigned end = i + count[size]; i < end; i++) {
            const uint32_t entry = entry_of(order[i]);
            if (size <= c->bits)
                c->table[code] = entry + size;
            else
                put_long(c, entry, code, size);
            code = next_code(code, size);
        }
    }
    for (; filled < 1u << c->bits; filled *= 2)
        memcpy(c->table + filled, c->table, filled * sizeof *c->table);
}

bool ntpio__make_table(uint32_t *table, unsigned bits, const uint8_t *sizes, unsigned symbols,
                       ntpio__entry_of *entry_of)
{
    unsigned count[NTPIO__CODE_MAX + 1] = { 0 }, next[NTPIO__CODE_MAX + 1] = { 0 };
    uint16_t order[NTPIO__SYMBOLS_MAX];
    code_of c = { .table = table, .bits = bits, .used = 1u << bits, .linked = UINT_MAX };
    for (unsigned i = 0; i < symbols; i++)
        count[sizes[i]]++;
    unsigned space = 0;
    for (unsigned size = 1; size <= NTPIO__CODE_MAX; size++) {
        next[size] = next[size - 1] + count[size - 1];
        space += count[size] << (NTPIO__CODE_MAX - size);
        c.most = count[size] != 0 ? size : c.most;
    }
    const bool complete = space == 1u << NTPIO__CODE_MAX;
    const bool few = entry_of == ntpio__distance_entry && c.most <= 1 && count[1] <= 1;
    if (!complete && !few)
        return false;
    for (unsigned i = 0; i < symbols; i++) /* those without a code come first */
        order[next[sizes[i]]++] = (uint16_t) i;
    const uint16_t *const coded = order + count[0];
    if (complete) {
        fill(&c, coded, count, entry_of);
        return true;
    }
    for (unsigned i = 0; i < 1u << bits; i++) /* half of them a distance, if there is one */
        table[i] = c.most != 0 && i % 2 == 0 ? entry_of(coded[0]) + 1 : NTPIO__NO_CODE;
    return true;
}

/*
 * sizes[2^k + w], for all k: how long the code of a literal is that begins with the k bits w; 0: they
 * do not tell, or it is longer than a look-up, or no literal.  Bits count from the lowest on, so w is
 * the end of two longer ones, w and w + 2^k.
 */
void ntpio__pair_literals(uint32_t *table)
{
    enum { WORDS = 1 << NTPIO__LITERAL_BITS, FEW = WORDS / 4 };
    uint8_t sizes[2 * WORDS];
    uint32_t added[NTPIO__LITERAL_BITS + 1] = { 0 }; /* branches would often be foreseen wrongly */
    unsigned literals = 0;
    for (unsigned i = 0; i < WORDS; i++) {
        const bool is_literal = (table[i] & NTPIO__NO_LITERAL) == 0;
        sizes[WORDS + i] = is_literal ? (uint8_t) table[i] : 0;
        literals += is_literal;
    }
    if (literals < FEW) /* pairs are rare, and this takes as long as 500 literals */
        return;
    for (unsigned half = WORDS / 2; half > 0; half /= 2) {
        const uint8_t *const zero = sizes + 2 * half, *const one = zero + half;
        for (unsigned i = 0; i < half; i++)
            sizes[half + i] = zero[i] == one[i] ? zero[i] : 0;
    }
    for (unsigned more = 1; more <= NTPIO__LITERAL_BITS; more++)
        added[more] = NTPIO__ONE_MORE + more;
    for (unsigned i = 0; i < WORDS; i++) {
        const unsigned first = sizes[WORDS + i];
        table[i] += added[sizes[(WORDS + i) >> first]] + (first << 16);
    }
}
