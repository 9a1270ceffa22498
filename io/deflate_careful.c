/* SPDX-License-Identifier: MIT */
/*
 * deflate_careful.c - finds a match for every byte, and the cheapest way through all of them
 */
#include "deflate_state.h"

enum {
    ENDS = 4,             /* lengths of a long match that are tried */
    MANY = 20,            /* bytes: shorter matches are tried at every length */
    FAR_ENOUGH = 1 << 14, /* bytes: how far a match is followed at once */
    KNOWN_ENOUGH = 16     /* bytes left of a near match: then farther ones are not looked for */
};

/* A match that goes on: known from the byte before. */
typedef struct run {
    size_t end;
    uint32_t distance;
} run;

static uint32_t part_of(const run *r, size_t at)
{
    const size_t left = r->end - at;
    return (uint32_t) (left < NTPIO__LENGTH_MAX ? left : NTPIO__LENGTH_MAX) << 16 | r->distance;
}

static size_t left_at(const ntpio__deflater *d, size_t at)
{
    return d->to - at < FAR_ENOUGH ? d->to - at : FAR_ENOUGH;
}

/* A long match stays until one with a shorter distance is as long as matches get. */
static uint32_t near_match(const ntpio__deflater *d, size_t at, int32_t place, run *known)
{
    const bool knows = at + KNOWN_ENOUGH <= known->end;
    const size_t distance = at - (size_t) place;
    if (place < 0 || (knows && distance > known->distance))
        return knows ? part_of(known, at) : 0;
    const size_t most = left_at(d, at),
                 tried = knows && most > NTPIO__LENGTH_MAX ? NTPIO__LENGTH_MAX : most;
    size_t length = common(d->bytes + place, d->bytes + at, tried);
    if (knows && length < NTPIO__LENGTH_MAX)
        return part_of(known, at);
    if (length < NEAR_BYTES)
        return 0;
    if (length == tried)
        length += common(d->bytes + place + length, d->bytes + at + length, most - length);
    *known = (run) { at + length, (uint32_t) distance - 1 };
    return part_of(known, at);
}

/* Longer than the near one, or that. */
static uint32_t long_match(const ntpio__deflater *d, size_t at, const places *p, uint32_t near,
                           run *known)
{
    const uint32_t enough = d->effort->enough;
    uint32_t longest = near >> 16, best = near;
    if (at + enough / 2 < known->end)
        return part_of(known, at) >> 16 > longest ? part_of(known, at) : near;
    int32_t place = p->far;
    for (int n = d->effort->depth; n > 0 && longest < enough && in_reach(place, at); n--) {
        const uint8_t *there = d->bytes + place;
        if (place != p->near && longest < d->to - at && may_exceed(there, d->bytes + at, longest)) {
            const size_t length = common(there, d->bytes + at, left_at(d, at));
            if (length > longest && length >= FAR_BYTES) {
                const run found = { at + length, (uint32_t) (at - (size_t) place) - 1 };
                best = part_of(&found, at);
                longest = best >> 16;
                if (length >= enough)
                    *known = found;
            }
        }
        place = earlier(d, place);
    }
    return best;
}

static void find_all(ntpio__deflater *d, size_t from, size_t to)
{
    run near_run = { 0, 0 }, far_run = { 0, 0 };
    for (size_t at = from; at < to; at++) {
        places p = visit(d, at);
        if (!is_near(d, p.near, at))
            p.near = -1;
        const uint32_t near = near_match(d, at, p.near, &near_run);
        d->careful->nearest[at - from] = near;
        d->careful->longest[at - from] = long_match(d, at, &p, near, &far_run);
    }
}

/* Takes the match, or one of its beginnings longer than `over`, where that is cheaper. */
static inline void try_match(const ntpio__deflater *d, uint32_t found, uint32_t over,
                             const uint32_t *cost, uint32_t *least, ntpio__match *best)
{
    const uint32_t length = found >> 16, distance = found & 0xffff;
    const uint32_t fixed = d->distances[ntpio__distance_slot(distance)];
    const uint32_t floor = length > MANY && over < length - ENDS ? length - ENDS : over;
    for (uint32_t n = length; n > floor; n--) {
        const uint32_t sum = fixed + d->lengths[n] + cost[n];
        if (sum < *least) {
            *least = sum;
            *best = n << 16 | distance;
        }
    }
}

/* The cheapest way from every byte to the end.  What lies beyond that costs nothing. */
static void find_way(ntpio__deflater *d, size_t from, size_t size)
{
    careful *c = d->careful;
    memset(c->cost + size, 0, NTPIO__LENGTH_MAX * sizeof *c->cost);
    for (size_t i = size; i-- > 0;) {
        uint32_t least = d->literals[d->bytes[from + i]] + c->cost[i + 1];
        const uint32_t near = c->nearest[i], far = c->longest[i];
        c->best[i] = 0;
        if (far != near)
            try_match(d, far, near != 0 ? near >> 16 : NEAR_BYTES - 1, c->cost + i, &least,
                      &c->best[i]);
        if (near != 0)
            try_match(d, near, NEAR_BYTES - 1, c->cost + i, &least, &c->best[i]);
        c->cost[i] = least;
    }
}

static void count_way(const ntpio__deflater *d, size_t from, size_t size, ntpio__counts *counts)
{
    memset(counts, 0, sizeof *counts);
    for (size_t i = 0; i < size;) {
        const ntpio__match s = d->careful->best[i];
        if (s == 0) {
            counts->words[d->bytes[from + i++]]++;
        } else {
            counts->words[NTPIO__FIRST_LENGTH + ntpio__length_slot(s >> 16)]++;
            counts->distances[ntpio__distance_slot(s & 0xffff)]++;
            i += s >> 16;
        }
    }
}

size_t ntpio__read_carefully(ntpio__deflater *d, size_t from, size_t to, bool first,
                             ntpio__counts *counts)
{
    size_t at = from;
    find_all(d, from, to);
    for (int i = first ? -1 : 0; i < d->effort->rounds; i++) {
        find_way(d, from, to - from);
        count_way(d, from, to - from, counts);
        if (i + 1 < d->effort->rounds)
            ntpio__set_costs(d, counts);
    }
    uint32_t literals = 0;
    size_t symbols = 0; /* of this part */
    while (at < to) {
        const ntpio__match m = d->careful->best[at - from];
        literals += m == 0;
        at += m == 0 ? 1 : m >> 16;
        const bool ends = ++symbols == PART || at >= to;
        if (m != 0 || ends) {
            d->steps[d->count++] = (ntpio__step) { literals, m };
            literals = 0;
        }
        if (ends) {
            ntpio__end_part(d);
            symbols = 0;
        }
    }
    for (size_t i = to; i < at; i++)
        visit(d, i);
    return at;
}
