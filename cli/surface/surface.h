/* SPDX-License-Identifier: MIT */
/*
 * surface.h - what a texture says about the surface behind it: kernel, seams, steps, fit
 *
 * The room of what needs heights or slopes, for `ntp check` and `ntp to-height`.
 *   surface.c           the facts that a check adds, of the middle or of all of a texture
 *   exchange.c          whether x and y are exchanged
 *   mips.c              how the mips of a DDS or KTX2 were made
 *   most_used_square.c  the part of a texture with the fewest holes
 *   height_range.c      the range that most heights lie in, and clipping to it
 *   solve_heights.c     heights on all threads of a worker; borders by the normals at the edges
 */
#ifndef NTP_CLI_SURFACE_H
#define NTP_CLI_SURFACE_H

#include "examine/examine.h"

/*
 * Fills f->surface of a file that was examined with s->keep_middle.  Textures that are not in
 * tangent space have none.  y: which way green has to point (an ntp_y), or -1. surface_look uses
 * the middle of the image.  surface_look_deeper reads the file again and uses all of it, if it fits
 * into memory; it returns false with an error if reading fails.
 */
void surface_look(source *s, facts *f, int y);
bool surface_look_deeper(source *s, facts *f, int y, ntpio_error *error);

#endif
