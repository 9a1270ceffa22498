// SPDX-License-Identifier: MIT
/*
 * bytes.c - memcpy, memmove and memset by the instructions that WebAssembly has for them
 *
 * Those of wasi-libc are loops.  Few bytes are done here, as the instructions are slow to begin.
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define BULK __attribute__((target("bulk-memory")))

enum { FEW = 32 };

BULK void *memset(void *to, int value, size_t size)
{
    uint8_t *bytes = to;

    if (size > FEW)
        return __builtin_memset(to, value, size);
    for (size_t i = 0; i < size; i++)
        bytes[i] = (uint8_t) value;
    return to;
}

BULK void *memcpy(void *restrict to, const void *restrict from, size_t size)
{
    uint8_t *bytes = to;

    if (size > FEW)
        return __builtin_memcpy(to, from, size);
    for (size_t i = 0; i < size; i++)
        bytes[i] = ((const uint8_t *) from)[i];
    return to;
}

BULK void *memmove(void *to, const void *from, size_t size)
{
    return __builtin_memmove(to, from, size);
}
