/* SPDX-License-Identifier: MIT */
/*
 * text.h - growing strings, and the ways in which names and numbers are shown
 *
 * The room of strings and output.  Every other room uses it.
 *   text.c      growing strings; names, counts, shares and angles for people; memory or the end
 *   numbers.c   counts, shares and angles; the GIMP plug-in has it, too
 *   terminal.c  standard output, standard error, the progress bar (declared in cli.h)
 *
 * Workers build results in memory, and one thread prints them: their order never depends on --jobs.
 * The program ends when there is no memory for a message.
 */
#ifndef NTP_CLI_TEXT_H
#define NTP_CLI_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__) && !defined(__clang__) /* its plain printf is that of the system */
#  define TEXT_FORMAT(string, first) __attribute__((format(gnu_printf, string, first)))
#elif defined(__clang__)
#  define TEXT_FORMAT(string, first) __attribute__((format(printf, string, first)))
#else
#  define TEXT_FORMAT(string, first)
#endif

typedef struct text {
    char *data; /* NULL while empty; otherwise ends in a 0 that size does not count */
    size_t size, capacity;
} text;

void text_bytes(text *t, const void *bytes, size_t size);
void text_add(text *t, const char *string);
void text_addf(text *t, const char *format, ...) TEXT_FORMAT(2, 3);
void text_char(text *t, char c);
void text_free(text *t);
const char *text_string(const text *t);

/* A name for people: control characters and bytes that are not UTF-8 become \n or \x1b. */
void text_name(text *t, const char *name);

/* 1234567 as 1,234,567. */
void text_count(text *t, uint64_t count);

/* part of whole in percent: "12.3 %".  It has enough digits to differ from 0 and 100. */
void text_percent(text *t, uint64_t part, uint64_t whole);

/* An angle for people: 0.38, 6.7, 44. */
void text_degrees(text *t, double degrees);

/* Words wrapped at `width`.  The first line starts at `column`, the others are indented by
 * `indent`. */
void text_wrap(text *t, const char *words, int column, int indent, int width);

/* The length of the UTF-8 sequence at s, or 0 if there is none.  s ends with a 0. */
size_t utf8_length(const char *s);
bool utf8_valid(const char *s);

/* How many letters were typed wrong, left out, added or exchanged, at least. */
unsigned edit_distance(const char *a, const char *b);

/* Memory or the end of the program; need_aligned: at 64 bytes, for free_aligned. */
void *need(void *memory);
void *need_aligned(size_t size);
void free_aligned(void *memory);
char *copy_string(const char *string);
char *join_path(const char *directory, const char *name);

#endif
