/* SPDX-License-Identifier: MIT */
/*
 * dds.c - DirectDraw Surface: the header of DirectX 9, and that of DirectX 10 after it
 *
 * After the headers come the layers, in each of them its mips from the largest; rows have no gaps.
 * Header fields that programs fill in wrongly (pitch, flags, depth of a plain texture) are not
 * looked at.
 */
#include <stdio.h>
#include <string.h>

#include "formats.h"
#include "layouts.h"

enum {
    HEADER_SIZE = 128, /* with the magic number */
    DX10_SIZE = 20,
    AT_HEIGHT = 12,
    AT_WIDTH = 16,
    AT_MIPS = 28,
    AT_FORMAT = 76, /* size, flags, FourCC, bit count, four masks */
    AT_CAPS_2 = 112,
    HAS_ALPHA = 0x1, /* flags of the format */
    ALPHA_ONLY = 0x2,
    HAS_FOURCC = 0x4,
    LUMINANCE = 0x20000,
    SIGNED = 0x80000,
    CUBE = 0x200, /* caps 2 */
    FACES = 0xfc00,
    VOLUME = 0x200000,
    DX10_TEXTURE_1D = 2, /* dimensions */
    DX10_TEXTURE_2D = 3,
    DX10_CUBE = 0x4 /* flag */
};

/* FourCCs, and the older numbers that stand in their place, by the format of DXGI. */
static const struct {
    const char *code; /* or a number below 256 in `number` */
    uint32_t number, dxgi;
} FOUR[] = {
    { "DXT1", 0, 71 }, { "DXT2", 0, 74 }, { "DXT3", 0, 74 }, { "DXT4", 0, 77 }, { "DXT5", 0, 77 },
    { "RXGB", 0, 77 }, { "ATI1", 0, 80 }, { "BC4U", 0, 80 }, { "BC4S", 0, 81 }, { "ATI2", 0, 83 },
    { "A2XY", 0, 83 }, { "BC5U", 0, 83 }, { "BC5S", 0, 84 }, { "", 36, 11 },    { "", 110, 13 },
    { "", 111, 54 },   { "", 112, 34 },   { "", 113, 10 },   { "", 114, 41 },   { "", 115, 16 },
    { "", 116, 2 },
};

static bool not_read(const ntpio_reader *reader, const ntpio__texture *t, ntpio_error *error)
{
    return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                       "a DDS texture of %s, which is not read", t->name);
}

static bool by_four(ntpio_reader *reader, const uint8_t *format, ntpio__texture *t,
                    ntpio_error *error)
{
    const uint8_t *code = format + 8;
    const uint32_t number = ntpio__u32(code);
    for (size_t i = 0; i < sizeof FOUR / sizeof *FOUR; i++) {
        const bool is_code = FOUR[i].number == 0 && memcmp(code, FOUR[i].code, 4) == 0;
        if (!is_code && (FOUR[i].number == 0 || FOUR[i].number != number))
            continue;
        ntpio__layout_of_dxgi(FOUR[i].dxgi, t, &reader->info.has_srgb);
        if (is_code && memcmp(code, "BC", 2) != 0) {
            const size_t length = strlen(t->name);
            snprintf(t->name + length, sizeof t->name - length, " (%.4s)", FOUR[i].code);
        }
        if (FOUR[i].dxgi == 71 && (ntpio__u32(format + 4) & HAS_ALPHA) != 0) {
            t->layout.channels = 4;
            t->layout.alpha = true;
        }
        return true;
    }
    snprintf(t->name, sizeof t->name, "an unknown format");
    return not_read(reader, t, error);
}

static int bits_in(uint32_t mask)
{
    int count = 0;
    for (; mask != 0; mask &= mask - 1)
        count++;
    return count;
}

static const char *sign_of(bool is_signed)
{
    return is_signed ? " SNORM" : "";
}

/* Channels in the order red, green, blue, alpha, those without a mask left out; a signed one has
 * two bits at least. */
