/* SPDX-License-Identifier: MIT */
/*
 * crew.c - items of work shared out among the parts that the caller's hooks offer
 *
 * Each part does every parts-th item, so that one call of parallel_for does them all.  What an
 * item computes does not depend on the part that does it.
 */
#include "crew.h"

#include <stddef.h>

typedef struct shift {
    ntp__crew_task *task;
    void *job;
    int32_t parts, count;
} shift;

ntp__crew ntp__crew_of(const ntp_hooks *hooks)
{
    ntp__crew crew = { hooks, hooks != NULL && hooks->parts != 0 ? hooks->parts : 1 };
    return crew;
}

static void work_part(void *work, int32_t part)
{
    const shift *s = work;
    for (int32_t item = part; item < s->count; item += s->parts)
        s->task(s->job, part, item);
}

void ntp__crew_each(const ntp__crew *crew, ntp__crew_task *task, void *job, int32_t count)
{
    shift s = { task, job, crew->parts < count ? crew->parts : count, count };
    if (crew->hooks != NULL && crew->hooks->parallel_for != NULL && s.parts > 1) {
        crew->hooks->parallel_for(crew->hooks->user, s.parts, work_part, &s);
        return;
    }
    for (int32_t part = 0; part < s.parts; part++)
        work_part(&s, part);
}
