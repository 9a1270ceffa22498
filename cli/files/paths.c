/* SPDX-License-Identifier: MIT */
/*
 * paths.c - from the command line to a list of files
 *
 * Directories are sorted by bytes, so every machine lists them in the same order.  A directory is
 * entered once and a file taken once, however many links lead to it.
 */
#include "files/paths.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "os/files.h"

typedef struct visited {
    uint64_t device, node;
} visited;

typedef struct scan {
    input_list *list;
    const options *o;
    visited *seen;
    size_t seen_count;
} scan;

static input *add_input(input_list *list, const char *path, const char *relative)
{
    if (list->count % 64 == 0)
        list->at = need(realloc(list->at, (list->count + 64) * sizeof *list->at));
    input *in = &list->at[list->count++];
    *in = (input) { .path = copy_string(path), .relative = copy_string(relative) };
    in->hinted = name_is_normals(path);
    in->y = name_orientation(path);
    return in;
}

static bool matches_any(const option_value *globs, const char *relative)
{
    const char *slash = strrchr(relative, '/');
    const char *base = slash != NULL ? slash + 1 : relative;
    for (size_t i = 0; i < globs->count; i++) {
        const bool whole = strchr(globs->all[i], '/') != NULL;
        if (os_matches(globs->all[i], whole ? relative : base))
            return true;
    }
    return false;
}

/* Marks a directory as entered; returns false if it was entered before. */
static bool enter(scan *s, const os_file *found)
{
    for (size_t i = 0; i < s->seen_count; i++) {
        if (s->seen[i].device == found->device && s->seen[i].node == found->node)
            return false;
    }
    s->seen = need(realloc(s->seen, (s->seen_count + 1) * sizeof *s->seen));
    s->seen[s->seen_count++] = (visited) { found->device, found->node };
    return true;
}

static void add_problem(scan *s, const char *path, int error)
{
    input *in = add_input(s->list, path, path);
    in->problem = copy_string(strerror(error));
}

static void scan_directory(scan *s, const char *directory, const char *relative, int depth);

/* Of files that cannot be read, normals textures are told by name; heights are not. */
static bool is_texture_to_tell(const scan *s, const char *path)
{
    return s->o->verb_bit != V_FROM_HEIGHT && name_is_normals(path);
}

static void scan_entry(scan *s, const char *path, const char *relative, int depth)
{
    os_file found;
    if (matches_any(&s->o->values[OPT_EXCLUDE], relative))
        return;
    if (!os_look(path, &found)) {
        if (name_is_image(path))
            add_problem(s, path, errno);
        return;
    }
    const option_value *match = &s->o->values[OPT_MATCH];
    if (found.kind == OS_DIRECTORY) {
        if (option_given(s->o, OPT_RECURSIVE) && enter(s, &found))
            scan_directory(s, path, relative, depth + 1);
    } else if (found.kind == OS_REGULAR) {
        const bool foreign = name_is_foreign(path);
        if (match->count > 0 ? matches_any(match, relative)
                             : name_is_image(path) || (foreign && is_texture_to_tell(s, path)))
            add_input(s->list, path, relative)->foreign = foreign;
    }
}

static void scan_directory(scan *s, const char *directory, const char *relative, int depth)
{
    enum { DEEPEST = 512 }; /* each level holds a list open */
    os_names names = { 0 };
    if (depth >= DEEPEST || !os_list(directory, &names)) {
        add_problem(s, directory, depth < DEEPEST ? errno : ELOOP);
        return;
    }
    for (size_t i = 0; i < names.count; i++) {
        const char *name = names.at[i];
        char *path = join_path(directory, name);
        char *below = relative[0] != 0 ? join_path(relative, name) : copy_string(name);
        scan_entry(s, path, below, depth);
        free(path);
        free(below);
    }
    os_free_names(&names);
}

/* A relative path without "..", with "./" taken off; otherwise the last component. */
static const char *relative_part(const char *path, bool keep_path)
{
    while (strncmp(path, "./", 2) == 0)
        path += 2 + strspn(path + 2, "/");
    const char *slash = strrchr(path, '/');
    const bool climbs = strncmp(path, "../", 3) == 0 || strstr(path, "/../") != NULL;
    if (keep_path && !os_is_absolute(path) && !climbs)
        return path;
    return slash != NULL ? slash + 1 : os_after_drive(path);
}

static void add_root(input_list *list, const char *path)
{
    char *root = os_real_path(path);
    if (root == NULL)
        return; /* then its files cannot be reached either */
    list->roots = need(realloc(list->roots, (list->root_count + 1) * sizeof *list->roots));
    list->roots[list->root_count++] = root;
}

static bool add_path(scan *s, const char *path, bool keep_path);

/* A pattern that the shell left alone, as it does in quotes.  Returns false if no file matches. */
static bool add_matches(scan *s, const char *pattern, bool keep_path)
{
    os_names found;
    const bool any = os_expand(pattern, &found);
    for (size_t i = 0; any && i < found.count; i++)
        add_path(s, found.at[i], keep_path);
    os_free_names(&found);
    return any;
}

static bool add_path(scan *s, const char *path, bool keep_path)
{
    os_file found;
    if (path[0] == 0) {
        complain("a path is empty");
        return false;
    }
    const bool exists = strcmp(path, "-") != 0 && os_exists(path);
    if (!exists && add_matches(s, path, keep_path))
        return true;
    if (exists && os_look(path, &found) && found.kind == OS_DIRECTORY) {
        s->list->from_directory = true;
        add_root(s->list, path);
        if (enter(s, &found))
            scan_directory(s, path, "", 0);
        return true;
    }
    const bool excluded = matches_any(&s->o->values[OPT_EXCLUDE], path);
    if (!excluded)
        add_input(s->list, path, relative_part(path, keep_path))->named = true;
    return true;
}

