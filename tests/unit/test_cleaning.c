/* SPDX-License-Identifier: MIT */
/*
 * test_cleaning.c - packed textures are cleaned as the integers of level.h say, with every instruction set
 *
 * Rows of any width between guard pages, in place or not, of runs of texels that are any, derived, too long,
 * black, white or transparent; and how many of them changed.  In long rows kernels leave some in doubt.
 */
#include "guarded.h"
#include "libntp.h"
#include "texel/level.h"
#include "texel/unused.h"
#include "without_avx2.h"
#include "without_avx512.h"

#include <stdlib.h>
#include <string.h>

enum { SETS = 3 /* of instructions */, TIMES = 4000, WIDEST = 700, LONG_ROWS = 6 };

typedef enum kind { ANY, DERIVED, TOO_LONG, GRAY, CLEAR, KINDS } kind;

static int32_t get(const void *p, ntp_type type, size_t i)
{
    return type == NTP_TYPE_U8 ? ((const uint8_t *) p)[i] : ((const uint16_t *) p)[i];
}

static void put(void *p, ntp_type type, size_t i, int32_t level)
{
    if (type == NTP_TYPE_U8)
        ((uint8_t *) p)[i] = (uint8_t) level;
    else
        ((uint16_t *) p)[i] = (uint16_t) level;
}

static void make_texel(int32_t c[4], kind k, int32_t m, bool zzero, uint64_t *seed)
{
    int64_t rest;
    do {
        for (int32_t i = 0; i < 4; i++)
            c[i] = random_level(seed, m);
        rest = ntp__rest(c[0], c[1], m);
    } while ((k == DERIVED && rest < 0) || (k == TOO_LONG && rest >= 0));
    if (k == DERIVED)
        c[2] = ntp__blue_of_rest(rest, m, zzero);
    if (k == GRAY)
        c[0] = c[1] = c[2] = random_bits(seed) % 8 == 0 ? c[2] : random_bits(seed) & 1 ? m : 0;
    if (k == CLEAR)
        c[3] = random_bits(seed) & 1 ? 0 : c[3];
}

static void make_row(const ntp_image *row, int kinds, uint64_t *seed)
{
    const bool zzero = row->encoding == NTP_ENCODING_ZZERO;
    const size_t channels = (size_t) row->channels;
    kind k = ANY;
    for (size_t i = 0; i < (size_t) row->width; i++) {
        int32_t c[4];
        if (i == 0 || random_bits(seed) % 40 == 0)
            k = (kind) (random_bits(seed) % KINDS);
        while (!(kinds >> k & 1))
            k = (k + 1) % KINDS;
        make_texel(c, k, row->type == NTP_TYPE_U8 ? 255 : 65535, zzero, seed);
        for (size_t j = 0; j < channels; j++)
            put(row->data, row->type, i * channels + j, c[j]);
    }
}

/* Returns how many texels change. */
static uint64_t clean_each(const ntp_image *row, const ntp_clean_options *how)
{
    const int32_t m = row->type == NTP_TYPE_U8 ? 255 : 65535;
    uint64_t changed = 0;
    for (size_t i = 0; i < (size_t) row->width; i++) {
        int32_t c[4] = { 0, 0, 0, m };
        bool same = true;
        for (int32_t k = 0; k < row->channels; k++)
            c[k] = get(row->data, row->type, i * (size_t) row->channels + (size_t) k);
        if (!ntp__unused(c[0], c[1], c[2], c[3], m, how->touch_unused))
            ntp__clean(c, m, row->encoding, how->method, false);
        for (size_t k = 0; k < 3; k++) {
            const size_t at = i * (size_t) row->channels + k;
            same = same && get(row->data, row->type, at) == c[k];
            put(row->data, row->type, at, c[k]);
        }
        changed += !same;
    }
    return changed;
}

static void clean(const ntp_image *dst, const ntp_image *src, const ntp_clean_options *how,
                  const ntp_clean_plan *plan, const ntp_image *want, uint64_t changed)
{
    const size_t size = (size_t) src->row_stride;
    const ntp_const_image from = ntp_image_as_const(src);
    ntp_clean_counts counts = { 0, 0 };
    CHECK(ntp_clean(dst, &from, how, plan, &counts, NULL) == NTP_OK);
    CHECK(memcmp(dst->data, want->data, size) == 0);
    CHECK(counts.changed == changed && counts.not_finite == 0);
}

static void check(ntp_image row, const ntp_clean_options *how, int kinds, ntp_clean_plan *memory,
                  uint64_t *seed)
{
    const size_t size = (size_t) row.row_stride;
    guarded rows[3];
    ntp_image src = row, dst = row, want = row;
    ntp_clean_plan *plan = NULL;
    for (int32_t i = 0; i < 3; i++)
        rows[i] = guarded_alloc(size, random_bits(seed) & 1);
    src.data = rows[0].data;
    dst.data = rows[1].data;
    want.data = rows[2].data;
    make_row(&src, kinds, seed);
    memcpy(want.data, src.data, size);
    const uint64_t changed = clean_each(&want, how);
    CHECK(ntp_clean_plan_init(&plan, memory, ntp_clean_plan_size(), row.encoding, how) == NTP_OK);
    for (int32_t i = 0; i < SETS; i++) {
        allowed = i > 0;
        allowed_512 = i == 2;
        memset(dst.data, 0, size);
        clean(&dst, &src, how, NULL, &want, changed);
        memcpy(dst.data, src.data, size);
        clean(&dst, &dst, how, NULL, &want, changed);
        memset(dst.data, 0, size);
        clean(&dst, &src, how, plan, &want, changed);
    }
    for (int32_t i = 0; i < 3; i++)
        guarded_free(&rows[i]);
}

int main(void)
{
    ntp_clean_plan *const memory = malloc(ntp_clean_plan_size());
    uint64_t seed = 31415;
    CHECK(memory != NULL);
    for (int32_t i = 0; i < TIMES; i++) {
        const ntp_type type = random_bits(&seed) % 4 == 0 ? NTP_TYPE_U8 : NTP_TYPE_U16;
        const int32_t width = 1 + (int32_t) (random_bits(&seed) % WIDEST);
        ntp_image row =
            ntp_image_packed(NULL, width, 1, 3 + (int32_t) (random_bits(&seed) % 2), type);
        const ntp_clean_options how = { .method = random_bits(&seed) % 2 != 0 ? NTP_CLEAN_DERIVE
                                                                              : NTP_CLEAN_NORMALIZE,
                                        .touch_unused = random_bits(&seed) % (NTP_UNUSED_ALL + 1) };
        row.encoding = random_bits(&seed) % 3 == 0 ? NTP_ENCODING_ZZERO : NTP_ENCODING_STANDARD;
        check(row, &how, 1 + (int) (random_bits(&seed) % ((1 << KINDS) - 1)), memory, &seed);
    }
    for (int32_t i = 0; i < LONG_ROWS; i++) {
        const ntp_clean_options how = { .method = NTP_CLEAN_DERIVE };
        check(ntp_image_packed(NULL, NTP_MAX_SIDE, 1, 3, NTP_TYPE_U16), &how, 1 << TOO_LONG, memory,
              &seed);
    }
    free(memory);
    return 0;
}
