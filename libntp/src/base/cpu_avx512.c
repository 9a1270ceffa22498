/* SPDX-License-Identifier: MIT */
/*
 * cpu_avx512.c - do loops for AVX-512 run?
 *
 * Apart from cpu.c, so that a test can leave out one of the two and keep the other.
 */
#include "base/cpu.h"

#ifdef NTP_HAVE_AVX512
#  ifdef __has_include
#    if __has_include(<sys/platform/x86.h>) /* of glibc 2.33 and later */
#      include <sys/platform/x86.h>
#    endif
#  endif

static bool has_avx512(void)
{
#  ifdef CPU_FEATURE_ACTIVE
    return CPU_FEATURE_ACTIVE(AVX512F) && CPU_FEATURE_ACTIVE(AVX512BW) &&
           CPU_FEATURE_ACTIVE(AVX512_VBMI);
#  else
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512vbmi");
#  endif
}
#endif

bool ntp__cpu_has_avx512(int mask)
{
#ifdef NTP_HAVE_AVX512
    return (mask & NTP__CPU_AVX512) != 0 && ntp__cpu_has_avx2(mask) && has_avx512();
#else
    (void) mask;
    return false;
#endif
}
