/* SPDX-License-Identifier: MIT */
/*
 * deflate_state.h - what a deflater knows, and where the bytes of a match stood before
 */
#ifndef NTPIO_DEFLATE_STATE_H
#define NTPIO_DEFLATE_STATE_H

#include <stdlib.h>
#include <string.h>

#include "deflate.h"
#include "deflate_block.h"

/* Fuzzing makes the tables smaller. */
#ifndef NTPIO_TABLE_BITS
#  define NTPIO_TABLE_BITS 14
#endif

enum {
    NEAR_BYTES = 4,
    FAR_BYTES = 6,
    WIDE_BYTES = 8,
    NEAR_BITS = NTPIO_TABLE_BITS, /* of the tables: together they fit in the second cache */
    FAR_BITS = NTPIO_TABLE_BITS + 1,
    MARK_BITS = NTPIO_TABLE_BITS + 4,
    MARK_SHIFT = 14,   /* log2 of the bytes that a mark stands for */
    PART = 8192,       /* symbols: the least block of careful levels */
    BLOCK = 65536,     /* symbols: the largest one, less a part */
    SPAN = 16384,      /* bytes that are read with the same costs */
    WIDE_SPAN = 65536, /* ... at careful levels */
    STEPS = BLOCK + 2 * SPAN,
    BIT = 16,      /* costs are in parts of a bit */
    FOUND_MAX = 8, /* matches at a byte that are remembered */
    SOON = 4,      /* bytes ahead, the tables are fetched */
    AHEAD = 8192,  /* ... and the bytes themselves, which take longest; may be after the last one */
    LINE = 64      /* bytes that are fetched together */
};

typedef struct effort {
    int depth;         /* places of a chain that are looked at */
    int deep;          /* ... next to a match, or, times DEEPER, where literals are rare */
    uint32_t enough;   /* bytes: no longer match is looked for */
    int rounds;        /* careful levels */
    bool looks_ahead;  /* one byte further */
    int near_patience; /* log2 of ... after which short matches are not looked for */
    int patience; /* log2 of the literals in a row after which every other byte is passed over */
    bool leaps;   /* looks at most spans less closely */
    bool far;     /* takes no match below eight bytes */
} effort;

/* Holds nothing until it is written; the largest part is the last one, of which small pictures fill little. */
typedef struct careful {
    int32_t sides[NTPIO__WINDOW][2]; /* of a place in its tree: what is before it, and after it */
    uint8_t count[WIDE_SPAN];        /* of found */
    ntpio__match best[WIDE_SPAN];    /* 0: a literal */
    uint32_t cost[WIDE_SPAN + NTPIO__LENGTH_MAX]; /* from a byte to the end */
    ntpio__match found[WIDE_SPAN][FOUND_MAX];     /* at each byte */
} careful;

struct ntpio__deflater {
    int32_t near_places[1 << NEAR_BITS], far_places[1 << FAR_BITS]; /* the newest; -1: none */
    int32_t before[NTPIO__WINDOW];      /* the place before, of the same six bytes */
    size_t count, in_block;             /* steps; the rest is the newest part */
    size_t counted;                     /* steps that block and part have */
    size_t block_symbols, part_symbols; /* literals and matches */
    size_t block_bytes, part_bytes;     /* what they stand for */
    ntpio__counts block, part;          /* of their symbols */
    uint64_t block_cost;                /* about; in parts of a bit */
    uint32_t literals[NTPIO__LITERALS]; /* costs */
    uint32_t lengths[NTPIO__LENGTH_MAX + 1];
    uint32_t distances[NTPIO__DISTANCES];
    bool literals_are_rare;  /* in the span before */
    size_t misses;           /* bytes in a row without a match */
    int leaps;               /* spans that are to be read leaping */
    uint64_t saved_by_short; /* matches below eight bytes; in parts of a bit */
    careful *careful;
    const effort *effort;
    const uint8_t *bytes;
    size_t block_from, to;
    ntpio__bits bits;
    size_t in_bits;     /* of what was packed last */
    ntpio__step *steps; /* STEPS of them; small pictures fill few pages of these */
    /* These hold nothing until they are written. */
    /* Of costs as literals, from the span's start; their low bits: those of a match take 16 or less. */
    uint16_t sums[SPAN + NTPIO__LENGTH_MAX + 1];
    uint8_t marks[1 << MARK_BITS]; /* of zlib's way: in which part of the bytes these stood last */
};

