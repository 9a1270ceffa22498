/* SPDX-License-Identifier: MIT */
/*
 * parts.c - shares items of work out among the parts that the caller's hooks offer
 *
 * Part p of n does items p, p + n, p + 2n and so on, so one call of parallel_for does them all.
 * The result of an item does not depend on which part does it.
 */
#include "base/parts.h"

#include <stddef.h>

typedef struct shift {
    const ntp__crew_items *items[2];
    int32_t parts;
} shift;

ntp__crew ntp__crew_of(const ntp_hooks *hooks)
{
    ntp__crew crew = { hooks, hooks != NULL && hooks->parts != 0 ? hooks->parts : 1 };
    return crew;
}

static void work_part(void *work, int32_t part)
{
    const shift *s = work;
    for (int32_t k = 0; k < 2; k++) {
        const ntp__crew_items *some = s->items[(k + part) % 2];
        for (int32_t item = part; item < some->count; item += s->parts)
            some->task(some->job, part, item);
    }
}

void ntp__crew_both(const ntp__crew *crew, const ntp__crew_items *a, const ntp__crew_items *b)
{
    int32_t most = a->count > b->count ? a->count : b->count;
    shift s = { { a, b }, crew->parts < most ? crew->parts : most };
    if (crew->hooks != NULL && crew->hooks->parallel_for != NULL && s.parts > 1) {
        crew->hooks->parallel_for(crew->hooks->user, s.parts, work_part, &s);
        return;
    }
    for (int32_t part = 0; part < s.parts; part++)
        work_part(&s, part);
}

void ntp__crew_each(const ntp__crew *crew, ntp__crew_task *task, void *job, int32_t count)
{
    const ntp__crew_items all = { task, job, count }, none = { task, job, 0 };
    ntp__crew_both(crew, &all, &none);
}
