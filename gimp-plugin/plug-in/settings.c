/* SPDX-License-Identifier: MIT */
/*
 * settings.c - values of a procedure's fields: defaults, ranges, and settings as text
 *
 * "Save settings" and last values use the text: a line for each field, independent of the locale.
 */
#include "fields.h"

#include <locale.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void settings_reset(const procedure *p, settings *s)
{
    memset(s, 0, sizeof *s);
    for (int i = 0; i < p->count; i++)
        s->value[i] = p->fields[i].value;
}

static bool in_range(const field *f, double value)
{
    switch (f->kind) {
    case FIELD_CHOICE:
        return value >= 0 && value < choice_count(f) && value == (int) value;
    case FIELD_SWITCH:
        return value == 0 || value == 1;
    case FIELD_LAYER:
        return true;
    default:
        return value >= f->low && value <= f->high;
    }
}

static double nearest(const field *f, double value)
{
    if (f->kind == FIELD_SWITCH && value == value)
        return 1;
    if (f->kind != FIELD_NUMBER || value != value)
        return f->value;
    return value < f->low ? f->low : f->high;
}

const field *settings_check(const procedure *p, settings *s)
{
    const field *first = NULL;
    for (int i = 0; i < p->count; i++) {
        const field *f = &p->fields[i];
        if (in_range(f, s->value[i]))
            continue;
        s->value[i] = nearest(f, s->value[i]);
        if (first == NULL)
            first = f;
    }
    return first;
}

/* ------------------------------------------------------------------------------ as text */

enum { NUMBER_SIZE = 40 };

static void number_text(char text[NUMBER_SIZE], double value)
{
    int digits = 15; /* as few as reproduce the number */
    do
        snprintf(text, NUMBER_SIZE, "%.*g", digits, value);
    while (digits++ < 17 && strtod(text, NULL) != value);
    char *point = strstr(text, localeconv()->decimal_point);
    if (point != NULL)
        *point = '.';
}

static bool text_number(const char *text, double *value)
{
    char copy[NUMBER_SIZE], *end = NULL;
    if (strlen(text) >= sizeof copy)
        return false;
    strcpy(copy, text);
    char *point = strchr(copy, '.');
    if (point != NULL)
        *point = localeconv()->decimal_point[0];
    *value = strtod(copy, &end);
    return end != copy && *end == 0;
}

size_t settings_write(const procedure *p, const settings *s, char *text, size_t size)
{
    size_t length = 0;
    for (int i = 0; i < p->count; i++) {
        const field *f = &p->fields[i];
        char number[NUMBER_SIZE];
        const char *value = number;
        if (f->kind == FIELD_LAYER)
            continue;
        if (f->kind == FIELD_CHOICE)
            value = f->choices[(int) s->value[i]].name;
        else
            number_text(number, s->value[i]);
        const int more = snprintf(length < size ? text + length : NULL,
                                  length < size ? size - length : 0, "%s = %s\n", f->name, value);
        length += (size_t) more;
    }
    return length;
}

static void read_line(const procedure *p, settings *s, const char *name, const char *value)
{
    for (int i = 0; i < p->count; i++) {
        const field *f = &p->fields[i];
        double number = 0;
        if (strcmp(f->name, name) != 0 || f->kind == FIELD_LAYER)
            continue;
        if (f->kind == FIELD_CHOICE)
            number = choice_find(f, value);
        else if (!text_number(value, &number))
            return;
        if (in_range(f, number))
            s->value[i] = number;
    }
}

void settings_read(const procedure *p, settings *s, const char *text)
{
    while (*text != 0) {
        char name[64], value[64];
        if (sscanf(text, " %63[a-zA-Z-] = %63[^ \t\r\n]", name, value) == 2)
            read_line(p, s, name, value);
        text += strcspn(text, "\n");
        text += *text == '\n';
    }
}
