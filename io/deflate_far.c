/* SPDX-License-Identifier: MIT */
/*
 * deflate_far.c - takes the match of eight bytes and more that saves most, at a byte or at the next one
 *
 * Where literals are cheap, shorter matches hardly pay, and yet they are found at most bytes.  One chain
 * of the places with the same eight bytes finds none of them.
 */
#include "deflate_match.h"

enum {
    LEAST = WIDE_BYTES,
    LAZY = 32,   /* a match this long is taken without a look at the next byte */
    LASTING = 16 /* next to a match this long, a quarter of the places is looked at */
};

/* Remembers a place; returns the newest one before it. */
static inline int32_t visit_wide(ntpio__deflater *d, size_t at)
{
    int32_t *slot = wide_slot(d, load(d->bytes + at), 0);
    const int32_t place = *slot;
    __builtin_prefetch(wide_slot(d, load(d->bytes + at + SOON), 0), 1);
    d->before[at % NTPIO__WINDOW] = place;
    *slot = (int32_t) at;
    return place;
}

/* The match that saves most of those longer than `longest`.  sums: from this byte on. */
static inline match best_wide(ntpio__deflater *d, size_t at, const uint16_t *sums, uint32_t longest,
                              int depth)
{
    match m = NOTHING;
    const uint8_t *here = d->bytes + at;
    int32_t place = visit_wide(d, at);
    if (!in_reach(place, at))
        return m;
    const uint32_t most = most_at(d, at), enough = d->effort->enough;
    size_t last = longest + 1 - LEAST; /* where the last bytes of a longer one are */
    uint64_t wanted = load(here + last);
    for (int n = depth; n > 0 && in_reach(place, at); n--, place = earlier(d, place)) {
        const uint8_t *there = d->bytes + place;
        if (load(there + last) != wanted)
            continue;
        const uint32_t length = (uint32_t) common(there, here, most);
        if (length <= longest)
            continue;
        m = better(d, m, sums, at - (size_t) place, length);
        if (length >= enough || length >= most)
            break;
        longest = length;
        last = length + 1 - LEAST;
        wanted = load(here + last);
    }
    return m;
}

void ntpio__visit_wide(ntpio__deflater *d, size_t from, size_t to)
{
    for (size_t i = from; i < to; i++)
        visit_wide(d, i);
}

static void visit_match(ntpio__deflater *d, size_t from, size_t to)
{
    const bool much = to - from > MUCH;
    if (much)
        ntpio__visit_wide(d, from, from + FEW);
    ntpio__visit_wide(d, much ? to - MUCH / 2 : from, to);
}

size_t ntpio__read_far(ntpio__deflater *d, size_t from, size_t to)
{
    const effort *e = d->effort;
    size_t at = from, written = from;
    size_t misses = d->misses, literals = 0; /* bytes in a row without a match; all of them */
    const int deep = d->literals_are_rare ? DEEPER * e->deep : e->deep;
    const int depth = d->literals_are_rare ? deep : e->depth;
    ntpio__step *out = d->steps + d->count;
    const uint16_t *sums = d->sums; /* of the byte at `from` */
    match m = best_wide(d, at, sums, LEAST - 1, deep);
    for (;;) {
        const uint32_t length = (uint32_t) m >> 16;
        match next = NOTHING;
        if (length == 0) {
            at += 1 + passed_over(misses++, e->patience);
        } else {
            const ntpio__match taken = misses >> NOISE == 0
                                           ? (ntpio__match) m
                                           : reach_back(d, (ntpio__match) m, at, written);
            const size_t back = (taken >> 16) - length;
            const bool looks = back == 0 && length < LAZY && at + 1 < to;
            misses = 0;
            if (looks)
                next = best_wide(d, at + 1, sums + (at + 1 - from), length - 1,
                                 length < LASTING ? deep : deep / 4);
            if (next >> 32 > m >> 32) {
                at++;
                m = next;
                continue;
            }
            literals += at - back - written;
            *out++ = (ntpio__step) { (uint32_t) (at - back - written), taken };
            visit_match(d, at + 1 + looks, at + length);
            at += length;
            written = at;
            next = at < to ? goes_on(d, at, m) : NOTHING;
        }
        if (at >= to)
            break;
        m = (uint32_t) next != 0 ? next
                                 : best_wide(d, at, sums + (at - from), LEAST - 1,
                                             misses < SOON_AFTER ? deep : depth);
    }
    d->misses = misses;
    at = at < d->to ? at : d->to;
    literals += at - written;
    d->literals_are_rare = RARE * literals < at - from;
    if (at > written)
        *out++ = (ntpio__step) { (uint32_t) (at - written), 0 };
    d->count = (size_t) (out - d->steps);
    return at;
}
