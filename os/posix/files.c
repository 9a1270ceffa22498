/* SPDX-License-Identifier: MIT */
/*
 * files.c - what a file is, opening, reading
 */
#include "os/files.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "os/posix/state.h"

#ifndef O_CLOEXEC
#  define O_CLOEXEC 0
#endif

os_file os__file_of(const struct stat *st)
{
#ifdef __APPLE__
    const struct timespec changed = st->st_mtimespec;
#else
    const struct timespec changed = st->st_mtim;
#endif
    const bool device = S_ISCHR(st->st_mode) || S_ISBLK(st->st_mode);
    return (os_file) { .kind = S_ISREG(st->st_mode)   ? OS_REGULAR
                               : S_ISDIR(st->st_mode) ? OS_DIRECTORY
                               : device               ? OS_DEVICE
                                                      : OS_OTHER,
                       .device = (uint64_t) st->st_dev,
                       .node = (uint64_t) st->st_ino,
                       .size = (uint64_t) st->st_size,
                       .seconds = changed.tv_sec,
                       .nanoseconds = changed.tv_nsec };
}

bool os_look(const char *path, os_file *file)
{
    struct stat st;
    if (stat(path, &st) != 0)
        return false;
    *file = os__file_of(&st);
    return true;
}

bool os_look_at_open(FILE *stream, os_file *file)
{
    struct stat st;
    if (fstat(fileno(stream), &st) != 0)
        return false;
    *file = os__file_of(&st);
    return true;
}

bool os_exists(const char *path)
{
    struct stat st;
    return lstat(path, &st) == 0;
}

/* A pipe without a writer would be waited for: O_NONBLOCK does not, and changes nothing about
 * regular files. */
FILE *os_open_to_read(const char *path, bool no_wait)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC | (no_wait ? O_NONBLOCK : 0));
    FILE *file = fd >= 0 ? fdopen(fd, "rb") : NULL;
    if (fd >= 0 && file == NULL)
        close(fd);
    return file;
}

bool os_seek(FILE *stream, int64_t offset, int from)
{
    return (off_t) offset == offset && fseeko(stream, (off_t) offset, from) == 0;
}

int64_t os_tell(FILE *stream)
{
    return ftello(stream);
}

ptrdiff_t os_read_line(char **line, size_t *size, int end, FILE *stream)
{
    return getdelim(line, size, end, stream);
}

char *os_real_path(const char *path)
{
#ifdef __wasi__ /* it has no links */
    return strdup(path);
#else
    return realpath(path, NULL);
#endif
}

char *os_current_directory(void)
{
    return getcwd(NULL, 0);
}

bool os_make_directory(const char *path)
{
    return mkdir(path, 0777) == 0;
}
