/* SPDX-License-Identifier: MIT */
/*
 * bench_kernels - the core in memory, each operation beside a memcpy of the same image
 *
 * usage: bench_kernels [--isa base|avx2] [--side N] [--pairs N] [--only TEXT]
 *
 * An operation and its reference alternate in one run, and the median of the pairwise ratios is
 * compared with the goal: on a shared machine times vary by half, ratios hardly.  Times are
 * processor times, which exclude other programs.  One thread; all buffers belong to the caller and
 * were touched before.  Content: fractal rock, a brick wall, and noise, which is the worst for
 * branches and tables and has no goals.
 */
#include "texel/kernels.h"
#include "libntp.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SIDE = 4096, PAIRS = 9, MAX_PAIRS = 99, OCTAVES = 9 };

typedef struct bench {
    int32_t side, pairs;
    const char *only;
    size_t bytes8, bytes16;
    float *height;
    uint8_t *src8, *dst8;
    uint16_t *src16, *dst16;
    ntp_clean_plan *plan;
    ntp_tally *tally;
    ntp_stats stats;
    uint64_t valid; /* the result of the reference's test, so that it is not optimized away */
    bool avx2;
    int over;
} bench;

/* ------------------------------------------------------------------- instruction set by option */

/* The library is linked from an archive: its cpu.c is left out because its function is here. */
static int allowed = NTP__CPU_ALL;

bool ntp__cpu_has_avx2(int mask)
{
#ifdef NTP_HAVE_AVX2
    return (mask & allowed & NTP__CPU_AVX2) != 0 && __builtin_cpu_supports("avx2") &&
           __builtin_cpu_supports("fma");
#else
    (void) mask;
    return false;
#endif
}

/* ------------------------------------------------------------------------------------ textures */

static uint32_t hash(uint32_t x, uint32_t y, uint32_t seed)
{
    uint32_t h = x * 0x9e3779b1u ^ y * 0x85ebca77u ^ seed * 0xc2b2ae3du;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return h ^ h >> 15;
}

static float corner(uint32_t x, uint32_t y, uint32_t seed)
{
    return (float) (hash(x, y, seed) >> 8) / 16777216.0f - 0.5f;
}

/* Adds smoothly interpolated noise with `cells` cells on each side; it tiles. */
static void add_octave(float *height, int32_t side, int32_t cells, float amplitude)
{
    uint32_t mask = (uint32_t) cells - 1, seed = (uint32_t) cells;
    float step = (float) cells / (float) side;
    for (int32_t j = 0; j < side; j++) {
        float y = (float) j * step;
        uint32_t y0 = (uint32_t) y;
        float v = y - (float) y0, sv = v * v * (3 - 2 * v);
        uint32_t cell = UINT32_MAX;
        float a = 0, b = 0, c = 0, d = 0;
        for (int32_t i = 0; i < side; i++) {
            float x = (float) i * step;
            uint32_t x0 = (uint32_t) x;
            if (x0 != cell) {
                cell = x0;
                a = corner(x0, y0, seed);
                b = corner((x0 + 1) & mask, y0, seed);
                c = corner(x0, (y0 + 1) & mask, seed);
                d = corner((x0 + 1) & mask, (y0 + 1) & mask, seed);
            }
            float u = x - (float) x0, su = u * u * (3 - 2 * u);
            float top = a + (b - a) * su, bottom = c + (d - c) * su;
            height[(size_t) j * (size_t) side + (size_t) i] +=
                amplitude * (top + (bottom - top) * sv);
        }
    }
}

static void make_rock(float *height, int32_t side, float amplitude)
{
    int32_t cells = 8;
    for (int32_t k = 0; k < OCTAVES && cells <= side; k++) {
        add_octave(height, side, cells, amplitude);
        cells *= 2;
        amplitude *= 0.52f;
    }
}

