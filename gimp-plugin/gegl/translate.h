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
#include <string.h>

#define _(text) g_dgettext(GETTEXT_PACKAGE, text)
/* A name of choices.h, without the mark of the letter for the keyboard. */
#define LABEL(text) translate_label(_(text))
#define N_(text)    (text)

static inline const gchar *translate_label(const gchar *text)
{
    gchar *plain = g_new0(gchar, strlen(text) + 1);
    for (gsize i = 0, n = 0; text[i] != 0; i++) {
        if (text[i] != '_')
            plain[n++] = text[i];
    }
    const gchar *kept = g_intern_string(plain);
    g_free(plain);
    return kept;
}

#endif
