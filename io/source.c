/* SPDX-License-Identifier: MIT */
/*
 * source.c - where the bytes of an image come from: a file, standard input, memory
 *
 * stdio is unbuffered, with one buffer in front of it.  So the start of a pipe can be looked at
 * before a decoder is chosen, and large reads go past the buffer.
 */
#include "source.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "message.h"
#include "stamp.h"

#ifndef O_CLOEXEC
#  define O_CLOEXEC 0
#endif

enum { BUFFER_SIZE = 1 << 16 };

/* A pipe without a writer would be waited for: O_NONBLOCK does not, and changes nothing about
 * regular files. */
static FILE *open_file(const char *path, bool regular_only)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC | (regular_only ? O_NONBLOCK : 0));
    FILE *file = fd >= 0 ? fdopen(fd, "rb") : NULL;
    if (fd >= 0 && file == NULL)
        close(fd);
    return file;
}

bool ntpio__source_open(ntpio__source *source, const char *path, bool regular_only,
                        ntpio_error *error)
{
    *source = (ntpio__source) { .start = -1 };
    const bool standard = strcmp(path, "-") == 0;
    source->file = standard ? stdin : open_file(path, regular_only);
    if (source->file == NULL)
        return ntpio__fail(error, NTPIO_ERR_OPEN, path, "cannot be opened: %s", strerror(errno));
    if (!standard)
        source->stamp = ntpio__stamp_of(fileno(source->file));
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
        if (fseek(source->file, 0, SEEK_SET) == 0)
            source->start = 0;
    }
    source->bytes = source->buffer;
    if (ntpio__peek(source, 1) == 0 && source->problem != 0) {
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
        } else if (size - done >= BUFFER_SIZE) {
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
    return offset <= LONG_MAX && fseek(source->file, (long) offset, SEEK_SET) == 0;
}

bool ntpio__size(ntpio__source *source, uint64_t *size)
{
    if (source->file == NULL) {
        *size = source->end;
        return true;
    }
    const long here = ntpio__can_seek(source) ? ftell(source->file) : -1;
    if (here < 0 || fseek(source->file, 0, SEEK_END) != 0)
        return false;
    const long end = ftell(source->file);
    *size = end < 0 ? 0 : (uint64_t) end;
    return fseek(source->file, here, SEEK_SET) == 0 && end >= 0;
}
