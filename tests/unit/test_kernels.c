/* SPDX-License-Identifier: MIT */
/*
 * test_kernels.c - every instruction set gives the bytes of the base level
 *
 * All widths 1..300 between guard pages, 8 and 16 bit, for each kernel; square roots against integers,
 * for every argument where that is feasible; angles against angle.c; packed RGB to planes and back.
 */
#include "guarded.h"
#include "base/view.h"
#include "texel/angle.h"
#include "texel/kernels.h"
#include "texel/level.h"
#include "texel/root30.h"
#include "libntp.h"

#include <math.h>
#include <string.h>

enum { WIDEST = 300, LONGEST = 3000 /* of packed pixels */, TABLE = 65536, SKIPPED = 77 };
static const ntp__kernels_table *base;

/* Derived blue by search: no square root at all. */
static int32_t derived_by_search(int32_t r, int32_t g, int32_t m, bool zzero)
{
    int64_t x = 2 * r - m, y = 2 * g - m, s = (int64_t) m * m - x * x - y * y;
    if (s < 0)
        return -1;
    int32_t low = zzero ? 0 : (m + 1) / 2, high = m;
    while (low < high) {
        int64_t middle = low + (high - low + 1) / 2;
        int64_t edge = zzero ? 2 * middle - 1 : 2 * middle - m - 1;
        const bool fits = edge * edge <= (zzero ? 4 * s : s);
        low = fits ? (int32_t) middle : low;
        high = fits ? high : (int32_t) middle - 1;
    }
    return low;
}

/* Flags of ntp_validate, for each encoding, against the integers of level.h. */
static void check_flags(const ntp__kernels_table *level, int32_t *const plane[4], int32_t n,
                        int32_t m, uint64_t *seed)
{
    const int32_t *r = plane[0], *g = plane[1], *b = plane[2], *a = plane[3];
    uint8_t flags[NTP__BLOCK];
    for (int32_t encoding = NTP_ENCODING_STANDARD; encoding <= NTP_ENCODING_XY; encoding++) {
        const bool xy = encoding == NTP_ENCODING_XY, keep = random_bits(seed) & 1;
        const ntp__validity how = { m, encoding == NTP_ENCODING_ZZERO, keep,
                                    xy ? NTP_FLAG_XY_TOO_LONG : 0xff, xy ? 7 : 0 };
        level->validate(flags, plane, n, &how);
        for (int32_t i = 0; i < n; i++) {
            uint32_t want = ntp__flags(r[i], g[i], b[i], m, (ntp_encoding) encoding, keep);
            want |= ntp__unused(r[i], g[i], b[i], a[i], m, 0) ? NTP_FLAG_UNUSED : 0;
            CHECK(flags[i] == want);
        }
    }
}

static void compare_planar(const ntp__kernels_table *level, int32_t n, int32_t m, bool zzero,
                           uint64_t *seed)
{
    size_t bytes = (size_t) n * sizeof(int32_t);
    guarded plane[3], want = guarded_alloc(bytes, false);
    for (int k = 0; k < 3; k++) {
        plane[k] = guarded_alloc(bytes, false);
        for (int32_t i = 0; i < n; i++)
            ((int32_t *) plane[k].data)[i] = random_level(seed, m);
    }
    const int32_t *r = plane[0].data, *g = plane[1].data;
    int32_t expected[WIDEST];
    base->derive(expected, r, g, n, m, zzero);
    for (int32_t i = 0; i < n; i += 7)
        CHECK(expected[i] == derived_by_search(r[i], g[i], m, zzero));
    level->derive(want.data, r, g, n, m, zzero);
    CHECK(memcmp(want.data, expected, bytes) == 0);
    if (n <= NTP__BLOCK) {
        static int32_t block[4][NTP__BLOCK];
        int32_t *const planes[] = { block[0], block[1], block[2], block[3] };
        for (int32_t i = 0; i < n; i++) {
            const int32_t sign = random_bits(seed) & 1 ? -1 : 0;
            block[0][i] = r[i];
            block[1][i] = g[i];
            block[2][i] = ((const int32_t *) plane[2].data)[i];
            if (random_bits(seed) & 1 && expected[i] >= 0) /* exact, mirrored, or beside these */
                block[2][i] = (expected[i] - (int32_t) (random_bits(seed) % 3 == 0)) ^ (m & sign);
            block[3][i] = random_level(seed, m);
        }
        check_flags(level, planes, n, m, seed);
    }
    for (int k = 0; k < 3; k++)
        guarded_free(&plane[k]);
    guarded_free(&want);
}

