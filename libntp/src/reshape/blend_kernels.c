/* SPDX-License-Identifier: MIT */
/*
 * blend_kernels.c - the loops of ntp_blend, compiled once for each instruction set
 */
#include "reshape/blend_kernels.h"

#include <math.h>

#define CONCAT_(a, b) a##b
#define CONCAT(a, b)  CONCAT_(a, b)

static void reoriented(ntp__vectors *restrict out, double *restrict size,
                       const ntp__vectors *restrict base, const ntp__vectors *restrict detail,
                       const int32_t *restrict alpha, int32_t n, const ntp__mixture *restrict how)
{
    const ntp__mixture h = *how;
    n = n / NTP__KERNEL_LANES *
        NTP__KERNEL_LANES; /* no remainder, which would be code of its own */
    for (int32_t i = 0; i < n; i++) {
        double a = h.by_alpha * alpha[i] + h.opaque, bx = base->c[0][i], by = base->c[1][i];
        double bz = base->c[2][i], dx = h.strength * (detail->c[0][i] * a);
        double dy = h.turn * (detail->c[1][i] * a);
        double dz = detail->c[2][i] * a + (h.most - a) * h.filled, level = fabs(bz) + h.mb;
        double tz = bz + h.mb, dot = tz * dz - bx * dx - by * dy, scale = tz * h.mb;
        double z = dot * tz - scale * dz, sum = fabs(bx) + fabs(by) + level;
        size[i] = 2 * sum * sum * (fabs(dx) + fabs(dy) + fabs(dz));
        out->c[0][i] = dot * bx + scale * dx;
        out->c[1][i] = dot * by + scale * dy;
        out->c[2][i] = ((z < 0) & (bz >= 0) & (detail->c[2][i] >= 0)) ? 0 : z;
    }
}

static void others(ntp__vectors *restrict out, double *restrict size,
                   const ntp__vectors *restrict base, const ntp__vectors *restrict detail,
                   const int32_t *restrict alpha, int32_t n, const ntp__mixture *restrict how)
{
    const ntp__mixture h = *how;
    n = n / NTP__KERNEL_LANES *
        NTP__KERNEL_LANES; /* no remainder, which would be code of its own */
    const double reach = h.md * h.most;
    for (int32_t i = 0; i < n; i++) {
        double a = h.by_alpha * alpha[i] + h.opaque, bx = base->c[0][i], by = base->c[1][i];
        double bz = base->c[2][i], dx = h.strength * (detail->c[0][i] * a);
        double dy = h.turn * (detail->c[1][i] * a);
        double dz = detail->c[2][i] * a + (h.most - a) * h.filled;
        double z = h.base_z * bz * reach + h.detail_z * dz * h.mb + h.product * bz * dz;
        size[i] = (fabs(bx) + fabs(by) + fabs(bz)) * (reach + fabs(dz)) +
                  h.mb * (fabs(dx) + fabs(dy) + fabs(dz));
        out->c[0][i] = bx * reach + dx * h.mb;
        out->c[1][i] = by * reach + dy * h.mb;
        out->c[2][i] = ((z < 0) & (bz >= 0) & (detail->c[2][i] >= 0)) ? 0 : z;
    }
}

extern const ntp__blend_kernels CONCAT(ntp__blend_loops_, NTP_ISA);
const ntp__blend_kernels CONCAT(ntp__blend_loops_, NTP_ISA) = { reoriented, others };