/* Lists of Windows end their lines with "\r\n".  A file may have such a name, too. */
static ptrdiff_t without_return(char *line, ptrdiff_t length)
{
    if (length > 0 && line[length - 1] == '\r' && !os_exists(line))
        line[--length] = 0;
    return length;
}

static bool add_list(scan *s, const char *name)
{
    const bool standard = strcmp(name, "-") == 0;
    FILE *file = standard ? stdin : os_open_to_read(name, false);
    if (file == NULL) {
        complain("--files-from %s: %s", name, strerror(errno));
        return false;
    }
    const int end = option_given(s->o, OPT_NUL) ? 0 : '\n';
    char *line = NULL;
    size_t size = 0;
    bool ok = true;
    for (ptrdiff_t length; ok && (length = os_read_line(&line, &size, end, file)) > 0;) {
        if (line[length - 1] == (char) end)
            line[--length] = 0;
        if (end == '\n')
            length = without_return(line, length);
        os_take_path(line);
        if (length > 0)
            ok = add_path(s, line, true);
    }
    if (ok && ferror(file)) {
        complain("--files-from %s: %s", name, strerror(errno));
        ok = false;
    }
    free(line);
    if (!standard)
        fclose(file);
    return ok;
}

typedef struct identity {
    char *canonical;
    size_t index;
} identity;

static int by_identity(const void *a, const void *b)
{
    const identity *x = a, *y = b;
    const int order = strcmp(x->canonical, y->canonical);
    return order != 0 ? order : (x->index > y->index) - (x->index < y->index);
}

static void free_input(input *in)
{
    free(in->path);
    free(in->relative);
    free(in->output);
    free(in->outside);
    free(in->problem);
}

/* The directory of a path without links, and the name in it. */
static char *canonical_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *directory = copy_string(slash == NULL ? "." : path);
    if (slash != NULL)
        directory[slash - path + (slash == os_after_drive(path))] = 0;
    char *resolved = strcmp(path, "-") != 0 ? os_real_path(directory) : NULL;
    free(directory);
    if (resolved == NULL)
        return copy_string(path);
    char *name = join_path(resolved, slash == NULL ? path : slash + 1);
    free(resolved);
    return name;
}

/* Two inputs are one if their links lead to the same file.  But a link that is named counts as a
 * file of its own, unless both would be written. */
static char *identity_of(const input *in, bool in_place)
{
    char *resolved = in->named && !in_place ? NULL : os_real_path(in->path);
    return resolved != NULL ? resolved : canonical_name(in->path);
}

/* Of several names of one file, keeps the first. */
static void drop_duplicates(input_list *list, bool in_place)
{
    identity *all = need(calloc(list->count + 1, sizeof *all));
    for (size_t i = 0; i < list->count; i++) {
        all[i] = (identity) { identity_of(&list->at[i], in_place), i };
    }
    qsort(all, list->count, sizeof *all, by_identity);
    bool *drop = need(calloc(list->count + 1, sizeof *drop));
    size_t first = 0;
    for (size_t i = 1; i < list->count; i++) {
        if (strcmp(all[i].canonical, all[first].canonical) != 0) {
            first = i;
            continue;
        }
        drop[all[i].index] = true;
        list->at[all[first].index].named |= list->at[all[i].index].named;
    }
    size_t kept = 0;
    for (size_t i = 0; i < list->count; i++) {
        if (drop[i])
            free_input(&list->at[i]);
        else
            list->at[kept++] = list->at[i];
        free(all[i].canonical);
    }
    list->count = kept;
    free(all);
    free(drop);
}

bool inputs_collect(input_list *list, const options *o)
{
    *list = (input_list) { 0 };
    scan s = { .list = list, .o = o };
    bool ok = true;
    for (size_t i = 0; ok && i < o->path_count; i++)
        ok = add_path(&s, o->paths[i], false);
    const option_value *lists = &o->values[OPT_FILES_FROM];
    for (size_t i = 0; ok && i < lists->count; i++)
        ok = add_list(&s, lists->all[i]);
    free(s.seen);
    if (ok && o->path_count == 0 && lists->count == 0) {
        complain("ntp %s needs a file or a directory; ntp %s --help tells more", o->verb->name,
                 o->verb->name);
        ok = false;
    }
    if (ok && list->count > 1)
        drop_duplicates(list, option_given(o, OPT_IN_PLACE));
    if (ok && list->count == 0 && !option_given(o, OPT_ALLOW_EMPTY))
        complain("no image found%s", list->from_directory && !option_given(o, OPT_RECURSIVE)
                                         ? "; -r looks below the directory as well"
                                         : "");
    if (!ok)
        inputs_free(list);
    return ok;
}

bool inputs_are_two(const options *o, const char *called)
{
    if (o->path_count != 2)
        complain("ntp %s takes two files%s", o->verb->name, called);
    else if (strcmp(o->paths[0], "-") == 0 && strcmp(o->paths[1], "-") == 0)
        complain("standard input can be only one of the two");
    else
        return true;
    return false;
}

void inputs_free(input_list *list)
{
    for (size_t i = 0; i < list->count; i++)
        free_input(&list->at[i]);
    free(list->at);
    for (size_t i = 0; i < list->root_count; i++)
        free(list->roots[i]);
    free(list->roots);
    *list = (input_list) { 0 };
}
