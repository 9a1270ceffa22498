/* SPDX-License-Identifier: MIT */
/*
 * scratch.h - hands out the caller's working memory in pieces
 *
 * One function both measures memory and lays it out, so the two cannot disagree.  With base NULL
 * it only counts in `used`.
 */
#ifndef NTP_SCRATCH_H
#define NTP_SCRATCH_H

#include <stddef.h>

enum { NTP__ALIGNMENT = 64 };

typedef struct ntp__scratch {
    char *base;
    size_t used;
} ntp__scratch;

static inline void *ntp__take(ntp__scratch *s, size_t bytes)
{
    void *taken = s->base != NULL ? s->base + s->used : NULL;
    s->used += (bytes + NTP__ALIGNMENT - 1) / NTP__ALIGNMENT * NTP__ALIGNMENT;
    return taken;
}

#endif
