/* SPDX-License-Identifier: MIT */
/*
 * output.h - writes a file beside its target, and puts it in place
 *
 * Until then the target stays as it was, however the program dies.  A symbolic link stays, and what
 * it leads to is replaced.  Devices and pipes are written directly.
 */
#ifndef NTP_OS_OUTPUT_H
#define NTP_OS_OUTPUT_H

#include "os/files.h"

enum { OS_WHAT_SIZE = 320 };

/* Why it failed: "WHAT: the words of the error". */
typedef struct os_problem {
    char what[OS_WHAT_SIZE]; /* "" with ENOMEM: no memory */
    int error;               /* errno */
    bool changed;            /* somebody saved another version of the target meanwhile */
} os_problem;

typedef struct os_output os_output;

/* made_of: the version of the file that the output is made of, or NULL.  If it is the target, a
 * version that somebody saves meanwhile is not lost. */
os_output *os_output_open(const char *path, const os_file *made_of, os_problem *problem);

/* Standard output. */
os_output *os_output_standard(os_problem *problem);

/* Can bytes be written anywhere?  Not in a pipe. */
bool os_output_can_seek(const os_output *output);

/* Where it cannot seek, bytes follow those that were written before. */
bool os_output_write(os_output *output, uint64_t offset, const void *bytes, size_t size,
                     os_problem *problem);

/* All bytes are on the disk; nothing to do for what is written directly. */
bool os_output_sync(os_output *output, os_problem *problem);

/* Gives the file the name of its target, or ends what was written directly. */
bool os_output_finish(os_output *output, os_problem *problem);

/* Drops a file that is not finished.  NULL is allowed. */
void os_output_free(os_output *output);

#endif
