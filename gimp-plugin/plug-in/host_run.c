/* SPDX-License-Identifier: MIT */
/*
 * host_run.c - the procedures on layers of GIMP
 *
 * Each first computes a separate result; the image changes only when this is complete.
 */
#include "classic.h"
#include "host.h"
#if HOST_GIMP3
#  include "gimp3/operation.h"
#endif

#include <stdlib.h>

/* The raster of an optional layer; NULL: there is none. */
static const raster *open_other(host_layer *other, double id)
{
    *other = (host_layer) { 0 };
    if (!host_is_layer((gint32) id))
        return NULL;
    host_open(other, (gint32) id);
    return &other->raster;
}

static int32_t result_channels(const host_layer *layer, bool needs_alpha)
{
    return layer->raster.channels % 2 == 0 || needs_alpha ? 4 : 3;
}

/* Another layer's heights, the luminance of that or of the layer, or NULL: the layer itself. */
static const raster *open_heights(host_layer *heights, normals_job *job, double id,
                                  const host_layer *layer)
{
    if (!job->luminance)
        return open_other(heights, id);
    host_open_luminance(heights, host_is_layer((gint32) id) ? (gint32) id : layer->id);
    job->how.source = NTP_HEIGHT_SOURCE_RED; /* the only channel */
    return &heights->raster;
}

static job_status run_normals(const normals_job *asked, double height_id, double alpha_id,
                              const host_layer *layer, const ntp_rect *area)
{
    normals_job given = *asked;
    const normals_job *job = &given;
    const bool needs_alpha = normals_job_needs_alpha(job, layer->raster.type);
    host_layer heights, mask, result;
    if (job->alpha == ALPHA_LAYER && !host_is_layer((gint32) alpha_id))
        return JOB_NO_LAYER;
    const raster *height = open_heights(&heights, &given, height_id, layer);
    const raster *alpha = open_other(&mask, job->alpha == ALPHA_LAYER ? alpha_id : -1);
    host_open_result(&result, layer, result_channels(layer, needs_alpha));
    const job_status status =
        normals_job_run(job, height != NULL ? height : &layer->raster, &layer->raster, alpha,
                        &result.raster, area, &host_surroundings);
    if (status == JOB_DONE)
        host_put_result(&result, layer, area);
    host_close(&result);
    host_close(&heights);
    host_close(&mask);
    return status;
}

/* from: the layer's texels, or what is to be repaired in their place. */
static job_status run_repair(const repair_job *job, const raster *from, double alpha_id,
                             const host_layer *layer, const ntp_rect *area, uint64_t *changed)
{
    host_layer mask, result;
    if (job->alpha == ALPHA_LAYER && !host_is_layer((gint32) alpha_id))
        return JOB_NO_LAYER;
    const raster *alpha = open_other(&mask, job->alpha == ALPHA_LAYER ? alpha_id : -1);
    host_open_result(&result, layer, layer->raster.channels);
    const job_status status =
        repair_job_run(job, from, alpha, &result.raster, area, &host_surroundings, changed);
    if (status == JOB_DONE && (changed == NULL || *changed > 0))
        host_put_result(&result, layer, area);
    host_close(&result);
    host_close(&mask);
    return status;
}

static job_status usable(const report *found)
{
    if (!found->judged)
        return found->type.type == NTP_CLASS_HEIGHT ? JOB_IS_HEIGHT : JOB_NO_NORMALS;
    return found->misplaced ? JOB_MISPLACED : JOB_DONE;
}

job_status host_find_normals(report *found, const settings *question, const raster *layer)
{
    const job_status status = report_run(found, question, layer, NULL, &host_surroundings);
    return status == JOB_DONE ? usable(found) : status;
}

/* ------------------------------------------------------------------------------- heights */

