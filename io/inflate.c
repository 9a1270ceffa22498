/* SPDX-License-Identifier: MIT */
/*
 * inflate.c - unpacks deflate part by part
 *
 * A code is looked up by its next 11 bits (distances: 8; inflate_table.h).  Each look-up waits for
 * the one before, which says how many bits it used.  So two literals take one such step, where 11
 * bits say how long both codes are; a repetition takes two.
 *
 * Full bits are 54 at least.  They last for two steps of two literals (10 + 11 bits each) and the
 * look-up after them (11), or for one such step, a length (20) and the look-up of its distance (8);
 * and then for that distance (28) and the look-up after it.
 *
 * Input and room are checked once in a step.  Bytes are read up to the slack beyond the input; a
 * stream that ends there is bad.  Nothing is written past the slack of the room, and no distance
 * reaches before `begin`.
 */
#include "inflate.h"

#include <string.h>

#include "inflate_table.h"

enum {
    LITERALS_MAX = 288,
    DISTANCES_MAX = 32,
    LENGTH_CODES = 19,
    LENGTH_BITS = 7,
    JUNK = 2,       /* see taker */
    STEP_INPUT = 24 /* bytes that a step reads at most: three refills */
};

static inline uint64_t read64(const uint8_t *from)
{
    uint64_t value;
    memcpy(&value, from, sizeof value);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    value = __builtin_bswap64(value);
#endif
    return value;
}

/* At least 56 bits are there then. */
static inline void refill(const uint8_t **in, uint64_t *bits, unsigned *count)
{
    *bits |= read64(*in) << *count;
    *in += (63 - *count) >> 3;
    *count |= 56;
}

/* -------------------------------------------------------------------------- blocks */

static unsigned take(ntpio__inflate *s, unsigned size)
{
    refill(&s->in, &s->bits, &s->bit_count);
    const unsigned value = (unsigned) (s->bits & ((1u << size) - 1));
    s->bits >>= size;
    s->bit_count -= size;
    return value;
}

/* Were more bits used than there are?  The bits that were not used do not count. */
static bool is_beyond(const ntpio__inflate *s)
{
    return s->in - s->in_end > (ptrdiff_t) (s->bit_count / 8);
}

static bool take_sizes(ntpio__inflate *s, uint8_t *sizes, unsigned count)
{
    unsigned i = 0;
    while (i < count) {
        refill(&s->in, &s->bits, &s->bit_count);
        const uint32_t entry = s->literals[s->bits & ((1u << LENGTH_BITS) - 1)];
        if ((entry & NTPIO__SPECIAL) != 0)
            return false;
        s->bits >>= entry & 255;
        s->bit_count -= entry & 255;
        const unsigned symbol = entry >> 16;
        if (symbol < 16) {
            sizes[i++] = (uint8_t) symbol;
            continue;
        }
        if (symbol == 16 && i == 0)
            return false;
        const unsigned times = symbol == 16   ? 3 + take(s, 2)
                               : symbol == 17 ? 3 + take(s, 3)
                                              : 11 + take(s, 7);
        if (times > count - i)
            return false;
        memset(sizes + i, symbol == 16 ? sizes[i - 1] : 0, times);
        i += times;
    }
    return true;
}

static bool make_tables(ntpio__inflate *s, const uint8_t *sizes, unsigned literals,
                        unsigned distances)
{
    if (sizes[NTPIO__END_OF_BLOCK] == 0 ||
        !ntpio__make_table(s->distances, NTPIO__DISTANCE_BITS, sizes + literals, distances,
                           ntpio__distance_entry) ||
        !ntpio__make_table(s->literals, NTPIO__LITERAL_BITS, sizes, literals, ntpio__literal_entry))
        return false;
    ntpio__pair_literals(s->literals);
    return true;
}

