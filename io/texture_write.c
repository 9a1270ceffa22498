/* SPDX-License-Identifier: MIT */
/*
 * texture_write.c - writes DDS with the header of DirectX 10, and KTX2
 *
 * The rows are kept until the last one, as mips are made of the whole picture and KTX2 begins with
 * the smallest.  The caller makes mips and blocks.  RGB gets an opaque alpha: few programs read
 * three channels.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats.h"

enum {
    SIDE = 4, /* of a block */
    BC4_BYTES = 8,
    BC5_BYTES = 16,
    MIPS_MAX = 32,
    DDS_HEADER = 128 + 20,
    KTX2_HEADER = 80,
    KTX2_INDEX = 24, /* bytes for each mip */
    KTX2_ALIGNMENT = 4
};

/* A kind of texels, as the files name it. */
typedef struct kind {
    uint8_t channels;
    uint8_t bytes; /* of a texel, or of a block */
    bool blocks;
    uint8_t dxgi, vulkan;
    uint8_t model; /* of colors, in the data format descriptor of KTX2 */
} kind;

enum { MODEL_PLAIN = 1, MODEL_BC4 = 131, MODEL_BC5 = 132 };

static const kind BC4 = { 1, BC4_BYTES, true, 80, 139, MODEL_BC4 };
static const kind BC5 = { 2, BC5_BYTES, true, 83, 141, MODEL_BC5 };
static const kind PLAIN[] = {
    { 1, 1, false, 61, 9, MODEL_PLAIN },  { 1, 2, false, 56, 70, MODEL_PLAIN },
    { 2, 2, false, 49, 16, MODEL_PLAIN }, { 2, 4, false, 35, 77, MODEL_PLAIN },
    { 4, 4, false, 28, 37, MODEL_PLAIN }, { 4, 8, false, 11, 91, MODEL_PLAIN },
};

typedef struct texture_state {
    kind kind;
    uint32_t mips;
    size_t texel;   /* bytes that the caller gives */
    uint8_t *whole; /* the picture */
    uint8_t *level; /* a mip of it */
    uint8_t *made;  /* a mip as the file has it */
} texture_state;

static uint32_t side_at(uint32_t side, uint32_t mip)
{
    return side >> mip > 1 ? side >> mip : 1;
}

static size_t level_bytes(const ntpio_writer *w, uint32_t mip)
{
    const texture_state *s = w->state;
    size_t width = side_at(w->options.width, mip), height = side_at(w->options.height, mip);
    if (s->kind.blocks) {
        width = (width + SIDE - 1) / SIDE;
        height = (height + SIDE - 1) / SIDE;
    }
    return width * height * s->kind.bytes;
}

static kind kind_of(const ntpio_write_options *o)
{
    const ntpio_blocks blocks = o->texture != NULL ? o->texture->blocks : NTPIO_BLOCKS_NONE;
    if (blocks != NTPIO_BLOCKS_NONE)
        return blocks == NTPIO_BLOCKS_BC4 ? BC4 : BC5;
    const int channels = o->channels == 3 ? 4 : o->channels;
    size_t i = 0;
    while (PLAIN[i].channels != channels || PLAIN[i].bytes != channels * o->sample_bytes)
        i++;
    return PLAIN[i];
}

static bool texture_open(ntpio_writer *w, ntpio_error *error)
{
    const ntpio_write_options *o = &w->options;
    texture_state *s = calloc(1, sizeof *s);
    w->state = s;
    if (s == NULL)
        return ntpio__fail_memory(error, w->name);
    s->kind = kind_of(o);
    s->texel = (size_t) o->channels * (size_t) o->sample_bytes;
    s->mips = 1;
    while (o->texture != NULL && o->texture->mips &&
           (o->width >> s->mips != 0 || o->height >> s->mips != 0))
        s->mips++;
    const uint64_t texels = (uint64_t) o->width * o->height;
    if (texels > SIZE_MAX / 16)
        return ntpio__fail_memory(error, w->name);
    s->whole = malloc((size_t) texels * s->texel);
    s->level = s->mips > 1 ? malloc((size_t) texels * s->texel) : NULL;
    s->made = malloc(level_bytes(w, 0));
    return (s->whole != NULL && s->made != NULL && (s->mips == 1 || s->level != NULL)) ||
           ntpio__fail_memory(error, w->name);
}

