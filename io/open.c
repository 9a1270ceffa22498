/* SPDX-License-Identifier: MIT */
/*
 * open.c - finds the format of a file, and reads its rows through the decoder of that format
 *
 * The content decides, not the name.  Only TGA has no signature: there the header has to be free of
 * contradictions, or the name says TGA and the footer does too.
 */
#include <stdlib.h>
#include <string.h>

#include "formats.h"

static const ntpio_limits default_limits = { .max_side = 65535,
                                             .max_texels = (uint64_t) 1 << 30,
                                             .max_memory = (uint64_t) 4 << 30,
                                             .max_at_once = (uint64_t) 256 << 20 };

/* ------------------------------------------------------------------------ formats */

static bool ends_with(const char *name, const char *suffix)
{
    const size_t n = strlen(name), m = strlen(suffix);
    if (n < m)
        return false;
    for (size_t i = 0; i < m; i++) {
        const char c = name[n - m + i];
        if ((c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c) != suffix[i])
            return false;
    }
    return true;
}

static bool has_tga_footer(ntpio__source *source)
{
    static const char signature[] = "TRUEVISION-XFILE.";
    enum { SIGNATURE_SIZE = sizeof signature }; /* its zero included, as in the file */
    char last[SIGNATURE_SIZE];
    uint64_t size;
    if (!ntpio__can_seek(source) || !ntpio__size(source, &size) || size < SIGNATURE_SIZE)
        return false;
    const bool found = ntpio__seek(source, size - SIGNATURE_SIZE) &&
                       ntpio__read(source, last, SIGNATURE_SIZE) == SIGNATURE_SIZE &&
                       memcmp(last, signature, SIGNATURE_SIZE) == 0;
    return ntpio__seek(source, 0) && found;
}

#define BY_PYTHON "Python reads it after pip install 'normaltexture[images]'"
#define EXR_START "\x76\x2f\x31\x01"

/* What a file is that cannot be read here, if it is known; else NULL. */
static const char *foreign(const uint8_t *b, size_t n)
{
    static const struct {
        const char *start, *what;
    } known[] = {
        { "version https://git-lfs", "a Git LFS pointer, not the image: run `git lfs pull`" },
        { "GIF8", "GIF images are not read" },
        { "BM", "BMP images are not read" },
        { "II*", "a TIFF image, which is not read; " BY_PYTHON },
        { "MM", "a TIFF image, which is not read; " BY_PYTHON },
        { "8BPS", "Photoshop documents are not read" },
#ifndef NTPIO_HAVE_EXR
        { EXR_START, "an EXR image, which this build does not read: it needs OpenEXR (Debian: "
                     "libopenexr-dev) when it is built; " BY_PYTHON },
#endif
        { "#?RADIANCE", "Radiance HDR images are not read" },
        { "\xabKTX 11", "KTX textures of version 1 are not read, only KTX2" },
        { "\x13\xab\xa1\x5c", "an ASTC texture, which is not read; astcenc -dl makes a PNG of it "
                              "(Debian: astcenc)" },
        { "RIFF", "RIFF files that are no WebP are not read" },
        { "gimp xcf", "GIMP documents are not read" },
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        const size_t size = strlen(known[i].start);
        if (n >= size && memcmp(b, known[i].start, size) == 0)
            return known[i].what;
    }
    return NULL;
}

static const ntpio__decoder *find_decoder(ntpio_reader *reader, ntpio_error *error)
{
    const size_t n = ntpio__peek(&reader->source, NTPIO__PEEK);
    const uint8_t *b = reader->source.bytes + reader->source.at;
    if (n == 0) {
        ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "empty file");
        return NULL;
    }
    if (n >= 4 && memcmp(b, "\x89PNG", 4) == 0)
        return &ntpio__png_decoder;
    if (n >= 3 && memcmp(b, "\xff\xd8\xff", 3) == 0) {
#ifdef NTPIO_HAVE_JPEG
        return &ntpio__jpeg_decoder;
#else
        ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                    "a JPEG image, which this build does not read");
        return NULL;
#endif
    }
    if (n >= 3 && b[0] == 'P' && (b[1] == 'F' || b[1] == 'f') &&
        (b[2] == '\n' || b[2] == '\r' || b[2] == ' ' || b[2] == '\t'))
        return &ntpio__pfm_decoder;
    if (n >= 4 && memcmp(b, "DDS ", 4) == 0)
        return &ntpio__dds_decoder;
    if (n >= 7 && memcmp(b, "\xabKTX 20", 7) == 0)
        return &ntpio__ktx2_decoder;
    if (n >= 12 && memcmp(b, "RIFF", 4) == 0 && memcmp(b + 8, "WEBP", 4) == 0) {
#ifdef NTPIO_HAVE_WEBP
        return &ntpio__webp_decoder;
#else
        ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                    "a WebP image, which this build does not read: it needs libwebp (Debian: "
                    "libwebp-dev) when it is built; " BY_PYTHON);
        return NULL;
#endif
    }
#ifdef NTPIO_HAVE_EXR
    if (n >= 4 && memcmp(b, EXR_START, 4) == 0)
        return &ntpio__exr_decoder;
