/* SPDX-License-Identifier: MIT */
/*
 * formats.h - the decoders and encoders that open.c and writer.c choose from
 */
#ifndef NTPIO_FORMATS_H
#define NTPIO_FORMATS_H

#include <string.h>

#include "reader.h"
#include "writer.h"

extern const ntpio__decoder ntpio__png_decoder, ntpio__tga_decoder, ntpio__jpeg_decoder,
    ntpio__pfm_decoder, ntpio__dds_decoder, ntpio__ktx2_decoder, ntpio__webp_decoder,
    ntpio__exr_decoder;
extern const ntpio__encoder ntpio__png_encoder, ntpio__tga_encoder, ntpio__pfm_encoder,
    ntpio__webp_encoder, ntpio__texture_encoder;

/* Could bytes without a signature be the start of a TGA file? */
bool ntpio__tga_plausible(const uint8_t *bytes, size_t size);

/* The byte order of this machine; each format knows its own. */
static inline bool ntpio__little_endian(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

#endif
