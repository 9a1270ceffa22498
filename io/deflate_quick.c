/* SPDX-License-Identifier: MIT */
/*
 * deflate_quick.c - takes the match that saves most, at a byte or at the next one; at level 1, any that
 * saves enough
 */
#include "deflate_match.h"
#include "simd.h"

enum {
    ZLIB_PASS = 7,           /* bytes that are passed over in zlib's way, where matches are rare */
    LITERALS_COST = 4 * BIT, /* on average; where they cost less, shorter matches hardly pay */
    LEAPS = 31,              /* spans, after one that was looked at closely */
    SHORT_PAY = 16,          /* a match below FAR_BYTES for so many literals: no leaps */
    LAZY = 16, /* zlib's level 6: a match this long is taken without a look at the next byte */
    GOOD = 8   /* ... next to a match this long, a quarter of the places is looked at */
};

/* The match that saves most.  sums: from this byte on; with_near: those shorter than FAR_BYTES count, too;
 * of the chain, `depth` places are looked at. */
static inline match best_match(ntpio__deflater *d, size_t at, const uint16_t *sums, bool with_near,
                               int depth, uint32_t enough)
{
    match m = NOTHING;
    const uint8_t *here = d->bytes + at;
    const uint32_t most = most_at(d, at);
    places p = visit(d, at);
    uint32_t longest = NEAR_BYTES - 1;
    if (with_near && is_near(d, p.near, at)) {
        const uint32_t length = (uint32_t) common(d->bytes + p.near, here, most);
        if (length > longest) {
            longest = length;
            m = better(d, m, sums, at - (size_t) p.near, length);
            if (length >= enough || length >= most)
                return m;
        }
    }
    for (int n = depth; n > 0 && in_reach(p.far, at); n--, p.far = earlier(d, p.far)) {
        const uint8_t *there = d->bytes + p.far;
        if (!may_exceed(there, here, longest))
            continue;
        const uint32_t length = (uint32_t) common(there, here, most);
        if (length > longest && length >= FAR_BYTES) {
            longest = length;
            m = better(d, m, sums, at - (size_t) p.far, length);
            if (length >= enough || length >= most)
                break;
        }
    }
    return m;
}

/* From `from` to `to` - 1; `sums` begins there with `sum`.  Returns the last one, whole. */
static uint32_t sum_some(const ntpio__deflater *d, size_t from, size_t to, uint32_t sum,
                         uint16_t *sums)
{
    const uint8_t *bytes = d->bytes + from;
    const size_t size = to - from;
    size_t i = 0;
#ifdef NTPIO_HAVE_AVX512
    if (ntpio__has_avx512())
        i = ntpio__sum_costs_avx512(bytes, size, d->literals, &sum, sums);
#endif
    while (i < size) {
        const size_t end = size - i < LINE ? size : i + LINE;
        __builtin_prefetch((const void *) ((uintptr_t) bytes + i + AHEAD));
        for (; i < end; i++) {
            sums[i] = (uint16_t) sum;
            sum += d->literals[bytes[i]];
        }
    }
    sums[size] = (uint16_t) sum;
    return sum;
}

