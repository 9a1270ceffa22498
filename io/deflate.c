/* SPDX-License-Identifier: MIT */
/*
 * deflate.c - packs the filtered rows of pictures as deflate does (RFC 1951)
 *
 * Filtered normals are noise: short matches cost more bits than the literals that they stand for.
 * zlib leaves out matches below six bytes, libdeflate takes them.  Here a match is taken if it
 * saves bits, by what literals, lengths and distances cost in the codes of the part before.  That
 * gives smaller files than both, in the time of libdeflate.
 *
 * Two tables find matches: where the next four bytes stood last, and a chain of the places where
 * the next six did, or one chain of the next eight (LEVEL_FAR).  Levels below CAREFUL take the match
 * that saves more, here or a byte further; where none was found for a while, most of them look at some
 * bytes only.  The others find matches of every length for every byte, with trees, and then the cheapest
 * way through all of them from the end to the start, several times, with the costs that the way before
 * it had.
 *
 * A block ends where the symbols change so much that new codes pay.  All costs are integers, so
 * every machine writes the same bytes.
 */
#include "deflate_state.h"

#include <os/memory.h>

enum {
    FIRST_SPAN = 4096,  /* bytes; its costs are guessed */
    QUICK_PART = 4096,  /* symbols: the least block of quick levels */
    ZLIB_BLOCK = 16383, /* symbols of zlib's blocks */
    NEVER = 31,         /* patience */
    CAREFUL = 10,       /* levels from here on */
    TABLES = 4,         /* that literals are counted in */
    LENGTH_MIN = 3,     /* of a match */
    LITERAL_MAX = 15,   /* bits */
    LENGTH_COST_MAX = 13,
    DISTANCE_COST_MAX = 10
};

static const effort efforts[NTPIO__LEVEL_TRIAL + 1] = {
    [NTPIO__LEVEL_ZLIB] = { 128, 0, 128, 0, true, NEVER, NEVER, false, false },
    [1] = { 1, 1, 32, 0, false, 3, 4, true, false },
    [2] = { 1, 2, 32, 0, true, 4, 5, false, false },
    [3] = { 2, 4, 32, 0, true, 4, 6, false, false },
    [4] = { 3, 6, 32, 0, true, 5, 7, false, false },
    [5] = { 3, 8, 64, 0, true, 6, 7, false, false },
    [6] = { 4, 16, 128, 0, true, 6, 8, false, false },
    [7] = { 12, 32, 128, 0, true, NEVER, NEVER, false, false },
    [8] = { 24, 48, 128, 0, true, NEVER, NEVER, false, false },
    [9] = { 64, 64, 258, 0, true, NEVER, NEVER, false, false },
    [10] = { 16, 0, 64, 1, true, NEVER, NEVER, false, false },
    [11] = { 32, 0, 128, 2, true, NEVER, NEVER, false, false },
    [12] = { 128, 0, 258, 3, true, NEVER, NEVER, false, false },
    [NTPIO__LEVEL_FAR] = { 4, 16, 128, 0, true, NEVER, 7, false, true },
    [NTPIO__LEVEL_TRIAL] = { 1, 1, 32, 0, false, 3, 4, false, false },
};

/* --------------------------------------------------------------------------- costs */

/* log2, times BIT, of counts below 2^24, which a float holds as they are: its exponent and 16 bits of what
 * follows.  Compilers make vectors of that.  log2(1 + f) is nearly f + 0.344 f (1 - f). */
static inline uint32_t log2_of(uint32_t v)
{
    const float number = (float) (int32_t) v;
    uint32_t bits;
    memcpy(&bits, &number, sizeof bits);
    const uint32_t top = (bits >> 23) - 127, f = bits >> 7 & 0xffff;
    const uint32_t more = (f * (65536 - f) >> 16) * 22524 >> 16;
    return (top * BIT + (((f + more) * BIT + 32768) >> 16)) & (0u - (v != 0));
}

static inline uint32_t cost_of(uint32_t count, uint32_t log_of_all, uint32_t most)
{
    const int32_t cost = (int32_t) (log_of_all - log2_of(count) + BIT * (count == 0));
    const int32_t least = BIT, largest = (int32_t) most * BIT;
    return (uint32_t) (cost < least ? least : cost < largest ? cost : largest);
}

