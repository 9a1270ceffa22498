/* SPDX-License-Identifier: MIT */
/* pictures.c - pictures made without rounding, and the hash of what comes of them. */
#include "sums.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void need(bool holds, const char *what)
{
    if (holds)
        return;
    fprintf(stderr, "sums: %s: %s\n", current, what);
    exit(1);
}

/* ---------------------------------------------------------------------------- hashing */

/* FNV-1a of 64-bit numbers, byte by byte from the lowest. */
uint64_t hash_number(uint64_t hash, uint64_t number)
{
    for (int i = 0; i < 8; i++) {
        hash ^= (number >> (8 * i)) & 255;
        hash *= 0x100000001b3u;
    }
    return hash;
}

uint64_t hash_double(uint64_t hash, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return hash_number(hash, bits);
}

/* Samples of a packed picture. */
static uint64_t hash_samples(uint64_t hash, const void *data, size_t count, ntp_type type)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        if (type == NTP_TYPE_U8)
            bits = ((const uint8_t *) data)[i];
        else if (type == NTP_TYPE_U16)
            bits = ((const uint16_t *) data)[i];
        else
            memcpy(&bits, (const float *) data + i, sizeof bits);
        hash = (hash ^ bits) * 0x100000001b3u;
    }
    return hash;
}

uint64_t hash_image(uint64_t hash, const ntp_image *image)
{
    const size_t samples =
        (size_t) image->width * (size_t) image->height * (size_t) image->channels;
    return hash_samples(hash, image->data, samples, image->type);
}

/* --------------------------------------------------------------------------- pictures */

static uint32_t draw(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

void *reserve(size_t size)
{
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64 + 64);
    need(memory != NULL, "no memory");
    memset(memory, 0, size);
    return memory;
}

static const size_t sample_size[] = { 1, 2, 4 };

ntp_image picture(int32_t width, int32_t height, int32_t channels, ntp_type type,
                  ntp_encoding encoding)
{
    const size_t samples = (size_t) width * (size_t) height * (size_t) channels;
    ntp_image image =
        ntp_image_packed(reserve(samples * sample_size[type]), width, height, channels, type);
    image.encoding = encoding;
    return image;
}

/* Sums of moving means, 0..1. */
ntp_image make_heights(int width, int height, ntp_type type)
{
    static uint32_t noise[WIDE * HIGH], sums[WIDE * HIGH];
    ntp_image image = picture(width, height, 1, type, NTP_ENCODING_HEIGHT);
    const int texels = width * height;
    uint32_t state = 7;
    for (int i = 0; i < texels; i++)
        noise[i] = draw(&state) >> 8;
    for (int pass = 0; pass < 3; pass++) {
        for (int y = 0; y < height; y++) {
            for (int x = 0; x < width; x++) {
                uint64_t sum = 0;
                for (int dy = -2; dy <= 2; dy++)
                    for (int dx = -2; dx <= 2; dx++)
                        sum += noise[(y + dy + height) % height * width + (x + dx + width) % width];
                sums[y * width + x] = (uint32_t) (sum / 25);
            }
        }
        memcpy(noise, sums, sizeof noise);
    }
    for (int i = 0; i < texels; i++) {
        const uint32_t level = noise[i] & 0xffff;
        if (type == NTP_TYPE_U8)
            ((uint8_t *) image.data)[i] = (uint8_t) (level >> 6 & 255);
        else if (type == NTP_TYPE_U16)
            ((uint16_t *) image.data)[i] = (uint16_t) level;
        else
            ((float *) image.data)[i] = (float) level / 65536;
    }
    return image;
}

ntp_image make_normals(int width, int height, ntp_type type, ntp_encoding encoding,
                       int32_t channels)
{
    ntp_image heights = make_heights(width, height, NTP_TYPE_U16);
    ntp_image image = picture(width, height, channels, type, encoding);
    const ntp_const_image src = ntp_image_as_const(&heights);
    const ntp_normals_options how = { .scale = 40, .kernel = NTP_KERNEL_SOBEL3 };
    OK(ntp_normals_from_height(&image, &src, &how, NULL, NULL));
    free(heights.data);
    return image;
}

ntp_image make_damaged(int width, int height, ntp_type type, ntp_encoding encoding,
                       int32_t channels)
{
    ntp_image image = make_normals(width, height, type, encoding, channels);
    uint32_t state = 99;
    for (int i = 0; i < width * height * channels; i++) {
        const uint32_t change = draw(&state) % 23;
        if (type == NTP_TYPE_U8)
            ((uint8_t *) image.data)[i] ^= change == 0 ? 5 : 0;
        else if (type == NTP_TYPE_U16)
            ((uint16_t *) image.data)[i] ^= change == 0 ? 700 : 0;
        else if (change == 0)
            ((float *) image.data)[i] *= 0.75f;
    }
    memset(image.data, 0, (size_t) (20 * channels) * sample_size[type]);
    return image;
}
