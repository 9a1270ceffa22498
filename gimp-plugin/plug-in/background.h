/* SPDX-License-Identifier: MIT */
/*
 * background.h - long work while a window stays alive
 *
 * The work runs in a thread of its own.  It may read layers, whose tiles GIMP sends one after the
 * other, but call no other function of GIMP.
 */
#ifndef NTP_PLUGIN_BACKGROUND_H
#define NTP_PLUGIN_BACKGROUND_H

#include "raster.h"

#include <glib.h>

typedef struct background background;

/* Starts work(data, around) in a thread; its progress is kept, and stops it when it is asked to.
 * Then done(data) is called in the main loop, unless background_stop was called. */
background *background_start(void (*work)(void *data, const surroundings *around),
                             void (*done)(void *data), void *data);

/* The share done, 0 to 1. */
double background_share(background *b);

/* Asks the work to stop, waits until it does, and frees it; NULL is nothing.  Also to be called
 * when the work is done. */
void background_stop(background *b);

#endif
