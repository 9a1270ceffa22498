/* SPDX-License-Identifier: MIT */
/*
 * undo.h - accidents that are exactly undone: exchanged channels, DXT5nm, inverted blue, sRGB
 *
 * The rows of a source are put right as they are read, so that all else sees a standard texture.
 */
#ifndef NTP_CLI_UNDO_H
#define NTP_CLI_UNDO_H

#include <jansson.h>

#include "examine/examine.h"
#include "write/undo_rows.h"

typedef struct undo {
    undo_kind kind;
    double confidence; /* of the accident */
    ntp_type type;
    int32_t channels;
    undo_loss loss;
} undo;

/* The accident that the texels show, or UNDO_NOTHING.  Inverted blue counts only as an accident of
 * standard textures. */
undo_kind undo_kind_of(const facts *f);

/* Can it be undone in such a file?  (sRGB not in floats.) */
bool undo_is_possible(undo_kind kind, const ntpio_info *info);

/* From here on the source, which stands at its first row, is read with the accident undone. */
void undo_begin(undo *u, source *s, undo_kind kind, double confidence);
/* Before each pass over the rows. */
void undo_restart(undo *u);

/* The rows of the block that was read last, as they are stored. */
ntp_const_image undo_stored(const source *s);

/* "red and blue are exchanged" */
const char *undo_title(undo_kind kind);
/* Adds "undid sRGB (93 % sure), whose rounding ...". */
void undo_tell(text *line, const undo *u, bool would);
/* What was undone, as an object, or null. */
json_t *undo_json(const undo *u);

#endif
