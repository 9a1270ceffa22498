/* SPDX-License-Identifier: MIT */
/*
 * memory.c - aligned memory; large pages need a privilege that users do not have
 */
#include "os/memory.h"

#include <malloc.h>
#include <stdlib.h>

void *os_alloc_aligned(size_t alignment, size_t size)
{
    return _aligned_malloc(size, alignment);
}

void os_free_aligned(void *memory)
{
    _aligned_free(memory);
}

void *os_alloc_large(size_t size)
{
    return malloc(size);
}

void os_large_pages(void *memory, size_t size)
{
    (void) memory, (void) size;
}

void os_make_present(void *memory, size_t size)
{
    (void) memory, (void) size;
}

void os_keep_memory(void)
{
}

void *os_large_pages_for_malloc(void)
{
    return NULL;
}

void *os_alloc_zeros(size_t size)
{
    return calloc(1, size);
}

void os_free_zeros(void *memory, size_t size)
{
    (void) size;
    free(memory);
}
