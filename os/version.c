/* SPDX-License-Identifier: MIT */
/*
 * version.c - which version of a file was read
 *
 * Programs save a file by renaming another over it (a new node) or by writing into it (another time
 * or size).
 */
#include <stdlib.h>

#include "os/files.h"

bool os_same_version(const os_file *a, const os_file *b)
{
    return a->kind == b->kind && a->device == b->device && a->node == b->node &&
           a->size == b->size && a->seconds == b->seconds && a->nanoseconds == b->nanoseconds;
}

void os_free_names(os_names *names)
{
    for (size_t i = 0; i < names->count; i++)
        free(names->at[i]);
    free(names->at);
    *names = (os_names) { 0 };
}
