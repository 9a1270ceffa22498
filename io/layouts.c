/* SPDX-License-Identifier: MIT */
/*
 * layouts.c - formats of texels by their numbers in DXGI and Vulkan
 *
 * One table has both numbers, with those of sRGB beside them.  Names are those of DXGI without what
 * says how numbers are read, such as UNORM.
 */
#include "layouts.h"

#include <stdio.h>

typedef struct entry {
    uint16_t dxgi, dxgi_srgb; /* 0: none */
    uint16_t vulkan, vulkan_srgb;
    const char *name;
    ntpio__layout layout; /* texels 0: not read */
} entry;

#define PLAIN(kind, channels)                                                                      \
    { NTPIO__TEXELS_##kind, channels, channels, "", false, channels == 4, { 0 } }
#define ORDERED(kind, n, in, order) { NTPIO__TEXELS_##kind, n, in, order, false, n == 4, { 0 } }
#define BLOCK(kind, n, alpha, sign) { NTPIO__TEXELS_##kind, n, n, "", sign, alpha, { 0 } }
#define BITS(n, bytes, r, g, b, a)                                                                 \
    {                                                                                              \
        NTPIO__TEXELS_MASKED, n, bytes, "", false, n == 4,                                         \
        {                                                                                          \
            r, g, b, a                                                                             \
        }                                                                                          \
    }
#define NOT_READ { NTPIO__TEXELS_NONE, 0, 0, "", false, false, { 0 } }

/* clang-format off */
static const entry TABLE[] = {
    { 61, 0, 9, 15, "R8", PLAIN(U8, 1) },
    { 63, 0, 10, 0, "R8 SNORM", PLAIN(S8, 1) },
    { 65, 0, 0, 0, "A8", PLAIN(U8, 1) },
    { 49, 0, 16, 22, "R8G8", PLAIN(U8, 2) },
    { 51, 0, 17, 0, "R8G8 SNORM", PLAIN(S8, 2) },
    { 0, 0, 23, 29, "R8G8B8", PLAIN(U8, 3) },
    { 0, 0, 24, 0, "R8G8B8 SNORM", PLAIN(S8, 3) },
    { 0, 0, 30, 36, "B8G8R8", ORDERED(U8, 3, 3, "210") },
    { 28, 29, 37, 43, "R8G8B8A8", PLAIN(U8, 4) },
    { 31, 0, 38, 0, "R8G8B8A8 SNORM", PLAIN(S8, 4) },
    { 87, 91, 44, 50, "B8G8R8A8", ORDERED(U8, 4, 4, "2103") },
    { 88, 93, 0, 0, "B8G8R8X8", ORDERED(U8, 3, 4, "210") },
    { 24, 0, 64, 0, "R10G10B10A2", BITS(4, 4, 0x3ff, 0xffc00, 0x3ff00000, 0xc0000000) },
    { 85, 0, 4, 0, "B5G6R5", BITS(3, 2, 0xf800, 0x7e0, 0x1f, 0) },
    { 86, 0, 8, 0, "B5G5R5A1", BITS(4, 2, 0x7c00, 0x3e0, 0x1f, 0x8000) },
    { 115, 0, 0, 0, "B4G4R4A4", BITS(4, 2, 0xf00, 0xf0, 0xf, 0xf000) },
    { 56, 0, 70, 0, "R16", PLAIN(U16, 1) },
    { 58, 0, 71, 0, "R16 SNORM", PLAIN(S16, 1) },
    { 54, 0, 76, 0, "R16 FLOAT", PLAIN(F16, 1) },
    { 35, 0, 77, 0, "R16G16", PLAIN(U16, 2) },
    { 37, 0, 78, 0, "R16G16 SNORM", PLAIN(S16, 2) },
    { 34, 0, 83, 0, "R16G16 FLOAT", PLAIN(F16, 2) },
    { 0, 0, 84, 0, "R16G16B16", PLAIN(U16, 3) },
    { 0, 0, 85, 0, "R16G16B16 SNORM", PLAIN(S16, 3) },
    { 0, 0, 90, 0, "R16G16B16 FLOAT", PLAIN(F16, 3) },
    { 11, 0, 91, 0, "R16G16B16A16", PLAIN(U16, 4) },
    { 13, 0, 92, 0, "R16G16B16A16 SNORM", PLAIN(S16, 4) },
    { 10, 0, 97, 0, "R16G16B16A16 FLOAT", PLAIN(F16, 4) },
    { 41, 0, 100, 0, "R32 FLOAT", PLAIN(F32, 1) },
    { 16, 0, 103, 0, "R32G32 FLOAT", PLAIN(F32, 2) },
    { 6, 0, 106, 0, "R32G32B32 FLOAT", PLAIN(F32, 3) },
    { 2, 0, 109, 0, "R32G32B32A32 FLOAT", PLAIN(F32, 4) },
    { 71, 72, 131, 132, "BC1", BLOCK(BC1, 3, false, false) },
    { 0, 0, 133, 134, "BC1", BLOCK(BC1, 4, true, false) },
    { 74, 75, 135, 136, "BC2", BLOCK(BC2, 4, true, false) },
    { 77, 78, 137, 138, "BC3", BLOCK(BC3, 4, true, false) },
    { 80, 0, 139, 0, "BC4", BLOCK(BC4, 1, false, false) },
    { 81, 0, 140, 0, "BC4 SNORM", BLOCK(BC4, 1, false, true) },
    { 83, 0, 141, 0, "BC5", BLOCK(BC5, 2, false, false) },
    { 84, 0, 142, 0, "BC5 SNORM", BLOCK(BC5, 2, false, true) },
    { 95, 0, 143, 0, "BC6H", NOT_READ },
    { 96, 0, 144, 0, "BC6H", NOT_READ },
    { 98, 99, 145, 146, "BC7", BLOCK(BC7, 4, true, false) },
};
/* clang-format on */

/* Formats of blocks that are not read, by the first and last number. */
static const struct {
    uint32_t first, last;
    const char *name;
} OTHERS[] = { { 147, 156, "ETC2 or EAC" },
               { 157, 184, "ASTC" },
               { 1000054000, 1000054007, "PVRTC" },
               { 1000066000, 1000066013, "ASTC HDR" } };

static bool fill(const entry *e, bool srgb, ntpio__texture *t, bool *is_srgb)
{
    t->layout = e->layout;
    snprintf(t->name, sizeof t->name, "%s%s", e->name, srgb ? " sRGB" : "");
    *is_srgb = srgb;
    return e->layout.texels != NTPIO__TEXELS_NONE;
}

bool ntpio__layout_of_dxgi(uint32_t number, ntpio__texture *t, bool *srgb)
{
    for (size_t i = 0; i < sizeof TABLE / sizeof *TABLE && number != 0; i++) {
        if (TABLE[i].dxgi == number || TABLE[i].dxgi_srgb == number)
            return fill(&TABLE[i], TABLE[i].dxgi != number, t, srgb);
    }
    snprintf(t->name, sizeof t->name, "DXGI format %lu", (unsigned long) number);
    return false;
}

bool ntpio__layout_of_vulkan(uint32_t number, ntpio__texture *t, bool *srgb)
{
    for (size_t i = 0; i < sizeof TABLE / sizeof *TABLE && number != 0; i++) {
        if (TABLE[i].vulkan == number || TABLE[i].vulkan_srgb == number)
            return fill(&TABLE[i], TABLE[i].vulkan != number, t, srgb);
    }
    snprintf(t->name, sizeof t->name, "Vulkan format %lu", (unsigned long) number);
    for (size_t i = 0; i < sizeof OTHERS / sizeof *OTHERS; i++) {
        if (number >= OTHERS[i].first && number <= OTHERS[i].last)
            snprintf(t->name, sizeof t->name, "%s", OTHERS[i].name);
    }
    return false;
}
