/* SPDX-License-Identifier: MIT */
/*
 * test_same_bytes.c - operations on textures give the same bytes and counts with and without AVX2
 *
 * And some with AVX-512, too.  All triplets of 8 bit; of 16 bit random ones, and many that are exact or
 * beside an exact one.  Then all widths up to 100, between guard pages, packed and strided, of 3 and 4
 * channels, in place where that is allowed.
 */
#include "guarded.h"
#include "without_avx2.h"
#include "without_avx512.h"
#include "texel/level.h"
#include "libntp.h"

#include <math.h>
#include <string.h>

enum { ROW = 4096, ROWS = 4096, ROWS_16 = 200, WIDEST = 100, SETS = 3, SKIPPED = 77 };

/* Allows no instructions but the base ones, AVX2 too, or also AVX-512. */
static void allow(int set)
{
    allowed = set > 0;
    allowed_512 = set > 1;
}

/* ------------------------------------------------------------------------------------- texels */

/* Every sixteenth texel is black, white or transparent; most others are exact, or nearly. */
static void make_texel(int32_t c[4], int32_t m, bool zzero, uint64_t *seed)
{
    for (int k = 0; k < 4; k++)
        c[k] = random_level(seed, m);
    const uint64_t kind = random_bits(seed) % 16;
    if (kind == 0) {
        c[0] = c[1] = c[2] = random_bits(seed) & 1 ? m : 0;
        c[3] = random_bits(seed) & 1 ? m : 0;
    } else if (kind > 4 && ntp__rest(c[0], c[1], m) >= 0) {
        c[2] = ntp__blue_of_rest(ntp__rest(c[0], c[1], m), m, zzero);
        c[2] = kind > 12 && !zzero ? m - c[2] : c[2];
        c[2] += kind == 5 && c[2] < m ? 1 : kind == 6 && c[2] > 0 ? -1 : 0;
    }
}

static void put(void *texel, int32_t channels, ntp_type type, const int32_t c[4])
{
    for (int32_t k = 0; k < channels; k++) {
        if (type == NTP_TYPE_U8)
            ((uint8_t *) texel)[k] = (uint8_t) c[k];
        else
            ((uint16_t *) texel)[k] = (uint16_t) c[k];
    }
}

static int32_t max_of(ntp_type type)
{
    return type == NTP_TYPE_U8 ? 255 : 65535;
}

/* --------------------------------------------------------------------------------- operations */

typedef struct counts {
    ntp_convert_counts convert;
} counts;

static void convert(const ntp_image *dst, const ntp_const_image *src, counts *found)
{
    CHECK(ntp_convert(dst, src, NULL, &found->convert, NULL) == NTP_OK);
}

/* Conversions of a row to every encoding and depth, both ways, into rows that end where plain and
 * other do. */
static void compare_conversions(const ntp_const_image *src, uint8_t *plain, uint8_t *other,
                                bool in_place)
{
    for (int e = NTP_ENCODING_STANDARD; e <= NTP_ENCODING_ZZERO; e++) {
        for (int t = NTP_TYPE_U8; t <= NTP_TYPE_U16; t++) {
            ntp_image dst = ntp_image_packed(plain, src->width, 1, src->channels, (ntp_type) t);
            const size_t size = (size_t) dst.row_stride;
            const bool same = in_place && dst.type == src->type;
            counts one = { { 0, 0, 0 } }, two = one;
            ntp_const_image from = *src;
            dst.data = plain - size;
            dst.encoding = (ntp_encoding) e;
            allowed = false;
            convert(&dst, &from, &one);
            allowed = true;
            dst.data = other - size;
            if (same) {
                memcpy(dst.data, src->data, size);
                from.data = dst.data;
            }
            convert(&dst, &from, &two);
            CHECK(memcmp(plain - size, other - size, size) == 0);
            CHECK(memcmp(&one, &two, sizeof one) == 0);
        }
    }
}

/* A row as float vectors, and these as levels of every encoding and depth, both ways, the vectors up
 * to `ends`. */
