/* SPDX-License-Identifier: MIT */
/*
 * memory.c - aligned memory
 */
#include "os/memory.h"

#include <stdlib.h>

void *os_alloc_aligned(size_t alignment, size_t size)
{
    return aligned_alloc(alignment, size);
}

void os_free_aligned(void *memory)
{
    free(memory);
}

void *os_alloc_large(size_t size)
{
    return malloc(size);
}

void os_large_pages(void *memory, size_t size)
{
    (void) memory, (void) size;
}
