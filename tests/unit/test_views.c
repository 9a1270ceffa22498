/* SPDX-License-Identifier: MIT */
/*
 * test_views.c - no operation touches a byte outside its views
 *
 * Images of every type, channel count and width 1..300 lie against guard pages, forwards and
 * backwards; the samples that an operation must not touch are compared afterwards.
 */
#include "guarded.h"
#include "libntp.h"

#include <string.h>

static ntp_encoding encoding_for(int32_t channels, ntp_type type, uint32_t pick)
{
    const ntp_encoding any[] = { NTP_ENCODING_STANDARD, NTP_ENCODING_ZZERO, NTP_ENCODING_XY,
                                 NTP_ENCODING_VECTOR };
    if (channels == 1)
        return NTP_ENCODING_HEIGHT;
    if (channels == 2)
        return NTP_ENCODING_XY;
    return any[pick % (type == NTP_TYPE_F32 ? 4 : 3)];
}

static size_t sample_size(ntp_type type)
{
    return type == NTP_TYPE_U8 ? 1 : type == NTP_TYPE_U16 ? 2 : 4;
}

static void fill(void *data, size_t samples, ntp_type type, uint64_t *seed)
{
    for (size_t i = 0; i < samples; i++) {
        int32_t level = random_level(seed, type == NTP_TYPE_U8 ? 255 : 65535);
        if (type == NTP_TYPE_U8)
            ((uint8_t *) data)[i] = (uint8_t) level;
        else if (type == NTP_TYPE_U16)
            ((uint16_t *) data)[i] = (uint16_t) level;
        else
            ((float *) data)[i] = (float) level / 65535.0f;
    }
}

/* A view of w x h pixels in exactly as many bytes; every other one runs backwards. */
static ntp_image guarded_view(guarded *g, int32_t w, int32_t h, int32_t channels, ntp_type type,
                              uint64_t *seed)
{
    size_t samples = (size_t) w * (size_t) h * (size_t) channels;
    uint32_t pick = random_bits(seed);
    *g = guarded_alloc(samples * sample_size(type), pick & 1);
    fill(g->data, samples, type, seed);
    ntp_image view = ntp_image_packed(g->data, w, h, channels, type);
    view.encoding = encoding_for(channels, type, pick >> 8);
    if (pick & 2) {
        view.data = (char *) view.data + (h - 1) * view.row_stride;
        view.row_stride = -view.row_stride;
    }
    if (pick & 4) {
        view.data = (char *) view.data + (w - 1) * view.pixel_stride;
        view.pixel_stride = -view.pixel_stride;
    }
    return view;
}

static void clean_and_validate(int32_t w, int32_t channels, ntp_type type, uint64_t *seed)
{
    guarded gs, gd, gm;
    ntp_image src = guarded_view(&gs, w, 2, channels, type, seed);
    ntp_image dst = guarded_view(&gd, w, 2, channels, type, seed);
    ntp_image mask = guarded_view(&gm, w, 2, 1, NTP_TYPE_U8, seed);
    dst.encoding = src.encoding;
    ntp_const_image from = ntp_image_as_const(&src);
    ntp_clean_options how = { (ntp_clean_method) (random_bits(seed) % 3), 0, 0,
                              NTP_VERDICT_NEIGHBOR, 0 };
    CHECK(ntp_clean(&dst, &from, &how, NULL, NULL, NULL) == NTP_OK);
    CHECK(ntp_clean(&src, &from, &how, NULL, NULL, NULL) == NTP_OK);
    if (dst.row_stride == src.row_stride && dst.pixel_stride == src.pixel_stride)
        CHECK(memcmp(gs.data, gd.data, sample_size(type) * (size_t) (w * 2 * channels)) == 0);
    CHECK(ntp_validate(&mask, &from, 0, NULL) == NTP_OK);
    ntp_texel texel;
    CHECK(ntp_inspect(&texel, &from, w - 1, 1, 0) == NTP_OK);
    guarded_free(&gs);
    guarded_free(&gd);
    guarded_free(&gm);
}

static void clean_by_plan(int32_t w, int32_t channels, ntp_clean_plan *plan,
                          const ntp_clean_options *how, uint64_t *seed)
{
    guarded gs;
    ntp_image view = guarded_view(&gs, w, 2, channels, NTP_TYPE_U8, seed);
    view.encoding = NTP_ENCODING_STANDARD;
    ntp_const_image from = ntp_image_as_const(&view);
    CHECK(ntp_clean(&view, &from, how, plan, NULL, NULL) == NTP_OK);
    guarded_free(&gs);
}

static void convert_between(int32_t w, int32_t from_channels, ntp_type from_type, uint64_t *seed)
{
    for (ntp_type type = NTP_TYPE_U8; type <= NTP_TYPE_F32; type++) {
        for (int32_t channels = 1; channels <= 4; channels++) {
            guarded gs, gd;
            if ((from_channels == 1) != (channels == 1))
                continue;
            ntp_image src = guarded_view(&gs, w, 2, from_channels, from_type, seed);
            ntp_image dst = guarded_view(&gd, w, 2, channels, type, seed);
            ntp_const_image from = ntp_image_as_const(&src);
            dst.y = (ntp_y) (random_bits(seed) & 1);
            CHECK(ntp_convert(&dst, &from, NULL, NULL, NULL) == NTP_OK);
            guarded_free(&gs);
            guarded_free(&gd);
        }
    }
}

static void measure(int32_t w, int32_t channels, ntp_type type, uint64_t *seed)
{
    guarded gs, gt = guarded_alloc((ntp_tally_size() + 15) / 16 * 16, false);
    ntp_image view = guarded_view(&gs, w, 2, channels, type, seed);
    ntp_const_image from = ntp_image_as_const(&view);
    ntp_stats stats;
    CHECK(ntp_tally_add(gt.data, &from, 0, NULL) == NTP_OK);
    ntp_encoding encoding =
        view.encoding >= NTP_ENCODING_VECTOR ? NTP_ENCODING_STANDARD : view.encoding;
    CHECK(ntp_tally_summarize(&stats, gt.data, encoding) == NTP_OK);
    CHECK(stats.texels == (uint64_t) w * 2);
    guarded_free(&gs);
    guarded_free(&gt);
}

int main(void)
{
    uint64_t seed = 99;
    ntp_clean_plan *plan = NULL;
    const ntp_clean_options how = { NTP_CLEAN_DERIVE, 0, 0, NTP_VERDICT_NEIGHBOR, 0 };
    guarded memory = guarded_alloc((ntp_clean_plan_size() + 15) / 16 * 16, false);
    CHECK(ntp_clean_plan_init(&plan, memory.data, ntp_clean_plan_size(), NTP_ENCODING_STANDARD,
                              &how) == NTP_OK);
    for (int32_t w = 1; w <= 300; w++) {
        for (ntp_type type = NTP_TYPE_U8; type <= NTP_TYPE_F32; type++) {
            for (int32_t channels = 1; channels <= 4; channels++) {
                if (channels > 1)
                    clean_and_validate(w, channels, type, &seed);
                if (channels > 2 && type == NTP_TYPE_U8)
                    clean_by_plan(w, channels, plan, &how, &seed);
                if (w < 40 || w % 16 == 0)
                    convert_between(w, channels, type, &seed);
                if (w < 6 || w % 60 == 0)
                    measure(w, channels, type, &seed);
            }
        }
    }
    guarded_free(&memory);
    return 0;
}
