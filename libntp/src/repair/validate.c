/* SPDX-License-Identifier: MIT */
/*
 * validate.c - the verdicts on many texels, as a byte of flags for each
 */
#include "base/view.h"
#include "texel/kernels.h"

#include <string.h>

enum { PASSES = NTP_FLAG_NEIGHBOR | NTP_FLAG_ROUNDED | NTP_FLAG_EXACT };

static ntp__validity validity_of(const ntp_const_image *src, bool keep_negative_z)
{
    const bool xy = src->encoding == NTP_ENCODING_XY;
    return (ntp__validity) { .m = ntp__max(src->type),
                             .zzero = src->encoding == NTP_ENCODING_ZZERO,
                             .keep_negative_z = keep_negative_z,
                             .kept = xy ? NTP_FLAG_XY_TOO_LONG : 0xff,
                             .others = xy ? PASSES : 0 };
}

static void flag_run(ntp__validate_fn *validate, uint8_t *flags, ntp__block *block, int32_t n,
                     const ntp__validity *how)
{
    int32_t *const planes[] = { block->c[0], block->c[1], block->c[2], block->c[3] };
    validate(flags, planes, n, how);
    for (int32_t i = 0; block->any_broken && i < n; i++) {
        if (block->broken[i])
            flags[i] = (uint8_t) ((flags[i] & ~(uint32_t) PASSES) | NTP_FLAG_NOT_FINITE);
    }
}

static void store(const ntp_image *mask, const uint8_t *flags, int32_t x, int32_t y, int32_t n)
{
    uint8_t *d = ntp__at_mut(mask, x, y);
    if (mask->pixel_stride == 1) {
        memcpy(d, flags, (size_t) n);
        return;
    }
    for (int32_t i = 0; i < n; i++, d += mask->pixel_stride)
        *d = flags[i];
}

ntp_status ntp_validate(const ntp_image *mask, const ntp_const_image *src, int32_t keep_negative_z,
                        const ntp_rect *area)
{
    if (mask == NULL)
        return NTP_ERR_ARGUMENT;
    ntp_const_image target = ntp_image_as_const(mask);
    NTP__TRY(ntp__check_normals(src));
    NTP__TRY(ntp__check_view(&target));
    if (mask->type != NTP_TYPE_U8)
        return NTP_ERR_FORMAT;
    if (!ntp__same_size(&target, src))
        return NTP_ERR_SHAPE;
    ntp_rect rect;
    NTP__TRY(ntp__check_area(&rect, src, area));
    const ntp__validity how = validity_of(src, keep_negative_z != 0);
    const bool packed = src->type != NTP_TYPE_F32 && src->channels == 3 && ntp__is_packed(src);
    ntp__kernels_table kernels;
    ntp__pick_kernels(&kernels, NTP__CPU_ALL);
    ntp__validate_rgb_fn *const rgb = packed && !how.zzero ? kernels.validate_rgb : NULL;
    const bool direct = rgb != NULL && mask->pixel_stride == 1;
    const int32_t most = direct ? NTP_MAX_SIDE : NTP__BLOCK;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x += most) {
            int32_t n = rect.x1 - x < most ? rect.x1 - x : most;
            uint8_t flags[NTP__BLOCK], *to = direct ? ntp__at_mut(mask, x, y) : flags;
            if (rgb != NULL) {
                rgb(to, ntp__at(src, x, y), n, &how);
            } else {
                ntp__block block;
                ntp__unpack(&block, src, x, y, n);
                flag_run(kernels.validate, flags, &block, n, &how);
            }
            if (!direct)
                store(mask, flags, x, y, n);
        }
    }
    return NTP_OK;
}
