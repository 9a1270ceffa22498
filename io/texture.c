/* SPDX-License-Identifier: MIT */
/*
 * texture.c - rows of a texture as GPUs take them: blocks, signed and float samples, bits
 *
 * Numbers are exact, or rounded once, half up: a signed v of -1..1 is (v + 1) / 2 of 0..65535.
 * Floats stay as they are.  Nothing is converted from sRGB.
 */
#include "texture.h"

#include <stdlib.h>
#include <string.h>

#include "blocks.h"
#include "formats.h"
#include "half.h"

typedef struct state {
    ntpio__texture t;
    uint8_t *memory; /* the image, where it was compressed as a whole; else NULL */
    size_t at;       /* in it */
    uint8_t *stored; /* a row of blocks, or of texels */
    size_t stored_size;
    uint8_t *band; /* four rows, decoded from blocks */
    uint32_t band_row;
} state;

static bool is_block(ntpio__texels texels)
{
    return texels >= NTPIO__TEXELS_BC1;
}

/* Of a block, or of a texel. */
static size_t unit_bytes(const ntpio__layout *l)
{
    switch (l->texels) {
    case NTPIO__TEXELS_S8:
    case NTPIO__TEXELS_U8:
    case NTPIO__TEXELS_MASKED:
        return l->stored;
    case NTPIO__TEXELS_U16:
    case NTPIO__TEXELS_S16:
    case NTPIO__TEXELS_F16:
        return 2u * l->stored;
    case NTPIO__TEXELS_F32:
        return 4u * l->stored;
    case NTPIO__TEXELS_BC1:
    case NTPIO__TEXELS_BC4:
        return 8;
    default:
        return 16;
    }
}

static uint32_t smaller(uint32_t side, uint32_t mip)
{
    return side >> mip != 0 ? side >> mip : 1;
}

static uint64_t row_units(const ntpio__texture *t, uint32_t mip)
{
    const uint64_t width = smaller(t->width, mip);
    return is_block(t->layout.texels) ? (width + NTPIO__SIDE - 1) / NTPIO__SIDE : width;
}

uint64_t ntpio__texture_bytes(const ntpio__texture *t, uint32_t mip)
{
    const uint64_t height = smaller(t->height, mip);
    const uint64_t rows =
        is_block(t->layout.texels) ? (height + NTPIO__SIDE - 1) / NTPIO__SIDE : height;
    return row_units(t, mip) * rows * unit_bytes(&t->layout);
}

/* ------------------------------------------------------------------------ the choice */

static uint32_t mips_of(uint32_t width, uint32_t height)
{
    uint32_t count = 1;
    for (uint32_t side = width > height ? width : height; side > 1; side >>= 1)
        count++;
    return count;
}

bool ntpio__texture_check(ntpio_reader *reader, const ntpio__texture *t, ntpio_error *error)
{
    enum { LAYERS_MAX = 6 * 2048 };                 /* of Direct3D and Vulkan */
    const uint64_t TEXELS_MAX = (uint64_t) 1 << 40; /* no sum of bytes overflows */
    const uint32_t mip = reader->limits.mip, picked = reader->limits.layer_and_one;
    if (!ntpio__check_size(reader, t->width, t->height, error))
        return false;
    if ((uint64_t) t->width * t->height > TEXELS_MAX)
        return ntpio__fail(error, NTPIO_ERR_LIMIT, reader->name, "too large for a texture");
    if (t->mips > mips_of(t->width, t->height))
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name,
                           "damaged (%lu mips of %lu x %lu texels)", (unsigned long) t->mips,
                           (unsigned long) t->width, (unsigned long) t->height);
    if (t->layers == 0 || t->layers > LAYERS_MAX)
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "damaged (%lu layers)",
                           (unsigned long) t->layers);
    if (mip >= t->mips)
        return ntpio__fail(error, NTPIO_ERR_USAGE, reader->name,
                           "has no mip %lu: there are %lu, from 0", (unsigned long) mip,
                           (unsigned long) t->mips);
    if (t->layers > 1 && picked == 0)
        return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                           "%s of %lu textures: pick a layer, 0 to %lu",
                           t->cube ? "a cube map" : "an array", (unsigned long) t->layers,
                           (unsigned long) t->layers - 1);
    if (picked > t->layers)
        return ntpio__fail(error, NTPIO_ERR_USAGE, reader->name,
                           "has no layer %lu: there are %lu, from 0", (unsigned long) picked - 1,
                           (unsigned long) t->layers);
    return true;
}

