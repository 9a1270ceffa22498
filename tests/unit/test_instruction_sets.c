/* SPDX-License-Identifier: MIT */
/*
 * test_instruction_sets.c - heights of normals are the same bytes with and without AVX2, and for 1
 * and 2 threads; and so is what is measured of texels of any kind, and which kernel made them
 *
 * The function that asks the processor is defined here, so that of the library is left out.
 */
#include "base/cpu.h"
#include "guarded.h"
#include "libntp.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 75, HEIGHT = 60, TEXELS = WIDTH * HEIGHT, SKIPPED = 77 };

static bool allowed; /* AVX2 */
static bool used;    /* by the library */

bool ntp__cpu_has_avx2(int mask)
{
#ifdef __x86_64__
    used = allowed && (mask & NTP__CPU_AVX2) != 0 && __builtin_cpu_supports("avx2") &&
           __builtin_cpu_supports("fma");
#else
    (void) mask;
#endif
    return used;
}

typedef struct solution {
    float heights[TEXELS];
    ntp_height_result result;
} solution;

static void in_turn(void *user, int32_t count, void (*task)(void *work, int32_t index), void *work)
{
    (void) user;
    for (int32_t i = count - 1; i >= 0; i--)
        task(work, i);
}

static void solve(solution *s, const ntp_const_image *src, const ntp_height_options *how, bool avx2,
                  int32_t parts)
{
    const ntp_hooks hooks = { .parallel_for = in_turn, .parts = parts };
    const ntp_image dst = ntp_image_packed(s->heights, WIDTH, HEIGHT, 1, NTP_TYPE_F32);
    allowed = avx2;
    size_t size = ntp_height_scratch_size(how, WIDTH, HEIGHT, parts);
    void *scratch = system_aligned(size);
    CHECK(scratch != NULL);
    memset(s, 0, sizeof *s);
    CHECK(ntp_height_from_normals(&dst, src, how, scratch, size, &hooks, &s->result) == NTP_OK);
    system_aligned_free(scratch);
}

static void compare(const ntp_const_image *src, const ntp_height_options *how)
{
    static solution plain, other;
    const void *bytes = plain.heights, *others = other.heights;
    solve(&plain, src, how, false, 1);
    for (int i = 1; i < 4; i++) {
        used = false;
        solve(&other, src, how, (i & 1) != 0, 1 + i / 2);
        CHECK(used == ((i & 1) != 0));
        CHECK(memcmp(bytes, others, sizeof plain.heights) == 0);
        CHECK(plain.result.residual >= 0 && plain.result.residual == other.result.residual);
        CHECK(plain.result.rounds == other.result.rounds);
        CHECK(plain.result.refine_left == other.result.refine_left);
    }
}

/* Normals of smooth noise; the seed is fixed. */
static void make_normals(void *texels, ntp_type type)
{
    static float noise[TEXELS], heights[TEXELS];
    ntp_normals_options how = { .scale = 3 };
    const ntp_blur_options blur = { .sigma = 2, .weight = 1 };
    uint32_t state = 1;
    for (int i = 0; i < TEXELS; i++) {
        state = state * 1664525u + 1013904223u;
        noise[i] = (float) (state >> 8) / (1 << 20);
    }
    const ntp_image rough = ntp_image_packed(noise, WIDTH, HEIGHT, 1, NTP_TYPE_F32);
    const ntp_image smooth = ntp_image_packed(heights, WIDTH, HEIGHT, 1, NTP_TYPE_F32);
    const ntp_const_image from = ntp_image_as_const(&rough), seen = ntp_image_as_const(&smooth);
    size_t size = ntp_height_blur_scratch_size(&blur, WIDTH);
    void *scratch = system_aligned(size);
    CHECK(scratch != NULL);
    CHECK(ntp_height_blur(&smooth, &from, &blur, scratch, size) == NTP_OK);
    system_aligned_free(scratch);
    const ntp_image normals = ntp_image_packed(texels, WIDTH, HEIGHT, 3, type);
    CHECK(ntp_normals_from_height(&normals, &seen, &how, NULL, NULL) == NTP_OK);
}

/* What is asked of a tally, and the direction of green. */
typedef struct measured {
    ntp_stats stats;
    ntp_classification class;
    uint64_t lengths[256], levels_off[65536];
    ntp_harm harm;
} measured;

