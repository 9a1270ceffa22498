/* SPDX-License-Identifier: MIT */
/*
 * exr_channels.h - which channels of an EXR are read
 */
#ifndef NTPIO_EXR_CHANNELS_H
#define NTPIO_EXR_CHANNELS_H

#include <openexr.h>

#include "reader.h"

typedef struct ntpio__exr_choice {
    int index[4]; /* in the list of channels */
    int32_t count;
    size_t bytes[4];  /* of a sample */
    size_t offset[4]; /* of the channel in a line, in bytes a texel */
    size_t texel;     /* bytes of all channels */
    bool pair;        /* red and green alone */
    bool alpha;       /* the last is A */
    bool vectors;     /* X, Y, Z */
    bool half;        /* all are half floats */
} ntpio__exr_choice;

/*
 * A layer is what the names of its channels have in common before their last dot.  The first layer
 * that offers something is taken: of those with a name of normals, then the one without a name, then
 * the others, in the order of the file.  It offers R, G, B; else X, Y, Z; else R, G; else Y; each
 * but R, G with A, if there is one; else its only channel.  Upper and lower case are the same.
 */
bool ntpio__exr_choose(const ntpio_reader *reader, const exr_attr_chlist_t *list,
                       ntpio__exr_choice *choice, ntpio_error *error);

/* Copies a text of the file, for a message: what is not ASCII becomes '?'. */
void ntpio__exr_plain(char *dst, size_t room, const char *src);

#endif
