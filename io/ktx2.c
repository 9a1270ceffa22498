/* SPDX-License-Identifier: MIT */
/*
 * ktx2.c - Khronos Texture 2: a header, an index of mips, and what describes the data
 *
 * A mip holds all of its layers and faces, and may be compressed as a whole by zlib or zstd.  Basis
 * Universal (ETC1S, UASTC) and ASTC are named, not read.
 */
#include <stdlib.h>
#include <string.h>
#define ZLIB_CONST
#include <zlib.h>
#ifdef NTPIO_HAVE_ZSTD
#  include <zstd.h>
#endif

#include "formats.h"
#include "layouts.h"

enum {
    HEADER_SIZE = 80,
    INDEX_SIZE = 24, /* of a mip: offset, bytes, bytes unpacked */
    MIPS_MAX = 32,
    DESCRIPTOR_SIZE = 20, /* as much of the data format descriptor as is looked at */
    PLAIN = 0,            /* supercompression */
    BASIS = 1,
    ZSTD = 2,
    ZLIB = 3,
    MODEL_ETC1S = 163, /* color models of the descriptor */
    MODEL_UASTC = 166,
    MODEL_ASTC = 162,
    TRANSFER_SRGB = 2
};

typedef struct header {
    ntpio__texture t;
    uint32_t number, scheme;
    uint64_t descriptor, descriptor_size;
    uint64_t offset, stored, unpacked; /* of the picked mip */
    uint32_t model, transfer;          /* 0: not known */
    uint64_t at;                       /* how far the source was read */
} header;

static bool damaged(const ntpio_reader *reader, const char *what, ntpio_error *error)
{
    return ntpio__fail(error, NTPIO_ERR_CORRUPT, reader->name, "damaged (%s)", what);
}

static bool read_index(ntpio_reader *reader, header *h, uint32_t count, ntpio_error *error)
{
    uint8_t index[MIPS_MAX * INDEX_SIZE];
    if (!ntpio__read_all(reader, index, (size_t) count * INDEX_SIZE, error))
        return false;
    const uint8_t *mip = index + (size_t) reader->limits.mip * INDEX_SIZE;
    h->offset = ntpio__u64(mip);
    h->stored = ntpio__u64(mip + 8);
    h->unpacked = ntpio__u64(mip + 16);
    return true;
}

/* The descriptor follows the index, as the rules have it; elsewhere it is not looked for. */
static bool read_descriptor(ntpio_reader *reader, header *h, ntpio_error *error)
{
    uint8_t d[DESCRIPTOR_SIZE];
    const uint64_t index_end = h->at;
    if (h->descriptor < index_end || h->descriptor_size < sizeof d ||
        h->descriptor - index_end > 1 << 20)
        return true;
    h->at = h->descriptor + sizeof d;
    if (!ntpio__texture_seek(reader, index_end, h->descriptor, error) ||
        !ntpio__read_all(reader, d, sizeof d, error))
        return false;
    h->model = d[12];
    h->transfer = d[14];
    return true;
}

static bool read_header(ntpio_reader *reader, header *h, ntpio_error *error)
{
    uint8_t b[HEADER_SIZE];
    if (!ntpio__read_all(reader, b, sizeof b, error))
        return false;
    if (memcmp(b, "\xabKTX 20\xbb\r\n\x1a\n", 12) != 0)
        return damaged(reader, "the signature of KTX2", error);
    const uint32_t depth = ntpio__u32(b + 28), layers = ntpio__u32(b + 32);
    const uint32_t faces = ntpio__u32(b + 36), levels = ntpio__u32(b + 40);
    const uint32_t height = ntpio__u32(b + 24);
    *h = (header) { .number = ntpio__u32(b + 12),
                    .scheme = ntpio__u32(b + 44),
                    .descriptor = ntpio__u32(b + 48),
                    .descriptor_size = ntpio__u32(b + 52) };
    h->t = (ntpio__texture) { .width = ntpio__u32(b + 20),
                              .height = height != 0 ? height : 1,
                              .mips = levels != 0 ? levels : 1,
                              .cube = faces == 6 };
    if (depth != 0)
        return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                           "a volume texture, which is not read");
    if (faces != 1 && faces != 6)
        return damaged(reader, "neither 1 face nor 6", error);
    h->t.layers = layers > UINT32_MAX / 6 ? UINT32_MAX : (layers != 0 ? layers : 1) * faces;
    if (!ntpio__texture_check(reader, &h->t, error))
        return false;
    h->at = HEADER_SIZE + (uint64_t) h->t.mips * INDEX_SIZE;
    return read_index(reader, h, h->t.mips, error) && read_descriptor(reader, h, error);
}

/* Of ETC1S or UASTC. */
static bool is_basis(const header *h)
{
    return h->model == MODEL_UASTC || h->model == MODEL_ETC1S || h->scheme == BASIS;
}

/* "a KTX2 texture of UASTC, 512 x 512, 10 mips, marked sRGB, ..." */
static bool not_read(const ntpio_reader *reader, const header *h, const char *what,
                     ntpio_error *error)
{
    return ntpio__fail(error, NTPIO_ERR_FORMAT, reader->name,
                       "a KTX2 texture of %s, %lu x %lu, %lu mip%s%s: its pixels are not read%s",
                       what, (unsigned long) h->t.width, (unsigned long) h->t.height,
                       (unsigned long) h->t.mips, h->t.mips == 1 ? "" : "s",
                       h->transfer == TRANSFER_SRGB ? ", marked sRGB, which is wrong for normals"
                                                    : "",
                       is_basis(h) ? "; `ktx transcode` (KTX-Software) makes a KTX2 that is" : "");
}

