/* SPDX-License-Identifier: MIT */
/*
 * window.h - windows that fit the screen, at any scale of it
 */
#ifndef NTP_PLUGIN_WINDOW_H
#define NTP_PLUGIN_WINDOW_H

#include <gtk/gtk.h>

/* The child in a box that scrolls up and down where the screen has no room for it. */
GtkWidget *window_scrolled(GtkWidget *child);

/* Pixels of a screen of scale 1 on this one.  GTK 2 makes nothing larger there but text. */
int window_scaled(int pixels);

/* Opens the window as large as its widgets like to be, by so much wider, and so high that the view in
 * it, if there is one, is by so much higher than its least; but never larger than the screen. */
void window_fit(GtkWidget *window, GtkWidget *view, int wider, int higher);

#endif
