/* SPDX-License-Identifier: MIT */
/*
 * message.c - error messages, and the strings of texts
 *
 * A message is one line of valid UTF-8, whatever the name of the file is: names come from other
 * people and end up on terminals.
 */
#include "message.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    NAME_ROOM = 256, /* of the message; a longer name loses its beginning */
    ESCAPE_SIZE = 4  /* \xHH */
};

/* The length of the UTF-8 sequence at s; 0 if it is invalid or not fit to print. */
static size_t printable(const unsigned char *s)
{
    if (s[0] < 0x80)
        return s[0] >= 0x20 && s[0] != 0x7f;
    size_t size = s[0] >= 0xf0 ? 4 : s[0] >= 0xe0 ? 3 : 2;
    if (s[0] < 0xc2 || s[0] > 0xf4)
        return 0;
    for (size_t i = 1; i < size; i++) {
        if ((s[i] & 0xc0) != 0x80)
            return 0;
    }
    const bool overlong = (s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xf0 && s[1] < 0x90);
    const bool surrogate = s[0] == 0xed && s[1] > 0x9f;
    const bool too_high = s[0] == 0xf4 && s[1] > 0x8f;
    const bool control = s[0] == 0xc2 && s[1] < 0xa0;
    return overlong || surrogate || too_high || control ? 0 : size;
}

/* Copies what fits, and never a part of a character.  Returns the bytes written. */
static size_t escape(char *dst, size_t room, const char *text)
{
    static const char hex[] = "0123456789abcdef";
    const unsigned char *s = (const unsigned char *) text;
    size_t n = 0;
    while (*s != 0) {
        size_t size = printable(s);
        if (n + (size != 0 ? size : ESCAPE_SIZE) >= room)
            break;
        if (size != 0) {
            memcpy(dst + n, s, size);
            n += size;
            s += size;
        } else {
            dst[n++] = '\\';
            if (*s == '\n') {
                dst[n++] = 'n';
            } else {
                dst[n++] = 'x';
                dst[n++] = hex[*s >> 4];
                dst[n++] = hex[*s & 15];
            }
            s++;
        }
    }
    dst[n] = 0;
    return n;
}

/* The end of a long name says more than its beginning. */
static size_t escape_name(char *dst, const char *name)
{
    const size_t size = strlen(name);
    size_t n = 0;
    if (size >= NAME_ROOM / ESCAPE_SIZE * 3) {
        const size_t keep = NAME_ROOM / ESCAPE_SIZE * 2;
        memcpy(dst, "...", 3);
        n = 3;
        name += size - keep;
        while (((unsigned char) *name & 0xc0) == 0x80)
            name++;
    }
    return n + escape(dst + n, NAME_ROOM - n, name);
}

bool ntpio__fail(ntpio_error *error, ntpio_status status, const char *name, const char *format, ...)
{
    char text[sizeof error->message];
    va_list values;
    va_start(values, format);
    vsnprintf(text, sizeof text, format, values);
    va_end(values);
    error->status = status;
    size_t n = escape_name(error->message, name);
    memcpy(error->message + n, ": ", 2);
    n += 2;
    escape(error->message + n, sizeof error->message - n, text);
    return false;
}

bool ntpio__fail_memory(ntpio_error *error, const char *name)
{
    return ntpio__fail(error, NTPIO_ERR_MEMORY, name, "out of memory");
}

char *ntpio__copy_string(const char *string, size_t size)
{
    char *copy = malloc(size + 1);
    if (copy != NULL) {
        if (size != 0)
            memcpy(copy, string, size);
        copy[size] = 0;
    }
    return copy;
}

static char *copy_or_null(const char *string, bool *failed)
{
    if (string == NULL)
        return NULL;
    char *copy = ntpio__copy_string(string, strlen(string));
    *failed = *failed || copy == NULL;
    return copy;
}

static void free_text(ntpio_text *text)
{
    free(text->key);
    free(text->value);
    free(text->language);
    free(text->translated_key);
}

bool ntpio__add_text(ntpio_info *info, const ntpio_text *text)
{
    ntpio_text *texts = realloc(info->texts, (info->text_count + 1) * sizeof *texts);
    if (texts == NULL)
        return false;
    info->texts = texts;
    bool failed = false;
    ntpio_text copy = { .key = copy_or_null(text->key, &failed),
                        .value = copy_or_null(text->value, &failed),
                        .language = copy_or_null(text->language, &failed),
                        .translated_key = copy_or_null(text->translated_key, &failed),
                        .compressed = text->compressed,
                        .itxt = text->itxt };
    if (failed) {
        free_text(&copy);
        return false;
    }
    texts[info->text_count++] = copy;
    return true;
}

void ntpio__free_texts(ntpio_info *info)
{
    for (size_t i = 0; i < info->text_count; i++)
        free_text(&info->texts[i]);
    free(info->texts);
    info->texts = NULL;
    info->text_count = 0;
}
