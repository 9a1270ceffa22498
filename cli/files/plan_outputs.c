/* SPDX-License-Identifier: MIT */
/*
 * plan_outputs.c - where each input's output goes
 *
 * What could destroy a file is refused here, before any work: two inputs with one output, and an
 * output that is one of the inputs (compared by device and inode, so by any path).  --force allows
 * that an output is its own input, but not that it is another one, which may still be unread.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "files/paths.h"
#include "os/files.h"

static bool is_directory(const char *path)
{
    os_file found;
    return os_look(path, &found) && found.kind == OS_DIRECTORY;
}

static bool is_regular(const char *path)
{
    os_file found;
    return os_look(path, &found) && found.kind == OS_REGULAR;
}

static bool ends_in(const char *path, const char *ending)
{
    return strcasecmp(name_ending(path), ending) == 0;
}

typedef enum ending { NEW_ENDING, ADDED_ENDING } ending;

/* Float images stay float where the verb keeps the depth of its input. */
static bool keeps_pfm(const options *o)
{
    return (o->verb_bit & (V_CLEAN | V_CONVERT | V_TRANSFORM | V_RESIZE)) != 0 &&
           !option_given(o, OPT_DEPTH);
}

static bool makes_pfm(const options *o)
{
    const bool relief = (o->verb_bit & V_RELIEF) != 0 && option_given(o, OPT_DEPTH);
    return ((o->verb_bit & (V_TO_HEIGHT | V_TO_DEPTH)) != 0 && option_integer(o, OPT_DEPTH) == 1) ||
           (relief && option_integer(o, OPT_DEPTH) == 2);
}

static char *below(const char *directory, const char *relative, ending how, const options *o)
{
    const bool of_floats = ends_in(relative, ".exr") && keeps_pfm(o);
    const char *made = makes_pfm(o) || of_floats ? ".pfm" : ".png";
    const bool as_it_is = ends_in(relative, made) || (ends_in(relative, ".pfm") && keeps_pfm(o));
    const size_t dropped = as_it_is || how == ADDED_ENDING ? 0 : strlen(name_ending(relative));
    text name = { 0 };
    text_bytes(&name, relative, strlen(relative) - dropped);
    if (!as_it_is)
        text_add(&name, made);
    char *path = join_path(directory, text_string(&name));
    text_free(&name);
    return path;
}

typedef struct target {
    const char *path;
    size_t index;
} target;

static int by_path(const void *a, const void *b)
{
    const target *x = a, *y = b;
    const int order = os_compare_names(x->path, y->path);
    return order != 0 ? order : (x->index > y->index) - (x->index < y->index);
}

static target *sorted_targets(const input_list *list)
{
    target *all = need(calloc(list->count + 1, sizeof *all));
    for (size_t i = 0; i < list->count; i++)
        all[i] = (target) { list->at[i].output, i };
    qsort(all, list->count, sizeof *all, by_path);
    return all;
}

/* wall.tga and wall.png would both be wall.png: the former becomes wall.tga.png. */
static void part_collisions(input_list *list, const char *directory, const options *o)
{
    target *all = sorted_targets(list);
    char **renamed = need(calloc(list->count + 1, sizeof *renamed));
    for (size_t i = 0; i < list->count; i++) {
        const bool meets_previous = i > 0 && os_compare_names(all[i].path, all[i - 1].path) == 0;
        const bool meets_next =
            i + 1 < list->count && os_compare_names(all[i].path, all[i + 1].path) == 0;
        const char *relative = list->at[all[i].index].relative;
        if ((meets_previous || meets_next) && !ends_in(relative, ".png"))
            renamed[all[i].index] = below(directory, relative, ADDED_ENDING, o);
    }
    free(all);
    for (size_t i = 0; i < list->count; i++) {
        if (renamed[i] == NULL)
            continue;
        free(list->at[i].output);
        list->at[i].output = renamed[i];
    }
    free(renamed);
}

static bool no_two_alike(const input_list *list)
{
    target *all = sorted_targets(list);
    bool ok = true;
    for (size_t i = 1; ok && i < list->count; i++) {
        if (os_compare_names(all[i].path, all[i - 1].path) != 0)
            continue;
        complain("%s and %s would both be written to %s", list->at[all[i - 1].index].path,
                 list->at[all[i].index].path, all[i].path);
        ok = false;
    }
    free(all);
    return ok;
}

