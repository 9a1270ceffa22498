/* SPDX-License-Identifier: MIT */
/*
 * check_buffer.c - find the bad texels in a part of an image in memory
 *
 * The image is 16-bit RGBA, as an engine or a paint program holds it; only a crop of it is checked.
 * A view needs no copy: it says where the samples are.  Compiles as C and as C++.
 *
 * Build: cc check_buffer.c $(pkg-config --cflags --libs libntp)
 */
#include <libntp.h>

#include <stdio.h>
#include <string.h>

enum { WIDTH = 48, HEIGHT = 32, CHANNELS = 4 };

static uint16_t pixels[HEIGHT][WIDTH][CHANNELS];

/* Flat normals, and three wrong texels. */
static void fill(void)
{
    static const uint16_t flat[CHANNELS] = { 32768, 32768, 65535, 65535 };
    static const uint16_t too_short[CHANNELS] = { 32768, 32768, 52000, 65535 };
    static const uint16_t too_long[CHANNELS] = { 65000, 60000, 33000, 65535 };
    static const uint16_t inward[CHANNELS] = { 32768, 32768, 0, 65535 };
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            memcpy(pixels[y][x], flat, sizeof flat);
    memcpy(pixels[9][20], too_short, sizeof too_short);
    memcpy(pixels[15][21], too_long, sizeof too_long);
    memcpy(pixels[15][30], inward, sizeof inward);
}

static void describe(const ntp_const_image *view, int x, int y)
{
    ntp_texel texel;
    if (ntp_inspect(&texel, view, x, y, 0) != NTP_OK)
        return;
    printf("(%d, %d): %u %u %u, length %.4f%s%s, cleaned %u %u %u, %.2f degrees off\n", x, y,
           (unsigned) texel.stored[0], (unsigned) texel.stored[1], (unsigned) texel.stored[2],
           texel.length, texel.flags & NTP_FLAG_XY_TOO_LONG ? ", x and y too long" : "",
           texel.flags & NTP_FLAG_Z_NEGATIVE ? ", z negative" : "", (unsigned) texel.cleaned[0],
           (unsigned) texel.cleaned[1], (unsigned) texel.cleaned[2], texel.angle);
}

int main(void)
{
    fill();
    ntp_image whole = ntp_image_packed(pixels, WIDTH, HEIGHT, CHANNELS, NTP_TYPE_U16);

    /* The 32 x 16 texels from (8, 8), upside down: the last row first, a negative stride. */
    ntp_image crop = whole;
    crop.width = 32;
    crop.height = 16;
    crop.data = pixels[8 + 15][8];
    crop.row_stride = -whole.row_stride;
    ntp_const_image view = ntp_image_as_const(&crop);

    static unsigned char flags[16][32];
    ntp_image mask = ntp_image_packed(flags, 32, 16, 1, NTP_TYPE_U8);
    ntp_status status = ntp_validate(&mask, &view, 0, NULL);
    if (status != NTP_OK) {
        fprintf(stderr, "validate: %s\n", ntp_status_string(status));
        return 1;
    }
    int bad = 0;
    for (int y = 0; y < 16; y++) {
        for (int x = 0; x < 32; x++) {
            if ((flags[y][x] & NTP_FLAG_NEIGHBOR) == 0 ||
                (flags[y][x] & NTP_FLAG_Z_NEGATIVE) != 0) {
                describe(&view, x, y);
                bad++;
            }
        }
    }
    printf("%d of %d texels are bad\n", bad, 32 * 16);
    return bad == 3 ? 0 : 1;
}
