/* SPDX-License-Identifier: MIT */
/*
 * host.h - the jobs on GIMP's layers, for GIMP 3 and GIMP 2.10
 *
 * Layers are known by their IDs, which both have.  Nothing here shows a window.
 */
#ifndef NTP_PLUGIN_HOST_H
#define NTP_PLUGIN_HOST_H

#include "../luminance.h"
#include "normals.h"
#include "remedy.h"

#include <gegl.h>
#include <libgimp/gimp.h>

#define HOST_GIMP3 GIMP_CHECK_VERSION(2, 99, 0)

#if HOST_GIMP3
#  define HOST_DRAWABLE(ID) gimp_drawable_get_by_id(ID)
#  define HOST_LAYER(ID)    GIMP_LAYER(gimp_item_get_by_id(ID))
#  define HOST_ITEM(ID)     gimp_item_get_by_id(ID)
#else
#  define HOST_DRAWABLE(ID) (ID)
#  define HOST_LAYER(ID)    (ID)
#  define HOST_ITEM(ID)     (ID)
#endif

#define _(TEXT)  host_translate(TEXT)
#define N_(TEXT) TEXT /* translated later */

enum { HOST_TEXT = 600 }; /* room for a message */

/* The path of this program, set by main. */
extern const char *host_program;

/* The path of what is installed in the program's directory; free it. */
gchar *host_beside(const char *name);

/* Makes the translations known. */
void host_begin(void);

/* The text in the user's language. */
const char *host_translate(const char *text);

/* A layer that is open for reading, as it is shown with its effects. */
typedef struct host_layer {
    gint32 id;
    gint32 shown; /* a copy of it with its effects merged; 0: it shows no effects */
    raster raster;
    GeglBuffer *buffer;
    const Babl *format;         /* in which samples are read, and written */
    const luminance *luminance; /* made of them for the raster, or NULL */
    gboolean apart;             /* not GIMP's memory, but that of a result */
} host_layer;

void host_open(host_layer *layer, gint32 id);

/* Opens a layer for its luminance, which takes the place of red; gray is its own. */
void host_open_luminance(host_layer *layer, gint32 id);

/* Effects such as shadows can make what is shown larger than the layer. */
gboolean host_has_size_of(const host_layer *layer, gint32 id);
void host_close(host_layer *layer);

/*
 * Opens what a job writes.  If the channels are those of the layer, this is its shadow.  Otherwise,
 * and if GIMP's blending would not be exact, it is memory.  When the job is done, the layer becomes
 * RGB and gets alpha as needed, so a cancelled job changes nothing.
 */
void host_open_result(host_layer *result, const host_layer *layer, int32_t channels);

/* Writes an area of the result into the selected part of the layer, in one undo step; closes it.
 * Effects, which the result already contains, are merged into the layer. */
void host_put_result(host_layer *result, const host_layer *layer, const ntp_rect *area);

/* Why the procedure cannot work on this drawable, in the user's language; NULL: it can. */
const char *host_refusal(const procedure *p, gint32 id);

/* Does the layer show effects (GIMP 3), which are then part of what the procedures see? */
gboolean host_has_effects(gint32 id);

/* What a user should know before the procedure runs on this layer, in the user's language; empty:
 * nothing.  only_effects: nothing unless the layer shows effects. */
void host_notice(const procedure *p, gint32 id, gboolean only_effects, char notice[HOST_TEXT]);

/*
 * Would normals be made of normals?  The judgement is that of `ntp from-height`, on what is shown.
 * A single channel other than red, which is the default, is taken for a height.
 */
gboolean host_shows_normals(const settings *s, const host_layer *layer);

/* The same before the procedure runs, so that the user can be asked. */
gboolean host_must_ask(const settings *s, gint32 id);

/* Is it a layer, so that the argument counts? */
gboolean host_is_layer(gint32 id);

/* The selected part of the layer, all of it without a selection; FALSE: none of it. */
gboolean host_selection(const host_layer *layer, ntp_rect *area);

/*
 * Runs the procedure on a layer in one undo step.  Nothing is changed unless it returns TRUE.
 * message: an error or other information; empty: none.
 */
gboolean host_run(const procedure *p, const settings *s, gint32 id, char message[HOST_TEXT]);

/* The same for PROCEDURE_RESIZE, on the layer or the whole image. */
gboolean host_resize(const procedure *p, const settings *s, gint32 id, char message[HOST_TEXT]);

/* The report on a layer that must hold normals. */
job_status host_find_normals(report *found, const settings *question, const raster *layer);

/* The report on a layer.  FALSE: message says why there is none. */
gboolean host_check(const settings *s, gint32 id, report *r, char message[HOST_TEXT]);

/* Adds that a report is on the layer with its effects. */
void host_add_effects(report *r);

/* Does what the report suggests, in one undo step; else as host_run. */
gboolean host_remedy(remedy which, const findings *f, gint32 id, char message[HOST_TEXT]);

/* Threads and GIMP's progress bar. */
extern const surroundings host_surroundings;

#endif
