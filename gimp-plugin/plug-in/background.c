/* SPDX-License-Identifier: MIT */
/*
 * background.c - long work while a window stays alive
 */
#include "background.h"
#include "host.h"

struct background {
    GThread *thread;
    gint share;   /* in millionths; atomic, as the next one */
    gint stopped; /* somebody asked for it */
    guint idle;   /* calls done; only the main loop sees it once the thread has ended */
    void (*work)(void *data, const surroundings *around);
    void (*done)(void *data);
    void *data;
};

static bool keep_share(void *user, double share)
{
    background *b = user;
    g_atomic_int_set(&b->share, (gint) (share * 1e6));
    return g_atomic_int_get(&b->stopped) == 0;
}

static gboolean tell(gpointer data)
{
    background *b = data;
    if (b->thread != NULL)
        g_thread_join(b->thread); /* it has written b->idle */
    b->thread = NULL;
    b->idle = 0;
    b->done(b->data); /* which may free b */
    return FALSE;
}

static gpointer run(gpointer data)
{
    background *b = data;
    surroundings around = host_surroundings;
    around.user = b;
    around.progress = keep_share;
    b->work(b->data, &around);
    b->idle = g_idle_add(tell, b);
    return NULL;
}

background *background_start(void (*work)(void *data, const surroundings *around),
                             void (*done)(void *data), void *data)
{
    background *b = g_new0(background, 1);
    b->work = work;
    b->done = done;
    b->data = data;
    b->thread = g_thread_new("ntp", run, b);
    return b;
}

double background_share(background *b)
{
    return g_atomic_int_get(&b->share) / 1e6;
}

void background_stop(background *b)
{
    if (b == NULL)
        return;
    g_atomic_int_set(&b->stopped, 1);
    if (b->thread != NULL)
        g_thread_join(b->thread);
    if (b->idle != 0)
        g_source_remove(b->idle);
    g_free(b);
}