static bool by_masks(ntpio_reader *reader, const uint8_t *format, ntpio__texture *t,
                     ntpio_error *error)
{
    const uint32_t flags = ntpio__u32(format + 4), bits = ntpio__u32(format + 12);
    ntpio__layout *l = &t->layout;
    *l = (ntpio__layout) { .texels = NTPIO__TEXELS_MASKED, .is_signed = (flags & SIGNED) != 0 };
    const uint32_t used = bits == 32 ? UINT32_MAX : ((uint32_t) 1 << (bits & 31)) - 1;
    const int first = (flags & ALPHA_ONLY) != 0 ? 3 : 0;
    const bool alpha = (flags & (HAS_ALPHA | ALPHA_ONLY)) != 0 || l->is_signed;
    size_t length = 0;
    bool sound = bits == 8 || bits == 16 || bits == 24 || bits == 32;
    for (int i = first; sound && i < (alpha ? 4 : 3); i++) {
        const uint32_t mask = ntpio__u32(format + 16 + 4 * i);
        if (mask == 0 || ((flags & LUMINANCE) != 0 && i > 0 && i < 3))
            continue;
        sound = (mask & ~used) == 0 && (!l->is_signed || bits_in(mask) > 1);
        l->alpha = i == 3 && first == 0;
        l->mask[l->channels++] = mask;
        length +=
            (size_t) snprintf(t->name + length, sizeof t->name - length, "%c%d",
                              (flags & LUMINANCE) != 0 && i == 0 ? 'L' : "RGBA"[i], bits_in(mask));
    }
    if (!sound || l->channels == 0)
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name,
                           "damaged (masks of %lu bits a texel)", (unsigned long) bits);
    snprintf(t->name + length, sizeof t->name - length, "%s", sign_of(l->is_signed));
    l->stored = (uint8_t) (bits / 8);
    return true;
}

static bool by_dx10(ntpio_reader *reader, ntpio__texture *t, ntpio_error *error)
{
    uint8_t h[DX10_SIZE];
    if (!ntpio__read_all(reader, h, sizeof h, error))
        return false;
    const uint32_t dimension = ntpio__u32(h + 4), layers = ntpio__u32(h + 12);
    t->cube = (ntpio__u32(h + 8) & DX10_CUBE) != 0;
    t->layers = layers > UINT32_MAX / 6 ? UINT32_MAX : layers * (t->cube ? 6 : 1);
    if (dimension != DX10_TEXTURE_2D && dimension != DX10_TEXTURE_1D)
        return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                           "a volume texture, which is not read");
    return ntpio__layout_of_dxgi(ntpio__u32(h), t, &reader->info.has_srgb) ||
           not_read(reader, t, error);
}

static bool read_header(ntpio_reader *reader, ntpio__texture *t, uint64_t *start,
                        ntpio_error *error)
{
    uint8_t h[HEADER_SIZE];
    if (!ntpio__read_all(reader, h, sizeof h, error))
        return false;
    const uint8_t *format = h + AT_FORMAT;
    const uint32_t mips = ntpio__u32(h + AT_MIPS), caps = ntpio__u32(h + AT_CAPS_2);
    const uint32_t flags = ntpio__u32(format + 4);
    const bool dx10 = (flags & HAS_FOURCC) != 0 && memcmp(format + 8, "DX10", 4) == 0;
    *t = (ntpio__texture) { .width = ntpio__u32(h + AT_WIDTH),
                            .height = ntpio__u32(h + AT_HEIGHT),
                            .mips = mips > 1 ? mips : 1,
                            .cube = (caps & CUBE) != 0,
                            .layers = (caps & CUBE) != 0 ? (uint32_t) bits_in(caps & FACES) : 1 };
    *start = HEADER_SIZE + (dx10 ? DX10_SIZE : 0);
    if (ntpio__u32(h + 4) != HEADER_SIZE - 4 || ntpio__u32(format) != 32)
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "damaged DDS header");
    if ((caps & VOLUME) != 0)
        return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                           "a volume texture, which is not read");
    return (dx10                        ? by_dx10(reader, t, error)
            : (flags & HAS_FOURCC) != 0 ? by_four(reader, format, t, error)
                                        : by_masks(reader, format, t, error)) &&
           ntpio__texture_check(reader, t, error);
}

static bool dds_open(ntpio_reader *reader, ntpio_error *error)
{
    ntpio__texture t;
    uint64_t start, size, layer = 0, before = 0;
    if (!read_header(reader, &t, &start, error))
        return false;
    for (uint32_t mip = 0; mip < t.mips; mip++) {
        if (mip == reader->limits.mip)
            before = layer;
        layer += ntpio__texture_bytes(&t, mip);
    }
    if (reader->limits.layer_and_one > 1)
        before += layer * (reader->limits.layer_and_one - 1);
    if (ntpio__can_seek(&reader->source) &&
        (!ntpio__size(&reader->source, &size) || size < start || (size - start) / t.layers < layer))
        return ntpio__fail_ended(reader, error);
    reader->info.format = NTPIO_DDS;
    return ntpio__texture_seek(reader, start, start + before, error) &&
           ntpio__texture_start(reader, &t, NULL, error);
}

const ntpio__decoder ntpio__dds_decoder = { dds_open, ntpio__texture_rows,
                                            NULL,     ntpio__texture_close,
                                            NULL,     NULL };
