// SPDX-License-Identifier: MIT
/*
 * sweep16.c - all 2^32 (r, g) pairs of 16 bit through the public ntp_clean
 *
 * For standard and Z-zero, each pair is cleaned once, cleaned again and validated.  What comes
 * out is judged by inequalities, never by the square roots that made it:
 *   - derived blue: sqrt(S) lies within half a level of it, told by squares;
 *   - r, g on the disc are unchanged; what was over-long lands on a corner of the cell around
 *     its projection, and no other corner on the disc has a greater dot product;
 *   - the second pass changes nothing, and every verdict passes.
 * Two threads; the argument, if any, is a step: every n-th r only, for a quick look.
 */
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "libntp.h"

enum { M = 65535, HALF = 32768, THREADS = 2 };

__extension__ typedef unsigned __int128 wide;

static const char *const names[] = { "standard", "zzero" };

typedef struct sweep {
    pthread_t thread;
    int first, step;
    uint64_t inside, wrong;
    uint16_t (*source)[3], (*once)[3], (*twice)[3];
    uint8_t *mask;
} sweep;

static uint64_t square(int64_t v)
{
    return (uint64_t) (v * v);
}

/* Is b the level nearest to the root of S?  S is never a square, so < and <= are the same. */
static bool is_derived(int64_t x, int64_t y, int64_t b, bool zzero)
{
    int64_t s = (int64_t) M * M - x * x - y * y;
    if (s < 0)
        return false;
    if (zzero) /* 2b - 1 < 2 sqrt(S) < 2b + 1 */
        return (b == 0 || (2 * b - 1) * (2 * b - 1) < 4 * s) && 4 * s < (2 * b + 1) * (2 * b + 1);
    int64_t t = 2 * b - M; /* t - 1 < sqrt(S) < t + 1 */
    return t >= 1 && ((t - 1) * (t - 1) < s || t == 1) && s < (t + 1) * (t + 1);
}

/* sign of k*k*n - M*M*a*a: is level k above the projection M*a/sqrt(n) or below?  Never 0. */
static bool above_projection(int64_t k, int64_t a, uint64_t n)
{
    if (k < 0)
        return false;
    return (wide) square(k) * n > (wide) ((uint64_t) M * M) * square(a);
}

/*
 * (px, py) against the over-long (ax, ay), all without signs: each is one of the two odd numbers
 * around its projection, and of the four pairs so made none on the disc has a greater dot
 * product.
 */
static bool is_best_pull(int64_t px, int64_t py, int64_t ax, int64_t ay)
{
    uint64_t n = square(ax) + square(ay);
    bool x_above = above_projection(px, ax, n), y_above = above_projection(py, ay, n);
    int64_t other_x = x_above ? px - 2 : px + 2, other_y = y_above ? py - 2 : py + 2;
    if (above_projection(other_x, ax, n) == x_above || above_projection(other_y, ay, n) == y_above)
        return false;
    if (ax == ay)
        return px == py && !x_above && !y_above;
    const int64_t corner[3][2] = { { other_x, py }, { px, other_y }, { other_x, other_y } };
    const int64_t dot = px * ax + py * ay;
    for (int i = 0; i < 3; i++) {
        int64_t cx = corner[i][0], cy = corner[i][1];
        if (square(cx) + square(cy) <= (uint64_t) M * M && cx * ax + cy * ay >= dot)
            return false;
    }
    return square(px) + square(py) <= (uint64_t) M * M;
}

static bool is_right(const uint16_t src[3], const uint16_t dst[3], bool zzero, bool *inside)
{
    int64_t x = 2 * src[0] - M, y = 2 * src[1] - M;
    int64_t px = 2 * dst[0] - M, py = 2 * dst[1] - M;
    *inside = square(x) + square(y) <= (uint64_t) M * M;
    if (!is_derived(px, py, dst[2], zzero))
        return false;
    if (*inside)
        return src[0] == dst[0] && src[1] == dst[1];
    return is_best_pull(x < 0 ? -px : px, y < 0 ? -py : py, x < 0 ? -x : x, y < 0 ? -y : y);
}

static ntp_image row_view(void *data, int channels, ntp_type type, ntp_encoding encoding)
{
    ntp_image view = ntp_image_packed(data, HALF, 2, channels, type);
    view.encoding = encoding;
    return view;
}

