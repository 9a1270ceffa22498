/* SPDX-License-Identifier: MIT */
/*
 * row_cache.h - rows of slopes that are made once and kept while the rows around need them
 *
 * A row of a right-hand side reads several rows of slopes, and the next one reads most of them
 * again.  When all places are taken, the row asked for longest ago makes way.
 */
#ifndef NTP_ROW_CACHE_H
#define NTP_ROW_CACHE_H

#include "base/scratch.h"

#include <stdbool.h>
#include <stdint.h>

enum { NTP__MOST_CACHED = 20 };

/* right[k] and down[k] are the slopes of row row[k] of the picture; -1: of none. */
typedef struct ntp__row_cache {
    int32_t places, row[NTP__MOST_CACHED];
    uint64_t used[NTP__MOST_CACHED], clock; /* when each was asked for last */
    void *right[NTP__MOST_CACHED], *down[NTP__MOST_CACHED];
} ntp__row_cache;

/* Takes memory for `places` rows of slopes right and as many down, and empties the cache. */
void ntp__row_cache_init(ntp__row_cache *cache, ntp__scratch *memory, int32_t places,
                         size_t row_bytes);
void ntp__row_cache_forget(ntp__row_cache *cache);

/* Sets *place to that of row y; false: the caller has to make the row there. */
bool ntp__row_cache_find(ntp__row_cache *cache, int32_t y, int32_t *place);

#endif
