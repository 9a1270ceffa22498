/* SPDX-License-Identifier: MIT */
/*
 * jobs.c - a queue of inputs, worker threads, and one thread that prints
 *
 * Workers take the next input and leave its result in a slot of a ring.  The main thread takes
 * results out in order.  The ring limits how far workers get ahead of a slow file.
 */
#include "run/jobs.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "os/console.h"
#include "os/files.h"
#include "os/memory.h"
#include "os/threads.h"

enum {
    AHEAD = 256,              /* results that may wait to be printed */
    POLL_MS = 100,            /* how often the main thread looks at signals and progress */
    FIRST_PROGRESS_MS = 1000, /* a shorter run needs no bar */
    MAX_WORKERS = 256,
    SMALL_FILE = 2 << 20 /* bytes */
};

typedef struct queue {
    const batch *b;
    os_lock lock;
    os_condition changed;
    size_t next;      /* first input that no worker took */
    size_t delivered; /* inputs whose result was printed */
    bool stop;
    struct {
        result r;
        bool done;
    } slots[AHEAD];
} queue;

bool progress_wanted(const options *o)
{
    return !option_given(o, OPT_NO_PROGRESS) && os_error_is_terminal();
}

typedef struct seat {
    queue *q;
    worker *w;
    os_thread thread;
} seat;

static void *work_loop(void *context)
{
    seat *s = context;
    queue *q = s->q;
    const batch *b = q->b;
    os_lock_take(&q->lock);
    for (;;) {
        while (!q->stop && q->next < b->inputs->count && q->next >= q->delivered + AHEAD)
            os_condition_wait(&q->changed, &q->lock);
        if (q->stop || interrupted_by != 0 || q->next >= b->inputs->count)
            break;
        const size_t index = q->next++;
        os_lock_release(&q->lock);
        result r = { 0 };
        b->work(b->context, s->w, &b->inputs->at[index], &r);
        atomic_store_explicit(&s->w->permille, 0, memory_order_relaxed);
        atomic_store_explicit(&s->w->left, 0, memory_order_relaxed);
        os_lock_take(&q->lock);
        q->slots[index % AHEAD].r = r;
        q->slots[index % AHEAD].done = true;
        os_condition_wake_all(&q->changed);
    }
    os_condition_wake_all(&q->changed);
    os_lock_release(&q->lock);
    return NULL;
}

static int threads_allowed(const batch *b)
{
    return b->jobs > 0 ? b->jobs : os_processors();
}

static int worker_count(const batch *b)
{
    size_t count = (size_t) threads_allowed(b);
    if (count > b->inputs->count)
        count = b->inputs->count;
    return count > MAX_WORKERS ? MAX_WORKERS : (int) count;
}

static void print_result(const batch *b, const input *in, result *r)
{
    if (b->deliver != NULL)
        b->deliver(b->context, in, r);
    if (r->err.size > 0) {
        progress_clear();
        output_flush();
        fwrite(r->err.data, 1, r->err.size, stderr);
        fflush(stderr);
    }
    if (r->out.size > 0)
        progress_clear();
    output_text(&r->out);
    text_free(&r->out);
    text_free(&r->err);
}

static void show_progress(const queue *q, const seat *seats, int workers, int64_t started)
{
    if (!q->b->show_progress || os_now_ms() - started < FIRST_PROGRESS_MS)
        return;
    double done = (double) q->delivered;
    for (size_t i = q->delivered; i < q->next; i++)
        done += q->slots[i % AHEAD].done;
    uint64_t left = 0;
    for (int i = 0; i < workers; i++) {
        done += atomic_load_explicit(&seats[i].w->permille, memory_order_relaxed) / 1000.0;
        left += atomic_load_explicit(&seats[i].w->left, memory_order_relaxed);
    }
    progress_draw(done / (double) q->b->inputs->count, q->delivered, q->b->inputs->count, left);
}