static void compare_vectors(const ntp_const_image *src, float *const ends[2], uint8_t *plain,
                            uint8_t *other)
{
    uint8_t *const to[2] = { plain, other };
    counts found[2];
    ntp_image dst[2];
    for (int y = NTP_Y_UP; y <= NTP_Y_DOWN; y++) {
        for (int k = 0; k < 2; k++) {
            allowed = k == 1;
            dst[k] = ntp_image_packed(ends[k] - src->width * src->channels, src->width, 1,
                                      src->channels, NTP_TYPE_F32);
            dst[k].encoding = NTP_ENCODING_VECTOR;
            dst[k].y = (ntp_y) y;
            convert(&dst[k], src, &found[k]);
        }
        CHECK(memcmp(dst[0].data, dst[1].data, (size_t) dst[0].row_stride) == 0);
    }
    for (int e = 0; e < 12; e++) {
        const ntp_type type = e & 1 ? NTP_TYPE_U16 : NTP_TYPE_U8;
        ntp_image made = ntp_image_packed(NULL, src->width, 1, src->channels, type);
        const size_t size = (size_t) made.row_stride;
        made.encoding = (ntp_encoding) (NTP_ENCODING_STANDARD + e % 3);
        made.y = e < 6 ? NTP_Y_UP : NTP_Y_DOWN;
        for (int k = 0; k < 2; k++) {
            const ntp_const_image view = ntp_image_as_const(&dst[k]);
            allowed = k == 1;
            made.data = to[k] - size;
            memset(&found[k], 0, sizeof found[k]);
            convert(&made, &view, &found[k]);
        }
        CHECK(memcmp(plain - size, other - size, size) == 0);
        CHECK(memcmp(&found[0], &found[1], sizeof found[0]) == 0);
    }
}

static const float WHOLE[4][3] = { { -2, 1, 2 }, { 1, -2, -2 }, { 0, -4, 3 }, { 2, 10, 11 } };

/* A vector of a length that is common, tiny or huge, or none; many lie on the rim, or beside a
 * boundary between levels. */
static void make_vector(float v[3], uint64_t *seed)
{
    const uint32_t kind = random_bits(seed) % 64;
    for (int k = 0; k < 3; k++)
        v[k] = (float) (int32_t) random_bits(seed) * 0x1p-31F;
    if (kind < 16) {
        v[2] *= 0x1p-9F;
    } else if (kind < 24) { /* M x/2 is whole at 8 bit, but for rounding */
        v[0] = (float) (2 * (int32_t) (random_bits(seed) % 128)) / 255;
        v[1] = 0;
        v[2] = sqrtf(1 - v[0] * v[0]);
    } else if (kind < 32) {
        v[random_bits(seed) % 3] = random_bits(seed) & 1 ? 0.0F : -0.0F;
    } else if (kind > 60) { /* M x/2L or M y/2L is whole */
        memcpy(v, WHOLE[random_bits(seed) % 4], sizeof WHOLE[0]);
    }
    const float by = kind == 33   ? 0x1p-70F
                     : kind == 34 ? 0x1p70F
                     : kind == 35 ? 0x1p-140F
                     : kind == 36 ? 0.0F
                     : kind < 50  ? 1.0F
                                  : 0x1p-10F;
    for (int k = 0; k < 3; k++)
        v[k] *= by;
    if (kind == 37)
        v[random_bits(seed) % 3] = random_bits(seed) & 1 ? INFINITY : NAN;
}

typedef ntp_status paint_fn(const ntp_image *dst, const ntp_const_image *src, ntp_diff *diff);

static ntp_status reference(const ntp_image *dst, const ntp_const_image *src, ntp_diff *diff)
{
    (void) diff;
    return ntp_heatmap(dst, src, NTP_PALETTE_REFERENCE, 0, NULL);
}

static ntp_status safe(const ntp_image *dst, const ntp_const_image *src, ntp_diff *diff)
{
    (void) diff;
    return ntp_heatmap(dst, src, NTP_PALETTE_SAFE, 0, NULL);
}

/* The light just touches texels of which x + y = 2 z. */
static ntp_status shade(const ntp_image *dst, const ntp_const_image *src, ntp_diff *diff)
{
    const ntp_light light = { { 1, 1, -2 }, 0.1, 0.9, 0.2, { 0.6, 0.6, 0.6 } };
    (void) diff;
    return ntp_shade(dst, src, &light, NULL);
}

static ntp_status shade_in_color(const ntp_image *dst, const ntp_const_image *src, ntp_diff *diff)
{
    const ntp_light light = { .direction = { 0.3, -0.2, 0.9 },
                              .ambient = 0.05,
                              .diffuse = 1,
                              .specular = 0.7,
                              .color = { 1, 0.5, 0.25 } };
    (void) diff;
    return ntp_shade(dst, src, &light, NULL);
}

/* With the texels from right to left. */
static ntp_status differ(const ntp_image *dst, const ntp_const_image *src, ntp_diff *diff)
{
    ntp_const_image other = *src;
    other.data = (const char *) src->data + (src->width - 1) * src->pixel_stride;
    other.pixel_stride = -src->pixel_stride;
    CHECK(ntp_diff_clear(diff) == NTP_OK);
    return ntp_diff_add(diff, dst, src, &other, NULL);
}

