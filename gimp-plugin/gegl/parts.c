/* SPDX-License-Identifier: MIT */
/*
 * parts.c - work on a whole layer: shared out by GEGL, with progress
 */
#include "parts.h"

enum { MOST_PARTS = 16 };

typedef struct shares {
    gint32 count;
    void (*task)(void *work, gint32 index);
    void *work;
} shares;

static void do_share(gint i, gint n, gpointer data)
{
    const shares *all = data;
    for (gint32 k = i; k < all->count; k += n)
        all->task(all->work, k);
}

static void run_parts(void *user, gint32 count, void (*task)(void *work, gint32 index), void *work)
{
    shares all = { count, task, work };
    (void) user;
    gegl_parallel_distribute(count, do_share, &all);
}

static gint32 tell_progress(void *user, gdouble share)
{
    parts_tell(user, share);
    return 0;
}

ntp_hooks parts_hooks(GeglOperation *operation)
{
    return (ntp_hooks) {
        .user = operation, .progress = tell_progress, .parallel_for = run_parts, .parts = MOST_PARTS
    };
}

void parts_tell(GeglOperation *operation, gdouble share)
{
    gchar message[] = "";
    gegl_operation_progress(operation, share, message);
}
