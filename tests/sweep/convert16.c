// SPDX-License-Identifier: MIT
/*
 * convert16.c - all 2^32 (r, g) pairs of 16 bit through the public ntp_convert
 *
 * Each pair is converted with its derived blue, with the mirrored one (standard Z) and with one a
 * level above it, from both encodings to both at 8 bit, and to the other one at 16 bit.  What is
 * expected is computed from the definitions, with integers and not as the library does.
 * Two threads; the argument, if any, is a step: every n-th r only, for a quick look.
 */
#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "libntp.h"

enum { M = 65535, HALF = 32768, THREADS = 2, KINDS = 3 };

typedef struct sweep {
    pthread_t thread;
    int first, step;
    uint64_t wrong, texels;
    uint16_t (*source)[3], (*made)[3];
    int (*want)[2]; /* derived blues, standard and Z-zero; -1: too long */
} sweep;

/* Pairs of 8 bit: the levels that they get where they are too long, else their own; and both blues. */
typedef struct cleaned {
    int r, g, blue[2];
} cleaned;

static cleaned narrow[256][256];

static int64_t root_of(int64_t s)
{
    int64_t t = (int64_t) sqrt((double) s);
    while (t * t > s)
        t--;
    while ((t + 1) * (t + 1) <= s)
        t++;
    return t;
}

static int64_t rest_of(int r, int g, int m)
{
    const int64_t x = 2 * r - m, y = 2 * g - m;
    return (int64_t) m * m - x * x - y * y;
}

static int blue_of(int64_t rest, int m, bool zzero)
{
    return (int) (zzero ? (root_of(4 * rest) + 1) / 2 : (root_of(rest) + m + 1) / 2);
}

/* The greatest odd number, from -1 on, that is not above m a / sqrt(n). */
static int64_t below_projection(int64_t m, int64_t a, int64_t n)
{
    int64_t o = -1;
    while ((o + 2) * (o + 2) * n <= m * m * a * a)
        o += 2;
    return o;
}

/* The pair on the disc that is nearest in direction, of the four around the projection. */
static void pull(int *r, int *g, int m)
{
    const int64_t x = 2 * *r - m, y = 2 * *g - m, ax = x < 0 ? -x : x, ay = y < 0 ? -y : y;
    const int64_t o[2] = { below_projection(m, ax, ax * ax + ay * ay),
                           below_projection(m, ay, ax * ax + ay * ay) };
    int64_t best[2] = { o[0], o[1] };
    for (int corner = 1; corner < 4 && ax != ay; corner++) {
        const int64_t p = o[0] + 2 * (corner & 1), q = o[1] + (corner & 2);
        if (p * p + q * q <= (int64_t) m * m && p * ax + q * ay > best[0] * ax + best[1] * ay) {
            best[0] = p;
            best[1] = q;
        }
    }
    *r = (int) (((x < 0 ? -best[0] : best[0]) + m) / 2);
    *g = (int) (((y < 0 ? -best[1] : best[1]) + m) / 2);
}

static void fill_narrow(void)
{
    for (int r = 0; r < 256; r++) {
        for (int g = 0; g < 256; g++) {
            cleaned *c = &narrow[r][g];
            c->r = r;
            c->g = g;
            if (rest_of(r, g, 255) < 0)
                pull(&c->r, &c->g, 255);
            for (int zzero = 0; zzero < 2; zzero++)
                c->blue[zzero] = blue_of(rest_of(c->r, c->g, 255), 255, zzero);
        }
    }
}

static int by_value(int c)
{
    return (c + 128) / 257;
}

/* Blue of a texel that is not exact. */
static int blue_by_value(int b, bool from_zzero, bool to_zzero, bool to_8)
{
    if (from_zzero == to_zzero)
        return to_8 ? by_value(b) : b;
    if (to_zzero) {
        const int z = 2 * b < M ? M - 2 * b : 2 * b - M;
        return to_8 ? by_value(z) : z;
    }
    /* floor((z + 1)/2 M + 1/2) */
    return to_8 ? (b + M + 257) / 514 : (b + M + 1) / 2;
}

/* Whether a texel became what it should; counts pulled ones. */
static bool is_right(const uint16_t s[3], const int d[3], const int want[2], bool from_zzero,
                     bool to_zzero, bool to_8, uint64_t *pulled)
{
    const bool negative = !from_zzero && s[2] < HALF;
    const bool exact = want[from_zzero] >= 0 && want[from_zzero] == (negative ? M - s[2] : s[2]);
    int r = s[0], g = s[1], b = blue_by_value(s[2], from_zzero, to_zzero, to_8);
    if (to_8) {
        r = by_value(r);
        g = by_value(g);
    }
    if (exact) {
        b = want[to_zzero];
        if (to_8) {
            const cleaned *c = &narrow[r][g];
            *pulled += rest_of(r, g, 255) < 0;
            r = c->r;
            g = c->g;
            b = c->blue[to_zzero];
        }
        b = negative && !to_zzero ? (to_8 ? 255 : M) - b : b;
    }
    return d[0] == r && d[1] == g && d[2] == b;
}

