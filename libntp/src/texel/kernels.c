/* SPDX-License-Identifier: MIT */
/*
 * kernels.c - loops over texels, compiled once for each instruction set with -DNTP_ISA=...
 *
 * With a = r - K, K = (M + 1)/2, the odd numerator is X = 2a + 1 and X*X = 4a(a + 1) + 1; with
 * k = (|X| + 1)/2 also X*X = 4k(k - 1) + 1.  Working with a(a + 1) and k keeps all sums of
 * three squares, and of their neighbors k - 1 and k + 1, within 32 bits at M = 65535.
 */
#include "texel/kernels.h"

#include "base/inlining.h"
#include "texel/angle.h"
#include "texel/cells.h"
#include "texel/judged.h"
#include "texel/root30.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#define CONCAT_(a, b) a##b
#define CONCAT(a, b)  CONCAT_(a, b)

/* Loops in float for 8 bit beside those in double: not where they would only make the library greater
 * for processors from before 2013. */
#if defined(__AVX2__) || !defined(NTP_HAVE_AVX2)
enum { FLOATS = 1 };
#else
enum { FLOATS = 0 };
#endif

static inline bool little_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

static inline uint32_t load16le(const uint8_t *p)
{
    uint16_t v;
    memcpy(&v, p, 2);
    return little_endian() ? v : (uint32_t) (v >> 8 | (v & 255) << 8);
}

static inline uint32_t load32le(const uint8_t *p)
{
    uint32_t v;
    memcpy(&v, p, 4);
    return little_endian() ? v : load16le(p) | load16le(p + 2) << 16;
}

static inline uint64_t load64le(const uint8_t *p)
{
    uint64_t v;
    memcpy(&v, p, 8);
    return little_endian() ? v : load32le(p) | (uint64_t) load32le(p + 4) << 32;
}

static inline void store32le(uint8_t *p, uint32_t v)
{
    if (little_endian()) {
        memcpy(p, &v, 4);
        return;
    }
    for (int i = 0; i < 4; i++)
        p[i] = (uint8_t) (v >> 8 * i);
}

static inline void store64le(uint8_t *p, uint64_t v)
{
    if (little_endian()) {
        memcpy(p, &v, 8);
        return;
    }
    store32le(p, (uint32_t) v);
    store32le(p + 4, (uint32_t) (v >> 32));
}

enum {
    RGB = 0xffffff,
    LANES =
        NTP__KERNEL_LANES /* most loops over planes do a multiple, so that they have no remainder */
};

static inline uint32_t load24le(const uint8_t *p)
{
    return load16le(p) | (uint32_t) p[2] << 16;
}

static inline uint32_t clean_one(uint32_t v, const uint32_t *table, uint32_t kept, uint32_t touch)
{
    uint32_t color = v & RGB;
    if ((color == 0 && !(touch & NTP_UNUSED_BLACK)) ||
        (color == RGB && !(touch & NTP_UNUSED_WHITE)))
        return v;
    return (table[v & 0xffff] & RGB & ~kept) | (v & kept);
}

static uint64_t clean_rgb8_slowly(uint8_t *dst, const uint8_t *src, size_t n, const uint32_t *table,
                                  uint32_t kept, uint32_t touch_unused)
{
    uint64_t changed = 0;
    for (size_t i = 0; i < n; i++, src += 3, dst += 3) {
        uint32_t v = load24le(src), t = clean_one(v, table, kept, touch_unused);
        changed += t != v;
        dst[0] = (uint8_t) t;
        dst[1] = (uint8_t) (t >> 8);
        dst[2] = (uint8_t) (t >> 16);
    }
    return changed;
}

#ifdef __AVX2__
#  include "texel/find_four_tmpl.h"

#  include "texel/packed_avx2_tmpl.h"

#  include <immintrin.h>

/* The places i to i + 3 of which the mask has a bit; returns how many.  Branches would be taken at
 * random. */
static inline int32_t find_four(int32_t *at, int32_t i, int mask)
{
    int32_t which;
    memcpy(&which, SET[mask], sizeof which);
    const __m128i places =
        _mm_add_epi32(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(which)), _mm_set1_epi32(i));
    _mm_storeu_si128((__m128i *) (void *) at, places);
    return (int32_t) (COUNTS >> 4 * mask & 15);
}
#endif

