/* SPDX-License-Identifier: MIT */
/*
 * picture.c - what the operations share that paint a picture of a texture
 */
#include "picture/picture.h"

#include "base/cpu.h"
#include "picture/paint_avx2.h"
#include "picture/picture_kernels.h"
#include "texel/level.h"

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

#ifdef NTP_HAVE_AVX2
static void paint_again(const ntp__painter *p, ntp__odd_texels *odd)
{
    ntp__block out;
    if (odd->n == 0)
        return;
    ntp__fill_group(&odd->block, odd->n);
    odd->block.any_broken = false;
    p->again(p->job, &out, odd);
    for (int32_t i = 0; i < odd->n; i++) {
        const uint8_t color[3] = { (uint8_t) out.c[0][i], (uint8_t) out.c[1][i],
                                   (uint8_t) out.c[2][i] };
        ntp__paint(ntp__at_mut(p->dst, odd->x[i], odd->y[i]), 3, color);
    }
    odd->n = 0;
}

bool ntp__paint_packed(const ntp__painter *p, const ntp_rect *rect)
{
    const ntp_image *dst = p->dst;
    const ntp_const_image *src = p->src;
    uint8_t bits[NTP__BLOCK / 8];
    ntp__odd_texels odd;
    odd.n = 0;
    if (src->channels != 3 || src->type == NTP_TYPE_F32 || !ntp__is_packed(src) ||
        src->encoding != NTP_ENCODING_STANDARD || dst->channels != 3 || dst->pixel_stride != 3 ||
        dst->data == src->data || !ntp__cpu_has_avx2(NTP__CPU_ALL))
        return false;
    for (int32_t y = rect->y0; y < rect->y1; y++) {
        for (int32_t x = rect->x0; x < rect->x1; x += NTP__BLOCK) {
            const int32_t n = rect->x1 - x < NTP__BLOCK ? rect->x1 - x : NTP__BLOCK;
            const bool deep = src->type == NTP_TYPE_U16;
            const int32_t found =
                p->paint(p->job, ntp__at_mut(dst, x, y), bits, ntp__at(src, x, y), n, deep);
            if (odd.n + found > NTP__BLOCK)
                paint_again(p, &odd);
            if (found > 0)
                ntp__gather_odd_avx2(p, &odd, bits, x, y, n);
        }
        /* In a ring, other rows take the place of this one. */
        if (dst->ring_rows > 0 || y + 1 == rect->y1)
            paint_again(p, &odd);
    }
    return true;
}
#endif
