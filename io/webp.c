/* SPDX-License-Identifier: MIT */
/*
 * webp.c - WebP through libwebp: read, and written without loss
 *
 * The library takes the whole file and gives the whole picture, so nothing streams.  Texels are
 * RGB, or RGBA where the file says that its alpha is used; colors below an alpha of 0 are kept.
 */
#include <stdlib.h>
#include <string.h>

#include <webp/decode.h>
#include <webp/encode.h>

#include "formats.h"

enum {
    RIFF_SIZE = 12,      /* "RIFF", the bytes that follow, "WEBP" */
    EXTENDED_FLAGS = 20, /* where a file that begins with VP8X has its flags */
    FLAG_ICC = 0x20,     /* a color profile */
    WORKING_COPIES = 3,  /* of 4 bytes a texel: what libwebp holds besides our rows, at most */
    PRESET_USUAL = 6,    /* of 0 to 9: more takes much longer for little */
    PRESET_MAX = 9,
    FORMAT_LOSSY = 1, /* WebPBitstreamFeatures.format */
    FORMAT_LOSSLESS = 2
};

static bool damaged(const ntpio_reader *reader, VP8StatusCode status, ntpio_error *error)
{
    if (status == VP8_STATUS_NOT_ENOUGH_DATA)
        return ntpio__fail_ended(reader, error);
    if (status == VP8_STATUS_OUT_OF_MEMORY)
        return ntpio__fail_memory(error, reader->name);
    return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "damaged (WebP, status %d)",
                       (int) status);
}

/* Holds the file, and refuses one that ends before its header says so. */
static bool hold_file(ntpio_reader *reader, ntpio_error *error)
{
    const uint8_t *b = reader->source.bytes + reader->source.at;
    const size_t there = reader->source.end - reader->source.at;
    if (there < RIFF_SIZE)
        return ntpio__fail_ended(reader, error);
    const uint64_t size = (uint64_t) b[4] + ((uint64_t) b[5] << 8) + ((uint64_t) b[6] << 16) +
                          ((uint64_t) b[7] << 24) + 8;
    if (!ntpio__hold_source(reader, error))
        return false;
    return reader->source.end - reader->source.at >= size || ntpio__fail_ended(reader, error);
}

static bool take_header(ntpio_reader *reader, const WebPBitstreamFeatures *f, ntpio_error *error)
{
    ntpio_info *info = &reader->info;
    const uint8_t *b = reader->source.bytes + reader->source.at;
    if (!ntpio__check_size(reader, (uint64_t) f->width, (uint64_t) f->height, error))
        return false;
    if (f->has_animation)
        return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                           "an animated WebP; only single pictures are read");
    info->format = NTPIO_WEBP;
    info->width = (uint32_t) f->width;
    info->height = (uint32_t) f->height;
    info->channels = f->has_alpha ? 4 : 3;
    info->alpha = f->has_alpha;
    info->sample_bytes = 1;
    info->bit_depth = 8;
    info->lossy = f->format != FORMAT_LOSSLESS;
    info->jpeg_subsampled = f->format == FORMAT_LOSSY; /* it always is */
    info->has_iccp = memcmp(b + RIFF_SIZE, "VP8X", 4) == 0 && (b[EXTENDED_FLAGS] & FLAG_ICC) != 0;
    return true;
}

static bool webp_open(ntpio_reader *reader, ntpio_error *error)
{
    WebPDecoderConfig config;
    if (!hold_file(reader, error))
        return false;
    if (!WebPInitDecoderConfig(&config))
        return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                           "libwebp is not the version that this was built for");
    const uint8_t *bytes = reader->source.bytes + reader->source.at;
    const size_t size = reader->source.end - reader->source.at;
    VP8StatusCode status = WebPGetFeatures(bytes, size, &config.input);
    if (status != VP8_STATUS_OK)
        return damaged(reader, status, error);
    if (!take_header(reader, &config.input, error))
        return false;
    const ntpio_info *info = &reader->info;
    const uint64_t texels = (uint64_t) info->width * info->height;
    if (!ntpio__check_memory(reader, texels * 4 * WORKING_COPIES + size, error) ||
        !ntpio__hold(reader, error))
        return false;
    const size_t row = ntpio__row_bytes(info);
    config.output.colorspace = info->alpha ? MODE_RGBA : MODE_RGB;
    config.output.is_external_memory = 1;
    config.output.u.RGBA.rgba = reader->held;
    config.output.u.RGBA.stride = (int) row;
    config.output.u.RGBA.size = row * info->height;
    status = WebPDecode(bytes, size, &config);
    WebPFreeDecBuffer(&config.output);
    return status == VP8_STATUS_OK || damaged(reader, status, error);
}

