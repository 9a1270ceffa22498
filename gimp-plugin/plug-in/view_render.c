/* SPDX-License-Identifier: MIT */
/*
 * view_render.c - the pixels of the preview widget
 *
 * Only visible texels are computed, when the program is idle: first few of them for each pixel, so
 * that a slider can be dragged, and when nothing changes any more all.
 */
#include "view_render.h"
#include "repair.h"

enum {
    SLICE = 30000, /* microseconds to show rows in full, so that the window stays alive */
    FEW = 2,       /* texels on each axis that a pixel shows while something changes */
    PATIENCE = 150 /* milliseconds without a change until all texels are shown */
};

/* Translated where the list is made. */
#define N_(TEXT) TEXT
const view_zoom view_zooms[VIEW_ZOOMS] = {
    { 0, N_("Fit") }, { 1, "1:1" }, { 2, "2:1" }, { 4, "4:1" }, { 8, "8:1" }
};

/* ------------------------------------------------------------------------------ geometry */

/* The pixels of a picture, or of one of the four tiles in it. */
static void room(const view *v, int *width, int *height)
{
    GtkAllocation size;
    gtk_widget_get_allocation(v->areas[MAP], &size);
    const int parts = view_is_on(v->tile) ? 2 : 1;
    *width = MAX(size.width, 2) * view_density(v) / parts;
    *height = MAX(size.height, 2) * view_density(v) / parts;
}

static void fit(view *v)
{
    const double width = v->layer.raster.width, height = v->layer.raster.height;
    int most_width, most_height;
    room(v, &most_width, &most_height);
    const double whole = MIN(most_width / width, most_height / height);
    const double chosen = view_is_on(v->tile) ? 0 : view_zooms[v->zoom].zoom * view_density(v);
    const double zoom = chosen > 0 ? chosen : whole;
    v->step = 1 / zoom;
    v->width = CLAMP((int) (width * zoom + 0.5), 1, most_width);
    v->height = CLAMP((int) (height * zoom + 0.5), 1, most_height);
    const double half_width = v->width * v->step / 2, half_height = v->height * v->step / 2;
    v->x = width > 2 * half_width ? CLAMP(v->x, half_width, width - half_width) : width / 2;
    v->y = height > 2 * half_height ? CLAMP(v->y, half_height, height - half_height) : height / 2;
}

/* ---------------------------------------------------------------------------- rendering */

/* Another layer's heights, the luminance of that or of the layer, or NULL: the layer itself. */
static const raster *other_heights(view *v)
{
    const gboolean normals = v->procedure == &procedures[PROCEDURE_NORMALS];
    const gint32 id = normals ? (gint32) v->settings.value[FN_HEIGHT_LAYER] : -1;
    const gboolean light = normals && normals_job_from(&v->settings).luminance;
    if (id != v->heights_id || light != v->luminance) {
        host_close(&v->heights);
        v->heights_id = id;
        v->luminance = light;
        v->scale.known = false;
        preview_heights_forget(&v->smoothed);
        if (light)
            host_open_luminance(&v->heights, host_is_layer(id) ? id : v->layer.id);
        else if (host_is_layer(id))
            host_open(&v->heights, id);
    }
    return v->heights.buffer != NULL ? &v->heights.raster : NULL;
}

static gboolean same_settings(const settings *a, const settings *b)
{
    for (int i = 0; i < MAX_FIELDS; i++) {
        if (a->value[i] != b->value[i])
            return FALSE;
    }
    return TRUE;
}

static void look_at(void *data, const surroundings *around)
{
    view *v = data;
    if (report_run(&v->found, &v->question, &v->seen.raster, NULL, around) != JOB_DONE)
        v->found.judged = false;
}

static void stop_looking(view *v)
{
    background_stop(v->looking);
    if (v->looking != NULL)
        host_close(&v->seen);
    v->looking = NULL;
}

static void on_looked(void *data)
{
    view *v = data;
    stop_looking(v);
    v->looked = LOOKED;
    view_render_soon(v);
}

/* Detects what the settings leave open, as cleaning will; again when they change.  NULL: they leave
 * nothing open, or it is not known yet. */
static const report *look(view *v)
{
    settings question;
    if (v->procedure == &procedures[PROCEDURE_CHECK])
        return v->findings != NULL ? &v->findings->found : NULL;
    if (v->procedure != &procedures[PROCEDURE_CLEAN] || v->layer.raster.channels < 3 ||
        !repair_finds_out(&v->settings, &question)) {
        stop_looking(v);
        v->looked = NOT_LOOKED;
        return NULL;
    }
    if (v->looked == NOT_LOOKED || !same_settings(&question, &v->question)) {
        stop_looking(v);
        v->looked = LOOKS;
        v->question = question;
        host_open(&v->seen, v->layer.id);
        v->seen.raster.user = &v->seen;
        v->looking = background_start(look_at, on_looked, v);
    }
    return v->looked == LOOKED ? &v->found : NULL;
}

