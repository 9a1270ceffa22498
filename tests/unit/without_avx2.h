/* SPDX-License-Identifier: MIT */
/*
 * without_avx2.h - lets a test run the library with and without AVX2
 *
 * The function that asks the processor is defined here, so that of the library is left out.
 */
#ifndef WITHOUT_AVX2_H
#define WITHOUT_AVX2_H

#include "base/cpu.h"

static bool allowed; /* AVX2 */

bool ntp__cpu_has_avx2(int mask)
{
#ifdef __x86_64__
    return allowed && (mask & NTP__CPU_AVX2) != 0 && __builtin_cpu_supports("avx2") &&
           __builtin_cpu_supports("fma");
#else
    (void) mask;
    return false;
#endif
}

#endif
