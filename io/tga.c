/* SPDX-License-Identifier: MIT */
/*
 * tga.c - Truevision TGA: gray, palette and true color, raw or run-length coded, four origins
 *
 * Rows stream if they are stored from the top.  Raw rows from the bottom stream too, if the file
 * can seek.  Otherwise the image is held.  The header often says "no alpha bits" although texels of
 * 32 bits have alpha.  Such files are held as well; they have alpha if any of it is not 0.
 */
#include <stdlib.h>
#include <string.h>

#include "formats.h"

enum {
    HEADER_SIZE = 18,
    FOOTER_SIZE = 26,
    RLE = 8, /* bit of the type */
    TYPE_PALETTE = 1,
    TYPE_COLOR = 2,
    TYPE_GRAY = 3,
    RIGHT_TO_LEFT = 0x10, /* bits of the descriptor */
    TOP_TO_BOTTOM = 0x20,
    INTERLEAVED = 0xc0,
    ALPHA_BITS = 0x0f,
    RUN = 0x80, /* of a packet's first byte */
    RUN_LENGTH = 0x7f
};

typedef struct tga_state {
    int type; /* without RLE */
    bool rle, flipped, mirrored;
    size_t stored;    /* bytes of a stored texel */
    int bits;         /* of a color: of the texel or of the palette's entry */
    bool file_alpha;  /* the fourth byte, or bit 15, is alpha */
    uint64_t start;   /* of the rows */
    uint8_t *palette; /* RGBA */
    uint32_t palette_first, palette_count;
    uint8_t *row;    /* as stored */
    uint32_t packet; /* texels left of the current one */
    bool run;
    uint8_t texel[4]; /* of the run */
} tga_state;

static uint32_t word(const uint8_t *b)
{
    return (uint32_t) b[0] | (uint32_t) b[1] << 8;
}

static bool is_color_depth(int bits)
{
    return bits == 15 || bits == 16 || bits == 24 || bits == 32;
}

bool ntpio__tga_plausible(const uint8_t *b, size_t size)
{
    if (size < HEADER_SIZE || b[1] > 1 || (b[2] & ~(RLE | 3)) != 0 || (b[17] & INTERLEAVED) != 0 ||
        (b[17] & ALPHA_BITS) > 8)
        return false;
    switch (b[2] & 3) {
    case TYPE_PALETTE:
        return b[1] == 1 && word(b + 5) != 0 && is_color_depth(b[7]) && (b[16] == 8 || b[16] == 16);
    case TYPE_COLOR:
        return is_color_depth(b[16]);
    case TYPE_GRAY:
        return b[16] == 8 || b[16] == 16;
    default:
        return false;
    }
}

/* ------------------------------------------------------------------------ colors */

/* round(c * 255 / 31) */
static uint8_t from_5_bits(uint32_t c)
{
    return (uint8_t) (((c & 31) * 255 + 15) / 31);
}

static void to_rgba(const uint8_t *b, int bits, uint8_t *rgba)
{
    if (bits <= 16) {
        const uint32_t c = word(b);
        rgba[0] = from_5_bits(c >> 10);
        rgba[1] = from_5_bits(c >> 5);
        rgba[2] = from_5_bits(c);
        rgba[3] = (c & 0x8000) != 0 ? 255 : 0;
    } else {
        rgba[0] = b[2];
        rgba[1] = b[1];
        rgba[2] = b[0];
        rgba[3] = bits == 32 ? b[3] : 255;
    }
}

static void convert_gray(const tga_state *s, uint8_t *dst, uint32_t width, size_t channels)
{
    if (s->stored == channels) {
        memcpy(dst, s->row, width * channels);
        return;
    }
    for (size_t x = 0; x < width; x++)
        dst[x] = s->row[x * s->stored];
}

