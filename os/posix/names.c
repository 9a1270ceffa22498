/* SPDX-License-Identifier: MIT */
/*
 * names.c - directories and patterns
 */
#include <dirent.h>
#include <errno.h>
#include <fnmatch.h>
#include <glob.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "os/files.h"

bool os_is_absolute(const char *path)
{
    return path[0] == '/';
}

void os_take_path(char *path)
{
    (void) path; /* a backslash is part of a name */
}

/* The file systems of macOS take "Wall" and "wall" for one name, unless they were made otherwise. */
int os_compare_names(const char *a, const char *b)
{
#ifdef __APPLE__
    return strcasecmp(a, b);
#else
    return strcmp(a, b);
#endif
}

const char *os_after_drive(const char *path)
{
    return path;
}

bool os_matches(const char *pattern, const char *name)
{
    return fnmatch(pattern, name, 0) == 0;
}

/* No dotfiles: our own temporary files are among them. */
static int is_listed(const struct dirent *entry)
{
    return entry->d_name[0] != '.';
}

static int by_bytes(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

bool os_list(const char *directory, os_names *names)
{
    struct dirent **entries = NULL;
    *names = (os_names) { 0 };
    const int count = scandir(directory, &entries, is_listed, by_bytes);
    if (count < 0)
        return false;
    bool ok = true;
    names->at = calloc((size_t) count + 1, sizeof *names->at);
    for (int i = 0; i < count; i++) {
        char *name = names->at != NULL ? strdup(entries[i]->d_name) : NULL;
        ok = ok && name != NULL;
        if (name != NULL)
            names->at[names->count++] = name;
        free(entries[i]);
    }
    free(entries);
    if (ok && names->at != NULL)
        return true;
    os_free_names(names);
    errno = ENOMEM;
    return false;
}

bool os_expand(const char *pattern, os_names *names)
{
    glob_t found = { 0 };
    *names = (os_names) { 0 };
    const bool any = strpbrk(pattern, "*?[") != NULL && glob(pattern, 0, NULL, &found) == 0;
    if (any)
        names->at = calloc(found.gl_pathc + 1, sizeof *names->at);
    for (size_t i = 0; names->at != NULL && i < found.gl_pathc; i++) {
        char *path = strdup(found.gl_pathv[i]);
        if (path == NULL)
            break;
        names->at[names->count++] = path;
    }
    globfree(&found);
    return names->count > 0;
}
