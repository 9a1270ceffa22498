/* SPDX-License-Identifier: MIT */
/*
 * without_avx512.h - lets a test run the library with and without AVX-512, as without_avx2.h does with AVX2
 */
#ifndef WITHOUT_AVX512_H
#define WITHOUT_AVX512_H

#include "base/cpu.h"

static bool allowed_512; /* AVX-512 */

bool ntp__cpu_has_avx512(int mask)
{
#ifdef __x86_64__
    return allowed_512 && ntp__cpu_has_avx2(mask) && __builtin_cpu_supports("avx512f") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vbmi");
#else
    (void) mask;
    return false;
#endif
}

#endif
