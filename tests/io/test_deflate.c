/* SPDX-License-Identifier: MIT */
/*
 * test_deflate.c - packs to the same bytes whatever the processor has
 *
 * The digest is that of plain C.  meson.build makes this test twice: with what the processor has, and
 * without.  Whoever changes what a level writes changes the digest, too.
 */
#include <stdlib.h>
#include <string.h>

#include "chance.h"
#include "deflate_state.h"
#include "made.h"
#ifdef NTPIO_HAVE_AVX512
#  include "simd.h"
#endif

#define DIGEST 0x302942819cb718c6u

enum { SIZE = 400000, ENOUGH = 700 };

/* Runs of literals that differ in how many values they have, and repetitions of what came before. */
static void make_bytes(uint8_t *bytes, size_t size)
{
    for (size_t at = 0; at < size;) {
        const size_t left = size - at, long_run = once_in(16) ? 5000 : 120;
        size_t count = 1 + chance((uint32_t) long_run);
        count = count < left ? count : left;
        if (at > 0 && once_in(2)) {
            const size_t back = 1 + chance(at < 60000 ? (uint32_t) at : 60000);
            for (size_t i = 0; i < count; i++)
                bytes[at + i] = bytes[at + i - back];
        } else {
            const uint32_t values = 1u << chance(9), first = chance(256);
            for (size_t i = 0; i < count; i++)
                bytes[at + i] = (uint8_t) (first + chance(values) * chance(3) / 2);
        }
        at += count;
    }
}

static uint64_t digest_of(uint64_t digest, const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++)
        digest = (digest ^ bytes[i]) * 0x100000001b3u;
    return digest;
}

static void test_digest(void)
{
    uint8_t *bytes = calloc(1, SIZE + NTPIO__SLACK);
    uint8_t *out = malloc(ntpio__deflate_bound(SIZE));
    ntpio__deflater *d = ntpio__deflater_new(NTPIO__LEVEL_MAX);
    uint64_t digest = 0xcbf29ce484222325u;
    CHECK(bytes != NULL && out != NULL && d != NULL);
    make_bytes(bytes, SIZE);
    for (int level = 0; level <= NTPIO__LEVEL_TRIAL; level++) {
        const size_t size = ntpio__deflate(d, level, bytes, 40000, SIZE, level % 2 != 0, out);
        digest = digest_of(digest, out, size);
    }
    ntpio__deflater_free(d);
    free(out);
    free(bytes);
    if (digest != DIGEST)
        fprintf(stderr, "the digest is %#llx\n", (unsigned long long) digest);
    CHECK(digest == DIGEST);
}

#ifdef NTPIO_HAVE_AVX512
/* Sums of costs; nothing is read or written outside of what is counted. */
static void test_sums(void)
{
    uint32_t costs[NTPIO__LITERALS];
    for (uint32_t n = 0; n < 3000 && ntpio__has_avx512(); n++) {
        const size_t size = chance(ENOUGH);
        const uint32_t most = once_in(2) ? 240 : 17, begin = chance(5000000);
        uint32_t sum = begin, plain = begin;
        for (int i = 0; i < NTPIO__LITERALS; i++)
            costs[i] = 16 + chance(most - 15);
        uint8_t *bytes = malloc(size + 1);
        uint16_t *sums = malloc((size + 1) * sizeof *sums);
        CHECK(bytes != NULL && sums != NULL);
        for (size_t i = 0; i < size; i++)
            bytes[i] = (uint8_t) chance(256);
        const size_t done = ntpio__sum_costs_avx512(bytes, size, costs, &sum, sums);
        CHECK(done <= size && size - done < 64);
        for (size_t i = 0; i < done; i++) {
            CHECK(sums[i] == (uint16_t) plain);
            plain += costs[bytes[i]];
        }
        CHECK(sum == plain);
        free(bytes);
        free(sums);
    }
}
#endif

int main(void)
{
    test_digest();
#ifdef NTPIO_HAVE_AVX512
    test_sums();
#endif
    return 0;
}