static bool convert_palette(const tga_state *s, uint8_t *dst, uint32_t width, size_t channels)
{
    for (size_t x = 0; x < width; x++, dst += channels) {
        const uint8_t *b = s->row + x * s->stored;
        const uint32_t index = (s->stored == 1 ? b[0] : word(b)) - s->palette_first;
        if (index >= s->palette_count)
            return false;
        memcpy(dst, s->palette + (size_t) index * 4, channels);
    }
    return true;
}

static void convert_color(const tga_state *s, uint8_t *dst, uint32_t width, size_t channels)
{
    const uint8_t *b = s->row;
    if (s->bits == 24 && channels == 3) {
        for (size_t x = 0; x < width; x++, b += 3, dst += 3) {
            const uint8_t blue = b[0];
            dst[0] = b[2];
            dst[1] = b[1];
            dst[2] = blue;
        }
        return;
    }
    for (size_t x = 0; x < width; x++, b += s->stored, dst += channels) {
        uint8_t rgba[4];
        to_rgba(b, s->bits, rgba);
        memcpy(dst, rgba, channels);
    }
}

static void mirror(uint8_t *row, uint32_t width, size_t channels)
{
    uint8_t texel[4];
    for (size_t a = 0, b = (size_t) width - 1; a < b; a++, b--) {
        memcpy(texel, row + a * channels, channels);
        memcpy(row + a * channels, row + b * channels, channels);
        memcpy(row + b * channels, texel, channels);
    }
}

/* ------------------------------------------------------------------------ rows */

/* Packets may go on in the next row: some programs write such files. */
static bool unpack_row(ntpio_reader *reader, tga_state *s, ntpio_error *error)
{
    const size_t stored = s->stored;
    uint8_t *dst = s->row;
    for (uint32_t left = reader->info.width; left != 0;) {
        if (s->packet == 0) {
            uint8_t first;
            if (!ntpio__read_all(reader, &first, 1, error))
                return false;
            s->packet = (uint32_t) (first & RUN_LENGTH) + 1;
            s->run = (first & RUN) != 0;
            if (s->run && !ntpio__read_all(reader, s->texel, stored, error))
                return false;
        }
        const uint32_t some = s->packet < left ? s->packet : left;
        if (!s->run) {
            if (!ntpio__read_all(reader, dst, some * stored, error))
                return false;
        } else if (stored == 1) {
            memset(dst, s->texel[0], some);
        } else {
            for (size_t i = 0; i < some; i++)
                memcpy(dst + i * stored, s->texel, stored);
        }
        dst += some * stored;
        left -= some;
        s->packet -= some;
    }
    return true;
}

/* Reads the next row in the order of the file. */
static bool next_row(ntpio_reader *reader, uint8_t *dst, ntpio_error *error)
{
    tga_state *s = reader->state;
    const uint32_t width = reader->info.width;
    const size_t channels = (size_t) reader->info.channels;
    if (s->rle ? !unpack_row(reader, s, error)
               : !ntpio__read_all(reader, s->row, width * s->stored, error))
        return false;
    if (s->type == TYPE_GRAY)
        convert_gray(s, dst, width, channels);
    else if (s->type == TYPE_COLOR)
        convert_color(s, dst, width, channels);
    else if (!convert_palette(s, dst, width, channels))
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name,
                           "damaged (a palette index out of range)");
    if (s->mirrored)
        mirror(dst, width, channels);
    return true;
}

static bool tga_rows(ntpio_reader *reader, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                     ntpio_error *error)
{
    const tga_state *s = reader->state;
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t y = reader->info.height - 1 - (reader->row + i);
        if (s->flipped &&
            !ntpio__seek(&reader->source, s->start + y * (reader->info.width * s->stored)))
            return ntpio__fail_ended(reader, error);
        if (!next_row(reader, dst + (ptrdiff_t) i * stride, error))
            return false;
    }
    return true;
}

