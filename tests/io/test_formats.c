/* SPDX-License-Identifier: MIT */
/*
 * test_formats.c - every kind of PNG, TGA and PFM, made by hand, read back sample by sample;
 * then the same files cut at each byte and with each byte flipped
 */
#include <math.h>

#include "made.h"
#include "ntpio.h"

static made file;
static uint8_t raw[1 << 17], rows[1 << 17];
static ntpio_error error;

/* 1: read whole, 0: refused with a message */
static int read_all(const uint8_t *bytes, size_t size, const char *name, ntpio_info *info)
{
    /* Exactly sized, so that AddressSanitizer sees the end. */
    uint8_t *copy = malloc(size + (size == 0));
    CHECK(copy != NULL);
    memcpy(copy, bytes, size);
    const ntpio_limits limits = { .max_side = 4096, .max_texels = 1 << 14, .max_memory = 1 << 20 };
    memset(&error, 0, sizeof error);
    ntpio_reader *reader = ntpio_open_memory(copy, size, name, &limits, &error);
    bool done = reader != NULL;
    if (done) {
        *info = *ntpio_reader_info(reader);
        const size_t row = (size_t) info->width * (size_t) (info->channels * info->sample_bytes);
        uint8_t *image = malloc(row * info->height);
        CHECK(image != NULL);
        done = ntpio_read_rows(reader, image, (ptrdiff_t) row, info->height, &error) &&
               ntpio_read_end(reader, &error);
        if (done && row * info->height <= sizeof rows)
            memcpy(rows, image, row * info->height);
        free(image);
    }
    ntpio_close(reader);
    free(copy);
    CHECK(done || (error.status != NTPIO_OK && strstr(error.message, ": ") != NULL));
    return done;
}

static void damage(const char *name)
{
    ntpio_info info;
    static made cut;
    for (size_t size = 0; size < file.size; size++)
        read_all(file.bytes, size, name, &info);
    for (size_t at = 0; at < file.size; at++) {
        cut = file;
        cut.bytes[at] ^= (uint8_t) (1u << at % 8);
        read_all(cut.bytes, cut.size, name, &info);
        cut.bytes[at] = 255;
        read_all(cut.bytes, cut.size, name, &info);
    }
}

static uint32_t delivered(const ntpio_info *info, uint32_t x, uint32_t y, uint32_t c)
{
    const size_t at = ((size_t) y * info->width + x) * (size_t) info->channels + c;
    uint16_t wide;
    memcpy(&wide, rows + at * 2 * (info->sample_bytes == 2), 2);
    return info->sample_bytes == 2 ? wide : rows[at];
}

static void one_png(int depth, int kind, int lace, bool transparent)
{
    static const uint32_t adam7[7][4] = { { 0, 0, 8, 8 }, { 4, 0, 8, 8 }, { 0, 4, 4, 8 },
                                          { 2, 0, 4, 4 }, { 0, 2, 2, 4 }, { 1, 0, 2, 2 },
                                          { 0, 1, 1, 2 } };
    static const uint32_t whole[4] = { 0, 0, 1, 1 };
    static const uint32_t stored_channels[] = { 1, 0, 3, 1, 2, 0, 4 };
    const uint32_t w = 13, h = 11, stored = stored_channels[kind];
    png_start(&file, w, h, depth, kind, lace);
    uint8_t palette[768], alpha[256], key[6];
    for (uint32_t i = 0; i < 256; i++) {
        for (uint32_t c = 0; c < 3; c++)
            palette[i * 3 + c] = (uint8_t) sample(i, 7, c, 8);
        alpha[i] = (uint8_t) sample(i, 9, 3, 8);
    }
    for (uint32_t c = 0; c < 3; c++) {
        const uint32_t v = sample(5, 4, c, depth);
        key[2 * c] = (uint8_t) (v >> 8);
        key[2 * c + 1] = (uint8_t) (v & 255);
    }
    if (kind == 3)
        chunk(&file, "PLTE", palette, 3u << depth);
    if (transparent)
        chunk(&file, "tRNS", kind == 3 ? alpha : key, kind == 3 ? 1u << depth : 2 * stored);
    size_t n = 0;
    for (int pass = 0; pass < (lace ? 7 : 1); pass++)
        n += pass_rows(raw + n, w, h, depth, stored, lace ? adam7[pass] : whole);
    pixels(&file, raw, n);
    chunk(&file, "IEND", "", 0);
    ntpio_info info;
    CHECK(read_all(file.bytes, file.size, "x", &info));
    const uint32_t channels = (kind == 3 ? 3 : stored) + transparent;
    CHECK(info.channels == (int32_t) channels && info.bit_depth == depth &&
          info.sample_bytes == (depth == 16 ? 2 : 1) && info.streams == !lace &&
          info.alpha == (transparent || kind >= 4) && info.palette == (kind == 3));
    const uint32_t top = (1u << depth) - 1, full = depth == 16 ? 65535 : 255;
    for (uint32_t y = 0; y < h; y++) {
        for (uint32_t x = 0; x < w; x++) {
            bool same = true;
            for (uint32_t c = 0; c < stored; c++)
                same = same && sample(x, y, c, depth) == sample(5, 4, c, depth);
            for (uint32_t c = 0; c < channels; c++) {
                const uint32_t index = sample(x, y, 0, depth);
                uint32_t want;
                if (kind == 3)
                    want = c < 3 ? palette[index * 3 + c] : alpha[index];
                else if (c < stored)
                    want = (sample(x, y, c, depth) * full + top / 2) / top;
                else
                    want = same ? 0 : full;
                CHECK(delivered(&info, x, y, c) == want);
            }
        }
    }
    damage("x.png");
}