static void compare_packed(const ntp__kernels_table *level, size_t n, size_t channels,
                           const uint32_t *table, const uint8_t *blues, uint64_t *seed)
{
    size_t bytes = n * channels;
    static uint8_t expected[LONGEST * 4];
    for (int place = 0; place < 4; place++) {
        uint32_t kept = place & 1 ? 0xff0000 : 0, touch = random_bits(seed) & NTP_UNUSED_ALL;
        guarded src = guarded_alloc(bytes, place & 2), dst = guarded_alloc(bytes, place & 2);
        uint8_t *s = src.data;
        /* Half of the time nearly no pair is too long, and few pixels are transparent. */
        const bool inside = random_bits(seed) & 1;
        for (size_t i = 0; i < bytes; i++) {
            const uint8_t any = (uint8_t) random_level(seed, 255);
            s[i] = inside ? (uint8_t) (48 + any * 5 / 8) : any;
            s[i] = inside && i % channels == 3 && random_bits(seed) % 64 == 0 ? 0 : s[i];
        }
        for (size_t i = random_bits(seed) % 2 * n; i < n; i += 1 + random_bits(seed) % 300)
            memset(s + channels * i, random_bits(seed) & 1 ? 255 : 0, /* backgrounds */
                   channels * (n - i < 150 ? n - i : random_bits(seed) % 150));
        /* Half of these have blues that are right, but few that are one off. */
        const bool right = inside && random_bits(seed) & 1;
        for (size_t i = 0; right && i < bytes; i += channels) {
            const uint32_t off = random_bits(seed) % 64;
            s[i + 2] = (uint8_t) (blues[s[i] | s[i + 1] << 8] + (off == 0) - (off == 1));
        }
        const uint8_t *blue = place & 1 ? NULL : blues;
        ntp__clean8_fn *slow = channels == 3 ? base->clean_rgb8 : base->clean_rgba8;
        ntp__clean8_fn *fast = channels == 3 ? level->clean_rgb8 : level->clean_rgba8;
        uint64_t changed = slow(expected, s, n, table, NULL, kept, touch);
        CHECK(fast(dst.data, s, n, table, blue, kept, touch) == changed);
        CHECK(memcmp(dst.data, expected, bytes) == 0);
        CHECK(fast(s, s, n, table, blue, kept, touch) == changed); /* in place */
        CHECK(memcmp(s, expected, bytes) == 0);
        guarded_free(&src);
        guarded_free(&dst);
    }
}

/* The texels that it reports as done are done, and nothing else; it stops only where a pair is too
 * long. */
static void check_cleaned16(const uint16_t *dst, const uint16_t *src, const int32_t *want,
                            int32_t n, int32_t done, uint64_t changed)
{
    bool too_long = false;
    for (int32_t i = 0; i < done; i++) {
        CHECK(dst[3 * i] == src[3 * i] && dst[3 * i + 1] == src[3 * i + 1]);
        CHECK(dst[3 * i + 2] == want[i]);
        changed -= src[3 * i + 2] != want[i];
    }
    CHECK(changed == 0);
    for (int32_t i = done; i < n && i < done + NTP__KERNEL_STEP; i++)
        too_long |= want[i] < 0;
    CHECK(done == n || too_long);
}

