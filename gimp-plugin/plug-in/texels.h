/* SPDX-License-Identifier: MIT */
/*
 * texels.h - what happens to finished texels: alpha, DU/DV, channel order
 */
#ifndef NTP_PLUGIN_TEXELS_H
#define NTP_PLUGIN_TEXELS_H

#include "normals.h"

/* The part of a view that an area covers. */
ntp_image texels_crop(const ntp_image *view, const ntp_rect *area);

/* One of the samples of a view as a view of its own. */
ntp_image texels_channel(const ntp_image *view, int32_t channel);

/* Sets sample 3 by the rule (not the height's); plane: the alpha to start from, of the view's size
 * and any type, or without data: opaque. */
void texels_alpha(const ntp_image *view, alpha_rule rule, const ntp_const_image *plane);

/* Exchanges red and blue. */
void texels_swap(const ntp_image *view);

/* Stores x and y of vectors (NTP_ENCODING_VECTOR, 3 channels) in that format; other samples become 0, alpha
 * stays where the format leaves it. */
void texels_dudv(const ntp_image *view, const ntp_const_image *vectors, dudv_format format);

#endif