/* Drops the fourth channel if it is all zeros. */
static void settle_alpha(ntpio_reader *reader)
{
    const size_t count = (size_t) reader->info.width * reader->info.height;
    uint8_t *b = reader->held;
    for (size_t i = 0; i < count; i++) {
        if (b[i * 4 + 3] != 0)
            return;
    }
    for (size_t i = 0; i < count; i++)
        memmove(b + i * 3, b + i * 4, 3);
    reader->info.channels = 3;
    reader->info.alpha = false;
}

static bool hold_all(ntpio_reader *reader, bool doubtful_alpha, ntpio_error *error)
{
    const tga_state *s = reader->state;
    const uint32_t height = reader->info.height;
    if (!ntpio__hold(reader, error))
        return false;
    const size_t size = ntpio__row_bytes(&reader->info);
    for (uint32_t y = 0; y < height; y++) {
        const size_t row = s->flipped ? height - 1 - y : y;
        if (!next_row(reader, reader->held + row * size, error))
            return false;
    }
    if (doubtful_alpha)
        settle_alpha(reader);
    return true;
}

/* ------------------------------------------------------------------------ header */

static bool skip(ntpio_reader *reader, size_t size, ntpio_error *error)
{
    uint8_t dropped[256];
    for (size_t some; size != 0; size -= some) {
        some = size < sizeof dropped ? size : sizeof dropped;
        if (!ntpio__read_all(reader, dropped, some, error))
            return false;
    }
    return true;
}

static bool read_palette(ntpio_reader *reader, const uint8_t *header, ntpio_error *error)
{
    tga_state *s = reader->state;
    const size_t entry = (size_t) (header[7] + 7) / 8;
    s->palette_first = word(header + 3);
    s->palette_count = word(header + 5);
    s->palette = malloc((size_t) s->palette_count * 4);
    if (s->palette == NULL)
        return ntpio__fail_memory(error, reader->name);
    bool any_alpha = false;
    for (size_t i = 0; i < s->palette_count; i++) {
        uint8_t stored[4];
        if (!ntpio__read_all(reader, stored, entry, error))
            return false;
        to_rgba(stored, header[7], s->palette + i * 4);
        any_alpha = any_alpha || (header[7] == 32 && stored[3] != 0);
    }
    s->file_alpha = any_alpha || (header[7] == 16 && (header[17] & ALPHA_BITS) == 1);
    return true;
}

static bool read_header(ntpio_reader *reader, bool *doubtful_alpha, ntpio_error *error)
{
    tga_state *s = reader->state;
    ntpio_info *info = &reader->info;
    uint8_t h[HEADER_SIZE];
    if (!ntpio__read_all(reader, h, HEADER_SIZE, error))
        return false;
    if (!ntpio__tga_plausible(h, HEADER_SIZE))
        return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                           "not a TGA image of a kind that is read here");
    if (!ntpio__check_size(reader, word(h + 12), word(h + 14), error) || !skip(reader, h[0], error))
        return false;
    const int alpha_bits = h[17] & ALPHA_BITS;
    const size_t palette_bytes = h[1] == 1 ? word(h + 5) * ((size_t) (h[7] + 7) / 8) : 0;
    s->type = h[2] & 3;
    s->rle = (h[2] & RLE) != 0;
    s->stored = (size_t) (h[16] + 7) / 8;
    s->bits = h[16];
    s->flipped = (h[17] & TOP_TO_BOTTOM) == 0;
    s->mirrored = (h[17] & RIGHT_TO_LEFT) != 0;
    s->start = HEADER_SIZE + h[0] + palette_bytes;
    *doubtful_alpha = s->type == TYPE_COLOR && h[16] == 32 && alpha_bits == 0;
    if (s->type != TYPE_PALETTE) {
        s->file_alpha = h[16] == 32 || (h[16] == 16 && alpha_bits != 0);
        if (!skip(reader, palette_bytes, error))
            return false;
    } else if (!read_palette(reader, h, error)) {
        return false;
    }
    const int color_bits = s->type == TYPE_PALETTE ? h[7] : h[16];
    info->format = NTPIO_TGA;
    info->width = word(h + 12);
    info->height = word(h + 14);
    info->palette = s->type == TYPE_PALETTE;
    info->alpha = s->file_alpha;
    info->channels = (s->type == TYPE_GRAY ? 1 : 3) + (s->file_alpha ? 1 : 0);
    info->sample_bytes = 1;
    info->bit_depth = s->type != TYPE_GRAY && color_bits <= 16 ? 5 : 8;
    return true;
}