/* Pictures of a row, into rows that end where plain and other do. */
static void compare_pictures(const ntp_const_image *src, paint_fn *const *paint, int32_t count,
                             uint8_t *plain, uint8_t *other)
{
    static ntp_diff *diff[2];
    for (int k = 0; k < 2 && diff[k] == NULL; k++)
        CHECK((diff[k] = calloc(1, ntp_diff_size())) != NULL);
    const size_t size = (size_t) src->width * 3;
    const void *one = diff[0], *two = diff[1];
    ntp_image dst = ntp_image_packed(plain - size, src->width, 1, 3, NTP_TYPE_U8);
    dst.encoding = NTP_ENCODING_HEIGHT;
    for (int32_t i = 0; i < count; i++) {
        for (int set = 0; set < SETS; set++) {
            allow(set);
            dst.data = (set == 0 ? plain : other) - size;
            CHECK(paint[i](&dst, src, diff[set > 0]) == NTP_OK);
            CHECK(set == 0 || memcmp(plain - size, other - size, size) == 0);
            CHECK(set == 0 || paint[i] != differ || memcmp(one, two, ntp_diff_size()) == 0);
        }
    }
}

/* ------------------------------------------------------------------------ vectors that change */

typedef void change_fn(const ntp_image *dst, const ntp_const_image *src);

static void strengthen(const ntp_image *dst, const ntp_const_image *src)
{
    const ntp_transform_options how = { .flip_x = 1, .use_strength = 1, .strength = 1.7 };
    CHECK(ntp_transform(dst, src, &how, NULL) == NTP_OK);
}

static void weaken_and_turn(const ntp_image *dst, const ntp_const_image *src)
{
    const ntp_transform_options how = { .quarter_turns = 2, .use_strength = 1, .strength = -0.3 };
    CHECK(ntp_transform(dst, src, &how, NULL) == NTP_OK);
}

/* As a column of the source, stronger. */
static void turn_strongly(const ntp_image *dst, const ntp_const_image *src)
{
    const ntp_transform_options how = { .quarter_turns = 1, .use_strength = 1, .strength = 3.1 };
    ntp_const_image column = *src;
    column.width = 1;
    column.height = src->width;
    column.row_stride = src->pixel_stride;
    CHECK(ntp_transform(dst, &column, &how, NULL) == NTP_OK);
}

static void mirror(const ntp_image *dst, const ntp_const_image *src)
{
    const ntp_transform_options how = { .flip_y = 1 };
    CHECK(ntp_transform(dst, src, &how, NULL) == NTP_OK);
}

/* As a column of the source: the picture is turned, and so is what it is turned into. */
static void turn(const ntp_image *dst, const ntp_const_image *src)
{
    const ntp_transform_options how = { .quarter_turns = 3 };
    ntp_image upright = *dst;
    upright.width = 1;
    upright.height = dst->width;
    upright.row_stride = dst->pixel_stride;
    CHECK(ntp_transform(&upright, src, &how, NULL) == NTP_OK);
}

static void blend(const ntp_image *dst, const ntp_const_image *src, ntp_blend_mode mode,
                  double strength)
{
    const ntp_blend_options how = { .mode = mode,
                                    .use_strength = strength != 1,
                                    .strength = strength,
                                    .detail_alpha = mode == NTP_BLEND_LINEAR };
    ntp_const_image detail = *src; /* repeats */
    detail.width = (src->width + 2) / 3;
    CHECK(ntp_blend(dst, src, &detail, &how, NULL) == NTP_OK);
    if (src->pixel_stride != dst->pixel_stride)
        return;
    /* In place, with the other y, and another touch of unused texels */
    const ntp_const_image base = ntp_image_as_const(dst);
    const ntp_blend_options touch = { .mode = mode, .touch_unused = NTP_UNUSED_BLACK };
    detail.y = src->y == NTP_Y_UP ? NTP_Y_DOWN : NTP_Y_UP;
    detail.width = 1 + src->width / 2;
    CHECK(ntp_blend(dst, &base, &detail, &touch, NULL) == NTP_OK);
}

static void reorient(const ntp_image *dst, const ntp_const_image *src)
{
    blend(dst, src, NTP_BLEND_RNM, 1);
}

static void reorient_strongly(const ntp_image *dst, const ntp_const_image *src)
{
    blend(dst, src, NTP_BLEND_RNM, 2.3);
}

