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

#include <libntp.h>
#include <ntpio.h>

#define EXPORT(name) __attribute__((export_name(#name)))

typedef struct texture {
    void *samples; /* by rows, without gaps */
    uint32_t width, height, channels, sample_bytes;
    uint8_t *heatmap; /* RGB; NULL where there is no memory, or no vector */
} texture;

static uint8_t *heatmap_of(const texture *t, ntp_encoding encoding)
{
    const int32_t width = (int32_t) t->width, height = (int32_t) t->height;
    const ntp_type type = t->sample_bytes == 1   ? NTP_TYPE_U8
                          : t->sample_bytes == 2 ? NTP_TYPE_U16
                                                 : NTP_TYPE_F32;
    ntp_image view = ntp_image_packed(t->samples, width, height, (int32_t) t->channels, type);
    uint8_t *colors = malloc((size_t) 3 * t->width * t->height);
    ntp_image to = ntp_image_packed(colors, width, height, 3, NTP_TYPE_U8);

    view.encoding = encoding;
    to.encoding = NTP_ENCODING_HEIGHT;
    const ntp_const_image from = ntp_image_as_const(&view);
    if (colors != NULL && ntp_heatmap(&to, &from, NTP_PALETTE_REFERENCE, 0, NULL) == NTP_OK)
        return colors;
    free(colors);
    return NULL;
}

/*
 * Reads the texture that lies in the directory as "texture", and makes its heatmap as `ntp heatmap`
 * does; encoding: an ntp_encoding, or -1 for none.  NULL where `ntp check` says why.
 */
EXPORT(readTexture) const texture *page_read_texture(double most_texels, int32_t encoding);

const texture *page_read_texture(double most_texels, int32_t encoding)
{
    static texture read;
    const ntpio_limits limits = { .max_texels = (uint64_t) most_texels };
    ntpio_error failure;
    ntpio_reader *reader = ntpio_open("texture", &limits, &failure);
    bool done = false;

    if (reader != NULL) {
        const ntpio_info *info = ntpio_reader_info(reader);
        const size_t row =
            (size_t) info->width * (size_t) info->channels * (size_t) info->sample_bytes;
        read = (texture) {
            malloc(row * info->height),    info->width, info->height, (uint32_t) info->channels,
            (uint32_t) info->sample_bytes, NULL
        };
        done = read.samples != NULL &&
               ntpio_read_rows(reader, read.samples, (ptrdiff_t) row, info->height, &failure);
    }
    ntpio_close(reader);
    if (done && encoding >= 0)
        read.heatmap = heatmap_of(&read, (ntp_encoding) encoding);
    return done ? &read : NULL;
}
