/* SPDX-License-Identifier: MIT */
/* generate.h - texts that are made from the program's tables while it is built */
#ifndef NTP_CLI_GENERATE_H
#define NTP_CLI_GENERATE_H

#include "text/text.h"

/* "man", "bash", "zsh", "fish" or "findings"; false for another word. */
bool generate(text *t, const char *what);

#endif