bool ntpio__texture_seek(ntpio_reader *reader, uint64_t at, uint64_t offset, ntpio_error *error)
{
    if (ntpio__can_seek(&reader->source))
        return ntpio__seek(&reader->source, offset) || ntpio__fail_ended(reader, error);
    uint8_t dropped[256];
    for (uint64_t left = offset - at; left != 0;) {
        const size_t some = left < sizeof dropped ? (size_t) left : sizeof dropped;
        if (!ntpio__read_all(reader, dropped, some, error))
            return false;
        left -= some;
    }
    return true;
}

/* ------------------------------------------------------------------------ samples */

static bool is_wide(const ntpio__layout *l)
{
    bool wide = l->texels == NTPIO__TEXELS_S8 || l->texels == NTPIO__TEXELS_U16 ||
                l->texels == NTPIO__TEXELS_S16 || l->texels == NTPIO__TEXELS_BC4 ||
                l->texels == NTPIO__TEXELS_BC5;
    for (int c = 0; l->texels == NTPIO__TEXELS_MASKED && c < l->channels; c++)
        wide = wide || l->is_signed || l->mask[c] > 255 * (l->mask[c] & (~l->mask[c] + 1));
    return wide;
}

static uint32_t half_word(const uint8_t *b)
{
    return (uint32_t) b[0] | (uint32_t) b[1] << 8;
}

static void put_wide(uint8_t *dst, uint32_t level)
{
    const uint16_t wide = (uint16_t) level;
    memcpy(dst, &wide, sizeof wide);
}

/* round((v + top) 65535 / (2 top)), half up, of v / top in -1..1; below -1 counts as -1 */
static uint32_t from_signed(int32_t v, int32_t top)
{
    const int64_t up = v < -top ? 0 : (int64_t) v + top;
    return (uint32_t) ((up * 65535 + top) / (2 * (int64_t) top));
}

static void put_sample(uint8_t *dst, const uint8_t *src, ntpio__texels texels)
{
    uint32_t word;
    switch (texels) {
    case NTPIO__TEXELS_U8:
        dst[0] = src[0];
        break;
    case NTPIO__TEXELS_S8:
        put_wide(dst, from_signed((int32_t) src[0] - (src[0] > 127 ? 256 : 0), 127));
        break;
    case NTPIO__TEXELS_U16:
        put_wide(dst, half_word(src));
        break;
    case NTPIO__TEXELS_S16:
        word = half_word(src);
        put_wide(dst, from_signed((int32_t) word - (word > 32767 ? 65536 : 0), 32767));
        break;
    default:
        word = texels == NTPIO__TEXELS_F16 ? ntpio__from_half(half_word(src)) : ntpio__u32(src);
        memcpy(dst, &word, sizeof word);
        break;
    }
}

static void plain_row(const ntpio__layout *l, uint8_t *dst, const uint8_t *src, uint32_t width,
                      size_t sample)
{
    const size_t unit = unit_bytes(l), stored = unit / l->stored;
    for (uint32_t x = 0; x < width; x++, src += unit) {
        for (size_t c = 0; c < l->channels; c++, dst += sample) {
            const size_t from = l->order[0] != 0 ? (size_t) (l->order[c] - '0') : c;
            put_sample(dst, src + from * stored, l->texels);
        }
    }
}

