/* SPDX-License-Identifier: MIT */
/*
 * exr.c - OpenEXR through its C library, OpenEXRCore: one part, of half or single floats
 *
 * Files hold bands of rows or of tiles, packed one by one; a band is unpacked at a time, all of its
 * channels, and those that exr_channels.c picks become rows.  Numbers stay as they are, NaN and
 * infinities too.  The picture is the data window, which is what is stored.  The library asks for
 * bytes at any place: a pipe is held whole.
 */
#include <stdlib.h>
#include <string.h>

#include "exr_channels.h"
#include "exr_library.h"
#include "formats.h"
#include "half.h"

enum { MESSAGE_SIZE = 200, SAMPLE = sizeof(float) };

typedef struct exr_state {
    exr_context_t context;
    exr_decode_pipeline_t pipeline;
    ntpio_reader *reader;
    bool decoding; /* the pipeline is initialized */
    bool tiled, packed;
    int32_t left, top;    /* of the data window */
    uint32_t tile_width;  /* tiles only */
    uint32_t band_height; /* rows of a band: of a chunk, or of a tile */
    uint32_t band;        /* the one in `rows`, plus one */
    ntpio__exr_choice choice;
    int32_t channels; /* of the rows */
    float *rows;
    uint8_t *plain; /* a chunk of a file that is not packed, else NULL */
    uint64_t plain_size;
    bool ended; /* the source gave less than it was asked for */
    char message[MESSAGE_SIZE];
} exr_state;

/* ------------------------------------------------------------------------ the library's side */

static exr_state *state_of(exr_const_context_t context)
{
    void *user = NULL;
    EXR(get_user_data)(context, &user);
    return user;
}

/* The first message says what is wrong; later ones follow from it. */
static void on_error(exr_const_context_t context, exr_result_t code, const char *message)
{
    exr_state *s = state_of(context);
    (void) code;
    if (s == NULL || s->message[0] != 0)
        return;
    ntpio__exr_plain(s->message, sizeof s->message, message);
}

static int64_t on_read(exr_const_context_t context, void *user, void *bytes, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t report)
{
    exr_state *s = user;
    ntpio__source *source = &s->reader->source;
    (void) context;
    (void) report;
    if (size > PTRDIFF_MAX || !ntpio__seek(source, offset)) {
        s->ended = true;
        return -1;
    }
    const size_t got = ntpio__read(source, bytes, (size_t) size);
    s->ended = s->ended || got < size;
    return (int64_t) got;
}

static int64_t on_size(exr_const_context_t context, void *user)
{
    exr_state *s = user;
    uint64_t size;
    (void) context;
    return ntpio__size(&s->reader->source, &size) && size <= INT64_MAX ? (int64_t) size : -1;
}

static bool fail(exr_state *s, exr_result_t result, ntpio_error *error)
{
    if (result == EXR_ERR_OUT_OF_MEMORY)
        return ntpio__fail_memory(error, s->reader->name);
    if (s->reader->source.problem != 0 || (result == EXR_ERR_READ_IO && s->ended))
        return ntpio__fail_ended(s->reader, error);
    return ntpio__fail(error, NTPIO_ERR_CORRUPT, s->reader->name, "damaged (%s)",
                       s->message[0] != 0 ? s->message : EXR(get_default_error_message)(result));
}

static exr_result_t start_library(exr_state *s)
{
    exr_context_initializer_t with = EXR_DEFAULT_CONTEXT_INITIALIZER;
    with.error_handler_fn = on_error;
    with.user_data = s;
    with.read_fn = on_read;
    with.size_fn = on_size;
#ifdef EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION
    with.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION; /* a cut file is refused */
#endif
    return EXR(start_read)(&s->context, "image", &with);
}

/* ------------------------------------------------------------------------ the header */

static bool check_parts(exr_state *s, ntpio_error *error)
{
    int parts = 0;
    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    exr_result_t result = EXR(get_count)(s->context, &parts);
    if (result == EXR_ERR_SUCCESS && parts != 1)
        return ntpio__fail(error, NTPIO_ERR_FORMAT, s->reader->name,
                           "an EXR of %d parts; only those of one are read", parts);
    if (result == EXR_ERR_SUCCESS)
        result = EXR(get_storage)(s->context, 0, &storage);
    if (result != EXR_ERR_SUCCESS)
        return fail(s, result, error);
    s->tiled = storage == EXR_STORAGE_TILED;
    return s->tiled || storage == EXR_STORAGE_SCANLINE ||
           ntpio__fail(error, NTPIO_ERR_FORMAT, s->reader->name,
                       "an EXR of deep data, which is not read");
}

