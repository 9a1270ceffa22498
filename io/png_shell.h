/* SPDX-License-Identifier: MIT */
/*
 * png_shell.h - what stands around the pixels of a PNG, kept for libpng
 */
#ifndef NTPIO_PNG_SHELL_H
#define NTPIO_PNG_SHELL_H

#include "source.h"

/* Begins with zeros; `bytes` is for free. */
typedef struct ntpio__png_shell {
    uint8_t *bytes;
    size_t size, room;
} ntpio__png_shell;

/* Add bytes, the next ones of the source, or all that are left.  False: they are too many, not there, or
 * cannot be read. */
bool ntpio__png_shell_add(ntpio__png_shell *shell, const uint8_t *bytes, size_t size);
bool ntpio__png_shell_read(ntpio__png_shell *shell, ntpio__source *source, size_t size);
bool ntpio__png_shell_read_all(ntpio__png_shell *shell, ntpio__source *source);

#endif
