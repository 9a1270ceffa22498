/* SPDX-License-Identifier: MIT */
/*
 * samples.c - sizes and values of samples, and channels in another order
 */
#include "examine/samples.h"

#include <string.h>

size_t sample_size(ntp_type type)
{
    return type == NTP_TYPE_U8 ? 1 : type == NTP_TYPE_U16 ? 2 : 4;
}

ntp_type sample_type(int32_t bytes)
{
    return bytes == 1 ? NTP_TYPE_U8 : bytes == 2 ? NTP_TYPE_U16 : NTP_TYPE_F32;
}

double sample_value(ntp_type type, const unsigned char *at, int channel)
{
    uint16_t word;
    float v;
    switch (type) {
    case NTP_TYPE_U8:
        return at[channel] / 255.0;
    case NTP_TYPE_U16:
        memcpy(&word, at + channel * (ptrdiff_t) sizeof word, sizeof word);
        return word / 65535.0;
    default:
        memcpy(&v, at + channel * (ptrdiff_t) sizeof v, sizeof v);
        return v;
    }
}

#define REORDER reorder_8
#define SAMPLE  uint8_t
#define ONE     255
#include "examine/reorder_tmpl.h"

#define REORDER reorder_16
#define SAMPLE  uint16_t
#define ONE     65535
#include "examine/reorder_tmpl.h"

#define REORDER reorder_float
#define SAMPLE  float
#define ONE     1
#include "examine/reorder_tmpl.h"

void reorder_channels(void *to, const void *from, const channel_order *order, size_t pixels)
{
    if (order->type == NTP_TYPE_U8)
        reorder_8(to, from, order, pixels);
    else if (order->type == NTP_TYPE_U16)
        reorder_16(to, from, order, pixels);
    else
        reorder_float(to, from, order, pixels);
}
