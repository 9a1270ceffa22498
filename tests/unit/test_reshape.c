/* SPDX-License-Identifier: MIT */
/*
 * test_reshape.c - turned and resized pictures are the same with and without AVX2 and AVX-512
 *
 * The bytes of a picture end or begin at a guard page.
 */
#include "guarded.h"
#include "without_avx2.h"
#include "without_avx512.h"
#include "libntp.h"

#include <string.h>

enum { SKIPPED = 77, SMALL = 20, SETS = 3 /* of instructions */ };

typedef struct picture {
    guarded memory;
    ntp_image view;
} picture;

static picture make(int32_t width, int32_t height, int32_t channels, ntp_type type, bool at_start)
{
    const size_t size = (size_t) (width * height * channels) * (type == NTP_TYPE_U16 ? 2 : 1);
    picture p;
    p.memory = guarded_alloc(size, at_start);
    p.view = ntp_image_packed(p.memory.data, width, height, channels, type);
    p.view.encoding = NTP_ENCODING_STANDARD;
    memset(p.memory.data, 0x5a, size);
    return p;
}

static size_t bytes_of(const picture *p)
{
    return (size_t) p->view.height * (size_t) p->view.row_stride;
}

/* `rough`: how far red and green go from flat; some texels are black or white. */
static void fill(picture *p, int32_t rough, int32_t unused, uint64_t *seed)
{
    const int32_t channels = p->view.channels, n = p->view.width * p->view.height * channels;
    const bool deep = p->view.type == NTP_TYPE_U16;
    const int32_t m = deep ? 65535 : 255;
    int32_t c = 0;
    bool plain = false;
    for (int32_t i = 0; i < n; i++) {
        if (i % channels == 0) {
            plain = unused > 0 && (int32_t) (random_bits(seed) % 100) < unused;
            c = random_bits(seed) & 1 ? m : 0;
        }
        if (!plain) {
            const int32_t away = (int32_t) (random_bits(seed) % (uint32_t) m) - m / 2;
            c = (m + 1) / 2 + away * rough / 100;
            c = i % channels == 2 && rough < 100 ? m - c / 4 : c;
        }
        if (deep)
            ((uint16_t *) p->memory.data)[i] = (uint16_t) c;
        else
            ((uint8_t *) p->memory.data)[i] = (uint8_t) c;
    }
}

static void put(picture *p, int32_t x, int32_t y, int32_t k, int32_t c)
{
    const int32_t i = (y * p->view.width + x) * p->view.channels + k;
    if (p->view.type == NTP_TYPE_U16)
        ((uint16_t *) p->memory.data)[i] = (uint16_t) c;
    else
        ((uint8_t *) p->memory.data)[i] = (uint8_t) c;
}

/* Columns that cancel out one component where the sides are halved: then its sign hangs on the last
 * bit of a sum. */
static void fill_stripes(picture *p, int32_t component, uint64_t *seed)
{
    const int32_t m = p->view.type == NTP_TYPE_U16 ? 65535 : 255;
    for (int32_t y = 0; y < p->view.height; y++) {
        for (int32_t k = 0; k < 3; k++) {
            const int32_t c = 1 + (int32_t) (random_bits(seed) % (uint32_t) (m - 1));
            for (int32_t x = 0; x < p->view.width; x++)
                put(p, x, y, k, k == component && x % 2 != 0 ? m - c : c);
        }
    }
}

/* Few texels point down. */
static void fill_spots(picture *p, uint64_t *seed)
{
    const int32_t m = p->view.type == NTP_TYPE_U16 ? 65535 : 255;
    const int32_t texels = p->view.width * p->view.height;
    for (int32_t i = 0; i < texels; i++) {
        const bool down = random_bits(seed) % 200 == 0;
        for (int32_t k = 0; k < 3; k++)
            put(p, i % p->view.width, i / p->view.width, k, k < 2 ? m / 2 + k : down ? 1 : m - 2);
    }
}

/* Only blue has negative components, in few places; elsewhere sums overshoot to below 0. */
static void fill_steep(picture *p, uint64_t *seed)
{
    const int32_t m = p->view.type == NTP_TYPE_U16 ? 65535 : 255;
    for (int32_t y = 0; y < p->view.height; y++) {
        for (int32_t x = 0; x < p->view.width; x++) {
            const uint64_t bits = random_bits(seed);
            const bool up = bits % 4 == 0, down = x / 8 % 7 == 1 && y / 8 % 2 == 0 && bits % 5 == 0;
            put(p, x, y, 0, m / 2 + 1);
            put(p, x, y, 1, m - 9);
            put(p, x, y, 2, down ? m / 2 - 3 : up ? m - 20 : m / 2 + 1);
        }
    }
}