static void reorient_turned(const ntp_image *dst, const ntp_const_image *src)
{
    blend(dst, src, NTP_BLEND_RNM, -1);
}

static void linear_strongly(const ntp_image *dst, const ntp_const_image *src)
{
    blend(dst, src, NTP_BLEND_LINEAR, 63.5);
}

static void whiteout(const ntp_image *dst, const ntp_const_image *src)
{
    blend(dst, src, NTP_BLEND_WHITEOUT, 1);
}

static void udn(const ntp_image *dst, const ntp_const_image *src)
{
    blend(dst, src, NTP_BLEND_UDN, -0.7);
}

static void linear(const ntp_image *dst, const ntp_const_image *src)
{
    blend(dst, src, NTP_BLEND_LINEAR, 1);
}

static void resize(const ntp_image *dst, const ntp_const_image *src, int32_t to, int32_t from,
                   ntp_filter filter)
{
    static uint64_t plan_memory[ROW * 16], scratch[ROW * 64];
    const ntp_resize_options how = { filter, NTP_BORDER_WRAP, NTP_BORDER_CLAMP, 0 };
    ntp_image made = *dst;
    ntp_const_image view = *src;
    ntp_resize_plan *plan;
    made.width = to;
    view.width = from;
    CHECK(ntp_resize_plan_init(&plan, plan_memory, sizeof plan_memory, &how, from, 1, to, 1) ==
          NTP_OK);
    CHECK(ntp_resize_scratch_size(plan) <= sizeof scratch);
    CHECK(ntp_resize(&made, &view, plan, scratch, sizeof scratch, NULL) == NTP_OK);
}

static void shrink(const ntp_image *dst, const ntp_const_image *src)
{
    resize(dst, src, (src->width + 1) / 2, src->width, NTP_FILTER_LANCZOS3);
    /* The first few texels, of which often none is unused */
    resize(dst, src, src->width < 2 ? 1 : 2, src->width < 8 ? src->width : 8, NTP_FILTER_BOX);
}

static void grow(const ntp_image *dst, const ntp_const_image *src)
{
    resize(dst, src, src->width, (src->width + 1) / 2, NTP_FILTER_TRIANGLE);
    resize(dst, src, 1, src->width < 9 ? src->width : 9, NTP_FILTER_TRIANGLE);
}

static change_fn *const CHANGE[] = {
    strengthen,        weaken_and_turn, turn,     turn_strongly, reorient,
    reorient_strongly, reorient_turned, whiteout, udn,           linear,
    linear_strongly,   shrink,          grow,     mirror
};
enum { CHANGES = 14 };

/* Changes of a row, into rows that end where plain and other do. */
static void compare_changes(const ntp_const_image *src, uint8_t *plain, uint8_t *other)
{
    ntp_image dst = ntp_image_packed(plain, src->width, 1, src->channels, src->type);
    const size_t size = (size_t) dst.row_stride;
    dst.encoding = src->encoding;
    for (int32_t i = 0; i < CHANGES; i++) {
        for (int set = 0; set < SETS; set++) {
            allow(set);
            dst.data = (set == 0 ? plain : other) - size;
            CHANGE[i](&dst, src);
            CHECK(set == 0 || memcmp(plain - size, other - size, size) == 0);
        }
    }
}

static paint_fn *const PAINT[] = { reference, safe, shade, shade_in_color, differ };
enum { PAINTS = 5, PAINTS_OF_ALL = 3 };

/* -------------------------------------------------------------------------------------- tests */

static uint64_t in[2 * ROW], out[2][ROW];

static void all_triplets(void)
{
    for (int32_t row = 0; row < ROWS; row++) {
        for (int32_t i = 0; i < ROW; i++) {
            const int32_t c[4] = { i & 255, i >> 8 | (row & 15) << 4, row >> 4, 255 };
            put((uint8_t *) in + 3 * i, 3, NTP_TYPE_U8, c);
        }
        ntp_image src = ntp_image_packed(in, ROW, 1, 3, NTP_TYPE_U8);
        for (int e = NTP_ENCODING_STANDARD; e <= NTP_ENCODING_ZZERO; e++) {
            src.encoding = (ntp_encoding) e;
            const ntp_const_image view = ntp_image_as_const(&src);
            compare_conversions(&view, (uint8_t *) out[1], (uint8_t *) (out[1] + ROW), false);
            compare_pictures(&view, PAINT, PAINTS_OF_ALL, (uint8_t *) out[1],
                             (uint8_t *) (out[1] + ROW));
            if (row % 128 == 77 && e == NTP_ENCODING_STANDARD)
                compare_changes(&view, (uint8_t *) out[1], (uint8_t *) (out[1] + ROW));
        }
    }
}

