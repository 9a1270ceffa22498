/* SPDX-License-Identifier: MIT */
/*
 * fuzz_png.c - reads PNG files of any chunks and any rows
 *
 * The input is a file whose first byte says what becomes of it: it is read with its checksums mended (so
 * is any PNG file), with the data of its pixels packed anew (then they are the filtered rows, which
 * change byte by byte), or as it is.  The rest of the signature does not count.
 */
#include "both_ways.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum {
    SIGNATURE = 8,
    CHUNK = 12,
    AS_IT_IS = 0,
    PACKED_ANEW = 1, /* 2 is mended, and 0x89 is 2 modulo 3 */
    WAYS = 3,
    STREAM = 11,       /* bytes around those of a block as they are */
    STORED_MAX = 65535 /* bytes of it */
};

/* Writes a zlib stream of one block, and returns its size. */
static size_t store(uint8_t *out, const uint8_t *bytes, size_t size)
{
    const uint8_t head[] = { 0x78,
                             0x01,
                             1,
                             (uint8_t) size,
                             (uint8_t) (size >> 8),
                             (uint8_t) ~size,
                             (uint8_t) (~size >> 8) };
    memcpy(out, head, sizeof head);
    memmove(out + sizeof head, bytes, size);
    put_big_endian(out + sizeof head + size, (uint32_t) adler32(1, bytes, (uInt) size));
    return size + STREAM;
}

/* The end of the chunk at `at`, or of the file. */
static size_t end_of_chunk(const uint8_t *file, size_t size, size_t at)
{
    const size_t left = size - at;
    return left < CHUNK || big_endian(file + at) > left - CHUNK
               ? size
               : at + CHUNK + big_endian(file + at);
}

/* Packs what stands in the first of the chunks of pixels; returns the size of the copy in `out`. */
static size_t pack_anew(uint8_t *out, const uint8_t *file, size_t size)
{
    size_t used = SIGNATURE;
    memcpy(out, file, SIGNATURE);
    for (size_t at = SIGNATURE, end, done = 0; at < size; at = end) {
        end = end_of_chunk(file, size, at);
        const size_t whole = end - at;
        const bool pixels = !done && whole >= CHUNK && whole - CHUNK <= STORED_MAX &&
                            memcmp(file + at + 4, "IDAT", 4) == 0;
        memcpy(out + used, file + at, whole);
        if (pixels) {
            const size_t packed = store(out + used + 8, file + at + 8, whole - CHUNK);
            put_big_endian(out + used, (uint32_t) packed);
            used += packed + CHUNK;
            done = 1;
        } else {
            used += whole;
        }
    }
    return used;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < SIGNATURE)
        return 0;
    const int way = data[0] % WAYS;
    uint8_t *file = malloc(size + STREAM);
    require(file != NULL, "memory");
    if (way == PACKED_ANEW)
        size = pack_anew(file, data, size);
    else
        memcpy(file, data, size);
    memcpy(file, "\x89PNG\r\n\x1a\n", SIGNATURE);
    if (way != AS_IT_IS)
        mend(file, size);
    uint8_t *exact = malloc(size);
    require(exact != NULL, "memory");
    memcpy(exact, file, size);
    free(file);
    read_both_ways(exact, size);
    free(exact);
    return 0;
}