/* Vectors of a few levels; `opposite`: those of odd columns undo those beside them, else some are unused. */
static void fill_short(picture *p, bool opposite, uint64_t *seed)
{
    const int32_t m = p->view.type == NTP_TYPE_U16 ? 65535 : 255;
    for (int32_t y = 0; y < p->view.height; y++) {
        int32_t c[3] = { 0, 0, 0 };
        for (int32_t x = 0; x < p->view.width; x++) {
            const uint64_t bits = random_bits(seed);
            const bool undone = opposite && x % 2 != 0 && bits % 50 != 0;
            for (int32_t k = 0; k < 3; k++) {
                c[k] = undone ? m - c[k] : m / 2 + (int32_t) (random_bits(seed) % 4) - 1;
                c[k] = !opposite && bits % 8 < 3 ? (bits & 1 ? m : 0) : c[k];
                put(p, x, y, k, c[k]);
            }
        }
    }
}

static void compare(const picture *one, const picture *two)
{
    CHECK(memcmp(one->memory.data, two->memory.data, bytes_of(one)) == 0);
}

/* ----------------------------------------------------------------------------------- turns */

/* With each set of instructions; `kind` says what is turned, and where it lies. */
static void turn_by(const picture *src, const ntp_transform_options *how, int32_t kind)
{
    const ntp_const_image from = ntp_image_as_const(&src->view);
    const bool upright = how->quarter_turns % 2 == 0;
    picture made[SETS];
    for (int32_t k = 0; k < SETS; k++) {
        made[k] = make(upright ? from.width : from.height, upright ? from.height : from.width,
                       from.channels, from.type, kind & 4);
        allowed = k != 0;
        allowed_512 = k > 1;
        CHECK(ntp_transform(&made[k].view, &from, how, NULL) == NTP_OK);
    }
    compare(&made[0], &made[1]);
    compare(&made[0], &made[2]);
    for (int32_t k = 0; k < SETS; k++)
        guarded_free(&made[k].memory);
}

static void turn(int32_t width, int32_t height, int32_t kind, uint64_t *seed)
{
    static const double ANGLES[] = { 30, 45, -3.7 };
    const ntp_type type = kind & 1 ? NTP_TYPE_U16 : NTP_TYPE_U8;
    picture src = make(width, height, kind & 2 ? 4 : 3, type, kind & 4);
    fill(&src, 100, 10, seed);
    for (int32_t turns = 1; turns <= 3; turns++) {
        const ntp_transform_options by_quarters = { .quarter_turns = turns, .flip_x = kind >> 3 };
        turn_by(&src, &by_quarters, kind);
        const ntp_transform_options by_angle = { .angle = ANGLES[turns - 1],
                                                 .flip_x = kind >> 3,
                                                 .border_x = NTP_BORDER_MIRROR - (turns - 1),
                                                 .border_y = NTP_BORDER_WRAP + (turns - 1) };
        turn_by(&src, &by_angle, kind);
    }
    guarded_free(&src.memory);
}

static void turns(uint64_t *seed)
{
    for (int32_t kind = 0; kind < 16; kind++) {
        for (int32_t width = 1; width <= SMALL; width++) {
            for (int32_t height = 1; height <= SMALL; height++)
                turn(width, height, kind, seed);
        }
        turn(141, 70, kind, seed);
        turn(70, 141, kind, seed);
    }
}

/* --------------------------------------------------------------------------------- resizing */

static void resize(const ntp_image *dst, const ntp_const_image *src, const ntp_resize_options *how)
{
    ntp_resize_plan *plan;
    const size_t size = ntp_resize_plan_size(how, src->width, src->height, dst->width, dst->height);
    void *memory = malloc(size);
    CHECK(memory != NULL);
    CHECK(ntp_resize_plan_init(&plan, memory, size, how, src->width, src->height, dst->width,
                               dst->height) == NTP_OK);
    const size_t scratch_size = ntp_resize_scratch_size(plan);
    void *scratch = malloc(scratch_size);
    CHECK(scratch != NULL);
    CHECK(ntp_resize(dst, src, plan, scratch, scratch_size, NULL) == NTP_OK);
    free(scratch);
    free(memory);
}

typedef struct sizes {
    int32_t from[2], to[2];
} sizes;