static void webp_close(ntpio_reader *reader)
{
    (void) reader; /* the rows are held, and there is no state */
}

const ntpio__decoder ntpio__webp_decoder = { webp_open, NULL, NULL, webp_close, NULL, NULL };

/* ------------------------------------------------------------------------ writing */

typedef struct webp_writer {
    WebPPicture picture;
    ntpio_error *error;
    bool output_failed; /* and *error says how */
    ntpio_writer *writer;
} webp_writer;

static int on_write(const uint8_t *bytes, size_t size, const WebPPicture *picture)
{
    webp_writer *s = picture->custom_ptr;
    s->output_failed = !ntpio__output_write(s->writer->output, bytes, size, s->error);
    return !s->output_failed;
}

static bool webp_write_open(ntpio_writer *writer, ntpio_error *error)
{
    const ntpio_write_options *o = &writer->options;
    webp_writer *s = calloc(1, sizeof *s);
    if (s == NULL)
        return ntpio__fail_memory(error, writer->name);
    writer->state = s;
    s->writer = writer;
    if (!WebPPictureInit(&s->picture))
        return ntpio__fail(error, NTPIO_ERR_WRITE, writer->name,
                           "libwebp is not the version that this was built for");
    s->picture.use_argb = 1;
    s->picture.width = (int) o->width;
    s->picture.height = (int) o->height;
    s->picture.writer = on_write;
    s->picture.custom_ptr = s;
    return WebPPictureAlloc(&s->picture) || ntpio__fail_memory(error, writer->name);
}

static void pack_row(uint32_t *dst, const uint8_t *src, uint32_t width, int32_t channels)
{
    for (uint32_t x = 0; x < width; x++, src += channels) {
        const uint32_t alpha = channels == 4 ? src[3] : 255;
        dst[x] = alpha << 24 | (uint32_t) src[0] << 16 | (uint32_t) src[1] << 8 | src[2];
    }
}

static bool webp_write_rows(ntpio_writer *writer, const uint8_t *src, ptrdiff_t stride,
                            uint32_t count, ntpio_error *error)
{
    const webp_writer *s = writer->state;
    (void) error;
    for (uint32_t i = 0; i < count; i++)
        pack_row(s->picture.argb + (size_t) (writer->row + i) * (size_t) s->picture.argb_stride,
                 src + (ptrdiff_t) i * stride, writer->options.width, writer->options.channels);
    return true;
}

static bool webp_write_end(ntpio_writer *writer, ntpio_error *error)
{
    webp_writer *s = writer->state;
    const int32_t level = writer->options.level < 0 ? PRESET_USUAL : writer->options.level;
    WebPConfig config;
    s->error = error;
    bool done = WebPConfigInit(&config) &&
                WebPConfigLosslessPreset(&config, level < PRESET_MAX ? level : PRESET_MAX);
    config.exact = 1; /* also below an alpha of 0 */
    done = done && WebPEncode(&config, &s->picture);
    if (done || s->output_failed)
        return done;
    if (s->picture.error_code == VP8_ENC_ERROR_OUT_OF_MEMORY)
        return ntpio__fail_memory(error, writer->name);
    return ntpio__fail(error, NTPIO_ERR_WRITE, writer->name,
                       "cannot be encoded (libwebp, error %d)", (int) s->picture.error_code);
}

static void webp_write_close(ntpio_writer *writer)
{
    webp_writer *s = writer->state;
    WebPPictureFree(&s->picture);
    free(s);
}

const ntpio__encoder ntpio__webp_encoder = { webp_write_open, webp_write_rows, webp_write_end,
                                             webp_write_close };
