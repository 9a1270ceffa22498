/* SPDX-License-Identifier: MIT */
/*
 * stamp.c - which version of a file was read
 *
 * Programs save a file by renaming another over it (a new node) or by writing into it (another time
 * or size).
 */
#include "stamp.h"

#include <fcntl.h>
#include <sys/stat.h>

static ntpio_stamp from_state(const struct stat *st)
{
#ifdef __APPLE__
    const struct timespec changed = st->st_mtimespec;
#else
    const struct timespec changed = st->st_mtim;
#endif
    if (!S_ISREG(st->st_mode))
        return (ntpio_stamp) { 0 };
    return (ntpio_stamp) { .known = true,
                           .device = (uint64_t) st->st_dev,
                           .node = (uint64_t) st->st_ino,
                           .size = (uint64_t) st->st_size,
                           .seconds = changed.tv_sec,
                           .nanoseconds = changed.tv_nsec };
}

ntpio_stamp ntpio__stamp_of(int fd)
{
    struct stat st;
    return fstat(fd, &st) == 0 ? from_state(&st) : (ntpio_stamp) { 0 };
}

bool ntpio__has_stamp(int directory, const char *name, const ntpio_stamp *stamp)
{
    struct stat st;
    if (fstatat(directory, name, &st, 0) != 0)
        return false;
    const ntpio_stamp now = from_state(&st);
    return now.known && now.device == stamp->device && now.node == stamp->node &&
           now.size == stamp->size && now.seconds == stamp->seconds &&
           now.nanoseconds == stamp->nanoseconds;
}

bool ntpio_is_current(const char *path, const ntpio_stamp *stamp)
{
    return !stamp->known || ntpio__has_stamp(AT_FDCWD, path, stamp);
}
