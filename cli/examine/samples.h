/* SPDX-License-Identifier: MIT */
/*
 * samples.h - sizes and values of samples, and channels in another order
 */
#ifndef NTP_CLI_SAMPLES_H
#define NTP_CLI_SAMPLES_H

#include <libntp.h>
#include <stddef.h>
#include <stdint.h>

/* Bytes of a sample, and the type of samples of so many bytes. */
size_t sample_size(ntp_type type);
ntp_type sample_type(int32_t bytes);

/* Sample `channel` of the texel at `at`: integers as 0..1, floats as they are. */
double sample_value(ntp_type type, const unsigned char *at, int channel);

/* What a channel is taken from: a channel of the source, or a constant. */
enum { FROM_ZERO = -1, FROM_ONE = -2 };

/* How pixels are made of others of the same type. */
typedef struct channel_order {
    ntp_type type;
    int32_t channels, from_channels;
    const int8_t *of; /* for each channel: the one that it is taken from, or FROM_* */
} channel_order;

void reorder_channels(void *to, const void *from, const channel_order *order, size_t pixels);

#endif
