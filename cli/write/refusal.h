/* SPDX-License-Identifier: MIT */
/*
 * refusal.h - which files are refused: those without normals in tangent space
 */
#ifndef NTP_CLI_REFUSAL_H
#define NTP_CLI_REFUSAL_H

#include "examine/examine.h"

/* Gray and alpha are x and y, but it is not known which is which. */
bool is_unordered_pair(const facts *f);

/* Does the file have such normals, by its facts or by the forced class?  any_order: an unordered
 * pair is enough. */
bool has_tangent_normals(const facts *f, bool any_order);

/* Adds what the file is instead and, unless `option` is NULL, which value of it makes it
 * accepted. */
void add_refusal(text *t, const facts *f, const char *option);

#endif
