/* SPDX-License-Identifier: MIT */
/*
 * baseline.c - findings of an earlier check, by file and id
 *
 * A file is known by its path from the working directory, spelled in one way: "./a", "b/../a" and
 * "/where/we/are/a" are "a".  Links are not followed: the file may be gone.
 */
#include "report/baseline.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "os/files.h"
#include "report/report.h"

/* The value of a base64 digit; -1: it is none. */
static int digit_value(char c)
{
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

static void add_decoded(text *t, const char *coded)
{
    unsigned bits = 0;
    int count = 0;
    for (; digit_value(*coded) >= 0; coded++) {
        bits = (bits << 6 | (unsigned) digit_value(*coded)) & 0xffff;
        count += 6;
        if (count >= 8) {
            count -= 8;
            text_char(t, (char) (bits >> count & 255));
        }
    }
}

/* Takes the last part off a path that ends in one; false: there is none but "..". */
static bool go_up(text *t)
{
    size_t start = t->size;
    while (start > 0 && t->data[start - 1] != '/')
        start--;
    const size_t length = t->size - start;
    if (length == 0 || (length == 2 && memcmp(t->data + start, "..", 2) == 0))
        return false;
    t->size = start > 1 ? start - 1 : start;
    t->data[t->size] = 0;
    return true;
}

/* Adds a path in its one spelling; t is empty. */
static void add_plain(text *t, const char *path)
{
    if (path[0] == '/')
        text_char(t, '/');
    while (*path != 0) {
        const size_t length = strcspn(path, "/");
        const bool dot = length == 1 && path[0] == '.';
        const bool up = length == 2 && memcmp(path, "..", 2) == 0;
        if (length > 0 && !dot && !(up && go_up(t))) {
            if (t->size > 0 && t->data[t->size - 1] != '/')
                text_char(t, '/');
            text_bytes(t, path, length);
        }
        path += length + (path[length] == '/');
    }
}

static void add_key(text *key, const baseline *b, const char *path, const char *id)
{
    text plain = { 0 };
    const char *here = text_string(&b->here);
    if (path[0] == '/' && path[1] != '/') /* on Windows it begins with the drive that one is on */
        text_bytes(&plain, here, (size_t) (os_after_drive(here) - here));
    add_plain(&plain, path);
    const bool inside = b->here.size > 0 && plain.size > b->here.size &&
                        memcmp(plain.data, b->here.data, b->here.size) == 0;
    json_t *named = need(json_object()); /* jansson takes UTF-8 only */
    json_set_name(named, "path", text_string(&plain) + (inside ? b->here.size : 0));
    const json_t *coded = json_object_get(named, "path_base64");
    text_addf(key, "%s%s\n%s", coded != NULL ? "base64:" : "",
              json_string_value(coded != NULL ? coded : json_object_get(named, "path")), id);
    json_decref(named);
    text_free(&plain);
}

static void keep_known(baseline *b, const json_t *file)
{
    const char *coded = json_string_value(json_object_get(file, "path_base64"));
    const char *path = json_string_value(json_object_get(file, "path"));
    text name = { 0 };
    if (coded != NULL)
        add_decoded(&name, coded);
    else
        text_add(&name, path != NULL ? path : "");
    size_t i;
    json_t *one;
    json_array_foreach(json_object_get(file, "findings"), i, one)
    {
        const char *id = json_string_value(json_object_get(one, "id"));
        text key = { 0 };
        add_key(&key, b, text_string(&name), id != NULL ? id : "");
        json_object_set_new(b->keys, text_string(&key), json_true());
        text_free(&key);
    }
    text_free(&name);
}

bool baseline_read(baseline *b, const char *name)
{
    *b = (baseline) { 0 };
    if (name == NULL)
        return true;
    json_error_t problem = { .text = "" };
    FILE *stream = os_open_to_read(name, false);
    snprintf(problem.text, sizeof problem.text, "%s", strerror(errno));
    json_t *report = stream != NULL ? json_loadf(stream, JSON_REJECT_DUPLICATES, &problem) : NULL;
    if (stream != NULL)
        fclose(stream);
    const json_t *files = json_object_get(report, "files");
    if (!json_is_array(files)) {
        complain("--baseline %s: %s", name,
                 report == NULL ? problem.text : "not a JSON report of ntp check");
        json_decref(report);
        return false;
    }
    char *here = os_current_directory();
    if (here != NULL)
        text_addf(&b->here, "%s%s", here, strcmp(here, "/") == 0 ? "" : "/");
    free(here);
    b->keys = need(json_object());
    size_t i;
    json_t *file;
    json_array_foreach(files, i, file) keep_known(b, file);
    json_decref(report);
    return true;
}

void baseline_free(baseline *b)
{
    json_decref(b->keys);
    text_free(&b->here);
}

void baseline_mark(const baseline *b, const input *in, finding_list *list)
{
    if (b->keys == NULL)
        return;
    for (size_t i = 0; i < list->count; i++) {
        text key = { 0 };
        add_key(&key, b, in->path, FINDING_TABLE[list->at[i].id].id);
        list->at[i].known = json_object_get(b->keys, text_string(&key)) != NULL;
        text_free(&key);
    }
}
