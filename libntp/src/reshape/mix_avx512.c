/* SPDX-License-Identifier: MIT */
/*
 * mix_avx512.c - vectors blended in double, as mix_avx2.c does it, with AVX-512
 */
#include "reshape/mix_avx2.h"

#include <immintrin.h>

#define NUMBER       __m512d
#define ELEMENT      double
#define OP(op)       _mm512_##op##_pd
#define MIXED        mixed
#define LOAD(from)   _mm512_cvtps_pd(_mm256_loadu_ps(from))
#define STORE(to, v) _mm256_storeu_ps(to, _mm512_cvtpd_ps(v))
#include "reshape/mixed_tmpl.h"

void ntp__mix_doubles_avx512(ntp__mix_planes v, ntp__mix_planes base, ntp__mix_planes detail,
                             int32_t n, const ntp__mix_terms *t)
{
    mixed(v, NULL, base, detail, n, t);
}
