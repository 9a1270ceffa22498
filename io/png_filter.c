/* SPDX-License-Identifier: MIT */
/*
 * png_filter.c - the row filters of PNG, done and undone
 *
 * When they are undone, each texel waits for the one to its left, so the work in one texel decides
 * the speed: with SSE2 or NEON all its bytes are undone together.  When they are done, nothing waits,
 * and these do 16 bytes at once, or 32 with AVX2 (png_filter_avx2.c), or 64 with AVX-512
 * (png_filter_avx512.c).  Plain C gives the same bytes.
 */
#include "png_filter.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "simd.h"

#if defined NTPIO_NO_SIMD
#elif defined __SSE2__ && defined __x86_64__
#  define IN_SSE2
#elif defined __ARM_NEON && defined __aarch64__ && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#  define IN_NEON
#endif
#if defined IN_SSE2 || defined IN_NEON
#  define IN_REGISTERS
#endif

/* The size of a texel is a constant in these only if they are part of their caller. */
#ifdef __GNUC__
#  define SIZE_KNOWN static inline __attribute__((always_inline))
#else
#  define SIZE_KNOWN static inline
#endif

enum { NONE, SUB, UP, AVERAGE, PAETH };
#ifdef IN_REGISTERS
enum { AT_ONCE = 16 };
#endif

/* Of a, b and c the one that is nearest to a + b - c; of equals the first. */
static inline int paeth(int a, int b, int c)
{
    const int to_a = abs(b - c), to_b = abs(a - c), to_c = abs(a + b - 2 * c);
    return to_a <= to_b && to_a <= to_c ? a : to_b <= to_c ? b : c;
}

/* ---------------------------------------------------------------------------- texels */

#if defined IN_SSE2
#  include "png_filter_sse2_tmpl.h"
#elif defined IN_NEON
#  include "png_filter_neon_tmpl.h"
#else

typedef struct bytes {
    uint8_t at[8];
} bytes;

static inline bytes load(const uint8_t *from, size_t texel)
{
    bytes value = { { 0 } };
    memcpy(value.at, from, texel);
    return value;
}

static inline void store(uint8_t *to, bytes value, size_t texel)
{
    memcpy(to, value.at, texel);
}

static inline bytes undo_sub(bytes value, bytes a)
{
    for (int i = 0; i < 8; i++)
        value.at[i] = (uint8_t) (value.at[i] + a.at[i]);
    return value;
}

static inline bytes undo_average(bytes value, bytes a, bytes b)
{
    for (int i = 0; i < 8; i++)
        value.at[i] = (uint8_t) (value.at[i] + (a.at[i] + b.at[i]) / 2);
    return value;
}

static inline bytes undo_paeth(bytes value, bytes a, bytes b, bytes c)
{
    for (int i = 0; i < 8; i++)
        value.at[i] = (uint8_t) (value.at[i] + paeth(a.at[i], b.at[i], c.at[i]));
    return value;
}

static inline bytes no_texel(void)
{
    return (bytes) { { 0 } };
}

#endif

/* ------------------------------------------------------------------------------ rows */

#ifdef IN_SSE2
#  include "png_unfilter_sse2_tmpl.h"
#else

/* Rows in texels of a size that the compiler knows. */
SIZE_KNOWN void undo_row(uint8_t *row, const uint8_t *above, size_t size, size_t texel, int kind)
{
    bytes a = no_texel(), c = no_texel();
    for (size_t i = 0; i < size; i += texel) {
        const bytes value = load(row + i, texel), b = kind == SUB ? c : load(above + i, texel);
        a = kind == SUB       ? undo_sub(value, a)
            : kind == AVERAGE ? undo_average(value, a, b)
                              : undo_paeth(value, a, b, c);
        c = b;
        store(row + i, a, texel);
    }
}

#endif

SIZE_KNOWN void undo_kind(uint8_t *row, const uint8_t *above, size_t size, size_t texel, int kind)
{
    switch (kind) {
    case SUB:
        undo_row(row, row, size, texel, SUB); /* there may be no row above */
        break;
    case AVERAGE:
        undo_row(row, above, size, texel, AVERAGE);
        break;
    default:
        undo_row(row, above, size, texel, PAETH);
        break;
    }
}