static uint32_t masked(uint32_t texel, uint32_t mask, bool is_signed, bool wide)
{
    if (mask == 0)
        return 0;
    uint32_t shift = 0;
    while ((mask >> shift & 1) == 0)
        shift++;
    const uint32_t top = mask >> shift, value = (texel & mask) >> shift;
    if (is_signed) {
        const int64_t half = (int64_t) (top >> 1) + 1;
        const int64_t v = value >= half ? (int64_t) value - 2 * half : (int64_t) value;
        return from_signed((int32_t) v, (int32_t) (half - 1));
    }
    const uint64_t full = wide ? 65535 : 255;
    return (uint32_t) ((2 * full * value + top) / (2 * (uint64_t) top));
}

static void masked_row(const ntpio__layout *l, uint8_t *dst, const uint8_t *src, uint32_t width,
                       bool wide)
{
    for (uint32_t x = 0; x < width; x++, src += l->stored) {
        uint8_t bytes[4] = { 0 };
        memcpy(bytes, src, l->stored);
        const uint32_t texel = ntpio__u32(bytes);
        for (int c = 0; c < l->channels; c++) {
            const uint32_t level = masked(texel, l->mask[c], l->is_signed, wide);
            if (wide)
                put_wide(dst, level);
            else
                dst[0] = (uint8_t) level;
            dst += wide ? 2 : 1;
        }
    }
}

/* ------------------------------------------------------------------------ blocks */

static void decode_block(const ntpio__layout *l, const uint8_t *block, uint8_t *rgba,
                         uint16_t *levels)
{
    switch (l->texels) {
    case NTPIO__TEXELS_BC1:
        ntpio__bc1(block, rgba);
        break;
    case NTPIO__TEXELS_BC2:
        ntpio__bc2(block, rgba);
        break;
    case NTPIO__TEXELS_BC3:
        ntpio__bc3(block, rgba);
        break;
    case NTPIO__TEXELS_BC7:
        ntpio__bc7(block, rgba);
        break;
    case NTPIO__TEXELS_BC4:
        ntpio__bc4(block, l->is_signed, levels, 1);
        break;
    default:
        ntpio__bc4(block, l->is_signed, levels, 2);
        ntpio__bc4(block + 8, l->is_signed, levels + 1, 2);
        break;
    }
}

/* A row of blocks to four rows; what lies beyond the right edge is left out. */
static void decode_band(const state *s, uint32_t width)
{
    const ntpio__layout *l = &s->t.layout;
    const bool wide = is_wide(l);
    const size_t channels = l->channels, unit = unit_bytes(l);
    const size_t row = width * channels * (wide ? 2u : 1u);
    uint8_t rgba[4 * NTPIO__BLOCK_TEXELS];
    uint16_t levels[2 * NTPIO__BLOCK_TEXELS];
    for (uint32_t x = 0; x < width; x += NTPIO__SIDE) {
        decode_block(l, s->stored + x / NTPIO__SIDE * unit, rgba, levels);
        const size_t some = width - x < NTPIO__SIDE ? width - x : NTPIO__SIDE;
        for (size_t y = 0; y < NTPIO__SIDE; y++) {
            uint8_t *dst = s->band + y * row + x * channels * (wide ? 2u : 1u);
            if (wide) {
                memcpy(dst, levels + y * NTPIO__SIDE * channels, some * channels * 2);
                continue;
            }
            for (size_t i = 0; i < some; i++)
                memcpy(dst + i * channels, rgba + (y * NTPIO__SIDE + i) * 4, channels);
        }
    }
}

/* ------------------------------------------------------------------------ rows */

static bool next_stored(ntpio_reader *reader, state *s, ntpio_error *error)
{
    if (s->memory == NULL)
        return ntpio__read_all(reader, s->stored, s->stored_size, error);
    memcpy(s->stored, s->memory + s->at, s->stored_size);
    s->at += s->stored_size;
    return true;
}

