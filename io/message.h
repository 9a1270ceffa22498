/* SPDX-License-Identifier: MIT */
/*
 * message.h - error messages, and the strings of texts
 */
#ifndef NTPIO_MESSAGE_H
#define NTPIO_MESSAGE_H

#include "ntpio.h"

#if defined(__GNUC__)
#  define NTPIO_PRINTF(text, values) __attribute__((format(printf, text, values)))
#else
#  define NTPIO_PRINTF(text, values)
#endif

/* Fills *error with "NAME: text"; escapes control characters and invalid UTF-8.  Returns false. */
bool ntpio__fail(ntpio_error *error, ntpio_status status, const char *name, const char *format, ...)
    NTPIO_PRINTF(4, 5);

/* The same: out of memory. */
bool ntpio__fail_memory(ntpio_error *error, const char *name);

/* A copy of `size` bytes with a 0 after them; NULL without memory. */
char *ntpio__copy_string(const char *string, size_t size);

/* Appends deep copies of the strings; NULL stays NULL. */
bool ntpio__add_text(ntpio_info *info, const ntpio_text *text);

void ntpio__free_texts(ntpio_info *info);

#endif
