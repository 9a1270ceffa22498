/* SPDX-License-Identifier: MIT */
/*
 * rgb_avx2.h - packed RGB to planes and back, flips and turns of it, with AVX2
 */
#ifndef NTP_RGB_AVX2_H
#define NTP_RGB_AVX2_H

#include "base/view.h"

/* Three planes of n <= NTP__BLOCK packed pixels of 8 bit, or 16 (deep); values of planes after the
 * first n change. */
void ntp__unpack_rgb_avx2(ntp__block *block, const void *src, int32_t n, bool deep);

/* The other way round. */
void ntp__pack_rgb_avx2(void *dst, const ntp__block *block, int32_t n, bool deep);

/*
 * x, y, z and 1 of packed pixels, as numerators over M: int16_t, or floats of 16 bit; `to` has room
 * for seven pixels more.  negative: a z is below 0.  False where red of a pixel is 0 or M: it may be
 * black or white.
 */
bool ntp__place_rgb_avx2(void *to, bool *negative, const void *src, int32_t n, bool deep,
                         bool zzero);

/* Packed pixels with red and green exchanged if `swap`, and then M - r and M - g if inverted; black
 * and white ones stay.  dst is not src. */
void ntp__turn_rgb_avx2(void *dst, const void *src, int32_t n, bool deep, bool swap, bool invert_r,
                        bool invert_g);

/* The same without an exchange, faster where few pixels are black or white; and of pixels with alpha, of which
 * those of alpha 0 stay, too. */
void ntp__mirror_rgb_avx2(void *dst, const void *src, int32_t n, bool deep, bool invert_r,
                          bool invert_g);
void ntp__mirror_rgba_avx2(void *dst, const void *src, int32_t n, bool deep, bool invert_r,
                           bool invert_g);

/* Pixels of 3, 4, 6 or 8 bytes in the other order; 16 bytes after those of dst change. */
void ntp__reverse_avx2(void *dst, const void *src, int32_t n, int32_t size);

/*
 * Columns of packed pixels become rows, with red and green exchanged, and then M - r and M - g if
 * inverted; black and white pixels stay.  There are at least 8 rows and 8 columns in src.  `step`
 * bytes lie between rows of src, `pitch` between those of dst; 4 bytes after a row of dst change.
 */
void ntp__turn_tile_avx2(uint8_t *dst, ptrdiff_t pitch, const void *src, ptrdiff_t step,
                         int32_t rows, int32_t columns, bool deep, bool invert_r, bool invert_g);

/* dst = src, packed pixels, with M - g for g.  Black and white pixels stay as they are, if that is
 * asked for.  dst may be src. */
void ntp__flip_rgb_avx2(void *dst, const void *src, int32_t n, bool deep, bool keep_black,
                        bool keep_white);

#endif