static void compare_clean16(const ntp__kernels_table *level, int32_t n, bool zzero, uint64_t *seed)
{
    size_t bytes = (size_t) n * 6;
    for (int place = 0; place < 4; place++) {
        guarded from = guarded_alloc(bytes, place & 2), to = guarded_alloc(bytes, place & 2);
        uint16_t *src = from.data, *dst = to.data, kept[3 * WIDEST];
        int32_t want[WIDEST];
        for (int32_t i = 0; i < n; i++) {
            src[3 * i] = (uint16_t) (place & 1 ? random_level(seed, 65535)
                                               : 32768 - random_level(seed, 23000));
            src[3 * i + 1] = (uint16_t) (23000 + random_level(seed, 19000));
            want[i] = derived_by_search(src[3 * i], src[3 * i + 1], 65535, zzero);
            src[3 * i + 2] = (uint16_t) (random_bits(seed) & 1 ? want[i] : want[i] + 1);
        }
        memcpy(kept, src, bytes);
        uint64_t changed = 0;
        int32_t done = level->clean_rgb16(dst, src, n, zzero, &changed);
        check_cleaned16(dst, src, want, n, done, changed);
        CHECK(level->clean_rgb16(src, src, n, zzero, NULL) == done); /* in place */
        CHECK(memcmp(src, dst, (size_t) done * 6) == 0);
        CHECK(memcmp(src + 3 * done, kept + 3 * done, bytes - (size_t) done * 6) == 0);
        guarded_free(&from);
        guarded_free(&to);
    }
}

/* All 65,536 pairs of 8 bit; of 16 bit the rows where S is smallest and a thousand others. */
static void check_derive(const ntp__kernels_table *level)
{
    static int32_t r[TABLE], g[TABLE], want[TABLE];
    for (int zzero = 0; zzero < 2; zzero++) {
        for (int32_t i = 0; i < TABLE; i++) {
            r[i] = i & 255;
            g[i] = i >> 8;
        }
        level->derive(want, r, g, TABLE, 255, zzero);
        for (int32_t i = 0; i < TABLE; i++)
            CHECK(want[i] == derived_by_search(r[i], g[i], 255, zzero));
        uint64_t seed = 77;
        for (int row = 0; row < 30; row++) {
            int32_t red = random_level(&seed, 65535);
            for (int32_t i = 0; i < TABLE; i++) {
                r[i] = red;
                g[i] = i;
            }
            level->derive(want, r, g, TABLE, 65535, zzero);
            for (int32_t i = 0; i < TABLE; i++)
                CHECK(want[i] == derived_by_search(red, i, 65535, zzero));
        }
    }
}

/* ntp__root30 for every argument.  (1024 a step, so that the compiler can vectorise the inner
 * loop.) */
static void check_float_roots(void)
{
    for (int32_t first = 0; first < 1 << 30; first += 1024) {
        int32_t bad = 0;
        for (int32_t i = 0; i < 1024; i++) {
            int32_t e = first + i, t = ntp__root30(e);
            bad |= (t * t > e) | (e - t * t > 2 * t);
        }
        CHECK(!bad);
    }
}

/* floor((M + 1 + M v/L)/2) is the only c with 2c - M - 1 <= M v/L < 2c - M + 1. */
static bool rounds_to(int32_t c, int64_t v, int64_t length2, int64_t m)
{
    int64_t at[2] = { 2 * c - m - 1, 2 * c - m + 1 };
    bool reaches[2];
    for (int k = 0; k < 2; k++) {
        int64_t left = at[k] * at[k] * length2, right = m * m * v * v;
        if ((at[k] < 0) != (v < 0))
            reaches[k] = at[k] < 0 || (at[k] == 0 && v >= 0);
        else
            reaches[k] = v < 0 ? left >= right : left <= right;
    }
    return reaches[0] && !reaches[1];
}

