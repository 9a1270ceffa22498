/* SPDX-License-Identifier: MIT */
/*
 * green.h - which way green points, for verbs whose result depends on it
 *
 * What --y says holds.  Else the texels decide, where they are as sure as `ntp check` has to be,
 * and the name of the file does not say the opposite.  Else the file is refused with a question.
 */
#ifndef NTP_CLI_GREEN_H
#define NTP_CLI_GREEN_H

#include <jansson.h>

#include "examine/examine.h"
#include "options/options.h"

typedef enum green_by {
    GREEN_BY_OPTION,
    GREEN_BY_TEXELS,
    GREEN_UNNEEDED,     /* the result is the same for up and down */
    GREEN_BY_CONVENTION /* nothing tells; the verb has a convention */
} green_by;

typedef struct green {
    ntp_y y; /* up if unneeded */
    green_by by;
    double confidence; /* 1 by option, 0 if unneeded or by convention */
} green;

/* What an option says: -1 for auto, else an ntp_y. */
int green_told(const options *o, option_id id);

/* Is green known?  told: -1, or the ntp_y of the option.  Returns false if the texels are not
 * sure. */
bool green_find(green *g, int told, const facts *f);

/* Lets examine() find out what the functions below ask for, from the rows that a check samples. */
void green_seek(source *s);

/* The same for verbs whose convention is up: that holds where neither the texels nor the name say
 * down. */
bool green_find_or_up(green *g, int told, const facts *f);

/* Measures which way green points in an image in memory, from the rows that a check samples. */
void green_measure(facts *f, const ntp_const_image *src, uint32_t touch_unused);

/* Adds why green is not known, and how to say it: option is "--y" or "--detail-y". */
void green_ask(text *t, const facts *f, const char *option);

/* Adds "green points down (91 % sure)" where the texels said so, or that a convention was taken;
 * else nothing. */
void green_tell(text *line, const char *separator, const char *whose, const green *g);

/* Sets `key` ("y"), `key`_by and `key`_confidence. */
void green_report(json_t *object, const char *key, const green *g);

#endif
