/* SPDX-License-Identifier: MIT */
/*
 * png_write.c - PNG: pixels through png_pack.c, all else through libpng
 *
 * Rows that are too long for bands are libpng's as well, with its own defaults.
 */
#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "deflate.h"
#include "formats.h"
#include "png_pack.h"
#include "png_sums.h"

enum {
    IDAT_SIZE = 1 << 18, /* of compressed data at a time: few system calls */
    ZLIB_LEVEL_MAX = 9,
    KEY_MAX = 79, /* bytes, by the PNG specification */
    MESSAGE_SIZE = 128
};

typedef struct png_state {
    png_structp png, tail; /* tail: writes what follows the pixels */
    png_infop info, tail_info, end_info;
    bool at_tail;
    ntpio__png_packer *packer; /* NULL: libpng packs the pixels */
    bool begun;                /* a row was written */
    ntpio_writer *writer;
    ntpio_error *error;   /* of the call that is running */
    bool output_failed;   /* and *error says how */
    size_t texts_written; /* of copy_from */
    char message[MESSAGE_SIZE];
} png_state;

static void on_error(png_structp png, png_const_charp message)
{
    png_state *s = png_get_error_ptr(png);
    snprintf(s->message, sizeof s->message, "%s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message)
{
    (void) png;
    (void) message;
}

static void write_bytes(png_structp png, const uint8_t *bytes, size_t size)
{
    png_state *s = png_get_io_ptr(png);
    if (!ntpio__output_write(s->writer->output, bytes, size, s->error)) {
        s->output_failed = true;
        png_error(png, "write error");
    }
}

static void on_write(png_structp png, png_bytep bytes, size_t size)
{
    write_bytes(png, bytes, size);
}

/* Of the tail's file, only its end is wanted. */
static void on_write_tail(png_structp png, png_bytep bytes, size_t size)
{
    const png_state *s = png_get_io_ptr(png);
    if (s->at_tail)
        on_write(png, bytes, size);
}

static void on_flush(png_structp png)
{
    (void) png;
}

static bool fail(png_state *s)
{
    if (s->output_failed)
        return false;
    return ntpio__fail(s->error, NTPIO_ERR_WRITE, s->writer->name, "cannot be encoded (%s)",
                       s->message);
}

static int level_of(const ntpio_write_options *o)
{
    return o->level < 0 ? NTPIO__LEVEL_USUAL : o->level;
}

/* Only of texts, unless libpng packs the pixels. */
static void set_compression(png_state *s)
{
    const int level = level_of(&s->writer->options);
    png_set_compression_buffer_size(s->png, IDAT_SIZE);
    if (s->packer == NULL) {
        png_set_compression_level(s->png, level < ZLIB_LEVEL_MAX ? level : ZLIB_LEVEL_MAX);
        png_set_filter(s->png, 0, PNG_ALL_FILTERS);
    }
}

static bool add_texts(png_state *s, png_infop info, const ntpio_text *texts, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const ntpio_text *t = &texts[i];
        const size_t size = t->key != NULL ? strlen(t->key) : 0;
        if (size == 0 || size > KEY_MAX)
            return ntpio__fail(s->error, NTPIO_ERR_USAGE, s->writer->name,
                               "the key of a text has 1 to %d bytes", KEY_MAX);
        png_text text = { .compression = t->itxt ? (t->compressed ? PNG_ITXT_COMPRESSION_zTXt
                                                                  : PNG_ITXT_COMPRESSION_NONE)
                                         : t->compressed ? PNG_TEXT_COMPRESSION_zTXt
                                                         : PNG_TEXT_COMPRESSION_NONE,
                          .key = t->key,
                          .text = t->value,
                          .lang = t->itxt ? t->language : NULL,
                          .lang_key = t->itxt ? t->translated_key : NULL };
        png_set_text(s->png, info, &text, 1);
    }
    return true;
}

static bool write_header(png_state *s)
{
    static const int kinds[] = { PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                 PNG_COLOR_TYPE_RGB_ALPHA };
    const ntpio_write_options *o = &s->writer->options;
    if (setjmp(png_jmpbuf(s->png)) != 0)
        return fail(s);
    png_set_write_fn(s->png, s, on_write, on_flush);
    png_set_user_limits(s->png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    set_compression(s);
    png_set_IHDR(s->png, s->info, o->width, o->height, 8 * o->sample_bytes, kinds[o->channels - 1],
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (o->copy_from != NULL) {
        if (o->copy_from->has_phys)
            png_set_pHYs(s->png, s->info, o->copy_from->phys_x, o->copy_from->phys_y,
                         o->copy_from->phys_unit);
        if (!add_texts(s, s->info, o->copy_from->texts, o->copy_from->text_count))
            return false;
        s->texts_written = o->copy_from->text_count;
    }
    if (!add_texts(s, s->info, o->texts, o->text_count))
        return false;
    png_write_info(s->png, s->info);
    if (o->sample_bytes == 2 && ntpio__little_endian())
        png_set_swap(s->png);
    return true;
}

static bool make_packer(png_state *s)
{
    const ntpio_write_options *o = &s->writer->options;
    const size_t texel = (size_t) o->channels * (size_t) o->sample_bytes;
    if (o->width > NTPIO__PACKED_ROW_MAX / texel)
        return true;
    s->packer = ntpio__png_packer_new(o->width * texel, o->height, texel, level_of(o), o->threads);
    return s->packer != NULL;
}

static bool png_open(ntpio_writer *writer, ntpio_error *error)
{
    png_state *s = calloc(1, sizeof *s);
    if (s == NULL)
        return ntpio__fail_memory(error, writer->name);
    writer->state = s;
    s->writer = writer;
    s->error = error;
    s->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, s, on_error, on_warning);
    if (s->png != NULL) {
        s->info = png_create_info_struct(s->png);
        s->end_info = png_create_info_struct(s->png);
    }
    if (s->info == NULL || s->end_info == NULL || !make_packer(s))
        return ntpio__fail_memory(error, writer->name);
    return write_header(s);
}

/* Asked after the first row, when a reader knows. */
static bool has_rival(const ntpio_write_options *o)
{
    const ntpio_info *i = o->as_it_came;
    return o->level < 0 && i != NULL && i->packed_hard && i->file_size != 0 && !i->palette &&
           i->width == o->width && i->height == o->height && i->channels == o->channels &&
           i->bit_depth == 8 * o->sample_bytes;
}

/* What of that file may be pixels: texts that stand there as they are stand here as well. */
static uint64_t rival_size(const ntpio_info *i)
{
    uint64_t texts = 0;
    for (size_t k = 0; k < i->text_count; k++) {
        if (!i->texts[k].compressed)
            texts += strlen(i->texts[k].key) + strlen(i->texts[k].value);
    }
    return texts < i->file_size ? i->file_size - texts : i->file_size;
}

static void begin_rows(png_state *s)
{
    const ntpio_write_options *o = &s->writer->options;
    s->begun = true;
    if (s->packer != NULL && has_rival(o) &&
        !ntpio__png_packer_rival(s->packer, rival_size(o->as_it_came)))
        png_error(s->png, "out of memory");
}

/* As png_write_chunk, whose checksum takes longer. */
static void put_pixels(png_state *s, const uint8_t *packed, size_t size)
{
    enum { NUMBER = 4, HEAD = 2 * NUMBER };
    png_byte head[HEAD + 1] = "....IDAT", sum[NUMBER];
    png_save_uint_32(head, (png_uint_32) size);
    png_save_uint_32(sum, ntpio__crc32(ntpio__crc32(0, head + NUMBER, NUMBER), packed, size));
    write_bytes(s->png, head, HEAD);
    write_bytes(s->png, packed, size);
    write_bytes(s->png, sum, NUMBER);
}

static void put_row(png_state *s, const uint8_t *row)
{
    const bool swap = s->writer->options.sample_bytes == 2 && ntpio__little_endian();
    const uint8_t *packed = NULL;
    if (s->packer == NULL) {
        png_write_row(s->png, row);
        return;
    }
    ntpio__png_pack_row(s->packer, row, swap);
    for (size_t size; (size = ntpio__png_packed(s->packer, &packed)) != 0;)
        put_pixels(s, packed, size);
}

static bool png_rows(ntpio_writer *writer, const uint8_t *src, ptrdiff_t stride, uint32_t count,
                     ntpio_error *error)
{
    png_state *s = writer->state;
    s->error = error;
    if (setjmp(png_jmpbuf(s->png)) != 0)
        return fail(s);
    if (!s->begun)
        begin_rows(s);
    for (uint32_t i = 0; i < count; i++)
        put_row(s, src + (ptrdiff_t) i * stride);
    return true;
}

/* libpng ends a file only after pixels of its own: so another one, of one texel, ends for this. */
static bool write_tail(png_state *s)
{
    static const png_byte texel = 0;
    s->tail = png_create_write_struct(PNG_LIBPNG_VER_STRING, s, on_error, on_warning);
    s->tail_info = s->tail != NULL ? png_create_info_struct(s->tail) : NULL;
    if (s->tail_info == NULL)
        return ntpio__fail_memory(s->error, s->writer->name);
    if (setjmp(png_jmpbuf(s->tail)) != 0)
        return fail(s);
    png_set_write_fn(s->tail, s, on_write_tail, on_flush);
    png_set_IHDR(s->tail, s->tail_info, 1, 1, 8, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(s->tail, s->tail_info);
    png_write_row(s->tail, &texel);
    s->at_tail = true;
    png_write_end(s->tail, s->end_info);
    return true;
}

static bool put_end(png_state *s)
{
    static const png_byte end[] = { 0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82 };
    return ntpio__output_write(s->writer->output, end, sizeof end, s->error);
}

/* Texts that the reader found after its pixels are written after ours.  Without them, libpng takes more
 * time for the end than for the pixels of an icon. */
static bool png_end(ntpio_writer *writer, ntpio_error *error)
{
    png_state *s = writer->state;
    const ntpio_info *from = writer->options.copy_from;
    s->error = error;
    if (setjmp(png_jmpbuf(s->png)) != 0)
        return fail(s);
    const size_t late = from != NULL && from->text_count > s->texts_written
                            ? from->text_count - s->texts_written
                            : 0;
    if (late > 0 && !add_texts(s, s->end_info, from->texts + s->texts_written, late))
        return false;
    if (s->packer != NULL)
        return late > 0 ? write_tail(s) : put_end(s);
    png_write_end(s->png, s->end_info);
    return true;
}

static void png_close(ntpio_writer *writer)
{
    png_state *s = writer->state;
    if (s == NULL)
        return;
    png_destroy_info_struct(s->png, &s->end_info);
    png_destroy_write_struct(&s->png, &s->info);
    png_destroy_write_struct(&s->tail, &s->tail_info);
    ntpio__png_packer_free(s->packer);
    free(s);
}

const ntpio__encoder ntpio__png_encoder = { png_open, png_rows, png_end, png_close };