static const char *basis_name(const header *h)
{
    return h->model == MODEL_UASTC   ? "UASTC"
           : h->model == MODEL_ETC1S ? "ETC1S"
           : h->scheme == BASIS      ? "Basis Universal"
                                     : "an unnamed format";
}

/* ------------------------------------------------------------------------ unpacking */

static bool unpack_zlib(uint8_t *dst, size_t size, const uint8_t *src, size_t stored)
{
    z_stream z = { 0 };
    if (inflateInit(&z) != Z_OK)
        return false;
    int status = Z_OK;
    size_t in = 0, out = 0;
    while (status == Z_OK) {
        const size_t step = (size_t) 1 << 30;
        const uInt more_in = (uInt) (stored - in < step ? stored - in : step);
        const uInt more_out = (uInt) (size - out < step ? size - out : step);
        z.next_in = src + in;
        z.avail_in = more_in;
        z.next_out = dst + out;
        z.avail_out = more_out;
        status = inflate(&z, Z_NO_FLUSH);
        in += more_in - z.avail_in;
        out += more_out - z.avail_out;
    }
    inflateEnd(&z);
    return status == Z_STREAM_END && out == size;
}

static bool unpack(uint32_t scheme, uint8_t *dst, size_t size, const uint8_t *src, size_t stored)
{
    if (scheme == ZLIB)
        return unpack_zlib(dst, size, src, stored);
#ifdef NTPIO_HAVE_ZSTD
    return ZSTD_decompress(dst, size, src, stored) == size;
#else
    return false;
#endif
}

/* Reads and unpacks the picked mip, and returns its picked layer. */
static uint8_t *unpacked_image(ntpio_reader *reader, const header *h, uint64_t bytes,
                               ntpio_error *error)
{
    const uint32_t layer = reader->limits.layer_and_one != 0 ? reader->limits.layer_and_one - 1 : 0;
    if (!ntpio__check_memory(reader, h->unpacked, error) ||
        !ntpio__check_memory(reader, h->stored, error))
        return NULL;
    uint8_t *stored = malloc((size_t) h->stored), *all = malloc((size_t) h->unpacked);
    bool done = stored != NULL && all != NULL;
    if (!done)
        ntpio__fail_memory(error, reader->name);
    done = done && ntpio__read_all(reader, stored, (size_t) h->stored, error);
    if (done && !unpack(h->scheme, all, (size_t) h->unpacked, stored, (size_t) h->stored))
        done = damaged(reader, "the packed data", error);
    free(stored);
    if (!done) {
        free(all);
        return NULL;
    }
    memmove(all, all + (size_t) (bytes * layer), (size_t) bytes);
    return all;
}

static bool find_layout(ntpio_reader *reader, header *h, ntpio_error *error)
{
    bool srgb = false;
    if (h->number == 0 || h->scheme == BASIS)
        return not_read(reader, h, basis_name(h), error);
    if (!ntpio__layout_of_vulkan(h->number, &h->t, &srgb))
        return not_read(reader, h, h->t.name, error);
    reader->info.has_srgb = srgb || h->transfer == TRANSFER_SRGB;
    if (h->scheme > ZLIB)
        return not_read(reader, h, "an unknown supercompression", error);
#ifndef NTPIO_HAVE_ZSTD
    if (h->scheme == ZSTD)
        return not_read(reader, h, "zstd, which this build lacks", error);
#endif
    return true;
}

static bool ktx2_open(ntpio_reader *reader, ntpio_error *error)
{
    header h;
    uint64_t size;
    if (!read_header(reader, &h, error) || !find_layout(reader, &h, error))
        return false;
    const uint64_t bytes = ntpio__texture_bytes(&h.t, reader->limits.mip);
    const uint64_t all = bytes * h.t.layers;
    if (h.scheme == PLAIN ? h.stored < all : h.unpacked != all || h.stored == 0)
        return damaged(reader, "bytes of a mip", error);
    const bool seeks = ntpio__can_seek(&reader->source);
    if (seeks && !ntpio__size(&reader->source, &size))
        return ntpio__fail_ended(reader, error);
    if (seeks && (h.offset > size || h.stored > size - h.offset))
        return ntpio__fail_ended(reader, error);
    if (!seeks && h.offset < h.at)
        return damaged(reader, "the place of a mip", error);
    const uint32_t picked = reader->limits.layer_and_one;
    const uint64_t skipped = h.scheme == PLAIN && picked > 1 ? bytes * (picked - 1) : 0;
    reader->info.format = NTPIO_KTX2;
    if (!ntpio__texture_seek(reader, h.at, h.offset + skipped, error))
        return false;
    uint8_t *image = h.scheme == PLAIN ? NULL : unpacked_image(reader, &h, bytes, error);
    if (h.scheme != PLAIN && image == NULL)
        return false;
    return ntpio__texture_start(reader, &h.t, image, error);
}

const ntpio__decoder ntpio__ktx2_decoder = { ktx2_open, ntpio__texture_rows,
                                             NULL,      ntpio__texture_close,
                                             NULL,      NULL };