/* Returns what all from `from` to `to` - 1 cost as literals. */
static uint32_t sum_literals(ntpio__deflater *d, size_t from, size_t to)
{
    const size_t end = d->to - to < NTPIO__LENGTH_MAX ? d->to : to + NTPIO__LENGTH_MAX;
    const uint32_t sum = sum_some(d, from, to, 0, d->sums);
    sum_some(d, to, end, sum, d->sums + (to - from));
    return sum;
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

/* ------------------------------------------------------------------------- leaping */

/*
 * Level 1 remembers only where the next eight bytes stood last, or the next six where literals are
 * dear: `shift` puts the others out of the number.  A match is taken from its first byte, which may
 * have been passed over.  Now and then a span is read closely, and so are those after it while short
 * matches pay.
 */
/* As common, where up to 15 equal bytes are likely. */
static inline uint32_t common_soon(const uint8_t *a, const uint8_t *b, uint32_t most)
{
    const uint64_t first = load(a) ^ load(b), second = load(a + 8) ^ load(b + 8);
    if ((first | second) == 0)
        return (uint32_t) common(a, b, most);
    const uint64_t other = first != 0 ? first : second;
    const uint32_t same = (first != 0 ? 0 : 8) + (uint32_t) __builtin_ctzll(other) / 8;
    return same < most ? same : most;
}

/* The newest match, or one as far back as the last far one: rows repeat those above. */
NTPIO_PART match leap_match(ntpio__deflater *d, size_t at, const uint16_t *sums, unsigned shift,
                            size_t *last)
{
    const uint8_t *here = d->bytes + at;
    const uint64_t next = load(here);
    int32_t *slot = wide_slot(d, next, shift);
    const int32_t place = *slot;
    const uint32_t back = (uint32_t) at - (uint32_t) place;
    const uint32_t out_of_reach = (back - 1) / NTPIO__WINDOW | (uint32_t) place >> 31;
    /* Without a branch, as it is hard to foresee; and what is far away is not in the cache. */
    const uint8_t *there = here - (back & -(uint32_t) (out_of_reach == 0));
    *slot = (int32_t) at;
    __builtin_prefetch(wide_slot(d, load(here + SOON), shift), 1);
    if (((load(there) ^ next) << shift | out_of_reach) != 0)
        return NOTHING;
    const uint32_t most = most_at(d, at);
    uint32_t length = common_soon(there, here, most);
    match m = NOTHING;
    if (length >= FAR_BYTES)
        m = better(d, m, sums, back, length);
    if (*last != 0 && (uint32_t) m != 0 && length < most) {
        length = (uint32_t) common(here - *last, here, most);
        if (length >= FAR_BYTES)
            m = better(d, m, sums, *last, length);
    }
    if ((m & 0xffff) >= CLOSE)
        *last = (m & 0xffff) + 1;
    return m;
}

NTPIO_PART void visit_leaping(ntpio__deflater *d, size_t from, size_t to, unsigned shift)
{
    const size_t gap = to - from > MUCH ? from + FEW : to;
    for (size_t i = from; i < gap; i++)
        *wide_slot(d, load(d->bytes + i), shift) = (int32_t) i;
    for (size_t i = gap < to ? to - MUCH / 2 : to; i < to; i++)
        *wide_slot(d, load(d->bytes + i), shift) = (int32_t) i;
}

NTPIO_PART size_t leap(ntpio__deflater *d, size_t from, size_t to, unsigned shift)
{
    size_t at = from, written = from, misses = d->misses;
    ntpio__step *out = d->steps + d->count;
    size_t last = 0;
    match next = NOTHING;
    while (at < to) {
        const match m =
            (uint32_t) next != 0 ? next : leap_match(d, at, d->sums + (at - from), shift, &last);
        const uint32_t length = (uint32_t) m >> 16;
        next = NOTHING;
        if (length == 0) {
            at += 1 + passed_over(misses++, d->effort->patience);
            continue;
        }
        const ntpio__match taken = reach_back(d, (ntpio__match) m, at, written);
        misses = 0;
        *out++ = (ntpio__step) { (uint32_t) (at + length - (taken >> 16) - written), taken };
        visit_leaping(d, at + 1, at + length, shift);
        at += length;
        written = at;
        next = at < to ? goes_on(d, at, m) : NOTHING;
    }
    d->misses = misses;
    at = at < d->to ? at : d->to;
    if (at > written)
        *out++ = (ntpio__step) { (uint32_t) (at - written), 0 };
    d->count = (size_t) (out - d->steps);
    return at;
}

/* dear: do literals cost much? */
static size_t read_leaping(ntpio__deflater *d, size_t from, size_t to, bool dear)
{
    return dear ? leap(d, from, to, 64 - 8 * FAR_BYTES) : leap(d, from, to, 0);
}

/* ------------------------------------------------------------------------- closely */

/* Reads the span up to `to`, or as far as its last match goes.  Returns where that is. */
static size_t read_closely(ntpio__deflater *d, size_t from, size_t to)
{
    const effort e = *d->effort;
    size_t at = from, written = from;
    size_t misses = d->misses, literals = 0; /* bytes in a row without a match; all of them */
    size_t shorts = 0;
    uint64_t saved_by_short = 0;
    const bool deeper = d->literals_are_rare && !e.leaps; /* leaps leave no chains */
    const int deep = deeper ? DEEPER * e.deep : e.deep, depth = deeper ? deep : e.depth;
    ntpio__step *out = d->steps + d->count;
    const uint16_t *sums = d->sums; /* of the byte at `from` */
    match m = best_match(d, at, sums + (at - from), true, deep, e.enough);
    for (;;) {
        const uint32_t length = (uint32_t) m >> 16;
        match next = NOTHING;
        if (length == 0) {
            at += 1 + passed_over(misses++, e.patience);
        } else {
            const ntpio__match taken = misses >> NOISE == 0
                                           ? (ntpio__match) m
                                           : reach_back(d, (ntpio__match) m, at, written);
            const size_t back = (taken >> 16) - length;
            const bool looks = back == 0 && length < e.enough && e.looks_ahead && at + 1 < to;
            misses = 0;
            if (looks)
                next = best_match(d, at + 1, sums + (at + 1 - from), true, deep, e.enough);
            if (next >> 32 > m >> 32) {
                at++;
                m = next;
                continue;
            }
            literals += at - back - written;
            shorts += length < FAR_BYTES;
            saved_by_short += length < WIDE_BYTES ? m >> 32 : 0;
            *out++ = (ntpio__step) { (uint32_t) (at - back - written), taken };
            visit_all(d, at + 1 + looks, at + length);
            at += length;
            written = at;
            next = at < to ? goes_on(d, at, m) : NOTHING;
        }
        if (at >= to)
            break;
        m = (uint32_t) next != 0
                ? next
                : best_match(d, at, sums + (at - from), misses >> e.near_patience == 0,
                             misses < SOON_AFTER ? deep : depth, e.enough);
    }
    d->misses = misses;
    d->saved_by_short += saved_by_short;
    at = at < d->to ? at : d->to;
    literals += at - written;
    d->literals_are_rare = RARE * literals < at - from;
    d->leaps = e.leaps && SHORT_PAY * shorts <= literals ? LEAPS : 0;
    if (at > written)
        *out++ = (ntpio__step) { (uint32_t) (at - written), 0 };
    d->count = (size_t) (out - d->steps);
    return at;
}

size_t ntpio__read_quickly(ntpio__deflater *d, size_t from, size_t to)
{
    const uint32_t cost = sum_literals(d, from, to);
    if (d->effort->far)
        return ntpio__read_far(d, from, to);
    if (d->leaps == 0)
        return read_closely(d, from, to);
    d->leaps--;
    return read_leaping(d, from, to, cost > LITERALS_COST * (to - from));
}

/* ------------------------------------------------------------------------ as zlib does */

/*
 * Most bytes of noise stand nowhere before, and yet two of three find a place: one of other bytes with the same
 * number.  The processor cannot foresee how many of these follow each other, and waits for longer than it takes
 * to look at them.  So marks tell, for eight times as many numbers, in which part of the bytes they stood last.
 * If that is out of reach, there is no match of FAR_BYTES.  An old mark may look like a new one: then places are
 * looked at, and nothing is found.
 */
static inline size_t mark_slot(uint64_t next)
{
    return (size_t) ((next << (64 - 8 * FAR_BYTES)) * 0x9e3779b185ebca87u >> (64 - MARK_BITS));
}

/* Remembers a place for matches of FAR_BYTES and more; returns the newest one before it, or -1 if none is in
 * reach that has the same bytes. */
static inline int32_t visit_far(ntpio__deflater *d, size_t at)
{
    enum { REACH = NTPIO__WINDOW >> MARK_SHIFT, FIRST = REACH + 1 }; /* 0: never */
    const uint64_t soon = load(d->bytes + at + SOON);
    const size_t slot = mark_slot(load(d->bytes + at));
    int32_t *const far = &d->far_places[slot >> (MARK_BITS - FAR_BITS)];
    const uint8_t now = (uint8_t) ((at >> MARK_SHIFT) + FIRST), last = d->marks[slot];
    const int32_t place = *far;
    __builtin_prefetch(&d->marks[mark_slot(soon)], 1);
    __builtin_prefetch(&d->far_places[far_slot(soon)], 1);
    d->before[at % NTPIO__WINDOW] = place;
    *far = (int32_t) at;
    d->marks[slot] = now;
    return (uint8_t) (now - last) <= REACH ? place : -1;
}

void ntpio__visit_as_zlib(ntpio__deflater *d, size_t from, size_t to)
{
    for (size_t i = from; i < to; i++)
        visit_far(d, i);
}

/* The longest match that is longer than `longest`, or 0; the nearest of equals. */
static inline ntpio__match longest_match(const ntpio__deflater *d, size_t at, int32_t place,
                                         uint32_t longest, int depth)
{
    ntpio__match m = 0;
    const uint8_t *here = d->bytes + at;
    const uint32_t most = most_at(d, at);
    for (int n = depth; n > 0 && in_reach(place, at); n--, place = earlier(d, place)) {
        const uint8_t *there = d->bytes + place;
        if (!may_exceed(there, here, longest))
            continue;
        const uint32_t length = (uint32_t) common(there, here, most);
        if (length > longest) {
            longest = length;
            m = length << 16 | ((uint32_t) (at - (size_t) place) - 1);
            if (length >= d->effort->enough || length >= most)
                break;
        }
    }
    return m;
}

size_t ntpio__read_as_zlib(ntpio__deflater *d, size_t from, size_t to)
{
    const effort e = *d->effort;
    size_t at = from, written = from, misses = d->misses;
    size_t start = from;   /* of the last match */
    ntpio__match last = 0; /* of the byte before, which waits */
    while (at < d->to && (at < to || last != 0)) {
        const uint32_t known = last >> 16;
        const int32_t place = visit_far(d, at);
        ntpio__match next = 0;
        if (known < LAZY)
            next = longest_match(d, at, place, known < FAR_BYTES ? FAR_BYTES - 1 : known,
                                 known < GOOD ? e.depth : e.depth / 4);
        if (last != 0 && next == 0) {
            d->steps[d->count++] = (ntpio__step) { (uint32_t) (start - written), last };
            written = start + known;
            misses = 0;
            while (++at < written)
                visit_far(d, at);
        } else if (next != 0) {
            const ntpio__match longer =
                misses >> NOISE == 0 || last != 0 ? next : reach_back(d, next, at, written);
            start = at++ - ((longer - next) >> 16);
            next = longer;
        } else {
            const size_t pass = misses++ >> NOISE;
            const size_t end = at + 1 + (pass < ZLIB_PASS ? pass : ZLIB_PASS);
            while (++at < end && at < d->to)
                visit_far(d, at);
        }
        last = next;
    }
    d->misses = misses;
    if (at > written)
        d->steps[d->count++] = (ntpio__step) { (uint32_t) (at - written), 0 };
    return at;
}
