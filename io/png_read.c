/* SPDX-License-Identifier: MIT */
/*
 * png_read.c - PNG through libpng, row by row and raw
 *
 * Pictures of most files are unpacked by png_stream.c, and libpng reads the rest of these files.
 * All others are libpng's alone.
 *
 * libpng decodes pixels and texts.  It never sees the contents of the color chunks: a callback
 * notes that they are there.  So colors are not managed, and no hostile profile is unpacked.  All
 * that libpng allocates counts against a budget.  Its errors come back here by longjmp.
 */
#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "formats.h"
#include "png_plain.h"
#include "png_stream.h"
#include "png_sums.h"

enum {
    READ_SIZE = 1 << 13,           /* of compressed data at a time; unpacked at most 8 MB */
    SURPLUS_MAX = 1 << 12,         /* of compressed data after the last row; honest: 10 bytes */
    CHUNK_COUNT_MAX = 256,         /* of texts; a file with more loses the rest */
    CHUNK_SIZE_MAX = 4 << 20,      /* of one text, unpacked */
    CHUNK_BUDGET = 64 << 20,       /* all that libpng allocates, without rows */
    ROW_BUDGET_BYTES_A_TEXEL = 64, /* more than three rows of 8 bytes a texel */
    LIBPNG_ONLY = 1,               /* as max_at_once */
    MESSAGE_SIZE = 128
};

typedef struct png_state {
    png_structp png;
    png_infop info, end_info;
    ntpio_reader *reader;
    ntpio__png_stream *stream; /* NULL: libpng unpacks the pixels */
    ntpio__source shell;       /* the file with an empty picture instead of the stream's */
    ntpio_reader *other;       /* reads what a stream with a fault has */
    size_t budget;
    bool ended;     /* the source gave less than was asked for */
    size_t begun;   /* bytes of the stream of pixels that were seen, until its two of header were */
    size_t surplus; /* bytes of IDAT read after the last row */
    bool bad_pixels; /* a warning that is an error here */
    bool out_of_memory;
    char message[MESSAGE_SIZE];
} png_state;

/* Does libpng see an empty picture? */
static bool has_shell(const png_state *s)
{
    return s->stream != NULL;
}

/* What is freed does not return to the budget: libpng allocates nothing for each row. */
static png_voidp allocate(png_structp png, png_alloc_size_t size)
{
    png_state *s = png_get_mem_ptr(png);
    if (size > s->budget)
        return NULL;
    void *memory = malloc(size);
    s->out_of_memory = s->out_of_memory || memory == NULL;
    if (memory != NULL)
        s->budget -= size;
    return memory;
}

static void release(png_structp png, png_voidp memory)
{
    (void) png;
    free(memory);
}

static void on_error(png_structp png, png_const_charp message)
{
    png_state *s = png_get_error_ptr(png);
    snprintf(s->message, sizeof s->message, "%s", message);
    png_longjmp(png, 1);
}

/* libpng only warns about the checksum of the pixels, after the last row. */
static void on_warning(png_structp png, png_const_charp message)
{
    png_state *s = png_get_error_ptr(png);
    if (strncmp(message, "IDAT", 4) == 0 &&
        (strstr(message, "incorrect data check") != NULL || strstr(message, "ADLER") != NULL))
        s->bad_pixels = true;
}

/* Is the picture whole, and yet there is much more in its chunks?  libpng would unpack all of that,
 * in order to warn about it. */
static bool has_surplus(const png_state *s)
{
    return s->surplus > SURPLUS_MAX;
}

static void count_surplus(png_state *s, size_t size)
{
    enum { IDAT = 0x49444154, PASSES = 7 };
    const ntpio_info *info = &s->reader->info;
    const bool whole = info->interlaced ? png_get_current_pass_number(s->png) >= PASSES
                                        : png_get_current_row_number(s->png) >= info->height;
    if (whole && info->height != 0 && png_get_io_chunk_type(s->png) == IDAT &&
        (png_get_io_state(s->png) & PNG_IO_MASK_LOC) == PNG_IO_CHUNK_DATA)
        s->surplus += size;
}

