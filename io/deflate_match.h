/* SPDX-License-Identifier: MIT */
/*
 * deflate_match.h - what a match saves, how far it goes, and which bytes are looked at
 */
#ifndef NTPIO_DEFLATE_MATCH_H
#define NTPIO_DEFLATE_MATCH_H

#include "deflate_state.h"

enum {
    PAYS = 3 * BIT / 2, /* what a match has to save: the codes of its literals grow rarer by it */
    MUCH = 24,          /* of longer matches, only the first and last places are remembered */
    FEW = 8,
    CLOSE = 4,                    /* bytes: distances without extra bits */
    SOON_AFTER = 2,               /* bytes after a match, where others are likely */
    RARE = 10,                    /* one literal in so many bytes */
    DEEPER = 3,                   /* times as deep, where literals are rare */
    PASS_MAX = 3,                 /* bytes that are passed over, where matches are rare; ... */
    NOISE = NTPIO_TABLE_BITS - 4, /* ... from 2^10 without a match on, a 2^8th of them, ... */
    GROWS = NTPIO_TABLE_BITS - 6, /* (sooner in fuzzing) */
    NOISE_PASS = 15               /* ... up to so many */
};

/* What it saves << 32 | its symbol.  One number stays in a register, where a struct does not. */
typedef uint64_t match;

static const uint64_t NOTHING = (uint64_t) PAYS << 32;

/* This match, if it saves more than the best one. */
static inline match better(const ntpio__deflater *d, match best, const uint16_t *sums, size_t back,
                           uint32_t length)
{
    const uint32_t distance = (uint32_t) back - 1;
    const uint32_t whole = (uint16_t) (sums[length] - sums[0]);
    const uint32_t cost = d->lengths[length] + d->distances[ntpio__distance_slot(distance)];
    if (whole < cost || whole - cost <= best >> 32)
        return best;
    return (match) (whole - cost) << 32 | length << 16 | distance;
}

static inline uint32_t most_at(const ntpio__deflater *d, size_t at)
{
    return d->to - at < NTPIO__LENGTH_MAX ? (uint32_t) (d->to - at) : NTPIO__LENGTH_MAX;
}

/* Do the bytes repeat the few before them?  Short distances cost few bits. */
static inline bool repeats_few(const uint8_t *here)
{
    for (int i = 1; i <= CLOSE; i++) {
        if (load(here) == load(here - i))
            return true;
    }
    return false;
}

/* After the longest match there is: does it go on? */
static inline match goes_on(const ntpio__deflater *d, size_t at, match last)
{
    const uint32_t distance = ((uint32_t) last & 0xffff) + 1;
    const uint8_t *here = d->bytes + at;
    const bool may = (uint32_t) last >> 16 == NTPIO__LENGTH_MAX &&
                     most_at(d, at) == NTPIO__LENGTH_MAX &&
                     (distance <= CLOSE || !repeats_few(here));
    return may && common(here - distance, here, NTPIO__LENGTH_MAX) == NTPIO__LENGTH_MAX ? last
                                                                                        : NOTHING;
}

/* A match that was found after bytes were passed over, from as many bytes before as are equal, too. */
static inline ntpio__match reach_back(const ntpio__deflater *d, ntpio__match m, size_t at,
                                      size_t least)
{
    const uint8_t *here = d->bytes + at, *there = here - (m & 0xffff) - 1;
    size_t most = NTPIO__LENGTH_MAX - (m >> 16), back = 0;
    if (most > at - least)
        most = at - least;
    while (back < most && there - back > d->bytes &&
           here[-1 - (ptrdiff_t) back] == there[-1 - (ptrdiff_t) back])
        back++;
    return m + ((ntpio__match) back << 16);
}

/* Few bytes are looked at where there was no match for long. */
static inline size_t passed_over(size_t misses, int patience)
{
    const size_t pass = misses >> patience, more = misses >> GROWS;
    if (misses >> NOISE == 0 || pass == 0)
        return pass < PASS_MAX ? pass : PASS_MAX;
    return more < NOISE_PASS ? more : NOISE_PASS;
}

/* Of the next eight bytes; `shift` puts the last ones out of the number. */
static inline int32_t *wide_slot(ntpio__deflater *d, uint64_t next, unsigned shift)
{
    return &d->far_places[(next << shift) * 0x9e3779b185ebca87u >> (64 - FAR_BITS)];
}

#endif
