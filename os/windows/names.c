/* SPDX-License-Identifier: MIT */
/*
 * names.c - directories and patterns
 *
 * The shells of Windows leave patterns to programs.  Case does not matter in names.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <wchar.h>
#include <windows.h>

#include "os/files.h"
#include "os/windows/wide.h"

/* ------------------------------------------------------------------------ spelling */

void os_take_path(char *path)
{
    for (; *path != 0; path++) {
        if (*path == '\\')
            *path = '/';
    }
}

static bool has_drive(const char *path)
{
    const char c = path[0];
    return ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z')) && path[1] == ':';
}

bool os_is_absolute(const char *path)
{
    return path[0] == '/' || has_drive(path);
}

/* "C:", "//server/share", "//?/C:" */
const char *os_after_drive(const char *path)
{
    if (has_drive(path))
        return path + 2;
    if (strncmp(path, "//", 2) != 0)
        return path;
    if (strncmp(path, "//?/", 4) == 0 && has_drive(path + 4))
        return path + 6;
    const char *share = strchr(path + 2, '/');
    return share == NULL ? path + strlen(path) : share + 1 + strcspn(share + 1, "/");
}

int os_compare_names(const char *a, const char *b)
{
    wchar_t *x = os__wide(a), *y = os__wide(b);
    const int order = x != NULL && y != NULL ? CompareStringOrdinal(x, -1, y, -1, TRUE) - CSTR_EQUAL
                                             : strcmp(a, b);
    free(x);
    free(y);
    return order;
}

/* ------------------------------------------------------------------------ patterns */

static wchar_t lower(wchar_t c)
{
    return (wchar_t) (uintptr_t) CharLowerW((wchar_t *) (uintptr_t) c); /* of one letter */
}

/* One character, which may be a surrogate pair. */
static const wchar_t *next(const wchar_t *s)
{
    const bool pair = s[0] >= 0xd800 && s[0] < 0xdc00 && s[1] >= 0xdc00 && s[1] < 0xe000;
    return s + (pair ? 2 : 1);
}

/* The end of a [set] at p, or NULL: then [ stands for itself.  *in: is c in it? */
static const wchar_t *match_set(const wchar_t *p, wchar_t c, bool *in)
{
    const bool negated = p[1] == L'!' || p[1] == L'^';
    bool found = false;
    p += negated ? 2 : 1;
    for (const wchar_t *first = p; *p != 0 && (*p != L']' || p == first); p++) {
        const wchar_t from = lower(*p);
        const bool range = p[1] == L'-' && p[2] != 0 && p[2] != L']';
        if (range)
            p += 2;
        found = found || (c >= from && c <= lower(*p));
    }
    *in = found != negated;
    return *p == L']' ? p + 1 : NULL;
}

/* One character of the name against one of the pattern; NULL: it does not match. */
static const wchar_t *match_one(const wchar_t *p, const wchar_t *s)
{
    bool in = false;
    if (*s == 0)
        return NULL;
    if (*p == L'?')
        return p + 1;
    const wchar_t *end = *p == L'[' ? match_set(p, lower(*s), &in) : NULL;
    if (end != NULL)
        return in ? end : NULL;
    return lower(*p) == lower(*s) ? p + 1 : NULL;
}

static bool match(const wchar_t *p, const wchar_t *s)
{
    const wchar_t *star = NULL, *from = NULL; /* the last *, and where its text ends */
    for (;;) {
        if (*p == L'*') {
            star = ++p;
            from = s;
            continue;
        }
        if (*p == 0 && *s == 0)
            return true;
        const wchar_t *on = *p != 0 ? match_one(p, s) : NULL;
        if (on != NULL) {
            s = *p == L'?' ? next(s) : s + 1;
            p = on;
        } else if (star != NULL && *from != 0) {
            p = star;
            s = from = next(from);
        } else {
            return false;
        }
    }
}

bool os_matches(const char *pattern, const char *name)
{
    wchar_t *p = os__wide(pattern), *s = os__wide(name);
    const bool matches = p != NULL && s != NULL && match(p, s);
    free(p);
    free(s);
    return matches;
}

/* ------------------------------------------------------------------------ listing */

static int by_bytes(const void *a, const void *b)
{
    return strcmp(*(char *const *) a, *(char *const *) b);
}

static void sort(os_names *names)
{
    if (names->count > 1)
        qsort(names->at, names->count, sizeof *names->at, by_bytes);
}