#endif
    const char *what = foreign(b, n);
    if (n >= 12 && (memcmp(b + 4, "ftypavif", 8) == 0 || memcmp(b + 4, "ftypavis", 8) == 0))
        what = "an AVIF image, which is not read; " BY_PYTHON;
    const bool plausible = what == NULL && ntpio__tga_plausible(b, n);
    if (plausible || ends_with(reader->name, ".tga") || ends_with(reader->name, ".targa")) {
        if (plausible || (what == NULL && has_tga_footer(&reader->source)))
            return &ntpio__tga_decoder;
        ntpio__fail(error, n < 18 ? NTPIO_ERR_CORRUPT : NTPIO_ERR_FORMAT, reader->name, "%s",
                    what != NULL ? what
                    : n < 18     ? "truncated"
                                 : "not a TGA image of a kind that is read here");
        return NULL;
    }
    ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name, "%s",
                what != NULL ? what : "not a PNG, TGA, JPEG, PFM, DDS, KTX2, WebP or EXR image");
    return NULL;
}

/* ------------------------------------------------------------------------ readers */

static ntpio_reader *new_reader(const char *name, const ntpio_limits *limits, ntpio_error *error)
{
    ntpio_reader *reader = calloc(1, sizeof *reader);
    if (reader != NULL)
        reader->name = ntpio__copy_string(name, strlen(name));
    if (reader == NULL || reader->name == NULL) {
        free(reader);
        ntpio__fail_memory(error, name);
        return NULL;
    }
    reader->limits = default_limits;
    if (limits != NULL && limits->max_side != 0)
        reader->limits.max_side = limits->max_side < INT32_MAX ? limits->max_side : INT32_MAX;
    if (limits != NULL && limits->max_texels != 0)
        reader->limits.max_texels = limits->max_texels;
    if (limits != NULL && limits->max_memory != 0)
        reader->limits.max_memory = limits->max_memory;
    if (limits != NULL && limits->max_at_once != 0)
        reader->limits.max_at_once = limits->max_at_once;
    if (limits != NULL) {
        reader->limits.one_pass = limits->one_pass;
        reader->limits.mip = limits->mip;
        reader->limits.layer_and_one = limits->layer_and_one;
        reader->limits.pairs_as_rgb = limits->pairs_as_rgb;
        reader->limits.vectors_as_texels = limits->vectors_as_texels;
    }
    return reader;
}

static ntpio_reader *start(ntpio_reader *reader, ntpio_error *error)
{
    const ntpio__decoder *decoder = find_decoder(reader, error);
    if (decoder != NULL) {
        reader->info.streams = true;
        reader->decoder = decoder;
        if (decoder->open(reader, error))
            return reader;
    }
    ntpio_close(reader);
    return NULL;
}

ntpio_reader *ntpio_open(const char *path, const ntpio_limits *limits, ntpio_error *error)
{
    const bool standard = strcmp(path, "-") == 0;
    ntpio_reader *reader = new_reader(standard ? "standard input" : path, limits, error);
    if (reader == NULL)
        return NULL;
    if (!ntpio__source_open(&reader->source, path, limits != NULL && limits->regular_only, error)) {
        ntpio_close(reader);
        return NULL;
    }
    reader->info.stamp = reader->source.stamp;
    return start(reader, error);
}

ntpio_reader *ntpio_open_memory(const void *bytes, size_t size, const char *name,
                                const ntpio_limits *limits, ntpio_error *error)
{
    ntpio_reader *reader = new_reader(name, limits, error);
    if (reader == NULL)
        return NULL;
    ntpio__source_memory(&reader->source, bytes, size);
    return start(reader, error);
}

const ntpio_info *ntpio_reader_info(const ntpio_reader *reader)
{
    return &reader->info;
}

bool ntpio_read_rows(ntpio_reader *reader, void *dst, ptrdiff_t stride, uint32_t count,
                     ntpio_error *error)
{
    if (count > reader->info.height - reader->row)
        return ntpio__fail(error, NTPIO_ERR_USAGE, reader->name, "no more than %lu rows are there",
                           (unsigned long) reader->info.height);
    if (reader->held != NULL) {
        const size_t size = ntpio__row_bytes(&reader->info);
        for (uint32_t i = 0; i < count; i++)
            memcpy((uint8_t *) dst + (ptrdiff_t) i * stride,
                   reader->held + (size_t) (reader->row + i) * size, size);
    } else if (count != 0 && !reader->decoder->rows(reader, dst, stride, count, error)) {
        return false;
    }
    reader->row += count;
    return true;
}

bool ntpio_read_end(ntpio_reader *reader, ntpio_error *error)
{
    if (reader->row != reader->info.height)
        return ntpio__fail(error, NTPIO_ERR_USAGE, reader->name, "rows are left to read");
    return reader->decoder->end == NULL || reader->decoder->end(reader, error);
}

bool ntpio_rewind(ntpio_reader *reader)
{
    const ntpio__decoder *decoder = reader->decoder;
    const bool can = reader->held != NULL || (decoder->rewind != NULL && decoder->rewind(reader));
    if (can)
        reader->row = 0;
    return can;
}

bool ntpio_unpack(ntpio_reader *reader)
{
    return reader->decoder->unpack != NULL && reader->decoder->unpack(reader);
}

void ntpio_close_file(ntpio_reader *reader)
{
    ntpio__source_close(&reader->source);
}

void ntpio_close(ntpio_reader *reader)
{
    if (reader == NULL)
        return;
    if (reader->decoder != NULL)
        reader->decoder->close(reader);
    ntpio__source_close(&reader->source);
    ntpio__free_texts(&reader->info);
    free(reader->held);
    free(reader->name);
    free(reader);
}
