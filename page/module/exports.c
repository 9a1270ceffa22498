// SPDX-License-Identifier: MIT
/*
 * exports.c - what the page calls besides the program: a texture to look at
 *
 * Everything else the page does is a run of `ntp`.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <libntp.h>
#include <ntpio.h>

#define EXPORT(name) __attribute__((export_name(#name)))

typedef struct texture {
    void *samples; /* by rows, without gaps */
    uint32_t width, height, channels, sample_bytes;
    uint32_t drawn_width, drawn_height;
    float *means;      /* of the samples of each drawn pixel, in 0..1 */
    uint8_t *heatmap;  /* RGBA, at the drawn size; NULL where there is no memory, or no vector */
    uint32_t *columns; /* of texels in each drawn pixel */
} texture;

typedef struct span {
    uint32_t from, to;
} span;

/* The texels that a drawn pixel shows: one or more, as no more pixels are drawn than there are. */
static span span_of(uint32_t pixel, uint32_t drawn, uint32_t texels)
{
    return (span) { (uint32_t) ((uint64_t) pixel * texels / drawn),
                    (uint32_t) ((uint64_t) (pixel + 1) * texels / drawn) };
}

static uint32_t drawn_side(uint32_t side, uint32_t longest, uint32_t most)
{
    if (longest <= most)
        return side;
    const uint64_t drawn = ((uint64_t) side * most + longest / 2) / longest;
    return drawn > 0 ? (uint32_t) drawn : 1;
}

static void add_levels(float *sums, const void *row, size_t count, uint32_t bytes)
{
    if (bytes == 1)
        for (size_t i = 0; i < count; i++)
            sums[i] += (float) ((const uint8_t *) row)[i];
    else if (bytes == 2)
        for (size_t i = 0; i < count; i++)
            sums[i] += (float) ((const uint16_t *) row)[i];
    else
        for (size_t i = 0; i < count; i++)
            sums[i] += ((const float *) row)[i];
}

/* Sums of whole columns become those of drawn pixels, in place, then means in 0..1. */
static void narrow(float *sums, const texture *t, uint32_t channels, float share)
{
    float *to = sums;
    const float *from = sums;

    for (uint32_t x = 0; x < t->drawn_width; x++, to += channels) {
        const uint32_t texels = t->columns[x];
        for (uint32_t c = 0; c < channels; c++) {
            float sum = 0;
            for (uint32_t u = 0; u < texels; u++)
                sum += from[u * channels + c];
            to[c] = sum * share / (float) texels;
        }
        from += texels * channels;
    }
}

/* The means of `count` rows are those of one drawn row; `means` has room for a whole row. */
static void mean_of_rows(float *means, const texture *t, const void *rows, uint32_t count,
                         uint32_t channels, uint32_t bytes)
{
    const size_t row = (size_t) t->width * channels;
    const float most = bytes == 1 ? 255 : bytes == 2 ? 65535 : 1;

    memset(means, 0, sizeof *means * row);
    for (uint32_t y = 0; y < count; y++)
        add_levels(means, (const uint8_t *) rows + y * row * bytes, row, bytes);
    narrow(means, t, channels, 1 / (most * (float) count));
}

static void *rows_from(const texture *t, uint32_t y)
{
    return (uint8_t *) t->samples + (size_t) y * t->width * t->channels * t->sample_bytes;
}

static bool shrink(texture *t)
{
    const size_t row = (size_t) t->drawn_width * t->channels;
    float *sums = malloc(sizeof *sums * t->width * t->channels);

    t->means = malloc(sizeof *t->means * row * t->drawn_height);
    t->columns = malloc(sizeof *t->columns * t->drawn_width);
    if (sums == NULL || t->means == NULL || t->columns == NULL)
        return false;
    for (uint32_t x = 0; x < t->drawn_width; x++) {
        const span texels = span_of(x, t->drawn_width, t->width);
        t->columns[x] = texels.to - texels.from;
    }
    for (uint32_t y = 0; y < t->drawn_height; y++) {
        const span rows = span_of(y, t->drawn_height, t->height);
        mean_of_rows(sums, t, rows_from(t, rows.from), rows.to - rows.from, t->channels,
                     t->sample_bytes);
        memcpy(t->means + y * row, sums, sizeof *sums * row);
    }
    return true;
}