static void every_png(void)
{
    for (int lace = 0; lace < 2; lace++) {
        for (int depth = 1; depth <= 16; depth *= 2) {
            for (int transparent = 0; transparent < 2; transparent++) {
                one_png(depth, 0, lace, transparent);
                if (depth <= 8)
                    one_png(depth, 3, lace, transparent);
                if (depth >= 8)
                    one_png(depth, 2, lace, transparent);
            }
            if (depth >= 8) {
                one_png(depth, 4, lace, false);
                one_png(depth, 6, lace, false);
            }
        }
    }
}

/* Damage that must be reported, and in these words. */
static void told(void)
{
    ntpio_info info;
    one_png(8, 2, 0, false);
    CHECK(!read_all(file.bytes, file.size - 30, "a\nb\xff.png", &info));
    CHECK(strcmp(error.message, "a\\nb\\xff.png: truncated") == 0);
    file.bytes[60] ^= 1;
    CHECK(!read_all(file.bytes, file.size, "x", &info));
    CHECK(error.status == NTPIO_ERR_CORRUPT && strstr(error.message, "checksum") != NULL);
    png_start(&file, 5000, 1, 8, 2, 0);
    chunk(&file, "IDAT", "", 0);
    CHECK(!read_all(file.bytes, file.size, "x", &info) && error.status == NTPIO_ERR_LIMIT);
    png_start(&file, 4000, 4000, 8, 2, 0);
    chunk(&file, "IDAT", "", 0);
    CHECK(!read_all(file.bytes, file.size, "x", &info) && error.status == NTPIO_ERR_LIMIT);
    static const char pointer[] = "version https://git-lfs.github.com/spec/v1\n";
    CHECK(!read_all((const uint8_t *) pointer, sizeof pointer, "x.png", &info));
    CHECK(error.status == NTPIO_ERR_FORMAT && strstr(error.message, "Git LFS") != NULL);
    CHECK(!read_all((const uint8_t *) "", 0, "x.tga", &info));
}

/* kind 1 palette, 2 color, 3 gray; origin: bits 4 and 5 of the descriptor */
static void one_tga(int kind, int bits, bool rle, int origin, int alpha_bits)
{
    const uint32_t w = 9, h = 5, bytes = kind == 1 ? 1 : (uint32_t) (bits + 7) / 8;
    const uint32_t entry = (uint32_t) (bits + 7) / 8;
    uint8_t head[18] = { 3, kind == 1, (uint8_t) (kind | (rle ? 8 : 0)) };
    if (kind == 1) {
        head[6] = 1; /* 256 entries */
        head[7] = (uint8_t) bits;
    }
    head[12] = (uint8_t) w;
    head[14] = (uint8_t) h;
    head[16] = (uint8_t) (kind == 1 ? 8 : bits);
    head[17] = (uint8_t) (origin << 4 | alpha_bits);
    file.size = 0;
    put(&file, head, 18);
    put(&file, "abc", 3);
    for (uint32_t i = 0; kind == 1 && i < 256; i++) {
        uint8_t e[4];
        for (uint32_t k = 0; k < 4; k++)
            e[k] = (uint8_t) sample(i, 77, k, 8);
        put(&file, e, entry);
    }
    for (uint32_t i = 0; i < w * h; i++) {
        uint8_t texel[4];
        for (uint32_t k = 0; k < 4; k++)
            texel[k] = (uint8_t) sample(i / 3, 1, k, 8); /* runs of three */
        if (rle && i % 3 == 0)
            put(&file, i % 2 ? "\x82" : "\x02", 1);
        if (!rle || i % 3 == 0 || i / 3 % 2 == 0)
            put(&file, texel, bytes);
    }
    ntpio_info info;
    CHECK(read_all(file.bytes, file.size, "x.tga", &info));
    CHECK(info.width == w && info.height == h && info.format == NTPIO_TGA);
    for (uint32_t y = 0; y < h; y++) {
        for (uint32_t x = 0; x < w; x++) {
            const uint32_t fy = (origin & 2) != 0 ? y : h - 1 - y;
            const uint32_t fx = (origin & 1) != 0 ? w - 1 - x : x;
            const uint32_t i = (fy * w + fx) / 3;
            uint32_t b[4];
            for (uint32_t k = 0; k < 4; k++)
                b[k] = kind == 1 ? sample(sample(i, 1, 0, 8), 77, k, 8) : sample(i, 1, k, 8);
            uint32_t want[4] = { b[2], b[1], b[0], b[3] };
            if (kind == 3) {
                want[0] = b[0];
            } else if (bits <= 16) {
                const uint32_t v = b[0] | b[1] << 8;
                for (uint32_t k = 0; k < 3; k++)
                    want[k] = (uint32_t) lround((v >> (10 - 5 * k) & 31) * 255 / 31.0);
                want[3] = v >> 15 != 0 ? 255 : 0;
            }
            for (uint32_t c = 0; c < (uint32_t) info.channels; c++)
                CHECK(delivered(&info, x, y, c) == want[c]);
        }
    }
    CHECK(info.channels == (kind == 3 ? 1 : bits == 32 || (bits == 16 && alpha_bits != 0) ? 4 : 3));
    damage("x.tga");
}