static uint32_t sum_of(const uint32_t *counts, unsigned size)
{
    uint32_t sum = 0;
    for (unsigned i = 0; i < size; i++)
        sum += counts[i];
    return sum;
}

void ntpio__set_costs(ntpio__deflater *d, const ntpio__counts *from)
{
    uint32_t of_slots[NTPIO__WORDS - NTPIO__FIRST_LENGTH];
    const uint32_t words = log2_of(sum_of(from->words, NTPIO__WORDS) + NTPIO__WORDS / 2);
    const uint32_t all = log2_of(sum_of(from->distances, NTPIO__DISTANCES) + NTPIO__DISTANCES / 2);
    for (unsigned i = 0; i < NTPIO__LITERALS; i++)
        d->literals[i] = cost_of(from->words[i], words, LITERAL_MAX);
    for (uint32_t slot = 0; slot < NTPIO__WORDS - NTPIO__FIRST_LENGTH; slot++)
        of_slots[slot] = cost_of(from->words[NTPIO__FIRST_LENGTH + slot], words, LENGTH_COST_MAX);
    uint32_t length = LENGTH_MIN;
    for (uint32_t slot = 0; slot < ntpio__length_slot(NTPIO__LENGTH_MAX); slot++) {
        const uint32_t extra = ntpio__length_extra(length), next = length + (1u << extra);
        const uint32_t cost = of_slots[slot] + BIT * extra;
        for (; length < next && length < NTPIO__LENGTH_MAX; length++)
            d->lengths[length] = cost;
    }
    d->lengths[NTPIO__LENGTH_MAX] = of_slots[ntpio__length_slot(NTPIO__LENGTH_MAX)];
    for (unsigned i = 0; i < NTPIO__DISTANCES; i++)
        d->distances[i] =
            cost_of(from->distances[i], all, DISTANCE_COST_MAX) + BIT * (i < 4 ? 0 : i / 2 - 1);
}

/* Before anything is known: the literals as they are, and a match now and then. */
static void guess(ntpio__counts *counts, const uint8_t *bytes, size_t size)
{
    memset(counts, 0, sizeof *counts);
    for (size_t i = 0; i < size; i++)
        counts->words[bytes[i]]++;
    for (uint32_t i = 0; i < NTPIO__WORDS - NTPIO__FIRST_LENGTH; i++)
        counts->words[NTPIO__FIRST_LENGTH + i] = (uint32_t) size / (64 * (i + 4));
    for (unsigned i = 0; i < NTPIO__DISTANCES; i++)
        counts->distances[i] = (uint32_t) size / 512;
}

static void add_counts(ntpio__counts *to, const ntpio__counts *from, unsigned shift)
{
    for (unsigned i = 0; i < NTPIO__WORDS; i++)
        to->words[i] += from->words[i] >> shift;
    for (unsigned i = 0; i < NTPIO__DISTANCES; i++)
        to->distances[i] += from->distances[i] >> shift;
}

/* -------------------------------------------------------------------------- blocks */

/* No word takes less than a bit.  Of a block, that fits in 32 bits. */
static uint32_t entropy(const uint32_t *counts, unsigned size)
{
    uint32_t parts = 0;
    const uint32_t all = log2_of(sum_of(counts, size));
    for (unsigned i = 0; i < size; i++) {
        const uint32_t bits = all - log2_of(counts[i]);
        parts += counts[i] * (bits > BIT ? bits : BIT);
    }
    return parts;
}

/* What the symbols and their codes take, about. */
static uint64_t block_cost(const ntpio__counts *counts)
{
    uint32_t used = 0;
    for (unsigned i = 0; i < NTPIO__WORDS; i++)
        used += counts->words[i] != 0;
    for (unsigned i = 0; i < NTPIO__DISTANCES; i++)
        used += counts->distances[i] != 0;
    return (uint64_t) entropy(counts->words, NTPIO__WORDS) +
           entropy(counts->distances, NTPIO__DISTANCES) + (uint64_t) BIT * (120 + 4 * used);
}

