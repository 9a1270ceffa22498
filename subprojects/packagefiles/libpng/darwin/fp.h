/* SPDX-License-Identifier: MIT */
/* Versions of libpng before 1.6.45 look for this header of old Macs where newer headers of Apple say
 * which system it is. */
#include <math.h>
