/* SPDX-License-Identifier: MIT */
/*
 * png_filter.c - the row filters of PNG, done and undone
 *
 * When they are undone, each texel waits for the one to its left, so the work in one texel decides
 * the speed: with SSE2 all its bytes are undone together.  When they are done, nothing waits, and
 * SSE2 does 16 bytes at once.  Plain C gives the same bytes.
 */
#include "png_filter.h"

#include <stdlib.h>
#include <string.h>

#if defined __SSE2__ && defined __x86_64__ && !defined NTPIO_NO_SIMD
#  define IN_REGISTERS
#  include <emmintrin.h>
#endif

enum { NONE, SUB, UP, AVERAGE, PAETH };

/* Of a, b and c the one that is nearest to a + b - c; of equals the first. */
static inline int paeth(int a, int b, int c)
{
    const int to_a = abs(b - c), to_b = abs(a - c), to_c = abs(a + b - 2 * c);
    return to_a <= to_b && to_a <= to_c ? a : to_b <= to_c ? b : c;
}

/* ---------------------------------------------------------------------------- texels */

#ifdef IN_REGISTERS

typedef __m128i bytes; /* of a texel, in the low half; the rest is anything */

/* In two parts at most, which stay in registers. */
static inline bytes load(const uint8_t *from, size_t texel)
{
    const size_t whole = texel >= 4 ? 4 : texel >= 2 ? 2 : 1, rest = texel - whole;
    uint32_t low = 0, high = 0;
    memcpy(&low, from, whole);
    memcpy(&high, from + whole, rest);
    return _mm_cvtsi64_si128((long long) (low | (uint64_t) high << 8 * whole));
}

static inline void store(uint8_t *to, bytes value, size_t texel)
{
    const size_t whole = texel >= 4 ? 4 : texel >= 2 ? 2 : 1, rest = texel - whole;
    const uint64_t all = (uint64_t) _mm_cvtsi128_si64(value);
    const uint64_t above = all >> 8 * whole;
    memcpy(to, &all, whole);
    memcpy(to + whole, &above, rest);
}

static inline bytes undo_sub(bytes value, bytes a)
{
    return _mm_add_epi8(value, a);
}

static inline bytes average(bytes a, bytes b)
{
    const bytes odd = _mm_and_si128(_mm_xor_si128(a, b), _mm_set1_epi8(1)); /* avg rounds up */
    return _mm_sub_epi8(_mm_avg_epu8(a, b), odd);
}

static inline bytes undo_average(bytes value, bytes a, bytes b)
{
    return _mm_add_epi8(value, average(a, b));
}

static inline __m128i absolute(__m128i v)
{
    return _mm_max_epi16(v, _mm_sub_epi16(_mm_setzero_si128(), v));
}

static inline __m128i choose(__m128i mask, __m128i yes, __m128i no)
{
    return _mm_or_si128(_mm_and_si128(mask, yes), _mm_andnot_si128(mask, no));
}

/* Of eight numbers of 16 bits.  Of a, b and c the one that is nearest to a + b - c. */
static inline __m128i paeth16(__m128i a16, __m128i b16, __m128i c16)
{
    const __m128i b_c = _mm_sub_epi16(b16, c16), a_c = _mm_sub_epi16(a16, c16);
    const __m128i to_a = absolute(b_c), to_b = absolute(a_c);
    const __m128i to_c = absolute(_mm_add_epi16(b_c, a_c));
    const __m128i least = _mm_min_epi16(to_c, _mm_min_epi16(to_a, to_b));
    const __m128i b_or_c = choose(_mm_cmpeq_epi16(least, to_b), b16, c16);
    return choose(_mm_cmpeq_epi16(least, to_a), a16, b_or_c);
}

static inline bytes undo_paeth(bytes value, bytes a, bytes b, bytes c)
{
    const __m128i zero = _mm_setzero_si128();
    const __m128i nearest =
        paeth16(_mm_unpacklo_epi8(a, zero), _mm_unpacklo_epi8(b, zero), _mm_unpacklo_epi8(c, zero));
    return _mm_add_epi8(value, _mm_packus_epi16(nearest, nearest));
}

static inline bytes no_texel(void)
{
    return _mm_setzero_si128();
}

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

/* A row in texels of a size that the compiler knows. */
static inline void undo_left(uint8_t *row, const uint8_t *above, size_t size, size_t texel,
                             int kind)
{
    bytes a = no_texel(), c = no_texel();
    for (size_t i = 0; i < size; i += texel) {
        const bytes value = load(row + i, texel);
        if (kind == SUB) {
            a = undo_sub(value, a);
        } else {
            const bytes b = load(above + i, texel);
            a = kind == AVERAGE ? undo_average(value, a, b) : undo_paeth(value, a, b, c);
            c = b;
        }
        store(row + i, a, texel);
    }
}