static bool tga_open(ntpio_reader *reader, ntpio_error *error)
{
    tga_state *s = calloc(1, sizeof *s);
    bool doubtful_alpha = false;
    if (s == NULL)
        return ntpio__fail_memory(error, reader->name);
    reader->state = s;
    if (!read_header(reader, &doubtful_alpha, error))
        return false;
    const size_t stored_row = reader->info.width * s->stored;
    s->row = malloc(stored_row);
    if (s->row == NULL)
        return ntpio__fail_memory(error, reader->name);
    const bool seeks = ntpio__can_seek(&reader->source);
    uint64_t size;
    if (seeks && !s->rle &&
        (!ntpio__size(&reader->source, &size) || size < s->start ||
         size - s->start < (uint64_t) stored_row * reader->info.height))
        return ntpio__fail_ended(reader, error);
    if (doubtful_alpha || (s->flipped && (s->rle || !seeks)))
        return hold_all(reader, doubtful_alpha, error);
    return true;
}

static void tga_close(ntpio_reader *reader)
{
    tga_state *s = reader->state;
    if (s == NULL)
        return;
    free(s->palette);
    free(s->row);
    free(s);
}

const ntpio__decoder ntpio__tga_decoder = { tga_open, tga_rows, NULL, tga_close, NULL, NULL };

/* ------------------------------------------------------------------------ writing */

static bool tga_write_open(ntpio_writer *writer, ntpio_error *error)
{
    const ntpio_write_options *o = &writer->options;
    uint8_t h[HEADER_SIZE] = { 0 };
    h[2] = o->channels == 1 ? TYPE_GRAY : TYPE_COLOR;
    h[12] = (uint8_t) (o->width & 255);
    h[13] = (uint8_t) (o->width >> 8);
    h[14] = (uint8_t) (o->height & 255);
    h[15] = (uint8_t) (o->height >> 8);
    h[16] = (uint8_t) (8 * o->channels);
    h[17] = (uint8_t) (TOP_TO_BOTTOM | (o->channels == 4 ? 8 : 0));
    writer->state = malloc((size_t) o->width * (size_t) o->channels);
    if (writer->state == NULL)
        return ntpio__fail_memory(error, writer->name);
    return ntpio__output_write(writer->output, h, HEADER_SIZE, error);
}

static bool tga_write_rows(ntpio_writer *writer, const uint8_t *src, ptrdiff_t stride,
                           uint32_t count, ntpio_error *error)
{
    const size_t channels = (size_t) writer->options.channels;
    const size_t size = writer->options.width * channels;
    uint8_t *row = writer->state;
    for (uint32_t i = 0; i < count; i++, src += stride) {
        memcpy(row, src, size);
        for (size_t x = 0; channels != 1 && x < size; x += channels) {
            row[x] = src[x + 2];
            row[x + 2] = src[x];
        }
        if (!ntpio__output_write(writer->output, row, size, error))
            return false;
    }
    return true;
}

/* The footer of TGA 2.0, by which a file without a signature is recognized. */
static bool tga_write_end(ntpio_writer *writer, ntpio_error *error)
{
    static const char footer[FOOTER_SIZE] = "\0\0\0\0\0\0\0\0TRUEVISION-XFILE.";
    return ntpio__output_write(writer->output, footer, FOOTER_SIZE, error);
}

static void tga_write_close(ntpio_writer *writer)
{
    free(writer->state);
}

const ntpio__encoder ntpio__tga_encoder = { tga_write_open, tga_write_rows, tga_write_end,
                                            tga_write_close };
