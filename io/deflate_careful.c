/* SPDX-License-Identifier: MIT */
/*
 * deflate_careful.c - finds matches of every length for every byte, and the cheapest way through all
 * of them
 */
#include "deflate_state.h"

enum {
    LEAST = 3,            /* bytes of a match: a texel of RGB often is like one of those before */
    ENDS = 4,             /* lengths of a long match that are tried */
    MANY = 20,            /* bytes: shorter matches are tried at every length */
    FAR_ENOUGH = 1 << 14, /* bytes: how far a match is followed at once */
    LONG = 2 * NTPIO__LENGTH_MAX, /* a match that goes on for so long hides all others */
    CLOSE = 8                     /* bytes: short distances cost few bits */
};

/* A match that goes on: known from a byte before. */
typedef struct run {
    size_t end;
    uint32_t distance; /* less one */
} run;

static uint32_t part_of(const run *r, size_t at)
{
    const size_t left = r->end - at;
    return (uint32_t) (left < NTPIO__LENGTH_MAX ? left : NTPIO__LENGTH_MAX) << 16 | r->distance;
}

/* What is found at a byte: matches in rising order of length, and of distance but for the first. */
typedef struct finds {
    ntpio__match *found;
    unsigned count;
    uint32_t longest, most, enough;
} finds;

static void add_find(finds *f, uint32_t length, size_t back)
{
    f->longest = length;
    f->count -= f->count == FOUND_MAX;
    f->found[f->count++] = length << 16 | ((uint32_t) back - 1);
}

static bool in_window(int32_t place, size_t at)
{
    return place >= 0 && at - (size_t) place < NTPIO__WINDOW;
}

/*
 * Takes the byte at `at` into the tree of the places whose next four bytes are the same (or have the
 * same hash), as its root: to one side those whose bytes come before in order, to the other those
 * whose come after.  On the way down, all that are longer than `longest` are found, the newest first.
 */
static void plant(ntpio__deflater *d, size_t at, int32_t *root, finds *f)
{
    int32_t(*sides)[2] = d->careful->sides;
    const uint8_t *here = d->bytes + at;
    int32_t place = *root,
            *ends[2] = { &sides[at % NTPIO__WINDOW][0], &sides[at % NTPIO__WINDOW][1] };
    uint32_t same[2] = { 0, 0 }, length = 0;
    *root = (int32_t) at;
    for (int n = d->effort->depth; n > 0 && in_window(place, at); n--) {
        const uint8_t *there = d->bytes + place;
        int32_t *next = sides[(size_t) place % NTPIO__WINDOW];
        if (there[length] == here[length]) {
            length += (uint32_t) common(there + length, here + length, f->most - length);
            if (length > f->longest)
                add_find(f, length, at - (size_t) place);
            if (length >= f->enough) {
                *ends[0] = next[0];
                *ends[1] = next[1];
                return;
            }
        }
        const bool after = there[length] > here[length];
        *ends[after] = place;
        ends[after] = &next[!after];
        place = next[!after];
        same[after] = length;
        length = same[!after] < length ? same[!after] : length;
    }
    *ends[0] = *ends[1] = -1;
}

/* The tables have other contents than at quick levels: where the next three bytes stood last, and the
 * roots of trees. */
static void visit_careful(ntpio__deflater *d, size_t at, finds *f)
{
    const uint32_t next = (uint32_t) load(d->bytes + at);
    int32_t *near = &d->near_places[((next << 8) * 0x9e3779b1u) >> (32 - NEAR_BITS)];
    int32_t *root = &d->far_places[(next * 0x9e3779b1u) >> (32 - FAR_BITS)];
    if (in_window(*near, at) && (((uint32_t) load(d->bytes + *near) ^ next) & 0xffffff) == 0 &&
        f->most >= LEAST && f->longest < LEAST)
        add_find(f, LEAST, at - (size_t) *near);
    *near = (int32_t) at;
    plant(d, at, root, f);
}