/* The second byte of the stream says how hard its maker tried. */
static void look_at_stream(png_state *s, const uint8_t *bytes, size_t size)
{
    enum { IDAT = 0x49444154 };
    if (s->begun >= 2 || png_get_io_chunk_type(s->png) != IDAT ||
        (png_get_io_state(s->png) & PNG_IO_MASK_LOC) != PNG_IO_CHUNK_DATA)
        return;
    if (s->begun + size >= 2)
        s->reader->info.packed_hard = ntpio__png_packed_hard(bytes[1 - s->begun]);
    s->begun += size;
}

static void on_read(png_structp png, png_bytep dst, size_t size)
{
    png_state *s = png_get_io_ptr(png);
    count_surplus(s, size);
    if (has_surplus(s))
        png_error(png, "more data than the picture has");
    ntpio__source *source = has_shell(s) ? &s->shell : &s->reader->source;
    if (ntpio__read(source, dst, size) != size) {
        s->ended = true;
        png_error(png, "truncated");
    }
    if (!has_shell(s))
        look_at_stream(s, dst, size);
}

/* gAMA, sRGB, iCCP, cHRM and cICP are reported, never applied. */
static int on_chunk(png_structp png, png_unknown_chunkp chunk)
{
    ntpio_info *info = png_get_user_chunk_ptr(png);
    const char *name = (const char *) chunk->name;
    const uint8_t *b = chunk->data;
    if (memcmp(name, "gAMA", 4) == 0 && chunk->size == 4) {
        info->has_gama = true;
        info->gamma = png_get_uint_32(b) / 100000.0;
    } else if (memcmp(name, "sRGB", 4) == 0) {
        info->has_srgb = true;
    } else if (memcmp(name, "iCCP", 4) == 0) {
        info->has_iccp = true;
    } else if (memcmp(name, "cHRM", 4) == 0) {
        info->has_chrm = true;
    } else if (memcmp(name, "cICP", 4) == 0) {
        info->has_cicp = true;
    }
    return 1;
}

static bool fail(png_state *s, ntpio_error *error)
{
    const ntpio_reader *reader = s->reader;
    const char *m = s->message;
    if (s->ended)
        return ntpio__fail_ended(reader, error);
    if (s->out_of_memory)
        return ntpio__fail_memory(error, reader->name);
    if (strlen(m) > 4 && strstr(m, ": CRC error") != NULL)
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "checksum error in %.4s", m);
    if (strstr(m, "incorrect data check") != NULL)
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "checksum error in the pixels");
    if (strstr(m, "Not enough image data") != NULL)
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "truncated image data");
    return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "damaged (%s)", m);
}

static void configure(png_state *s)
{
    static const png_byte told[] = "gAMA\0sRGB\0iCCP\0cHRM\0cICP";
    static const png_byte dropped[] = "bKGD\0eXIf\0hIST\0oFFs\0pCAL\0sBIT\0sCAL\0sPLT\0sTER\0tIME";
    png_structp png = s->png;
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX); /* ntpio__check_size has messages */
    png_set_chunk_cache_max(png, CHUNK_COUNT_MAX);
    png_set_chunk_malloc_max(png, CHUNK_SIZE_MAX);
    png_set_compression_buffer_size(png, READ_SIZE);
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, NULL, 0);
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_ALWAYS, told, (int) sizeof told / 5);
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, dropped, (int) sizeof dropped / 5);
    png_set_read_user_chunk_fn(png, &s->reader->info, on_chunk);
    png_set_read_fn(png, s, on_read);
}

