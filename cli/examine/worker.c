/* SPDX-License-Identifier: MIT */
/*
 * worker.c - the memory of a thread, used again from file to file
 */
#include "examine/worker.h"

#include <stdlib.h>

#include "os/memory.h"
#include "text/text.h"

unsigned char *buffer_reserve(buffer *b, size_t size)
{
    if (b->size < size) {
        free_aligned(b->data);
        b->data = need_aligned(size);
        b->size = size;
    }
    return b->data;
}

worker *worker_new(void)
{
    worker *w = need(calloc(1, sizeof *w));
    w->tally = need(os_alloc_zeros(ntp_tally_size())); /* most of it is never touched */
    return w;
}

ntp_diff *worker_diff(worker *w)
{
    if (w->diff == NULL) /* what ntp_diff_clear takes has been a diff before, or zeros */
        w->diff = need(os_alloc_zeros(ntp_diff_size()));
    else
        ntp_diff_clear(w->diff);
    return w->diff;
}

void worker_free(worker *w)
{
    os_free_zeros(w->tally, ntp_tally_size());
    free_aligned(w->rows.data);
    free_aligned(w->raw.data);
    free_aligned(w->kept.data);
    free_aligned(w->extra.data);
    free_aligned(w->extra2.data);
    free_aligned(w->extra3.data);
    os_free_zeros(w->diff, ntp_diff_size());
    os_free_zeros(w->histogram, HISTOGRAM_SIZE);
    os_free_zeros(w->orientation, ntp_orientation_size());
    free_aligned(w->band.data);
    free_aligned(w->aside.data);
    free_aligned(w->middle.data);
    free_aligned(w->across.data);
    free_aligned(w->down.data);
    free(w);
}
