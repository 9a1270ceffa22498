/* SPDX-License-Identifier: MIT */
/*
 * confirm.c - what a user is asked after the dialog, before a procedure runs
 */
#include "confirm.h"

#include <libgimp/gimpui.h>

static gboolean says_yes(const char *question, const char *button)
{
    GtkWidget *dialog = gtk_message_dialog_new(NULL, GTK_DIALOG_MODAL, GTK_MESSAGE_QUESTION,
                                               GTK_BUTTONS_CANCEL, "%s", question);
    gtk_dialog_add_button(GTK_DIALOG(dialog), button, GTK_RESPONSE_OK);
    gtk_dialog_set_default_response(GTK_DIALOG(dialog), GTK_RESPONSE_CANCEL);
    gimp_window_set_transient(GTK_WINDOW(dialog));
    const gint answer = gtk_dialog_run(GTK_DIALOG(dialog));
    gtk_widget_destroy(dialog);
    return answer == GTK_RESPONSE_OK;
}

gboolean confirm(const procedure *p, settings *s, gint32 id)
{
    if (p != &procedures[PROCEDURE_NORMALS])
        return TRUE;
    if (host_must_ask(s, id) &&
        !says_yes(_("This shows normals already, not heights. Make normals of their colors?"),
                  _("_Make Normals")))
        return FALSE;
    s->value[FN_FORCE] = 1; /* no second look */
    return TRUE;
}