/* 8 x 16 bricks with rounded edges, every other row shifted by half a brick. */
static void make_bricks(float *height, int32_t side)
{
    for (int32_t j = 0; j < side; j++) {
        float v = (float) j * 16.0f / (float) side;
        int32_t row = (int32_t) v;
        v -= (float) row;
        for (int32_t i = 0; i < side; i++) {
            float u = (float) i * 8.0f / (float) side + (row % 2 ? 0.5f : 0.0f);
            u -= (float) (int32_t) u;
            float eu = 2 * (u < 0.5f ? u : 1 - u), ev = v < 0.5f ? v : 1 - v;
            float t = ((eu < ev ? eu : ev) - 0.04f) / 0.08f;
            t = t < 0 ? 0 : t > 1 ? 1 : t;
            height[(size_t) j * (size_t) side + (size_t) i] += 0.01f * t * t * (3 - 2 * t);
        }
    }
}

static void expect(ntp_status status)
{
    if (status != NTP_OK) {
        fprintf(stderr, "bench_kernels: %s\n", ntp_status_string(status));
        exit(1);
    }
}

static ntp_image image8(uint8_t *data, const bench *b)
{
    return ntp_image_packed(data, b->side, b->side, 3, NTP_TYPE_U8);
}

static ntp_image image16(uint16_t *data, const bench *b)
{
    return ntp_image_packed(data, b->side, b->side, 3, NTP_TYPE_U16);
}

/* Normals whose channels were rounded independently, as most bakers do. */
static void make_normals(bench *b, double scale)
{
    ntp_normals_options how = { .scale = scale, .blue = NTP_BLUE_NEAREST };
    ntp_image height = ntp_image_packed(b->height, b->side, b->side, 1, NTP_TYPE_F32);
    ntp_const_image src = ntp_image_as_const(&height);
    ntp_image rgb8 = image8(b->src8, b), rgb16 = image16(b->src16, b);
    expect(ntp_normals_from_height(&rgb8, &src, &how, NULL, NULL));
    expect(ntp_normals_from_height(&rgb16, &src, &how, NULL, NULL));
}

static void make_content(bench *b, const char *content)
{
    size_t texels = (size_t) b->side * (size_t) b->side;
    memset(b->height, 0, texels * sizeof *b->height);
    if (strcmp(content, "noise") == 0) {
        for (size_t i = 0; i < 3 * texels; i++) {
            uint32_t h = hash((uint32_t) i, (uint32_t) (i >> 32), 1);
            b->src8[i] = (uint8_t) (h >> 24);
            b->src16[i] = (uint16_t) (h >> 8);
        }
        return;
    }
    bool rock = strcmp(content, "rock") == 0;
    make_rock(b->height, b->side, rock ? 1.0f : 0.004f);
    if (!rock)
        make_bricks(b->height, b->side);
    /* Heights in texels: x and y of 0.15 to 0.25 rms, as in real textures, whatever the side. */
    make_normals(b, rock ? b->side / 64.0 : b->side / 2.0);
}

/* ---------------------------------------------------------------------------------- operations */

static void copy8(bench *b)
{
    memcpy(b->dst8, b->src8, b->bytes8);
}

static void copy16(bench *b)
{
    memcpy(b->dst16, b->src16, b->bytes16);
}

static void clean8(bench *b)
{
    ntp_image dst = image8(b->dst8, b), src = image8(b->src8, b);
    ntp_const_image from = ntp_image_as_const(&src);
    expect(ntp_clean(&dst, &from, NULL, b->plan, NULL, NULL));
}

static void clean8_in_place(bench *b)
{
    ntp_image dst = image8(b->dst8, b);
    ntp_const_image from = ntp_image_as_const(&dst);
    expect(ntp_clean(&dst, &from, NULL, b->plan, NULL, NULL));
}

static void clean16(bench *b)
{
    ntp_image dst = image16(b->dst16, b), src = image16(b->src16, b);
    ntp_const_image from = ntp_image_as_const(&src);
    expect(ntp_clean(&dst, &from, NULL, NULL, NULL, NULL));
}