static void undo_up(uint8_t *row, const uint8_t *above, size_t size)
{
    size_t i = 0;
#ifdef IN_REGISTERS
    for (; i + AT_ONCE <= size; i += AT_ONCE)
        store16(row + i, add16(load16(row + i), load16(above + i)));
#endif
    for (; i < size; i++)
        row[i] = (uint8_t) (row[i] + above[i]);
}

/* Above the first row there are zeros. */
static void undo_first_average(uint8_t *row, size_t size, size_t texel)
{
    for (size_t i = texel; i < size; i++)
        row[i] = (uint8_t) (row[i] + row[i - texel] / 2);
}

void ntpio__unfilter(uint8_t *row, const uint8_t *above, size_t size, size_t texel, int kind)
{
    if (above == NULL) { /* then Up changes nothing, and Paeth is Sub */
        if (kind == AVERAGE)
            undo_first_average(row, size, texel);
        if (kind == AVERAGE || kind == UP)
            return;
        kind = kind == PAETH ? SUB : kind;
    }
    if (kind == NONE)
        return;
    if (kind == UP) {
        undo_up(row, above, size);
        return;
    }
    switch (texel) {
    case 1:
        undo_kind(row, above, size, 1, kind);
        break;
    case 2:
        undo_kind(row, above, size, 2, kind);
        break;
    case 3:
        undo_kind(row, above, size, 3, kind);
        break;
    case 4:
        undo_kind(row, above, size, 4, kind);
        break;
    case 6:
        undo_kind(row, above, size, 6, kind);
        break;
    default:
        undo_kind(row, above, size, 8, kind);
        break;
    }
}

#ifdef IN_SSE2

/* Two rows or four of a kind that the compiler knows. */
SIZE_KNOWN void undo_together(uint8_t *row, ptrdiff_t stride, uint32_t count, const uint8_t *above,
                              size_t size, size_t texel, int kind)
{
    if (count == FOUR)
        undo_four_rows(row, stride, above, size, texel, kind);
    else
        undo_two_rows(row, row + stride, above, size, texel, kind);
}

SIZE_KNOWN void undo_kinds(uint8_t *row, ptrdiff_t stride, uint32_t count, const uint8_t *above,
                           size_t size, size_t texel, int kind)
{
    if (kind == AVERAGE)
        undo_together(row, stride, count, above, size, texel, AVERAGE);
    else
        undo_together(row, stride, count, above, size, texel, PAETH);
}

/* So many rows that are undone together: four, two, or one. */
static uint32_t together(uint32_t count, size_t size, size_t texel, const int *kinds)
{
    enum { LEAST_TEXELS_OF_TWO = 4, LEAST_TEXELS_OF_FOUR = 8 };
    uint32_t same = 1;
    while (same < count && same < FOUR && kinds[same] == kinds[0])
        same++;
    if (kinds[0] != AVERAGE && kinds[0] != PAETH)
        return 1;
    if (same == FOUR && texel <= 4 && size >= LEAST_TEXELS_OF_FOUR * texel)
        return FOUR;
    return same > 1 && size >= LEAST_TEXELS_OF_TWO * texel ? 2 : 1;
}

#endif

uint32_t ntpio__unfilter_rows(uint8_t *row, ptrdiff_t stride, uint32_t count, const uint8_t *above,
                              size_t size, size_t texel, const int *kinds)
{
#ifdef IN_SSE2
    const uint32_t some = above != NULL ? together(count, size, texel, kinds) : 1;
    if (some > 1) {
        if (texel == 1)
            undo_kinds(row, stride, some, above, size, 1, kinds[0]);
        else if (texel == 2)
            undo_kinds(row, stride, some, above, size, 2, kinds[0]);
        else if (texel == 3)
            undo_kinds(row, stride, some, above, size, 3, kinds[0]);
        else if (texel == 4)
            undo_kinds(row, stride, some, above, size, 4, kinds[0]);
        else if (texel == 6)
            undo_kinds(row, stride, 2, above, size, 6, kinds[0]);
        else
            undo_kinds(row, stride, 2, above, size, 8, kinds[0]);
        return some;
    }
#else
    (void) stride, (void) count;
#endif
    ntpio__unfilter(row, above, size, texel, kinds[0]);
    return 1;
}

/* ---------------------------------------------------------------------------- done */

