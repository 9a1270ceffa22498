/* SPDX-License-Identifier: MIT */
/*
 * cpu.c - which instruction set's kernels run; no state, the processor is asked each time
 */
#include "texel/kernels.h"
#include "to_height/shared/solver_kernels.h"

extern const ntp__kernels_table ntp__kernels_base;
#ifdef NTP_HAVE_AVX2
extern const ntp__kernels_table ntp__kernels_avx2;
#endif

const ntp__kernels_table *ntp__kernels(int mask)
{
#ifdef NTP_HAVE_AVX2
    if ((mask & NTP__CPU_AVX2) && __builtin_cpu_supports("avx2"))
        return &ntp__kernels_avx2;
#else
    (void) mask;
#endif
    return &ntp__kernels_base;
}

extern const ntp__solver_kernels ntp__solver_kernels_base;
#ifdef NTP_HAVE_AVX2
extern const ntp__solver_kernels ntp__solver_kernels_avx2;
#endif

const ntp__solver_kernels *ntp__solver_kernels_for(int mask)
{
#ifdef NTP_HAVE_AVX2
    if ((mask & NTP__CPU_AVX2) && __builtin_cpu_supports("avx2"))
        return &ntp__solver_kernels_avx2;
#else
    (void) mask;
#endif
    return &ntp__solver_kernels_base;
}
