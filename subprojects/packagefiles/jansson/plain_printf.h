/* SPDX-License-Identifier: MIT */
/* _snprintf, which jansson takes on Windows, rounds halves up, and not to even. */
#include "jansson_private.h"
#undef snprintf
#undef vsnprintf
