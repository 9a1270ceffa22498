/* SPDX-License-Identifier: MIT */
/* simd.h - which instruction set's loops run: as the library asks, glibc knows since the program's start */
#ifndef NTPIO_SIMD_H
#define NTPIO_SIMD_H

#include <stdbool.h>

#ifdef NTPIO_NO_SIMD
#  undef NTPIO_HAVE_AVX2
#  undef NTPIO_HAVE_AVX512
#endif

#ifdef NTPIO_HAVE_AVX2
#  ifdef __has_include
#    if __has_include(<sys/platform/x86.h>) /* of glibc 2.33 and later */
#      include <sys/platform/x86.h>
#    endif
#  endif

static inline bool ntpio__has_avx2(void)
{
#  ifdef CPU_FEATURE_ACTIVE
    return CPU_FEATURE_ACTIVE(AVX2);
#  else
    return __builtin_cpu_supports("avx2");
#  endif
}

/* Shifts by any register.  Where much is shifted, it is done twice: with them, and without. */
static inline bool ntpio__has_bmi2(void)
{
#  ifdef CPU_FEATURE_ACTIVE
    return CPU_FEATURE_ACTIVE(BMI2);
#  else
    return __builtin_cpu_supports("bmi2");
#  endif
}

#  define NTPIO_IN_BMI2 __attribute__((target("bmi2")))
#endif

/* A function that is part of its caller: what the caller hands it may be constants, or instructions. */
#ifdef __GNUC__
#  define NTPIO_PART static inline __attribute__((always_inline))
#else
#  define NTPIO_PART static inline
#endif

#ifdef NTPIO_HAVE_AVX512
static inline bool ntpio__has_avx512(void)
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

#endif
