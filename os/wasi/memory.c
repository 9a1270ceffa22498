/* SPDX-License-Identifier: MIT */
/*
 * memory.c - aligned memory, fresh memory
 */
#include "os/memory.h"

#include <stdint.h>
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

/* calloc of wasi-libc writes zeros over zeros, which takes longer than to check a small file. */
void *os_alloc_zeros(size_t size)
{
    enum { PAGE = 1 << 16 };
    const size_t pages = size / PAGE + (size % PAGE != 0);
    const size_t end = __builtin_wasm_memory_grow(0, pages);

    return end == SIZE_MAX ? NULL : (void *) (end * PAGE); // NOLINT: an address in linear memory
}

void os_free_zeros(void *memory, size_t size)
{
    (void) memory, (void) size; /* goes with the instance, which runs once */
}
