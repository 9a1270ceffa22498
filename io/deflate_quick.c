/* SPDX-License-Identifier: MIT */
/*
 * deflate_quick.c - takes the match that saves most, at a byte or at the next one
 */
#include "deflate_state.h"

enum {
    PAYS = 2 * BIT, /* what a match has to save: the codes of its literals grow rarer by it */
    MUCH = 64,      /* of longer matches, only the first and last places are remembered */
    FEW = 16,
    PASS_MAX = 3 /* bytes, where matches are rare */
};

/* What it saves << 32 | its symbol.  One number stays in a register, where a struct does not. */
typedef uint64_t match;

static const uint64_t NOTHING = (uint64_t) PAYS << 32;

/* This match, if it saves more than the best one. */
static inline match better(const ntpio__deflater *d, match best, const uint32_t *sums, size_t back,
                           uint32_t length)
{
    const uint32_t distance = (uint32_t) back - 1;
    const uint32_t whole = sums[length] - sums[0];
    const uint32_t cost = d->lengths[length] + d->distances[ntpio__distance_slot(distance)];
    if (whole < cost || whole - cost <= best >> 32)
        return best;
    return (match) (whole - cost) << 32 | length << 16 | distance;
}

/* The match that saves most.  sums: from this byte on. */
static inline match best_match(ntpio__deflater *d, size_t at, const uint32_t *sums, int depth,
                               uint32_t enough)
{
    match m = NOTHING;
    const uint8_t *here = d->bytes + at;
    const size_t left = d->to - at;
    const uint32_t most = left < NTPIO__LENGTH_MAX ? (uint32_t) left : NTPIO__LENGTH_MAX;
    places p = visit(d, at);
    uint32_t longest = 0;
    if (p.near >= 0) {
        const uint32_t length = (uint32_t) common(d->bytes + p.near, here, most);
        if (length >= NEAR_BYTES) {
            longest = length;
            m = better(d, m, sums, at - (size_t) p.near, length);
        }
    }
    for (int n = depth; n > 0 && in_reach(p.far, at); n--, p.far = earlier(d, p.far)) {
        if (longest >= most || longest >= enough)
            break;
        const uint8_t *there = d->bytes + p.far;
        if (p.far == p.near || !may_exceed(there, here, longest))
            continue;
        const uint32_t length = (uint32_t) common(there, here, most);
        if (length > longest && length >= FAR_BYTES) {
            longest = length;
            m = better(d, m, sums, at - (size_t) p.far, length);
        }
    }
    return m;
}

static void sum_literals(ntpio__deflater *d, size_t from, size_t to)
{
    uint32_t sum = 0;
    const size_t end = d->to - to < NTPIO__LENGTH_MAX ? d->to : to + NTPIO__LENGTH_MAX;
    for (size_t i = from; i < end; i++) {
        d->sums[i - from] = sum;
        sum += d->literals[d->bytes[i]];
    }
    d->sums[end - from] = sum;
}

static void visit_all(ntpio__deflater *d, size_t from, size_t to)
{
    size_t i = from;
    if (to - from > MUCH) {
        for (; i < from + FEW; i++)
            visit(d, i);
        i = to - MUCH / 2;
    }
    for (; i < to; i++)
        visit(d, i);
}

/* Reads the span up to `to`, or as far as its last match goes.  Returns where that is. */
size_t ntpio__read_quickly(ntpio__deflater *d, size_t from, size_t to)
{
    const effort e = *d->effort;
    const uint8_t *bytes = d->bytes;
    ntpio__symbol *out = d->symbols + d->count;
    size_t at = from, misses = 0; /* misses: bytes in a row without a match */
    sum_literals(d, from, to);
    match m = best_match(d, at, d->sums + (at - from), e.depth, e.enough);
    for (;;) {
        bool looked = false;
        match next = NOTHING;
        const uint32_t length = (uint32_t) m >> 16;
        if (length == 0) {
            *out++ = bytes[at++];
            size_t pass = misses++ >> e.patience;
            for (pass = pass < PASS_MAX ? pass : PASS_MAX; pass > 0 && at < to; pass--)
                *out++ = bytes[at++];
        } else {
            misses = 0;
            if (length < e.enough && e.looks_ahead && at + 1 < to) {
                looked = true;
                next = best_match(d, at + 1, d->sums + (at + 1 - from), e.depth, e.enough);
            }
            if (next >> 32 > m >> 32) {
                *out++ = bytes[at++];
                m = next;
                continue;
            }
            *out++ = (ntpio__symbol) m;
            visit_all(d, at + 1 + looked, at + length);
            at += length;
        }
        if (at >= to)
            break;
        m = best_match(d, at, d->sums + (at - from), e.depth, e.enough);
    }
    d->count = (size_t) (out - d->symbols);
    return at;
}
