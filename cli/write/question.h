/* SPDX-License-Identifier: MIT */
/*
 * question.h - what every verb that writes asks first: what is the input, and can it work on it?
 *
 * The class has to be one that the verb works on, and no accident may stand in the way, unless
 * --type says what the file is.
 */
#ifndef NTP_CLI_QUESTION_H
#define NTP_CLI_QUESTION_H

#include "write/undo.h"
#include "write/write_run.h"

typedef enum answer { ANSWER_WORK, ANSWER_UNDO, ANSWER_REFUSE } answer;

/* By the facts of the production. */
answer question(const production *p);

/* Verbs that take heights: must it be asked whether the file holds normals?  Not of gray files, and
 * not where --source or --force is given. */
bool question_is_of_heights(const production *p);
bool question_finds_normals(const facts *f);

/* Verbs that take pictures of objects, which need not look like textures: is the file surely
 * something else? */
bool question_is_no_object(const production *p);

/* Adds why the file is refused, and what to do. */
void question_refusal(text *t, const production *p);

/* The same of a further input, such as the detail of a blend.  Returns false if it is refused, and
 * adds why unless t is NULL. */
bool question_detail(text *t, const facts *f);

#endif
