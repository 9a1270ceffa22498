/* SPDX-License-Identifier: MIT */
/*
 * picture.c - the checks shared by the operations that paint a picture of a texture
 */
#include "picture/picture.h"

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
