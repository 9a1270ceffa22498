/* SPDX-License-Identifier: MIT */
/*
 * deep.h - what ntp check --deep finds out beside: the kernel, the seams, the fit of a surface
 */
#ifndef NTP_CLI_DEEP_H
#define NTP_CLI_DEEP_H

#include "examine.h"

/*
 * Looks at the whole texture, whose other facts are known, and adds f->deep.  y: which way green is
 * asked to point, or -1.  Reads the file once more.  False with an error where that fails; textures
 * that are too large to be held in memory, or are not in tangent space, are left.
 */
bool look_deeper(source *s, facts *f, int y, ntpio_error *error);

#endif
