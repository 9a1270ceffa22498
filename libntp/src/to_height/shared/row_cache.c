/* SPDX-License-Identifier: MIT */
/*
 * row_cache.c - rows of slopes that are made once and kept while the rows around need them
 */
#include "to_height/shared/row_cache.h"

void ntp__row_cache_init(ntp__row_cache *cache, ntp__scratch *memory, int32_t places,
                         size_t row_bytes)
{
    cache->places = places;
    for (int32_t k = 0; k < places; k++) {
        cache->right[k] = ntp__take(memory, row_bytes);
        cache->down[k] = ntp__take(memory, row_bytes);
    }
    ntp__row_cache_forget(cache);
}

void ntp__row_cache_forget(ntp__row_cache *cache)
{
    cache->clock = 0;
    for (int32_t k = 0; k < cache->places; k++) {
        cache->row[k] = -1;
        cache->used[k] = 0;
    }
}

bool ntp__row_cache_find(ntp__row_cache *cache, int32_t y, int32_t *place)
{
    int32_t oldest = 0;
    cache->clock++;
    for (int32_t k = 0; k < cache->places; k++) {
        if (cache->row[k] == y) {
            cache->used[k] = cache->clock;
            *place = k;
            return true;
        }
        oldest = cache->used[k] < cache->used[oldest] ? k : oldest;
    }
    cache->row[oldest] = y;
    cache->used[oldest] = cache->clock;
    *place = oldest;
    return false;
}
