/* SPDX-License-Identifier: MIT */
/*
 * test_jpeg.c - JPEG made by the library's compressor, read as its plain decompressor reads it;
 * header fields, and damage
 */
#include <stdio.h>

#include <jpeglib.h>

#include "made.h"
#include "ntpio.h"

enum { WIDTH = 37, HEIGHT = 21, CHANNELS_MAX = 4 };

typedef struct shape {
    int channels; /* 1 gray, 3 color, 4 CMYK */
    int quality;
    bool subsampled, progressive;
} shape;

typedef struct jpeg_file {
    unsigned char *bytes;
    unsigned long size;
} jpeg_file;

static uint8_t original[WIDTH * HEIGHT * CHANNELS_MAX];
static uint8_t rows[WIDTH * HEIGHT * CHANNELS_MAX], wanted[WIDTH * HEIGHT * CHANNELS_MAX];

static jpeg_file compress(shape s)
{
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr errors;
    jpeg_file file = { NULL, 0 };
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH; x++)
            for (uint32_t c = 0; c < (uint32_t) s.channels; c++)
                original[(y * WIDTH + x) * (uint32_t) s.channels + c] =
                    (uint8_t) (40 + 3 * x + (c + 1) * y + sample(x, y, c, 3));
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &file.bytes, &file.size);
    jpeg.image_width = WIDTH;
    jpeg.image_height = HEIGHT;
    jpeg.input_components = s.channels;
    jpeg.in_color_space = s.channels == 1 ? JCS_GRAYSCALE : s.channels == 3 ? JCS_RGB : JCS_CMYK;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, s.quality, TRUE);
    if (s.channels == 3 && !s.subsampled)
        jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
    if (s.progressive)
        jpeg_simple_progression(&jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    for (uint32_t y = 0; y < HEIGHT; y++) {
        JSAMPROW row = original + y * WIDTH * (uint32_t) s.channels;
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    return file;
}

static void decompress(const jpeg_file *file)
{
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr errors;
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, file->bytes, file->size);
    jpeg_read_header(&jpeg, TRUE);
    jpeg_start_decompress(&jpeg);
    while (jpeg.output_scanline < jpeg.output_height) {
        JSAMPROW row = wanted + jpeg.output_scanline * WIDTH * (uint32_t) jpeg.output_components;
        jpeg_read_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_decompress(&jpeg);
    jpeg_destroy_decompress(&jpeg);
}

/* Into rows; NTPIO_OK, or the status of the error. */
static ntpio_status read_all(const uint8_t *bytes, size_t size, const ntpio_limits *limits,
                             ntpio_info *info, ntpio_error *error)
{
    uint8_t *copy = malloc(size + (size == 0)); /* of the exact size, for the sanitizers */
    CHECK(copy != NULL);
    memcpy(copy, bytes, size);
    *error = (ntpio_error) { NTPIO_OK, "" };
    ntpio_reader *reader = ntpio_open_memory(copy, size, "x.jpg", limits, error);
    bool good = reader != NULL;
    if (good) {
        *info = *ntpio_reader_info(reader);
        const size_t row = (size_t) info->width * (size_t) info->channels;
        uint8_t *image = malloc(row * info->height);
        CHECK(image != NULL);
        good = ntpio_read_rows(reader, image, (ptrdiff_t) row, info->height, error) &&
               ntpio_read_end(reader, error);
        if (good && row * info->height <= sizeof rows)
            memcpy(rows, image, row * info->height);
        free(image);
    }
    ntpio_close(reader);
    free(copy);
    CHECK(good || (error->status != NTPIO_OK && strncmp(error->message, "x.jpg: ", 7) == 0));
    return good ? NTPIO_OK : error->status;
}

static void check_damage(const jpeg_file *file)
{
    static const ntpio_limits few = { .max_side = 2048,
                                      .max_texels = 1 << 18,
                                      .max_memory = 1 << 22 };
    ntpio_info info;
    ntpio_error error;
    for (size_t size = 0; size < file->size; size++) {
        const ntpio_status status = read_all(file->bytes, size, NULL, &info, &error);
        CHECK(status == NTPIO_ERR_CORRUPT || (size < 4 && status == NTPIO_ERR_FORMAT));
        CHECK(size < 4 || strstr(error.message, "truncated") != NULL);
    }
    /* A file that ends within the texels: the library only warns, and would invent the rest. */
    const size_t middle = file->size - file->size / 8;
    unsigned char two[2];
    memcpy(two, file->bytes + middle, 2);
    memcpy(file->bytes + middle, "\xff\xd9", 2);
    CHECK(read_all(file->bytes, file->size, NULL, &info, &error) == NTPIO_ERR_CORRUPT);
    memcpy(file->bytes + middle, two, 2);
    for (size_t at = 0; at < file->size; at++) {
        file->bytes[at] ^= (uint8_t) (1u << at % 8);
        read_all(file->bytes, file->size, &few, &info, &error);
        file->bytes[at] ^= (uint8_t) (1u << at % 8);
    }
}

static void check_shape(shape s)
{
    jpeg_file file = compress(s);
    ntpio_info info;
    ntpio_error error;
    const size_t size = WIDTH * HEIGHT * (size_t) s.channels;
    CHECK(read_all(file.bytes, file.size, NULL, &info, &error) == NTPIO_OK);
    decompress(&file);
    CHECK(memcmp(rows, wanted, size) == 0);
    for (size_t i = 0; i < size; i++) /* and upright, in the order RGB */
        CHECK(s.quality < 90 || abs(rows[i] - original[i]) < 20);
    CHECK(info.format == NTPIO_JPEG && info.width == WIDTH && info.height == HEIGHT);
    CHECK(info.channels == s.channels && info.sample_bytes == 1 && info.bit_depth == 8);
    CHECK(info.lossy && !info.alpha && !info.palette && info.streams == !s.progressive);
    CHECK(info.jpeg_quality == s.quality);
    CHECK(info.jpeg_subsampled == (s.channels == 3 && s.subsampled));
    check_damage(&file);
    /* Bytes after the image are ignored. */
    static const uint8_t junk[] = { 0xff, 0xd8, 'j', 'u', 'n', 'k', 0xff };
    uint8_t *longer = malloc(file.size + sizeof junk);
    CHECK(longer != NULL);
    memcpy(longer, file.bytes, file.size);
    memcpy(longer + file.size, junk, sizeof junk);
    CHECK(read_all(longer, file.size + sizeof junk, NULL, &info, &error) == NTPIO_OK);
    free(longer);
    free(file.bytes);
}

static void check_refusals(void)
{
    const jpeg_file cmyk = compress((shape) { 4, 90, false, false });
    const jpeg_file progressive = compress((shape) { 3, 90, false, true });
    ntpio_info info;
    ntpio_error error;
    CHECK(read_all(cmyk.bytes, cmyk.size, NULL, &info, &error) == NTPIO_ERR_FORMAT);
    CHECK(strstr(error.message, "CMYK") != NULL);
    const ntpio_limits memory = { .max_memory = 1000 }, side = { .max_side = 30 },
                       texels = { .max_texels = 700 };
    const jpeg_file *p = &progressive;
    CHECK(read_all(p->bytes, p->size, &memory, &info, &error) == NTPIO_ERR_LIMIT);
    CHECK(read_all(p->bytes, p->size, &side, &info, &error) == NTPIO_ERR_LIMIT);
    CHECK(read_all(p->bytes, p->size, &texels, &info, &error) == NTPIO_ERR_LIMIT);
    free(cmyk.bytes);
    free(progressive.bytes);
}

/* Where the frame header (SOF0) of a baseline file is. */
static size_t frame_of(const jpeg_file *file)
{
    size_t at = 2;
    while (file->bytes[at + 1] != 0xc0)
        at += 2 + ((size_t) file->bytes[at + 2] << 8 | file->bytes[at + 3]);
    CHECK(at < file->size && file->bytes[at] == 0xff);
    return at;
}

/* Headers that are unusual but not damaged: 12 bits, lossless, a profile. */
static void check_headers(void)
{
    jpeg_file file = compress((shape) { 3, 90, false, false });
    static const char profile[] = "\xff\xe2\0\x12"
                                  "ICC_PROFILE\0\1\1x";
    const size_t frame = frame_of(&file), size = sizeof profile;
    ntpio_info info;
    ntpio_error error;
    CHECK(read_all(file.bytes, file.size, NULL, &info, &error) == NTPIO_OK && !info.has_iccp);
    uint8_t *with = malloc(file.size + size);
    CHECK(with != NULL);
    memcpy(with, file.bytes, frame);
    memcpy(with + frame, profile, size);
    memcpy(with + frame + size, file.bytes + frame, file.size - frame);
    CHECK(read_all(with, file.size + size, NULL, &info, &error) == NTPIO_OK && info.has_iccp);
    free(with);
    file.bytes[frame + 4] = 12;
    CHECK(read_all(file.bytes, file.size, NULL, &info, &error) == NTPIO_ERR_FORMAT);
    file.bytes[frame + 4] = 8;
    file.bytes[frame + 1] = 0xc3;
    CHECK(read_all(file.bytes, file.size, NULL, &info, &error) == NTPIO_ERR_FORMAT);
    free(file.bytes);
}

int main(void)
{
    check_headers();
    for (int progressive = 0; progressive < 2; progressive++) {
        check_shape((shape) { 1, 92, false, progressive });
        check_shape((shape) { 3, 95, false, progressive });
        check_shape((shape) { 3, 60, true, progressive });
    }
    for (int quality = 1; quality <= 100; quality++) {
        jpeg_file file = compress((shape) { 1, quality, false, false });
        ntpio_info info;
        ntpio_error error;
        CHECK(read_all(file.bytes, file.size, NULL, &info, &error) == NTPIO_OK);
        CHECK(info.jpeg_quality == quality);
        free(file.bytes);
    }
    check_refusals();
    return 0;
}
