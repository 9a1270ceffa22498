/* SPDX-License-Identifier: MIT */
/*
 * test_orientation.c - orientation is measured alike with and without AVX2 and AVX-512
 *
 * Images of all widths up to a stretch and some, between guard pages: packed ones of 8 bit, which have kernels of
 * their own, and those of other types and strides.  What an ntp_orientation keeps is the same to the byte.
 */
#include "guarded.h"
#include "without_avx2.h"
#include "without_avx512.h"
#include "libntp.h"

#include <string.h>

enum { WIDEST = 300, HIGH = 9, SETS = 3 /* of instructions */, SKIPPED = 77 };

/* Levels: any; of gentle slopes; of steep ones; the same with some that are black, white or clear; the ends of
 * levels alone, whose products are the greatest. */
enum { RANDOM, GENTLE, STEEPER, HOLES, ENDS, KINDS };

static int32_t level_of(int kind, int32_t channel, int32_t m, uint64_t *seed)
{
    const int32_t any = random_level(seed, m), bits = (int32_t) (random_bits(seed) % 64);
    if (kind == RANDOM || channel == 3)
        return kind != RANDOM && (kind != HOLES || bits > 3) ? m : bits < 2 ? 0 : any;
    if (kind == ENDS)
        return bits % 8 == 0 ? m / 2 : bits % 2 ? m / 100 : m - m / 100;
    return channel == 2 ? m : m / 2 + (any - m / 2) / (kind == GENTLE ? 16 : 2);
}

static void put(void *data, size_t i, ntp_type type, int32_t level)
{
    if (type == NTP_TYPE_U8)
        ((uint8_t *) data)[i] = (uint8_t) level;
    else if (type == NTP_TYPE_U16)
        ((uint16_t *) data)[i] = (uint16_t) level;
    else
        ((float *) data)[i] = (float) level / 65535;
}

static void fill(void *data, size_t texels, int32_t channels, ntp_type type, int kind,
                 uint64_t *seed)
{
    const int32_t m = type == NTP_TYPE_U8 ? 255 : 65535;
    for (size_t i = 0; i < texels; i++) {
        const bool hole = kind == HOLES && random_bits(seed) % 40 == 0, white = hole && i % 2;
        for (int32_t k = 0; k < channels; k++)
            put(data, i * (size_t) channels + (size_t) k, type,
                hole ? (white ? m : 0) : level_of(kind, k, m, seed));
    }
}

/* Of images that are `spare` channels wider than their texels, too, which are not packed. */
static void compare(int32_t width, ntp_type type, int32_t channels, int32_t spare, int kind,
                    ntp_orientation *found[SETS], uint64_t *seed)
{
    const size_t size = type == NTP_TYPE_U8 ? 1 : type == NTP_TYPE_U16 ? 2 : 4;
    const size_t pixels = (size_t) width * HIGH, samples = pixels * (size_t) (channels + spare);
    guarded memory = guarded_alloc(samples * size, width & 1);
    ntp_image image = ntp_image_packed(memory.data, width, HIGH, channels + spare, type);
    image.channels = channels;
    ntp_const_image view = ntp_image_as_const(&image);
    view.encoding = NTP_ENCODING_STANDARD;
    const uint32_t touch = random_bits(seed) % 2 ? 0 : NTP_UNUSED_TRANSPARENT;
    fill(memory.data, pixels, channels + spare, type, kind, seed);
    for (int k = 0; k < SETS; k++) {
        allowed = k > 0;
        allowed_512 = k == 2;
        memset(found[k], 0, ntp_orientation_size());
        CHECK(ntp_orientation_add(found[k], &view, touch, 1, NULL) == NTP_OK);
        if (k > 0)
            CHECK(memcmp((void *) found[0], (void *) found[k], ntp_orientation_size()) == 0);
    }
    guarded_free(&memory);
}

int main(void)
{
    ntp_orientation *found[SETS];
    uint64_t seed = 31415926;
    allowed = true;
    if (!ntp__cpu_has_avx2(NTP__CPU_ALL))
        return SKIPPED;
    for (int k = 0; k < SETS; k++) {
        found[k] = malloc(ntp_orientation_size());
        CHECK(found[k] != NULL);
    }
    for (int32_t width = 1; width <= WIDEST; width++) {
        const int32_t channels = 3 + width / 2 % 2, kind = width % KINDS;
        compare(width, NTP_TYPE_U8, channels, 0, kind, found, &seed);
        compare(width, NTP_TYPE_U8, 7 - channels, 0, (kind + 1) % KINDS, found, &seed);
        compare(width, NTP_TYPE_U8, 3, 1, (kind + 2) % KINDS, found, &seed);
        compare(width, NTP_TYPE_U16, channels, 0, kind, found, &seed);
        compare(width, NTP_TYPE_F32, channels, 0, kind, found, &seed);
    }
    for (int k = 0; k < SETS; k++)
        free(found[k]);
    return 0;
}