static inline int foretold(int a, int b, int c, int kind)
{
    return kind == NONE      ? 0
           : kind == SUB     ? a
           : kind == UP      ? b
           : kind == AVERAGE ? (a + b) / 2
                             : paeth(a, b, c);
}

/* The kind is known to the compiler. */
static inline void filter_kind(uint8_t *out, const uint8_t *row, const uint8_t *above, size_t from,
                               size_t size, size_t texel, int kind)
{
    size_t i = from;
#ifdef IN_REGISTERS
    for (; i + AT_ONCE <= size; i += AT_ONCE)
        store16(out + i,
                subtract16(load16(row + i), foretold16(load16(row + i - texel), load16(above + i),
                                                       load16(above + i - texel), kind)));
#endif
    for (; i < size; i++) {
        const uint8_t *a = row + i - texel, *c = above + i - texel;
        out[i] = (uint8_t) (row[i] - foretold(*a, above[i], *c, kind));
    }
}

void ntpio__filter(uint8_t *out, const uint8_t *row, const uint8_t *above, size_t size,
                   size_t texel, int kind)
{
    size_t done = 0;
#ifdef NTPIO_HAVE_AVX512
    if (ntpio__has_avx512())
        done = ntpio__filter_avx512(out, row, above, size, texel, kind);
#endif
#ifdef NTPIO_HAVE_AVX2
    if (done == 0 && ntpio__has_avx2())
        done = ntpio__filter_avx2(out, row, above, size, texel, kind);
#endif
    switch (kind) {
    case NONE:
        memcpy(out, row, size);
        break;
    case SUB:
        filter_kind(out, row, above, done, size, texel, SUB);
        break;
    case UP:
        filter_kind(out, row, above, done, size, texel, UP);
        break;
    case AVERAGE:
        filter_kind(out, row, above, done, size, texel, AVERAGE);
        break;
    default:
        filter_kind(out, row, above, done, size, texel, PAETH);
        break;
    }
}

#ifdef IN_REGISTERS

/* Of as many bytes as fit in whole registers; returns how many. */
static size_t sum_most(const uint8_t *row, const uint8_t *above, size_t size, size_t texel,
                       uint64_t *of_kinds)
{
    sums none = no_sums(), sub = none, up = none, mean = none, nearest = none;
    size_t i = 0;
    for (; i + AT_ONCE <= size; i += AT_ONCE) {
        const wide value = load16(row + i), a = load16(row + i - texel);
        const wide b = load16(above + i), c = load16(above + i - texel);
        none = add_distances(none, value);
        sub = add_distances(sub, subtract16(value, a));
        up = add_distances(up, subtract16(value, b));
        mean = add_distances(mean, subtract16(value, foretold16(a, b, c, AVERAGE)));
        nearest = add_distances(nearest, subtract16(value, foretold16(a, b, c, PAETH)));
    }
    of_kinds[NONE] = total(none);
    of_kinds[SUB] = total(sub);
    of_kinds[UP] = total(up);
    of_kinds[AVERAGE] = total(mean);
    of_kinds[PAETH] = total(nearest);
    return i;
}

#else

static size_t sum_most(const uint8_t *row, const uint8_t *above, size_t size, size_t texel,
                       uint64_t *of_kinds)
{
    (void) row, (void) above, (void) size, (void) texel;
    memset(of_kinds, 0, NTPIO__FILTERS * sizeof *of_kinds);
    return 0;
}

#endif

void ntpio__filter_sums(const uint8_t *row, const uint8_t *above, size_t size, size_t texel,
                        uint64_t *of_kinds)
{
    const uint8_t *const left = row - texel, *const corner = above - texel;
    size_t i = 0;
#ifdef NTPIO_HAVE_AVX512
    if (ntpio__has_avx512())
        i = ntpio__filter_sums_avx512(row, above, size, texel, of_kinds);
#endif
#ifdef NTPIO_HAVE_AVX2
    if (i == 0 && ntpio__has_avx2())
        i = ntpio__filter_sums_avx2(row, above, size, texel, of_kinds);
#endif
    if (i == 0)
        i = sum_most(row, above, size, texel, of_kinds);
    for (; i < size; i++) {
        for (int kind = NONE; kind <= PAETH; kind++) {
            const int told = foretold(left[i], above[i], corner[i], kind);
            const int value = (row[i] - told) & 255;
            of_kinds[kind] += (uint64_t) (value < 128 ? value : 256 - value);
        }
    }
}
