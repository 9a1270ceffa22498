/* SPDX-License-Identifier: MIT */
/*
 * writer.c - writes rows through the encoder of a format
 *
 * The output replaces its target only if all went well.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats.h"

enum { TGA_SIDE_MAX = 65535, WEBP_SIDE_MAX = 16383, SIDE_MAX = INT32_MAX };

static const char *wrong_level(const ntpio_write_options *o)
{
    return o->level != -1 && (o->level < 1 || o->level > 12)
               ? "the compression level is 1 to 12, or -1"
               : NULL;
}

static const char *wrong_webp(const ntpio_write_options *o)
{
#ifdef NTPIO_HAVE_WEBP
    if (o->sample_bytes != 1)
        return "WebP holds 8 bits, not more; write a PNG, or 8 bits";
    if (o->channels != 3 && o->channels != 4)
        return "WebP holds RGB and RGBA, not gray; write a PNG";
    if (o->width > WEBP_SIDE_MAX || o->height > WEBP_SIDE_MAX)
        return "WebP holds at most 16383 x 16383 texels";
    return wrong_level(o);
#else
    (void) o;
    return "this build does not write WebP: it needs libwebp (Debian: libwebp-dev) when it is "
           "built";
#endif
}

static const char *wrong_shape(const ntpio_write_options *o)
{
    const int32_t c = o->channels, b = o->sample_bytes;
    if (o->width == 0 || o->height == 0)
        return "an image has at least one texel";
    if (o->width > SIDE_MAX || o->height > SIDE_MAX)
        return "sides above 2147483647 cannot be written";
    switch (o->format) {
    case NTPIO_PNG:
        if (b == 4)
            return "PNG holds no floats: write a PFM, or make 16 bits by ntp convert --depth 16";
        return c < 1 || c > 4 || b < 1 || b > 2 ? "PNG holds 1 to 4 channels of 8 or 16 bits"
                                                : wrong_level(o);
    case NTPIO_TGA:
        if (o->width > TGA_SIDE_MAX || o->height > TGA_SIDE_MAX)
            return "TGA holds at most 65535 x 65535 texels";
        return (c != 1 && c != 3 && c != 4) || b != 1 ? "TGA holds gray, RGB or RGBA of 8 bits"
                                                      : NULL;
    case NTPIO_PFM:
        return (c != 1 && c != 3) || b != 4 ? "PFM holds 1 or 3 channels of float" : NULL;
    case NTPIO_JPEG:
        return "JPEG is read, never written: it damages normals";
    case NTPIO_WEBP:
        return wrong_webp(o);
    case NTPIO_DDS:
    case NTPIO_KTX2:
        return c < 1 || c > 4 || b < 1 || b > 2 ? "DDS and KTX2 get 1 to 4 channels of 8 or 16 bits"
                                                : NULL;
    case NTPIO_EXR:
        return "EXR is read, not written";
    }
    return "an unknown format";
}

static void destroy(ntpio_writer *writer)
{
    if (writer->state != NULL)
        writer->encoder->close(writer);
    free(writer->name);
    free(writer);
}

static ntpio_writer *new_writer(const char *name, const ntpio_write_options *options,
                                ntpio_error *error)
{
    static const ntpio__encoder *const encoders[] = {
        [NTPIO_PNG] = &ntpio__png_encoder,      [NTPIO_TGA] = &ntpio__tga_encoder,
        [NTPIO_PFM] = &ntpio__pfm_encoder,      [NTPIO_DDS] = &ntpio__texture_encoder,
        [NTPIO_KTX2] = &ntpio__texture_encoder,
#ifdef NTPIO_HAVE_WEBP
        [NTPIO_WEBP] = &ntpio__webp_encoder
#endif
    };
    ntpio_writer *writer = calloc(1, sizeof *writer);
    if (writer != NULL)
        writer->name = ntpio__copy_string(name, strlen(name));
    if (writer == NULL || writer->name == NULL) {
        free(writer);
        ntpio__fail_memory(error, name);
        return NULL;
    }
    writer->options = *options;
    writer->encoder = encoders[options->format];
    return writer;
}

ntpio_writer *ntpio_create(const char *path, const ntpio_write_options *options, ntpio_error *error)
{
    const char *name = strcmp(path, "-") == 0 ? "standard output" : path;
    const char *wrong = wrong_shape(options);
    if (wrong != NULL) {
        ntpio__fail(error, NTPIO_ERR_USAGE, name, "%s", wrong);
        return NULL;
    }
    ntpio_writer *writer = new_writer(name, options, error);
    if (writer == NULL || options->dry_run)
        return writer;
    writer->output = ntpio__output_open(path, options, error);
    if (writer->output == NULL || !writer->encoder->open(writer, error)) {
        ntpio_abort(writer);
        return NULL;
    }
    return writer;
}

bool ntpio_write_rows(ntpio_writer *writer, const void *src, ptrdiff_t stride, uint32_t count,
                      ntpio_error *error)
{
    if (count > writer->options.height - writer->row) {
        writer->failed = true;
        return ntpio__fail(error, NTPIO_ERR_USAGE, writer->name, "more rows than the image has");
    }
    if (!writer->options.dry_run && count != 0 &&
        !writer->encoder->rows(writer, src, stride, count, error)) {
        writer->failed = true;
        return false;
    }
    writer->row += count;
    return true;
}

bool ntpio_commit(ntpio_writer *writer, ntpio_error *error)
{
    if (writer->failed || writer->row != writer->options.height) {
        ntpio__fail(error, NTPIO_ERR_USAGE, writer->name, "rows are missing");
        ntpio_abort(writer);
        return false;
    }
    bool done = true;
    if (!writer->options.dry_run) {
        if (!writer->encoder->end(writer, error)) {
            ntpio_abort(writer);
            return false;
        }
        done = ntpio__output_commit(writer->output, error);
    }
    destroy(writer);
    return done;
}

void ntpio_abort(ntpio_writer *writer)
{
    if (writer == NULL)
        return;
    if (writer->output != NULL)
        ntpio__output_abort(writer->output);
    destroy(writer);
}