/* Copies libpng's texts from number `from` on. */
static bool take_texts(png_state *s, png_infop info, ntpio_error *error)
{
    png_textp texts = NULL;
    int count = 0;
    png_get_text(s->png, info, &texts, &count);
    for (int i = 0; i < count; i++) {
        const png_text *t = &texts[i];
        const bool itxt = t->compression >= PNG_ITXT_COMPRESSION_NONE;
        const ntpio_text text = { .key = t->key,
                                  .value = t->text,
                                  .language = itxt ? t->lang : NULL,
                                  .translated_key = itxt ? t->lang_key : NULL,
                                  .compressed = t->compression == PNG_TEXT_COMPRESSION_zTXt ||
                                                t->compression == PNG_ITXT_COMPRESSION_zTXt,
                                  .itxt = itxt };
        if (!ntpio__add_text(&s->reader->info, &text))
            return ntpio__fail_memory(error, s->reader->name);
    }
    return true;
}

static bool take_header(png_state *s, ntpio_error *error)
{
    ntpio_info *info = &s->reader->info;
    const int kind = png_get_color_type(s->png, s->info);
    info->format = NTPIO_PNG;
    info->width = png_get_image_width(s->png, s->info);
    info->height = png_get_image_height(s->png, s->info);
    if (!ntpio__check_size(s->reader, info->width, info->height, error))
        return false;
    info->bit_depth = png_get_bit_depth(s->png, s->info);
    info->sample_bytes = info->bit_depth == 16 ? 2 : 1;
    info->interlaced = png_get_interlace_type(s->png, s->info) != PNG_INTERLACE_NONE;
    info->palette = kind == PNG_COLOR_TYPE_PALETTE;
    info->alpha =
        (kind & PNG_COLOR_MASK_ALPHA) != 0 || png_get_valid(s->png, s->info, PNG_INFO_tRNS);
    info->channels = ((kind & PNG_COLOR_MASK_COLOR) != 0 ? 3 : 1) + (info->alpha ? 1 : 0);
    png_uint_32 x, y;
    int unit;
    if (png_get_pHYs(s->png, s->info, &x, &y, &unit) != 0) {
        info->has_phys = true;
        info->phys_x = x;
        info->phys_y = y;
        info->phys_unit = unit;
    }
    s->budget += (size_t) info->width * ROW_BUDGET_BYTES_A_TEXEL;
    return take_texts(s, s->info, error);
}

/* Samples of 1, 2 and 4 bits are multiplied exactly: by 255, 85 and 17. */
static void set_transformations(png_state *s)
{
    const ntpio_info *info = &s->reader->info;
    if (info->palette)
        png_set_palette_to_rgb(s->png);
    else if (info->bit_depth < 8)
        png_set_expand_gray_1_2_4_to_8(s->png);
    if (png_get_valid(s->png, s->info, PNG_INFO_tRNS) != 0)
        png_set_tRNS_to_alpha(s->png);
    if (info->bit_depth == 16 && ntpio__little_endian())
        png_set_swap(s->png);
}

/* Adam7: each pass refines the image, which has to be held whole. */
static bool read_interlaced(png_state *s, int passes, ntpio_error *error)
{
    ntpio_reader *reader = s->reader;
    const size_t size = ntpio__row_bytes(&reader->info);
    if (setjmp(png_jmpbuf(s->png)) != 0)
        return has_surplus(s) || fail(s, error);
    for (int pass = 0; pass < passes; pass++) {
        for (uint32_t y = 0; y < reader->info.height; y++)
            png_read_row(s->png, reader->held + y * size, NULL);
    }
    return true;
}

static bool start_rows(png_state *s, int *passes, ntpio_error *error)
{
    if (setjmp(png_jmpbuf(s->png)) != 0)
        return fail(s, error);
    set_transformations(s);
    *passes = s->reader->info.interlaced ? png_set_interlace_handling(s->png) : 1;
    png_read_update_info(s->png, s->info);
    if (png_get_rowbytes(s->png, s->info) != ntpio__row_bytes(&s->reader->info))
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, s->reader->name, "rows of an unexpected size");
    return true;
}

