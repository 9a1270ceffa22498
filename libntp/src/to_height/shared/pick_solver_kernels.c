/* SPDX-License-Identifier: MIT */
/*
 * pick_solver_kernels.c - the table of the solvers' loops for this processor
 */
#include "to_height/shared/solver_kernels.h"

extern const ntp__solver_kernels ntp__solver_kernels_base, ntp__solver_kernels_avx2;

const ntp__solver_kernels *ntp__solver_kernels_for(int mask)
{
    return NTP__CPU_PICK(mask, ntp__solver_kernels_base, ntp__solver_kernels_avx2);
}