/* x so that 255 |x| / 2L lies about 2^-22 of itself from an integer: floats alone go wrong there. */
static void near_boundary(ntp__vectors *v, int32_t i, uint64_t *seed)
{
    enum { LENGTH = 1 << 21 };
    const int32_t k = 1 + random_level(seed, 125), sign = i % 2 ? -1 : 1;
    const double y = random_level(seed, LENGTH / 8), length = LENGTH + random_level(seed, LENGTH);
    const double x = (double) (int32_t) (length * k / 127.5 + 0.5), exact = x * 127.5 / k;
    const double z2 = exact * exact - x * x - y * y;
    v->c[0][i] = sign * x;
    v->c[1][i] = y;
    v->c[2][i] = z2 > 0 ? (double) (int32_t) sqrt(z2) : 1;
}

/* Vectors of small integers, and those whose quotients are close to a boundary: what the kernel
 * does not doubt is right, and it seldom doubts. */
static void check_directions(const ntp__kernels_table *level, int32_t m, int32_t zzero,
                             uint64_t *seed)
{
    enum { BLOCKS = 300, SIDE = 12000, BLOCK = 256 };
    int32_t doubts = 0, first[4][BLOCK], c[4][BLOCK];
    for (int32_t block = 0; block < BLOCKS; block++) {
        int32_t n = block % 7 ? BLOCK : 1 + block % BLOCK;
        ntp__vectors v, copy;
        for (int32_t i = 0; i < n; i++) {
            for (int k = 0; k < 3; k++)
                v.c[k][i] = random_level(seed, 2 * SIDE) - SIDE;
            if (i % 5 == 0) /* a vector as a texel has it, longer: halfway between boundaries */
                v.c[2][i] = i % 10 ? 0 : 1;
            if (i % 7 == 0)
                v.c[i % 2][i] = i % 3 ? 0 : -0.0;
            if (m == 255 && i % 11 == 3)
                near_boundary(&v, i, seed);
        }
        copy = v;
        level->directions(c[0], c[1], c[2], c[3], &v, n, m, zzero, 1);
        base->directions(first[0], first[1], first[2], first[3], &copy, n, m, zzero, 1);
        for (int32_t i = 0; i < n; i++) {
            const bool doubted = (c[3][i] | first[3][i]) & NTP__IN_DOUBT;
            for (int k = 0; k < 4; k++)
                CHECK(doubted || c[k][i] == first[k][i]);
            int64_t x = (int64_t) v.c[0][i], y = (int64_t) v.c[1][i], z = (int64_t) v.c[2][i];
            int64_t length2 = x * x + y * y + z * z;
            if (c[3][i] & NTP__IN_DOUBT) {
                doubts += length2 > 0 && i % 11 != 3;
                continue;
            }
            CHECK(length2 == 0 || rounds_to(c[0][i], x, length2, m));
            CHECK(length2 == 0 || rounds_to(c[1][i], y, length2, m));
            int32_t blue = derived_by_search(c[0][i], c[1][i], m, zzero);
            CHECK((blue < 0) == (c[3][i] == NTP__OVERLONG));
            CHECK(blue < 0 || c[2][i] == (z < 0 && !zzero ? m - blue : blue));
        }
    }
    CHECK(doubts < BLOCKS * BLOCK / 500);
}

/* Texels of any length and those near to length 1: what the kernel does not doubt is what the
 * integers of level.h make of it, and it seldom doubts. */
