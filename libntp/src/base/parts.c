/* SPDX-License-Identifier: MIT */
/*
 * parts.c - shares items of work out among the parts that the caller's hooks offer
 *
 * Of plain items part p of n does p, p + n, p + 2n and so on, so one call of parallel_for does them
 * all.  Blocks of two steps are taken as they come.  The result of an item or a block does not
 * depend on which part does it.
 *
 * parallel_for may also run the parts one after another.  So a part does not wait for another,
 * unless that one is at work on a chain, and not for long: it ends when it finds nothing to do.
 * Whoever completes a step looks for more, so the last one does all that is left.
 */
#include "base/parts.h"

#include <stdatomic.h>
#include <stddef.h>

ntp__crew ntp__crew_of(const ntp_hooks *hooks)
{
    ntp__crew crew = { hooks, hooks != NULL && hooks->parts != 0 ? hooks->parts : 1 };
    return crew;
}

/* Does task(work, part) for each of the parts. */
static void run_parts(const ntp__crew *crew, int32_t parts, void (*task)(void *work, int32_t part),
                      void *work)
{
    if (crew->hooks != NULL && crew->hooks->parallel_for != NULL && parts > 1) {
        crew->hooks->parallel_for(crew->hooks->user, parts, task, work);
        return;
    }
    for (int32_t part = 0; part < parts; part++)
        task(work, part);
}

/* --------------------------------------------------------------------------- plain items */

typedef struct shift {
    ntp__crew_task *task;
    void *job;
    int32_t count, parts;
} shift;

static void work_part(void *work, int32_t part)
{
    const shift *s = work;
    for (int32_t item = part; item < s->count; item += s->parts)
        s->task(s->job, part, item);
}

void ntp__crew_each(const ntp__crew *crew, ntp__crew_task *task, void *job, int32_t count)
{
    shift s = { task, job, count, crew->parts < count ? crew->parts : count };
    run_parts(crew, s.parts, work_part, &s);
}

/* -------------------------------------------------------------------------------- blocks */

enum { PATIENCE = 1 << 15 /* looks at a chain that another part has; some 0.1 ms */ };

typedef struct line {
    const ntp__crew_steps *steps;
    int32_t parts;
    _Atomic int32_t taken;                    /* blocks that parts have begun to do `each` of */
    _Atomic int32_t maker[NTP__MOST_BLOCKS];  /* 1 + the part that has done `each`; 0: none yet */
    _Atomic int32_t chained[NTP__MOST_LANES]; /* blocks that are done in the lane */
    _Atomic int32_t held[NTP__MOST_LANES];    /* 1: a part is at work on the lane */
} line;

/* May the part do the next block of the lane?  Not unless `each` has been done.  The block is left
 * to the part that did that, unless the chain falls behind or there is nothing else to do. */
static bool next_is_ready(line *l, int32_t lane, int32_t part)
{
    int32_t k = l->chained[lane];
    if (k >= l->steps->count || l->maker[k] == 0)
        return false;
    return l->steps->lanes > 1 || l->maker[k] == part + 1 || l->taken >= l->steps->count ||
           l->taken - k > 2 * l->parts;
}

/* Does what is ready in the lane, unless another part is at work on it.  That part looks again
 * after it lets go of the lane, so nothing is forgotten. */
static void follow_lane(line *l, int32_t lane, int32_t part)
{
    while (next_is_ready(l, lane, part)) {
        if (atomic_exchange(&l->held[lane], 1) != 0)
            return;
        while (next_is_ready(l, lane, part)) {
            l->steps->chain(l->steps->job, lane, l->chained[lane]);
            l->chained[lane]++;
        }
        l->held[lane] = 0;
    }
}

static void follow(line *l, int32_t part)
{
    for (int32_t i = 0; i < l->steps->lanes; i++)
        follow_lane(l, (part + i) % l->steps->lanes, part);
}

static void each_first(void *work, int32_t part)
{
    line *l = work;
    const ntp__crew_steps *s = l->steps;
    for (;;) {
        int32_t k = atomic_fetch_add(&l->taken, 1);
        if (k >= s->count)
            break;
        s->each(s->job, part, k);
        l->maker[k] = part + 1;
        follow(l, part);
    }
    follow(l, part);
}

/* The number of blocks that all lanes have done. */
static int32_t chained_whole(line *l)
{
    int32_t least = l->steps->count;
    for (int32_t i = 0; i < l->steps->lanes; i++)
        least = l->chained[i] < least ? l->chained[i] : least;
    return least;
}

/* Lets lanes run ahead of the blocks that are taken, by a block for each part. */
static void lead(line *l, int32_t part)
{
    for (int32_t i = 0; i < l->steps->lanes; i++) {
        int32_t lane = (part + i) % l->steps->lanes;
        if (l->chained[lane] >= l->steps->count || l->held[lane] != 0 ||
            atomic_exchange(&l->held[lane], 1) != 0)
            continue;
        int32_t end = l->taken + l->parts;
        for (int32_t k = l->chained[lane]; k < end && k < l->steps->count; k++) {
            l->steps->chain(l->steps->job, lane, k);
            l->chained[lane] = k + 1;
        }
        l->held[lane] = 0;
    }
}

static bool take_block(line *l, int32_t *k)
{
    *k = l->taken;
    while (*k < chained_whole(l)) {
        if (atomic_compare_exchange_weak(&l->taken, k, *k + 1))
            return true;
    }
    return false;
}

static void chain_first(void *work, int32_t part)
{
    line *l = work;
    const ntp__crew_steps *s = l->steps;
    for (int32_t looks = 0; looks < PATIENCE && l->taken < s->count; looks++) {
        int32_t k;
        if (take_block(l, &k)) {
            s->each(s->job, part, k);
            looks = 0;
        } else {
            lead(l, part);
        }
    }
}

void ntp__crew_blocks(const ntp__crew *crew, const ntp__crew_steps *steps)
{
    line l = { .steps = steps, .parts = crew->parts < steps->count ? crew->parts : steps->count };
    run_parts(crew, l.parts, steps->chain_first ? chain_first : each_first, &l);
}