/* The texels of one red, from an encoding to another. */
static void check(sweep *job, bool from_zzero, bool to_zzero, bool to_8)
{
    const ntp_convert_options how = { .touch_unused = NTP_UNUSED_ALL };
    const ntp_type type = to_8 ? NTP_TYPE_U8 : NTP_TYPE_U16;
    ntp_image source = ntp_image_packed(job->source, HALF, 2, 3, NTP_TYPE_U16);
    ntp_image made = ntp_image_packed(job->made, HALF, 2, 3, type);
    ntp_convert_counts counts = { 0, 0, 0 };
    uint64_t pulled = 0;
    source.encoding = from_zzero ? NTP_ENCODING_ZZERO : NTP_ENCODING_STANDARD;
    made.encoding = to_zzero ? NTP_ENCODING_ZZERO : NTP_ENCODING_STANDARD;
    const ntp_const_image view = ntp_image_as_const(&source);
    if (ntp_convert(&made, &view, &how, &counts, NULL) != NTP_OK)
        exit(1);
    for (int g = 0; g <= M; g++) {
        const uint8_t *bytes = (const uint8_t *) job->made + 3 * g;
        const uint16_t *s = job->source[g], *words = job->made[g];
        const int d[3] = { to_8 ? bytes[0] : words[0], to_8 ? bytes[1] : words[1],
                           to_8 ? bytes[2] : words[2] };
        if (is_right(s, d, job->want[g], from_zzero, to_zzero, to_8, &pulled) || job->wrong++ > 4)
            continue;
        fprintf(stderr, "(%d, %d, %d) zzero %d -> (%d, %d, %d) zzero %d, 8 bit %d\n", s[0], s[1],
                s[2], from_zzero, d[0], d[1], d[2], to_zzero, to_8);
    }
    job->wrong += counts.pulled != pulled;
    job->texels += M + 1;
}

static void sweep_red(sweep *job, int r)
{
    for (int g = 0; g <= M; g++) {
        const int64_t rest = rest_of(r, g, M);
        for (int zzero = 0; zzero < 2; zzero++)
            job->want[g][zzero] = rest < 0 ? -1 : blue_of(rest, M, zzero);
    }
    for (int from = 0; from < 2; from++) {
        for (int kind = 0; kind < KINDS; kind++) {
            if (from == 1 && kind == 1)
                continue;
            for (int g = 0; g <= M; g++) {
                const int any = (int) (((uint32_t) g * 40503U + (uint32_t) r * 60493U) >> 3 & M);
                const int b = job->want[g][from] < 0 ? any : job->want[g][from];
                job->source[g][0] = (uint16_t) r;
                job->source[g][1] = (uint16_t) g;
                job->source[g][2] = (uint16_t) (kind == 1 ? M - b : kind == 2 && b < M ? b + 1 : b);
            }
            check(job, from, from, true);
            check(job, from, !from, true);
            check(job, from, !from, false);
        }
    }
}

static void *run(void *argument)
{
    sweep *job = argument;
    job->source = calloc(M + 1, sizeof *job->source);
    job->made = calloc(M + 1, sizeof *job->made);
    job->want = calloc(M + 1, sizeof *job->want);
    if (!job->source || !job->made || !job->want)
        exit(1);
    for (int r = job->first; r <= M && job->wrong < 100; r += job->step)
        sweep_red(job, r);
    free(job->source);
    free(job->made);
    free(job->want);
    return NULL;
}

int main(int argc, char **argv)
{
    const int step = argc > 1 ? (int) strtol(argv[1], NULL, 10) : 1;
    sweep jobs[THREADS];
    uint64_t wrong = 0, texels = 0;
    memset(jobs, 0, sizeof jobs);
    if (step < 1)
        return 2;
    fill_narrow();
    for (int i = 0; i < THREADS; i++) {
        jobs[i].first = i * step;
        jobs[i].step = THREADS * step;
        if (pthread_create(&jobs[i].thread, NULL, run, &jobs[i]) != 0)
            return 1;
    }
    for (int i = 0; i < THREADS; i++) {
        pthread_join(jobs[i].thread, NULL);
        wrong += jobs[i].wrong;
        texels += jobs[i].texels;
    }
    printf("texels: %llu, wrong: %llu\n", (unsigned long long) texels, (unsigned long long) wrong);
    return wrong != 0;
}
