/* SPDX-License-Identifier: MIT */
/*
 * source.c - where the bytes of an image come from: a file, standard input, memory
 *
 * stdio is unbuffered, with one buffer in front of it.  So the start of a pipe can be looked at
 * before a decoder is chosen, and large reads go past the buffer.
 */
#include "source.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "message.h"
#include "os/files.h"
#include "stamp.h"

enum {
    BUFFER_SIZE = 1 << 16,
    DIRECT_SIZE = 1 << 13 /* so much is read past the buffer, whose pages may be fresh */
};

static size_t from_file(ntpio__source *source, void *dst, size_t size)
{
    if (source->file == NULL || source->problem != 0)
        return 0;
    errno = 0;
    const size_t got = fread(dst, 1, size, source->file);
    if (got < size && ferror(source->file))
        source->problem = errno != 0 ? errno : EIO;
    return got;
}

bool ntpio__source_open(ntpio__source *source, const char *path, bool regular_only,
                        ntpio_error *error)
{
    *source = (ntpio__source) { .start = -1 };
    const bool standard = strcmp(path, "-") == 0;
    source->file = standard ? stdin : os_open_to_read(path, regular_only);
    if (source->file == NULL)
        return ntpio__fail(error, NTPIO_ERR_OPEN, path, "cannot be opened: %s", strerror(errno));
    os_file file;
    if (!standard && os_look_at_open(source->file, &file))
        source->stamp = ntpio__stamp_of(&file);
    if (!standard && regular_only && !source->stamp.known) {
        ntpio__source_close(source);
        return ntpio__fail(error, NTPIO_ERR_OPEN, path, "not a regular file");
    }
    source->buffer = malloc(BUFFER_SIZE);
    if (source->buffer == NULL) {
        ntpio__source_close(source);
        return ntpio__fail_memory(error, path);
    }
    if (!standard) {
        setvbuf(source->file, NULL, _IONBF, 0);
        if (os_seek(source->file, 0, SEEK_SET))
            source->start = 0;
    }
    source->bytes = source->buffer;
    source->end = from_file(source, source->buffer, NTPIO__PEEK);
    if (source->end == 0 && source->problem != 0) {
        const int problem = source->problem;
        ntpio__source_close(source);
        return ntpio__fail(error, NTPIO_ERR_OPEN, path, "cannot be read: %s", strerror(problem));
    }
    return true;
}

void ntpio__source_memory(ntpio__source *source, const void *bytes, size_t size)
{
    *source = (ntpio__source) { .bytes = bytes, .end = size };
}

void ntpio__source_close(ntpio__source *source)
{
    if (source->file != NULL && source->file != stdin)
        fclose(source->file);
    free(source->buffer);
    *source = (ntpio__source) { .start = -1 };
}

size_t ntpio__peek(ntpio__source *source, size_t size)
{
    if (source->file != NULL && source->end - source->at < size) {
        source->end -= source->at;
        memmove(source->buffer, source->buffer + source->at, source->end);
        source->at = 0;
        source->end += from_file(source, source->buffer + source->end, BUFFER_SIZE - source->end);
    }
    return source->end - source->at;
}

bool ntpio__source_hold(ntpio__source *source, uint64_t most, bool *too_long)
{
    *too_long = false;
    if (source->file == NULL)
        return true;
    size_t size = source->end - source->at, room = BUFFER_SIZE;
    memmove(source->buffer, source->buffer + source->at, size);
    for (;;) {
        if (size == room) {
            *too_long = room > most || room > SIZE_MAX / 2;
            uint8_t *grown = *too_long ? NULL : realloc(source->buffer, room * 2);
            if (grown == NULL)
                return false;
            source->buffer = grown;
            room *= 2;
        }
        const size_t got = from_file(source, source->buffer + size, room - size);
        size += got;
        if (got == 0)
            break;
    }
    *too_long = size > most;
    if (source->file != stdin)
        fclose(source->file);
    source->file = NULL;
    source->bytes = source->buffer;
    source->at = 0;
    source->end = size;
    return !*too_long;
}

size_t ntpio__read(ntpio__source *source, void *dst, size_t size)
{
    uint8_t *out = dst;
    size_t done = 0;
    while (done < size) {
        size_t some = source->end - source->at;
        if (some != 0) {
            some = some < size - done ? some : size - done;
            memcpy(out + done, source->bytes + source->at, some);
            source->at += some;
        } else if (size - done >= DIRECT_SIZE) {
            some = from_file(source, out + done, size - done);
        } else if (ntpio__peek(source, 1) != 0) {
            continue;
        }
        if (some == 0)
            break;
        done += some;
    }
    return done;
}

bool ntpio__can_seek(const ntpio__source *source)
{
    return source->file == NULL || source->start >= 0;
}

bool ntpio__seek(ntpio__source *source, uint64_t offset)
{
    if (source->file == NULL) {
        if (offset > source->end)
            return false;
        source->at = (size_t) offset;
        return true;
    }
    source->at = source->end = 0;
    return offset <= INT64_MAX && os_seek(source->file, (int64_t) offset, SEEK_SET);
}

bool ntpio__size(ntpio__source *source, uint64_t *size)
{
    if (source->file == NULL) {
        *size = source->end;
        return true;
    }
    const int64_t here = ntpio__can_seek(source) ? os_tell(source->file) : -1;
    if (here < 0 || !os_seek(source->file, 0, SEEK_END))
        return false;
    const int64_t end = os_tell(source->file);
    *size = end < 0 ? 0 : (uint64_t) end;
    return os_seek(source->file, here, SEEK_SET) && end >= 0;
}
