/* SPDX-License-Identifier: MIT */
/*
 * pick_kernels.c - the table of texel kernels for this processor
 */
#include "texel/kernels.h"

extern const ntp__kernels_table ntp__kernels_base, ntp__kernels_avx2;

const ntp__kernels_table *ntp__kernels(int mask)
{
    return NTP__CPU_PICK(mask, ntp__kernels_base, ntp__kernels_avx2);
}
