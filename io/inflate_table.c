/* SPDX-License-Identifier: MIT */
/* inflate_table.c - tables of deflate's codes; see inflate_table.h */
#include "inflate_table.h"

#include "inflate.h"

uint32_t ntpio__literal_entry(unsigned symbol)
{
    static const uint8_t extra[] = { 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2,
                                     2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0 };
    static const uint16_t base[] = { 3,  4,  5,  6,   7,   8,   9,   10,  11, 13,
                                     15, 17, 19, 23,  27,  31,  35,  43,  51, 59,
                                     67, 83, 99, 115, 131, 163, 195, 227, 258 };
    if (symbol < NTPIO__END_OF_BLOCK)
        return NTPIO__LITERAL | symbol << 16;
    if (symbol == NTPIO__END_OF_BLOCK)
        return NTPIO__SPECIAL;
    return symbol < NTPIO__LITERALS_USED ? (uint32_t) base[symbol - NTPIO__END_OF_BLOCK - 1] << 16 |
                                               extra[symbol - NTPIO__END_OF_BLOCK - 1]
                                         : NTPIO__NO_CODE;
}

uint32_t ntpio__distance_entry(unsigned symbol)
{
    if (symbol >= NTPIO__DISTANCES_USED)
        return NTPIO__NO_CODE;
    const unsigned extra = symbol < 4 ? 0 : symbol / 2 - 1;
    const uint32_t base = symbol < 4 ? symbol + 1 : ((2 + symbol % 2) << extra) + 1;
    return base << 16 | extra;
}

uint32_t ntpio__length_entry(unsigned symbol)
{
    return symbol << 16;
}

/* The `size` bits of a code as they come: its highest bit first, at the lowest place. */
static unsigned turned(unsigned code, unsigned size)
{
    code = (code & 0x5555) << 1 | (code >> 1 & 0x5555);
    code = (code & 0x3333) << 2 | (code >> 2 & 0x3333);
    code = (code & 0x0f0f) << 4 | (code >> 4 & 0x0f0f);
    code = (code & 0x00ff) << 8 | code >> 8;
    return code >> (16 - size);
}

typedef struct code_of {
    uint32_t *table;
    unsigned bits, most; /* of a look-up; of the longest code */
    unsigned used;       /* entries */
} code_of;

/* Writes an entry wherever its code begins what is looked up. */
static void put(const code_of *c, uint32_t entry, unsigned code, unsigned size)
{
    const unsigned turn = turned(code, size);
    uint32_t *table = c->table;
    unsigned at = turn, step = size, end = c->bits;
    if (size > c->bits) {
        table += c->table[turn & ((1u << c->bits) - 1)] >> 16;
        at = turn >> c->bits;
        step = size - c->bits;
        end = c->most - c->bits;
    }
    entry += step | step << 8;
    for (; at < 1u << end; at += 1u << step)
        table[at] = entry;
}

/* Has each code that is longer than a look-up a table to go on in? */
static void put_link(code_of *c, unsigned code, unsigned size)
{
    const unsigned at = turned(code, size) & ((1u << c->bits) - 1);
    if (c->table[at] != NTPIO__NO_CODE)
        return;
    const unsigned more = c->most - c->bits;
    c->table[at] = NTPIO__LINK | c->bits | more << 8 | (uint32_t) c->used << 16;
    c->used += 1u << more;
}

bool ntpio__make_table(uint32_t *table, unsigned bits, const uint8_t *sizes, unsigned symbols,
                       ntpio__entry_of *entry_of)
{
    unsigned count[NTPIO__CODE_MAX + 1] = { 0 }, next[NTPIO__CODE_MAX + 1] = { 0 };
    code_of c = { .table = table, .bits = bits, .used = 1u << bits };
    for (unsigned i = 0; i < symbols; i++)
        count[sizes[i]]++;
    unsigned space = 0;
    for (unsigned size = 1; size <= NTPIO__CODE_MAX; size++) {
        next[size] = (next[size - 1] + (size > 1 ? count[size - 1] : 0)) << 1;
        space += count[size] << (NTPIO__CODE_MAX - size);
        c.most = count[size] != 0 ? size : c.most;
    }
    const bool complete = space == 1u << NTPIO__CODE_MAX;
    const bool few = entry_of == ntpio__distance_entry && c.most <= 1 && count[1] <= 1;
    if (!complete && !few)
        return false;
    if (!complete || c.most > bits) {
        for (unsigned i = 0; i < 1u << bits; i++)
            table[i] = NTPIO__NO_CODE;
    }
    for (unsigned i = 0; i < symbols; i++) {
        const unsigned size = sizes[i];
        if (size == 0)
            continue;
        const unsigned code = next[size]++;
        if (size > bits)
            put_link(&c, code, size);
        put(&c, entry_of(i), code, size);
    }
    return true;
}