#include "texel/clean8_tmpl.h"

/* Four pixels a step.  The results go into two stores that no later load overlaps.  When dst is
 * src, a store of four bytes for each pixel would stall the loads that follow. */
static inline void clean_by_pairs(uint8_t *dst, const uint8_t *src, size_t n, const uint32_t *table,
                                  uint32_t touch_unused, uint64_t *changed)
{
    for (; n >= 4; n -= 4, src += 12, dst += 12) {
        uint32_t t[4];
        UNROLLED
        for (int i = 0; i < 4; i++)
            t[i] = table[load16le(src + 3 * i)];
        if ((t[0] | t[1] | t[2] | t[3]) >> 24) {
            for (int i = 0; i < 4; i++)
                t[i] = clean_one(load24le(src + 3 * i), table, 0, touch_unused);
        }
        const uint64_t first = (uint64_t) t[0] | (uint64_t) t[1] << 24 | (uint64_t) t[2] << 48;
        const uint32_t last = t[2] >> 16 | t[3] << 8;
        if (changed != NULL) {
            const uint64_t a = load64le(src) ^ first;
            const uint32_t b = load32le(src + 8) ^ last;
            *changed += (uint64_t) ((a & RGB) != 0) + (uint64_t) ((a >> 24 & RGB) != 0) +
                        (uint64_t) ((a >> 48 | (b & 255)) != 0) + (uint64_t) (b >> 8 != 0);
        }
        store64le(dst, first);
        store32le(dst + 8, last);
    }
    uint64_t others = clean_rgb8_slowly(dst, src, n, table, 0, touch_unused);
    if (changed != NULL)
        *changed += others;
}

static inline void clean_rgb8(uint8_t *dst, const uint8_t *src, size_t n, const uint32_t *table,
                              const uint8_t *blue, uint32_t touch_unused, uint64_t *changed)
{
    size_t done = blue == NULL ? 0 : clean_blues(dst, src, n, table, blue, touch_unused, changed);
    clean_by_pairs(dst + 3 * done, src + 3 * done, n - done, table, touch_unused, changed);
}

static uint64_t clean_rgb8_counting(uint8_t *dst, const uint8_t *src, size_t n,
                                    const uint32_t *table, const uint8_t *blue, uint32_t kept,
                                    uint32_t touch_unused)
{
    uint64_t changed = 0;
    if (kept != 0)
        return clean_rgb8_slowly(dst, src, n, table, kept, touch_unused);
    clean_rgb8(dst, src, n, table, blue, touch_unused, &changed);
    return changed;
}

#ifdef NTP_HAVE_AVX2
#  define clean_rgb8_blindly clean_rgb8_counting /* to count is as fast, or the processor is old */
#else
static uint64_t clean_rgb8_blindly(uint8_t *dst, const uint8_t *src, size_t n,
                                   const uint32_t *table, const uint8_t *blue, uint32_t kept,
                                   uint32_t touch_unused)
{
    if (kept != 0)
        return clean_rgb8_slowly(dst, src, n, table, kept, touch_unused);
    clean_rgb8(dst, src, n, table, blue, touch_unused, NULL);
    return 0;
}
#endif

/* A pixel with alpha by the table. */
static inline uint32_t clean_one_rgba8(uint32_t v, const uint32_t *table, uint32_t kept,
                                       uint32_t touch_unused)
{
    const uint32_t transparent = touch_unused & NTP_UNUSED_TRANSPARENT ? 0 : 1;
    const uint32_t t = table[v & 0xffff];
    if (v >> 24 < transparent)
        return v;
    if (t >> 24)
        return clean_one(v, table, kept, touch_unused) | (v & ~(uint32_t) RGB);
    return (t & RGB & ~kept) | (v & (kept | ~(uint32_t) RGB));
}