static finds no_finds(const ntpio__deflater *d, size_t at, ntpio__match *found)
{
    const uint32_t most =
        d->to - at < NTPIO__LENGTH_MAX ? (uint32_t) (d->to - at) : NTPIO__LENGTH_MAX;
    const uint32_t enough = d->effort->enough < most ? d->effort->enough : most;
    return (finds) { found, 0, LEAST - 1, most, enough };
}

void ntpio__visit_carefully(ntpio__deflater *d, size_t at)
{
    ntpio__match found[FOUND_MAX];
    finds f = no_finds(d, at, found);
    visit_careful(d, at, &f);
}

/* The match becomes the known one if it goes on for longer. */
static void follow(const ntpio__deflater *d, size_t at, ntpio__match match, run *known)
{
    const size_t most = d->to - at < FAR_ENOUGH ? d->to - at : FAR_ENOUGH;
    const size_t length = match >> 16, distance = (match & 0xffff) + 1;
    const uint8_t *here = d->bytes + at + length;
    if (at + length >= known->end) {
        known->end = at + length + common(here - distance, here, most - length);
        known->distance = match & 0xffff;
    }
}

/* Do the bytes repeat the few before them? */
static bool repeats_few(const uint8_t *here)
{
    for (int i = 1; i <= CLOSE; i++) {
        if (load(here) == load(here - i))
            return true;
    }
    return false;
}

/* In the midst of a long match, only that counts, and not even is the byte remembered. */
static unsigned find_at(ntpio__deflater *d, size_t at, ntpio__match *found, run *close, run *far)
{
    const run *known = at + LONG < close->end                                ? close
                       : at + LONG < far->end && !repeats_few(d->bytes + at) ? far
                                                                             : NULL;
    if (known != NULL) {
        found[0] = part_of(known, at);
        return 1;
    }
    finds f = no_finds(d, at, found);
    visit_careful(d, at, &f);
    if (f.longest >= f.enough && f.count > 0) {
        const ntpio__match last = found[f.count - 1];
        follow(d, at, last, (last & 0xffff) < CLOSE ? close : far);
    }
    if (at < far->end && part_of(far, at) >> 16 > f.longest)
        add_find(&f, part_of(far, at) >> 16, far->distance + (size_t) 1);
    return f.count;
}

static void find_all(ntpio__deflater *d, size_t from, size_t to)
{
    run close = { 0, 0 }, far = { 0, 0 };
    careful *c = d->careful;
    for (size_t at = from; at < to; at++)
        c->count[at - from] = (uint8_t) find_at(d, at, c->found[at - from], &close, &far);
}

/* The cheapest way from every byte to the end.  What lies beyond that costs nothing. */
static void find_way(ntpio__deflater *d, size_t from, size_t size)
{
    careful *c = d->careful;
    memset(c->cost + size, 0, NTPIO__LENGTH_MAX * sizeof *c->cost);
    for (size_t i = size; i-- > 0;) {
        const uint32_t *cost = c->cost + i;
        uint32_t least = d->literals[d->bytes[from + i]] + cost[1], over = LEAST - 1;
        ntpio__match best = 0;
        for (unsigned k = 0; k < c->count[i]; k++) {
            const uint32_t length = c->found[i][k] >> 16, distance = c->found[i][k] & 0xffff;
            const uint32_t fixed = d->distances[ntpio__distance_slot(distance)];
            const uint32_t floor = length > MANY && over < length - ENDS ? length - ENDS : over;
            for (uint32_t n = length; n > floor; n--) {
                const uint32_t sum = fixed + d->lengths[n] + cost[n];
                if (sum < least) {
                    least = sum;
                    best = n << 16 | distance;
                }
            }
            over = length;
        }
        c->best[i] = best;
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
        ntpio__visit_carefully(d, i);
    return at;
}