static bool texture_rows(ntpio_writer *w, const uint8_t *src, ptrdiff_t stride, uint32_t count,
                         ntpio_error *error)
{
    texture_state *s = w->state;
    const size_t row = w->options.width * s->texel;
    (void) error;
    for (uint32_t y = 0; y < count; y++)
        memcpy(s->whole + (w->row + y) * row, src + (ptrdiff_t) y * stride, row);
    return true;
}

/* ------------------------------------------------------------------------ levels */

static void put_plain(const ntpio_writer *w, const uint8_t *from, size_t texels)
{
    const texture_state *s = w->state;
    const size_t sample = (size_t) w->options.sample_bytes;
    const bool swap = sample == 2 && !ntpio__little_endian();
    for (size_t i = 0; i < texels; i++) {
        uint8_t *to = s->made + i * s->kind.bytes;
        memset(to, 255, s->kind.bytes);
        memcpy(to, from + i * s->texel, s->texel);
        for (size_t k = 0; swap && k < s->texel; k += 2) {
            const uint8_t first = to[k];
            to[k] = to[k + 1];
            to[k + 1] = first;
        }
    }
}

/* Makes a mip as the file has it. */
static bool make_level(ntpio_writer *w, uint32_t mip, ntpio_error *error)
{
    const texture_state *s = w->state;
    const ntpio_texture *how = w->options.texture;
    const uint32_t width = side_at(w->options.width, mip), height = side_at(w->options.height, mip);
    const uint8_t *texels = s->whole;
    bool ok = true;
    if (mip > 0) {
        ok = how->make_mip(how->context, s->level, width, height, s->whole);
        texels = s->level;
    }
    if (ok && s->kind.blocks)
        ok = how->compress(how->context, s->made, texels, width, height);
    else if (ok)
        put_plain(w, texels, (size_t) width * height);
    return ok || ntpio__fail(error, NTPIO_ERR_WRITE, w->name, "a mip cannot be made");
}

static bool write_level(ntpio_writer *w, uint32_t mip, ntpio_error *error)
{
    const texture_state *s = w->state;
    return make_level(w, mip, error) &&
           ntpio__output_write(w->output, s->made, level_bytes(w, mip), error);
}

/* ------------------------------------------------------------------------ DDS */

static void put(uint8_t *at, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        at[i] = (uint8_t) (value >> 8 * i);
}

static bool write_dds(ntpio_writer *w, ntpio_error *error)
{
    enum {
        CAPS_SIZE_FORMAT = 0x1007,
        HAS_MIPS = 0x20000,
        HAS_SIZE = 0x80000,
        HAS_PITCH = 0x8,
        FOURCC = 0x4,
        TEXTURE = 0x1000,
        TEXTURE_WITH_MIPS = 0x401008,
        FLAT = 3 /* of two dimensions */
    };
    const texture_state *s = w->state;
    const ntpio_write_options *o = &w->options;
    uint8_t h[DDS_HEADER] = "DDS ";
    put(h + 4, 124, 4);
    put(h + 8,
        CAPS_SIZE_FORMAT | (s->kind.blocks ? HAS_SIZE : HAS_PITCH) | (s->mips > 1 ? HAS_MIPS : 0),
        4);
    put(h + 12, o->height, 4);
    put(h + 16, o->width, 4);
    put(h + 20, s->kind.blocks ? level_bytes(w, 0) : (uint64_t) o->width * s->kind.bytes, 4);
    put(h + 28, s->mips, 4);
    put(h + 76, 32, 4);
    put(h + 80, FOURCC, 4);
    memcpy(h + 84, "DX10", 4);
    put(h + 108, s->mips > 1 ? TEXTURE_WITH_MIPS : TEXTURE, 4);
    put(h + 128, s->kind.dxgi, 4);
    put(h + 132, FLAT, 4);
    put(h + 140, 1, 4);
    bool ok = ntpio__output_write(w->output, h, sizeof h, error);
    for (uint32_t mip = 0; ok && mip < s->mips; mip++)
        ok = write_level(w, mip, error);
    return ok;
}

/* ------------------------------------------------------------------------ KTX2 */

