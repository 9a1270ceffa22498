/* SPDX-License-Identifier: MIT */
/*
 * mips.h - were the mips of a DDS or KTX2 made of whole vectors?
 */
#ifndef NTP_CLI_MIPS_H
#define NTP_CLI_MIPS_H

#include "examine/examine.h"

/* Fills f->mips of a texture of two channels that was examined.  It reads the file again, and is to
 * be the last that does.  Returns false with an error if reading fails. */
bool mips_look(source *s, facts *f, ntpio_error *error);

#endif
