/* SPDX-License-Identifier: MIT */
/*
 * encode.c - block compression of one channel (BC4) and of normals (BC5)
 *
 * This room stands alone: its results are bytes for a GPU, not texels.
 *   encode.c            blocks of a view, and their bytes
 *   by_angle.c          both channels of normals together
 *   search.h, search.c  the best ends of a block of one channel
 *   try_lines.c         its inner loop, compiled once for each instruction set
 */
#include "compress/block.h"
#include "texel/level.h"

enum { SIDE = NTP_BLOCK_SIDE };

static int32_t level_at(const ntp_const_image *src, int32_t x, int32_t y, int32_t channel)
{
    const void *at = ntp__at(src, x, y);
    switch (src->type) {
    case NTP_TYPE_U8:
        return 257 * ((const uint8_t *) at)[channel];
    case NTP_TYPE_U16:
        return ((const uint16_t *) at)[channel];
    case NTP_TYPE_F32:
        break;
    }
    return ntp__level_of_unit(((const float *) at)[channel]);
}

/* Beyond the edges of the picture lie texels that nobody sees: they have no weight. */
static void read_block(ntp__block_levels *block, const ntp_const_image *src, int32_t x, int32_t y,
                       int32_t channels)
{
    for (int32_t i = 0; i < NTP__TEXELS; i++) {
        const int32_t tx = x + i % SIDE, ty = y + i / SIDE;
        block->seen[i] = tx < src->width && ty < src->height;
        for (int32_t c = 0; c < channels; c++)
            block->level[c][i] = level_at(src, tx < src->width ? tx : src->width - 1,
                                          ty < src->height ? ty : src->height - 1, c);
    }
}

void ntp__want_levels(ntp__wanted *wanted, const ntp__block_levels *block, int32_t channel)
{
    for (int32_t i = 0; i < NTP__TEXELS; i++) {
        wanted->level[i] = block->level[channel][i];
        wanted->weight[i] = block->seen[i];
    }
}

static void choose_nearest(ntp__coded *coded, const int32_t level[NTP__TEXELS])
{
    int32_t palette[NTP__VALUES];
    ntp__palette(palette, &coded->ends);
    for (int32_t i = 0; i < NTP__TEXELS; i++) {
        int32_t least = INT32_MAX;
        for (int32_t k = 0; k < NTP__VALUES; k++) {
            const int32_t off = ntp__abs(palette[k] - NTP__PARTS * level[i]);
            if (off < least) {
                least = off;
                coded->chosen[i] = (uint8_t) k;
            }
        }
    }
}

/* The index in the file of the values from the low end to the high one. */
static uint32_t index_of(const ntp__ends *ends, uint32_t value)
{
    static const uint8_t SEVENTHS[NTP__VALUES] = { 1, 7, 6, 5, 4, 3, 2, 0 };
    static const uint8_t FIFTHS[NTP__VALUES] = { 0, 2, 3, 4, 5, 1, 6, 7 };
    return (ends->parts == 7 ? SEVENTHS : FIFTHS)[value];
}

static void write_block(uint8_t *out, const ntp__coded *coded)
{
    const bool sevenths = coded->ends.parts == 7;
    uint64_t bits = 0;
    for (uint32_t i = 0; i < NTP__TEXELS; i++)
        bits |= (uint64_t) index_of(&coded->ends, coded->chosen[i]) << 3 * i;
    out[0] = (uint8_t) (sevenths ? coded->ends.high : coded->ends.low);
    out[1] = (uint8_t) (sevenths ? coded->ends.low : coded->ends.high);
    for (uint32_t i = 0; i < 6; i++)
        out[2 + i] = (uint8_t) (bits >> 8 * i);
}

static void encode_block(uint8_t *out, const ntp__block_levels *block, int32_t channels,
                         ntp_block_quality quality)
{
    ntp__coded coded[2];
    for (int32_t c = 0; c < channels; c++) {
        ntp__wanted wanted;
        ntp__want_levels(&wanted, block, c);
        coded[c].ends = ntp__search_ends(&wanted, quality != NTP_BLOCK_QUICK);
        choose_nearest(&coded[c], block->level[c]);
    }
    if (channels == 2 && quality == NTP_BLOCK_BY_ANGLE)
        ntp__code_by_angle(coded, block);
    for (int32_t c = 0; c < channels; c++)
        write_block(out + 8 * c, &coded[c]);
}

/* Does the area hold whole blocks? */
static bool is_of_blocks(const ntp_rect *area, const ntp_const_image *src)
{
    return area->x0 % SIDE == 0 && area->y0 % SIDE == 0 &&
           (area->x1 % SIDE == 0 || area->x1 == src->width) &&
           (area->y1 % SIDE == 0 || area->y1 == src->height);
}

static ntp_status encode(uint8_t *dst, ptrdiff_t row_stride, const ntp_const_image *src,
                         const ntp_block_options *how, const ntp_rect *area, int32_t channels)
{
    const ntp_block_quality quality = how != NULL ? how->quality : NTP_BLOCK_BY_ANGLE;
    ntp_rect rect;
    NTP__TRY(ntp__check_view(src));
    NTP__TRY(ntp__check_area(&rect, src, area));
    if (dst == NULL || (int) quality < NTP_BLOCK_BY_ANGLE || quality > NTP_BLOCK_QUICK ||
        !is_of_blocks(&rect, src))
        return NTP_ERR_ARGUMENT;
    if (src->channels < channels || src->encoding == NTP_ENCODING_VECTOR ||
        (channels == 2 && src->encoding == NTP_ENCODING_HEIGHT))
        return NTP_ERR_FORMAT;
    for (int32_t y = rect.y0; y < rect.y1; y += SIDE) {
        uint8_t *row = dst + (y / SIDE) * row_stride;
        for (int32_t x = rect.x0; x < rect.x1; x += SIDE) {
            ntp__block_levels block;
            read_block(&block, src, x, y, channels);
            encode_block(row + (ptrdiff_t) (x / SIDE) * 8 * channels, &block, channels, quality);
        }
    }
    return NTP_OK;
}

ntp_status ntp_bc4_encode(uint8_t *dst, ptrdiff_t row_stride, const ntp_const_image *src,
                          const ntp_block_options *how, const ntp_rect *area)
{
    return encode(dst, row_stride, src, how, area, 1);
}

ntp_status ntp_bc5_encode(uint8_t *dst, ptrdiff_t row_stride, const ntp_const_image *src,
                          const ntp_block_options *how, const ntp_rect *area)
{
    return encode(dst, row_stride, src, how, area, 2);
}
