/* SPDX-License-Identifier: MIT */
/*
 * exchange.h - are x and y exchanged?
 */
#ifndef NTP_CLI_EXCHANGE_H
#define NTP_CLI_EXCHANGE_H

#include "examine/examine.h"

/* Fills f->exchange of a file that was examined with s->keep_middle. */
void exchange_look(source *s, facts *f);

#endif