static void end_block(ntpio__deflater *d, bool last)
{
    ntpio__put_block(&d->bits, d->steps, d->in_block, &d->block, d->bytes + d->block_from,
                     d->block_bytes, last);
    d->count -= d->in_block;
    memmove(d->steps, d->steps + d->in_block, d->count * sizeof *d->steps);
    d->block_from += d->block_bytes;
    d->counted -= d->in_block;
    d->block_bytes = 0;
    d->block_symbols = 0;
    d->in_block = 0;
    memset(&d->block, 0, sizeof d->block);
}

/* Four tables by turns: adding to the same number again has to wait.  The last bytes, which are fewer,
 * without a branch that is hard to foresee. */
static inline void count_literals(uint32_t (*counts)[NTPIO__LITERALS], const uint8_t *bytes,
                                  size_t count)
{
    enum { AT_ONCE = 8 };
    size_t i = 0;
    for (; i + AT_ONCE <= count; i += AT_ONCE) {
        const uint64_t w = load(bytes + i);
        for (unsigned k = 0; k < AT_ONCE; k++)
            counts[k % TABLES][w >> 8 * k & 255]++;
    }
    const uint64_t w = load(bytes + i);
    for (unsigned k = 0; k < AT_ONCE; k++)
        counts[k % TABLES][w >> 8 * k & 255] += k < count - i;
}

/* Counts the steps that came to the newest part. */
static void count_part(ntpio__deflater *d)
{
    uint32_t counts[TABLES][NTPIO__LITERALS];
    memset(counts, 0, sizeof counts);
    const uint8_t *first = d->bytes + d->block_from + d->block_bytes + d->part_bytes, *at = first;
    for (; d->counted < d->count; d->counted++) {
        const ntpio__step s = d->steps[d->counted];
        count_literals(counts, at, s.literals);
        if (s.match != 0) {
            d->part.words[NTPIO__FIRST_LENGTH + ntpio__length_slot(s.match >> 16)]++;
            d->part.distances[ntpio__distance_slot(s.match & 0xffff)]++;
        }
        d->part_symbols += s.literals + (s.match != 0);
        at += s.literals + (s.match >> 16);
    }
    for (unsigned i = 0; i < NTPIO__LITERALS; i++)
        d->part.words[i] += counts[0][i] + counts[1][i] + counts[2][i] + counts[3][i];
    d->part_bytes += (size_t) (at - first);
}

static void join_part(ntpio__deflater *d)
{
    const uint64_t alone = block_cost(&d->part);
    uint64_t together = alone;
    if (d->in_block != 0) {
        ntpio__counts both = d->block;
        add_counts(&both, &d->part, 0);
        together = block_cost(&both);
        if (d->block_symbols + d->part_symbols > BLOCK || together > d->block_cost + alone) {
            end_block(d, false);
            together = alone;
        }
    }
    d->block_cost = together;
    add_counts(&d->block, &d->part, 0);
    d->block_bytes += d->part_bytes;
    d->block_symbols += d->part_symbols;
    d->in_block = d->count;
    d->part_bytes = d->part_symbols = 0;
    memset(&d->part, 0, sizeof d->part);
}

void ntpio__end_part(ntpio__deflater *d)
{
    count_part(d);
    join_part(d);
}

/* --------------------------------------------------------------------------- stream */

static void begin(ntpio__deflater *d, int level, const uint8_t *bytes, size_t from, size_t to)
{
    if (level == NTPIO__LEVEL_ZLIB)
        memset(d->marks, 0, sizeof d->marks);
    else
        memset(d->near_places, -1, sizeof d->near_places);
    memset(d->far_places, -1, sizeof d->far_places);
    d->count = d->counted = d->in_block = d->block_bytes = d->block_symbols = 0;
    d->part_bytes = d->part_symbols = 0;
    memset(&d->part, 0, sizeof d->part);
    memset(&d->block, 0, sizeof d->block);
    d->effort = &efforts[level];
    d->literals_are_rare = false;
    d->misses = 0;
    d->leaps = 0;
    d->saved_by_short = 0;
    d->bytes = bytes;
    d->block_from = from;
    d->to = to;
    const size_t first = from > NTPIO__WINDOW ? from - NTPIO__WINDOW : 0;
    const bool zlib = level == NTPIO__LEVEL_ZLIB, far = d->effort->far;
    if (zlib)
        ntpio__visit_as_zlib(d, first, from);
    else if (far)
        ntpio__visit_wide(d, first, from);
    for (size_t i = first; i < from && !zlib && !far; i++) {
        if (d->effort->rounds > 0)
            ntpio__visit_carefully(d, i);
        else
            visit(d, i);
    }
}

