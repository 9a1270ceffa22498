/* SPDX-License-Identifier: MIT */
/*
 * blocks.h - decoders of block compression: one block is 4 x 4 texels
 *
 * Palettes are interpolated exactly, as GPUs do, and each value is rounded once: thirds of 5 and 6
 * bit colors to 8 bit, sevenths and fifths of 8-bit ends to 16 bit (BC4, BC5) or 8 bit (the alpha
 * of BC3).  BC7 is defined in integers.
 */
#ifndef NTPIO_BLOCKS_H
#define NTPIO_BLOCKS_H

#include <stdbool.h>
#include <stdint.h>

enum { NTPIO__SIDE = 4, NTPIO__BLOCK_TEXELS = 16 };

/* rgba: 16 texels, rows from the top.  bc1: with black transparent texels (3 colors) as BC1 has. */
void ntpio__bc1(const uint8_t *block, uint8_t *rgba);
void ntpio__bc2(const uint8_t *block, uint8_t *rgba);
void ntpio__bc3(const uint8_t *block, uint8_t *rgba);
void ntpio__bc7(const uint8_t *block, uint8_t *rgba);

/* One channel, to every `step`th number.  Signed values -1..1 become 0..65535; 0 is 32768. */
void ntpio__bc4(const uint8_t *block, bool is_signed, uint16_t *levels, int step);

#endif
