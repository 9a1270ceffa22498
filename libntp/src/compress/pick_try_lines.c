/* SPDX-License-Identifier: MIT */
/*
 * pick_try_lines.c - the inner loop for this processor
 */
#include "compress/search.h"

extern ntp__try_lines_fn ntp__try_lines_base, ntp__try_lines_avx2;

ntp__try_lines_fn *ntp__try_lines_for(int mask)
{
    return *NTP__CPU_PICK(mask, ntp__try_lines_base, ntp__try_lines_avx2);
}