static void random_texels_16(uint64_t *seed)
{
    for (int32_t row = 0; row < ROWS_16; row++) {
        for (int e = NTP_ENCODING_STANDARD; e <= NTP_ENCODING_ZZERO; e++) {
            for (int32_t i = 0; i < ROW; i++) {
                int32_t c[4];
                do /* texels that are to be kept end the fast loop */
                    make_texel(c, 65535, e == NTP_ENCODING_ZZERO, seed);
                while (c[0] == c[1] && i % 512 != 0);
                put((uint16_t *) (void *) in + 3 * i, 3, NTP_TYPE_U16, c);
            }
            ntp_image src = ntp_image_packed(in, ROW, 1, 3, NTP_TYPE_U16);
            src.encoding = (ntp_encoding) e;
            const ntp_const_image view = ntp_image_as_const(&src);
            compare_conversions(&view, (uint8_t *) out[1], (uint8_t *) (out[1] + ROW), row & 1);
            compare_pictures(&view, PAINT, PAINTS, (uint8_t *) out[1], (uint8_t *) (out[1] + ROW));
            if (row % 8 == 0)
                compare_changes(&view, (uint8_t *) out[1], (uint8_t *) (out[1] + ROW));
        }
    }
}

/* Of random vectors.  compare_vectors copies, or flips, them first. */
static void random_vectors(uint64_t *seed)
{
    static float vectors[3 * ROW], copy[3 * ROW];
    float *const ends[2] = { vectors + 3 * ROW, copy + 3 * ROW };
    for (int32_t row = 0; row < ROWS_16; row++) {
        ntp_image src = ntp_image_packed(in, ROW, 1, 3, NTP_TYPE_F32);
        for (int32_t i = 0; i < ROW; i++)
            make_vector((float *) (void *) in + 3 * i, seed);
        src.encoding = NTP_ENCODING_VECTOR;
        const ntp_const_image view = ntp_image_as_const(&src);
        compare_vectors(&view, ends, (uint8_t *) out[1], (uint8_t *) (out[1] + ROW));
    }
}

static void widths(uint64_t *seed)
{
    for (int32_t n = 1; n <= WIDEST; n++) {
        for (int kind = 0; kind < 16; kind++) {
            const ntp_type type = kind & 1 ? NTP_TYPE_U16 : NTP_TYPE_U8;
            const int32_t channels = kind & 2 ? 4 : 3, size = type == NTP_TYPE_U16 ? 2 : 1;
            const int32_t stride = (kind & 4 ? 5 : channels) * size;
            guarded from = guarded_alloc((size_t) n * (size_t) stride, n & 1);
            guarded one = guarded_alloc((size_t) n * 8, false);
            guarded two = guarded_alloc((size_t) n * 8, false);
            guarded vectors = guarded_alloc((size_t) (n * channels) * sizeof(float), false);
            guarded copy = guarded_alloc((size_t) (n * channels) * sizeof(float), false);
            float *const ends[2] = { (float *) vectors.data + n * channels,
                                     (float *) copy.data + n * channels };
            ntp_image src = ntp_image_packed(from.data, n, 1, channels, type);
            src.pixel_stride = stride;
            src.encoding = kind & 8 ? NTP_ENCODING_ZZERO : NTP_ENCODING_STANDARD;
            for (int32_t i = 0; i < n; i++) {
                int32_t c[4];
                make_texel(c, max_of(type), kind & 8, seed);
                put((uint8_t *) from.data + i * stride, channels, type, c);
            }
            const ntp_const_image view = ntp_image_as_const(&src);
            compare_conversions(&view, (uint8_t *) one.data + n * 8, (uint8_t *) two.data + n * 8,
                                stride == channels * size);
            compare_vectors(&view, ends, (uint8_t *) one.data + n * 8,
                            (uint8_t *) two.data + n * 8);
            compare_pictures(&view, PAINT, PAINTS, (uint8_t *) one.data + n * 8,
                             (uint8_t *) two.data + n * 8);
            compare_changes(&view, (uint8_t *) one.data + n * 8, (uint8_t *) two.data + n * 8);
            guarded_free(&from);
            guarded_free(&one);
            guarded_free(&two);
            guarded_free(&vectors);
            guarded_free(&copy);
        }
    }
}

int main(void)
{
    uint64_t seed = 1;
    allowed = true;
    if (!ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    all_triplets();
    random_texels_16(&seed);
    random_vectors(&seed);
    widths(&seed);
    return 0;
}