/* Where pointers have 32 bits, libpng calls a size damaged that it cannot hold.  The limits come
 * first, so that all systems say the same. */
static bool check_announced_size(ntpio_reader *reader, ntpio_error *error)
{
    enum { SIGNATURE = 8, KIND = 12, BODY = 16, BODY_SIZE = 13, END = BODY + BODY_SIZE };
    const size_t size = ntpio__peek(&reader->source, END + 4);
    const uint8_t *b = reader->source.bytes + reader->source.at;
    if (size < END + 4 || ntpio__png_number(b + SIGNATURE) != BODY_SIZE ||
        memcmp(b + KIND, "IHDR", 4) != 0 ||
        ntpio__crc32(0, b + KIND, END - KIND) != ntpio__png_number(b + END))
        return true;
    const uint32_t width = ntpio__png_number(b + BODY), height = ntpio__png_number(b + BODY + 4);
    if (width == 0 || height == 0 || width > INT32_MAX || height > INT32_MAX)
        return true;
    return ntpio__check_size(reader, width, height, error);
}

static bool read_header(png_state *s, ntpio_error *error)
{
    if (setjmp(png_jmpbuf(s->png)) != 0)
        return fail(s, error);
    configure(s);
    png_read_info(s->png, s->info);
    return true;
}

/* Without libpng, if that is possible. */
static void take_pixels(png_state *s)
{
    ntpio_reader *reader = s->reader;
    if (reader->limits.max_at_once != LIBPNG_ONLY)
        s->stream = ntpio__png_stream_open(reader);
    if (s->stream == NULL)
        return;
    size_t size;
    const uint8_t *shell = ntpio__png_stream_shell(s->stream, &size);
    ntpio__source_memory(&s->shell, shell, size);
    reader->info.packed_hard = ntpio__png_stream_packed_hard(s->stream);
}

static bool png_open(ntpio_reader *reader, ntpio_error *error)
{
    png_state *s = calloc(1, sizeof *s);
    if (s == NULL)
        return ntpio__fail_memory(error, reader->name);
    reader->state = s;
    s->reader = reader;
    s->budget = CHUNK_BUDGET;
    if (!check_announced_size(reader, error))
        return false;
    if (!ntpio__can_seek(&reader->source) || !ntpio__size(&reader->source, &reader->info.file_size))
        reader->info.file_size = 0;
    take_pixels(s);
    s->png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, s, on_error, on_warning, s, allocate,
                                      release);
    if (s->png != NULL) {
        s->info = png_create_info_struct(s->png);
        s->end_info = png_create_info_struct(s->png);
    }
    if (s->info == NULL || s->end_info == NULL)
        return ntpio__fail_memory(error, reader->name);
    int passes = 1;
    if (!read_header(s, error) || !take_header(s, error) || !start_rows(s, &passes, error))
        return false;
    return !reader->info.interlaced ||
           (ntpio__hold(reader, error) && read_interlaced(s, passes, error));
}

/* Do samples of 16 bits change their bytes' order? */
static bool swaps(const ntpio_reader *reader)
{
    return reader->info.sample_bytes == 2 && ntpio__little_endian();
}

/* Rows through libpng. */
static bool read_rows(ntpio_reader *reader, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                      ntpio_error *error)
{
    png_state *s = reader->state;
    if (setjmp(png_jmpbuf(s->png)) != 0)
        return has_surplus(s) || fail(s, error);
    for (uint32_t i = 0; i < count; i++)
        png_read_row(s->png, dst + (ptrdiff_t) i * stride, NULL);
    return true;
}

static bool is_same_picture(const ntpio_info *a, const ntpio_info *b)
{
    return a->width == b->width && a->height == b->height && a->channels == b->channels &&
           a->sample_bytes == b->sample_bytes && !b->interlaced;
}

static void png_close(ntpio_reader *reader);