static bool take_codes(ntpio__inflate *s)
{
    static const uint8_t order[LENGTH_CODES] = { 16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                 11, 4,  12, 3, 13, 2, 14, 1, 15 };
    uint8_t sizes[LITERALS_MAX + DISTANCES_MAX] = { 0 };
    const unsigned literals = 257 + take(s, 5), distances = 1 + take(s, 5), count = 4 + take(s, 4);
    for (unsigned i = 0; i < count; i++)
        sizes[order[i]] = (uint8_t) take(s, 3);
    if (literals > NTPIO__LITERALS_USED || distances > NTPIO__DISTANCES_USED ||
        !ntpio__make_table(s->literals, LENGTH_BITS, sizes, LENGTH_CODES, ntpio__length_entry))
        return false;
    memset(sizes, 0, sizeof sizes);
    return take_sizes(s, sizes, literals + distances) && make_tables(s, sizes, literals, distances);
}

static bool set_fixed_codes(ntpio__inflate *s)
{
    uint8_t sizes[LITERALS_MAX + DISTANCES_MAX];
    memset(sizes, 8, LITERALS_MAX);
    memset(sizes + 144, 9, 256 - 144);
    memset(sizes + 256, 7, 280 - 256);
    memset(sizes + LITERALS_MAX, 5, DISTANCES_MAX);
    return make_tables(s, sizes, LITERALS_MAX, DISTANCES_MAX);
}

/* Whole bytes that were read and not used go back. */
static void give_back(ntpio__inflate *s)
{
    s->in -= s->bit_count / 8;
    s->bit_count %= 8;
}

static void align(ntpio__inflate *s)
{
    give_back(s);
    s->bits = 0;
    s->bit_count = 0;
}

static bool start_stored(ntpio__inflate *s)
{
    align(s);
    if (s->in_end - s->in < 4)
        return false;
    const unsigned size = s->in[0] | (unsigned) s->in[1] << 8;
    const unsigned check = s->in[2] | (unsigned) s->in[3] << 8;
    s->in += 4;
    s->stored_left = size;
    return (size ^ check) == 0xffff;
}

static bool start_block(ntpio__inflate *s)
{
    enum { STORED, FIXED, DYNAMIC };
    s->last = take(s, 1) != 0;
    const unsigned kind = take(s, 2);
    s->in_block = true;
    s->stored = kind == STORED;
    const bool good = kind == STORED    ? start_stored(s)
                      : kind == FIXED   ? set_fixed_codes(s)
                      : kind == DYNAMIC ? take_codes(s)
                                        : false;
    return good && !is_beyond(s);
}

static ntpio__inflated copy_stored(ntpio__inflate *s, uint8_t **out, const uint8_t *out_end)
{
    const size_t here = (size_t) (s->in_end - s->in), room = (size_t) (out_end - *out);
    size_t size = s->stored_left < here ? s->stored_left : here;
    size = size < room ? size : room;
    memcpy(*out, s->in, size);
    *out += size;
    s->in += size;
    s->stored_left -= (uint32_t) size;
    s->in_block = s->stored_left != 0;
    return !s->in_block || size == room ? NTPIO__NEEDS_ROOM
           : s->no_more                 ? NTPIO__STREAM_BAD
                                        : NTPIO__NEEDS_INPUT;
}

/* ---------------------------------------------------------------------- repetitions */

static inline void copy8(uint8_t *out, const uint8_t *from)
{
    uint64_t eight;
    memcpy(&eight, from, sizeof eight);
    memcpy(out, &eight, sizeof eight);
}

static inline void copy16(uint8_t *out, const uint8_t *from)
{
    uint8_t sixteen[16];
    memcpy(sixteen, from, sizeof sixteen);
    memcpy(out, sixteen, sizeof sixteen);
}