static void measure(measured *m, ntp_orientation *green, const ntp_const_image *src, bool avx2)
{
    ntp_tally *const tally = calloc(1, ntp_tally_size());
    CHECK(tally != NULL);
    allowed = avx2;
    used = false;
    memset(m, 0, sizeof *m);
    memset(green, 0, ntp_orientation_size());
    CHECK(ntp_orientation_add(green, src, 0, 1, NULL) == NTP_OK);
    CHECK(used == avx2);
    CHECK(ntp_tally_add(tally, src, 0, NULL) == NTP_OK);
    CHECK(ntp_tally_summarize(&m->stats, tally, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(ntp_tally_lengths(m->lengths, tally, NTP_ENCODING_ZZERO) == NTP_OK);
    CHECK(ntp_tally_levels_off(m->levels_off, 65536, tally, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(ntp_tally_harm(&m->harm, tally, NTP_ENCODING_STANDARD, NTP_HARM_ALL, 1) == NTP_OK);
    CHECK(ntp_classify(&m->class, tally) == NTP_OK);
    free(tally);
}

/* Runs of colors: any, gray, black, white, and close to flat; a few of them transparent. */
static void put_runs(void *texels, int32_t channels, ntp_type type, uint64_t *seed)
{
    const int32_t max = type == NTP_TYPE_U8 ? 255 : 65535;
    int32_t c[4] = { 0 }, left = 0;
    for (int32_t i = 0; i < TEXELS; i++) {
        if (left-- == 0) {
            const uint32_t bits = (uint32_t) random_bits(seed);
            left = bits & 7 ? (int32_t) (bits >> 8 & 3) : (int32_t) (bits >> 8 & 511);
            for (int32_t k = 0; k < 3; k++) {
                const int32_t any = (int32_t) random_level(seed, (uint32_t) max);
                c[k] = bits & 16 ? any : (k == 2 ? max : max / 2) - any / 16;
            }
            if ((bits >> 20 & 7) < 3) /* black, white, gray */
                c[0] = c[1] = c[2] = (bits >> 20 & 7) == 2 ? c[0] : bits & 1 << 20 ? max : 0;
            c[3] = bits >> 28 == 0 ? 0 : bits >> 28 == 1 ? max / 3 : max;
        }
        for (int32_t k = 0; k < channels; k++) {
            if (type == NTP_TYPE_U8)
                ((uint8_t *) texels)[channels * i + k] = (uint8_t) c[k];
            else
                ((uint16_t *) texels)[channels * i + k] = (uint16_t) c[k];
        }
    }
}

/* Of structures that were all zero before they were filled. */
static bool same_bytes(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

static void compare_measures(const ntp_const_image *src)
{
    static measured plain, other;
    ntp_orientation *const green = malloc(ntp_orientation_size());
    ntp_orientation *const others = malloc(ntp_orientation_size());
    CHECK(green != NULL && others != NULL);
    measure(&plain, green, src, false);
    measure(&other, others, src, true);
    CHECK(same_bytes(&plain, &other, sizeof plain));
    CHECK(same_bytes(green, others, ntp_orientation_size()));
    free(green);
    free(others);
}

/* Which kernel fits how well, of pictures of many widths: no lane is left over or counted twice. */
static void compare_kernels(const ntp_const_image *src, uint64_t least_points)
{
    ntp_const_image part = *src;
    uint64_t points = 0;
    for (part.width = WIDTH; part.width > WIDTH - 20; part.width--) {
        ntp_kernel_fit plain, other;
        memset(&plain, 0, sizeof plain);
        memset(&other, 0, sizeof other);
        allowed = false;
        CHECK(ntp_find_kernel(&plain, &part, 0) == NTP_OK);
        allowed = true;
        CHECK(ntp_find_kernel(&other, &part, 0) == NTP_OK);
        CHECK(same_bytes(&plain, &other, sizeof plain));
        points += plain.points;
    }
    CHECK(points >= least_points);
}

/* 16-bit normals that are flat but for a level or two, of which most slopes become 0. */
static void put_nearly_flat(uint16_t *texels, uint64_t *seed)
{
    for (int32_t i = 0; i < 3 * TEXELS; i++)
        texels[i] = i % 3 == 2 ? 65535 : (uint16_t) (32766 + random_level(seed, 3));
}

int main(void)
{
    static const ntp_type types[] = { NTP_TYPE_U8, NTP_TYPE_U16 };
    static const ntp_kernel kernels[] = { NTP_KERNEL_FORWARD, NTP_KERNEL_CENTRAL,
                                          NTP_KERNEL_SOBEL3 };
    static const ntp_border borders[] = { NTP_BORDER_WRAP, NTP_BORDER_CLAMP };
    static uint16_t texels[4 * TEXELS];
    uint64_t seed = 4711;
    allowed = true;
    if (!ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    for (int t = 0; t < 2; t++) {
        allowed = false;
        make_normals(texels, types[t]);
        ntp_image view = ntp_image_packed(texels, WIDTH, HEIGHT, 3, types[t]);
        const ntp_const_image src = ntp_image_as_const(&view);
        compare_measures(&src);
        compare_kernels(&src, 20 * 1000);
        for (int k = 0; k < 3; k++) {
            for (int b = 0; b < 2; b++) {
                ntp_height_options how = { .kernel = kernels[k],
                                           .border_x = borders[b],
                                           .border_y = borders[b],
                                           .residual_scope = NTP_RESIDUAL_ALL };
                compare(&src, &how);
                how.refine = 5;
                compare(&src, &how);
                how.refine = 0;
                how.method = NTP_HEIGHT_WEIGHTED;
                compare(&src, &how);
            }
        }
        for (int32_t round = 0; round < 40; round++) {
            view = ntp_image_packed(texels, WIDTH, HEIGHT, 3 + round % 2, types[t]);
            put_runs(texels, view.channels, types[t], &seed);
            const ntp_const_image runs = ntp_image_as_const(&view);
            compare_measures(&runs);
            compare_kernels(&runs, 0);
        }
    }
    put_nearly_flat(texels, &seed);
    ntp_image view = ntp_image_packed(texels, WIDTH, HEIGHT, 3, NTP_TYPE_U16);
    const ntp_const_image flat = ntp_image_as_const(&view);
    compare_measures(&flat);
    /* noise, and then normals; rows of any width */
    allowed = false;
    make_normals(texels, NTP_TYPE_U16);
    for (int32_t i = 0; i < 2 * TEXELS; i++)
        texels[i] = (uint16_t) random_level(&seed, 65535);
    for (int32_t width = 9; width < 400; width += width / 3) {
        view = ntp_image_packed(texels, width, TEXELS / width, 3, NTP_TYPE_U16);
        const ntp_const_image noise = ntp_image_as_const(&view);
        compare_measures(&noise);
    }
    return 0;
}
