/* SPDX-License-Identifier: MIT */
/*
 * test_conversions.c - packed RGB is converted alike with and without AVX2 and AVX-512
 *
 * All texels of 8 bit, and of 16 bit random ones, exact ones, and those that rounding makes exact or too
 * long; all widths up to two blocks and some, between guard pages, and in place.  The loops without these
 * instructions are those that tests/test_convert.py compares with exact arithmetic.
 */
#include "guarded.h"
#include "without_avx2.h"
#include "without_avx512.h"
#include "libntp.h"

#include <math.h>
#include <string.h>

enum { WIDEST = 540, SETS = 3 /* of instructions */, LONG_ROW = 1 << 15, SKIPPED = 77 };

typedef struct conversion {
    ntp_encoding from, to;
    ntp_type into;
} conversion;

static size_t bytes_of(int32_t n, ntp_type type)
{
    return (size_t) n * (type == NTP_TYPE_U8 ? 3 : 6);
}

static void convert(void *to, const void *from, int32_t n, ntp_type type, const conversion *how,
                    ntp_convert_counts *counts)
{
    const ntp_image dst = { .data = to,
                            .width = n,
                            .height = 1,
                            .channels = 3,
                            .type = how->into,
                            .pixel_stride = (ptrdiff_t) bytes_of(1, how->into),
                            .row_stride = (ptrdiff_t) bytes_of(n, how->into),
                            .encoding = how->to };
    ntp_const_image src = ntp_image_as_const(&dst);
    src.data = from;
    src.type = type;
    src.pixel_stride = (ptrdiff_t) bytes_of(1, type);
    src.row_stride = (ptrdiff_t) bytes_of(n, type);
    src.encoding = how->from;
    memset(counts, 0, sizeof *counts);
    CHECK(ntp_convert(&dst, &src, NULL, counts, NULL) == NTP_OK);
}

/* Every conversion of these texels, with each set of instructions. */
static void check(const void *texels, int32_t n, ntp_type type, bool at_start)
{
    const size_t size = bytes_of(n, type);
    const guarded src = guarded_alloc(size, at_start);
    memcpy(src.data, texels, size);
    for (int k = 0; k < 8; k++) {
        const conversion how = { k & 1 ? NTP_ENCODING_ZZERO : NTP_ENCODING_STANDARD,
                                 k & 2 ? NTP_ENCODING_ZZERO : NTP_ENCODING_STANDARD,
                                 k & 4 ? NTP_TYPE_U16 : NTP_TYPE_U8 };
        guarded dst[SETS];
        ntp_convert_counts counts[SETS];
        for (int i = 0; i < SETS; i++) {
            allowed = i > 0;
            allowed_512 = i == 2;
            dst[i] = guarded_alloc(bytes_of(n, how.into), at_start);
            convert(dst[i].data, src.data, n, type, &how, &counts[i]);
            CHECK(memcmp(dst[i].data, dst[0].data, bytes_of(n, how.into)) == 0);
            CHECK(memcmp(&counts[i], &counts[0], sizeof counts[0]) == 0);
        }
        if (how.into == type) {
            memcpy(dst[1].data, texels, size);
            convert(dst[1].data, dst[1].data, n, type, &how, &counts[1]);
            CHECK(memcmp(dst[1].data, dst[0].data, size) == 0);
            CHECK(memcmp(&counts[1], &counts[0], sizeof counts[0]) == 0);
        }
        for (int i = 0; i < SETS; i++)
            guarded_free(&dst[i]);
    }
    guarded_free(&(guarded) { src.map, src.length, src.data });
}

static void check_all_of_8_bit(void)
{
    uint8_t *row = malloc(bytes_of(LONG_ROW, NTP_TYPE_U8));
    CHECK(row != NULL);
    for (int32_t b = 0; b < 512; b++) {
        for (int32_t i = 0; i < LONG_ROW; i++) {
            row[3 * i] = (uint8_t) ((b & 1) << 7 | i >> 8);
            row[3 * i + 1] = (uint8_t) i;
            row[3 * i + 2] = (uint8_t) (b >> 1);
        }
        check(row, LONG_ROW, NTP_TYPE_U8, false);
    }
    free(row);
}

/* Levels anywhere; blues that are derived, or nearly; and that at the rim of the disc, where many
 * become too long.  Of the last two one in 256 is black, and in parts of the row they are exact. */
enum { RANDOM, EXACT, RIM, KINDS };

/* A level for |v| = size/m, with this sign. */
static int32_t level_of(double size, int32_t m, bool minus)
{
    const int32_t level = (m + 1) / 2 + (int32_t) (size / 2);
    return minus ? m - level : level > m ? m : level;
}

static void make_texel(int32_t c[3], int kind, int32_t m, bool exact, uint64_t *seed)
{
    for (int k = 0; k < 3; k++)
        c[k] = random_level(seed, m);
    if (kind == RANDOM)
        return;
    const double x = 2.0 * c[0] - m, full = (double) m * m;
    if (kind == RIM) {
        const double rest = full - x * x;
        const int32_t off = (int32_t) (random_bits(seed) % 9) - 4;
        const int32_t g = level_of(sqrt(rest), m, (random_bits(seed) & 1) != 0);
        c[1] = g + off < 0 ? 0 : g + off > m ? m : g + off;
    }
    const double y = 2.0 * c[1] - m, rest = full - x * x - y * y;
    const bool far = !exact && (random_bits(seed) & 1) != 0;
    const int32_t off = far ? (int32_t) (random_bits(seed) % 5) - 2 : 0;
    const bool zzero = (random_bits(seed) & 1) != 0;
    const int32_t b = rest < 0 ? c[2]
                      : zzero  ? (int32_t) (sqrt(rest) + 0.5)
                               : level_of(sqrt(rest), m, (random_bits(seed) & 1) != 0);
    c[2] = b + off < 0 ? 0 : b + off > m ? m : b + off;
    if (!exact && random_bits(seed) % 256 == 0)
        c[0] = c[1] = c[2] = 0;
}

static void make_row(void *to, int32_t n, ntp_type type, int kind, uint64_t *seed)
{
    const int32_t m = type == NTP_TYPE_U8 ? 255 : 65535;
    bool exact = false;
    for (int32_t i = 0; i < n; i++) {
        int32_t c[3];
        exact = i % 100 == 0 ? (random_bits(seed) & 1) != 0 : exact;
        make_texel(c, kind, m, exact, seed);
        for (int k = 0; k < 3; k++) {
            if (type == NTP_TYPE_U8)
                ((uint8_t *) to)[3 * i + k] = (uint8_t) c[k];
            else
                ((uint16_t *) to)[3 * i + k] = (uint16_t) c[k];
        }
    }
}

int main(void)
{
    uint64_t seed = 1;
    allowed = true;
    if (!ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    void *row = malloc(bytes_of(LONG_ROW, NTP_TYPE_U16));
    CHECK(row != NULL);
    for (int kind = 0; kind < KINDS; kind++) {
        for (int32_t n = 1; n <= WIDEST; n++) {
            make_row(row, n, NTP_TYPE_U8, kind, &seed);
            check(row, n, NTP_TYPE_U8, kind == EXACT);
            make_row(row, n, NTP_TYPE_U16, kind, &seed);
            check(row, n, NTP_TYPE_U16, kind == EXACT);
        }
        for (int k = 0; k < 64; k++) {
            make_row(row, LONG_ROW, NTP_TYPE_U16, kind, &seed);
            check(row, LONG_ROW, NTP_TYPE_U16, false);
        }
    }
    free(row);
    check_all_of_8_bit();
    return 0;
}