static inline uint64_t clean_rgba8_by_table(uint8_t *dst, const uint8_t *src, size_t n,
                                            const uint32_t *table, uint32_t kept,
                                            uint32_t touch_unused)
{
    uint64_t changed = 0;
    for (size_t i = 0; i < n; i++, src += 4, dst += 4) {
        const uint32_t v = load32le(src), t = clean_one_rgba8(v, table, kept, touch_unused);
        changed += t != v;
        store32le(dst, t);
    }
    return changed;
}

#ifdef __AVX2__
/* Whole steps of pixels with alpha: derives blues, and does the pixels that need more by the table, after all
 * others.  *left is how many these were, in the steps before: while many are looked up, a processor does
 * not fetch the next ones by itself. */
static uint64_t derive_rgba8(uint8_t *dst, const uint8_t *src, int32_t n, const uint32_t *table,
                             uint32_t touch_unused, int32_t *left)
{
    const uint32_t opaque = touch_unused & NTP_UNUSED_TRANSPARENT ? 0 : ~0U;
    enum { NEXT = 4 * MOST /* bytes */ };
    const bool fetch = *left > MANY;
    int32_t at[MOST + LANES], found = 0;
    uint64_t changed = 0;
    for (int32_t i = 0; i < n; i += NTP__KERNEL_STEP) {
        if (fetch)
            prefetch(dst + 4 * i + NEXT, src + 4 * i + NEXT);
        found +=
            find_sixteen(at + found, i,
                         put_blues_rgba(dst + 4 * i, src + 4 * i, opaque, touch_unused, &changed));
    }
    for (int32_t k = 0; k < found; k++) { /* each changes, as its pair does */
        uint8_t *const p = dst + 4 * at[k];
        const uint32_t v = load32le(p), t = table[v & 0xffff];
        store32le(p, (t & RGB) | (v & ~(uint32_t) RGB));
    }
    *left = found;
    return changed + (uint64_t) found;
}
#endif

static uint64_t clean_rgba8(uint8_t *dst, const uint8_t *src, size_t n, const uint32_t *table,
                            const uint8_t *blue, uint32_t kept, uint32_t touch_unused)
{
    uint64_t changed = 0;
#ifdef __AVX2__
    int32_t left = 0;
    while (blue != NULL && kept == 0 && n >= NTP__KERNEL_STEP) {
        const size_t next = n < MOST ? n / NTP__KERNEL_STEP * NTP__KERNEL_STEP : MOST;
        changed += derive_rgba8(dst, src, (int32_t) next, table, touch_unused, &left);
        n -= next;
        src += 4 * next;
        dst += 4 * next;
    }
#else
    (void) blue;
#endif
    return changed + clean_rgba8_by_table(dst, src, n, table, kept, touch_unused);
}

/* The derived blue for S = 4e + 3, e >= 0.  Standard: K + t, t = floor(sqrt(e)).  Z-zero: the
 * rounding of sqrt(4e + 3), which lies in 2t..2t+2.  With d = e - t*t this root is above 2t + 1/2
 * when 2d + 1 >= t, and above 2t + 3/2 when 2d >= 3t. */
static inline int32_t blue(int32_t e, int32_t k, int32_t zzero)
{
    int32_t t = ntp__root30(e), d = e - t * t;
    int32_t z = 2 * t + (2 * d + 1 >= t) + (2 * d >= 3 * t);
    return zzero ? z : k + t;
}

#ifndef __AVX2__
#  include "texel/clean16_tmpl.h"
#endif
#include "texel/normalize8_tmpl.h"
#include "texel/normalize16_tmpl.h"

static inline void derive_loop(int32_t *restrict want, const int32_t *restrict r,
                               const int32_t *restrict g, int32_t n, int32_t m, int32_t zzero)
{
    int32_t k = (m + 1) / 2;
    int32_t e0 = (int32_t) (((int64_t) m * m - 5) / 4);
    for (int32_t i = 0; i < n; i++) {
        int32_t a = r[i] - k, c = g[i] - k;
        int32_t e = e0 - a * (a + 1) - c * (c + 1);
        int32_t b = blue(e < 0 ? 0 : e, k, zzero);
        want[i] = e < 0 ? -1 : b;
    }
}

ONE_COPY static void derive(int32_t *want, const int32_t *r, const int32_t *g, int32_t n, int32_t m,
                            int32_t zzero)
{
    if (zzero)
        derive_loop(want, r, g, n, m, 1);
    else
        derive_loop(want, r, g, n, m, 0);
}

