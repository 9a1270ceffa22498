/* SPDX-License-Identifier: MIT */
/*
 * test_threads.c - calls on disjoint areas of one image from several threads
 *
 * Four threads clean, validate and measure bands of one image and share the plan.  The result is
 * that of one call, whatever the order.  Run it under a thread sanitizer too.
 */
#include "guarded.h"
#include "libntp.h"

#include <pthread.h>
#include <string.h>

enum { WIDTH = 515, HEIGHT = 203, THREADS = 4 };

typedef struct band {
    pthread_t thread;
    ntp_image dst, mask;
    ntp_const_image src;
    const ntp_clean_options *how;
    const ntp_clean_plan *plan;
    ntp_clean_counts counts;
    ntp_tally *tally;
    int index;
} band;

static void *work(void *argument)
{
    band *b = argument;
    for (int32_t y = b->index; y < HEIGHT; y += THREADS) { /* rows interleave: worst for sharing */
        ntp_rect area = { 0, y, WIDTH, y + 1 };
        CHECK(ntp_clean(&b->dst, &b->src, b->how, b->plan, &b->counts, &area) == NTP_OK);
        CHECK(ntp_validate(&b->mask, &b->src, 0, &area) == NTP_OK);
        CHECK(ntp_tally_add(b->tally, &b->src, 0, &area) == NTP_OK);
    }
    return NULL;
}

static void *zeroed(size_t size)
{
    void *memory = system_aligned(size);
    CHECK(memory != NULL);
    memset(memory, 0, size);
    return memory;
}

int main(void)
{
    static uint8_t src[HEIGHT][WIDTH][3], dst[HEIGHT][WIDTH][3], whole[HEIGHT][WIDTH][3];
    static uint8_t mask[HEIGHT][WIDTH], whole_mask[HEIGHT][WIDTH];
    uint64_t seed = 4;
    for (size_t i = 0; i < sizeof src; i++)
        ((uint8_t *) src)[i] = (uint8_t) random_level(&seed, 255);

    const ntp_clean_options how = { NTP_CLEAN_DERIVE, 0, 0, NTP_VERDICT_NEIGHBOR, 0 };
    ntp_clean_plan *plan = NULL;
    void *memory = zeroed(ntp_clean_plan_size());
    CHECK(ntp_clean_plan_init(&plan, memory, ntp_clean_plan_size(), NTP_ENCODING_STANDARD, &how) ==
          NTP_OK);
    ntp_image source = ntp_image_packed(src, WIDTH, HEIGHT, 3, NTP_TYPE_U8);
    ntp_image target = ntp_image_packed(whole, WIDTH, HEIGHT, 3, NTP_TYPE_U8);
    ntp_image flags = ntp_image_packed(whole_mask, WIDTH, HEIGHT, 1, NTP_TYPE_U8);
    ntp_const_image from = ntp_image_as_const(&source);
    ntp_clean_counts counts = { 0, 0 };
    ntp_tally *tally = zeroed(ntp_tally_size()), *merged = zeroed(ntp_tally_size());
    CHECK(ntp_clean(&target, &from, &how, NULL, &counts, NULL) == NTP_OK);
    CHECK(ntp_validate(&flags, &from, 0, NULL) == NTP_OK);
    CHECK(ntp_tally_add(tally, &from, 0, NULL) == NTP_OK);

    band bands[THREADS];
    memset(bands, 0, sizeof bands);
    for (int i = 0; i < THREADS; i++) {
        band *b = &bands[i];
        b->dst = ntp_image_packed(dst, WIDTH, HEIGHT, 3, NTP_TYPE_U8);
        b->mask = ntp_image_packed(mask, WIDTH, HEIGHT, 1, NTP_TYPE_U8);
        b->src = from;
        b->how = &how;
        b->plan = plan;
        b->tally = zeroed(ntp_tally_size());
        b->index = i;
        CHECK(pthread_create(&b->thread, NULL, work, b) == 0);
    }
    uint64_t changed = 0;
    for (int i = THREADS - 1; i >= 0; i--) {
        CHECK(pthread_join(bands[i].thread, NULL) == 0);
        CHECK(ntp_tally_merge(merged, bands[i].tally) == NTP_OK);
        changed += bands[i].counts.changed;
        system_aligned_free(bands[i].tally);
    }
    CHECK(changed == counts.changed);
    CHECK(memcmp(dst, whole, sizeof dst) == 0);
    CHECK(memcmp(mask, whole_mask, sizeof mask) == 0);
    ntp_stats one, many;
    memset(&one, 0, sizeof one);
    memset(&many, 0, sizeof many);
    CHECK(ntp_tally_summarize(&one, tally, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(ntp_tally_summarize(&many, merged, NTP_ENCODING_STANDARD) == NTP_OK);
    CHECK(one.texels == (uint64_t) WIDTH * HEIGHT);
    /* Both were zero-filled, padding included.  NOLINTNEXTLINE */
    CHECK(memcmp(&one, &many, sizeof one) == 0);
    system_aligned_free(tally);
    system_aligned_free(merged);
    system_aligned_free(memory);
    return 0;
}
