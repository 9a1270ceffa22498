/* SPDX-License-Identifier: MIT */
/*
 * thread_crew.c - threads for the parts of one large piece of work
 *
 * Each thread takes the next index, and so does the caller.  Then the caller waits for the last
 * one.
 */
#include "run/thread_crew.h"

#include <stdbool.h>
#include <stdlib.h>

#include "os/threads.h"
#include "text/text.h"

struct crew {
    os_lock lock;
    os_condition has_work, is_done;
    void (*task)(void *work, int32_t index);
    void *work;
    int32_t count, next, open; /* all indices; the next one to take; how many are not done */
    bool stop;
    int threads; /* besides the caller */
    os_thread thread[];
};

/* Does parts while there are any.  The caller holds the lock before and after. */
static void take_part(crew *c)
{
    while (c->next < c->count) {
        const int32_t index = c->next++;
        void (*task)(void *, int32_t) = c->task;
        void *work = c->work;
        os_lock_release(&c->lock);
        task(work, index);
        os_lock_take(&c->lock);
        if (--c->open == 0)
            os_condition_wake_one(&c->is_done);
    }
}

static void *wait_for_work(void *context)
{
    crew *c = context;
    os_lock_take(&c->lock);
    while (!c->stop) {
        take_part(c);
        if (!c->stop)
            os_condition_wait(&c->has_work, &c->lock);
    }
    os_lock_release(&c->lock);
    return NULL;
}

crew *crew_start(int threads)
{
    const size_t more = threads > 1 ? (size_t) threads - 1 : 0;
    crew *c = need(calloc(1, sizeof *c + more * sizeof c->thread[0]));
    os_lock_init(&c->lock);
    os_condition_init(&c->has_work);
    os_condition_init(&c->is_done);
    while (c->threads < (int) more &&
           os_thread_start(&c->thread[c->threads], wait_for_work, c) == 0)
        c->threads++;
    return c;
}

void crew_stop(crew *c)
{
    if (c == NULL)
        return;
    os_lock_take(&c->lock);
    c->stop = true;
    os_condition_wake_all(&c->has_work);
    os_lock_release(&c->lock);
    for (int i = 0; i < c->threads; i++)
        os_thread_join(c->thread[i]);
    os_condition_destroy(&c->is_done);
    os_condition_destroy(&c->has_work);
    os_lock_destroy(&c->lock);
    free(c);
}

void crew_run(void *crew_of_threads, int32_t count, void (*task)(void *work, int32_t index),
              void *work)
{
    crew *c = crew_of_threads;
    os_lock_take(&c->lock);
    c->task = task;
    c->work = work;
    c->count = c->open = count;
    c->next = 0;
    os_condition_wake_all(&c->has_work);
    take_part(c);
    while (c->open > 0)
        os_condition_wait(&c->is_done, &c->lock);
    c->count = c->next = 0;
    os_lock_release(&c->lock);
}
