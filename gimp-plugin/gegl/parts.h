/* SPDX-License-Identifier: MIT */
/*
 * parts.h - work on a whole layer: shared out by GEGL, with progress
 */
#ifndef NTP_GEGL_PARTS_H
#define NTP_GEGL_PARTS_H

#include <gegl-plugin.h>

#include "libntp.h"

/* For functions of libntp that take hooks; nothing can cancel them. */
ntp_hooks parts_hooks(GeglOperation *operation);

/* Shows the share that is done, up to 1: until then GIMP takes neither clicks nor keys. */
void parts_tell(GeglOperation *operation, gdouble share);

#endif
