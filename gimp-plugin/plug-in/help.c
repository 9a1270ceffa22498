/* SPDX-License-Identifier: MIT */
/*
 * help.c - opens the help page in the user's web browser
 */
#include "help.h"
#include "host.h"

#include <gio/gio.h>

void show_help(const char *id, void *data)
{
    gchar *page = host_beside("help/index.html");
    gchar *uri = g_filename_to_uri(page, NULL, NULL);
    GError *error = NULL;
    (void) id;
    (void) data;
    if (uri == NULL || !g_app_info_launch_default_for_uri(uri, NULL, &error))
        g_message(_("The help is in %s."), page);
    g_clear_error(&error);
    g_free(uri);
    g_free(page);
}
