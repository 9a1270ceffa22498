/* SPDX-License-Identifier: MIT */
/*
 * undo_rows.h - which accident a texture shows, and levels put right again
 *
 * For the verbs and for the GIMP plug-in.  It needs nothing but libntp.
 */
#ifndef NTP_CLI_UNDO_ROWS_H
#define NTP_CLI_UNDO_ROWS_H

#include "libntp.h"

#include <stddef.h>

typedef enum undo_kind {
    UNDO_NOTHING,
    UNDO_RED_BLUE,
    UNDO_GREEN_BLUE,
    UNDO_DXT5NM,
    UNDO_BLUE, /* inverted */
    UNDO_SRGB
} undo_kind;

/* The accident that a texture of these channels shows, or UNDO_NOTHING.  Inverted blue counts only
 * as an accident of standard textures. */
undo_kind undo_kind_shown(const ntp_classification *type, int32_t channels);

/* What the rounding to sRGB took; each call adds to it. */
typedef struct undo_loss {
    uint64_t texels;   /* of which it was counted */
    uint32_t most;     /* of a level */
    double sum, angle; /* of the vectors, in radians: sum and greatest */
} undo_loss;

/* UNDO_SRGB (not in floats) and UNDO_BLUE in rows without gaps; other kinds change nothing here. */
void undo_levels(undo_kind kind, void *rows, ntp_type type, int32_t channels, size_t texels,
                 undo_loss *loss);

#endif