static void check_normalize(const ntp__kernels_table *level, int32_t m, uint64_t *seed)
{
    enum { BLOCKS = 400, BLOCK = 256 };
    int32_t doubts = 0, in[3][BLOCK], out[3][BLOCK], doubt[BLOCK];
    int32_t *const from[] = { in[0], in[1], in[2] }, *const to[] = { out[0], out[1], out[2] };
    for (int32_t block = 0; block < BLOCKS; block++) {
        const bool mirror = block % 2;
        int32_t changed = 0, differ = 0;
        for (int32_t i = 0; i < BLOCK; i++) {
            for (int k = 0; k < 3; k++)
                in[k][i] = random_level(seed, m);
            int32_t blue = derived_by_search(in[0][i], in[1][i], m, false);
            if (i % 2 && blue >= 0)
                in[2][i] = blue - (blue >= 4 ? random_level(seed, 4) : 0);
        }
        const int32_t n = block % 7 ? BLOCK : 1 + block % BLOCK;
        for (int32_t i = n; i < BLOCK; i++) { /* flat */
            in[0][i] = in[1][i] = (m + 1) / 2;
            in[2][i] = m;
        }
        level->normalize(to, doubt, from, n, m, mirror ? (m - 1) / 2 : -1, &changed);
        for (int32_t i = 0; i < n; i++) {
            int32_t c[3] = { in[0][i], in[1][i], in[2][i] };
            ntp__clean(c, m, NTP_ENCODING_STANDARD, NTP_CLEAN_NORMALIZE, !mirror);
            doubts += doubt[i] != 0;
            differ += out[0][i] != in[0][i] || out[1][i] != in[1][i] || out[2][i] != in[2][i];
            for (int k = 0; k < 3; k++)
                CHECK(doubt[i] || out[k][i] == c[k]);
        }
        CHECK(changed == differ);
    }
    CHECK(doubts < BLOCKS * BLOCK / 500);
}

/* Angles within 0.00001 micro-degrees of the middle between two whole ones, on the other side of which
 * a polynomial alone takes them to be. */
static void check_doubtful_angles(const ntp__kernels_table *level)
{
    static const int32_t CASE[][7] = {
        { -11, 55, -213, -7, -179, 45, 118405253 },
        { 113, 19, -91, 9, 193, -35, 74104704 },
        { 201, -37, 121, -25, 231, 147, 86299215 },
        { 33, -179, -145, 133, -109, 203, 95129192 },
        { -165, -139, -3, -221, -231, -173, 28243497 },
        { -77, -87, 239, -95, -183, -255, 115639940 },
        { 225, 147, -161, 157, 153, 53, 45775971 },
        { -209, 133, -175, 145, -99, 151, 174349569 },
    };
    enum { CASES = sizeof CASE / sizeof CASE[0], BLOCK = 256 };
    int32_t angle[BLOCK], c[2][3][BLOCK];
    for (int32_t i = 0; i < CASES; i++) {
        for (int32_t k = 0; k < 6; k++)
            c[k / 3][k % 3][i] = (CASE[i][k] + 255) / 2;
    }
    const ntp__numbers v = { { c[0][0], c[0][1], c[0][2] }, 255, -1, 255, -1, 255 };
    const ntp__numbers w = { { c[1][0], c[1][1], c[1][2] }, 255, -1, 255, -1, 255 };
    level->angles(angle, &v, &w, CASES);
    for (int32_t i = 0; i < CASES; i++)
        CHECK(angle[i] == CASE[i][6]);
}

/* Marks of any density; what comes after the places is not looked at. */
static void check_find(const ntp__kernels_table *level, uint64_t *seed)
{
    enum { RUNS = 3000, BLOCK = 256 };
    for (int32_t run = 0; run < RUNS; run++) {
        const int32_t n = random_level(seed, BLOCK), bits = run % 3 ? INT32_MIN : 1 + run % 7;
        int32_t marks[BLOCK], at[BLOCK], places = 0;
        for (int32_t i = 0; i < BLOCK; i++) {
            const bool marked = random_level(seed, 15) < run % 17;
            marks[i] = (random_level(seed, 65535) & ~bits) | (marked ? bits : 0);
        }
        const int32_t found = level->find(at, marks, bits, n);
        for (int32_t i = 0; i < n; i++) {
            if (marks[i] & bits)
                CHECK(places < found && at[places++] == i);
        }
        CHECK(places == found);
    }
}

