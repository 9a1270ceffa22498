/* SPDX-License-Identifier: MIT */
/*
 * memory.c - aligned memory, and fewer page faults for large buffers
 *
 * Fresh memory comes in pages of 4 KiB, each by a fault of one to three microseconds.  For the
 * pixels of a texture that takes a quarter as long as decoding them.  Linux gives 2 MiB at once if
 * it is asked to; elsewhere nothing changes.
 */
#include "os/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#ifdef __GLIBC__
#  include <malloc.h>
#endif

enum { PAGE = 4096, LARGE = 2 << 20 };

void os_large_pages(void *memory, size_t size)
{
#ifdef MADV_HUGEPAGE
    const size_t before = (PAGE - (uintptr_t) memory % PAGE) % PAGE;
    if (memory != NULL && size >= before + LARGE)
        madvise((uint8_t *) memory + before, (size - before) / PAGE * PAGE, MADV_HUGEPAGE);
#else
    (void) memory, (void) size;
#endif
}

void os_make_present(void *memory, size_t size)
{
#ifdef __linux__
    enum { POPULATE_WRITE = 23 }; /* Linux 5.14; an older one refuses it */
    madvise(memory, size, POPULATE_WRITE);
#else
    (void) memory, (void) size;
#endif
}

void *os_alloc_large(size_t size)
{
    if (size < LARGE || size > SIZE_MAX - LARGE)
        return malloc(size);
    const size_t whole = (size + LARGE - 1) / LARGE * LARGE, rest = size % LARGE;
    void *memory = aligned_alloc(LARGE, whole);
    /* A little more than large pages takes small ones: to fill a large one with zeros takes longer. */
    os_large_pages(memory, rest < LARGE / 4 ? size - rest : whole);
    return memory;
}

void *os_alloc_aligned(size_t alignment, size_t size)
{
    return aligned_alloc(alignment, size);
}

void os_free_aligned(void *memory)
{
    free(memory);
}

/* glibc gives buffers of a megabyte and more back when they are freed, and takes fresh ones for the
 * next file.  The system fills these with zeros, which took a fifth of the time of a folder.  And it is
 * asked for more at a time, of which only what is used takes memory. */
void os_keep_memory(void)
{
#ifdef __GLIBC__
    mallopt(M_TOP_PAD, 1 << 20);
    mallopt(M_MMAP_THRESHOLD, 64 << 20);
    mallopt(M_TRIM_THRESHOLD, 256 << 20);
#endif
}

/* Even a small file takes hundreds of pages of buffers and tables to write, and the system clears a large one in
 * the time of 30 to 150 faults.  What malloc gives next follows on what it has given: what is left of
 * a large page that has begun is kept out of its way, and no memory is ever put there. */
void *os_large_pages_for_malloc(void)
{
#if defined __GLIBC__ && defined MADV_HUGEPAGE
    enum { AT_ONCE = 24 * LARGE };
    uint8_t *const next = malloc(AT_ONCE);
    const size_t rest = (LARGE - (uintptr_t) next % LARGE) % LARGE;
    if (next != NULL)
        madvise(next + rest, (AT_ONCE - rest) / LARGE * LARGE, MADV_HUGEPAGE);
    free(next);
    return malloc(rest);
#else
    return NULL;
#endif
}

static size_t whole_pages(size_t size)
{
    return (size + PAGE - 1) / PAGE * PAGE;
}

/* calloc of glibc writes zeros over the rest of its pages, which are zeros mostly and may never be
 * used.  Large memory begins with a large page, and what is too much before and after it is given back. */
void *os_alloc_zeros(size_t size)
{
    const size_t more = size >= LARGE ? LARGE : 0, whole = whole_pages(size);
    if (size > SIZE_MAX - LARGE - PAGE)
        return NULL;
    uint8_t *const memory =
        mmap(NULL, whole + more, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED || more == 0)
        return memory != MAP_FAILED ? memory : NULL;
    const size_t before = (LARGE - (uintptr_t) memory % LARGE) % LARGE;
    if (before > 0)
        munmap(memory, before);
    munmap(memory + before + whole, more - before);
    return memory + before;
}

void os_free_zeros(void *memory, size_t size)
{
    if (memory != NULL)
        munmap(memory, size);
}
