/* SPDX-License-Identifier: MIT */
/*
 * validate.c - the verdicts on many texels, as a byte of flags for each
 */
#include "base/view.h"
#include "texel/judged.h"
#include "texel/kernels.h"
#include "texel/level.h"

#include <string.h>

enum { PASSES = NTP_FLAG_NEIGHBOR | NTP_FLAG_ROUNDED | NTP_FLAG_EXACT };

/* Turns the flags of the kernel into those of ntp_validate.  Masks hold what differs between
 * encodings, so that one loop serves all of them. */
static void finish_flags(uint8_t *restrict flags, const ntp__block *block, int32_t n, int32_t m,
                         ntp_encoding encoding, bool keep)
{
    const uint32_t mirrored = NTP__MIRRORED | NTP_FLAG_Z_NEGATIVE;
    bool xy = encoding == NTP_ENCODING_XY;
    uint32_t kept = xy ? NTP_FLAG_XY_TOO_LONG : 0xff & ~(uint32_t) NTP__MIRRORED;
    uint32_t of_none = xy ? PASSES : 0;
    uint32_t of_mirrored = keep && encoding == NTP_ENCODING_STANDARD ? NTP_FLAG_EXACT : 0;
    for (int32_t i = 0; i < n; i++) {
        uint32_t f = flags[i];
        f |= (f & mirrored) == mirrored ? of_mirrored : 0;
        f &= kept;
        f |= f == 0 ? of_none : 0;
        int32_t r = block->c[0][i], g = block->c[1][i], b = block->c[2][i];
        int32_t none = (r | g | b) == 0, all = (r & g & b) == m, clear = block->c[3][i] == 0;
        f |= (uint32_t) (none | all | clear) * NTP_FLAG_UNUSED;
        flags[i] = (uint8_t) f;
    }
}

static void flag_run(uint8_t *flags, const ntp__block *block, int32_t n, int32_t m,
                     ntp_encoding encoding, bool keep)
{
    int32_t want[NTP__BLOCK];
    const ntp__kernels_table *kernels = ntp__kernels(NTP__CPU_ALL);
    kernels->judge(flags, want, block->c[0], block->c[1], block->c[2], n, m,
                   encoding == NTP_ENCODING_ZZERO);
    finish_flags(flags, block, n, m, encoding, keep);
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
    ntp_encoding encoding =
        src->encoding == NTP_ENCODING_VECTOR ? NTP_ENCODING_STANDARD : src->encoding;
    for (int32_t y = rect.y0; y < rect.y1; y++) {
        for (int32_t x = rect.x0; x < rect.x1; x += NTP__BLOCK) {
            int32_t n = rect.x1 - x < NTP__BLOCK ? rect.x1 - x : NTP__BLOCK;
            ntp__block block;
            uint8_t flags[NTP__BLOCK];
            ntp__unpack(&block, src, x, y, n);
            flag_run(flags, &block, n, ntp__max(src->type), encoding, keep_negative_z != 0);
            store(mask, flags, x, y, n);
        }
    }
    return NTP_OK;
}