/* Takes over the name, or returns false: there is no memory. */
static bool add(os_names *names, char *name)
{
    if (name != NULL && (names->count & (names->count - 1)) == 0) { /* room for twice as many */
        char **grown = realloc(names->at, (names->count * 2 + 1) * sizeof *grown);
        if (grown == NULL)
            return false;
        names->at = grown;
    }
    if (name == NULL)
        return false;
    names->at[names->count++] = name;
    return true;
}

static bool add_copy(os_names *names, const wchar_t *wide)
{
    char *name = os__narrow(wide);
    if (add(names, name))
        return true;
    free(name);
    errno = ENOMEM;
    return false;
}

/* `a` and the first bytes of `b`. */
static char *concat(const char *a, const char *b, size_t length)
{
    const size_t n = strlen(a);
    char *both = malloc(n + length + 1);
    if (both == NULL)
        return NULL;
    memcpy(both, a, n);
    memcpy(both + n, b, length);
    both[n + length] = 0;
    return both;
}

bool os_list(const char *directory, os_names *names)
{
    WIN32_FIND_DATAW found;
    *names = (os_names) { 0 };
    const size_t length = strlen(directory);
    const bool open = length == 0 || directory[length - 1] == '/' || directory[length - 1] == ':';
    char *every = concat(directory, open ? "*" : "/*", open ? 1 : 2);
    wchar_t *wide = every != NULL ? os__wide_path(every) : NULL;
    free(every);
    if (wide == NULL)
        return false;
    const HANDLE search = FindFirstFileW(wide, &found);
    const DWORD error = GetLastError();
    free(wide);
    if (search == INVALID_HANDLE_VALUE) /* the root of a drive may have no file */
        return error == ERROR_FILE_NOT_FOUND || os__failed_with(error);
    bool ok = true;
    do {
        if (found.cFileName[0] != L'.') /* our own temporary files are among the others */
            ok = add_copy(names, found.cFileName);
    } while (ok && FindNextFileW(search, &found));
    if (ok && GetLastError() != ERROR_NO_MORE_FILES)
        ok = os__failed();
    FindClose(search);
    if (!ok)
        os_free_names(names);
    sort(names);
    return ok;
}

static bool has_pattern(const char *s, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        if (strchr("*?[", s[i]) != NULL)
            return true;
    }
    return false;
}

/* Adds what matches `rest` below a directory, which is "" or ends with its slash.  The first part of
 * `rest`, with the slashes after it, is `part` bytes long. */
static void expand_below(const char *directory, const char *rest, os_names *names);

static void expand_plain(const char *directory, const char *rest, size_t part, os_names *names)
{
    char *path = concat(directory, rest, part);
    if (path != NULL && rest[part] != 0)
        expand_below(path, rest + part, names);
    else if (path != NULL && os_exists(path) && add(names, path))
        return;
    free(path);
}

static void expand_pattern(const char *directory, const char *pattern, const char *rest,
                           os_names *names)
{
    os_names here;
    if (!os_list(directory, &here))
        return;
    for (size_t i = 0; i < here.count; i++) {
        char *path = os_matches(pattern, here.at[i])
                         ? concat(directory, here.at[i], strlen(here.at[i]))
                         : NULL;
        if (path != NULL && *rest != 0) {
            char *below = concat(path, "/", 1);
            if (below != NULL)
                expand_below(below, rest, names);
            free(below);
        } else if (path != NULL && add(names, path)) {
            continue;
        }
        free(path);
    }
    os_free_names(&here);
}

static void expand_below(const char *directory, const char *rest, os_names *names)
{
    const size_t length = strcspn(rest, "/"), part = length + strspn(rest + length, "/");
    if (!has_pattern(rest, length)) {
        expand_plain(directory, rest, part, names);
        return;
    }
    char *pattern = concat("", rest, length);
    if (pattern != NULL)
        expand_pattern(directory, pattern, rest + part, names);
    free(pattern);
}

bool os_expand(const char *pattern, os_names *names)
{
    *names = (os_names) { 0 };
    if (!has_pattern(pattern, strlen(pattern)))
        return false;
    const char *rest = os_after_drive(pattern);
    rest += strspn(rest, "/");
    char *start = concat("", pattern, (size_t) (rest - pattern));
    if (start != NULL)
        expand_below(start, rest, names);
    free(start);
    sort(names);
    return names->count > 0;
}
