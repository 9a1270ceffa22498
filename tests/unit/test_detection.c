/* SPDX-License-Identifier: MIT */
/*
 * test_detection.c - what made a texture is found alike with and without AVX2, and of texels that do not
 * lie side by side
 */
#include "guarded.h"
#include "libntp.h"
#include "without_avx2.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 171, HEIGHT = 133, TEXELS = WIDTH * HEIGHT, SKIPPED = 77 };

static uint32_t state = 1;

static int32_t random_below(int32_t n)
{
    state = state * 1664525u + 1013904223u;
    return (int32_t) ((state >> 8) % (uint32_t) n);
}

/* Normals of smooth bumps whose levels are off by up to `damage`; a few texels hold none. */
static void make(uint8_t *texels, int32_t width, int32_t height, int32_t damage, int32_t holes)
{
    for (int32_t i = 0; i < width * height; i++) {
        const int32_t column = i % width, row = i / width;
        double x = column, y = row;
        double p = 0.6 * sin(x / 5) * cos(y / 7) + 0.3 * sin((x + 2 * y) / 9),
               q = 0.5 * cos(x / 6 + y / 4);
        double z = 1 / sqrt(1 + p * p + q * q), n[3] = { -p * z, -q * z, z };
        for (int32_t c = 0; c < 3; c++) {
            int32_t v =
                (int32_t) floor((n[c] + 1) * 127.5 + 0.5) + random_below(2 * damage + 1) - damage;
            texels[3 * i + c] = (uint8_t) (v < 1 ? 1 : v > 254 ? 254 : v);
        }
        if (holes > 0 && random_below(holes) == 0)
            memset(texels + (size_t) 3 * (size_t) i, 0, 3);
    }
}

/* All that is found, in structures that were all zero before they were filled. */
typedef struct found {
    ntp_kernel_fit kernel;
    ntp_seam seams[2];
    ntp_border_fit borders[2];
} found;

static void find(found *f, const ntp_const_image *src, bool avx2)
{
    static const int32_t open[2] = { 1, 1 };
    ntp_height_options how = { .kernel = NTP_KERNEL_CENTRAL };
    memset(f, 0, sizeof *f);
    allowed = avx2;
    CHECK(ntp_find_kernel(&f->kernel, src, 0) == NTP_OK);
    CHECK(ntp_find_seams(&f->seams[0], &f->seams[1], src, 0) == NTP_OK);
    const int32_t wraps[2] = { f->seams[0].wraps, f->seams[1].wraps };
    size_t size = ntp_find_borders_scratch_size(&how, src->width, src->height, 1);
    void *scratch = system_aligned(size);
    CHECK(scratch != NULL);
    CHECK(ntp_find_borders(f->borders, src, &how, open, wraps, scratch, size, NULL) == NTP_OK);
    system_aligned_free(scratch);
}

static bool same_bytes(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

static void compare(const ntp_const_image *src, const found *expected)
{
    static found plain, other;
    find(&plain, src, false);
    find(&other, src, true);
    CHECK(same_bytes(&plain, &other, sizeof plain));
    CHECK(expected == NULL || same_bytes(&plain, expected, sizeof plain));
}

/* Pixels two by two, of which the others are noise; and rows from the last one up. */
static void compare_apart(const ntp_const_image *packed)
{
    static uint8_t apart[6 * TEXELS];
    static found expected;
    ntp_const_image src = *packed;
    find(&expected, packed, true);
    const uint8_t *from = packed->data;
    for (int32_t y = 0; y < src.height; y++) {
        for (int32_t x = 0; x < src.width; x++) {
            uint8_t *to = apart + (size_t) 6 * (size_t) ((src.height - 1 - y) * src.width + x);
            memcpy(to, from + (size_t) 3 * (size_t) (y * src.width + x), 3);
            for (int32_t c = 3; c < 6; c++)
                to[c] = (uint8_t) random_below(256);
        }
    }
    src.data = apart + (size_t) 6 * (size_t) ((src.height - 1) * src.width);
    src.pixel_stride = 6;
    src.row_stride = -6 * (ptrdiff_t) src.width;
    compare(&src, &expected);
}

int main(void)
{
    static uint8_t texels[3 * TEXELS];
    allowed = true;
    if (!ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    for (int32_t round = 0; round < 48; round++) {
        const int32_t width = WIDTH - 3 * round, height = round % 2 ? HEIGHT : HEIGHT - 2 * round;
        make(texels, width, height, round % 8, round % 5 == 4 ? 500 : 0);
        ntp_image view = ntp_image_packed(texels, width, height, 3, NTP_TYPE_U8);
        const ntp_const_image src = ntp_image_as_const(&view);
        compare(&src, NULL);
        compare_apart(&src);
    }
    return 0;
}
