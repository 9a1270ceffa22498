/* SPDX-License-Identifier: MIT */
/*
 * like_program.c - the settings that give the same picture as other programs
 *
 * The kernels of other programs have some gain on a ramp.  Ours have gain 1, so that gain goes into
 * the scale, as a fraction that is rounded once.
 */
#include "from_height/gradient.h"

#include <string.h>

typedef struct likeness {
    const char *name;
    ntp_kernel kernel;
    int32_t gain, over; /* scale = value * gain / over */
    ntp_border border;
    ntp_y y;
    ntp_height_source source;
    bool swap_green_blue;
} likeness;

#define GIMP(NAME, KERNEL, GAIN, OVER)                                                             \
    { "gimp-normalmap:" NAME,      KERNEL, GAIN, OVER, NTP_BORDER_CLAMP, NTP_Y_DOWN,               \
      NTP_HEIGHT_SOURCE_LUMA_GIMP, false }

static const likeness likenesses[] = {
    { "reference", NTP_KERNEL_CENTRAL, 2, 1, NTP_BORDER_WRAP, NTP_Y_UP, NTP_HEIGHT_SOURCE_RED,
      false },
    { "eberly", NTP_KERNEL_CENTRAL, -2, 1, NTP_BORDER_WRAP, NTP_Y_DOWN,
      NTP_HEIGHT_SOURCE_LUMA_EBERLY, false },
    { "zima", NTP_KERNEL_SOBEL3, -8, 1, NTP_BORDER_WRAP, NTP_Y_DOWN, NTP_HEIGHT_SOURCE_RED, true },
    { "zima-corrected", NTP_KERNEL_SOBEL3, 8, 1, NTP_BORDER_WRAP, NTP_Y_DOWN, NTP_HEIGHT_SOURCE_RED,
      true },
    { "gegl", NTP_KERNEL_CENTRAL, 1, 1, NTP_BORDER_CLAMP, NTP_Y_DOWN, NTP_HEIGHT_SOURCE_LUMA,
      false },
    GIMP("4sample", NTP_KERNEL_CENTRAL, 1, 1),
    GIMP("sobel3", NTP_KERNEL_SOBEL3, 8, 1),
    GIMP("sobel5", NTP_KERNEL_SOBEL5, 128, 1),
    GIMP("prewitt3", NTP_KERNEL_PREWITT3, 6, 1),
    GIMP("prewitt5", NTP_KERNEL_PREWITT5, 40, 1),
    GIMP("3x3", NTP_KERNEL_PREWITT3, 1, 1),
    GIMP("5x5", NTP_KERNEL_GIMP5, 36, 29),
    GIMP("7x7", NTP_KERNEL_GIMP7, 124, 69),
    GIMP("9x9", NTP_KERNEL_GIMP9, 170, 77),
};

/* value * gain / over, rounded once. */
static double scaled(double value, int32_t gain, int32_t over)
{
    ntp__scaled s = ntp__scaled_from(value);
    uint64_t times = (uint64_t) (gain < 0 ? -gain : gain), divisor = (uint64_t) over;
    uint64_t product = s.mantissa * times, rest = product % divisor; /* 53 + 8 bits */
    uint64_t quotient = product / divisor;
    if (product == 0)
        return 0;
    while (quotient < (uint64_t) 1 << 60) {
        rest *= 2;
        quotient = 2 * quotient + (rest >= divisor);
        rest = rest >= divisor ? rest - divisor : rest;
        s.exponent--;
    }
    /* The last bit is far below those of a double, so it can stand for all bits that follow. */
    ntp__wide wide;
    ntp__wide_set(&wide, quotient | (rest != 0));
    double size = ntp__wide_to_double(&wide, s.exponent);
    return s.negative != (gain < 0) ? -size : size;
}

ntp_status ntp_normals_like(ntp_peer *peer, const char *name, double value)
{
    if (peer == NULL || name == NULL || !(value - value == 0))
        return NTP_ERR_ARGUMENT;
    for (size_t i = 0; i < sizeof likenesses / sizeof likenesses[0]; i++) {
        const likeness *l = &likenesses[i];
        if (strcmp(l->name, name) != 0)
            continue;
        memset(peer, 0, sizeof *peer);
        peer->options.scale = scaled(value, l->gain, l->over);
        peer->options.kernel = l->kernel;
        peer->options.border_x = l->border;
        peer->options.border_y = l->border;
        peer->options.source = l->source;
        peer->y = l->y;
        peer->swap_green_blue = l->swap_green_blue;
        return NTP_OK;
    }
    return NTP_ERR_ARGUMENT;
}