/* Prints results in order, until all are printed or the work is stopped. */
static unsigned deliver_all(queue *q, const seat *seats, int workers)
{
    const int64_t started = os_now_ms();
    unsigned ran = 0;
    os_lock_take(&q->lock);
    while (q->delivered < q->b->inputs->count) {
        const size_t index = q->delivered;
        while (!q->slots[index % AHEAD].done && interrupted_by == 0) {
            os_condition_wait_ms(&q->changed, &q->lock, POLL_MS);
            show_progress(q, seats, workers, started);
        }
        if (!q->slots[index % AHEAD].done)
            break;
        result r = q->slots[index % AHEAD].r;
        q->slots[index % AHEAD].done = false;
        os_lock_release(&q->lock);
        ran |= r.ran;
        print_result(q->b, &q->b->inputs->at[index], &r);
        os_lock_take(&q->lock);
        q->delivered++;
        os_condition_wake_all(&q->changed);
        if (q->b->reads_only && (output_closed() || output_failed()))
            break;
    }
    q->stop = true;
    os_condition_wake_all(&q->changed);
    os_lock_release(&q->lock);
    return ran;
}

/* Prints the results that were ready when the work was stopped. */
static unsigned drop_rest(queue *q)
{
    unsigned ran = 0;
    for (size_t i = q->delivered; i < q->next; i++) {
        result *r = &q->slots[i % AHEAD].r;
        if (!q->slots[i % AHEAD].done)
            continue;
        ran |= r->ran;
        print_result(q->b, &q->b->inputs->at[i], r);
    }
    return ran;
}

static unsigned finish(unsigned ran)
{
    progress_clear();
    output_flush();
    if (interrupted_by != 0)
        ran |= RAN_INTERRUPTED;
    if (output_failed())
        ran |= RAN_FAILED;
    return ran;
}

/* Of a small file most time goes into pages that are used for the first time.  A larger one gains little by large
 * pages, of which parts may stay unused. */
static bool is_small(const input *in)
{
    os_file file;
    return os_look(in->path, &file) && file.kind == OS_REGULAR && file.size <= SMALL_FILE;
}

/* One input without a progress bar: starting a thread would cost a tenth of the time of a small file.  Its
 * memory is not used again.  Who only reads a file takes less of it than a large page. */
static unsigned run_alone(const batch *b)
{
    const bool large = !b->reads_only && is_small(&b->inputs->at[0]);
    void *const aside = large ? os_large_pages_for_malloc() : NULL;
    worker *w = worker_new();
    w->threads = threads_allowed(b);
    result r = { 0 };
    b->work(b->context, w, &b->inputs->at[0], &r);
    const unsigned ran = r.ran;
    print_result(b, &b->inputs->at[0], &r);
    worker_free(w);
    free(aside);
    return finish(ran);
}

unsigned batch_run(const batch *b)
{
    if (b->inputs->count == 0)
        return 0;
    if (b->inputs->count == 1 && !b->show_progress)
        return run_alone(b);
    queue *q = need(calloc(1, sizeof *q));
    q->b = b;
    os_lock_init(&q->lock);
    os_condition_init(&q->changed);
    const int wanted = worker_count(b);
    int workers = wanted;
    seat *seats = need(calloc((size_t) workers, sizeof *seats));
    for (int i = 0; i < workers; i++) {
        seats[i] = (seat) { .q = q, .w = worker_new() };
        seats[i].w->threads = threads_allowed(b) / wanted;
        const int error = os_thread_start(&seats[i].thread, work_loop, &seats[i]);
        if (error == 0)
            continue;
        worker_free(seats[i].w);
        workers = i; /* fewer threads do the same work; this ends the loop */
        if (i == 0)
            complain("cannot start a thread: %s", strerror(error));
    }
    unsigned ran = workers > 0 ? deliver_all(q, seats, workers) : RAN_FAILED;
    for (int i = 0; i < workers; i++) {
        os_thread_join(seats[i].thread);
        worker_free(seats[i].w);
    }
    ran |= drop_rest(q);
    os_condition_destroy(&q->changed);
    os_lock_destroy(&q->lock);
    free(seats);
    free(q);
    return finish(ran);
}
