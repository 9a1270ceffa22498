/* SPDX-License-Identifier: MIT */
/*
 * refusal.h - files without normals in tangent space: which they are, and what is told
 */
#ifndef NTP_CLI_REFUSAL_H
#define NTP_CLI_REFUSAL_H

#include "examine/examine.h"

/* x and y in gray and alpha: the file does not say which is which. */
bool is_unordered_pair(const facts *f);

/* By the facts, or by the class that was forced.  any_order: an unordered pair will do. */
bool has_tangent_normals(const facts *f, bool any_order);

/* What the file is instead; and, unless `option` is NULL, how --option settles it. */
void add_refusal(text *t, const facts *f, const char *option);

#endif
