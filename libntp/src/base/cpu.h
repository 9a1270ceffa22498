/* SPDX-License-Identifier: MIT */
/*
 * cpu.h - which instruction set's loops run
 *
 * Files of loops are compiled once for each instruction set, each time with another NTP_ISA, and
 * end in a table of functions.  Each room has its own tables and picks one by NTP__CPU_PICK.
 */
#ifndef NTP_CPU_H
#define NTP_CPU_H

#include <stdbool.h>

/* The instruction sets that a mask allows. */
enum { NTP__CPU_AVX2 = 1, NTP__CPU_AVX512 = 2, NTP__CPU_ALL = -1 };

/* Does this processor have AVX2 and fused products (FMA), and does the mask allow these?  The mask is for tests.
 * Benchmarks define a function of this name themselves: the linker then leaves out that of the archive. */
bool ntp__cpu_has_avx2(int mask);

/* And AVX-512 with its instructions on bytes (BW, VBMI), which few loops have?  No without AVX2. */
bool ntp__cpu_has_avx512(int mask);

/* The address of the table of the best instruction set. */
#ifdef NTP_HAVE_AVX2
#  define NTP__CPU_PICK(mask, base, avx2) (ntp__cpu_has_avx2(mask) ? &(avx2) : &(base))
#else
#  define NTP__CPU_PICK(mask, base, avx2) ((void) (mask), &(base))
#endif

#endif