/* Two channels that are delivered as red, green and a blue of 0. */
static void widen(uint8_t *row, uint32_t width, size_t sample)
{
    for (size_t x = width; x-- > 0;) {
        memmove(row + x * 3 * sample, row + x * 2 * sample, 2 * sample);
        memset(row + (x * 3 + 2) * sample, 0, sample);
    }
}

static bool next_row(ntpio_reader *reader, state *s, uint8_t *dst, ntpio_error *error)
{
    const ntpio__layout *l = &s->t.layout;
    const uint32_t width = reader->info.width;
    const size_t sample = (size_t) reader->info.sample_bytes, row = width * l->channels * sample;
    if (is_block(l->texels)) {
        if (s->band_row == 0) {
            if (!next_stored(reader, s, error))
                return false;
            decode_band(s, width);
        }
        memcpy(dst, s->band + s->band_row * row, row);
        s->band_row = (s->band_row + 1) % NTPIO__SIDE;
    } else if (!next_stored(reader, s, error)) {
        return false;
    } else if (l->texels == NTPIO__TEXELS_MASKED) {
        masked_row(l, dst, s->stored, width, sample == 2);
    } else {
        plain_row(l, dst, s->stored, width, sample);
    }
    if (reader->info.channels != l->channels)
        widen(dst, width, sample);
    return true;
}

bool ntpio__texture_rows(ntpio_reader *reader, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                         ntpio_error *error)
{
    state *s = reader->state;
    for (uint32_t i = 0; i < count; i++) {
        if (!next_row(reader, s, dst + (ptrdiff_t) i * stride, error))
            return false;
    }
    return true;
}

static int32_t depth_of(const ntpio__layout *l)
{
    return l->texels == NTPIO__TEXELS_F16   ? 16
           : l->texels == NTPIO__TEXELS_F32 ? 32
           : l->texels == NTPIO__TEXELS_S8  ? 8
                                            : (is_wide(l) ? 16 : 8);
}

bool ntpio__texture_start(ntpio_reader *reader, const ntpio__texture *t, uint8_t *memory,
                          ntpio_error *error)
{
    ntpio_info *info = &reader->info;
    const ntpio__layout *l = &t->layout;
    const uint32_t mip = reader->limits.mip;
    const bool is_float = l->texels == NTPIO__TEXELS_F16 || l->texels == NTPIO__TEXELS_F32;
    state *s = calloc(1, sizeof *s);
    if (s == NULL) {
        free(memory);
        return ntpio__fail_memory(error, reader->name);
    }
    reader->state = s;
    s->t = *t;
    s->memory = memory;
    info->width = smaller(t->width, mip);
    info->height = smaller(t->height, mip);
    info->alpha = l->alpha;
    info->sample_bytes = is_float ? 4 : is_wide(l) ? 2 : 1;
    info->bit_depth = depth_of(l);
    info->red_green = l->channels == 2 && !l->alpha;
    info->channels = info->red_green && reader->limits.pairs_as_rgb ? 3 : l->channels;
    info->blocks = is_block(l->texels);
    info->lossy = info->blocks && l->texels != NTPIO__TEXELS_BC4 && l->texels != NTPIO__TEXELS_BC5;
    info->mips = t->mips;
    info->layers = t->layers;
    memcpy(info->layout, t->name, sizeof info->layout);
    s->stored_size = (size_t) (row_units(t, mip) * unit_bytes(l));
    s->stored = malloc(s->stored_size);
    if (info->blocks)
        s->band =
            malloc((size_t) info->width * l->channels * (size_t) info->sample_bytes * NTPIO__SIDE);
    if (s->stored == NULL || (info->blocks && s->band == NULL))
        return ntpio__fail_memory(error, reader->name);
    return true;
}

void ntpio__texture_close(ntpio_reader *reader)
{
    state *s = reader->state;
    if (s == NULL)
        return;
    free(s->memory);
    free(s->stored);
    free(s->band);
    free(s);
}
