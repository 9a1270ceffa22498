/* SPDX-License-Identifier: MIT */
/*
 * blend_texels.h - details of normals laid over others, for both operations that blend
 */
#ifndef NTP_GEGL_BLEND_TEXELS_H
#define NTP_GEGL_BLEND_TEXELS_H

#include "blending.h"

/* Set by prepare(), read by the threads that process. */
typedef struct blend_texels {
    pixels base, detail;
    const blending *blending; /* shared by all */
    gboolean light;           /* the output is for GIMP's blending */
} blend_texels;

typedef struct blend_how {
    ntp_blend_options options;
    ntp_encoding encoding;
    ntp_y base_y, detail_y;
} blend_how;

/* Sets the formats of the input and the output, by those of both pictures (NULL: not known). */
void blend_texels_prepare(blend_texels *b, GeglOperation *operation, const Babl *base,
                          const Babl *detail);

/* Without a detail the base is the result. */
gboolean blend_texels_make(const blend_texels *b, const blend_how *how, guchar *base,
                           guchar *detail, gpointer out, glong texels);

#endif
