/* SPDX-License-Identifier: MIT */
/*
 * reorder_tmpl.h - reorder_channels for one type of samples
 *
 * Included once for each type: REORDER is the name of the function, SAMPLE the type, ONE its 1.
 */
static void REORDER(SAMPLE *to, const SAMPLE *from, const channel_order *order, size_t pixels)
{
    const int32_t channels = order->channels, from_channels = order->from_channels;
    int8_t of[4] = { 0 };
    for (int32_t c = 0; c < channels; c++)
        of[c] = order->of[c];
    for (size_t i = 0; i < pixels; i++, from += from_channels, to += channels) {
        for (int32_t c = 0; c < channels; c++)
            to[c] = of[c] == FROM_ZERO  ? (SAMPLE) 0
                    : of[c] == FROM_ONE ? (SAMPLE) ONE
                                        : from[of[c]];
    }
}

#undef REORDER
#undef SAMPLE
#undef ONE