/* Copies at least `length` bytes from `distance` before, and up to 31 more.  Most are short. */
static inline void repeat(uint8_t *out, size_t distance, size_t length)
{
    const uint8_t *from = out - distance;
    uint8_t *const end = out + length;
    if (distance >= 16) {
        copy16(out, from);
        copy16(out + 16, from + 16);
        for (out += 32, from += 32; out < end; out += 16, from += 16)
            copy16(out, from);
    } else if (distance >= 8) {
        do {
            copy8(out, from);
            out += 8;
            from += 8;
        } while (out < end);
    } else if (distance == 1) {
        const uint64_t eight = *from * UINT64_C(0x0101010101010101);
        do {
            memcpy(out, &eight, 8);
            memcpy(out + 8, &eight, 8);
            out += 16;
        } while (out < end);
    } else {
        do { /* of eight bytes the first `distance` are right; the next eight begin after them */
            copy8(out, from);
            out += distance;
            from += distance;
        } while (out < end);
    }
}

/* A copy of the state that stays in registers; only the lowest byte of `count` counts.  Below the bits
 * are JUNK others, so that they are also four times a place in a table: where codes are single bytes,
 * each look-up waits for the one before, and one without a factor takes a cycle less. */
typedef struct taker {
    const uint8_t *in;
    uint64_t bits;
    unsigned count;
    uint8_t *out;
} taker;

static inline void fill_up(taker *t)
{
    t->bits |= read64(t->in) << (t->count & 63);
    t->in += ((t->count ^ 63) >> 3) & 7;
    t->count |= 56;
}

/* The entry of a table for the next bits. */
static inline uint32_t look_up(const taker *t, const uint32_t *table, unsigned size)
{
    uint32_t entry;
    const uint64_t at = t->bits & (((UINT64_C(1) << size) - 1) << JUNK);
    memcpy(&entry, (const uint8_t *) table + at, sizeof entry);
    return entry;
}

static inline uint32_t next_literal(const taker *t, const ntpio__inflate *s)
{
    return look_up(t, s->literals, NTPIO__LITERAL_BITS);
}

/* Of the bits that an entry uses the last ones, shifted to the top. */
static inline unsigned extra_bits(uint64_t bits, uint32_t entry)
{
    return (uint32_t) (bits << ((64 - JUNK - entry) & 63) >> 33) >> (entry >> 8 & 31);
}

/* The bits of an entry are used; returns what they were in front of. */
static inline uint64_t use(taker *t, uint32_t entry)
{
    const uint64_t before = t->bits;
    t->bits >>= entry & 63;
    t->count -= entry;
    return before;
}

/* The table that `entry` leads to. */
static inline uint32_t follow(const taker *t, const uint32_t *table, uint32_t entry)
{
    return table[(entry >> 16 & NTPIO__BASE) + (t->bits >> JUNK & ((1u << (entry >> 8 & 31)) - 1))];
}

/* False: no code of a distance. */
static inline bool take_distance(taker *t, const ntpio__inflate *s, size_t *distance)
{
    uint32_t entry = look_up(t, s->distances, NTPIO__DISTANCE_BITS);
    fill_up(t);
    if ((entry & NTPIO__LINK) != 0) {
        use(t, entry);
        entry = follow(t, s->distances, entry);
    }
    *distance = (entry >> 16) + extra_bits(t->bits, entry);
    use(t, entry);
    return (entry & NTPIO__SPECIAL) == 0;
}

/* One or two literals, whose bits begin `before`.  If there is one, a byte behind it is overwritten
 * by what comes next. */
static inline void put_literals(taker *t, const ntpio__inflate *s, uint32_t entry, uint64_t before)
{
    const taker second = { .bits = before >> (entry >> 16 & 63) };
    t->out[0] = (uint8_t) (entry >> 8);
    t->out[1] = (uint8_t) (next_literal(&second, s) >> 8);
    t->out += entry >> 24;
}

/*
 * Codes of a block, from full bits on, while there are input and room.  The entry of the next code
 * is looked up before the bits are filled and bytes are repeated, which do not wait for it.
 * False: the stream is bad.
 */