static bool take_window(exr_state *s, ntpio_error *error)
{
    exr_attr_box2i_t window;
    const exr_result_t result = EXR(get_data_window)(s->context, 0, &window);
    if (result != EXR_ERR_SUCCESS)
        return fail(s, result, error);
    const int64_t width = (int64_t) window.max.x - window.min.x + 1;
    const int64_t height = (int64_t) window.max.y - window.min.y + 1;
    if (!ntpio__check_size(s->reader, width > 0 ? (uint64_t) width : 0,
                           height > 0 ? (uint64_t) height : 0, error))
        return false;
    s->left = window.min.x;
    s->top = window.min.y;
    s->reader->info.width = (uint32_t) width;
    s->reader->info.height = (uint32_t) height;
    return true;
}

static bool take_bands(exr_state *s, ntpio_error *error)
{
    int32_t rows = 0;
    uint32_t tile_height = 0;
    exr_tile_level_mode_t levels;
    exr_tile_round_mode_t rounding;
    const exr_result_t result = s->tiled
                                    ? EXR(get_tile_descriptor)(s->context, 0, &s->tile_width,
                                                               &tile_height, &levels, &rounding)
                                    : EXR(get_scanlines_per_chunk)(s->context, 0, &rows);
    if (result != EXR_ERR_SUCCESS)
        return fail(s, result, error);
    s->band_height = s->tiled ? tile_height : (uint32_t) rows;
    if (s->band_height == 0 || rows < 0 || (s->tiled && s->tile_width == 0))
        return ntpio__fail(error, NTPIO_ERR_CORRUPT, s->reader->name, "damaged (empty bands)");
    return true;
}

static bool take_channels(exr_state *s, ntpio_error *error)
{
    ntpio_info *info = &s->reader->info;
    const exr_attr_chlist_t *list = NULL;
    const exr_result_t result = EXR(get_channels)(s->context, 0, &list);
    if (result != EXR_ERR_SUCCESS)
        return fail(s, result, error);
    if (!ntpio__exr_choose(s->reader, list, &s->choice, error))
        return false;
    info->format = NTPIO_EXR;
    info->red_green = s->choice.pair;
    info->alpha = s->choice.alpha;
    info->vectors = s->choice.vectors;
    info->sample_bytes = SAMPLE;
    info->bit_depth = s->choice.half ? 16 : 32;
    info->channels = info->red_green && s->reader->limits.pairs_as_rgb ? 3 : s->choice.count;
    s->channels = info->channels;
    return true;
}

/* Half floats of B44 and DWA are not those that were given. */
static bool take_compression(exr_state *s, ntpio_error *error)
{
    exr_compression_t kind = EXR_COMPRESSION_NONE;
    const exr_result_t result = EXR(get_compression)(s->context, 0, &kind);
    s->reader->info.lossy = kind == EXR_COMPRESSION_B44 || kind == EXR_COMPRESSION_B44A ||
                            kind == EXR_COMPRESSION_DWAA || kind == EXR_COMPRESSION_DWAB;
    s->packed = kind != EXR_COMPRESSION_NONE;
    return result == EXR_ERR_SUCCESS || fail(s, result, error);
}

static bool make_rows(exr_state *s, ntpio_error *error)
{
    const ntpio_info *info = &s->reader->info;
    const uint32_t rows = s->band_height < info->height ? s->band_height : info->height;
    const uint64_t bytes = (uint64_t) ntpio__row_bytes(info) * rows;
    if (!ntpio__check_memory(s->reader, bytes, error))
        return false;
    const uint32_t columns = s->tiled && s->tile_width < info->width ? s->tile_width : info->width;
    s->plain_size = s->packed ? 0 : (uint64_t) columns * rows * s->choice.texel;
    if (!ntpio__check_memory(s->reader, s->plain_size + bytes, error))
        return false;
    s->rows = calloc(1, (size_t) bytes); /* a blue that is not stored is 0 */
    s->plain = s->packed ? NULL : malloc((size_t) s->plain_size);
    return (s->rows != NULL && (s->packed || s->plain != NULL)) ||
           ntpio__fail_memory(error, s->reader->name);
}

