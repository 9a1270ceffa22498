/* SPDX-License-Identifier: MIT */
/*
 * files.h - files, directories and their names
 *
 * The room of what differs by system: os/posix/, os/windows/ and os/wasi/ have the same functions,
 * and the build takes one of them.  Nothing outside os/ asks which system it is.
 *   files.h    what a file is, opening, listing, patterns
 *   output.h   writing a file beside its target, and putting it in place
 *   console.h  arguments, terminals, interruption, other programs
 *   threads.h  threads, locks, time
 *   memory.h   aligned memory, large pages
 *
 * Names are UTF-8 with slashes (POSIX: any bytes).  What fails sets errno.
 */
#ifndef NTP_OS_FILES_H
#define NTP_OS_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef enum os_kind {
    OS_REGULAR,
    OS_DIRECTORY,
    OS_DEVICE, /* it may have no end */
    OS_OTHER   /* a pipe, a socket */
} os_kind;

/* What a file is, and which version of it. */
typedef struct os_file {
    os_kind kind;
    uint64_t device, node, size;
    int64_t seconds, nanoseconds; /* of the last change of the content */
} os_file;

/* Links are followed.  False: there is none, or it cannot be looked at. */
bool os_look(const char *path, os_file *file);
bool os_look_at_open(FILE *stream, os_file *file);

/* Is there a file or a link of this name?  The link may lead nowhere. */
bool os_exists(const char *path);

bool os_same_version(const os_file *a, const os_file *b);

/* To be read in binary; no_wait: a pipe without a writer is not waited for. */
FILE *os_open_to_read(const char *path, bool no_wait);

/* Offsets of more than 2 GiB; os_tell: -1 if the stream cannot tell. */
bool os_seek(FILE *stream, int64_t offset, int from);
int64_t os_tell(FILE *stream);

/* A line up to `end`, which it keeps; *line grows.  -1: there is none. */
ptrdiff_t os_read_line(char **line, size_t *size, int end, FILE *stream);

/* An absolute path without links, to be freed; NULL if there is no such file. */
char *os_real_path(const char *path);

/* To be freed. */
char *os_current_directory(void);

bool os_make_directory(const char *path);

/* ------------------------------------------------------------------------ names */

bool os_is_absolute(const char *path);

/* A path as a user types it, in place: with slashes. */
void os_take_path(char *path);

/* As strcmp, but 0 for two spellings that the system takes for one name. */
int os_compare_names(const char *a, const char *b);

/* What a path says after its drive. */
const char *os_after_drive(const char *path);

/* Does a name match a shell pattern? */
bool os_matches(const char *pattern, const char *name);

typedef struct os_names {
    char **at;
    size_t count;
} os_names;

/* The names in a directory that do not start with a dot, sorted by bytes.  */
bool os_list(const char *directory, os_names *names);

/* The files that match a shell pattern, sorted; false if there is none. */
bool os_expand(const char *pattern, os_names *names);

void os_free_names(os_names *names);

#endif
