/* SPDX-License-Identifier: MIT */
/*
 * test_png_filter.c - row filters, done and undone, with SIMD as in plain C
 */
#include <stdlib.h>
#include <string.h>

#include "chance.h"
#include "made.h"
#include "png_filter.h"

#define NTPIO_NO_SIMD
#define ntpio__unfilter      unfilter_plainly
#define ntpio__filter        filter_plainly
#define ntpio__filter_sums   filter_sums_plainly
#define ntpio__unfilter_rows unfilter_rows_plainly
void unfilter_plainly(uint8_t *row, const uint8_t *above, size_t size, size_t texel, int kind);
void filter_plainly(uint8_t *out, const uint8_t *row, const uint8_t *above, size_t size,
                    size_t texel, int kind);
void filter_sums_plainly(const uint8_t *row, const uint8_t *above, size_t size, size_t texel,
                         uint64_t *of_kinds);
uint32_t unfilter_rows_plainly(uint8_t *row, ptrdiff_t stride, uint32_t count, const uint8_t *above,
                               size_t size, size_t texel, const int *kinds);
#include "../../io/png_filter.c" // NOLINT(bugprone-suspicious-include)
#undef ntpio__unfilter
#undef ntpio__filter
#undef ntpio__filter_sums
#undef ntpio__unfilter_rows

enum { SIDE = 40 };

static void test_filters(void)
{
    static const size_t texels[] = { 1, 2, 3, 4, 6, 8 };
    uint8_t above[SIDE * 8], fast[SIDE * 8], slow[SIDE * 8];
    for (uint32_t n = 0; n < 60000; n++) {
        const size_t texel = texels[chance(6)], size = texel * (1 + chance(SIDE));
        const int kind = (int) chance(NTPIO__FILTERS);
        const uint32_t values = once_in(2) ? 4 : 256;
        for (size_t i = 0; i < size; i++) {
            above[i] = (uint8_t) chance(values);
            fast[i] = slow[i] = (uint8_t) chance(values);
        }
        const uint8_t *over = once_in(8) ? NULL : above;
        ntpio__unfilter(fast, over, size, texel, kind);
        unfilter_plainly(slow, over, size, texel, kind);
        CHECK(memcmp(fast, slow, size) == 0);
    }
}

/* Rows that are undone together, as many as are there: the same as one by one, and no byte around
 * them changes. */
static void test_rows_together(void)
{
    static const size_t texels[] = { 1, 2, 3, 4, 6, 8 };
    enum { ROWS = 6, AROUND = 16, MOST = ROWS * (SIDE * 8 + 1) + 2 * AROUND };
    static uint8_t fast[MOST], slow[MOST], above[SIDE * 8];
    for (uint32_t n = 0; n < 60000; n++) {
        const size_t texel = texels[chance(6)], size = texel * (1 + chance(SIDE));
        const uint32_t values = once_in(2) ? 4 : 256, other = 1 + chance(8);
        const uint32_t often = NTPIO__FILTERS - 1 - chance(2); /* Paeth or Average */
        const uint8_t *over = once_in(8) ? NULL : above;
        for (size_t i = 0; i < MOST; i++)
            fast[i] = slow[i] = (uint8_t) chance(values);
        for (size_t i = 0; i < size; i++)
            above[i] = (uint8_t) chance(values);
        for (size_t y = 0; y < ROWS; y++) {
            uint8_t *kind = fast + AROUND + y * (size + 1);
            *kind = (uint8_t) (once_in(other) ? chance(NTPIO__FILTERS) : often);
            slow[kind - fast] = *kind;
        }
        for (size_t y = 0; y < ROWS;) {
            uint8_t *row = fast + AROUND + y * (size + 1);
            const uint32_t left = ROWS - (uint32_t) y, count = 1 + chance(left);
            int kinds[ROWS];
            for (size_t k = 0; k < count; k++)
                kinds[k] = row[k * (size + 1)];
            const size_t done =
                ntpio__unfilter_rows(row + 1, (ptrdiff_t) size + 1, count,
                                     y == 0 ? over : row - size, size, texel, kinds);
            CHECK(done <= count);
            CHECK(done >= 1 && done <= ROWS - y);
            y += done;
        }
        for (size_t y = 0; y < ROWS; y++) {
            uint8_t *row = slow + AROUND + y * (size + 1);
            unfilter_plainly(row + 1, y == 0 ? over : row - size, size, texel, *row);
        }
        CHECK(memcmp(fast, slow, MOST) == 0);
    }
}

/* What is done is undone, both ways are the same, and the sums are those of the bytes. */
static void test_filters_done(void)
{
    static const size_t texels[] = { 1, 2, 3, 4, 6, 8 };
    enum { LEAD = NTPIO__TEXEL_MAX };
    uint8_t above[LEAD + SIDE * 8] = { 0 }, row[LEAD + SIDE * 8] = { 0 };
    uint8_t fast[SIDE * 8 + 1], slow[SIDE * 8];
    for (uint32_t n = 0; n < 60000; n++) {
        const size_t texel = texels[chance(6)], size = texel * (1 + chance(SIDE));
        const int kind = (int) chance(NTPIO__FILTERS);
        const uint32_t values = once_in(2) ? 4 : 256;
        const bool first = once_in(8);
        for (size_t i = 0; i < size; i++) {
            above[LEAD + i] = first ? 0 : (uint8_t) chance(values);
            row[LEAD + i] = (uint8_t) chance(values);
        }
        uint64_t sums[NTPIO__FILTERS], plain_sums[NTPIO__FILTERS];
        fast[size] = (uint8_t) n;
        ntpio__filter(fast, row + LEAD, above + LEAD, size, texel, kind);
        CHECK(fast[size] == (uint8_t) n);
        filter_plainly(slow, row + LEAD, above + LEAD, size, texel, kind);
        CHECK(memcmp(fast, slow, size) == 0);
        ntpio__filter_sums(row + LEAD, above + LEAD, size, texel, sums);
        filter_sums_plainly(row + LEAD, above + LEAD, size, texel, plain_sums);
        CHECK(memcmp(sums, plain_sums, sizeof sums) == 0);
        uint64_t away = 0;
        for (size_t i = 0; i < size; i++)
            away += (uint64_t) abs((int8_t) fast[i]);
        CHECK(away == sums[kind]);
        unfilter_plainly(slow, first ? NULL : above + LEAD, size, texel, kind);
        CHECK(memcmp(slow, row + LEAD, size) == 0);
    }
}

int main(void)
{
    test_filters();
    test_rows_together();
    test_filters_done();
    return 0;
}
