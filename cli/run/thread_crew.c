/* SPDX-License-Identifier: MIT */
/*
 * thread_crew.c - threads for the parts of one large piece of work
 *
 * Each thread takes the next index, and so does the caller.  Then the caller waits for the last
 * one.
 */
#include "run/thread_crew.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>

#include "text/text.h"

struct crew {
    pthread_mutex_t lock;
    pthread_cond_t has_work, is_done;
    void (*task)(void *work, int32_t index);
    void *work;
    int32_t count, next, open; /* all indices; the next one to take; how many are not done */
    bool stop;
    int threads; /* besides the caller */
    pthread_t thread[];
};

/* Does parts while there are any.  The caller holds the lock before and after. */
static void take_part(crew *c)
{
    while (c->next < c->count) {
        const int32_t index = c->next++;
        void (*task)(void *, int32_t) = c->task;
        void *work = c->work;
        pthread_mutex_unlock(&c->lock);
        task(work, index);
        pthread_mutex_lock(&c->lock);
        if (--c->open == 0)
            pthread_cond_signal(&c->is_done);
    }
}

static void *wait_for_work(void *context)
{
    crew *c = context;
    pthread_mutex_lock(&c->lock);
    while (!c->stop) {
        take_part(c);
        if (!c->stop)
            pthread_cond_wait(&c->has_work, &c->lock);
    }
    pthread_mutex_unlock(&c->lock);
    return NULL;
}

crew *crew_start(int threads)
{
    const size_t more = threads > 1 ? (size_t) threads - 1 : 0;
    crew *c = need(calloc(1, sizeof *c + more * sizeof c->thread[0]));
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->has_work, NULL);
    pthread_cond_init(&c->is_done, NULL);
    while (c->threads < (int) more &&
           pthread_create(&c->thread[c->threads], NULL, wait_for_work, c) == 0)
        c->threads++;
    return c;
}

void crew_stop(crew *c)
{
    if (c == NULL)
        return;
    pthread_mutex_lock(&c->lock);
    c->stop = true;
    pthread_cond_broadcast(&c->has_work);
    pthread_mutex_unlock(&c->lock);
    for (int i = 0; i < c->threads; i++)
        pthread_join(c->thread[i], NULL);
    pthread_cond_destroy(&c->is_done);
    pthread_cond_destroy(&c->has_work);
    pthread_mutex_destroy(&c->lock);
    free(c);
}

void crew_run(void *crew_of_threads, int32_t count, void (*task)(void *work, int32_t index),
              void *work)
{
    crew *c = crew_of_threads;
    pthread_mutex_lock(&c->lock);
    c->task = task;
    c->work = work;
    c->count = c->open = count;
    c->next = 0;
    pthread_cond_broadcast(&c->has_work);
    take_part(c);
    while (c->open > 0)
        pthread_cond_wait(&c->is_done, &c->lock);
    c->count = c->next = 0;
    pthread_mutex_unlock(&c->lock);
}