static inline void undo_kind(uint8_t *row, const uint8_t *above, size_t size, size_t texel,
                             int kind)
{
    switch (kind) {
    case SUB:
        undo_left(row, above, size, texel, SUB);
        break;
    case AVERAGE:
        undo_left(row, above, size, texel, AVERAGE);
        break;
    default:
        undo_left(row, above, size, texel, PAETH);
        break;
    }
}

static void undo_up(uint8_t *row, const uint8_t *above, size_t size)
{
    size_t i = 0;
#ifdef IN_REGISTERS
    for (; i + 16 <= size; i += 16) {
        __m128i *at = (__m128i *) (void *) (row + i);
        const __m128i b = _mm_loadu_si128((const __m128i *) (const void *) (above + i));
        _mm_storeu_si128(at, _mm_add_epi8(_mm_loadu_si128(at), b));
    }
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

/* ---------------------------------------------------------------------------- done */

static inline int foretold(int a, int b, int c, int kind)
{
    return kind == NONE      ? 0
           : kind == SUB     ? a
           : kind == UP      ? b
           : kind == AVERAGE ? (a + b) / 2
                             : paeth(a, b, c);
}

#ifdef IN_REGISTERS

enum { AT_ONCE = 16 };

static inline __m128i load16(const uint8_t *from)
{
    return _mm_loadu_si128((const __m128i *) (const void *) from);
}

static inline __m128i foretold16(__m128i a, __m128i b, __m128i c, int kind)
{
    const __m128i zero = _mm_setzero_si128();
    if (kind == NONE || kind == SUB || kind == UP)
        return kind == NONE ? zero : kind == SUB ? a : b;
    if (kind == AVERAGE)
        return average(a, b);
    return _mm_packus_epi16(
        paeth16(_mm_unpacklo_epi8(a, zero), _mm_unpacklo_epi8(b, zero), _mm_unpacklo_epi8(c, zero)),
        paeth16(_mm_unpackhi_epi8(a, zero), _mm_unpackhi_epi8(b, zero),
                _mm_unpackhi_epi8(c, zero)));
}

/* As many bytes as fit in whole registers.  *sum: two sums. */
static inline size_t filter_most(uint8_t *out, const uint8_t *row, const uint8_t *above,
                                 size_t size, size_t texel, int kind, uint64_t *sum)
{
    const __m128i zero = _mm_setzero_si128();
    __m128i sums = zero;
    size_t i = 0;
    for (; i + AT_ONCE <= size; i += AT_ONCE) {
        const __m128i told =
            foretold16(load16(row + i - texel), load16(above + i), load16(above + i - texel), kind);
        const __m128i value = _mm_sub_epi8(load16(row + i), told);
        const __m128i away = _mm_min_epu8(value, _mm_sub_epi8(zero, value));
        _mm_storeu_si128((__m128i *) (void *) (out + i), value);
        sums = _mm_add_epi64(sums, _mm_sad_epu8(away, zero));
    }
    *sum = (uint64_t) _mm_cvtsi128_si64(sums) +
           (uint64_t) _mm_cvtsi128_si64(_mm_unpackhi_epi64(sums, sums));
    return i;
}

#else

static inline size_t filter_most(const uint8_t *out, const uint8_t *row, const uint8_t *above,
                                 size_t size, size_t texel, int kind, uint64_t *sum)
{
    (void) out, (void) row, (void) above, (void) size, (void) texel, (void) kind;
    *sum = 0;
    return 0;
}

#endif

/* The kind is known to the compiler. */
static inline uint64_t filter_kind(uint8_t *out, const uint8_t *row, const uint8_t *above,
                                   size_t size, size_t texel, int kind)
{
    uint64_t sum;
    for (size_t i = filter_most(out, row, above, size, texel, kind, &sum); i < size; i++) {
        const uint8_t *a = row + i - texel, *c = above + i - texel;
        const int value = (row[i] - foretold(*a, above[i], *c, kind)) & 255;
        out[i] = (uint8_t) value;
        sum += (uint64_t) (value < 128 ? value : 256 - value);
    }
    return sum;
}

uint64_t ntpio__filter(uint8_t *out, const uint8_t *row, const uint8_t *above, size_t size,
                       size_t texel, int kind)
{
    switch (kind) {
    case NONE:
        return filter_kind(out, row, above, size, texel, NONE);
    case SUB:
        return filter_kind(out, row, above, size, texel, SUB);
    case UP:
        return filter_kind(out, row, above, size, texel, UP);
    case AVERAGE:
        return filter_kind(out, row, above, size, texel, AVERAGE);
    default:
        return filter_kind(out, row, above, size, texel, PAETH);
    }
}