static void complain(sweep *job, const char *what, bool zzero, int r, int g)
{
    if (job->wrong++ < 5) {
        const uint16_t *s = job->source[g], *d = job->once[g];
        fprintf(stderr, "%s %s: (%d, %d, %d) -> (%d, %d, %d), r %d\n", names[zzero], what, s[0],
                s[1], s[2], d[0], d[1], d[2], r);
    }
}

/* All greens of one red, in two rows of half. */
static void sweep_red(sweep *job, int r, bool zzero)
{
    const ntp_clean_options how = { .touch_unused = NTP_UNUSED_ALL };
    const ntp_encoding encoding = zzero ? NTP_ENCODING_ZZERO : NTP_ENCODING_STANDARD;
    for (int g = 0; g <= M; g++) {
        job->source[g][0] = (uint16_t) r;
        job->source[g][1] = (uint16_t) g;
        job->source[g][2] = (uint16_t) (((uint32_t) g * 40503U + (uint32_t) r * 60493U) >> 3);
    }
    ntp_image source = row_view(job->source, 3, NTP_TYPE_U16, encoding);
    ntp_image once = row_view(job->once, 3, NTP_TYPE_U16, encoding);
    ntp_image twice = row_view(job->twice, 3, NTP_TYPE_U16, encoding);
    ntp_image mask = row_view(job->mask, 1, NTP_TYPE_U8, NTP_ENCODING_HEIGHT);
    ntp_const_image from = ntp_image_as_const(&source), between = ntp_image_as_const(&once);
    ntp_clean_counts counts = { 0, 0 };
    ntp_status status = ntp_clean(&once, &from, &how, NULL, NULL, NULL);
    if (status == NTP_OK)
        status = ntp_clean(&twice, &between, &how, NULL, &counts, NULL);
    if (status == NTP_OK)
        status = ntp_validate(&mask, &between, 0, NULL);
    if (status != NTP_OK) {
        fprintf(stderr, "%s\n", ntp_status_string(status));
        exit(1);
    }
    if (counts.changed != 0 || memcmp(job->once, job->twice, sizeof(uint16_t[3]) * (M + 1)) != 0)
        complain(job, "second pass changes", zzero, r, 0);
    const int want = NTP_FLAG_NEIGHBOR | NTP_FLAG_ROUNDED | NTP_FLAG_EXACT;
    for (int g = 0; g <= M; g++) {
        bool inside;
        if (!is_right(job->source[g], job->once[g], zzero, &inside))
            complain(job, "wrong", zzero, r, g);
        if ((job->mask[g] & ~NTP_FLAG_UNUSED) != want)
            complain(job, "fails a verdict", zzero, r, g);
        job->inside += inside;
    }
}

static void *run(void *argument)
{
    sweep *job = argument;
    job->source = calloc(M + 1, sizeof *job->source);
    job->once = calloc(M + 1, sizeof *job->once);
    job->twice = calloc(M + 1, sizeof *job->twice);
    job->mask = calloc(M + 1, 1);
    if (!job->source || !job->once || !job->twice || !job->mask)
        exit(1);
    for (int r = job->first; r <= M && job->wrong < 100; r += job->step) {
        sweep_red(job, r, false);
        sweep_red(job, r, true);
    }
    free(job->source);
    free(job->once);
    free(job->twice);
    free(job->mask);
    return NULL;
}

int main(int argc, char **argv)
{
    int step = argc > 1 ? (int) strtol(argv[1], NULL, 10) : 1;
    sweep jobs[THREADS];
    memset(jobs, 0, sizeof jobs);
    if (step < 1)
        return 2;
    for (int i = 0; i < THREADS; i++) {
        jobs[i].first = i * step;
        jobs[i].step = THREADS * step;
        if (pthread_create(&jobs[i].thread, NULL, run, &jobs[i]) != 0)
            return 1;
    }
    uint64_t inside = 0, wrong = 0;
    for (int i = 0; i < THREADS; i++) {
        pthread_join(jobs[i].thread, NULL);
        inside += jobs[i].inside;
        wrong += jobs[i].wrong;
    }
    printf("pairs on the disc (both encodings): %llu, wrong: %llu\n", (unsigned long long) inside,
           (unsigned long long) wrong);
    if (step == 1 && inside != 2 * UINT64_C(3373155896)) {
        fprintf(stderr, "expected 2 * 3373155896 pairs on the disc\n");
        return 1;
    }
    return wrong != 0;
}