/* How blue stores z, detected if the settings of PROCEDURE_HEIGHT say so. */
static job_status find_encoding(const settings *s, const host_layer *layer, ntp_encoding *encoding)
{
    static report found;
    const settings question = { { 0 } };
    if (!height_finds_out(s))
        return JOB_DONE;
    const job_status status = host_find_normals(&found, &question, &layer->raster);
    if (status == JOB_DONE)
        *encoding = found.encoding;
    return status;
}

/* A new image of one 16-bit gray layer. */
static job_status show_plane(const float *plane, const host_layer *layer, double range)
{
    const gint width = layer->raster.width, height = layer->raster.height;
    char *name = g_strdup_printf(_("Height, scale %.9g"), range);
#if HOST_GIMP3
    GimpImage *image =
        gimp_image_new_with_precision(width, height, GIMP_GRAY, GIMP_PRECISION_U16_NON_LINEAR);
    GimpLayer *made =
        gimp_layer_new(image, name, width, height, GIMP_GRAY_IMAGE, 100, GIMP_LAYER_MODE_NORMAL);
    gimp_image_insert_layer(image, made, NULL, 0);
    const gint32 id = gimp_item_get_id(GIMP_ITEM(made));
#else
    const gint32 image =
        gimp_image_new_with_precision(width, height, GIMP_GRAY, GIMP_PRECISION_U16_GAMMA);
    const gint32 id =
        gimp_layer_new(image, name, width, height, GIMP_GRAY_IMAGE, 100, GIMP_LAYER_MODE_NORMAL);
    gimp_image_insert_layer(image, id, -1, 0);
#endif
    const ntp_rect all = { 0, 0, width, height };
    host_layer target, shadow;
    host_open(&target, id);
    host_open_result(&shadow, &target, target.raster.channels);
    gimp_image_undo_disable(image);
    const job_status status = height_write(plane, &target.raster, &shadow.raster, &all, false);
    if (status == JOB_DONE)
        host_put_result(&shadow, &target, &all);
    gimp_image_undo_enable(image);
    host_close(&shadow);
    host_close(&target);
    gimp_display_new(image);
    g_free(name);
    return status;
}

static job_status put_plane(const float *plane, const host_layer *layer, const ntp_rect *area,
                            bool alpha_too)
{
    host_layer result;
    host_open_result(&result, layer, layer->raster.channels);
    const job_status status = height_write(plane, &layer->raster, &result.raster, area, alpha_too);
    if (status == JOB_DONE)
        host_put_result(&result, layer, area);
    host_close(&result);
    return status;
}

static job_status run_height(const height_job *job, const raster *normals, bool new_image,
                             const host_layer *layer, const ntp_rect *area, double *range)
{
    float *plane = NULL;
    job_status status = height_job_run(job, normals, &plane, range, &host_surroundings);
    if (status == JOB_DONE)
        status =
            new_image ? show_plane(plane, layer, *range) : put_plane(plane, layer, area, false);
    free(plane);
    return status;
}

/* --------------------------------------------------------------------- the old arguments */

/* A layer that is repaired while it is read. */
typedef struct repaired {
    const raster *layer;
    const repair_job *job;
} repaired;

static bool read_repaired(void *user, int32_t y0, int32_t y1, void *rows)
{
    const repaired *from = user;
    const ntp_image view = raster_view(from->layer, rows, y1 - y0);
    return from->layer->read(from->layer->user, y0, y1, rows) &&
           repair_rows(from->job, &view, NULL) == JOB_DONE;
}

static job_status run_classic_height(const classic_job *job, const host_layer *layer,
                                     const ntp_rect *area)
{
    repaired from = { &layer->raster, &job->repair };
    raster normals = layer->raster;
    float *plane = NULL;
    double range = 0;
    normals.user = &from;
    normals.read = read_repaired;
    job_status status = height_job_run(&job->height, &normals, &plane, &range, &host_surroundings);
    if (status == JOB_DONE)
        status = put_plane(plane, layer, area, job->alpha == ALPHA_HEIGHT);
    free(plane);
    return status;
}

