// SPDX-License-Identifier: MIT
/*
 * jump.c - setjmp and longjmp in WebAssembly, for the image libraries
 *
 * WebAssembly cannot leave a function from a function that it calls.  JavaScript can, by throwing.
 * So LLVM's -enable-emscripten-sjlj makes of each call that may jump an `invoke_` function, which
 * JavaScript provides: it calls and catches (src/jump.ts).  After it, the caller looks into __THREW__
 * for the buffer that was jumped to, and in its table of labels for the place.  Here is what remains:
 * the table, and what is kept meanwhile.
 */
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>

typedef struct label {
    uint32_t buffer; /* its number; 0 ends the table */
    uint32_t place;
} label;

uintptr_t __THREW__;
int __threwValue;

static uint32_t returned; /* the second result of the functions below */
static uint32_t buffers;

/* JavaScript throws what its invoke_ functions catch. */
__attribute__((import_module("env"), import_name("throwJump"))) _Noreturn void throw_jump(void);

void setTempRet0(uint32_t value)
{
    returned = value;
}

uint32_t getTempRet0(void)
{
    return returned;
}

/* Adds a buffer to a table of `size` labels and one that ends it.  A table that grew moves. */
label *saveSetjmp(uint32_t *buffer, uint32_t place, label *table, uint32_t size)
{
    uint32_t used = 0;

    *buffer = ++buffers;
    while (used < size && table[used].buffer != 0)
        used++;
    if (used == size) {
        size *= 2;
        table = realloc(table, (size + 1) * sizeof *table);
        if (table == NULL)
            abort();
    }
    table[used] = (label) { *buffer, place };
    table[used + 1] = (label) { 0, 0 };
    setTempRet0(size);
    return table;
}

/* The place of a buffer, or 0: the jump goes to another function. */
uint32_t testSetjmp(uint32_t buffer, const label *table, uint32_t size)
{
    for (uint32_t i = 0; i < size && table[i].buffer != 0; i++)
        if (table[i].buffer == buffer)
            return table[i].place;
    return 0;
}

_Noreturn void emscripten_longjmp(uintptr_t buffer, int value)
{
    __THREW__ = buffer;
    __threwValue = value != 0 ? value : 1;
    throw_jump();
}
