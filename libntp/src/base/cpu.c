/* SPDX-License-Identifier: MIT */
/*
 * cpu.c - which instruction set's loops run
 *
 * The library keeps no state, so the processor is asked each time.
 */
#include "base/cpu.h"

bool ntp__cpu_has_avx2(int mask)
{
#ifdef NTP_HAVE_AVX2
    return (mask & NTP__CPU_AVX2) != 0 && __builtin_cpu_supports("avx2");
#else
    (void) mask;
    return false;
#endif
}