static job_status run_classic(const settings *s, const host_layer *layer, const ntp_rect *area)
{
    const classic_job job = classic_job_from(s, layer->raster.channels, layer->raster.type);
    switch (job.kind) {
    case CLASSIC_NORMALS:
        return run_normals(&job.normals, -1, s->value[FO_ALPHA_LAYER], layer, area);
    case CLASSIC_REPAIR:
        return run_repair(&job.repair, &layer->raster, s->value[FO_ALPHA_LAYER], layer, area, NULL);
    default:
        return run_classic_height(&job, layer, area);
    }
}

/* -------------------------------------------------------------------------------- cleaning */

/* With an accident undone first, texels change even if none is to be cleaned then. */
static job_status undo_and_clean(const settings *s, const findings *f, const host_layer *layer,
                                 const ntp_rect *area, uint64_t *changed)
{
    undone right;
    const repair_job job = repair_job_from(s, &f->undone);
    undone_open(&right, &layer->raster, f->found.accident);
    *changed = 1;
    return run_repair(&job, &right.raster, -1, layer, area, NULL);
}

/* The encoding and the method, detected if the settings say so. */
static job_status run_clean(const settings *s, const host_layer *layer, const ntp_rect *area,
                            uint64_t *changed)
{
    static findings f;
    settings question;
    const bool finds_out = repair_finds_out(s, &question);
    if (finds_out && s->value[FC_UNDO] != 0) {
        const job_status status =
            remedy_look(&f, &question, &layer->raster, NULL, &host_surroundings);
        if (status == JOB_DONE && f.undoes)
            return undo_and_clean(s, &f, layer, area, changed);
        if (status != JOB_DONE || usable(&f.found) != JOB_DONE)
            return status != JOB_DONE ? status : usable(&f.found);
    } else if (finds_out) {
        const job_status status = host_find_normals(&f.found, &question, &layer->raster);
        if (status != JOB_DONE)
            return status;
    }
    const repair_job job = repair_job_from(s, finds_out ? &f.found : NULL);
    return run_repair(&job, &layer->raster, -1, layer, area, changed);
}

void host_add_effects(report *r)
{
    g_strlcat(r->text, "\n", sizeof r->text);
    g_strlcat(r->text, _("Seen as the layer is shown, with its effects."), sizeof r->text);
}

/* Does what a script asks for: nothing, or a remedy, for which settings have one more. */
static gboolean remedy_asked(const settings *s, const findings *f, gint32 id,
                             char message[HOST_TEXT])
{
    const int asked = (int) s->value[FK_REMEDY];
    if (asked == 0)
        return TRUE;
    if (remedy_applies((remedy) (asked - 1), f))
        return host_remedy((remedy) (asked - 1), f, id, message);
    g_strlcpy(message, _("This remedy is not one for this layer. Nothing was changed."), HOST_TEXT);
    return FALSE;
}

gboolean host_check(const settings *s, gint32 id, report *r, char message[HOST_TEXT])
{
    static findings f;
    host_layer layer;
    host_open(&layer, id);
    gimp_progress_init(_("Checking normals"));
    const job_status status = remedy_look(&f, s, &layer.raster, host_translate, &host_surroundings);
    gimp_progress_end();
    if (layer.shown > 0)
        host_add_effects(&f.found);
    host_close(&layer);
    *r = f.found;
    g_strlcpy(message, status == JOB_DONE ? "" : _(job_status_text(status)), HOST_TEXT);
    return status == JOB_DONE && remedy_asked(s, &f, id, message);
}

/* --------------------------------------------------------------------------------- running */