/* Costs are those of the span before, and a little of those before that. */
static void read_all(ntpio__deflater *d, int level, size_t from)
{
    ntpio__counts old, counts;
    const size_t span = d->effort->rounds > 0 ? WIDE_SPAN : SPAN;
    size_t size = d->effort->rounds > 0 ? WIDE_SPAN : FIRST_SPAN;
    /* Guesses about two blocks are worth less than a byte or two where zlib makes one. */
    const bool one = level == NTPIO__LEVEL_ZLIB && d->to - from <= ZLIB_BLOCK;
    const size_t least = one ? ZLIB_BLOCK + 1 : QUICK_PART;
    guess(&counts, d->bytes + from, d->to - from < size ? d->to - from : size);
    for (size_t at = from; at < d->to; size = span) {
        const size_t end = d->to - at < size ? d->to : at + size;
        ntpio__set_costs(d, &counts);
        if (d->effort->rounds > 0) {
            at = ntpio__read_carefully(d, at, end, at == from, &counts);
            continue;
        }
        old = counts;
        at = level == NTPIO__LEVEL_ZLIB ? ntpio__read_as_zlib(d, at, end)
                                        : ntpio__read_quickly(d, at, end);
        count_part(d);
        counts = d->part;
        add_counts(&counts, &old, 1);
        if (d->part_symbols >= least || at >= d->to)
            join_part(d);
    }
}

ntpio__deflater *ntpio__deflater_new(int level)
{
    ntpio__deflater *d = malloc(sizeof *d);
    if (d == NULL)
        return NULL;
    /* Each run begins the tables, and sets the places before of those that it passes. */
    memset((uint8_t *) d + offsetof(ntpio__deflater, count), 0,
           offsetof(ntpio__deflater, sums) - offsetof(ntpio__deflater, count));
    d->steps = os_alloc_zeros(STEPS * sizeof *d->steps);
    if (level >= CAREFUL)
        d->careful = malloc(sizeof *d->careful);
    if (d->steps != NULL && (level < CAREFUL || d->careful != NULL))
        return d;
    ntpio__deflater_free(d);
    return NULL;
}

void ntpio__deflater_free(ntpio__deflater *d)
{
    if (d == NULL)
        return;
    os_free_zeros(d->steps, STEPS * sizeof *d->steps);
    free(d->careful);
    free(d);
}

size_t ntpio__deflate_bound(size_t size)
{
    return size + 5 * (size / QUICK_PART + 2) + 2 * NTPIO__SLACK;
}

size_t ntpio__deflate(ntpio__deflater *d, int level, const uint8_t *bytes, size_t from, size_t to,
                      bool last, uint8_t *out)
{
    d->bits = (ntpio__bits) { .out = out };
    begin(d, level, bytes, from, to);
    read_all(d, level, from);
    end_block(d, last);
    d->in_bits = 8 * d->bits.size + d->bits.count;
    if (last)
        ntpio__end_byte(&d->bits);
    else
        ntpio__put_stored(&d->bits, bytes + to, 0, false);
    return d->bits.size;
}

size_t ntpio__deflated_bits(const ntpio__deflater *d)
{
    return d->in_bits;
}

bool ntpio__deflated_shifts(const ntpio__deflater *d)
{
    return !d->bits.stored;
}

size_t ntpio__deflate_saved_by_short(const ntpio__deflater *d)
{
    return (size_t) (d->saved_by_short / (8 * BIT));
}
