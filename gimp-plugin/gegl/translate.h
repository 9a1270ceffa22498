/* SPDX-License-Identifier: MIT */
/*
 * translate.h - texts for translators: _ now, N_ later
 *
 * As in glib/gi18n-lib.h, but without its cast, which takes const away.
 */
#ifndef NTP_GEGL_TRANSLATE_H
#define NTP_GEGL_TRANSLATE_H

#include <glib.h>
#include <libintl.h>

#define _(text)  g_dgettext(GETTEXT_PACKAGE, text)
#define N_(text) (text)

#endif
