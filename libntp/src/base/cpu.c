/* SPDX-License-Identifier: MIT */
/*
 * cpu.c - which instruction set's loops run
 *
 * The library keeps no state, so each time this is looked up where it is known: glibc asks the
 * processor when a program starts.  Else GCC's library does so too, before main, which takes a hundredth
 * of the time of a check of a small file.
 */
#include "base/cpu.h"

#ifdef NTP_HAVE_AVX2
#  ifdef __has_include
#    if __has_include(<sys/platform/x86.h>) /* of glibc 2.33 and later */
#      include <sys/platform/x86.h>
#    endif
#  endif

static bool has_avx2(void)
{
#  ifdef CPU_FEATURE_ACTIVE
    return CPU_FEATURE_ACTIVE(AVX2) && CPU_FEATURE_ACTIVE(FMA);
#  else
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#  endif
}
#endif

bool ntp__cpu_has_avx2(int mask)
{
#ifdef NTP_HAVE_AVX2
    return (mask & NTP__CPU_AVX2) != 0 && has_avx2();
#else
    (void) mask;
    return false;
#endif
}