/* Numerators of levels: any, nearly parallel, nearly opposite and nearly at right angles. */
static void check_angles(const ntp__kernels_table *level, uint64_t *seed)
{
    enum { BLOCKS = 400, BLOCK = 256, NEAR = 4 }; /* even: no vector is zero */
    for (int32_t block = 0; block < BLOCKS; block++) {
        int32_t n = block % 7 ? BLOCK : 1 + block % BLOCK, m = block % 2 ? 65535 : 255;
        int32_t angle[BLOCK], pair[2][3][BLOCK], copy[2][3][BLOCK];
        for (int32_t i = 0; i < n; i++) {
            for (int k = 0; k < 3; k++) {
                pair[0][k][i] = 2 * random_level(seed, m) - m;
                pair[1][k][i] = 2 * random_level(seed, m) - m;
                if (i % 4 == 1 || i % 4 == 2) /* the same or the opposite, or near to it */
                    pair[1][k][i] = (i % 4 == 1 ? 1 : -1) * pair[0][k][i] +
                                    (i % 3 ? 2 * random_level(seed, NEAR) - NEAR : 0);
            }
            if (i % 4 == 3) {
                pair[1][0][i] = pair[0][1][i];
                pair[1][1][i] = -pair[0][0][i];
                pair[1][2][i] = i % 3 - 1;
            }
        }
        memcpy(copy, pair, sizeof copy);
        const ntp__numbers v = { .c = { copy[0][0], copy[0][1], copy[0][2] }, .m = m };
        const ntp__numbers w = { .c = { copy[1][0], copy[1][1], copy[1][2] }, .m = m };
        level->angles(angle, &v, &w, n);
        for (int32_t i = 0; i < n; i++)
            CHECK((uint32_t) angle[i] == ntp__angle(pair[0][0][i], pair[0][1][i], pair[0][2][i],
                                                    pair[1][0][i], pair[1][1][i], pair[1][2][i]));
    }
}

/* Pairs are pulled as ntp__pull does it, or in doubt, which is rare: all of 8 bit; those of 16 bit
 * that lie close to the circle, and others. */
static void check_pull(const ntp__kernels_table *level, int32_t m, uint64_t *seed)
{
    enum { BLOCK = 256, BLOCKS = 2000 };
    int32_t pair = 0, doubts = 0, all = 0;
    for (int32_t block = 0; block < (m == 255 ? 65536 / BLOCK : BLOCKS); block++) {
        const int32_t n = m == 255 || block % 5 ? BLOCK : 1 + block % BLOCK;
        int32_t r[BLOCK] = { 0 }, g[BLOCK] = { 0 }, from[2][BLOCK], doubt[BLOCK];
        for (int32_t i = 0; i < n; i++, pair++) {
            r[i] = m == 255 ? pair & 255 : random_level(seed, m);
            g[i] = m == 255 ? pair >> 8 : random_level(seed, m);
            if (m != 255 && i % 2) { /* just outside */
                const double x = 2 * r[i] - m, y = sqrt((double) m * m - x * x);
                g[i] = (int32_t) ((y + m) / 2) + 1;
                g[i] = i % 4 == 1 ? g[i] : m - g[i];
            }
            while (ntp__rest(r[i], g[i], m) >= 0)
                r[i] = g[i] = random_level(seed, m);
            from[0][i] = r[i];
            from[1][i] = g[i];
        }
        level->pull(r, g, doubt, n, m);
        for (int32_t i = 0; i < n; i++) {
            ntp__pull(&from[0][i], &from[1][i], m);
            CHECK(doubt[i] || (r[i] == from[0][i] && g[i] == from[1][i]));
            doubts += doubt[i] != 0;
            all++;
        }
    }
    CHECK(doubts * 5 < all); /* where X = 1, one is always in doubt */
}

