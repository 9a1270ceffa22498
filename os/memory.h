/* SPDX-License-Identifier: MIT */
/*
 * memory.h - aligned memory, large pages
 */
#ifndef NTP_OS_MEMORY_H
#define NTP_OS_MEMORY_H

#include <stddef.h>

/* alignment: a power of two, of which size is a multiple.  For os_free_aligned. */
void *os_alloc_aligned(size_t alignment, size_t size);
void os_free_aligned(void *memory);

/* As malloc, for free; a large one is rounded up to large pages. */
void *os_alloc_large(size_t size);

/* Zeros, of which only what is used takes memory.  For os_free_zeros, with the same size. */
void *os_alloc_zeros(size_t size);
void os_free_zeros(void *memory, size_t size);

/* Asks for large pages under a buffer that will be used as a whole. */
void os_large_pages(void *memory, size_t size);

/* Lets the system put pages under large memory that will be used soon, where it can.  Any thread may
 * use the memory meanwhile; nothing in it changes. */
void os_make_present(void *memory, size_t size);

/* What is freed from now on may stay with the program: for one that works on file after file. */
void os_keep_memory(void);

/* ... and what malloc gives this thread next lies in large pages, where the system has them: for one that works
 * on a single file.  Returns what is to be freed at the end, or NULL. */
void *os_large_pages_for_malloc(void);

#endif
