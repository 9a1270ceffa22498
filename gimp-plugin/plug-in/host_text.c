/* SPDX-License-Identifier: MIT */
/*
 * host_text.c - translations; they lie in the directory locale beside the program
 */
#include "host.h"

#include <libintl.h>

const char *host_translate(const char *text)
{
    return text[0] == 0 ? text : dgettext(GETTEXT_PACKAGE, text);
}

gchar *host_beside(const char *name)
{
    gchar *directory = g_path_get_dirname(host_program);
    gchar *path = g_build_filename(directory, name, NULL);
    g_free(directory);
    return path;
}

void host_begin(void)
{
    gchar *locale = host_beside("locale");
    bindtextdomain(GETTEXT_PACKAGE, locale);
    bind_textdomain_codeset(GETTEXT_PACKAGE, "UTF-8");
    g_free(locale);
}
