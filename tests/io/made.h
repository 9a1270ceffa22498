/* SPDX-License-Identifier: MIT */
/*
 * made.h - image files made byte by byte, without the libraries under test
 *
 * PNG with stored deflate blocks, own CRC and Adler; the caller knows every sample.
 */
#ifndef MADE_H
#define MADE_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition);                        \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

typedef struct made {
    uint8_t bytes[1 << 17];
    size_t size;
} made;

static inline void put(made *m, const void *bytes, size_t size)
{
    CHECK(m->size + size <= sizeof m->bytes);
    memcpy(m->bytes + m->size, bytes, size);
    m->size += size;
}

static inline void put_be32(made *m, uint32_t v)
{
    const uint8_t b[] = { (uint8_t) (v >> 24), (uint8_t) (v >> 16 & 255), (uint8_t) (v >> 8 & 255),
                          (uint8_t) (v & 255) };
    put(m, b, 4);
}

static inline uint32_t crc(const uint8_t *b, size_t size)
{
    uint32_t c = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        c ^= b[i];
        for (int k = 0; k < 8; k++)
            c = (c >> 1) ^ ((c & 1) != 0 ? 0xedb88320u : 0);
    }
    return ~c;
}

static inline void chunk(made *m, const char *name, const void *data, size_t size)
{
    put_be32(m, (uint32_t) size);
    const size_t at = m->size;
    put(m, name, 4);
    put(m, data, size);
    put_be32(m, crc(m->bytes + at, size + 4));
}

/* Stored blocks: the data as they are. */
static inline void pixels(made *m, const uint8_t *data, size_t size)
{
    static made z;
    uint32_t a = 1, b = 0;
    z.size = 0;
    put(&z, "\x78\x01", 2);
    for (size_t at = 0; at < size || at == 0;) {
        const size_t some = size - at < 60000 ? size - at : 60000;
        const uint8_t head[] = { at + some == size, (uint8_t) (some & 255), (uint8_t) (some >> 8),
                                 (uint8_t) (~some & 255), (uint8_t) (~some >> 8 & 255) };
        put(&z, head, 5);
        put(&z, data + at, some);
        at += some;
    }
    for (size_t i = 0; i < size; i++) {
        a = (a + data[i]) % 65521;
        b = (b + a) % 65521;
    }
    put_be32(&z, b << 16 | a);
    chunk(m, "IDAT", z.bytes, z.size);
}

static inline void png_start(made *m, uint32_t width, uint32_t height, int depth, int kind,
                             int lace)
{
    made *h = calloc(1, sizeof *h);
    CHECK(h != NULL);
    m->size = 0;
    put(m, "\x89PNG\r\n\x1a\n", 8);
    put_be32(h, width);
    put_be32(h, height);
    const uint8_t rest[] = { (uint8_t) depth, (uint8_t) kind, 0, 0, (uint8_t) lace };
    put(h, rest, 5);
    chunk(m, "IHDR", h->bytes, h->size);
    free(h);
}

/* A sample that depends on all of its place. */
static inline uint32_t sample(uint32_t x, uint32_t y, uint32_t c, int depth)
{
    uint32_t v = (x * 73856093u) ^ (y * 19349663u) ^ (c * 83492791u);
    v = (v ^ v >> 13) * 0x5bd1e995u;
    return (v ^ v >> 15) & ((1u << depth) - 1);
}

/* One pass of filtered rows, filter None, of texels x0, x0 + dx, ... */
static inline size_t pass_rows(uint8_t *dst, uint32_t w, uint32_t h, int depth, uint32_t channels,
                               const uint32_t pass[4])
{
    size_t n = 0;
    for (uint32_t y = pass[1]; y < h && pass[0] < w; y += pass[3]) {
        dst[n++] = 0;
        uint32_t bits = 0;
        int have = 0;
        for (uint32_t x = pass[0]; x < w; x += pass[2]) {
            for (uint32_t c = 0; c < channels; c++) {
                bits = bits << depth | sample(x, y, c, depth);
                for (have += depth; have >= 8; have -= 8)
                    dst[n++] = (uint8_t) (bits >> (have - 8) & 255);
            }
        }
        if (have > 0)
            dst[n++] = (uint8_t) (bits << (8 - have) & 255);
    }
    return n;
}

/* Reads a file of fewer than `most` bytes; returns how many. */
static inline size_t load_file(const char *path, uint8_t *to, size_t most)
{
    FILE *f = fopen(path, "rb");
    CHECK(f != NULL);
    const size_t size = fread(to, 1, most, f);
    fclose(f);
    CHECK(size < most);
    return size;
}

#endif
