/* SPDX-License-Identifier: MIT */
/*
 * stamp.c - which version of a file was read
 */
#include "stamp.h"

ntpio_stamp ntpio__stamp_of(const os_file *file)
{
    if (file->kind != OS_REGULAR)
        return (ntpio_stamp) { 0 };
    return (ntpio_stamp) { .known = true,
                           .device = file->device,
                           .node = file->node,
                           .size = file->size,
                           .seconds = file->seconds,
                           .nanoseconds = file->nanoseconds };
}

os_file ntpio__version_of(const ntpio_stamp *stamp)
{
    return (os_file) { .kind = OS_REGULAR,
                       .device = stamp->device,
                       .node = stamp->node,
                       .size = stamp->size,
                       .seconds = stamp->seconds,
                       .nanoseconds = stamp->nanoseconds };
}

bool ntpio_is_current(const char *path, const ntpio_stamp *stamp)
{
    os_file now;
    const os_file read = ntpio__version_of(stamp);
    return !stamp->known || (os_look(path, &now) && os_same_version(&now, &read));
}
