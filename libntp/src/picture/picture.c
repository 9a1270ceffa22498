/* SPDX-License-Identifier: MIT */
/*
 * picture.c - what the operations share that paint a picture of a texture
 */
#include "picture/picture.h"

#include "base/cpu.h"
#include "picture/picture_kernels.h"

#include <string.h>

extern const ntp__picture_kernels ntp__picture_loops_base, ntp__picture_loops_avx2;

const ntp__picture_kernels *ntp__picture_loops(void)
{
    return NTP__CPU_PICK(NTP__CPU_ALL, ntp__picture_loops_base, ntp__picture_loops_avx2);
}

ntp_status ntp__check_painting(const ntp_image *dst, const ntp_const_image *src,
                               int32_t min_channels)
{
    if (dst == NULL)
        return NTP_ERR_ARGUMENT;
    ntp_const_image target = ntp_image_as_const(dst);
    NTP__TRY(ntp__check_picture(&target, min_channels, 4));
    if (target.channels == 2)
        return NTP_ERR_FORMAT;
    if (!ntp__same_size(&target, src))
        return NTP_ERR_SHAPE;
    bool in_place = target.data == src->data;
    if (in_place &&
        (target.type != src->type || target.row_stride != src->row_stride ||
         target.pixel_stride != src->pixel_stride || target.ring_rows != src->ring_rows))
        return NTP_ERR_OVERLAP;
    return NTP_OK;
}

void ntp__fill_group(ntp__block *block, int32_t n)
{
    for (int32_t k = 0; k < 4; k++)
        memset(block->c[k] + n, 0, (size_t) (ntp__whole(n) - n) * sizeof block->c[k][0]);
}

void ntp__pack_opaque(const ntp_image *dst, ntp__block *rgb, int32_t x, int32_t y, int32_t n)
{
    for (int32_t i = 0; dst->channels == 4 && i < n; i++)
        rgb->c[3][i] = 255;
    ntp__pack(dst, rgb, x, y, n, dst->channels);
}