/* k = (|X| + 1)/2 for a = r - K. */
static inline int32_t half_up(int32_t a)
{
    return a >= 0 ? a + 1 : -a;
}

/* n, as a compiler knows it to be a multiple of lanes: loops then have no remainder. */
static inline int32_t whole_lanes(int32_t n)
{
    return n & -LANES;
}

#if defined __AVX2__ && defined NTP_HAVE_AVX2
#  include "texel/cells_avx2.h"
#  define count_cells  ntp__count_cells_avx2
#  define count_alpha8 ntp__count_alpha8_avx2
#  define count_close8 ntp__count_close8_avx2
#  define survey8      ntp__survey8_avx2
#  define sample8      ntp__sample8_avx2
#  define move_colors  ntp__move_colors_avx2
#else
#  define count_cells  NULL
#  define count_alpha8 NULL
#  define count_close8 NULL
#  include "texel/survey8_tmpl.h"
#  define sample8     NULL
#  define move_colors NULL
#endif
#include "texel/flags_tmpl.h"

#include "texel/directions_tmpl.h"
#include "texel/angles_tmpl.h"
#include "texel/judge_tmpl.h"
#ifdef __AVX2__
#  define clean_rgb16 NULL
#  include "texel/derive16_tmpl.h"
#else
#  define derive_rgb16 NULL
#endif

#include "texel/close_tmpl.h"
#include "texel/exact16_tmpl.h"

static int32_t find(int32_t *restrict at, const int32_t *restrict marks, int32_t bits, int32_t n)
{
    int32_t found = 0, i = 0;
#ifdef __AVX2__
    const __m128i wanted = _mm_set1_epi32(bits), zero = _mm_setzero_si128();
    for (; i + 4 <= n; i += 4) {
        const __m128i v = _mm_loadu_si128((const __m128i *) (const void *) (marks + i));
        const __m128i none = _mm_cmpeq_epi32(_mm_and_si128(v, wanted), zero);
        found += find_four(at + found, i, _mm_movemask_ps(_mm_castsi128_ps(none)) ^ 15);
    }
#endif
    for (; i < n; i++) {
        at[found] = i;
        found += (marks[i] & bits) != 0;
    }
    return found;
}

#include "texel/normalize_tmpl.h"

static int32_t suspect(const int32_t *restrict r, const int32_t *restrict g,
                       const int32_t *restrict b, const int32_t *restrict a, int32_t n, int32_t m)
{
    int32_t any = 0;
    for (int32_t i = 0; i < n; i++)
        any |= (a[i] == 0) | ((r[i] | g[i] | b[i]) == 0) | ((r[i] & g[i] & b[i]) == m);
    return any;
}

static void numerators(ntp__vectors *restrict v, const int32_t *restrict r,
                       const int32_t *restrict g, const int32_t *restrict b, int32_t n, int32_t m,
                       int32_t zzero, double by_r, double by_g)
{
    const double twice = zzero ? 1 : 2, less = zzero ? 0 : m;
    for (int32_t i = 0; i < n; i++) {
        v->c[0][i] = (2.0 * r[i] - m) * by_r;
        v->c[1][i] = (2.0 * g[i] - m) * by_g;
        v->c[2][i] = twice * b[i] - less;
    }
}

extern const ntp__kernels_table CONCAT(ntp__kernels_, NTP_ISA);
const ntp__kernels_table CONCAT(ntp__kernels_, NTP_ISA) = {
    NTP_ISA_NAME,
    clean_rgb8_counting,
    clean_rgb8_blindly,
    clean_rgba8,
    derive_rgb8,
    clean_rgb16,
    derive_rgb16,
    derive,
    validate,
    validate_rgb,
    count_cells,
    count_alpha8,
    count_close8,
    survey8,
    sample8,
    survey,
    judge_block,
    count_close,
    count_exact,
    directions,
    angles,
    angles_of,
    normalize,
    normalize_rgb8,
    normalize_rgb16,
    move_colors,
    find,
    pull,
    suspect,
    numerators,
};