static job_status dispatch(const procedure *p, const settings *s, const host_layer *layer,
                           const ntp_rect *area, char message[HOST_TEXT])
{
    const bool gray = layer->raster.channels < 3;
    uint64_t changed = 0;
    double range = 0;
    job_status status = JOB_WRONG;
    switch ((procedure_id) (p - procedures)) {
    case PROCEDURE_NORMALS: {
        const normals_job job = normals_job_from(s);
        if (host_shows_normals(s, layer))
            return JOB_IS_NORMALS;
#if HOST_GIMP3
        if (operation_merge(s, layer))
            return JOB_DONE;
#endif
        return run_normals(&job, s->value[FN_HEIGHT_LAYER], s->value[FN_ALPHA_LAYER], layer, area);
    }
    case PROCEDURE_HEIGHT: {
        height_job job = height_job_from(s);
        if (gray)
            return JOB_GRAY;
        status = find_encoding(s, layer, &job.encoding);
        if (status != JOB_DONE)
            return status;
        return run_height(&job, &layer->raster, s->value[FH_RESULT] != 0, layer, area, &range);
    }
    case PROCEDURE_CLEAN:
        if (gray)
            return JOB_GRAY;
        status = run_clean(s, layer, area, &changed);
        if (status == JOB_DONE && changed == 0)
            g_strlcpy(message, _("Every texel is right already. Nothing was changed."), HOST_TEXT);
        return status;
    case PROCEDURE_CLASSIC:
        if (gray && s->value[FO_CONVERSION] >= 8) /* those that start from normals */
            return JOB_GRAY;
        return run_classic(s, layer, area);
    default:
        return status;
    }
}

/* A layer to work on, and the part of it. */
typedef struct target {
    host_layer layer;
    ntp_rect area;
} target;

/* FALSE: there is nothing to do, and the message says why; *done is what host_run returns then. */
static gboolean open_target(target *t, const procedure *p, gint32 id, gboolean *done,
                            char message[HOST_TEXT])
{
    const char *refusal = host_refusal(p, id);
    *done = FALSE;
    message[0] = 0;
    if (refusal != NULL) {
        g_strlcpy(message, refusal, HOST_TEXT);
        return FALSE;
    }
    host_open(&t->layer, id);
    t->layer.raster.user = &t->layer;
    if (!host_has_size_of(&t->layer, id)) {
        host_close(&t->layer);
        g_strlcpy(message, _(job_status_text(JOB_BEYOND)), HOST_TEXT);
        return FALSE;
    }
    if (!host_selection(&t->layer, &t->area)) {
        host_close(&t->layer);
        g_strlcpy(message, _("The selection does not touch the layer. Nothing was changed."),
                  HOST_TEXT);
        *done = TRUE;
        return FALSE;
    }
    gimp_progress_init(_("Normals texture"));
    return TRUE;
}

static gboolean close_target(target *t, job_status status, char message[HOST_TEXT])
{
    gimp_progress_end();
    host_close(&t->layer);
    if (status != JOB_DONE)
        g_strlcpy(message, _(job_status_text(status)), HOST_TEXT);
    return status == JOB_DONE;
}

gboolean host_run(const procedure *p, const settings *s, gint32 id, char message[HOST_TEXT])
{
    target t;
    gboolean done = FALSE;
    message[0] = 0;
    if (p == &procedures[PROCEDURE_RESIZE])
        return host_resize(p, s, id, message);
    if (!open_target(&t, p, id, &done, message))
        return done;
    return close_target(&t, dispatch(p, s, &t.layer, &t.area, message), message);
}

gboolean host_remedy(remedy which, const findings *f, gint32 id, char message[HOST_TEXT])
{
    target t;
    undone right;
    undo_kind accident = UNDO_NOTHING;
    gboolean done = FALSE;
    uint64_t changed = 0;
    if (!open_target(&t, &procedures[PROCEDURE_CLEAN], id, &done, message))
        return done;
    const repair_job job = remedy_job(which, f, &accident);
    undone_open(&right, &t.layer.raster, accident);
    const job_status status = run_repair(&job, &right.raster, -1, &t.layer, &t.area,
                                         which == REMEDY_CLEAN ? &changed : NULL);
    if (status == JOB_DONE && which == REMEDY_CLEAN && changed == 0)
        g_strlcpy(message, _("Every texel is right already. Nothing was changed."), HOST_TEXT);
    return close_target(&t, status, message);
}