typedef struct node {
    uint64_t device, number;
    size_t index; /* of the input */
} node;

static int by_node(const void *a, const void *b)
{
    const node *x = a, *y = b;
    if (x->device != y->device)
        return x->device < y->device ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

static bool refuse_input(const char *output)
{
    complain("%s is an input, and inputs are not overwritten; give another -o, or --in-place",
             output);
    return false;
}

/* Standard input may be a file, too. */
static bool look_at_input(const char *path, os_file *found)
{
    return strcmp(path, "-") == 0 ? os_look_at_open(stdin, found) : os_look(path, found);
}

static bool is_file(const char *output, os_file *found)
{
    return strcmp(output, "-") != 0 && os_look(output, found) && found->kind == OS_REGULAR;
}

/* May an output be this input?  Several names of one file stand beside each other. */
static bool may_replace(const node *found, const node *inputs, size_t count, size_t own)
{
    while (found > inputs && by_node(found - 1, found) == 0)
        found--;
    for (const node *n = found; n < inputs + count && by_node(n, found) == 0; n++) {
        if (n->index != own)
            return false;
    }
    return true;
}

static bool no_input_overwritten(const input_list *list, bool force)
{
    node *inputs = need(calloc(list->count + 1, sizeof *inputs));
    size_t count = 0;
    os_file found;
    for (size_t i = 0; i < list->count; i++) {
        if (look_at_input(list->at[i].path, &found))
            inputs[count++] = (node) { found.device, found.node, i };
    }
    qsort(inputs, count, sizeof *inputs, by_node);
    bool ok = true;
    for (size_t i = 0; ok && i < list->count; i++) {
        const char *output = list->at[i].output;
        if (!is_file(output, &found))
            continue;
        const node own = { found.device, found.node, i };
        const node *same = bsearch(&own, inputs, count, sizeof own, by_node);
        if (same != NULL && !(force && may_replace(same, inputs, count, i)))
            ok = refuse_input(output);
    }
    free(inputs);
    return ok;
}

/* The same of the images that options name, and of the second file of a verb of two. */
static bool no_second_image_overwritten(const input_list *list, const options *o)
{
    const char *const others[] = { option_string(o, OPT_MASK), option_string(o, OPT_ALPHA),
                                   option_string(o, OPT_AO),
                                   o->verb_bit == V_BLEND ? o->paths[1] : NULL };
    os_file x, y;
    for (size_t k = 0; k < sizeof others / sizeof others[0]; k++) {
        if (others[k] == NULL || !look_at_input(others[k], &x))
            continue;
        for (size_t i = 0; i < list->count; i++) {
            const char *output = list->at[i].output;
            if (is_file(output, &y) && x.device == y.device && x.node == y.node)
                return refuse_input(output);
        }
    }
    return true;
}

static bool no_image_overwritten(const input_list *list, const options *o)
{
    const bool force = option_given(o, OPT_FORCE);
    return no_input_overwritten(list, force) && (force || no_second_image_overwritten(list, o));
}

/* Does -o name a directory?  It does if it is one or ends with a slash.  It also does if its
 * name is not that of an image, and either several inputs go there or it has no ending at all. */
static bool means_directory(const input_list *list, const char *output)
{
    os_file found;
    if (strcmp(output, "-") == 0)
        return false;
    if (output[strlen(output) - 1] == '/' || is_directory(output))
        return true;
    if (os_look(output, &found) || name_is_image(output))
        return false;
    return list->from_directory || list->count > 1 || name_ending(output)[0] == 0;
}

static bool is_below(const char *path, const char *directory)
{
    const size_t length = strlen(directory);
    return strncmp(path, directory, length) == 0 &&
           (path[length] == '/' || directory[length - 1] == '/');
}

/* Where links lead from a file of a directory, if that is in none of the directories.  What is
 * named itself may be replaced, wherever it is. */
static char *way_out(const input_list *list, const input *in)
{
    char *resolved = in->named ? NULL : os_real_path(in->path);
    for (size_t i = 0; resolved != NULL && i < list->root_count; i++) {
        if (is_below(resolved, list->roots[i])) {
            free(resolved);
            resolved = NULL;
        }
    }
    return resolved;
}

static bool plan_in_place(input_list *list)
{
    for (size_t i = 0; i < list->count; i++) {
        list->at[i].outside = way_out(list, &list->at[i]);
        if (strcmp(list->at[i].path, "-") == 0) {
            complain("--in-place: standard input cannot be replaced");
            return false;
        }
        list->at[i].output = copy_string(list->at[i].path);
    }
    return true;
}

const char *unwritten_name(const ntpio_info *info)
{
    return info->format == NTPIO_JPEG                  ? "JPEG"
           : info->format == NTPIO_DDS                 ? "DDS"
           : info->format == NTPIO_KTX2                ? "KTX2"
           : info->format == NTPIO_EXR                 ? "EXR"
           : info->format == NTPIO_WEBP && info->lossy ? "WebP with loss"
                                                       : NULL;
}

/* False for JPEG and the formats of other programs: a PNG must not have such a name. */
static bool format_is_written(const char *output, const options *o)
{
    const bool texture = ends_in(output, ".dds") || ends_in(output, ".ktx2");
    if (ends_in(output, ".jpg") || ends_in(output, ".jpeg") || ends_in(output, ".jpe")) {
        complain("-o %s: JPEG damages normals and is not written; use .png", output);
        return false;
    }
    if (texture ? o->verb_bit == V_CONVERT : !name_is_foreign(output) && !ends_in(output, ".exr"))
        return true;
    if (texture) {
        complain("-o %s: only ntp convert writes DDS and KTX2; write .png, then convert it",
                 output);
        return false;
    }
    complain("-o %s: such files are not written; use .png", output);
    return false;
}

static bool plan_file(input_list *list, const options *o, const char *output)
{
    if (list->count > 1 || list->from_directory) {
        complain("-o %s is one file, but the inputs are %s; give a directory", output,
                 list->from_directory ? "those of a directory" : "several");
        return false;
    }
    if (!format_is_written(output, o))
        return false;
    if (list->count == 1)
        list->at[0].output = copy_string(output);
    return true;
}

bool outputs_plan(input_list *list, const options *o)
{
    const char *output = option_string(o, OPT_OUTPUT);
    const bool in_place = option_given(o, OPT_IN_PLACE);
    if (in_place && output != NULL) {
        complain("give -o or --in-place, not both");
        return false;
    }
    if (in_place)
        return plan_in_place(list);
    if (output == NULL) {
        if (option_given(o, OPT_DRY_RUN))
            return true;
        complain("ntp %s needs -o FILE or -o DIR%s", o->verb->name,
                 option_row(OPT_IN_PLACE, o->verb_bit) != NULL ? ", or --in-place" : "");
        return false;
    }
    if (!means_directory(list, output))
        return plan_file(list, o, output) && no_image_overwritten(list, o);
    for (size_t i = 0; i < list->count; i++) {
        const char *relative = list->at[i].relative;
        const char *name = strcmp(relative, "-") == 0 ? "stdin" : relative;
        list->at[i].output = below(output, name, NEW_ENDING, o);
    }
    part_collisions(list, output, o);
    return no_two_alike(list) && no_image_overwritten(list, o);
}

bool output_is_allowed(const char *output, const options *o)
{
    if (!format_is_written(output, o))
        return false;
    if (strcmp(output, "-") == 0 || !is_regular(output))
        return true;
    for (size_t i = 0; i < o->path_count; i++) {
        if (is_same_file(o->paths[i], output)) {
            complain("%s is an input; a picture of differences does not replace it", output);
            return false;
        }
    }
    return true;
}

bool is_same_file(const char *a, const char *b)
{
    os_file x, y;
    return os_look(a, &x) && os_look(b, &y) && x.device == y.device && x.node == y.node;
}

bool output_is_free(const input_list *list, const char *path)
{
    const bool there = is_regular(path);
    for (size_t i = 0; i < list->count; i++) {
        const char *given = list->at[i].path;
        if (os_compare_names(list->at[i].output, path) == 0 ||
            (there && strcmp(given, "-") != 0 && is_same_file(given, path)))
            return false;
    }
    return true;
}

bool make_parents(const char *path, text *why)
{
    char *copy = copy_string(path);
    bool ok = true;
    char *start = copy + (os_after_drive(copy) - copy);
    char *slash = *start != 0 ? strchr(start + 1, '/') : NULL;
    for (; ok && slash != NULL; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        if (!os_make_directory(copy) && errno != EEXIST && !is_directory(copy)) {
            text_name(why, copy);
            text_addf(why, ": cannot be made: %s", strerror(errno));
            ok = false;
        }
        *slash = '/';
    }
    free(copy);
    return ok;
}
