/* SPDX-License-Identifier: MIT */
/* chance.h - numbers by chance, the same in every run */
#ifndef CHANCE_H
#define CHANCE_H

#include <stdbool.h>
#include <stdint.h>

static uint64_t state = 1;

/* Below `below`. */
static inline uint32_t chance(uint32_t below)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t) (state >> 33) % below;
}

static inline bool once_in(uint32_t n)
{
    return chance(n) == 0;
}

#endif