/* Instead of how rough; there are stripes of x, y, z. */
enum { OPPOSITE = -7, SHORT_SUM, STEEP, STRIPES, SPOTS = -1 };

static void compare_sizes(const sizes *s, int32_t kind, int32_t rough, int32_t unused,
                          uint64_t *seed)
{
    const ntp_type type = kind & 1 ? NTP_TYPE_U16 : NTP_TYPE_U8;
    picture src = make(s->from[0], s->from[1], 3, type, kind & 2), made[SETS];
    if (rough >= 0)
        fill(&src, rough, unused, seed);
    else if (rough == SPOTS)
        fill_spots(&src, seed);
    else if (rough == STEEP)
        fill_steep(&src, seed);
    else if (rough < STEEP)
        fill_short(&src, rough == OPPOSITE, seed);
    else
        fill_stripes(&src, rough - STRIPES, seed);
    src.view.encoding = kind & 4 ? NTP_ENCODING_ZZERO : NTP_ENCODING_STANDARD;
    const ntp_const_image from = ntp_image_as_const(&src.view);
    for (int32_t filter = NTP_FILTER_TRIANGLE; filter <= NTP_FILTER_LANCZOS3; filter++) {
        const ntp_border border = kind & 2 ? NTP_BORDER_WRAP : NTP_BORDER_MIRROR;
        const ntp_resize_options how = { (ntp_filter) filter, border, border, 0 };
        for (int32_t k = 0; k < SETS; k++) {
            made[k] = make(s->to[0], s->to[1], 3, type, kind & 2);
            made[k].view.encoding = src.view.encoding;
            allowed = k != 0;
            allowed_512 = k > 1;
            resize(&made[k].view, &from, &how);
        }
        compare(&made[0], &made[1]);
        compare(&made[0], &made[2]);
        for (int32_t k = 0; k < SETS; k++)
            guarded_free(&made[k].memory);
    }
    guarded_free(&src.memory);
}

static void resizes(uint64_t *seed)
{
    static const sizes SIZES[] = {
        { { 64, 64 }, { 32, 32 } },     { { 600, 40 }, { 300, 20 } }, { { 601, 41 }, { 300, 20 } },
        { { 100, 100 }, { 25, 25 } },   { { 96, 96 }, { 12, 12 } },   { { 99, 33 }, { 33, 11 } },
        { { 50, 30 }, { 71, 43 } },     { { 40, 40 }, { 80, 80 } },   { { 90, 90 }, { 61, 31 } },
        { { 300, 200 }, { 290, 190 } }, { { 7, 5 }, { 3, 2 } },       { { 1, 1 }, { 5, 5 } },
        { { 400, 90 }, { 33, 17 } },    { { 2, 90 }, { 1, 45 } },
    };
    for (size_t i = 0; i < sizeof SIZES / sizeof SIZES[0]; i++) {
        for (int32_t kind = 0; kind < 8; kind++) {
            compare_sizes(&SIZES[i], kind, 100, 0, seed);
            compare_sizes(&SIZES[i], kind, 100, 20, seed);
            compare_sizes(&SIZES[i], kind, 100, 95, seed);
            compare_sizes(&SIZES[i], kind, 60, 0, seed);
            compare_sizes(&SIZES[i], kind, 60, 1, seed); /* rows with unused texels and without */
            compare_sizes(&SIZES[i], kind, 5, 0, seed);
            compare_sizes(&SIZES[i], kind, 1, 10, seed);
            compare_sizes(&SIZES[i], kind, 0, 0, seed);
            for (int32_t special = OPPOSITE; special <= SPOTS; special++)
                compare_sizes(&SIZES[i], kind, special, 0, seed);
        }
    }
}

/* Halved: up to one strip and some, which sums of whole rows make. */
static void all_widths(uint64_t *seed)
{
    for (int32_t width = 30; width < 150; width++) {
        const sizes half = { { 2 * width, 10 }, { width, 5 } },
                    third = { { 2 * width, 9 }, { width, 3 } };
        for (int32_t kind = 0; kind < 6; kind += 2) {
            compare_sizes(&half, kind, 100, width % 3 * 10, seed);
            compare_sizes(&half, kind, SHORT_SUM, 0, seed);
            compare_sizes(&half, kind, OPPOSITE, 0, seed);
            compare_sizes(&third, kind, OPPOSITE, 0, seed);
        }
    }
}

int main(void)
{
    uint64_t seed = 1;
    allowed = true;
    if (!ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    turns(&seed);
    resizes(&seed);
    all_widths(&seed);
    return 0;
}