static bool exr_open(ntpio_reader *reader, ntpio_error *error)
{
    if (!ntpio__exr_load(reader, error))
        return false;
    exr_state *s = calloc(1, sizeof *s);
    if (s == NULL)
        return ntpio__fail_memory(error, reader->name);
    reader->state = s;
    s->reader = reader;
    if (!ntpio__can_seek(&reader->source) && !ntpio__hold_source(reader, error))
        return false;
    const exr_result_t result = start_library(s);
    if (result != EXR_ERR_SUCCESS)
        return fail(s, result, error);
    return check_parts(s, error) && take_window(s, error) && take_bands(s, error) &&
           take_channels(s, error) && take_compression(s, error) && make_rows(s, error);
}

/* ------------------------------------------------------------------------ the pixels */

/* A chunk is packed, unpacked and rearranged: four buffers of its size, at most. */
static bool chunk_fits(const exr_state *s, const exr_chunk_info_t *chunk, ntpio_error *error)
{
    enum { BUFFERS = 4 };
    const uint64_t most =
        chunk->unpacked_size > chunk->packed_size ? chunk->unpacked_size : chunk->packed_size;
    return ntpio__check_memory(s->reader, most < UINT64_MAX / BUFFERS ? BUFFERS * most : UINT64_MAX,
                               error);
}

static uint32_t little(const uint8_t *b, size_t size)
{
    uint32_t word = 0;
    for (size_t i = 0; i < size; i++)
        word |= (uint32_t) b[i] << (8 * i);
    return word;
}

/* A line of one channel. */
static void put_line(float *dst, int32_t step, const uint8_t *src, size_t sample, uint32_t width)
{
    for (uint32_t x = 0; x < width; x++, dst += step, src += sample) {
        const uint32_t stored = little(src, sample);
        const uint32_t bits = sample == 2 ? ntpio__from_half(stored) : stored;
        memcpy(dst, &bits, sizeof bits);
    }
}

/* A line of a chunk holds each channel in turn.  Puts those that are read into rows, from column x
 * on. */
static void put_chunk(exr_state *s, const exr_chunk_info_t *chunk, const uint8_t *data, uint32_t x)
{
    const size_t width = (size_t) chunk->width, wide = s->reader->info.width;
    for (size_t y = 0; y < (size_t) chunk->height; y++) {
        for (int32_t k = 0; k < s->choice.count; k++)
            put_line(s->rows + ((y * wide + x) * (size_t) s->channels) + k, s->channels,
                     data + y * width * s->choice.texel + width * s->choice.offset[k],
                     s->choice.bytes[k], (uint32_t) width);
    }
}

static bool damaged_chunk(const exr_state *s, ntpio_error *error)
{
    return ntpio__fail(error, NTPIO_ERR_CORRUPT, s->reader->name, "damaged (the size of a chunk)");
}

/* The library reads and unpacks; its own ways to rearrange samples trust files too much. */
static exr_result_t unpack(exr_state *s, const exr_chunk_info_t *chunk)
{
    exr_decode_pipeline_t *p = &s->pipeline;
    exr_result_t result = s->decoding ? EXR(decoding_update)(s->context, 0, chunk, p)
                                      : EXR(decoding_initialize)(s->context, 0, chunk, p);
    s->decoding = true;
    if (result == EXR_ERR_SUCCESS)
        result = EXR(decoding_choose_default_routines)(s->context, 0, p);
    p->unpack_and_convert_fn = NULL;
    return result == EXR_ERR_SUCCESS ? EXR(decoding_run)(s->context, 0, p) : result;
}

