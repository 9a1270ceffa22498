/* SPDX-License-Identifier: MIT */
/*
 * text.c - growing strings; see text.h
 */
#include "text/text.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "os/memory.h"
#include "text/numbers.h"

void *need(void *memory)
{
    if (memory == NULL) {
        fputs("ntp: out of memory\n", stderr);
        exit(NTP_EXIT_FAILED);
    }
    return memory;
}

void *need_aligned(size_t size)
{
    enum { LINE = 64 }; /* of a cache: no less than libntp asks for */
    return need(os_alloc_aligned(LINE, (size + LINE - 1) / LINE * LINE));
}

void free_aligned(void *memory)
{
    os_free_aligned(memory);
}

char *copy_string(const char *string)
{
    return need(strdup(string));
}

char *join_path(const char *directory, const char *name)
{
    const size_t length = strlen(directory);
    const char *slash = length > 0 && directory[length - 1] != '/' ? "/" : "";
    const size_t size = length + strlen(slash) + strlen(name) + 1;
    char *path = need(malloc(size));
    snprintf(path, size, "%s%s%s", directory, slash, name);
    return path;
}

static void reserve(text *t, size_t more)
{
    if (t->capacity - t->size > more)
        return;
    t->capacity = (t->size + more + 1) * 2;
    t->data = need(realloc(t->data, t->capacity));
}

void text_bytes(text *t, const void *bytes, size_t size)
{
    reserve(t, size);
    if (size > 0)
        memcpy(t->data + t->size, bytes, size);
    t->size += size;
    t->data[t->size] = 0;
}

void text_add(text *t, const char *string)
{
    text_bytes(t, string, strlen(string));
}

void text_char(text *t, char c)
{
    text_bytes(t, &c, 1);
}

void text_addf(text *t, const char *format, ...)
{
    va_list arguments, again;
    char first[128]; /* most pieces fit and are formatted only once */
    va_start(arguments, format);
    va_copy(again, arguments);
    const int size = vsnprintf(first, sizeof first, format, arguments);
    va_end(arguments);
    if (size > 0 && (size_t) size < sizeof first) {
        text_bytes(t, first, (size_t) size);
    } else if (size > 0) {
        reserve(t, (size_t) size);
        vsnprintf(t->data + t->size, (size_t) size + 1, format, again);
        t->size += (size_t) size;
    }
    va_end(again);
}

void text_free(text *t)
{
    free(t->data);
    *t = (text) { 0 };
}

const char *text_string(const text *t)
{
    return t->data != NULL ? t->data : "";
}

/* The shortest form only, no surrogates, at most U+10FFFF. */
size_t utf8_length(const char *s)
{
    const unsigned char *u = (const unsigned char *) s;
    if (u[0] < 0x80)
        return u[0] != 0;
    size_t length = 0;
    unsigned code = 0, least = 0;
    if (u[0] >= 0xc2 && u[0] < 0xe0)
        length = 2, code = u[0] & 0x1fU, least = 0x80;
    else if (u[0] >= 0xe0 && u[0] < 0xf0)
        length = 3, code = u[0] & 0x0fU, least = 0x800;
    else if (u[0] >= 0xf0 && u[0] < 0xf5)
        length = 4, code = u[0] & 0x07U, least = 0x10000;
    for (size_t i = 1; i < length; i++) {
        if ((u[i] & 0xc0U) != 0x80)
            return 0;
        code = code << 6 | (u[i] & 0x3fU);
    }
    const bool surrogate = code >= 0xd800 && code <= 0xdfff;
    return length > 0 && code >= least && code <= 0x10ffff && !surrogate ? length : 0;
}

bool utf8_valid(const char *s)
{
    while (*s != 0) {
        const size_t length = utf8_length(s);
        if (length == 0)
            return false;
        s += length;
    }
    return true;
}

void text_name(text *t, const char *name)
{
    while (*name != 0) {
        const unsigned char c = (unsigned char) *name;
        size_t length = utf8_length(name);
        /* C1 controls, U+0080..U+009F, move a terminal's cursor as well */
        const bool c1 = length == 2 && c == 0xc2 && (unsigned char) name[1] < 0xa0;
        if (c == '\n') {
            text_add(t, "\\n");
        } else if (length == 0 || c < 0x20 || c == 0x7f) {
            text_addf(t, "\\x%02x", c);
            length = 1;
        } else if (c1) {
            text_addf(t, "\\x%02x\\x%02x", c, (unsigned char) name[1]);
        } else {
            text_bytes(t, name, length);
        }
        name += length;
    }
}

void text_count(text *t, uint64_t count)
{
    char number[NUMBER_SIZE];
    number_count(number, count, &NUMBERS_ENGLISH);
    text_add(t, number);
}

void text_percent(text *t, uint64_t part, uint64_t whole)
{
    char number[NUMBER_SIZE];
    number_percent(number, part, whole, &NUMBERS_ENGLISH);
    text_add(t, number);
}

void text_degrees(text *t, double degrees)
{
    char number[NUMBER_SIZE];
    number_degrees(number, degrees, &NUMBERS_ENGLISH);
    text_add(t, number);
}

void text_wrap(text *t, const char *words, int column, int indent, int width)
{
    bool first = true;
    while (*words != 0) {
        if (*words == '\n') {
            text_addf(t, "\n%*s", indent, "");
            column = indent;
            first = true;
        }
        words += strspn(words, " \n");
        const size_t length = strcspn(words, " \n");
        if (length == 0)
            break;
        if (!first && column + 1 + (int) length > width) {
            text_addf(t, "\n%*s", indent, "");
            column = indent;
        } else if (!first) {
            text_char(t, ' ');
            column++;
        }
        text_bytes(t, words, length);
        column += (int) length;
        words += length;
        first = false;
    }
}

unsigned edit_distance(const char *a, const char *b)
{
    enum { LONGEST = 40 };
    const size_t m = strlen(a), n = strlen(b);
    unsigned rows[3][LONGEST + 1];
    if (m > LONGEST || n > LONGEST)
        return LONGEST;
    for (size_t j = 0; j <= n; j++)
        rows[0][j] = (unsigned) j;
    for (size_t i = 1; i <= m; i++) {
        unsigned *now = rows[i % 3];
        const unsigned *up = rows[(i - 1) % 3], *up2 = rows[(i + 1) % 3];
        now[0] = (unsigned) i;
        for (size_t j = 1; j <= n; j++) {
            unsigned least = up[j - 1] + (a[i - 1] != b[j - 1]);
            if (up[j] + 1 < least)
                least = up[j] + 1;
            if (now[j - 1] + 1 < least)
                least = now[j - 1] + 1;
            const bool exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (exchanged && up2[j - 2] + 1 < least)
                least = up2[j - 2] + 1;
            now[j] = least;
        }
    }
    return rows[m % 3][n];
}
