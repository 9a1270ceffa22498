/* SPDX-License-Identifier: MIT */
/*
 * surface.h - what a texture tells of the surface behind it: kernel, seams, steps, how it fits
 */
#ifndef NTP_CLI_SURFACE_H
#define NTP_CLI_SURFACE_H

#include "examine/examine.h"

/*
 * Adds f->surface, for a file whose other facts are known.  s->keep_crop was set when it was
 * examined.  y: which way green is asked to point, or -1.  Textures that are not in tangent space
 * are left.  surface_look looks at the middle of the image.  surface_look_deeper reads the file once
 * more, and looks at all of it as far as memory allows; false with an error where reading fails.
 */
void surface_look(source *s, facts *f, int y);
bool surface_look_deeper(source *s, facts *f, int y, ntpio_error *error);

#endif