static void say(const view *v, job_status status)
{
    const gboolean measured = v->procedure == &procedures[PROCEDURE_NORMALS] &&
                              v->settings.value[FN_SCALE] == 0 && v->scale.value > 0;
    gchar *found = measured ? g_strdup_printf(_("Scale from the layer: %g"), v->scale.value)
                            : g_strdup(v->looked == LOOKS ? _("Looking at the layer...") : "");
    gtk_label_set_text(GTK_LABEL(v->note), status == JOB_DONE ? found : _(job_status_text(status)));
    g_free(found);
}

/* The remedy that is shown, and which way green points after it. */
static const repair_job *shown_remedy(view *v, undo_kind *accident, ntp_y *green)
{
    *accident = UNDO_NOTHING;
    if (v->findings == NULL)
        return NULL;
    *green = remedy_green(v->remedy, v->findings);
    if (v->remedy == (remedy) REMEDIES || !remedy_applies(v->remedy, v->findings))
        return NULL;
    v->repair = remedy_job(v->remedy, v->findings, accident);
    return &v->repair;
}

/* The rows of pixels first .. end - 1.  most: texels that a pixel shows on each axis; 0: all. */
static job_status render_rows(view *v, int first, int end, int most)
{
    surroundings around = host_surroundings;
    around.progress = NULL;
    preview p = { .procedure = v->procedure,
                  .settings = &v->settings,
                  .layer = &v->layer.raster,
                  .heights = other_heights(v),
                  .found = look(v),
                  .waiting = v->looked == LOOKS,
                  .width = v->width,
                  .height = v->height,
                  .x = v->x - v->width * v->step / 2,
                  .y = v->y - v->height * v->step / 2,
                  .step = v->step,
                  .first = first,
                  .end = end,
                  .most = most,
                  .light = &v->light,
                  .scale = &v->scale,
                  .smoothed = &v->smoothed,
                  .around = &around };
    p.repair = shown_remedy(v, &p.accident, &p.green);
    if (v->procedure == &procedures[PROCEDURE_CLEAN] && v->settings.value[FC_UNDO] != 0 &&
        p.found != NULL && undone_is_possible(p.found->accident, p.layer))
        p.accident = p.found->accident;
    job_status status =
        preview_render(&p, v->map, v->lit, view_is_on(v->compare) ? v->before : NULL);
    if (status == JOB_DONE && v->areas[HEAT] != NULL && p.found != NULL && p.found->judged)
        status = preview_heatmap(&p, v->palette, v->heat);
    for (int i = 0; i < AREAS; i++) {
        if (v->areas[i] != NULL)
            gtk_widget_queue_draw(v->areas[i]);
    }
    return status;
}

/* Room for the pictures; they stay until they are painted over, if their size does. */
static void make_room(view *v)
{
    fit(v);
    const gsize size = (gsize) v->width * (gsize) v->height * 3;
    uint8_t **const pictures[] = { &v->map, &v->lit, &v->before, &v->heat };
    const gboolean fits = v->size == size;
    for (gsize i = 0; i < G_N_ELEMENTS(pictures) && !fits; i++) {
        g_free(*pictures[i]);
        *pictures[i] = g_malloc0(size);
    }
    v->size = size;
}

/* Some more rows, as many as a moment allows.  Heights depend on all rows. */
static gboolean refine(gpointer data)
{
    view *v = data;
    const gboolean whole = v->procedure == &procedures[PROCEDURE_HEIGHT];
    const int end = whole ? v->height : MIN(v->row + v->rows, v->height);
    const gint64 began = g_get_monotonic_time();
    say(v, render_rows(v, v->row, end, v->most));
    const gint64 taken = g_get_monotonic_time() - began;
    v->rows = (int) CLAMP(v->rows * (double) SLICE / (double) MAX(taken, 1), 1, 2 * v->rows + 1);
    v->row = end;
    v->refining = end < v->height ? g_idle_add(refine, v) : 0;
    if (end == v->height && v->most > 0 && v->step > v->most) {
        v->row = v->most = 0;
        v->rows = 1;
        v->refining = g_timeout_add(PATIENCE, refine, v);
    }
    return FALSE;
}

/* First few texels for each pixel.  Where a slider may be dragged, at once, for it would begin again
 * and again at the top. */
static gboolean render_idle(gpointer data)
{
    view *v = data;
    v->pending = 0;
    make_room(v);
    v->row = 0;
    v->rows = v->procedure == &procedures[PROCEDURE_CHECK] ? 1 : v->height;
    v->most = FEW;
    refine(v);
    return FALSE;
}

void view_render_soon(view *v)
{
    if (v->refining != 0)
        g_source_remove(v->refining);
    v->refining = 0;
    if (v->pending == 0)
        v->pending = g_idle_add(render_idle, v);
}

void view_render_stop(view *v)
{
    if (v->pending != 0)
        g_source_remove(v->pending);
    if (v->refining != 0)
        g_source_remove(v->refining);
    stop_looking(v);
}