/* Packed RGB of every width to planes and back, not a byte beyond. */
static void check_packed_rgb(ntp_type type, uint64_t *seed)
{
    enum { BLOCK = 256 };
    const size_t sample = type == NTP_TYPE_U8 ? 1 : 2;
    for (int32_t n = 1; n <= BLOCK; n++) {
        guarded src = guarded_alloc(3 * sample * (size_t) n, false);
        guarded dst = guarded_alloc(3 * sample * (size_t) n, false);
        for (size_t i = 0; i < 3 * sample * (size_t) n; i++)
            ((uint8_t *) src.data)[i] = (uint8_t) random_bits(seed);
        const ntp_image from = ntp_image_packed(src.data, n, 1, 3, type);
        const ntp_image to = ntp_image_packed(dst.data, n, 1, 3, type);
        const ntp_const_image view = ntp_image_as_const(&from);
        ntp__block block;
        ntp__unpack(&block, &view, 0, 0, n);
        for (int32_t i = 0; i < 4 * n; i++) {
            int32_t at = 3 * (i / 4) + i % 4;
            int32_t want = i % 4 == 3    ? (sample == 1 ? 255 : 65535)
                           : sample == 1 ? ((uint8_t *) src.data)[at]
                                         : ((uint16_t *) src.data)[at];
            CHECK(block.c[i % 4][i / 4] == want);
        }
        ntp__pack(&to, &block, 0, 0, n, 3);
        CHECK(memcmp(src.data, dst.data, 3 * sample * (size_t) n) == 0);
        guarded_free(&src);
        guarded_free(&dst);
    }
}

int main(int argc, char **argv)
{
    const bool wide = argc > 1 && strcmp(argv[1], "avx512") == 0, avx2 = argc > 1;
    if ((avx2 && !ntp__cpu_has_avx2(NTP__CPU_ALL)) || (wide && !ntp__cpu_has_avx512(NTP__CPU_ALL)))
        return SKIPPED;
    static uint32_t table[TABLE];
    static uint8_t blues[TABLE];
    uint64_t seed = 12345;
    for (int32_t i = 0; i < TABLE; i++) {
        int32_t blue = derived_by_search(i & 255, i >> 8, 255, false);
        uint32_t other = (random_bits(&seed) & 0xffffff) | (i % 65535 == 0 ? 1U << 24 : 0);
        blues[i] = (uint8_t) (blue < 0 ? 0 : blue);
        table[i] = blue < 0 ? other : (uint32_t) (i | blue << 16);
    }
    base = ntp__kernels(0);
    check_derive(base);
    check_float_roots();
    ntp__kernels_table picked, *const level = &picked;
    ntp__pick_kernels(&picked, wide ? NTP__CPU_ALL : avx2 ? NTP__CPU_AVX2 : 0);
    check_derive(level);
    for (int32_t m = 255; m <= 65535; m *= 257) {
        check_directions(level, m, false, &seed);
        check_directions(level, m, true, &seed);
        check_packed_rgb(m == 255 ? NTP_TYPE_U8 : NTP_TYPE_U16, &seed);
        check_normalize(level, m, &seed);
        check_pull(level, m, &seed);
    }
    check_angles(level, &seed);
    check_doubtful_angles(level);
    check_find(level, &seed);
    for (int32_t n = 1; n <= WIDEST; n++)
        for (int kind = 0; kind < 4; kind++)
            compare_planar(level, n, kind & 1 ? 65535 : 255, kind & 2, &seed);
    for (int32_t n = 1; level->clean_rgb16 != NULL && n <= WIDEST; n++)
        compare_clean16(level, n, n & 1, &seed);
    for (int32_t n = 2; n < 2 * LONGEST; n += n < 2 * WIDEST ? 1 : 71)
        compare_packed(level, (size_t) n / 2, 3 + (size_t) n % 2, table, blues, &seed);
    return 0;
}
