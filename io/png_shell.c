/* SPDX-License-Identifier: MIT */
/*
 * png_shell.c - what stands around the pixels of a PNG, kept for libpng
 */
#include "png_shell.h"

#include <stdlib.h>
#include <string.h>

enum { SHELL_MAX = 1 << 24 };

/* Makes room for so many bytes more. */
static bool grow(ntpio__png_shell *s, size_t size)
{
    if (size > SHELL_MAX - s->size)
        return false;
    if (s->room - s->size >= size)
        return true;
    const size_t room = 2 * (s->size + size);
    uint8_t *grown = realloc(s->bytes, room);
    if (grown == NULL)
        return false;
    s->bytes = grown;
    s->room = room;
    return true;
}

bool ntpio__png_shell_add(ntpio__png_shell *s, const uint8_t *bytes, size_t size)
{
    if (!grow(s, size))
        return false;
    memcpy(s->bytes + s->size, bytes, size);
    s->size += size;
    return true;
}

bool ntpio__png_shell_read(ntpio__png_shell *s, ntpio__source *source, size_t size)
{
    if (!grow(s, size) || ntpio__read(source, s->bytes + s->size, size) != size)
        return false;
    s->size += size;
    return true;
}

bool ntpio__png_shell_read_all(ntpio__png_shell *s, ntpio__source *source)
{
    enum { SOME = 1 << 12 };
    size_t got = SOME;
    bool good = true;
    for (; good && got == SOME; s->size += got) {
        good = grow(s, SOME);
        got = good ? ntpio__read(source, s->bytes + s->size, SOME) : 0;
    }
    return good && source->problem == 0;
}