static void every_tga(void)
{
    static const int depths[] = { 15, 16, 24, 32 };
    for (int origin = 0; origin < 4; origin++) {
        for (int rle = 0; rle < 2; rle++) {
            one_tga(3, 8, rle, origin, 0);
            for (int i = 0; i < 4; i++) {
                const int alpha = depths[i] == 32 ? 8 : depths[i] == 16 ? 1 : 0;
                one_tga(2, depths[i], rle, origin, alpha);
                if (origin == 0) /* a palette is long to damage */
                    one_tga(1, depths[i], rle, origin, alpha);
            }
            one_tga(2, 16, rle, origin, 0);
            one_tga(2, 32, rle, origin, 0);
        }
    }
}

static void every_pfm(void)
{
    for (int little = 0; little < 2; little++) {
        for (int color = 0; color < 2; color++) {
            const uint32_t w = 3, h = 4, channels = color ? 3 : 1;
            const char *head = little ? "F\n3 4\n-1.0\n" : "F\n3 4\n1.0\n";
            file.size = 0;
            put(&file, "P", 1);
            put(&file, head, strlen(head));
            file.bytes[1] = color ? 'F' : 'f';
            for (uint32_t i = 0; i < w * h * channels; i++) {
                const uint32_t v = i == 2 ? 0x7fc01234u : 0x3f800000u + i * 77777;
                uint8_t b[4];
                for (uint32_t k = 0; k < 4; k++)
                    b[k] = (uint8_t) (v >> 8 * (little ? k : 3 - k) & 255);
                put(&file, b, 4);
            }
            ntpio_info info;
            CHECK(read_all(file.bytes, file.size, "x.pfm", &info));
            CHECK(info.channels == (int32_t) channels && info.sample_bytes == 4);
            for (uint32_t i = 0; i < w * h * channels; i++) {
                const uint32_t row = w * channels, from = (h - 1 - i / row) * row + i % row;
                uint32_t got;
                memcpy(&got, rows + i * 4, 4);
                CHECK(got == (from == 2 ? 0x7fc01234u : 0x3f800000u + from * 77777));
            }
            for (size_t size = 0; size < file.size; size++)
                CHECK(!read_all(file.bytes, size, "x.pfm", &info));
            damage("x.pfm");
        }
    }
}

/* Signed channels of 2 to 32 bits, alone in a DDS: round((v + top) 65535 / (2 top)), half up. */
static void signed_masks(void)
{
    for (int bits = 2; bits <= 32; bits++) {
        const int64_t top = ((int64_t) 1 << (bits - 1)) - 1;
        const int64_t values[] = { -top - 1, -top, -1, 0, 1, top / 3, top - 1, top };
        uint32_t words[32] = { 0x20534444, 124, 0x1007, 1, 8 }; /* "DDS ", ..., height, width */
        words[19] = 32;                                         /* of the format: its size, */
        words[20] = 0x80040;                                    /* signed and with masks, */
        words[22] = 32;                                         /* bits of a texel, red's mask */
        words[23] = (uint32_t) (((uint64_t) 1 << bits) - 1);
        file.size = 0;
        for (size_t i = 0; i < 32 + 8; i++) {
            const uint32_t v =
                i < 32 ? words[i] : (uint32_t) ((uint64_t) values[i - 32] & words[23]);
            const uint8_t b[] = { (uint8_t) v, (uint8_t) (v >> 8), (uint8_t) (v >> 16),
                                  (uint8_t) (v >> 24) };
            put(&file, b, 4);
        }
        ntpio_info info;
        CHECK(read_all(file.bytes, file.size, "x.dds", &info));
        CHECK(info.channels == 1 && info.sample_bytes == 2);
        for (size_t i = 0; i < 8; i++) {
            const int64_t up = values[i] < -top ? 0 : values[i] + top;
            uint16_t got;
            memcpy(&got, rows + 2 * i, 2);
            CHECK(got == (up * 2 * 65535 + 2 * top) / (4 * top));
        }
    }
}

int main(void)
{
    every_png();
    signed_masks();
    told();
    every_tga();
    every_pfm();
    return 0;
}