/* Costs of symbols that occur as often. */
void ntpio__set_costs(ntpio__deflater *d, const ntpio__counts *from);

/* The newest part joins the block if that takes fewer bits than another block. */
void ntpio__end_part(ntpio__deflater *d);

/* Remembers a place, for careful levels. */
void ntpio__visit_carefully(ntpio__deflater *d, size_t at);

/* ... and those from `from` to `to` - 1, for ntpio__read_far and ntpio__read_as_zlib. */
void ntpio__visit_wide(ntpio__deflater *d, size_t from, size_t to);
void ntpio__visit_as_zlib(ntpio__deflater *d, size_t from, size_t to);

/* Read the span up to `to`, or as far as its last match goes, and return where that is.  The last one
 * sets costs; `counts` gets what it has read. */
size_t ntpio__read_quickly(ntpio__deflater *d, size_t from, size_t to);
size_t ntpio__read_far(ntpio__deflater *d, size_t from, size_t to); /* of ntpio__read_quickly */
size_t ntpio__read_as_zlib(ntpio__deflater *d, size_t from, size_t to);
size_t ntpio__read_carefully(ntpio__deflater *d, size_t from, size_t to, bool first,
                             ntpio__counts *counts);

/*
 * Sums of what the bytes before each one cost as literals; the first is *sum, which gets what all of them
 * cost added.  With AVX-512, of as many of the first bytes as fit in its registers: returns how many.
 */
size_t ntpio__sum_costs_avx512(const uint8_t *bytes, size_t size, const uint32_t *costs,
                               uint32_t *sum, uint16_t *sums);

/* The first byte is the lowest one. */
static inline uint64_t load(const uint8_t *b)
{
    uint64_t v;
    memcpy(&v, b, sizeof v);
#if defined __BYTE_ORDER__ && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    v = __builtin_bswap64(v);
#endif
    return v;
}

static inline uint32_t near_slot(uint64_t next)
{
    return ((uint32_t) next * 0x9e3779b1u) >> (32 - NEAR_BITS);
}

static inline uint32_t far_slot(uint64_t next)
{
    return (uint32_t) (((next << (64 - 8 * FAR_BYTES)) * 0x9e3779b185ebca87u) >> (64 - FAR_BITS));
}

static inline size_t common(const uint8_t *a, const uint8_t *b, size_t most)
{
    for (size_t n = 0; n < most; n += 8) {
        const uint64_t other = load(a + n) ^ load(b + n);
        if (other != 0) {
            n += (size_t) __builtin_ctzll(other) / 8;
            return n < most ? n : most;
        }
    }
    return most;
}

static inline bool in_reach(int32_t place, size_t at)
{
    return place >= 0 && at - (size_t) place <= NTPIO__WINDOW;
}

typedef struct places {
    int32_t near, far; /* the newest with these bytes, perhaps; near is one of them for sure */
} places;

/* Does it have the next four bytes? */
static inline bool is_near(const ntpio__deflater *d, int32_t place, size_t at)
{
    return in_reach(place, at) &&
           (uint32_t) load(d->bytes + place) == (uint32_t) load(d->bytes + at);
}

/* Remembers a place; returns those before it. */
static inline places visit(ntpio__deflater *d, size_t at)
{
    const uint64_t next = load(d->bytes + at);
    int32_t *near = &d->near_places[near_slot(next)], *far = &d->far_places[far_slot(next)];
    const uint64_t soon = load(d->bytes + at + SOON);
    places p = { *near, *far };
    __builtin_prefetch(&d->near_places[near_slot(soon)], 1);
    __builtin_prefetch(&d->far_places[far_slot(soon)], 1);
    d->before[at % NTPIO__WINDOW] = *far;
    *near = *far = (int32_t) at;
    return p;
}

/* The next place of the chain, or -1.  Where the window has passed, later places stand. */
static inline int32_t earlier(const ntpio__deflater *d, int32_t place)
{
    const int32_t next = d->before[(size_t) place % NTPIO__WINDOW];
    return next < place ? next : -1;
}

/* Can a match there be longer, and long enough?  Then the bytes that would be its last are equal. */
static inline bool may_exceed(const uint8_t *there, const uint8_t *here, uint32_t length)
{
    const size_t first = length < FAR_BYTES ? 0 : length + 1 - FAR_BYTES;
    return (load(there + first) ^ load(here + first)) << (64 - 8 * FAR_BYTES) == 0;
}

#endif