static void measure(bench *b, const ntp_image *image)
{
    ntp_const_image from = ntp_image_as_const(image);
    expect(ntp_tally_clear(b->tally));
    expect(ntp_tally_add(b->tally, &from, 0, NULL));
    expect(ntp_tally_summarize(&b->stats, b->tally, NTP_ENCODING_STANDARD));
}

static void measure8(bench *b)
{
    ntp_image src = image8(b->src8, b);
    measure(b, &src);
}

static void measure16(bench *b)
{
    ntp_image src = image16(b->src16, b);
    measure(b, &src);
}

static void validate8(bench *b)
{
    ntp_image src = image8(b->src8, b);
    ntp_image mask = ntp_image_packed(b->dst8, b->side, b->side, 1, NTP_TYPE_U8);
    ntp_const_image from = ntp_image_as_const(&src);
    expect(ntp_validate(&mask, &from, 0, NULL));
}

static void narrow(bench *b)
{
    ntp_image dst = image8(b->dst8, b), src = image16(b->src16, b);
    ntp_const_image from = ntp_image_as_const(&src);
    expect(ntp_convert(&dst, &from, NULL, NULL, NULL));
}

/* The reference program's test of a texel: the shortest and the longest of 27 neighbors, with a
 * square root for each, in floats.  (It needs as many again for Z-zero; they are left out here.) */
static bool has_unit_neighbor(const uint8_t *texel)
{
    float square[3][3], shortest = 9.0f, longest = 0.0f;
    for (int c = 0; c < 3; c++) {
        for (int step = -1; step <= 1; step++) {
            float v = (float) (texel[c] + step) / 255.0f * 2.0f - 1.0f;
            square[c][step + 1] = v * v;
        }
    }
    if (sqrtf(square[0][1] + square[1][1]) > 1.00774f)
        return false;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            for (int k = 0; k < 3; k++) {
                float length = sqrtf(square[0][i] + square[1][j] + square[2][k]);
                shortest = length < shortest ? length : shortest;
                longest = length > longest ? length : longest;
            }
        }
    }
    return shortest <= 1.0f && longest >= 1.0f;
}

static void reference8(bench *b)
{
    uint64_t valid = 0;
    for (size_t i = 0; i < b->bytes8; i += 3)
        valid += has_unit_neighbor(b->src8 + i);
    b->valid = valid;
}

/* --------------------------------------------------------------------------------------- table */

typedef void operation(bench *b);

static double spent(operation *run, bench *b)
{
    struct timespec from, to;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &from);
    run(b);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &to);
    return (double) (to.tv_sec - from.tv_sec) * 1e3 + (double) (to.tv_nsec - from.tv_nsec) / 1e6;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

