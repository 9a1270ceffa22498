/* SPDX-License-Identifier: MIT */
/*
 * guarded.h - memory between two pages that may not be touched
 *
 * guarded_alloc gives `size` bytes that end (or, with at_start, begin) exactly at a guard page: a
 * read or a write of one byte too many ends the test.  Also the tests' random numbers and CHECK.
 */
#ifndef GUARDED_H
#define GUARDED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "../system.h"

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition);                \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

typedef struct guarded {
    char *map;
    size_t length;
    void *data;
} guarded;

static inline guarded guarded_alloc(size_t size, bool at_start)
{
    size_t page = system_page();
    size_t inner = (size + page - 1) / page * page;
    guarded g = { NULL, inner + 2 * page, NULL };
    g.map = system_reserve(g.length);
    CHECK(g.map != NULL);
    CHECK(inner == 0 || system_allow(g.map + page, inner));
    g.data = at_start ? g.map + page : g.map + page + inner - size;
    return g;
}

static inline void guarded_free(guarded *g)
{
    system_release(g->map, g->length);
}

/* xorshift64*: a fixed stream, so that a failure can be repeated. */
static inline uint32_t random_bits(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (uint32_t) (*state * UINT64_C(2685821657736338717) >> 32);
}

/* A level: anywhere, or (one time in four) where the interesting cases lie. */
static inline int32_t random_level(uint64_t *state, int32_t m)
{
    const int32_t special[] = { 0, 1, (m - 1) / 2, (m + 1) / 2, m - 1, m };
    uint32_t bits = random_bits(state);
    if (bits % 4 == 0)
        return special[(bits >> 8) % 6];
    return (int32_t) ((bits >> 8) % ((uint32_t) m + 1));
}

#endif
