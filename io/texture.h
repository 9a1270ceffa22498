/* SPDX-License-Identifier: MIT */
/*
 * texture.h - textures as GPUs take them: how texels lie in DDS and KTX2, and one image of many
 *
 * dds.c and ktx2.c read headers and find the image that the caller picked; texture.c turns its
 * texels or blocks into rows, four rows at a time.
 */
#ifndef NTPIO_TEXTURE_H
#define NTPIO_TEXTURE_H

#include "reader.h"

typedef enum ntpio__texels {
    NTPIO__TEXELS_NONE = 0,
    NTPIO__TEXELS_U8,
    NTPIO__TEXELS_S8, /* signed: -1..1 becomes 0..65535, as that of BC5 */
    NTPIO__TEXELS_U16,
    NTPIO__TEXELS_S16,
    NTPIO__TEXELS_F16,
    NTPIO__TEXELS_F32,
    NTPIO__TEXELS_MASKED, /* bits of up to 32 */
    NTPIO__TEXELS_BC1,
    NTPIO__TEXELS_BC2,
    NTPIO__TEXELS_BC3,
    NTPIO__TEXELS_BC4,
    NTPIO__TEXELS_BC5,
    NTPIO__TEXELS_BC7
} ntpio__texels;

typedef struct ntpio__layout {
    ntpio__texels texels;
    uint8_t channels; /* delivered */
    uint8_t stored;   /* samples of a texel, or bytes of a MASKED one */
    char order[5];    /* which stored sample each channel is, as digits; "": 0, 1, 2, 3 */
    bool is_signed;   /* of BC4, BC5 and MASKED */
    bool alpha;       /* the last channel is alpha */
    uint32_t mask[4];
} ntpio__layout;

typedef struct ntpio__texture {
    ntpio__layout layout;
    char name[32]; /* of the layout, for people */
    uint32_t width, height;
    uint32_t mips, layers; /* a cube has six layers for each of its own */
    bool cube;
} ntpio__texture;

/* Refuses sizes, numbers of mips and a choice that are out of range. */
bool ntpio__texture_check(ntpio_reader *reader, const ntpio__texture *t, ntpio_error *error);

/* The bytes of one image, that of mip `mip`. */
uint64_t ntpio__texture_bytes(const ntpio__texture *t, uint32_t mip);

/* Starts to deliver the picked image, whose texels come next in the source; or in `memory`, which
 * the texture then owns. */
bool ntpio__texture_start(ntpio_reader *reader, const ntpio__texture *t, uint8_t *memory,
                          ntpio_error *error);

/* Moves to byte `offset` of the file, from byte `at`. */
bool ntpio__texture_seek(ntpio_reader *reader, uint64_t at, uint64_t offset, ntpio_error *error);

/* What a decoder of such textures has beside its own open(). */
bool ntpio__texture_rows(ntpio_reader *reader, uint8_t *dst, ptrdiff_t stride, uint32_t count,
                         ntpio_error *error);
void ntpio__texture_close(ntpio_reader *reader);

static inline uint32_t ntpio__u32(const uint8_t *b)
{
    return (uint32_t) b[0] | (uint32_t) b[1] << 8 | (uint32_t) b[2] << 16 | (uint32_t) b[3] << 24;
}

static inline uint64_t ntpio__u64(const uint8_t *b)
{
    return ntpio__u32(b) | (uint64_t) ntpio__u32(b + 4) << 32;
}

#endif