static void drop_other(png_state *s)
{
    ntpio_reader *other = s->other;
    if (other == NULL)
        return;
    png_close(other);
    ntpio__source_close(&other->source);
    ntpio__free_texts(&other->info);
    free(other->held);
    free(other);
    s->other = NULL;
}

/* Reads the file from its start in another way, up to row `row`.  It may have changed meanwhile. */
static bool read_anew(png_state *s, uint32_t row, ntpio_error *error)
{
    ntpio_reader *reader = s->reader, *other = calloc(1, sizeof *other);
    uint8_t *dropped = malloc(ntpio__row_bytes(&reader->info));
    s->other = other;
    bool good = other != NULL && dropped != NULL;
    if (!good)
        ntpio__fail_memory(error, reader->name);
    if (other != NULL) {
        *other = (ntpio_reader) { .source = reader->source,
                                  .info = { .stamp = reader->info.stamp, .streams = true },
                                  .limits = reader->limits,
                                  .name = reader->name };
        other->limits.max_at_once = LIBPNG_ONLY;
        other->source.problem = 0;
        reader->source = (ntpio__source) { .start = -1 };
    }
    if (good && !ntpio__seek(&other->source, 0))
        good = ntpio__fail_ended(other, error);
    good = good && png_open(other, error);
    if (good && !is_same_picture(&reader->info, &other->info))
        good = ntpio__fail(error, NTPIO_ERR_OPEN, reader->name, "changed meanwhile");
    for (uint32_t y = 0; good && y < row; y++)
        good = read_rows(other, dropped, 0, 1, error);
    free(dropped);
    if (!good)
        drop_other(s);
    return good;
}

static bool png_rows(ntpio_reader *reader, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                     ntpio_error *error)
{
    png_state *s = reader->state;
    if (s->stream == NULL)
        return read_rows(reader, dst, stride, count, error);
    uint32_t done = 0;
    if (s->other == NULL)
        done = ntpio__png_stream_rows(s->stream, dst, stride, count, swaps(reader));
    if (done == count)
        return true;
    if (s->other == NULL && !read_anew(s, reader->row + done, error))
        return false;
    return read_rows(s->other, dst + (ptrdiff_t) done * stride, stride, count - done, error);
}

static bool read_end(ntpio_reader *reader, ntpio_error *error)
{
    png_state *s = reader->state;
    if (has_surplus(s)) /* texts after it are left out */
        return true;
    if (setjmp(png_jmpbuf(s->png)) != 0)
        return has_surplus(s) || fail(s, error);
    png_read_end(s->png, s->end_info);
    if (s->bad_pixels)
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "checksum error in the pixels");
    return take_texts(s, s->end_info, error);
}

static bool png_end(ntpio_reader *reader, ntpio_error *error)
{
    png_state *s = reader->state;
    if (s->other != NULL) {
        const bool good = read_end(s->other, error);
        ntpio__free_texts(&reader->info);
        reader->info = s->other->info;
        s->other->info.texts = NULL;
        s->other->info.text_count = 0;
        return good;
    }
    if (s->stream != NULL)
        s->shell.bytes = ntpio__png_stream_shell(s->stream, &s->shell.end);
    return read_end(reader, error);
}

static void png_close(ntpio_reader *reader)
{
    png_state *s = reader->state;
    if (s == NULL)
        return;
    drop_other(s);
    png_destroy_read_struct(&s->png, &s->info, &s->end_info);
    ntpio__png_stream_close(s->stream);
    free(s);
}

static bool png_rewind(ntpio_reader *reader)
{
    png_state *s = reader->state;
    return s->stream != NULL && s->other == NULL && ntpio__png_stream_rewind(s->stream);
}

static bool png_unpack(ntpio_reader *reader)
{
    const png_state *s = reader->state;
    return s->stream != NULL && ntpio__png_stream_unpack(s->stream);
}

const ntpio__decoder ntpio__png_decoder = { png_open,  png_rows,   png_end,
                                            png_close, png_rewind, png_unpack };