static bool heat_rows(uint8_t *colors, const texture *t, span rows, ntp_encoding encoding)
{
    const int32_t width = (int32_t) t->width, height = (int32_t) (rows.to - rows.from);
    const ntp_type type = t->sample_bytes == 1   ? NTP_TYPE_U8
                          : t->sample_bytes == 2 ? NTP_TYPE_U16
                                                 : NTP_TYPE_F32;
    ntp_image view =
        ntp_image_packed(rows_from(t, rows.from), width, height, (int32_t) t->channels, type);
    ntp_image to = ntp_image_packed(colors, width, height, 3, NTP_TYPE_U8);

    view.encoding = encoding;
    to.encoding = NTP_ENCODING_HEIGHT;
    const ntp_const_image from = ntp_image_as_const(&view);
    return ntp_heatmap(&to, &from, NTP_PALETTE_REFERENCE, 0, NULL) == NTP_OK;
}

/* As `ntp heatmap` paints it, then drawn smaller. */
static void make_heatmap(texture *t, ntp_encoding encoding)
{
    const uint32_t tallest = t->height / t->drawn_height + 1;
    uint8_t *colors = malloc((size_t) 3 * t->width * tallest);
    float *means = malloc(sizeof *means * 3 * t->width);
    uint8_t *to = malloc((size_t) 4 * t->drawn_width * t->drawn_height);
    bool done = colors != NULL && means != NULL && to != NULL;

    t->heatmap = to;
    for (uint32_t y = 0; done && y < t->drawn_height; y++) {
        const span rows = span_of(y, t->drawn_height, t->height);
        done = heat_rows(colors, t, rows, encoding);
        if (!done)
            break;
        mean_of_rows(means, t, colors, rows.to - rows.from, 3, 1);
        for (uint32_t x = 0; x < t->drawn_width; x++, to += 4) {
            for (uint32_t c = 0; c < 3; c++)
                to[c] = (uint8_t) (255 * means[3 * x + c] + 0.5f);
            to[3] = 255;
        }
    }
    if (!done)
        t->heatmap = NULL;
}

static bool read_samples(texture *t, ntpio_reader *reader, uint32_t most_side)
{
    const ntpio_info *info = ntpio_reader_info(reader);
    const uint32_t longest = info->width > info->height ? info->width : info->height;
    const size_t row = (size_t) info->width * (size_t) info->channels * (size_t) info->sample_bytes;
    ntpio_error failure;

    *t = (texture) { .samples = malloc(row * info->height),
                     .width = info->width,
                     .height = info->height,
                     .channels = (uint32_t) info->channels,
                     .sample_bytes = (uint32_t) info->sample_bytes,
                     .drawn_width = drawn_side(info->width, longest, most_side),
                     .drawn_height = drawn_side(info->height, longest, most_side) };
    return t->samples != NULL &&
           ntpio_read_rows(reader, t->samples, (ptrdiff_t) row, info->height, &failure);
}

/*
 * Reads the texture that lies in the directory as "texture", and makes its heatmap as `ntp heatmap`
 * does; encoding: an ntp_encoding, or -1 for none.  Neither side is drawn longer than most_side.
 * NULL where `ntp check` says why.  The module ends after it, so nothing is freed.
 */
EXPORT(readTexture)
const texture *page_read_texture(double most_texels, uint32_t most_side, int32_t encoding);

const texture *page_read_texture(double most_texels, uint32_t most_side, int32_t encoding)
{
    static texture read;
    const ntpio_limits limits = { .max_texels = (uint64_t) most_texels };
    ntpio_error failure;
    ntpio_reader *reader = ntpio_open("texture", &limits, &failure);
    const bool done = reader != NULL && read_samples(&read, reader, most_side) && shrink(&read);

    ntpio_close(reader);
    if (done && encoding >= 0)
        make_heatmap(&read, (ntp_encoding) encoding);
    return done ? &read : NULL;
}