static double median(double *values, int n)
{
    qsort(values, (size_t) n, sizeof *values, by_value);
    return n % 2 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

/* The definition of the ratio of times, and on which side of the goal it has to be. */
typedef enum sense {
    SPEED,
    COST
} sense; /* yardstick / operation >= goal; operation / it <= goal */

/* One line; goal 0: none. */
static void row(bench *b, const char *content, const char *name, operation *run, operation *beside,
                sense kind, double goal)
{
    double a[MAX_PAIRS], y[MAX_PAIRS], ratio[MAX_PAIRS];
    char label[80], limit[16] = "";
    snprintf(label, sizeof label, "%s, %s", name, content);
    if (strstr(label, b->only) == NULL)
        return;
    spent(run, b);
    spent(beside, b);
    for (int i = 0; i < b->pairs; i++) {
        if (i % 2 == 0)
            a[i] = spent(run, b);
        y[i] = spent(beside, b);
        if (i % 2 == 1)
            a[i] = spent(run, b);
        ratio[i] = kind == SPEED ? y[i] / a[i] : a[i] / y[i];
    }
    double r = median(ratio, b->pairs);
    if (strcmp(content, "noise") == 0)
        goal = 0;
    bool met = goal == 0 || (kind == SPEED ? r >= goal : r <= goal);
    b->over += !met;
    if (goal > 0)
        snprintf(limit, sizeof limit, "%s %.3g", kind == SPEED ? ">=" : "<=", goal);
    printf("%-44s%8.1f ms%8.1f ms%8.2f  %-8s%s\n", label, median(a, b->pairs), median(y, b->pairs),
           r, limit, met ? "" : "missed");
    fflush(stdout);
}

static void rows(bench *b, const char *content)
{
    make_content(b, content);
    copy8(b);
    row(b, content, "clean RGB8 / memcpy, speed", clean8, copy8, SPEED, 0.55);
    row(b, content, "clean RGB8 in place / memcpy, speed", clean8_in_place, copy8, SPEED, 0.4);
    row(b, content, "clean RGB16 / memcpy, speed", clean16, copy16, SPEED, b->avx2 ? 0.55 : 0.28);
    row(b, content, "measure RGB8 / memcpy, time", measure8, copy8, COST, 6);
    row(b, content, "measure RGB8 / 27 roots, speed", measure8, reference8, SPEED, 12);
    row(b, content, "measure RGB16 / memcpy, time", measure16, copy16, COST, 0);
    row(b, content, "validate RGB8 / memcpy, time", validate8, copy8, COST, 0);
    row(b, content, "convert RGB16 to 8 / memcpy, time", narrow, copy16, COST, 0);
}

static void *buffer(size_t size)
{
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
    if (memory == NULL) {
        fputs("bench_kernels: out of memory\n", stderr);
        exit(1);
    }
    return memset(memory, 1, size);
}

static void set_up(bench *b)
{
    size_t texels = (size_t) b->side * (size_t) b->side;
    b->bytes8 = 3 * texels;
    b->bytes16 = 6 * texels;
    b->height = buffer(texels * sizeof *b->height);
    b->src8 = buffer(b->bytes8);
    b->dst8 = buffer(b->bytes8);
    b->src16 = buffer(b->bytes16);
    b->dst16 = buffer(b->bytes16);
    size_t size = ntp_clean_plan_size();
    expect(ntp_clean_plan_init(&b->plan, buffer(size), size, NTP_ENCODING_STANDARD, NULL));
    b->tally = memset(buffer(ntp_tally_size()), 0, ntp_tally_size());
}

static int usage(void)
{
    fputs("usage: bench_kernels [--isa base|avx2] [--side N] [--pairs N] [--only TEXT]\n", stderr);
    return 2;
}

int main(int argc, char **argv)
{
    static const char *const CONTENTS[] = { "rock", "bricks", "noise" };
    static bench b = { .side = SIDE, .pairs = PAIRS, .only = "" };
    for (int i = 1; i < argc; i += 2) {
        const char *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (value == NULL)
            return usage();
        if (strcmp(argv[i], "--isa") == 0)
            allowed = strcmp(value, "base") == 0 ? 0 : NTP__CPU_ALL;
        else if (strcmp(argv[i], "--side") == 0)
            b.side = atoi(value);
        else if (strcmp(argv[i], "--pairs") == 0)
            b.pairs = atoi(value);
        else if (strcmp(argv[i], "--only") == 0)
            b.only = value;
        else
            return usage();
    }
    if (b.side < 16 || b.side > 16384 || b.pairs < 1 || b.pairs > MAX_PAIRS)
        return usage();
    const char *name = ntp__kernels(NTP__CPU_ALL)->name;
    b.avx2 = strcmp(name, "avx2") == 0;
    set_up(&b);
    printf("%d x %d, kernels: %s, %d pairs\n", (int) b.side, (int) b.side, name, b.pairs);
    printf("%-44s%11s%11s%8s  %s\n", "", "it", "beside", "ratio", "goal");
    for (size_t i = 0; i < sizeof CONTENTS / sizeof CONTENTS[0]; i++)
        rows(&b, CONTENTS[i]);
    if (b.over > 0)
        printf("goals missed: %d\n", b.over);
    return 0;
}