/* The basic data format descriptor: linear numbers, not colors.  Returns its size. */
static size_t put_descriptor(uint8_t *at, const ntpio_writer *w)
{
    enum { BEFORE = 4, BLOCK = 24, SAMPLE = 16, VERSION = 2, BT709 = 1, LINEAR = 1, ALPHA = 15 };
    const texture_state *s = w->state;
    const int n = s->kind.channels, bits = 8 * s->kind.bytes / n;
    const size_t size = BEFORE + BLOCK + SAMPLE * (size_t) n;
    put(at, size, 4);
    put(at + 8, VERSION, 2);
    put(at + 10, size - BEFORE, 2);
    at[12] = s->kind.model;
    at[13] = BT709;
    at[14] = LINEAR;
    at[16] = at[17] = s->kind.blocks ? SIDE - 1 : 0;
    at[20] = s->kind.bytes;
    for (int i = 0; i < n; i++) {
        uint8_t *sample = at + BEFORE + BLOCK + SAMPLE * i;
        put(sample, (uint64_t) i * (uint64_t) bits, 2);
        sample[2] = (uint8_t) (bits - 1);
        sample[3] = (uint8_t) (i == 3 ? ALPHA : i);
        put(sample + 12, s->kind.blocks ? UINT32_MAX : bits == 8 ? UINT8_MAX : UINT16_MAX, 4);
    }
    return size;
}

/* One pair of key and value.  Returns its size. */
static size_t put_writer_name(uint8_t *at)
{
    static const char PAIR[] = "KTXwriter\0ntp"; /* and the 0 that ends it */
    put(at, sizeof PAIR, 4);
    memcpy(at + 4, PAIR, sizeof PAIR);
    return (4 + sizeof PAIR + 3) / 4 * 4;
}

/* Where mips begin: at a multiple of 4 and of the size of a texel or block. */
static uint64_t aligned(const texture_state *s, uint64_t at)
{
    const uint64_t unit = s->kind.bytes > KTX2_ALIGNMENT ? s->kind.bytes : KTX2_ALIGNMENT;
    return (at + unit - 1) / unit * unit;
}

static bool write_ktx2(ntpio_writer *w, ntpio_error *error)
{
    static const uint8_t SIGNATURE[12] = { 0xab, 'K',  'T',  'X',  ' ',  '2',
                                           '0',  0xbb, '\r', '\n', 0x1a, '\n' };
    static const uint8_t ZEROS[BC5_BYTES] = { 0 };
    const texture_state *s = w->state;
    uint8_t h[KTX2_HEADER + MIPS_MAX * KTX2_INDEX + 128] = { 0 };
    const size_t descriptor = KTX2_HEADER + KTX2_INDEX * s->mips;
    const size_t size = put_descriptor(h + descriptor, w), names = descriptor + size;
    const size_t end = names + put_writer_name(h + names);
    memcpy(h, SIGNATURE, sizeof SIGNATURE);
    put(h + 12, s->kind.vulkan, 4);
    put(h + 16, s->kind.blocks ? 1 : (uint64_t) w->options.sample_bytes, 4);
    put(h + 20, w->options.width, 4);
    put(h + 24, w->options.height, 4);
    put(h + 36, 1, 4);
    put(h + 40, s->mips, 4);
    put(h + 48, descriptor, 4);
    put(h + 52, size, 4);
    put(h + 56, names, 4);
    put(h + 60, end - names, 4);
    uint64_t at = end;
    for (uint32_t mip = s->mips; mip-- > 0;) {
        at = aligned(s, at);
        put(h + KTX2_HEADER + KTX2_INDEX * mip, at, 8);
        put(h + KTX2_HEADER + KTX2_INDEX * mip + 8, level_bytes(w, mip), 8);
        put(h + KTX2_HEADER + KTX2_INDEX * mip + 16, level_bytes(w, mip), 8);
        at += level_bytes(w, mip);
    }
    bool ok = ntpio__output_write(w->output, h, end, error);
    at = end;
    for (uint32_t mip = s->mips; ok && mip-- > 0;) {
        ok = ntpio__output_write(w->output, ZEROS, (size_t) (aligned(s, at) - at), error) &&
             write_level(w, mip, error);
        at = aligned(s, at) + level_bytes(w, mip);
    }
    return ok;
}

static bool texture_end(ntpio_writer *w, ntpio_error *error)
{
    return w->options.format == NTPIO_DDS ? write_dds(w, error) : write_ktx2(w, error);
}

static void texture_close(ntpio_writer *w)
{
    texture_state *s = w->state;
    free(s->whole);
    free(s->level);
    free(s->made);
    free(s);
}

const ntpio__encoder ntpio__texture_encoder = { texture_open, texture_rows, texture_end,
                                                texture_close };
