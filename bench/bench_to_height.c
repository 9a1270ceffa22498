/* SPDX-License-Identifier: MIT */
/*
 * bench_to_height.c - normals -> heightfield on one thread and two, and row by row
 *
 *     bench_to_height [--size N] [--pairs N]   RGB8 in memory; median of the pairwise ratios
 *     bench_to_height --rows N                 N x N through row callbacks and a temporary file,
 *                                              and the peak memory
 * Lines are: name, A, B, A/B, goal.
 */
#include "libntp.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

enum { PARTS = 2, ALIGNMENT = 64, MIB = 1 << 20, MAX_PAIRS = 99 };

static void fail(const char *what)
{
    fprintf(stderr, "bench_to_height: %s\n", what);
    exit(2);
}

static double now(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double) t.tv_sec + 1e-9 * (double) t.tv_nsec;
}

static void *allocate(size_t bytes)
{
    void *memory = aligned_alloc(ALIGNMENT, (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
    if (memory == NULL)
        fail("out of memory");
    return memory;
}

/* ----------------------------------------------------------------------------- threads */

/* A second thread, which waits for work. */
typedef struct helper {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    void (*task)(void *work, int32_t index);
    void *work;
    int busy, stop;
} helper;

static void *help(void *user)
{
    helper *h = user;
    pthread_mutex_lock(&h->lock);
    for (;;) {
        while (!h->busy && !h->stop)
            pthread_cond_wait(&h->changed, &h->lock);
        if (h->stop)
            break;
        pthread_mutex_unlock(&h->lock);
        h->task(h->work, 1);
        pthread_mutex_lock(&h->lock);
        h->busy = 0;
        pthread_cond_broadcast(&h->changed);
    }
    pthread_mutex_unlock(&h->lock);
    return NULL;
}

static void parallel_for(void *user, int32_t count, void (*task)(void *work, int32_t index),
                         void *work)
{
    helper *h = user;
    pthread_mutex_lock(&h->lock);
    h->task = task;
    h->work = work;
    h->busy = count > 1;
    pthread_cond_broadcast(&h->changed);
    pthread_mutex_unlock(&h->lock);
    task(work, 0);
    pthread_mutex_lock(&h->lock);
    while (h->busy)
        pthread_cond_wait(&h->changed, &h->lock);
    pthread_mutex_unlock(&h->lock);
}

static void start_helper(helper *h)
{
    memset(h, 0, sizeof *h);
    pthread_mutex_init(&h->lock, NULL);
    pthread_cond_init(&h->changed, NULL);
    if (pthread_create(&h->thread, NULL, help, h) != 0)
        fail("no thread");
}

static void stop_helper(helper *h)
{
    pthread_mutex_lock(&h->lock);
    h->stop = 1;
    pthread_cond_broadcast(&h->changed);
    pthread_mutex_unlock(&h->lock);
    pthread_join(h->thread, NULL);
}

/* ----------------------------------------------------------------------------- in memory */

/* Normals of about (0, 0, 1), which change often. */
static void fill(uint8_t *row, int32_t y, int32_t width)
{
    uint32_t state = (uint32_t) y * 2654435761u + 1;
    for (int32_t i = 0; i < width; i++) {
        state = state * 1664525u + 1013904223u;
        row[3 * i] = (uint8_t) (96 + (state >> 26));
        row[3 * i + 1] = (uint8_t) (96 + (state >> 20) % 64);
        row[3 * i + 2] = 240;
    }
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

static double median(double *values, int count)
{
    qsort(values, (size_t) count, sizeof *values, by_value);
    return values[count / 2];
}

static void time_threads(int32_t size, int pairs, ntp_border border, const char *name)
{
    double one[MAX_PAIRS], two[MAX_PAIRS], ratio[MAX_PAIRS], busy_ratio[MAX_PAIRS];
    size_t texels = (size_t) size * (size_t) size;
    uint8_t *normals = allocate(3 * texels);
    float *heights = allocate(sizeof(float) * texels);
    for (int32_t y = 0; y < size; y++)
        fill(normals + 3 * (size_t) size * (size_t) y, y, size);
    ntp_image src = ntp_image_packed(normals, size, size, 3, NTP_TYPE_U8);
    ntp_image dst = ntp_image_packed(heights, size, size, 1, NTP_TYPE_F32);
    ntp_const_image seen = ntp_image_as_const(&src);
    ntp_height_options how = { .kernel = NTP_KERNEL_FORWARD,
                               .border_x = border,
                               .border_y = border,
                               .decode = NTP_DECODE_UNORM,
                               .z = NTP_Z_STORED };
    size_t bytes = ntp_height_scratch_size(&how, size, size, PARTS);
    void *scratch = allocate(bytes);
    helper h;
    start_helper(&h);
    for (int i = -1; i < pairs; i++) { /* the first is for the caches */
        double spent[PARTS], busy[PARTS];
        for (int32_t k = 0; k < PARTS; k++) {
            ntp_hooks hooks = { &h, NULL, parallel_for, 1 + (i % 2 == 0 ? k : 1 - k) };
            double start = now(CLOCK_MONOTONIC), before = now(CLOCK_PROCESS_CPUTIME_ID);
            if (ntp_height_from_normals(&dst, &seen, &how, scratch, bytes, &hooks, NULL) != NTP_OK)
                fail("not solved");
            spent[hooks.parts - 1] = now(CLOCK_MONOTONIC) - start;
            busy[hooks.parts - 1] = now(CLOCK_PROCESS_CPUTIME_ID) - before;
        }
        if (i >= 0) {
            one[i] = 1000 * spent[0];
            two[i] = 1000 * spent[1];
            ratio[i] = spent[1] / spent[0];
            busy_ratio[i] = busy[1] / busy[0];
        }
    }
    stop_helper(&h);
    printf("%-40s %8.1f ms %8.1f ms %7.3f  <= 0.571\n", name, median(two, pairs),
           median(one, pairs), median(ratio, pairs));
    /* Where other programs run, threads wait for a processor; this does not count that. */
    printf("%-40s %22s %9.3f  <= 1.143\n", "the same, time of both processors added", "",
           median(busy_ratio, pairs));
    printf("%-40s %8.2f B  %8.2f B  %7.3f  <= 1\n", "bytes of memory per texel beyond the input",
           (double) (sizeof(float) * texels + bytes) / (double) texels, 5.0,
           (double) (sizeof(float) * texels + bytes) / (double) texels / 5);
    free(normals);
    free(heights);
    free(scratch);
}

/* ---------------------------------------------------------------------------- row by row */

typedef struct rows {
    FILE *file;
    int32_t size;
} rows;

static int32_t read_normals(void *user, void *to, int32_t y, int32_t count)
{
    const rows *r = user;
    for (int32_t i = 0; i < count; i++)
        fill((uint8_t *) to + 3 * (size_t) r->size * (size_t) i, y + i, r->size);
    return 0;
}

static int move_to(const rows *r, int32_t y)
{
    return fseeko(r->file, (off_t) y * r->size * (off_t) sizeof(float), SEEK_SET);
}

static int32_t read_heights(void *user, float *to, int32_t y, int32_t count)
{
    const rows *r = user;
    size_t n = (size_t) r->size * (size_t) count;
    return move_to(r, y) != 0 || fread(to, sizeof *to, n, r->file) != n;
}

static int32_t write_heights(void *user, const float *from, int32_t y, int32_t count)
{
    const rows *r = user;
    size_t n = (size_t) r->size * (size_t) count;
    return move_to(r, y) != 0 || fwrite(from, sizeof *from, n, r->file) != n;
}

static void time_rows(int32_t size)
{
    rows r = { tmpfile(), size };
    if (r.file == NULL)
        fail("no temporary file");
    ntp_height_rows calls = { &r, read_normals, read_heights, write_heights };
    ntp_const_image form = { .width = size, .height = size, .channels = 3, .type = NTP_TYPE_U8 };
    ntp_height_options how = { .kernel = NTP_KERNEL_FORWARD };
    size_t bytes = ntp_height_rows_scratch_size(&form, &how, PARTS);
    void *scratch = allocate(bytes);
    helper h;
    start_helper(&h);
    ntp_hooks hooks = { &h, NULL, parallel_for, PARTS };
    double start = now(CLOCK_MONOTONIC);
    if (ntp_height_from_rows(&form, &calls, &how, scratch, bytes, &hooks, NULL) != NTP_OK)
        fail("not solved; is the disk full?");
    double seconds = now(CLOCK_MONOTONIC) - start;
    stop_helper(&h);
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    double peak = (double) usage.ru_maxrss / 1024;
    printf("%d x %d row by row: %.1f s on two threads, %.2f ns a texel\n", (int) size, (int) size,
           seconds, 1e9 * seconds / size / size);
    printf("%-40s %8.1f MiB %7.1f MiB %6.3f  <= 1\n", "peak memory / limit", peak, 300.0,
           peak / 300);
    fclose(r.file);
    free(scratch);
}

int main(int argc, char **argv)
{
    int32_t size = 4096, whole = 0;
    int pairs = 7;
    for (int i = 1; i + 1 < argc; i += 2) {
        int value = atoi(argv[i + 1]);
        if (value < 1)
            fail("a number is expected");
        if (strcmp(argv[i], "--size") == 0)
            size = value;
        else if (strcmp(argv[i], "--pairs") == 0)
            pairs = value < MAX_PAIRS ? value : MAX_PAIRS;
        else if (strcmp(argv[i], "--rows") == 0)
            whole = value;
        else
            fail("usage: [--size N] [--pairs N] | --rows N");
    }
    if (whole > 0) {
        time_rows(whole);
        return 0;
    }
    time_threads(size, pairs, NTP_BORDER_WRAP, "RGB8 to height, wrap: 2 threads / 1");
    time_threads(size, pairs, NTP_BORDER_CLAMP, "RGB8 to height, free: 2 threads / 1");
    return 0;
}