/* Unpacks a chunk into the rows, from column x on. */
static bool decode_chunk(exr_state *s, const exr_chunk_info_t *chunk, uint32_t x,
                         ntpio_error *error)
{
    const uint64_t size = (uint64_t) chunk->width * (uint64_t) chunk->height * s->choice.texel;
    if (chunk->packed_size == 0 || chunk->unpacked_size != size ||
        (s->plain != NULL && (chunk->packed_size != size || size > s->plain_size)))
        return damaged_chunk(s, error);
    if (!chunk_fits(s, chunk, error))
        return false;
    const exr_result_t result =
        s->packed ? unpack(s, chunk) : EXR(read_chunk)(s->context, 0, chunk, s->plain);
    if (result != EXR_ERR_SUCCESS)
        return fail(s, result, error);
    const exr_decode_pipeline_t *p = &s->pipeline;
    const bool as_it_was = p->unpacked_buffer == NULL && chunk->packed_size == size;
    const void *data = !s->packed ? s->plain : as_it_was ? p->packed_buffer : p->unpacked_buffer;
    if (data == NULL)
        return damaged_chunk(s, error);
    put_chunk(s, chunk, data, x);
    return true;
}

static bool read_tile(exr_state *s, uint32_t column, uint32_t band, ntpio_error *error)
{
    const ntpio_info *info = &s->reader->info;
    const uint32_t x = column * s->tile_width, y = band * s->band_height;
    exr_chunk_info_t chunk;
    const exr_result_t result =
        EXR(read_tile_chunk_info)(s->context, 0, (int) column, (int) band, 0, 0, &chunk);
    if (result != EXR_ERR_SUCCESS)
        return fail(s, result, error);
    const uint32_t width = info->width - x < s->tile_width ? info->width - x : s->tile_width;
    const uint32_t height = info->height - y < s->band_height ? info->height - y : s->band_height;
    if (chunk.width != (int32_t) width || chunk.height != (int32_t) height)
        return damaged_chunk(s, error);
    return decode_chunk(s, &chunk, x, error);
}

static bool read_scanlines(exr_state *s, uint32_t band, ntpio_error *error)
{
    const ntpio_info *info = &s->reader->info;
    const uint32_t y = band * s->band_height;
    exr_chunk_info_t chunk;
    const exr_result_t result =
        EXR(read_scanline_chunk_info)(s->context, 0, (int) ((int64_t) s->top + y), &chunk);
    if (result != EXR_ERR_SUCCESS)
        return fail(s, result, error);
    const uint32_t height = info->height - y < s->band_height ? info->height - y : s->band_height;
    if (chunk.width != (int32_t) info->width || chunk.height != (int32_t) height)
        return damaged_chunk(s, error);
    return decode_chunk(s, &chunk, 0, error);
}

/* v of -1..1 to 0..1, rounded once. */
static void bias(float *samples, size_t texels, int32_t channels)
{
    for (size_t i = 0; i < texels; i++, samples += channels) {
        for (int c = 0; c < 3; c++)
            samples[c] = (float) (((double) samples[c] + 1) / 2);
    }
}

static bool read_band(exr_state *s, uint32_t band, ntpio_error *error)
{
    const ntpio_info *info = &s->reader->info;
    const uint32_t y = band * s->band_height;
    const uint32_t rows = info->height - y < s->band_height ? info->height - y : s->band_height;
    s->band = 0;
    if (s->tiled) {
        for (uint32_t column = 0; column <= (info->width - 1) / s->tile_width; column++) {
            if (!read_tile(s, column, band, error))
                return false;
        }
    } else if (!read_scanlines(s, band, error)) {
        return false;
    }
    if (info->vectors && s->reader->limits.vectors_as_texels)
        bias(s->rows, (size_t) info->width * rows, s->channels);
    s->band = band + 1;
    return true;
}

static bool exr_rows(ntpio_reader *reader, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                     ntpio_error *error)
{
    exr_state *s = reader->state;
    const size_t row = ntpio__row_bytes(&reader->info);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t y = reader->row + i, band = y / s->band_height;
        if (s->band != band + 1 && !read_band(s, band, error))
            return false;
        memcpy(dst + (ptrdiff_t) i * stride, (const uint8_t *) s->rows + row * (y % s->band_height),
               row);
    }
    return true;
}

static void exr_close(ntpio_reader *reader)
{
    exr_state *s = reader->state;
    if (s == NULL)
        return;
    if (s->decoding)
        EXR(decoding_destroy)(s->context, &s->pipeline);
    if (s->context != NULL)
        EXR(finish)(&s->context);
    free(s->rows);
    free(s->plain);
    free(s);
}

const ntpio__decoder ntpio__exr_decoder = { exr_open, exr_rows, NULL, exr_close, NULL, NULL };