static inline bool take_codes_of(taker *t, ntpio__inflate *s, const uint8_t *begin,
                                 const uint8_t *in_most, const uint8_t *out_most)
{
    uint32_t next = next_literal(t, s);
    do {
        uint32_t entry = next;
        uint64_t before = use(t, entry);
        if ((entry & NTPIO__NO_LITERAL) == 0) {
            const uint32_t first = entry;
            const uint64_t first_before = before;
            entry = next_literal(t, s);
            before = use(t, entry);
            put_literals(t, s, first, first_before);
            if ((entry & NTPIO__NO_LITERAL) == 0) {
                next = next_literal(t, s);
                fill_up(t);
                put_literals(t, s, entry, before);
                continue;
            }
        }
        if ((entry & (NTPIO__LINK | NTPIO__SPECIAL)) != 0) {
            if ((entry & NTPIO__LINK) != 0) {
                entry = follow(t, s->literals, entry);
                before = use(t, entry);
                if ((entry & NTPIO__NO_LITERAL) == 0) {
                    *t->out++ = (uint8_t) (entry >> 8);
                    next = next_literal(t, s);
                    fill_up(t);
                    continue;
                }
            }
            if ((entry & NTPIO__SPECIAL) != 0) {
                s->in_block = false;
                return (entry & NTPIO__NO_CODE) == NTPIO__SPECIAL;
            }
        }
        const size_t length = (entry >> 16 & NTPIO__BASE) + extra_bits(before, entry);
        size_t distance;
        if (!take_distance(t, s, &distance) || distance > (size_t) (t->out - begin))
            return false;
        uint8_t *const to = t->out;
        t->out += length;
        next = next_literal(t, s);
        fill_up(t);
        repeat(to, distance, length);
    } while (t->out <= out_most && t->in <= in_most);
    return true;
}

static bool take_symbols(ntpio__inflate *s, const uint8_t *begin, uint8_t **out,
                         const uint8_t *out_end)
{
    const uint8_t *const in_most = s->in_end + (s->no_more ? NTPIO__IN_SLACK / 2 : -STEP_INPUT);
    const uint8_t *const out_most = out_end - NTPIO__OUT_SLACK;
    give_back(s);
    taker t = { s->in, s->bits << JUNK, s->bit_count + JUNK, *out };
    fill_up(&t);
    const bool good = take_codes_of(&t, s, begin, in_most, out_most);
    s->in = t.in;
    s->bits = t.bits >> JUNK;
    s->bit_count = (uint8_t) t.count - JUNK;
    *out = t.out;
    return good && !is_beyond(s);
}

static ntpio__inflated unpack_some(ntpio__inflate *s, const uint8_t *begin, uint8_t **out,
                                   const uint8_t *out_end)
{
    for (;;) {
        if (!s->in_block && s->last)
            return NTPIO__STREAM_ENDS;
        if (out_end - *out < NTPIO__OUT_SLACK)
            return NTPIO__NEEDS_ROOM;
        const ptrdiff_t here = s->in_end - s->in;
        if (!s->in_block) {
            if (here < NTPIO__IN_SLACK && !s->no_more)
                return NTPIO__NEEDS_INPUT;
            if (!start_block(s))
                return NTPIO__STREAM_BAD;
        } else if (s->stored) {
            const ntpio__inflated now = copy_stored(s, out, out_end);
            if (now != NTPIO__NEEDS_ROOM)
                return now;
        } else {
            if (here < STEP_INPUT && !s->no_more)
                return NTPIO__NEEDS_INPUT;
            if (!take_symbols(s, begin, out, out_end))
                return NTPIO__STREAM_BAD;
        }
    }
}

/* Input may move before the next call, so none of it stays among the bits. */
ntpio__inflated ntpio__inflate_some(ntpio__inflate *s, const uint8_t *begin, uint8_t **out,
                                    const uint8_t *out_end)
{
    const ntpio__inflated now = unpack_some(s, begin, out, out_end);
    if (now != NTPIO__STREAM_BAD)
        give_back(s);
    return now;
}

const uint8_t *ntpio__inflate_end(ntpio__inflate *s)
{
    align(s);
    return s->in;
}
